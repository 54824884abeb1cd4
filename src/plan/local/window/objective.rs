//! The objective on fixed scales: progress along the path, and what tempers it.
//!
//! ```text
//! G = m · (π gain / (v_max T) + γ f min(v, cap) / v_max)              m: 1 less what nearness to obstacles takes off
//!     − δ min(offset / 0.5 m, 1) + α align − 1.5 max(0, v − cap) / v_max  (+ terms of the planner)
//! gain   = way along the path from the robot to the pose judged
//! offset = distance of that pose from the path;   align = 1 − |its heading − direction to the path 0.4 m on| / 2
//! m      = (1 − β (1 − clearance / d_cap)²), where nearer than d_cap, times the same for movers
//! ```
//!
//! The pose judged is that at the end of the horizon or on arrival at the target, if that is sooner. `cap` is the speed at which
//! the robot can still stop at the end of the path, and turn to a target that is near and aside.
//!
//! Why so: progress is what the robot is there for, and no other term can outweigh it, so that standing still before an open gap
//! is never the best. Clearance is a factor on progress and not a term beside it: as a term it makes the robot creep before
//! a doorway, and it counts near contact only. Scales do not depend on the other candidates: those that do make the best speed
//! jump as the window moves with the speed.
//!
//! Sources: progress and distance from the path instead of the heading to a goal are those of the trajectory controllers of
//! `base_local_planner` and DWB (E. Marder-Eppstein and others; D. V. Lu, "dwb_local_planner", Navigation2: PathDist, GoalDist, PathAlign) and of
//! the global dynamic window (O. Brock, O. Khatib, ICRA 1999: NF1 in place of the heading).

use super::{Aim, DynamicWindow, Rollouts, Score};
use crate::geometry::{Piece, Vec2, direction};
use crate::math;
use crate::plan::contract::{Guidance, Situation};
use crate::plan::local::stopping_speed_mps;

/// Weights of the terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Weights {
    /// Of progress.
    pub(crate) progress: f64,
    /// Of the distance from the path.
    pub(crate) path: f64,
    /// Of the heading along the path.
    pub(crate) heading: f64,
    /// What contact with a static takes off progress, as a share.
    pub(crate) distance: f64,
    /// The same with a mover.
    pub(crate) movers: f64,
    /// Of the speed.
    pub(crate) velocity: f64,
}

/// Distance from the path beyond which a pose is no worse, m.
const OFFSET_MAX_M: f64 = 0.5;
/// Distance along the path at which its direction is taken, m.
const ALIGN_M: f64 = 0.4;
/// Weight of speed above the cap.
const EXCESS_WEIGHT: f64 = 1.5;
/// What takes a rollout that leads nowhere behind all others.
const STANDING: f64 = 10.0;
/// Least progress that is not standing, m.
const PROGRESS_MIN_M: f64 = 0.02;
/// A target beyond this bearing is turned to on the spot, rad.
const TURN_RAD: f64 = 1.4;
/// Weight of the speed of a robot that turns: on the spot where that is admissible, on an arc where a corner is in the way.
const TURN_SPEED_WEIGHT: f64 = 0.05;
/// The same while it rolls: it brakes first, for what it would hit on a fast arc keeps it from turning.
const TURN_BRAKING_WEIGHT: f64 = 1.0;
/// Speed below which it does not count as rolling, m/s, or what two control periods of braking take off, if that is more.
const TURN_ROLLING_MPS: f64 = 0.1;
/// A target nearer than this is reached, whatever its bearing, m.
const TURN_MIN_M: f64 = 1e-3;
/// How far the part of the path that is looked at begins behind the robot, m.
const BEHIND_M: f64 = 0.5;
/// Share of its progress that a rollout keeps if the robot has to brake for a mover.
const BRAKING_SHARE: f64 = 0.3;

/// A straight part of the path.
#[derive(Clone, Copy, Debug)]
struct Leg {
    from: Vec2,
    along: Vec2,
    length_m: f64,
    start_m: f64,
}

