//! One episode: the tick loop. The only place where planners and the world meet.

mod outcome;

use crate::clock::Stopwatch;
use crate::geometry::{Pose, Twist, Vec2};
use crate::guard::guard;
use crate::math;
use crate::observation::{Belief, SensedObstacle};
use crate::plan::contract::{Arrival, Decision, Failure, Randomness, Situation, State, StateKind};
use crate::plan::stack::Stack;
use crate::robot::Robot;
use crate::settings::quantity::{NonNegative, Positive};
use crate::trace::{Detail, MoverState, PlannedPath, Tick, Trace, to_nanosecond};
use crate::world::{Conditions, Contact, Scene, SensingSpec, World};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::world::DT_S;
pub use outcome::{Outcome, Parts};

/// When an episode ends (scenario key `termination`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TerminationSpec {
    /// Distance of the robot's centre from the goal that counts as arrived, m; default 0.25.
    pub goal_tolerance_m: NonNegative,
    /// Whether it is enough to come that near; default `pass`.
    pub arrive: Arrive,
    /// Where the goal has a heading: how far the robot's may differ from it where it has to stand, rad; default 0.1.
    pub heading_tolerance_rad: Positive,
    /// Time-out as a multiple of the time that the shortest way takes at the highest speed and half a turn at the highest yaw rate;
    /// default 10. The shortest way is the column `shortest_m`; where that is empty, the grid's on the known map, from goal to goal
    /// of the script; the straight line where there is none.
    pub timeout_factor: Positive,
    /// Time-out, s; replaces the multiple where given.
    #[schemars(example = 300.0)]
    pub timeout_s: Option<Positive>,
    /// The robot is stuck when it stays within this distance of where it was, m, …; default 0.3.
    pub stuck_radius_m: Positive,
    /// … for this long, s, while no path is being planned and the local planner does not say that it waits; default 30, longer than
    /// any planned wait.
    pub stuck_after_s: Positive,
    /// Whether time counts in which the robot turns at 0.9 of its highest yaw rate or faster; default false: it makes progress, but
    /// by no more than one full turn on one spot.
    pub stuck_while_turning: bool,
    /// Whether time counts in which the robot stands before a mover: one that it senses touches the next 2 m of its path, as wide as
    /// the robot. Default false: it waits. An episode that waits to its end is a `timeout`.
    pub stuck_behind_movers: bool,
}

/// How the robot has to arrive at its goal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Arrive {
    /// It comes within the tolerance, at any speed.
    #[default]
    Pass,
    /// It stands there, below 0.05 m/s and 0.1 rad/s, and has the goal's heading if that has one. Within the tolerance the stack
    /// takes over from the local planner: it brakes, then turns on the spot.
    Stand,
}

impl Default for TerminationSpec {
    fn default() -> Self {
        Self {
            goal_tolerance_m: NonNegative::new(0.25),
            arrive: Arrive::default(),
            heading_tolerance_rad: Positive::new(0.1),
            timeout_factor: Positive::new(10.0),
            timeout_s: None,
            stuck_radius_m: Positive::new(0.3),
            stuck_after_s: Positive::new(30.0),
            stuck_while_turning: false,
            stuck_behind_movers: false,
        }
    }
}

impl TerminationSpec {
    /// The tick at which the episode times out, for a shortest way of `way_m`: at least 1, at most a day of simulated time.
    pub fn tick_max(&self, way_m: f64, robot: &Robot, dt_s: f64) -> u32 {
        const DAY_S: f64 = 86_400.0;
        let way_s = way_m / robot.speed_max_mps + math::PI / robot.yaw_rate_max_radps;
        let timeout_s = self.timeout_s.map_or(self.timeout_factor.get() * way_s, Positive::get);
        ((timeout_s / dt_s).ceil().clamp(1.0, DAY_S / dt_s)) as u32
    }

    /// What counts as arrived at the goal in force.
    fn arrival(&self, world: &World<'_>) -> Arrival {
        Arrival {
            tolerance_m: self.goal_tolerance_m.get(),
            must_stand: self.arrive == Arrive::Stand,
            heading_rad: world.goal_heading_rad(),
            heading_tolerance_rad: self.heading_tolerance_rad.get(),
        }
    }

