//! The planning grid: cells in which the centre of the robot may be, and lines of sight between them.
//!
//! One byte per cell in a flat row-major array with a border of one blocked cell all around, so
//! that neither searches nor lines of sight ever test for the edge of the map. A second byte says which
//! of its eight neighbours are passable, so that a search looks at one place to know where it can go.

use super::clearance::{DISTANCE_SLACK_M, Obstacles, segment_square_distance, segments_distance};
use crate::geometry::{Rect, Vec2, point_segment_distance};
use crate::map::{Cell, DistanceField, OccupancyGrid, SIDE_MAX};
use crate::math;

/// Passability of a cell of the planning grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passability {
    /// Never enterable.
    Blocked,
    /// Enterable at its plain cost.
    Free,
    /// Inside the inflated zone around a start or goal: a step from or to it costs ten times as much.
    Escape,
}

/// The byte of a cell that is never enterable.
pub(super) const BLOCKED: u8 = 0;
/// Bit of a passable cell.
pub(super) const PASSABLE: u8 = 0b001;
/// Bit of a cell of an escape zone, beside [`PASSABLE`].
pub(super) const ESCAPE: u8 = 0b010;
/// Mark of a cell that [`PlanningGrid::open_around`] is about to open; not passable, and cleared before it returns.
const OPENING: u8 = 0b100;

/// Cost multiplier of a step from or to a cell of an escape zone.
pub const ESCAPE_FACTOR: u32 = 10;

/// Points are rounded to this fraction of a cell before their sight is computed in integers.
/// Cell centres and corners are represented exactly; products of two coordinates of a map of
/// [`SIDE_MAX`] cells stay below 2⁶¹.
const UNITS_PER_CELL: i64 = 1 << 16;

/// Binary places of the factor that stands for a division by the stride.
///
/// It is too large by less than 2^-44, hence a quotient by less than 2^(29 - 44): an index has 29 bits. The next whole
/// number is at least 1 / stride > 2^-15 away, so rounding down gives the row. Products stay below 2^59.
const ROW_BITS: u32 = 44;

/// Cells in which the centre of the robot may be, with a blocked border around the map.
#[derive(Clone, Debug, Default)]
pub struct PlanningGrid {
    cols: i32,
    rows: i32,
    resolution_m: f64,
    /// Padded, row-major, `(cols + 2) * (rows + 2)`.
    cells: Vec<u8>,
    /// Bit k: the neighbour in direction k (E, NE, N, NW, W, SW, S, SE) is passable. Padded like `cells`; 0 in the border.
    around: Vec<u8>,
    /// 2^[`ROW_BITS`] / stride, rounded up.
    row_factor: u64,
    /// Cells of the last escape zone opened, in a buffer that is reused.
    zone: Vec<u32>,
    inflation_m: f64,
    /// The distance field of the map, row-major without a border.
    squares: Vec<u32>,
    /// Padded like `cells`, empty without inflation: what a line through the cell has to look at, see [`Near`].
    near: Vec<u8>,
    /// Workspace of [`Self::look_for_corners`].
    corners: Vec<u8>,
    /// What [`Self::block_capsule`] has blocked.
    capsules: Vec<Capsule>,
}

/// Bits of [`PlanningGrid::near`].
///
/// A line whose ends keep the inflation can lose it only at a convex corner of the obstacles, or where it enters one: along
/// their sides the distance has no least value between the ends. So most cells have nothing to look at.
struct Near;

impl Near {
    /// The cell is an obstacle, or outside.
    const OBSTACLE: u8 = 0x80;
    /// Where the inflation is wider than a cell: some corner is within it of the cell. Else the first of four bits, for the cell's
    /// own corners that are corners of obstacles: lower left, lower right, upper left, upper right.
    const CORNER: u8 = 0x01;
}

/// The points nearer than `radius_m` to the segment a–b.
#[derive(Clone, Copy, Debug)]
struct Capsule {
    a: Vec2,
    b: Vec2,
    radius_m: f64,
}

impl Capsule {
    /// The distance from the segment a–b that has to be kept on the straight way between `from` and `to`: as much of the radius as
    /// both leave.
    fn needed_m(&self, from: Vec2, to: Vec2) -> f64 {
        let away = |p: Vec2| point_segment_distance(p, self.a, self.b);
        math::min(self.radius_m, math::min(away(from), away(to)))
    }
}

impl PlanningGrid {
    /// A cell is blocked if it is occupied or its centre is nearer than `inflation_m` to an
    /// occupied square (the border of the map counts as occupied).
    ///
    /// # Panics
    /// If a side is longer than [`SIDE_MAX`] cells.
    pub fn new(grid: &OccupancyGrid, field: &DistanceField, inflation_m: f64) -> Self {
        let mut planning = Self::default();
        planning.rebuild(grid, field, inflation_m);
        planning
    }

    /// Builds the grid anew as [`Self::new`] does, reusing the memory. Escape zones are closed again.
    ///
    /// # Panics
    /// If a side is longer than [`SIDE_MAX`] cells.
    pub fn rebuild(&mut self, grid: &OccupancyGrid, field: &DistanceField, inflation_m: f64) {
        let side = grid.cols().max(grid.rows()) as usize;
        assert!(side <= SIDE_MAX, "a planning grid has at most {SIDE_MAX} cells a side");
        self.cols = grid.cols();
        self.rows = grid.rows();
        self.resolution_m = grid.resolution_m();
        self.zone.clear();
        self.inflation_m = inflation_m;
        self.capsules.clear();
        self.squares.clear();
        self.squares.extend_from_slice(field.squares());
        self.look_for_corners();
        let stride = self.stride();
        self.row_factor = (1u64 << ROW_BITS).div_ceil(stride as u64);
        self.cells.clear();
        self.cells.resize(stride * (self.rows as usize + 2), BLOCKED);
        let cols = self.cols as usize;
        let padded_rows = self.cells[stride..].chunks_exact_mut(stride).map(|row| &mut row[1..=cols]);
        let rows = padded_rows.zip(grid.occupied().chunks_exact(cols));
        let passable = |is_free: bool| if is_free { PASSABLE } else { BLOCKED };
        if inflation_m > 0.0 {
            let least = field.threshold(inflation_m);
            for ((cells, occupied), squares) in rows.zip(field.squares().chunks_exact(cols)) {
                for ((cell, &occupied), &square) in cells.iter_mut().zip(occupied).zip(squares) {
                    *cell = passable(!occupied & (square >= least));
                }
            }
        } else {
            for (cells, occupied) in rows {
                for (cell, &occupied) in cells.iter_mut().zip(occupied) {
                    *cell = passable(!occupied);
                }
            }
        }
        self.around.clear();
        self.around.resize(self.cells.len(), 0);
        self.look_around(0..self.rows as usize);
    }

