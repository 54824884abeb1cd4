//! `simrun reproduce`: a paper's tables, run and judged.

use super::run::{complete, existing, refused};
use super::scenarios::prepare;
use super::{Failure, colour, print, say};
use crate::comparison::{self, Section};
use crate::experiment::{Experiment, Session};
use crate::paper::{self, Evidence, Paper};
use crate::results::EPISODES_CSV;
use crate::scenario::ScenarioError;
use crate::settings::quantity::counted;
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
    let paper = Paper::read(&args.papers, &args.paper).map_err(Failure::usage)?;
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
        let session = Session::open(experiment, &folder, existing(args.force)).map_err(refused)?;
        complete(session, args.threads, None, args.quiet)?;
        let rows = comparison::read_table(&folder.join(EPISODES_CSV)).map_err(Failure::run)?;
        let (sections, copies): (Vec<_>, Vec<u64>) = rows.sections.iter().map(Section::without_copies).unzip();
        let copies = copies.iter().sum::<u64>();
        if copies > 0 {
            say(&format!(
                "{}: {} left out: nothing in them is random, they are copies of others",
                table.id,
                counted(copies, "episode")
            ));
        }
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
        Err(Failure::Run(format!("error: {} broken, see {}", counted(broken as u64, "bound"), report.display())))
    }
}

fn load(paper: &Paper, table: &paper::manifest::Table, episodes: Option<u32>) -> Result<Experiment, Failure> {
    let refuse = |error: ScenarioError| Failure::Usage(error.render(colour()));
    let load = || {
        let (file, edits) = paper.scenario(table, episodes).map_err(refuse)?;
        let experiment = prepare(&file, &edits, &table.stacks)?;
        paper.check_stacks(table.id.as_str(), &experiment.stack_names()).map_err(Failure::usage)?;
        Ok(experiment)
    };
    load().map_err(|failure| match failure {
        Failure::Usage(message) => Failure::Usage(format!("table {}: {message}", table.id)),
        other => other,
    })
}

/// The verdicts in short.
fn summary(paper: &Paper, evidence: &Evidence) -> String {
    let claims = paper.manifest.claims.iter();
    let lines = claims.map(|claim| {
        let verdict = paper::judge(&claim.test, evidence, &paper.published);
        format!("{:<18} {:<17} {}\n", claim.id, verdict.ruling.words(), claim.says)
    });
    lines.collect()
}
