//! Costs of paths, and estimates of the remaining cost.

use crate::map::Cell;
use crate::math::{SQRT_2, hypot};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Representation of the cost of a path, in cells.
pub(in super::super) trait Cost: Copy {
    /// Cost of the path that consists of the start alone.
    const ZERO: Self;

    /// Cost after one more step to a neighbour; the step counts `factor` times.
    fn stepped(self, is_diagonal: bool, factor: u32) -> Self;

    /// The cost as a number, in cells.
    fn value(self) -> f64;

    /// The part of the cost that a node keeps: enough to recognise a cheaper connection.
    type Kept: Copy + Default + core::fmt::Debug;

    /// The part of this cost that a node keeps.
    fn kept(self) -> Self::Kept;

    /// Whether this cost is less than the kept cost of a node.
    fn is_below(self, kept: Self::Kept) -> bool;

    /// The part of its parent that a node keeps.
    type Parent: Copy + Default + core::fmt::Debug;

    /// The kept parent for the node of an index.
    fn parent(index: u32) -> Self::Parent;

    /// Index of the parent of a node, given the index of the neighbour from which the node was reached.
    fn parent_index(parent: Self::Parent, neighbour: u32) -> u32;
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

/// The cost of a path of steps between neighbours as one integer, in ticks of 2⁻³⁶ of a cell: what [`Steps`] are
/// where only their order matters.
///
/// √2 is rounded by less than half a tick, so two costs are off against each other by less than |Δd| / 2 ticks.
/// Different ones are |Δs² − 2Δd²| / |Δs − Δd√2| cells apart, near each other at least 1 / 2√2 |Δd|, so their order is
/// right where the diagonal counts differ by less than 2¹⁷: always where fewer than 2¹⁷ cells are free, and
/// beyond that but for a maze that winds so long. A map has at most 2²⁸ cells: no cost of a path overflows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in super::super) struct CellCost(pub u64);

/// √2 · 2³⁶ = 97 184 015 999.2…
const DIAGONAL_TICKS: u64 = 97_184_015_999;

impl CellCost {
    pub const PER_CELL: u64 = 1 << 36;

    /// Both costs added.
    pub fn plus(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }

    /// The octile distance between two cells.
    pub fn octile(a: Cell, b: Cell) -> Self {
        let (dx, dy) = (u64::from(a.col.abs_diff(b.col)), u64::from(a.row.abs_diff(b.row)));
        let (long, short) = (dx.max(dy), dx.min(dy));
        Self(long.wrapping_mul(Self::PER_CELL).wrapping_add(short.wrapping_mul(DIAGONAL_TICKS - Self::PER_CELL)))
    }
}

impl Cost for CellCost {
    const ZERO: Self = Self(0);

    fn stepped(self, is_diagonal: bool, factor: u32) -> Self {
        let step = if is_diagonal { DIAGONAL_TICKS } else { Self::PER_CELL };
        Self(self.0.wrapping_add(step.wrapping_mul(u64::from(factor))))
    }

    fn value(self) -> f64 {
        self.0 as f64 / Self::PER_CELL as f64
    }

    /// 32 bits, from 2⁻²⁵ to 2⁶ of a cell. It is compared in a circle, so a difference must be below 64 cells.
    ///
    /// Say n is reached by way of p, and q, which is taken out later, leads to it as well. h is consistent and steps go
    /// both ways: p and q are taken out at their distances from the start, two steps by way of n apart at most. So
    /// the two costs of n differ by four steps at most, 57 cells in an escape zone.
    type Kept = u32;

    fn kept(self) -> u32 {
        (self.0 >> 11) as u32
    }

    fn is_below(self, kept: u32) -> bool {
        (self.kept().wrapping_sub(kept) as i32) < 0
    }

    type Parent = ();

    fn parent(_: u32) {}

    fn parent_index((): (), neighbour: u32) -> u32 {
        neighbour
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

    type Kept = Self;

    fn kept(self) -> Self {
        self
    }

    fn is_below(self, kept: Self) -> bool {
        self.value() < kept.value()
    }

    /// Nothing is kept: the parent is always the neighbour.
    type Parent = ();

    fn parent(_: u32) {}

    fn parent_index((): (), neighbour: u32) -> u32 {
        neighbour
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

    type Kept = Self;

    fn kept(self) -> Self {
        self
    }

    fn is_below(self, kept: Self) -> bool {
        self < kept
    }

    /// Index of the parent.
    type Parent = u32;

    fn parent(index: u32) -> u32 {
        index
    }

    fn parent_index(parent: u32, _: u32) -> u32 {
        parent
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
    pub fn is_consistent(self) -> bool {
        self != Self::Manhattan
    }

    /// g + h, in cells. Whole steps are added as counts, so that equal sums are equal numbers.
    pub(in super::super) fn added_to(self, g: Steps, cell: Cell, goal: Cell) -> f64 {
        let (dx, dy) = (cell.col.abs_diff(goal.col), cell.row.abs_diff(goal.row));
        match self {
            Self::Octile => g.plus(octile(cell, goal)).value(),
            Self::Euclidean => g.value() + euclidean(cell, goal),
            Self::Manhattan => g.plus(Steps { straight: dx + dy, diagonal: 0 }).value(),
            Self::Chebyshev => g.plus(Steps { straight: dx.max(dy), diagonal: 0 }).value(),
        }
    }
}

/// The straight distance between the centres of two cells, in cells.
pub(in super::super) fn euclidean(a: Cell, b: Cell) -> f64 {
    hypot(f64::from(a.col.abs_diff(b.col)), f64::from(a.row.abs_diff(b.row)))
}

/// The octile distance between two cells, as steps.
fn octile(a: Cell, b: Cell) -> Steps {
    let (dx, dy) = (a.col.abs_diff(b.col), a.row.abs_diff(b.row));
    Steps { straight: dx.abs_diff(dy), diagonal: dx.min(dy) }
}
