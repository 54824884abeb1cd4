//! The paper that figures are drawn on: lines, marks and texts, 96 pixels an inch, y down.

use crate::geometry::{Rect, Vec2};
use crate::math;
use crate::report::palette::{self, Colour, INK, PAPER};
use crate::report::picture::{Anchor, Paint, Picture, Text, font};

/// Pixels of a millimetre.
pub(super) const MM_PX: f64 = 96.0 / 25.4;

/// Width of axes and intervals, px.
pub(super) const LINE_PX: f64 = 1.0;

/// A sheet.
pub(super) struct Sheet {
    pub picture: Picture,
    /// Size of its texts, px.
    pub font_px: f64,
}

impl Sheet {
    pub fn new(width_px: f64, height_px: f64, font_px: f64) -> Self {
        Self { picture: Picture::new(width_px, height_px), font_px }
    }

    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), colour: Colour, width_px: f64) {
        self.polyline(&[from, to], colour, width_px);
    }

    pub fn polyline(&mut self, points: &[(f64, f64)], colour: Colour, width_px: f64) {
        if points.len() > 1 {
            self.picture.line(points.iter().map(|&(x, y)| Vec2::new(x, y)).collect(), Paint::line(colour, width_px));
        }
    }

    /// Dots of worlds, behind everything that is told of them.
    pub fn cloud(&mut self, points: impl IntoIterator<Item = (f64, f64)>, colour: Colour) {
        let half = 0.09 * self.font_px;
        for (x, y) in points {
            let (min, max) = (Vec2::new(x - half, y - half), Vec2::new(x + half, y + half));
            self.picture.rect(Rect { min, max }, Paint::fill(colour).faded(0.45));
        }
    }

    /// A mark whose shape goes with its colour: disc, square, diamond, triangle.
    pub fn mark(&mut self, series: usize, (x, y): (f64, f64)) {
        let r = 0.3 * self.font_px;
        let paint = Paint::fill(palette::series(series)).edged(PAPER, 0.8);
        let corners: &[(f64, f64)] = match series % 4 {
            0 => return self.picture.circle(Vec2::new(x, y), r, paint),
            1 => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
            2 => &[(0.0, -1.25), (1.25, 0.0), (0.0, 1.25), (-1.25, 0.0)],
            _ => &[(0.0, -1.2), (1.15, 0.8), (-1.15, 0.8)],
        };
        let border = corners.iter().map(|(right, down)| Vec2::new(x + right * r, y + down * r)).collect();
        self.picture.area(vec![border], paint);
    }

    pub fn text(&mut self, (x, y): (f64, f64), anchor: Anchor, colour: Colour, words: &str) {
        self.picture.text(Text::new(Vec2::new(x, y), self.font_px, words).anchored(anchor).coloured(colour));
    }

    /// The label of an axis about its middle, moved so that it stays between the edges of its panel.
    pub fn label(&mut self, (middle, base): (f64, f64), (left, right): (f64, f64), words: &str) {
        let half = self.width_of(words) / 2.0;
        let at = math::max(left + half, math::min(middle, right - half));
        self.text((at, base), Anchor::Middle, INK, words);
    }

    /// Width of a text, px.
    pub fn width_of(&self, words: &str) -> f64 {
        font::width(words, self.font_px, false)
    }
}
