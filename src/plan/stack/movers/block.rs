//! The cells that sensed movers cover are impassable at the moment of planning (qin2026: dynamic obstacles as blocked cells).
//!
//! A mover covers the disc around its outline, inflated as statics are, swept along its velocity for `predict_s`. The robot's own
//! surroundings open as the inflated zone of a static does.

use super::MoversOnGrid;
use crate::plan::PlanningGrid;
use crate::plan::contract::Situation;
use crate::settings::Entry;
use crate::settings::quantity::NonNegative;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How much of a mover's way is blocked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Time over which a mover's straight way is blocked as well, s. Default 0: where it is now.
    pub predict_s: NonNegative,
}

impl Default for Params {
    fn default() -> Self {
        Self { predict_s: NonNegative::new(0.0) }
    }
}

/// Registry entry.
pub const ENTRY: Entry =
    Entry { summary: "The cells that sensed movers cover are impassable at the moment of planning." };

impl MoversOnGrid for Params {
    fn mark(&self, grid: &mut PlanningGrid, situation: &Situation<'_>, inflation_m: f64) {
        for mover in situation.obstacles {
            let end = mover.position + mover.velocity * self.predict_s.get();
            grid.block_capsule(mover.position, end, mover.radius_m() + inflation_m);
        }
    }

    fn block(&self) -> bool {
        true
    }
}
