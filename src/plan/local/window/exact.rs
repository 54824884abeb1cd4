//! The exact clearances of a rollout's predicted poses, as the papers' objective has them.
//!
//! With [`Normalise::Sum`](super::Normalise) each term is divided by its sum over the candidates, whose clearances differ by
//! centimetres: a lower bound that is a few millimetres below the truth, and more or less so from one candidate to the next, picks other
//! candidates than the formula does. So the bound of the patch only says which poses may be the nearest ones to an obstacle;
//! their distances are those to the obstacle squares. What lies between two poses does not count, as in the formula.

use super::lanes::{LANES, Lane};
use super::rollout::Track;
use super::{DistanceMode, Gaps, Settings, positive_sqrt};
use crate::geometry::{Twist, Vec2};
use crate::math;
use crate::plan::clearance::Obstacles;
use crate::plan::contract::Situation;
use crate::robot::Robot;

/// Rounding of a bound of the patch, in units of the pitch.
const ROUNDING: f64 = 1e-3;

/// A robot that believes itself in contact may not come nearer than it is, by this, m.
const SLACK_M: f64 = 1e-6;

/// Exact distances from the centre of a disc to the believed statics.
pub(super) struct Exact<'a> {
    obstacles: Obstacles<'a>,
    origin: Vec2,
    pitch_m: f64,
    radius_m: f64,
    /// Distance of the centre at or below which a pose touches, m.
    touch_m: f64,
    robot: &'a Robot,
    settings: &'a Settings,
}

impl<'a> Exact<'a> {
    pub(super) fn new(situation: &'a Situation<'_>, pitch_m: f64, settings: &'a Settings) -> Self {
        let (belief, radius_m) = (situation.belief, situation.robot.radius_m);
        let obstacles = Obstacles::new(belief.grid(), belief.field());
        let origin = situation.pose.position;
        let near_m = radius_m + settings.room_m;
        let here_m = obstacles.clearance(origin, near_m);
        let touch_m = if here_m > 0.0 { math::min(here_m - SLACK_M, near_m) } else { near_m };
        Self { obstacles, origin, pitch_m, radius_m, touch_m, robot: situation.robot, settings }
    }

    /// Distance of the centre above which a pose of a candidate is no better, m: the objective counts no more, and it is enough to brake.
    fn limit_m(&self, twist: Twist) -> f64 {
        let needed_m = (1.0 + ROUNDING) * self.settings.braking_clearance_m(self.robot, twist);
        self.radius_m + math::max(math::max(self.settings.clearance_cap_m, self.settings.room_m), needed_m)
    }

    /// The gaps of the candidates of a block, [`LANES`] at most; `squares` are lower bounds of the squared distances, in units of pitch².
    pub(super) fn gaps(&self, twists: &[Twist], track: &Track, squares: &[Lane]) -> Gaps {
        let mut gaps = Gaps::new([0.0; LANES]);
        for (lane, &twist) in twists.iter().enumerate() {
            let limit_m = self.limit_m(twist);
            let at = |k: usize| {
                let [x, y] = track[k];
                self.origin + Vec2::new(f64::from(x[lane]), f64::from(y[lane])) * self.pitch_m
            };
            // The squared bound below which a pose may be nearer than `distance_m`.
            let below = |distance_m: f64| {
                let distance = (distance_m / self.pitch_m + ROUNDING) as f32;
                distance * distance
            };
            let steps = track.len();
            // The pose with the lowest bound first: it rules most of the others out.
            let lowest = (0..steps).fold(0, |best, k| if squares[k][lane] < squares[best][lane] { k } else { best });
            let mut least_m = limit_m;
            // Squared bound below which a pose is looked at.
            let mut limit = below(least_m);
            if squares[lowest][lane] < limit {
                least_m = self.obstacles.clearance(at(lowest), least_m);
                limit = below(least_m);
            }
            for (k, square) in squares.iter().enumerate() {
                if square[lane] < limit && k != lowest {
                    let distance_m = self.obstacles.clearance(at(k), least_m);
                    if distance_m < least_m {
                        (least_m, limit) = (distance_m, below(distance_m));
                    }
                }
            }
            let last_m = match self.settings.distance_mode {
                DistanceMode::Endpoint => self.obstacles.clearance(at(steps - 1), limit_m),
                DistanceMode::PathMin => {
                    math::max(f64::from(positive_sqrt(squares[steps - 1][lane])) * self.pitch_m, least_m)
                }
            };
            let touching = below(self.touch_m);
            let touches =
                |&k: &usize| squares[k][lane] <= touching && self.obstacles.clearance(at(k), limit_m) <= self.touch_m;
            let free = if least_m <= self.touch_m { (0..steps).find(touches).unwrap_or(steps) } else { steps };
            let surface = |distance_m: f64| ((distance_m - self.radius_m) / self.pitch_m) as f32;
            (gaps.least[lane], gaps.last[lane]) = (surface(least_m), surface(last_m));
            gaps.free_steps[lane] = free as f32;
        }
        gaps
    }
}
