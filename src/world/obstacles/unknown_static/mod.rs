//! Obstacles that stand still and are not on the known map: one file per kind.

use super::Drawing;
use crate::geometry::outline::{Body, Hit, Outline, Shape};
use crate::geometry::{Pose, Rect, Vec2};
use crate::map::OccupancyGrid;
use crate::settings::{Entry, registry};
use crate::world::scene::{FreeSpace, Infeasible, SceneError};
use crate::world::statics::StaticMap;

registry! {
    /// An obstacle that stands still and is unknown until sensed.
    pub enum UnknownStaticChoice: "kind of unknown static obstacle", Entry, dyn UnknownStaticKind { fixed, random }
}

/// Behaviour of a kind of unknown static obstacle.
pub trait UnknownStaticKind {
    /// Checks everything that does not depend on a draw; `key` is that of the entry, such as `obstacles.unknown_static[0].fixed`.
    ///
    /// # Errors
    /// The first invalid parameter.
    fn check(&self, key: &str, map: &StaticMap) -> Result<(), SceneError>;

    /// The obstacle, if the scenario gives its pose: start, goal and everything drawn keep clear of it.
    fn given(&self, grid: &OccupancyGrid) -> Option<UnknownStatic> {
        let _ = grid;
        None
    }

    /// Whether obstacles are placed by the scene's reference route.
    fn needs_route(&self) -> bool {
        false
    }

    /// The obstacles of this entry.
    ///
    /// # Errors
    /// The first obstacle that found no place.
    fn draw(&self, drawing: &Drawing<'_>, space: &mut FreeSpace<'_>) -> Result<Vec<UnknownStatic>, Infeasible>;
}

/// An obstacle that stands still and is not on the known map.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownStatic {
    pose: Pose,
    outline: Outline,
    present: bool,
}

impl UnknownStatic {
    /// The obstacle of that shape with its centre at `pose` (grid frame).
    pub fn new(pose: Pose, shape: Shape) -> Self {
        Self { pose, outline: Outline::new(shape, pose.theta), present: true }
    }

    /// Pose of the centre, grid frame.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// The outline, about that pose's position.
    pub fn outline(&self) -> &Outline {
        &self.outline
    }

    /// The shape.
    pub fn shape(&self) -> &Shape {
        self.outline.shape()
    }

    /// The same obstacle, present or absent.
    #[must_use]
    pub fn with_presence(self, present: bool) -> Self {
        Self { present, ..self }
    }

    /// Makes it present or absent.
    pub(in crate::world) fn set_presence(&mut self, present: bool) {
        self.present = present;
    }

    /// Whether it is present; an absent obstacle is in nobody's way.
    pub fn is_present(&self) -> bool {
        self.present
    }

    /// Signed distance from the point `p` (grid frame) to the outline, m: negative inside; infinite while it is absent.
    pub fn distance_m(&self, p: Vec2) -> f64 {
        if self.present { self.outline.distance_m(self.pose.position, p) } else { f64::INFINITY }
    }

    /// Signed distance between a body and the outline, m: negative if they overlap; infinite while it is absent.
    pub fn gap_m(&self, body: &Body) -> f64 {
        if self.present { self.outline.gap_m(self.pose.position, body) } else { f64::INFINITY }
    }

    /// The smallest axis-aligned rectangle around the obstacle, grid frame.
    pub fn bounds(&self) -> Rect {
        self.outline.bounds(self.pose.position)
    }

    /// Whether the obstacle and the square (or rectangle) `square` overlap, see [`Outline::touches`].
    pub fn touches(&self, square: Rect) -> bool {
        self.outline.touches(self.pose.position, square)
    }

    /// First contact of an outline that moves from `p` with `velocity`.
    pub(in crate::world) fn sweep(&self, moving: &Outline, p: Vec2, velocity: Vec2) -> Option<Hit> {
        if self.present { self.outline.sweep(self.pose.position, moving, p, velocity) } else { None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::convex::Polygon;
    use crate::geometry::direction;
    use crate::rng::{EpisodeSeed, Purpose, Stream};
    use rapier2d::parry::query;
    use rapier2d::parry::shape::ConvexPolygon;
    use rapier2d::prelude::{Ball, Cuboid, Pose as RapierPose, Vector};

    fn stream(seed: u64) -> Stream {
        EpisodeSeed { seed, episode: 0 }.stream(Purpose::Planner, 0)
    }

    fn random_obstacle(stream: &mut Stream) -> UnknownStatic {
        let pose = Pose::new(stream.range(-2.0, 2.0), stream.range(-2.0, 2.0), stream.range(-4.0, 4.0));
        let shape = match stream.index(3) {
            0 => Shape::Disc { radius_m: stream.range(0.05, 1.0) },
            1 => Shape::Rectangle { half_m: Vec2::new(stream.range(0.05, 1.5), stream.range(0.05, 1.0)) },
            _ => Shape::Polygon(random_polygon(stream)),
        };
        UnknownStatic::new(pose, shape)
    }

    fn parry_pose(pose: Pose) -> RapierPose {
        RapierPose::new(Vector::new(pose.position.x as f32, pose.position.y as f32), pose.theta as f32)
    }

    /// A wedge with its tip ahead.
    fn random_polygon(stream: &mut Stream) -> Polygon {
        let (ahead, behind) = (stream.range(0.1, 1.5), stream.range(-1.0, -0.1));
        let (left, right) = (stream.range(0.1, 1.0), stream.range(-1.0, -0.1));
        let corners = [(ahead, 0.0), (0.0, left), (behind, 0.5 * left), (behind, right), (0.0, 1.1 * right)];
        Polygon::new(&corners.map(|(x, y)| Vec2::new(x, y))).expect("convex")
    }

    fn parry_shape(shape: &Shape) -> Box<dyn rapier2d::parry::shape::Shape> {
        match shape {
            Shape::Disc { radius_m } => Box::new(Ball::new(*radius_m as f32)),
            Shape::Rectangle { half_m } => Box::new(Cuboid::new(Vector::new(half_m.x as f32, half_m.y as f32))),
            Shape::Polygon(polygon) => {
                let corners = polygon.corners().iter().map(|c| Vector::new(c.x as f32, c.y as f32)).collect();
                Box::new(ConvexPolygon::from_convex_polyline_unmodified(corners).expect("convex"))
            }
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
            // The distance to a polygon it finds by iteration in single precision, and the depth inside one hardly at all:
            // `geometry::convex` has an oracle of its own.
            let is_polygon = matches!(obstacle.shape(), Shape::Polygon(_));
            if is_polygon && ours < 0.0 {
                continue;
            }
            let tolerance = if is_polygon { 5e-3 } else { 1e-5 };
            assert!((ours.abs() - f64::from(theirs).abs()).abs() < tolerance, "{ours} {theirs} {obstacle:?} {p:?}");
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
            let hit = obstacle.sweep(&Outline::disc(radius), p, velocity);
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
