//! Sweeps: the same experiment at several values of some keys.
//!
//! Every entry is an axis, and the points of the sweep are the product of the axes in the order of the file, the first one
//! varying slowest:
//!
//! ```yaml
//! sweep:
//!   stacks.local.dwa.horizon_s: [1, 2, 3]                         # a list
//!   limits.speed_max_mps: {from: 0.5, to: 1.5, steps: 5}          # both ends included
//!   zip: {robot.radius_m: [0.2, 0.3], planning.inflation_m: [0.25, 0.35]}   # side by side: one axis of two points
//!   latin_hypercube:                                             # one axis of 20 points that spread over all ranges
//!     points: 20
//!     keys: {stacks.local.dwa.distance_weight: [0.05, 0.5], stacks.local.dwa.velocity_weight: [0.05, 0.5]}
//! ```

use super::error::ScenarioError;
use super::faults::FAULTS_MAX;
use super::key_path::KeyPath;
use super::memory::Memory;
use super::{Edit, Scenario, ScenarioFile};
use crate::map::MapSpec;
use crate::rng::{EpisodeSeed, Purpose};
use crate::settings::quantity::{Count, Finite, counted};
use crate::world::StaticMap;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_yaml::Value;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Largest number of points of one sweep; more is a mistake, or days of computing.
const POINTS_MAX: usize = 10_000;
/// Keys that cannot be swept, because they are no property of a point.
const NOT_SWEPT: [&str; 5] = ["name", "description", "seed", "episodes", "sweep"];

/// Which keys take several values (scenario key `sweep`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sweep(Vec<Axis>);

#[derive(Clone, Debug, PartialEq)]
enum Axis {
    Key(String, Values),
    Zip(Vec<(String, Values)>),
    LatinHypercube(LatinHypercube),
}

/// The values of one key.
#[derive(Clone, Debug, PartialEq)]
enum Values {
    List(Vec<Value>),
    Steps(Steps),
}

/// Evenly spaced values, both ends included.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Steps {
    /// First value.
    from: Finite,
    /// Last value.
    to: Finite,
    /// How many values; at least 2.
    steps: Count,
}

/// Points that fall into every n-th of the range of every key exactly once (M. McKay, R. Beckman, W. Conover, 1979).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LatinHypercube {
    /// How many points.
    points: Count,
    /// Seed of the draw; default 1. It has nothing to do with the seed of the worlds.
    #[serde(default = "one")]
    seed: u64,
    /// The range [lowest, highest] of each key.
    keys: Ranges,
}

fn one() -> u64 {
    1
}

/// Keys with their ranges, in the order of the file.
#[derive(Clone, Debug, PartialEq)]
struct Ranges(Vec<(String, [Finite; 2])>);

/// One value of one key at one point.
#[derive(Clone, Debug, PartialEq)]
struct Setting {
    key: String,
    /// Text behind the key in messages, which says which value of the sweep it is.
    number: String,
    value: Value,
}

/// One point of a sweep, read and checked.
#[derive(Clone, Debug)]
pub struct SweepPoint {
    /// The value of each swept key, as results show it.
    pub values: Vec<String>,
    /// The scenario at this point; its own `sweep` is empty.
    pub scenario: Scenario,
    /// Points of equal number differ in their stacks alone: a stack that both have drives the same episodes.
    pub surroundings: usize,
    /// For each stack, in order, whether each swept key concerns it.
    touched: Vec<Vec<bool>>,
}

impl SweepPoint {
    /// The values of the swept keys in the rows of a stack, by its number; empty if the key does not concern the stack.
    pub fn values_of(&self, stack: usize) -> Vec<String> {
        let values = self.values.iter().zip(&self.touched[stack]);
        values.map(|(value, touched)| if *touched { value.clone() } else { String::new() }).collect()
    }
}

impl Sweep {
    /// Whether nothing is swept.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The swept keys, in the order of the file.
    pub fn keys(&self) -> Vec<String> {
        let mut keys = Vec::new();
        for axis in &self.0 {
            match axis {
                Axis::Key(key, _) => keys.push(key.clone()),
                Axis::Zip(columns) => keys.extend(columns.iter().map(|(key, _)| key.clone())),
                Axis::LatinHypercube(cube) => keys.extend(cube.keys.0.iter().map(|(key, _)| key.clone())),
            }
        }
        keys
    }

