//! The pull towards a target: the goal-distance term of gao2025 eq. 27 and zhu2025 eq. 17, on either scale.

use super::Rollouts;
use crate::geometry::Vec2;
use crate::math;
use crate::plan::contract::Situation;

/// Least distance from the target in [`nearness`], m.
const TARGET_DISTANCE_MIN_M: f64 = 0.1;

/// Distance from the target at which the pull on fixed scales is all there is, m: a robot that is pulled to the very point
/// slows down at every sub-goal.
const PULL_RADIUS_M: f64 = 0.5;

/// 1 / distance from the target, 1/m, for distances of at least 0.1 m (G-A15, U-A9).
pub(crate) fn nearness(distance_m: f64) -> f64 {
    1.0 / math::max(distance_m, TARGET_DISTANCE_MIN_M)
}

/// The pull on fixed scales: weight · d_best / |p_end − target|, where d_best is the nearest that any rollout of this cycle could
/// come, at least 0.5 m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pull {
    target: Vec2,
    weight: f64,
    now_m: f64,
    nearest_m: f64,
}

impl Pull {
    /// The pull of a cycle whose rollouts take `duration_s`.
    pub(crate) fn new(situation: &Situation<'_>, duration_s: f64, target: Vec2, weight: f64) -> Self {
        let now_m = (situation.pose.position - target).norm();
        let nearest_m = math::max(now_m - situation.robot.speed_max_mps * duration_s, PULL_RADIUS_M);
        Self { target, weight, now_m, nearest_m }
    }

    /// What it adds to the score of rollout `i`: the weight where the rollout ends as near as any could.
    pub(crate) fn of(&self, rollouts: &Rollouts, i: usize) -> f64 {
        let end_m = (rollouts.pose_within(i, self.now_m).position - self.target).norm();
        self.weight * self.nearest_m / math::max(end_m, self.nearest_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearness_is_the_inverse_of_the_distance_from_a_tenth_of_a_metre_on() {
        assert_eq!((nearness(4.0), nearness(0.1), nearness(0.0)), (0.25, 10.0, 10.0));
    }
}
