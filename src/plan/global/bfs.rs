//! `bfs`: breadth-first search, the path with the fewest steps. A diagonal step counts like a straight one, so
//! its paths may wander; a baseline of qin2026.
//!
//! Source: E. F. Moore, "The shortest path through a maze", Proceedings of the International Symposium on the
//! Theory of Switching, Harvard University Press, 1959. Nodes are expanded in the order in which they were
//! met, neighbours are met in the order E, NE, N, NW, W, SW, S, SE (`systems.md` §7.6); the first way to a node stays.
//!
//! Departures: the search ends when the goal would be expanded. Cells of escape zones count like any other.

use super::GlobalKind;
use super::search::{CornerRule, Marks, Moves};
use crate::map::Cell;
use crate::plan::contract::{Entry, Failure, GlobalPlanner, GridPlanner, Problem, Search};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `bfs`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Breadth-first search: the fewest steps, whatever their length.",
    source: "E. F. Moore, The shortest path through a maze, International Symposium on the Theory of Switching, 1959",
    ..Entry::PLAIN
};

/// A node that has been met.
#[derive(Clone, Copy, Debug)]
struct Met {
    index: u32,
    /// Place in the queue of the node from which this one was met; the start holds its own place.
    from: u32,
}

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
    /// All nodes in the order in which they were met; those that are not expanded yet are at the end.
    queue: Vec<Met>,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone(), marks: Marks::default(), queue: Vec::new() }
    }

    /// The cells from the start to the node at place `at` of the queue.
    fn trace(&self, problem: &Problem<'_>, mut at: usize, path: &mut Vec<Cell>) {
        loop {
            let Met { index, from } = self.queue[at];
            path.push(problem.grid.cell(index));
            if from as usize == at {
                break;
            }
            at = from as usize;
        }
        path.reverse();
    }
}

impl GridPlanner for Planner {
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        path.clear();
        if let Err(failure) = problem.check_ends() {
            return Search { result: Err(failure), expanded: 0, generated: 0 };
        }
        let grid = problem.grid;
        let (start, goal) = (grid.index(problem.start), grid.index(problem.goal));
        self.marks.begin(grid);
        self.marks.mark(start);
        self.queue.clear();
        self.queue.push(Met { index: start, from: 0 });
        let (mut at, mut result) = (0, Err(Failure::NoPath));
        while at < self.queue.len() {
            let index = self.queue[at].index;
            if index == goal {
                self.trace(problem, at, path);
                result = Ok(());
                break;
            }
            for step in Moves::allowed(grid, index, self.params.corner_rule) {
                let to = step.index_from(grid, index);
                if self.marks.mark(to) {
                    self.queue.push(Met { index: to, from: at as u32 });
                }
            }
            at += 1;
        }
        Search { result, expanded: at as u64, generated: self.queue.len() as u64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};

    #[test]
    fn neighbours_are_met_in_the_order_of_the_directions() {
        // (2, 1) is two steps away by (1, 0) and by (1, 1), of which (1, 0) is met first.
        let (_, grid) = drawn(&["...", "...", "..."]);
        let mut path = Vec::new();
        let cell = |col, row| Cell { col, row };
        let problem = Problem { grid: &grid, start: cell(0, 0), goal: cell(2, 1) };
        let search = Planner::new(&Params::default()).search(&problem, &mut path);
        // Met: (0,0); from it (1,0), (1,1), (0,1); from (1,0): E (2,0), NE (2,1), …: by way of (1,0).
        assert_eq!(path, [cell(0, 0), cell(1, 0), cell(2, 1)]);
        // Expanded before the goal, the sixth one met: (0,0), (1,0), (1,1), (0,1), (2,0).
        // Met from (1,1) besides: (2,2), (1,2), (0,2). Nine in all.
        assert_eq!((search.expanded, search.generated), (5, 9));
    }

    #[test]
    fn paths_have_the_fewest_steps_that_relaxing_finds() {
        let mut stream = stream(51);
        let mut planner = Planner::new(&Params::default());
        let mut found = 0;
        for _ in 0..1000 {
            let share = stream.range(0.0, 0.5);
            let map = random_map(&mut stream, 12, share);
            let grid = uninflated(&map);
            let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
            let mut path = Vec::new();
            let search = planner.search(&Problem { grid: &grid, start, goal }, &mut path);
            if search.result == Err(Failure::StartOccupied) || search.result == Err(Failure::GoalOccupied) {
                continue;
            }
            // Steps to all cells, by relaxing every step until nothing changes.
            let mut steps = vec![u32::MAX; grid.cells().len()];
            steps[grid.index(start) as usize] = 0;
            loop {
                let before = steps.clone();
                for cell in (0..map.occupied().len()).map(|index| map.cell(index)).filter(|&c| grid.is_passable(c)) {
                    let index = grid.index(cell);
                    for step in Moves::allowed(&grid, index, CornerRule::Forbid) {
                        let to = step.index_from(&grid, index) as usize;
                        steps[to] = steps[to].min(steps[index as usize].saturating_add(1));
                    }
                }
                if steps == before {
                    break;
                }
            }
            let fewest = steps[grid.index(goal) as usize];
            assert_eq!(search.result.is_ok(), fewest < u32::MAX);
            if search.result.is_ok() {
                assert_eq!(path.len(), fewest as usize + 1);
                found += 1;
            }
        }
        assert!(found > 200, "{found}");
    }
}
