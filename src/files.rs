//! Reading files: the one place at which simrun opens what others wrote.
//!
//! What is no regular file is refused before it is opened (a pipe would wait for ever, a device never ends), what is larger than
//! its reader allows before anything is allocated. Texts come out one way, whoever saved them: without a byte order mark, their
//! lines ended by a line feed where the file has CR LF or CR, and in UTF-8, or the error names the line that is not. Lines and
//! columns of later errors are therefore those that an editor shows.

use crate::digest::{Digest, Fnv1a};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// Reason why a file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The system refused.
    #[error(transparent)]
    System(#[from] io::Error),
    /// It is no regular file.
    #[error("found {found}, expected a regular file")]
    Kind {
        /// What it is.
        found: &'static str,
    },
    /// It is too large for what it should be.
    #[error("found {}{}, expected at most {}", if *is_whole { "" } else { "more than " }, size(*bytes), size(*bytes_max))]
    TooLarge {
        /// Bytes found.
        bytes: u64,
        /// Whether these are all, which is unknown of a file that the system makes as it is read.
        is_whole: bool,
        /// Most bytes that its reader allows.
        bytes_max: u64,
    },
    /// It is no UTF-8 text.
    #[error("line {line}, column {column}: found the byte 0x{byte:02X}, expected UTF-8 text; save the file as UTF-8")]
    NotUtf8 {
        /// Number of the line, from 1.
        line: usize,
        /// Character in the line, from 1.
        column: usize,
        /// The first byte that belongs to no character.
        byte: u8,
    },
    /// It is a text in another encoding, as its byte order mark says.
    #[error("line 1, column 1: found text in UTF-{bits}, expected UTF-8 text; save the file as UTF-8")]
    OtherUtf {
        /// 16 or 32.
        bits: u8,
    },
}

impl FileError {
    /// Whether there is no such file.
    pub fn is_missing(&self) -> bool {
        matches!(self, Self::System(error) if error.kind() == io::ErrorKind::NotFound)
    }
}

impl From<FileError> for io::Error {
    fn from(error: FileError) -> Self {
        match error {
            FileError::System(error) => error,
            other => Self::new(io::ErrorKind::InvalidData, other),
        }
    }
}

/// Bytes in words: whole numbers of the largest unit that has one digit before the point.
pub(crate) fn size(bytes: u64) -> String {
    match bytes {
        1 => "1 byte".to_owned(),
        0..1024 => format!("{bytes} bytes"),
        _ => {
            let power = bytes.ilog2() / 10;
            let tenths = u128::from(bytes) * 10 / (1 << (10 * power));
            let unit = ["", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"][power as usize];
            let fraction = if tenths.is_multiple_of(10) { String::new() } else { format!(".{}", tenths % 10) };
            format!("{}{fraction} {unit}", tenths / 10)
        }
    }
}

/// What a file is that is no regular one.
fn kind(file: &std::fs::FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if file.is_fifo() {
            return "a named pipe";
        }
        if file.is_char_device() || file.is_block_device() {
            return "a device";
        }
        if file.is_socket() {
            return "a socket";
        }
    }
    if file.is_dir() { "a folder" } else { "no file" }
}

/// Number of bytes of a regular file; 0 for anything else.
pub(crate) fn length(file: &Path) -> u64 {
    std::fs::metadata(file).ok().filter(std::fs::Metadata::is_file).map_or(0, |found| found.len())
}

/// Opens a regular file of at most `bytes_max` bytes. Whoever reads on must bound what it allocates by itself.
///
/// # Errors
/// [`FileError::System`], [`FileError::Kind`] and [`FileError::TooLarge`].
pub fn open(file: &Path, bytes_max: u64) -> Result<File, FileError> {
    let regular = |found: std::fs::Metadata| {
        let found_type = found.file_type();
        if !found_type.is_file() {
            return Err(FileError::Kind { found: kind(&found_type) });
        }
        if found.len() > bytes_max {
            return Err(FileError::TooLarge { bytes: found.len(), is_whole: true, bytes_max });
        }
        Ok(())
    };
    // Opening a pipe would wait for somebody to write to it.
    regular(std::fs::metadata(file)?)?;
    let opened = File::open(file)?;
    regular(opened.metadata()?)?;
    Ok(opened)
}

