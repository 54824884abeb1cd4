//! Placement uniformly over the map.

use super::PlacementKind;
use crate::geometry::Vec2;
use crate::rng::Stream;
use crate::settings::Entry;
use crate::world::scene::Scene;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "uniformly over the map" };

/// No parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {}

impl PlacementKind for Params {
    fn draw(&self, scene: &Scene, stream: &mut Stream) -> Option<Vec2> {
        let extent = scene.map.grid.extent_m();
        Some(Vec2::new(stream.range(0.0, extent.x), stream.range(0.0, extent.y)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{hall, stream};
    use super::*;

    #[test]
    fn places_cover_the_whole_map() {
        let (scene, mut stream) = (hall(), stream());
        let mut quarters = [0; 4];
        for _ in 0..4000 {
            let p = Params {}.draw(&scene, &mut stream).unwrap();
            assert!((0.0..20.0).contains(&p.x) && (0.0..10.0).contains(&p.y));
            quarters[usize::from(p.x > 10.0) + 2 * usize::from(p.y > 5.0)] += 1;
        }
        // 1000 expected in each, standard deviation 27.
        assert!(quarters.iter().all(|count| (860..1140).contains(count)), "{quarters:?}");
    }
}
