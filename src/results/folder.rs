//! The folder of one run: hands out work, takes answers in any order, writes them in one order.

use super::columns::COLUMNS;
use super::identity::{Identity, Launch, Manifest};
use super::order::Order;
use super::row::{Reader, Row, header_line, write_row};
use super::store::{self, Appender};
use super::summary::{SummaryRow, summarise, write_summary};
use super::timings::{self, Timing, write_timing};
use super::{ReadError, ResultsError};
use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// One row per episode and stack.
pub const EPISODES_CSV: &str = "episodes.csv";
/// One row per stack and sweep point.
pub const SUMMARY_CSV: &str = "summary.csv";
/// Wall-clock times, one row per row of `episodes.csv`; a kill may cost some of them.
pub const TIMINGS_CSV: &str = "timings.csv";
/// Which run the folder belongs to.
pub const MANIFEST_JSON: &str = "manifest.json";
/// Guards the folder; it stays, and is free as soon as its owner has ended in whatever way.
const LOCK: &str = ".lock";
/// The rows of a run with fewer episodes while it is being extended.
const EXTENDED_CSV: &str = "episodes.extended.csv";

/// Blocks that may be handed out beyond the first one that is not yet written.
///
/// It bounds the memory of answers that wait for an earlier one, and is ample enough that one long
/// episode does not hold up the other workers.
pub const WINDOW_BLOCKS: u64 = 1024;

/// What to do with the results of another run in the same folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Go on where the same run was interrupted; refuse another run.
    Continue,
    /// Throw away whatever is there.
    Replace,
}

/// What was found when the folder was opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opened {
    /// No rows of this run.
    Fresh,
    /// Rows of this run, interrupted or with fewer episodes.
    Resume {
        /// Blocks that need not run again.
        blocks_done: u64,
    },
    /// All rows.
    Complete,
}

/// The folder of one run; shared by reference between workers.
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
pub struct Folder {
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

/// What changes while the run goes on.
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
    timings: Appender<File>,
    is_stopped: bool,
    failure: Option<String>,
}

/// The lines of a block.
#[derive(Debug, Default)]
struct Encoded {
    episodes: Vec<u8>,
    timings: Vec<u8>,
}

/// A piece of work: one world, to be driven by every stack of its sweep point.
///
/// Dropping it instead of submitting its rows (a worker has panicked) ends the run as failed, so
/// that no other worker waits for rows that never come.
#[derive(Debug)]
pub struct Block<'a> {
    folder: &'a Folder,
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
        self.folder.order.position(self.index).0
    }

    /// Number of the episode.
    pub fn episode(&self) -> u64 {
        self.folder.order.position(self.index).1
    }

    /// The stacks to run, in the order in which their rows are to be submitted.
    pub fn stacks(&self) -> &[String] {
        self.folder.order.stacks(self.point())
    }
}

impl Drop for Block<'_> {
    fn drop(&mut self) {
        if !self.is_submitted {
            let (point, episode) = self.folder.order.position(self.index);
            self.folder.state().failure.get_or_insert(format!("point {point}, episode {episode} was given up"));
            self.folder.changed.notify_all();
        }
    }
}

impl Folder {
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
        let lock = lock(path)?;
        let [episodes, extended] = [path.join(EPISODES_CSV), path.join(EXTENDED_CSV)];
        let seed = identity.seed;
        let mut start = Start::default();
        let mut launches = Vec::new();
        if existing == Existing::Continue && (episodes.exists() || extended.exists()) {
            let manifest = recognise(path, &identity)?;
            launches = manifest.launches;
            start = Start::find(path, &order, seed)?;
        }

