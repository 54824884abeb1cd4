//! One episode: the tick loop. The only place where planners and the world meet.

use crate::world::ObstacleKind;

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
