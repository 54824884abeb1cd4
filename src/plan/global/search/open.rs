//! The open list: nodes waiting to be expanded, best first. There are two, which give the same order: [`Buckets`],
//! for searches whose f hardly ever falls, and a heap with four children a node ([`Heap`]) for all others.
//!
//! [`Buckets`] is a bucket queue whose order is exact. Entries are sorted into buckets by f, 1/128 of a cell each;
//! only the bucket in turn is kept in order, and only when its turn comes is a bucket sorted. So
//! most pushes append to a list, and entries that are never reached cost nothing more. Within a
//! search by A* a child with the f of its parent goes to the end of the bucket in turn, from where
//! it is taken next: no comparison with the rest.
//!
//! The order is f, then larger g, then smaller index. An entry holds these in one of two forms:
//! [`WholeEntry`], one integer, where f and h are whole steps; [`RealEntry`] for all others.

use super::cost::{CellCost, Cost};
use dary_heap::QuaternaryHeap;
use std::cmp::Reverse;

/// Buckets per unit of f.
const BUCKETS_PER_CELL: u64 = 128;
/// Buckets ahead of the one in turn, 4 cells of f: more than a step can add to f with a consistent heuristic.
const RING: usize = 512;

/// f of a node that is about to be pushed, in the form in which the rule computes it.
pub(in super::super) trait Priority<C: Cost> {
    /// Type of the entries in the open list.
    type Entry: OpenEntry;

    /// The entry of a node that is reached at cost `g`, given its row-major index.
    fn entry(self, g: C, index: u32) -> Self::Entry;

    /// Whether an entry may be current: `false` if it was surely pushed with another cost than the node has now.
    fn may_have_cost(entry: Self::Entry, kept: C::Kept) -> bool;

    /// Cost of the node whose best entry this is; `estimate` gives h.
    fn cost(entry: Self::Entry, kept: C::Kept, estimate: impl FnOnce() -> C) -> C;
}

/// A node's key in the order: the smallest is the best.
pub(in super::super) trait OpenEntry: Copy + Ord {
    /// Number of its bucket; it never decreases as f increases.
    fn bucket(self) -> u64;

    /// Row-major index of the node.
    fn index(self) -> u32;
}

/// f as a number of steps, for searches that never find a closed node cheaper.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct WholeSteps {
    /// f: the node with the smallest f is expanded first.
    pub f: CellCost,
    /// h, the part of f that estimates the remaining cost.
    pub h: CellCost,
}

/// From the highest bit: 64 of f, 32 of h, 32 of the index.
///
/// Where f is equal, g is larger where h is smaller. h is in 2⁻¹⁷ of a cell, rounded down, in the same order as
/// before: different octile distances on a map of up to 2¹⁴ cells a side are more than 2⁻¹⁶ cells apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in super::super) struct WholeEntry(u128);

impl Priority<CellCost> for WholeSteps {
    type Entry = WholeEntry;

    fn entry(self, _: CellCost, index: u32) -> WholeEntry {
        let h = self.h.0 / (CellCost::PER_CELL >> 17);
        WholeEntry(u128::from(self.f.0) << 64 | u128::from(h << 32 | u64::from(index)))
    }

    /// Of several entries of a node the cheapest has the smallest f and comes first; then the node is closed.
    fn may_have_cost(_: WholeEntry, _: u32) -> bool {
        true
    }

    fn cost(entry: WholeEntry, _: u32, estimate: impl FnOnce() -> CellCost) -> CellCost {
        CellCost(entry.f().wrapping_sub(estimate().0))
    }
}

impl WholeEntry {
    fn f(self) -> u64 {
        (self.0 >> 64) as u64
    }
}

impl OpenEntry for WholeEntry {
    fn bucket(self) -> u64 {
        self.f() / (CellCost::PER_CELL / BUCKETS_PER_CELL)
    }

    fn index(self) -> u32 {
        self.0 as u32
    }
}

/// f and g as numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in super::super) struct RealEntry {
    /// Bits that compare like f.
    f: u64,
    minus_g: u64,
    index: u32,
}

impl<C: Cost<Kept = C>> Priority<C> for f64 {
    type Entry = RealEntry;

    /// # Panics
    /// If f is not a number.
    fn entry(self, g: C, index: u32) -> RealEntry {
        assert!(!self.is_nan(), "the priority of a node is a number");
        RealEntry { f: ordered(self), minus_g: !g.value().to_bits(), index }
    }

    fn may_have_cost(entry: RealEntry, kept: C) -> bool {
        entry.minus_g == !kept.value().to_bits()
    }

    fn cost(_: RealEntry, kept: C, _: impl FnOnce() -> C) -> C {
        kept
    }
}

