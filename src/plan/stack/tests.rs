//! The stack tick by tick, with planners that do what a test says.

use super::*;
use crate::geometry::{Pose, Twist};
use crate::map::OccupancyGrid;
use crate::observation::Belief;
use crate::plan::contract::{Guidance, Notes, Randomness, SearchEffort, State};
use crate::plan::local::LocalChoice;
use crate::settings::quantity::{Count, NonNegative, Positive};
use std::sync::{Arc, Mutex};

/// A global planner that goes by the corner (goal.x, start.y).
struct ByCorner;

impl GlobalPlanner for ByCorner {
    fn plan(&mut self, task: &Task<'_>, plan: &mut Plan) -> Result<(), Failure> {
        plan.path = Path::polyline(&[task.start, Vec2::new(task.goal.x, task.start.y), task.goal]);
        plan.effort = SearchEffort { expanded: 5, generated: 7 };
        Ok(())
    }
}

/// A local planner that does what a closure says.
struct Scripted<F>(F);

impl<F: FnMut(&Situation<'_>) -> Decision + Send> LocalPlanner for Scripted<F> {
    fn decide(&mut self, situation: &Situation<'_>, _: &Guidance<'_>) -> Result<Decision, Failure> {
        Ok((self.0)(situation))
    }
}

fn stack(local: impl FnMut(&Situation<'_>) -> Decision + Send + 'static) -> Stack {
    Stack::new(Some(Box::new(ByCorner)), Vec::new(), Box::new(Scripted(local)))
}

const GOAL: Vec2 = Vec2::new(16.5, 12.5);

/// Begins an episode and stands at these places, one tick after the other; what was decided at each.
fn at_each(stack: &mut Stack, robot: &Robot, places: &[(f64, f64)]) -> Vec<Result<Decision, Failure>> {
    let belief = Belief::from(&OccupancyGrid::empty(20, 20, 1.0));
    let situation = |tick: usize, budget: Budget| {
        let (x, y) = places[tick];
        Situation { tick: tick as u32, budget, ..Situation::new(robot, &belief, Pose::new(x, y, 0.0), GOAL) }
    };
    let budget = stack.budget();
    stack.begin(&situation(0, budget)).expect("a path");
    (0..places.len()).map(|tick| stack.decide(&situation(tick, budget))).collect()
}

#[test]
fn progress_goes_back_on_request_and_the_planner_may_steer_for_a_point_of_its_own() {
    let mut stack = stack(|situation| Decision {
        request: match situation.tick {
            1 => Some(Request::GoBack { to_m: 2.0 }),
            2 => Some(Request::SubGoal(Vec2::new(9.0, 9.0))),
            _ => None,
        },
        ..Decision::STAND
    });
    let robot = Robot::default();
    at_each(&mut stack, &robot, &[(4.5, 2.5), (7.0, 2.5)]);
    assert_eq!((stack.drive.route.progress_m, stack.drive.route.next), (2.0, 1));
    at_each(&mut stack, &robot, &[(4.5, 2.5), (7.0, 2.5), (7.0, 2.5)]);
    assert_eq!(stack.sub_goal(), Vec2::new(9.0, 9.0));
}

#[test]
fn a_new_path_from_a_point_ahead_keeps_the_way_to_it() {
    let mut stack = stack(|situation| Decision {
        request: (situation.tick == 0).then_some(Request::NewPath { from_m: Some(6.0) }),
        ..Decision::STAND
    });
    at_each(&mut stack, &Robot::default(), &[(4.5, 2.5), (4.5, 2.5)]);
    // From the robot on straight to (10.5, 2.5), then by the corner again.
    let nodes: Vec<Vec2> = stack.path().vertices().collect();
    assert_eq!(nodes, [(4.5, 2.5), (10.5, 2.5), (16.5, 2.5), (16.5, 12.5)].map(|(x, y)| Vec2::new(x, y)));
    assert_eq!((stack.effort().replans, stack.effort().expanded, stack.path_revision()), (1, 10, 2));
}

#[test]
fn caps_lower_what_the_planners_see_and_never_raise_it() {
    let seen = |caps: Caps| {
        let robot = Robot { speed_max_mps: 1.0, reverse_speed_max_mps: 0.3, ..Robot::default() };
        let echo = |situation: &Situation<'_>| {
            let robot = situation.robot;
            Decision::track(Twist { v: robot.speed_max_mps, omega: robot.reverse_speed_max_mps })
        };
        let mut stack = stack(echo).with_caps(caps);
        let Twist { v, omega } = at_each(&mut stack, &robot, &[(4.5, 2.5)])[0].as_ref().expect("an answer").command;
        (v, omega)
    };
    let caps = |speed: f64, reverse: f64| Caps {
        speed_max_mps: Some(Positive::new(speed)),
        reverse_speed_max_mps: Some(NonNegative::new(reverse)),
    };
    let all = [Caps::default(), caps(0.4, 0.0), caps(7.0, 7.0)].map(seen);
    assert_eq!(all, [(1.0, 0.3), (0.4, 0.0), (1.0, 0.3)]);
}

