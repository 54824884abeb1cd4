use super::*;
use crate::geometry::{Path, Pose, Twist, Vec2, direction};
use crate::map::OccupancyGrid;
use crate::observation::Belief;
use crate::plan::local::dwa;
use crate::plan::local::tests::{Course, Drive, drives_what_its_formula_says};
use crate::plan::local::window::{Aim, HeadingAt, Prediction};
use crate::robot::Robot;

/// The paper's form.
fn printed() -> Params {
    Params {
        normalise: Normalise::Sum,
        horizon_s: Some(Positive::new(3.0)),
        room_m: NonNegative::new(0.0),
        prediction: Prediction::Euler,
        heading_at: HeadingAt::Horizon,
        d_cap_m: Positive::new(2.0),
        heading_weight: NonNegative::new(0.05),
        distance_weight: NonNegative::new(0.2),
        movers_weight: NonNegative::new(0.2),
        velocity_weight: NonNegative::new(0.1),
        path_weight: NonNegative::new(0.1),
        brake_lead_s: NonNegative::new(0.0),
        ..Params::default()
    }
}

fn v(x: f64, y: f64) -> Vec2 {
    Vec2::new(x, y)
}

fn drive(course: &Course, params: &Params, ticks: u32) -> Drive {
    let mut planner = Planner::new(params);
    course.drive(ticks, |situation, guidance| planner.decide(situation, guidance))
}

/// The states of a drive, each as often as it was entered.
fn entered(drive: &Drive) -> Vec<&'static str> {
    let mut names: Vec<_> = drive.decisions.iter().map(|decision| decision.state.name).collect();
    names.dedup();
    names
}

/// A planner that is asked by hand: the robot at (10, 10) with a path along x.
struct Asked {
    planner: Planner,
    robot: Robot,
    belief: Belief,
    path: Path,
}

impl Asked {
    fn new(params: Params) -> Self {
        let belief = Belief::from(&OccupancyGrid::empty(30, 20, 1.0));
        let path = Path::polyline(&[v(10.0, 10.0), v(25.0, 10.0)]);
        Self { planner: Planner::new(&params), robot: Robot::default(), belief, path }
    }

    /// State and cap with a robot of this speed and these movers: number, position, velocity; 0.3 m in radius.
    fn state(&mut self, speed_mps: f64, movers: &[(u32, Vec2, Vec2)]) -> (&'static str, f64) {
        let movers: Vec<_> =
            movers.iter().map(|&(id, at, velocity)| SensedObstacle::disc(id, at, velocity, 0.3)).collect();
        let situation = Situation {
            twist: Twist { v: speed_mps, omega: 0.0 },
            obstacles: &movers,
            ..Situation::new(&self.robot, &self.belief, Pose::new(10.0, 10.0, 0.0), self.path.end())
        };
        let (state, cap_mps) = self.planner.state(&situation, &Guidance::to_end(&self.path, 0.0));
        (state.name, cap_mps)
    }

    /// The state of a fresh planner.
    fn fresh(&mut self, speed_mps: f64, movers: &[(u32, Vec2, Vec2)]) -> (&'static str, f64) {
        self.planner.reset();
        self.state(speed_mps, movers)
    }
}

const UP: Vec2 = Vec2::new(0.0, 1.0);

