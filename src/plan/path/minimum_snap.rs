//! `minimum_snap`: polynomials in time through the key nodes, with the least snap, the fourth derivative of the position.
//!
//! Source: Hu, Wang, Zhang, Research on Dynamic Obstacle Avoidance Method of Mobile Robot based on Improved A* Algorithm and Dynamic
//! Window Method, Engineering Letters 32(3), 2024, eq. 6 to 13 (`hu2024`), after D. Mellinger, V. Kumar, Minimum snap trajectory
//! generation and control for quadrotors, ICRA 2011.
//!
//! ```text
//! minimise  Σ_i ∫ |x⁗(t)|² dt   over x of degree 7 in each of k segments, with
//!   x(t_i) = key node i                      velocity and acceleration 0 at both ends
//!   x', x'' and x''' continuous at the key nodes between
//! ```
//!
//! **Solution.** A polynomial of degree 7 is given by position, velocity, acceleration and jerk at its two ends. The positions are
//! known; the derivatives at the nodes, as far as they are not 0, are the unknowns, which satisfies all constraints from the outset
//! and leaves a positive definite system, the conditions of Karush, Kuhn and Tucker with the multipliers eliminated. A node meets its
//! two neighbours alone: the system has 7 diagonals beside the main one and is solved by L D Lᵀ in time proportional
//! to k, both axes at once, in one order of operations: the same bits everywhere.
//!
//! **Time.** The path carries times: as a whole it takes its length before smoothing by `speed_mps`, which is a mean, not a limit. The
//! curve does not depend on it.
//!
//! Readings of the paper (ids of `systems.md`):
//! - H-A6, H-A9: eq. 9 and 13 as they must be meant.
//! - H-A7: the degree is not given and continuity is printed up to the acceleration. `continuity: 3` joins the jerk as well and is the
//!   default; `2` is the printed form.
//! - H-A8: all segments take the same time (`time_alloc: equal`), so short ones are driven slowly and long ones fast, and the curve swings
//!   out or makes loops where they meet; `proportional` gives a segment time in proportion to the distance between its nodes.
//! - H-A8, H-A19: the paper checks nothing, and its smoothed path collides. By default (`check: fallback`) every segment
//!   must keep from obstacles what the path between the two nodes keeps: the inflation, or as much as that path does, and without inflation
//!   the robot's radius (`clearance_m`). Where one does not, the middle of the path beneath it becomes a node, and all is
//!   solved again, up to five times; then the path stays as it came. [`Path::fallbacks`] counts the segments of the first curve that
//!   did not keep their distance. `check: none` is the printed form; a curve that leads deep into an obstacle is then an error of the plan.
//!
//! The nodes are the key nodes of the path as it comes, and stay its key nodes; middles that were added are none.
//!
//! Parameters: [`Params`].

use super::{Check, PathKind, clearance_of_curves_m, curve_keeps};
use crate::geometry::curve::{COEFFICIENTS, Curve};
use crate::geometry::{KeyNode, Path, Piece, Vec2};
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, Failure, PathStage, Task};
use crate::settings::quantity::{NonNegative, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rounds of new nodes in the middle of segments.
const ROUNDS: u32 = 5;
/// Nodes nearer to the one before are left out, m.
const APART_M: f64 = 1e-6;
/// Diagonals of the system beside the main one.
const BAND: usize = 7;

/// How the time is shared out among the segments (H-A8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TimeAlloc {
    /// Every segment takes the same time, as printed.
    #[default]
    Equal,
    /// In proportion to the distance between its nodes.
    Proportional,
}

/// Order of the highest derivative that is continuous at the nodes: 2, the acceleration, or 3, the jerk.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "u8", into = "u8")]
pub struct Continuity(u8);

impl Continuity {
    /// Acceleration, as printed.
    pub const ACCELERATION: Self = Self(2);
    /// Jerk.
    pub const JERK: Self = Self(3);
}

impl TryFrom<u8> for Continuity {
    type Error = String;
    fn try_from(order: u8) -> Result<Self, String> {
        match order {
            2 | 3 => Ok(Self(order)),
            _ => Err(format!("expected 2 (acceleration) or 3 (jerk), found {order}")),
        }
    }
}

impl From<Continuity> for u8 {
    fn from(continuity: Continuity) -> Self {
        continuity.0
    }
}

impl JsonSchema for Continuity {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Continuity".into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({"type": "integer", "enum": [2, 3]})
    }
}

