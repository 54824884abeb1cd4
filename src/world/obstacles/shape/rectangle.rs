//! A rectangle about its own centre.

use super::ShapeKind;
use crate::geometry::Vec2;
use crate::geometry::outline::Shape;
use crate::settings::Entry;
use crate::settings::quantity::Positive;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "a rectangle about its own centre" };

/// Parameters of a rectangle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Sides along the rectangle's own x and y, m.
    pub size_m: [Positive; 2],
}

impl ShapeKind for Params {
    fn shape(&self) -> Shape {
        let [a, b] = self.size_m.map(|side| 0.5 * side.get());
        Shape::Rectangle { half_m: Vec2::new(a, b) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_is_given_by_its_sides() {
        let shape = Params { size_m: [Positive::new(0.8), Positive::new(1.2)] }.shape();
        assert_eq!(shape, Shape::Rectangle { half_m: Vec2::new(0.4, 0.6) });
    }
}
