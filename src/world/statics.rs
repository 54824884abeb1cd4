//! Static obstacles: the known map with its edge, and the unknown statics of one scene.

use super::obstacles::unknown_static::UnknownStatic;
use super::scene::{Digest, FreeSpaceCache};
use crate::geometry::outline::{Body, Hit, Outline, sweep_disc_rect};
use crate::geometry::{Rect, Vec2, convex};
use crate::map::{Cell, DistanceField, OccupancyGrid};
use crate::math;
use rapier2d::prelude::{Pose as RapierPose, SharedShape, Vector};
use std::sync::Arc;

/// A known map with the tables derived from it, computed once and shared by every episode that uses it.
#[derive(Clone)]
pub struct StaticMap {
    /// Occupancy.
    pub grid: Arc<OccupancyGrid>,
    /// Exact distance field of `grid`.
    pub field: Arc<DistanceField>,
    /// The nearest occupied column at or left of each cell, row by row; [`NONE`] if there is no such column.
    left: Vec<u16>,
    /// The nearest occupied column at or right of each cell, row by row; [`NONE`] if there is no such column.
    right: Vec<u16>,
    shape: SharedShape,
    digest: u64,
    pub(super) free_spaces: FreeSpaceCache,
}

/// Stands for no column; grids have at most 16384 columns.
const NONE: u16 = u16::MAX;

impl core::fmt::Debug for StaticMap {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let (cols, rows) = (self.grid.cols(), self.grid.rows());
        f.debug_struct("StaticMap").field("cols", &cols).field("rows", &rows).finish_non_exhaustive()
    }
}

impl StaticMap {
    /// Derives everything from a grid: distance field, merged rectangles for rapier, tables for exact distances.
    ///
    /// # Panics
    /// If the grid has more than 16384 columns.
    pub fn new(grid: OccupancyGrid) -> Self {
        assert!(grid.cols() <= 16_384, "a map has at most 16384 columns");
        let field = DistanceField::new(&grid);
        let (left, right) = nearest_columns(&grid);
        let shape =
            SharedShape::compound(merged_rectangles(&grid).into_iter().chain(border(&grid)).map(cuboid).collect());
        let digest = digest_of(&grid);
        Self {
            grid: Arc::new(grid),
            field: Arc::new(field),
            left,
            right,
            shape,
            digest,
            free_spaces: FreeSpaceCache::default(),
        }
    }

    /// Known obstacles and the map's edge as one rapier shape: greedily merged rectangles and four bars.
    pub(super) fn shape(&self) -> &SharedShape {
        &self.shape
    }

    /// Fingerprint of the map: size, resolution, frame and cells. Two different maps have the same one with a chance of 2⁻⁶⁴.
    pub fn digest(&self) -> u64 {
        self.digest
    }

    /// Signed distance from `p` (grid frame) to the map's edge, m: positive inside the map.
    pub fn edge_distance_m(&self, p: Vec2) -> f64 {
        let extent = self.grid.extent_m();
        math::min(math::min(p.x, extent.x - p.x), math::min(p.y, extent.y - p.y))
    }

    /// Distance from `p` (grid frame) to the nearest occupied square, m, exact, and at most `cap`.
    ///
    /// Inside an occupied square: minus the depth below that square's own nearest side. Goes through the rows in the
    /// order of their distance and asks each for its nearest occupied column, so it costs O(distance / resolution).
    pub fn obstacle_distance_m(&self, p: Vec2, cap: f64) -> f64 {
        let grid = &self.grid;
        let own = grid.cell_at(p);
        let col = own.col.clamp(0, grid.cols() - 1);
        let mut best = cap;
        let (mut up, mut down) = (own.row.max(0), own.row.min(grid.rows()) - 1);
        loop {
            // Vertical distance to the next strip of rows on either side; no square there is nearer.
            let above = f64::from(up) * grid.resolution_m() - p.y;
            let below = p.y - f64::from(down + 1) * grid.resolution_m();
            let go_up = up < grid.rows() && above < best;
            let go_down = down >= 0 && below < best;
            if !go_up && !go_down {
                return best;
            }
            if go_up {
                best = self.row_distance_m(p, Cell { col, row: up }, best);
                up += 1;
            }
            if go_down {
                best = self.row_distance_m(p, Cell { col, row: down }, best);
                down -= 1;
            }
        }
    }