/// Parameters of `minimum_snap`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// How the time is shared out among the segments. Default `equal`.
    pub time_alloc: TimeAlloc,
    /// Order of the highest derivative that is continuous at the nodes: 2 as printed, or 3. Default 3.
    pub continuity: Continuity,
    /// Mean speed, m/s: the path takes its length before smoothing by this. Larger times the path faster. Default 1.
    pub speed_mps: Positive,
    /// What happens where the curve comes too near to an obstacle. Default `fallback`.
    pub check: Check,
    /// Distance that the curve keeps from blocked squares of the planning grid, m; larger falls back more often. Default: 0 with
    /// inflation, which it keeps from obstacles, else the robot's radius.
    pub clearance_m: Option<NonNegative>,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            time_alloc: TimeAlloc::Equal,
            continuity: Continuity::JERK,
            speed_mps: Positive::new(1.0),
            check: Check::Fallback,
            clearance_m: None,
        }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Smooths with polynomials of least snap through the key nodes, with times; keeps the path's clearance, or the path.",
    source: "Hu, Wang, Zhang, Research on Dynamic Obstacle Avoidance Method of Mobile Robot based on Improved A* Algorithm and Dynamic Window Method, Engineering Letters 32(3), 2024, eq. 6 to 13",
    ..Entry::PLAIN
};

impl PathKind for Params {
    fn build(&self) -> Box<dyn PathStage> {
        Box::new(Stage::new(self))
    }
}

/// A node of the trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    position: Vec2,
    /// Its place on the path before smoothing, m.
    along_m: f64,
    /// Whether it is a key node of that path and not a middle that was added.
    is_key: bool,
}

/// The last four coefficients of the polynomial of degree 7 on [0, 1] that has these derivatives of order 0 to 3 at 0 and then at 1.
fn upper_coefficients<T>(d: [T; 8]) -> [T; 4]
where
    T: Copy + core::ops::Add<Output = T> + core::ops::Sub<Output = T> + core::ops::Mul<f64, Output = T>,
{
    let [p0, v0, a0, j0, p1, v1, a1, j1] = d;
    // What the first four leave of the derivatives at 1.
    let p = p1 - p0 - v0 - a0 * 0.5 - j0 * (1.0 / 6.0);
    let v = v1 - v0 - a0 - j0 * 0.5;
    let a = a1 - a0 - j0;
    let j = j1 - j0;
    [
        p * 35.0 - v * 15.0 + a * 2.5 - j * (1.0 / 6.0),
        v * 39.0 - p * 84.0 - a * 7.0 + j * 0.5,
        p * 70.0 - v * 34.0 + a * 6.5 - j * 0.5,
        v * 10.0 - p * 20.0 - a * 2.0 + j * (1.0 / 6.0),
    ]
}

/// The polynomial of degree 7 on [0, 1] that has these derivatives of order 0 to 3 at 0 and then at 1.
fn coefficients(d: [Vec2; 8]) -> [Vec2; COEFFICIENTS] {
    let [c4, c5, c6, c7] = upper_coefficients(d);
    [d[0], d[1], d[2] * 0.5, d[3] * (1.0 / 6.0), c4, c5, c6, c7]
}

/// H of ∫ (x⁗)² du = dᵀ H d for the polynomial on [0, 1] with the derivatives d: Mᵀ Q M with the rows of M from [`upper_coefficients`] and
/// Q of eq. 9.
fn snap_of_derivatives() -> [[f64; 8]; 8] {
    // r! / (r − 4)! for r from 4 to 7.
    const FALLING: [f64; 4] = [24.0, 120.0, 360.0, 840.0];
    let columns: [[f64; 4]; 8] = core::array::from_fn(|k| {
        let mut unit = [0.0; 8];
        unit[k] = 1.0;
        upper_coefficients(unit)
    });
    core::array::from_fn(|a| {
        core::array::from_fn(|b| {
            let mut sum = 0.0;
            for r in 0..4 {
                for c in 0..4 {
                    sum += columns[a][r] * columns[b][c] * FALLING[r] * FALLING[c] / (r + c + 1) as f64;
                }
            }
            sum
        })
    })
}

/// A derivative at the end of a segment: 0 or known, or an unknown of the system.
#[derive(Clone, Copy, Debug)]
enum Slot {
    Known(Vec2),
    Unknown(usize),
}

/// Numbers of the unknowns, node by node.
struct Unknowns {
    continuity: Continuity,
    segments: usize,
}

