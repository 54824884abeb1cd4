//! What counts as in the way: an obstacle in a region that the robot, going on along its path, would come too near to in time.

use super::Params;
use super::regions::Rectangle;
use crate::geometry::{Vec2, convex};
use crate::math;
use crate::observation::SensedObstacle;
use crate::plan::clearance::segment_square_distance;
use crate::plan::contract::{Guidance, Situation};

/// The robot's nominal motion; its memory is used again.
#[derive(Clone, Debug, Default)]
pub(super) struct Watch {
    /// Where the robot would be on its path after 1, 2, … control periods.
    nominal: Vec<Vec2>,
}

impl Watch {
    /// Whether a mover or an unexpected static that touches one of the `rectangles` conflicts with the robot within the time window.
    ///
    /// The robot follows its path from its progress on, as fast as its limits allow; a mover keeps its velocity and is the smallest
    /// disc that holds it, as is the robot. An unexpected static also conflicts, wherever it is, if it is too near to the way from the
    /// robot to its look-ahead point on the path: a robot that has left its path may have it between itself and the path.
    pub(super) fn is_conflict<'a>(
        &mut self,
        params: &Params,
        situation: &Situation<'_>,
        guidance: &Guidance<'_>,
        rectangles: impl Iterator<Item = &'a Rectangle> + Clone,
    ) -> bool {
        let belief = situation.belief;
        if situation.obstacles.is_empty() && belief.added().is_empty() {
            return false;
        }
        self.go_on(params, situation, guidance);
        let near_m = situation.robot.radius_m + params.conflict_margin_m.get();
        let is_watched = |mover: &SensedObstacle| {
            rectangles.clone().any(|rectangle| rectangle.touches_disc(mover.position, mover.radius_m()))
        };
        let is_met = |mover: &SensedObstacle| {
            self.nominal.iter().zip(1_u32..).any(|(point, tick)| {
                let then = mover.position + mover.velocity * (f64::from(tick) * situation.dt_s);
                (point - then).norm() - mover.radius_m() < near_m
            })
        };
        if situation.obstacles.iter().any(|mover| is_watched(mover) && is_met(mover)) {
            return true;
        }
        let here = situation.pose.position;
        let back = guidance.path.point_at(guidance.progress_m + params.lookahead_m.get());
        belief.added().iter().any(|&cell| {
            let square = belief.grid().square(cell);
            let corners = convex::rectangle(square);
            let is_on_the_way =
                self.nominal.iter().any(|&point| math::max(square.signed_distance(point), 0.0) < near_m)
                    && rectangles.clone().any(|rectangle| rectangle.touches(&corners));
            is_on_the_way || segment_square_distance(here, back, square) < near_m
        })
    }

    fn go_on(&mut self, params: &Params, situation: &Situation<'_>, guidance: &Guidance<'_>) {
        let (robot, dt_s) = (situation.robot, situation.dt_s);
        let ticks = (params.conflict_window_s.get() / dt_s).round().clamp(1.0, 1e4) as u32;
        let length_m = guidance.path.length();
        let (mut along_m, mut speed_mps) = (guidance.progress_m, math::max(situation.twist.v, 0.0));
        self.nominal.clear();
        self.nominal.extend((0..ticks).map(|_| {
            speed_mps = math::min(speed_mps + robot.acceleration_max_mps2 * dt_s, robot.speed_max_mps);
            along_m = math::min(along_m + speed_mps * dt_s, length_m);
            guidance.path.point_at(along_m)
        }));
    }
}
