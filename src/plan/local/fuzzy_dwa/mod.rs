//! `fuzzy_dwa`: the dynamic window approach with a pull towards its target, whose four weights a fuzzy controller sets anew every tick.
//!
//! Source: Zhu et al., "Path planning optimization of automated guided vehicles based on enhanced A* and dynamic window approach
//! fusion algorithms", 2025, eq. 17 and Table 1 (`zhu2025`):
//!
//! ```text
//! G = α norm(head) + β norm(dist) + γ norm(vel) + λ norm(Dgoal)         largest wins
//! (α, β, γ, λ) = fuzzy(D_obs, D_goal)                                   16 rules, Mamdani min and max, centroid
//! Dgoal = 1 / |p_end − target|
//! ```
//!
//! head, dist and vel are those of [`dwa`](super::dwa), window, rollouts and ties those of [`window`](super::window), the rules
//! those of [`controller`]. The heading counts for much in open space and for nothing beside an obstacle, the distance from
//! obstacles the other way round.
//!
//! That is `normalise: sum`, which the paper's scenarios state. By default (`fixed`) the objective is the one shared with `dwa`
//! (`window/objective.rs`) with the pull of [`imp_dwa`](super::imp_dwa) on top, and the controller scales their weights: an
//! output of 1/2 leaves a weight as it is, 1 doubles it.
//!
//! Readings of the paper (ids of `systems.md`):
//! - U-A8: eq. 13 and 14 print v_max and ω_max where accelerations belong. As printed they are those of a robot whose `limits` say
//!   v_max per second for acceleration and deceleration and ω_max per second for the yaw acceleration; a scenario can say so.
//! - U-A9: the "distance correction" term has no formula: 1 / |p_end − target|, the distance at least 0.1 m.
//! - U-A10: the sets of the inputs are nowhere and those of the outputs in pictures alone. Triangles with peaks at 0, 1/3, 2/3 and 1 of
//!   0 to 3 m, 0 to 10 m and 0 to 1; `input_sets`, `output_sets`, `shape`, `obstacle_range_m` and `goal_range_m` change them.
//! - U-A12, U-A13: the incomplete rule 7 and the missing rule 16 as in [`controller::RULES`].
//! - D_obs is the distance from the robot's edge to the nearest obstacle, known or sensed, movers included; for a robot that is no disc
//!   from the discs that cover it.
//! - D_goal is the distance to the sub-goal; the text, "giving up tracking the global and target points", allows the goal as well
//!   (`d_goal_of`). The pull goes to the same point.
//! - U-A15: dist is at the end point in the paper, over the whole rollout by default (`dist_mode`).
//! - U-A21: movers keep their velocity over the horizon, by the assumption of the paper's conclusion (`predict_dynamic`).
//!
//! Departures: those of [`dwa`](super::dwa), prediction apart.
//!
//! Parameters: [`Params`].

pub mod controller;
pub mod inference;

use super::LocalKind;
use super::window::objective::Weights;
use super::window::params::window_params;
use super::window::pull::{Pull, nearness};
use super::window::weighing::Weighing;
use super::window::{DynamicWindow, Normalise, Target};
use crate::geometry::convex::{Disc, turned};
use crate::geometry::direction;
use crate::math;
use crate::plan::clearance::Obstacles;
use crate::plan::contract::{Decision, Entry, Failure, Fit, Guidance, LocalPlanner, Notes, Situation, State};
use crate::settings::quantity::{NonNegative, Positive};
use controller::{Controller, OUTPUTS};
use inference::{Peaks, Shape};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Output of the controller at which a weight on fixed scales is the one that was given.
const NEUTRAL: f64 = 0.5;

/// Source of the four weights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Weighting {
    /// The fuzzy controller, every tick.
    #[default]
    Fuzzy,
    /// The given weights.
    Fixed,
}

