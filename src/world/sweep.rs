//! First contact and lowest clearance over a stretch of time, from a distance that is exact at any moment and a bound
//! of its rate of change.
//!
//! Both use only this: where the gap between two surfaces is g and cannot shrink faster than `rate`, it stays
//! positive for g / rate. No sub-steps are assumed, so speed and size of the bodies do not matter.

use super::obstacle::SLACK_M;
use crate::math;

/// Contacts shallower than this may be stepped over, m; half of the promised millimetre.
const GRAZE_M: f64 = 0.5e-3;

/// How far below the truth the lowest clearance may be reported, m.
const PRECISION_M: f64 = 1e-3;

/// Halvings of the interval that brackets a contact: 0.1 s · 2⁻⁴⁵ is below a femtosecond of simulated time... of driving.
const HALVINGS: u32 = 45;

/// The first moment in [0, duration] at which the gap is negative (by more than a nanometre).
///
/// Conservative advancement: from a gap g it goes on by max(g, 0.5 mm) / rate. A contact deeper than 0.5 mm lasts for at
/// least twice the shortest step, so it cannot be missed; what is reported is a true overlap, so there
/// are no false contacts. Then the moment is bracketed by halving.
pub(super) fn first_contact(gap: impl Fn(f64) -> f64, rate: f64, duration: f64) -> Option<f64> {
    let touches = |g: f64| g < -SLACK_M;
    let (mut t, mut g) = (0.0, gap(0.0));
    if touches(g) {
        return Some(0.0);
    }
    while t < duration && rate > 0.0 {
        let next = math::min(t + math::max(g, GRAZE_M) / rate, duration);
        g = gap(next);
        if touches(g) {
            let (mut clear, mut contact) = (t, next);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (clear + contact);
                if touches(gap(middle)) {
                    contact = middle;
                } else {
                    clear = middle;
                }
            }
            return Some(contact);
        }
        t = next;
    }
    None
}

/// A gap at a moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    pub(super) time_s: f64,
    pub(super) gap_m: f64,
}

/// A lower bound of the gap between two samples, never above the truth.
///
/// Between two samples the gap is at least (g₁ + g₂ − rate · (t₂ − t₁)) / 2 (Piyavskii 1972, Shubert 1972). Intervals are
/// halved until that is within a millimetre of `seen`, the lowest gap sampled so far, or no lower than `enough`:
/// below that nobody needs to know.
pub(super) fn lowest(
    gap: &impl Fn(f64) -> f64,
    rate: f64,
    from: Sample,
    to: Sample,
    enough: f64,
    seen: &mut f64,
) -> f64 {
    let bound = bound(rate, from, to);
    if bound >= enough || bound >= *seen - PRECISION_M {
        return bound;
    }
    let time_s = 0.5 * (from.time_s + to.time_s);
    let middle = Sample { time_s, gap_m: gap(time_s) };
    *seen = math::min(*seen, middle.gap_m);
    let first = lowest(gap, rate, from, middle, enough, seen);
    math::min(first, lowest(gap, rate, middle, to, enough, seen))
}

/// The lower bound that two samples alone give.
pub(super) fn bound(rate: f64, from: Sample, to: Sample) -> f64 {
    0.5 * (from.gap_m + to.gap_m - rate * (to.time_s - from.time_s))
}
