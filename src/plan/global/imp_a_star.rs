//! `imp_a_star`: A* that leans towards the goal, the more so the farther away it is.
//!
//! Source: Gao, Zhang, Liu, Ou, Cheng, Zhu, the ImpA*-ImpDWA paper, AIMS Press, 2025, eq. 2–10 (`gao2025`).
//!
//! ```text
//! O     = blocked cells / all cells
//! w(n)  = exp(d1 / d2) − (1 − exp(−O)) / 2          d1 = |n goal|, d2 = |start goal|
//! f(n)  = g(n) + w(n) h(n) − K D cos φ              h = |n goal|, D = |p goal|, p the node before n
//! φ     = angle at p between p → goal and p → n
//! ```
//!
//! All distances are Euclidean and in cells. w falls from e − (1 − exp(−O))/2 at the start to
//! 1 − (1 − exp(−O))/2 at the goal (2.62 and 0.90 where 22 % of the map are blocked). So this is a greedy
//! search, and its paths are *not* shortest ones: f is no lower bound of anything and may be negative (G-A5).
//! What the paper gains in length comes from [`clearance_prune`](crate::plan::path::clearance_prune) and
//! [`arc_fillet`](crate::plan::path::arc_fillet).
//!
//! Readings of the paper (ids of `systems.md`):
//! - G-A1, G-A2: O in eq. 9 and 10 as in eq. 6, d1 from the node and d2 from the start.
//! - G-A3: K is only said to be between 0 and 1; `direction_gain`, to be reported with results.
//! - G-A4: the term that the paper calls a turning cost rewards steps towards the goal; it knows nothing of the
//!   step before. That is the default; `direction_term: previous_step` is the penalty K D (1 − cos turn) instead.
//! - G-A6: beyond d2 from the goal w exceeds e; `w_clamp` cuts d1/d2 at 1.
//! - G-A7: O is that of the whole map. The planning grid counts, as that is what the planner is given: cells
//!   blocked by inflation are blocked, those of escape zones are not. Without inflation (the paper's setting) it
//!   is occupied cells over all cells.
//! - The direction term is part of the priority alone and never of g. Where a node is reached again at the same
//!   cost the first connection stays, and its f with it.
//!
//! Closed nodes are opened again when a cheaper connection is found: h times w is not consistent, and each
//! re-expansion counts. Ties: larger g, then smaller row-major index. When start and goal are one cell d1/d2 is 0.
//!
//! Parameters: [`Params`].

use super::GlobalKind;
use super::search::{Arrival, CornerRule, Cost, Heap, Moves, RealEntry, Rule, Steps, Visit, Workspace};
use crate::geometry::Vec2;
use crate::map::Cell;
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, GlobalPlanner, GridPlanner, Problem, Search};
use crate::settings::quantity::Fraction;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the directions of steps do to the priority of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DirectionTerm {
    /// −K D cos φ: steps towards the goal are rewarded, as printed.
    #[default]
    Goal,
    /// +K D (1 − cos turn): turns from the step before are penalised, as the text has it (G-A4).
    PreviousStep,
    /// Nothing.
    Off,
}

/// The weight of h.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Weight {
    /// w(n), as printed.
    #[default]
    Dynamic,
    /// 1: with `direction_term: off` this is A*.
    One,
}

/// Parameters of `imp_a_star`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// K, the share of the direction term; higher goes straighter at the goal (or turns less). Default 0.5.
    pub direction_gain: Fraction,
    /// What that term measures. Default `goal`.
    pub direction_term: DirectionTerm,
    /// The weight of the estimate. Default `dynamic`.
    pub weight: Weight,
    /// Whether d1/d2 is cut at 1, so that w is at most e. Default false.
    pub w_clamp: bool,
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            direction_gain: Fraction::new(0.5),
            direction_term: DirectionTerm::Goal,
            weight: Weight::Dynamic,
            w_clamp: false,
            corner_rule: CornerRule::Forbid,
        }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Greedy A* with an exponential weight and a reward for steps towards the goal: few expansions, paths not shortest.",
    source: "Gao, Zhang, Liu, Ou, Cheng, Zhu, ImpA*-ImpDWA, AIMS Press, 2025, eq. 2 to 10",
    ..Entry::PLAIN
};

impl GlobalKind for Params {
    fn build(&self) -> Box<dyn GlobalPlanner> {
        Box::new(Planner::new(self))
    }
}

/// The planner.
#[derive(Debug)]
pub struct Planner {
    params: Params,
    workspace: Workspace<Steps, Heap<RealEntry>>,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone(), workspace: Workspace::default() }
    }
}

impl GridPlanner for Planner {
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search {
        self.workspace.search(&Leaning::new(problem, &self.params), problem, path)
    }
}

/// The rule for one problem.
struct Leaning<'a> {
    problem: &'a Problem<'a>,
    params: &'a Params,
    /// (1 − exp(−O)) / 2.
    obstacle_discount: f64,
    /// d2, in cells.
    start_to_goal: f64,
}

