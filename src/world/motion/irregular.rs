//! Motion straight on for a while, then in another uniformly random direction at another speed (gao2025, G-A21).

use super::uniform::StraightOn;
use super::{Course, Drive, Motion, MotionKind, MotionSpec, Span};
use crate::geometry::{Vec2, direction};
use crate::math;
use crate::rng::Stream;
use crate::settings::Entry;
use crate::settings::quantity::{NonNegative, Positive};
use crate::world::TIME_SLACK_S;
use crate::world::obstacles::moving::Mover;
use crate::world::scene::{Digest, SceneError, check_range};
use crate::world::statics::Statics;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry =
    Entry { summary: "straight on for a while, then another way at another speed (gao2025, G-A21)" };

/// Parameters of an erratic motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Range [shortest, longest] of the time between two changes, s; rounded to tenths of a second. Default: [2, 5].
    pub interval_s: [Positive; 2],
    /// Range [lowest, highest] of the speed after a change, m/s. Default: that from which the first speed was drawn, or the
    /// given first speed.
    pub speed_mps: Option<[NonNegative; 2]>,
}

impl Default for Params {
    fn default() -> Self {
        Self { interval_s: [Positive::new(2.0), Positive::new(5.0)], speed_mps: None }
    }
}

impl MotionSpec for Params {
    fn check(&self, key: &str) -> Result<(), SceneError> {
        check_range(&format!("{key}.interval_s"), self.interval_s.map(Positive::get))?;
        self.speed_mps.map_or(Ok(()), |speed| check_range(&format!("{key}.speed_mps"), speed.map(NonNegative::get)))
    }

    fn motion(&self, speed_mps: [f64; 2], stream: Stream) -> Motion {
        let speed_mps = self.speed_mps.map_or(speed_mps, |speed| speed.map(NonNegative::get));
        Irregular { interval_s: self.interval_s.map(Positive::get), speed_mps, stream }.into()
    }
}

/// Piecewise constant velocity: after each interval a new, uniformly random heading and a new speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Irregular {
    /// Range of the time between two changes, s; rounded to whole tenths of a second, at least one.
    pub interval_s: [f64; 2],
    /// Range of the speed, m/s.
    pub speed_mps: [f64; 2],
    /// The mover's own stream; change k draws from its place k, whatever was drawn before and whatever a tick lasts.
    pub stream: Stream,
}

/// Unit to which the time between two changes is rounded, s. It is not the control period, so that a mover goes the same way
/// at any control period.
const UNIT_S: f64 = 0.1;

/// One stretch of an irregular motion.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stretch {
    /// Duration, in units of [`UNIT_S`].
    units: u32,
    velocity: Vec2,
}

impl Irregular {
    /// Stretch `number` of the motion; of stretch 0 only the duration counts, for the mover has its first velocity already.
    fn stretch(&self, number: u32) -> Stretch {
        let mut stream = self.stream.clone();
        let draws = stream.at_tick(number);
        let [shortest, longest] = self.interval_s;
        let units = (draws.range(shortest, longest) / UNIT_S).round().clamp(1.0, 1e9) as u32;
        let heading = draws.range(-math::PI, math::PI);
        let [slowest, fastest] = self.speed_mps;
        Stretch { units, velocity: draws.range(slowest, fastest) * direction(heading) }
    }
}

impl MotionKind for Irregular {
    fn digest(&self, digest: &mut Digest) {
        digest.word(1);
        self.interval_s.iter().chain(&self.speed_mps).for_each(|&x| digest.real(x));
        digest.word(self.stream.clone().at_tick(0).bits());
    }

    fn driver(&self, velocity: Vec2) -> Box<dyn Drive> {
        let ends = self.stretch(0).units;
        Box::new(Wanderer { motion: self.clone(), straight: StraightOn { cruise: velocity }, number: 0, ends })
    }
}

/// Driver of an irregular motion.
#[derive(Debug)]
struct Wanderer {
    motion: Irregular,
    straight: StraightOn,
    /// Number of the current stretch.
    number: u32,
    /// End of the current stretch, in units of [`UNIT_S`].
    ends: u32,
}

impl Wanderer {
    /// End of the current stretch, s after the beginning of the episode.
    fn ends_s(&self) -> f64 {
        f64::from(self.ends) * UNIT_S
    }

    fn begin_next(&mut self) {
        self.number += 1;
        let next = self.motion.stretch(self.number);
        self.ends = self.ends.saturating_add(next.units);
        self.straight.cruise = next.velocity;
    }
}

impl Drive for Wanderer {
    fn begin(&mut self, mover: &mut Mover, tick: Span) {
        while self.ends_s() <= tick.begin_s + TIME_SLACK_S {
            self.begin_next();
            mover.velocity = self.straight.cruise;
        }
    }

    fn way(&self, mover: &Mover) -> Vec2 {
        self.straight.way(mover)
    }

    /// The course through a tick, with a corner at every change of velocity within it.
    fn course(&mut self, mover: &Mover, statics: &Statics<'_>, tick: Span) -> Course {
        let mut course = Course::empty(mover.position, 0.0);
        let mut from_s = 0.0;
        loop {
            let change_s = self.ends_s() - tick.begin_s;
            let changes = change_s < tick.lasts_s - TIME_SLACK_S;
            let until_s = if changes { change_s } else { tick.lasts_s };
            course.go_on(mover, &mut self.straight.cruise, statics, from_s, until_s);
            if !changes {
                return course;
            }
            if course.is_full() {
                // The change comes with the next tick.
                course.stand(change_s);
                return course;
            }
            from_s = change_s;
            self.begin_next();
        }
    }

