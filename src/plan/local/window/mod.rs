//! The dynamic window, shared by all DWA planners here.
//!
//! Once per tick [`DynamicWindow::roll`] samples the twists within reach (V_s ∩ V_d), drives each
//! for the horizon against the believed map and the sensed movers, and says which are
//! admissible: those that touch nothing and from which the robot can brake in time (V_a). The
//! planner weighs the admissible ones with [`Score`] and takes the best; if none is admissible it
//! takes the command of [`DynamicWindow::recover`].
//!
//! ```text
//! V_s = { v_min ≤ v ≤ v_max, |ω| ≤ ω_max }
//! V_d = { v_c − a_dec dt ≤ v ≤ v_c + a_acc dt, |ω − ω_c| ≤ α dt }
//! V_a = { v ≤ √(2 dist a_dec), |ω| ≤ √(2 dist α) }        and nothing touched within the horizon
//! ```
//!
//! A rollout that touches a static within the horizon is not admissible, however late, unless it has arrived before. Movers are met in one of
//! two ways ([`Normalise`]): as statics are, or over a horizon of their own with braking (`movers.rs`). One exception: a robot that believes
//! itself in contact already (noise of its pose, a map cell that turned occupied beside it) may stand, turn or
//! drive out, only not deeper in; otherwise a centimetre of noise would hold it for ever.
//!
//! Source: D. Fox, W. Burgard, S. Thrun, "The dynamic window approach to collision avoidance",
//! IEEE Robotics & Automation Magazine 4(1), 1997.

mod escape;
mod exact;
mod lanes;
mod movers;
pub(crate) mod objective;
pub(crate) mod params;
mod patch;
pub(crate) mod pull;
mod recovery;
mod rollout;
mod rollouts;
mod sampling;
mod score;
mod settings;
mod terms;
pub(crate) mod weighing;

#[cfg(test)]
mod tests;

pub use recovery::Recovery;
pub use rollouts::{Clearance, Rollouts};
pub use sampling::{SAMPLES_MAX, Spacing, Window};
pub use score::{Score, Scoring};
pub use settings::{BrakingDistance, BrakingTurn, DistanceMode, Measure, Normalise, Prediction, Settings};
pub(crate) use terms::Terms;
pub use terms::{HeadingAt, Target};

use crate::geometry::convex::{self, Polygon, turned};
use crate::geometry::{Pose, Twist, Vec2, direction};
use crate::math;
use crate::plan::contract::{Decision, Fit, Notes, Situation, State};
use crate::robot::Robot;
use exact::Exact;
use lanes::{LANES, Lane, Lanes, Plain, Width};
use movers::{Ahead, Bounce, Course, Met};
use patch::{Anchor, Patch};
use rollout::{Block, Disc, FAR, Field, Part, Passing, Track, quarters};

/// Most poses that one decision may predict, all candidates together: some seconds of work.
const POSES_MAX: f64 = 1e8;

/// Samples, simulates and judges the twists within reach. Keeps its memory from tick to tick, and nothing else
/// that an answer depends on.
#[derive(Clone, Debug)]
pub struct DynamicWindow {
    settings: Settings,
    width: Width,
    patch: Patch,
    rollouts: Rollouts,
    speeds: Vec<f64>,
    yaw_rates: Vec<f64>,
    blocks: Vec<Block>,
    /// Share of the speed that is driven in each step.
    profile: Vec<f32>,
    track: Vec<[Lane; 2]>,
    discs: Vec<Disc>,
    /// Parts of the footprint outside its inscribed disc; empty for a disc.
    parts: Vec<Part>,
    carried: Vec<[Lane; 2]>,
    squares: Vec<Lane>,
    turnings: Vec<Turning>,
    ahead: Ahead,
}

/// What the planner is after in this cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// The speed that the target asks for, m/s; sampled exactly.
    pub speed_mps: Option<f64>,
    /// Way left to the point at which the robot is to stand, m; infinite if it is to go on.
    pub arrival_m: f64,
    /// That point, no farther away than the way to it.
    pub stop: Vec2,
    /// Highest speed to be sampled, m/s, where one tick of braking reaches it; below infinity the robot does not reverse either.
    /// It narrows the window and leaves the scales of the objective as they are.
    pub cap_mps: f64,
}

