//! Path stages: they prune or smooth the path of a global planner. One file per stage.

use super::PlanningGrid;
use super::contract::{Entry, Fit, PathStage};
use crate::geometry::{Path, Piece, Vec2};
use crate::math;
use crate::settings::registry;
use core::ops::Range;

/// Behaviour of the parameters of a path stage.
pub trait PathKind {
    /// A fresh stage.
    fn build(&self) -> Box<dyn PathStage>;

    /// Whether the parameters fit this map and robot.
    ///
    /// # Errors
    /// A message that says what does not fit.
    fn check(&self, _: &Fit<'_>) -> Result<(), String> {
        Ok(())
    }
}

registry! {
    /// A path stage with its parameters.
    pub enum PathChoice: "path stage", Entry, dyn PathKind {
        line_of_sight,
        clearance_prune,
        arc_fillet,
        b_spline,
        grandparent_prune,
    }
}

impl PathChoice {
    /// A fresh stage.
    pub fn build(&self) -> Box<dyn PathStage> {
        self.kind().build()
    }
}

/// What the pieces of a path keep from obstacle squares, for stages that replace some of them by a straight line.
#[derive(Clone, Copy, Debug)]
struct Room<'a> {
    grid: &'a PlanningGrid,
    /// For each piece, m, at most the inflation; empty without inflation.
    room_m: &'a [f64],
}

impl<'a> Room<'a> {
    /// That of `path`, into a buffer that is used again. Arcs and curves count as having the whole inflation.
    fn of(grid: &'a PlanningGrid, path: &Path, room_m: &'a mut Vec<f64>) -> Self {
        room_m.clear();
        if let Some(obstacles) = grid.obstacles() {
            room_m.extend(path.segments().map(|(from, piece)| match piece {
                Piece::Line { to } => obstacles.segment_clearance(from, *to, grid.inflation_m()),
                Piece::Arc { .. } | Piece::Curve(_) => grid.inflation_m(),
            }));
        }
        Self { grid, room_m }
    }

    /// The least of the pieces `pieces`, m.
    fn least(&self, pieces: Range<usize>) -> f64 {
        let rooms = self.room_m.get(pieces).unwrap_or_default();
        rooms.iter().fold(self.grid.inflation_m(), |least, &room_m| math::min(least, room_m))
    }

    /// Whether the line a–b may stand in place of these pieces: it keeps the inflation from obstacles, or as much as they do, and
    /// `clearance_m` from blocked squares.
    fn may_replace(&self, pieces: Range<usize>, a: Vec2, b: Vec2, clearance_m: f64) -> bool {
        let inflation_m = self.grid.inflation_m();
        self.grid.may_replace(a, b, inflation_m, clearance_m) || {
            let least_m = self.least(pieces);
            least_m < inflation_m && self.grid.may_replace(a, b, least_m, clearance_m)
        }
    }
}
