//! `blend_a_star`: A* whose estimate blends the Manhattan and the Euclidean distance and counts twice.
//!
//! Source: Hu, Wang, Zhang, Research on Dynamic Obstacle Avoidance Method of Mobile Robot based on Improved A* Algorithm and Dynamic
//! Window Method, Engineering Letters 32(3), 2024, eq. 2 to 5 (`hu2024`).
//!
//! ```text
//! f(n) = g(n) + w (√2 p h_e + (1 − p) h_m)
//! h_e = |n goal|, h_m = |Δcol| + |Δrow| to the goal,   p = h_m(n) / h_m(start), at most 1
//! ```
//!
//! All distances are in cells.
//!
//! **Length.** The estimate h, without w, lies between h_m and √2 h_e, and h_m ≤ √2 h_e. Both are at least the cost of the way
//! without obstacles and at most √2 times as much, so the estimate is not admissible for w ≥ 1, not even for w = 1, and paths
//! need not be shortest. Closed nodes are opened again, so some node of a shortest path is always open at its smallest cost, and the
//! goal is taken before that node only with g ≤ g* + w h ≤ max(1, √2 w) times the shortest cost: at most 2.83 times
//! with w = 2, and exactly the shortest with w ≤ 1/√2. In the printed form √2 w is multiplied by the largest p along a
//! shortest path where that is above 1.
//!
//! Readings of the paper (ids of `systems.md`):
//! - H-A1: eq. 3 lacks the square root; h_e is used as a distance elsewhere.
//! - H-A2: eq. 5 is printed with the distance from the *start*: p then rises from 0 to 1 on the way and above 1 on detours. The text
//!   has p as the share of the distance that remains and wants Euclid's distance far from the goal. `p_form` selects;
//!   `remaining`, cut at 1, is the default. `printed` is not cut.
//! - H-A4: "the parameter value" 2 is w.
//!
//! The estimate is not consistent: nodes are expanded again when a cheaper connection is found, and each time counts. Ties: larger
//! g, then smaller row-major index.
//!
//! The paper's pruning and smoothing are path stages of their own: [`farthest_visible`](crate::plan::path::farthest_visible) and
//! [`minimum_snap`](crate::plan::path::minimum_snap).
//!
//! Parameters: [`Params`].

use super::GlobalKind;
use super::search::{Arrival, CornerRule, Cost, Heap, Moves, RealEntry, Rule, Steps, Visit, Workspace, euclidean};
use crate::map::Cell;
use crate::math;
use crate::plan::contract::{Entry, GlobalPlanner, GridPlanner, Problem, Search};
use crate::settings::quantity::Positive;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The share p of Euclid's distance in the blend (H-A2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ShareForm {
    /// Manhattan distance from the node to the goal by that from the start to the goal, at most 1.
    #[default]
    Remaining,
    /// Manhattan distance from the start to the node by that from the start to the goal, as printed in eq. 5.
    Printed,
}

/// Parameters of `blend_a_star`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// w, weight of the estimate; larger expands fewer nodes and bounds the length less. Default 2.
    pub w: Positive,
    /// The share p as a formula. Default `remaining`.
    pub p_form: ShareForm,
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

impl Default for Params {
    fn default() -> Self {
        Self { w: Positive::new(2.0), p_form: ShareForm::Remaining, corner_rule: CornerRule::Forbid }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "A* whose estimate blends Manhattan and Euclid and counts twice: few expansions, paths longer by a bounded factor.",
    source: "Hu, Wang, Zhang, Research on Dynamic Obstacle Avoidance Method of Mobile Robot based on Improved A* Algorithm and Dynamic Window Method, Engineering Letters 32(3), 2024, eq. 2 to 5",
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
        self.workspace.search(&Blended::new(problem, &self.params), problem, path)
    }
}

/// |Δcol| + |Δrow|, in cells.
fn manhattan(a: Cell, b: Cell) -> f64 {
    (f64::from(a.col) - f64::from(b.col)).abs() + (f64::from(a.row) - f64::from(b.row)).abs()
}

/// The rule for one problem.
struct Blended<'a> {
    problem: &'a Problem<'a>,
    params: &'a Params,
    /// h_m of the start.
    start_to_goal: f64,
}

