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
//!   end of the path where none is, and the point of progress where the robot is farther off the path than that.
//! - Coulter leaves the speed open. Here: as fast as the limits allow, with |κ| v ≤ ω_max, and slow enough to come
//!   to a stop at the end of the path.
//! - A robot that turns on the spot can face any way: where the look-ahead point lies behind (|bearing| > π/2) it
//!   brakes and turns there first, since the circle of κ would lead the long way round.
//!
//! Parameters: [`Params`].

use super::{Decision, Entry, Guidance, LocalPlanner, Mode, turn_on_the_spot};
use crate::geometry::{Path, Pose, Twist, Vec2};
use crate::math;
use crate::observation::Observation;
use crate::quantity::Positive;
use crate::robot::Robot;
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
};

/// The planner. It has no state: its answer depends on the observation and the guidance alone.
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
    fn decide(&mut self, observation: &Observation<'_>, guidance: &Guidance<'_>) -> Decision {
        let Observation { pose, twist, robot, dt_s, .. } = *observation;
        let (point, left_m) = look_ahead(guidance.path, guidance.progress_m, pose.position, self.lookahead_m);
        let bearing = pose.bearing_to(point);
        let command = if bearing.abs() > math::FRAC_PI_2 {
            Twist { v: 0.0, omega: turn_on_the_spot(bearing, robot, dt_s) }
        } else {
            follow(curvature(pose, point), left_m, twist, robot, dt_s)
        };
        Decision { command, mode: Mode::Track, rollouts: 0 }
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
    let deceleration = robot.deceleration_mps2;
    // Driving v for this tick and a_dec·dt less in each that follows takes v²/2a + v·dt/2.
    let half_tick = 0.5 * dt_s;
    let stopping = deceleration * ((half_tick * half_tick + 2.0 * left_m / deceleration).sqrt() - half_tick);
    let bend = curvature.abs();
    let turning = if bend > 0.0 { robot.yaw_rate_max_radps / bend } else { robot.speed_max_mps };
    let wanted = math::min(robot.speed_max_mps, math::min(stopping, turning));
    // The yaw rate goes with the speed that the drive will reach, so that the curvature is kept while it changes.
    let v = robot.actuate(twist, Twist { v: wanted, omega: 0.0 }, dt_s).v;
    Twist { v, omega: math::clamp(curvature * v, -robot.yaw_rate_max_radps, robot.yaw_rate_max_radps) }
}
