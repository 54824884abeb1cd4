//! First contact and lowest clearance over a stretch of time, from a distance that is exact at any moment and a bound
//! of its rate of change.
//!
//! Both use only this: where the gap between two surfaces is g and cannot shrink faster than `rate`, it stays
//! positive for g / rate. No sub-steps are assumed, so speed and size of the bodies do not matter.

use crate::geometry::outline::SLACK_M;
use crate::math;

/// Contacts shallower than this may be stepped over, m; half of the promised millimetre.
const GRAZE_M: f64 = 0.5e-3;

/// Largest error by which the lowest clearance may be reported below the truth, m.
const PRECISION_M: f64 = 1e-3;

/// Halvings of the interval that brackets a contact: 0.1 s · 2⁻⁴⁵ is 3 femtoseconds.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{EpisodeSeed, Purpose};

    /// Gap of two points' discs on straight lines: |d + u t| − r.
    fn flyby(d: (f64, f64), u: (f64, f64), r: f64) -> impl Fn(f64) -> f64 {
        move |t| math::hypot(d.0 + u.0 * t, d.1 + u.1 * t) - r
    }

    #[test]
    fn contact_of_two_discs_comes_at_the_root_of_the_quadratic() {
        // Head on: 1 m apart, radii sum 0.4, closing at 10 m/s: 0.06 s.
        let time = first_contact(flyby((1.0, 0.0), (-10.0, 0.0), 0.4), 10.0, 0.1).unwrap();
        assert!((time - 0.06).abs() < 1e-9, "{time}");
        // Offset 0.24 of 0.4: contact where the distance along is 0.32, after 0.68 m.
        let time = first_contact(flyby((1.0, 0.24), (-10.0, 0.0), 0.4), 10.0, 0.1).unwrap();
        assert!((time - 0.068).abs() < 1e-9, "{time}");
    }

    #[test]
    fn a_graze_counts_from_a_millimetre_of_depth_and_a_miss_never() {
        let mut stream = EpisodeSeed { seed: 1, episode: 0 }.stream(Purpose::Planner, 0);
        for _ in 0..5000 {
            let (speed, r) = (stream.range(0.1, 40.0), stream.range(0.05, 2.0));
            let depth = stream.range(-2e-3, 4e-3);
            let ahead = r + stream.range(0.0, 1.0);
            let gap = flyby((ahead, r - depth), (-speed, 0.0), r);
            let rate = speed * stream.range(1.0, 3.0);
            let found = first_contact(&gap, rate, ahead / speed + 0.1);
            if depth > 1e-3 {
                assert!(found.is_some(), "depth {depth} at {speed} m/s missed");
            }
            if depth < 0.0 {
                assert!(found.is_none(), "gap {} at {speed} m/s taken for a contact", -depth);
            }
            if let Some(time) = found {
                assert!(gap(time) < 0.0 && gap(time) > -1e-6, "{}", gap(time));
            }
        }
    }

    #[test]
    fn the_lowest_gap_is_bounded_from_below_and_within_a_millimetre() {
        let mut stream = EpisodeSeed { seed: 2, episode: 0 }.stream(Purpose::Planner, 0);
        for _ in 0..5000 {
            let (speed, r) = (stream.range(0.1, 10.0), stream.range(0.05, 0.5));
            let (ahead, beside) = (stream.range(-0.5, 1.0), r + stream.range(0.0, 0.5));
            let gap = flyby((ahead, beside), (-speed, 0.0), r);
            let [from, to] = [0.0, 0.1].map(|time_s| Sample { time_s, gap_m: gap(time_s) });
            let mut seen = math::min(from.gap_m, to.gap_m);
            let low = lowest(&gap, speed, from, to, f64::INFINITY, &mut seen);
            let truth = gap(math::clamp(ahead / speed, 0.0, 0.1));
            assert!(low <= truth + 1e-12 && low >= truth - PRECISION_M - 1e-12, "{low} for {truth}");
        }
    }

    #[test]
    fn a_bound_that_is_high_enough_is_not_refined() {
        let evaluations = core::cell::Cell::new(0);
        let gap = |_| {
            evaluations.set(evaluations.get() + 1);
            1.0
        };
        let [from, to] = [0.0, 0.1].map(|time_s| Sample { time_s, gap_m: 1.0 });
        assert!((lowest(&gap, 4.0, from, to, 0.5, &mut 1.0) - 0.8).abs() < 1e-12);
        assert_eq!(evaluations.get(), 0);
        lowest(&gap, 4.0, from, to, f64::INFINITY, &mut 1.0);
        // 0.4 m of motion, leaves of at most 2 mm each: no more than 256 halvings.
        assert!((1..256).contains(&evaluations.get()), "{}", evaluations.get());
    }
}
