//! `follow_dwa`: the dynamic window approach with two more states: it brakes and waits for a mover that crosses its way, and follows
//! one that goes its way.
//!
//! Source: Hu, Wang, Zhang, dynamic obstacle avoidance based on improved A* and the dynamic window method, Engineering Letters 32(3), 2024,
//! eq. 14 to 18 and section III.D (`hu2024`):
//!
//! ```text
//! G = α norm(heading) + β norm(dist) + μ norm(dist_m) + γ norm(vel) + ψ norm(Path)       largest wins
//! dist   = clearance from statics, at most d_cap          dist_m = clearance from predicted movers, at most d_cap
//! Path   = 1 / (1 + offset / L)                           offset = distance of the end of the rollout from the path
//!
//! track   no mover as below
//! brake   a mover in the way, nearer than d1, faster than v1, that crosses it (45° to 135°): the window is capped at 0, until that mover is
//!         out of the way, at most `wait_max_s`
//! follow  a mover in the way, nearer than d2, faster than 2/3 of the robot's top speed, that goes along it (under 25°): the window is
//!         capped at the mover's speed
//! recover nothing is admissible
//! ```
//!
//! The rules tick by tick are in `docs/book/src/papers/systems.md` §6(a); `tests/oracles/hu2024_follow_dwa.py` is written from them alone. heading and vel
//! are those of [`dwa`](super::dwa), window, rollouts and ties those of [`window`](super::window).
//!
//! That is `normalise: sum`, which the paper's scenarios state. By default (`fixed`) the objective is the one that it shares with `dwa`
//! (`window/objective.rs`): β and μ are what contact with a static and with a mover takes off progress, ψ weighs the distance from the path.
//!
//! Readings of the paper (ids of `systems.md`):
//! - H-A10: the text measures dist and dist_m at the end point of a trajectory; over all of it by default (`dist_mode`), as a collision on the
//!   way counts.
//! - H-A11: Path is said to be a distance, where smaller is better; in a sum that is maximised it is 1 / (1 + offset / L).
//! - H-A12: the paper gives no weights.
//! - H-A13: as printed a mover that comes head-on (180°) makes the robot wait for ever; it brakes up to 135° (`brake_angle_max_deg`).
//! - H-A14: d1, d2 and v1 are not given. d1 is at least the braking distance and 1 m. A robot that has waited `wait_max_s` goes on.
//! - H-A15: at 2/3 of the top speed hardly any mover is followed; `follow_speed_ratio`.
//! - H-A16: the planned direction is that of the path at the robot.
//!
//! Departures: "in the way" looks ahead by `brake_lead_s` when braking is at stake, so that the robot brakes for a mover that is about to step
//! into its way; 0 is as printed. A capped window does not reverse.
//!
//! Parameters: [`Params`].

mod way;

#[cfg(test)]
mod tests;

use super::LocalKind;
use super::window::objective::Weights;
use super::window::params::window_params;
use super::window::weighing::Weighing;
use super::window::{DynamicWindow, Normalise};
use crate::math;
use crate::observation::SensedObstacle;
use crate::plan::contract::{
    Decision, Entry, Failure, Fit, Guidance, LocalPlanner, Notes, Situation, State, StateKind,
};
use crate::settings::quantity::{NonNegative, Positive};
use way::Way;

