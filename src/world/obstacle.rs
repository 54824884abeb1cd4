//! Obstacles: their shapes, exact distances to them, and which cells they touch.

use super::motion::Motion;
use super::spec::ShapeChoice;
use super::spec::moving::{OnRobot, OnStatic};
use crate::geometry::{Pose, Rect, Vec2, direction};
use crate::math;

/// Two shapes touch where they overlap by more than this, m: shapes that share an edge do not touch,
/// whatever the rounding of their coordinates.
pub(super) const SLACK_M: f64 = 1e-9;

/// Outline of an obstacle about its own origin.
#[derive(Clone, Copy, Debug, PartialEq)]
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
}

impl Shape {
    /// Radius of the smallest disc about the origin that holds the shape, m.
    pub fn circumradius_m(&self) -> f64 {
        match *self {
            Self::Disc { radius_m } => radius_m,
            Self::Rectangle { half_m } => half_m.norm(),
        }
    }
}

impl From<&ShapeChoice> for Shape {
    fn from(choice: &ShapeChoice) -> Self {
        match choice {
            ShapeChoice::disc(disc) => Self::Disc { radius_m: disc.radius_m.get() },
            ShapeChoice::rectangle(rectangle) => {
                let [a, b] = rectangle.size_m.map(|side| 0.5 * side.get());
                Self::Rectangle { half_m: Vec2::new(a, b) }
            }
        }
    }
}

/// An obstacle that stands still and is not on the known map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnknownStatic {
    pose: Pose,
    shape: Shape,
    /// Direction of the shape's own x axis, kept because distances need it every tick.
    axis: Vec2,
    present: bool,
}

impl UnknownStatic {
    /// The obstacle of that shape with its centre at `pose` (grid frame).
    pub fn new(pose: Pose, shape: Shape) -> Self {
        Self { pose, shape, axis: direction(pose.theta), present: true }
    }

    /// Pose of the centre, grid frame.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// The outline.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// The same obstacle, there or not.
    #[must_use]
    pub fn with_presence(self, present: bool) -> Self {
        Self { present, ..self }
    }

    /// Whether it is there; one that is not is in nobody's way.
    pub fn is_present(&self) -> bool {
        self.present
    }

    /// Signed distance from the point `p` (grid frame) to the outline, m: negative inside; infinite while it is away.
    pub fn distance_m(&self, p: Vec2) -> f64 {
        if !self.present {
            return f64::INFINITY;
        }
        match self.shape {
            Shape::Disc { radius_m } => (p - self.pose.position).norm() - radius_m,
            Shape::Rectangle { half_m } => centred(half_m).signed_distance(self.in_own_frame(p - self.pose.position)),
        }
    }

    /// The smallest axis-aligned rectangle around the obstacle, grid frame.
    pub fn bounds(&self) -> Rect {
        let reach = match self.shape {
            Shape::Disc { radius_m } => Vec2::new(radius_m, radius_m),
            Shape::Rectangle { half_m } => {
                let (cos, sin) = (self.axis.x.abs(), self.axis.y.abs());
                Vec2::new(cos * half_m.x + sin * half_m.y, sin * half_m.x + cos * half_m.y)
            }
        };
        Rect { min: self.pose.position - reach, max: self.pose.position + reach }
    }

    /// Whether the obstacle and the square (or rectangle) `square` overlap, by more than a nanometre: sharing an
    /// edge or a corner is not touching, so that an obstacle of exactly one cell occupies one cell.
    ///
    /// Rectangles by the separating axes of both.
    pub fn touches(&self, square: Rect) -> bool {
        match self.shape {
            Shape::Disc { radius_m } => square.signed_distance(self.pose.position) < radius_m - SLACK_M,
            Shape::Rectangle { half_m } => {
                let square_half = 0.5 * (square.max - square.min);
                let offset = 0.5 * (square.max + square.min) - self.pose.position;
                let (cos, sin) = (self.axis.x.abs(), self.axis.y.abs());
                let own = self.in_own_frame(offset);
                // Along each axis: the centres' distance against the sum of the two reaches.
                let overlaps = |distance: f64, reach: f64| distance.abs() < reach - SLACK_M;
                overlaps(offset.x, square_half.x + cos * half_m.x + sin * half_m.y)
                    && overlaps(offset.y, square_half.y + sin * half_m.x + cos * half_m.y)
                    && overlaps(own.x, half_m.x + cos * square_half.x + sin * square_half.y)
                    && overlaps(own.y, half_m.y + sin * square_half.x + cos * square_half.y)
            }
        }
    }

