//! Plan again when the robot has stood for a while.

use super::{Begin, ReplanRule, Watch};
use crate::settings::Entry;
use crate::settings::quantity::Positive;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When the robot counts as standing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// How long it must have stood, s; default 5.
    pub after_s: Positive,
    /// Within which distance it counts as standing, m; default 0.1.
    pub radius_m: Positive,
}

impl Default for Params {
    fn default() -> Self {
        Self { after_s: Positive::new(5.0), radius_m: Positive::new(0.1) }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "Plan again when the robot has stood for a while." };

impl ReplanRule for Params {
    fn wants_path(&self, watch: &mut Watch<'_>) -> Option<Begin> {
        watch.has_stood(self.after_s.get()).then_some(Begin::Robot)
    }

    fn standing_radius_m(&self) -> f64 {
        self.radius_m.get()
    }
}
