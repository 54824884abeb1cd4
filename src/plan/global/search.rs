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
//! **Memory.** One record of 8 bytes per padded cell (16 for real-valued costs), and the open list. Nothing is
//! cleared between searches: a record is valid if it bears the stamp of the current search. Both grow to the
//! largest map met and are kept.
//!
//! **Cost.** Planners of grid paths keep g as two counts ([`Steps`]), so equal paths have equal keys
//! whatever the order of their steps; planners of real-valued costs keep an `f64`.

mod cost;
mod kept;
mod lifelong;
mod marks;
mod moves;
mod open;
#[cfg(test)]
mod tests;

pub use cost::Heuristic;
pub(super) use cost::{CellCost, Cost, Steps, euclidean};
pub(super) use kept::KeptGrid;
pub(super) use lifelong::{Lifelong, UNREACHED, WhenMoved};
pub(super) use marks::Marks;
pub use moves::CornerRule;
pub(super) use moves::{Move, MoveTable, Moves};
pub(super) use open::{Buckets, Heap, OpenEntry, Priority, RealEntry, WholeEntry, WholeSteps};

use crate::map::Cell;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Failure, Problem, Search};
use crate::plan::grid::{ESCAPE, ESCAPE_FACTOR};
use open::OpenList;

/// A node that is being expanded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visit<C: Cost> {
    /// Its index in the padded grid.
    pub index: u32,
    /// Its cell.
    pub cell: Cell,
    /// The part of its parent that the node keeps.
    pub parent: C::Parent,
    /// The move that led to it; none for the start.
    pub arrived_by: Option<Move>,
}

/// A node that is about to be pushed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival<C: Cost> {
    /// Its cell.
    pub cell: Cell,
    /// Cost from the start.
    pub g: C,
    /// The node from which it was reached; none for the start.
    pub from: Option<Visit<C>>,
}

/// The rule that distinguishes one best-first planner from another, for one problem.
pub(super) trait Rule {
    /// Type of the costs.
    type Cost: Cost;
    /// Type of f.
    type Priority: Priority<Self::Cost>;

    /// Whether a closed node is opened again when a cheaper connection is found. A rule that never finds one may return either:
    /// `false` saves connecting the node, `true` a branch.
    fn reopens(&self) -> bool;

    /// The moves to try from a node.
    fn moves(&self, from: &Visit<Self::Cost>) -> Moves;

    /// Parent and cost of the node that `step` leads to from `from`; `stepped` is the cost by a plain step. `None` unless that is
    /// less than `known`, the cost of the node so far if it has been met.
    fn connect(
        &self,
        nodes: &Nodes<Self::Cost>,
        from: &Visit<Self::Cost>,
        step: Move,
        stepped: Self::Cost,
        known: Option<<Self::Cost as Cost>::Kept>,
    ) -> Option<(<Self::Cost as Cost>::Parent, Self::Cost)> {
        let _ = (nodes, step);
        let is_cheaper = known.is_none_or(|known| stepped.is_below(known));
        is_cheaper.then(|| (Self::Cost::parent(from.index), stepped))
    }

    /// The part h of f, where f is g + h in whole steps.
    fn estimate(&self, cell: Cell) -> Self::Cost {
        let _ = cell;
        Self::Cost::ZERO
    }

    /// f of a node: the node with the smallest f is expanded first.
    fn priority(&self, arrival: Arrival<Self::Cost>) -> Self::Priority;
}

/// Cost multiplier of a step; `bits` is the OR of its two cells.
fn step_factor(bits: u8) -> u32 {
    if bits & ESCAPE != 0 { ESCAPE_FACTOR } else { 1 }
}

/// A distance with the step between two nodes added.
pub(super) fn stepped(grid: &PlanningGrid, distance: CellCost, a: u32, b: u32, step: Move) -> CellCost {
    let factor = step_factor(grid.cells()[a as usize] | grid.cells()[b as usize]);
    distance.stepped(step.is_diagonal(), factor)
}

/// Record of a cell.
#[derive(Clone, Copy, Debug)]
struct Node<C: Cost> {
    g: C::Kept,
    parent: C::Parent,
    state: State,
}

/// The stamp of the search that met a node, whether it is closed, and the move that led to it: the larger, the more
/// is known in the current search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct State(u32);

impl State {
    const UNMET: Self = Self(0);
    /// Value of the four lowest bits, which hold the direction of a move, for no move.
    const NO_MOVE: u32 = 8;
    const CLOSED: u32 = 16;
    const ONE_SEARCH: u32 = 32;

    /// State of an open node that was reached by the move `by`; the start has none.
    fn opened(self, by: Option<Move>) -> Self {
        Self(self.0 | by.map_or(Self::NO_MOVE, |step| step.direction() as u32))
    }

    fn closed(self) -> Self {
        Self(self.0 | Self::CLOSED)
    }

    fn arrived_by(self) -> Option<Move> {
        Move::of_direction(self.0 % Self::CLOSED)
    }
}

