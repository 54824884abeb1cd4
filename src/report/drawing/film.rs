//! A drive moment by moment: what the robot knows and senses, its plan and its track so far, and the clock.

use super::movers::Look;
use super::{Caption, Drive, Sheet, Style, clock, map, movers, outlined, robot};
use crate::episode::Recording;
use crate::geometry::{Vec2, direction};
use crate::map::Cell;
use crate::math;
use crate::report::palette::{INK, NOT_ON_MAP, PLAN, ROBOT, SENSED};
use crate::report::picture::{Paint, Picture};
use std::collections::BTreeSet;

/// Rows of a recording, one for each picture of a film.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Film {
    /// The row of each picture.
    pub rows: Vec<usize>,
}

/// Pictures of a film at most, unless a step is given.
const PICTURES_MAX: f64 = 180.0;
/// How long the tracks of movers are, s.
const TRAIL_S: f64 = 3.0;

impl Film {
    /// A picture every `every_s` seconds, and the last moment; by default as often as gives a film of about fifteen seconds at twelve pictures
    /// a second.
    pub fn new(recording: &Recording, every_s: Option<f64>) -> Self {
        let rows = recording.trace.ticks.len();
        let last = rows.saturating_sub(1);
        let step = match every_s {
            Some(every_s) => (every_s / recording.dt_s).round(),
            None => (last as f64 / PICTURES_MAX).ceil(),
        };
        let step = math::max(step, 1.0) as usize;
        let mut rows: Vec<usize> = (0..last).step_by(step).collect();
        rows.push(last);
        Self { rows }
    }
}

/// The picture of one row of a recording; all rows give pictures of one size.
pub fn film(recording: &Recording, row: usize, caption: &Caption, style: &Style) -> Picture {
    let drive = Drive { recording };
    let mut sheet = Sheet::new(&recording.scene, drive.touched(), caption, style);
    let trace = &recording.trace;
    let Some(tick) = trace.ticks.get(row) else { return sheet.finish() };
    let time_s = trace.row_time_s(row, recording.dt_s);
    sheet.map(&recording.scene);
    sheet.inside(|page, view, labels, legend| {
        robot::flags(page, view, &drive, time_s + 1e-9, labels, legend);
        statics(page, view, &drive, time_s);
        believed(page, view, recording, tick.tick);
        let trail_rows = (TRAIL_S / recording.dt_s).round() as usize;
        movers::now(page, view, &drive, row, trail_rows);
        robot::plans(page, view, trace, tick.tick, PLAN, &mut super::Legend::default());
        robot::track_by_speed(page, view, &drive, row + 1);
        sensed(page, view, recording, row);
        robot::now(page, view, &drive, row, ROBOT);

        robot::speed_legend(drive.robot(), legend);
        if !trace.paths.is_empty() {
            legend.add("plan", |page, at| {
                let bar = vec![at - Vec2::new(10.0, 0.0), at + Vec2::new(10.0, 0.0)];
                page.line(bar, Paint::line(PLAN, 1.5).dashed(5.0, 3.5));
            });
        }
        if trace.mover_count > 0 {
            let body = Paint::fill(Look::USUAL.fill).edged(Look::USUAL.edge, 1.0);
            legend.add("mover, its last 3 s", move |page, at| {
                page.line(vec![at, at - Vec2::new(11.0, 0.0)], Paint::line(Look::USUAL.edge, 1.2).faded(0.6));
                page.circle(at, 5.0, body);
            });
            legend.add("sensed", move |page, at| {
                page.circle(at, 4.0, body);
                page.circle(at, 7.5, Paint::line(SENSED, 2.0));
            });
        }
        if !recording.scene.unknown_static.is_empty() {
            legend.add("obstacle not on the map", |page, at| {
                map::swatch(page, at, Paint::fill(NOT_ON_MAP).edged(INK, 0.9))
            });
            legend.add("known by now", |page, at| map::swatch(page, at, Paint::fill(SENSED).faded(0.6)));
        }
        if trace.ray_count > 0 {
            legend.add("echo of the scanner", |page, at| page.circle(at, 1.8, Paint::fill(SENSED)));
        }
    });
    let words = format!("{time_s:.1} s");
    clock(&mut sheet.page, &sheet.view, &words);
    sheet.finish()
}

/// The unknown statics that are there at a time.
fn statics(page: &mut Picture, view: &super::View, drive: &Drive<'_>, time_s: f64) {
    for (obstacle, stay) in drive.scene().unknown_static.iter().zip(map::stays(drive.scene())) {
        if stay.from_s <= time_s && time_s < stay.until_s {
            let paint = Paint::fill(NOT_ON_MAP).edged(INK, 0.9);
            outlined(page, view, obstacle.outline(), obstacle.pose().position, paint);
        }
    }
}

/// The cells that the robot has added to the map by a tick.
fn believed(page: &mut Picture, view: &super::View, recording: &Recording, tick: u32) {
    let mut cells: BTreeSet<Cell> = BTreeSet::new();
    for change in recording.detail.belief.iter().take_while(|change| change.tick <= tick) {
        cells.extend(&change.entered);
        change.left.iter().for_each(|cell| {
            cells.remove(cell);
        });
    }
    if !cells.is_empty() {
        let cells: Vec<Cell> = cells.into_iter().collect();
        map::cells(page, view, &recording.scene.map.grid, &cells, Paint::fill(SENSED).faded(0.6));
    }
}

/// Rings about the movers that the robot sensed when it decided what it does at this row, and the echoes of its scanner.
fn sensed(page: &mut Picture, view: &super::View, recording: &Recording, row: usize) {
    let (trace, detail) = (&recording.trace, &recording.detail);
    let before = row.saturating_sub(1);
    if before < detail.ticks() {
        for obstacle in detail.sensed_at(before) {
            // The ring is about where the mover is now, not where it was sensed a tick ago.
            let now = trace.movers_at(row).get(obstacle.id as usize).filter(|mover| mover.present);
            let at = view.at(now.map_or(obstacle.position, |mover| mover.position));
            let radius = math::max(obstacle.radius_m() * view.scale, 2.0) + 3.5;
            page.circle(at, radius, Paint::line(SENSED, 2.0));
        }
    }
    let Some(lidar) = recording.sensing.lidar.as_ref().filter(|_| trace.ray_count > 0) else { return };
    let (first_rad, step_rad) = lidar.bearings_rad();
    let eye = trace.ticks[before].pose;
    let ranges = trace.ranges_m.chunks_exact(trace.ray_count).nth(before).unwrap_or_default();
    for (ray, range_m) in ranges.iter().enumerate().filter(|(_, range_m)| range_m.is_finite()) {
        let bearing_rad = first_rad + ray as f64 * step_rad;
        let echo = eye.position + direction(eye.theta + bearing_rad) * *range_m;
        page.circle(view.at(echo), 1.5, Paint::fill(SENSED));
    }
}

/// For how long the last picture of a film is shown, and any other, hundredths of a second.
pub fn shown_cs(index: usize, count: usize) -> u16 {
    if index + 1 == count { 200 } else { 8 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_picture_stays() {
        assert_eq!((shown_cs(0, 3), shown_cs(2, 3)), (8, 200));
    }
}
