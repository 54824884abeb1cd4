//! Equivalence: tests that a difference is smaller than a margin, where tests of a difference can only fail to find one.

use super::{PairedOutcomes, normal_quantile, normal_upper_tail, student_quantile, student_upper_tail};
use crate::math;

/// Result of two one-sided tests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Equivalence {
    /// The larger p-value of the two: that of the hypothesis that the difference is at least the margin, on either side.
    pub p: f64,
    /// Interval of the difference at level 1 − 2 α: inside of the margins if and only if p is at most α.
    pub interval: (f64, f64),
}

/// Are two means equal up to ± `margin`? Two one-sided t tests of paired differences. `None` below two differences.
///
/// p = max(P(T > (mean + margin) / se), P(T > (margin − mean) / se)) with n − 1 degrees of freedom. Small p: equivalent. The
/// margin is stated before the data are seen. Assumes that the mean of the differences is about normal. D. J. Schuirmann, *A
/// comparison of the two one-sided tests procedure and the power approach for assessing the equivalence of average
/// bioavailability*, Journal of Pharmacokinetics and Biopharmaceutics 15, 1987. Differences that are all equal have p = 0 inside
/// of the margins and 1 elsewhere.
///
/// # Panics
/// If a difference is not finite, the margin is not above 0 or `alpha` not between 0 and ½.
pub fn equivalence_of_means(differences: &[f64], margin: f64, alpha: f64) -> Option<Equivalence> {
    assert!(differences.iter().all(|d| d.is_finite()), "only finite differences are tested");
    assert_margin(margin, alpha);
    let n = differences.len();
    if n < 2 {
        return None;
    }
    let mean = differences.iter().sum::<f64>() / n as f64;
    let squares: f64 = differences.iter().map(|d| (d - mean) * (d - mean)).sum();
    let error = (squares / (n - 1) as f64 / n as f64).sqrt();
    let freedom = n as u64 - 1;
    let nearest = margin - mean.abs();
    let p = if error > 0.0 {
        // The side that the mean is nearer to decides.
        student_upper_tail(nearest / error, freedom)
    } else {
        f64::from(u8::from(nearest <= 0.0))
    };
    let reach = -student_quantile(alpha, freedom) * error;
    Some(Equivalence { p, interval: (mean - reach, mean + reach) })
}

/// Are two success rates of the same worlds equal up to ± `margin` (0 to 1)? Two one-sided score tests. `None` without pairs.
///
/// With b pairs that the first alone solved, c the second alone, and δ the assumed difference of the rates,
/// T(δ) = (b − c − n δ) / √(n (2 q + δ (1 − δ))) is standard normal for many pairs; q is the most likely rate of pairs that the
/// second alone solves, given δ: the larger root of 2n q² − (b + c − (2n − b + c) δ) q − c δ (1 − δ) = 0. The interval is that of
/// all δ with |T| at most the quantile of 1 − α. Unlike Wald's interval it has a width without any discordant pair.
/// T. Tango, *Equivalence test and confidence interval for the difference in proportions for the paired-sample design*,
/// Statistics in Medicine 17, 1998.
///
/// # Panics
/// If the margin is not strictly between 0 and 1 or `alpha` not between 0 and ½.
pub fn equivalence_of_rates(outcomes: PairedOutcomes, margin: f64, alpha: f64) -> Option<Equivalence> {
    assert_margin(margin, alpha);
    assert!(margin < 1.0, "rates differ by less than 1: {margin}");
    if outcomes.pairs() == 0 {
        return None;
    }
    let p =
        math::max(normal_upper_tail(tango_score(outcomes, -margin)), normal_upper_tail(-tango_score(outcomes, margin)));
    Some(Equivalence { p, interval: tango_interval(outcomes, 1.0 - 2.0 * alpha)? })
}

