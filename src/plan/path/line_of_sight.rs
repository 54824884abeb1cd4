//! `line_of_sight`: removes the vertices between two that see each other.
//!
//! Greedy from the start: from vertex i go straight to the last vertex j in sight, and on from there;
//! where none beyond the next one is in sight, the path's own piece to it is kept as it is. Never
//! longer than the path given, by the triangle inequality.
//!
//! Source: corner removal of Qin, Gao, Lu, "SSA*-PDWA", Computers, Materials & Continua 87(1), 2026,
//! as resolved in `systems.md` §3(a): `i → largest j with los_r(P_i, P_j, r)`; there r is half a cell
//! (Q-A5). Common practice otherwise ("string pulling").
//!
//! Departures: pieces between neighbouring vertices are kept even where they break the clearance, so
//! that a path remains a path; arcs of a stage before are pieces like any other.

use super::{Entry, PathStage, PlanningGrid};
use crate::geometry::{Path, Piece, Vec2};
use crate::quantity::NonNegative;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Parameters of `line_of_sight`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Distance that a shortcut must keep from blocked squares of the planning grid, m; larger keeps
    /// more of the path. Default 0: it must not touch one.
    pub clearance_m: NonNegative,
}

impl Default for Params {
    fn default() -> Self {
        Self { clearance_m: NonNegative::new(0.0) }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Goes straight to the farthest vertex in sight, again and again: fewer bends, never longer.",
    source: "corner removal of H. Qin et al., SSA*-PDWA, Computers, Materials & Continua 87(1), 2026",
};

/// The stage.
#[derive(Debug)]
pub struct Stage {
    clearance_m: f64,
    vertices: Vec<Vec2>,
}

impl Stage {
    /// A fresh stage.
    pub fn new(params: &Params) -> Self {
        Self { clearance_m: params.clearance_m.get(), vertices: Vec::new() }
    }
}

impl PathStage for Stage {
    fn apply(&mut self, grid: &PlanningGrid, path: &Path) -> Path {
        self.vertices.clear();
        self.vertices.extend(path.vertices());
        let vertices = &self.vertices;
        let in_sight = |i: usize, j: usize| {
            grid.line_of_sight_with_clearance(vertices[i], vertices[j], self.clearance_m)
        };
        let last = vertices.len() - 1;
        let mut pieces = Vec::new();
        let mut at = 0;
        while at < last {
            match (at + 2..=last).rev().find(|&far| in_sight(at, far)) {
                Some(far) => {
                    pieces.push(Piece::Line { to: vertices[far] });
                    at = far;
                }
                None => {
                    pieces.push(path.pieces()[at]);
                    at += 1;
                }
            }
        }
        Path::new(path.start(), pieces)
    }
}
