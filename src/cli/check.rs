//! `simrun check`: everything that can be wrong before the first tick.

use super::scenarios::Changes;
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
    #[command(flatten)]
    changes: Changes,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    for file in &args.scenarios {
        let experiment = args.changes.load(file)?;
        if args.resolved {
            print(&experiment.scenario().to_yaml())?;
        } else {
            let (stacks, episodes) = (experiment.stacks().len(), experiment.scenario().episodes.get());
            print(&format!("{}: valid, {stacks} stacks, {episodes} episodes each\n", file.display()))?;
        }
    }
    Ok(())
}
