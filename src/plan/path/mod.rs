//! Path stages: they prune or smooth the path of a global planner. One file per stage.

use super::PlanningGrid;
use super::clearance::Obstacles;
use super::contract::{Entry, Fit, PathStage};
use crate::geometry::curve::Curve;
use crate::geometry::{Path, Piece, Vec2};
use crate::math;
use crate::settings::quantity::NonNegative;
use crate::settings::registry;
use core::ops::Range;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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

/// What happens where the curve comes too near to an obstacle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Check {
    /// It is drawn to the path, or becomes the path, and that is counted.
    #[default]
    Fallback,
    /// Nothing, as printed.
    None,
}

registry! {
    /// A path stage with its parameters.
    pub enum PathChoice: "path stage", Entry, dyn PathKind {
        line_of_sight,
        clearance_prune,
        arc_fillet,
        b_spline,
        grandparent_prune,
        farthest_visible,
        minimum_snap,
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

/// The path that goes from vertex to vertex: straight to the one that `far` names, two or more on, and where it names none by the
/// path's own piece to the next.
fn shortened(path: &Path, mut far: impl FnMut(usize) -> Option<usize>) -> Path {
    let vertices: Vec<Vec2> = path.vertices().collect();
    let (mut pieces, mut at) = (Vec::new(), 0);
    while at + 1 < vertices.len() {
        match far(at) {
            Some(far) => {
                pieces.push(Piece::Line { to: vertices[far] });
                at = far;
            }
            None => {
                pieces.push(path.pieces()[at].clone());
                at += 1;
            }
        }
    }
    Path::new(path.start(), pieces)
}

/// Precision of the distance of a curve from obstacles, m.
const EXACT_M: f64 = 1e-7;
/// Chords of a curve stay this near to it where it is judged by blocked squares and movers, in cells.
const SAGITTA_CELLS: f64 = 1e-3;

/// What a curve keeps from blocked squares, m: what the stage asks for, else 0 with inflation, which the curve keeps from obstacles,
/// and the robot's radius without.
fn clearance_of_curves_m(asked: Option<NonNegative>, grid: &PlanningGrid, radius_m: f64) -> f64 {
    let without = if grid.inflation_m() > 0.0 { 0.0 } else { radius_m };
    asked.map_or(without, NonNegative::get)
}

/// Whether a curve keeps `needed_m` from obstacles where there is inflation, `clearance_m` from blocked squares, and from movers
/// that block cells what these ends do.
fn curve_keeps(curve: &Curve, grid: &PlanningGrid, needed_m: f64, clearance_m: f64, [from, to]: [Vec2; 2]) -> bool {
    // The first parts are short enough for a look at the obstacles about a cell around.
    let parts = curve.chords_within(grid.resolution_m());
    let part = |k: u32| f64::from(k) / f64::from(parts);
    let keeps_inflation = grid
        .obstacles()
        .is_none_or(|obstacles| (0..parts).all(|k| part_keeps(curve, &obstacles, needed_m, part(k), part(k + 1))));
    let chords = curve.chords_within(SAGITTA_CELLS * grid.resolution_m());
    let at = |k: u32| curve.point(f64::from(k) / f64::from(chords));
    let asks = clearance_m > 0.0 || grid.obstacles().is_none();
    keeps_inflation
        && (0..chords).map(|k| (at(k), at(k + 1))).all(|(a, b)| {
            grid.passes_movers_between(a, b, from, to)
                && (!asks || grid.line_of_sight_with_clearance(a, b, clearance_m))
        })
}

/// Whether the part of a curve between two parameters keeps `needed_m` from obstacles, to [`EXACT_M`], and touches none: its chord
/// says so, or both halves do.
fn part_keeps(curve: &Curve, obstacles: &Obstacles<'_>, needed_m: f64, from: f64, to: f64) -> bool {
    let part = to - from;
    let sagitta_m = part * part * curve.sagitta_bound_m(1);
    let room_m = obstacles.segment_clearance(curve.point(from), curve.point(to), needed_m + sagitta_m);
    if sagitta_m <= EXACT_M {
        return room_m > 0.0 && room_m >= needed_m - EXACT_M;
    }
    room_m >= needed_m + sagitta_m
        || room_m >= needed_m - sagitta_m && {
            let middle = 0.5 * (from + to);
            part_keeps(curve, obstacles, needed_m, from, middle) && part_keeps(curve, obstacles, needed_m, middle, to)
        }
}
