//! Axes with their grid.

use super::scale::{Scale, Tick};
use super::{Anchor, Drawing, Ink, text_width_px};

/// Size of the labels of axes, px.
pub(super) const LABEL_PX: f64 = 11.0;

/// Draws the x axis of a plot whose drawing area goes from `top` down to `bottom`: grid, ticks, and the label below. It needs 32 px below
/// `bottom`.
pub fn axis_x(drawing: &mut Drawing, ink: &Ink, scale: &Scale, (top, bottom): (f64, f64), label: &str) {
    let width_px = (scale.to_px - scale.from_px).abs();
    let ticks = spaced(scale, width_px / 48.0, |ticks| {
        let widest = ticks.iter().map(|tick| text_width_px(&tick.label, LABEL_PX)).fold(0.0, crate::math::max);
        (ticks.len() as f64) * (widest + 10.0) <= width_px + widest
    });
    for Tick { value, label } in &ticks {
        let x = scale.at(*value);
        drawing.line((x, top), (x, bottom), ink.grid, 1.0);
        drawing.text((x, bottom + 14.0), Anchor::Middle, LABEL_PX, ink.muted, label);
    }
    let middle = (scale.from_px + scale.to_px) / 2.0;
    drawing.text((middle, bottom + 29.0), Anchor::Middle, LABEL_PX, ink.muted, label);
}

/// Draws the y axis of a plot whose drawing area goes from `left` to `right`: grid and ticks; the label stands above the axis, where
/// it is read without turning the head. It needs 16 px above.
pub fn axis_y(drawing: &mut Drawing, ink: &Ink, scale: &Scale, (left, right): (f64, f64), label: &str) {
    let height_px = (scale.to_px - scale.from_px).abs();
    for Tick { value, label } in &scale.ticks((height_px / 36.0) as usize) {
        let y = scale.at(*value);
        drawing.line((left, y), (right, y), ink.grid, 1.0);
        drawing.text((left - 6.0, y + 4.0), Anchor::End, LABEL_PX, ink.muted, label);
    }
    let top = crate::math::min(scale.from_px, scale.to_px);
    drawing.text((0.0, top - 8.0), Anchor::Start, LABEL_PX, ink.muted, label);
}

/// The room that the labels of a y axis need to its left, px.
pub(super) fn room_y_px(scale: &Scale) -> f64 {
    let height_px = (scale.to_px - scale.from_px).abs();
    let ticks = scale.ticks((height_px / 36.0) as usize);
    ticks.iter().map(|tick| text_width_px(&tick.label, LABEL_PX)).fold(0.0, crate::math::max) + 8.0
}

/// As many ticks as `most`, or fewer so that they fit.
fn spaced(scale: &Scale, most: f64, fits: impl Fn(&[Tick]) -> bool) -> Vec<Tick> {
    let most = (most as usize).clamp(1, 10);
    let choices = (1..=most).rev().map(|about| scale.ticks(about));
    let mut last = Vec::new();
    for ticks in choices {
        if fits(&ticks) {
            return ticks;
        }
        last = ticks;
    }
    last
}