impl Unknowns {
    fn per_node(&self) -> usize {
        if self.continuity == Continuity::JERK { 3 } else { 4 }
    }

    /// Number of unknowns: the jerk at both ends, and velocity, acceleration and one jerk or two at each node between.
    fn count(&self) -> usize {
        2 + (self.segments - 1) * self.per_node()
    }

    /// The derivative of `order` 1 to 3 at node `node`, as the end of the segment before it (`arrives`) or the beginning of the one after.
    fn slot(&self, node: usize, order: usize, arrives: bool) -> Slot {
        let is_end = node == 0 || node == self.segments;
        let first = if node == 0 { 0 } else { 1 + (node - 1) * self.per_node() };
        match order {
            3 if is_end => Slot::Unknown(first),
            _ if is_end => Slot::Known(Vec2::zeros()),
            3 if !arrives && self.continuity != Continuity::JERK => Slot::Unknown(first + 3),
            _ => Slot::Unknown(first + order - 1),
        }
    }
}

/// A symmetric system with [`BAND`] diagonals on either side of the main one, for both axes.
struct Banded {
    /// Row i from column i − BAND to i.
    rows: Vec<[f64; BAND + 1]>,
    right: Vec<Vec2>,
}

impl Banded {
    fn new(count: usize) -> Self {
        Self { rows: vec![[0.0; BAND + 1]; count], right: vec![Vec2::zeros(); count] }
    }

    fn add(&mut self, row: usize, col: usize, value: f64) {
        if col <= row {
            self.rows[row][BAND + col - row] += value;
        }
    }

    /// The solution, by L D Lᵀ without pivots: the matrix is positive definite.
    fn solve(mut self) -> Vec<Vec2> {
        let count = self.rows.len();
        for i in 0..count {
            let first = i.saturating_sub(BAND);
            for j in first..=i {
                // L D of the rows above is known; D stands on the diagonal.
                let mut sum = self.rows[i][BAND + j - i];
                for k in first.max(j.saturating_sub(BAND))..j {
                    sum -= self.rows[i][BAND + k - i] * self.rows[j][BAND + k - j] * self.rows[k][BAND];
                }
                self.rows[i][BAND + j - i] = if j == i { sum } else { sum / self.rows[j][BAND] };
            }
        }
        let mut x = self.right;
        for i in 0..count {
            for k in i.saturating_sub(BAND)..i {
                let step = x[k] * self.rows[i][BAND + k - i];
                x[i] -= step;
            }
        }
        for (x, row) in x.iter_mut().zip(&self.rows).take(count) {
            *x /= row[BAND];
        }
        for i in (0..count).rev() {
            for k in i.saturating_sub(BAND)..i {
                let step = x[i] * self.rows[i][BAND + k - i];
                x[k] -= step;
            }
        }
        x
    }
}

/// The curves of least snap through `positions`, of which segment i takes the time `durations[i]`, each over its own u from 0 to 1.
fn curves(positions: &[Vec2], durations: &[f64], continuity: Continuity) -> Vec<Curve> {
    let unknowns = Unknowns { continuity, segments: durations.len() };
    // Derivatives with respect to time become ones with respect to u by powers of the duration.
    let slots = |segment: usize| -> [(Slot, f64); 8] {
        let t = durations[segment];
        let scale = [1.0, t, t * t, t * t * t];
        core::array::from_fn(|k| {
            let (node, order) = (segment + k / 4, k % 4);
            let slot = if order == 0 { Slot::Known(positions[node]) } else { unknowns.slot(node, order, k >= 4) };
            (slot, scale[order])
        })
    };
    let snap = snap_of_derivatives();
    let mut system = Banded::new(unknowns.count());
    for (segment, &t) in durations.iter().enumerate() {
        // x⁗ by time is that by u over t⁴, and dt = t du.
        let weight = 1.0 / (t * t * t * t * t * t * t);
        let slots = slots(segment);
        // Snap does not depend on where the segment begins: positions count from there, which keeps rounding small.
        let origin = positions[segment];
        for (a, &(row, row_scale)) in slots.iter().enumerate() {
            let Slot::Unknown(row) = row else { continue };
            for (b, &(col, col_scale)) in slots.iter().enumerate() {
                let value = weight * snap[a][b] * row_scale;
                match col {
                    Slot::Unknown(col) => system.add(row, col, value * col_scale),
                    Slot::Known(known) if b == 4 => system.right[row] -= (known - origin) * value,
                    Slot::Known(_) => {}
                }
            }
        }
    }
    let solution = system.solve();
    (0..durations.len())
        .map(|segment| {
            let origin = positions[segment];
            let derivatives = slots(segment).map(|(slot, scale)| match slot {
                Slot::Known(known) => known,
                Slot::Unknown(number) => solution[number] * scale,
            });
            let mut relative = derivatives;
            relative[0] = Vec2::zeros();
            relative[4] = derivatives[4] - origin;
            let mut coefficients = coefficients(relative);
            coefficients[0] = origin;
            Curve::new(&coefficients).ending_at(positions[segment + 1])
        })
        .collect()
}

