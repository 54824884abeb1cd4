//! `lpa_star`: Lifelong Planning A*, a shortest-path search that is repaired when the map has changed. What is
//! still right of the search before is kept; only what the changes touch is searched again.
//!
//! Source: S. Koenig, M. Likhachev, D. Furcy, "Lifelong Planning A*", Artificial Intelligence 155, 2004.
//!
//! ```text
//! g(n)    distance of n as known
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
//! and with h the keys; the queue is put in order anew (D* Lite's key offset would save just that). Another goal
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
use super::search::{CellCost, CornerRule, Cost, Move, Moves, step_factor};
use crate::map::Cell;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, Failure, GlobalPlanner, GridPlanner, Problem, Search};
use crate::plan::grid::PASSABLE;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

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

/// Distance of a node to which no way is known; larger than that of any path.
const UNREACHED: CellCost = CellCost(u64::MAX);

/// Record of a node: its distance from the root as stored (g), and as computed from its neighbours (rhs).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Vertex {
    g: CellCost,
    rhs: CellCost,
}

type Key = (CellCost, CellCost);

/// Key of a node of which nothing is known: larger than all others.
const LAST: Key = (UNREACHED, UNREACHED);

/// Number of cells that are compared at once to find those that changed.
const COMPARED: usize = 256;

impl GlobalKind for Params {
    fn build(&self) -> Box<dyn GlobalPlanner> {
        Box::new(Planner::new(self))
    }
}

