//! One mover with a given state at the first tick.

use super::{Given, Mover, MovingKind, OnRobot, OnStatic, SLACK_M, manners, radius_default, yield_distance_default};
use crate::geometry::outline::Outline;
use crate::geometry::{Vec2, direction};
use crate::map::OccupancyGrid;
use crate::rng::Purpose;
use crate::robot::OutlineCorners;
use crate::settings::Entry;
use crate::settings::quantity::{Finite, NonNegative, Positive};
use crate::world::motion::MotionChoice;
use crate::world::obstacles::Drawing;
use crate::world::scene::{Infeasible, SceneError, at, check_inside, point_to_grid, turn_to_grid};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "one mover with a given state at the first tick" };

/// Parameters of one mover: either `velocity_mps`, or `speed_mps` with `heading_rad`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Centre [x, y] in the world frame, m.
    pub position: [Finite; 2],
    /// Velocity [vx, vy] in the world frame, m/s.
    #[serde(default)]
    pub velocity_mps: Option<[Finite; 2]>,
    /// Speed along `heading_rad`, m/s.
    #[serde(default)]
    pub speed_mps: Option<NonNegative>,
    /// Direction of motion in the world frame, rad.
    #[serde(default)]
    pub heading_rad: Option<Finite>,
    /// Radius of the disc, m. Default: 0.3.
    #[serde(default = "radius_default")]
    pub radius_m: Positive,
    /// A convex outline in place of the disc: corners [x, y], m, x along its heading at first, which it keeps. Default: none.
    #[serde(default)]
    pub footprint: Option<OutlineCorners>,
    /// At a wall, an unknown static or the map's edge. Default: reflect.
    #[serde(default)]
    pub on_static: OnStatic,
    /// Towards the robot. Default: ignore.
    #[serde(default)]
    pub on_robot: OnRobot,
    /// How it goes on after it has set out. Default: uniform.
    #[serde(default)]
    pub motion: MotionChoice,
    /// Surface distance within which a yielding mover stops for a robot ahead of it, m. Default: 1.
    #[serde(default = "yield_distance_default")]
    pub yield_distance_m: NonNegative,
}

manners!();

impl Params {
    /// The velocity in the grid frame, m/s; the error says what is wrong with the keys that give it.
    fn velocity(&self, grid: &OccupancyGrid) -> Result<Vec2, &'static str> {
        match (self.velocity_mps, self.speed_mps, self.heading_rad) {
            (Some([x, y]), None, None) => Ok(turn_to_grid(Vec2::new(x.get(), y.get()), grid)),
            (None, Some(speed), Some(heading)) => Ok(turn_to_grid(speed.get() * direction(heading.get()), grid)),
            _ => Err("a mover needs either `velocity_mps`, or `speed_mps` with `heading_rad`"),
        }
    }

    /// The outline, its x axis along the heading or the velocity.
    fn outline(&self, grid: &OccupancyGrid) -> Outline {
        let forward = match self.heading_rad {
            Some(heading) => turn_to_grid(direction(heading.get()), grid),
            None => self.velocity(grid).unwrap_or_default(),
        };
        self.manners().outline(forward)
    }
}

impl MovingKind for Params {
    fn check(&self, key: &str, given: &Given<'_>) -> Result<(), SceneError> {
        let map = given.statics.map;
        self.velocity(&map.grid).map_err(|message| SceneError::new(key, message))?;
        self.motion.check(key)?;
        let key = format!("{key}.position");
        let position = point_to_grid(self.position, &map.grid);
        let outline = self.outline(&map.grid);
        if self.on_static != OnStatic::Pass {
            check_inside(&key, position, map)?;
            let gap = given.statics.gap_m(&outline, position);
            if gap < -SLACK_M {
                let overlap = format!("overlaps a static obstacle or the map's edge by {:.3} m", -gap);
                return Err(SceneError::new(key, format!("the mover {}", at(position, map, &overlap))));
            }
        }
        if given.meets_robot(&outline, position) {
            return Err(SceneError::new(key, "the mover overlaps the robot at its start"));
        }
        Ok(())
    }

