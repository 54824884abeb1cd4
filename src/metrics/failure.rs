//! Causes of failures, as far as the trace of an episode shows them: for reports and for finding defects.
//!
//! An outcome says *what* ended the episode; the cause says what led to it. The rules are tried from the top, the first that
//! holds names the cause, so each failure has exactly one. They describe, they do not blame: "the mover turned" means that it did so
//! shortly before the contact, not that the robot could not have known better.

use crate::episode::Outcome;
use crate::geometry::Vec2;
use crate::math;
use crate::plan::contract::StateKind;
use crate::trace::Trace;
use crate::world::{ObstacleKind, Scene};

/// Longest time from a mover's turn to a contact that the turn explains, s.
const TURNED_WITHIN_S: f64 = 1.5;
/// Change of a mover's velocity that counts as a turn, m/s.
const TURN_MPS: f64 = 0.1;
/// Longest time from a lack of admissible commands to a contact that it explains, s.
const NO_COMMAND_WITHIN_S: f64 = 1.0;
/// Distance from the robot's centre to the surface of an unknown static that explains why it stands, m.
const HELD_WITHIN_M: f64 = 1.0;
/// A robot that moved farther than this in the last half minute before the time-out was not held, m.
const HELD_RADIUS_M: f64 = 1.0;
/// Duration of that half minute, s.
const HELD_FOR_S: f64 = 30.0;

/// Cause of a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// A mover ran into the robot, which stood still.
    HitAtRest,
    /// The mover changed its velocity within 1.5 s before the contact: no constant-velocity prediction could know.
    MoverTurned,
    /// Within the last second the local planner had found no admissible command: it braked, or turned on the spot, in vain.
    NoWayOut,
    /// The local planner took the command that led into a mover for a good one up to the end.
    MoverNotForeseen,
    /// The robot drove into something that stands still: an obstacle, or the edge of the map.
    StaticContact,
    /// The robot stood, or paced up and down, beside an obstacle that is not on its map.
    HeldByUnknown,
    /// The robot stood, or paced up and down, with nothing but the known map around it.
    HeldByKnown,
    /// The robot was still driving at the time-out.
    UnderWay,
    /// No path, a crash, no feasible world: the outcome says it all.
    NeverDrove,
}

impl Cause {
    /// All causes, in the order of the rules.
    pub const ALL: [Self; 9] = [
        Self::HitAtRest,
        Self::MoverTurned,
        Self::NoWayOut,
        Self::MoverNotForeseen,
        Self::StaticContact,
        Self::HeldByUnknown,
        Self::HeldByKnown,
        Self::UnderWay,
        Self::NeverDrove,
    ];

    /// The cause in words, for the line of a report.
    pub fn words(self) -> &'static str {
        match self {
            Self::HitAtRest => "a mover ran into the robot, which stood still",
            Self::MoverTurned => "a mover changed course less than 1.5 s before it met the robot",
            Self::NoWayOut => "no admissible command was left in the last second before a mover was met",
            Self::MoverNotForeseen => "the robot drove into a mover by a command that it took for a safe one",
            Self::StaticContact => "the robot touched something that stands still",
            Self::HeldByUnknown => "the robot got stuck beside an obstacle that is not on its map",
            Self::HeldByKnown => "the robot got stuck among known obstacles",
            Self::UnderWay => "the robot was under way when the drive ended",
            Self::NeverDrove => "no drive: no path, no feasible world, or a crash",
        }
    }
}

/// The cause of a failure; `None` for a success.
///
/// `radius_m` is the robot's circumscribed radius, `dt_s` the control period.
pub fn cause(scene: &Scene, radius_m: f64, outcome: &Outcome, trace: &Trace, dt_s: f64) -> Option<Cause> {
    Some(match outcome {
        Outcome::Success => return None,
        Outcome::Collision { with: ObstacleKind::Dynamic, at_rest: true } => Cause::HitAtRest,
        Outcome::Collision { with: ObstacleKind::Dynamic, at_rest: false } => collision(scene, radius_m, trace, dt_s),
        Outcome::Collision { .. } => Cause::StaticContact,
        Outcome::Timeout | Outcome::Stuck => held(scene, trace, dt_s),
        Outcome::NoPath { .. }
        | Outcome::PlannerError { .. }
        | Outcome::InternalError { .. }
        | Outcome::GaveUp { .. }
        | Outcome::InfeasibleWorld { .. } => Cause::NeverDrove,
    })
}

/// Rows of the trace that lie within the last `time_s`, the last one included.
fn last_rows(trace: &Trace, time_s: f64, dt_s: f64) -> core::ops::Range<usize> {
    let rows = trace.ticks.len();
    rows.saturating_sub((time_s / dt_s).round() as usize + 1)..rows
}

fn collision(scene: &Scene, radius_m: f64, trace: &Trace, dt_s: f64) -> Cause {
    let Some(end) = trace.ticks.last() else { return Cause::NeverDrove };
    let movers = trace.movers_at(trace.ticks.len() - 1);
    let gap_m =
        |index: usize| (movers[index].position - end.pose.position).norm() - scene.movers[index].radius_m() - radius_m;
    let nearest =
        (0..movers.len()).filter(|&index| movers[index].present).min_by(|&a, &b| gap_m(a).total_cmp(&gap_m(b)));
    let velocity = |row: usize| nearest.map_or(Vec2::zeros(), |index| trace.movers_at(row)[index].velocity);
    let turned = last_rows(trace, TURNED_WITHIN_S, dt_s)
        .skip(1)
        .any(|row| (velocity(row) - velocity(row - 1)).norm() > TURN_MPS);
    if turned {
        return Cause::MoverTurned;
    }
    let without_command =
        last_rows(trace, NO_COMMAND_WITHIN_S, dt_s).any(|row| trace.ticks[row].state.kind == StateKind::Recovering);
    if without_command { Cause::NoWayOut } else { Cause::MoverNotForeseen }
}

