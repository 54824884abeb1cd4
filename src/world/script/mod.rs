//! The script: what happens in the world at given times, besides what moves by itself. One file per event.
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
    /// The first parameter that cannot be.
    fn check(&self, key: &str, at_s: NonNegative, given: &Given<'_>) -> Result<(), SceneError>;

    /// Writes what happens at `at_s` into the scene's script, and what it needs into the scene.
    fn write(&self, at_s: NonNegative, scene: &mut Scene);
}

/// What a scenario gives, for the checks of events.
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
    /// The first parameter that cannot be.
    pub(super) fn check(&self, number: usize, given: &Given<'_>) -> Result<(), SceneError> {
        self.event.kind().check(&format!("script[{number}].event.{}", self.event.name()), self.at_s, given)
    }
}

/// Turns the entries of a script into events by time; what happens at the same time happens in the order of the file.
pub(super) fn write(entries: &[ScriptEntry], scene: &mut Scene) {
    for ScriptEntry { at_s, event } in entries {
        event.kind().write(*at_s, scene);
    }
    scene.script.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
}

/// Something that happens at the beginning of a tick, before the robot senses: of the first that does not begin before
/// its time.
#[derive(Clone, Debug)]
pub struct Event {
    /// When, s after the beginning of the episode.
    pub at_s: f64,
    /// What.
    pub change: Change,
}

impl Event {
    fn at(time_s: NonNegative, change: Change) -> Self {
        Self { at_s: time_s.get(), change }
    }

    /// Whether it has happened once a tick has begun at `time_s`.
    pub(super) fn is_due(&self, time_s: f64) -> bool {
        self.at_s <= time_s + TIME_SLACK_S
    }

    pub(super) fn digest(&self, digest: &mut Digest) {
        digest.real(self.at_s);
        self.change.0.digest(digest);
    }
}

/// What an event changes. Obstacles and movers are numbered as in the scene, from 0.
#[derive(Clone, Debug)]
pub struct Change(Arc<dyn Effect>);

/// What every change can do.
pub(super) trait Effect: Debug + Send + Sync {
    /// Makes the change.
    fn apply(&self, world: &mut World<'_>);

    /// Takes the change into a fingerprint.
    fn digest(&self, digest: &mut Digest);

    /// Whether the shortest way from start to goal may be another one afterwards.
    fn moves_the_task(&self) -> bool {
        false
    }

    /// Where the goal is from then on, grid frame, if the change moves it.
    fn goal(&self) -> Option<Vec2> {
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

    /// Whether the shortest way from start to goal may be another one afterwards.
    pub fn moves_the_task(&self) -> bool {
        self.0.moves_the_task()
    }

    /// Where the goal is from then on, grid frame, m, if the change moves it.
    pub fn goal_moved_to(&self) -> Option<Vec2> {
        self.0.goal()
    }
}