/// The planner.
#[derive(Debug)]
pub struct Planner {
    corner_rule: CornerRule,
    /// Root of the kept search; `None` if nothing is kept.
    goal: Option<Cell>,
    /// The robot's cell, for which the keys were computed.
    start: Cell,
    /// The grid of the last search, padded.
    cells: Vec<u8>,
    cols: i32,
    vertices: Vec<Vertex>,
    /// All nodes with g ≠ rhs and their keys. It also holds outdated entries, recognised by their key.
    queue: BinaryHeap<Reverse<(Key, u32)>>,
    changed: Vec<u32>,
    /// Nodes whose rhs a change may have altered.
    affected: Vec<u32>,
    pushed: u64,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self {
            corner_rule: params.corner_rule,
            goal: None,
            start: Cell { col: 0, row: 0 },
            cells: Vec::new(),
            cols: 0,
            vertices: Vec::new(),
            queue: BinaryHeap::new(),
            changed: Vec::new(),
            affected: Vec::new(),
            pushed: 0,
        }
    }

    /// Adapts the kept search to the problem: the root, the keys, the cells that changed.
    fn adopt(&mut self, problem: &Problem<'_>) {
        let grid = problem.grid;
        let is_same_map = self.cols == grid.cols() && self.cells.len() == grid.cells().len();
        if self.goal != Some(problem.goal) || !is_same_map {
            self.restart(problem);
            return;
        }
        if self.start != problem.start || self.queue.len() > self.cells.len() {
            self.start = problem.start;
            self.order_queue_anew(grid);
        }
        self.changed.clear();
        self.affected.clear();
        let parts = self.cells.chunks_mut(COMPARED).zip(grid.cells().chunks(COMPARED)).enumerate();
        for (part, (old, new)) in parts.filter(|(_, (old, new))| old != new) {
            let differing = (0..new.len()).filter(|&at| old[at] != new[at]);
            self.changed.extend(differing.map(|at| (part * COMPARED + at) as u32));
            old.copy_from_slice(new);
        }
        // Steps from and to a changed cell, and those that pass it diagonally: all between it and its neighbours.
        let stride = grid.stride() as u32;
        for at in 0..self.changed.len() {
            for row_start in [self.changed[at] - stride - 1, self.changed[at] - 1, self.changed[at] + stride - 1] {
                self.affected.extend(row_start..row_start + 3);
            }
        }
        self.affected.sort_unstable();
        self.affected.dedup();
        let affected = core::mem::take(&mut self.affected);
        for &index in &affected {
            self.look_ahead(grid, index);
        }
        self.affected = affected;
    }

    fn restart(&mut self, problem: &Problem<'_>) {
        let grid = problem.grid;
        (self.goal, self.start, self.cols) = (Some(problem.goal), problem.start, grid.cols());
        self.cells.clear();
        self.cells.extend_from_slice(grid.cells());
        self.vertices.clear();
        self.vertices.resize(self.cells.len(), Vertex { g: UNREACHED, rhs: UNREACHED });
        self.queue.clear();
        self.set_rhs(grid, grid.index(problem.goal), CellCost::ZERO);
    }

    /// Gives every entry of the queue its current key and drops the outdated ones.
    fn order_queue_anew(&mut self, grid: &PlanningGrid) {
        let mut entries = core::mem::take(&mut self.queue).into_vec();
        entries.retain_mut(|Reverse((key, index))| {
            *key = self.key(grid, *index);
            !self.is_consistent(*index)
        });
        entries.sort_unstable();
        entries.dedup();
        self.queue = BinaryHeap::from(entries);
    }

    fn is_consistent(&self, index: u32) -> bool {
        let Vertex { g, rhs } = self.vertices[index as usize];
        g == rhs
    }

    fn key(&self, grid: &PlanningGrid, index: u32) -> Key {
        let Vertex { g, rhs } = self.vertices[index as usize];
        let distance = g.min(rhs);
        if distance == UNREACHED {
            return LAST;
        }
        (distance.plus(CellCost::octile(grid.cell(index), self.start)), distance)
    }

    /// Repairs g and rhs until the distance of `start` is right; returns the number of nodes expanded.
    fn repair(&mut self, grid: &PlanningGrid, start: u32) -> u64 {
        let mut expanded = 0;
        while let Some(&Reverse((key, index))) = self.queue.peek() {
            let is_out_of_date = self.is_consistent(index) || key != self.key(grid, index);
            if !is_out_of_date && key >= self.key(grid, start) && self.is_consistent(start) {
                break;
            }
            self.queue.pop();
            if is_out_of_date {
                continue;
            }
            expanded += 1;
            let Vertex { g, rhs } = self.vertices[index as usize];
            if rhs < g {
                self.vertices[index as usize].g = rhs;
                for step in self.moves(grid, index) {
                    let to = step.index_from(grid, index);
                    let distance = stepped(grid, rhs, index, to, step);
                    if distance < self.vertices[to as usize].rhs {
                        self.set_rhs(grid, to, distance);
                    }
                }
            } else {
                self.vertices[index as usize].g = UNREACHED;
                self.push(grid, index);
                for step in self.moves(grid, index) {
                    let to = step.index_from(grid, index);
                    // The others' rhs comes from elsewhere, where nothing has changed.
                    if self.vertices[to as usize].rhs == stepped(grid, g, index, to, step) {
                        self.look_ahead(grid, to);
                    }
                }
            }
        }
        expanded
    }

    /// The moves from a node; none if it is blocked.
    fn moves(&self, grid: &PlanningGrid, index: u32) -> Moves {
        if grid.cells()[index as usize] & PASSABLE != 0 {
            Moves::allowed(grid, index, self.corner_rule)
        } else {
            Moves::NONE
        }
    }

    /// The neighbour through which a node is nearest to the root, and the distance that way; ties go to the first neighbour.
    fn best_neighbour(&self, grid: &PlanningGrid, index: u32) -> Option<(u32, CellCost)> {
        let neighbours = self.moves(grid, index).filter_map(|step| {
            let to = step.index_from(grid, index);
            let g = self.vertices[to as usize].g;
            (g != UNREACHED).then(|| (to, stepped(grid, g, index, to, step)))
        });
        neighbours.min_by_key(|&(_, distance)| distance)
    }

    /// Computes the rhs of a node from its neighbours.
    fn look_ahead(&mut self, grid: &PlanningGrid, index: u32) {
        if self.goal != Some(grid.cell(index)) {
            let rhs = self.best_neighbour(grid, index).map_or(UNREACHED, |(_, distance)| distance);
            self.set_rhs(grid, index, rhs);
        }
    }

    fn set_rhs(&mut self, grid: &PlanningGrid, index: u32, rhs: CellCost) {
        if self.vertices[index as usize].rhs != rhs {
            self.vertices[index as usize].rhs = rhs;
            self.push(grid, index);
        }
    }

    /// Puts a node into the queue if it belongs there.
    fn push(&mut self, grid: &PlanningGrid, index: u32) {
        if !self.is_consistent(index) {
            self.queue.push(Reverse((self.key(grid, index), index)));
            self.pushed += 1;
        }
    }

    /// The cells from `start` to the root, downhill.
    fn trace(&self, grid: &PlanningGrid, start: u32, path: &mut Vec<Cell>) {
        let mut index = start;
        path.push(grid.cell(index));
        while self.goal != Some(grid.cell(index)) {
            let (next, _) = self.best_neighbour(grid, index).expect("a reached node has a reached neighbour");
            let distance = |index: u32| self.vertices[index as usize].g;
            assert!(distance(next) < distance(index), "the way to the goal goes downhill");
            index = next;
            path.push(grid.cell(index));
        }
    }
}

