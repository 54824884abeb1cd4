//! `d_star`: D* as it first was: shortest paths, repaired by waves of raised and lowered costs that start where the map has
//! changed.
//!
//! Source: A. Stentz, "Optimal and efficient path planning for partially-known environments", IEEE International Conference on
//! Robotics and Automation, 1994.
//!
//! ```text
//! tag(X)  NEW: never met, OPEN: in the list, CLOSED: taken from it
//! h(X)    cost from X to the goal as known; k(X) the least that h(X) was since X came into the list: the list is sorted by k
//! b(X)    the next node on the way to the goal
//!
//! PROCESS-STATE: take the X of smallest k from the list, k_old = k(X)
//!     k_old < h(X)  (RAISE):  for each neighbour Y with h(Y) ≤ k_old and h(X) > h(Y) + c(Y, X):   b(X) = Y, h(X) = h(Y) + c(Y, X)
//!     k_old = h(X)  (LOWER):  for each neighbour Y that is NEW, or has b(Y) = X and h(Y) ≠ h(X) + c(X, Y),
//!                             or has b(Y) ≠ X and h(Y) > h(X) + c(X, Y):                          b(Y) = X, INSERT(Y, h(X) + c(X, Y))
//!     otherwise:              for each neighbour Y
//!                                 that is NEW, or has b(Y) = X and h(Y) ≠ h(X) + c(X, Y):         b(Y) = X, INSERT(Y, h(X) + c(X, Y))
//!                                 that has b(Y) ≠ X and h(Y) > h(X) + c(X, Y):                    INSERT(X, h(X))
//!                                 that has b(Y) ≠ X, h(X) > h(Y) + c(Y, X), is CLOSED, h(Y) > k_old:  INSERT(Y, h(Y))
//! INSERT(X, h'):   k(X) = h' if NEW, min(k(X), h') if OPEN, min(h(X), h') if CLOSED;  h(X) = h', OPEN
//! MODIFY-COST:     a cost at X has changed:  INSERT(X, h(X)) if X is CLOSED
//! ```
//!
//! A call runs PROCESS-STATE until the smallest k is at least h of the robot's cell, whose way is a shortest one then, and follows
//! the pointers b. An arc is infinite from and to a blocked cell and where the corner rule forbids it; what is raised to infinity
//! is cut off. If that holds for the robot's cell there is no path until a cell is freed, which lowers costs again.
//!
//! **What is kept.** Between two calls of an episode: tags, h, k, b, the list, and a copy of the planning grid, with which the next
//! call compares its own: MODIFY-COST is called for every cell from or to which an arc may have changed, escape zones included.
//! Nothing depends on where the robot is. Another goal or another size of the map starts from scratch.
//!
//! **Counts.** Each node that PROCESS-STATE takes counts as expanded, each INSERT that puts a node into the list or moves it forward
//! as generated. Without an estimate a first search expands as much as [`dijkstra`](super::dijkstra); a repair where nothing
//! changed expands nothing.
//!
//! Departures: of nodes with the same k the one of smaller row-major index is taken first, where the paper says nothing. (So
//! which one of several shortest paths it is may depend on the calls before in the episode, its cost never.) Neighbours are looked at
//! in the order E, NE, N, NW, W, SW, S, SE. Movers are blocked cells where `planning` says so, and nothing else: there is no
//! prediction (Q-A15, `systems.md` §7.8).
//!
//! Parameters: [`Params`].

use super::GlobalKind;
use super::search::{CellCost, CornerRule, Cost, KeptGrid, Move, Moves, UNREACHED, stepped};
use crate::map::Cell;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, Failure, GlobalPlanner, GridPlanner, Problem, Search};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Parameters of `d_star`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "D* of 1994: shortest grid paths, repaired by raising and lowering costs where the map has changed.",
    source: "A. Stentz, Optimal and efficient path planning for partially-known environments, IEEE International Conference \
             on Robotics and Automation, 1994",
    exact: true,
    ..Entry::PLAIN
};

