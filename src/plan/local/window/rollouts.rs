//! The rollouts of one cycle: their twists, their ends, their clearances.

use super::settings::DistanceMode;
use crate::geometry::{Pose, Twist, Vec2};
use crate::math;

/// Clearance of one rollout from one kind of obstacle, m: never more than the true one, at least 0, cut at the
/// cap; 0 where the rollout touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// The least over the whole rollout.
    pub path_min_m: f64,
    /// At its end.
    pub end_m: f64,
}

impl Clearance {
    /// The clearance that `mode` selects.
    pub fn at(self, mode: DistanceMode) -> f64 {
        match mode {
            DistanceMode::PathMin => self.path_min_m,
            DistanceMode::Endpoint => self.end_m,
        }
    }

    pub(super) fn both(value_m: f64) -> Self {
        Self { path_min_m: value_m, end_m: value_m }
    }
}

/// The rollouts of one cycle, by index: speed varies slowest, yaw rate fastest, both ascending.
#[derive(Clone, Debug)]
pub struct Rollouts {
    pub(super) origin: Pose,
    pub(super) duration_s: f64,
    /// Clearance from statics at the point where the robot is to stand, m; infinite if it is to go on.
    pub(super) stop_clearance_m: f64,
    pub(super) twists: Vec<Twist>,
    /// Displacement from the origin to the end, m.
    pub(super) end: Vec<Vec2>,
    /// Time driven before the first contact, s; the whole horizon if nothing is touched.
    pub(super) free_s: Vec<f64>,
    pub(super) statics: Vec<Clearance>,
    pub(super) movers: Vec<Clearance>,
    /// With fixed scales: time until the first contact with a mover, s.
    pub(super) going_on_s: Vec<f64>,
    pub(super) admissible: Vec<u32>,
    /// Those that only the movers keep from being admissible.
    pub(super) doubtful: Vec<u32>,
}

impl Rollouts {
    pub(super) fn new() -> Self {
        Self {
            origin: Pose::new(0.0, 0.0, 0.0),
            duration_s: 0.0,
            stop_clearance_m: f64::INFINITY,
            twists: Vec::new(),
            end: Vec::new(),
            free_s: Vec::new(),
            statics: Vec::new(),
            movers: Vec::new(),
            going_on_s: Vec::new(),
            admissible: Vec::new(),
            doubtful: Vec::new(),
        }
    }

    /// Number of rollouts.
    pub fn len(&self) -> usize {
        self.twists.len()
    }

    /// Whether there are no rollouts, which is so only before the first cycle.
    pub fn is_empty(&self) -> bool {
        self.twists.is_empty()
    }

    /// Indices of the admissible rollouts, ascending.
    pub fn admissible(&self) -> impl Iterator<Item = usize> + '_ {
        self.admissible.iter().map(|&i| i as usize)
    }

    /// Twist of rollout `i`.
    pub fn twist(&self, i: usize) -> Twist {
        self.twists[i]
    }

    /// Pose at the end of rollout `i`; valid only if it touches nothing.
    pub fn end(&self, i: usize) -> Pose {
        let end = self.origin.position + self.end[i];
        Pose::new(end.x, end.y, self.origin.theta + self.twists[i].omega * self.duration_s)
    }

    /// Pose where rollout `i` has driven `arc_m`, or at its end if that comes sooner.
    pub fn pose_within(&self, i: usize, arc_m: f64) -> Pose {
        let twist = self.twists[i];
        if twist.v * self.duration_s <= arc_m { self.end(i) } else { self.origin.advance(twist, arc_m / twist.v) }
    }

    /// Time until rollout `i` touches a mover if the robot goes on with its twist and brakes only for a static or its target, s;
    /// infinite if it touches none within the horizon for movers. Only with fixed scales.
    pub fn going_on_s(&self, i: usize) -> f64 {
        self.going_on_s[i]
    }

    /// Whether rollout `i` touches a mover beyond what [`Self::touches`] says.
    pub(super) fn meets_movers(&self, i: usize) -> bool {
        self.going_on_s.get(i).is_some_and(|time_s| time_s.is_finite())
    }

    /// Clearance of rollout `i` from the believed statics and the edge of the map.
    pub fn static_clearance(&self, i: usize) -> Clearance {
        self.statics[i]
    }

    /// Clearance of rollout `i` from the sensed movers; the cap if none is in reach.
    pub fn mover_clearance(&self, i: usize) -> Clearance {
        self.movers[i]
    }

    /// Clearance of rollout `i` from the nearest static or mover, m.
    pub fn clearance_m(&self, i: usize, mode: DistanceMode) -> f64 {
        math::min(self.statics[i].at(mode), self.movers[i].at(mode))
    }

    /// Whether rollout `i` touches an obstacle within the horizon.
    pub fn touches(&self, i: usize) -> bool {
        self.free_s[i] < self.duration_s
    }

    /// Clearance from statics at the point where the robot is to stand, m; infinite if it is to go on.
    pub fn stop_clearance_m(&self) -> f64 {
        self.stop_clearance_m
    }

    /// Time driven by every rollout, s.
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// Arc length that rollout `i` drives before its first contact, m; that of the whole rollout if it touches nothing.
    pub fn free_arc_m(&self, i: usize) -> f64 {
        self.twists[i].v.abs() * self.free_s[i]
    }
}
