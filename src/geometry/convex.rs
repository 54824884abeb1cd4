//! Convex polygons: exact distances, first contacts of straight motion, and discs that cover them.
//!
//! Points are metres; corners are in counter-clockwise order. Signed distances are negative where two bodies overlap: then
//! they are minus the least translation that parts them.

use super::outline::{Hit, sweep_point_disc};
use super::{Rect, Vec2, closest_on_segment, cross, point_segment_distance};
use crate::math;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};

/// Most corners of a polygon.
pub const CORNERS_MAX: usize = 16;

/// Corners nearer to the line of their neighbours than this do not count as corners, m.
const STRAIGHT_M: f64 = 1e-9;

/// A convex polygon about its own origin, which lies inside. Cheap to copy.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Vec<Vec2>", into = "Vec<Vec2>")]
pub struct Polygon(Arc<Parts>);

#[derive(Debug)]
struct Parts {
    corners: Vec<Vec2>,
    circumradius_m: f64,
    inradius_m: f64,
    /// Discs that cover the polygon, computed on first use.
    cover: OnceLock<Vec<Disc>>,
}

impl TryFrom<Vec<Vec2>> for Polygon {
    type Error = String;

    fn try_from(corners: Vec<Vec2>) -> Result<Self, String> {
        Self::new(&corners)
    }
}

impl From<Polygon> for Vec<Vec2> {
    fn from(polygon: Polygon) -> Self {
        polygon.corners().to_vec()
    }
}

impl PartialEq for Polygon {
    fn eq(&self, other: &Self) -> bool {
        self.corners() == other.corners()
    }
}

/// A disc in the frame of the polygon that it helps to cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Centre, m.
    pub centre: Vec2,
    /// Radius, m.
    pub radius_m: f64,
}

impl Polygon {
    /// The polygon with these corners, in either order.
    ///
    /// # Errors
    /// Fewer than 3 or more than [`CORNERS_MAX`] corners, corners that are not strictly convex, an origin that is not inside.
    pub fn new(corners: &[Vec2]) -> Result<Self, String> {
        let count = corners.len();
        if !(3..=CORNERS_MAX).contains(&count) {
            return Err(format!("expected 3 to {CORNERS_MAX} corners, not {count}"));
        }
        let area: f64 = edges(corners).map(|(a, b)| cross(a, b)).sum();
        let corners: Vec<Vec2> = if area < 0.0 { corners.iter().rev().copied().collect() } else { corners.to_vec() };
        // Strictly convex: every turn is to the left, and all turns make one round.
        let mut round = 0.0;
        for i in 0..count {
            let (a, b, c) = (corners[i], corners[(i + 1) % count], corners[(i + 2) % count]);
            let (ab, bc) = (b - a, c - b);
            let turn = cross(ab, bc);
            if turn <= STRAIGHT_M * (ab.norm() + bc.norm()) {
                return Err(format!(
                    "expected the corners of a convex outline in order: it does not bend outwards at [{}, {}]",
                    b.x, b.y
                ));
            }
            round += math::atan2(turn, ab.dot(&bc));
        }
        if round > 1.5 * math::TAU {
            return Err("expected a convex outline: this one winds round more than once".to_owned());
        }
        let inradius_m = -point_distance(&corners, Vec2::zeros());
        if inradius_m <= STRAIGHT_M {
            return Err("expected the point [0, 0], about which the body turns, to lie inside the outline".to_owned());
        }
        let circumradius_m = corners.iter().map(|corner| corner.norm()).fold(0.0, math::max);
        Ok(Self(Arc::new(Parts { corners, circumradius_m, inradius_m, cover: OnceLock::new() })))
    }

    /// The same shape, `scale` times as large; `scale` is above 0.
    #[must_use]
    pub fn scaled(&self, scale: f64) -> Self {
        Self(Arc::new(Parts {
            corners: self.corners().iter().map(|corner| scale * corner).collect(),
            circumradius_m: scale * self.circumradius_m(),
            inradius_m: scale * self.inradius_m(),
            cover: OnceLock::new(),
        }))
    }

    /// The corners, counter-clockwise.
    pub fn corners(&self) -> &[Vec2] {
        &self.0.corners
    }

    /// Radius of the smallest disc about the origin that holds the polygon, m.
    pub fn circumradius_m(&self) -> f64 {
        self.0.circumradius_m
    }

    /// Radius of the largest disc about the origin that the polygon holds, m.
    pub fn inradius_m(&self) -> f64 {
        self.0.inradius_m
    }

