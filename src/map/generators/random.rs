//! Seeded maps of random obstacles with an exact number of occupied cells. This scenario
//!
//! ```yaml
//! map: {random: {cols: 16, rows: 9, obstacles: 30, map_seed: 1}}
//! ```
//!
//! is drawn as
//!
//! ```text
//! ...........##...
//! ...........##...
//! .##.............
//! ........####....
//! .####...####....
//! .####...####....
//! .####...........
//! ................
//! ................
//! ```

use crate::map::connectivity::Components;
use crate::map::kind::one_metre;
use crate::map::{Cell, Entry, Generator, MapError, MapSeed, OccupancyGrid};
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::settings::quantity::{Cells, CountOrZero, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "Seeded random obstacles, an exact number of occupied cells.", files: &[] };

/// Parameters of a random map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Number of columns.
    pub cols: Cells,
    /// Number of rows.
    pub rows: Cells,
    /// Side of a cell, m. Default 1.
    #[serde(default = "one_metre")]
    pub resolution_m: Positive,
    /// Number of occupied cells, met exactly.
    pub obstacles: CountOrZero,
    /// What the obstacles look like. Default `blocks`.
    #[serde(default)]
    pub shape: Shape,
    /// Keeps the four corner cells and their neighbours free and demands that opposite corners are
    /// connected (8 neighbours, no corner cut): a map that does not is drawn again, 100 times at
    /// most. Without it every draw is taken. Default true.
    #[serde(default = "yes")]
    pub keep_corners_free: bool,
    /// `per_episode` draws a new map for each episode; a number fixes the map, whatever the
    /// scenario's seed is. Default `per_episode`.
    #[serde(default)]
    pub map_seed: MapSeed,
}

fn yes() -> bool {
    true
}

/// What random obstacles look like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// Rectangles of 1 to 4 by 1 to 4 cells, which may overlap; the last is trimmed.
    #[default]
    Blocks,
    /// Single cells, uniformly.
    Cells,
}

/// Maps drawn before giving up. At the papers' densities one in ten is rejected.
const TRIES_MAX: u32 = 100;

/// Longest side of a block, cells (systems.md §8.2).
const BLOCK_SIDE_MAX: usize = 4;

impl Generator for Params {
    fn map_seed(&self) -> MapSeed {
        self.map_seed
    }

    /// The grid of one episode.
    ///
    /// Try t draws from stream (map, t), so that a map is addressed by seed, episode and try.
    ///
    /// # Errors
    /// [`MapError::Contradiction`] if there are more obstacles than cells for them, and
    /// [`MapError::Infeasible`] if no draw connects the corners within the bound on tries.
    fn generate(&self, seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        self.generate_around("random", &[], &[], seed)
    }
}

impl Params {
    /// Generates a map as `generate` does, for the kind of map called `map`, around `walls`, which are occupied and not counted,
    /// and `kept_free`, which stay free.
    pub(super) fn generate_around(
        &self,
        map: &'static str,
        walls: &[Cell],
        kept_free: &[Cell],
        seed: EpisodeSeed,
    ) -> Result<OccupancyGrid, MapError> {
        let mut empty = OccupancyGrid::empty(self.cols.get() as i32, self.rows.get() as i32, self.resolution_m.get());
        for &wall in walls {
            empty.set_occupied(wall);
        }
        let mut taken = empty.occupied().to_vec();
        for &cell in kept_free {
            taken[empty.index(cell)] = true;
        }
        let mut ground = self.ground();
        ground.retain(|&index| !taken[index as usize]);
        if self.obstacles.get() as usize > ground.len() {
            return Err(MapError::Contradiction {
                map,
                found: format!("{} obstacles on {} x {} cells", self.obstacles.get(), self.cols.get(), self.rows.get()),
                expected: format!("at most {}", ground.len()),
                advice: "lower `obstacles` or enlarge the map (free corners take up to 16 cells)",
            });
        }
        for attempt in 0..TRIES_MAX {
            let mut stream = seed.stream(Purpose::Map, u64::from(attempt));
            let grid = self.draw(empty.clone(), ground.clone(), &mut stream);
            if !self.keep_corners_free || corners_are_connected(&grid) {
                return Ok(grid);
            }
        }
        Err(MapError::Infeasible {
            map,
            tries: TRIES_MAX,
            wanted: "connects the opposite corners",
            advice: match map {
                "random" => "lower `obstacles` or set `keep_corners_free: false`",
                _ => "lower `obstacles`",
            },
        })
    }

    /// Row-major indices of the cells that may be occupied, ascending.
    fn ground(&self) -> Vec<u32> {
        let (cols, rows) = (self.cols.get(), self.rows.get());
        let at_end = |at: u32, count: u32| at < 2 || at + 2 >= count;
        let mut ground = Vec::with_capacity(cols as usize * rows as usize);
        for row in 0..rows {
            let end_row = self.keep_corners_free && at_end(row, rows);
            ground.extend((0..cols).filter(|&col| !(end_row && at_end(col, cols))).map(|col| row * cols + col));
        }
        ground
    }