/// The path ahead of the robot and what it asks for; keeps its memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Objective {
    legs: Vec<Leg>,
    first_m: f64,
    progress_m: f64,
    /// Place of the robot on the path, m.
    now_m: f64,
    /// Its distance from the path, m.
    offset_m: f64,
    cap_mps: f64,
    arrival_m: f64,
    /// Angle by which the robot is to turn before it drives on, rad.
    turn_rad: Option<f64>,
    turn_speed_weight: f64,
    speed_max_mps: f64,
    reach_m: f64,
    movers_horizon_s: f64,
    /// Least progress of a rollout that counts, m.
    least_m: f64,
}

impl Objective {
    /// Takes in the situation; what the window is to sample for it.
    pub(crate) fn aim(
        &mut self,
        situation: &Situation<'_>,
        guidance: &Guidance<'_>,
        window: &mut DynamicWindow,
    ) -> Aim {
        let (robot, pose, dt_s) = (situation.robot, situation.pose, situation.dt_s);
        let (horizon_s, movers_horizon_s) = window.horizons_s(robot);
        self.speed_max_mps = math::max(robot.speed_max_mps, 1e-9);
        self.reach_m = self.speed_max_mps * horizon_s;
        self.movers_horizon_s = movers_horizon_s;
        let fastest =
            math::min(robot.speed_max_mps, math::max(situation.twist.v, 0.0) + robot.acceleration_max_mps2 * dt_s);
        self.least_m = math::min(PROGRESS_MIN_M, 0.5 * fastest * horizon_s);
        self.progress_m = guidance.progress_m;
        self.first_m = guidance.progress_m - BEHIND_M;
        self.take_legs(guidance, guidance.progress_m + 1.5 * self.reach_m + ALIGN_M);
        (self.now_m, self.offset_m) = self.project(pose.position, self.progress_m);

        let length_m = guidance.key_nodes.last().map_or(0.0, |node| node.along_m);
        let left_m = math::max(length_m - guidance.progress_m, (guidance.path.end() - pose.position).norm());
        let target_m = (guidance.sub_goal - pose.position).norm();
        let bearing = pose.bearing_to(guidance.sub_goal);
        let aside = math::sin(math::min(bearing.abs(), math::FRAC_PI_2));
        let turning = if aside > 0.0 { robot.yaw_rate_max_radps * target_m / (2.0 * aside) } else { f64::INFINITY };
        let stopping = stopping_speed_mps(left_m, robot, dt_s);
        self.cap_mps = math::min(robot.speed_max_mps, math::min(stopping, turning));
        self.arrival_m = if left_m < self.reach_m { left_m } else { f64::INFINITY };
        let turns = bearing.abs() > TURN_RAD && target_m > TURN_MIN_M;
        self.turn_rad = turns.then(|| {
            // The short way round, unless a body that is no disc is held up on it and not on the long one.
            let long = bearing - math::sign(bearing) * 2.0 * math::PI;
            if !window.can_turn(situation, bearing) && window.can_turn(situation, long) { long } else { bearing }
        });
        let slow_mps = math::max(2.0 * robot.deceleration_max_mps2 * dt_s, TURN_ROLLING_MPS);
        let is_rolling = situation.twist.v.abs() > slow_mps;
        self.turn_speed_weight = if is_rolling { TURN_BRAKING_WEIGHT } else { TURN_SPEED_WEIGHT };
        Aim { speed_mps: Some(self.cap_mps), arrival_m: self.arrival_m, stop: guidance.path.end(), ..Aim::ON }
    }

