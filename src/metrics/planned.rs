//! Metrics of the first planned path, whatever the outcome of the drive. All are undefined without a plan.

use super::shortest::cells_in;
use crate::geometry::{Path, Piece, Rect, Vec2, cross, point_segment_distance};
use crate::map::OccupancyGrid;
use crate::math;
use crate::plan::clearance::Obstacles;
use crate::world::StaticMap;

/// Change of direction above which an interior vertex is a turn, rad.
pub const TURN_MIN_RAD: f64 = 1e-6;

/// Clearance below which a segment is risky, cells; less a rounding error, so that a path through
/// cell centres beside an obstacle, exactly half a cell away, is not.
const RISKY_CELLS: f64 = 0.5 - 1e-9;

/// Largest distance of a chord from its arc when clearance is measured, cells.
const SAGITTA_CELLS: f64 = 1e-4;

/// `planned_turns`: interior vertices with a change of direction above [`TURN_MIN_RAD`]; less is better
/// (systems.md §1.6). At the joints of arcs the tangents are compared; a curve that goes on smoothly is no
/// vertex. Pieces without length are passed over.
pub fn planned_turns(path: &Path) -> u32 {
    let (mut turns, mut arriving) = (0, None);
    for (from, piece) in path.segments() {
        let Some((begin, end)) = piece.tangents(from) else { continue };
        let bend = |before: Vec2| math::atan2(cross(before, begin), before.dot(&begin)).abs();
        turns += u32::from(arriving.is_some_and(|before| bend(before) > TURN_MIN_RAD));
        arriving = Some(end);
    }
    turns
}

/// `planned_turning_deg`: Σ |change of direction| along the path, degrees: at its vertices as [`planned_turns`] has them, along arcs, and
/// along curves between the tangents of chords that lie within a centimetre of them; less is better (systems.md §1.6, cum_turn_deg).
pub fn planned_turning_deg(path: &Path) -> f64 {
    const CHORD_SAGITTA_M: f64 = 0.01;
    let (mut turning, mut heading) = (0.0, None);
    for (from, piece) in path.segments() {
        let Some((begin, end)) = piece.tangents(from) else { continue };
        let mut turn_to = |along: Vec2| {
            let before = heading.replace(along).unwrap_or(along);
            turning += math::atan2(cross(before, along), before.dot(&along)).abs();
        };
        turn_to(begin);
        match piece {
            Piece::Line { .. } => {}
            Piece::Arc { sweep, .. } => {
                heading = Some(end);
                turning += sweep.abs();
            }
            Piece::Curve(_) => {
                let chords = piece.chord_count(from, CHORD_SAGITTA_M, 1e4);
                let at = |k: u32| piece.chord_point(from, k, chords);
                (0..chords)
                    .map(|k| at(k + 1) - at(k))
                    .filter(|chord| chord.norm_squared() > 0.0)
                    .for_each(&mut turn_to);
                turn_to(end);
            }
        }
    }
    turning.to_degrees()
}

/// Distance from obstacles above which a path has room enough, m.
const CLEARANCE_MAX_M: f64 = 5.0;

/// `planned_clearance_min_m`: least distance from the path, a line, to a cell that is occupied on the known map or to its edge, m, at most 5; 0
/// where it touches or leaves the map; more is better. A robot that follows the path exactly collides where it is below the robot's radius.
pub fn planned_clearance_min_m(path: &Path, known: &StaticMap) -> f64 {
    let obstacles = Obstacles::new(&known.grid, &known.field);
    let least_m = |least_m: f64, (from, piece): (Vec2, &Piece)| obstacles.piece_clearance(from, piece, least_m);
    path.segments().fold(obstacles.clearance(path.start(), CLEARANCE_MAX_M), least_m)
}

/// `path_nodes`: vertices of the path, both ends included; less is simpler (systems.md §1.6, node count).
pub fn path_nodes(path: &Path) -> u32 {
    path.vertices().count() as u32
}

