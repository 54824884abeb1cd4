//! Plain values of the plane: points, poses, twists, segments, paths of lines and arcs.
//!
//! Metres and radians; x forward/east, y left/north, angles counter-clockwise from +x.

pub mod convex;
pub mod outline;

use crate::math;

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

/// Where a body is and which way it points.
#[derive(Clone, Copy, Debug, PartialEq)]
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

    /// Angle from the heading to `point`, in (−π, π]; 0 where the point is the position itself.
    pub fn bearing_to(self, point: Vec2) -> f64 {
        let d = point - self.position;
        if d.x == 0.0 && d.y == 0.0 { 0.0 } else { wrap_angle(math::atan2(d.y, d.x) - self.theta) }
    }
}

/// Velocity of a differential drive in its own frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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

    /// The smaller of `best` and [`Self::signed_distance`], without the root where it cannot be the latter.
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

/// One piece of a [`Path`]; it begins where the piece before it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// A straight line to `to`.
    Line {
        /// End point.
        to: Vec2,
    },
    /// A circular arc to `to`.
    Arc {
        /// End point.
        to: Vec2,
        /// Centre of the circle.
        centre: Vec2,
        /// Signed turn from beginning to end, radians; positive counter-clockwise.
        sweep: f64,
    },
}

impl Piece {
    /// End point of the piece.
    pub fn end(&self) -> Vec2 {
        match *self {
            Self::Line { to } | Self::Arc { to, .. } => to,
        }
    }

    /// Length of the piece that begins at `from`, metres.
    pub fn length(&self, from: Vec2) -> f64 {
        match *self {
            Self::Line { to } => (to - from).norm(),
            Self::Arc { centre, sweep, .. } => (from - centre).norm() * sweep.abs(),
        }
    }

    /// The arc length at which the piece that begins at `from` comes nearest to `p`.
    pub fn project(&self, from: Vec2, p: Vec2) -> f64 {
        match *self {
            Self::Line { to } => (closest_on_segment(p, from, to) - from).norm(),
            Self::Arc { to, centre, sweep } => {
                let (r, q) = (from - centre, p - centre);
                // The turn from the beginning to p, in the sweep's own sense.
                let mut turn = math::atan2(cross(r, q), r.dot(&q));
                if turn * sweep < 0.0 {
                    turn += if sweep > 0.0 { math::TAU } else { -math::TAU };
                }
                if turn.abs() <= sweep.abs() {
                    r.norm() * turn.abs()
                } else if (p - from).norm() <= (p - to).norm() {
                    0.0
                } else {
                    self.length(from)
                }
            }
        }
    }

    /// The point at arc length `s` (0 to the length) of the piece that begins at `from`.
    pub fn point_at(&self, from: Vec2, s: f64) -> Vec2 {
        let length = self.length(from);
        if length == 0.0 {
            return from;
        }
        let share = math::clamp(s / length, 0.0, 1.0);
        match *self {
            Self::Line { to } => from + (to - from) * share,
            Self::Arc { centre, sweep, .. } => {
                let (sin, cos) = math::sin_cos(sweep * share);
                let r = from - centre;
                centre + Vec2::new(cos * r.x - sin * r.y, sin * r.x + cos * r.y)
            }
        }
    }
}

/// A continuous path of lines and arcs, kept as geometry with exact lengths.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Path {
    start: Vec2,
    pieces: Vec<Piece>,
}

impl Path {
    /// The polyline through `vertices`; empty where there are none, a single point where there is one.
    pub fn polyline(vertices: &[Vec2]) -> Self {
        let start = vertices.first().copied().unwrap_or_default();
        let pieces = vertices.iter().skip(1).map(|&to| Piece::Line { to }).collect();
        Self { start, pieces }
    }

    /// A path from its beginning and its pieces.
    pub fn new(start: Vec2, pieces: Vec<Piece>) -> Self {
        Self { start, pieces }
    }

    /// Where the path begins.
    pub fn start(&self) -> Vec2 {
        self.start
    }

    /// Where the path ends.
    pub fn end(&self) -> Vec2 {
        self.pieces.last().map_or(self.start, Piece::end)
    }

    /// The pieces in order.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Beginning and ends of all pieces, in order: start, interior vertices, goal.
    pub fn vertices(&self) -> impl Iterator<Item = Vec2> + '_ {
        core::iter::once(self.start).chain(self.pieces.iter().map(Piece::end))
    }

    /// Each piece with the point where it begins.
    pub fn segments(&self) -> impl Iterator<Item = (Vec2, &Piece)> + '_ {
        self.vertices().zip(&self.pieces)
    }

    /// Length in metres.
    pub fn length(&self) -> f64 {
        self.segments().map(|(from, piece)| piece.length(from)).sum()
    }

    /// The point at arc length `s`, clamped to the ends.
    pub fn point_at(&self, s: f64) -> Vec2 {
        let mut left = math::max(s, 0.0);
        for (from, piece) in self.segments() {
            let length = piece.length(from);
            if left <= length {
                return piece.point_at(from, left);
            }
            left -= length;
        }
        self.end()
    }

    /// The arc length at which the path comes nearest to `p`, and that distance; the first of equals.
    pub fn project(&self, p: Vec2) -> (f64, f64) {
        self.project_within(p, 0.0, f64::INFINITY)
    }

    /// The same for the pieces that reach into the arc lengths from `from_m` to `to_m` alone.
    pub fn project_within(&self, p: Vec2, from_m: f64, to_m: f64) -> (f64, f64) {
        let mut best = (0.0, f64::INFINITY);
        let mut s = 0.0;
        for (from, piece) in self.segments() {
            let length = piece.length(from);
            if s + length >= from_m && s <= to_m {
                let along = piece.project(from, p);
                let distance = (p - piece.point_at(from, along)).norm();
                if distance < best.1 {
                    best = (s + along, distance);
                }
            }
            s += length;
        }
        if best.1.is_finite() { best } else { (s, (p - self.end()).norm()) }
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

    #[test]
    fn lines_and_arcs_have_exact_lengths() {
        let path = Path::new(
            Vec2::new(0.0, 0.0),
            vec![
                Piece::Line { to: Vec2::new(2.0, 0.0) },
                Piece::Arc { to: Vec2::new(3.0, 1.0), centre: Vec2::new(2.0, 1.0), sweep: math::FRAC_PI_2 },
            ],
        );
        assert!(close(path.length(), 2.0 + math::FRAC_PI_2));
        let middle = path.point_at(2.0 + math::FRAC_PI_2 / 2.0);
        assert!(close((middle - Vec2::new(2.0, 1.0)).norm(), 1.0));
        let (s, d) = path.project(Vec2::new(2.0 + 2.0 * math::cos(-0.3), 1.0 + 2.0 * math::sin(-0.3)));
        assert!(close(s, 2.0 + math::FRAC_PI_2 - 0.3) && close(d, 1.0), "{s} {d}");
    }
}