    /// One draw: blocks whose lower left cell is uniform on the rest of the ground, until the
    /// count is met. A block leaves out cells that are not ground, and the last one the surplus cells, row
    /// by row from its lower left cell.
    fn draw(&self, mut grid: OccupancyGrid, mut ground: Vec<u32>, stream: &mut Stream) -> OccupancyGrid {
        let mut allowed = vec![false; grid.occupied().len()];
        for &index in &ground {
            allowed[index as usize] = true;
        }
        let mut left = self.obstacles.get();
        while left > 0 {
            let choice = stream.index(ground.len());
            let corner = ground[choice] as usize;
            if !allowed[corner] {
                // An earlier block covers it. Each round takes a cell off the ground or off the count.
                ground.swap_remove(choice);
                continue;
            }
            let (width, height) = match self.shape {
                Shape::Blocks => (1 + stream.index(BLOCK_SIDE_MAX), 1 + stream.index(BLOCK_SIDE_MAX)),
                Shape::Cells => (1, 1),
            };
            let Cell { col, row } = grid.cell(corner);
            for row in row..(row + height as i32).min(grid.rows()) {
                for col in col..(col + width as i32).min(grid.cols()) {
                    let cell = Cell { col, row };
                    let index = grid.index(cell);
                    if left > 0 && allowed[index] {
                        grid.set_occupied(cell);
                        allowed[index] = false;
                        left -= 1;
                    }
                }
            }
        }
        grid
    }
}

/// Whether lower left and upper right, and lower right and upper left, are connected by free cells.
fn corners_are_connected(grid: &OccupancyGrid) -> bool {
    let free: Vec<bool> = grid.occupied().iter().map(|&occupied| !occupied).collect();
    let parts = Components::new(grid, &free);
    let (last_col, last) = (grid.cols() as usize - 1, free.len() - 1);
    parts.connected(0, last) && parts.connected(last_col, last - last_col)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::connectivity::reachable;
    use crate::map::support::{episode, generate, load};
    use crate::map::{DistanceField, MapSpec};

    fn params(cols: u32, rows: u32, obstacles: u32) -> Params {
        Params {
            cols: Cells::new(cols),
            rows: Cells::new(rows),
            resolution_m: Positive::new(1.0),
            obstacles: CountOrZero::new(obstacles),
            shape: Shape::Blocks,
            keep_corners_free: true,
            map_seed: MapSeed::PerEpisode,
        }
    }

    #[test]
    fn counts_are_exact_and_corners_free_and_connected() {
        for shape in [Shape::Blocks, Shape::Cells] {
            // gao2025, Table 1: 200 of 30 x 30.
            let params = Params { shape, ..params(30, 30, 200) };
            for number in 0..100 {
                let grid = generate(&params, number);
                assert_eq!(grid.occupied_count(), 200);
                for (col, row) in [(0, 0), (28, 0), (0, 28), (28, 28)] {
                    for (dc, dr) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                        assert!(grid.is_free(Cell { col: col + dc, row: row + dr }), "{grid}");
                    }
                }
                let field = DistanceField::new(&grid);
                let reached = reachable(&grid, &field, Cell { col: 0, row: 0 }, 0.0);
                assert!([29, 870, 899].iter().all(|&corner| reached[corner]), "{grid}");
            }
        }
    }

    #[test]
    fn a_map_is_a_function_of_seed_and_episode() {
        let params = params(20, 20, 80);
        assert_eq!(generate(&params, 4), generate(&params, 4));
        assert_ne!(generate(&params, 4), generate(&params, 5));
        let fixed = Params { map_seed: MapSeed::Fixed(9), ..params };
        assert_eq!(generate(&fixed, 4), generate(&fixed, 5));
        assert!(MapSpec::random(fixed).is_fixed());
    }

    #[test]
    fn what_was_drawn_once_stays() {
        // Part of the results contract: another picture means that every result on random maps moves.
        let drawn = generate(&params(16, 9, 30), 0);
        let picture = [
            "...........##...",
            "...........##...",
            ".##.............",
            "........####....",
            ".####...####....",
            ".####...####....",
            ".####...........",
            "................",
            "................",
        ];
        assert_eq!(drawn.to_string().lines().collect::<Vec<_>>(), picture);
        assert_eq!(drawn.occupied_count(), 30);
    }

    #[test]
    fn a_full_map_is_met_exactly() {
        let params = Params { keep_corners_free: false, ..params(9, 7, 63) };
        assert_eq!(generate(&params, 0).occupied_count(), 63);
    }

    #[test]
    fn too_many_obstacles_contradict_the_size() {
        // 10 x 10 less four corners of 2 x 2: 84.
        let message = params(10, 10, 85).generate(episode(0)).expect_err("refused").to_string();
        assert!(message.contains("found 85 obstacles on 10 x 10 cells, expected at most 84"), "{message}");
        assert_eq!(generate(&params(1, 1, 0), 0).occupied_count(), 0);
    }

    #[test]
    fn a_map_that_cannot_be_drawn_is_infeasible() {
        let error = params(10, 10, 80).generate(episode(0)).expect_err("refused");
        assert!(matches!(error, MapError::Infeasible { tries: 100, .. }), "{error}");
        assert!(error.to_string().contains("lower `obstacles`"), "{error}");
    }

    #[test]
    fn scenarios_name_only_what_differs_from_the_defaults() {
        let text = "random: {cols: 20, rows: 20, obstacles: 80}";
        let spec: MapSpec = serde_yaml::from_str(text).expect("a map");
        assert_eq!(spec, MapSpec::random(params(20, 20, 80)));
        assert!(!spec.is_fixed());
        assert_eq!(load(text).expect("a map"), generate(&params(20, 20, 80), 0));
        let text = "random: {cols: 20, rows: 20, obstacles: 80, shape: cells, map_seed: 7, keep_corners_free: false}";
        let spec: MapSpec = serde_yaml::from_str(text).expect("a map");
        let written = serde_yaml::to_string(&spec).expect("text");
        assert_eq!(serde_yaml::from_str::<MapSpec>(&written).expect("a map"), spec);
        let wrong = "random: {cols: 20, rows: 20, obstacles: 80, map_seed: often}";
        let message = serde_yaml::from_str::<MapSpec>(wrong).expect_err("refused").to_string();
        assert!(message.contains("map_seed") && message.contains("expected `per_episode` or a whole"), "{message}");
    }
}