    /// Discs whose union holds the polygon and little more: so the distance from their union is never more than
    /// that from the polygon. For callers that look up distances of points.
    pub fn cover(&self) -> &[Disc] {
        self.0.cover.get_or_init(|| cover(self.corners(), self.inradius_m()))
    }

    /// The corners where the polygon's origin is at `position` and its x axis points along the unit vector `axis`.
    pub fn placed(&self, position: Vec2, axis: Vec2) -> Corners {
        let mut placed = Corners { points: [Vec2::zeros(); CORNERS_MAX], count: self.corners().len() };
        for (point, corner) in placed.points.iter_mut().zip(self.corners()) {
            *point = position + turned(*corner, axis);
        }
        placed
    }
}

/// A vector given in a frame whose x axis points along the unit vector `axis`, in the frame outside.
pub fn turned(d: Vec2, axis: Vec2) -> Vec2 {
    Vec2::new(axis.x * d.x - axis.y * d.y, axis.y * d.x + axis.x * d.y)
}

/// The inverse of [`turned`].
pub fn turned_back(d: Vec2, axis: Vec2) -> Vec2 {
    Vec2::new(axis.x * d.x + axis.y * d.y, axis.x * d.y - axis.y * d.x)
}

/// The corners of a polygon somewhere in the plane, without memory of their own.
#[derive(Clone, Copy, Debug)]
pub struct Corners {
    points: [Vec2; CORNERS_MAX],
    count: usize,
}

impl core::ops::Deref for Corners {
    type Target = [Vec2];

    fn deref(&self) -> &[Vec2] {
        &self.points[..self.count]
    }
}

impl From<[Vec2; 4]> for Corners {
    fn from(corners: [Vec2; 4]) -> Self {
        let mut points = [Vec2::zeros(); CORNERS_MAX];
        points[..4].copy_from_slice(&corners);
        Self { points, count: 4 }
    }
}

impl Corners {
    /// The corners after the motion `f`, which must be rigid.
    #[must_use]
    pub fn map(mut self, f: impl Fn(Vec2) -> Vec2) -> Self {
        for point in &mut self.points[..self.count] {
            *point = f(*point);
        }
        self
    }
}

/// The corners of a rectangle.
pub fn rectangle(rect: Rect) -> [Vec2; 4] {
    [rect.min, Vec2::new(rect.max.x, rect.min.y), rect.max, Vec2::new(rect.min.x, rect.max.y)]
}

/// The smallest axis-aligned rectangle around points.
pub fn bounds(points: &[Vec2]) -> Rect {
    let first = Rect { min: points[0], max: points[0] };
    points.iter().fold(first, |rect, p| Rect {
        min: Vec2::new(math::min(rect.min.x, p.x), math::min(rect.min.y, p.y)),
        max: Vec2::new(math::max(rect.max.x, p.x), math::max(rect.max.y, p.y)),
    })
}

fn edges(corners: &[Vec2]) -> impl Iterator<Item = (Vec2, Vec2)> + Clone + '_ {
    corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
}

/// Unit vector out of the polygon across the edge a–b.
fn outward(a: Vec2, b: Vec2) -> Vec2 {
    let along = b - a;
    Vec2::new(along.y, -along.x) / along.norm()
}

/// Signed distance from `p` to a polygon, m.
pub fn point_distance(corners: &[Vec2], p: Vec2) -> f64 {
    let deepest = edges(corners).map(|(a, b)| outward(a, b).dot(&(p - a))).fold(f64::NEG_INFINITY, math::max);
    if deepest <= 0.0 {
        return deepest;
    }
    edges(corners).map(|(a, b)| point_segment_distance(p, a, b)).fold(f64::INFINITY, math::min)
}

/// The point of a polygon that is nearest to `p`: `p` itself inside.
pub fn nearest_point(corners: &[Vec2], p: Vec2) -> Vec2 {
    if edges(corners).all(|(a, b)| cross(b - a, p - a) >= 0.0) {
        return p;
    }
    let mut best = corners[0];
    for (a, b) in edges(corners) {
        let point = closest_on_segment(p, a, b);
        if (p - point).norm_squared() < (p - best).norm_squared() {
            best = point;
        }
    }
    best
}

/// A point of a polygon whose height is as near to `y` as any.
pub fn point_at_height(corners: &[Vec2], y: f64) -> Vec2 {
    // The middle of what the line at that height has in common with the polygon; else the corner nearest to the line.
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut nearest = corners[0];
    for (a, b) in edges(corners) {
        if (a.y - y).abs() < (nearest.y - y).abs() {
            nearest = a;
        }
        if math::min(a.y, b.y) <= y && y <= math::max(a.y, b.y) {
            let x = if a.y == b.y { a.x } else { a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)) };
            (low, high) = (math::min(low, x), math::max(high, x));
        }
    }
    if low <= high { Vec2::new(0.5 * (low + high), y) } else { nearest }
}

