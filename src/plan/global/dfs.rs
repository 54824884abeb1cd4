//! `dfs`: depth-first search. Goes on from the node met last and turns back only where nothing new is left, so
//! its paths are usually very long; a baseline of qin2026 that shows what a path without any cost is.
//!
//! Source: R. Tarjan, "Depth-first search and linear graph algorithms", SIAM Journal on Computing 1(2), 1972.
//! Neighbours in the order E, NE, N, NW, W, SW, S, SE, a set of visited nodes, no limit of depth (`systems.md` §7.6).
//!
//! Departures: the search ends when the goal is visited. Cells of escape zones count like any other.

use super::GlobalKind;
use super::search::{CornerRule, Marks, Moves};
use crate::map::Cell;
use crate::plan::contract::{Entry, Failure, GlobalPlanner, GridPlanner, Problem, Search};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `dfs`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Depth-first search: the first way found, usually very long; shows what ignoring cost does.",
    source: "R. Tarjan, Depth-first search and linear graph algorithms, SIAM Journal on Computing 1(2), 1972",
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
    marks: Marks,
    /// The way from the start to the current node; each node with the moves that are left to try.
    way: Vec<(u32, Moves)>,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone(), marks: Marks::default(), way: Vec::new() }
    }
}

impl GridPlanner for Planner {
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        path.clear();
        if let Err(failure) = problem.check_ends() {
            return Search { result: Err(failure), expanded: 0, generated: 0 };
        }
        let grid = problem.grid;
        let moves = |index| Moves::allowed(grid, index, self.params.corner_rule);
        let (start, goal) = (grid.index(problem.start), grid.index(problem.goal));
        self.marks.begin(grid);
        self.marks.mark(start);
        self.way.clear();
        self.way.push((start, moves(start)));
        let mut visited = 1;
        while let Some((index, left)) = self.way.last_mut() {
            let index = *index;
            if index == goal {
                path.extend(self.way.iter().map(|&(index, _)| grid.cell(index)));
                return Search { result: Ok(()), expanded: visited - 1, generated: visited };
            }
            match left.map(|step| step.index_from(grid, index)).find(|&to| self.marks.mark(to)) {
                Some(to) => {
                    self.way.push((to, moves(to)));
                    visited += 1;
                }
                None => {
                    self.way.pop();
                }
            }
        }
        Search { result: Err(Failure::NoPath), expanded: visited, generated: visited }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::grid::tests::drawn;

    #[test]
    fn it_goes_east_first_and_turns_back_from_dead_ends() {
        let (_, grid) = drawn(&[
            "..#", //
            ".#.", //
            "...", //
        ]);
        let cell = |col, row| Cell { col, row };
        let mut path = Vec::new();
        let mut planner = Planner::new(&Params::default());
        // East twice, then N to (2, 1), a dead end; back to the start, and N twice.
        let problem = Problem { grid: &grid, start: cell(0, 0), goal: cell(1, 2) };
        let search = planner.search(&problem, &mut path);
        assert_eq!(path, [cell(0, 0), cell(0, 1), cell(0, 2), cell(1, 2)]);
        // Visited: (0,0), (1,0), (2,0), (2,1), (0,1), (0,2), and the goal.
        assert_eq!((search.expanded, search.generated), (6, 7));
    }

    #[test]
    fn in_the_open_it_sweeps_the_map() {
        let (_, grid) = drawn(&["...", "...", "..."]);
        let cell = |col, row| Cell { col, row };
        let mut path = Vec::new();
        let problem = Problem { grid: &grid, start: cell(0, 0), goal: cell(0, 1) };
        Planner::new(&Params::default()).search(&problem, &mut path);
        // E, E; then N, for E and NE lead outside; N; W; W; then SW, S of (0, 2) is the goal.
        // At (2, 1): E, NE outside, N (2, 2). At (2, 2): W (1, 2). At (1, 2): W (0, 2). At (0, 2): S (0, 1).
        let expected = [cell(0, 0), cell(1, 0), cell(2, 0), cell(2, 1), cell(2, 2), cell(1, 2), cell(0, 2), cell(0, 1)];
        assert_eq!(path, expected);
    }
}
