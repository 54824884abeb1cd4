//! Motion from waypoint to waypoint, again and again.

use super::course::{Course, Leg};
use super::{Drive, MotionKind, Span};
use crate::geometry::Vec2;
use crate::math;
use crate::world::obstacles::moving::{Mover, OnStatic};
use crate::world::scene::Digest;
use crate::world::statics::Statics;
use std::sync::Arc;

/// Waypoints driven one after the other in straight lines, with a stop of `pause_s` at each.
#[derive(Clone, Debug, PartialEq)]
pub struct Patrol {
    /// The waypoints, grid frame, m; at least two, no two neighbours equal.
    pub waypoints: Arc<[Vec2]>,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Whether the last waypoint leads to the first; otherwise the mover goes back the way it came.
    pub closed: bool,
    /// Stop at every waypoint, s.
    pub pause_s: f64,
}

impl Patrol {
    /// The waypoint after `at`, and whether the mover goes through the list backwards from there on.
    fn after(&self, at: usize, backwards: bool) -> (usize, bool) {
        let last = self.waypoints.len() - 1;
        match (self.closed, backwards) {
            (true, false) => (if at == last { 0 } else { at + 1 }, false),
            (true, true) => (if at == 0 { last } else { at - 1 }, true),
            (false, false) if at == last => (at - 1, true),
            (false, false) => (at + 1, false),
            (false, true) if at == 0 => (1, false),
            (false, true) => (at - 1, true),
        }
    }
}

impl MotionKind for Patrol {
    fn digest(&self, digest: &mut Digest) {
        digest.word(2);
        digest.word(self.waypoints.len() as u64);
        self.waypoints.iter().for_each(|&p| digest.point(p));
        digest.real(self.speed_mps);
        digest.word(u64::from(self.closed));
        digest.real(self.pause_s);
    }

    fn driver(&self, _: Vec2) -> Box<dyn Drive> {
        Box::new(Patroller { patrol: self.clone(), next: 1, backwards: false, wait_s: 0.0 })
    }
}

/// A mover on its patrol.
#[derive(Debug)]
struct Patroller {
    patrol: Patrol,
    /// The waypoint it goes to.
    next: usize,
    backwards: bool,
    /// Remaining time of its stop, s.
    wait_s: f64,
}

impl Drive for Patroller {
    fn way(&self, mover: &Mover) -> Vec2 {
        self.patrol.waypoints[self.next] - mover.position
    }

