//! `ssa_star`: A* that keeps half a cell from obstacles, and if asked pays for being near them.
//!
//! Source: Qin, Gao, Lu, "SSA*-PDWA", Computers, Materials & Continua 87(1), art. 86, 2026, §4.1 and eq. 20 (`qin2026`).
//!
//! ```text
//! f(n) = g(n) + h(n)                                  h = |n goal|, in cells
//! g(n) = Σ over the steps  |step| + w2 L / d          d: distance from the step's end to the nearest obstacle, L: side of a cell
//! ```
//!
//! **Inflation.** The paper inflates obstacles by r = L/2. On a binary grid that adds nothing or, taken as "≤", blocks the neighbours
//! of every obstacle and with them all lanes of one cell (Q-A5). `inflate: clearance`, the default, reads it as a distance: every edge
//! of the search keeps at least L/2 − 10⁻⁹ m from all obstacle squares. Between centres of neighbours this is, edge by edge,
//! the corner rule `forbid` and nothing beyond it:
//!
//! - A straight step between two free cells: no square comes nearer to it than the sides of its two cells do, and these are L/2
//!   away. All are allowed, beside obstacles and along the edge of the map.
//! - A diagonal step passes the vertex that its two cells share with the two cells beside it. If one of these is an obstacle the
//!   distance is 0: forbidden. If both are free, the other squares come no nearer than L/2 to its ends (those across an edge of an end) and
//!   L/√2 to its inside (the nearest vertices on either side): allowed.
//!
//! So with `clearance` and `safety_weight: 0` this planner *is* `a_star` with `heuristic: euclidean` and `corner_rule: forbid`, node by
//! node; it differs from an A* that cuts corners (`corner_rule: allow`), and by what follows the search: the corner removal of
//! the paper is [`line_of_sight`](crate::plan::path::line_of_sight) with `clearance_cells: 0.5`. The paper credits an "optimised
//! heuristic" with fewer expansions and defines none (Q-A4): there is none here.
//!
//! `dilate4` and `dilate8` block the cells beside blocked ones, across edges or vertices as well: the "≤" reading. Start and goal stay
//! passable, so do cells of escape zones. The edge of the map is *not* dilated, for the paper's maps are pictures whose drives begin and end
//! in their corners; everywhere else, `d` included, it counts as an obstacle, as in all of simrun.
//!
//! The inflation of the planning grid (`planning.inflation_m`) is in force besides: what it blocks is blocked, diagonal steps past such
//! cells are forbidden, and dilation goes on from there.
//!
//! **Safety cost.** The abstract has the safety cost in the search, algorithm 1 does not (Q-A3): `safety_weight`, w2, is 0 by default.
//! d is that of the distance field of the map as believed, from the cell's centre. The floor of 0.1 cell that the score of a path has
//! (Q-A1) never acts here: the centre of a passable cell is at least half a cell away. With w2 > 0 the Euclidean distance stays
//! admissible and consistent, so the path is one of smallest g; it is not a shortest one.
//!
//! Departures: the paper claims that optimality is kept; it holds on this graph alone, before corners are removed (Q-A14). "Dynamically
//! removing suboptimal nodes during the search" has no formula and is left out. In escape zones the step counts ten times, the
//! safety cost once. Ties: larger g, then smaller row-major index; with w2 > 0, g is summed from the start on.
//!
//! Parameters: [`Params`].

use super::search::{
    Arrival, Buckets, CornerRule, Heap, Heuristic, Move, Moves, Nodes, RealEntry, Rule, Steps, Visit, Workspace,
    euclidean,
};
use super::{GlobalKind, a_star};
use crate::map::Cell;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, GlobalPlanner, GridPlanner, Problem, Search};
use crate::settings::quantity::NonNegative;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the inflation of obstacles by half a cell means (Q-A5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Inflate {
    /// Edges keep half a cell from obstacle squares: no diagonal step past an obstacle.
    #[default]
    Clearance,
    /// Cells that share an edge with a blocked one are blocked as well, but for start and goal.
    Dilate4,
    /// The same for cells that share a vertex.
    Dilate8,
}

/// Parameters of `ssa_star`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// How obstacles are inflated. Default `clearance`.
    pub inflate: Inflate,
    /// w2, the cost of a step that ends one cell from an obstacle, in cells; larger keeps farther away. Default 0.
    pub safety_weight: NonNegative,
}

