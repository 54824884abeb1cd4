//! Behaviour of every kind of map, and its registry entry.

use super::file::FileFormat;
use super::{Cell, MapError, MapSeed, OccupancyGrid};
use crate::rng::EpisodeSeed;
use crate::settings::quantity::Positive;
use std::path::{Path, PathBuf};

/// A kind of map, with its parameters.
pub trait MapKind {
    /// The grid of one episode; files are looked up relative to `folder`, the folder of the scenario.
    ///
    /// # Errors
    /// [`MapError::File`] for a file that cannot be read or does not follow its format,
    /// [`MapError::Contradiction`] for sizes that do not fit together, and
    /// [`MapError::Infeasible`] if no acceptable map was drawn: only this one depends on the seed.
    fn load(&self, folder: &Path, seed: EpisodeSeed) -> Result<OccupancyGrid, MapError>;

    /// Whether every episode gets the same grid.
    fn is_fixed(&self) -> bool;

    /// The files that [`load`](Self::load) reads: the one that the parameters name, and those that this one names in turn. Relative to `folder` as the
    /// parameters are.
    fn files(&self, _folder: &Path) -> Vec<PathBuf> {
        Vec::new()
    }

    /// Whether nobody knows what a cell holds; whether it then counts as occupied is a parameter of the kind.
    fn is_unknown(&self, _folder: &Path, _cell: Cell) -> bool {
        false
    }

    /// What the map's file says that was not used, or should be looked at, in words; none if it cannot be read.
    fn notes(&self, _folder: &Path) -> Vec<String> {
        Vec::new()
    }
}

/// A kind of map that is drawn from a seed.
pub trait Generator {
    /// Choice of the map of an episode from the family (scenario key `map_seed` of the kind).
    fn map_seed(&self) -> MapSeed;

    /// The map of a seed; every draw comes from its stream `map`.
    ///
    /// # Errors
    /// [`MapError::Contradiction`] for sizes that do not fit together, and
    /// [`MapError::Infeasible`] if no acceptable map was drawn.
    fn generate(&self, seed: EpisodeSeed) -> Result<OccupancyGrid, MapError>;
}

impl<G: Generator> MapKind for G {
    fn load(&self, _folder: &Path, seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        self.generate(self.map_seed().of(seed))
    }

    fn is_fixed(&self) -> bool {
        self.map_seed() != MapSeed::PerEpisode
    }
}

/// Registry entry of a kind of map.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// One line that describes it.
    pub summary: &'static str,
    /// The formats of map files that it brings; empty for a map that is not in a file of its own.
    pub files: &'static [FileFormat],
}

/// Default resolution of maps, m: the seed papers count in cells of 1 m (systems.md §1.1).
pub(super) fn one_metre() -> Positive {
    Positive::new(1.0)
}
