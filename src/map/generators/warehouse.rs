//! A warehouse: rack rows with aisles between them, cross aisles, docks along the left side.
//!
//! The layout has no randomness. From left to right: dock bays between dividers, open floor (the
//! staging area), then columns of racks, each with a cross aisle on its right, the last one along
//! the right wall. From bottom to top: an aisle, a rack row, an aisle, …, an aisle. What the lengths
//! leave over widens the staging area and the two outer aisles. This scenario
//!
//! ```yaml
//! map: {warehouse: {width_m: 30, height_m: 13, resolution_m: 1, rack_rows: 3, rack_depth_m: 1, aisle_width_m: 2,
//!   cross_aisles: 1, cross_aisle_width_m: 2, docks: 3, dock_depth_m: 2, dock_divider_m: 1, staging_width_m: 4}}
//! ```
//!
//! is drawn as
//!
//! ```text
//! ..............................
//! ..............................
//! ..............................
//! ......##########..##########..
//! ##............................
//! ..............................
//! ......##########..##########..
//! ..............................
//! ..............................
//! ##....##########..##########..
//! ..............................
//! ..............................
//! ..............................
//! ```

use crate::map::layout::{self, occupy};
use crate::map::{Entry, MapError, MapKind, OccupancyGrid};
use crate::rng::EpisodeSeed;
use crate::settings::quantity::{Count, CountOrZero, NonNegative, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "A warehouse: rack rows with aisles between them, cross aisles, docks along the left side.",
    files: &[],
};

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

/// The sizes in cells.
struct Plan {
    cols: i64,
    rows: i64,
    rack_depth: i64,
    aisle: i64,
    cross_aisle: i64,
    dock_depth: i64,
    dock_divider: i64,
    staging: i64,
}

impl MapKind for Params {
    /// The grid.
    ///
    /// # Errors
    /// [`MapError::Contradiction`] if a length is not a whole number of cells, a side exceeds
    /// [`SIDE_MAX`](crate::map::SIDE_MAX) cells, or racks, aisles and docks do not fit into the hall.
    fn load(&self, _folder: &Path, _seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        let plan = self.plan()?;
        let (rack_rows, docks) = (i64::from(self.rack_rows.get()), i64::from(self.docks.get()));
        let rack_columns = i64::from(self.cross_aisles.get()) + 1;

        let needed = rack_rows * plan.rack_depth + (rack_rows + 1) * plan.aisle;
        if needed > plan.rows {
            return Err(self.contradiction(
                format!("{rack_rows} rack rows and {} aisles, together {} m", rack_rows + 1, self.metres(needed)),
                format!("at most `height_m`, {} m", self.height_m.get()),
                "lower `rack_rows`, `rack_depth_m` or `aisle_width_m`, or raise `height_m`",
            ));
        }
        let before_racks = plan.dock_depth + plan.staging;
        let rack_length = (plan.cols - before_racks - rack_columns * plan.cross_aisle) / rack_columns;
        if rack_length < 1 {
            let needed = before_racks + rack_columns * (plan.cross_aisle + 1);
            return Err(self.contradiction(
                format!(
                    "docks, staging, {rack_columns} cross aisles and racks of one cell, together {} m",
                    self.metres(needed)
                ),
                format!("at most `width_m`, {} m", self.width_m.get()),
                "lower `cross_aisles`, `cross_aisle_width_m`, `staging_width_m` or `dock_depth_m`, or raise `width_m`",
            ));
        }
        let bays = plan.rows - (docks - 1) * plan.dock_divider;
        if bays < docks {
            return Err(self.contradiction(
                format!("{docks} docks with dividers of {} m", self.dock_divider_m.get()),
                format!("at least one cell for each dock along `height_m`, {} m", self.height_m.get()),
                "lower `docks` or `dock_divider_m`, or raise `height_m`",
            ));
        }

        let mut grid = OccupancyGrid::empty(plan.cols as i32, plan.rows as i32, self.resolution_m.get());
        // What the lengths leave over goes to the staging area and to both outer aisles.
        let first_col = plan.cols - rack_columns * (rack_length + plan.cross_aisle);
        let first_row = plan.aisle + (plan.rows - needed) / 2;
        for rack_row in 0..rack_rows {
            let row = first_row + rack_row * (plan.rack_depth + plan.aisle);
            for rack_column in 0..rack_columns {
                let col = first_col + rack_column * (rack_length + plan.cross_aisle);
                occupy(&mut grid, col..col + rack_length, row..row + plan.rack_depth);
            }
        }
        for divider in 1..docks {
            let row = divider * bays / docks + (divider - 1) * plan.dock_divider;
            occupy(&mut grid, 0..plan.dock_depth, row..row + plan.dock_divider);
        }
        Ok(grid)
    }

    fn is_fixed(&self) -> bool {
        true
    }
}