/// `risky_nodes`: vertices of the path with an incident segment that comes nearer than half a cell to a
/// cell that is occupied on the known map or outside of it; less is better (systems.md §1.6, Q-A10).
///
/// Lines are measured exactly; arcs and curves by chords that lie within 10⁻⁴ cell of them.
pub fn risky_nodes(path: &Path, known: &OccupancyGrid) -> u32 {
    let risky: Vec<bool> = path.segments().map(|(from, piece)| is_risky(from, piece, known)).collect();
    let at = |index: usize| risky.get(index).copied().unwrap_or(false);
    (0..=risky.len()).filter(|&node| at(node) || (node > 0 && at(node - 1))).count() as u32
}

fn is_risky(from: Vec2, piece: &Piece, known: &OccupancyGrid) -> bool {
    let chords = piece.chord_count(from, SAGITTA_CELLS * known.resolution_m(), 1e6);
    (0..chords)
        .any(|k| is_risky_line(piece.chord_point(from, k, chords), piece.chord_point(from, k + 1, chords), known))
}

/// Whether a straight segment comes nearer than half a cell to a blocked square.
fn is_risky_line(a: Vec2, b: Vec2, known: &OccupancyGrid) -> bool {
    let risky_m = RISKY_CELLS * known.resolution_m();
    // In steps of a cell at most, so that a long diagonal does not look at all cells of the rectangle around it.
    let steps = math::clamp(((b - a).norm() / known.resolution_m()).ceil(), 1.0, 1e6) as u32;
    let at = |k: u32| if k == steps { b } else { a + (b - a) * (f64::from(k) / f64::from(steps)) };
    (0..steps).any(|k| {
        let (from, to) = (at(k), at(k + 1));
        let bounds = Rect {
            min: Vec2::new(math::min(from.x, to.x), math::min(from.y, to.y)),
            max: Vec2::new(math::max(from.x, to.x), math::max(from.y, to.y)),
        };
        cells_in(known, bounds, risky_m)
            .any(|cell| !known.is_free(cell) && segment_rect_distance(from, to, known.square(cell)) < risky_m)
    })
}

/// Distance from the segment a–b to a rectangle, m; 0 where they meet.
fn segment_rect_distance(a: Vec2, b: Vec2, rect: Rect) -> f64 {
    let Rect { min, max } = rect;
    let corners = [min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)];
    // Convex sets are apart exactly if one of these separates them: an axis, or the line through a and b.
    let overlap = |a: f64, b: f64, low: f64, high: f64| math::max(a, b) >= low && math::min(a, b) <= high;
    let sides = corners.map(|corner| cross(b - a, corner - a));
    let split = sides.iter().any(|&side| side >= 0.0) && sides.iter().any(|&side| side <= 0.0);
    if split && overlap(a.x, b.x, min.x, max.x) && overlap(a.y, b.y, min.y, max.y) {
        return 0.0;
    }
    // Apart, they come nearest at a corner of the one or an end of the other.
    let ends = math::min(rect.signed_distance(a), rect.signed_distance(b));
    corners.into_iter().map(|corner| point_segment_distance(corner, a, b)).fold(ends, math::min)
}

#[cfg(test)]
mod tests {
    use super::super::tests::close;
    use super::*;
    use crate::rng::{EpisodeSeed, Purpose};

    fn v(x: f64, y: f64) -> Vec2 {
        Vec2::new(x, y)
    }

    #[test]
    fn the_clearance_of_a_path_is_that_of_its_nearest_point() {
        let rows = ["........", "...##...", "...##...", "........", "........", "........"];
        let known = StaticMap::new(OccupancyGrid::from_ascii(&rows, 1.0));
        let of = |points: &[Vec2]| planned_clearance_min_m(&Path::polyline(points), &known);
        // The block is from (3, 3) to (5, 5); the edge is nearer to the first.
        assert!(close(of(&[v(1.0, 0.5), v(7.0, 0.5)]), 0.5));
        assert!(close(of(&[v(1.0, 2.25), v(7.0, 2.25)]), 0.75));
        assert!(close(of(&[v(2.0, 2.0), v(2.0, 2.0)]), 2f64.sqrt()));
        assert_eq!(of(&[v(1.0, 4.0), v(4.0, 4.0)]), 0.0);
        assert_eq!(of(&[v(1.0, 4.0), v(-1.0, 4.0), v(1.0, 4.0)]), 0.0);
        let arc = Piece::Arc { to: v(2.0, 2.0), centre: v(2.0, 1.0), sweep: math::FRAC_PI_2 };
        assert!(close(planned_clearance_min_m(&Path::new(v(3.0, 1.0), vec![arc]), &known), 1.0));
    }