    fn row_distance_m(&self, p: Vec2, cell: Cell, mut best: f64) -> f64 {
        let index = self.grid.index(cell);
        for col in [self.left[index], self.right[index]] {
            if col != NONE {
                let square = self.grid.square(Cell { col: i32::from(col), row: cell.row });
                best = square.signed_distance_below(p, best);
            }
        }
        best
    }

    /// Distance from `p` (grid frame) to the nearest known obstacle or the map's edge, m, exact.
    pub fn distance_m(&self, p: Vec2) -> f64 {
        self.obstacle_distance_m(p, self.edge_distance_m(p))
    }
}

impl StaticMap {
    /// A lower bound of [`Self::distance_m`], m, at most a diagonal of a cell below it, found by one look at the field.
    fn distance_at_least_m(&self, p: Vec2) -> f64 {
        let cell = self.grid.cell_at(p);
        self.field.distance_m(cell) - (p - self.grid.centre(cell)).norm()
    }

    /// Signed distance between a body (grid frame) and the nearest known obstacle or the map's edge, m.
    pub fn gap_m(&self, body: &Body) -> f64 {
        match &body.corners {
            None => self.distance_m(body.position) - body.radius_m,
            Some(corners) => self.polygon_distance_m(corners, self.edge_gap_m(body)),
        }
    }

    /// Signed distance between a body (grid frame) and the nearest known obstacle, m; infinite on a map without obstacles.
    pub fn obstacle_gap_m(&self, body: &Body) -> f64 {
        match &body.corners {
            None => self.obstacle_distance_m(body.position, f64::INFINITY) - body.radius_m,
            Some(corners) => self.polygon_distance_m(corners, f64::INFINITY),
        }
    }

    /// Signed distance between a body (grid frame) and the map's edge, m: positive inside the map.
    pub fn edge_gap_m(&self, body: &Body) -> f64 {
        match &body.corners {
            None => self.edge_distance_m(body.position) - body.radius_m,
            Some(corners) => corners.iter().map(|&corner| self.edge_distance_m(corner)).fold(f64::INFINITY, math::min),
        }
    }

    /// Signed distance from a convex polygon (grid frame) to the nearest occupied square, m; at most `cap`. Exact if the polygon
    /// touches no square; if it overlaps several squares, minus the depth in one of them.
    ///
    /// Computed as [`Self::obstacle_distance_m`], row by row. In a row the distance is a convex function of the square's column, so
    /// the nearest occupied columns to either side of its minimum are enough; the minimum is where the polygon is nearest the row.
    fn polygon_distance_m(&self, corners: &[Vec2], cap: f64) -> f64 {
        let (grid, bounds) = (&self.grid, convex::bounds(corners));
        let side_m = grid.resolution_m();
        let middle = 0.5 * (bounds.min + bounds.max);
        let own = grid.cell_at(middle);
        let mut best = cap;
        let (mut up, mut down) = (own.row.max(0), own.row.min(grid.rows()) - 1);
        loop {
            let above = f64::from(up) * side_m - bounds.max.y;
            let below = bounds.min.y - f64::from(down + 1) * side_m;
            let go_up = up < grid.rows() && above < best;
            let go_down = down >= 0 && below < best;
            if !go_up && !go_down {
                return best;
            }
            let rows = [go_up.then_some(up), go_down.then_some(down)];
            for row in rows.into_iter().flatten() {
                let y = math::clamp(middle.y, f64::from(row) * side_m, f64::from(row + 1) * side_m);
                let p = convex::point_at_height(corners, y);
                let col = grid.cell_at(p).col.clamp(0, grid.cols() - 1);
                let index = grid.index(Cell { col, row });
                for col in [self.left[index], self.right[index]] {
                    if col != NONE {
                        let square = convex::rectangle(grid.square(Cell { col: i32::from(col), row }));
                        best = math::min(best, convex::distance(corners, &square));
                    }
                }
            }
            up += i32::from(go_up);
            down -= i32::from(go_down);
        }
    }
}

