//! The search that `lpa_star` and `d_star_lite` share: g and rhs of every node, a queue of the nodes where they differ, and
//! their repair where the grid has changed. The two differ in what becomes of the queue when the robot has moved on ([`WhenMoved`]).
//!
//! ```text
//! g(n)    distance of n from the root as known
//! rhs(n)  = min over the neighbours m of g(m) + c(m, n), 0 at the root        one step ahead of g
//! key(n)  = [min(g, rhs) + h(n) + km, min(g, rhs)]                            h: octile distance to the robot's cell
//! queue:  the nodes where g ≠ rhs, smallest key first, then smaller row-major index
//!
//! while the first key is below that of the robot's cell, or g ≠ rhs there
//!     take the first node n
//!     its key has grown since it was put in:  put it back with the key it has now
//!     g > rhs:  g = rhs                       and look at its neighbours again
//!     g < rhs:  g = ∞                         and look at n and its neighbours again
//! ```
//!
//! The root is the goal, for steps cost the same in both directions and the goal stays where it is. Another goal or another size of
//! the map starts from scratch.

use super::{CellCost, CornerRule, Cost, KeptGrid, Moves, stepped};
use crate::map::Cell;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Failure, Problem, Search};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What becomes of the queue when the robot has moved on, and with it h and all keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum WhenMoved {
    /// All keys are computed anew; km stays 0.
    OrderAnew,
    /// The keys stay, and km grows by the way gone: they are lower bounds, and nodes are put back when they are taken with one.
    Offset,
}

/// Distance of a node to which no way is known; larger than that of any path.
pub(in super::super) const UNREACHED: CellCost = CellCost(u64::MAX);

/// km above which the keys are computed anew after all, so that none overflows.
const OFFSET_MAX: CellCost = CellCost(u64::MAX / 4);

/// Record of a node: its distance from the root as stored (g), and as computed from its neighbours (rhs).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Vertex {
    g: CellCost,
    rhs: CellCost,
}

type Key = (CellCost, CellCost);

/// Key of a node of which nothing is known: larger than all others.
const LAST: Key = (UNREACHED, UNREACHED);

/// The search with all that it keeps between two calls.
#[derive(Debug)]
pub(in super::super) struct Lifelong {
    corner_rule: CornerRule,
    when_moved: WhenMoved,
    /// Root of the kept search; `None` if nothing is kept.
    goal: Option<Cell>,
    /// The robot's cell at the last call.
    start: Cell,
    /// km.
    offset: CellCost,
    grid: KeptGrid,
    vertices: Vec<Vertex>,
    /// All nodes with g ≠ rhs and their keys. It also holds outdated entries, recognised by their distance.
    queue: BinaryHeap<Reverse<(Key, u32)>>,
    pushed: u64,
}

impl Lifelong {
    /// A search that keeps nothing yet.
    pub fn new(corner_rule: CornerRule, when_moved: WhenMoved) -> Self {
        Self {
            corner_rule,
            when_moved,
            goal: None,
            start: Cell { col: 0, row: 0 },
            offset: CellCost::ZERO,
            grid: KeptGrid::default(),
            vertices: Vec::new(),
            queue: BinaryHeap::new(),
            pushed: 0,
        }
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        self.goal = None;
    }

    /// Number of entries in the queue, outdated ones included.
    #[cfg(test)]
    pub fn queue_len(&self) -> usize {
        self.queue.len()
    }

    /// Answers a problem by repairing what is kept: every node taken from the queue and not put back counts as expanded, every one
    /// put in or back as generated.
    pub fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
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

    /// Adapts the kept search to the problem: the root, the keys, the cells that changed.
    fn adopt(&mut self, problem: &Problem<'_>) {
        let grid = problem.grid;
        if self.goal != Some(problem.goal) || !self.grid.has_size_of(grid) {
            self.restart(problem);
            return;
        }
        let moved = CellCost::octile(self.start, problem.start);
        self.start = problem.start;
        let has_new_keys = match self.when_moved {
            WhenMoved::OrderAnew => moved != CellCost::ZERO,
            WhenMoved::Offset => {
                self.offset = self.offset.plus(moved);
                self.offset > OFFSET_MAX
            }
        };
        if has_new_keys || self.queue.len() > self.vertices.len() {
            self.order_queue_anew(grid);
        }
        let mut kept = core::mem::take(&mut self.grid);
        for &index in kept.update(grid) {
            self.look_ahead(grid, index);
        }
        self.grid = kept;
    }

    fn restart(&mut self, problem: &Problem<'_>) {
        let grid = problem.grid;
        (self.goal, self.start, self.offset) = (Some(problem.goal), problem.start, CellCost::ZERO);
        self.grid.replace(grid);
        self.vertices.clear();
        self.vertices.resize(grid.cells().len(), Vertex { g: UNREACHED, rhs: UNREACHED });
        self.queue.clear();
        self.set_rhs(grid, grid.index(problem.goal), CellCost::ZERO);
    }

    /// Gives every entry of the queue its current key, without offset, and drops the outdated ones.
    fn order_queue_anew(&mut self, grid: &PlanningGrid) {
        self.offset = CellCost::ZERO;
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
        (distance.plus(CellCost::octile(grid.cell(index), self.start)).plus(self.offset), distance)
    }

    /// Repairs g and rhs until the distance of `start` is right; returns the number of nodes expanded.
    fn repair(&mut self, grid: &PlanningGrid, start: u32) -> u64 {
        let mut expanded = 0;
        while let Some(&Reverse((key, index))) = self.queue.peek() {
            let current = self.key(grid, index);
            // An entry of another distance is not the last one of its node.
            let is_out_of_date = self.is_consistent(index) || key.1 != current.1;
            if !is_out_of_date && key >= self.key(grid, start) && self.is_consistent(start) {
                break;
            }
            self.queue.pop();
            if is_out_of_date {
                continue;
            }
            if key < current {
                self.push(grid, index);
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
        Moves::allowed_if_passable(grid, index, self.corner_rule)
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
