//! `dwa`: the dynamic window approach.
//!
//! Of the twists that one tick of acceleration can reach, drive each one ahead as if it stayed constant, drop those
//! that touch something or from which the robot could not stop, and command the one that best trades heading for
//! the target against distance from obstacles and speed. It reacts to what is near; it does not search, so a
//! pocket between it and the target holds it. As the local layer under a global path, or alone in open space.
//!
//! Source: D. Fox, W. Burgard, S. Thrun, "The dynamic window approach to collision avoidance", IEEE Robotics &
//! Automation Magazine 4(1), 1997; in the form of the five papers reproduced here (gao2025 eq. 19–25, qin2026
//! eq. 10–17, zhu2025 eq. 11–16, zhao2025 eq. 10–15, hu2024 eq. 14–18), which agree on
//!
//! ```text
//! G = α norm(heading) + β norm(dist) + γ norm(velocity)            largest wins, over V_s ∩ V_d ∩ V_a
//! heading  = π − |angle between the final heading and the line from the end point to the target|
//! dist     = clearance of the rollout, at most d_cap
//! velocity = v (0 where it reverses)
//! norm(k)  = k / Σ k over the admissible rollouts
//! ```
//!
//! The window, the rollouts and V_a are those of [`window`](super::window), the normalisation and the ties those of
//! [`Scoring`](super::window::Scoring).
//!
//! Departures and choices (ids of the reading notes):
//! - Movers stand where they are seen (`predict_dynamic: false`), as in plain DWA; G-A12 turns prediction on.
//! - The heading is taken at the end of the horizon, as the papers print it; Fox et al. take it where the robot
//!   would stop if it braked after the next tick (`heading_at: stop`). At the horizon's end it also slows the
//!   robot down before a near target, for a rollout that overshoots the target points away from it.
//! - `distance` is cut at 0.5 m: with the papers' usual 2 m it draws the robot into pockets.
//! - The braking rule goes by arc length to the first contact (Fox et al.) and not by the clearance to the sides.
//! - No admissible twist: [`recover`](super::window::DynamicWindow::recover), counted as a recovery.
//!
//! Parameters: [`Params`].

use super::window::{
    BrakingDistance, BrakingTurn, DistanceMode, DynamicWindow, Prediction, Rollouts, Score, Settings, Spacing,
};
use super::{Decision, Entry, Guidance, LocalPlanner, Mode};
use crate::geometry::{Pose, Twist, Vec2};
use crate::math;
use crate::observation::Observation;
use crate::quantity::{NonNegative, Positive, Samples};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where along a rollout the heading is judged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HeadingAt {
    /// At its end, as the five papers print it.
    #[default]
    Horizon,
    /// Where the robot would stand if it braked after the next tick (Fox et al. 1997).
    Stop,
}

/// Parameters of `dwa`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Weight α of the heading term; higher turns to the target sooner and goes round less. Default 0.05.
    pub heading_weight: NonNegative,
    /// Weight β of the distance term; higher keeps farther from obstacles and shuns lanes. Default 0.2.
    pub distance_weight: NonNegative,
    /// Weight γ of the velocity term; lower is timid. Default 0.1.
    pub velocity_weight: NonNegative,
    /// Time predicted, s, rounded to whole control periods. Longer sees farther and admits less. Default 3.
    pub horizon_s: Positive,
    /// Step between sampled speeds, m/s; without it `speed_samples` counts. The papers' scenarios use 0.01 to 0.02.
    pub speed_step_mps: Option<Positive>,
    /// Step between sampled yaw rates, rad/s; without it `yaw_rate_samples` counts.
    pub yaw_rate_step_radps: Option<Positive>,
    /// Sampled speeds, evenly over the window. A count fits the window of any robot and bounds the cost of a
    /// decision; more than a few change little. Default 11 (every 0.01 m/s at 0.5 m/s²).
    pub speed_samples: Samples,
    /// Sampled yaw rates, evenly over the window. Default 21 (every 0.02 rad/s at 2 rad/s²).
    pub yaw_rate_samples: Samples,
    /// How a rollout moves. Default `euler`.
    pub prediction: Prediction,
    /// Whether movers are predicted at constant velocity; else they stand where they are. Default false.
    pub predict_dynamic: bool,
    /// Where the clearance of a rollout is taken. Default `path_min`.
    pub dist_mode: DistanceMode,
    /// Clearance above which a rollout is no better, m. Default 0.5.
    pub d_cap_m: Positive,
    /// Where the heading of a rollout is judged. Default `horizon`.
    pub heading_at: HeadingAt,
    /// The distance in which the robot must be able to stop. Default `arc`.
    pub va_distance: BrakingDistance,
    /// How that rule bounds the yaw rate. Default `printed`.
    pub va_angular: BrakingTurn,
    /// Whether that distance is cut as well, which caps the speed at √(2 a d), as in the demo the papers' numbers
    /// come from. Default false.
    pub va_uses_clip: bool,
    /// Where it is cut, m; `d_cap_m` where absent.
    pub va_clip_m: Option<Positive>,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            heading_weight: NonNegative::new(0.05),
            distance_weight: NonNegative::new(0.2),
            velocity_weight: NonNegative::new(0.1),
            horizon_s: Positive::new(3.0),
            speed_step_mps: None,
            yaw_rate_step_radps: None,
            speed_samples: Samples::new(11),
            yaw_rate_samples: Samples::new(21),
            prediction: Prediction::Euler,
            predict_dynamic: false,
            dist_mode: DistanceMode::PathMin,
            d_cap_m: Positive::new(0.5),
            heading_at: HeadingAt::Horizon,
            va_distance: BrakingDistance::Arc,
            va_angular: BrakingTurn::Printed,
            va_uses_clip: false,
            va_clip_m: None,
        }
    }
}