    /// The legs of the path up to `last_m`.
    fn take_legs(&mut self, guidance: &Guidance<'_>, last_m: f64) {
        const SAGITTA_M: f64 = 0.01;
        const CHORDS_MAX: f64 = 200.0;
        self.legs.clear();
        let mut start_m = 0.0;
        for (from, piece) in guidance.path.segments() {
            let length_m = piece.length(from);
            if start_m + length_m >= self.first_m && start_m <= last_m {
                let chords = if matches!(piece, Piece::Line { .. }) {
                    1
                } else {
                    piece.chord_count(from, SAGITTA_M, CHORDS_MAX)
                };
                let mut along_m = start_m;
                for k in 0..chords {
                    let (a, b) = (piece.chord_point(from, k, chords), piece.chord_point(from, k + 1, chords));
                    let chord_m = (b - a).norm();
                    if chord_m > 0.0 {
                        self.legs.push(Leg { from: a, along: (b - a) / chord_m, length_m: chord_m, start_m: along_m });
                    }
                    along_m += length_m / f64::from(chords);
                }
            }
            start_m += length_m;
        }
        if self.legs.is_empty() {
            let (from, along) = (guidance.path.end(), Vec2::new(1.0, 0.0));
            self.legs.push(Leg { from, along, length_m: 0.0, start_m });
        }
    }

    /// The nearest place on the path up to `last_m`, m, and the distance from it, m.
    fn project(&self, p: Vec2, last_m: f64) -> (f64, f64) {
        let (mut place_m, mut nearest) = (self.first_m, f64::INFINITY);
        for leg in &self.legs {
            let (low, high) = (self.first_m - leg.start_m, last_m - leg.start_m);
            if high < 0.0 && nearest.is_finite() {
                break;
            }
            let wanted = math::clamp((p - leg.from).dot(&leg.along), low, math::max(high, low));
            let along_m = math::clamp(wanted, 0.0, leg.length_m);
            let squared = (p - leg.from - leg.along * along_m).norm_squared();
            if squared < nearest {
                (place_m, nearest) = (leg.start_m + along_m, squared);
            }
        }
        (place_m, nearest.sqrt())
    }

    /// The point of the path at `place_m`.
    fn point_at(&self, place_m: f64) -> Vec2 {
        let leg = self
            .legs
            .iter()
            .find(|leg| place_m <= leg.start_m + leg.length_m)
            .unwrap_or(&self.legs[self.legs.len() - 1]);
        leg.from + leg.along * math::clamp(place_m - leg.start_m, 0.0, leg.length_m)
    }

    /// Score of rollout `i`: the larger the better. `speed_factor` is the f of the velocity term.
    pub(crate) fn score(
        &self,
        rollouts: &Rollouts,
        i: usize,
        weights: &Weights,
        d_cap_m: f64,
        speed_factor: f64,
    ) -> f64 {
        let twist = rollouts.twist(i);
        if let Some(turn_rad) = self.turn_rad {
            let missed = (turn_rad - twist.omega * rollouts.duration_s()).abs() / math::PI;
            return -missed - self.turn_speed_weight * twist.v.abs() / self.speed_max_mps;
        }
        let pose = rollouts.pose_within(i, self.arrival_m);
        let driven_m = math::min(twist.v.abs() * rollouts.duration_s(), self.arrival_m);
        let (place_m, offset_m) = self.project(pose.position, self.progress_m + 1.5 * driven_m + PROGRESS_MIN_M);
        let gain_m = place_m - self.now_m;
        let on = self.point_at(place_m + ALIGN_M) - pose.position;
        let away_m = on.norm();
        let align =
            if away_m > PROGRESS_MIN_M { 1.0 - 0.5 * (on / away_m - direction(pose.theta)).norm() } else { 1.0 };
        // A robot does not slow down for what it has to come near to.
        let static_cap_m = math::min(d_cap_m, rollouts.stop_clearance_m());
        let share = nearness_share(rollouts.static_clearance(i).path_min_m, static_cap_m, weights.distance)
            * self.movers_share(
                rollouts.going_on_s(i),
                rollouts.mover_clearance(i).path_min_m,
                d_cap_m,
                weights.movers,
            );
        let gain = gain_m / self.reach_m;
        let speed = math::clamp(twist.v, 0.0, self.cap_mps) / self.speed_max_mps;
        let excess = math::max(twist.v - self.cap_mps, 0.0) / self.speed_max_mps;
        let (gained, lost) = (math::max(gain, 0.0), math::min(gain, 0.0));
        let leads_nowhere = gain_m < self.least_m && self.offset_m - offset_m < self.least_m;
        share * (weights.progress * gained + weights.velocity * speed_factor * speed) + weights.progress * lost
            - weights.path * math::min(offset_m / OFFSET_MAX_M, 1.0)
            + weights.heading * align
            - EXCESS_WEIGHT * excess
            - if leads_nowhere { STANDING } else { 0.0 }
    }

