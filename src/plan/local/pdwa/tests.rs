use super::*;
use crate::geometry::{KeyNode, Path, Pose, Vec2};
use crate::map::{Cell, OccupancyGrid};
use crate::observation::{Belief, SensedObstacle};
use crate::plan::local::tests::Course;
use crate::plan::local::window::{HeadingAt, Normalise};

/// The paper's form, but with exact arcs and room for the way from one predicted pose to the next.
fn printed() -> Params {
    let avoid = dwa::Params {
        heading_weight: NonNegative::new(0.2),
        distance_weight: NonNegative::new(0.04),
        velocity_weight: NonNegative::new(0.3),
        normalise: Normalise::Sum,
        horizon_s: Some(Positive::new(3.0)),
        heading_at: HeadingAt::Horizon,
        ..dwa::Params::default()
    };
    Params { split: Split::TurningPoints, stall_s: NonNegative::new(0.0), avoid, ..Params::default() }
}

/// A lane of one cell along y = 10.5 with a key node every 5 m, and a robot in it that the test moves by hand.
struct Lane {
    robot: Robot,
    belief: Belief,
    path: Path,
    nodes: Vec<KeyNode>,
    planner: Planner,
    progress_m: f64,
    tick: u32,
}

impl Lane {
    fn new(params: &Params) -> Self {
        let mut grid = OccupancyGrid::empty(30, 20, 1.0);
        for col in 0..30 {
            grid.set_occupied(Cell { col, row: 9 });
            grid.set_occupied(Cell { col, row: 11 });
        }
        let path = Path::polyline(&[Vec2::new(2.5, 10.5), Vec2::new(22.5, 10.5)]);
        let node = |k: u32| KeyNode { position: path.point_at(5.0 * f64::from(k)), along_m: 5.0 * f64::from(k) };
        let nodes = (0..=4).map(node).collect();
        let robot = Robot { reverse_speed_max_mps: 0.3, ..Robot::default() };
        let planner = Planner::new(params);
        Self { robot, belief: Belief::from(&grid), path, nodes, planner, progress_m: 12.0, tick: 0 }
    }

    /// One tick of a robot that stands at its progress; a mover comes at it from 1.2 m ahead at 1 m/s if `is_blocked`.
    fn tick(&mut self, is_blocked: bool) -> Decision {
        let pose = Pose::new(2.5 + self.progress_m, 10.5, 0.0);
        let ahead = Vec2::new(pose.position.x + 1.2, 10.5);
        let movers = [SensedObstacle::disc(0, ahead, Vec2::new(-1.0, 0.0), 0.3)];
        let situation = Situation {
            tick: self.tick,
            obstacles: if is_blocked { &movers } else { &[] },
            ..Situation::new(&self.robot, &self.belief, pose, self.path.end())
        };
        let guidance = Guidance { key_nodes: &self.nodes, ..Guidance::to_end(&self.path, self.progress_m) };
        let decision = self.planner.decide(&situation, &guidance).expect("an answer");
        if let Some(Request::GoBack { to_m }) = decision.request {
            assert!(to_m <= self.progress_m + 1e-9);
            self.progress_m += 0.1 * decision.command.v;
        }
        self.tick += 1;
        decision
    }

