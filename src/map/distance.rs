//! Exact Euclidean distance from cell centres to the nearest occupied square.
//!
//! # Integers
//!
//! In units of half a cell, a centre is 2|k| − 1 away from a square whose column is k ≠ 0 columns
//! off, and 0 where k = 0. With `f(0) = 0`, `f(k) = (2|k| − 1)²`, the squared distance to the square
//! at offset (k, m) is therefore `f(k) + f(m)`: a whole number, separable. Everything outside
//! the grid is blocked, so the border counts as a ring of occupied squares.
//!
//! # Two passes, linear time
//!
//! 1. *Columns.* Two sweeps over the rows count how many rows the nearest occupied cell of the own
//!    column is away, which gives `G(c) = f(rows away)` in each row.
//! 2. *Rows.* Wanted is `min over c' of f(c − c') + G(c')`. `f` is no parabola at 0, but seen from
//!    another column a square is its nearer vertical edge. Edge k lies between the columns k − 1
//!    and k, belongs to both, and so weighs `E(k) = min(G(k − 1), G(k))`, with `E = 0` at both ends
//!    (the border). From the centre of column c edge k is `2c + 1 − 2k` half cells away, hence
//!
//!    ```text
//!    D(c) = min( G(c), min over k of (2c + 1 − 2k)² + E(k) )
//!    ```
//!
//!    A square's farther edge never weighs less than the nearer one, so that it does no harm. The
//!    rest is the lower envelope of plain parabolas (Felzenszwalb & Huttenlocher, *Distance
//!    Transforms of Sampled Functions*, Theory of Computing, 2012; the integer separator is that of
//!    Meijster, Roerdink & Hesselink, *A General Algorithm for Computing Distance Transforms in
//!    Linear Time*, ISMM 2000). For edges i < j, the left one is at most the right one where
//!
//!    ```text
//!    (2c+1−2i)² + E(i) ≤ (2c+1−2j)² + E(j)   ⇔   2c ≤ i + j − 1 + (E(j) − E(i)) / 4(j−i)
//!    ```
//!
//!    so that ⌊(i + j − 1 + ⌊(E(j) − E(i)) / 4(j−i)⌋) / 2⌋ is the last column that the left one owns.
//!    At [`SIDE_MAX`] cells a side no value exceeds 2³⁰ + 2²⁸, and 32 bits hold them all.

use super::{Cell, OccupancyGrid, SIDE_MAX};

/// Distance from the centre of every cell to the nearest occupied square or to the border.
///
/// Kept as squared distance in units of (resolution / 2)², four bytes a cell.
#[derive(Debug, PartialEq)]
pub struct DistanceField {
    cols: usize,
    rows: usize,
    resolution_m: f64,
    squared: Vec<u32>,
}

impl Clone for DistanceField {
    fn clone(&self) -> Self {
        Self { squared: self.squared.clone(), ..*self }
    }

    fn clone_from(&mut self, source: &Self) {
        let mut squared = core::mem::take(&mut self.squared);
        squared.clone_from(&source.squared);
        *self = Self { squared, ..*source };
    }
}

/// Squared distance, in half cells, from a centre to a square `offset` rows (or columns) away.
const fn f(offset: u32) -> u32 {
    if offset == 0 {
        0
    } else {
        let half_cells = 2 * offset - 1;
        half_cells * half_cells
    }
}

/// A parabola of the lower envelope of one row.
#[derive(Clone, Copy, Debug)]
struct Arch {
    /// The edge at its lowest point.
    edge: i32,
    /// The value at its lowest point.
    weight: i32,
    /// The first column in which it is the lowest parabola.
    from: i32,
}

impl DistanceField {
    /// The field of a grid. Linear in the number of cells.
    ///
    /// # Panics
    /// If a side of the grid exceeds [`SIDE_MAX`]: the squares would not fit.
    pub fn new(grid: &OccupancyGrid) -> Self {
        let (cols, rows) = (grid.cols() as usize, grid.rows() as usize);
        assert!(cols <= SIDE_MAX && rows <= SIDE_MAX, "a grid has at most {SIDE_MAX} cells a side");
        let mut squared = rows_to_nearest_in_column(grid.occupied(), cols, rows);
        let mut envelope = Envelope::new(cols);
        for row in squared.chunks_exact_mut(cols) {
            envelope.apply(row);
        }
        Self { cols, rows, resolution_m: grid.resolution_m(), squared }
    }

