//! Event: a mover that goes straight on takes another velocity.

use super::{Change, Effect, Event, EventKind, Given, movers};
use crate::geometry::Vec2;
use crate::settings::Entry;
use crate::settings::quantity::{CountOrZero, Finite, NonNegative};
use crate::world::obstacles::moving::Order;
use crate::world::scene::{Digest, Scene, SceneError, point_to_grid};
use crate::world::truth::World;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "a mover that goes straight on has another velocity from now on" };

/// Which mover, and how it moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Its number.
    pub mover: CountOrZero,
    /// Velocity [x, y] in the world frame, m/s.
    pub velocity_mps: [Finite; 2],
}

impl EventKind for Params {
    fn check(&self, key: &str, _: NonNegative, given: &Given<'_>) -> Result<(), SceneError> {
        movers::check(key, self.mover, Order::Velocity, given)
    }

    fn write(&self, at_s: NonNegative, scene: &mut Scene) {
        let [still, moving] = [[Finite::new(0.0); 2], self.velocity_mps].map(|v| point_to_grid(v, &scene.map.grid));
        scene.script.push(Event::at(at_s, Change::velocity(self.mover.get() as usize, moving - still)));
    }
}

/// The change that gives a mover another velocity.
#[derive(Debug)]
struct Velocity {
    number: usize,
    velocity: Vec2,
}

impl Change {
    /// Gives mover `number` the velocity `velocity`, m/s, grid frame.
    pub fn velocity(number: usize, velocity: Vec2) -> Self {
        Self::new(Velocity { number, velocity })
    }
}

impl Effect for Velocity {
    fn apply(&self, world: &mut World<'_>) {
        world.set_mover_velocity(self.number, self.velocity);
    }

    fn digest(&self, digest: &mut Digest) {
        digest.words([3, self.number as u64]);
        digest.point(self.velocity);
    }
}
