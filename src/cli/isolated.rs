//! `--isolate`: drives in child processes. The child is this program once more, under a subcommand that nobody types.

use super::Failure;
use super::scenarios::Changes;
use crate::experiment::{Isolation, serve};
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Name of the subcommand of children.
const NAME: &str = "drive-blocks";

#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct Isolate {
    /// Drive in child processes, one per thread: one that aborts, or that the system kills, is a row `internal_error`, and the run
    /// goes on. Results are the same.
    #[arg(long)]
    isolate: bool,
    /// Kill a child that is busy with one world or one drive for longer, s; its row is `gave_up`, is left out of rates and driven again
    /// when the run goes on.
    #[arg(long, value_name = "SECONDS", requires = "isolate", value_parser = seconds)]
    give_up_after: Option<f64>,
}

/// A time that a clock can wait for.
fn seconds(text: &str) -> Result<f64, String> {
    let found = text.parse::<f64>().ok().filter(|seconds| (0.001..=1e7).contains(seconds));
    found.ok_or_else(|| "expected a number from 0.001 to 10000000".to_owned())
}

impl Isolate {
    /// Number of processes that hold their own maps, for a run on so many threads.
    pub(super) fn processes(&self, threads: u64) -> u64 {
        if self.isolate { threads.saturating_add(1) } else { 1 }
    }

    /// Calls `run` with the way in which children are started; with `None` where nobody asked for them.
    ///
    /// # Errors
    /// If the program cannot find itself.
    pub(super) fn with<T>(
        &self,
        scenario: &Path,
        changes: &Changes,
        traces: Option<&Path>,
        run: impl FnOnce(Option<&Isolation<'_>>) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        if !self.isolate {
            return run(None);
        }
        let program = std::env::current_exe().map_err(Failure::run)?;
        let command = || {
            let mut command = Command::new(&program);
            command.arg(NAME).args(changes.arguments());
            if let Some(traces) = traces {
                command.arg("--traces").arg(traces);
            }
            command.arg("--").arg(scenario);
            command
        };
        run(Some(&Isolation { command: &command, give_up_after_s: self.give_up_after }))
    }
}

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scenario file.
    #[arg(value_name = "SCENARIO")]
    scenario: PathBuf,
    /// Folder of the traces.
    #[arg(long, value_name = "FOLDER")]
    traces: Option<PathBuf>,
    #[command(flatten)]
    changes: Changes,
}

/// Drives what the parent asks for.
pub(super) fn main(args: &Args) -> Result<(), Failure> {
    let experiment = args.changes.load_for(&args.scenario, Some(1), &Isolate::default())?;
    serve(&experiment, args.traces.as_deref(), io::stdin(), &mut io::stdout().lock()).map_err(Failure::run)
}
