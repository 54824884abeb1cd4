//! The path in force and the robot's progress on it.

use crate::geometry::{KeyNode, Path, Piece, Vec2};
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::clearance::DISTANCE_SLACK_M;
use crate::plan::contract::Guidance;

/// The path in force and the robot's progress on it.
#[derive(Clone, Debug, Default)]
pub struct Route {
    pub(super) path: Path,
    pub(super) nodes: Vec<KeyNode>,
    /// Number of the first key node that the robot has not passed yet.
    pub(super) next: usize,
    pub(super) progress_m: f64,
    pub(super) previous_node: Vec2,
    pub(super) sub_goal: Vec2,
    pub(super) is_last: bool,
    pub(super) revision: u32,
    /// What each piece keeps from obstacle squares, m, at most the inflation; empty where the grid knows none.
    room_m: Vec<f64>,
}

impl Route {
    /// Puts a path into force, from its beginning on.
    pub(super) fn set(&mut self, path: Path) {
        self.nodes.clear();
        self.room_m.clear();
        path.key_nodes(&mut self.nodes);
        self.path = path;
        self.next = 1.min(self.nodes.len() - 1);
        self.progress_m = 0.0;
        (self.previous_node, self.sub_goal) = (self.nodes[0].position, self.nodes[self.next].position);
        self.is_last = self.next == self.nodes.len() - 1;
        self.revision += 1;
    }

    /// Puts a path into force that was planned on `grid`, and notes what it keeps from obstacles.
    pub(super) fn set_on(&mut self, path: Path, grid: &PlanningGrid) {
        self.set(path);
        if let Some(obstacles) = grid.obstacles() {
            let room = |(from, piece): (Vec2, &Piece)| obstacles.piece_clearance(from, piece, grid.inflation_m());
            self.room_m.extend(self.path.segments().map(room));
        }
    }

    /// Forgets the path; its memory is used again.
    pub(super) fn clear(&mut self) {
        let (mut nodes, mut room_m) = (core::mem::take(&mut self.nodes), core::mem::take(&mut self.room_m));
        nodes.clear();
        room_m.clear();
        *self = Self { nodes, room_m, ..Self::default() };
    }

    /// Length of the path, m.
    pub(super) fn length_m(&self) -> f64 {
        self.nodes.last().map_or(0.0, |node| node.along_m)
    }

    /// Moves the progress to the point nearest to `position` within a stretch of the path, never back.
    pub(super) fn project(&mut self, position: Vec2, from_m: f64, to_m: f64) {
        let nearest_m = self.path.project_within(position, from_m, to_m).0;
        self.progress_m = math::max(math::max(from_m, self.progress_m), math::min(nearest_m, to_m));
    }

    /// Moves the progress back to `to_m`, and the next key node with it.
    pub(super) fn go_back(&mut self, to_m: f64) {
        self.progress_m = math::clamp(to_m, 0.0, self.progress_m);
        while self.next > 1 && self.nodes[self.next - 1].along_m >= self.progress_m {
            self.next -= 1;
        }
        self.is_last = self.next + 1 == self.nodes.len();
    }

    pub(super) fn guidance(&self) -> Guidance<'_> {
        Guidance {
            path: &self.path,
            progress_m: self.progress_m,
            previous_node: self.previous_node,
            sub_goal: self.sub_goal,
            is_last: self.is_last,
            path_revision: self.revision,
            key_nodes: &self.nodes,
            next_key_node: self.next,
        }
    }

    /// Whether every piece that the robot has not passed and that begins before `last_m` is as clear on the grid as it was when the
    /// path came into force, and passes movers that block cells as far as the robot's `position` and the end of the path leave it.
    ///
    /// Without inflation: whether it touches no blocked cell; arcs and curves are tested by chords that stay within a tenth of a
    /// cell of them.
    pub(super) fn is_free_up_to(&self, last_m: f64, grid: &PlanningGrid, position: Vec2) -> bool {
        let mut begin_m = 0.0;
        let begins_before = |(_, (from, piece)): &(usize, (Vec2, &Piece))| {
            let begins_before = begin_m < last_m;
            begin_m += piece.length(*from);
            begins_before
        };
        let pieces = self.path.segments().enumerate().take_while(begins_before);
        let mut rest = pieces.skip(self.first_piece_left());
        let Some(obstacles) = grid.obstacles().filter(|_| self.room_m.len() == self.path.pieces().len()) else {
            return rest.all(|(_, (from, piece))| all_chords(grid, from, piece, |a, b| grid.line_of_sight(a, b)));
        };
        rest.all(|(index, (from, piece))| {
            let room_m = self.room_m[index];
            obstacles.piece_clearance(from, piece, room_m) >= room_m - DISTANCE_SLACK_M
                && all_chords(grid, from, piece, |a, b| grid.passes_movers_between(a, b, position, self.path.end()))
        })
    }

    /// Number of the piece on which the key node before the next one lies.
    fn first_piece_left(&self) -> usize {
        let before = self.next.saturating_sub(1);
        if !self.path.has_named_nodes() {
            return before;
        }
        let mut end_m = 0.0;
        let passed = |(from, piece): &(Vec2, &Piece)| {
            end_m += piece.length(*from);
            end_m <= self.nodes[before].along_m
        };
        self.path.segments().take_while(passed).count()
    }
}

