//! `jps`: jump point search. A* that runs along the lines of the grid instead of stepping from cell to cell, and
//! opens only the cells where a shortest path may have to turn.
//!
//! Source: D. Harabor, A. Grastien, "Online Graph Pruning for Pathfinding on Grid Maps", AAAI 2011; the same,
//! "Improving Jump Point Search", ICAPS 2014 (scanning in blocks of bits, pruning of intermediate points).
//!
//! ```text
//! Expand n, reached by the straight step d, under the corner rule `forbid`:
//!     natural:  go on by d
//!     forced:   where the cell behind and beside n is blocked and the one beside n is not,
//!               also go to that side, and diagonally forward to that side
//!     (the start goes all eight ways)
//! Straight:     run to the first cell that has a forced move, or the goal: a jump point. A blocked cell ends the run.
//! Diagonal:     at each cell of the run start straight runs in its two parts; what they meet is a jump point of n.
//! f = g + h     h: octile distance. Ties: larger g, then smaller row-major index.
//! ```
//!
//! **Blocks.** Rows are kept as bits, 64 cells to a word, and so are columns. One bit per cell and direction says
//! that a run stops there: blocked(c), or free(c) and blocked(c − 1) on a line beside it. So a run is a search for the
//! first set bit. The maps of bits are built where the grid differs from that of the call before, which is compared
//! byte by byte; nothing else is kept.
//!
//! The runs towards the goal come first, and the search ends as soon as the goal's cost is no more than the f in turn:
//! where the goal is in plain view, after a run or two.
//!
//! **Exact.** Each path is as long as that of `a_star`, compared in counts of steps; which one of
//! several shortest paths it is differs. Between two jump points it goes diagonally first, then straight. All cells
//! passed are given.
//!
//! **Counts.** Jump points taken from the open list count as expanded and those put into it as generated; cells that
//! are run over do not count. So the counts are no measure of work beside those of other planners.
//!
//! **Limits.** Only the corner rule `forbid`, and only one cost for all cells: where the grid has an escape zone the
//! plain rule of `a_star` searches instead (octile, `forbid`).
//!
//! Departures: none from the second paper; its preprocessed variant (JPS+) is not offered.
//!
//! When to use it: wherever only the length of the path counts. On maps with many single obstacles it gains least.

use super::GlobalKind;
use super::a_star::CostPlusOctile;
use super::search::{
    Buckets, CellCost, CornerRule, Cost, Heap, Move, Moves, OpenEntry, Priority, WholeEntry, WholeSteps, Workspace,
};
use crate::map::Cell;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, Failure, GlobalPlanner, GridPlanner, Problem, Search};
use crate::plan::grid::PASSABLE;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;

/// Parameters of `jps`: none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Jump point search: paths as short as those of a_star in a fraction of the time; no corners are cut.",
    source: "D. Harabor, A. Grastien, Online Graph Pruning for Pathfinding on Grid Maps, AAAI 2011; \
             Improving Jump Point Search, ICAPS 2014",
    exact: true,
    ..Entry::PLAIN
};

impl GlobalKind for Params {
    fn build(&self) -> Box<dyn GlobalPlanner> {
        Box::new(Planner::new(self))
    }
}

/// The planner.
#[derive(Debug, Default)]
pub struct Planner {
    lines: Lines,
    /// One node per padded cell.
    nodes: Vec<Node>,
    /// Number of this search; a node with another number has not been met.
    search: u32,
    /// Best first. Cheaper entries of a node are pushed beside the old ones.
    open: Heap<WholeEntry>,
    pushed: u64,
    /// Workspace of the plain search for grids with escape zones.
    plain: Workspace<CellCost, Buckets<WholeEntry>>,
}

/// Record of a cell.
#[derive(Clone, Copy, Debug)]
struct Node {
    g: CellCost,
    parent: u32,
    /// Number of the search that met the cell.
    search: u32,
    /// The last step to the cell; none for the start.
    arrived_by: Option<Move>,
    is_closed: bool,
}

/// A point of a run.
#[derive(Clone, Copy, Debug)]
struct Passed {
    cell: Cell,
    g: CellCost,
}

impl Planner {
    /// A fresh planner.
    pub fn new(_: &Params) -> Self {
        Self::default()
    }

