//! The only transcendental functions of the crate, so that every build agrees.
//!
//! The standard library's `sin`, `cos`, … call the platform's libm, which differs between
//! systems and processors; its `max`/`min` differ on ±0 between debug and release. Everything
//! that can reach a result goes through the functions below instead: `libm`'s portable code,
//! and comparisons whose answer on zeros is specified. `clippy.toml` forbids the others.
//! (`sqrt`, `floor`, `ceil`, `round`, `abs` are exact by IEEE 754 and stay the standard ones.)

pub use core::f64::consts::{FRAC_PI_2, PI, SQRT_2, TAU};

/// Sine of an angle in radians.
pub fn sin(x: f64) -> f64 {
    libm::sin(x)
}

/// Cosine of an angle in radians.
pub fn cos(x: f64) -> f64 {
    libm::cos(x)
}

/// Sine and cosine of an angle in radians.
pub fn sin_cos(x: f64) -> (f64, f64) {
    (libm::sin(x), libm::cos(x))
}

/// Tangent of an angle in radians.
pub fn tan(x: f64) -> f64 {
    libm::tan(x)
}

/// Arc tangent in (−π/2, π/2).
pub fn atan(x: f64) -> f64 {
    libm::atan(x)
}

/// Direction of the vector (x, y) in (−π, π]; 0 for the zero vector with positive zeros.
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Arc cosine in [0, π]; the argument is clamped to [−1, 1].
pub fn acos(x: f64) -> f64 {
    libm::acos(clamp(x, -1.0, 1.0))
}

/// e to the power x.
pub fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// Natural logarithm.
pub fn ln(x: f64) -> f64 {
    libm::log(x)
}

/// Complementary error function: 2/√π times the integral of e^(−t²) from x on; below 1 ulp off.
pub fn erfc(x: f64) -> f64 {
    libm::erfc(x)
}

/// √(x² + y²), by the plain formula: exact operations only, no rescaling.
pub fn hypot(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

/// The larger of two numbers; `b` where they compare equal (so also for ±0).
pub fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two numbers; `b` where they compare equal (so also for ±0).
pub fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// `x` limited to [low, high], both ends included.
pub fn clamp(x: f64, low: f64, high: f64) -> f64 {
    if x < low {
        low
    } else if x > high {
        high
    } else {
        x
    }
}

/// A finite number as it may enter a digest or a table: −0.0 becomes 0.0.
///
/// # Panics
/// If `x` is not finite: a result was computed from an undefined value.
pub fn canonical(x: f64) -> f64 {
    assert!(x.is_finite(), "a result is not finite: {x}");
    if x == 0.0 { 0.0 } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_are_specified() {
        assert_eq!(max(0.0, -0.0).to_bits(), (-0.0f64).to_bits());
        assert_eq!(min(-0.0, 0.0).to_bits(), 0.0f64.to_bits());
        assert_eq!(canonical(-0.0).to_bits(), 0.0f64.to_bits());
    }

    #[test]
    fn fixed_bits_of_the_portable_functions() {
        // Bits written down once; a build that disagrees is not comparable with the others.
        assert_eq!(sin(0.7).to_bits(), 0x3fe4_9d6e_6946_19b8);
        assert_eq!(cos(2.3).to_bits(), 0xbfe5_5222_1730_2fe0);
        assert_eq!(atan2(-1.0, 3.0).to_bits(), 0xbfd4_978f_a326_9ee1);
        assert_eq!(erfc(0.5).to_bits(), 0x3fde_b021_47ce_245c);
    }

    #[test]
    #[should_panic(expected = "not finite")]
    fn a_not_a_number_never_reaches_a_result() {
        canonical(f64::NAN);
    }
}
