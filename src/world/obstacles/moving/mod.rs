//! Obstacles that move, discs or convex outlines that keep their heading: one file per kind.

pub mod recording;

use super::Drawing;
use crate::geometry::Vec2;
use crate::geometry::outline::{Body, Outline, SLACK_M, Shape};
use crate::robot::{OutlineCorners, Robot};
use crate::settings::quantity::{NonNegative, Positive};
use crate::settings::{Entry, registry};
use crate::world::motion::Motion;
use crate::world::scene::{Infeasible, SceneError};
use crate::world::statics::Statics;
use core::fmt::Debug;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

registry! {
    /// A moving obstacle.
    pub enum MovingChoice: "kind of moving obstacle", Entry, dyn MovingKind { fixed, random, crossing, patrol, replay }
}

/// Behaviour of a kind of moving obstacle.
pub trait MovingKind: Debug {
    /// Reads the files that the parameters name, relative to `folder`; `key` is that of the entry.
    ///
    /// # Errors
    /// The first file that cannot be read.
    fn load(&mut self, key: &str, folder: &Path) -> Result<(), SceneError> {
        let _ = (key, folder);
        Ok(())
    }

    /// The files that [`load`](Self::load) reads, as the parameters name them.
    fn files(&self) -> Vec<PathBuf> {
        Vec::new()
    }

    /// Checks everything that does not depend on a draw; `key` is that of the entry, such as `obstacles.moving[2].fixed`.
    ///
    /// # Errors
    /// The first invalid parameter.
    fn check(&self, key: &str, given: &Given<'_>) -> Result<(), SceneError>;

    /// Number of movers of this entry.
    fn count(&self) -> usize;

    /// Whether movers are placed by the scene's reference route.
    fn needs_route(&self) -> bool {
        false
    }

    /// The reason why a script may not give these movers that order, in words that follow "mover 3 …"; `None` if it may.
    fn refuses(&self, order: Order) -> Option<&'static str> {
        let _ = order;
        None
    }

    /// The movers of this entry; the unknown statics are in the scene already.
    ///
    /// # Errors
    /// The first mover that found no place.
    fn draw(&self, drawing: &Drawing<'_>) -> Result<Vec<Mover>, Infeasible>;
}

/// The given parts of a scenario, against which a kind checks its parameters.
#[derive(Debug)]
pub struct Given<'a> {
    /// The known map and the unknown statics whose pose is given.
    pub statics: Statics<'a>,
    /// The robot.
    pub robot: &'a Robot,
    /// Start of the robot, grid frame; `None` if it is drawn.
    pub start: Option<Vec2>,
}

impl Given<'_> {
    /// Whether a mover that begins at `position` overlaps the robot at its given start.
    fn meets_robot(&self, outline: &Outline, position: Vec2) -> bool {
        self.start.is_some_and(|start| (start - position).norm() < outline.circumradius_m() + self.robot.radius_m)
    }
}

/// An order that a script may give a mover.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// To appear or to vanish.
    Presence,
    /// To stand or to go on.
    Halt,
    /// To take another velocity.
    Velocity,
}

/// What a mover does at a wall, an unknown static or the map's edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnStatic {
    /// Bounces off like a billiard ball: speed kept.
    #[default]
    Reflect,
    /// Goes through, as if nothing were there (and leaves the map).
    Pass,
    /// Stands still there for the rest of the episode.
    Stop,
    /// Goes back the way it came, on its own line: the cart that meets a pallet in its aisle.
    TurnBack,
}

/// What a mover does about the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnRobot {
    /// Moves on as if the robot were not there.
    #[default]
    Ignore,
    /// Stands still while the robot is close ahead (`yield_distance_m`), then goes on.
    Yield,
}

/// Body and manners of a mover, as the parameters of most kinds give them.
#[derive(Clone, Copy, Debug)]
struct Manners<'a> {
    radius_m: Positive,
    footprint: Option<&'a OutlineCorners>,
    on_static: OnStatic,
    on_robot: OnRobot,
    yield_distance_m: NonNegative,
}

/// Gives `Params` the function that collects its keys of body and manners.
macro_rules! manners {
    () => {
        impl Params {
            fn manners(&self) -> super::Manners<'_> {
                super::Manners {
                    radius_m: self.radius_m,
                    footprint: self.footprint.as_ref(),
                    on_static: self.on_static,
                    on_robot: self.on_robot,
                    yield_distance_m: self.yield_distance_m,
                }
            }
        }
    };
}
use manners;

impl Manners<'_> {
    /// The outline: the footprint with x pointing `forward` (along the grid's x if that is no direction), or a disc.
    fn outline(&self, forward: Vec2) -> Outline {
        let length = forward.norm();
        let axis = if length > 0.0 { forward / length } else { Vec2::new(1.0, 0.0) };
        match self.footprint {
            None => Outline::disc(self.radius_m.get()),
            Some(corners) => Outline::new(Shape::Polygon(corners.polygon().clone()), 0.0).with_axis(axis),
        }
    }

    /// Radius of the smallest disc about the centre that holds the outline, whichever way it points, m.
    fn circumradius_m(&self) -> f64 {
        self.outline(Vec2::zeros()).circumradius_m()
    }

    /// The mover at `position` (grid frame), going straight on at `velocity`.
    fn mover(&self, position: Vec2, velocity: Vec2, outline: Outline) -> Mover {
        Mover {
            on_static: self.on_static,
            on_robot: self.on_robot,
            yield_distance_m: self.yield_distance_m.get(),
            ..Mover::with_outline(position, velocity, outline)
        }
    }
}

fn radius_default() -> Positive {
    Positive::new(0.3)
}

fn yield_distance_default() -> NonNegative {
    NonNegative::new(1.0)
}

/// A moving obstacle. Its outline keeps its heading: it moves, but does not turn.
#[derive(Clone, Debug, PartialEq)]
pub struct Mover {
    /// Centre, grid frame, m.
    pub position: Vec2,
    /// Velocity at this moment, m/s; zero while it yields or after it has stopped.
    pub velocity: Vec2,
    /// Its outline.
    pub outline: Outline,
    /// Behaviour at a static obstacle or the map's edge.
    pub on_static: OnStatic,
    /// Behaviour towards the robot.
    pub on_robot: OnRobot,
    /// Surface distance within which it stops for a robot ahead, if it yields, m.
    pub yield_distance_m: f64,
    /// Its motion.
    pub motion: Motion,
    /// Whether it is present; an absent mover is neither sensed nor touched.
    pub present: bool,
}

impl Mover {
    /// A disc that bounces off statics and ignores the robot.
    pub fn new(position: Vec2, velocity: Vec2, radius_m: f64) -> Self {
        Self::with_outline(position, velocity, Outline::disc(radius_m))
    }

    /// A mover of any outline that bounces off statics and ignores the robot.
    pub fn with_outline(position: Vec2, velocity: Vec2, outline: Outline) -> Self {
        let (on_static, on_robot) = (OnStatic::Reflect, OnRobot::Ignore);
        let (motion, present) = (Motion::default(), true);
        Self { position, velocity, outline, on_static, on_robot, yield_distance_m: 1.0, motion, present }
    }

    /// Radius of the smallest disc about its centre that holds it, m.
    pub fn radius_m(&self) -> f64 {
        self.outline.circumradius_m()
    }

    /// Signed distance between a body and the mover with its centre at `position`, m: negative where they overlap.
    pub fn gap_m(&self, position: Vec2, body: &Body) -> f64 {
        self.outline.gap_m(position, body)
    }
}
