//! Paths: pieces that are lines, arcs and curves, the key nodes among them, and times along them.

use super::curve::Curve;
use super::{Vec2, closest_on_segment, cross};
use crate::math;
use serde::{Deserialize, Serialize};

/// One piece of a [`Path`]; it begins where the piece before it ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// A polynomial curve; it begins where the piece before it ends.
    Curve(Box<Curve>),
}

impl Piece {
    /// End point of the piece.
    pub fn end(&self) -> Vec2 {
        match self {
            Self::Line { to } | Self::Arc { to, .. } => *to,
            Self::Curve(curve) => curve.point(1.0),
        }
    }

    /// Length of the piece that begins at `from`, metres.
    pub fn length(&self, from: Vec2) -> f64 {
        match self {
            Self::Line { to } => (to - from).norm(),
            Self::Arc { centre, sweep, .. } => (from - centre).norm() * sweep.abs(),
            Self::Curve(curve) => curve.length_m(),
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
            Self::Curve(ref curve) => curve.arc_to(curve.nearest(p)),
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
            Self::Arc { centre, sweep, .. } => turned_about(from, centre, sweep * share),
            Self::Curve(ref curve) => curve.point(curve.parameter_at(s)),
        }
    }

    /// The point at `share` (0 to 1) of the time that the piece that begins at `from` takes: lines and arcs are driven at
    /// constant speed, curves at a constant rate of their parameter.
    pub fn point_at_time(&self, from: Vec2, share: f64) -> Vec2 {
        match self {
            Self::Curve(curve) => curve.point(share),
            _ => self.point_at(from, share * self.length(from)),
        }
    }

    /// The part of the piece that begins at `from` between two arc lengths within it, m.
    fn part(&self, from: Vec2, first_m: f64, last_m: f64) -> Self {
        let to = self.point_at(from, last_m);
        match *self {
            Self::Line { .. } => Self::Line { to },
            Self::Arc { centre, sweep, .. } => {
                Self::Arc { to, centre, sweep: sweep * (last_m - first_m) / self.length(from) }
            }
            Self::Curve(ref curve) => {
                Self::Curve(Box::new(curve.part(curve.parameter_at(first_m), curve.parameter_at(last_m))))
            }
        }
    }

    /// Directions, not of unit length, in which the piece that begins at `from` sets out and arrives; `None` if it has no length.
    pub fn tangents(&self, from: Vec2) -> Option<(Vec2, Vec2)> {
        if self.length(from) == 0.0 {
            return None;
        }
        Some(match *self {
            Self::Line { to } => (to - from, to - from),
            Self::Arc { to, centre, sweep } => {
                let along = |radius: Vec2| Vec2::new(-radius.y, radius.x) * sweep.signum();
                (along(from - centre), along(to - centre))
            }
            Self::Curve(ref curve) => {
                // A curve may set out from rest: then the direction is that of the first derivative that is not 0.
                let set_out = (1..super::curve::COEFFICIENTS).map(|order| curve.derivative(order, 0.0));
                let begin = set_out.into_iter().find(|d| d.norm_squared() > 0.0).unwrap_or_default();
                let arrive = (1..super::curve::COEFFICIENTS).map(|order| (order, curve.derivative(order, 1.0)));
                let end = arrive.into_iter().find(|(_, d)| d.norm_squared() > 0.0);
                // Backwards from the end every second derivative points the other way.
                (begin, end.map_or(begin, |(order, d)| if order % 2 == 1 { d } else { -d }))
            }
        })
    }

    /// Largest absolute curvature of the piece that begins at `from`, 1/m; a curve's is that of 128 samples.
    pub fn curvature_max(&self, from: Vec2) -> f64 {
        match self {
            Self::Line { .. } => 0.0,
            Self::Arc { centre, .. } => 1.0 / (from - centre).norm(),
            Self::Curve(curve) => {
                (0..=128).fold(0.0, |largest, k| math::max(largest, curve.curvature(f64::from(k) / 128.0).abs()))
            }
        }
    }

