//! The specification of a scene, as a scenario gives it.

use super::check::{SceneError, check_fits};
use super::place::{GoalSpec, StartSpec};
use crate::robot::Robot;
use crate::world::obstacles::{ObstaclesSpec, moving};
use crate::world::script::{self, ScriptEntry};
use crate::world::statics::{StaticMap, Statics};
use std::path::Path;

/// The specification of a scene, beside the map and the robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneSpec {
    /// Start of the robot (scenario key `start`).
    pub start: StartSpec,
    /// Goal of the robot (scenario key `goal`).
    pub goal: GoalSpec,
    /// Obstacles beside the map (scenario key `obstacles`); the files that they name have been read.
    pub obstacles: ObstaclesSpec,
    /// Events at given times (scenario key `script`).
    pub script: Vec<ScriptEntry>,
}

impl SceneSpec {
    /// The specification with the files of its obstacles read; they are looked up relative to `folder`.
    ///
    /// # Errors
    /// The first file that cannot be read.
    pub fn new(
        start: StartSpec,
        goal: GoalSpec,
        mut obstacles: ObstaclesSpec,
        script: Vec<ScriptEntry>,
        folder: &Path,
    ) -> Result<Self, SceneError> {
        obstacles.load(folder)?;
        Ok(Self { start, goal, obstacles, script })
    }

    /// Checks everything that does not depend on a draw: given places against the map and each other, ranges, velocities.
    ///
    /// # Errors
    /// The first impossible part in file order: start, goal, unknown statics, movers, script.
    pub fn check(&self, map: &StaticMap, robot: &Robot) -> Result<(), SceneError> {
        let unknown = self.obstacles.given_statics(&map.grid);
        let statics = Statics { map, unknown: &unknown };
        let start = self.start.given(&map.grid);
        if let Some((position, theta)) = start {
            check_fits("start", position, theta, robot, &statics)?;
        }
        if let Some(goal) = self.goal.given(&map.grid) {
            check_fits("goal", goal, None, robot, &statics)?;
        }
        for (entry, choice) in self.obstacles.unknown_static.iter().enumerate() {
            choice.kind().check(&format!("obstacles.unknown_static[{entry}].{}", choice.name()), map)?;
        }
        let given = moving::Given { statics, robot, start: start.map(|(position, _)| position) };
        for (entry, choice) in self.obstacles.moving.iter().enumerate() {
            choice.kind().check(&format!("obstacles.moving[{entry}].{}", choice.name()), &given)?;
        }
        let movers = self.obstacles.movers();
        let given = script::Given { known: Statics { map, unknown: &[] }, robot, movers: &movers };
        self.script.iter().enumerate().try_for_each(|(number, entry)| entry.check(number, &given))
    }
}
