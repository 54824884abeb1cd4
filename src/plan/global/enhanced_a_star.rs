//! `enhanced_a_star`: A* whose estimate weighs the more, the farther the goal still is.
//!
//! Source: Zhu, Tu, Shen, Yin, Zhang, Zhao, Chen, AGV path planning with enhanced A* and enhanced DWA, 2025, eq. 5, 6
//! (`zhu2025`).
//!
//! ```text
//! w(n) = 1 + a r / R          r = |n goal|, R = |start goal|, 0 < a ≤ 1
//! F(n) = G(n) + w(n) H(n)     H = |n goal|
//! ```
//!
//! All distances are Euclidean and in cells. w falls from 1 + a at the start to 1 at the goal.
//!
//! **Length.** w H is not admissible, so paths need not be shortest. They cost at most 1 + a max r/R times as much as a shortest one, the
//! maximum being that over its nodes: closed nodes are opened again, so some node of it is always open at its smallest cost g*, and the
//! goal is taken before that node only with G ≤ g* + w H ≤ (1 + a r/R) (g* + H). The paper's claim that r ≤ R everywhere is false
//! where the way leads round an obstacle, and the factor can be above 1 + a (U-A2).
//!
//! Readings of the paper (ids of `systems.md`):
//! - U-A1: eq. 5 is printed with w = 1 + a r/R, which mostly expands less than A*; the paragraph on admissibility has w = a r/R, which
//!   expands more. `w_form` selects; `printed_eq5` is the default. w = a r/R is admissible where a r/R ≤ 1 and there finds
//!   shortest paths; beyond it, only the factor max(1, a max r/R) holds.
//! - U-A2: `w_clamp` cuts r/R at 1, so that the factor is 1 + a at most and w = a r/R always admissible.
//! - U-A3: a is not given; `a`, 1 by default.
//!
//! Neither form is consistent, so nodes are expanded again when a cheaper connection is found, and each time counts: where the ways wind,
//! the printed form may expand more than A* after all. Ties: larger g, then smaller row-major index. When start and goal are one
//! cell r/R is 0.
//!
//! The paper smooths the path by a B-spline; that is a path stage of its own.
//!
//! Parameters: [`Params`].

use super::GlobalKind;
use super::search::{Arrival, CornerRule, Cost, Heap, Moves, RealEntry, Rule, Steps, Visit, Workspace, euclidean};
use crate::map::Cell;
use crate::math;
use crate::plan::contract::{Entry, GlobalPlanner, GridPlanner, Problem, Search};
use crate::settings::quantity::PositiveFraction;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The weight of the estimate (U-A1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WeightForm {
    /// 1 + a r/R, as printed in eq. 5: fewer expansions than A*, paths not always shortest.
    #[default]
    PrintedEq5,
    /// a r/R, as the paper's proof of admissibility has it: more expansions than A*.
    ProofText,
}

/// Parameters of `enhanced_a_star`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// The weight as a formula. Default `printed_eq5`.
    pub w_form: WeightForm,
    /// Share of r/R in the weight, above 0 and at most 1; larger is greedier. Default 1.
    pub a: PositiveFraction,
    /// Whether r/R is cut at 1. Default false.
    pub w_clamp: bool,
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            w_form: WeightForm::PrintedEq5,
            a: PositiveFraction::new(1.0),
            w_clamp: false,
            corner_rule: CornerRule::Forbid,
        }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "A* whose estimate weighs more far from the goal: fewer expansions, paths longer by a bounded factor.",
    source: "Zhu, Tu, Shen, Yin, Zhang, Zhao, Chen, AGV path planning with enhanced A* and enhanced DWA, 2025, eq. 5, 6",
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
        self.workspace.search(&Weighted::new(problem, &self.params), problem, path)
    }
}

/// The rule for one problem.
struct Weighted<'a> {
    problem: &'a Problem<'a>,
    params: &'a Params,
    /// R, in cells.
    start_to_goal: f64,
}

impl<'a> Weighted<'a> {
    fn new(problem: &'a Problem<'a>, params: &'a Params) -> Self {
        Self { problem, params, start_to_goal: euclidean(problem.start, problem.goal) }
    }

