//! `farthest_visible`: from each key node on to the last node before the first one that is out of sight.
//!
//! Source: redundant point elimination of Hu, Wang, Zhang, Research on Dynamic Obstacle Avoidance Method of Mobile Robot based on
//! Improved A* Algorithm and Dynamic Window Method, Engineering Letters 32(3), 2024, §II.B (`hu2024`).
//!
//! The nodes n_1 to n_m are those of the path as it comes, every cell of a grid path included. n_1 is a key node. From the last key
//! node the segments to the nodes that follow are tried in order; where the one to n_i is blocked, n_{i−1} is the next key node
//! (H-A5: and the walk goes on from there, where the paper says "from n_i"). n_m is the last. The key nodes are joined by lines, and
//! the path names them: they stay key nodes where the path goes straight on at one.
//!
//! **Not [`line_of_sight`](super::line_of_sight).** That stage goes to the last node in sight, this one to the last before the first
//! that is *out* of sight: where a path leaves a node's sight and comes back into it, as round a block beside the straight way,
//! `line_of_sight` cuts across and this stage follows the path round. Neither is always the shorter one, for both are greedy;
//! where no node comes back into sight they are the same. The rule of sight is the same: a segment keeps the inflation
//! from obstacles, or as much as the part of the path that it replaces, and without inflation it touches no blocked cell.
//!
//! Neighbouring nodes count as seeing each other: the piece between them is kept as it is, an arc or a curve too.

use super::{PathKind, Room, shortened};
use crate::geometry::{Path, Vec2};
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, Failure, PathStage, Task};
use crate::settings::quantity::NonNegative;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `farthest_visible`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Distance that a segment must keep from blocked squares of the planning grid, in cells of the map; larger keeps more nodes.
    /// Default 0: it must not touch one, and with inflation it keeps that from obstacles.
    pub clearance_cells: NonNegative,
}

impl Default for Params {
    fn default() -> Self {
        Self { clearance_cells: NonNegative::new(0.0) }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Goes straight to the last node before the first one that is out of sight: fewer bends, never longer.",
    source: "Hu, Wang, Zhang, Research on Dynamic Obstacle Avoidance Method of Mobile Robot based on Improved A* Algorithm and Dynamic Window Method, Engineering Letters 32(3), 2024, section II.B",
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
    clearance_cells: f64,
    room_m: Vec<f64>,
}

impl Stage {
    /// A fresh stage.
    pub fn new(params: &Params) -> Self {
        Self { clearance_cells: params.clearance_cells.get(), room_m: Vec::new() }
    }

