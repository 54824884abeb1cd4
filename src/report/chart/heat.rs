//! A value over two keys: a map of cells.

use super::axis::LABEL_PX;
use super::scale::number;
use super::strip::fitted;
use super::{Anchor, Drawing, Ink, text_width_px};
use crate::math;

/// A map of values.
#[derive(Clone, Debug)]
pub struct Heat {
    /// Width, px.
    pub width_px: f64,
    /// What the values are.
    pub label: String,
    /// The key along x, and its values.
    pub x: (String, Vec<String>),
    /// The key along y, and its values from the top.
    pub y: (String, Vec<String>),
    /// The cells, row by row from the top; `None` where nothing was run.
    pub cells: Vec<Option<HeatCell>>,
    /// Decimals of the numbers in the cells.
    pub decimals: usize,
    /// The values of the lightest and the darkest step; by the cells if not given.
    pub ends: Option<(f64, f64)>,
}

/// A cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatCell {
    /// Its value.
    pub value: f64,
    /// Whether it is the one to look at: it gets a frame.
    pub is_best: bool,
}

const ROW_PX: f64 = 30.0;

impl Heat {
    /// The map.
    ///
    /// # Panics
    /// If there are not as many cells as places.
    pub fn draw(&self, ink: &Ink) -> String {
        let ((x_key, xs), (y_key, ys)) = (&self.x, &self.y);
        assert_eq!(self.cells.len(), xs.len() * ys.len(), "one cell for each pair of values");
        let left = math::min(
            ys.iter().map(|word| text_width_px(word, LABEL_PX)).fold(20.0, math::max) + 10.0,
            0.35 * self.width_px,
        );
        let (top, side) = (24.0, (self.width_px - left - 4.0) / math::max(xs.len() as f64, 1.0));
        let bottom = top + ys.len() as f64 * ROW_PX;
        let mut drawing = Drawing::new(self.width_px, bottom + 78.0);
        drawing.text((0.0, 12.0), Anchor::Start, LABEL_PX, ink.muted, &fitted(y_key, self.width_px, LABEL_PX));
        let known = || self.cells.iter().flatten().map(|cell| cell.value);
        let (low, high) = self
            .ends
            .unwrap_or_else(|| (known().fold(f64::INFINITY, math::min), known().fold(f64::NEG_INFINITY, math::max)));
        let step = |value: f64| {
            let share = if high > low { math::clamp((value - low) / (high - low), 0.0, 1.0) } else { 0.5 };
            ((share * ink.ramp.len() as f64) as usize).min(ink.ramp.len() - 1)
        };
        let mut frame = None;
        for (at, cell) in self.cells.iter().enumerate() {
            let (col, row) = (at % xs.len(), at / xs.len());
            let place = (left + col as f64 * side, top + row as f64 * ROW_PX);
            let size = (side - 1.5, ROW_PX - 1.5);
            let Some(cell) = cell else {
                drawing.rect(place, size, &format!("fill=\"none\" stroke=\"{}\" stroke-dasharray=\"2 3\"", ink.grid));
                continue;
            };
            let step = step(cell.value);
            drawing.rect(place, size, &format!("fill=\"{}\"", ink.ramp[step]));
            let text = number(cell.value, self.decimals);
            let size_px = if text_width_px(&text, LABEL_PX) < side - 4.0 { LABEL_PX } else { 8.5 };
            if text_width_px(&text, size_px) < side {
                let middle = (place.0 + (side - 1.5) / 2.0, place.1 + 18.0);
                drawing.text(middle, Anchor::Middle, size_px, ink.on_ramp[step], &text);
            }
            if cell.is_best {
                frame = Some((place, size));
            }
        }
        if let Some((place, size)) = frame {
            drawing.rect(place, size, &format!("fill=\"none\" stroke=\"{}\" stroke-width=\"2.5\"", ink.text));
        }
        for (row, word) in ys.iter().enumerate() {
            let y = top + row as f64 * ROW_PX + 18.0;
            drawing.text((left - 6.0, y), Anchor::End, LABEL_PX, ink.muted, &fitted(word, left - 6.0, LABEL_PX));
        }
        for (col, word) in xs.iter().enumerate() {
            let x = left + (col as f64 + 0.5) * side;
            drawing.text((x, bottom + 13.0), Anchor::Middle, LABEL_PX, ink.muted, &fitted(word, side, LABEL_PX));
        }
        let x_key = fitted(x_key, self.width_px - left, LABEL_PX);
        drawing.text((left + (self.width_px - left) / 2.0, bottom + 29.0), Anchor::Middle, LABEL_PX, ink.muted, &x_key);
        self.legend(&mut drawing, ink, (low, high), bottom + 44.0);
        drawing.finish(&format!("{} over {} and {}", self.label, self.x.0, self.y.0))
    }

    fn legend(&self, drawing: &mut Drawing, ink: &Ink, (low, high): (f64, f64), y: f64) {
        if !(low.is_finite() && high.is_finite()) {
            return;
        }
        let ends = [number(low, self.decimals), number(high, self.decimals)];
        let from = 4.0 + text_width_px(&ends[0], LABEL_PX) + 6.0;
        drawing.text((4.0, y + 9.5), Anchor::Start, LABEL_PX, ink.muted, &ends[0]);
        for (step, colour) in ink.ramp.iter().enumerate() {
            drawing.rect((from + 18.0 * step as f64, y), (18.0, 11.0), &format!("fill=\"{colour}\""));
        }
        let after = from + 18.0 * ink.ramp.len() as f64 + 6.0;
        drawing.text((after, y + 9.5), Anchor::Start, LABEL_PX, ink.muted, &format!("{} ({})", ends[1], self.label));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_carry_their_numbers_and_the_best_one_a_frame() {
        let cell = |value: f64, is_best: bool| Some(HeatCell { value, is_best });
        let map = Heat {
            width_px: 320.0,
            label: "success, %".to_owned(),
            x: ("a".to_owned(), vec!["1".to_owned(), "2".to_owned()]),
            y: ("b".to_owned(), vec!["x".to_owned(), "y".to_owned()]),
            cells: vec![cell(10.0, false), cell(100.0, true), None, cell(55.0, false)],
            decimals: 0,
            ends: Some((0.0, 100.0)),
        };
        let svg = map.draw(&Ink::PAGE);
        assert!(svg.contains(">10</text>") && svg.contains(">55</text>"));
        assert_eq!((svg.matches("stroke-width=\"2.5\"").count(), svg.matches("stroke-dasharray").count()), (1, 1));
    }
}
