//! A convex polygon about its own centre.

use super::ShapeKind;
use crate::geometry::outline::Shape;
use crate::robot::OutlineCorners;
use crate::settings::Entry;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "a convex polygon about its own centre" };

/// Parameters of a polygon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Corners [x, y] in its own frame, m, in order; [0, 0] lies inside.
    pub corners: OutlineCorners,
}

impl ShapeKind for Params {
    fn shape(&self) -> Shape {
        Shape::Polygon(self.corners.polygon().clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polygon_keeps_its_corners() {
        let params: Params = serde_yaml::from_str("corners: [[1, 0], [-1, 1], [-1, -1]]").unwrap();
        let Shape::Polygon(polygon) = params.shape() else { panic!("{params:?}") };
        assert_eq!(&polygon, params.corners.polygon());
        assert!((params.shape().circumradius_m() - 2f64.sqrt()).abs() < 1e-12);
    }
}
