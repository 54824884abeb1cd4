//! A scene: everything about one episode's world before the first tick. Equal for all stacks.

use crate::geometry::{Pose, Vec2};
use crate::map::{DistanceField, OccupancyGrid};
use std::sync::Arc;

/// A known map with all that is derived from it once and shared by every episode that uses it.
#[derive(Debug)]
pub struct StaticMap {
    /// Occupancy.
    pub grid: OccupancyGrid,
    /// Exact distance field of `grid`.
    pub field: DistanceField,
}

/// Outline of an obstacle about its own origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A disc.
    Disc {
        /// Radius, m.
        radius_m: f64,
    },
    /// A rectangle, half its sides along its own x and y.
    Rectangle {
        /// Half of the two sides, m.
        half_m: Vec2,
    },
}

/// An obstacle that stands still and is not on the known map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnknownStatic {
    /// Pose of its centre, grid frame.
    pub pose: Pose,
    /// Its outline.
    pub shape: Shape,
}

/// A moving obstacle as it is at tick 0: a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mover {
    /// Centre, grid frame, m.
    pub position: Vec2,
    /// Velocity, m/s.
    pub velocity: Vec2,
    /// Radius, m.
    pub radius_m: f64,
}

/// One episode's world before the first tick.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The known map.
    pub map: Arc<StaticMap>,
    /// Where the robot starts, grid frame.
    pub start: Pose,
    /// Where it is to go, grid frame.
    pub goal: Vec2,
    /// Obstacles that stand still and are not on the map.
    pub unknown_static: Vec<UnknownStatic>,
    /// Moving obstacles.
    pub movers: Vec<Mover>,
}

/// What the robot touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObstacleKind {
    /// A cell of the known map.
    KnownStatic,
    /// An obstacle that stands still and is not on the map.
    UnknownStatic,
    /// A mover.
    Dynamic,
    /// The edge of the map.
    Boundary,
}

impl ObstacleKind {
    /// The name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::KnownStatic => "known_static",
            Self::UnknownStatic => "unknown_static",
            Self::Dynamic => "dynamic",
            Self::Boundary => "boundary",
        }
    }
}
