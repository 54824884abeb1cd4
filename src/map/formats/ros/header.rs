//! The YAML header of a ROS map.

use super::writer::{FREE_THRESH, OCCUPIED_THRESH};
use crate::map::MapError;
use crate::settings::choice::unknown_name;
use crate::settings::quantity::{Finite, Fraction, Positive};
use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::marker::PhantomData;
use std::ops::Deref;

/// The header's keys, all that Nav2 reads and writes.
const KEYS: [&str; 7] = ["image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode"];

/// The YAML file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
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
    /// Header for an image without one: trinary, white is free, origin [0, 0, 0], and the thresholds
    /// that Nav2 writes.
    pub(super) fn of_image(resolution_m: Positive) -> Self {
        Self {
            image: String::new(),
            resolution: Scalar(resolution_m),
            origin: [Scalar(Finite::new(0.0)); 3],
            negate: Switch(false),
            occupied_thresh: Scalar(Fraction::new(OCCUPIED_THRESH)),
            free_thresh: Scalar(Fraction::new(FREE_THRESH)),
            mode: Mode::Trinary,
        }
    }

    /// Reads the text of a header.
    ///
    /// # Errors
    /// [`MapError::Header`] with the place of the fault, and [`MapError::Contradiction`] for thresholds in the wrong order.
    pub(super) fn parse(text: &str) -> Result<Self, MapError> {
        let header: Self = serde_yaml::from_str(text).map_err(|error| header_error(&error))?;
        if header.image.is_empty() {
            return Err(MapError::Header {
                line: 1,
                column: 1,
                message: "`image` is empty, expected the name of a PGM or PNG file".to_owned(),
            });
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
        Ok(header)
    }
}

/// The error of the YAML reader with its place, and with the nearest known key if a key is unknown.
fn header_error(error: &serde_yaml::Error) -> MapError {
    let (line, column) = error.location().map_or((1, 1), |place| (place.line(), place.column()));
    let text = error.to_string();
    let message = text.split(" at line ").next().unwrap_or_default();
    let message = match message.split_once("unknown field `").and_then(|(_, rest)| rest.split('`').next()) {
        Some(key) => unknown_name("key", key, &KEYS),
        None => message.replace("missing field", "missing key").replace("duplicate field", "twice the key"),
    };
    MapError::Header { line, column, message }
}

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
