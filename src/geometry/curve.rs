//! Polynomial curves of the plane: the pieces of splines and of minimum-snap paths.
//!
//! A curve is x(u) = c₀ + c₁ u + … + c₇ u⁷ for u from 0 to 1. Arc length has no closed form; it is integrated by the five-point
//! Gauss–Legendre rule on 16 equal spans of u, once, and tabulated. All loops end by their own
//! numbers alone, so that the same curve gives the same bits everywhere.

use super::{Vec2, cross};
use crate::math;
use serde::{Deserialize, Serialize};

/// Number of coefficients of a curve; minimum snap needs degree 7.
pub const COEFFICIENTS: usize = 8;

/// Spans of u whose arc lengths are tabulated.
const SPANS: usize = 16;

/// Nodes and weights of the five-point Gauss–Legendre rule on [−1, 1].
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

/// A polynomial curve; see the module's documentation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    coefficients: [Vec2; COEFFICIENTS],
    /// The point at u = 1: that of the polynomial, or one that rounding keeps it from.
    end: Vec2,
    /// Arc length from u = 0 to u = k / SPANS, m.
    arc_m: [f64; SPANS + 1],
}

impl Curve {
    /// The curve of these coefficients, the constant one first; missing ones are 0.
    ///
    /// # Panics
    /// If there are more than [`COEFFICIENTS`].
    pub fn new(coefficients: &[Vec2]) -> Self {
        assert!(coefficients.len() <= COEFFICIENTS, "a curve has at most {COEFFICIENTS} coefficients");
        let mut curve =
            Self { coefficients: [Vec2::zeros(); COEFFICIENTS], end: Vec2::zeros(), arc_m: [0.0; SPANS + 1] };
        curve.coefficients[..coefficients.len()].copy_from_slice(coefficients);
        curve.end = curve.polynomial(1.0);
        for k in 0..SPANS {
            curve.arc_m[k + 1] = curve.arc_m[k] + curve.arc_between(u_of(k), u_of(k + 1));
        }
        curve
    }

    /// The same curve that ends exactly at `end`, which the polynomial misses by rounding alone.
    #[must_use]
    pub fn ending_at(self, end: Vec2) -> Self {
        Self { end, ..self }
    }

    /// The coefficients, the constant one first.
    pub fn coefficients(&self) -> &[Vec2; COEFFICIENTS] {
        &self.coefficients
    }

    /// The cubic with these control points of Bézier.
    pub fn bezier([a, b, c, d]: [Vec2; 4]) -> Self {
        Self::new(&[a, 3.0 * (b - a), 3.0 * (a - 2.0 * b + c), d - a + 3.0 * (b - c)])
    }

    /// The same points from parameter `first` to `last`, as a curve of its own.
    #[must_use]
    pub fn part(&self, first: f64, last: f64) -> Self {
        // x(first + h u) by Taylor's series, which ends: the k-th coefficient is x⁽ᵏ⁾(first) hᵏ / k!.
        let (mut coefficients, mut scale) = (self.coefficients, 1.0);
        coefficients[0] = self.point(first);
        for (k, coefficient) in coefficients.iter_mut().enumerate().skip(1) {
            scale *= (last - first) / k as f64;
            *coefficient = self.derivative(k, first) * scale;
        }
        Self::new(&coefficients)
    }

    /// The point at parameter `u`.
    pub fn point(&self, u: f64) -> Vec2 {
        if u == 1.0 { self.end } else { self.polynomial(u) }
    }

    fn polynomial(&self, u: f64) -> Vec2 {
        self.coefficients.iter().rev().fold(Vec2::zeros(), |sum, &c| sum * u + c)
    }

    /// The derivative of `order` 1 or more with respect to u, at `u`, in metres.
    pub fn derivative(&self, order: usize, u: f64) -> Vec2 {
        let falling = |k: usize| (0..order).fold(1.0, |product, i| product * (k - i) as f64);
        (order..COEFFICIENTS).rev().fold(Vec2::zeros(), |sum, k| sum * u + self.coefficients[k] * falling(k))
    }

    /// Length of the whole curve, m.
    pub fn length_m(&self) -> f64 {
        self.arc_m[SPANS]
    }

    /// Arc length from the beginning to parameter `u`, m.
    pub fn arc_to(&self, u: f64) -> f64 {
        let span = ((u * SPANS as f64) as usize).min(SPANS - 1);
        self.arc_m[span] + self.arc_between(u_of(span), u)
    }

    /// The parameter at arc length `s_m`, clamped to the ends.
    pub fn parameter_at(&self, s_m: f64) -> f64 {
        let span = (1..SPANS).take_while(|&k| self.arc_m[k] <= s_m).count();
        let (mut low, mut high) = (u_of(span), u_of(span + 1));
        // Newton's steps inside the span, halving where one would leave it.
        let mut u = 0.5 * (low + high);
        for _ in 0..50 {
            let excess = self.arc_m[span] + self.arc_between(u_of(span), u) - s_m;
            if excess > 0.0 {
                high = u;
            } else {
                low = u;
            }
            let stepped = u - excess / self.derivative(1, u).norm();
            let next = if stepped >= low && stepped <= high { stepped } else { 0.5 * (low + high) };
            if next == u {
                break;
            }
            u = next;
        }
        if s_m <= 0.0 {
            0.0
        } else if s_m >= self.length_m() {
            1.0
        } else {
            u
        }
    }

