//! What makes a run worse than its baseline: which metrics count, and by how much they may move.
//!
//! A test on thousands of worlds finds differences that nobody cares about. A margin says which ones count: a change is a
//! regression only if it is significant *and* its mean is larger than the margin.

use super::COMPARED;
use crate::settings::choice::NameError;

/// How much a metric may get worse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Margin {
    /// In the unit of the metric; of success in percentage points.
    Amount(f64),
    /// As a share of the mean of the baseline.
    Share(f64),
}

/// What makes a run worse than its baseline. Without settings: any significant change for the worse of any metric.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gate {
    metrics: Vec<String>,
    margins: Vec<(String, Margin)>,
}

/// Reason why a gate cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GateError {
    /// A metric that is not compared.
    #[error(transparent)]
    Metric(#[from] NameError),
    /// A margin that is no number.
    #[error("the margin `{0}` is not of the form METRIC=VALUE or METRIC=VALUE%, with a value of at least 0")]
    Margin(String),
}

impl Gate {
    /// A gate on these metrics (all if there are none) with margins as `METRIC=VALUE` or `METRIC=VALUE%`.
    ///
    /// # Errors
    /// If a metric is not one that is compared, or a margin cannot be read.
    pub fn new(metrics: &[String], margins: &[String]) -> Result<Self, GateError> {
        let known = |name: &str| {
            let names: Vec<&str> = ["success"].into_iter().chain(COMPARED).collect();
            if names.contains(&name) { Ok(name.to_owned()) } else { Err(NameError::unknown("metric", name, &names)) }
        };
        let metrics = metrics.iter().map(|name| known(name)).collect::<Result<Vec<_>, _>>()?;
        let margins = margins.iter().map(|text| {
            let refuse = || GateError::Margin(text.clone());
            let (name, value) = text.split_once('=').ok_or_else(refuse)?;
            let (number, is_share) = value.strip_suffix('%').map_or((value, false), |number| (number, true));
            let number: f64 = number.trim().parse().map_err(|_| refuse())?;
            if !(number.is_finite() && number >= 0.0) {
                return Err(refuse());
            }
            // Success is in percentage points already.
            let margin =
                if is_share && name != "success" { Margin::Share(0.01 * number) } else { Margin::Amount(number) };
            Ok((known(name)?, margin))
        });
        Ok(Self { metrics, margins: margins.collect::<Result<_, GateError>>()? })
    }

    /// Whether a metric counts.
    pub(super) fn counts(&self, metric: &str) -> bool {
        self.metrics.is_empty() || self.metrics.iter().any(|name| name == metric)
    }

    /// How much a metric may get worse whose mean in the baseline is `mean`.
    pub(super) fn margin(&self, metric: &str, mean: Option<f64>) -> f64 {
        match self.margins.iter().find(|(name, _)| name == metric) {
            None => 0.0,
            Some((_, Margin::Amount(amount))) => *amount,
            Some((_, Margin::Share(share))) => share * mean.unwrap_or(0.0).abs(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(texts: &[&str]) -> Vec<String> {
        texts.iter().map(|text| (*text).to_owned()).collect()
    }

    #[test]
    fn margins_are_amounts_or_shares_of_the_baselines_mean() {
        let gate = Gate::new(&[], &texts(&["time_s=5%", "length_m=0.2", "success=2%"])).unwrap();
        assert_eq!((gate.margin("time_s", Some(60.0)), gate.margin("length_m", Some(9.0))), (3.0, 0.2));
        assert_eq!((gate.margin("success", Some(98.0)), gate.margin("clearance_min_m", Some(1.0))), (2.0, 0.0));
        assert!(gate.counts("clearance_min_m"));
        let only = Gate::new(&texts(&["success", "time_s"]), &[]).unwrap();
        assert!(only.counts("success") && only.counts("time_s") && !only.counts("length_m"));
    }

    #[test]
    fn what_cannot_be_read_is_refused_with_what_was_meant() {
        let refused =
            |metrics: &[&str], margins: &[&str]| Gate::new(&texts(metrics), &texts(margins)).unwrap_err().to_string();
        assert!(refused(&["time"], &[]).contains("time_s"));
        assert!(refused(&[], &["tme_s=3"]).contains("time_s"));
        for text in ["time_s", "time_s=fast", "time_s=-1", "time_s=inf"] {
            assert!(refused(&[], &[text]).contains("METRIC=VALUE"), "{text}");
        }
    }
}