/// The stage. It has no state.
#[derive(Debug)]
pub struct Stage {
    params: Params,
}

impl Stage {
    /// A fresh stage.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone() }
    }

    /// Shares of the time for segments between `nodes`, 1 on average.
    fn durations(&self, nodes: &[Node]) -> Vec<f64> {
        let segments = nodes.len() - 1;
        match self.params.time_alloc {
            TimeAlloc::Equal => vec![1.0; segments],
            TimeAlloc::Proportional => {
                let lengths: Vec<f64> =
                    nodes.windows(2).map(|pair| (pair[1].position - pair[0].position).norm()).collect();
                let whole = lengths.iter().fold(0.0, |sum, length| sum + length);
                lengths.iter().map(|length| length / whole * segments as f64).collect()
            }
        }
    }

    /// The nodes at which the trajectory begins: the key nodes of the path, no two in one place.
    fn nodes(path: &Path) -> Vec<Node> {
        let mut keys: Vec<KeyNode> = Vec::new();
        path.key_nodes(&mut keys);
        let last = keys.len() - 1;
        let mut nodes: Vec<Node> = Vec::with_capacity(keys.len());
        for (number, key) in keys.iter().enumerate() {
            let position = match number {
                0 => path.start(),
                _ if number == last => path.end(),
                _ => key.position,
            };
            let node = Node { position, along_m: key.along_m, is_key: true };
            if number == last && number > 0 {
                while nodes.len() > 1 && (nodes[nodes.len() - 1].position - position).norm() < APART_M {
                    nodes.pop();
                }
            }
            let is_apart = nodes.last().is_none_or(|before| (before.position - position).norm() >= APART_M);
            if is_apart || number == last {
                nodes.push(node);
            }
        }
        nodes
    }

    /// Whether the curve between two nodes keeps what the path between them keeps.
    fn keeps(grid: &PlanningGrid, path: &Path, clearance_m: f64, pair: &[Node], curve: &Curve) -> bool {
        let needed_m = grid.obstacles().map_or(0.0, |obstacles| {
            obstacles.path_clearance(path, pair[0].along_m, pair[1].along_m, grid.inflation_m())
        });
        curve_keeps(curve, grid, needed_m, clearance_m, [pair[0].position, pair[1].position])
    }

    /// The path as this stage makes it on `grid` for a robot of `radius_m`.
    fn treat(&self, grid: &PlanningGrid, radius_m: f64, path: &Path) -> Path {
        let clearance_m = clearance_of_curves_m(self.params.clearance_m, grid, radius_m);
        let duration_s = path.length() / self.params.speed_mps.get();
        let mut nodes = Self::nodes(path);
        if path.length() < APART_M || nodes.len() < 2 {
            return path.clone();
        }
        let mut fallbacks = 0;
        for round in 0..=ROUNDS {
            let positions: Vec<Vec2> = nodes.iter().map(|node| node.position).collect();
            let durations = self.durations(&nodes);
            let curves = curves(&positions, &durations, self.params.continuity);
            let broken: Vec<usize> = match self.params.check {
                Check::None => Vec::new(),
                Check::Fallback => (0..curves.len())
                    .filter(|&k| !Self::keeps(grid, path, clearance_m, &nodes[k..k + 2], &curves[k]))
                    .collect(),
            };
            if round == 0 {
                fallbacks = broken.len() as u32;
            }
            if broken.is_empty() {
                let pieces = curves.into_iter().map(|curve| Piece::Curve(Box::new(curve))).collect();
                return timed(Path::new(path.start(), pieces), duration_s, &durations)
                    .with_key_nodes_at_ends(|piece| nodes[piece + 1].is_key)
                    .with_fallbacks(fallbacks);
            }
            // From the back, so that places stay valid.
            for &k in broken.iter().rev() {
                let along_m = 0.5 * (nodes[k].along_m + nodes[k + 1].along_m);
                let position = path.point_at(along_m);
                let is_apart = |node: &Node| (node.position - position).norm() >= APART_M;
                if is_apart(&nodes[k]) && is_apart(&nodes[k + 1]) {
                    nodes.insert(k + 1, Node { position, along_m, is_key: false });
                }
            }
        }
        let lengths: Vec<f64> = path.segments().map(|(from, piece)| piece.length(from)).collect();
        timed(path.clone(), duration_s, &lengths).with_fallbacks(fallbacks)
    }
}

