//! `arc_fillet`: rounds the corners of a path with circular arcs tangent to both legs.
//!
//! Source: circular arc smoothing of Gao, Zhang, Liu, Ou, Cheng, Zhu, the ImpA*-ImpDWA paper, AIMS Press, 2025,
//! eq. 11–18 (`gao2025`), in a vector form that holds for every orientation (G-A10). For consecutive nodes P0, P1, P2:
//!
//! ```text
//! u1 = P0P1 / |P0P1|,  u2 = P1P2 / |P1P2|,  φ = angle from u1 to u2           the deflection, 0: straight on
//! t  = R tan(φ / 2)                                                        tangent length, eq. 14 (G-A8)
//! A  = P1 − t u1,  B = P1 + t u2,  C = A + R n                             n: u1 turned a quarter to the inside
//! ```
//!
//! and P1 gives way to the arc from A to B about C, which turns by φ. It does so where the interior angle
//! π − φ is at least 90° and the arc keeps the clearance r from every blocked square; else the corner stays.
//!
//! Departures and choices:
//! - Neither R nor r is given: 1 m and 0.3 m.
//! - Where t is longer than half of the shorter leg, R shrinks until it is as long, so that the arcs of neighbouring
//!   corners cannot overlap.
//! - G-A9: the paper's condition on a distance "l_AC" that only a figure defines is read as the clearance of the
//!   arc. It is computed exactly, along the whole arc, to 1e-9 m; with r = 0 the arc must not touch a square.
//! - The result is lines and arcs, not samples of them; both ends of an arc are key nodes. Arcs of a stage before
//!   stay, and so do the corners beside them.
//! - An arc keeps the inflation from obstacles as well, or as much as the corner that it replaces.
//!
//! A fillet is never longer than the corner it replaces: R φ ≤ 2 t.

use super::PathKind;
use crate::geometry::{Path, Piece, Rect, Vec2, cross};
use crate::map::Cell;
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Entry, Failure, PathStage, Task};
use crate::settings::quantity::{NonNegative, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Slack of comparisons between angles (rad) and between lengths (m): rounding error of a right angle or an
/// exact clearance.
const SLACK: f64 = 1e-9;

/// Parameters of `arc_fillet`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// R: radius of the arcs, m; smaller where a leg is too short. Larger turns gentler and cuts more of the corner.
    /// Default 1.
    pub radius_m: Positive,
    /// r: distance that an arc must keep from blocked squares of the planning grid, m. Default 0.3.
    pub clearance_m: NonNegative,
}

impl Default for Params {
    fn default() -> Self {
        Self { radius_m: Positive::new(1.0), clearance_m: NonNegative::new(0.3) }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Rounds obtuse corners with arcs tangent to both legs where they keep a clearance: never longer.",
    source: "circular arc smoothing of Gao, Zhang, Liu, Ou, Cheng, Zhu, ImpA*-ImpDWA, AIMS Press, 2025, eq. 11 to 18",
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
    radius_m: f64,
    clearance_m: f64,
}

impl Stage {
    /// A fresh stage.
    pub fn new(params: &Params) -> Self {
        Self { radius_m: params.radius_m.get(), clearance_m: params.clearance_m.get() }
    }

