//! The journal of one run: hands out work, takes answers in any order, writes them in one order.

use super::ResultsError;
use super::csv_rows::{header_line, write_row};
use super::identity::{Identity, Launch, Manifest};
use super::order::{Order, StackAt};
use super::resume::{self, Extended, Start};
use super::states::{self, Answer, write_states};
use super::store::{self, Appender};
use super::summary::{SummaryRow, summarise, write_summary};
use super::timings::{self, write_timing};
use crate::files;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// One row per episode and stack.
pub const EPISODES_CSV: &str = "episodes.csv";
/// One row per stack and sweep point.
pub const SUMMARY_CSV: &str = "summary.csv";
/// Time of each stack in each state of its local planner.
pub const STATES_CSV: &str = "states.csv";
/// Wall-clock times, one row per row of `episodes.csv`; a kill may cost some of them.
pub const TIMINGS_CSV: &str = "timings.csv";
/// The run to which the folder belongs.
pub const MANIFEST_JSON: &str = "manifest.json";
/// Largest number of bytes of a manifest: some thousands of starts.
pub const MANIFEST_BYTES_MAX: u64 = 1 << 26;
/// The rows of a run with fewer episodes while it is being extended.
pub(super) const EXTENDED_CSV: &str = "episodes.extended.csv";

/// The states of a run with fewer episodes while it is being extended.
pub(super) const EXTENDED_STATES_CSV: &str = "states.extended.csv";

/// Blocks that may be handed out beyond the first one that is not yet written.
///
/// It bounds the memory of answers that wait for an earlier one, and is ample enough that one long
/// episode does not hold up the other workers.
pub const WINDOW_BLOCKS: u64 = 1024;

/// Treatment of results that are in the folder already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Go on where the same run was interrupted; refuse another run.
    Continue,
    /// Throw away whatever is there.
    Replace,
}

/// State of the folder when it was opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opened {
    /// The folder held no rows of this run.
    Fresh,
    /// The folder held rows of this run, which was interrupted or had fewer episodes.
    Resume {
        /// Blocks that need not run again.
        blocks_done: u64,
    },
    /// The folder held all rows.
    Complete,
}

/// The journal of one run, in a folder of its own; shared by reference between workers.
///
/// Each worker repeats [`take`](Self::take) and [`submit`](Self::submit) until there is no more work;
/// then one calls [`finish`](Self::finish). Blocks are handed out in order and never further than
/// [`WINDOW_BLOCKS`] ahead, so that the earliest unwritten block is always being worked on:
/// `take` may wait, `submit` never does. Waiting blocks the thread.
///
/// **Adding episodes.** Rows are ordered by sweep point first, so that more episodes per point belong
/// between rows already written. With one point they are appended; with several the old file is set
/// aside and its blocks are copied to their places in a new one. Nothing runs twice, the bytes are
/// those of a run with the full number from the start, and an interruption is resumed like any other.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    order: Order,
    seed: u64,
    opened: Opened,
    window_blocks: u64,
    state: Mutex<State>,
    /// Signalled when a block is written or the run ends.
    changed: Condvar,
    /// Holds the lock until it is dropped.
    _lock: File,
}

/// Mutable state of the run.
#[derive(Debug)]
struct State {
    /// First block not yet handed out.
    next: u64,
    /// Blocks in the file.
    written: u64,
    /// Blocks that need not run (again).
    done: u64,
    /// Blocks that wait for an earlier one.
    waiting: BTreeMap<u64, Encoded>,
    /// Blocks of the run that is being extended.
    extended: Option<Extended>,
    episodes: Appender<File>,
    states: Appender<File>,
    timings: Appender<File>,
    is_stopped: bool,
    failure: Option<String>,
}

/// A piece of work: one world, to be driven by every stack of its sweep point.
///
/// Dropping it instead of submitting its rows (a worker has panicked) ends the run as failed, so
/// that no other worker waits for rows that never come.
#[derive(Debug)]
pub struct Block<'a> {
    journal: &'a Journal,
    index: u64,
    is_submitted: bool,
}

