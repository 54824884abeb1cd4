//! From the command to the motion over ground: latency, the drive's limits, noise, slip.

use crate::geometry::Twist;
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::robot::Robot;
use crate::settings::quantity::{CountOrZero, Fraction, NonNegative};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How well the drive does what it is told (scenario key `actuation`); perfectly by default.
///
/// A command reaches the drive after the latency; the drive answers within its limits; noise and slip then part the ground's
/// motion from the wheels'. The robot knows the twist of its wheels, not that of its body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ActuationSpec {
    /// Ticks from a command to its effect; until the first one arrives the drive is told to stand. Default 0, at most 1000.
    pub latency_ticks: CountOrZero,
    /// Standard deviation of the speed as a share of it, normal, each tick anew; default 0.
    pub speed_noise_share: NonNegative,
    /// Standard deviation of the yaw rate as a share of it, normal, each tick anew; default 0.
    pub yaw_rate_noise_share: NonNegative,
    /// Share of its rim speed that the left wheel loses to the ground, uniform between the two numbers, each tick anew;
    /// default [0, 0].
    pub slip_left: [Fraction; 2],
    /// The same for the right wheel.
    pub slip_right: [Fraction; 2],
}

impl Default for ActuationSpec {
    fn default() -> Self {
        let none = NonNegative::new(0.0);
        let grip = [Fraction::new(0.0), Fraction::new(0.0)];
        Self {
            latency_ticks: CountOrZero::new(0),
            speed_noise_share: none,
            yaw_rate_noise_share: none,
            slip_left: grip,
            slip_right: grip,
        }
    }
}

impl ActuationSpec {
    /// Whether the motion over ground always equals that of the wheels.
    fn is_exact(&self) -> bool {
        let noise = [self.speed_noise_share, self.yaw_rate_noise_share];
        let slip = [self.slip_left, self.slip_right];
        noise.iter().all(|noise| noise.get() == 0.0) && slip.as_flattened().iter().all(|slip| slip.get() == 0.0)
    }
}

/// The drive: everything between a command and the motion over ground.
#[derive(Clone, Debug)]
pub(super) struct Drivetrain {
    spec: ActuationSpec,
    stream: Stream,
    /// Commands that have not arrived yet; the command of tick k is in slot k modulo the latency.
    on_the_way: Vec<Twist>,
    /// The twist of the wheels during the last tick, as odometry measures it.
    pub(super) wheels: Twist,
}

impl Drivetrain {
    pub(super) fn new(spec: &ActuationSpec, seed: EpisodeSeed) -> Self {
        Self {
            stream: seed.stream(Purpose::Actuation, 0),
            on_the_way: vec![Twist::ZERO; spec.latency_ticks.get() as usize],
            wheels: Twist::ZERO,
            spec: spec.clone(),
        }
    }

    pub(super) fn set_slip(&mut self, left: [Fraction; 2], right: [Fraction; 2]) {
        (self.spec.slip_left, self.spec.slip_right) = (left, right);
    }

    /// Takes the command of `tick`, which lasts `dt_s`, and returns the body's twist during it.
    pub(super) fn drive(&mut self, robot: &Robot, command: Twist, tick: u32, dt_s: f64) -> Twist {
        let arrived = if self.on_the_way.is_empty() {
            command
        } else {
            let slot = tick as usize % self.on_the_way.len();
            core::mem::replace(&mut self.on_the_way[slot], command)
        };
        self.wheels = robot.actuate(self.wheels, arrived, dt_s);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::quantity::CountOrZero;

    /// A robot that reaches any command at once, its wheels half a metre apart.
    fn robot() -> Robot {
        Robot {
            speed_max_mps: 5.0,
            acceleration_max_mps2: 1e3,
            deceleration_max_mps2: 1e3,
            yaw_rate_max_radps: 20.0,
            yaw_acceleration_max_radps2: 1e4,
            track_width_m: 0.5,
            wheel_speed_max_mps: 100.0,
            ..Robot::default()
        }
    }

    fn ahead(v: f64) -> Twist {
        Twist { v, omega: 0.0 }
    }

    #[test]
    fn a_command_takes_effect_after_the_latency() {
        let spec = ActuationSpec { latency_ticks: CountOrZero::new(3), ..ActuationSpec::default() };
        let mut drivetrain = Drivetrain::new(&spec, EpisodeSeed::default());
        let speeds: Vec<f64> =
            (0..7).map(|tick| drivetrain.drive(&robot(), ahead(f64::from(tick + 1)), tick, 0.1).v).collect();
        assert_eq!(speeds[..3], [0.0; 3], "it stands until the first command arrives");
        assert_eq!(speeds[3..], [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn the_limits_of_the_drive_hold_each_tick() {
        let mut drivetrain = Drivetrain::new(&ActuationSpec::default(), EpisodeSeed::default());
        // 0.5 m/s² for 0.1 s.
        for tick in 0..4 {
            let twist = drivetrain.drive(&Robot::default(), ahead(1.0), tick, 0.1);
            assert!((twist.v - 0.05 * f64::from(tick + 1)).abs() < 1e-12);
            assert_eq!(twist, drivetrain.wheels);
        }
    }

    #[test]
    fn wheels_that_slip_move_the_body_by_hand_worked_amounts() {
        let mut drivetrain = Drivetrain::new(&ActuationSpec::default(), EpisodeSeed::default());
        drivetrain.set_slip([Fraction::new(0.5); 2], [Fraction::new(0.0); 2]);
        let command = Twist { v: 1.0, omega: 0.4 };
        let twist = drivetrain.drive(&robot(), command, 0, 0.1);
        // Rims: 1 − 0.1 = 0.9 and 1.1 m/s; the left one loses half: 0.45. v = 0.775, ω = 0.65 / 0.5.
        assert!((twist.v - 0.775).abs() < 1e-12 && (twist.omega - 1.3).abs() < 1e-12, "{twist:?}");
        assert_eq!(drivetrain.wheels, command, "odometry knows nothing of it");
    }

    #[test]
    fn noise_is_a_share_of_the_motion_and_addressed_by_tick() {
        let spec = ActuationSpec { speed_noise_share: NonNegative::new(0.1), ..ActuationSpec::default() };
        let seed = EpisodeSeed { seed: 6, episode: 0 };
        let drive = |tick: u32, v: f64| Drivetrain::new(&spec, seed).drive(&robot(), ahead(v), tick, 0.1);
        assert_eq!(drive(4, 0.0), Twist::ZERO, "what stands does not shake");
        let (one, two) = (drive(4, 1.0).v - 1.0, drive(4, 2.0).v - 2.0);
        assert!(one != 0.0 && (two - 2.0 * one).abs() < 1e-12, "{one} {two}");
        assert_ne!(drive(5, 1.0), drive(4, 1.0));
        assert_eq!(drive(4, 1.0), drive(4, 1.0));
    }

    #[test]
    fn a_longer_period_reaches_farther_into_the_limits() {
        let mut drivetrain = Drivetrain::new(&ActuationSpec::default(), EpisodeSeed::default());
        let twist = drivetrain.drive(&Robot::default(), Twist { v: 1.0, omega: 1.0 }, 0, 0.4);
        // 0.5 m/s² and 2 rad/s² for 0.4 s.
        assert!((twist.v - 0.2).abs() < 1e-12 && (twist.omega - 0.8).abs() < 1e-12, "{twist:?}");
    }
}
