//! The end of a drive that has to stand at its goal: within the tolerance the stack brakes and turns on the spot by itself, so
//! that every local planner can end with a heading.

use crate::geometry::Twist;
use crate::math;
use crate::plan::contract::{Arrival, Decision, Situation, State};

/// Share of the tolerance of the heading below which the stack turns no more.
const SHARE: f64 = 0.5;

/// The stack's own decision at the goal; `None` while the local planner drives. Where the robot brakes too late and leaves the
/// tolerance again, the local planner brings it back.
pub(super) fn decide(situation: &Situation<'_>) -> Option<Decision> {
    let Situation { arrival, pose, twist, robot, .. } = situation;
    if !arrival.must_stand || !arrival.is_near(situation.goal, pose.position) {
        return None;
    }
    let left_rad = arrival.turn_left_rad(pose.theta);
    let turns = twist.v.abs() <= Arrival::SPEED_MPS && left_rad.abs() > SHARE * arrival.heading_tolerance_rad;
    let omega = if turns {
        // The highest yaw rate from which the robot can still stop in time, if it keeps it for this tick.
        let step = 0.5 * robot.yaw_acceleration_max_radps2 * situation.dt_s;
        let fastest = (step * step + 2.0 * robot.yaw_acceleration_max_radps2 * left_rad.abs()).sqrt() - step;
        math::sign(left_rad) * math::min(fastest, robot.yaw_rate_max_radps)
    } else {
        0.0
    };
    let command = robot.within_wheel_limits(Twist { v: 0.0, omega });
    Some(Decision { state: State::ARRIVE, ..Decision::track(command) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pose, Vec2, wrap_angle};
    use crate::map::OccupancyGrid;
    use crate::observation::Belief;
    use crate::robot::Robot;

    const GOAL: Vec2 = Vec2::new(5.0, 5.0);

    /// Ticks until a robot that enters the tolerance at `v`, 0.2 m before the goal, stands there with the heading asked for.
    fn ticks_to_stand(v: f64, heading_rad: Option<f64>, robot: &Robot) -> u32 {
        let belief = Belief::from(&OccupancyGrid::empty(10, 10, 1.0));
        let arrival = Arrival { must_stand: true, heading_rad, ..Arrival::default() };
        let (mut pose, mut twist) = (Pose::new(4.8, 5.0, 0.0), Twist { v, omega: 0.0 });
        for tick in 0..2000 {
            if arrival.is_met(GOAL, pose, twist) {
                return tick;
            }
            let situation = Situation { arrival, twist, ..Situation::new(robot, &belief, pose, GOAL) };
            let decision = decide(&situation).expect("near the goal");
            assert_eq!(decision.state, State::ARRIVE);
            twist = robot.actuate(twist, decision.command, 0.1);
            pose = pose.advance(twist, 0.1);
        }
        panic!("it never stands: {pose:?} {twist:?}");
    }

    #[test]
    fn it_brakes_and_turns_the_short_way_without_swinging() {
        let robot = Robot::default();
        // 0.49 m/s less 0.05 m/s a tick: below 0.05 m/s after 9 of them.
        assert_eq!((ticks_to_stand(0.0, None, &robot), ticks_to_stand(0.49, None, &robot)), (0, 9));
        // 1 rad/s after 0.5 s, then π rad less the way of both ramps; a swing would take longer.
        for heading in [math::PI, -3.0, 1.5, -1.5, 0.11] {
            let turn_s = wrap_angle(heading).abs() / robot.yaw_rate_max_radps + 1.0;
            assert!(f64::from(ticks_to_stand(0.0, Some(heading), &robot)) * 0.1 <= turn_s + 0.2, "{heading}");
        }
        assert_eq!(ticks_to_stand(0.0, Some(0.09), &robot), 0, "within the tolerance");
        let slow = Robot { yaw_rate_max_radps: 0.035, yaw_acceleration_max_radps2: 0.1, ..robot };
        assert!(ticks_to_stand(0.0, Some(-3.0), &slow) < 900);
    }

    #[test]
    fn elsewhere_and_where_passing_is_enough_the_local_planner_drives() {
        let (robot, belief) = (Robot::default(), Belief::from(&OccupancyGrid::empty(10, 10, 1.0)));
        let stand = Arrival { must_stand: true, ..Arrival::default() };
        let at = |x: f64, arrival: Arrival| {
            decide(&Situation { arrival, ..Situation::new(&robot, &belief, Pose::new(x, 5.0, 0.0), GOAL) }).is_some()
        };
        assert!(at(4.8, stand) && !at(4.7, stand) && !at(4.8, Arrival::default()));
    }
}