    /// The course through a tick. The mover waits before a static in its way, unless it turns back there or passes through statics.
    fn course(&mut self, mover: &Mover, statics: &Statics<'_>, tick: Span) -> Course {
        let patrol = &self.patrol;
        let mut course = Course::empty(mover.position, patrol.speed_mps);
        let (mut time_s, mut position) = (0.0, mover.position);
        while time_s < tick.lasts_s {
            let begin_s = time_s;
            let left_s = tick.lasts_s - time_s;
            let ahead = patrol.waypoints[self.next] - position;
            let away_s = ahead.norm() / patrol.speed_mps;
            let waits = self.wait_s > 0.0;
            let velocity = if waits || away_s == 0.0 { Vec2::zeros() } else { ahead / away_s };
            let mut lasts_s = math::min(if waits { self.wait_s } else { away_s }, left_s);
            let hit = statics.sweep(&mover.outline, position, velocity, lasts_s);
            let blocked = mover.on_static != OnStatic::Pass && hit.is_some();
            if let (true, Some(hit)) = (blocked, hit) {
                lasts_s = hit.time_s;
            }
            course.push(Leg { begin_s, from: position, velocity });
            time_s += lasts_s;
            position += velocity * lasts_s;
            if blocked && mover.on_static == OnStatic::TurnBack && !course.is_full() {
                (self.next, self.backwards) = patrol.after(self.next, !self.backwards);
                continue;
            }
            if blocked || course.is_full() {
                course.push(Leg { begin_s: time_s, from: position, velocity: Vec2::zeros() });
                break;
            }
            if waits {
                self.wait_s -= lasts_s;
            } else if away_s <= left_s {
                position = patrol.waypoints[self.next];
                (self.next, self.backwards) = patrol.after(self.next, self.backwards);
                self.wait_s = patrol.pause_s;
            }
        }
        course
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patrol(closed: bool) -> Patrol {
        let waypoints = Arc::new([Vec2::new(0.0, 0.0), Vec2::new(1.0, 0.0), Vec2::new(1.0, 1.0)]);
        Patrol { waypoints, speed_mps: 0.5, closed, pause_s: 0.0 }
    }

    /// The first waypoints that a patrol goes to.
    fn visits(patrol: &Patrol, count: usize) -> Vec<usize> {
        let (mut at, mut backwards) = (0, false);
        let next = || {
            (at, backwards) = patrol.after(at, backwards);
            Some(at)
        };
        core::iter::from_fn(next).take(count).collect()
    }

    #[test]
    fn a_closed_patrol_goes_round_and_an_open_one_there_and_back() {
        assert_eq!(visits(&patrol(true), 7), [1, 2, 0, 1, 2, 0, 1]);
        assert_eq!(visits(&patrol(false), 7), [1, 2, 1, 0, 1, 2, 1]);
        let two = Patrol { waypoints: Arc::new([Vec2::zeros(), Vec2::x()]), ..patrol(false) };
        assert_eq!(visits(&two, 4), [1, 0, 1, 0]);
    }

    #[test]
    fn a_patrol_that_turns_back_goes_round_the_other_way() {
        use crate::map::OccupancyGrid;
        use crate::world::statics::StaticMap;
        // The second leg of the round is closed at y = 2: it comes as far as 1.7, goes back, and past the first waypoint to the last.
        let map = StaticMap::new(OccupancyGrid::from_ascii(&["....", ".###", "....", "...."], 1.0));
        let statics = Statics { map: &map, unknown: &[] };
        let waypoints = Arc::new([Vec2::new(0.5, 0.5), Vec2::new(2.5, 0.5), Vec2::new(2.5, 3.5), Vec2::new(0.5, 3.5)]);
        let patrol = Patrol { waypoints, speed_mps: 1.0, closed: true, pause_s: 0.0 };
        let mut mover = Mover::new(Vec2::new(0.5, 0.5), Vec2::zeros(), 0.3);
        mover.on_static = OnStatic::TurnBack;
        let mut driver = patrol.driver(Vec2::zeros());
        let mut places = Vec::new();
        for _ in 0..90 {
            let course = driver.course(&mover, &statics, Span { begin_s: 0.0, lasts_s: 0.1 });
            (mover.position, mover.velocity) = course.at(0.1);
            places.push(mover.position);
        }
        let highest = places.iter().filter(|p| p.x > 2.0).fold(0.0, |high, p| math::max(high, p.y));
        assert!((highest - 1.7).abs() < 0.06, "{highest}");
        // 2 + 1.2 there, 1.2 + 2 back, then up to the last waypoint: 3 m more need 9.4 s, so it is on that leg.
        let end = places[places.len() - 1];
        assert!((end.x - 0.5).abs() < 1e-9 && end.y > 2.5, "{end:?}");
    }

    #[test]
    fn patrols_that_differ_are_fingerprinted_apart() {
        let digest = |patrol: &Patrol| {
            let mut digest = Digest::default();
            MotionKind::digest(patrol, &mut digest);
            digest.value()
        };
        assert_eq!(digest(&patrol(true)), digest(&patrol(true)));
        for other in [
            patrol(false),
            Patrol { speed_mps: 0.6, ..patrol(true) },
            Patrol { pause_s: 0.1, ..patrol(true) },
            Patrol { waypoints: Arc::new([Vec2::zeros(), Vec2::x()]), ..patrol(true) },
        ] {
            assert_ne!(digest(&patrol(true)), digest(&other), "{other:?}");
        }
    }
}
