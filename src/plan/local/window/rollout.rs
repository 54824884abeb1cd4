//! The kernel: many constant twists driven ahead at once, against static obstacles and movers.
//!
//! Eight candidates go side by side ([`Lanes`]). Lengths are `f32` in units of the lattice pitch h relative to the robot
//! (about 10 µm of rounding at 100 h); the robot's own state stays `f64`. Direction turns by a rotation
//! recurrence, so a candidate costs one sine and cosine.
//!
//! **Between the poses.** A rollout is the line through its poses, not the poses alone. Where D is the squared
//! distance to any obstacle and s the length of a step, D ≥ min(D₀, D₁) − s²/4 on the whole step (its
//! two ends at D₀ and D₁): for one obstacle point by Pythagoras, for a set as the minimum over its points. For a
//! moving disc the same holds with the length of the relative step. So s²/4 is taken off at every pose
//! (5 mm at 1 m/s and 0.25 m; the longest step of the rollout stands for all), and nothing is driven through between two predicted poses. The pose the robot
//! is at is not one of them: it is the same for all candidates, and one that leads away is not to blame for it.
//!
//! **What is left out.** Clearances count up to a cap. Poses that are too near to the robot to come within the cap of any
//! static ([`Field::free`]) are not looked up, and a mover whose way keeps beyond it from the box around a block's poses is
//! not measured. Both leave the numbers as they are, which end at the cap either way.

use super::lanes::{LANES, Lane, Lanes, on_lanes};
use super::patch::{Anchor, Patch};

/// The motion of a block of candidates. Lengths in units of the pitch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// Signed length of a full-speed step.
    pub(super) step: Lane,
    /// Direction of the first step.
    pub(super) heading: [Lane; 2],
    /// Cosine and sine of the turn per step.
    pub(super) turn: [Lane; 2],
    /// Cosine and sine of the turn from the direction of the step that follows a pose to the robot's heading there.
    pub(super) lead: [Lane; 2],
    /// 1 for a candidate, 0 for a lane without one.
    pub(super) used: Lane,
    /// Steps until the candidate is to stand at its target; what it would touch later does not count.
    pub(super) arrival: Lane,
    /// Turn per step, rad.
    pub(super) angle: Lane,
    /// Direction in which the robot faces now.
    pub(super) facing: [f32; 2],
    /// Way that braking to rest takes, in steps at full speed.
    pub(super) stopping: Lane,
    /// Share of the full speed that braking takes off in a step.
    pub(super) loss: Lane,
}

/// A disc of a footprint that is no disc: fixed to the robot beside its centre. Lengths in units of the pitch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Centre in the robot's frame.
    pub(super) centre: [f32; 2],
    /// Radius.
    pub(super) radius: f32,
    /// Squared distance at or below which it touches a static.
    pub(super) touch: f32,
}

impl Part {
    /// Distance of its farthest point from the robot's centre.
    pub(super) fn reach(&self) -> f32 {
        let [x, y] = self.centre;
        (x * x + y * y).sqrt() + self.radius
    }

    /// Upper bound of its displacement per step: with the robot, and as the robot turns.
    pub(super) fn step(&self, block: &Block) -> Lane {
        let [x, y] = self.centre;
        let away = (x * x + y * y).sqrt();
        let mut step = block.step;
        for ((step, cos), sin) in step.iter_mut().zip(block.turn[0]).zip(block.turn[1]) {
            *step = step.abs() + away * ((cos - 1.0) * (cos - 1.0) + sin * sin).sqrt();
        }
        step
    }
}

/// The statics around the robot's current position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field<'a> {
    pub(super) patch: &'a Patch,
    pub(super) at: Anchor,
    /// Squared distance at or below which a pose touches.
    pub(super) touch: f32,
    /// Distance from the robot up to which every pose has the cap of the patch as its clearance.
    pub(super) free: f32,
}

/// Result of a block. Squared distances are lower bounds, in units of pitch².
#[derive(Clone, Copy, Debug)]
pub(super) struct Fate {
    /// Squared distance to the statics over the whole rollout.
    pub(super) least: Lane,
    /// Squared distance to the statics at the last pose.
    pub(super) last: Lane,
    /// Steps driven before the first one that touches a static; all steps if none does.
    pub(super) free_steps: Lane,
    /// Steps after which the rollout was broken off because every candidate of the block had touched
    /// something, in which case positions beyond are meaningless; all steps if it was not broken off.
    pub(super) driven: usize,
}

/// Positions of a block after each step, for the movers' pass.
pub(super) type Track = [[Lane; 2]];

