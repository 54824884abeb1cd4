//! Metrics of the driven trajectory: length, turning, speed, curvature, jerk, clearance.
//!
//! Row 0 of the trace is the state before the first tick, so a drive of n ticks has n + 1 rows; sums and
//! means over time run over rows 1 to n, "the ticks driven". Where the episode failed every value
//! holds for the drive up to its end.

use crate::geometry::{Vec2, wrap_angle};
use crate::math;
use crate::trace::{Tick, Trace};

/// Yaw rate from which a tick belongs to a turn, rad/s.
pub const TURN_RATE_MIN_RADPS: f64 = 0.05;
/// Heading change from which a run of such ticks is a turning point, rad (5°).
pub const TURN_MIN_RAD: f64 = 5.0 * math::PI / 180.0;
/// Heading change above which a tick is a turning step, rad (0.5°).
pub const TURNING_STEP_RAD: f64 = 0.5 * math::PI / 180.0;
/// Speed from which curvature is defined, m/s: below it ω/v says how slow the robot is, not how tight the curve.
pub const CURVATURE_SPEED_MIN_MPS: f64 = 0.05;
/// Speed and yaw rate below which the robot is at rest, m/s and rad/s (`HuNavSim`).
pub const REST: (f64, f64) = (0.01, 0.02);

/// The ticks driven: all rows but the initial state.
fn driven(ticks: &[Tick]) -> &[Tick] {
    ticks.get(1..).unwrap_or_default()
}

/// Change of the true heading in each tick driven, rad in (−π, π].
fn heading_changes(ticks: &[Tick]) -> impl Iterator<Item = f64> + '_ {
    ticks.windows(2).map(|pair| wrap_angle(pair[1].pose.theta - pair[0].pose.theta))
}

/// The mean of some numbers; `None` without any.
fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0u32);
    for value in values {
        sum += value;
        count += 1;
    }
    (count > 0).then(|| sum / f64::from(count))
}

/// `length_m`: Σ |v| dt over the ticks driven, m; less is better. Exact, for a tick is an arc of that length;
/// the tick of a collision counts up to the contact.
pub fn length_m(trace: &Trace, dt_s: f64) -> f64 {
    let driven = trace.ticks.iter().enumerate().skip(1);
    driven.map(|(row, tick)| tick.twist.v.abs() * trace.lasts_s(row, dt_s)).sum()
}

/// `speed_mean_mps`: length divided by time, m/s; undefined if no time passed.
pub fn speed_mean_mps(length_m: f64, time_s: f64) -> Option<f64> {
    (time_s > 0.0).then(|| length_m / time_s)
}

/// `goal_error_m`: distance from the true position at the end to the goal, m; less is better. For a failed
/// episode it is the remaining distance in a straight line.
pub fn goal_error_m(last: &Tick, goal: Vec2) -> f64 {
    (last.pose.position - goal).norm()
}

/// `turning_angle_deg`: Σ |Δθ| over the ticks driven, degrees, each Δθ wrapped; less is better
/// (cumulative heading change of `HuNavSim`).
pub fn turning_angle_deg(ticks: &[Tick]) -> f64 {
    heading_changes(ticks).map(f64::abs).sum::<f64>() * (180.0 / math::PI)
}

/// `turning_points`: the turns of the trajectory; less is better. A turn is a maximal run of ticks with
/// one sign of yaw rate and |ω| ≥ [`TURN_RATE_MIN_RADPS`] that changes the heading by at least [`TURN_MIN_RAD`] in all.
pub fn turning_points(ticks: &[Tick]) -> u32 {
    let (mut turns, mut run, mut sense) = (0, 0.0f64, 0.0);
    let mut close = |run: f64| turns += u32::from(run.abs() >= TURN_MIN_RAD);
    for (tick, change) in driven(ticks).iter().zip(heading_changes(ticks)) {
        let omega = tick.twist.omega;
        let turning = if omega.abs() >= TURN_RATE_MIN_RADPS { omega.signum() } else { 0.0 };
        if turning != sense {
            close(run);
            (run, sense) = (0.0, turning);
        }
        if turning != 0.0 {
            run += change;
        }
    }
    close(run);
    turns
}