window_params! {
    /// Parameters of `fuzzy_dwa`.
    pub struct Params {
        /// Where the weights come from. Default `fuzzy`.
        pub weights: Weighting = Weighting::Fuzzy,
        /// Weight α of the heading term with `weights: fixed`, and with `normalise: fixed` the one that the controller scales. Default 0.1.
        pub heading_weight: NonNegative = NonNegative::new(0.1),
        /// The same for β, the distance from obstacles. Default 0.8.
        pub distance_weight: NonNegative = NonNegative::new(0.8),
        /// The same for γ, the velocity. Default 0.3.
        pub velocity_weight: NonNegative = NonNegative::new(0.3),
        /// The same for λ, the pull towards the target. Default 0.2.
        pub goal_weight: NonNegative = NonNegative::new(0.2),
        /// Factor on the controller's α; higher turns to the target sooner. Default 1.
        pub heading_scale: NonNegative = NonNegative::new(1.0),
        /// Factor on the controller's β; higher keeps farther from obstacles. Default 1.
        pub distance_scale: NonNegative = NonNegative::new(1.0),
        /// Factor on the controller's γ; higher is faster. Default 1.
        pub velocity_scale: NonNegative = NonNegative::new(1.0),
        /// Factor on the controller's λ; higher is pulled harder. Default 1.
        pub goal_scale: NonNegative = NonNegative::new(1.0),
        /// The point whose distance is an input of the controller and to which the pull goes. Default `sub_goal`.
        pub d_goal_of: Target = Target::SubGoal,
        /// Distance to the nearest obstacle from which on it is "far" and nothing else, m. Default 3.
        pub obstacle_range_m: Positive = Positive::new(3.0),
        /// Distance to the target from which on it is "far" and nothing else, m. Default 10.
        pub goal_range_m: Positive = Positive::new(10.0),
        /// Peaks of the sets "very near", "near", "moderate" and "far" of both inputs, in shares of their ranges, ascending. Default 0, 1/3, 2/3, 1.
        pub input_sets: Peaks = Peaks::EVEN,
        /// Peaks of the sets "very small", "small", "medium" and "large" of all four weights, ascending. Default 0, 1/3, 2/3, 1.
        pub output_sets: Peaks = Peaks::EVEN,
        /// Shape of all sets. Default `triangle`.
        pub shape: Shape = Shape::Triangle,
    }
}

impl Params {
    /// The controller that these parameters describe.
    pub fn controller(&self) -> Controller {
        let (obstacle_m, goal_m) = (self.obstacle_range_m.get(), self.goal_range_m.get());
        Controller::new(obstacle_m, goal_m, self.input_sets, self.output_sets, self.shape)
    }

    /// α, β, γ and λ for what the controller says.
    fn weights_of(&self, outputs: impl FnOnce() -> [f64; OUTPUTS]) -> [f64; OUTPUTS] {
        let given = [self.heading_weight, self.distance_weight, self.velocity_weight, self.goal_weight];
        let given = given.map(NonNegative::get);
        if self.weights == Weighting::Fixed {
            return given;
        }
        let scales = [self.heading_scale, self.distance_scale, self.velocity_scale, self.goal_scale];
        let outputs = outputs();
        core::array::from_fn(|k| {
            let base = if self.normalise == Normalise::Fixed { given[k] / NEUTRAL } else { 1.0 };
            base * scales[k].get() * outputs[k]
        })
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Dynamic window with a pull towards its target; a fuzzy controller sets the weights from the distances to obstacles and target.",
    source: "Zhu, Tu, Shen, Yin, Zhang, Zhao, Chen, Path planning optimization of automated guided vehicles based on enhanced A* and dynamic window approach fusion algorithms, 2025, eq. 17 and Table 1",
    reacts_to_movers: true,
    states: &[State::TRACK, State::RECOVER],
    notes: &["heading_weight", "distance_weight", "velocity_weight", "goal_weight", "obstacle_m", "target_m"],
    ..Entry::PLAIN
};

impl LocalKind for Params {
    fn build(&self) -> Box<dyn LocalPlanner> {
        Box::new(Planner::new(self))
    }

    fn check(&self, fit: &Fit<'_>) -> Result<(), String> {
        DynamicWindow::check(&self.window(), fit)
    }
}

/// The planner.
#[derive(Clone, Debug)]
pub struct Planner {
    params: Params,
    controller: Controller,
    weighing: Weighing,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone(), controller: params.controller(), weighing: Weighing::new(params.window()) }
    }
}

