//! `dwa`: the dynamic window approach.
//!
//! Of the twists that one tick of acceleration can reach, drive each one ahead as if it stayed constant, drop those
//! that touch something or from which the robot could not stop, and command the one that gets farthest along the path for what it
//! risks. It reacts to what is near; it does not search, so a pocket between it and the target holds it. As the local layer under a
//! global path, or alone in open space.
//!
//! Source: D. Fox, W. Burgard, S. Thrun, "The dynamic window approach to collision avoidance", IEEE Robotics &
//! Automation Magazine 4(1), 1997, for the window and the choice. Two objectives (`normalise`):
//!
//! - `fixed` (default): progress along the path, tempered by nearness, with the equations and sources of
//!   `window/objective.rs`. Movers are looked at over a horizon of their own, with braking
//!   (`window/movers.rs`), and where no twist is admissible a manoeuvre beyond the window is looked for.
//! - `sum`: the form of the five papers reproduced here (gao2025 eq. 19–25, qin2026 eq. 10–17, zhu2025 eq. 11–16, zhao2025
//!   eq. 10–15, hu2024 eq. 14–18), which agree on
//!
//! ```text
//! G = α norm(heading) + β norm(dist) + γ norm(velocity)            largest wins, over V_s ∩ V_d ∩ V_a
//! heading  = π − |angle between the final heading and the line from the end point to the target|
//! dist     = clearance of the rollout, at most d_cap
//! velocity = v (0 where it reverses)
//! norm(k)  = k / Σ k over the admissible rollouts
//! ```
//!
//! The window, the rollouts and V_a are those of [`window`](super::window), the normalisation and the ties those of
//! [`Scoring`](super::window::Scoring).
//!
//! What `sum` does that an engineer would not expect, and why it is not the default: a rollout that ends beyond its target counts
//! as pointing away, so the robot drives no faster than distance / horizon and creeps to its goal; standing still before
//! an open gap can be the best, for nothing rewards progress; and as norm(k) is taken over a window that moves with the speed, the
//! best speed jumps from tick to tick at low speeds.
//!
//! Departures and choices (ids of `systems.md`):
//! - Movers keep their velocity (`predict_dynamic`, G-A12); the papers' scenarios turn it off for `dwa`.
//! - With `sum` the heading is taken on arrival at the target, or at the end of the horizon if that is sooner. The papers print the
//!   end (`heading_at: horizon`); Fox et al. take it where the robot would stop if it braked after the next tick (`stop`).
//! - `distance` is cut at 0.3 m: with the papers' usual 2 m it draws the robot into pockets.
//! - The braking rule goes by arc length to the first contact (Fox et al.) and not by the clearance to the sides.
//! - With `sum` the velocity term knows no target: a target well inside the circle that the robot drives at full speed and
//!   yaw rate can be orbited. With `fixed` the speed is capped so that the robot can turn to a near target and stop at the
//!   last one.
//! - No admissible twist: with movers near the manoeuvre that touches nothing or touches last, else
//!   [`recover`](super::window::DynamicWindow::recover); counted as a recovery.
//!
//! Parameters: [`Params`].

use super::LocalKind;
use super::window::params::window_params;
use super::window::weighing::Weighing;
use super::window::{DynamicWindow, Normalise};
use crate::plan::contract::{Decision, Entry, Failure, Fit, Guidance, LocalPlanner, Situation, State};
use crate::settings::quantity::NonNegative;

