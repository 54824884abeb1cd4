//! Never plan again after the first path (as the papers do).

use super::{Begin, ReplanRule, Watch};
use crate::settings::Entry;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// No parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {}

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "Never plan again after the first path, as the papers do." };

impl ReplanRule for Params {
    fn wants_path(&self, _: &mut Watch<'_>) -> Option<Begin> {
        None
    }
}
