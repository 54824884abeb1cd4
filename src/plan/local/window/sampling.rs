//! The velocities within reach during one tick, and the grid of samples over them.

use crate::geometry::Twist;
use crate::math;
use crate::robot::Robot;

/// Most samples along one axis; a finer step is widened to this. Bounds the cost of a decision.
pub const SAMPLES_MAX: u32 = 1000;

/// Samples nearer to each other than this count as one (m/s or rad/s).
const SAME: f64 = 1e-9;

/// V_s ∩ V_d: the speeds and yaw rates that the limits allow and one tick of acceleration reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Lowest speed, m/s.
    pub v_low: f64,
    /// Highest speed, m/s.
    pub v_high: f64,
    /// Lowest yaw rate, rad/s.
    pub omega_low: f64,
    /// Highest yaw rate, rad/s.
    pub omega_high: f64,
}

impl Window {
    /// The window around `twist`, by the same rules as [`Robot::actuate`].
    ///
    /// If `twist` lies outside the limits by more than one tick can correct (noise of the believed
    /// twist), an axis shrinks to the one value that the drive will reach.
    pub fn reachable(robot: &Robot, twist: Twist, dt_s: f64) -> Self {
        let (up, down) = if twist.v >= 0.0 {
            (robot.acceleration_max_mps2, robot.deceleration_max_mps2)
        } else {
            (robot.deceleration_max_mps2, robot.acceleration_max_mps2)
        };
        let (v_first, v_last) = (twist.v - down * dt_s, twist.v + up * dt_s);
        let turn = robot.yaw_acceleration_max_radps2 * dt_s;
        let (omega_first, omega_last) = (twist.omega - turn, twist.omega + turn);
        let yaw_rate = robot.yaw_rate_max_radps;
        Self {
            v_low: math::clamp(robot.speed_min_mps(), v_first, v_last),
            v_high: math::clamp(robot.speed_max_mps, v_first, v_last),
            omega_low: math::clamp(-yaw_rate, omega_first, omega_last),
            omega_high: math::clamp(yaw_rate, omega_first, omega_last),
        }
    }

    /// The window without speeds above `cap_mps` or below 0; the nearest speed to these if there is none between. All of it where
    /// the cap is infinite.
    pub fn capped(self, cap_mps: f64) -> Self {
        if cap_mps.is_infinite() {
            return self;
        }
        let v_high = math::clamp(cap_mps, self.v_low, self.v_high);
        Self { v_low: math::clamp(0.0, self.v_low, v_high), v_high, ..self }
    }
}

/// How an axis of the window is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spacing {
    /// A fixed step (m/s or rad/s) from the lower end.
    Step(f64),
    /// A fixed number of evenly spaced samples, ends included; at least 2.
    Count(u32),
}

impl Spacing {
    /// The most samples of the speed and of the yaw rate that [`Window::reachable`] of this robot gives, about.
    pub fn most(speed: Self, yaw_rate: Self, robot: &Robot, dt_s: f64) -> [f64; 2] {
        let reached_mps = (robot.acceleration_max_mps2 + robot.deceleration_max_mps2) * dt_s;
        let width_mps = math::min(reached_mps, robot.speed_max_mps - robot.speed_min_mps());
        let width_radps = 2.0 * math::min(robot.yaw_acceleration_max_radps2 * dt_s, robot.yaw_rate_max_radps);
        [(speed, width_mps), (yaw_rate, width_radps)].map(|(spacing, width)| match spacing {
            Self::Count(count) => f64::from(count),
            Self::Step(step) => math::min(width / step + 1.0, f64::from(SAMPLES_MAX)),
        })
    }

    /// Writes the samples of [`low`, `high`] to `out`, ascending and without duplicates: those of the
    /// spacing, both ends, and exactly each value of `always` that lies inside.
    pub fn sample(self, low: f64, high: f64, always: &[f64], out: &mut Vec<f64>) {
        assert!(low <= high, "the window is not empty");
        out.clear();
        out.extend([low, high]);
        for &value in always {
            if value > low && value < high {
                push_new(out, value);
            }
        }
        let most = SAMPLES_MAX - 1;
        let width = high - low;
        let (step, intervals) = match self {
            Self::Step(step) if width / step <= f64::from(most) => (step, (width / step + SAME).floor() as u32),
            Self::Step(_) => (width / f64::from(most), most),
            Self::Count(count) => {
                let intervals = count.clamp(2, SAMPLES_MAX) - 1;
                (width / f64::from(intervals), intervals)
            }
        };
        for i in 1..=intervals {
            push_new(out, math::min(low + f64::from(i) * step, high));
        }
        out.sort_unstable_by(f64::total_cmp);
        out.dedup();
    }
}

