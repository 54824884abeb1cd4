//! Hodges–Lehmann estimates: the location that belongs to a rank test, with the interval that inverts the test.

use super::rank::{subsets_by_sum, subsets_of_size_by_sum};
use super::{EXACT_MAX, normal_quantile};
use crate::math;

/// The pseudomedian of paired differences: the median of all averages (dᵢ + dⱼ) / 2 with i ≤ j. `None` without differences.
///
/// The estimate that belongs to [`signed_rank`](super::signed_rank): the shift at which its two sums of ranks balance. It is
/// the median where differences are symmetric, and a few wild ones hardly move it. Zeros are differences like any other here,
/// though the test drops them. J. L. Hodges and E. L. Lehmann, *Estimates of location based on rank tests*, Annals of
/// Mathematical Statistics 34, 1963. Exact, in O(n log n): averages are counted, never stored.
///
/// # Panics
/// If a difference is not finite.
pub fn hodges_lehmann(differences: &[f64]) -> Option<f64> {
    Averages::of(differences).median()
}

/// Confidence interval of [`hodges_lehmann`] at a level: the shifts that the signed-rank test does not reject.
///
/// The averages number r + 1 from either end, r being the largest sum of ranks with 2 P(W ≤ r) ≤ 1 − level: from the exact law
/// of n ranks up to [`EXACT_MAX`] differences, from the normal approximation with continuity correction above. `None` where no
/// sum is that rare: below 6 differences at 95 %. Covers the pseudomedian of any symmetric law with at least the level, with
/// ties and zeros more often than that; without them it holds 0 if and only if the test is not significant.
/// M. Hollander, D. A. Wolfe and E. Chicken, *Nonparametric Statistical Methods*, 3rd edition, 2014, section 3.3.
///
/// # Panics
/// If a difference is not finite or `level` is not strictly between 0 and 1.
pub fn hodges_lehmann_interval(differences: &[f64], level: f64) -> Option<(f64, f64)> {
    let n = differences.len();
    let size = n as f64;
    let law = || subsets_by_sum(&(1..=n).collect::<Vec<usize>>());
    let variance = size * (size + 1.0) * (2.0 * size + 1.0) / 24.0;
    let rejected = largest_rejected(level, n, law, size * (size + 1.0) / 4.0, variance)?;
    Averages::of(differences).ends(rejected)
}

/// The shift between two independent samples: the median of all differences xᵢ − yⱼ. `None` if a sample is empty.
///
/// The estimate that belongs to [`rank_sum`](super::rank_sum). It is not the difference of the medians, but equals it where both
/// laws are the same but for a shift. Hodges and Lehmann 1963, as [`hodges_lehmann`].
///
/// # Panics
/// If a number is not finite.
pub fn hodges_lehmann_shift(first: &[f64], second: &[f64]) -> Option<f64> {
    Shifts::of(first, second).median()
}

/// Confidence interval of [`hodges_lehmann_shift`] at a level: the shifts that the rank-sum test does not reject.
///
/// The differences number r + 1 from either end, r being the largest U with 2 P(U ≤ r) ≤ 1 − level: exact up to
/// [`EXACT_MAX`] numbers in all, from the normal approximation with continuity correction above, without ties in both. `None`
/// where no U is that rare. Assumes that both laws have the same shape. Hollander, Wolfe and Chicken 2014, section 4.3.
///
/// # Panics
/// If a number is not finite or `level` is not strictly between 0 and 1.
pub fn hodges_lehmann_shift_interval(first: &[f64], second: &[f64], level: f64) -> Option<(f64, f64)> {
    let (m, n) = (first.len(), second.len());
    let product = m as f64 * n as f64;
    // U is the sum of the ranks of the first sample less the smallest that it can be.
    let law = || subsets_of_size_by_sum(&(1..=m + n).collect::<Vec<usize>>(), m).split_off(m * (m + 1) / 2);
    let variance = product * ((m + n) as f64 + 1.0) / 12.0;
    let rejected = largest_rejected(level, m + n, law, product / 2.0, variance)?;
    Shifts::of(first, second).ends(rejected)
}

/// The largest value of a rank statistic that its two-sided test rejects at 1 − level, of `ranked` numbers; `None` without one.
/// `law` counts the arrangements that have each value.
fn largest_rejected(level: f64, ranked: usize, law: impl Fn() -> Vec<u64>, mean: f64, variance: f64) -> Option<u64> {
    assert!(level > 0.0 && level < 1.0, "no interval of level {level}");
    let alpha = 1.0 - level;
    if ranked > EXACT_MAX {
        let value = mean - 0.5 + normal_quantile(alpha / 2.0) * variance.sqrt();
        return (value >= 0.0).then(|| value.floor() as u64);
    }
    let ways = law();
    let all: u64 = ways.iter().sum();
    let mut below = 0;
    let rare = ways.iter().take_while(|&&count| {
        below += count;
        2.0 * below as f64 <= alpha * all as f64
    });
    (rare.count() as u64).checked_sub(1)
}

