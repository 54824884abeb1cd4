//! Placement uniformly over the part of the map near the reference route.

use super::PlacementKind;
use crate::geometry::Vec2;
use crate::math;
use crate::rng::Stream;
use crate::settings::Entry;
use crate::settings::quantity::Positive;
use crate::world::scene::Scene;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "uniformly over the part of the map near the reference route" };

/// Parameters of the placement near the route.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Largest distance from the obstacle's centre to the route, m. Default: 3.
    pub distance_max_m: Positive,
}

impl Default for Params {
    fn default() -> Self {
        Self { distance_max_m: Positive::new(3.0) }
    }
}

impl PlacementKind for Params {
    fn needs_route(&self) -> bool {
        true
    }

    /// Draws uniformly from the rectangle around the route and its surroundings; `None` if the point is too far from the route.
    fn draw(&self, scene: &Scene, stream: &mut Stream) -> Option<Vec2> {
        let extent = scene.map.grid.extent_m();
        let (route, reach) = (scene.route(), self.distance_max_m.get());
        let (mut min, mut max) = (route.start(), route.start());
        for p in route.vertices() {
            min = Vec2::new(math::min(min.x, p.x), math::min(min.y, p.y));
            max = Vec2::new(math::max(max.x, p.x), math::max(max.y, p.y));
        }
        let low = Vec2::new(math::max(min.x - reach, 0.0), math::max(min.y - reach, 0.0));
        let high = Vec2::new(math::min(max.x + reach, extent.x), math::min(max.y + reach, extent.y));
        let p = Vec2::new(stream.range(low.x, high.x), stream.range(low.y, high.y));
        (route.project(p).1 <= reach).then_some(p)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{hall, stream};
    use super::*;

    #[test]
    fn places_fill_the_surroundings_of_the_route_and_nothing_else() {
        let (scene, mut stream) = (hall(), stream());
        let (mut inside, mut beyond_the_ends, tries) = (0, 0, 4000);
        for _ in 0..tries {
            let Some(p) = Params { distance_max_m: Positive::new(2.0) }.draw(&scene, &mut stream) else { continue };
            // The route goes along y = 5 from x = 3 to x = 17.
            let beside = math::max(math::max(3.0 - p.x, p.x - 17.0), 0.0);
            assert!(math::hypot(beside, p.y - 5.0) <= 2.0 + 1e-9, "{p:?}");
            inside += 1;
            beyond_the_ends += u32::from(beside > 0.0);
        }
        // Of the rectangle of 18 by 4: 14 · 4 + 4 π square metres, of which 4 π beyond the ends.
        let (area, ends) = (14.0 * 4.0 + 4.0 * math::PI, 4.0 * math::PI);
        let close = |count: u32, share: f64| {
            (f64::from(count) - share * f64::from(tries)).abs() < 5.0 * (f64::from(tries) * share).sqrt()
        };
        assert!(close(inside, area / 72.0) && close(beyond_the_ends, ends / 72.0), "{inside} {beyond_the_ends}");
    }
}
