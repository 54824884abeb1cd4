//! A scene: everything about one episode's world before the first tick, given or drawn. Equal for all stacks.
//!
//! Order of a draw: given unknown statics, start and goal, reference route, random unknown statics, movers (which
//! reflect on the statics). Every obstacle draws from a stream of its own, (purpose, entry of the list, number within
//! the entry): appending one, or raising a count, leaves the bits of the others as they were. (An unknown static
//! that is added *before* others in the list may push those that it now overlaps to another of their own draws.)
//!
//! A scene is feasible if the footprint fits at start and goal and a disc of the clearance below can go
//! from one to the other over the cell centres of the true map, in which every cell that an unknown static touches
//! is occupied. The clearance is the robot's radius and a margin of 0.05 m, like the default inflation of the planning grid. No
//! setting of a planner shapes the world, so a feasible scene may be too narrow for a wider `planning.inflation_m`. If a given
//! start or goal lies inside the margin, the clearance is the footprint alone.
//! Draws are bounded: something that finds no place within [`TRIES`] draws makes the scene infeasible, which is a result.

mod check;
mod digest;
mod ends;
mod free_space;
mod place;
mod route;
mod spec;
#[cfg(test)]
pub(super) mod tests;

use super::obstacles::Drawing;
use super::obstacles::moving::Mover;
use super::obstacles::unknown_static::UnknownStatic;
use super::script::{self, Event};
use super::statics::{StaticMap, Statics};
use crate::geometry::outline::SLACK_M;
use crate::geometry::{Path, Pose, Vec2};
use crate::math;
use crate::rng::EpisodeSeed;
use crate::robot::Robot;
use std::sync::Arc;

pub use check::{INSIDE_KNOWN, SceneError};
pub(super) use check::{at, check_fits, check_inside, check_range};
pub(super) use digest::Digest;
pub use free_space::FreeSpace;
pub(super) use free_space::FreeSpaceCache;
pub use place::{CellPlace, GoalSpec, RandomPlace, StartSpec};
pub(super) use place::{point_to_grid, pose_to_grid, turn_to_grid};
pub use spec::SceneSpec;

/// Draws for one start and goal, one unknown static or one mover.
pub(super) const TRIES: u32 = 1000;

/// No feasible scene was found: an outcome of the episode, not an error.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Infeasible {
    /// A message that says what could not be placed.
    pub message: String,
}

impl Infeasible {
    pub(super) fn new(message: impl Into<String>) -> Self {
        Self { message: message.into() }
    }
}

/// One episode's world before the first tick.
///
/// [`Scene::generate`](Self::generate) draws one from a specification; code may also put one together by hand.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The known map.
    pub map: Arc<StaticMap>,
    /// Start of the robot, grid frame.
    pub start: Pose,
    /// Goal of the robot, grid frame.
    pub goal: Vec2,
    /// Heading that the robot is to have at the goal where it has to stand there, grid frame, rad.
    pub goal_heading_rad: Option<f64>,
    /// A way from start to goal on the known map that no planner has shaped; obstacles "on the route" are placed on it.
    /// `None` if no obstacle is placed by it.
    pub reference_route: Option<Path>,
    /// Obstacles that stand still and are not on the map.
    pub unknown_static: Vec<UnknownStatic>,
    /// Moving obstacles.
    pub movers: Vec<Mover>,
    /// Events in the order of their times.
    pub script: Vec<Event>,
}

impl Scene {
    /// A scene with nothing but a map, a start and a goal.
    pub fn new(map: &Arc<StaticMap>, start: Pose, goal: Vec2) -> Self {
        let (unknown_static, movers, script) = (Vec::new(), Vec::new(), Vec::new());
        Self {
            map: Arc::clone(map),
            start,
            goal,
            goal_heading_rad: None,
            reference_route: None,
            unknown_static,
            movers,
            script,
        }
    }

    /// Draws the scene of `seed`.
    ///
    /// The scene depends on the arguments alone; of the robot, on its outline only.
    ///
    /// # Errors
    /// [`Infeasible`] if something given or drawn cannot be placed.
    pub fn generate(
        spec: &SceneSpec,
        map: &Arc<StaticMap>,
        robot: &Robot,
        seed: EpisodeSeed,
    ) -> Result<Self, Infeasible> {
        spec.check(map, robot).map_err(|error| Infeasible::new(error.to_string()))?;
        let given = spec.obstacles.given_statics(&map.grid);
        let mut space = ends::free_space(spec, map, &given, robot);
        let (start, goal) = ends::draw(spec, &space, seed)?;
        let theta = match spec.start.given(&map.grid) {
            Some((_, Some(theta))) => theta,
            _ => math::atan2(goal.y - start.y, goal.x - start.x),
        };
        let mut scene = Self::new(map, Pose { position: start, theta }, goal);
        scene.goal_heading_rad = spec.goal.heading_rad(&map.grid);
        // A search of the whole map: only if it is wanted.
        if spec.obstacles.need_route() {
            let route = route::reference_route(&map.grid, space.known(), start, goal, seed);
            let unconnected = || Infeasible::new("start and goal are not connected on the known map");
            scene.reference_route = Some(route.ok_or_else(unconnected)?);
        }
        let body = robot.body(scene.start);
        if body.corners.is_some() && (Statics { map, unknown: &given }).body_gap_m(&body) < -SLACK_M {
            return Err(Infeasible::new("the footprint does not fit at the start with its heading"));
        }
        for (entry, choice) in spec.obstacles.unknown_static.iter().enumerate() {
            let drawn = choice.kind().draw(&Drawing { scene: &scene, robot, seed, entry }, &mut space)?;
            scene.unknown_static.extend(drawn);
        }
        for (entry, choice) in spec.obstacles.moving.iter().enumerate() {
            let drawn = choice.kind().draw(&Drawing { scene: &scene, robot, seed, entry })?;
            scene.movers.extend(drawn);
        }
        script::write(&spec.script, &mut scene);
        Ok(scene)
    }

    /// Goal of the robot during the tick that begins at `time_s`, grid frame.
    pub fn goal_at(&self, time_s: f64) -> Vec2 {
        let moved = self.script.iter().take_while(|event| event.is_due(time_s));
        moved.filter_map(|event| event.change.goal_moved_to()).last().unwrap_or(self.goal)
    }

    /// Whether goal and statics stay as they are, so that one shortest way holds for the whole episode.
    pub fn has_a_fixed_task(&self) -> bool {
        !self.script.iter().any(|event| event.change.moves_the_task())
    }

    /// The static obstacles.
    pub(super) fn statics(&self) -> Statics<'_> {
        Statics { map: &self.map, unknown: &self.unknown_static }
    }

    /// The reference route, for a scene in which an obstacle is placed by it.
    pub(super) fn route(&self) -> &Path {
        self.reference_route.as_ref().expect("one is drawn if something is placed by it")
    }
}