    /// Whether the robot has arrived.
    fn is_reached(&self, world: &World<'_>) -> bool {
        self.arrival(world).is_met(world.goal(), world.pose(), world.twist())
    }
}

/// Wall time that an episode took; for `timings.csv` alone.
#[derive(Clone, Debug, Default)]
pub struct Timings {
    /// Building the live world, s.
    pub world_s: f64,
    /// The global layer, s.
    pub global_s: f64,
    /// Each decision of the local planner, s.
    pub local_s: Vec<f64>,
    /// Moving and judging, s.
    pub physics_s: f64,
}

/// Runs episodes one after the other, reusing its memory; nothing else carries over.
#[derive(Debug, Default)]
pub struct Runner {
    sensed: Vec<SensedObstacle>,
    belief: Option<Belief>,
    /// Whether what is sensed and believed is recorded as well.
    records_in_full: bool,
    /// The last episode.
    pub record: Record,
}

/// Trace and timings of an episode.
#[derive(Debug, Default)]
pub struct Record {
    /// Trace of the drive.
    pub trace: Trace,
    /// Sensed obstacles and beliefs, if they are recorded.
    pub detail: Option<Detail>,
    /// Wall times of the episode.
    pub timings: Timings,
}

/// An episode recorded in full: all that pictures, reports and bags are made from.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The world in which the robot drove.
    pub scene: Scene,
    /// The robot.
    pub robot: Robot,
    /// Control period, s.
    pub dt_s: f64,
    /// Distance from the goal that counts as arrived, m.
    pub goal_tolerance_m: f64,
    /// What the robot senses with.
    pub sensing: SensingSpec,
    /// Outcome of the episode.
    pub outcome: Outcome,
    /// Trace of the drive: among others the paths with the tick at which each came into force, the scans, states and notes.
    pub trace: Trace,
    /// Sensed obstacles and beliefs.
    pub detail: Detail,
}

/// Setting of an episode: its world, robot, conditions and rules of termination.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// The world.
    pub scene: &'a Scene,
    /// The robot.
    pub robot: &'a Robot,
    /// Seed, sensing, localisation and actuation.
    pub conditions: &'a Conditions,
    /// Conditions under which the episode ends.
    pub termination: &'a TerminationSpec,
    /// Length of the shortest way from start to goal, by which the time-out goes, m; `None` takes the straight line.
    pub way_m: Option<f64>,
}

impl Runner {
    /// A runner that records what is sensed and believed as well ([`Record::detail`]).
    pub fn in_full() -> Self {
        Self { records_in_full: true, ..Self::default() }
    }

    /// Drives the robot through a scene with `stack` until the episode ends. A panic is an outcome, in a planner or in our own
    /// code; the stack, for the latter the runner as well, must then be dropped, for its state is undefined.
    pub fn run(&mut self, setting: Setting<'_>, stack: &mut Stack) -> Outcome {
        self.record.begin(setting.scene, self.records_in_full);
        let outcome = guard(|| self.drive(setting, stack)).unwrap_or_else(|panic| {
            let message = panic.to_string();
            match stack.acting() {
                Some(_) => Outcome::PlannerError { message },
                None => Outcome::InternalError { message },
            }
        });
        match (outcome, stack.acting()) {
            (Outcome::PlannerError { message }, Some(part)) => {
                Outcome::PlannerError { message: format!("{}: {message}", part.name()) }
            }
            (outcome, _) => outcome,
        }
    }

