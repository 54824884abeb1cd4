//! What stands still: cells that nobody has seen, obstacles on the map, obstacles that are not on it.

use super::borders::borders;
use super::labels::Labels;
use super::legend::Legend;
use super::view::View;
use super::{outlined, seconds};
use crate::geometry::{Rect, Vec2};
use crate::map::{Cell, OccupancyGrid};
use crate::report::palette::{FLOOR, INK, NOT_ON_MAP, OBSTACLE, UNKNOWN_CELL};
use crate::report::picture::{Paint, Picture, Text};
use crate::world::Scene;

/// Cells of a map are merged into blocks where one is smaller than this on the page.
const CELL_MIN: f64 = 0.4;

/// The cells of the window, in blocks of `side` × `side` from the lower left.
struct Blocks {
    from: Cell,
    cols: i32,
    rows: i32,
    side: i32,
}

impl Blocks {
    fn new(grid: &OccupancyGrid, view: &View) -> Self {
        let Rect { min, max } = view.window;
        let (from, to) = (grid.cell_at(min), grid.cell_at(max));
        let from = Cell { col: from.col.max(0), row: from.row.max(0) };
        let side = (CELL_MIN / (grid.resolution_m() * view.scale)).ceil().clamp(1.0, 1e4) as i32;
        let blocks = |first: i32, last: i32, all: i32| (last.min(all - 1) - first).max(0) / side + 1;
        Self { cols: blocks(from.col, to.col, grid.cols()), rows: blocks(from.row, to.row, grid.rows()), from, side }
    }

    /// Whether some cell of each block is `kind`, row by row.
    fn any(&self, kind: &dyn Fn(Cell) -> bool) -> Vec<bool> {
        let block = |row: i32, col: i32| {
            let corner = Cell { col: self.from.col + col * self.side, row: self.from.row + row * self.side };
            let cells = (0..self.side).flat_map(|up| (0..self.side).map(move |right| (up, right)));
            cells.into_iter().any(|(up, right)| kind(Cell { col: corner.col + right, row: corner.row + up }))
        };
        (0..self.rows)
            .flat_map(|row| (0..self.cols).map(move |col| (row, col)))
            .map(|(row, col)| block(row, col))
            .collect()
    }

    /// The area of the blocks for which `marked` holds, on the page.
    fn area(&self, grid: &OccupancyGrid, view: &View, marked: &[bool]) -> Vec<Vec<Vec2>> {
        let inside = |col: i32, row: i32| marked[(row * self.cols + col) as usize];
        let corner = |[col, row]: [i32; 2]| {
            let col = (self.from.col + col * self.side).min(grid.cols());
            let row = (self.from.row + row * self.side).min(grid.rows());
            view.at(Vec2::new(f64::from(col), f64::from(row)) * grid.resolution_m())
        };
        borders(self.cols, self.rows, &inside)
            .into_iter()
            .map(|border| border.into_iter().map(corner).collect())
            .collect()
    }
}

/// The floor and the cells that nobody has seen.
pub(super) fn ground(page: &mut Picture, view: &View, grid: &OccupancyGrid, legend: &mut Legend) {
    page.rect(view.plot, Paint::fill(FLOOR));
    if grid.has_unknown() {
        let blocks = Blocks::new(grid, view);
        let unknown = blocks.any(&|cell| grid.is_unknown(cell));
        if unknown.contains(&true) {
            page.area(blocks.area(grid, view, &unknown), Paint::fill(UNKNOWN_CELL));
            legend.add("unknown cells", |page, at| swatch(page, at, Paint::fill(UNKNOWN_CELL).edged(OBSTACLE, 0.6)));
        }
    }
}

/// The obstacles on the map.
pub(super) fn obstacles(page: &mut Picture, view: &View, grid: &OccupancyGrid, legend: &mut Legend) {
    let blocks = Blocks::new(grid, view);
    let occupied = blocks.any(&|cell| grid.contains(cell) && !grid.is_free(cell) && !grid.is_unknown(cell));
    if occupied.contains(&true) {
        page.area(blocks.area(grid, view, &occupied), Paint::fill(OBSTACLE));
        legend.add("obstacle", |page, at| swatch(page, at, Paint::fill(OBSTACLE)));
    }
}

