//! One episode: the tick loop. The only place where planners and the world meet.

use crate::quantity::{NonNegative, Positive};
use crate::world::ObstacleKind;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Control period, s: the world's only time step. Time is `tick * DT_S`.
pub const DT_S: f64 = 0.1;

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
    pub timeout_s: Option<Positive>,
    /// The robot is stuck when it stays within this distance of where it was, m, …; default 0.3.
    pub stuck_radius_m: Positive,
    /// … for this long, s; default 30, longer than any planned wait.
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
