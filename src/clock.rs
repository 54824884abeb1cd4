//! The only wall clock. It feeds `timings.csv`, the manifest and the progress bar; no result depends on it.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Measures elapsed wall time.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// Starts now.
    #[expect(clippy::disallowed_methods, reason = "the one place that may read the clock")]
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Time since the start.
    pub fn elapsed(&self) -> Duration {
        self.0.elapsed()
    }

    /// Seconds since the start.
    pub fn elapsed_s(&self) -> f64 {
        self.elapsed().as_secs_f64()
    }
}

/// Seconds since 1970-01-01 UTC, for the manifest; 0 where the system has no usable clock.
#[expect(clippy::disallowed_methods, reason = "the one place that may read the clock")]
pub fn unix_time_s() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs())
}
