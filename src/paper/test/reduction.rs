//! By how many per cent one stack has less than another, on the worlds that both solved.
//!
//! The reduction is 100 · (1 − mean(of) / mean(than)). Holds if its 95 % interval (bootstrap of pairs) lies within the bounds and the
//! signed-rank test at the nearer bound agrees (p ≤ 0.05), fails if the same shows that it lies outside, undecided otherwise.

use super::compare::pairs;
use super::{
    Data, Entry, Kind, Over, Place, Use, Verdict, check_metric, confirmed, missing, p_text, verdict, within, worlds,
};
use crate::analysis::{bootstrap_ratio, paired_differences, signed_rank};
use crate::paper::Paper;
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "by how many per cent one stack has less than another" };

/// Which stacks, by which metric, by how much.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The metric.
    pub metric: String,
    /// The stack that should have less.
    pub of: Place,
    /// The stack that it is compared with.
    pub than: Place,
    /// Least reduction, per cent; default none.
    #[serde(default)]
    pub at_least: Option<f64>,
    /// Largest reduction, per cent; default none.
    #[serde(default)]
    pub at_most: Option<f64>,
}

impl Kind for Params {
    fn check(&self, paper: &Paper) -> Result<(), String> {
        check_metric(&self.metric)?;
        paper.known(&self.of.table)?;
        paper.known(&self.than.table)?;
        if self.at_least.is_none() && self.at_most.is_none() {
            return Err("a reduction needs `at_least`, `at_most` or both".to_owned());
        }
        Ok(())
    }

    fn uses(&self) -> Vec<Use<'_>> {
        vec![self.of.used(), self.than.used()]
    }

    fn judge(&self, data: &Data<'_>) -> Verdict {
        let judged = || {
            let pairs = pairs(data.stack(&self.of)?, data.stack(&self.than)?, &self.metric, Over::BothSolved);
            let (of, than): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
            let found = bootstrap_ratio(&of, &than, 0.95).ok_or_else(|| missing("no world counts for both"))?;
            let per_cent = |ratio: f64| 100.0 * (1.0 - ratio);
            let (value, interval) = (per_cent(found.ratio), (per_cent(found.interval.1), per_cent(found.interval.0)));
            let (at_least, at_most) =
                (self.at_least.unwrap_or(f64::NEG_INFINITY), self.at_most.unwrap_or(f64::INFINITY));
            // "Less by r per cent" is "less than 1 − r / 100 times as much": the signed-rank test of that at the nearer bound.
            let bound = if (value - at_least).abs() <= (value - at_most).abs() { at_least } else { at_most };
            let scaled: Vec<f64> = than.iter().map(|number| (1.0 - 0.01 * bound) * number).collect();
            let p = signed_rank(&paired_differences(&of, &scaled)).p;
            let why = format!(
                "reduction {value:.2} % [{:.2}, {:.2}] in {}, {}",
                interval.0,
                interval.1,
                worlds(pairs.len()),
                p_text(p)
            );
            Ok(verdict(confirmed(within(interval, at_least, at_most), p), why).with_p(p))
        };
        judged().unwrap_or_else(|verdict| verdict)
    }
}
