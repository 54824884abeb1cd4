//! Which part of the world a picture shows, and where on the page.

use crate::geometry::outline::Outline;
use crate::geometry::{Path, Piece, Rect, Vec2};
use crate::map::{Cell, OccupancyGrid};
use crate::math;

/// Which part of the world a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Crop {
    /// The part of the map that somebody has seen; where the drive touched less than a fifth of it, [`Self::Drive`].
    #[default]
    Auto,
    /// The whole map.
    Map,
    /// What the drive touched and a margin: start, goals, plans and tracks of the robot.
    Drive,
    /// A rectangle of the map's own frame, m: the smallest part of the grid that holds it.
    Window(Rect),
}

/// Share of the known map that a drive touches at least for the whole to be shown.
const SHARE_MIN: f64 = 0.2;
/// The shorter side of a window about a drive, as a share of the longer.
const SLENDER: f64 = 0.4;

impl Crop {
    /// The part of a grid to show, grid frame, m; `touched` is what the drive touched.
    pub(super) fn window(self, grid: &OccupancyGrid, touched: Rect) -> Rect {
        let whole = Rect { min: Vec2::zeros(), max: grid.extent_m() };
        match self {
            Self::Map => whole,
            Self::Drive => about(touched, whole),
            Self::Auto => {
                let (known, drive) = (known_part(grid, whole), about(touched, whole));
                let known = cut(united(known, touched), whole);
                if area(drive) < SHARE_MIN * area(known) { drive } else { known }
            }
            Self::Window(asked) => {
                let frame = grid.frame();
                let corners =
                    [asked.min, Vec2::new(asked.max.x, asked.min.y), asked.max, Vec2::new(asked.min.x, asked.max.y)];
                let corners = corners.map(|corner| frame.point_to_grid(corner));
                let window = cut(bounds(corners).unwrap_or(whole), whole);
                if area(window) > 0.0 { window } else { whole }
            }
        }
    }
}

/// A drive and a margin, not too slender, inside the map.
fn about(touched: Rect, whole: Rect) -> Rect {
    let sides = touched.max - touched.min;
    let longer = math::max(sides.x, sides.y);
    let margin = math::max(0.06 * longer, 0.5);
    let grown = |side: f64| math::max(margin, 0.5 * (SLENDER * longer - side));
    let by = Vec2::new(grown(sides.x), grown(sides.y));
    cut(Rect { min: touched.min - by, max: touched.max + by }, whole)
}

/// The part of a map that is not just unknown cells, with a rim of one cell.
fn known_part(grid: &OccupancyGrid, whole: Rect) -> Rect {
    if !grid.has_unknown() {
        return whole;
    }
    let cells = (0..grid.rows()).flat_map(|row| (0..grid.cols()).map(move |col| Cell { col, row }));
    let known = cells.filter(|cell| !grid.is_unknown(*cell)).flat_map(|cell| {
        let Rect { min, max } = grid.square(cell);
        [min, max]
    });
    let Some(Rect { min, max }) = bounds(known) else { return whole };
    let rim = Vec2::new(grid.resolution_m(), grid.resolution_m());
    cut(Rect { min: min - rim, max: max + rim }, whole)
}

/// The smallest rectangle that holds all points; `None` without points.
pub(super) fn bounds(points: impl IntoIterator<Item = Vec2>) -> Option<Rect> {
    points.into_iter().fold(None, |rect, p| {
        let rect = rect.unwrap_or(Rect { min: p, max: p });
        Some(Rect { min: rect.min.inf(&p), max: rect.max.sup(&p) })
    })
}

pub(super) fn united(a: Rect, b: Rect) -> Rect {
    Rect { min: a.min.inf(&b.min), max: a.max.sup(&b.max) }
}

fn cut(rect: Rect, whole: Rect) -> Rect {
    let min = rect.min.sup(&whole.min);
    Rect { min, max: rect.max.inf(&whole.max).sup(&min) }
}

fn area(rect: Rect) -> f64 {
    let sides = rect.max - rect.min;
    sides.x * sides.y
}

/// From metres of the grid frame to the page, y down.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// The part of the world that is shown, grid frame, m.
    pub window: Rect,
    /// Where it lies on the page.
    pub plot: Rect,
    /// Pixels to a metre.
    pub scale: f64,
}

impl View {
    /// The window with its upper left corner at `corner`, as large as fits into `width` and `height`.
    pub fn new(window: Rect, corner: Vec2, width: f64, height: f64) -> Self {
        let sides = window.max - window.min;
        let scale = math::min(width / sides.x, height / sides.y);
        Self { window, plot: Rect { min: corner, max: corner + sides * scale }, scale }
    }

    pub fn at(&self, p: Vec2) -> Vec2 {
        let d = (p - self.window.min) * self.scale;
        Vec2::new(self.plot.min.x + d.x, self.plot.max.y - d.y)
    }

