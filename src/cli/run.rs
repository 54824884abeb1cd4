//! `simrun run`: scenarios become tables.

use super::scenarios::{AtPoint, Changes};
use super::{Failure, print, say};
use crate::episode::Outcome;
use crate::experiment::{Experiment, Worker};
use crate::results::{self, Existing, Folder, Opened, SummaryRow};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scenario files; each writes a folder of its own.
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
    /// Fail (exit code 3) unless every stack reaches this success rate, from 0 to 1.
    #[arg(long, value_name = "RATE")]
    require_success: Option<f64>,
    /// No progress bar and no table.
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    changes: Changes,
}

impl Args {
    /// The scenario files.
    pub(super) fn scenarios(&self) -> &[PathBuf] {
        &self.scenarios
    }
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    if args.out.is_some() && args.scenarios.len() > 1 {
        return Err(Failure::Usage("error: --out names one folder, for one scenario".to_owned()));
    }
    if args.point.point > 0 && args.episode.is_none() {
        return Err(Failure::Usage("error: --point runs one world: name its --episode as well".to_owned()));
    }
    if args.require_success.is_some_and(|rate| !(0.0..=1.0).contains(&rate)) {
        return Err(Failure::Usage("error: --require-success takes a rate from 0 to 1".to_owned()));
    }
    // All scenarios are checked before the first one runs.
    let experiments =
        args.scenarios.iter().map(|file| args.changes.load(file)).collect::<Result<Vec<Experiment>, Failure>>()?;
    for (index, experiment) in experiments.iter().enumerate() {
        let name = &experiment.scenario().name;
        if experiments[..index].iter().any(|other| other.scenario().name == *name) {
            return Err(Failure::Usage(format!(
                "error: two scenarios are called `{name}` and would write the same folder"
            )));
        }
    }
    experiments.iter().try_for_each(|experiment| run(args, experiment))
}

fn run(args: &Args, experiment: &Experiment) -> Result<(), Failure> {
    let folder = args.out.clone().unwrap_or_else(|| Path::new("results").join(experiment.scenario().name.as_str()));
    let traces = args.trace.then(|| folder.join("traces"));
    if let Some(traces) = &traces {
        std::fs::create_dir_all(traces)
            .map_err(|error| Failure::Run(format!("error: cannot create `{}`: {error}", traces.display())))?;
    }
    match args.episode {
        Some(episode) => run_one(experiment, args.point.of(experiment)?, episode, traces.as_deref()),
        None => run_all(args, experiment, &folder, traces.as_deref()),
    }
}

/// Runs one episode and prints its rows.
fn run_one(experiment: &Experiment, point: u32, episode: u64, traces: Option<&Path>) -> Result<(), Failure> {
    let rows = experiment.run_block(&mut Worker::default(), point, episode, traces).map_err(Failure::run)?;
    let header = results::header_line(&experiment.scenario().sweep.keys());
    let mut table = csv::WriterBuilder::new().has_headers(false).from_writer(header);
    for (row, _) in &rows {
        results::write_row(&mut table, row).map_err(Failure::run)?;
    }
    print(&String::from_utf8_lossy(&table.into_inner().map_err(Failure::run)?))?;
    match rows.iter().find(|(row, _)| matches!(row.outcome, Outcome::PlannerError { .. })) {
        Some((row, _)) => Err(Failure::Run(format!("error: {} crashed: {}", row.stack, row.outcome.message()))),
        None => Ok(()),
    }
}

/// Runs every episode that is not in the folder yet.
fn run_all(args: &Args, experiment: &Experiment, folder: &Path, traces: Option<&Path>) -> Result<(), Failure> {
    let existing = if args.force { Existing::Replace } else { Existing::Continue };
    let identity = experiment.identity().map_err(Failure::run)?;
    let order = experiment.order().map_err(|error| Failure::Usage(format!("error: {error}")))?;
    let folder = Folder::open(folder, identity, order, existing).map_err(Failure::run)?;
    let shown = folder.path().display().to_string();
    match folder.opened() {
        Opened::Fresh => {}
        Opened::Resume { blocks_done } => {
            say(&format!("{shown}: going on after {blocks_done} of {} episodes", folder.order().blocks()));
        }
        Opened::Complete => say(&format!("{shown}: complete, nothing to run (--force runs it again)")),
    }

    let bar = progress_bar(args.quiet, folder.order().blocks(), folder.blocks_done());
    let threads = args.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from)).max(1);
    let quiet_panics = QuietPanics::install();
    let result = experiment.run(&folder, threads, traces, || bar.inc(1));
    drop(quiet_panics);
    bar.finish_and_clear();
    result.map_err(Failure::run)?;
    let summary = folder.finish().map_err(Failure::run)?.unwrap_or_default();
    if !args.quiet {
        print(&format!(
            "{}\n{shown}/episodes.csv, summary.csv, timings.csv, manifest.json\n",
            results::table(&summary)
        ))?;
    }
    judge(args, &summary)
}

/// Whether what came out is what the caller asked for.
fn judge(args: &Args, summary: &[SummaryRow]) -> Result<(), Failure> {
    if let Some(row) = summary.iter().find(|row| row.count("planner_error") > 0) {
        let count = row.count("planner_error");
        return Err(Failure::Run(format!(
            "error: {} crashed in {count} episodes: see the column `message`",
            row.stack
        )));
    }
    let Some(required) = args.require_success else { return Ok(()) };
    let missed: Vec<String> = summary
        .iter()
        .filter_map(|row| {
            let rate = row.success.map_or(0.0, |success| success.rate);
            (rate < required).then(|| format!("{} succeeds in {:.1} %", row.stack, 100.0 * rate))
        })
        .collect();
    if missed.is_empty() {
        Ok(())
    } else {
        Err(Failure::Requirement(format!("error: {:.1} % is required, but {}", 100.0 * required, missed.join(", "))))
    }
}

pub(super) fn progress_bar(quiet: bool, blocks: u64, done: u64) -> ProgressBar {
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

/// While it lives, a planner's panic is a row of the results and not a message on the terminal.
pub(super) struct QuietPanics;

impl QuietPanics {
    pub(super) fn install() -> Self {
        std::panic::set_hook(Box::new(|_| {}));
        Self
    }
}

impl Drop for QuietPanics {
    fn drop(&mut self) {
        let _ = std::panic::take_hook();
    }
}
