//! Errors of maps.

use crate::files::FileError;
use std::path::{Path, PathBuf};

/// Reason why a map cannot be made. Each message says what was found, what was expected and what to do.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// A file could not be read.
    #[error("cannot read the map: {source}")]
    Read {
        /// What is wrong with it.
        source: FileError,
    },
    /// A text does not follow its format.
    #[error("line {line}, column {column}: found {found}, expected {expected}; {advice}")]
    Format {
        /// Line in the text, counted from 1.
        line: usize,
        /// Character in the line, counted from 1.
        column: usize,
        /// The text found there.
        found: String,
        /// The text that the format expects.
        expected: String,
        /// Advice for mending it.
        advice: &'static str,
    },
    /// The YAML header of a map is invalid.
    #[error("line {line}, column {column}: {message}")]
    Header {
        /// Line in the text, counted from 1.
        line: usize,
        /// Character in the line, counted from 1.
        column: usize,
        /// Message with what was found and what was expected.
        message: String,
    },
    /// An image cannot be read as a map.
    #[error("image {}: found {found}, expected {expected}; {advice}", image.display())]
    Image {
        /// The image's file.
        image: PathBuf,
        /// Properties of the image.
        found: String,
        /// Properties that were expected.
        expected: String,
        /// Advice for mending it.
        advice: String,
    },
    /// Numbers of a map contradict each other.
    #[error("{map} map: found {found}, expected {expected}; {advice}")]
    Contradiction {
        /// The kind of map.
        map: &'static str,
        /// The numbers as given.
        found: String,
        /// Numbers that would fit.
        expected: String,
        /// Advice for mending it.
        advice: &'static str,
    },
    /// No acceptable map was drawn within the bound on tries.
    #[error("{map} map: none of {tries} draws {wanted}, expected one; {advice}")]
    Infeasible {
        /// The kind of map.
        map: &'static str,
        /// Number of draws taken and rejected.
        tries: u32,
        /// Condition that a draw should meet.
        wanted: &'static str,
        /// Advice for mending it.
        advice: &'static str,
    },
    /// A file could not be written.
    #[error("cannot write the map: {source}")]
    Write {
        /// The system's error.
        source: std::io::Error,
    },
    /// Files that would be replaced are there.
    #[error("{} there already", there(files))]
    Exist {
        /// The files.
        files: Vec<PathBuf>,
    },
    /// A file's extension names no format.
    #[error("the extension names no format of maps, expected {known}")]
    UnknownExtension {
        /// The known formats.
        known: String,
    },
    /// Any of the above, about a file.
    #[error("{}: {source}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The error about that file.
        source: Box<MapError>,
    },
}

/// Files that are there, in words: `a.yaml and a.pgm are`.
fn there(files: &[PathBuf]) -> String {
    let names: Vec<String> = files.iter().map(|file| format!("`{}`", file.display())).collect();
    format!("{} {}", names.join(" and "), if files.len() == 1 { "is" } else { "are" })
}

impl MapError {
    /// A [`MapError::Format`] at a place counted from 0.
    pub(super) fn at(
        (line, column): (usize, usize),
        found: impl Into<String>,
        expected: impl Into<String>,
        advice: &'static str,
    ) -> Self {
        Self::Format { line: line + 1, column: column + 1, found: found.into(), expected: expected.into(), advice }
    }

    /// The same error, with the name of the file.
    pub(super) fn of(self, file: &Path) -> Self {
        Self::File { file: file.into(), source: Box::new(self) }
    }
}
