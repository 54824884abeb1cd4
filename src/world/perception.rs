//! What the robot perceives: obstacles and ranges, with all that stands between them and the truth.

use super::DT_S;
use super::obstacle::{Mover, UnknownStatic};
use super::spec::{Conditions, LidarSpec, LocalisationSpec, SensingSpec};
use super::statics::Statics;
use crate::geometry::{Pose, Vec2, direction, wrap_angle};
use crate::math;
use crate::rng::{EpisodeSeed, Purpose, Stream};

/// Slack of a line of sight, m: what rounding may take from the distance to the point that is looked at.
const SIGHT_SLACK_M: f64 = 1e-6;

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
    /// One stream for each obstacle, unknown statics first; none without noise.
    streams: Vec<Stream>,
}

impl Sensor {
    pub(super) fn new(conditions: &Conditions, obstacles: usize) -> Self {
        let spec = conditions.sensing.clone();
        let noisy = if spec.is_noisy() { obstacles } else { 0 };
        let streams = (0..noisy).map(|k| conditions.seed.stream(Purpose::Sensor, k as u64)).collect();
        Self { range_m: spec.range_m.get(), spec, streams }
    }

    pub(super) fn set_range_m(&mut self, range_m: f64) {
        self.range_m = range_m;
    }

    /// Whether anything but the distance decides if an obstacle is sensed, or how.
    fn is_plain(&self) -> bool {
        self.spec.field_of_view_rad.is_none() && !self.spec.occlusion && self.streams.is_empty()
    }

    /// How obstacle `number` of `scene` is perceived from `eye`; `None` where it is not. `gap_m` is the distance of its
    /// surface, `nearest` the point of it that is nearest.
    pub(super) fn look(
        &mut self,
        scene: &Surroundings<'_>,
        eye: Pose,
        tick: u32,
        number: usize,
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
            || self.spec.occlusion && scene.hides(eye.position, nearest, number)
        {
            return None;
        }
        let Some(stream) = self.streams.get_mut(number) else { return Some(perfect) };
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
pub(super) struct Surroundings<'a> {
    pub(super) statics: Statics<'a>,
    pub(super) movers: &'a [Mover],
}

impl Surroundings<'_> {
    /// The obstacles that nobody has on a map, with their numbers: unknown statics, then movers.
    fn cast_ray(&self, from: Vec2, unit: Vec2, range_m: f64, except: Option<usize>) -> f64 {
        let mut first_m = self.statics.map.cast_ray(from, unit, range_m);
        let unknown: &[UnknownStatic] = self.statics.unknown;
        for (number, obstacle) in unknown.iter().enumerate() {
            if except != Some(number) {
                first_m = math::min(first_m, obstacle.cast_ray(from, unit));
            }
        }
        for (index, mover) in self.movers.iter().enumerate() {
            if except != Some(unknown.len() + index) && mover.present {
                first_m = math::min(first_m, mover.outline.cast_ray(mover.position, from, unit));
            }
        }
        first_m
    }

    /// Whether anything but obstacle `number` is between `eye` and the point `p` of it.
    fn hides(&self, eye: Vec2, p: Vec2, number: usize) -> bool {
        let line = p - eye;
        let distance_m = line.norm();
        distance_m > 0.0 && self.cast_ray(eye, line / distance_m, distance_m, Some(number)) < distance_m - SIGHT_SLACK_M
    }
}

/// The scanner.
#[derive(Clone, Debug)]
pub(super) struct Lidar {
    spec: LidarSpec,
    fov_rad: f64,
    /// One stream for each block of rays; none without noise.
    streams: Vec<Stream>,
    pub(super) ranges_m: Vec<f64>,
}

/// Rays that draw from one stream: six words each, of the 4096 that a stream has for a tick.
const RAYS_PER_STREAM: usize = 512;
/// Number of the first stream of the scanner; obstacles have those from 0 on.
const FIRST_LIDAR_STREAM: u64 = 1 << 32;

impl Lidar {
    pub(super) fn new(spec: &LidarSpec, seed: EpisodeSeed) -> Self {
        let rays = spec.rays.get() as usize;
        let noisy = spec.range_noise_m.get() > 0.0 || spec.miss_probability.get() > 0.0;
        let blocks = if noisy { rays.div_ceil(RAYS_PER_STREAM) as u64 } else { 0 };
        Self {
            fov_rad: spec.field_of_view_rad.map_or(math::TAU, |fov| math::min(fov.get(), math::TAU)),
            streams: (0..blocks).map(|k| seed.stream(Purpose::Sensor, FIRST_LIDAR_STREAM + k)).collect(),
            ranges_m: vec![f64::INFINITY; rays],
            spec: spec.clone(),
        }
    }

    /// Bearings of the rays: the first, and from one to the next, rad.
    pub(super) fn bearings_rad(&self) -> (f64, f64) {
        let step = self.fov_rad / self.ranges_m.len() as f64;
        (0.5 * step - 0.5 * self.fov_rad, step)
    }

    pub(super) fn scan(&mut self, scene: &Surroundings<'_>, eye: Pose, tick: u32) {
        let (first, step) = self.bearings_rad();
        let longest_m = self.spec.range_m.get();
        for (ray, range_m) in self.ranges_m.iter_mut().enumerate() {
            let unit = direction(eye.theta + first + step * ray as f64);
            let true_m = scene.cast_ray(eye.position, unit, longest_m, None);
            *range_m = if true_m < longest_m { true_m } else { f64::INFINITY };
        }
        for (stream, block) in self.streams.iter_mut().zip(self.ranges_m.chunks_mut(RAYS_PER_STREAM)) {
            let draws = stream.at_tick(tick);
            for range_m in block {
                let missed = draws.uniform() < self.spec.miss_probability.get();
                let noise_m = self.spec.range_noise_m.get() * draws.normal();
                *range_m = if missed { f64::INFINITY } else { math::max(*range_m + noise_m, 0.0) };
            }
        }
    }
}

/// Where the robot believes to be.
#[derive(Clone, Debug)]
pub(super) struct Localisation {
    spec: LocalisationSpec,
    noise: Stream,
    walk: Stream,
    drift: Pose,
    is_exact: bool,
}

impl Localisation {
    pub(super) fn new(conditions: &Conditions) -> Self {
        let spec = conditions.localisation.clone();
        Self {
            is_exact: spec == LocalisationSpec::default(),
            noise: conditions.seed.stream(Purpose::Localisation, 0),
            walk: conditions.seed.stream(Purpose::Localisation, 1),
            drift: Pose::new(0.0, 0.0, 0.0),
            spec,
        }
    }

    /// The believed pose at `tick` for the true pose `pose`: to be asked once a tick, in order.
    pub(super) fn believe(&mut self, pose: Pose, tick: u32) -> Pose {
        if self.is_exact {
            return pose;
        }
        if tick > 0 {
            let step = DT_S.sqrt();
            let draws = self.walk.at_tick(tick);
            let walked = self.spec.position_drift_m.get() * step * Vec2::new(draws.normal(), draws.normal());
            self.drift.position += walked;
            self.drift.theta += self.spec.heading_drift_rad.get() * step * draws.normal();
        }
        let draws = self.noise.at_tick(tick);
        let noise = self.spec.position_noise_m.get() * Vec2::new(draws.normal(), draws.normal());
        let turn = self.spec.heading_noise_rad.get() * draws.normal();
        Pose {
            position: pose.position + self.drift.position + noise,
            theta: wrap_angle(pose.theta + self.drift.theta + turn),
        }
    }
}
