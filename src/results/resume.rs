//! Whole blocks left by an interrupted or shorter run, and the place at which writing goes on.

use super::columns::COLUMNS;
use super::csv_rows::{Reader, header_line};
use super::journal::{EPISODES_CSV, EXTENDED_CSV, EXTENDED_STATES_CSV, STATES_CSV};
use super::order::Order;
use super::states::StateLines;
use super::{ReadError, ResultsError, store};
use crate::episode::Outcome;
use crate::files;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::Path;

/// The tables of a run under the byte contract: their rows belong to blocks.
const TABLES: [&str; 2] = [EPISODES_CSV, STATES_CSV];
/// The tables of the run that is being extended.
const EXTENDED: [&str; 2] = [EXTENDED_CSV, EXTENDED_STATES_CSV];

/// The blocks that are whole in both tables.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Present {
    /// Whole blocks, always the first ones of some order.
    pub(super) blocks: u64,
    /// Bytes of the episodes up to the end of the last whole block.
    pub(super) bytes: u64,
    /// Bytes of the states up to the end of the last whole block.
    pub(super) states_bytes: u64,
    /// Numbers of the blocks with a drive that was given up, which are to be driven again.
    pub(super) given_up: BTreeSet<u64>,
    /// Episodes per point; `None` while only the first point has rows, since any number may follow.
    pub(super) episodes: Option<u64>,
}

impl Present {
    /// Reads two tables; an incomplete end of either, left by a kill, is skipped.
    fn scan(folder: &Path, tables: [&str; 2], order: &Order, seed: u64) -> Result<Self, ResultsError> {
        let [path, states_path] = tables.map(|name| folder.join(name));
        let Some(mut file) = open(&path)? else { return Ok(Self::default()) };
        let states = match open(&states_path)? {
            Some(file) => StateLines::new(BufReader::new(file)).map_err(ResultsError::io("read", &states_path))?,
            None => None,
        };
        let read = || {
            let bytes = store::whole_lines(&mut file).map_err(ReadError::Io)?;
            file.rewind().map_err(ReadError::Io)?;
            if bytes == 0 {
                Self::header_cut_short(&mut file, order)
            } else {
                Self::rows(&mut file, bytes, states, order, seed)
            }
        };
        read().map_err(|source| ResultsError::Read { path, source })
    }

    /// Result for a file without any whole line: no blocks, provided that it is the beginning of a header.
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

    fn rows(
        file: &mut File,
        bytes: u64,
        mut states: Option<StateLines<BufReader<File>>>,
        order: &Order,
        seed: u64,
    ) -> Result<Self, ReadError> {
        let mut reader = Reader::new(BufReader::new(file.take(bytes)))?;
        if reader.swept() != order.swept() {
            return Err(reader.error(format!(
                "expected the swept keys {:?}, found {:?}",
                order.swept(),
                reader.swept()
            )));
        }
        if let Some(column) = reader.missing().first() {
            return Err(reader.error(format!("the column `{column}` is missing: an older version wrote the table")));
        }
        let states_bytes = states.as_ref().map_or(0, StateLines::offset);
        let mut present =
            Self { blocks: 0, bytes: reader.offset(), states_bytes, given_up: BTreeSet::new(), episodes: None };
        // The next row's place among the points with rows; a point ends where the next one begins, or like the first one ended.
        let (mut place, mut episode, mut stack) = (0u64, 0u64, 0usize);
        // Blocks are whole up to the first one whose states are not; the rows behind it are checked all the same.
        let mut times: Vec<(String, f64)> = Vec::new();
        let mut is_given_up = false;
        while let Some(row) = reader.next() {
            let row = row?;
            let is_first_end = place == 0 && episode > 0 && order.driven(1) == Some(row.point);
            if stack == 0 && (is_first_end || present.episodes == Some(episode)) {
                present.episodes = Some(episode);
                (place, episode) = (place + 1, 0);
            }
            let Some(point) = order.driven(place) else {
                return Err(reader.error("a row beyond the last sweep point".to_owned()));
            };
            order.check(&row, point, episode, stack, seed).map_err(|message| reader.error(message))?;
            stack += 1;
            is_given_up |= matches!(row.outcome, Outcome::GaveUp { .. });
            times.push((row.stack, row.metrics.time_s.unwrap_or_default()));
            if stack == order.stacks(point).len() {
                if let Some(lines) = &mut states
                    && lines.is_whole(point, episode, &times).map_err(ReadError::Io)?
                {
                    if is_given_up {
                        present.given_up.insert(present.blocks);
                    }
                    present.blocks += 1;
                    (present.bytes, present.states_bytes) = (reader.offset(), lines.offset());
                } else {
                    states = None;
                }
                times.clear();
                is_given_up = false;
                (stack, episode) = (0, episode + 1);
            }
        }
        Ok(present)
    }

    /// Number in these tables of the block at (point, episode); `None` if they do not hold it, or a drive in it was given up.
    ///
    /// Valid only for a file that has reached its second point.
    pub(super) fn ordinal(&self, order: &Order, (point, episode): (u32, u64)) -> Option<u64> {
        let episodes = self.episodes.expect("the number of episodes is known");
        let ordinal = order.place(point) * episodes + episode;
        (episode < episodes && ordinal < self.blocks && !self.given_up.contains(&ordinal)).then_some(ordinal)
    }
}

