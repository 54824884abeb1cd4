//! Confidence intervals of rates.

use crate::math;

/// The 97.5 % quantile of the standard normal distribution: two-sided 95 %.
pub const Z_95: f64 = 1.959_963_984_540_054;

/// The Wilson score interval (low, high) of a rate; `None` without trials.
///
/// The two solutions p of |successes/n − p| = z √(p (1 − p) / n), in closed form
/// (s + z²/2 ± z √(s (n − s)/n + z²/4)) / (n + z²). Inside [0, 1]; exactly 0 below no success and
/// exactly 1 above no failure. E. B. Wilson, *Probable inference, the law of succession, and
/// statistical inference*, JASA 22, 1927; recommended in R. G. Newcombe, *Two-sided confidence
/// intervals for the single proportion*, Statistics in Medicine 17, 1998.
///
/// # Panics
/// If there are more successes than trials or `z` is not positive.
pub fn wilson(successes: u64, trials: u64, z: f64) -> Option<(f64, f64)> {
    assert!(successes <= trials, "{successes} successes in {trials} trials");
    assert!(z > 0.0, "the quantile {z} is not positive");
    if trials == 0 {
        return None;
    }
    let (s, n) = (successes as f64, trials as f64);
    let centre = s + z * z / 2.0;
    let half = z * (s * (n - s) / n + z * z / 4.0).sqrt();
    let scale = n + z * z;
    let low = if successes == 0 { 0.0 } else { math::clamp((centre - half) / scale, 0.0, 1.0) };
    let high = if successes == trials { 1.0 } else { math::clamp((centre + half) / scale, 0.0, 1.0) };
    Some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The interval's ends by bisection on its defining equation, without the closed form.
    fn by_bisection(successes: u64, trials: u64, z: f64) -> (f64, f64) {
        let (n, rate) = (trials as f64, successes as f64 / trials as f64);
        // Positive while p is nearer to the rate than z standard errors of p.
        let inside = |p: f64| (rate - p).abs() <= z * (p * (1.0 - p) / n).sqrt();
        let end = |outer: f64| {
            let (mut near, mut far) = (rate, outer);
            for _ in 0..200 {
                let middle = (near + far) / 2.0;
                if inside(middle) {
                    near = middle;
                } else {
                    far = middle;
                }
            }
            near
        };
        (end(0.0), end(1.0))
    }

    #[test]
    fn agrees_with_the_values_newcombe_published() {
        // Newcombe 1998, table I, method 3 (score without continuity correction).
        for (s, n, low, high) in
            [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)]
        {
            let (l, h) = wilson(s, n, Z_95).unwrap();
            assert!((l - low).abs() < 5e-5 && (h - high).abs() < 5e-5, "{s}/{n}: {l} {h}");
        }
    }

    #[test]
    fn solves_its_defining_equation() {
        for n in [1u64, 2, 7, 30, 120, 1000] {
            for s in (1..n).step_by(1 + n as usize / 40) {
                let (l, h) = wilson(s, n, Z_95).unwrap();
                let (low, high) = by_bisection(s, n, Z_95);
                assert!((l - low).abs() < 1e-9 && (h - high).abs() < 1e-9, "{s}/{n}: {l} {low} {h} {high}");
            }
        }
    }

    #[test]
    fn a_rate_of_116_in_120_by_hand() {
        // z² = 3.841459; centre = 116 + 1.920729 = 117.920729; 116·4/120 = 3.866667;
        // half = 1.959964 √(3.866667 + 0.960365) = 4.306137; scale = 123.841459.
        let (low, high) = wilson(116, 120, Z_95).unwrap();
        assert!((low - (117.920_729 - 4.306_137) / 123.841_459).abs() < 1e-6, "{low}");
        assert!((high - (117.920_729 + 4.306_137) / 123.841_459).abs() < 1e-6, "{high}");
    }

    #[test]
    fn ends_are_exact_and_nothing_is_said_without_trials() {
        assert_eq!(wilson(0, 0, Z_95), None);
        assert_eq!(wilson(0, 5, Z_95).unwrap().0.to_bits(), 0.0f64.to_bits());
        assert_eq!(wilson(5, 5, Z_95).unwrap().1.to_bits(), 1.0f64.to_bits());
        // Mirrored: the interval of failures is one minus that of successes.
        let (low, high) = wilson(3, 17, Z_95).unwrap();
        let (mirror_low, mirror_high) = wilson(14, 17, Z_95).unwrap();
        assert!((low - (1.0 - mirror_high)).abs() < 1e-15 && (high - (1.0 - mirror_low)).abs() < 1e-15);
    }
}