    fn begin(&mut self, grid: &PlanningGrid) {
        self.lines.adopt(grid);
        self.open.clear();
        self.pushed = 0;
        if self.search == u32::MAX {
            self.nodes.clear();
            self.search = 0;
        }
        self.search += 1;
        if self.nodes.len() < grid.cells().len() {
            let unmet = Node { g: CellCost::ZERO, parent: 0, search: 0, arrived_by: None, is_closed: false };
            self.nodes.resize(grid.cells().len(), unmet);
        }
    }

    /// Opens a cell if this is its first connection or a cheaper one.
    fn open(&mut self, problem: &Problem<'_>, parent: u32, arrived_by: Option<Move>, Passed { cell, g }: Passed) {
        let index = problem.grid.index(cell);
        let node = &mut self.nodes[index as usize];
        if node.search == self.search && node.g <= g {
            return;
        }
        *node = Node { g, parent, search: self.search, arrived_by, is_closed: false };
        let h = CellCost::octile(cell, problem.goal);
        self.open.push(Reverse(WholeSteps { f: g.plus(h), h }.entry(g, index)));
        self.pushed += 1;
    }

    /// Runs from a cell by a straight step and opens the jump point, if there is one.
    fn run_straight(&mut self, problem: &Problem<'_>, parent: u32, step: Move, from: Passed) {
        if let Some(cell) = self.lines.jump(from.cell, step, problem.goal) {
            let g = from.g.plus(CellCost::octile(from.cell, cell));
            self.open(problem, parent, Some(step), Passed { cell, g });
        }
    }

    /// Runs from a cell by a diagonal step that is allowed there, and straight from each cell on the way.
    fn run_diagonally(&mut self, problem: &Problem<'_>, parent: u32, step: Move, from: Passed) {
        let parts = step.parts();
        let (mut at, mut index) = (from, parent);
        while Moves::allowed(problem.grid, index, CornerRule::Forbid).contains(step) {
            index = step.index_from(problem.grid, index);
            at = Passed { cell: step.from(at.cell), g: at.g.stepped(true, 1) };
            if at.cell == problem.goal {
                self.open(problem, parent, Some(step), at);
                return;
            }
            for part in parts {
                self.run_straight(problem, parent, part, at);
            }
        }
    }

    /// The cells from the start to the goal, those between jump points included.
    fn trace(&self, problem: &Problem<'_>, path: &mut Vec<Cell>) {
        let mut at = problem.goal;
        path.push(at);
        while at != problem.start {
            let parent = problem.grid.cell(self.nodes[problem.grid.index(at) as usize].parent);
            while at != parent {
                // Backwards: the straight part first, which is what one coordinate has more of.
                let (d_col, d_row) = (parent.col - at.col, parent.row - at.row);
                at.col += if d_col.abs() >= d_row.abs() { d_col.signum() } else { 0 };
                at.row += if d_row.abs() >= d_col.abs() { d_row.signum() } else { 0 };
                path.push(at);
            }
        }
        path.reverse();
    }
}

impl GridPlanner for Planner {
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        let grid = problem.grid;
        if grid.has_escape_zone() {
            return self.plain.search(&CostPlusOctile::new(problem, CornerRule::Forbid), problem, path);
        }
        path.clear();
        if let Err(failure) = problem.check_ends() {
            return Search { result: Err(failure), expanded: 0, generated: 0 };
        }
        self.begin(grid);
        let (start, goal) = (grid.index(problem.start), grid.index(problem.goal));
        let mut expanded = 0;
        self.open(problem, start, None, Passed { cell: problem.start, g: CellCost::ZERO });
        while let Some(Reverse(entry)) = self.open.pop() {
            let index = entry.index();
            let node = &mut self.nodes[index as usize];
            if node.is_closed {
                continue; // a cheaper entry of the same node came first
            }
            node.is_closed = true;
            let Node { g, arrived_by, .. } = *node;
            if index == goal {
                self.trace(problem, path);
                return Search { result: Ok(()), expanded, generated: self.pushed };
            }
            expanded += 1;
            let from = Passed { cell: grid.cell(index), g };
            let f = g.plus(CellCost::octile(from.cell, problem.goal));
            let moves = Moves::natural_and_forced(grid, index, CornerRule::Forbid, arrived_by);
            let towards_goal = Move::towards(from.cell, problem.goal).filter(|&step| moves.contains(step));
            for step in towards_goal.into_iter().chain(moves.filter(|&step| Some(step) != towards_goal)) {
                if step.is_diagonal() {
                    self.run_diagonally(problem, index, step, from);
                } else {
                    self.run_straight(problem, index, step, from);
                }
                // No path is shorter than the f in turn.
                let Node { g, search, .. } = self.nodes[goal as usize];
                if search == self.search && g <= f {
                    self.trace(problem, path);
                    return Search { result: Ok(()), expanded, generated: self.pushed };
                }
            }
        }
        Search { result: Err(Failure::NoPath), expanded, generated: self.pushed }
    }
}