    /// Checks the sweep by itself.
    pub(super) fn consistent(&self) -> Result<(), ScenarioError> {
        let refuse = |title: String, label: &str| {
            Err(ScenarioError::new(title).key(KeyPath::parse("sweep")).label(label.to_owned()))
        };
        let keys = self.keys();
        for (index, key) in keys.iter().enumerate() {
            if NOT_SWEPT.contains(&key.as_str()) {
                return refuse(format!("`{key}` cannot be swept"), "the points of a sweep share it");
            }
            if keys[..index].contains(key) {
                return refuse(format!("`{key}` is swept twice"), "a key has one value at a point");
            }
        }
        for axis in &self.0 {
            if let Axis::Zip(columns) = axis
                && let [(first, values), rest @ ..] = columns.as_slice()
                && let Some((other, found)) = rest.iter().find(|(_, others)| others.len() != values.len())
            {
                let (n, m) = (counted(values.len() as u64, "value"), found.len());
                return refuse(format!("`zip` joins {n} of `{first}` to {m} of `{other}`"), "as many of each");
            }
            if let Axis::LatinHypercube(cube) = axis
                && let Some((key, [low, high])) = cube.keys.0.iter().find(|(_, [low, high])| low >= high)
            {
                let title = format!("`{key}` of the hypercube goes from {} to {}", low.get(), high.get());
                return refuse(title, "expected [lowest, highest]");
            }
            if axis.len() == 0 {
                return refuse("a sweep over no values".to_owned(), "an empty list");
            }
        }
        let points = self.0.iter().fold(1usize, |product, axis| product.saturating_mul(axis.len()));
        if points > POINTS_MAX {
            return refuse(format!("a sweep of {points} points"), "at most 10000");
        }
        self.0.iter().try_for_each(Axis::distinct)
    }

    /// The settings of every point.
    fn points(&self) -> Vec<Vec<Setting>> {
        let mut points = vec![Vec::new()];
        for axis in &self.0 {
            let settings: Vec<Vec<Setting>> = axis.points();
            points = points
                .iter()
                .flat_map(|point| settings.iter().map(move |more| point.iter().chain(more).cloned().collect()))
                .collect();
        }
        points
    }
}

impl Axis {
    fn len(&self) -> usize {
        match self {
            Self::Key(_, values) => values.len(),
            Self::Zip(columns) => columns.first().map_or(0, |(_, values)| values.len()),
            Self::LatinHypercube(cube) => cube.points.get() as usize,
        }
    }

    /// Checks that no two points of the axis have the same values.
    fn distinct(&self) -> Result<(), ScenarioError> {
        let (columns, at) = match self {
            Self::Key(key, values) => (vec![values.values()], KeyPath::parse("sweep").key(key)),
            Self::Zip(columns) => {
                (columns.iter().map(|(_, values)| values.values()).collect(), KeyPath::parse("sweep").key("zip"))
            }
            // Its points lie in strata of their own.
            Self::LatinHypercube(_) => return Ok(()),
        };
        let mut seen = BTreeSet::new();
        for k in 0..self.len() {
            let values: Vec<&Value> = columns.iter().map(|column: &Vec<Value>| &column[k]).collect();
            if !seen.insert(values.iter().map(|value| meant(value)).collect::<Vec<String>>()) {
                let shown = values.iter().map(|value| shown(value)).collect::<Vec<String>>().join(", ");
                let (what, are) = if values.len() == 1 { ("value", "is") } else { ("values", "are") };
                let at = if matches!(self, Self::Zip(_)) { at } else { at.item(k) };
                return Err(ScenarioError::new(format!("the {what} {shown} {are} there twice"))
                    .key(at)
                    .label("a point of the sweep is like no other"));
            }
        }
        Ok(())
    }

    fn points(&self) -> Vec<Vec<Setting>> {
        let column = |key: &str, values: &Values| -> Vec<Setting> {
            let numbered = values.values().into_iter().enumerate();
            numbered.map(|(k, value)| Setting { key: key.to_owned(), number: format!("[{k}]"), value }).collect()
        };
        let columns: Vec<Vec<Setting>> = match self {
            Self::Key(key, values) => vec![column(key, values)],
            Self::Zip(columns) => columns.iter().map(|(key, values)| column(key, values)).collect(),
            Self::LatinHypercube(cube) => cube.columns(),
        };
        (0..self.len()).map(|k| columns.iter().map(|column| column[k].clone()).collect()).collect()
    }
}

