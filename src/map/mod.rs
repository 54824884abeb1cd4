//! Maps: occupancy grid, exact distance field, frames; readers of file formats; seeded generators.
//!
//! Cell (col, row) covers the square [col, col+1] × [row, row+1] times the resolution; row 0 is at
//! the bottom. Formats whose first row is the top are flipped by their reader and nowhere else.
//! Everything outside the grid is blocked.

pub mod ascii;
pub mod connectivity;
mod distance;
pub mod empty;
mod error;
pub mod file;
pub mod from_image;
mod grid;
mod layout;
pub mod maze;
pub mod movingai;
pub mod port;
pub mod queries;
pub mod random;
pub mod rooms;
pub mod ros;
mod spec;
pub mod u_trap;
pub mod warehouse;
pub mod workshop;

pub use distance::DistanceField;
pub use error::MapError;
pub use grid::{Cell, Frame, OccupancyGrid};
pub use spec::MapSpec;

/// Most cells along one side of a map; checked before anything is allocated.
pub const SIDE_MAX: usize = 16_384;
