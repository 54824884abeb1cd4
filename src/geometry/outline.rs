//! Outlines of bodies: discs, rectangles and convex polygons with a heading, exact distances to them, first contacts.

use super::convex::{self, Corners, Polygon, turned, turned_back};
use super::{Rect, Vec2, direction};
use crate::math;
use serde::{Deserialize, Serialize};

/// Two outlines touch where they overlap by more than this, m: shapes that share an edge do not touch,
/// whatever the rounding of their coordinates.
pub const SLACK_M: f64 = 1e-9;

/// The shape of a body about its own origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// A disc.
    Disc {
        /// Radius, m.
        radius_m: f64,
    },
    /// A rectangle, half its sides along its own x and y.
    Rectangle {
        /// Half of the two sides, m.
        half_m: Vec2,
    },
    /// A convex polygon that holds its origin.
    Polygon(Polygon),
}

impl Shape {
    /// Radius of the smallest disc about the origin that holds the shape, m.
    pub fn circumradius_m(&self) -> f64 {
        match self {
            Self::Disc { radius_m } => *radius_m,
            Self::Rectangle { half_m } => half_m.norm(),
            Self::Polygon(polygon) => polygon.circumradius_m(),
        }
    }

    /// Radius of the largest disc about the origin that the shape holds, m.
    pub fn inradius_m(&self) -> f64 {
        match self {
            Self::Disc { radius_m } => *radius_m,
            Self::Rectangle { half_m } => math::min(half_m.x, half_m.y),
            Self::Polygon(polygon) => polygon.inradius_m(),
        }
    }
}

/// A shape with a heading. Its position is an argument of the methods: `centre` is the place of its origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outline {
    shape: Shape,
    /// Direction of the shape's own x axis, kept because distances need it every tick.
    axis: Vec2,
}

impl Outline {
    /// The shape with its x axis at the angle `theta`, rad.
    pub fn new(shape: Shape, theta: f64) -> Self {
        Self { shape, axis: direction(theta) }
    }

    /// A disc.
    pub fn disc(radius_m: f64) -> Self {
        Self { shape: Shape::Disc { radius_m }, axis: Vec2::new(1.0, 0.0) }
    }

    /// The shape.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Unit vector of the shape's own x axis.
    pub fn axis(&self) -> Vec2 {
        self.axis
    }

    /// The same shape with another x axis, a unit vector.
    #[must_use]
    pub fn with_axis(self, axis: Vec2) -> Self {
        Self { axis, ..self }
    }

    /// Radius of the smallest disc about the origin that holds it, m.
    pub fn circumradius_m(&self) -> f64 {
        self.shape.circumradius_m()
    }

    /// The same a little smaller: no point of it moves by more than [`SLACK_M`]. What slides along a wall does not touch it.
    #[must_use]
    pub fn with_slack(&self) -> Self {
        let scale = 1.0 - SLACK_M / self.circumradius_m();
        let shape = match &self.shape {
            Shape::Disc { radius_m } => Shape::Disc { radius_m: radius_m - SLACK_M },
            Shape::Rectangle { half_m } => Shape::Rectangle { half_m: half_m * scale },
            Shape::Polygon(polygon) => Shape::Polygon(polygon.scaled(scale)),
        };
        Self { shape, axis: self.axis }
    }

    /// The corners; a disc has none.
    pub fn corners(&self, centre: Vec2) -> Option<Corners> {
        match &self.shape {
            Shape::Disc { .. } => None,
            Shape::Rectangle { half_m } => {
                let corners = Corners::from(convex::rectangle(centred(*half_m)));
                Some(corners.map(|corner| centre + turned(corner, self.axis)))
            }
            Shape::Polygon(polygon) => Some(polygon.placed(centre, self.axis)),
        }
    }

