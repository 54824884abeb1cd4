//! The fuzzy controller: from the distances to the nearest obstacle and to the target to the four weights.
//!
//! Source: Zhu et al., "Path planning optimization of automated guided vehicles based on enhanced A* and dynamic window approach
//! fusion algorithms" (`zhu2025`), Table 1. The paper shows the sets of the outputs in pictures alone and those of the inputs
//! not at all; [`Params`](super::Params) has them (U-A10).

use super::inference::{Peaks, SETS, Set, Shape, centroid};
use crate::math;

/// Weights of the objective: heading, distance, velocity, pull.
pub const OUTPUTS: usize = 4;

/// The rule base: for each set of the distance to the nearest obstacle (N1 very near, to N4 far) and, within it, each set of the
/// distance to the target (N1 to N4) the sets of α, β, γ and λ, 1 very small to 4 large.
///
/// The table lists 15 rules, in this order but for rules 3 and 4, which are (N1, N4) and (N1, N3). β of (N2, N3) is printed as
/// "M": M3, as between the rows beside it (U-A12). (N4, N4) is missing: α and β as in the rows before, γ as in every other row
/// of a far target, λ on from 1, 1, 2 (U-A13).
pub const RULES: [[[usize; OUTPUTS]; SETS]; SETS] = [
    [[1, 2, 3, 2], [1, 3, 3, 2], [1, 4, 3, 2], [1, 4, 4, 2]],
    [[3, 1, 3, 3], [3, 2, 3, 3], [2, 3, 3, 3], [2, 4, 4, 3]],
    [[3, 1, 3, 1], [3, 1, 3, 2], [3, 1, 3, 3], [3, 1, 4, 4]],
    [[4, 1, 2, 1], [4, 1, 2, 1], [4, 1, 3, 2], [4, 1, 4, 3]],
];

/// The controller.
#[derive(Clone, Debug)]
pub struct Controller {
    obstacle_range_m: f64,
    goal_range_m: f64,
    inputs: [Set; SETS],
    outputs: [Set; SETS],
}

impl Controller {
    /// The controller whose inputs run from 0 to these ranges, m, in sets with the peaks `inputs`, and whose outputs have the
    /// peaks `outputs`.
    pub fn new(obstacle_range_m: f64, goal_range_m: f64, inputs: Peaks, outputs: Peaks, shape: Shape) -> Self {
        let (inputs, outputs) = (Set::family(inputs, shape), Set::family(outputs, shape));
        Self { obstacle_range_m, goal_range_m, inputs, outputs }
    }

    /// α, β, γ and λ, each from 0 to 1, at these distances, m; beyond its range a distance counts as the range.
    pub fn weights(&self, obstacle_m: f64, goal_m: f64) -> [f64; OUTPUTS] {
        let near_obstacle = self.inputs.map(|set| set.membership(obstacle_m / self.obstacle_range_m));
        let near_goal = self.inputs.map(|set| set.membership(goal_m / self.goal_range_m));
        let mut levels = [[0.0; SETS]; OUTPUTS];
        for (rules, obstacle) in RULES.iter().zip(near_obstacle) {
            for (rule, goal) in rules.iter().zip(near_goal) {
                let degree = math::min(obstacle, goal);
                for (levels, &set) in levels.iter_mut().zip(rule) {
                    levels[set - 1] = math::max(levels[set - 1], degree);
                }
            }
        }
        levels.map(|levels| centroid(&self.outputs, &levels))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn controller() -> Controller {
        Controller::new(3.0, 10.0, Peaks::EVEN, Peaks::EVEN, Shape::Triangle)
    }

    #[track_caller]
    fn assert_close(found: [f64; OUTPUTS], expected: [f64; OUTPUTS]) {
        let worst = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, math::max);
        assert!(worst < 1e-12, "{found:?} {expected:?}");
    }

