//! Proof that the determinism lints fire: clippy only warns about a mistyped path in `clippy.toml`.
//!
//! Compiled by `scripts/check` alone, with `--cfg lint_fixture`; every line marked `fires` must be refused there.
#![cfg(lint_fixture)]

use nalgebra::{ComplexField, RealField};

#[test]
fn every_line_here_is_refused() {
    let (x, y) = (0.5f64, 0.25f64);
    let _ = x.sin(); // fires
    let _ = x.cos(); // fires
    let _ = x.tan(); // fires
    let _ = x.sin_cos(); // fires
    let _ = x.asin(); // fires
    let _ = x.acos(); // fires
    let _ = x.atan(); // fires
    let _ = f64::atan2(y, x); // fires
    let _ = x.exp(); // fires
    let _ = x.ln(); // fires
    let _ = x.log10(); // fires
    let _ = x.powf(y); // fires
    let _ = x.powi(2); // fires
    let _ = x.cbrt(); // fires
    let _ = x.hypot(y); // fires
    let _ = f64::mul_add(x, y, y); // fires
    let _ = f64::max(x, y); // fires
    let _ = f64::min(x, y); // fires
    let _ = f32::sin(0.5); // fires
    let _ = f32::max(0.5, 0.25); // fires
    let _ = ComplexField::sin(x); // fires
    let _ = ComplexField::powi(x, 2); // fires
    let _ = ComplexField::hypot(x, y); // fires
    let _ = ComplexField::mul_add(x, y, y); // fires
    let _ = RealField::atan2(x, y); // fires
    let _ = RealField::max(x, y); // fires
    let _ = RealField::min(x, y); // fires
    let _ = std::time::Instant::now(); // fires
    let _ = std::time::SystemTime::now(); // fires
    let _ = std::collections::HashMap::<u8, u8>::new(); // fires
    let _ = std::collections::HashSet::<u8>::new(); // fires
}