impl Aim {
    /// To go on.
    pub const ON: Self =
        Self { speed_mps: None, arrival_m: f64::INFINITY, stop: Vec2::new(0.0, 0.0), cap_mps: f64::INFINITY };
}

impl DynamicWindow {
    /// A window that has seen nothing yet.
    pub fn new(settings: Settings) -> Self {
        Self {
            settings,
            width: Width::widest(),
            patch: Patch::default(),
            rollouts: Rollouts::new(),
            speeds: Vec::new(),
            yaw_rates: Vec::new(),
            blocks: Vec::new(),
            profile: Vec::new(),
            track: Vec::new(),
            discs: Vec::new(),
            parts: Vec::new(),
            carried: Vec::new(),
            squares: Vec::new(),
            turnings: Vec::new(),
            ahead: Ahead::default(),
        }
    }

    /// Whether a window with these settings fits a map and a robot.
    ///
    /// # Errors
    /// A message that says what is too large, with the numbers.
    pub fn check(settings: &Settings, fit: &Fit<'_>) -> Result<(), String> {
        let robot = fit.robot;
        let horizon_s = match settings.normalise {
            Normalise::Sum => settings.horizon_s(robot),
            Normalise::Fixed => math::max(settings.horizon_s(robot), settings.movers_horizon_s(robot)),
        };
        let speed = math::max(robot.speed_max_mps, robot.reverse_speed_max_mps);
        let steps = math::max((horizon_s / fit.dt_s).round(), 1.0);
        let [speeds, yaw_rates] = Spacing::most(settings.speed, settings.yaw_rate, robot, fit.dt_s);
        let candidates = (speeds * yaw_rates).round();
        if candidates * steps > POSES_MAX {
            return Err(format!(
                "{candidates} candidates of {steps} periods each are too much for one decision, expected at most {POSES_MAX:e} poses: \
                 lower `horizon_s` or the number of samples"
            ));
        }
        let reach_m = speed * steps * fit.dt_s + robot.footprint.as_ref().map_or(0.0, Polygon::circumradius_m);
        let pitch_m = patch::pitch_m(fit.map);
        if patch::is_coverable(reach_m, pitch_m) {
            return Ok(());
        }
        let cell_m = fit.map.resolution_m();
        Err(format!(
            "speed times horizon is too long for this map's cells: {speed} m/s for {horizon_s} s with cells of {cell_m} m"
        ))
    }

    /// Whether the robot can turn on the spot by `angle` rad without touching a believed static. A disc always can.
    pub fn can_turn(&mut self, situation: &Situation<'_>, angle: f64) -> bool {
        const STEP_RAD: f64 = 0.05;
        const SLACK_M: f64 = 1e-3;
        let robot = situation.robot;
        let Some(footprint) = &robot.footprint else { return true };
        let speed = math::max(robot.speed_max_mps, robot.reverse_speed_max_mps);
        let (pitch_m, cap) = (patch::pitch_m(situation.belief.grid()), self.patch_cap(situation, speed));
        let at = self.patch.cover(situation.belief, situation.pose.position, footprint.circumradius_m(), cap);
        let steps = (angle.abs() / STEP_RAD).ceil().clamp(1.0, 1e3) as u32;
        let distance_m = |disc: &convex::Disc, axis: Vec2| {
            let centre = turned(disc.centre, axis) / pitch_m;
            let [x, y] = [centre.x as f32, centre.y as f32].map(Plain::splat);
            f64::from(positive_sqrt(self.patch.squared_distances(&at, x, y).store()[0])) * pitch_m
        };
        // The discs that cover a polygon stick out of it: one that is in contact may go on, but not deeper.
        let now = direction(situation.pose.theta);
        footprint.cover().iter().all(|disc| {
            let least_m = math::min(disc.radius_m, distance_m(disc, now) - SLACK_M);
            (1..=steps).all(|k| {
                let share = f64::from(k) / f64::from(steps);
                distance_m(disc, direction(situation.pose.theta + angle * share)) > least_m
            })
        })
    }

