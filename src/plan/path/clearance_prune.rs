//! `clearance_prune`: removes nodes where a straight line is shorter and keeps its distance from obstacles.
//!
//! Source: redundant node elimination of Gao, Zhang, Liu, Ou, Cheng, Zhu, the ImpA*-ImpDWA paper, AIMS Press,
//! 2025 (`gao2025`, `systems.md` §2(a)). For nodes N_i, N_j with j > i + 1 all nodes between are dropped if
//!
//! ```text
//! |N_i N_j| < sum of the distances between them         and         clearance of the segment N_i N_j ≥ r
//! ```
//!
//! Every node tries the longest jump first, and the whole is repeated until nothing changes. So a second
//! application changes nothing, and the path never gets longer.
//!
//! Departures and choices:
//! - The order of the scan and r are not in the paper: longest jump first from the start on, 0.3 m.
//! - Nodes on the straight line between their neighbours make nothing shorter and would stay by the rule as
//!   printed; they are dropped as well, whatever their clearance, for the path does not change by it.
//! - Clearance is that from the blocked squares of the planning grid and the border, to 1e-9 m; with r = 0
//!   it must not touch one. Pieces of the path that break it already stay as they are.
//! - The nodes are those that the stage is given: every cell of a path of cells, as in the paper, so that jumps may begin and
//!   end between bends.
//! - Arcs of a stage before are pieces like any other.
//! - A jump keeps the inflation from obstacles as well, as every planned line does ([`PlanningGrid::is_clear`]), or as much as
//!   the path that it replaces where that has less.
//!
//! [`line_of_sight`](super::line_of_sight) does one pass of greedy jumps instead, without asking whether a jump is shorter.

use super::{PathKind, Room};
use crate::geometry::{Path, Piece, Vec2, point_segment_distance};
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, Failure, PathStage, Task};
use crate::settings::quantity::NonNegative;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Least gain of a jump, and largest distance of a node that counts as on a straight line, m: a bound of the accumulated
/// rounding error on a path of kilometres.
const LENGTH_SLACK_M: f64 = 1e-9;

/// Parameters of `clearance_prune`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// r: distance that a jump must keep from blocked squares of the planning grid, m; larger keeps more of the
    /// path. Default 0.3.
    pub clearance_m: NonNegative,
}

impl Default for Params {
    fn default() -> Self {
        Self { clearance_m: NonNegative::new(0.3) }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Drops nodes where a straight line is shorter and keeps a clearance, until nothing changes: never longer.",
    source: "redundant node elimination of Gao, Zhang, Liu, Ou, Cheng, Zhu, ImpA*-ImpDWA, AIMS Press, 2025",
    ..Entry::PLAIN
};

impl PathKind for Params {
    fn build(&self) -> Box<dyn PathStage> {
        Box::new(Stage::new(self))
    }
}

/// The stage.
#[derive(Debug)]
pub struct Stage {
    clearance_m: f64,
    nodes: Vec<Vec2>,
    room_m: Vec<f64>,
}

impl Stage {
    /// A fresh stage.
    pub fn new(params: &Params) -> Self {
        Self { clearance_m: params.clearance_m.get(), nodes: Vec::new(), room_m: Vec::new() }
    }

    /// Makes one pass of jumps; returns whether it made any.
    fn jump(&mut self, grid: &PlanningGrid, pieces: &mut Vec<Piece>) -> bool {
        let mut any = false;
        let mut from = 0;
        while from + 2 < self.nodes.len() {
            let a = self.nodes[from];
            // Length of the path from here to each node, taken off piece by piece from the far end.
            let mut along_m: f64 = (from..pieces.len()).map(|k| pieces[k].length(self.nodes[k])).sum();
            for to in (from + 2..self.nodes.len()).rev() {
                let b = self.nodes[to];
                let is_shorter = (b - a).norm() < along_m - LENGTH_SLACK_M;
                let room = Room { grid, room_m: &self.room_m };
                if is_shorter && room.may_replace(from..to, a, b, self.clearance_m) {
                    self.nodes.drain(from + 1..to);
                    pieces.splice(from..to, [Piece::Line { to: b }]);
                    let room_m = room.least(from..to);
                    if !self.room_m.is_empty() {
                        self.room_m.splice(from..to, [math::max(room_m, grid.clearance(a, b))]);
                    }
                    any = true;
                    break;
                }
                along_m -= pieces[to - 1].length(self.nodes[to - 1]);
            }
            from += 1;
        }
        any
    }

