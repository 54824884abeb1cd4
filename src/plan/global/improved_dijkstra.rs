//! `improved_dijkstra`: uniform-cost search that tries each way round once. A **stand-in**, see below.
//!
//! The tables of gao2025 list it as "IDA*". That is **not** iterative deepening A*: it is the improved Dijkstra
//! algorithm of their reference 15 (Li, Liu, Yao 2019), whose text was not available (G-A25). This file stands in
//! for it with what its name promises, an exact Dijkstra that does less (`systems.md` §7.4):
//!
//! - a bucket queue, that of the search core, ordered exactly over sums of the two step costs 1 and √2;
//! - an early end, when the goal would be expanded;
//! - closed nodes are never looked at again;
//! - from a node only the natural and forced neighbours with respect to the direction from its parent are tried
//!   (D. Harabor, A. Grastien, "Online graph pruning for pathfinding on grid maps", AAAI 2011: jump point search
//!   without the jumps), so that of many equal ways round free space one is followed.
//!
//! Paths are as long as those of [`dijkstra`](super::dijkstra), and exactly as many nodes are expanded, for a
//! search without an estimate has to expand all nodes that are nearer than the goal; what it saves is looking at
//! neighbours. The published counts (fewer nodes than A*) cannot be had this way (T4).
//!
//! Departures: in escape zones, where a detour may be cheaper, all moves are tried. Ties: smaller row-major index.
//!
//! Parameters: [`Params`].

use super::GlobalKind;
use super::search::{
    Arrival, Buckets, CellCost, CornerRule, Cost, MoveTable, Moves, Rule, Visit, WholeEntry, WholeSteps, Workspace,
};
use crate::map::Cell;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, GlobalPlanner, GridPlanner, Problem, Search};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `improved_dijkstra`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Dijkstra without symmetric detours, a stand-in for the improved Dijkstra that gao2025 lists as IDA*: shortest grid paths.",
    source: "stand-in for Li, Liu, Yao, 2019 (reference 15 of gao2025), with the neighbours of D. Harabor, A. Grastien, \
             Online graph pruning for pathfinding on grid maps, AAAI 2011",
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
        let rule = WithoutSymmetry { grid, moves: MoveTable::natural_and_forced(grid, self.params.corner_rule) };
        self.workspace.search(&rule, problem, path)
    }
}

struct WithoutSymmetry<'a> {
    grid: &'a PlanningGrid,
    moves: &'static MoveTable,
}

impl Rule for WithoutSymmetry<'_> {
    type Cost = CellCost;
    type Priority = WholeSteps;

    fn reopens(&self) -> bool {
        true // a closed node already has its smallest cost
    }

    fn moves(&self, from: &Visit<CellCost>) -> Moves {
        self.moves.after(from.arrived_by, self.grid, from.index)
    }

    fn priority(&self, arrival: Arrival<CellCost>) -> WholeSteps {
        WholeSteps { f: arrival.g, h: CellCost::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::grid::tests::drawn;

    /// Directions (0: E, counter-clockwise) of the moves from the middle of a drawing, reached in direction `by`.
    fn moves(lines: &[&str], rule: CornerRule, by: usize) -> Vec<usize> {
        let (_, open) = drawn(&["...", "...", "..."]);
        let (_, grid) = drawn(lines);
        let middle = grid.index(Cell { col: 1, row: 1 });
        let arrived_by = Moves::allowed(&open, middle, rule).find(|step| step.direction() == by);
        Moves::natural_and_forced(&grid, middle, rule, arrived_by).map(|step| step.direction()).collect()
    }

    #[test]
    fn in_the_open_a_straight_step_goes_on_and_a_diagonal_one_spreads() {
        for rule in [CornerRule::Forbid, CornerRule::OneFree, CornerRule::Allow] {
            let open = ["...", "...", "..."];
            assert_eq!(moves(&open, rule, 0), [0]);
            assert_eq!(moves(&open, rule, 6), [6]);
            assert_eq!(moves(&open, rule, 1), [0, 1, 2]);
            assert_eq!(moves(&open, rule, 3), [2, 3, 4]);
        }
    }

    #[test]
    fn obstacles_force_the_neighbours_behind_them() {
        // By E past a block in the NW: N and what lies beyond it cannot be had diagonally without cutting it.
        let behind = ["#..", "...", "..."];
        assert_eq!(moves(&behind, CornerRule::Forbid, 0), [0, 1, 2]);
        assert_eq!(moves(&behind, CornerRule::Allow, 0), [0]);
        // By E along a block in the N: NE by way of the middle alone, where corners may be cut.
        let beside = [".#.", "...", "..."];
        assert_eq!(moves(&beside, CornerRule::Forbid, 0), [0]);
        assert_eq!(moves(&beside, CornerRule::OneFree, 0), [0, 1]);
        // By NE past a block in the W: NW.
        let corner = ["...", "#..", "..."];
        assert_eq!(moves(&corner, CornerRule::Allow, 1), [0, 1, 2, 3]);
    }
}
