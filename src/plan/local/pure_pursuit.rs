//! `pure_pursuit`: steers along the circle that meets the path one look-ahead distance away.
//!
//! The tracker for stacks that are to be judged by their global path alone: it follows the path within the robot's
//! limits and avoids nothing.
//!
//! Source: R. C. Coulter, "Implementation of the pure pursuit path tracking algorithm", technical report
//! CMU-RI-TR-92-01, Carnegie Mellon University, 1992. The look-ahead point lies at (x, y) in the robot's frame, at
//! distance d; the circle through it that is tangent to the heading has the curvature
//!
//! ```text
//! κ = 2 y / d²
//! ```
//!
//! Departures and choices:
//! - The look-ahead point is the first one, from the progress on the path onwards, that is `lookahead_m` away; the
//!   end of the path if no point is, and the point of progress if the robot is farther off the path than that.
//! - A chord of `lookahead_m` cuts corners, and a path that passes one closely would be hit for the tracker's own fault. So the
//!   robot looks no farther ahead than it can go: each of some look-ahead distances is tried, the longest first, by driving
//!   one tick as the law has it and then braking on along the path. That way out must keep clear of the statics of the belief map:
//!   half of what the path ahead leaves beyond the robot's radius, at most 2.5 cm. A shorter look-ahead is driven more slowly;
//!   where none is clear the robot holds its speed, or brakes: what it brakes along was found clear the tick before. A path that
//!   comes nearer than the radius is followed wherever it leads.
//! - Coulter leaves the speed open. Here: as fast as the limits allow, with |κ| v ≤ ω_max, and slow enough to come
//!   to a stop at the end of the path.
//! - A robot that turns on the spot can face any way: where the look-ahead point lies behind (|bearing| > π/2) it
//!   comes to a stop, for the circle of κ would lead the long way round; at rest it turns on the spot until it faces
//!   the point to within 0.3 rad, and farther where the circle is not clear.
//!
//! Parameters: [`Params`].

use super::{LocalKind, turn_in_place};
use crate::geometry::{Path, Piece, Pose, Twist, Vec2};
use crate::math;
use crate::plan::clearance::Obstacles;
use crate::plan::contract::{Decision, Entry, Failure, Guidance, LocalPlanner, Situation, State};
use crate::robot::Robot;
use crate::settings::quantity::Positive;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `pure_pursuit`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Look-ahead distance, m: shorter tracks closer and swings more, longer cuts corners. Default 0.8.
    pub lookahead_m: Positive,
}

impl Default for Params {
    fn default() -> Self {
        Self { lookahead_m: Positive::new(0.8) }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Pure pursuit: tracks the path and avoids nothing; to judge a global planner by its path alone.",
    source: "R. C. Coulter, Implementation of the pure pursuit path tracking algorithm, CMU-RI-TR-92-01, 1992",
    states: &[State::TRACK],
    ..Entry::PLAIN
};

/// A robot at rest turns on the spot until the look-ahead point is within this bearing, rad.
const ALIGNED_RAD: f64 = 0.3;

/// Bearing to which it turns where the circle to the point is not clear, rad.
const FINE_RAD: f64 = 0.01;

/// A robot that is slower counts as at rest, m/s: it can stop within the tick, or almost does.
const REST_MPS: f64 = 0.05;

/// The look-ahead distances that are tried, in parts of `lookahead_m`.
const SHARES: [f64; 7] = [1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12];

/// A look-ahead that has been shortened to d allows the speed d / this, s: the yaw rate takes about that long to follow.
const SHORT_CHORD_S: f64 = 0.35;

/// Largest distance beyond its radius that the robot keeps from statics, m.
const MARGIN_M: f64 = 0.025;

/// Speeds of a robot that would not get away otherwise, m/s.
const CRAWL_MPS: [f64; 2] = [0.1, 0.03];

/// Points of the path behind the robot's place that are tried, and the distance from one to the next, m.
const BACK_POINTS: u32 = 20;
const BACK_STEP_M: f64 = 0.05;

/// Ticks after which a way out is taken to be clear: a bound of the work.
const TICKS_MAX: u32 = 200;

impl LocalKind for Params {
    fn build(&self) -> Box<dyn LocalPlanner> {
        Box::new(Planner::new(self))
    }
}

/// The planner. It has no state: its answer depends on the situation and the guidance alone.
#[derive(Clone, Debug)]
pub struct Planner {
    lookahead_m: f64,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self { lookahead_m: params.lookahead_m.get() }
    }
}

