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

/// What the registry says of it.
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
    /// The velocity in the grid frame, or what is wrong with how it is given.
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
