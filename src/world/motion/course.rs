//! The course of a mover: its position at every moment of one tick.

use super::super::obstacles::moving::{Mover, OnStatic};
use super::super::statics::Statics;
use crate::geometry::Vec2;
use crate::math;

/// Contacts with statics that one tick resolves; after them the mover stands for the rest of the tick. A disc
/// wedged in a gap of its own width would bounce without end.
pub(super) const BOUNCES_MAX: usize = 8;

/// A piece of straight motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    pub(super) begin_s: f64,
    pub(super) from: Vec2,
    pub(super) velocity: Vec2,
}

/// Position of one mover at every moment of one tick.
#[derive(Clone, Copy, Debug)]
pub(in crate::world) struct Course {
    legs: [Leg; BOUNCES_MAX + 1],
    count: usize,
    /// Highest speed in the tick, m/s.
    pub(super) speed: f64,
}

impl Course {
    /// The course of a mover that stands at `p`.
    pub(in crate::world) fn standing(p: Vec2) -> Self {
        let leg = Leg { begin_s: 0.0, from: p, velocity: Vec2::zeros() };
        Self { legs: [leg; BOUNCES_MAX + 1], count: 1, speed: 0.0 }
    }

    /// A course without legs that begins at `p`; no leg will be faster than `speed_mps`.
    pub(super) fn empty(p: Vec2, speed_mps: f64) -> Self {
        Self { count: 0, speed: speed_mps, ..Self::standing(p) }
    }

    /// The course of a mover with the wanted velocity `cruise`; `cruise` becomes its wanted velocity at the end of the course.
    pub(super) fn drive(mover: &Mover, cruise: &mut Vec2, statics: &Statics<'_>, duration_s: f64) -> Self {
        let mut course = Self::empty(mover.position, 0.0);
        course.go_on(mover, cruise, statics, 0.0, duration_s);
        course
    }

    /// Extends the course at `cruise` from `from_s`, its end so far, to `until_s`; `cruise` becomes the mover's wanted velocity
    /// at `until_s`.
    pub(super) fn go_on(&mut self, mover: &Mover, cruise: &mut Vec2, statics: &Statics<'_>, from_s: f64, until_s: f64) {
        let speed = cruise.norm();
        self.speed = math::max(self.speed, speed);
        self.push(Leg { begin_s: from_s, from: self.at(from_s).0, velocity: *cruise });
        if mover.on_static == OnStatic::Pass || speed == 0.0 {
            return;
        }
        loop {
            let leg = self.legs[self.count - 1];
            let left_s = until_s - leg.begin_s;
            let Some(hit) = statics.sweep(&mover.outline, leg.from, leg.velocity, left_s) else {
                return;
            };
            *cruise = match mover.on_static {
                OnStatic::Stop => Vec2::zeros(),
                OnStatic::TurnBack => -leg.velocity,
                OnStatic::Reflect | OnStatic::Pass => {
                    let mirrored = leg.velocity - 2.0 * leg.velocity.dot(&hit.normal) * hit.normal;
                    // Scaled back, so that rounding never changes the speed.
                    mirrored * (speed / mirrored.norm())
                }
            };
            let out_of_bounces = self.is_full();
            self.push(Leg {
                begin_s: leg.begin_s + hit.time_s,
                from: leg.from + leg.velocity * hit.time_s,
                velocity: if out_of_bounces { Vec2::zeros() } else { *cruise },
            });
            if out_of_bounces || mover.on_static == OnStatic::Stop {
                return;
            }
        }
    }

    /// Appends a leg.
    pub(super) fn push(&mut self, leg: Leg) {
        self.legs[self.count] = leg;
        self.count += 1;
    }

    /// Ends the course: from `time_s` on the mover stands, unless it does already.
    pub(super) fn stand(&mut self, time_s: f64) {
        if self.count <= BOUNCES_MAX {
            self.push(Leg { begin_s: time_s, from: self.at(time_s).0, velocity: Vec2::zeros() });
        }
    }

    /// Whether there is room for one more leg at most.
    pub(super) fn is_full(&self) -> bool {
        self.count >= BOUNCES_MAX
    }

    /// Position and velocity at `time_s` of the tick; at a bounce, the velocity after it.
    pub(in crate::world) fn at(&self, time_s: f64) -> (Vec2, Vec2) {
        let mut leg = &self.legs[0];
        for next in &self.legs[1..self.count.max(1)] {
            if next.begin_s > time_s {
                break;
            }
            leg = next;
        }
        (leg.from + leg.velocity * (time_s - leg.begin_s), leg.velocity)
    }

    /// Highest speed in the tick, m/s.
    pub(in crate::world) fn speed(&self) -> f64 {
        self.speed
    }
}

