//! simrun's speed, as ratios against named peers and against the least work that the answer needs.
//!
//! ```text
//! cargo run --release -p simrun-benches -- --list
//! cargo run --release -p simrun-benches -- a_star jps      rows whose names begin with one of these
//! ```
//!
//! Inputs are loaded outside the timed part. Times are those of the process, pinned to one core, in turn A B A B; what
//! counts is the median of the ratios, pair by pair. Rows that need maps of the MovingAI benchmarks take them from
//! `--benchmarks` and say so where they are missing.

#![allow(
    clippy::disallowed_types,
    clippy::disallowed_methods,
    reason = "what is measured here reaches no results of simrun"
)]

mod decision;
mod floor;
mod grid;
mod measure;
mod scenes;
mod tick;

use clap::Parser;
use measure::{Pair, Spread};
use std::path::PathBuf;
use std::process::ExitCode;

/// How to measure.
#[derive(Debug, Parser)]
#[command(name = "simrun-benches", about = "simrun's speed beside that of its peers, as ratios")]
pub struct Settings {
    /// Rows whose names begin with one of these; all without any.
    names: Vec<String>,
    /// Prints the names of all rows.
    #[arg(long)]
    list: bool,
    /// Answers the queries of `benches/scenes` once with a planner of grids, to count instructions.
    #[arg(long, value_name = "PLANNER")]
    once: Option<String>,
    /// Prints what a map of so many cells a side and a search on it take of memory.
    #[arg(long, value_name = "SIDE", hide = true)]
    memory: Option<i32>,
    /// Pairs of measurements of each row.
    #[arg(long, default_value_t = 7)]
    pairs: usize,
    /// The core to run on.
    #[arg(long, default_value_t = 0)]
    core: usize,
    /// Folder of the MovingAI benchmarks: `NAME.map` with `NAME*.scen` beside it.
    #[arg(long, value_name = "FOLDER")]
    benchmarks: Option<PathBuf>,
    /// Writes the table to a file as well.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

/// A row of the table of benches; it may have several lines, one for each input.
pub struct Row {
    /// Its name.
    pub name: &'static str,
    /// What is measured, against what.
    pub what: &'static str,
    /// The ratio that is to be reached, where there is one.
    pub target: Option<Target>,
    /// Measures it: its lines, or why it cannot be measured here.
    pub measure: fn(&Settings) -> Result<Vec<Line>, String>,
}

/// What a ratio is to be.
#[derive(Clone, Copy, Debug)]
pub enum Target {
    /// At most this.
    AtMost(f64),
}

impl Target {
    fn is_met(self, ratio: f64) -> bool {
        match self {
            Self::AtMost(limit) => ratio <= limit,
        }
    }
}

/// One input measured.
pub struct Line {
    /// The input.
    pub input: String,
    /// Ours, s for the unit of work.
    pub ours: Spread,
    /// The other side, s, where there is one.
    pub other: Option<Spread>,
    /// Ours over the other.
    pub ratio: Option<Spread>,
    /// Counts that belong to it: expansions, points, bytes.
    pub counts: String,
}

impl Line {
    /// A line from a pair, ours first, whose calls do `units` units of work each.
    pub fn of(input: impl Into<String>, pair: Pair, units: f64, counts: impl Into<String>) -> Self {
        let per_unit = |s: Spread| Spread { median: s.median / units, min: s.min / units, max: s.max / units };
        Self {
            input: input.into(),
            ours: per_unit(pair.first),
            other: Some(per_unit(pair.second)),
            ratio: Some(pair.ratio),
            counts: counts.into(),
        }
    }

