//! Rooms with doors: a lattice of equal rooms, each wall between two with one door or none.
//!
//! A random spanning tree of doors joins all rooms, and each other wall has a door with the
//! probability `extra_doors`; a door stands anywhere along its wall, uniformly. The outer wall is the
//! border of the map. A disc narrower than the doors reaches every room. This scenario
//!
//! ```yaml
//! map: {rooms: {rooms_x: 4, rooms_y: 3, room_width_m: 7, room_height_m: 4, door_width_m: 2, map_seed: 1}}
//! ```
//!
//! is drawn as
//!
//! ```text
//! .......#...............#.......
//! .......#...............#.......
//! ...............#...............
//! ...............#...............
//! ##..####..######..###########..
//! .......#.......#.......#.......
//! .......#...............#.......
//! .......................#.......
//! ...............#.......#.......
//! #########################..####
//! .......#.......#.......#.......
//! .......#.......#...............
//! ...............................
//! .......................#.......
//! ```

use crate::map::layout;
use crate::map::{Entry, Generator, MapError, MapSeed, OccupancyGrid};
use crate::rng::{EpisodeSeed, Purpose};
use crate::settings::quantity::{Cells, Fraction, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Rooms with doors: a lattice of equal rooms, each wall between two with one door or none.",
    files: &[],
};

/// Parameters of a map of rooms. Every length is a whole number of cells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Rooms along x. Default 4.
    pub rooms_x: Cells,
    /// Rooms along y. Default 4.
    pub rooms_y: Cells,
    /// Inner width of a room along x, m. Default 9.
    pub room_width_m: Positive,
    /// Inner width of a room along y, m. Default 9.
    pub room_height_m: Positive,
    /// Thickness of the walls, m. Default 1.
    pub wall_thickness_m: Positive,
    /// Width of a door, m; at most the sides of a room. Default 2.
    pub door_width_m: Positive,
    /// Probability of a door in a wall that needs none to connect all rooms: 0 makes a tree of rooms, 1
    /// gives every wall a door. Default 0.5.
    pub extra_doors: Fraction,
    /// Side of a cell, m; divides every length here. Default 1.
    pub resolution_m: Positive,
    /// `per_episode` draws new doors for each episode; a number fixes the map, whatever the
    /// scenario's seed is. Default `per_episode`.
    pub map_seed: MapSeed,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            rooms_x: Cells::new(4),
            rooms_y: Cells::new(4),
            room_width_m: Positive::new(9.0),
            room_height_m: Positive::new(9.0),
            wall_thickness_m: Positive::new(1.0),
            door_width_m: Positive::new(2.0),
            extra_doors: Fraction::new(0.5),
            resolution_m: Positive::new(1.0),
            map_seed: MapSeed::PerEpisode,
        }
    }
}

impl Generator for Params {
    fn map_seed(&self) -> MapSeed {
        self.map_seed
    }

