//! How movers move: straight pieces, split where they meet a static obstacle, turn at a waypoint or pass a sample.
//!
//! Movers pass through each other, and the robot never pushes them.

use super::DT_S;
use super::motion::{Motion, Patrol, Replay};
use super::obstacle::Mover;
use super::spec::moving::{OnRobot, OnStatic};
use super::statics::Statics;
use crate::geometry::Vec2;
use crate::math;

/// Contacts with statics that one tick resolves; after them the mover stands for the rest of the tick. A disc
/// wedged in a gap of its own width would bounce without end.
const BOUNCES_MAX: usize = 8;

/// A piece of straight motion.
#[derive(Clone, Copy, Debug)]
struct Leg {
    begin_s: f64,
    from: Vec2,
    velocity: Vec2,
}

/// Where one mover is at every moment of one tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    legs: [Leg; BOUNCES_MAX + 1],
    count: usize,
    speed: f64,
}

impl Course {
    /// Standing at `p`.
    pub(super) fn standing(p: Vec2) -> Self {
        let leg = Leg { begin_s: 0.0, from: p, velocity: Vec2::zeros() };
        Self { legs: [leg; BOUNCES_MAX + 1], count: 1, speed: 0.0 }
    }

    /// The course of a mover that wants to go at `cruise`; `cruise` becomes what it wants afterwards.
    fn drive(mover: &Mover, cruise: &mut Vec2, statics: &Statics<'_>, duration_s: f64) -> Self {
        let mut course = Self::standing(mover.position);
        course.speed = cruise.norm();
        course.legs[0].velocity = *cruise;
        if mover.on_static == OnStatic::Pass || course.speed == 0.0 {
            return course;
        }
        let speed = course.speed;
        loop {
            let leg = course.legs[course.count - 1];
            let left_s = duration_s - leg.begin_s;
            let Some(hit) = statics.sweep(&mover.outline, leg.from, leg.velocity, left_s) else {
                return course;
            };
            *cruise = match mover.on_static {
                OnStatic::Stop => Vec2::zeros(),
                OnStatic::Reflect | OnStatic::Pass => {
                    let mirrored = leg.velocity - 2.0 * leg.velocity.dot(&hit.normal) * hit.normal;
                    // Scaled back, so that rounding never changes the speed.
                    mirrored * (speed / mirrored.norm())
                }
            };
            let out_of_bounces = course.count == BOUNCES_MAX;
            course.legs[course.count] = Leg {
                begin_s: leg.begin_s + hit.time_s,
                from: leg.from + leg.velocity * hit.time_s,
                velocity: if out_of_bounces { Vec2::zeros() } else { *cruise },
            };
            course.count += 1;
            if out_of_bounces || mover.on_static == OnStatic::Stop {
                return course;
            }
        }
    }

    /// The course along `patrol`, from where `beat` says; `beat` becomes what it is afterwards. Where a static is in the way
    /// the mover waits, unless it passes.
    fn patrol(mover: &Mover, patrol: &Patrol, beat: &mut Beat, statics: &Statics<'_>, duration_s: f64) -> Self {
        let mut course = Self::standing(mover.position);
        course.speed = patrol.speed_mps;
        course.count = 0;
        let (mut time_s, mut position) = (0.0, mover.position);
        while time_s < duration_s {
            let begin_s = time_s;
            let left_s = duration_s - time_s;
            let ahead = patrol.waypoints[beat.next] - position;
            let away_s = ahead.norm() / patrol.speed_mps;
            let waits = beat.wait_s > 0.0;
            let velocity = if waits || away_s == 0.0 { Vec2::zeros() } else { ahead / away_s };
            let mut lasts_s = math::min(if waits { beat.wait_s } else { away_s }, left_s);
            let hit = statics.sweep(&mover.outline, position, velocity, lasts_s);
            let blocked = mover.on_static != OnStatic::Pass && hit.is_some();
            if let (true, Some(hit)) = (blocked, hit) {
                lasts_s = hit.time_s;
            }
            course.push(Leg { begin_s, from: position, velocity });
            time_s += lasts_s;
            position += velocity * lasts_s;
            if blocked || course.count == BOUNCES_MAX {
                course.push(Leg { begin_s: time_s, from: position, velocity: Vec2::zeros() });
                break;
            }
            if waits {
                beat.wait_s -= lasts_s;
            } else if away_s <= left_s {
                position = patrol.waypoints[beat.next];
                (beat.next, beat.backwards) = patrol.after(beat.next, beat.backwards);
                beat.wait_s = patrol.pause_s;
            }
        }
        course
    }