impl Values {
    fn len(&self) -> usize {
        match self {
            Self::List(values) => values.len(),
            Self::Steps(steps) => steps.steps.get() as usize,
        }
    }

    fn values(&self) -> Vec<Value> {
        match self {
            Self::List(values) => values.clone(),
            Self::Steps(Steps { from, to, steps }) => {
                let (from, to, last) = (from.get(), to.get(), f64::from(steps.get() - 1));
                (0..steps.get()).map(|k| number(from + (to - from) * (f64::from(k) / last))).collect()
            }
        }
    }
}

impl LatinHypercube {
    fn columns(&self) -> Vec<Vec<Setting>> {
        let n = self.points.get() as usize;
        let seed = EpisodeSeed { seed: self.seed, episode: 0 };
        let column = |(index, (key, [low, high])): (usize, &(String, [Finite; 2]))| {
            let mut stream = seed.stream(Purpose::Sweep, index as u64);
            let mut strata: Vec<usize> = (0..n).collect();
            for k in (1..n).rev() {
                strata.swap(k, stream.index(k + 1));
            }
            let (low, high) = (low.get(), high.get());
            let settings = strata.into_iter().enumerate().map(|(k, stratum)| Setting {
                key: key.clone(),
                number: format!(" at point {k} of the hypercube"),
                value: number(low + (high - low) * ((stratum as f64 + stream.uniform()) / n as f64)),
            });
            settings.collect()
        };
        self.keys.0.iter().enumerate().map(column).collect()
    }
}

/// A number as a person would write it: twelve digits behind the point are enough, whole numbers without a point.
fn number(x: f64) -> Value {
    let rounded = (x * 1e12).round() / 1e12;
    let x = if rounded.is_finite() { rounded } else { x };
    if x.fract() == 0.0 && x.abs() < 1e15 { Value::from(x as i64) } else { Value::from(x) }
}

/// A text that is the same for values with the same meaning, such as 1 and 1.0.
fn meant(value: &Value) -> String {
    match value.as_f64() {
        // Every whole number below 2⁵³ is a number of this type.
        Some(x) if x.fract() == 0.0 && x.abs() < 9_007_199_254_740_992.0 => format!("{}", x as i64),
        _ => shown(value),
    }
}

/// A value as a column shows it.
fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        _ => serde_json::to_string(value).unwrap_or_default().replace('"', ""),
    }
}

impl ScenarioFile {
    /// The points of the scenario's sweep, each read and checked against its map; one point without a value if nothing
    /// is swept. `scenario` is the result of [`Self::read`] for the same `edits`.
    ///
    /// # Errors
    /// The first fault of the first faulty point, placed at the value that caused it.
    pub fn points(&self, scenario: &Scenario, edits: &[Edit]) -> Result<Vec<SweepPoint>, ScenarioError> {
        if scenario.sweep.is_empty() {
            self.check(scenario, edits)?;
            let touched = vec![Vec::new(); scenario.stacks().len()];
            let scenario = scenario.clone();
            return Ok(vec![SweepPoint { values: Vec::new(), scenario, surroundings: 0, touched }]);
        }
        let mut reader = PointReader::new(self, scenario, edits)?;
        let (mut points, mut errors): (Vec<SweepPoint>, Vec<ScenarioError>) = (Vec::new(), Vec::new());
        for settings in scenario.sweep.points() {
            match reader.read(settings) {
                Ok(point) => points.push(point),
                // What is wrong at every point is told once.
                Err(error) => errors.extend(
                    error.apart().filter(|new| !errors.iter().any(|known| known.repeats(new))).collect::<Vec<_>>(),
                ),
            }
            if errors.len() >= FAULTS_MAX {
                break;
            }
        }
        ScenarioError::all(errors, &self.shown()).map(|()| points)
    }
}

