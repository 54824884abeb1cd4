//! How movers move: straight lines, split where they meet a static obstacle.
//!
//! Movers pass through each other, and the robot never pushes them.

use super::obstacle::Mover;
use super::spec::moving::{OnRobot, OnStatic};
use super::statics::Statics;
use crate::geometry::Vec2;

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
    pub(super) fn drive(mover: &Mover, cruise: &mut Vec2, statics: &Statics<'_>, duration_s: f64) -> Self {
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
            let Some(hit) = statics.sweep_disc(leg.from, leg.velocity, mover.radius_m, left_s) else {
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

/// Whether a yielding mover stands this tick: the robot's centre lies in the half plane ahead of it and their surfaces
/// are within its distance, at the beginning of the tick.
pub(super) fn yields(mover: &Mover, cruise: Vec2, robot: Vec2, robot_radius_m: f64) -> bool {
    let d = robot - mover.position;
    mover.on_robot == OnRobot::Yield
        && d.dot(&cruise) > 0.0
        && d.norm() - mover.radius_m - robot_radius_m <= mover.yield_distance_m
}
