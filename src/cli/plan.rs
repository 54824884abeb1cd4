//! `simrun plan`: global planning alone, on a map file.

use super::map::UnknownArg;
use super::{Failure, Out, json, say};
use crate::geometry::{Path as PlannedPath, Pose, Vec2};
use crate::map::file::{self, Loaded};
use crate::map::formats::movingai;
use crate::map::queries::{self, Queries, Query};
use crate::map::{Cell, DistanceField, OccupancyGrid};
use crate::metrics::planned::planned_turns;
use crate::observation::Belief;
use crate::plan::PlanningGrid;
use crate::plan::contract::{
    self as planning, GlobalPlanner, PathStage, Plan, Randomness, SearchEffort, Situation, Task,
};
use crate::plan::global::GlobalChoice;
use crate::plan::path::PathChoice;
use crate::plan::stack::find_path;
use crate::results::{Field, json_object};
use crate::rng::EpisodeSeed;
use crate::robot::Robot;
use crate::settings::choice::unknown_name;
use crate::settings::quantity::{NonNegative, Positive};
use serde_json::{Value as Json, json};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("what").required(true).args(["scen", "queries", "from"]))]
pub(super) struct Args {
    /// Map file: .map, .yaml (ROS), .png, .pgm or .txt.
    map: PathBuf,
    /// Queries of the MovingAI benchmarks (a .scen, whatever it is called).
    #[arg(long, value_name = "FILE")]
    scen: Option<PathBuf>,
    /// Queries as a table with the columns start_col, start_row, goal_col, goal_row and, if known, length_cells; a file that opens as a
    /// .scen is read as one.
    #[arg(long, value_name = "FILE")]
    queries: Option<PathBuf>,
    /// One query: its start. Columns count from the left, rows from the top of the file.
    #[arg(long, value_name = "COL,ROW", requires = "to", value_parser = pair, allow_hyphen_values = true)]
    from: Option<Pair>,
    /// One query: its goal.
    #[arg(long, value_name = "COL,ROW", requires = "from", value_parser = pair, allow_hyphen_values = true)]
    to: Option<Pair>,
    /// --from and --to are points X,Y in metres of the map's frame; the cells that hold them are meant.
    #[arg(long, requires = "from")]
    metres: bool,
    /// Global planners, joined by commas; `simrun planners` lists them.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', default_value = "a_star")]
    global: Vec<String>,
    /// Path stages that follow, joined by commas.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    path: Vec<String>,
    /// Distance that paths keep from obstacles, m.
    #[arg(long, value_name = "METRES", default_value = "0", value_parser = distance)]
    inflate: NonNegative,
    /// Seed of planners that draw random numbers; query k is episode k.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Side of a cell, m, for formats that do not say it.
    #[arg(long, value_name = "METRES", default_value = "1", value_parser = resolution)]
    resolution_m: Positive,
    /// What unknown cells count as.
    #[arg(long, value_enum, default_value = "occupied")]
    unknown: UnknownArg,
    /// Write the points of the paths to this file: query, planner, number of the point, column and row in cells of the file (cell centres
    /// are whole), x and y in metres of the map's frame. Arcs and curves become chords.
    #[arg(long, value_name = "FILE")]
    paths: Option<PathBuf>,
    /// How to print it: a table, or one JSON document with a row for each query and planner and the sums of each planner.
    #[arg(long, value_enum, default_value_t)]
    format: CsvOrJson,
    #[command(flatten)]
    out: Out,
}

/// Format of the rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
enum CsvOrJson {
    #[default]
    Csv,
    Json,
}

/// Two numbers as given.
#[derive(Clone, Copy, Debug)]
struct Pair([f64; 2]);

fn pair(text: &str) -> Result<Pair, String> {
    let number = |part: &str| part.trim().parse().ok().filter(|number: &f64| number.is_finite());
    let parsed = text.split_once(',').and_then(|(a, b)| Some(Pair([number(a)?, number(b)?])));
    parsed.ok_or_else(|| format!("expected two numbers such as 3,14, found {text}"))
}