    /// The grid of one episode. Draws are taken room by room: the tree from stream (map, 0), then from
    /// (map, 1) for the wall on the right and the one above whether it has a door, and where; so a change
    /// of `extra_doors` moves no door.
    ///
    /// # Errors
    /// [`MapError::Contradiction`] if a length is not a whole number of cells, a door is wider than a
    /// room, or the map gets too large.
    fn generate(&self, seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        let resolution_m = self.resolution_m.get();
        let cells = |key, length: Positive| layout::cells("rooms", key, length.get(), resolution_m);
        let (width, height) = (cells("room_width_m", self.room_width_m)?, cells("room_height_m", self.room_height_m)?);
        let wall = cells("wall_thickness_m", self.wall_thickness_m)?;
        let door = cells("door_width_m", self.door_width_m)?;
        if door > width || door > height {
            return Err(MapError::Contradiction {
                map: "rooms",
                found: format!("doors of {} m", self.door_width_m.get()),
                expected: format!(
                    "at most the sides of a room, {} x {} m",
                    self.room_width_m.get(),
                    self.room_height_m.get()
                ),
                advice: "lower `door_width_m`, or raise `room_width_m` and `room_height_m`",
            });
        }
        let (across, up) = (i64::from(self.rooms_x.get()), i64::from(self.rooms_y.get()));
        let sides = (across * (width + wall) - wall, up * (height + wall) - wall);
        let advice = "lower `rooms_x`, `rooms_y` or the sides of a room, or raise `resolution_m`";
        let mut grid = layout::grid("rooms", sides, resolution_m, advice)?;

        let tree = layout::spanning_tree(across as usize, up as usize, &mut seed.stream(Purpose::Map, 0));
        let mut doors = seed.stream(Purpose::Map, 1);
        for (room, joined) in tree.iter().enumerate() {
            let (room_x, room_y) = (room as i64 % across, room as i64 / across);
            let (col, row) = (room_x * (width + wall), room_y * (height + wall));
            // Three draws for each room, used or not.
            let mut draw = |joined: bool, side: i64| {
                let extra = doors.uniform() < self.extra_doors.get();
                let offset = doors.index((side - door + 1) as usize) as i64;
                (joined || extra).then_some(offset)
            };
            let (right, above) = (draw(joined.right, height), draw(joined.above, width));
            if room_x + 1 < across {
                layout::occupy(&mut grid, col + width..col + width + wall, row..row + height);
                if let Some(offset) = right {
                    layout::clear(&mut grid, col + width..col + width + wall, row + offset..row + offset + door);
                }
            }
            if room_y + 1 < up {
                // With the post between four rooms, where there is one.
                let end = (col + width + wall).min(sides.0);
                layout::occupy(&mut grid, col..end, row + height..row + height + wall);
                if let Some(offset) = above {
                    layout::clear(&mut grid, col + offset..col + offset + door, row + height..row + height + wall);
                }
            }
        }
        Ok(grid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::DistanceField;
    use crate::map::connectivity::{Components, passable};
    use crate::map::support::{generate, refusal};

    #[test]
    fn every_room_is_reached_by_a_disc_narrower_than_the_doors() {
        for number in 0..100 {
            let params =
                Params { extra_doors: Fraction::new(0.0), resolution_m: Positive::new(0.5), ..Params::default() };
            let grid = generate(&params, number);
            let parts = Components::new(&grid, &passable(&DistanceField::new(&grid), 0.7));
            assert_eq!(parts.sizes().len(), 1);
        }
    }

    #[test]
    fn doors_are_counted() {
        // Of 24 walls between 4 x 4 rooms, 15 doors make the tree; a door is 2 of 9 cells.
        let walls = 24 * 9 + 9;
        for (extra, doors) in [(0.0, 15), (1.0, 24)] {
            let params = Params { extra_doors: Fraction::new(extra), ..Params::default() };
            for number in 0..20 {
                let grid = generate(&params, number);
                assert_eq!((grid.cols(), grid.rows()), (39, 39));
                assert_eq!(grid.occupied_count(), walls - 2 * doors);
            }
        }
        // Extra doors are added and move none.
        let few = generate(&Params { extra_doors: Fraction::new(0.2), ..Params::default() }, 0);
        let more = generate(&Params { extra_doors: Fraction::new(0.6), ..Params::default() }, 0);
        assert!(few.occupied().iter().zip(more.occupied()).all(|(few, more)| few >= more) && few != more);
    }

    #[test]
    fn contradictory_sizes_are_named() {
        for (yaml, expected) in [
            ("rooms: {door_width_m: 10}", "found doors of 10 m, expected at most the sides of a room, 9 x 9 m"),
            ("rooms: {room_width_m: 2.5}", "`room_width_m` 2.5, expected a whole number of cells of 1 m"),
            ("rooms: {rooms_y: 9999}", "found 39 x 99989 cells"),
        ] {
            let message = refusal(yaml);
            assert!(message.contains(expected), "{message}");
        }
    }
}
