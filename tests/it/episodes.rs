//! Outcomes of episodes, with planners written outside the crate.

use simrun::episode::{Arrive, DT_S, Outcome, Runner, Setting, TerminationSpec};
use simrun::geometry::{Pose, Twist, Vec2};
use simrun::map::OccupancyGrid;
use simrun::plan::contract::Situation;
use simrun::plan::contract::{Decision, Failure, Guidance, LocalPlanner};
use simrun::plan::global::GlobalChoice;
use simrun::plan::local::LocalChoice;
use simrun::plan::stack::{ComputeSpec, PlanningSpec, Replan, Stack, SubGoals};
use simrun::robot::Robot;
use simrun::settings::quantity::NonNegative;
use simrun::world::{Conditions, Mover, ObstacleKind, Scene, Shape, StaticMap, UnknownStatic};
use std::sync::Arc;

/// Does what a closure says.
struct Scripted<F>(F);

impl<F: FnMut(&Situation<'_>, &Guidance<'_>) -> Twist + Send> LocalPlanner for Scripted<F> {
    fn decide(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Result<Decision, Failure> {
        Ok(Decision::track((self.0)(situation, guidance)))
    }
}

fn hall(lines: &[&str]) -> Arc<StaticMap> {
    Arc::new(StaticMap::new(OccupancyGrid::from_ascii(lines, 1.0)))
}

fn scripted(local: impl FnMut(&Situation<'_>, &Guidance<'_>) -> Twist + Send + 'static) -> Stack {
    Stack::new(Some(GlobalChoice::by_name("a_star").unwrap().build()), Vec::new(), Box::new(Scripted(local)))
}

fn run(scene: &Scene, stack: &mut Stack, termination: &TerminationSpec) -> (Outcome, Runner) {
    let mut runner = Runner::default();
    let outcome = runner.run(
        Setting { scene, robot: &Robot::default(), conditions: &Conditions::default(), termination, way_m: None },
        stack,
    );
    (outcome, runner)
}

const OPEN: [&str; 5] = ["..........", "..........", "..........", "..........", ".........."];

fn open_scene() -> Scene {
    Scene::new(&hall(&OPEN), Pose::new(1.5, 2.5, 0.0), Vec2::new(8.5, 2.5))
}

const STRAIGHT: Twist = Twist { v: 1.0, omega: 0.0 };

#[test]
fn a_straight_drive_takes_the_time_of_the_closed_form() {
    let scene = Scene::new(&hall(&OPEN), Pose::new(1.5, 2.5, 0.0), Vec2::new(8.45, 2.5));
    let (outcome, runner) = run(&scene, &mut scripted(|_, _| STRAIGHT), &TerminationSpec::default());
    assert_eq!(outcome, Outcome::Success);
    // Tick k ≤ 20 drives 0.05 k · 0.1 m, so 1.05 m after 20 ticks, then 0.1 m a tick. The goal is 6.95 m away and
    // counts from 0.25 m: (6.7 − 1.05) / 0.1 = 56.5, so 57 more ticks.
    let last = runner.record.trace.ticks.last().unwrap();
    assert_eq!(last.tick, 77);
    assert!((last.pose.position.x - (1.5 + 1.05 + 5.7)).abs() < 1e-9, "{:?}", last.pose);
    assert_eq!(runner.record.trace.ticks.len(), 78, "one row per tick and the initial state");
}

#[test]
fn a_wall_is_a_collision_with_the_known_map_while_moving() {
    let walled = hall(&["......#...", "......#...", "......#...", "......#...", ".........."]);
    let scene = Scene::new(&walled, Pose::new(1.5, 2.5, 0.0), Vec2::new(8.5, 2.5));
    let (outcome, runner) = run(&scene, &mut scripted(|_, _| STRAIGHT), &TerminationSpec::default());
    assert_eq!(outcome, Outcome::Collision { with: ObstacleKind::KnownStatic, at_rest: false });
    // The disc of 0.25 m touches the wall at x = 6 with its centre at 5.75.
    let x = runner.record.trace.ticks.last().unwrap().pose.position.x;
    assert!((x - 5.75).abs() < 1e-3, "{x}");
}

#[test]
fn the_edge_of_the_map_is_a_boundary() {
    let scene = Scene::new(&hall(&OPEN), Pose::new(1.5, 2.5, std::f64::consts::PI), Vec2::new(8.5, 2.5));
    let (outcome, _) = run(&scene, &mut scripted(|_, _| STRAIGHT), &TerminationSpec::default());
    assert_eq!(outcome, Outcome::Collision { with: ObstacleKind::Boundary, at_rest: false });
}

#[test]
fn a_planner_that_stands_is_stuck_after_half_a_minute() {
    let (outcome, runner) = run(&open_scene(), &mut scripted(|_, _| Twist::ZERO), &TerminationSpec::default());
    assert_eq!(outcome, Outcome::Stuck);
    assert_eq!(f64::from(runner.record.trace.ticks.last().unwrap().tick) * DT_S, 30.0);
}

#[test]
fn a_planner_that_circles_times_out() {
    let termination = TerminationSpec {
        timeout_factor: simrun::settings::quantity::Positive::new(2.0),
        ..TerminationSpec::default()
    };
    let (outcome, runner) = run(&open_scene(), &mut scripted(|_, _| Twist { v: 0.8, omega: 1.0 }), &termination);
    assert_eq!(outcome, Outcome::Timeout);
    // 2 × (7 m at 1 m/s and π at 1 rad/s) = 20.283 s.
    assert_eq!(runner.record.trace.ticks.last().unwrap().tick, 203);
}

#[test]
fn the_time_out_goes_by_the_way_that_is_given() {
    let scene = open_scene();
    let ticks = |way_m: f64| {
        let (conditions, termination) = (Conditions::default(), TerminationSpec::default());
        let robot = Robot::default();
        let setting = Setting {
            scene: &scene,
            robot: &robot,
            conditions: &conditions,
            termination: &termination,
            way_m: Some(way_m),
        };
        let mut runner = Runner::default();
        let outcome = runner.run(setting, &mut scripted(|_, _| Twist { v: 0.8, omega: 1.0 }));
        assert_eq!(outcome, Outcome::Timeout);
        runner.record.trace.ticks.last().unwrap().tick
    };
    // 10 × (way + π) s in tenths of a second.
    assert_eq!((ticks(7.0), ticks(62.0)), (1015, 6515));
}

#[test]
fn a_robot_that_spins_on_one_spot_is_stuck_after_a_turn_and_half_a_minute() {
    let spin = |omega: f64, termination: &TerminationSpec| {
        let (outcome, runner) = run(&open_scene(), &mut scripted(move |_, _| Twist { v: 0.0, omega }), termination);
        assert_eq!(outcome, Outcome::Stuck);
        runner.record.trace.ticks.last().unwrap().tick
    };
    // 0.9 rad/s are reached with the fifth tick; from then on a turn takes less than 6.3 s at 1 rad/s.
    let free = spin(1.0, &TerminationSpec::default());
    assert!((360..=365).contains(&free), "{free}");
    assert_eq!(spin(0.8, &TerminationSpec::default()), 300, "it could turn faster");
    assert_eq!(spin(1.0, &TerminationSpec { stuck_while_turning: true, ..TerminationSpec::default() }), 300);
}

#[test]
fn who_stands_before_a_mover_waits_and_who_has_turned_away_from_its_path_does_not() {
    let stand = |x: f64, y: f64| {
        let mut scene = open_scene();
        scene.movers.push(Mover::new(Vec2::new(x, y), Vec2::zeros(), 0.3));
        let mut stack = scripted(|_, _| Twist::ZERO).with_replan(Replan::by_name("never").unwrap());
        run(&scene, &mut stack, &TerminationSpec::default()).0
    };
    // The path goes along y = 2.5 from x = 1.5; the robot needs 0.25 m on either side.
    assert_eq!((stand(3.0, 2.5), stand(3.0, 3.0)), (Outcome::Timeout, Outcome::Timeout));
    assert_eq!((stand(3.0, 3.1), stand(4.5, 2.5)), (Outcome::Stuck, Outcome::Stuck));
}

#[test]
fn a_robot_that_has_to_stand_is_stopped_at_its_goal() {
    let termination = TerminationSpec { arrive: Arrive::Stand, ..TerminationSpec::default() };
    let mut scene = Scene::new(&hall(&OPEN), Pose::new(1.5, 2.5, 0.0), Vec2::new(8.5, 2.5));
    scene.goal_heading_rad = Some(1.5);
    // Full speed ahead would pass the goal; half a metre a second stops within the tolerance.
    let (outcome, runner) = run(&scene, &mut scripted(|_, _| Twist { v: 0.5, omega: 0.0 }), &termination);
    assert_eq!(outcome, Outcome::Success);
    let last = runner.record.trace.ticks.last().unwrap();
    assert!(last.twist.v.abs() <= 0.05 && (last.pose.theta - 1.5).abs() <= 0.1, "{last:?}");
    assert!(last.state.name == "arrive" && (last.pose.position - scene.goal).norm() < 0.25, "{last:?}");
    let (outcome, _) = run(&scene, &mut scripted(|_, _| STRAIGHT), &termination);
    assert_eq!(outcome, Outcome::Collision { with: ObstacleKind::Boundary, at_rest: false });
}

#[test]
fn a_planner_that_panics_is_an_outcome_with_its_words() {
    let mut stack = scripted(|situation, _| {
        assert!(situation.tick < 5, "lost at tick {}", situation.tick);
        STRAIGHT
    });
    let (outcome, runner) = run(&open_scene(), &mut stack, &TerminationSpec::default());
    let words = "local planner: lost at tick 5 (tests/it/episodes.rs:";
    assert!(matches!(&outcome, Outcome::PlannerError { message } if message.starts_with(words)), "{outcome:?}");
    assert_eq!(runner.record.trace.ticks.last().unwrap().tick, 5, "what happened before is kept");
}

#[test]
fn a_command_that_is_not_a_number_is_a_planner_error() {
    let mut stack = scripted(|_, _| Twist { v: f64::NAN, omega: 0.0 });
    let (outcome, _) = run(&open_scene(), &mut stack, &TerminationSpec::default());
    assert!(matches!(&outcome, Outcome::PlannerError { message } if message.contains("not finite")), "{outcome:?}");
}

#[test]
fn a_goal_that_cannot_be_reached_is_no_path() {
    let closed = hall(&["....#.....", "....#.....", "....#.....", "....#.....", "....#....."]);
    let scene = Scene::new(&closed, Pose::new(1.5, 2.5, 0.0), Vec2::new(8.5, 2.5));
    let (outcome, _) = run(&scene, &mut scripted(|_, _| STRAIGHT), &TerminationSpec::default());
    assert_eq!(outcome, Outcome::NoPath { message: "no path exists".to_owned() });
}

/// A corridor that forks around a block; a pallet that is not on the map closes the upper way.
fn forked_scene() -> Scene {
    let map = hall(&["............", "...######...", "...######...", "...######...", "............", "............"]);
    let mut scene = Scene::new(&map, Pose::new(1.5, 5.5, 0.0), Vec2::new(10.5, 5.5));
    let half_m = Vec2::new(0.5, 0.45);
    scene.unknown_static.push(UnknownStatic::new(Pose::new(7.5, 5.5, 0.0), Shape::Rectangle { half_m }));
    scene
}

fn tracking(replan: Replan) -> Stack {
    let (global, local) = (GlobalChoice::by_name("a_star").unwrap(), LocalChoice::by_name("pure_pursuit").unwrap());
    let planning: PlanningSpec =
        PlanningSpec { sub_goals: SubGoals::by_name("key_nodes").unwrap(), ..Default::default() };
    Stack::new(Some(global.build()), Vec::new(), local.build()).with_planning(&planning).with_replan(replan)
}

#[test]
fn without_replanning_the_unknown_obstacle_is_hit_and_with_it_the_robot_goes_round() {
    let (outcome, runner) =
        run(&forked_scene(), &mut tracking(Replan::by_name("never").unwrap()), &TerminationSpec::default());
    assert_eq!(outcome, Outcome::Collision { with: ObstacleKind::UnknownStatic, at_rest: false });
    assert_eq!(runner.record.trace.replans, 0);

    let (outcome, runner) =
        run(&forked_scene(), &mut tracking(Replan::by_name("when_blocked").unwrap()), &TerminationSpec::default());
    assert_eq!(outcome, Outcome::Success);
    let trace = &runner.record.trace;
    assert_eq!((trace.replans, trace.paths.len()), (1, 2));
    // The second plan came into force when the pallet, whose near face is at x = 7, was 5 m away.
    let seen_at = trace.ticks[trace.paths[1].tick as usize].pose.position.x;
    assert!((1.9..=2.1).contains(&seen_at), "{seen_at}");
}

#[test]
fn a_fixed_period_plans_again_and_again() {
    let every: Replan = Replan::every(simrun::plan::stack::replan::every::Params {
        period_s: simrun::settings::quantity::Positive::new(2.0),
    });
    let (outcome, runner) = run(&open_scene(), &mut tracking(every), &TerminationSpec::default());
    assert_eq!(outcome, Outcome::Success);
    let ticks: Vec<u32> = runner.record.trace.paths.iter().map(|planned| planned.tick).collect();
    assert!(ticks.iter().enumerate().all(|(index, tick)| *tick == 20 * index as u32), "{ticks:?}");
}

#[test]
fn a_sub_goal_is_never_out_of_sight_unless_it_is_near() {
    let map = hall(&["............", "............", "......#.....", "......#.....", "......#.....", "......#....."]);
    let scene = Scene::new(&map, Pose::new(1.5, 1.5, 0.0), Vec2::new(10.5, 1.5));
    let mut stack = Stack::new(
        Some(GlobalChoice::by_name("a_star").unwrap().build()),
        Vec::new(),
        LocalChoice::by_name("pure_pursuit").unwrap().build(),
    );
    let (outcome, runner) = run(&scene, &mut stack, &TerminationSpec::default());
    assert_eq!(outcome, Outcome::Success);
    for tick in &runner.record.trace.ticks {
        let (a, b) = (tick.pose.position, tick.sub_goal);
        let is_near = (b - a).norm() < 1.5 + 0.3;
        // The wall is x 6 to 7, y 0 to 4: a segment that crosses the plane x = 6.5 below y = 4 goes through it.
        let crosses = (a.x < 6.5) != (b.x < 6.5) && a.y + (b.y - a.y) * (6.5 - a.x) / (b.x - a.x) < 4.0;
        assert!(is_near || !crosses, "at {a:?} the sub-goal {b:?} is behind the wall");
    }
}

/// The planning settings with a price on computing, in simulated seconds.
fn charged(per_expansion_s: f64, per_rollout_point_s: f64) -> PlanningSpec {
    let (expansion, point) = (NonNegative::new(per_expansion_s), NonNegative::new(per_rollout_point_s));
    let compute = ComputeSpec { per_expansion_s: expansion, per_rollout_point_s: point };
    PlanningSpec { compute, ..PlanningSpec::default() }
}

#[test]
fn a_path_that_takes_time_to_plan_delays_the_drive_by_that_time() {
    let scene = Scene::new(&hall(&OPEN), Pose::new(1.5, 2.5, 0.0), Vec2::new(8.45, 2.5));
    let (_, free) = run(&scene, &mut scripted(|_, _| STRAIGHT), &TerminationSpec::default());
    let expanded = free.record.trace.expanded;
    assert_eq!(expanded, 7, "a straight lane: every cell but the goal's");
    let mut stack = scripted(|_, _| STRAIGHT).with_planning(&charged(0.15, 0.0));
    let (outcome, late) = run(&scene, &mut stack, &TerminationSpec::default());
    assert_eq!(outcome, Outcome::Success);
    // 7 × 0.15 s = 1.05 s: in force at tick 11.
    assert_eq!((late.record.trace.paths[0].tick, late.record.trace.expanded), (11, expanded));
    let (free, late) = (&free.record.trace.ticks, &late.record.trace.ticks);
    assert_eq!(late.len(), free.len() + 11);
    assert!(late[..=11].iter().all(|tick| tick.pose == scene.start && tick.command == Twist::ZERO));
    assert!(free.iter().zip(&late[11..]).all(|(free, late)| free.pose == late.pose && free.twist == late.twist));
}

#[test]
fn a_command_that_takes_time_to_compute_comes_late_and_the_last_one_stays_in_force() {
    struct Slow;
    impl LocalPlanner for Slow {
        fn decide(&mut self, situation: &Situation<'_>, _: &Guidance<'_>) -> Result<Decision, Failure> {
            let command = Twist { v: 0.01 * f64::from(situation.tick + 1), omega: 0.0 };
            Ok(Decision { rollouts: 5, rollout_points: 250, ..Decision::track(command) })
        }
    }
    let mut stack = Stack::new(None, Vec::new(), Box::new(Slow)).with_planning(&charged(0.0, 1e-3));
    let (_, runner) = run(&open_scene(), &mut stack, &TerminationSpec::default());
    // 250 points of a millisecond: asked at ticks 0, 3, 6, …, in force three ticks later, for three ticks.
    for tick in &runner.record.trace.ticks[1..40] {
        let asked = ((tick.tick - 1) / 3 * 3).checked_sub(3);
        let expected = asked.map_or(0.0, |asked| 0.01 * f64::from(asked + 1));
        assert_eq!(tick.command.v, expected, "tick {}", tick.tick);
    }
    let decided = u64::from(runner.record.trace.ticks.last().unwrap().tick).div_ceil(3);
    assert_eq!(runner.record.trace.rollouts, 5 * decided);
}

#[test]
fn what_a_stack_did_before_does_not_matter() {
    let mut used = tracking(Replan::by_name("when_blocked").unwrap());
    run(&open_scene(), &mut used, &TerminationSpec::default());
    let (_, second) = run(&forked_scene(), &mut used, &TerminationSpec::default());
    let (_, fresh) =
        run(&forked_scene(), &mut tracking(Replan::by_name("when_blocked").unwrap()), &TerminationSpec::default());
    assert_eq!(simrun::trace::digest(&second.record.trace), simrun::trace::digest(&fresh.record.trace));
}
