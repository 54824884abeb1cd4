//! Placements of random obstacles: one file each.

use crate::geometry::Vec2;
use crate::rng::Stream;
use crate::settings::{Entry, registry};
use crate::world::scene::{Scene, SceneError};

registry! {
    /// Where random obstacles are put. "The route" is the scene's reference route, which no planner shapes.
    pub enum PlacementChoice: "placement", Entry, dyn PlacementKind { anywhere, near_route, on_route }
}

/// Behaviour of a placement.
pub trait PlacementKind {
    /// Checks the parameters; `key` is that of the placement, such as `….placement.on_route`.
    ///
    /// # Errors
    /// The first parameter that no draw can satisfy.
    fn check(&self, key: &str) -> Result<(), SceneError> {
        let _ = key;
        Ok(())
    }

    /// Whether places are drawn by the scene's reference route.
    fn needs_route(&self) -> bool {
        false
    }

    /// One draw of a position, grid frame; `None` if this draw fell outside the placement's region.
    fn draw(&self, scene: &Scene, stream: &mut Stream) -> Option<Vec2>;
}

impl Default for PlacementChoice {
    fn default() -> Self {
        Self::anywhere(anywhere::Params {})
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Path, Pose};
    use crate::map::OccupancyGrid;
    use crate::rng::{EpisodeSeed, Purpose};
    use crate::world::statics::StaticMap;
    use std::sync::Arc;

    /// A hall of 20 m by 10 m, its route straight from [3, 5] to [17, 5].
    pub(super) fn hall() -> Scene {
        let map = Arc::new(StaticMap::new(OccupancyGrid::empty(20, 10, 1.0)));
        let (start, goal) = (Vec2::new(3.0, 5.0), Vec2::new(17.0, 5.0));
        let mut scene = Scene::new(&map, Pose { position: start, theta: 0.0 }, goal);
        scene.reference_route = Some(Path::polyline(&[start, goal]));
        scene
    }

    pub(super) fn stream() -> Stream {
        EpisodeSeed { seed: 31, episode: 0 }.stream(Purpose::UnknownStatic, 0)
    }
}
