//! The world, the truth: the only user of rapier2d.

mod scene;
pub mod spec;

pub use scene::{Mover, ObstacleKind, Scene, Shape, StaticMap, UnknownStatic};
