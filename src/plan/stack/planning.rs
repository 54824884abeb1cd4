//! The scenario key `planning`: how paths are planned and followed.

use super::movers::Movers;
use super::replan::Replan;
use super::sub_goal::SubGoals;
use crate::plan::contract::Budget;
use crate::settings::quantity::{Count, NonNegative, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How paths are planned and followed (scenario key `planning`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PlanningSpec {
    /// Distance that planned paths and the way to the sub-goal keep from obstacle squares, m, as far as start and goal
    /// leave it: cells' centres, first and last leg, lines of sight (a diagonal step past a corner may dip below it where
    /// the planner's corner rule allows one). The robot's radius and 0.05 m where absent: a path at exactly the radius touches, and no local planner can
    /// follow it. The papers plan with 0 and clearance rules of their own.
    pub inflation_m: Option<NonNegative>,
    /// Which point of the path the local planner steers for; default `lookahead`.
    pub sub_goals: SubGoals,
    /// When stacks plan again that do not say so themselves; default `when_blocked`.
    pub replan: Replan,
    /// What sensed movers are to the global planner; default `ignore`.
    pub movers: Movers,
    /// A mover that was slower than this, m/s, … (default 0.05; 0: no mover ever is)
    pub standing_mps: NonNegative,
    /// … for this long, s (default 2), stands: the cells that it touches are blocked on the map on which paths are planned, where
    /// there is a way round, until it is seen to move or to be gone. Local planners go by its outline.
    pub standing_after_s: Positive,
    /// Simulated time that planning takes; by default none.
    pub compute: ComputeSpec,
    /// How much work one answer of a planner may take; by default without limits.
    pub budget: BudgetSpec,
}

impl Default for PlanningSpec {
    fn default() -> Self {
        Self {
            inflation_m: None,
            sub_goals: SubGoals::default(),
            replan: Replan::default(),
            movers: Movers::default(),
            standing_mps: NonNegative::new(0.05),
            standing_after_s: Positive::new(2.0),
            compute: ComputeSpec::default(),
            budget: BudgetSpec::default(),
        }
    }
}

/// Default margin between planned paths and obstacles beyond the robot's radius, m.
const PLANNING_MARGIN_M: f64 = 0.05;

impl PlanningSpec {
    /// The inflation of the planning grid for a robot of radius `radius_m`, m.
    pub fn inflation_m(&self, radius_m: f64) -> f64 {
        self.inflation_m.map_or(radius_m + PLANNING_MARGIN_M, NonNegative::get)
    }
}

/// Simulated time that planning takes, a model and never a clock: the same on every machine.
///
/// A request made at tick k that costs c seconds is answered at tick k + ⌈c / dt⌉, from what was observed at tick k. Until
/// then the last path and the last command stay in force (at first there is none: the robot stands), and the layer that is
/// busy is asked nothing new. What costs nothing is answered at once. Path stages are not charged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ComputeSpec {
    /// Charged for each node that the global planner expands, s; default 0.
    pub per_expansion_s: NonNegative,
    /// Charged for each pose of each trajectory that the local planner simulates, s; default 0.
    pub per_rollout_point_s: NonNegative,
}

impl Default for ComputeSpec {
    fn default() -> Self {
        Self { per_expansion_s: NonNegative::new(0.0), per_rollout_point_s: NonNegative::new(0.0) }
    }
}

/// How much work one answer of a planner may take, in counts: the same on every machine. A first path that takes more ends the
/// episode as `no_path`, a later one leaves the old path in force, a decision that takes more is a `planner_error`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BudgetSpec {
    /// Nodes that the global planner may expand for one path. Default: any number.
    pub expansions: Option<Count>,
    /// Poses that the local planner may simulate for one decision. Default: any number.
    pub rollout_points: Option<Count>,
}

impl BudgetSpec {
    /// The budget in numbers.
    pub fn budget(&self) -> Budget {
        let limit = |count: Option<Count>| count.map_or(u64::MAX, |count| u64::from(count.get()));
        Budget { expansions: limit(self.expansions), rollout_points: limit(self.rollout_points) }
    }
}