/// Signed distance between two polygons, m.
///
/// Apart, the nearest two points are a corner of one and a point of an edge of the other. Overlapping, the least
/// translation that parts them is along the normal of an edge (of their Minkowski difference, whose edges are those of both).
pub fn distance(a: &[Vec2], b: &[Vec2]) -> f64 {
    let separation = math::max(separation(a, b), separation(b, a));
    if separation <= 0.0 {
        return separation;
    }
    let corner_to_edge = |from: &[Vec2], to: &[Vec2]| {
        from.iter()
            .flat_map(|&corner| edges(to).map(move |(p, q)| point_segment_distance(corner, p, q)))
            .fold(f64::INFINITY, math::min)
    };
    math::min(corner_to_edge(a, b), corner_to_edge(b, a))
}

/// The largest distance by which all of `b` lies beyond the line of an edge of `a`, m; negative if it lies beyond none.
fn separation(a: &[Vec2], b: &[Vec2]) -> f64 {
    let beyond = |(p, q)| {
        let normal = outward(p, q);
        b.iter().map(|corner| normal.dot(&(corner - p))).fold(f64::INFINITY, math::min)
    };
    edges(a).map(beyond).fold(f64::NEG_INFINITY, math::max)
}

/// Times at which a ray enters a convex body and leaves it again, in units of the ray's speed; `None` if it misses.
/// The body is the intersection of half planes `normal · x ≤ offset`; the normal is that of the face of entry, zero
/// if the ray begins inside.
fn clip(from: Vec2, velocity: Vec2, planes: impl Iterator<Item = (Vec2, f64)>) -> Option<(f64, Vec2)> {
    let (mut enters, mut leaves, mut normal) = (f64::NEG_INFINITY, f64::INFINITY, Vec2::zeros());
    for (face, offset) in planes {
        let (approach, above) = (face.dot(&velocity), face.dot(&from) - offset);
        if approach < 0.0 {
            let time = above / -approach;
            if time > enters {
                (enters, normal) = (time, face);
            }
        } else if approach > 0.0 {
            leaves = math::min(leaves, -above / approach);
        } else if above > 0.0 {
            return None;
        }
    }
    (enters <= leaves && leaves >= 0.0).then_some((enters, normal))
}

/// Distance along a ray (unit vector `unit`) to a polygon, m: 0 inside it, infinity where the ray misses.
pub fn cast_ray(corners: &[Vec2], from: Vec2, unit: Vec2) -> f64 {
    let faces = edges(corners).map(|(a, b)| {
        let normal = outward(a, b);
        (normal, normal.dot(&a))
    });
    clip(from, unit, faces).map_or(f64::INFINITY, |(enters, _)| math::max(enters, 0.0))
}

/// First contact of the polygon `moving` at constant `velocity` with the polygon `still`: the time and the unit normal of
/// contact, which points from `still` to `moving`. At time 0 if they overlap already and approach; `None`
/// if they move apart or never meet.
///
/// The origin as a point against the Minkowski difference still − moving, whose edges are those of both.
pub fn sweep(moving: &[Vec2], velocity: Vec2, still: &[Vec2]) -> Option<Hit> {
    let reach = |points: &[Vec2], along: Vec2| points.iter().map(|p| along.dot(p)).fold(f64::NEG_INFINITY, math::max);
    let normals = edges(still).map(|(a, b)| outward(a, b)).chain(edges(moving).map(|(a, b)| -outward(a, b)));
    let faces = normals.map(|normal| (normal, reach(still, normal) + reach(moving, -normal)));
    let (enters, normal) = clip(Vec2::zeros(), velocity, faces.clone())?;
    if enters >= 0.0 {
        return Some(Hit { time_s: enters, normal });
    }
    // They overlap: out by the shortest way, if they are not on it.
    let mut best = (f64::INFINITY, Vec2::zeros());
    for (normal, offset) in faces {
        if offset < best.0 {
            best = (offset, normal);
        }
    }
    (velocity.dot(&best.1) < 0.0).then_some(Hit { time_s: 0.0, normal: best.1 })
}