    /// Updates the field for cells that have become occupied in `grid`. The result is, bit for bit, that of computing it anew.
    ///
    /// The cost is proportional to the changed cells (a few ns each, for each added cell on the outline of
    /// the added ones), and never much more than that of computing it anew.
    ///
    /// The cells that change for one new square are those that it is nearest to. On the way from such a
    /// centre straight to the square, the distance to the square falls by the way gone and
    /// that to any other square by no more: all of the way belongs to the new square. It need not pass
    /// through centres, though, so changed cells may be islands. But each cell it crosses has its
    /// centre within half a diagonal of it, hence is nearer to the new square than its old
    /// distance plus one diagonal. The cells with that weaker property (`is_near`) are connected along
    /// ways that go from the square outwards by row and column, and are swept row by row.
    ///
    /// # Panics
    /// If `grid` has another size than the field, or an added cell lies outside or is free.
    pub fn add(&mut self, grid: &OccupancyGrid, added: &[Cell]) {
        assert_eq!(grid.occupied().len(), self.squared.len(), "the field of this grid");
        assert_eq!(grid.cols() as usize, self.cols, "the field of this grid");
        let mut swept = 0;
        for &cell in added {
            let index = grid.index(cell);
            assert!(grid.occupied()[index], "an added cell is occupied");
            let Cell { col, row } = cell;
            let sides = [(col - 1, row), (col + 1, row), (col, row - 1), (col, row + 1)];
            if sides.into_iter().any(|(col, row)| grid.is_free(Cell { col, row })) {
                swept += self.add_square(cell);
            } else {
                // Whatever lies outside is nearer to one of the four.
                self.squared[index] = 0;
            }
            if swept > SWEEPS_MAX * self.squared.len() {
                *self = Self::new(grid);
                return;
            }
        }
    }

    /// Updates the field for one occupied cell and returns the number of cells examined.
    fn add_square(&mut self, cell: Cell) -> usize {
        let (col, row) = (cell.col as usize, cell.row as usize);
        if self.squared[row * self.cols + col] == 0 {
            return 0;
        }
        let mut swept = 0;
        let mut sweep = |row: usize, rows_away: usize, span| {
            let cells = &mut self.squared[row * self.cols..(row + 1) * self.cols];
            let next = sweep_row(cells, col, f(rows_away as u32), span);
            swept += next.map_or(span.1 - span.0 + 1, |(low, high)| high.max(span.1) - low.min(span.0) + 1);
            next
        };
        let own = sweep(row, 0, (col, col));
        let mut span = own;
        for above in row + 1..self.rows {
            let Some(before) = span else { break };
            span = sweep(above, above - row, before);
        }
        span = own;
        for below in (0..row).rev() {
            let Some(before) = span else { break };
            span = sweep(below, row - below, before);
        }
        swept
    }

    /// Metres from the cell's centre to the nearest occupied square or to the border; 0 in an
    /// occupied cell and outside.
    pub fn distance_m(&self, cell: Cell) -> f64 {
        f64::from(self.squared(cell)).sqrt() * (0.5 * self.resolution_m)
    }

    /// Square of [`Self::distance_m`] in units of (resolution / 2)²; 0 in an occupied cell and outside.
    pub fn squared(&self, cell: Cell) -> u32 {
        let Cell { col, row } = cell;
        if col < 0 || row < 0 || col as usize >= self.cols || row as usize >= self.rows {
            return 0;
        }
        self.squared[row as usize * self.cols + col as usize]
    }

    /// [`Self::squared`] of all cells, row-major, row 0 at the bottom.
    pub fn squares(&self) -> &[u32] {
        &self.squared
    }

    /// The least value of [`Self::squared`] that belongs to a free cell whose distance is at least
    /// `clearance_m` (less a tolerance of 1 nm, so that a lane of exactly that width is passable).
    pub fn threshold(&self, clearance_m: f64) -> u32 {
        let half_cells = (clearance_m - 1e-9) / (0.5 * self.resolution_m);
        // A cast saturates: beyond every distance of the field, no cell passes.
        if half_cells <= 1.0 { 1 } else { (half_cells * half_cells).ceil() as u32 }
    }
}

/// Average number of times that [`DistanceField::add`] examines a cell, above which computing anew is cheaper.
const SWEEPS_MAX: usize = 4;

/// Whether a square at squared distance `square` from a centre is at most one diagonal of a cell
/// (2√2 half cells) farther than the nearest known one at squared distance `known`.
fn is_near(square: u32, known: u32) -> bool {
    // √s ≤ √d + 2√2  ⇔  s − d − 8 ≤ √(32 d)
    let excess = i64::from(square) - i64::from(known) - 8;
    excess <= 0 || excess * excess <= 32 * i64::from(known)
}