/// Reads the points of a sweep one after the other. The parts that they share are parsed, edited and checked once.
struct PointReader<'a> {
    file: &'a ScenarioFile,
    /// The scenario with its sweep.
    scenario: &'a Scenario,
    edits: &'a [Edit],
    /// The tree that the settings of a point are put into, without the sweep.
    tree: Value,
    /// The checked scenarios, by their text without the stacks.
    surroundings: BTreeMap<String, usize>,
    /// Points by surroundings and the text of their stacks.
    seen: BTreeSet<(usize, String)>,
    /// The map that was loaded last.
    map: Option<(MapSpec, StaticMap)>,
    /// Cells of the map of each of the surroundings.
    cells: Vec<u64>,
    memory: Memory,
}

impl<'a> PointReader<'a> {
    fn new(file: &'a ScenarioFile, scenario: &'a Scenario, edits: &'a [Edit]) -> Result<Self, ScenarioError> {
        let (mut tree, _) = file.edited(edits, Scenario::schema())?;
        if let Value::Mapping(keys) = &mut tree {
            keys.remove("sweep");
        }
        let (surroundings, seen) = (BTreeMap::new(), BTreeSet::new());
        let memory = file.memory();
        Ok(Self { file, scenario, edits, tree, surroundings, seen, map: None, cells: Vec::new(), memory })
    }

    fn read(&mut self, settings: Vec<Setting>) -> Result<SweepPoint, ScenarioError> {
        let swept: Vec<Edit> = settings.iter().map(Setting::edit).collect();
        let at = |error: ScenarioError| {
            let at: Vec<String> = settings.iter().map(|s| format!("{} = {}", s.key, shown(&s.value))).collect();
            error.note(format!("at the sweep's point {}", at.join(", ")))
        };
        // Straight from the tree. Where that fails, the way through the text says why, or knows better.
        let mut tree = self.tree.clone();
        let schema = Scenario::schema();
        let landed: Result<Vec<Vec<KeyPath>>, _> = swept.iter().map(|edit| edit.apply(&mut tree, schema)).collect();
        let edits = || self.edits.iter().chain(&swept).cloned().collect::<Vec<Edit>>();
        let direct = serde_yaml::from_value(tree).ok().and_then(|mut point: Scenario| {
            point.name = self.scenario.name.clone();
            point.consistent().ok().map(|()| point)
        });
        let mut point = match direct {
            Some(point) => point,
            None => self.file.read(&edits()).map_err(at)?,
        };
        let landed = landed.map_err(at)?;
        point.sweep = Sweep::default();

        let text = point.text_without_stacks();
        let surroundings = match self.surroundings.get(&text) {
            Some(&number) => {
                let checked = self.memory.check(&point, self.cells[number], self.file.folder());
                let checked = checked.and_then(|()| self.check_stacks(&point));
                checked.map_err(|error| at(self.file.place(error, &edits())))?;
                number
            }
            None => {
                let edits = edits();
                self.check(&point, &edits).map_err(at)?;
                self.surroundings.insert(text, self.surroundings.len());
                self.cells.push(self.map.as_ref().map_or(0, |(_, map)| cells(map)));
                self.surroundings.len() - 1
            }
        };
        let stacks = serde_json::to_string(&point.stacks).expect("stacks are names and finite numbers");
        if !self.seen.insert((surroundings, stacks)) {
            let error = ScenarioError::new("a point of the sweep changes nothing: it is an earlier one in other words");
            return Err(at(self.file.place(error.key(KeyPath::parse("sweep")), self.edits)));
        }
        let values = settings.iter().map(|setting| shown(&setting.value)).collect();
        let by_key: Vec<Vec<Vec<bool>>> =
            landed.iter().map(|places| places.iter().map(|place| point.stacks.touched_by(place)).collect()).collect();
        let touches = |stack: usize| by_key.iter().map(|places| places.iter().any(|place| place[stack])).collect();
        let touched = (0..point.stacks().len()).map(touches).collect();
        Ok(SweepPoint { values, scenario: point, surroundings, touched })
    }

    /// Checks the stacks of a point whose surroundings have been checked.
    fn check_stacks(&mut self, point: &Scenario) -> Result<(), ScenarioError> {
        if self.map.as_ref().is_none_or(|(spec, _)| *spec != point.map) {
            let map = point.load_map(self.file.folder(), &mut Memory::default())?;
            self.map = map.map(|map| (point.map.clone(), map));
        }
        self.map.as_ref().map_or(Ok(()), |(_, map)| point.check_planners(map))
    }

