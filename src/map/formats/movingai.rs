//! Maps and queries in the format of the MovingAI benchmarks.
//!
//! A `.map` is a header of four lines (`type octile`, `height H`, `width W`, `map`) and H rows of W
//! characters, the first on top: `.`, `G` and `S` are passable, `@`, `O`, `T` and `W` blocked. A `.scen`
//! is a line `version 1` (or `1.0`) and one query a line, its nine columns separated by tabs or, where the name of the
//! map has no space, by any white space. Its cells count columns from the left and rows from the *top* ([`flip`]); its
//! lengths are for 8 neighbours without corner cutting, in cells. White space at the end of lines and between the words of
//! a header means nothing, as in the reference implementation, hog2 of the benchmarks' author.
//!
//! N. R. Sturtevant, *Benchmarks for Grid-Based Pathfinding*, IEEE Transactions on Computational
//! Intelligence and AI in Games 4(2), 2012.

use crate::files;
use crate::map::file::{Draft, FileFormat, Loaded, Unknown};
use crate::map::kind::one_metre;
use crate::map::{Cell, DRAWING_BYTES_MAX, Entry, MapError, MapKind, OccupancyGrid, SIDE_MAX};
use crate::rng::EpisodeSeed;
use crate::settings::choice::or_text;
use crate::settings::quantity::{Positive, counted};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "A map file of the MovingAI benchmarks.",
    files: &[FileFormat {
        extensions: &["map"],
        name: Some("MovingAI"),
        has_frame: false,
        in_scenarios: None,
        read: read_file,
        write: Some(write_file),
    }],
};

/// Parameters of a map read from a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, remote = "Self")]
#[schemars(extend("x-alone" = "file"))]
pub struct Params {
    /// The `.map` file, relative to the folder of the scenario file.
    #[schemars(example = "maps/hall.map")]
    pub file: PathBuf,
    /// Side of a cell, m. Default 1.
    #[serde(default = "one_metre")]
    pub resolution_m: Positive,
}

or_text!(Params, "file");

impl MapKind for Params {
    fn load(&self, folder: &Path, _seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        read_file(&folder.join(&self.file), self.resolution_m, Unknown::default()).map(|loaded| loaded.grid)
    }

    fn is_fixed(&self) -> bool {
        true
    }

    fn files(&self, _folder: &Path) -> Vec<PathBuf> {
        vec![self.file.clone()]
    }
}

/// Reads a `.map`; the format knows no unknown cells.
fn read_file(file: &Path, resolution_m: Positive, _: Unknown) -> Result<Loaded, MapError> {
    let text = files::text(file, DRAWING_BYTES_MAX).map_err(|source| MapError::Read { source }.of(file))?;
    let grid = parse(&text).map_err(|error| error.of(file))?;
    // The header has none of its letters in capitals.
    let water = text.bytes().filter(|&byte| byte == b'W').count();
    let note = || format!("water (`W`) is blocked, also from water to water: {}", counted(water as u64, "cell"));
    let notes = if water > 0 { vec![note()] } else { Vec::new() };
    Ok(Loaded { notes, ..Loaded::known(grid.with_resolution(resolution_m.get())) })
}

/// Drafts a `.map`.
fn write_file(grid: &OccupancyGrid, file: &Path) -> Vec<Draft> {
    vec![Draft { file: file.into(), bytes: write(grid).into_bytes() }]
}