/// Many numbers of which any order statistic can be had without storing them.
trait Counted {
    /// How many there are.
    fn count(&self) -> u64;

    /// How many are at most `limit`.
    fn at_most(&self, limit: f64) -> u64;

    /// The smallest and the largest; only asked where there are some.
    fn range(&self) -> (f64, f64);

    /// The number with `before` smaller or equal ones before it, by bisection over all floats in its range: exact.
    fn nth(&self, before: u64) -> f64 {
        let (low, high) = self.range();
        let (mut low, mut high) = (order_key(low), order_key(high));
        while low < high {
            let middle = low.midpoint(high);
            if self.at_most(of_order_key(middle)) > before {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        math::canonical(of_order_key(low))
    }

    fn median(&self) -> Option<f64> {
        let count = self.count();
        (count > 0).then(|| {
            let upper = self.nth(count / 2);
            if count.is_multiple_of(2) { (self.nth(count / 2 - 1) + upper) / 2.0 } else { upper }
        })
    }

    /// The numbers with `rejected` others before and after them.
    fn ends(&self, rejected: u64) -> Option<(f64, f64)> {
        let upper = self.count().checked_sub(rejected + 1)?;
        Some((self.nth(rejected), self.nth(upper)))
    }
}

const SIGN: u64 = 1 << 63;

/// An integer that orders floats as their values do: the bits of negative ones run backwards.
fn order_key(x: f64) -> u64 {
    let bits = x.to_bits();
    if bits & SIGN == 0 { bits | SIGN } else { !bits }
}

/// The float of an [`order_key`].
fn of_order_key(key: u64) -> f64 {
    f64::from_bits(if key & SIGN == 0 { !key } else { key ^ SIGN })
}

/// How many sums of a number of either sorted sample are at most `limit`. Sums rise with both terms, rounded as they are.
fn sums_at_most(first: &[f64], second: &[f64], limit: f64) -> u64 {
    let mut end = second.len();
    let fitting = first.iter().map(|x| {
        while end > 0 && x + second[end - 1] > limit {
            end -= 1;
        }
        end as u64
    });
    fitting.sum()
}

fn sorted(numbers: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = numbers.collect();
    assert!(sorted.iter().all(|x| x.is_finite()), "only finite numbers have a location");
    sorted.sort_by(f64::total_cmp);
    sorted
}

/// The averages of all pairs of a sample, a number with itself included.
struct Averages {
    /// Half of each number, in ascending order.
    halves: Vec<f64>,
}

impl Averages {
    fn of(sample: &[f64]) -> Self {
        Self { halves: sorted(sample.iter().map(|x| x / 2.0)) }
    }
}

impl Counted for Averages {
    fn count(&self) -> u64 {
        let n = self.halves.len() as u64;
        n * (n + 1) / 2
    }

    fn at_most(&self, limit: f64) -> u64 {
        // Ordered pairs hold every pair twice but those of a number with itself.
        let ordered = sums_at_most(&self.halves, &self.halves, limit);
        let own = self.halves.partition_point(|half| half + half <= limit) as u64;
        (ordered + own) / 2
    }

    fn range(&self) -> (f64, f64) {
        (self.halves[0] * 2.0, self.halves[self.halves.len() - 1] * 2.0)
    }
}

/// The differences of all pairs of two samples.
struct Shifts {
    first: Vec<f64>,
    /// The second sample with its signs changed.
    negated: Vec<f64>,
}

impl Shifts {
    fn of(first: &[f64], second: &[f64]) -> Self {
        Self { first: sorted(first.iter().copied()), negated: sorted(second.iter().map(|y| -y)) }
    }
}

impl Counted for Shifts {
    fn count(&self) -> u64 {
        self.first.len() as u64 * self.negated.len() as u64
    }

    fn at_most(&self, limit: f64) -> u64 {
        sums_at_most(&self.first, &self.negated, limit)
    }

    fn range(&self) -> (f64, f64) {
        let last = |sorted: &[f64]| sorted[sorted.len() - 1];
        (self.first[0] + self.negated[0], last(&self.first) + last(&self.negated))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{rank_sum, signed_rank};
    use crate::rng::{EpisodeSeed, Purpose};

    /// Numbers with ties, or without if `step` is tiny.
    fn numbers(count: usize, step: f64, entity: u64) -> Vec<f64> {
        let mut stream = EpisodeSeed { seed: 3, episode: count as u64 }.stream(Purpose::Resampling, entity);
        (0..count).map(|_| ((stream.uniform() - 0.4) / step).round() * step).collect()
    }

    #[test]
    fn estimates_of_numbers_worked_by_hand() {
        assert_eq!((hodges_lehmann(&[]), hodges_lehmann(&[7.0])), (None, Some(7.0)));
        // Averages of 1, 2, 9: 1, 1½, 2, 5, 5½, 9.
        assert_eq!(hodges_lehmann(&[9.0, 1.0, 2.0]), Some(3.5));
        assert_eq!(hodges_lehmann(&[-9.0, -1.0, -2.0]), Some(-3.5));
        assert_eq!(hodges_lehmann(&[0.0, -0.0, 0.0]).map(f64::to_bits), Some(0));
        // 1 − 4, 1 − 2, 3 − 4, 3 − 2, 8 − 4, 8 − 2: −3, −1, −1, 1, 4, 6.
        assert_eq!(hodges_lehmann_shift(&[8.0, 1.0, 3.0], &[4.0, 2.0]), Some(0.0));
        assert_eq!((hodges_lehmann_shift(&[1.0], &[]), hodges_lehmann_shift(&[], &[1.0])), (None, None));
        // Halving first keeps the sums of huge numbers finite.
        assert_eq!(hodges_lehmann(&[f64::MAX, f64::MAX]), Some(f64::MAX));
    }

    #[test]
    fn order_statistics_are_those_of_the_list_written_out() {
        for (n, step) in [(1, 1e-9), (2, 1e-9), (7, 0.25), (20, 0.1), (33, 1e-9), (60, 0.05)] {
            let (sample, other) = (numbers(n, step, 0), numbers(n + 3, step, 1));
            let mut averages: Vec<f64> =
                (0..n).flat_map(|i| (i..n).map(move |j| (i, j))).map(|(i, j)| (sample[i] + sample[j]) / 2.0).collect();
            averages.sort_by(f64::total_cmp);
            let mut shifts: Vec<f64> = sample.iter().flat_map(|x| other.iter().map(move |y| x - y)).collect();
            shifts.sort_by(f64::total_cmp);
            let (counted, counted_shifts) = (Averages::of(&sample), Shifts::of(&sample, &other));
            assert_eq!((counted.count(), counted_shifts.count()), (averages.len() as u64, shifts.len() as u64));
            for (before, &average) in averages.iter().enumerate() {
                assert_eq!(counted.nth(before as u64), average, "{n} {before}");
            }
            for (before, &shift) in shifts.iter().enumerate() {
                assert_eq!(counted_shifts.nth(before as u64), shift, "{n} {before}");
            }
        }
    }

    #[test]
    fn the_intervals_hold_what_the_tests_do_not_reject() {
        for n in [6, 9, 30, 50, 51, 200] {
            let (sample, other) = (numbers(n, 1e-9, 2), numbers(n / 2 + 4, 1e-9, 3));
            let (low, high) = hodges_lehmann_interval(&sample, 0.95).unwrap();
            let (least, most) = hodges_lehmann_shift_interval(&sample, &other, 0.95).unwrap();
            let gap = 1e-6;
            for (shift, is_inside) in [(low - gap, false), (low + gap, true), (high - gap, true), (high + gap, false)] {
                let shifted: Vec<f64> = sample.iter().map(|x| x - shift).collect();
                assert_eq!(signed_rank(&shifted).p > 0.05, is_inside, "{n} {shift} in {low} {high}");
            }
            for (shift, is_inside) in
                [(least - gap, false), (least + gap, true), (most - gap, true), (most + gap, false)]
            {
                let shifted: Vec<f64> = sample.iter().map(|x| x - shift).collect();
                assert_eq!(rank_sum(&shifted, &other).p > 0.05, is_inside, "{n} {shift} in {least} {most}");
            }
        }
    }

    #[test]
    fn too_few_numbers_have_no_interval() {
        // 2 · 2⁻⁵ > 5 %; of C(6, 3) = 20 splits the rarest has 2 / 20; C(8, 4) = 70: 2 / 70.
        assert_eq!(hodges_lehmann_interval(&[1.0, 2.0, 3.0, 4.0, 5.0], 0.95), None);
        assert_eq!(hodges_lehmann_interval(&[1.0, 2.0, 3.0, 4.0, 5.0, 7.0], 0.95), Some((1.0, 7.0)));
        assert_eq!(hodges_lehmann_shift_interval(&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0], 0.95), None);
        let four = [1.0, 2.0, 3.0, 4.0];
        assert_eq!(hodges_lehmann_shift_interval(&four, &four, 0.95), Some((-3.0, 3.0)));
        for n in [0, 60] {
            assert_eq!(hodges_lehmann_shift_interval(&[], &vec![1.0; n], 0.95), None);
        }
        assert_eq!(hodges_lehmann_interval(&[], 0.95), None);
    }

    #[test]
    fn ten_thousand_numbers_take_no_square_of_memory() {
        let sample = numbers(10_000, 1e-9, 4);
        let found = hodges_lehmann(&sample).unwrap();
        let (low, high) = hodges_lehmann_interval(&sample, 0.95).unwrap();
        // Uniform between −0.4 and 0.6: 0.1, with a standard error of √(1 / 12 / 10⁴).
        assert!(
            (found - 0.1).abs() < 0.015 && low < found && found < high && high - low < 0.015,
            "{low} {found} {high}"
        );
    }
}
