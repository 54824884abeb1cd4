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

const N: u8 = 1 << 2;
const NW: u8 = 1 << 3;
const W: u8 = 1 << 4;
const SW: u8 = 1 << 5;
const S: u8 = 1 << 6;

/// Steps in an array of cells with `stride` cells per row, in the order of the moves.
pub(super) fn offsets(stride: usize) -> [i32; 8] {
    core::array::from_fn(|k| D_COL[k] + D_ROW[k] * stride as i32)
}

/// A move to one of the eight neighbours, counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in super::super) enum Move {
    E,
    NE,
    N,
    NW,
    W,
    SW,
    S,
    SE,
}

impl Move {
    /// All moves, in their order.
    pub const ALL: [Self; 8] = [Self::E, Self::NE, Self::N, Self::NW, Self::W, Self::SW, Self::S, Self::SE];

    /// 0 to 7: E, NE, N, NW, W, SW, S, SE.
    pub const fn direction(self) -> usize {
        self as usize
    }

    /// The move of a direction; none beyond 7.
    pub const fn of_direction(direction: u32) -> Option<Self> {
        // Not by way of `ALL`: this costs nothing.
        Some(match direction {
            0 => Self::E,
            1 => Self::NE,
            2 => Self::N,
            3 => Self::NW,
            4 => Self::W,
            5 => Self::SW,
            6 => Self::S,
            7 => Self::SE,
            _ => return None,
        })
    }

    /// The move from one cell that lessens every coordinate difference to another; `None` if the cells are equal.
    pub fn towards(from: Cell, to: Cell) -> Option<Self> {
        let signs = ((to.col - from.col).signum(), (to.row - from.row).signum());
        Self::ALL.into_iter().find(|step| (D_COL[step.direction()], D_ROW[step.direction()]) == signs)
    }

    /// Whether the move is diagonal: it leads through a vertex.
    pub const fn is_diagonal(self) -> bool {
        self as u8 & 1 != 0
    }

    /// The two moves through an edge that a diagonal one consists of.
    pub fn parts(self) -> [Self; 2] {
        debug_assert!(self.is_diagonal());
        [Self::ALL[self.direction() - 1], Self::ALL[(self.direction() + 1) % 8]]
    }

    /// The cell that the move leads to.
    pub fn from(self, cell: Cell) -> Cell {
        Cell { col: cell.col + D_COL[self.direction()], row: cell.row + D_ROW[self.direction()] }
    }

    /// The padded index of the cell that the move leads to from the cell of a padded index.
    pub fn index_from(self, grid: &PlanningGrid, index: u32) -> u32 {
        index.wrapping_add_signed(D_COL[self.direction()] + D_ROW[self.direction()] * grid.stride() as i32)
    }

    /// The move back.
    pub fn reversed(self) -> Self {
        Self::ALL[(self.direction() + 4) % 8]
    }

    /// The padded index of the cell that the move leads from to the cell of a padded index.
    pub fn index_before(self, grid: &PlanningGrid, index: u32) -> u32 {
        self.reversed().index_from(grid, index)
    }
}

/// A set of moves, which iterates in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) struct Moves(u8);

impl Moves {
    /// No move.
    pub const NONE: Self = Self(0);

    /// Whether a move is one of them.
    pub fn contains(self, step: Move) -> bool {
        self.0 >> step.direction() & 1 != 0
    }

    /// The moves that the corner rule allows from a cell of the map, given by its padded index.
    pub fn allowed(grid: &PlanningGrid, index: u32, rule: CornerRule) -> Self {
        Self(rule.allows(grid.around()[index as usize]))
    }

    /// The same for any cell of the map or its border; none from one that is blocked.
    pub fn allowed_if_passable(grid: &PlanningGrid, index: u32, rule: CornerRule) -> Self {
        if grid.cells()[index as usize] & PASSABLE != 0 { Self::allowed(grid, index, rule) } else { Self::NONE }
    }

    /// The moves of [`Self::allowed`] without those that cannot help a node reached by `arrived_by`, for searches whose g
    /// is the plain length of a path: the node before leads to their cells at no larger cost, and
    /// has done so already. What is expanded, when and at which g stays the same to the last node.
    ///
    /// Say the node x was reached by E from p. Its W is p; its NW and SW are a straight step from
    /// p; its N and S are a diagonal step from p (√2, by way of x 2), unless the corner rule forbids
    /// that step. Say it was reached by NE: its SW is p, its W and S are a straight step from p. With
    /// escape zones a detour may be cheaper, so there nothing is left out.
    pub fn worthwhile(grid: &PlanningGrid, index: u32, rule: CornerRule, arrived_by: Option<Move>) -> Self {
        MoveTable::worthwhile(grid, rule).after(arrived_by, grid, index)
    }

    /// The natural and forced neighbours of jump point search: of [`Self::worthwhile`] also without moves to cells
    /// that another way from the node before reaches at less cost, or at the same cost with a straight last step.
    ///
    /// Every node is still reached at its smallest cost, whichever of several best connections it holds. Look at
    /// the last step of a best path to n, from x. If it is straight it is never left out, for that takes a
    /// cheaper way to n. If it is diagonal and left out, there is a best path to n whose last step is straight.
    /// (By induction over the cost: x has got its own already.) The step is E to x from p, then NE to n: the
    /// other way is p, x's N, n, unless the corner rule forbids the diagonal step from p.
    pub fn natural_and_forced(grid: &PlanningGrid, index: u32, rule: CornerRule, arrived_by: Option<Move>) -> Self {
        MoveTable::natural_and_forced(grid, rule).after(arrived_by, grid, index)
    }
}

