//! `b_spline`: a uniform cubic B-spline over the nodes of a path: smooth in direction and curvature, inside every corner.
//!
//! Source: Zhu et al., "Path planning optimization of automated guided vehicles based on enhanced A* and dynamic window approach
//! fusion algorithms", 2025, eq. 9 and 10 (`zhu2025`). Four consecutive control points give the span
//!
//! ```text
//! P(t) = b0 P_i + b1 P_{i+1} + b2 P_{i+2} + b3 P_{i+3}                    t from 0 to 1
//! b0 = (1 − t)³ / 6,   b1 = t³/2 − t² + 2/3,   b2 = −t³/2 + t²/2 + t/2 + 1/6,   b3 = t³ / 6
//! ```
//!
//! which is, exactly, the cubic of Bézier with the control points (P_i + 4 P_{i+1} + P_{i+2}) / 6, (2 P_{i+1} + P_{i+2}) / 3,
//! (P_{i+1} + 2 P_{i+2}) / 3 and (P_{i+1} + 4 P_{i+2} + P_{i+3}) / 6. A span lies in the convex hull of its four points; spans
//! join with equal first and second derivative. The path is made of these cubics, and of lines where the points are in a line: nothing is
//! sampled. It is never longer than the polyline.
//!
//! Readings of the paper (ids of `systems.md`):
//! - U-A5: a uniform B-spline does not reach its ends; the first and the last control point count three times.
//! - U-A6: the paper checks nothing. By default (`check: fallback`) a span must keep from obstacles what the path beneath it keeps: the
//!   inflation, or as much as that path does, and without inflation the robot's radius (`clearance_m`). Where one does not, the
//!   middles of the legs beneath it become control points, up to three times, which halves its distance from the
//!   path each time; then its control points count three times each, which makes it the path itself. [`Path::fallbacks`]
//!   counts the spans of the plain spline that were mended. `check: none` is the printed form; a curve that leads
//!   deep into an obstacle is then an error of the plan.
//! - U-A7: no pruning is described: the control points are all nodes (`over: nodes`); `corners` takes those where the path turns.
//! - U-A20: key nodes are the points of the curve that belong to the corners of the path, and enough between them that none is
//!   farther than `node_spacing_m` from the next.
//!
//! Arcs and curves of a stage before stay; each run of lines between them becomes a spline of its own.

use super::{Check, PathKind, clearance_of_curves_m, curve_keeps};
use crate::geometry::curve::Curve;
use crate::geometry::{Path, Piece, Vec2, cross};
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, Failure, PathStage, Task};
use crate::settings::quantity::{NonNegative, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Times that an end, or a point at which the curve is to be the path itself, counts as a control point.
const TRIPLE: usize = 3;
/// Rounds of new control points in the middle of legs.
const ROUNDS: u32 = 3;
/// Turn below which a path goes straight on, rad: rounding makes less.
const STRAIGHT_RAD: f64 = 1e-9;

/// Control points of the spline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// Every node of the path: near to it.
    #[default]
    Nodes,
    /// Its ends and the nodes where it turns: wide and smooth.
    Corners,
}

/// Parameters of `b_spline`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// The control points. Default `nodes`.
    pub over: Over,
    /// What happens where the curve comes too near to an obstacle. Default `fallback`.
    pub check: Check,
    /// Distance that the curve keeps from blocked squares of the planning grid, m; larger falls back more often. Default: 0 with
    /// inflation, which it keeps from obstacles, else the robot's radius.
    pub clearance_m: Option<NonNegative>,
    /// Longest way along the path from one key node to the next, m. Default 5.
    pub node_spacing_m: Positive,
}

