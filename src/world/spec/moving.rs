//! Obstacles that move: discs, or convex outlines that keep their heading.

use super::*;
use crate::robot::OutlineCorners;
use crate::settings::quantity::{CountOrZero, Fraction};
use std::path::PathBuf;

choice! {
    /// A moving obstacle.
    pub enum MovingChoice: "kind of moving obstacle" { fixed, random, crossing, patrol, replay }
}

choice! {
    /// How a mover goes on after it has set out.
    pub enum MotionChoice: "motion" { uniform, irregular }
}

impl Default for MotionChoice {
    fn default() -> Self {
        Self::uniform(uniform::Params {})
    }
}

/// Straight on.
pub mod uniform {
    use super::*;

    /// No parameters.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Params {}
}

/// Straight on for a while, then in another direction, uniformly random, at another speed (gao2025, G-A21).
pub mod irregular {
    use super::*;

    /// Parameters of an erratic motion.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Params {
        /// Range [shortest, longest] of the time between two changes, s; rounded to whole ticks. Default: [2, 5].
        pub interval_s: [Positive; 2],
        /// Range [lowest, highest] of the speed after a change, m/s. Default: that from which the first speed was drawn, or the
        /// given first speed.
        pub speed_mps: Option<[NonNegative; 2]>,
    }

    impl Default for Params {
        fn default() -> Self {
            Self { interval_s: [Positive::new(2.0), Positive::new(5.0)], speed_mps: None }
        }
    }
}

/// What a mover does at a wall, an unknown static or the map's edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnStatic {
    /// Bounces off like a billiard ball: speed kept.
    #[default]
    Reflect,
    /// Goes through, as if nothing were there (and leaves the map).
    Pass,
    /// Stands still there for the rest of the episode.
    Stop,
}

/// Which way a random mover sets out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Heading {
    /// Uniformly random: between walls it ricochets.
    #[default]
    Any,
    /// Either way along that axis of the known map in which the free run through its place is longer: up and
    /// down the aisle, as traffic between racks does. Equal runs: along x.
    AlongAisle,
}

/// What a mover does about the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnRobot {
    /// Moves on as if the robot were not there.
    #[default]
    Ignore,
    /// Stands still while the robot is close ahead (`yield_distance_m`), then goes on.
    Yield,
}

/// One mover with a given state at the first tick.
pub mod fixed {
    use super::*;

    /// Parameters of one mover: either `velocity_mps`, or `speed_mps` with `heading_rad`.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// Centre [x, y] in the world frame, m.
        pub position: [Finite; 2],
        /// Velocity [vx, vy] in the world frame, m/s.
        #[serde(default)]
        pub velocity_mps: Option<[Finite; 2]>,
        /// Speed along `heading_rad`, m/s.
        #[serde(default)]
        pub speed_mps: Option<NonNegative>,
        /// Direction of motion in the world frame, rad.
        #[serde(default)]
        pub heading_rad: Option<Finite>,
        /// Radius of the disc, m. Default: 0.3.
        #[serde(default = "radius_default")]
        pub radius_m: Positive,
        /// A convex outline in place of the disc: corners [x, y], m, x along its heading at first, which it keeps. Default: none.
        #[serde(default)]
        pub footprint: Option<OutlineCorners>,
        /// At a wall, an unknown static or the map's edge. Default: reflect.
        #[serde(default)]
        pub on_static: OnStatic,
        /// Towards the robot. Default: ignore.
        #[serde(default)]
        pub on_robot: OnRobot,
        /// How it goes on after it has set out. Default: uniform.
        #[serde(default)]
        pub motion: MotionChoice,
        /// Surface distance within which a yielding mover stops for a robot ahead of it, m. Default: 1.
        #[serde(default = "yield_distance_default")]
        pub yield_distance_m: NonNegative,
    }
}

/// Movers with random position and heading, each from its own random stream.
pub mod random {
    use super::*;

    /// Parameters of random movers.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Params {
        /// How many. Default: 1.
        pub count: CountOrZero,
        /// Radius of the disc, m. Default: 0.3.
        pub radius_m: Positive,
        /// A convex outline in place of the disc: corners [x, y], m, x along its way at first; it keeps that heading. Default: none.
        pub footprint: Option<OutlineCorners>,
        /// Range [lowest, highest] from which the speed is drawn, m/s. Default: [0.5, 1].
        pub speed_mps: [NonNegative; 2],
        /// Which way they set out. Default: any.
        pub heading: Heading,
        /// How they go on after they have set out. Default: uniform.
        pub motion: MotionChoice,
        /// At a wall, an unknown static or the map's edge. Default: reflect.
        pub on_static: OnStatic,
        /// Towards the robot. Default: ignore.
        pub on_robot: OnRobot,
        /// Surface distance within which a yielding mover stops for a robot ahead of it, m. Default: 1.
        pub yield_distance_m: NonNegative,
        /// Least surface distance to the robot at the start, m. Default: 3.
        pub keep_from_start_m: NonNegative,
    }

    impl Default for Params {
        fn default() -> Self {
            Self {
                count: CountOrZero::new(1),
                radius_m: radius_default(),
                footprint: None,
                speed_mps: [NonNegative::new(0.5), NonNegative::new(1.0)],
                heading: Heading::default(),
                motion: MotionChoice::default(),
                on_static: OnStatic::default(),
                on_robot: OnRobot::default(),
                yield_distance_m: yield_distance_default(),
                keep_from_start_m: NonNegative::new(3.0),
            }
        }
    }
}

