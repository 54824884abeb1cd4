//! Points of worlds, one strip a stack: the spread and not the mean alone.

use super::axis::{LABEL_PX, axis_x};
use super::{Anchor, Drawing, Ink, Scale, text_width_px};

/// A chart of strips.
#[derive(Clone, Debug)]
pub struct Strip {
    /// Width, px.
    pub width_px: f64,
    /// Label of the axis.
    pub label: String,
    /// The strips, from the top.
    pub rows: Vec<StripRow>,
}

/// One strip.
#[derive(Clone, Debug, Default)]
pub struct StripRow {
    /// Its name.
    pub name: String,
    /// Number of the colour ([`Ink::series`]).
    pub series: usize,
    /// The points; each stands at a height that its place in the list decides.
    pub points: Vec<f64>,
    /// Mean of all values, also of those that are not shown.
    pub mean: Option<f64>,
    /// First quartile, median, third quartile.
    pub quartiles: Option<[f64; 3]>,
    /// What stands at the right end of its name, such as the mean.
    pub note: String,
}

/// Height of a strip with its name, px.
const ROW_PX: f64 = 46.0;
/// Height of the band of points, px.
const BAND_PX: f64 = 20.0;

impl Strip {
    /// The chart.
    pub fn draw(&self, ink: &Ink) -> String {
        let height = self.rows.len() as f64 * ROW_PX + 38.0;
        let mut drawing = Drawing::new(self.width_px, height);
        let values = self
            .rows
            .iter()
            .flat_map(|row| row.points.iter().copied().chain(row.mean).chain(row.quartiles.into_iter().flatten()));
        let scale = Scale::covering_near_zero(values, 6, (14.0, self.width_px - 14.0));
        axis_x(&mut drawing, ink, &scale, (4.0, height - 34.0), &self.label);
        for (at, row) in self.rows.iter().enumerate() {
            let top = at as f64 * ROW_PX;
            row.draw(&mut drawing, ink, &scale, top);
        }
        let names: Vec<String> = self.rows.iter().map(|row| format!("{} {}", row.name, row.note)).collect();
        drawing.finish(&format!("{}: {}", self.label, names.join("; ")))
    }
}

impl StripRow {
    fn draw(&self, drawing: &mut Drawing, ink: &Ink, scale: &Scale, top: f64) {
        let colour = ink.series(self.series);
        name_line(drawing, ink, top + 13.0, &self.name, &self.note);
        let middle = top + 19.0 + BAND_PX / 2.0;
        if self.points.is_empty() && self.mean.is_none() {
            drawing.text((scale.from_px, middle + 4.0), Anchor::Start, LABEL_PX, ink.muted, "no value");
            return;
        }
        // The golden ratio spreads neighbours of any sequence evenly, and the same way every time.
        let height = |k: usize| middle + ((k as f64 * 0.618_033_988_75).fract() - 0.5) * BAND_PX;
        let opacity = if self.points.len() > 150 { 0.35 } else { 0.55 };
        let points = self.points.iter().enumerate().map(|(k, &value)| (scale.at(value), height(k)));
        drawing.dots(points, 1.8, colour, opacity);
        if let Some([low, median, high]) = self.quartiles {
            let (low, median, high) = (scale.at(low), scale.at(median), scale.at(high));
            drawing.line((low, middle), (high, middle), ink.paper, 6.0);
            drawing.line((low, middle), (high, middle), ink.text, 2.5);
            drawing.line((median, middle - 7.0), (median, middle + 7.0), ink.paper, 5.0);
            drawing.line((median, middle - 7.0), (median, middle + 7.0), ink.text, 2.5);
        }
        if let Some(mean) = self.mean {
            let x = scale.at(mean);
            drawing.path(
                &format!("M{:.1} {:.1}l5 5l-5 5l-5 -5z", x, middle - 5.0),
                &format!("fill=\"{}\" stroke=\"{}\" stroke-width=\"1.8\"", ink.paper, ink.text),
            );
        }
    }
}

/// A name on the left and a note on the right of one line; a name that is too long loses its end.
pub(super) fn name_line(drawing: &mut Drawing, ink: &Ink, y: f64, name: &str, note: &str) {
    let right = drawing.width_px() - 4.0;
    let room = right - 8.0 - if note.is_empty() { 0.0 } else { text_width_px(note, LABEL_PX) + 10.0 };
    drawing.text((4.0, y), Anchor::Start, 12.0, ink.text, &fitted(name, room, 12.0));
    if !note.is_empty() {
        drawing.text((right, y), Anchor::End, LABEL_PX, ink.muted, note);
    }
}

/// A text cut so that it fits.
pub(super) fn fitted(text: &str, room_px: f64, size_px: f64) -> String {
    if text_width_px(text, size_px) <= room_px {
        return text.to_owned();
    }
    let mut kept: Vec<char> = text.chars().collect();
    while kept.len() > 1 && text_width_px(&kept.iter().collect::<String>(), size_px) + size_px > room_px {
        kept.pop();
    }
    kept.into_iter().collect::<String>() + "…"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_strip_is_drawn_with_its_name_and_points() {
        let row = |name: &str, points: &[f64]| StripRow {
            name: name.to_owned(),
            points: points.to_vec(),
            mean: (!points.is_empty()).then_some(12.0),
            ..StripRow::default()
        };
        let strip = Strip {
            width_px: 380.0,
            label: "time, s".to_owned(),
            rows: vec![row("a_star+dwa", &[10.0, 12.0, 14.0]), row("b <c>", &[])],
        };
        let svg = strip.draw(&Ink::PAGE);
        assert_eq!(svg.matches("h0").count(), 3, "one mark a point");
        assert!(svg.contains(">a_star+dwa</text>") && svg.contains("b &lt;c&gt;") && svg.contains(">no value<"));
        assert_eq!(svg, strip.draw(&Ink::PAGE));
    }

    #[test]
    fn a_long_name_is_cut_to_its_room() {
        let cut = fitted("improved_dijkstra+line_of_sight+dwa", 100.0, 12.0);
        assert!(cut.ends_with('…') && text_width_px(&cut, 12.0) <= 105.0, "{cut}");
        assert_eq!(fitted("short", 100.0, 12.0), "short");
    }
}