    /// Works out [`Self::near`] from the squares.
    fn look_for_corners(&mut self) {
        self.near.clear();
        if self.inflation_m <= 0.0 {
            return;
        }
        let (stride, cols) = (self.stride(), self.cols as usize);
        self.near.resize(stride * (self.rows as usize + 2), Near::OBSTACLE);
        let padded_rows = self.near[stride..].chunks_exact_mut(stride).map(|row| &mut row[1..=cols]);
        for (row, squares) in padded_rows.zip(self.squares.chunks_exact(cols)) {
            for (near, &square) in row.iter_mut().zip(squares) {
                *near = if square == 0 { Near::OBSTACLE } else { 0 };
            }
        }
        // The corner at the lower left of each cell: of the four cells around it, one obstacle has both neighbours free.
        self.corners.clear();
        self.corners.resize(self.near.len(), 0);
        let (near, count) = (&self.near, self.near.len());
        let around = near[stride + 1..].iter().zip(&near[stride..]).zip(near[1..].iter().zip(near));
        for (corner, ((&ur, &ul), (&lr, &ll))) in self.corners[stride + 1..].iter_mut().zip(around) {
            let convex = (ur & !ul & !lr) | (ul & !ur & !ll) | (lr & !ll & !ur) | (ll & !lr & !ul);
            *corner = convex >> 7;
        }
        let reach =
            math::min((self.inflation_m / self.resolution_m).floor(), f64::from(self.cols.max(self.rows))) as usize;
        if reach == 0 {
            let corners = &self.corners;
            let at = |offset: usize| &corners[offset..];
            let own = at(0).iter().zip(at(1)).zip(at(stride).iter().zip(at(stride + 1)));
            for (near, ((ll, lr), (ul, ur))) in self.near.iter_mut().zip(own) {
                *near |= ll | lr << 1 | ul << 2 | ur << 3;
            }
            return;
        }
        // Any corner in a box around the cell; beyond the end of a row the next one begins, which finds too many and never too few.
        for step in [1, stride] {
            let width = 2 * reach + 2;
            let mut widened = 1;
            while widened < width {
                let by = widened.min(width - widened);
                for at in 0..count.saturating_sub(by * step) {
                    self.corners[at] |= self.corners[at + by * step];
                }
                widened += by;
            }
        }
        let back = reach * (stride + 1);
        for (at, near) in self.near.iter_mut().enumerate() {
            *near |= if at < back { Near::CORNER } else { self.corners[at - back] };
        }
    }

    /// Works out which neighbours are passable for the cells of some rows of the map.
    fn look_around(&mut self, rows: core::ops::Range<usize>) {
        let stride = self.stride();
        let (begin, end) = (rows.start * stride, rows.end * stride);
        let line = |after: usize| self.cells[begin + after..].chunks_exact(stride);
        let lines = line(0).zip(line(stride)).zip(line(2 * stride));
        let around = self.around[begin + stride..end + stride].chunks_exact_mut(stride);
        for (((below, here), above), around) in lines.zip(around) {
            for col in 1..stride - 1 {
                let bit = |cell: u8, direction: u32| (cell & PASSABLE) << direction;
                around[col] = bit(here[col + 1], 0)
                    | bit(above[col + 1], 1)
                    | bit(above[col], 2)
                    | bit(above[col - 1], 3)
                    | bit(here[col - 1], 4)
                    | bit(below[col - 1], 5)
                    | bit(below[col], 6)
                    | bit(below[col + 1], 7);
            }
        }
    }

    /// Opens an escape zone where `cell` is blocked by inflation alone: the connected inflated but
    /// unoccupied cells around it become passable, as far as free space is away from it.
    ///
    /// Connected means through the four edges of the cells. The zone holds the cells that are no more
    /// steps away than the first one that has a free neighbour: the inflated cells beyond belong to
    /// passages that are too narrow for the robot, which it has no reason to enter. Where no free
    /// cell can be reached the whole of the connected cells is opened. A free or occupied cell, or one
    /// outside, changes nothing.
    ///
    /// # Panics
    /// If `grid` has not the size of the map that this one was built from.
    pub fn open_around(&mut self, grid: &OccupancyGrid, cell: Cell) {
        assert!((grid.cols(), grid.rows()) == (self.cols, self.rows), "the map that the planning grid was built from");
        if self.passability(cell) != Passability::Blocked || !grid.is_free(cell) {
            return;
        }
        let stride = self.stride() as u32;
        let mut zone = core::mem::take(&mut self.zone);
        zone.clear();
        zone.push(self.index(cell));
        self.cells[zone[0] as usize] = OPENING;
        // Breadth first, one layer of equally many steps at a time.
        let (mut layer, mut reached_free_space) = (0..1, false);
        while !layer.is_empty() && !reached_free_space {
            for at in layer.clone() {
                for next in [zone[at] + 1, zone[at] - 1, zone[at] + stride, zone[at] - stride] {
                    match self.cells[next as usize] {
                        BLOCKED if grid.is_free(self.cell(next)) => {
                            self.cells[next as usize] = OPENING;
                            zone.push(next);
                        }
                        // An escape zone opened earlier leads to free space as well.
                        bits => reached_free_space |= bits & PASSABLE != 0,
                    }
                }
            }
            layer = layer.end..zone.len();
        }
        for (at, &index) in zone.iter().enumerate() {
            // The last layer lies beyond the cell that touches free space.
            let beyond = reached_free_space && layer.contains(&at);
            self.cells[index as usize] = if beyond { BLOCKED } else { PASSABLE | ESCAPE };
        }
        // The rows of the zone, and the one on either side.
        let rows = zone.iter().map(|&index| self.cell(index).row as usize);
        let (first, last) = rows.fold((usize::MAX, 0), |(first, last), row| (first.min(row), last.max(row)));
        self.look_around(first.saturating_sub(1)..(last + 2).min(self.rows as usize));
        self.zone = zone;
    }

