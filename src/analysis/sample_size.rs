//! Differences that a given number of worlds can show.

use super::normal_quantile;
use crate::math;

/// Error rate and power of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorRates {
    /// Probability of claiming a difference that does not exist, two-sided.
    pub alpha: f64,
    /// Probability of claiming a difference that exists.
    pub power: f64,
}

impl Default for ErrorRates {
    /// The customary 5 % and 80 %.
    fn default() -> Self {
        Self { alpha: 0.05, power: 0.8 }
    }
}

impl ErrorRates {
    /// The normal quantiles (1 − α/2, power).
    fn quantiles(self) -> (f64, f64) {
        assert!(self.alpha > 0.0 && self.alpha < 1.0, "no error rate: {}", self.alpha);
        assert!(self.power > 0.5 && self.power < 1.0, "a power above one half, below one: {}", self.power);
        (-normal_quantile(self.alpha / 2.0), normal_quantile(self.power))
    }
}

/// The fewest informative pairs with which an exact paired test can reach `alpha` at all.
///
/// Even if all n discordant worlds (or all n nonzero differences) point the same way, McNemar's
/// exact test and the signed-rank test give p = 2 · 2⁻ⁿ. With `comparisons` in the family the
/// first step of Holm's procedure asks for α / comparisons, so this is the smallest n with
/// 2 · 2⁻ⁿ ≤ α / comparisons: 6 for one comparison at 5 %, 11 for 45. **The rule: with fewer
/// informative pairs, say that n is too small, not that no difference was found.**
///
/// # Panics
/// If `alpha` is not strictly between 0 and 1 or nothing is compared.
pub fn informative_pairs_min(alpha: f64, comparisons: usize) -> u32 {
    assert!(alpha > 0.0 && alpha < 1.0, "no error rate: {alpha}");
    assert!(comparisons > 0, "a family of tests has one at least");
    let mut p = 1.0;
    let mut pairs = 1;
    while p * comparisons as f64 > alpha {
        p /= 2.0;
        pairs += 1;
    }
    pairs
}

/// The smallest mean difference that `pairs` differences of standard deviation `sd` can show.
///
/// δ = (z₁₋α/₂ + z_power) sd / √(n − z₁₋α/₂² / 2): the normal formula with the correction for an
/// estimated standard deviation of W. C. Guenther, *Sample size formulas for normal theory t
/// tests*, The American Statistician 35, 1981; within 2 % of the exact answer (noncentral t) from 8
/// pairs on. For the paired t test; the signed-rank test needs about 5 % more pairs where differences
/// are normal (its efficiency is 3/π). `None` with fewer than 2 pairs or n at most z² / 2:
/// nothing can be shown. In the unit of `sd`.
///
/// # Panics
/// If a rate is out of range (power between ½ and 1) or `sd` is negative or not finite.
pub fn minimal_detectable_mean(pairs: usize, sd: f64, rates: ErrorRates) -> Option<f64> {
    assert!(sd.is_finite() && sd >= 0.0, "no standard deviation: {sd}");
    let (z_alpha, z_power) = rates.quantiles();
    let effective = pairs as f64 - z_alpha * z_alpha / 2.0;
    (pairs >= 2 && effective > 0.0).then(|| (z_alpha + z_power) * sd / effective.sqrt())
}

/// The smallest difference of success rates that `pairs` worlds can show.
///
/// `discordant` is the rate of worlds that exactly one stack solves (from a pilot, or the largest
/// thought possible). The δ that solves n δ² = (z₁₋α/₂ √ψ + z_power √(ψ − δ²))² with ψ the
/// discordant rate: δ = √ψ (√n z_α + z_power √(n + z_power² − z_α²)) / (n + z_power²). R. J. Connor,
/// *Sample size for testing differences in proportions for the paired-sample design*, Biometrics
/// 43, 1987. Large-sample theory of McNemar's test: the exact test needs somewhat more. `None` if δ
/// would exceed ψ, the largest difference there can be: then n is too small to show anything.
///
/// # Panics
/// If a rate is out of range (power between ½ and 1, `discordant` between 0 and 1).
pub fn minimal_detectable_risk_difference(pairs: usize, discordant: f64, rates: ErrorRates) -> Option<f64> {
    assert!((0.0..=1.0).contains(&discordant), "no rate: {discordant}");
    let (z_alpha, z_power) = rates.quantiles();
    let n = pairs as f64;
    let inner = n + z_power * z_power - z_alpha * z_alpha;
    if inner < 0.0 {
        return None;
    }
    let delta = discordant.sqrt() * (n.sqrt() * z_alpha + z_power * inner.sqrt()) / (n + z_power * z_power);
    (delta <= discordant && delta > 0.0).then_some(delta)
}