    /// Whether a point lies in the window.
    pub fn shows(&self, p: Vec2) -> bool {
        self.window.signed_distance(p) <= 0.0
    }

    /// The points on the page, without those that nobody could tell from the one before.
    pub fn track(&self, points: impl IntoIterator<Item = Vec2>) -> Vec<Vec2> {
        let mut track: Vec<Vec2> = Vec::new();
        let mut last = None;
        for p in points.into_iter().map(|p| self.at(p)) {
            last = Some(p);
            if track.last().is_none_or(|kept| (p - kept).norm() > 0.5) {
                track.push(p);
            }
        }
        // A line ends where its last point is.
        match (track.last(), last) {
            (Some(kept), Some(end)) if *kept != end => track.push(end),
            (Some(only), _) if track.len() == 1 => track.push(*only),
            _ => {}
        }
        track
    }

    /// A path, its arcs and curves in chords.
    pub fn path(&self, path: &Path) -> Vec<Vec2> {
        let sagitta_m = 0.15 / self.scale;
        let pieces = path.segments().flat_map(|(from, piece)| {
            let chords = match piece {
                Piece::Line { .. } => 1,
                _ => piece.chord_count(from, sagitta_m, 1e3),
            };
            (1..=chords).map(move |k| piece.chord_point(from, k, chords))
        });
        core::iter::once(path.start()).chain(pieces).map(|p| self.at(p)).collect()
    }

    /// The border of an outline about `centre`; a disc has none.
    pub fn corners(&self, outline: &Outline, centre: Vec2) -> Option<Vec<Vec2>> {
        Some(outline.corners(centre)?.iter().map(|corner| self.at(*corner)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Frame;

    fn rect(x0: f64, y0: f64, x1: f64, y1: f64) -> Rect {
        Rect { min: Vec2::new(x0, y0), max: Vec2::new(x1, y1) }
    }

    #[test]
    fn the_whole_map_is_shown_unless_the_drive_is_a_small_part_of_it() {
        let grid = OccupancyGrid::empty(100, 50, 1.0);
        assert_eq!(Crop::Auto.window(&grid, rect(10.0, 10.0, 60.0, 30.0)), rect(0.0, 0.0, 100.0, 50.0));
        // 10 x 10 m of 100 x 50, with a margin of 0.6 m.
        assert_eq!(Crop::Auto.window(&grid, rect(10.0, 10.0, 20.0, 20.0)), rect(9.4, 9.4, 20.6, 20.6));
        assert_eq!(Crop::Map.window(&grid, rect(10.0, 10.0, 20.0, 20.0)), rect(0.0, 0.0, 100.0, 50.0));
    }

    #[test]
    fn a_straight_drive_has_room_on_both_sides_and_the_map_ends_the_window() {
        let grid = OccupancyGrid::empty(100, 50, 1.0);
        // 40 m by 0.4: 16 m high, of which 8 m are below and would be outside.
        let window = Crop::Drive.window(&grid, rect(10.0, 5.0, 50.0, 5.0));
        assert_eq!((window.min.y, window.max.y), (0.0, 13.0));
        assert!((window.min.x - 7.6).abs() < 1e-9 && (window.max.x - 52.4).abs() < 1e-9);
    }

    #[test]
    fn a_window_is_given_in_the_frame_of_the_map() {
        let origin = crate::geometry::Pose::new(-10.0, -5.0, 0.0);
        let grid = OccupancyGrid::empty(100, 50, 1.0).with_frame(Frame { origin });
        let window = Crop::Window(rect(0.0, 0.0, 8.0, 4.0)).window(&grid, rect(0.0, 0.0, 1.0, 1.0));
        assert_eq!(window, rect(10.0, 5.0, 18.0, 9.0));
    }

    #[test]
    fn what_nobody_has_seen_is_cut_off() {
        let mut unknown = vec![true; 64];
        (unknown[3 * 8 + 3], unknown[4 * 8 + 5]) = (false, false);
        let grid = OccupancyGrid::empty(8, 8, 1.0).with_unknown(unknown);
        assert_eq!(Crop::Auto.window(&grid, rect(3.0, 3.0, 5.0, 4.0)), rect(2.0, 2.0, 7.0, 6.0));
    }

    #[test]
    fn up_is_up() {
        let view = View::new(rect(2.0, 2.0, 12.0, 7.0), Vec2::new(50.0, 20.0), 200.0, 500.0);
        assert_eq!((view.scale, view.at(Vec2::new(2.0, 2.0))), (20.0, Vec2::new(50.0, 120.0)));
        assert_eq!(view.at(Vec2::new(12.0, 7.0)), Vec2::new(250.0, 20.0));
    }
}