    /// The parameter at which the curve comes nearest to `p`; ties go to the first of the samples.
    pub fn nearest(&self, p: Vec2) -> f64 {
        const SAMPLES: usize = 8 * SPANS;
        let squared = |u: f64| (self.point(u) - p).norm_squared();
        let at = |k: usize| k as f64 / SAMPLES as f64;
        let mut best = (0, f64::INFINITY);
        for k in 0..=SAMPLES {
            let distance = squared(at(k));
            if distance < best.1 {
                best = (k, distance);
            }
        }
        // Between its neighbours the distance has one minimum.
        let (mut low, mut high) = (at(best.0.saturating_sub(1)), at((best.0 + 1).min(SAMPLES)));
        for _ in 0..60 {
            let third = (high - low) / 3.0;
            if squared(low + third) <= squared(high - third) { high -= third } else { low += third }
        }
        0.5 * (low + high)
    }

    /// Signed curvature at parameter `u`, 1/m: positive to the left; 0 where the curve stands still.
    pub fn curvature(&self, u: f64) -> f64 {
        let (first, second) = (self.derivative(1, u), self.derivative(2, u));
        let speed = first.norm();
        if speed == 0.0 { 0.0 } else { cross(first, second) / (speed * speed * speed) }
    }

    /// A bound of the distance between the curve and the chord of any of `chords` equal parts of u, m: h² / 8 times
    /// the largest |x''|.
    pub fn sagitta_bound_m(&self, chords: u32) -> f64 {
        let bend =
            (2..COEFFICIENTS).map(|k| (k * (k - 1)) as f64 * self.coefficients[k].norm()).fold(0.0, |a, b| a + b);
        let step = 1.0 / f64::from(chords);
        step * step * bend / 8.0
    }

    /// Chords of equal parts of u that stay within `sagitta_m` of the curve: 1 to 10⁴.
    pub fn chords_within(&self, sagitta_m: f64) -> u32 {
        math::clamp((self.sagitta_bound_m(1) / sagitta_m).sqrt().ceil(), 1.0, 1e4) as u32
    }

    fn arc_between(&self, from: f64, to: f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let speed = |node: f64| self.derivative(1, middle + half * node).norm();
        half * GAUSS.iter().fold(0.0, |sum, &(node, weight)| sum + weight * speed(node))
    }
}

fn u_of(span: usize) -> f64 {
    span as f64 / SPANS as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve() -> Curve {
        let v = Vec2::new;
        Curve::bezier([v(0.0, 0.0), v(1.0, 2.0), v(3.0, -1.0), v(4.0, 1.0)])
    }

    #[test]
    fn a_line_as_a_curve_has_the_measures_of_the_line() {
        let line = Curve::new(&[Vec2::new(1.0, 1.0), Vec2::new(3.0, 4.0)]);
        assert!((line.length_m() - 5.0).abs() < 1e-12);
        assert!((line.point(line.parameter_at(2.5)) - Vec2::new(2.5, 3.0)).norm() < 1e-12);
        assert!((line.arc_to(line.nearest(Vec2::new(1.0, 6.0))) - 4.0).abs() < 1e-7); // foot of (0, 5) on (3, 4)/5: 20/5
        assert_eq!((line.curvature(0.3), line.chords_within(1e-3)), (0.0, 1));
    }

    #[test]
    fn length_curvature_and_derivatives_are_those_of_dense_sampling() {
        let curve = curve();
        let n = 20_000;
        let at = |k: i32| curve.point(f64::from(k) / f64::from(n));
        let sampled: f64 = (0..n).map(|k| (at(k + 1) - at(k)).norm()).sum();
        assert!((curve.length_m() - sampled).abs() < 1e-6, "{} {sampled}", curve.length_m());
        let h = 1e-5;
        for u in [0.1, 0.5, 0.9] {
            let slope = (curve.point(u + h) - curve.point(u - h)) / (2.0 * h);
            let bend = (curve.point(u + h) - 2.0 * curve.point(u) + curve.point(u - h)) / (h * h);
            assert!((curve.derivative(1, u) - slope).norm() < 1e-8);
            assert!((curve.derivative(2, u) - bend).norm() < 1e-4);
            let expected = cross(slope, bend) / (slope.norm() * slope.norm_squared());
            assert!((curve.curvature(u) - expected).abs() < 1e-4);
        }
        let third = (curve.derivative(2, 0.5 + h) - curve.derivative(2, 0.5 - h)) / (2.0 * h);
        assert!((curve.derivative(3, 0.5) - third).norm() < 1e-6);
    }

    #[test]
    fn parameters_and_arc_lengths_are_inverse() {
        let curve = curve();
        for k in 0..=40 {
            let s = curve.length_m() * f64::from(k) / 40.0;
            assert!((curve.arc_to(curve.parameter_at(s)) - s).abs() < 1e-9, "{s}");
        }
        assert_eq!((curve.parameter_at(-1.0), curve.parameter_at(99.0)), (0.0, 1.0));
    }

    #[test]
    fn chords_stay_within_the_sagitta_and_the_nearest_point_is_that_of_dense_sampling() {
        let curve = curve();
        let chords = curve.chords_within(1e-3);
        let at = |k: f64| curve.point(k / f64::from(chords));
        for k in 0..chords {
            for part in 0..=10 {
                let u = f64::from(k) + f64::from(part) / 10.0;
                let chord = super::super::point_segment_distance(at(u), at(f64::from(k)), at(f64::from(k + 1)));
                assert!(chord <= 1e-3, "{chord}");
            }
        }
        for p in [Vec2::new(2.0, 3.0), Vec2::new(1.0, 0.0), Vec2::new(5.0, 5.0), Vec2::new(-1.0, -1.0)] {
            let found = (curve.point(curve.nearest(p)) - p).norm();
            let sampled = (0..=20_000).map(|k| (curve.point(f64::from(k) / 20_000.0) - p).norm()).fold(9e9, math::min);
            assert!((found - sampled).abs() < 1e-6, "{found} {sampled}");
        }
    }
}