    /// Time predicted against statics and against movers, s.
    pub fn horizons_s(&self, robot: &Robot) -> (f64, f64) {
        (self.settings.horizon_s(robot), self.settings.movers_horizon_s(robot))
    }

    /// Forgets the map: to be called before each episode.
    pub fn reset(&mut self) {
        self.patch.reset();
    }

    /// The rollouts of this tick.
    pub fn roll(&mut self, situation: &Situation<'_>, aim: &Aim) -> &Rollouts {
        let robot = situation.robot;
        let window = Window::reachable(robot, situation.twist, situation.dt_s).capped(aim.cap_mps);
        let now = situation.twist.v;
        let always = [now, aim.speed_mps.unwrap_or(now)];
        self.settings.speed.sample(window.v_low, window.v_high, &always, &mut self.speeds);
        self.settings.yaw_rate.sample(
            window.omega_low,
            window.omega_high,
            &[0.0, situation.twist.omega],
            &mut self.yaw_rates,
        );
        self.rollouts.twists.clear();
        for &v in &self.speeds {
            // What the drive would make of the command is what is predicted.
            let twists = self.yaw_rates.iter().map(|&omega| robot.within_wheel_limits(Twist { v, omega }));
            self.rollouts.twists.extend(twists);
        }
        self.profile.clear();
        self.profile.resize(self.horizon_steps(situation), 1.0);
        self.simulate(situation, aim);
        for i in 0..self.rollouts.len() {
            if !self.rollouts.touches(i) && self.brakes_in_time(i, situation) {
                if self.rollouts.meets_movers(i) {
                    self.rollouts.doubtful.push(i as u32);
                } else {
                    self.rollouts.admissible.push(i as u32);
                }
            }
        }
        &self.rollouts
    }

    /// The rollouts of this tick once more.
    pub fn rollouts(&self) -> &Rollouts {
        &self.rollouts
    }

    /// Admits the rollouts of this tick that meet a mover when they go on but can stop before it.
    pub fn admit_stopping(&mut self, situation: &Situation<'_>) -> &Rollouts {
        let mut doubtful = core::mem::take(&mut self.rollouts.doubtful);
        if let Some(&first) = doubtful.first() {
            let pitch_m = patch::pitch_m(situation.belief.grid());
            let radius = (situation.robot.inscribed_radius_m() / pitch_m) as f32;
            let mut known = (first as usize / LANES, [false; LANES]);
            let mut is_known = false;
            for &i in &doubtful {
                let (number, lane) = (i as usize / LANES, i as usize % LANES);
                if !is_known || known.0 != number {
                    let (width, block) = (self.width, &self.blocks[number]);
                    let course = Course { width, block, parts: &self.parts, radius, cap: 0.0 };
                    known = (number, self.ahead.stop(&course, &self.discs));
                    is_known = true;
                }
                if known.1[lane] {
                    self.rollouts.admissible.push(i);
                }
            }
            self.rollouts.admissible.sort_unstable();
        }
        doubtful.clear();
        self.rollouts.doubtful = doubtful;
        &self.rollouts
    }

    /// Whether the robot could stop from rollout `i`, which touches nothing, within its `dist` (V_a).
    ///
    /// With [`BrakingDistance::Arc`] that is the arc known to be free: all of it, v·T. It bounds the speed by what
    /// was looked at (v ≤ 2 a T); it bounds the yaw rate only through the clip, for no contact is known.
    fn brakes_in_time(&self, i: usize, situation: &Situation<'_>) -> bool {
        let robot = situation.robot;
        let Twist { v, omega } = self.rollouts.twist(i);
        let clip = |distance: f64| self.settings.braking_clip_m.map_or(distance, |clip| math::min(distance, clip));
        let (ahead, around) = match self.settings.braking_distance {
            BrakingDistance::Arc => (clip(self.rollouts.free_arc_m(i)), clip(f64::INFINITY)),
            BrakingDistance::Clearance => {
                let clearance = clip(self.rollouts.clearance_m(i, DistanceMode::PathMin));
                (clearance, clearance)
            }
        };
        let turns_in_time = match self.settings.braking_turn {
            BrakingTurn::Off => true,
            BrakingTurn::Printed => omega * omega <= 2.0 * around * robot.yaw_acceleration_max_radps2,
            // ω² ≤ 2 (dist |ω|/|v|) α, multiplied out.
            BrakingTurn::Arc => (omega * v).abs() <= 2.0 * around * robot.yaw_acceleration_max_radps2,
        };
        v * v <= 2.0 * ahead * robot.deceleration_max_mps2 && turns_in_time
    }

