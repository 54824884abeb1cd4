//! Published beside measured: two marks a row, the measured one with its interval.

use super::axis::{LABEL_PX, axis_x};
use super::strip::name_line;
use super::{Anchor, Drawing, Ink, Scale};

/// A chart of published and measured values.
#[derive(Clone, Debug)]
pub struct Beside {
    /// Width, px.
    pub width_px: f64,
    /// Label of the axis.
    pub label: String,
    /// The rows, from the top.
    pub rows: Vec<BesideRow>,
}

/// A published number and the one measured for it.
#[derive(Clone, Debug, Default)]
pub struct BesideRow {
    /// Its name.
    pub name: String,
    /// The published value.
    pub published: Option<f64>,
    /// The measured value.
    pub measured: Option<f64>,
    /// The interval of the measured value.
    pub interval: Option<(f64, f64)>,
}

const ROW_PX: f64 = 34.0;

impl Beside {
    /// The chart.
    pub fn draw(&self, ink: &Ink) -> String {
        let top = 20.0;
        let height = top + self.rows.len() as f64 * ROW_PX + 40.0;
        let mut drawing = Drawing::new(self.width_px, height);
        let values = self.rows.iter().flat_map(|row| {
            let interval = row.interval.into_iter().flat_map(|(low, high)| [low, high]);
            row.published.into_iter().chain(row.measured).chain(interval)
        });
        let scale = Scale::covering_near_zero(values, 6, (14.0, self.width_px - 14.0));
        axis_x(&mut drawing, ink, &scale, (top, height - 34.0), &self.label);
        published(&mut drawing, ink, (10.0, 8.0));
        drawing.text((20.0, 12.0), Anchor::Start, LABEL_PX, ink.muted, "published");
        drawing.dots([(92.0, 8.0)], 4.5, ink.series(0), 1.0);
        drawing.text((102.0, 12.0), Anchor::Start, LABEL_PX, ink.muted, "measured, with its 95 % interval");
        for (at, row) in self.rows.iter().enumerate() {
            let from = top + at as f64 * ROW_PX;
            name_line(&mut drawing, ink, from + 13.0, &row.name, "");
            let y = from + 25.0;
            if let (Some(printed), Some(ours)) = (row.published, row.measured) {
                drawing.line((scale.at(printed), y), (scale.at(ours), y), ink.muted, 1.0);
            }
            if let Some((low, high)) = row.interval {
                drawing.line((scale.at(low), y), (scale.at(high), y), ink.series(0), 3.0);
            }
            if let Some(ours) = row.measured {
                drawing.dots([(scale.at(ours), y)], 4.5, ink.series(0), 1.0);
            }
            if let Some(printed) = row.published {
                published(&mut drawing, ink, (scale.at(printed), y));
            }
        }
        let names: Vec<&str> = self.rows.iter().map(|row| row.name.as_str()).collect();
        drawing.finish(&format!("{}, published beside measured: {}", self.label, names.join("; ")))
    }
}

/// The mark of a published number: a hollow diamond.
fn published(drawing: &mut Drawing, ink: &Ink, (x, y): (f64, f64)) {
    let data = format!("M{x:.1} {:.1}l5.5 5.5l-5.5 5.5l-5.5 -5.5z", y - 5.5);
    drawing.path(&data, &format!("fill=\"{}\" stroke=\"{}\" stroke-width=\"1.8\"", ink.paper, ink.series(1)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_numbers_stand_in_a_row() {
        let row = BesideRow {
            name: "a_star+dwa".to_owned(),
            published: Some(20.0),
            measured: Some(40.0),
            interval: Some((30.0, 50.0)),
        };
        let chart = Beside { width_px: 278.0, label: "length, m".to_owned(), rows: vec![row] };
        // 14 to 264 px are 0 to 50 m.
        let svg = chart.draw(&Ink::PAGE);
        assert!(svg.contains("M164 45L264 45") && svg.contains("M114.0 39.5l5.5"), "{svg}");
    }
}
