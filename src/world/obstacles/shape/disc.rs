//! A disc.

use super::ShapeKind;
use crate::geometry::outline::Shape;
use crate::settings::Entry;
use crate::settings::quantity::Positive;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "a disc" };

/// Parameters of a disc.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Radius, m.
    pub radius_m: Positive,
}

impl ShapeKind for Params {
    fn shape(&self) -> Shape {
        Shape::Disc { radius_m: self.radius_m.get() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disc_has_its_radius() {
        assert_eq!(Params { radius_m: Positive::new(0.4) }.shape(), Shape::Disc { radius_m: 0.4 });
    }
}