window_params! {
    /// Parameters of `follow_dwa`.
    pub struct Params {
        /// Weight α of the heading term; higher turns to the path or target sooner and goes round less. Default 0.1.
        pub heading_weight: NonNegative = NonNegative::new(0.1),
        /// Weight β of the distance from statics; with `normalise: fixed` the share of its progress that contact takes off a rollout.
        /// Default 0.8.
        pub distance_weight: NonNegative = NonNegative::new(0.8),
        /// Weight μ of the distance from movers; with `normalise: fixed` the share of its progress that contact takes off a rollout.
        /// Default 0.8.
        pub movers_weight: NonNegative = NonNegative::new(0.8),
        /// Weight γ of the velocity term; lower is timid. Default 0.3.
        pub velocity_weight: NonNegative = NonNegative::new(0.3),
        /// Distance L from the path at which the term Path is a half, m; only with `normalise: sum`. Default 1.
        pub offset_scale_m: Positive = Positive::new(1.0),
        /// Whether the robot brakes and follows; else it only tracks. Default true.
        pub states: bool = true,
        /// Least distance d1 below which a mover makes the robot brake, m; it is at least the braking distance and 1 m. Default 2.
        pub brake_distance_m: Positive = Positive::new(2.0),
        /// Speed v1 above which a mover makes the robot brake, m/s. Default 0.1.
        pub brake_speed_mps: NonNegative = NonNegative::new(0.1),
        /// Angle between the motion of a mover and the way above which the robot brakes for it, degrees. Default 45.
        pub brake_angle_min_deg: NonNegative = NonNegative::new(45.0),
        /// The same up to which it brakes, degrees; 180 is as printed. Default 135.
        pub brake_angle_max_deg: NonNegative = NonNegative::new(135.0),
        /// How far ahead a mover counts as in the way for braking, s; 0 is as printed. Default 1.
        pub brake_lead_s: NonNegative = NonNegative::new(1.0),
        /// Longest time that the robot brakes and waits for one mover, s. Default 10.
        pub wait_max_s: Positive = Positive::new(10.0),
        /// Distance d2 below which a mover is followed, m. Default 4.
        pub follow_distance_m: Positive = Positive::new(4.0),
        /// Share of the robot's top speed above which a mover is followed. Default 2/3.
        pub follow_speed_ratio: NonNegative = NonNegative::new(2.0 / 3.0),
        /// Angle between the motion of a mover and the way below which it is followed, degrees. Default 25.
        pub follow_angle_max_deg: NonNegative = NonNegative::new(25.0),
        /// Room to either side of the robot within which a mover is in its way, m. Default 0.2.
        pub corridor_margin_m: NonNegative = NonNegative::new(0.2),
    }
}

/// Standing, or braking to a stand, until a mover has left the way.
pub const BRAKE: State = State { name: "brake", kind: StateKind::Waiting };
/// Behind a mover, no faster than it.
pub const FOLLOW: State = State { name: "follow", kind: StateKind::Tracking };

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Dynamic window that brakes and waits for movers that cross its way and follows those that go its way.",
    source: "Hu, Wang, Zhang, Research on dynamic obstacle avoidance method of mobile robot based on improved A* algorithm and dynamic window method, Engineering Letters 32(3), 2024, eq. 18 and section III.D",
    reacts_to_movers: true,
    states: &[State::TRACK, BRAKE, FOLLOW, State::RECOVER],
    notes: &["cap_mps"],
    ..Entry::PLAIN
};

/// Room before the mover beyond the braking distance, m (H-A14).
const ROOM_M: f64 = 1.0;

impl LocalKind for Params {
    fn build(&self) -> Box<dyn LocalPlanner> {
        Box::new(Planner::new(self))
    }

    fn check(&self, fit: &Fit<'_>) -> Result<(), String> {
        DynamicWindow::check(&self.window(), fit)
    }
}

impl Params {
    /// d1, m.
    fn brake_distance_m(&self, situation: &Situation<'_>) -> f64 {
        let speed_mps = situation.twist.v;
        let braking_m = speed_mps * speed_mps / (2.0 * situation.robot.deceleration_max_mps2);
        math::max(self.brake_distance_m.get(), braking_m + ROOM_M)
    }
}

/// The mover for which the robot brakes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Braking {
    mover: u32,
    /// Distance along the path within which it is in the way, m: d1 when the robot began to brake.
    reach_m: f64,
    /// Ticks since then.
    ticks: u32,
}

/// What lasts from tick to tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Progress {
    braking: Option<Braking>,
    /// A mover for which the robot waits no longer, until it has been out of the way.
    given_up: Option<u32>,
}