/// `turning_steps`: ticks with |Δθ| > 0.5°; less is better (systems.md U-A11).
pub fn turning_steps(ticks: &[Tick]) -> u32 {
    heading_changes(ticks).filter(|change| change.abs() > TURNING_STEP_RAD).count() as u32
}

/// `clearance_min_m`: the smallest clearance at any moment, m; more is better, negative in penetration.
/// From the lower bounds of the ticks, so that a narrow pass between two ticks is not missed: the number may be up to a
/// millimetre below the truth. Without a contact it is at least 0.
pub fn clearance_min_m(trace: &Trace) -> Option<f64> {
    let low_m = trace.ticks.iter().map(|tick| tick.clearance_low_m).reduce(math::min)?;
    Some(without_bound_below_zero(low_m, trace))
}

/// A lower bound of a clearance, m: where the drive had no contact, the truth is at least 0.
pub(super) fn without_bound_below_zero(low_m: f64, trace: &Trace) -> f64 {
    if trace.contact_s.is_some() { low_m } else { math::max(low_m, 0.0) }
}

/// `clearance_mean_m`: mean clearance at the ends of the ticks driven, m; more is better. Undefined without a tick.
pub fn clearance_mean_m(ticks: &[Tick]) -> Option<f64> {
    mean(driven(ticks).iter().map(|tick| tick.clearance_m))
}

/// `near_miss_s`: time with a clearance below `near_miss_m`, judged at the end of each tick, s; less is better.
pub fn near_miss_s(trace: &Trace, near_miss_m: f64, dt_s: f64) -> f64 {
    trace.time_where_s(dt_s, |tick| tick.clearance_m < near_miss_m)
}

/// `stopped_s`: time with |v| < 0.01 m/s and |ω| < 0.02 rad/s ([`REST`]), s; less is better
/// (`HuNavSim`, `time_not_moving`).
pub fn stopped_s(trace: &Trace, dt_s: f64) -> f64 {
    trace.time_where_s(dt_s, |tick| tick.twist.v.abs() < REST.0 && tick.twist.omega.abs() < REST.1)
}

/// `curvature_max_1pm`: max |ω| / |v| over the ticks driven with |v| ≥ [`CURVATURE_SPEED_MIN_MPS`], 1/m; less is
/// better. A tick is an exact arc, so this is its exact curvature, whereas Menger's three-point formula depends on the
/// spacing of the points. Undefined if no tick is that fast (turns on the spot have no curvature).
pub fn curvature_max_1pm(ticks: &[Tick]) -> Option<f64> {
    let fast = driven(ticks).iter().map(|tick| tick.twist).filter(|twist| twist.v.abs() >= CURVATURE_SPEED_MIN_MPS);
    fast.map(|twist| twist.omega.abs() / twist.v.abs()).reduce(math::max)
}

/// `jerk_rms_mps3`: √mean((vₖ₊₁ − 2 vₖ + vₖ₋₁) / dt²)² of the true speed, row 0 included, m/s³; less is better.
/// Undefined with fewer than two ticks.
pub fn jerk_rms_mps3(ticks: &[Tick], dt_s: f64) -> Option<f64> {
    let jerk = ticks.windows(3).map(|t| (t[2].twist.v - 2.0 * t[1].twist.v + t[0].twist.v) / (dt_s * dt_s));
    mean(jerk.map(|jerk| jerk * jerk)).map(f64::sqrt)
}

/// `path_deviation_mean_m`: mean distance to the path in force over the ticks driven that had one, m; less is better.
/// Undefined if no tick had a path.
pub fn path_deviation_mean_m(ticks: &[Tick]) -> Option<f64> {
    mean(driven(ticks).iter().filter_map(|tick| tick.path_deviation_m))
}

/// `spl`: success weighted by path length, S · L / max(P, L) with L = `shortest_m`, P = `length_m`; 0 to 1, more is better
/// (P. Anderson et al., On evaluation of embodied navigation agents, 2018). 0 on failure. Undefined if L is undefined, also on
/// failure: such worlds would otherwise count only when they are lost.
pub fn spl(success: bool, length_m: f64, shortest_m: Option<f64>) -> Option<f64> {
    let shortest = shortest_m?;
    if !success {
        return Some(0.0);
    }
    // Start and goal in one place, nothing driven: nothing could be shorter.
    Some(if shortest == 0.0 && length_m == 0.0 { 1.0 } else { shortest / math::max(length_m, shortest) })
}