on_lanes! {
    /// Drives `block` through the statics; step k has length `step · speed[k]`.
    pub(super) fn drive(block: &Block, speed: &[f32], field: &Field<'_>, track: &mut Track) -> Fate = drive_lanes;
}

#[inline(always)]
fn drive_lanes<L: Lanes>(block: &Block, speed: &[f32], field: &Field<'_>, track: &mut Track) -> Fate {
    assert_eq!(speed.len(), track.len(), "one position per step");
    let mut motion = Motion::<L>::of(block);
    let longest = block.step.iter().fold(0.0, |longest, step| if step.abs() > longest { step.abs() } else { longest });
    // A cast saturates: all steps where the block does not move.
    let unseen = ((field.free / longest) as usize).min(speed.len());
    let (near_track, track) = track.split_at_mut(unseen);
    let (near_speed, speed) = speed.split_at(unseen);
    for (position, &speed) in near_track.iter_mut().zip(near_speed) {
        *position = motion.advance(speed);
    }

    let used = L::load(&block.used);
    let between = L::load(&quarters(&block.step, 0.0));
    let limit = L::splat(field.touch) + between;
    let (mut least, mut last) = (L::splat(f32::MAX), L::splat(f32::MAX));
    let mut free_steps = L::splat(unseen as f32) * used;
    let mut driven = unseen;
    let arrival = L::load(&block.arrival);
    for (position, &speed) in track.iter_mut().zip(speed) {
        *position = motion.advance(speed);
        driven += 1;
        let arrived = L::splat(driven as f32).where_above(arrival, L::splat(FAR));
        last = field.patch.squared_distances(&field.at, motion.x, motion.y) + arrived;
        least = last.min(least);
        let free = least.where_above(limit, used);
        free_steps = free_steps + free;
        if !free.any() {
            break;
        }
    }
    Fate { least: (least - between).store(), last: (last - between).store(), free_steps: free_steps.store(), driven }
}

on_lanes! {
    /// Positions of a block that meets nothing; step k has length `step · speed[k]`.
    pub(super) fn follow(block: &Block, speed: &[f32], track: &mut Track) -> () = follow_lanes;
}

#[inline(always)]
fn follow_lanes<L: Lanes>(block: &Block, speed: &[f32], track: &mut Track) {
    let mut motion = Motion::<L>::of(block);
    for (position, &speed) in track.iter_mut().zip(speed) {
        *position = motion.advance(speed);
    }
}

on_lanes! {
    /// Squared distances of the positions of `track` to the statics, lower bounds.
    pub(super) fn squares(field: &Field<'_>, track: &Track, squares: &mut [Lane]) -> () = squares_lanes;
}

#[inline(always)]
fn squares_lanes<L: Lanes>(field: &Field<'_>, track: &Track, squares: &mut [Lane]) {
    for ([x, y], square) in track.iter().zip(squares) {
        *square = field.patch.squared_distances(&field.at, L::load(x), L::load(y)).store();
    }
}

/// A squared distance that counts as none at all.
pub(super) const FAR: f32 = 1e30;

/// Where the candidates of a block begin to brake.
#[derive(Clone, Copy, Debug)]
pub(super) struct Braking {
    /// Steps driven before; [`FAR`] and more for never.
    pub(super) start: Lane,
    /// Share of the full speed lost in each step.
    pub(super) loss: Lane,
}

impl Braking {
    /// Goes on at full speed.
    pub(super) const NEVER: Self = Self { start: [FAR; LANES], loss: [0.0; LANES] };
}

on_lanes! {
    /// Positions of a block that goes on at full speed.
    pub(super) fn coast(block: &Block, track: &mut Track) -> () = coast_lanes;
}

#[inline(always)]
fn coast_lanes<L: Lanes>(block: &Block, track: &mut Track) {
    let mut motion = Motion::<L>::of(block);
    for position in track {
        *position = motion.advance(1.0);
    }
}

on_lanes! {
    /// Positions of a block that brakes to rest along its arcs, and its headings.
    pub(super) fn glide(block: &Block, braking: &Braking, track: &mut Track, headings: &mut Track) -> () = glide_lanes;
}

#[inline(always)]
fn glide_lanes<L: Lanes>(block: &Block, braking: &Braking, track: &mut Track, headings: &mut Track) {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let (step, angle) = (L::load(&block.step), L::splat(0.5) * L::load(&block.angle));
    let (start, loss) = (L::load(&braking.start), L::load(&braking.loss));
    let [mut cos, mut sin] = block.facing.map(L::splat);
    let (mut x, mut y) = (zero, zero);
    let mut middle = L::splat(0.5);
    for (position, heading) in track.iter_mut().zip(headings) {
        // The mean over the step of the share of the full speed.
        let lost = zero - (start - middle).min(zero);
        let share = one - (loss * lost).min(one);
        middle = middle + one;
        // Half of the turn, the step, the other half. Sine and cosine by their series: the angles are small.
        let a = angle * share;
        let square = a * a;
        let c = one - square * (L::splat(1.0 / 2.0) - square * L::splat(1.0 / 24.0));
        let s = a * (one - square * (L::splat(1.0 / 6.0) - square * L::splat(1.0 / 120.0)));
        let half = |cos: L, sin: L| (cos * c - sin * s, sin * c + cos * s);
        (cos, sin) = half(cos, sin);
        x = x + step * share * cos;
        y = y + step * share * sin;
        (cos, sin) = half(cos, sin);
        *position = [x.store(), y.store()];
        *heading = [cos.store(), sin.store()];
    }
}

on_lanes! {
    /// Positions of the centre of `part` when the robot is at the positions of `track` with `headings`.
    pub(super) fn carry_turned(headings: &Track, part: &Part, track: &Track, carried: &mut Track) -> () = carry_turned_lanes;
}

#[inline(always)]
fn carry_turned_lanes<L: Lanes>(headings: &Track, part: &Part, track: &Track, carried: &mut Track) {
    let [arm_x, arm_y] = part.centre.map(L::splat);
    for (([x, y], [cos, sin]), carried) in track.iter().zip(headings).zip(carried) {
        let (cos, sin) = (L::load(cos), L::load(sin));
        *carried =
            [(L::load(x) + (cos * arm_x - sin * arm_y)).store(), (L::load(y) + (sin * arm_x + cos * arm_y)).store()];
    }
}

on_lanes! {
    /// Positions of the centre of `part` when the robot is at the positions of `track`.
    pub(super) fn carry(block: &Block, part: &Part, track: &Track, carried: &mut Track) -> () = carry_lanes;
}

#[inline(always)]
fn carry_lanes<L: Lanes>(block: &Block, part: &Part, track: &Track, carried: &mut Track) {
    let mut motion = Motion::<L>::of(block);
    let [x, y] = part.centre.map(L::splat);
    let [cos, sin] = [L::load(&block.lead[0]), L::load(&block.lead[1])];
    let arm = [cos * x - sin * y, sin * x + cos * y];
    for ([x, y], carried) in track.iter().zip(carried) {
        motion.advance(0.0);
        let (cos, sin) = (motion.cos, motion.sin);
        *carried = [
            (L::load(x) + (cos * arm[0] - sin * arm[1])).store(),
            (L::load(y) + (sin * arm[0] + cos * arm[1])).store(),
        ];
    }
}

on_lanes! {
    /// Distances of the positions of `track`, which are at most `step` apart, to the statics, up to `arrival`. Contact is judged for
    /// `part`.
    pub(super) fn look(step: &Lane, arrival: &Lane, part: &Part, field: &Field<'_>, track: &Track) -> Passing = look_lanes;
}

#[inline(always)]
fn look_lanes<L: Lanes>(step: &Lane, arrival: &Lane, part: &Part, field: &Field<'_>, track: &Track) -> Passing {
    let between = L::load(&quarters(step, 0.0));
    let arrival = L::load(arrival);
    let limit = L::splat(part.touch) + between;
    let one = L::splat(1.0);
    let (mut least, mut last) = (L::splat(f32::MAX), L::splat(f32::MAX));
    let mut free_steps = L::splat(0.0);
    for (number, [x, y]) in track.iter().enumerate() {
        let arrived = L::splat((number + 1) as f32).where_above(arrival, L::splat(FAR));
        last = field.patch.squared_distances(&field.at, L::load(x), L::load(y)) + arrived;
        least = last.min(least);
        free_steps = free_steps + least.where_above(limit, one);
    }
    Passing { least: (least - between).store(), last: (last - between).store(), free_steps: free_steps.store() }
}

/// Positions and headings of the candidates of a block.
#[derive(Clone, Copy)]
struct Motion<L> {
    step: L,
    turn: [L; 2],
    x: L,
    y: L,
    cos: L,
    sin: L,
}

impl<L: Lanes> Motion<L> {
    #[inline(always)]
    fn of(block: &Block) -> Self {
        let zero = L::splat(0.0);
        let Block { step, heading: [cos, sin], turn: [turn_cos, turn_sin], .. } = block;
        Self {
            step: L::load(step),
            turn: [L::load(turn_cos), L::load(turn_sin)],
            x: zero,
            y: zero,
            cos: L::load(cos),
            sin: L::load(sin),
        }
    }

    /// One step at this share of the full speed; returns the positions after it.
    #[inline(always)]
    fn advance(&mut self, speed: f32) -> [Lane; 2] {
        let Self { cos, sin, turn: [turn_cos, turn_sin], .. } = *self;
        let step = self.step * L::splat(speed);
        self.x = self.x + step * cos;
        self.y = self.y + step * sin;
        (self.cos, self.sin) = (cos * turn_cos - sin * turn_sin, sin * turn_cos + cos * turn_sin);
        [self.x.store(), self.y.store()]
    }
}

/// A mover as the kernel sees it, relative to the robot, in units of the pitch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    /// Position at the start.
    pub(super) position: [f32; 2],
    /// Displacement per step; 0 for a mover that is taken to stand still.
    pub(super) step: [f32; 2],
    /// Its radius plus the robot's, and the room.
    pub(super) touch: f32,
    /// The room that admissible rollouts keep.
    pub(super) room: f32,
    /// Steps before it counts.
    pub(super) from: usize,
}

/// Distances of a block to the statics or to one moving disc: squared, from centre to centre, as in [`Fate`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Passing {
    /// Over the whole rollout.
    pub(super) least: Lane,
    /// At the last pose.
    pub(super) last: Lane,
    /// Steps before the first one that touches.
    pub(super) free_steps: Lane,
}

on_lanes! {
    /// Drives the positions of `track` past a disc that moves at constant velocity. `between` is what the squared distances lose between
    /// the positions ([`quarters`]); 0 if these alone count.
    pub(super) fn pass(between: &Lane, track: &Track, disc: &Disc) -> Passing = pass_lanes;
}

#[inline(always)]
fn pass_lanes<L: Lanes>(between: &Lane, track: &Track, disc: &Disc) -> Passing {
    let between = L::load(between);
    let limit = L::splat(disc.touch * disc.touch) + between;
    let one = L::splat(1.0);
    let (mut least, mut last) = (L::splat(f32::MAX), L::splat(f32::MAX));
    let from = disc.from.min(track.len());
    let mut free_steps = L::splat(from as f32);
    let [mut disc_x, mut disc_y] = disc.position;
    disc_x += from as f32 * disc.step[0];
    disc_y += from as f32 * disc.step[1];
    for [x, y] in &track[from..] {
        disc_x += disc.step[0];
        disc_y += disc.step[1];
        let (dx, dy) = (L::load(x) - L::splat(disc_x), L::load(y) - L::splat(disc_y));
        last = dx * dx + dy * dy;
        least = last.min(least);
        free_steps = free_steps + least.where_above(limit, one);
    }
    Passing { least: (least - between).store(), last: (last - between).store(), free_steps: free_steps.store() }
}

impl Disc {
    pub(super) fn step_length(&self) -> f32 {
        (self.step[0] * self.step[0] + self.step[1] * self.step[1]).sqrt()
    }

    /// Whether the disc keeps `cap` or more from the robot at every pose in `bounds` over `steps` steps, so that it
    /// need not be measured. `between` is as in [`pass`].
    pub(super) fn keeps_off(&self, between: &Lane, bounds: &Bounds, steps: usize, cap: f32) -> bool {
        /// Bound of the accumulated rounding error, in units of the pitch.
        const SLACK: f32 = 0.05;
        let gap = |axis: usize| {
            let from = self.position[axis] + self.step[axis];
            let to = self.position[axis] + steps as f32 * self.step[axis];
            let (low, high) = if from < to { (from, to) } else { (to, from) };
            let outside = [low - bounds.high[axis], bounds.low[axis] - high, 0.0];
            outside.into_iter().fold(0.0, |gap, side| if side > gap { side } else { gap })
        };
        let (x, y) = (gap(0), gap(1));
        let between = between.iter().fold(0.0, |a, &b| if b > a { b } else { a });
        let wanted = 1.001 * (self.touch + cap) + SLACK;
        x * x + y * y > wanted * wanted + between
    }
}

/// The box around the poses of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    low: [f32; 2],
    high: [f32; 2],
}

on_lanes! {
    /// The box around the positions of a track.
    pub(super) fn bounds(track: &Track) -> Bounds = bounds_lanes;
}

#[inline(always)]
fn bounds_lanes<L: Lanes>(track: &Track) -> Bounds {
    let far = L::splat(f32::MAX);
    let zero = L::splat(0.0);
    let (mut low, mut minus_high) = ([far; 2], [far; 2]);
    for position in track {
        for axis in [0, 1] {
            let at = L::load(&position[axis]);
            low[axis] = at.min(low[axis]);
            minus_high[axis] = (zero - at).min(minus_high[axis]);
        }
    }
    let smallest = |lanes: L| lanes.store().into_iter().fold(f32::MAX, |a, b| if b < a { b } else { a });
    Bounds { low: low.map(smallest), high: minus_high.map(|lanes| -smallest(lanes)) }
}

/// s²/4 of steps that are `longer` than those of the block.
#[inline(always)]
pub(super) fn quarters(step: &Lane, longer: f32) -> Lane {
    let mut quarters = [0.0; LANES];
    for lane in 0..LANES {
        let half = 0.5 * (step[lane].abs() + longer);
        quarters[lane] = half * half;
    }
    quarters
}