impl Default for Params {
    fn default() -> Self {
        Self { over: Over::Nodes, check: Check::Fallback, clearance_m: None, node_spacing_m: Positive::new(5.0) }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Smooths with a uniform cubic B-spline that keeps the path's clearance, or is drawn back to the path: never longer.",
    source: "Zhu, Tu, Shen, Yin, Zhang, Zhao, Chen, Path planning optimization of automated guided vehicles based on enhanced A* and dynamic window approach fusion algorithms, 2025, eq. 7 to 10",
    ..Entry::PLAIN
};

impl PathKind for Params {
    fn build(&self) -> Box<dyn PathStage> {
        Box::new(Stage::new(self))
    }
}

/// The stage. It has no state.
#[derive(Debug)]
pub struct Stage {
    params: Params,
}

/// A control point and how often it counts: once or [`TRIPLE`].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Control {
    position: Vec2,
    count: usize,
    /// Whether the path turns here.
    is_corner: bool,
}

/// A span: four control points of the spline, and the places of the inner two in the list of control points.
#[derive(Clone, Copy, Debug)]
struct Span {
    points: [Vec2; 4],
    inner: [usize; 2],
    /// Whether it begins at the point of the curve that belongs to the first of the inner two.
    is_node: bool,
}

impl Span {
    /// The control points of Bézier.
    fn bezier(&self) -> [Vec2; 4] {
        let [p, q, r, s] = self.points;
        // An end that counts three times is met exactly, whatever the rounding.
        let joint = |a: Vec2, b: Vec2, c: Vec2| if a == b && b == c { b } else { (a + 4.0 * b + c) / 6.0 };
        [joint(p, q, r), (2.0 * q + r) / 3.0, (q + 2.0 * r) / 3.0, joint(q, r, s)]
    }

    /// Whether its points are in a line, in order: then so is the span, on the path itself.
    fn is_straight(&self) -> bool {
        let [p, q, r, s] = self.points;
        let along = s - p;
        let goes_on = |step: Vec2| {
            step.dot(&along) >= 0.0 && cross(step, along).abs() <= STRAIGHT_RAD * step.norm() * along.norm()
        };
        goes_on(q - p) && goes_on(r - q) && goes_on(s - r)
    }

    /// Whether it keeps the inflation from obstacles and from movers that block cells, or as much as the path beneath it does, and
    /// `clearance_m` from blocked squares. On the path itself it may do what that does.
    fn keeps(&self, grid: &PlanningGrid, clearance_m: f64) -> bool {
        if self.is_straight() {
            return true;
        }
        let [p, q, r, s] = self.points;
        let legs = [(p, q), (q, r), (r, s)];
        let needed_m = legs.iter().map(|&(a, b)| grid.clearance(a, b)).fold(grid.inflation_m(), math::min);
        let curve = Curve::bezier(self.bezier());
        curve_keeps(&curve, grid, needed_m, clearance_m, [p, s])
    }
}

/// The spans of the spline with these control points.
fn spans(controls: &[Control]) -> Vec<Span> {
    let repeated = controls.iter().enumerate().flat_map(|(at, control)| {
        (0..control.count).map(move |k| (control.position, at, control.is_corner && k == control.count / 2))
    });
    let all: Vec<(Vec2, usize, bool)> = repeated.collect();
    let span = |four: &[(Vec2, usize, bool)]| Span {
        points: [four[0].0, four[1].0, four[2].0, four[3].0],
        inner: [four[1].1, four[2].1],
        is_node: four[1].2,
    };
    all.windows(4).map(span).collect()
}

impl Stage {
    /// A fresh stage.
    pub fn new(params: &Params) -> Self {
        Self { params: params.clone() }
    }

    /// The control points for a run of lines through `nodes`.
    fn controls(&self, nodes: &[Vec2]) -> Vec<Control> {
        let mut controls: Vec<Control> = Vec::with_capacity(nodes.len());
        let last = nodes.len() - 1;
        for (at, &position) in nodes.iter().enumerate() {
            let is_end = at == 0 || at == last;
            let is_corner = !is_end && {
                let (arriving, leaving) = (position - nodes[at - 1], nodes[at + 1] - position);
                let slack = STRAIGHT_RAD * arriving.norm() * leaving.norm();
                cross(arriving, leaving).abs() > slack || arriving.dot(&leaving) < 0.0
            };
            if is_end || is_corner || self.params.over == Over::Nodes {
                controls.push(Control { position, count: if is_end { TRIPLE } else { 1 }, is_corner });
            }
        }
        controls
    }

