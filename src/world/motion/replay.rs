//! Recorded motion: straight from sample to sample.

use super::course::{BOUNCES_MAX, Course, Leg};
use super::{Drive, MotionKind, Span};
use crate::geometry::Vec2;
use crate::math;
use crate::world::obstacles::moving::Mover;
use crate::world::scene::Digest;
use crate::world::statics::Statics;
use std::sync::Arc;

/// Position of a recorded mover at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the episode began, s; may be negative.
    pub time_s: f64,
    /// Centre, grid frame, m.
    pub position: Vec2,
}

/// A recording: straight lines between its samples. The mover is absent before the first sample, in its holes, and after the last
/// sample unless it stays.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// The samples in ascending order of time, no two at the same time; at least one.
    pub samples: Arc<[Sample]>,
    /// Whether the mover stands at its last sample afterwards, instead of vanishing.
    pub stays: bool,
    /// Longest time between two samples that is bridged by a straight walk, s; a longer one is a hole.
    pub gap_max_s: f64,
}

impl Replay {
    /// Whether the mover is present for the whole of a tick.
    fn is_present(&self, tick: Span) -> bool {
        const SLACK_S: f64 = 1e-9;
        let (first, last) = (self.samples[0].time_s, self.samples[self.samples.len() - 1].time_s);
        let end_s = tick.begin_s + tick.lasts_s;
        // From the last sample by the beginning of the tick to the first one by its end.
        let from = self.samples.partition_point(|sample| sample.time_s <= tick.begin_s + SLACK_S).saturating_sub(1);
        let to = self.samples.partition_point(|sample| sample.time_s < end_s - SLACK_S);
        let met = &self.samples[from..(to + 1).min(self.samples.len())];
        tick.begin_s >= first - SLACK_S
            && (self.stays || end_s <= last + SLACK_S)
            && !met.windows(2).any(|pair| self.is_hole(pair))
    }

    /// Whether nothing is known of the mover between two samples.
    fn is_hole(&self, pair: &[Sample]) -> bool {
        pair[1].time_s - pair[0].time_s > self.gap_max_s + 1e-9
    }

    /// Position at `time_s`; before the first and after the last sample, that of the nearest sample.
    fn position(&self, time_s: f64) -> Vec2 {
        let samples = &self.samples;
        let after = samples.partition_point(|sample| sample.time_s <= time_s);
        if after == 0 {
            return samples[0].position;
        }
        let a = samples[after - 1];
        let Some(b) = samples.get(after) else { return a.position };
        a.position + (b.position - a.position) * ((time_s - a.time_s) / (b.time_s - a.time_s))
    }

    /// Times of the samples strictly between `from_s` and `to_s`.
    fn sample_times(&self, from_s: f64, to_s: f64) -> impl Iterator<Item = f64> + '_ {
        let first = self.samples.partition_point(|sample| sample.time_s <= from_s);
        self.samples[first..].iter().map(|sample| sample.time_s).take_while(move |&time_s| time_s < to_s)
    }

    /// The course through a tick.
    fn through(&self, tick: Span) -> Course {
        let end_s = tick.begin_s + tick.lasts_s;
        let mut course = Course::empty(self.position(tick.begin_s), 0.0);
        let mut from_s = tick.begin_s;
        let inside = self.sample_times(tick.begin_s, end_s).take(BOUNCES_MAX);
        for to_s in inside.chain([end_s]) {
            let (from, to) = (self.position(from_s), self.position(to_s));
            let velocity = if to_s > from_s { (to - from) / (to_s - from_s) } else { Vec2::zeros() };
            course.push(Leg { begin_s: from_s - tick.begin_s, from, velocity });
            course.speed = math::max(course.speed, velocity.norm());
            from_s = to_s;
        }
        course
    }
}

impl MotionKind for Replay {
    fn digest(&self, digest: &mut Digest) {
        digest.word(3);
        digest.word(self.samples.len() as u64);
        for sample in self.samples.iter() {
            digest.real(sample.time_s);
            digest.point(sample.position);
        }
        digest.word(u64::from(self.stays));
        // A recording without holes adds nothing, so that it keeps its fingerprint.
        for (number, _) in self.samples.windows(2).enumerate().filter(|(_, pair)| self.is_hole(pair)) {
            digest.word(number as u64);
        }
    }

