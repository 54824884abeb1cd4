//! Convex polygons: exact distances, first contacts of straight motion, and discs that cover them.
//!
//! Points are metres; corners are in counter-clockwise order. Signed distances are negative where two bodies overlap: then
//! they are minus the least translation that parts them.

use super::outline::{Hit, sweep_point_disc};
use super::{Rect, Vec2, closest_on_segment, cross, point_segment_distance};
use crate::math;
use std::sync::{Arc, OnceLock};

/// Most corners of a polygon.
pub const CORNERS_MAX: usize = 16;

/// Corners nearer to the line of their neighbours than this do not count as corners, m.
const STRAIGHT_M: f64 = 1e-9;

/// A convex polygon about its own origin, which lies inside. Cheap to copy.
#[derive(Clone, Debug)]
pub struct Polygon(Arc<Parts>);

#[derive(Debug)]
struct Parts {
    corners: Vec<Vec2>,
    circumradius_m: f64,
    inradius_m: f64,
    /// Worked out when it is first asked for.
    cover: OnceLock<Vec<Disc>>,
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
            return Err(format!("expected 3 to {CORNERS_MAX} corners, found {count}"));
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
                    "expected corners of a convex outline in order, found no bend outwards at [{}, {}]",
                    b.x, b.y
                ));
            }
            round += math::atan2(turn, ab.dot(&bc));
        }
        if round > 1.5 * math::TAU {
            return Err("expected a convex outline, found one that winds round more than once".to_owned());
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
    /// that from the polygon. For those who look up distances of points.
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
    /// The same corners, each moved by what `f` makes of it, which must be a rigid motion.
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

/// The largest distance by which all of `b` lies beyond the line of an edge of `a`, m; negative where none does.
fn separation(a: &[Vec2], b: &[Vec2]) -> f64 {
    let beyond = |(p, q)| {
        let normal = outward(p, q);
        b.iter().map(|corner| normal.dot(&(corner - p))).fold(f64::INFINITY, math::min)
    };
    edges(a).map(beyond).fold(f64::NEG_INFINITY, math::max)
}

/// When a ray enters a convex body and when it leaves it again, in units of the ray's speed; `None` where it misses.
/// The body is the intersection of half planes `normal · x ≤ offset`; the normal is that of the face of entry, zero
/// where the ray begins inside.
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
/// contact, which points from `still` to `moving`. At time 0 where they overlap already and approach; `None`
/// where they part or never meet.
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

/// How far the discs of a cover may stick out, as shares of the inradius: the first that will do is taken.
const OVERHANGS: [f64; 7] = [0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5];
/// How many discs a cover may have, each tried with all overhangs: look-ups cost, and slender outlines need more.
const DISCS_MAX: [usize; 3] = [8, 16, 32];
/// Intervals a side of the lattice of points that are covered.
const POINTS: i32 = 40;
/// Intervals a side of the lattice of candidates for the centres.
const CENTRES: i32 = 16;

/// Discs that cover a polygon, chosen greedily: from those that stick out by a given overhang, the one that covers most of
/// what is not covered yet. Where nothing will do, the disc about the origin.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::direction;
    use crate::rng::{EpisodeSeed, Purpose, Stream};
    use rapier2d::parry::query;
    use rapier2d::parry::shape::ConvexPolygon;
    use rapier2d::prelude::{Pose as RapierPose, Vector};

    fn stream(seed: u64) -> Stream {
        EpisodeSeed { seed, episode: 0 }.stream(Purpose::Planner, 0)
    }

    /// Points on an ellipse are convex.
    fn random_polygon(stream: &mut Stream) -> Polygon {
        loop {
            let count = 3 + stream.index(6);
            let (a, b) = (stream.range(0.2, 1.0), stream.range(0.2, 1.0));
            let mut angles: Vec<f64> = (0..count).map(|_| stream.range(-math::PI, math::PI)).collect();
            angles.sort_by(f64::total_cmp);
            let corners: Vec<Vec2> =
                angles.iter().map(|&angle| Vec2::new(a * math::cos(angle), b * math::sin(angle))).collect();
            if let Ok(polygon) = Polygon::new(&corners)
                && polygon.inradius_m() > 0.02
            {
                return polygon;
            }
        }
    }

    fn placed(stream: &mut Stream, polygon: &Polygon, range_m: f64) -> Corners {
        let position = Vec2::new(stream.range(-range_m, range_m), stream.range(-range_m, range_m));
        polygon.placed(position, direction(stream.range(-math::PI, math::PI)))
    }

    fn parry(corners: &[Vec2]) -> ConvexPolygon {
        let points = corners.iter().map(|p| Vector::new(p.x as f32, p.y as f32)).collect();
        ConvexPolygon::from_convex_polyline_unmodified(points).expect("convex")
    }

    const SPACING_M: f64 = 0.01;

    /// Points of an outline, no two neighbours farther apart than twice the spacing.
    fn outline(corners: &[Vec2]) -> impl Iterator<Item = Vec2> + '_ {
        edges(corners).flat_map(|(a, b)| {
            let count = ((b - a).norm() / (2.0 * SPACING_M)).ceil().max(1.0);
            (0..count as u32).map(move |k| a + (b - a) * (f64::from(k) / count))
        })
    }

    #[test]
    fn distances_equal_those_of_sampled_outlines_and_depths_part_the_two() {
        let mut stream = stream(1);
        let (mut apart, mut overlapping) = (0, 0);
        for _ in 0..20_000 {
            let (p, q) = (random_polygon(&mut stream), random_polygon(&mut stream));
            let (a, b) = (placed(&mut stream, &p, 1.2), placed(&mut stream, &q, 1.2));
            let ours = distance(&a, &b);
            assert!((ours - distance(&b, &a)).abs() < 1e-12);
            let sampled = outline(&a).map(|p| point_distance(&b, p)).fold(f64::INFINITY, math::min);
            if ours > 0.0 {
                apart += 1;
                assert!(ours <= sampled + 1e-12 && sampled <= ours + SPACING_M, "{ours} {sampled}");
                // Which iterates in single precision.
                let still = RapierPose::IDENTITY;
                let parry = query::distance(&still, &parry(&a), &still, &parry(&b)).expect("supported").distance;
                assert!((ours - f64::from(parry)).abs() < 5e-3, "{ours} {parry}");
            } else {
                overlapping += 1;
                // Their outlines cross, or one lies within the other.
                assert!(sampled < SPACING_M || outline(&b).all(|p| point_distance(&a, p) < 0.0), "{ours} {sampled}");
                // No shorter translation parts them, and one of that length does.
                let parts = |length: f64| {
                    (0..3600).any(|k| {
                        let shift = length * direction(math::TAU * f64::from(k) / 3600.0);
                        distance(&a.map(|p| p + shift), &b) >= 0.0
                    })
                };
                if overlapping < 40 {
                    assert!(parts(-1.001 * ours + 1e-6) && !parts(-0.99 * ours - 1e-6), "{ours}");
                }
            }
        }
        assert!(apart > 2000 && overlapping > 2000, "{apart} {overlapping}");
    }

    #[test]
    fn distances_of_points_equal_those_of_sampled_outlines_and_rays_end_on_them() {
        let (mut stream, mut hits) = (stream(2), 0);
        for _ in 0..20_000 {
            let polygon = random_polygon(&mut stream);
            let corners = placed(&mut stream, &polygon, 0.5);
            let p = Vec2::new(stream.range(-2.0, 2.0), stream.range(-2.0, 2.0));
            let ours = point_distance(&corners, p);
            let sampled = outline(&corners).map(|q| (p - q).norm()).fold(f64::INFINITY, math::min);
            assert!(ours.abs() <= sampled + 1e-12 && sampled <= ours.abs() + SPACING_M, "{ours} {sampled}");
            // Inside where the outline winds round the point once.
            let turns: f64 =
                edges(&corners).map(|(a, b)| math::atan2(cross(a - p, b - p), (a - p).dot(&(b - p)))).sum();
            assert_eq!(ours < 0.0, turns > math::PI, "{ours} {turns}");
            let near = nearest_point(&corners, p);
            assert!(((p - near).norm() - math::max(ours, 0.0)).abs() < 1e-9);
            let unit = direction(stream.range(-math::PI, math::PI));
            let hit = cast_ray(&corners, p, unit);
            let clear =
                |until: f64| (0..200).all(|k| point_distance(&corners, p + unit * until * f64::from(k) / 200.0) > 0.0);
            if ours <= 0.0 {
                assert_eq!(hit, 0.0);
            } else if hit.is_finite() {
                hits += 1;
                assert!(clear(hit) && point_distance(&corners, p + unit * hit).abs() < 1e-9);
            } else {
                assert!(clear(8.0));
            }
        }
        assert!(hits > 2000, "{hits}");
    }

    #[test]
    fn first_contacts_leave_no_gap_and_no_overlap() {
        let (mut stream, mut hits) = (stream(3), 0);
        for case in 0..4000 {
            let (p, q) = (random_polygon(&mut stream), random_polygon(&mut stream));
            let (still, moving) = (placed(&mut stream, &p, 1.5), placed(&mut stream, &q, 1.5));
            let velocity = stream.range(0.1, 5.0) * direction(stream.range(-math::PI, math::PI));
            let (centre, radius) = (moving[0], stream.range(0.05, 0.5));
            let is_disc = case % 2 == 0;
            let gap = |t: f64| {
                if is_disc {
                    point_distance(&still, centre + velocity * t) - radius
                } else {
                    distance(&still, &moving.map(|p| p + velocity * t))
                }
            };
            if gap(0.0) < 0.0 {
                continue;
            }
            let hit =
                if is_disc { sweep_disc(centre, velocity, radius, &still) } else { sweep(&moving, velocity, &still) };
            let until = hit.map_or(3.0, |hit| hit.time_s);
            for k in 0..100 {
                let t = until * f64::from(k) / 100.0;
                assert!(gap(t) > -1e-9, "overlap of {} before the contact", -gap(t));
            }
            if let Some(Hit { time_s: time, normal }) = hit {
                hits += 1;
                assert!(gap(time).abs() < 1e-9, "{}", gap(time));
                assert!(velocity.dot(&normal) < 0.0 && (normal.norm() - 1.0).abs() < 1e-12);
                // A step back along the normal parts them by its length.
                let back = if is_disc {
                    point_distance(&still, centre + velocity * time + 1e-4 * normal) - radius
                } else {
                    distance(&still, &moving.map(|p| p + velocity * time + 1e-4 * normal))
                };
                assert!((back - 1e-4).abs() < 1e-7, "{back}");
            }
        }
        assert!(hits > 400, "{hits}");
    }

    #[test]
    fn overlapping_bodies_touch_at_once_unless_they_part() {
        let square = |x: f64| rectangle(Rect { min: Vec2::new(x, 0.0), max: Vec2::new(x + 1.0, 1.0) });
        let (still, moving) = (square(0.0), square(0.9));
        let out = Vec2::new(1.0, 0.0);
        let at_once = Some(Hit { time_s: 0.0, normal: out });
        assert_eq!(sweep(&moving, -out, &still), at_once);
        assert_eq!(sweep(&moving, out, &still), None);
        assert_eq!(sweep_disc(Vec2::new(1.2, 0.5), -out, 0.3, &still), at_once);
        assert_eq!(sweep_disc(Vec2::new(1.2, 0.5), out, 0.3, &still), None);
    }

    #[test]
    fn discs_cover_the_polygon_and_hardly_more() {
        let mut stream = stream(4);
        let half = |x: f64, y: f64| rectangle(Rect { min: Vec2::new(-x, -y), max: Vec2::new(x, y) }).to_vec();
        let mut polygons = vec![half(0.254, 0.215), half(0.6, 0.3), half(0.2, 0.2), half(1.0, 0.1)];
        polygons.extend((0..40).map(|_| random_polygon(&mut stream).corners().to_vec()));
        for corners in polygons {
            let polygon = Polygon::new(&corners).unwrap();
            let cover = polygon.cover();
            for _ in 0..4000 {
                let box_ = bounds(&corners);
                let p = Vec2::new(stream.range(box_.min.x, box_.max.x), stream.range(box_.min.y, box_.max.y));
                let p = nearest_point(polygon.corners(), p);
                let from_cover =
                    cover.iter().map(|d| (p - d.centre).norm() - d.radius_m).fold(f64::INFINITY, math::min);
                assert!(from_cover <= 1e-12, "{p:?} of {corners:?} is {from_cover} outside");
            }
            for disc in cover {
                let overhang = disc.radius_m + point_distance(polygon.corners(), disc.centre);
                assert!(cover.len() == 1 || overhang <= 0.5 * polygon.inradius_m() + 1e-12);
            }
            assert!(cover.len() <= 32);
        }
        // A Jackal's outline: within 5 cm of it everywhere.
        let jackal = Polygon::new(&half(0.254, 0.215)).unwrap();
        let overhang = |d: &Disc| d.radius_m + point_distance(jackal.corners(), d.centre);
        assert!(jackal.cover().iter().all(|disc| overhang(disc) < 0.05), "{:?}", jackal.cover());
    }

    #[test]
    fn outlines_that_are_not_convex_about_the_origin_are_refused() {
        let polygon =
            |corners: &[(f64, f64)]| Polygon::new(&corners.iter().map(|&(x, y)| Vec2::new(x, y)).collect::<Vec<_>>());
        assert!(polygon(&[(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)]).is_ok());
        let clockwise = polygon(&[(-1.0, -1.0), (0.0, 1.0), (1.0, -1.0)]).unwrap();
        assert!(
            cross(clockwise.corners()[1] - clockwise.corners()[0], clockwise.corners()[2] - clockwise.corners()[1])
                > 0.0
        );
        for (corners, says) in [
            (&[(-1.0, -1.0), (1.0, -1.0)][..], "3 to 16 corners, found 2"),
            (&[(-1.0, -1.0), (1.0, -1.0), (-0.2, -0.2), (-1.0, 1.0)], "no bend outwards at [-0.2, -0.2]"),
            (&[(-1.0, -1.0), (0.0, -1.0), (1.0, -1.0), (0.0, 1.0)], "no bend outwards at [0, -1]"),
            (&[(1.0, 1.0), (2.0, 1.0), (2.0, 2.0)], "[0, 0]"),
        ] {
            let message = polygon(corners).unwrap_err();
            assert!(message.contains(says), "{message}");
        }
        // A pentagram turns left at every corner, twice round.
        let star: Vec<Vec2> = (0..5).map(|k| direction(math::TAU * f64::from(2 * k) / 5.0)).collect();
        assert!(Polygon::new(&star).unwrap_err().contains("more than once"));
    }

    #[test]
    fn a_disc_meets_a_wall_after_its_closed_form() {
        // 2 m away at 1 m/s, radius 0.5: after 1.5 s.
        let wall = rectangle(Rect { min: Vec2::new(0.0, -1.0), max: Vec2::new(1.0, 1.0) });
        let hit = sweep_disc(Vec2::new(3.0, 0.0), Vec2::new(-1.0, 0.0), 0.5, &wall).unwrap();
        assert!((hit.time_s - 1.5).abs() < 1e-12 && hit.normal == Vec2::new(1.0, 0.0));
    }
}