    /// The path as this stage makes it on `grid`.
    fn treat(&mut self, grid: &PlanningGrid, path: &Path) -> Path {
        let nodes: Vec<Vec2> = path.vertices().collect();
        let room = Room::of(grid, path, &mut self.room_m);
        let clearance_m = self.clearance_cells * grid.resolution_m();
        let in_sight = |i: usize, j: usize| room.may_replace(i..j, nodes[i], nodes[j], clearance_m);
        shortened(path, |key| (key + 2..nodes.len()).take_while(|&i| in_sight(key, i)).last())
            .with_key_nodes_at_ends(|_| true)
    }
}

impl PathStage for Stage {
    fn apply(&mut self, task: &Task<'_>, path: &Path) -> Result<Path, Failure> {
        Ok(self.treat(task.grid, path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{KeyNode, Piece};
    use crate::map::Cell;
    use crate::math::FRAC_PI_2;
    use crate::plan::contract::Problem;
    use crate::plan::global::GlobalChoice;
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};
    use crate::plan::path::line_of_sight;

    fn stage(clearance_cells: f64) -> Stage {
        Stage::new(&Params { clearance_cells: NonNegative::new(clearance_cells) })
    }

    fn points(numbers: &[(f64, f64)]) -> Vec<Vec2> {
        numbers.iter().map(|&(x, y)| Vec2::new(x, y)).collect()
    }

    fn key_nodes(path: &Path) -> Vec<KeyNode> {
        let mut nodes = Vec::new();
        path.key_nodes(&mut nodes);
        nodes
    }

    /// The paper's three steps word by word, for nodes at centres of cells.
    fn key_node_set(grid: &PlanningGrid, nodes: &[Cell]) -> Vec<Cell> {
        let mut set = vec![nodes[0]];
        let (mut key, mut i) = (0, 2);
        while i < nodes.len() {
            if grid.line_of_sight_cells(nodes[key], nodes[i]) {
                i += 1;
            } else {
                key = i - 1;
                set.push(nodes[key]);
                i = key + 2;
            }
        }
        if nodes.len() > 1 {
            set.push(nodes[nodes.len() - 1]);
        }
        set
    }

    #[test]
    fn it_stops_before_the_first_node_out_of_sight_where_line_of_sight_looks_on() {
        let (_, grid) = drawn(&[
            ".....", //
            ".....", //
            "..#..", //
            ".....", //
        ]);
        // Along the row under the block, up beside it and down again. The line from (0.5, 0.5) to (3.5, 1.5) passes the block's corner
        // (2, 1): 0.5 + 1.5/3 = 1. (4.5, 0.5), beyond it, is in sight.
        let path = Path::polyline(&points(&[(0.5, 0.5), (2.5, 0.5), (3.5, 1.5), (4.5, 0.5)]));
        let kept = stage(0.0).treat(&grid, &path);
        assert_eq!(kept.vertices().collect::<Vec<_>>(), points(&[(0.5, 0.5), (2.5, 0.5), (4.5, 0.5)]));
        let robot = crate::robot::Robot::default();
        let belief = crate::observation::Belief::from(&crate::map::OccupancyGrid::empty(5, 4, 1.0));
        let pose = crate::geometry::Pose { position: path.start(), theta: 0.0 };
        let situation = crate::plan::contract::Situation::new(&robot, &belief, pose, path.end());
        let task = Task { situation: &situation, grid: &grid, start: path.start(), goal: path.end() };
        let straight = line_of_sight::Params::default().build().apply(&task, &path).expect("a path");
        assert_eq!(straight, Path::polyline(&points(&[(0.5, 0.5), (4.5, 0.5)])));
    }

    #[test]
    fn key_nodes_are_named_and_stay_where_the_path_goes_straight_on() {
        let (_, grid) = drawn(&[
            "......", //
            "...#..", //
            "......", //
        ]);
        // (3.5, 2.5) is the last node that (0.5, 2.5) sees before the detour (4.5, 1.5): the line there passes through the block.
        let path = Path::polyline(&points(&[(0.5, 2.5), (1.5, 2.5), (3.5, 2.5), (4.5, 1.5), (5.5, 2.5)]));
        let kept = stage(0.0).treat(&grid, &path);
        assert!(kept.has_named_nodes());
        let nodes = key_nodes(&kept);
        assert_eq!(
            nodes.iter().map(|node| node.position).collect::<Vec<_>>(),
            points(&[(0.5, 2.5), (3.5, 2.5), (5.5, 2.5)])
        );
        assert_eq!(nodes.iter().map(|node| node.along_m).collect::<Vec<_>>(), [0.0, 3.0, 5.0]);
    }

    #[test]
    fn half_a_cell_of_clearance_keeps_the_nodes_beside_a_corner() {
        let (_, grid) = drawn(&[
            "......", //
            "..#...", //
            "......", //
        ]);
        // To (5.5, 1.5): from (1.5, 2.5) at 0.125 m from the block's corner (3, 2), from (3.5, 2.5) away from it.
        let path = Path::polyline(&points(&[(1.5, 2.5), (2.5, 2.5), (3.5, 2.5), (4.5, 2.5), (5.5, 1.5)]));
        let kept = |clearance| stage(clearance).treat(&grid, &path).vertices().collect::<Vec<_>>();
        assert_eq!(kept(0.0), points(&[(1.5, 2.5), (5.5, 1.5)]));
        assert_eq!(kept(0.5), points(&[(1.5, 2.5), (4.5, 2.5), (5.5, 1.5)]));
    }

    #[test]
    fn arcs_stay_unless_a_segment_passes_over_them_and_short_paths_stay() {
        let arc = Piece::Arc { to: Vec2::new(2.5, 1.5), centre: Vec2::new(1.5, 1.5), sweep: FRAC_PI_2 };
        let pieces = vec![Piece::Line { to: Vec2::new(1.5, 0.5) }, arc, Piece::Line { to: Vec2::new(2.5, 2.5) }];
        let path = Path::new(Vec2::new(0.5, 0.5), pieces);
        let (_, wall) = drawn(&["#..", "##.", "..."]);
        assert_eq!(stage(0.0).treat(&wall, &path).pieces(), path.pieces());
        let (_, open) = drawn(&["...", "...", "..."]);
        assert_eq!(stage(0.0).treat(&open, &path).pieces(), [Piece::Line { to: Vec2::new(2.5, 2.5) }]);
        for path in [Path::polyline(&points(&[(0.5, 0.5)])), Path::polyline(&points(&[(0.5, 0.5), (1.5, 1.5)]))] {
            let kept = stage(0.0).treat(&open, &path);
            assert_eq!((kept.pieces(), key_nodes(&kept).len()), (path.pieces(), path.pieces().len() + 1));
        }
    }

    #[test]
    fn key_nodes_of_grid_paths_are_those_of_the_three_steps() {
        let mut stream = stream(131);
        let mut planner = GlobalChoice::by_name("a_star").expect("defaults").build();
        let (mut cells, mut shorter, mut unlike) = (Vec::new(), 0, 0);
        for _ in 0..1500 {
            let share = stream.range(0.0, 0.35);
            let map = random_map(&mut stream, 30, share);
            let grid = uninflated(&map);
            let problem =
                Problem { grid: &grid, start: random_cell(&mut stream, &map), goal: random_cell(&mut stream, &map) };
            if planner.as_grid().expect("cells").search(&problem, &mut cells).result.is_err() {
                continue;
            }
            let path = Path::polyline(&cells.iter().map(|&cell| grid.centre(cell)).collect::<Vec<_>>());
            let kept = stage(0.0).treat(&grid, &path);
            let expected: Vec<Vec2> = key_node_set(&grid, &cells).iter().map(|&cell| grid.centre(cell)).collect();
            assert_eq!(key_nodes(&kept).iter().map(|node| node.position).collect::<Vec<_>>(), expected);
            assert!(kept.length() <= path.length() + 1e-9);
            assert!(kept.segments().all(|(from, piece)| grid.line_of_sight(from, piece.end())));
            shorter += u32::from(kept.length() < path.length() - 1e-9);
            let nodes: Vec<Vec2> = path.vertices().collect();
            let last = nodes.len() - 1;
            let farthest =
                shortened(&path, |at| (at + 2..=last).rev().find(|&far| grid.line_of_sight(nodes[at], nodes[far])));
            unlike += u32::from(farthest.pieces() != kept.pieces());
        }
        assert!(shorter > 300 && unlike > 10, "{shorter} {unlike}");
    }
}
