//! Obstacles at random places, each from its own random stream.

use super::{UnknownStatic, UnknownStaticKind};
use crate::geometry::Pose;
use crate::math;
use crate::rng::{Purpose, Stream};
use crate::settings::Entry;
use crate::settings::quantity::{CountOrZero, NonNegative};
use crate::world::obstacles::{Drawing, placement::PlacementChoice, shape::ShapeChoice};
use crate::world::scene::{FreeSpace, Infeasible, SceneError, TRIES};
use crate::world::statics::StaticMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "obstacles at random places, each from its own random stream" };

/// Parameters of obstacles at random places.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// How many. Default: 1.
    pub count: CountOrZero,
    /// Outline. Default: a rectangle of 1 m by 1 m.
    pub shape: ShapeChoice,
    /// Where. Default: anywhere.
    pub placement: PlacementChoice,
    /// Put the centre on a cell centre with the sides along the grid, as the papers' "obstacle
    /// cells"; otherwise place and heading are free. Default: false.
    pub snap_to_cells: bool,
    /// Keep the cells it touches from being 8-adjacent to the cells of any other static
    /// obstacle or to the map's edge, so that it never closes a pocket. Default: false.
    pub apart_from_obstacles: bool,
    /// Least distance from its surface to the robot's centre at the start and to the goal, m;
    /// the robot's radius where that is larger. Default: 1.
    pub keep_from_ends_m: NonNegative,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            count: CountOrZero::new(1),
            shape: ShapeChoice::default(),
            placement: PlacementChoice::default(),
            snap_to_cells: false,
            apart_from_obstacles: false,
            keep_from_ends_m: NonNegative::new(1.0),
        }
    }
}

impl UnknownStaticKind for Params {
    fn check(&self, key: &str, _: &StaticMap) -> Result<(), SceneError> {
        self.placement.kind().check(&format!("{key}.placement.{}", self.placement.name()))
    }

    fn needs_route(&self) -> bool {
        self.placement.kind().needs_route()
    }

    fn draw(&self, drawing: &Drawing<'_>, space: &mut FreeSpace<'_>) -> Result<Vec<UnknownStatic>, Infeasible> {
        let one = |number: u32| {
            let stream = drawing.stream(Purpose::UnknownStatic, number);
            self.draw_one(drawing, space, stream).ok_or_else(|| drawing.no_place("obstacles.unknown_static", number))
        };
        (0..self.count.get()).map(one).collect()
    }
}

impl Params {
    /// One obstacle: on free cells, clear of both ends, start and goal still connected; `None` after too many draws.
    fn draw_one(&self, drawing: &Drawing<'_>, space: &mut FreeSpace<'_>, mut stream: Stream) -> Option<UnknownStatic> {
        let scene = drawing.scene;
        let grid = &scene.map.grid;
        let (start, goal) = (scene.start.position, scene.goal);
        let cells = [start, goal].map(|end| grid.index(grid.cell_at(end)));
        let shape = self.shape.kind().shape();
        let keep = math::max(self.keep_from_ends_m.get(), drawing.robot.radius_m);
        for _ in 0..TRIES {
            let theta = stream.range(-math::PI, math::PI);
            let Some(position) = self.placement.kind().draw(scene, &mut stream) else { continue };
            let pose = if self.snap_to_cells {
                Pose { position: grid.centre(grid.cell_at(position)), theta: 0.0 }
            } else {
                Pose { position, theta }
            };
            let obstacle = UnknownStatic::new(pose, shape.clone());
            if obstacle.distance_m(start) < keep || obstacle.distance_m(goal) < keep {
                continue;
            }
            let touched = space.touched(&obstacle);
            if touched.is_empty() || space.overlaps(&touched) || (self.apart_from_obstacles && space.adjoins(&touched))
            {
                continue;
            }
            let blocked = space.add(&touched);
            if space.components().connected(cells[0], cells[1]) {
                return Some(obstacle);
            }
            space.remove(&touched, &blocked);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vec2;
    use crate::map::OccupancyGrid;
    use crate::robot::Robot;
    use crate::world::scene::Scene;
    use crate::world::scene::tests::seed;
    use std::sync::Arc;

    /// The obstacles drawn by the parameters in a lane of 9 by 3 cells, the robot at its left end, the goal at its right.
    fn draw(yaml: &str, rows: [&str; 3], episode: u64) -> Result<Vec<UnknownStatic>, Infeasible> {
        let params: Params = serde_yaml::from_str(yaml).unwrap();
        let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(&rows, 1.0)));
        let scene = Scene::new(&map, Pose::new(0.5, 1.5, 0.0), Vec2::new(8.5, 1.5));
        let robot = Robot::default();
        let drawing = Drawing { scene: &scene, robot: &robot, seed: seed(episode), entry: 2 };
        params.draw(&drawing, &mut FreeSpace::new(&map, robot.radius_m))
    }

    #[test]
    fn obstacles_keep_from_the_ends_snap_and_leave_a_way() {
        let open = [".........", ".........", "........."];
        for episode in 0..50 {
            let drawn = draw("{count: 3, snap_to_cells: true, keep_from_ends_m: 1.2}", open, episode).unwrap();
            let mut cols = Vec::new();
            for obstacle in &drawn {
                let p = obstacle.pose().position;
                assert_eq!((p.x.fract(), p.y.fract(), obstacle.pose().theta), (0.5, 0.5, 0.0));
                assert!(
                    obstacle.distance_m(Vec2::new(0.5, 1.5)) >= 1.2 && obstacle.distance_m(Vec2::new(8.5, 1.5)) >= 1.2
                );
                cols.push(p.x);
            }
            // Three in one column would close the lane.
            assert!(cols.windows(2).any(|pair| pair[0] != pair[1]));
        }
    }

    #[test]
    fn a_lane_that_every_obstacle_closes_has_no_place() {
        let lane = ["#########", ".........", "#########"];
        let error = draw("{snap_to_cells: true}", lane, 0).unwrap_err();
        assert_eq!(error.message, "no place for number 0 of obstacles.unknown_static[2] in 1000 draws");
        let apart = draw("{snap_to_cells: true, apart_from_obstacles: true}", ["........."; 3], 0).unwrap();
        assert_eq!(apart[0].pose().position.y, 1.5, "the only row that is not at the edge");
    }
}