/// Reads the text of a `.map`; cells have a side of 1 m.
///
/// # Errors
/// [`MapError::Format`] at the first place that does not follow the format. Sizes are checked before
/// anything is allocated.
pub fn parse(text: &str) -> Result<OccupancyGrid, MapError> {
    let mut lines = text.lines().enumerate();
    let mut next = |expected: &str| match lines.next() {
        Some((_, line)) => Ok(line),
        None => Err(MapError::at((text.lines().count(), 0), "the end of the file", expected, "the file seems cut off")),
    };
    let advice = "a map opens with the lines `type octile`, `height H`, `width W`, `map`";
    let kind = next("`type octile`")?;
    if !kind.split_whitespace().eq(["type", "octile"]) {
        return Err(MapError::at((0, 0), quoted(kind), "`type octile`", advice));
    }
    let rows = side(next("`height H`")?, "height", 1)?;
    let cols = side(next("`width W`")?, "width", 2)?;
    let opening = next("`map`")?;
    if opening.trim() != "map" {
        return Err(MapError::at((3, 0), quoted(opening), "`map`", advice));
    }
    let mut grid = OccupancyGrid::empty(cols as i32, rows as i32, 1.0);
    for from_top in 0..rows {
        let line = next(&format!("{rows} rows of cells, of which {from_top} are there"))?.trim_end();
        let mut columns = 0;
        for (col, character) in line.chars().enumerate() {
            if col == cols {
                break;
            }
            match character {
                '.' | 'G' | 'S' => {}
                '@' | 'O' | 'T' | 'W' => {
                    grid.set_occupied(Cell { col: col as i32, row: (rows - 1 - from_top) as i32 });
                }
                _ => {
                    return Err(MapError::at(
                        (from_top + HEADER_LINES, col),
                        quoted(&character.to_string()),
                        "`.`, `G` or `S` (passable), `@`, `O`, `T` or `W` (blocked)",
                        "only these characters are cells of an octile map",
                    ));
                }
            }
            columns = col + 1;
        }
        if columns != cols || line.chars().nth(cols).is_some() {
            return Err(MapError::at(
                (from_top + HEADER_LINES, columns),
                format!("a row of {} characters", line.chars().count()),
                format!("{cols}, as `width` says"),
                "correct the row or the header",
            ));
        }
    }
    match lines.find(|(_, line)| !line.trim().is_empty()) {
        None => Ok(grid),
        Some((line, more)) => Err(MapError::at(
            (line, 0),
            quoted(more),
            format!("the end of the file after {rows} rows, as `height` says"),
            "correct the header or remove the line",
        )),
    }
}

/// Lines before the first row of cells.
const HEADER_LINES: usize = 4;

/// Longest piece of a file that an error quotes, in characters.
const QUOTE_MAX: usize = 40;

/// A piece of a file as an error shows it.
fn quoted(text: &str) -> String {
    let start: String = text.chars().take(QUOTE_MAX).collect();
    let more = if start.len() < text.len() { "…" } else { "" };
    format!("`{}{more}`", start.escape_debug())
}

/// The number of a header line `key number`.
fn side(line: &str, key: &str, at: usize) -> Result<usize, MapError> {
    let words: Vec<&str> = line.split_whitespace().collect();
    match (&words[..], words.last().and_then(|number| number.parse().ok())) {
        ([first, _], Some(side)) if *first == key && (1..=SIDE_MAX).contains(&side) => Ok(side),
        _ => Err(MapError::at(
            (at, 0),
            quoted(line),
            format!("`{key}` and a whole number from 1 to {SIDE_MAX}"),
            "a map opens with the lines `type octile`, `height H`, `width W`, `map`",
        )),
    }
}

/// The text of a `.map` with the occupancy of `grid`: `.` passable, `@` blocked. Resolution and frame
/// have no place in it.
pub fn write(grid: &OccupancyGrid) -> String {
    let mut text = format!("type octile\nheight {}\nwidth {}\nmap\n", grid.rows(), grid.cols());
    for row in grid.occupied().chunks_exact(grid.cols() as usize).rev() {
        text.extend(row.iter().map(|&occupied| if occupied { '@' } else { '.' }));
        text.push('\n');
    }
    text
}

/// The grid's cell of a file's cell (row counted from the top), and the other way round.
pub fn flip(grid: &OccupancyGrid, cell: Cell) -> Cell {
    Cell { col: cell.col, row: grid.rows() - 1 - cell.row }
}

