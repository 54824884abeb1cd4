//! Event: an obstacle that stands still appears, to block an aisle. It is on no map; the robot knows of it once it senses it.

use super::{Change, Effect, Event, EventKind, Given};
use crate::settings::Entry;
use crate::settings::quantity::{Finite, NonNegative};
use crate::world::obstacles::shape::ShapeChoice;
use crate::world::obstacles::unknown_static::UnknownStatic;
use crate::world::scene::{Digest, Scene, SceneError, check_inside, pose_to_grid};
use crate::world::truth::World;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "an obstacle that stands still appears" };

/// Where, what, how long.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Pose [x, y, theta] of the centre in the world frame, m and rad.
    pub pose: [Finite; 3],
    /// Outline. Default: a rectangle of 1 m by 1 m.
    #[serde(default)]
    pub shape: ShapeChoice,
    /// When it vanishes again, s after the beginning; by default it stays. The robot believes in it until it sees that it
    /// is gone.
    #[serde(default)]
    pub until_s: Option<NonNegative>,
}

impl EventKind for Params {
    fn check(&self, key: &str, at_s: NonNegative, given: &Given<'_>) -> Result<(), SceneError> {
        let map = given.known.map;
        check_inside(&format!("{key}.pose"), pose_to_grid(self.pose, &map.grid).position, map)?;
        match self.until_s.filter(|&until_s| until_s <= at_s) {
            None => Ok(()),
            Some(until_s) => {
                let message = format!("it would vanish ({} s) before it appears ({} s)", until_s.get(), at_s.get());
                Err(SceneError::new(format!("{key}.until_s"), message))
            }
        }
    }

    fn write(&self, at_s: NonNegative, scene: &mut Scene) {
        let pose = pose_to_grid(self.pose, &scene.map.grid);
        let number = scene.unknown_static.len();
        scene.unknown_static.push(UnknownStatic::new(pose, self.shape.kind().shape()).with_presence(false));
        if let Some(until_s) = self.until_s {
            scene.script.push(Event::at(until_s, Change::obstacle(number, false)));
        }
        scene.script.push(Event::at(at_s, Change::obstacle(number, true)));
    }
}

/// The change that makes an unknown static appear or vanish.
#[derive(Debug)]
struct Presence {
    number: usize,
    present: bool,
}

impl Change {
    /// Makes obstacle `number` among the unknown statics appear or vanish. One that appears on the robot hits it.
    pub fn obstacle(number: usize, present: bool) -> Self {
        Self::new(Presence { number, present })
    }
}

impl Effect for Presence {
    fn apply(&self, world: &mut World<'_>) {
        world.set_obstacle_presence(self.number, self.present);
    }

    fn digest(&self, digest: &mut Digest) {
        digest.words([0, self.number as u64, u64::from(self.present)]);
    }

    fn moves_the_task(&self) -> bool {
        true
    }

    fn obstacle(&self) -> Option<(usize, bool)> {
        Some((self.number, self.present))
    }
}
