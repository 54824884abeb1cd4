//! Writes that survive a kill or a full disk.

use super::ResultsError;
use super::identity::host;
use crate::clock::Stopwatch;
use crate::files::{self, LineFeeds};
use std::fs::{File, TryLockError};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// Lock file of a folder. The file stays; the lock is released when its owner ends, in whatever way.
const LOCK: &str = ".lock";

/// Least time between two synchronisations with the disk, s.
const SYNC_INTERVAL_S: f64 = 1.0;

/// Storage to which blocks are appended: a file, or a stand-in in tests.
pub(super) trait Storage: Write {
    /// Shortens the file to `len` bytes; the next write follows there.
    fn cut(&mut self, len: u64) -> io::Result<()>;
    /// Brings everything to the disk.
    fn sync(&mut self) -> io::Result<()>;
}

/// A file opened for appending: writes go to its end, wherever a cut has moved it.
impl Storage for File {
    fn cut(&mut self, len: u64) -> io::Result<()> {
        self.set_len(len)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.sync_data()
    }
}

/// Appends blocks, each whole or not at all.
#[derive(Debug)]
pub(super) struct Appender<S> {
    storage: S,
    /// Bytes of whole blocks.
    len: u64,
    is_dirty: bool,
    since_sync: Stopwatch,
}

impl<S: Storage> Appender<S> {
    /// Goes on behind the first `len` bytes; what follows them is cut.
    pub fn new(mut storage: S, len: u64) -> io::Result<Self> {
        storage.cut(len)?;
        Ok(Self { storage, len, is_dirty: false, since_sync: Stopwatch::start() })
    }

    /// An appender to a storage that cannot be cut.
    #[cfg(test)]
    pub fn unchecked(storage: S) -> Self {
        Self { storage, len: 0, is_dirty: false, since_sync: Stopwatch::start() }
    }

    /// Appends a block with one write and syncs if the last time is long ago.
    ///
    /// # Errors
    /// If the block could not be written completely; the part written is cut off again.
    pub fn append(&mut self, block: &[u8]) -> io::Result<()> {
        // One write as a rule; more only where the system took a part of it.
        if let Err(error) = self.storage.write_all(block) {
            // If this fails too, the next start cuts the incomplete block.
            let _ = self.storage.cut(self.len);
            return Err(error);
        }
        self.len += block.len() as u64;
        self.is_dirty = true;
        if self.since_sync.elapsed_s() >= SYNC_INTERVAL_S { self.sync() } else { Ok(()) }
    }

    /// Brings everything appended to the disk.
    pub fn sync(&mut self) -> io::Result<()> {
        if self.is_dirty {
            self.storage.sync()?;
            self.is_dirty = false;
            self.since_sync = Stopwatch::start();
        }
        Ok(())
    }
}

/// Opens a file for appending, creates it if it is not there, and keeps its first `len` bytes.
pub(super) fn appender(path: &Path, len: u64) -> Result<Appender<File>, ResultsError> {
    let open = || Appender::new(File::options().create(true).append(true).open(path)?, len);
    open().map_err(ResultsError::io("write", path))
}

/// Bytes up to and including the last newline.
pub(super) fn whole_lines(file: &mut File) -> io::Result<u64> {
    const STEP: u64 = 1 << 16;
    let mut end = file.seek(SeekFrom::End(0))?;
    let mut buffer = Vec::new();
    while end > 0 {
        let begin = end.saturating_sub(STEP);
        buffer.clear();
        file.seek(SeekFrom::Start(begin))?;
        Read::by_ref(file).take(end - begin).read_to_end(&mut buffer)?;
        if let Some(last) = buffer.iter().rposition(|&byte| byte == b'\n') {
            return Ok(begin + last as u64 + 1);
        }
        end = begin;
    }
    Ok(0)
}

/// Hold on a folder, for as long as it lives.
#[derive(Debug)]
pub(super) struct Hold {
    _file: Option<File>,
    /// Why nothing can be written here; what is complete can be read all the same.
    pub(super) read_only: Option<ResultsError>,
    /// Whether the lock keeps others away: some file systems have none.
    pub(super) is_guarded: bool,
}

