//! `shortest_m`: a lower bound of the length of every collision-free drive.
//!
//! It is the exact any-angle optimum of a *point* on the true static map, in which a cell counts as
//! blocked only where the centre of the robot can never be: if it is an obstacle, or if its whole
//! square lies within the inscribed radius of one ([`blocked_cells`]). A drive is at least that long
//! because its centre never enters such a cell, however the footprint, the movers and the limits of
//! the drive lengthen it.
//!
//! The point may touch obstacles and run along them. It must not enter a blocked cell, run
//! between two blocked cells that share an edge, or pass a point where two blocked cells meet
//! diagonally (the rules of the `anyangle` benchmark).
//!
//! Method: the shortest path bends only at convex corners of obstacles (T. Lozano-Pérez, M. Wesley,
//! An algorithm for planning collision-free paths among polyhedral obstacles, CACM 1979), so A* runs
//! on the visibility graph of those corners. Edges are found when a corner is expanded, by following what
//! it sees from row to row, through the free runs of cells, as shrinking cones (the line-of-sight
//! scans of S. Oh, H. W. Leong, Edge N-level sparse visibility graphs, SoCS 2017). Only taut
//! edges are looked for, which pass a corner tangentially and bend around it: the others are on no
//! shortest path. So the cost of an expansion grows with the visible part of the map, not with the whole map.
//!
//! Inside, lengths are in cells. Corners are whole numbers and cell centres are half ones, so that
//! every test of a line is exact in f64 where start and goal are centres. Elsewhere a line that
//! grazes a corner within rounding may be judged either way, and the path bent at that corner has
//! the same length within rounding.

use crate::geometry::{Rect, Vec2};
use crate::map::{Cell, OccupancyGrid};
use crate::math;
use crate::world::{Scene, UnknownStatic};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

/// Largest depth of a contact that the world may miss, m: the centre may come nearer to an obstacle by this much.
const CONTACT_DEPTH_M: f64 = 1e-3;

/// Work after which the search gives up: runs of cells looked into, corners found, cells crossed by tested lines.
const WORK_MAX: u64 = 20_000_000;

/// Distance within which a coordinate is rounded to a multiple of half a cell, cells.
const SNAP_CELLS: f64 = 1e-9;

/// Amount by which a cone is widened, cells. It may then show a corner too many, which the exact test of the
/// line refuses, but never one too few.
const CONE_SLACK: f64 = 1e-9;

/// A lower bound, m, of the way that the centre of a robot with inscribed radius `radius_m` travels
/// in `scene` without collision until it is within `goal_tolerance_m` of the goal, plus that tolerance.
///
/// So for every successful episode `length_m + goal_tolerance_m >= shortest_m`. `None` if no drive
/// exists under the relaxed rules above, or if the search exceeds its fixed bound of work.
/// Valid only while goal and statics stay as the scene has them. Ties do not matter: only the length is returned.
pub fn shortest_m(scene: &Scene, radius_m: f64, goal_tolerance_m: f64) -> Option<f64> {
    let blocked = blocked_cells(scene, radius_m, goal_tolerance_m);
    any_angle_m(&blocked, scene.start.position, scene.goal)
}

/// The cells in which the centre of the robot can never be; all else is free.
///
/// With R = `radius_m` less the depth of contact that the world may miss, a cell is blocked
/// - if it is occupied on the known map;
/// - if its whole square lies within R of one occupied cell or of the outside of the map. The point of
///   a square that is farthest from another square of the grid, `(i, j)` cells away, has
///   distance L·√(i² + j²), so this compares the distance of the two centres with R;
/// - if its whole square lies inside, or within R of, one unknown static. The distance to a convex shape
///   is a convex function, so its four corners tell. A cell that the static only touches stays free: the
///   centre may pass through the rest of it.
///
/// Then cells nearer than `goal_tolerance_m` to the goal are opened: a drive may end, and count as
/// success, on the near side of an obstacle behind which the goal lies, and the last straight piece
/// to the goal must not be forced around it.
pub fn blocked_cells(scene: &Scene, radius_m: f64, goal_tolerance_m: f64) -> OccupancyGrid {
    let known = &scene.map.grid;
    let mut blocked = OccupancyGrid::clone(known);
    let reach_m = math::max(radius_m - CONTACT_DEPTH_M, 0.0);
    grow(known, reach_m, &mut blocked);
    for obstacle in &scene.unknown_static {
        cover(obstacle, reach_m, &mut blocked);
    }
    let around = Rect { min: scene.goal, max: scene.goal };
    for cell in cells_in(&blocked, around, goal_tolerance_m) {
        if blocked.contains(cell) && blocked.square(cell).signed_distance(scene.goal) < goal_tolerance_m {
            blocked.set_free(cell);
        }
    }
    blocked
}

