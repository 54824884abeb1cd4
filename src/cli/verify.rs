//! `simrun verify`: the determinism promise, checked; and whether finished tables are as their run left them.

use super::run::{complete, refused};
use super::scenarios::Changes;
use super::{Failure, print};
use crate::experiment::{Experiment, Session, threads_available};
use crate::results::{EPISODES_CSV, Existing, Manifest, STATES_CSV, SUMMARY_CSV, compare};
use crate::settings::quantity::counted;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scenario file; or a folder of results, whose tables are compared with the hashes in its manifest.
    #[arg(value_name = "SCENARIO")]
    scenario: PathBuf,
    #[command(flatten)]
    changes: Changes,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    if args.scenario.is_dir() {
        return verify_tables(&args.scenario);
    }
    let experiment = args.changes.load(&args.scenario)?;
    let many = threads_available().max(2);
    let scratch = Scratch::new(&experiment)?;
    let (once, again) = (scratch.0.join("1"), scratch.0.join(many.to_string()));
    run(&experiment, &once, 1)?;
    run(&experiment, &again, many)?;
    for file in [EPISODES_CSV, STATES_CSV, SUMMARY_CSV] {
        if let Some(difference) = compare(&once.join(file), &again.join(file)).map_err(Failure::run)? {
            let message = format!("error: {file} of 1 thread (left) and of {many} (right) differ: {difference}");
            return Err(Failure::Requirement(message));
        }
    }
    print(&format!(
        "{}: {}, {EPISODES_CSV}, {STATES_CSV} and {SUMMARY_CSV} identical with 1 and {many} threads\n",
        args.scenario.display(),
        counted(experiment.order().map_err(Failure::run)?.rows(), "row"),
    ))
}

/// Compares the tables of a finished run with their hashes.
fn verify_tables(folder: &Path) -> Result<(), Failure> {
    let shown = folder.display();
    let manifest = Manifest::read(folder).map_err(|reason| Failure::usage(format!("`{shown}`: {reason}")))?;
    if manifest.tables.is_empty() {
        return Err(Failure::run(format!("`{shown}`: the manifest has no hashes of tables: its run is not finished")));
    }
    let names: Vec<&str> = manifest.tables.keys().map(String::as_str).collect();
    let altered: Vec<&str> = names.iter().copied().filter(|name| manifest.is_altered(folder, name)).collect();
    if altered.is_empty() {
        return print(&format!("{shown}: {} are as the finished run left them\n", names.join(", ")));
    }
    let altered = altered.join(", ");
    Err(Failure::Requirement(format!("error: `{shown}`: altered since the run was finished: {altered}")))
}

fn run(experiment: &Experiment, folder: &Path, threads: usize) -> Result<(), Failure> {
    let session = Session::open(experiment, folder, Existing::Replace).map_err(refused)?;
    complete(session, Some(threads), None, None, true).map(|_| ())
}

/// A folder that is gone afterwards.
struct Scratch(PathBuf);

impl Scratch {
    fn new(experiment: &Experiment) -> Result<Self, Failure> {
        let name = format!("simrun-verify-{}-{}", experiment.scenario().name, std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir_all(&path)
            .map_err(|error| Failure::Run(format!("error: cannot create `{}`: {error}", path.display())))?;
        Ok(Self(path))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // Left behind at worst: nothing depends on it.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