/// Locks a folder. The lock is the system's own, on an open file: whoever held it and has ended, in whatever way, holds it no more.
/// A folder that may only be read is locked if there is a lock file; a run that writes it is noticed by that.
pub(super) fn lock(folder: &Path) -> Result<Hold, ResultsError> {
    let path = folder.join(LOCK);
    let mut hold = Hold { _file: None, read_only: None, is_guarded: true };
    let locked = match File::options().create(true).read(true).write(true).truncate(false).open(&path) {
        Ok(mut file) => {
            let locked = file.try_lock();
            if locked.is_ok() {
                // For whoever waits; the lock holds without it, as on a full disk.
                let _ = file.set_len(0).and_then(|()| writeln!(file, "process {} on {}", std::process::id(), host()));
            }
            hold._file = Some(file);
            locked
        }
        Err(error) if matches!(error.kind(), io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem) => {
            hold.read_only = Some(ResultsError::io("write", &path)(error));
            match files::open(&path, LOCK_BYTES_MAX) {
                Ok(file) => {
                    let locked = file.try_lock_shared();
                    hold._file = Some(file);
                    locked
                }
                Err(_) => Ok(()),
            }
        }
        Err(error) => return Err(ResultsError::io("write", &path)(error)),
    };
    match locked {
        Ok(()) => Ok(hold),
        Err(TryLockError::WouldBlock) => Err(ResultsError::Locked { folder: folder.to_owned(), holder: holder(&path) }),
        Err(TryLockError::Error(error)) if has_no_locks(&error) => Ok(Hold { is_guarded: false, ..hold }),
        Err(TryLockError::Error(error)) => Err(ResultsError::io("lock", &path)(error)),
    }
}

/// Largest number of bytes of a lock file.
const LOCK_BYTES_MAX: u64 = 1 << 10;

/// Who holds a lock, by what its holder wrote.
fn holder(lock: &Path) -> String {
    let said = files::text(lock, LOCK_BYTES_MAX).unwrap_or_default();
    let said: String = said.lines().next().unwrap_or_default().chars().filter(|c| !c.is_control()).collect();
    if said.is_empty() { "another run".to_owned() } else { said }
}

/// Whether an error says that the file system knows no locks, as some network file systems.
fn has_no_locks(error: &io::Error) -> bool {
    /// ENOLCK, which has no kind of its own.
    const NO_LOCKS: i32 = 37;
    error.kind() == io::ErrorKind::Unsupported || (cfg!(target_os = "linux") && error.raw_os_error() == Some(NO_LOCKS))
}

/// What tells the file at a path from every other; `None` if there is none. Where the system numbers no files, one is like another.
pub(super) fn place(path: &Path) -> Option<(u64, u64)> {
    let found = std::fs::metadata(path).ok()?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        Some((found.dev(), found.ino()))
    }
    #[cfg(not(unix))]
    {
        let _ = found;
        Some((0, 0))
    }
}

/// Brings the names in a folder to the disk: a file that is synced may still lose its name. Elsewhere than on Unix folders cannot be synced.
pub(super) fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::options().read(true).open(folder)?.sync_all() } else { Ok(()) }
}

/// Puts a file in place as a whole: a reader sees the old content or the new, never a part.
pub(crate) fn put(path: &Path, content: &[u8]) -> io::Result<()> {
    let fresh = path.with_extension(FRESH);
    let mut file = File::create(&fresh)?;
    file.write_all(content)?;
    file.sync_all()?;
    std::fs::rename(&fresh, path)
}

/// Extension of a file that is not in place yet.
const FRESH: &str = "new";

/// Puts a file in place as a whole, and brings its name to the disk as well.
pub(super) fn replace(path: &Path, content: &[u8]) -> Result<(), ResultsError> {
    let write = || put(path, content).and_then(|()| path.parent().map_or(Ok(()), sync_folder));
    write().map_err(ResultsError::io("write", path))
}

/// Removes the traces in a folder that are not to be kept; what no run has written there stays.
pub(super) fn remove_traces(folder: &Path, is_kept: impl Fn(&Path) -> bool) -> Result<(), ResultsError> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for entry in entries {
        let path = entry.map_err(ResultsError::io("read", folder))?.path();
        if is_trace(&path) && !is_kept(&path) {
            remove(&path)?;
        }
    }
    Ok(())
}

/// Whether a file is called as a run calls a trace: `e000017_dwa.csv`, `p0003_e000017_dwa.lidar.csv`, or not in place yet.
fn is_trace(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let number = |text: &str, letter: char| {
        let rest = text.strip_prefix(letter)?;
        let (digits, rest) = rest.split_once('_')?;
        (!digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit())).then(|| rest.to_owned())
    };
    let episode = number(&name, 'p').unwrap_or_else(|| name.to_string());
    let is_ours = path.extension().is_some_and(|extension| extension == "csv" || extension == FRESH);
    is_ours && number(&episode, 'e').is_some()
}

/// Longest beginning of a table in which its first line is looked for, bytes.
const HEADER_BYTES_MAX: u64 = 1 << 16;

