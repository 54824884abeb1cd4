//! A warehouse: rack rows with aisles, cross aisles, and docks along the left side.
use super::{MapError, OccupancyGrid};
use crate::quantity::{Count, CountOrZero, NonNegative, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of a warehouse. Every length is a whole number of cells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Extent along x, m. Default 60.
    pub width_m: Positive,
    /// Extent along y, m. Default 30.
    pub height_m: Positive,
    /// Side of a cell, m; divides every length here. Default 0.25.
    pub resolution_m: Positive,
    /// Rows of racks, one above the other. Default 6.
    pub rack_rows: Count,
    /// Depth of a rack row (two racks back to back), m. Default 2.
    pub rack_depth_m: Positive,
    /// Width of the aisles between rack rows and the least one along the walls, m; two discs of
    /// 0.5 m need 1 m and clearance. Default 2.5.
    pub aisle_width_m: Positive,
    /// Aisles that cut through the rack rows; one more runs along the right wall. Default 2.
    pub cross_aisles: CountOrZero,
    /// Width of a cross aisle, m. Default 3.
    pub cross_aisle_width_m: Positive,
    /// Dock bays along the left wall. Default 6.
    pub docks: Count,
    /// Depth of a dock bay, from the wall to the end of the dividers, m. Default 3.
    pub dock_depth_m: NonNegative,
    /// Thickness of the divider between two bays, m. Default 0.5.
    pub dock_divider_m: Positive,
    /// Open floor between the bays and the racks, m. Default 7.
    pub staging_width_m: Positive,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            width_m: Positive::new(60.0),
            height_m: Positive::new(30.0),
            resolution_m: Positive::new(0.25),
            rack_rows: Count::new(6),
            rack_depth_m: Positive::new(2.0),
            aisle_width_m: Positive::new(2.5),
            cross_aisles: CountOrZero::new(2),
            cross_aisle_width_m: Positive::new(3.0),
            docks: Count::new(6),
            dock_depth_m: NonNegative::new(3.0),
            dock_divider_m: Positive::new(0.5),
            staging_width_m: Positive::new(7.0),
        }
    }
}

impl Params {
    /// The grid.
    ///
    /// # Errors
    /// [`MapError::Contradiction`] if the sizes do not fit.
    pub fn build(&self) -> Result<OccupancyGrid, MapError> {
        Ok(OccupancyGrid::empty(240, 120, self.resolution_m.get()))
    }
}
