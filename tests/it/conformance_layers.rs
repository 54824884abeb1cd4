//! What every path stage, local planner, sub-goal rule, replanning rule and treatment of movers promises, asked of each of them
//! by its registry.

use simrun::episode::{Outcome, Runner, Setting, TerminationSpec};
use simrun::geometry::{Path, Pose, Twist, Vec2};
use simrun::map::{DistanceField, OccupancyGrid};
use simrun::observation::{Belief, SensedObstacle};
use simrun::plan::PlanningGrid;
use simrun::plan::contract::{Decision, Guidance, Plan, Situation, Task};
use simrun::plan::global::GlobalChoice;
use simrun::plan::local::LocalChoice;
use simrun::plan::path::PathChoice;
use simrun::plan::stack::{Movers, PlanningSpec, Replan, Stack, SubGoals, find_path};
use simrun::rng::{EpisodeSeed, Purpose, Stream};
use simrun::robot::Robot;
use simrun::world::{Conditions, Mover, Scene, Shape, StaticMap, UnknownStatic};
use std::sync::Arc;

fn stream(entity: u64) -> Stream {
    EpisodeSeed { seed: 2, episode: 0 }.stream(Purpose::Planner, entity)
}

/// A map of 12 m by 12 m of which a share is occupied.
fn random_map(stream: &mut Stream) -> OccupancyGrid {
    let mut map = OccupancyGrid::empty(24, 24, 0.5);
    let share = stream.range(0.0, 0.15);
    for index in 0..map.occupied().len() {
        if stream.uniform() < share {
            map.set_occupied(map.cell(index));
        }
    }
    map
}

fn random_point(stream: &mut Stream) -> Vec2 {
    Vec2::new(stream.range(0.5, 11.5), stream.range(0.5, 11.5))
}

/// A robot somewhere on a random map, with movers about and a path to follow.
struct Case {
    belief: Belief,
    movers: Vec<SensedObstacle>,
    pose: Pose,
    twist: Twist,
    path: Path,
}

impl Case {
    fn random(stream: &mut Stream) -> Self {
        let belief = Belief::from(&random_map(stream));
        let mover = |id: u32, stream: &mut Stream| {
            let velocity = 0.2 * (random_point(stream) - random_point(stream));
            SensedObstacle::disc(id, random_point(stream), velocity, 0.3)
        };
        let movers = (0..3).map(|id| mover(id, stream)).collect();
        let position = random_point(stream);
        let pose = Pose::new(position.x, position.y, stream.range(-3.0, 3.0));
        let twist = Twist { v: stream.range(0.0, 1.0), omega: stream.range(-1.0, 1.0) };
        let path = Path::polyline(&[position, random_point(stream), random_point(stream)]);
        Self { belief, movers, pose, twist, path }
    }

    fn decide(&self, planner: &mut dyn simrun::plan::contract::LocalPlanner, robot: &Robot) -> Decision {
        let goal = self.path.end();
        let situation = Situation {
            twist: self.twist,
            obstacles: &self.movers,
            ..Situation::new(robot, &self.belief, self.pose, goal)
        };
        let mut key_nodes = Vec::new();
        self.path.key_nodes(&mut key_nodes);
        let guidance = Guidance {
            sub_goal: key_nodes[1].position,
            is_last: false,
            key_nodes: &key_nodes,
            next_key_node: 1,
            ..Guidance::to_end(&self.path, 0.0)
        };
        planner.decide(&situation, &guidance).expect("an answer")
    }
}

