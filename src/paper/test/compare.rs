//! One stack against another.
//!
//! Measured: on the same worlds. `less` and `more` of a metric hold if the 95 % interval of the mean difference `of − factor · than`
//! lies wholly on that side of 0 and the signed-rank test agrees (p ≤ 0.05); of `success`, if McNemar's exact test tells the two
//! apart. They fail if the same shows on the other side, a metric also where no world differs at all, and are undecided otherwise.
//! `equal` holds if no world differs by more than the tolerance. Published: the printed numbers as they are.

use super::{
    Data, Entry, Kind, Over, Place, Relation, Ruling, Source, Use, Verdict, check_metric, missing, p_text, verdict,
    worlds,
};
use crate::analysis::{Location, PairedOutcomes, bootstrap_interval, mcnemar_exact, paired_differences, signed_rank};
use crate::comparison::{ALPHA, StackRows};
use crate::math;
use crate::paper::Paper;
use crate::paper::published::{Published, SUCCESS, counts_failures, value};
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "one stack against another" };

/// Which stacks, by which metric.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The metric.
    pub metric: String,
    /// The first stack.
    pub of: Place,
    /// How it should stand to the second.
    pub is: Relation,
    /// The second stack; of another table, the worlds must be the same.
    pub than: Place,
    /// The second number is multiplied by this; default 1.
    #[serde(default = "one")]
    pub factor: f64,
    /// Difference up to which two numbers are equal; default 0.
    #[serde(default)]
    pub tolerance: f64,
    /// The worlds it looks at; default `both_solved`.
    #[serde(default)]
    pub over: Over,
    /// Whose numbers; default `measured`.
    #[serde(default)]
    pub source: Source,
}

fn one() -> f64 {
    1.0
}

impl Kind for Params {
    fn check(&self, paper: &Paper) -> Result<(), String> {
        check_metric(&self.metric)?;
        paper.known(&self.of.table)?;
        paper.known(&self.than.table)?;
        if !(self.factor.is_finite() && self.tolerance >= 0.0 && self.tolerance.is_finite()) {
            return Err("`factor` and `tolerance` are finite, `tolerance` at least 0".to_owned());
        }
        Ok(())
    }

    fn uses(&self) -> Vec<Use<'_>> {
        match self.source {
            Source::Measured => vec![self.of.used(), self.than.used()],
            Source::Published => Vec::new(),
        }
    }

    fn judge(&self, data: &Data<'_>) -> Verdict {
        match self.source {
            Source::Measured => self.measured(data).unwrap_or_else(|verdict| verdict),
            Source::Published => self.published(data),
        }
    }
}

impl Params {
    fn measured(&self, data: &Data<'_>) -> Result<Verdict, Verdict> {
        let pairs = pairs(data.stack(&self.of)?, data.stack(&self.than)?, &self.metric, self.over);
        let pairs: Vec<(f64, f64)> = pairs.into_iter().map(|(a, b)| (a, self.factor * b)).collect();
        if self.is == Relation::Equal {
            let largest = pairs.iter().map(|(a, b)| (a - b).abs()).fold(0.0, math::max);
            let ruling = if pairs.is_empty() {
                return Err(missing("no world counts for both"));
            } else if largest <= self.tolerance {
                Ruling::Holds
            } else {
                Ruling::Fails
            };
            return Ok(verdict(ruling, format!("largest difference {largest:.3} in {}", worlds(pairs.len()))));
        }
        let found = Difference::of(&pairs, self.metric == SUCCESS && self.factor == 1.0)?;
        let factor = if self.factor == 1.0 { String::new() } else { format!(" ({} times)", self.factor) };
        let why = format!("{:.2} against {:.2}{factor}, {}", found.first, found.second, found.text());
        let verdict = verdict(found.ruling(self.is), why);
        // Numbers that are the same in every world are no estimate.
        Ok(if found.is_same_everywhere() { verdict } else { verdict.with_p(found.p) })
    }

    fn published(&self, data: &Data<'_>) -> Verdict {
        let number = |place: &Place| data.printed(place, &self.metric).and_then(Published::number);
        let (Some(a), Some(b)) = (number(&self.of), number(&self.than)) else {
            return missing("not printed");
        };
        let b = b * self.factor;
        let holds = match self.is {
            Relation::Less => a < b,
            Relation::More => a > b,
            Relation::Equal => (a - b).abs() <= self.tolerance,
        };
        verdict(if holds { Ruling::Holds } else { Ruling::Fails }, format!("printed: {a} against {b}"))
    }
}

/// The numbers of two stacks on the worlds that count.
pub(super) fn pairs(of: &StackRows, than: &StackRows, metric: &str, over: Over) -> Vec<(f64, f64)> {
    let all = over == Over::All || counts_failures(metric);
    let both = of.shared(than).filter(|(a, b)| all || (a.outcome.is_success() && b.outcome.is_success()));
    both.filter_map(|(a, b)| Some((value(a, metric)?, value(b, metric)?))).collect()
}

/// The difference of two stacks on the same worlds.
pub(super) struct Difference {
    /// Mean of the first stack.
    pub(super) first: f64,
    /// Mean of the second stack.
    pub(super) second: f64,
    /// 95 % bootstrap interval of the mean difference.
    pub(super) interval: (f64, f64),
    /// McNemar's test of successes, the signed-rank test of anything else.
    pub(super) p: f64,
    is_success: bool,
    worlds: usize,
}

impl Difference {
    pub(super) fn of(pairs: &[(f64, f64)], is_success: bool) -> Result<Self, Verdict> {
        if pairs.is_empty() {
            return Err(missing("no world counts for both"));
        }
        let (first, second): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let differences: Vec<f64> = pairs.iter().map(|(a, b)| a - b).collect();
        let interval = bootstrap_interval(&differences, Location::Mean, 0.95).unwrap_or_default();
        // In few worlds the exact tests know more than a bootstrap: of one world its interval is a point.
        let p = if is_success {
            let won = |values: &[f64]| values.iter().map(|value| *value > 0.0).collect::<Vec<bool>>();
            mcnemar_exact(PairedOutcomes::count(&won(&first), &won(&second)))
        } else {
            signed_rank(&paired_differences(&first, &second)).p
        };
        Ok(Self { first: mean(&first), second: mean(&second), interval, p, is_success, worlds: pairs.len() })
    }

    /// The ruling on "the first is less (more) than the second".
    pub(super) fn ruling(&self, is: Relation) -> Ruling {
        let (low, high) = self.interval;
        let is_clear = self.p <= ALPHA && (self.is_success || high < 0.0 || low > 0.0);
        let (is_less, is_more) = (is_clear && self.first < self.second, is_clear && self.first > self.second);
        match is {
            Relation::Less if is_less => Ruling::Holds,
            Relation::Less if is_more => Ruling::Fails,
            Relation::More if is_more => Ruling::Holds,
            Relation::More if is_less => Ruling::Fails,
            _ if self.is_same_everywhere() => Ruling::Fails,
            _ => Ruling::Undecided,
        }
    }

    /// Whether the numbers are the same in every world; successes that are the same may differ elsewhere.
    fn is_same_everywhere(&self) -> bool {
        !self.is_success && self.interval == (0.0, 0.0)
    }

    /// The difference in words.
    pub(super) fn text(&self) -> String {
        let (low, high) = self.interval;
        let difference = self.first - self.second;
        format!("difference {difference:+.2} [{low:+.2}, {high:+.2}] in {}, {}", worlds(self.worlds), p_text(self.p))
    }
}
