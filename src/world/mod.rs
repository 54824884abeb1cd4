//! The world, the truth: the only user of rapier2d.

mod bodies;
mod generate;
mod mover;
mod obstacle;
mod route;
mod scene;
pub mod spec;
mod statics;
mod sweep;
mod truth;

pub use generate::{Infeasible, SceneError};
pub use obstacle::{Mover, Shape, UnknownStatic};
pub use scene::{ObstacleKind, Scene};
pub use statics::StaticMap;
pub use truth::{Contact, Step, World};

/// Control period, s: the world's only time step.
pub const DT_S: f64 = 0.1;