    fn drive(&mut self, setting: Setting<'_>, stack: &mut Stack) -> Outcome {
        let Setting { scene, robot, conditions, termination, way_m } = setting;
        let Self { sensed, belief, record, .. } = self;
        let clock = Stopwatch::start();
        let mut world = World::new(scene, robot, conditions);
        let (grid, field) = (&scene.map.grid, &scene.map.field);
        let belief = belief.get_or_insert_with(|| Belief::new(grid, field));
        belief.begin(grid, field);
        record.trace.note_names = stack.local_entry().notes;
        record.timings.world_s = clock.elapsed_s();

        let dt_s = conditions.control_period_s.get();
        let way_m = way_m.unwrap_or_else(|| (scene.goal - scene.start.position).norm());
        let mut stuck = StuckWatch::new(scene.start.position, termination, robot, dt_s);
        for tick in 0..termination.tick_max(way_m, robot, dt_s) {
            world.sense(belief, sensed);
            record.note_senses(tick, &world, belief, sensed);
            let situation = Situation {
                tick,
                dt_s,
                pose: world.believed_pose(),
                twist: world.odometry(),
                robot,
                belief,
                obstacles: sensed,
                remembered: world.remembered(),
                scan: world.scan(),
                goal: world.goal(),
                arrival: termination.arrival(&world),
                random: Randomness::new(conditions.seed, tick),
                budget: stack.budget(),
            };
            if tick == 0 {
                let planned = stack.begin(&situation);
                record.note_effort(stack);
                record.note_path(tick, stack);
                record.push_start(&world, stack, sensed.len());
                match planned {
                    Err(Failure::Fault(message)) => return Outcome::PlannerError { message },
                    // What the script has put upon the robot hits it: no planner had a say.
                    Err(_) if world.is_in_contact() => {
                        let step = world.step(Twist::ZERO);
                        let (believed, sensed) = (world.believed_pose(), sensed.len());
                        record.push(&world, stack, 1, believed, Decision::STAND, step.clearance_low_m, sensed);
                        return step.contact.map_or(Outcome::Timeout, |contact| record.collision(contact));
                    }
                    Err(failure) => return Outcome::NoPath { message: failure.to_string() },
                    Ok(()) => {}
                }
                if termination.is_reached(&world) {
                    return Outcome::Success;
                }
            }

            let (clock, global_before_s) = (Stopwatch::start(), stack.global_s());
            let decision = match stack.decide(&situation) {
                Ok(decision) => decision,
                Err(failure) => return Outcome::PlannerError { message: failure.to_string() },
            };
            record.timings.local_s.push(clock.elapsed_s() - (stack.global_s() - global_before_s));
            record.note_effort(stack);
            record.note_path(tick, stack);
            record.trace.rollouts += decision.rollouts;
            record.trace.recoveries += u32::from(decision.state.kind == StateKind::Recovering);

            let believed = situation.pose;
            let is_held = stuck.looks_for_movers() && stack.is_held(&situation);
            let clock = Stopwatch::start();
            let step = world.step(decision.command);
            record.timings.physics_s += clock.elapsed_s();
            record.push(&world, stack, tick + 1, believed, decision, step.clearance_low_m, sensed.len());

            if let Some(contact) = step.contact {
                return record.collision(contact);
            }
            if termination.is_reached(&world) {
                return Outcome::Success;
            }
            if stuck.is_stuck(world.pose().position, world.odometry(), stack.is_waiting(), is_held) {
                return Outcome::Stuck;
            }
        }
        Outcome::Timeout
    }
}

/// The trace of a world without its robot, whose place in it is the start, for `ticks` ticks.
pub fn watch(scene: &Scene, robot: &Robot, conditions: &Conditions, ticks: u32) -> Trace {
    let mut world = World::new(scene, robot, conditions);
    let mut trace = Trace::default();
    trace.clear(scene.movers.len());
    for tick in 0..=ticks {
        trace.ticks.push(Tick {
            tick,
            pose: world.pose(),
            believed: world.believed_pose(),
            twist: Twist::ZERO,
            command: Twist::ZERO,
            state: State::TRACK,
            sub_goal: world.goal(),
            clearance_m: world.clearance_m(),
            clearance_low_m: world.clearance_m(),
            path_deviation_m: None,
            sensed_movers: 0,
            seen_statics: 0,
        });
        trace.movers.extend(world.movers().iter().map(MoverState::of));
        world.pass();
    }
    trace
}

/// Share of the highest yaw rate from which a robot counts as turning as fast as it can.
const FULL_TURN_SHARE: f64 = 0.9;

/// Watches whether the robot makes progress.
struct StuckWatch<'a> {
    termination: &'a TerminationSpec,
    dt_s: f64,
    /// Ticks after which the robot is stuck.
    ticks: u32,
    /// Yaw rate from which it turns as fast as it can, rad/s.
    full_turn_radps: f64,
    /// Position at which it last counted as moving, and how many ticks have counted since.
    anchor: Vec2,
    counted: u32,
    /// Angle that it has turned there as fast as it can, rad.
    turned_rad: f64,
}

