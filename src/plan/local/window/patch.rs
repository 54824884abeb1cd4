//! Distance to the believed static obstacles, ready to be looked up many times around the robot.
//!
//! The obstacles are the closed squares of occupied cells and everything outside the map. A patch
//! holds the *squared* distance D at the nodes of a lattice whose pitch h divides the cell side, so
//! that every corner of every square is a node and D, in units of h², is an exact integer.
//!
//! Between the nodes: D(x) − |x|² = min over obstacle points p of (|p|² − 2 p·x) is a minimum of linear
//! functions, hence concave, and bilinear interpolation, being a mean whose weights reproduce the
//! point, never exceeds a concave function. With f, g the fractions of x inside its lattice cell,
//!
//! ```text
//! D(x) ≥ bilinear(D)(x) − f (1 − f) − g (1 − g)        (h = 1)
//! ```
//!
//! so the distance used is never larger than the true one, with no margin to be guessed. It is exact
//! where one obstacle corner is nearest, too small by up to h²/(8·distance) beside a straight
//! wall (5 mm at 0.25 m, h = 0.1 m), and by at most about 0.7 h where obstacles on several sides are equally near.
//! Capping D keeps it concave.
//!
//! The lattice is anchored to the map and the values are functions of the map alone, so an answer
//! depends on the belief and the point, never on where the patch lay or how long it has been in use.

use super::lanes::Lanes;
use crate::geometry::Vec2;
use crate::map::{Cell, OccupancyGrid};
use crate::observation::Belief;

/// Largest pitch of the lattice, m. Smaller is more exact and costs its square in building.
const PITCH_MAX_M: f64 = 0.1;

/// Distance that the robot may move before a patch is built anew, m. Larger patches are built less often, but cost more.
const SLACK_M: f64 = 1.0;

/// Most nodes of a patch: numbers up to 2²³ are read from the mantissa of an `f32`.
const NODES_MAX: usize = 1 << 23;

/// Adding this to an `f32` of small magnitude rounds it to a whole number.
const ROUND: f32 = 12_582_912.0; // 1.5 · 2²³

/// Adding this to a whole `f32` in 0..2²³ leaves the number in the mantissa's bits.
const TO_BITS: f32 = 8_388_608.0; // 2²³

/// Squared distances around the robot.
#[derive(Clone, Debug, Default)]
pub(super) struct Patch {
    /// Per lattice cell the bilinear form a + b f + c g + d f g of the squared distances at its corners, in h².
    forms: Vec<[f32; 4]>,
    /// Lattice coordinates of the first cell.
    first: [i64; 2],
    /// Number of lattice cells along x and y.
    size: [usize; 2],
    /// The inputs from which `forms` was built; `None` before the first use.
    key: Option<Key>,
    build: Build,
}

/// Inputs on which the values depend, within one episode.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    revision: u64,
    cols: i32,
    rows: i32,
    resolution_m: f64,
    cap: f32,
}

/// A point on the lattice from which lookups are made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    /// Place of the point inside its lattice cell, in [0, 1]: a function of the point alone.
    fraction: [f32; 2],
    /// Index of that cell in the patch.
    index: f32,
    /// Lattice cells per row of the patch.
    stride: f32,
}

/// Number of lattice intervals per cell: at most [`PITCH_MAX_M`] each, and even unless 1, so that
/// the middle of a lane of any whole number of coarse cells lies on nodes.
fn intervals_per_cell(resolution_m: f64) -> i64 {
    let least = (resolution_m / PITCH_MAX_M - 1e-9).ceil() as i64;
    if least <= 1 { 1 } else { least + least % 2 }
}

/// Pitch of the lattice on a map, m.
pub(super) fn pitch_m(grid: &OccupancyGrid) -> f64 {
    grid.resolution_m() / intervals_per_cell(grid.resolution_m()) as f64
}

impl Patch {
    /// Forgets the map.
    pub(super) fn reset(&mut self) {
        self.key = None;
    }

