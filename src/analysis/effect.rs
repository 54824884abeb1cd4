//! Effect sizes: the size of a difference, beside the test whether it exists.

use super::{PairedOutcomes, SignedRank};

/// Cohen's d_z of paired differences: mean / standard deviation (n − 1 below the sum).
///
/// Positive if the first stack has the larger numbers. `None` for fewer than two differences
/// and if all are equal: then there is no spread to compare with. It is the effect of
/// *differences*, larger than the d of two independent groups when pairs are correlated.
/// J. Cohen, *Statistical Power Analysis for the Behavioral Sciences*, 2nd edition, 1988, section
/// 2.3.5; name and discussion in D. Lakens, Frontiers in Psychology 4:863, 2013.
///
/// # Panics
/// If a difference is not finite.
pub fn cohen_d_z(differences: &[f64]) -> Option<f64> {
    assert!(differences.iter().all(|d| d.is_finite()), "only finite differences have an effect size");
    let (&start, n) = (differences.first()?, differences.len() as f64);
    // Asked of the numbers themselves: their computed spread may differ from 0 by rounding.
    if differences.iter().all(|&d| d == start) {
        return None;
    }
    let mean = differences.iter().sum::<f64>() / n;
    let squares: f64 = differences.iter().map(|d| (d - mean) * (d - mean)).sum();
    Some(mean / (squares / (n - 1.0)).sqrt())
}

/// Matched-pairs rank-biserial correlation, −1 to 1: (W⁺ − W⁻) / (W⁺ + W⁻).
///
/// 1 if every nonzero difference is positive, 0 for balanced ranks. Zeros are left out, as in the
/// test. `None` if all differences are zero. D. S. Kerby, *The simple difference
/// formula: an approach to teaching nonparametric correlation*, Comprehensive Psychology 3, 2014.
pub fn rank_biserial(test: &SignedRank) -> Option<f64> {
    (test.ranked > 0).then(|| (test.positive - test.negative) / (test.positive + test.negative))
}

/// Odds ratio of the discordant pairs: number of worlds that only the first stack solved, divided by the number that
/// only the second solved.
///
/// The conditional maximum likelihood estimate of the paired odds ratio. Above 1 if the first
/// is better; 0 if only the second ever won alone; `None` if the second never won alone: then
/// it is infinite, or without discordant pairs undefined. J. L. Fleiss, B. Levin and M. C. Paik,
/// *Statistical Methods for Rates and Proportions*, 3rd edition, 2003, section 13.1.
pub fn discordant_odds_ratio(outcomes: PairedOutcomes) -> Option<f64> {
    (outcomes.second_only > 0).then(|| outcomes.first_only as f64 / outcomes.second_only as f64)
}

/// Difference of the two success rates, first − second, −1 to 1; `None` without pairs.
///
/// Equals (first only − second only) / pairs.
pub fn risk_difference(outcomes: PairedOutcomes) -> Option<f64> {
    let pairs = outcomes.pairs();
    (pairs > 0).then(|| (outcomes.first_only as f64 - outcomes.second_only as f64) / pairs as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::signed_rank;

    #[test]
    fn cohens_d_of_numbers_worked_by_hand() {
        // Mean 2, squares 4 + 0 + 4 = 8, variance 8 / 2 = 4: d = 2 / 2.
        assert_eq!(cohen_d_z(&[0.0, 2.0, 4.0]), Some(1.0));
        assert_eq!(cohen_d_z(&[-4.0, 0.0, -2.0]), Some(-1.0));
        for constant in [&[][..], &[1.0], &[0.1, 0.1, 0.1]] {
            assert_eq!(cohen_d_z(constant), None);
        }
    }

    #[test]
    fn rank_biserial_of_numbers_worked_by_hand() {
        // Ranks of 1, 2, 3, 4; the 2 is negative: (8 − 2) / 10.
        assert_eq!(rank_biserial(&signed_rank(&[1.0, -2.0, 3.0, 4.0, 0.0])), Some(0.6));
        assert_eq!(rank_biserial(&signed_rank(&[-1.0, -5.0])), Some(-1.0));
        assert_eq!(rank_biserial(&signed_rank(&[0.0, 0.0])), None);
    }

    #[test]
    fn rates_of_pairs_worked_by_hand() {
        let outcomes = PairedOutcomes { both: 10, first_only: 6, second_only: 2, neither: 2 };
        assert_eq!(discordant_odds_ratio(outcomes), Some(3.0));
        // 16 / 20 − 12 / 20.
        assert_eq!(risk_difference(outcomes), Some(0.2));
        assert_eq!(discordant_odds_ratio(PairedOutcomes { second_only: 0, ..outcomes }), None);
        assert_eq!(risk_difference(PairedOutcomes::default()), None);
    }
}