    /// The best rollout of this tick by `score`, where it leads anywhere without those that have to stop before a mover, else with
    /// them; `None` if no rollout is admissible.
    pub(crate) fn best(
        &self,
        window: &mut DynamicWindow,
        situation: &Situation<'_>,
        scores: &mut Score,
        score: impl Fn(&Rollouts, usize) -> f64,
    ) -> Option<usize> {
        let mut choose = |rollouts: &Rollouts| {
            let mut scoring = scores.over(rollouts);
            scoring.set(|i| score(rollouts, i));
            scoring.best().map(|best| (best, scoring.score(best)))
        };
        match choose(window.rollouts()) {
            Some((best, score)) if score > -0.5 * STANDING => Some(best),
            _ => choose(window.admit_stopping(situation)).map(|(best, _)| best),
        }
    }

    /// Share of its progress that a rollout keeps with respect to movers.
    fn movers_share(&self, going_on_s: f64, clearance_m: f64, d_cap_m: f64, weight: f64) -> f64 {
        if going_on_s.is_infinite() {
            nearness_share(clearance_m, d_cap_m, weight)
        } else {
            BRAKING_SHARE * going_on_s / self.movers_horizon_s
        }
    }
}

/// Share of its progress that a rollout keeps so near to obstacles.
fn nearness_share(clearance_m: f64, d_cap_m: f64, weight: f64) -> f64 {
    let near = if clearance_m < d_cap_m { 1.0 - clearance_m / d_cap_m } else { 0.0 };
    1.0 - math::min(weight, 1.0) * near * near
}

#[cfg(test)]
mod tests {
    use super::super::{BrakingDistance, BrakingTurn, Normalise, Prediction, Settings, Spacing};
    use super::*;
    use crate::geometry::{Path, Pose, Twist};
    use crate::map::OccupancyGrid;
    use crate::observation::Belief;
    use crate::robot::Robot;

    const WEIGHTS: Weights =
        Weights { progress: 1.0, path: 0.5, heading: 0.1, distance: 0.8, movers: 0.8, velocity: 0.3 };

    fn window() -> DynamicWindow {
        DynamicWindow::new(Settings {
            normalise: Normalise::Fixed,
            horizon_s: None,
            movers_horizon_s: None,
            room_m: 0.02,
            prediction: Prediction::Arc,
            speed: Spacing::Count(11),
            yaw_rate: Spacing::Count(21),
            predict_dynamic: true,
            clearance_cap_m: 0.3,
            distance_mode: super::super::DistanceMode::PathMin,
            measure: super::super::Measure::Exact,
            braking_distance: BrakingDistance::Arc,
            braking_clip_m: None,
            braking_turn: BrakingTurn::Off,
        })
    }