impl LocalPlanner for Planner {
    fn decide(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Result<Decision, Failure> {
        Ok(Decision::track(Tracker::new(situation, guidance, self.lookahead_m).command()))
    }

    fn entry(&self) -> &'static Entry {
        &ENTRY
    }
}

/// One decision.
struct Tracker<'a> {
    path: &'a Path,
    length_m: f64,
    robot: &'a Robot,
    dt_s: f64,
    lookahead_m: f64,
    now: Drive,
    obstacles: Obstacles<'a>,
    /// What the robot's centre keeps from statics, m; none where the path itself does not keep the radius.
    room_m: Option<f64>,
}

/// The robot on its path at one tick, as it is or as it will be.
#[derive(Clone, Copy, Debug)]
struct Drive {
    pose: Pose,
    twist: Twist,
    place: Place,
}

impl<'a> Tracker<'a> {
    fn new(situation: &Situation<'a>, guidance: &Guidance<'a>, lookahead_m: f64) -> Self {
        let Situation { pose, twist, robot, dt_s, belief, .. } = *situation;
        let path = guidance.path;
        let obstacles = Obstacles::new(belief.grid(), belief.field());
        let place = Place::at(path, guidance.progress_m);
        let braking_m = 0.5 * twist.v * twist.v / robot.deceleration_max_mps2;
        let ahead_m = place.along_m + lookahead_m + braking_m;
        let room_m = |radius_m: f64| {
            let path_m = obstacles.path_clearance(path, place.along_m, ahead_m, radius_m + 2.0 * MARGIN_M);
            let here_m = obstacles.clearance(pose.position, path_m);
            (here_m > radius_m).then(|| {
                // Half of what the path leaves; a robot that has less itself keeps nearly that.
                let (of_path_m, of_place_m) = (0.5 * (path_m - radius_m), 0.9 * (here_m - radius_m));
                radius_m + math::min(of_path_m, of_place_m)
            })
        };
        let room_m = room_m(robot.radius_m).or_else(|| room_m(robot.inscribed_radius_m()));
        let now = Drive { pose, twist, place };
        Self { path, length_m: path.length(), robot, dt_s, lookahead_m, now, obstacles, room_m }
    }

    fn command(&self) -> Twist {
        let resting_mps = math::min(self.robot.deceleration_max_mps2 * self.dt_s, REST_MPS);
        if self.now.twist.v.abs() > resting_mps { self.rolling() } else { self.at_rest() }
    }

    /// The command of a robot that rolls.
    fn rolling(&self) -> Twist {
        let v = self.now.twist.v;
        let reachable = |distance_m: &f64| {
            let point = self.look_ahead(&self.now, *distance_m).0;
            self.now.pose.bearing_to(point).abs() <= math::FRAC_PI_2
        };
        let distances = || SHARES.iter().map(|share| share * self.lookahead_m).filter(reachable);
        if distances().next().is_none() {
            return Twist::ZERO;
        }
        for limit_mps in [f64::INFINITY, v, 0.0] {
            for distance_m in distances() {
                let command = self.steer(&self.now, distance_m, limit_mps);
                if self.is_clear(command, distance_m) {
                    return command;
                }
            }
        }
        let shortest_m = SHARES[SHARES.len() - 1] * self.lookahead_m;
        self.steer(&self.now, shortest_m, 0.0)
    }