    /// The decision for the `best` rollout of this tick; if none is admissible, the command of [`Self::recover`] towards `target`.
    pub fn decide(&mut self, best: Option<usize>, situation: &Situation<'_>, target: Vec2) -> Decision {
        let (rollouts, rollout_points) = self.simulated();
        if let Some(best) = best {
            return Decision { rollouts, rollout_points, ..Decision::track(self.rollouts.twist(best)) };
        }
        let escape = if self.looks_ahead() { self.escape(situation, target) } else { None };
        let recovery = escape.unwrap_or_else(|| self.recover(situation, target));
        Decision {
            command: recovery.command,
            state: State::RECOVER,
            rollouts: rollouts + recovery.rollouts,
            rollout_points: rollout_points + recovery.rollout_points,
            notes: Notes::NONE,
            request: None,
        }
    }

    /// Number of trajectories simulated, and number of their poses.
    fn simulated(&self) -> (u64, u64) {
        let rollouts = self.rollouts.len() as u64;
        (rollouts, rollouts * self.profile.len() as u64)
    }

    /// Control periods in the horizon: at least one.
    fn horizon_steps(&self, situation: &Situation<'_>) -> usize {
        ((self.settings.horizon_s(situation.robot) / situation.dt_s).round() as usize).max(1)
    }

    /// Control periods in the horizon for movers: not fewer than in the horizon for statics.
    fn steps_ahead(&self, situation: &Situation<'_>) -> usize {
        let steps = (self.settings.movers_horizon_s(situation.robot) / situation.dt_s).round() as usize;
        steps.max(self.horizon_steps(situation))
    }

    /// Whether admissible rollouts must leave the robot a way to stop before movers.
    fn looks_ahead(&self) -> bool {
        self.settings.normalise == Normalise::Fixed
    }

    /// Whether clearances are the exact ones of the predicted poses, as the papers' formulas have it, and no lower bounds.
    fn is_exact(&self, robot: &Robot) -> bool {
        self.settings.normalise == Normalise::Sum
            && self.settings.measure == Measure::Exact
            && robot.footprint.is_none()
    }

