//! `dijkstra`: uniform-cost search. Expands cells in the order of their distance from the start
//! until the goal is reached; the reference for shortest paths on the grid.
//!
//! Source: E. W. Dijkstra, "A note on two problems in connexion with graphs", Numerische
//! Mathematik 1, 1959. f = g; steps cost 1 and √2 cells, ten times that in escape zones.
//!
//! Departures: the search ends when the goal would be expanded (`systems.md` §7.1), as all the papers
//! that compare with it do. Ties: smaller row-major index.
//!
//! When to use it: as a baseline. [`a_star`](super::a_star) finds paths of the same length with fewer expansions.

use super::GlobalKind;
use super::search::{
    Arrival, Buckets, CellCost, CornerRule, Cost, MoveTable, Moves, Rule, Visit, WholeEntry, WholeSteps, Workspace,
};
use crate::map::Cell;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, GlobalPlanner, GridPlanner, Problem, Search};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `dijkstra`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Uniform-cost search: shortest grid paths with no estimate of what is left; the reference for the others.",
    source: "E. W. Dijkstra, A note on two problems in connexion with graphs, Numerische Mathematik 1, 1959",
    exact: true,
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
    params: Params,
    workspace: Workspace<CellCost, Buckets<WholeEntry>>,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone(), workspace: Workspace::default() }
    }
}

impl GridPlanner for Planner {
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        let grid = problem.grid;
        let rule = UniformCost { grid, moves: MoveTable::worthwhile(grid, self.params.corner_rule) };
        self.workspace.search(&rule, problem, path)
    }
}

struct UniformCost<'a> {
    grid: &'a PlanningGrid,
    moves: &'static MoveTable,
}

impl Rule for UniformCost<'_> {
    type Cost = CellCost;
    type Priority = WholeSteps;

    fn reopens(&self) -> bool {
        true // steps have positive cost, so a closed node already has its smallest cost
    }

    fn moves(&self, from: &Visit<CellCost>) -> Moves {
        self.moves.after(from.arrived_by, self.grid, from.index)
    }

    fn priority(&self, arrival: Arrival<CellCost>) -> WholeSteps {
        WholeSteps { f: arrival.g, h: CellCost::ZERO }
    }
}