/// Whether all chords of a piece that begins at `from` are clear; the chords stay within a tenth of a cell of it.
fn all_chords(grid: &PlanningGrid, from: Vec2, piece: &Piece, mut is_clear: impl FnMut(Vec2, Vec2) -> bool) -> bool {
    match piece {
        Piece::Line { to } => is_clear(from, *to),
        Piece::Arc { .. } => {
            let length = piece.length(from);
            let steps = (length / (0.25 * grid.resolution_m())).ceil().clamp(1.0, 1e4) as u32;
            let at = |k: u32| piece.point_at(from, length * f64::from(k) / f64::from(steps));
            (0..steps).all(|k| is_clear(at(k), at(k + 1)))
        }
        Piece::Curve(_) => {
            let chords = piece.chord_count(from, 0.1 * grid.resolution_m(), 1e4);
            let at = |k: u32| piece.chord_point(from, k, chords);
            (0..chords).all(|k| is_clear(at(k), at(k + 1)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::curve::Curve;
    use crate::plan::grid::tests::drawn;

    fn v(x: f64, y: f64) -> Vec2 {
        Vec2::new(x, y)
    }

    fn route(path: Path) -> Route {
        let mut route = Route::default();
        route.set(path);
        route
    }

    #[test]
    fn a_path_that_comes_into_force_begins_at_its_beginning() {
        let mut route = route(Path::polyline(&[v(0.5, 0.5), v(3.5, 0.5)]));
        assert_eq!((route.next, route.is_last, route.revision, route.length_m()), (1, true, 1, 3.0));
        route.project(v(2.0, 1.0), 0.0, 9.0);
        assert_eq!(route.progress_m, 1.5);
        route.set(Path::polyline(&[v(0.5, 0.5)]));
        assert_eq!((route.next, route.is_last, route.revision, route.progress_m), (0, true, 2, 0.0));
    }

    #[test]
    fn the_progress_goes_back_on_request_alone() {
        let mut route = route(Path::polyline(&[v(0.0, 0.0), v(2.0, 0.0), v(4.0, 0.0), v(6.0, 0.0)]));
        (route.progress_m, route.next, route.is_last) = (5.0, 3, true);
        route.project(v(1.0, 0.0), 0.0, 6.0);
        assert_eq!(route.progress_m, 5.0);
        route.go_back(1.0);
        assert_eq!((route.progress_m, route.next, route.is_last), (1.0, 1, false));
        route.go_back(3.0); // ahead: nothing to go back to
        assert_eq!(route.progress_m, 1.0);
    }

    #[test]
    fn what_lies_behind_does_not_block_and_what_lies_ahead_does() {
        let (_, grid) = drawn(&[
            "......", //
            "......", //
            ".#....", //
        ]);
        let mut route = route(Path::polyline(&[v(0.5, 0.5), v(2.5, 0.5), v(5.5, 0.5)]));
        assert!(!route.is_free_up_to(f64::INFINITY, &grid, v(2.5, 0.5)));
        route.next = 2;
        assert!(route.is_free_up_to(f64::INFINITY, &grid, v(2.5, 0.5)));
        let curve = |end: Vec2| {
            let bend = Curve::bezier([v(2.5, 0.5), v(2.5, 1.5), v(1.5, 2.5), end]);
            self::route(Path::new(v(2.5, 0.5), vec![Piece::Curve(Box::new(bend))]))
        };
        assert!(
            curve(v(0.5, 2.5)).is_free_up_to(f64::INFINITY, &grid, v(2.5, 0.5))
                && !curve(v(1.5, 0.5)).is_free_up_to(f64::INFINITY, &grid, v(2.5, 0.5))
        );
    }
}
