//! Tests of equivalence of two stacks up to a stated margin.

use super::pair::{SUCCESS, outcomes, solved_by_both};
use super::{ALPHA, COMPARED, Margins, StackRows, compared};
use crate::analysis::{equivalence_of_means, equivalence_of_rates, holm, paired_differences};

/// Two one-sided tests: is the difference of two stacks smaller than a margin?
#[derive(Clone, Debug, PartialEq)]
pub struct EquivalenceTest {
    /// The stack compared with.
    pub reference: String,
    /// The stack that is compared.
    pub stack: String,
    /// `success` or the column of a metric.
    pub metric: &'static str,
    /// Number of worlds that the tests use.
    pub n: u64,
    /// The margin on either side, in the unit of the metric; of success in percentage points.
    pub margin: f64,
    /// 90 % interval of stack − reference: of the t law, for success Tango's score interval. `None` with too few worlds.
    pub interval: Option<(f64, f64)>,
    /// The larger p-value of the two tests; 1 with too few worlds.
    pub p: f64,
    /// `p` after Holm's correction over the tests of equivalence of the section.
    pub p_holm: f64,
}

impl EquivalenceTest {
    /// Whether equivalence is shown.
    pub fn is_shown(&self) -> bool {
        self.p_holm <= ALPHA
    }
}

/// The tests of pairs (reference, stack) of every metric that has a margin: one family.
pub(super) fn test_equivalence<'a>(
    pairs: impl Iterator<Item = (&'a StackRows, &'a StackRows)>,
    margins: &Margins,
) -> Vec<EquivalenceTest> {
    let mut tests: Vec<EquivalenceTest> = pairs
        .flat_map(|(reference, stack)| {
            let metrics = [SUCCESS].into_iter().chain(COMPARED);
            metrics.filter_map(move |metric| test(reference, stack, metric, margins))
        })
        .collect();
    let adjusted = holm(&tests.iter().map(|test| test.p).collect::<Vec<_>>());
    tests.iter_mut().zip(adjusted).for_each(|(test, p_holm)| test.p_holm = p_holm);
    tests
}

/// The tests of one metric; `None` if it has no margin.
fn test(reference: &StackRows, stack: &StackRows, metric: &'static str, margins: &Margins) -> Option<EquivalenceTest> {
    let (n, margin, found) = if metric == SUCCESS {
        let (margin, table) = (margins.of(metric, None)?, outcomes(stack, reference));
        let found = equivalence_of_rates(table, margin / 100.0, ALPHA).map(|mut found| {
            found.interval = (100.0 * found.interval.0, 100.0 * found.interval.1);
            found
        });
        (table.pairs(), margin, found)
    } else {
        let column = compared().into_iter().find(|column| column.name == metric)?;
        let (ours, theirs) = solved_by_both(reference, stack, column);
        let mean = theirs.iter().sum::<f64>() / theirs.len() as f64;
        let margin = margins.of(metric, (!theirs.is_empty()).then_some(mean))?;
        // A share of a mean of 0 is no margin.
        let found = (margin > 0.0).then(|| equivalence_of_means(&paired_differences(&ours, &theirs), margin, ALPHA));
        (ours.len() as u64, margin, found.flatten())
    };
    Some(EquivalenceTest {
        reference: reference.name.clone(),
        stack: stack.name.clone(),
        metric,
        n,
        margin,
        interval: found.map(|found| found.interval),
        p: found.map_or(1.0, |found| found.p),
        p_holm: 1.0,
    })
}

#[cfg(test)]
mod tests {
    use super::super::tests::section;
    use super::super::{Pairing, analyse};
    use super::*;

    #[test]
    fn stacks_that_differ_by_less_than_the_margin_are_equivalent_and_few_worlds_show_nothing() {
        let lengths: Vec<f64> = (0..40).map(|k| 20.0 + f64::from(k)).collect();
        // Differences of ±0.1 in turn.
        let others: Vec<f64> = lengths.iter().enumerate().map(|(k, x)| x + [0.1, -0.1][k % 2]).collect();
        let tests = |count: usize, margins: &[&str]| {
            let ends = "s".repeat(count);
            let section = section(&[("a", &ends, &lengths), ("b", &ends, &others)]);
            let margins: Vec<String> = margins.iter().map(|text| (*text).to_owned()).collect();
            let pairing = Pairing { equivalent: Margins::of_equivalence(&margins).unwrap(), ..Pairing::default() };
            analyse(&section, &pairing).unwrap().equivalences
        };
        let [success, length] = &tests(40, &["length_m=1%", "success=8"])[..] else { panic!() };
        // One per cent of a mean of 39.5 m.
        assert!((length.margin - 0.395).abs() < 1e-12 && length.is_shown() && length.n == 40);
        // Without a discordant pair the interval of 90 % ends at z² / (n + z²) = 2.7055 / 42.7055.
        let (low, high) = success.interval.unwrap();
        assert!((high - 6.3353).abs() < 1e-3 && (low + high).abs() < 1e-9 && success.is_shown());
        assert!(!tests(40, &["length_m=0.01"])[0].is_shown() && !tests(20, &["success=8"])[0].is_shown());
        assert_eq!(tests(1, &["length_m=5"])[0].interval, None);
        assert!(tests(40, &[]).is_empty());
    }
}
