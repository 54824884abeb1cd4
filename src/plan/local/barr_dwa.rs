//! `barr_dwa`: the dynamic window approach with a term that prefers to pass behind the nearest mover.
//!
//! Source: Zhao, Xie, Xu, Zhu, Xu, dynamic path planning for inspection robots based on improved A* and DWA, 2025, eq. 10 to 17 (`zhao2025`):
//!
//! ```text
//! G = α norm(head) + β norm(dist) + γ norm(vel) + κ norm(barr)      largest wins      (barr_mode: additive, Table 4)
//! G = norm(barr) · (α norm(head) + β norm(dist) + γ norm(vel))                        (barr_mode: multiplicative, eq. 16)
//! barr(i) = ∠(v_c(i) + v_b, v_b)                                                      (barr: sum)
//! ```
//!
//! v_b is the velocity of the mover, v_c(i) that of the robot at the end of candidate i. The angle is the larger, the less the robot goes
//! where the mover goes: it turns towards where the mover comes from and passes behind it. head, dist and vel are those of
//! [`dwa`](super::dwa), window, rollouts and ties those of [`window`](super::window).
//!
//! That is `normalise: sum`, which the paper's scenarios state. By default (`fixed`) κ · barr(i) / barr_max goes on top of the objective that it
//! shares with `dwa` (`window/objective.rs`), where barr_max is the most that barr can be.
//!
//! Readings of the paper (ids of `systems.md`):
//! - Z-A7: eq. 16 multiplies by barr, Table 4 gives it a weight, and eq. 17 normalises it as the other terms: a sum with that weight is the
//!   default; as a constant factor the weight would decide nothing.
//! - Z-A8: barr has no formula. The text derives a new velocity v_c2 from the sum v_h1 of both velocities and then subtracts; with these signs a
//!   symmetric crossing changes nothing. The angle itself is the measure here; `barr: relative` takes v_c − v_b instead of the sum.
//! - Z-A9: `barr: target` takes the derived velocity: v_h2 is v_h1 turned by a right angle, away from v_b, v_c2 = v_h2 − v_b, and
//!   barr(i) = 1 + cos ∠(v_c(i), v_c2).
//! - Z-A17: the text does so "when the angle is acute", which is asked of the velocity that the robot has now (`barr_when: acute`).
//! - Several movers: the nearest one, by its surface; of equals the earlier one. A mover that stands, and none, leave barr constant.
//! - As printed the movers' motion enters through barr alone; `predict_dynamic` is off in the paper's scenarios and on by default.
//!
//! Departures: those of [`dwa`](super::dwa).
//!
//! Parameters: [`Params`].

use super::LocalKind;
use super::window::params::window_params;
use super::window::weighing::Weighing;
use super::window::{DynamicWindow, Normalise, Rollouts};
use crate::geometry::{Twist, Vec2, cross, direction};
use crate::math;
use crate::observation::SensedObstacle;
use crate::plan::contract::{Decision, Entry, Failure, Fit, Guidance, LocalPlanner, Situation, State};
use crate::settings::quantity::NonNegative;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How barr joins the other terms (Z-A7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BarrMode {
    /// A term with a weight of its own, as Table 4 has it.
    #[default]
    Additive,
    /// A factor on the sum of the others, as eq. 16 prints it; only with `normalise: sum`.
    Multiplicative,
}

/// What barr measures (Z-A8, Z-A9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Barr {
    /// The angle between the sum of both velocities and that of the mover.
    #[default]
    Sum,
    /// The angle between the robot's velocity relative to the mover and that of the mover.
    Relative,
    /// How well the robot's velocity agrees with the one that the text derives.
    Target,
}

/// When barr counts (Z-A17).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BarrWhen {
    /// While the angle between the sum of both velocities and that of the mover is acute, as printed: not while the mover comes
    /// towards a faster robot.
    #[default]
    Acute,
    /// Whenever a mover moves.
    Always,
}