    /// Drives every twist of the rollouts along the speed profile and records its end, clearances and first contact.
    fn simulate(&mut self, situation: &Situation<'_>, aim: &Aim) {
        let (robot, dt_s) = (situation.robot, situation.dt_s);
        let steps = self.profile.len();
        self.rollouts.origin = situation.pose;
        self.rollouts.duration_s = steps as f64 * dt_s;
        self.rollouts.admissible.clear();
        self.rollouts.doubtful.clear();
        self.rollouts.end.clear();
        self.rollouts.free_s.clear();
        self.rollouts.statics.clear();
        self.rollouts.movers.clear();
        self.rollouts.going_on_s.clear();

        let mut speed = math::max(robot.speed_max_mps, robot.reverse_speed_max_mps);
        for twist in &self.rollouts.twists {
            speed = math::max(speed, twist.v.abs());
        }
        // Of a point of the footprint from the robot's centre now.
        let arm_m = robot.footprint.as_ref().map_or(0.0, Polygon::circumradius_m);
        let looks_ahead = self.looks_ahead();
        let meets = looks_ahead && !situation.obstacles.is_empty();
        let steps_ahead = if meets { self.steps_ahead(situation) } else { steps };
        let reach_m = speed * steps_ahead as f64 * dt_s + arm_m;
        let cap_m = self.clearance_cap_m(situation);
        let pitch_m = patch::pitch_m(situation.belief.grid());
        let cap = self.patch_cap(situation, speed);
        let at = self.patch.cover(situation.belief, situation.pose.position, reach_m, cap);

        self.fill_blocks(situation, pitch_m, aim.arrival_m);
        self.fill_discs(situation, pitch_m, reach_m, cap_m, steps_ahead);
        self.fill_parts(situation, pitch_m, &at);
        let meets = meets && !self.discs.is_empty();
        if meets {
            self.ahead.resize(steps_ahead);
        }
        self.track.resize(steps, [[0.0; LANES]; 2]);
        self.carried.resize(steps, [[0.0; LANES]; 2]);

        let (radius, room) = ((robot.inscribed_radius_m() / pitch_m) as f32, (self.settings.room_m / pitch_m) as f32);
        let near = radius + room;
        let field = Field {
            touch: touching(&self.patch, &at, [0.0; 2], near * near),
            // The nodes around a pose are up to √2 away from it.
            free: (free_m(situation) / pitch_m - f64::from(cap).sqrt() - math::SQRT_2 - ROUNDING) as f32,
            patch: &self.patch,
            at,
        };
        self.rollouts.stop_clearance_m = f64::INFINITY;
        if aim.arrival_m <= reach_m {
            let offset = (aim.stop - situation.pose.position) / pitch_m;
            let [x, y] = [offset.x as f32, offset.y as f32].map(Plain::splat);
            let gap = positive_sqrt(self.patch.squared_distances(&at, x, y).store()[0]) - radius;
            self.rollouts.stop_clearance_m = math::max(f64::from(gap) * pitch_m - BOUND_M, 0.0);
        }
        let (cap, limited) = ((cap_m / pitch_m) as f32, |gap: f32| math::clamp(f64::from(gap) * pitch_m, 0.0, cap_m));
        let count = self.rollouts.twists.len();
        let exact = self.is_exact(robot).then(|| Exact::new(situation, pitch_m, &self.settings));
        self.squares.resize(if exact.is_some() { steps } else { 0 }, [0.0; LANES]);
        for ((number, block), twists) in self.blocks.iter().enumerate().zip(self.rollouts.twists.chunks(LANES)) {
            let (mut statics, driven) = if let Some(exact) = &exact {
                rollout::follow(self.width, block, &self.profile, &mut self.track);
                rollout::squares(self.width, &field, &self.track, &mut self.squares);
                (exact.gaps(twists, &self.track, &self.squares), steps)
            } else {
                let fate = rollout::drive(self.width, block, &self.profile, &field, &mut self.track);
                let mut statics = Gaps::new(fate.free_steps);
                statics.take(&fate.least, &fate.last, radius);
                (statics, fate.driven)
            };
            let mut movers = Gaps::new(statics.free_steps);
            let track = &self.track[..driven];
            let end_at = |lane: usize| track[driven - 1].map(|axis| f64::from(axis[lane]));
            if !looks_ahead {
                let step = exact.is_none().then_some(&block.step);
                movers.pass(self.width, &self.discs, 0.0, step, track, cap);
            }
            for part in &self.parts {
                let carried = &mut self.carried[..driven];
                rollout::carry(self.width, block, part, track, carried);
                let step = part.step(block);
                let looked = rollout::look(self.width, &step, &block.arrival, part, &field, carried);
                statics.take_passing(&looked, part.radius);
                if !looks_ahead {
                    movers.pass(self.width, &self.discs, part.radius - radius, Some(&step), carried, cap);
                }
            }
            let met = if meets {
                let course = Course { width: self.width, block, parts: &self.parts, radius, cap };
                self.ahead.go_on(&course, &field, &self.discs, steps)
            } else {
                Met::NONE
            };
            if looks_ahead {
                (movers.least, movers.last) = (met.gap, met.gap);
            }
            for lane in 0..LANES.min(count - number * LANES) {
                let free = smaller(statics.free_steps[lane], movers.free_steps[lane]) as usize;
                self.rollouts.end.push(Vec2::from(end_at(lane)) * pitch_m);
                self.rollouts.free_s.push(free as f64 * dt_s);
                let clearance = |gaps: &Gaps| {
                    if free < steps {
                        Clearance::both(0.0)
                    } else {
                        Clearance { path_min_m: limited(gaps.least[lane]), end_m: limited(gaps.last[lane]) }
                    }
                };
                self.rollouts.statics.push(clearance(&statics));
                self.rollouts.movers.push(clearance(&movers));
                if looks_ahead {
                    let going_on = met.going_on[lane];
                    let going_on_s = if going_on < FAR { f64::from(going_on) * dt_s } else { f64::INFINITY };
                    self.rollouts.going_on_s.push(going_on_s);
                }
            }
        }
    }

