//! The terms of the objective that every planner over the dynamic window shares.

use super::{DistanceMode, Rollouts};
use crate::geometry::{Pose, Twist, Vec2};
use crate::math;
use crate::plan::contract::{Guidance, Situation};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where along a rollout the heading is judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HeadingAt {
    /// At its end, or where it arrives at the target if that is sooner: a rollout that overshoots its target is not to
    /// blame for what lies behind it.
    #[default]
    Arrival,
    /// At its end, as the five papers print it.
    Horizon,
    /// Where the robot would stand if it braked after the next tick (Fox et al. 1997).
    Stop,
}

/// The point that the terms of an objective aim at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// The sub-goal on the path.
    #[default]
    SubGoal,
    /// The goal itself, whatever the path.
    Goal,
}

impl Target {
    /// The point, grid frame, m.
    pub fn point(self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Vec2 {
        match self {
            Self::SubGoal => guidance.sub_goal,
            Self::Goal => situation.goal,
        }
    }
}

/// The terms of the objective that every planner over the window shares, for the rollouts of one cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms<'a> {
    pub rollouts: &'a Rollouts,
    pub situation: &'a Situation<'a>,
    pub target: Vec2,
    pub heading_at: HeadingAt,
    pub dist_mode: DistanceMode,
    pub d_cap_m: f64,
}

impl Terms<'_> {
    /// Heading term of rollout `i`, rad: π if it points to the target, 0 if it points away.
    pub fn heading(&self, i: usize) -> f64 {
        heading(self.judged_pose(i), self.target)
    }

    /// Distance term of rollout `i`, m: its clearance, at most the cap.
    pub fn distance_m(&self, i: usize) -> f64 {
        math::min(self.rollouts.clearance_m(i, self.dist_mode), self.d_cap_m)
    }

    /// Velocity term of rollout `i`, m/s: 0 if it reverses.
    pub fn velocity_mps(&self, i: usize) -> f64 {
        math::max(self.rollouts.twist(i).v, 0.0)
    }

    /// Pose at which the heading of rollout `i` is judged.
    fn judged_pose(&self, i: usize) -> Pose {
        match self.heading_at {
            HeadingAt::Horizon => self.rollouts.end(i),
            HeadingAt::Arrival => self.rollouts.pose_within(i, (self.target - self.situation.pose.position).norm()),
            HeadingAt::Stop => {
                // One tick, then an arc as long as the braking distance that turns as far as the braking of the yaw rate.
                let (twist, robot) = (self.rollouts.twist(i), self.situation.robot);
                let braking = Twist {
                    v: twist.v * twist.v.abs() / (2.0 * robot.deceleration_max_mps2),
                    omega: twist.omega * twist.omega.abs() / (2.0 * robot.yaw_acceleration_max_radps2),
                };
                self.situation.pose.advance(twist, self.situation.dt_s).advance(braking, 1.0)
            }
        }
    }
}

/// π less the angle between the heading of `pose` and the line to `target`, rad: π if it points there.
fn heading(pose: Pose, target: Vec2) -> f64 {
    math::PI - pose.bearing_to(target).abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heading_is_pi_towards_the_target_and_zero_away_from_it() {
        let pose = Pose::new(1.0, 1.0, math::FRAC_PI_2);
        assert!((heading(pose, Vec2::new(1.0, 3.0)) - math::PI).abs() < 1e-12);
        assert!(heading(pose, Vec2::new(1.0, 0.0)).abs() < 1e-12);
        assert!((heading(pose, Vec2::new(5.0, 1.0)) - math::FRAC_PI_2).abs() < 1e-12);
        assert_eq!(heading(pose, pose.position), math::PI);
    }
}
