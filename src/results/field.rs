//! The value of one field of a table, as text in CSV and as a value in JSON: so the two hold the same under the same name.

use super::value::one_line;
use crate::math;
use serde_json::{Map, Value as Json};

/// The value of one field of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Field {
    /// Undefined: nothing in CSV, `null` in JSON.
    Empty,
    /// A text; an empty one is undefined.
    Text(String),
    /// The value of a swept key, as written in the sweep: in JSON a number, a truth value or a list where it reads as one.
    Setting(String),
    /// A whole number.
    Whole(u64),
    /// A real number; one that is not finite is `null` in JSON, which has no word for it.
    Real(f64),
    /// A truth value.
    Flag(bool),
}

impl Field {
    /// The field of a CSV, before it is quoted.
    pub fn csv(&self) -> String {
        match self {
            Self::Empty => String::new(),
            Self::Text(text) | Self::Setting(text) => one_line(text).into_owned(),
            Self::Whole(number) => number.to_string(),
            Self::Real(number) if number.is_finite() => math::canonical(*number).to_string(),
            Self::Real(number) => number.to_string(),
            Self::Flag(flag) => flag.to_string(),
        }
    }

    /// The value in JSON.
    pub fn json(&self) -> Json {
        match self {
            Self::Empty => Json::Null,
            Self::Text(text) | Self::Setting(text) if text.is_empty() => Json::Null,
            Self::Text(text) => text.as_str().into(),
            Self::Setting(text) => serde_json::from_str(text).unwrap_or_else(|_| text.as_str().into()),
            Self::Whole(number) => (*number).into(),
            Self::Real(number) if number.is_finite() => math::canonical(*number).into(),
            Self::Real(_) => Json::Null,
            Self::Flag(flag) => (*flag).into(),
        }
    }
}

impl From<&str> for Field {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<&String> for Field {
    fn from(text: &String) -> Self {
        Self::Text(text.clone())
    }
}

impl From<u64> for Field {
    fn from(number: u64) -> Self {
        Self::Whole(number)
    }
}

impl From<u32> for Field {
    fn from(number: u32) -> Self {
        Self::Whole(number.into())
    }
}

impl From<i32> for Field {
    fn from(number: i32) -> Self {
        u64::try_from(number).map_or(Self::Real(number.into()), Self::Whole)
    }
}

impl From<f64> for Field {
    fn from(number: f64) -> Self {
        Self::Real(number)
    }
}

impl From<bool> for Field {
    fn from(flag: bool) -> Self {
        Self::Flag(flag)
    }
}

impl<T: Into<Field>> From<Option<T>> for Field {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Empty, Into::into)
    }
}

/// A line of a table as an object of JSON, the names of its columns as keys, in their order.
pub fn json_object<'a>(names: impl IntoIterator<Item = &'a str>, fields: &[Field]) -> Map<String, Json> {
    names.into_iter().zip(fields).map(|(name, field)| (name.to_owned(), field.json())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_value_is_written_alike_in_csv_and_json() {
        for (field, csv, json) in [
            (Field::from("a_star"), "a_star", json!("a_star")),
            (Field::from("two\nlines"), "two lines", json!("two\nlines")),
            (Field::from(""), "", json!(null)),
            (Field::from(None::<f64>), "", json!(null)),
            (Field::from(Some(0.1)), "0.1", json!(0.1)),
            (Field::from(-0.0), "0", json!(0.0)),
            (Field::from(f64::INFINITY), "inf", json!(null)),
            (Field::from(u64::MAX), "18446744073709551615", json!(u64::MAX)),
            (Field::from(true), "true", json!(true)),
            (Field::Setting("0.30".to_owned()), "0.30", json!(0.30)),
            (Field::Setting("[1, 2]".to_owned()), "[1, 2]", json!([1, 2])),
            (Field::Setting("true".to_owned()), "true", json!(true)),
            (Field::Setting("fast".to_owned()), "fast", json!("fast")),
            (Field::Setting(String::new()), "", json!(null)),
        ] {
            assert_eq!((field.csv().as_str(), field.json()), (csv, json));
        }
    }

    #[test]
    fn keys_keep_the_order_of_the_columns() {
        let object = json_object(["stack", "n", "b", "a"], &[Field::from("x"), 1u64.into(), 2u64.into(), 3u64.into()]);
        assert_eq!(serde_json::to_string(&object).unwrap(), r#"{"stack":"x","n":1,"b":2,"a":3}"#);
    }
}
