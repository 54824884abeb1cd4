//! Several tests at once.

use crate::math;

/// Holm's step-down adjustment: p-values to be compared with the error rate of the whole family.
///
/// With p₍₁₎ ≤ … ≤ p₍ₘ₎ the adjusted p₍ᵢ₎ is the largest of min(1, (m − j + 1) p₍ⱼ₎) over j ≤ i;
/// answers are in the order of the input, equal p-values get equal answers. Rejecting where the
/// adjusted value is at most α keeps the probability of *any* false rejection at α, whatever the
/// dependence between the tests, and rejects all that Bonferroni's does. The family is every test
/// of one question (all pairs of stacks on one metric, say), decided before looking. S. Holm, *A simple
/// sequentially rejective multiple test procedure*, Scandinavian Journal of Statistics 6, 1979;
/// adjusted values as in S. P. Wright, *Adjusted p-values for simultaneous inference*, Biometrics
/// 48, 1992.
///
/// # Panics
/// If a p-value is outside [0, 1].
pub fn holm(p: &[f64]) -> Vec<f64> {
    assert!(p.iter().all(|p| (0.0..=1.0).contains(p)), "p-values lie between 0 and 1: {p:?}");
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut adjusted = vec![0.0; p.len()];
    let mut floor = 0.0;
    for (rejected, &index) in order.iter().enumerate() {
        let still_open = (p.len() - rejected) as f64;
        floor = math::max(floor, math::min(still_open * p[index], 1.0));
        adjusted[index] = floor;
    }
    adjusted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_numbers_worked_by_hand() {
        assert_eq!(holm(&[]), [0.0; 0]);
        assert_eq!(holm(&[0.25]), [0.25]);
        // In order 0.0625 · 4 = 0.25; 0.125 · 3 = 0.375; 0.1875 · 2 = 0.375; 0.25 · 1, raised to 0.375.
        assert_eq!(holm(&[0.25, 0.0625, 0.1875, 0.125]), [0.375, 0.25, 0.375, 0.375]);
        assert_eq!(holm(&[0.5, 0.5, 0.75]), [1.0, 1.0, 1.0]);
    }

    #[test]
    fn decides_like_the_step_down_procedure() {
        // Holm's own form: go up the ordered p-values while p₍ᵢ₎ ≤ α / (m − i + 1); reject those passed.
        let mut stream = crate::rng::EpisodeSeed { seed: 1, episode: 0 }.stream(crate::rng::Purpose::Resampling, 1);
        for _ in 0..2000 {
            let p: Vec<f64> = (0..1 + stream.index(12)).map(|_| stream.uniform() * stream.uniform() * 0.1).collect();
            let mut sorted = p.clone();
            sorted.sort_by(f64::total_cmp);
            let passed = (0..p.len()).take_while(|&i| sorted[i] <= 0.05 / (p.len() - i) as f64).count();
            let rejected = holm(&p).iter().filter(|&&adjusted| adjusted <= 0.05).count();
            assert_eq!(rejected, passed, "{p:?}");
        }
    }
}
