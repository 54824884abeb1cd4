//! `pdwa`: the path is cut into regions, and the dynamic window drives only where something unexpected is in the way.
//!
//! Source: Qin, Gao, Lu, "SSA*-PDWA: A Hierarchical Path Planning Framework …", Computers, Materials & Continua 87(1), 86, 2026 (`qin2026`),
//! section 4.6, eq. 21 to 23; its Algorithm 2 is a picture. In prose: rectangles along the global path are scanned one after the other; where an
//! obstacle in the robot's rectangle "is predicted to potentially collide with the robot within the planning time window", the dynamic window
//! drives to the end of the rectangle; where it finds no feasible velocity, the robot backs up along the path and looks again; after several
//! failures it goes to a safe place and waits until the obstacles have moved.
//!
//! ```text
//! follow    nothing in the way: pure pursuit of the path
//! avoid     a conflict in the region: the dynamic window, towards the region's end; back to `follow` after `calm_s` without conflict
//! retreat   no command was admissible: backwards along the path; after `retreat_s` it looks again at every tick
//! withdraw  the `attempts_max`-th attempt in the region failed: backwards to the beginning of the region before, without looking again
//! wait      there, or where it cannot go on backwards: standing, until nothing has been in the way for `calm_s`, at most `wait_s`
//! ```
//!
//! The rules tick by tick are in `docs/book/src/papers/systems.md` §3(a); `tests/oracles/qin2026_pdwa.py` is written from them alone. The regions are in
//! `regions`, what counts as a conflict in `conflict`, the way back in `retreat`.
//!
//! Readings of the paper (ids of `systems.md`):
//! - Q-A9: p_i and p_{i+1} are called the corners of a region and the ends of its axis; the rectangle is about the axis, as wide as
//!   `region_half_width_m` to either side.
//! - The text cuts the path at its turning points (`split: turning_points`), and warns of regions that are too long or too short; by
//!   default (`split: length`) they are 2 to 8 m long.
//! - The safe location is undefined: it is the beginning of the region before; in region 0, which has none before, the start.
//! - "No feasible velocity" is an empty set of admissible ones. Standing before an obstacle is always feasible, so a robot that the window
//!   holds there would never retreat: by default `stall_s` of standing counts as a failure as well. 0 turns that off, as printed.
//! - Retreat and retries do not exclude endless cycles, whatever the text says ("finite time, no infinite loops"): a lane that stays blocked
//!   is tried again and again (T14). The episode then ends by its time limit.
//!
//! Departures: tracking is pure pursuit, which the text does not name. A robot that cannot reverse (`limits.reverse_speed_max_mps` 0) waits
//! where it is. Obstacles count in the rectangle of the robot alone, as printed; while it retreats or waits also in those ahead, up to
//! the one in which it failed.
//!
//! Parameters: [`Params`].

mod conflict;
mod regions;
mod retreat;

#[cfg(test)]
mod tests;

use super::{LocalKind, dwa, pure_pursuit};
use crate::geometry::Twist;
use crate::plan::contract::{
    Decision, Entry, Failure, Fit, Guidance, LocalPlanner, Notes, Request, Situation, State, StateKind,
};
use crate::robot::Robot;
use crate::settings::quantity::{Count, NonNegative, Positive};
use conflict::Watch;
use regions::Regions;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where the path is cut into regions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Split {
    /// At its key nodes, then by length: longer regions are cut, shorter ones joined.
    #[default]
    Length,
    /// At its key nodes, as printed.
    TurningPoints,
}

/// When the dynamic window drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Trigger {
    /// Where a conflict is predicted.
    #[default]
    Conflict,
    /// All the time: the regions without the trigger, to see what the trigger does (T12).
    Always,
}

