//! `atan_a_star`: A* whose estimate weighs the more, the more obstacles lie between the node and the goal.
//!
//! Source: Zhao, Xie, Xu, Zhu, Xu, dynamic path planning for inspection robots based on improved A* and DWA, 2025, eq. 2 to 6 (`zhao2025`).
//!
//! ```text
//! f(n) = g(n) + α(n) h(n)        h = |dx| + |dy| to the goal, in cells
//! α(n) = atan μ(n)               from 0 to below π/2
//! μ(n) = obstacles(n) / |start goal|
//! ```
//!
//! obstacles(n) is the number of blocked cells of the planning grid in the box that n and the goal span, both included; |start goal| is
//! Euclidean and in cells. A table of sums over all boxes from the corner of the map, built once per search, gives each count by four
//! look-ups.
//!
//! **What that does.** Where the box is empty, α is 0 and the search is Dijkstra's: near the goal, and everywhere on an open map. μ is a count
//! of cells over a length, so α depends on the size of the map: on one of N × N cells of which a share s is blocked it is about
//! atan(s N / √2) at the start and falls towards the goal. Where α is below 1 the search expands more nodes than A*, not fewer.
//! [`Density::alpha_at`] says what α is.
//!
//! **Length.** At the goal h is 0, and until then some node n of a shortest path is open at its smallest cost, so the path costs at most
//! max(1, α(n) h(n) / h*(n)) as much as a shortest one, the maximum over the nodes of any shortest path, h* the cost that is left.
//!
//! Readings of the paper (ids of `systems.md`):
//! - Z-A2: eq. 2 measures to the next node; the estimate must be that to the goal.
//! - Z-A3: Manhattan, which overestimates on a grid with diagonal steps; `heuristic` selects.
//! - Z-A4: the printed weight grows with obstacles, whatever the prose says of it ("adaptive"): `weight_form`.
//! - Z-A5: the printed sums fail where the goal has the smaller column or row: the box spanned by the two cells. The denominator is
//!   the distance from the start, as printed, and constant.
//!
//! Departures: cells that the inflation of the planning grid blocks count as obstacles. Neither form is consistent, so nodes are
//! expanded again when a cheaper connection is found, and each time counts. Ties: larger g, then smaller row-major index.
//!
//! The paper prunes the path afterwards: [`grandparent_prune`](crate::plan::path::grandparent_prune).
//!
//! Parameters: [`Params`].

