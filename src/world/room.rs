//! Where a disc fits on a known map: worked out once for all episodes.

use crate::map::connectivity::{Components, passable};
use crate::map::{DistanceField, OccupancyGrid};
use std::sync::{Arc, Mutex, PoisonError};

/// Where a disc of some clearance fits on a known map, and which of these cells are connected.
#[derive(Debug)]
pub(super) struct Room {
    /// Least square of the distance field where it fits.
    threshold: u32,
    /// The cells on whose centre it fits, row-major.
    pub(super) passable: Vec<bool>,
    /// Which of them are connected.
    pub(super) components: Components,
}

/// The rooms of a map that were asked for last: every episode asks for the same.
#[derive(Clone, Debug, Default)]
pub(super) struct Rooms(Arc<Mutex<Vec<Arc<Room>>>>);

impl Rooms {
    /// How many are kept: a scene has two.
    const KEPT: usize = 4;

    /// The room of a disc of radius `clearance_m` on the map that these rooms belong to.
    pub(super) fn of(&self, grid: &OccupancyGrid, field: &DistanceField, clearance_m: f64) -> Arc<Room> {
        let threshold = field.threshold(clearance_m);
        // A room is put in when it is whole, so one that a panic has left is as good as any.
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(room) = kept.iter().find(|room| room.threshold == threshold) {
            return Arc::clone(room);
        }
        let passable = passable(field, clearance_m);
        let room = Arc::new(Room { threshold, components: Components::new(grid, &passable), passable });
        if kept.len() == Self::KEPT {
            kept.remove(0);
        }
        kept.push(Arc::clone(&room));
        room
    }
}
