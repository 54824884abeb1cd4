//! `simrun run`: scenarios become tables.

use super::interrupt::Interrupt;
use super::isolated::Isolate;
use super::json;
use super::scenarios::{AtPoint, Changes, load_all};
use super::{Failure, Out, command_comment, print, say, width};
use crate::clock::Stopwatch;
use crate::comparison::{self, Format};
use crate::experiment::{Experiment, Isolation, Session, Worker, threads_available};
use crate::files;
use crate::results::{self, Answer, Existing, Identity, Manifest, Opened, ResultsError, Row, SummaryRow, TRACES};
use crate::settings::quantity::counted;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value as Json, json};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::time::Duration;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scenario files, each of which writes a folder of its own; or folders of results, which go on where they are.
    #[arg(required = true, value_name = "SCENARIO")]
    scenarios: Vec<PathBuf>,
    /// Folder of the results; results/NAME by default (one scenario only).
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Throw away other results in that folder.
    #[arg(long)]
    force: bool,
    /// Run this episode alone and print its rows as CSV; nothing but a --trace is written.
    #[arg(long, value_name = "N")]
    episode: Option<u64>,
    #[command(flatten)]
    point: AtPoint,
    /// Also write what happened tick by tick: one CSV per episode and stack, in FOLDER/traces.
    #[arg(long)]
    trace: bool,
    /// Threads; as many as there are processors by default. Results do not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    #[command(flatten)]
    isolate: Isolate,
    /// Fail (exit code 3) unless every stack reaches this success rate, from 0 to 1.
    #[arg(long, value_name = "RATE")]
    require_success: Option<f64>,
    /// Ask it of the lower end of the 95 % interval and not of the rate itself: then a lucky run does not pass, and it takes more
    /// episodes to pass.
    #[arg(long, requires = "require_success")]
    require_interval: bool,
    /// No progress bar and no table.
    #[arg(short, long)]
    quiet: bool,
    /// How to print the summary; the rows of --episode are CSV, or json. json is one document with every column of summary.csv, or of episodes.csv.
    #[arg(long, value_enum, default_value_t)]
    format: Shape,
    #[command(flatten)]
    waiting: Waiting,
    #[command(flatten)]
    changes: Changes,
}

/// What to do while another run holds the folder of results.
#[derive(Debug, clap::Args)]
pub(super) struct Waiting {
    /// Wait up to this many seconds while another run is writing to the folder; without it such a folder ends the command (exit code 75).
    #[arg(long, value_name = "SECONDS", default_value_t = 0)]
    wait_lock: u32,
}

impl Waiting {
    /// How often a folder in use is looked at again.
    const STEP: Duration = Duration::from_millis(100);

    /// Opens the folder of results, as soon as nobody else holds it.
    pub(super) fn open<'e>(
        &self,
        experiment: &'e Experiment,
        folder: &Path,
        existing: Existing,
    ) -> Result<Session<'e>, Failure> {
        // From here on what is finished is kept.
        let interrupt = Interrupt::listen()?;
        let clock = Stopwatch::start();
        let mut is_said = false;
        loop {
            match Session::open(experiment, folder, existing) {
                Err(ResultsError::Locked { holder, .. }) if clock.elapsed_s() < f64::from(self.wait_lock) => {
                    if !is_said {
                        say(&format!("{}: in use by {holder}, waiting for it", folder.display()));
                    }
                    is_said = true;
                    if let Some(code) = interrupt.code() {
                        return Err(Interrupt::failure(code, "nothing was begun"));
                    }
                    std::thread::sleep(Self::STEP);
                }
                Ok(session) => {
                    if !session.is_guarded() {
                        say(&format!(
                            "note: the file system of {} has no locks: let no second run write there",
                            folder.display()
                        ));
                    }
                    return Ok(session);
                }
                Err(error) => return Err(refused(error)),
            }
        }
    }
}

/// Format of the summary.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Shape {
    /// A table for the terminal.
    #[default]
    Text,
    /// A table of Markdown.
    Markdown,
    /// A table of LaTeX; it needs the package booktabs.
    Latex,
    /// One JSON document.
    Json,
}

impl Shape {
    /// The format of a table for papers; `None` for the terminal and for programs.
    fn of_paper(self) -> Option<Format> {
        match self {
            Self::Text | Self::Json => None,
            Self::Markdown => Some(Format::Markdown),
            Self::Latex => Some(Format::Latex),
        }
    }
}

