//! What an interrupted or shorter run has left, and where writing goes on.

use super::columns::COLUMNS;
use super::csv_rows::{Reader, header_line};
use super::journal::{EPISODES_CSV, EXTENDED_CSV};
use super::order::Order;
use super::{ReadError, ResultsError, store};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::Path;

/// The whole blocks of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Present {
    /// Whole blocks, always the first ones of some order.
    pub(super) blocks: u64,
    /// Bytes up to the end of the last whole block.
    pub(super) bytes: u64,
    /// Episodes per point; `None` while there are only rows of the first point, for then any number may follow.
    pub(super) episodes: Option<u64>,
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
        // The next row's place among the points with rows; a point ends where the next one begins, or like the first one ended.
        let (mut place, mut episode, mut stack) = (0u64, 0u64, 0usize);
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
    pub(super) fn ordinal(&self, order: &Order, (point, episode): (u32, u64)) -> Option<u64> {
        let episodes = self.episodes.expect("the number of episodes is known");
        let ordinal = order.place(point) * episodes + episode;
        (episode < episodes && ordinal < self.blocks).then_some(ordinal)
    }
}

/// Where writing goes on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Start {
    /// Blocks of `episodes.csv` that stay.
    pub(super) blocks: u64,
    /// Their bytes with the header.
    pub(super) bytes: u64,
    /// What the file that is being extended holds.
    pub(super) extended: Option<Present>,
    /// Whether `episodes.csv` is that file and must be set aside first.
    pub(super) is_to_be_set_aside: bool,
}

impl Start {
    pub(super) fn find(folder: &Path, order: &Order, seed: u64) -> Result<Self, ResultsError> {
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
pub(super) struct Extended {
    pub(super) present: Present,
    reader: BufReader<File>,
    /// The block that comes next in the file.
    next: u64,
}

impl Extended {
    pub(super) fn open(path: &Path, present: Present) -> Result<Self, ResultsError> {
        let open = || {
            let mut reader = BufReader::new(File::open(path)?);
            reader.skip_until(b'\n')?;
            Ok(reader)
        };
        let reader = open().map_err(ResultsError::io("read", path))?;
        Ok(Self { present, reader, next: 0 })
    }

    /// The lines of a block; blocks are asked for in order.
    pub(super) fn lines(&mut self, ordinal: u64, order: &Order) -> io::Result<Vec<u8>> {
        assert!(self.next <= ordinal, "block {ordinal} after block {}", self.next);
        let episodes = self.present.episodes.expect("the number of episodes is known");
        let mut lines = Vec::new();
        while self.next <= ordinal {
            lines.clear();
            let point = order.driven(self.next / episodes).expect("the file was scanned in this order");
            for _ in order.stacks(point) {
                self.reader.read_until(b'\n', &mut lines)?;
            }
            self.next += 1;
        }
        Ok(lines)
    }
}