use super::GlobalKind;
use super::search::{
    Arrival, CornerRule, Cost, Heap, Heuristic, Moves, RealEntry, Rule, Steps, Visit, Workspace, euclidean,
};
use crate::map::Cell;
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, GlobalPlanner, GridPlanner, Problem, Search};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The weight of the estimate (Z-A4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WeightForm {
    /// atan μ, as printed: 0 in open space, greedier among obstacles.
    #[default]
    AtanMu,
    /// π/2 − atan μ, the other direction: greedy in open space, careful among obstacles.
    HalfPiMinusAtanMu,
}

/// Parameters of `atan_a_star`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Estimate of the cost to the goal. Default `manhattan`.
    pub heuristic: Heuristic,
    /// The weight as a formula. Default `atan_mu`.
    pub weight_form: WeightForm,
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

impl Default for Params {
    fn default() -> Self {
        Self { heuristic: Heuristic::Manhattan, weight_form: WeightForm::AtanMu, corner_rule: CornerRule::Forbid }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "A* whose estimate weighs more where more obstacles lie between node and goal; like dijkstra on open maps.",
    source: "Zhao, Xie, Xu, Zhu, Xu, Dynamic path planning for inspection robots based on improved A* and DWA, 2025, eq. 2 to 6",
    ..Entry::PLAIN
};

impl GlobalKind for Params {
    fn build(&self) -> Box<dyn GlobalPlanner> {
        Box::new(Planner::new(self))
    }
}

/// The numbers of blocked cells in boxes of a planning grid; its memory is used again.
#[derive(Clone, Debug, Default)]
struct BlockedCounts {
    /// Sums have one column and one row more than the grid.
    stride: usize,
    /// Blocked cells in the columns and rows below those of the place, row-major.
    sums: Vec<u32>,
}

impl BlockedCounts {
    /// Takes in a grid.
    fn rebuild(&mut self, grid: &PlanningGrid) {
        let (cols, rows) = (grid.cols() as usize, grid.rows() as usize);
        self.stride = cols + 1;
        self.sums.clear();
        self.sums.resize(self.stride * (rows + 1), 0);
        for row in 0..rows {
            let mut in_row = 0;
            for col in 0..cols {
                let cell = Cell { col: col as i32, row: row as i32 };
                in_row += u32::from(!grid.is_passable(cell));
                let at = (row + 1) * self.stride + col + 1;
                self.sums[at] = self.sums[at - self.stride] + in_row;
            }
        }
    }

    /// Blocked cells in the box that two cells of the grid span, both included.
    fn between(&self, a: Cell, b: Cell) -> u32 {
        let span = |a: i32, b: i32| (a.min(b) as usize, a.max(b) as usize + 1);
        let ((left, right), (bottom, top)) = (span(a.col, b.col), span(a.row, b.row));
        let sum = |col: usize, row: usize| self.sums[row * self.stride + col];
        sum(right, top) + sum(left, bottom) - sum(left, top) - sum(right, bottom)
    }
}

/// The density of obstacles between a cell and the goal of a problem, and the weight α that follows from it.
#[derive(Clone, Debug)]
pub struct Density {
    counts: BlockedCounts,
    goal: Cell,
    /// In cells.
    start_to_goal: f64,
}

impl Density {
    /// That of a problem.
    pub fn new(problem: &Problem<'_>) -> Self {
        let mut density = Self::unknown();
        density.rebuild(problem);
        density
    }

    /// That of no problem yet.
    fn unknown() -> Self {
        Self { counts: BlockedCounts::default(), goal: Cell { col: 0, row: 0 }, start_to_goal: 0.0 }
    }

    /// Becomes that of another problem.
    fn rebuild(&mut self, problem: &Problem<'_>) {
        self.counts.rebuild(problem.grid);
        self.goal = problem.goal;
        self.start_to_goal = euclidean(problem.start, problem.goal);
    }

    /// μ of a cell, in blocked cells per cell of distance: 0 where nothing is blocked, infinite where start and goal are one cell and
    /// something is.
    ///
    /// # Panics
    /// If the cell or the goal is not on the grid.
    pub fn mu_at(&self, cell: Cell) -> f64 {
        match self.counts.between(cell, self.goal) {
            0 => 0.0,
            count => f64::from(count) / self.start_to_goal,
        }
    }

    /// α of a cell, from 0 to π/2.
    ///
    /// # Panics
    /// As [`Self::mu_at`].
    pub fn alpha_at(&self, cell: Cell, form: WeightForm) -> f64 {
        let alpha = math::atan(self.mu_at(cell));
        match form {
            WeightForm::AtanMu => alpha,
            WeightForm::HalfPiMinusAtanMu => math::FRAC_PI_2 - alpha,
        }
    }
}

/// The planner.
#[derive(Debug)]
pub struct Planner {
    params: Params,
    density: Density,
    workspace: Workspace<Steps, Heap<RealEntry>>,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone(), density: Density::unknown(), workspace: Workspace::default() }
    }
}

impl GridPlanner for Planner {
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        self.density.rebuild(problem);
        let rule = Weighted { problem, params: &self.params, density: &self.density };
        self.workspace.search(&rule, problem, path)
    }
}

/// The rule for one problem.
struct Weighted<'a> {
    problem: &'a Problem<'a>,
    params: &'a Params,
    density: &'a Density,
}

