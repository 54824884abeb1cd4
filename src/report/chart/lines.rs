//! A value over a key, one line a series, with a band for its interval.

use super::axis::{LABEL_PX, axis_x, axis_y, room_y_px};
use super::strip::fitted;
use super::{Anchor, Drawing, Ink, Scale, text_width_px};
use crate::math;

/// A chart of lines.
#[derive(Clone, Debug)]
pub struct Lines {
    /// Width, px.
    pub width_px: f64,
    /// Height of the plot without legend and labels, px.
    pub height_px: f64,
    /// Label of the x axis.
    pub x_label: String,
    /// Label of the y axis.
    pub y_label: String,
    /// The ends that the y axis must hold.
    pub y_ends: Option<(f64, f64)>,
    /// The words of x where it has no numbers: x is then 0, 1, 2 and so on.
    pub x_words: Vec<String>,
    /// The series.
    pub series: Vec<Series>,
}

/// One line.
#[derive(Clone, Debug)]
pub struct Series {
    /// Its name.
    pub name: String,
    /// Number of the colour; the shape of the marks goes by it as well.
    pub series: usize,
    /// The points, in the order of x.
    pub points: Vec<LinePoint>,
}

/// A point of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinePoint {
    /// Place on the x axis.
    pub x: f64,
    /// Value.
    pub y: f64,
    /// Its interval.
    pub interval: Option<(f64, f64)>,
}

impl Lines {
    /// The chart.
    pub fn draw(&self, ink: &Ink) -> String {
        let named = self.series.len() > 1;
        let legend_px = if named { self.series.len() as f64 * 16.0 + 4.0 } else { 0.0 };
        let top = legend_px + 22.0;
        let bottom = top + self.height_px;
        let points = || self.series.iter().flat_map(|series| &series.points);
        let ys = points().flat_map(|point| {
            [Some(point.y), point.interval.map(|(low, _)| low), point.interval.map(|(_, high)| high)]
                .into_iter()
                .flatten()
        });
        let ends = self.y_ends.into_iter().flat_map(|(low, high)| [low, high]);
        let y = Scale::covering_near_zero(ys.chain(ends), 5, (bottom, top));
        let left = room_y_px(&y);
        let pixels = (left + 8.0, self.width_px - 14.0);
        let x = if self.x_words.is_empty() {
            Scale::covering(points().map(|point| point.x), 6, pixels)
        } else {
            let last = self.x_words.len() as f64 - 0.5;
            Scale { low: -0.5, high: math::max(last, 0.5), from_px: left, to_px: self.width_px - 4.0 }
        };
        let mut drawing = Drawing::new(self.width_px, bottom + 36.0);
        axis_y(&mut drawing, ink, &y, (left, self.width_px), &self.y_label);
        if self.x_words.is_empty() {
            axis_x(&mut drawing, ink, &x, (top, bottom), &self.x_label);
        } else {
            self.words(&mut drawing, ink, &x, bottom);
        }
        for (at, series) in self.series.iter().enumerate() {
            series.draw(&mut drawing, ink, &x, &y);
            if named {
                let line = at as f64 * 16.0 + 8.0;
                drawing.line((4.0, line), (22.0, line), ink.series(series.series), 2.0);
                mark(&mut drawing, ink, series.series, (13.0, line));
                let name = fitted(&series.name, self.width_px - 32.0, LABEL_PX);
                drawing.text((28.0, line + 4.0), Anchor::Start, LABEL_PX, ink.text, &name);
            }
        }
        let names: Vec<&str> = self.series.iter().map(|series| series.name.as_str()).collect();
        drawing.finish(&format!("{} over {}: {}", self.y_label, self.x_label, names.join(", ")))
    }

