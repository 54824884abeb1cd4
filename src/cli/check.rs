//! `simrun check`: everything that can be wrong before the first tick.

use super::scenarios::{AtPoint, Changes};
use super::{Failure, Out};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scenario files.
    #[arg(required = true, value_name = "SCENARIO")]
    scenarios: Vec<PathBuf>,
    /// Print each scenario with every default filled in.
    #[arg(long)]
    resolved: bool,
    /// Print the scenario at this point of its sweep, with every default filled in.
    #[arg(long, value_name = "N")]
    point: Option<u32>,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    out: Out,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    let mut text = String::new();
    let result = check(args, &mut text);
    // What was found before a fault is said as well.
    args.out.write(&text)?;
    result
}

fn check(args: &Args, text: &mut String) -> Result<(), Failure> {
    for file in &args.scenarios {
        let experiment = args.changes.load(file)?;
        let episodes = experiment.scenario().episodes.get();
        match (args.resolved, args.point) {
            (true, None) => *text += &experiment.scenario().to_yaml(),
            (_, Some(point)) => {
                let point = AtPoint { point }.of(&experiment)?;
                *text += &experiment.scenario_at(point).to_yaml();
            }
            (false, None) if experiment.scenario().sweep.is_empty() => {
                let stacks = experiment.stacks(0).len();
                *text += &format!("{}: valid, {stacks} stacks, {episodes} episodes each\n", file.display());
            }
            (false, None) => {
                let order = experiment.order().map_err(|error| Failure::Usage(format!("error: {error}")))?;
                let points = order.points().len();
                *text += &format!("{}: valid, {points} points, {episodes} episodes each\n", file.display());
                for (number, point) in order.points().iter().enumerate() {
                    let values = order.swept().iter().zip(&point.values).map(|(key, value)| format!("{key} = {value}"));
                    let (values, stacks) = (values.collect::<Vec<_>>().join(", "), point.stacks.join(", "));
                    *text += &format!("  {number}: {values}: {stacks}\n");
                }
            }
        }
    }
    Ok(())
}
