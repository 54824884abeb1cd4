//! `lpa_star`: Lifelong Planning A*, a shortest-path search that is repaired when the map has changed. What is
//! still right of the search before is kept; only what the changes touch is searched again.
//!
//! Source: S. Koenig, M. Likhachev, D. Furcy, "Lifelong Planning A*", Artificial Intelligence 155, 2004.
//!
//! ```text
//! g(n)    distance of n from the root as known
//! rhs(n)  = min over the neighbours m of g(m) + c(m, n), 0 at the root        one step ahead of g
//! key(n)  = [min(g, rhs) + h(n), min(g, rhs)]
//! queue:  the nodes where g ≠ rhs, smallest key first, then smaller row-major index
//!
//! while the first key is below that of the target, or g ≠ rhs there
//!     take the first node n
//!     g > rhs:  g = rhs                      and look at its neighbours again
//!     g < rhs:  g = ∞                        and look at n and its neighbours again
//! ```
//!
//! Paths are shortest ones, as those of [`a_star`](super::a_star); h is the octile distance.
//!
//! **What is kept.** Between two calls of an episode: a copy of the planning grid, g, rhs and the queue. A call
//! compares the grid with the copy and repairs around the cells that differ, those of escape zones included.
//!
//! **The root is the goal.** The paper searches between two fixed nodes. Here the robot has moved on when it plans
//! again, so the search grows from the goal to the robot: steps cost the same in both directions, g is the distance
//! to the goal and stays right wherever the robot is. Only h, the distance to the robot's cell, changes with it,
//! and with h the keys; the queue is put in order anew (the key offset of [`d_star_lite`](super::d_star_lite) saves just that). Another goal
//! or another size of the map starts from scratch.
//!
//! **Counts.** Each node taken from the queue counts as expanded, over- and under-consistent alike, the robot's cell
//! included; each one put into it as generated. A first search expands a little more than A* therefore, and a
//! repair where nothing changed nothing at all.
//!
//! Departures: the paper leaves the choice between equal ways open: the path follows the first of the best
//! neighbours in the order E, NE, N, NW, W, SW, S, SE. (So which one of several shortest paths it is may depend
//! on the calls before in the episode, its length never.) gao2025 cites an improved variant; this is the
//! plain one (G-A24).
//!
//! When to use it: with replanning on a map that changes here and there. Without, `a_star` does the same with less.

use super::GlobalKind;
use super::search::{CornerRule, Lifelong, WhenMoved};
use crate::map::Cell;
use crate::plan::contract::{Entry, GlobalPlanner, GridPlanner, Problem, Search};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `lpa_star`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Lifelong Planning A*: shortest grid paths, repaired instead of searched again when the map has changed.",
    source: "S. Koenig, M. Likhachev, D. Furcy, Lifelong Planning A*, Artificial Intelligence 155, 2004",
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
    search: Lifelong,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self { search: Lifelong::new(params.corner_rule, WhenMoved::OrderAnew) }
    }
}

impl GridPlanner for Planner {
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        self.search.search(problem, path)
    }

    fn reset(&mut self) {
        self.search.reset();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::OccupancyGrid;
    use crate::plan::contract::Failure;
    use crate::plan::grid::tests::{drawn, stream, uninflated};

    #[test]
    fn a_corridor_is_searched_once_and_repaired_by_hand() {
        let (map, grid) = drawn(&["......", "......"]);
        let cell = |col, row| Cell { col, row };
        let mut planner = Planner::new(&Params::default());
        let mut path = Vec::new();
        let (start, goal) = (cell(0, 0), cell(5, 0));
        let search = planner.search(&Problem { grid: &grid, start, goal }, &mut path);
        // Straight along the row: the goal, four cells and the start are expanded, the start last.
        assert_eq!((search.result, search.expanded, path.len()), (Ok(()), 6, 6));
        let search = planner.search(&Problem { grid: &grid, start, goal }, &mut path);
        assert_eq!((search.expanded, path.len()), (0, 6));
        // The robot has moved on: its cell is right already.
        let search = planner.search(&Problem { grid: &grid, start: cell(2, 0), goal }, &mut path);
        assert_eq!((search.expanded, path.len()), (0, 4));
        // A cell behind the robot changes nothing for it.
        let mut behind = map.clone();
        behind.set_occupied(cell(0, 0));
        let grid = uninflated(&behind);
        let search = planner.search(&Problem { grid: &grid, start: cell(2, 0), goal }, &mut path);
        assert_eq!((search.expanded, path.len()), (0, 4));
        // One ahead sends it round by the other row: two diagonal steps are not allowed beside it.
        let mut ahead = behind.clone();
        ahead.set_occupied(cell(3, 0));
        let grid = uninflated(&ahead);
        let search = planner.search(&Problem { grid: &grid, start: cell(2, 0), goal }, &mut path);
        assert!(search.expanded > 0);
        assert_eq!(path, [cell(2, 0), cell(2, 1), cell(3, 1), cell(4, 1), cell(5, 0)]);
        // Walled off, and opened again.
        let mut walled = ahead.clone();
        walled.set_occupied(cell(3, 1));
        let problem_grid = uninflated(&walled);
        let search = planner.search(&Problem { grid: &problem_grid, start: cell(2, 0), goal }, &mut path);
        assert_eq!((search.result, path.len()), (Err(Failure::NoPath), 0));
        let search = planner.search(&Problem { grid: &grid, start: cell(2, 0), goal }, &mut path);
        assert_eq!((search.result, path.len()), (Ok(()), 5));
    }

    #[test]
    fn the_queue_stays_small_over_a_long_episode() {
        let mut stream = stream(62);
        let map = OccupancyGrid::empty(30, 30, 1.0);
        let mut planner = Planner::new(&Params::default());
        let (start, goal) = (Cell { col: 0, row: 0 }, Cell { col: 29, row: 29 });
        let mut path = Vec::new();
        for _ in 0..2000 {
            let mut now = map.clone();
            for _ in 0..5 {
                now.set_occupied(Cell { col: 1 + stream.index(28) as i32, row: 1 + stream.index(28) as i32 });
            }
            let grid = uninflated(&now);
            let search = planner.search(&Problem { grid: &grid, start, goal }, &mut path);
            assert!(planner.search.queue_len() as u64 <= 32 * 32 + search.generated, "{}", planner.search.queue_len());
        }
    }
}
