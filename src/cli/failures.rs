//! `simrun failures`: the failed episodes of a folder of results by their cause, each with the commands that drive it again.

use super::scenarios::Changes;
use super::{Failure, Out, json, say};
use crate::command;
use crate::experiment::{Experiment, in_order, threads_available};
use crate::metrics::failure::Cause;
use crate::results::layout::{hanging, lines};
use crate::results::{EPISODES_CSV, Field, Reader, ResultsError, Row, json_object};
use crate::settings::quantity::counted;
use serde_json::Value as Json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder of results.
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Only failures of this stack, by its name in the results (repeatable).
    #[arg(long = "stack", value_name = "NAME")]
    stacks: Vec<String>,
    /// At most so many failures of each cause.
    #[arg(long, value_name = "N")]
    each: Option<usize>,
    /// Group them by their outcomes alone: nothing is driven again to find the cause.
    #[arg(long)]
    outcomes: bool,
    /// Threads; as many as there are processors by default.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// How to print it.
    #[arg(long, value_enum, default_value_t = Shape::Text)]
    format: Shape,
    #[command(flatten)]
    out: Out,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Shape {
    Text,
    Csv,
    Json,
}

/// A failed episode.
struct Failed {
    row: Row,
    /// What led to it; `None` where that was not asked for or this build drives the episode otherwise.
    cause: Option<Cause>,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    if args.format != Shape::Json {
        return print_failures(args);
    }
    json::answer("failures", &args.out, |document| {
        let (all, failed) = failures(args)?;
        let count = failed.len();
        let lines = lines_of(&args.folder, &grouped(failed, args.each));
        let lines: Vec<Json> = lines.iter().map(|line| json_object(HEADER, line).into()).collect();
        document.insert("episodes".to_owned(), all.into());
        document.insert("failed".to_owned(), count.into());
        document.insert("failures".to_owned(), lines.into());
        Ok(())
    })
}

fn print_failures(args: &Args) -> Result<(), Failure> {
    let (all, failed) = failures(args)?;
    match args.format {
        Shape::Csv => args.out.write(&csv(&lines_of(&args.folder, &grouped(failed, args.each)))?),
        Shape::Text | Shape::Json => args.out.write(&text(args, all, failed, args.out.width())),
    }
}

/// The failed episodes of the folder in the order of its rows, and the number of all.
fn failures(args: &Args) -> Result<(usize, Vec<Failed>), Failure> {
    let table = args.folder.join(EPISODES_CSV);
    let reader = Reader::open(&table).map_err(Failure::usage)?;
    let (mut rows, mut all) = (Vec::new(), 0);
    for row in reader {
        let row = row.map_err(|source| Failure::usage(ResultsError::Read { path: table.clone(), source }))?;
        if args.stacks.is_empty() || args.stacks.contains(&row.stack) {
            all += 1;
            rows.extend((!row.outcome.is_success()).then_some(row));
        }
    }
    let mut causes = vec![None; rows.len()];
    if !args.outcomes && !rows.is_empty() {
        let experiment = Changes::default().load(&args.folder)?;
        let threads = args.threads.unwrap_or_else(threads_available).max(1);
        causes = in_order(rows.len(), threads, |index| cause_of(&experiment, &rows[index]));
        let unknown = causes.iter().filter(|cause| cause.is_none()).count();
        if unknown > 0 {
            say(&format!(
                "{}: this build drives {} otherwise, the causes of which are not known",
                args.folder.display(),
                counted(unknown as u64, "episode")
            ));
        }
    }
    Ok((all, rows.into_iter().zip(causes).map(|(row, cause)| Failed { row, cause }).collect()))
}

/// What led to the failure: the episode is driven again.
fn cause_of(experiment: &Experiment, row: &Row) -> Option<Cause> {
    if row.trace_digest.is_none() {
        return Some(Cause::NeverDrove);
    }
    let drive = experiment.drive_again(row)?;
    if drive.row.trace_digest == row.trace_digest { drive.cause() } else { None }
}

