//! Rays: the free distance in a direction.

use crate::geometry::Vec2;
use crate::math;
use crate::world::obstacles::unknown_static::UnknownStatic;
use crate::world::statics::StaticMap;

impl StaticMap {
    /// Distance from `from` (grid frame) along the unit vector `unit` to the first occupied square or the map's edge, m,
    /// at most `range_m`. 0 inside an occupied square and outside the map.
    ///
    /// Walks from cell to cell (Amanatides and Woo, 1987). The crossing of every grid line is computed from the ray's origin,
    /// so nothing adds up. A ray through a vertex goes on in the row above or below.
    pub fn cast_ray(&self, from: Vec2, unit: Vec2, range_m: f64) -> f64 {
        let grid = &self.grid;
        let side_m = grid.resolution_m();
        let mut cell = grid.cell_at(from);
        // Where the ray leaves a column or row.
        let leaves = |index: i32, from: f64, unit: f64| {
            if unit == 0.0 {
                return f64::INFINITY;
            }
            let line = if unit > 0.0 { index + 1 } else { index };
            (f64::from(line) * side_m - from) / unit
        };
        let mut away_m = 0.0;
        while away_m < range_m {
            // What is outside is not free.
            if !grid.is_free(cell) {
                return math::max(away_m, 0.0);
            }
            let (across, along) = (leaves(cell.col, from.x, unit.x), leaves(cell.row, from.y, unit.y));
            if across < along {
                cell.col += if unit.x > 0.0 { 1 } else { -1 };
                away_m = across;
            } else {
                cell.row += if unit.y > 0.0 { 1 } else { -1 };
                away_m = along;
            }
        }
        range_m
    }
}

impl UnknownStatic {
    /// Distance along a ray to the obstacle, m: 0 inside it, infinity if the ray misses it or it is absent.
    pub(super) fn cast_ray(&self, from: Vec2, unit: Vec2) -> f64 {
        if self.is_present() { self.outline().cast_ray(self.pose().position, from, unit) } else { f64::INFINITY }
    }

    /// The point of the outline that is nearest to `p`; `p` itself inside.
    pub(super) fn nearest_point(&self, p: Vec2) -> Vec2 {
        self.outline().nearest_point(self.pose().position, p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::outline::Shape;
    use crate::geometry::{Pose, direction};
    use crate::map::OccupancyGrid;
    use crate::rng::{EpisodeSeed, Purpose, Stream};
    use rapier2d::parry::query::{Ray, RayCast as _};
    use rapier2d::prelude::{Ball, Cuboid, Pose as RapierPose, Vector};

    fn stream() -> Stream {
        EpisodeSeed { seed: 21, episode: 0 }.stream(Purpose::Planner, 0)
    }

    fn rapier_ray(from: Vec2, unit: Vec2) -> Ray {
        Ray::new(Vector::new(from.x as f32, from.y as f32), Vector::new(unit.x as f32, unit.y as f32))
    }

    /// Whether `oracle` lies between what rays a hair to either side give: single precision hits or misses corners.
    fn brackets(cast: impl Fn(f64) -> f64, angle: f64, oracle: f64) -> bool {
        let beside = [angle - 2e-4, angle, angle + 2e-4].map(cast);
        let (low, high) =
            beside.iter().fold((f64::INFINITY, 0.0), |(low, high), &x| (math::min(low, x), math::max(high, x)));
        low - 3e-3 <= oracle && oracle <= high + 3e-3
    }

    #[test]
    fn ranges_on_the_map_equal_those_of_rapier() {
        let mut stream = stream();
        let (mut rays, mut exact) = (0, 0);
        for _ in 0..60 {
            let mut grid = OccupancyGrid::empty(30, 20, stream.range(0.2, 1.3));
            for index in 0..grid.occupied().len() {
                if stream.uniform() < 0.1 {
                    grid.set_occupied(grid.cell(index));
                }
            }
            let map = StaticMap::new(grid);
            let extent = map.grid.extent_m();
            for _ in 0..50 {
                let from = Vec2::new(stream.range(0.0, extent.x), stream.range(0.0, extent.y));
                if map.distance_m(from) < 0.01 {
                    continue;
                }
                let angle = stream.range(-4.0, 4.0);
                let cast = |angle: f64| map.cast_ray(from, direction(angle), 8.0);
                let hit = map.shape().cast_ray(&RapierPose::IDENTITY, &rapier_ray(from, direction(angle)), 8.0, true);
                let oracle = hit.map_or(8.0, f64::from);
                assert!(brackets(cast, angle, oracle), "{from:?} {angle}: {} {oracle}", cast(angle));
                rays += 1;
                exact += u32::from((cast(angle) - oracle).abs() < 3e-3);
            }
        }
        assert!(rays > 1500 && exact * 100 > rays * 98, "{exact} of {rays}");
    }

    #[test]
    fn ranges_to_discs_and_rectangles_equal_those_of_parry() {
        let mut stream = stream();
        for k in 0..2000 {
            let pose = Pose::new(stream.range(-3.0, 3.0), stream.range(-3.0, 3.0), stream.range(-4.0, 4.0));
            let (a, b) = (stream.range(0.1, 1.5), stream.range(0.1, 1.5));
            let disc = k % 2 == 0;
            let shape = if disc { Shape::Disc { radius_m: a } } else { Shape::Rectangle { half_m: Vec2::new(a, b) } };
            let obstacle = UnknownStatic::new(pose, shape);
            let from = Vec2::new(stream.range(-4.0, 4.0), stream.range(-4.0, 4.0));
            let angle = stream.range(-4.0, 4.0);
            let at = RapierPose::new(Vector::new(pose.position.x as f32, pose.position.y as f32), pose.theta as f32);
            let ray = rapier_ray(from, direction(angle));
            let hit = if disc {
                Ball::new(a as f32).cast_ray(&at, &ray, 100.0, true)
            } else {
                Cuboid::new(Vector::new(a as f32, b as f32)).cast_ray(&at, &ray, 100.0, true)
            };
            let cast = |angle: f64| math::min(obstacle.cast_ray(from, direction(angle)), 100.0);
            let oracle = hit.map_or(100.0, f64::from);
            assert!(brackets(cast, angle, oracle), "{obstacle:?} {from:?} {angle}: {} {oracle}", cast(angle));
            let nearest = obstacle.nearest_point(from);
            assert!(((nearest - from).norm() - math::max(obstacle.distance_m(from), 0.0)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_ray_from_inside_an_obstacle_or_from_outside_the_map_has_length_0() {
        let map = StaticMap::new(OccupancyGrid::from_ascii(&["...", ".#.", "..."], 1.0));
        assert_eq!(map.cast_ray(Vec2::new(1.5, 1.5), Vec2::x(), 5.0), 0.0);
        assert_eq!(map.cast_ray(Vec2::new(-1.0, 1.5), Vec2::x(), 5.0), 0.0);
        assert_eq!(map.cast_ray(Vec2::new(0.5, 1.5), Vec2::x(), 5.0), 0.5);
        assert_eq!(map.cast_ray(Vec2::new(0.5, 0.5), Vec2::x(), 5.0), 2.5, "the edge of the map");
        assert_eq!(map.cast_ray(Vec2::new(0.5, 0.5), Vec2::x(), 1.0), 1.0);
    }
}