    fn words(&self, drawing: &mut Drawing, ink: &Ink, x: &Scale, bottom: f64) {
        let room = (x.at(1.0) - x.at(0.0)) - 6.0;
        let widest = self.x_words.iter().map(|word| text_width_px(word, LABEL_PX)).fold(0.0, math::max);
        // Where words are wider than their places, every second or third one is written.
        let every = if room > 24.0 {
            1
        } else {
            (math::min(widest, 60.0) / math::max(room, 1.0)).ceil().clamp(1.0, 1e3) as usize
        };
        for (at, word) in self.x_words.iter().enumerate().step_by(every) {
            let word = fitted(word, room * every as f64 + 2.0, LABEL_PX);
            drawing.text((x.at(at as f64), bottom + 14.0), Anchor::Middle, LABEL_PX, ink.muted, &word);
        }
        let middle = (x.from_px + x.to_px) / 2.0;
        drawing.text((middle, bottom + 29.0), Anchor::Middle, LABEL_PX, ink.muted, &self.x_label);
    }
}

impl Series {
    fn draw(&self, drawing: &mut Drawing, ink: &Ink, x: &Scale, y: &Scale) {
        let colour = ink.series(self.series);
        let banded: Vec<(f64, f64, f64)> = self
            .points
            .iter()
            .filter_map(|point| point.interval.map(|(low, high)| (x.at(point.x), y.at(low), y.at(high))))
            .collect();
        if banded.len() > 1 {
            let edge: Vec<(f64, f64)> = banded.iter().map(|&(x, low, _)| (x, low)).collect();
            let back = banded.iter().rev().map(|&(x, _, high)| (x, high));
            let outline: Vec<(f64, f64)> = edge.into_iter().chain(back).collect();
            drawing.polyline(&outline, &format!("fill=\"{colour}\" fill-opacity=\"0.14\""));
        }
        for &(x, low, high) in &banded {
            drawing.line((x, low), (x, high), colour, 1.2);
        }
        let line: Vec<(f64, f64)> = self.points.iter().map(|point| (x.at(point.x), y.at(point.y))).collect();
        drawing.polyline(
            &line,
            &format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\" stroke-linejoin=\"round\""),
        );
        for &place in &line {
            mark(drawing, ink, self.series, place);
        }
    }
}

/// A mark whose shape goes with its colour: disc, square, diamond, triangle.
fn mark(drawing: &mut Drawing, ink: &Ink, series: usize, (x, y): (f64, f64)) {
    let shape = match series % 4 {
        0 => format!("M{:.1} {y:.1}a3.6 3.6 0 1 0 7.2 0a3.6 3.6 0 1 0 -7.2 0z", x - 3.6),
        1 => format!("M{:.1} {:.1}h6.4v6.4h-6.4z", x - 3.2, y - 3.2),
        2 => format!("M{x:.1} {:.1}l4.6 4.6l-4.6 4.6l-4.6 -4.6z", y - 4.6),
        _ => format!("M{x:.1} {:.1}l4.3 7.2h-8.6z", y - 4.4),
    };
    drawing.path(&shape, &format!("fill=\"{}\" stroke=\"{}\" stroke-width=\"1\"", ink.series(series), ink.paper));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(words: &[&str]) -> Lines {
        let point = |x: f64, y: f64| LinePoint { x, y, interval: Some((y - 5.0, y + 5.0)) };
        let series = |name: &str, series: usize| Series {
            name: name.to_owned(),
            series,
            points: vec![point(0.0, 90.0), point(1.0, 60.0)],
        };
        Lines {
            width_px: 360.0,
            height_px: 160.0,
            x_label: "robot.radius_m".to_owned(),
            y_label: "success, %".to_owned(),
            y_ends: Some((0.0, 100.0)),
            x_words: words.iter().map(|&word| word.to_owned()).collect(),
            series: vec![series("a_star+dwa", 0), series("bfs+dwa", 1)],
        }
    }

    #[test]
    fn lines_are_named_and_told_apart_by_shape() {
        let svg = chart(&[]).draw(&Ink::PAGE);
        assert!(svg.contains(">a_star+dwa<") && svg.contains(">bfs+dwa<") && svg.contains("fill-opacity=\"0.14\""));
        assert!(svg.contains("a3.6 3.6") && svg.contains("h6.4v6.4"), "disc and square");
    }

    #[test]
    fn x_may_be_words() {
        let svg = chart(&["arc", "euler"]).draw(&Ink::PAGE);
        assert!(svg.contains(">arc<") && svg.contains(">euler<"), "{svg}");
    }
}
