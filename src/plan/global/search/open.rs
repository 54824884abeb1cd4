//! The open list: nodes waiting to be expanded, best first.
//!
//! A bucket queue whose order is exact. Entries are sorted into buckets by f, 1/32 of a cell each;
//! only the bucket in turn is kept in order, and only when its turn comes is a bucket sorted. So
//! most pushes append to a list, and entries that are never reached cost nothing more. Within a
//! search by A* a child with the f of its parent goes to the end of the bucket in turn, from where
//! it is taken next: no comparison with the rest.

use super::Move;

/// Buckets per unit of f.
const BUCKETS_PER_CELL: f64 = 32.0;
/// Buckets ahead of the one in turn, 4 cells of f: more than a step can add to f with a consistent heuristic.
const RING: i64 = 128;

/// A node at a place in the order: smaller f, then larger g, then smaller index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    f: u64,
    minus_g: u64,
    index: u32,
    arrived_by: Option<Move>,
}

/// What comes out of the open list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Popped {
    /// Row-major index of the node.
    pub index: u32,
    /// The g that it was pushed with.
    pub g: f64,
    /// The move that it was pushed with.
    pub arrived_by: Option<Move>,
}

/// The open list. Cheaper entries of a node are pushed beside the old ones, not moved.
#[derive(Debug)]
pub(super) struct Open {
    /// The entries of all buckets up to the one in turn, the best at the end.
    current: Vec<Entry>,
    /// Number of the bucket in turn.
    turn: i64,
    /// The next `RING - 1` buckets, unsorted, at their number modulo `RING`.
    ring: Vec<Vec<Entry>>,
    /// Bit k: bucket k of the ring has entries.
    filled: u128,
    /// Entries of the buckets beyond the ring, each with its bucket's number.
    beyond: Vec<(i64, Entry)>,
    /// Smallest number of a bucket in `beyond`.
    beyond_first: i64,
}

impl Default for Open {
    fn default() -> Self {
        Self {
            current: Vec::new(),
            turn: i64::MIN,
            ring: vec![Vec::new(); RING as usize],
            filled: 0,
            beyond: Vec::new(),
            beyond_first: i64::MAX,
        }
    }
}

impl Open {
    /// Forgets all entries and keeps their memory.
    pub fn clear(&mut self) {
        self.current.clear();
        self.turn = i64::MIN;
        self.ring.iter_mut().for_each(Vec::clear);
        self.filled = 0;
        self.beyond.clear();
        self.beyond_first = i64::MAX;
    }

    /// Adds a node with its f, its g, its row-major index and the move that led to it.
    ///
    /// # Panics
    /// If f is not a number.
    pub fn push(&mut self, f: f64, g: f64, index: u32, arrived_by: Option<Move>) {
        assert!(!f.is_nan(), "the priority of a node is a number");
        let entry = Entry { f: ordered(f), minus_g: !g.to_bits(), index, arrived_by };
        // Rounding towards zero keeps the order, which is all that buckets need.
        let bucket = (f * BUCKETS_PER_CELL) as i64;
        if bucket <= self.turn {
            let worse = self.current.iter().rposition(|other| entry < *other);
            self.current.insert(worse.map_or(0, |at| at + 1), entry);
        } else {
            self.put_off(bucket, entry);
        }
    }

    /// Takes out the best entry.
    pub fn pop(&mut self) -> Option<Popped> {
        if self.current.is_empty() {
            self.turn_to_next_bucket();
        }
        let Entry { minus_g, index, arrived_by, .. } = self.current.pop()?;
        Some(Popped { index, g: f64::from_bits(!minus_g), arrived_by })
    }

    /// Keeps an entry for the turn of its bucket.
    fn put_off(&mut self, bucket: i64, entry: Entry) {
        if bucket.saturating_sub(self.turn) < RING {
            let slot = bucket.rem_euclid(RING);
            self.ring[slot as usize].push(entry);
            self.filled |= 1 << slot;
        } else {
            self.beyond.push((bucket, entry));
            self.beyond_first = self.beyond_first.min(bucket);
        }
    }

    /// Brings the next bucket that has entries into `current`, if there is one.
    fn turn_to_next_bucket(&mut self) {
        if self.filled == 0 && self.beyond.is_empty() {
            return;
        }
        let first_in_ring = if self.filled == 0 {
            i64::MAX
        } else {
            let next_slot = (self.turn + 1).rem_euclid(RING) as u32;
            self.turn + 1 + i64::from(self.filled.rotate_right(next_slot).trailing_zeros())
        };
        self.turn = first_in_ring.min(self.beyond_first);
        if self.beyond_first.saturating_sub(self.turn) < RING {
            self.beyond_first = i64::MAX;
            // What is still beyond the ring is appended again.
            for at in (0..self.beyond.len()).rev() {
                let (bucket, entry) = self.beyond.swap_remove(at);
                self.put_off(bucket, entry);
            }
        }
        let slot = self.turn.rem_euclid(RING);
        core::mem::swap(&mut self.current, &mut self.ring[slot as usize]);
        self.filled &= !(1 << slot);
        self.current.sort_unstable_by(|a, b| b.cmp(a));
    }
}

/// Bits that compare like the number; both zeros give the same. (Numbers ≥ 0 compare like their bits.)
fn ordered(x: f64) -> u64 {
    let bits = (x + 0.0).to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::grid::tests::stream;

    /// Pushes and pops at random beside a list that is searched for its best entry each time.
    fn agrees_with_a_plain_list(seed: u64, mut f: impl FnMut(f64, f64) -> f64) {
        let mut stream = stream(seed);
        let mut open = Open::default();
        for _ in 0..300 {
            let mut list: Vec<(f64, f64, u32)> = Vec::new();
            let mut last_f = 0.0;
            for index in 0..stream.index(300) as u32 {
                if stream.uniform() < 0.6 {
                    // Few different g, so that all three keys decide.
                    let (f, g) = (f(last_f, stream.uniform()), stream.index(3) as f64 * 0.7);
                    let index = index * 7919 % 300;
                    open.push(f, g, index, None);
                    list.push((f, g, index));
                } else {
                    let best = (0..list.len()).min_by(|&a, &b| {
                        let (a, b) = (list[a], list[b]);
                        a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)).then(a.2.cmp(&b.2))
                    });
                    let expected = best.map(|at| list.swap_remove(at));
                    assert_eq!(
                        open.pop().map(|popped| (popped.index, popped.g)),
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
        agrees_with_a_plain_list(11, |last_f, u| last_f + (u * 6.0).floor() * 0.5);
    }

    #[test]
    fn the_order_holds_where_f_falls_jumps_and_is_negative() {
        agrees_with_a_plain_list(12, |last_f, u| last_f + (u - 0.6) * 40.0);
        agrees_with_a_plain_list(13, |_, u| (u * 5.0).floor() * 1e3 - 2e3);
        agrees_with_a_plain_list(14, |_, u| if u < 0.1 { f64::INFINITY } else { (u - 0.5) * 1e300 });
    }

    #[test]
    #[should_panic(expected = "is a number")]
    fn a_priority_that_is_no_number_is_refused() {
        Open::default().push(f64::NAN, 0.0, 1, None);
    }
}