/// The path with times that share out `duration_s` in proportion to `shares`, one for each piece.
fn timed(path: Path, duration_s: f64, shares: &[f64]) -> Path {
    let whole = shares.iter().fold(0.0, |sum, share| sum + share);
    let mut elapsed = 0.0;
    let times_s = shares.iter().map(|share| {
        elapsed += share;
        duration_s * math::min(elapsed / whole, 1.0)
    });
    let times_s = times_s.collect();
    path.with_times(times_s)
}

impl PathStage for Stage {
    fn apply(&mut self, task: &Task<'_>, path: &Path) -> Result<Path, Failure> {
        Ok(self.treat(task.grid, task.situation.robot.radius_m, path))
    }

    fn keeps_off_obstacles(&self) -> bool {
        self.params.check == Check::Fallback
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Cell, DistanceField, OccupancyGrid};
    use crate::plan::clearance::Obstacles;
    use crate::plan::contract::Problem;
    use crate::plan::global::GlobalChoice;
    use crate::plan::grid::tests::{random_cell, random_map, stream, uninflated};
    use crate::plan::path::farthest_visible;
    use crate::rng::Stream;

    fn v(x: f64, y: f64) -> Vec2 {
        Vec2::new(x, y)
    }

    const BOTH: [Continuity; 2] = [Continuity::JERK, Continuity::ACCELERATION];

    /// Nodes at random, 1 m to 8 m apart, and durations at random.
    fn random_course(stream: &mut Stream) -> (Vec<Vec2>, Vec<f64>) {
        let segments = 1 + stream.index(8);
        let mut positions = vec![v(stream.range(0.0, 50.0), stream.range(0.0, 50.0))];
        for _ in 0..segments {
            let way = crate::geometry::direction(stream.range(-3.0, 3.0)) * stream.range(1.0, 8.0);
            positions.push(positions[positions.len() - 1] + way);
        }
        (positions, (0..segments).map(|_| stream.range(0.5, 2.0)).collect())
    }

    fn power(x: f64, n: usize) -> f64 {
        (0..n).map(|_| x).product()
    }

