//! A small picture of an episode: the map in rough strokes, the way driven. What a page shows without a script, and on paper.

use super::super::chart::escape;
use crate::episode::{Outcome, Recording};
use crate::geometry::Vec2;
use crate::map::{Cell, OccupancyGrid};
use crate::math;
use std::fmt::Write as _;

/// Longest side of a picture, in its own units.
const SIDE: f64 = 160.0;
/// Cells along the longer side that the map is reduced to.
const CELLS_MAX: i32 = 56;
/// Points of a track.
const POINTS_MAX: usize = 48;

/// From metres to units of the picture, y down.
struct Frame {
    scale: f64,
    width: f64,
    height: f64,
}

impl Frame {
    fn new(grid: &OccupancyGrid) -> Self {
        let extent = grid.extent_m();
        // A very long map keeps a side that can be seen.
        let scale = SIDE / math::max(extent.x, extent.y);
        Self { scale, width: extent.x * scale, height: extent.y * scale }
    }

    fn at(&self, p: Vec2) -> (f64, f64) {
        (p.x * self.scale, self.height - p.y * self.scale)
    }
}

/// The map as a symbol that pictures share.
pub(super) fn symbol(grid: &OccupancyGrid, id: &str) -> String {
    let frame = Frame::new(grid);
    let step = (grid.cols().max(grid.rows()) + CELLS_MAX - 1) / CELLS_MAX;
    let (cols, rows) = ((grid.cols() + step - 1) / step, (grid.rows() + step - 1) / step);
    // A rough cell is drawn where a fifth of it is occupied: thin walls stay, single cells of a fine map do not swell.
    let is_full = |col: i32, row: i32| {
        let inside = (0..step * step).map(|k| Cell { col: col * step + k % step, row: row * step + k / step });
        let (mut occupied, mut all) = (0, 0);
        for cell in inside.filter(|&cell| grid.contains(cell)) {
            all += 1;
            occupied += i32::from(!grid.is_free(cell));
        }
        5 * occupied >= all.max(1)
    };
    let side = frame.scale * grid.resolution_m() * f64::from(step);
    let mut data = String::new();
    for row in 0..rows {
        let mut col = 0;
        while col < cols {
            let run = (col..cols).take_while(|&col| is_full(col, row)).count() as i32;
            if run > 0 {
                let (x, y) = (f64::from(col) * side, frame.height - f64::from(row + 1) * side);
                let _ = write!(
                    data,
                    "M{x:.1} {y:.1}h{:.1}v{side:.1}h-{:.1}z",
                    f64::from(run) * side,
                    f64::from(run) * side
                );
            }
            col += run + 1;
        }
    }
    let (width, height) = (frame.width, frame.height);
    format!(
        "<symbol id=\"{}\" viewBox=\"0 0 {width:.1} {height:.1}\"><rect width=\"{width:.1}\" height=\"{height:.1}\" class=\"floor\"/><path d=\"{data}\" class=\"wall\"/></symbol>",
        escape(id)
    )
}

/// The picture of an episode over the map's symbol.
pub(super) fn draw(recording: &Recording, map: &str, says: &str) -> String {
    let Recording { scene, trace, outcome, .. } = recording;
    let frame = Frame::new(&scene.map.grid);
    let mut svg = format!(
        "<svg viewBox=\"0 0 {:.1} {:.1}\" role=\"img\" aria-label=\"{}\"><use href=\"#{}\"/>",
        frame.width,
        frame.height,
        escape(says),
        escape(map)
    );
    for obstacle in &scene.unknown_static {
        let (x, y) = frame.at(obstacle.pose().position);
        let r = math::max(obstacle.outline().circumradius_m() * frame.scale, 1.0);
        let _ = write!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.1}\" class=\"unknown\"/>");
    }
    let rows = trace.ticks.len();
    let stride = rows.div_ceil(POINTS_MAX).max(1);
    let shown = || (0..rows).step_by(stride).chain(rows.checked_sub(1).filter(|last| last % stride != 0));
    let line = |points: &mut dyn Iterator<Item = Vec2>| {
        let mut data = String::new();
        for p in points {
            let (x, y) = frame.at(p);
            let _ = write!(data, "{}{x:.1} {y:.1}", if data.is_empty() { 'M' } else { 'L' });
        }
        data
    };
    // The last seconds of movers near the end alone: a crowd would cover the drive.
    if let Some(last) = rows.checked_sub(1) {
        for (index, state) in trace.movers_at(last).iter().enumerate().filter(|(_, state)| state.present).take(24) {
            let (x, y) = frame.at(state.position);
            let r = math::max(scene.movers[index].radius_m() * frame.scale, 1.2);
            let _ = write!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.1}\" class=\"mover\"/>");
        }
    }
    let track = line(&mut shown().map(|row| trace.ticks[row].pose.position));
    let (gx, gy) = frame.at(scene.goal);
    let _ = write!(
        svg,
        "<circle cx=\"{gx:.1}\" cy=\"{gy:.1}\" r=\"3\" class=\"goal\"/><path d=\"{track}\" class=\"track\"/>"
    );
    if let Some(end) = trace.ticks.last() {
        let (x, y) = frame.at(end.pose.position);
        let class = if *outcome == Outcome::Success { "end" } else { "end failed" };
        let _ = write!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.6\" class=\"{class}\"/>");
    }
    svg + "</svg>"
}