fn held(scene: &Scene, trace: &Trace, dt_s: f64) -> Cause {
    let Some(end) = trace.ticks.last().map(|tick| tick.pose.position) else { return Cause::NeverDrove };
    let strayed_m = last_rows(trace, HELD_FOR_S, dt_s)
        .map(|row| (trace.ticks[row].pose.position - end).norm())
        .fold(0.0, math::max);
    if strayed_m > HELD_RADIUS_M {
        Cause::UnderWay
    } else if scene.unknown_static.iter().any(|obstacle| obstacle.distance_m(end) <= HELD_WITHIN_M) {
        Cause::HeldByUnknown
    } else {
        Cause::HeldByKnown
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{drive, mover, scene_with};
    use super::*;
    use crate::geometry::{Pose, Twist};
    use crate::plan::contract::State;
    use crate::trace::MoverState;
    use crate::world::{Shape, UnknownStatic};

    const HIT: Outcome = Outcome::Collision { with: ObstacleKind::Dynamic, at_rest: false };

    /// A robot on the spot for `ticks` ticks beside a mover whose velocity is `velocity(row)`.
    fn beside_a_mover(ticks: u32, velocity: impl Fn(usize) -> Vec2) -> (Scene, Trace) {
        let scene = scene_with(vec![mover(Vec2::new(5.0, 5.5), Vec2::zeros(), 0.3)], Vec::new());
        let ticks = drive(Pose::new(5.0, 5.0, 0.0), &vec![Twist::ZERO; ticks as usize]);
        let state = |row: usize| MoverState { position: Vec2::new(5.0, 5.5), velocity: velocity(row), present: true };
        let movers = (0..ticks.len()).map(state).collect();
        (scene, Trace { ticks, movers, mover_count: 1, ..Trace::default() })
    }

    #[test]
    fn each_rule_names_its_cause_and_the_first_one_wins() {
        let steady = |_: usize| Vec2::new(0.5, 0.0);
        let (scene, mut trace) = beside_a_mover(40, steady);
        let of = |outcome: &Outcome, trace: &Trace| cause(&scene, 0.25, outcome, trace, 0.1);
        assert_eq!(of(&Outcome::Success, &trace), None);
        assert_eq!(of(&HIT, &trace), Some(Cause::MoverNotForeseen));
        trace.ticks[33].state = State::RECOVER;
        assert_eq!(of(&HIT, &trace), Some(Cause::NoWayOut), "0.7 s before the end");
        trace.ticks[33].state = State::TRACK;
        trace.ticks[28].state = State::RECOVER;
        assert_eq!(of(&HIT, &trace), Some(Cause::MoverNotForeseen), "1.2 s before the end");
        let at_rest = Outcome::Collision { with: ObstacleKind::Dynamic, at_rest: true };
        assert_eq!(of(&at_rest, &trace), Some(Cause::HitAtRest));
        for with in [ObstacleKind::KnownStatic, ObstacleKind::UnknownStatic, ObstacleKind::Boundary] {
            assert_eq!(of(&Outcome::Collision { with, at_rest: true }, &trace), Some(Cause::StaticContact));
        }
        assert_eq!(of(&Outcome::NoPath { message: String::new() }, &trace), Some(Cause::NeverDrove));
    }

    #[test]
    fn a_turn_of_the_mover_explains_a_contact_within_a_second_and_a_half() {
        for (row, expected) in [
            (30, Cause::MoverTurned),
            (26, Cause::MoverTurned),
            (25, Cause::MoverNotForeseen),
            (1, Cause::MoverNotForeseen),
        ] {
            let (scene, trace) =
                beside_a_mover(40, |at| if at < row { Vec2::new(0.5, 0.0) } else { Vec2::new(-0.5, 0.0) });
            assert_eq!(cause(&scene, 0.25, &HIT, &trace, 0.1), Some(expected), "turned at row {row} of 40");
        }
    }

    #[test]
    fn a_robot_that_is_held_is_told_from_one_under_way() {
        let mut scene = scene_with(Vec::new(), Vec::new());
        let trace =
            |start: Pose, v: f64| Trace { ticks: drive(start, &[Twist { v, omega: 0.0 }; 310]), ..Trace::default() };
        let (still, moving) = (trace(Pose::new(5.0, 5.0, 0.0), 0.0), trace(Pose::new(2.0, 5.0, 0.0), 0.1));
        let of = |scene: &Scene, trace: &Trace| cause(scene, 0.25, &Outcome::Timeout, trace, 0.1);
        assert_eq!(of(&scene, &still), Some(Cause::HeldByKnown));
        assert_eq!(of(&scene, &moving), Some(Cause::UnderWay));
        scene.unknown_static.push(UnknownStatic::new(Pose::new(6.4, 5.0, 0.0), Shape::Disc { radius_m: 0.3 }));
        assert_eq!(of(&scene, &still), Some(Cause::HeldByKnown), "1.1 m away");
        scene.unknown_static.push(UnknownStatic::new(Pose::new(5.0, 6.2, 0.0), Shape::Disc { radius_m: 0.3 }));
        assert_eq!(of(&scene, &still), Some(Cause::HeldByUnknown), "0.9 m away");
    }
}
