//! Placement with the centre on the reference route.

use super::PlacementKind;
use crate::geometry::Vec2;
use crate::rng::Stream;
use crate::settings::Entry;
use crate::settings::quantity::Fraction;
use crate::world::scene::{Scene, SceneError, check_range};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "with the centre on the reference route" };

/// Parameters of the placement on the route.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Part of the route's length from which the place is drawn: 0 is the start, 1 the goal. Default: [0.2, 0.8].
    pub share: [Fraction; 2],
}

impl Default for Params {
    fn default() -> Self {
        Self { share: [Fraction::new(0.2), Fraction::new(0.8)] }
    }
}

impl PlacementKind for Params {
    fn check(&self, key: &str) -> Result<(), SceneError> {
        check_range(&format!("{key}.share"), self.share.map(Fraction::get))
    }

    fn needs_route(&self) -> bool {
        true
    }

    fn draw(&self, scene: &Scene, stream: &mut Stream) -> Option<Vec2> {
        let route = scene.route();
        let [low, high] = self.share.map(|share| share.get() * route.length());
        Some(route.point_at(stream.range(low, high)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{hall, stream};
    use super::*;
    use crate::math;

    #[test]
    fn places_lie_on_the_stated_part_of_the_route() {
        let (scene, mut stream) = (hall(), stream());
        let (mut low, mut high) = (f64::INFINITY, 0.0);
        for _ in 0..1000 {
            let p = Params::default().draw(&scene, &mut stream).unwrap();
            assert!((p.y - 5.0).abs() < 1e-12);
            (low, high) = (math::min(low, p.x), math::max(high, p.x));
        }
        // 14 m from x = 3 on: from a fifth, at 5.8, to four fifths, at 14.2.
        assert!((5.8..5.9).contains(&low) && (14.1..=14.2).contains(&high), "{low} {high}");
    }

    #[test]
    fn shares_in_the_wrong_order_are_refused() {
        let params = Params { share: [Fraction::new(0.8), Fraction::new(0.2)] };
        let error = params.check("placement.on_route").unwrap_err();
        assert_eq!(error.to_string(), "placement.on_route.share: expected [lowest, highest], found [0.8, 0.2]");
    }
}
