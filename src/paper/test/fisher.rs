//! The paper's own counts show one of its stacks to be better than another: two-sided exact test of Fisher, p ≤ 0.05.

use super::{Data, Entry, Kind, Place, Ruling, Use, Verdict, missing, verdict};
use crate::analysis::fisher_exact;
use crate::comparison::ALPHA;
use crate::paper::Paper;
use crate::paper::published::{Published, SUCCESS};
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "the printed counts tell two stacks apart" };

/// Which two.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The stack that should be better.
    pub of: Place,
    /// The stack that should be worse.
    pub than: Place,
}

impl Kind for Params {
    fn check(&self, paper: &Paper) -> Result<(), String> {
        paper.known(&self.of.table).and_then(|()| paper.known(&self.than.table))
    }

    fn uses(&self) -> Vec<Use<'_>> {
        Vec::new()
    }

    fn judge(&self, data: &Data<'_>) -> Verdict {
        let counts = |place: &Place| data.printed(place, SUCCESS).and_then(Published::counts);
        let (Some((a, n)), Some((b, m))) = (counts(&self.of), counts(&self.than)) else {
            return missing("no published counts");
        };
        let p = fisher_exact([[a, n - a], [b, m - b]]);
        let ruling = if p <= ALPHA && a * m > b * n { Ruling::Holds } else { Ruling::Fails };
        verdict(ruling, format!("{a}/{n} against {b}/{m} ({}): p = {p:.3}", self.than.stack))
    }
}
