//! Path stages: they prune or smooth the path of a global planner. One file per stage.

use super::contract::{Entry, Fit, PathStage};
use crate::settings::registry;

/// Behaviour of the parameters of a path stage.
pub trait PathKind {
    /// A fresh stage.
    fn build(&self) -> Box<dyn PathStage>;

    /// Whether the parameters fit this map and robot.
    ///
    /// # Errors
    /// A message that says what does not fit.
    fn check(&self, _: &Fit<'_>) -> Result<(), String> {
        Ok(())
    }
}

registry! {
    /// A path stage with its parameters.
    pub enum PathChoice: "path stage", Entry, dyn PathKind {
        line_of_sight,
        clearance_prune,
        arc_fillet,
    }
}

impl PathChoice {
    /// A fresh stage.
    pub fn build(&self) -> Box<dyn PathStage> {
        self.kind().build()
    }
}