    /// Chords that stay within `sagitta_m` of the piece that begins at `from`, at most `chords_max`; 1 for a line. They are equal
    /// parts of an arc's turn or of a curve's parameter; [`Self::chord_point`] gives their ends.
    pub fn chord_count(&self, from: Vec2, sagitta_m: f64, chords_max: f64) -> u32 {
        match self {
            Self::Line { .. } => 1,
            Self::Arc { centre, sweep, .. } => {
                // The sagitta r (1 − cos(δ/2)) is at most r δ² / 8.
                let turn_max = (8.0 * sagitta_m / (from - centre).norm()).sqrt();
                math::clamp((sweep.abs() / turn_max).ceil(), 1.0, chords_max) as u32
            }
            Self::Curve(curve) => curve.chords_within(sagitta_m),
        }
    }

    /// End number `k` of `chords` chords of the piece that begins at `from`; 0 is the beginning.
    pub fn chord_point(&self, from: Vec2, k: u32, chords: u32) -> Vec2 {
        if k == chords {
            return self.end();
        }
        match self {
            Self::Curve(curve) => curve.point(f64::from(k) / f64::from(chords)),
            _ => self.point_at(from, self.length(from) * f64::from(k) / f64::from(chords)),
        }
    }
}

fn turned_about(p: Vec2, centre: Vec2, angle: f64) -> Vec2 {
    let (sin, cos) = math::sin_cos(angle);
    let r = p - centre;
    centre + Vec2::new(cos * r.x - sin * r.y, sin * r.x + cos * r.y)
}

/// A significant point of a path, such as a turn of the method or the centre of a gate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeyNode {
    /// Its position, m; a smoothed path may pass beside it.
    pub position: Vec2,
    /// Arc length of the path's point that belongs to it, m.
    pub along_m: f64,
}

/// A continuous path of lines, arcs and curves, kept as geometry with exact lengths.
///
/// Its *key nodes* are apart from its pieces: a curve in a hundred pieces has no hundred key nodes. Where a method names none
/// they are the ends of the pieces. A path may carry *times*: when each piece ends, s from its beginning.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Path {
    start: Vec2,
    pieces: Vec<Piece>,
    /// Empty where the ends of the pieces are meant.
    named_nodes: Vec<KeyNode>,
    /// One for each piece, or empty.
    times_s: Vec<f64>,
    fallbacks: u32,
}

impl Path {
    /// The polyline through `vertices`; empty without vertices, a single point for one vertex.
    pub fn polyline(vertices: &[Vec2]) -> Self {
        let start = vertices.first().copied().unwrap_or_default();
        Self::new(start, vertices.iter().skip(1).map(|&to| Piece::Line { to }).collect())
    }

    /// A path from its beginning and its pieces.
    pub fn new(start: Vec2, pieces: Vec<Piece>) -> Self {
        Self { start, pieces, ..Self::default() }
    }

    /// The same path with `positions` as its key nodes, first and last included; each belongs to the nearest point of the
    /// path from that of the node before it on.
    #[must_use]
    pub fn with_key_nodes(mut self, positions: &[Vec2]) -> Self {
        let length = self.length();
        let mut along_m = 0.0;
        let last = positions.len().saturating_sub(1);
        let nodes = positions.iter().enumerate().map(|(number, &position)| {
            along_m = match number {
                0 => 0.0,
                _ if number == last => length,
                _ => math::clamp(self.project_within(position, along_m, length).0, along_m, length),
            };
            KeyNode { position, along_m }
        });
        self.named_nodes = nodes.collect();
        self
    }

    /// The same path with its points at these arc lengths as its key nodes, first and last included; they ascend from 0 to the
    /// length, m.
    #[must_use]
    pub fn with_key_nodes_at(mut self, along_m: &[f64]) -> Self {
        let last = along_m.len().saturating_sub(1);
        let position = |(number, &along_m)| if number == last { self.end() } else { self.point_at(along_m) };
        let positions = along_m.iter().enumerate().map(position);
        self.named_nodes = positions.zip(along_m).map(|(position, &along_m)| KeyNode { position, along_m }).collect();
        self
    }

