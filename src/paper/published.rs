//! The published numbers, and what our runs say in their place.

use super::evidence::Evidence;
use crate::analysis::{Location, Z_95, bootstrap_interval, wilson};
use crate::comparison::StackRows;
use crate::episode::Outcome;
use crate::results::{Row, metric_columns};
use serde::Deserialize;
use std::path::Path;

/// One number that a paper printed.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Published {
    /// Where it stands in the paper.
    #[serde(rename = "where")]
    pub place: String,
    /// The table of the manifest that it belongs to.
    pub table: String,
    /// The stack.
    pub stack: String,
    /// The stack that it is compared with, for differences; else empty.
    pub against: String,
    /// A column of `episodes.csv`, or `success`.
    pub metric: String,
    /// What of it: `mean`, `gain`, `reduction`, `reduction_percent` or `rank`.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// As it is printed; may be a bound (`>=0.5`) or a range.
    pub value: String,
    /// Number of trials behind it, where the paper says so.
    pub trials: Option<u64>,
    /// What is odd about it.
    pub note: String,
}

impl Published {
    /// Reads the CSV of a paper.
    pub(super) fn read(path: &Path) -> Result<Vec<Self>, String> {
        let shown = path.display();
        let mut reader = csv::Reader::from_path(path).map_err(|error| format!("cannot read `{shown}`: {error}"))?;
        reader.deserialize().collect::<Result<Vec<Self>, _>>().map_err(|error| format!("{shown}: {error}"))
    }

    /// The printed value, where it is one number.
    pub fn number(&self) -> Option<f64> {
        self.value.parse().ok()
    }

    /// Successes and trials behind a published rate: the whole number of trials nearest to it.
    pub fn counts(&self) -> Option<(u64, u64)> {
        let (rate, trials) = (self.number()?, self.trials?);
        (self.metric == "success" && self.quantity == "mean")
            .then(|| ((rate * trials as f64 / 100.0).round() as u64, trials))
    }
}

/// One of our numbers, with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The number.
    pub value: f64,
    /// Its interval, where there is one.
    pub interval: Option<(f64, f64)>,
    /// Rows, or pairs of rows, behind it.
    pub n: u64,
}

/// The value of `metric` in a row: `success` in percent, or a measured column; `None` where it is undefined.
pub(super) fn value(row: &Row, metric: &str) -> Option<f64> {
    if metric == "success" {
        return (!matches!(row.outcome, Outcome::InfeasibleWorld { .. }))
            .then(|| if row.outcome == Outcome::Success { 100.0 } else { 0.0 });
    }
    metric_columns().find(|column| column.name == metric)?.number(&row.metrics)
}

/// Whether a metric is known before the drive, so that failures have it as well.
pub(super) fn is_of_plan(metric: &str) -> bool {
    matches!(
        metric,
        "planned_length_m" | "planned_turns" | "expanded" | "generated" | "path_nodes" | "risky_nodes" | "success"
    )
}

/// The values of a stack that its mean is taken of: over the successes, or over all rows where failures have it as well.
pub(super) fn values(stack: &StackRows, metric: &str) -> Vec<f64> {
    let counts = |row: &&Row| is_of_plan(metric) || row.outcome == Outcome::Success;
    stack.rows.values().filter(counts).filter_map(|row| value(row, metric)).collect()
}

/// What our runs say in the place of a published number; `None` where they say nothing.
pub fn measured(number: &Published, evidence: &Evidence) -> Option<Measured> {
    let stack = evidence.stack(&number.table, &number.stack)?;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    match number.quantity.as_str() {
        "mean" => mean_of(stack, &number.metric),
        "rank" => {
            let section = evidence.section(&number.table)?;
            let rate = stack.success_rate();
            let better = section.stacks.iter().filter(|other| other.success_rate() > rate).count();
            Some(Measured { value: 1.0 + better as f64, interval: None, n: section.stacks.len() as u64 })
        }
        quantity => {
            let against = evidence.stack(&number.table, &number.against)?;
            let plan = is_of_plan(&number.metric);
            let both = stack
                .shared(against)
                .filter(|(a, b)| plan || (a.outcome == Outcome::Success && b.outcome == Outcome::Success));
            let pairs: Vec<(f64, f64)> =
                both.filter_map(|(a, b)| Some((value(a, &number.metric)?, value(b, &number.metric)?))).collect();
            if pairs.is_empty() {
                return None;
            }
            let sign = if quantity == "gain" { 1.0 } else { -1.0 };
            let scale = if quantity == "reduction_percent" {
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
    let interval = if metric == "success" {
        wilson(stack.successes(), n, Z_95).map(|(low, high)| (100.0 * low, 100.0 * high))
    } else {
        bootstrap_interval(&values, Location::Mean, 0.95)
    };
    Some(Measured { value: values.iter().sum::<f64>() / n as f64, interval, n })
}