/// Row of a [`MoveTable`] for nodes to which no move led.
const NO_MOVE: usize = 8;

/// Sets of moves by the move that led to a node (or [`NO_MOVE`]) and its passable neighbours. A look into the
/// table takes the place of a dozen operations and of a branch that nothing predicts.
#[derive(Debug)]
pub(in super::super) struct MoveTable([[u8; 256]; 9]);

impl MoveTable {
    /// The table of [`Moves::worthwhile`].
    pub fn worthwhile(grid: &PlanningGrid, rule: CornerRule) -> &'static Self {
        static TABLES: [MoveTable; 3] = MoveTable::of_rules(true, false);
        if grid.has_escape_zone() { Self::allowed(rule) } else { &TABLES[rule as usize] }
    }

    /// The table of [`Moves::natural_and_forced`].
    pub fn natural_and_forced(grid: &PlanningGrid, rule: CornerRule) -> &'static Self {
        static TABLES: [MoveTable; 3] = MoveTable::of_rules(true, true);
        if grid.has_escape_zone() { Self::allowed(rule) } else { &TABLES[rule as usize] }
    }

    /// All moves that the corner rule allows.
    fn allowed(rule: CornerRule) -> &'static Self {
        static TABLES: [MoveTable; 3] = MoveTable::of_rules(false, false);
        &TABLES[rule as usize]
    }

    /// The moves from a node that was reached by `arrived_by`.
    pub fn after(&self, arrived_by: Option<Move>, grid: &PlanningGrid, index: u32) -> Moves {
        let passable = grid.around()[index as usize];
        Moves(self.0[arrived_by.map_or(NO_MOVE, Move::direction)][usize::from(passable)])
    }

    const fn of_rules(without_detours: bool, without_symmetric: bool) -> [Self; 3] {
        [
            Self::of_rule(CornerRule::Forbid, without_detours, without_symmetric),
            Self::of_rule(CornerRule::OneFree, without_detours, without_symmetric),
            Self::of_rule(CornerRule::Allow, without_detours, without_symmetric),
        ]
    }

    const fn of_rule(rule: CornerRule, without_detours: bool, without_symmetric: bool) -> Self {
        let mut table = [[0; 256]; 9];
        let mut at = 0;
        while at < 9 * 256 {
            let (arrived_by, passable) = (at / 256, (at % 256) as u8);
            let mut moves = rule.allows(passable);
            if arrived_by < NO_MOVE {
                let arrived_by = Move::ALL[arrived_by];
                // Written for E and NE, turned to the move's own direction.
                let turn = (arrived_by as u8 & !1) as u32;
                let seen = passable.rotate_right(turn);
                if without_detours {
                    moves &= !rule.detours(seen, arrived_by).rotate_left(turn);
                }
                if without_symmetric {
                    moves &= !rule.symmetric(seen, arrived_by).rotate_left(turn);
                }
            }
            table[at / 256][passable as usize] = moves;
            at += 1;
        }
        Self(table)
    }
}

impl CornerRule {
    /// The moves that the rule allows, given the passable neighbours as bits.
    const fn allows(self, passable: u8) -> u8 {
        // A diagonal move's two neighbours are the directions before and after it.
        let (before, after) = (passable.rotate_left(1), passable.rotate_right(1));
        match self {
            Self::Forbid => passable & (STRAIGHT | before & after),
            Self::OneFree => passable & (STRAIGHT | before | after),
            Self::Allow => passable,
        }
    }

    /// Moves from a node reached by E (or by NE, where `arrived_by` is diagonal) to cells that the node
    /// before has led to, given which neighbours are passable.
    const fn detours(self, passable: u8, arrived_by: Move) -> u8 {
        if arrived_by.is_diagonal() {
            return W | SW | S;
        }
        // N and S: the diagonal step there had NW or SW beside it, and the node itself.
        let by_diagonal = match self {
            Self::Forbid => (passable & NW) >> 1 | (passable & SW) << 1,
            Self::OneFree | Self::Allow => S | S >> 4,
        };
        NW | W | SW | by_diagonal
    }

    /// Moves from a node reached by E (or by NE, where `arrived_by` is diagonal) to cells that two other steps from
    /// the node before lead to as well, the second of them straight, at no larger cost.
    const fn symmetric(self, passable: u8, arrived_by: Move) -> u8 {
        if arrived_by.is_diagonal() {
            // NW by way of W and SE by way of S, two straight steps each.
            return (passable & W) >> 1 | (passable & S) << 1;
        }
        // NE by way of N and SE by way of S, a diagonal step first, which passes NW or SW and the node itself.
        match self {
            Self::Forbid => (passable & NW) >> 2 | (passable & SW) << 2,
            Self::OneFree | Self::Allow => (passable & N) >> 1 | (passable & S) << 1,
        }
    }
}

impl Iterator for Moves {
    type Item = Move;

    fn next(&mut self) -> Option<Move> {
        if self.0 == 0 {
            return None;
        }
        let first = self.0.trailing_zeros();
        self.0 &= self.0 - 1;
        Move::of_direction(first)
    }
}