/// A distance with the step between two nodes added.
fn stepped(grid: &PlanningGrid, distance: CellCost, a: u32, b: u32, step: Move) -> CellCost {
    let factor = step_factor(grid.cells()[a as usize] | grid.cells()[b as usize]);
    distance.stepped(step.is_diagonal(), factor)
}

impl GridPlanner for Planner {
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        path.clear();
        if let Err(failure) = problem.check_ends() {
            return Search { result: Err(failure), expanded: 0, generated: 0 };
        }
        let grid = problem.grid;
        let start = grid.index(problem.start);
        self.pushed = 0;
        self.adopt(problem);
        let expanded = self.repair(grid, start);
        let is_reached = self.vertices[start as usize].g != UNREACHED;
        if is_reached {
            self.trace(grid, start, path);
        }
        let result = if is_reached { Ok(()) } else { Err(Failure::NoPath) };
        Search { result, expanded, generated: self.pushed }
    }

    fn reset(&mut self) {
        self.goal = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::OccupancyGrid;
    use crate::plan::global::search::Steps;
    use crate::plan::global::{GlobalChoice, dijkstra};
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};

    /// The cost of a path of allowed steps, counted anew.
    fn cost(grid: &PlanningGrid, path: &[Cell], rule: CornerRule) -> Steps {
        path.windows(2).fold(Steps::ZERO, |cost, pair| {
            let from = grid.index(pair[0]);
            let step = Moves::allowed(grid, from, rule).find(|step| step.from(pair[0]) == pair[1]).expect("allowed");
            let bits = grid.cells()[from as usize] | grid.cells()[grid.index(pair[1]) as usize];
            cost.stepped(step.is_diagonal(), step_factor(bits))
        })
    }

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
    fn repairs_cost_what_a_search_from_scratch_does() {
        let mut stream = stream(61);
        let (mut found, mut lost, mut repaired, mut scratch) = (0, 0, 0, 0);
        for case in 0..400 {
            let corner_rule = [CornerRule::Forbid, CornerRule::OneFree, CornerRule::Allow][case % 3];
            let share = stream.range(0.0, 0.4);
            // What is occupied, and what is blocked by inflation as well.
            let mut blocked = random_map(&mut stream, 24, share);
            let mut occupied = blocked.clone();
            let mut planner = Planner::new(&Params { corner_rule });
            let mut fresh = GlobalChoice::dijkstra(dijkstra::Params { corner_rule }).build();
            let (mut start, mut goal) = (random_cell(&mut stream, &blocked), random_cell(&mut stream, &blocked));
            for _ in 0..20 {
                for _ in 0..stream.index(6) {
                    let cell = random_cell(&mut stream, &blocked);
                    let toggle = |map: &mut OccupancyGrid, free: bool| {
                        if free { map.set_free(cell) } else { map.set_occupied(cell) }
                    };
                    let was_free = blocked.is_free(cell);
                    toggle(&mut blocked, !was_free);
                    toggle(&mut occupied, !was_free || stream.uniform() < 0.5);
                }
                let mut grid = uninflated(&blocked);
                if stream.uniform() < 0.5 {
                    grid.open_around(&occupied, start);
                    grid.open_around(&occupied, goal);
                }
                let problem = Problem { grid: &grid, start, goal };
                let (mut path, mut expected_path) = (Vec::new(), Vec::new());
                let search = planner.search(&problem, &mut path);
                let expected = fresh.as_grid().expect("cells").search(&problem, &mut expected_path);
                assert_eq!(search.result, expected.result);
                if search.result.is_ok() {
                    assert_eq!((path[0], path[path.len() - 1]), (start, goal));
                    assert_eq!(cost(&grid, &path, corner_rule), cost(&grid, &expected_path, corner_rule));
                    found += 1;
                    repaired += search.expanded;
                    scratch += expected.expanded;
                    start = path[stream.index(path.len().min(4))];
                } else {
                    assert!(path.is_empty());
                    lost += 1;
                    start = random_cell(&mut stream, &blocked);
                }
                if stream.uniform() < 0.05 {
                    goal = random_cell(&mut stream, &blocked);
                }
            }
        }
        assert!(found > 2000 && lost > 500, "{found} {lost}");
        assert!(repaired < scratch / 2, "{repaired} expanded in repairs, {scratch} from scratch");
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
            assert!(planner.queue.len() as u64 <= 32 * 32 + search.generated, "{}", planner.queue.len());
        }
    }
}