/// Cells per word.
const WORD: usize = 64;

/// 64 cells of a row or column; bit k is the cell at k places from the first.
#[derive(Clone, Copy, Debug, Default)]
struct Word {
    free: u64,
    /// Places at which a run towards higher places stops.
    stops_up: u64,
    /// Places at which a run towards lower places stops.
    stops_down: u64,
}

/// The grid as bits, by rows and by columns, in padded places.
#[derive(Debug, Default)]
struct Lines {
    /// The cells of the grid from which the bits were made.
    cells: Vec<u8>,
    stride: usize,
    rows: Axis,
    cols: Axis,
}

/// All lines in one direction.
#[derive(Debug, Default)]
struct Axis {
    words: Vec<Word>,
    per_line: usize,
}

impl Lines {
    /// Makes the bits of a grid, unless they are those of this grid already.
    fn adopt(&mut self, grid: &PlanningGrid) {
        let (cells, stride) = (grid.cells(), grid.stride());
        if self.stride == stride && self.cells == cells {
            return;
        }
        self.cells.clear();
        self.cells.extend_from_slice(cells);
        self.stride = stride;
        let height = cells.len() / stride;
        self.rows.begin(height, stride);
        self.cols.begin(stride, height);
        let Self { rows, cols, .. } = self;
        for (words, cells) in rows.words.chunks_exact_mut(rows.per_line).zip(cells.chunks_exact(stride)) {
            for (word, cells) in words.iter_mut().zip(cells.chunks(WORD)) {
                word.free = packed(cells);
            }
        }
        // Blocks of 64 rows and 64 columns, transposed.
        for down in 0..cols.per_line {
            for across in 0..rows.per_line {
                let mut block = [0; WORD];
                for (line, row) in block.iter_mut().zip(down * WORD..height) {
                    *line = rows.words[row * rows.per_line + across].free;
                }
                transpose(&mut block);
                for (line, col) in block.iter().zip(across * WORD..stride) {
                    cols.words[col * cols.per_line + down].free = *line;
                }
            }
        }
        mark_stops(&mut rows.words, rows.per_line);
        mark_stops(&mut cols.words, cols.per_line);
    }

    /// The first jump point beyond a cell in the direction of a straight step: the goal, or a cell with a forced move.
    #[inline]
    fn jump(&self, from: Cell, step: Move, goal: Cell) -> Option<Cell> {
        let place = |coordinate: i32| (coordinate + 1) as usize;
        let (col, row) = (place(from.col), place(from.row));
        let goal_in_row = (goal.row == from.row).then(|| place(goal.col));
        let goal_in_col = (goal.col == from.col).then(|| place(goal.row));
        let in_row = |place: usize| Cell { col: place as i32 - 1, ..from };
        let in_col = |place: usize| Cell { row: place as i32 - 1, ..from };
        match step {
            Move::E => self.rows.run_up(row, col, goal_in_row).map(in_row),
            Move::W => self.rows.run_down(row, col, goal_in_row).map(in_row),
            Move::N => self.cols.run_up(col, row, goal_in_col).map(in_col),
            Move::S => self.cols.run_down(col, row, goal_in_col).map(in_col),
            _ => unreachable!("a straight step"),
        }
    }
}

impl Axis {
    /// Makes room for lines of some length, all blocked.
    fn begin(&mut self, lines: usize, length: usize) {
        self.per_line = length.div_ceil(WORD);
        self.words.clear();
        self.words.resize(lines * self.per_line, Word::default());
    }