#[test]
fn a_mover_that_crosses_makes_it_brake_by_the_four_conditions() {
    // The robot is 0.25 m in radius, it brakes at 0.5 m/s²: at rest d1 is 2 m, at 1 m/s it is 1 / (2 · 0.5) + 1 = 2 m.
    let mut asked = Asked::new(Params { brake_lead_s: NonNegative::new(0.0), ..Params::default() });
    let mut state = |speed_mps: f64, at: Vec2, velocity: Vec2| asked.fresh(speed_mps, &[(0, at, velocity)]).0;
    assert_eq!(state(0.5, v(12.0, 10.0), UP), "brake");
    // (1) In the way: half the corridor is 0.25 + 0.2 m, the mover 0.3 m. Behind the robot is not ahead.
    assert_eq!(state(0.5, v(12.0, 10.74), UP), "brake");
    assert_eq!(state(0.5, v(12.0, 10.76), UP), "track");
    assert_eq!(state(0.5, v(9.5, 10.0), UP), "track");
    // (2) Between the surfaces 2 m.
    assert_eq!(state(0.5, v(12.54, 10.0), UP), "brake");
    assert_eq!(state(0.5, v(12.56, 10.0), UP), "track");
    // (3) Faster than 0.1 m/s.
    assert_eq!(state(0.5, v(12.0, 10.0), 0.11 * UP), "brake");
    assert_eq!(state(0.5, v(12.0, 10.0), 0.09 * UP), "track");
    // (4) From 45° to 135°, to either side.
    for (degrees, expected) in [(44.9, "track"), (45.1, "brake"), (134.9, "brake"), (135.1, "track"), (180.0, "track")]
    {
        for side in [1.0, -1.0] {
            assert_eq!(state(0.5, v(12.0, 10.0), 0.5 * direction(side * f64::to_radians(degrees))), expected);
        }
    }
    let mut printed = Asked::new(Params { brake_angle_max_deg: NonNegative::new(180.0), ..printed() });
    assert_eq!(printed.fresh(0.5, &[(0, v(12.0, 10.0), v(-0.5, 0.0))]), ("brake", 0.0));
}

#[test]
fn the_braking_distance_and_the_lead_make_it_brake_earlier() {
    let mut asked = Asked::new(Params { brake_lead_s: NonNegative::new(0.0), ..Params::default() });
    asked.robot.deceleration_max_mps2 = 0.2;
    // 1 / (2 · 0.2) + 1 = 3.5 m between the surfaces.
    assert_eq!(asked.fresh(1.0, &[(0, v(14.04, 10.0), UP)]).0, "brake");
    assert_eq!(asked.fresh(1.0, &[(0, v(14.06, 10.0), UP)]).0, "track");
    // It comes from below at 1 m/s: 1.7 m below the path it touches the corridor, 0.75 m from it, after 0.95 s.
    let mut leading = Asked::new(Params::default());
    assert_eq!(leading.fresh(0.5, &[(0, v(11.0, 8.3), UP)]).0, "brake");
    assert_eq!(leading.fresh(0.5, &[(0, v(11.0, 8.2), UP)]).0, "track");
    assert_eq!(asked.fresh(0.5, &[(0, v(11.0, 8.3), UP)]).0, "track");
}

#[test]
fn a_mover_ahead_that_goes_its_way_is_followed_by_the_four_conditions() {
    let mut asked = Asked::new(Params::default());
    let mut state = |at: Vec2, speed_mps: f64, degrees: f64| {
        asked.fresh(0.5, &[(0, at, speed_mps * direction(f64::to_radians(degrees)))])
    };
    let is = |(name, cap_mps): (&str, f64), expected: &str, cap: f64| {
        assert_eq!(name, expected);
        assert!((cap_mps - cap).abs() < 1e-12 || cap_mps == cap, "{cap_mps}");
    };
    is(state(v(13.0, 10.0), 0.7, 0.0), "follow", 0.7);
    is(state(v(13.0, 10.0), 1.4, 24.9), "follow", 1.4);
    // In the way, nearer than 4 m, faster than 2/3 m/s, under 25°.
    is(state(v(13.0, 10.76), 0.7, 0.0), "track", f64::INFINITY);
    is(state(v(9.0, 10.0), 0.7, 0.0), "track", f64::INFINITY);
    is(state(v(14.54, 10.0), 0.7, 0.0), "follow", 0.7);
    is(state(v(14.56, 10.0), 0.7, 0.0), "track", f64::INFINITY);
    is(state(v(13.0, 10.0), 0.66, 0.0), "track", f64::INFINITY);
    is(state(v(13.0, 10.0), 0.7, 25.1), "track", f64::INFINITY);
    // The nearest of two; braking goes before following.
    let two = [(0, v(13.0, 10.0), v(0.9, 0.0)), (1, v(12.0, 10.0), v(0.7, 0.0))];
    assert_eq!(asked.fresh(0.5, &two), ("follow", 0.7));
    assert_eq!(asked.fresh(0.5, &[two[1], (2, v(12.4, 10.0), UP)]), ("brake", 0.0));
    let mut off = Asked::new(Params { states: false, ..Params::default() });
    assert_eq!(off.fresh(0.5, &two), ("track", f64::INFINITY));
}

