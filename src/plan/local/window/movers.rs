//! How the rollouts meet the movers, with fixed scales.
//!
//! A robot that only tests whether it would touch a mover with the twist of this moment either looks too short a time ahead or
//! shuns whatever the twist would touch long after it has been given up. Two ways to go on are tested over the horizon for
//! movers:
//!
//! - *Going on*: the twist, then braking along its arc so that the robot comes to rest before the first static or at its
//!   target, then standing. A rollout that bends into a rack ends beside the rack and not out of the movers' reach.
//! - *Stopping*: the twist for one control period, then braking along its arc, then standing (passive safety: Bouraine,
//!   Fraichard, Salhi, "Provably safe navigation for mobile robots with limited field-of-views in dynamic environments",
//!   Autonomous Robots 32, 2012).
//!
//! A rollout is admissible if going on touches no mover, each at constant velocity; where nothing that leads anywhere is, also if
//! stopping touches none. A mover whose way leads into a believed static cannot keep its velocity: from there on it is expected on
//! three ways at once, straight on, mirrored and back.

use super::lanes::{LANES, Lane, Width};
use super::rollout::{self, Block, Bounds, Braking, Disc, FAR, Field, Part, quarters};
use super::{Gaps, smaller};
use crate::geometry::Vec2;
use crate::map::Cell;
use crate::math;
use crate::observation::{Belief, SensedObstacle};

/// A block of candidates among statics.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course<'a> {
    pub(super) width: Width,
    pub(super) block: &'a Block,
    pub(super) parts: &'a [Part],
    /// Radius of the robot's inscribed disc, in units of the pitch.
    pub(super) radius: f32,
    /// Clearance up to which movers count, in units of the pitch.
    pub(super) cap: f32,
}

impl Course<'_> {
    /// Whether a mover may come within the cap of a candidate that keeps within `bounds` for `steps` steps.
    fn is_near(&self, disc: &Disc, bounds: &Bounds, steps: usize) -> bool {
        let widest = self.parts.iter().map(Part::reach).fold(self.radius, |a, b| if a > b { a } else { b });
        let disc = Disc { touch: disc.touch + widest - self.radius, ..*disc };
        !disc.keeps_off(&quarters(&self.block.step, disc.step_length()), bounds, steps, self.cap)
    }
}

/// How the candidates of a block meet the movers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    /// Steps before the first contact when going on; [`FAR`] if there is none.
    pub(super) going_on: Lane,
    /// Least gap when going on, in units of the pitch.
    pub(super) gap: Lane,
}

impl Met {
    /// No mover is near.
    pub(super) const NONE: Self = Self { going_on: [FAR; LANES], gap: [FAR; LANES] };
}

/// Drives blocks on beyond the horizon for statics; keeps its memory.
#[derive(Clone, Debug, Default)]
pub(super) struct Ahead {
    pub(super) track: Vec<[Lane; 2]>,
    pub(super) headings: Vec<[Lane; 2]>,
    pub(super) carried: Vec<[Lane; 2]>,
}

impl Ahead {
    /// Makes room for a number of steps.
    pub(super) fn resize(&mut self, steps: usize) {
        for track in [&mut self.track, &mut self.headings, &mut self.carried] {
            track.resize(steps, [[0.0; LANES]; 2]);
        }
    }

    /// How the candidates of a block that touch no static in the first `looked_at` steps meet the movers when they go on.
    pub(super) fn go_on(&mut self, course: &Course<'_>, field: &Field<'_>, discs: &[Disc], looked_at: usize) -> Met {
        let Course { width, block, .. } = *course;
        let steps = self.track.len();
        if course.parts.is_empty() {
            rollout::coast(width, block, &mut self.track);
        } else {
            rollout::glide(width, block, &Braking::NEVER, &mut self.track, &mut self.headings);
        }
        let bounds = rollout::bounds(width, &self.track);
        if !discs.iter().any(|disc| course.is_near(disc, &bounds, steps)) {
            return Met::NONE;
        }
        let free = self.free_of_statics(course, field, looked_at);
        let mut braking = Braking { start: [FAR; LANES], loss: block.loss };
        let mut brakes = false;
        for (lane, &free) in free.iter().enumerate() {
            let before_static = if (free as usize) < steps { free - 1.0 } else { FAR };
            let start = smaller(before_static, block.arrival[lane]) - block.stopping[lane];
            braking.start[lane] = if start > 0.0 { start } else { 0.0 };
            brakes |= start < steps as f32;
        }
        if brakes {
            rollout::glide(width, block, &braking, &mut self.track, &mut self.headings);
        }
        let gaps = self.pass(course, discs, &bounds);
        let contact = gaps.free_steps.map(|free| if (free as usize) < steps { free } else { FAR });
        Met { going_on: contact, gap: gaps.least }
    }

    /// Which candidates of a block touch no mover when they stop.
    pub(super) fn stop(&mut self, course: &Course<'_>, discs: &[Disc]) -> [bool; LANES] {
        let Course { width, block, .. } = *course;
        let at_once = Braking { start: [1.0; LANES], loss: block.loss };
        rollout::glide(width, block, &at_once, &mut self.track, &mut self.headings);
        let bounds = rollout::bounds(width, &self.track);
        let steps = self.track.len();
        self.pass(course, discs, &bounds).free_steps.map(|free| free as usize >= steps)
    }