impl Block<'_> {
    /// The block's number in the order of rows.
    pub fn index(&self) -> u64 {
        self.index
    }

    /// Number of the sweep point.
    pub fn point(&self) -> u32 {
        self.journal.order.position(self.index).0
    }

    /// Number of the episode.
    pub fn episode(&self) -> u64 {
        self.journal.order.position(self.index).1
    }

    /// The stacks to run, in the order in which their rows are to be submitted.
    pub fn stacks(&self) -> &[StackAt] {
        self.journal.order.stacks(self.point())
    }
}

impl Drop for Block<'_> {
    fn drop(&mut self) {
        if !self.is_submitted {
            let (point, episode) = self.journal.order.position(self.index);
            self.journal.state().failure.get_or_insert(format!("point {point}, episode {episode} was given up"));
            self.journal.changed.notify_all();
        }
    }
}

impl Journal {
    /// Locks the folder, compares what it holds with this run, and prepares the files.
    ///
    /// The folder and its parents are created. Nothing in it changes before all is checked;
    /// `episodes.csv` exists afterwards, so that a bad path fails before the long run.
    ///
    /// # Errors
    /// [`Locked`](ResultsError::Locked) if another run holds it. With [`Existing::Continue`]:
    /// [`Different`](ResultsError::Different) for another run, [`TooManyEpisodes`](ResultsError::TooManyEpisodes)
    /// for the same run with more episodes, [`UnfinishedExtension`](ResultsError::UnfinishedExtension) while
    /// one to another number is under way, [`Foreign`](ResultsError::Foreign) without a readable manifest,
    /// [`Read`](ResultsError::Read) if a row is not the expected one. [`Io`](ResultsError::Io) if the system refuses.
    pub fn open(path: &Path, identity: Identity, order: Order, existing: Existing) -> Result<Self, ResultsError> {
        Self::open_with_window(path, identity, order, existing, WINDOW_BLOCKS)
    }

    fn open_with_window(
        path: &Path,
        identity: Identity,
        order: Order,
        existing: Existing,
        window_blocks: u64,
    ) -> Result<Self, ResultsError> {
        assert!(window_blocks > 0, "a window of no blocks");
        std::fs::create_dir_all(path).map_err(ResultsError::io("create", path))?;
        let lock = store::lock(path)?;
        let [episodes, states, extended] = [EPISODES_CSV, STATES_CSV, EXTENDED_CSV].map(|name| path.join(name));
        let seed = identity.seed;
        let mut start = Start::default();
        let mut launches = Vec::new();
        if existing == Existing::Continue && (episodes.exists() || extended.exists()) {
            let manifest = recognise(path, &identity)?;
            launches = manifest.launches;
            for name in [EPISODES_CSV, STATES_CSV, TIMINGS_CSV, EXTENDED_CSV, EXTENDED_STATES_CSV] {
                store::restore_line_feeds(&path.join(name))?;
            }
            start = Start::find(path, &order, seed)?;
        }

        let mut done = start.blocks;
        if let Some(present) = start.extended {
            done += (start.blocks..order.blocks())
                .filter(|&block| present.ordinal(&order, order.position(block)).is_some())
                .count() as u64;
        }
        let opened = match done {
            0 => Opened::Fresh,
            _ if start.blocks == order.blocks() => Opened::Complete,
            _ => Opened::Resume { blocks_done: done },
        };

        // From here on things change. A kill between any two steps leaves a folder that opens as before.
        if opened != Opened::Complete {
            if existing == Existing::Replace {
                // The copy first: alone it would look like an extension that has just begun.
                resume::forget(path)?;
                store::remove(&episodes)?;
                store::remove(&states)?;
            }
            launches.push(Launch::current());
            let manifest = Manifest { identity, episodes: order.episodes(), launches };
            let text = serde_json::to_string_pretty(&manifest).expect("a manifest is plain data");
            store::replace(&path.join(MANIFEST_JSON), (text + "\n").as_bytes())?;
            store::remove(&path.join(SUMMARY_CSV))?;
            if start.is_to_be_set_aside {
                resume::set_aside(path)?;
            }
        }
        let mut episodes = store::appender(&episodes, start.bytes)?;
        if start.bytes == 0 {
            episodes
                .append(&header_line(order.swept()))
                .map_err(ResultsError::io("write", &path.join(EPISODES_CSV)))?;
        }
        let mut states = store::appender(&states, start.states_bytes)?;
        if start.states_bytes == 0 {
            states.append(states::HEADER.as_bytes()).map_err(ResultsError::io("write", &path.join(STATES_CSV)))?;
        }
        let timings = open_timings(&path.join(TIMINGS_CSV), opened == Opened::Fresh)?;
        let extended = start.extended.map(|present| Extended::open(path, present)).transpose()?;
        let state = State {
            next: start.blocks,
            written: start.blocks,
            done,
            waiting: BTreeMap::new(),
            extended,
            episodes,
            states,
            timings,
            is_stopped: false,
            failure: None,
        };
        let journal = Self {
            path: path.to_owned(),
            order,
            seed,
            opened,
            window_blocks,
            state: Mutex::new(state),
            changed: Condvar::new(),
            _lock: lock,
        };
        journal.advance(&mut journal.state())?;
        Ok(journal)
    }