impl Args {
    /// The cell of the file that --from or --to means.
    fn cell(&self, option: &str, Pair([a, b]): Pair, grid: &OccupancyGrid) -> Result<Cell, String> {
        if self.metres {
            let here = grid.cell_at(grid.frame().point_to_grid(Vec2::new(a, b)));
            if grid.contains(here) {
                return Ok(movingai::flip(grid, here));
            }
            let extent = grid.extent_m();
            let corner = |x: f64, y: f64| {
                let corner = grid.frame().point_to_world(Vec2::new(x, y));
                format!("{},{}", to_nano(corner.x), to_nano(corner.y))
            };
            let (lower, upper) = (corner(0.0, 0.0), corner(extent.x, extent.y));
            return Err(format!("{option} {a},{b} m lies outside the map, which reaches from {lower} to {upper} m"));
        }
        let whole = |number: f64| {
            let is_whole = number.fract() == 0.0 && number.abs() < f64::from(i32::MAX);
            let refused = || format!("{option}: expected the whole numbers COL,ROW, found {a},{b}; --metres takes X,Y");
            is_whole.then_some(number as i32).ok_or_else(refused)
        };
        Ok(Cell { col: whole(a)?, row: whole(b)? })
    }

    /// Refuses to write where something is read, or two things to one file.
    fn keep_inputs(&self) -> Result<(), String> {
        let inputs = [Some(&self.map), self.scen.as_ref(), self.queries.as_ref()];
        let found = |file: &Path| file.canonicalize().ok();
        let outputs = [("--out", self.out.file()), ("--paths", self.paths.as_deref())];
        for (option, output) in outputs.iter().filter_map(|(option, file)| Some((option, (*file)?))) {
            if inputs.into_iter().flatten().any(|input| found(output).is_some() && found(output) == found(input)) {
                return Err(format!("{option} {} is an input: write elsewhere", output.display()));
            }
        }
        match outputs {
            [(_, Some(out)), (_, Some(paths))] if out == paths => Err("--out and --paths name one file".to_owned()),
            _ => Ok(()),
        }
    }
}

/// A number to the ninth decimal: sums of cells and halves of cells come out whole.
fn to_nano(number: f64) -> f64 {
    let rounded = (number * 1e9).round() / 1e9;
    // −0 is 0, and what is too large to round stays.
    if rounded.is_finite() { rounded + 0.0 } else { number }
}

fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| format!("expected a number, found {text}"))
}

fn distance(text: &str) -> Result<NonNegative, String> {
    NonNegative::try_from(number(text)?)
}

fn resolution(text: &str) -> Result<Positive, String> {
    Positive::try_from(number(text)?)
}

const HEADER: [&str; 17] = [
    "map",
    "query",
    "start_col",
    "start_row",
    "goal_col",
    "goal_row",
    "global",
    "found",
    "optimal",
    "length",
    "length_m",
    "ratio",
    "expanded",
    "generated",
    "turns",
    "fallbacks",
    "note",
];

const PATHS_HEADER: [&str; 7] = ["query", "global", "point", "col", "row", "x_m", "y_m"];

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    if args.format == CsvOrJson::Json {
        return json::answer("plan", &args.out, |document| plan(args, Some(document)));
    }
    plan(args, None)
}