/// Puts the line ends of a table back that something else has turned into CR LF or CR, as git and editors do, and takes a byte order
/// mark away: rows are appended and compared byte by byte. A table in order stays untouched.
pub(super) fn restore_line_feeds(path: &Path) -> Result<(), ResultsError> {
    let mut table = match files::open(path, u64::MAX) {
        Err(error) if error.is_missing() => return Ok(()),
        other => BufReader::new(other.map_err(ResultsError::io("read", path))?),
    };
    let mut header = Vec::new();
    let read = Read::by_ref(&mut table).take(HEADER_BYTES_MAX).read_until(b'\n', &mut header);
    read.map_err(ResultsError::io("read", path))?;
    // A run writes neither: in texts every control character is a space.
    if !header.contains(&b'\r') && !header.starts_with(files::MARK) {
        return Ok(());
    }
    let fresh = path.with_extension("new");
    let restore = || {
        table.rewind()?;
        let mut file = File::create(&fresh)?;
        io::copy(&mut LineFeeds::new(table), &mut file)?;
        file.sync_all()?;
        std::fs::rename(&fresh, path)
    };
    restore().map_err(ResultsError::io("write", path))
}

/// Removes a file if it is there.
pub(super) fn remove(path: &Path) -> Result<(), ResultsError> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(ResultsError::io("remove", path)(error)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_system_without_locks_is_known_by_its_errors() {
        assert!(has_no_locks(&io::ErrorKind::Unsupported.into()));
        #[cfg(target_os = "linux")]
        for (number, expected) in [(37, true), (95, true), (38, true), (13, false), (28, false)] {
            // ENOLCK, EOPNOTSUPP, ENOSYS; EACCES, ENOSPC.
            assert_eq!(has_no_locks(&io::Error::from_raw_os_error(number)), expected, "{number}");
        }
    }

    #[test]
    fn traces_are_known_by_their_names() {
        for name in ["e000017_dwa.csv", "p0003_e000017_a_star+dwa.lidar.csv", "e1000000_x.new"] {
            assert!(is_trace(Path::new(name)), "{name}");
        }
        for name in ["episodes.csv", "e_mine.csv", "e000017_dwa.svg", "p3_mine.csv", "e12.csv", "notes.new"] {
            assert!(!is_trace(Path::new(name)), "{name}");
        }
    }

    /// A disk with room for a given number of bytes.
    struct SmallDisk {
        content: Vec<u8>,
        room: usize,
    }

    impl Write for SmallDisk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let taken = bytes.len().min(self.room - self.content.len());
            if taken == 0 && !bytes.is_empty() {
                return Err(io::ErrorKind::StorageFull.into());
            }
            self.content.extend(&bytes[..taken]);
            Ok(taken)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Storage for &mut SmallDisk {
        fn cut(&mut self, len: u64) -> io::Result<()> {
            self.content.truncate(len as usize);
            Ok(())
        }

        fn sync(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_block_that_the_disk_takes_in_part_is_cut_back() {
        for room in 0..16 {
            let mut disk = SmallDisk { content: b"head\n".to_vec(), room: 5 + room };
            let mut appender = Appender::new(&mut disk, 5).unwrap();
            let blocks: [&[u8]; 3] = [b"one\n", b"two\n", b"three\n"];
            let results = blocks.map(|block| appender.append(block).map_err(|error| error.kind()));
            // Blocks of 4, 4 and 6 bytes; a later, smaller one never slips in behind a failed one here.
            let whole = [4, 8, 14].iter().filter(|&&end| end <= room).count();
            for (index, result) in results.iter().enumerate() {
                assert_eq!(
                    *result,
                    if index < whole { Ok(()) } else { Err(io::ErrorKind::StorageFull) },
                    "room {room}"
                );
            }
            assert_eq!(disk.content, [b"head\n", blocks[..whole].concat().as_slice()].concat());
        }
    }

    #[test]
    fn whole_lines_end_at_the_last_newline_however_far_back_it_is() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("file");
        for (content, expected) in [
            (Vec::new(), 0),
            (b"abc".to_vec(), 0),
            (b"abc\n".to_vec(), 4),
            ([b"abc\n".to_vec(), vec![b'x'; 200_000]].concat(), 4),
            ([vec![b'x'; 65_536], b"\n".to_vec(), vec![b'y'; 65_535]].concat(), 65_537),
        ] {
            std::fs::write(&path, &content).unwrap();
            assert_eq!(whole_lines(&mut File::open(&path).unwrap()).unwrap(), expected);
        }
    }
}
