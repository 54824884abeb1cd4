//! Maps: occupancy grid, exact distance field, frames; readers of file formats; seeded generators.
//!
//! Cell (col, row) covers the square [col, col+1] × [row, row+1] times the resolution; row 0 is at
//! the bottom. Formats whose first row is the top are flipped by their reader and nowhere else.
//! Everything outside the grid is blocked.

pub mod connectivity;
mod distance;
mod error;
pub mod file;
pub mod from_image;
mod grid;
mod kind;
mod layout;
mod map_seed;
pub mod queries;
#[cfg(test)]
mod support;

pub use distance::DistanceField;
pub use error::MapError;
pub use grid::{Cell, Frame, OccupancyGrid};
pub use kind::{Entry, Generator, MapKind};
pub use map_seed::MapSeed;

use crate::rng::EpisodeSeed;
use crate::settings::{RESOLUTION_M, registry};
use file::FileFormat;
use schemars::{Schema, SchemaGenerator, json_schema};
use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use std::fmt;
use std::path::{Path, PathBuf};

/// Largest number of cells along one side of a map; checked before anything is allocated.
pub const SIDE_MAX: usize = 16_384;

/// Largest number of bytes of a file that draws a map with characters: the largest map with two characters for the end of a line, and
/// room for a header.
pub(crate) const DRAWING_BYTES_MAX: u64 = (SIDE_MAX * (SIDE_MAX + 2) + 1024) as u64;

/// Refuses a map whose cells are too small or too large to be meant.
fn check_resolution(grid: &OccupancyGrid) -> Result<(), MapError> {
    let side_m = grid.resolution_m();
    if RESOLUTION_M.contains(&side_m) {
        return Ok(());
    }
    Err(MapError::Contradiction {
        map: "any",
        found: format!("cells of {side_m} m"),
        expected: format!("{} to {} m", RESOLUTION_M.start(), RESOLUTION_M.end()),
        advice: "the resolution is the side of a cell in metres",
    })
}

registry! {
    /// The known map of a scenario (scenario key `map`): drawn in place, read from a file, or generated.
    pub enum MapSpec: "map", Entry, dyn MapKind {
        /// Maps drawn by hand or recorded, in the scenario or in a file.
        formats { ascii, movingai, ros }
        /// Maps that are computed, most of them from a seed.
        generators { random, warehouse, port, rooms, maze, u_trap, workshop, empty }
    }
}