impl Args {
    /// The scenario files.
    pub(super) fn scenarios(&self) -> &[PathBuf] {
        &self.scenarios
    }
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    if args.format == Shape::Json {
        return json::answer("run", &Out::default(), |document| {
            let mut runs = Vec::new();
            let result = run_scenarios(args, &mut runs);
            document.insert("runs".to_owned(), runs.into());
            result
        });
    }
    run_scenarios(args, &mut Vec::new())
}

/// Runs the scenarios one after the other; each adds what it found to `runs`.
fn run_scenarios(args: &Args, runs: &mut Vec<Json>) -> Result<(), Failure> {
    if args.out.is_some() && args.scenarios.len() > 1 {
        return Err(Failure::usage("--out names one folder, for one scenario"));
    }
    if args.episode.is_some() && args.format.of_paper().is_some() {
        return Err(Failure::usage("the rows of --episode are CSV or --format json"));
    }
    if args.point.point > 0 && args.episode.is_none() {
        return Err(Failure::usage("--point runs one world: name its --episode as well"));
    }
    if args.require_success.is_some_and(|rate| !(0.0..=1.0).contains(&rate)) {
        return Err(Failure::usage("--require-success takes a rate from 0 to 1"));
    }
    // All scenarios are checked before the first one runs.
    let load = |source: &Path| args.changes.load_for(source, args.threads, &args.isolate);
    let experiments = load_all(&args.scenarios, load)?;
    for (index, experiment) in experiments.iter().enumerate() {
        // Some file systems take capitals and small letters for the same.
        let name = &experiment.scenario().name;
        let is_same =
            |other: &&Experiment| other.scenario().name.as_str().to_lowercase() == name.as_str().to_lowercase();
        if let Some(other) = experiments[..index].iter().find(is_same) {
            let other = &other.scenario().name;
            return Err(Failure::usage(if other == name {
                format!("two scenarios are called `{name}` and would write the same folder")
            } else {
                format!("`{other}` and `{name}` are the same folder where capitals do not count")
            }));
        }
    }
    let mut sources = args.scenarios.iter().zip(&experiments);
    sources.try_for_each(|(source, experiment)| run(args, source, experiment, runs))
}

fn run(args: &Args, source: &Path, experiment: &Experiment, runs: &mut Vec<Json>) -> Result<(), Failure> {
    for note in experiment.map_notes().iter().filter(|_| !args.quiet) {
        say(&format!("note: {note}"));
    }
    // A folder of results goes on where it is.
    let own = || {
        if source.is_dir() { source.to_owned() } else { Path::new("results").join(experiment.scenario().name.as_str()) }
    };
    let folder = args.out.clone().unwrap_or_else(own);
    let traces = args.trace.then(|| folder.join(TRACES));
    match args.episode {
        Some(episode) => {
            let point = args.point.driven(experiment)?;
            if let Some(traces) = &traces {
                refuse_traces_of_another_run(experiment, &folder)?;
                create(traces)?;
            }
            run_one(args, experiment, (point, episode), traces.as_deref(), runs)
        }
        None => args.isolate.with(source, &args.changes, traces.as_deref(), |isolation| {
            run_all(args, experiment, &folder, traces.as_deref(), isolation, runs)
        }),
    }
}

fn create(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .map_err(|error| Failure::Run(format!("error: cannot create `{}`: {error}", folder.display())))
}

/// Keeps the trace of a single episode out of a folder with the rows of another run; some of its stacks are the same run.
fn refuse_traces_of_another_run(experiment: &Experiment, folder: &Path) -> Result<(), Failure> {
    let Ok(there) = Manifest::read(folder) else { return Ok(()) };
    let here = Identity { stacks: there.identity.stacks.clone(), ..experiment.identity() };
    match there.identity.differences(&here).as_slice() {
        [] => Ok(()),
        differences => Err(Failure::run(format!(
            "`{}` holds results of another run: {}. Write the trace elsewhere with --out",
            folder.display(),
            differences.join("; ")
        ))),
    }
}