    /// Discs about points given from the centre whose union holds the outline and little more.
    pub fn cover(&self) -> impl Iterator<Item = (Vec2, f64)> + '_ {
        let (round, discs) = match &self.shape {
            Shape::Polygon(polygon) => (None, polygon.cover()),
            shape => (Some((Vec2::zeros(), shape.circumradius_m())), &[][..]),
        };
        round.into_iter().chain(discs.iter().map(|disc| (turned(disc.centre, self.axis), disc.radius_m)))
    }

    /// Signed distance from the point `p` to the outline, m: negative inside.
    pub fn distance_m(&self, centre: Vec2, p: Vec2) -> f64 {
        match &self.shape {
            Shape::Disc { radius_m } => (p - centre).norm() - radius_m,
            Shape::Rectangle { half_m } => centred(*half_m).signed_distance(turned_back(p - centre, self.axis)),
            Shape::Polygon(polygon) => convex::point_distance(polygon.corners(), turned_back(p - centre, self.axis)),
        }
    }

    /// Signed distance between the outline and a body, m: negative where they overlap.
    pub fn gap_m(&self, centre: Vec2, body: &Body) -> f64 {
        let Some(corners) = &body.corners else { return self.distance_m(centre, body.position) - body.radius_m };
        let corners = corners.map(|corner| turned_back(corner - centre, self.axis));
        match &self.shape {
            Shape::Disc { radius_m } => convex::point_distance(&corners, Vec2::zeros()) - radius_m,
            Shape::Rectangle { half_m } => convex::distance(&corners, &convex::rectangle(centred(*half_m))),
            Shape::Polygon(polygon) => convex::distance(&corners, polygon.corners()),
        }
    }

    /// The smallest axis-aligned rectangle around it.
    pub fn bounds(&self, centre: Vec2) -> Rect {
        let reach = match &self.shape {
            Shape::Disc { radius_m } => Vec2::new(*radius_m, *radius_m),
            Shape::Rectangle { half_m } => {
                let (cos, sin) = (self.axis.x.abs(), self.axis.y.abs());
                Vec2::new(cos * half_m.x + sin * half_m.y, sin * half_m.x + cos * half_m.y)
            }
            Shape::Polygon(polygon) => return convex::bounds(&polygon.placed(centre, self.axis)),
        };
        Rect { min: centre - reach, max: centre + reach }
    }

    /// Whether it overlaps the square (or rectangle) `square` by more than a nanometre: sharing an
    /// edge or a corner is not touching, so that an obstacle of exactly one cell occupies one cell.
    ///
    /// Rectangles by the separating axes of both.
    pub fn touches(&self, centre: Vec2, square: Rect) -> bool {
        match &self.shape {
            Shape::Disc { radius_m } => square.signed_distance(centre) < radius_m - SLACK_M,
            Shape::Rectangle { half_m } => {
                let square_half = 0.5 * (square.max - square.min);
                let offset = 0.5 * (square.max + square.min) - centre;
                let (cos, sin) = (self.axis.x.abs(), self.axis.y.abs());
                let own = turned_back(offset, self.axis);
                // Along each axis: the centres' distance against the sum of the two reaches.
                let overlaps = |distance: f64, reach: f64| distance.abs() < reach - SLACK_M;
                overlaps(offset.x, square_half.x + cos * half_m.x + sin * half_m.y)
                    && overlaps(offset.y, square_half.y + sin * half_m.x + cos * half_m.y)
                    && overlaps(own.x, half_m.x + cos * square_half.x + sin * square_half.y)
                    && overlaps(own.y, half_m.y + sin * square_half.x + cos * square_half.y)
            }
            Shape::Polygon(polygon) => {
                convex::distance(&polygon.placed(centre, self.axis), &convex::rectangle(square)) < -SLACK_M
            }
        }
    }

    /// The point of the outline that is nearest to `p`; `p` itself inside.
    pub fn nearest_point(&self, centre: Vec2, p: Vec2) -> Vec2 {
        let offset = p - centre;
        match &self.shape {
            Shape::Disc { radius_m } => {
                let away_m = offset.norm();
                if away_m <= *radius_m { p } else { centre + offset * (radius_m / away_m) }
            }
            Shape::Rectangle { half_m } => {
                let own = turned_back(offset, self.axis);
                let nearest =
                    Vec2::new(math::clamp(own.x, -half_m.x, half_m.x), math::clamp(own.y, -half_m.y, half_m.y));
                centre + turned(nearest, self.axis)
            }
            Shape::Polygon(polygon) => convex::nearest_point(&polygon.placed(centre, self.axis), p),
        }
    }

    /// Distance along a ray (unit vector `unit`), m: 0 inside, infinity where the ray misses.
    pub fn cast_ray(&self, centre: Vec2, from: Vec2, unit: Vec2) -> f64 {
        match &self.shape {
            Shape::Disc { radius_m } => cast_ray_disc(from, unit, centre, *radius_m),
            Shape::Rectangle { half_m } => {
                let (from, unit) = (turned_back(from - centre, self.axis), turned_back(unit, self.axis));
                cast_ray_rect(from, unit, centred(*half_m))
            }
            Shape::Polygon(polygon) => convex::cast_ray(&polygon.placed(centre, self.axis), from, unit),
        }
    }

    /// First contact of another outline that moves from `p` with `velocity`, with this one, which stands still.
    pub fn sweep(&self, centre: Vec2, moving: &Self, p: Vec2, velocity: Vec2) -> Option<Hit> {
        match (&self.shape, &moving.shape) {
            (Shape::Disc { radius_m: own }, Shape::Disc { radius_m }) => {
                sweep_point_disc(p, velocity, centre, own + radius_m)
            }
            (Shape::Rectangle { half_m }, Shape::Disc { radius_m }) => {
                let (own, own_velocity) = (turned_back(p - centre, self.axis), turned_back(velocity, self.axis));
                let hit = sweep_disc_rect(own, own_velocity, *radius_m, centred(*half_m))?;
                Some(Hit { normal: turned(hit.normal, self.axis), ..hit })
            }
            (Shape::Polygon(polygon), Shape::Disc { radius_m }) => {
                convex::sweep_disc(p, velocity, *radius_m, &polygon.placed(centre, self.axis))
            }
            // The disc against the other, seen from the other.
            (Shape::Disc { radius_m }, _) => {
                let hit = convex::sweep_disc(centre, -velocity, *radius_m, &moving.corners(p)?)?;
                Some(Hit { normal: -hit.normal, ..hit })
            }
            _ => convex::sweep(&moving.corners(p)?, velocity, &self.corners(centre)?),
        }
    }
}

