//! The score J of a path: its length, its nearness to obstacles and its turns in one number; less is better.
//!
//! Source: Qin, Gao, Lu, "SSA*-PDWA", Computers, Materials & Continua 87(1), art. 86, 2026, eq. 4 to 8 (`qin2026`).
//!
//! ```text
//! J = w1 Σ |P_{i+1} − P_i|  +  w2 Σ 1 / d(P_i)  +  w3 Σ (φ_i − φ_{i−1})²
//! φ_i = direction from P_i to P_{i+1}         d: distance to the nearest obstacle or the edge of the known map
//! ```
//!
//! Points and distances are in cells, as in the paper; angles in rad.
//!
//! Readings of the paper (ids of `systems.md`): 1/d, and not d, floored at 0.1 cell (Q-A1); the difference of directions is wrapped to
//! (−π, π] and summed over interior points (Q-A2). The weights and d_max are not given; all are 1.
//!
//! The second sum counts points: a path from which a stage has taken nodes scores better for it, wherever it leads. So there are two
//! columns: over the nodes of the path as printed, and over points of equal spacing along it, d_max at most (the constraint of eq. 8), to which
//! the number of nodes is nothing. There a corner between two points is cut, so that it may count as two smaller turns.

use crate::geometry::{Path, Vec2, cross};
use crate::math;
use crate::settings::quantity::{NonNegative, Positive};
use crate::world::StaticMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Least distance to an obstacle that is counted, cells (Q-A1).
const DISTANCE_MIN_CELLS: f64 = 0.1;

/// Most points of a resampled path, for steps that are nearly 0.
const STEPS_MAX: f64 = 1e6;

/// Weights of the columns `path_score` and `path_score_resampled` (scenario key `metrics.path_score`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PathScoreSpec {
    /// w1: cost of a cell of length (default 1).
    pub length_weight: NonNegative,
    /// w2: cost of a point that is one cell from an obstacle (default 1).
    pub safety_weight: NonNegative,
    /// w3: cost of a turn by 1 rad; larger turns cost the square (default 1).
    pub turn_weight: NonNegative,
    /// d_max: longest distance between points of the resampled path, cells (default 1). Smaller counts nearness at more points.
    pub step_max_cells: Positive,
}

impl Default for PathScoreSpec {
    fn default() -> Self {
        let one = NonNegative::new(1.0);
        Self { length_weight: one, safety_weight: one, turn_weight: one, step_max_cells: Positive::new(1.0) }
    }
}

/// `path_score`: J over the nodes of the path, as printed; less is better.
pub fn path_score(path: &Path, known: &StaticMap, spec: &PathScoreSpec) -> f64 {
    score(path.vertices(), known, spec)
}

/// `path_score_resampled`: J over points of equal spacing along the path, `spec.step_max_cells` at most; less is better.
pub fn path_score_resampled(path: &Path, known: &StaticMap, spec: &PathScoreSpec) -> f64 {
    score(resampled(path, spec.step_max_cells.get() * known.grid.resolution_m()).into_iter(), known, spec)
}

/// Points of equal spacing along a path, `step_max_m` at most, both ends included; one point where the path has no length.
fn resampled(path: &Path, step_max_m: f64) -> Vec<Vec2> {
    let length_m = path.length();
    // A length that is a whole number of steps but for rounding takes no step more.
    let steps = math::clamp((length_m / step_max_m - 1e-9).ceil(), 0.0, STEPS_MAX);
    let (mut points, mut begin_m) = (vec![path.start()], 0.0);
    for (from, piece) in path.segments() {
        let end_m = begin_m + piece.length(from);
        loop {
            let along_m = length_m * (points.len() as f64 / steps);
            if points.len() as f64 >= steps || along_m > end_m {
                break;
            }
            points.push(piece.point_at(from, along_m - begin_m));
        }
        begin_m = end_m;
    }
    if steps > 0.0 {
        points.push(path.end());
    }
    points
}