/// The planner.
#[derive(Clone, Debug)]
pub struct Planner {
    params: Params,
    weighing: Weighing,
    progress: Progress,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone(), weighing: Weighing::new(params.window()), progress: Progress::default() }
    }

    /// The state of this tick and the highest speed in it, m/s.
    fn state(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> (State, f64) {
        const FREE: (State, f64) = (State::TRACK, f64::INFINITY);
        let Self { params, progress, .. } = self;
        if !params.states || situation.obstacles.is_empty() {
            *progress = Progress::default();
            return FREE;
        }
        let way = Way::new(situation, guidance, params.corridor_margin_m.get());
        let dt_s = situation.dt_s;
        let lead_ticks = (params.brake_lead_s.get() / dt_s).round() as u32;
        let brake_m = params.brake_distance_m(situation);
        let sensed = |id: u32| situation.obstacles.iter().find(|mover| mover.id == id);
        let is_in_the_way = |mover: &SensedObstacle, reach_m: f64| way.holds(mover, reach_m, lead_ticks, dt_s);
        let nearest = |is_one: &dyn Fn(&SensedObstacle) -> bool| {
            let movers = situation.obstacles.iter().filter(|mover| is_one(mover));
            movers.min_by(|a, b| way.gap_m(a).total_cmp(&way.gap_m(b)))
        };

        progress.given_up =
            progress.given_up.filter(|&id| sensed(id).is_some_and(|mover| is_in_the_way(mover, brake_m)));
        if let Some(braking) = &mut progress.braking {
            braking.ticks += 1;
            let holds = sensed(braking.mover).is_some_and(|mover| is_in_the_way(mover, braking.reach_m));
            let has_waited = f64::from(braking.ticks) * dt_s >= params.wait_max_s.get() - 1e-9;
            if holds && !has_waited {
                return (BRAKE, 0.0);
            }
            if holds {
                progress.given_up = Some(braking.mover);
            }
            progress.braking = None;
        }
        let is_across = |angle_deg: f64| {
            angle_deg > params.brake_angle_min_deg.get() && angle_deg <= params.brake_angle_max_deg.get()
        };
        let crosses = |mover: &SensedObstacle| {
            progress.given_up != Some(mover.id)
                && mover.velocity.norm() > params.brake_speed_mps.get()
                && way.gap_m(mover) < brake_m
                && is_across(way.angle_deg(mover))
                && is_in_the_way(mover, brake_m)
        };
        if let Some(mover) = nearest(&crosses) {
            progress.braking = Some(Braking { mover: mover.id, reach_m: brake_m, ticks: 0 });
            return (BRAKE, 0.0);
        }
        let follow_m = params.follow_distance_m.get();
        let goes_along = |mover: &SensedObstacle| {
            mover.velocity.norm() > params.follow_speed_ratio.get() * situation.robot.speed_max_mps
                && way.gap_m(mover) < follow_m
                && way.angle_deg(mover) < params.follow_angle_max_deg.get()
                && way.holds(mover, follow_m, 0, dt_s)
        };
        nearest(&goes_along).map_or(FREE, |mover| (FOLLOW, mover.velocity.norm()))
    }
}

impl LocalPlanner for Planner {
    fn decide(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Result<Decision, Failure> {
        let (state, cap_mps) = self.state(situation, guidance);
        let params = &self.params;
        let (best, target) = if params.normalise == Normalise::Fixed {
            let weights =
                Weights { movers: params.movers_weight.get(), ..params.weights(params.velocity_weight.get()) };
            let d_cap_m = params.d_cap_m.get();
            self.weighing.roll(situation, guidance, cap_mps);
            let best = self
                .weighing
                .best(situation, |objective, rollouts, i| objective.score(rollouts, i, &weights, d_cap_m, 1.0));
            (best, guidance.sub_goal)
        } else {
            let target = params.target.point(situation, guidance);
            let best = self.weighing.best_by_sums(situation, cap_mps, |rollouts, score| {
                let terms = params.terms(rollouts, situation, target);
                let cap_m = params.d_cap_m.get();
                let offset_m = |i| guidance.path.project(rollouts.end(i).position).1;
                score.add(params.heading_weight.get(), |i| terms.heading(i));
                score.add(params.distance_weight.get(), |i| {
                    math::min(rollouts.static_clearance(i).at(params.dist_mode), cap_m)
                });
                score.add(params.movers_weight.get(), |i| {
                    math::min(rollouts.mover_clearance(i).at(params.dist_mode), cap_m)
                });
                score.add(params.velocity_weight.get(), |i| terms.velocity_mps(i));
                if params.path_weight.get() > 0.0 {
                    score.add(params.path_weight.get(), |i| 1.0 / (1.0 + offset_m(i) / params.offset_scale_m.get()));
                }
            });
            (best, target)
        };
        let decision = self.weighing.decide(best, situation, target);
        let state = if decision.state == State::RECOVER { State::RECOVER } else { state };
        let notes = Notes::new(&[math::min(cap_mps, situation.robot.speed_max_mps)]);
        Ok(Decision { state, notes, ..decision })
    }

    fn reset(&mut self) {
        self.weighing.reset();
        self.progress = Progress::default();
    }

    fn entry(&self) -> &'static Entry {
        &ENTRY
    }
}