    /// Checks a point against its map, which is loaded anew only if it differs from the last one.
    fn check(&mut self, point: &Scenario, edits: &[Edit]) -> Result<(), ScenarioError> {
        let folder = self.file.folder();
        match &self.map {
            Some((spec, map)) if *spec == point.map => self.memory.check(point, cells(map), folder),
            _ => point.load_map(folder, &mut self.memory).map(|map| self.map = map.map(|map| (point.map.clone(), map))),
        }
        .map_err(|error| self.file.place(error, edits))?;
        let Some((_, map)) = &self.map else { return Ok(()) };
        point.check_on(map, folder).map_err(|error| self.file.place(error, edits))
    }
}

fn cells(map: &StaticMap) -> u64 {
    map.grid.occupied().len() as u64
}

impl Setting {
    fn edit(&self) -> Edit {
        let Self { key, number, value } = self;
        Edit::new("sweep['", key, &format!("']{number}: {}", shown(value)), value.clone())
    }
}

impl<'de> Deserialize<'de> for Sweep {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Sweep;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("keys with lists of values: `path.to.key: [1, 2]`")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Sweep, A::Error> {
                let mut axes = Vec::new();
                while let Some(key) = map.next_key::<String>()? {
                    axes.push(match key.as_str() {
                        "zip" => Axis::Zip(map.next_value::<Columns>()?.0),
                        "latin_hypercube" => Axis::LatinHypercube(map.next_value()?),
                        _ => Axis::Key(key, map.next_value()?),
                    });
                }
                Ok(Sweep(axes))
            }
        }
        deserializer.deserialize_map(Reader)
    }
}

impl Serialize for Sweep {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for axis in &self.0 {
            match axis {
                Axis::Key(key, values) => map.serialize_entry(key, values)?,
                Axis::Zip(columns) => map.serialize_entry("zip", &Columns(columns.clone()))?,
                Axis::LatinHypercube(cube) => map.serialize_entry("latin_hypercube", cube)?,
            }
        }
        map.end()
    }
}

impl JsonSchema for Sweep {
    fn schema_name() -> Cow<'static, str> {
        "Sweep".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "Keys by path (`stacks.local.dwa.horizon_s`), each with its values; the points are the product.",
            "type": "object",
            "properties": {
                "zip": {
                    "description": "Keys whose values go side by side instead of making a product.",
                    "type": "object",
                    "additionalProperties": generator.subschema_for::<Values>(),
                    "examples": [{"limits.speed_max_mps": [0.5, 1.0], "limits.acceleration_max_mps2": [0.25, 0.5]}],
                },
                "latin_hypercube": generator.subschema_for::<LatinHypercube>(),
            },
            "additionalProperties": generator.subschema_for::<Values>(),
            "examples": [{"limits.speed_max_mps": [0.5, 1.0]}],
        })
    }
}

/// Pairs in the order of the file.
fn pairs<'de, A: MapAccess<'de>, T: Deserialize<'de>>(mut map: A) -> Result<Vec<(String, T)>, A::Error> {
    let mut pairs = Vec::new();
    while let Some(pair) = map.next_entry()? {
        pairs.push(pair);
    }
    Ok(pairs)
}

/// The keys of a `zip`.
struct Columns(Vec<(String, Values)>);

macro_rules! ordered_map {
    ($name:ident, $value:ty, $expected:literal) => {
        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Reader;
                impl<'de> Visitor<'de> for Reader {
                    type Value = $name;
                    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                        f.write_str($expected)
                    }
                    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<$name, A::Error> {
                        pairs::<A, $value>(map).map($name)
                    }
                }
                deserializer.deserialize_map(Reader)
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_map(self.0.iter().map(|(key, value)| (key, value)))
            }
        }
    };
}

ordered_map!(Columns, Values, "keys with lists of values");
ordered_map!(Ranges, [Finite; 2], "keys with ranges: `path.to.key: [lowest, highest]`");

impl JsonSchema for Ranges {
    fn schema_name() -> Cow<'static, str> {
        "Ranges".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "object",
            "additionalProperties": generator.subschema_for::<[Finite; 2]>(),
            "examples": [{"limits.speed_max_mps": [0.5, 1.5]}],
        })
    }
}