    /// Adds control points until every span keeps its distance; returns how many spans of the plain spline did not.
    fn mend(controls: &mut Vec<Control>, grid: &PlanningGrid, clearance_m: f64) -> u32 {
        let breaks = |controls: &[Control]| -> Vec<[usize; 2]> {
            let spans = spans(controls).into_iter();
            spans.filter(|span| !span.keeps(grid, clearance_m)).map(|span| span.inner).collect()
        };
        let mut broken = breaks(controls);
        let count = broken.len() as u32;
        for _ in 0..ROUNDS {
            if broken.is_empty() {
                return count;
            }
            // The legs beside the inner points, from the back so that places stay valid.
            let mut legs: Vec<usize> = broken.iter().flat_map(|&[q, r]| q.saturating_sub(1)..(r + 1)).collect();
            legs.sort_unstable();
            legs.dedup();
            legs.retain(|leg| leg + 1 < controls.len());
            for &leg in legs.iter().rev() {
                let position = 0.5 * (controls[leg].position + controls[leg + 1].position);
                controls.insert(leg + 1, Control { position, count: 1, is_corner: false });
            }
            broken = breaks(controls);
        }
        // Each round triples a point that counted once: a span between two that count three times is a line.
        while !broken.is_empty() {
            for &at in broken.iter().flatten() {
                controls[at].count = TRIPLE;
            }
            broken = breaks(controls);
        }
        count
    }

    /// The path as this stage makes it on `grid` for a robot of `radius_m`.
    fn treat(&self, grid: &PlanningGrid, radius_m: f64, path: &Path) -> Path {
        let clearance_m = clearance_of_curves_m(self.params.clearance_m, grid, radius_m);
        let mut smooth = Smooth { at: path.start(), ..Smooth::default() };
        let mut fallbacks = 0;
        let mut run = vec![path.start()];
        let mut close = |run: &mut Vec<Vec2>, smooth: &mut Smooth| {
            if run.len() > 1 {
                let mut controls = self.controls(run);
                if self.params.check == Check::Fallback {
                    fallbacks += Self::mend(&mut controls, grid, clearance_m);
                }
                for span in spans(&controls) {
                    smooth.span(&span);
                }
            }
            run.clear();
        };
        for (_, piece) in path.segments() {
            match piece {
                Piece::Line { to } => {
                    if run.last() != Some(to) {
                        run.push(*to);
                    }
                }
                Piece::Arc { .. } | Piece::Curve(_) => {
                    close(&mut run, &mut smooth);
                    smooth.node();
                    smooth.push(piece.clone());
                    smooth.node();
                    run.push(piece.end());
                }
            }
        }
        close(&mut run, &mut smooth);
        smooth.finish(path, self.params.node_spacing_m.get()).with_fallbacks(fallbacks)
    }
}

/// The new path while it is made.
#[derive(Debug, Default)]
struct Smooth {
    pieces: Vec<Piece>,
    /// Where it ends so far, and where its last piece begins.
    at: Vec2,
    before: Vec2,
    length_m: f64,
    /// Places of the key nodes between the ends, m.
    nodes_m: Vec<f64>,
}

impl Smooth {
    fn node(&mut self) {
        self.nodes_m.push(self.length_m);
    }

    fn push(&mut self, piece: Piece) {
        self.length_m += piece.length(self.at);
        self.before = self.at;
        self.at = piece.end();
        self.pieces.push(piece);
    }

