//! The open list: nodes waiting to be expanded, best first.

use core::cmp::Reverse;
use std::collections::BinaryHeap;

/// A node at a place in the order: smaller f, then larger g, then smaller index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    f: u64,
    minus_g: u64,
    index: u32,
}

/// The open list. Cheaper entries of a node are pushed beside the old ones, not moved.
#[derive(Debug, Default)]
pub(super) struct Open {
    heap: BinaryHeap<Reverse<Entry>>,
}

impl Open {
    /// Forgets all entries and keeps their memory.
    pub fn clear(&mut self) {
        self.heap.clear();
    }

    /// Adds a node with its f, its g and its row-major index.
    pub fn push(&mut self, f: f64, g: f64, index: u32) {
        assert!(!f.is_nan(), "the priority of a node is a number");
        self.heap.push(Reverse(Entry { f: ordered(f), minus_g: !g.to_bits(), index }));
    }

    /// Takes out the best entry: its index and the g it was pushed with.
    pub fn pop(&mut self) -> Option<(u32, f64)> {
        self.heap.pop().map(|Reverse(entry)| (entry.index, f64::from_bits(!entry.minus_g)))
    }
}

/// Bits that compare like the number; both zeros give the same. (Numbers ≥ 0 compare like their bits.)
fn ordered(x: f64) -> u64 {
    let bits = (x + 0.0).to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}