    /// Squared distance up to which the patch is exact, in units of pitch².
    ///
    /// What the lower bounds take off (½ in the patch, s²/4 in the kernel) goes on top of the cap, with a little for rounding, so
    /// that a rollout far from everything has exactly the cap as its clearance.
    fn patch_cap(&self, situation: &Situation<'_>, speed_mps: f64) -> f32 {
        let (robot, pitch_m) = (situation.robot, patch::pitch_m(situation.belief.grid()));
        let arm_m = robot.footprint.as_ref().map_or(0.0, Polygon::circumradius_m);
        let need = (self.clearance_cap_m(situation) + robot.radius_m) / pitch_m;
        let step = (speed_mps + robot.yaw_rate_max_radps * arm_m) * situation.dt_s / pitch_m;
        (1.0001 * (need * need + 0.5 + 0.25 * step * step)) as f32
    }

    /// Distance up to which clearances matter: for scoring, and for V_a where it goes by clearance.
    fn clearance_cap_m(&self, situation: &Situation<'_>) -> f64 {
        let robot = situation.robot;
        let v = math::max(robot.speed_max_mps, robot.reverse_speed_max_mps);
        let fastest = Twist { v, omega: robot.yaw_rate_max_radps };
        math::max(self.settings.clearance_cap_m, self.settings.braking_clearance_m(robot, fastest))
    }

    /// Lays the twists out for the kernel, [`LANES`] to a block.
    fn fill_blocks(&mut self, situation: &Situation<'_>, pitch_m: f64, arrival_m: f64) {
        let (dt_s, robot) = (situation.dt_s, situation.robot);
        let zero = [0.0; LANES];
        let facing = direction(situation.pose.theta);
        let idle = Block {
            step: zero,
            heading: [zero; 2],
            turn: [zero; 2],
            lead: [zero; 2],
            used: zero,
            arrival: [FAR; LANES],
            angle: zero,
            facing: [facing.x as f32, facing.y as f32],
            stopping: zero,
            loss: zero,
        };
        self.blocks.clear();
        self.blocks.resize(self.rollouts.twists.len().div_ceil(LANES), idle);
        self.turnings.clear();
        for &omega in &self.yaw_rates {
            self.turnings.push(Turning::new(self.settings.prediction, situation.pose.theta, omega, dt_s));
        }
        for (i, &Twist { v, omega }) in self.rollouts.twists.iter().enumerate() {
            let turning = &mut self.turnings[i % self.yaw_rates.len()];
            if turning.omega != omega {
                // The wheels' limit has scaled this twist down.
                *turning = Turning::new(self.settings.prediction, situation.pose.theta, omega, dt_s);
            }
            let (block, lane) = (&mut self.blocks[i / LANES], i % LANES);
            block.used[lane] = 1.0;
            block.step[lane] = (v * dt_s * turning.length / pitch_m) as f32;
            block.heading[0][lane] = turning.first.x as f32;
            block.heading[1][lane] = turning.first.y as f32;
            block.turn[0][lane] = turning.turn.x as f32;
            block.turn[1][lane] = turning.turn.y as f32;
            block.lead[0][lane] = turning.lead.x as f32;
            block.lead[1][lane] = turning.lead.y as f32;
            block.angle[lane] = (omega * dt_s) as f32;
            let braking_mps2 = if v < 0.0 { robot.acceleration_max_mps2 } else { robot.deceleration_max_mps2 };
            let (speed, lost) = (v.abs(), braking_mps2 * dt_s);
            block.stopping[lane] = (0.5 * speed / lost) as f32;
            // All of it in one step where that takes less than a step.
            block.loss[lane] = if speed > lost { (lost / speed) as f32 } else { 1.0 };
            if v > 0.0 && arrival_m.is_finite() {
                // What a robot that cannot stop in time would touch beyond its target counts.
                let way_m = math::max(arrival_m, 0.5 * v * (v / braking_mps2 + dt_s));
                block.arrival[lane] = math::max(way_m / (v * dt_s), 1.0) as f32;
            }
        }
    }