/// The footprint of a body at one moment.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// Position of its centre, m.
    pub position: Vec2,
    /// Radius of the smallest disc about the centre that holds it, m.
    pub radius_m: f64,
    /// The corners; a disc has none.
    pub corners: Option<Corners>,
}

fn centred(half: Vec2) -> Rect {
    Rect { min: -half, max: half }
}

/// Distance along a ray to a disc, m: 0 inside it, infinity where the ray misses it.
fn cast_ray_disc(from: Vec2, unit: Vec2, centre: Vec2, radius_m: f64) -> f64 {
    let d = from - centre;
    let approach = d.dot(&unit);
    let beyond = d.norm_squared() - radius_m * radius_m;
    if beyond <= 0.0 {
        return 0.0;
    }
    let discriminant = approach * approach - beyond;
    // The form of the quadratic's smaller root that subtracts no like numbers.
    if approach >= 0.0 || discriminant < 0.0 { f64::INFINITY } else { beyond / (discriminant.sqrt() - approach) }
}

/// Distance along a ray to an axis-aligned rectangle, m, by its two slabs.
fn cast_ray_rect(from: Vec2, unit: Vec2, rect: Rect) -> f64 {
    let (mut enters, mut leaves) = (0.0, f64::INFINITY);
    for axis in [0, 1] {
        if unit[axis] == 0.0 {
            if from[axis] < rect.min[axis] || from[axis] > rect.max[axis] {
                return f64::INFINITY;
            }
            continue;
        }
        let (a, b) = ((rect.min[axis] - from[axis]) / unit[axis], (rect.max[axis] - from[axis]) / unit[axis]);
        enters = math::max(enters, math::min(a, b));
        leaves = math::min(leaves, math::max(a, b));
    }
    if enters <= leaves { enters } else { f64::INFINITY }
}

