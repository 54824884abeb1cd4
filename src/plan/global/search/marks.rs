//! A set of nodes that is emptied at once.

use crate::plan::PlanningGrid;

/// The set of nodes that a search has met, for searches that need no other record of them.
#[derive(Debug, Default)]
pub(in super::super) struct Marks {
    /// Number of the search in which each node was marked last; 0 for none.
    marked_in: Vec<u32>,
    search: u32,
}

impl Marks {
    /// Removes all marks, and makes room for the nodes of `grid`.
    pub fn begin(&mut self, grid: &PlanningGrid) {
        if self.search == u32::MAX {
            self.marked_in.clear();
            self.search = 0;
        }
        self.search += 1;
        if self.marked_in.len() < grid.cells().len() {
            self.marked_in.resize(grid.cells().len(), 0);
        }
    }

    /// Marks a node; returns whether it was unmarked before.
    pub fn mark(&mut self, index: u32) -> bool {
        core::mem::replace(&mut self.marked_in[index as usize], self.search) != self.search
    }

    /// Whether a node is marked.
    pub fn contains(&self, index: u32) -> bool {
        self.marked_in[index as usize] == self.search
    }
}