/// Blocks every cell whose centre is within `reach_m` of the centre of an occupied or outside cell.
fn grow(known: &OccupancyGrid, reach_m: f64, blocked: &mut OccupancyGrid) {
    let reach_cells = reach_m / known.resolution_m();
    let reach = reach_cells.floor() as i32;
    if reach == 0 {
        return;
    }
    let offsets: Vec<(i32, i32)> = (-reach..=reach)
        .flat_map(|row| (-reach..=reach).map(move |col| (col, row)))
        .filter(|&(col, row)| f64::from(col * col + row * row) <= reach_cells * reach_cells)
        .collect();
    let free_beside = |cell: Cell| {
        (-1..=1).any(|row| (-1..=1).any(|col| known.is_free(Cell { col: cell.col + col, row: cell.row + row })))
    };
    // The outside needs its first ring only, and obstacles their outermost cells: what lies behind is farther.
    for row in -1..=known.rows() {
        for col in -1..=known.cols() {
            let source = Cell { col, row };
            if known.is_free(source) || !free_beside(source) {
                continue;
            }
            for &(cols, rows) in &offsets {
                let cell = Cell { col: col + cols, row: row + rows };
                if known.contains(cell) {
                    blocked.set_occupied(cell);
                }
            }
        }
    }
}

/// Blocks every cell that lies wholly within `reach_m` of the obstacle.
fn cover(obstacle: &UnknownStatic, reach_m: f64, blocked: &mut OccupancyGrid) {
    let half = obstacle.shape().circumradius_m();
    let centre = obstacle.pose().position;
    for cell in cells_in(blocked, Rect { min: centre, max: centre }, half + reach_m) {
        let Rect { min, max } = blocked.square(cell);
        let corners = [min, max, Vec2::new(min.x, max.y), Vec2::new(max.x, min.y)];
        let is_covered = corners.into_iter().all(|corner| obstacle.distance_m(corner) <= reach_m);
        if is_covered && blocked.contains(cell) {
            blocked.set_occupied(cell);
        }
    }
}

/// The cells that reach into `rect`, widened by `margin_m`, in row-major order: those of the grid and of the
/// first ring outside.
pub(super) fn cells_in(grid: &OccupancyGrid, rect: Rect, margin_m: f64) -> impl Iterator<Item = Cell> + use<> {
    let margin = Vec2::new(margin_m, margin_m);
    let (first, last) = (grid.cell_at(rect.min - margin), grid.cell_at(rect.max + margin));
    let cols = first.col.max(-1)..=last.col.min(grid.cols());
    let rows = first.row.max(-1)..=last.row.min(grid.rows());
    rows.flat_map(move |row| cols.clone().map(move |col| Cell { col, row }))
}

/// Length, m, of the shortest way of a point from `start` to `goal` (grid frame) around the occupied
/// cells of `grid`, in any direction; the rules and the method are in the module's documentation.
///
/// `None` if the cell of `start` or `goal` is occupied or outside, if no way exists, or if the search
/// exceeds its bound of work (a fixed count, so the same on every machine).
pub fn any_angle_m(grid: &OccupancyGrid, start: Vec2, goal: Vec2) -> Option<f64> {
    if !grid.is_free(grid.cell_at(start)) || !grid.is_free(grid.cell_at(goal)) {
        return None;
    }
    let cells = Plane::new(grid).optimum(in_cells(grid, start), in_cells(grid, goal))?;
    Some(cells * grid.resolution_m())
}

/// A point in cells; coordinates within rounding of a multiple of half a cell are rounded to it.
fn in_cells(grid: &OccupancyGrid, p: Vec2) -> Vec2 {
    (p / grid.resolution_m()).map(|x| {
        let halves = (2.0 * x).round() / 2.0;
        if (x - halves).abs() < SNAP_CELLS { halves } else { x }
    })
}

/// The map in the form that the search uses, in cells.
#[derive(Debug)]
struct Plane {
    /// Blocked cells with a blocked ring around, so that no look-up needs a bounds test of its own.
    blocked: Vec<bool>,
    /// Columns of `blocked`.
    width: usize,
    /// Maximal runs of free cells, each from its left end to its right end, row by row.
    runs: Rows<(f64, f64)>,
    /// Convex corners from left to right, grid line by grid line.
    corners: Rows<Corner>,
}

/// Items in rows.
#[derive(Debug)]
struct Rows<T> {
    items: Vec<T>,
    /// Index of the first item of each row, and the end of the last row.
    begins: Vec<usize>,
}

