//! One episode: the tick loop. The only place where planners and the world meet.

use crate::clock::Stopwatch;
use crate::geometry::Pose;
use crate::observation::{Belief, Observation, SensedObstacle};
use crate::plan::local::{Decision, Mode};
use crate::plan::stack::Stack;
use crate::robot::Robot;
use crate::settings::quantity::{NonNegative, Positive};
use crate::trace::{MoverState, PlannedPath, Tick, Trace};
use crate::world::{Conditions, ObstacleKind, Scene, World};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::panic::{AssertUnwindSafe, catch_unwind};

pub use crate::world::DT_S;

/// How an episode ended. Failure to reach the goal is a result, never an error.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// Within the goal tolerance, without contact, before the time-out.
    Success,
    /// First contact.
    Collision {
        /// With what.
        with: ObstacleKind,
        /// Whether the robot stood still when it was hit.
        at_rest: bool,
    },
    /// The time-out came first.
    Timeout,
    /// Too little progress for too long.
    Stuck,
    /// The global planner found no path at the start.
    NoPath {
        /// What the planner said.
        message: String,
    },
    /// A panic, a value that is not a number, or an endless loop in a planner, caught.
    PlannerError {
        /// What it said.
        message: String,
    },
    /// No feasible world was found within the bound of the generator; left out of rates.
    InfeasibleWorld {
        /// What could not be placed.
        message: String,
    },
}

impl Outcome {
    /// All names, in the order in which summaries count them.
    pub const NAMES: [&'static str; 7] =
        ["success", "collision", "timeout", "stuck", "no_path", "planner_error", "infeasible_world"];

    /// The name in results.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Success => "success",
            Self::Collision { .. } => "collision",
            Self::Timeout => "timeout",
            Self::Stuck => "stuck",
            Self::NoPath { .. } => "no_path",
            Self::PlannerError { .. } => "planner_error",
            Self::InfeasibleWorld { .. } => "infeasible_world",
        }
    }

    /// What went wrong, in words; empty where the name says it all.
    pub fn message(&self) -> &str {
        match self {
            Self::NoPath { message } | Self::PlannerError { message } | Self::InfeasibleWorld { message } => message,
            _ => "",
        }
    }
}

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
    pub fn tick_max(&self, scene: &Scene, robot: &Robot) -> u32 {
        const DAY_S: f64 = 86_400.0;
        let straight_m = (scene.goal - scene.start.position).norm();
        let timeout_s =
            self.timeout_s.map_or(self.timeout_factor.get() * straight_m / robot.speed_max_mps, Positive::get);
        ((timeout_s / DT_S).ceil().clamp(1.0, DAY_S / DT_S)) as u32
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
    /// The last episode.
    pub record: Record,
}

/// What is known of an episode afterwards.
#[derive(Debug, Default)]
pub struct Record {
    /// What happened.
    pub trace: Trace,
    /// How long it took.
    pub timings: Timings,
}

impl Runner {
    /// Drives the robot through `scene` with `stack` until the episode ends. A panic in a planner
    /// is an outcome; the stack must then be dropped, for its state is undefined.
    pub fn run(
        &mut self,
        scene: &Scene,
        robot: &Robot,
        conditions: &Conditions,
        termination: &TerminationSpec,
        stack: &mut Stack,
    ) -> Outcome {
        self.record.begin(scene);
        let episode = AssertUnwindSafe(|| self.drive(scene, robot, conditions, termination, stack));
        catch_unwind(episode).unwrap_or_else(|panic| {
            let message = panic
                .downcast_ref::<&str>()
                .map(|text| (*text).to_owned())
                .or_else(|| panic.downcast_ref::<String>().cloned())
                .unwrap_or_else(|| "a panic without a message".to_owned());
            Outcome::PlannerError { message }
        })
    }