        let mut done = start.blocks;
        if let Some(present) = start.extended {
            done += (start.blocks..order.blocks())
                .filter(|&block| present.ordinal(order.position(block)).is_some())
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
                store::remove(&extended)?;
                store::remove(&episodes)?;
            }
            launches.push(Launch::current());
            let manifest = Manifest { identity, episodes: order.episodes(), launches };
            let text = serde_json::to_string_pretty(&manifest).expect("a manifest is plain data");
            store::replace(&path.join(MANIFEST_JSON), (text + "\n").as_bytes())?;
            store::remove(&path.join(SUMMARY_CSV))?;
            if start.is_to_be_set_aside {
                std::fs::rename(&episodes, &extended).map_err(ResultsError::io("rename", &episodes))?;
            }
        }
        let mut episodes = store::appender(&episodes, start.bytes)?;
        if start.bytes == 0 {
            episodes
                .append(&header_line(order.swept()))
                .map_err(ResultsError::io("write", &path.join(EPISODES_CSV)))?;
        }
        let timings = open_timings(&path.join(TIMINGS_CSV), opened == Opened::Fresh)?;
        let extended = start.extended.map(|present| Extended::open(&extended, present)).transpose()?;
        let state = State {
            next: start.blocks,
            written: start.blocks,
            done,
            waiting: BTreeMap::new(),
            extended,
            episodes,
            timings,
            is_stopped: false,
            failure: None,
        };
        let folder = Self {
            path: path.to_owned(),
            order,
            seed,
            opened,
            window_blocks,
            state: Mutex::new(state),
            changed: Condvar::new(),
            _lock: lock,
        };
        folder.advance(&mut folder.state())?;
        Ok(folder)
    }

    /// What was found when the folder was opened.
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
            while state.next < self.order.blocks() && state.copies(self.order.position(state.next)).is_some() {
                state.next += 1;
            }
            if state.next == self.order.blocks() {
                return None;
            }
            if state.next < state.written + self.window_blocks {
                let index = state.next;
                state.next += 1;
                return Some(Block { folder: self, index, is_submitted: false });
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Takes the rows of a block, one per stack, and writes every block whose turn has come.
    ///
    /// # Errors
    /// If writing fails. The run has then failed: the file ends with the last whole block, `take` hands out
    /// nothing more, and the same command resumes once there is room.
    ///
    /// # Panics
    /// If the block is of another folder, or the rows are not those of the block in the order of its stacks.
    pub fn submit(&self, mut block: Block<'_>, rows: &[(Row, Timing)]) -> Result<(), ResultsError> {
        assert!(std::ptr::eq(block.folder, self), "the block is of another folder");
        let (point, episode) = self.order.position(block.index);
        assert_eq!(rows.len(), self.order.stacks(point).len(), "one row per stack");
        for (stack, (row, _)) in rows.iter().enumerate() {
            if let Err(message) = self.order.check(row, point, episode, stack, self.seed) {
                panic!("a row of another block: {message}");
            }
        }
        let encoded = Encoded::new(rows);

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

    /// Hands out no more work: what has been taken may still be submitted, the rest is left for the next start.
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
        state.episodes.sync().map_err(ResultsError::io("write", &path))?;
        state.timings.sync().map_err(ResultsError::io("write", &self.path.join(TIMINGS_CSV)))?;
        if state.written < self.order.blocks() {
            return Ok(None);
        }
        store::remove(&self.path.join(EXTENDED_CSV))?;
        let file = File::open(&path).map_err(ResultsError::io("read", &path))?;
        let summary = summarise(BufReader::new(file), self.order.episodes() as usize)
            .map_err(|source| ResultsError::Read { path, source })?;
        let mut bytes = Vec::new();
        write_summary(&mut bytes, self.order.swept(), &summary).expect("writing to memory cannot fail");
        let path = self.path.join(SUMMARY_CSV);
        // A complete folder stays untouched.
        if std::fs::read(&path).ok().as_ref() != Some(&bytes) {
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
            let position = self.order.position(state.written);
            let encoded = match (state.copies(position), &mut state.extended) {
                (Some(ordinal), Some(extended)) => {
                    let lines = extended.lines(ordinal, &self.order);
                    let episodes = lines.map_err(ResultsError::io("read", &self.path.join(EXTENDED_CSV)))?;
                    // Their times are in timings.csv already.
                    Encoded { episodes, timings: Vec::new() }
                }
                _ => match state.waiting.remove(&state.written) {
                    Some(encoded) => encoded,
                    None => break,
                },
            };
            let failed = |name| move |error| ResultsError::io("write", &self.path.join(name))(error);
            state.episodes.append(&encoded.episodes).map_err(failed(EPISODES_CSV))?;
            state.written += 1;
            state.timings.append(&encoded.timings).map_err(failed(TIMINGS_CSV))?;
        }
        Ok(())
    }
}

impl State {
    /// The block's number in the file that is being extended, if it is there.
    fn copies(&self, position: (u32, u64)) -> Option<u64> {
        self.extended.as_ref()?.present.ordinal(position)
    }
}

impl Encoded {
    fn new(rows: &[(Row, Timing)]) -> Self {
        const MEMORY: &str = "writing to memory cannot fail";
        let mut episodes = csv::Writer::from_writer(Vec::new());
        let mut timings = csv::Writer::from_writer(Vec::new());
        for (row, timing) in rows {
            write_row(&mut episodes, row).expect(MEMORY);
            write_timing(&mut timings, row, timing).expect(MEMORY);
        }
        Self { episodes: episodes.into_inner().expect(MEMORY), timings: timings.into_inner().expect(MEMORY) }
    }
}

fn lock(folder: &Path) -> Result<File, ResultsError> {
    let path = folder.join(LOCK);
    let file = File::options().create(true).append(true).open(&path).map_err(ResultsError::io("write", &path))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(ResultsError::Locked { folder: folder.to_owned() }),
        Err(TryLockError::Error(error)) => Err(ResultsError::io("lock", &path)(error)),
    }
}

