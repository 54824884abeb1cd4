//! A panel of values over a key or a column: means with intervals, and the points of worlds behind them.

use super::axis::{Axis, Extent};
use super::sheet::{LINE_PX, Sheet};
use crate::math;
use crate::report::chart::Tick;
use crate::report::palette::{GRID_LINE, INK, series as series_colour};
use crate::report::picture::Anchor;

/// A panel of curves.
#[derive(Clone, Debug, Default)]
pub(super) struct Curves {
    pub x_label: String,
    pub y_label: String,
    /// Places of x, if it has few; else x is continuous.
    pub x_places: Vec<Tick>,
    /// Values that the y axis must hold.
    pub y_ends: Option<(f64, f64)>,
    pub is_log: [bool; 2],
    /// Whether means are joined by lines: x has an order.
    pub is_joined: bool,
    pub curves: Vec<Curve>,
}

/// One curve.
#[derive(Clone, Debug, Default)]
pub(super) struct Curve {
    /// Number of its colour and mark.
    pub series: usize,
    pub means: Vec<Mean>,
    /// Points of worlds, x and y.
    pub cloud: Vec<(f64, f64)>,
}

/// A mean at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mean {
    pub x: f64,
    pub y: f64,
    pub interval: Option<(f64, f64)>,
}

impl Curves {
    /// Height of the panel with its labels, px.
    pub fn height_px(&self, font_px: f64) -> f64 {
        17.5 * font_px
    }

    pub fn draw(&self, sheet: &mut Sheet, (left, top): (f64, f64), width_px: f64) {
        let font = sheet.font_px;
        let (from, bottom) = (top + 1.9 * font, top + self.height_px(font) - 3.4 * font);
        let means = || self.curves.iter().flat_map(|curve| &curve.means);
        let intervals = means().filter_map(|mean| mean.interval).flat_map(|(low, high)| [low, high]);
        let cloud = || self.curves.iter().flat_map(|curve| &curve.cloud);
        let ys = means().map(|mean| mean.y).chain(intervals).chain(cloud().map(|point| point.1));
        let y_extent = Extent { values: ys.collect(), ends: self.y_ends, places: Vec::new(), is_log: self.is_log[1] };
        let y = Axis::new(&y_extent, ((bottom - from) / (2.6 * font)) as usize, (bottom, from));
        let widest = y.ticks.iter().map(|tick| sheet.width_of(&tick.label)).fold(0.0, math::max);
        let (start, end) = (left + widest + 0.9 * font, left + width_px - 0.3 * font);
        let xs = means().map(|mean| mean.x).chain(cloud().map(|point| point.0)).collect();
        let x_extent = Extent { values: xs, ends: None, places: self.x_places.clone(), is_log: self.is_log[0] };
        let x = Axis::new(&x_extent, ((end - start) / (4.5 * font)) as usize, (start, end));

        sheet.text((left, top + 0.9 * font), Anchor::Start, INK, &self.y_label);
        for tick in &y.ticks {
            let at = y.within(tick.value);
            sheet.line((start, at), (end, at), GRID_LINE, 0.6);
            sheet.text((start - 0.5 * font, at + 0.35 * font), Anchor::End, INK, &tick.label);
        }
        for (tick, words) in x.ticks.iter().zip(self.fitted(sheet, &x)) {
            let at = x.within(tick.value);
            sheet.line((at, bottom), (at, bottom + 0.3 * font), INK, 0.8);
            for (line, word) in words.iter().enumerate() {
                let base = bottom + (1.35 + 1.1 * line as f64) * font;
                sheet.text((at, base), Anchor::Middle, INK, word);
            }
        }
        sheet.line((start, bottom), (end, bottom), INK, 0.8);
        let middle = (start + end) / 2.0;
        sheet.label((middle, bottom + 2.8 * font), (left, left + width_px), &self.x_label);
        self.draw_curves(sheet, &x, &y, end - start);
    }