    /// Prepares lookups up to `reach_m` from `position` along each axis.
    ///
    /// Squared distances are capped at `cap` (in units of pitch²).
    pub(super) fn cover(&mut self, belief: &Belief, position: Vec2, reach_m: f64, cap: f32) -> Anchor {
        let grid = belief.grid();
        let key = Key {
            revision: belief.revision(),
            cols: grid.cols(),
            rows: grid.rows(),
            resolution_m: grid.resolution_m(),
            cap,
        };
        let pitch_m = pitch_m(grid);
        let lattice = position / pitch_m;
        let cell = [lattice.x.floor() as i64, lattice.y.floor() as i64];
        // One more on each side: f32 rounding at the rim.
        let half = (reach_m / pitch_m).ceil() as i64 + 1;
        let inside = |axis: usize| {
            let offset = cell[axis] - self.first[axis];
            offset >= half && offset + half < self.size[axis] as i64
        };
        if self.key != Some(key) || !inside(0) || !inside(1) {
            let half = half + (SLACK_M / pitch_m).ceil() as i64;
            self.first = [cell[0] - half, cell[1] - half];
            self.size = [2 * half as usize + 1; 2];
            assert!(is_coverable(reach_m, pitch_m), "speed times horizon is too long for this map's cells");
            self.build.run(grid, self.first, self.size, cap, &mut self.forms);
            self.key = Some(key);
        }
        Anchor {
            fraction: [(lattice.x - cell[0] as f64) as f32, (lattice.y - cell[1] as f64) as f32],
            index: ((cell[1] - self.first[1]) as usize * self.size[0] + (cell[0] - self.first[0]) as usize) as f32,
            stride: self.size[0] as f32,
        }
    }

    /// Lower bounds of the squared distances (units of pitch²) at the displacements (`x`, `y`) from the
    /// anchor, in units of the pitch; a little below 0 is possible at an obstacle.
    #[inline(always)]
    pub(super) fn squared_distances<L: Lanes>(&self, at: &Anchor, x: L, y: L) -> L {
        let (half, one, round) = (L::splat(0.5), L::splat(1.0), L::splat(ROUND));
        let (u, v) = (x + L::splat(at.fraction[0]), y + L::splat(at.fraction[1]));
        // floor(), up to the choice of cell for a point on a lattice line, which does not matter.
        let (col, row) = ((u - half + round) - round, (v - half + round) - round);
        let (f, g) = (u - col, v - row);
        let index = row * L::splat(at.stride) + col + L::splat(at.index);
        let [a, b, c, d] = (index + L::splat(TO_BITS)).look_up(&self.forms);
        a + b * f + (c + d * f) * g - f * (one - f) - g * (one - g)
    }
}

/// Builds patches; keeps its memory.
#[derive(Clone, Debug, Default)]
struct Build {
    /// Vertical distance to the nearest blocked node, per node of the patch and `margin` columns either side.
    vertical: Vec<f32>,
    /// 0 at blocked nodes of the row at hand, else 1.
    open: Vec<f32>,
    /// Rows since the last blocked node, per column.
    run: Vec<f32>,
    /// Squared distances at the nodes.
    nodes: Vec<f32>,
}