/// The manifest of the folder, if it is of the same run.
fn recognise(folder: &Path, identity: &Identity) -> Result<Manifest, ResultsError> {
    let foreign = |reason| ResultsError::Foreign { folder: folder.to_owned(), reason };
    let text = std::fs::read_to_string(folder.join(MANIFEST_JSON))
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
    let len = match File::open(path) {
        Ok(mut file) if !is_fresh => store::whole_lines(&mut file).map_err(ResultsError::io("read", path))?,
        _ => 0,
    };
    let mut timings = store::appender(path, len)?;
    if len == 0 {
        timings.append(timings::HEADER.as_bytes()).map_err(ResultsError::io("write", path))?;
    }
    Ok(timings)
}

/// The whole blocks of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Present {
    /// Whole blocks, always the first ones of some order.
    blocks: u64,
    /// Bytes up to the end of the last whole block.
    bytes: u64,
    /// Episodes per point; `None` while there are only rows of the first point, for then any number may follow.
    episodes: Option<u64>,
}

impl Present {
    /// Reads a file; what a kill has cut short at its end is passed over.
    fn scan(path: &Path, order: &Order, seed: u64) -> Result<Self, ResultsError> {
        let mut file = match File::open(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::default()),
            other => other.map_err(ResultsError::io("read", path))?,
        };
        let mut read = || {
            let bytes = store::whole_lines(&mut file).map_err(ReadError::Io)?;
            file.rewind().map_err(ReadError::Io)?;
            if bytes == 0 {
                Self::header_cut_short(&mut file, order)
            } else {
                Self::rows(&mut file, bytes, order, seed)
            }
        };
        read().map_err(|source| ResultsError::Read { path: path.to_owned(), source })
    }

    /// A file without any whole line: nothing, provided that it is the beginning of a header.
    fn header_cut_short(file: &mut File, order: &Order) -> Result<Self, ReadError> {
        let header = header_line(order.swept());
        let mut content = Vec::new();
        file.take(header.len() as u64).read_to_end(&mut content).map_err(ReadError::Io)?;
        if header.starts_with(&content) {
            Ok(Self::default())
        } else {
            Err(ReadError::Line { line: 1, message: format!("expected the column `{}`", COLUMNS[0].name) })
        }
    }

    fn rows(file: &mut File, bytes: u64, order: &Order, seed: u64) -> Result<Self, ReadError> {
        let mut reader = Reader::new(BufReader::new(file.take(bytes)))?;
        if reader.swept() != order.swept() {
            return Err(reader.error(format!(
                "expected the swept keys {:?}, found {:?}",
                order.swept(),
                reader.swept()
            )));
        }
        let mut present = Self { blocks: 0, bytes: reader.offset(), episodes: None };
        // The next row's place; a point ends where the next one begins, or like the first one ended.
        let (mut point, mut episode, mut stack) = (0u32, 0u64, 0usize);
        while let Some(row) = reader.next() {
            let row = row?;
            let is_first_end = point == 0 && episode > 0 && row.point == 1;
            if stack == 0 && (is_first_end || present.episodes == Some(episode)) {
                present.episodes = Some(episode);
                (point, episode) = (point + 1, 0);
            }
            if point as usize == order.points().len() {
                return Err(reader.error("a row beyond the last sweep point".to_owned()));
            }
            order.check(&row, point, episode, stack, seed).map_err(|message| reader.error(message))?;
            stack += 1;
            if stack == order.stacks(point).len() {
                (stack, episode) = (0, episode + 1);
                present.blocks += 1;
                present.bytes = reader.offset();
            }
        }
        Ok(present)
    }

    /// The number here of the block at (point, episode), if it is here.
    ///
    /// Only for a file that has reached its second point.
    fn ordinal(&self, (point, episode): (u32, u64)) -> Option<u64> {
        let episodes = self.episodes.expect("the number of episodes is known");
        let ordinal = u64::from(point) * episodes + episode;
        (episode < episodes && ordinal < self.blocks).then_some(ordinal)
    }
}

/// Where writing goes on.
#[derive(Clone, Copy, Debug, Default)]
struct Start {
    /// Blocks of `episodes.csv` that stay.
    blocks: u64,
    /// Their bytes with the header.
    bytes: u64,
    /// What the file that is being extended holds.
    extended: Option<Present>,
    /// Whether `episodes.csv` is that file and must be set aside first.
    is_to_be_set_aside: bool,
}

