//! The published numbers, and the numbers of our runs in their place.

use super::evidence::Evidence;
use super::{BYTES_MAX, PaperError};
use crate::analysis::{Location, Z_95, bootstrap_interval, wilson};
use crate::comparison::StackRows;
use crate::files;
use crate::results::{Known, Row, metric_column};
use serde::Deserialize;
use std::path::Path;

/// The metric that is no measured column: success, in percent.
pub(super) const SUCCESS: &str = "success";

/// Kind of a published number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// The mean of the stack.
    Mean,
    /// Amount by which the stack has more than the one with which it is compared.
    Gain,
    /// Amount by which the stack has less than the one with which it is compared.
    Reduction,
    /// The reduction in percent of the other's mean.
    ReductionPercent,
    /// The place of the stack by success, 1 the best.
    Rank,
}

impl Quantity {
    /// The name in the CSV of published numbers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::Gain => "gain",
            Self::Reduction => "reduction",
            Self::ReductionPercent => "reduction_percent",
            Self::Rank => "rank",
        }
    }

    /// Whether the quantity compares the stack with another one.
    pub fn needs_another_stack(self) -> bool {
        matches!(self, Self::Gain | Self::Reduction | Self::ReductionPercent)
    }
}

/// One number that a paper printed.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Published {
    /// Its place in the paper.
    #[serde(rename = "where")]
    pub place: String,
    /// The table of the manifest to which it belongs.
    pub table: String,
    /// The stack.
    pub stack: String,
    /// The stack with which it is compared, for differences; else empty.
    pub against: String,
    /// A column of `episodes.csv`, or `success`.
    pub metric: String,
    /// Kind of the number.
    pub quantity: Quantity,
    /// Its unit.
    pub unit: String,
    /// The value as printed; may be a bound (`>=0.5`) or a range.
    pub value: String,
    /// Number of trials behind it, if the paper gives it.
    pub trials: Option<u64>,
    /// Remark on anything odd about it.
    pub note: String,
}

impl Published {
    /// Reads the CSV of a paper.
    pub(super) fn read(path: &Path) -> Result<Vec<Self>, PaperError> {
        let text = files::text(path, BYTES_MAX).map_err(|source| PaperError::Read { path: path.to_owned(), source })?;
        let rows = csv::Reader::from_reader(text.as_bytes()).deserialize().collect::<Result<Vec<Self>, csv::Error>>();
        rows.map_err(|error| PaperError::File { path: path.to_owned(), message: error.to_string() })
    }

    /// The printed value, if it is a single number.
    pub fn number(&self) -> Option<f64> {
        self.value.parse().ok()
    }

    /// Successes and trials behind a published rate: the whole number of trials nearest to it.
    pub fn counts(&self) -> Option<(u64, u64)> {
        let (rate, trials) = (self.number()?, self.trials?);
        (self.metric == "success" && self.quantity == Quantity::Mean)
            .then(|| ((rate * trials as f64 / 100.0).round() as u64, trials))
    }
}

/// One of our numbers, with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The number.
    pub value: f64,
    /// Its interval, if it has one.
    pub interval: Option<(f64, f64)>,
    /// Number of rows, or pairs of rows, behind it.
    pub n: u64,
}

/// The value of `metric` in a row: `success` in percent, or a measured column; `None` if it is undefined.
pub(super) fn value(row: &Row, metric: &str) -> Option<f64> {
    if metric == SUCCESS {
        return row.outcome.is_rated().then(|| if row.outcome.is_success() { 100.0 } else { 0.0 });
    }
    metric_column(metric).ok()?.number(&row.metrics)
}

/// Whether failures have the metric as successes do: metrics known before the drive, and success itself.
pub(super) fn counts_failures(metric: &str) -> bool {
    metric == SUCCESS || metric_column(metric).is_ok_and(|column| column.known == Known::Before)
}

/// The values of which the mean of a stack is taken: over the successes, or over all rows if failures have the metric as well.
pub(super) fn values(stack: &StackRows, metric: &str) -> Vec<f64> {
    let counts = |row: &&Row| counts_failures(metric) || row.outcome.is_success();
    stack.rows.values().filter(counts).filter_map(|row| value(row, metric)).collect()
}

/// The number of our runs in place of a published one; `None` if they give none.
pub fn measured(number: &Published, evidence: &Evidence) -> Option<Measured> {
    let stack = evidence.stack(&number.table, &number.stack)?;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    match number.quantity {
        Quantity::Mean => mean_of(stack, &number.metric),
        Quantity::Rank => {
            let section = evidence.section(&number.table)?;
            let rate = stack.success_rate();
            let better = section.stacks.iter().filter(|other| other.success_rate() > rate).count();
            Some(Measured { value: 1.0 + better as f64, interval: None, n: section.stacks.len() as u64 })
        }
        quantity => {
            let against = evidence.stack(&number.table, &number.against)?;
            let all = counts_failures(&number.metric);
            let both = stack.shared(against).filter(|(a, b)| all || (a.outcome.is_success() && b.outcome.is_success()));
            let pairs: Vec<(f64, f64)> =
                both.filter_map(|(a, b)| Some((value(a, &number.metric)?, value(b, &number.metric)?))).collect();
            if pairs.is_empty() {
                return None;
            }
            let sign = if quantity == Quantity::Gain { 1.0 } else { -1.0 };
            let scale = if quantity == Quantity::ReductionPercent {
                100.0 / mean(&pairs.iter().map(|pair| pair.1).collect::<Vec<_>>())
            } else {
                1.0
            };
            let differences: Vec<f64> = pairs.iter().map(|(a, b)| sign * scale * (a - b)).collect();
            let interval = bootstrap_interval(&differences, Location::Mean, 0.95);
            Some(Measured { value: mean(&differences), interval, n: pairs.len() as u64 })
        }
    }
}

/// Mean of a metric of a stack with its 95 % interval: Wilson's for success, a bootstrap interval for the rest.
pub(super) fn mean_of(stack: &StackRows, metric: &str) -> Option<Measured> {
    let values = values(stack, metric);
    let n = values.len() as u64;
    if n == 0 {
        return None;
    }
    let interval = if metric == SUCCESS {
        wilson(stack.successes(), n, Z_95).map(|(low, high)| (100.0 * low, 100.0 * high))
    } else {
        bootstrap_interval(&values, Location::Mean, 0.95)
    };
    Some(Measured { value: values.iter().sum::<f64>() / n as f64, interval, n })
}
