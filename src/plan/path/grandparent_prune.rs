//! `grandparent_prune`: from the goal back, each node takes its grandparent for its parent as long as it sees it.
//!
//! Source: Zhao, Xie, Xu, Zhu, Xu, dynamic path planning for inspection robots based on improved A* and DWA, 2025, section 2.4 (`zhao2025`):
//!
//! ```text
//! i = the goal
//! until i is the start
//!     k = the node before i
//!     while k is not the start and i sees the node before k:  k = that node
//!     join i to k, and go on from i = k
//! ```
//!
//! It works on every node of the path, bends or not, and stops at the first node that is not in sight: a node farther on that is in sight
//! again is not found, which [`line_of_sight`](super::line_of_sight), from the start on, looks for. So a second pass may shorten the path once
//! more. The new path is never longer than the given one, by the triangle inequality.
//!
//! The paper sees along the grid, "if the connection between nodes occupies grid cells with no obstacles", and keeps no clearance;
//! `clearance_m` and `clearance_cells` ask for some. A shortcut keeps the inflation from obstacles as every planned line does
//! ([`PlanningGrid::is_clear`]), or as much as the path that it replaces where that has less.
//!
//! Departures: pieces between neighbouring nodes are kept as they are, even where they break the clearance, so that a path remains a path.
//!
//! Parameters: [`Params`].

use super::{PathKind, Room};
use crate::geometry::{Path, Piece, Vec2};
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, Failure, PathStage, Task};
use crate::settings::quantity::NonNegative;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `grandparent_prune`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Distance that a shortcut must keep from blocked squares of the planning grid, m; larger keeps more of the path. Default 0, as the
    /// paper has it: it keeps the inflation (`planning.inflation_m`) from obstacles, and without inflation it must not touch
    /// a blocked square.
    pub clearance_m: NonNegative,
    /// The same in cells of the map; the larger of the two counts. Default 0.
    pub clearance_cells: NonNegative,
}

