//! Local planners: a situation and the guidance of the global path become a twist.
//!
//! One file per planner, each with its `Params` and `ENTRY`; a new planner is one new file and one
//! line in the registry below. The shared dynamic window is in `window`.

use super::contract::{Entry, Fit, LocalPlanner};
use crate::math;
use crate::robot::Robot;
use crate::settings::registry;

pub mod window;

/// Behaviour of the parameters of a local planner.
pub trait LocalKind {
    /// A fresh planner.
    fn build(&self) -> Box<dyn LocalPlanner>;

    /// Whether the parameters fit this map and robot.
    ///
    /// # Errors
    /// A message that says what does not fit.
    fn check(&self, _: &Fit<'_>) -> Result<(), String> {
        Ok(())
    }
}

registry! {
    /// A local planner with its parameters.
    pub enum LocalChoice: "local planner", Entry, dyn LocalKind {
        dwa,
        imp_dwa,
        pdwa,
        fuzzy_dwa,
        barr_dwa,
        follow_dwa,
        pure_pursuit,
    }
}

impl LocalChoice {
    /// A fresh planner.
    pub fn build(&self) -> Box<dyn LocalPlanner> {
        self.kind().build()
    }
}

/// Highest speed, m/s, with which the robot can still stop within `left_m` if it drives it for this tick.
///
/// It drives v for a tick and a·dt less in each that follows: with n more ticks (n + 1) v dt − a dt² n (n + 1) / 2, where n is
/// the number of whole steps a·dt in v.
fn stopping_speed_mps(left_m: f64, robot: &Robot, dt_s: f64) -> f64 {
    let lost = robot.deceleration_max_mps2 * dt_s;
    let n = (0.5 * ((1.0 + 8.0 * left_m / (lost * dt_s)).sqrt() - 1.0)).floor();
    left_m / ((n + 1.0) * dt_s) + 0.5 * lost * n
}

/// Yaw rate for turning in place by `bearing` rad, rad/s: as fast as the limits allow without overshooting within the tick.
fn turn_in_place(bearing: f64, robot: &Robot, dt_s: f64) -> f64 {
    let stoppable = (2.0 * robot.yaw_acceleration_max_radps2 * bearing.abs()).sqrt();
    let rate = math::min(robot.yaw_rate_max_radps, math::min(stoppable, bearing.abs() / dt_s));
    if bearing < 0.0 { -rate } else { rate }
}