impl<T> Rows<T> {
    /// Rows of the items that `fill` appends for each row number from 0.
    fn new(rows: usize, mut fill: impl FnMut(usize, &mut Vec<T>)) -> Self {
        let (mut items, mut begins) = (Vec::new(), vec![0]);
        for row in 0..rows {
            fill(row, &mut items);
            begins.push(items.len());
        }
        Self { items, begins }
    }

    /// Indices of the items of `row`; empty for a row outside.
    fn row(&self, row: i32) -> Range<usize> {
        match usize::try_from(row) {
            Ok(row) if row + 1 < self.begins.len() => self.begins[row]..self.begins[row + 1],
            _ => 0..0,
        }
    }

    /// Indices of the items of `row` from the first for which `is_before` is false.
    fn row_from(&self, row: i32, is_before: impl Fn(&T) -> bool) -> Range<usize> {
        let row = self.row(row);
        row.start + self.items[row.clone()].partition_point(is_before)..row.end
    }
}

/// A convex corner of an obstacle: a lattice point with exactly one blocked cell around it.
#[derive(Clone, Copy, Debug)]
struct Corner {
    at: Vec2,
    /// Signs of the direction from the corner into its blocked cell.
    towards: Vec2,
}

/// Part of a row of cells that is seen through the rows before it.
#[derive(Clone, Copy, Debug)]
struct Cone {
    row: i32,
    /// Columns gained per row by its leftmost and by its rightmost line.
    slopes: (f64, f64),
}

impl Plane {
    fn new(grid: &OccupancyGrid) -> Self {
        let (cols, rows, width) = (grid.cols() as usize, grid.rows() as usize, grid.cols() as usize + 2);
        let mut blocked = vec![true; width * (rows + 2)];
        for (row, occupied) in grid.occupied().chunks_exact(cols).enumerate() {
            blocked[(row + 1) * width + 1..][..cols].copy_from_slice(occupied);
        }
        let runs = Rows::new(rows, |row, runs| {
            let cells = &blocked[(row + 1) * width..][..width];
            let mut begin = 0;
            for col in 1..width {
                match (cells[col - 1], cells[col]) {
                    (true, false) => begin = col - 1,
                    (false, true) => runs.push((begin as f64, (col - 1) as f64)),
                    _ => {}
                }
            }
        });
        let corners = Rows::new(rows + 1, |line, corners| {
            // The lattice point (col, line) lies between the cells col − 1 and col of the rows line − 1 and line.
            for col in 0..=cols {
                let (below, above) = (line * width + col, (line + 1) * width + col);
                let towards = match [below, below + 1, above, above + 1].map(|index| blocked[index]) {
                    [true, false, false, false] => Vec2::new(-1.0, -1.0),
                    [false, true, false, false] => Vec2::new(1.0, -1.0),
                    [false, false, true, false] => Vec2::new(-1.0, 1.0),
                    [false, false, false, true] => Vec2::new(1.0, 1.0),
                    _ => continue,
                };
                corners.push(Corner { at: Vec2::new(col as f64, line as f64), towards });
            }
        });
        Self { blocked, width, runs, corners }
    }

    /// Index of the cell (col, row), both from −1 to one past the last.
    fn index(&self, col: i32, row: i32) -> usize {
        (row + 1) as usize * self.width + (col + 1) as usize
    }

    fn is_blocked(&self, col: i32, row: i32) -> bool {
        self.blocked[self.index(col, row)]
    }

    /// Whether a point may go straight from `a` to `b`.
    ///
    /// Crossings with the lines of the grid are ordered by |X − a.x|·|d.y| against |Y − a.y|·|d.x|,
    /// without a division: exact for multiples of half a cell.
    fn sees(&self, a: Vec2, b: Vec2) -> bool {
        let d = b - a;
        if d.y == 0.0 {
            return clear_along(a.x, b.x, a.y, |col, row| self.is_blocked(col, row));
        }
        if d.x == 0.0 {
            return clear_along(a.y, b.y, a.x, |row, col| self.is_blocked(col, row));
        }
        let (mut x, mut y) = (AxisWalk::new(a.x, b.x), AxisWalk::new(a.y, b.y));
        // Grows by a whole cell's share per crossing; compared, it says which line comes next.
        let (mut to_x, mut to_y) = (x.to_first * d.y.abs(), y.to_first * d.x.abs());
        let stride_y = if y.step > 0 { self.width as isize } else { -(self.width as isize) };
        let stride_x = x.step as isize;
        let mut at = self.index(x.cell, y.cell);
        loop {
            if self.blocked[at] {
                return false;
            }
            if x.left == 0 && y.left == 0 {
                return true;
            }
            let next_x = x.left > 0 && (y.left == 0 || to_x <= to_y);
            let next_y = y.left > 0 && (x.left == 0 || to_y <= to_x);
            if next_x && next_y {
                let (beside, above) = (at.wrapping_add_signed(stride_x), at.wrapping_add_signed(stride_y));
                if self.blocked[beside] && self.blocked[above] {
                    return false; // through a point where two blocked cells meet diagonally
                }
            }
            if next_x {
                at = at.wrapping_add_signed(stride_x);
                to_x += d.y.abs();
                x.left -= 1;
            }
            if next_y {
                at = at.wrapping_add_signed(stride_y);
                to_y += d.x.abs();
                y.left -= 1;
            }
        }
    }

