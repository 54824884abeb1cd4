//! `d_star_lite`: D* Lite, Lifelong Planning A* for a robot that moves: what is still right of the search before is kept, and so
//! is the order of its queue.
//!
//! Source: S. Koenig, M. Likhachev, "D* Lite", AAAI 2002; the version with the key offset km (its figure 3).
//!
//! ```text
//! g, rhs, queue as in lpa_star, searched from the goal to the robot
//! key(n)  = [min(g, rhs) + h(n) + km, min(g, rhs)]        h: octile distance to the robot's cell
//! the robot has moved from s to t:  km = km + h(s, t)
//! take the first node n of the queue
//!     its key has grown since it was put in:  put it back with the key it has now
//!     otherwise as in lpa_star
//! ```
//!
//! h falls by at most h(s, t) where the robot has moved from s to t, so a key that was computed before is a lower bound of what it
//! is now: the queue need not be put in order, and only the nodes that are taken get new keys.
//!
//! It shares all but that with [`lpa_star`](super::lpa_star): what is kept, the comparison of the grid with that of the call before,
//! the order among equal ways, and paths, which are shortest ones. Another goal or another size of the map starts from scratch.
//!
//! **Counts.** Each node taken from the queue counts as expanded, unless it is put back; each one put in or back as generated. A
//! repair where nothing changed expands nothing, wherever the robot has gone along its path.
//!
//! Departures: the keys of the whole queue are computed anew, and km set to 0, when outdated entries fill it beyond the number of
//! cells. qin2026 compares with "D*" (Q-A15): [`d_star`](super::d_star) is that of 1994, this one is equal to it in cost.
//!
//! Parameters: [`Params`].

use super::GlobalKind;
use super::search::{CornerRule, Lifelong, WhenMoved};
use crate::map::Cell;
use crate::plan::contract::{Entry, GlobalPlanner, GridPlanner, Problem, Search};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `d_star_lite`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "D* Lite: shortest grid paths, repaired as the map changes, without putting the queue in order anew when the robot has moved.",
    source: "S. Koenig, M. Likhachev, D* Lite, AAAI 2002",
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
        Self { search: Lifelong::new(params.corner_rule, WhenMoved::Offset) }
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
    use crate::plan::global::lpa_star;
    use crate::plan::grid::tests::{drawn, stream, uninflated};

    #[test]
    fn a_corridor_is_searched_once_and_repaired_by_hand() {
        let (map, grid) = drawn(&["......", "......"]);
        let cell = |col, row| Cell { col, row };
        let mut planner = Planner::new(&Params::default());
        let (mut path, goal) = (Vec::new(), cell(5, 0));
        let search = planner.search(&Problem { grid: &grid, start: cell(0, 0), goal }, &mut path);
        assert_eq!((search.result, search.expanded, path.len()), (Ok(()), 6, 6));
        // The robot has moved on: its cell is right already, and no key is computed anew.
        let search = planner.search(&Problem { grid: &grid, start: cell(2, 0), goal }, &mut path);
        assert_eq!((search.expanded, search.generated, path.len()), (0, 0, 4));
        // An obstacle ahead sends it round by the other row.
        let mut ahead = map.clone();
        ahead.set_occupied(cell(3, 0));
        let grid = uninflated(&ahead);
        let search = planner.search(&Problem { grid: &grid, start: cell(2, 0), goal }, &mut path);
        assert!(search.expanded > 0);
        assert_eq!(path, [cell(2, 0), cell(2, 1), cell(3, 1), cell(4, 1), cell(5, 0)]);
    }

    #[test]
    fn a_moving_robot_costs_what_it_does_with_a_queue_put_in_order_and_the_queue_stays_small() {
        let mut stream = stream(63);
        let map = OccupancyGrid::empty(40, 40, 1.0);
        let mut lite = Planner::new(&Params::default());
        let mut lifelong = lpa_star::Planner::new(&lpa_star::Params::default());
        let goal = Cell { col: 39, row: 39 };
        let (mut path, mut other, mut expanded) = (Vec::new(), Vec::new(), (0, 0));
        let mut start = Cell { col: 0, row: 0 };
        for round in 0..2000 {
            let mut now = map.clone();
            for _ in 0..5 {
                now.set_occupied(Cell { col: 1 + stream.index(38) as i32, row: 1 + stream.index(38) as i32 });
            }
            now.set_free(start);
            let grid = uninflated(&now);
            let problem = Problem { grid: &grid, start, goal };
            let search = lite.search(&problem, &mut path);
            expanded.0 += search.expanded;
            expanded.1 += lifelong.search(&problem, &mut other).expanded;
            assert_eq!(path.len(), other.len());
            assert!(lite.search.queue_len() as u64 <= 42 * 42 + search.generated, "{}", lite.search.queue_len());
            start = if round % 40 == 39 { Cell { col: 0, row: stream.index(39) as i32 } } else { path[1] };
        }
        // The same nodes, but for ties.
        assert!(expanded.0 < expanded.1 + expanded.1 / 10 && expanded.1 < expanded.0 + expanded.0 / 10, "{expanded:?}");
    }
}
