//! Scenario files: YAML becomes a checked [`Scenario`], or an error that points at the line.
//!
//! Reading goes in steps: the text as such (size, nesting, syntax, keys written twice), the edits of the
//! command line, the types (unknown keys and planners, wrong types, ranges), then [`Scenario::consistent`]
//! (numbers that contradict each other) and [`Scenario::check`] (faults against the map: start inside a wall,
//! no way to the goal). A [`ScenarioError`] tells all faults of a step, and those of later steps that have
//! nothing to do with them.
//!
//! ```
//! use simrun::scenario::ScenarioFile;
//!
//! let text = "map: {empty: {cols: 20, rows: 10}}\nstacks: {global: [a_star], local: [dwa]}";
//! let scenario = ScenarioFile::from_text("corridor.yaml", text).read(&[])?;
//! assert_eq!(scenario.stacks()[0].name, "a_star+dwa");
//!
//! let error = ScenarioFile::from_text("corridor.yaml", text.replace("rows", "rwos")).read(&[]).unwrap_err();
//! assert!(error.to_string().contains("did you mean `rows`?"));
//! # Ok::<(), simrun::scenario::ScenarioError>(())
//! ```

mod check;
mod differences;
mod edit;
mod error;
mod explain;
mod faults;
mod file;
mod key_path;
mod memory;
mod ranges;
pub mod reference;
mod resolved;
mod schema;
mod shape;
mod stacks;
mod sweep;

pub use differences::differences;
pub use edit::Edit;
pub use error::{ErrorParts, ScenarioError};
pub use file::{DocumentError, ScenarioFile, load, read_document};

pub use key_path::{KeyPath, Step};
pub use memory::Room;
pub use stacks::{Global, Listed, Product, Stacks};
pub use sweep::{Sweep, SweepPoint};

use crate::episode::TerminationSpec;
use crate::map::MapSpec;
use crate::metrics::MetricsSpec;
use crate::plan::stack::{PlanningSpec, StackSpec};
use crate::robot::{Limits, RobotSpec};
use crate::settings::quantity::{Count, Period};
use crate::world::{
    ActuationSpec, DT_S, GoalSpec, LocalisationSpec, ObstaclesSpec, SceneError, SceneSpec, ScriptEntry, SensingSpec,
    StartSpec,
};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// Everything that a scenario file says, with every default filled in.
///
/// Equal scenarios give equal results, whatever their files look like.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name of the scenario and of its folder of results; by default the file's name without `.yaml`.
    #[serde(default, skip_serializing_if = "Name::is_empty")]
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
    /// Time from one decision to the next, s: 0.001 to 10; default 0.1. The world is the same whatever it is.
    #[serde(default = "tenth_of_a_second")]
    pub control_period_s: Period,
    /// The known map: drawn here, read from a file, or generated. A map file may stand alone: `map: site.yaml`.
    #[serde(deserialize_with = "MapSpec::or_file")]
    #[schemars(schema_with = "MapSpec::schema_or_file")]
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
    /// How well the robot knows where it is.
    #[serde(default)]
    pub localisation: LocalisationSpec,
    /// How well it does what it is told.
    #[serde(default)]
    pub actuation: ActuationSpec,
    /// What happens at given times; by default nothing.
    #[serde(default)]
    pub script: Vec<ScriptEntry>,
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
    /// Keys that take several values, one after the other; by default none.
    #[serde(default)]
    pub sweep: Sweep,
}

fn tenth_of_a_second() -> Period {
    Period::new(DT_S)
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

    /// The specification from which scenes are drawn, with its recordings read; files are looked up relative to `folder`.
    ///
    /// # Errors
    /// The first recording that cannot be read.
    pub fn scene_spec(&self, folder: &Path) -> Result<SceneSpec, SceneError> {
        SceneSpec::new(self.start.clone(), self.goal.clone(), self.obstacles.clone(), self.script.clone(), folder)
    }

    /// Every file that the scenario names, and those that they name in turn; relative to `folder`, the scenario's own, unless absolute.
    pub fn files(&self, folder: &Path) -> Vec<PathBuf> {
        self.map.files(folder).into_iter().chain(self.obstacles.files()).collect()
    }

    /// The scenario as YAML with every default written out; reading it back gives an equal scenario.
    pub fn to_yaml(&self) -> String {
        serde_yaml::to_string(self).expect("a scenario is made of maps, lists, texts and finite numbers")
    }

    /// A text that two scenarios share if they differ in their stacks alone.
    fn text_without_stacks(&mut self) -> String {
        let stacks = std::mem::replace(&mut self.stacks, Stacks::List(Vec::new()));
        let text = serde_json::to_string(self).expect("a scenario is made of maps, lists, texts and finite numbers");
        self.stacks = stacks;
        text
    }

    /// The JSON Schema of scenario files, for editors.
    pub fn schema() -> &'static serde_json::Value {
        static SCHEMA: LazyLock<serde_json::Value> =
            LazyLock::new(|| schema::named_by_path(schemars::schema_for!(Scenario).to_value()));
        &SCHEMA
    }

    /// The JSON Schema as text, as `simrun schema` prints it and `docs/scenario.schema.json` holds it.
    pub fn schema_text() -> String {
        let text = serde_json::to_string_pretty(Self::schema()).expect("a schema is a tree of texts and numbers");
        text + "\n"
    }
}