    /// Adds to `found` every corner above `p` (`step` 1) or below it (−1) that is seen from `p` at a slope
    /// (columns per row) from `slopes.0` to `slopes.1`, and perhaps some that are not; returns the work.
    fn look(&self, p: Vec2, step: i32, slopes: (f64, f64), cones: &mut Vec<Cone>, found: &mut Vec<usize>) -> u64 {
        let mut work = 0;
        let row = if step > 0 { p.y.floor() } else { p.y.ceil() - 1.0 };
        cones.push(Cone { row: row as i32, slopes });
        while let Some(Cone { row, slopes: (left, right) }) = cones.pop() {
            // Distances from p to the near and to the far line of the row of cells.
            let (below, above) = (f64::from(row) - p.y, f64::from(row + 1) - p.y);
            let (near, far, far_line) = if step > 0 { (below, above, row + 1) } else { (-above, -below, row) };
            let near = math::max(near, 0.0);
            let (from, to) = if near == 0.0 { (p.x, p.x) } else { (p.x + left * near, p.x + right * near) };
            let runs = &self.runs.items[self.runs.row_from(row, |run| run.1 < from - CONE_SLACK)];
            for &(begin, end) in runs.iter().take_while(|run| run.0 <= to + CONE_SLACK) {
                work += 1;
                // A line that leans right is nearest to the run's left end on the near line, one that leans left on
                // the far line; likewise at the right end.
                let (begin, end) = (begin - p.x, end - p.x);
                let left = math::max(left, begin / if begin > 0.0 { near } else { far });
                let right = math::min(right, end / if end < 0.0 { near } else { far });
                if left > right + CONE_SLACK {
                    continue;
                }
                let (from, to) = (p.x + left * far - CONE_SLACK, p.x + right * far + CONE_SLACK);
                let seen = self.corners.row_from(far_line, |corner| corner.at.x < from);
                found.extend(seen.take_while(|&index| self.corners.items[index].at.x <= to));
                cones.push(Cone { row: row + step, slopes: (left, right) });
            }
        }
        work
    }

    /// Adds to `found` the next corner on the grid line of `p`, to the right (`side` 1) or to the left (−1).
    ///
    /// The corners behind it on the line are reached through it.
    fn look_along(&self, p: Vec2, side: f64, found: &mut Vec<usize>) {
        if p.y != p.y.floor() {
            return;
        }
        let beyond = self.corners.row_from(p.y as i32, |corner| corner.at.x <= p.x);
        let before = self.corners.row(p.y as i32).start..self.corners.row_from(p.y as i32, |c| c.at.x < p.x).start;
        found.extend(if side > 0.0 { beyond.into_iter().next() } else { before.into_iter().next_back() });
    }

    /// Adds to `found` the corners to which a taut path that arrives at `corner` in direction `arrival` may go on, and perhaps
    /// some to which it may not; returns the work.
    fn look_around(&self, corner: Corner, arrival: Vec2, cones: &mut Vec<Cone>, found: &mut Vec<usize>) -> u64 {
        let Corner { at, towards } = corner;
        let slope = if arrival.y == 0.0 { f64::INFINITY } else { (arrival.x / arrival.y).abs() };
        // The path bends towards the blocked cell, by anything from straight on to along the cell's side,
        // which lies along the row or across it.
        let is_along_row = arrival.x * towards.x >= 0.0 && arrival.y * towards.y <= 0.0;
        let (side, step, low, high) = if is_along_row {
            (towards.x, -towards.y, slope - CONE_SLACK, f64::INFINITY)
        } else {
            (-towards.x, towards.y, 0.0, slope + CONE_SLACK)
        };
        if is_along_row || arrival.y == 0.0 {
            self.look_along(at, side, found);
        }
        let slopes = if side > 0.0 { (low, high) } else { (-high, -low) };
        self.look(at, step as i32, slopes, cones, found)
    }

