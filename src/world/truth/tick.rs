//! The motion of everything within one tick.

use super::ObstacleKind;
use super::bodies::{Body, PerBody};
use crate::geometry::outline::Body as Placed;
use crate::geometry::{Pose, Twist};
use crate::robot::Robot;
use crate::world::motion::Course;
use crate::world::obstacles::moving::Mover;
use crate::world::statics::Statics;

/// The motion of everything within one tick.
pub(super) struct Tick<'a> {
    pub(super) statics: Statics<'a>,
    pub(super) movers: &'a [Mover],
    pub(super) courses: &'a [Course],
    pub(super) begin: Pose,
    pub(super) twist: Twist,
    pub(super) robot: &'a Robot,
}

impl Tick<'_> {
    pub(super) fn pose(&self, time_s: f64) -> Pose {
        self.begin.advance(self.twist, time_s)
    }

    /// The footprint at `time_s`.
    fn footprint(&self, time_s: f64) -> Placed {
        self.robot.body(self.pose(time_s))
    }

    /// Signed distance at `time_s` between the footprint and a body, m.
    pub(super) fn gap_m(&self, body: Body, time_s: f64) -> f64 {
        self.gap_to_m(body, &self.footprint(time_s), time_s)
    }

    fn gap_to_m(&self, body: Body, footprint: &Placed, time_s: f64) -> f64 {
        match body {
            Body::Map => self.statics.map.gap_m(footprint),
            Body::Unknown(number) => self.statics.unknown[number].gap_m(footprint),
            Body::Mover(number) => {
                let mover = &self.movers[number];
                if mover.present { mover.gap_m(self.courses[number].at(time_s).0, footprint) } else { f64::INFINITY }
            }
        }
    }

    /// Highest rate at which the gap to a body can shrink, m/s. Turning moves the corners of a polygon towards a body, but not the
    /// outline of a disc.
    pub(super) fn rate(&self, body: Body) -> f64 {
        let other = match body {
            Body::Map | Body::Unknown(_) => 0.0,
            Body::Mover(number) => self.courses[number].speed(),
        };
        self.twist.v.abs() + other + self.turning_mps()
    }

    /// Highest speed that turning alone gives a point of the outline, m/s; 0 for a disc, whose outline stays where it is.
    pub(super) fn turning_mps(&self) -> f64 {
        self.robot.footprint.as_ref().map_or(0.0, |corners| self.twist.omega.abs() * corners.circumradius_m())
    }

    /// The kind of obstacle that the robot touches when it touches `body` at `time_s`.
    pub(super) fn kind(&self, body: Body, time_s: f64) -> ObstacleKind {
        match body {
            Body::Map => {
                let (map, footprint) = (self.statics.map, self.footprint(time_s));
                let is_obstacle = map.gap_m(&footprint) < map.edge_gap_m(&footprint);
                if is_obstacle { ObstacleKind::KnownStatic } else { ObstacleKind::Boundary }
            }
            Body::Unknown(_) => ObstacleKind::UnknownStatic,
            Body::Mover(_) => ObstacleKind::Dynamic,
        }
    }

    /// The gaps to all bodies at `time_s`.
    pub(super) fn measure(&self, time_s: f64, gaps_m: &mut PerBody<f64>) {
        let footprint = self.footprint(time_s);
        for (body, gap) in gaps_m.iter_mut() {
            *gap = self.gap_to_m(body, &footprint, time_s);
        }
    }
}