impl MapSpec {
    /// Reads the value of the scenario's key `map`: a kind of map, or a map file alone, whose extension tells the kind.
    ///
    /// # Errors
    /// The reader's, or one that says why the file cannot be the map of a scenario.
    pub fn or_file<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = MapSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a map: `name`, `name: {parameters}`, or a map file")
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<MapSpec, E> {
                let file = Path::new(text);
                if file.extension().is_none() {
                    return MapSpec::deserialize(StrDeserializer::new(text));
                }
                let format = FileFormat::of(file)
                    .map_err(|_| E::custom(format!("`{text}` is no map file: they end in {}", FileFormat::known())))?;
                if let Some(advice) = format.in_scenarios {
                    return Err(E::custom(format!("`{text}` cannot be the map of a scenario: {advice}")));
                }
                let has = |entry: &Entry| entry.files.iter().any(|other| other.extensions == format.extensions);
                let kinds = MapSpec::NAMES.iter().zip(MapSpec::ENTRIES);
                let kind = kinds.filter(|(_, entry)| has(entry)).map(|(name, _)| *name).next().unwrap_or_default();
                serde_json::from_value(serde_json::json!({kind: text})).map_err(E::custom)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<MapSpec, A::Error> {
                MapSpec::deserialize(MapAccessDeserializer::new(map))
            }
        }
        deserializer.deserialize_any(Reader)
    }

    /// The JSON Schema of what [`Self::or_file`] reads.
    pub fn schema_or_file(generator: &mut SchemaGenerator) -> Schema {
        let extensions = FileFormat::all().filter(|format| format.in_scenarios.is_none());
        let extensions: Vec<&str> = extensions.flat_map(|format| format.extensions).copied().collect();
        let file = json_schema!({
            "type": "string",
            "pattern": format!("\\.({})$", extensions.join("|")),
            "description": "A map file, whose extension tells its kind.",
        });
        json_schema!({"anyOf": [generator.subschema_for::<Self>(), file]})
    }

    /// The grid of one episode. Files are looked up relative to `folder`, the folder of the scenario.
    ///
    /// # Errors
    /// [`MapError::File`] for a file that cannot be read or does not follow its format,
    /// [`MapError::Contradiction`] for sizes that do not fit together, and
    /// [`MapError::Infeasible`] if no acceptable map was drawn: only this one depends on the seed.
    pub fn load(&self, folder: &Path, seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        let grid = self.kind().load(folder, seed)?;
        check_resolution(&grid)?;
        Ok(grid)
    }

    /// The files that the map is read from, the one that the scenario names first; relative to `folder` as in the scenario.
    pub fn files(&self, folder: &Path) -> Vec<PathBuf> {
        self.kind().files(folder)
    }

    /// What the map's file says that was not used, or should be looked at, in words; none if it cannot be read.
    pub fn notes(&self, folder: &Path) -> Vec<String> {
        self.kind().notes(folder)
    }

    /// Whether every episode gets the same grid, so that it may be loaded once and shared.
    pub fn is_fixed(&self) -> bool {
        self.kind().is_fixed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEED: EpisodeSeed = support::episode(0);

    fn read(yaml: &str) -> MapSpec {
        serde_yaml::from_str(yaml).expect("a map")
    }

    #[test]
    fn every_kind_of_map_is_loaded() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("two.map"), "type octile\nheight 1\nwidth 2\nmap\n.@\n").expect("a file");
        let header =
            "{image: two.pgm, resolution: 1, origin: [0, 0, 0], negate: 0, occupied_thresh: 0.65, free_thresh: 0.25}";
        std::fs::write(folder.path().join("two.yaml"), header).expect("a file");
        std::fs::write(folder.path().join("two.pgm"), "P2 2 1 255 255 0").expect("a file");
        for (yaml, cols, rows, occupied, fixed) in [
            ("ascii: {rows: ['.#', '..']}", 2, 2, 1, true),
            ("movingai: {file: two.map, resolution_m: 0.5}", 2, 1, 1, true),
            ("random: {cols: 8, rows: 9, obstacles: 5}", 8, 9, 5, false),
            ("random: {cols: 8, rows: 9, obstacles: 5, map_seed: 3}", 8, 9, 5, true),
            ("warehouse", 240, 120, 7896, true),
            ("ros: {file: two.yaml}", 2, 1, 1, true),
            ("port", 25, 25, 117, false),
            // 24 walls of 9 cells and 9 posts, less 24 doors of 2.
            ("rooms: {extra_doors: 1}", 39, 39, 24 * 9 + 9 - 24 * 2, false),
            ("maze", 29, 29, 29 * 29 - 100 * 4 - 99 * 2, false),
            ("maze: {map_seed: 3}", 29, 29, 29 * 29 - 100 * 4 - 99 * 2, true),
            ("u_trap", 40, 40, 240, false),
            ("workshop", 96, 56, (5 * 8 + 4) * 16, false),
            ("empty: {cols: 3, rows: 4, resolution_m: 0.5}", 3, 4, 0, true),
        ] {
            let spec = read(yaml);
            let grid = spec.load(folder.path(), SEED).expect("a grid");
            assert_eq!((grid.cols(), grid.rows(), grid.occupied_count()), (cols, rows, occupied), "{yaml}");
            assert_eq!(spec.is_fixed(), fixed, "{yaml}");
            let other = spec.load(folder.path(), EpisodeSeed { episode: 1, ..SEED }).expect("a grid");
            assert_eq!(grid == other, fixed, "{yaml}");
        }
        let half = read("movingai: {file: two.map, resolution_m: 0.5}").load(folder.path(), SEED).expect("a grid");
        assert_eq!(half.resolution_m(), 0.5);
        assert!(half.is_free(Cell { col: 0, row: 0 }));
    }

    #[test]
    fn a_fault_in_a_file_is_named_with_file_and_place() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("bad.map"), "type octile\nheight 1\nwidth 2\nmap\n.?\n").expect("a file");
        let error = read("movingai: {file: bad.map}").load(folder.path(), SEED).expect_err("refused").to_string();
        assert!(error.contains("bad.map: line 5, column 2: found `?`, expected `.`, `G` or `S` (passable)"), "{error}");
    }

    /// The documentation of every generator shows a scenario and the map it draws.
    #[test]
    fn the_picture_in_the_documentation_of_a_generator_is_its_map() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/map/generators");
        let mut pictures = 0;
        for name in MapSpec::NAMES {
            if let Ok(source) = std::fs::read_to_string(folder.join(name).with_extension("rs")) {
                support::assert_picture(name, &source);
                pictures += 1;
            }
        }
        assert_eq!(pictures, std::fs::read_dir(folder).expect("a folder").count());
    }

    #[test]
    fn a_wrong_name_is_answered_with_the_nearest() {
        let error = serde_yaml::from_str::<MapSpec>("warehous").expect_err("refused").to_string();
        assert!(error.contains("unknown map `warehous`, did you mean `warehouse`?"), "{error}");
    }

    #[test]
    fn the_schema_names_every_kind() {
        let schema = serde_json::to_string(&schemars::schema_for!(MapSpec)).expect("text");
        assert!(MapSpec::NAMES.iter().all(|name| schema.contains(&format!("\"{name}\""))), "{schema}");
    }
}