impl Params {
    fn plan(&self) -> Result<Plan, MapError> {
        Ok(Plan {
            cols: self.cells("width_m", self.width_m.get())?,
            rows: self.cells("height_m", self.height_m.get())?,
            rack_depth: self.cells("rack_depth_m", self.rack_depth_m.get())?,
            aisle: self.cells("aisle_width_m", self.aisle_width_m.get())?,
            cross_aisle: self.cells("cross_aisle_width_m", self.cross_aisle_width_m.get())?,
            dock_depth: self.cells("dock_depth_m", self.dock_depth_m.get())?,
            dock_divider: self.cells("dock_divider_m", self.dock_divider_m.get())?,
            staging: self.cells("staging_width_m", self.staging_width_m.get())?,
        })
    }

    /// A length in cells.
    fn cells(&self, key: &str, length_m: f64) -> Result<i64, MapError> {
        layout::cells("warehouse", key, length_m, self.resolution_m.get())
    }

    fn metres(&self, cells: i64) -> f64 {
        cells as f64 * self.resolution_m.get()
    }

    fn contradiction(&self, found: String, expected: String, advice: &'static str) -> MapError {
        MapError::Contradiction { map: "warehouse", found, expected, advice }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::connectivity::{Components, passable};
    use crate::map::support::{generate, load, refusal};
    use crate::map::{Cell, DistanceField, MapSpec};

    #[test]
    fn the_default_hall_has_the_sizes_it_names() {
        let grid = generate(&Params::default(), 0);
        assert_eq!((grid.cols(), grid.rows()), (240, 120));
        // Racks: 6 rows x 3 columns of 54 x 8 cells, as (240 - 40 - 3 x 12) / 3 = 54; dividers: 5 of 12 x 2.
        assert_eq!(grid.occupied_count(), 6 * 3 * 54 * 8 + 5 * 12 * 2);
        // Upwards through the first rack column: free runs are the aisles, 10 cells or more each.
        let free: String = (0..120).map(|row| if grid.is_free(Cell { col: 60, row }) { '.' } else { '#' }).collect();
        let aisles: Vec<usize> = free.split('#').filter(|run| !run.is_empty()).map(str::len).collect();
        assert_eq!(aisles, [11, 10, 10, 10, 10, 10, 11]);
        let bays: String = (0..120).map(|row| if grid.is_free(Cell { col: 0, row }) { '.' } else { '#' }).collect();
        let bays: Vec<usize> = bays.split('#').filter(|run| !run.is_empty()).map(str::len).collect();
        // (120 - 5 x 2) / 6 = 18 1/3
        assert_eq!(bays, [18, 18, 19, 18, 18, 19]);
    }

    #[test]
    fn two_robots_pass_each_other_everywhere() {
        // Abreast, two discs of 0.5 m take 1 m: a disc of that diameter reaches every aisle and bay.
        for resolution in ["0.25", "0.1", "0.5"] {
            let grid = load(&format!("warehouse: {{resolution_m: {resolution}}}")).expect("a map");
            let parts = Components::new(&grid, &passable(&DistanceField::new(&grid), 0.5));
            assert_eq!(parts.sizes().len(), 1);
            assert_eq!(grid.extent_m(), crate::geometry::Vec2::new(60.0, 30.0));
        }
    }

    #[test]
    fn contradictory_sizes_are_named_with_the_way_out() {
        for (yaml, expected) in [
            (
                "warehouse: {rack_rows: 7}",
                "found 7 rack rows and 8 aisles, together 34 m, expected at most `height_m`, 30 m",
            ),
            (
                "warehouse: {cross_aisles: 20}",
                "21 cross aisles and racks of one cell, together 78.25 m, expected at most `width_m`",
            ),
            ("warehouse: {docks: 41}", "found 41 docks with dividers of 0.5 m, expected at least one cell"),
            ("warehouse: {rack_depth_m: 1.1}", "found `rack_depth_m` 1.1, expected a whole number of cells of 0.25 m"),
            ("warehouse: {width_m: 5000}", "found `width_m` of 20000 cells, expected at most 16384"),
            ("warehouse: {docks: 1000000000, rack_rows: 1}", "found 1000000000 docks"),
            ("warehouse: {rack_rows: 1000000000}", "found 1000000000 rack rows"),
            ("warehouse: {cross_aisles: 1000000000}", "1000000001 cross aisles"),
        ] {
            let message = refusal(yaml);
            assert!(message.contains(expected), "{message}");
        }
        // 40 docks and 39 dividers of 2 cells leave 42 of 120 cells for the bays.
        assert!(load("warehouse: {docks: 40, dock_depth_m: 0}").is_ok());
    }

    #[test]
    fn the_name_alone_is_the_default_hall() {
        assert_eq!(MapSpec::by_name("warehouse").expect("a map"), MapSpec::warehouse(Params::default()));
    }
}
