//! Two stacks on the same worlds: paired outcomes and paired numbers.

use crate::math;

/// How two stacks ended the same worlds: the 2 × 2 table of paired successes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PairedOutcomes {
    /// Worlds in which both stacks succeeded.
    pub both: u64,
    /// Worlds in which only the first stack succeeded.
    pub first_only: u64,
    /// Worlds in which only the second stack succeeded.
    pub second_only: u64,
    /// Worlds in which neither stack succeeded.
    pub neither: u64,
}

impl PairedOutcomes {
    /// Counts the successes of two stacks; element i of both is the same world.
    ///
    /// # Panics
    /// If the slices differ in length: then they are no pairs.
    pub fn count(first: &[bool], second: &[bool]) -> Self {
        assert_eq!(first.len(), second.len(), "paired outcomes come in pairs");
        let mut outcomes = Self::default();
        for pair in first.iter().zip(second) {
            *match pair {
                (true, true) => &mut outcomes.both,
                (true, false) => &mut outcomes.first_only,
                (false, true) => &mut outcomes.second_only,
                (false, false) => &mut outcomes.neither,
            } += 1;
        }
        outcomes
    }

    /// The number of worlds.
    pub fn pairs(self) -> u64 {
        self.both + self.neither + self.discordant()
    }

    /// The number of worlds in which exactly one stack succeeded; McNemar's test uses these alone.
    pub fn discordant(self) -> u64 {
        self.first_only + self.second_only
    }
}

/// Two-sided p-value of McNemar's exact conditional test: do both stacks succeed equally often?
///
/// Of n discordant worlds, those won by the first stack are binomial (n, ½) under the null
/// hypothesis; with m the smaller of the two counts, p = min(1, 2 P(X ≤ m)). Worlds that both or
/// neither solved carry no information; without discordant worlds p = 1. Assumes that the worlds
/// are independent of each other. Q. McNemar, *Note on the sampling error of the difference
/// between correlated proportions*, Psychometrika 12, 1947; the exact form as in Fagerland et al.
/// (see [`mcnemar_mid_p`]). Relative error below n · 1e-15; 0 where p is below 1e-300.
pub fn mcnemar_exact(outcomes: PairedOutcomes) -> f64 {
    let (below, at) = fair_binomial(outcomes.discordant(), outcomes.first_only.min(outcomes.second_only));
    math::min(2.0 * (below + at), 1.0)
}

/// Two-sided mid-p-value of McNemar's test: the outcomes more extreme than the one observed, and
/// half of those as extreme.
///
/// With m and n of [`mcnemar_exact`], p = 2 P(X < m) + P(X = m), and 1 − P(X = m) / 2 where both
/// counts are equal; without discordant worlds p = 1. It is less conservative than the exact test
/// and may exceed the stated error rate slightly (never in the 9595 settings of its authors):
/// M. W. Fagerland, S. Lydersen and P. Laake, *The McNemar test for binary matched-pairs data:
/// mid-p and asymptotic are better than exact conditional*, BMC Medical Research Methodology
/// 13:91, 2013.
pub fn mcnemar_mid_p(outcomes: PairedOutcomes) -> f64 {
    let (below, at) = fair_binomial(outcomes.discordant(), outcomes.first_only.min(outcomes.second_only));
    if outcomes.discordant() == 0 {
        1.0
    } else if outcomes.first_only == outcomes.second_only {
        1.0 - at / 2.0
    } else {
        2.0 * below + at
    }
}

/// (P(X < m), P(X = m)) of a binomial variable (n, ½), for m up to n / 2.
///
/// Weights relative to the middle, by C(n, k − 1) = C(n, k) k / (n − k + 1), divided by their sum:
/// no factorial, nothing that overflows.
fn fair_binomial(n: u64, m: u64) -> (f64, f64) {
    assert!(m <= n / 2, "{m} is not in the lower half of {n}");
    let (mut weight, mut half, mut below, mut at) = (1.0, 0.0, 0.0, 0.0);
    for k in (0..=n / 2).rev() {
        half += weight;
        if k == m {
            at = weight;
        } else if k < m {
            below += weight;
        }
        weight *= k as f64 / (n - k + 1) as f64;
    }
    // An even n has its middle in both halves.
    let total = if n.is_multiple_of(2) { 2.0 * half - 1.0 } else { 2.0 * half };
    (below / total, at / total)
}