    /// What the window is to sample, the score of each twist, and the best one, in an open hall.
    fn judge(path: &Path, pose: Pose, twist: Twist) -> (Aim, Vec<(Twist, f64)>, Twist) {
        let (belief, robot) = (Belief::from(&OccupancyGrid::empty(40, 40, 1.0)), Robot::default());
        let situation = Situation { twist, ..Situation::new(&robot, &belief, pose, path.end()) };
        let mut nodes = Vec::new();
        path.key_nodes(&mut nodes);
        let sub_goal = path.point_at(math::min(path.project(pose.position).0 + 3.0, path.length()));
        let guidance =
            Guidance { sub_goal, key_nodes: &nodes, ..Guidance::to_end(path, path.project(pose.position).0) };
        let (mut window, mut objective, mut scores) = (window(), Objective::default(), Score::default());
        let aim = objective.aim(&situation, &guidance, &mut window);
        window.roll(&situation, &aim);
        let of = |rollouts: &Rollouts, i: usize| objective.score(rollouts, i, &WEIGHTS, 0.3, 1.0);
        let best = objective.best(&mut window, &situation, &mut scores, of).expect("an open hall");
        let rollouts = window.rollouts();
        let all = (0..rollouts.len()).map(|i| (rollouts.twist(i), of(rollouts, i))).collect();
        (aim, all, rollouts.twist(best))
    }

    fn path(points: &[(f64, f64)]) -> Path {
        Path::polyline(&points.iter().map(|&(x, y)| Vec2::new(x, y)).collect::<Vec<_>>())
    }

    #[test]
    fn on_the_path_the_score_is_the_one_worked_by_hand() {
        let (aim, all, best) =
            judge(&path(&[(5.0, 20.0), (35.0, 20.0)]), Pose::new(10.0, 20.0, 0.0), Twist { v: 0.8, omega: 0.0 });
        assert!(aim.speed_mps == Some(1.0) && aim.arrival_m.is_infinite());
        // Straight on at v: all of v · 1.5 s is gained, of 1.5 m; the heading is the path's; 0.3 for the speed.
        for (twist, score) in all.iter().filter(|(twist, _)| twist.omega == 0.0) {
            assert!((score - (twist.v + 0.1 + 0.3 * twist.v)).abs() < 1e-4, "{twist:?} {score}");
        }
        assert!((best.v - 0.85).abs() < 1e-9 && best.omega == 0.0, "{best:?}");
    }

    #[test]
    fn standing_is_behind_whatever_leads_on() {
        let start = Pose::new(10.0, 20.0, 0.3);
        let (_, all, best) = judge(&path(&[(10.0, 20.0), (35.0, 20.0)]), start, Twist::ZERO);
        let standing = all.iter().find(|(twist, _)| *twist == Twist::ZERO).unwrap().1;
        assert!(standing < -9.0 && best.v == 0.05 && best.omega < 0.0, "{standing} {best:?}");
    }

    #[test]
    fn beside_the_path_it_turns_towards_it_and_behind_it_it_turns_round() {
        let line = path(&[(5.0, 20.0), (35.0, 20.0)]);
        let (_, _, best) = judge(&line, Pose::new(10.0, 20.4, 0.0), Twist { v: 0.8, omega: 0.0 });
        assert!(best.omega < 0.0, "{best:?}");
        // Rolling away from it: brake first.
        let (_, _, best) = judge(&line, Pose::new(10.0, 20.0, 3.0), Twist { v: 0.8, omega: 0.0 });
        assert!(best.v == 0.75 && best.omega < 0.0, "{best:?}");
        let (_, _, best) = judge(&line, Pose::new(10.0, 20.0, 3.0), Twist::ZERO);
        assert!(best.v == 0.0 && best.omega == -0.2, "{best:?}");
    }

    #[test]
    fn before_the_end_it_drives_the_speed_at_which_it_can_still_stop() {
        let line = path(&[(5.0, 20.0), (11.0, 20.0)]);
        let (aim, _, best) = judge(&line, Pose::new(10.5, 20.0, 0.0), Twist { v: 0.7, omega: 0.0 });
        let cap = aim.speed_mps.unwrap();
        // v dt and 0.05 m/s less in each tick that follows: 0.5 m in all.
        let mut way_m = 0.0;
        let mut v = cap;
        while v > 0.0 {
            way_m += 0.1 * v;
            v -= 0.05;
        }
        assert!((way_m - 0.5).abs() < 1e-9 && (aim.arrival_m - 0.5).abs() < 1e-9, "{way_m}");
        assert_eq!(best, Twist { v: cap, omega: 0.0 });
    }
}
