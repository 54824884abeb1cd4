//! A workshop: a depot, five stations, and crates that stand about.
//!
//! Stand-in for the welding shop of zhu2025 (U-E3; systems.md §8.2), of which no measures are given: a hall of 24 x
//! 14 m with five machines of 4 x 2 m. The robot starts at the depot and parks 1 m in front
//! of a machine:
//!
//! | place | position, m |
//! |---|---|
//! | depot S | [1, 7] |
//! | T1, T2 | [8, 5], [16, 5] |
//! | T3, T4, T5 | [4, 9], [12, 9], [20, 9] |
//!
//! Crates of 1 x 1 m stand anywhere, uniformly, but 1.5 m at least from machines, parking places, walls
//! and each other: a disc of a radius up to 0.75 m passes on all their sides, so every place is
//! feasible. A crate for which no place is found in 1000 draws makes the map infeasible. This scenario
//!
//! ```yaml
//! map: {workshop: {resolution_m: 1, crates: 4, map_seed: 1}}
//! ```
//!
//! is drawn as
//!
//! ```text
//! ........................
//! ........................
//! ..####....####....####..
//! ..####....####....####..
//! ........................
//! ........................
//! ................#.......
//! ....#...............#...
//! ........................
//! ........................
//! ......####....####......
//! ......####....####..#...
//! ........................
//! ........................
//! ```

use crate::map::layout;
use crate::map::{Entry, Generator, MapError, MapSeed, OccupancyGrid};
use crate::rng::{EpisodeSeed, Purpose};
use crate::settings::quantity::{CountOrZero, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry =
    Entry { summary: "A workshop: a depot, five stations, and crates that stand about.", files: &[] };

/// Parameters of a workshop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Side of a cell, m; divides 1 m. Default 0.25.
    pub resolution_m: Positive,
    /// Number of crates. Default 4; about 10 find room.
    pub crates: CountOrZero,
    /// `per_episode` places the crates anew for each episode; a number fixes the map, whatever the
    /// scenario's seed is. Default `per_episode`.
    pub map_seed: MapSeed,
}

impl Default for Params {
    fn default() -> Self {
        Self { resolution_m: Positive::new(0.25), crates: CountOrZero::new(4), map_seed: MapSeed::PerEpisode }
    }
}

/// Width and height of the hall, m.
const HALL_M: (i64, i64) = (24, 14);
/// Lower left corners of the machines, m, in the order of T1 to T5.
const MACHINES_M: [(i64, i64); 5] = [(6, 2), (14, 2), (2, 10), (10, 10), (18, 10)];
/// Width and height of a machine, m.
const MACHINE_M: (i64, i64) = (4, 2);
/// Start of the robot, m.
pub const DEPOT_M: (i64, i64) = (1, 7);
/// Parking places of the robot, m: T1 to T5.
pub const STATIONS_M: [(i64, i64); 5] = [(8, 5), (16, 5), (4, 9), (12, 9), (20, 9)];
/// Least gap around a crate, m.
const GAP_M: f64 = 1.5;
/// Number of places drawn for a crate before giving up.
const TRIES_MAX: u32 = 1000;

/// A rectangle in cells: near edges belong to it, far edges do not.
#[derive(Clone, Copy)]
struct Block {
    x: (i64, i64),
    y: (i64, i64),
}

impl Block {
    fn new((x, y): (i64, i64), (width, height): (i64, i64)) -> Self {
        Self { x: (x, x + width), y: (y, y + height) }
    }

    /// The gap to another block along the axis on which it is wider, in cells; negative if they overlap.
    fn gap(&self, other: &Self) -> i64 {
        let apart = |a: (i64, i64), b: (i64, i64)| (a.0 - b.1).max(b.0 - a.1);
        apart(self.x, other.x).max(apart(self.y, other.y))
    }
}

impl Generator for Params {
    fn map_seed(&self) -> MapSeed {
        self.map_seed
    }

    /// The grid of one episode; crate k draws from stream (map, k).
    ///
    /// # Errors
    /// [`MapError::Contradiction`] if 1 m is not a whole number of cells, and
    /// [`MapError::Infeasible`] if a crate finds no place.
    fn generate(&self, seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        let scale = layout::cells("workshop", "one metre of", 1.0, self.resolution_m.get())?;
        let scaled = |(x, y): (i64, i64)| (x * scale, y * scale);
        let (cols, rows) = scaled(HALL_M);
        let mut grid = layout::grid("workshop", (cols, rows), self.resolution_m.get(), "raise `resolution_m`")?;
        let gap = (GAP_M * scale as f64).ceil() as i64;

        // What crates keep away from: blocks, and the places of the robot as points.
        let machines = MACHINES_M.map(|corner| Block::new(scaled(corner), scaled(MACHINE_M)));
        let mut blocks = machines.to_vec();
        let places: Vec<Block> =
            STATIONS_M.iter().chain([&DEPOT_M]).map(|&place| Block::new(scaled(place), (0, 0))).collect();
        for number in 0..self.crates.get() {
            let mut stream = seed.stream(Purpose::Map, u64::from(number));
            let mut draw = |cells: i64| gap + stream.index((cells - scale - 2 * gap + 1) as usize) as i64;
            let found = (0..TRIES_MAX)
                .map(|_| Block::new((draw(cols), draw(rows)), (scale, scale)))
                .find(|place| blocks.iter().chain(&places).all(|other| place.gap(other) >= gap));
            match found {
                Some(place) => blocks.push(place),
                None => {
                    return Err(MapError::Infeasible {
                        map: "workshop",
                        tries: TRIES_MAX,
                        wanted: "has room for a crate",
                        advice: "lower `crates`",
                    });
                }
            }
        }
        for Block { x, y } in blocks {
            layout::occupy(&mut grid, x.0..x.1, y.0..y.1);
        }
        Ok(grid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vec2;
    use crate::map::DistanceField;
    use crate::map::connectivity::{Components, passable};
    use crate::map::support::{generate, refusal};

    #[test]
    fn every_station_is_reached_from_the_depot_around_every_crate() {
        for number in 0..100 {
            let grid = generate(&Params::default(), number);
            assert_eq!((grid.cols(), grid.rows(), grid.occupied_count()), (96, 56, (5 * 8 + 4) * 16));
            // Cell centres see up to half a diagonal less than the 0.75 m of the gaps.
            let parts = Components::new(&grid, &passable(&DistanceField::new(&grid), 0.6));
            let cell = |(x, y): (i64, i64)| grid.index(grid.cell_at(Vec2::new(x as f64, y as f64)));
            for station in STATIONS_M {
                assert!(parts.connected(cell(DEPOT_M), cell(station)), "{grid}");
            }
        }
    }

    #[test]
    fn too_many_crates_are_infeasible_after_a_bounded_search() {
        let message = refusal("workshop: {crates: 1000000000}");
        assert!(message.contains("none of 1000 draws has room for a crate, expected one; lower `crates`"), "{message}");
        let message = refusal("workshop: {resolution_m: 0.3}");
        assert!(message.starts_with("workshop map: found `one metre of` 1, expected a whole number"), "{message}");
    }
}
