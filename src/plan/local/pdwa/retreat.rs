//! The way back: pure pursuit of the path with the tail ahead, as far as nothing is behind.

use super::Params;
use crate::geometry::{Twist, Vec2, wrap_angle};
use crate::math;
use crate::plan::clearance::Obstacles;
use crate::plan::contract::{Decision, Guidance, Request, Situation};
use crate::plan::local::turn_in_place;

/// A robot whose tail points farther than this away from the way back turns on the spot first, rad.
const ALIGNED_RAD: f64 = 0.25 * math::PI;
/// The way back is looked at for this long, s.
const LOOK_S: f64 = 1.0;
/// Gap that it keeps, m.
const GAP_M: f64 = 0.05;
/// Stretch of the path, behind and ahead, in which the robot's place on it is looked for, m.
const STRETCH_M: f64 = 1.0;

/// One tick of the way back: the command, and the robot's place on the path as the progress from now on. It stands where the way back
/// is not clear.
pub(super) fn back_up(params: &Params, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Decision {
    let Situation { pose, robot, dt_s, .. } = *situation;
    let along_m = math::max(guidance.progress_m - params.lookahead_m.get(), 0.0);
    let target = guidance.path.point_at(along_m);
    let bearing = pose.bearing_to(target);
    let tail_rad = wrap_angle(bearing - math::PI);
    let command = if tail_rad.abs() > ALIGNED_RAD {
        Twist { v: 0.0, omega: turn_in_place(tail_rad, robot, dt_s) }
    } else {
        let v = -math::min(params.retreat_speed_mps.get(), robot.reverse_speed_max_mps);
        let away_m = (target - pose.position).norm();
        let curvature = if away_m > 0.0 { 2.0 * math::sin(bearing) / away_m } else { 0.0 };
        let omega = math::clamp(v * curvature, -robot.yaw_rate_max_radps, robot.yaw_rate_max_radps);
        Twist { v, omega }
    };
    let command = if is_clear(situation, command) { command } else { Twist::ZERO };
    let nearest_m =
        guidance.path.project_within(pose.position, guidance.progress_m - STRETCH_M, guidance.progress_m + STRETCH_M);
    Decision { request: Some(Request::GoBack { to_m: nearest_m.0 }), ..Decision::track(command) }
}

/// Whether a robot that keeps `twist` comes no nearer than the gap to anything, or no nearer than if it stood.
fn is_clear(situation: &Situation<'_>, twist: Twist) -> bool {
    let Situation { pose, robot, dt_s, belief, obstacles: movers, .. } = *situation;
    let (statics, gap_m) = (Obstacles::new(belief.grid(), belief.field()), robot.radius_m + GAP_M);
    let ticks = (LOOK_S / dt_s).round().clamp(1.0, 1e4) as u32;
    let here = pose.position;
    let standing_m = statics.clearance(here, gap_m);
    (1..=ticks).all(|tick| {
        let time_s = f64::from(tick) * dt_s;
        let there = pose.advance(twist, time_s).position;
        let passes = |there_m: f64, standing_m: f64| there_m >= gap_m || there_m >= standing_m;
        passes(statics.clearance(there, gap_m), standing_m)
            && movers.iter().all(|mover| {
                let centre = mover.position + mover.velocity * time_s;
                let away_m = |p: Vec2| (p - centre).norm() - mover.radius_m();
                passes(away_m(there), away_m(here))
            })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Path, Pose};
    use crate::map::{Cell, OccupancyGrid};
    use crate::observation::{Belief, SensedObstacle};
    use crate::robot::Robot;

    fn reversing() -> Robot {
        Robot { reverse_speed_max_mps: 0.5, ..Robot::default() }
    }

    #[test]
    fn it_backs_along_the_path_round_its_corner() {
        let path = Path::polyline(&[Vec2::new(10.0, 10.0), Vec2::new(14.0, 10.0), Vec2::new(14.0, 14.0)]);
        let belief = Belief::from(&OccupancyGrid::empty(20, 20, 1.0));
        let robot = reversing();
        let (mut pose, mut progress_m) = (Pose::new(14.0, 13.0, math::FRAC_PI_2), 7.0);
        let (mut aside_m, mut ticks) = (0.0_f64, 0);
        while progress_m > 0.1 && ticks < 600 {
            let situation = Situation::new(&robot, &belief, pose, path.end());
            let decision = back_up(&Params::default(), &situation, &Guidance::to_end(&path, progress_m));
            assert!(decision.command.v == -0.2 && decision.command.omega.abs() <= robot.yaw_rate_max_radps);
            pose = pose.advance(decision.command, 0.1);
            let Some(Request::GoBack { to_m }) = decision.request else { panic!("no request") };
            progress_m = math::min(progress_m, to_m);
            aside_m = math::max(aside_m, path.project(pose.position).1);
            ticks += 1;
        }
        // 7 m at 0.2 m/s are 350 ticks; the tail cuts the corner, and the robot ends where the path begins, facing along it.
        assert!(ticks < 360 && aside_m < 0.4, "{ticks} ticks, {aside_m} m");
        assert!((pose.position - path.start()).norm() < 0.2 && pose.theta.abs() < 0.1, "{pose:?}");
    }

    #[test]
    fn it_stands_where_something_is_behind_and_turns_where_its_tail_points_away() {
        let path = Path::polyline(&[Vec2::new(10.0, 10.5), Vec2::new(18.0, 10.5)]);
        let mut grid = OccupancyGrid::empty(20, 20, 1.0);
        let robot = reversing();
        let back = |grid: &OccupancyGrid, pose: Pose, movers: &[SensedObstacle]| {
            let belief = Belief::from(grid);
            let situation = Situation { obstacles: movers, ..Situation::new(&robot, &belief, pose, path.end()) };
            back_up(&Params::default(), &situation, &Guidance::to_end(&path, 4.0)).command
        };
        let pose = Pose::new(14.0, 10.5, 0.0);
        let mover = |x: f64, vx: f64| [SensedObstacle::disc(0, Vec2::new(x, 10.5), Vec2::new(vx, 0.0), 0.3)];
        assert_eq!(back(&grid, pose, &[]).v, -0.2);
        // 14 − 13.3 − 0.3 − 0.25 = 0.15 m; 0.2 m of way, and a gap of 0.05 m.
        assert_eq!(
            (back(&grid, pose, &mover(13.3, 0.0)), back(&grid, pose, &mover(13.15, 0.0)).v),
            (Twist::ZERO, -0.2)
        );
        // One that comes from behind holds it; one that flees does not, nor one that is near or comes ahead.
        assert_eq!((back(&grid, pose, &mover(13.0, 0.6)).v, back(&grid, pose, &mover(13.3, -0.6)).v), (0.0, -0.2));
        assert_eq!((back(&grid, pose, &mover(14.58, 0.0)).v, back(&grid, pose, &mover(15.2, -1.0)).v), (-0.2, -0.2));
        grid.set_occupied(Cell { col: 12, row: 10 });
        assert_eq!(back(&grid, Pose::new(13.4, 10.5, 0.0), &[]), Twist::ZERO);
        let aside = back(&grid, Pose::new(16.0, 10.5, math::FRAC_PI_2), &[]);
        assert!(aside.v == 0.0 && aside.omega < 0.0, "{aside:?}");
    }
}
