//! Scenario files: YAML becomes a checked [`Scenario`], or an error that points at the line.
//!
//! Reading goes in steps, and the first one that fails speaks: the text as such (size, nesting,
//! syntax, keys written twice), the edits of the command line, the types (unknown keys and planners,
//! wrong types, ranges), then [`Scenario::consistent`] (numbers that contradict each other) and
//! [`Scenario::check`] (what the map says: start inside a wall, no way to the goal).
//!
//! ```
//! let text = "map: {ascii: {rows: ['....', '....']}}\nstacks: {global: [a_star], local: [dwa]}";
//! ```

mod check;
mod edit;
mod error;
mod explain;
mod file;
mod key_path;
mod schema;
mod shape;
mod stacks;

pub use edit::Edit;
pub use error::ScenarioError;
pub use file::{ScenarioFile, load};
pub use key_path::{KeyPath, Step};
pub use stacks::{Global, Listed, Product, Stacks};

use crate::episode::TerminationSpec;
use crate::map::MapSpec;
use crate::metrics::MetricsSpec;
use crate::plan::stack::{PlanningSpec, StackSpec};
use crate::quantity::Count;
use crate::robot::{Limits, RobotSpec};
use crate::world::spec::{GoalSpec, ObstaclesSpec, SensingSpec, StartSpec};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// Everything that a scenario file says, with every default filled in.
///
/// Equal scenarios give equal results, whatever their files look like.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name of the scenario and of its folder of results; by default the file's name without `.yaml`.
    #[serde(default)]
    pub name: Name,
    /// What the scenario shows, in words.
    #[serde(default)]
    pub description: String,
    /// Seed of all randomness, a whole number; default 1.
    #[serde(default = "one")]
    pub seed: u64,
    /// Number of episodes, each with its own random world; default 1.
    #[serde(default = "once")]
    pub episodes: Count,
    /// The known map: drawn here, read from a file, or generated.
    pub map: MapSpec,
    /// Where the robot starts; by default a random free cell, heading for the goal.
    #[serde(default)]
    pub start: StartSpec,
    /// Where it is to go; by default a random free cell.
    #[serde(default)]
    pub goal: GoalSpec,
    /// Obstacles that the known map does not show; by default none.
    #[serde(default)]
    pub obstacles: ObstaclesSpec,
    /// What the robot senses of its surroundings.
    #[serde(default)]
    pub sensing: SensingSpec,
    /// The robot's shape and drive.
    #[serde(default)]
    pub robot: RobotSpec,
    /// What the drive may do.
    #[serde(default)]
    pub limits: Limits,
    /// Where planned paths may go, and how they are followed.
    #[serde(default)]
    pub planning: PlanningSpec,
    /// When an episode ends.
    #[serde(default)]
    pub termination: TerminationSpec,
    /// Thresholds of the metrics.
    #[serde(default)]
    pub metrics: MetricsSpec,
    /// The planners that drive.
    pub stacks: Stacks,
}

fn one() -> u64 {
    1
}

fn once() -> Count {
    Count::new(1)
}

impl Scenario {
    /// Every stack, in the order of rows in results.
    pub fn stacks(&self) -> Vec<StackSpec> {
        self.stacks.specs()
    }

    /// The scenario as YAML with every default written out; reading it back gives an equal scenario.
    pub fn to_yaml(&self) -> String {
        serde_yaml::to_string(self).expect("a scenario is made of maps, lists, texts and finite numbers")
    }

    /// The JSON Schema of scenario files, for editors.
    pub fn schema() -> serde_json::Value {
        schemars::schema_for!(Scenario).to_value()
    }
}

/// A name that may become part of a file name: letters, digits, `_`, `-` and `+`, at most 100.
///
/// The empty name is that of a scenario that was not given one; files cannot spell it.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Name(String);

impl Name {
    /// The name as a text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl TryFrom<&str> for Name {
    type Error = String;
    fn try_from(text: &str) -> Result<Self, String> {
        let allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '+');
        if !text.is_empty() && text.len() <= 100 && text.chars().all(allowed) {
            Ok(Self(text.to_owned()))
        } else {
            Err(format!("expected a name of letters, digits, `_`, `-` and `+`, found {text:?}"))
        }
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl serde::de::Visitor<'_> for Reader {
            type Value = Name;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a name of letters, digits, `_`, `-` and `+`")
            }
            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Name, E> {
                Name::try_from(text).map_err(E::custom)
            }
        }
        deserializer.deserialize_str(Reader)
    }
}

impl Serialize for Name {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0)
    }
}

impl JsonSchema for Name {
    fn schema_name() -> Cow<'static, str> {
        "Name".into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "string", "pattern": "^[A-Za-z0-9_+-]{1,100}$"})
    }
}
