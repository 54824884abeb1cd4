//! What a mover wants to do: straight on, erratic, round its beat, or as recorded.

use super::DT_S;
use super::statics::Digest;
use crate::geometry::{Vec2, direction};
use crate::math;
use crate::rng::Stream;
use std::sync::Arc;

/// How a mover chooses its way.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Motion {
    /// Straight on at its velocity.
    #[default]
    Uniform,
    /// Straight on for a while, then another way.
    Irregular(Box<Irregular>),
    /// From waypoint to waypoint, again and again.
    Patrol(Patrol),
    /// As recorded.
    Replay(Replay),
}

impl Motion {
    /// Takes what tells this motion from a uniform one into a fingerprint.
    pub(super) fn digest(&self, digest: &mut Digest) {
        match self {
            Self::Uniform => {}
            Self::Irregular(irregular) => {
                digest.word(1);
                irregular.interval_s.iter().chain(&irregular.speed_mps).for_each(|&x| digest.real(x));
                digest.word(irregular.stream.clone().at_tick(0).bits());
            }
            Self::Patrol(patrol) => {
                digest.word(2);
                digest.word(patrol.waypoints.len() as u64);
                patrol.waypoints.iter().for_each(|&p| digest.point(p));
                digest.real(patrol.speed_mps);
                digest.word(u64::from(patrol.closed));
                digest.real(patrol.pause_s);
            }
            Self::Replay(replay) => {
                digest.word(3);
                digest.word(replay.samples.len() as u64);
                for sample in replay.samples.iter() {
                    digest.real(sample.time_s);
                    digest.point(sample.position);
                }
                digest.word(u64::from(replay.stays));
            }
        }
    }
}

/// Piecewise constant velocity (G-A21): every now and then a new heading, uniformly random, and a new speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Irregular {
    /// Range of the time between two changes, s; rounded to whole ticks, at least one.
    pub interval_s: [f64; 2],
    /// Range of the speed, m/s.
    pub speed_mps: [f64; 2],
    /// The mover's own stream; change k draws from its place k, whatever was drawn before.
    pub stream: Stream,
}

/// One stretch of an irregular motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub(super) ticks: u32,
    pub(super) velocity: Vec2,
}

impl Irregular {
    /// Stretch `number` of the motion; of stretch 0 only the duration counts, for the mover has its first velocity already.
    pub(super) fn stretch(&self, number: u32) -> Stretch {
        let mut stream = self.stream.clone();
        let draws = stream.at_tick(number);
        let [shortest, longest] = self.interval_s;
        let ticks = (draws.range(shortest, longest) / DT_S).round().clamp(1.0, 1e9) as u32;
        let heading = draws.range(-math::PI, math::PI);
        let [slowest, fastest] = self.speed_mps;
        Stretch { ticks, velocity: draws.range(slowest, fastest) * direction(heading) }
    }
}

/// Waypoints driven one after the other in straight lines, with a stop at each where `pause_s` is above 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Patrol {
    /// The waypoints, grid frame, m; at least two, no two neighbours equal.
    pub waypoints: Arc<[Vec2]>,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Whether the last waypoint leads to the first; else back the way it came.
    pub closed: bool,
    /// Stop at every waypoint, s.
    pub pause_s: f64,
}

impl Patrol {
    /// The waypoint after `at`, and the direction of counting from there on.
    pub(super) fn after(&self, at: usize, backwards: bool) -> (usize, bool) {
        let last = self.waypoints.len() - 1;
        match (self.closed, backwards) {
            (true, _) => (if at == last { 0 } else { at + 1 }, false),
            (false, false) => {
                if at == last {
                    (at - 1, true)
                } else {
                    (at + 1, false)
                }
            }
            (false, true) => {
                if at == 0 {
                    (1, false)
                } else {
                    (at - 1, true)
                }
            }
        }
    }
}

/// Where a recorded mover was when.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the episode began, s; may be negative.
    pub time_s: f64,
    /// Centre, grid frame, m.
    pub position: Vec2,
}

/// A recording: straight lines between its samples. Before the first one the mover is not there, after the last one
/// neither, unless it stays.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// The samples, by time, no two at one time; at least one.
    pub samples: Arc<[Sample]>,
    /// Whether it stands where the data ends, instead of vanishing.
    pub stays: bool,
}

impl Replay {
    /// Whether the mover is there for the whole of a tick that begins at `time_s`.
    pub(super) fn is_present(&self, time_s: f64) -> bool {
        const SLACK_S: f64 = 1e-9;
        let (first, last) = (self.samples[0].time_s, self.samples[self.samples.len() - 1].time_s);
        time_s >= first - SLACK_S && (self.stays || time_s + DT_S <= last + SLACK_S)
    }

    /// Where it is at `time_s`; at the ends of the data outside of it.
    pub(super) fn position(&self, time_s: f64) -> Vec2 {
        let samples = &self.samples;
        let after = samples.partition_point(|sample| sample.time_s <= time_s);
        if after == 0 {
            return samples[0].position;
        }
        let a = samples[after - 1];
        let Some(b) = samples.get(after) else { return a.position };
        a.position + (b.position - a.position) * ((time_s - a.time_s) / (b.time_s - a.time_s))
    }

    /// Times of the samples strictly between `from_s` and `to_s`.
    pub(super) fn sample_times(&self, from_s: f64, to_s: f64) -> impl Iterator<Item = f64> + '_ {
        let first = self.samples.partition_point(|sample| sample.time_s <= from_s);
        self.samples[first..].iter().map(|sample| sample.time_s).take_while(move |&time_s| time_s < to_s)
    }
}