impl<'a> Blended<'a> {
    fn new(problem: &'a Problem<'a>, params: &'a Params) -> Self {
        Self { problem, params, start_to_goal: manhattan(problem.start, problem.goal) }
    }

    /// p of a cell; 0 where start and goal are one cell.
    fn share(&self, cell: Cell) -> f64 {
        if self.start_to_goal == 0.0 {
            return 0.0;
        }
        match self.params.p_form {
            ShareForm::Remaining => math::min(manhattan(cell, self.problem.goal) / self.start_to_goal, 1.0),
            ShareForm::Printed => manhattan(cell, self.problem.start) / self.start_to_goal,
        }
    }
}

impl Rule for Blended<'_> {
    type Cost = Steps;
    type Priority = f64;

    fn reopens(&self) -> bool {
        true
    }

    fn moves(&self, from: &Visit<Steps>) -> Moves {
        Moves::worthwhile(self.problem.grid, from.index, self.params.corner_rule, from.arrived_by)
    }

    fn priority(&self, arrival: Arrival<Steps>) -> f64 {
        let (p, goal) = (self.share(arrival.cell), self.problem.goal);
        let estimate = math::SQRT_2 * p * euclidean(arrival.cell, goal) + (1.0 - p) * manhattan(arrival.cell, goal);
        arrival.g.value() + self.params.w.get() * estimate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::global::{GlobalChoice, a_star, dijkstra, search};
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};

    fn params(p_form: ShareForm, w: f64) -> Params {
        Params { p_form, w: Positive::new(w), ..Params::default() }
    }

    const FORMS: [ShareForm; 2] = [ShareForm::Remaining, ShareForm::Printed];

    #[test]
    fn priorities_are_those_of_the_formula_by_hand() {
        let (_, grid) = drawn(&[".....", ".....", ".....", ".....", "....."]);
        let cell = |col, row| Cell { col, row };
        let problem = Problem { grid: &grid, start: cell(0, 0), goal: cell(3, 4) };
        let f = |problem: &Problem<'_>, p_form, w, cell, straight| {
            let g = Steps { straight, diagonal: 0 };
            Blended::new(problem, &params(p_form, w)).priority(Arrival { cell, g, from: None })
        };
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} {b}");
        // h_m of the start is 7, its h_e 5: p is 1 or 0.
        close(f(&problem, ShareForm::Remaining, 2.0, cell(0, 0), 0), 14.142_135_6);
        close(f(&problem, ShareForm::Printed, 2.0, cell(0, 0), 0), 14.0);
        // On a diagonal to the goal h_m = √2 h_e = 6, whatever p.
        close(f(&problem, ShareForm::Remaining, 2.0, cell(0, 1), 1), 13.0);
        close(f(&problem, ShareForm::Printed, 2.0, cell(0, 1), 1), 13.0);
        // At (3, 1) h_m = h_e = 3; p = 3/7: √2 9/7 + 12/7 = 3.5325603, and printed p = 4/7: √2 12/7 + 9/7 = 3.7100804.
        close(f(&problem, ShareForm::Remaining, 2.0, cell(3, 1), 4), 11.065_120_6);
        close(f(&problem, ShareForm::Remaining, 1.0, cell(3, 1), 4), 7.532_560_3);
        close(f(&problem, ShareForm::Printed, 2.0, cell(3, 1), 4), 11.420_160_7);
        close(f(&problem, ShareForm::Remaining, 2.0, cell(3, 4), 7), 7.0);
        close(f(&problem, ShareForm::Printed, 2.0, cell(3, 4), 7), 7.0);
        // Farther away than the start: from (1, 4) to (3, 4), h_m of the start is 2. At (0, 4) h_m = h_e = 3, p = 3/2 cut at 1, printed 1/2.
        let beyond = Problem { start: cell(1, 4), ..problem };
        close(f(&beyond, ShareForm::Remaining, 2.0, cell(0, 4), 1), 1.0 + 6.0 * 2f64.sqrt());
        close(f(&beyond, ShareForm::Printed, 2.0, cell(0, 4), 1), 1.0 + 3.0 * 2f64.sqrt() + 3.0);
        // At (4, 1) printed p = 6/2: h_m = 4, √2 h_e = √20: 3 √20 − 2 · 4.
        close(f(&beyond, ShareForm::Printed, 2.0, cell(4, 1), 6), 6.0 + 2.0 * (3.0 * 20f64.sqrt() - 8.0));
    }

    #[test]
    fn an_open_corridor_is_expanded_cell_by_cell() {
        let (_, grid) = drawn(&["......"]);
        let cell = |col| Cell { col, row: 0 };
        for p_form in FORMS {
            // From (2) to (5) f falls from 8.5 or 6 to 3; (1) has 1 + 8 at least.
            let problem = Problem { grid: &grid, start: cell(2), goal: cell(5) };
            let mut path = Vec::new();
            let found = Planner::new(&params(p_form, 2.0)).search(&problem, &mut path);
            assert_eq!((found.result, found.expanded, found.generated), (Ok(()), 3, 5));
            assert_eq!(path, [cell(2), cell(3), cell(4), cell(5)]);
            let problem = Problem { goal: cell(2), ..problem };
            assert_eq!(Planner::new(&params(p_form, 2.0)).search(&problem, &mut path).expanded, 0);
            assert_eq!(path, [cell(2)]);
        }
    }

    #[test]
    fn costs_keep_the_bound_and_small_weights_are_exact() {
        let mut stream = stream(171);
        let (mut longer, mut exact, mut beyond, mut expanded) = (0, 0, 0, [0; 3]);
        for _ in 0..2000 {
            let share = stream.range(0.0, 0.45);
            let map = random_map(&mut stream, 30, share);
            let grid = uninflated(&map);
            let problem =
                Problem { grid: &grid, start: random_cell(&mut stream, &map), goal: random_cell(&mut stream, &map) };
            for corner_rule in [CornerRule::Forbid, CornerRule::Allow] {
                let mut shortest = GlobalChoice::dijkstra(dijkstra::Params { corner_rule }).build();
                let mut reference =
                    GlobalChoice::a_star(a_star::Params { heuristic: search::Heuristic::Euclidean, corner_rule })
                        .build();
                let (mut best, mut path) = (Vec::new(), Vec::new());
                let result = shortest.as_grid().expect("cells").search(&problem, &mut best).result;
                let of_a_star = reference.as_grid().expect("cells").search(&problem, &mut path).expanded;
                let cost = |path: &[Cell]| path.windows(2).map(|pair| euclidean(pair[0], pair[1])).sum::<f64>();
                let optimum = cost(&best);
                let apart = manhattan(problem.start, problem.goal);
                let from_start = best.iter().map(|&cell| manhattan(cell, problem.start)).fold(0.0, math::max);
                let printed_p = if apart > 0.0 { math::max(from_start / apart, 1.0) } else { 1.0 };
                beyond += u32::from(printed_p > 1.0);
                for (p_form, w) in FORMS.into_iter().flat_map(|form| [(form, 0.5), (form, 1.0), (form, 2.0)]) {
                    let params = Params { corner_rule, ..params(p_form, w) };
                    let found = Planner::new(&params).search(&problem, &mut path);
                    assert_eq!(found.result, result);
                    if result.is_err() {
                        continue;
                    }
                    let p = if p_form == ShareForm::Printed { printed_p } else { 1.0 };
                    let bound = math::max(1.0, math::SQRT_2 * w * p);
                    assert!(cost(&path) <= bound * optimum + 1e-9, "{} {bound} {optimum}", cost(&path));
                    assert!(cost(&path) >= optimum - 1e-9);
                    longer += u32::from(cost(&path) > optimum + 1e-9);
                    exact += u32::from(bound == 1.0);
                    if w == 2.0 {
                        expanded[p_form as usize] += found.expanded;
                    }
                }
                expanded[2] += if result.is_ok() { of_a_star } else { 0 };
            }
        }
        assert!(longer > 100 && exact > 2000 && beyond > 50, "{longer} {exact} {beyond}");
        let [remaining, printed, of_a_star] = expanded;
        assert!(remaining < of_a_star && printed < of_a_star, "{remaining} {printed} {of_a_star}");
    }
}