fn open(path: &Path) -> Result<Option<File>, ResultsError> {
    match files::open(path, u64::MAX) {
        Err(error) if error.is_missing() => Ok(None),
        other => other.map(Some).map_err(ResultsError::io("read", path)),
    }
}

/// Place at which writing goes on.
#[derive(Clone, Debug, Default)]
pub(super) struct Start {
    /// Number of blocks of `episodes.csv` that stay.
    pub(super) blocks: u64,
    /// Bytes of these blocks, with the header.
    pub(super) bytes: u64,
    /// Bytes of the states of these blocks, with the header.
    pub(super) states_bytes: u64,
    /// Whole blocks of the file that is being extended.
    pub(super) extended: Option<Present>,
    /// Whether `episodes.csv` is that file and must be set aside first.
    pub(super) is_to_be_set_aside: bool,
}

impl Start {
    pub(super) fn find(folder: &Path, order: &Order, seed: u64) -> Result<Self, ResultsError> {
        let asked = order.episodes();
        let too_many = |present| ResultsError::TooManyEpisodes { folder: folder.to_owned(), present, asked };
        restore(folder)?;
        let present = Present::scan(folder, TABLES, order, seed)?;
        // While only the first point has rows, each block is one of its episodes.
        let least = present.episodes.unwrap_or(present.blocks);
        let Present { blocks, bytes, states_bytes, .. } = present;
        let here = Self { blocks, bytes, states_bytes, ..Self::default() };

        if folder.join(EXTENDED_CSV).exists() {
            let extended = Present::scan(folder, EXTENDED, order, seed)?;
            // Tables of one point alone are set aside only to drive again what was given up: each block is an episode of that point.
            let old = extended.episodes.unwrap_or(extended.blocks);
            let extended = Present { episodes: Some(extended.episodes.unwrap_or(asked)), ..extended };
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
                Ok(Self { extended: Some(present), is_to_be_set_aside: true, ..Self::default() })
            }
            episodes if !present.given_up.is_empty() => {
                let present = Present { episodes: Some(episodes.unwrap_or(asked)), ..present };
                Ok(Self { extended: Some(present), is_to_be_set_aside: true, ..Self::default() })
            }
            _ => Ok(here),
        }
    }
}

/// Sets the tables aside for an extension, the states first: alone they are not an extension yet.
pub(super) fn set_aside(folder: &Path) -> Result<(), ResultsError> {
    rename(folder, STATES_CSV, EXTENDED_STATES_CSV)?;
    rename(folder, EPISODES_CSV, EXTENDED_CSV)
}

/// Undoes a setting aside that was interrupted by a kill.
fn restore(folder: &Path) -> Result<(), ResultsError> {
    if folder.join(EXTENDED_STATES_CSV).exists() && !folder.join(EXTENDED_CSV).exists() {
        rename(folder, EXTENDED_STATES_CSV, STATES_CSV)?;
    }
    Ok(())
}

/// Removes the tables that were set aside, in an order in which a kill never leaves the states alone.
pub(super) fn forget(folder: &Path) -> Result<(), ResultsError> {
    store::remove(&folder.join(EXTENDED_STATES_CSV))?;
    store::remove(&folder.join(EXTENDED_CSV))
}

fn rename(folder: &Path, from: &str, to: &str) -> Result<(), ResultsError> {
    let from = folder.join(from);
    std::fs::rename(&from, folder.join(to)).map_err(ResultsError::io("rename", &from))
}

/// The tables that are being extended, read once from front to back.
#[derive(Debug)]
pub(super) struct Extended {
    pub(super) present: Present,
    reader: BufReader<File>,
    states: StateLines<BufReader<File>>,
    /// The block that comes next in the tables.
    next: u64,
}

impl Extended {
    pub(super) fn open(folder: &Path, present: Present) -> Result<Self, ResultsError> {
        let [path, states_path] = EXTENDED.map(|name| folder.join(name));
        let episodes = || -> io::Result<_> {
            let mut reader = BufReader::new(files::open(&path, u64::MAX)?);
            reader.skip_until(b'\n')?;
            Ok(reader)
        };
        let states = || -> io::Result<_> {
            let lines = StateLines::new(BufReader::new(files::open(&states_path, u64::MAX)?))?;
            Ok(lines.expect("the header was there when the file was scanned"))
        };
        let reader = episodes().map_err(ResultsError::io("read", &path))?;
        let states = states().map_err(ResultsError::io("read", &states_path))?;
        Ok(Self { present, reader, states, next: 0 })
    }

    /// The lines of a block, of its episodes and of its states; blocks are asked for in order.
    pub(super) fn lines(&mut self, ordinal: u64, order: &Order) -> io::Result<(Vec<u8>, Vec<u8>)> {
        assert!(self.next <= ordinal, "block {ordinal} after block {}", self.next);
        let episodes = self.present.episodes.expect("the number of episodes is known");
        let (mut lines, mut states) = (Vec::new(), Vec::new());
        while self.next <= ordinal {
            lines.clear();
            let point = order.driven(self.next / episodes).expect("the file was scanned in this order");
            for _ in order.stacks(point) {
                self.reader.read_until(b'\n', &mut lines)?;
            }
            states = self.states.block(point, self.next % episodes)?;
            self.next += 1;
        }
        Ok((lines, states))
    }
}