impl GlobalKind for Params {
    fn build(&self) -> Box<dyn GlobalPlanner> {
        Box::new(Planner::new(self))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Tag {
    New,
    Open,
    Closed,
}

/// Record of a node.
#[derive(Clone, Copy, Debug)]
struct Node {
    h: CellCost,
    k: CellCost,
    /// The move to the next node on the way to the goal; none at the goal and where none is known.
    next: Option<Move>,
    tag: Tag,
}

impl Node {
    const NEW: Self = Self { h: UNREACHED, k: UNREACHED, next: None, tag: Tag::New };
}

/// The planner.
#[derive(Debug)]
pub struct Planner {
    corner_rule: CornerRule,
    /// Root of the kept search; `None` if nothing is kept.
    goal: Option<Cell>,
    grid: KeptGrid,
    nodes: Vec<Node>,
    /// All open nodes and their k. It also holds outdated entries, recognised by another k or tag.
    open: BinaryHeap<Reverse<(CellCost, u32)>>,
    inserted: u64,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self {
            corner_rule: params.corner_rule,
            goal: None,
            grid: KeptGrid::default(),
            nodes: Vec::new(),
            open: BinaryHeap::new(),
            inserted: 0,
        }
    }

    /// Adapts the kept search to the problem: the root and the cells that changed.
    fn adopt(&mut self, problem: &Problem<'_>) {
        let grid = problem.grid;
        if self.goal != Some(problem.goal) || !self.grid.has_size_of(grid) {
            self.goal = Some(problem.goal);
            self.grid.replace(grid);
            self.nodes.clear();
            self.nodes.resize(grid.cells().len(), Node::NEW);
            self.open.clear();
            self.insert(grid.index(problem.goal), CellCost::ZERO);
            return;
        }
        if self.open.len() > self.nodes.len() {
            self.drop_outdated();
        }
        let mut kept = core::mem::take(&mut self.grid);
        for &index in kept.update(grid) {
            let Node { h, tag, .. } = self.nodes[index as usize];
            // From where no way is known nothing can be learnt.
            if tag == Tag::Closed && h != UNREACHED {
                self.insert(index, h);
            }
        }
        self.grid = kept;
    }

    fn is_current(&self, k: CellCost, index: u32) -> bool {
        let node = self.nodes[index as usize];
        node.tag == Tag::Open && node.k == k
    }

    fn drop_outdated(&mut self) {
        let mut entries = core::mem::take(&mut self.open).into_vec();
        entries.retain(|&Reverse((k, index))| self.is_current(k, index));
        entries.sort_unstable();
        entries.dedup();
        self.open = BinaryHeap::from(entries);
    }

    /// INSERT.
    fn insert(&mut self, index: u32, h: CellCost) {
        let node = &mut self.nodes[index as usize];
        let k = match node.tag {
            Tag::New => h,
            Tag::Open => node.k.min(h),
            Tag::Closed => node.h.min(h),
        };
        let is_in_place = node.tag == Tag::Open && node.k == k;
        *node = Node { h, k, tag: Tag::Open, ..*node };
        if !is_in_place {
            self.open.push(Reverse((k, index)));
            self.inserted += 1;
        }
    }

    /// The smallest k and its node, which stays in the list.
    fn first(&mut self) -> Option<(CellCost, u32)> {
        while let Some(&Reverse((k, index))) = self.open.peek() {
            if self.is_current(k, index) {
                return Some((k, index));
            }
            self.open.pop();
        }
        None
    }

    /// Runs PROCESS-STATE until the way from `start` is right; returns the number of nodes taken.
    fn repair(&mut self, grid: &PlanningGrid, start: u32) -> u64 {
        let mut taken = 0;
        while let Some((k, index)) = self.first() {
            if k >= self.nodes[start as usize].h {
                break;
            }
            self.open.pop();
            taken += 1;
            self.process(grid, index, k);
        }
        taken
    }

    /// PROCESS-STATE, for a node that has just been taken from the list with k = `k_old`.
    fn process(&mut self, grid: &PlanningGrid, x: u32, k_old: CellCost) {
        self.nodes[x as usize].tag = Tag::Closed;
        let allowed = Moves::allowed_if_passable(grid, x, self.corner_rule);
        // h of a node plus the arc, which is infinite where the step is not allowed; arcs cost the same both ways.
        let by_arc = |h: CellCost, y: u32, step: Move| {
            if h == UNREACHED || !allowed.contains(step) { UNREACHED } else { stepped(grid, h, x, y, step) }
        };
        if k_old < self.nodes[x as usize].h {
            for step in allowed {
                let y = step.index_from(grid, x);
                let h_y = self.nodes[y as usize].h;
                let by_y = by_arc(h_y, y, step);
                if h_y <= k_old && self.nodes[x as usize].h > by_y {
                    self.nodes[x as usize] = Node { h: by_y, next: Some(step), ..self.nodes[x as usize] };
                }
            }
        }
        let h_x = self.nodes[x as usize].h;
        // Also nodes to which no step is allowed: an arc that has gone was the way of some.
        for step in Move::ALL {
            let y = step.index_from(grid, x);
            let node = self.nodes[y as usize];
            let (by_x, back) = (by_arc(h_x, y, step), step.reversed());
            let leads_here = node.next == Some(back);
            let is_met_now = node.tag == Tag::New && by_x != UNREACHED;
            let improves = !leads_here && node.h > by_x;
            if is_met_now || leads_here && node.h != by_x || improves && k_old == h_x {
                self.nodes[y as usize].next = Some(back);
                self.insert(y, by_x);
            } else if k_old < h_x {
                if improves {
                    self.insert(x, h_x);
                } else if !leads_here && node.tag == Tag::Closed && node.h > k_old && h_x > by_arc(node.h, y, step) {
                    self.insert(y, node.h);
                }
            }
        }
    }

    /// The cells from `start` to the goal, along the pointers.
    fn trace(&self, grid: &PlanningGrid, start: u32, path: &mut Vec<Cell>) {
        let mut index = start;
        path.push(grid.cell(index));
        while let Some(step) = self.nodes[index as usize].next {
            let next = step.index_from(grid, index);
            assert!(self.nodes[next as usize].h < self.nodes[index as usize].h, "the way to the goal goes downhill");
            index = next;
            path.push(grid.cell(index));
        }
    }
}

impl GridPlanner for Planner {
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        path.clear();
        if let Err(failure) = problem.check_ends() {
            return Search { result: Err(failure), expanded: 0, generated: 0 };
        }
        let grid = problem.grid;
        let start = grid.index(problem.start);
        self.inserted = 0;
        self.adopt(problem);
        let expanded = self.repair(grid, start);
        let is_reached = self.nodes[start as usize].h != UNREACHED;
        if is_reached {
            self.trace(grid, start, path);
        }
        let result = if is_reached { Ok(()) } else { Err(Failure::NoPath) };
        Search { result, expanded, generated: self.inserted }
    }