    /// The command of a robot at rest: it faces the farthest point to which it can go before it goes.
    fn at_rest(&self) -> Twist {
        let now = &self.now;
        let turn = |bearing: f64| Twist { v: 0.0, omega: turn_in_place(bearing, self.robot, self.dt_s) };
        let mut faced = None;
        for share in SHARES {
            let distance_m = share * self.lookahead_m;
            let point = self.look_ahead(now, distance_m).0;
            let bearing = now.pose.bearing_to(point);
            let is_chord_clear =
                self.room_m.is_none_or(|room_m| self.obstacles.keeps(now.pose.position, point, room_m));
            if !is_chord_clear {
                continue;
            }
            if bearing.abs() > ALIGNED_RAD {
                return turn(faced.unwrap_or(bearing));
            }
            let command = self.steer(now, distance_m, f64::INFINITY);
            if self.is_clear(command, distance_m) {
                return command;
            }
            faced = faced.or(Some(bearing));
        }
        // Nothing ahead can be reached: back to the path, where it was left.
        let Some(bearing) = faced else { return self.back_to_path().unwrap_or(Twist::ZERO) };
        if bearing.abs() > FINE_RAD {
            return turn(bearing);
        }
        for limit_mps in CRAWL_MPS {
            for share in SHARES {
                let command = self.steer(now, share * self.lookahead_m, limit_mps);
                if self.is_clear(command, share * self.lookahead_m) {
                    return command;
                }
            }
        }
        self.back_to_path().unwrap_or(Twist::ZERO)
    }

    /// Turns to the nearest point of the path, at the robot's place on it or behind, to which the way is clear, and goes there slowly.
    fn back_to_path(&self) -> Option<Twist> {
        let Drive { pose, twist, place } = self.now;
        let room_m = self.room_m?;
        let points =
            (0..=BACK_POINTS).map(|k| place.along_m - BACK_STEP_M * f64::from(k)).filter(|&along_m| along_m >= 0.0);
        let points = points.map(|along_m| self.path.point_at(along_m));
        let point = points
            .filter(|point| (point - pose.position).norm() > 1e-3)
            .find(|&point| self.obstacles.keeps(pose.position, point, room_m))?;
        let bearing = pose.bearing_to(point);
        if bearing.abs() > FINE_RAD {
            return Some(Twist { v: 0.0, omega: turn_in_place(bearing, self.robot, self.dt_s) });
        }
        let away_m = (point - pose.position).norm();
        Some(follow(curvature(pose, point), away_m, CRAWL_MPS[0], twist, self.robot, self.dt_s))
    }

    /// Whether the robot keeps clear when it obeys `command` for a tick and then brakes along the path.
    fn is_clear(&self, command: Twist, distance_m: f64) -> bool {
        let Some(room_m) = self.room_m else { return true };
        let mut drive = self.now;
        let mut command = command;
        for _ in 0..TICKS_MAX {
            let twist = self.robot.actuate(drive.twist, command, self.dt_s);
            let pose = drive.pose.advance(twist, self.dt_s);
            // The chord of a tick is that much nearer to the inside than its arc at most.
            let bulge_m = 0.125 * (twist.v * twist.omega).abs() * self.dt_s * self.dt_s;
            if !self.obstacles.keeps(drive.pose.position, pose.position, room_m + bulge_m) {
                return false;
            }
            if twist.v.abs() < 1e-9 {
                return true;
            }
            let moved_m = twist.v.abs() * self.dt_s;
            drive = Drive { pose, twist, place: drive.place.moved(self.path, pose.position, moved_m) };
            command = self.steer(&drive, distance_m, 0.0);
        }
        true
    }