    /// State of the folder when it was opened.
    pub fn opened(&self) -> Opened {
        self.opened
    }

    /// The folder's path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The order of the rows.
    pub fn order(&self) -> &Order {
        &self.order
    }

    /// Blocks that need not run (again), for a progress bar; all of them are [`Order::blocks`].
    pub fn blocks_done(&self) -> u64 {
        self.state().done
    }

    /// The next piece of work; `None` when there is no more, after [`stop`](Self::stop), or when the run has failed.
    ///
    /// Waits while the window is full.
    pub fn take(&self) -> Option<Block<'_>> {
        let mut state = self.state();
        loop {
            if state.is_stopped || state.failure.is_some() {
                return None;
            }
            while state.next < self.order.blocks() && state.copies(&self.order, state.next).is_some() {
                state.next += 1;
            }
            if state.next == self.order.blocks() {
                return None;
            }
            if state.next < state.written + self.window_blocks {
                let index = state.next;
                state.next += 1;
                return Some(Block { journal: self, index, is_submitted: false });
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Takes the answers to a block, one per stack, and writes every block whose turn has come.
    ///
    /// # Errors
    /// If writing fails. The run has then failed: the file ends with the last whole block, `take` hands out
    /// nothing more, and the same command resumes once there is room.
    ///
    /// # Panics
    /// If the block is of another journal, or the answers are not those of the block in the order of its stacks.
    pub fn submit(&self, mut block: Block<'_>, answers: &[Answer]) -> Result<(), ResultsError> {
        assert!(std::ptr::eq(block.journal, self), "the block is of another journal");
        let (point, episode) = self.order.position(block.index);
        assert_eq!(answers.len(), self.order.stacks(point).len(), "one row per stack");
        for (stack, Answer { row, .. }) in answers.iter().enumerate() {
            if let Err(message) = self.order.check(row, point, episode, stack, self.seed) {
                panic!("a row of another block: {message}");
            }
        }
        let encoded = Encoded::new(answers);

        let mut state = self.state();
        block.is_submitted = true;
        if let Some(failure) = &state.failure {
            return Err(ResultsError::Failed(failure.clone()));
        }
        state.waiting.insert(block.index, encoded);
        state.done += 1;
        let result = self.advance(&mut state);
        if let Err(error) = &result {
            state.failure = Some(error.to_string());
        }
        self.changed.notify_all();
        result
    }

    /// Hands out no more work. Blocks already taken may still be submitted; the rest is left for the next start.
    pub fn stop(&self) {
        self.state().is_stopped = true;
        self.changed.notify_all();
    }

    /// Brings everything to the disk and writes `summary.csv`; `None` if blocks are missing.
    ///
    /// # Errors
    /// If the run has failed or the system refuses.
    pub fn finish(self) -> Result<Option<Vec<SummaryRow>>, ResultsError> {
        let mut state = self.state();
        if let Some(failure) = &state.failure {
            return Err(ResultsError::Failed(failure.clone()));
        }
        let path = self.path.join(EPISODES_CSV);
        state.states.sync().map_err(ResultsError::io("write", &self.path.join(STATES_CSV)))?;
        state.episodes.sync().map_err(ResultsError::io("write", &path))?;
        state.timings.sync().map_err(ResultsError::io("write", &self.path.join(TIMINGS_CSV)))?;
        if state.written < self.order.blocks() {
            return Ok(None);
        }
        resume::forget(&self.path)?;
        let file = files::open(&path, u64::MAX).map_err(ResultsError::io("read", &path))?;
        let summary = summarise(BufReader::new(file), self.order.episodes() as usize)
            .map_err(|source| ResultsError::Read { path, source })?;
        let mut bytes = Vec::new();
        write_summary(&mut bytes, self.order.swept(), &summary).expect("writing to memory cannot fail");
        let path = self.path.join(SUMMARY_CSV);
        // A complete folder stays untouched.
        if files::bytes(&path, bytes.len() as u64).ok().as_ref() != Some(&bytes) {
            store::replace(&path, &bytes)?;
        }
        Ok(Some(summary))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // A panic while it is held leaves whole blocks only, and the block's drop marks the run as failed.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes the blocks whose turn has come.
    fn advance(&self, state: &mut State) -> Result<(), ResultsError> {
        while state.written < self.order.blocks() {
            let encoded = match (state.copies(&self.order, state.written), &mut state.extended) {
                (Some(ordinal), Some(extended)) => {
                    let lines = extended.lines(ordinal, &self.order);
                    let (episodes, states) = lines.map_err(ResultsError::io("read", &self.path.join(EXTENDED_CSV)))?;
                    // Their times are in timings.csv already.
                    Encoded { episodes, states, timings: Vec::new() }
                }
                _ => match state.waiting.remove(&state.written) {
                    Some(encoded) => encoded,
                    None => break,
                },
            };
            let failed = |name| move |error| ResultsError::io("write", &self.path.join(name))(error);
            // The episodes last: a block that they hold has its states, whenever a kill comes.
            state.states.append(&encoded.states).map_err(failed(STATES_CSV))?;
            state.episodes.append(&encoded.episodes).map_err(failed(EPISODES_CSV))?;
            state.written += 1;
            state.timings.append(&encoded.timings).map_err(failed(TIMINGS_CSV))?;
        }
        Ok(())
    }
}

impl State {
    /// Number of the block in the file that is being extended; `None` if it is not in that file.
    fn copies(&self, order: &Order, block: u64) -> Option<u64> {
        self.extended.as_ref()?.present.ordinal(order, order.position(block))
    }
}

/// The lines of a block.
#[derive(Debug, Default)]
struct Encoded {
    episodes: Vec<u8>,
    states: Vec<u8>,
    timings: Vec<u8>,
}

impl Encoded {
    fn new(answers: &[Answer]) -> Self {
        const MEMORY: &str = "writing to memory cannot fail";
        let [mut episodes, mut states, mut timings] = [(); 3].map(|()| csv::Writer::from_writer(Vec::new()));
        for answer in answers {
            write_row(&mut episodes, &answer.row).expect(MEMORY);
            write_states(&mut states, answer).expect(MEMORY);
            write_timing(&mut timings, &answer.row, &answer.timing).expect(MEMORY);
        }
        let [episodes, states, timings] = [episodes, states, timings].map(|table| table.into_inner().expect(MEMORY));
        Self { episodes, states, timings }
    }
}

/// The manifest of the folder, if it is of the same run.
fn recognise(folder: &Path, identity: &Identity) -> Result<Manifest, ResultsError> {
    let foreign = |reason| ResultsError::Foreign { folder: folder.to_owned(), reason };
    let text = files::text(&folder.join(MANIFEST_JSON), MANIFEST_BYTES_MAX)
        .map_err(|error| foreign(format!("{MANIFEST_JSON} cannot be read: {error}")))?;
    let manifest: Manifest = serde_json::from_str(&text)
        .map_err(|error| foreign(format!("{MANIFEST_JSON} is not of this version: {error}")))?;
    let differences = manifest.identity.differences(identity);
    if differences.is_empty() {
        Ok(manifest)
    } else {
        Err(ResultsError::Different { folder: folder.to_owned(), differences })
    }
}

/// The whole lines of `timings.csv`, or a new one.
fn open_timings(path: &Path, is_fresh: bool) -> Result<Appender<File>, ResultsError> {
    let len = match files::open(path, u64::MAX) {
        Ok(mut file) if !is_fresh => store::whole_lines(&mut file).map_err(ResultsError::io("read", path))?,
        _ => 0,
    };
    let mut timings = store::appender(path, len)?;
    if len == 0 {
        timings.append(timings::HEADER.as_bytes()).map_err(ResultsError::io("write", path))?;
    }
    Ok(timings)
}

#[cfg(test)]
mod tests;
