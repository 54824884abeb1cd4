//! Rank tests: Wilcoxon's signed-rank test of pairs and the rank-sum test of two samples.

use super::normal_upper_tail;
use crate::math;

/// Up to this many ranked numbers the null distribution is enumerated, ties included.
///
/// All counts stay below 2⁵³ here (2⁵⁰ sign patterns; C(50, 25) splits), so that every one is an
/// exact f64. R and SciPy change over near this size for signed ranks without ties (with ties R
/// approximates at once, SciPy from 14 on).
pub const EXACT_MAX: usize = 50;

/// Method by which a p-value was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NullDistribution {
    /// From the exact distribution given the ranks, average ranks of ties included.
    Exact,
    /// From the normal approximation with tie and continuity correction.
    Normal,
}

/// Result of Wilcoxon's signed-rank test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedRank {
    /// Number of differences that were ranked: those other than zero.
    pub ranked: usize,
    /// Number of differences of zero, which are left out.
    pub zeros: usize,
    /// W⁺: sum of the ranks of the positive differences.
    pub positive: f64,
    /// W⁻: sum of the ranks of the negative differences.
    pub negative: f64,
    /// Two-sided p-value.
    pub p: f64,
    /// Method by which `p` was computed.
    pub null: NullDistribution,
}

/// Wilcoxon's signed-rank test of paired differences: are they symmetric around zero?
///
/// Zeros are dropped and counted; the others are ranked by magnitude, ties take their average
/// rank, and W⁺ sums the ranks of the positive ones. Numbers tie only where they are equal: take
/// the differences from [`paired_differences`](super::paired_differences). Under the null
/// hypothesis each rank has either sign with probability ½.
/// - Up to [`EXACT_MAX`] ranks, p = min(1, 2 P(W ≤ min(W⁺, W⁻))) from the number of subsets of the
///   (doubled, hence integer) ranks with each sum: exact with ties too.
/// - Above, z = (|W⁺ − n(n+1)/4| − ½) / σ, at least 0, with σ² = n(n+1)(2n+1)/24 − Σ(t³−t)/48 over
///   ties of t, and p = 2 P(Z > z).
///
/// p = 1 if nothing is left to rank. F. Wilcoxon, *Individual comparisons by ranking methods*,
/// Biometrics Bulletin 1, 1945; ties as in M. Hollander, D. A. Wolfe and E. Chicken,
/// *Nonparametric Statistical Methods*, 3rd edition, 2014, section 3.1.
///
/// # Panics
/// If a difference is not finite.
pub fn signed_rank(differences: &[f64]) -> SignedRank {
    let kept: Vec<f64> = differences.iter().copied().filter(|&d| d != 0.0).collect();
    let magnitudes: Vec<f64> = kept.iter().map(|d| d.abs()).collect();
    let Ranks { doubled, ties } = Ranks::of(&magnitudes);
    let all: usize = doubled.iter().sum();
    let positive: usize = kept.iter().zip(&doubled).filter(|&(&d, _)| d > 0.0).map(|(_, rank)| rank).sum();
    let negative = all - positive;

    let (p, null) = if kept.len() <= EXACT_MAX {
        let ways = subsets_by_sum(&doubled);
        let tail: u64 = ways[..=positive.min(negative)].iter().sum();
        (2.0 * tail as f64 / (1u64 << kept.len()) as f64, NullDistribution::Exact)
    } else {
        let n = kept.len() as f64;
        let variance = n * (n + 1.0) * (2.0 * n + 1.0) / 24.0 - ties / 48.0;
        // |W⁺ − n(n+1)/4| = |W⁺ − W⁻| / 2, and the sums are doubled.
        (two_sided_normal(positive.abs_diff(negative) as f64 / 4.0, variance), NullDistribution::Normal)
    };
    SignedRank {
        ranked: kept.len(),
        zeros: differences.len() - kept.len(),
        positive: positive as f64 / 2.0,
        negative: negative as f64 / 2.0,
        p: math::min(p, 1.0),
        null,
    }
}

/// Result of the rank-sum test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankSum {
    /// U of the first sample: pairs (x, y) with x > y, those with x = y counted half.
    pub first: f64,
    /// U of the second sample: pairs with y > x, ties counted half. Both sum to n₁ n₂.
    pub second: f64,
    /// Two-sided p-value.
    pub p: f64,
    /// Method by which `p` was computed.
    pub null: NullDistribution,
}

