//! Rank correlations: do two numbers of the same worlds rise together?

use super::rank::Ranks;
use super::{normal_upper_tail, pairs, student_upper_tail};
use crate::math;

/// Up to this many pairs every pairing of the two samples is enumerated: 9! = 362,880.
const PAIRINGS_MAX: usize = 9;

/// A rank correlation and its test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RankCorrelation {
    /// The coefficient, −1 to 1.
    pub coefficient: f64,
    /// Two-sided p-value of the hypothesis that the samples are independent.
    pub p: f64,
}

/// Spearman's rank correlation: Pearson's correlation of the ranks, equal numbers taking their average rank.
///
/// Up to 9 pairs p = min(1, 2 min(P(ρ ≤ observed), P(ρ ≥ observed))) over all pairings, ties included; above, by Student's t of
/// ρ √((n − 2) / (1 − ρ²)) with n − 2 degrees of freedom. `None` below 3 pairs and where all numbers of a sample are equal.
/// C. Spearman, *The proof and measurement of association between two things*, American Journal of Psychology 15, 1904; tests as
/// in Hollander, Wolfe and Chicken 2014, section 8.5.
///
/// # Panics
/// If the slices differ in length or a number is not finite.
pub fn spearman(first: &[f64], second: &[f64]) -> Option<RankCorrelation> {
    assert_eq!(first.len(), second.len(), "correlated numbers come in pairs");
    let n = first.len();
    let (a, b) = (Ranks::of(first).doubled, Ranks::of(second).doubled);
    // Doubled ranks are integers around n + 1: all sums are exact.
    let centred = |ranks: &[usize]| -> Vec<i64> { ranks.iter().map(|&rank| rank as i64 - (n as i64 + 1)).collect() };
    let (a, b) = (centred(&a), centred(&b));
    let product = |a: &[i64], b: &[i64]| -> i64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let (own_a, own_b) = (product(&a, &a), product(&b, &b));
    if n < 3 || own_a == 0 || own_b == 0 {
        return None;
    }
    let coefficient = product(&a, &b) as f64 / ((own_a as f64).sqrt() * (own_b as f64).sqrt());
    let coefficient = math::clamp(coefficient, -1.0, 1.0);
    let p = if n <= PAIRINGS_MAX {
        p_of_pairings(n, |order| order.iter().zip(&a).map(|(&j, a)| a * b[j]).sum())
    } else {
        let rest = (1.0 - coefficient) * (1.0 + coefficient);
        let t = coefficient.abs() * ((n - 2) as f64 / rest).sqrt();
        2.0 * student_upper_tail(t, n as u64 - 2)
    };
    Some(RankCorrelation { coefficient, p: math::min(p, 1.0) })
}

/// Kendall's τ_b: (concordant − discordant pairs) / √((all − tied in the first) (all − tied in the second)).
///
/// Up to 9 pairs p is exact over all pairings as for [`spearman`]; above, from the normal approximation with its correction for
/// ties, without continuity correction. `None` below 3 pairs and where all numbers of a sample are equal. O(n²).
/// M. G. Kendall, *The treatment of ties in ranking problems*, Biometrika 33, 1945.
///
/// # Panics
/// If the slices differ in length or a number is not finite.
pub fn kendall_tau_b(first: &[f64], second: &[f64]) -> Option<RankCorrelation> {
    assert_eq!(first.len(), second.len(), "correlated numbers come in pairs");
    let n = first.len();
    let (a, b) = (Ranks::of(first), Ranks::of(second));
    let sign = |ranks: &Ranks, i: usize, j: usize| (ranks.doubled[i] as i64 - ranks.doubled[j] as i64).signum();
    let balance =
        |order: &[usize]| -> i64 { pairs(n).map(|(i, j)| sign(&a, i, j) * sign(&b, order[i], order[j])).sum() };
    let untied = |ranks: &Ranks| pairs(n).filter(|&(i, j)| sign(ranks, i, j) != 0).count() as f64;
    let (untied_a, untied_b) = (untied(&a), untied(&b));
    if n < 3 || untied_a == 0.0 || untied_b == 0.0 {
        return None;
    }
    let straight: Vec<usize> = (0..n).collect();
    let observed = balance(&straight) as f64;
    let p = if n <= PAIRINGS_MAX {
        p_of_pairings(n, balance)
    } else {
        let size = n as f64;
        let tied = |f: fn(f64) -> f64| {
            let sum = |ranks: &Ranks| -> f64 { group_sizes(ranks).into_iter().map(f).sum() };
            (sum(&a), sum(&b))
        };
        let (a_0, b_0) = tied(|t| t * (t - 1.0) * (2.0 * t + 5.0));
        let (a_1, b_1) = tied(|t| t * (t - 1.0));
        let (a_2, b_2) = tied(|t| t * (t - 1.0) * (t - 2.0));
        let variance = (size * (size - 1.0) * (2.0 * size + 5.0) - a_0 - b_0) / 18.0
            + a_1 * b_1 / (2.0 * size * (size - 1.0))
            + a_2 * b_2 / (9.0 * size * (size - 1.0) * (size - 2.0));
        2.0 * normal_upper_tail(observed.abs() / variance.sqrt())
    };
    let coefficient = math::clamp(observed / (untied_a.sqrt() * untied_b.sqrt()), -1.0, 1.0);
    Some(RankCorrelation { coefficient, p: math::min(p, 1.0) })
}