impl LocalPlanner for Planner {
    fn decide(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Result<Decision, Failure> {
        let params = &self.params;
        let pulled_to = params.d_goal_of.point(situation, guidance);
        let obstacle_m = obstacle_m(situation, params.obstacle_range_m.get());
        let target_m = (pulled_to - situation.pose.position).norm();
        let weights = params.weights_of(|| self.controller.weights(obstacle_m, target_m));
        let [heading, distance, velocity, goal] = weights;
        let (best, towards) = if params.normalise == Normalise::Fixed {
            let weights = Weights { heading, distance, movers: distance, ..params.weights(velocity) };
            let duration_s = self.weighing.roll(situation, guidance, f64::INFINITY).duration_s();
            let (pull, d_cap_m) = (Pull::new(situation, duration_s, pulled_to, goal), params.d_cap_m.get());
            let best = self.weighing.best(situation, |objective, rollouts, i| {
                objective.score(rollouts, i, &weights, d_cap_m, 1.0) + pull.of(rollouts, i)
            });
            (best, guidance.sub_goal)
        } else {
            let target = params.target.point(situation, guidance);
            let best = self.weighing.best_by_sums(situation, f64::INFINITY, |rollouts, score| {
                let terms = params.terms(rollouts, situation, target);
                score.add(heading, |i| terms.heading(i));
                score.add(distance, |i| terms.distance_m(i));
                score.add(velocity, |i| terms.velocity_mps(i));
                score.add(goal, |i| nearness((rollouts.end(i).position - pulled_to).norm()));
            });
            (best, target)
        };
        let notes = Notes::new(&[heading, distance, velocity, goal, obstacle_m, target_m]);
        Ok(Decision { notes, ..self.weighing.decide(best, situation, towards) })
    }

    fn reset(&mut self) {
        self.weighing.reset();
    }

    fn entry(&self) -> &'static Entry {
        &ENTRY
    }
}

