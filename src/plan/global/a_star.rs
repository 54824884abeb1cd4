//! `a_star`: best-first search by cost so far plus an estimate of the rest.
//!
//! Source: P. E. Hart, N. J. Nilsson, B. Raphael, "A formal basis for the heuristic determination
//! of minimum cost paths", IEEE Transactions on Systems Science and Cybernetics 4(2), 1968.
//!
//! ```text
//! f(n) = g(n) + h(n)        g: cost from the start, h: estimate of the cost to the goal, in cells
//! ```
//!
//! With an admissible h (`octile`, `euclidean`, `chebyshev`) the path is a shortest one; these three
//! are consistent as well, so no node is expanded twice. `manhattan` overestimates on a grid with
//! diagonal steps: fewer expansions, paths not always shortest, closed nodes re-opened (`systems.md`
//! §7.2, Z-A3). Ties: larger g, then smaller row-major index.
//!
//! Departures: none; the heuristic of the papers differs (gao, zhu, qin, hu: `euclidean`; zhao: `manhattan`).

use super::GlobalKind;
use super::search::{
    Arrival, Buckets, CellCost, CornerRule, Heuristic, MoveTable, Moves, RealEntry, Rule, Steps, Visit, WholeEntry,
    WholeSteps, Workspace,
};
use crate::map::Cell;
use crate::plan::contract::{Entry, GlobalPlanner, GridPlanner, Problem, Search};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `a_star`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Estimate of the cost to the goal; default `octile`.
    pub heuristic: Heuristic,
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Best-first search by cost plus estimate: shortest grid paths with far fewer expansions than dijkstra.",
    source: "P. E. Hart, N. J. Nilsson, B. Raphael, A formal basis for the heuristic determination of minimum cost \
             paths, IEEE Transactions on Systems Science and Cybernetics 4(2), 1968",
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
    /// Workspace for the octile distance, whose f is a number of steps.
    whole: Workspace<CellCost, Buckets<WholeEntry>>,
    /// Workspace for the other estimates.
    real: Workspace<Steps, Buckets<RealEntry>>,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone(), whole: Workspace::default(), real: Workspace::default() }
    }
}

impl GridPlanner for Planner {
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        if self.params.heuristic == Heuristic::Octile {
            self.whole.search(&CostPlusOctile::new(problem, self.params.corner_rule), problem, path)
        } else {
            self.real.search(&CostPlusEstimate { problem, params: &self.params }, problem, path)
        }
    }
}

/// A* with the octile distance as a rule of the search core, for one problem: [`CostPlusEstimate`] in whole steps.
pub(super) struct CostPlusOctile<'a> {
    problem: &'a Problem<'a>,
    moves: &'static MoveTable,
}

impl<'a> CostPlusOctile<'a> {
    pub fn new(problem: &'a Problem<'a>, corner_rule: CornerRule) -> Self {
        Self { problem, moves: MoveTable::worthwhile(problem.grid, corner_rule) }
    }
}

impl Rule for CostPlusOctile<'_> {
    type Cost = CellCost;
    type Priority = WholeSteps;

    fn reopens(&self) -> bool {
        true // a consistent estimate never finds a cheaper way to a closed node
    }

    fn moves(&self, from: &Visit<CellCost>) -> Moves {
        self.moves.after(from.arrived_by, self.problem.grid, from.index)
    }

    fn estimate(&self, cell: Cell) -> CellCost {
        CellCost::octile(cell, self.problem.goal)
    }

    fn priority(&self, arrival: Arrival<CellCost>) -> WholeSteps {
        let h = self.estimate(arrival.cell);
        WholeSteps { f: arrival.g.plus(h), h }
    }
}

/// A* as a rule of the search core, for one problem.
pub(super) struct CostPlusEstimate<'a> {
    pub problem: &'a Problem<'a>,
    pub params: &'a Params,
}

impl Rule for CostPlusEstimate<'_> {
    type Cost = Steps;
    type Priority = f64;

    fn reopens(&self) -> bool {
        !self.params.heuristic.is_consistent()
    }

    fn moves(&self, from: &Visit<Steps>) -> Moves {
        Moves::worthwhile(self.problem.grid, from.index, self.params.corner_rule, from.arrived_by)
    }

    fn priority(&self, arrival: Arrival<Steps>) -> f64 {
        self.params.heuristic.added_to(arrival.g, arrival.cell, self.problem.goal)
    }
}
