//! Choice of an episode's map from a random family: the key `map_seed` of every generator that draws.

use crate::rng::EpisodeSeed;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// Choice of an episode's map from a random family.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MapSeed {
    /// A new map for each episode, from the scenario's seed (`per_episode`).
    #[default]
    PerEpisode,
    /// The same map for all episodes and all seeds of the scenario (a whole number).
    Fixed(u64),
}

impl MapSeed {
    /// The seed from which the map of an episode is drawn.
    pub(super) fn of(self, episode: EpisodeSeed) -> EpisodeSeed {
        match self {
            Self::PerEpisode => episode,
            Self::Fixed(seed) => EpisodeSeed { seed, episode: 0 },
        }
    }
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