impl Build {
    /// Two passes of one dimension each (first down the columns, then along the rows), over plain rows of numbers.
    fn run(&mut self, grid: &OccupancyGrid, first: [i64; 2], size: [usize; 2], cap: f32, forms: &mut Vec<[f32; 4]>) {
        let [cols, rows] = [size[0] + 1, size[1] + 1]; // nodes
        let margin = cap.sqrt().ceil() as usize; // an obstacle farther off than this cannot matter
        let width = cols + 2 * margin;
        let left = first[0] - margin as i64;
        let far = (margin + 1) as f32;

        self.vertical.resize(width * rows, 0.0);
        self.open.resize(width, 0.0);
        self.run.resize(width, 0.0);
        self.nodes.resize(cols * rows, 0.0);
        let (below, above) = (first[1] - margin as i64, first[1] + (rows + margin) as i64);
        self.run.fill(far);
        for y in below..first[1] + rows as i64 {
            self.advance(grid, left, y, y > below);
            if y >= first[1] {
                let row = (y - first[1]) as usize * width;
                self.vertical[row..row + width].copy_from_slice(&self.run);
            }
        }
        self.run.fill(far);
        for y in (first[1]..above).rev() {
            self.advance(grid, left, y, y + 1 < above);
            if y < first[1] + rows as i64 {
                let row = (y - first[1]) as usize * width;
                for (up, &down) in self.vertical[row..row + width].iter_mut().zip(&self.run) {
                    *up = if down < *up { down } else { *up };
                }
            }
        }

        for (out, vertical) in self.nodes.chunks_exact_mut(cols).zip(self.vertical.chunks_exact_mut(width)) {
            out.fill(cap);
            if vertical.iter().all(|&g| g >= far) {
                continue;
            }
            for g in vertical.iter_mut() {
                *g *= *g;
            }
            for shift in 0..=2 * margin {
                let across = shift as f32 - margin as f32;
                let across = across * across;
                for (best, &g) in out.iter_mut().zip(&vertical[shift..shift + cols]) {
                    let candidate = g + across;
                    *best = if candidate < *best { candidate } else { *best };
                }
            }
        }

        forms.resize(size[0] * size[1], [0.0; 4]);
        for (row, forms) in forms.chunks_exact_mut(size[0]).enumerate() {
            let (low, high) = (&self.nodes[row * cols..][..cols], &self.nodes[(row + 1) * cols..][..cols]);
            for (col, form) in forms.iter_mut().enumerate() {
                let (p, q, r, s) = (low[col], low[col + 1], high[col], high[col + 1]);
                *form = [p, q - p, r - p, (s - r) - (q - p)];
            }
        }
    }

    /// Moves `run` on to lattice row `y`. `again` says that `open` holds the row next to it.
    fn advance(&mut self, grid: &OccupancyGrid, left: i64, y: i64, again: bool) {
        let per_cell = intervals_per_cell(grid.resolution_m());
        // Rows strictly inside one row of cells are alike.
        let inside = |y: i64| y.rem_euclid(per_cell) != 0;
        let neighbours_alike = again && inside(y) && inside(y - 1) && inside(y + 1);
        if !neighbours_alike {
            self.mark(grid, left, y, per_cell);
        }
        for (run, &open) in self.run.iter_mut().zip(&self.open) {
            *run = (*run + 1.0) * open;
        }
    }

    /// Fills `open` for lattice row `y`, whose first node is at lattice column `left`.
    fn mark(&mut self, grid: &OccupancyGrid, left: i64, y: i64, per_cell: i64) {
        let (right, top) = (i64::from(grid.cols()) * per_cell, i64::from(grid.rows()) * per_cell);
        if y <= 0 || y >= top {
            self.open.fill(0.0);
            return;
        }
        // A node on the line between two rows of cells touches the squares of both.
        let upper = (y / per_cell) as i32;
        let lower = if y % per_cell == 0 { upper - 1 } else { upper };
        self.open.fill(1.0);
        let last = left + self.open.len() as i64 - 1;
        for x in left..=last.min(0) {
            self.open[(x - left) as usize] = 0.0;
        }
        for x in right.max(left)..=last {
            self.open[(x - left) as usize] = 0.0;
        }
        let (first_col, last_col) = ((left / per_cell - 1).max(0), (last / per_cell).min(i64::from(grid.cols()) - 1));
        for col in first_col..=last_col {
            let cell = |row: i32| Cell { col: col as i32, row };
            if !grid.is_free(cell(lower)) || !grid.is_free(cell(upper)) {
                let (from, to) = ((col * per_cell).max(left), ((col + 1) * per_cell).min(last));
                for x in from..=to {
                    self.open[(x - left) as usize] = 0.0;
                }
            }
        }
    }
}

