//! The kernel: many constant twists driven ahead at once, against static obstacles and movers.
//!
//! Sixteen candidates go side by side through plain arrays, which the compiler turns into vector
//! instructions on any x86-64. Lengths are `f32` in units of the lattice pitch h relative to the robot
//! (about 10 µm of rounding at 100 h); the robot's own state stays `f64`. Direction turns by a rotation
//! recurrence, so a candidate costs one sine and cosine.
//!
//! **Between the poses.** A rollout is the line through its poses, not the poses alone. Where D is the squared
//! distance to any obstacle and s the length of a step, D ≥ min(D₀, D₁) − s²/4 on the whole step (its
//! two ends at D₀ and D₁): for one obstacle point by Pythagoras, for a set as the minimum over its points. For a
//! moving disc the same holds with the length of the relative step. So s²/4 is taken off at every pose
//! (5 mm at 1 m/s and 0.25 m), and nothing is driven through between two predicted poses. The pose the robot
//! is at is not one of them: it is the same for all candidates, and one that leads away is not to blame for it.

use super::patch::{Anchor, Patch};

/// Candidates side by side.
pub(super) const LANES: usize = 16;

/// One number per candidate of a block.
pub(super) type Lane = [f32; LANES];

/// What a block of candidates drives. Lengths in units of the pitch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// Signed length of a full-speed step.
    pub(super) step: Lane,
    /// Direction of the first step.
    pub(super) heading: [Lane; 2],
    /// Cosine and sine of the turn per step.
    pub(super) turn: [Lane; 2],
    /// 1 for a candidate, 0 for a lane without one.
    pub(super) used: Lane,
}

/// What became of a block. Squared distances are lower bounds, in units of pitch².
#[derive(Clone, Copy, Debug)]
pub(super) struct Fate {
    /// Position after the last step, relative to the start.
    pub(super) end: [Lane; 2],
    /// Squared distance to the statics over the whole rollout.
    pub(super) least: Lane,
    /// Squared distance to the statics at the last pose.
    pub(super) last: Lane,
    /// Steps driven before the first one that touches a static; all of them where none does.
    pub(super) free_steps: Lane,
    /// Steps after which the rollout was broken off because every candidate of the block had touched
    /// something; the rest means nothing then. All steps where it was not.
    pub(super) driven: usize,
}

/// Positions of a block after each step, for the movers' pass.
pub(super) type Track = [[Lane; 2]];

/// Drives `block` through the statics; step k has length `step · speed[k]`. Touching means a squared
/// distance of at most `touch`.
pub(super) fn drive(block: &Block, speed: &[f32], touch: f32, patch: &Patch, at: &Anchor, track: &mut Track) -> Fate {
    assert_eq!(speed.len(), track.len(), "one position per step");
    let (mut x, mut y) = ([0.0; LANES], [0.0; LANES]);
    let [mut cos, mut sin] = block.heading;
    let mut least = [f32::MAX; LANES];
    let mut last = [f32::MAX; LANES];
    let mut free_steps = [0.0; LANES];
    let mut driven = 0;
    for (position, &speed) in track.iter_mut().zip(speed) {
        for lane in 0..LANES {
            let step = block.step[lane] * speed;
            x[lane] += step * cos[lane];
            y[lane] += step * sin[lane];
            let (c, s) = (cos[lane], sin[lane]);
            cos[lane] = c * block.turn[0][lane] - s * block.turn[1][lane];
            sin[lane] = s * block.turn[0][lane] + c * block.turn[1][lane];
        }
        *position = [x, y];
        driven += 1;
        last = patch.squared_distances(at, &x, &y);
        let mut free = 0.0;
        for lane in 0..LANES {
            let half_step = 0.5 * block.step[lane] * speed;
            last[lane] -= half_step * half_step;
            least[lane] = if last[lane] < least[lane] { last[lane] } else { least[lane] };
            let alive = if least[lane] > touch { block.used[lane] } else { 0.0 };
            free_steps[lane] += alive;
            free += alive;
        }
        if free == 0.0 {
            break;
        }
    }
    Fate { end: [x, y], least, last, free_steps, driven }
}

/// A mover as the kernel sees it, relative to the robot, in units of the pitch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    /// Where it is at the start.
    pub(super) position: [f32; 2],
    /// How far it moves per step; 0 for a mover that is taken to stand still.
    pub(super) step: [f32; 2],
    /// Its radius plus the robot's.
    pub(super) touch: f32,
}

/// Distances of a block to one moving disc: squared, from centre to centre, as in [`Fate`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Passing {
    /// Over the whole rollout.
    pub(super) least: Lane,
    /// At the last pose.
    pub(super) last: Lane,
    /// Steps before the first one that touches.
    pub(super) free_steps: Lane,
}

/// Drives the positions of `track` past a disc that moves at constant velocity. Both may be cut short.
pub(super) fn pass(block: &Block, speed: &[f32], track: &Track, disc: &Disc) -> Passing {
    let mut least = [f32::MAX; LANES];
    let mut last = [f32::MAX; LANES];
    let mut free_steps = [0.0; LANES];
    let disc_step = (disc.step[0] * disc.step[0] + disc.step[1] * disc.step[1]).sqrt();
    let touch = disc.touch * disc.touch;
    let [mut disc_x, mut disc_y] = disc.position;
    for ([x, y], &speed) in track.iter().zip(speed) {
        disc_x += disc.step[0];
        disc_y += disc.step[1];
        for lane in 0..LANES {
            let (dx, dy) = (x[lane] - disc_x, y[lane] - disc_y);
            // At most the relative step: the two lengths added.
            let half_step = 0.5 * ((block.step[lane] * speed).abs() + disc_step);
            last[lane] = dx * dx + dy * dy - half_step * half_step;
            least[lane] = if last[lane] < least[lane] { last[lane] } else { least[lane] };
            free_steps[lane] += if least[lane] > touch { 1.0 } else { 0.0 };
        }
    }
    Passing { least, last, free_steps }
}
