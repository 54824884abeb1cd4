//! A map without obstacles: nothing but its border. This scenario
//!
//! ```yaml
//! map: {empty: {cols: 6, rows: 2}}
//! ```
//!
//! is drawn as
//!
//! ```text
//! ......
//! ......
//! ```

use crate::map::kind::one_metre;
use crate::map::{Entry, MapError, MapKind, OccupancyGrid};
use crate::rng::EpisodeSeed;
use crate::settings::quantity::{Cells, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "A map without obstacles: nothing but its border.", files: &[] };

/// Parameters of an empty map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Number of columns.
    pub cols: Cells,
    /// Number of rows.
    pub rows: Cells,
    /// Side of a cell, m. Default 1.
    #[serde(default = "one_metre")]
    pub resolution_m: Positive,
}

impl MapKind for Params {
    fn load(&self, _folder: &Path, _seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        Ok(OccupancyGrid::empty(self.cols.get() as i32, self.rows.get() as i32, self.resolution_m.get()))
    }

    fn is_fixed(&self) -> bool {
        true
    }
}