    /// The arc that replaces the corner `p1` between `p0` and `p2`, if there is one.
    fn fillet(&self, grid: &PlanningGrid, p0: Vec2, p1: Vec2, p2: Vec2) -> Option<Arc> {
        let (first, second) = (p1 - p0, p2 - p1);
        let half_leg_m = 0.5 * math::min(first.norm(), second.norm());
        if half_leg_m == 0.0 {
            return None;
        }
        let (u1, u2) = (first.normalize(), second.normalize());
        let turn = math::atan2(cross(u1, u2), u1.dot(&u2));
        if turn.abs() <= SLACK || turn.abs() > math::FRAC_PI_2 + SLACK {
            return None;
        }
        let slope = math::tan(0.5 * turn.abs());
        let tangent_m = math::min(self.radius_m * slope, half_leg_m);
        let radius_m = tangent_m / slope;
        let inside = math::sign(turn) * Vec2::new(-u1.y, u1.x);
        let from = p1 - tangent_m * u1;
        let arc = Arc { from, to: p1 + tangent_m * u2, centre: from + radius_m * inside, radius_m, sweep: turn };
        (arc.keeps_clear(grid, self.clearance_m) && arc.keeps_inflation(grid, p1)).then_some(arc)
    }
}

impl PathStage for Stage {
    fn apply(&mut self, task: &Task<'_>, path: &Path) -> Result<Path, Failure> {
        Ok(self.treat(task.grid, path))
    }
}

impl Stage {
    /// The path as this stage makes it on `grid`.
    fn treat(&mut self, grid: &PlanningGrid, path: &Path) -> Path {
        let mut pieces: Vec<Piece> = Vec::with_capacity(2 * path.pieces().len());
        let mut at = path.start();
        let mut segments = path.segments().peekable();
        while let Some((from, piece)) = segments.next() {
            let next = segments.peek().map(|&(_, next)| next);
            let fillet = match (piece, next) {
                (&Piece::Line { to }, Some(&Piece::Line { to: beyond })) => self.fillet(grid, from, to, beyond),
                _ => None,
            };
            match fillet {
                Some(arc) => {
                    // Nothing is left of the leg where two arcs meet in its middle.
                    if (arc.from - at).norm() > SLACK {
                        pieces.push(Piece::Line { to: arc.from });
                    }
                    pieces.push(Piece::Arc { to: arc.to, centre: arc.centre, sweep: arc.sweep });
                    at = arc.to;
                }
                None => {
                    pieces.push(piece.clone());
                    at = piece.end();
                }
            }
        }
        Path::new(path.start(), pieces)
    }
}

/// A circular arc of at most a quarter turn.
#[derive(Clone, Copy, Debug)]
struct Arc {
    from: Vec2,
    to: Vec2,
    centre: Vec2,
    radius_m: f64,
    sweep: f64,
}

impl Arc {
    /// Whether no blocked square, nor the border, is nearer than `clearance_m`.
    fn keeps_clear(&self, grid: &PlanningGrid, clearance_m: f64) -> bool {
        let side_m = grid.resolution_m();
        let bounds = self.bounds();
        // One more on either side: rounding must not lose a line of cells. Beyond the border all is blocked.
        let first = |low: f64| ((low - clearance_m) / side_m).floor() as i32 - 1;
        let last = |high: f64| ((high + clearance_m) / side_m).floor() as i32 + 1;
        let cols = first(bounds.min.x).max(-1)..=last(bounds.max.x).min(grid.cols());
        let rows = first(bounds.min.y).max(-1)..=last(bounds.max.y).min(grid.rows());
        rows.flat_map(|row| cols.clone().map(move |col| Cell { col, row })).all(|cell| {
            grid.is_passable(cell) || {
                let min = side_m * Vec2::new(f64::from(cell.col), f64::from(cell.row));
                let distance_m = self.distance(Rect { min, max: min + Vec2::new(side_m, side_m) });
                if clearance_m > 0.0 { distance_m >= clearance_m - SLACK } else { distance_m > 0.0 }
            }
        })
    }

    /// Whether the arc keeps the inflation from obstacle squares, or as much as the corner `p1` that it replaces does.
    fn keeps_inflation(&self, grid: &PlanningGrid, p1: Vec2) -> bool {
        let Some(obstacles) = grid.obstacles() else { return true };
        let needed_m = math::min(grid.clearance(self.from, p1), grid.clearance(p1, self.to));
        let side_m = grid.resolution_m();
        let bounds = self.bounds();
        let first = |low: f64| ((low - needed_m) / side_m).floor() as i32 - 1;
        let last = |high: f64| ((high + needed_m) / side_m).floor() as i32 + 1;
        let cols = first(bounds.min.x).max(-1)..=last(bounds.max.x).min(grid.cols());
        let rows = first(bounds.min.y).max(-1)..=last(bounds.max.y).min(grid.rows());
        let keeps_off_squares = rows.flat_map(|row| cols.clone().map(move |col| Cell { col, row })).all(|cell| {
            !obstacles.is_occupied(cell) || {
                let min = side_m * Vec2::new(f64::from(cell.col), f64::from(cell.row));
                let distance_m = self.distance(Rect { min, max: min + Vec2::new(side_m, side_m) });
                distance_m > 0.0 && distance_m >= needed_m - SLACK
            }
        });
        let piece = Piece::Arc { to: self.to, centre: self.centre, sweep: self.sweep };
        let chords = piece.chord_count(self.from, 0.01 * side_m, 1e4);
        let at = |k: u32| piece.chord_point(self.from, k, chords);
        keeps_off_squares && (0..chords).all(|k| grid.passes_movers_between(at(k), at(k + 1), self.from, self.to))
    }

