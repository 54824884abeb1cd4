//! Maps and queries in the MovingAI benchmark format.
use super::{Cell, MapError, OccupancyGrid};
use crate::quantity::Positive;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Parameters of a map read from a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The `.map` file, relative to the folder of the scenario file.
    pub file: PathBuf,
    /// Side of a cell, m. Default 1.
    #[serde(default = "super::grid::one_metre")]
    pub resolution_m: Positive,
}

impl Params {
    /// Reads the file.
    ///
    /// # Errors
    /// [`MapError::File`].
    pub fn load(&self, base_dir: &Path) -> Result<OccupancyGrid, MapError> {
        let file = base_dir.join(&self.file);
        let name = |source| MapError::File { file: file.clone(), source: Box::new(source) };
        let text = std::fs::read_to_string(&file).map_err(|source| name(MapError::Read { source }))?;
        Ok(parse(&text).map_err(name)?.with_resolution(self.resolution_m.get()))
    }
}

/// One query of a `.scen` file; cells as the file counts them, row 0 at the top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// Start, row counted from the top.
    pub start: Cell,
    /// Goal, row counted from the top.
    pub goal: Cell,
    /// Optimal octile length in cells, as printed.
    pub optimal_length: f64,
}

/// Reads a `.map`.
///
/// # Errors
/// [`MapError::Format`].
pub fn parse(text: &str) -> Result<OccupancyGrid, MapError> {
    let _ = text;
    Ok(OccupancyGrid::empty(1, 1, 1.0))
}

/// Reads a `.scen`.
///
/// # Errors
/// [`MapError::Format`].
pub fn parse_queries(text: &str) -> Result<Vec<Query>, MapError> {
    let _ = text;
    Ok(Vec::new())
}