/// Numbers of equal ranks.
fn group_sizes(ranks: &Ranks) -> Vec<f64> {
    let mut sorted = ranks.doubled.clone();
    sorted.sort_unstable();
    sorted.chunk_by(|a, b| a == b).map(|group| group.len() as f64).collect()
}

/// The share of all pairings whose statistic is as far on the side of the observed one (the pairing as it is), doubled.
fn p_of_pairings(n: usize, statistic: impl Fn(&[usize]) -> i64) -> f64 {
    let mut order: Vec<usize> = (0..n).collect();
    let observed = statistic(&order);
    let (mut all, mut lower, mut upper) = (0u32, 0u32, 0u32);
    loop {
        let value = statistic(&order);
        all += 1;
        lower += u32::from(value <= observed);
        upper += u32::from(value >= observed);
        if !next_permutation(&mut order) {
            break;
        }
    }
    2.0 * f64::from(lower.min(upper)) / f64::from(all)
}

/// The next order in the dictionary; false after the last.
fn next_permutation(order: &mut [usize]) -> bool {
    let Some(pivot) = order.windows(2).rposition(|pair| pair[0] < pair[1]) else {
        return false;
    };
    if let Some(larger) = order.iter().rposition(|&x| x > order[pivot]) {
        order.swap(pivot, larger);
    }
    order[pivot + 1..].reverse();
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_pairs_worked_by_hand() {
        // Squared differences of ranks 1, 1, 0, 0: ρ = 1 − 6 · 2 / (4 · 15) = 0.8. Of 24 pairings the straight one and three
        // exchanges of neighbours reach it: p = 2 · 4 / 24. One discordant pair of six: τ = 4 / 6, p alike.
        let (first, second) = ([1.0, 2.0, 3.0, 4.0], [20.0, 10.0, 30.0, 40.0]);
        let rho = spearman(&first, &second).unwrap();
        let tau = kendall_tau_b(&first, &second).unwrap();
        assert!((rho.coefficient - 0.8).abs() < 1e-15 && (tau.coefficient - 4.0 / 6.0).abs() < 1e-15);
        assert!((rho.p - 8.0 / 24.0).abs() < 1e-15 && (tau.p - 8.0 / 24.0).abs() < 1e-15);
    }

    #[test]
    fn what_rises_always_is_one_and_what_does_not_vary_is_none() {
        for n in [3, 9, 10, 40] {
            let rising: Vec<f64> = (0..n).map(f64::from).collect();
            let cubes: Vec<f64> = rising.iter().map(|x| x * x * x).collect();
            let falling: Vec<f64> = rising.iter().map(|x| -x).collect();
            for correlation in [spearman, kendall_tau_b] {
                assert!((correlation(&rising, &cubes).unwrap().coefficient - 1.0).abs() < 1e-15);
                let down = correlation(&rising, &falling).unwrap();
                assert!((down.coefficient + 1.0).abs() < 1e-15 && (down.p < 1e-4 || n == 3), "{n} {down:?}");
                assert_eq!(correlation(&rising, &vec![2.0; rising.len()]), None);
            }
        }
        assert_eq!(spearman(&[1.0, 2.0], &[1.0, 2.0]), None);
    }

    #[test]
    fn the_orders_are_all_and_end() {
        let mut order = vec![0, 1, 2, 3];
        let mut seen = vec![order.clone()];
        while next_permutation(&mut order) {
            seen.push(order.clone());
        }
        assert!(seen.len() == 24 && seen.is_sorted_by(|a, b| a < b));
    }
}