    fn set_velocity(&mut self, velocity: Vec2) {
        self.straight.set_velocity(velocity);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::OccupancyGrid;
    use crate::rng::{EpisodeSeed, Purpose};
    use crate::world::scene::tests::{scene_of, states};
    use crate::world::statics::StaticMap;

    fn motion() -> Irregular {
        let stream = EpisodeSeed { seed: 3, episode: 1 }.stream(Purpose::Motion, 7);
        Irregular { interval_s: [1.0, 3.0], speed_mps: [0.4, 0.6], stream }
    }

    #[test]
    fn a_stretch_is_addressed_by_its_number_alone() {
        let (motion, mut used) = (motion(), motion());
        used.stream.uniform();
        for number in [5, 0, 5, 2] {
            assert_eq!(used.stretch(number), motion.stretch(number));
        }
        assert_ne!(motion.stretch(0), motion.stretch(1));
    }

    #[test]
    fn the_velocity_changes_where_a_stretch_ends() {
        let motion = motion();
        let mut mover = Mover::new(Vec2::zeros(), Vec2::new(0.5, 0.0), 0.3);
        let mut driver = motion.driver(mover.velocity);
        let mut changes = Vec::new();
        for tick in 0..100u32 {
            let before = mover.velocity;
            driver.begin(&mut mover, Span { begin_s: f64::from(tick) * 0.1, lasts_s: 0.1 });
            if mover.velocity != before {
                changes.push((tick, mover.velocity));
            }
        }
        let mut ends = 0;
        for (number, change) in (1..).zip(&changes) {
            ends += motion.stretch(number - 1).units;
            assert_eq!(*change, (ends, motion.stretch(number).velocity));
            assert_eq!(driver_way(&motion, number), motion.stretch(number).velocity);
        }
        assert!(changes.len() >= 3, "{changes:?}");
    }

    #[test]
    fn a_mover_goes_the_same_way_whatever_a_tick_lasts() {
        let map = StaticMap::new(OccupancyGrid::from_ascii(&["........", "..#.....", ".....#..", "........"], 1.0));
        let statics = Statics { map: &map, unknown: &[] };
        // Where it is every two seconds of a minute.
        let places = |lasts_s: f64, ticks: u32| -> Vec<Vec2> {
            let mut mover = Mover::new(Vec2::new(1.0, 2.0), Vec2::new(0.5, 0.2), 0.3);
            let mut driver = motion().driver(mover.velocity);
            let mut step = |tick: u32| {
                let span = Span { begin_s: f64::from(tick) * lasts_s, lasts_s };
                driver.begin(&mut mover, span);
                let course = driver.course(&mover, &statics, span);
                (mover.position, mover.velocity) = course.at(lasts_s);
                mover.position
            };
            (0..30 * ticks).map(&mut step).skip(ticks as usize - 1).step_by(ticks as usize).collect()
        };
        let papers = places(0.1, 20);
        assert!(papers.windows(2).all(|pair| pair[0] != pair[1]));
        for (lasts_s, ticks) in [(0.05, 40), (0.25, 8), (1.0 / 30.0, 60), (0.5, 4), (2.0, 1)] {
            let places = places(lasts_s, ticks);
            for (place, expected) in places.iter().zip(&papers) {
                assert!((place - expected).norm() < 1e-6, "{lasts_s}: {place:?} {expected:?}");
            }
        }
    }

    /// Which way the mover goes once it has begun stretch `number`.
    fn driver_way(motion: &Irregular, number: u32) -> Vec2 {
        let mut mover = Mover::new(Vec2::zeros(), Vec2::new(0.5, 0.0), 0.3);
        let mut driver = motion.driver(mover.velocity);
        let ticks: u32 = (0..number).map(|number| motion.stretch(number).units).sum();
        for tick in 0..=ticks {
            driver.begin(&mut mover, Span { begin_s: f64::from(tick) * 0.1, lasts_s: 0.1 });
        }
        driver.way(&mover)
    }

    #[test]
    fn an_irregular_mover_changes_course_as_often_and_as_much_as_it_says() {
        let text =
            "moving: [random: {speed_mps: [0.8, 1.0], motion: {irregular: {interval_s: [1, 3]}}, on_static: pass}]";
        let (mut changes_s, mut headings, mut speeds) = (Vec::new(), Vec::new(), Vec::new());
        for episode in 0..40 {
            let states = states(&scene_of(text, episode), 600);
            let mut last = 0;
            for tick in 1..states.len() {
                let (before, after) = (states[tick - 1][0].velocity, states[tick][0].velocity);
                if before != after {
                    changes_s.push((tick - last) as f64 * 0.1);
                    last = tick;
                    headings.push(math::atan2(after.y, after.x));
                    speeds.push(after.norm());
                }
                let moved = states[tick][0].position - states[tick - 1][0].position;
                assert!((moved - after * 0.1).norm() < 1e-9, "straight within a tick");
            }
        }
        let n = changes_s.len() as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        assert!(n > 1000.0, "{n}");
        // Uniform on [1, 3]: mean 2, sd 0.577; four standard errors. The first interval of an episode counts from tick 1.
        assert!((mean(&changes_s) - 2.0).abs() < 4.0 * 0.577 / n.sqrt(), "{}", mean(&changes_s));
        assert!(changes_s.iter().all(|s| (0.95..=3.15).contains(s)));
        assert!((mean(&speeds) - 0.9).abs() < 4.0 * 0.058 / n.sqrt() && speeds.iter().all(|s| (0.8..=1.0).contains(s)));
        let turn: Vec2 = headings.iter().map(|&heading| direction(heading)).sum::<Vec2>() / n;
        // The mean direction of n uniform headings is about 1/√n long.
        assert!(turn.norm() < 3.0 / n.sqrt(), "{turn:?}");
    }
}
