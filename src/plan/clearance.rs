//! Exact clearance of points and segments to the obstacle squares of a map: a tool for planners.
//!
//! An *obstacle square* is the closed square of an occupied cell; everything outside the map counts as one. The distance field
//! prunes: where a cell's centre is D away from the nearest square, a point that is o away from the centre has a clearance from
//! D − o to D + o. Most of a segment is passed in strides of that length, and squares are looked at only where the bound does not
//! decide.

use crate::geometry::{Path, Piece, Rect, Vec2, point_segment_distance};
use crate::map::{Cell, DistanceField, OccupancyGrid};
use crate::math;

/// Slack of comparisons between distances, m: what rounding may take from an exact clearance.
pub(super) const DISTANCE_SLACK_M: f64 = 1e-9;

/// Chords of arcs and curves stay this near to them, in cells, where their clearance is worked out.
const SAGITTA_CELLS: f64 = 0.01;

/// The obstacle squares of a map, seen through its distance field.
#[derive(Clone, Copy, Debug)]
pub struct Obstacles<'a> {
    /// [`DistanceField::squares`]: 0 in an occupied cell alone.
    squares: &'a [u32],
    cols: i32,
    rows: i32,
    side_m: f64,
}

impl<'a> Obstacles<'a> {
    /// The obstacles of `grid`, whose field is `field`.
    pub fn new(grid: &OccupancyGrid, field: &'a DistanceField) -> Self {
        Self::of_squares(field.squares(), grid.cols(), grid.rows(), grid.resolution_m())
    }

    pub(super) fn of_squares(squares: &'a [u32], cols: i32, rows: i32, side_m: f64) -> Self {
        Self { squares, cols, rows, side_m }
    }

    /// Distance from `p` to the nearest obstacle square, m, or `limit_m` if that is less; 0 in a square and outside the map.
    pub fn clearance(&self, p: Vec2, limit_m: f64) -> f64 {
        let Some((from_centre_m, offset_m)) = self.bounds(p) else { return 0.0 };
        if from_centre_m == 0.0 {
            return 0.0;
        }
        if from_centre_m - offset_m >= limit_m {
            return limit_m;
        }
        self.nearest_to(p, math::min(limit_m, from_centre_m + offset_m))
    }

    /// Distance between the segment a–b and the nearest obstacle square, m, or `limit_m` if that is less; 0 where they touch.
    pub fn segment_clearance(&self, a: Vec2, b: Vec2, limit_m: f64) -> f64 {
        if !(b - a).norm().is_finite() {
            return 0.0;
        }
        let mut least_m = limit_m;
        self.walk(a, b, limit_m, |from, to| {
            least_m = self.nearest_within(from, to, least_m);
            least_m > 0.0
        });
        least_m
    }

    /// The same for a piece of a path that begins at `from`; an arc or a curve by chords that stay within a hundredth of a cell of it.
    pub fn piece_clearance(&self, from: Vec2, piece: &Piece, limit_m: f64) -> f64 {
        let chords = piece.chord_count(from, SAGITTA_CELLS * self.side_m, 1e4);
        let at = |k: u32| piece.chord_point(from, k, chords);
        (0..chords).fold(limit_m, |least_m, k| self.segment_clearance(at(k), at(k + 1), least_m))
    }

    /// The same for the part of a path between two arc lengths.
    pub fn path_clearance(&self, path: &Path, from_m: f64, to_m: f64, limit_m: f64) -> f64 {
        let (mut begin_m, mut least_m) = (0.0, limit_m);
        for (from, piece) in path.segments() {
            let length_m = piece.length(from);
            let (first, last) = (math::max(from_m - begin_m, 0.0), math::min(to_m - begin_m, length_m));
            if first <= last {
                least_m = match piece {
                    Piece::Line { .. } => {
                        self.segment_clearance(piece.point_at(from, first), piece.point_at(from, last), least_m)
                    }
                    _ => self.piece_clearance(from, piece, least_m),
                };
            }
            begin_m += length_m;
            if begin_m > to_m {
                break;
            }
        }
        least_m
    }

    /// Whether the segment a–b keeps at least `clearance_m` from every obstacle square, to 1e-9 m, and touches none.
    pub fn keeps(&self, a: Vec2, b: Vec2, clearance_m: f64) -> bool {
        let needed_m = clearance_m - DISTANCE_SLACK_M;
        self.walk(a, b, clearance_m, |from, to| {
            let least_m = self.nearest_within(from, to, clearance_m);
            least_m > 0.0 && least_m >= needed_m
        })
    }

