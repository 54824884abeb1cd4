//! `simrun analyze`: result files become comparisons.

use super::{Failure, Out, say};
use crate::comparison::{self, Format, Gate, Pairing, Section, Table};
use crate::settings::quantity::counted;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// `episodes.csv` of a run, or its folder; several are analysed one by one, never pooled.
    #[arg(required = true, value_name = "EPISODES_CSV")]
    files: Vec<PathBuf>,
    /// The stack that the others are compared with; the first one by default.
    #[arg(long, value_name = "STACK", conflicts_with = "all_pairs")]
    reference: Option<String>,
    /// Compare every stack with every other.
    #[arg(long)]
    all_pairs: bool,
    /// Fisher's exact test and rank sums of independent samples, as some papers do, instead of tests of pairs.
    #[arg(long)]
    unpaired: bool,
    /// Compare with an older run of the same scenario instead: rows that moved, tests of each stack; exit code 3 if it got worse.
    #[arg(long, value_name = "EPISODES_CSV", conflicts_with_all = ["reference", "all_pairs", "unpaired"])]
    baseline: Option<PathBuf>,
    /// With --baseline: the metrics that may make the run worse, joined by commas; all by default.
    #[arg(long, value_name = "METRICS", value_delimiter = ',', requires = "baseline")]
    metrics: Vec<String>,
    /// With --baseline: how much a metric may get worse, in its unit or in per cent of the baseline's mean, for example
    /// --margin time_s=5% (repeatable).
    #[arg(long, value_name = "METRIC=VALUE", requires = "baseline")]
    margin: Vec<String>,
    /// How to print it; csv holds the tests alone (summary.csv has the stacks).
    #[arg(long, value_enum, default_value_t = Shape::Text)]
    format: Shape,
    #[command(flatten)]
    out: Out,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Shape {
    Text,
    Markdown,
    Csv,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    let read = |file: &PathBuf| {
        let table = comparison::read_table(file).map_err(Failure::usage)?;
        if !table.missing.is_empty() {
            let (file, missing) = (table.path.display(), table.missing.join(", "));
            say(&format!("{file}: an older version wrote this table; the columns that it lacks are empty: {missing}"));
        }
        Ok(table)
    };
    let tables = args.files.iter().map(read).collect::<Result<Vec<Table>, Failure>>()?;
    if let Some(old) = &args.baseline {
        if args.files.len() > 1 {
            return Err(Failure::usage("--baseline compares one run with one older run"));
        }
        let gate = Gate::new(&args.metrics, &args.margin).map_err(Failure::usage)?;
        return baseline(&read(old)?, &tables[0], &gate, &args.out);
    }
    let sections = tables.into_iter().flat_map(|table| table.sections).collect::<Vec<Section>>();
    let pairing = Pairing { reference: args.reference.clone(), all_pairs: args.all_pairs, unpaired: args.unpaired };
    let reports = sections.iter().map(|section| comparison::analyse(section, &pairing));
    let reports = reports.collect::<Result<Vec<_>, _>>().map_err(Failure::usage)?;
    let format = match args.format {
        Shape::Text => Format::Text,
        Shape::Markdown => Format::Markdown,
        Shape::Csv => Format::Csv,
    };
    args.out.write(&comparison::render(&reports, format))
}

/// Rows that moved, named one by one.
const MOVED_SHOWN: usize = 20;

fn baseline(old: &Table, new: &Table, gate: &Gate, out: &Out) -> Result<(), Failure> {
    let found = comparison::compare_baseline(&old.sections, &new.sections, gate).map_err(Failure::usage)?;
    let mut text = match found.regressions.as_slice() {
        [] => "No worse than the baseline.\n".to_owned(),
        regressions => format!("Worse than the baseline: {}\n", regressions.join("; ")),
    };
    if let (Some(before), Some(now)) = (&old.version, &new.version)
        && before != now
    {
        text += &format!(
            "The baseline was written by simrun {before}, this run by {now}: defaults may have moved (see the changelog).\n"
        );
    }
    text += &format!(
        "{} in both, {} moved, {} missing, {} new\n",
        counted(found.rows, "row"),
        found.moved.len(),
        found.missing,
        found.added
    );
    if found.other_worlds > 0 {
        text += &format!("  {} of them in worlds that differ: these are not compared\n", found.other_worlds);
    }
    for (point, stack, episode) in found.moved.iter().take(MOVED_SHOWN) {
        text += &format!("  moved: point {point}, {stack}, episode {episode}\n");
    }
    if found.moved.len() > MOVED_SHOWN {
        text += &format!("  … and {} more\n", found.moved.len() - MOVED_SHOWN);
    }
    if !found.comparisons.is_empty() {
        text += "\nNew against old, on the same worlds:\n";
        text += &comparison::comparison_table(&found.comparisons);
    }
    out.write(&text)?;
    if found.regressions.is_empty() {
        return Ok(());
    }
    Err(Failure::Requirement(format!("error: worse than the baseline: {}", found.regressions.join("; "))))
}
