//! `simrun reproduce`: a paper's tables, run and judged.

use super::isolated::Isolate;
use super::memory::MemoryLimit;
use super::run::{Waiting, complete, existing};
use super::scenarios::prepare;
use super::{Failure, print, say, width};
use crate::comparison::{self, Section};
use crate::experiment::Experiment;
use crate::files;
use crate::paper::manifest::{Choice, Table};
use crate::paper::{self, Evidence, Finding, Findings, Paper, Ruling};
use crate::results::EPISODES_CSV;
use crate::results::layout::hanging;
use crate::settings::quantity::counted;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Short name of the paper, such as gao2025, or `all` for every paper, one after the other.
    #[arg(value_name = "PAPER")]
    paper: String,
    /// Run every table and every choice that the paper leaves open; without it the paper's own tables and counts.
    #[arg(long)]
    full: bool,
    /// The paper's own tables and counts, as without `--full`.
    #[arg(long, conflicts_with = "full")]
    short: bool,
    /// At most this many episodes of each table: a short form.
    #[arg(long, value_name = "N")]
    episodes: Option<u32>,
    /// Folder of the papers.
    #[arg(long, value_name = "FOLDER", default_value = "scenarios/papers")]
    papers: PathBuf,
    /// Folder of the results; results/reproduce/PAPER by default, for all papers results/reproduce with a folder for each. What is there
    /// already is not run again.
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
    #[command(flatten)]
    waiting: Waiting,
}

/// The name that stands for every paper.
const ALL: &str = "all";

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    let read = |name: &str| Paper::read(&args.papers, name).map_err(Failure::usage);
    let base = Path::new("results/reproduce");
    if args.paper != ALL {
        let paper = read(&args.paper)?;
        let out = args.out.clone().unwrap_or_else(|| base.join(&paper.name));
        return judge(args, &paper, &experiments(args, &paper)?, &out)?.check();
    }
    let out = args.out.as_deref().unwrap_or(base);
    let names = Paper::names(&args.papers).map_err(Failure::usage)?;
    let papers = names.iter().map(|name| read(name)).collect::<Result<Vec<_>, _>>()?;
    // All papers are checked before the first one runs.
    let checked = papers.iter().map(|paper| Ok((paper, experiments(args, paper)?)));
    let checked = checked.collect::<Result<Vec<_>, Failure>>()?;
    let mut judged = Vec::new();
    for (paper, runs) in &checked {
        if !args.quiet {
            say(&format!("\n{}: {}", paper.name, paper.manifest.title.trim()));
        }
        judged.push(judge(args, paper, runs, &out.join(&paper.name))?);
    }
    let (table, path) = (rulings(&judged), out.join("verdicts.md"));
    write(&path, &table)?;
    if !args.quiet {
        print(&format!("\n{table}\n{}\n", path.display()))?;
    }
    judged.iter().try_for_each(Judged::check)
}

/// What came of a paper.
struct Judged {
    name: String,
    /// Number of claims, then of questions, with each ruling, in the order of [`Ruling::ALL`].
    counts: [[usize; Ruling::ALL.len()]; 2],
    /// Bounds that hold in every world and were broken.
    broken: usize,
    report: PathBuf,
}

impl Judged {
    /// Whether every bound was kept.
    fn check(&self) -> Result<(), Failure> {
        if self.broken == 0 {
            return Ok(());
        }
        let broken = counted(self.broken as u64, "bound");
        Err(Failure::Run(format!("error: {broken} broken, see {}", self.report.display())))
    }
}

/// The rulings on every paper as a table.
fn rulings(judged: &[Judged]) -> String {
    let words = Ruling::ALL.map(Ruling::words).join(" | ");
    let mut table = format!("| paper | | all | {words} |\n|---|---|{}\n", "---|".repeat(1 + Ruling::ALL.len()));
    for Judged { name, counts, .. } in judged {
        for (what, counts) in ["claims", "questions"].into_iter().zip(counts) {
            let all: usize = counts.iter().sum();
            if all > 0 {
                table.push_str(&format!(
                    "| {name} | {what} | {all} | {} |\n",
                    counts.map(|count| count.to_string()).join(" | ")
                ));
            }
        }
    }
    table
}

/// Writes a report, unless the file holds it already. Where only reading is allowed, the report is on the terminal alone.
fn write(path: &Path, text: &str) -> Result<(), Failure> {
    if files::bytes(path, text.len() as u64).is_ok_and(|found| found == text.as_bytes()) {
        return Ok(());
    }
    match std::fs::write(path, text) {
        Err(error) if matches!(error.kind(), ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem) => {
            say(&format!("note: cannot write `{}`: {error}", path.display()));
            Ok(())
        }
        other => other.map_err(|error| Failure::Run(format!("error: cannot write `{}`: {error}", path.display()))),
    }
}

/// The tables of a paper, checked.
fn experiments<'a>(args: &Args, paper: &'a Paper) -> Result<Vec<(Run<'a>, Experiment)>, Failure> {
    // All tables are checked before the first one runs.
    let runs = runs(paper, args.full).into_iter().map(|run| {
        let experiment = load(paper, &run, args.episodes)?;
        Ok((run, experiment))
    });
    runs.collect()
}