    fn count(&self) -> usize {
        1
    }

    fn draw(&self, drawing: &Drawing<'_>) -> Result<Vec<Mover>, Infeasible> {
        let scene = drawing.scene;
        let grid = &scene.map.grid;
        let velocity = self.velocity(grid).map_err(Infeasible::new)?;
        let speed = velocity.norm();
        let mover = Mover {
            motion: self.motion.kind().motion([speed, speed], drawing.stream(Purpose::Motion, 0)),
            ..self.manners().mover(point_to_grid(self.position, grid), velocity, self.outline(grid))
        };
        let blocked =
            mover.on_static != OnStatic::Pass && scene.statics().gap_m(&mover.outline, mover.position) < -SLACK_M;
        if blocked || (mover.position - scene.start.position).norm() < mover.radius_m() + drawing.robot.radius_m {
            let entry = drawing.entry;
            return Err(Infeasible::new(format!(
                "obstacles.moving[{entry}] begins in the robot or in a random unknown static"
            )));
        }
        Ok(vec![mover])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::Frame;
    use crate::math;
    use crate::robot::Robot;
    use crate::world::statics::{StaticMap, Statics};

    #[test]
    fn a_velocity_is_given_in_one_of_two_ways_and_turned_with_the_map() {
        let frame = Frame { origin: Pose::new(3.0, 4.0, math::FRAC_PI_2) };
        let grid = OccupancyGrid::empty(4, 4, 1.0).with_frame(frame);
        let read = |rest: &str| -> Params { serde_yaml::from_str(&format!("{{position: [3, 5]{rest}}}")).unwrap() };
        // The grid's x runs along the world's y, so what goes along the world's x goes along the grid's −y.
        for rest in [", velocity_mps: [2, 0]", ", speed_mps: 2, heading_rad: 0"] {
            let velocity = read(rest).velocity(&grid).unwrap();
            assert!((velocity - Vec2::new(0.0, -2.0)).norm() < 1e-12, "{velocity:?}");
        }
        for rest in ["", ", speed_mps: 2", ", heading_rad: 0", ", velocity_mps: [2, 0], speed_mps: 2"] {
            assert!(read(rest).velocity(&grid).is_err(), "{rest}");
        }
        let cart = read(", speed_mps: 0, heading_rad: 0, footprint: [[1, 0.3], [-1, 0.3], [-1, -0.3], [1, -0.3]]");
        assert!((cart.outline(&grid).axis() - Vec2::new(0.0, -1.0)).norm() < 1e-12, "it points along its heading");
    }

    #[test]
    fn a_mover_in_a_wall_is_refused_unless_it_passes() {
        let map = StaticMap::new(OccupancyGrid::from_ascii(&["....", ".#..", "...."], 1.0));
        let robot = Robot::default();
        let given = Given { statics: Statics { map: &map, unknown: &[] }, robot: &robot, start: None };
        let check = |rest: &str| {
            let params: Params = serde_yaml::from_str(&format!("{{velocity_mps: [1, 0], {rest}}}")).unwrap();
            params.check("k", &given).map_err(|error| error.to_string())
        };
        assert!(check("position: [1.5, 1.5]").unwrap_err().starts_with("k.position: the mover at [1.500, 1.500]"));
        assert_eq!(check("position: [1.5, 1.5], on_static: pass"), Ok(()));
        assert!(check("position: [9, 9]").unwrap_err().contains("lies outside the map"));
        assert_eq!(check("position: [3, 1.5]"), Ok(()));
        let near = Given { start: Some(Vec2::new(3.0, 2.0)), ..given };
        let params: Params = serde_yaml::from_str("{velocity_mps: [1, 0], position: [3, 1.5]}").unwrap();
        assert!(params.check("k", &near).unwrap_err().message.contains("overlaps the robot"), "0.5 m < 0.3 + 0.25");
    }
}
