//! The occupancy grid and its frame.

use crate::geometry::{Pose, Rect, Vec2, wrap_angle};
use crate::math;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// A cell of a grid: column from the left, row from the bottom. May lie outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Cell {
    /// Column, 0 at the left.
    pub col: i32,
    /// Row, 0 at the bottom.
    pub row: i32,
}

/// Place of the grid in the world: the pose of its lower left corner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// World pose of the grid's lower left corner.
    pub origin: Pose,
}

impl Frame {
    /// The frame in which grid and world coincide.
    pub const IDENTITY: Self = Self { origin: Pose { position: Vec2::new(0.0, 0.0), theta: 0.0 } };

    /// A grid pose in the world frame.
    pub fn to_world(&self, grid: Pose) -> Pose {
        Pose { position: self.point_to_world(grid.position), theta: wrap_angle(grid.theta + self.origin.theta) }
    }

    /// A world pose in the grid frame.
    pub fn to_grid(&self, world: Pose) -> Pose {
        Pose { position: self.point_to_grid(world.position), theta: wrap_angle(world.theta - self.origin.theta) }
    }

    /// A grid point in the world frame.
    pub fn point_to_world(&self, p: Vec2) -> Vec2 {
        let (sin, cos) = math::sin_cos(self.origin.theta);
        self.origin.position + Vec2::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y)
    }

    /// A world point in the grid frame.
    pub fn point_to_grid(&self, p: Vec2) -> Vec2 {
        let (sin, cos) = math::sin_cos(self.origin.theta);
        let d = p - self.origin.position;
        Vec2::new(cos * d.x + sin * d.y, cos * d.y - sin * d.x)
    }
}

/// A rectangular grid of free and occupied cells.
#[derive(Debug, Serialize, Deserialize)]
#[serde(try_from = "GridBytes", into = "GridBytes")]
pub struct OccupancyGrid {
    cols: i32,
    rows: i32,
    resolution_m: f64,
    frame: Frame,
    occupied: Vec<bool>,
    /// The cells that nobody has seen, for pictures alone: each counts as free or occupied like any other. `None` if all are known.
    unknown: Option<Arc<[bool]>>,
}

/// By place and occupancy.
impl PartialEq for OccupancyGrid {
    fn eq(&self, other: &Self) -> bool {
        let place = |grid: &Self| (grid.cols, grid.rows, grid.resolution_m, grid.frame);
        place(self) == place(other) && self.occupied == other.occupied
    }
}

/// A grid as it is written: eight cells to a byte, the first one in the lowest bit.
#[derive(Serialize, Deserialize)]
struct GridBytes {
    cols: i32,
    rows: i32,
    resolution_m: f64,
    frame: Frame,
    occupied: Vec<u8>,
}

impl From<OccupancyGrid> for GridBytes {
    fn from(grid: OccupancyGrid) -> Self {
        let OccupancyGrid { cols, rows, resolution_m, frame, occupied, unknown: _ } = grid;
        let byte = |cells: &[bool]| cells.iter().rev().fold(0, |byte, &cell| byte << 1 | u8::from(cell));
        Self { cols, rows, resolution_m, frame, occupied: occupied.chunks(8).map(byte).collect() }
    }
}

impl TryFrom<GridBytes> for OccupancyGrid {
    type Error = &'static str;

    fn try_from(bytes: GridBytes) -> Result<Self, Self::Error> {
        let GridBytes { cols, rows, resolution_m, frame, occupied } = bytes;
        let sides = usize::try_from(cols).ok().zip(usize::try_from(rows).ok());
        let count = sides.filter(|&(cols, rows)| cols.min(rows) > 0).and_then(|(cols, rows)| cols.checked_mul(rows));
        match count {
            Some(count) if count.div_ceil(8) == occupied.len() && resolution_m.is_finite() && resolution_m > 0.0 => {
                let cells = occupied.iter().flat_map(|byte| (0..8).map(move |bit| byte >> bit & 1 == 1));
                Ok(Self { cols, rows, resolution_m, frame, occupied: cells.take(count).collect(), unknown: None })
            }
            _ => Err("sizes that are not those of a grid"),
        }
    }
}

impl Clone for OccupancyGrid {
    fn clone(&self) -> Self {
        Self { occupied: self.occupied.clone(), unknown: self.unknown.clone(), ..*self }
    }

