//! One obstacle at a given place.

use super::{UnknownStatic, UnknownStaticKind};
use crate::geometry::Pose;
use crate::map::OccupancyGrid;
use crate::settings::Entry;
use crate::settings::quantity::Finite;
use crate::world::obstacles::{Drawing, shape::ShapeChoice};
use crate::world::scene::{FreeSpace, Infeasible, SceneError, check_inside, pose_to_grid};
use crate::world::statics::StaticMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "one obstacle at a given place" };

/// Parameters of an obstacle at a given place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Pose [x, y, theta] of the centre in the world frame, m and rad.
    pub pose: [Finite; 3],
    /// Outline. Default: a rectangle of 1 m by 1 m.
    #[serde(default)]
    pub shape: ShapeChoice,
}

impl Params {
    fn pose(&self, grid: &OccupancyGrid) -> Pose {
        pose_to_grid(self.pose, grid)
    }

    fn obstacle(&self, grid: &OccupancyGrid) -> UnknownStatic {
        UnknownStatic::new(self.pose(grid), self.shape.kind().shape())
    }
}

impl UnknownStaticKind for Params {
    fn check(&self, key: &str, map: &StaticMap) -> Result<(), SceneError> {
        check_inside(&format!("{key}.pose"), self.pose(&map.grid).position, map)
    }

    fn given(&self, grid: &OccupancyGrid) -> Option<UnknownStatic> {
        Some(self.obstacle(grid))
    }

    /// The one obstacle. It is already part of the free space.
    fn draw(&self, drawing: &Drawing<'_>, _: &mut FreeSpace<'_>) -> Result<Vec<UnknownStatic>, Infeasible> {
        Ok(vec![self.obstacle(&drawing.scene.map.grid)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::outline::Shape;

    #[test]
    fn the_pose_is_in_the_world_frame_and_must_be_on_the_map() {
        let params: Params = serde_yaml::from_str("{pose: [12, 1, 0.5], shape: {disc: {radius_m: 0.3}}}").unwrap();
        let frame = crate::map::Frame { origin: Pose::new(10.0, 0.0, 0.0) };
        let map = StaticMap::new(OccupancyGrid::empty(5, 4, 1.0).with_frame(frame));
        let given = params.given(&map.grid).unwrap();
        assert_eq!((given.pose(), given.shape()), (Pose::new(2.0, 1.0, 0.5), &Shape::Disc { radius_m: 0.3 }));
        assert_eq!(params.check("k", &map), Ok(()));
        let elsewhere = StaticMap::new(OccupancyGrid::empty(5, 4, 1.0));
        let error = params.check("k", &elsewhere).unwrap_err();
        assert_eq!(error.key, "k.pose");
        assert!(error.message.contains("in cell [12, 1], lies outside the map of 5 by 4 cells"), "{error}");
    }
}
