//! Global planners: a start cell and a goal cell become a sequence of cells.
//!
//! One file per planner, each with its `Params` and `ENTRY`; a new planner is one new file and one
//! line in the registry below. What they share is in `search`.

mod search;

pub use search::{CornerRule, Heuristic};

use super::{Entry, PlanningGrid};
use crate::map::Cell;
use crate::settings::choice::choice;

/// Generates the modules, the choice and the table from one list of names.
macro_rules! registry {
    ($($module:ident),+ $(,)?) => {
        $(pub mod $module;)+

        choice! {
            /// A global planner with its parameters.
            pub enum GlobalChoice: "global planner" { $($module = $module::ENTRY.summary),+ }
        }

        impl GlobalChoice {
            /// A fresh planner.
            pub fn build(&self) -> Box<dyn GlobalPlanner> {
                match self { $(Self::$module(params) => Box::new($module::Planner::new(params))),+ }
            }

            /// What the registry says of each planner, in the order of [`Self::NAMES`].
            pub const ENTRIES: &'static [Entry] = &[$($module::ENTRY),+];
        }
    };
}

registry! {
    dijkstra,
    a_star,
    jps,
    theta_star,
    improved_dijkstra,
    lpa_star,
    bfs,
    dfs,
    imp_a_star,
}

/// One question to a global planner.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// Where the robot's centre may be.
    pub grid: &'a PlanningGrid,
    /// Where to start.
    pub start: Cell,
    /// Where to go.
    pub goal: Cell,
}

impl Problem<'_> {
    /// Whether start and goal are passable.
    ///
    /// # Errors
    /// [`PlanFailure::StartOccupied`] before [`PlanFailure::GoalOccupied`].
    pub fn check_ends(&self) -> Result<(), PlanFailure> {
        if !self.grid.is_passable(self.start) {
            Err(PlanFailure::StartOccupied)
        } else if !self.grid.is_passable(self.goal) {
            Err(PlanFailure::GoalOccupied)
        } else {
            Ok(())
        }
    }
}

/// Why there is no path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanFailure {
    /// The start cell is blocked or outside.
    #[error("the start is occupied")]
    StartOccupied,
    /// The goal cell is blocked or outside.
    #[error("the goal is occupied")]
    GoalOccupied,
    /// Start and goal are not connected.
    #[error("no path exists")]
    NoPath,
}

/// What a search did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Search {
    /// Whether a path was found.
    pub result: Result<(), PlanFailure>,
    /// Nodes popped and expanded, re-expansions included; the goal that ends the search is not expanded.
    pub expanded: u64,
    /// Nodes pushed, the start and every cheaper connection included.
    pub generated: u64,
}

/// Turns a start cell and a goal cell into a path of cells.
///
/// A planner may keep workspaces and, between [`reset`](Self::reset)s, what it learnt in earlier
/// calls of the same episode; its answer may depend on nothing else. It never reads a clock.
pub trait GlobalPlanner: Send {
    /// Finds a path. On success `path` holds its vertices from start to goal, both included (once if
    /// they are equal); consecutive ones are neighbours, or for an any-angle planner in sight of
    /// each other. On failure `path` is empty.
    fn plan(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search;

    /// Forgets everything learnt: called before each episode.
    fn reset(&mut self) {}
}
