//! Two stacks are as good as each other: their mean difference is smaller than a stated margin.
//!
//! Holds if the 90 % interval of the mean difference lies within ± margin (two one-sided tests at 5 %, Schuirmann 1987); fails if it lies
//! wholly outside; undecided otherwise.

use super::compare::pairs;
use super::{Data, Entry, Kind, Over, Place, Ruling, Use, Verdict, check_metric, missing, verdict, worlds};
use crate::analysis::{PairedOutcomes, equivalence_of_means, equivalence_of_rates};
use crate::comparison::ALPHA;
use crate::paper::Paper;
use crate::paper::published::SUCCESS;
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "two stacks differ by less than a margin" };

/// Which stacks, by which metric, within which margin.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The metric.
    pub metric: String,
    /// The first stack.
    pub of: Place,
    /// The second stack; of another table, the worlds must be the same.
    pub than: Place,
    /// The margin, in the unit of the metric (of `success` in percentage points), above 0.
    pub margin: f64,
}

impl Kind for Params {
    fn check(&self, paper: &Paper) -> Result<(), String> {
        check_metric(&self.metric)?;
        paper.known(&self.of.table)?;
        paper.known(&self.than.table)?;
        if self.margin > 0.0 && self.margin.is_finite() { Ok(()) } else { Err("`margin` is above 0".to_owned()) }
    }

    fn uses(&self) -> Vec<Use<'_>> {
        vec![self.of.used(), self.than.used()]
    }

    fn judge(&self, data: &Data<'_>) -> Verdict {
        let judged = || {
            let pairs = pairs(data.stack(&self.of)?, data.stack(&self.than)?, &self.metric, Over::BothSolved);
            let differences: Vec<f64> = pairs.iter().map(|(a, b)| a - b).collect();
            let found = if self.metric == SUCCESS {
                let won =
                    |pick: fn(&(f64, f64)) -> f64| pairs.iter().map(|pair| pick(pair) > 0.0).collect::<Vec<bool>>();
                let outcomes = PairedOutcomes::count(&won(|pair| pair.0), &won(|pair| pair.1));
                let found = equivalence_of_rates(outcomes, 0.01 * self.margin, ALPHA);
                found.map(|found| (found.p, (100.0 * found.interval.0, 100.0 * found.interval.1)))
            } else {
                equivalence_of_means(&differences, self.margin, ALPHA).map(|found| (found.p, found.interval))
            };
            let (p, (low, high)) = found.ok_or_else(|| missing("too few worlds count for both"))?;
            let ruling = if p <= ALPHA {
                Ruling::Holds
            } else if low > self.margin || high < -self.margin {
                Ruling::Fails
            } else {
                Ruling::Undecided
            };
            let mean = differences.iter().sum::<f64>() / differences.len() as f64;
            let why = format!(
                "difference {mean:+.2}, 90 % [{low:+.2}, {high:+.2}], in {}, margin {}",
                worlds(pairs.len()),
                self.margin
            );
            Ok(verdict(ruling, why).with_p(p))
        };
        judged().unwrap_or_else(|verdict| verdict)
    }
}
