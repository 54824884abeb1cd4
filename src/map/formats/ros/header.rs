//! The YAML header of a ROS map.

use super::writer::OCCUPIED_THRESH;
use crate::map::MapError;
use crate::settings::choice::{nearest, unknown_name};
use crate::settings::quantity::{Finite, Fraction, Positive};
use crate::settings::{COORDINATE_M_MAX, shown};
use serde::de::{Error, IgnoredAny, MapAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::marker::PhantomData;
use std::ops::Deref;

/// The header's keys, all that Nav2 reads and writes.
const KEYS: [&str; 7] = ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode"];

/// The free threshold of an image without a header, that of ROS 1's map saver: the grey 205 that savers write for unknown cells is above
/// it by a hair (50/255 = 0.19608). By the 0.25 that Nav2's saver writes beside maps without that grey it would be free.
const BARE_FREE_THRESH: f64 = 0.196;

/// Most brackets of a header that may be open at once.
const OPEN_MAX: usize = 100;

/// The YAML file. Other keys are passed over, as Nav2 does.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Header {
    pub(super) image: String,
    pub(super) resolution: Scalar<Positive>,
    pub(super) origin: [Scalar<Finite>; 3],
    pub(super) negate: Switch,
    pub(super) occupied_thresh: Scalar<Fraction>,
    pub(super) free_thresh: Scalar<Fraction>,
    #[serde(default)]
    pub(super) mode: Mode,
}

impl Header {
    /// Header for an image without one: trinary, white is free, origin [0, 0, 0], and thresholds that leave the grey of unknown cells
    /// unknown.
    pub(super) fn of_image(resolution_m: Positive) -> Self {
        Self {
            image: String::new(),
            resolution: Scalar(resolution_m),
            origin: [Scalar(Finite::new(0.0)); 3],
            negate: Switch(false),
            occupied_thresh: Scalar(Fraction::new(OCCUPIED_THRESH)),
            free_thresh: Scalar(Fraction::new(BARE_FREE_THRESH)),
            mode: Mode::Trinary,
        }
    }

    /// Reads the text of a header, its first YAML document; also returns notes on keys that it passes over.
    ///
    /// # Errors
    /// [`MapError::Header`] with the place of the fault, and [`MapError::Contradiction`] for thresholds in the wrong order.
    pub(super) fn parse(text: &str) -> Result<(Self, Vec<String>), MapError> {
        // The time of the YAML reader grows with the square of the open brackets. Pictures and poses nest two of them.
        if let Some((line, column)) = nested_too_deep(text) {
            let message = format!("more than {OPEN_MAX} open brackets, expected `origin: [x, y, yaw]` at most");
            return Err(MapError::Header { line, column, message });
        }
        let document = || serde_yaml::Deserializer::from_str(text).next();
        let read = document().map_or_else(|| Self::deserialize(serde_yaml::Value::Null), Self::deserialize);
        // After `Self` has been read the text is known to be YAML.
        let foreign = || {
            let keys = document().and_then(|document| Keys::deserialize(document).ok()).unwrap_or_default().0;
            keys.into_iter().filter(|key| !KEYS.contains(&key.as_str())).collect::<Vec<String>>()
        };
        let header = read.map_err(|error| header_error(&error, text, &foreign()))?;
        if header.image.is_empty() {
            let (line, column) = place_of(text, "image", 0);
            let message = "`image` is empty, expected the name of a PGM, PNG or BMP file".to_owned();
            return Err(MapError::Header { line, column, message });
        }
        for (item, number) in header.origin.iter().enumerate() {
            if number.get().abs() > COORDINATE_M_MAX {
                let (line, column) = place_of(text, "origin", 0);
                let found = shown(number.get());
                let message = format!("`origin[{item}]` is {found}, expected at most {COORDINATE_M_MAX} m");
                return Err(MapError::Header { line, column, message });
            }
        }
        let (free, occupied) = (header.free_thresh.get(), header.occupied_thresh.get());
        if free >= occupied {
            return Err(MapError::Contradiction {
                map: "ros",
                found: format!("`free_thresh` {free} and `occupied_thresh` {occupied}"),
                expected: "a free threshold below the occupied one".to_owned(),
                advice: "0.25 and 0.65 are what Nav2 writes",
            });
        }
        let note = |key: String| {
            let (line, _) = place_of(text, &key, 0);
            let meant = nearest(&key, &KEYS).map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
            format!("line {line}: the key {} is no key of map headers and passed over{meant}", quoted(&key))
        };
        Ok((header, foreign().into_iter().map(note).collect()))
    }
}

/// Line and column, from 1, of the bracket with which too many are open at once, wherever they stand.
fn nested_too_deep(text: &str) -> Option<(usize, usize)> {
    let mut open = 0_usize;
    for (line, content) in text.lines().enumerate() {
        for (column, c) in content.chars().enumerate() {
            match c {
                '[' | '{' => open += 1,
                ']' | '}' => open = open.saturating_sub(1),
                _ => {}
            }
            if open > OPEN_MAX {
                return Some((line + 1, column + 1));
            }
        }
    }
    None
}

/// A key as messages show it.
fn quoted(key: &str) -> String {
    let shown: String = key.chars().take(40).collect();
    format!("`{}`", shown.escape_debug())
}

/// The keys of a mapping that are texts, values passed over.
#[derive(Default)]
struct Keys(Vec<String>);

impl<'de> Deserialize<'de> for Keys {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Keys;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a mapping")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Keys, A::Error> {
                let mut keys = Keys::default();
                while let Some((key, IgnoredAny)) = map.next_entry::<serde_yaml::Value, IgnoredAny>()? {
                    keys.0.extend(key.as_str().map(str::to_owned));
                }
                Ok(keys)
            }
        }
        deserializer.deserialize_map(Reader)
    }
}