    /// A line without another side, from calls that do `units` units of work each.
    pub fn alone(input: impl Into<String>, time: Spread, units: f64, counts: impl Into<String>) -> Self {
        let ours = Spread { median: time.median / units, min: time.min / units, max: time.max / units };
        Self { input: input.into(), ours, other: None, ratio: None, counts: counts.into() }
    }
}

/// All rows.
const TABLE: &[&[Row]] = &[grid::ROWS, decision::ROWS, tick::ROWS];

fn main() -> ExitCode {
    let settings = Settings::parse();
    let is_wanted =
        |row: &&Row| settings.names.is_empty() || settings.names.iter().any(|name| row.name.starts_with(name.as_str()));
    let rows: Vec<&Row> = TABLE.iter().copied().flatten().filter(is_wanted).collect();
    if settings.list {
        for row in rows {
            println!("{:<28} {}", row.name, row.what);
        }
        return ExitCode::SUCCESS;
    }
    let printed = match (&settings.once, settings.memory) {
        (Some(planner), _) => Some(grid::once(planner)),
        (None, Some(side)) => Some(grid::memory(side)),
        (None, None) => None,
    };
    if let Some(printed) = printed {
        return match printed {
            Ok(text) => {
                println!("{text}");
                ExitCode::SUCCESS
            }
            Err(error) => {
                eprintln!("{error}");
                ExitCode::FAILURE
            }
        };
    }
    if let Err(error) = pin(settings.core) {
        eprintln!("not pinned to core {}: {error}", settings.core);
    }
    match print_table(&settings, &rows) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn pin(core: usize) -> rustix::io::Result<()> {
    let mut set = rustix::thread::CpuSet::new();
    set.set(core);
    rustix::thread::sched_setaffinity(None, &set)
}

const HEADER: [&str; 13] = [
    "row",
    "input",
    "ours_us",
    "ours_min_us",
    "ours_max_us",
    "other_us",
    "other_min_us",
    "other_max_us",
    "ratio",
    "ratio_min",
    "ratio_max",
    "target",
    "counts",
];

fn print_table(settings: &Settings, rows: &[&Row]) -> Result<(), csv::Error> {
    let mut table = match &settings.csv {
        Some(file) => Some(csv::Writer::from_path(file)?),
        None => None,
    };
    if let Some(table) = &mut table {
        table.write_record(HEADER)?;
    }
    println!(
        "{:<24} {:<30} {:>12} {:>12} {:>7} {:>17}  {:<10} counts",
        "row", "input", "ours us", "other us", "ratio", "min .. max", "target"
    );
    for row in rows {
        let lines = match (row.measure)(settings) {
            Ok(lines) => lines,
            Err(reason) => {
                println!("{:<24} not measured: {reason}", row.name);
                continue;
            }
        };
        for line in lines {
            let target = match (row.target, line.ratio) {
                (Some(target @ Target::AtMost(limit)), Some(ratio)) => {
                    format!("≤ {limit} {}", if target.is_met(ratio.median) { "met" } else { "MISSED" })
                }
                _ => String::new(),
            };
            let us = |spread: Option<Spread>| spread.map_or(String::new(), |s| format!("{:.3}", s.median * 1e6));
            let ratio = line.ratio.map_or(String::new(), |ratio| format!("{:.3}", ratio.median));
            let range = line.ratio.map_or(String::new(), |ratio| format!("{:.3} .. {:.3}", ratio.min, ratio.max));
            println!(
                "{:<24} {:<30} {:>12} {:>12} {ratio:>7} {range:>17}  {target:<10} {}",
                row.name,
                line.input,
                us(Some(line.ours)),
                us(line.other),
                line.counts
            );
            if let Some(table) = &mut table {
                let three = |spread: Option<Spread>, scale: f64| {
                    let number = |value: fn(Spread) -> f64| {
                        spread.map_or(String::new(), |spread| format!("{:.4}", value(spread) * scale))
                    };
                    [number(|s| s.median), number(|s| s.min), number(|s| s.max)]
                };
                let numbers = [three(Some(line.ours), 1e6), three(line.other, 1e6), three(line.ratio, 1.0)];
                let mut record = vec![row.name.to_owned(), line.input];
                record.extend(numbers.into_iter().flatten());
                record.extend([target, line.counts]);
                table.write_record(record)?;
                table.flush()?;
            }
        }
    }
    Ok(())
}
