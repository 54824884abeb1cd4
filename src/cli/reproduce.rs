//! `simrun reproduce`: a paper's tables, run and judged.

use super::run::{QuietPanics, progress_bar};
use super::{Failure, colour, print, say};
use crate::comparison;
use crate::experiment::Experiment;
use crate::paper::{self, Evidence, Paper, Ruling};
use crate::results::{EPISODES_CSV, Existing, Folder};
use crate::scenario::ScenarioError;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Short name of the paper, such as gao2025.
    #[arg(value_name = "PAPER")]
    paper: String,
    /// At most this many episodes of each table: a short form.
    #[arg(long, value_name = "N")]
    episodes: Option<u32>,
    /// Folder of the papers.
    #[arg(long, value_name = "FOLDER", default_value = "scenarios/papers")]
    papers: PathBuf,
    /// Folder of the results; results/reproduce/PAPER by default. What is there already is not run again.
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Throw away other results in that folder.
    #[arg(long)]
    force: bool,
    /// Threads; as many as there are processors by default. Results do not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// No progress bar and no summary.
    #[arg(short, long)]
    quiet: bool,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    let paper =
        Paper::read(&args.papers, &args.paper).map_err(|message| Failure::Usage(format!("error: {message}")))?;
    let out = args.out.clone().unwrap_or_else(|| Path::new("results/reproduce").join(&paper.name));
    // All tables are checked before the first one runs.
    let experiments = paper.manifest.tables.iter().map(|table| Ok((table, load(&paper, table, args.episodes)?)));
    let experiments = experiments.collect::<Result<Vec<_>, Failure>>()?;

    let mut evidence = Evidence::default();
    for (table, experiment) in &experiments {
        if !args.quiet {
            say(&format!("{}: {}", table.id, table.title));
        }
        let folder = out.join(table.id.as_str());
        run(args, experiment, &folder)?;
        let sections = comparison::read_sections(&folder.join(EPISODES_CSV)).map_err(Failure::Run)?;
        evidence.add(table.id.as_str(), experiment, sections);
    }
    let report = out.join("report.md");
    for (name, text) in [
        ("report.md", paper::report(&paper, &evidence)),
        ("numbers.csv", paper::published_csv(&paper, &evidence)),
        ("verdicts.csv", paper::verdicts_csv(&paper, &evidence)),
    ] {
        let path = out.join(name);
        std::fs::write(&path, text)
            .map_err(|error| Failure::Run(format!("error: cannot write `{}`: {error}", path.display())))?;
    }
    if !args.quiet {
        print(&summary(&paper, &evidence))?;
        print(&format!("\n{}\n", report.display()))?;
    }
    let broken: usize = evidence.tables.values().map(|table| table.bounds.broken.len()).sum();
    if broken == 0 {
        Ok(())
    } else {
        Err(Failure::Run(format!("error: {broken} bounds are broken, see {}", report.display())))
    }
}

fn load(paper: &Paper, table: &paper::manifest::Table, episodes: Option<u32>) -> Result<Experiment, Failure> {
    let refuse = |error: ScenarioError| Failure::Usage(format!("table {}: {}", table.id, error.render(colour())));
    let (file, edits) = paper.scenario(table, episodes).map_err(refuse)?;
    let scenario = file.read(&edits).map_err(refuse)?;
    let points = file.points(&scenario, &edits).map_err(refuse)?;
    let mut experiment =
        Experiment::new(scenario, points, file.folder()).map_err(|error| Failure::Usage(format!("error: {error}")))?;
    if !table.stacks.is_empty() {
        let known = experiment.stack_names();
        experiment.keep_stacks(&table.stacks).map_err(|unknown| {
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            misfit(table, &crate::settings::choice::unknown_name("stack", unknown, &known))
        })?;
    }
    let stacks = experiment.stack_names();
    let stacks: Vec<&str> = stacks.iter().map(String::as_str).collect();
    paper.check_stacks(table.id.as_str(), &stacks).map_err(|message| misfit(table, &message))?;
    Ok(experiment)
}

fn misfit(table: &paper::manifest::Table, message: &str) -> Failure {
    Failure::Usage(format!("error: table `{}`: {message}", table.id))
}

fn run(args: &Args, experiment: &Experiment, folder: &Path) -> Result<(), Failure> {
    let existing = if args.force { Existing::Replace } else { Existing::Continue };
    let identity = experiment.identity().map_err(Failure::run)?;
    let order = experiment.order().map_err(|error| Failure::Usage(format!("error: {error}")))?;
    let folder = Folder::open(folder, identity, order, existing).map_err(Failure::run)?;
    let bar = progress_bar(args.quiet, folder.order().blocks(), folder.blocks_done());
    let threads = args.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from)).max(1);
    let quiet_panics = QuietPanics::install();
    let result = experiment.run(&folder, threads, None, || bar.inc(1));
    drop(quiet_panics);
    bar.finish_and_clear();
    result.map_err(Failure::run)?;
    folder.finish().map(|_| ()).map_err(Failure::run)
}

/// The verdicts in short.
fn summary(paper: &Paper, evidence: &Evidence) -> String {
    let claims = paper.manifest.claims.iter();
    let lines = claims.map(|claim| {
        let verdict = paper::judge(&claim.test, evidence, &paper.published);
        let mark = match verdict.ruling {
            Ruling::Holds => "holds",
            Ruling::Fails => "does not hold",
            Ruling::Undecided => "undecided",
            Ruling::Untestable => "cannot be tested",
        };
        format!("{:<18} {mark:<17} {}\n", claim.id, claim.says)
    });
    lines.collect()
}
