//! Settings of a dynamic window.

use super::sampling::Spacing;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a rollout moves during one control period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Prediction {
    /// A straight step along the heading, then the turn, as the papers print it (gao eq. 19, qin eq. 11).
    #[default]
    Euler,
    /// The exact arc of a unicycle.
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

/// Settings of a dynamic window.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Time predicted, s; rounded to whole control periods, at least one.
    pub horizon_s: f64,
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
    /// The distance in which the robot must be able to stop.
    pub braking_distance: BrakingDistance,
    /// Upper limit of the braking distance, m; `None` for no limit.
    pub braking_clip_m: Option<f64>,
    /// How the yaw rate is bounded.
    pub braking_turn: BrakingTurn,
}
