//! Plan again when the rest of the path has become blocked on the belief map, or the robot has come to a stand.

use super::{ReplanRule, Watch};
use crate::settings::Entry;
use crate::settings::quantity::NonNegative;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When a stand counts as blocked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Also plan again when the robot has stood within 0.1 m for this long, s: a new path may lead elsewhere, and one that
    /// came into force at full speed may have been missed. 0 never does; default 5.
    pub after_standing_s: NonNegative,
}

impl Default for Params {
    fn default() -> Self {
        Self { after_standing_s: NonNegative::new(5.0) }
    }
}

/// Registry entry.
pub const ENTRY: Entry =
    Entry { summary: "Plan again when the rest of the path has become blocked, or the robot has stood for a while." };

impl ReplanRule for Params {
    fn wants_path(&self, watch: &mut Watch<'_>) -> bool {
        let after_s = self.after_standing_s.get();
        (after_s > 0.0 && watch.has_stood(after_s)) || watch.path_has_become_blocked()
    }
}
