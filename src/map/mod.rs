//! Maps: occupancy grid, exact distance field, frames; readers of file formats; seeded generators.
//!
//! Cell (col, row) covers the square [col, col+1] × [row, row+1] times the resolution; row 0 is at
//! the bottom. Formats whose first row is the top are flipped by their reader and nowhere else.
//! Everything outside the grid is blocked.

mod distance;
mod grid;

pub use distance::DistanceField;
pub use grid::{Cell, Frame, OccupancyGrid};
