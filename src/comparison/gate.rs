//! What makes a run worse than its baseline: which metrics count, and by how much they may move.
//!
//! A test on thousands of worlds finds differences that nobody cares about. A margin says which ones count: a change is a
//! regression only if it is significant *and* its mean is larger than the margin. Even rounding can make a test significant: a
//! change of the last digits that points the same way in every world has p near 0. A metric without a margin of its own therefore has
//! a small one.

use super::pair::SUCCESS;
use super::{MarginError, Margins, compared_name};

/// The share of the baseline's mean by which a metric may get worse if nothing else is said; success has no such margin.
const SHARE: f64 = 0.001;

/// What makes a run worse than its baseline. Without settings: a significant change for the worse of any metric, by more than a thousandth of
/// its mean (success: by anything).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gate {
    metrics: Vec<&'static str>,
    margins: Margins,
}

impl Gate {
    /// A gate on these metrics (all if there are none) with margins as `METRIC=VALUE` or `METRIC=VALUE%`.
    ///
    /// # Errors
    /// If a metric is not one that is compared, or a margin cannot be read.
    pub fn new(metrics: &[String], margins: &[String]) -> Result<Self, MarginError> {
        let metrics = metrics.iter().map(|name| compared_name(name)).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { metrics, margins: Margins::read(margins)? })
    }

    /// Whether a metric counts.
    pub(super) fn counts(&self, metric: &str) -> bool {
        self.metrics.is_empty() || self.metrics.contains(&metric)
    }

    /// How much a metric may get worse whose mean in the baseline is `mean`.
    pub(super) fn margin(&self, metric: &str, mean: Option<f64>) -> f64 {
        let small = if metric == SUCCESS { 0.0 } else { SHARE * mean.unwrap_or(0.0).abs() };
        self.margins.of(metric, mean).unwrap_or(small)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gate_counts_all_metrics_or_those_that_it_names() {
        let own = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
        let gate = Gate::new(&[], &own(&["time_s=5%"])).unwrap();
        assert_eq!((gate.margin("time_s", Some(60.0)), gate.margin("length_m", Some(8.0))), (3.0, 0.008));
        assert_eq!((gate.margin("success", Some(95.0)), gate.margin("length_m", None)), (0.0, 0.0));
        assert_eq!(Gate::new(&[], &own(&["length_m=0"])).unwrap().margin("length_m", Some(9.0)), 0.0);
        assert!(gate.counts("clearance_min_m"));
        let only = Gate::new(&own(&["success", "time_s"]), &[]).unwrap();
        assert!(only.counts("success") && only.counts("time_s") && !only.counts("length_m"));
        assert!(Gate::new(&own(&["time"]), &[]).unwrap_err().to_string().contains("time_s"));
    }
}
