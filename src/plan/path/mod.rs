//! Path stages: they prune or smooth what a global planner found. One file per stage.

use super::{Entry, PlanningGrid};
use crate::geometry::Path;
use crate::settings::choice::choice;

macro_rules! registry {
    ($($module:ident),+ $(,)?) => {
        $(pub mod $module;)+

        choice! {
            /// A path stage with its parameters.
            pub enum PathChoice: "path stage" { $($module = $module::ENTRY.summary),+ }
        }

        impl PathChoice {
            /// A fresh stage.
            pub fn build(&self) -> Box<dyn PathStage> {
                match self { $(Self::$module(params) => Box::new($module::Stage::new(params))),+ }
            }

            /// What the registry says of each stage, in the order of [`Self::NAMES`].
            pub const ENTRIES: &'static [Entry] = &[$($module::ENTRY),+];
        }
    };
}

registry! {
    line_of_sight,
    clearance_prune,
    arc_fillet,
}

/// Turns a path into a better one on the same planning grid.
pub trait PathStage: Send {
    /// The new path: same start, same end.
    fn apply(&mut self, grid: &PlanningGrid, path: &Path) -> Path;
}