/// Answers the queries, into `document` or as a table.
fn plan(args: &Args, document: Option<&mut json::Object>) -> Result<(), Failure> {
    let usage = |message: String| Failure::Usage(format!("error: {message}"));
    let globals = args.global.iter().map(|name| {
        GlobalChoice::by_name(name).map_err(|_| usage(unknown_name("global planner", name, GlobalChoice::NAMES)))
    });
    let globals = globals.collect::<Result<Vec<_>, Failure>>()?;
    let stages = args
        .path
        .iter()
        .map(|name| PathChoice::by_name(name).map_err(|_| usage(unknown_name("path stage", name, PathChoice::NAMES))));
    let stages = stages.collect::<Result<Vec<_>, Failure>>()?;
    args.keep_inputs().map_err(usage)?;
    let map =
        file::read(&args.map, args.resolution_m, args.unknown.into()).map_err(|error| usage(error.to_string()))?;
    let (file, queries) = match (&args.scen, &args.queries, args.from, args.to) {
        (Some(file), ..) => (Some(file), queries::read_scen(file).map_err(usage)?),
        (None, Some(file), ..) => (Some(file), queries::read(file).map_err(usage)?),
        (None, None, Some(from), Some(to)) => {
            let cell = |option, pair| args.cell(option, pair, &map.grid).map_err(usage);
            let list = vec![Query::new(cell("--from", from)?, cell("--to", to)?)];
            (None, Queries { list, maps: Vec::new() })
        }
        _ => return Err(usage("name queries: --scen, --queries, or --from and --to".to_owned())),
    };
    let mut notes = map.notes.clone();
    if let Some(file) = file {
        notes.extend(check_maps(&args.map, &map.grid, file, &queries).map_err(usage)?);
    }
    let queries: Vec<Asked> =
        queries.list.into_iter().map(|query| Asked { query, refusal: refusal(&map, &query).err() }).collect();
    notes.extend(check_all(file, &queries).map_err(usage)?);
    for note in &notes {
        say(&format!("note: {note}"));
    }

    let grid = PlanningGrid::new(&map.grid, &DistanceField::new(&map.grid), args.inflate.get());
    let mut planners: Vec<Planner> = globals
        .iter()
        .map(|global| Planner {
            name: global.name(),
            global: global.build(),
            stages: stages.iter().map(PathChoice::build).collect(),
            tally: Tally::default(),
        })
        .collect();
    let mut rows = match &document {
        None => {
            let mut table = csv::WriterBuilder::new().buffer_capacity(1 << 12).from_writer(args.out.open()?);
            table.write_record(HEADER).map_err(Failure::run)?;
            Rows::Table(Box::new(table))
        }
        Some(_) => Rows::Json(Vec::new()),
    };
    let paths = args.paths.clone().map(|file| Out { out: Some(file) }.open()).transpose()?;
    let name = args.map.file_name().unwrap_or_default().to_string_lossy();
    let question = Question { name: &name, map: &map.grid, grid: &grid, seed: args.seed };
    let written = stream(&mut rows, paths, &question, &queries, &mut planners);
    match written {
        // Somebody read enough of it, as `head` does.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {}
        other => other.map_err(Failure::run)?,
    }
    for planner in &planners {
        say(&planner.tally.summary(planner.name));
    }
    if let (Some(document), Rows::Json(rows)) = (document, rows) {
        let sums: Vec<Json> = planners.iter().map(|planner| planner.tally.as_json(planner.name)).collect();
        document.insert("notes".to_owned(), notes.into());
        document.insert("planners".to_owned(), sums.into());
        document.insert("rows".to_owned(), rows.into());
    }
    Ok(())
}

/// Where the rows go.
enum Rows {
    /// To a table, as they come.
    Table(Box<csv::Writer<Box<dyn Write>>>),
    /// To a document that is written at the end.
    Json(Vec<Json>),
}