#[test]
fn it_brakes_until_the_mover_has_left_the_way_it_had_and_at_most_ten_seconds() {
    let mut asked = Asked::new(Params { brake_lead_s: NonNegative::new(0.0), ..Params::default() });
    let crossing = (7, v(12.0, 10.0), 0.5 * UP);
    assert_eq!(asked.state(0.5, &[crossing]).0, "brake");
    // Now it goes along, or farther than d1, but in the way as it was when the robot began to brake.
    assert_eq!(asked.state(0.2, &[(7, v(12.0, 10.0), v(0.5, 0.0))]).0, "brake");
    assert_eq!(asked.state(0.0, &[(7, v(12.7, 10.0), v(0.5, 0.0))]).0, "brake");
    assert_eq!(asked.state(0.0, &[(7, v(12.76, 10.0), v(0.5, 0.0))]).0, "track");
    // Out of sight.
    assert_eq!(asked.state(0.5, &[crossing]).0, "brake");
    assert_eq!(asked.state(0.5, &[(8, v(18.0, 10.0), UP)]).0, "track");
    // One that stays: 10 s are 100 ticks.
    let ticks = (0..200).take_while(|_| asked.state(0.0, &[crossing]).0 == "brake").count();
    assert_eq!(ticks, 100);
    assert_eq!(asked.planner.progress.given_up, Some(7));
    assert_eq!(asked.state(0.0, &[crossing]).0, "track");
    // Another one makes it brake; the first does again once it has been out of the way.
    assert_eq!(asked.state(0.0, &[crossing, (8, v(12.0, 10.2), UP)]).0, "brake");
    assert_eq!(asked.state(0.0, &[(7, v(12.0, 12.0), UP)]).0, "track");
    assert_eq!(asked.state(0.0, &[crossing]).0, "brake");
}

#[test]
fn on_a_way_without_length_the_direction_is_that_to_the_goal_and_then_that_of_the_robot() {
    let (robot, belief) = (Robot::default(), Belief::from(&OccupancyGrid::empty(20, 20, 1.0)));
    let path = Path::polyline(&[v(5.0, 5.0), v(9.0, 5.0)]);
    let ahead = |x: f64, y: f64, progress_m: f64| {
        let situation = Situation::new(&robot, &belief, Pose::new(x, y, 1.0), path.end());
        Way::new(&situation, &Guidance::to_end(&path, progress_m), 0.2).ahead
    };
    let close = |a: Vec2, b: Vec2| assert!((a - b).norm() < 1e-12, "{a} {b}");
    close(ahead(6.0, 7.0, 1.0), v(1.0, 0.0));
    close(ahead(9.0, 6.0, 4.0), v(0.0, -1.0));
    close(ahead(9.0, 5.0, 4.0), direction(1.0));
}

#[test]
fn each_state_is_entered_and_left_on_the_way() {
    for params in [Params::default(), printed()] {
        // One crosses in front of the robot, slowly, so that it is in the way for some seconds.
        let mut crossing = Course::open(Pose::new(5.0, 20.0, 0.0), v(25.0, 20.0));
        crossing.movers = vec![SensedObstacle::disc(0, v(10.0, 17.5), v(0.0, 0.45), 0.3)];
        let drive_1 = drive(&crossing, &params, 900);
        assert!(drive_1.arrived && drive_1.clearance_m > 0.0, "{params:?} {}", drive_1.clearance_m);
        assert_eq!(entered(&drive_1), ["track", "brake", "track"], "{params:?}");
        // It brakes at 0.5 m/s², 0.05 m/s a tick, until it stands or the mover has gone.
        let speeds = drive_1.decisions.iter().map(|decision| (decision.state, decision.command.v));
        let braking: Vec<f64> = speeds.filter(|&(state, _)| state == BRAKE).map(|(_, v)| v).collect();
        assert!(braking.len() > 5, "{params:?} {braking:?}");
        let slows_down = |pair: &[f64]| (pair[1] - math::max(pair[0] - 0.05, 0.0)).abs() < 1e-6;
        assert!(braking.windows(2).all(slows_down), "{params:?} {braking:?}");

        // One goes ahead at 0.7 m/s, and aside later: the robot keeps behind it.
        let mut ahead = Course::open(Pose::new(5.0, 20.0, 0.0), v(25.0, 20.0));
        ahead.movers = vec![SensedObstacle::disc(0, v(7.0, 20.0), v(0.7, 0.07), 0.3)];
        let drive_2 = drive(&ahead, &params, 900);
        assert!(drive_2.arrived && drive_2.clearance_m > 0.2, "{params:?} {}", drive_2.clearance_m);
        let states = entered(&drive_2);
        assert!(states.contains(&"follow") && states.last() == Some(&"track"), "{states:?}");
        let fastest = drive_2.decisions.iter().filter(|decision| decision.state == FOLLOW);
        let fastest = fastest.map(|decision| decision.command.v).fold(0.0, math::max);
        assert!((0.69..=0.7036).contains(&fastest), "{fastest}");
    }
    // Walls on three sides, and the window looks farther than they are.
    let mut pocket = Course::open(Pose::new(10.5, 20.5, 0.0), v(25.5, 20.5));
    for (col, row) in [(11, 19), (11, 20), (11, 21), (10, 21), (10, 19), (9, 21), (9, 19)] {
        pocket.grid.set_occupied(crate::map::Cell { col, row });
    }
    pocket.robot.deceleration_max_mps2 = 0.1;
    let mut planner = Planner::new(&printed());
    let mut started = false;
    let drive = pocket.drive(60, |situation, guidance| {
        // Its drive begins too fast to stop.
        let twist = if started { situation.twist } else { Twist { v: 0.8, omega: 0.0 } };
        started = true;
        planner.decide(&Situation { twist, ..*situation }, guidance)
    });
    let states = entered(&drive);
    assert!(states.contains(&"recover") && states.contains(&"track"), "{states:?}");
}

