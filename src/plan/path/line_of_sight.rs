//! `line_of_sight`: removes the vertices between two that see each other.
//!
//! Greedy from the start: from vertex i go straight to the last vertex j in sight, and on from there;
//! if no vertex beyond the next one is in sight, the path's own piece to it is kept as it is. The new path
//! is never longer than the given one, by the triangle inequality.
//!
//! Source: corner removal of Qin, Gao, Lu, "SSA*-PDWA", Computers, Materials & Continua 87(1), 2026,
//! as resolved in `systems.md` §3(a): `i → largest j with los_r(P_i, P_j, r)`; there r is half a cell
//! (Q-A5): `clearance_cells: 0.5`. Common practice otherwise ("string pulling").
//!
//! A shortcut keeps the inflation from obstacles as every planned line does ([`PlanningGrid::is_clear`]), or as much as the
//! path that it replaces where that has less.
//!
//! Departures: pieces between neighbouring vertices are kept even where they break the clearance, so
//! that a path remains a path; arcs of a stage before are pieces like any other.

use super::{PathKind, Room, shortened};
use crate::geometry::{Path, Vec2};
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, Failure, PathStage, Task};
use crate::settings::quantity::NonNegative;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `line_of_sight`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Distance that a shortcut must keep from blocked squares of the planning grid, m; larger keeps
    /// more of the path. Default 0: it keeps the inflation (`planning.inflation_m`) from obstacles, and without inflation
    /// it must not touch a blocked square.
    pub clearance_m: NonNegative,
    /// The same in cells of the map; the larger of the two counts. Half a cell lets a shortcut pass beside a blocked square along a row or
    /// column of cell centres and past no corner nearer than that. Default 0.
    pub clearance_cells: NonNegative,
}

