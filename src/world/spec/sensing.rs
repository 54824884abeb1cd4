//! What a scenario says about how well the robot perceives and obeys: sensing, localisation, actuation.

use crate::rng::EpisodeSeed;
use crate::settings::quantity::{CountOrZero, Fraction, NonNegative, Positive, Rays};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the robot perceives and obeys in one episode. The default is a perfect robot that senses 5 m around itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conditions {
    /// Source of the episode's noise.
    pub seed: EpisodeSeed,
    /// What it senses of its surroundings (scenario key `sensing`).
    pub sensing: SensingSpec,
    /// How well it knows where it is (scenario key `localisation`).
    pub localisation: LocalisationSpec,
    /// How well it does what it is told (scenario key `actuation`).
    pub actuation: ActuationSpec,
}

/// What the robot senses of its surroundings (scenario key `sensing`).
///
/// An obstacle is sensed by the point of its surface that is nearest to the robot's centre: it must be in range, in the
/// field of view, and with `occlusion` in sight. Noise is normal with mean 0, drawn anew every tick and for every obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SensingSpec {
    /// An obstacle is sensed while its surface is within this distance of the robot's centre, m. Default: 5.
    pub range_m: Positive,
    /// Angle of the sector in which obstacles are sensed, rad, half of it to either side of the heading; all round where absent.
    pub field_of_view_rad: Option<Positive>,
    /// Whether obstacles hide what is behind them; by default the robot senses through walls.
    pub occlusion: bool,
    /// Standard deviation of the distance at which an obstacle is sensed, m; default 0.
    pub range_noise_m: NonNegative,
    /// Standard deviation of the bearing at which an obstacle is sensed, rad; default 0.
    pub bearing_noise_rad: NonNegative,
    /// Standard deviation of either component of a mover's sensed velocity, m/s; default 0.
    pub velocity_noise_mps: NonNegative,
    /// Probability that an obstacle that could be sensed is not, each tick anew; default 0.
    pub miss_probability: Fraction,
    /// A scanner whose ranges are handed to planners and written beside traces; by default there is none.
    pub lidar: Option<LidarSpec>,
}

impl Default for SensingSpec {
    fn default() -> Self {
        Self {
            range_m: Positive::new(5.0),
            field_of_view_rad: None,
            occlusion: false,
            range_noise_m: NonNegative::new(0.0),
            bearing_noise_rad: NonNegative::new(0.0),
            velocity_noise_mps: NonNegative::new(0.0),
            miss_probability: Fraction::new(0.0),
            lidar: None,
        }
    }
}

impl SensingSpec {
    /// Whether what is sensed depends on chance.
    pub(in super::super) fn is_noisy(&self) -> bool {
        let noise = [self.range_noise_m, self.bearing_noise_rad, self.velocity_noise_mps];
        noise.iter().any(|noise| noise.get() > 0.0) || self.miss_probability.get() > 0.0
    }
}

/// A planar laser scanner at the robot's centre: rays through the middles of equal sectors.
///
/// Ray i of n points at heading − fov/2 + (i + ½) fov/n. It measures the distance to the first surface, the map's edge
/// included; none within range, or a ray that is missed, gives infinity (as ROS REP 117 has it).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LidarSpec {
    /// Number of rays; default 360.
    pub rays: Rays,
    /// Longest distance that is measured, m; default 10.
    pub range_m: Positive,
    /// Angle of the scan, rad; all round where absent.
    pub field_of_view_rad: Option<Positive>,
    /// Standard deviation of a measured distance, m; default 0. What is measured is at least 0.
    pub range_noise_m: NonNegative,
    /// Probability that a ray gives nothing, each ray and tick anew; default 0.
    pub miss_probability: Fraction,
}

impl Default for LidarSpec {
    fn default() -> Self {
        Self {
            rays: Rays::new(360),
            range_m: Positive::new(10.0),
            field_of_view_rad: None,
            range_noise_m: NonNegative::new(0.0),
            miss_probability: Fraction::new(0.0),
        }
    }
}

/// How well the robot knows where it is (scenario key `localisation`); perfectly by default.
///
/// The believed pose is the true one plus an error in x, y and heading: a random walk that starts at 0 with the episode (the
/// drift of dead reckoning) plus noise that is drawn anew every tick. All of it is normal. What the robot senses it sees from
/// where it is and places as seen from where it believes to be. Goal and contact are judged on the truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LocalisationSpec {
    /// Standard deviation of the noise of x and of y, m; default 0.
    pub position_noise_m: NonNegative,
    /// Standard deviation of the noise of the heading, rad; default 0.
    pub heading_noise_rad: NonNegative,
    /// Standard deviation of the drift of x and of y after one second, m; it grows with the root of time. Default 0.
    pub position_drift_m: NonNegative,
    /// Standard deviation of the drift of the heading after one second, rad; it grows with the root of time. Default 0.
    pub heading_drift_rad: NonNegative,
}

impl Default for LocalisationSpec {
    fn default() -> Self {
        let none = NonNegative::new(0.0);
        Self { position_noise_m: none, heading_noise_rad: none, position_drift_m: none, heading_drift_rad: none }
    }
}

/// How well the drive does what it is told (scenario key `actuation`); perfectly by default.
///
/// A command reaches the drive after the latency; the drive answers within its limits; noise and slip then part the ground's
/// motion from the wheels'. The robot knows the twist of its wheels, not that of its body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ActuationSpec {
    /// Ticks from a command to its effect; until the first one arrives the drive is told to stand. Default 0, at most 1000.
    pub latency_ticks: CountOrZero,
    /// Standard deviation of the speed as a share of it, normal, each tick anew; default 0.
    pub speed_noise_share: NonNegative,
    /// Standard deviation of the yaw rate as a share of it, normal, each tick anew; default 0.
    pub yaw_rate_noise_share: NonNegative,
    /// Share of its rim speed that the left wheel loses to the ground, uniform between the two numbers, each tick anew;
    /// default [0, 0].
    pub slip_left: [Fraction; 2],
    /// The same for the right wheel.
    pub slip_right: [Fraction; 2],
}

impl Default for ActuationSpec {
    fn default() -> Self {
        let none = NonNegative::new(0.0);
        let grip = [Fraction::new(0.0), Fraction::new(0.0)];
        Self {
            latency_ticks: CountOrZero::new(0),
            speed_noise_share: none,
            yaw_rate_noise_share: none,
            slip_left: grip,
            slip_right: grip,
        }
    }
}

impl ActuationSpec {
    /// Whether the ground's motion is always that of the wheels.
    pub(in super::super) fn is_exact(&self) -> bool {
        let noise = [self.speed_noise_share, self.yaw_rate_noise_share];
        let slip = [self.slip_left, self.slip_right];
        noise.iter().all(|noise| noise.get() == 0.0) && slip.as_flattened().iter().all(|slip| slip.get() == 0.0)
    }
}
