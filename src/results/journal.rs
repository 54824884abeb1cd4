//! The journal of one run: hands out work, takes answers in any order, writes them in one order.

use super::ResultsError;
use super::csv_rows::{header_line, write_row};
use super::identity::{Identity, Launch, Manifest};
use super::order::{Order, StackAt};
use super::resume::{self, Extended, Start};
use super::states::{self, Answer, write_states};
use super::store::{self, Appender, Hold};
use super::summary::{SummaryRow, summarise, write_summary};
use super::timings::{self, write_timing};
use crate::digest::Digest;
use crate::files;
use crate::trace::Header;
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
/// Folder of the traces, one CSV per episode and stack.
pub const TRACES: &str = "traces";
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
///
/// **Finished tables.** When the last block is written, everything is brought to the disk, and then the manifest gets a hash of each table.
/// From then on a table that was altered is refused; one that lost its end is completed, and must then have its hash again.
/// A complete folder is only read, so it may be read-only.
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
    manifest: Manifest,
    /// Holds the lock until it is dropped.
    hold: Hold,
}

/// The tables that are being written.
#[derive(Debug)]
struct Tables {
    episodes: Appender<File>,
    states: Appender<File>,
    timings: Appender<File>,
    /// Each table under the byte contract with the place at which it was opened.
    places: [(PathBuf, Option<(u64, u64)>); 2],
}

impl Tables {
    /// Opens the tables of a folder behind the blocks that stay, with their headers.
    fn open(folder: &Path, order: &Order, start: &Start, is_fresh: bool) -> Result<Self, ResultsError> {
        let [episodes_path, states_path] = [EPISODES_CSV, STATES_CSV].map(|name| folder.join(name));
        let mut episodes = store::appender(&episodes_path, start.bytes)?;
        if start.bytes == 0 {
            episodes.append(&header_line(order.swept())).map_err(ResultsError::io("write", &episodes_path))?;
        }
        let mut states = store::appender(&states_path, start.states_bytes)?;
        if start.states_bytes == 0 {
            states.append(states::HEADER.as_bytes()).map_err(ResultsError::io("write", &states_path))?;
        }
        let timings = open_timings(&folder.join(TIMINGS_CSV), is_fresh)?;
        store::sync_folder(folder).map_err(ResultsError::io("write", folder))?;
        let places = [episodes_path, states_path].map(|path| {
            let place = store::place(&path);
            (path, place)
        });
        Ok(Self { episodes, states, timings, places })
    }

    /// The table that is not where it was opened, if there is one: what is written to it would be lost.
    fn gone(&self) -> Option<&Path> {
        self.places.iter().find(|(path, place)| store::place(path) != *place).map(|(path, _)| path.as_path())
    }

    /// Brings everything to the disk.
    fn sync(&mut self, folder: &Path) -> Result<(), ResultsError> {
        let tables =
            [(&mut self.states, STATES_CSV), (&mut self.episodes, EPISODES_CSV), (&mut self.timings, TIMINGS_CSV)];
        for (table, name) in tables {
            table.sync().map_err(ResultsError::io("write", &folder.join(name)))?;
        }
        Ok(())
    }
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
    /// `None` if all blocks are there already.
    tables: Option<Tables>,
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
    /// [`Read`](ResultsError::Read) if a row is not the expected one, [`Altered`](ResultsError::Altered) if a finished table has another hash.
    /// [`Io`](ResultsError::Io) if the system refuses.
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
        let mut hold = store::lock(path)?;
        let [episodes, states, extended] = [EPISODES_CSV, STATES_CSV, EXTENDED_CSV].map(|name| path.join(name));
        let seed = identity.seed;
        let mut start = Start::default();
        let mut manifest =
            Manifest { identity, episodes: order.episodes(), launches: Vec::new(), tables: BTreeMap::new() };
        if existing == Existing::Continue && (episodes.exists() || extended.exists()) {
            let found = recognise(path, &manifest.identity)?;
            for name in [EPISODES_CSV, STATES_CSV, TIMINGS_CSV, EXTENDED_CSV, EXTENDED_STATES_CSV] {
                store::restore_line_feeds(&path.join(name))?;
            }
            start = Start::find(path, &order, seed)?;
            let altered = [EPISODES_CSV, STATES_CSV].into_iter().find(|name| found.is_altered(path, name));
            let is_cut_short = found.episodes == order.episodes() && start.blocks < order.blocks();
            if let Some(name) = altered.filter(|_| !is_cut_short) {
                return Err(ResultsError::Altered { path: path.join(name) });
            }
            manifest.launches = found.launches;
            if found.episodes == order.episodes() && start.extended.is_none() {
                // What a finished run left is what this one must come to, unless a drive of it was given up.
                manifest.tables = found.tables;
            }
        }

        let mut done = start.blocks;
        if let Some(present) = &start.extended {
            done += (start.blocks..order.blocks())
                .filter(|&block| present.ordinal(&order, order.position(block)).is_some())
                .count() as u64;
        }
        let opened = match done {
            0 => Opened::Fresh,
            _ if start.blocks == order.blocks() => Opened::Complete,
            _ => Opened::Resume { blocks_done: done },
        };

        if opened != Opened::Complete
            && let Some(refused) = hold.read_only.take()
        {
            return Err(refused);
        }