#[test]
fn answers_that_no_planner_may_give_are_faults_of_the_local_planner() {
    const OWN: State = State { name: "dance", kind: StateKind::Tracking };
    let faults: [(Decision, &str); 5] = [
        (Decision::track(Twist { v: f64::NAN, omega: 0.0 }), "not finite"),
        (Decision { state: OWN, ..Decision::STAND }, "`dance`, which it does not declare"),
        (Decision { notes: Notes::new(&[1.0]), ..Decision::STAND }, "publishes [1.0] and declares []"),
        (Decision { request: Some(Request::GoBack { to_m: f64::INFINITY }), ..Decision::STAND }, "arc length"),
        (Decision { rollout_points: 9, ..Decision::STAND }, "more than its budget"),
    ];
    for (decision, words) in faults {
        let mut stack = stack(move |_| decision);
        stack.planning.budget.rollout_points = Some(Count::new(8));
        let answers = at_each(&mut stack, &Robot::default(), &[(4.5, 2.5)]);
        assert!(matches!(&answers[0], Err(Failure::Fault(what)) if what.contains(words)), "{answers:?}");
        assert_eq!(stack.acting(), Some(Part::Local));
    }
}

#[test]
fn each_layer_draws_from_a_stream_of_its_own() {
    let drawn = Arc::new(Mutex::new(Vec::new()));
    let draws = Arc::clone(&drawn);
    let mut stack = stack(move |situation| {
        draws.lock().unwrap().push(situation.random.stream().bits());
        Decision::STAND
    });
    at_each(&mut stack, &Robot::default(), &[(4.5, 2.5), (4.5, 2.5)]);
    at_each(&mut stack, &Robot::default(), &[(4.5, 2.5), (4.5, 2.5)]);
    let drawn = drawn.lock().unwrap();
    assert_eq!(drawn[..2], drawn[2..], "the same episode, the same numbers");
    assert_ne!(drawn[0], Randomness::default().stream().bits(), "those of the global planner");
}

#[test]
fn a_specification_builds_the_stack_that_it_describes() {
    let spec = StackSpec {
        name: "s".to_owned(),
        global: None,
        path: Vec::new(),
        local: LocalChoice::by_name("pure_pursuit").unwrap(),
        replan: Some(Replan::by_name("when_stuck").unwrap()),
        sub_goals: Some(SubGoals::by_name("key_nodes").unwrap()),
        movers: Some(Movers::by_name("block").unwrap()),
        caps: Caps { speed_max_mps: Some(Positive::new(0.5)), reverse_speed_max_mps: None },
    };
    let stack = spec.build(&PlanningSpec::default());
    assert_eq!((stack.planning.replan.name(), stack.planning.sub_goals.name()), ("when_stuck", "key_nodes"));
    assert_eq!((stack.planning.movers.name(), PlanningSpec::default().movers.name()), ("block", "ignore"));
    assert_eq!(
        (stack.caps, spec.global_name(), spec.default_name().as_str()),
        (spec.caps, "none", "none+pure_pursuit")
    );
}