    /// Whether the segment a–b keeps as much from every obstacle square as its own ends do, up to `clearance_m`.
    pub fn keeps_as_its_ends(&self, a: Vec2, b: Vec2, clearance_m: f64) -> bool {
        let room_m = self.clearance(b, self.clearance(a, clearance_m));
        room_m > 0.0 && self.keeps(a, b, room_m)
    }

    /// Hands the parts of the segment to `is_clear` that may have less than `clearance_m`, until it says no; returns what it said last.
    #[inline]
    fn walk(&self, a: Vec2, b: Vec2, clearance_m: f64, mut is_clear: impl FnMut(Vec2, Vec2) -> bool) -> bool {
        let d = b - a;
        let length_m = d.norm();
        if !length_m.is_finite() {
            return false;
        }
        let direction = if length_m > 0.0 { d / length_m } else { d };
        // A part is about as long as the clearance is wide: longer ones are seldom clear as a whole, shorter ones look at squares twice.
        let part_m = math::max(self.side_m, clearance_m);
        let mut along_m = 0.0;
        loop {
            let p = a + direction * along_m;
            let free_m = match self.bounds(p) {
                None => 0.0,
                Some((from_centre_m, offset_m)) => {
                    if from_centre_m + offset_m < clearance_m - DISTANCE_SLACK_M {
                        // Too near for certain: what is asked here ends the walk or is exact.
                        0.0
                    } else {
                        from_centre_m - offset_m - clearance_m
                    }
                }
            };
            if free_m >= 0.25 * self.side_m {
                along_m += free_m;
            } else {
                let end_m = math::min(along_m + part_m, length_m);
                if !is_clear(p, a + direction * end_m) {
                    return false;
                }
                along_m = end_m;
                if end_m == length_m {
                    return true;
                }
            }
            if along_m > length_m {
                return true;
            }
        }
    }

    /// Distance from the centre of the cell of `p` to the nearest square and to `p`, m; `None` outside the map.
    #[inline]
    fn bounds(&self, p: Vec2) -> Option<(f64, f64)> {
        let (x, y) = (p.x / self.side_m, p.y / self.side_m);
        // NaN is outside as well.
        let is_inside = x >= 0.0 && y >= 0.0 && x < f64::from(self.cols) && y < f64::from(self.rows);
        if !is_inside {
            return None;
        }
        let (col, row) = (x as i32, y as i32);
        let square = self.squares[row as usize * self.cols as usize + col as usize];
        let (dx, dy) = (x - f64::from(col) - 0.5, y - f64::from(row) - 0.5);
        Some((0.5 * self.side_m * f64::from(square).sqrt(), self.side_m * (dx * dx + dy * dy).sqrt()))
    }

    /// Distance between a point inside the map and the nearest square, m, or `limit_m` if that is less: by looking at every square
    /// around, in squared distances in cells.
    fn nearest_to(&self, p: Vec2, limit_m: f64) -> f64 {
        let (x, y) = (p.x / self.side_m, p.y / self.side_m);
        // Rounding must not lose a line of cells, nor a square that is only touched.
        let limit = limit_m / self.side_m;
        let reach = limit + 1e-6;
        // The ring around the map has the numbers −1 and `cells`; a cast rounds towards 0.
        let first = |x: f64| (math::max(x - reach, -1.0) + 1.0) as i32 - 1;
        let last = |x: f64, cells: i32| (math::min(x + reach, f64::from(cells))) as i32;
        let (cols, rows) = ((first(x), last(x, self.cols)), (first(y), last(y, self.rows)));
        let mut least = limit * limit;
        if cols.0 < 0 || rows.0 < 0 || cols.1 >= self.cols || rows.1 >= self.rows {
            let border = math::min(math::min(x, y), math::min(f64::from(self.cols) - x, f64::from(self.rows) - y));
            least = math::min(least, border * border);
        }
        let beside = |x: f64, number: i32| math::max(math::max(f64::from(number) - x, x - f64::from(number + 1)), 0.0);
        let (from, to) = (cols.0.max(0), cols.1.min(self.cols - 1));
        for row in rows.0.max(0)..=rows.1.min(self.rows - 1) {
            let dy = beside(y, row);
            let begin = row as usize * self.cols as usize;
            for col in from..=to {
                if self.squares[begin + col as usize] == 0 {
                    let dx = beside(x, col);
                    least = math::min(least, dx * dx + dy * dy);
                }
            }
        }
        math::min(least.sqrt() * self.side_m, limit_m)
    }