/// The differences first − second, rounded so that those equal on paper are equal as numbers.
///
/// The resolution is 2⁻³² of the power of two at or below the largest magnitude in both samples (at
/// most 2.4e-10 of it), far above rounding errors and far below measured differences. Without it 12.3 − 12.1
/// and 5.3 − 5.1 would be no tie, and a rank test would see an order that does not exist. R rounds for the
/// same reason (`wilcox.test(digits.rank = )`).
///
/// # Panics
/// If the slices differ in length or a number is not finite.
pub fn paired_differences(first: &[f64], second: &[f64]) -> Vec<f64> {
    assert_eq!(first.len(), second.len(), "paired numbers come in pairs");
    let mut largest = 0.0;
    for &value in first.iter().chain(second) {
        assert!(value.is_finite(), "a difference from {value}");
        largest = math::max(largest, value.abs());
    }
    let step = resolution(largest);
    // Step is a power of two: dividing and multiplying by it are exact.
    first.iter().zip(second).map(|(a, b)| math::canonical(((a - b) / step).round() * step)).collect()
}

/// 2⁻³² of the power of two at or below `largest`; 1 if `largest` is 0.
fn resolution(largest: f64) -> f64 {
    const MANTISSA: u64 = (1 << 52) - 1;
    let power = f64::from_bits(largest.to_bits() & !MANTISSA);
    let step = power / (1u64 << 32) as f64;
    if step > 0.0 { step } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn discordant(first_only: u64, second_only: u64) -> PairedOutcomes {
        PairedOutcomes { both: 3, first_only, second_only, neither: 4 }
    }

    #[test]
    fn pairs_are_counted_by_who_succeeded() {
        let first = [true, true, true, false, false, true];
        let second = [true, false, false, true, false, true];
        let outcomes = PairedOutcomes::count(&first, &second);
        assert_eq!(outcomes, PairedOutcomes { both: 2, first_only: 2, second_only: 1, neither: 1 });
        assert_eq!((outcomes.pairs(), outcomes.discordant()), (6, 3));
    }

    #[test]
    fn mcnemar_agrees_with_the_examples_of_fagerland_2013() {
        // Airway hyper-responsiveness, 1 and 7 discordant pairs: 2 (1 + 8) / 2⁸ = 0.0703 and
        // (2 · 1 + 8) / 2⁸ = 0.0391.
        assert!((mcnemar_exact(discordant(1, 7)) - 18.0 / 256.0).abs() < 1e-15);
        assert!((mcnemar_mid_p(discordant(7, 1)) - 10.0 / 256.0).abs() < 1e-15);
        // 6 and 16 discordant pairs: 2 · 110 056 / 2²² = 0.0525, less C(22, 6) / 2²² = 74 613 / 2²².
        assert!((mcnemar_exact(discordant(6, 16)) - 0.0525).abs() < 5e-5);
        assert!((mcnemar_mid_p(discordant(16, 6)) - 0.0347).abs() < 5e-5);
    }

    #[test]
    fn equal_and_absent_discordant_pairs_say_nothing() {
        assert_eq!((mcnemar_exact(discordant(0, 0)), mcnemar_mid_p(discordant(0, 0))), (1.0, 1.0));
        // C(4, 2) / 2⁴ = 0.375.
        assert_eq!((mcnemar_exact(discordant(2, 2)), mcnemar_mid_p(discordant(2, 2))), (1.0, 1.0 - 0.375 / 2.0));
    }

    #[test]
    fn thousands_of_pairs_neither_overflow_nor_vanish() {
        // All of n pairs for one side: p = 2^(1 − n), exactly.
        assert!((mcnemar_exact(discordant(0, 1000)) / (2.0 / f64::from_bits((1000 + 1023) << 52)) - 1.0).abs() < 1e-12);
        // Around the middle of a large sample the normal law holds: z = (5100 − 5000 − ½) / 50 = 1.99.
        let normal = 2.0 * crate::analysis::normal_upper_tail(1.99);
        assert!((mcnemar_exact(discordant(4900, 5100)) - normal).abs() < 1e-5);
    }

    #[test]
    fn differences_equal_on_paper_are_ties() {
        let (first, second) = ([12.3, 5.3, 7.1, 2.0], [12.1, 5.1, 7.1, 2.2]);
        assert_ne!(12.3 - 12.1, 5.3 - 5.1);
        let differences = paired_differences(&first, &second);
        assert_eq!(differences[0], differences[1]);
        assert_eq!(differences[0], -differences[3]);
        assert_eq!(differences[2].to_bits(), 0.0f64.to_bits());
        assert!((differences[0] - 0.2).abs() < 1e-8);
        assert_eq!(paired_differences(&[0.0], &[0.0]), [0.0]);
        assert_eq!(paired_differences(&[], &[]), [0.0; 0]);
    }

    #[test]
    #[should_panic(expected = "paired numbers come in pairs")]
    fn a_missing_partner_is_a_bug() {
        paired_differences(&[1.0], &[]);
    }
}