impl Start {
    fn find(folder: &Path, order: &Order, seed: u64) -> Result<Self, ResultsError> {
        let asked = order.episodes();
        let too_many = |present| ResultsError::TooManyEpisodes { folder: folder.to_owned(), present, asked };
        let present = Present::scan(&folder.join(EPISODES_CSV), order, seed)?;
        // While only the first point has rows, each block is one of its episodes.
        let least = present.episodes.unwrap_or(present.blocks);
        let here = Self { blocks: present.blocks, bytes: present.bytes, ..Self::default() };

        let extended_path = folder.join(EXTENDED_CSV);
        if extended_path.exists() {
            let extended = Present::scan(&extended_path, order, seed)?;
            let Some(old) = extended.episodes else {
                let reason = format!("{EXTENDED_CSV} holds fewer than two sweep points");
                return Err(ResultsError::Foreign { folder: folder.to_owned(), reason });
            };
            return match present.episodes {
                Some(episodes) if episodes != asked => {
                    Err(ResultsError::UnfinishedExtension { folder: folder.to_owned(), episodes })
                }
                _ if old > asked || least > asked => Err(too_many(if old > asked { old } else { least })),
                _ => Ok(Self { extended: Some(extended), ..here }),
            };
        }
        match present.episodes {
            _ if least > asked => Err(too_many(least)),
            Some(episodes) if episodes < asked => {
                Ok(Self { blocks: 0, bytes: 0, extended: Some(present), is_to_be_set_aside: true })
            }
            _ => Ok(here),
        }
    }
}

/// The file that is being extended, read once from front to back.
#[derive(Debug)]
struct Extended {
    present: Present,
    reader: BufReader<File>,
    /// The block that comes next in the file.
    next: u64,
}

impl Extended {
    fn open(path: &Path, present: Present) -> Result<Self, ResultsError> {
        let open = || {
            let mut reader = BufReader::new(File::open(path)?);
            reader.skip_until(b'\n')?;
            Ok(reader)
        };
        let reader = open().map_err(ResultsError::io("read", path))?;
        Ok(Self { present, reader, next: 0 })
    }

