//! The search core: best-first search on the planning grid, shared by the planners.
//!
//! A planner is a [`Rule`]: which moves it tries, how it connects a node to the ones before, and in
//! which order nodes are expanded. [`Workspace::search`] does the rest:
//!
//! ```text
//! push the start
//! while a node can be popped                         smallest f, then larger g, then smaller row-major index
//!     if it is the goal, follow the parents back: done
//!     close it, count it as expanded
//!     for each move that the rule allows             E, NE, N, NW, W, SW, S, SE
//!         let the rule connect the node that the move leads to
//!         if that is its first connection or a cheaper one
//!             keep it, open the node (again), push it with the rule's f, count it as generated
//! ```
//!
//! Closed nodes are re-opened when a cheaper connection is found, unless the rule says that its
//! closed nodes are final; an equal cost never replaces a connection. The goal that ends a search is
//! not expanded, and an entry made worthless by a cheaper one is neither expanded nor counted.
//!
//! **Memory.** One record of 16 bytes per padded cell, and the open list. Nothing is cleared between
//! searches: a record is valid if it bears the stamp of the current search. Both grow to the
//! largest map met and are kept.
//!
//! **Cost.** Planners of grid paths keep g as two counts ([`Steps`]), so equal paths have equal keys
//! whatever the order of their steps; planners of real-valued costs keep an `f64`.

mod cost;
mod marks;
mod moves;
mod open;
#[cfg(test)]
mod tests;

pub use cost::Heuristic;
pub(super) use cost::{Cost, Steps};
pub(super) use marks::Marks;
pub use moves::CornerRule;
pub(super) use moves::{Move, Moves};

use super::{PlanFailure, Problem, Search};
use crate::map::Cell;
use crate::plan::PlanningGrid;
use crate::plan::grid::{ESCAPE, ESCAPE_FACTOR};
use open::{Open, Popped};

/// A node that is being expanded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visit<C> {
    /// Its index in the padded grid.
    pub index: u32,
    /// Its cell.
    pub cell: Cell,
    /// Cost from the start.
    pub g: C,
    /// Index of the node that it is connected to; its own for the start.
    pub parent: u32,
    /// The move that led to it, none for the start.
    pub arrived_by: Option<Move>,
}

/// A node that is about to be pushed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival<C> {
    /// Its cell.
    pub cell: Cell,
    /// Cost from the start.
    pub g: C,
    /// The node that it was reached from, none for the start.
    pub from: Option<Visit<C>>,
}

/// What distinguishes one best-first planner from another, for one problem.
pub(super) trait Rule {
    /// How costs are kept.
    type Cost: Cost;

    /// Whether a closed node is opened again when a cheaper connection is found. Where closed nodes
    /// are cheapest already, `false` saves the comparison.
    fn reopens(&self) -> bool;

    /// The moves to try from a node.
    fn moves(&self, from: &Visit<Self::Cost>) -> Moves;

    /// Parent and cost of the node that `step` leads to from `from`, where a plain step costs `stepped`.
    fn connect(
        &self,
        nodes: &Workspace<Self::Cost>,
        from: &Visit<Self::Cost>,
        step: Move,
        stepped: Self::Cost,
    ) -> (u32, Self::Cost) {
        let _ = (nodes, step);
        (from.index, stepped)
    }

    /// f: the node with the smallest is expanded first.
    fn priority(&self, arrival: Arrival<Self::Cost>) -> f64;
}

/// How many times its plain cost a step costs, given the bits of the cells at both its ends, joined by or.
pub(super) fn step_factor(bits: u8) -> u32 {
    if bits & ESCAPE != 0 { ESCAPE_FACTOR } else { 1 }
}

/// What is known of a cell.
#[derive(Clone, Copy, Debug)]
struct Node<C> {
    g: C,
    parent: u32,
    /// Even: opened in the search with that stamp; one more: closed in it. Smaller: not met in it.
    stamp: u32,
}

/// The memory of a search: carries nothing from one search to the next but its size.
#[derive(Debug)]
pub(super) struct Workspace<C> {
    nodes: Vec<Node<C>>,
    open: Open,
    stamp: u32,
}

impl<C: Cost> Default for Workspace<C> {
    fn default() -> Self {
        Self { nodes: Vec::new(), open: Open::default(), stamp: 0 }
    }
}

impl<C: Cost> Workspace<C> {
    /// Cost of a node that has been met in this search.
    pub fn g(&self, index: u32) -> C {
        self.nodes[index as usize].g
    }

    /// Finds a path by the rule; see the module. `path` holds start to goal, or nothing on failure.
    pub fn search<R: Rule<Cost = C>>(&mut self, rule: &R, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        path.clear();
        let mut search = Search { result: Err(PlanFailure::NoPath), expanded: 0, generated: 0 };
        if let Err(failure) = problem.check_ends() {
            search.result = Err(failure);
            return search;
        }
        let grid = problem.grid;
        let (start, goal) = (grid.index(problem.start), grid.index(problem.goal));
        let offsets = moves::offsets(grid.stride());
        self.begin(grid);
        let opened = self.stamp;
        let closed = opened + 1;

        self.nodes[start as usize] = Node { g: C::ZERO, parent: start, stamp: opened };
        self.open.push(
            rule.priority(Arrival { cell: problem.start, g: C::ZERO, from: None }),
            C::ZERO.value(),
            start,
            None,
        );
        search.generated = 1;
        while let Some(Popped { index, g, arrived_by }) = self.open.pop() {
            let node = &mut self.nodes[index as usize];
            if node.stamp == closed || node.g.value() != g {
                continue; // a cheaper entry of the same node came first
            }
            if index == goal {
                self.trace(grid, goal, path);
                search.result = Ok(());
                return search;
            }
            node.stamp = closed;
            search.expanded += 1;
            let from = Visit { index, cell: grid.cell(index), g: node.g, parent: node.parent, arrived_by };
            let from_bits = grid.cells()[index as usize];
            for step in rule.moves(&from) {
                let to = index.wrapping_add_signed(offsets[step.direction()]);
                let known = self.nodes[to as usize];
                if known.stamp == closed && !rule.reopens() {
                    continue;
                }
                let factor = step_factor(from_bits | grid.cells()[to as usize]);
                let stepped = from.g.stepped(step.is_diagonal(), factor);
                let (parent, g) = rule.connect(self, &from, step, stepped);
                if known.stamp >= opened && known.g.value() <= g.value() {
                    continue;
                }
                self.nodes[to as usize] = Node { g, parent, stamp: opened };
                let f = rule.priority(Arrival { cell: step.from(from.cell), g, from: Some(from) });
                self.open.push(f, g.value(), to, Some(step));
                search.generated += 1;
            }
        }
        search
    }

    /// Makes all nodes unmet, and enough of them.
    fn begin(&mut self, grid: &PlanningGrid) {
        const UNMET: u32 = 0;
        self.open.clear();
        if self.stamp >= u32::MAX - 3 {
            self.nodes.clear();
            self.stamp = UNMET;
        }
        self.stamp += 2;
        if self.nodes.len() < grid.cells().len() {
            self.nodes.resize(grid.cells().len(), Node { g: C::ZERO, parent: 0, stamp: UNMET });
        }
    }

    /// The cells from the start to `end`, along the parents.
    fn trace(&self, grid: &PlanningGrid, end: u32, path: &mut Vec<Cell>) {
        let mut index = end;
        path.push(grid.cell(index));
        while self.nodes[index as usize].parent != index {
            index = self.nodes[index as usize].parent;
            path.push(grid.cell(index));
        }
        path.reverse();
    }
}
