//! The grid of the call before, for searches that are repaired: which cells have changed, and whose steps that concerns.

use crate::plan::PlanningGrid;

/// Number of cells that are compared at once to find those that changed.
const COMPARED: usize = 256;

/// A copy of the planning grid as it was at the last call.
#[derive(Debug, Default)]
pub(in super::super) struct KeptGrid {
    /// Padded; empty if nothing is kept.
    cells: Vec<u8>,
    cols: i32,
    changed: Vec<u32>,
    affected: Vec<u32>,
}

impl KeptGrid {
    /// Whether `grid` has the size of the copy.
    pub fn has_size_of(&self, grid: &PlanningGrid) -> bool {
        self.cols == grid.cols() && self.cells.len() == grid.cells().len()
    }

    /// Takes a new copy.
    pub fn replace(&mut self, grid: &PlanningGrid) {
        self.cols = grid.cols();
        self.cells.clear();
        self.cells.extend_from_slice(grid.cells());
    }

    /// Brings the copy up to date with a grid of its size. Returns the nodes from or to which a step may have changed: the cells
    /// that differ, those of escape zones included, and their neighbours, for diagonal steps pass them; ascending, each once.
    pub fn update(&mut self, grid: &PlanningGrid) -> &[u32] {
        self.changed.clear();
        self.affected.clear();
        let parts = self.cells.chunks_mut(COMPARED).zip(grid.cells().chunks(COMPARED)).enumerate();
        for (part, (old, new)) in parts.filter(|(_, (old, new))| old != new) {
            let differing = (0..new.len()).filter(|&at| old[at] != new[at]);
            self.changed.extend(differing.map(|at| (part * COMPARED + at) as u32));
            old.copy_from_slice(new);
        }
        let stride = grid.stride() as u32;
        for &index in &self.changed {
            for row_start in [index - stride - 1, index - 1, index + stride - 1] {
                self.affected.extend(row_start..row_start + 3);
            }
        }
        self.affected.sort_unstable();
        self.affected.dedup();
        &self.affected
    }
}
