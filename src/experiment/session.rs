//! One run of an experiment: opened, driven, finished. `run`, `reproduce` and `verify` share it.

use super::pool::on_threads;
use super::{Experiment, RunError, Worker};
use crate::results::{Existing, Journal, Opened, Order, ResultsError, SummaryRow};
use std::path::Path;

/// An experiment with the journal of its results.
#[derive(Debug)]
pub struct Session<'e> {
    experiment: &'e Experiment,
    journal: Journal,
}

impl<'e> Session<'e> {
    /// Opens the folder of results at `path`; see [`Journal::open`].
    ///
    /// # Errors
    /// If the folder cannot be written, or holds results that this experiment would not write.
    pub fn open(experiment: &'e Experiment, path: &Path, existing: Existing) -> Result<Self, ResultsError> {
        let journal = Journal::open(path, experiment.identity(), experiment.order()?, existing)?;
        Ok(Self { experiment, journal })
    }

    /// State of the folder when it was opened.
    pub fn opened(&self) -> Opened {
        self.journal.opened()
    }

    /// The order of the rows.
    pub fn order(&self) -> &Order {
        self.journal.order()
    }

    /// Blocks that need not run (again); all of them are [`Order::blocks`].
    pub fn blocks_done(&self) -> u64 {
        self.journal.blocks_done()
    }

    /// Drives the missing blocks on `threads` threads; calls `after` once per finished block, from any thread. Traces are
    /// written to `traces` if given.
    ///
    /// # Errors
    /// If a row or a trace cannot be written. Rows written before stay, and the same run goes on from there.
    pub fn run(&self, threads: usize, traces: Option<&Path>, after: impl Fn() + Sync) -> Result<(), RunError> {
        let work = || -> Result<(), RunError> {
            let mut worker = Worker::default();
            while let Some(block) = self.journal.take() {
                let answers = self.experiment.run_block(&mut worker, block.point(), block.episode(), traces)?;
                self.journal.submit(block, &answers)?;
                after();
            }
            Ok(())
        };
        on_threads(threads, work).into_iter().collect()
    }

    /// Begins no more blocks: those that are being driven are written, the rest is left for the next session.
    pub fn stop(&self) {
        self.journal.stop();
    }

    /// Brings everything to the disk and writes `summary.csv`; `None` if blocks are missing.
    ///
    /// # Errors
    /// If the run has failed or the system refuses.
    pub fn finish(self) -> Result<Option<Vec<SummaryRow>>, ResultsError> {
        self.journal.finish()
    }
}