    /// The lines of a block; blocks are asked for in order.
    fn lines(&mut self, ordinal: u64, order: &Order) -> io::Result<Vec<u8>> {
        assert!(self.next <= ordinal, "block {ordinal} after block {}", self.next);
        let episodes = self.present.episodes.expect("the number of episodes is known");
        let mut lines = Vec::new();
        while self.next <= ordinal {
            lines.clear();
            let point = u32::try_from(self.next / episodes).expect("points are numbered with 32 bits");
            for _ in order.stacks(point) {
                self.reader.read_until(b'\n', &mut lines)?;
            }
            self.next += 1;
        }
        Ok(lines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::episode::Outcome;
    use crate::metrics::Metrics;
    use crate::results::order::Point;
    use crate::results::row::Digest;
    use crate::rng::{EpisodeSeed, Purpose};

    const SEED: u64 = 7;

    fn identity(scenario: &str) -> Identity {
        Identity {
            version: "1".to_owned(),
            build: "b".to_owned(),
            seed: SEED,
            stacks: vec!["a".to_owned(), "b".to_owned()],
            scenario_hash: String::new(),
            scenario: scenario.to_owned(),
        }
    }

    /// `points` points; the first has two stacks, the others one.
    fn order(points: usize, episodes: u64) -> Order {
        let point = |index: usize| Point {
            values: vec![format!("0.{index}")],
            stacks: if index == 0 { vec!["a".to_owned(), "b,c".to_owned()] } else { vec!["a".to_owned()] },
        };
        Order::new(vec!["robot.radius_m".to_owned()], (0..points).map(point).collect(), episodes).unwrap()
    }

    /// The rows of a block, a pure function of its place.
    fn rows(block: &Block<'_>, order: &Order) -> Vec<(Row, Timing)> {
        let (point, episode) = (block.point(), block.episode());
        let row = |stack: &String| {
            let mut stream =
                EpisodeSeed { seed: u64::from(point), episode }.stream(Purpose::Planner, stack.len() as u64);
            Row {
                scenario: "s".to_owned(),
                point,
                stack: stack.clone(),
                global: "a_star".to_owned(),
                path: String::new(),
                local: "dwa".to_owned(),
                episode,
                seed: SEED,
                outcome: match stream.index(3) {
                    0 => Outcome::PlannerError { message: "it said \"no\",\nthen fell".to_owned() },
                    _ => Outcome::Success,
                },
                metrics: Metrics { time_s: Some(stream.uniform()), ..Metrics::default() },
                world_digest: Some(Digest(stream.bits())),
                trace_digest: None,
                swept: order.points()[point as usize].values.clone(),
            }
        };
        block.stacks().iter().map(|stack| (row(stack), Timing::default())).collect()
    }

    fn open(path: &Path, points: usize, episodes: u64) -> Result<Folder, ResultsError> {
        Folder::open(path, identity("k: 1"), order(points, episodes), Existing::Continue)
    }

    /// Runs at most `blocks` blocks.
    fn run(folder: &Folder, blocks: u64) -> u64 {
        let mut ran = 0;
        while ran < blocks
            && let Some(block) = folder.take()
        {
            let rows = rows(&block, folder.order());
            folder.submit(block, &rows).unwrap();
            ran += 1;
        }
        ran
    }

    fn content(path: &Path) -> [Vec<u8>; 2] {
        [EPISODES_CSV, SUMMARY_CSV].map(|name| std::fs::read(path.join(name)).unwrap())
    }

    /// What an undisturbed run writes.
    fn undisturbed(points: usize, episodes: u64) -> [Vec<u8>; 2] {
        let directory = tempfile::tempdir().unwrap();
        let folder = open(directory.path(), points, episodes).unwrap();
        assert_eq!(folder.opened(), Opened::Fresh);
        run(&folder, u64::MAX);
        folder.finish().unwrap().unwrap();
        content(directory.path())
    }

    #[test]
    fn a_file_torn_at_any_byte_is_resumed_to_the_same_bytes() {
        let [episodes, _] = &undisturbed(2, 2);
        let directory = tempfile::tempdir().unwrap();
        run(&open(directory.path(), 2, 2).unwrap(), 0);
        let path = directory.path().join(EPISODES_CSV);
        let manifest = std::fs::read(directory.path().join(MANIFEST_JSON)).unwrap();
        let header = episodes.iter().position(|&byte| byte == b'\n').unwrap() + 1;
        let mut fewest_run = u64::MAX;
        // Everything behind the header, and a few places inside it.
        for torn in (0..header).step_by(97).chain(header - 1..=episodes.len()) {
            std::fs::write(&path, &episodes[..torn]).unwrap();
            std::fs::write(directory.path().join(MANIFEST_JSON), &manifest).unwrap();
            let folder = open(directory.path(), 2, 2).unwrap();
            let ran = run(&folder, u64::MAX);
            // Without `finish`, which waits for the disk: the summary is a function of these bytes.
            assert_eq!(std::fs::read(&path).unwrap(), *episodes, "torn at byte {torn}");
            // The more there was, the less is to do.
            assert!(ran <= fewest_run, "torn at byte {torn}: {ran} blocks");
            fewest_run = ran;
        }
        assert_eq!(fewest_run, 0);
    }

    #[test]
    fn a_run_killed_between_blocks_goes_on_where_it_was() {
        let expected = undisturbed(3, 4);
        for killed in 0..=12 {
            let directory = tempfile::tempdir().unwrap();
            // Dropping without `finish` is what a kill leaves.
            assert_eq!(run(&open(directory.path(), 3, 4).unwrap(), killed), killed);
            let folder = open(directory.path(), 3, 4).unwrap();
            let opened = match killed {
                0 => Opened::Fresh,
                12 => Opened::Complete,
                _ => Opened::Resume { blocks_done: killed },
            };
            assert_eq!((folder.opened(), folder.blocks_done()), (opened, killed));
            assert_eq!(run(&folder, u64::MAX), 12 - killed);
            folder.finish().unwrap().unwrap();
            assert_eq!(content(directory.path()), expected);
        }
    }

    #[test]
    fn a_complete_folder_is_left_as_it_is() {
        let directory = tempfile::tempdir().unwrap();
        let folder = open(directory.path(), 1, 3).unwrap();
        run(&folder, u64::MAX);
        let summary = folder.finish().unwrap();
        let files = || {
            [EPISODES_CSV, SUMMARY_CSV, MANIFEST_JSON, TIMINGS_CSV]
                .map(|name| std::fs::read(directory.path().join(name)).unwrap())
        };
        let before = files();
        let folder = open(directory.path(), 1, 3).unwrap();
        assert_eq!(folder.opened(), Opened::Complete);
        assert!(folder.take().is_none());
        assert_eq!(folder.finish().unwrap(), summary);
        assert_eq!(files(), before);
    }

    #[test]
    fn stopping_leaves_a_folder_without_summary_that_goes_on() {
        let directory = tempfile::tempdir().unwrap();
        let folder = open(directory.path(), 1, 5).unwrap();
        run(&folder, 2);
        let taken = folder.take().unwrap();
        folder.stop();
        assert!(folder.take().is_none());
        let rows = rows(&taken, folder.order());
        folder.submit(taken, &rows).unwrap();
        assert_eq!(folder.finish().unwrap(), None);
        assert!(!directory.path().join(SUMMARY_CSV).exists());
        assert_eq!(open(directory.path(), 1, 5).unwrap().opened(), Opened::Resume { blocks_done: 3 });
    }

    #[test]
    fn answers_in_any_order_from_any_thread_make_the_same_bytes() {
        let expected = undisturbed(2, 150);
        for (threads, window) in [(1, 1), (2, 1), (3, 2), (8, 7), (8, WINDOW_BLOCKS)] {
            let directory = tempfile::tempdir().unwrap();
            let folder =
                Folder::open_with_window(directory.path(), identity("k: 1"), order(2, 150), Existing::Continue, window)
                    .unwrap();
            std::thread::scope(|scope| {
                for thread in 0..threads {
                    let folder = &folder;
                    scope.spawn(move || {
                        let mut stream = EpisodeSeed { seed: 3, episode: thread }.stream(Purpose::Planner, 0);
                        while let Some(block) = folder.take() {
                            let rows = rows(&block, folder.order());
                            // Some blocks take long.
                            (0..stream.index(20)).for_each(|_| std::thread::yield_now());
                            let index = block.index();
                            folder.submit(block, &rows).unwrap();
                            let state = folder.state();
                            assert!(state.waiting.len() as u64 <= window && index < state.written + window);
                        }
                    });
                }
            });
            folder.finish().unwrap().unwrap();
            assert_eq!(content(directory.path()), expected);
        }
    }

    #[test]
    fn later_blocks_wait_for_the_first_one() {
        let directory = tempfile::tempdir().unwrap();
        let folder =
            Folder::open_with_window(directory.path(), identity("k: 1"), order(1, 4), Existing::Continue, 3).unwrap();
        let header = header_line(folder.order().swept());
        let blocks: Vec<Block<'_>> = (0..3).map(|_| folder.take().unwrap()).collect();
        for block in blocks.into_iter().rev() {
            assert_eq!(std::fs::read(directory.path().join(EPISODES_CSV)).unwrap(), header);
            let rows = rows(&block, folder.order());
            folder.submit(block, &rows).unwrap();
        }
        run(&folder, u64::MAX);
        folder.finish().unwrap().unwrap();
        assert_eq!(content(directory.path()), undisturbed(1, 4));
    }

    #[test]
    fn a_folder_in_use_is_refused_until_its_owner_ends() {
        let directory = tempfile::tempdir().unwrap();
        let owner = open(directory.path(), 1, 2).unwrap();
        for _ in 0..2 {
            let error = open(directory.path(), 1, 2).unwrap_err();
            assert!(matches!(error, ResultsError::Locked { .. }));
            assert!(error.to_string().contains(&*directory.path().to_string_lossy()), "{error}");
        }
        drop(owner);
        open(directory.path(), 1, 2).unwrap();
    }

    #[test]
    fn another_run_is_refused_with_the_difference_named_until_it_is_to_be_replaced() {
        let directory = tempfile::tempdir().unwrap();
        run(&open(directory.path(), 1, 2).unwrap(), 1);
        let before = std::fs::read(directory.path().join(EPISODES_CSV)).unwrap();
        let open = |existing| Folder::open(directory.path(), identity("k: 2"), order(1, 2), existing);
        let error = open(Existing::Continue).unwrap_err().to_string();
        assert!(error.contains("`k`: 1 there, 2 here") && error.contains("--force"), "{error}");
        assert_eq!(std::fs::read(directory.path().join(EPISODES_CSV)).unwrap(), before);
        let folder = open(Existing::Replace).unwrap();
        assert_eq!(folder.opened(), Opened::Fresh);
        run(&folder, u64::MAX);
        folder.finish().unwrap().unwrap();
        assert_eq!(open(Existing::Continue).unwrap().opened(), Opened::Complete);
        assert_eq!(content(directory.path()), undisturbed(1, 2));
    }

    #[test]
    fn more_episodes_make_the_bytes_of_a_longer_run() {
        for (points, old, new, blocks) in
            [(1, 2, 5, 2), (1, 4, 5, 3), (3, 2, 5, 6), (3, 2, 5, 5), (3, 2, 3, 3), (3, 4, 5, 2)]
        {
            let directory = tempfile::tempdir().unwrap();
            run(&open(directory.path(), points, old).unwrap(), blocks);
            let folder = open(directory.path(), points, new).unwrap();
            assert_eq!(folder.opened(), Opened::Resume { blocks_done: blocks });
            assert_eq!(run(&folder, u64::MAX), points as u64 * new - blocks, "nothing runs twice");
            folder.finish().unwrap().unwrap();
            assert_eq!(content(directory.path()), undisturbed(points, new));
            assert!(!directory.path().join(EXTENDED_CSV).exists());
        }
    }

    #[test]
    fn an_extension_killed_anywhere_is_finished_to_the_same_bytes() {
        let expected = undisturbed(3, 4);
        for killed in 0..6 {
            let directory = tempfile::tempdir().unwrap();
            run(&open(directory.path(), 3, 2).unwrap(), 6);
            run(&open(directory.path(), 3, 4).unwrap(), killed);
            let folder = open(directory.path(), 3, 4).unwrap();
            assert_eq!(folder.opened(), Opened::Resume { blocks_done: 6 + killed });
            assert_eq!(run(&folder, u64::MAX), 6 - killed);
            folder.finish().unwrap().unwrap();
            assert_eq!(content(directory.path()), expected);
        }
        // Killed after the old file was set aside and before the new one was there.
        let directory = tempfile::tempdir().unwrap();
        run(&open(directory.path(), 3, 2).unwrap(), 6);
        std::fs::rename(directory.path().join(EPISODES_CSV), directory.path().join(EXTENDED_CSV)).unwrap();
        let folder = open(directory.path(), 3, 4).unwrap();
        assert_eq!(run(&folder, u64::MAX), 6);
        folder.finish().unwrap().unwrap();
        assert_eq!(content(directory.path()), expected);
    }

    #[test]
    fn another_extension_waits_for_the_first_and_the_old_number_is_always_there() {
        let directory = tempfile::tempdir().unwrap();
        run(&open(directory.path(), 3, 2).unwrap(), 6);
        // Two new episodes of the first point, then the copies up to the next gap: the second point is begun.
        run(&open(directory.path(), 3, 4).unwrap(), 2);
        for asked in [2, 3, 5] {
            let error = open(directory.path(), 3, asked).unwrap_err();
            assert!(matches!(error, ResultsError::UnfinishedExtension { episodes: 4, .. }), "{error}");
        }
        open(directory.path(), 3, 4).unwrap();
    }

    #[test]
    fn fewer_episodes_than_present_are_refused() {
        for (points, blocks) in [(1, 3), (2, 3), (2, 4), (2, 6)] {
            let directory = tempfile::tempdir().unwrap();
            run(&open(directory.path(), points, 3).unwrap(), blocks);
            let error = open(directory.path(), points, 2).unwrap_err();
            assert!(matches!(error, ResultsError::TooManyEpisodes { present: 3, asked: 2, .. }), "{error}");
        }
        // A run that has not come that far may end earlier.
        let directory = tempfile::tempdir().unwrap();
        run(&open(directory.path(), 1, 5).unwrap(), 2);
        assert_eq!(open(directory.path(), 1, 2).unwrap().opened(), Opened::Complete);
    }

    #[test]
    fn rows_that_this_run_would_not_write_are_refused_by_line() {
        let directory = tempfile::tempdir().unwrap();
        let folder = open(directory.path(), 2, 2).unwrap();
        run(&folder, u64::MAX);
        folder.finish().unwrap();
        let path = directory.path().join(EPISODES_CSV);
        let text = std::fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        let without = |gone: usize| {
            let kept: Vec<&str> = lines.iter().enumerate().filter(|(i, _)| *i != gone).map(|(_, line)| *line).collect();
            kept.join("\n") + "\n"
        };
        for (edited, message) in [
            (without(3), "line 4: expected point 0, episode 1, stack `a`, found point 0, episode 1, stack `b,c`"),
            (text.clone() + lines[6] + "\n", "line 8: a row beyond the last sweep point"),
            (text.replace(",7,", ",8,"), "line 2: expected the seed 7, found 8"),
            (text.replace("s,1,a,", "s,1,a,,"), "line 6: expected 44 fields, found 45"),
            (text.replacen("robot.radius_m", "robot.mass_kg", 1), "line 1: expected the swept keys"),
        ] {
            std::fs::write(&path, edited).unwrap();
            let error = open(directory.path(), 2, 2).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        }
    }

    #[test]
    fn rows_without_a_manifest_are_not_touched() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join(EPISODES_CSV);
        std::fs::write(&path, "my,own,table\n").unwrap();
        let error = open(directory.path(), 1, 1).unwrap_err();
        assert!(matches!(error, ResultsError::Foreign { .. }), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"my,own,table\n");
    }

    #[test]
    #[expect(clippy::print_stdout, reason = "a skipped test says so")]
    fn a_bad_path_fails_at_once_and_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("file");
        std::fs::write(&file, "").unwrap();
        let error = open(&file.join("run"), 1, 1).unwrap_err().to_string();
        assert!(error.contains("cannot create") && error.contains("run`"), "{error}");

        let read_only = directory.path().join("read_only");
        std::fs::create_dir(&read_only).unwrap();
        let mut permissions = std::fs::metadata(&read_only).unwrap().permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(&read_only, permissions).unwrap();
        if File::create(read_only.join("probe")).is_ok() {
            println!("skipped: this user may write to read-only folders");
            return;
        }
        let error = open(&read_only, 1, 1).unwrap_err().to_string();
        assert!(error.contains("cannot write") && error.contains("read_only"), "{error}");
    }