    fn draw_curves(&self, sheet: &mut Sheet, x: &Axis, y: &Axis, width_px: f64) {
        let font = sheet.font_px;
        // Curves stand beside each other at a place, so that their intervals do not cover one another.
        let places: Vec<f64> = self.x_places.iter().filter_map(|tick| x.at(tick.value)).collect();
        let gap = places.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(width_px, math::min);
        let count = self.curves.len() as f64;
        let step = if places.is_empty() { 0.0 } else { math::min(0.75 * font, 0.8 * gap / count) };
        let shift = |at: usize| (at as f64 - (count - 1.0) / 2.0) * step;
        let placed = |at: usize, px: f64, py: f64| Some((x.at(px)? + shift(at), y.at(py)?));
        for (at, curve) in self.curves.iter().enumerate() {
            let room = if places.is_empty() { 0.0 } else { 0.7 * math::min(step, font) };
            // The golden ratio spreads neighbours of any sequence evenly, and the same way every time.
            let aside = |k: usize| ((k as f64 * 0.618_033_988_75).fract() - 0.5) * room;
            let points = curve.cloud.iter().enumerate().filter_map(|(k, &(px, py))| {
                let (px, py) = placed(at, px, py)?;
                Some((px + aside(k), py))
            });
            sheet.cloud(points.collect::<Vec<_>>(), series_colour(curve.series));
        }
        for (at, curve) in self.curves.iter().enumerate() {
            let colour = series_colour(curve.series);
            let means: Vec<(f64, f64)> = curve.means.iter().filter_map(|mean| placed(at, mean.x, mean.y)).collect();
            if self.is_joined {
                sheet.polyline(&means, colour, 1.2 * LINE_PX);
            }
            for mean in &curve.means {
                let (Some((px, _)), Some((low, high))) = (placed(at, mean.x, mean.y), mean.interval) else { continue };
                let (low, high, cap) = (y.within(low), y.within(high), 0.2 * font);
                sheet.line((px, low), (px, high), colour, LINE_PX);
                for end in [low, high] {
                    sheet.line((px - cap, end), (px + cap, end), colour, LINE_PX);
                }
            }
            means.into_iter().for_each(|place| sheet.mark(curve.series, place));
        }
    }

    /// The labels of the x axis in lines; where they are too wide for their places, words are parted at `_` and `+`, then some left out.
    fn fitted(&self, sheet: &Sheet, x: &Axis) -> Vec<Vec<String>> {
        let at: Vec<f64> = x.ticks.iter().map(|tick| x.within(tick.value)).collect();
        let gap = at.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(f64::INFINITY, math::min);
        let one: Vec<Vec<String>> = x.ticks.iter().map(|tick| vec![tick.label.clone()]).collect();
        let fits = |labels: &[Vec<String>], every: usize| {
            labels
                .iter()
                .step_by(every)
                .flatten()
                .all(|word| sheet.width_of(word) + 0.6 * sheet.font_px <= gap * every as f64)
        };
        if fits(&one, 1) {
            return one;
        }
        let two: Vec<Vec<String>> = x.ticks.iter().map(|tick| parted(&tick.label)).collect();
        if fits(&two, 1) {
            return two;
        }
        let every = (2..=one.len().max(2)).find(|&every| fits(&one, every)).unwrap_or(1);
        one.into_iter().enumerate().map(|(at, words)| if at % every == 0 { words } else { Vec::new() }).collect()
    }
}

/// A name in two lines, parted as near to its middle as it can be.
fn parted(name: &str) -> Vec<String> {
    let middle = name.len() / 2;
    let cuts = name.char_indices().filter(|(_, c)| ['_', '+', ' '].contains(c)).map(|(at, _)| at + 1);
    match cuts.min_by_key(|at| at.abs_diff(middle)) {
        Some(at) => vec![name[..at].trim_end().to_owned(), name[at..].to_owned()],
        None => vec![name.to_owned()],
    }
}
