//! The command when no rollout is admissible and movers are near: the manoeuvre that touches nothing, or touches last.
//!
//! The window holds the twists of one control period. What leads a robot at rest out of a mover's lane lies beyond it: so
//! manoeuvres are simulated here, each of which speeds up to a twist as fast as the limits allow, keeps it for a time and brakes along
//! its arc.

use super::lanes::{LANES, Lane};
use super::rollout::{self, Block, Disc, FAR, Field, Part, quarters};
use super::{DynamicWindow, Gaps, Recovery, patch, smaller, touching};
use crate::geometry::convex::{Polygon, turned};
use crate::geometry::{Twist, Vec2, direction};
use crate::math;
use crate::plan::contract::Situation;
use crate::robot::Robot;

/// Speeds tried over the limits.
const SPEEDS: usize = 8;
/// Yaw rates tried over the limits.
const YAW_RATES: usize = 21;
/// Shares of the horizon for which a twist is kept.
const HOLDS: [f64; 4] = [0.2, 0.45, 0.7, 1.0];
/// Gap to movers above which a manoeuvre is no safer, m.
const GAP_MAX_M: f64 = 0.3;
/// Number of manoeuvres.
const MANOEUVRES: usize = SPEEDS * YAW_RATES * HOLDS.len();

/// What becomes of a manoeuvre. Ordered by the first difference.
#[derive(Clone, Copy, Debug)]
struct Fate {
    /// First twist.
    command: Twist,
    /// Steps before the first contact with a static.
    static_steps: f32,
    /// Steps before the first contact with a mover.
    mover_steps: f32,
    /// Gap to movers, m, plus what it comes nearer to the target.
    merit: f64,
}

/// A manoeuvre: the twist that it speeds up to, and the steps for which it does not brake.
#[derive(Clone, Copy, Debug)]
struct Manoeuvre {
    twist: Twist,
    hold: usize,
}

impl Manoeuvre {
    /// Number `number` of [`MANOEUVRES`].
    fn number(number: usize, robot: &Robot, steps: usize) -> Self {
        let (speed, rest) = (number / (YAW_RATES * HOLDS.len()), number % (YAW_RATES * HOLDS.len()));
        let (yaw_rate, hold) = (rest / HOLDS.len(), rest % HOLDS.len());
        let share = |k: usize, count: usize| k as f64 / (count - 1) as f64;
        let low = robot.speed_min_mps();
        let v = low + (robot.speed_max_mps - low) * share(speed, SPEEDS);
        let omega = robot.yaw_rate_max_radps * (2.0 * share(yaw_rate, YAW_RATES) - 1.0);
        Self { twist: robot.within_wheel_limits(Twist { v, omega }), hold: (HOLDS[hold] * steps as f64) as usize }
    }

    /// Drives it from `twist` into a lane of the tracks; returns its first twist and its last position in units of the pitch.
    fn drive(
        self,
        situation: &Situation<'_>,
        pitch_m: f64,
        lane: usize,
        tracks: [&mut Vec<[Lane; 2]>; 2],
    ) -> (Twist, Vec2) {
        let (robot, dt_s) = (situation.robot, situation.dt_s);
        let [track, headings] = tracks;
        let (mut twist, mut first) = (situation.twist, None);
        let (mut position, mut facing) = (Vec2::zeros(), direction(situation.pose.theta));
        for (step, (place, heading)) in track.iter_mut().zip(headings).enumerate() {
            let wanted = if step < self.hold.max(1) {
                self.twist
            } else {
                let slower = robot.actuate(twist, Twist { v: 0.0, omega: twist.omega }, dt_s).v;
                Twist { v: 0.0, omega: if twist.v == 0.0 { 0.0 } else { twist.omega * slower / twist.v } }
            };
            twist = robot.actuate(twist, wanted, dt_s);
            first = first.or(Some(twist));
            let half = turn_by(0.5 * twist.omega * dt_s);
            facing = turned(facing, half);
            position += facing * (twist.v * dt_s / pitch_m);
            facing = turned(facing, half);
            for (axis, (at, to)) in [(position.x, facing.x), (position.y, facing.y)].into_iter().enumerate() {
                place[axis][lane] = at as f32;
                heading[axis][lane] = to as f32;
            }
        }
        (first.unwrap_or(twist), position)
    }
}

/// Cosine and sine of a small angle.
fn turn_by(angle: f64) -> Vec2 {
    let square = angle * angle;
    Vec2::new(
        1.0 - square * (0.5 - square * (1.0 / 24.0 - square / 720.0)),
        angle * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square / 5040.0))),
    )
}