/// J over some points. A point at the place of the one before has no direction to it and costs its nearness alone.
fn score(points: impl Iterator<Item = Vec2>, known: &StaticMap, spec: &PathScoreSpec) -> f64 {
    let cell_m = known.grid.resolution_m();
    let (mut length, mut nearness, mut turns) = (0.0, 0.0, 0.0);
    let mut before: Option<Vec2> = None;
    let mut arriving: Option<Vec2> = None;
    for point in points {
        nearness += 1.0 / math::max(known.distance_m(point) / cell_m, DISTANCE_MIN_CELLS);
        let step = before.map(|before| point - before).filter(|step| step.norm_squared() > 0.0);
        if let Some(step) = step {
            length += step.norm() / cell_m;
            let turn = arriving.map_or(0.0, |arriving| math::atan2(cross(arriving, step), arriving.dot(&step)));
            turns += turn * turn;
            arriving = Some(step);
        }
        before = Some(point);
    }
    spec.length_weight.get() * length + spec.safety_weight.get() * nearness + spec.turn_weight.get() * turns
}

#[cfg(test)]
mod tests {
    use super::super::tests::close;
    use super::*;
    use crate::geometry::Piece;
    use crate::map::OccupancyGrid;
    use crate::math::{FRAC_PI_2, PI};

    fn weights(length: f64, safety: f64, turn: f64, step_max_cells: f64) -> PathScoreSpec {
        let [length_weight, safety_weight, turn_weight] = [length, safety, turn].map(NonNegative::new);
        PathScoreSpec { length_weight, safety_weight, turn_weight, step_max_cells: Positive::new(step_max_cells) }
    }

    /// A room of 8 by 5 cells with a block in the square from (4, 2) to (5, 3).
    fn room(cell_m: f64) -> StaticMap {
        let lines = ["........", "........", "....#...", "........", "........"];
        StaticMap::new(OccupancyGrid::from_ascii(&lines, cell_m))
    }

    fn path(points: &[(f64, f64)], cell_m: f64) -> Path {
        Path::polyline(&points.iter().map(|&(x, y)| Vec2::new(x, y) * cell_m).collect::<Vec<_>>())
    }

    #[test]
    fn the_score_of_a_path_with_a_corner_is_that_by_hand() {
        for cell_m in [1.0, 0.05] {
            let known = room(cell_m);
            // 3 cells to the east, 2 to the north. d: 1.5 at (1.5, 1.5) from the left edge and the lower one; at (4.5, 1.5) 0.5 below
            // the block; (4.5, 3.5) likewise 0.5 above it. Two legs with a turn by π/2 between.
            let path = path(&[(1.5, 1.5), (4.5, 1.5), (4.5, 3.5)], cell_m);
            let score = |w1, w2, w3| path_score(&path, &known, &weights(w1, w2, w3, 1.0));
            assert!(close(score(1.0, 0.0, 0.0), 5.0));
            assert!(close(score(0.0, 1.0, 0.0), 1.0 / 1.5 + 2.0 + 2.0));
            assert!(close(score(0.0, 0.0, 1.0), FRAC_PI_2 * FRAC_PI_2));
            assert!(close(score(1.0, 1.0, 1.0), 5.0 + 14.0 / 3.0 + PI * PI / 4.0));
            assert!(close(score(2.0, 0.5, 3.0), 10.0 + 7.0 / 3.0 + 0.75 * PI * PI));
            // In steps of a cell: 1.5, then (2.5, 1.5): 1.5; (3.5, 1.5): the corner (4, 2), √0.5; (4.5, 1.5): 0.5; (4.5, 2.5): in the
            // block, 0.1; (4.5, 3.5): 0.5.
            let resampled = |w1, w2, w3| path_score_resampled(&path, &known, &weights(w1, w2, w3, 1.0));
            assert!(close(resampled(1.0, 0.0, 0.0), 5.0));
            assert!(close(resampled(0.0, 1.0, 0.0), 2.0 / 1.5 + 2f64.sqrt() + 2.0 + 10.0 + 2.0));
            assert!(close(resampled(0.0, 0.0, 1.0), PI * PI / 4.0));
        }
    }