fn nearest_columns(grid: &OccupancyGrid) -> (Vec<u16>, Vec<u16>) {
    let cols = grid.cols() as usize;
    let occupied = grid.occupied();
    let (mut left, mut right) = (vec![NONE; occupied.len()], vec![NONE; occupied.len()]);
    for begin in (0..occupied.len()).step_by(cols) {
        let mut last = NONE;
        for col in 0..cols {
            if occupied[begin + col] {
                last = col as u16;
            }
            left[begin + col] = last;
        }
        last = NONE;
        for col in (0..cols).rev() {
            if occupied[begin + col] {
                last = col as u16;
            }
            right[begin + col] = last;
        }
    }
    (left, right)
}

/// Disjoint rectangles that cover exactly the occupied cells: each as wide as it can be, then as high.
fn merged_rectangles(grid: &OccupancyGrid) -> Vec<Rect> {
    let (cols, rows) = (grid.cols() as usize, grid.rows() as usize);
    let occupied = grid.occupied();
    let mut taken = vec![false; occupied.len()];
    let mut rectangles = Vec::new();
    for row in 0..rows {
        for col in 0..cols {
            let open = |taken: &[bool], row: usize, col: usize| occupied[row * cols + col] && !taken[row * cols + col];
            if !open(&taken, row, col) {
                continue;
            }
            let mut right = col + 1;
            while right < cols && open(&taken, row, right) {
                right += 1;
            }
            let mut top = row + 1;
            while top < rows && (col..right).all(|c| open(&taken, top, c)) {
                top += 1;
            }
            for r in row..top {
                taken[r * cols + col..r * cols + right].fill(true);
            }
            let first = grid.square(Cell { col: col as i32, row: row as i32 });
            let last = grid.square(Cell { col: right as i32 - 1, row: top as i32 - 1 });
            rectangles.push(Rect { min: first.min, max: last.max });
        }
    }
    rectangles
}

/// Four bars around the map.
fn border(grid: &OccupancyGrid) -> [Rect; 4] {
    const THICKNESS_M: f64 = 1.0;
    let extent = grid.extent_m();
    let (low, high) = (-THICKNESS_M, extent + Vec2::new(THICKNESS_M, THICKNESS_M));
    let rect = |x0, y0, x1, y1| Rect { min: Vec2::new(x0, y0), max: Vec2::new(x1, y1) };
    [
        rect(low, low, high.x, 0.0),
        rect(low, extent.y, high.x, high.y),
        rect(low, 0.0, 0.0, extent.y),
        rect(extent.x, 0.0, high.x, extent.y),
    ]
}

fn cuboid(rect: Rect) -> (RapierPose, SharedShape) {
    let (centre, half) = (0.5 * (rect.min + rect.max), 0.5 * (rect.max - rect.min));
    let pose = RapierPose::from_translation(Vector::new(centre.x as f32, centre.y as f32));
    (pose, SharedShape::cuboid(half.x as f32, half.y as f32))
}

fn digest_of(grid: &OccupancyGrid) -> u64 {
    let mut digest = Digest::default();
    digest.word(grid.cols() as u64);
    digest.word(grid.rows() as u64);
    digest.real(grid.resolution_m());
    digest.point(grid.frame().origin.position);
    digest.real(grid.frame().origin.theta);
    for cells in grid.occupied().chunks(64) {
        digest.word(cells.iter().enumerate().fold(0, |word, (bit, &occupied)| word | u64::from(occupied) << bit));
    }
    digest.value()
}