    /// The law: along the circle to the point that is `distance_m` ahead, within the limits, able to stop at the end.
    fn steer(&self, drive: &Drive, distance_m: f64, limit_mps: f64) -> Twist {
        let (point, is_end) = self.look_ahead(drive, distance_m);
        let away_m = (point - drive.pose.position).norm();
        let along_m = math::max(self.length_m - drive.place.along_m, 0.0);
        let left_m = if is_end { math::max(along_m, away_m) } else { along_m };
        let short_mps = if distance_m < self.lookahead_m { distance_m / SHORT_CHORD_S } else { f64::INFINITY };
        let limit_mps = math::min(limit_mps, short_mps);
        follow(curvature(drive.pose, point), left_m, limit_mps, drive.twist, self.robot, self.dt_s)
    }

    /// The look-ahead point, and whether it is the end of the path.
    fn look_ahead(&self, drive: &Drive, distance_m: f64) -> (Vec2, bool) {
        look_ahead(self.path, drive.place, drive.pose.position, distance_m)
    }
}

/// A place on a path: its arc length, and the piece that it lies on.
#[derive(Clone, Copy, Debug)]
struct Place {
    piece: usize,
    /// Arc length where the piece begins, m.
    begin_m: f64,
    along_m: f64,
}

impl Place {
    fn at(path: &Path, along_m: f64) -> Self {
        let mut place = Self { piece: 0, begin_m: 0.0, along_m };
        for (index, (from, piece)) in path.segments().enumerate() {
            let end_m = place.begin_m + piece.length(from);
            if along_m <= end_m || index + 1 == path.pieces().len() {
                break;
            }
            place = Self { piece: index + 1, begin_m: end_m, along_m };
        }
        place
    }

    /// The place of a robot that has gone `moved_m` on to `position`: never back.
    fn moved(self, path: &Path, position: Vec2, moved_m: f64) -> Self {
        // Round the inside of a corner the path is longer than the way; farther on another part of it may be nearer.
        let reach_m = self.along_m + 1.5 * moved_m + 0.02;
        let mut best = (self, f64::INFINITY);
        let (mut index, mut begin_m) = (self.piece, self.begin_m);
        while let Some(piece) = path.pieces().get(index).filter(|_| begin_m <= reach_m) {
            let from = begin_of(path, index);
            let along_m = math::clamp(begin_m + piece.project(from, position), self.along_m, reach_m);
            let away_m = (piece.point_at(from, along_m - begin_m) - position).norm();
            if away_m < best.1 {
                best = (Self { piece: index, begin_m, along_m }, away_m);
            }
            begin_m += piece.length(from);
            index += 1;
        }
        best.0
    }
}

/// Where a piece of a path begins.
fn begin_of(path: &Path, index: usize) -> Vec2 {
    if index == 0 { path.start() } else { path.pieces()[index - 1].end() }
}

/// The look-ahead point, and whether it is the end of the path.
fn look_ahead(path: &Path, place: Place, position: Vec2, lookahead_m: f64) -> (Vec2, bool) {
    let away = |point: Vec2| (point - position).norm() >= lookahead_m;
    let mut begin_m = place.begin_m;
    for (index, piece) in path.pieces().iter().enumerate().skip(place.piece) {
        let from = begin_of(path, index);
        let length = piece.length(from);
        let begin = math::clamp(place.along_m - begin_m, 0.0, length);
        begin_m += length;
        if away(piece.point_at(from, begin)) {
            return (piece.point_at(from, begin), false); // only at the point of progress: off the path
        }
        if !away(piece.end()) {
            continue;
        }
        // The distance passes the look-ahead inside this piece.
        if let Piece::Line { to } = *piece {
            let (direction, offset) = ((to - from) / length, from - position);
            let half = offset.dot(&direction);
            let root = half * half - offset.norm_squared() + lookahead_m * lookahead_m;
            let along = math::clamp(math::max(root, 0.0).sqrt() - half, begin, length);
            return (from + direction * along, false);
        }
        let (mut near, mut far) = (begin, length);
        for _ in 0..30 {
            let middle = 0.5 * (near + far);
            *(if away(piece.point_at(from, middle)) { &mut far } else { &mut near }) = middle;
        }
        return (piece.point_at(from, far), false);
    }
    (path.end(), true)
}

