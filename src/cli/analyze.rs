//! `simrun analyze`: result files become comparisons.

use super::json::{self, Object};
use super::{Failure, Out, command_comment, say};
use crate::comparison::{self, Baseline, Format, Gate, Margins, Pairing, Section, Table};
use crate::settings::quantity::counted;
use serde_json::{Value as Json, json};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("mode").args(["baseline", "compare_points"]))]
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
    /// Test whether two stacks are equivalent up to a margin, in its unit (success in percentage points) or in per cent of the reference's mean, for
    /// example --equivalent time_s=2% (repeatable).
    #[arg(long, value_name = "METRIC=VALUE", conflicts_with_all = ["unpaired", "baseline", "compare_points"])]
    equivalent: Vec<String>,
    /// Compare the points of a sweep with each other instead: a ranking by success, then time, and tests of each against the best.
    #[arg(long, conflicts_with_all = ["reference", "all_pairs", "unpaired", "baseline"])]
    compare_points: bool,
    /// Compare with an older run of the same scenario instead: rows that moved, tests of each stack; exit code 3 if it got worse.
    #[arg(long, value_name = "EPISODES_CSV", conflicts_with_all = ["reference", "all_pairs", "unpaired"])]
    baseline: Option<PathBuf>,
    /// Metrics, joined by commas. With --baseline: those that may make the run worse, all by default. With --compare-points: those
    /// that are tested, success and time_s by default.
    #[arg(long, value_name = "METRICS", value_delimiter = ',', requires = "mode")]
    metrics: Vec<String>,
    /// With --baseline: how much a metric may get worse, in its unit or in per cent of the baseline's mean, for example
    /// --margin time_s=5% (repeatable). Without one: 0.1 %, success 0.
    #[arg(long, value_name = "METRIC=VALUE", requires = "baseline")]
    margin: Vec<String>,
    /// How to print it; csv holds the tests alone (summary.csv has the stacks), with --compare-points the ranking with its tests; json holds all of it,
    /// numbers unrounded.
    #[arg(long, value_enum, default_value_t = Shape::Text)]
    format: Shape,
    #[command(flatten)]
    out: Out,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Shape {
    Text,
    Markdown,
    /// Tables of LaTeX; they need the package booktabs.
    Latex,
    Csv,
    Json,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    match args.format {
        Shape::Text => analyze(args, Some(Format::Text), &mut Object::new()),
        Shape::Markdown => analyze(args, Some(Format::Markdown), &mut Object::new()),
        Shape::Latex => analyze(args, Some(Format::Latex), &mut Object::new()),
        Shape::Csv => analyze(args, Some(Format::Csv), &mut Object::new()),
        Shape::Json => json::answer("analyze", &args.out, |document| analyze(args, None, document)),
    }
}

/// Compares, and writes it in a format; without one into the document.
fn analyze(args: &Args, format: Option<Format>, document: &mut Object) -> Result<(), Failure> {
    let read = |file: &PathBuf| {
        let table = comparison::read_table(file).map_err(Failure::usage)?;
        if table.sections.is_empty() {
            return Err(Failure::usage(format!("`{}` has no rows", table.path.display())));
        }
        if !table.missing.is_empty() {
            let (file, missing) = (table.path.display(), table.missing.join(", "));
            say(&format!("{file}: an older version wrote this table; the columns that it lacks are empty: {missing}"));
        }
        if table.is_altered {
            say(&format!(
                "warning: `{}` has been altered since its run was finished, as its hash in manifest.json says",
                table.path.display()
            ));
        }
        Ok(table)
    };
    let tables = args.files.iter().map(read).collect::<Result<Vec<Table>, Failure>>()?;
    if let Some(old) = &args.baseline {
        if args.files.len() > 1 {
            return Err(Failure::usage("--baseline compares one run with one older run"));
        }
        if !matches!(args.format, Shape::Text | Shape::Json) {
            return Err(Failure::usage("--baseline prints text or json"));
        }
        let gate = Gate::new(&args.metrics, &args.margin).map_err(Failure::usage)?;
        return baseline(&read(old)?, &tables[0], &gate, format.map(|_| &args.out), document);
    }
    if args.compare_points {
        if args.files.len() > 1 && format == Some(Format::Csv) {
            return Err(Failure::usage(
                "--compare-points --format csv takes one table: each sweep has columns of its own",
            ));
        }
        let rankings = tables.iter().map(|table| comparison::rank_points(table, &args.metrics));
        let rankings = rankings.collect::<Result<Vec<_>, _>>().map_err(Failure::usage)?;
        let Some(format) = format else {
            let rankings: Vec<Json> = rankings.iter().map(comparison::points_json).collect();
            document.insert("rankings".to_owned(), rankings.into());
            return Ok(());
        };
        let texts = rankings.iter().map(|ranking| comparison::render_points(ranking, format, args.out.width()));
        return args.out.write(&(command_comment(format) + &texts.collect::<String>()));
    }
    let sections = tables.into_iter().flat_map(|table| table.sections).collect::<Vec<Section>>();
    let pairing = Pairing {
        reference: args.reference.clone(),
        all_pairs: args.all_pairs,
        unpaired: args.unpaired,
        equivalent: Margins::of_equivalence(&args.equivalent).map_err(Failure::usage)?,
    };
    let reports = sections.iter().map(|section| comparison::analyse(section, &pairing));
    let reports = reports.collect::<Result<Vec<_>, _>>().map_err(Failure::usage)?;
    if sections.len() > 1 && reports.iter().all(|report| report.comparisons.is_empty()) {
        say("no point has two stacks to compare; --compare-points compares the points");
    }
    let Some(format) = format else {
        let sections: Vec<Json> = reports.iter().map(comparison::report_json).collect();
        document.insert("sections".to_owned(), sections.into());
        return Ok(());
    };
    args.out.write(&(command_comment(format) + &comparison::render(&reports, format, args.out.width())))
}

