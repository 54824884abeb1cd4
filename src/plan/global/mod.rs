//! Global planners: a task becomes a path. Most search the planning grid and answer with its cells.
//!
//! One file per planner, each with its `Params` and `ENTRY`; a new planner is one new file and one
//! line in the registry below. The search core that they share is in `search`.

mod search;

pub use search::{CornerRule, Heuristic};

use super::contract::{Entry, Fit, GlobalPlanner};
use crate::settings::registry;

/// Behaviour of the parameters of a global planner.
pub trait GlobalKind {
    /// A fresh planner.
    fn build(&self) -> Box<dyn GlobalPlanner>;

    /// Whether the parameters fit this map and robot.
    ///
    /// # Errors
    /// A message that says what does not fit.
    fn check(&self, _: &Fit<'_>) -> Result<(), String> {
        Ok(())
    }
}

registry! {
    /// A global planner with its parameters.
    pub enum GlobalChoice: "global planner", Entry, dyn GlobalKind {
        dijkstra,
        a_star,
        jps,
        theta_star,
        improved_dijkstra,
        lpa_star,
        d_star,
        d_star_lite,
        bfs,
        dfs,
        imp_a_star,
        enhanced_a_star,
        blend_a_star,
        ssa_star,
        atan_a_star,
        pf_aco,
    }
}

impl GlobalChoice {
    /// A fresh planner.
    pub fn build(&self) -> Box<dyn GlobalPlanner> {
        self.kind().build()
    }
}