impl Params {
    /// The settings of the window that these parameters describe.
    fn window(&self) -> Settings {
        let spacing = |step: Option<Positive>, samples: Samples| {
            step.map_or(Spacing::Count(samples.get()), |step| Spacing::Step(step.get()))
        };
        Settings {
            horizon_s: self.horizon_s.get(),
            prediction: self.prediction,
            speed: spacing(self.speed_step_mps, self.speed_samples),
            yaw_rate: spacing(self.yaw_rate_step_radps, self.yaw_rate_samples),
            predict_dynamic: self.predict_dynamic,
            clearance_cap_m: self.d_cap_m.get(),
            braking_distance: self.va_distance,
            braking_clip_m: self.va_uses_clip.then(|| self.va_clip_m.unwrap_or(self.d_cap_m).get()),
            braking_turn: self.va_angular,
        }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Dynamic window: the best of the twists within reach by heading, clearance and speed; for open space or under a global path.",
    source: "D. Fox, W. Burgard, S. Thrun, The dynamic window approach to collision avoidance, IEEE Robotics & Automation Magazine 4(1), 1997",
};

/// The planner.
#[derive(Clone, Debug)]
pub struct Planner {
    params: Params,
    window: DynamicWindow,
    score: Score,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone(), window: DynamicWindow::new(params.window()), score: Score::default() }
    }
}

impl LocalPlanner for Planner {
    fn decide(&mut self, observation: &Observation<'_>, guidance: &Guidance<'_>) -> Decision {
        let params = &self.params;
        let target = guidance.sub_goal;
        let rollouts = self.window.roll(observation);
        let count = rollouts.len() as u64;

        let mut score = self.score.over(rollouts);
        score.add(params.heading_weight.get(), |i| {
            heading(heading_pose(params.heading_at, rollouts, i, observation), target)
        });
        score.add(params.distance_weight.get(), |i| {
            math::min(rollouts.clearance_m(i, params.dist_mode), params.d_cap_m.get())
        });
        score.add(params.velocity_weight.get(), |i| math::max(rollouts.twist(i).v, 0.0));

        if let Some(best) = score.best() {
            return Decision { command: rollouts.twist(best), mode: Mode::Track, rollouts: count };
        }
        let recovery = self.window.recover(observation, target);
        Decision { command: recovery.command, mode: Mode::Recover, rollouts: count + recovery.rollouts }
    }

    fn reset(&mut self) {
        self.window.reset();
    }
}

/// π less the angle between the heading of `pose` and the line to `target`, rad: π where it points there.
pub(super) fn heading(pose: Pose, target: Vec2) -> f64 {
    math::PI - pose.bearing_to(target).abs()
}

/// Where rollout `i` is judged for its heading.
fn heading_pose(at: HeadingAt, rollouts: &Rollouts, i: usize, observation: &Observation<'_>) -> Pose {
    match at {
        HeadingAt::Horizon => rollouts.end(i),
        HeadingAt::Stop => {
            // One tick, then an arc as long as the braking distance that turns as far as the braking of the yaw rate.
            let (twist, robot) = (rollouts.twist(i), observation.robot);
            let braking = Twist {
                v: twist.v * twist.v.abs() / (2.0 * robot.deceleration_mps2),
                omega: twist.omega * twist.omega.abs() / (2.0 * robot.yaw_acceleration_radps2),
            };
            observation.pose.advance(twist, observation.dt_s).advance(braking, 1.0)
        }
    }
}