    fn push(&mut self, leg: Leg) {
        self.legs[self.count] = leg;
        self.count += 1;
    }

    /// The course of a recording in the tick that begins at `begin_s`.
    fn replay(replay: &Replay, begin_s: f64, duration_s: f64) -> Self {
        let end_s = begin_s + duration_s;
        let mut course = Self::standing(replay.position(begin_s));
        course.count = 0;
        let mut from_s = begin_s;
        let inside = replay.sample_times(begin_s, end_s).take(BOUNCES_MAX);
        for to_s in inside.chain([end_s]) {
            let (from, to) = (replay.position(from_s), replay.position(to_s));
            let velocity = if to_s > from_s { (to - from) / (to_s - from_s) } else { Vec2::zeros() };
            course.push(Leg { begin_s: from_s - begin_s, from, velocity });
            course.speed = math::max(course.speed, velocity.norm());
            from_s = to_s;
        }
        course
    }

    /// Position and velocity at `time_s` of the tick; at a bounce, the velocity after it.
    pub(super) fn at(&self, time_s: f64) -> (Vec2, Vec2) {
        let mut leg = &self.legs[0];
        for next in &self.legs[1..self.count] {
            if next.begin_s > time_s {
                break;
            }
            leg = next;
        }
        (leg.from + leg.velocity * (time_s - leg.begin_s), leg.velocity)
    }

    /// Highest speed in the tick, m/s.
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }
}

/// Where a mover is on its beat.
#[derive(Clone, Copy, Debug)]
struct Beat {
    /// The waypoint it goes to.
    next: usize,
    backwards: bool,
    /// What is left of its stop, s.
    wait_s: f64,
}

/// What one mover is about to do, from tick to tick.
#[derive(Clone, Debug)]
pub(super) struct Driver {
    /// What it drives when nothing holds it.
    cruise: Vec2,
    /// The stretch of an irregular motion that it is in, and the tick at which the next one begins.
    stretch: (u32, u32),
    beat: Beat,
    /// Whether the script makes it stand.
    pub(super) halted: bool,
}

impl Driver {
    /// A mover at the beginning of the episode.
    pub(super) fn new(mover: &Mover) -> Self {
        let ends = match &mover.motion {
            Motion::Irregular(irregular) => irregular.stretch(0).ticks,
            Motion::Uniform | Motion::Patrol(_) | Motion::Replay(_) => u32::MAX,
        };
        let beat = Beat { next: 1, backwards: false, wait_s: 0.0 };
        Self { cruise: mover.velocity, stretch: (0, ends), beat, halted: false }
    }

    /// The mover has another velocity from now on.
    pub(super) fn set_velocity(&mut self, mover: &mut Mover, velocity: Vec2) {
        (self.cruise, mover.velocity) = (velocity, velocity);
    }

