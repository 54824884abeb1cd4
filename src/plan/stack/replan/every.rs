//! Plan again at a fixed period.

use super::{Begin, ReplanRule, Watch};
use crate::settings::Entry;
use crate::settings::quantity::Positive;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The period.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Time between two plans, s.
    pub period_s: Positive,
}

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "Plan again at a fixed period." };

impl ReplanRule for Params {
    fn wants_path(&self, watch: &mut Watch<'_>) -> Option<Begin> {
        watch.planned_before(self.period_s.get()).then_some(Begin::Robot)
    }
}
