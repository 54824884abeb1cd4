//! A container port: rows of container blocks with lanes between them, some blocks missing.
//!
//! Stand-in for the satellite maps of qin2026, which are not published (systems.md §8.2). The layout is drawn
//! in whole container widths (`unit_m`): rows 2 or 3 deep, in each of them blocks 6 to 12 long, separated by
//! lanes 2 to 4 wide, and lanes along all four sides. It is one layout of rectangles for every
//! resolution: a cell is occupied if its centre lies in a block, the nearest-neighbour rule of qin2026
//! eq. 1 to 3. By default 25, 50 or 100 cells a side at 1, 0.5 or 0.25 m. Every lane leads to every other one, so
//! each pair of free cells is feasible for a disc narrower than two units. This scenario
//!
//! ```yaml
//! map: {port: {map_seed: 1}}
//! ```
//!
//! is drawn as
//!
//! ```text
//! .........................
//! .........................
//! .........................
//! .........................
//! .........................
//! ..##########...########..
//! ..##########...########..
//! ..##########...########..
//! .........................
//! .........................
//! ...........#########.....
//! ...........#########.....
//! .........................
//! .........................
//! .........................
//! ...#######...............
//! ...#######...............
//! ...#######...............
//! .........................
//! .........................
//! .........................
//! ..############...........
//! ..############...........
//! .........................
//! .........................
//! ```

use crate::map::layout;
use crate::map::{Entry, Generator, MapError, MapSeed, OccupancyGrid};
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::settings::quantity::{Fraction, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "A container port: rows of container blocks with lanes between them, some blocks missing.",
    files: &[],
};

/// Parameters of a port.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Extent along x, m. Default 25.
    pub width_m: Positive,
    /// Extent along y, m. Default 25.
    pub height_m: Positive,
    /// Width of a container, in which blocks and lanes are measured, m. Default 1.
    pub unit_m: Positive,
    /// Probability that a block is missing. Default 0.15.
    pub missing: Fraction,
    /// Side of a cell, m; divides both extents and is at most two units, so that no lane gets lost. The
    /// layout does not depend on it. Default 1.
    pub resolution_m: Positive,
    /// `per_episode` draws a new port for each episode; a number fixes the map, whatever the
    /// scenario's seed is. Default `per_episode`.
    pub map_seed: MapSeed,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            width_m: Positive::new(25.0),
            height_m: Positive::new(25.0),
            unit_m: Positive::new(1.0),
            missing: Fraction::new(0.15),
            resolution_m: Positive::new(1.0),
            map_seed: MapSeed::PerEpisode,
        }
    }
}

/// Smallest and largest depth of a row of blocks, units (systems.md §8.2).
const DEPTH: (i64, i64) = (2, 3);
/// Smallest and largest length of a block, units.
const LENGTH: (i64, i64) = (6, 12);
/// Smallest and largest width of a lane, units.
const LANE: (i64, i64) = (2, 4);

/// A block, in units from the lower left corner: its near edges belong to it, its far edges do not.
struct Block {
    x: (i64, i64),
    y: (i64, i64),
}

impl Generator for Params {
    fn map_seed(&self) -> MapSeed {
        self.map_seed
    }

    /// The grid of one episode.
    ///
    /// # Errors
    /// [`MapError::Contradiction`] if an extent is not a whole number of cells, has no room for a block
    /// between two lanes, or the cells are wider than the lanes.
    fn generate(&self, seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        let (unit_m, resolution_m) = (self.unit_m.get(), self.resolution_m.get());
        let cols = layout::cells("port", "width_m", self.width_m.get(), resolution_m)?;
        let rows = layout::cells("port", "height_m", self.height_m.get(), resolution_m)?;
        let contradiction = |found, expected, advice| MapError::Contradiction { map: "port", found, expected, advice };
        let advice = "change `width_m`, `height_m` or `resolution_m`";
        let mut grid = layout::grid("port", (cols, rows), resolution_m, advice)?;
        let lane_m = LANE.0 as f64 * unit_m;
        if resolution_m > lane_m {
            return Err(contradiction(
                format!("cells of {resolution_m} m"),
                format!("at most the narrowest lane, {lane_m} m"),
                "lower `resolution_m` or raise `unit_m`",
            ));
        }
        let units = |key: &str, length_m: f64, least: i64| {
            let units = length_m / unit_m;
            if units < least as f64 {
                return Err(contradiction(
                    format!("`{key}` {length_m}"),
                    format!("room for a block between two lanes, {} m", least as f64 * unit_m),
                    "raise that length or lower `unit_m`",
                ));
            }
            // A side has at most SIDE_MAX cells, and none is wider than two units; smaller units are no port.
            if units > UNITS_MAX {
                return Err(contradiction(
                    format!("`{key}` of {units} containers"),
                    format!("at most {UNITS_MAX}"),
                    "raise `unit_m`",
                ));
            }
            // A whole number, up to rounding, does not lose its last unit.
            Ok((units + 1e-6).floor() as i64)
        };
        let width = units("width_m", self.width_m.get(), LENGTH.0 + 2 * LANE.0)?;
        let height = units("height_m", self.height_m.get(), DEPTH.0 + 2 * LANE.0)?;

        let mut stream = seed.stream(Purpose::Map, 0);
        // Centres from the near edge on, below the far one. The 1e-6 of a cell takes rounding off an edge.
        let first = |edge: i64| (edge as f64 * unit_m / resolution_m - 0.5 - 1e-6).ceil() as i64;
        for Block { x, y } in self.blocks(width, height, &mut stream) {
            layout::occupy(&mut grid, first(x.0)..first(x.1), first(y.0)..first(y.1));
        }
        Ok(grid)
    }
}

