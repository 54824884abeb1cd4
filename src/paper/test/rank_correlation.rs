//! The printed means of a table's stacks rank them as our means do: Spearman's correlation of the two.
//!
//! Holds if the correlation is positive and p ≤ 0.05, fails if it is negative and p ≤ 0.05, undecided otherwise. Few stacks tell
//! little: of six, nothing below 0.89 is significant.

use super::{Data, Entry, Kind, Place, Ruling, Use, Verdict, check_metric, missing, p_text, verdict};
use crate::analysis::spearman;
use crate::comparison::ALPHA;
use crate::paper::Paper;
use crate::paper::published::{Published, mean_of};
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "the printed means rank the stacks as ours do" };

/// Which metric of which table.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The metric.
    pub metric: String,
    /// Id of the table; its stacks with a printed mean count.
    pub table: String,
}

impl Kind for Params {
    fn check(&self, paper: &Paper) -> Result<(), String> {
        check_metric(&self.metric)?;
        paper.known(&self.table)
    }

    fn uses(&self) -> Vec<Use<'_>> {
        vec![Use { table: &self.table, stack: None }]
    }

    fn judge(&self, data: &Data<'_>) -> Verdict {
        let judged = || {
            let both = data.section(&self.table)?.stacks.iter().filter_map(|stack| {
                let place = Place { table: self.table.clone(), stack: stack.name.clone() };
                let printed = data.printed(&place, &self.metric).and_then(Published::number)?;
                Some((printed, mean_of(stack, &self.metric)?.value))
            });
            let (printed, ours): (Vec<f64>, Vec<f64>) = both.unzip();
            let found = spearman(&printed, &ours).ok_or_else(|| missing("too few stacks, or all are equal"))?;
            let ruling = match found.p <= ALPHA {
                true if found.coefficient > 0.0 => Ruling::Holds,
                true => Ruling::Fails,
                false => Ruling::Undecided,
            };
            let why =
                format!("rank correlation {:.2} of {} stacks, {}", found.coefficient, ours.len(), p_text(found.p));
            Ok(verdict(ruling, why).with_p(found.p))
        };
        judged().unwrap_or_else(|verdict: Verdict| verdict)
    }
}