impl Default for Params {
    fn default() -> Self {
        Self { inflate: Inflate::Clearance, safety_weight: NonNegative::new(0.0) }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "A* that keeps half a cell from obstacles, with dilation and a cost of nearness to choose: safe grid paths.",
    source: "Qin, Gao, Lu, SSA*-PDWA, Computers, Materials & Continua 87(1), art. 86, 2026, section 4.1 and eq. 20",
    exact: true,
    ..Entry::PLAIN
};

impl GlobalKind for Params {
    fn build(&self) -> Box<dyn GlobalPlanner> {
        Box::new(Planner::new(self))
    }
}

/// A* as it is where nothing is paid for nearness.
const PLAIN: a_star::Params = a_star::Params { heuristic: Heuristic::Euclidean, corner_rule: CornerRule::Forbid };

/// The planner.
#[derive(Debug)]
pub struct Planner {
    params: Params,
    plain: Workspace<Steps, Buckets<RealEntry>>,
    /// Workspace for searches with a safety cost, whose f may rise by any amount.
    weighted: Workspace<f64, Heap<RealEntry>>,
    /// The grid with dilated obstacles.
    dilated: PlanningGrid,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self {
            params: params.clone(),
            plain: Workspace::default(),
            weighted: Workspace::default(),
            dilated: PlanningGrid::default(),
        }
    }
}

impl GridPlanner for Planner {
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        let Problem { grid, start, goal } = *problem;
        let grid = match self.params.inflate {
            Inflate::Clearance => grid,
            Inflate::Dilate4 | Inflate::Dilate8 => {
                self.dilated.clone_from(grid);
                self.dilated.dilate(self.params.inflate == Inflate::Dilate8, [start, goal]);
                &self.dilated
            }
        };
        let problem = &Problem { grid, start, goal };
        let safety_weight = self.params.safety_weight.get();
        if safety_weight > 0.0 {
            self.weighted.search(&Wary { problem, safety_weight }, problem, path)
        } else {
            self.plain.search(&a_star::CostPlusEstimate { problem, params: &PLAIN }, problem, path)
        }
    }
}

/// A* with a safety cost, for one problem.
struct Wary<'a> {
    problem: &'a Problem<'a>,
    safety_weight: f64,
}