impl<'de> Deserialize<'de> for Values {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Values;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of values, or `{from: …, to: …, steps: …}`")
            }
            fn visit_seq<A: serde::de::SeqAccess<'de>>(self, mut list: A) -> Result<Values, A::Error> {
                let mut values = Vec::new();
                while let Some(value) = list.next_element()? {
                    values.push(value);
                }
                Ok(Values::List(values))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Values, A::Error> {
                let steps = Steps::deserialize(serde::de::value::MapAccessDeserializer::new(map))?;
                if steps.steps.get() < 2 || steps.from == steps.to {
                    return Err(A::Error::custom("expected at least 2 steps between two different values"));
                }
                Ok(Values::Steps(steps))
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

impl Serialize for Values {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::List(values) => values.serialize(serializer),
            Self::Steps(steps) => steps.serialize(serializer),
        }
    }
}

impl JsonSchema for Values {
    fn schema_name() -> Cow<'static, str> {
        "SweptValues".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({"anyOf": [{"type": "array", "minItems": 1}, generator.subschema_for::<Steps>()]})
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: &str = "map: {empty: {cols: 20, rows: 10}}\nstacks: {global: [a_star], local: [dwa, pure_pursuit]}\n";

    fn points(sweep: &str) -> Result<Vec<SweepPoint>, ScenarioError> {
        let file = ScenarioFile::from_text("scenario.yaml", format!("{BASE}{sweep}"));
        file.points(&file.read(&[])?, &[])
    }

    fn values(sweep: &str) -> Vec<Vec<String>> {
        points(sweep).unwrap_or_else(|error| panic!("{error}")).into_iter().map(|point| point.values).collect()
    }

    #[test]
    fn axes_make_a_product_in_the_order_of_the_file() {
        let found = values(
            "sweep:\n  limits.speed_max_mps: {from: 0.5, to: 1.5, steps: 3}\n  stacks.local.dwa.horizon_s: [1, 2.5]\n",
        );
        let expected = [["0.5", "1"], ["0.5", "2.5"], ["1", "1"], ["1", "2.5"], ["1.5", "1"], ["1.5", "2.5"]];
        assert_eq!(found, expected);
        let zipped = values(
            "sweep:\n  sensing.range_m: [3, 4]\n  zip: {robot.radius_m: [0.2, 0.3], planning.inflation_m: [0.25, 0.35]}\n",
        );
        assert_eq!(zipped, [["3", "0.2", "0.25"], ["3", "0.3", "0.35"], ["4", "0.2", "0.25"], ["4", "0.3", "0.35"]]);
    }

    #[test]
    fn a_point_is_the_scenario_with_those_values_and_no_sweep() {
        let swept = points("sweep: {limits.speed_max_mps: [0.5, 0.75]}").unwrap();
        for (point, speed) in swept.iter().zip([0.5, 0.75]) {
            let text = format!("{BASE}limits: {{speed_max_mps: {speed}}}");
            assert_eq!(point.scenario, ScenarioFile::from_text("scenario.yaml", text).read(&[]).unwrap());
        }
        let plain = points("").unwrap();
        assert_eq!((plain.len(), plain[0].values.len()), (1, 0));
        // Points are read from the tree; the way through the text gives the same, also where a text looks like a number.
        let (more, sweep) = (
            "description: 12",
            "sweep: {stacks.local.dwa.horizon_s: [1, 2.5], stacks.replan: [never, every: {period_s: 3}]}",
        );
        let file = ScenarioFile::from_text("scenario.yaml", format!("{BASE}{more}\n{sweep}"));
        let found = file.points(&file.read(&[]).unwrap(), &[]).unwrap();
        assert_eq!(found.len(), 4);
        for (point, (horizon, replan)) in found.iter().zip([
            ("1", "never"),
            ("1", "{every: {period_s: 3}}"),
            ("2.5", "never"),
            ("2.5", "{every: {period_s: 3}}"),
        ]) {
            let set = |text: &str| Edit::parse(text).unwrap();
            let edits = [
                set(&format!("stacks.local.dwa.horizon_s={horizon}")),
                set(&format!("stacks.replan={replan}")),
                set("sweep={}"),
            ];
            assert_eq!(point.scenario, file.read(&edits).unwrap());
        }
    }