impl DynamicWindow {
    /// The first twist of the best manoeuvre; `None` where no mover is near or every manoeuvre touches a static.
    ///
    /// Best is the one that touches no static and its first mover last; of those that touch none the one with the larger gap to movers
    /// (0.3 m and more are equal) and the larger approach to `target`, weighed together; among equals the first by speed, yaw rate, hold.
    pub(super) fn escape(&mut self, situation: &Situation<'_>, target: Vec2) -> Option<Recovery> {
        if self.discs.is_empty() {
            return None;
        }
        let robot = situation.robot;
        let steps = self.steps_ahead(situation);
        let pitch_m = patch::pitch_m(situation.belief.grid());
        let arm_m = robot.footprint.as_ref().map_or(0.0, Polygon::circumradius_m);
        let speed = math::max(math::max(robot.speed_max_mps, robot.reverse_speed_max_mps), situation.twist.v.abs());
        let reach_m = speed * steps as f64 * situation.dt_s + arm_m;
        let at = self.patch.cover(situation.belief, situation.pose.position, reach_m, self.patch_cap(situation, speed));
        let radius = (robot.inscribed_radius_m() / pitch_m) as f32;
        let touch = touching(&self.patch, &at, [0.0; 2], radius * radius);
        let field = Field { touch, patch: &self.patch, at, free: 0.0 };
        let disc = Part { centre: [0.0; 2], radius, touch };
        let block =
            Block::still([(speed * situation.dt_s / pitch_m) as f32; LANES], robot.yaw_rate_max_radps * situation.dt_s);
        let ahead = &mut self.ahead;
        ahead.resize(steps);
        let mut best: Option<Fate> = None;
        for first in (0..MANOEUVRES).step_by(LANES) {
            let lanes = LANES.min(MANOEUVRES - first);
            let mut begun = [(Twist::ZERO, Vec2::zeros()); LANES];
            for (lane, begun) in begun.iter_mut().enumerate().take(lanes) {
                let manoeuvre = Manoeuvre::number(first + lane, robot, steps);
                *begun = manoeuvre.drive(situation, pitch_m, lane, [&mut ahead.track, &mut ahead.headings]);
            }
            let mut free = [steps as f32; LANES];
            let mut gaps = Gaps::new(free);
            for part in core::iter::once(&disc).chain(&self.parts) {
                rollout::carry_turned(self.width, &ahead.headings, part, &ahead.track, &mut ahead.carried);
                let step = part.step(&block);
                let looked = rollout::look(self.width, &step, &[FAR; LANES], part, &field, &ahead.carried);
                for (free, looked) in free.iter_mut().zip(looked.free_steps) {
                    *free = smaller(looked, *free);
                }
                for mover in &self.discs {
                    // Every millimetre counts here: the true radii, and the gap beside them.
                    let mover = Disc { touch: mover.touch - mover.room + part.radius - radius, ..*mover };
                    gaps.take_passing(
                        &rollout::pass(self.width, &quarters(&step, mover.step_length()), &ahead.carried, &mover),
                        mover.touch,
                    );
                }
            }
            for (lane, &(command, end)) in begun.iter().enumerate().take(lanes) {
                let end = situation.pose.position + end * pitch_m;
                let nearer_m = (target - situation.pose.position).norm() - (target - end).norm();
                let gap_m = math::clamp(f64::from(gaps.least[lane]) * pitch_m, 0.0, GAP_MAX_M);
                let merit = gap_m + 0.1 * nearer_m;
                let fate = Fate { command, static_steps: free[lane], mover_steps: gaps.free_steps[lane], merit };
                if best.is_none_or(|best| fate.is_better_than(&best)) {
                    best = Some(fate);
                }
            }
        }
        let best = best.filter(|fate| fate.static_steps as usize >= steps)?;
        let points = (MANOEUVRES * steps) as u64;
        Some(Recovery { command: best.command, rollouts: MANOEUVRES as u64, rollout_points: points })
    }
}

impl Fate {
    fn is_better_than(&self, other: &Self) -> bool {
        (self.static_steps.total_cmp(&other.static_steps))
            .then(self.mover_steps.total_cmp(&other.mover_steps))
            .then(self.merit.total_cmp(&other.merit))
            .is_gt()
    }
}

impl Block {
    /// A block that stands for manoeuvres of no more than this step and turn.
    fn still(step: Lane, angle: f64) -> Self {
        let zero = [0.0; LANES];
        let turn = direction(angle);
        Self {
            step,
            heading: [zero; 2],
            turn: [[turn.x as f32; LANES], [turn.y as f32; LANES]],
            lead: [zero; 2],
            used: [1.0; LANES],
            arrival: [FAR; LANES],
            angle: zero,
            facing: [1.0, 0.0],
            stopping: zero,
            loss: zero,
        }
    }
}
