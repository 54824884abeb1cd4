//! A metric lies within bounds.
//!
//! `every`: in every row (of the paper: in every printed number). `mean`: the 95 % interval of the mean over the successes
//! (of `success`: the Wilson interval of the rate) lies within the bounds and Student's test against the nearer bound (of `success` the
//! score test) agrees; fails if the same shows that it lies outside; undecided otherwise.

use super::{
    Data, Entry, Kind, Ruling, Source, Use, Verdict, check_metric, confirmed, missing, p_of_mean, p_of_rate, together,
    verdict, within,
};
use crate::paper::Paper;
use crate::paper::published::{Published, Quantity, SUCCESS, mean_of, value, values};
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "a metric lies within bounds" };

/// Which metric, which bounds.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The metric.
    pub metric: String,
    /// Id of the table.
    pub table: String,
    /// The stack; default every stack of the table.
    #[serde(default)]
    pub stack: Option<String>,
    /// Lower bound, itself within; default none.
    #[serde(default)]
    pub at_least: Option<f64>,
    /// Upper bound, itself within; default none.
    #[serde(default)]
    pub at_most: Option<f64>,
    /// Of what; default `mean`.
    #[serde(default)]
    pub of: Statistic,
    /// Whose numbers; default `measured`.
    #[serde(default)]
    pub source: Source,
}

/// What must lie within the bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Statistic {
    /// The mean over the successes, or the rate.
    #[default]
    Mean,
    /// Every single value.
    Every,
}

impl Kind for Params {
    fn check(&self, paper: &Paper) -> Result<(), String> {
        check_metric(&self.metric)?;
        paper.known(&self.table)?;
        if self.at_least.is_none() && self.at_most.is_none() {
            return Err("a range needs `at_least`, `at_most` or both".to_owned());
        }
        if self.metric == SUCCESS && self.of == Statistic::Every && self.source == Source::Measured {
            return Err("a row's `success` is 0 or 100: ask for the mean".to_owned());
        }
        Ok(())
    }

    fn uses(&self) -> Vec<Use<'_>> {
        match self.source {
            Source::Measured => vec![Use { table: &self.table, stack: self.stack.as_deref() }],
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
    fn bounds(&self) -> (f64, f64) {
        (self.at_least.unwrap_or(f64::NEG_INFINITY), self.at_most.unwrap_or(f64::INFINITY))
    }

    fn looks_at(&self, stack: &str) -> bool {
        self.stack.as_ref().is_none_or(|name| name == stack)
    }

    fn measured(&self, data: &Data<'_>) -> Result<Verdict, Verdict> {
        let (low, high) = self.bounds();
        let stacks = data.section(&self.table)?.stacks.iter().filter(|stack| self.looks_at(&stack.name));
        if self.of == Statistic::Every {
            let values: Vec<f64> =
                stacks.flat_map(|stack| stack.rows.values()).filter_map(|row| value(row, &self.metric)).collect();
            let outside = values.iter().filter(|value| **value < low || **value > high).count();
            let ruling = match (values.len(), outside) {
                (0, _) => Ruling::Undecided,
                (_, 0) => Ruling::Holds,
                _ => Ruling::Fails,
            };
            return Ok(verdict(ruling, format!("{outside} of {} values lie outside", values.len())));
        }
        let parts = stacks.filter_map(|stack| {
            let mean = mean_of(stack, &self.metric)?;
            let interval = mean.interval.unwrap_or((mean.value, mean.value));
            let why = format!("{}: {:.3} [{:.3}, {:.3}]", stack.name, mean.value, interval.0, interval.1);
            // Against the bound that is nearer: the one that decides.
            let bound = if (mean.value - low).abs() <= (mean.value - high).abs() { low } else { high };
            let p = if self.metric == SUCCESS {
                p_of_rate(mean.value, bound, mean.n)
            } else {
                p_of_mean(&values(stack, &self.metric), bound)
            };
            Some(verdict(confirmed(within(interval, low, high), p), why).with_p(p))
        });
        Ok(together(parts.collect()))
    }

    fn published(&self, data: &Data<'_>) -> Verdict {
        let (low, high) = self.bounds();
        let numbers: Vec<f64> = data
            .published
            .iter()
            .filter(|number| number.table == self.table && self.looks_at(&number.stack) && number.metric == self.metric)
            .filter(|number| number.quantity == Quantity::Mean)
            .filter_map(Published::number)
            .collect();
        let outside: Vec<String> =
            numbers.iter().filter(|number| **number < low || **number > high).map(f64::to_string).collect();
        match (numbers.len(), outside.as_slice()) {
            (0, _) => missing("not printed"),
            (_, []) => verdict(Ruling::Holds, "every printed number lies within"),
            (n, _) => verdict(
                Ruling::Fails,
                format!("{} of {n} printed numbers do not: {}", outside.len(), outside.join(", ")),
            ),
        }
    }
}
