//! Connectivity of cells.
//!
//! Moves go to the 8 neighbours, a diagonal one only if both cells beside it are passable. Then
//! the same cell is reached by two straight moves as well. The reachable cells are therefore
//! those that moves to the 4 straight neighbours reach, and the fills below use these alone.

use super::{Cell, DistanceField, OccupancyGrid};

/// The cells where the centre of a disc of radius `clearance_m` may be, row-major: free, and at least
/// that far (less 1 nm) from every occupied square and from the border.
pub fn passable(field: &DistanceField, clearance_m: f64) -> Vec<bool> {
    let threshold = field.threshold(clearance_m);
    field.squares().iter().map(|&squared| squared >= threshold).collect()
}

/// The cells that a disc of radius `clearance_m` can reach from `from`, row-major; none if it
/// cannot stand at `from` or `from` lies outside.
///
/// # Panics
/// If `field` is not of the size of `grid`.
pub fn reachable(grid: &OccupancyGrid, field: &DistanceField, from: Cell, clearance_m: f64) -> Vec<bool> {
    let passable = passable(field, clearance_m);
    assert_eq!(grid.occupied().len(), passable.len(), "the field of this grid");
    let mut reached = vec![false; passable.len()];
    if grid.contains(from) && passable[grid.index(from)] {
        fill(grid, &passable, grid.index(from), &mut Vec::new(), |index| {
            !core::mem::replace(&mut reached[index], true)
        });
    }
    reached
}

/// The connected components of the passable cells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Components {
    labels: Vec<u32>,
    sizes: Vec<usize>,
}

impl Components {
    /// The parts of `passable` (row-major, of the size of `grid`), numbered from 1 in the order of
    /// their first cells.
    ///
    /// # Panics
    /// If `passable` is not of the size of `grid`.
    pub fn new(grid: &OccupancyGrid, passable: &[bool]) -> Self {
        assert_eq!(grid.occupied().len(), passable.len(), "one entry per cell");
        let (mut labels, mut sizes, mut stack) = (vec![0; passable.len()], Vec::new(), Vec::new());
        for index in 0..passable.len() {
            if passable[index] && labels[index] == 0 {
                let label = sizes.len() as u32 + 1;
                let mut size = 0;
                fill(grid, passable, index, &mut stack, |index| {
                    let fresh = labels[index] == 0;
                    labels[index] = label;
                    size += usize::from(fresh);
                    fresh
                });
                sizes.push(size);
            }
        }
        Self { labels, sizes }
    }

    /// The number of each cell's part, row-major; 0 for a cell that is not passable.
    pub fn labels(&self) -> &[u32] {
        &self.labels
    }

    /// Number of cells of each part; that of part k stands at index k − 1.
    pub fn sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// The number of the part with the most cells; ties go to the lowest number. `None` if no cell is passable.
    pub fn largest(&self) -> Option<u32> {
        let most = self.sizes.iter().max()?;
        let first = self.sizes.iter().position(|size| size == most)?;
        Some(first as u32 + 1)
    }

    /// Whether two cells, given by row-major index, are passable and in the same part.
    pub fn connected(&self, a: usize, b: usize) -> bool {
        self.labels[a] != 0 && self.labels[a] == self.labels[b]
    }
}

/// Visits the passable cells connected with `from`; `enter` returns whether a cell is new.
fn fill(
    grid: &OccupancyGrid,
    passable: &[bool],
    from: usize,
    stack: &mut Vec<usize>,
    mut enter: impl FnMut(usize) -> bool,
) {
    let (cols, cells) = (grid.cols() as usize, passable.len());
    enter(from);
    stack.push(from);
    while let Some(index) = stack.pop() {
        let col = index % cols;
        let sides = [
            (col > 0).then(|| index - 1),
            (col + 1 < cols).then_some(index + 1),
            index.checked_sub(cols),
            (index + cols < cells).then_some(index + cols),
        ];
        for side in sides.into_iter().flatten() {
            if passable[side] && enter(side) {
                stack.push(side);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{EpisodeSeed, Purpose};

    fn reached(lines: &[&str], from: Cell, clearance_m: f64) -> usize {
        let grid = OccupancyGrid::from_ascii(lines, 1.0);
        reachable(&grid, &DistanceField::new(&grid), from, clearance_m).iter().filter(|&&r| r).count()
    }

    const ORIGIN: Cell = Cell { col: 0, row: 0 };

    #[test]
    fn no_way_leads_between_diagonal_neighbours_that_touch() {
        assert_eq!(reached(&["#.", ".#"], ORIGIN, 0.0), 1);
        assert_eq!(reached(&["..", ".#"], ORIGIN, 0.0), 3);
    }

    #[test]
    fn a_lane_of_exactly_the_diameter_is_passable() {
        let lane = ["#####", ".....", "#####"];
        let from = Cell { col: 0, row: 1 };
        // Centres of the lane lie 0.5 m from the racks.
        assert_eq!(reached(&lane, from, 0.5), 5);
        assert_eq!(reached(&lane, from, 0.51), 0);
    }

    #[test]
    fn blocked_and_outside_cells_reach_nothing() {
        assert_eq!(reached(&["..", "#."], ORIGIN, 0.0), 0);
        assert_eq!(reached(&["..", "#."], Cell { col: 2, row: 0 }, 0.0), 0);
    }

    #[test]
    fn parts_are_numbered_by_their_first_cell() {
        let grid = OccupancyGrid::from_ascii(&["...", "##.", ".#."], 1.0);
        let parts = Components::new(&grid, &passable(&DistanceField::new(&grid), 0.0));
        assert_eq!(parts.labels(), [1, 0, 2, 0, 0, 2, 2, 2, 2]);
        assert_eq!((parts.sizes(), parts.largest()), ([1, 5].as_slice(), Some(2)));
        assert!(parts.connected(2, 6) && !parts.connected(0, 2) && !parts.connected(1, 1));
    }

    #[test]
    fn eight_moves_without_corner_cutting_reach_the_same_cells() {
        // The rule as it is stated, by repeated relaxation, against the fill by four moves.
        let mut stream = EpisodeSeed { seed: 2, episode: 0 }.stream(Purpose::Map, 0);
        for _ in 0..300 {
            let mut grid = OccupancyGrid::empty(9, 8, 1.0);
            for index in 1..72 {
                if stream.uniform() < 0.4 {
                    grid.set_occupied(grid.cell(index));
                }
            }
            let mut expected = vec![false; 72];
            expected[0] = true;
            for _ in 0..72 {
                for index in 0..72 {
                    let Cell { col, row } = grid.cell(index);
                    for (dc, dr) in [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)] {
                        let to = Cell { col: col + dc, row: row + dr };
                        let (beside, above) = (Cell { col: col + dc, row }, Cell { col, row: row + dr });
                        let open = grid.is_free(to) && grid.is_free(beside) && grid.is_free(above);
                        if expected[index] && open {
                            expected[grid.index(to)] = true;
                        }
                    }
                }
            }
            assert_eq!(reachable(&grid, &DistanceField::new(&grid), ORIGIN, 0.0), expected, "{grid}");
        }
    }
}