    #[test]
    fn turning_is_that_of_corners_arcs_and_curves_by_hand() {
        let of = |path: &Path| planned_turning_deg(path);
        assert_eq!(of(&Path::polyline(&[v(0.0, 0.0), v(5.0, 0.0)])), 0.0);
        // 90° to the left, then 45° to the right, then back.
        let corners = [v(0.0, 0.0), v(2.0, 0.0), v(2.0, 2.0), v(4.0, 4.0), v(2.0, 2.0)];
        assert!(close(of(&Path::polyline(&corners)), 315.0));
        // A quarter circle between lines that touch it, and one that begins across.
        let arc = |to: Vec2| Piece::Arc { to, centre: v(2.0, 1.0), sweep: math::FRAC_PI_2 };
        let smooth = vec![Piece::Line { to: v(2.0, 0.0) }, arc(v(3.0, 1.0)), Piece::Line { to: v(3.0, 4.0) }];
        assert!(close(of(&Path::new(v(0.0, 0.0), smooth)), 90.0));
        let across = vec![Piece::Line { to: v(2.0, 0.0) }, arc(v(3.0, 1.0))];
        assert!(close(of(&Path::new(v(2.0, 2.0), across)), 180.0));
        // A cubic that turns from +x to +y and on to −x; one that bends left by 45° and right again.
        let curve = |points: [Vec2; 4]| {
            let bend = crate::geometry::curve::Curve::bezier(points);
            Path::new(points[0], vec![Piece::Curve(Box::new(bend))])
        };
        assert!(close(of(&curve([v(0.0, 0.0), v(4.0, 0.0), v(4.0, 3.0), v(0.0, 3.0)])), 180.0));
        let s_shape = of(&curve([v(0.0, 0.0), v(3.0, 0.0), v(3.0, 6.0), v(6.0, 6.0)]));
        // Its steepest direction is that in the middle: derivative 3 (P3 + P2 − P1 − P0) / 4 = (4.5, 9).
        assert!((s_shape - 2.0 * math::atan(2.0).to_degrees()).abs() < 0.1, "{s_shape}");
    }

    #[test]
    fn turns_of_polylines_and_fillets() {
        // Straight on at (1, 0), a bend at (2, 0), a doubled vertex, and a bend back at (3, 1).
        let path = Path::polyline(&[v(0.0, 0.0), v(1.0, 0.0), v(2.0, 0.0), v(3.0, 1.0), v(3.0, 1.0), v(5.0, 1.0)]);
        assert_eq!((planned_turns(&path), path_nodes(&path)), (2, 6));
        // A quarter arc joins two lines smoothly; with the second line askew its joint is a turn.
        let arc = Piece::Arc { to: v(3.0, 1.0), centre: v(2.0, 1.0), sweep: math::FRAC_PI_2 };
        let smooth = vec![Piece::Line { to: v(2.0, 0.0) }, arc.clone(), Piece::Line { to: v(3.0, 4.0) }];
        assert_eq!(planned_turns(&Path::new(v(0.0, 0.0), smooth)), 0);
        let askew = vec![Piece::Line { to: v(2.0, 0.0) }, arc, Piece::Line { to: v(3.1, 4.0) }];
        assert_eq!(planned_turns(&Path::new(v(0.0, 0.0), askew)), 1);
        // Clockwise round the same corner of the circle the tangent points the other way: both joints turn.
        let back = Piece::Arc { to: v(3.0, 1.0), centre: v(2.0, 1.0), sweep: math::FRAC_PI_2 - math::TAU };
        let loops = vec![Piece::Line { to: v(2.0, 0.0) }, back, Piece::Line { to: v(3.0, 4.0) }];
        assert_eq!(planned_turns(&Path::new(v(0.0, 0.0), loops)), 2);
    }

