//! One run of an experiment: opened, driven, finished. `run`, `reproduce` and `verify` share it.

use super::isolate::{Isolated, Isolation};
use super::pool::on_threads;
use super::{Experiment, RunError, Worker};
use crate::results::{
    Answer, Digest, EPISODES_CSV, Existing, Journal, Opened, Order, Reader, ResultsError, SummaryRow,
};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

/// An episode of a finished run that lacks the trace of a stack.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Untraced {
    point: u32,
    episode: u64,
    /// The stacks whose traces are missing, with the digests in their rows.
    digests: Vec<(String, Digest)>,
}

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

    /// The folder of the results.
    pub fn folder(&self) -> &Path {
        self.journal.path()
    }

    /// State of the folder when it was opened.
    pub fn opened(&self) -> Opened {
        self.journal.opened()
    }

    /// Whether a lock keeps other runs out of the folder: some file systems have none.
    pub fn is_guarded(&self) -> bool {
        self.journal.is_guarded()
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
        self.drive(threads, after, || {
            let mut worker = Worker::default();
            move |point, episode| self.experiment.run_block(&mut worker, point, episode, traces)
        })
    }

    /// As [`Self::run`], in child processes, one for each thread; they write traces themselves if their command says so.
    ///
    /// # Errors
    /// As [`Self::run`], and if a child cannot be started or has read another scenario.
    pub fn run_isolated(
        &self,
        threads: usize,
        isolation: &Isolation<'_>,
        after: impl Fn() + Sync,
    ) -> Result<(), RunError> {
        self.drive(threads, after, || {
            let mut isolated = Isolated::new(self.experiment, isolation);
            move |point, episode| isolated.run_block(point, episode)
        })
    }

    /// Drives the missing blocks; each thread makes its own driver.
    fn drive<D>(&self, threads: usize, after: impl Fn() + Sync, driver: impl Fn() -> D + Sync) -> Result<(), RunError>
    where
        D: FnMut(u32, u64) -> Result<Vec<Answer>, RunError>,
    {
        let work = || -> Result<(), RunError> {
            let mut drive = driver();
            while let Some(block) = self.journal.take() {
                let answers = drive(block.point(), block.episode())?;
                self.journal.submit(block, &answers)?;
                after();
            }
            Ok(())
        };
        // More threads than blocks would only be started and ended.
        let missing = self.order().blocks() - self.blocks_done();
        let threads = threads.min(usize::try_from(missing).unwrap_or(usize::MAX));
        on_threads(threads, work).into_iter().collect()
    }

    /// The episodes of a finished run whose traces are not all in `folder`: it was asked for none then, or they were removed.
    ///
    /// # Errors
    /// If the rows cannot be read.
    pub fn untraced(&self, folder: &Path) -> Result<Vec<Untraced>, ResultsError> {
        let path = self.journal.path().join(EPISODES_CSV);
        let refuse = |source| ResultsError::Read { path: path.clone(), source };
        let reader = Reader::open(&path)?;
        let mut found: Vec<Untraced> = Vec::new();
        for row in reader {
            let row = row.map_err(refuse)?;
            let Some(digest) = row.trace_digest else { continue };
            if self.experiment.has_trace(folder, &row) {
                continue;
            }
            if found.last().is_none_or(|last| (last.point, last.episode) != (row.point, row.episode)) {
                found.push(Untraced { point: row.point, episode: row.episode, digests: Vec::new() });
            }
            found.last_mut().expect("one was put there").digests.push((row.stack, digest));
        }
        Ok(found)
    }

    /// Drives these episodes again for their traces; calls `after` once per episode, from any thread. [`stop`](Self::stop) ends it early.
    ///
    /// # Errors
    /// If a trace cannot be written, or a drive is not that of its row, whose trace is then not written.
    pub fn trace(
        &self,
        threads: usize,
        untraced: &[Untraced],
        folder: &Path,
        after: impl Fn() + Sync,
    ) -> Result<(), RunError> {
        let next = AtomicUsize::new(0);
        let work = || -> Result<(), RunError> {
            let mut worker = Worker::default();
            let take = || untraced.get(next.fetch_add(1, Ordering::Relaxed)).filter(|_| !self.journal.is_stopped());
            while let Some(Untraced { point, episode, digests }) = take() {
                let answers = self.experiment.run_block(&mut worker, *point, *episode, Some(folder))?;
                for (row, (stack, before)) in answers
                    .iter()
                    .map(|answer| &answer.row)
                    .filter_map(|row| Some((row, digests.iter().find(|(stack, _)| *stack == row.stack)?)))
                {
                    let now = row.trace_digest.unwrap_or_default();
                    if now != *before {
                        self.experiment.remove_trace(folder, row);
                        let (point, episode, stack, before) = (*point, *episode, stack.clone(), *before);
                        return Err(RunError::OtherDrive { point, episode, stack, before, now });
                    }
                }
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