/// Reads a regular file of at most `bytes_max` bytes.
///
/// # Errors
/// As [`open`].
pub fn bytes(file: &Path, bytes_max: u64) -> Result<Vec<u8>, FileError> {
    let opened = open(file, bytes_max)?;
    let mut bytes = Vec::new();
    // The system makes some files as they are read: their length says nothing.
    opened.take(bytes_max.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > bytes_max {
        return Err(FileError::TooLarge { bytes: bytes_max, is_whole: false, bytes_max });
    }
    Ok(bytes)
}

/// Reads a text of at most `bytes_max` bytes, without byte order mark, its lines ended by line feeds.
///
/// # Errors
/// [`FileError`].
pub fn text(file: &Path, bytes_max: u64) -> Result<String, FileError> {
    decode(bytes(file, bytes_max)?)
}

/// The text of the bytes of a file.
fn decode(bytes: Vec<u8>) -> Result<String, FileError> {
    match bytes[..] {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => return Err(FileError::OtherUtf { bits: 32 }),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => return Err(FileError::OtherUtf { bits: 16 }),
        _ => {}
    }
    let is_plain = !bytes.starts_with(MARK) && !bytes.contains(&b'\r');
    let bytes = if is_plain {
        bytes
    } else {
        let mut plain = Vec::with_capacity(bytes.len());
        LineFeeds::new(&bytes[..]).read_to_end(&mut plain)?;
        plain
    };
    String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let before = String::from_utf8_lossy(&error.as_bytes()[..good]);
        let line_start = before.rfind('\n').map_or(0, |at| at + 1);
        FileError::NotUtf8 {
            line: 1 + before.matches('\n').count(),
            column: 1 + before[line_start..].chars().count(),
            byte: error.as_bytes()[good],
        }
    })
}

/// Opens a text that is read line by line: without byte order mark, its lines ended by line feeds. UTF-8 is for the reader to check.
///
/// # Errors
/// As [`open`].
pub fn lines(file: &Path, bytes_max: u64) -> Result<LineFeeds<BufReader<File>>, FileError> {
    Ok(LineFeeds::new(BufReader::new(open(file, bytes_max)?)))
}

/// The FNV-1a hash of a file's bytes as they are.
///
/// # Errors
/// As [`open`].
pub fn digest(file: &Path) -> Result<Digest, FileError> {
    Ok(digest_of(BufReader::new(open(file, u64::MAX)?))?)
}

/// The FNV-1a hash of a text's bytes without byte order mark, its lines ended by line feeds: whoever saved it again as it was changed nothing.
///
/// # Errors
/// As [`open`].
pub fn digest_of_lines(file: &Path) -> Result<Digest, FileError> {
    Ok(digest_of(lines(file, u64::MAX)?)?)
}

fn digest_of(mut input: impl BufRead) -> io::Result<Digest> {
    let mut hash = Fnv1a::default();
    loop {
        let bytes = input.fill_buf()?;
        if bytes.is_empty() {
            return Ok(Digest(hash.value()));
        }
        hash.bytes(bytes);
        let taken = bytes.len();
        input.consume(taken);
    }
}

/// The byte order mark of UTF-8.
pub const MARK: &[u8] = b"\xef\xbb\xbf";

/// The bytes of a text without byte order mark, CR LF and CR turned into LF.
#[derive(Debug)]
pub struct LineFeeds<R> {
    input: R,
    is_at_start: bool,
    is_after_return: bool,
    /// Bytes that are ready, of which `taken` have been read.
    ready: Vec<u8>,
    taken: usize,
}

impl<R: BufRead> LineFeeds<R> {
    /// A reader of what `input` holds.
    pub fn new(input: R) -> Self {
        Self { input, is_at_start: true, is_after_return: false, ready: Vec::new(), taken: 0 }
    }
}

impl<R: BufRead> BufRead for LineFeeds<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        while self.taken == self.ready.len() {
            (self.taken, self.ready) = (0, std::mem::take(&mut self.ready));
            self.ready.clear();
            let found = self.input.fill_buf()?;
            let length = found.len();
            if length == 0 {
                break;
            }
            // A regular file fills the buffer at once, so the mark is never torn.
            let skipped = if self.is_at_start && found.starts_with(MARK) { MARK.len() } else { 0 };
            for &byte in &found[skipped..] {
                match byte {
                    b'\r' => self.ready.push(b'\n'),
                    b'\n' if self.is_after_return => {}
                    _ => self.ready.push(byte),
                }
                self.is_after_return = byte == b'\r';
            }
            self.is_at_start = false;
            self.input.consume(length);
        }
        Ok(&self.ready[self.taken..])
    }

    fn consume(&mut self, amount: usize) {
        self.taken += amount;
    }
}