window_params! {
    /// Parameters of `dwa`.
    pub struct Params {
        /// Weight α of the heading term; higher turns to the path or target sooner and goes round less. Default 0.1.
        pub heading_weight: NonNegative = NonNegative::new(0.1),
        /// Weight β of the distance from obstacles; with `normalise: fixed` the share of its progress that contact takes off a rollout.
        /// Default 0.8.
        pub distance_weight: NonNegative = NonNegative::new(0.8),
        /// Weight γ of the velocity term; lower is timid. Default 0.3.
        pub velocity_weight: NonNegative = NonNegative::new(0.3),
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Dynamic window: the twist within reach that gets farthest along the path for what it risks; for open space or under a global path.",
    source: "D. Fox, W. Burgard, S. Thrun, The dynamic window approach to collision avoidance, IEEE Robotics & Automation Magazine 4(1), 1997",
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
        if params.normalise == Normalise::Fixed {
            let (weights, d_cap_m) = (params.weights(params.velocity_weight.get()), params.d_cap_m.get());
            self.weighing.roll(situation, guidance, f64::INFINITY);
            let best = self
                .weighing
                .best(situation, |objective, rollouts, i| objective.score(rollouts, i, &weights, d_cap_m, 1.0));
            return Ok(self.weighing.decide(best, situation, guidance.sub_goal));
        }
        let target = params.target.point(situation, guidance);
        let best = self.weighing.best_by_sums(situation, f64::INFINITY, |rollouts, score| {
            let terms = params.terms(rollouts, situation, target);
            score.add(params.heading_weight.get(), |i| terms.heading(i));
            score.add(params.distance_weight.get(), |i| terms.distance_m(i));
            score.add(params.velocity_weight.get(), |i| terms.velocity_mps(i));
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pose, Vec2};
    use crate::map::{Cell, OccupancyGrid};
    use crate::math;
    use crate::observation::SensedObstacle;
    use crate::plan::local::tests::{Course, Drive};
    use crate::plan::local::window::{BrakingDistance, HeadingAt, Prediction, Spacing};
    use crate::rng::{EpisodeSeed, Purpose, Stream};
    use crate::robot::Robot;
    use crate::settings::quantity::Positive;

    /// The papers' form.
    fn printed() -> Params {
        Params {
            normalise: Normalise::Sum,
            horizon_s: Some(Positive::new(3.0)),
            room_m: NonNegative::new(0.0),
            prediction: Prediction::Euler,
            heading_at: HeadingAt::Horizon,
            d_cap_m: Positive::new(0.5),
            distance_weight: NonNegative::new(0.2),
            velocity_weight: NonNegative::new(0.1),
            predict_dynamic: false,
            ..Params::default()
        }
    }

    fn drive(course: &Course, params: &Params, ticks: u32) -> Drive {
        let mut planner = Planner::new(params);
        course.drive(ticks, |situation, guidance| planner.decide(situation, guidance))
    }

    #[test]
    fn in_open_space_it_arrives_from_any_heading_the_goal_straight_behind_included() {
        let mut stream = EpisodeSeed { seed: 1, episode: 0 }.stream(Purpose::Planner, 0);
        for case in 0..60 {
            let theta = if case == 0 { math::PI } else { stream.range(-math::PI, math::PI) };
            let start = Pose::new(15.0, 20.0, theta);
            let course = Course::open(start, Vec2::new(15.0 + stream.range(1.5, 10.0), 20.0));
            for params in [
                Params::default(),
                printed(),
                Params { heading_at: HeadingAt::Stop, ..printed() },
                Params { heading_at: HeadingAt::Arrival, ..printed() },
            ] {
                let drive = drive(&course, &params, 400);
                assert!(drive.arrived, "{params:?} from {start:?} to {:?}", course.path.end());
                assert!(drive.decisions.iter().all(|decision| decision.state == State::TRACK));
            }
        }
    }

    #[test]
    fn a_straight_run_is_straight_fast_and_slows_down_for_the_goal() {
        let course = Course::open(Pose::new(5.0, 20.0, 0.0), Vec2::new(25.0, 20.0));
        // Within 0.25 m of the goal: with fixed scales still able to stop there, √(2 · 0.5 · 0.25) = 0.5 m/s; as printed the end
        // of the rollout stays about the target, v ≈ distance / horizon.
        for (params, last_mps, ticks) in [(Params::default(), 0.56, 222), (printed(), 0.2, 400)] {
            let drive = drive(&course, &params, ticks);
            assert!(drive.arrived);
            assert!(drive.poses.iter().all(|pose| (pose.position.y - 20.0).abs() < 0.1));
            let fastest = drive.decisions.iter().map(|decision| decision.command.v).fold(0.0, math::max);
            assert!(fastest > 0.99, "{fastest}");
            assert!(drive.decisions.last().unwrap().command.v < last_mps);
        }
    }

    #[test]
    fn it_goes_round_a_block() {
        let mut course = Course::open(Pose::new(10.0, 20.3, 0.0), Vec2::new(22.0, 20.0));
        course.grid.set_occupied(Cell { col: 15, row: 19 });
        course.grid.set_occupied(Cell { col: 15, row: 20 });
        // The papers' weights: a stronger heading term holds the robot in front of a block with the target behind it.
        let params = Params { heading_weight: NonNegative::new(0.05), ..printed() };
        let drive = drive(&course, &params, 500);
        assert!(drive.arrived && drive.clearance_m > 0.0, "{} {}", drive.arrived, drive.clearance_m);
    }

    #[test]
    fn it_stops_before_a_wall_that_it_cannot_pass() {
        let mut course = Course::open(Pose::new(10.0, 20.5, 0.0), Vec2::new(30.0, 20.5));
        for row in 0..40 {
            course.grid.set_occupied(Cell { col: 16, row });
        }
        for params in [Params::default(), printed()] {
            let drive = drive(&course, &params, 400);
            assert!(!drive.arrived && drive.clearance_m > 0.0, "{}", drive.clearance_m);
            assert!(drive.poses.iter().all(|pose| pose.position.x < 16.0 - 0.25));
        }
    }

    fn cluttered(stream: &mut Stream, side: i32, resolution_m: f64, density: f64, robot: &Robot) -> Course {
        loop {
            let mut point = || Vec2::new(stream.range(1.0, 19.0), stream.range(1.0, 19.0));
            let (start, goal) = (point(), point());
            let mut course = Course::open(Pose::new(start.x, start.y, stream.range(-3.0, 3.0)), goal);
            course.robot = robot.clone();
            course.grid = OccupancyGrid::empty(side, side, resolution_m);
            for row in 0..side {
                for col in 0..side {
                    if stream.uniform() < density {
                        course.grid.set_occupied(Cell { col, row });
                    }
                }
            }
            if course.clearance_m(&course.grid, start, &[]) > 0.05 && course.clearance_m(&course.grid, goal, &[]) > 0.05
            {
                return course;
            }
        }
    }

    /// The robot and limits of gao2025.
    fn gao() -> Robot {
        Robot {
            radius_m: 0.15,
            acceleration_max_mps2: 0.2,
            deceleration_max_mps2: 0.2,
            yaw_rate_max_radps: 0.6,
            yaw_acceleration_max_radps2: 0.3,
            ..Robot::default()
        }
    }

    #[test]
    fn it_never_touches_a_static_obstacle() {
        let mut stream = EpisodeSeed { seed: 6, episode: 0 }.stream(Purpose::Planner, 0);
        let (mut with_fixed, mut as_printed) = (0, 0);
        for robot in [Robot::default(), gao()] {
            for (side, resolution_m, density) in [(20, 1.0, 0.12), (80, 0.25, 0.01)] {
                for _ in 0..12 {
                    let course = cluttered(&mut stream, side, resolution_m, density, &robot);
                    for (params, arrived) in [(Params::default(), &mut with_fixed), (printed(), &mut as_printed)] {
                        let drive = drive(&course, &params, 300);
                        assert!(drive.clearance_m > 0.0, "{} from {:?}", drive.clearance_m, course.start);
                        *arrived += u32::from(drive.arrived);
                    }
                }
            }
        }
        // Alone in clutter it gets caught in pockets, but a good part of the drives arrives within the half minute.
        assert!(with_fixed > 10 && as_printed > 16, "{with_fixed} and {as_printed} of 48");
    }

    /// A mover that crosses 4 m ahead, so that it and a robot that does not yield meet.
    fn crossing() -> Course {
        let mut course = Course::open(Pose::new(10.0, 20.0, 0.0), Vec2::new(20.0, 20.0));
        course.movers = vec![SensedObstacle::disc(0, Vec2::new(14.0, 25.2), Vec2::new(0.0, -1.0), 0.3)];
        course
    }

    #[test]
    fn prediction_gives_way_to_a_crossing_mover() {
        let fixed = drive(&crossing(), &Params::default(), 400);
        assert!(fixed.arrived && fixed.clearance_m > 0.02, "{}", fixed.clearance_m);
        let predicting = drive(&crossing(), &Params { predict_dynamic: true, ..printed() }, 400);
        assert!(predicting.arrived && predicting.clearance_m > 0.0, "{}", predicting.clearance_m);
        // It sees the mover come before the one that takes it to stand still does.
        let frozen = drive(&crossing(), &printed(), 400);
        let parted = predicting.poses.iter().zip(&frozen.poses).position(|(a, b)| a != b).unwrap();
        let mover_y = 25.2 - 0.1 * parted as f64;
        assert!(mover_y > 20.55, "the two parted only with the mover at y = {mover_y}");
        assert!(predicting.clearance_m > frozen.clearance_m, "{} {}", predicting.clearance_m, frozen.clearance_m);
    }

    #[test]
    fn answers_do_not_depend_on_what_was_driven_before() {
        let mut stream = EpisodeSeed { seed: 8, episode: 0 }.stream(Purpose::Planner, 0);
        let mut used = Planner::new(&Params::default());
        for _ in 0..4 {
            let mut course = cluttered(&mut stream, 20, 1.0, 0.12, &Robot::default());
            course.movers = crossing().movers;
            // A planner that has driven elsewhere, a new one, and a new one at every tick: the same bits.
            used.reset();
            let after = course.drive(150, |situation, guidance| used.decide(situation, guidance));
            assert_eq!(after, drive(&course, &Params::default(), 150));
            let forgetful =
                course.drive(150, |situation, guidance| Planner::new(&Params::default()).decide(situation, guidance));
            assert_eq!(after, forgetful);
        }
    }

    #[test]
    fn parameters_are_read_with_their_defaults_and_unknown_ones_refused() {
        let params: Params =
            serde_yaml::from_str("horizon_s: 2\nva_distance: clearance\nyaw_rate_step_radps: 0.01").unwrap();
        assert_eq!(params.window().yaw_rate, Spacing::Step(0.01));
        assert_eq!(params.window().speed, Spacing::Count(11));
        assert_eq!(
            (params.window().horizon_s, params.window().braking_distance),
            (Some(2.0), BrakingDistance::Clearance)
        );
        assert_eq!(serde_yaml::from_str::<Params>("va_uses_clip: true").unwrap().window().braking_clip_m, Some(0.3));
        assert!(serde_yaml::from_str::<Params>("horizon: 2").is_err());
        assert!(serde_yaml::from_str::<Params>("speed_samples: 1").is_err());
    }
}