    #[test]
    #[expect(clippy::print_stdout, reason = "a skipped test says so")]
    fn a_full_disk_fails_the_run_and_leaves_whole_blocks() {
        // Linux has a file that is always full.
        let full = Path::new("/dev/full");
        if !full.exists() {
            println!("skipped: no /dev/full here");
            return;
        }
        let directory = tempfile::tempdir().unwrap();
        let folder = open(directory.path(), 1, 4).unwrap();
        run(&folder, 2);
        let [third, fourth] = [folder.take().unwrap(), folder.take().unwrap()];
        let whole = std::fs::read(directory.path().join(EPISODES_CSV)).unwrap();
        folder.state().timings = full_disk(full);
        folder.state().episodes = full_disk(full);
        let answer = rows(&third, folder.order());
        let error = folder.submit(third, &answer).unwrap_err();
        assert!(matches!(error, ResultsError::Io { action: "write", .. }), "{error}");
        let answer = rows(&fourth, folder.order());
        assert!(matches!(folder.submit(fourth, &answer), Err(ResultsError::Failed(_))));
        assert!(folder.take().is_none());
        assert!(matches!(folder.finish(), Err(ResultsError::Failed(_))));
        assert_eq!(std::fs::read(directory.path().join(EPISODES_CSV)).unwrap(), whole);
        let folder = open(directory.path(), 1, 4).unwrap();
        assert_eq!(run(&folder, u64::MAX), 2);
        folder.finish().unwrap().unwrap();
        assert_eq!(content(directory.path()), undisturbed(1, 4));
    }