/// Time step of [`free_run`], s. It is not the control period, because no scene depends on that.
const FREE_RUN_STEP_S: f64 = 0.1;

/// Position and velocity of a uniform mover after `time_s` without a robot; `None` if it stands by then.
pub(in crate::world) fn free_run(mover: &Mover, statics: &Statics<'_>, time_s: f64) -> Option<(Vec2, Vec2)> {
    let (mut mover, mut cruise, mut left_s) = (mover.clone(), mover.velocity, time_s);
    while left_s > 0.0 {
        let tick_s = math::min(left_s, FREE_RUN_STEP_S);
        let course = Course::drive(&mover, &mut cruise, statics, tick_s);
        (mover.position, mover.velocity) = course.at(tick_s);
        left_s -= tick_s;
    }
    (mover.velocity != Vec2::zeros()).then_some((mover.position, mover.velocity))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::outline::Shape;
    use crate::geometry::{Pose, direction};
    use crate::map::OccupancyGrid;
    use crate::rng::{EpisodeSeed, Purpose};
    use crate::world::obstacles::unknown_static::UnknownStatic;
    use crate::world::statics::StaticMap;

    const DT: f64 = 0.1;

    fn mover(position: Vec2, radius_m: f64, on_static: OnStatic) -> Mover {
        Mover { on_static, yield_distance_m: 0.0, ..Mover::new(position, Vec2::zeros(), radius_m) }
    }

    /// Coordinate of a point that starts at `x` with velocity `u` and is mirrored at `low` and `high`, after `t`:
    /// unfolded, the motion is straight, and the room repeats every two lengths.
    fn mirrored(x: f64, u: f64, low: f64, high: f64, t: f64) -> f64 {
        let length = high - low;
        let unfolded = (x - low + u * t).rem_euclid(2.0 * length);
        low + if unfolded > length { 2.0 * length - unfolded } else { unfolded }
    }

    #[test]
    fn in_an_empty_room_a_mover_follows_the_mirror_construction() {
        let mut stream = EpisodeSeed { seed: 1, episode: 0 }.stream(Purpose::Dynamic, 0);
        for _ in 0..200 {
            let (width, height) = (3 + stream.index(6) as i32, 2 + stream.index(6) as i32);
            let map = StaticMap::new(OccupancyGrid::empty(width, height, 1.0));
            let statics = Statics { map: &map, unknown: &[] };
            let radius = stream.range(0.1, 0.9);
            let room = |size: i32| (radius, f64::from(size) - radius);
            let ((x0, x1), (y0, y1)) = (room(width), room(height));
            let begin = Vec2::new(stream.range(x0, x1), stream.range(y0, y1));
            let velocity = stream.range(0.1, 6.0) * direction(stream.range(-4.0, 4.0));
            let (mut mover, mut cruise) = (mover(begin, radius, OnStatic::Reflect), velocity);
            for tick in 1..=300 {
                let course = Course::drive(&mover, &mut cruise, &statics, DT);
                (mover.position, mover.velocity) = course.at(DT);
                let t = DT * f64::from(tick);
                let expected =
                    Vec2::new(mirrored(begin.x, velocity.x, x0, x1, t), mirrored(begin.y, velocity.y, y0, y1, t));
                assert!((mover.position - expected).norm() < 1e-8, "{:?} {expected:?}", mover.position);
                assert!((mover.velocity.x.abs() - velocity.x.abs()).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn movers_keep_their_speed_and_never_enter_a_static_obstacle() {
        let (mut worlds, mut bounces, mut halts) = (0, 0, 0);
        for episode in 0..3000 {
            let mut stream = EpisodeSeed { seed: 2, episode }.stream(Purpose::Dynamic, 0);
            let mut grid = OccupancyGrid::empty(10, 8, stream.range(0.1, 1.2));
            for index in 0..80 {
                if stream.uniform() < 0.2 {
                    grid.set_occupied(grid.cell(index));
                }
            }
            let extent = grid.extent_m();
            let map = StaticMap::new(grid);
            let unknown: Vec<UnknownStatic> = (0..3)
                .map(|k| {
                    let (x, y) = (stream.range(0.0, extent.x), stream.range(0.0, extent.y));
                    let size = 0.1 * extent.y;
                    let shape = if k == 0 {
                        Shape::Disc { radius_m: stream.range(0.1, 1.0) * size }
                    } else {
                        Shape::Rectangle { half_m: Vec2::new(stream.range(0.1, 1.0), stream.range(0.1, 1.0)) * size }
                    };
                    UnknownStatic::new(Pose::new(x, y, stream.range(-4.0, 4.0)), shape)
                })
                .collect();
            let statics = Statics { map: &map, unknown: &unknown };
            let radius = stream.range(0.05, 0.5);
            let position = Vec2::new(stream.range(0.0, extent.x), stream.range(0.0, extent.y));
            if statics.distance_m(position) < radius {
                continue;
            }
            worlds += 1;
            let speed = stream.range(0.1, 5.0);
            let mut cruise = speed * direction(stream.range(-4.0, 4.0));
            let mut mover = mover(position, radius, OnStatic::Reflect);
            for _ in 0..100 {
                let before = mover.position;
                let course = Course::drive(&mover, &mut cruise, &statics, DT);
                bounces += course.count - 1;
                for k in 1..=20 {
                    let p = course.at(DT * f64::from(k) / 20.0).0;
                    let gap = statics.distance_m(p) - radius;
                    assert!(gap > -1e-8, "{gap} in episode {episode}");
                    assert!((p - before).norm() <= speed * DT + 1e-9);
                }
                (mover.position, mover.velocity) = course.at(DT);
                halts += i32::from(mover.velocity.norm() == 0.0);
                assert!((cruise.norm() - speed).abs() < 1e-12 * math::max(speed, 1.0));
            }
        }
        assert!(worlds > 1000 && bounces > 10_000, "{worlds} worlds, {bounces} bounces, {halts} halts");
    }

    #[test]
    fn a_mover_stops_at_a_wall_or_passes_through_it() {
        let grid = OccupancyGrid::from_ascii(&["..#..."], 1.0);
        let map = StaticMap::new(grid);
        let statics = Statics { map: &map, unknown: &[] };
        let begin = Vec2::new(1.0, 0.5);
        // The wall's face is at 2, so a disc of 0.3 stops at 1.7, after 0.7 s at 1 m/s.
        for (on_static, x, speed) in [(OnStatic::Stop, 1.7, 0.0), (OnStatic::Pass, 11.0, 1.0)] {
            let (mut mover, mut cruise) = (mover(begin, 0.3, on_static), Vec2::new(1.0, 0.0));
            for _ in 0..100 {
                let course = Course::drive(&mover, &mut cruise, &statics, DT);
                (mover.position, mover.velocity) = course.at(DT);
            }
            assert!((mover.position.x - x).abs() < 1e-9, "{:?}", mover.position);
            assert_eq!(mover.velocity.norm(), speed);
        }
    }

    #[test]
    fn a_mover_that_turns_back_keeps_its_line_at_a_pallet_that_stands_askew() {
        let map = StaticMap::new(OccupancyGrid::empty(12, 4, 1.0));
        let shape = Shape::Rectangle { half_m: Vec2::new(0.6, 0.4) };
        let unknown = [UnknownStatic::new(Pose::new(8.0, 2.3, 0.6), shape)];
        let statics = Statics { map: &map, unknown: &unknown };
        let (mut mover, mut cruise) = (mover(Vec2::new(3.0, 2.0), 0.3, OnStatic::TurnBack), Vec2::new(0.8, 0.0));
        let (mut low, mut high) = (3.0, 3.0);
        for _ in 0..600 {
            let course = Course::drive(&mover, &mut cruise, &statics, DT);
            (mover.position, mover.velocity) = course.at(DT);
            assert_eq!((mover.position.y, mover.velocity.y.abs(), mover.velocity.x.abs()), (2.0, 0.0, 0.8));
            (low, high) = (math::min(low, mover.position.x), math::max(high, mover.position.x));
        }
        // From the map's edge to the pallet's near corner and back, and again.
        assert!(low < 0.38 && (6.5..7.2).contains(&high), "{low} {high}");
    }

    #[test]
    fn a_corner_is_met_along_its_own_normal() {
        // Corner of the cell at (2, 1), disc of 0.5 aimed so that the normal is at 45°: it turns a right angle.
        let mut grid = OccupancyGrid::empty(6, 6, 1.0);
        grid.set_occupied(crate::map::Cell { col: 2, row: 1 });
        let map = StaticMap::new(grid);
        let statics = Statics { map: &map, unknown: &[] };
        let contact = Vec2::new(3.0, 2.0) + 0.5 * direction(math::FRAC_PI_2 / 2.0);
        let mover = mover(contact + Vec2::new(0.05, 0.0), 0.5, OnStatic::Reflect);
        let mut cruise = Vec2::new(-1.0, 0.0);
        let course = Course::drive(&mover, &mut cruise, &statics, DT);
        assert!((course.at(0.05).0 - contact).norm() < 1e-9);
        assert!((cruise - Vec2::new(0.0, 1.0)).norm() < 1e-9, "{cruise:?}");
    }
}
