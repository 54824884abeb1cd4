//! The laser scanner.

use super::sensor::Surroundings;
use crate::geometry::{Pose, direction};
use crate::math;
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::settings::quantity::{Fraction, NonNegative, Positive, Rays};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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

/// The scanner.
#[derive(Clone, Debug)]
pub(super) struct Lidar {
    spec: LidarSpec,
    /// One stream for each block of rays; empty without noise.
    streams: Vec<Stream>,
    pub(super) ranges_m: Vec<f64>,
}

/// Number of rays that draw from one stream: each takes six of the 4096 words that a stream has for a tick.
const RAYS_PER_STREAM: usize = 512;
/// Number of the scanner's first stream; the streams of obstacles are numbered from 0.
const FIRST_LIDAR_STREAM: u64 = 1 << 32;

impl LidarSpec {
    /// Bearing of the first ray from the robot's heading and step from one ray to the next, rad.
    pub fn bearings_rad(&self) -> (f64, f64) {
        let fov_rad = self.field_of_view_rad.map_or(math::TAU, |fov| math::min(fov.get(), math::TAU));
        let step = fov_rad / f64::from(self.rays.get());
        (0.5 * step - 0.5 * fov_rad, step)
    }
}

impl Lidar {
    pub(super) fn new(spec: &LidarSpec, seed: EpisodeSeed) -> Self {
        let rays = spec.rays.get() as usize;
        let noisy = spec.range_noise_m.get() > 0.0 || spec.miss_probability.get() > 0.0;
        let blocks = if noisy { rays.div_ceil(RAYS_PER_STREAM) as u64 } else { 0 };
        Self {
            streams: (0..blocks).map(|k| seed.stream(Purpose::Sensor, FIRST_LIDAR_STREAM + k)).collect(),
            ranges_m: vec![f64::INFINITY; rays],
            spec: spec.clone(),
        }
    }

    pub(super) fn bearings_rad(&self) -> (f64, f64) {
        self.spec.bearings_rad()
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vec2;
    use crate::map::OccupancyGrid;
    use crate::world::Mover;
    use crate::world::statics::{StaticMap, Statics};

    /// The ranges from [3, 2] in a hall of 8 m by 4 m, looking along x, a disc of 0.5 m around [6, 2].
    fn scan(yaml: &str) -> Vec<f64> {
        let map = StaticMap::new(OccupancyGrid::empty(8, 4, 1.0));
        let movers = [Mover::new(Vec2::new(6.0, 2.0), Vec2::zeros(), 0.5)];
        let scene = Surroundings { statics: Statics { map: &map, unknown: &[] }, movers: &movers };
        let mut lidar = Lidar::new(&serde_yaml::from_str(yaml).unwrap(), EpisodeSeed { seed: 1, episode: 0 });
        lidar.scan(&scene, Pose::new(3.0, 2.0, 0.0), 3);
        lidar.ranges_m
    }

    #[test]
    fn rays_go_through_the_middles_of_equal_sectors() {
        // Three rays over a half circle: 60° to the right, ahead, 60° to the left; the walls are 2 m beside.
        let ranges = scan("{rays: 3, field_of_view_rad: 3.141592653589793}");
        let wall = 2.0 / math::sin(math::PI / 3.0);
        for (range, expected) in ranges.iter().zip([wall, 2.5, wall]) {
            assert!((range - expected).abs() < 1e-9, "{ranges:?}");
        }
    }

    #[test]
    fn what_is_beyond_the_range_or_missed_is_infinite() {
        assert!(scan("{rays: 8, range_m: 1.9}").iter().all(|range| range.is_infinite()));
        assert!(scan("{rays: 8, miss_probability: 1}").iter().all(|range| range.is_infinite()));
    }
}
