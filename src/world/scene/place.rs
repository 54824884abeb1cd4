//! Start and goal: `random`, a place in the world frame, or a cell.

use crate::geometry::{Pose, Vec2};
use crate::map::{Cell, OccupancyGrid};
use crate::settings::quantity::{CountOrZero, Finite, NonNegative};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// Start of the robot. Written `random`, `[x, y]`, `[x, y, theta]`, `{x: …, y: …, heading_rad: …}` or `cell: [col, row]`.
#[derive(Clone, Debug, PartialEq)]
pub enum StartSpec {
    /// A random free cell centre; the heading points at the goal.
    Random(RandomPlace),
    /// [x, y] in the world frame, m; the heading points at the goal.
    Position([Finite; 2]),
    /// [x, y, theta] in the world frame, m and rad.
    Pose([Finite; 3]),
    /// The centre of a cell; the heading points at the goal.
    Cell(CellPlace),
}

/// Goal of the robot. Written `random`, `[x, y]`, `[x, y, theta]`, `{x: …, y: …, heading_rad: …}` or `cell: [col, row]`.
#[derive(Clone, Debug, PartialEq)]
pub enum GoalSpec {
    /// A random free cell centre.
    Random(RandomPlace),
    /// [x, y] in the world frame, m.
    Position([Finite; 2]),
    /// [x, y, theta] in the world frame, m and rad: also with that heading, where the robot has to stand there.
    Pose([Finite; 3]),
    /// The centre of a cell.
    Cell(CellPlace),
}

/// Parameters of a random start or goal.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RandomPlace {
    /// Least straight distance to the other end, m; where both ends are random, the larger of the two
    /// numbers holds. Default: half the map's diagonal, or a quarter where the other end is given.
    pub distance_min_m: Option<NonNegative>,
}

/// A cell [col, row] of the grid: columns from the left, rows from the bottom, both from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct CellPlace(pub [CountOrZero; 2]);

impl Default for StartSpec {
    fn default() -> Self {
        Self::Random(RandomPlace::default())
    }
}

impl Default for GoalSpec {
    fn default() -> Self {
        Self::Random(RandomPlace::default())
    }
}

/// A position of the world frame in the grid frame.
pub(in crate::world) fn point_to_grid(position: [Finite; 2], grid: &OccupancyGrid) -> Vec2 {
    grid.frame().point_to_grid(Vec2::new(position[0].get(), position[1].get()))
}

/// A pose [x, y, theta] of the world frame in the grid frame.
pub(in crate::world) fn pose_to_grid(pose: [Finite; 3], grid: &OccupancyGrid) -> Pose {
    let [x, y, theta] = pose.map(Finite::get);
    grid.frame().to_grid(Pose::new(x, y, theta))
}

/// A vector of the world frame in the grid frame.
pub(in crate::world) fn turn_to_grid(v: Vec2, grid: &OccupancyGrid) -> Vec2 {
    grid.frame().point_to_grid(v + grid.frame().origin.position)
}

fn centre(cell: CellPlace, grid: &OccupancyGrid) -> Vec2 {
    let [col, row] = cell.0.map(|n| n.get() as i32);
    grid.centre(Cell { col, row })
}

impl StartSpec {
    /// The given position (grid frame) and heading; `None` if the start is random.
    pub fn given(&self, grid: &OccupancyGrid) -> Option<(Vec2, Option<f64>)> {
        match *self {
            Self::Random(_) => None,
            Self::Position(position) => Some((point_to_grid(position, grid), None)),
            Self::Pose(pose) => {
                let pose = pose_to_grid(pose, grid);
                Some((pose.position, Some(pose.theta)))
            }
            Self::Cell(cell) => Some((centre(cell, grid), None)),
        }
    }
}

impl GoalSpec {
    /// The given position (grid frame); `None` if the goal is random.
    pub fn given(&self, grid: &OccupancyGrid) -> Option<Vec2> {
        match *self {
            Self::Random(_) => None,
            Self::Position(position) => Some(point_to_grid(position, grid)),
            Self::Pose(pose) => Some(pose_to_grid(pose, grid).position),
            Self::Cell(cell) => Some(centre(cell, grid)),
        }
    }