/// All static obstacles of one scene.
#[derive(Clone, Copy, Debug)]
pub struct Statics<'a> {
    /// The known map with its edge.
    pub(super) map: &'a StaticMap,
    /// The unknown statics.
    pub(super) unknown: &'a [UnknownStatic],
}

impl Statics<'_> {
    /// Distance from `p` to the nearest static obstacle or the map's edge, m.
    #[cfg(test)]
    pub(super) fn distance_m(&self, p: Vec2) -> f64 {
        self.unknown.iter().fold(self.map.distance_m(p), |best, obstacle| math::min(best, obstacle.distance_m(p)))
    }

    /// Signed distance from an outline about `p` to the nearest static obstacle or the map's edge, m.
    pub(super) fn gap_m(&self, outline: &Outline, p: Vec2) -> f64 {
        self.body_gap_m(&Body { position: p, radius_m: outline.circumradius_m(), corners: outline.corners(p) })
    }

    /// Signed distance between a body and the nearest static obstacle or the map's edge, m.
    pub(super) fn body_gap_m(&self, body: &Body) -> f64 {
        self.unknown.iter().fold(self.map.gap_m(body), |best, obstacle| math::min(best, obstacle.gap_m(body)))
    }

    /// First contact within `duration_s` of an outline that moves from `p` with `velocity`; ties go to the known map's
    /// cells in row order, then to its edge, then to unknown statics in order.
    pub(super) fn sweep(&self, outline: &Outline, p: Vec2, velocity: Vec2, duration_s: f64) -> Option<Hit> {
        let radius_m = outline.circumradius_m();
        let mut first: Option<Hit> = None;
        let mut keep = |hit: Option<Hit>| {
            if let Some(hit) = hit
                && hit.time_s <= duration_s
                && first.is_none_or(|best| hit.time_s < best.time_s)
            {
                first = Some(hit);
            }
        };
        let reach = radius_m + velocity.norm() * duration_s;
        let grid = &self.map.grid;
        if self.map.distance_at_least_m(p) <= reach {
            let end = p + velocity * duration_s;
            let margin = Vec2::new(radius_m, radius_m);
            let corners = outline.corners(p);
            let low = grid.cell_at(Vec2::new(math::min(p.x, end.x), math::min(p.y, end.y)) - margin);
            let high = grid.cell_at(Vec2::new(math::max(p.x, end.x), math::max(p.y, end.y)) + margin);
            for row in low.row.max(0)..=high.row.min(grid.rows() - 1) {
                for col in low.col.max(0)..=high.col.min(grid.cols() - 1) {
                    let cell = Cell { col, row };
                    if !grid.is_free(cell) {
                        let square = grid.square(cell);
                        keep(match &corners {
                            None => sweep_disc_rect(p, velocity, radius_m, square),
                            Some(corners) => convex::sweep(corners, velocity, &convex::rectangle(square)),
                        });
                    }
                }
            }
            let extent = grid.extent_m();
            for axis in [0, 1] {
                let (gap, sign) = match (&corners, velocity[axis] < 0.0) {
                    (None, true) => (p[axis] - radius_m, 1.0),
                    (None, false) => (extent[axis] - radius_m - p[axis], -1.0),
                    (Some(corners), true) => (convex::bounds(corners).min[axis], 1.0),
                    (Some(corners), false) => (extent[axis] - convex::bounds(corners).max[axis], -1.0),
                };
                if velocity[axis] != 0.0 {
                    let mut normal = Vec2::zeros();
                    normal[axis] = sign;
                    keep(Some(Hit { time_s: math::max(gap / velocity[axis].abs(), 0.0), normal }));
                }
            }
        }
        for obstacle in self.unknown {
            if (p - obstacle.pose().position).norm() <= reach + obstacle.shape().circumradius_m() {
                keep(obstacle.sweep(outline, p, velocity));
            }
        }
        first
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{EpisodeSeed, Purpose, Stream};

    fn random_grid(stream: &mut Stream, cols: i32, rows: i32, resolution_m: f64, density: f64) -> OccupancyGrid {
        let mut grid = OccupancyGrid::empty(cols, rows, resolution_m);
        for index in 0..grid.occupied().len() {
            if stream.uniform() < density {
                grid.set_occupied(grid.cell(index));
            }
        }
        grid
    }

    #[test]
    fn distances_equal_the_smallest_over_all_squares_and_that_of_parry() {
        let mut stream = EpisodeSeed { seed: 1, episode: 0 }.stream(Purpose::Planner, 0);
        for round in 0..200 {
            let (resolution, density) = (stream.range(0.05, 1.5), stream.range(0.0, 0.5));
            let grid = random_grid(&mut stream, 1 + round % 17, 1 + round % 11, resolution, density);
            let map = StaticMap::new(grid);
            let extent = map.grid.extent_m();
            for _ in 0..50 {
                let p = Vec2::new(stream.range(0.0, extent.x), stream.range(0.0, extent.y));
                let edge = [p.x, p.y, extent.x - p.x, extent.y - p.y].into_iter().fold(f64::INFINITY, math::min);
                let squares = (0..map.grid.occupied().len()).filter(|&i| map.grid.occupied()[i]);
                let brute =
                    squares.fold(edge, |best, i| math::min(best, map.grid.square(map.grid.cell(i)).signed_distance(p)));
                assert_eq!(map.distance_m(p).to_bits(), brute.to_bits());
                let at_least = map.distance_at_least_m(p);
                assert!((brute - 1.5 * resolution..brute + 1e-9).contains(&at_least) || brute < 0.0);
                if brute > 0.0 {
                    let theirs = map.shape.distance_to_local_point(Vector::new(p.x as f32, p.y as f32), true);
                    assert!((f64::from(theirs) - brute).abs() < 1e-5, "{theirs} {brute}");
                }
            }
        }
    }

    #[test]
    fn outside_the_map_the_edge_distance_is_negative() {
        let map = StaticMap::new(OccupancyGrid::empty(4, 3, 1.0));
        assert_eq!(map.distance_m(Vec2::new(-0.5, 1.0)), -0.5);
        assert_eq!(map.distance_m(Vec2::new(2.0, 3.25)), -0.25);
        assert_eq!(map.obstacle_distance_m(Vec2::new(-0.5, 1.0), 9.0), 9.0);
    }

    #[test]
    fn merged_rectangles_cover_the_occupied_cells_once() {
        let mut stream = EpisodeSeed { seed: 2, episode: 0 }.stream(Purpose::Planner, 0);
        for density in [0.1, 0.5, 0.9, 1.0] {
            let grid = random_grid(&mut stream, 23, 19, 0.5, density);
            let rectangles = merged_rectangles(&grid);
            for index in 0..grid.occupied().len() {
                let centre = grid.centre(grid.cell(index));
                let covers = rectangles.iter().filter(|rect| rect.contains(centre)).count();
                assert_eq!(covers, usize::from(grid.occupied()[index]));
            }
            if density == 1.0 {
                assert_eq!(rectangles.len(), 1);
            }
        }
    }

    #[test]
    fn digests_tell_maps_apart() {
        let grid = OccupancyGrid::from_ascii(&["..#", "..."], 1.0);
        let digest = StaticMap::new(grid.clone()).digest();
        assert_eq!(StaticMap::new(grid.clone()).digest(), digest);
        let mut other = grid.clone();
        other.set_occupied(Cell { col: 0, row: 0 });
        assert_ne!(StaticMap::new(other).digest(), digest);
        assert_ne!(StaticMap::new(grid.clone().with_resolution(0.5)).digest(), digest);
        // The same cells in another outline.
        assert_ne!(StaticMap::new(OccupancyGrid::from_ascii(&["..", "#.", ".."], 1.0)).digest(), digest);
    }
}
