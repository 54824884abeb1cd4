//! The sensor for obstacles: which it perceives, and how.

use super::lidar::LidarSpec;
use crate::geometry::{Pose, Vec2, direction};
use crate::math;
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::settings::quantity::{Fraction, NonNegative, Positive};
use crate::world::obstacles::moving::Mover;
use crate::world::statics::Statics;
use crate::world::truth::{Bodies, Body};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
    fn is_noisy(&self) -> bool {
        let noise = [self.range_noise_m, self.bearing_noise_rad, self.velocity_noise_mps];
        noise.iter().any(|noise| noise.get() > 0.0) || self.miss_probability.get() > 0.0
    }
}

/// Slack of a line of sight, m: what rounding may take from the distance to the point that is looked at.
const SIGHT_SLACK_M: f64 = 1e-6;

/// Number of an obstacle's stream: unknown statics first, then movers; the map has none.
fn stream_number(bodies: Bodies, body: Body) -> Option<usize> {
    bodies.index(body).checked_sub(1)
}

/// How an obstacle is perceived at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sighting {
    /// From where it is to where it is perceived, m.
    pub(super) offset: Vec2,
    /// Error of the velocity, m/s.
    pub(super) velocity_error: Vec2,
}

/// The sensor for obstacles.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    spec: SensingSpec,
    /// In force now.
    range_m: f64,
    bodies: Bodies,
    /// One stream for each obstacle, by [`stream_number`]; none without noise.
    streams: Vec<Stream>,
}

impl Sensor {
    pub(super) fn new(spec: &SensingSpec, seed: EpisodeSeed, bodies: Bodies) -> Self {
        let streams = bodies.iter().filter_map(|body| stream_number(bodies, body));
        let streams = streams.filter(|_| spec.is_noisy()).map(|k| seed.stream(Purpose::Sensor, k as u64)).collect();
        Self { range_m: spec.range_m.get(), spec: spec.clone(), bodies, streams }
    }

    pub(super) fn set_range_m(&mut self, range_m: f64) {
        self.range_m = range_m;
    }

    /// Whether anything but the distance decides if an obstacle is sensed, or how.
    fn is_plain(&self) -> bool {
        self.spec.field_of_view_rad.is_none() && !self.spec.occlusion && self.streams.is_empty()
    }

    /// How the obstacle `body` of `scene` is perceived from `eye`; `None` if it is not. `gap_m` is the distance of its
    /// surface, `nearest` the point of it that is nearest.
    pub(super) fn look(
        &mut self,
        scene: &Surroundings<'_>,
        eye: Pose,
        tick: u32,
        body: Body,
        gap_m: f64,
        nearest: impl Fn() -> Vec2,
    ) -> Option<Sighting> {
        let perfect = Sighting { offset: Vec2::zeros(), velocity_error: Vec2::zeros() };
        if gap_m > self.range_m {
            return None;
        }
        if self.is_plain() {
            return Some(perfect);
        }
        let nearest = nearest();
        let in_view = |fov: f64| eye.bearing_to(nearest).abs() <= 0.5 * fov;
        if self.spec.field_of_view_rad.is_some_and(|fov| !in_view(fov.get()))
            || self.spec.occlusion && scene.hides(eye.position, nearest, body)
        {
            return None;
        }
        let stream = stream_number(self.bodies, body).and_then(|number| self.streams.get_mut(number));
        let Some(stream) = stream else { return Some(perfect) };
        // Always drawn in this order, so that one kind of noise does not move another.
        let draws = stream.at_tick(tick);
        let missed = draws.uniform() < self.spec.miss_probability.get();
        let away_m = self.spec.range_noise_m.get() * draws.normal();
        let turn = self.spec.bearing_noise_rad.get() * draws.normal();
        let velocity_error = self.spec.velocity_noise_mps.get() * Vec2::new(draws.normal(), draws.normal());
        let line = nearest - eye.position;
        let distance_m = line.norm();
        let offset = if distance_m > 0.0 {
            let bearing = math::atan2(line.y, line.x) + turn;
            math::max(distance_m + away_m, 0.0) * direction(bearing) - line
        } else {
            Vec2::zeros()
        };
        (!missed).then_some(Sighting { offset, velocity_error })
    }
}

/// What can be in the way of a look.
#[derive(Clone, Copy)]
pub(in crate::world) struct Surroundings<'a> {
    pub(in crate::world) statics: Statics<'a>,
    pub(in crate::world) movers: &'a [Mover],
}

impl Surroundings<'_> {
    /// Distance along a ray to the first surface, the map's edge included, m; `range_m` if none is nearer.
    pub(super) fn cast_ray(&self, from: Vec2, unit: Vec2, range_m: f64, except: Option<Body>) -> f64 {
        let mut first_m = self.statics.map.cast_ray(from, unit, range_m);
        for (number, obstacle) in self.statics.unknown.iter().enumerate() {
            if except != Some(Body::Unknown(number)) {
                first_m = math::min(first_m, obstacle.cast_ray(from, unit));
            }
        }
        for (number, mover) in self.movers.iter().enumerate() {
            if except != Some(Body::Mover(number)) && mover.present {
                first_m = math::min(first_m, mover.outline.cast_ray(mover.position, from, unit));
            }
        }
        first_m
    }

    /// Whether anything but `body` is between `eye` and the point `p` of it.
    fn hides(&self, eye: Vec2, p: Vec2, body: Body) -> bool {
        let line = p - eye;
        let distance_m = line.norm();
        distance_m > 0.0 && self.cast_ray(eye, line / distance_m, distance_m, Some(body)) < distance_m - SIGHT_SLACK_M
    }
}