    /// The first jump point above a place of a line; `goal` is the place of the goal if it lies on this line.
    fn run_up(&self, line: usize, place: usize, goal: Option<usize>) -> Option<usize> {
        let words = &self.words[line * self.per_line..][..self.per_line];
        // The first place where a run stops. The border is one, so there is one.
        let mut at = (place + 1) / WORD;
        let mut stops = words[at].stops_up & u64::MAX << ((place + 1) % WORD);
        while stops == 0 {
            at += 1;
            stops = words[at].stops_up;
        }
        let bit = stops.trailing_zeros() as usize;
        let stop = at * WORD + bit;
        match goal {
            Some(goal) if place < goal && goal < stop => Some(goal),
            _ => (words[at].free >> bit & 1 != 0).then_some(stop),
        }
    }

    /// The first jump point below a place of a line; `goal` is the place of the goal if it lies on this line.
    fn run_down(&self, line: usize, place: usize, goal: Option<usize>) -> Option<usize> {
        let words = &self.words[line * self.per_line..][..self.per_line];
        let mut at = (place - 1) / WORD;
        let mut stops = words[at].stops_down & u64::MAX >> (WORD - 1 - (place - 1) % WORD);
        while stops == 0 {
            at -= 1;
            stops = words[at].stops_down;
        }
        let bit = WORD - 1 - stops.leading_zeros() as usize;
        let stop = at * WORD + bit;
        match goal {
            Some(goal) if stop < goal && goal < place => Some(goal),
            _ => (words[at].free >> bit & 1 != 0).then_some(stop),
        }
    }
}

/// Computes from the free cells where runs stop. The first and the last line are border, where nothing runs.
fn mark_stops(words: &mut [Word], per_line: usize) {
    let free = |words: &[Word], at: usize| words.get(at).map_or(0, |word| word.free);
    for line in 1..(words.len() / per_line).saturating_sub(1) {
        for at in line * per_line..(line + 1) * per_line {
            // Free with a blocked cell before it. Beyond the ends of a line lies the blocked end of another.
            let forced_up =
                |at: usize| free(words, at) & !(free(words, at) << 1 | free(words, at.wrapping_sub(1)) >> (WORD - 1));
            let forced_down = |at: usize| free(words, at) & !(free(words, at) >> 1 | free(words, at + 1) << (WORD - 1));
            let blocked = !words[at].free;
            let stops_up = blocked | forced_up(at - per_line) | forced_up(at + per_line);
            let stops_down = blocked | forced_down(at - per_line) | forced_down(at + per_line);
            (words[at].stops_up, words[at].stops_down) = (stops_up, stops_down);
        }
    }
}

/// The passable ones of up to 64 cells as bits.
fn packed(cells: &[u8]) -> u64 {
    cells.iter().enumerate().fold(0, |bits, (k, &cell)| bits | u64::from(cell & PASSABLE) << k)
}