/// Tango's score interval of the difference of two paired success rates, first − second; `None` without pairs. The score falls
/// as the assumed difference rises; its ends are found by bisection. Source: see [`equivalence_of_rates`].
///
/// # Panics
/// If `level` is not strictly between 0 and 1.
pub fn tango_interval(outcomes: PairedOutcomes, level: f64) -> Option<(f64, f64)> {
    assert!(level > 0.0 && level < 1.0, "no interval of level {level}");
    if outcomes.pairs() == 0 {
        return None;
    }
    let z = -normal_quantile((1.0 - level) / 2.0);
    let solve = |wanted: f64| {
        let (mut low, mut high) = (-1.0, 1.0);
        for _ in 0..80 {
            let middle = (low + high) / 2.0;
            if tango_score(outcomes, middle) > wanted {
                low = middle;
            } else {
                high = middle;
            }
        }
        (low + high) / 2.0
    };
    Some((solve(z), solve(-z)))
}

/// T(δ) of [`equivalence_of_rates`].
fn tango_score(outcomes: PairedOutcomes, delta: f64) -> f64 {
    let n = outcomes.pairs() as f64;
    let (b, c) = (outcomes.first_only as f64, outcomes.second_only as f64);
    let linear = (2.0 * n - b + c) * delta - b - c;
    let constant = -c * delta * (1.0 - delta);
    let root = math::max(linear * linear - 8.0 * n * constant, 0.0).sqrt();
    let q = (root - linear) / (4.0 * n);
    let variance = n * (2.0 * q + delta * (1.0 - delta));
    let distance = b - c - n * delta;
    if variance > 0.0 {
        distance / variance.sqrt()
    } else if distance == 0.0 {
        0.0
    } else {
        f64::INFINITY * distance
    }
}

fn assert_margin(margin: f64, alpha: f64) {
    assert!(margin.is_finite() && margin > 0.0, "no margin: {margin}");
    assert!(alpha > 0.0 && alpha < 0.5, "no error rate of one side: {alpha}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_and_the_test_agree() {
        let differences = [0.3, -0.1, 0.2, 0.5, 0.0, -0.2, 0.4, 0.1];
        let of = |margin| equivalence_of_means(&differences, margin, 0.05).unwrap();
        let (low, high) = of(1.0).interval;
        assert!(low < 0.0 && high.abs() > low.abs());
        assert!(of(high + 1e-9).p < 0.05 && of(high - 1e-9).p > 0.05);
        let outcomes = PairedOutcomes { both: 80, first_only: 9, second_only: 4, neither: 7 };
        let of = |margin| equivalence_of_rates(outcomes, margin, 0.05).unwrap();
        let (low, high) = of(0.5).interval;
        assert!(low < 0.05 && 0.05 < high && high.abs() > low.abs());
        assert!(of(high + 1e-9).p < 0.05 && of(high - 1e-9).p > 0.05);
    }

    #[test]
    fn differences_without_spread_and_samples_without_pairs() {
        assert_eq!(
            equivalence_of_means(&[0.25; 4], 0.5, 0.05).unwrap(),
            Equivalence { p: 0.0, interval: (0.25, 0.25) }
        );
        assert_eq!(equivalence_of_means(&[0.25; 4], 0.25, 0.05).unwrap().p, 1.0);
        assert_eq!(equivalence_of_means(&[0.25], 0.5, 0.05), None);
        assert_eq!(equivalence_of_rates(PairedOutcomes::default(), 0.1, 0.05), None);
    }

    #[test]
    fn no_discordant_pair_still_has_a_width() {
        // T(δ) = −√(n δ / (1 − δ)): the interval of 95 % ends at z² / (n + z²).
        let outcomes = PairedOutcomes { both: 40, ..PairedOutcomes::default() };
        let (low, high) = tango_interval(outcomes, 0.95).unwrap();
        let expected = 3.841_458_820_694_124 / (40.0 + 3.841_458_820_694_124);
        assert!((high - expected).abs() < 1e-12 && (low + expected).abs() < 1e-12, "{low} {high}");
    }

    #[test]
    fn one_side_alone_reaches_the_ends() {
        for (first_only, second_only) in [(5, 0), (0, 5)] {
            let outcomes = PairedOutcomes { first_only, second_only, ..PairedOutcomes::default() };
            let (low, high) = tango_interval(outcomes, 0.95).unwrap();
            assert!((-1.0..=1.0).contains(&low) && (-1.0..=1.0).contains(&high) && low < high, "{low} {high}");
            assert!(if first_only > 0 { high > 1.0 - 1e-9 } else { low < 1e-9 - 1.0 });
        }
    }
}