    /// Lays out the discs covering a polygonal footprint.
    fn fill_parts(&mut self, situation: &Situation<'_>, pitch_m: f64, at: &Anchor) {
        self.parts.clear();
        let Some(footprint) = &situation.robot.footprint else { return };
        let axis = direction(situation.pose.theta);
        for disc in footprint.cover() {
            let lattice = |v: Vec2| [(v.x / pitch_m) as f32, (v.y / pitch_m) as f32];
            let radius = (disc.radius_m / pitch_m) as f32;
            let near = radius + (self.settings.room_m / pitch_m) as f32;
            let touch = touching(&self.patch, at, lattice(turned(disc.centre, axis)), near * near);
            self.parts.push(Part { centre: lattice(disc.centre), radius, touch });
        }
    }

    /// Lays out the movers that some rollout could approach to within the cap.
    fn fill_discs(&mut self, situation: &Situation<'_>, pitch_m: f64, reach_m: f64, cap_m: f64, steps: usize) {
        let (dt_s, robot) = (situation.dt_s, situation.robot);
        let horizon_s = steps as f64 * dt_s;
        self.discs.clear();
        for obstacle in situation.obstacles {
            let velocity = if self.settings.predict_dynamic { obstacle.velocity } else { Vec2::zeros() };
            let offset = obstacle.position - situation.pose.position;
            let bounce = (self.looks_ahead() && self.settings.predict_dynamic)
                .then(|| Bounce::of(obstacle, velocity, situation.belief, dt_s, steps))
                .flatten();
            let lattice = |v: Vec2| [(v.x / pitch_m) as f32, (v.y / pitch_m) as f32];
            for (centre, radius_m) in obstacle.outline.cover() {
                let (offset, touch_m) = (offset + centre, robot.inscribed_radius_m() + radius_m);
                let room_m = if self.looks_ahead() { room_m(touch_m, offset.norm()) } else { 0.0 };
                let touch_m = touch_m + room_m;
                let away_m = reach_m + velocity.norm() * horizon_s + robot.radius_m + radius_m + cap_m;
                if offset.norm() <= away_m {
                    let [touch, room] = [touch_m, room_m].map(|length_m| (length_m / pitch_m) as f32);
                    let step = lattice(velocity * dt_s);
                    self.discs.push(Disc { position: lattice(offset), step, touch, room, from: 0 });
                    if let Some(bounce) = &bounce {
                        let back = -velocity;
                        let mirrored = bounce.mirrored(velocity);
                        let differs = (mirrored - back).norm() > 0.1 * velocity.norm();
                        for after in [Some(back), differs.then_some(mirrored)].into_iter().flatten() {
                            let position = offset + bounce.moved - after * (bounce.step as f64 * dt_s);
                            let (position, step) = (lattice(position), lattice(after * dt_s));
                            self.discs.push(Disc { position, step, touch, room, from: bounce.step });
                        }
                    }
                }
            }
        }
    }
}

/// Gaps between the candidates of a block and obstacles of one kind, in units of the pitch.
struct Gaps {
    /// The least distance between surfaces over the whole rollout.
    least: Lane,
    /// The distance between surfaces at the end of the rollout.
    last: Lane,
    /// Number of steps before the first contact.
    free_steps: Lane,
}

impl Gaps {
    fn new(free_steps: Lane) -> Self {
        Self { least: [f32::MAX; LANES], last: [f32::MAX; LANES], free_steps }
    }

    /// Takes in squared distances between centres of bodies whose radii are `touch` together.
    fn take(&mut self, least: &Lane, last: &Lane, touch: f32) {
        for lane in 0..LANES {
            self.least[lane] = smaller(positive_sqrt(least[lane]) - touch, self.least[lane]);
            self.last[lane] = smaller(positive_sqrt(last[lane]) - touch, self.last[lane]);
        }
    }