/// A name that may become part of a file name: letters, digits, `_`, `-` and `+`, at most 100.
///
/// The empty name is that of a scenario that was not given one; files cannot spell it.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Name(String);

impl Name {
    /// Whether it is the name of a scenario that was not given one.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

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
            // `2024` and `true` are names; `1e3` would be another one once the tree is written anew.
            fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<Name, E> {
                self.visit_str(&number.to_string())
            }
            fn visit_bool<E: serde::de::Error>(self, value: bool) -> Result<Name, E> {
                self.visit_str(if value { "true" } else { "false" })
            }
        }
        // As the tree that `--set` edits is read.
        deserializer.deserialize_any(Reader)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{EpisodeSeed, Purpose};

    fn read(text: &str) -> Scenario {
        ScenarioFile::from_text("scenario.yaml", text).read(&[]).unwrap_or_else(|error| panic!("{error}"))
    }

    const SMALL: &str = "map: {empty: {cols: 20, rows: 10}}\nstacks: {global: [a_star], local: [dwa]}";

    const FULL: &str = r#"
name: everything
description: |
  Every key, with "quotes", a colon: and
  - two lines.
seed: 18446744073709551615
episodes: 100
map: {ascii: {rows: [".....", ".#.#.", "....."], resolution_m: 0.5, origin: [-1e-3, 2, 0.1]}}
start: {cell: [0, 0]}
goal: [1.9e0, 3]
obstacles:
  unknown_static:
    - fixed: {pose: [1, 2, 0.5], shape: {disc: {radius_m: 0.4}}}
    - random: {count: 4, placement: {near_route: {distance_max_m: 2}}}
  moving:
    - random
    - fixed: {position: [3, 4], speed_mps: 1, heading_rad: -1.5, on_static: stop, on_robot: yield}
sensing: {range_m: 4}
robot: {radius_m: 0.2, wheel_speed_max_mps: 1.25}
limits: {reverse_speed_max_mps: 0.1, deceleration_max_mps2: 1}
planning: {inflation_m: 0}
termination: {timeout_s: 300}
metrics: {near_miss_m: 0.1}
stacks:
  - {global: a_star, path: [line_of_sight], local: {pure_pursuit: {lookahead_m: 0.7}}}
  - {name: alone, global: none, local: dwa, replan: {every: {period_s: 2}}}