    /// Distance to a square, 0 where they touch.
    ///
    /// Where they are apart, the nearest points are a corner of the square and a point of the arc, an end of the
    /// arc and a point of the square, or lie on one line with the centre across an edge.
    fn distance(&self, square: Rect) -> f64 {
        if self.crosses(square) {
            return 0.0;
        }
        let Rect { min, max } = square;
        let corners = [min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)];
        let from_corners = corners.map(|corner| self.distance_to_point(corner));
        let from_arc = self.outermost().map(|point| math::max(square.signed_distance(point), 0.0));
        from_corners.into_iter().chain(from_arc).fold(f64::INFINITY, math::min)
    }

    /// Whether the arc meets one of the square's edges.
    fn crosses(&self, square: Rect) -> bool {
        let Rect { min, max } = square;
        let c = self.centre;
        // Where the circle meets a line at this distance from the centre: so far to either side.
        let half_chord = |offset: f64| {
            let squared = self.radius_m * self.radius_m - offset * offset;
            (squared >= 0.0).then(|| squared.sqrt())
        };
        let on_upright = [min.x, max.x].into_iter().filter_map(|x| half_chord(x - c.x).map(|half| (x, half)));
        let on_level = [min.y, max.y].into_iter().filter_map(|y| half_chord(y - c.y).map(|half| (y, half)));
        let mut upright = on_upright.flat_map(|(x, half)| [Vec2::new(x, c.y - half), Vec2::new(x, c.y + half)]);
        let mut level = on_level.flat_map(|(y, half)| [Vec2::new(c.x - half, y), Vec2::new(c.x + half, y)]);
        upright.any(|p| p.y >= min.y && p.y <= max.y && self.spans(p))
            || level.any(|p| p.x >= min.x && p.x <= max.x && self.spans(p))
    }

    /// Whether the direction from the centre to `p` lies within the arc.
    fn spans(&self, p: Vec2) -> bool {
        let (r, q) = (self.from - self.centre, p - self.centre);
        let turn = math::atan2(cross(r, q), r.dot(&q)) * math::sign(self.sweep);
        turn >= 0.0 && turn <= self.sweep.abs()
    }

    fn distance_to_point(&self, p: Vec2) -> f64 {
        if self.spans(p) {
            ((p - self.centre).norm() - self.radius_m).abs()
        } else {
            math::min((p - self.from).norm(), (p - self.to).norm())
        }
    }

