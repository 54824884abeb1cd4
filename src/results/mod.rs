//! Results: rows become bytes that are the same for every number of threads and after every interruption.
//!
//! A [`Journal`] owns `results/<name>/`. It hands out work in order ([`Journal::take`]), accepts the
//! answers in any order ([`Journal::submit`]) and writes them in the one order of the contract:
//!
//! - `episodes.csv`: one [`Row`] per episode and stack, see [`COLUMNS`];
//! - `states.csv`: the time of each stack in each state of its local planner ([`StateTime`](crate::metrics::StateTime));
//! - `summary.csv`: one [`SummaryRow`] per stack and sweep point, a pure function of the bytes of `episodes.csv`;
//! - `timings.csv` ([`Timing`]) and `manifest.json` ([`Manifest`]): wall clock, command and host, outside the byte contract.
//!
//! ```
//! use simrun::episode::Outcome;
//! use simrun::metrics::{Metrics, StateTime};
//! use std::collections::BTreeMap;
//! use simrun::results::{Answer, Existing, Identity, Journal, Order, Row, StackAt, Timing, table};
//!
//! # let directory = tempfile::tempdir().unwrap();
//! let identity = Identity::new("robot: {radius_m: 0.25}", 7, vec!["a_star+dwa".to_owned()], BTreeMap::new());
//! let stack = StackAt { name: "a_star+dwa".to_owned(), values: vec![] };
//! let order = Order::new(vec![], vec![vec![stack]], 100)?;
//!
//! let journal = Journal::open(&directory.path().join("demo"), identity, order, Existing::Continue)?;
//! std::thread::scope(|scope| {
//!     for _ in 0..2 {
//!         scope.spawn(|| {
//!             while let Some(block) = journal.take() {
//!                 let episode = block.episode(); // Here a world is built and driven by every stack of the point.
//!                 let row = Row {
//!                     scenario: "demo".to_owned(),
//!                     point: block.point(),
//!                     stack: "a_star+dwa".to_owned(),
//!                     global: "a_star".to_owned(),
//!                     path: String::new(),
//!                     local: "dwa".to_owned(),
//!                     episode,
//!                     seed: 7,
//!                     outcome: if episode < 90 { Outcome::Success } else { Outcome::Timeout },
//!                     metrics: Metrics { time_s: Some(12.5), ..Metrics::default() },
//!                     world_digest: None,
//!                     trace_digest: None,
//!                     swept: vec![],
//!                 };
//!                 let states = vec![StateTime { state: "track".to_owned(), seconds: 12.5, entries: 1 }];
//!                 let answer = Answer { row, states, timing: Timing::default() };
//!                 journal.submit(block, &[answer]).expect("the disk has room");
//!             }
//!         });
//!     }
//! });
//! let summary = journal.finish()?.expect("nothing interrupted the run");
//! assert_eq!(summary[0].success.expect("100 trials").rate, 0.9);
//! print!("{}", table(&summary, 80));
//! # Ok::<(), simrun::results::ResultsError>(())
//! ```

mod columns;
mod compare;
mod csv_rows;
mod field;
mod identity;
mod journal;
pub mod layout;
mod order;
mod resume;
mod row;
mod states;
mod store;
mod summary;
mod table;
mod timings;
mod value;

pub use crate::digest::Digest;
pub use columns::{COLUMNS, Column, Known, columns, header, metric_column, metric_columns};
pub use compare::{Difference, compare};
pub use csv_rows::{Reader, header_line, row_json, write_row};
pub use field::{Field, json_object};
pub use identity::{BUILD, Identity, Launch, Manifest, settings_hash};
pub use journal::{
    Block, EPISODES_CSV, Existing, Journal, MANIFEST_BYTES_MAX, MANIFEST_JSON, Opened, STATES_CSV, SUMMARY_CSV,
    TIMINGS_CSV, TRACES, WINDOW_BLOCKS,
};
pub use order::{Order, StackAt};
pub use row::Row;
pub use states::Answer;
pub(crate) use store::put;
pub use summary::{Rate, Statistics, SummaryRow, summarise, summarise_rows, summary_json, write_summary};
pub(crate) use table::title;
pub use table::{summary_rows, table};
pub use timings::Timing;

use crate::settings::quantity::counted;
use std::io;
use std::path::{Path, PathBuf};

/// Reason why an `episodes.csv` cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file could not be read.
    #[error(transparent)]
    Io(io::Error),
    /// The file has no header.
    #[error("the file is empty")]
    Empty,
    /// A line is invalid.
    #[error("line {line}: {message}")]
    Line {
        /// Number of the line, from 1.
        line: u64,
        /// Description of the fault.
        message: String,
    },
}

/// Reason why results could not be written or read. The files are as they were before the failed step.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// The system refused.
    #[error("cannot {action} `{}`: {source}", path.display())]
    Io {
        /// The action that was tried.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Another run holds the folder's lock.
    #[error("`{}` is in use by {holder}: wait for it with --wait-lock SECONDS, or write elsewhere with --out", folder.display())]
    Locked {
        /// The folder.
        folder: PathBuf,
        /// Process and host that hold it, as far as they are known.
        holder: String,
    },
    /// A table is not as the finished run left it.
    #[error("`{}` has been altered since its run was finished, as its hash in manifest.json says: bring the old one back, \
        write elsewhere with --out, or run all of it again with --force", path.display())]
    Altered {
        /// The table.
        path: PathBuf,
    },
    /// A table that is being written is not where it was.
    #[error("`{}` has been removed, moved or replaced while the run was writing it: nothing more is written", path.display())]
    Gone {
        /// The table.
        path: PathBuf,
    },
    /// The folder holds results of another run.
    #[error("`{}` holds results of another run: {}. Write elsewhere with --out, or replace them with --force",
        folder.display(), differences.join("; "))]
    Different {
        /// The folder.
        folder: PathBuf,
        /// Each difference in words: what, there, here.
        differences: Vec<String>,
    },
    /// The folder holds an `episodes.csv` that cannot be recognised.
    #[error("`{}` holds an episodes.csv that cannot be continued: {reason}. Write elsewhere with --out, or replace it with --force",
        folder.display())]
    Foreign {
        /// The folder.
        folder: PathBuf,
        /// The reason.
        reason: String,
    },
    /// The folder holds more episodes than were asked for.
    #[error("`{}` holds {} per point, more than the {asked} asked for: ask for at least {present}, \
        write elsewhere with --out, or replace them with --force", folder.display(), counted(*present, "episode"))]
    TooManyEpisodes {
        /// The folder.
        folder: PathBuf,
        /// Episodes of the first point in the file.
        present: u64,
        /// Episodes asked for.
        asked: u64,
    },
    /// An interrupted extension must be finished before the next.
    #[error("`{}` is being extended to {episodes} episodes per point: finish that first with --episodes {episodes}, \
        or replace everything with --force", folder.display())]
    UnfinishedExtension {
        /// The folder.
        folder: PathBuf,
        /// The number of episodes it is being extended to.
        episodes: u64,
    },
    /// A file cannot be read as results.
    #[error("`{}`: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Description of the fault.
        source: ReadError,
    },
    /// A swept key would make two columns of one name.
    #[error("the swept key `{0}` is already the name of a column")]
    SweptKey(String),
    /// The run had failed before.
    #[error("the run has failed: {0}")]
    Failed(String),
}

impl ResultsError {
    /// Names what was done to which file, for `map_err`.
    pub(crate) fn io<E: Into<io::Error>>(action: &'static str, path: &Path) -> impl FnOnce(E) -> Self {
        move |error| Self::Io { action, path: path.to_owned(), source: error.into() }
    }
}