    /// Joins lines that go straight on; returns whether there were any.
    fn join(&mut self, pieces: &mut Vec<Piece>) -> bool {
        let before = pieces.len();
        let mut at = 1;
        while at < pieces.len() {
            let are_lines = matches!(&pieces[at - 1..=at], [Piece::Line { .. }, Piece::Line { .. }]);
            if are_lines
                && point_segment_distance(self.nodes[at], self.nodes[at - 1], self.nodes[at + 1]) <= LENGTH_SLACK_M
            {
                self.nodes.remove(at);
                pieces.remove(at - 1);
                if !self.room_m.is_empty() {
                    let before = self.room_m.remove(at - 1);
                    self.room_m[at - 1] = math::min(before, self.room_m[at - 1]);
                }
            } else {
                at += 1;
            }
        }
        pieces.len() < before
    }
}

impl PathStage for Stage {
    fn apply(&mut self, task: &Task<'_>, path: &Path) -> Result<Path, Failure> {
        Ok(self.treat(task.grid, path))
    }
}

impl Stage {
    /// The path as this stage makes it on `grid`.
    fn treat(&mut self, grid: &PlanningGrid, path: &Path) -> Path {
        self.nodes.clear();
        self.nodes.extend(path.vertices());
        Room::of(grid, path, &mut self.room_m);
        let mut pieces = path.pieces().to_vec();
        // Each round but the last leaves fewer pieces.
        loop {
            let jumped = self.jump(grid, &mut pieces);
            let joined = self.join(&mut pieces);
            if !(jumped || joined) {
                break;
            }
        }
        Path::new(path.start(), pieces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{FRAC_PI_2, SQRT_2};
    use crate::plan::contract::Problem;
    use crate::plan::global::GlobalChoice;
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};

    fn stage(clearance_m: f64) -> Stage {
        Stage::new(&Params { clearance_m: NonNegative::new(clearance_m) })
    }

    fn points(numbers: &[(f64, f64)]) -> Vec<Vec2> {
        numbers.iter().map(|&(x, y)| Vec2::new(x, y)).collect()
    }

    #[test]
    fn a_jump_past_a_corner_is_made_up_to_the_clearance_it_has() {
        let (_, grid) = drawn(&["....", "....", "..#.", "...."]);
        // From (0.5, 1.5) to (2.5, 3.5): y = x + 1 passes the corner (2, 2) at 1/√2 = 0.7071; the ends keep 0.5
        // from the border, so do all points of the path.
        let path = Path::polyline(&points(&[(0.5, 1.5), (0.5, 3.5), (2.5, 3.5)]));
        assert_eq!(stage(0.5).treat(&grid, &path), Path::polyline(&points(&[(0.5, 1.5), (2.5, 3.5)])));
        assert_eq!(stage(0.51).treat(&grid, &path), path);
        // Away from the border, 0.7071 decides.
        let wide: Vec<String> =
            (0..12).map(|row| if row == 6 { ".....#......" } else { "............" }.to_owned()).collect();
        let (_, grid) = drawn(&wide.iter().map(String::as_str).collect::<Vec<_>>());
        // The block is x 5 to 6, y 5 to 6; y = x + 2 passes its corner (5, 6) at 1/√2.
        let path = Path::polyline(&points(&[(3.0, 5.0), (3.0, 8.0), (6.0, 8.0)]));
        assert_eq!(stage(SQRT_2 / 2.0).treat(&grid, &path).pieces().len(), 1, "the slack lets the exact value pass");
        assert_eq!(stage(SQRT_2 / 2.0 + 1e-6).treat(&grid, &path), path);
    }

    #[test]
    fn the_longest_jump_is_taken_and_a_blocked_one_passed_over() {
        let (_, grid) = drawn(&[
            "......", //
            ".##...", //
            "......", //
        ]);
        let path = Path::polyline(&points(&[(0.5, 1.5), (0.5, 2.5), (1.5, 2.5), (3.5, 2.5), (4.5, 1.5)]));
        // To (4.5, 1.5) and to (3.5, 2.5) the block is in the way, (1.5, 2.5) touches its corner (1, 2). From
        // (0.5, 2.5) the end is hidden (x = 3 at y = 1.875), (3.5, 2.5) is no shorter but straight on.
        let kept: Vec<Vec2> = stage(0.0).treat(&grid, &path).vertices().collect();
        assert_eq!(kept, points(&[(0.5, 1.5), (0.5, 2.5), (3.5, 2.5), (4.5, 1.5)]));
    }

    #[test]
    fn nodes_on_a_straight_line_go_and_turning_points_back_along_it_do_not() {
        let (_, grid) = drawn(&["....#", "....#"]);
        // With a clearance that nothing here keeps.
        let straight = Path::polyline(&points(&[(0.5, 0.5), (1.5, 0.5), (2.0, 0.5), (3.5, 0.5)]));
        assert_eq!(stage(2.0).treat(&grid, &straight), Path::polyline(&points(&[(0.5, 0.5), (3.5, 0.5)])));
        let back = Path::polyline(&points(&[(0.5, 0.5), (3.5, 0.5), (1.5, 0.5)]));
        assert_eq!(stage(2.0).treat(&grid, &back), back);
        assert_eq!(stage(0.1).treat(&grid, &back), Path::polyline(&points(&[(0.5, 0.5), (1.5, 0.5)])));
    }

    #[test]
    fn arcs_stay_unless_a_jump_passes_over_them_and_points_stay_points() {
        let arc = Piece::Arc { to: Vec2::new(2.5, 1.5), centre: Vec2::new(1.5, 1.5), sweep: FRAC_PI_2 };
        let path = Path::new(
            Vec2::new(0.5, 0.5),
            vec![Piece::Line { to: Vec2::new(1.5, 0.5) }, arc, Piece::Line { to: Vec2::new(2.5, 2.5) }],
        );
        let (_, wall) = drawn(&["#..", "##.", "..."]);
        assert_eq!(stage(0.0).treat(&wall, &path), path);
        let (_, open) = drawn(&["...", "...", "..."]);
        assert_eq!(stage(0.0).treat(&open, &path), Path::polyline(&points(&[(0.5, 0.5), (2.5, 2.5)])));
        let point = Path::polyline(&points(&[(0.5, 0.5)]));
        assert_eq!(stage(0.0).treat(&open, &point), point);
    }

    #[test]
    fn pruned_paths_are_clear_no_longer_and_pruned_once_and_for_all() {
        let mut stream = stream(71);
        let mut planner = GlobalChoice::by_name("a_star").expect("defaults").build();
        let (mut cells, mut shorter) = (Vec::new(), 0);
        for _ in 0..1500 {
            let share = stream.range(0.0, 0.35);
            let map = random_map(&mut stream, 30, share);
            let grid = uninflated(&map);
            let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
            let clearance_m = stream.index(4) as f64 * 0.15 * map.resolution_m();
            if planner
                .as_grid()
                .expect("cells")
                .search(&Problem { grid: &grid, start, goal }, &mut cells)
                .result
                .is_err()
            {
                continue;
            }
            let path = Path::polyline(&cells.iter().map(|&cell| grid.centre(cell)).collect::<Vec<_>>());
            let pruned = stage(clearance_m).treat(&grid, &path);
            assert_eq!((pruned.start(), pruned.end()), (path.start(), path.end()));
            assert!(pruned.length() <= path.length() + 1e-9);
            let mut nodes = path.vertices();
            assert!(pruned.vertices().all(|node| nodes.any(|v| v == node)), "in the order of the path");
            // A cell path keeps half a cell, so every piece has the clearance, jumped or not.
            let clear =
                |(from, piece): (Vec2, &Piece)| grid.line_of_sight_with_clearance(from, piece.end(), clearance_m);
            assert!(pruned.segments().all(clear));
            assert_eq!(stage(clearance_m).treat(&grid, &pruned), pruned);
            shorter += u32::from(pruned.length() < path.length() - 1e-9);
        }
        assert!(shorter > 300, "{shorter}");
    }
}
