//! From the command to the motion over ground: latency, the drive's limits, noise, slip.

use super::DT_S;
use super::spec::{ActuationSpec, Conditions};
use crate::geometry::Twist;
use crate::rng::{Purpose, Stream};
use crate::robot::Robot;
use crate::settings::quantity::Fraction;

/// What lies between a command and the ground.
#[derive(Clone, Debug)]
pub(super) struct Drivetrain {
    spec: ActuationSpec,
    stream: Stream,
    /// Commands that have not arrived: that of tick k in slot k modulo the latency.
    on_the_way: Vec<Twist>,
    /// The twist of the wheels during the last tick: what odometry says.
    pub(super) wheels: Twist,
}

impl Drivetrain {
    pub(super) fn new(conditions: &Conditions) -> Self {
        let spec = conditions.actuation.clone();
        Self {
            stream: conditions.seed.stream(Purpose::Actuation, 0),
            on_the_way: vec![Twist::ZERO; spec.latency_ticks.get() as usize],
            wheels: Twist::ZERO,
            spec,
        }
    }

    pub(super) fn set_slip(&mut self, left: [Fraction; 2], right: [Fraction; 2]) {
        (self.spec.slip_left, self.spec.slip_right) = (left, right);
    }

    /// Takes the command of `tick` and returns the body's twist during it.
    pub(super) fn drive(&mut self, robot: &Robot, command: Twist, tick: u32) -> Twist {
        let arrived = if self.on_the_way.is_empty() {
            command
        } else {
            let slot = tick as usize % self.on_the_way.len();
            core::mem::replace(&mut self.on_the_way[slot], command)
        };
        self.wheels = robot.actuate(self.wheels, arrived, DT_S);
        if self.spec.is_exact() {
            return self.wheels;
        }
        // Always drawn in this order, so that one kind of noise does not move another.
        let draws = self.stream.at_tick(tick);
        let noisy = Twist {
            v: self.wheels.v * (1.0 + self.spec.speed_noise_share.get() * draws.normal()),
            omega: self.wheels.omega * (1.0 + self.spec.yaw_rate_noise_share.get() * draws.normal()),
        };
        let mut kept = |[low, high]: [Fraction; 2]| 1.0 - draws.range(low.get(), high.get());
        let (left_kept, right_kept) = (kept(self.spec.slip_left), kept(self.spec.slip_right));
        let (left, right) = robot.wheel_speeds(noisy);
        let (left, right) = (left * left_kept, right * right_kept);
        Twist { v: 0.5 * (left + right), omega: (right - left) / robot.track_width_m }
    }
}
