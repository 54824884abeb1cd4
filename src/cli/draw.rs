//! `simrun draw`: one episode as a picture.

use super::scenarios::{AtPoint, Changes};
use super::traced::Traced;
use super::{Failure, print, say};
use crate::episode::Outcome;
use crate::report::{self, Caption};
use crate::results::Row;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scenario file; folder of results, one of whose episodes is driven again as it was; or a trace, whose drive is driven again.
    #[arg(value_name = "SCENARIO")]
    scenario: PathBuf,
    /// Which episode; the first stack of the scenario drives unless --stack names one.
    #[arg(long, default_value_t = 0)]
    episode: u64,
    /// Where to write; `-` for stdout.
    #[arg(short, long, alias = "output", value_name = "FILE", default_value = "episode.svg")]
    out: PathBuf,
    #[command(flatten)]
    point: AtPoint,
    #[command(flatten)]
    changes: Changes,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    check_ending(&args.out)?;
    let traced = Traced::of(&args.scenario)?;
    let (experiment, point, episode) = match &traced {
        Some(_) if args.changes != Changes::default() => {
            return Err(Failure::usage("a trace is drawn as it was driven: nothing of it can be changed"));
        }
        Some(traced) => traced.load()?,
        None => {
            let experiment = args.changes.load(&args.scenario)?;
            let point = args.point.driven(&experiment)?;
            (experiment, point, args.episode)
        }
    };
    let stack = experiment.stacks(point).next().map_or("", |stack| stack.name.as_str());
    let drive = experiment.drive_one(point, episode, 0).map_err(Failure::run)?;
    if let Some(traced) = &traced {
        traced.check(&experiment, &drive.row)?;
    }
    let svg = report::draw(
        &drive.recording,
        &Caption {
            title: format!(
                "{}: {}, episode {}, seed {}",
                experiment.scenario().name,
                stack,
                episode,
                experiment.scenario().seed
            ),
            subtitle: sentence(&drive.row),
        },
    );
    if args.out.as_os_str() == "-" {
        return print(&svg);
    }
    std::fs::write(&args.out, svg)
        .map_err(|error| Failure::Run(format!("error: cannot write {}: {error}", args.out.display())))?;
    say(&format!("{}: {}", args.out.display(), sentence(&drive.row)));
    Ok(())
}

/// Refuses a file whose name promises another format than is written.
fn check_ending(file: &Path) -> Result<(), Failure> {
    const WRITTEN: [&str; 1] = ["svg"];
    let Some(ending) = file.extension().map(|ending| ending.to_string_lossy().to_lowercase()) else { return Ok(()) };
    if file.as_os_str() == "-" || WRITTEN.contains(&ending.as_str()) {
        return Ok(());
    }
    let written = WRITTEN.map(|ending| format!(".{ending}")).join(", ");
    Err(Failure::Usage(format!("error: {}: no picture ends in .{ending} here; written are: {written}", file.display())))
}

/// Outcome of an episode, in words.
fn sentence(row: &Row) -> String {
    let metrics = &row.metrics;
    let mut words = row.outcome.name().replace('_', " ");
    if let Outcome::Collision { with, at_rest } = &row.outcome {
        words += &format!(" with {}{}", with.name().replace('_', " "), if *at_rest { ", standing still" } else { "" });
    }
    let mut add = |what: &str, value: Option<f64>, unit: &str| {
        if let Some(value) = value {
            words += &format!(", {what} {value:.2} {unit}");
        }
    };
    add("after", metrics.time_s, "s");
    add("driven", metrics.length_m, "m");
    add("planned", metrics.planned_length_m, "m");
    add("at least", metrics.shortest_m, "m");
    add("smallest clearance", metrics.clearance_min_m, "m");
    words
}