    /// The same path with its start and the ends of those of its pieces that `is_node` names by their numbers as its key nodes. The
    /// last piece is to be one of them.
    #[must_use]
    pub fn with_key_nodes_at_ends(mut self, is_node: impl Fn(usize) -> bool) -> Self {
        self.named_nodes.clear();
        let mut ends = Vec::with_capacity(self.pieces.len() + 1);
        self.key_nodes(&mut ends);
        let mut number = 0;
        ends.retain(|_| {
            number += 1;
            number == 1 || is_node(number - 2)
        });
        self.named_nodes = ends;
        self
    }

    /// The same path with the number of places where the method that made it had to fall back to something simpler.
    #[must_use]
    pub fn with_fallbacks(self, fallbacks: u32) -> Self {
        Self { fallbacks, ..self }
    }

    /// The same path with times: `times_s[k]` is when piece k ends, s from the beginning, ascending.
    ///
    /// # Panics
    /// If there are not as many times as pieces, or they are negative, fall or are not finite.
    #[must_use]
    pub fn with_times(mut self, times_s: Vec<f64>) -> Self {
        assert_eq!(times_s.len(), self.pieces.len(), "a time for each piece");
        let ascend = times_s.iter().scan(0.0, |before, &time| Some(time >= core::mem::replace(before, time)));
        assert!(times_s.iter().all(|time| time.is_finite()) && ascend.into_iter().all(|ok| ok), "times ascend from 0");
        self.times_s = times_s;
        self
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

    /// Places where the method that made the path had to fall back to something simpler, such as parts of a spline that would have
    /// come too near to an obstacle; 0 for methods that never do. A part of a path, or a path that goes on, has none.
    pub fn fallbacks(&self) -> u32 {
        self.fallbacks
    }

    /// When each piece ends, s from the beginning; empty where the path has no times.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Beginning and ends of all pieces, in order: start, interior vertices, goal.
    pub fn vertices(&self) -> impl Iterator<Item = Vec2> + '_ {
        core::iter::once(self.start).chain(self.pieces.iter().map(Piece::end))
    }

    /// Appends the key nodes in order: those that were named, else the ends of the pieces.
    pub fn key_nodes(&self, nodes: &mut Vec<KeyNode>) {
        if !self.named_nodes.is_empty() {
            nodes.extend_from_slice(&self.named_nodes);
            return;
        }
        let mut along_m = 0.0;
        nodes.push(KeyNode { position: self.start, along_m });
        for (from, piece) in self.segments() {
            along_m += piece.length(from);
            nodes.push(KeyNode { position: piece.end(), along_m });
        }
    }

