//! A map without obstacles: nothing but its border.

use super::OccupancyGrid;
use crate::settings::quantity::{Cells, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of an empty map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Number of columns.
    pub cols: Cells,
    /// Number of rows.
    pub rows: Cells,
    /// Side of a cell, m. Default 1.
    #[serde(default = "super::spec::one_metre")]
    pub resolution_m: Positive,
}

impl Params {
    /// The grid.
    pub fn grid(&self) -> OccupancyGrid {
        OccupancyGrid::empty(self.cols.get() as i32, self.rows.get() as i32, self.resolution_m.get())
    }
}