    fn full_disk(path: &Path) -> Appender<File> {
        Appender::unchecked(File::options().append(true).open(path).unwrap())
    }

    #[test]
    fn a_block_that_is_given_up_ends_the_run_for_the_workers_that_wait() {
        let directory = tempfile::tempdir().unwrap();
        let folder =
            Folder::open_with_window(directory.path(), identity("k: 1"), order(1, 4), Existing::Continue, 1).unwrap();
        std::thread::scope(|scope| {
            let first = folder.take().unwrap();
            let waiting = scope.spawn(|| folder.take().is_none());
            drop(first);
            assert!(waiting.join().unwrap());
        });
        let error = folder.finish().unwrap_err().to_string();
        assert!(error.contains("point 0, episode 0 was given up"), "{error}");
    }

    #[test]
    #[should_panic(expected = "a row of another block")]
    fn rows_in_another_order_are_a_bug() {
        let directory = tempfile::tempdir().unwrap();
        let folder = open(directory.path(), 1, 1).unwrap();
        let block = folder.take().unwrap();
        let mut rows = rows(&block, folder.order());
        rows.reverse();
        let _ = folder.submit(block, &rows);
    }

    #[test]
    fn a_swept_key_named_like_a_column_is_refused() {
        for keys in [vec!["seed"], vec!["robot.radius_m", "robot.radius_m"]] {
            let keys: Vec<String> = keys.into_iter().map(str::to_owned).collect();
            let point = Point { values: keys.clone(), stacks: vec!["a".to_owned()] };
            assert!(matches!(Order::new(keys, vec![point], 1), Err(ResultsError::SweptKey(_))));
        }
    }