    fn span(&mut self, span: &Span) {
        if span.is_node {
            self.node();
        }
        let bezier = span.bezier();
        let [from, .., to] = bezier;
        if !span.is_straight() {
            self.push(Piece::Curve(Box::new(Curve::bezier(bezier))));
        } else if from != to {
            // Straight spans one after the other are one line, if no node is between them.
            let arriving = from - self.before;
            let goes_on = matches!(self.pieces.last(), Some(Piece::Line { .. }))
                && arriving.dot(&(to - from)) > 0.0
                && cross(arriving, to - from).abs() <= STRAIGHT_RAD * arriving.norm() * (to - from).norm();
            if goes_on {
                self.pieces.pop();
                self.length_m -= arriving.norm();
                self.at = self.before;
            }
            self.push(Piece::Line { to });
        }
    }

    /// The path, with key nodes at its ends and at most `spacing_m` apart.
    fn finish(mut self, path: &Path, spacing_m: f64) -> Path {
        let smooth = Path::new(path.start(), self.pieces);
        self.nodes_m.push(smooth.length());
        let (mut nodes_m, mut from_m) = (vec![0.0], 0.0);
        for to_m in self.nodes_m {
            let parts = ((to_m - from_m) / spacing_m).ceil() as u32;
            nodes_m.extend((1..=parts).map(|k| from_m + (to_m - from_m) * f64::from(k) / f64::from(parts)));
            from_m = to_m;
        }
        smooth.with_key_nodes_at(&nodes_m)
    }
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
    use crate::geometry::KeyNode;
    use crate::map::{DistanceField, OccupancyGrid};
    use crate::plan::clearance::Obstacles;
    use crate::plan::contract::Problem;
    use crate::plan::global::GlobalChoice;
    use crate::plan::grid::tests::{random_cell, random_map, stream, uninflated};

    fn v(x: f64, y: f64) -> Vec2 {
        Vec2::new(x, y)
    }

    fn open() -> PlanningGrid {
        uninflated(&OccupancyGrid::empty(80, 80, 1.0))
    }

    fn smoothed(params: &Params, grid: &PlanningGrid, path: &Path) -> Path {
        Stage::new(params).treat(grid, 0.25, path)
    }

    fn key_nodes(path: &Path) -> Vec<KeyNode> {
        let mut nodes = Vec::new();
        path.key_nodes(&mut nodes);
        nodes
    }

