//! Checked numbers: a value of one of these types is finite and inside its range.
//!
//! Each type comes from one macro: range, reader, writer, JSON Schema. The check sits inside the
//! serde visitor, so that an error keeps the value's own line, column and key path.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// A count with its noun, for messages: `1 stack`, `2 stacks`.
pub fn counted(count: u64, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

macro_rules! real_quantities {
    ($($(#[$doc:meta])* $name:ident: $expected:literal, $test:expr, $schema:tt;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
        pub struct $name(f64);

        impl $name {
            /// The checked value.
            ///
            /// # Panics
            /// If `value` is outside the range: for constants and code, not for input.
            pub fn new(value: f64) -> Self {
                match Self::try_from(value) {
                    Ok(checked) => checked,
                    Err(message) => panic!("{message}"),
                }
            }

            /// The value as a plain number.
            pub const fn get(self) -> f64 {
                self.0
            }
        }

        impl TryFrom<f64> for $name {
            type Error = String;
            fn try_from(value: f64) -> Result<Self, String> {
                let test: fn(f64) -> bool = $test;
                if value.is_finite() && test(value) {
                    Ok(Self(value))
                } else {
                    Err(format!("expected {}, found {value}", $expected))
                }
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_f64(self.0)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Reader;
                impl Visitor<'_> for Reader {
                    type Value = $name;
                    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                        f.write_str($expected)
                    }
                    fn visit_f64<E: de::Error>(self, value: f64) -> Result<$name, E> {
                        $name::try_from(value).map_err(E::custom)
                    }
                    fn visit_u64<E: de::Error>(self, value: u64) -> Result<$name, E> {
                        self.visit_f64(value as f64)
                    }
                    fn visit_i64<E: de::Error>(self, value: i64) -> Result<$name, E> {
                        self.visit_f64(value as f64)
                    }
                }
                // Not `deserialize_f64`, by which YAML reads `010` and `0x10` in a file otherwise than in the tree that `--set` edits.
                deserializer.deserialize_any(Reader)
            }
        }

        impl JsonSchema for $name {
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }
            fn inline_schema() -> bool {
                true
            }
            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!($schema)
            }
        }
    )*};
}

real_quantities! {
    /// A finite number.
    Finite: "a finite number", |_| true, {"type": "number"};
    /// A finite number above 0.
    Positive: "a number above 0", |x| x > 0.0, {"type": "number", "exclusiveMinimum": 0};
    /// A finite number of at least 0.
    NonNegative: "a number of at least 0", |x| x >= 0.0, {"type": "number", "minimum": 0};
    /// A control period: 0.001 s to 10 s.
    Period: "a number from 0.001 to 10", |x| (0.001..=10.0).contains(&x), {"type": "number", "minimum": 0.001, "maximum": 10};
    /// A number in (0, 1].
    PositiveFraction: "a number above 0 and at most 1", |x| x > 0.0 && x <= 1.0, {"type": "number", "exclusiveMinimum": 0, "maximum": 1};
    /// A number in [0, 1].
    Fraction: "a number from 0 to 1", |x| (0.0..=1.0).contains(&x), {"type": "number", "minimum": 0, "maximum": 1};
}

macro_rules! whole_quantities {
    ($($(#[$doc:meta])* $name:ident($int:ty): $low:literal to $high:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub struct $name($int);

        impl $name {
            /// The checked value.
            ///
            /// # Panics
            /// If `value` is outside the range: for constants and code, not for input.
            pub fn new(value: $int) -> Self {
                assert!(($low..=$high).contains(&value), "outside the range");
                Self(value)
            }

            /// The value as a plain number.
            pub const fn get(self) -> $int {
                self.0
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                self.0.serialize(serializer)
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Reader;
                impl Reader {
                    fn refuse<E: de::Error>(&self, found: impl fmt::Display) -> E {
                        E::custom(format!("expected a whole number from {} to {}, found {found}", $low, $high))
                    }
                }
                impl Visitor<'_> for Reader {
                    type Value = $name;
                    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                        write!(f, "a whole number from {} to {}", $low, $high)
                    }
                    fn visit_u64<E: de::Error>(self, value: u64) -> Result<$name, E> {
                        match <$int>::try_from(value) {
                            Ok(v) if ($low..=$high).contains(&v) => Ok($name(v)),
                            _ => Err(self.refuse(value)),
                        }
                    }
                    fn visit_i64<E: de::Error>(self, value: i64) -> Result<$name, E> {
                        match u64::try_from(value) {
                            Ok(v) => self.visit_u64(v),
                            Err(_) => Err(self.refuse(value)),
                        }
                    }
                    fn visit_f64<E: de::Error>(self, value: f64) -> Result<$name, E> {
                        // With its point: `1e3` is 1000.0, which is no whole number here.
                        Err(self.refuse(format!("{value:?}")))
                    }
                }
                deserializer.deserialize_any(Reader)
            }
        }

        impl JsonSchema for $name {
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }
            fn inline_schema() -> bool {
                true
            }
            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!({"type": "integer", "minimum": $low, "maximum": $high})
            }
        }
    )*};
}

whole_quantities! {
    /// A count of at least 1, at most 10⁹.
    Count(u32): 1 to 1_000_000_000;
    /// A count that may be 0, at most 10⁹.
    CountOrZero(u32): 0 to 1_000_000_000;
    /// Samples along one axis, both ends included: 2 to 1000.
    Samples(u32): 2 to 1000;
    /// Rays of a scanner: 1 to 10000.
    Rays(u32): 1 to 10_000;
    /// Cells along one side of a map: 1 to 16384.
    Cells(u32): 1 to 16_384;
}