    /// First contact of a disc that moves from `p` with `velocity`: see [`sweep_disc_rect`].
    pub(super) fn sweep_disc(&self, p: Vec2, velocity: Vec2, radius_m: f64) -> Option<Hit> {
        if !self.present {
            return None;
        }
        match self.shape {
            Shape::Disc { radius_m: own } => sweep_point_disc(p, velocity, self.pose.position, own + radius_m),
            Shape::Rectangle { half_m } => {
                let (own, own_velocity) = (self.in_own_frame(p - self.pose.position), self.in_own_frame(velocity));
                let hit = sweep_disc_rect(own, own_velocity, radius_m, centred(half_m))?;
                Some(Hit { normal: self.out_of_own_frame(hit.normal), ..hit })
            }
        }
    }

    pub(super) fn in_own_frame(self, d: Vec2) -> Vec2 {
        Vec2::new(self.axis.x * d.x + self.axis.y * d.y, self.axis.x * d.y - self.axis.y * d.x)
    }

    pub(super) fn out_of_own_frame(self, d: Vec2) -> Vec2 {
        Vec2::new(self.axis.x * d.x - self.axis.y * d.y, self.axis.y * d.x + self.axis.x * d.y)
    }
}

fn centred(half: Vec2) -> Rect {
    Rect { min: -half, max: half }
}

/// A moving obstacle: a disc.
#[derive(Clone, Debug, PartialEq)]
pub struct Mover {
    /// Centre, grid frame, m.
    pub position: Vec2,
    /// Velocity at this moment, m/s; zero while it yields or after it has stopped.
    pub velocity: Vec2,
    /// Radius, m.
    pub radius_m: f64,
    /// What it does at a static obstacle or the map's edge.
    pub on_static: OnStatic,
    /// What it does about the robot.
    pub on_robot: OnRobot,
    /// Surface distance within which it stops for a robot ahead, if it yields, m.
    pub yield_distance_m: f64,
    /// How it chooses its way.
    pub motion: Motion,
    /// Whether it is there at all; else nothing senses it and nothing touches it.
    pub present: bool,
}

impl Mover {
    /// A mover that bounces off statics and ignores the robot.
    pub fn new(position: Vec2, velocity: Vec2, radius_m: f64) -> Self {
        let (on_static, on_robot) = (OnStatic::Reflect, OnRobot::Ignore);
        let (motion, present) = (Motion::Uniform, true);
        Self { position, velocity, radius_m, on_static, on_robot, yield_distance_m: 1.0, motion, present }
    }
}

/// First contact of a moving disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Hit {
    /// When, s.
    pub(super) time_s: f64,
    /// Unit vector from the obstacle's surface to the disc's centre.
    pub(super) normal: Vec2,
}