/// The pairs that the paired t test needs to show a mean `difference` of differences with standard deviation `sd`.
///
/// The smallest n with [`minimal_detectable_mean`] at most |difference|: ((z₁₋α/₂ + z_power) sd / δ)² + z₁₋α/₂² / 2 rounded up,
/// 2 at least. `None` if the difference is 0, or so small that the number is beyond 2⁵³.
///
/// # Panics
/// As [`minimal_detectable_mean`], or if the difference is not finite.
pub fn pairs_needed_mean(difference: f64, sd: f64, rates: ErrorRates) -> Option<u64> {
    assert!(sd.is_finite() && sd >= 0.0 && difference.is_finite(), "no difference: {difference} ± {sd}");
    let (z_alpha, z_power) = rates.quantiles();
    let ratio = (z_alpha + z_power) * sd / difference;
    whole(ratio * ratio + z_alpha * z_alpha / 2.0)
}

/// The pairs that McNemar's test needs to show a `difference` of success rates where exactly one stack solves `discordant` of the worlds.
///
/// Connor's formula, see [`minimal_detectable_risk_difference`]: (z₁₋α/₂ √ψ + z_power √(ψ − δ²))² / δ² rounded up. The exact test needs somewhat
/// more: at least [`informative_pairs_min`] / ψ. `None` if the difference is 0, or so small that the number is beyond 2⁵³.
///
/// # Panics
/// If a rate is out of range or the difference is larger than `discordant`.
pub fn pairs_needed_risk_difference(difference: f64, discordant: f64, rates: ErrorRates) -> Option<u64> {
    assert!((0.0..=1.0).contains(&discordant), "no rate: {discordant}");
    // Both are counts divided by one number; equal on paper, they may differ by rounding.
    assert!(difference.abs() <= discordant * (1.0 + 1e-9), "{difference} of {discordant} discordant");
    let (z_alpha, z_power) = rates.quantiles();
    let rest = math::max(discordant - difference * difference, 0.0);
    let root = (z_alpha * discordant.sqrt() + z_power * rest.sqrt()) / difference;
    whole(root * root)
}

