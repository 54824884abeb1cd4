//! What can be wrong with a map.

use std::path::{Path, PathBuf};

/// Why there is no map. Each message says what was found, what was expected and what to do.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// A file could not be read.
    #[error("cannot read the map: {source}")]
    Read {
        /// What the system said.
        source: std::io::Error,
    },
    /// A text does not follow its format.
    #[error("line {line}, column {column}: found {found}, expected {expected}; {advice}")]
    Format {
        /// Line in the text, counted from 1.
        line: usize,
        /// Character in the line, counted from 1.
        column: usize,
        /// What stands there.
        found: String,
        /// What the format asks for.
        expected: String,
        /// What to do about it.
        advice: &'static str,
    },
    /// The header of a map, which is YAML, says what it may not say.
    #[error("line {line}, column {column}: {message}")]
    Header {
        /// Line in the text, counted from 1.
        line: usize,
        /// Character in the line, counted from 1.
        column: usize,
        /// What was found, and what was expected.
        message: String,
    },
    /// An image cannot be read as a map.
    #[error("image {}: found {found}, expected {expected}; {advice}", image.display())]
    Image {
        /// The image's file.
        image: PathBuf,
        /// What is there.
        found: String,
        /// What would do.
        expected: String,
        /// What to do about it.
        advice: &'static str,
    },
    /// Numbers of a map contradict each other.
    #[error("{map} map: found {found}, expected {expected}; {advice}")]
    Contradiction {
        /// The kind of map.
        map: &'static str,
        /// The numbers as given.
        found: String,
        /// What would fit.
        expected: String,
        /// What to do about it.
        advice: &'static str,
    },
    /// No acceptable map was drawn within the bound on tries.
    #[error("{map} map: none of {tries} draws {wanted}, expected one; {advice}")]
    Infeasible {
        /// The kind of map.
        map: &'static str,
        /// Draws taken and rejected.
        tries: u32,
        /// What a draw should do.
        wanted: &'static str,
        /// What to do about it.
        advice: &'static str,
    },
    /// A file could not be written.
    #[error("cannot write the map: {source}")]
    Write {
        /// What the system said.
        source: std::io::Error,
    },
    /// A file's extension names no format.
    #[error("the extension names no format of maps, expected {known}")]
    UnknownExtension {
        /// The formats that there are.
        known: String,
    },
    /// Any of the above, about a file.
    #[error("{}: {source}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        source: Box<MapError>,
    },
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

    /// The same error, said of a file.
    pub(super) fn of(self, file: &Path) -> Self {
        Self::File { file: file.into(), source: Box::new(self) }
    }
}
