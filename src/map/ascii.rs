//! A map drawn in the scenario itself: `.` or space is free, `#` or `@` is occupied, the first row is the top.
//!
//! ```yaml
//! map:
//!   ascii:
//!     rows: |
//!       ......
//!       ..##..
//!       ......
//! ```

use super::{Frame, MapError, OccupancyGrid};
use crate::geometry::Pose;
use crate::quantity::{Finite, Positive};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::fmt;

/// Parameters of a drawn map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The drawing: a list of rows or one block of lines, all of one length, the first on top.
    pub rows: Drawing,
    /// Side of a cell, m. Default 1.
    #[serde(default = "super::grid::one_metre")]
    pub resolution_m: Positive,
    /// World pose [x, y, theta] of the lower left corner, m and rad. Default [0, 0, 0].
    #[serde(default = "identity")]
    pub origin: [Finite; 3],
}

fn identity() -> [Finite; 3] {
    [Finite::new(0.0); 3]
}

/// Rows of a map, checked: at least one cell, all rows of one length, known characters only.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Drawing(Vec<String>);

impl Drawing {
    /// A drawing from its rows, the first on top.
    ///
    /// # Errors
    /// [`MapError::Format`] if there is no cell, the rows differ in length, or a character is unknown.
    pub fn new(rows: Vec<String>) -> Result<Self, MapError> {
        let width = rows.first().map_or(0, |row| row.chars().count());
        for (index, row) in rows.iter().enumerate() {
            if let Some((at, found)) = row.chars().enumerate().find(|&(_, c)| !matches!(c, '.' | ' ' | '#' | '@')) {
                return Err(MapError::Format {
                    line: index + 1,
                    column: at + 1,
                    found: format!("`{found}`"),
                    expected: "`.` or a space (free), `#` or `@` (occupied)".into(),
                    advice: "draw with these characters only",
                });
            }
            if row.len() != width {
                return Err(MapError::Format {
                    line: index + 1,
                    column: row.len().min(width) + 1,
                    found: format!("{} cells", row.len()),
                    expected: format!("{width}, as in the first row"),
                    advice: "give all rows one length (an editor may have cut trailing spaces: draw free cells as `.`)",
                });
            }
        }
        if width == 0 || width > super::SIDE_MAX || rows.len() > super::SIDE_MAX {
            return Err(MapError::Format {
                line: 1,
                column: 1,
                found: format!("{width} x {} cells", rows.len()),
                expected: format!("1 to {} cells a side", super::SIDE_MAX),
                advice: "draw at least one row of cells",
            });
        }
        Ok(Self(rows))
    }

    /// The rows, the first on top.
    pub fn rows(&self) -> &[String] {
        &self.0
    }
}

impl<'de> Deserialize<'de> for Drawing {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // The check sits inside the visitor, so that the error keeps its place in the file.
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Drawing;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the rows of a map: a list of strings or a block of lines")
            }
            fn visit_str<E: Error>(self, block: &str) -> Result<Drawing, E> {
                Drawing::new(block.lines().map(String::from).collect()).map_err(E::custom)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Drawing, A::Error> {
                let mut rows = Vec::new();
                while let Some(row) = list.next_element()? {
                    rows.push(row);
                }
                Drawing::new(rows).map_err(A::Error::custom)
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

impl JsonSchema for Drawing {
    fn schema_name() -> Cow<'static, str> {
        "Drawing".into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"anyOf": [
            {"type": "string"},
            {"type": "array", "items": {"type": "string"}, "minItems": 1},
        ]})
    }
}

impl Params {
    /// The grid.
    pub fn grid(&self) -> OccupancyGrid {
        let lines: Vec<&str> = self.rows.rows().iter().map(String::as_str).collect();
        let [x, y, theta] = self.origin.map(Finite::get);
        OccupancyGrid::from_ascii(&lines, self.resolution_m.get()).with_frame(Frame { origin: Pose::new(x, y, theta) })
    }
}