    /// The heading that the robot is to have there, grid frame, rad, if one is given.
    pub fn heading_rad(&self, grid: &OccupancyGrid) -> Option<f64> {
        match *self {
            Self::Pose(pose) => Some(pose_to_grid(pose, grid).theta),
            _ => None,
        }
    }
}

const NAMES: &[&str] = &["random", "cell"];

/// Keys of a place that is written as a block: the numbers of the list, each by its name.
const COORDINATES: &[&str] = &["x", "y", "heading_rad"];

/// The place written as `{x: 1, y: 2}` or `{x: 1, y: 2, heading_rad: 0.5}`, of which the first key has been read.
fn coordinates<'de, A: MapAccess<'de>>(first: String, mut map: A) -> Result<StartSpec, A::Error> {
    let mut found = [None; 3];
    let mut next = Some(first);
    while let Some(key) = next {
        let Some(index) = COORDINATES.iter().position(|known| *known == key) else {
            return Err(A::Error::unknown_field(&key, COORDINATES));
        };
        found[index] = Some(map.next_value::<Finite>()?);
        next = map.next_key()?;
    }
    match found {
        [None, ..] => Err(A::Error::missing_field("x")),
        [_, None, _] => Err(A::Error::missing_field("y")),
        [Some(x), Some(y), None] => Ok(StartSpec::Position([x, y])),
        [Some(x), Some(y), Some(heading)] => Ok(StartSpec::Pose([x, y, heading])),
    }
}

/// Reads every spelling of a place.
struct Reader {
    what: &'static str,
}

impl<'de> Visitor<'de> for Reader {
    type Value = StartSpec;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a {}: `random`, [x, y], [x, y, theta], `{{x: …, y: …}}` or `cell: [col, row]`", self.what)
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<StartSpec, E> {
        match name {
            "random" => Ok(StartSpec::default()),
            _ => Err(E::custom(crate::settings::choice::unknown_name(self.what, name, NAMES))),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<StartSpec, A::Error> {
        let Some(name) = map.next_key::<String>()? else {
            return Err(A::Error::invalid_length(0, &self));
        };
        if COORDINATES.contains(&name.as_str()) {
            return coordinates(name, map);
        }
        let place = match name.as_str() {
            "random" => StartSpec::Random(crate::settings::choice::value(&mut map)?),
            "cell" => StartSpec::Cell(map.next_value()?),
            _ => return Err(A::Error::custom(crate::settings::choice::unknown_name(self.what, &name, NAMES))),
        };
        match map.next_key::<String>()? {
            None => Ok(place),
            Some(second) => Err(A::Error::custom(format!("expected one {}, found `{name}` and `{second}`", self.what))),
        }
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<StartSpec, A::Error> {
        let mut numbers = [Finite::new(0.0); 3];
        let mut count = 0;
        while let Some(number) = seq.next_element::<Finite>()? {
            if count == 3 {
                return Err(A::Error::invalid_length(4, &self));
            }
            numbers[count] = number;
            count += 1;
        }
        match count {
            2 => Ok(StartSpec::Position([numbers[0], numbers[1]])),
            3 => Ok(StartSpec::Pose(numbers)),
            _ => Err(A::Error::invalid_length(count, &self)),
        }
    }
}

impl<'de> Deserialize<'de> for StartSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Reader { what: "start" })
    }
}

impl<'de> Deserialize<'de> for GoalSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match deserializer.deserialize_any(Reader { what: "goal" })? {
            StartSpec::Random(params) => Self::Random(params),
            StartSpec::Position(position) => Self::Position(position),
            StartSpec::Cell(cell) => Self::Cell(cell),
            StartSpec::Pose(pose) => Self::Pose(pose),
        })
    }
}

fn entry<S: Serializer>(serializer: S, name: &str, value: &impl Serialize) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(1))?;
    map.serialize_entry(name, value)?;
    map.end()
}

impl Serialize for StartSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Random(params) => entry(serializer, "random", params),
            Self::Position(position) => position.serialize(serializer),
            Self::Pose(pose) => pose.serialize(serializer),
            Self::Cell(cell) => entry(serializer, "cell", cell),
        }
    }
}

