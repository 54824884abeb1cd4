//! Plain values of the plane: points, poses, twists, rectangles; paths of lines, arcs and curves.
//!
//! Metres and radians; x forward/east, y left/north, angles counter-clockwise from +x.

pub mod convex;
pub mod curve;
pub mod outline;
mod path;

pub use path::{KeyNode, Path, Piece};

use crate::math;
use serde::{Deserialize, Serialize};

/// A point or a displacement, in metres.
pub type Vec2 = nalgebra::Vector2<f64>;

/// The angle `a` brought into (−π, π].
pub fn wrap_angle(a: f64) -> f64 {
    let wrapped = a - math::TAU * ((a + math::PI) / math::TAU).floor();
    // floor() leaves [−π, π); the lower end belongs to the upper.
    if wrapped <= -math::PI { wrapped + math::TAU } else { wrapped }
}

/// The unit vector of direction `theta`.
pub fn direction(theta: f64) -> Vec2 {
    let (sin, cos) = math::sin_cos(theta);
    Vec2::new(cos, sin)
}

/// z component of the cross product: positive where `b` lies counter-clockwise of `a`.
pub fn cross(a: Vec2, b: Vec2) -> f64 {
    a.x * b.y - a.y * b.x
}

/// Position and heading of a body.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Position, metres.
    pub position: Vec2,
    /// Heading, radians in (−π, π].
    pub theta: f64,
}

impl Pose {
    /// A pose from its numbers; the heading is wrapped.
    pub fn new(x: f64, y: f64, theta: f64) -> Self {
        Self { position: Vec2::new(x, y), theta: wrap_angle(theta) }
    }

    /// The pose after driving `twist` for `time_s`: the exact arc of a unicycle.
    ///
    /// The chord has length v·t·sinc(ω·t/2) and lies at heading + ω·t/2, which is exact for
    /// every ω, the straight line included.
    pub fn advance(self, twist: Twist, time_s: f64) -> Self {
        let half_turn = 0.5 * twist.omega * time_s;
        let sinc = if half_turn.abs() < 1e-9 { 1.0 } else { math::sin(half_turn) / half_turn };
        let chord = twist.v * time_s * sinc;
        Self {
            position: self.position + chord * direction(self.theta + half_turn),
            theta: wrap_angle(self.theta + twist.omega * time_s),
        }
    }

    /// Angle from the heading to `point`, in (−π, π]; 0 if the point is the position itself.
    pub fn bearing_to(self, point: Vec2) -> f64 {
        let d = point - self.position;
        if d.x == 0.0 && d.y == 0.0 { 0.0 } else { wrap_angle(math::atan2(d.y, d.x) - self.theta) }
    }
}

/// Velocity of a differential drive in its own frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Forward speed, m/s.
    pub v: f64,
    /// Yaw rate, rad/s, counter-clockwise.
    pub omega: f64,
}

impl Twist {
    /// Standing still.
    pub const ZERO: Self = Self { v: 0.0, omega: 0.0 };
}

/// Distance from `p` to the segment a–b, metres.
pub fn point_segment_distance(p: Vec2, a: Vec2, b: Vec2) -> f64 {
    (p - closest_on_segment(p, a, b)).norm()
}

/// The point of the segment a–b that is nearest to `p`.
pub fn closest_on_segment(p: Vec2, a: Vec2, b: Vec2) -> Vec2 {
    let ab = b - a;
    let length_squared = ab.norm_squared();
    if length_squared == 0.0 {
        return a;
    }
    a + ab * math::clamp((p - a).dot(&ab) / length_squared, 0.0, 1.0)
}

/// An axis-aligned rectangle, both ends included, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Corner with the smallest coordinates.
    pub min: Vec2,
    /// Corner with the largest coordinates.
    pub max: Vec2,
}

impl Rect {
    /// Signed distance from `p` to the rectangle's boundary: negative inside.
    pub fn signed_distance(&self, p: Vec2) -> f64 {
        let (dx, dy) = self.beyond(p);
        if dx > 0.0 && dy > 0.0 { math::hypot(dx, dy) } else { math::max(dx, dy) }
    }

    /// How far `p` lies beyond the nearer side in x and in y: negative between the sides.
    fn beyond(&self, p: Vec2) -> (f64, f64) {
        (math::max(self.min.x - p.x, p.x - self.max.x), math::max(self.min.y - p.y, p.y - self.max.y))
    }

    /// The smaller of `best` and [`Self::signed_distance`]; the square root is skipped if the result must be `best`.
    pub fn signed_distance_below(&self, p: Vec2, best: f64) -> f64 {
        // Far above what rounding can do to either side.
        const MARGIN: f64 = 1.000_001;
        let (dx, dy) = self.beyond(p);
        if dx > 0.0 && dy > 0.0 && best > 0.0 && dx * dx + dy * dy > MARGIN * (best * best) {
            return best;
        }
        math::min(best, self.signed_distance(p))
    }

    /// Whether `p` lies inside or on the edge.
    pub fn contains(&self, p: Vec2) -> bool {
        p.x >= self.min.x && p.x <= self.max.x && p.y >= self.min.y && p.y <= self.max.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12
    }

    #[test]
    fn angles_wrap_into_the_half_open_interval() {
        assert!(close(wrap_angle(math::PI), math::PI));
        assert!(close(wrap_angle(-math::PI), math::PI));
        assert!(close(wrap_angle(3.0 * math::PI), math::PI));
        assert!(close(wrap_angle(-0.25), -0.25));
        assert!(close(wrap_angle(7.0), 7.0 - math::TAU));
    }

    #[test]
    fn a_quarter_circle_ends_where_it_should() {
        // v = 1, ω = 1 for π/2 s: a quarter of the unit circle about (0, 1).
        let end = Pose::new(0.0, 0.0, 0.0).advance(Twist { v: 1.0, omega: 1.0 }, math::FRAC_PI_2);
        assert!(close(end.position.x, 1.0) && close(end.position.y, 1.0) && close(end.theta, math::FRAC_PI_2));
    }

    #[test]
    fn rectangle_distance_is_signed() {
        let rect = Rect { min: Vec2::new(0.0, 0.0), max: Vec2::new(2.0, 1.0) };
        assert!(close(rect.signed_distance(Vec2::new(5.0, 5.0)), 5.0)); // 3-4-5
        assert!(close(rect.signed_distance(Vec2::new(1.0, 0.25)), -0.25));
        assert!(close(rect.signed_distance(Vec2::new(1.0, 3.0)), 2.0));
    }
}