/// Curvature of the circle from `pose`, tangent to its heading, through `point`, 1/m; 0 where they coincide.
fn curvature(pose: Pose, point: Vec2) -> f64 {
    let distance = (point - pose.position).norm();
    // y = d sin(bearing)
    if distance > 0.0 { 2.0 * math::sin(pose.bearing_to(point)) / distance } else { 0.0 }
}

/// Along the curvature, within the limits and not above `limit_mps`, able to stop in `left_m`.
fn follow(curvature: f64, left_m: f64, limit_mps: f64, twist: Twist, robot: &Robot, dt_s: f64) -> Twist {
    let deceleration = robot.deceleration_max_mps2;
    // Driving v for this tick and a_dec·dt less in each that follows takes v²/2a + v·dt/2, where v is a whole
    // number of such steps, and at most a·dt²/8 more (under a millimetre) where it is not. Below one step it takes v·dt.
    let half_tick = 0.5 * dt_s;
    let stopping = deceleration * ((half_tick * half_tick + 2.0 * left_m / deceleration).sqrt() - half_tick);
    let stopping = math::min(stopping, math::max(left_m / dt_s, 0.0));
    let bend = curvature.abs();
    let turning = if bend > 0.0 { robot.yaw_rate_max_radps / bend } else { robot.speed_max_mps };
    let wanted = math::min(math::min(robot.speed_max_mps, limit_mps), math::min(stopping, turning));
    // The yaw rate goes with the speed that the drive will reach, so that the curvature is kept while it changes.
    let v = robot.actuate(twist, Twist { v: wanted, omega: 0.0 }, dt_s).v;
    Twist { v, omega: math::clamp(curvature * v, -robot.yaw_rate_max_radps, robot.yaw_rate_max_radps) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::OccupancyGrid;
    use crate::plan::local::tests::{Course, Drive};

    fn drive(course: &Course, lookahead_m: f64) -> Drive {
        let mut planner = Planner::new(&Params { lookahead_m: Positive::new(lookahead_m) });
        course.drive(1000, |situation, guidance| planner.decide(situation, guidance))
    }

    fn close(a: Vec2, x: f64, y: f64) -> bool {
        (a - Vec2::new(x, y)).norm() < 1e-9
    }

    #[test]
    fn the_look_ahead_point_is_where_the_circle_meets_the_path() {
        let path = Path::new(
            Vec2::new(0.0, 0.0),
            vec![
                Piece::Line { to: Vec2::new(4.0, 0.0) },
                Piece::Arc { to: Vec2::new(6.0, 2.0), centre: Vec2::new(4.0, 2.0), sweep: math::FRAC_PI_2 },
            ],
        );
        // On the line: 3-4-5 triangle of 0.6, 0.8, 1.
        let ahead =
            |along_m: f64, from: Vec2, distance_m: f64| look_ahead(&path, Place::at(&path, along_m), from, distance_m);
        let (point, is_end) = ahead(1.0, Vec2::new(1.0, 0.6), 1.0);
        assert!(close(point, 1.8, 0.0) && !is_end);
        // On the arc: √2 · 2 from its beginning to its end, so 2 m away is at 60° of the circle.
        let (point, _) = ahead(4.0, Vec2::new(4.0, 0.0), 2.0);
        assert!(close(point, 4.0 + 2.0 * math::sin(math::PI / 3.0), 2.0 - 2.0 * math::cos(math::PI / 3.0)), "{point}");
        // Nearer to the end than the look-ahead: the end. Farther off the path than it: the point of progress.
        assert!(close(ahead(6.5, Vec2::new(6.0, 1.5), 1.0).0, 6.0, 2.0));
        assert!(close(ahead(2.0, Vec2::new(2.0, 3.0), 1.0).0, 2.0, 0.0));
    }

    #[test]
    fn the_circle_goes_through_the_point() {
        // From the origin along +x to (1, 1): the unit circle about (0, 1).
        assert!((curvature(Pose::new(0.0, 0.0, 0.0), Vec2::new(1.0, 1.0)) - 1.0).abs() < 1e-12);
        assert!((curvature(Pose::new(0.0, 0.0, 0.0), Vec2::new(0.5, -0.5)) + 2.0).abs() < 1e-12);
        assert_eq!(curvature(Pose::new(0.0, 0.0, 0.0), Vec2::new(0.0, 0.0)), 0.0);
    }

    #[test]
    fn it_stays_on_a_path_with_corners_and_stops_at_its_end() {
        let vertices = [(5.0, 5.0), (15.0, 5.0), (15.0, 12.0), (25.0, 20.0)].map(|(x, y)| Vec2::new(x, y));
        let course = Course { path: Path::polyline(&vertices), ..Course::open(Pose::new(5.0, 5.0, 0.0), vertices[3]) };
        let drive = drive(&course, 0.8);
        assert!(drive.arrived);
        let deviation = drive.poses.iter().map(|pose| course.path.project(pose.position).1).fold(0.0, math::max);
        assert!(deviation < 0.8, "{deviation}");
        // Within 0.25 m of the end: v ≤ √(2·0.5·0.25) = 0.5 and a tick more.
        assert!(drive.decisions.last().unwrap().command.v < 0.56);
        // 9.97 + 7 + 12.8 m at 1 m/s with two corners: not much longer than 30 s.
        assert!(drive.poses.len() < 380, "{}", drive.poses.len());
    }

    #[test]
    fn it_follows_an_arc_within_centimetres() {
        let path = Path::new(
            Vec2::new(10.0, 10.0),
            vec![Piece::Arc { to: Vec2::new(10.0, 20.0), centre: Vec2::new(10.0, 15.0), sweep: math::PI }],
        );
        let course = Course { path, ..Course::open(Pose::new(10.0, 10.0, 0.0), Vec2::zeros()) };
        let drive = drive(&course, 0.8);
        assert!(drive.arrived);
        assert!(drive.poses.iter().all(|pose| course.path.project(pose.position).1 < 0.03));
    }

    #[test]
    fn it_turns_on_the_spot_for_a_path_that_begins_behind() {
        let course = Course::open(Pose::new(20.0, 20.0, math::PI), Vec2::new(30.0, 20.0));
        let drive = drive(&course, 0.8);
        assert!(drive.arrived);
        assert!(drive.poses[..10].iter().all(|pose| (pose.position - course.start.position).norm() < 1e-12));
    }

    #[test]
    fn it_comes_to_rest_at_the_end_and_obeys_the_limits() {
        let robot = Robot::default();
        let (mut twist, mut left) = (Twist { v: 1.0, omega: 0.0 }, 5.0);
        for _ in 0..300 {
            let command = follow(0.0, left, f64::INFINITY, twist, &robot, 0.1);
            assert_eq!(robot.actuate(twist, command, 0.1), command);
            twist = command;
            left -= 0.1 * twist.v;
            assert!(left > -0.001);
        }
        assert!(left.abs() < 0.01 && twist.v < 0.01, "{left} {twist:?}");
        // Round a bend of 0.5 m radius the yaw rate of 1 rad/s allows 0.5 m/s.
        let mut twist = Twist { v: 0.5, omega: 1.0 };
        for _ in 0..20 {
            twist = follow(2.0, 50.0, f64::INFINITY, twist, &robot, 0.1);
        }
        assert!((twist.v - 0.5).abs() < 1e-12 && (twist.omega - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_path_of_one_point_is_no_panic() {
        let here = Vec2::new(20.0, 20.0);
        let course = Course {
            path: Path::polyline(&[here]),
            grid: OccupancyGrid::empty(40, 40, 1.0),
            ..Course::open(Pose::new(21.0, 20.0, 0.0), here)
        };
        assert!(!drive(&course, 0.8).poses.is_empty());
    }
}