/// Lowers one row's squared distances to those of a square in column `col`, whose rows contribute
/// `rows_squared`, and returns the first and last near column, if any.
///
/// Looks at the columns of `span`, the near ones of the row before, and on from its ends while near.
fn sweep_row(cells: &mut [u32], col: usize, rows_squared: u32, span: (usize, usize)) -> Option<(usize, usize)> {
    let cols = cells.len();
    let mut near = |at: usize| {
        let square = f(at.abs_diff(col) as u32) + rows_squared;
        let near = is_near(square, cells[at]);
        cells[at] = cells[at].min(square);
        near
    };
    let (low, high) = span;
    let mut found = None;
    for at in low..=high {
        if near(at) {
            let (first, _) = found.unwrap_or((at, at));
            found = Some((first, at));
        }
    }
    let (mut first, mut last) = found?;
    while first <= low && first > 0 && near(first - 1) {
        first -= 1;
    }
    while last >= high && last + 1 < cols && near(last + 1) {
        last += 1;
    }
    Some((first, last))
}

/// Rows from each cell to the nearest occupied one of its column, the border rows included.
fn rows_to_nearest_in_column(occupied: &[bool], cols: usize, rows: usize) -> Vec<u32> {
    let mut away = vec![0; occupied.len()];
    let mut nearest = vec![0; cols];
    for row in 0..rows {
        let cells = row * cols..(row + 1) * cols;
        for ((nearest, &occupied), away) in nearest.iter_mut().zip(&occupied[cells.clone()]).zip(&mut away[cells]) {
            *nearest = if occupied { 0 } else { *nearest + 1 };
            *away = *nearest;
        }
    }
    nearest.fill(0);
    for row in (0..rows).rev() {
        // An occupied cell is known by its 0, which the first sweep left.
        for (nearest, away) in nearest.iter_mut().zip(&mut away[row * cols..(row + 1) * cols]) {
            *nearest = (*nearest + 1).min(*away);
            *away = *nearest;
        }
    }
    away
}

/// The lower envelope of one row and its workspace.
struct Envelope {
    arches: Vec<Arch>,
}

impl Envelope {
    fn new(cols: usize) -> Self {
        Self { arches: Vec::with_capacity(cols + 1) }
    }