#[test]
fn every_local_planner_asks_for_finite_twists_in_a_state_that_it_declares() {
    let robot = Robot { reverse_speed_max_mps: 0.3, ..Robot::default() };
    for &name in LocalChoice::NAMES {
        let mut stream = stream(1);
        let mut planner = LocalChoice::by_name(name).expect("defaults").build();
        let entry = planner.entry();
        assert!(!entry.states.is_empty() && entry.summary.ends_with('.') && !entry.source.is_empty(), "{name}");
        for _ in 0..300 {
            let decision = Case::random(&mut stream).decide(&mut *planner, &robot);
            let Twist { v, omega } = decision.command;
            assert!(v >= -robot.reverse_speed_max_mps - 1e-9 && v <= robot.speed_max_mps + 1e-9, "{name}: {v}");
            assert!(omega.abs() <= robot.yaw_rate_max_radps + 1e-9, "{name}: {omega}");
            assert!(entry.states.contains(&decision.state), "{name}: {:?}", decision.state);
            assert_eq!(decision.notes.values().len(), entry.notes.len(), "{name}");
        }
    }
}

#[test]
fn every_local_planner_answers_the_same_fresh_after_a_reset_and_with_another_stream_of_its_own() {
    let robot = Robot::default();
    for &name in LocalChoice::NAMES {
        let build = || LocalChoice::by_name(name).expect("defaults").build();
        let (mut stream, mut used) = (stream(2), build());
        for _ in 0..100 {
            let (a, b) = (Case::random(&mut stream), Case::random(&mut stream));
            used.reset();
            let first = a.decide(&mut *used, &robot);
            used.reset();
            let second = b.decide(&mut *used, &robot);
            assert_eq!((first, second), (a.decide(&mut *build(), &robot), b.decide(&mut *build(), &robot)), "{name}");
        }
    }
}

#[test]
fn every_path_stage_keeps_the_ends_and_answers_the_same_fresh_and_used() {
    let robot = Robot::default();
    for &name in PathChoice::NAMES {
        let entry = PathChoice::by_name(name).expect("defaults").entry();
        assert!(entry.summary.ends_with('.') && !entry.source.is_empty(), "{name}");
        let build = || PathChoice::by_name(name).expect("defaults").build();
        let (mut stream, mut used, mut found) = (stream(3), [build()], 0);
        let mut global = GlobalChoice::by_name("a_star").expect("defaults").build();
        for _ in 0..200 {
            let map = random_map(&mut stream);
            let grid = PlanningGrid::new(&map, &DistanceField::new(&map), 0.0);
            let belief = Belief::from(&map);
            let (start, goal) = (random_point(&mut stream), random_point(&mut stream));
            let situation = Situation::new(&robot, &belief, Pose { position: start, theta: 0.0 }, goal);
            let task = Task { situation: &situation, grid: &grid, start, goal };
            // The harness checks that the path starts, ends and stays where it may.
            let mut answer = |stages: &mut [Box<_>]| {
                let mut plan = Plan::default();
                global.reset();
                find_path(&mut *global, stages, &task, &mut plan).map(|()| plan.path)
            };
            let path = answer(&mut used);
            assert_eq!(path, answer(&mut [build()]), "{name}");
            if let Ok(path) = path {
                found += 1;
                assert_eq!((path.start(), path.end()), (start, goal), "{name}");
            }
        }
        assert!(found > 100, "{name}: {found}");
    }
}

/// A corridor that forks; a pallet that is not on the map closes the upper way, somebody walks across the lower one.
fn scene() -> Scene {
    let lines = ["............", "...######...", "...######...", "...######...", "............", "............"];
    let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(&lines, 1.0)));
    let mut scene = Scene::new(&map, Pose::new(1.5, 5.5, 0.0), Vec2::new(10.5, 5.5));
    let half_m = Vec2::new(0.5, 0.45);
    scene.unknown_static.push(UnknownStatic::new(Pose::new(7.5, 5.5, 0.0), Shape::Rectangle { half_m }));
    scene.movers.push(Mover::new(Vec2::new(6.0, 0.5), Vec2::new(0.0, 0.2), 0.3));
    scene
}

fn run(stack: &mut Stack) -> (Outcome, Runner) {
    let (scene, robot, conditions) = (scene(), Robot::default(), Conditions::default());
    let (termination, mut runner) = (TerminationSpec::default(), Runner::default());
    let setting =
        Setting { scene: &scene, robot: &robot, conditions: &conditions, termination: &termination, way_m: None };
    let outcome = runner.run(setting, stack);
    (outcome, runner)
}