impl Default for Params {
    fn default() -> Self {
        Self { clearance_m: NonNegative::new(0.0), clearance_cells: NonNegative::new(0.0) }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "From the goal back, joins each node to the farthest one before which none is out of sight: fewer bends, never longer.",
    source: "Zhao, Xie, Xu, Zhu, Xu, Dynamic path planning for inspection robots based on improved A* and DWA, 2025, section 2.4",
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
    params: Params,
    nodes: Vec<Vec2>,
    room_m: Vec<f64>,
}

impl Stage {
    /// A fresh stage.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone(), nodes: Vec::new(), room_m: Vec::new() }
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
        let nodes = &self.nodes;
        let room = Room::of(grid, path, &mut self.room_m);
        let clearance_m =
            math::max(self.params.clearance_m.get(), self.params.clearance_cells.get() * grid.resolution_m());
        let sees = |i: usize, k: usize| room.may_replace(k..i, nodes[k], nodes[i], clearance_m);
        let mut pieces = Vec::new();
        let mut at = nodes.len() - 1;
        while at > 0 {
            let mut parent = at - 1;
            while parent > 0 && sees(at, parent - 1) {
                parent -= 1;
            }
            let is_kept = parent == at - 1;
            pieces.push(if is_kept { path.pieces()[parent].clone() } else { Piece::Line { to: nodes[at] } });
            at = parent;
        }
        pieces.reverse();
        Path::new(path.start(), pieces)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Cell, OccupancyGrid};
    use crate::math::FRAC_PI_2;
    use crate::plan::contract::Problem;
    use crate::plan::global::GlobalChoice;
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};

    fn stage(clearance_cells: f64) -> Stage {
        Stage::new(&Params { clearance_cells: NonNegative::new(clearance_cells), ..Params::default() })
    }

    fn centres(grid: &PlanningGrid, cells: &[(i32, i32)]) -> Vec<Vec2> {
        cells.iter().map(|&(col, row)| grid.centre(Cell { col, row })).collect()
    }

    fn kept(stage: &mut Stage, grid: &PlanningGrid, cells: &[(i32, i32)]) -> Vec<Vec2> {
        stage.treat(grid, &Path::polyline(&centres(grid, cells))).vertices().collect()
    }

    #[test]
    fn each_node_takes_its_grandparent_until_one_is_out_of_sight() {
        let (_, grid) = drawn(&[
            "......", //
            "......", //
            ".##...", //
            "......", //
        ]);
        // Along the left edge, over the block and down to the right. Node by node from the goal (5, 0), centre (5.5, 0.5): (4, 1) and
        // (3, 2), on one diagonal. (2, 3): the line to it passes x = 3 at y = 0.5 + 2.5 · 3/3 = 3, beyond the block's top. (1, 3): it passes
        // x = 3 at y = 0.5 + 2.5 · 3/4 = 2.375, over the top at y = 2, and x = 2 at 3.125. (0, 2): y at x = 3 is
        // 0.5 + 2.5 · 2/5 = 1.5, inside. So (1, 3) is the goal's parent, and (0, 1) its own: the line to the start touches the
        // block's corner (1, 2).
        let cells = [(0, 0), (0, 1), (0, 2), (1, 3), (2, 3), (3, 2), (4, 1), (5, 0)];
        assert_eq!(kept(&mut stage(0.0), &grid, &cells), centres(&grid, &[(0, 0), (0, 1), (1, 3), (5, 0)]));
    }

    #[test]
    fn a_node_in_sight_again_beyond_one_out_of_sight_is_not_found() {
        let (_, grid) = drawn(&[
            ".......", //
            "..###..", //
            ".......", //
        ]);
        // Round the block although start and goal see each other along the bottom.
        let cells = [(0, 0), (0, 1), (1, 2), (2, 2), (3, 2), (4, 2), (5, 2), (6, 1), (6, 0)];
        // From (6, 0) over (6, 1) and (5, 2) to (4, 2): the line to it passes the corner (5, 1) at x = 5, y = 0.5 + 2 · 1.5/2 = 2, the block's
        // top corner: touched. So (5, 2), and from there along the top to (1, 2), as (0, 1) is out of sight; then the start.
        let once = centres(&grid, &[(0, 0), (1, 2), (5, 2), (6, 0)]);
        assert_eq!(kept(&mut stage(0.0), &grid, &cells), once);
        // The second pass ends in the same path: the goal does not see (1, 2).
        assert_eq!(stage(0.0).treat(&grid, &Path::polyline(&once)), Path::polyline(&once));
        // line_of_sight finds the way along the bottom.
        let mut other = crate::plan::path::line_of_sight::Params::default().build();
        let robot = crate::robot::Robot::default();
        let belief = crate::observation::Belief::from(&OccupancyGrid::empty(7, 3, 1.0));
        let path = Path::polyline(&centres(&grid, &cells));
        let pose = crate::geometry::Pose::new(0.5, 0.5, 0.0);
        let situation = crate::plan::contract::Situation::new(&robot, &belief, pose, path.end());
        let task = Task { situation: &situation, grid: &grid, start: path.start(), goal: path.end() };
        assert_eq!(other.apply(&task, &path), Ok(Path::polyline(&centres(&grid, &[(0, 0), (6, 0)]))));
    }

    #[test]
    fn a_second_pass_may_find_more_where_a_node_between_hid_it() {
        let (_, grid) = drawn(&[
            ".......", //
            "....#..", //
            ".......", //
        ]);
        // The goal does not see (2, 2) past the block and so does not ask for (0, 0), which (3, 0) sees.
        let once = kept(&mut stage(0.0), &grid, &[(0, 0), (2, 2), (3, 0), (6, 0)]);
        assert_eq!(once, centres(&grid, &[(0, 0), (3, 0), (6, 0)]));
        let twice = stage(0.0).treat(&grid, &Path::polyline(&once));
        assert_eq!(twice, Path::polyline(&centres(&grid, &[(0, 0), (6, 0)])));
        assert_eq!(stage(0.0).treat(&grid, &twice), twice);
    }

    #[test]
    fn shortcuts_keep_the_clearance_in_cells_of_the_map() {
        for resolution_m in [1.0, 0.05] {
            let map = OccupancyGrid::from_ascii(&["......", "..#...", "......"], resolution_m);
            let grid = uninflated(&map);
            let along = [(0, 2), (1, 2), (2, 2), (3, 2), (4, 2)];
            assert_eq!(kept(&mut stage(0.5), &grid, &along), centres(&grid, &[(0, 2), (4, 2)]));
            assert_eq!(kept(&mut stage(0.51), &grid, &along), centres(&grid, &along));
            // From (5, 1) the line to (1, 2) passes the block's corner (3, 2) at y = 2.125: 0.12 of a cell away; that to (2, 2) at
            // y = 2.33: 0.32. From (3, 2) on it goes away from it.
            let down = [(1, 2), (2, 2), (3, 2), (4, 2), (5, 1)];
            assert_eq!(kept(&mut stage(0.0), &grid, &down), centres(&grid, &[(1, 2), (5, 1)]));
            assert_eq!(kept(&mut stage(0.2), &grid, &down), centres(&grid, &[(1, 2), (2, 2), (5, 1)]));
            assert_eq!(kept(&mut stage(0.5), &grid, &down), centres(&grid, &[(1, 2), (3, 2), (5, 1)]));
        }
    }

    #[test]
    fn arcs_stay_unless_a_shortcut_passes_over_them() {
        let arc = Piece::Arc { to: Vec2::new(2.5, 1.5), centre: Vec2::new(1.5, 1.5), sweep: FRAC_PI_2 };
        let path = Path::new(
            Vec2::new(0.5, 0.5),
            vec![Piece::Line { to: Vec2::new(1.5, 0.5) }, arc, Piece::Line { to: Vec2::new(2.5, 2.5) }],
        );
        let (_, wall) = drawn(&["#..", "##.", "..."]);
        assert_eq!(stage(0.0).treat(&wall, &path), path);
        let (_, open) = drawn(&["...", "...", "..."]);
        assert_eq!(stage(0.0).treat(&open, &path), Path::polyline(&[Vec2::new(0.5, 0.5), Vec2::new(2.5, 2.5)]));
    }

    #[test]
    fn single_points_and_single_pieces_stay_as_they_are() {
        let (_, grid) = drawn(&["..", ".."]);
        for path in [Path::polyline(&[Vec2::new(0.5, 0.5)]), Path::polyline(&centres(&grid, &[(0, 0), (1, 1)]))] {
            assert_eq!(stage(0.0).treat(&grid, &path), path);
        }
    }

    #[test]
    fn pruned_paths_are_free_and_no_longer_and_once_they_are_straight_they_stay() {
        let mut stream = stream(94);
        let mut planner = GlobalChoice::by_name("a_star").expect("defaults").build();
        let (mut cells, mut shorter, mut stays) = (Vec::new(), 0, 0);
        for _ in 0..1500 {
            let share = stream.range(0.0, 0.35);
            let map = random_map(&mut stream, 30, share);
            let grid = uninflated(&map);
            let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
            let problem = Problem { grid: &grid, start, goal };
            if planner.as_grid().expect("cells").search(&problem, &mut cells).result.is_err() {
                continue;
            }
            let nodes: Vec<Vec2> = cells.iter().map(|&cell| grid.centre(cell)).collect();
            let path = Path::polyline(&nodes);
            let pruned = stage(0.0).treat(&grid, &path);
            assert_eq!((pruned.start(), pruned.end()), (path.start(), path.end()));
            assert!(pruned.length() <= path.length() + 1e-9);
            let mut kept = nodes.iter();
            assert!(pruned.vertices().all(|vertex| kept.any(|&v| v == vertex)), "in the order of the path");
            assert!(pruned.segments().all(|(from, piece)| grid.line_of_sight(from, piece.end())));
            shorter += u32::from(pruned.length() < path.length() - 1e-9);
            // No node sees the one before its parent in the new path: then it is what it makes of itself.
            let new: Vec<Vec2> = pruned.vertices().collect();
            if new.windows(3).all(|three| !grid.line_of_sight(three[0], three[2])) {
                assert_eq!(stage(0.0).treat(&grid, &pruned), pruned);
                stays += 1;
            }
        }
        assert!(shorter > 300 && stays > 800, "{shorter} {stays}");
    }
}