    /// Blocks every free cell that has a blocked neighbour, across an edge or, with `across_corners`, a vertex. Cells of escape zones
    /// and those of `spared` stay as they are; the border of the map blocks nothing.
    pub(super) fn dilate(&mut self, across_corners: bool, spared: [Cell; 2]) {
        const EDGES: u8 = 0b0101_0101;
        // Bits of the neighbours in a row or column, see `around`.
        const EAST: u8 = 0b1000_0011;
        const NORTH: u8 = 0b0000_1110;
        const WEST: u8 = 0b0011_1000;
        const SOUTH: u8 = 0b1110_0000;
        let spared = spared.map(|cell| if self.contains(cell) { self.index(cell) } else { 0 });
        for row in 0..self.rows {
            for col in 0..self.cols {
                let index = self.index(Cell { col, row });
                let outside = if col == 0 { WEST } else { 0 }
                    | if col == self.cols - 1 { EAST } else { 0 }
                    | if row == 0 { SOUTH } else { 0 }
                    | if row == self.rows - 1 { NORTH } else { 0 };
                let asked = if across_corners { u8::MAX } else { EDGES } & !outside;
                let is_beside = !self.around[index as usize] & asked != 0;
                if is_beside && self.cells[index as usize] == PASSABLE && !spared.contains(&index) {
                    self.cells[index as usize] = BLOCKED;
                }
            }
        }
        self.look_around(0..self.rows as usize);
    }

    /// Number of columns.
    pub fn cols(&self) -> i32 {
        self.cols
    }

    /// Number of rows.
    pub fn rows(&self) -> i32 {
        self.rows
    }

    /// Side of a cell, m.
    pub fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    /// Passability of a cell; cells outside the map are blocked.
    pub fn passability(&self, cell: Cell) -> Passability {
        if !self.contains(cell) {
            return Passability::Blocked;
        }
        match self.cells[self.index(cell) as usize] {
            bits if bits & ESCAPE != 0 => Passability::Escape,
            PASSABLE => Passability::Free,
            _ => Passability::Blocked,
        }
    }

    /// Whether the robot's centre may be in the cell: it is free or part of an escape zone.
    pub fn is_passable(&self, cell: Cell) -> bool {
        self.passability(cell) != Passability::Blocked
    }

    /// The cell that holds a point of the grid frame, also outside the map.
    pub fn cell_at(&self, p: Vec2) -> Cell {
        Cell { col: (p.x / self.resolution_m).floor() as i32, row: (p.y / self.resolution_m).floor() as i32 }
    }

    /// Blocks every cell whose centre is nearer than `radius_m` to the segment a–b (grid frame, m).
    pub fn block_capsule(&mut self, a: Vec2, b: Vec2, radius_m: f64) {
        let (low, high) = (
            self.cell_at(lowest(a, b) - Vec2::new(radius_m, radius_m)),
            self.cell_at(highest(a, b) + Vec2::new(radius_m, radius_m)),
        );
        let (rows, cols) =
            (low.row.max(0)..(high.row + 1).min(self.rows), low.col.max(0)..(high.col + 1).min(self.cols));
        for row in rows.clone() {
            for col in cols.clone() {
                let cell = Cell { col, row };
                if point_segment_distance(self.centre(cell), a, b) < radius_m {
                    let index = self.index(cell) as usize;
                    self.cells[index] = BLOCKED;
                }
            }
        }
        self.capsules.push(Capsule { a, b, radius_m });
        if !rows.is_empty() {
            let (first, last) = (rows.start as usize, rows.end as usize);
            self.look_around(first.saturating_sub(1)..(last + 1).min(self.rows as usize));
        }
    }

    /// Centre of a cell, grid frame, metres.
    pub fn centre(&self, cell: Cell) -> Vec2 {
        Vec2::new((f64::from(cell.col) + 0.5) * self.resolution_m, (f64::from(cell.row) + 0.5) * self.resolution_m)
    }

    /// The distance that centres of passable cells keep from obstacle squares, m; 0 where clearance is not the grid's business.
    pub fn inflation_m(&self) -> f64 {
        self.inflation_m
    }

