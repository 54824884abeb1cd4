//! `simrun plan`: global planning alone, on a map file.

use super::{Failure, Out, say};
use crate::geometry::Pose;
use crate::map::file::{self, Unknown};
use crate::map::formats::movingai;
use crate::map::queries::{self, Query};
use crate::map::{Cell, DistanceField, OccupancyGrid};
use crate::metrics::planned::planned_turns;
use crate::observation::Belief;
use crate::plan::PlanningGrid;
use crate::plan::contract::{GlobalPlanner, PathStage, Plan, Randomness, Situation, Task};
use crate::plan::global::GlobalChoice;
use crate::plan::path::PathChoice;
use crate::plan::stack::find_path;
use crate::rng::EpisodeSeed;
use crate::robot::Robot;
use crate::settings::choice::unknown_name;
use crate::settings::quantity::{NonNegative, Positive};
use std::io::{self, Write};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("what").required(true).args(["scen", "queries", "from"]))]
pub(super) struct Args {
    /// Map file: .map, .yaml (ROS), .png, .pgm or .txt.
    map: PathBuf,
    /// Queries of the MovingAI benchmarks.
    #[arg(long, value_name = "FILE")]
    scen: Option<PathBuf>,
    /// Queries as a table with the columns start_col, start_row, goal_col, goal_row and, if known, length_cells.
    #[arg(long, value_name = "FILE")]
    queries: Option<PathBuf>,
    /// One query: its start. Columns count from the left, rows from the top of the file.
    #[arg(long, value_name = "COL,ROW", requires = "to", value_parser = cell)]
    from: Option<Cell>,
    /// One query: its goal.
    #[arg(long, value_name = "COL,ROW", requires = "from", value_parser = cell)]
    to: Option<Cell>,
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
    #[command(flatten)]
    out: Out,
}

fn cell(text: &str) -> Result<Cell, String> {
    let parsed = text
        .split_once(',')
        .and_then(|(col, row)| Some(Cell { col: col.trim().parse().ok()?, row: row.trim().parse().ok()? }));
    parsed.ok_or_else(|| format!("expected COL,ROW such as 3,14, found {text}"))
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

const HEADER: [&str; 16] = [
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
];

pub(super) fn main(args: &Args) -> Result<(), Failure> {
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
    let map = file::read(&args.map, args.resolution_m, Unknown::Occupied).map_err(|error| usage(error.to_string()))?;
    let queries = match (&args.scen, &args.queries, args.from, args.to) {
        (Some(file), ..) | (None, Some(file), ..) => queries::read(file).map_err(usage)?,
        (None, None, Some(start), Some(goal)) => {
            vec![Query { start, goal, optimum: None, tolerance: 0.0, line: 0 }]
        }
        _ => return Err(usage("name queries: --scen, --queries, or --from and --to".to_owned())),
    };
    for query in &queries {
        check(&map.grid, query).map_err(usage)?;
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
    let mut out = args.out.open()?;
    let name = args.map.file_name().unwrap_or_default().to_string_lossy();
    let question = Question { name: &name, map: &map.grid, grid: &grid, seed: args.seed };
    let written = stream(&mut out, &question, &queries, &mut planners);
    match written {
        // Somebody read enough of it, as `head` does.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => {}
        other => other.map_err(Failure::run)?,
    }
    for planner in &planners {
        say(&planner.tally.summary(planner.name));
    }
    Ok(())
}

/// Checks that both ends of a query are free cells of the map.
fn check(grid: &OccupancyGrid, query: &Query) -> Result<(), String> {
    for (what, at) in [("start", query.start), ("goal", query.goal)] {
        let line = if query.line > 0 { format!("line {}: ", query.line) } else { String::new() };
        let (col, row) = (at.col, at.row);
        let here = movingai::flip(grid, at);
        if !grid.contains(here) {
            let (cols, rows) = (grid.cols(), grid.rows());
            return Err(format!("{line}the {what} {col},{row} lies outside the map of {cols} columns and {rows} rows"));
        }
        if !grid.is_free(here) {
            return Err(format!("{line}the {what} {col},{row} is occupied (rows count from the top)"));
        }
    }
    Ok(())
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
    length: f64,
    expanded: u64,
    generated: u64,
}

impl Tally {
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
    out: &mut impl Write,
    question: &Question<'_>,
    queries: &[Query],
    planners: &mut [Planner],
) -> io::Result<()> {
    let Question { name, map, grid, seed } = *question;
    let mut table = csv::WriterBuilder::new().buffer_capacity(1 << 12).from_writer(out);
    table.write_record(HEADER)?;
    let (robot, belief, mut plan) = (Robot::default(), Belief::from(map), Plan::default());
    for (number, query) in queries.iter().enumerate() {
        let [start, goal] = [query.start, query.goal].map(|cell| grid.centre(movingai::flip(map, cell)));
        let pose = Pose { position: start, theta: 0.0 };
        let random = Randomness::new(EpisodeSeed { seed, episode: number as u64 }, 0);
        let situation = Situation { random, ..Situation::new(&robot, &belief, pose, goal) };
        for Planner { name: global, global: planner, stages, tally } in planners.iter_mut() {
            // Each query by itself: what a planner learnt from another is no part of the answer.
            planner.reset();
            let found =
                find_path(&mut **planner, stages, &Task { situation: &situation, grid, start, goal }, &mut plan);
            let (path, search) = (found.is_ok().then_some(&plan.path), plan.effort);
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
            let real = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
            table.write_record([
                name.to_owned(),
                number.to_string(),
                query.start.col.to_string(),
                query.start.row.to_string(),
                query.goal.col.to_string(),
                query.goal.row.to_string(),
                (*global).to_owned(),
                u8::from(length.is_some()).to_string(),
                real(query.optimum),
                real(length),
                real(length.map(|length| length * side_m)),
                real(ratio),
                search.expanded.to_string(),
                search.generated.to_string(),
                path.map_or_else(String::new, |path| planned_turns(path).to_string()),
                path.map_or_else(String::new, |path| path.fallbacks().to_string()),
            ])?;
        }
        table.flush()?;
    }
    table.flush()
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