    #[test]
    fn the_manifest_remembers_every_start_and_timings_have_a_row_per_row() {
        let directory = tempfile::tempdir().unwrap();
        run(&open(directory.path(), 2, 3).unwrap(), 1);
        let timings = directory.path().join(TIMINGS_CSV);
        let mut torn = std::fs::read(&timings).unwrap();
        torn.extend(b"0,a,1,0.0");
        std::fs::write(&timings, torn).unwrap();
        let folder = open(directory.path(), 2, 3).unwrap();
        run(&folder, u64::MAX);
        folder.finish().unwrap();
        let manifest: Manifest =
            serde_json::from_slice(&std::fs::read(directory.path().join(MANIFEST_JSON)).unwrap()).unwrap();
        assert_eq!((manifest.identity, manifest.episodes, manifest.launches.len()), (identity("k: 1"), 3, 2));
        // 2 · 3 rows of the first point, 3 of the second.
        let keys: Vec<String> = csv::Reader::from_path(&timings)
            .unwrap()
            .records()
            .map(|record| record.unwrap().iter().take(3).collect::<Vec<_>>().join(" "))
            .collect();
        assert_eq!(keys, ["0 a 0", "0 b,c 0", "0 a 1", "0 b,c 1", "0 a 2", "0 b,c 2", "1 a 0", "1 a 1", "1 a 2"]);
    }
}