    /// Whether the key nodes were named and are not the ends of the pieces.
    pub fn has_named_nodes(&self) -> bool {
        !self.named_nodes.is_empty()
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

    /// The point at `time_s` from the beginning, clamped to the ends; `None` where the path has no times.
    pub fn point_at_time(&self, time_s: f64) -> Option<Vec2> {
        if self.times_s.is_empty() {
            return None;
        }
        let mut begin_s = 0.0;
        for ((from, piece), &end_s) in self.segments().zip(&self.times_s) {
            if time_s <= end_s {
                let share = if end_s > begin_s { (time_s - begin_s) / (end_s - begin_s) } else { 1.0 };
                return Some(piece.point_at_time(from, math::clamp(share, 0.0, 1.0)));
            }
            begin_s = end_s;
        }
        Some(self.end())
    }

    /// The part between two arc lengths, clamped to the ends; a single point where `to_m` is not beyond `from_m`. Its key nodes
    /// are the ends of its pieces, and it has no times.
    #[must_use]
    pub fn part(&self, from_m: f64, to_m: f64) -> Self {
        let mut part = Self::new(self.point_at(from_m), Vec::new());
        let mut begin_m = 0.0;
        for (from, piece) in self.segments() {
            let length = piece.length(from);
            let (first, last) = (math::max(from_m - begin_m, 0.0), math::min(to_m - begin_m, length));
            if first < last {
                part.pieces.push(piece.part(from, first, last));
            }
            begin_m += length;
        }
        part
    }

    /// This path and then `next`, which begins where this one ends. Key nodes are the ends of the pieces, and there are no times.
    #[must_use]
    pub fn then(mut self, next: &Self) -> Self {
        self.pieces.extend_from_slice(&next.pieces);
        Self::new(self.start, self.pieces)
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

    /// A quarter of a circle of 1 m as a line of 2 m goes on, then a cubic that leaves along it.
    fn mixed() -> Path {
        let v = Vec2::new;
        let curve = Curve::bezier([v(3.0, 1.0), v(3.0, 2.0), v(4.0, 3.0), v(5.0, 3.0)]);
        let arc = Piece::Arc { to: v(3.0, 1.0), centre: v(2.0, 1.0), sweep: math::FRAC_PI_2 };
        Path::new(v(0.0, 0.0), vec![Piece::Line { to: v(2.0, 0.0) }, arc, Piece::Curve(Box::new(curve))])
    }

    #[test]
    fn curves_have_length_projection_and_tangents_like_other_pieces() {
        let path = mixed();
        let (from, piece) = path.segments().last().unwrap();
        let length = piece.length(from);
        assert!((piece.point_at(from, length) - Vec2::new(5.0, 3.0)).norm() < 1e-9);
        let (begin, end) = piece.tangents(from).unwrap();
        assert!(begin.x == 0.0 && begin.y > 0.0 && end.y == 0.0 && end.x > 0.0);
        let before = 2.0 + math::FRAC_PI_2;
        for share in [0.1, 0.4, 0.75] {
            let point = path.point_at(before + share * length);
            let (along, distance) = path.project(point);
            assert!((along - before - share * length).abs() < 1e-5 && distance < 1e-5, "{along} {distance}");
        }
        assert!(piece.curvature_max(from) > 0.3 && piece.curvature_max(from) < 2.0);
        assert!(piece.chord_count(from, 1e-3, 1e4) > 5);
        assert_eq!(piece.chord_point(from, 0, 7), from);
    }

    #[test]
    fn key_nodes_are_apart_from_pieces() {
        let path = mixed();
        let mut nodes = Vec::new();
        path.key_nodes(&mut nodes);
        assert_eq!(nodes.len(), 4);
        assert!(close(nodes[2].along_m, 2.0 + math::FRAC_PI_2));
        let named = path.clone().with_key_nodes(&[path.start(), Vec2::new(3.0, 0.0), path.end()]);
        nodes.clear();
        named.key_nodes(&mut nodes);
        assert_eq!(nodes.len(), 3);
        // The corner (3, 0) belongs to the middle of the arc.
        assert!(close(nodes[1].along_m, 2.0 + 0.25 * math::PI) && nodes[1].position == Vec2::new(3.0, 0.0));
        assert!(close(nodes[2].along_m, path.length()) && named.pieces().len() == 3);
    }

    #[test]
    fn a_part_of_a_path_is_that_part() {
        let path = mixed();
        let length = path.length();
        for (from_m, to_m) in [(0.5, 1.5), (1.0, 2.5), (2.2, length - 0.3), (0.0, length)] {
            let part = path.part(from_m, to_m);
            assert!((part.length() - (to_m - from_m)).abs() < 1e-5, "{from_m} {to_m} {}", part.length());
            for share in [0.0, 0.3, 0.8, 1.0] {
                let along = share * (to_m - from_m);
                assert!(
                    (part.point_at(along) - path.point_at(from_m + along)).norm() < 1e-5,
                    "{from_m} {to_m} {share}"
                );
            }
        }
        assert_eq!((path.part(3.0, 1.0).pieces().len(), path.part(1.0, 1.0).start()), (0, Vec2::new(1.0, 0.0)));
        let whole = path.part(0.0, 2.5).then(&path.part(2.5, length));
        assert!((whole.length() - length).abs() < 1e-5 && (whole.end() - path.end()).norm() < 1e-9);
    }

    #[test]
    fn times_run_along_the_pieces() {
        let path = mixed().with_times(vec![2.0, 3.0, 5.0]);
        assert_eq!(path.point_at_time(1.0), Some(Vec2::new(1.0, 0.0)));
        assert!((path.point_at_time(2.5).unwrap() - path.point_at(2.0 + 0.25 * math::PI)).norm() < 1e-12);
        assert_eq!(path.point_at_time(9.0), Some(path.end()));
        let Piece::Curve(curve) = &path.pieces()[2] else { panic!("a curve") };
        assert_eq!(path.point_at_time(4.0), Some(curve.point(0.5)));
        assert_eq!(mixed().point_at_time(1.0), None);
    }
}
