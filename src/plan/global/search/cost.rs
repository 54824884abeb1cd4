//! Costs of paths, and estimates of what is left.

use crate::map::Cell;
use crate::math::{SQRT_2, hypot};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a search keeps the cost of a path, in cells.
pub(in super::super) trait Cost: Copy {
    /// The cost of the path that is the start alone.
    const ZERO: Self;

    /// The cost after one more step to a neighbour, which counts `factor` times.
    fn stepped(self, is_diagonal: bool, factor: u32) -> Self;

    /// The cost as a number, in cells.
    fn value(self) -> f64;
}

/// The cost of a path of steps between neighbours, as two counts.
///
/// Its value is computed from the counts, never accumulated, so it does not depend on the order of
/// the steps. Up to 2²³ steps, different counts have different values in the right order:
/// s + d√2 and s' + d'√2 differ by |Δs² − 2Δd²| / |Δs − Δd√2| ≥ 1 / (|Δs| + |Δd|√2), which is
/// above 2⁻²⁵, and rounding moves a value by less than 2⁻²⁸.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in super::super) struct Steps {
    /// Steps through an edge.
    pub straight: u32,
    /// Steps through a vertex, √2 each.
    pub diagonal: u32,
}

impl Steps {
    /// Both counts added.
    pub fn plus(self, other: Self) -> Self {
        Self { straight: self.straight + other.straight, diagonal: self.diagonal + other.diagonal }
    }
}

impl Cost for Steps {
    const ZERO: Self = Self { straight: 0, diagonal: 0 };

    fn stepped(self, is_diagonal: bool, factor: u32) -> Self {
        let diagonal = u32::from(is_diagonal) * factor;
        Self { straight: self.straight + (factor - diagonal), diagonal: self.diagonal + diagonal }
    }

    fn value(self) -> f64 {
        f64::from(self.straight) + f64::from(self.diagonal) * SQRT_2
    }
}

/// A real-valued cost, for planners whose paths leave the grid's directions or whose steps are weighted.
impl Cost for f64 {
    const ZERO: Self = 0.0;

    fn stepped(self, is_diagonal: bool, factor: u32) -> Self {
        self + f64::from(factor) * if is_diagonal { SQRT_2 } else { 1.0 }
    }

    fn value(self) -> f64 {
        self
    }
}

/// Estimate h of the cost from a cell to the goal, in cells (dx, dy: columns and rows between them).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Heuristic {
    /// |dx − dy| + √2 min(dx, dy): exact where nothing is in the way, so the best admissible one of these.
    #[default]
    Octile,
    /// √(dx² + dy²): admissible; the papers' usual choice.
    Euclidean,
    /// dx + dy: up to √2 times too much with diagonal steps, so paths need not be shortest.
    Manhattan,
    /// max(dx, dy): admissible, the weakest.
    Chebyshev,
}

impl Heuristic {
    /// Whether no step lowers g + h, so that a node is expanded at its smallest cost.
    pub(in super::super) fn is_consistent(self) -> bool {
        self != Self::Manhattan
    }

    /// g + h, in cells. Whole steps are added as counts, so that equal sums are equal numbers.
    pub(in super::super) fn added_to(self, g: Steps, cell: Cell, goal: Cell) -> f64 {
        let (dx, dy) = (cell.col.abs_diff(goal.col), cell.row.abs_diff(goal.row));
        let (short, long) = (dx.min(dy), dx.max(dy));
        match self {
            Self::Octile => g.plus(Steps { straight: long - short, diagonal: short }).value(),
            Self::Euclidean => g.value() + hypot(f64::from(dx), f64::from(dy)),
            Self::Manhattan => g.plus(Steps { straight: dx + dy, diagonal: 0 }).value(),
            Self::Chebyshev => g.plus(Steps { straight: long, diagonal: 0 }).value(),
        }
    }
}
