//! The script: events at given times, such as a goal that moves or an obstacle that appears. One file per event.
//!
//! An event's file holds its parameters, its check, and the [`Change`] that it makes.

mod movers;

use super::TIME_SLACK_S;
use super::obstacles::moving::MovingKind;
use super::scene::{Digest, Scene, SceneError};
use super::statics::Statics;
use super::truth::World;
use crate::geometry::Vec2;
use crate::robot::Robot;
use crate::settings::quantity::NonNegative;
use crate::settings::{Entry, registry};
use core::fmt::Debug;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

registry! {
    /// Something that happens at a given time. Movers are numbered from 0 in the order of `obstacles.moving`.
    pub enum EventChoice: "event", Entry, dyn EventKind {
        obstacle, mover_appears, mover_vanishes, mover_stops, mover_starts, mover_velocity, goal, sensor_range, wheel_slip
    }
}

/// Behaviour of a kind of event.
pub trait EventKind {
    /// Checks the parameters; `key` is that of the event, such as `script[0].event.goal`.
    ///
    /// # Errors
    /// The first invalid parameter.
    fn check(&self, key: &str, at_s: NonNegative, given: &Given<'_>) -> Result<(), SceneError>;

    /// Writes the event at `at_s` into the scene's script, and the obstacles that it needs into the scene.
    fn write(&self, at_s: NonNegative, scene: &mut Scene);
}

/// The given parts of a scenario, against which events check their parameters.
#[derive(Debug)]
pub struct Given<'a> {
    /// The known map alone.
    pub known: Statics<'a>,
    /// The robot.
    pub robot: &'a Robot,
    /// The kind of each mover, by its number.
    pub movers: &'a [&'a dyn MovingKind],
}

/// One line of the script (scenario key `script`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScriptEntry {
    /// When it happens, s after the beginning: with the first tick that does not begin before.
    pub at_s: NonNegative,
    /// What happens.
    pub event: EventChoice,
}

impl ScriptEntry {
    /// Checks entry `number` of the script.
    ///
    /// # Errors
    /// The first invalid parameter.
    pub(super) fn check(&self, number: usize, given: &Given<'_>) -> Result<(), SceneError> {
        self.event.kind().check(&format!("script[{number}].event.{}", self.event.name()), self.at_s, given)
    }
}

/// Turns the entries of a script into events in the order of their times; ties keep the order of the file.
pub(super) fn write(entries: &[ScriptEntry], scene: &mut Scene) {
    for ScriptEntry { at_s, event } in entries {
        event.kind().write(*at_s, scene);
    }
    scene.script.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
}

/// An event. It happens at the beginning of the first tick that does not begin before its time, before the robot senses.
#[derive(Clone, Debug)]
pub struct Event {
    /// Time, s after the beginning of the episode.
    pub at_s: f64,
    /// The change that it makes.
    pub change: Change,
}

impl Event {
    fn at(time_s: NonNegative, change: Change) -> Self {
        Self { at_s: time_s.get(), change }
    }

    /// Whether it is due by the beginning of a tick at `time_s`.
    pub(super) fn is_due(&self, time_s: f64) -> bool {
        self.at_s <= time_s + TIME_SLACK_S
    }

    pub(super) fn digest(&self, digest: &mut Digest) {
        digest.real(self.at_s);
        self.change.0.digest(digest);
    }
}

/// The change that an event makes. Obstacles and movers are numbered as in the scene, from 0.
#[derive(Clone, Debug)]
pub struct Change(Arc<dyn Effect>);

/// Behaviour of every change.
pub(super) trait Effect: Debug + Send + Sync {
    /// Makes the change.
    fn apply(&self, world: &mut World<'_>);

    /// Adds the change to a fingerprint.
    fn digest(&self, digest: &mut Digest);

    /// Whether the change may alter the shortest way from start to goal.
    fn moves_the_task(&self) -> bool {
        false
    }

    /// The new goal, grid frame, m, if the change moves it.
    fn goal(&self) -> Option<Vec2> {
        None
    }

    /// The number of an unknown static and whether it is there from now on, if the change makes one appear or vanish.
    fn obstacle(&self) -> Option<(usize, bool)> {
        None
    }
}

impl Change {
    fn new(effect: impl Effect + 'static) -> Self {
        Self(Arc::new(effect))
    }

    pub(super) fn apply(&self, world: &mut World<'_>) {
        self.0.apply(world);
    }

    /// Whether the change may alter the shortest way from start to goal.
    pub fn moves_the_task(&self) -> bool {
        self.0.moves_the_task()
    }

    /// The new goal, grid frame, m, if the change moves it.
    pub fn goal_moved_to(&self) -> Option<Vec2> {
        self.0.goal()
    }

    /// The number of an unknown static and whether it is there from now on, if the change makes one appear or vanish.
    pub fn obstacle_presence(&self) -> Option<(usize, bool)> {
        self.0.obstacle()
    }
}