    /// Snap of curves, by Simpson's rule, which is exact for cubics and wrong by far less than 1e-9 of the sum here.
    fn snap(curves: &[Curve], durations: &[f64]) -> f64 {
        const PARTS: u32 = 200;
        let of = |(curve, t): (&Curve, &f64)| {
            let squared = |k: u32| curve.derivative(4, f64::from(k) / f64::from(PARTS)).norm_squared();
            let weight = |k: u32| if k == 0 || k == PARTS { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
            (0..=PARTS).map(|k| weight(k) * squared(k)).sum::<f64>() / (3.0 * f64::from(PARTS)) / power(*t, 7)
        };
        curves.iter().zip(durations).map(of).sum()
    }

    #[test]
    fn one_segment_is_the_smooth_step_by_hand() {
        // x⁗ is a cubic (x has no eighth derivative), 0 at both ends, where the jerk is free, and antisymmetric about the middle: a multiple of
        // u (u − 1/2) (u − 1). Integrated four times from x = x' = x'' = 0 to x = 1, x' = x'' = 0: 7 u³ − 21 u⁵ + 21 u⁶ − 6 u⁷.
        for continuity in BOTH {
            let [curve] = &curves(&[v(2.0, 3.0), v(6.0, 1.0)], &[1.7], continuity)[..] else { panic!("one segment") };
            let step = [0.0, 0.0, 0.0, 7.0, 0.0, -21.0, 21.0, -6.0];
            for (k, (&c, share)) in curve.coefficients().iter().zip(step).enumerate() {
                let expected = v(4.0, -2.0) * share + if k == 0 { v(2.0, 3.0) } else { v(0.0, 0.0) };
                assert!((c - expected).norm() < 1e-10, "{k}: {c:?} {expected:?}");
            }
        }
    }

    #[test]
    fn coefficients_are_those_of_a_dense_solver_with_multipliers() {
        let file = include_str!("../../../tests/data/minimum_snap.csv");
        let mut rows: Vec<(usize, Continuity, bool, Vec<f64>)> = Vec::new();
        for line in file.lines().skip(1) {
            let fields: Vec<&str> = line.split(',').collect();
            let continuity = Continuity::try_from(fields[1].parse::<u8>().unwrap()).unwrap();
            let numbers = fields[3..].iter().map(|field| field.parse().unwrap()).collect();
            rows.push((fields[0].parse().unwrap(), continuity, fields[2] == "equal", numbers));
        }
        let mut compared = 0;
        for case in rows.chunk_by(|a, b| a.0 == b.0) {
            let mut positions = vec![v(case[0].3[0], case[0].3[1])];
            positions.extend(case.iter().map(|row| v(row.3[2], row.3[3])));
            let nodes: Vec<Node> =
                positions.iter().map(|&position| Node { position, along_m: 0.0, is_key: true }).collect();
            let time_alloc = if case[0].2 { TimeAlloc::Equal } else { TimeAlloc::Proportional };
            let durations = Stage::new(&Params { time_alloc, ..Params::default() }).durations(&nodes);
            for (row, curve) in case.iter().zip(curves(&positions, &durations, case[0].1)) {
                for (k, c) in curve.coefficients().iter().enumerate() {
                    let expected = v(row.3[5 + k], row.3[13 + k]);
                    assert!((c - expected).norm() < 1e-8 * (1.0 + expected.norm()), "{row:?} {k}: {c:?} {expected:?}");
                    compared += 1;
                }
            }
        }
        assert_eq!(compared, 80 * 8);
    }

    #[test]
    fn nodes_are_met_ends_stand_and_derivatives_join() {
        let mut stream = stream(201);
        for _ in 0..200 {
            let (positions, durations) = random_course(&mut stream);
            for continuity in BOTH {
                let curves = curves(&positions, &durations, continuity);
                for (k, curve) in curves.iter().enumerate() {
                    assert_eq!((curve.point(0.0), curve.point(1.0)), (positions[k], positions[k + 1]));
                    let sum = curve.coefficients().iter().fold(Vec2::zeros(), |sum, c| sum + c);
                    assert!((sum - positions[k + 1]).norm() < 1e-9, "the polynomial itself ends there");
                }
                // One-sided differences by time, of second order or better.
                let at = |k: usize, t: f64| curves[k].point(t / durations[k]);
                let h = 1e-3;
                let first = |p: &dyn Fn(f64) -> Vec2| (-3.0 * p(0.0) + 4.0 * p(h) - p(2.0 * h)) / (2.0 * h);
                let second =
                    |p: &dyn Fn(f64) -> Vec2| (2.0 * p(0.0) - 5.0 * p(h) + 4.0 * p(2.0 * h) - p(3.0 * h)) / (h * h);
                let last = curves.len() - 1;
                let (begin, end) = (|t: f64| at(0, t), |t: f64| at(last, durations[last] - t));
                let sizes = curves.iter().zip(&durations).map(|(curve, t)| {
                    curve.coefficients()[3..].iter().map(|c| c.norm()).sum::<f64>() * 1000.0 / power(*t, 4)
                });
                let size = 1.0 + sizes.fold(0.0, math::max);
                assert!(first(&begin).norm() < 1e-6 * size && second(&begin).norm() < 1e-5 * size);
                assert!(first(&end).norm() < 1e-6 * size && second(&end).norm() < 1e-5 * size);
                for k in 1..curves.len() {
                    let (before, after) = (|t: f64| at(k - 1, durations[k - 1] - t), |t: f64| at(k, t));
                    assert!((first(&before) + first(&after)).norm() < 1e-6 * size);
                    assert!((second(&before) - second(&after)).norm() < 1e-5 * size);
                    let third = |k: usize, u: f64| curves[k].derivative(3, u) / power(durations[k], 3);
                    let (jerk, next) = (third(k - 1, 1.0), third(k, 0.0));
                    let joins = (jerk - next).norm() < 1e-7 * size;
                    assert_eq!(joins, continuity == Continuity::JERK, "{jerk:?} {next:?}");
                }
            }
        }
    }

    #[test]
    fn no_change_of_the_derivatives_at_the_nodes_has_less_snap() {
        let mut stream = stream(202);
        let mut tried = 0;
        for _ in 0..50 {
            let (positions, durations) = random_course(&mut stream);
            for continuity in BOTH {
                let best = curves(&positions, &durations, continuity);
                let least = snap(&best, &durations);
                for _ in 0..10 {
                    // Derivatives by time at each node, two jerks where they need not join.
                    let size = [1e-3, 0.1, 3.0][stream.index(3)];
                    let nodes = positions.len();
                    let mut change = |order: usize, node: usize| {
                        let is_free = order == 3 || node > 0 && node + 1 < nodes;
                        let by = v(stream.range(-1.0, 1.0), stream.range(-1.0, 1.0));
                        if is_free { by * size } else { v(0.0, 0.0) }
                    };
                    let arriving: Vec<[Vec2; 3]> =
                        (0..nodes).map(|node| core::array::from_fn(|k| change(k + 1, node))).collect();
                    let mut leaving = arriving.clone();
                    if continuity == Continuity::ACCELERATION {
                        leaving.iter_mut().enumerate().for_each(|(node, d)| d[2] = change(3, node));
                    }
                    let changed: Vec<Curve> = best
                        .iter()
                        .enumerate()
                        .map(|(k, curve)| {
                            let t = durations[k];
                            let by_u = |d: &[Vec2; 3]| [d[0] * t, d[1] * t * t, d[2] * t * t * t];
                            let (a, b) = (by_u(&leaving[k]), by_u(&arriving[k + 1]));
                            let zero = v(0.0, 0.0);
                            let added = coefficients([zero, a[0], a[1], a[2], zero, b[0], b[1], b[2]]);
                            let sum: [Vec2; COEFFICIENTS] =
                                core::array::from_fn(|i| curve.coefficients()[i] + added[i]);
                            Curve::new(&sum)
                        })
                        .collect();
                    let other = snap(&changed, &durations);
                    assert!(other >= least * (1.0 - 1e-9), "{other} {least}");
                    tried += u32::from(other > least * (1.0 + 1e-12));
                }
            }
        }
        assert!(tried > 500, "{tried}");
        // The printed form has fewer constraints, so never more snap.
        let (positions, durations) = random_course(&mut stream);
        let [joined, printed] = BOTH.map(|continuity| snap(&curves(&positions, &durations, continuity), &durations));
        assert!(printed <= joined * (1.0 + 1e-9), "{printed} {joined}");
    }

    #[test]
    fn equal_times_swing_out_where_segments_are_unlike_and_proportional_ones_less() {
        // A long leg, a short one across, and a long one on (H-A8).
        let path = Path::polyline(&[v(5.0, 40.0), v(35.0, 40.0), v(35.0, 42.0), v(65.0, 42.0)]);
        let grid = uninflated(&OccupancyGrid::empty(80, 80, 1.0));
        let made = |time_alloc| {
            Stage::new(&Params { time_alloc, check: Check::None, ..Params::default() }).treat(&grid, 0.25, &path)
        };
        let (equal, proportional) = (made(TimeAlloc::Equal), made(TimeAlloc::Proportional));
        assert!(equal.length() > proportional.length() && proportional.length() > 60.0);
        assert_eq!(equal.pieces(), made(TimeAlloc::Equal).pieces(), "the same bits");
    }

    #[test]
    fn times_take_the_length_by_the_speed_and_share_it_out() {
        let path = Path::polyline(&[v(5.0, 40.0), v(9.0, 40.0), v(9.0, 42.0)]);
        let grid = uninflated(&OccupancyGrid::empty(80, 80, 1.0));
        let times = |time_alloc| {
            let params = Params { time_alloc, speed_mps: Positive::new(0.5), ..Params::default() };
            Stage::new(&params).treat(&grid, 0.25, &path).times_s().to_vec()
        };
        assert_eq!(times(TimeAlloc::Equal), [6.0, 12.0]);
        let proportional = times(TimeAlloc::Proportional);
        assert!((proportional[0] - 8.0).abs() < 1e-12 && proportional[1] == 12.0, "{proportional:?}");
        // In the middle of the first segment by time the robot is as far as its polynomial at u = 1/2.
        let smooth = Stage::new(&Params::default()).treat(&grid, 0.25, &path);
        let Piece::Curve(curve) = &smooth.pieces()[0] else { panic!("a curve") };
        assert_eq!(smooth.point_at_time(1.5), Some(curve.point(0.5)));
        assert_eq!((smooth.point_at_time(0.0), smooth.point_at_time(6.0)), (Some(path.start()), Some(path.end())));
    }

    #[test]
    fn key_nodes_are_those_of_the_path_before_and_points_stay_points() {
        let grid = uninflated(&OccupancyGrid::empty(80, 80, 1.0));
        let path = Path::polyline(&[v(5.0, 40.0), v(9.0, 40.0), v(9.0, 42.0), v(20.0, 50.0)]);
        let mut nodes = Vec::new();
        Stage::new(&Params::default()).treat(&grid, 0.25, &path).key_nodes(&mut nodes);
        assert_eq!(nodes.iter().map(|node| node.position).collect::<Vec<_>>(), path.vertices().collect::<Vec<_>>());
        let point = Path::polyline(&[v(5.0, 40.0)]);
        assert_eq!(Stage::new(&Params::default()).treat(&grid, 0.25, &point), point);
        // Twice the same node is one.
        let twice = Path::polyline(&[v(5.0, 40.0), v(9.0, 40.0), v(9.0, 40.0), v(9.0, 42.0), v(9.0, 42.0)]);
        let once = Path::polyline(&[v(5.0, 40.0), v(9.0, 40.0), v(9.0, 42.0)]);
        let made = |path: &Path| Stage::new(&Params::default()).treat(&grid, 0.25, path);
        assert_eq!(made(&twice).pieces(), made(&once).pieces());
    }

    #[test]
    fn a_checked_curve_is_never_blocked_and_keeps_what_its_path_keeps() {
        let mut stream = stream(203);
        let (mut curved, mut mended, mut given_up, mut touched) = (0, 0, 0, 0);
        let mut planner = GlobalChoice::by_name("a_star").unwrap().build();
        for round in 0..200 {
            let map = random_map(&mut stream, 20, 0.2);
            let side_m = map.resolution_m();
            let inflation_m = if round % 2 == 0 { 0.0 } else { 0.45 * side_m };
            let field = DistanceField::new(&map);
            let grid = PlanningGrid::new(&map, &field, inflation_m);
            let (start, goal): (Cell, Cell) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
            let mut cells = Vec::new();
            let problem = Problem { grid: &grid, start, goal };
            if planner.as_grid().unwrap().search(&problem, &mut cells).result.is_err() || start == goal {
                continue;
            }
            let polyline = Path::polyline(&cells.iter().map(|&cell| grid.centre(cell)).collect::<Vec<_>>());
            let robot = crate::robot::Robot::default();
            let belief = crate::observation::Belief::from(&map);
            let pose = crate::geometry::Pose { position: polyline.start(), theta: 0.0 };
            let situation = crate::plan::contract::Situation::new(&robot, &belief, pose, polyline.end());
            let task = Task { situation: &situation, grid: &grid, start: polyline.start(), goal: polyline.end() };
            let pruned = farthest_visible::Params::default().build().apply(&task, &polyline).unwrap();
            let obstacles = Obstacles::new(&map, &field);
            let least = |path: &Path| {
                path.segments().fold(side_m, |least, (from, piece)| obstacles.piece_clearance(from, piece, least))
            };
            for path in [&polyline, &pruned] {
                for time_alloc in [TimeAlloc::Equal, TimeAlloc::Proportional] {
                    let radius_m = 0.3 * side_m;
                    let params = Params { time_alloc, ..Params::default() };
                    let made = Stage::new(&params).treat(&grid, radius_m, path);
                    assert_eq!((made.start(), made.end()), (path.start(), path.end()));
                    assert_eq!(made.times_s().len(), made.pieces().len());
                    let is_curve = made.pieces().iter().all(|piece| matches!(piece, Piece::Curve(_)));
                    curved += u32::from(is_curve);
                    mended += u32::from(is_curve && made.fallbacks() > 0);
                    given_up += u32::from(!is_curve);
                    let asked_m = if inflation_m > 0.0 { inflation_m } else { radius_m };
                    let needed_m = math::min(asked_m, least(path));
                    assert!(least(&made) >= needed_m - 0.011 * side_m, "{} {needed_m}", least(&made));
                    let plain = Stage::new(&Params { check: Check::None, ..params }).treat(&grid, radius_m, path);
                    touched += u32::from(least(&plain) < needed_m - 0.02 * side_m);
                    assert_eq!(plain.fallbacks(), 0);
                }
            }
        }
        assert!(curved > 100 && mended > 20 && given_up > 5 && touched > 50, "{curved} {mended} {given_up} {touched}");
    }
}