    fn clone_from(&mut self, source: &Self) {
        let mut occupied = core::mem::take(&mut self.occupied);
        occupied.clone_from(&source.occupied);
        *self = Self { occupied, unknown: source.unknown.clone(), ..*source };
    }
}

impl OccupancyGrid {
    /// A grid without obstacles.
    ///
    /// # Panics
    /// If a side is not positive or the resolution is not a positive number.
    pub fn empty(cols: i32, rows: i32, resolution_m: f64) -> Self {
        assert!(cols > 0 && rows > 0, "a grid has at least one cell");
        assert!(resolution_m.is_finite() && resolution_m > 0.0, "the resolution is a positive number");
        let cells = cols as usize * rows as usize;
        Self { cols, rows, resolution_m, frame: Frame::IDENTITY, occupied: vec![false; cells], unknown: None }
    }

    /// The grid drawn by `lines`, the first line on top: `.` and space are free, all else is occupied.
    ///
    /// # Panics
    /// If the lines differ in length. For tests and examples; files go through a reader.
    pub fn from_ascii(lines: &[&str], resolution_m: f64) -> Self {
        let rows = lines.len() as i32;
        let cols = lines.first().map_or(0, |line| line.len()) as i32;
        let mut grid = Self::empty(cols, rows, resolution_m);
        for (from_top, line) in lines.iter().enumerate() {
            assert_eq!(line.len(), cols as usize, "lines of one length");
            for (col, byte) in line.bytes().enumerate() {
                if byte != b'.' && byte != b' ' {
                    grid.set_occupied(Cell { col: col as i32, row: rows - 1 - from_top as i32 });
                }
            }
        }
        grid
    }

    /// The same grid with another frame.
    pub fn with_frame(mut self, frame: Frame) -> Self {
        self.frame = frame;
        self
    }

    /// The same grid with cells of another size.
    ///
    /// # Panics
    /// If the resolution is not a positive number.
    pub fn with_resolution(mut self, resolution_m: f64) -> Self {
        assert!(resolution_m.is_finite() && resolution_m > 0.0, "the resolution is a positive number");
        self.resolution_m = resolution_m;
        self
    }

    /// The same grid that knows which of its cells nobody has seen, in the order of [`Self::occupied`].
    ///
    /// # Panics
    /// If there are not as many as the grid has cells.
    pub fn with_unknown(mut self, cells: Vec<bool>) -> Self {
        assert_eq!(cells.len(), self.occupied.len(), "one for each cell");
        self.unknown = cells.contains(&true).then(|| cells.into());
        self
    }

    /// Whether nobody has seen some of the cells.
    pub fn has_unknown(&self) -> bool {
        self.unknown.is_some()
    }

    /// Whether the cell is inside and nobody has seen it.
    pub fn is_unknown(&self, cell: Cell) -> bool {
        self.unknown.as_ref().is_some_and(|unknown| self.contains(cell) && unknown[self.index(cell)])
    }

    /// Number of columns.
    pub fn cols(&self) -> i32 {
        self.cols
    }

    /// Number of rows.
    pub fn rows(&self) -> i32 {
        self.rows
    }

    /// Side of a cell, metres.
    pub fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    /// Place of the grid in the world.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Width and height in metres.
    pub fn extent_m(&self) -> Vec2 {
        Vec2::new(f64::from(self.cols) * self.resolution_m, f64::from(self.rows) * self.resolution_m)
    }

    /// Whether the cell lies inside the grid.
    pub fn contains(&self, cell: Cell) -> bool {
        cell.col >= 0 && cell.col < self.cols && cell.row >= 0 && cell.row < self.rows
    }

    /// Row-major index of a cell inside the grid.
    ///
    /// # Panics
    /// If the cell lies outside.
    pub fn index(&self, cell: Cell) -> usize {
        assert!(self.contains(cell), "cell outside the grid");
        cell.row as usize * self.cols as usize + cell.col as usize
    }

    /// The cell of a row-major index.
    pub fn cell(&self, index: usize) -> Cell {
        let cols = self.cols as usize;
        Cell { col: (index % cols) as i32, row: (index / cols) as i32 }
    }

    /// Whether the cell is inside and free.
    pub fn is_free(&self, cell: Cell) -> bool {
        self.contains(cell) && !self.occupied[self.index(cell)]
    }

