//! The world, the truth: the only user of rapier2d.

mod scene;

pub use scene::{Mover, ObstacleKind, Scene, Shape, StaticMap, UnknownStatic};