#[cfg(test)]
mod tests {
    use super::super::tests::{close, drive};
    use super::*;
    use crate::geometry::{Pose, Twist};

    const DT: f64 = 0.1;

    fn constant(v: f64, omega: f64, ticks: usize) -> Vec<Tick> {
        drive(Pose::new(0.0, 0.0, 0.0), &vec![Twist { v, omega }; ticks])
    }

    fn of(ticks: &[Tick]) -> Trace {
        Trace { ticks: ticks.to_vec(), ..Trace::default() }
    }

    #[test]
    fn a_contact_ends_length_and_times_within_its_tick() {
        // Ten ticks at 0.8 m/s, the last one ended after 0.025 s: 9 · 0.08 + 0.02 m, in contact for no time.
        let mut trace = of(&constant(0.8, 0.0, 10));
        assert!(close(length_m(&trace, DT), 0.8) && trace.row_time_s(10, DT) == 1.0);
        trace.contact_s = Some(0.025);
        assert!(close(length_m(&trace, DT), 0.74));
        assert_eq!((trace.row_time_s(10, DT), trace.row_time_s(9, DT)), (0.925, 0.9));
        trace.ticks.iter_mut().skip(8).for_each(|tick| tick.clearance_m = 0.1);
        assert!(close(near_miss_s(&trace, 0.2, DT), 0.225));
        trace.ticks[10].clearance_m = 1.0;
        assert!(close(near_miss_s(&trace, 0.2, DT), 0.2), "the last tick is not among them");
    }

    #[test]
    fn straight_drive() {
        // 50 ticks at 0.8 m/s: 4 m in 5 s, no turn.
        let ticks = constant(0.8, 0.0, 50);
        assert!(close(length_m(&of(&ticks), DT), 4.0));
        assert_eq!(speed_mean_mps(4.0, 5.0), Some(0.8));
        assert!(close(goal_error_m(&ticks[50], Vec2::new(4.0, 3.0)), 3.0));
        assert_eq!((turning_angle_deg(&ticks), turning_points(&ticks), turning_steps(&ticks)), (0.0, 0, 0));
        assert_eq!(curvature_max_1pm(&ticks), Some(0.0));
        assert_eq!(stopped_s(&of(&ticks), DT), 0.0);
    }

    #[test]
    fn two_circles() {
        // v 0.5, ω 0.4: radius 1.25 m. 2·2π / 0.4 = 31.4 s, so 314 ticks: 314 · 0.04 rad = 12.56 rad = 719.64°,
        // twice through ±π. Each tick turns by 2.29° > 0.5°. Curvature 0.8 1/m. Length 15.7 m.
        let ticks = constant(0.5, 0.4, 314);
        assert!(close(turning_angle_deg(&ticks), 12.56 * 180.0 / math::PI));
        assert_eq!((turning_points(&ticks), turning_steps(&ticks)), (1, 314));
        assert!(close(curvature_max_1pm(&ticks).unwrap(), 0.8));
        assert!(close(length_m(&of(&ticks), DT), 15.7));
    }

    #[test]
    fn zig_zag_counts_each_turn_once() {
        // Four turns of 10 ticks · 0.1 s · 0.3 rad/s = 0.3 rad = 17.2°, left and right in turn.
        let mut twists = Vec::new();
        for sign in [1.0, -1.0, 1.0, -1.0] {
            twists.extend([Twist { v: 1.0, omega: 0.3 * sign }; 10]);
        }
        let ticks = drive(Pose::new(0.0, 0.0, 3.1), &twists);
        assert_eq!((turning_points(&ticks), turning_steps(&ticks)), (4, 40));
        assert!(close(turning_angle_deg(&ticks), 1.2 * 180.0 / math::PI));
    }