/// Whether a patch can reach `reach_m` every way at this pitch.
pub(super) fn is_coverable(reach_m: f64, pitch_m: f64) -> bool {
    let half = (reach_m / pitch_m).ceil() + 1.0 + (SLACK_M / pitch_m).ceil();
    let side = 2.0 * half + 1.0;
    side * side <= NODES_MAX as f64
}

#[cfg(test)]
mod tests {
    use super::super::lanes::Plain;
    use super::*;
    use crate::geometry::Rect;
    use crate::math;
    use crate::rng::{EpisodeSeed, Purpose, Stream};

    /// Distance to the nearest occupied square or to the border, by looking at every cell.
    fn brute_force_m(squares: &[Rect], extent: Vec2, p: Vec2) -> f64 {
        let edge = math::min(math::min(p.x, extent.x - p.x), math::min(p.y, extent.y - p.y));
        math::max(squares.iter().map(|square| square.signed_distance(p)).fold(edge, math::min), 0.0)
    }

    fn random_grid(stream: &mut Stream, side: i32, resolution_m: f64, density: f64) -> Belief {
        let mut grid = OccupancyGrid::empty(side, side, resolution_m);
        for row in 0..side {
            for col in 0..side {
                if stream.uniform() < density {
                    grid.set_occupied(Cell { col, row });
                }
            }
        }
        Belief::from(&grid)
    }

    /// The distance that the patch gives at `p`, looked up from a robot at `from`.
    fn looked_up_m(patch: &mut Patch, belief: &Belief, from: Vec2, p: Vec2, cap: f32) -> f64 {
        let pitch_m = pitch_m(belief.grid());
        let anchor = patch.cover(belief, from, 3.0, cap);
        let offset = (p - from) / pitch_m;
        let (x, y) = (Plain::splat(offset.x as f32), Plain::splat(offset.y as f32));
        let squared = patch.squared_distances(&anchor, x, y).store()[3];
        math::max(f64::from(squared), 0.0).sqrt() * pitch_m
    }

    #[test]
    fn the_lattice_divides_the_cells() {
        for (resolution_m, intervals) in [(0.05, 1), (0.1, 1), (0.15, 2), (0.2, 2), (0.25, 4), (0.5, 6), (1.0, 10)] {
            assert_eq!(intervals_per_cell(resolution_m), intervals, "{resolution_m}");
        }
    }

    #[test]
    fn the_distance_never_exceeds_the_true_one_and_is_close_to_it() {
        let cap_m = 1.5;
        for (episode, (resolution_m, side)) in
            [(1.0, 12), (0.25, 40), (0.05, 160), (0.3, 30), (0.1, 90)].into_iter().enumerate()
        {
            let mut stream = EpisodeSeed { seed: 3, episode: episode as u64 }.stream(Purpose::Planner, 0);
            let mut sum_of_slack = 0.0;
            for density in [0.02, 0.2] {
                let density = if resolution_m < 0.2 { density / 20.0 } else { density };
                let belief = random_grid(&mut stream, side, resolution_m, density);
                let pitch_m = pitch_m(belief.grid());
                let cap = (cap_m / pitch_m * cap_m / pitch_m + 0.5) as f32;
                let mut patch = Patch::default();
                let grid = belief.grid();
                let occupied = (0..grid.occupied().len()).filter(|&index| grid.occupied()[index]);
                let squares: Vec<Rect> = occupied.map(|index| grid.square(grid.cell(index))).collect();
                let extent = f64::from(side) * resolution_m;
                for _ in 0..2000 {
                    let from = Vec2::new(stream.range(0.0, extent), stream.range(0.0, extent));
                    let p = from + Vec2::new(stream.range(-2.9, 2.9), stream.range(-2.9, 2.9));
                    let truth = math::min(brute_force_m(&squares, grid.extent_m(), p), cap_m);
                    let found = math::min(looked_up_m(&mut patch, &belief, from, p, cap), cap_m);
                    assert!(found <= truth + 2e-5 * pitch_m + 1e-6, "{p:?}: {found} instead of {truth}");
                    // Worst where obstacles on several sides are equally near, or next to a wall: ½ √2 h and √½ h.
                    assert!(truth - found <= 0.75 * pitch_m, "{p:?}: {found} instead of {truth}, h = {pitch_m}");
                    sum_of_slack += truth - found;
                }
            }
            let mean = sum_of_slack / 4000.0;
            assert!(mean < 0.006, "{resolution_m}: {mean} m too small on average");
        }
    }

