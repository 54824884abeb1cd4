//! The tests of two stacks.

use super::{ALPHA, StackRows, compared};
use crate::analysis::{
    ErrorRates, Location, PairedOutcomes, RankSum, Ratio, bootstrap_interval, bootstrap_ratio, discordant_odds_ratio,
    fisher_exact, hodges_lehmann, hodges_lehmann_interval, hodges_lehmann_shift, hodges_lehmann_shift_interval, holm,
    informative_pairs_min, mcnemar_exact, minimal_detectable_mean, minimal_detectable_risk_difference,
    paired_differences, pairs_needed_mean, pairs_needed_risk_difference, rank_biserial, rank_sum, signed_rank,
};
use crate::results::Column;

/// What is compared beside the metrics: how often a stack succeeds.
pub(super) const SUCCESS: &str = "success";

/// One test of two stacks.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The stack compared with.
    pub reference: String,
    /// The stack that is compared.
    pub stack: String,
    /// `success` or the column of a metric.
    pub metric: &'static str,
    /// The test.
    pub test: &'static str,
    /// Number of worlds that the test uses.
    pub n: u64,
    /// Number of informative worlds among them: those in which exactly one stack succeeded, or the metric differs.
    pub informative: u64,
    /// Mean of the reference on the worlds that the test uses; of success in per cent.
    pub reference_mean: Option<f64>,
    /// Mean of stack − reference; of success in percentage points.
    pub difference: Option<f64>,
    /// Its 95 % bootstrap interval; `None` without pairs.
    pub interval: Option<(f64, f64)>,
    /// Hodges–Lehmann estimate of stack − reference, which belongs to the rank test; `None` for success.
    pub shift: Option<f64>,
    /// Its 95 % interval; `None` for success and with too few worlds.
    pub shift_interval: Option<(f64, f64)>,
    /// Mean of the stack divided by that of the reference, with its 95 % bootstrap interval; `None` for success, without pairs and
    /// where the mean of the reference is near 0.
    pub ratio: Option<Ratio>,
    /// Standard deviation of the differences; of success the share of worlds that exactly one solved (0 to 1). `None` without pairs.
    pub spread: Option<f64>,
    /// Two-sided p-value.
    pub p: f64,
    /// The p-value after Holm's correction over the family of the section.
    pub p_holm: f64,
    /// Effect size: discordant odds ratio of stack to reference for success (infinite where only the stack won alone),
    /// matched-pairs rank-biserial correlation for a metric.
    pub effect: Option<f64>,
    /// Whether too few worlds are informative for any result to be significant.
    pub too_few: bool,
}

impl Comparison {
    /// The smallest difference that so many worlds with such a spread show with a power of 80 % in a test at level `alpha`; of success in
    /// percentage points. `None` if there is none, or without pairs.
    pub fn detectable(&self, alpha: f64) -> Option<f64> {
        let (n, spread, rates) = (self.n as usize, self.spread?, ErrorRates { alpha, ..ErrorRates::default() });
        if self.metric == SUCCESS {
            minimal_detectable_risk_difference(n, spread, rates).map(|rate| 100.0 * rate)
        } else {
            minimal_detectable_mean(n, spread, rates)
        }
    }

    /// The number of worlds that would show the mean difference found here with a power of 80 % in one test at 5 %. `None` if the
    /// difference is 0, or without pairs.
    pub fn pairs_needed(&self) -> Option<u64> {
        let (difference, spread, rates) = (self.difference?, self.spread?, ErrorRates::default());
        if self.metric == SUCCESS {
            pairs_needed_risk_difference(difference / 100.0, spread, rates)
        } else {
            pairs_needed_mean(difference, spread, rates)
        }
    }
}

/// Corrects the p-values of one family, and marks the tests that could not become significant.
pub(super) fn correct(comparisons: &mut [Comparison]) {
    if comparisons.is_empty() {
        return;
    }
    let least = u64::from(informative_pairs_min(ALPHA, comparisons.len()));
    let adjusted = holm(&comparisons.iter().map(|comparison| comparison.p).collect::<Vec<_>>());
    for (comparison, p_holm) in comparisons.iter_mut().zip(adjusted) {
        comparison.p_holm = p_holm;
        comparison.too_few = comparison.informative < least;
    }
}

/// Paired outcomes of two stacks on the worlds that both drove.
pub(super) fn outcomes(first: &StackRows, second: &StackRows) -> PairedOutcomes {
    let (a, b): (Vec<bool>, Vec<bool>) =
        first.shared(second).map(|(a, b)| (a.outcome.is_success(), b.outcome.is_success())).unzip();
    PairedOutcomes::count(&a, &b)
}

/// A metric of the stack and of the reference on the worlds that both solved.
pub(super) fn solved_by_both(reference: &StackRows, stack: &StackRows, metric: &Column) -> (Vec<f64>, Vec<f64>) {
    let both = stack.shared(reference).filter(|(a, b)| a.outcome.is_success() && b.outcome.is_success());
    both.filter_map(|(a, b)| Some((metric.number(&a.metrics)?, metric.number(&b.metrics)?))).unzip()
}