    /// The obstacle squares of the map, from which lines keep the inflation; none without inflation, when blocked cells are all that
    /// counts.
    pub fn obstacles(&self) -> Option<Obstacles<'_>> {
        let known = || Obstacles::of_squares(&self.squares, self.cols, self.rows, self.resolution_m);
        (self.inflation_m > 0.0).then(known)
    }

    /// Whether the robot can go straight from a to b (grid frame, m): the segment keeps the inflation from obstacle squares, and
    /// from movers that block cells what they block, as far as both its ends do. Exact, to 1e-9 m. Without inflation it is
    /// [`Self::line_of_sight`].
    ///
    /// It is the rule for everything that is planned or steered for, and kinder than [`Self::line_of_sight`]: a blocked cell is
    /// not obstacle all over, nor is a passable one clear all over.
    pub fn is_clear(&self, a: Vec2, b: Vec2) -> bool {
        self.is_clear_to(a, b, self.inflation_m)
    }

    /// As [`Self::is_clear`] for a clearance of `clearance_m` where that is less than the inflation: for a line in place of a
    /// path that has no more.
    pub fn is_clear_to(&self, a: Vec2, b: Vec2, clearance_m: f64) -> bool {
        let Some(obstacles) = self.obstacles() else { return self.line_of_sight(a, b) };
        obstacles.keeps_as_its_ends(a, b, math::min(clearance_m, self.inflation_m)) && self.passes_movers(a, b)
    }

    /// As [`Self::is_clear`] between the centres of two cells that are free: neither blocked nor in an escape zone.
    pub fn is_clear_cells_free(&self, a: Cell, b: Cell) -> bool {
        if self.near.is_empty() {
            return self.line_of_sight_cells_free(a, b);
        }
        let is_free = |cell: Cell| self.contains(cell) && self.cells[self.index(cell) as usize] == PASSABLE;
        is_free(a)
            && is_free(b)
            && (if self.inflation_m < self.resolution_m {
                self.keeps_off_own_corners(a, b)
            } else {
                self.keeps_off_corners(a, b)
            })
            && (self.capsules.is_empty() || self.passes_movers(self.centre(a), self.centre(b)))
    }

    /// Whether the line between two free cells keeps the inflation, which is less than a cell: no corner of a cell that it touches
    /// is nearer. Whole numbers, but for the inflation.
    fn keeps_off_own_corners(&self, a: Cell, b: Cell) -> bool {
        let (d_col, d_row) = (i64::from(b.col - a.col), i64::from(b.row - a.row));
        let squared = d_col * d_col + d_row * d_row;
        // In half cells: a corner at r from a is |d × r| / |d| away from the line, where its foot is on the line.
        let needed = 2.0 * (self.inflation_m - DISTANCE_SLACK_M) / self.resolution_m;
        let cross_squared_min = needed * needed * squared as f64;
        let is_off = |corner: (i64, i64)| {
            let (x, y) = corner;
            let along = d_col * x + d_row * y;
            let cross = (d_col * y - d_row * x) as f64;
            cross * cross >= cross_squared_min || along <= 0 || along >= 2 * squared
        };
        self.walk(a, b, |index, (col, row)| {
            let near = self.near[index];
            near == 0
                || near < Near::OBSTACLE && {
                    let (x, y) = (2 * col - 1, 2 * row - 1);
                    (near & 1 == 0 || is_off((x, y)))
                        && (near & 2 == 0 || is_off((x + 2, y)))
                        && (near & 4 == 0 || is_off((x, y + 2)))
                        && (near & 8 == 0 || is_off((x + 2, y + 2)))
                }
        })
    }

    /// Whether the line between two free cells keeps the inflation: the stretch of it that has corners around is measured.
    fn keeps_off_corners(&self, a: Cell, b: Cell) -> bool {
        let mut stretch: Option<((i64, i64), (i64, i64))> = None;
        let is_free = self.walk(a, b, |index, at| {
            let near = self.near[index];
            if near != 0 {
                stretch = Some((stretch.map_or(at, |(first, _)| first), at));
            }
            near < Near::OBSTACLE
        });
        let Some(((first, last), obstacles)) = stretch.zip(self.obstacles()).filter(|_| is_free) else {
            return is_free;
        };
        let (from, to) = (self.centre(a), self.centre(b));
        let d = to - from;
        let length = d.norm();
        if length == 0.0 {
            return true;
        }
        // From a cell's diagonal before the first to one beyond the last.
        let along_m = |at: (i64, i64)| self.resolution_m * Vec2::new(at.0 as f64, at.1 as f64).dot(&d) / length;
        let point = |along_m: f64| from + d * (math::clamp(along_m, 0.0, length) / length);
        obstacles.keeps(
            point(along_m(first) - self.resolution_m),
            point(along_m(last) + self.resolution_m),
            self.inflation_m,
        )
    }

    /// Walks from cell to cell along the line between the centres of two cells of the map and asks each one by its index and its
    /// offset from a, until one says no. Where the line passes a vertex, both cells beside it have to be no obstacles.
    #[inline(always)]
    fn walk(&self, a: Cell, b: Cell, mut is_clear: impl FnMut(usize, (i64, i64)) -> bool) -> bool {
        let (d_col, d_row) = (i64::from(b.col - a.col), i64::from(b.row - a.row));
        let (step_col, step_row) = (d_col.signum(), d_row.signum());
        let (skip_col, skip_row) = (step_col as isize, step_row as isize * self.stride() as isize);
        let (cols, rows) = (d_col.abs(), d_row.abs());
        let mut index = self.index(a) as isize;
        let mut at = (0, 0);
        // As in `sees`.
        let mut lead = rows - cols;
        let mut lines_left = cols + rows;
        let mut clear = is_clear(index as usize, at);
        while clear && lines_left > 0 {
            if lead < 0 {
                index += skip_col;
                at.0 += step_col;
                lead += 2 * rows;
                lines_left -= 1;
            } else if lead > 0 {
                index += skip_row;
                at.1 += step_row;
                lead -= 2 * cols;
                lines_left -= 1;
            } else {
                let is_obstacle = |beside: isize| self.near[(index + beside) as usize] >= Near::OBSTACLE;
                if is_obstacle(skip_col) || is_obstacle(skip_row) {
                    return false;
                }
                index += skip_col + skip_row;
                at = (at.0 + step_col, at.1 + step_row);
                lead += 2 * (rows - cols);
                lines_left -= 2;
            }
            clear = is_clear(index as usize, at);
        }
        clear
    }

    /// Distance between the segment a–b and the nearest obstacle square, m, or the inflation if that is less; 0 where they touch.
    pub fn clearance(&self, a: Vec2, b: Vec2) -> f64 {
        self.obstacles().map_or(0.0, |obstacles| obstacles.segment_clearance(a, b, self.inflation_m))
    }

    /// Whether a segment keeps from movers that block cells what they block, as far as both its ends do.
    fn passes_movers(&self, a: Vec2, b: Vec2) -> bool {
        self.capsules
            .iter()
            .all(|capsule| segments_distance(a, b, capsule.a, capsule.b) >= capsule.needed_m(a, b) - DISTANCE_SLACK_M)
    }

    /// Whether the segment a–b keeps from movers that block cells what they block, as far as `from` and `to` do.
    pub(super) fn passes_movers_between(&self, a: Vec2, b: Vec2, from: Vec2, to: Vec2) -> bool {
        self.capsules.iter().all(|capsule| {
            segments_distance(a, b, capsule.a, capsule.b) >= capsule.needed_m(from, to) - DISTANCE_SLACK_M
        })
    }

    /// Whether the segment between the centres of two cells touches no blocked cell.
    ///
    /// Exact (integers only), symmetric in its ends. Every cell whose closed square the segment
    /// touches counts, so a segment through a shared vertex touches all four cells around it
    /// (`systems.md` §1.2). Cells of escape zones do not block the view. A cell outside sees nothing.
    pub fn line_of_sight_cells(&self, a: Cell, b: Cell) -> bool {
        self.sees(a, b, |bits| bits & PASSABLE != 0)
    }

    /// As [`Self::line_of_sight_cells`], with cells of escape zones blocking the view as well.
    pub fn line_of_sight_cells_free(&self, a: Cell, b: Cell) -> bool {
        self.sees(a, b, |bits| bits == PASSABLE)
    }

    /// Walks from cell to cell along the segment and asks each one.
    fn sees(&self, a: Cell, b: Cell, is_clear: impl Fn(u8) -> bool) -> bool {
        if !(self.contains(a) && self.contains(b)) {
            return false;
        }
        let (d_col, d_row) = (b.col - a.col, b.row - a.row);
        let (step_col, step_row) = (d_col.signum() as isize, d_row.signum() as isize * self.stride() as isize);
        let (cols, rows) = (i64::from(d_col.abs()), i64::from(d_row.abs()));
        let is_clear = |index: isize| is_clear(self.cells[index as usize]);

        let mut at = self.index(a) as isize;
        // The segment leaves its i-th column at (2i + 1) / (2 cols) of its length and its j-th row
        // at (2j + 1) / (2 rows). `lead` is the first minus the second, times 2 cols rows.
        let mut lead = rows - cols;
        let mut lines_left = cols + rows;
        let mut clear = is_clear(at);
        while clear && lines_left > 0 {
            if lead < 0 {
                at += step_col;
                lead += 2 * rows;
                lines_left -= 1;
            } else if lead > 0 {
                at += step_row;
                lead -= 2 * cols;
                lines_left -= 1;
            } else {
                clear = is_clear(at + step_col) && is_clear(at + step_row);
                at += step_col + step_row;
                lead += 2 * (rows - cols);
                lines_left -= 2;
            }
            clear = clear && is_clear(at);
        }
        clear
    }

    /// Whether the segment a–b (grid frame, metres) touches no blocked cell.
    ///
    /// The points are rounded to 1/65536 of a cell (cell centres and corners are exact); from
    /// there on everything is integers. Symmetric; touching an edge or a vertex is touching all
    /// cells that share it. Cells of escape zones do not block the view. A point outside the map,
    /// or on its border, sees nothing.
    pub fn line_of_sight(&self, a: Vec2, b: Vec2) -> bool {
        let (Some(a), Some(b)) = (self.to_units(a), self.to_units(b)) else { return false };
        let ((ax, ay), (bx, by)) = if a.1 <= b.1 { (a, b) } else { (b, a) };
        let (dx, dy) = (bx - ax, by - ay);
        // The columns whose closed range touches [low, high] / (scale · unit): all arguments ≥ 0.
        let first = |low: i64, scale: i64| (low + scale * UNITS_PER_CELL - 1) / (scale * UNITS_PER_CELL) - 1;
        let last = |high: i64, scale: i64| high / (scale * UNITS_PER_CELL);
        (first(ay, 1)..=last(by, 1)).all(|row| {
            // The part of the segment inside the row's closed band; x times dy is a whole number.
            let (scale, enters, leaves) = if dy == 0 {
                (1, ax, bx)
            } else {
                let x_times_dy = |y: i64| ax * dy + dx * (y - ay);
                let bottom = (row * UNITS_PER_CELL).max(ay);
                let top = ((row + 1) * UNITS_PER_CELL).min(by);
                (dy, x_times_dy(bottom), x_times_dy(top))
            };
            let (low, high) = (enters.min(leaves), enters.max(leaves));
            let begin = (row + 1) as usize * self.stride() + 1;
            let touched = (begin as i64 + first(low, scale)) as usize..=(begin as i64 + last(high, scale)) as usize;
            self.cells[touched].iter().all(|bits| bits & PASSABLE != 0)
        })
    }

    /// Whether the segment a–b (grid frame, metres) is in sight and keeps at least `clearance_m` from
    /// every blocked square, the border of the map included: `los_r` of `systems.md` §1.2.
    ///
    /// Rounding is on the side of the segment: 1e-9 m less clearance counts as kept. Without
    /// clearance it is [`Self::line_of_sight`]: no touch.
    pub fn line_of_sight_with_clearance(&self, a: Vec2, b: Vec2, clearance_m: f64) -> bool {
        self.line_of_sight(a, b) && (clearance_m <= 0.0 || self.keeps_clear(a, b, clearance_m))
    }

    /// The sight of path stages: the segment is clear as [`Self::is_clear_to`] has it for `path_m`, the clearance of the path that
    /// it replaces, and keeps `clearance_m` from blocked squares where the stage asks for any.
    pub fn may_replace(&self, a: Vec2, b: Vec2, path_m: f64, clearance_m: f64) -> bool {
        if self.inflation_m <= 0.0 {
            return self.line_of_sight_with_clearance(a, b, clearance_m);
        }
        self.is_clear_to(a, b, path_m) && (clearance_m <= 0.0 || self.line_of_sight_with_clearance(a, b, clearance_m))
    }

    /// Whether no blocked square is nearer than `clearance_m` to a segment that crosses none.
    fn keeps_clear(&self, a: Vec2, b: Vec2, clearance_m: f64) -> bool {
        let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
        let d = b - a;
        let line = |from_m: f64, to_m: f64, count: i32| {
            // One more on either side: rounding must not lose a line of cells.
            let first = ((from_m - clearance_m) / self.resolution_m).floor() as i32 - 1;
            let last = ((to_m + clearance_m) / self.resolution_m).floor() as i32 + 1;
            first.max(-1)..=last.min(count)
        };
        line(a.y, b.y, self.rows).all(|row| {
            let (bottom, top) = (f64::from(row) * self.resolution_m, f64::from(row + 1) * self.resolution_m);
            // Where the segment is within reach of the row.
            let share = |y: f64| if d.y == 0.0 { 0.0 } else { math::clamp((y - a.y) / d.y, 0.0, 1.0) };
            let enters = a.x + d.x * share(bottom - clearance_m);
            let leaves = if d.y == 0.0 { b.x } else { a.x + d.x * share(top + clearance_m) };
            line(math::min(enters, leaves), math::max(enters, leaves), self.cols).all(|col| {
                let index = (row + 1) as usize * self.stride() + (col + 1) as usize;
                self.cells[index] & PASSABLE != 0 || {
                    let min = Vec2::new(f64::from(col) * self.resolution_m, bottom);
                    let square = Rect { min, max: min + Vec2::new(self.resolution_m, self.resolution_m) };
                    segment_square_distance(a, b, square) >= clearance_m - DISTANCE_SLACK_M
                }
            })
        })
    }

    /// A point of the map in integer units from its lower left corner; `None` outside.
    fn to_units(&self, p: Vec2) -> Option<(i64, i64)> {
        let inside = |x: f64, cells: i32| x >= 0.0 && x <= f64::from(cells) * self.resolution_m;
        let units = |x: f64| (x / self.resolution_m * UNITS_PER_CELL as f64).round() as i64;
        (inside(p.x, self.cols) && inside(p.y, self.rows)).then(|| (units(p.x), units(p.y)))
    }

    fn contains(&self, cell: Cell) -> bool {
        cell.col >= 0 && cell.col < self.cols && cell.row >= 0 && cell.row < self.rows
    }

    /// Distance from the centre of a cell of the map, given by its padded index, to the nearest obstacle square or the border of the
    /// map, in cells: what the map has, whatever the inflation. At least half a cell where the cell is passable.
    pub(super) fn obstacle_distance_cells(&self, index: u32) -> f64 {
        let Cell { col, row } = self.cell(index);
        0.5 * f64::from(self.squares[row as usize * self.cols as usize + col as usize]).sqrt()
    }

    /// Number of passable cells, those of escape zones included.
    pub(super) fn passable_count(&self) -> usize {
        // In parts whose counts fit a byte, which the compiler adds up many at a time.
        let of_part = |part: &[u8]| part.iter().fold(0u8, |count, bits| count.wrapping_add(bits & PASSABLE));
        self.cells.chunks(usize::from(u8::MAX)).map(|part| usize::from(of_part(part))).sum()
    }

    /// Whether any cell belongs to an escape zone.
    pub(super) fn has_escape_zone(&self) -> bool {
        !self.zone.is_empty()
    }

    /// Cells from one row of the padded array to the next.
    pub(super) fn stride(&self) -> usize {
        self.cols as usize + 2
    }

    /// The padded array: [`BLOCKED`], or [`PASSABLE`] with or without [`ESCAPE`].
    pub(super) fn cells(&self) -> &[u8] {
        &self.cells
    }

    /// The passable neighbours of each cell of the padded array: bit k is the one in direction k.
    pub(super) fn around(&self) -> &[u8] {
        &self.around
    }

    /// Index in the padded array; for a cell of the map or its border.
    pub(super) fn index(&self, cell: Cell) -> u32 {
        (cell.row + 1) as u32 * self.stride() as u32 + (cell.col + 1) as u32
    }

    /// The cell of an index of the padded array.
    pub(super) fn cell(&self, index: u32) -> Cell {
        let row = ((u64::from(index) * self.row_factor) >> ROW_BITS) as u32;
        Cell { col: (index - row * self.stride() as u32) as i32 - 1, row: row as i32 - 1 }
    }
}

