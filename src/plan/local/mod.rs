//! Local planners: an observation and the guidance of the global path become a twist.
//!
//! One file per planner, each with its `Params` and `ENTRY`; a new planner is one new file and one
//! line in the registry below. The shared dynamic window is in `window`.

use super::Entry;
use crate::geometry::{Path, Twist, Vec2};
use crate::math;
use crate::observation::Observation;
use crate::robot::Robot;
use crate::settings::choice::choice;

pub mod window;

macro_rules! registry {
    ($($module:ident),+ $(,)?) => {
        $(pub mod $module;)+

        choice! {
            /// A local planner with its parameters.
            pub enum LocalChoice: "local planner" { $($module = $module::ENTRY.summary),+ }
        }

        impl LocalChoice {
            /// A fresh planner.
            pub fn build(&self) -> Box<dyn LocalPlanner> {
                match self { $(Self::$module(params) => Box::new($module::Planner::new(params))),+ }
            }

            /// What the registry says of each planner, in the order of [`Self::NAMES`].
            pub const ENTRIES: &'static [Entry] = &[$($module::ENTRY),+];
        }
    };
}

registry! {
    dwa,
    imp_dwa,
    pure_pursuit,
}

/// What the global layer tells the local one.
#[derive(Clone, Copy, Debug)]
pub struct Guidance<'a> {
    /// The path in force, grid frame; a stand-alone local planner gets the straight line to the goal.
    pub path: &'a Path,
    /// Arc length of the point of `path` nearest to the robot's progress, m; never decreases on one path.
    pub progress_m: f64,
    /// The key node before the current sub-goal (the path's start at first).
    pub previous_node: Vec2,
    /// The key node to steer for.
    pub sub_goal: Vec2,
    /// Whether `sub_goal` is the last one, the goal.
    pub is_last: bool,
    /// Increases by one whenever a new path comes into force.
    pub path_revision: u32,
}

/// What a local planner is doing; a column of the trace.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Following or optimising as usual.
    #[default]
    Track,
    /// No admissible command existed: braking or turning on the spot.
    Recover,
}

impl Mode {
    /// The name in traces.
    pub fn name(self) -> &'static str {
        match self {
            Self::Track => "track",
            Self::Recover => "recover",
        }
    }
}

/// The answer of a local planner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// What to drive.
    pub command: Twist,
    /// What the planner is doing.
    pub mode: Mode,
    /// Candidate trajectories simulated for this decision.
    pub rollouts: u64,
    /// Poses simulated in all of them: what a decision costs where a scenario charges for it.
    pub rollout_points: u64,
}

impl Decision {
    /// Standing still; nothing was simulated.
    pub const STAND: Self = Self::track(Twist::ZERO);

    /// `command`, chosen without simulating anything.
    pub const fn track(command: Twist) -> Self {
        Self { command, mode: Mode::Track, rollouts: 0, rollout_points: 0 }
    }
}

/// Turns an observation and the guidance of a path into a command, once per tick.
///
/// A planner may keep workspaces and, between [`reset`](Self::reset)s, its own state of the episode;
/// its answer may depend on nothing else. It never reads a clock.
pub trait LocalPlanner: Send {
    /// The command for this tick.
    fn decide(&mut self, observation: &Observation<'_>, guidance: &Guidance<'_>) -> Decision;

    /// Forgets everything: called before each episode.
    fn reset(&mut self) {}
}

/// The yaw rate, rad/s, with which to turn by `bearing` rad on the spot: as fast as the drive may, but able to stop at the
/// bearing and not past it within the tick.
fn turn_on_the_spot(bearing: f64, robot: &Robot, dt_s: f64) -> f64 {
    let stoppable = (2.0 * robot.yaw_acceleration_radps2 * bearing.abs()).sqrt();
    let rate = math::min(robot.yaw_rate_max_radps, math::min(stoppable, bearing.abs() / dt_s));
    if bearing < 0.0 { -rate } else { rate }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::OccupancyGrid;
    use crate::observation::{Belief, SensedObstacle};

    /// A small closed loop: one robot, one map, movers at constant velocity, exact arcs, ten looks a tick.
    pub(crate) struct Course {
        pub(crate) robot: Robot,
        pub(crate) grid: OccupancyGrid,
        pub(crate) start: Pose,
        pub(crate) movers: Vec<SensedObstacle>,
        pub(crate) path: Path,
    }

    /// How a drive went.
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
            Self { robot: Robot::default(), grid, start, movers: Vec::new(), path }
        }

        /// Drives for at most `ticks`, with a planner from `planner` for each tick.
        pub(crate) fn drive(
            &self,
            ticks: u32,
            mut planner: impl FnMut(&Observation<'_>, &Guidance<'_>) -> Decision,
        ) -> Drive {
            let belief = Belief::from(&self.grid);
            let (goal, dt_s) = (self.path.end(), 0.1);
            let (mut pose, mut twist, mut movers, mut progress_m) = (self.start, Twist::ZERO, self.movers.clone(), 0.0);
            let mut drive = Drive { poses: vec![], decisions: vec![], clearance_m: f64::INFINITY, arrived: false };
            for tick in 0..ticks {
                progress_m = math::max(progress_m, self.path.project(pose.position).0);
                let robot = &self.robot;
                let observation = Observation {
                    tick,
                    dt_s,
                    pose,
                    twist,
                    belief: &belief,
                    obstacles: &movers,
                    scan: None,
                    goal,
                    robot,
                };
                let guidance = Guidance {
                    path: &self.path,
                    progress_m,
                    previous_node: self.path.start(),
                    sub_goal: goal,
                    is_last: true,
                    path_revision: 0,
                };
                let decision = planner(&observation, &guidance);
                let reached = self.robot.actuate(twist, decision.command, dt_s);
                twist = reached;
                for _ in 0..10 {
                    pose = pose.advance(twist, 0.1 * dt_s);
                    for mover in &mut movers {
                        mover.position += mover.velocity * (0.1 * dt_s);
                    }
                    drive.clearance_m = math::min(drive.clearance_m, self.clearance_m(pose.position, &movers));
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

        pub(crate) fn clearance_m(&self, p: Vec2, movers: &[SensedObstacle]) -> f64 {
            let extent = self.grid.extent_m();
            let mut nearest = math::min(math::min(p.x, extent.x - p.x), math::min(p.y, extent.y - p.y));
            for (index, _) in self.grid.occupied().iter().enumerate().filter(|&(_, &occupied)| occupied) {
                nearest = math::min(nearest, self.grid.square(self.grid.cell(index)).signed_distance(p));
            }
            for mover in movers {
                nearest = math::min(nearest, (p - mover.position).norm() - mover.radius_m());
            }
            nearest - self.robot.radius_m
        }
    }
}
