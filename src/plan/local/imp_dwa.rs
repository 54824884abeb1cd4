//! `imp_dwa`: the dynamic window approach with speed that counts more in open space, and a pull towards the target.
//!
//! Source: Gao, Zhang, Liu, Ou, Cheng, Zhu, the ImpA*-ImpDWA paper, AIMS Press, 2025, eq. 26 and 27 (`gao2025`):
//!
//! ```text
//! G = α norm(head) + β norm(dist) + λ ln(e + dist / d2) norm(vel) + γ norm(dist_g)         largest wins
//! dist_g = 1 / |p_end − target|
//! ```
//!
//! head, dist and vel are those of [`dwa`](super::dwa), window, rollouts and ties those of [`window`](super::window).
//!
//! That is `normalise: sum`, which the paper's scenarios state. By default (`fixed`) what is its own goes on top of the objective
//! that it shares with `dwa` (`window/objective.rs`): the factor ln(e + dist / d2) on the velocity term, and the
//! pull γ · d_best / |p_end − target|, where d_best is the nearest that any rollout could come within the
//! horizon; within 0.5 m of the target all rollouts are equal.
//!
//! Readings of the paper (ids of `systems.md`):
//! - G-A11: the formula has α, β, λ, γ, the list of values α 0.05, β 0.2, γ 0.2, η 0.1. Matched by name, η is λ; by
//!   order (`weights_by: order`) λ is 0.2 and γ 0.1.
//! - G-A12: the text credits the method with predicting the obstacles' motion, though no formula does; movers keep their
//!   velocity over the horizon here (`predict_dynamic`, on by default as in `dwa`). In the paper's scenarios, where `dwa` has it
//!   off, most of what sets the two apart is this.
//! - G-A13: d2 is only defined for the global planner, as the distance from start to goal, which makes the factor
//!   practically constant (ln(e + 2/41) = 1.018). By default it is that of the key nodes before and after the robot;
//!   `d2_mode: global` takes both ends of the path in force. At least 1 m either way.
//! - G-A14: the factor multiplies the normalised velocity; its dist is in metres, cut at `d_cap_m`.
//! - G-A15: the goal of dist_g is the current sub-goal, and |p_end − target| is at least 0.1 m.
//! - G-A16: σ is the normalisation of each term over the admissible rollouts.
//!
//! Departures: those of [`dwa`](super::dwa), prediction apart. "Window adaptation" and "fewer invalid samples" of the
//! text have no formula and are not here.
//!
//! Parameters: [`Params`].

use super::LocalKind;
use super::window::params::window_params;
use super::window::pull::{Pull, nearness};
use super::window::weighing::Weighing;
use super::window::{DistanceMode, DynamicWindow, Normalise};
use crate::math;
use crate::plan::contract::{Decision, Entry, Failure, Fit, Guidance, LocalPlanner, Situation, State};
use crate::settings::quantity::NonNegative;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Least d2, m.
const D2_MIN_M: f64 = 1.0;

/// Which distance d2 is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum D2Mode {
    /// From the key node before to the sub-goal.
    #[default]
    Segment,
    /// From the beginning to the end of the path in force, as printed.
    Global,
}

/// How the values of the paper belong to its symbols.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WeightsBy {
    /// velocity 0.1, goal 0.2.
    #[default]
    Name,
    /// velocity 0.2, goal 0.1.
    Order,
}

window_params! {
    /// Parameters of `imp_dwa`.
    pub struct Params {
        /// Weight α of the heading term; higher turns to the target sooner and goes round less. Default 0.05.
        pub heading_weight: NonNegative = NonNegative::new(0.05),
        /// Weight β of the distance term; higher keeps farther from obstacles and shuns lanes. Default 0.2.
        pub distance_weight: NonNegative = NonNegative::new(0.2),
        /// Weight λ of the velocity term; as `weights_by` has it where absent.
        pub velocity_weight: Option<NonNegative> = None,
        /// Weight γ of the pull towards the target; as `weights_by` has it where absent.
        pub goal_weight: Option<NonNegative> = None,
        /// Which reading of the paper's list of values λ and γ are taken from. Default `name`.
        pub weights_by: WeightsBy = WeightsBy::Name,
        /// Which distance d2 is; a shorter one lets free space raise the velocity term more. Default `segment`.
        pub d2_mode: D2Mode = D2Mode::Segment,
    }
}