    /// Turns the rows to the nearest occupied cell of the own column into squared distances.
    fn apply(&mut self, row: &mut [u32]) {
        let cols = row.len() as i32;
        self.arches.clear();
        let mut left = 0; // G of the column left of the edge; the border's is 0
        for edge in 0..=cols {
            let right = row.get(edge as usize).map_or(0, |&away| f(away));
            let weight = left.min(right) as i32;
            left = right;
            let mut from = 0;
            while let Some(top) = self.arches.last() {
                let gap = edge - top.edge;
                let owned = (top.edge + edge - 1 + (weight - top.weight).div_euclid(4 * gap)).div_euclid(2);
                if owned >= top.from {
                    from = owned + 1;
                    break;
                }
                self.arches.pop();
            }
            if from < cols {
                self.arches.push(Arch { edge, weight, from });
            }
        }
        let mut end = cols;
        for arch in self.arches.iter().rev() {
            for col in arch.from..end {
                let half_cells = 2 * (col - arch.edge) + 1;
                let cell = &mut row[col as usize];
                *cell = f(*cell).min((half_cells * half_cells + arch.weight) as u32);
            }
            end = arch.from;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use crate::rng::{EpisodeSeed, Purpose, Stream};

    fn stream(entity: u64) -> Stream {
        EpisodeSeed { seed: 1, episode: 0 }.stream(Purpose::Map, entity)
    }

    fn random_grid(stream: &mut Stream, side_max: usize, density: f64) -> OccupancyGrid {
        let (cols, rows) = (1 + stream.index(side_max), 1 + stream.index(side_max));
        let mut grid = OccupancyGrid::empty(cols as i32, rows as i32, 0.5);
        for index in 0..cols * rows {
            if stream.uniform() < density {
                grid.set_occupied(grid.cell(index));
            }
        }
        grid
    }

    /// Distance by definition: every square, and the border as four half planes, in metres.
    fn by_definition(grid: &OccupancyGrid, cell: Cell) -> f64 {
        let (centre, extent) = (grid.centre(cell), grid.extent_m());
        let to_border = [centre.x, extent.x - centre.x, centre.y, extent.y - centre.y];
        let squares = (0..grid.occupied().len()).filter(|&index| grid.occupied()[index]);
        let to_squares = squares.map(|index| math::max(grid.square(grid.cell(index)).signed_distance(centre), 0.0));
        to_border.into_iter().chain(to_squares).fold(f64::INFINITY, math::min)
    }

    #[test]
    fn distances_worked_out_by_hand() {
        // The centre of (3, 3) is (1.5, 1.5) half cells from the corner of the square (1, 1): 3² + 3².
        let grid = OccupancyGrid::from_ascii(
            &[".......", ".......", ".......", ".......", ".......", ".#.....", "......."],
            1.0,
        );
        let field = DistanceField::new(&grid);
        assert_eq!(field.squared(Cell { col: 3, row: 3 }), 18);
        assert_eq!(field.squared(Cell { col: 1, row: 3 }), 9);
        assert_eq!(field.squared(Cell { col: 1, row: 1 }), 0);
        assert_eq!(field.squared(Cell { col: 2, row: 2 }), 2);
        // The lower left cell is half a cell from the border.
        assert_eq!(field.distance_m(Cell { col: 0, row: 0 }), 0.5);
        assert_eq!(field.distance_m(Cell { col: 3, row: 4 }), 2.5);
        assert_eq!(field.distance_m(Cell { col: -1, row: 0 }), 0.0);
        assert_eq!(field.distance_m(Cell { col: 0, row: 7 }), 0.0);
    }

    #[test]
    fn the_field_is_the_distance_by_definition() {
        let mut stream = stream(0);
        for density in [0.0, 0.002, 0.02, 0.2, 0.6] {
            for _ in 0..60 {
                let grid = random_grid(&mut stream, 40, density);
                let field = DistanceField::new(&grid);
                for index in 0..grid.occupied().len() {
                    let cell = grid.cell(index);
                    let expected = by_definition(&grid, cell);
                    assert!((field.distance_m(cell) - expected).abs() < 1e-12, "{cell:?}\n{grid:?}");
                }
            }
        }
    }

    #[test]
    fn adding_equals_computing_anew() {
        let mut stream = stream(1);
        for round in 0..400 {
            let mut grid = random_grid(&mut stream, 70, [0.0, 0.003, 0.02, 0.2][round % 4]);
            let mut field = DistanceField::new(&grid);
            for _ in 0..12 {
                // A few single cells or one block, as when an obstacle is seen.
                let mut added = Vec::new();
                let corner = grid.cell(stream.index(grid.occupied().len()));
                let (width, height) = (1 + stream.index(4) as i32, 1 + stream.index(4) as i32);
                for row in corner.row..(corner.row + height).min(grid.rows()) {
                    for col in corner.col..(corner.col + width).min(grid.cols()) {
                        grid.set_occupied(Cell { col, row });
                        added.push(Cell { col, row });
                    }
                }
                field.add(&grid, &added);
                assert_eq!(field, DistanceField::new(&grid), "round {round}, added {added:?}");
            }
        }
    }

    #[test]
    fn single_cells_added_to_an_open_map_equal_computing_anew() {
        // Sparse squares have long, thin regions, where changed cells are islands.
        let mut stream = stream(2);
        for _ in 0..20 {
            let mut grid = OccupancyGrid::empty(150, 130, 1.0);
            let mut field = DistanceField::new(&grid);
            for _ in 0..60 {
                let cell = grid.cell(stream.index(grid.occupied().len()));
                grid.set_occupied(cell);
                field.add(&grid, &[cell]);
                assert_eq!(field, DistanceField::new(&grid), "added {cell:?}");
            }
        }
    }

    #[test]
    fn adding_what_would_cost_more_than_computing_anew_is_the_same() {
        // A line added from its end: each cell takes over what lies beyond it from the one before.
        let mut grid = OccupancyGrid::empty(64, 64, 1.0);
        let mut field = DistanceField::new(&grid);
        let mut one_by_one = field.clone();
        let added: Vec<Cell> = (1..63).map(|col| Cell { col, row: 31 }).collect();
        for &cell in &added {
            grid.set_occupied(cell);
        }
        let swept: usize = added.iter().map(|&cell| one_by_one.add_square(cell)).sum();
        assert!(swept > SWEEPS_MAX * grid.occupied().len(), "{swept} looks do not exceed the bound");
        field.add(&grid, &added);
        assert_eq!(field, DistanceField::new(&grid));
        assert_eq!(one_by_one, field);
    }

    #[test]
    fn a_threshold_separates_the_distances() {
        let grid = OccupancyGrid::empty(40, 40, 0.25);
        let field = DistanceField::new(&grid);
        for clearance_m in [-1.0, 0.0, 0.125, 0.25, 0.3, 0.375, 1.0, 1e9] {
            let threshold = field.threshold(clearance_m);
            for (index, &squared) in field.squares().iter().enumerate() {
                let far = field.distance_m(grid.cell(index)) >= clearance_m - 1e-9;
                assert_eq!(squared >= threshold, far, "{clearance_m} m at {squared}");
            }
        }
    }
}
