//! The world, the truth: the only user of rapier2d.
//!
//! A [`Scene`] is everything about one episode before its first tick, drawn from a [`SceneSpec`] or put together
//! in code; a [`World`] drives it, tick by tick of the control period ([`Conditions::control_period_s`]). Positions are in the grid frame.
//!
//! # How motion and contact are computed
//!
//! Robot and movers are integrated by us in f64: the robot on the exact arc of its twist, which is constant within a tick
//! (it changes in a step at the tick's beginning, within the limits of the drive), movers on straight pieces that
//! bounce off statics at the exact moment of contact. These poses are handed to rapier, whose bodies are kinematic
//! and position-based: rapier pushes nothing back and decides nothing. Its contact pairs are switched off, because they
//! lag by a step and fire 2 cm early; it holds the scene for queries and pictures, and tests compare its distances with
//! ours.
//!
//! Movers and the script go by time and not by tick: apart from what a mover does about the robot, and up to rounding, a world
//! goes the same way at any control period.
//!
//! The verdict of a tick comes from exact distances of our own (disc to squares, rectangles, discs and the map's edge),
//! advanced conservatively along that motion: no contact deeper than 1 mm is missed and none is invented, at any speed.
//!
//! # What is not modelled
//!
//! - The episode ends at the first contact, so there is no collision response for the robot.
//! - Movers, discs or convex outlines, pass through each other and through the robot; only statics and the map's edge
//!   turn them. One that meets more than eight surfaces within a tick, wedged in a gap of its own width, stands for the
//!   rest of it; of a recording, the first eight samples within a tick are passed on the way.
//! - Perception and actuation are perfect unless [`Conditions`] say otherwise: noise, drift, latency, slip, occlusion.

mod conditions;
mod drive;
pub mod motion;
pub mod obstacles;
mod scene;
pub mod script;
mod sense;
mod statics;
mod truth;

pub use crate::geometry::outline::{Outline, Shape};
pub use conditions::Conditions;
pub use drive::ActuationSpec;
pub use motion::{Irregular, Motion, Patrol, Replay, Sample};
pub use obstacles::ObstaclesSpec;
pub use obstacles::moving::{Mover, OnRobot, OnStatic, recording::Recording};
pub use obstacles::unknown_static::UnknownStatic;
pub use scene::{CellPlace, GoalSpec, INSIDE_KNOWN, Infeasible, RandomPlace, Scene, SceneError, SceneSpec, StartSpec};
pub use script::{Change, Event, ScriptEntry};
pub use sense::{LidarSpec, LocalisationSpec, SensingSpec};
pub use statics::StaticMap;
pub use truth::{Closest, Contact, ObstacleKind, Step, World};

/// Default of the control period ([`Conditions::control_period_s`]), s. Time is the number of the tick times the period.
pub const DT_S: f64 = 0.1;

/// Slack for rounding of times, s: an event or a change that is due at most this much after a tick's beginning is due then.
const TIME_SLACK_S: f64 = 1e-9;
