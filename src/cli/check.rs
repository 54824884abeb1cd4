//! `simrun check`: everything that can be wrong before the first tick.

use super::scenarios::{AtPoint, Changes};
use super::{Failure, print};
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
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    for file in &args.scenarios {
        let experiment = args.changes.load(file)?;
        let episodes = experiment.scenario().episodes.get();
        match (args.resolved, args.point) {
            (true, None) => print(&experiment.scenario().to_yaml())?,
            (_, Some(point)) => {
                let point = AtPoint { point }.of(&experiment)?;
                print(&experiment.scenario_at(point).to_yaml())?;
            }
            (false, None) if experiment.scenario().sweep.is_empty() => {
                let stacks = experiment.stacks(0).len();
                print(&format!("{}: valid, {stacks} stacks, {episodes} episodes each\n", file.display()))?;
            }
            (false, None) => {
                let order = experiment.order().map_err(Failure::usage)?;
                let points = order.points().len();
                print(&format!("{}: valid, {points} points, {episodes} episodes each\n", file.display()))?;
                for (number, point) in order.points().iter().enumerate() {
                    let values = order.swept().iter().zip(&point.values).map(|(key, value)| format!("{key} = {value}"));
                    let (values, stacks) = (values.collect::<Vec<_>>().join(", "), point.stacks.join(", "));
                    print(&format!("  {number}: {values}: {stacks}\n"))?;
                }
            }
        }
    }
    Ok(())
}
