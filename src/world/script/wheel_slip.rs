//! Event: the slip of the wheels changes; see `actuation`.

use super::{Change, Effect, Event, EventKind, Given};
use crate::settings::Entry;
use crate::settings::quantity::{Fraction, NonNegative};
use crate::world::scene::{Digest, Scene, SceneError, check_range};
use crate::world::truth::World;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "the wheels lose other shares of their speed to the ground" };

/// How much.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Range of the left wheel's share; default [0, 0].
    #[serde(default = "grip")]
    pub left: [Fraction; 2],
    /// Range of the right wheel's share; default [0, 0].
    #[serde(default = "grip")]
    pub right: [Fraction; 2],
}

fn grip() -> [Fraction; 2] {
    [Fraction::new(0.0); 2]
}

impl EventKind for Params {
    fn check(&self, key: &str, _: NonNegative, _: &Given<'_>) -> Result<(), SceneError> {
        check_range(&format!("{key}.left"), self.left.map(Fraction::get))?;
        check_range(&format!("{key}.right"), self.right.map(Fraction::get))
    }

    fn write(&self, at_s: NonNegative, scene: &mut Scene) {
        scene.script.push(Event::at(at_s, Change::wheel_slip(self.left, self.right)));
    }
}

/// The change that sets the slip of the wheels.
#[derive(Debug)]
struct WheelSlip {
    left: [Fraction; 2],
    right: [Fraction; 2],
}

impl Change {
    /// Each wheel loses a share of its speed from these ranges from now on; see
    /// [`ActuationSpec`](crate::world::ActuationSpec).
    pub fn wheel_slip(left: [Fraction; 2], right: [Fraction; 2]) -> Self {
        Self::new(WheelSlip { left, right })
    }
}

impl Effect for WheelSlip {
    fn apply(&self, world: &mut World<'_>) {
        world.set_wheel_slip(self.left, self.right);
    }

    fn digest(&self, digest: &mut Digest) {
        digest.word(6);
        [self.left, self.right].as_flattened().iter().for_each(|share| digest.real(share.get()));
    }
}