    /// What changes at the beginning of `tick`: an irregular mover's velocity, whether a recorded one is there.
    pub(super) fn begin(&mut self, mover: &mut Mover, tick: u32) {
        match &mover.motion {
            Motion::Uniform | Motion::Patrol(_) => {}
            Motion::Irregular(irregular) => {
                let (number, ends) = self.stretch;
                if tick >= ends {
                    let next = irregular.stretch(number + 1);
                    self.stretch = (number + 1, ends.saturating_add(next.ticks));
                    self.cruise = next.velocity;
                    mover.velocity = next.velocity;
                }
            }
            Motion::Replay(replay) => {
                let time_s = f64::from(tick) * DT_S;
                let present = replay.is_present(time_s);
                if present && !mover.present {
                    let course = Course::replay(replay, time_s, DT_S);
                    (mover.position, mover.velocity) = course.at(0.0);
                }
                mover.present = present;
            }
        }
    }

    /// Its course in `tick`, given where the robot's centre is and how far its footprint is away.
    pub(super) fn course(
        &mut self,
        mover: &Mover,
        statics: &Statics<'_>,
        (robot, gap_m): (Vec2, f64),
        tick: u32,
    ) -> Course {
        if !mover.present || self.halted {
            return Course::standing(mover.position);
        }
        let wants = match &mover.motion {
            Motion::Patrol(patrol) => patrol.waypoints[self.beat.next] - mover.position,
            Motion::Uniform | Motion::Irregular(_) | Motion::Replay(_) => self.cruise,
        };
        match &mover.motion {
            Motion::Replay(replay) => Course::replay(replay, f64::from(tick) * DT_S, DT_S),
            _ if yields(mover, wants, robot, gap_m) => Course::standing(mover.position),
            Motion::Patrol(patrol) => Course::patrol(mover, patrol, &mut self.beat, statics, DT_S),
            Motion::Uniform | Motion::Irregular(_) => Course::drive(mover, &mut self.cruise, statics, DT_S),
        }
    }
}

/// Where a uniform mover is, and how it moves, after `time_s` without a robot; `None` where it stands by then.
pub(super) fn free_run(mover: &Mover, statics: &Statics<'_>, time_s: f64) -> Option<(Vec2, Vec2)> {
    let (mut mover, mut cruise, mut left_s) = (mover.clone(), mover.velocity, time_s);
    while left_s > 0.0 {
        let tick_s = math::min(left_s, DT_S);
        let course = Course::drive(&mover, &mut cruise, statics, tick_s);
        (mover.position, mover.velocity) = course.at(tick_s);
        left_s -= tick_s;
    }
    (mover.velocity != Vec2::zeros()).then_some((mover.position, mover.velocity))
}

/// Whether a yielding mover stands this tick: the robot's centre lies in the half plane ahead of it and their surfaces
/// are within its distance, at the beginning of the tick.
fn yields(mover: &Mover, cruise: Vec2, robot: Vec2, gap_m: f64) -> bool {
    mover.on_robot == OnRobot::Yield && (robot - mover.position).dot(&cruise) > 0.0 && gap_m <= mover.yield_distance_m
}

#[cfg(test)]
mod tests {
    use super::super::obstacle::{Shape, UnknownStatic};
    use super::super::statics::StaticMap;
    use super::*;
    use crate::geometry::{Pose, direction};
    use crate::map::OccupancyGrid;
    use crate::math;
    use crate::rng::{EpisodeSeed, Purpose};

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

    #[test]
    fn yielding_depends_on_who_is_ahead_and_how_near() {
        let mut mover = mover(Vec2::new(0.0, 0.0), 0.3, OnStatic::Reflect);
        mover.yield_distance_m = 1.0;
        let cruise = Vec2::new(1.0, 0.0);
        let gap_m = |x: f64| x.abs() - 0.3 - 0.25;
        let ahead =
            |x| yields(&Mover { on_robot: OnRobot::Yield, ..mover.clone() }, cruise, Vec2::new(x, 0.0), gap_m(x));
        // Surfaces are 1 m apart where the centres are 1.55 m apart.
        assert!(ahead(1.54) && !ahead(1.56) && !ahead(-1.0));
        assert!(!yields(&mover, cruise, Vec2::new(1.0, 0.0), gap_m(1.0)), "movers ignore the robot unless told");
    }
}
