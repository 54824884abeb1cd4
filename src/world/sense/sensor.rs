//! The sensor for obstacles: which ones it perceives, and with what errors.

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
    /// Whether the sensor has noise or misses obstacles at random.
    fn is_noisy(&self) -> bool {
        let noise = [self.range_noise_m, self.bearing_noise_rad, self.velocity_noise_mps];
        noise.iter().any(|noise| noise.get() > 0.0) || self.miss_probability.get() > 0.0
    }
}

/// Slack of a line of sight, m: bound of the rounding error in the distance to the point that is looked at.
const SIGHT_SLACK_M: f64 = 1e-6;

/// Number of an obstacle's stream: unknown statics first, then movers; the map has none.
fn stream_number(bodies: Bodies, body: Body) -> Option<usize> {
    bodies.index(body).checked_sub(1)
}

/// Errors with which an obstacle is perceived at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sighting {
    /// Offset from its true to its perceived position, m.
    pub(super) offset: Vec2,
    /// Error of the velocity, m/s.
    pub(super) velocity_error: Vec2,
}

/// The sensor for obstacles.
#[derive(Clone, Debug)]
pub(super) struct Sensor {
    spec: SensingSpec,
    /// Range in force now, m.
    range_m: f64,
    bodies: Bodies,
    /// One stream for each obstacle, by [`stream_number`]; empty without noise.
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

    /// Whether distance alone decides if an obstacle is sensed, and it is sensed without errors.
    fn is_plain(&self) -> bool {
        self.spec.field_of_view_rad.is_none() && !self.spec.occlusion && self.streams.is_empty()
    }

    /// The errors with which the obstacle `body` of `scene` is perceived from `eye`; `None` if it is not perceived. `gap_m` is the
    /// distance to its surface, `nearest` the nearest point of it.
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

/// The obstacles that can hide others.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::OccupancyGrid;
    use crate::world::statics::StaticMap;
    use crate::world::{Shape, UnknownStatic};

    const SEED: EpisodeSeed = EpisodeSeed { seed: 2, episode: 0 };
    const BODIES: Bodies = Bodies { unknown: 1, movers: 1 };

    /// How a mover of radius 0.5 at [5, 2] is perceived from [2, 2], looking along `theta`; a box stands between them if it is
    /// `present`.
    fn look(spec: &SensingSpec, theta: f64, present: bool) -> Option<Sighting> {
        let map = StaticMap::new(OccupancyGrid::empty(8, 4, 1.0));
        let crate_at = UnknownStatic::new(Pose::new(3.5, 2.0, 0.0), Shape::Rectangle { half_m: Vec2::new(0.2, 0.2) });
        let unknown = [crate_at.with_presence(present)];
        let movers = [Mover::new(Vec2::new(5.0, 2.0), Vec2::zeros(), 0.5)];
        let scene = Surroundings { statics: Statics { map: &map, unknown: &unknown }, movers: &movers };
        let eye = Pose::new(2.0, 2.0, theta);
        let gap_m = movers[0].outline.distance_m(movers[0].position, eye.position);
        let nearest = || movers[0].outline.nearest_point(movers[0].position, eye.position);
        Sensor::new(spec, SEED, BODIES).look(&scene, eye, 7, Body::Mover(0), gap_m, nearest)
    }

    #[test]
    fn range_view_and_sight_are_judged_at_the_nearest_point() {
        let perfect = Some(Sighting { offset: Vec2::zeros(), velocity_error: Vec2::zeros() });
        // Its surface is 2.5 m away.
        let within = |range_m: f64| SensingSpec { range_m: Positive::new(range_m), ..SensingSpec::default() };
        assert_eq!((look(&within(2.6), 0.0, false), look(&within(2.4), 0.0, false)), (perfect, None));
        let sector = SensingSpec { field_of_view_rad: Some(Positive::new(1.0)), ..SensingSpec::default() };
        assert_eq!((look(&sector, 0.49, false), look(&sector, -0.51, false)), (perfect, None));
        let sight = SensingSpec { occlusion: true, ..SensingSpec::default() };
        assert_eq!((look(&sight, 0.0, false), look(&sight, 0.0, true)), (perfect, None));
    }

    #[test]
    fn noise_moves_along_and_across_the_line_of_sight() {
        let quiet = SensingSpec::default();
        let range = SensingSpec { range_noise_m: NonNegative::new(0.1), ..quiet.clone() };
        let along = look(&range, 0.0, false).unwrap().offset;
        assert!(along.x != 0.0 && along.y.abs() < 1e-12, "{along:?}");
        let bearing = SensingSpec { bearing_noise_rad: NonNegative::new(0.1), ..quiet.clone() };
        let across = look(&bearing, 0.0, false).unwrap().offset + Vec2::new(2.5, 0.0);
        assert!(across.y != 0.0 && (across.norm() - 2.5).abs() < 1e-12, "{across:?}");
        let missing = SensingSpec { miss_probability: Fraction::new(1.0), ..quiet };
        assert_eq!(look(&missing, 0.0, false), None);
    }

    #[test]
    fn a_ray_ends_at_the_first_surface_but_that_of_the_body_left_out() {
        let map = StaticMap::new(OccupancyGrid::empty(8, 4, 1.0));
        let unknown = [UnknownStatic::new(Pose::new(3.5, 2.0, 0.0), Shape::Disc { radius_m: 0.5 })];
        let movers = [Mover::new(Vec2::new(5.0, 2.0), Vec2::zeros(), 0.5)];
        let scene = Surroundings { statics: Statics { map: &map, unknown: &unknown }, movers: &movers };
        let cast = |except| scene.cast_ray(Vec2::new(2.0, 2.0), Vec2::x(), 9.0, except);
        assert!((cast(None) - 1.0).abs() < 1e-12 && (cast(Some(Body::Unknown(0))) - 2.5).abs() < 1e-12);
        let gone = Surroundings { movers: &[], statics: Statics { map: &map, unknown: &[] } };
        assert!((gone.cast_ray(Vec2::new(2.0, 2.0), Vec2::x(), 9.0, None) - 6.0).abs() < 1e-12, "the map's edge");
    }
}
