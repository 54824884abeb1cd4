//! All of several tests: holds if all do, fails if one does, undecided otherwise.

use super::{Data, Entry, Kind, Test, Use, Verdict, together};
use crate::paper::Paper;
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "all of several tests" };

/// Which ones.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The tests.
    pub tests: Vec<Test>,
}

impl Kind for Params {
    fn check(&self, paper: &Paper) -> Result<(), String> {
        if self.tests.is_empty() {
            return Err("`all` of no tests".to_owned());
        }
        self.tests.iter().try_for_each(|test| test.kind().check(paper))
    }

    fn uses(&self) -> Vec<Use<'_>> {
        self.tests.iter().flat_map(|test| test.kind().uses()).collect()
    }

    fn judge(&self, data: &Data<'_>) -> Verdict {
        together(self.tests.iter().map(|test| test.kind().judge(data)).collect())
    }
}