/// First contact of a disc of `radius` that moves from `p` with `velocity`, with a rectangle.
///
/// Closed form: the point `p` against the four faces, moved out by the radius, and the four corners as
/// discs. At time 0 where they touch already and approach; `None` where they part or never meet.
pub(super) fn sweep_disc_rect(p: Vec2, velocity: Vec2, radius: f64, rect: Rect) -> Option<Hit> {
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
pub(super) fn sweep_point_disc(p: Vec2, velocity: Vec2, centre: Vec2, radius: f64) -> Option<Hit> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{EpisodeSeed, Purpose, Stream};
    use rapier2d::parry::query;
    use rapier2d::prelude::{Ball, Cuboid, Pose as RapierPose, Vector};

    fn stream(seed: u64) -> Stream {
        EpisodeSeed { seed, episode: 0 }.stream(Purpose::Planner, 0)
    }

    fn random_obstacle(stream: &mut Stream) -> UnknownStatic {
        let pose = Pose::new(stream.range(-2.0, 2.0), stream.range(-2.0, 2.0), stream.range(-4.0, 4.0));
        let shape = if stream.uniform() < 0.3 {
            Shape::Disc { radius_m: stream.range(0.05, 1.0) }
        } else {
            Shape::Rectangle { half_m: Vec2::new(stream.range(0.05, 1.5), stream.range(0.05, 1.0)) }
        };
        UnknownStatic::new(pose, shape)
    }

    fn parry_pose(pose: Pose) -> RapierPose {
        RapierPose::new(Vector::new(pose.position.x as f32, pose.position.y as f32), pose.theta as f32)
    }

    fn parry_shape(shape: Shape) -> Box<dyn rapier2d::parry::shape::Shape> {
        match shape {
            Shape::Disc { radius_m } => Box::new(Ball::new(radius_m as f32)),
            Shape::Rectangle { half_m } => Box::new(Cuboid::new(Vector::new(half_m.x as f32, half_m.y as f32))),
        }
    }

    #[test]
    fn distances_equal_those_of_parry() {
        let mut stream = stream(1);
        for _ in 0..20_000 {
            let obstacle = random_obstacle(&mut stream);
            let p = Vec2::new(stream.range(-4.0, 4.0), stream.range(-4.0, 4.0));
            let shape = parry_shape(obstacle.shape());
            let theirs = shape.distance_to_point(
                &parry_pose(obstacle.pose()),
                Vector::new(p.x as f32, p.y as f32),
                false, // hollow: the distance to the outline, also from inside
            );
            let ours = obstacle.distance_m(p);
            assert!((ours.abs() - f64::from(theirs).abs()).abs() < 1e-5, "{ours} {theirs} {obstacle:?} {p:?}");
        }
    }

    #[test]
    fn touching_a_square_equals_an_intersection_of_parry() {
        let (mut stream, mut touching) = (stream(2), 0);
        for _ in 0..20_000 {
            let obstacle = random_obstacle(&mut stream);
            let (x, y, side) = (stream.range(-3.0, 3.0), stream.range(-3.0, 3.0), stream.range(0.05, 1.0));
            let square = Rect { min: Vec2::new(x, y), max: Vec2::new(x + side, y + side) };
            let cuboid = Cuboid::new(Vector::new(0.5 * side as f32, 0.5 * side as f32));
            let pose = RapierPose::from_translation(Vector::new((x + 0.5 * side) as f32, (y + 0.5 * side) as f32));
            let shape = parry_shape(obstacle.shape());
            let contact = query::contact(&parry_pose(obstacle.pose()), &*shape, &pose, &cuboid, 1.0).unwrap();
            let depth = contact.map_or(-1.0, |contact| -contact.dist);
            if depth.abs() > 1e-4 {
                assert_eq!(obstacle.touches(square), depth > 0.0, "{obstacle:?} {square:?} {depth}");
                touching += i32::from(depth > 0.0);
            }
            // Whatever it touches, its bounds meet.
            if obstacle.touches(square) {
                let bounds = obstacle.bounds();
                assert!(bounds.min.x < square.max.x && bounds.max.x > square.min.x);
                assert!(bounds.min.y < square.max.y && bounds.max.y > square.min.y);
            }
        }
        assert!(touching > 1500, "{touching}");
    }

    #[test]
    fn an_obstacle_of_one_cell_touches_one_cell() {
        // 0.1 m has no exact binary form: edges of neighbours differ in the last bit.
        for (side, col) in [(1.0, 3), (0.1, 7), (0.05, 123)] {
            let at = |k: i32| Vec2::new(f64::from(col + k) * side, f64::from(col) * side);
            let square = |k: i32| Rect { min: at(k), max: at(k) + Vec2::new(side, side) };
            let centre = at(0) + Vec2::new(0.5 * side, 0.5 * side);
            let half_m = Vec2::new(0.5 * side, 0.5 * side);
            let cell = UnknownStatic::new(Pose { position: centre, theta: 0.0 }, Shape::Rectangle { half_m });
            assert!(cell.touches(square(0)) && !cell.touches(square(1)) && !cell.touches(square(-1)));
        }
    }

    #[test]
    fn first_contacts_of_a_moving_disc_are_exact() {
        let (mut stream, mut hits) = (stream(3), 0);
        for _ in 0..5000 {
            let obstacle = random_obstacle(&mut stream);
            let p = Vec2::new(stream.range(-4.0, 4.0), stream.range(-4.0, 4.0));
            let velocity = stream.range(0.1, 5.0) * direction(stream.range(-4.0, 4.0));
            let radius = stream.range(0.05, 0.5);
            if obstacle.distance_m(p) < radius {
                continue;
            }
            let gap = |t: f64| obstacle.distance_m(p + velocity * t) - radius;
            let hit = obstacle.sweep_disc(p, velocity, radius);
            let until = hit.map_or(3.0, |hit| hit.time_s);
            for k in 0..300 {
                let t = until * f64::from(k) / 300.0;
                assert!(gap(t) > -1e-9, "overlap of {} before the contact", -gap(t));
            }
            if let Some(hit) = hit {
                hits += 1;
                assert!(gap(hit.time_s).abs() < 1e-9, "{}", gap(hit.time_s));
                // The normal is the gradient of the distance there, and the disc approaches against it.
                let at = p + velocity * hit.time_s;
                assert!((obstacle.distance_m(at + 1e-4 * hit.normal) - radius - 1e-4).abs() < 1e-7);
                assert!(velocity.dot(&hit.normal) < 0.0 && (hit.normal.norm() - 1.0).abs() < 1e-12);
            }
        }
        assert!(hits > 500, "{hits}");
    }
}
