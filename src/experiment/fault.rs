//! Faults of simrun itself inside a work item: which part panicked, and the command that drives the same episode again.

use crate::guard::guard;
use crate::scenario::Edit;
use std::fmt;
use std::path::PathBuf;

/// A part of a work item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The map is made, obstacles and tasks are placed, the shortest ways are found.
    WorldGeneration,
    /// The stack is built, the robot drives.
    Drive,
    /// What the drive came to is measured, digests are taken.
    Metrics,
    /// Rows and traces are written.
    Encoding,
}

impl Phase {
    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::WorldGeneration => "world_generation",
            Self::Drive => "drive",
            Self::Metrics => "metrics",
            Self::Encoding => "encoding",
        }
    }
}

/// What went wrong in which part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fault {
    pub(super) phase: Phase,
    pub(super) message: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.phase.name(), self.message)
    }
}

/// The answer of one part of a work item, or its fault.
pub(super) fn guarded<T>(phase: Phase, work: impl FnOnce() -> T) -> Result<T, Fault> {
    guard(work).map_err(|panic| Fault { phase, message: panic.to_string() })
}

/// Where a scenario came from: what has to be named to run it again.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Origin {
    /// Its file; its name if it has none.
    pub(super) file: PathBuf,
    /// Keys and values of the edits, as `--set` takes them; not the number of episodes, which drives none of them otherwise.
    pub(super) edits: Vec<String>,
}

impl Origin {
    pub(super) fn new(file: PathBuf, edits: &[Edit]) -> Self {
        let drives = edits.iter().map(Edit::argument).filter(|edit| !edit.starts_with("episodes="));
        Self { file, edits: drives.map(str::to_owned).collect() }
    }
}