/// Runs one episode and prints its rows.
fn run_one(
    args: &Args,
    experiment: &Experiment,
    (point, episode): (u32, u64),
    traces: Option<&Path>,
    runs: &mut Vec<Json>,
) -> Result<(), Failure> {
    let answers = experiment.run_block(&mut Worker::default(), point, episode, traces).map_err(Failure::run)?;
    if args.format == Shape::Json {
        let rows: Vec<Json> =
            answers.iter().map(|answer| results::row_json(&answer.row, experiment.swept()).into()).collect();
        runs.push(json!({ "scenario": experiment.scenario().name.as_str(), "rows": rows }));
    } else {
        let header = results::header_line(experiment.swept());
        let mut table = csv::WriterBuilder::new().has_headers(false).from_writer(header);
        for Answer { row, .. } in &answers {
            results::write_row(&mut table, row).map_err(Failure::run)?;
        }
        print(&String::from_utf8_lossy(&table.into_inner().map_err(Failure::run)?))?;
    }
    match answers.iter().find(|answer| answer.row.outcome.is_crash()) {
        Some(Answer { row, .. }) => Err(Failure::Run(format!(
            "error: {} ended in `{}`: {}",
            row.stack,
            row.outcome.name(),
            row.outcome.message()
        ))),
        None => {
            let summary = answers.iter().filter_map(|answer| results::summarise_rows(std::iter::once(&answer.row)));
            check_required(args, &summary.collect::<Vec<SummaryRow>>())
        }
    }
}

/// Runs every episode that is not in the folder yet.
fn run_all(
    args: &Args,
    experiment: &Experiment,
    folder: &Path,
    traces: Option<&Path>,
    isolation: Option<&Isolation<'_>>,
    runs: &mut Vec<Json>,
) -> Result<(), Failure> {
    let session = args.waiting.open(experiment, folder, existing(args.force))?;
    if let Some(traces) = traces {
        create(traces)?;
    }
    let shown = folder.display().to_string();
    match session.opened() {
        Opened::Fresh => {}
        Opened::Resume { blocks_done } => {
            say(&format!("{shown}: going on after {blocks_done} of {}", counted(session.order().blocks(), "world")));
        }
        Opened::Complete => say(&format!("{shown}: complete, nothing to run (--force runs it again)")),
    }
    let summary = complete(session, args.threads, traces, isolation, args.quiet)?;
    if args.format == Shape::Json {
        let rows: Vec<Json> = summary.iter().map(|row| results::summary_json(row).into()).collect();
        runs.push(json!({ "scenario": experiment.scenario().name.as_str(), "folder": shown, "summary": rows }));
    } else if let Some(format) = args.format.of_paper() {
        print(&(command_comment(format) + &comparison::table(&results::summary_rows(&summary), 1, format)))?;
    } else if !args.quiet {
        print(&format!(
            "{}\n{shown}/episodes.csv, states.csv, summary.csv, timings.csv, manifest.json\n",
            results::table(&summary, width())
        ))?;
    }
    let given_up: u64 = summary.iter().map(|row| row.count("gave_up")).sum();
    if given_up > 0 {
        say(&format!("{shown}: {} given up; the same command drives them again", counted(given_up, "drive")));
    }
    judge(args, experiment, folder, &summary)
}

/// Checks that nothing crashed and that the results are what the caller requires.
fn judge(args: &Args, experiment: &Experiment, folder: &Path, summary: &[SummaryRow]) -> Result<(), Failure> {
    let crashed = CRASHES.iter().map(|outcome| summary.iter().map(|row| row.count(outcome)).sum::<u64>()).sum::<u64>();
    if crashed > 0 {
        let first = first_crash(folder).map_err(Failure::run)?;
        let shown = first.map_or_else(String::new, |row| {
            let command = experiment.replay_command(row.point, row.episode, &row.stack);
            format!(", the first: {}: {}\nhelp: {command}", row.outcome.name(), said(&row))
        });
        return Err(Failure::Run(format!("error: {} crashed{shown}", counted(crashed, "episode"))));
    }
    check_required(args, summary)
}

/// Checks the success rates against those that are required.
fn check_required(args: &Args, summary: &[SummaryRow]) -> Result<(), Failure> {
    let Some(required) = args.require_success else { return Ok(()) };
    let missed: Vec<String> = summary
        .iter()
        .filter_map(|row| {
            let (rate, low) = row.success.map_or((0.0, 0.0), |success| (success.rate, success.low));
            let said = format!("{} succeeds in {:.1} %", row.stack, 100.0 * rate);
            if args.require_interval {
                (low < required).then(|| format!("{said}, surely in {:.1} %", 100.0 * low))
            } else {
                (rate < required).then_some(said)
            }
        })
        .collect();
    if missed.is_empty() {
        Ok(())
    } else {
        Err(Failure::Requirement(format!("error: {:.1} % is required, but {}", 100.0 * required, missed.join(", "))))
    }
}