impl OpenEntry for RealEntry {
    fn bucket(self) -> u64 {
        // Rounding towards zero keeps the order, which is all that buckets need.
        let bucket = (number(self.f) * BUCKETS_PER_CELL as f64) as i64;
        bucket as u64 ^ 1 << 63 // from the smallest to the largest, negative ones first
    }

    fn index(self) -> u32 {
        self.index
    }
}

/// Bits that compare like the number; both zeros give the same. (Numbers ≥ 0 compare like their bits.)
fn ordered(x: f64) -> u64 {
    let bits = (x + 0.0).to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

/// The number that such bits stand for.
fn number(ordered: u64) -> f64 {
    f64::from_bits(if ordered >> 63 == 0 { !ordered } else { ordered & !(1 << 63) })
}

/// The open list. Cheaper entries of a node are pushed beside the old ones, not moved.
pub(in super::super) trait OpenList: Default {
    /// Type of the entries.
    type Entry: OpenEntry;

    /// Forgets all entries and keeps their memory.
    fn clear(&mut self);

    /// Adds an entry.
    fn push(&mut self, entry: Self::Entry);

    /// Takes out the best entry.
    fn pop(&mut self) -> Option<Self::Entry>;
}

/// The open list of searches whose f may fall by any amount.
pub(in super::super) type Heap<E> = QuaternaryHeap<Reverse<E>>;

impl<E: OpenEntry> OpenList for Heap<E> {
    type Entry = E;

    fn clear(&mut self) {
        self.clear();
    }

    fn push(&mut self, entry: E) {
        self.push(Reverse(entry));
    }

    fn pop(&mut self) -> Option<E> {
        self.pop().map(|Reverse(entry)| entry)
    }
}

/// The open list of searches whose f hardly ever falls, and never rises by much.
#[derive(Debug)]
pub(in super::super) struct Buckets<E> {
    /// The entries of all buckets up to the one in turn, the best at the end.
    current: Vec<E>,
    /// Room to sort in.
    sorted: Vec<E>,
    /// Number of the bucket in turn.
    turn: u64,
    /// The next `RING - 1` buckets, unsorted, at their number modulo `RING`.
    ring: Box<[Vec<E>; RING]>,
    /// Bit k of word w: bucket 64 w + k of the ring has entries.
    filled: [u64; RING / 64],
    /// Entries of the buckets beyond the ring, each with its bucket's number.
    beyond: Vec<(u64, E)>,
    /// Smallest number of a bucket in `beyond`.
    beyond_first: u64,
}

impl<E> Default for Buckets<E> {
    fn default() -> Self {
        Self {
            current: Vec::new(),
            sorted: Vec::new(),
            turn: 0,
            ring: Box::new([const { Vec::new() }; RING]),
            filled: [0; RING / 64],
            beyond: Vec::new(),
            beyond_first: u64::MAX,
        }
    }
}

impl<E: OpenEntry> OpenList for Buckets<E> {
    type Entry = E;

    fn clear(&mut self) {
        self.current.clear();
        self.turn = 0;
        while let Some(slot) = self.next_filled(0) {
            self.ring[slot].clear();
            self.filled[slot / 64] &= !(1 << (slot % 64));
        }
        self.beyond.clear();
        self.beyond_first = u64::MAX;
    }

    fn push(&mut self, entry: E) {
        let bucket = entry.bucket();
        if bucket > self.turn {
            self.put_off(bucket, entry);
        } else {
            let worse = self.current.iter().rposition(|other| entry < *other);
            self.current.insert(worse.map_or(0, |at| at + 1), entry);
        }
    }

    #[inline]
    fn pop(&mut self) -> Option<E> {
        if self.current.is_empty() {
            self.turn_to_next_bucket();
        }
        self.current.pop()
    }
}

impl<E: OpenEntry> Buckets<E> {
    /// Keeps an entry for the turn of its bucket.
    fn put_off(&mut self, bucket: u64, entry: E) {
        if bucket - self.turn < RING as u64 {
            let slot = bucket as usize % RING;
            self.ring[slot].push(entry);
            self.filled[slot / 64] |= 1 << (slot % 64);
        } else {
            self.beyond.push((bucket, entry));
            self.beyond_first = self.beyond_first.min(bucket);
        }
    }

    /// The first slot of the ring from `slot` on that has entries, the ring being read as a circle.
    fn next_filled(&self, slot: usize) -> Option<usize> {
        let (word, bits_before) = (slot / 64, !(u64::MAX << (slot % 64)));
        // The word that the slot is in comes first, and last once more for what lies before the slot in it.
        let words = (word..self.filled.len()).chain(0..=word);
        words.enumerate().find_map(|(at, word)| {
            let bits = if at == 0 { self.filled[word] & !bits_before } else { self.filled[word] };
            (bits != 0).then(|| 64 * word + bits.trailing_zeros() as usize)
        })
    }

    /// Brings the next bucket that has entries into `current`, if there is one.
    #[inline(never)]
    fn turn_to_next_bucket(&mut self) {
        let slot_in_turn = self.turn as usize % RING;
        let first_in_ring = self
            .next_filled((slot_in_turn + 1) % RING)
            .map_or(u64::MAX, |slot| self.turn + ((slot + RING - slot_in_turn) % RING) as u64);
        self.turn = first_in_ring.min(self.beyond_first);
        if self.beyond_first - self.turn < RING as u64 {
            self.beyond_first = u64::MAX;
            // What is still beyond the ring is appended again.
            for at in (0..self.beyond.len()).rev() {
                let (bucket, entry) = self.beyond.swap_remove(at);
                self.put_off(bucket, entry);
            }
        }
        let slot = self.turn as usize % RING;
        core::mem::swap(&mut self.current, &mut self.ring[slot]);
        self.filled[slot / 64] &= !(1 << (slot % 64));
        sort_best_last(&mut self.current, &mut self.sorted);
    }
}

/// Sorts entries, no two of which are equal. Short lists by counting for each entry those that it is better than:
/// that takes more comparisons than other ways, but no branch depends on them.
fn sort_best_last<E: OpenEntry>(entries: &mut Vec<E>, sorted: &mut Vec<E>) {
    const SHORT: usize = 16;
    if entries.len() > SHORT {
        entries.sort_unstable_by(|a, b| b.cmp(a));
        return;
    }
    sorted.clear();
    sorted.extend_from_slice(entries);
    for entry in entries.iter() {
        let place = entries.iter().map(|other| usize::from(other > entry)).sum::<usize>();
        sorted[place] = *entry;
    }
    core::mem::swap(entries, sorted);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::grid::tests::stream;

    /// Pushes and pops at random beside a list that is searched for its best entry each time.
    fn agrees_with_a_plain_list<O: OpenList<Entry = RealEntry>>(seed: u64, mut f: impl FnMut(f64, f64) -> f64) {
        let mut stream = stream(seed);
        let mut open = O::default();
        for _ in 0..300 {
            let mut list: Vec<(f64, f64, u32)> = Vec::new();
            let mut last_f = 0.0;
            for index in 0..stream.index(300) as u32 {
                if stream.uniform() < 0.6 {
                    // Few different g, so that all three keys decide.
                    let (f, g) = (f(last_f, stream.uniform()), stream.index(3) as f64 * 0.7);
                    let index = index * 7919 % 300;
                    open.push(Priority::<f64>::entry(f, g, index));
                    list.push((f, g, index));
                } else {
                    let best = (0..list.len()).min_by(|&a, &b| {
                        let (a, b) = (list[a], list[b]);
                        a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)).then(a.2.cmp(&b.2))
                    });
                    let expected = best.map(|at| list.swap_remove(at));
                    assert_eq!(
                        open.pop().map(|popped| (popped.index, f64::from_bits(!popped.minus_g))),
                        expected.map(|(_, g, index)| (index, g))
                    );
                    last_f = expected.map_or(last_f, |(f, _, _)| f);
                }
            }
            open.clear();
            assert_eq!(open.pop(), None);
        }
    }

    #[test]
    fn entries_come_out_by_f_then_larger_g_then_smaller_index() {
        // As with a consistent heuristic, ties included: f never falls, by at most 3 cells per step.
        agrees_with_a_plain_list::<Buckets<_>>(11, |last_f, u| last_f + (u * 6.0).floor() * 0.5);
        agrees_with_a_plain_list::<Heap<_>>(11, |last_f, u| last_f + (u * 6.0).floor() * 0.5);
    }

    #[test]
    fn the_order_holds_where_f_falls_jumps_and_is_negative() {
        fn both<O: OpenList<Entry = RealEntry>>() {
            agrees_with_a_plain_list::<O>(12, |last_f, u| last_f + (u - 0.6) * 40.0);
            agrees_with_a_plain_list::<O>(13, |_, u| (u * 5.0).floor() * 1e3 - 2e3);
            agrees_with_a_plain_list::<O>(14, |_, u| if u < 0.1 { f64::INFINITY } else { (u - 0.5) * 1e300 });
        }
        both::<Buckets<_>>();
        both::<Heap<_>>();
    }

    #[test]
    #[should_panic(expected = "is a number")]
    fn a_priority_that_is_no_number_is_refused() {
        let _ = Priority::<f64>::entry(f64::NAN, 0.0, 1);
    }
}