fn lowest(a: Vec2, b: Vec2) -> Vec2 {
    Vec2::new(math::min(a.x, b.x), math::min(a.y, b.y))
}

fn highest(a: Vec2, b: Vec2) -> Vec2 {
    Vec2::new(math::max(a.x, b.x), math::max(a.y, b.y))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::rng::{EpisodeSeed, Purpose, Stream};

    pub(in crate::plan) fn stream(entity: u64) -> Stream {
        EpisodeSeed { seed: 1, episode: 0 }.stream(Purpose::Map, entity)
    }

    /// A map of up to `side` by `side` cells of which about `share` are occupied.
    pub(in crate::plan) fn random_map(stream: &mut Stream, side: usize, share: f64) -> OccupancyGrid {
        let resolution_m = [1.0, 0.05, 0.3][stream.index(3)];
        let (cols, rows) = (1 + stream.index(side) as i32, 1 + stream.index(side) as i32);
        let mut grid = OccupancyGrid::empty(cols, rows, resolution_m);
        for index in 0..grid.occupied().len() {
            if stream.uniform() < share {
                grid.set_occupied(grid.cell(index));
            }
        }
        grid
    }

    pub(in crate::plan) fn random_cell(stream: &mut Stream, grid: &OccupancyGrid) -> Cell {
        grid.cell(stream.index(grid.occupied().len()))
    }

    pub(in crate::plan) fn uninflated(grid: &OccupancyGrid) -> PlanningGrid {
        PlanningGrid::new(grid, &DistanceField::new(grid), 0.0)
    }

    /// The grids drawn by `lines`: `.` free, `i` blocked by inflation alone, `#` occupied.
    pub(in crate::plan) fn drawn(lines: &[&str]) -> (OccupancyGrid, PlanningGrid) {
        let inflated = uninflated(&OccupancyGrid::from_ascii(lines, 1.0));
        let lines: Vec<String> = lines.iter().map(|line| line.replace('i', ".")).collect();
        let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
        (OccupancyGrid::from_ascii(&lines, 1.0), inflated)
    }

    fn drawing(grid: &PlanningGrid) -> Vec<String> {
        let letter = |col, row| match grid.passability(Cell { col, row }) {
            Passability::Blocked => '#',
            Passability::Free => '.',
            Passability::Escape => 'e',
        };
        (0..grid.rows()).rev().map(|row| (0..grid.cols()).map(|col| letter(col, row)).collect()).collect()
    }

    /// Whether a segment and a closed square share a point, by the separating axis theorem in
    /// integers: two convex sets are apart if and only if they are on x, on y or across the segment.
    fn touches(a: (i64, i64), b: (i64, i64), min: (i64, i64), max: (i64, i64)) -> bool {
        let apart_on_x = a.0.max(b.0) < min.0 || a.0.min(b.0) > max.0;
        let apart_on_y = a.1.max(b.1) < min.1 || a.1.min(b.1) > max.1;
        let side = |p: (i64, i64)| ((b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0)).signum();
        let sides = [min, max, (min.0, max.1), (max.0, min.1)].map(side);
        let apart_across = sides == [1; 4] || sides == [-1; 4];
        !(apart_on_x || apart_on_y || apart_across)
    }

    /// Sight by trying every occupied square and the squares around the map; points in parts of a cell.
    fn sees_by_brute_force(grid: &OccupancyGrid, a: (i64, i64), b: (i64, i64), parts: i64) -> bool {
        (-1..=grid.rows()).all(|row| {
            (-1..=grid.cols()).all(|col| {
                let min = (i64::from(col) * parts, i64::from(row) * parts);
                grid.is_free(Cell { col, row }) || !touches(a, b, min, (min.0 + parts, min.1 + parts))
            })
        })
    }

    #[test]
    fn sight_between_cells_is_that_of_brute_force_in_integers() {
        let mut stream = stream(1);
        let mut seen = 0;
        for _ in 0..4000 {
            let share = stream.range(0.0, 0.25);
            let map = random_map(&mut stream, 24, share);
            let grid = uninflated(&map);
            for _ in 0..10 {
                let (a, b) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
                let halves = |cell: Cell| (2 * i64::from(cell.col) + 1, 2 * i64::from(cell.row) + 1);
                let expected = sees_by_brute_force(&map, halves(a), halves(b), 2);
                assert_eq!(grid.line_of_sight_cells(a, b), expected, "{a:?} {b:?}\n{:#?}", drawing(&grid));
                assert_eq!(grid.line_of_sight_cells(b, a), expected);
                assert_eq!(grid.line_of_sight(map.centre(a), map.centre(b)), expected, "{a:?} {b:?}");
                seen += usize::from(expected);
            }
        }
        assert!((8000..32000).contains(&seen), "both answers are common: {seen} of 40000");
    }

    #[test]
    fn sight_between_points_is_that_of_brute_force_in_integers() {
        // Eighths of a cell: many points on edges and vertices, many segments through vertices.
        let mut stream = stream(2);
        let mut seen = 0;
        for _ in 0..4000 {
            let share = stream.range(0.0, 0.25);
            let map = random_map(&mut stream, 12, share);
            let grid = uninflated(&map);
            for _ in 0..10 {
                let mut point = || {
                    let mut eighths = |cells: i32| stream.index(8 * cells as usize + 1) as i64;
                    (eighths(map.cols()), eighths(map.rows()))
                };
                let (a, b) = (point(), point());
                let metres = |p: (i64, i64)| Vec2::new(p.0 as f64, p.1 as f64) * (map.resolution_m() / 8.0);
                let expected = sees_by_brute_force(&map, a, b, 8);
                assert_eq!(grid.line_of_sight(metres(a), metres(b)), expected, "{a:?} {b:?}\n{:#?}", drawing(&grid));
                assert_eq!(grid.line_of_sight(metres(b), metres(a)), expected);
                seen += usize::from(expected);
            }
        }
        assert!((4000..36000).contains(&seen), "both answers are common: {seen} of 40000");
    }

    #[test]
    fn a_segment_through_a_vertex_touches_all_four_cells() {
        let (_, grid) = drawn(&["..", ".#"]);
        let cell = |col, row| Cell { col, row };
        assert!(!grid.line_of_sight_cells(cell(0, 0), cell(1, 1)));
        assert!(grid.line_of_sight_cells(cell(0, 0), cell(0, 1)) && grid.line_of_sight_cells(cell(0, 1), cell(1, 1)));
        // Along the edge x = 1 of the blocked square, from above, and just left of it.
        assert!(!grid.line_of_sight(Vec2::new(1.0, 1.9), Vec2::new(1.0, 1.0)));
        assert!(grid.line_of_sight(Vec2::new(1.0, 1.9), Vec2::new(1.0, 1.1)));
        assert!(grid.line_of_sight(Vec2::new(0.99, 1.9), Vec2::new(0.99, 0.1)));
    }

    #[test]
    fn points_and_cells_outside_see_nothing() {
        let (_, grid) = drawn(&["..", ".."]);
        let inside = Vec2::new(0.5, 0.5);
        for outside in [Vec2::new(-0.1, 0.5), Vec2::new(0.5, 2.1), Vec2::new(f64::NAN, 0.5), Vec2::new(0.0, 0.5)] {
            assert!(!grid.line_of_sight(inside, outside) && !grid.line_of_sight(outside, inside), "{outside:?}");
        }
        assert!(!grid.line_of_sight_cells(Cell { col: 0, row: 0 }, Cell { col: 2, row: 0 }));
        let nothing = PlanningGrid::default();
        assert!(!nothing.is_passable(Cell { col: 0, row: 0 }) && !nothing.line_of_sight(inside, inside));
    }

    #[test]
    fn clearance_along_a_segment_is_that_of_dense_sampling() {
        let mut stream = stream(3);
        let (mut kept, mut broken) = (0, 0);
        for _ in 0..400 {
            let share = stream.range(0.0, 0.1);
            let map = random_map(&mut stream, 12, share);
            let (grid, side) = (uninflated(&map), map.resolution_m());
            let squares: Vec<Rect> = (-1..=map.rows())
                .flat_map(|row| (-1..=map.cols()).map(move |col| Cell { col, row }))
                .filter(|&cell| !map.is_free(cell))
                .map(|cell| map.square(cell))
                .collect();
            for _ in 0..5 {
                let mut point = || Vec2::new(stream.uniform() * map.extent_m().x, stream.uniform() * map.extent_m().y);
                let (a, b) = (point(), point());
                if !grid.line_of_sight(a, b) {
                    continue;
                }
                let sampled = (0..=400)
                    .flat_map(|k| squares.iter().map(move |s| s.signed_distance(a + (b - a) * (f64::from(k) / 400.0))))
                    .fold(f64::INFINITY, math::min);
                let error = (b - a).norm() / 800.0 + 1e-9; // half the spacing of the samples
                let clearance = stream.uniform() * 1.5 * side;
                let answer = grid.line_of_sight_with_clearance(a, b, clearance);
                if clearance > sampled {
                    assert!(!answer, "{a:?} {b:?} {clearance} {sampled}");
                    broken += 1;
                } else if clearance < sampled - error {
                    assert!(answer, "{a:?} {b:?} {clearance} {sampled}");
                    kept += 1;
                }
            }
        }
        assert!(kept > 200 && broken > 200, "{kept} {broken}");
    }

    #[test]
    fn passing_beside_an_obstacle_keeps_half_a_cell_and_passing_its_corner_less() {
        let (_, grid) = drawn(&["....", "....", "..#.", "...."]);
        let keeps = |a: (f64, f64), b: (f64, f64), clearance_m| {
            grid.line_of_sight_with_clearance(Vec2::new(a.0, a.1), Vec2::new(b.0, b.1), clearance_m)
        };
        assert!(keeps((1.5, 0.5), (1.5, 2.5), 0.5) && !keeps((1.5, 0.5), (1.5, 2.5), 0.51));
        // From (0.5, 1.5) to (2.5, 3.5): the line y = x + 1 passes the corner (2, 2) at 1/√2 = 0.707;
        // the end (2.5, 3.5) is 0.5 from the border.
        assert!(keeps((0.5, 1.5), (2.5, 3.5), 0.5));
        assert!(keeps((1.0, 2.0), (2.0, 3.0), 0.707) && !keeps((1.0, 2.0), (2.0, 3.0), 0.708));
    }

    #[test]
    fn lines_between_free_cells_are_clear_where_they_keep_the_inflation() {
        let mut stream = stream(7);
        let (mut clear, mut refused) = (0, 0);
        for _ in 0..1500 {
            let share = stream.range(0.0, 0.2);
            let map = random_map(&mut stream, 24, share);
            let inflation_m = map.resolution_m() * [0.3, 0.49, 0.6, 0.95, 1.2, 2.0, 3.3][stream.index(7)];
            let field = DistanceField::new(&map);
            let grid = PlanningGrid::new(&map, &field, inflation_m);
            let obstacles = Obstacles::new(&map, &field);
            for _ in 0..20 {
                let (a, b) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
                if !(grid.is_passable(a) && grid.is_passable(b)) {
                    assert!(!grid.is_clear_cells_free(a, b));
                    continue;
                }
                let least_m = obstacles.segment_clearance(map.centre(a), map.centre(b), 2.0 * inflation_m);
                let expected = least_m >= inflation_m - DISTANCE_SLACK_M;
                assert_eq!(grid.is_clear_cells_free(a, b), expected, "{a:?} {b:?} {inflation_m} {least_m}");
                assert_eq!(
                    grid.is_clear(map.centre(a), map.centre(b)),
                    expected,
                    "{a:?} {b:?} {inflation_m} {least_m}"
                );
                *(if expected { &mut clear } else { &mut refused }) += 1;
            }
        }
        assert!(clear > 2000 && refused > 2000, "{clear} {refused}");
    }

    #[test]
    fn an_escape_zone_reaches_to_the_nearest_free_cell_and_no_further() {
        let (map, mut grid) = drawn(&["#########", "iiiiiii..", "#########"]);
        grid.open_around(&map, Cell { col: 4, row: 1 });
        // Free space is three steps to the right; as many to the left are opened, not the whole passage.
        assert_eq!(drawing(&grid), ["#########", "##eeeee..", "#########"]);
        // A second zone ends at the first.
        grid.open_around(&map, Cell { col: 1, row: 1 });
        assert_eq!(drawing(&grid), ["#########", "#eeeeee..", "#########"]);
        // Sight passes through it, unless asked for free cells alone.
        let (a, b) = (Cell { col: 2, row: 1 }, Cell { col: 8, row: 1 });
        assert!(grid.line_of_sight_cells(a, b) && !grid.line_of_sight_cells_free(a, b));
    }

    #[test]
    fn an_escape_zone_opens_only_what_is_inflated_and_unoccupied() {
        let (map, mut grid) = drawn(&["i#i.", "ii#.", "####"]);
        for untouched in [Cell { col: 3, row: 1 }, Cell { col: 2, row: 1 }, Cell { col: -1, row: 0 }] {
            let before = drawing(&grid);
            grid.open_around(&map, untouched);
            assert_eq!(drawing(&grid), before);
        }
        // No free cell can be reached through edges: all that is connected opens, and only that.
        grid.open_around(&map, Cell { col: 0, row: 1 });
        assert_eq!(drawing(&grid), ["e##.", "ee#.", "####"]);
    }

    #[test]
    fn inflation_blocks_the_centres_that_are_too_near_to_a_square_or_the_border() {
        let mut stream = stream(5);
        for _ in 0..200 {
            let map = random_map(&mut stream, 15, 0.1);
            let inflation_m = stream.index(7) as f64 * 0.25 * map.resolution_m();
            let grid = PlanningGrid::new(&map, &DistanceField::new(&map), inflation_m);
            let all = (-1..=map.rows()).flat_map(|row| (-1..=map.cols()).map(move |col| Cell { col, row }));
            let blocked: Vec<Cell> = all.filter(|&cell| !map.is_free(cell)).collect();
            for index in 0..map.occupied().len() {
                let cell = map.cell(index);
                let distance_to = |other: &Cell| map.square(*other).signed_distance(map.centre(cell));
                let distance_m = blocked.iter().map(distance_to).fold(f64::INFINITY, math::min);
                let expected = map.is_free(cell) && distance_m >= inflation_m - 1e-9;
                assert_eq!(grid.is_passable(cell), expected, "{cell:?} {distance_m} {inflation_m}");
            }
        }
    }

    #[test]
    fn a_capsule_blocks_the_centres_within_it_and_the_neighbours_know() {
        let mut stream = stream(6);
        for _ in 0..200 {
            let map = random_map(&mut stream, 15, 0.1);
            let (mut grid, before) = (uninflated(&map), uninflated(&map));
            let mut point =
                || 1.2 * Vec2::new(stream.uniform() * map.extent_m().x, stream.uniform() * map.extent_m().y);
            let (a, b) = (point(), point());
            let radius_m = 2.0 * stream.uniform() * map.resolution_m();
            grid.block_capsule(a, b, radius_m);
            let mut lines = Vec::new();
            for row in (0..map.rows()).rev() {
                let letter = |col| {
                    let cell = Cell { col, row };
                    let hit = point_segment_distance(map.centre(cell), a, b) < radius_m;
                    if hit || !before.is_passable(cell) { '#' } else { '.' }
                };
                lines.push((0..map.cols()).map(letter).collect::<String>());
            }
            let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
            let expected = uninflated(&OccupancyGrid::from_ascii(&lines, map.resolution_m()));
            assert_eq!((drawing(&grid), grid.around()), (drawing(&expected), expected.around()));
        }
    }

    #[test]
    fn a_rebuilt_grid_is_a_new_one() {
        let mut stream = stream(4);
        let (map, mut reused) = drawn(&["ii.", "###"]);
        reused.open_around(&map, Cell { col: 0, row: 1 });
        assert_eq!(drawing(&reused), ["ee.", "###"]);
        for _ in 0..200 {
            let map = random_map(&mut stream, 9, 0.3);
            reused.rebuild(&map, &DistanceField::new(&map), 0.0);
            let fresh = uninflated(&map);
            assert_eq!(drawing(&reused), drawing(&fresh));
            for index in 0..map.occupied().len() {
                let cell = map.cell(index);
                assert_eq!(fresh.is_passable(cell), map.is_free(cell));
                assert_eq!(fresh.cell(fresh.index(cell)), cell);
            }
        }
    }
}
