//! Movers are none of the global planner's business.

use super::MoversOnGrid;
use crate::plan::PlanningGrid;
use crate::plan::contract::Situation;
use crate::settings::Entry;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// No parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {}

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "Movers are left to the local planner." };

impl MoversOnGrid for Params {
    fn mark(&self, _: &mut PlanningGrid, _: &Situation<'_>, _: f64) {}

    fn block(&self) -> bool {
        false
    }
}
