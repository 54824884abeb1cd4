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
        self.faults(map, robot).into_iter().next().map_or(Ok(()), Err)
    }

    /// Every impossible part, in the order of [`Self::check`]; of each entry of a list the first.
    pub fn faults(&self, map: &StaticMap, robot: &Robot) -> Vec<SceneError> {
        let unknown = self.obstacles.given_statics(&map.grid);
        let statics = Statics { map, unknown: &unknown };
        let mut faults = Vec::new();
        let start = self.start.given(&map.grid);
        if let Some((position, theta)) = start {
            faults.extend(check_fits("start", position, theta, robot, &statics).err());
        }
        if let Some(goal) = self.goal.given(&map.grid) {
            faults.extend(check_fits("goal", goal, None, robot, &statics).err());
        }
        for (entry, choice) in self.obstacles.unknown_static.iter().enumerate() {
            let key = format!("obstacles.unknown_static[{entry}].{}", choice.name());
            faults.extend(choice.kind().check(&key, map).err());
        }
        let given = moving::Given { statics, robot, start: start.map(|(position, _)| position) };
        for (entry, choice) in self.obstacles.moving.iter().enumerate() {
            let key = format!("obstacles.moving[{entry}].{}", choice.name());
            faults.extend(choice.kind().check(&key, &given).err());
        }
        let movers = self.obstacles.movers();
        let given = script::Given { known: Statics { map, unknown: &[] }, robot, movers: &movers };
        faults.extend(self.script.iter().enumerate().filter_map(|(number, entry)| entry.check(number, &given).err()));
        faults
    }
}