/// Movers that cross the reference route at about the time at which the robot comes by, each from its own random stream.
///
/// A point of the route is drawn, and a heading; the mover is there when a robot that drives the route at
/// `robot_speed_mps` would be, give or take `jitter_s`. Where it begins follows by driving backwards from there, with bounces off
/// statics. A mover that is met by accident says little of avoidance; this one is met.
pub mod crossing {
    use super::*;

    /// Parameters of movers that cross the route.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Params {
        /// How many. Default: 1.
        pub count: CountOrZero,
        /// Radius of the disc, m. Default: 0.3.
        pub radius_m: Positive,
        /// A convex outline in place of the disc: corners [x, y], m, x along its way at first; it keeps that heading. Default: none.
        pub footprint: Option<OutlineCorners>,
        /// Range [lowest, highest] from which the speed is drawn, m/s. Default: [0.5, 1].
        pub speed_mps: [NonNegative; 2],
        /// Part of the route's length from which the crossing is drawn: 0 is the start, 1 the goal. Default: [0.3, 0.8].
        pub share: [Fraction; 2],
        /// Speed at which the robot is taken to drive the route, m/s. Default: 0.5.
        pub robot_speed_mps: Positive,
        /// The mover is at most this much too early or too late, uniformly, s. Default: 2.
        pub jitter_s: NonNegative,
        /// It goes straight for this long before and after the crossing, s. Default: 3.
        pub straight_s: NonNegative,
        /// At a wall, an unknown static or the map's edge. Default: reflect.
        pub on_static: OnStatic,
        /// Towards the robot. Default: ignore.
        pub on_robot: OnRobot,
        /// Surface distance within which a yielding mover stops for a robot ahead of it, m. Default: 1.
        pub yield_distance_m: NonNegative,
        /// Least surface distance to the robot at the start, m. Default: 3.
        pub keep_from_start_m: NonNegative,
    }

    impl Default for Params {
        fn default() -> Self {
            Self {
                count: CountOrZero::new(1),
                radius_m: radius_default(),
                footprint: None,
                speed_mps: [NonNegative::new(0.5), NonNegative::new(1.0)],
                share: [Fraction::new(0.3), Fraction::new(0.8)],
                robot_speed_mps: Positive::new(0.5),
                jitter_s: NonNegative::new(2.0),
                straight_s: NonNegative::new(3.0),
                on_static: OnStatic::default(),
                on_robot: OnRobot::default(),
                yield_distance_m: yield_distance_default(),
                keep_from_start_m: NonNegative::new(3.0),
            }
        }
    }
}

/// One mover that goes from waypoint to waypoint, again and again.
pub mod patrol {
    use super::*;

    /// Parameters of a patrol.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// Waypoints [x, y] in the world frame, m; it begins at the first. At least two, no two neighbours at one place.
        pub waypoints: Vec<[Finite; 2]>,
        /// Speed, m/s. Default: 0.5.
        #[serde(default = "patrol_speed_default")]
        pub speed_mps: Positive,
        /// Whether the last waypoint leads back to the first; else it goes back the way it came. Default: true.
        #[serde(default = "yes")]
        pub closed: bool,
        /// Stop at every waypoint, s. Default: 0.
        #[serde(default = "none")]
        pub pause_s: NonNegative,
        /// Radius of the disc, m. Default: 0.3.
        #[serde(default = "radius_default")]
        pub radius_m: Positive,
        /// A convex outline in place of the disc: corners [x, y], m, x along the first leg; it keeps that heading. Default: none.
        #[serde(default)]
        pub footprint: Option<OutlineCorners>,
        /// Where a static obstacle is in its way: `stop` waits there, `pass` goes through. Default: stop.
        #[serde(default = "stop")]
        pub on_static: OnStatic,
        /// Towards the robot. Default: ignore.
        #[serde(default)]
        pub on_robot: OnRobot,
        /// Surface distance within which a yielding mover stops for a robot ahead of it, m. Default: 1.
        #[serde(default = "yield_distance_default")]
        pub yield_distance_m: NonNegative,
    }
}

/// Movers from a recording: one for each that it holds. They appear and vanish with the data, go straight from sample to
/// sample, and mind neither walls nor the robot, as recordings do.
pub mod replay {
    use super::*;

    /// Parameters of a replay.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// CSV file, relative to the scenario, with the columns `time_s` (or `time`, or `frame`), `id` (or `ped_id`), `x_m` (or `x`)
        /// and `y_m` (or `y`); positions in the world frame, m. Other columns are not read.
        pub file: PathBuf,
        /// Frames per second, for a file that counts frames. Default: 25.
        #[serde(default = "frame_rate_default")]
        pub frame_rate_hz: Positive,
        /// Moment of the recording at which the episode begins, s. Default: 0.
        #[serde(default = "none")]
        pub from_s: NonNegative,
        /// Only these ids, as they stand in the file. Default: all.
        #[serde(default)]
        pub ids: Option<Vec<u64>>,
        /// Radius of the discs, m. Default: 0.3.
        #[serde(default = "radius_default")]
        pub radius_m: Positive,
        /// Whether they stand where the data ends, instead of vanishing. Default: false.
        #[serde(default)]
        pub stays: bool,
    }
}

fn patrol_speed_default() -> Positive {
    Positive::new(0.5)
}

fn frame_rate_default() -> Positive {
    Positive::new(25.0)
}

fn yes() -> bool {
    true
}

fn none() -> NonNegative {
    NonNegative::new(0.0)
}

fn stop() -> OnStatic {
    OnStatic::Stop
}

fn radius_default() -> Positive {
    Positive::new(0.3)
}

fn yield_distance_default() -> NonNegative {
    NonNegative::new(1.0)
}