impl Params {
    /// λ and γ.
    fn velocity_and_goal_weight(&self) -> (f64, f64) {
        let (velocity, goal) = match self.weights_by {
            WeightsBy::Name => (0.1, 0.2),
            WeightsBy::Order => (0.2, 0.1),
        };
        (self.velocity_weight.map_or(velocity, NonNegative::get), self.goal_weight.map_or(goal, NonNegative::get))
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Dynamic window that predicts movers, prizes speed more in open space and is pulled towards its target.",
    source: "Gao, Zhang, Liu, Ou, Cheng, Zhu, ImpA*-ImpDWA, AIMS Press, 2025, eq. 26 and 27",
    reacts_to_movers: true,
    states: &[State::TRACK, State::RECOVER],
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
    weighing: Weighing,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone(), weighing: Weighing::new(params.window()) }
    }
}

impl LocalPlanner for Planner {
    fn decide(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Result<Decision, Failure> {
        let params = &self.params;
        let (velocity_weight, goal_weight) = params.velocity_and_goal_weight();
        let d2_m = d2_m(params.d2_mode, guidance);
        if params.normalise == Normalise::Fixed {
            let target = guidance.sub_goal;
            let (weights, d_cap_m) = (params.weights(velocity_weight), params.d_cap_m.get());
            let duration_s = self.weighing.roll(situation, guidance, f64::INFINITY).duration_s();
            let pull = Pull::new(situation, duration_s, target, goal_weight);
            let best = self.weighing.best(situation, |objective, rollouts, i| {
                let clearance_m = math::min(rollouts.clearance_m(i, DistanceMode::PathMin), d_cap_m);
                objective.score(rollouts, i, &weights, d_cap_m, openness(clearance_m, d2_m)) + pull.of(rollouts, i)
            });
            return Ok(self.weighing.decide(best, situation, target));
        }
        let target = params.target.point(situation, guidance);
        let best = self.weighing.best_by_sums(situation, f64::INFINITY, |rollouts, score| {
            let terms = params.terms(rollouts, situation, target);
            score.add(params.heading_weight.get(), |i| terms.heading(i));
            score.add(params.distance_weight.get(), |i| terms.distance_m(i));
            score.add_weighted(|i| velocity_weight * openness(terms.distance_m(i), d2_m), |i| terms.velocity_mps(i));
            score.add(goal_weight, |i| nearness((rollouts.end(i).position - target).norm()));
        });
        Ok(self.weighing.decide(best, situation, target))
    }

    fn reset(&mut self) {
        self.weighing.reset();
    }

    fn entry(&self) -> &'static Entry {
        &ENTRY
    }
}

/// d2, m.
fn d2_m(mode: D2Mode, guidance: &Guidance<'_>) -> f64 {
    let (from, to) = match mode {
        D2Mode::Segment => (guidance.previous_node, guidance.sub_goal),
        D2Mode::Global => (guidance.path.start(), guidance.path.end()),
    };
    math::max((to - from).norm(), D2_MIN_M)
}