/// One query of a `.scen`.
#[derive(Clone, Debug, PartialEq)]
pub struct Query {
    /// Its line in the file, from 1.
    pub line: usize,
    /// The map for which it is, as the file names it.
    pub map: String,
    /// Columns and rows of that map.
    pub size: [i32; 2],
    /// Start as the file counts: row 0 at the top.
    pub start: Cell,
    /// Goal as the file counts: row 0 at the top.
    pub goal: Cell,
    /// Optimal octile length in cells. Published sets print 0 between different cells where there is no way.
    pub optimal_length: f64,
    /// The same as printed: to 6 significant digits in the older files, to 2 decimals in some, to 8 in the newer ones.
    pub printed: String,
}

/// Reads the text of a `.scen`, in the order of its lines.
///
/// # Errors
/// [`MapError::Format`] at the first place that does not follow the format. Whether the cells are on the map is not looked at.
pub fn parse_queries(text: &str) -> Result<Vec<Query>, MapError> {
    let mut lines = text.lines().enumerate();
    let version = lines.next().map_or("", |(_, line)| line);
    if !is_version(version) {
        return Err(MapError::at((0, 0), quoted(version), "`version 1`", "a .scen file opens with that line"));
    }
    lines.filter(|(_, line)| !line.trim().is_empty()).map(|(number, line)| parse_query(number, line)).collect()
}

/// Whether a line is the first one of a `.scen`; the version is a number.
pub fn is_version(line: &str) -> bool {
    let mut words = line.split_whitespace();
    let is_one = |number: &str| f64::from_str(number).is_ok_and(|number| number == 1.0);
    words.next() == Some("version") && words.next().is_some_and(is_one) && words.next().is_none()
}

/// Columns of a query's line.
const QUERY_COLUMNS: [&str; 9] =
    ["bucket", "map", "map width", "map height", "start x", "start y", "goal x", "goal y", "optimal length"];

