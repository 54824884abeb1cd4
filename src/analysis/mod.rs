//! Statistics: plain functions of numbers, used by summaries and by paired comparisons.

mod interval;
mod quantile;

pub use interval::{Z_95, wilson};
pub use quantile::quantile;