    fn drive(
        &mut self,
        scene: &Scene,
        robot: &Robot,
        conditions: &Conditions,
        termination: &TerminationSpec,
        stack: &mut Stack,
    ) -> Outcome {
        let Self { sensed, belief, record } = self;
        let clock = Stopwatch::start();
        let mut world = World::new(scene, robot, conditions);
        let (grid, field) = (&scene.map.grid, &scene.map.field);
        let belief = belief.get_or_insert_with(|| Belief::new(grid, field));
        belief.begin(grid, field);
        record.timings.world_s = clock.elapsed_s();

        let tick_max = termination.tick_max(scene, robot);
        let goal_tolerance_m = termination.goal_tolerance_m.get();
        let stuck_ticks = (termination.stuck_after_s.get() / DT_S).ceil() as u32;
        let mut anchor = (scene.start.position, 0u32);

        for tick in 0..tick_max {
            world.sense(belief, sensed);
            if let Some(scan) = world.scan() {
                record.trace.ray_count = scan.ranges_m.len();
                record.trace.ranges_m.extend_from_slice(scan.ranges_m);
            }
            let observation = Observation {
                tick,
                dt_s: DT_S,
                pose: world.believed_pose(),
                twist: world.odometry(),
                belief,
                obstacles: sensed,
                scan: world.scan(),
                goal: world.goal(),
                robot,
            };
            if tick == 0 {
                let planned = stack.begin(&observation);
                record.note_effort(stack);
                record.note_path(tick, stack);
                record.push_start(&world, stack, sensed.len());
                if let Err(failure) = planned {
                    return Outcome::NoPath { message: failure.to_string() };
                }
                if (world.goal() - scene.start.position).norm() <= goal_tolerance_m {
                    return Outcome::Success;
                }
            }

            let (clock, global_before_s) = (Stopwatch::start(), stack.global_s());
            let decision = stack.decide(&observation);
            record.timings.local_s.push(clock.elapsed_s() - (stack.global_s() - global_before_s));
            assert!(
                decision.command.v.is_finite() && decision.command.omega.is_finite(),
                "the local planner asked for a twist that is not finite: {:?}",
                decision.command
            );
            record.note_effort(stack);
            record.note_path(tick, stack);
            record.trace.rollouts += decision.rollouts;
            record.trace.recoveries += u32::from(decision.mode == Mode::Recover);

            let believed = observation.pose;
            let clock = Stopwatch::start();
            let step = world.step(decision.command);
            record.timings.physics_s += clock.elapsed_s();
            record.push(&world, stack, tick + 1, believed, decision, step.clearance_low_m, sensed.len());

            if let Some(contact) = step.contact {
                return Outcome::Collision { with: contact.with, at_rest: contact.at_rest };
            }
            let position = world.pose().position;
            if (world.goal() - position).norm() <= goal_tolerance_m {
                return Outcome::Success;
            }
            // A robot that waits for its path is not stuck.
            if stack.is_planning() || (position - anchor.0).norm() > termination.stuck_radius_m.get() {
                anchor = (position, tick + 1);
            } else if tick + 1 - anchor.1 >= stuck_ticks {
                return Outcome::Stuck;
            }
        }
        Outcome::Timeout
    }
}

impl Record {
    fn begin(&mut self, scene: &Scene) {
        self.trace.clear(scene.movers.len());
        let mut local_s = core::mem::take(&mut self.timings.local_s);
        local_s.clear();
        self.timings = Timings { local_s, ..Timings::default() };
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
            mode: decision.mode,
            sub_goal: if has_path { stack.sub_goal() } else { pose.position },
            clearance_m: world.clearance_m(),
            clearance_low_m,
            path_deviation_m: has_path.then(|| stack.path().project(pose.position).1),
            sensed_movers: sensed as u32,
            seen_statics: world.seen_statics(),
        });
        self.trace.movers.extend(world.movers().iter().map(|mover| MoverState {
            position: mover.position,
            velocity: mover.velocity,
            present: mover.present,
        }));
    }
}
