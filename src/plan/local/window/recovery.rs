//! The command when no rollout is admissible.

use super::{Aim, DistanceMode, DynamicWindow, Window};
use crate::geometry::{Twist, Vec2};
use crate::math;
use crate::plan::contract::Situation;
use crate::plan::local::turn_in_place;

/// Clearance above which a braking trajectory is no safer, m. Without room a robot that turns to its target while it brakes
/// stops on the very edge of what is beside it, and the error of the prediction makes that a contact.
const RECOVERY_ROOM_M: f64 = 0.05;

/// The command when no rollout is admissible.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recovery {
    /// The command.
    pub command: Twist,
    /// Braking trajectories simulated for it.
    pub rollouts: u64,
    /// Poses simulated in all of them.
    pub rollout_points: u64,
}

impl DynamicWindow {
    /// The command when no rollout is admissible: brake as hard as the drive can, then turn in place to `target`.
    ///
    /// A disc that turns on the spot touches nothing new. While it still rolls, the braking trajectories of all yaw
    /// rates within reach are simulated. Of those that get farthest, all the way to rest where one touches nothing, the one
    /// with the most room is taken (5 cm and more are equal), and of these the one nearest to the wanted
    /// turn. Replaces the rollouts.
    pub fn recover(&mut self, situation: &Situation<'_>, target: Vec2) -> Recovery {
        let (robot, dt_s, twist) = (situation.robot, situation.dt_s, situation.twist);
        let bearing = situation.pose.bearing_to(target);
        let wanted = turn_in_place(bearing, robot, dt_s);

        let lost_per_tick = robot.deceleration_max_mps2 * dt_s;
        let speed = twist.v.abs();
        self.profile.clear();
        for step in 1..=self.horizon_steps(situation) {
            let left = speed - step as f64 * lost_per_tick;
            if left > 0.0 {
                self.profile.push((left / speed) as f32);
            }
        }
        if self.profile.is_empty() {
            return Recovery { command: Twist { v: 0.0, omega: wanted }, rollouts: 0, rollout_points: 0 };
        }
        let window = Window::reachable(robot, twist, dt_s);
        let wanted_now = math::clamp(wanted, window.omega_low, window.omega_high);
        self.settings.yaw_rate.sample(window.omega_low, window.omega_high, &[wanted_now], &mut self.yaw_rates);
        self.rollouts.twists.clear();
        self.rollouts.twists.extend(self.yaw_rates.iter().map(|&omega| Twist { v: twist.v, omega }));
        self.simulate(situation, &Aim::ON);
        let detour = |i: usize| (self.yaw_rates[i] - wanted_now).abs();
        let room = |i: usize| math::min(self.rollouts.clearance_m(i, DistanceMode::PathMin), RECOVERY_ROOM_M);
        let best = (0..self.rollouts.len()).min_by(|&a, &b| {
            (self.rollouts.free_s[b].total_cmp(&self.rollouts.free_s[a]))
                .then(room(b).total_cmp(&room(a)))
                .then(detour(a).total_cmp(&detour(b)))
        });
        let omega = best.map_or(wanted_now, |i| self.yaw_rates[i]);
        let v = if twist.v < 0.0 { -(speed - lost_per_tick) } else { speed - lost_per_tick };
        let (rollouts, rollout_points) = self.simulated();
        Recovery { command: Twist { v, omega }, rollouts, rollout_points }
    }
}