/// The rank-sum test of two independent samples (Wilcoxon, Mann and Whitney): same distribution?
///
/// For unpaired numbers only; the same worlds driven by two stacks are pairs ([`signed_rank`]).
/// All n = n₁ + n₂ numbers are ranked together, equal ones take their average rank, R₁ sums the
/// ranks of the first sample and U₁ = R₁ − n₁(n₁+1)/2.
/// - Up to [`EXACT_MAX`] numbers in all, p = min(1, 2 min(P(R ≤ R₁), P(R ≥ R₁))) over all C(n, n₁)
///   splits of the (doubled, hence integer) ranks: exact with ties too.
/// - Above, z = (|U₁ − n₁n₂/2| − ½) / σ, at least 0, with σ² = n₁n₂/12 · (n + 1 − Σ(t³−t)/(n(n−1)))
///   over ties of t, and p = 2 P(Z > z).
///
/// p = 1 if a sample is empty or all numbers are equal. H. B. Mann and D. R. Whitney, *On a test of whether
/// one of two random variables is stochastically larger than the other*, Annals of Mathematical
/// Statistics 18, 1947; ties as in Hollander, Wolfe and Chicken 2014, section 4.1.
///
/// # Panics
/// If a number is not finite.
pub fn rank_sum(first: &[f64], second: &[f64]) -> RankSum {
    let pooled: Vec<f64> = first.iter().chain(second).copied().collect();
    let Ranks { doubled, ties } = Ranks::of(&pooled);
    let observed: usize = doubled[..first.len()].iter().sum();
    // 2 U₁ = 2 R₁ − n₁(n₁+1): an integer as well.
    let doubled_u = observed - first.len() * (first.len() + 1);
    let (n1, n2, n) = (first.len() as f64, second.len() as f64, pooled.len() as f64);
    let first_u = doubled_u as f64 / 2.0;

    let (p, null) = if pooled.len() <= EXACT_MAX {
        let ways = subsets_of_size_by_sum(&doubled, first.len());
        let lower: u64 = ways[..=observed].iter().sum();
        let upper: u64 = ways[observed..].iter().sum();
        let all = lower + upper - ways[observed];
        (2.0 * lower.min(upper) as f64 / all as f64, NullDistribution::Exact)
    } else {
        let variance = n1 * n2 / 12.0 * (n + 1.0 - ties / (n * (n - 1.0)));
        (two_sided_normal((first_u - n1 * n2 / 2.0).abs(), variance), NullDistribution::Normal)
    };
    RankSum { first: first_u, second: n1 * n2 - first_u, p: math::min(p, 1.0), null }
}

/// Average ranks, and the correction of the variance for ties.
pub(super) struct Ranks {
    /// Twice the rank (counted from 1) of each number: an integer even where ranks are averaged.
    pub(super) doubled: Vec<usize>,
    /// Σ(t³ − t) over the groups of t equal numbers.
    ties: f64,
}

impl Ranks {
    pub(super) fn of(values: &[f64]) -> Self {
        assert!(values.iter().all(|value| value.is_finite()), "only finite numbers have ranks");
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
        let mut doubled = vec![0; values.len()];
        let (mut ties, mut before) = (0.0, 0);
        // −0.0 sorts before 0.0 and equals it: the grouping compares, the sort only gathers.
        for group in order.chunk_by(|&a, &b| values[a] == values[b]) {
            let after = before + group.len();
            for &index in group {
                doubled[index] = before + 1 + after;
            }
            let t = group.len() as f64;
            ties += t * t * t - t;
            before = after;
        }
        Self { doubled, ties }
    }
}

/// For each sum, the number of subsets of `ranks` that have it.
pub(super) fn subsets_by_sum(ranks: &[usize]) -> Vec<u64> {
    let mut ways = vec![0; ranks.iter().sum::<usize>() + 1];
    ways[0] = 1;
    for &rank in ranks {
        for sum in (rank..ways.len()).rev() {
            ways[sum] += ways[sum - rank];
        }
    }
    ways
}

/// For each sum, the number of subsets of `size` of the `ranks` that have it.
pub(super) fn subsets_of_size_by_sum(ranks: &[usize], size: usize) -> Vec<u64> {
    let sums = ranks.iter().sum::<usize>() + 1;
    // Row k: the subsets of k ranks.
    let mut ways = vec![0; (size + 1) * sums];
    ways[0] = 1;
    for &rank in ranks {
        for k in (1..=size).rev() {
            for sum in rank..sums {
                ways[k * sums + sum] += ways[(k - 1) * sums + sum - rank];
            }
        }
    }
    ways.split_off(size * sums)
}

