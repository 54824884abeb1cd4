//! A perfect maze: between any two places there is exactly one way.
//!
//! A lattice of chambers, joined by the random spanning tree of a depth-first walk; the outer wall is
//! the border of the map. A disc of the corridor's width fits everywhere, so every pair of free cells is
//! feasible. This scenario
//!
//! ```yaml
//! map: {maze: {chambers_x: 7, chambers_y: 4, corridor_width_m: 2, wall_thickness_m: 1, map_seed: 1}}
//! ```
//!
//! is drawn as
//!
//! ```text
//! ....................
//! ....................
//! ..################..
//! .....#..............
//! .....#..............
//! ..#..##########..###
//! ..#...........#.....
//! ..#...........#.....
//! ############..####..
//! ..............#.....
//! ..............#.....
//! ```

use crate::map::layout::{self, Joined};
use crate::map::{Entry, Generator, MapError, MapSeed, OccupancyGrid};
use crate::rng::{EpisodeSeed, Purpose};
use crate::settings::quantity::{Cells, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry =
    Entry { summary: "A perfect maze: between any two places there is exactly one way.", files: &[] };

/// Parameters of a maze. Every length is a whole number of cells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Chambers along x. Default 10.
    pub chambers_x: Cells,
    /// Chambers along y. Default 10.
    pub chambers_y: Cells,
    /// Width of the corridors, which is the side of a chamber, m. Default 2.
    pub corridor_width_m: Positive,
    /// Thickness of the walls, m. Default 1.
    pub wall_thickness_m: Positive,
    /// Side of a cell, m; divides both lengths. Default 1.
    pub resolution_m: Positive,
    /// `per_episode` draws a new maze for each episode; a number fixes the maze, whatever the
    /// scenario's seed is. Default `per_episode`.
    pub map_seed: MapSeed,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            chambers_x: Cells::new(10),
            chambers_y: Cells::new(10),
            corridor_width_m: Positive::new(2.0),
            wall_thickness_m: Positive::new(1.0),
            resolution_m: Positive::new(1.0),
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
    /// [`MapError::Contradiction`] if a length is not a whole number of cells or the map gets too large.
    fn generate(&self, seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        let resolution_m = self.resolution_m.get();
        let corridor = layout::cells("maze", "corridor_width_m", self.corridor_width_m.get(), resolution_m)?;
        let wall = layout::cells("maze", "wall_thickness_m", self.wall_thickness_m.get(), resolution_m)?;
        let (across, up) = (i64::from(self.chambers_x.get()), i64::from(self.chambers_y.get()));
        let pitch = corridor + wall;
        let sides = (across * pitch - wall, up * pitch - wall);
        let advice = "lower `chambers_x`, `chambers_y` or the widths, or raise `resolution_m`";
        let mut grid = layout::grid("maze", sides, resolution_m, advice)?;

        let mut stream = seed.stream(Purpose::Map, 0);
        let joined = layout::spanning_tree(across as usize, up as usize, &mut stream);
        layout::occupy(&mut grid, 0..sides.0, 0..sides.1);
        for (room, &Joined { right, above }) in joined.iter().enumerate() {
            let (col, row) = (room as i64 % across * pitch, room as i64 / across * pitch);
            // A chamber, with the wall cells towards the chambers that it is joined with.
            let (width, height) = (corridor + if right { wall } else { 0 }, corridor + if above { wall } else { 0 });
            layout::clear(&mut grid, col..col + width, row..row + corridor);
            layout::clear(&mut grid, col..col + corridor, row..row + height);
        }
        Ok(grid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::DistanceField;
    use crate::map::connectivity::{Components, passable};
    use crate::map::support::{generate, load, refusal};

    #[test]
    fn a_maze_is_connected_and_has_no_loop() {
        for number in 0..100 {
            let grid = generate(&Params { corridor_width_m: Positive::new(1.0), ..Params::default() }, number);
            let free: Vec<bool> = grid.occupied().iter().map(|&occupied| !occupied).collect();
            assert_eq!(Components::new(&grid, &free).sizes().len(), 1);
            // With corridors and walls of one cell the free cells are a graph of their own, and a tree has one
            // edge less than nodes: 100 chambers and 99 doors.
            let nodes = free.iter().filter(|&&free| free).count();
            let cols = grid.cols() as usize;
            let edges: usize = (0..free.len())
                .map(|index| {
                    let right = (index + 1) % cols != 0 && free[index] && free[index + 1];
                    let above = index + cols < free.len() && free[index] && free[index + cols];
                    usize::from(right) + usize::from(above)
                })
                .sum();
            assert_eq!((nodes, edges), (199, 198));
        }
    }

    #[test]
    fn a_robot_of_nearly_the_corridors_width_reaches_everything() {
        let grid = load("maze: {corridor_width_m: 1.5, wall_thickness_m: 0.5, resolution_m: 0.25}").expect("a map");
        assert_eq!((grid.cols(), grid.rows()), (10 * 8 - 2, 10 * 8 - 2));
        let parts = Components::new(&grid, &passable(&DistanceField::new(&grid), 0.6));
        assert_eq!(parts.sizes().len(), 1);
    }

    #[test]
    fn episodes_differ_and_a_fixed_maze_stays() {
        let params = Params::default();
        assert_eq!(generate(&params, 3), generate(&params, 3));
        assert_ne!(generate(&params, 3), generate(&params, 4));
        let fixed = Params { map_seed: MapSeed::Fixed(3), ..params };
        assert_eq!(generate(&fixed, 3), generate(&fixed, 4));
    }

    #[test]
    fn contradictory_sizes_are_named() {
        for (yaml, expected) in [
            ("maze: {corridor_width_m: 1.5}", "`corridor_width_m` 1.5, expected a whole number of cells"),
            ("maze: {chambers_x: 16384}", "found 49151 x 29 cells, expected 1 to 16384 along each side"),
        ] {
            let message = refusal(yaml);
            assert!(message.contains(expected), "{message}");
        }
    }
}
