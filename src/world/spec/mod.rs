//! What a scenario says about the world: start, goal, obstacles, sensing.
//!
//! Positions are in the world frame (the map's own frame), metres and radians. Every kind of obstacle,
//! shape and placement is one module with a `Params`; a new kind is one new module and one name in
//! its `choice!`.

pub mod moving;
mod place;
pub mod script;
mod sensing;

pub use place::{CellPlace, GoalSpec, RandomPlace, StartSpec};
pub use script::{EventChoice, ScriptEntry};
pub use sensing::{ActuationSpec, Conditions, LidarSpec, LocalisationSpec, SensingSpec};

use super::{Recording, SceneError};
use crate::settings::choice::choice;
use crate::settings::quantity::{Finite, NonNegative, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;

pub use moving::MovingChoice;
pub use placement::PlacementChoice;
pub use shape::ShapeChoice;
pub use unknown_static::UnknownStaticChoice;

/// Everything a scene is made from, beside the map and the robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SceneSpec {
    /// Where the robot starts (scenario key `start`).
    pub start: StartSpec,
    /// Where it is to go (scenario key `goal`).
    pub goal: GoalSpec,
    /// What else is there (scenario key `obstacles`).
    pub obstacles: ObstaclesSpec,
    /// What the `replay` entries among the moving obstacles play, in their order.
    pub recordings: Vec<Arc<Recording>>,
    /// What happens when (scenario key `script`).
    pub script: Vec<ScriptEntry>,
}

impl SceneSpec {
    /// The specification with its recordings read; their files are looked up relative to `folder`.
    ///
    /// # Errors
    /// The first recording that cannot be read.
    pub fn new(
        start: StartSpec,
        goal: GoalSpec,
        obstacles: ObstaclesSpec,
        script: Vec<ScriptEntry>,
        folder: &Path,
    ) -> Result<Self, SceneError> {
        let mut recordings = Vec::new();
        for (entry, choice) in obstacles.moving.iter().enumerate() {
            if let MovingChoice::replay(params) = choice {
                let recording = Recording::read(&folder.join(&params.file), params.frame_rate_hz.get());
                let key = || format!("obstacles.moving[{entry}].replay.file");
                recordings.push(Arc::new(recording.map_err(|message| SceneError { key: key(), message })?));
            }
        }
        Ok(Self { start, goal, obstacles, recordings, script })
    }
}

/// Obstacles that the known map does not show (scenario key `obstacles`).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ObstaclesSpec {
    /// Obstacles that stand still and are unknown until the robot senses them. Default: none.
    pub unknown_static: Vec<UnknownStaticChoice>,
    /// Moving discs: straight on, erratic, on patrol, as recorded. Default: none.
    pub moving: Vec<MovingChoice>,
}

/// Outlines of obstacles.
pub mod shape {
    use super::*;

    choice! {
        /// The outline of an obstacle.
        pub enum ShapeChoice: "shape" { disc, rectangle, polygon }
    }

    impl Default for ShapeChoice {
        fn default() -> Self {
            Self::rectangle(rectangle::Params { size_m: [Positive::new(1.0), Positive::new(1.0)] })
        }
    }

    /// A disc.
    pub mod disc {
        use super::*;

        /// Parameters of a disc.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct Params {
            /// Radius, m.
            pub radius_m: Positive,
        }
    }

    /// A rectangle about its own centre.
    pub mod rectangle {
        use super::*;

        /// Parameters of a rectangle.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct Params {
            /// Sides along the rectangle's own x and y, m.
            pub size_m: [Positive; 2],
        }
    }

    /// A convex polygon about its own centre.
    pub mod polygon {
        use super::*;
        use crate::robot::OutlineCorners;

        /// Parameters of a polygon.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct Params {
            /// Corners [x, y] in its own frame, m, in order; [0, 0] lies inside.
            pub corners: OutlineCorners,
        }
    }
}

/// Where random obstacles are put.
pub mod placement {
    use super::*;

    choice! {
        /// Where random obstacles are put. "The route" is the scene's reference route, which no planner shapes.
        pub enum PlacementChoice: "placement" { anywhere, near_route, on_route }
    }

    impl Default for PlacementChoice {
        fn default() -> Self {
            Self::anywhere(anywhere::Params {})
        }
    }

    /// Uniformly over the map.
    pub mod anywhere {
        use super::*;

        /// No parameters.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct Params {}
    }

    /// Uniformly over the part of the map near the reference route.
    pub mod near_route {
        use super::*;

        /// Parameters of the placement near the route.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct Params {
            /// Largest distance from the obstacle's centre to the route, m. Default: 3.
            pub distance_max_m: Positive,
        }

        impl Default for Params {
            fn default() -> Self {
                Self { distance_max_m: Positive::new(3.0) }
            }
        }
    }

    /// With the centre on the reference route.
    pub mod on_route {
        use super::*;
        use crate::settings::quantity::Fraction;

        /// Parameters of the placement on the route.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct Params {
            /// Part of the route's length from which the place is drawn: 0 is the start, 1 the goal. Default: [0.2, 0.8].
            pub share: [Fraction; 2],
        }

        impl Default for Params {
            fn default() -> Self {
                Self { share: [Fraction::new(0.2), Fraction::new(0.8)] }
            }
        }
    }
}

/// Obstacles that stand still and are not on the known map.
pub mod unknown_static {
    use super::*;

    choice! {
        /// An obstacle that stands still and is unknown until sensed.
        pub enum UnknownStaticChoice: "kind of unknown static obstacle" { fixed, random }
    }

    /// One obstacle at a given place.
    pub mod fixed {
        use super::*;

        /// Parameters of an obstacle at a given place.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct Params {
            /// Pose [x, y, theta] of the centre in the world frame, m and rad.
            pub pose: [Finite; 3],
            /// Outline. Default: a rectangle of 1 m by 1 m.
            #[serde(default)]
            pub shape: ShapeChoice,
        }
    }

    /// Obstacles at random places, each from its own random stream.
    pub mod random {
        use super::*;
        use crate::settings::quantity::CountOrZero;

        /// Parameters of obstacles at random places.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct Params {
            /// How many. Default: 1.
            pub count: CountOrZero,
            /// Outline. Default: a rectangle of 1 m by 1 m.
            pub shape: ShapeChoice,
            /// Where. Default: anywhere.
            pub placement: PlacementChoice,
            /// Put the centre on a cell centre with the sides along the grid, as the papers' "obstacle
            /// cells"; otherwise place and heading are free. Default: false.
            pub snap_to_cells: bool,
            /// Keep the cells it touches from being 8-adjacent to the cells of any other static
            /// obstacle or to the map's edge, so that it never closes a pocket. Default: false.
            pub apart_from_obstacles: bool,
            /// Least distance from its surface to the robot's centre at the start and to the goal, m;
            /// the robot's radius where that is larger. Default: 1.
            pub keep_from_ends_m: NonNegative,
        }

        impl Default for Params {
            fn default() -> Self {
                Self {
                    count: CountOrZero::new(1),
                    shape: ShapeChoice::default(),
                    placement: PlacementChoice::default(),
                    snap_to_cells: false,
                    apart_from_obstacles: false,
                    keep_from_ends_m: NonNegative::new(1.0),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