/// Line and column, from 1, at which a key is written for the time number `nth`, from 0; the beginning of the text if it is not found.
fn place_of(text: &str, key: &str, nth: usize) -> (usize, usize) {
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let on_line = |(line, content): (usize, &str)| {
        let content = content.split_once(" #").map_or(content, |(content, _)| content).to_owned();
        let starts = content.match_indices(key).filter(|(at, _)| {
            let after = content[at + key.len()..].trim_start_matches(['"', '\'']).trim_start();
            !content[..*at].ends_with(is_word) && after.starts_with(':') && !content.trim_start().starts_with('#')
        });
        starts.map(|(at, _)| (line + 1, content[..at].chars().count() + 1)).collect::<Vec<_>>()
    };
    text.lines().enumerate().flat_map(on_line).nth(nth).unwrap_or((1, 1))
}

/// The error of the YAML reader with its place; where a key is missing, a foreign one that is much like it is named.
fn header_error(error: &serde_yaml::Error, text: &str, foreign: &[String]) -> MapError {
    let place = error.location().map_or((1, 1), |place| (place.line(), place.column()));
    let shown = error.to_string();
    let message = shown.split(" at line ").next().unwrap_or_default();
    let named = |kind: &str| message.split_once(kind).and_then(|(_, rest)| rest.split('`').next());
    let (place, message) = if let Some(key) = named("missing field `") {
        match foreign.iter().find(|found| nearest(found, &KEYS) == Some(key)) {
            Some(found) => {
                (place_of(text, found, 0), format!("missing key `{key}`; {}", unknown_name("key", found, &KEYS)))
            }
            None => (place, format!("missing key `{key}`")),
        }
    } else if let Some(key) = named("duplicate field `") {
        (place_of(text, key, 1), format!("twice the key `{key}`"))
    } else {
        // Values that are read as texts first have lost their place, but not their key.
        let key = message.split_once(": ").map(|(key, _)| key).filter(|key| KEYS.contains(key));
        let key = key.or(message.starts_with(UNKNOWN_MODE).then_some("mode"));
        let place = key.filter(|_| place == (1, 1)).map_or(place, |key| place_of(text, key, 0));
        let expected = format!("expected a mapping of the keys `{}`", KEYS.join("`, `"));
        (place, message.replace("expected struct Header", &expected))
    };
    let (line, column) = place;
    MapError::Header { line, column, message }
}

/// How the message on a mode begins that does not exist.
const UNKNOWN_MODE: &str = "unknown mode `";

/// Rule by which a pixel becomes an occupancy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Mode {
    #[default]
    Trinary,
    Scale,
    Raw,
}

impl<'de> Deserialize<'de> for Mode {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        const NAMES: [&str; 3] = ["trinary", "scale", "raw"];
        let name = String::deserialize(deserializer)?;
        // As map_server, which does not mind capitals.
        match NAMES.iter().position(|known| known.eq_ignore_ascii_case(&name)) {
            Some(0) => Ok(Self::Trinary),
            Some(1) => Ok(Self::Scale),
            Some(_) => Ok(Self::Raw),
            None => Err(D::Error::custom(unknown_name("mode", &name, &NAMES))),
        }
    }
}

/// A number as `yaml-cpp` takes it, bare or quoted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scalar<T>(T);

impl<T> Deref for Scalar<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.0
    }
}

impl<'de, T: TryFrom<f64, Error = String>> Deserialize<'de> for Scalar<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader<T>(PhantomData<T>);
        impl<T: TryFrom<f64, Error = String>> Visitor<'_> for Reader<T> {
            type Value = Scalar<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number")
            }
            fn visit_f64<E: Error>(self, value: f64) -> Result<Scalar<T>, E> {
                T::try_from(value).map(Scalar).map_err(E::custom)
            }
            fn visit_u64<E: Error>(self, value: u64) -> Result<Scalar<T>, E> {
                self.visit_f64(value as f64)
            }
            fn visit_i64<E: Error>(self, value: i64) -> Result<Scalar<T>, E> {
                self.visit_f64(value as f64)
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<Scalar<T>, E> {
                match text.trim().parse() {
                    Ok(value) => self.visit_f64(value),
                    Err(_) => Err(E::invalid_value(Unexpected::Str(text), &self)),
                }
            }
        }
        deserializer.deserialize_any(Reader(PhantomData))
    }
}

/// A yes or no as `yaml-cpp` takes it: 0, 1, and the words of YAML 1.1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Switch(pub(super) bool);

impl<'de> Deserialize<'de> for Switch {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl Visitor<'_> for Reader {
            type Value = Switch;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("0 or 1")
            }
            fn visit_bool<E: Error>(self, value: bool) -> Result<Switch, E> {
                Ok(Switch(value))
            }
            fn visit_u64<E: Error>(self, value: u64) -> Result<Switch, E> {
                match value {
                    0 | 1 => Ok(Switch(value == 1)),
                    _ => Err(E::invalid_value(Unexpected::Unsigned(value), &self)),
                }
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<Switch, E> {
                match text.trim().to_ascii_lowercase().as_str() {
                    "0" | "false" | "no" | "off" => Ok(Switch(false)),
                    "1" | "true" | "yes" | "on" => Ok(Switch(true)),
                    _ => Err(E::invalid_value(Unexpected::Str(text), &self)),
                }
            }
        }
        deserializer.deserialize_any(Reader)
    }
}
