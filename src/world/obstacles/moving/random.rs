//! Movers with random position and heading, each from its own random stream.

use super::{Given, Mover, MovingKind, OnRobot, OnStatic, manners, radius_default, yield_distance_default};
use crate::geometry::{Vec2, direction};
use crate::map::Cell;
use crate::math;
use crate::rng::{Purpose, Stream};
use crate::robot::OutlineCorners;
use crate::settings::Entry;
use crate::settings::quantity::{CountOrZero, NonNegative, Positive};
use crate::world::motion::MotionChoice;
use crate::world::obstacles::Drawing;
use crate::world::scene::{Infeasible, SceneError, TRIES, check_range};
use crate::world::statics::StaticMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "movers with random position and heading, each from its own random stream" };

/// Which way a random mover sets out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Heading {
    /// Uniformly random: between walls it ricochets.
    #[default]
    Any,
    /// Either way along that axis of the known map in which the free run through its place is longer: up and
    /// down the aisle, as traffic between racks does. Equal runs: along x.
    AlongAisle,
}

/// Parameters of random movers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// How many. Default: 1.
    pub count: CountOrZero,
    /// Radius of the disc, m. Default: 0.3.
    pub radius_m: Positive,
    /// A convex outline in place of the disc: corners [x, y], m, x along its way at first; it keeps that heading. Default: none.
    pub footprint: Option<OutlineCorners>,
    /// Range [lowest, highest] from which the speed is drawn, m/s. Default: [0.5, 1].
    pub speed_mps: [NonNegative; 2],
    /// Which way they set out. Default: any.
    pub heading: Heading,
    /// How they go on after they have set out. Default: uniform.
    pub motion: MotionChoice,
    /// At a wall, an unknown static or the map's edge. Default: reflect.
    pub on_static: OnStatic,
    /// Towards the robot. Default: ignore.
    pub on_robot: OnRobot,
    /// Surface distance within which a yielding mover stops for a robot ahead of it, m. Default: 1.
    pub yield_distance_m: NonNegative,
    /// Least surface distance to the robot at the start, m. Default: 3.
    pub keep_from_start_m: NonNegative,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            count: CountOrZero::new(1),
            radius_m: radius_default(),
            footprint: None,
            speed_mps: [NonNegative::new(0.5), NonNegative::new(1.0)],
            heading: Heading::default(),
            motion: MotionChoice::default(),
            on_static: OnStatic::default(),
            on_robot: OnRobot::default(),
            yield_distance_m: yield_distance_default(),
            keep_from_start_m: NonNegative::new(3.0),
        }
    }
}

manners!();

impl MovingKind for Params {
    fn check(&self, key: &str, _: &Given<'_>) -> Result<(), SceneError> {
        check_range(&format!("{key}.speed_mps"), self.speed_mps.map(NonNegative::get))?;
        self.motion.check(key)
    }

    fn count(&self) -> usize {
        self.count.get() as usize
    }

    fn draw(&self, drawing: &Drawing<'_>) -> Result<Vec<Mover>, Infeasible> {
        let one = |number| {
            let mover = self
                .draw_one(drawing, drawing.stream(Purpose::Dynamic, number))
                .ok_or_else(|| drawing.no_place("obstacles.moving", number))?;
            let stream = drawing.stream(Purpose::Motion, number);
            Ok(Mover { motion: self.motion.kind().motion(self.speed_mps.map(NonNegative::get), stream), ..mover })
        };
        (0..self.count.get()).map(one).collect()
    }
}

impl Params {
    /// One mover: clear of every static obstacle and of the robot's start; `None` after too many draws.
    fn draw_one(&self, drawing: &Drawing<'_>, mut stream: Stream) -> Option<Mover> {
        let scene = drawing.scene;
        let extent = scene.map.grid.extent_m();
        let [slowest, fastest] = self.speed_mps.map(NonNegative::get);
        let speed = stream.range(slowest, fastest);
        let heading = stream.range(-math::PI, math::PI);
        let shape = self.manners().outline(Vec2::zeros());
        let keep = self.keep_from_start_m.get() + drawing.robot.radius_m + shape.circumradius_m();
        (0..TRIES).find_map(|_| {
            let position = Vec2::new(stream.range(0.0, extent.x), stream.range(0.0, extent.y));
            let way = match self.heading {
                Heading::Any => direction(heading),
                Heading::AlongAisle => math::sign(heading) * aisle(&scene.map, position, shape.shape().inradius_m()),
            };
            let outline = self.manners().outline(way);
            let clear =
                (position - scene.start.position).norm() >= keep && scene.statics().gap_m(&outline, position) >= 0.0;
            clear.then(|| self.manners().mover(position, speed * way, outline))
        })
    }
}

/// The unit vector along x or y in which a disc has the longer free run through `position` on the known map, by
/// whole cells; equal runs: along x.
fn aisle(map: &StaticMap, position: Vec2, radius_m: f64) -> Vec2 {
    let here = map.grid.cell_at(position);
    let run = |(cols, rows): (i32, i32)| {
        let ahead = (1..).map(|k| Cell { col: here.col + k * cols, row: here.row + k * rows });
        ahead.take_while(|&cell| map.grid.contains(cell) && map.field.distance_m(cell) >= radius_m).count()
    };
    if run((1, 0)) + run((-1, 0)) >= run((0, 1)) + run((0, -1)) { Vec2::new(1.0, 0.0) } else { Vec2::new(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Twist;
    use crate::map::OccupancyGrid;
    use crate::robot::Robot;
    use crate::world::scene::Scene;
    use crate::world::scene::tests::{paper_scene, seed, spec};
    use crate::world::{Conditions, World};
    use std::sync::Arc;

    #[test]
    fn movers_of_an_aisle_set_out_along_it() {
        // An aisle along x below, one along y on the right: each two cells wide and longer than wide.
        let rows = ["########..", "########..", "########..", "########..", "..........", ".........."];
        let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(&rows, 1.0)));
        let spec = spec(
            "[0.5, 0.5]",
            "[1.5, 0.5]",
            "{moving: [random: {count: 4, heading: along_aisle, keep_from_start_m: 0}]}",
        );
        let (mut along_x, mut along_y) = (0, 0);
        for episode in 0..200 {
            for mover in Scene::generate(&spec, &map, &Robot::default(), seed(episode)).unwrap().movers {
                let (x, v) = (mover.position.x, mover.velocity);
                assert!(v.x == 0.0 || v.y == 0.0, "{v:?}");
                if x < 8.0 {
                    assert!(v.x != 0.0, "{mover:?}");
                    along_x += i32::from(v.x > 0.0);
                } else if mover.position.y > 2.0 {
                    assert!(v.y != 0.0, "{mover:?}");
                    along_y += i32::from(v.y > 0.0);
                }
            }
        }
        assert!(along_x > 50 && along_y > 50, "either way: {along_x} {along_y}");
    }

    #[test]
    fn random_movers_never_enter_statics_while_driving() {
        for episode in 0..60 {
            let Ok(scene) = paper_scene(episode) else { continue };
            let robot = Robot::default();
            let mut world = World::new(&scene, &robot, &Conditions::default());
            for _ in 0..100 {
                world.step(Twist::ZERO);
                for (mover, begin) in world.movers().iter().zip(&scene.movers) {
                    assert!(scene.statics().distance_m(mover.position) > mover.radius_m() - 1e-8);
                    assert!(
                        (mover.velocity.norm() - begin.velocity.norm()).abs() < 1e-9 || mover.velocity.norm() == 0.0
                    );
                }
            }
        }
    }
}
