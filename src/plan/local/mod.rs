//! Local planners: an observation and the guidance of the global path become a twist.
//!
//! One file per planner, each with its `Params` and `ENTRY`; a new planner is one new file and one
//! line in the registry below. The shared dynamic window is in `window`.

use super::Entry;
use crate::choice::choice;
use crate::geometry::{Path, Twist, Vec2};
use crate::math;
use crate::observation::Observation;
use crate::robot::Robot;

pub mod window;

macro_rules! registry {
    ($($module:ident),+ $(,)?) => {
        $(pub mod $module;)+

        choice! {
            /// A local planner with its parameters.
            pub enum LocalChoice: "local planner" { $($module),+ }
        }

        impl LocalChoice {
            /// A fresh planner.
            pub fn build(&self) -> Box<dyn LocalPlanner> {
                match self { $(Self::$module(params) => Box::new($module::Planner::new(params))),+ }
            }

            /// What the registry says of each planner, in the order of [`Self::NAMES`].
            pub const ENTRIES: &'static [Entry] = &[$($module::ENTRY),+];
        }
    };
}

registry! {
    dwa,
    pure_pursuit,
}

/// What the global layer tells the local one.
#[derive(Clone, Copy, Debug)]
pub struct Guidance<'a> {
    /// The path in force, grid frame; a stand-alone local planner gets the straight line to the goal.
    pub path: &'a Path,
    /// Arc length of the point of `path` nearest to the robot's progress, m; never decreases on one path.
    pub progress_m: f64,
    /// The key node before the current sub-goal (the path's start at first).
    pub previous_node: Vec2,
    /// The key node to steer for.
    pub sub_goal: Vec2,
    /// Whether `sub_goal` is the last one, the goal.
    pub is_last: bool,
    /// Increases by one whenever a new path comes into force.
    pub path_revision: u32,
}

/// What a local planner is doing; a column of the trace.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Following or optimising as usual.
    #[default]
    Track,
    /// No admissible command existed: braking or turning on the spot.
    Recover,
}

impl Mode {
    /// The name in traces.
    pub fn name(self) -> &'static str {
        match self {
            Self::Track => "track",
            Self::Recover => "recover",
        }
    }
}

/// The answer of a local planner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// What to drive.
    pub command: Twist,
    /// What the planner is doing.
    pub mode: Mode,
    /// Candidate trajectories simulated for this decision.
    pub rollouts: u64,
}

/// Turns an observation and the guidance of a path into a command, once per tick.
///
/// A planner may keep workspaces and, between [`reset`](Self::reset)s, its own state of the episode;
/// its answer may depend on nothing else. It never reads a clock.
pub trait LocalPlanner: Send {
    /// The command for this tick.
    fn decide(&mut self, observation: &Observation<'_>, guidance: &Guidance<'_>) -> Decision;

    /// Forgets everything: called before each episode.
    fn reset(&mut self) {}
}

/// The yaw rate, rad/s, with which to turn by `bearing` rad on the spot: as fast as the drive may, but able to stop at the
/// bearing and not past it within the tick.
fn turn_on_the_spot(bearing: f64, robot: &Robot, dt_s: f64) -> f64 {
    let stoppable = (2.0 * robot.yaw_acceleration_radps2 * bearing.abs()).sqrt();
    let rate = math::min(robot.yaw_rate_max_radps, math::min(stoppable, bearing.abs() / dt_s));
    if bearing < 0.0 { -rate } else { rate }
}
