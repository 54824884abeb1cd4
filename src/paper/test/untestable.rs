//! Nothing that simrun can run would decide it.

use super::{Data, Entry, Kind, Ruling, Use, Verdict, verdict};
use crate::paper::Paper;
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "nothing that simrun can run would decide it" };

/// Why not.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The reason.
    pub because: String,
}

impl Kind for Params {
    fn check(&self, _: &Paper) -> Result<(), String> {
        Ok(())
    }

    fn uses(&self) -> Vec<Use<'_>> {
        Vec::new()
    }

    fn judge(&self, _: &Data<'_>) -> Verdict {
        verdict(Ruling::Untestable, self.because.clone())
    }
}