impl<'a> Leaning<'a> {
    fn new(problem: &'a Problem<'a>, params: &'a Params) -> Self {
        Self {
            problem,
            params,
            obstacle_discount: 0.5 * (1.0 - math::exp(-obstacle_ratio(problem.grid))),
            start_to_goal: between(problem.start, problem.goal).norm(),
        }
    }

    /// w of a node at `to_goal` cells from the goal.
    fn weight(&self, to_goal: f64) -> f64 {
        if self.params.weight == Weight::One {
            return 1.0;
        }
        let share = if self.start_to_goal > 0.0 { to_goal / self.start_to_goal } else { 0.0 };
        let share = if self.params.w_clamp { math::min(share, 1.0) } else { share };
        math::exp(share) - self.obstacle_discount
    }

    /// Direction term of f for the step from `from` to `cell`, in cells.
    fn direction_term(&self, from: &Visit<Steps>, cell: Cell) -> f64 {
        let step = direction(from.cell, cell);
        let to_goal = between(from.cell, self.problem.goal);
        let gain = self.params.direction_gain.get();
        match (self.params.direction_term, from.arrived_by) {
            // D cos φ is the part of the way to the goal that lies along the step.
            (DirectionTerm::Goal, _) => -gain * to_goal.dot(&step),
            (DirectionTerm::PreviousStep, Some(before)) => {
                let origin = Cell { col: 0, row: 0 };
                let before = direction(origin, before.from(origin));
                gain * to_goal.norm() * (1.0 - before.dot(&step))
            }
            (DirectionTerm::PreviousStep, None) | (DirectionTerm::Off, _) => 0.0,
        }
    }
}

impl Rule for Leaning<'_> {
    type Cost = Steps;
    type Priority = f64;

    fn reopens(&self) -> bool {
        true
    }

    fn moves(&self, from: &Visit<Steps>) -> Moves {
        Moves::worthwhile(self.problem.grid, from.index, self.params.corner_rule, from.arrived_by)
    }

    // Inlined, so that what depends on the node alone is worked out once for its neighbours.
    #[inline(always)]
    fn priority(&self, arrival: Arrival<Steps>) -> f64 {
        let to_goal = between(arrival.cell, self.problem.goal).norm();
        let direction_term = arrival.from.map_or(0.0, |from| self.direction_term(&from, arrival.cell));
        // At the goal h is 0 whatever its weight, which is finite there.
        arrival.g.value() + self.weight(to_goal) * to_goal + direction_term
    }
}

/// O: the share of blocked cells among all cells.
fn obstacle_ratio(grid: &PlanningGrid) -> f64 {
    let all = f64::from(grid.cols()) * f64::from(grid.rows());
    (all - grid.passable_count() as f64) / all
}

/// The unit vector from a cell to a neighbour of it.
fn direction(from: Cell, to: Cell) -> Vec2 {
    let is_diagonal = from.col != to.col && from.row != to.row;
    between(from, to) * if is_diagonal { 1.0 / math::SQRT_2 } else { 1.0 }
}

