//! The planning grid: where the centre of the robot may be, and who sees whom.

use crate::geometry::Vec2;
use crate::map::{Cell, DistanceField, OccupancyGrid};

/// What a cell of the planning grid allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passability {
    /// Never enterable.
    Blocked,
    /// Enterable at its plain cost.
    Free,
    /// Inside the inflated zone around a start or goal: enterable at ten times the cost.
    Escape,
}

/// Where the centre of the robot may be, cell by cell, with a blocked border around.
#[derive(Clone, Debug, Default)]
pub struct PlanningGrid {
    cols: i32,
    rows: i32,
    resolution_m: f64,
    cells: Vec<Passability>,
}

impl PlanningGrid {
    /// A cell is blocked if it is occupied or its centre is nearer than `inflation_m` to an
    /// occupied square (the border of the map counts as occupied).
    pub fn new(grid: &OccupancyGrid, field: &DistanceField, inflation_m: f64) -> Self {
        let _ = field;
        let _ = inflation_m;
        Self { cols: grid.cols(), rows: grid.rows(), resolution_m: grid.resolution_m(), cells: Vec::new() }
    }

    /// The same in place, keeping the memory.
    pub fn rebuild(&mut self, grid: &OccupancyGrid, field: &DistanceField, inflation_m: f64) {
        *self = Self::new(grid, field, inflation_m);
    }

    /// Whether the segment a–b touches no blocked cell.
    pub fn line_of_sight(&self, a: Vec2, b: Vec2) -> bool {
        let _ = (a, b);
        true
    }

    /// Side of a cell, m.
    pub fn resolution_m(&self) -> f64 {
        self.resolution_m
    }

    /// Makes the connected inflated but unoccupied cells around `cell` passable at ten times the cost
    /// until free space is reached, where `cell` is blocked by inflation alone.
    pub fn open_around(&mut self, grid: &OccupancyGrid, cell: Cell) {
        let _ = (grid, cell);
    }

    /// What a cell allows; outside is blocked.
    pub fn passability(&self, cell: Cell) -> Passability {
        let _ = (cell, self.cols, self.rows);
        self.cells[0]
    }

    /// Centre of a cell, grid frame, metres.
    pub fn centre(&self, cell: Cell) -> Vec2 {
        Vec2::new((f64::from(cell.col) + 0.5) * self.resolution_m, (f64::from(cell.row) + 0.5) * self.resolution_m)
    }
}
