//! One row of `episodes.csv`.

use crate::digest::Digest;
use crate::episode::Outcome;
use crate::metrics::Metrics;

/// One row of `episodes.csv`: identification, outcome and metrics of an episode.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the scenario.
    pub scenario: String,
    /// Number of the sweep point, from 0.
    pub point: u32,
    /// Unique name of the stack.
    pub stack: String,
    /// Global planner; empty without one.
    pub global: String,
    /// Path stages joined by `+`; empty without any.
    pub path: String,
    /// Local planner.
    pub local: String,
    /// Number of the episode, from 0.
    pub episode: u64,
    /// Seed of the scenario.
    pub seed: u64,
    /// Outcome of the episode.
    pub outcome: Outcome,
    /// Metrics of the episode.
    pub metrics: Metrics,
    /// Digest of the world before the first tick; `None` without a world.
    pub world_digest: Option<Digest>,
    /// Digest of the trace; `None` without a trace.
    pub trace_digest: Option<Digest>,
    /// Value of each swept key at this point, in the order of the sweep.
    pub swept: Vec<String>,
}

impl Row {
    /// An empty row, for a reader to fill.
    pub(crate) fn blank() -> Self {
        Self {
            scenario: String::new(),
            point: 0,
            stack: String::new(),
            global: String::new(),
            path: String::new(),
            local: String::new(),
            episode: 0,
            seed: 0,
            outcome: Outcome::Timeout,
            metrics: Metrics::default(),
            world_digest: None,
            trace_digest: None,
            swept: Vec::new(),
        }
    }
}