impl Rows {
    fn push(&mut self, fields: &[Field; HEADER.len()]) -> io::Result<()> {
        match self {
            Self::Table(table) => Ok(table.write_record(fields.iter().map(Field::csv))?),
            Self::Json(rows) => {
                rows.push(json_object(HEADER, fields).into());
                Ok(())
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Table(table) => table.flush(),
            Self::Json(_) => Ok(()),
        }
    }
}

/// A query, and the reason why it cannot be asked.
struct Asked {
    query: Query,
    refusal: Option<String>,
}

impl Asked {
    /// The reason with the line of the file.
    fn placed(&self) -> Option<String> {
        let refusal = self.refusal.as_ref()?;
        Some(if self.query.line > 0 { format!("line {}: {refusal}", self.query.line) } else { refusal.clone() })
    }
}

/// Checks that both ends of a query are free cells of the map.
fn refusal(map: &Loaded, query: &Query) -> Result<(), String> {
    let grid = &map.grid;
    for (what, at) in [("start", query.start), ("goal", query.goal)] {
        let (col, row) = (at.col, at.row);
        // In the cells of the file: turning over a row that is far outside would overflow.
        if !grid.contains(at) {
            let (cols, rows) = (grid.cols(), grid.rows());
            return Err(format!("the {what} {col},{row} lies outside the map of {cols} columns and {rows} rows"));
        }
        let here = movingai::flip(grid, at);
        if !grid.is_free(here) {
            return Err(if map.is_unknown(here) {
                format!("the {what} {col},{row} is unknown, which counts as occupied; --unknown free plans through it")
            } else {
                format!("the {what} {col},{row} is occupied (rows count from the top)")
            });
        }
    }
    Ok(())
}

/// Refuses queries that are for a map of another size; a note if they are for one of another name.
fn check_maps(map: &Path, grid: &OccupancyGrid, file: &Path, queries: &Queries) -> Result<Option<String>, String> {
    let shown = file.display();
    for named in &queries.maps {
        let ([cols, rows], line) = (named.size, named.line);
        if [cols, rows] != [grid.cols(), grid.rows()] {
            return Err(format!(
                "{shown}: line {line}: found queries for a map of {cols} x {rows} cells, expected {} x {} as {} has",
                grid.cols(),
                grid.rows(),
                map.display()
            ));
        }
    }
    let stem = |name: &str| {
        let name = name.rsplit(['/', '\\']).next().unwrap_or_default();
        name.split_once('.').map_or(name, |(stem, _)| stem).to_lowercase()
    };
    let this = stem(&map.to_string_lossy());
    let other = queries.maps.iter().find(|named| stem(&named.name) != this);
    Ok(other.map(|named| {
        let name: String = named.name.chars().take(80).collect();
        format!("{shown}: line {}: the queries are for the map `{}`", named.line, name.escape_debug())
    }))
}

/// A note if some queries cannot be asked; an error if none can.
fn check_all(file: Option<&PathBuf>, queries: &[Asked]) -> Result<Option<String>, String> {
    let shown = file.map_or_else(String::new, |file| format!("{}: ", file.display()));
    let refused: Vec<String> = queries.iter().filter_map(Asked::placed).collect();
    Ok(match (&refused[..], queries.len()) {
        ([], _) => None,
        ([only], 1) => return Err(format!("{shown}{only}")),
        ([first, ..], all) if refused.len() == all => {
            return Err(format!("{shown}none of {all} queries can be asked of this map, the first because of {first}"));
        }
        ([first, ..], all) => {
            Some(format!("{shown}{} of {all} queries cannot be asked, see the column `note`; {first}", refused.len()))
        }
    })
}

/// A planner with its stages, and what it has done so far.
struct Planner {
    name: &'static str,
    global: Box<dyn GlobalPlanner>,
    stages: Vec<Box<dyn PathStage>>,
    tally: Tally,
}

/// Sums over the queries of one planner.
#[derive(Default)]
struct Tally {
    queries: u64,
    found: u64,
    /// Queries with a known optimum.
    known: u64,
    equal: u64,
    shorter: u64,
    ratio_worst: f64,
    ratio_sum: f64,
    /// Ways found where the file says that there is none.
    against_file: u64,
    length: f64,
    expanded: u64,
    generated: u64,
}

impl Tally {
    fn as_json(&self, name: &str) -> Json {
        let mean = (self.known > 0).then(|| self.ratio_sum / self.known as f64);
        json!({
            "global": name,
            "queries": self.queries,
            "found": self.found,
            "optimum_known": self.known,
            "equal_optimum": self.equal,
            "shorter_than_optimum": self.shorter,
            "ratio_mean": mean,
            "ratio_worst": (self.known > 0).then_some(self.ratio_worst),
            "found_against_file": self.against_file,
            "length_sum": self.length,
            "expanded_sum": self.expanded,
            "generated_sum": self.generated,
        })
    }

