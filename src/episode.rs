//! One episode: the tick loop. The only place where planners and the world meet.

mod outcome;

use crate::clock::Stopwatch;
use crate::geometry::{Pose, Vec2};
use crate::observation::{Belief, SensedObstacle};
use crate::plan::contract::{Decision, Failure, Randomness, Situation, StateKind};
use crate::plan::stack::Stack;
use crate::robot::Robot;
use crate::settings::quantity::{NonNegative, Positive};
use crate::trace::{Detail, MoverState, PlannedPath, Tick, Trace};
use crate::world::{Conditions, Scene, World};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::panic::{AssertUnwindSafe, catch_unwind};

pub use crate::world::DT_S;
pub use outcome::{Outcome, Parts};

/// When an episode ends (scenario key `termination`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TerminationSpec {
    /// Distance of the robot's centre from the goal that counts as arrived, m; default 0.25.
    pub goal_tolerance_m: NonNegative,
    /// Time-out as a multiple of the time that the straight line takes at the highest speed; default 10.
    pub timeout_factor: Positive,
    /// Time-out, s; replaces the multiple where given.
    #[schemars(example = 300.0)]
    pub timeout_s: Option<Positive>,
    /// The robot is stuck when it stays within this distance of where it was, m, …; default 0.3.
    pub stuck_radius_m: Positive,
    /// … for this long, s, while no path is being planned; default 30, longer than any planned wait.
    pub stuck_after_s: Positive,
}

impl Default for TerminationSpec {
    fn default() -> Self {
        Self {
            goal_tolerance_m: NonNegative::new(0.25),
            timeout_factor: Positive::new(10.0),
            timeout_s: None,
            stuck_radius_m: Positive::new(0.3),
            stuck_after_s: Positive::new(30.0),
        }
    }
}

impl TerminationSpec {
    /// The tick at which the episode times out: at least 1, at most a day of simulated time.
    pub fn tick_max(&self, scene: &Scene, robot: &Robot, dt_s: f64) -> u32 {
        const DAY_S: f64 = 86_400.0;
        let straight_m = (scene.goal - scene.start.position).norm();
        let timeout_s =
            self.timeout_s.map_or(self.timeout_factor.get() * straight_m / robot.speed_max_mps, Positive::get);
        ((timeout_s / dt_s).ceil().clamp(1.0, DAY_S / dt_s)) as u32
    }

    /// Whether the robot is at its goal.
    fn is_reached(&self, world: &World<'_>) -> bool {
        (world.goal() - world.pose().position).norm() <= self.goal_tolerance_m.get()
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
}

impl Runner {
    /// A runner that records what is sensed and believed as well ([`Record::detail`]).
    pub fn in_full() -> Self {
        Self { records_in_full: true, ..Self::default() }
    }

    /// Drives the robot through a scene with `stack` until the episode ends. A panic in a planner
    /// is an outcome; the stack must then be dropped, for its state is undefined.
    pub fn run(&mut self, setting: Setting<'_>, stack: &mut Stack) -> Outcome {
        self.record.begin(setting.scene, self.records_in_full);
        let episode = AssertUnwindSafe(|| self.drive(setting, stack));
        let outcome = catch_unwind(episode).unwrap_or_else(|panic| {
            let message = panic
                .downcast_ref::<&str>()
                .map(|text| (*text).to_owned())
                .or_else(|| panic.downcast_ref::<String>().cloned())
                .unwrap_or_else(|| "a panic without a message".to_owned());
            Outcome::PlannerError { message }
        });
        match (outcome, stack.acting()) {
            (Outcome::PlannerError { message }, Some(part)) => {
                Outcome::PlannerError { message: format!("{}: {message}", part.name()) }
            }
            (outcome, _) => outcome,
        }
    }

    fn drive(&mut self, setting: Setting<'_>, stack: &mut Stack) -> Outcome {
        let Setting { scene, robot, conditions, termination } = setting;
        let Self { sensed, belief, record, .. } = self;
        let clock = Stopwatch::start();
        let mut world = World::new(scene, robot, conditions);
        let (grid, field) = (&scene.map.grid, &scene.map.field);
        let belief = belief.get_or_insert_with(|| Belief::new(grid, field));
        belief.begin(grid, field);
        record.trace.note_names = stack.local_entry().notes;
        record.timings.world_s = clock.elapsed_s();

        let dt_s = conditions.control_period_s.get();
        let mut stuck = StuckWatch::new(scene.start.position, termination, dt_s);
        for tick in 0..termination.tick_max(scene, robot, dt_s) {
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
                scan: world.scan(),
                goal: world.goal(),
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
            let clock = Stopwatch::start();
            let step = world.step(decision.command);
            record.timings.physics_s += clock.elapsed_s();
            record.push(&world, stack, tick + 1, believed, decision, step.clearance_low_m, sensed.len());

            if let Some(contact) = step.contact {
                return Outcome::Collision { with: contact.with, at_rest: contact.at_rest };
            }
            if termination.is_reached(&world) {
                return Outcome::Success;
            }
            if stuck.is_stuck(world.pose().position, tick + 1, stack.is_waiting()) {
                return Outcome::Stuck;
            }
        }
        Outcome::Timeout
    }
}

/// Watches whether the robot makes progress.
struct StuckWatch {
    /// Position and tick at which it last counted as moving.
    anchor: (Vec2, u32),
    radius_m: f64,
    ticks: u32,
}

impl StuckWatch {
    fn new(start: Vec2, termination: &TerminationSpec, dt_s: f64) -> Self {
        let ticks = (termination.stuck_after_s.get() / dt_s).ceil() as u32;
        Self { anchor: (start, 0), radius_m: termination.stuck_radius_m.get(), ticks }
    }

    /// Whether the robot has stayed where it was for too long by `tick`; a robot that waits on purpose or for its path is not stuck.
    fn is_stuck(&mut self, position: Vec2, tick: u32, is_waiting: bool) -> bool {
        if is_waiting || (position - self.anchor.0).norm() > self.radius_m {
            self.anchor = (position, tick);
        }
        tick - self.anchor.1 >= self.ticks
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
        self.trace.movers.extend(world.movers().iter().map(|mover| MoverState {
            position: mover.position,
            velocity: mover.velocity,
            present: mover.present,
        }));
    }
}