fn parse_query(number: usize, line: &str) -> Result<Query, MapError> {
    let tabs: Vec<&str> = line.split('\t').map(str::trim).collect();
    let is_by_tabs = tabs.len() == QUERY_COLUMNS.len() && tabs.iter().all(|field| !field.is_empty());
    let fields = if is_by_tabs { tabs } else { line.split_whitespace().collect() };
    let advice = "a query is: bucket, map, map width, map height, start x, start y, goal x, goal y, optimal length";
    if fields.len() != QUERY_COLUMNS.len() {
        let found = format!("{} columns", fields.len());
        return Err(MapError::at(
            (number, 0),
            found,
            format!("{} separated by tabs or spaces", QUERY_COLUMNS.len()),
            advice,
        ));
    }
    // The fields are parts of the line, so their addresses say where in it they stand.
    let place = |index: usize| {
        let before = fields[index].as_ptr() as usize - line.as_ptr() as usize;
        (number, line[..before].chars().count())
    };
    let whole = |index: usize| {
        i32::from_str(fields[index]).map_err(|_| {
            MapError::at(
                place(index),
                quoted(fields[index]),
                format!("{}, a whole number", QUERY_COLUMNS[index]),
                advice,
            )
        })
    };
    let size = [whole(2)?, whole(3)?];
    let (start, goal) = (Cell { col: whole(4)?, row: whole(5)? }, Cell { col: whole(6)?, row: whole(7)? });
    match f64::from_str(fields[8]) {
        Ok(optimal_length) if optimal_length.is_finite() && optimal_length >= 0.0 => Ok(Query {
            line: number + 1,
            map: fields[1].to_owned(),
            size,
            start,
            goal,
            optimal_length,
            printed: fields[8].to_owned(),
        }),
        _ => Err(MapError::at(place(8), quoted(fields[8]), "optimal length, a number of at least 0", advice)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::support::episode;
    use std::io::Write;

    const SMALL: &str = "type octile\nheight 2\nwidth 3\nmap\n.GS\n@OT\n";

    fn fault(text: &str) -> String {
        parse(text).expect_err("refused").to_string()
    }

    #[test]
    fn rows_are_read_from_the_top_and_every_character_is_known() {
        let grid = parse(SMALL).expect("a map");
        assert_eq!(grid.to_string(), "...\n###\n");
        assert!(!grid.is_free(Cell { col: 0, row: 0 }) && grid.is_free(Cell { col: 0, row: 1 }));
        assert_eq!(flip(&grid, Cell { col: 2, row: 0 }), Cell { col: 2, row: 1 });
        assert_eq!(parse(&SMALL.replace('T', "W")).expect("a map"), grid);
        assert_eq!(parse(&SMALL.replace('\n', "\r\n")).expect("a map"), grid);
        assert_eq!(parse(SMALL.trim_end()).expect("a map"), grid);
        assert_eq!(parse(" type \t octile \nheight\t2\nwidth  3 \nmap \n.GS\t\n@OT  \n \n").expect("a map"), grid);
        assert_eq!(parse(&write(&grid)).expect("a map"), grid);
    }

    #[test]
    fn faults_are_named_with_their_place() {
        for (text, expected) in [
            (String::new(), "line 1, column 1: found the end of the file, expected `type octile`"),
            (SMALL.replace("octile", "tile"), "line 1, column 1: found `type tile`, expected `type octile`"),
            (SMALL.replace("height 2", "height -2"), "line 2, column 1: found `height -2`, expected `height` and a"),
            (SMALL.replace("height 2", "width 2"), "line 2, column 1: found `width 2`, expected `height`"),
            (SMALL.replace("width 3", "width 99999"), "line 3, column 1: found `width 99999`, expected `width` and"),
            (SMALL.replace("width 3", "width 3 3"), "line 3, column 1: found `width 3 3`, expected `width` and"),
            (SMALL.replace("width 3", "width"), "line 3, column 1: found `width`, expected `width` and"),
            (SMALL.replace("type octile", "typeoctile"), "line 1, column 1: found `typeoctile`, expected"),
            (SMALL.replace("\nmap", "\nmaps"), "line 4, column 1: found `maps`, expected `map`"),
            (SMALL.replace('S', "x"), "line 5, column 3: found `x`, expected `.`, `G` or `S`"),
            (SMALL.replace("@O", "@"), "line 6, column 3: found a row of 2 characters, expected 3"),
            (SMALL.replace("@O", "@OO"), "line 6, column 4: found a row of 4 characters, expected 3"),
            (SMALL.replace("height 2", "height 3"), "line 7, column 1: found the end of the file, expected 3 rows"),
            (SMALL.replace("height 2", "height 1"), "line 6, column 1: found `@OT`, expected the end of the file"),
        ] {
            let message = fault(&text);
            assert!(message.starts_with(expected), "{message}");
        }
    }

    #[test]
    fn an_unreadable_file_is_named() {
        let params = Params { file: "no/such.map".into(), resolution_m: Positive::new(1.0) };
        let message = params.load(Path::new("scenarios"), episode(0)).expect_err("refused").to_string();
        assert!(message.contains("such.map: cannot read the map: "), "{message}");
    }

    #[test]
    fn queries_are_read_in_the_cells_of_the_file() {
        let text = "version 1\r\n3\tmaps/a.map\t3\t2\t0\t1\t2\t0\t2.41421\r\n";
        let query = Query {
            line: 2,
            map: "maps/a.map".to_owned(),
            size: [3, 2],
            start: Cell { col: 0, row: 1 },
            goal: Cell { col: 2, row: 0 },
            optimal_length: 2.41421,
            printed: "2.41421".to_owned(),
        };
        for same in [
            text.to_owned(),
            text.replace('\t', " "),
            text.replace('\t', "  \t"),
            text.replace('\n', "\t\n").replace("version 1", " version  1.0"),
            text.replace("\r\n3", "\r\n 3"),
        ] {
            assert_eq!(parse_queries(&same).expect("queries"), std::slice::from_ref(&query), "{same:?}");
        }
        // With tabs the name may hold spaces.
        let spaced = parse_queries(&text.replace("maps/a.map", "my maps/a b.map")).expect("queries");
        assert_eq!(spaced, [Query { map: "my maps/a b.map".to_owned(), ..query }]);
        for (text, expected) in [
            ("version 2\n".to_string(), "line 1, column 1: found `version 2`, expected `version 1`"),
            ("version 1 1\n".to_string(), "line 1, column 1: found `version 1 1`, expected `version 1`"),
            (String::new(), "line 1, column 1: found ``, expected `version 1`"),
            (text.replace("\t0\t1\t", "\t"), "line 2, column 1: found 7 columns, expected 9 separated by tabs or"),
            (
                text.replace("a.map\t", "a b.map "),
                "line 2, column 1: found 10 columns, expected 9 separated by tabs or",
            ),
            // "3\tmaps/a.map\t3\t2\t0\t" takes 19 characters.
            (text.replace("\t1\t", "\tx\t"), "line 2, column 20: found `x`, expected start y, a whole number"),
            (text.replace("\t1\t", "  1.5 "), "line 2, column 21: found `1.5`, expected start y, a whole number"),
            (text.replace("2.41421", "NaN"), "line 2, column 26: found `NaN`, expected optimal length"),
        ] {
            let message = parse_queries(&text).expect_err("refused").to_string();
            assert!(message.starts_with(expected), "{message}");
        }
    }

    /// The files of the benchmark with an extension; empty if the benchmark is absent.
    fn benchmark_files(extension: &str) -> Vec<PathBuf> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/benchmarks/movingai");
        let Ok(entries) = std::fs::read_dir(folder) else {
            writeln!(std::io::stderr(), "skipped: ../shared/benchmarks not found").expect("stderr");
            return Vec::new();
        };
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
        files.retain(|file| file.extension().is_some_and(|found| found == extension));
        files.sort();
        assert!(!files.is_empty(), "no .{extension} in the benchmark");
        files
    }

    #[test]
    fn every_benchmark_map_is_read_as_it_stands() {
        for file in benchmark_files("map") {
            let text = std::fs::read_to_string(&file).expect("text");
            let grid = parse(&text).expect("a map");
            // Independently: the rows are what follows the header, as bytes.
            let rows: Vec<&[u8]> = text.lines().skip(4).map(str::as_bytes).collect();
            assert_eq!((grid.rows() as usize, grid.cols() as usize), (rows.len(), rows[0].len()), "{}", file.display());
            for (y, row) in rows.iter().enumerate() {
                for (x, byte) in row.iter().enumerate() {
                    let cell = flip(&grid, Cell { col: x as i32, row: y as i32 });
                    assert_eq!(grid.is_free(cell), b".GS".contains(byte), "{} {x} {y}", file.display());
                }
            }
            assert_eq!(parse(&write(&grid)).expect("a map"), grid);
        }
    }

    #[test]
    fn free_cells_of_known_maps_are_counted() {
        // Counted with `sed 1,4d FILE | tr -d '\r\n@OTW' | wc -c`.
        let known = [("arena", 49, 2054), ("lak303d", 194, 14_784), ("random512-20-0", 512, 209_281)];
        for file in benchmark_files("map") {
            let name = file.file_stem().expect("a name").to_string_lossy().into_owned();
            if let Some(&(_, side, free)) = known.iter().find(|known| known.0 == name) {
                let grid = parse(&std::fs::read_to_string(&file).expect("text")).expect("a map");
                assert_eq!((grid.cols(), grid.rows()), (side, side));
                assert_eq!(grid.occupied().len() - grid.occupied_count(), free, "{name}");
            }
        }
    }

    #[test]
    fn every_benchmark_query_starts_and_ends_on_free_cells() {
        let mut queries = 0;
        let files = benchmark_files("scen");
        for file in &files {
            let text = std::fs::read_to_string(file).expect("text");
            let map = text.lines().nth(1).and_then(|line| line.split('\t').nth(1)).expect("a map");
            let map = file.with_file_name(Path::new(map).file_name().expect("a name"));
            let grid = parse(&std::fs::read_to_string(map).expect("text")).expect("a map");
            for query in parse_queries(&text).expect("queries") {
                let free = [query.start, query.goal].map(|cell| grid.is_free(flip(&grid, cell)));
                assert_eq!(free, [true; 2], "{} {query:?}", file.display());
                queries += 1;
            }
        }
        assert!(files.is_empty() || queries == 7994, "{queries} queries");
    }
}