/// The outcomes that are no result of a drive.
const CRASHES: [&str; 2] = ["planner_error", "internal_error"];

/// The first row that is no result of a drive.
fn first_crash(folder: &Path) -> Result<Option<Row>, ResultsError> {
    let path = folder.join(results::EPISODES_CSV);
    let mut rows = results::Reader::open(&path)?;
    let crash = rows.find(|row| row.as_ref().is_ok_and(|row| row.outcome.is_crash()));
    crash.transpose().map_err(|source| ResultsError::Read { path, source })
}

/// What a row says went wrong, without the command that stands on a line of its own.
fn said(row: &Row) -> &str {
    row.outcome.message().split("; replay: ").next().unwrap_or_default()
}

/// Treatment of results that are in the folder already.
pub(super) fn existing(force: bool) -> Existing {
    if force { Existing::Replace } else { Existing::Continue }
}

/// The failure behind an error of opening a folder: a swept key that cannot be a column is a fault of the scenario.
pub(super) fn refused(error: ResultsError) -> Failure {
    match error {
        ResultsError::SweptKey(_) => Failure::usage(error),
        ResultsError::Locked { .. } => Failure::Busy(format!("error: {error}")),
        _ => Failure::run(error),
    }
}

/// Drives the missing blocks of a session, with a progress bar unless `quiet`; on every processor unless `threads` is given, in child
/// processes if `isolation` says how.
///
/// A signal ends it after the worlds in hand; what is there by then is shown unless `quiet`.
pub(super) fn complete(
    session: Session<'_>,
    threads: Option<usize>,
    traces: Option<&Path>,
    isolation: Option<&Isolation<'_>>,
    quiet: bool,
) -> Result<Vec<SummaryRow>, Failure> {
    let interrupt = Interrupt::listen()?;
    let bar = progress_bar(quiet, session.order().blocks(), session.blocks_done());
    interrupt.beside(&bar);
    let stop = || {
        if interrupt.code().is_some() {
            session.stop();
        }
    };
    stop();
    let threads = threads.unwrap_or_else(threads_available).max(1);
    let after = || {
        bar.inc(1);
        stop();
    };
    let result = match isolation {
        Some(isolation) => session.run_isolated(threads, isolation, after),
        None => session.run(threads, traces, after),
    };
    bar.finish_and_clear();
    result.map_err(Failure::run)?;
    let (folder, done, all) = (session.folder().to_owned(), session.blocks_done(), session.order().blocks());
    if let Some(traces) = traces.filter(|_| done == all) {
        let untraced = session.untraced(traces).map_err(Failure::run)?;
        if !untraced.is_empty() {
            let episodes = counted(untraced.len() as u64, "world");
            say(&format!("{}: driving {episodes} again for their traces", traces.display()));
        }
        let bar = progress_bar(quiet, untraced.len() as u64, 0);
        interrupt.beside(&bar);
        let result = session.trace(threads, &untraced, traces, || {
            bar.inc(1);
            stop();
        });
        bar.finish_and_clear();
        result.map_err(Failure::run)?;
        if let Some(code) = interrupt.code().filter(|_| !untraced.is_empty()) {
            return Err(Interrupt::failure(code, &format!("some traces are missing in {}", traces.display())));
        }
    }
    if let Some(summary) = session.finish().map_err(Failure::run)? {
        return Ok(summary);
    }
    if !quiet {
        print(&results::table(&so_far(&folder)?, width()))?;
    }
    let kept = format!("{done} of {} are kept in {}", counted(all, "world"), folder.display());
    Err(Interrupt::failure(interrupt.code().unwrap_or(1), &kept))
}

/// The summary of the rows that are in a folder.
fn so_far(folder: &Path) -> Result<Vec<SummaryRow>, Failure> {
    let file = folder.join(results::EPISODES_CSV);
    let opened = files::open(&file, u64::MAX).map_err(Failure::run)?;
    results::summarise(BufReader::new(opened), 0)
        .map_err(|error| Failure::Run(format!("error: {}: {error}", file.display())))
}

fn progress_bar(quiet: bool, blocks: u64, done: u64) -> ProgressBar {
    let bar = ProgressBar::new(blocks);
    if quiet {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    }
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} worlds, {elapsed} elapsed, {eta} to go") {
        bar.set_style(style);
    }
    bar.set_position(done);
    bar.reset_eta();
    bar
}
