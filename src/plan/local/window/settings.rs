//! Settings of a dynamic window.

use super::sampling::Spacing;
use crate::geometry::Twist;
use crate::math;
use crate::robot::Robot;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The scales on which the terms of the objective are added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Normalise {
    /// Scales that do not depend on the other candidates; progress along the path is the main term.
    #[default]
    Fixed,
    /// Each term over its sum over the admissible candidates of the cycle, as the papers print it.
    Sum,
}

/// How a rollout moves during one control period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Prediction {
    /// A straight step along the heading, then the turn, as the papers print it (gao eq. 19, qin eq. 11).
    Euler,
    /// The exact arc of a unicycle.
    #[default]
    Arc,
}

/// Where along a rollout the clearance is taken for scoring.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DistanceMode {
    /// The least over the whole rollout (gao, qin).
    #[default]
    PathMin,
    /// At its end point (zhu, hu: U-A15, H-A10).
    Endpoint,
}

/// The distance in which the robot must be able to stop (the `dist` of V_a).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BrakingDistance {
    /// Arc length to the first contact, as Fox et al. define it.
    #[default]
    Arc,
    /// The least clearance over the rollout, as the papers' one `dist` for both uses has it. Slow in lanes:
    /// clearance to the sides brakes as well.
    Clearance,
}

/// How the yaw rate is bounded by V_a.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BrakingTurn {
    /// |ω| ≤ √(2 dist α) with dist in metres, as printed (and dimensionally odd).
    #[default]
    Printed,
    /// |ω| ≤ √(2 (dist/r) α) with r = v/|ω|: the angle that is driven over that distance.
    Arc,
    /// No bound.
    Off,
}

/// How clearances of rollouts are measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// The distance of each predicted pose, exactly; what lies between two poses does not count, as in the papers' formulas.
    #[default]
    Exact,
    /// Lower bounds, a few millimetres too small, of the lines through the poses: faster. All that version 0.1 had.
    Bound,
}

/// Settings of a dynamic window.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The scales of the objective, and with them how movers are met: with [`Normalise::Sum`] a rollout that touches one within
    /// the horizon is not admissible, with [`Normalise::Fixed`] one that could not brake before it either.
    pub normalise: Normalise,
    /// Time predicted, s; rounded to whole control periods, at least one. `None`: [`Settings::horizon_s`].
    pub horizon_s: Option<f64>,
    /// Time over which movers are predicted with [`Normalise::Fixed`], s. `None`: [`Settings::movers_horizon_s`].
    pub movers_horizon_s: Option<f64>,
    /// Least distance that an admissible rollout keeps from statics, m.
    pub room_m: f64,
    /// How a rollout moves.
    pub prediction: Prediction,
    /// Samples of the speed.
    pub speed: Spacing,
    /// Samples of the yaw rate.
    pub yaw_rate: Spacing,
    /// Whether movers keep their velocity over the horizon; else they stand where they are.
    pub predict_dynamic: bool,
    /// Clearances are computed up to at least this distance, m.
    pub clearance_cap_m: f64,
    /// Which clearance of a rollout is asked for: with [`Measure::Exact`] that one is exact, the other one a lower bound.
    pub distance_mode: DistanceMode,
    /// How clearances are measured with [`Normalise::Sum`]; with [`Normalise::Fixed`], and for a robot that is no disc, they are bounds.
    pub measure: Measure,
    /// The distance in which the robot must be able to stop.
    pub braking_distance: BrakingDistance,
    /// Upper limit of the braking distance, m; `None` for no limit.
    pub braking_clip_m: Option<f64>,
    /// How the yaw rate is bounded.
    pub braking_turn: BrakingTurn,
}

/// Shortest horizon where none is given, s.
const HORIZON_MIN_S: f64 = 1.5;
/// Shortest horizon for movers where none is given, s.
const MOVERS_HORIZON_MIN_S: f64 = 3.0;

impl Settings {
    /// Time predicted against statics, s: the given one, or what the robot needs to stop from top speed within the arc that it
    /// has looked at (v ≤ 2 a T), v / 2a, and 0.5 s; at least 1.5 s. A longer horizon shuns what lies where the robot will have
    /// turned long before.
    pub fn horizon_s(&self, robot: &Robot) -> f64 {
        let stopping_s = robot.speed_max_mps / (2.0 * robot.deceleration_max_mps2);
        self.horizon_s.unwrap_or_else(|| math::max(stopping_s + 0.5, HORIZON_MIN_S))
    }

    /// Distance in which a robot that moves with `twist` can stop, m, where V_a asks the clearance for it; 0 where it goes by the arc.
    pub(super) fn braking_clearance_m(&self, robot: &Robot, twist: Twist) -> f64 {
        if self.braking_distance == BrakingDistance::Arc {
            return 0.0;
        }
        let (speed, yaw_rate) = (twist.v.abs(), twist.omega.abs());
        let ahead = speed * speed / (2.0 * robot.deceleration_max_mps2);
        let turn_lost = 2.0 * robot.yaw_acceleration_max_radps2;
        let around = match self.braking_turn {
            BrakingTurn::Off => 0.0,
            BrakingTurn::Printed => yaw_rate * yaw_rate / turn_lost,
            BrakingTurn::Arc => speed * yaw_rate / turn_lost,
        };
        let braking = math::max(ahead, around);
        self.braking_clip_m.map_or(braking, |clip| math::min(braking, clip))
    }

    /// Time predicted against movers, s: the given one, or what the robot needs to stop and one second; at least 3 s.
    pub fn movers_horizon_s(&self, robot: &Robot) -> f64 {
        let stopping_s = robot.speed_max_mps / robot.deceleration_max_mps2;
        self.movers_horizon_s.unwrap_or_else(|| math::max(stopping_s + 1.0, MOVERS_HORIZON_MIN_S))
    }
}
