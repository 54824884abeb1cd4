//! A panel with a row for each stack: its mean with an interval, and the points of worlds behind it.

use super::axis::{Axis, Extent};
use super::sheet::{LINE_PX, Sheet};
use crate::math;
use crate::report::palette::{FAINT_INK, GRID_LINE, INK, PAPER, series as series_colour};
use crate::report::picture::Anchor;

/// A panel of rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    pub label: String,
    /// Values that the axis must hold.
    pub ends: Option<(f64, f64)>,
    /// A value to compare with, drawn as a line: 0 for differences.
    pub reference: Option<f64>,
    pub is_log: bool,
    pub rows: Vec<Row>,
}

/// One row.
#[derive(Clone, Debug, Default)]
pub(super) struct Row {
    pub name: String,
    /// Number of its colour and mark.
    pub series: usize,
    pub mean: Option<f64>,
    pub interval: Option<(f64, f64)>,
    /// Points of worlds.
    pub cloud: Vec<f64>,
}

/// Height of a row, in heights of letters.
const ROW: f64 = 2.3;

impl Rows {
    /// Height of the panel with its labels, px.
    pub fn height_px(&self, font_px: f64) -> f64 {
        (self.rows.len() as f64 * ROW + 3.6) * font_px
    }

    pub fn draw(&self, sheet: &mut Sheet, (left, top): (f64, f64), width_px: f64) {
        let font = sheet.font_px;
        let names: Vec<Vec<String>> = self.rows.iter().map(|row| in_lines(sheet, &row.name, 0.4 * width_px)).collect();
        let widest = names.iter().flatten().map(|line| sheet.width_of(line)).fold(0.0, math::max);
        let (start, end) = (left + widest + 0.9 * font, left + width_px - 1.2 * font);
        let bottom = top + self.rows.len() as f64 * ROW * font + 0.2 * font;
        let intervals = self.rows.iter().filter_map(|row| row.interval).flat_map(|(low, high)| [low, high]);
        let values = self.rows.iter().flat_map(|row| row.cloud.iter().copied().chain(row.mean));
        let extent = Extent {
            values: values.chain(intervals).chain(self.reference).collect(),
            ends: self.ends,
            places: Vec::new(),
            is_log: self.is_log,
        };
        let axis = Axis::new(&extent, ((end - start) / (4.5 * font)) as usize, (start, end));

        for tick in &axis.ticks {
            let at = axis.within(tick.value);
            sheet.line((at, top), (at, bottom), GRID_LINE, 0.6);
            sheet.line((at, bottom), (at, bottom + 0.3 * font), INK, 0.8);
            sheet.text((at, bottom + 1.35 * font), Anchor::Middle, INK, &tick.label);
        }
        sheet.line((start, bottom), (end, bottom), INK, 0.8);
        sheet.label(((start + end) / 2.0, bottom + 2.7 * font), (left, left + width_px), &self.label);
        if let Some(reference) = self.reference.and_then(|value| axis.at(value)) {
            sheet.line((reference, top), (reference, bottom), FAINT_INK, LINE_PX);
        }
        for (at, (row, lines)) in self.rows.iter().zip(&names).enumerate() {
            let y = top + (at as f64 + 0.5) * ROW * font;
            for (line, words) in lines.iter().enumerate() {
                let base = y + (0.35 + 1.05 * (line as f64 - (lines.len() as f64 - 1.0) / 2.0)) * font;
                sheet.text((start - 0.7 * font, base), Anchor::End, INK, words);
            }
            row.draw(sheet, &axis, y);
        }
    }
}

impl Row {
    fn draw(&self, sheet: &mut Sheet, axis: &Axis, y: f64) {
        let (font, colour) = (sheet.font_px, series_colour(self.series));
        let aside = |k: usize| ((k as f64 * 0.618_033_988_75).fract() - 0.5) * 1.5 * font;
        let points = self.cloud.iter().enumerate().filter_map(|(k, value)| Some((axis.at(*value)?, y + aside(k))));
        sheet.cloud(points.collect::<Vec<_>>(), colour);
        if let Some((low, high)) = self.interval {
            let (low, high, cap) = (axis.within(low), axis.within(high), 0.25 * font);
            // A rim of paper, so that it can be read over the points.
            sheet.line((low, y), (high, y), PAPER, 3.5 * LINE_PX);
            sheet.line((low, y), (high, y), INK, 1.2 * LINE_PX);
            for end in [low, high] {
                sheet.line((end, y - cap), (end, y + cap), INK, 1.2 * LINE_PX);
            }
        }
        match self.mean.and_then(|mean| axis.at(mean)) {
            Some(x) => sheet.mark(self.series, (x, y)),
            None => sheet.text(
                (axis.within(f64::NEG_INFINITY) + 0.3 * font, y + 0.35 * font),
                Anchor::Start,
                FAINT_INK,
                "no value",
            ),
        }
    }
}

/// A name in lines of at most `width_px`, parted behind `+`.
fn in_lines(sheet: &Sheet, name: &str, width_px: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for part in name.split_inclusive('+') {
        let line = lines.last_mut().expect("at least one line");
        if !line.is_empty() && sheet.width_of(line) + sheet.width_of(part) > width_px {
            lines.push(part.to_owned());
        } else {
            line.push_str(part);
        }
    }
    lines
}