/// ln(e + dist / d2): 1 at an obstacle, more away from it.
fn openness(distance_m: f64, d2_m: f64) -> f64 {
    math::ln(core::f64::consts::E + distance_m / d2_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Path, Pose, Twist, Vec2, direction};
    use crate::map::Cell;
    use crate::observation::SensedObstacle;
    use crate::plan::local::dwa;
    use crate::plan::local::tests::{Course, Drive, drives_what_its_formula_says};
    use crate::plan::local::window::{Aim, HeadingAt, Prediction};
    use crate::rng::{EpisodeSeed, Purpose};
    use crate::settings::quantity::Positive;

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
    fn the_factor_is_that_worked_by_hand() {
        assert!((openness(0.0, 5.0) - 1.0).abs() < 1e-12); // ln e
        assert!((openness(2.0, 41.0) - 1.0178).abs() < 1e-4); // ln(2.718282 + 0.048780) = ln 2.767062
        assert!((openness(2.0, 1.0) - 1.5515).abs() < 1e-4); // ln 4.718282
    }

    #[test]
    fn d2_is_that_of_the_segment_or_of_the_path_and_at_least_one_metre() {
        let point = |x, y| Vec2::new(x, y);
        let path = Path::polyline(&[point(0.0, 0.0), point(3.0, 4.0), point(3.0, 10.0), point(12.0, 5.0)]);
        let guidance = |previous_node, sub_goal| Guidance {
            previous_node,
            sub_goal,
            is_last: false,
            ..Guidance::to_end(&path, 0.0)
        };
        let second = guidance(point(3.0, 4.0), point(3.0, 10.0));
        assert_eq!((d2_m(D2Mode::Segment, &second), d2_m(D2Mode::Global, &second)), (6.0, 13.0)); // 5-12-13
        let short = guidance(point(3.0, 4.0), point(3.0, 4.5));
        assert_eq!(d2_m(D2Mode::Segment, &short), 1.0);
    }

    #[test]
    fn the_papers_values_are_matched_by_name_or_by_order_unless_given() {
        let params = |yaml: &str| serde_yaml::from_str::<Params>(yaml);
        assert_eq!(params("{}").unwrap().velocity_and_goal_weight(), (0.1, 0.2));
        assert_eq!(params("weights_by: order").unwrap().velocity_and_goal_weight(), (0.2, 0.1));
        assert_eq!(params("weights_by: order\ngoal_weight: 0.7").unwrap().velocity_and_goal_weight(), (0.2, 0.7));
        assert!(params("{}").unwrap().window().predict_dynamic);
        assert!(params("weights_by: chance").is_err() && params("velocity_weight: -1").is_err());
    }

    #[test]
    fn every_option_of_dwa_is_an_option_here_with_the_same_default_but_the_papers_weights() {
        let of = |value: serde_json::Value| value.as_object().expect("a struct").clone();
        let ours = of(serde_json::to_value(Params::default()).unwrap());
        for (key, theirs) in of(serde_json::to_value(dwa::Params::default()).unwrap()) {
            let differs = ["velocity_weight", "heading_weight", "distance_weight"].contains(&key.as_str());
            assert_eq!(ours.get(&key) == Some(&theirs), !differs, "{key}");
        }
    }

    /// Written out once more: the best of the admissible rollouts by eq. 26.
    fn best_by_the_formula(params: &Params, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Option<Twist> {
        let mut window = DynamicWindow::new(params.window());
        let rollouts = window.roll(situation, &Aim::ON);
        let d2 = math::max((guidance.sub_goal - guidance.previous_node).norm(), 1.0);
        let all: Vec<usize> = rollouts.admissible().collect();
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
        let sum = |k: usize| terms.iter().map(|term| term[k]).sum::<f64>();
        let sums = [sum(0), sum(1), sum(2), sum(3)];
        let score = |term: &[f64; 4]| {
            let norm = |k: usize| if sums[k] > 0.0 { term[k] / sums[k] } else { 0.0 };
            let factor = math::ln(core::f64::consts::E + term[1] / d2);
            0.05 * norm(0) + 0.2 * norm(1) + 0.1 * factor * norm(2) + 0.2 * norm(3)
        };
        let best = (0..all.len()).max_by(|&a, &b| score(&terms[a]).total_cmp(&score(&terms[b])));
        best.map(|at| rollouts.twist(all[at]))
    }

    #[test]
    fn it_drives_what_the_formula_says() {
        drives_what_its_formula_says(3, |_, situation, guidance| {
            let params = printed();
            let decision = Planner::new(&params).decide(situation, guidance).expect("an answer");
            (decision, best_by_the_formula(&params, situation, guidance))
        });
    }

    #[test]
    fn it_arrives_in_open_space_and_round_a_block_without_touching_it() {
        let mut stream = EpisodeSeed { seed: 1, episode: 0 }.stream(Purpose::Planner, 1);
        for _ in 0..30 {
            let start = Pose::new(15.0, 20.0, stream.range(-math::PI, math::PI));
            let course = Course::open(start, Vec2::new(17.0 + stream.range(1.5, 8.0), 20.0));
            assert!(drive(&course, &Params::default(), 400).arrived, "from {start:?} to {:?}", course.path.end());
        }
        let mut course = Course::open(Pose::new(10.0, 20.3, 0.0), Vec2::new(22.0, 20.0));
        course.grid.set_occupied(Cell { col: 15, row: 19 });
        course.grid.set_occupied(Cell { col: 15, row: 20 });
        // As printed it goes round; on fixed scales it heeds the path, which leads through the block, and stands.
        let drive = drive(&course, &printed(), 500);
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
