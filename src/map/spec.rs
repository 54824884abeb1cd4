//! The scenario key `map`: which map, with which parameters.

use super::{MapError, OccupancyGrid, ascii, empty, movingai, random, warehouse};
use crate::choice::choice;
use crate::rng::EpisodeSeed;
use std::path::Path;

choice! {
    /// The known map of a scenario: drawn in place, read from a file, or generated.
    pub enum MapSpec: "map" { ascii, movingai, random, warehouse, empty }
}

impl MapSpec {
    /// The grid of one episode. Files are looked up relative to `base_dir`, the folder of the scenario.
    ///
    /// # Errors
    /// [`MapError::File`] for a file that cannot be read or does not follow its format,
    /// [`MapError::Contradiction`] for sizes that do not fit together, and
    /// [`MapError::Infeasible`] where no acceptable map was drawn: only this one depends on the seed.
    pub fn load(&self, base_dir: &Path, seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        match self {
            Self::ascii(params) => Ok(params.grid()),
            Self::movingai(params) => params.load(base_dir),
            Self::random(params) => params.generate(seed),
            Self::warehouse(params) => params.build(),
            Self::empty(params) => Ok(params.grid()),
        }
    }

    /// Whether every episode gets the same grid, so that it may be loaded once and shared.
    pub fn is_fixed(&self) -> bool {
        match self {
            Self::ascii(_) | Self::movingai(_) | Self::warehouse(_) | Self::empty(_) => true,
            Self::random(params) => params.map_seed != random::MapSeed::PerEpisode,
        }
    }
}