/// Runs the tables of a paper, judges its claims and writes the report.
fn judge(args: &Args, paper: &Paper, runs: &[(Run<'_>, Experiment)], out: &Path) -> Result<Judged, Failure> {
    let mut evidence = Evidence::default();
    for (Run { table, choice, .. }, experiment) in runs {
        let name = paper::folder_of(table, *choice);
        if !args.quiet {
            say(&format!("{name}: {}", choice.map_or(&table.title, |choice| &choice.says).trim()));
        }
        let folder = out.join(&name);
        let session = args.waiting.open(experiment, &folder, existing(args.force))?;
        complete(session, args.threads, None, None, args.quiet)?;
        let rows = comparison::read_table(&folder.join(EPISODES_CSV)).map_err(Failure::run)?;
        let (sections, copies): (Vec<_>, Vec<u64>) = rows.sections.iter().map(Section::without_copies).unzip();
        let copies = copies.iter().sum::<u64>();
        if copies > 0 {
            say(&format!(
                "{name}: {} left out: nothing in them is random, they are copies of others",
                counted(copies, "episode")
            ));
        }
        match choice {
            None => evidence.add(table.id.as_str(), experiment, sections),
            Some(choice) => {
                evidence.under.insert((choice.id.to_string(), table.id.to_string()), sections);
            }
        }
    }
    let findings = Findings::new(paper, &evidence);
    let report = out.join("report.md");
    for (name, text) in [
        ("report.md", paper::report(paper, &evidence, &findings)),
        ("numbers.csv", paper::published_csv(paper, &evidence)),
        ("verdicts.csv", paper::verdicts_csv(&findings)),
    ] {
        write(&out.join(name), &text)?;
    }
    if !args.quiet {
        print(&summary(&findings, width()))?;
        print(&format!("\n{}\n", report.display()))?;
    }
    let count = |findings: &[Finding<'_>]| {
        Ruling::ALL.map(|ruling| findings.iter().filter(|finding| finding.ruling() == ruling).count())
    };
    Ok(Judged {
        name: paper.name.clone(),
        counts: [count(&findings.claims), count(&findings.questions)],
        broken: evidence.tables.values().map(|table| table.bounds.broken.len()).sum(),
        report,
    })
}

/// A table that is run, as it is or under a choice.
struct Run<'a> {
    table: &'a Table,
    choice: Option<&'a Choice>,
    /// The stacks that run; empty for all.
    stacks: Vec<String>,
}

/// The tables as they are, then under each choice those that a claim looks at: of a table and its larger form the larger one.
fn runs(paper: &Paper, full: bool) -> Vec<Run<'_>> {
    let tables = || paper.manifest.tables.iter().filter(|table| full || !table.full);
    let mut runs: Vec<Run<'_>> =
        tables().map(|table| Run { table, choice: None, stacks: table.stacks.clone() }).collect();
    for choice in paper.manifest.ablate.iter().filter(|_| full) {
        let concerned =
            |table: &&Table| table.larger.is_none() && choice.tables.iter().any(|id| *id == table.id.as_str());
        for table in tables().filter(concerned) {
            match paper.stacks_used(table.id.as_str()) {
                Some(stacks) if stacks.is_empty() => {}
                Some(stacks) => runs.push(Run { table, choice: Some(choice), stacks }),
                None => runs.push(Run { table, choice: Some(choice), stacks: table.stacks.clone() }),
            }
        }
    }
    runs
}

fn load(paper: &Paper, run: &Run<'_>, episodes: Option<u32>) -> Result<Experiment, Failure> {
    let load = || {
        let (file, edits) = paper.scenario(run.table, run.choice, episodes).map_err(Failure::Scenario)?;
        let file = MemoryLimit::default().set(file, None, &Isolate::default());
        let experiment = prepare(&file, &edits, &run.stacks)?;
        if run.choice.is_none() {
            paper.check_stacks(run.table.id.as_str(), &experiment.stack_names()).map_err(Failure::usage)?;
        }
        Ok(experiment)
    };
    load().map_err(|failure| match failure {
        Failure::Usage(_) | Failure::Scenario(_) => {
            Failure::Usage(format!("table {}: {}", paper::folder_of(run.table, run.choice), failure.message()))
        }
        other => other,
    })
}

/// The verdicts in short.
fn summary(findings: &Findings<'_>, width: usize) -> String {
    let line = |finding: &Finding<'_>| {
        let head = format!("{:<18} {:<17} ", finding.claim.id, finding.words());
        hanging(&head, if width < 80 { 4 } else { 37 }, finding.claim.says.trim(), width)
    };
    let claims: String = findings.claims.iter().map(line).collect();
    let questions: String = findings.questions.iter().map(line).collect();
    match (claims.is_empty(), questions.is_empty()) {
        (_, true) => claims,
        (true, false) => questions,
        (false, false) => format!("Claims of the paper:\n{claims}\nQuestions of ours:\n{questions}"),
    }
}