    fn reset(&mut self) {
        self.goal = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::OccupancyGrid;
    use crate::plan::grid::tests::{drawn, stream, uninflated};

    #[test]
    fn a_corridor_is_raised_and_lowered_by_hand() {
        let (map, grid) = drawn(&["......"]);
        let cell = |col| Cell { col, row: 0 };
        let (mut planner, mut path, goal) = (Planner::new(&Params::default()), Vec::new(), cell(5));
        let mut search =
            |grid: &PlanningGrid, start| planner.search(&Problem { grid, start: cell(start), goal }, &mut path);
        // The goal and four cells are taken; then the smallest k is the start's h, 5, and the start stays in the list.
        let found = search(&grid, 0);
        assert_eq!((found.result, found.expanded, found.generated), (Ok(()), 5, 6));
        // Nothing depends on the robot.
        let found = search(&grid, 2);
        assert_eq!((found.result, found.expanded, found.generated), (Ok(()), 0, 0));
        let mut walled = map.clone();
        walled.set_occupied(cell(3));
        // (2), (3) and (4) are put back. (4) raises (3) to infinity, (3) raises (2), (2) raises (1), and (1) the cell (0), which was
        // in the list already: (4), (3), (2), (1), (0) are taken. In the list came (4), (3), (2), (1).
        let found = search(&uninflated(&walled), 2);
        assert_eq!((found.result, found.expanded, found.generated), (Err(Failure::NoPath), 5, 4));
        assert_eq!(search(&uninflated(&walled), 1).expanded, 0);
        // Freed: (4) is put back and lowers (3), that (2), which is as far as the robot is.
        let found = search(&grid, 2);
        assert_eq!((found.result, found.expanded, found.generated), (Ok(()), 2, 3));
        assert_eq!(path, [cell(2), cell(3), cell(4), cell(5)]);
    }

    #[test]
    fn the_list_stays_small_over_a_long_episode() {
        let mut stream = stream(64);
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
            assert!(planner.open.len() as u64 <= 32 * 32 + search.generated, "{}", planner.open.len());
        }
    }
}