impl Params {
    /// The layout, row by row from below, each from the left. Every block, missing or not, takes three
    /// draws: whether it stands, its length, the lane behind it.
    fn blocks(&self, width: i64, height: i64, stream: &mut Stream) -> Vec<Block> {
        let draw = |stream: &mut Stream, (low, high): (i64, i64)| low + stream.index((high - low + 1) as usize) as i64;
        let mut blocks = Vec::new();
        let mut y = draw(stream, LANE);
        // Bounded: each turn of either loop takes a block and a lane off the extent.
        while y + DEPTH.0 + LANE.0 <= height {
            let top = (y + draw(stream, DEPTH)).min(height - LANE.0);
            let mut x = draw(stream, LANE);
            while x + LENGTH.0 + LANE.0 <= width {
                let stands = stream.uniform() >= self.missing.get();
                let end = (x + draw(stream, LENGTH)).min(width - LANE.0);
                if stands {
                    blocks.push(Block { x: (x, end), y: (y, top) });
                }
                x = end + draw(stream, LANE);
            }
            y = top + draw(stream, LANE);
        }
        blocks
    }
}

/// Most units along a side.
const UNITS_MAX: f64 = crate::map::SIDE_MAX as f64;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::connectivity::{Components, passable};
    use crate::map::support::{episode, generate, refusal};
    use crate::map::{Cell, DistanceField};

    fn at(resolution: f64) -> Params {
        Params { resolution_m: Positive::new(resolution), ..Params::default() }
    }

    #[test]
    fn all_resolutions_show_the_same_port() {
        for number in 0..50 {
            let coarse = generate(&at(1.0), number);
            for (resolution, parts) in [(0.5, 2), (0.25, 4), (0.1, 10)] {
                let fine = generate(&at(resolution), number);
                assert_eq!((fine.cols(), fine.rows()), (25 * parts, 25 * parts));
                for index in 0..fine.occupied().len() {
                    let cell = fine.cell(index);
                    let whole = Cell { col: cell.col / parts, row: cell.row / parts };
                    assert_eq!(fine.is_free(cell), coarse.is_free(whole), "{number} {cell:?}");
                }
            }
        }
    }

    #[test]
    fn every_lane_leads_to_every_other_one() {
        for number in 0..100 {
            for resolution in [0.25, 0.5, 1.0] {
                let grid = generate(&at(resolution), number);
                let parts = Components::new(&grid, &passable(&DistanceField::new(&grid), 0.4));
                assert_eq!(parts.sizes().len(), 1);
                let corners = [(0, 0), (grid.cols() - 1, grid.rows() - 1)];
                assert!(corners.iter().all(|&(col, row)| grid.is_free(Cell { col, row })));
                assert!(grid.occupied_count() > 0 || number > 0);
            }
            // Cells as wide as the narrowest lane still show every lane.
            let coarse = Params { width_m: Positive::new(50.0), height_m: Positive::new(50.0), ..at(2.0) };
            let grid = generate(&coarse, number);
            let free: Vec<bool> = grid.occupied().iter().map(|&occupied| !occupied).collect();
            assert_eq!(Components::new(&grid, &free).sizes().len(), 1, "{grid}");
        }
    }

    #[test]
    fn blocks_have_the_sizes_of_the_paper_and_go_missing_at_the_rate_given() {
        let (mut all, mut kept) = (0, 0);
        for number in 0..200 {
            for (missing, count) in [(0.0, &mut all), (0.15, &mut kept)] {
                let params = Params { missing: Fraction::new(missing), ..at(1.0) };
                let blocks = params.blocks(100, 100, &mut episode(number).stream(Purpose::Map, 0));
                *count += blocks.len();
                for Block { x, y } in blocks {
                    assert!((6..=12).contains(&(x.1 - x.0)) && (2..=3).contains(&(y.1 - y.0)));
                    assert!(x.0 >= 2 && y.0 >= 2 && x.1 <= 98 && y.1 <= 98);
                }
            }
        }
        // About 26 000 blocks: standard error 0.0022.
        let rate = 1.0 - f64::from(kept as u32) / f64::from(all as u32);
        assert!((rate - 0.15).abs() < 0.01, "{rate} of {all}");
    }

    #[test]
    fn contradictory_sizes_are_named() {
        for (yaml, expected) in [
            ("port: {width_m: 9}", "found `width_m` 9, expected room for a block between two lanes, 10 m"),
            ("port: {resolution_m: 2.5}", "found cells of 2.5 m, expected at most the narrowest lane, 2 m"),
            ("port: {resolution_m: 0.3}", "`width_m` 25, expected a whole number of cells of 0.3 m"),
            ("port: {unit_m: 1e-9}", "cells of 1 m, expected at most the narrowest lane"),
            ("port: {resolution_m: 0.001}", "`width_m` of 25000 cells"),
        ] {
            let message = refusal(yaml);
            assert!(message.contains(expected), "{message}");
        }
    }
}