/// The planner that the guide writes step by step.
#[cfg(test)]
#[path = "../../../docs/book/code/turn_and_drive.rs"]
mod turn_and_drive;

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::geometry::{Path, Pose, Twist, Vec2};
    use crate::map::{Cell, OccupancyGrid};
    use crate::observation::{Belief, SensedObstacle};
    use crate::plan::contract::{Decision, Failure, Guidance, Request, Situation, State};
    use crate::rng::{EpisodeSeed, Purpose};

    /// Asks, in 300 random places among random obstacles and beside a mover, for a planner's decision and for the best admissible twist by its
    /// formula, which must be the same.
    pub(crate) fn drives_what_its_formula_says(
        seed: u64,
        mut ask: impl FnMut(usize, &Situation<'_>, &Guidance<'_>) -> (Decision, Option<Twist>),
    ) {
        let mut stream = EpisodeSeed { seed, episode: 0 }.stream(Purpose::Planner, 0);
        let mut tracked = 0;
        for case in 0..300 {
            let mut grid = OccupancyGrid::empty(20, 20, 1.0);
            for index in 0..400 {
                if stream.uniform() < 0.06 {
                    grid.set_occupied(grid.cell(index));
                }
            }
            let (belief, robot) = (Belief::from(&grid), Robot::default());
            let mut point = || Vec2::new(stream.range(1.0, 19.0), stream.range(1.0, 19.0));
            let (here, from, goal) = (point(), point(), point());
            let movers = [SensedObstacle::disc(0, point(), 0.1 * (point() - point()), 0.3)];
            let pose = Pose::new(here.x, here.y, stream.range(-3.0, 3.0));
            let twist = Twist { v: stream.uniform(), omega: stream.range(-1.0, 1.0) };
            let path = Path::polyline(&[from, goal]);
            let situation = Situation { twist, obstacles: &movers, ..Situation::new(&robot, &belief, pose, goal) };
            match ask(case, &situation, &Guidance::to_end(&path, 0.0)) {
                (decision, Some(best)) => {
                    assert_eq!((decision.command, decision.state), (best, State::TRACK), "case {case}");
                    tracked += 1;
                }
                (decision, None) => assert_eq!(decision.state, State::RECOVER, "case {case}"),
            }
        }
        assert!(tracked > 150, "{tracked}");
    }

    /// A small closed loop: one robot, one map, movers at constant velocity, exact arcs, ten looks a tick.
    pub(crate) struct Course {
        pub(crate) robot: Robot,
        pub(crate) grid: OccupancyGrid,
        pub(crate) start: Pose,
        pub(crate) movers: Vec<SensedObstacle>,
        pub(crate) path: Path,
        /// Cells that turn out to be occupied.
        pub(crate) unexpected: Vec<Cell>,
    }

    /// Result of a drive.
    #[derive(Debug, PartialEq)]
    pub(crate) struct Drive {
        /// Pose after each tick; the drive ends within 0.25 m of the end of the path.
        pub(crate) poses: Vec<Pose>,
        pub(crate) decisions: Vec<Decision>,
        /// Least distance from the robot's edge to anything, m.
        pub(crate) clearance_m: f64,
        pub(crate) arrived: bool,
    }

    impl Course {
        /// Open space of 40 m by 40 m, and the straight line to the goal as path.
        pub(crate) fn open(start: Pose, goal: Vec2) -> Self {
            let grid = OccupancyGrid::empty(40, 40, 1.0);
            let path = Path::polyline(&[start.position, goal]);
            Self { robot: Robot::default(), grid, start, movers: Vec::new(), path, unexpected: Vec::new() }
        }

        /// Drives for at most `ticks`, with a planner from `planner` for each tick.
        pub(crate) fn drive(
            &self,
            ticks: u32,
            mut planner: impl FnMut(&Situation<'_>, &Guidance<'_>) -> Result<Decision, Failure>,
        ) -> Drive {
            let mut belief = Belief::from(&self.grid);
            for &cell in &self.unexpected {
                let square = self.grid.square(cell);
                belief.add(square, |other| other == square);
            }
            let (goal, dt_s) = (self.path.end(), 0.1);
            let (mut pose, mut twist, mut movers, mut progress_m) = (self.start, Twist::ZERO, self.movers.clone(), 0.0);
            let mut drive = Drive { poses: vec![], decisions: vec![], clearance_m: f64::INFINITY, arrived: false };
            for tick in 0..ticks {
                progress_m = math::max(progress_m, self.path.project(pose.position).0);
                let situation = Situation {
                    tick,
                    dt_s,
                    twist,
                    obstacles: &movers,
                    ..Situation::new(&self.robot, &belief, pose, goal)
                };
                let guidance = Guidance::to_end(&self.path, progress_m);
                let decision = planner(&situation, &guidance).expect("an answer");
                if let Some(Request::GoBack { to_m }) = decision.request {
                    progress_m = math::min(progress_m, to_m);
                }
                let reached = self.robot.actuate(twist, decision.command, dt_s);
                twist = reached;
                for _ in 0..10 {
                    pose = pose.advance(twist, 0.1 * dt_s);
                    for mover in &mut movers {
                        mover.position += mover.velocity * (0.1 * dt_s);
                    }
                    drive.clearance_m =
                        math::min(drive.clearance_m, self.clearance_m(belief.grid(), pose.position, &movers));
                }
                drive.poses.push(pose);
                drive.decisions.push(decision);
                if (pose.position - goal).norm() <= 0.25 {
                    drive.arrived = true;
                    break;
                }
            }
            drive
        }

        pub(crate) fn clearance_m(&self, grid: &OccupancyGrid, p: Vec2, movers: &[SensedObstacle]) -> f64 {
            let extent = grid.extent_m();
            let mut nearest = math::min(math::min(p.x, extent.x - p.x), math::min(p.y, extent.y - p.y));
            for (index, _) in grid.occupied().iter().enumerate().filter(|&(_, &occupied)| occupied) {
                nearest = math::min(nearest, grid.square(grid.cell(index)).signed_distance(p));
            }
            for mover in movers {
                nearest = math::min(nearest, (p - mover.position).norm() - mover.radius_m());
            }
            nearest - self.robot.radius_m
        }
    }

    #[test]
    fn the_planner_of_the_guide_is_one_as_the_registry_wants_them() {
        let params: turn_and_drive::Params = serde_yaml::from_str("gain_hz: 2").unwrap();
        assert_eq!(params.build().entry().summary, turn_and_drive::ENTRY.summary);
    }
}
