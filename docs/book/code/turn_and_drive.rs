//! `turn_and_drive`: turns towards the sub-goal and drives the faster, the better it points there. Avoids nothing.

use super::LocalKind;
use crate::geometry::Twist;
use crate::plan::contract::{Decision, Entry, Failure, Guidance, LocalPlanner, Situation};
use crate::settings::quantity::Positive;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `turn_and_drive`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Yaw rate per radian of bearing, 1/s. Default 1.5.
    pub gain_hz: Positive,
}

impl Default for Params {
    fn default() -> Self {
        Self { gain_hz: Positive::new(1.5) }
    }
}

/// Registry entry.
pub const ENTRY: Entry =
    Entry { summary: "Turns towards the sub-goal; avoids nothing.", source: "this guide", ..Entry::PLAIN };

impl LocalKind for Params {
    fn build(&self) -> Box<dyn LocalPlanner> {
        Box::new(Planner { gain_hz: self.gain_hz.get() })
    }
}

/// The planner.
#[derive(Debug)]
pub struct Planner {
    gain_hz: f64,
}

impl LocalPlanner for Planner {
    fn entry(&self) -> &'static Entry {
        &ENTRY
    }

    fn decide(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Result<Decision, Failure> {
        let bearing = situation.pose.bearing_to(guidance.sub_goal);
        let alignment = if bearing.abs() < 1.0 { 1.0 - bearing.abs() } else { 0.0 };
        let command = Twist { v: situation.robot.speed_max_mps * alignment, omega: self.gain_hz * bearing };
        Ok(Decision::track(command))
    }
}