/// Adds `value` unless it is there already. The fixed samples come first, so that they stay exact.
fn push_new(samples: &mut Vec<f64>, value: f64) {
    // A regular sample can only double one of the few fixed ones or the sample before it.
    let fixed = samples.len().min(4);
    if samples[..fixed].iter().all(|&other| (other - value).abs() > SAME) {
        samples.push(value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot() -> Robot {
        Robot { deceleration_max_mps2: 1.0, ..Robot::default() } // 1 m/s, 0.5 and 1 m/s², 1 rad/s, 2 rad/s²
    }

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12
    }

    #[test]
    fn a_cap_narrows_the_speeds_as_far_as_one_tick_reaches() {
        let at = |v: f64, cap_mps: f64| {
            let window =
                Window::reachable(&Robot { reverse_speed_max_mps: 0.5, ..robot() }, Twist { v, omega: 0.0 }, 0.1);
            let capped = window.capped(cap_mps);
            assert_eq!((capped.omega_low, capped.omega_high), (window.omega_low, window.omega_high));
            (capped.v_low, capped.v_high)
        };
        let is = |(low, high): (f64, f64), expected: (f64, f64)| close(low, expected.0) && close(high, expected.1);
        assert!(is(at(0.5, f64::INFINITY), (0.4, 0.55)));
        assert!(is(at(0.5, 0.45), (0.4, 0.45)) && is(at(0.5, 2.0), (0.4, 0.55)));
        // Out of reach: as slow as a tick of braking makes it.
        assert!(is(at(0.5, 0.0), (0.4, 0.4)) && is(at(0.05, 0.0), (0.0, 0.0)));
        // It stops reversing, as fast as it can.
        assert!(is(at(0.0, 0.3), (0.0, 0.05)) && is(at(-0.3, 0.3), (-0.2, -0.2)));
    }

    #[test]
    fn the_window_is_one_tick_of_acceleration_inside_the_limits() {
        let inside = Window::reachable(&robot(), Twist { v: 0.5, omega: -0.3 }, 0.1);
        assert!(close(inside.v_low, 0.4) && close(inside.v_high, 0.55)); // 0.5 − 1·0.1, 0.5 + 0.5·0.1
        assert!(close(inside.omega_low, -0.5) && close(inside.omega_high, -0.1)); // ± 2·0.1
        let at_rest = Window::reachable(&robot(), Twist::ZERO, 0.1);
        assert_eq!((at_rest.v_low, at_rest.v_high), (0.0, 0.05));
        let at_the_limit = Window::reachable(&robot(), Twist { v: 1.0, omega: 1.0 }, 0.1);
        assert_eq!((at_the_limit.v_high, at_the_limit.omega_high), (1.0, 1.0));
    }

    #[test]
    fn the_window_reaches_exactly_what_the_drive_reaches() {
        let robot = Robot { reverse_speed_max_mps: 0.3, ..robot() };
        for v in [-0.4, -0.3, -0.02, 0.0, 0.04, 0.97, 1.0, 1.3] {
            for omega in [-1.4, -1.0, 0.0, 0.9, 1.1] {
                let twist = Twist { v, omega };
                let window = Window::reachable(&robot, twist, 0.1);
                let least = robot.actuate(twist, Twist { v: -9.0, omega: -9.0 }, 0.1);
                let most = robot.actuate(twist, Twist { v: 9.0, omega: 9.0 }, 0.1);
                assert_eq!((window.v_low, window.omega_low), (least.v, least.omega), "{twist:?}");
                assert_eq!((window.v_high, window.omega_high), (most.v, most.omega), "{twist:?}");
            }
        }
    }

    #[test]
    fn samples_hold_both_ends_and_what_is_always_asked_for() {
        let mut out = Vec::new();
        Spacing::Step(0.1).sample(-0.25, 0.2, &[0.0, 0.07], &mut out);
        let expected = [-0.25, -0.15, -0.05, 0.0, 0.05, 0.07, 0.15, 0.2];
        assert_eq!(out.len(), expected.len(), "{out:?}");
        assert!(out.iter().zip(expected).all(|(&a, b)| close(a, b)), "{out:?}");
        assert!(out.contains(&0.0) && out.contains(&0.07));

        // The papers' window of 0.04 m/s by 0.01 m/s: five samples; the regular 0.3 gives way to the exact one.
        Spacing::Step(0.01).sample(0.28, 0.32, &[0.3], &mut out);
        assert_eq!(out.len(), 5, "{out:?}");
        assert!(out.contains(&0.3));

        Spacing::Count(5).sample(0.0, 1.0, &[], &mut out);
        assert_eq!(out, [0.0, 0.25, 0.5, 0.75, 1.0]);
        Spacing::Count(5).sample(0.4, 0.4, &[0.4], &mut out);
        assert_eq!(out, [0.4]);
    }

    #[test]
    fn a_step_that_is_far_too_fine_stays_bounded() {
        let mut out = Vec::new();
        Spacing::Step(1e-12).sample(0.0, 0.1, &[0.05], &mut out);
        assert!(out.len() <= SAMPLES_MAX as usize + 1);
        assert!(out.windows(2).all(|pair| pair[0] < pair[1]));
    }
}