impl<R: BufRead> Read for LineFeeds<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.fill_buf()?.read(buffer)?;
        self.consume(length);
        Ok(length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(bytes: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, bytes).unwrap();
        (folder, file)
    }

    #[test]
    fn a_text_comes_out_one_way_whoever_saved_it() {
        for (bytes, expected) in [
            (&b"a\nb\n"[..], "a\nb\n"),
            (b"\xef\xbb\xbfa\r\nb\r\n", "a\nb\n"),
            (b"a\rb\r", "a\nb\n"),
            (b"a\r\r\nb\n\rc", "a\n\nb\n\nc"),
            (b"\xef\xbb\xbf", ""),
            (b"", ""),
            ("\u{fe}ä\r\n".as_bytes(), "\u{fe}ä\n"),
        ] {
            let (_folder, file) = written(bytes);
            assert_eq!(text(&file, 100).unwrap(), expected, "{bytes:?}");
            // The same however the input is cut up, but for the mark.
            let mark = if bytes.starts_with(MARK) { 3 } else { 1 };
            for room in mark..8 {
                let mut plain = Vec::new();
                LineFeeds::new(BufReader::with_capacity(room, bytes)).read_to_end(&mut plain).unwrap();
                assert_eq!(plain, expected.as_bytes(), "{bytes:?} {room}");
            }
        }
    }

    #[test]
    fn the_digest_is_of_the_bytes_or_of_the_lines() {
        let of = |content: &[u8]| {
            let (_folder, file) = written(content);
            (digest(&file).unwrap().to_string(), digest_of_lines(&file).unwrap().to_string())
        };
        // The vector of the authors' reference for these bytes (draft-eastlake-fnv).
        assert_eq!(of(b"foobar"), ("85944171f73967e8".to_owned(), "85944171f73967e8".to_owned()));
        let (plain, turned) = (of(b"a\nb\n"), of(b"\xef\xbb\xbfa\r\nb\r\n"));
        assert!(plain.0 == plain.1 && turned.1 == plain.1 && turned.0 != plain.0);
        // A long text is taken in by pieces.
        let long = "0123456789\n".repeat(10_000);
        assert_eq!(of(long.as_bytes()).0, Digest::of(long.as_bytes()).to_string());
    }

    #[test]
    fn what_is_no_utf_8_is_named_with_its_place() {
        for (bytes, expected) in [
            (&b"a\r\n\xc3\xa4b\xe9c\n"[..], "line 2, column 3: found the byte 0xE9, expected UTF-8 text"),
            (b"\xff\xfea\0\n\0", "line 1, column 1: found text in UTF-16, expected UTF-8 text"),
            (b"\xfe\xff\0a", "line 1, column 1: found text in UTF-16"),
            (b"\xff\xfe\0\0a\0\0\0", "line 1, column 1: found text in UTF-32"),
            (b"a\x80", "line 1, column 2: found the byte 0x80"),
        ] {
            let (_folder, file) = written(bytes);
            let message = text(&file, 100).unwrap_err().to_string();
            assert!(message.starts_with(expected), "{message}");
        }
    }

    #[test]
    fn a_file_may_be_as_large_as_its_reader_allows_and_no_larger() {
        let (_folder, file) = written(b"12345");
        assert_eq!(bytes(&file, 5).unwrap(), b"12345");
        let refused = bytes(&file, 4).unwrap_err().to_string();
        assert_eq!(refused, "found 5 bytes, expected at most 4 bytes");
        // A hole of a TiB takes no room on the disk.
        File::options().write(true).open(&file).unwrap().set_len((1 << 40) + (1 << 39)).unwrap();
        let refused = text(&file, 1 << 16).unwrap_err().to_string();
        assert_eq!(refused, "found 1.5 TiB, expected at most 64 KiB");
    }

    /// The length of such a file is 0 whatever it holds.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_made_as_it_is_read_is_bounded_as_well() {
        let status = Path::new("/proc/self/status");
        assert!(text(status, 1 << 16).unwrap().contains("Name:"));
        assert_eq!(text(status, 10).unwrap_err().to_string(), "found more than 10 bytes, expected at most 10 bytes");
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_regular_file_is_refused_before_it_is_opened() {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let link = folder.path().join("link");
        std::os::unix::fs::symlink(&pipe, &link).unwrap();
        for (file, expected) in [
            (folder.path(), "found a folder, expected a regular file"),
            (&pipe, "found a named pipe, expected a regular file"),
            (&link, "found a named pipe, expected a regular file"),
            (&socket, "found a socket, expected a regular file"),
            (Path::new("/dev/zero"), "found a device, expected a regular file"),
        ] {
            assert_eq!(text(file, u64::MAX).unwrap_err().to_string(), expected);
        }
        let missing = text(&folder.path().join("none"), 1).unwrap_err();
        assert!(missing.is_missing(), "{missing}");
    }
}