    /// Distance between the segment a–b and the nearest square, m, or `limit_m` if that is less: by looking at every square around.
    fn nearest_within(&self, a: Vec2, b: Vec2, limit_m: f64) -> f64 {
        let (low, high) =
            (Vec2::new(math::min(a.x, b.x), math::min(a.y, b.y)), Vec2::new(math::max(a.x, b.x), math::max(a.y, b.y)));
        // Rounding must not lose a line of cells, nor a square that is only touched.
        let reach = limit_m + 1e-6 * self.side_m;
        let first = |x: f64| ((x - reach) / self.side_m).floor().clamp(-1.0, f64::from(i32::MAX)) as i32;
        let last = |x: f64, cells: i32| ((x + reach) / self.side_m).floor().clamp(-1.0, f64::from(cells)) as i32;
        let (cols, rows) = ((first(low.x), last(high.x, self.cols)), (first(low.y), last(high.y, self.rows)));
        let mut least_m = limit_m;
        // The ring of squares around the map: the nearest points of its four sides are straight across.
        if cols.0 < 0 || rows.0 < 0 || cols.1 >= self.cols || rows.1 >= self.rows {
            let extent = Vec2::new(f64::from(self.cols), f64::from(self.rows)) * self.side_m;
            let to_border = math::min(math::min(low.x, low.y), math::min(extent.x - high.x, extent.y - high.y));
            // NaN counts as outside.
            least_m = if to_border > 0.0 { math::min(least_m, to_border) } else { 0.0 };
        }
        for row in rows.0.max(0)..=rows.1.min(self.rows - 1) {
            let begin = row as usize * self.cols as usize;
            let (from, to) = (cols.0.max(0), cols.1.min(self.cols - 1));
            if from > to {
                break;
            }
            let squares = &self.squares[begin + from as usize..=begin + to as usize];
            for (offset, _) in squares.iter().enumerate().filter(|&(_, &square)| square == 0) {
                let col = from + offset as i32;
                let min = Vec2::new(f64::from(col), f64::from(row)) * self.side_m;
                let square = Rect { min, max: min + Vec2::new(self.side_m, self.side_m) };
                least_m = math::min(least_m, segment_square_distance(a, b, square));
            }
        }
        math::max(least_m, 0.0)
    }

    /// Whether a cell is occupied; outside the map all are.
    pub fn is_occupied(&self, cell: Cell) -> bool {
        let Cell { col, row } = cell;
        col < 0
            || row < 0
            || col >= self.cols
            || row >= self.rows
            || self.squares[row as usize * self.cols as usize + col as usize] == 0
    }
}

/// Distance between a segment and a closed square, 0 where they touch.
///
/// Two convex polygons that are apart come nearest at a corner of one of them.
pub(super) fn segment_square_distance(a: Vec2, b: Vec2, square: Rect) -> f64 {
    if touches(a, b, square) {
        return 0.0;
    }
    let (min, max) = (square.min, square.max);
    let corners = [min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)];
    let ends = math::min(square.signed_distance(a), square.signed_distance(b));
    corners.iter().fold(ends, |nearest, &corner| math::min(nearest, point_segment_distance(corner, a, b)))
}

/// Whether a segment and a closed square share a point: they are apart on x, on y or across the segment, or not at all.
fn touches(a: Vec2, b: Vec2, square: Rect) -> bool {
    let (min, max) = (square.min, square.max);
    let apart_on_x = math::max(a.x, b.x) < min.x || math::min(a.x, b.x) > max.x;
    let apart_on_y = math::max(a.y, b.y) < min.y || math::min(a.y, b.y) > max.y;
    if apart_on_x || apart_on_y {
        return false;
    }
    let d = b - a;
    // Middle and half extent of the square across the segment.
    let across = d.x * (0.5 * (min.y + max.y) - a.y) - d.y * (0.5 * (min.x + max.x) - a.x);
    let half = 0.5 * (d.x.abs() * (max.y - min.y) + d.y.abs() * (max.x - min.x));
    across.abs() <= half
}