/// Swaps the rows and columns of a square of bits: halves, quarters and so on across the diagonal
/// (H. S. Warren, Hacker's Delight, 2nd edition, §7-3).
fn transpose(block: &mut [u64; WORD]) {
    let (mut width, mut low) = (WORD / 2, u64::MAX >> (WORD / 2));
    while width > 0 {
        for k in (0..WORD).filter(|k| k & width == 0) {
            let swapped = (block[k] >> width ^ block[k + width]) & low;
            block[k] ^= swapped << width;
            block[k + width] ^= swapped;
        }
        width /= 2;
        low ^= low << width;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::global::GlobalChoice;
    use crate::plan::global::search::Steps;
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};

    /// The steps of a path, each of which must be allowed.
    fn cost(grid: &PlanningGrid, path: &[Cell]) -> Steps {
        path.windows(2).fold(Steps::ZERO, |cost, pair| {
            let mut allowed = Moves::allowed(grid, grid.index(pair[0]), CornerRule::Forbid);
            let step = allowed.find(|step| step.from(pair[0]) == pair[1]).expect("an allowed step");
            cost.stepped(step.is_diagonal(), 1)
        })
    }

    #[test]
    fn paths_cost_what_those_of_a_star_do_on_maps_of_several_words() {
        let mut stream = stream(71);
        let mut planner = Planner::default();
        let mut reference = GlobalChoice::by_name("a_star").expect("defaults").build();
        let (mut found, mut jumped, mut stepped) = (0, 0, 0);
        for case in 0..400 {
            let share = [0.01, 0.1, 0.2, 0.35][case % 4];
            let mut map = random_map(&mut stream, 200, share);
            if case % 3 == 0 {
                // Walls with gaps, for long runs.
                for _ in 0..8 {
                    let (wall, gap) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
                    let along_row = stream.uniform() < 0.5;
                    for place in 0..if along_row { map.cols() } else { map.rows() } {
                        let cell = if along_row { Cell { col: place, ..wall } } else { Cell { row: place, ..wall } };
                        if cell.col != gap.col && cell.row != gap.row {
                            map.set_occupied(cell);
                        }
                    }
                }
            }
            let grid = uninflated(&map);
            for _ in 0..4 {
                let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
                let problem = Problem { grid: &grid, start, goal };
                let (mut path, mut expected_path) = (vec![start; 3], Vec::new());
                let search = planner.search(&problem, &mut path);
                let expected = reference.as_grid().expect("cells").search(&problem, &mut expected_path);
                assert_eq!(search.result, expected.result);
                assert_eq!(path.is_empty(), search.result.is_err());
                if search.result.is_ok() {
                    assert_eq!((path[0], path[path.len() - 1]), (start, goal));
                    assert_eq!(cost(&grid, &path), cost(&grid, &expected_path), "exactly");
                    found += 1;
                    jumped += search.expanded;
                    stepped += expected.expanded;
                }
            }
        }
        assert!(found > 500 && jumped < stepped / 2, "{found} {jumped} {stepped}");
    }

    #[test]
    fn a_run_stops_where_a_step_beside_it_is_forced() {
        let (_, grid) = drawn(&[
            ".......", //
            "..##...", //
            ".......", //
            ".......", //
        ]);
        let mut lines = Lines::default();
        lines.adopt(&grid);
        let goal = Cell { col: 6, row: 3 };
        let at = |col, row| Cell { col, row };
        let allowed = |from: Cell| Moves::allowed(&grid, grid.index(from), CornerRule::Forbid);
        let jump = |from: Cell, direction: usize| {
            let step = allowed(from).find(|step| step.direction() == direction).expect("allowed");
            lines.jump(from, step, goal)
        };
        let (east, north, west) = (0, 2, 4);
        // Below the wall: its end is passed at column 4 eastwards and at column 1 westwards, where the turn is.
        assert_eq!(jump(at(0, 1), east), Some(at(4, 1)));
        assert_eq!(jump(at(6, 1), west), Some(at(1, 1)));
        // Beside it, going up: the same.
        assert_eq!(jump(at(1, 0), north), Some(at(1, 3)));
        // Two rows below nothing is near.
        assert_eq!(jump(at(0, 0), east), None);
        // The goal stops a run that nothing else stops.
        assert_eq!(jump(at(4, 3), east), Some(goal));
        assert_eq!(jump(at(6, 0), north), Some(goal));
    }

    #[test]
    fn an_empty_map_takes_the_start_alone_and_goes_diagonally_first() {
        let (_, grid) = drawn(&["....", "....", "...."]);
        let (start, goal) = (Cell { col: 0, row: 0 }, Cell { col: 3, row: 1 });
        let mut path = Vec::new();
        let search = Planner::default().search(&Problem { grid: &grid, start, goal }, &mut path);
        assert_eq!((search.result, search.expanded, search.generated), (Ok(()), 1, 2));
        assert_eq!(path, [start, Cell { col: 1, row: 1 }, Cell { col: 2, row: 1 }, goal]);
    }

    #[test]
    fn where_there_is_an_escape_zone_it_is_a_star() {
        let (map, mut grid) = drawn(&[".......", ".iiiii.", "......."]);
        let (start, goal) = (Cell { col: 1, row: 1 }, Cell { col: 6, row: 1 });
        grid.open_around(&map, start);
        let problem = Problem { grid: &grid, start, goal };
        let (mut path, mut expected_path) = (Vec::new(), Vec::new());
        let mut reference = GlobalChoice::by_name("a_star").expect("defaults").build();
        let expected = reference.as_grid().expect("cells").search(&problem, &mut expected_path);
        assert_eq!(Planner::default().search(&problem, &mut path), expected);
        assert_eq!(path, expected_path);
    }

    #[test]
    fn transposing_swaps_rows_and_columns() {
        let mut stream = stream(72);
        let mut block: [u64; WORD] = core::array::from_fn(|_| (stream.uniform() * 9_007_199_254_740_992.0) as u64);
        let before = block;
        transpose(&mut block);
        for (row, line) in before.iter().enumerate() {
            for (col, column) in block.iter().enumerate() {
                assert_eq!(line >> col & 1, column >> row & 1);
            }
        }
    }
}