/// D_obs: distance from the robot's edge to the nearest believed static, edge of the map or sensed mover, m, from 0 to `limit_m`.
fn obstacle_m(situation: &Situation<'_>, limit_m: f64) -> f64 {
    let (robot, pose) = (situation.robot, situation.pose);
    let obstacles = Obstacles::new(situation.belief.grid(), situation.belief.field());
    let from_statics = |centre, radius_m: f64| obstacles.clearance(centre, limit_m + radius_m) - radius_m;
    let statics_m = match &robot.footprint {
        None => from_statics(pose.position, robot.radius_m),
        Some(polygon) => {
            let axis = direction(pose.theta);
            let of = |disc: &Disc| from_statics(pose.position + turned(disc.centre, axis), disc.radius_m);
            polygon.cover().iter().map(of).fold(limit_m, math::min)
        }
    };
    let body = robot.body(pose);
    let movers = situation.obstacles.iter().map(|mover| mover.outline.gap_m(mover.position, &body));
    math::max(movers.fold(statics_m, math::min), 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::convex::Polygon;
    use crate::geometry::{Path, Pose, Twist, Vec2};
    use crate::map::{Cell, OccupancyGrid};
    use crate::observation::{Belief, SensedObstacle};
    use crate::plan::local::tests::{Course, Drive, drives_what_its_formula_says};
    use crate::plan::local::window::{Aim, HeadingAt, Prediction};
    use crate::plan::local::{dwa, imp_dwa};
    use crate::rng::{EpisodeSeed, Purpose};
    use crate::robot::Robot;

    /// The paper's form.
    fn printed() -> Params {
        Params {
            normalise: Normalise::Sum,
            horizon_s: Some(Positive::new(3.0)),
            room_m: NonNegative::new(0.0),
            prediction: Prediction::Euler,
            heading_at: HeadingAt::Horizon,
            d_cap_m: Positive::new(0.5),
            ..Params::default()
        }
    }

    fn drive(course: &Course, params: &Params, ticks: u32) -> Drive {
        let mut planner = Planner::new(params);
        course.drive(ticks, |situation, guidance| planner.decide(situation, guidance))
    }

    #[test]
    fn every_option_of_dwa_is_an_option_here_with_the_same_default() {
        let of = |value: serde_json::Value| value.as_object().expect("a struct").clone();
        let ours = of(serde_json::to_value(Params::default()).unwrap());
        for (key, theirs) in of(serde_json::to_value(dwa::Params::default()).unwrap()) {
            assert_eq!(ours.get(&key), Some(&theirs), "{key}");
        }
    }

    #[test]
    fn a_neutral_output_leaves_the_weights_and_the_papers_form_takes_the_outputs_alone() {
        let weights = |yaml: &str, outputs| serde_yaml::from_str::<Params>(yaml).unwrap().weights_of(|| outputs);
        assert_eq!(weights("{}", [0.5; 4]), [0.1, 0.8, 0.3, 0.2]);
        assert_eq!(weights("heading_scale: 2", [0.5, 0.25, 0.0, 1.0]), [0.2, 0.4, 0.0, 0.4]);
        assert_eq!(weights("normalise: sum", [0.5, 0.25, 0.0, 1.0]), [0.5, 0.25, 0.0, 1.0]);
        assert_eq!(weights("{normalise: sum, goal_scale: 0.5}", [0.5, 0.25, 0.0, 1.0]), [0.5, 0.25, 0.0, 0.5]);
        assert_eq!(weights("{weights: fixed, velocity_weight: 0.7, normalise: sum}", [0.9; 4]), [0.1, 0.8, 0.7, 0.2]);
        assert!(serde_yaml::from_str::<Params>("output_sets: [0, 0.5, 0.4, 1]").is_err());
    }

    #[test]
    fn the_nearest_obstacle_is_that_from_the_edge_of_the_robot_movers_included() {
        let mut grid = OccupancyGrid::empty(20, 20, 1.0);
        grid.set_occupied(Cell { col: 12, row: 10 });
        let belief = Belief::from(&grid);
        let mut robot = Robot::default();
        let at = |robot: &Robot, x: f64, movers: &[SensedObstacle]| {
            let pose = Pose::new(x, 10.5, 0.0);
            let situation = Situation { obstacles: movers, ..Situation::new(robot, &belief, pose, Vec2::zeros()) };
            obstacle_m(&situation, 3.0)
        };
        // The square begins at x = 12; a disc of 0.25 m.
        assert!((at(&robot, 10.0, &[]) - 1.75).abs() < 1e-12);
        assert_eq!((at(&robot, 6.0, &[]), at(&robot, 11.9, &[])), (3.0, 0.0));
        let mover = SensedObstacle::disc(0, Vec2::new(10.0, 11.5), Vec2::zeros(), 0.3);
        assert!((at(&robot, 10.0, std::slice::from_ref(&mover)) - 0.45).abs() < 1e-12);
        // A rectangle 1 m long: 0.5 m of it ahead, and the discs that cover it stick out by up to half of its inscribed radius.
        let corners = [(0.5, 0.2), (-0.5, 0.2), (-0.5, -0.2), (0.5, -0.2)].map(|(x, y)| Vec2::new(x, y));
        robot.footprint = Some(Polygon::new(&corners).unwrap());
        robot.radius_m = robot.footprint.as_ref().unwrap().circumradius_m();
        let found = at(&robot, 10.0, &[]);
        assert!(found <= 1.5 + 1e-12 && found > 1.39, "{found}");
    }

    #[test]
    fn with_fixed_weights_it_drives_as_imp_dwa_without_its_factor() {
        // λ ln(e + dist / d2) is λ where d2 is vast.
        let course = Course::open(Pose::new(10.0, 20.0, 1.0), Vec2::new(18.0, 24.0));
        let params = Params { weights: Weighting::Fixed, velocity_weight: NonNegative::new(0.0), ..Params::default() };
        let theirs = imp_dwa::Params {
            heading_weight: params.heading_weight,
            distance_weight: params.distance_weight,
            velocity_weight: Some(params.velocity_weight),
            ..imp_dwa::Params::default()
        };
        let mut imp = imp_dwa::Planner::new(&theirs);
        let theirs = course.drive(300, |situation, guidance| imp.decide(situation, guidance));
        let ours = drive(&course, &params, 300);
        assert!(ours.arrived);
        assert_eq!(ours.poses, theirs.poses);
    }

    #[test]
    fn the_notes_are_the_weights_in_force_and_what_they_were_made_of() {
        let grid = OccupancyGrid::empty(40, 40, 1.0);
        let (belief, robot) = (Belief::from(&grid), Robot::default());
        let path = Path::polyline(&[Vec2::new(20.0, 20.0), Vec2::new(24.0, 20.0)]);
        let goal = Vec2::new(24.0, 26.0);
        let situation = Situation::new(&robot, &belief, Pose::new(20.0, 20.0, 0.0), goal);
        let guidance = Guidance::to_end(&path, 0.0);
        let notes = |params: &Params| {
            let decision = Planner::new(params).decide(&situation, &guidance).expect("an answer");
            decision.notes.values().to_vec()
        };
        let fuzzy = printed().controller();
        let expected = [&fuzzy.weights(3.0, 4.0)[..], &[3.0, 4.0]].concat();
        assert_eq!(notes(&printed()), expected);
        let goal_m = 52f64.sqrt();
        let expected = [&fuzzy.weights(3.0, goal_m)[..], &[3.0, goal_m]].concat();
        assert_eq!(notes(&Params { d_goal_of: Target::Goal, ..printed() }), expected);
    }

    /// Written out once more: the best of the admissible rollouts by eq. 17, with the weights of the controller.
    fn best_by_the_formula(params: &Params, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Option<Twist> {
        let mut window = DynamicWindow::new(params.window());
        let rollouts = window.roll(situation, &Aim::ON);
        let all: Vec<usize> = rollouts.admissible().collect();
        // Every square and mover.
        let grid = situation.belief.grid();
        let p = situation.pose.position;
        let squares = (0..grid.occupied().len()).map(|index| grid.cell(index)).filter(|&cell| !grid.is_free(cell));
        let to_squares = squares.map(|cell| math::max(grid.square(cell).signed_distance(p), 0.0));
        let to_movers = situation.obstacles.iter().map(|mover| (p - mover.position).norm() - mover.radius_m());
        let border = [p.x, p.y, grid.extent_m().x - p.x, grid.extent_m().y - p.y];
        let nearest_m = to_squares.chain(to_movers).chain(border).fold(f64::INFINITY, math::min);
        let obstacle_m = math::max(nearest_m - situation.robot.radius_m, 0.0);
        let weights = params.controller().weights(obstacle_m, (guidance.sub_goal - p).norm());
        let terms: Vec<[f64; 4]> = all
            .iter()
            .map(|&i| {
                let end = rollouts.end(i);
                let to_target = guidance.sub_goal - end.position;
                let angle = direction(end.theta).dot(&to_target) / to_target.norm();
                let dist = math::min(rollouts.clearance_m(i, params.dist_mode), 0.5);
                let near = 1.0 / math::max(to_target.norm(), 0.1);
                [math::PI - math::acos(angle), dist, rollouts.twist(i).v, near]
            })
            .collect();
        let sums: [f64; 4] = core::array::from_fn(|k| terms.iter().map(|term| term[k]).sum());
        let score = |term: &[f64; 4]| -> f64 {
            (0..4).map(|k| if sums[k] > 0.0 { weights[k] * term[k] / sums[k] } else { 0.0 }).sum()
        };
        let best = (0..all.len()).max_by(|&a, &b| score(&terms[a]).total_cmp(&score(&terms[b])));
        best.map(|at| rollouts.twist(all[at]))
    }

    #[test]
    fn it_drives_what_the_formula_says() {
        drives_what_its_formula_says(4, |_, situation, guidance| {
            let params = printed();
            let decision = Planner::new(&params).decide(situation, guidance).expect("an answer");
            (decision, best_by_the_formula(&params, situation, guidance))
        });
    }

    #[test]
    fn it_arrives_in_open_space_and_past_a_block_without_touching_it() {
        let mut stream = EpisodeSeed { seed: 1, episode: 0 }.stream(Purpose::Planner, 1);
        for _ in 0..30 {
            let start = Pose::new(15.0, 20.0, stream.range(-math::PI, math::PI));
            let course = Course::open(start, Vec2::new(17.0 + stream.range(1.5, 8.0), 20.0));
            assert!(drive(&course, &Params::default(), 400).arrived, "from {start:?} to {:?}", course.path.end());
        }
        let mut course = Course::open(Pose::new(10.0, 20.3, 0.0), Vec2::new(22.0, 20.0));
        course.grid.set_occupied(Cell { col: 15, row: 19 });
        course.grid.set_occupied(Cell { col: 15, row: 20 });
        course.path = Path::polyline(&[Vec2::new(10.0, 20.3), Vec2::new(15.5, 22.0), Vec2::new(22.0, 20.0)]);
        let drive = drive(&course, &Params::default(), 500);
        assert!(drive.arrived && drive.clearance_m > 0.0, "{} {}", drive.arrived, drive.clearance_m);
    }

    #[test]
    fn it_gives_way_to_a_crossing_mover_unless_prediction_is_off() {
        let mut course = Course::open(Pose::new(10.0, 20.0, 0.0), Vec2::new(20.0, 20.0));
        course.movers = vec![SensedObstacle::disc(0, Vec2::new(14.0, 25.2), Vec2::new(0.0, -1.0), 0.3)];
        let predicting = drive(&course, &Params::default(), 400);
        assert!(predicting.arrived && predicting.clearance_m > 0.0, "{}", predicting.clearance_m);
        let frozen = drive(&course, &Params { predict_dynamic: false, ..Params::default() }, 400);
        assert!(predicting.clearance_m > frozen.clearance_m, "{} {}", predicting.clearance_m, frozen.clearance_m);
    }
}
