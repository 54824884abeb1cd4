//! Event: the goal moves. The robot is told at once and plans anew, whatever its replanning rule.

use super::{Change, Effect, Event, EventKind, Given};
use crate::geometry::{Pose, Vec2};
use crate::settings::Entry;
use crate::settings::quantity::{Finite, NonNegative};
use crate::world::scene::{Digest, Scene, SceneError, check_fits, point_to_grid, pose_to_grid};
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
    /// Heading that the robot is to have there, world frame, rad, where it has to stand (`termination.arrive`). Default: any.
    #[serde(default)]
    pub heading_rad: Option<Finite>,
}

impl EventKind for Params {
    fn check(&self, key: &str, _: NonNegative, given: &Given<'_>) -> Result<(), SceneError> {
        let to = point_to_grid(self.to, &given.known.map.grid);
        check_fits(&format!("{key}.to"), to, None, given.robot, &given.known)
    }

    fn write(&self, at_s: NonNegative, scene: &mut Scene) {
        let (grid, [x, y]) = (&scene.map.grid, self.to);
        let change = match self.heading_rad {
            None => Change::goal(point_to_grid(self.to, grid)),
            Some(theta) => Change::goal_pose(pose_to_grid([x, y, theta], grid)),
        };
        scene.script.push(Event::at(at_s, change));
    }
}

/// The change that moves the goal.
#[derive(Debug)]
struct Goal {
    to: Vec2,
    heading_rad: Option<f64>,
}

impl Change {
    /// Moves the goal to `to`, grid frame, m.
    pub fn goal(to: Vec2) -> Self {
        Self::new(Goal { to, heading_rad: None })
    }

    /// Moves the goal to `pose`, grid frame, whose heading the robot is to have where it has to stand there.
    pub fn goal_pose(pose: Pose) -> Self {
        Self::new(Goal { to: pose.position, heading_rad: Some(pose.theta) })
    }
}

impl Effect for Goal {
    fn apply(&self, world: &mut World<'_>) {
        world.set_goal(self.to, self.heading_rad);
    }

    fn digest(&self, digest: &mut Digest) {
        digest.word(4);
        digest.point(self.to);
        if let Some(heading_rad) = self.heading_rad {
            digest.real(heading_rad);
        }
    }

    fn moves_the_task(&self) -> bool {
        true
    }

    fn goal(&self) -> Option<Vec2> {
        Some(self.to)
    }
}