"#;

    #[test]
    fn the_resolved_form_reads_back_to_an_equal_scenario() {
        for text in [SMALL, FULL] {
            let scenario = read(text);
            let resolved = scenario.to_yaml();
            assert_eq!(read(&resolved), scenario, "{resolved}");
            assert_eq!(read(&resolved).to_yaml(), resolved);
        }
    }

    #[test]
    fn shorthands_mean_the_forms_in_full() {
        const STACKS: &str = "stacks: {global: [a_star], local: [dwa]}";
        for (short, full) in [
            ("map: maps/site.yaml", "map: {ros: {file: maps/site.yaml}}"),
            ("map: SITE.YML", "map: {ros: {file: SITE.YML}}"),
            ("map: hall.map", "map: {movingai: {file: hall.map}}"),
            ("map: {ros: site.yaml}", "map: {ros: {file: site.yaml, unknown: occupied}}"),
            ("map: {movingai: hall.map}", "map: {movingai: {file: hall.map, resolution_m: 1}}"),
            ("map: {ascii: \"..\\n.#\"}", "map: {ascii: {rows: ['..', '.#']}}"),
            ("map: warehouse\nstart: {x: 1, y: 2}", "map: {warehouse: {}}\nstart: [1, 2]"),
            ("map: warehouse\ngoal: {x: 1, y: 2, heading_rad: 3}", "map: {warehouse: {}}\ngoal: [1, 2, 3]"),
        ] {
            assert_eq!(read(&format!("{short}\n{STACKS}")), read(&format!("{full}\n{STACKS}")), "{short}");
        }
        let set = |set: &str| vec![Edit::parse(set).unwrap()];
        let file = ScenarioFile::from_text("scenario.yaml", SMALL);
        assert_eq!(
            file.read(&set("map=hall.map")).unwrap(),
            file.read(&set("map={movingai: {file: hall.map}}")).unwrap()
        );
        for (map, part) in [
            ("site.pgm", "`simrun map convert"),
            ("hall.txt", "a drawing stands in the scenario itself"),
            ("site.tif", "`site.tif` is no map file: they end in .txt, .map (MovingAI)"),
            ("warehous", "did you mean `warehouse`?"),
            ("{ros: 5}", "expected a block of keys, or `file` alone"),
        ] {
            let text = format!("map: {map}\n{STACKS}");
            let error = ScenarioFile::from_text("scenario.yaml", text).read(&[]).unwrap_err().to_string();
            assert!(error.contains(part) && error.contains("scenario.yaml:1:"), "{error}");
        }
    }

    #[test]
    fn a_scalar_means_the_same_in_a_file_and_in_an_edit() {
        for (key, written) in [
            ("sensing.range_m", "0x10"),
            ("sensing.range_m", "010"),
            ("sensing.range_m", "1e1"),
            ("limits.speed_max_mps", "-nan"),
            ("limits.speed_max_mps", ".5"),
            ("episodes", "1e3"),
            ("episodes", "0o12"),
            ("seed", "-0"),
            ("seed", "010"),
            ("seed", "0x1F"),
            ("name", "1e3"),
            ("name", "0x10"),
            ("name", "true"),
            ("description", "1e3"),
            ("planning.replan", "never"),
        ] {
            let nested = match key.split_once('.') {
                Some((block, inner)) => format!("{block}: {{{inner}: {written}}}"),
                None => format!("{key}: {written}"),
            };
            let by_file = ScenarioFile::from_text("scenario.yaml", format!("{SMALL}\n{nested}")).read(&[]);
            let by_edit = Edit::parse(&format!("{key}={written}"));
            let by_edit = by_edit.and_then(|edit| ScenarioFile::from_text("scenario.yaml", SMALL).read(&[edit]));
            match (by_file, by_edit) {
                (Ok(by_file), Ok(by_edit)) => assert_eq!(by_file, by_edit, "{nested}"),
                (Err(by_file), Err(by_edit)) => assert_eq!(by_file.title(), by_edit.title(), "{nested}"),
                (by_file, by_edit) => panic!("{nested}: {by_file:?} {by_edit:?}"),
            }
        }
    }

    #[test]
    fn the_resolved_form_holds_every_key_of_the_schema_at_the_top() {
        let resolved: serde_yaml::Mapping = serde_yaml::from_str(&read(SMALL).to_yaml()).unwrap();
        let schema = Scenario::schema();
        let mut keys: Vec<&str> = schema["properties"].as_object().unwrap().keys().map(String::as_str).collect();
        let mut written: Vec<&str> = resolved.keys().map(|key| key.as_str().unwrap()).collect();
        keys.sort_unstable();
        written.sort_unstable();
        assert_eq!(written, keys);
    }

    #[test]
    fn no_slip_of_the_pen_makes_the_reader_or_its_messages_panic() {
        let pieces = [
            "\t", "  ", "\n", ":", ": ", "- ", "[", "]", "{", "}", "\"", "'", "#", "é", "!", "&a ", "*a", "|", "~",
            "9", ".nan",
        ];
        let mut draws = EpisodeSeed { seed: 1, episode: 0 }.stream(Purpose::Map, 0);
        let (mut read, mut refused) = (0, 0);
        for _ in 0..1000 {
            let mut text: Vec<char> = FULL.chars().collect();
            for _ in 0..=draws.index(3) {
                let at = draws.index(text.len());
                match draws.index(3) {
                    0 => drop(text.drain(at..(at + 1 + draws.index(6)).min(text.len()))),
                    1 => text.swap(at, draws.index(FULL.len() / 2)),
                    _ => drop(text.splice(at..at, pieces[draws.index(pieces.len())].chars())),
                }
            }
            let text: String = text.into_iter().collect();
            let edits = [Edit::parse("limits.speed_max_mps=0.9").unwrap()];
            for edits in [&edits[..], &[]] {
                match ScenarioFile::from_text("slip.yaml", text.clone()).read(edits) {
                    Ok(_) => read += 1,
                    Err(error) => refused += usize::from(error.to_string().starts_with("error: ")),
                }
            }
        }
        assert!(read + refused == 2000 && read > 20 && refused > 1000, "{read} {refused}");
    }

    #[test]
    fn only_map_and_stacks_are_required() {
        assert_eq!(Scenario::schema()["required"], serde_json::json!(["map", "stacks"]));
        let scenario = read(SMALL);
        assert_eq!((scenario.seed, scenario.episodes.get(), scenario.name.as_str()), (1, 1, "scenario"));
        assert_eq!((&scenario.limits, &scenario.robot), (&Limits::default(), &RobotSpec::default()));
    }

    #[test]
    fn the_smallest_scenario_that_messages_show_is_one() {
        let text = shape::SMALLEST.split_once('\n').unwrap().1;
        read(text);
    }

    #[test]
    fn every_key_says_what_it_means() {
        fn visit(place: &schema::Place<'_>, path: &KeyPath) {
            for key in place.keys() {
                let (inner, at) = (place.key(key).unwrap(), path.clone().key(key));
                let is_name_of_choice = place.is_choice(key);
                assert!(is_name_of_choice || inner.meaning().is_some(), "`{at}` has no documentation");
                visit(&inner, &at);
            }
            if let Some(items) = place.items() {
                visit(&items, path);
            }
        }
        visit(&schema::Place::top(Scenario::schema()), &KeyPath::default());
    }
}