    #[test]
    fn nodes_beside_a_segment_nearer_than_half_a_cell_are_risky() {
        for resolution_m in [1.0, 0.1] {
            let known = OccupancyGrid::from_ascii(&[".....", "..#..", ".....", "....."], resolution_m);
            let nodes = |points: &[(f64, f64)]| {
                let vertices: Vec<Vec2> = points.iter().map(|&(x, y)| v(x, y) * resolution_m).collect();
                risky_nodes(&Path::polyline(&vertices), &known)
            };
            // Along the row under the block (2..3, 2..3), and along the edge of the map: exactly half a cell away.
            assert_eq!(nodes(&[(0.5, 1.5), (2.5, 1.5), (4.5, 1.5)]), 0);
            assert_eq!(nodes(&[(0.5, 0.5), (4.5, 0.5), (4.5, 3.5)]), 0);
            // From (1.5, 2.5) diagonally down to (2.5, 1.5): through the corner (2, 2). Both its ends are risky.
            assert_eq!(nodes(&[(0.5, 2.5), (1.5, 2.5), (2.5, 1.5), (4.5, 1.5)]), 2);
            // From (0.5, 0.9) to (4.5, 1.9): under the corner (3, 2) at y = 1.525, 0.475 · cos 14° = 0.461 cells.
            assert_eq!(nodes(&[(0.5, 0.9), (4.5, 1.9)]), 2);
            assert_eq!(nodes(&[(0.5, 0.8), (4.5, 1.8)]), 0); // 0.575 · cos 14° = 0.558
            assert_eq!(nodes(&[(0.5, 0.49), (1.5, 0.5), (2.5, 0.5)]), 2); // the outside counts
        }
    }

    #[test]
    fn arcs_are_measured_along_the_arc() {
        // Quarter circle of radius 1 about (2, 1), from (2, 0) to (3, 1), in an 8 × 8 grid of 0.5 m cells. The block
        // [3.0, 3.5] × [0, 0.5]: its corner (3, 0.5) is √(1 + 0.25) − 1 = 0.118 m off, less than 0.25 m.
        let arc = |cell| {
            let mut known = OccupancyGrid::empty(8, 8, 0.5);
            known.set_occupied(cell);
            let start = v(2.0, 0.25);
            let piece = Piece::Arc { to: v(3.0, 1.25), centre: v(2.0, 1.25), sweep: math::FRAC_PI_2 };
            risky_nodes(&Path::new(start, vec![piece]), &known)
        };
        use crate::map::Cell;
        // Centre (2, 1.25). Block [3, 3.5] × [0, 0.5]: corner (3, 0.5), √(1 + 0.5625) − 1 = 0.25 m: just not below.
        assert_eq!(arc(Cell { col: 6, row: 0 }), 0);
        // Block [2.5, 3] × [0, 0.5]: corner (2.5, 0.5) is inside the circle, 1 − √(0.25 + 0.5625) = 0.099 m off.
        assert_eq!(arc(Cell { col: 5, row: 0 }), 2);
        // Block [2, 2.5] × [1, 1.5] on the chord's side: corner (2.5, 1), 1 − √(0.25 + 0.0625) = 0.44 m off.
        assert_eq!(arc(Cell { col: 4, row: 2 }), 0);
    }

    #[test]
    fn segment_distance_equals_dense_sampling() {
        let mut draws = EpisodeSeed { seed: 5, episode: 0 }.stream(Purpose::Map, 0);
        let rect = Rect { min: v(0.0, 0.0), max: v(1.0, 1.0) };
        let mut meetings = 0;
        for _ in 0..3000 {
            let mut point = || v(draws.range(-1.5, 2.5), draws.range(-1.5, 2.5));
            let (a, b) = (point(), point());
            let sampled = (0..=400)
                .map(|k| math::max(rect.signed_distance(a + (b - a) * (f64::from(k) / 400.0)), 0.0))
                .fold(f64::INFINITY, math::min);
            let exact = segment_rect_distance(a, b, rect);
            // Samples are at most 5.7 / 400 apart, so half of that off.
            assert!(exact <= sampled + 1e-12 && sampled <= exact + 0.0072, "{a} {b}: {exact}, sampled {sampled}");
            meetings += u32::from(exact == 0.0);
        }
        assert!(meetings > 500);
        // On the line of a side, but apart.
        assert!(close(segment_rect_distance(v(2.0, 1.0), v(3.0, 1.0), rect), 1.0));
        assert!(close(segment_rect_distance(v(2.0, 2.0), v(3.0, 3.0), rect), 2f64.sqrt()));
        assert!(close(segment_rect_distance(v(2.0, 0.5), v(2.0, 0.5), rect), 1.0));
    }
}