/// First contact of a disc that moves from `p` with `velocity` with a polygon that stands still; as [`sweep`].
pub fn sweep_disc(p: Vec2, velocity: Vec2, radius_m: f64, still: &[Vec2]) -> Option<Hit> {
    if point_distance(still, p) <= radius_m {
        let normal = outward_at(still, p);
        return (velocity.dot(&normal) < 0.0).then_some(Hit { time_s: 0.0, normal });
    }
    let mut first: Option<Hit> = None;
    let mut keep = |hit: Hit| {
        if first.is_none_or(|best| hit.time_s < best.time_s) {
            first = Some(hit);
        }
    };
    for (a, b) in edges(still) {
        let normal = outward(a, b);
        let approach = normal.dot(&velocity);
        if approach < 0.0 {
            let time = (normal.dot(&(p - a)) - radius_m) / -approach;
            let along = (p + velocity * time - a).dot(&(b - a));
            if time >= 0.0 && (0.0..=(b - a).norm_squared()).contains(&along) {
                keep(Hit { time_s: time, normal });
            }
        }
        if let Some(hit) = sweep_point_disc(p, velocity, a, radius_m) {
            keep(hit);
        }
    }
    first
}

/// Unit vector from the nearest point of the outline to `p`, outwards also from inside.
fn outward_at(corners: &[Vec2], p: Vec2) -> Vec2 {
    let d = p - nearest_point(corners, p);
    if d.norm_squared() > 0.0 {
        return d / d.norm();
    }
    let mut best = (f64::NEG_INFINITY, Vec2::zeros());
    for (a, b) in edges(corners) {
        let normal = outward(a, b);
        let depth = normal.dot(&(p - a));
        if depth > best.0 {
            best = (depth, normal);
        }
    }
    best.1
}

/// Largest overhangs of the discs of a cover, as shares of the inradius; the first that suffices is taken.
const OVERHANGS: [f64; 7] = [0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5];
/// Largest numbers of discs of a cover, each tried with all overhangs: look-ups cost time, but slender outlines need more.
const DISCS_MAX: [usize; 3] = [8, 16, 32];
/// Intervals a side of the lattice of points that are covered.
const POINTS: i32 = 40;
/// Intervals a side of the lattice of candidates for the centres.
const CENTRES: i32 = 16;

/// Discs that cover a polygon, chosen greedily: from those that stick out by a given overhang, the one that covers most of
/// the points not covered yet. If no choice suffices, the disc about the origin.
fn cover(corners: &[Vec2], inradius_m: f64) -> Vec<Disc> {
    let around = bounds(corners);
    let size = around.max - around.min;
    let lattice = |count: i32| {
        let share = move |k: i32| f64::from(k) / f64::from(count);
        let point = move |row, col| around.min + Vec2::new(size.x * share(col), size.y * share(row));
        (0..=count).flat_map(move |row| (0..=count).map(move |col| point(row, col)))
    };
    // No point of the polygon is farther than this from one of `points`: half a diagonal of the lattice, whose points
    // beyond the outline are moved to it.
    let reach_m = size.norm() / f64::from(2 * POINTS);
    let points = lattice(POINTS).filter(|&p| point_distance(corners, p) <= reach_m);
    let points: Vec<Vec2> = points.map(|p| nearest_point(corners, p)).collect();
    let depth = |p: Vec2| -point_distance(corners, p);
    let centres = lattice(CENTRES).chain([Vec2::zeros()]).map(|p| (p, depth(p)));
    let centres: Vec<(Vec2, f64)> = centres.filter(|&(_, depth)| depth > 0.0).collect();
    for discs_max in DISCS_MAX {
        for overhang in OVERHANGS {
            let candidates =
                centres.iter().map(|&(centre, depth)| Disc { centre, radius_m: depth + overhang * inradius_m });
            let covers = |disc: &Disc, p: Vec2| (p - disc.centre).norm() <= disc.radius_m - reach_m;
            let (mut open, mut discs) = (points.clone(), Vec::new());
            while !open.is_empty() && discs.len() < discs_max {
                let count = |disc: &Disc| open.iter().filter(|&&p| covers(disc, p)).count();
                // The first of equals.
                let best =
                    candidates.clone().map(|disc| (count(&disc), disc)).reduce(|a, b| if b.0 > a.0 { b } else { a });
                let Some((1.., disc)) = best else { break };
                open.retain(|&p| !covers(&disc, p));
                discs.push(disc);
            }
            if open.is_empty() {
                return discs;
            }
        }
    }
    let radius_m = corners.iter().map(|corner| corner.norm()).fold(0.0, math::max);
    vec![Disc { centre: Vec2::zeros(), radius_m }]
}