/// Cells on the page, for what the robot has come to believe.
pub(super) fn cells(page: &mut Picture, view: &View, grid: &OccupancyGrid, marked: &[Cell], paint: Paint) {
    let squares = marked.iter().map(|cell| {
        let Rect { min, max } = grid.square(*cell);
        [min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)].map(|corner| view.at(corner)).to_vec()
    });
    page.area(squares.collect(), paint);
}

/// When an obstacle that is not on the map is there, s after the beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::report) struct Stay {
    pub from_s: f64,
    pub until_s: f64,
}

/// The stay of each unknown static; one that comes and goes more than once has its first.
pub(in crate::report) fn stays(scene: &Scene) -> Vec<Stay> {
    let endless = |present: bool| Stay { from_s: if present { 0.0 } else { f64::INFINITY }, until_s: f64::INFINITY };
    let mut stays: Vec<Stay> = scene.unknown_static.iter().map(|obstacle| endless(obstacle.is_present())).collect();
    for event in &scene.script {
        let Some((number, present)) = event.change.obstacle_presence() else { continue };
        let stay = &mut stays[number];
        match present {
            true if stay.from_s.is_infinite() => stay.from_s = event.at_s,
            false if stay.from_s.is_finite() && stay.until_s.is_infinite() => stay.until_s = event.at_s,
            _ => {}
        }
    }
    stays
}

/// The obstacles that are not on the map and are there at some time from `from_s` to `to_s`; those that come or go have the time beside
/// them.
pub(super) fn unknown_statics(
    page: &mut Picture,
    view: &View,
    scene: &Scene,
    (from_s, to_s): (f64, f64),
    labels: &mut Labels,
    legend: &mut Legend,
) {
    let paint = Paint::fill(NOT_ON_MAP).edged(INK, 0.9);
    let mut any = false;
    for (obstacle, stay) in scene.unknown_static.iter().zip(stays(scene)) {
        if stay.from_s > to_s || stay.until_s <= from_s {
            continue;
        }
        any = true;
        let centre = obstacle.pose().position;
        outlined(page, view, obstacle.outline(), centre, paint);
        let mut words = Vec::new();
        if stay.from_s > 0.0 {
            words.push(format!("from {}", seconds(stay.from_s)));
        }
        if stay.until_s <= to_s {
            words.push(format!("until {}", seconds(stay.until_s)));
        }
        let (words, reach) = (words.join(" "), obstacle.outline().circumradius_m() * view.scale);
        if !words.is_empty()
            && let Some((at, anchor)) = labels.place(view.at(centre), reach + 2.0, &words, 10.0, false)
        {
            page.text(Text { rimmed: true, ..Text::new(at, 10.0, words).anchored(anchor) });
        }
    }
    if any {
        legend.add("obstacle not on the map", move |page, at| swatch(page, at, paint));
    }
}

pub(super) fn swatch(page: &mut Picture, at: Vec2, paint: Paint) {
    let half = Vec2::new(8.0, 4.5);
    page.rect(Rect { min: at - half, max: at + half }, paint);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_cells_are_merged_and_none_is_lost() {
        let mut grid = OccupancyGrid::empty(1000, 700, 0.1);
        grid.set_occupied(Cell { col: 999, row: 699 });
        let window = Rect { min: Vec2::zeros(), max: grid.extent_m() };
        let view = View::new(window, Vec2::zeros(), 100.0, 100.0);
        let blocks = Blocks::new(&grid, &view);
        assert_eq!((blocks.side, blocks.cols, blocks.rows), (4, 250, 175));
        let marked = blocks.any(&|cell| grid.contains(cell) && !grid.is_free(cell));
        let area = blocks.area(&grid, &view, &marked);
        // The corner of the map and no further.
        assert_eq!(area.len(), 1);
        assert!(area[0].iter().any(|p| (p - Vec2::new(100.0, 0.0)).norm() < 1e-9));
    }
}