/// Parameters of `pdwa`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Where the path is cut into regions. Default `length`.
    pub split: Split,
    /// Length above which a region is cut into equal ones with `split: length`, m. Default 8.
    pub region_length_max_m: Positive,
    /// Length below which a region is joined with the next one with `split: length`, m. Default 2.
    pub region_length_min_m: NonNegative,
    /// Half the width of a region, m; wider looks at more obstacles. Default 1.5.
    pub region_half_width_m: Positive,
    /// How far a region reaches beyond both of its ends, m; the robot is in the next region as soon as it is in its rectangle. Default 0.5.
    pub region_overlap_m: NonNegative,
    /// When the dynamic window drives. Default `conflict`.
    pub trigger: Trigger,
    /// Time T_w over which a conflict is predicted, s. Default 3.
    pub conflict_window_s: Positive,
    /// Gap between robot and obstacle below which they conflict, m. Default 0.3.
    pub conflict_margin_m: NonNegative,
    /// Time without conflict after which the robot follows the path again, s. Default 1.
    pub calm_s: Positive,
    /// Time for which the dynamic window may hold the robot on the spot before the attempt has failed, s; 0: for ever, as printed. Default 5.
    pub stall_s: NonNegative,
    /// Failed attempts N_max in one region after which the robot withdraws. Default 5.
    pub attempts_max: Count,
    /// Speed of the retreat, m/s, at most what the robot may reverse with. Default 0.2.
    pub retreat_speed_mps: Positive,
    /// Time for which a retreat goes on before the robot looks again, s. Default 1.
    pub retreat_s: Positive,
    /// Longest time that the robot waits before it tries again, s. Default 10.
    pub wait_s: Positive,
    /// Look-ahead distance on the path, forwards and backwards, m. Default 0.8.
    pub lookahead_m: Positive,
    /// The dynamic window, with the parameters of `dwa`.
    pub avoid: dwa::Params,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            split: Split::default(),
            region_length_max_m: Positive::new(8.0),
            region_length_min_m: NonNegative::new(2.0),
            region_half_width_m: Positive::new(1.5),
            region_overlap_m: NonNegative::new(0.5),
            trigger: Trigger::default(),
            conflict_window_s: Positive::new(3.0),
            conflict_margin_m: NonNegative::new(0.3),
            calm_s: Positive::new(1.0),
            stall_s: NonNegative::new(5.0),
            attempts_max: Count::new(5),
            retreat_speed_mps: Positive::new(0.2),
            retreat_s: Positive::new(1.0),
            wait_s: Positive::new(10.0),
            lookahead_m: Positive::new(0.8),
            avoid: dwa::Params::default(),
        }
    }
}

/// Nothing in the way: pure pursuit.
pub const FOLLOW: State = State { name: "follow", kind: StateKind::Tracking };
/// The dynamic window drives.
pub const AVOID: State = State { name: "avoid", kind: StateKind::Tracking };
/// Backwards along the path, ready to try again.
pub const RETREAT: State = State { name: "retreat", kind: StateKind::Retreating };
/// Backwards to the safe place.
pub const WITHDRAW: State = State { name: "withdraw", kind: StateKind::Retreating };
/// Standing until the way is free.
pub const WAIT: State = State { name: "wait", kind: StateKind::Waiting };

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Pure pursuit, and the dynamic window where something unexpected is in the way; retreats and waits where that fails.",
    source: "Qin, Gao, Lu, SSA*-PDWA, Computers, Materials & Continua 87(1), 86, 2026, section 4.6",
    reacts_to_movers: true,
    states: &[FOLLOW, AVOID, RETREAT, WITHDRAW, WAIT],
    notes: &["region", "conflict", "failures"],
    ..Entry::PLAIN
};

/// A robot that is slower stands, m/s.
const STANDING_MPS: f64 = 0.05;
/// The beginning of the region before counts as reached within this distance, m.
const REACHED_M: f64 = 0.05;

impl LocalKind for Params {
    fn build(&self) -> Box<dyn LocalPlanner> {
        Box::new(Planner::new(self))
    }

    fn check(&self, fit: &Fit<'_>) -> Result<(), String> {
        self.avoid.check(fit)
    }
}

/// State that lasts from tick to tick.
#[derive(Clone, Copy, Debug)]
struct Progress {
    state: State,
    /// Earlier ticks that ended in this state without a break.
    ticks: u32,
    /// Ticks without conflict.
    calm_ticks: u32,
    /// Ticks for which the dynamic window has held the robot on the spot.
    stalled_ticks: u32,
    /// Attempts that failed in region `failed_region`.
    failures: u32,
    failed_region: usize,
}

impl Progress {
    const BEGIN: Self =
        Self { state: FOLLOW, ticks: 0, calm_ticks: 0, stalled_ticks: 0, failures: 0, failed_region: 0 };

    fn enter(&mut self, state: State) {
        (self.state, self.ticks, self.stalled_ticks) = (state, 0, 0);
    }
}

/// The planner.
#[derive(Clone, Debug)]
pub struct Planner {
    params: Params,
    window: dwa::Planner,
    tracker: pure_pursuit::Planner,
    regions: Regions,
    progress: Progress,
    watch: Watch,
    /// The robot as the dynamic window may drive it: it reverses in a retreat alone.
    forward: Robot,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self {
            window: dwa::Planner::new(&params.avoid),
            tracker: pure_pursuit::Planner::new(&pure_pursuit::Params { lookahead_m: params.lookahead_m }),
            regions: Regions::default(),
            progress: Progress::BEGIN,
            watch: Watch::default(),
            forward: Robot::default(),
            params: params.clone(),
        }
    }

    /// Whether something is in the way: in the robot's region, and while it is held up in those to the one in which it failed.
    fn is_conflict(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>, region: usize) -> bool {
        if self.params.trigger == Trigger::Always {
            return true;
        }
        let is_held_up = matches!(self.progress.state, RETREAT | WITHDRAW | WAIT);
        let last = if is_held_up { self.progress.failed_region.max(region) } else { region };
        let rectangles = self.regions.rectangles(region, last);
        self.watch.is_conflict(&self.params, situation, guidance, rectangles)
    }

    /// What the dynamic window makes of the situation, towards the end of a region.
    fn avoid(
        &mut self,
        situation: &Situation<'_>,
        guidance: &Guidance<'_>,
        region: usize,
    ) -> Result<Decision, Failure> {
        let (from, to) = self.regions.ends(region);
        let guidance = Guidance {
            previous_node: from,
            sub_goal: to,
            is_last: guidance.is_last && self.regions.is_last(region),
            ..*guidance
        };
        let decision = self.window.decide(&Situation { robot: &self.forward, ..*situation }, &guidance)?;
        Ok(Decision { request: Some(Request::SubGoal(to)), ..decision })
    }
}