    /// Length of the shortest way from `start` to `goal`, cells; `None` without a way or above the bound of work.
    fn optimum(&self, start: Vec2, goal: Vec2) -> Option<f64> {
        if self.sees(start, goal) {
            return Some((goal - start).norm());
        }
        let corners = &self.corners.items;
        // The goal and the start come after the corners.
        let (goal_index, start_index) = (corners.len(), corners.len() + 1);
        let at = |index: usize| match corners.get(index) {
            Some(corner) => corner.at,
            None if index == goal_index => goal,
            None => start,
        };
        let mut length = vec![f64::INFINITY; corners.len() + 2];
        let mut parent = vec![start_index; corners.len() + 2];
        length[start_index] = 0.0;
        // Lengths are not negative, so their bits are ordered as they are; ties go to the lower index.
        let estimate = |length: f64, p: Vec2| (length + (goal - p).norm()).to_bits();
        let mut open = BinaryHeap::from([Reverse((estimate(0.0, start), start_index))]);
        let (mut cones, mut found, mut work) = (Vec::new(), Vec::new(), 0);
        while let Some(Reverse((sum, index))) = open.pop() {
            if index == goal_index {
                return Some(length[goal_index]);
            }
            let here = at(index);
            if sum != estimate(length[index], here) {
                continue; // reached by a shorter way since
            }
            found.clear();
            found.push(goal_index);
            if let Some(&corner) = corners.get(index) {
                work += self.look_around(corner, here - at(parent[index]), &mut cones, &mut found);
            } else {
                for (step, side) in [(1, 1.0), (-1, -1.0)] {
                    work += self.look(here, step, (f64::NEG_INFINITY, f64::INFINITY), &mut cones, &mut found);
                    self.look_along(here, side, &mut found);
                }
            }
            for &next in &found {
                work += 1;
                let leg = at(next) - here;
                let is_tangent = |corner: &Corner| leg.x * leg.y * corner.towards.x * corner.towards.y <= 0.0;
                let reached = length[index] + leg.norm();
                if reached >= length[next] || !corners.get(next).is_none_or(is_tangent) {
                    continue;
                }
                work += (leg.x.abs() + leg.y.abs()) as u64;
                if self.sees(here, at(next)) {
                    (length[next], parent[next]) = (reached, index);
                    open.push(Reverse((estimate(reached, at(next)), next)));
                }
            }
            if work > WORK_MAX {
                return None;
            }
        }
        None
    }
}

/// The crossings of a line with the grid lines of one axis.
struct AxisWalk {
    /// The cell in which the line begins, on the side it goes to.
    cell: i32,
    /// +1 or −1.
    step: i32,
    /// Distance from the beginning to the first grid line ahead, cells; above 0.
    to_first: f64,
    /// Grid lines strictly between beginning and end.
    left: i32,
}

impl AxisWalk {
    fn new(from: f64, to: f64) -> Self {
        if to > from {
            let cell = from.floor();
            Self { cell: cell as i32, step: 1, to_first: cell + 1.0 - from, left: (to.ceil() - cell) as i32 - 1 }
        } else {
            let cell = from.ceil() - 1.0;
            Self { cell: cell as i32, step: -1, to_first: from - cell, left: (cell - to.floor()) as i32 }
        }
    }
}

