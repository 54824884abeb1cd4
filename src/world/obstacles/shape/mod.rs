//! Outlines of obstacles, as scenario files write them: one file each.

use crate::geometry::outline::Shape;
use crate::settings::quantity::Positive;
use crate::settings::{Entry, registry};

registry! {
    /// The outline of an obstacle.
    pub enum ShapeChoice: "shape", Entry, dyn ShapeKind { disc, rectangle, polygon }
}

/// Behaviour of a kind of outline.
pub trait ShapeKind {
    /// The shape, about its own origin.
    fn shape(&self) -> Shape;
}

impl Default for ShapeChoice {
    fn default() -> Self {
        Self::rectangle(rectangle::Params { size_m: [Positive::new(1.0), Positive::new(1.0)] })
    }
}