    /// Steps before the first contact with a static, on the track at hand.
    fn free_of_statics(&mut self, course: &Course<'_>, field: &Field<'_>, looked_at: usize) -> Lane {
        let Course { width, block, .. } = *course;
        let longest =
            block.step.iter().fold(0.0, |longest, step| if step.abs() > longest { step.abs() } else { longest });
        if course.parts.is_empty() && longest * self.track.len() as f32 <= field.free {
            return [self.track.len() as f32; LANES];
        }
        let arrival = block.arrival.map(|steps| steps - looked_at as f32);
        let disc = Part { centre: [0.0; 2], radius: course.radius, touch: field.touch };
        let beyond = &self.track[looked_at..];
        let mut free = rollout::look(width, &block.step, &arrival, &disc, field, beyond).free_steps;
        for part in course.parts {
            let carried = &mut self.carried[looked_at..];
            rollout::carry_turned(width, &self.headings[looked_at..], part, beyond, carried);
            let looked = rollout::look(width, &part.step(block), &arrival, part, field, carried);
            for (free, looked) in free.iter_mut().zip(looked.free_steps) {
                *free = smaller(looked, *free);
            }
        }
        free.map(|steps| steps + looked_at as f32)
    }

    /// Passes the movers on the track at hand.
    fn pass(&mut self, course: &Course<'_>, discs: &[Disc], bounds: &Bounds) -> Gaps {
        let Course { width, block, radius, .. } = *course;
        let steps = self.track.len();
        let is_near = |disc: &&Disc| course.is_near(disc, bounds, steps);
        let mut gaps = Gaps::new([self.track.len() as f32; LANES]);
        for disc in discs.iter().filter(is_near) {
            gaps.take_passing(
                &rollout::pass(width, &quarters(&block.step, disc.step_length()), &self.track, disc),
                disc.touch,
            );
        }
        for part in course.parts {
            rollout::carry_turned(width, &self.headings, part, &self.track, &mut self.carried);
            let step = part.step(block);
            for disc in discs.iter().filter(is_near) {
                let disc = Disc { touch: disc.touch + part.radius - radius, ..*disc };
                gaps.take_passing(
                    &rollout::pass(width, &quarters(&step, disc.step_length()), &self.carried, &disc),
                    disc.touch,
                );
            }
        }
        gaps
    }
}

/// Where the way of a mover leads into a believed static.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounce {
    /// Steps before.
    pub(super) step: usize,
    /// Displacement of the mover until then, m.
    pub(super) moved: Vec2,
    /// Unit vector from the static to the mover.
    normal: Vec2,
}

impl Bounce {
    /// The first one within `steps` of `dt_s`; `None` where there is none, or the mover is in contact already.
    pub(super) fn of(mover: &SensedObstacle, velocity: Vec2, belief: &Belief, dt_s: f64, steps: usize) -> Option<Self> {
        let radius_m = mover.radius_m();
        for step in 0..=steps {
            let moved = velocity * (step as f64 * dt_s);
            if let Some(away) = nearest_static(belief, mover.position + moved, radius_m) {
                let distance_m = away.norm();
                if step == 0 && away.dot(&velocity) >= 0.0 {
                    continue;
                }
                return (step > 0 && distance_m > 0.0 && away.dot(&velocity) < 0.0).then(|| Self {
                    step,
                    moved,
                    normal: away / distance_m,
                });
            }
        }
        None
    }

    /// The velocity after it, mirrored.
    pub(super) fn mirrored(&self, velocity: Vec2) -> Vec2 {
        velocity - self.normal * (2.0 * velocity.dot(&self.normal))
    }
}

/// From the nearest point of a believed static or the edge of the map, if it is nearer than `radius_m`, to `p`.
fn nearest_static(belief: &Belief, p: Vec2, radius_m: f64) -> Option<Vec2> {
    let grid = belief.grid();
    let (extent, cell) = (grid.extent_m(), grid.cell_at(p));
    if grid.contains(cell) {
        let here_m = belief.field().distance_m(cell) - (grid.centre(cell) - p).norm();
        if here_m > radius_m {
            return None;
        }
    }
    let mut nearest = Vec2::new(radius_m, 0.0);
    let mut is_near = false;
    let mut take = |away: Vec2| {
        if away.norm_squared() < nearest.norm_squared() {
            (nearest, is_near) = (away, true);
        }
    };
    take(Vec2::new(p.x, 0.0));
    take(Vec2::new(0.0, p.y));
    take(Vec2::new(p.x - extent.x, 0.0));
    take(Vec2::new(0.0, p.y - extent.y));
    let (first, last) = (grid.cell_at(p - Vec2::repeat(radius_m)), grid.cell_at(p + Vec2::repeat(radius_m)));
    for row in first.row.max(0)..=last.row.min(grid.rows() - 1) {
        for col in first.col.max(0)..=last.col.min(grid.cols() - 1) {
            let cell = Cell { col, row };
            if !grid.is_free(cell) {
                let square = grid.square(cell);
                let x = math::clamp(p.x, square.min.x, square.max.x);
                let y = math::clamp(p.y, square.min.y, square.max.y);
                take(p - Vec2::new(x, y));
            }
        }
    }
    is_near.then_some(nearest)
}