        // From here on things change. A kill between any two steps leaves a folder that opens as before.
        if opened != Opened::Complete {
            if existing == Existing::Replace {
                // The copy first: alone it would look like an extension that has just begun.
                resume::forget(path)?;
                store::remove(&episodes)?;
                store::remove(&states)?;
            }
            if opened == Opened::Fresh {
                // Traces of a run whose rows are gone; those of this one, of single episodes, are welcome.
                let is_kept = |trace: &Path| {
                    let header = Header::read(trace).ok().flatten();
                    existing == Existing::Continue && header.is_some_and(|header| manifest.identity.has_trace(&header))
                };
                store::remove_traces(&path.join(TRACES), is_kept)?;
            }
            manifest.launches.push(Launch::current());
            write_manifest(path, &manifest)?;
            store::remove(&path.join(SUMMARY_CSV))?;
            if start.is_to_be_set_aside {
                resume::set_aside(path)?;
            }
        }
        // Behind complete tables there may be the torn row of a longer run that never came to be.
        let is_whole = |path: &Path, bytes: u64| std::fs::metadata(path).is_ok_and(|found| found.len() == bytes);
        let is_untouched = opened == Opened::Complete
            && (hold.read_only.is_some() || is_whole(&episodes, start.bytes) && is_whole(&states, start.states_bytes));
        let tables = match is_untouched {
            true => None,
            false => Some(Tables::open(path, &order, &start, opened == Opened::Fresh)?),
        };
        let extended = start.extended.map(|present| Extended::open(path, present)).transpose()?;
        let state = State {
            next: start.blocks,
            written: start.blocks,
            done,
            waiting: BTreeMap::new(),
            extended,
            tables,
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
            manifest,
            hold,
        };
        journal.advance(&mut journal.state())?;
        Ok(journal)
    }

    /// State of the folder when it was opened.
    pub fn opened(&self) -> Opened {
        self.opened
    }

    /// Whether a lock keeps other runs out of the folder: some file systems have none.
    pub fn is_guarded(&self) -> bool {
        self.hold.is_guarded
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

    /// Whether [`stop`](Self::stop) was called.
    pub fn is_stopped(&self) -> bool {
        self.state().is_stopped
    }

    /// Brings everything to the disk and writes `summary.csv`, then the hashes of all tables into the manifest; `None` if blocks are missing.
    ///
    /// # Errors
    /// If the run has failed, the system refuses, or rows that were there already turn out to be altered.
    pub fn finish(self) -> Result<Option<Vec<SummaryRow>>, ResultsError> {
        let mut state = self.state();
        if let Some(failure) = &state.failure {
            return Err(ResultsError::Failed(failure.clone()));
        }
        let path = self.path.join(EPISODES_CSV);
        if let Some(tables) = &mut state.tables {
            tables.sync(&self.path)?;
            if let Some(gone) = tables.gone() {
                return Err(ResultsError::Gone { path: gone.to_owned() });
            }
        }
        if state.written < self.order.blocks() {
            return Ok(None);
        }
        let file = files::open(&path, u64::MAX).map_err(ResultsError::io("read", &path))?;
        let summary = summarise(BufReader::new(file), self.order.episodes() as usize)
            .map_err(|source| ResultsError::Read { path, source })?;
        let mut bytes = Vec::new();
        write_summary(&mut bytes, self.order.swept(), &summary).expect("writing to memory cannot fail");
        if self.hold.read_only.is_none() {
            self.seal(&bytes)?;
        }
        Ok(Some(summary))
    }

    /// Writes what a finished run ends with; a folder that has it all stays untouched.
    fn seal(&self, summary: &[u8]) -> Result<(), ResultsError> {
        let mut tables = BTreeMap::from([(SUMMARY_CSV.to_owned(), Digest::of(summary).to_string())]);
        for name in [EPISODES_CSV, STATES_CSV] {
            let path = self.path.join(name);
            let digest = files::digest(&path).map_err(ResultsError::io("read", &path))?.to_string();
            if self.manifest.tables.get(name).is_some_and(|before| *before != digest) {
                return Err(ResultsError::Altered { path });
            }
            tables.insert(name.to_owned(), digest);
        }
        resume::forget(&self.path)?;
        let path = self.path.join(SUMMARY_CSV);
        if files::bytes(&path, summary.len() as u64).ok().as_deref() != Some(summary) {
            store::replace(&path, summary)?;
        }
        if self.manifest.tables == tables {
            return Ok(());
        }
        store::sync_folder(&self.path).map_err(ResultsError::io("write", &self.path))?;
        write_manifest(&self.path, &Manifest { tables, ..self.manifest.clone() })
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
            let tables = state.tables.as_mut().expect("they are open while blocks are missing");
            if let Some(gone) = tables.gone() {
                return Err(ResultsError::Gone { path: gone.to_owned() });
            }
            // The episodes last: a block that they hold has its states, whenever a kill comes.
            tables.states.append(&encoded.states).map_err(failed(STATES_CSV))?;
            tables.episodes.append(&encoded.episodes).map_err(failed(EPISODES_CSV))?;
            state.written += 1;
            tables.timings.append(&encoded.timings).map_err(failed(TIMINGS_CSV))?;
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
    let manifest = Manifest::read(folder).map_err(foreign)?;
    let differences = manifest.identity.differences(identity);
    if differences.is_empty() {
        Ok(manifest)
    } else {
        Err(ResultsError::Different { folder: folder.to_owned(), differences })
    }
}

fn write_manifest(folder: &Path, manifest: &Manifest) -> Result<(), ResultsError> {
    let text = serde_json::to_string_pretty(manifest).expect("a manifest is plain data");
    store::replace(&folder.join(MANIFEST_JSON), (text + "\n").as_bytes())
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