/// A number of pairs rounded up, 2 at least; `None` where it is no number or too large to be exact.
fn whole(pairs: f64) -> Option<u64> {
    (pairs < (1u64 << 53) as f64).then(|| (pairs.ceil() as u64).max(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{PairedOutcomes, mcnemar_exact, mcnemar_mid_p, signed_rank};

    #[test]
    fn below_the_least_number_of_pairs_no_test_can_reject() {
        for (alpha, comparisons) in [(0.05, 1), (0.05, 3), (0.05, 45), (0.01, 1), (0.5, 1), (0.001, 190)] {
            let least = informative_pairs_min(alpha, comparisons) as usize;
            let level = alpha / comparisons as f64;
            let all_one_way = |n: usize| {
                let differences: Vec<f64> = (1..=n).map(|i| i as f64).collect();
                let outcomes = PairedOutcomes { first_only: n as u64, ..PairedOutcomes::default() };
                assert!((signed_rank(&differences).p - mcnemar_exact(outcomes)).abs() < 1e-15);
                mcnemar_exact(outcomes)
            };
            assert!(all_one_way(least) <= level, "{alpha} {comparisons} {least}");
            assert!(all_one_way(least - 1) > level, "{alpha} {comparisons} {least}");
        }
        assert_eq!((informative_pairs_min(0.05, 1), informative_pairs_min(0.05, 45)), (6, 11));
    }

    #[test]
    fn the_difference_of_rates_is_found_with_the_stated_power() {
        // Power by enumeration of all outcomes: n worlds, of which d discordant, of which w for the first.
        for (n, discordant) in [(100, 0.2), (200, 0.3), (60, 0.5)] {
            let delta = minimal_detectable_risk_difference(n, discordant, ErrorRates::default()).unwrap();
            let win = (discordant + delta) / (2.0 * discordant);
            let mut power = 0.0;
            for d in 0..=n {
                for w in 0..=d {
                    let outcomes = PairedOutcomes {
                        first_only: w as u64,
                        second_only: (d - w) as u64,
                        ..PairedOutcomes::default()
                    };
                    if mcnemar_mid_p(outcomes) <= 0.05 {
                        power += binomial(n, d, discordant) * binomial(d, w, win);
                    }
                }
            }
            // The theory is a large-sample one; outcomes are whole numbers.
            assert!((power - 0.8).abs() < 0.03, "{n} {discordant} {delta} {power}");
        }
    }

    /// C(n, k) pᵏ (1 − p)ⁿ⁻ᵏ by plain products of both.
    fn binomial(n: usize, k: usize, p: f64) -> f64 {
        let mut value = 1.0;
        for i in 0..k {
            value *= (n - i) as f64 / (k - i) as f64 * p;
            // Interleaved, so that no partial product overflows.
            if i < n - k {
                value *= 1.0 - p;
            }
        }
        for _ in k..(n - k).max(k) {
            value *= 1.0 - p;
        }
        value
    }

    #[test]
    fn more_pairs_show_smaller_differences() {
        let rates = ErrorRates::default();
        // (1.959964 + 0.841621) · 2 / √(102 − 1.920729) = 5.603170 / 10.003963.
        assert!((minimal_detectable_mean(102, 2.0, rates).unwrap() - 5.603_170 / 10.003_963).abs() < 1e-6);
        assert_eq!(minimal_detectable_mean(1, 2.0, rates), None);
        let found: Vec<f64> = (2..400).filter_map(|n| minimal_detectable_risk_difference(n, 0.4, rates)).collect();
        assert!(found.len() > 300 && found.is_sorted_by(|a, b| a > b));
        assert!(found.iter().all(|&delta| delta <= 0.4));
        for (n, discordant) in [(0, 0.5), (5, 0.1), (3, 1.0), (100, 0.0)] {
            assert_eq!(minimal_detectable_risk_difference(n, discordant, rates), None);
        }
    }

    #[test]
    fn the_closed_form_solves_connors_equation() {
        let (z_alpha, z_power) = ErrorRates::default().quantiles();
        for (n, psi) in [(30, 0.5), (100, 0.2), (1000, 0.05)] {
            let delta = minimal_detectable_risk_difference(n, psi, ErrorRates::default()).unwrap();
            let root = z_alpha * psi.sqrt() + z_power * (psi - delta * delta).sqrt();
            assert!((n as f64 * delta * delta - root * root).abs() < 1e-10, "{n} {psi}");
        }
    }

    #[test]
    fn the_pairs_needed_are_the_fewest_that_show_the_difference() {
        let rates = ErrorRates::default();
        for (difference, sd) in [(0.1, 1.0), (-0.5, 1.0), (2.0, 3.0), (0.01, 0.2)] {
            let n = pairs_needed_mean(difference, sd, rates).unwrap() as usize;
            let shows = |n| minimal_detectable_mean(n, sd, rates).is_some_and(|least| least <= difference.abs());
            assert!(shows(n) && !shows(n - 1), "{difference} {sd} {n}");
        }
        for (difference, discordant) in [(0.1, 0.2), (-0.05, 0.3), (0.02, 0.02), (0.3, 0.8)] {
            let n = pairs_needed_risk_difference(difference, discordant, rates).unwrap() as usize;
            let shows = |n| {
                let least = minimal_detectable_risk_difference(n, discordant, rates);
                least.is_some_and(|least| least <= difference.abs() * (1.0 + 1e-12))
            };
            assert!(shows(n) && !shows(n - 1), "{difference} {discordant} {n}");
        }
        assert_eq!((pairs_needed_mean(0.0, 1.0, rates), pairs_needed_mean(0.0, 0.0, rates)), (None, None));
        assert_eq!(pairs_needed_risk_difference(0.0, 0.2, rates), None);
        assert_eq!((pairs_needed_mean(1.0, 0.0, rates), pairs_needed_mean(1e-20, 1.0, rates)), (Some(2), None));
    }
}
