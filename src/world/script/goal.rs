//! Event: the goal moves. The robot is told at once and plans anew, whatever its replanning rule.

use super::{Change, Effect, Event, EventKind, Given};
use crate::geometry::Vec2;
use crate::settings::Entry;
use crate::settings::quantity::{Finite, NonNegative};
use crate::world::scene::{Digest, Scene, SceneError, check_fits, point_to_grid};
use crate::world::truth::World;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "the goal is elsewhere" };

/// Where to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// [x, y] in the world frame, m.
    pub to: [Finite; 2],
}

impl EventKind for Params {
    fn check(&self, key: &str, _: NonNegative, given: &Given<'_>) -> Result<(), SceneError> {
        let to = point_to_grid(self.to, &given.known.map.grid);
        check_fits(&format!("{key}.to"), to, None, given.robot, &given.known)
    }

    fn write(&self, at_s: NonNegative, scene: &mut Scene) {
        let to = point_to_grid(self.to, &scene.map.grid);
        scene.script.push(Event::at(at_s, Change::goal(to)));
    }
}

/// The change that moves the goal.
#[derive(Debug)]
struct Goal(Vec2);

impl Change {
    /// Moves the goal to `to`, grid frame, m.
    pub fn goal(to: Vec2) -> Self {
        Self::new(Goal(to))
    }
}

impl Effect for Goal {
    fn apply(&self, world: &mut World<'_>) {
        world.set_goal(self.0);
    }

    fn digest(&self, digest: &mut Digest) {
        digest.word(4);
        digest.point(self.0);
    }

    fn moves_the_task(&self) -> bool {
        true
    }

    fn goal(&self) -> Option<Vec2> {
        Some(self.0)
    }
}
