//! The robot's way: its path ahead, and which movers are in it.

use crate::geometry::{Path, Pose, Vec2, direction};
use crate::math;
use crate::observation::SensedObstacle;
use crate::plan::contract::{Guidance, Situation};

/// Step between the points of the path at which its corridor is looked at, m.
const STEP_M: f64 = 0.1;
/// Distance along the path over which its direction is taken, m.
const DIRECTION_M: f64 = 0.5;
/// Points nearer to each other have no direction, m.
const SAME_M: f64 = 1e-6;

/// The path ahead of the robot at one tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way<'a> {
    path: &'a Path,
    /// Place of the robot on it, m.
    progress_m: f64,
    here: Vec2,
    /// Direction of the planned trajectory (H-A16).
    pub(super) ahead: Vec2,
    /// Distance from the path within which a robot on it would touch a mover without radius, m.
    half_width_m: f64,
    radius_m: f64,
}

impl<'a> Way<'a> {
    /// The way of this tick, with `margin_m` to either side of the robot.
    pub(super) fn new(situation: &Situation<'_>, guidance: &Guidance<'a>, margin_m: f64) -> Self {
        let Pose { position: here, theta } = situation.pose;
        let (path, progress_m) = (guidance.path, guidance.progress_m);
        let along = path.point_at(progress_m + DIRECTION_M) - path.point_at(progress_m);
        let to_end = path.end() - here;
        let candidates = [along, to_end].into_iter().find(|way| way.norm() >= SAME_M);
        let ahead = candidates.map_or_else(|| direction(theta), |way| way.normalize());
        let radius_m = situation.robot.radius_m;
        Self { path, progress_m, here, ahead, half_width_m: radius_m + margin_m, radius_m }
    }

    /// Distance between the surfaces of the robot and a mover, as discs, m.
    pub(super) fn gap_m(&self, mover: &SensedObstacle) -> f64 {
        (mover.position - self.here).norm() - self.radius_m - mover.radius_m()
    }

    /// Angle between the motion of a mover and the direction of the way, degrees, from 0 to 180.
    pub(super) fn angle_deg(&self, mover: &SensedObstacle) -> f64 {
        let cosine = mover.velocity.dot(&self.ahead) / mover.velocity.norm();
        math::acos(math::clamp(cosine, -1.0, 1.0)).to_degrees()
    }

    /// Whether a mover is ahead and touches the corridor about the next `reach_m` of the path, now or at one of the next
    /// `lead_ticks` ticks if it keeps its velocity.
    pub(super) fn holds(&self, mover: &SensedObstacle, reach_m: f64, lead_ticks: u32, dt_s: f64) -> bool {
        if (mover.position - self.here).dot(&self.ahead) <= 0.0 {
            return false;
        }
        let touch_m = self.half_width_m + mover.radius_m();
        let points = (reach_m / STEP_M).round() as u32;
        (0..=points).any(|k| {
            let point = self.path.point_at(self.progress_m + STEP_M * f64::from(k));
            (0..=lead_ticks).any(|tick| {
                let then = mover.position + mover.velocity * (f64::from(tick) * dt_s);
                (then - point).norm() <= touch_m
            })
        })
    }
}