    #[test]
    fn turning_points_need_rate_and_angle_and_end_at_a_pause() {
        let twist = |omega: f64| Twist { v: 1.0, omega };
        let turns = |runs: &[(f64, usize)]| {
            let twists: Vec<Twist> = runs.iter().flat_map(|&(omega, count)| vec![twist(omega); count]).collect();
            turning_points(&drive(Pose::new(0.0, 0.0, 0.0), &twists))
        };
        // 0.049 rad/s for 60 s is 168°, and no turn; 0.05 is one.
        assert_eq!(turns(&[(0.049, 600)]), 0);
        assert_eq!(turns(&[(0.05, 600)]), 1);
        // 8 ticks at 0.1 rad/s: 0.08 rad = 4.6°; 9 ticks: 5.2°.
        assert_eq!(turns(&[(0.1, 8)]), 0);
        assert_eq!(turns(&[(0.1, 9)]), 1);
        // Two halves of 4.6° with a straight tick between are no turn; without it they are one.
        assert_eq!(turns(&[(0.1, 8), (0.0, 1), (0.1, 8)]), 0);
        assert_eq!(turns(&[(0.1, 8), (0.1, 8)]), 1);
    }

    #[test]
    fn braking_has_the_jerk_of_its_two_kinks() {
        // v: 1, 1, 1, then 0.9 … 0.1, 0, 0, 0: second differences −0.1 at the onset, +0.1 at the stop, else 0.
        // Rows: initial (1) + 2 + 10 + 2 = 15, so 13 differences: √(2 · 0.1² / 13) / 0.01 = 3.922 m/s³.
        let mut speeds = vec![1.0, 1.0];
        speeds.extend((0..10).rev().map(|k| f64::from(k) / 10.0));
        speeds.extend([0.0, 0.0]);
        let twists: Vec<Twist> = speeds.iter().map(|&v| Twist { v, omega: 0.0 }).collect();
        let mut ticks = drive(Pose::new(0.0, 0.0, 0.0), &twists);
        ticks[0].twist.v = 1.0;
        assert!(close(jerk_rms_mps3(&ticks, DT).unwrap(), (0.02f64 / 13.0).sqrt() / 0.01));
        assert!(close(stopped_s(&of(&ticks), DT), 0.3));
        assert_eq!(jerk_rms_mps3(&ticks[..2], DT), None);
    }

    #[test]
    fn turning_on_the_spot_is_neither_rest_nor_curvature() {
        let ticks = constant(0.0, 0.5, 20);
        assert_eq!(curvature_max_1pm(&ticks), None);
        assert_eq!((stopped_s(&of(&ticks), DT), length_m(&of(&ticks), DT)), (0.0, 0.0));
        assert!(close(turning_angle_deg(&ticks), 180.0 / math::PI));
        // Backwards the length still grows, and the curvature has no sign.
        let ticks = constant(-0.5, 0.25, 10);
        assert!(close(length_m(&of(&ticks), DT), 0.5) && close(curvature_max_1pm(&ticks).unwrap(), 0.5));
    }

    #[test]
    fn clearances_and_deviations() {
        let mut ticks = constant(1.0, 0.0, 4);
        for (tick, (end, low)) in
            ticks.iter_mut().zip([(0.1, 0.1), (0.5, 0.05), (0.15, 0.15), (0.2, -0.01), (0.3, 0.2)])
        {
            (tick.clearance_m, tick.clearance_low_m) = (end, low);
        }
        assert_eq!(clearance_min_m(&of(&ticks)), Some(0.0), "no contact was found: −0.01 is a bound below the truth");
        assert_eq!(clearance_min_m(&Trace { contact_s: Some(0.1), ..of(&ticks) }), Some(-0.01));
        assert!(close(clearance_mean_m(&ticks).unwrap(), 1.15 / 4.0)); // the initial 0.1 is no tick
        assert!(close(near_miss_s(&of(&ticks), 0.2, DT), 0.1)); // 0.15 alone: 0.2 is not below 0.2
        assert_eq!(path_deviation_mean_m(&ticks), None);
        (ticks[2].path_deviation_m, ticks[4].path_deviation_m) = (Some(0.2), Some(0.4));
        assert!(close(path_deviation_mean_m(&ticks).unwrap(), 0.3));
    }

    #[test]
    fn spl_weighs_success_by_length() {
        assert_eq!(spl(true, 12.5, Some(10.0)), Some(0.8));
        assert_eq!(spl(true, 9.9, Some(10.0)), Some(1.0)); // stopped within the tolerance
        assert_eq!(spl(false, 12.5, Some(10.0)), Some(0.0));
        assert_eq!((spl(true, 12.5, None), spl(false, 12.5, None)), (None, None));
        assert_eq!(spl(true, 0.0, Some(0.0)), Some(1.0));
    }
}