impl Rule for Wary<'_> {
    type Cost = f64;
    type Priority = f64;

    fn reopens(&self) -> bool {
        false // the estimate is consistent
    }

    fn moves(&self, from: &Visit<f64>) -> Moves {
        Moves::allowed(self.problem.grid, from.index, CornerRule::Forbid)
    }

    fn connect(
        &self,
        _: &Nodes<f64>,
        from: &Visit<f64>,
        step: Move,
        stepped: f64,
        known: Option<f64>,
    ) -> Option<(u32, f64)> {
        let grid = self.problem.grid;
        let g = stepped + self.safety_weight / grid.obstacle_distance_cells(step.index_from(grid, from.index));
        known.is_none_or(|known| g < known).then_some((from.index, g))
    }

    fn priority(&self, arrival: Arrival<f64>) -> f64 {
        arrival.g + euclidean(arrival.cell, self.problem.goal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{DistanceField, OccupancyGrid};
    use crate::math;
    use crate::plan::clearance::Obstacles;
    use crate::plan::contract::Failure;
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};

    fn planner(inflate: Inflate, safety_weight: f64) -> Planner {
        Planner::new(&Params { inflate, safety_weight: NonNegative::new(safety_weight) })
    }

    /// All pairs of neighbours of a map, with the move between them.
    fn edges(map: &OccupancyGrid) -> impl Iterator<Item = (Cell, Cell, Move)> {
        let cells = (0..map.occupied().len()).map(|index| map.cell(index));
        cells.flat_map(|from| Move::ALL.into_iter().map(move |step| (from, step.from(from), step)))
    }

    #[test]
    fn edges_that_keep_half_a_cell_are_those_of_the_corner_rule_forbid() {
        let mut stream = stream(81);
        let (mut allowed, mut forbidden) = (0, 0);
        for case in 0..300 {
            let share = stream.range(0.0, 0.5);
            let map = random_map(&mut stream, 10, share);
            let field = DistanceField::new(&map);
            let obstacles = Obstacles::new(&map, &field);
            let inflation_m = if case % 2 == 0 { 0.0 } else { stream.range(0.0, 2.0) * map.resolution_m() };
            let grid = PlanningGrid::new(&map, &field, inflation_m);
            for (a, b, step) in edges(&map) {
                let keeps = obstacles.keeps(grid.centre(a), grid.centre(b), 0.5 * map.resolution_m());
                let is_allowed = Moves::allowed_if_passable(&grid, grid.index(a), CornerRule::Forbid).contains(step);
                // An inflation forbids more.
                assert!(if inflation_m > 0.0 { keeps || !is_allowed } else { keeps == is_allowed }, "{a:?} {b:?}");
                allowed += u32::from(is_allowed);
                forbidden += u32::from(!is_allowed && map.is_free(a) && map.is_free(b) && inflation_m == 0.0);
            }
        }
        assert!(allowed > 10_000 && forbidden > 1000, "{allowed} {forbidden}");
    }

    #[test]
    fn with_clearance_alone_it_is_a_star_that_forbids_corners() {
        let mut stream = stream(82);
        let (mut ssa, mut reference) = (planner(Inflate::Clearance, 0.0), a_star::Planner::new(&PLAIN));
        for _ in 0..500 {
            let map = random_map(&mut stream, 30, 0.3);
            let grid = uninflated(&map);
            let problem =
                Problem { grid: &grid, start: random_cell(&mut stream, &map), goal: random_cell(&mut stream, &map) };
            let (mut path, mut expected_path) = (Vec::new(), Vec::new());
            let expected = reference.search(&problem, &mut expected_path);
            assert_eq!((ssa.search(&problem, &mut path), path), (expected, expected_path));
        }
    }

    #[test]
    fn dilation_blocks_the_cells_beside_obstacles_but_for_start_and_goal() {
        let (_, grid) = drawn(&[
            ".......", //
            ".......", //
            "...#...", //
            ".......", //
            ".......", //
        ]);
        let cell = |col, row| Cell { col, row };
        let blocked = |across_corners, spared| {
            let mut dilated = grid.clone();
            dilated.dilate(across_corners, spared);
            let cells = (0..5).flat_map(|row| (0..7).map(move |col| Cell { col, row }));
            cells.filter(|&cell| !dilated.is_passable(cell)).collect::<Vec<_>>()
        };
        let nowhere = [cell(0, 0), cell(-1, -1)];
        let cross = [cell(3, 1), cell(2, 2), cell(3, 2), cell(4, 2), cell(3, 3)];
        assert_eq!(blocked(false, nowhere), cross);
        let square: Vec<Cell> = (1..=3).flat_map(|row| (2..=4).map(move |col| cell(col, row))).collect();
        assert_eq!(blocked(true, nowhere), square);
        assert_eq!(blocked(false, [cell(2, 2), cell(3, 3)]), [cell(3, 1), cell(3, 2), cell(4, 2)]);
        // A lane of one cell is closed by either, one of three leaves its middle.
        let lane = |lines: &[&str], inflate| {
            let (_, grid) = drawn(lines);
            let problem = Problem { grid: &grid, start: cell(0, 1), goal: cell(6, 1) };
            planner(inflate, 0.0).search(&problem, &mut Vec::new()).result
        };
        let (one, three) = ([".##.##.", ".......", ".##.##."], ["..####.", ".......", ".......", ".......", "..####."]);
        for inflate in [Inflate::Dilate4, Inflate::Dilate8] {
            assert_eq!(lane(&one, inflate), Err(Failure::NoPath));
            assert_eq!(lane(&three, inflate), Ok(()));
        }
        assert_eq!(lane(&one, Inflate::Clearance), Ok(()));
    }

    #[test]
    fn dilation_leaves_the_edge_of_the_map_and_escape_zones_open() {
        let (_, mut empty) = drawn(&["...", "...", "..."]);
        empty.dilate(true, [Cell { col: 0, row: 0 }; 2]);
        assert_eq!(empty.passable_count(), 9);
        // The obstacle blocks the cell under it, and not the inflated one beside it, once that is open.
        let (map, mut inflated) = drawn(&["#i...", "....."]);
        let (beside, under) = (Cell { col: 1, row: 1 }, Cell { col: 0, row: 0 });
        inflated.open_around(&map, beside);
        inflated.dilate(true, [Cell { col: 4, row: 0 }; 2]);
        assert!(inflated.is_passable(beside) && !inflated.is_passable(under));
    }

    #[test]
    fn the_safety_cost_of_a_corridor_is_that_by_hand() {
        // Five cells by three, without obstacles: d is 1.5 in the middle of the corridor and 0.5 at its edge.
        let (_, grid) = drawn(&[".....", ".....", "....."]);
        let cell = |col, row| Cell { col, row };
        assert_eq!(grid.obstacle_distance_cells(grid.index(cell(2, 1))), 1.5);
        assert_eq!(grid.obstacle_distance_cells(grid.index(cell(2, 0))), 0.5);
        let path = |safety_weight| {
            let mut path = Vec::new();
            let problem = Problem { grid: &grid, start: cell(0, 0), goal: cell(4, 0) };
            planner(Inflate::Clearance, safety_weight).search(&problem, &mut path).result.map(|()| path)
        };
        // Along the edge: 4 + 4 w2 / 0.5. By the middle: 2 + 2√2 + w2 (3 / 1.5 + 1 / 0.5). Equal at w2 = (2√2 − 2) / 4 = 0.2071.
        let straight: Vec<Cell> = (0..5).map(|col| cell(col, 0)).collect();
        assert_eq!(path(0.207), Ok(straight));
        assert_eq!(path(0.208), Ok(vec![cell(0, 0), cell(1, 1), cell(2, 1), cell(3, 1), cell(4, 0)]));
    }

    #[test]
    fn costs_with_safety_are_the_least_that_relaxing_finds() {
        let mut stream = stream(83);
        let (mut found, mut farther) = (0, 0);
        for _ in 0..400 {
            let share = stream.range(0.0, 0.4);
            let map = random_map(&mut stream, 14, share);
            let grid = uninflated(&map);
            let safety_weight = stream.range(0.1, 5.0);
            let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
            let field = DistanceField::new(&map);
            let cost = |a: Cell, b: Cell| {
                euclidean(a, b)
                    + safety_weight * map.resolution_m() / math::max(field.distance_m(b), 0.1 * map.resolution_m())
            };
            let mut path = Vec::new();
            let problem = Problem { grid: &grid, start, goal };
            if planner(Inflate::Clearance, safety_weight).search(&problem, &mut path).result.is_err() {
                continue;
            }
            let mut least = vec![f64::INFINITY; map.occupied().len()];
            least[map.index(start)] = 0.0;
            loop {
                let before = least.clone();
                for (a, b, step) in edges(&map) {
                    if Moves::allowed_if_passable(&grid, grid.index(a), CornerRule::Forbid).contains(step) {
                        least[map.index(b)] = math::min(least[map.index(b)], least[map.index(a)] + cost(a, b));
                    }
                }
                if least == before {
                    break;
                }
            }
            let of_path: f64 = path.windows(2).map(|pair| cost(pair[0], pair[1])).sum();
            assert!((of_path - least[map.index(goal)]).abs() < 1e-9, "{of_path} {}", least[map.index(goal)]);
            found += 1;
            let mut plain = Vec::new();
            let _ = planner(Inflate::Clearance, 0.0).search(&problem, &mut plain);
            let length = |path: &[Cell]| path.windows(2).map(|pair| euclidean(pair[0], pair[1])).sum::<f64>();
            farther += u32::from(length(&path) > length(&plain) + 1e-9);
        }
        assert!(found > 150 && farther > 30, "{found} {farther}");
    }
}