    #[test]
    fn differences_of_directions_are_wrapped() {
        // From south-west by west to north-west by west: φ goes from −3π/4 to 3π/4, a turn by −π/2. And back on itself: π.
        let known = room(1.0);
        let turns = |points: &[(f64, f64)]| path_score(&path(points, 1.0), &known, &weights(0.0, 0.0, 1.0, 1.0));
        assert!(close(turns(&[(3.0, 3.0), (2.0, 2.0), (1.0, 3.0)]), PI * PI / 4.0));
        assert!(close(turns(&[(1.0, 1.0), (3.0, 1.0), (2.0, 1.0)]), PI * PI));
        // A doubled vertex turns nothing and costs its nearness.
        assert!(close(turns(&[(1.0, 1.0), (3.0, 1.0), (3.0, 1.0), (3.0, 2.0)]), PI * PI / 4.0));
        let near = |points: &[(f64, f64)]| path_score(&path(points, 1.0), &known, &weights(0.0, 1.0, 0.0, 1.0));
        assert!(close(near(&[(1.0, 1.0), (1.0, 1.0)]), 2.0));
    }

    #[test]
    fn the_number_of_nodes_moves_the_printed_score_and_not_the_resampled_one() {
        let known = room(0.5);
        let spec = PathScoreSpec::default();
        let sparse = path(&[(0.5, 0.5), (7.5, 0.5)], 0.5);
        let dense = path(&[(0.5, 0.5), (1.5, 0.5), (2.5, 0.5), (3.1, 0.5), (4.0, 0.5), (7.5, 0.5)], 0.5);
        assert!(close(path_score(&sparse, &known, &spec), 7.0 + 2.0 / 0.5));
        assert!(close(path_score(&dense, &known, &spec), 7.0 + 6.0 / 0.5));
        // Eight points a cell apart, all half a cell from the edge.
        assert!(close(path_score_resampled(&sparse, &known, &spec), 7.0 + 8.0 / 0.5));
        assert!(close(path_score_resampled(&dense, &known, &spec), 7.0 + 8.0 / 0.5));
        // In steps of 2 cells at most: four of 1.75.
        let wider = PathScoreSpec { step_max_cells: Positive::new(2.0), ..spec };
        assert!(close(path_score_resampled(&dense, &known, &wider), 7.0 + 5.0 / 0.5));
    }

    #[test]
    fn a_single_point_and_an_arc() {
        let known = room(1.0);
        let spec = PathScoreSpec::default();
        let point = path(&[(2.0, 2.0)], 1.0);
        assert!(
            close(path_score(&point, &known, &spec), 0.5) && close(path_score_resampled(&point, &known, &spec), 0.5)
        );
        // A quarter circle of radius 1, in thirds at most: five chords of 2 sin(9°), each 18° on from the one before.
        let arc = Piece::Arc { to: Vec2::new(3.0, 2.0), centre: Vec2::new(2.0, 2.0), sweep: FRAC_PI_2 };
        let arc = Path::new(Vec2::new(2.0, 1.0), vec![arc]);
        let of = |w1, w3| path_score_resampled(&arc, &known, &weights(w1, 0.0, w3, 1.0 / 3.0));
        assert!(close(of(1.0, 0.0), 10.0 * math::sin(PI / 20.0)));
        assert!(close(of(0.0, 1.0), 4.0 * (PI / 10.0) * (PI / 10.0)));
        assert!(close(path_score(&arc, &known, &weights(1.0, 0.0, 1.0, 1.0)), 2f64.sqrt()));
    }
}
