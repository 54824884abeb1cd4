//! Event: the range of the sensor for obstacles changes.

use super::{Change, Effect, Event, EventKind, Given};
use crate::settings::Entry;
use crate::settings::quantity::{NonNegative, Positive};
use crate::world::scene::{Digest, Scene, SceneError};
use crate::world::truth::World;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "the sensor for obstacles reaches farther or less far" };

/// How far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The range, m.
    pub range_m: Positive,
}

impl EventKind for Params {
    fn check(&self, _: &str, _: NonNegative, _: &Given<'_>) -> Result<(), SceneError> {
        Ok(())
    }

    fn write(&self, at_s: NonNegative, scene: &mut Scene) {
        scene.script.push(Event::at(at_s, Change::sensor_range(self.range_m.get())));
    }
}

/// The change that sets the range of the sensor, m.
#[derive(Debug)]
struct SensorRange(f64);

impl Change {
    /// Sets the range of the sensor for obstacles, m.
    pub fn sensor_range(range_m: f64) -> Self {
        Self::new(SensorRange(range_m))
    }
}

impl Effect for SensorRange {
    fn apply(&self, world: &mut World<'_>) {
        world.set_sensor_range_m(self.0);
    }

    fn digest(&self, digest: &mut Digest) {
        digest.word(5);
        digest.real(self.0);
    }
}