/// The tests of one pair of stacks on the worlds that both drove.
pub fn compare_pairs(reference: &StackRows, stack: &StackRows) -> Vec<Comparison> {
    let table = outcomes(stack, reference);
    let points: Vec<f64> = stack
        .shared(reference)
        .map(|(a, b)| {
            100.0 * (f64::from(u8::from(a.outcome.is_success())) - f64::from(u8::from(b.outcome.is_success())))
        })
        .collect();
    let blank = Comparison {
        reference: reference.name.clone(),
        stack: stack.name.clone(),
        metric: SUCCESS,
        test: "McNemar, exact",
        n: table.pairs(),
        informative: table.discordant(),
        reference_mean: (table.pairs() > 0)
            .then(|| 100.0 * (table.both + table.second_only) as f64 / table.pairs() as f64),
        difference: mean(&points),
        interval: bootstrap_interval(&points, Location::Mean, 0.95),
        shift: None,
        shift_interval: None,
        ratio: None,
        spread: (table.pairs() > 0).then(|| table.discordant() as f64 / table.pairs() as f64),
        p: mcnemar_exact(table),
        p_holm: 1.0,
        effect: match (table.first_only, table.second_only) {
            (0, 0) => None,
            (_, 0) => Some(f64::INFINITY),
            _ => discordant_odds_ratio(table),
        },
        too_few: false,
    };
    let metrics = compared().into_iter().map(|metric| {
        let (ours, theirs) = solved_by_both(reference, stack, metric);
        let differences = paired_differences(&ours, &theirs);
        let test = signed_rank(&differences);
        Comparison {
            metric: metric.name,
            test: "Wilcoxon, signed rank",
            n: differences.len() as u64,
            informative: test.ranked as u64,
            reference_mean: mean(&theirs),
            difference: mean(&differences),
            interval: bootstrap_interval(&differences, Location::Mean, 0.95),
            shift: hodges_lehmann(&differences),
            shift_interval: hodges_lehmann_interval(&differences, 0.95),
            ratio: bootstrap_ratio(&ours, &theirs, 0.95),
            spread: standard_deviation(&differences),
            p: test.p,
            effect: rank_biserial(&test),
            ..blank.clone()
        }
    });
    let metrics: Vec<Comparison> = metrics.collect();
    [vec![blank], metrics].concat()
}

/// The tests of two stacks as if their worlds were independent.
pub(super) fn compare_unpaired(reference: &StackRows, stack: &StackRows) -> Vec<Comparison> {
    let count = |stack: &StackRows| {
        let feasible = stack.rows.values().filter(|row| row.outcome.is_rated());
        let n = feasible.count() as u64;
        (stack.successes(), n - stack.successes())
    };
    let ((a, b), (c, d)) = (count(stack), count(reference));
    let rate = |yes: u64, no: u64| (yes + no > 0).then(|| 100.0 * yes as f64 / (yes + no) as f64);
    let success = Comparison {
        reference: reference.name.clone(),
        stack: stack.name.clone(),
        metric: SUCCESS,
        test: "Fisher, exact",
        n: a + b + c + d,
        informative: a + b + c + d,
        reference_mean: rate(c, d),
        difference: rate(a, b).zip(rate(c, d)).map(|(ours, theirs)| ours - theirs),
        interval: None,
        shift: None,
        shift_interval: None,
        ratio: None,
        spread: None,
        p: fisher_exact([[a, b], [c, d]]),
        p_holm: 1.0,
        effect: (b * c > 0).then(|| (a * d) as f64 / (b * c) as f64),
        too_few: false,
    };
    let values = |stack: &StackRows, metric: &Column| -> Vec<f64> {
        let solved = stack.rows.values().filter(|row| row.outcome.is_success());
        solved.filter_map(|row| metric.number(&row.metrics)).collect()
    };
    let metrics = compared().into_iter().map(|metric| {
        let (ours, theirs) = (values(stack, metric), values(reference, metric));
        let RankSum { first, second, p, .. } = rank_sum(&ours, &theirs);
        let n = (ours.len() + theirs.len()) as u64;
        Comparison {
            metric: metric.name,
            test: "rank sum",
            n,
            informative: n,
            reference_mean: mean(&theirs),
            difference: mean(&ours).zip(mean(&theirs)).map(|(ours, theirs)| ours - theirs),
            shift: hodges_lehmann_shift(&ours, &theirs),
            shift_interval: hodges_lehmann_shift_interval(&ours, &theirs, 0.95),
            p,
            effect: (first + second > 0.0).then(|| (first - second) / (first + second)),
            ..success.clone()
        }
    });
    let metrics: Vec<Comparison> = metrics.collect();
    [vec![success.clone()], metrics].concat()
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn standard_deviation(values: &[f64]) -> Option<f64> {
    let mean = mean(values).filter(|_| values.len() > 1)?;
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    Some((squares / (values.len() - 1) as f64).sqrt())
}