    /// The states of `ticks` ticks, each with the number of ticks in a row.
    fn states(&mut self, ticks: u32, is_blocked: bool) -> Vec<(&'static str, u32)> {
        let mut runs: Vec<(&'static str, u32)> = Vec::new();
        for _ in 0..ticks {
            let state = self.tick(is_blocked).state.name;
            match runs.last_mut() {
                Some(run) if run.0 == state => run.1 += 1,
                _ => runs.push((state, 1)),
            }
        }
        runs
    }
}

#[test]
fn it_retreats_looks_again_withdraws_and_waits_as_documented() {
    let mut lane = Lane::new(&printed());
    assert_eq!(lane.states(5, false), [("follow", 5)]);
    // Nothing is admissible: backwards for a second at least, and on while nothing changes.
    assert_eq!(lane.states(15, true), [("retreat", 15)]);
    assert!((lane.progress_m - 11.7).abs() < 1e-9);
    assert_eq!(lane.states(1, false), [("follow", 1)]);
    // The first attempt and four more in the same region; the sixth failure is beyond N_max.
    for _ in 0..4 {
        assert_eq!(lane.states(10, true), [("retreat", 10)]);
        assert_eq!(lane.states(1, false), [("follow", 1)]);
    }
    lane.progress_m = 10.5;
    // Back to the beginning of region 1, at 5 m: 5.45 m at 0.02 m a tick.
    let withdrawn = lane.states(400, true);
    assert_eq!(withdrawn[0].0, "withdraw");
    assert!((271..=274).contains(&withdrawn[0].1), "{withdrawn:?}");
    // There it stands for 10 s, tries and fails, and backs into the region before.
    assert_eq!(withdrawn[1..], [("wait", 100), ("retreat", 300 - withdrawn[0].1)]);
    let until_begin = lane.states(300, true);
    assert_eq!(until_begin.iter().map(|run| run.0).collect::<Vec<_>>(), ["retreat", "wait"]);
    let before = lane.progress_m;
    assert_eq!((lane.tick(true).command, lane.progress_m), (Twist::ZERO, before));
    // A second without conflict, and it goes on.
    assert_eq!(lane.states(12, false), [("wait", 9), ("follow", 3)]);
}

#[test]
fn the_first_region_has_none_before_so_the_start_is_the_safe_place() {
    let mut lane = Lane::new(&printed());
    lane.progress_m = 1.0;
    let states = lane.states(60, true);
    // 0.95 m at 0.02 m a tick.
    assert_eq!(states.iter().map(|run| run.0).collect::<Vec<_>>(), ["retreat", "wait"]);
    assert!((47..=49).contains(&states[0].1), "{states:?}");
}

#[test]
fn a_robot_that_cannot_reverse_waits_where_it_is() {
    let mut lane = Lane::new(&printed());
    lane.robot.reverse_speed_max_mps = 0.0;
    assert_eq!(lane.states(50, true), [("wait", 50)]);
    assert_eq!(lane.progress_m, 12.0);
}

#[test]
fn attempts_count_by_region() {
    let mut lane = Lane::new(&printed());
    let failures = |decision: &Decision| decision.notes.values()[2];
    assert_eq!(failures(&lane.tick(true)), 1.0);
    lane.states(10, true);
    assert_eq!(failures(&lane.tick(false)), 1.0);
    assert_eq!(failures(&lane.tick(true)), 2.0);
    // Beyond the region it begins again.
    (lane.progress_m, lane.planner.progress) = (15.5, Progress { failures: 2, failed_region: 2, ..Progress::BEGIN });
    assert_eq!(failures(&lane.tick(false)), 0.0);
}

#[test]
fn a_conflict_is_what_the_robot_would_come_too_near_to_in_time() {
    let mut lane = Lane::new(&printed());
    let mut conflict = |x: f64, y: f64, vx: f64, vy: f64, at: f64| {
        lane.progress_m = at;
        let movers = [SensedObstacle::disc(0, Vec2::new(x, y), Vec2::new(vx, vy), 0.3)];
        let pose = Pose::new(2.5 + at, 10.5, 0.0);
        let situation =
            Situation { obstacles: &movers, ..Situation::new(&lane.robot, &lane.belief, pose, lane.path.end()) };
        let guidance = Guidance { key_nodes: &lane.nodes, ..Guidance::to_end(&lane.path, at) };
        let mut planner = Planner::new(&printed());
        planner.regions.follow(&guidance, &planner.params);
        let region = planner.regions.at(at);
        planner.is_conflict(&situation, &guidance, region)
    };
    // From rest at 0.5 m/s² and up to 1 m/s: 2.05 m in 3 s (v² / 2a + v (3 − v / a), and half a tick's gain).
    // Together 0.25 + 0.3 + 0.3 m: one that stands 2.85 m ahead is met, one at 2.95 m is not.
    assert!(conflict(2.5 + 10.0 + 2.85, 10.5, 0.0, 0.0, 10.0) && !conflict(2.5 + 10.0 + 2.95, 10.5, 0.0, 0.0, 10.0));
    // One that has crossed before the robot comes is none, and neither is one outside the rectangle (1.5 m to the side, radius 0.3 m).
    assert!(!conflict(15.5, 11.9, 0.0, -4.0, 10.0));
    assert!(conflict(14.3, 12.2, 0.0, -0.8, 10.0) && !conflict(14.3, 12.4, 0.0, -0.8, 10.0));
    // The rectangle of region 1 ends at 10.5 m, beyond the node at 10 m; what lies in the next one is not looked at.
    assert!(conflict(2.5 + 10.7, 10.5, 0.0, 0.0, 8.5) && !conflict(2.5 + 10.9, 10.5, 0.0, 0.0, 8.5));
}

#[test]
fn it_goes_round_what_stands_on_the_path_and_follows_it_again() {
    let mut course = Course::open(Pose::new(8.0, 20.5, 0.0), Vec2::new(28.0, 20.5));
    course.unexpected = vec![Cell { col: 15, row: 20 }];
    let mut planner = Planner::new(&printed());
    let drive = course.drive(600, |situation, guidance| planner.decide(situation, guidance));
    assert!(drive.arrived && drive.clearance_m > 0.0, "{} {}", drive.arrived, drive.clearance_m);
    let mut states: Vec<&str> = drive.decisions.iter().map(|decision| decision.state.name).collect();
    states.dedup();
    assert_eq!(states.first(), Some(&"follow"));
    assert!(states.contains(&"avoid") && states.last() == Some(&"follow"), "{states:?}");
    // The dynamic window simulates; following simulates nothing.
    for decision in &drive.decisions {
        assert_eq!(decision.rollouts > 0, decision.state != FOLLOW);
    }
}

#[test]
fn without_trigger_the_window_drives_all_the_time() {
    let course = Course::open(Pose::new(8.0, 20.5, 0.0), Vec2::new(18.0, 20.5));
    let mut planner = Planner::new(&Params { trigger: Trigger::Always, ..Params::default() });
    let drive = course.drive(400, |situation, guidance| planner.decide(situation, guidance));
    assert!(drive.arrived && drive.decisions.iter().all(|decision| decision.state == AVOID));
}

#[test]
fn a_robot_that_the_window_holds_on_the_spot_has_failed_after_a_while() {
    let wall = |params: &Params| {
        let mut course = Course::open(Pose::new(8.0, 20.5, 0.0), Vec2::new(24.0, 20.5));
        course.robot.reverse_speed_max_mps = 0.3;
        course.unexpected = (0..40).map(|row| Cell { col: 14, row }).collect();
        let mut planner = Planner::new(params);
        let drive = course.drive(600, |situation, guidance| planner.decide(situation, guidance));
        assert!(!drive.arrived && drive.clearance_m > 0.0, "{} {}", drive.arrived, drive.clearance_m);
        drive.decisions.iter().any(|decision| decision.state == RETREAT)
    };
    assert!(wall(&Params::default()) && !wall(&printed()));
}
