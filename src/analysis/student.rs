//! Student's t distribution.

use crate::math;

/// Probability that a t variable of `freedom` degrees of freedom exceeds `t`.
///
/// Half of the regularised incomplete beta function I_x(freedom / 2, ½) at x = freedom / (freedom + t²), by its continued
/// fraction: M. Abramowitz and I. A. Stegun, *Handbook of Mathematical Functions*, 26.7.1 and 26.5.8. Computed in the tail itself
/// wherever it is small. Relative error below 1e-13 up to 1000 degrees of freedom, below 1e-10 up to 100,000.
///
/// # Panics
/// If `t` is not a number or there is no degree of freedom.
pub fn student_upper_tail(t: f64, freedom: u64) -> f64 {
    assert!(!t.is_nan() && freedom > 0, "no t distribution: {t} with {freedom} degrees of freedom");
    if t < 0.0 {
        return 1.0 - student_upper_tail(-t, freedom);
    }
    if t.is_infinite() {
        return 0.0;
    }
    let a = freedom as f64 / 2.0;
    let squared = t * t / freedom as f64;
    // x = 1 / (1 + t²/freedom), and 1 − x without cancellation.
    let (x, rest) = (1.0 / (1.0 + squared), squared / (1.0 + squared));
    let front = math::exp(-a * math::ln(1.0 + squared)) * rest.sqrt() / beta_half(freedom);
    if x < (a + 1.0) / (a + 2.5) {
        front / a * continued_fraction(a, 0.5, x) / 2.0
    } else {
        0.5 - front / 0.5 * continued_fraction(0.5, a, rest) / 2.0
    }
}

/// The t below which a variable of `freedom` degrees of freedom lies with probability `p`, by bisection on
/// [`student_upper_tail`].
///
/// # Panics
/// If `p` is not strictly between 0 and 1 or there is no degree of freedom.
pub fn student_quantile(p: f64, freedom: u64) -> f64 {
    assert!(p > 0.0 && p < 1.0, "no quantile at {p}");
    if p > 0.5 {
        return -student_quantile(1.0 - p, freedom);
    }
    let mut far = 1.0;
    while student_upper_tail(far, freedom) > p {
        far *= 2.0;
    }
    let mut near = 0.0;
    for _ in 0..120 {
        let middle = (near + far) / 2.0;
        if student_upper_tail(middle, freedom) > p {
            near = middle;
        } else {
            far = middle;
        }
    }
    -near
}

/// The beta function B(freedom / 2, ½) = Γ(freedom / 2) √π / Γ((freedom + 1) / 2), by B(a + 1, ½) = B(a, ½) a / (a + ½) from
/// B(½, ½) = π and B(1, ½) = 2.
fn beta_half(freedom: u64) -> f64 {
    let (start, mut beta) = if freedom.is_multiple_of(2) { (2, 2.0) } else { (1, math::PI) };
    for twice in (start..freedom).step_by(2) {
        beta *= twice as f64 / (twice + 1) as f64;
    }
    beta
}

/// The continued fraction of I_x(a, b) after its leading factor, evaluated forwards by Lentz's method.
fn continued_fraction(a: f64, b: f64, x: f64) -> f64 {
    const STEPS_MAX: u32 = 100_000;
    let mut c = 1.0;
    let mut d = 1.0 / (1.0 - (a + b) * x / (a + 1.0));
    let mut value = d;
    for step in 1..STEPS_MAX {
        let m = f64::from(step);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut change = 1.0;
        for coefficient in [even, odd] {
            d = 1.0 / (1.0 + coefficient * d);
            c = 1.0 + coefficient / c;
            change = c * d;
            value *= change;
        }
        if (change - 1.0).abs() < 3e-16 {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::normal_upper_tail;

    #[test]
    fn closed_forms_of_one_and_two_degrees_of_freedom() {
        for t in [0.0, 1e-9, 0.3, 1.0, 2.5, 12.0, 300.0, 1e7] {
            // One: Cauchy, atan(1 / t) / π. Two: (1 − t / √(2 + t²)) / 2 = 1 / (√(2 + t²) (√(2 + t²) + t)).
            let cauchy = math::atan2(1.0, t) / math::PI;
            let root = (2.0 + t * t).sqrt();
            for (freedom, expected) in [(1, cauchy), (2, 1.0 / (root * (root + t)))] {
                let found = student_upper_tail(t, freedom);
                assert!((found / expected - 1.0).abs() < 1e-14, "{t} {freedom}: {found}, not {expected}");
                assert!((student_upper_tail(-t, freedom) + found - 1.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn many_degrees_of_freedom_come_near_the_normal_law() {
        // The next term of the expansion is z (z² + 1) φ(z) / (4 n).
        for z in [0.5, 1.96, 4.0] {
            let n = 1_000_000;
            let density = math::exp(-z * z / 2.0) / math::TAU.sqrt();
            let expected = normal_upper_tail(z) + z * (z * z + 1.0) * density / (4.0 * n as f64);
            assert!((student_upper_tail(z, n) / expected - 1.0).abs() < 1e-8, "{z}");
        }
        assert_eq!(student_upper_tail(f64::INFINITY, 3), 0.0);
        assert_eq!((student_upper_tail(0.0, 3), student_quantile(0.5, 3).abs()), (0.5, 0.0));
    }
}