    /// Occupancy by row-major index, row 0 at the bottom.
    pub fn occupied(&self) -> &[bool] {
        &self.occupied
    }

    /// Marks a cell inside the grid as occupied.
    pub fn set_occupied(&mut self, cell: Cell) {
        let index = self.index(cell);
        self.occupied[index] = true;
    }

    /// Marks a cell inside the grid as free.
    pub fn set_free(&mut self, cell: Cell) {
        let index = self.index(cell);
        self.occupied[index] = false;
    }

    /// Number of occupied cells.
    pub fn occupied_count(&self) -> usize {
        self.occupied.iter().filter(|&&occupied| occupied).count()
    }

    /// The cell that holds a point of the grid frame (the upper one of a shared edge); may lie outside.
    pub fn cell_at(&self, p: Vec2) -> Cell {
        Cell { col: (p.x / self.resolution_m).floor() as i32, row: (p.y / self.resolution_m).floor() as i32 }
    }

    /// Centre of a cell in the grid frame.
    pub fn centre(&self, cell: Cell) -> Vec2 {
        Vec2::new((f64::from(cell.col) + 0.5) * self.resolution_m, (f64::from(cell.row) + 0.5) * self.resolution_m)
    }

    /// The square that a cell covers, grid frame.
    pub fn square(&self, cell: Cell) -> Rect {
        let min = Vec2::new(f64::from(cell.col) * self.resolution_m, f64::from(cell.row) * self.resolution_m);
        Rect { min, max: min + Vec2::new(self.resolution_m, self.resolution_m) }
    }
}

/// Draws the grid as [`OccupancyGrid::from_ascii`] reads it: `.` free, `#` occupied, the top row
/// first, each row ended by a line break.
impl fmt::Display for OccupancyGrid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for row in self.occupied.chunks_exact(self.cols as usize).rev() {
            let line: String = row.iter().map(|&occupied| if occupied { '#' } else { '.' }).collect();
            writeln!(f, "{line}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::FRAC_PI_2;

    #[test]
    fn a_grid_is_drawn_as_it_is_read() {
        let lines = ["..#.", "#...", "...#"];
        let grid = OccupancyGrid::from_ascii(&lines, 1.0);
        assert_eq!(grid.to_string().lines().collect::<Vec<_>>(), lines);
        // The last line is row 0.
        assert!(!grid.is_free(Cell { col: 3, row: 0 }) && !grid.is_free(Cell { col: 2, row: 2 }));
        assert_eq!(grid.occupied_count(), 3);
    }

    #[test]
    fn outside_is_not_free() {
        let grid = OccupancyGrid::empty(3, 2, 0.5);
        for cell in [(-1, 0), (0, -1), (3, 0), (0, 2)].map(|(col, row)| Cell { col, row }) {
            assert!(!grid.contains(cell) && !grid.is_free(cell));
        }
        assert!((0..6).all(|index| grid.index(grid.cell(index)) == index));
    }

    #[test]
    fn a_cell_holds_its_lower_and_left_edge() {
        let grid = OccupancyGrid::empty(3, 2, 0.5);
        assert_eq!(grid.cell_at(Vec2::new(0.5, 0.0)), Cell { col: 1, row: 0 });
        assert_eq!(grid.cell_at(Vec2::new(-0.1, 1.0)), Cell { col: -1, row: 2 });
        assert_eq!(grid.centre(Cell { col: 1, row: 0 }), Vec2::new(0.75, 0.25));
        assert_eq!(grid.extent_m(), Vec2::new(1.5, 1.0));
    }

    #[test]
    fn frames_turn_about_the_lower_left_corner() {
        // A quarter turn: the grid's x runs along the world's y.
        let frame = Frame { origin: Pose::new(10.0, 5.0, FRAC_PI_2) };
        let world = frame.to_world(Pose::new(2.0, 1.0, 0.25));
        assert!(
            (world.position - Vec2::new(9.0, 7.0)).norm() < 1e-12 && (world.theta - 0.25 - FRAC_PI_2).abs() < 1e-12
        );
        let back = frame.to_grid(world);
        assert!((back.position - Vec2::new(2.0, 1.0)).norm() < 1e-12 && (back.theta - 0.25).abs() < 1e-12);
    }
}
