//! Rules for sub-goals: which point of the path the local planner steers for. One file per rule.

use super::route::Route;
use crate::geometry::Vec2;
use crate::plan::PlanningGrid;
use crate::settings::{Entry, registry};

/// Behaviour of a rule for sub-goals.
pub trait SubGoalRule {
    /// Advances progress and sub-goal of `route` for a robot at `position`. `grid` is that of the last plan; `None` for a local
    /// planner alone.
    fn advance(&self, route: &mut Route, position: Vec2, grid: Option<&PlanningGrid>);
}

registry! {
    /// Which point of the path is the sub-goal.
    pub enum SubGoals: "rule for sub-goals", Entry, dyn SubGoalRule { lookahead, key_nodes }
}

impl Default for SubGoals {
    fn default() -> Self {
        Self::lookahead(lookahead::Params::default())
    }
}
