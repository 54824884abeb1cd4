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
//! - Coulter leaves the speed open. Here: as fast as the limits allow, with |κ| v ≤ ω_max, and slow enough to come
//!   to a stop at the end of the path.
//! - A robot that turns on the spot can face any way: where the look-ahead point lies behind (|bearing| > π/2) it
//!   comes to a stop, for the circle of κ would lead the long way round; at rest it turns on the spot until it faces
//!   the point to within 0.3 rad.
//!
//! Parameters: [`Params`].

use super::{LocalKind, turn_in_place};
use crate::geometry::{Path, Pose, Twist, Vec2};
use crate::math;
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
        let Situation { pose, twist, robot, dt_s, .. } = *situation;
        let (point, left_m) = look_ahead(guidance.path, guidance.progress_m, pose.position, self.lookahead_m);
        let bearing = pose.bearing_to(point);
        let is_rolling = twist.v.abs() > robot.deceleration_max_mps2 * dt_s;
        let command = if is_rolling && bearing.abs() > math::FRAC_PI_2 {
            Twist::ZERO
        } else if !is_rolling && bearing.abs() > ALIGNED_RAD {
            Twist { v: 0.0, omega: turn_in_place(bearing, robot, dt_s) }
        } else {
            follow(curvature(pose, point), left_m, twist, robot, dt_s)
        };
        Ok(Decision::track(command))
    }

    fn entry(&self) -> &'static Entry {
        &ENTRY
    }
}

/// The look-ahead point, and the length of path from the point of progress to the end, m.
fn look_ahead(path: &Path, progress_m: f64, position: Vec2, lookahead_m: f64) -> (Vec2, f64) {
    let away = |point: Vec2| (point - position).norm() >= lookahead_m;
    let mut found = None;
    let mut passed = 0.0;
    for (from, piece) in path.segments() {
        let length = piece.length(from);
        let begin = math::max(progress_m - passed, 0.0);
        passed += length;
        if found.is_some() || begin > length {
            continue;
        }
        if away(piece.point_at(from, begin)) {
            found = Some(piece.point_at(from, begin)); // only at the point of progress: off the path
        } else if away(piece.end()) {
            // The distance passes the look-ahead inside this piece: halve until it is found.
            let (mut near, mut far) = (begin, length);
            for _ in 0..50 {
                let middle = 0.5 * (near + far);
                if away(piece.point_at(from, middle)) {
                    far = middle;
                } else {
                    near = middle;
                }
            }
            found = Some(piece.point_at(from, far));
        }
    }
    (found.unwrap_or_else(|| path.end()), math::max(passed - progress_m, 0.0))
}

/// Curvature of the circle from `pose`, tangent to its heading, through `point`, 1/m; 0 where they coincide.
fn curvature(pose: Pose, point: Vec2) -> f64 {
    let distance = (point - pose.position).norm();
    // y = d sin(bearing)
    if distance > 0.0 { 2.0 * math::sin(pose.bearing_to(point)) / distance } else { 0.0 }
}

/// Along the curvature, within the limits, able to stop in `left_m`.
fn follow(curvature: f64, left_m: f64, twist: Twist, robot: &Robot, dt_s: f64) -> Twist {
    let deceleration = robot.deceleration_max_mps2;
    // Driving v for this tick and a_dec·dt less in each that follows takes v²/2a + v·dt/2, where v is a whole
    // number of such steps, and at most a·dt²/8 more (under a millimetre) where it is not.
    let half_tick = 0.5 * dt_s;
    let stopping = deceleration * ((half_tick * half_tick + 2.0 * left_m / deceleration).sqrt() - half_tick);
    let bend = curvature.abs();
    let turning = if bend > 0.0 { robot.yaw_rate_max_radps / bend } else { robot.speed_max_mps };
    let wanted = math::min(robot.speed_max_mps, math::min(stopping, turning));
    // The yaw rate goes with the speed that the drive will reach, so that the curvature is kept while it changes.
    let v = robot.actuate(twist, Twist { v: wanted, omega: 0.0 }, dt_s).v;
    Twist { v, omega: math::clamp(curvature * v, -robot.yaw_rate_max_radps, robot.yaw_rate_max_radps) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Piece;
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
        let (point, left) = look_ahead(&path, 1.0, Vec2::new(1.0, 0.6), 1.0);
        assert!(close(point, 1.8, 0.0) && (left - 3.0 - math::PI).abs() < 1e-12);
        // On the arc: √2 · 2 from its beginning to its end, so 2 m away is at 60° of the circle.
        let (point, _) = look_ahead(&path, 4.0, Vec2::new(4.0, 0.0), 2.0);
        assert!(close(point, 4.0 + 2.0 * math::sin(math::PI / 3.0), 2.0 - 2.0 * math::cos(math::PI / 3.0)), "{point}");
        // Nearer to the end than the look-ahead: the end. Farther off the path than it: the point of progress.
        assert!(close(look_ahead(&path, 6.5, Vec2::new(6.0, 1.5), 1.0).0, 6.0, 2.0));
        assert!(close(look_ahead(&path, 2.0, Vec2::new(2.0, 3.0), 1.0).0, 2.0, 0.0));
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
            let command = follow(0.0, left, twist, &robot, 0.1);
            assert_eq!(robot.actuate(twist, command, 0.1), command);
            twist = command;
            left -= 0.1 * twist.v;
            assert!(left > -0.001);
        }
        assert!(left.abs() < 0.01 && twist.v < 0.01, "{left} {twist:?}");
        // Round a bend of 0.5 m radius the yaw rate of 1 rad/s allows 0.5 m/s.
        let mut twist = Twist { v: 0.5, omega: 1.0 };
        for _ in 0..20 {
            twist = follow(2.0, 50.0, twist, &robot, 0.1);
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