impl Default for Params {
    fn default() -> Self {
        Self { clearance_m: NonNegative::new(0.0), clearance_cells: NonNegative::new(0.0) }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Goes straight to the farthest vertex in sight, again and again: fewer bends, never longer.",
    source: "corner removal of H. Qin et al., SSA*-PDWA, Computers, Materials & Continua 87(1), 2026",
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
    clearance_cells: f64,
    vertices: Vec<Vec2>,
    room_m: Vec<f64>,
}

impl Stage {
    /// A fresh stage.
    pub fn new(params: &Params) -> Self {
        Self {
            clearance_m: params.clearance_m.get(),
            clearance_cells: params.clearance_cells.get(),
            vertices: Vec::new(),
            room_m: Vec::new(),
        }
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
        self.vertices.clear();
        self.vertices.extend(path.vertices());
        let vertices = &self.vertices;
        let room = Room::of(grid, path, &mut self.room_m);
        let clearance_m = math::max(self.clearance_m, self.clearance_cells * grid.resolution_m());
        let in_sight = |i: usize, j: usize| room.may_replace(i..j, vertices[i], vertices[j], clearance_m);
        let last = vertices.len() - 1;
        shortened(path, |at| (at + 2..=last).rev().find(|&far| in_sight(at, far)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Piece;
    use crate::map::{Cell, OccupancyGrid};
    use crate::math::FRAC_PI_2;
    use crate::plan::contract::Problem;
    use crate::plan::global::GlobalChoice;
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};

    fn stage(clearance_m: f64) -> Stage {
        Stage::new(&Params { clearance_m: NonNegative::new(clearance_m), ..Params::default() })
    }

    fn points(numbers: &[(f64, f64)]) -> Vec<Vec2> {
        numbers.iter().map(|&(x, y)| Vec2::new(x, y)).collect()
    }

    #[test]
    fn vertices_between_two_that_see_each_other_go() {
        let (_, grid) = drawn(&[
            "......", //
            ".##...", //
            "......", //
        ]);
        // Over the block from left to right. The way up to (1.5, 2.5) touches its corner (1, 2), the way
        // down from (0.5, 2.5) to the end passes x = 3 at y = 1.875, below its top.
        let path = Path::polyline(&points(&[(0.5, 1.5), (0.5, 2.5), (1.5, 2.5), (3.5, 2.5), (4.5, 1.5)]));
        let kept: Vec<Vec2> = stage(0.0).treat(&grid, &path).vertices().collect();
        assert_eq!(kept, points(&[(0.5, 1.5), (0.5, 2.5), (3.5, 2.5), (4.5, 1.5)]));
    }

    #[test]
    fn shortcuts_keep_the_clearance_and_pieces_of_the_path_need_not() {
        let (_, grid) = drawn(&[
            ".....", //
            "..#..", //
            ".....", //
        ]);
        // Over the block's top, y = 2, on the line y = 2.25, and back down to the right.
        let path = Path::polyline(&points(&[(1.5, 2.25), (2.5, 2.25), (3.5, 2.25), (3.5, 1.0)]));
        let kept = |clearance_m| stage(clearance_m).treat(&grid, &path).vertices().collect::<Vec<_>>();
        assert_eq!(kept(0.25), points(&[(1.5, 2.25), (3.5, 2.25), (3.5, 1.0)]));
        assert_eq!(kept(0.26), path.vertices().collect::<Vec<_>>());
    }

    #[test]
    fn half_a_cell_of_clearance_is_the_corner_removal_of_the_paper() {
        for resolution_m in [1.0, 0.05] {
            let map = OccupancyGrid::from_ascii(
                &[
                    "......", //
                    "..#...", //
                    "......", //
                ],
                resolution_m,
            );
            let grid = uninflated(&map);
            let centres = |cells: &[(i32, i32)]| -> Vec<Vec2> {
                cells.iter().map(|&(col, row)| grid.centre(Cell { col, row })).collect()
            };
            let half = Params { clearance_cells: NonNegative::new(0.5), ..Params::default() };
            let kept = |cells: &[(i32, i32)]| -> Vec<Vec2> {
                Stage::new(&half).treat(&grid, &Path::polyline(&centres(cells))).vertices().collect()
            };
            // Along the row over the block, half a cell above its top and below the edge of the map.
            assert_eq!(kept(&[(0, 2), (1, 2), (2, 2), (3, 2), (4, 2)]), centres(&[(0, 2), (4, 2)]));
            // Down to (5, 1): from (0, 2) the line passes the block's corner (3, 2) at y = 2.5 − 2.5/5 = 2, through it. From (1, 2)
            // at y = 2.5 − 1.5/4 = 2.125 and from (2, 2) at 2.5 − 0.5/3 = 2.33, nearer than 0.5; from (3, 2), half a cell beyond
            // the corner, it goes away from it.
            let over = [(0, 2), (1, 2), (2, 2), (3, 2), (4, 2), (5, 1)];
            assert_eq!(kept(&over), centres(&[(0, 2), (4, 2), (5, 1)]));
            assert_eq!(kept(&over[3..]), centres(&[(3, 2), (5, 1)]));
            // Without the clearance (1, 2) sees (5, 1).
            let touching_nothing = stage(0.0).treat(&grid, &Path::polyline(&centres(&over[1..])));
            assert_eq!(touching_nothing.vertices().collect::<Vec<_>>(), centres(&[(1, 2), (5, 1)]));
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
        assert_eq!(stage(0.0).treat(&open, &path), Path::polyline(&points(&[(0.5, 0.5), (2.5, 2.5)])));
    }

    #[test]
    fn single_points_and_single_pieces_stay_as_they_are() {
        let (_, grid) = drawn(&["..", ".."]);
        for path in [Path::polyline(&points(&[(0.5, 0.5)])), Path::polyline(&points(&[(0.5, 0.5), (1.5, 1.5)]))] {
            assert_eq!(stage(0.0).treat(&grid, &path), path);
        }
    }

    #[test]
    fn pruned_paths_are_free_and_no_longer() {
        let mut stream = stream(31);
        let mut planner = GlobalChoice::by_name("a_star").expect("defaults").build();
        let (mut cells, mut shorter) = (Vec::new(), 0);
        for _ in 0..1500 {
            let share = stream.range(0.0, 0.35);
            let map = random_map(&mut stream, 30, share);
            let grid = uninflated(&map);
            let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
            if planner
                .as_grid()
                .expect("cells")
                .search(&Problem { grid: &grid, start, goal }, &mut cells)
                .result
                .is_err()
            {
                continue;
            }
            let vertices: Vec<Vec2> = cells.iter().map(|&cell| grid.centre(cell)).collect();
            let path = Path::polyline(&vertices);
            let pruned = stage(0.0).treat(&grid, &path);
            assert_eq!((pruned.start(), pruned.end()), (path.start(), path.end()));
            assert!(pruned.length() <= path.length() + 1e-9);
            let mut kept = vertices.iter();
            assert!(pruned.vertices().all(|vertex| kept.any(|&v| v == vertex)), "in the order of the path");
            assert!(pruned.segments().all(|(from, piece)| grid.line_of_sight(from, piece.end())));
            shorter += u32::from(pruned.length() < path.length() - 1e-9);
        }
        assert!(shorter > 300, "{shorter}");
    }
}