    fn take_passing(&mut self, passing: &Passing, touch: f32) {
        self.take(&passing.least, &passing.last, touch);
        for lane in 0..LANES {
            self.free_steps[lane] = smaller(passing.free_steps[lane], self.free_steps[lane]);
        }
    }

    /// Drives a disc of the robot, larger than the inscribed one by `larger`, along `track` past all movers. The positions are at most
    /// `step` apart; without it what lies between them does not count.
    fn pass(&mut self, width: Width, discs: &[Disc], larger: f32, step: Option<&Lane>, track: &Track, cap: f32) {
        if discs.is_empty() {
            return;
        }
        let bounds = rollout::bounds(width, track);
        for disc in discs.iter().map(|disc| Disc { touch: disc.touch + larger, ..*disc }) {
            let between = step.map_or([0.0; LANES], |step| quarters(step, disc.step_length()));
            if !disc.keeps_off(&between, &bounds, track.len(), cap) {
                self.take_passing(&rollout::pass(width, &between, track, &disc), disc.touch);
            }
        }
    }
}

/// Distance that an admissible rollout keeps from movers, m: their prediction is no better.
const MOVERS_ROOM_M: f64 = 0.05;

/// The room to keep from a mover that touches where the centres are `touch_m` apart, m: as much of it as there is now.
fn room_m(touch_m: f64, now_m: f64) -> f64 {
    const SLACK_M: f64 = 0.01;
    math::clamp(now_m - SLACK_M - touch_m, 0.0, MOVERS_ROOM_M)
}

fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Geometry that all steps of a candidate share at one yaw rate.
#[derive(Clone, Copy, Debug)]
struct Turning {
    omega: f64,
    /// Direction of the first step.
    first: Vec2,
    /// Cosine and sine of the turn per step.
    turn: Vec2,
    /// Cosine and sine of the turn from the direction of the next step to the heading of the pose before it.
    lead: Vec2,
    /// Length of a step over v·dt.
    length: f64,
}

impl Turning {
    fn new(prediction: Prediction, theta: f64, omega: f64, dt_s: f64) -> Self {
        let turn = direction(omega * dt_s);
        match prediction {
            Prediction::Euler => Self { omega, first: direction(theta), turn, lead: Vec2::new(1.0, 0.0), length: 1.0 },
            // The chord of the arc, as in `Pose::advance`.
            Prediction::Arc => {
                let chord = Pose::new(0.0, 0.0, 0.0).advance(Twist { v: 1.0, omega: omega * dt_s }, 1.0);
                let half_turn = 0.5 * omega * dt_s;
                let (first, lead) = (direction(theta + half_turn), direction(-half_turn));
                Self { omega, first, turn, lead, length: chord.position.norm() }
            }
        }
    }
}

/// What the lower bounds of clearances take off along a rollout, m.
const BOUND_M: f64 = 0.01;

/// Bound of the accumulated rounding error of `f32` over a rollout, in units of the pitch.
const ROUNDING: f64 = 0.05;

/// Lower bound of the distance from the robot's centre to the nearest believed static, m; 0 or less at an obstacle.
fn free_m(situation: &Situation<'_>) -> f64 {
    let (grid, position) = (situation.belief.grid(), situation.pose.position);
    let cell = grid.cell_at(position);
    situation.belief.field().distance_m(cell) - (grid.centre(cell) - position).norm()
}

/// Squared distance (units of pitch²) at or below which a disc of the robot about `centre` (relative to the robot's) counts
/// as touching a static: the squared radius, or, if the disc is believed to be nearer already, slightly less than its distance.
fn touching(patch: &Patch, at: &Anchor, centre: [f32; 2], radius_squared: f32) -> f32 {
    /// Room for turning and for the first step from rest, in pitch².
    const SLACK: f32 = 1e-3;
    let [x, y] = centre.map(Plain::splat);
    let here = patch.squared_distances(at, x, y).store()[0];
    if here > 0.0 && here - SLACK < radius_squared { here - SLACK } else { radius_squared }
}

fn positive_sqrt(x: f32) -> f32 {
    if x > 0.0 { x.sqrt() } else { 0.0 }
}