#[test]
fn without_states_it_drives_as_dwa_and_without_movers_as_well() {
    let mut course = Course::open(Pose::new(5.0, 20.0, 0.3), v(18.0, 22.0));
    for movers in [vec![], vec![SensedObstacle::disc(0, v(14.0, 19.0), v(-0.1, 0.4), 0.4)]] {
        let params = Params { states: movers.is_empty(), ..Params::default() };
        course.movers = movers;
        let mut plain = dwa::Planner::new(&dwa::Params::default());
        let expected = course.drive(400, |situation, guidance| plain.decide(situation, guidance));
        let found = drive(&course, &params, 400);
        assert!(found.arrived && found.poses == expected.poses);
    }
}

/// Written out once more: the best of the admissible rollouts by eq. 18.
fn best_by_the_formula(params: &Params, situation: &Situation<'_>, path: &Path) -> Option<Twist> {
    let mut window = DynamicWindow::new(params.window());
    let rollouts = window.roll(situation, &Aim::ON);
    let all: Vec<usize> = rollouts.admissible().collect();
    let (goal, from) = (path.end(), path.start());
    let along = (goal - from).normalize();
    let terms: Vec<[f64; 5]> = all
        .iter()
        .map(|&i| {
            let end = rollouts.end(i);
            let to_goal = goal - end.position;
            let angle = direction(end.theta).dot(&to_goal) / to_goal.norm();
            let s = math::clamp((end.position - from).dot(&along), 0.0, (goal - from).norm());
            let offset = (from + along * s - end.position).norm();
            [
                math::PI - math::acos(angle),
                math::min(rollouts.static_clearance(i).path_min_m, 2.0),
                math::min(rollouts.mover_clearance(i).path_min_m, 2.0),
                rollouts.twist(i).v,
                1.0 / (1.0 + offset),
            ]
        })
        .collect();
    let sums: Vec<f64> = (0..5).map(|k| terms.iter().map(|term| term[k]).sum()).collect();
    let weights = [0.05, 0.2, 0.2, 0.1, 0.1];
    let norm = |term: &[f64; 5], k: usize| if sums[k] > 0.0 { term[k] / sums[k] } else { 0.0 };
    let score = |term: &[f64; 5]| (0..5).map(|k| weights[k] * norm(term, k)).sum::<f64>();
    let best = (0..all.len()).max_by(|&a, &b| score(&terms[a]).total_cmp(&score(&terms[b])));
    best.map(|at| rollouts.twist(all[at]))
}

#[test]
fn it_drives_what_the_formula_says() {
    drives_what_its_formula_says(6, |_, situation, guidance| {
        let params = Params { states: false, ..printed() };
        let decision = Planner::new(&params).decide(situation, guidance).expect("an answer");
        (decision, best_by_the_formula(&params, situation, guidance.path))
    });
}
