//! Placeholder.
use super::{Entry, GlobalPlanner, PlanFailure, Problem, Search};
use crate::map::Cell;
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

impl GlobalPlanner for Planner {
    fn plan(&mut self, _: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        path.clear();
        Search { result: Err(PlanFailure::NoPath), expanded: 0, generated: 0 }
    }
}