    /// A walk over cells that turns at random by up to a right angle.
    fn random_walk(seed: u64) -> Vec<Vec2> {
        let mut stream = stream(seed);
        let steps = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];
        let (mut heading, mut nodes) = (0usize, vec![v(40.5, 40.5)]);
        while nodes.len() < 30 {
            let (dx, dy) = steps[heading % 8];
            let next = nodes[nodes.len() - 1] + v(f64::from(dx), f64::from(dy));
            heading = (heading + 6 + stream.index(5)) % 8;
            nodes.push(next);
        }
        nodes
    }

    #[test]
    fn a_span_has_the_basis_values_worked_by_hand() {
        // b at t = 0: 1/6, 4/6, 1/6, 0; at 1/2: 1/48, 23/48, 23/48, 1/48; at 1: 0, 1/6, 4/6, 1/6.
        let basis = [(0.0, [8.0, 32.0, 8.0, 0.0]), (0.5, [1.0, 23.0, 23.0, 1.0]), (1.0, [0.0, 8.0, 32.0, 8.0])];
        for number in 0..4 {
            let mut points = [v(0.0, 0.0); 4];
            points[number] = v(1.0, -2.0);
            let curve = Curve::bezier(Span { points, inner: [0, 0], is_node: false }.bezier());
            for (t, values) in basis {
                let expected = v(1.0, -2.0) * (values[number] / 48.0);
                assert!((curve.point(t) - expected).norm() < 1e-15, "b{number} at {t}");
            }
            // Eq. 9 at other places.
            for t in [0.1, 0.3, 0.9] {
                let (t2, t3) = (t * t, t * t * t);
                let values = [
                    -t3 / 6.0 + t2 / 2.0 - t / 2.0 + 1.0 / 6.0,
                    t3 / 2.0 - t2 + 2.0 / 3.0,
                    -t3 / 2.0 + t2 / 2.0 + t / 2.0 + 1.0 / 6.0,
                    t3 / 6.0,
                ];
                assert!((curve.point(t) - v(1.0, -2.0) * values[number]).norm() < 1e-15, "b{number} at {t}");
            }
        }
    }

    #[test]
    fn spans_join_with_equal_first_and_second_derivatives() {
        for seed in 0..20 {
            let stage = Stage::new(&Params::default());
            let spans: Vec<Curve> =
                spans(&stage.controls(&random_walk(seed))).iter().map(|span| Curve::bezier(span.bezier())).collect();
            // One-sided differences: of a cubic the second is exact but for rounding, the first wrong by h²/3 times the third.
            let h = 1e-3;
            for pair in spans.windows(2) {
                let (before, after) = (|t: f64| pair[0].point(1.0 - t), |t: f64| pair[1].point(t));
                assert!((before(0.0) - after(0.0)).norm() < 1e-12);
                let first = |p: &dyn Fn(f64) -> Vec2| (-3.0 * p(0.0) + 4.0 * p(h) - p(2.0 * h)) / (2.0 * h);
                assert!((first(&before) + first(&after)).norm() < 1e-5);
                let second =
                    |p: &dyn Fn(f64) -> Vec2| (2.0 * p(0.0) - 5.0 * p(h) + 4.0 * p(2.0 * h) - p(3.0 * h)) / (h * h);
                assert!((second(&before) - second(&after)).norm() < 1e-5);
            }
        }
    }

    #[test]
    fn the_path_is_smooth_in_direction_and_curvature_ends_where_it_should_and_is_no_longer() {
        for seed in 20..40 {
            let polyline = Path::polyline(&random_walk(seed));
            for over in [Over::Nodes, Over::Corners] {
                let path = smoothed(&Params { over, ..Params::default() }, &open(), &polyline);
                assert_eq!((path.start(), path.end()), (polyline.start(), polyline.end()));
                assert_eq!(path.fallbacks(), 0);
                assert!(path.length() <= polyline.length() + 1e-9);
                // No corner between two pieces, and none in the curvature where both are curves.
                let segments: Vec<(Vec2, &Piece)> = path.segments().collect();
                for pair in segments.windows(2) {
                    let tangents = |k: usize| pair[k].1.tangents(pair[k].0).expect("a piece with a length");
                    let (before, after) = (tangents(0).1.normalize(), tangents(1).0.normalize());
                    assert!((before - after).norm() < 1e-6, "{over:?} {pair:?}");
                    if let [(_, Piece::Curve(before)), (_, Piece::Curve(after))] = pair {
                        assert!((before.curvature(1.0) - after.curvature(0.0)).abs() < 1e-6);
                    }
                }
            }
        }
    }

    #[test]
    fn every_span_lies_in_the_convex_hull_of_its_four_points() {
        for seed in 40..60 {
            for span in spans(&Stage::new(&Params::default()).controls(&random_walk(seed))) {
                let curve = Curve::bezier(span.bezier());
                for k in 0..=16 {
                    let p = curve.point(f64::from(k) / 16.0);
                    // A point is in the hull if no direction parts it from all four.
                    for degrees in 0..360 {
                        let axis = crate::geometry::direction(f64::from(degrees).to_radians());
                        let farthest = span.points.iter().map(|q| q.dot(&axis)).fold(f64::NEG_INFINITY, math::max);
                        assert!(p.dot(&axis) <= farthest + 1e-12);
                    }
                }
            }
        }
    }

    #[test]
    fn a_straight_path_stays_straight_and_short_ones_stay() {
        let straight: Vec<Vec2> = (0..13).map(|k| v(2.5 + f64::from(k), 7.5)).collect();
        for over in [Over::Nodes, Over::Corners] {
            let path = smoothed(&Params { over, ..Params::default() }, &open(), &Path::polyline(&straight));
            assert_eq!(path.pieces(), [Piece::Line { to: v(14.5, 7.5) }]);
            // 12 m in parts of at most 5 m.
            let along: Vec<f64> = key_nodes(&path).iter().map(|node| node.along_m).collect();
            assert_eq!(along, [0.0, 4.0, 8.0, 12.0]);
        }
        let short = Path::polyline(&[v(1.0, 1.0), v(2.0, 3.0)]);
        assert_eq!(smoothed(&Params::default(), &open(), &short).pieces(), short.pieces());
        let point = Path::polyline(&[v(1.0, 1.0)]);
        let still = smoothed(&Params::default(), &open(), &point);
        assert!(still.pieces().is_empty() && still.start() == v(1.0, 1.0));
    }

    #[test]
    fn key_nodes_are_the_points_of_the_curve_at_the_corners() {
        // A corner between legs of 3 m in steps of 1 m: the curve passes at (P0 + 4 P1 + P2) / 6.
        let corner = [v(1.5, 1.5), v(2.5, 1.5), v(3.5, 1.5), v(4.5, 1.5), v(4.5, 2.5), v(4.5, 3.5), v(4.5, 4.5)];
        let path = smoothed(&Params::default(), &open(), &Path::polyline(&corner));
        let nodes = key_nodes(&path);
        assert_eq!(nodes.len(), 3);
        assert!((nodes[1].position - v(4.5 - 1.0 / 6.0, 1.5 + 1.0 / 6.0)).norm() < 1e-12);
        assert!((nodes[1].along_m - 0.5 * path.length()).abs() < 1e-9);
        assert!((nodes[2].along_m - path.length()).abs() < 1e-12);
        let dense = smoothed(
            &Params { node_spacing_m: Positive::new(1.0), ..Params::default() },
            &open(),
            &Path::polyline(&corner),
        );
        assert!(key_nodes(&dense).windows(2).all(|two| two[1].along_m - two[0].along_m <= 1.0 + 1e-12));
    }

    #[test]
    fn a_corner_without_room_is_drawn_to_the_path_and_counted() {
        // Inside the corner of a path along cells' centres stands a square, 0.5 m from both legs. From its corner the curve is
        // √((1/2 − b2 − 2 b3)² + (1/2 − b0)²) away: at least 0.465296, by eq. 9 at a million places.
        let map = OccupancyGrid::from_ascii(&["....", ".##.", ".##.", "...."], 1.0);
        let nodes: Vec<Vec2> = [(0.5, 3.5), (0.5, 2.5), (0.5, 1.5), (0.5, 0.5), (1.5, 0.5), (2.5, 0.5), (3.5, 0.5)]
            .map(|(x, y)| v(x, y))
            .to_vec();
        let field = DistanceField::new(&map);
        let grid = PlanningGrid::new(&map, &field, 0.48);
        let clearance = |path: &Path| {
            let obstacles = grid.obstacles().unwrap();
            let points =
                path.segments().flat_map(|(from, piece)| (0..=200).map(move |k| piece.chord_point(from, k, 200)));
            points.fold(1.0, |least, p| obstacles.clearance(p, least))
        };
        let plain = smoothed(&Params { check: Check::None, ..Params::default() }, &grid, &Path::polyline(&nodes));
        assert!((clearance(&plain) - 0.465_296).abs() < 1e-5 && plain.fallbacks() == 0, "{}", clearance(&plain));
        let mended = smoothed(&Params::default(), &grid, &Path::polyline(&nodes));
        // Both spans at the corner's point; a round of middles is enough.
        assert!(clearance(&mended) >= 0.48 - 1e-6, "{}", clearance(&mended));
        assert_eq!(mended.fallbacks(), 2);
        assert!(mended.pieces().iter().any(|piece| matches!(piece, Piece::Curve(_))));
        // Half a metre is what the path has: the curve leaves it where the square ends, and not before.
        let half = PlanningGrid::new(&map, &field, 0.5);
        let path = smoothed(&Params::default(), &half, &Path::polyline(&nodes));
        assert_eq!(path.pieces()[0], Piece::Line { to: v(0.5, 1.0) });
        // Round the very corner of the square nothing but the path will do.
        let tight = PlanningGrid::new(&map, &field, 0.1);
        let nodes = [(0.9, 2.9), (0.9, 1.9), (0.9, 0.9), (1.9, 0.9), (2.9, 0.9)].map(|(x, y)| v(x, y));
        let path = smoothed(&Params::default(), &tight, &Path::polyline(&nodes));
        assert_eq!(path.pieces(), [Piece::Line { to: nodes[2] }, Piece::Line { to: nodes[4] }]);
        assert!(path.fallbacks() >= 2);
    }

    #[test]
    fn a_checked_curve_is_never_blocked_and_keeps_what_its_path_keeps() {
        let mut stream = stream(91);
        let (mut curves, mut mended, mut touched) = (0, 0, 0);
        for round in 0..300 {
            let map = random_map(&mut stream, 20, 0.2);
            let side_m = map.resolution_m();
            let inflation_m = if round % 2 == 0 { 0.0 } else { 0.45 * side_m };
            let grid = PlanningGrid::new(&map, &DistanceField::new(&map), inflation_m);
            let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
            let mut cells = Vec::new();
            let problem = Problem { grid: &grid, start, goal };
            let mut planner = GlobalChoice::by_name("a_star").unwrap().build();
            if planner.as_grid().unwrap().search(&problem, &mut cells).result.is_err() {
                continue;
            }
            let polyline = Path::polyline(&cells.iter().map(|&cell| grid.centre(cell)).collect::<Vec<_>>());
            let whole = DistanceField::new(&map);
            let obstacles = Obstacles::new(&map, &whole);
            let least = |path: &Path| {
                path.segments().fold(side_m, |least, (from, piece)| obstacles.piece_clearance(from, piece, least))
            };
            for over in [Over::Nodes, Over::Corners] {
                let radius_m = 0.3 * side_m;
                let path = Stage::new(&Params { over, ..Params::default() }).treat(&grid, radius_m, &polyline);
                curves += path.pieces().iter().filter(|piece| matches!(piece, Piece::Curve(_))).count();
                mended += path.fallbacks();
                let asked_m = if inflation_m > 0.0 { inflation_m } else { radius_m };
                let needed_m = math::min(asked_m, least(&polyline));
                // Chords: ours stay within 1e-3 cells, those of the test within 1e-2.
                assert!(least(&path) >= needed_m - 0.01 * side_m, "{} {needed_m}", least(&path));
                assert!(path.length() <= polyline.length() + 1e-9);
                let plain = Stage::new(&Params { over, check: Check::None, ..Params::default() })
                    .treat(&grid, radius_m, &polyline);
                touched += u32::from(least(&plain) < needed_m - 0.02 * side_m);
            }
        }
        assert!(curves > 1000 && mended > 100 && touched > 20, "{curves} {mended} {touched}");
    }

    #[test]
    fn arcs_of_a_stage_before_stay() {
        let arc = Piece::Arc { to: v(6.0, 6.0), centre: v(5.0, 6.0), sweep: math::FRAC_PI_2 };
        let pieces = vec![
            Piece::Line { to: v(5.0, 5.0) },
            arc.clone(),
            Piece::Line { to: v(6.0, 8.0) },
            Piece::Line { to: v(8.0, 9.0) },
        ];
        let path = smoothed(&Params::default(), &open(), &Path::new(v(2.0, 5.0), pieces));
        assert_eq!(path.pieces()[..2], [Piece::Line { to: v(5.0, 5.0) }, arc]);
        assert_eq!(path.end(), v(8.0, 9.0));
        assert!(path.pieces().iter().any(|piece| matches!(piece, Piece::Curve(_))));
    }
}