/// From the centre of one cell to that of another, in cells; for any cells, also those outside.
fn between(a: Cell, b: Cell) -> Vec2 {
    Vec2::new(f64::from(b.col) - f64::from(a.col), f64::from(b.row) - f64::from(a.row))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::global::search::Heuristic;
    use crate::plan::global::{GlobalChoice, a_star};
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};

    const ORIGIN: Cell = Cell { col: 0, row: 0 };

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-4
    }

    /// f of `cell`, reached over `way` from the start (0, 0) on a map of 5 × 5 cells with one obstacle.
    fn f(params: &Params, goal: Cell, way: &[Cell], cell: Cell) -> f64 {
        let (_, grid) = drawn(&["....#", ".....", ".....", ".....", "....."]);
        let problem = Problem { grid: &grid, start: ORIGIN, goal };
        let rule = Leaning::new(&problem, params);
        let at = |i: usize| way[i];
        let index = way.len() - 1;
        let arrived_by = (index > 0).then(|| {
            let mut moves = Moves::allowed(&grid, grid.index(at(index - 1)), CornerRule::Forbid);
            moves.find(|step| step.from(at(index - 1)) == at(index)).expect("neighbours")
        });
        let from = Visit { index: 0, cell: at(index), parent: (), arrived_by };
        let g = Steps { straight: way.len() as u32, diagonal: 0 };
        rule.priority(Arrival { cell, g, from: Some(from) })
    }

    #[test]
    fn f_is_what_the_formula_gives_by_hand() {
        // O = 1/25: (1 − exp(−0.04)) / 2 = 0.0196053. Goal (3, 4): d2 = 5. From (0, 0) to (0, 1):
        // d1 = h = √18 = 4.242641, w = exp(0.848528) − 0.0196053 = 2.336203 − 0.019605 = 2.316598;
        // D = 5, cos φ = 4/5, so the term is 0.5 · 4 = 2. f = 1 + 2.316598 · 4.242641 − 2 = 8.828493.
        let (goal, north) = (Cell { col: 3, row: 4 }, Cell { col: 0, row: 1 });
        let params = Params::default();
        assert!(close(f(&params, goal, &[ORIGIN], north), 8.828_493), "{}", f(&params, goal, &[ORIGIN], north));
        let one = Params { weight: Weight::One, ..params.clone() };
        assert!(close(f(&one, goal, &[ORIGIN], north), 1.0 + 4.242_641 - 2.0));
        let plain = Params { direction_term: DirectionTerm::Off, ..one.clone() };
        assert!(close(f(&plain, goal, &[ORIGIN], north), 1.0 + 4.242_641));
        // A right turn at (0, 1), D = √18: 0.5 · 4.242641 · (1 − 0); straight on from there: nothing.
        let turning = Params { direction_term: DirectionTerm::PreviousStep, ..one };
        let (east, on) = (Cell { col: 1, row: 1 }, Cell { col: 0, row: 2 });
        assert!(close(f(&turning, goal, &[ORIGIN, north], east), 2.0 + 13f64.sqrt() + 0.5 * 4.242_641));
        assert!(close(f(&turning, goal, &[ORIGIN, north], on), 2.0 + 13f64.sqrt()));
        assert!(close(f(&turning, goal, &[ORIGIN], north), 1.0 + 4.242_641)); // no step before the first
    }

    #[test]
    fn the_clamp_acts_only_beyond_the_distance_from_start_to_goal() {
        // Goal (1, 0), d2 = 1. From (0, 0) to (0, 1): d1 = √2; w + 0.019605 is exp(√2) = 4.113250, or e.
        let (goal, north) = (Cell { col: 1, row: 0 }, Cell { col: 0, row: 1 });
        let printed = Params { direction_term: DirectionTerm::Off, ..Params::default() };
        let clamped = Params { w_clamp: true, ..printed.clone() };
        assert!(close(f(&printed, goal, &[ORIGIN], north), 1.0 + (4.113_250 - 0.019_605) * math::SQRT_2));
        assert!(close(f(&clamped, goal, &[ORIGIN], north), 1.0 + (core::f64::consts::E - 0.019_605) * math::SQRT_2));
        let east = Cell { col: 1, row: 1 };
        assert_eq!(f(&printed, goal, &[ORIGIN, north], east), f(&clamped, goal, &[ORIGIN, north], east));
    }

    #[test]
    fn the_weight_is_that_of_the_reading_notes_at_both_ends() {
        // 200 of 900 cells blocked: 2.62 at the start, 0.90 at the goal.
        let lines: Vec<String> =
            (0..30).map(|row| if row < 20 { "#".repeat(10) + &".".repeat(20) } else { ".".repeat(30) }).collect();
        let (_, grid) = drawn(&lines.iter().map(String::as_str).collect::<Vec<_>>());
        let problem = Problem { grid: &grid, start: Cell { col: 29, row: 29 }, goal: ORIGIN };
        let params = Params::default();
        let rule = Leaning::new(&problem, &params);
        assert!((rule.weight(rule.start_to_goal) - 2.62).abs() < 0.005, "{}", rule.weight(rule.start_to_goal));
        assert!((rule.weight(0.0) - 0.90).abs() < 0.005);
    }

    #[test]
    fn inflated_cells_count_as_obstacles_and_cells_of_escape_zones_do_not() {
        let (map, mut grid) = drawn(&["#ii.", "...."]);
        assert_eq!(obstacle_ratio(&grid), 3.0 / 8.0);
        grid.open_around(&map, Cell { col: 2, row: 1 });
        assert_eq!(obstacle_ratio(&grid), 2.0 / 8.0);
    }

    #[test]
    fn without_weight_and_direction_it_is_a_star_and_with_them_it_expands_less() {
        let mut stream = stream(41);
        let plain = Params { weight: Weight::One, direction_term: DirectionTerm::Off, ..Params::default() };
        let mut plain = Planner::new(&plain);
        let mut printed = Planner::new(&Params::default());
        let mut reference =
            GlobalChoice::a_star(a_star::Params { heuristic: Heuristic::Euclidean, ..a_star::Params::default() })
                .build();
        let (mut expanded, mut reference_expanded) = (0, 0);
        for _ in 0..2000 {
            let share = stream.range(0.0, 0.4);
            let map = random_map(&mut stream, 30, share);
            let grid = uninflated(&map);
            let problem =
                Problem { grid: &grid, start: random_cell(&mut stream, &map), goal: random_cell(&mut stream, &map) };
            let (mut path, mut reference_path) = (Vec::new(), Vec::new());
            let expected = reference.as_grid().expect("cells").search(&problem, &mut reference_path);
            assert_eq!((&plain.search(&problem, &mut path), &path), (&expected, &reference_path));
            let search = printed.search(&problem, &mut path);
            assert_eq!(search.result, expected.result);
            if search.result.is_ok() {
                expanded += search.expanded;
                reference_expanded += expected.expanded;
            }
        }
        assert!(expanded < reference_expanded, "{expanded} {reference_expanded}");
    }
}
