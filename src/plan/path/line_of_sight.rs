//! Placeholder.
use super::{Entry, PathStage, PlanningGrid};
use crate::geometry::Path;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {}

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "", source: "" };

/// The stage.
#[derive(Debug)]
pub struct Stage {}

impl Stage {
    /// A fresh stage.
    pub fn new(_: &Params) -> Self {
        Self {}
    }
}

impl PathStage for Stage {
    fn apply(&mut self, _: &PlanningGrid, path: &Path) -> Path {
        path.clone()
    }
}