/// Whether the dynamic window found an admissible command.
fn is_admissible(decision: &Decision) -> bool {
    decision.state != State::RECOVER
}

impl LocalPlanner for Planner {
    fn decide(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Result<Decision, Failure> {
        if self.regions.follow(guidance, &self.params) {
            self.progress = Progress::BEGIN;
            self.forward = Robot { reverse_speed_max_mps: 0.0, ..situation.robot.clone() };
        }
        let region = self.regions.at(guidance.progress_m);
        if region > self.progress.failed_region {
            self.progress.failures = 0;
        }
        let ticks = |time_s: f64| ((time_s / situation.dt_s).round() as u32).max(1);
        let (calm, retreat, wait) =
            (ticks(self.params.calm_s.get()), ticks(self.params.retreat_s.get()), ticks(self.params.wait_s.get()));
        let stall = self.params.stall_s.get();
        let is_conflict = self.is_conflict(situation, guidance, region);
        let can_reverse = situation.robot.reverse_speed_max_mps > 0.0;
        // Rollouts of an attempt that failed in this tick.
        let mut simulated = (0, 0);
        let mut decision = loop {
            let progress = &mut self.progress;
            match progress.state {
                AVOID => {
                    progress.calm_ticks = if is_conflict { 0 } else { progress.calm_ticks + 1 };
                    if progress.calm_ticks >= calm {
                        progress.enter(FOLLOW);
                        continue;
                    }
                    let decision = self.avoid(situation, guidance, region)?;
                    let progress = &mut self.progress;
                    let is_standing = decision.command.v.abs() < STANDING_MPS;
                    progress.stalled_ticks = if is_standing { progress.stalled_ticks + 1 } else { 0 };
                    let is_stalled = stall > 0.0 && progress.stalled_ticks >= ticks(stall);
                    if is_admissible(&decision) && !is_stalled {
                        break decision;
                    }
                    simulated = (decision.rollouts, decision.rollout_points);
                    progress.failures += 1;
                    progress.failed_region = region;
                    let is_last = progress.failures > self.params.attempts_max.get();
                    progress.enter(if is_last { WITHDRAW } else { RETREAT });
                }
                RETREAT if progress.ticks >= retreat && !is_conflict => progress.enter(FOLLOW),
                RETREAT | WITHDRAW => {
                    if progress.state == RETREAT && progress.ticks >= retreat {
                        let decision = self.avoid(situation, guidance, region)?;
                        if is_admissible(&decision) {
                            self.progress.enter(AVOID);
                            self.progress.calm_ticks = 0;
                            break decision;
                        }
                        simulated = (decision.rollouts, decision.rollout_points);
                    }
                    let progress = &mut self.progress;
                    let safe_m = self.regions.begin_m(progress.failed_region.saturating_sub(1));
                    if can_reverse && guidance.progress_m > safe_m + REACHED_M {
                        break retreat::back_up(&self.params, situation, guidance);
                    }
                    progress.enter(WAIT);
                    progress.calm_ticks = 0;
                }
                WAIT => {
                    progress.calm_ticks = if is_conflict { 0 } else { progress.calm_ticks + 1 };
                    if progress.calm_ticks >= calm {
                        progress.failures = 0;
                        progress.enter(FOLLOW);
                    } else if progress.ticks >= wait {
                        (progress.failures, progress.calm_ticks) = (0, 0);
                        progress.enter(AVOID);
                    } else {
                        break Decision::track(Twist::ZERO);
                    }
                }
                _ if is_conflict => {
                    progress.calm_ticks = 0;
                    progress.enter(AVOID);
                }
                _ => break self.tracker.decide(situation, guidance)?,
            }
        };
        let progress = &mut self.progress;
        progress.ticks += 1;
        decision.rollouts += simulated.0;
        decision.rollout_points += simulated.1;
        let notes = [region as f64, f64::from(u8::from(is_conflict)), f64::from(progress.failures)];
        Ok(Decision { state: progress.state, notes: Notes::new(&notes), ..decision })
    }

    fn reset(&mut self) {
        self.window.reset();
        self.tracker.reset();
        self.regions.clear();
        self.progress = Progress::BEGIN;
    }

    fn entry(&self) -> &'static Entry {
        &ENTRY
    }
}