    #[test]
    fn a_hypercube_hits_every_stratum_of_every_key_once() {
        let cube =
            "sweep: {latin_hypercube: {points: 25, keys: {limits.speed_max_mps: [0.5, 1.5], sensing.range_m: [3, 8]}}}";
        let found = values(cube);
        assert_eq!(found, values(cube), "the same again");
        for (key, low, high) in [(0, 0.5, 1.5), (1, 3.0, 8.0)] {
            let mut strata: Vec<usize> = found
                .iter()
                .map(|point| ((point[key].parse::<f64>().unwrap() - low) / (high - low) * 25.0) as usize)
                .collect();
            assert_ne!(strata, (0..25).collect::<Vec<_>>(), "shuffled");
            strata.sort_unstable();
            assert_eq!(strata, (0..25).collect::<Vec<_>>());
        }
        assert_ne!(found, values(&cube.replace("points: 25", "points: 25, seed: 2")));
    }

    #[test]
    fn the_resolved_form_reads_back() {
        let text = format!(
            "{BASE}sweep:\n  stacks.local.dwa.horizon_s: [1, 2]\n  zip: {{robot.radius_m: [0.2], planning.replan: [when_stuck]}}\n  \
             latin_hypercube: {{points: 2, keys: {{sensing.range_m: [3, 8]}}}}\n"
        );
        let scenario = ScenarioFile::from_text("scenario.yaml", text).read(&[]).unwrap();
        let again = ScenarioFile::from_text("scenario.yaml", scenario.to_yaml()).read(&[]).unwrap();
        assert_eq!(again, scenario, "{}", scenario.to_yaml());
        assert_eq!(
            scenario.sweep.keys(),
            ["stacks.local.dwa.horizon_s", "robot.radius_m", "planning.replan", "sensing.range_m"]
        );
    }

    #[test]
    fn a_value_may_come_again_in_a_zip_whose_tuples_differ() {
        let found = values("sweep: {zip: {robot.radius_m: [0.2, 0.2, 0.3], sensing.range_m: [3, 4, 4]}}");
        assert_eq!(found, [["0.2", "3"], ["0.2", "4"], ["0.3", "4"]]);
    }

    #[test]
    fn rows_say_the_values_of_the_keys_that_touch_their_stack() {
        let found = points("sweep: {limits.speed_max_mps: [0.5, 1], stacks.local.dwa.horizon_s: [1, 2]}").unwrap();
        assert_eq!(
            found.iter().map(|point| point.values_of(0).join("|")).collect::<Vec<_>>(),
            ["0.5|1", "0.5|2", "1|1", "1|2"]
        );
        assert_eq!(
            found.iter().map(|point| point.values_of(1).join("|")).collect::<Vec<_>>(),
            ["0.5|", "0.5|", "1|", "1|"]
        );
        assert_eq!(found.iter().map(|point| point.surroundings).collect::<Vec<_>>(), [0, 0, 1, 1]);
    }

    #[test]
    fn faults_name_the_value_of_the_sweep() {
        for (sweep, expected) in [
            ("sweep: {limits.speed_max_mps: [1, -1]}", "sweep['limits.speed_max_mps'][1]: -1"),
            ("sweep: {limits.speed_max_mp: [1]}", "did you mean `speed_max_mps`?"),
            ("sweep: {limits.speed_max_mps: [1, 1]}", "the value 1 is there twice"),
            ("sweep: {seed: [1, 2]}", "`seed` cannot be swept"),
            ("sweep: {zip: {robot.radius_m: [0.2, 0.3], sensing.range_m: [1]}}", "`zip` joins 2 values"),
            ("sweep: {robot.radius_m: {from: 1, to: 1, steps: 3}}", "at least 2 steps"),
            ("sweep: {robot.radius_m: []}", "a sweep over no values"),
            ("sweep: {robot.radius_m: [0.2, 30]}", "at the sweep's point robot.radius_m = 30"),
        ] {
            let error = points(&format!("start: [1, 1]\ngoal: [18, 8]\n{sweep}")).unwrap_err().to_string();
            assert!(error.contains(expected), "{sweep}: {error}");
        }
    }
}