impl Rule for Weighted<'_> {
    type Cost = Steps;
    type Priority = f64;

    fn reopens(&self) -> bool {
        true
    }

    fn moves(&self, from: &Visit<Steps>) -> Moves {
        Moves::worthwhile(self.problem.grid, from.index, self.params.corner_rule, from.arrived_by)
    }

    fn priority(&self, arrival: Arrival<Steps>) -> f64 {
        let alpha = self.density.alpha_at(arrival.cell, self.params.weight_form);
        arrival.g.value() + alpha * self.params.heuristic.added_to(Steps::ZERO, arrival.cell, self.problem.goal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::OccupancyGrid;
    use crate::plan::global::{GlobalChoice, dijkstra};
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};

    const FORMS: [WeightForm; 2] = [WeightForm::AtanMu, WeightForm::HalfPiMinusAtanMu];

    #[test]
    fn counts_are_those_of_looking_at_every_cell() {
        let mut stream = stream(91);
        let mut counts = BlockedCounts::default();
        let mut counted = 0;
        for _ in 0..300 {
            let share = stream.range(0.0, 1.0);
            let map = random_map(&mut stream, 25, share);
            counts.rebuild(&uninflated(&map));
            for _ in 0..30 {
                let (a, b) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
                let cells = (0..map.occupied().len()).map(|index| map.cell(index));
                let is_within = |cell: &Cell| {
                    let between = |x: i32, a: i32, b: i32| (a <= x && x <= b) || (b <= x && x <= a);
                    between(cell.col, a.col, b.col) && between(cell.row, a.row, b.row)
                };
                let expected = cells.filter(is_within).filter(|&cell| !map.is_free(cell)).count();
                assert_eq!(counts.between(a, b) as usize, expected, "{a:?} {b:?}");
                counted += expected;
            }
        }
        assert!(counted > 100_000, "{counted}");
    }

    #[test]
    fn weights_and_priorities_are_those_of_the_formulas_by_hand() {
        let (_, grid) = drawn(&[
            "....#", //
            ".....", //
            ".##..", //
            ".....", //
            "..#..", //
        ]);
        let cell = |col, row| Cell { col, row };
        // |start goal| = 5.
        let problem = Problem { grid: &grid, start: cell(0, 0), goal: cell(3, 4) };
        let density = Density::new(&problem);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
        // Blocked in the box: three from the start, two from (0, 1), none from (3, 3), and one from (4, 3), on the other side.
        let by_hand = [
            (cell(0, 0), 0.6, 0.540_419_500_27),
            (cell(0, 1), 0.4, 0.380_506_377_11),
            (cell(4, 3), 0.2, 0.197_395_559_85),
            (cell(3, 3), 0.0, 0.0),
            (cell(3, 4), 0.0, 0.0),
        ];
        for (at, mu, alpha) in by_hand {
            close(density.mu_at(at), mu);
            close(density.alpha_at(at, WeightForm::AtanMu), alpha);
            close(density.alpha_at(at, WeightForm::HalfPiMinusAtanMu), math::FRAC_PI_2 - alpha);
        }
        let f = |params: Params, cell, straight| {
            let g = Steps { straight, diagonal: 0 };
            Weighted { problem: &problem, params: &params, density: &density }.priority(Arrival { cell, g, from: None })
        };
        // (0, 1): three columns and three rows, or √18.
        close(f(Params::default(), cell(0, 1), 1), 1.0 + 6.0 * 0.380_506_377_11);
        let euclidean = Params { heuristic: Heuristic::Euclidean, ..Params::default() };
        close(f(euclidean, cell(0, 1), 1), 1.0 + 18f64.sqrt() * 0.380_506_377_11);
        let other = Params { weight_form: WeightForm::HalfPiMinusAtanMu, ..Params::default() };
        close(f(other, cell(0, 1), 1), 1.0 + 6.0 * 1.190_289_949_68);
        close(f(Params::default(), cell(3, 4), 7), 7.0);
    }

    #[test]
    fn on_a_map_without_obstacles_it_expands_what_dijkstra_does() {
        let mut stream = stream(92);
        for _ in 0..100 {
            let map = random_map(&mut stream, 25, 0.0);
            let grid = uninflated(&map);
            let problem =
                Problem { grid: &grid, start: random_cell(&mut stream, &map), goal: random_cell(&mut stream, &map) };
            let mut reference = GlobalChoice::dijkstra(dijkstra::Params { corner_rule: CornerRule::Forbid }).build();
            let (mut path, mut expected_path) = (Vec::new(), Vec::new());
            let expected = reference.as_grid().expect("cells").search(&problem, &mut expected_path);
            assert_eq!((Planner::new(&Params::default()).search(&problem, &mut path), path), (expected, expected_path));
        }
    }

    #[test]
    fn the_two_forms_search_the_other_way_round() {
        // Open: atan μ is 0 and everything nearer than the goal is expanded, π/2 − atan μ goes straight there.
        let map = OccupancyGrid::empty(21, 21, 1.0);
        let grid = uninflated(&map);
        let problem = Problem { grid: &grid, start: Cell { col: 10, row: 10 }, goal: Cell { col: 18, row: 10 } };
        let expanded = |weight_form| {
            Planner::new(&Params { weight_form, ..Params::default() }).search(&problem, &mut Vec::new()).expanded
        };
        assert_eq!(expanded(WeightForm::HalfPiMinusAtanMu), 8);
        assert!(expanded(WeightForm::AtanMu) > 150);
    }

    #[test]
    fn costs_keep_the_bound() {
        let mut stream = stream(93);
        let (mut longer, mut shortest, mut expanded) = (0, 0, [0; 2]);
        for _ in 0..1500 {
            let share = stream.range(0.0, 0.45);
            let map = random_map(&mut stream, 30, share);
            let grid = uninflated(&map);
            let problem =
                Problem { grid: &grid, start: random_cell(&mut stream, &map), goal: random_cell(&mut stream, &map) };
            let density = Density::new(&problem);
            for corner_rule in [CornerRule::Forbid, CornerRule::Allow] {
                let mut reference = GlobalChoice::dijkstra(dijkstra::Params { corner_rule }).build();
                let (mut best, mut path) = (Vec::new(), Vec::new());
                let result = reference.as_grid().expect("cells").search(&problem, &mut best).result;
                let cost = |path: &[Cell]| path.windows(2).map(|pair| euclidean(pair[0], pair[1])).sum::<f64>();
                let optimum = cost(&best);
                for weight_form in FORMS {
                    for heuristic in [Heuristic::Manhattan, Heuristic::Euclidean] {
                        let params = Params { heuristic, weight_form, corner_rule };
                        let found = Planner::new(&params).search(&problem, &mut path);
                        assert_eq!(found.result, result);
                        if result.is_err() {
                            continue;
                        }
                        let factor = |k: usize| {
                            let left = cost(&best[k..]);
                            let h = heuristic.added_to(Steps::ZERO, best[k], problem.goal);
                            if left > 0.0 { density.alpha_at(best[k], weight_form) * h / left } else { 1.0 }
                        };
                        let bound = (0..best.len()).map(factor).fold(1.0, math::max);
                        assert!(cost(&path) <= bound * optimum + 1e-9, "{} {bound} {optimum}", cost(&path));
                        assert!(cost(&path) >= optimum - 1e-9);
                        longer += u32::from(cost(&path) > optimum + 1e-9);
                        shortest += u32::from(bound == 1.0 && optimum > 0.0);
                        expanded[weight_form as usize] += found.expanded;
                    }
                }
            }
        }
        assert!(longer > 100 && shortest > 1000, "{longer} {shortest}");
        assert!(expanded[1] < expanded[0], "Z-A4: on maps this small atan μ is mostly below 1: {expanded:?}");
    }
}
