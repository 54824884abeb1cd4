//! Placeholder.
use super::{Decision, Entry, Guidance, LocalPlanner, Mode};
use crate::geometry::Twist;
use crate::observation::Observation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {}

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "", source: "" };

/// The planner.
#[derive(Debug)]
pub struct Planner {}

impl Planner {
    /// A fresh planner.
    pub fn new(_: &Params) -> Self {
        Self {}
    }
}

impl LocalPlanner for Planner {
    fn decide(&mut self, _: &Observation<'_>, _: &Guidance<'_>) -> Decision {
        Decision { command: Twist::ZERO, mode: Mode::Track, rollouts: 0 }
    }
}