impl Serialize for GoalSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Random(params) => entry(serializer, "random", params),
            Self::Position(position) => position.serialize(serializer),
            Self::Pose(pose) => pose.serialize(serializer),
            Self::Cell(cell) => entry(serializer, "cell", cell),
        }
    }
}

fn schema(generator: &mut SchemaGenerator, description: &str) -> Schema {
    schemars::json_schema!({
        "description": description,
        "anyOf": [
            {"enum": ["random"]},
            {"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 3},
            {
                "type": "object",
                "properties": {"random": {"anyOf": [generator.subschema_for::<RandomPlace>(), {"type": "null"}]}},
                "required": ["random"],
                "additionalProperties": false,
            },
            {
                "type": "object",
                "properties": {
                    "x": {"type": "number", "description": "x in the world frame, m."},
                    "y": {"type": "number", "description": "y in the world frame, m."},
                    "heading_rad": {"type": "number", "description": "The heading theta, rad; it may be left out."},
                },
                "required": ["x", "y"],
                "additionalProperties": false,
            },
            {
                "type": "object",
                "properties": {"cell": generator.subschema_for::<CellPlace>()},
                "required": ["cell"],
                "additionalProperties": false,
            },
        ],
    })
}

impl JsonSchema for StartSpec {
    fn schema_name() -> Cow<'static, str> {
        "StartSpec".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        schema(
            generator,
            "Where the robot starts: `random`, [x, y], [x, y, theta], {x: …, y: …} or `cell: [col, row]`.",
        )
    }
}

impl JsonSchema for GoalSpec {
    fn schema_name() -> Cow<'static, str> {
        "GoalSpec".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        schema(
            generator,
            "Where the robot is to go: `random`, [x, y], [x, y, theta], {x: …, y: …} or `cell: [col, row]`.",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_of_a_place_is_read_and_written_back() {
        for text in ["random", "[1.5, 2]", "[1.5, 2, -0.5]", "cell: [3, 4]", "random: {distance_min_m: 7}", "random:"] {
            let start: StartSpec = serde_yaml::from_str(text).unwrap();
            let written = serde_yaml::to_string(&start).unwrap();
            assert_eq!(serde_yaml::from_str::<StartSpec>(&written).unwrap(), start, "{text}: {written}");
        }
        assert_eq!(serde_yaml::from_str::<StartSpec>("random:").unwrap(), StartSpec::default());
        for (keys, list) in [("{x: 1, y: -2}", "[1, -2]"), ("{heading_rad: 0.5, y: -2, x: 1}", "[1, -2, 0.5]")] {
            let [keys, list] = [keys, list].map(|text| serde_yaml::from_str::<StartSpec>(text).unwrap());
            assert_eq!(keys, list);
        }
        assert!(matches!(serde_yaml::from_str("{x: 1, y: 2, heading_rad: 3}"), Ok(GoalSpec::Pose(_))));
        assert!(matches!(serde_yaml::from_str("[1, 2]"), Ok(GoalSpec::Position(_))));
        assert!(matches!(serde_yaml::from_str("[1, 2, 3]"), Ok(GoalSpec::Pose(_))));
    }

    #[test]
    fn a_wrong_place_says_what_is_expected() {
        for (text, part) in [
            ("[1]", "a start: `random`, [x, y], [x, y, theta], `{x: …, y: …}` or `cell: [col, row]`"),
            ("{x: 1}", "missing field `y`"),
            ("{y: 1, heading_rad: 2}", "missing field `x`"),
            ("{x: 1, y: 2, z: 3}", "unknown field `z`, expected one of `x`, `y`, `heading_rad`"),
            ("{x: 1, cell: [1, 2]}", "unknown field `cell`"),
            ("[1, 2, 3, 4]", "invalid length 4"),
            ("randon", "did you mean `random`?"),
            ("[1, .nan]", "a finite number"),
            ("{cell: [1, 2], random: {}}", "found `cell` and `random`"),
        ] {
            let error = serde_yaml::from_str::<StartSpec>(text).unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
        let error = serde_yaml::from_str::<GoalSpec>("[1, 2, 3, 4]").unwrap_err().to_string();
        assert!(
            error.contains("a goal: `random`, [x, y], [x, y, theta], `{x: …, y: …}` or `cell: [col, row]`"),
            "{error}"
        );
    }
}