/// Records of all cells.
#[derive(Debug)]
pub(super) struct Nodes<C: Cost> {
    of_cells: Vec<Node<C>>,
    /// Lower bound of this search: the state of every node that it has met is larger.
    search: State,
}

impl<C: Cost> Nodes<C> {
    /// The kept cost of a node that has been met in this search.
    pub fn g(&self, index: u32) -> C::Kept {
        self.of_cells[index as usize].g
    }

    /// Marks all nodes as unmet, and makes room for all nodes of `grid`.
    fn begin(&mut self, grid: &PlanningGrid) {
        if self.search.0 > u32::MAX - 2 * State::ONE_SEARCH {
            self.of_cells.clear();
            self.search = State::UNMET;
        }
        self.search.0 += State::ONE_SEARCH;
        if self.of_cells.len() < grid.cells().len() {
            let unmet = Node { g: C::Kept::default(), parent: C::Parent::default(), state: State::UNMET };
            self.of_cells.resize(grid.cells().len(), unmet);
        }
    }

    /// Index of the parent of a node; the start is its own parent.
    fn parent(&self, grid: &PlanningGrid, index: u32) -> u32 {
        let Node { parent, state, .. } = self.of_cells[index as usize];
        state.arrived_by().map_or(index, |step| C::parent_index(parent, step.index_before(grid, index)))
    }

    /// The cells from the start to `end`, along the parents.
    fn trace(&self, grid: &PlanningGrid, end: u32, path: &mut Vec<Cell>) {
        let mut index = end;
        path.push(grid.cell(index));
        while self.parent(grid, index) != index {
            index = self.parent(grid, index);
            path.push(grid.cell(index));
        }
        path.reverse();
    }
}

/// The memory of a search. Only its size carries over from one search to the next.
#[derive(Debug)]
pub(super) struct Workspace<C: Cost, O> {
    nodes: Nodes<C>,
    open: O,
}

impl<C: Cost, O: Default> Default for Workspace<C, O> {
    fn default() -> Self {
        Self { nodes: Nodes { of_cells: Vec::new(), search: State::UNMET }, open: O::default() }
    }
}

impl<C: Cost, O: OpenList> Workspace<C, O> {
    /// Finds a path by the rule; see the module. `path` then holds the cells from start to goal; it is empty on failure.
    pub fn search<R>(&mut self, rule: &R, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search
    where
        R: Rule<Cost = C>,
        R::Priority: Priority<C, Entry = O::Entry>,
    {
        path.clear();
        let mut search = Search { result: Err(Failure::NoPath), expanded: 0, generated: 0 };
        if let Err(failure) = problem.check_ends() {
            search.result = Err(failure);
            return search;
        }
        let grid = problem.grid;
        let (start, goal) = (grid.index(problem.start), grid.index(problem.goal));
        let offsets = moves::offsets(grid.stride());
        let steps_differ = grid.has_escape_zone();
        let Self { nodes, open } = self;
        nodes.begin(grid);
        open.clear();
        let (met, closed) = (nodes.search, nodes.search.closed());

        let parent = C::parent(start);
        nodes.of_cells[start as usize] = Node { g: C::ZERO.kept(), parent, state: met.opened(None) };
        let priority = rule.priority(Arrival { cell: problem.start, g: C::ZERO, from: None });
        open.push(priority.entry(C::ZERO, start));
        search.generated = 1;
        while let Some(entry) = open.pop() {
            let index = entry.index();
            let node = &mut nodes.of_cells[index as usize];
            if node.state >= closed || !R::Priority::may_have_cost(entry, node.g) {
                continue; // a cheaper entry of the same node came first
            }
            if index == goal {
                nodes.trace(grid, goal, path);
                search.result = Ok(());
                return search;
            }
            node.state = node.state.closed();
            search.expanded += 1;
            let Node { g: kept, parent, state } = *node;
            let from = Visit { index, cell: grid.cell(index), parent, arrived_by: state.arrived_by() };
            let g = R::Priority::cost(entry, kept, || rule.estimate(from.cell));
            for step in rule.moves(&from) {
                let to = index.wrapping_add_signed(offsets[step.direction()]);
                let known = nodes.of_cells[to as usize];
                if known.state >= closed && !rule.reopens() {
                    continue;
                }
                let factor = if steps_differ {
                    step_factor(grid.cells()[index as usize] | grid.cells()[to as usize])
                } else {
                    1
                };
                let stepped = g.stepped(step.is_diagonal(), factor);
                let known = (known.state >= met).then_some(known.g);
                let Some((parent, g)) = rule.connect(nodes, &from, step, stepped, known) else { continue };
                nodes.of_cells[to as usize] = Node { g: g.kept(), parent, state: met.opened(Some(step)) };
                let priority = rule.priority(Arrival { cell: step.from(from.cell), g, from: Some(from) });
                open.push(priority.entry(g, to));
                search.generated += 1;
            }
        }
        search
    }
}
