//! Tools that generators share: lengths in whole cells, rectangles, spanning trees.

use super::{Cell, MapError, OccupancyGrid, SIDE_MAX};
use crate::rng::Stream;
use std::ops::Range;

/// A length in whole cells; `map` and `key` name it in errors.
///
/// # Errors
/// [`MapError::Contradiction`] if it is not a whole number of cells or exceeds [`SIDE_MAX`] cells.
pub(super) fn cells(map: &'static str, key: &str, length_m: f64, resolution_m: f64) -> Result<i64, MapError> {
    let cells = length_m / resolution_m;
    let whole = cells.round();
    // Decimal lengths are no exact multiples in binary: 2.4 / 0.1 is 23.999….
    if (cells - whole).abs() > 1e-6 || (whole == 0.0 && length_m > 0.0) {
        return Err(MapError::Contradiction {
            map,
            found: format!("`{key}` {length_m}"),
            expected: format!("a whole number of cells of {resolution_m} m"),
            advice: "change that length or `resolution_m`",
        });
    }
    if whole > SIDE_MAX as f64 {
        return Err(MapError::Contradiction {
            map,
            found: format!("`{key}` of {whole} cells"),
            expected: format!("at most {SIDE_MAX} cells"),
            advice: "lower that length or raise `resolution_m`",
        });
    }
    Ok(whole as i64)
}

/// An empty grid whose sides were computed from several numbers.
///
/// # Errors
/// [`MapError::Contradiction`] if a side is not from 1 to [`SIDE_MAX`] cells.
pub(super) fn grid(
    map: &'static str,
    (cols, rows): (i64, i64),
    resolution_m: f64,
    advice: &'static str,
) -> Result<OccupancyGrid, MapError> {
    let side = 1..=SIDE_MAX as i64;
    if side.contains(&cols) && side.contains(&rows) {
        return Ok(OccupancyGrid::empty(cols as i32, rows as i32, resolution_m));
    }
    Err(MapError::Contradiction {
        map,
        found: format!("{cols} x {rows} cells"),
        expected: format!("1 to {SIDE_MAX} along each side"),
        advice,
    })
}

/// Marks a rectangle of cells inside the grid as occupied.
pub(super) fn occupy(grid: &mut OccupancyGrid, cols: Range<i64>, rows: Range<i64>) {
    for row in rows {
        for col in cols.clone() {
            grid.set_occupied(Cell { col: col as i32, row: row as i32 });
        }
    }
}

/// Marks a rectangle of cells inside the grid as free.
pub(super) fn clear(grid: &mut OccupancyGrid, cols: Range<i64>, rows: Range<i64>) {
    for row in rows {
        for col in cols.clone() {
            grid.set_free(Cell { col: col as i32, row: row as i32 });
        }
    }
}

/// Whether a room of a lattice of rooms is joined with the next one to the right and the next one above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Joined {
    pub(super) right: bool,
    pub(super) above: bool,
}

/// A random spanning tree over a lattice of `across` × `up` rooms, row-major from the lower left: from
/// each room exactly one way leads to each other. It is made by a depth-first walk from room 0, which takes a new neighbour
/// at random (drawn among right, left, above, below, in this order) and goes back if no neighbour is new. It has long
/// winding ways and few branches. Each room is entered once and left once.
pub(super) fn spanning_tree(across: usize, up: usize, stream: &mut Stream) -> Vec<Joined> {
    let mut joined = vec![Joined::default(); across * up];
    let mut seen = vec![false; across * up];
    let mut walk = vec![0];
    seen[0] = true;
    while let Some(&room) = walk.last() {
        let (col, row) = (room % across, room / across);
        let sides = [
            (col + 1 < across).then_some(room + 1),
            (col > 0).then(|| room - 1),
            (row + 1 < up).then_some(room + across),
            (row > 0).then(|| room - across),
        ];
        let mut fresh = [0; 4];
        let mut count = 0;
        for side in sides.into_iter().flatten().filter(|&side| !seen[side]) {
            fresh[count] = side;
            count += 1;
        }
        if count == 0 {
            walk.pop();
            continue;
        }
        let next = fresh[stream.index(count)];
        let (first, second) = if room < next { (room, next) } else { (next, room) };
        if second - first == 1 && across > 1 {
            joined[first].right = true;
        } else {
            joined[first].above = true;
        }
        seen[next] = true;
        walk.push(next);
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::support::episode;
    use crate::rng::Purpose;

    #[test]
    fn a_spanning_tree_joins_every_room_once() {
        for (across, up) in [(1, 1), (1, 7), (7, 1), (2, 2), (9, 13)] {
            for number in 0..50 {
                let mut stream = episode(number).stream(Purpose::Map, 0);
                let joined = spanning_tree(across, up, &mut stream);
                let doors: usize = joined.iter().map(|room| usize::from(room.right) + usize::from(room.above)).sum();
                assert_eq!(doors, across * up - 1);
                // Connected as well, so a tree: labels merge along the doors, and one is left.
                let mut label: Vec<usize> = (0..across * up).collect();
                for (room, doors) in joined.iter().enumerate() {
                    for (open, other) in [(doors.right, room + 1), (doors.above, room + across)] {
                        if open {
                            assert!(other < label.len() && (other != room + 1 || other % across != 0 || across == 1));
                            let (keep, drop) = (label[room], label[other]);
                            label.iter_mut().filter(|label| **label == drop).for_each(|label| *label = keep);
                        }
                    }
                }
                assert!(label.iter().all(|&found| found == label[0]));
            }
        }
    }
}
