//! Obstacles of a scene: their kinds, their placement, their random draws.
//!
//! Every kind of obstacle, shape and placement is one file that holds its parameters, its check and its draw, and one
//! name in a registry. Positions in scenarios are in the world frame (the map's own frame), metres and radians.

pub mod moving;
pub mod placement;
pub mod shape;
pub mod unknown_static;

use super::scene::{Infeasible, Scene, SceneError, TRIES};
use crate::map::OccupancyGrid;
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::robot::Robot;
use moving::{MovingChoice, MovingKind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use unknown_static::{UnknownStatic, UnknownStaticChoice};

/// Obstacles that the known map does not show (scenario key `obstacles`).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ObstaclesSpec {
    /// Obstacles that stand still and are unknown until the robot senses them. Default: none.
    pub unknown_static: Vec<UnknownStaticChoice>,
    /// Movers, discs or convex outlines: straight on, erratic, on patrol, as recorded. Default: none.
    pub moving: Vec<MovingChoice>,
}

impl ObstaclesSpec {
    /// Reads the files that obstacles name, relative to `folder`.
    ///
    /// # Errors
    /// The first file that cannot be read.
    pub(super) fn load(&mut self, folder: &Path) -> Result<(), SceneError> {
        for (entry, choice) in self.moving.iter_mut().enumerate() {
            let key = format!("obstacles.moving[{entry}].{}", choice.name());
            choice.kind_mut().load(&key, folder)?;
        }
        Ok(())
    }

    /// The files that obstacles name, as they stand in the scenario.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        self.moving.iter().flat_map(|choice| choice.kind().files()).collect()
    }

    /// The unknown statics whose pose is given, grid frame.
    pub(crate) fn given_statics(&self, grid: &OccupancyGrid) -> Vec<UnknownStatic> {
        self.unknown_static.iter().filter_map(|choice| choice.kind().given(grid)).collect()
    }

    /// Whether any obstacle is placed by the scene's reference route.
    pub(super) fn need_route(&self) -> bool {
        self.unknown_static.iter().any(|choice| choice.kind().needs_route())
            || self.moving.iter().any(|choice| choice.kind().needs_route())
    }

    /// The kind of each mover, in the scene's order.
    pub(super) fn movers(&self) -> Vec<&dyn MovingKind> {
        let kinds = self.moving.iter().map(MovingChoice::kind);
        kinds.flat_map(|kind| core::iter::repeat_n(kind, kind.count())).collect()
    }
}

/// Context for drawing the obstacles of one entry of a list: the scene as drawn so far, the robot, the seed.
#[derive(Debug)]
pub struct Drawing<'a> {
    /// The scene so far: start, goal, route and the obstacles that are placed already.
    pub scene: &'a Scene,
    /// The robot that will drive there.
    pub robot: &'a Robot,
    /// Source of the scene's randomness.
    pub seed: EpisodeSeed,
    /// Number of the entry in its list.
    pub entry: usize,
}

impl Drawing<'_> {
    /// The stream of obstacle `number` of this entry: appending an obstacle to the list, or raising a count, leaves the
    /// streams of the others as they were.
    fn stream(&self, purpose: Purpose, number: u32) -> Stream {
        assert!(self.entry < 1 << 16, "a list of obstacles has at most 65536 entries");
        self.seed.stream(purpose, (self.entry as u64) << 32 | u64::from(number))
    }

    /// The error for obstacle `number` of this entry of the list `list`, which found no place.
    fn no_place(&self, list: &str, number: u32) -> Infeasible {
        let entry = self.entry;
        Infeasible::new(format!("no place for number {number} of {list}[{entry}] in {TRIES} draws"))
    }
}

#[cfg(test)]
mod tests {
    use super::shape::{self, ShapeChoice};
    use super::*;
    use crate::settings::quantity::{Finite, Positive};

    #[test]
    fn obstacles_read_as_scenarios_write_them() {
        let yaml = "
unknown_static:
  - fixed: {pose: [1, 2, 0.5], shape: {disc: {radius_m: 0.4}}}
  - random
  - random: {count: 4, shape: {rectangle: {size_m: [0.8, 1.2]}}, placement: {near_route: {distance_max_m: 2}}}
  - random: {placement: on_route, snap_to_cells: true, apart_from_obstacles: true}
moving:
  - fixed: {position: [3, 4], velocity_mps: [0, -1]}
  - fixed: {position: [3, 4], speed_mps: 1, heading_rad: -1.5, on_static: stop, on_robot: yield}
  - random: {count: 10, speed_mps: [0.8, 1.0], on_static: pass}
";
        let spec: ObstaclesSpec = serde_yaml::from_str(yaml).unwrap();
        assert_eq!((spec.unknown_static.len(), spec.moving.len()), (4, 3));
        assert_eq!(
            spec.unknown_static[0],
            UnknownStaticChoice::fixed(unknown_static::fixed::Params {
                pose: [Finite::new(1.0), Finite::new(2.0), Finite::new(0.5)],
                shape: ShapeChoice::disc(shape::disc::Params { radius_m: Positive::new(0.4) }),
            })
        );
        assert_eq!(spec.unknown_static[1], UnknownStaticChoice::random(Default::default()));
        let written = serde_yaml::to_string(&spec).unwrap();
        assert_eq!(serde_yaml::from_str::<ObstaclesSpec>(&written).unwrap(), spec, "{written}");
    }

    #[test]
    fn a_wrong_obstacle_is_refused_at_its_own_place() {
        let error = serde_yaml::from_str::<ObstaclesSpec>("moving:\n  - random: {radius_m: -1}\n").unwrap_err();
        let place = error.location().map(|at| (at.line(), at.column()));
        assert_eq!(place, Some((2, 24)), "{error}");
        assert!(error.to_string().contains("above 0"), "{error}");
        let error = serde_yaml::from_str::<ObstaclesSpec>("moving:\n  - randon\n").unwrap_err();
        assert!(error.to_string().contains("did you mean `random`?"), "{error}");
    }
}