    /// w of a node at `to_goal` cells from the goal.
    fn weight(&self, to_goal: f64) -> f64 {
        let share = if self.start_to_goal > 0.0 { to_goal / self.start_to_goal } else { 0.0 };
        let share = if self.params.w_clamp { math::min(share, 1.0) } else { share };
        let weighted = self.params.a.get() * share;
        match self.params.w_form {
            WeightForm::PrintedEq5 => 1.0 + weighted,
            WeightForm::ProofText => weighted,
        }
    }
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
        let to_goal = euclidean(arrival.cell, self.problem.goal);
        // At the goal h is 0 whatever its weight, which is finite there.
        arrival.g.value() + self.weight(to_goal) * to_goal
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::global::{GlobalChoice, a_star, dijkstra, search};
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};

    fn params(w_form: WeightForm, a: f64, w_clamp: bool) -> Params {
        Params { w_form, a: PositiveFraction::new(a), w_clamp, ..Params::default() }
    }

    const FORMS: [WeightForm; 2] = [WeightForm::PrintedEq5, WeightForm::ProofText];

    #[test]
    fn priorities_are_those_of_the_formula_by_hand() {
        // Start (0, 0), goal (3, 4): R = 5. At (0, 1): r = √(9 + 9) = 4.2426407, r/R = 0.8485281. At (0, 0): r/R = 1.
        let (_, grid) = drawn(&[".....", ".....", ".....", ".....", "....."]);
        let cell = |col, row| Cell { col, row };
        let problem = Problem { grid: &grid, start: cell(0, 0), goal: cell(3, 4) };
        let f = |params: Params, cell, straight| {
            let g = Steps { straight, diagonal: 0 };
            Weighted::new(&problem, &params).priority(Arrival { cell, g, from: None })
        };
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6, "{a} {b}");
        close(f(params(WeightForm::PrintedEq5, 1.0, false), cell(0, 0), 0), 10.0);
        close(f(params(WeightForm::ProofText, 1.0, false), cell(0, 0), 0), 5.0);
        // 1 + 4.2426407 · 1.8485281 = 1 + 7.8426407, for 4.2426407 · 0.8485281 = 18 / 5.
        close(f(params(WeightForm::PrintedEq5, 1.0, false), cell(0, 1), 1), 8.842_640_7);
        close(f(params(WeightForm::ProofText, 1.0, false), cell(0, 1), 1), 1.0 + 3.6);
        close(f(params(WeightForm::PrintedEq5, 0.25, false), cell(0, 1), 1), 1.0 + 4.242_640_7 + 0.9);
        // At (4, 0), reached by four steps: r = √17 < 5. At the goal F = G.
        close(f(params(WeightForm::PrintedEq5, 1.0, false), cell(4, 0), 4), 4.0 + 17f64.sqrt() + 17.0 / 5.0);
        close(f(params(WeightForm::PrintedEq5, 1.0, false), cell(3, 4), 7), 7.0);
        // Farther away than the start, from (1, 4) to (3, 4): R = 2, at (0, 4) r/R = 3/2, or 1.
        let beyond = Problem { start: cell(1, 4), ..problem };
        let f = |params: Params| {
            let g = Steps { straight: 1, diagonal: 0 };
            Weighted::new(&beyond, &params).priority(Arrival { cell: cell(0, 4), g, from: None })
        };
        close(f(params(WeightForm::PrintedEq5, 1.0, false)), 1.0 + 2.5 * 3.0);
        close(f(params(WeightForm::PrintedEq5, 1.0, true)), 1.0 + 2.0 * 3.0);
        close(f(params(WeightForm::ProofText, 1.0, true)), 1.0 + 3.0);
    }

    #[test]
    fn an_open_corridor_is_expanded_cell_by_cell() {
        let (_, grid) = drawn(&["......"]);
        let cell = |col| Cell { col, row: 0 };
        let search = |w_form, start, goal| {
            let problem = Problem { grid: &grid, start: cell(start), goal: cell(goal) };
            Planner::new(&params(w_form, 1.0, false)).search(&problem, &mut Vec::new())
        };
        // From (2) to (5), R = 3. Printed: F falls on the way, and (1) has 1 + (1 + 4/3) 4: the goal is the fourth node taken.
        let printed = search(WeightForm::PrintedEq5, 2, 5);
        assert_eq!((printed.expanded, printed.generated), (3, 5));
        // Proof: F of (1) is 1 + 16/3 = 6.3, of (3) 1 + 4/3, of (4) 2 + 1/3, of the goal 3: the same.
        assert_eq!(search(WeightForm::ProofText, 2, 5), printed);
        // From (1) to (5), R = 4, F of (0) is 1 + 25/4: not before the goal's 4.
        let proof = search(WeightForm::ProofText, 1, 5);
        assert_eq!((proof.expanded, proof.generated), (4, 6));
    }

    #[test]
    fn costs_keep_the_bound_and_the_admissible_form_is_exact() {
        let mut stream = stream(71);
        let (mut longer, mut exact, mut beyond, mut expanded) = (0, 0, 0, [0; 3]);
        for _ in 0..2500 {
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
                let start_to_goal = euclidean(problem.start, problem.goal);
                let farthest = best.iter().map(|&cell| euclidean(cell, problem.goal)).fold(0.0, math::max);
                let ratio = if start_to_goal > 0.0 { farthest / start_to_goal } else { 0.0 };
                beyond += u32::from(ratio > 1.0);
                for (w_form, w_clamp) in FORMS.into_iter().flat_map(|form| [(form, false), (form, true)]) {
                    let a = 0.25 * (1 + stream.index(4)) as f64;
                    let params = Params { corner_rule, ..params(w_form, a, w_clamp) };
                    let found = Planner::new(&params).search(&problem, &mut path);
                    assert_eq!(found.result, result);
                    if result.is_err() {
                        continue;
                    }
                    let weighted = a * if w_clamp { math::min(ratio, 1.0) } else { ratio };
                    let bound = match w_form {
                        WeightForm::PrintedEq5 => 1.0 + weighted,
                        WeightForm::ProofText => math::max(1.0, weighted),
                    };
                    assert!(cost(&path) <= bound * optimum + 1e-9, "{} {bound} {optimum}", cost(&path));
                    assert!(cost(&path) >= optimum - 1e-9);
                    longer += u32::from(cost(&path) > optimum + 1e-9);
                    exact += u32::from(w_form == WeightForm::ProofText && weighted <= 1.0);
                    if !w_clamp {
                        expanded[w_form as usize] += found.expanded;
                    }
                }
                expanded[2] += if result.is_ok() { of_a_star } else { 0 };
            }
        }
        assert!(longer > 100 && exact > 2000 && beyond > 100, "{longer} {exact} {beyond}");
        let [printed, proof, of_a_star] = expanded;
        assert!(printed < of_a_star && of_a_star < proof, "U-A1: {printed} {of_a_star} {proof}");
    }

    #[test]
    fn a_must_be_above_0_and_at_most_1() {
        for (a, is_allowed) in [(1.0, true), (0.25, true), (0.0, false), (1.01, false)] {
            assert_eq!(PositiveFraction::try_from(a).is_ok(), is_allowed, "{a}");
        }
    }
}
