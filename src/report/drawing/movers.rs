//! Moving obstacles: where each was at first and at last, its track, and when it was where.

use super::labels::Labels;
use super::legend::Legend;
use super::view::View;
use super::{Drive, LABEL, emblem, outlined};
use crate::geometry::Vec2;
use crate::report::palette::{Colour, FAINT_INK, GRID_LINE, MOVER, MOVER_EDGE};
use crate::report::picture::{Paint, Picture, Text};
use std::ops::Range;

/// Times beside the tracks of movers, all of them together: those nearest the robot.
const LABELS_MAX: usize = 24;

/// The rows of a trace in which a mover is there, run by run.
fn runs(drive: &Drive<'_>, index: usize, rows: Range<usize>) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for row in rows.filter(|row| drive.trace().movers_at(*row)[index].present) {
        match runs.last_mut() {
            Some(run) if run.end == row => run.end = row + 1,
            _ => runs.push(row..row + 1),
        }
    }
    runs
}

/// How movers are painted.
#[derive(Clone, Copy)]
pub(super) struct Look {
    pub fill: Colour,
    pub edge: Colour,
}

impl Look {
    pub const USUAL: Self = Self { fill: MOVER, edge: MOVER_EDGE };
    /// Beside tracks in colours of their own.
    pub const PLAIN: Self = Self { fill: GRID_LINE, edge: FAINT_INK };

    fn track(self) -> Paint {
        Paint::line(self.edge, 1.2).faded(0.6)
    }

    fn ghost(self) -> Paint {
        Paint::line(self.edge, 1.1).faded(0.8)
    }

    fn body(self) -> Paint {
        Paint::fill(self.fill).edged(self.edge, 1.0)
    }
}

/// Labels would rather not lie on tracks of movers, nor on what is there at last.
pub(super) fn keep_clear(view: &View, drive: &Drive<'_>, labels: &mut Labels) {
    let trace = drive.trace();
    let places = trace.movers.iter().filter(|mover| mover.present && view.shows(mover.position)).step_by(4);
    labels.avoid(places.map(|mover| view.at(mover.position)));
    let Some(last) = drive.rows().checked_sub(1) else { return };
    for (mover, state) in drive.scene().movers.iter().zip(trace.movers_at(last)).filter(|(_, state)| state.present) {
        labels.take(view.at(state.position), 0.7 * mover.radius_m() * view.scale);
    }
}

/// The tracks of all movers, for beneath that of the robot.
pub(super) fn tracks(page: &mut Picture, view: &View, drive: &Drive<'_>, look: Look) {
    let rows = 0..drive.rows();
    for index in 0..drive.trace().mover_count {
        let at = |row: usize| drive.trace().movers_at(row)[index].position;
        let lines = runs(drive, index, rows.clone()).into_iter().map(|run| view.track(run.map(at)));
        page.lines(lines.collect(), look.track());
    }
}

/// Each mover at its first and at its last row, with where it would be a second later. One that has left by the end has its last outline
/// dashed.
pub(super) fn bodies(page: &mut Picture, view: &View, drive: &Drive<'_>, look: Look, legend: &mut Legend) {
    let rows = drive.rows();
    let mut left_early = false;
    let mut shape = None;
    for (index, mover) in drive.scene().movers.iter().enumerate() {
        let runs = runs(drive, index, 0..rows);
        let (Some(first), Some(last)) = (runs.first(), runs.last()) else { continue };
        shape.get_or_insert_with(|| mover.outline.shape().clone());
        let state = |row: usize| drive.trace().movers_at(row)[index];
        outlined(page, view, &mover.outline, state(first.start).position, look.ghost());
        let end = state(last.end - 1);
        if last.end < rows {
            left_early = true;
            outlined(page, view, &mover.outline, end.position, Paint::line(look.edge, 1.1).dashed(2.0, 2.0));
        } else {
            outlined(page, view, &mover.outline, end.position, look.body());
            let ahead = vec![view.at(end.position), view.at(end.position + end.velocity)];
            page.line(ahead, Paint::line(look.edge, 1.5));
        }
    }
    let Some(shape) = shape else { return };
    let at_first = shape.clone();
    legend.add("mover at first", move |page, at| emblem(page, at, &at_first, look.ghost()));
    legend.add("mover at last, and 1 s on", move |page, at| {
        emblem(page, at - Vec2::new(3.0, 0.0), &shape, look.body());
        page.line(vec![at - Vec2::new(3.0, 0.0), at + Vec2::new(10.0, 0.0)], Paint::line(look.edge, 1.5));
    });
    legend.add("its track", move |page, at| {
        page.line(vec![at - Vec2::new(10.0, 0.0), at + Vec2::new(10.0, 0.0)], look.track());
    });
    if left_early {
        legend.add("where a mover left", move |page, at| {
            page.circle(at, 5.0, Paint::line(look.edge, 1.1).dashed(2.0, 2.0))
        });
    }
}

/// Each mover as it is at a row, with its track of the last seconds.
pub(super) fn now(page: &mut Picture, view: &View, drive: &Drive<'_>, row: usize, trail_rows: usize) {
    let look = Look::USUAL;
    for (index, mover) in drive.scene().movers.iter().enumerate() {
        let state = drive.trace().movers_at(row)[index];
        if !state.present {
            continue;
        }
        let runs = runs(drive, index, row.saturating_sub(trail_rows)..row + 1);
        let trail = runs.last().cloned().unwrap_or(row..row + 1);
        page.line(view.track(trail.map(|row| drive.trace().movers_at(row)[index].position)), look.track());
        outlined(page, view, &mover.outline, state.position, look.body());
    }
}

/// Dots on the tracks at the times of `marks`, rows with their times; beside those nearest the robot the time.
pub(super) fn times(
    page: &mut Picture,
    view: &View,
    drive: &Drive<'_>,
    look: Look,
    marks: &[(usize, String)],
    labels: &mut Labels,
) {
    let trace = drive.trace();
    let mut spots = Vec::new();
    for (row, words) in marks {
        let robot = trace.ticks[*row].pose.position;
        for mover in trace.movers_at(*row).iter().filter(|mover| mover.present && view.shows(mover.position)) {
            let at = view.at(mover.position);
            page.circle(at, 1.9, Paint::fill(look.edge));
            spots.push(((mover.position - robot).norm(), at, words));
        }
    }
    spots.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, spot, words) in spots.into_iter().take(LABELS_MAX) {
        if let Some((at, anchor)) = labels.place(spot, 4.0, words, LABEL, false) {
            let text = Text::new(at, LABEL, words.as_str()).anchored(anchor).coloured(look.edge);
            page.text(Text { rimmed: true, ..text });
        }
    }
}