/// The failures by outcome and cause, the most frequent first; ties in the order of the rows.
fn grouped(failed: Vec<Failed>, each: Option<usize>) -> Vec<(String, usize, Vec<Failed>)> {
    let mut groups: Vec<(String, usize, Vec<Failed>)> = Vec::new();
    let mut known: BTreeMap<(String, Option<Cause>), usize> = BTreeMap::new();
    for failure in failed {
        let key = (failure.row.outcome.words(), failure.cause);
        let title = match key.1.filter(|cause| *cause != Cause::NeverDrove) {
            Some(cause) => format!("{}: {}", key.0, cause.words()),
            None => key.0.clone(),
        };
        let group = *known.entry(key).or_insert(groups.len());
        if group == groups.len() {
            groups.push((title, 0, Vec::new()));
        }
        groups[group].1 += 1;
        if groups[group].2.len() < each.unwrap_or(usize::MAX) {
            groups[group].2.push(failure);
        }
    }
    groups.sort_by_key(|(_, count, _)| std::cmp::Reverse(*count));
    groups
}

/// The commands that draw a row's episode and that drive it again with a trace.
fn commands(folder: &Path, row: &Row) -> [String; 2] {
    let (episode, point) = (row.episode.to_string(), row.point.to_string());
    let which = |subcommand: &str| {
        let mut words = vec!["simrun".into(), subcommand.into(), folder.as_os_str().to_owned()];
        words.extend(["--episode", &episode].map(Into::into));
        if row.point > 0 {
            words.extend(["--point", &point].map(Into::into));
        }
        words.extend(["--stack", &row.stack].map(Into::into));
        words
    };
    let [mut draw, mut run] = ["draw", "run"].map(which);
    draw.extend(["--out".into(), format!("p{point}_e{episode}_{}.svg", row.stack).into()]);
    run.push("--trace".into());
    [command::line(draw), command::line(run)]
}

fn text(args: &Args, all: usize, failed: Vec<Failed>, width: usize) -> String {
    let folder = args.folder.display();
    let mut text = format!("{folder}: {} of {} failed\n", failed.len(), counted(all as u64, "episode"));
    for (title, count, failed) in grouped(failed, args.each) {
        text.push('\n');
        text += &hanging("", 2, &format!("{title} ({count})"), width);
        for Failed { row, .. } in &failed {
            let point = if row.point > 0 { format!(", point {}", row.point) } else { String::new() };
            let after = row.metrics.time_s.map_or_else(String::new, |time| format!(", after {time:.1} s"));
            let message = row.outcome.message();
            let message = if message.is_empty() { String::new() } else { format!(": {message}") };
            text += &lines(&format!("  {}, episode {}{point}{after}{message}", row.stack, row.episode), width);
            // Whole, to be copied.
            for command in commands(&args.folder, row) {
                text += &format!("    {command}\n");
            }
        }
        if failed.len() < count {
            text += &format!("  … and {} more\n", count - failed.len());
        }
    }
    text
}

/// The columns of the table.
const HEADER: [&str; 12] = [
    "point",
    "stack",
    "episode",
    "seed",
    "outcome",
    "collision_with",
    "at_rest",
    "cause",
    "time_s",
    "message",
    "draw",
    "run",
];

/// The values of those columns, one line per failure.
fn lines_of(folder: &Path, groups: &[(String, usize, Vec<Failed>)]) -> Vec<[Field; HEADER.len()]> {
    let line = |Failed { row, cause }: &Failed| {
        let parts = row.outcome.parts();
        let [draw, run] = commands(folder, row);
        [
            row.point.into(),
            (&row.stack).into(),
            row.episode.into(),
            row.seed.into(),
            row.outcome.name().into(),
            parts.with.map(|with| with.name()).into(),
            parts.at_rest.copied().into(),
            cause.map(Cause::words).into(),
            row.metrics.time_s.into(),
            row.outcome.message().into(),
            (&draw).into(),
            (&run).into(),
        ]
    };
    groups.iter().flat_map(|(_, _, failed)| failed).map(line).collect()
}

fn csv(lines: &[[Field; HEADER.len()]]) -> Result<String, Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(HEADER).map_err(Failure::run)?;
    for line in lines {
        writer.write_record(line.iter().map(Field::csv)).map_err(Failure::run)?;
    }
    Ok(String::from_utf8_lossy(&writer.into_inner().map_err(Failure::run)?).into_owned())
}