/// Two-sided p-value of a sum of ranks at a distance from its mean, with continuity correction.
fn two_sided_normal(distance: f64, variance: f64) -> f64 {
    if variance <= 0.0 {
        return 1.0; // all numbers are equal
    }
    2.0 * normal_upper_tail(math::max(distance - 0.5, 0.0) / variance.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::paired_differences;

    #[test]
    #[expect(clippy::approx_constant, reason = "3.14 is a score of the table")]
    fn signed_ranks_agree_with_the_depression_scores_of_hollander_and_wolfe() {
        // Table 3.1, Hamilton factor IV of nine patients before and after treatment: W⁺ = 40 without ties,
        // one-sided p = 10 / 2⁹ = 0.0195.
        let before = [1.83, 0.50, 1.62, 2.48, 1.68, 1.88, 1.55, 3.06, 1.30];
        let after = [0.878, 0.647, 0.598, 2.05, 1.06, 1.29, 1.06, 3.14, 1.29];
        let test = signed_rank(&paired_differences(&before, &after));
        assert_eq!((test.ranked, test.zeros, test.positive, test.negative), (9, 0, 40.0, 5.0));
        assert_eq!((test.p, test.null), (20.0 / 512.0, NullDistribution::Exact));
    }

    #[test]
    fn rank_sums_agree_with_the_permeability_data_of_hollander_and_wolfe() {
        // Table 4.1, chorioamnion at term and at 12 to 26 weeks: U = 35 of 50, one-sided p = 0.1272.
        let term = [0.80, 0.83, 1.89, 1.04, 1.45, 1.38, 1.91, 1.64, 0.73, 1.46];
        let early = [1.15, 0.88, 0.90, 0.74, 1.21];
        let test = rank_sum(&term, &early);
        assert_eq!((test.first, test.second, test.null), (35.0, 15.0, NullDistribution::Exact));
        assert!((test.p - 2.0 * 0.1272).abs() < 1e-4);
    }

    #[test]
    fn ties_and_zeros_worked_by_hand() {
        // Magnitudes 1, 1, 2: ranks 1½, 1½, 3. W⁻ = 1½; sums 0, 1½, 1½ of the 8 are at most that: p = 6 / 8.
        let test = signed_rank(&[1.0, 0.0, -1.0, 2.0, -0.0]);
        assert_eq!((test.ranked, test.zeros, test.positive, test.negative, test.p), (3, 2, 4.5, 1.5, 0.75));
        // 1, 2 against 2, 3: ranks 1, 2½, 2½, 4. R₁ = 3½; of 6 splits two are at most that: p = 4 / 6.
        let test = rank_sum(&[1.0, 2.0], &[2.0, 3.0]);
        assert_eq!((test.first, test.second), (0.5, 3.5));
        assert!((test.p - 4.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn nothing_to_rank_is_no_evidence() {
        for differences in [&[][..], &[0.0, 0.0]] {
            let test = signed_rank(differences);
            assert_eq!((test.ranked, test.zeros, test.p), (0, differences.len(), 1.0));
        }
        for (first, second) in [(&[][..], &[][..]), (&[1.0, 2.0], &[]), (&[], &[1.0]), (&[3.0; 40], &[3.0; 40])] {
            assert_eq!(rank_sum(first, second).p, 1.0);
        }
        assert_eq!(rank_sum(&[1.0; 60], &[]).p, 1.0);
        assert_eq!(rank_sum(&[], &[1.0; 60]).p, 1.0);
    }

    #[test]
    fn exchanging_the_stacks_changes_only_the_sign() {
        let (first, second): (Vec<f64>, Vec<f64>) =
            (0..60).map(|i| (f64::from(i * 37 % 23), f64::from(i * 11 % 17))).unzip();
        for n in [4, 20, 50, 60] {
            let (a, b) = (&first[..n], &second[..n]);
            let (there, back) = (signed_rank(&paired_differences(a, b)), signed_rank(&paired_differences(b, a)));
            assert_eq!((there.positive, there.negative, there.p), (back.negative, back.positive, back.p));
            let (there, back) = (rank_sum(a, b), rank_sum(b, a));
            assert_eq!((there.first, there.second), (back.second, back.first));
            assert!((there.p - back.p).abs() < 1e-15);
        }
    }

    #[test]
    fn the_approximation_takes_over_smoothly() {
        // One difference more than can be enumerated moves p by little.
        let differences: Vec<f64> = (0..=EXACT_MAX).map(|i| (i * i % 53) as f64 - 18.5).collect();
        let (exact, normal) = (signed_rank(&differences[..EXACT_MAX]), signed_rank(&differences));
        assert_eq!((exact.null, normal.null), (NullDistribution::Exact, NullDistribution::Normal));
        assert!((exact.p - normal.p).abs() < 0.02, "{} {}", exact.p, normal.p);
    }

    #[test]
    #[should_panic(expected = "only finite numbers have ranks")]
    fn a_not_a_number_has_no_rank() {
        signed_rank(&[1.0, f64::NAN]);
    }
}