    /// Both ends, and the points farthest east, north, west and south of the circle if they are on the arc.
    fn outermost(&self) -> impl Iterator<Item = Vec2> + '_ {
        let directions = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
        let points = directions.map(|(x, y)| self.centre + self.radius_m * Vec2::new(x, y));
        [self.from, self.to].into_iter().chain(points.into_iter().filter(|&p| self.spans(p)))
    }

    fn bounds(&self) -> Rect {
        self.outermost().fold(Rect { min: self.from, max: self.from }, |Rect { min, max }, p| Rect {
            min: Vec2::new(math::min(min.x, p.x), math::min(min.y, p.y)),
            max: Vec2::new(math::max(max.x, p.x), math::max(max.y, p.y)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::direction;
    use crate::math::{FRAC_PI_2, PI, SQRT_2};
    use crate::plan::contract::Problem;
    use crate::plan::global::GlobalChoice;
    use crate::plan::grid::tests::{random_cell, random_map, stream, uninflated};

    fn stage(radius_m: f64, clearance_m: f64) -> Stage {
        Stage::new(&Params { radius_m: Positive::new(radius_m), clearance_m: NonNegative::new(clearance_m) })
    }

    fn open() -> PlanningGrid {
        uninflated(&crate::map::OccupancyGrid::empty(40, 40, 1.0))
    }

    fn path(numbers: &[(f64, f64)]) -> Path {
        Path::polyline(&numbers.iter().map(|&(x, y)| Vec2::new(x, y)).collect::<Vec<_>>())
    }

    fn close(a: Vec2, b: Vec2) -> bool {
        (a - b).norm() < 1e-12
    }

    #[test]
    fn a_right_angle_gets_a_quarter_circle() {
        // t = R tan 45° = 1: from (4, 1) to (5, 2) about (4, 2); 10 m of legs become 8 + π/2.
        let rounded = stage(1.0, 0.3).treat(&open(), &path(&[(1.0, 1.0), (5.0, 1.0), (5.0, 7.0)]));
        let [Piece::Line { to: a }, Piece::Arc { to: b, centre, sweep }, Piece::Line { to: end }] = *rounded.pieces()
        else {
            panic!("{rounded:?}")
        };
        assert!(close(a, Vec2::new(4.0, 1.0)) && close(b, Vec2::new(5.0, 2.0)) && close(centre, Vec2::new(4.0, 2.0)));
        assert!((sweep - FRAC_PI_2).abs() < 1e-12 && end == Vec2::new(5.0, 7.0));
        assert!((rounded.length() - (8.0 + FRAC_PI_2)).abs() < 1e-12);
    }

    #[test]
    fn half_a_right_angle_to_the_right_turns_clockwise() {
        // t = tan 22.5° = √2 − 1; the arc is R π/4 long and lies south of the corner.
        let rounded = stage(1.0, 0.3).treat(&open(), &path(&[(2.0, 8.0), (5.0, 8.0), (9.0, 4.0)]));
        let Piece::Arc { centre, sweep, .. } = rounded.pieces()[1] else { panic!("{rounded:?}") };
        assert!((sweep + PI / 4.0).abs() < 1e-12 && close(centre, Vec2::new(5.0 - (SQRT_2 - 1.0), 7.0)));
        assert!((rounded.length() - (3.0 + 4.0 * SQRT_2 - 2.0 * (SQRT_2 - 1.0) + PI / 4.0)).abs() < 1e-12);
    }

    #[test]
    fn corners_sharper_than_a_right_angle_stay_and_so_do_ends_and_straight_lines() {
        for kept in [
            path(&[(2.0, 2.0), (9.0, 2.0), (8.9, 9.0)]), // interior angle a little below 90°
            path(&[(2.0, 2.0), (9.0, 2.0), (3.0, 2.0)]),
            path(&[(2.0, 2.0), (5.0, 2.0), (9.0, 2.0)]),
            path(&[(2.0, 2.0), (5.0, 2.0)]),
            path(&[(2.0, 2.0)]),
        ] {
            assert_eq!(stage(1.0, 0.3).treat(&open(), &kept), kept);
        }
    }

    #[test]
    fn the_radius_shrinks_until_the_tangents_fit_into_half_of_each_leg() {
        // Legs 4, 1, 4: t = 0.5 = R tan 45°, so both arcs have R = 0.5 and meet in the middle of the short leg.
        let rounded = stage(1.0, 0.3).treat(&open(), &path(&[(2.0, 5.0), (6.0, 5.0), (6.0, 6.0), (10.0, 6.0)]));
        let [_, Piece::Arc { to: middle, .. }, Piece::Arc { centre, .. }, _] = *rounded.pieces() else {
            panic!("{rounded:?}")
        };
        assert!(close(middle, Vec2::new(6.0, 5.5)) && close(centre, Vec2::new(6.5, 5.5)));
        assert!((rounded.length() - (7.0 + PI / 2.0)).abs() < 1e-12); // 3.5 + 3.5 + 2 · 0.5 · π/2
    }

    #[test]
    fn the_clearance_of_an_arc_is_taken_where_it_comes_nearest() {
        // The block is x 3 to 4, y 4 to 5, inside the turn. R = 1: C = (4, 5), so the arc keeps exactly 1 from that
        // corner of the block.
        let mut map = crate::map::OccupancyGrid::empty(12, 12, 1.0);
        map.set_occupied(Cell { col: 3, row: 4 });
        let grid = uninflated(&map);
        let corner = path(&[(0.5, 6.0), (5.0, 6.0), (5.0, 1.5)]);
        assert_ne!(stage(1.0, 1.0).treat(&grid, &corner), corner);
        assert_eq!(stage(1.0, 1.001).treat(&grid, &corner), corner);
        // R = 2: C = (3, 4): the arc comes as near to (4, 5) as 2 − √2 = 0.5858, and its ends (3, 6) and (5, 4) keep 1
        // from the block, so they do not tell.
        assert_ne!(stage(2.0, 0.58).treat(&grid, &corner), corner);
        assert_eq!(stage(2.0, 0.59).treat(&grid, &corner), corner);
    }

    #[test]
    fn distances_between_arcs_and_squares_are_those_of_dense_sampling() {
        let mut stream = stream(81);
        let (mut touching, mut apart) = (0, 0);
        for _ in 0..4000 {
            let centre = Vec2::new(stream.range(-2.0, 2.0), stream.range(-2.0, 2.0));
            let (radius_m, theta) = (stream.range(0.05, 2.0), stream.range(-PI, PI));
            let sweep = stream.range(-FRAC_PI_2, FRAC_PI_2);
            let at = |share: f64| centre + radius_m * direction(theta + share * sweep);
            let arc = Arc { from: at(0.0), to: at(1.0), centre, radius_m, sweep };
            let square = Rect { min: Vec2::new(-0.5, -0.5), max: Vec2::new(0.5, 0.5) };
            let sampled =
                (0..=2000).map(|k| square.signed_distance(at(f64::from(k) / 2000.0))).fold(f64::INFINITY, math::min);
            let error = radius_m * sweep.abs() / 4000.0 + 1e-12; // half the spacing of the samples
            let distance = arc.distance(square);
            if sampled < 0.0 {
                assert_eq!(distance, 0.0, "{arc:?}");
                touching += 1;
            } else {
                assert!(distance <= sampled + 1e-12 && distance >= sampled - error, "{arc:?} {distance} {sampled}");
                apart += 1;
            }
        }
        assert!(touching > 300 && apart > 500, "{touching} {apart}");
    }

    #[test]
    fn rounded_paths_are_smooth_at_their_arcs_free_and_no_longer() {
        let mut stream = stream(82);
        let mut planner = GlobalChoice::by_name("theta_star").expect("defaults").build();
        let (mut cells, mut arcs) = (Vec::new(), 0);
        for _ in 0..1500 {
            let share = stream.range(0.0, 0.3);
            let map = random_map(&mut stream, 25, share);
            let (grid, side_m) = (uninflated(&map), map.resolution_m());
            let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
            if planner
                .as_grid()
                .expect("cells")
                .search(&Problem { grid: &grid, start, goal }, &mut cells)
                .result
                .is_err()
            {
                continue;
            }
            let path = Path::polyline(&cells.iter().map(|&cell| grid.centre(cell)).collect::<Vec<_>>());
            let clearance_m = stream.index(3) as f64 * 0.1 * side_m;
            let rounded = stage(stream.range(0.2, 3.0) * side_m, clearance_m).treat(&grid, &path);
            assert_eq!((rounded.start(), rounded.end()), (path.start(), path.end()));
            assert!(rounded.length() <= path.length() + 1e-9);
            // Direction at the beginning and at the end of each piece.
            let directions: Vec<(Vec2, Vec2, bool)> = rounded
                .segments()
                .map(|(from, piece)| match *piece {
                    Piece::Line { to } => ((to - from).normalize(), (to - from).normalize(), false),
                    Piece::Arc { to, centre, sweep } => {
                        assert!(((from - centre).norm() - (to - centre).norm()).abs() < 1e-9, "on one circle");
                        let tangent = |p: Vec2| {
                            let r = (p - centre).normalize();
                            math::sign(sweep) * Vec2::new(-r.y, r.x)
                        };
                        (tangent(from), tangent(to), true)
                    }
                    Piece::Curve(_) => unreachable!("the stage makes none"),
                })
                .collect();
            for pair in directions.windows(2) {
                if pair[0].2 || pair[1].2 {
                    assert!((pair[0].1 - pair[1].0).norm() < 1e-6, "{rounded:?}");
                }
            }
            for (from, piece) in rounded.segments() {
                if matches!(piece, Piece::Arc { .. }) {
                    arcs += 1;
                    for k in 0..=50 {
                        let p = piece.point_at(from, piece.length(from) * f64::from(k) / 50.0);
                        assert!(grid.line_of_sight_with_clearance(p, p, clearance_m - 1e-6), "{rounded:?}");
                    }
                }
            }
        }
        assert!(arcs > 500, "{arcs}");
    }
}