    fn summary(&self, name: &str) -> String {
        let optimum = if self.known == 0 {
            "no optimum is known".to_owned()
        } else {
            let mean = self.ratio_sum / self.known as f64;
            format!(
                "{} of {} equal the optimum, {} are shorter, ratio mean {mean:.6}, worst {:.6}",
                self.equal, self.known, self.shorter, self.ratio_worst
            )
        };
        let optimum = match self.against_file {
            0 => optimum,
            ways => format!("{optimum}; {ways} found where the file gives the length 0, which stands for no way"),
        };
        format!(
            "{name}: {} queries, {} found; {optimum}; {:.1} cells, {} expanded, {} generated",
            self.queries, self.found, self.length, self.expanded, self.generated
        )
    }
}

/// Inputs that all queries share.
struct Question<'a> {
    name: &'a str,
    map: &'a OccupancyGrid,
    grid: &'a PlanningGrid,
    seed: u64,
}

/// Answers every query with every planner, a row each, as they come.
fn stream(
    rows: &mut Rows,
    paths: Option<Box<dyn Write>>,
    question: &Question<'_>,
    queries: &[Asked],
    planners: &mut [Planner],
) -> io::Result<()> {
    let Question { name, map, grid, seed } = *question;
    let mut paths = paths.map(csv::Writer::from_writer);
    if let Some(paths) = &mut paths {
        paths.write_record(PATHS_HEADER)?;
    }
    let (robot, belief, mut plan) = (Robot::default(), Belief::from(map), Plan::default());
    for (number, Asked { query, refusal }) in queries.iter().enumerate() {
        // Ends that are not on the map are not asked for.
        let ends = [query.start, query.goal].map(|cell| match refusal {
            None => grid.centre(movingai::flip(map, cell)),
            Some(_) => Vec2::default(),
        });
        let [start, goal] = ends;
        let pose = Pose { position: start, theta: 0.0 };
        let random = Randomness::new(EpisodeSeed { seed, episode: number as u64 }, 0);
        let situation = Situation { random, ..Situation::new(&robot, &belief, pose, goal) };
        for Planner { name: global, global: planner, stages, tally } in planners.iter_mut() {
            // Each query by itself: what a planner learnt from another is no part of the answer.
            planner.reset();
            let task = Task { situation: &situation, grid, start, goal };
            let found = match refusal {
                None => find_path(&mut **planner, stages, &task, &mut plan).map_err(|failure| why(&failure, &task)),
                Some(refusal) => Err(refusal.clone()),
            };
            let path = found.is_ok().then_some(&plan.path);
            let search = if refusal.is_some() { SearchEffort::default() } else { plan.effort };
            let side_m = grid.resolution_m();
            let is_of_cells = stages.is_empty() && !plan.cells.is_empty();
            let length = path.map(|path| if is_of_cells { length_cells(&plan.cells) } else { path.length() / side_m });
            let ratio = length.zip(query.optimum).filter(|(_, optimum)| *optimum > 0.0).map(|(l, o)| l / o);
            tally.queries += 1;
            tally.found += u64::from(length.is_some());
            tally.length += length.unwrap_or_default();
            tally.expanded += search.expanded;
            tally.generated += search.generated;
            if let (Some(length), Some(optimum)) = (length, query.optimum) {
                tally.known += 1;
                tally.equal += u64::from((length - optimum).abs() <= query.tolerance);
                tally.shorter += u64::from(length < optimum - query.tolerance);
                tally.ratio_sum += ratio.unwrap_or(1.0);
                tally.ratio_worst = crate::math::max(tally.ratio_worst, ratio.unwrap_or(1.0));
            }
            let is_against_file = query.says_no_way && length.is_some();
            tally.against_file += u64::from(is_against_file);
            let note = match found {
                Ok(()) if is_against_file => "the file gives the length 0, which stands for no way".to_owned(),
                Ok(()) => String::new(),
                Err(reason) => reason,
            };
            rows.push(&[
                name.into(),
                (number as u64).into(),
                query.start.col.into(),
                query.start.row.into(),
                query.goal.col.into(),
                query.goal.row.into(),
                (*global).into(),
                u64::from(length.is_some()).into(),
                query.optimum.or(query.says_no_way.then_some(0.0)).into(),
                length.into(),
                length.map(|length| length * side_m).into(),
                ratio.into(),
                search.expanded.into(),
                search.generated.into(),
                path.map(|path| planned_turns(path) as u64).into(),
                path.map(|path| path.fallbacks() as u64).into(),
                note.as_str().into(),
            ])?;
            if let (Some(paths), Some(path)) = (&mut paths, path) {
                for (point, p) in points(path, side_m).into_iter().enumerate() {
                    let world = map.frame().point_to_world(p);
                    // The centre of cell c lies at c + ½ sides; rows count from the top.
                    let (col, row) = (p.x / side_m - 0.5, f64::from(map.rows()) - 0.5 - p.y / side_m);
                    let numbers = [col, row, world.x, world.y].map(|number| to_nano(number).to_string());
                    let names = [number.to_string(), (*global).to_owned(), point.to_string()];
                    paths.write_record(names.iter().chain(&numbers))?;
                }
            }
        }
        rows.flush()?;
    }
    if let Some(paths) = &mut paths {
        paths.flush()?;
    }
    rows.flush()
}