impl<'a> StuckWatch<'a> {
    fn new(start: Vec2, termination: &'a TerminationSpec, robot: &Robot, dt_s: f64) -> Self {
        let ticks = (termination.stuck_after_s.get() / dt_s).ceil() as u32;
        let fastest = robot.within_wheel_limits(Twist { v: 0.0, omega: robot.yaw_rate_max_radps });
        let full_turn_radps = FULL_TURN_SHARE * fastest.omega;
        Self { termination, dt_s, ticks, full_turn_radps, anchor: start, counted: 0, turned_rad: 0.0 }
    }

    /// Whether it matters if the robot stands before a mover.
    fn looks_for_movers(&self) -> bool {
        !self.termination.stuck_behind_movers
    }

    /// Whether the robot has stayed where it was for too long after one more tick. A robot that waits on purpose or for its path is
    /// not stuck; time in which it is held by a mover or turns as fast as it can does not count.
    fn is_stuck(&mut self, position: Vec2, wheels: Twist, is_waiting: bool, is_held: bool) -> bool {
        if is_waiting || (position - self.anchor).norm() > self.termination.stuck_radius_m.get() {
            (self.anchor, self.counted, self.turned_rad) = (position, 0, 0.0);
            return false;
        }
        let turns = !self.termination.stuck_while_turning
            && wheels.omega.abs() >= self.full_turn_radps
            && self.turned_rad < math::TAU;
        if turns {
            self.turned_rad += wheels.omega.abs() * self.dt_s;
        }
        self.counted += u32::from(!turns && !is_held);
        self.counted >= self.ticks
    }
}

impl Record {
    fn begin(&mut self, scene: &Scene, in_full: bool) {
        self.trace.clear(scene.movers.len());
        self.detail = in_full.then(Detail::default);
        let mut local_s = core::mem::take(&mut self.timings.local_s);
        local_s.clear();
        self.timings = Timings { local_s, ..Timings::default() };
    }

    /// The outcome of a contact, whose moment ends the trace.
    fn collision(&mut self, contact: Contact) -> Outcome {
        self.trace.contact_s = Some(to_nanosecond(contact.time_s));
        Outcome::Collision { with: contact.with, at_rest: contact.at_rest }
    }

    fn note_senses(&mut self, tick: u32, world: &World<'_>, belief: &Belief, sensed: &[SensedObstacle]) {
        if let Some(scan) = world.scan() {
            self.trace.ray_count = scan.ranges_m.len();
            self.trace.ranges_m.extend_from_slice(scan.ranges_m);
        }
        if let Some(detail) = &mut self.detail {
            detail.note(tick, belief, sensed);
        }
    }

    fn note_effort(&mut self, stack: &Stack) {
        let effort = stack.effort();
        self.trace.expanded = effort.expanded;
        self.trace.generated = effort.generated;
        self.trace.replans = effort.replans;
        self.timings.global_s = stack.global_s();
    }

    fn note_path(&mut self, tick: u32, stack: &Stack) {
        if stack.path_revision() as usize > self.trace.paths.len() {
            self.trace.paths.push(PlannedPath { tick, path: stack.path().clone() });
        }
    }

    /// The row before the first tick.
    fn push_start(&mut self, world: &World<'_>, stack: &Stack, sensed: usize) {
        self.push(world, stack, 0, world.believed_pose(), Decision::STAND, world.clearance_m(), sensed);
    }

    #[expect(clippy::too_many_arguments, reason = "a row of the trace, from all who know of it")]
    fn push(
        &mut self,
        world: &World<'_>,
        stack: &Stack,
        tick: u32,
        believed: Pose,
        decision: Decision,
        clearance_low_m: f64,
        sensed: usize,
    ) {
        let pose = world.pose();
        let has_path = stack.path_revision() > 0;
        self.trace.closest = world.closest();
        self.trace.ticks.push(Tick {
            tick,
            pose,
            believed,
            twist: world.twist(),
            command: decision.command,
            state: decision.state,
            sub_goal: if has_path { stack.sub_goal() } else { pose.position },
            clearance_m: world.clearance_m(),
            clearance_low_m,
            path_deviation_m: has_path.then(|| stack.path().project(pose.position).1),
            sensed_movers: sensed as u32,
            seen_statics: world.seen_statics(),
        });
        if !self.trace.note_names.is_empty() {
            self.trace.notes.push(decision.notes);
        }
        self.trace.movers.extend(world.movers().iter().map(MoverState::of));
    }
}
