//! Two axes in metres of the map's own frame, as scenarios give positions, with ticks at round numbers.

use super::view::View;
use crate::geometry::{Rect, Vec2};
use crate::map::Frame;
use crate::math;
use crate::report::chart::nice_step;
use crate::report::palette::{FAINT_INK, GRID_LINE, INK};
use crate::report::picture::{Anchor, Paint, Picture, Text};

/// Room that the vertical axis takes beside the map.
pub(super) const LEFT: f64 = 50.0;
/// Room that the horizontal axis takes beneath the map.
pub(super) const BELOW: f64 = 42.0;
const TICK: f64 = 4.0;
const SIZE: f64 = 11.0;
/// Distance of two ticks at least.
const APART: f64 = 48.0;

/// One, two or five times a power of ten, the smallest that is at least `least`, which is positive.
pub(super) fn round_step(least: f64) -> f64 {
    nice_step(least, 1).0
}

fn rounded(x: f64) -> f64 {
    (x * 1e9).round() / 1e9
}

/// The multiples of `step` from `low` to `high`.
pub(super) fn multiples(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let (first, last) = ((low / step - 1e-6).ceil() as i64, (high / step + 1e-6).floor() as i64);
    (first..=last).map(move |k| rounded(k as f64 * step))
}

/// A number of an axis, with a minus sign.
pub(super) fn signed(x: f64) -> String {
    math::canonical(x).to_string().replace('-', "\u{2212}")
}

pub(super) struct Axes {
    step: f64,
    /// What is added to grid coordinates to have those of the map.
    offset: Vec2,
    titles: [&'static str; 2],
}

impl Axes {
    pub fn new(view: &View, frame: &Frame) -> Self {
        let step = round_step(APART / view.scale);
        // A map that is turned has no axes along the page but those of its grid.
        if frame.origin.theta == 0.0 {
            Self { step, offset: frame.origin.position, titles: ["x (m)", "y (m)"] }
        } else {
            Self { step, offset: Vec2::zeros(), titles: ["along the grid (m)", "across the grid (m)"] }
        }
    }

    fn ticks(&self, view: &View) -> [Vec<f64>; 2] {
        let (low, high) = (view.window.min + self.offset, view.window.max + self.offset);
        [multiples(low.x, high.x, self.step).collect(), multiples(low.y, high.y, self.step).collect()]
    }

    /// Pale lines at the ticks, for beneath everything.
    pub fn grid(&self, page: &mut Picture, view: &View) {
        let Rect { min, max } = view.plot;
        let [across, up] = self.ticks(view);
        let vertical = across.into_iter().map(|x| view.at(Vec2::new(x - self.offset.x, 0.0)).x);
        let vertical = vertical.map(|x| vec![Vec2::new(x, min.y), Vec2::new(x, max.y)]);
        let level = up.into_iter().map(|y| view.at(Vec2::new(0.0, y - self.offset.y)).y);
        let level = level.map(|y| vec![Vec2::new(min.x, y), Vec2::new(max.x, y)]);
        page.lines(vertical.chain(level).collect(), Paint::line(GRID_LINE, 0.8));
    }

    /// The frame about the map, ticks and their numbers.
    pub fn frame(&self, page: &mut Picture, view: &View) {
        let Rect { min, max } = view.plot;
        let [across, up] = self.ticks(view);
        let mut ticks = Vec::new();
        for x in across {
            let at = Vec2::new(view.at(Vec2::new(x - self.offset.x, 0.0)).x, max.y);
            ticks.push(vec![at, at + Vec2::new(0.0, TICK)]);
            page.text(Text::new(at + Vec2::new(0.0, TICK + 11.0), SIZE, signed(x)).anchored(Anchor::Middle));
        }
        for y in up {
            let at = Vec2::new(min.x, view.at(Vec2::new(0.0, y - self.offset.y)).y);
            ticks.push(vec![at, at - Vec2::new(TICK, 0.0)]);
            page.text(Text::new(at + Vec2::new(-TICK - 3.0, 4.0), SIZE, signed(y)).anchored(Anchor::End));
        }
        page.lines(ticks, Paint::line(INK, 1.0));
        page.rect(view.plot, Paint::line(INK, 1.0));
        let [x, y] = self.titles;
        let middle = (min + max) * 0.5;
        let beneath = Vec2::new(middle.x, max.y + BELOW - 10.0);
        page.text(Text::new(beneath, SIZE, x).anchored(Anchor::Middle).coloured(FAINT_INK));
        let beside = Text::new(Vec2::new(min.x - LEFT + 14.0, middle.y), SIZE, y).anchored(Anchor::Middle);
        page.text(Text { upward: true, ..beside.coloured(FAINT_INK) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        let steps = [0.03, 0.2, 0.21, 1.0, 1.7, 3.0, 7.0, 10.0, 120.0].map(round_step);
        assert_eq!(steps, [0.05, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 10.0, 200.0]);
    }

    #[test]
    fn ticks_lie_inside_and_read_well() {
        let ticks: Vec<String> = multiples(-0.35, 0.4, 0.1).map(signed).collect();
        assert_eq!(ticks, ["\u{2212}0.3", "\u{2212}0.2", "\u{2212}0.1", "0", "0.1", "0.2", "0.3", "0.4"]);
    }
}