/// Why there is no path: what keeps an end from being planned from, if something does.
fn why(failure: &planning::Failure, task: &Task<'_>) -> String {
    let inflation_m = task.grid.inflation_m();
    let blocked = [("start", task.start), ("goal", task.goal)]
        .into_iter()
        .find(|(_, end)| !task.grid.is_passable(task.grid.cell_at(*end)));
    match blocked {
        Some((what, _)) => format!("the {what} is nearer than --inflate {inflation_m} m to an obstacle"),
        None => failure.to_string(),
    }
}

/// Largest distance of chords from the arc or curve for which they stand, cells.
const SAGITTA_CELLS: f64 = 0.01;

/// The points of a path, arcs and curves as chords, grid frame.
fn points(path: &PlannedPath, side_m: f64) -> Vec<Vec2> {
    let mut points = vec![path.start()];
    for (from, piece) in path.segments() {
        let chords = piece.chord_count(from, SAGITTA_CELLS * side_m, 1000.0);
        points.extend((1..=chords).map(|k| piece.chord_point(from, k, chords)));
    }
    points
}

/// Length of a path of cells, in cells: whole steps are counted before they are added up.
fn length_cells(path: &[Cell]) -> f64 {
    let (mut straight, mut diagonal, mut rest) = (0i64, 0i64, 0.0);
    for pair in path.windows(2) {
        let (cols, rows) = (i64::from((pair[1].col - pair[0].col).abs()), i64::from((pair[1].row - pair[0].row).abs()));
        if cols == 0 || rows == 0 {
            straight += cols + rows;
        } else if cols == rows {
            diagonal += cols;
        } else {
            rest += ((cols * cols + rows * rows) as f64).sqrt();
        }
    }
    straight as f64 + diagonal as f64 * core::f64::consts::SQRT_2 + rest
}
