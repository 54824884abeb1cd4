//! The standard normal distribution.

use crate::math;

/// Probability that a standard normal variable exceeds `z`: erfc(z / √2) / 2.
///
/// Computed in the tail itself, never as one minus something, so that small probabilities keep
/// their digits: the relative error is below 1e-15 · (1 + z²), from the rounding of z / √2 alone.
pub fn normal_upper_tail(z: f64) -> f64 {
    math::erfc(z / math::SQRT_2) / 2.0
}

/// The z below which a standard normal variable lies with probability `p`.
///
/// By bisection on [`normal_upper_tail`], to the last bit that it can tell apart: the error is
/// below 1e-15 · (1 + |z|).
///
/// # Panics
/// If `p` is not strictly between 0 and 1.
pub fn normal_quantile(p: f64) -> f64 {
    assert!(p > 0.0 && p < 1.0, "no normal quantile at {p}");
    if p > 0.5 {
        return -normal_quantile(1.0 - p);
    }
    // P(Z > 40) is below the smallest number above 0, so the quantile lies between the two.
    let (mut near, mut far) = (0.0, 40.0);
    for _ in 0..120 {
        let middle = (near + far) / 2.0;
        if normal_upper_tail(middle) > p {
            near = middle;
        } else {
            far = middle;
        }
    }
    -near
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::Z_95;

    #[test]
    fn agrees_with_the_printed_table() {
        // Abramowitz and Stegun, Handbook of Mathematical Functions, table 26.1: P(1), P(2), P(3).
        for (z, below) in [(1.0, 0.841_344_746_068_543), (2.0, 0.977_249_868_051_821), (3.0, 0.998_650_101_968_370)] {
            assert!((1.0 - normal_upper_tail(z) - below).abs() < 1e-15, "{z}");
            assert!((normal_upper_tail(-z) - below).abs() < 1e-15, "{z}");
        }
    }

    #[test]
    fn the_quantile_undoes_the_tail() {
        assert!((normal_quantile(0.975) - Z_95).abs() < 1e-15);
        assert_eq!(normal_quantile(0.5).abs(), 0.0);
        for i in -80..=80 {
            let z = f64::from(i) / 10.0;
            // The probability of a z above 0 is rounded beside 1: that is worth 2⁻⁵⁴ / density.
            let density = math::exp(-z * z / 2.0) / math::TAU.sqrt();
            let slack = 1e-14 + if z > 0.0 { 1.2e-16 / density } else { 0.0 };
            assert!((normal_quantile(normal_upper_tail(-z)) - z).abs() <= slack || z > 6.0, "{z}");
        }
    }

    #[test]
    #[should_panic(expected = "no normal quantile at 1")]
    fn a_certain_event_has_no_quantile() {
        normal_quantile(1.0);
    }
}