/// Drives with these settings, twice with one stack and once with a fresh one.
fn check_rule(what: &str, planning: &PlanningSpec) {
    let build = || {
        let (global, local) = (GlobalChoice::by_name("a_star"), LocalChoice::by_name("dwa"));
        Stack::new(Some(global.expect("defaults").build()), Vec::new(), local.expect("defaults").build())
            .with_planning(planning)
    };
    let mut used = build();
    run(&mut used);
    let ((outcome, second), (_, fresh)) = (run(&mut used), run(&mut build()));
    assert!(!matches!(outcome, Outcome::PlannerError { .. } | Outcome::NoPath { .. }), "{what}: {outcome:?}");
    let trace = &second.record.trace;
    assert_eq!(simrun::trace::digest(trace), simrun::trace::digest(&fresh.record.trace), "{what}");
    for tick in &trace.ticks {
        let at = tick.sub_goal;
        assert!(at.x >= 0.0 && at.x <= 12.0 && at.y >= 0.0 && at.y <= 6.0, "{what}: {at:?}");
    }
    let ascend = trace.paths.windows(2).all(|pair| pair[0].tick < pair[1].tick);
    assert!(ascend && trace.paths[0].tick == 0, "{what}: a path comes into force once");
}

/// The rule of that name; one that needs a period gets a second.
fn rule<T: serde::de::DeserializeOwned>(name: &str) -> T {
    let plain = serde_yaml::from_str(name);
    plain.unwrap_or_else(|_| serde_yaml::from_str(&format!("{name}: {{period_s: 1}}")).expect("one parameter"))
}

#[test]
fn every_rule_drives_repeats_itself_and_keeps_its_sub_goal_on_the_map() {
    for &name in SubGoals::NAMES {
        check_rule(name, &PlanningSpec { sub_goals: rule(name), replan: rule("when_blocked"), ..Default::default() });
    }
    for &name in Replan::NAMES {
        check_rule(name, &PlanningSpec { replan: rule(name), ..Default::default() });
    }
    for &name in Movers::NAMES {
        check_rule(name, &PlanningSpec { movers: rule(name), replan: rule("when_threatened"), ..Default::default() });
    }
}

#[test]
fn a_mover_on_the_only_way_is_planned_round_where_movers_block() {
    let planned = |movers: &str| {
        let planning = PlanningSpec { movers: rule(movers), ..Default::default() };
        let global = GlobalChoice::by_name("a_star").expect("defaults").build();
        let local = LocalChoice::by_name("pure_pursuit").expect("defaults").build();
        let mut stack = Stack::new(Some(global), Vec::new(), local).with_planning(&planning);
        let lines = ["........", "........", "........", "........"];
        let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(&lines, 1.0)));
        let mut scene = Scene::new(&map, Pose::new(1.5, 1.5, 0.0), Vec2::new(6.5, 1.5));
        scene.movers.push(Mover::new(Vec2::new(4.0, 1.5), Vec2::new(0.0, 0.0), 0.3));
        let (robot, conditions, termination) = (Robot::default(), Conditions::default(), TerminationSpec::default());
        let mut runner = Runner::default();
        let setting =
            Setting { scene: &scene, robot: &robot, conditions: &conditions, termination: &termination, way_m: None };
        let outcome = runner.run(setting, &mut stack);
        (outcome, runner.record.trace.paths[0].path.length())
    };
    let (ignored, straight_m) = planned("ignore");
    assert!(
        matches!(ignored, Outcome::Collision { .. }) && (straight_m - 5.0).abs() < 1e-9,
        "{ignored:?} {straight_m}"
    );
    let (blocked, round_m) = planned("block");
    assert_eq!(blocked, Outcome::Success);
    // Centres nearer than 0.3 + 0.25 + 0.05 m to (4, 1.5) are blocked: the row above or below is the way, two diagonals long.
    assert!((round_m - (3.0 + 2.0 * std::f64::consts::SQRT_2)).abs() < 1e-9, "{round_m}");
}