/// Whether a point may go parallel to an axis, from `from` to `to` on it, at `across` on the other.
fn clear_along(from: f64, to: f64, across: f64, is_blocked: impl Fn(i32, i32) -> bool) -> bool {
    let (low, high) = (math::min(from, to), math::max(from, to));
    let cells = low.floor() as i32..high.ceil() as i32;
    let side = across.floor() as i32;
    if across != across.floor() {
        return cells.into_iter().all(|cell| !is_blocked(cell, side));
    }
    // On a grid line: not between two blocked cells, nor from beside one to beside one on the other side.
    let (mut below_before, mut above_before) = (false, false);
    for cell in cells {
        let (below, above) = (is_blocked(cell, side - 1), is_blocked(cell, side));
        let crosses = (below && above_before) || (above && below_before);
        if crosses || (below && above) {
            return false;
        }
        (below_before, above_before) = (below, above);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::rng::{EpisodeSeed, Purpose, Stream};
    use crate::world::{Shape, StaticMap};
    use std::sync::Arc;

    /// A second method, in whole numbers (half cells): the visibility graph over *every* lattice point
    /// and both ends, each line tested against each blocked square, each edge between two of them and
    /// each point where two meet diagonally; then Dijkstra over all pairs.
    mod brute_force {
        use super::*;

        type Point = (i64, i64);

        fn cross(a: Point, b: Point, c: Point) -> i64 {
            (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
        }

        fn strictly_between(a: Point, b: Point, p: Point) -> bool {
            let dot = (p.0 - a.0) * (b.0 - a.0) + (p.1 - a.1) * (b.1 - a.1);
            let squared = (b.0 - a.0) * (b.0 - a.0) + (b.1 - a.1) * (b.1 - a.1);
            cross(a, b, p) == 0 && dot > 0 && dot < squared
        }

        /// Whether the line enters the open square of side 2 at `low`: no axis and no normal separates them.
        fn enters(a: Point, b: Point, low: Point) -> bool {
            let high = (low.0 + 2, low.1 + 2);
            if a.0.max(b.0) <= low.0 || a.0.min(b.0) >= high.0 || a.1.max(b.1) <= low.1 || a.1.min(b.1) >= high.1 {
                return false;
            }
            let sides = [low, high, (low.0, high.1), (high.0, low.1)].map(|corner| cross(a, b, corner));
            !(sides.iter().all(|&s| s >= 0) || sides.iter().all(|&s| s <= 0))
        }

        fn sees(grid: &OccupancyGrid, a: Point, b: Point) -> bool {
            let is_blocked = |col: i64, row: i64| !grid.is_free(Cell { col: col as i32, row: row as i32 });
            for row in -1..=i64::from(grid.rows()) {
                for col in -1..=i64::from(grid.cols()) {
                    let blocked = is_blocked(col, row);
                    if blocked && enters(a, b, (2 * col, 2 * row)) {
                        return false;
                    }
                    // The middle of an edge between two blocked cells, or its ends, on the line's way.
                    let (x, y) = (2 * col, 2 * row);
                    let up = blocked && is_blocked(col, row - 1);
                    if up && a.1 == y && b.1 == y && a.0.min(b.0) < x + 2 && a.0.max(b.0) > x {
                        return false;
                    }
                    let left = blocked && is_blocked(col - 1, row);
                    if left && a.0 == x && b.0 == x && a.1.min(b.1) < y + 2 && a.1.max(b.1) > y {
                        return false;
                    }
                    let meet = (blocked && is_blocked(col - 1, row - 1))
                        || (is_blocked(col - 1, row) && is_blocked(col, row - 1));
                    if meet && strictly_between(a, b, (x, y)) {
                        return false;
                    }
                }
            }
            true
        }

        pub fn length(grid: &OccupancyGrid, start: Cell, goal: Cell) -> Option<f64> {
            let centre = |c: Cell| (2 * i64::from(c.col) + 1, 2 * i64::from(c.row) + 1);
            let is_blocked = |col: i32, row: i32| !grid.is_free(Cell { col, row });
            let mut points = vec![centre(start), centre(goal)];
            for row in 0..=grid.rows() {
                for col in 0..=grid.cols() {
                    let diagonal = (is_blocked(col, row) && is_blocked(col - 1, row - 1))
                        || (is_blocked(col - 1, row) && is_blocked(col, row - 1));
                    if !diagonal {
                        points.push((2 * i64::from(col), 2 * i64::from(row)));
                    }
                }
            }
            let mut best = vec![f64::INFINITY; points.len()];
            let mut done = vec![false; points.len()];
            best[0] = 0.0;
            loop {
                let open = (0..points.len()).filter(|&i| !done[i] && best[i].is_finite());
                let at = open.min_by(|&i, &j| best[i].total_cmp(&best[j]))?;
                if at == 1 {
                    return Some(best[1] * grid.resolution_m() / 2.0);
                }
                done[at] = true;
                for to in 0..points.len() {
                    let (a, b) = (points[at], points[to]);
                    if !done[to] && sees(grid, a, b) {
                        let squared = (b.0 - a.0) * (b.0 - a.0) + (b.1 - a.1) * (b.1 - a.1);
                        let reached = best[at] + (squared as f64).sqrt();
                        if reached < best[to] {
                            best[to] = reached;
                        }
                    }
                }
            }
        }
    }

    fn stream(entity: u64) -> Stream {
        EpisodeSeed { seed: 11, episode: 0 }.stream(Purpose::Map, entity)
    }

    fn random_grid(draws: &mut Stream, cols: i32, rows: i32, resolution_m: f64, share: f64) -> OccupancyGrid {
        let mut grid = OccupancyGrid::empty(cols, rows, resolution_m);
        for index in 0..(cols * rows) as usize {
            if draws.uniform() < share {
                grid.set_occupied(grid.cell(index));
            }
        }
        grid
    }

    fn random_cell(draws: &mut Stream, grid: &OccupancyGrid) -> Cell {
        grid.cell(draws.index(grid.occupied().len()))
    }

    fn scene(grid: OccupancyGrid, start: Vec2, goal: Vec2, unknown_static: Vec<UnknownStatic>) -> Scene {
        let map = Arc::new(StaticMap::new(grid));
        Scene { unknown_static, ..Scene::new(&map, Pose { position: start, theta: 0.0 }, goal) }
    }

    #[test]
    fn equals_brute_force_on_random_maps() {
        let (mut found, mut none) = (0, 0);
        for case in 0..600 {
            let draws = &mut stream(case);
            // 0.1 and 0.3 m are no binary fractions: centres must survive the division.
            let resolution_m = [1.0, 0.1, 0.3][case as usize % 3];
            let share = draws.range(0.05, 0.5);
            let (cols, rows) = (3 + draws.index(6) as i32, 3 + draws.index(6) as i32);
            let grid = random_grid(draws, cols, rows, resolution_m, share);
            let (start, goal) = (random_cell(draws, &grid), random_cell(draws, &grid));
            if !grid.is_free(start) || !grid.is_free(goal) {
                continue;
            }
            let expected = brute_force::length(&grid, start, goal);
            let computed = any_angle_m(&grid, grid.centre(start), grid.centre(goal));
            match (expected, computed) {
                (Some(expected), Some(computed)) => {
                    assert!((expected - computed).abs() < 1e-9, "case {case}: {computed}, brute force {expected}");
                    found += 1;
                }
                (None, None) => none += 1,
                _ => panic!("case {case}: {computed:?}, brute force {expected:?}"),
            }
        }
        assert!(found > 200 && none > 20, "the cases say little: {found} ways, {none} times none");
    }

    #[test]
    fn bends_at_the_corner_of_a_block() {
        // The straight line enters the block [1, 2] × [1, 3]; the way bends at (2, 1):
        // √(1.5² + 0.5²) + √(1.5² + 2.5²) = 1.5811 + 2.9155 m.
        let grid = OccupancyGrid::from_ascii(&["....", ".#..", ".#..", "...."], 1.0);
        let length = any_angle_m(&grid, Vec2::new(0.5, 0.5), Vec2::new(3.5, 3.5)).unwrap();
        assert!((length - (2.5f64.sqrt() + 8.5f64.sqrt())).abs() < 1e-12, "{length}");
    }

    #[test]
    fn no_way_leads_between_blocks_that_touch_at_a_corner() {
        let grid = OccupancyGrid::from_ascii(&[".#", "#."], 1.0);
        assert_eq!(any_angle_m(&grid, Vec2::new(0.5, 1.5), Vec2::new(1.5, 0.5)), None);
        assert_eq!(any_angle_m(&grid, Vec2::new(0.5, 0.5), Vec2::new(1.5, 0.5)), None); // starts inside
    }

    #[test]
    fn arbitrary_ends_obey_the_triangle_inequality_and_symmetry() {
        for case in 0..400 {
            let draws = &mut stream(10_000 + case);
            let grid = random_grid(draws, 14, 9, 0.5, 0.25);
            let mut point = || loop {
                let p = Vec2::new(draws.range(0.0, 7.0), draws.range(0.0, 4.5));
                if grid.is_free(grid.cell_at(p)) {
                    return p;
                }
            };
            let (a, b, c) = (point(), point(), point());
            let (ab, ba) = (any_angle_m(&grid, a, b), any_angle_m(&grid, b, a));
            assert_eq!(ab.is_some(), ba.is_some());
            let (Some(ab), Some(ba)) = (ab, ba) else { continue };
            assert!((ab - ba).abs() < 1e-9, "case {case}: {ab} there, {ba} back");
            assert!(ab >= (a - b).norm() - 1e-12);
            if let (Some(ac), Some(cb)) = (any_angle_m(&grid, a, c), any_angle_m(&grid, c, b)) {
                assert!(ab <= ac + cb + 1e-9, "case {case}: a detour is shorter");
            }
        }
    }

    #[test]
    fn blocked_cells_are_wholly_within_the_radius_of_one_obstacle() {
        // Sampled: 21 × 21 points of each square, the border included, against every obstacle.
        let on = |square: Rect, i: i32, j: i32| {
            square.min + Vec2::new(f64::from(i) / 20.0, f64::from(j) / 20.0).component_mul(&(square.max - square.min))
        };
        for case in 0..60 {
            let draws = &mut stream(20_000 + case);
            let grid = random_grid(draws, 13, 11, 0.1, 0.04);
            let radius_m = draws.range(0.05, 0.35);
            let pose = Pose::new(draws.range(0.0, 1.3), draws.range(0.0, 1.1), draws.range(-3.0, 3.0));
            let shape = if case % 2 == 0 {
                Shape::Disc { radius_m: draws.range(0.05, 0.3) }
            } else {
                Shape::Rectangle { half_m: Vec2::new(draws.range(0.05, 0.4), draws.range(0.05, 0.3)) }
            };
            let obstacle = UnknownStatic::new(pose, shape);
            let goal = Vec2::new(-50.0, -50.0); // so that its tolerance opens nothing
            let blocked = blocked_cells(&scene(grid.clone(), goal, goal, vec![obstacle.clone()]), radius_m, 0.0);
            let reach = radius_m - 1e-3;
            for index in 0..grid.occupied().len() {
                let cell = grid.cell(index);
                let square = grid.square(cell);
                let within = |distance: &dyn Fn(Vec2) -> f64| {
                    (0..=20).all(|i| (0..=20).all(|j| distance(on(square, i, j)) <= reach + 1e-12))
                };
                let ring = (-1..=grid.rows()).flat_map(|row| (-1..=grid.cols()).map(move |col| Cell { col, row }));
                let expected = within(&|p| obstacle.distance_m(p))
                    || ring
                        .filter(|&c| !grid.is_free(c))
                        .any(|c| c == cell || within(&|p| grid.square(c).signed_distance(p)));
                assert_eq!(!blocked.is_free(cell), expected, "case {case}, {cell:?}");
            }
        }
    }

    #[test]
    fn a_static_that_only_touches_a_cell_does_not_lengthen_the_bound() {
        // Straight on at y = 1.5 through a pallet that covers no whole cell: 5 m, though the robot must go round.
        let pallet = UnknownStatic::new(Pose::new(3.0, 1.5, 0.0), Shape::Rectangle { half_m: Vec2::new(0.4, 0.6) });
        let grid = OccupancyGrid::empty(6, 3, 1.0);
        let (start, goal) = (Vec2::new(0.5, 1.5), Vec2::new(5.5, 1.5));
        let through = shortest_m(&scene(grid.clone(), start, goal, vec![pallet.clone()]), 0.25, 0.25).unwrap();
        assert!((through - 5.0).abs() < 1e-12);
        // Grown to cover the cells (2, 1) and (3, 1), it does: over (2, 2) and (4, 2), 2·√(1.5² + 0.5²) + 2.
        let pallet = UnknownStatic::new(pallet.pose(), Shape::Rectangle { half_m: Vec2::new(1.0, 0.6) });
        let round = shortest_m(&scene(grid, start, goal, vec![pallet]), 0.25, 0.25).unwrap();
        assert!((round - (2.0 * 2.5f64.sqrt() + 2.0)).abs() < 1e-12, "{round}");
    }

    #[test]
    fn a_wall_thinner_than_the_tolerance_does_not_bind_at_the_goal() {
        // The goal lies 0.06 m behind a wall of 0.1 m; a robot may stop before it, 0.5 m from the goal.
        let mut grid = OccupancyGrid::empty(40, 20, 0.1);
        for row in 0..19 {
            grid.set_occupied(Cell { col: 20, row });
        }
        let (start, goal) = (Vec2::new(0.55, 0.55), Vec2::new(2.16, 0.55));
        let open = shortest_m(&scene(grid.clone(), start, goal, Vec::new()), 0.05, 0.5).unwrap();
        assert!((open - 1.61).abs() < 1e-9, "{open}");
        let shut = shortest_m(&scene(grid, start, goal, Vec::new()), 0.05, 0.05).unwrap();
        assert!(shut > 3.0, "{shut}");
    }

    #[test]
    fn equals_the_published_any_angle_optima() {
        use crate::map::formats::movingai;
        use std::io::Write as _;
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/benchmarks");
        if !folder.exists() {
            writeln!(std::io::stderr(), "skipped: ../shared/benchmarks not found").expect("stderr");
            return;
        }
        let read = |name: String| std::fs::read_to_string(folder.join(name)).unwrap();
        for (name, count) in [("random-32-32-20", 200), ("room-64-64-8", 200), ("arena", 160), ("Berlin_0_256", 200)] {
            let grid = movingai::parse(&read(format!("movingai/{name}.map"))).unwrap();
            let queries = movingai::parse_queries(&read(format!("anyangle/{name}.anyangle-centre.scen"))).unwrap();
            assert!(queries.len() >= count, "{name}: {} queries", queries.len());
            for query in queries {
                let centre = |c: Cell| grid.centre(Cell { row: grid.rows() - 1 - c.row, ..c });
                let length = any_angle_m(&grid, centre(query.start), centre(query.goal)).unwrap();
                assert!((length - query.optimal_length).abs() < 5e-9, "{name} {query:?}: {length}");
            }
        }
    }
}