/// Rows that moved, named one by one.
const MOVED_SHOWN: usize = 20;

/// Settings that differ from the baseline's, named one by one.
const SETTINGS_SHOWN: usize = 6;

/// Compares with an older run, and writes it to `out`; without one into the document.
fn baseline(old: &Table, new: &Table, gate: &Gate, out: Option<&Out>, document: &mut Object) -> Result<(), Failure> {
    let found = comparison::compare_baseline(&old.sections, &new.sections, gate).map_err(Failure::usage)?;
    match out {
        Some(out) => out.write(&baseline_text(old, new, &found, out.width()))?,
        None => document.extend(baseline_json(old, new, &found)),
    }
    if found.regressions.is_empty() {
        return Ok(());
    }
    Err(Failure::Requirement(format!("error: worse than the baseline: {}", found.regressions.join("; "))))
}

fn baseline_json(old: &Table, new: &Table, found: &Baseline) -> Object {
    let moved =
        found.moved.iter().map(|(point, stack, episode)| json!({ "point": point, "stack": stack, "episode": episode }));
    let version = |table: &Table| table.identity.as_ref().map(|identity| identity.version.clone());
    let found = [
        ("regressions", json!(found.regressions)),
        ("baseline_version", json!(version(old))),
        ("version", json!(version(new))),
        ("settings_that_differ", json!(new.settings_that_differ(old))),
        ("rows", json!(found.rows)),
        ("missing", json!(found.missing)),
        ("new", json!(found.added)),
        ("other_worlds", json!(found.other_worlds)),
        ("moved", moved.collect()),
        ("tests", comparison::tests_json(&found.comparisons, &[]).into()),
    ];
    found.map(|(key, value)| (key.to_owned(), value)).into_iter().collect()
}

fn baseline_text(old: &Table, new: &Table, found: &Baseline, width: usize) -> String {
    let mut text = match found.regressions.as_slice() {
        [] => "No worse than the baseline.\n".to_owned(),
        regressions => format!("Worse than the baseline: {}\n", regressions.join("; ")),
    };
    if let (Some(before), Some(now)) = (&old.identity, &new.identity)
        && before.version != now.version
    {
        let (before, now) = (&before.version, &now.version);
        text += &format!(
            "The baseline was written by simrun {before}, this run by {now}: defaults may have moved (see the changelog).\n"
        );
    }
    let differ = new.settings_that_differ(old);
    if !differ.is_empty() {
        text += "The scenario is not that of the baseline (there: the baseline, here: this run):\n";
        for difference in differ.iter().take(SETTINGS_SHOWN) {
            text += &format!("  {difference}\n");
        }
        if differ.len() > SETTINGS_SHOWN {
            text += &format!("  … and {} more\n", differ.len() - SETTINGS_SHOWN);
        }
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
        text += &comparison::comparison_table(&found.comparisons, Format::Text, width);
    }
    text
}
