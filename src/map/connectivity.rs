//! Which cells can be reached: flood fill over the grid.
