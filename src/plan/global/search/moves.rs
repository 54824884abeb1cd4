//! Moves to the eight neighbours, and which of them a corner rule allows.

use crate::map::Cell;
use crate::plan::PlanningGrid;
use crate::plan::grid::PASSABLE;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When a diagonal step may pass the two cells beside it (`systems.md` §1.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum CornerRule {
    /// Both must be passable: the path never touches an obstacle's vertex.
    #[default]
    Forbid,
    /// At least one must be passable: the path may touch a vertex but not slip between two obstacles.
    OneFree,
    /// Always: "plain A*" of many papers.
    Allow,
}

/// Columns per move, in the order E, NE, N, NW, W, SW, S, SE.
const D_COL: [i32; 8] = [1, 1, 0, -1, -1, -1, 0, 1];
/// Rows per move, in the same order.
const D_ROW: [i32; 8] = [0, 1, 1, 1, 0, -1, -1, -1];
/// The moves through an edge: E, N, W, S.
const STRAIGHT: u8 = 0b0101_0101;

/// Steps in an array of cells with `stride` cells per row, in the order of the moves.
pub(super) fn offsets(stride: usize) -> [i32; 8] {
    core::array::from_fn(|k| D_COL[k] + D_ROW[k] * stride as i32)
}

/// A move to one of the eight neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) struct Move(u8);

impl Move {
    /// 0 to 7: E, NE, N, NW, W, SW, S, SE.
    pub fn direction(self) -> usize {
        usize::from(self.0)
    }

    /// Whether it leads through a vertex.
    pub fn is_diagonal(self) -> bool {
        self.0 & 1 != 0
    }

    /// The cell that the move leads to.
    pub fn from(self, cell: Cell) -> Cell {
        Cell { col: cell.col + D_COL[self.direction()], row: cell.row + D_ROW[self.direction()] }
    }
}

/// A set of moves, which iterates in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) struct Moves(u8);

impl Moves {
    /// The moves that the corner rule allows from a cell of the map, given by its padded index.
    pub fn allowed(grid: &PlanningGrid, index: u32, rule: CornerRule) -> Self {
        let (stride, west) = (grid.stride(), index as usize - 1);
        let row = |first: usize| -> &[u8] { &grid.cells()[first..first + 3] };
        let (below, here, above) = (row(west - stride), row(west), row(west + stride));
        let bit = |bits: u8, direction: u32| (bits & PASSABLE) << direction;
        let passable = bit(here[2], 0)
            | bit(above[2], 1)
            | bit(above[1], 2)
            | bit(above[0], 3)
            | bit(here[0], 4)
            | bit(below[0], 5)
            | bit(below[1], 6)
            | bit(below[2], 7);
        // A diagonal move's two neighbours are the directions before and after it.
        let (before, after) = (passable.rotate_left(1), passable.rotate_right(1));
        Self(match rule {
            CornerRule::Forbid => passable & (STRAIGHT | before & after),
            CornerRule::OneFree => passable & (STRAIGHT | before | after),
            CornerRule::Allow => passable,
        })
    }
}

impl Iterator for Moves {
    type Item = Move;

    fn next(&mut self) -> Option<Move> {
        if self.0 == 0 {
            return None;
        }
        let first = self.0.trailing_zeros() as u8;
        self.0 &= self.0 - 1;
        Some(Move(first))
    }
}