    #[test]
    fn beside_a_wall_and_before_a_corner_the_slack_is_the_derived_one() {
        let mut grid = OccupancyGrid::empty(12, 12, 1.0);
        grid.set_occupied(Cell { col: 5, row: 5 });
        let belief = Belief::from(&grid);
        let mut patch = Patch::default();
        let mut at = |x: f64, y: f64| looked_up_m(&mut patch, &belief, Vec2::new(6.5, 6.5), Vec2::new(x, y), 900.0);
        // 0.25 m to the right of the square, half way between nodes along the wall: √(0.25² − 0.05²).
        assert!((at(6.25, 5.45) - 0.06f64.sqrt()).abs() < 1e-5, "{}", at(6.25, 5.45));
        // On a lattice line across the wall nothing is lost.
        assert!((at(6.25, 5.4) - 0.25).abs() < 1e-5, "{}", at(6.25, 5.4));
        // The corner (6, 6) alone is nearest: exact anywhere.
        assert!((at(6.33, 6.44) - 0.55).abs() < 1e-5, "{}", at(6.33, 6.44));
        assert_eq!(at(5.5, 5.5), 0.0);
    }

    #[test]
    fn outside_the_map_is_blocked() {
        let grid = OccupancyGrid::empty(4, 4, 1.0);
        let belief = Belief::from(&grid);
        let mut patch = Patch::default();
        let mut at = |x: f64, y: f64| looked_up_m(&mut patch, &belief, Vec2::new(2.0, 2.0), Vec2::new(x, y), 900.0);
        assert!((at(0.4, 2.0) - 0.4).abs() < 1e-5);
        assert!((at(3.0, 3.3) - 0.7).abs() < 1e-5);
        assert_eq!(at(-0.5, 2.0), 0.0);
        assert_eq!(at(2.0, 4.7), 0.0);
    }

    #[test]
    fn the_answer_does_not_depend_on_where_the_patch_lies() {
        let mut stream = EpisodeSeed { seed: 4, episode: 0 }.stream(Purpose::Planner, 0);
        let belief = random_grid(&mut stream, 30, 0.5, 0.15);
        let mut used = Patch::default();
        for _ in 0..300 {
            let from = Vec2::new(stream.range(0.0, 15.0), stream.range(0.0, 15.0));
            let p = from + Vec2::new(stream.range(-2.9, 2.9), stream.range(-2.9, 2.9));
            let again = looked_up_m(&mut used, &belief, from, p, 70.0);
            let fresh = looked_up_m(&mut Patch::default(), &belief, from, p, 70.0);
            assert_eq!(again.to_bits(), fresh.to_bits());
        }
    }

    #[test]
    fn a_new_obstacle_is_seen_at_once() {
        let grid = OccupancyGrid::empty(10, 10, 1.0);
        let mut belief = Belief::from(&grid);
        let mut patch = Patch::default();
        let (from, p) = (Vec2::new(5.0, 5.0), Vec2::new(6.5, 5.5));
        assert!(looked_up_m(&mut patch, &belief, from, p, 900.0) > 2.0);
        let cell = grid.square(Cell { col: 7, row: 5 });
        belief.add(cell, |square| square == cell);
        assert!((looked_up_m(&mut patch, &belief, from, p, 900.0) - 0.5).abs() < 1e-5);
    }
}