    fn driver(&self, _: Vec2) -> Box<dyn Drive> {
        Box::new(self.clone())
    }
}

impl Drive for Replay {
    fn begin(&mut self, mover: &mut Mover, tick: Span) {
        let present = self.is_present(tick);
        if present && !mover.present {
            (mover.position, mover.velocity) = self.through(tick).at(0.0);
        }
        mover.present = present;
    }

    /// Zero: a recorded mover never yields.
    fn way(&self, _: &Mover) -> Vec2 {
        Vec2::zeros()
    }

    fn course(&mut self, _: &Mover, _: &Statics<'_>, tick: Span) -> Course {
        self.through(tick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From [0, 0] at 1 s to [2, 0] at 2 s and [2, 1] at 2.5 s.
    fn replay(stays: bool) -> Replay {
        let at = |time_s: f64, x: f64, y: f64| Sample { time_s, position: Vec2::new(x, y) };
        Replay { samples: Arc::new([at(1.0, 0.0, 0.0), at(2.0, 2.0, 0.0), at(2.5, 2.0, 1.0)]), stays, gap_max_s: 1.0 }
    }

    #[test]
    fn places_lie_on_the_lines_between_samples_and_at_the_ends_of_the_data() {
        let replay = replay(false);
        for (time_s, x, y) in [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.25, 0.5, 0.0), (2.25, 2.0, 0.5), (9.0, 2.0, 1.0)] {
            assert!((replay.position(time_s) - Vec2::new(x, y)).norm() < 1e-12, "{time_s}");
        }
    }

    #[test]
    fn a_recorded_mover_is_there_while_the_data_lasts_or_stays() {
        let is_present = |begin_s: f64, stays: bool| replay(stays).is_present(Span { begin_s, lasts_s: 0.5 });
        assert_eq!([0.5, 1.0, 2.0, 2.1].map(|begin_s| is_present(begin_s, false)), [false, true, true, false]);
        assert_eq!([0.5, 1.0, 2.0, 2.1].map(|begin_s| is_present(begin_s, true)), [false, true, true, true]);
    }

    #[test]
    fn in_a_hole_of_the_data_nobody_is_there() {
        // The first second is a hole for anything that bridges less.
        let replay = Replay { gap_max_s: 0.9, ..replay(true) };
        let is_present = |begin_s: f64| replay.is_present(Span { begin_s, lasts_s: 0.1 });
        assert_eq!(
            [0.9, 1.0, 1.5, 1.9, 1.95, 2.0, 2.4, 7.0].map(is_present),
            [false, false, false, false, false, true, true, true]
        );
        let digest = |gap_max_s: f64| {
            let mut digest = Digest::default();
            MotionKind::digest(&Replay { gap_max_s, ..replay.clone() }, &mut digest);
            digest.value()
        };
        assert_eq!((digest(0.9), digest(1.0)), (digest(0.6), digest(9.0)), "the same holes");
        assert_ne!(digest(0.9), digest(1.0));
    }

    #[test]
    fn a_tick_over_a_sample_has_a_corner_there() {
        let course = replay(false).through(Span { begin_s: 1.75, lasts_s: 0.5 });
        let near = |time_s: f64, p: (f64, f64), v: (f64, f64)| {
            let (position, velocity) = course.at(time_s);
            (position - Vec2::new(p.0, p.1)).norm() < 1e-12 && (velocity - Vec2::new(v.0, v.1)).norm() < 1e-12
        };
        assert!(near(0.0, (1.5, 0.0), (2.0, 0.0)) && near(0.125, (1.75, 0.0), (2.0, 0.0)));
        assert!(near(0.25, (2.0, 0.0), (0.0, 2.0)) && near(0.5, (2.0, 0.5), (0.0, 2.0)));
        assert!((course.speed() - 2.0).abs() < 1e-12);
    }
}
