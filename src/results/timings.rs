//! Wall-clock times of episodes: `timings.csv`, outside the byte contract.

use super::row::Row;
use serde::{Deserialize, Serialize};
use std::io;

/// Wall-clock times of one row, s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Building the world and the tables derived from it; the same for all stacks of a world.
    pub world_s: f64,
    /// The global layer, all calls.
    pub global_s: f64,
    /// Median of a local decision.
    pub local_p50_s: f64,
    /// 99 % quantile of a local decision.
    pub local_p99_s: f64,
    /// Longest local decision.
    pub local_max_s: f64,
    /// The physics, all ticks.
    pub physics_s: f64,
}

/// The names of the columns.
pub(super) const HEADER: &str = "point,stack,episode,world_s,global_s,local_p50_s,local_p99_s,local_max_s,physics_s\n";

/// Appends one row, times with nine decimals.
pub(super) fn write_timing<W: io::Write>(writer: &mut csv::Writer<W>, row: &Row, timing: &Timing) -> io::Result<()> {
    let Timing { world_s, global_s, local_p50_s, local_p99_s, local_max_s, physics_s } = *timing;
    let identity = [row.point.to_string(), row.stack.clone(), row.episode.to_string()];
    let times = [world_s, global_s, local_p50_s, local_p99_s, local_max_s, physics_s].map(|time| format!("{time:.9}"));
    Ok(writer.write_record(identity.iter().chain(&times))?)
}
