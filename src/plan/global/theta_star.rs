//! `theta_star`: A* whose paths may bend anywhere. A node is connected to the parent of the node it
//! is reached from where the two see each other, and so cuts the corner between.
//!
//! Source: A. Nash, K. Daniel, S. Koenig, A. Felner, "Theta*: Any-Angle Path Planning on Grids",
//! AAAI 2007; K. Daniel, A. Nash, S. Koenig, A. Felner, the same title, Journal of Artificial
//! Intelligence Research 39, 2010 (basic Theta*).
//!
//! ```text
//! n reached from m with parent p:
//!     p sees n:   parent(n) = p, g(n) = g(p) + |p n|        (path 2 of the paper)
//!     else        parent(n) = m, g(n) = g(m) + |m n|        (path 1)
//! f(n) = g(n) + |n goal|, all in cells
//! ```
//!
//! The path is usually shorter than any grid path but not always, and not always the shortest of
//! all. As in the paper closed nodes are final. Ties: larger g, then smaller row-major index.
//!
//! Departures, with `systems.md` §7.5: vertices are cell centres, not corners; sight is that of §1.2
//! (touching an obstacle blocks it), so neighbours are connected under the corner rule `forbid`. In
//! escape zones (simrun's own) nothing is cut: there the path keeps to the cells' centres, at ten
//! times the cost.

use super::GlobalKind;
use super::search::{Arrival, Buckets, CornerRule, Move, Moves, Nodes, RealEntry, Rule, Visit, Workspace};
use crate::map::Cell;
use crate::plan::contract::{Entry, GlobalPlanner, GridPlanner, Problem, Search};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `theta_star`: none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "A* with parents in sight instead of neighbours: any-angle paths, near the shortest and with few bends.",
    source: "A. Nash, K. Daniel, S. Koenig, A. Felner, Theta*: Any-Angle Path Planning on Grids, AAAI 2007; \
             Journal of Artificial Intelligence Research 39, 2010",
    any_angle: true,
    ..Entry::PLAIN
};

impl GlobalKind for Params {
    fn build(&self) -> Box<dyn GlobalPlanner> {
        Box::new(Planner::new(self))
    }
}

/// The planner.
#[derive(Debug)]
pub struct Planner {
    workspace: Workspace<f64, Buckets<RealEntry>>,
}

impl Planner {
    /// A fresh planner.
    pub fn new(_: &Params) -> Self {
        Self { workspace: Workspace::default() }
    }
}

impl GridPlanner for Planner {
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        self.workspace.search(&ParentInSight { problem }, problem, path)
    }
}

struct ParentInSight<'a> {
    problem: &'a Problem<'a>,
}

impl Rule for ParentInSight<'_> {
    type Cost = f64;
    type Priority = f64;

    fn reopens(&self) -> bool {
        false // the paper's basic Theta*
    }

    fn moves(&self, from: &Visit<f64>) -> Moves {
        Moves::allowed(self.problem.grid, from.index, CornerRule::Forbid)
    }

    // Inlined, so that what depends on the node alone is worked out once for its neighbours.
    #[inline(always)]
    fn connect(
        &self,
        nodes: &Nodes<f64>,
        from: &Visit<f64>,
        step: Move,
        stepped: f64,
        known: Option<f64>,
    ) -> Option<(u32, f64)> {
        let grid = self.problem.grid;
        let (parent, to) = (grid.cell(from.parent), step.from(from.cell));
        let straight = nodes.g(from.parent) + distance(parent, to);
        let is_cheaper = |g: f64| known.is_none_or(|known| g < known);
        // Sight is what takes long: it is looked for only where it matters.
        if !(is_cheaper(straight) || is_cheaper(stepped)) {
            return None;
        }
        if grid.is_clear_cells_free(parent, to) {
            is_cheaper(straight).then_some((from.parent, straight))
        } else {
            is_cheaper(stepped).then_some((from.index, stepped))
        }
    }

    fn priority(&self, arrival: Arrival<f64>) -> f64 {
        arrival.g + distance(arrival.cell, self.problem.goal)
    }
}

/// Distance between the centres of two cells, in cells.
fn distance(a: Cell, b: Cell) -> f64 {
    let (d_col, d_row) = (f64::from(a.col - b.col), f64::from(a.row - b.row));
    (d_col * d_col + d_row * d_row).sqrt()
}