/// Distance between the segments a–b and c–d, 0 where they cross.
pub(super) fn segments_distance(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> f64 {
    let side = |p: Vec2, q: Vec2, r: Vec2| (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
    let crosses = side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0;
    if crosses {
        return 0.0;
    }
    let ends = [
        point_segment_distance(a, c, d),
        point_segment_distance(b, c, d),
        point_segment_distance(c, a, b),
        point_segment_distance(d, a, b),
    ];
    ends.into_iter().fold(f64::INFINITY, math::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::grid::tests::{random_map, stream};

    /// Distance between a segment and a square by sampling, and half the spacing of the samples.
    fn sampled(a: Vec2, b: Vec2, squares: &[Rect]) -> (f64, f64) {
        const SAMPLES: i32 = 400;
        let mut least = f64::INFINITY;
        for k in 0..=SAMPLES {
            let p = a + (b - a) * (f64::from(k) / f64::from(SAMPLES));
            for square in squares {
                least = math::min(least, math::max(square.signed_distance(p), 0.0));
            }
        }
        (least, (b - a).norm() / f64::from(2 * SAMPLES))
    }

    #[test]
    fn the_clearance_of_a_segment_is_that_of_dense_sampling() {
        let mut stream = stream(201);
        let (mut kept, mut broken) = (0, 0);
        for _ in 0..400 {
            let share = stream.range(0.0, 0.15);
            let map = random_map(&mut stream, 14, share);
            let field = DistanceField::new(&map);
            let obstacles = Obstacles::new(&map, &field);
            let squares: Vec<Rect> = (-1..=map.rows())
                .flat_map(|row| (-1..=map.cols()).map(move |col| Cell { col, row }))
                .filter(|&cell| !map.is_free(cell))
                .map(|cell| map.square(cell))
                .collect();
            for _ in 0..10 {
                let mut point = || Vec2::new(stream.uniform() * map.extent_m().x, stream.uniform() * map.extent_m().y);
                let (a, b) = (point(), point());
                let limit_m = 4.0 * stream.uniform() * map.resolution_m();
                let (expected, error) = sampled(a, b, &squares);
                let expected = math::min(expected, limit_m);
                let answer = obstacles.segment_clearance(a, b, limit_m);
                assert!(
                    answer <= expected + 1e-12 && answer >= expected - error - 1e-12,
                    "{a:?} {b:?} {limit_m}: {answer} {expected}"
                );
                let point_m = math::min(sampled(a, a, &squares).0, limit_m);
                assert!((obstacles.clearance(a, limit_m) - point_m).abs() < 1e-12);
                let asked_m = stream.range(0.5, 1.5) * answer;
                if (asked_m - answer).abs() > 2e-9 && asked_m < limit_m && answer > 0.0 {
                    assert_eq!(obstacles.keeps(a, b, asked_m), asked_m < answer, "{a:?} {b:?} {asked_m} {answer}");
                    *(if asked_m < answer { &mut kept } else { &mut broken }) += 1;
                } else if answer == 0.0 {
                    assert!(!obstacles.keeps(a, b, 0.5 * limit_m), "{a:?} {b:?}");
                }
            }
        }
        assert!(kept > 200 && broken > 200, "{kept} {broken}");
    }

    #[test]
    fn outside_and_inside_squares_there_is_no_room() {
        let map = OccupancyGrid::from_ascii(&["...", ".#.", "..."], 1.0);
        let field = DistanceField::new(&map);
        let obstacles = Obstacles::new(&map, &field);
        for p in [(1.5, 1.5), (1.0, 1.5), (3.0, 1.5), (3.5, 1.5), (-0.1, 1.5), (f64::NAN, 1.5)] {
            let p = Vec2::new(p.0, p.1);
            assert_eq!(obstacles.clearance(p, 0.4), 0.0, "{p:?}");
            assert!(!obstacles.keeps(p, Vec2::new(0.5, 0.5), 0.1) && !obstacles.keeps_as_its_ends(p, p, 0.1));
        }
        // 0.5 m to the border and to the square; round the corner of it, (1, 1), it is 0.2 · √2 / 2.
        let v = Vec2::new;
        assert_eq!(obstacles.clearance(v(0.5, 1.5), 9.0), 0.5);
        assert!(
            (obstacles.segment_clearance(v(0.5, 1.3), v(1.3, 0.5), 9.0) - 0.1 * core::f64::consts::SQRT_2).abs()
                < 1e-12
        );
        assert!(!obstacles.keeps(v(0.5, 1.5), v(2.5, 1.5), 0.0));
    }

    #[test]
    fn segments_that_cross_have_no_distance_and_others_that_of_an_end() {
        let v = Vec2::new;
        assert_eq!(segments_distance(v(0.0, 0.0), v(2.0, 2.0), v(0.0, 2.0), v(2.0, 0.0)), 0.0);
        assert_eq!(segments_distance(v(0.0, 0.0), v(2.0, 0.0), v(3.0, 1.0), v(3.0, -1.0)), 1.0);
        assert_eq!(segments_distance(v(0.0, 0.0), v(2.0, 0.0), v(1.0, 0.5), v(1.0, 0.5)), 0.5);
    }
}
