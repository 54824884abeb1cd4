//! One stack against another as independent samples, as papers do that drive other worlds with each: the rank-sum test.
//!
//! Holds if p ≤ 0.05 and the median of all differences (Hodges-Lehmann) points the way that is claimed, fails if it points the other
//! way, undecided otherwise. On the same worlds `compare` tells more.

use super::{Data, Entry, Kind, Place, Relation, Ruling, Use, Verdict, check_metric, missing, p_text, verdict};
use crate::analysis::{hodges_lehmann_shift, rank_sum};
use crate::comparison::ALPHA;
use crate::paper::Paper;
use crate::paper::published::values;
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "one stack against another as independent samples" };

/// Which stacks, by which metric.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The metric; of the successes, or of all rows if it is known before the drive.
    pub metric: String,
    /// The first stack.
    pub of: Place,
    /// How it should stand to the second: `less` or `more`.
    pub is: Relation,
    /// The second stack.
    pub than: Place,
    /// Its numbers are multiplied by this; default 1.
    #[serde(default = "one")]
    pub factor: f64,
}

fn one() -> f64 {
    1.0
}

impl Kind for Params {
    fn check(&self, paper: &Paper) -> Result<(), String> {
        check_metric(&self.metric)?;
        paper.known(&self.of.table)?;
        paper.known(&self.than.table)?;
        if !(self.factor > 0.0 && self.factor.is_finite()) {
            return Err("`factor` is above 0".to_owned());
        }
        if self.is == Relation::Equal { Err("`is` is `less` or `more`".to_owned()) } else { Ok(()) }
    }

    fn uses(&self) -> Vec<Use<'_>> {
        vec![self.of.used(), self.than.used()]
    }

    fn judge(&self, data: &Data<'_>) -> Verdict {
        let judged = || {
            let of = values(data.stack(&self.of)?, &self.metric);
            let mut than = values(data.stack(&self.than)?, &self.metric);
            than.iter_mut().for_each(|value| *value *= self.factor);
            let shift = hodges_lehmann_shift(&of, &than).ok_or_else(|| missing("no rows"))?;
            let p = rank_sum(&of, &than).p;
            let ruling = match self.is {
                _ if p > ALPHA || shift == 0.0 => Ruling::Undecided,
                Relation::Less if shift < 0.0 => Ruling::Holds,
                Relation::More if shift > 0.0 => Ruling::Holds,
                _ => Ruling::Fails,
            };
            let why = format!("median difference {shift:+.2} of {} and {} drives, {}", of.len(), than.len(), p_text(p));
            Ok(verdict(ruling, why).with_p(p))
        };
        judged().unwrap_or_else(|verdict: Verdict| verdict)
    }
}