/// First contact of a moving body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Time of the contact, s.
    pub time_s: f64,
    /// Unit vector at the contact from the obstacle's surface to the body.
    pub normal: Vec2,
}

/// First contact of a disc of `radius` that moves from `p` with `velocity`, with a rectangle.
///
/// Closed form: the point `p` against the four faces, moved out by the radius, and the four corners as
/// discs. At time 0 if they touch already and approach; `None` if they move apart or never meet.
pub fn sweep_disc_rect(p: Vec2, velocity: Vec2, radius: f64, rect: Rect) -> Option<Hit> {
    if rect.signed_distance(p) <= radius {
        let normal = outward_normal(p, rect);
        return (velocity.dot(&normal) < 0.0).then_some(Hit { time_s: 0.0, normal });
    }
    let mut first: Option<Hit> = None;
    let mut keep = |hit: Hit| {
        if first.is_none_or(|best| hit.time_s < best.time_s) {
            first = Some(hit);
        }
    };
    for axis in [0, 1] {
        if velocity[axis] == 0.0 {
            continue;
        }
        let (face, sign) =
            if velocity[axis] > 0.0 { (rect.min[axis] - radius, -1.0) } else { (rect.max[axis] + radius, 1.0) };
        let time_s = (face - p[axis]) / velocity[axis];
        let other = 1 - axis;
        let along = p[other] + velocity[other] * time_s;
        if time_s >= 0.0 && along >= rect.min[other] && along <= rect.max[other] {
            let mut normal = Vec2::zeros();
            normal[axis] = sign;
            keep(Hit { time_s, normal });
        }
    }
    for corner in [rect.min, Vec2::new(rect.max.x, rect.min.y), rect.max, Vec2::new(rect.min.x, rect.max.y)] {
        if let Some(hit) = sweep_point_disc(p, velocity, corner, radius) {
            keep(hit);
        }
    }
    first
}

/// First contact of a point that moves from `p` with `velocity`, with the disc of `radius` about `centre`.
pub fn sweep_point_disc(p: Vec2, velocity: Vec2, centre: Vec2, radius: f64) -> Option<Hit> {
    let d = p - centre;
    let approach = d.dot(&velocity);
    if approach >= 0.0 {
        return None;
    }
    let beyond = d.norm_squared() - radius * radius;
    let time_s = if beyond <= 0.0 {
        0.0
    } else {
        let discriminant = approach * approach - velocity.norm_squared() * beyond;
        if discriminant < 0.0 {
            return None;
        }
        // The form of the quadratic's smaller root that subtracts no like numbers.
        beyond / (discriminant.sqrt() - approach)
    };
    let at = d + velocity * time_s;
    Some(Hit { time_s, normal: at / at.norm() })
}

/// Unit vector from the nearest point of the rectangle's boundary to `p`, pointing outwards also from inside.
fn outward_normal(p: Vec2, rect: Rect) -> Vec2 {
    let nearest = Vec2::new(math::clamp(p.x, rect.min.x, rect.max.x), math::clamp(p.y, rect.min.y, rect.max.y));
    let d = p - nearest;
    let distance = d.norm();
    if distance > 0.0 {
        return d / distance;
    }
    let depths = [
        (p.x - rect.min.x, Vec2::new(-1.0, 0.0)),
        (rect.max.x - p.x, Vec2::new(1.0, 0.0)),
        (p.y - rect.min.y, Vec2::new(0.0, -1.0)),
        (rect.max.y - p.y, Vec2::new(0.0, 1.0)),
    ];
    let mut best = depths[0];
    for depth in depths {
        if depth.0 < best.0 {
            best = depth;
        }
    }
    best.1
}
