//! Random obstacles and a U-shaped trap that opens towards the lower left corner's side.
//!
//! Stand-in for the second scenario of zhao2025 (Z-E2; systems.md §8.2): a map as [`random`] draws it,
//! with a U of walls on the diagonal from the lower left to the upper right corner. The U is
//! closed towards +x: a robot that heads from the lower left corner to the upper right one drives into it and has to come
//! out backwards. Its inside stays free. Both diagonals are feasible: a map whose opposite
//! corners are not connected is drawn again, 100 times at most. This scenario
//!
//! ```yaml
//! map: {u_trap: {cols: 20, rows: 14, obstacles: 25, trap_side_cells: 4, trap_at: 0.5, map_seed: 1}}
//! ```
//!
//! is drawn as
//!
//! ```text
//! ....................
//! ....................
//! .................#..
//! ....................
//! ........#####.....#.
//! ....###.....#.....#.
//! ....###.....#.....#.
//! ............#..####.
//! ............#..####.
//! ........#####.......
//! ......#.............
//! ......#.............
//! ......#.......##....
//! ........##..........
//! ```

use super::random::{self, Shape};
use crate::map::{Cell, Entry, Generator, MapError, MapSeed, OccupancyGrid};
use crate::rng::EpisodeSeed;
use crate::settings::quantity::{Cells, CountOrZero, Fraction, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Random obstacles and a U-shaped trap that opens towards the side of the lower left corner.",
    files: &[],
};

/// Parameters of a map with a trap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Number of columns. Default 40 (zhao2025).
    pub cols: Cells,
    /// Number of rows. Default 40 (zhao2025).
    pub rows: Cells,
    /// Side of a cell, m. Default 1.
    pub resolution_m: Positive,
    /// Number of random occupied cells, met exactly; those of the trap are not counted. Default 220: with
    /// the trap's 20 it makes the 15 % of zhao2025.
    pub obstacles: CountOrZero,
    /// What the random obstacles look like. Default `blocks`.
    pub shape: Shape,
    /// Inner side of the trap, cells. Default 6.
    pub trap_side_cells: Cells,
    /// Where on the diagonal the trap's centre lies, from 0 (lower left) to 1. Default 0.35.
    pub trap_at: Fraction,
    /// `per_episode` draws a new map for each episode; a number fixes the map, whatever the
    /// scenario's seed is. Default `per_episode`.
    pub map_seed: MapSeed,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            cols: Cells::new(40),
            rows: Cells::new(40),
            resolution_m: Positive::new(1.0),
            obstacles: CountOrZero::new(220),
            shape: Shape::Blocks,
            trap_side_cells: Cells::new(6),
            trap_at: Fraction::new(0.35),
            map_seed: MapSeed::PerEpisode,
        }
    }
}

impl Generator for Params {
    fn map_seed(&self) -> MapSeed {
        self.map_seed
    }

    /// The grid of one episode.
    ///
    /// # Errors
    /// [`MapError::Contradiction`] if the trap does not fit or there are more obstacles than cells for
    /// them, and [`MapError::Infeasible`] if no draw connects the corners within the bound on tries.
    fn generate(&self, seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        let (cols, rows) = (self.cols.get() as i32, self.rows.get() as i32);
        let side = self.trap_side_cells.get() as i32;
        let low = |cells: i32| (self.trap_at.get() * f64::from(cells)).round() as i32 - side / 2;
        let (left, bottom) = (low(cols), low(rows));
        // Two cells at each corner stay free, and two all around let the robot pass.
        if left < 2 || bottom < 3 || left + side + 3 > cols || bottom + side + 3 > rows {
            return Err(MapError::Contradiction {
                map: "u_trap",
                found: format!("a trap of {side} cells at {} of the diagonal", self.trap_at.get()),
                expected: format!("two free cells between it and the border of {cols} x {rows} cells"),
                advice: "lower `trap_side_cells`, or bring `trap_at` closer to 0.5",
            });
        }
        let arms = (left..left + side).flat_map(|col| [bottom - 1, bottom + side].map(|row| Cell { col, row }));
        let base = (bottom - 1..=bottom + side).map(|row| Cell { col: left + side, row });
        let walls: Vec<Cell> = arms.chain(base).collect();
        // The inside, and a column in front of the mouth.
        let inside = (bottom..bottom + side).flat_map(|row| (left - 1..left + side).map(move |col| Cell { col, row }));
        let around = random::Params {
            cols: self.cols,
            rows: self.rows,
            resolution_m: self.resolution_m,
            obstacles: self.obstacles,
            shape: self.shape,
            keep_corners_free: true,
            map_seed: self.map_seed,
        };
        around.generate_around("u_trap", &walls, &inside.collect::<Vec<_>>(), seed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::connectivity::Components;
    use crate::map::support::{generate, refusal};

    #[test]
    fn the_trap_stands_whole_and_empty_in_every_map() {
        for number in 0..100 {
            let grid = generate(&Params::default(), number);
            // 15 % of 1600; the centre at (14, 14), so the inside is 11..17 both ways.
            assert_eq!(grid.occupied_count(), 240);
            for at in 10..18 {
                assert!(at == 10 || at == 17 || (10..17).all(|col| grid.is_free(Cell { col, row: at })), "{grid}");
                assert!(!grid.is_free(Cell { col: 17, row: at }), "{grid}");
                assert!(at < 11 || [10, 17].iter().all(|&row| !grid.is_free(Cell { col: at, row })), "{grid}");
            }
            let free: Vec<bool> = grid.occupied().iter().map(|&occupied| !occupied).collect();
            let parts = Components::new(&grid, &free);
            assert!(parts.connected(0, 1599) && parts.connected(39, 1560), "{grid}");
        }
    }

    #[test]
    fn contradictions_are_named() {
        for (yaml, expected) in [
            ("u_trap: {trap_at: 0.05}", "found a trap of 6 cells at 0.05 of the diagonal, expected two free cells"),
            ("u_trap: {trap_side_cells: 16384}", "found a trap of 16384 cells"),
            ("u_trap: {obstacles: 1600}", "found 1600 obstacles on 40 x 40 cells, expected at most 1522"),
            ("u_trap: {obstacles: 1400}", "none of 100 draws connects"),
        ] {
            let message = refusal(yaml);
            assert!(message.contains(expected), "{message}");
        }
    }
}