window_params! {
    /// Parameters of `barr_dwa`.
    pub struct Params {
        /// Weight α of the heading term; higher turns to the path or target sooner and goes round less. Default 0.1.
        pub heading_weight: NonNegative = NonNegative::new(0.1),
        /// Weight β of the distance from obstacles; with `normalise: fixed` the share of its progress that contact takes off a rollout.
        /// Default 0.8.
        pub distance_weight: NonNegative = NonNegative::new(0.8),
        /// Weight γ of the velocity term; lower is timid. Default 0.3.
        pub velocity_weight: NonNegative = NonNegative::new(0.3),
        /// Weight κ of barr; higher turns farther out to pass behind a mover. Only with `barr_mode: additive`. Default 0.4.
        pub barr_weight: NonNegative = NonNegative::new(0.4),
        /// How barr joins the other terms. Default `additive`.
        pub barr_mode: BarrMode = BarrMode::Additive,
        /// What barr measures. Default `sum`.
        pub barr: Barr = Barr::Sum,
        /// When barr counts. Default `acute`.
        pub barr_when: BarrWhen = BarrWhen::Acute,
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Dynamic window with a term that prefers to pass behind the nearest mover.",
    source: "Zhao, Xie, Xu, Zhu, Xu, Dynamic path planning for inspection robots based on improved A* and DWA, 2025, eq. 16 and 17",
    reacts_to_movers: true,
    states: &[State::TRACK, State::RECOVER],
    ..Entry::PLAIN
};

impl LocalKind for Params {
    fn build(&self) -> Box<dyn LocalPlanner> {
        Box::new(Planner::new(self))
    }

    fn check(&self, fit: &Fit<'_>) -> Result<(), String> {
        if self.barr_mode == BarrMode::Multiplicative && self.normalise == Normalise::Fixed {
            return Err("`barr_mode: multiplicative` multiplies normalised terms: it needs `normalise: sum`".to_owned());
        }
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
        let passing = Passing::of(params, situation);
        if params.normalise == Normalise::Fixed {
            let (weights, d_cap_m) = (params.weights(params.velocity_weight.get()), params.d_cap_m.get());
            let barr_weight = params.barr_weight.get();
            self.weighing.roll(situation, guidance, f64::INFINITY);
            let best = self.weighing.best(situation, |objective, rollouts, i| {
                let barr = passing.as_ref().map_or(0.0, |passing| passing.share(rollouts, i));
                objective.score(rollouts, i, &weights, d_cap_m, 1.0) + barr_weight * barr
            });
            return Ok(self.weighing.decide(best, situation, guidance.sub_goal));
        }
        let target = params.target.point(situation, guidance);
        let best = self.weighing.best_by_sums(situation, f64::INFINITY, |rollouts, score| {
            let terms = params.terms(rollouts, situation, target);
            score.add(params.heading_weight.get(), |i| terms.heading(i));
            score.add(params.distance_weight.get(), |i| terms.distance_m(i));
            score.add(params.velocity_weight.get(), |i| terms.velocity_mps(i));
            let barr = |i| passing.as_ref().map_or(1.0, |passing| passing.barr(rollouts, i));
            match params.barr_mode {
                BarrMode::Additive => score.add(params.barr_weight.get(), barr),
                BarrMode::Multiplicative => score.multiply(barr),
            }
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

/// A slower mover stands, m/s.
const STANDING_MPS: f64 = 0.01;
/// A shorter vector has no direction, m/s.
const NO_DIRECTION_MPS: f64 = 1e-9;

/// What barr is at one tick, where it is not constant.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Passing {
    barr: Barr,
    /// Velocity v_b of the mover, m/s.
    mover: Vec2,
    /// Velocity v_c2 that the text derives, m/s.
    derived: Vec2,
}

impl Passing {
    /// `None` where barr is constant.
    fn of(params: &Params, situation: &Situation<'_>) -> Option<Self> {
        let here = situation.pose.position;
        let away_m = |mover: &SensedObstacle| (mover.position - here).norm() - mover.radius_m();
        let nearest = situation.obstacles.iter().min_by(|a, b| away_m(a).total_cmp(&away_m(b)))?;
        let mover = nearest.velocity;
        if mover.norm() < STANDING_MPS {
            return None;
        }
        let sum = direction(situation.pose.theta) * situation.twist.v + mover;
        if params.barr_when == BarrWhen::Acute && angle(sum, mover) >= math::FRAC_PI_2 {
            return None;
        }
        let turned = Vec2::new(-sum.y, sum.x);
        let away = if turned.dot(&mover) <= 0.0 { turned } else { -turned };
        Some(Self { barr: params.barr, mover, derived: away - mover })
    }

    /// barr of a robot that moves with `velocity`, m/s.
    fn of_velocity(&self, velocity: Vec2) -> f64 {
        match self.barr {
            Barr::Sum => angle(velocity + self.mover, self.mover),
            Barr::Relative => angle(velocity - self.mover, self.mover),
            Barr::Target => 1.0 + math::cos(angle(velocity, self.derived)),
        }
    }

    /// barr of rollout `i`.
    fn barr(&self, rollouts: &Rollouts, i: usize) -> f64 {
        let Twist { v, .. } = rollouts.twist(i);
        self.of_velocity(direction(rollouts.end(i).theta) * v)
    }

    /// barr of rollout `i` over the most that it can be.
    fn share(&self, rollouts: &Rollouts, i: usize) -> f64 {
        let most = match self.barr {
            Barr::Sum | Barr::Relative => math::PI,
            Barr::Target => 2.0,
        };
        self.barr(rollouts, i) / most
    }
}

/// The angle between two vectors, rad, from 0 to π; a right one where either has no direction.
fn angle(a: Vec2, b: Vec2) -> f64 {
    if a.norm() < NO_DIRECTION_MPS || b.norm() < NO_DIRECTION_MPS {
        return math::FRAC_PI_2;
    }
    math::atan2(cross(a, b).abs(), a.dot(&b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::OccupancyGrid;
    use crate::observation::Belief;
    use crate::plan::local::dwa;
    use crate::plan::local::tests::{Course, Drive, drives_what_its_formula_says};
    use crate::plan::local::window::{Aim, HeadingAt, Prediction};
    use crate::robot::Robot;
    use crate::settings::quantity::Positive;

    /// The paper's form.
    fn printed() -> Params {
        Params {
            normalise: Normalise::Sum,
            horizon_s: Some(Positive::new(3.0)),
            room_m: NonNegative::new(0.0),
            prediction: Prediction::Euler,
            heading_at: HeadingAt::Horizon,
            d_cap_m: Positive::new(1.0),
            heading_weight: NonNegative::new(0.07),
            distance_weight: NonNegative::new(0.2),
            barr_weight: NonNegative::new(0.4),
            predict_dynamic: false,
            ..Params::default()
        }
    }

    fn drive(course: &Course, params: &Params, ticks: u32) -> Drive {
        let mut planner = Planner::new(params);
        course.drive(ticks, |situation, guidance| planner.decide(situation, guidance))
    }

    fn v(x: f64, y: f64) -> Vec2 {
        Vec2::new(x, y)
    }

    #[test]
    fn barr_is_that_worked_by_hand() {
        let of = |barr, mover: Vec2, velocity: Vec2| {
            Passing { barr, mover, derived: v(1.0, 0.0) }.of_velocity(velocity).to_degrees()
        };
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
        let up = v(0.0, 1.0);
        // A mover that goes up. Beside it at the same speed: the sum points to 45°, the difference to −45°.
        close(of(Barr::Sum, up, v(1.0, 0.0)), 45.0);
        close(of(Barr::Relative, up, v(1.0, 0.0)), 135.0);
        // With it, against it and slower, against it and faster.
        close(of(Barr::Sum, up, v(0.0, 1.0)), 0.0);
        close(of(Barr::Sum, up, v(0.0, -0.5)), 0.0);
        close(of(Barr::Sum, up, v(0.0, -2.0)), 180.0);
        // 30° down at 2 m/s: the sum is (√3, 0).
        close(of(Barr::Sum, up, v(3f64.sqrt(), -1.0)), 90.0);
        // Standing, and both together standing.
        close(of(Barr::Sum, up, v(0.0, 0.0)), 0.0);
        close(of(Barr::Sum, up, v(0.0, -1.0)), 90.0);
        let target = |velocity| Passing { barr: Barr::Target, mover: up, derived: v(1.0, 1.0) }.of_velocity(velocity);
        close(target(v(2.0, 2.0)), 2.0);
        close(target(v(-1.0, -1.0)), 0.0);
        close(target(v(-1.0, 1.0)), 1.0);
    }

    /// What barr is with a robot at the origin that drives along x and these movers.
    fn passing(params: &Params, speed_mps: f64, movers: &[SensedObstacle]) -> Option<Passing> {
        let (robot, belief) = (Robot::default(), Belief::from(&OccupancyGrid::empty(20, 20, 1.0)));
        let pose = Pose::new(10.0, 10.0, 0.0);
        let twist = Twist { v: speed_mps, omega: 0.0 };
        let situation = Situation { twist, obstacles: movers, ..Situation::new(&robot, &belief, pose, v(15.0, 10.0)) };
        Passing::of(params, &situation)
    }

    #[test]
    fn it_is_the_nearest_mover_that_counts_if_it_moves_and_the_angle_is_acute() {
        let always = Params { barr_when: BarrWhen::Always, ..Params::default() };
        let mover = |x: f64, velocity: Vec2, radius_m: f64| SensedObstacle::disc(0, v(x, 10.0), velocity, radius_m);
        let acute = Params::default();
        assert_eq!(passing(&acute, 1.0, &[]), None);
        assert_eq!(passing(&always, 1.0, &[mover(12.0, v(0.0, 0.005), 0.3)]), None);
        // Centres 2 and 2.5 m away, surfaces 1.7 and 1.5 m.
        let two = [mover(12.0, v(0.0, 1.0), 0.3), mover(12.5, v(0.0, -1.0), 1.0)];
        assert_eq!(passing(&acute, 1.0, &two).map(|passing| passing.mover), Some(v(0.0, -1.0)));
        // The first of equals.
        let equal = [mover(12.0, v(0.0, 1.0), 0.3), mover(8.0, v(0.0, -1.0), 0.3)];
        assert_eq!(passing(&acute, 1.0, &equal).map(|passing| passing.mover), Some(v(0.0, 1.0)));
        // Towards a robot that is faster, slower, as fast.
        for (speed_mps, is_acute) in [(1.0, false), (0.3, true), (0.5, false)] {
            let oncoming = [mover(12.0, v(-0.5, 0.0), 0.3)];
            assert_eq!(passing(&acute, speed_mps, &oncoming).is_some(), is_acute);
            assert!(passing(&always, speed_mps, &oncoming).is_some());
        }
    }

    #[test]
    fn the_derived_velocity_is_that_worked_by_hand() {
        let up = [SensedObstacle::disc(0, v(12.0, 9.0), v(0.0, 1.0), 0.3)];
        // v_h1 = (1, 1); turned by +90° it is (−1, 1), towards the mover's direction, so it is (1, −1); v_c2 = (1, −2).
        assert_eq!(passing(&Params::default(), 1.0, &up).map(|passing| passing.derived), Some(v(1.0, -2.0)));
        let down = [SensedObstacle::disc(0, v(12.0, 11.0), v(0.0, -1.0), 0.3)];
        assert_eq!(passing(&Params::default(), 1.0, &down).map(|passing| passing.derived), Some(v(1.0, 2.0)));
    }

    /// Written out once more: the best of the admissible rollouts by eq. 16 and 17.
    fn best_by_the_formula(params: &Params, situation: &Situation<'_>, goal: Vec2) -> Option<Twist> {
        let mut window = DynamicWindow::new(params.window());
        let rollouts = window.roll(situation, &Aim::ON);
        let all: Vec<usize> = rollouts.admissible().collect();
        let v_b = situation.obstacles[0].velocity;
        let between = |a: Vec2, b: Vec2| math::acos(math::clamp(a.dot(&b) / (a.norm() * b.norm()), -1.0, 1.0));
        let is_acute = between(direction(situation.pose.theta) * situation.twist.v + v_b, v_b) < math::FRAC_PI_2;
        let terms: Vec<[f64; 4]> = all
            .iter()
            .map(|&i| {
                let (end, twist) = (rollouts.end(i), rollouts.twist(i));
                let to_goal = goal - end.position;
                let angle = direction(end.theta).dot(&to_goal) / to_goal.norm();
                let dist = math::min(rollouts.clearance_m(i, params.dist_mode), 1.0);
                let barr = if is_acute { between(direction(end.theta) * twist.v + v_b, v_b) } else { 1.0 };
                [math::PI - math::acos(angle), dist, twist.v, barr]
            })
            .collect();
        let sum = |k: usize| terms.iter().map(|term| term[k]).sum::<f64>();
        let sums = [sum(0), sum(1), sum(2), sum(3)];
        let score = |term: &[f64; 4]| {
            let norm = |k: usize| if sums[k] > 0.0 { term[k] / sums[k] } else { 0.0 };
            let others = 0.07 * norm(0) + 0.2 * norm(1) + 0.3 * norm(2);
            match params.barr_mode {
                BarrMode::Additive => others + 0.4 * norm(3),
                BarrMode::Multiplicative => others * norm(3),
            }
        };
        let best = (0..all.len()).max_by(|&a, &b| score(&terms[a]).total_cmp(&score(&terms[b])));
        best.map(|at| rollouts.twist(all[at]))
    }

    #[test]
    fn it_drives_what_the_formula_says() {
        drives_what_its_formula_says(5, |case, situation, guidance| {
            let barr_mode = if case % 2 == 0 { BarrMode::Additive } else { BarrMode::Multiplicative };
            let params = Params { barr_mode, ..printed() };
            let decision = Planner::new(&params).decide(situation, guidance).expect("an answer");
            (decision, best_by_the_formula(&params, situation, guidance.sub_goal))
        });
    }

    #[test]
    fn without_movers_and_beside_one_that_stands_it_drives_as_dwa() {
        let mut course = Course::open(Pose::new(5.0, 20.0, 0.3), v(18.0, 22.0));
        for velocity in [None, Some(v(0.0, 0.0))] {
            course.movers =
                velocity.map(|velocity| SensedObstacle::disc(0, v(11.0, 22.0), velocity, 0.4)).into_iter().collect();
            let mut plain = dwa::Planner::new(&dwa::Params::default());
            let expected = course.drive(400, |situation, guidance| plain.decide(situation, guidance));
            let found = drive(&course, &Params { barr_weight: NonNegative::new(5.0), ..Params::default() }, 400);
            assert!(found.arrived && found.clearance_m > 0.0);
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn it_turns_to_where_a_crossing_mover_comes_from_and_as_printed_for_as_long_as_it_sees_it() {
        // Both would be at (15, 20) after about ten seconds.
        let mut course = Course::open(Pose::new(5.0, 20.0, 0.0), v(25.0, 20.0));
        course.movers = vec![SensedObstacle::disc(0, v(15.0, 11.0), v(0.0, 0.9), 0.3)];
        let drive = |params: Params, weight| {
            let drive = drive(&course, &Params { barr_weight: NonNegative::new(weight), ..params }, 600);
            let lowest_m = drive.poses.iter().map(|pose| pose.position.y).fold(20.0, math::min);
            (drive.arrived && drive.clearance_m > 0.0, lowest_m)
        };
        let (plain, strong) = (drive(Params::default(), 0.0), drive(Params::default(), 1.0));
        assert!(plain.0 && strong.0 && strong.1 < plain.1 - 0.05, "{plain:?} {strong:?}");
        // As printed the mover stands where it is but for barr, and 0.4 outweighs the 0.07 of the heading: the robot drives down to the edge
        // of the map, 19 m away from its way, and is still there after a minute.
        let (plain, weighted) = (drive(printed(), 0.0), drive(printed(), 0.4));
        assert!(plain.1 > 19.9 && !weighted.0 && weighted.1 < 2.0, "{plain:?} {weighted:?}");
    }

    #[test]
    fn a_factor_on_scales_that_are_no_sums_is_refused() {
        let (map, robot) = (OccupancyGrid::empty(20, 20, 1.0), Robot::default());
        let fit = Fit { map: &map, robot: &robot, dt_s: 0.1 };
        let factor = Params { barr_mode: BarrMode::Multiplicative, ..Params::default() };
        assert!(factor.check(&fit).is_err_and(|what| what.contains("normalise: sum")));
        assert_eq!(Params { normalise: Normalise::Sum, ..factor }.check(&fit), Ok(()));
    }
}
