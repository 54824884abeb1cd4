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

use crate::files;
use crate::geometry::Pose;
use crate::map::file::{Draft, FileFormat, Loaded, Unknown};
use crate::map::kind::one_metre;
use crate::map::{DRAWING_BYTES_MAX, Entry, Frame, MapError, MapKind, OccupancyGrid, SIDE_MAX};
use crate::rng::EpisodeSeed;
use crate::settings::choice::or_text;
use crate::settings::quantity::{Finite, Positive};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::fmt;
use std::path::Path;

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "A map drawn in the scenario itself, one character a cell.",
    files: &[FileFormat {
        extensions: &["txt"],
        name: None,
        has_frame: false,
        in_scenarios: Some("a drawing stands in the scenario itself: `map: {ascii: {rows: …}}`"),
        read: read_file,
        write: Some(write_file),
    }],
};

/// Parameters of a drawn map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, remote = "Self")]
#[schemars(extend("x-alone" = "rows"))]
pub struct Params {
    /// The drawing: a list of rows or one block of lines, all of one length, the first on top.
    pub rows: Drawing,
    /// Side of a cell, m. Default 1.
    #[serde(default = "one_metre")]
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
        if width == 0 || width > SIDE_MAX || rows.len() > SIDE_MAX {
            return Err(MapError::at(
                (0, 0),
                format!("{} rows of {width} cells", rows.len()),
                format!("1 to {SIDE_MAX} of each"),
                "draw one character for each cell",
            ));
        }
        for (line, row) in rows.iter().enumerate() {
            if let Some((column, found)) = row.chars().enumerate().find(|&(_, c)| !matches!(c, '.' | ' ' | '#' | '@')) {
                return Err(MapError::at(
                    (line, column),
                    format!("`{}`", found.escape_default()),
                    "`.` or a space (free), `#` or `@` (occupied)",
                    "draw with these characters only",
                ));
            }
            if row.len() != width {
                return Err(MapError::at(
                    (line, row.len().min(width)),
                    format!("a row of {} cells", row.len()),
                    format!("{width} cells as in the first row"),
                    "draw free cells as `.`, for editors cut spaces at the end of a line",
                ));
            }
        }
        Ok(Self(rows))
    }

    /// The rows, the first on top.
    pub fn rows(&self) -> &[String] {
        &self.0
    }

    /// The grid; its lower left corner is the origin of the world.
    pub fn grid(&self, resolution_m: Positive) -> OccupancyGrid {
        let lines: Vec<&str> = self.0.iter().map(String::as_str).collect();
        OccupancyGrid::from_ascii(&lines, resolution_m.get())
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
        json_schema!({
            "anyOf": [
                {"type": "string"},
                {"type": "array", "items": {"type": "string"}, "minItems": 1},
            ],
            "examples": [["......", "..##..", "......"]],
        })
    }
}

or_text!(Params, "rows");

impl MapKind for Params {
    fn load(&self, _folder: &Path, _seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        let [x, y, theta] = self.origin.map(Finite::get);
        Ok(self.rows.grid(self.resolution_m).with_frame(Frame { origin: Pose::new(x, y, theta) }))
    }

    fn is_fixed(&self) -> bool {
        true
    }
}

/// Reads a file that holds a drawing and nothing else.
fn read_file(file: &Path, resolution_m: Positive, _: Unknown) -> Result<Loaded, MapError> {
    let text = files::text(file, DRAWING_BYTES_MAX).map_err(|source| MapError::Read { source }.of(file))?;
    let rows = Drawing::new(text.lines().map(str::to_owned).collect()).map_err(|error| error.of(file))?;
    Ok(Loaded::known(rows.grid(resolution_m)))
}

/// Drafts the drawing of a grid.
fn write_file(grid: &OccupancyGrid, file: &Path) -> Vec<Draft> {
    vec![Draft { file: file.into(), bytes: grid.to_string().into_bytes() }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::support::episode;
    use crate::map::{Cell, MapSpec};

    fn read(yaml: &str) -> Result<OccupancyGrid, String> {
        let spec: MapSpec = serde_yaml::from_str(yaml).map_err(|error| error.to_string())?;
        Ok(spec.load(Path::new(""), episode(0)).expect("a map"))
    }

    #[test]
    fn a_block_and_a_list_draw_the_same_map() {
        let block = read("ascii:\n  rows: |\n    ..#\n    @. \n").expect("a map");
        let list = read("ascii: {rows: ['..#', '@. ']}").expect("a map");
        assert_eq!(block, list);
        // The first row is the top: row 1 of the grid.
        assert!(!block.is_free(Cell { col: 2, row: 1 }) && !block.is_free(Cell { col: 0, row: 0 }));
        assert_eq!((block.occupied_count(), block.resolution_m()), (2, 1.0));
    }

    #[test]
    fn the_origin_is_the_world_pose_of_the_lower_left_corner() {
        let map = read("ascii: {rows: ['.'], resolution_m: 0.5, origin: [2, -1, 0.5]}").expect("a map");
        assert_eq!(map.frame().origin, Pose::new(2.0, -1.0, 0.5));
    }

    #[test]
    fn faults_are_named_with_their_place() {
        let unknown = read("ascii:\n  rows: ['...', '.x.']\n").expect_err("refused");
        assert!(unknown.contains("line 2, column 2: found `x`, expected `.` or a space"), "{unknown}");
        assert!(unknown.contains("ascii.rows") && unknown.contains("at line 2"), "{unknown}");
        let ragged = read("ascii: {rows: ['...', '..']}").expect_err("refused");
        assert!(ragged.contains("line 2, column 3: found a row of 2 cells, expected 3 cells"), "{ragged}");
        for nothing in ["ascii: {rows: []}", "ascii: {rows: ['']}", "ascii: {rows: ''}"] {
            let empty = read(nothing).expect_err("refused");
            assert!(empty.contains("expected 1 to 16384"), "{empty}");
        }
        let missing = read("ascii").expect_err("refused");
        assert!(missing.contains("missing field `rows`"), "{missing}");
    }

    #[test]
    fn a_drawn_map_is_written_as_it_is_read() {
        let spec: MapSpec = serde_yaml::from_str("ascii: {rows: ['.#', '..']}").expect("a map");
        let text = serde_yaml::to_string(&spec).expect("text");
        assert_eq!(serde_yaml::from_str::<MapSpec>(&text).expect("a map"), spec);
    }
}