    #[test]
    fn where_one_rule_holds_alone_its_sets_give_the_weights() {
        // Centroids of the four sets.
        let m = [1.0 / 9.0, 1.0 / 3.0, 2.0 / 3.0, 8.0 / 9.0];
        let of = |a: usize, b: usize, c: usize, d: usize| [m[a - 1], m[b - 1], m[c - 1], m[d - 1]];
        let fuzzy = controller();
        // Table 1 by its own numbers: the inputs at the peaks of their sets.
        let table = [
            (1, 1, of(1, 2, 3, 2)),
            (1, 2, of(1, 3, 3, 2)),
            (1, 4, of(1, 4, 4, 2)),
            (1, 3, of(1, 4, 3, 2)),
            (2, 1, of(3, 1, 3, 3)),
            (2, 2, of(3, 2, 3, 3)),
            (2, 3, of(2, 3, 3, 3)),
            (2, 4, of(2, 4, 4, 3)),
            (3, 1, of(3, 1, 3, 1)),
            (3, 2, of(3, 1, 3, 2)),
            (3, 3, of(3, 1, 3, 3)),
            (3, 4, of(3, 1, 4, 4)),
            (4, 1, of(4, 1, 2, 1)),
            (4, 2, of(4, 1, 2, 1)),
            (4, 3, of(4, 1, 3, 2)),
            (4, 4, of(4, 1, 4, 3)),
        ];
        for (obstacle, goal, expected) in table {
            let peak = |set: i32| f64::from(set - 1) / 3.0;
            let found = fuzzy.weights(3.0 * peak(obstacle), 10.0 * peak(goal));
            let worst = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, math::max);
            assert!(worst < 1e-9, "({obstacle}, {goal}): {found:?} {expected:?}");
        }
    }

    #[test]
    fn the_weights_are_those_of_scikit_fuzzy() {
        // Written by tests/oracles/zhu2025_fuzzy.py, which samples the outputs at 20,001 points.
        let table = include_str!("../../../../tests/data/fuzzy.csv");
        let mut lines = table.lines();
        assert_eq!(lines.next(), Some("obstacle_m,goal_m,alpha,beta,gamma,lambda"));
        let (fuzzy, mut count, mut worst) = (controller(), 0, 0.0);
        for line in lines {
            let numbers: Vec<f64> = line.split(',').map(|number| number.parse().expect("a number")).collect();
            let found = fuzzy.weights(numbers[0], numbers[1]);
            worst = found.iter().zip(&numbers[2..]).map(|(a, b)| (a - b).abs()).fold(worst, math::max);
            count += 1;
        }
        assert!(count == 442 && worst < 1e-7, "{count} {worst}");
    }

    #[test]
    fn beyond_their_ranges_distances_count_as_the_range() {
        let fuzzy = controller();
        assert_close(fuzzy.weights(30.0, 1e6), fuzzy.weights(3.0, 10.0));
        assert_close(fuzzy.weights(-0.1, 0.0), fuzzy.weights(0.0, 0.0));
    }

    #[test]
    fn two_rules_at_half_each_are_worked_by_hand() {
        // 0.5 m to an obstacle and at the target: rules 1 and 5 hold to 1/2 each.
        let [alpha, beta, gamma, lambda] = controller().weights(0.5, 0.0);
        // γ is M3 by both, cut at 1/2: symmetric about 2/3.
        assert!((gamma - 2.0 / 3.0).abs() < 1e-12);
        // β: M1 and M2 cut at 1/2: level at 1/2 from 0 to 1/2, then down to 0 at 2/3.
        // Area 1/4 + 1/24, moment 1/16 + (1/2 + 1/18) / 24.
        let expected = (1.0 / 16.0 + (5.0 / 9.0) / 24.0) / (7.0 / 24.0);
        assert!((beta - expected).abs() < 1e-12, "{beta} {expected}");
        // λ: M2 and M3 at 1/2: symmetric about the middle.
        assert!((lambda - 0.5).abs() < 1e-12);
        // α: M1 and M3 at 1/2. M1: area 1/8, moment 7/432. M3 from 1/3 to 1: up to 1/2 at 1/2, level to 5/6, down to 0 at 1: area 1/4 about
        // 2/3.
        let expected = (7.0 / 432.0 + 1.0 / 6.0) / (3.0 / 8.0);
        assert!((alpha - expected).abs() < 1e-12, "{alpha} {expected}");
    }
}
