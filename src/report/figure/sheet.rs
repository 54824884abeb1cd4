//! The paper that figures are drawn on: lines, areas, marks and texts, 96 pixels an inch, y down.

use crate::report::chart::{Anchor, Drawing, Ink, text_width_px};

pub(super) const INK: Ink = Ink::PRINT;

/// Pixels of a millimetre.
pub(super) const MM_PX: f64 = 96.0 / 25.4;

/// Width of axes and intervals, px.
pub(super) const LINE_PX: f64 = 1.0;

/// A sheet.
pub(super) struct Sheet {
    drawing: Drawing,
    /// Size of its texts, px.
    pub font_px: f64,
}

impl Sheet {
    pub fn new(width_px: f64, height_px: f64, font_px: f64) -> Self {
        let mut drawing = Drawing::new(width_px, height_px);
        drawing.rect((0.0, 0.0), (width_px, height_px), &format!("fill=\"{}\"", INK.paper));
        Self { drawing, font_px }
    }

    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), colour: &str, width_px: f64) {
        self.drawing.line(from, to, colour, width_px);
    }

    pub fn polyline(&mut self, points: &[(f64, f64)], colour: &str, width_px: f64) {
        if points.len() > 1 {
            let style =
                format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width_px}\" stroke-linejoin=\"round\"");
            self.drawing.polyline(points, &style);
        }
    }

    /// Dots of worlds, behind everything that is told of them.
    pub fn cloud(&mut self, points: impl IntoIterator<Item = (f64, f64)>, colour: &str) {
        self.drawing.dots(points, 0.1 * self.font_px, colour, 0.3);
    }

    /// A mark whose shape goes with its colour.
    pub fn mark(&mut self, series: usize, (x, y): (f64, f64)) {
        let r = 0.3 * self.font_px;
        let shape = match series % 4 {
            0 => {
                format!("M{:.2} {y:.2}a{r:.2} {r:.2} 0 1 0 {d:.2} 0a{r:.2} {r:.2} 0 1 0 -{d:.2} 0z", x - r, d = 2.0 * r)
            }
            1 => format!("M{:.2} {:.2}h{s:.2}v{s:.2}h-{s:.2}z", x - 0.9 * r, y - 0.9 * r, s = 1.8 * r),
            2 => format!("M{x:.2} {:.2}l{s:.2} {s:.2}l-{s:.2} {s:.2}l-{s:.2} -{s:.2}z", y - 1.25 * r, s = 1.25 * r),
            _ => format!("M{x:.2} {:.2}l{s:.2} {h:.2}h-{w:.2}z", y - 1.15 * r, s = 1.15 * r, h = 2.0 * r, w = 2.3 * r),
        };
        let (colour, paper) = (INK.series(series), INK.paper);
        self.drawing.path(&shape, &format!("fill=\"{colour}\" stroke=\"{paper}\" stroke-width=\"0.8\""));
    }

    pub fn text(&mut self, at: (f64, f64), anchor: Anchor, colour: &str, words: &str) {
        self.drawing.text(at, anchor, self.font_px, colour, words);
    }

    /// Width of a text, px.
    pub fn width_of(&self, words: &str) -> f64 {
        text_width_px(words, self.font_px)
    }

    /// The file; `says` is what it shows, in words.
    pub fn svg(self, says: &str) -> String {
        let size = format!(
            "<svg width=\"{}mm\" height=\"{}mm\" ",
            millimetres(self.drawing.width_px()),
            millimetres(self.drawing.height_px())
        );
        self.drawing.finish(says).replacen("<svg ", &size, 1)
    }
}

fn millimetres(px: f64) -> f64 {
    (px / MM_PX * 100.0).round() / 100.0
}
