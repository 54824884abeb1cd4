//! A value with its interval, one row a stack.

use super::axis::axis_x;
use super::strip::name_line;
use super::{Drawing, Ink, Scale};

/// A chart of values with intervals.
#[derive(Clone, Debug)]
pub struct Intervals {
    /// Width, px.
    pub width_px: f64,
    /// Label of the axis.
    pub label: String,
    /// The ends that the axis must hold, such as 0 and 100 per cent; with none it holds the intervals.
    pub ends: Option<(f64, f64)>,
    /// A value to compare with, drawn as a line: 0 for differences.
    pub reference: Option<f64>,
    /// The rows, from the top.
    pub rows: Vec<IntervalRow>,
}

/// One value with its interval.
#[derive(Clone, Debug, Default)]
pub struct IntervalRow {
    /// Its name.
    pub name: String,
    /// Number of the colour.
    pub series: usize,
    /// The value; a row without one is drawn empty.
    pub value: Option<f64>,
    /// The interval.
    pub interval: Option<(f64, f64)>,
    /// What stands at the right end of its name: the letters of its group, the value.
    pub note: String,
}

/// Height of a row with its name, px.
const ROW_PX: f64 = 34.0;

impl Intervals {
    /// The chart.
    pub fn draw(&self, ink: &Ink) -> String {
        let height = self.rows.len() as f64 * ROW_PX + 40.0;
        let mut drawing = Drawing::new(self.width_px, height);
        let ends = self.ends.into_iter().flat_map(|(low, high)| [low, high]);
        let values = self
            .rows
            .iter()
            .flat_map(|row| row.value.into_iter().chain(row.interval.into_iter().flat_map(|(low, high)| [low, high])));
        let scale = Scale::covering(values.chain(ends).chain(self.reference), 6, (14.0, self.width_px - 14.0));
        let bottom = height - 34.0;
        axis_x(&mut drawing, ink, &scale, (4.0, bottom), &self.label);
        if let Some(reference) = self.reference {
            drawing.line((scale.at(reference), 4.0), (scale.at(reference), bottom), ink.muted, 1.2);
        }
        for (at, row) in self.rows.iter().enumerate() {
            let top = at as f64 * ROW_PX;
            name_line(&mut drawing, ink, top + 13.0, &row.name, &row.note);
            let (y, colour) = (top + 24.0, ink.series(row.series));
            if let Some((low, high)) = row.interval {
                drawing.line((scale.at(low), y), (scale.at(high), y), colour, 2.5);
                for end in [low, high] {
                    drawing.line((scale.at(end), y - 4.0), (scale.at(end), y + 4.0), colour, 2.0);
                }
            }
            if let Some(value) = row.value {
                drawing.dots([(scale.at(value), y)], 6.0, ink.paper, 1.0);
                drawing.dots([(scale.at(value), y)], 4.5, colour, 1.0);
            }
        }
        let says: Vec<String> = self.rows.iter().map(|row| format!("{} {}", row.name, row.note)).collect();
        drawing.finish(&format!("{}: {}", self.label, says.join("; ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_of_an_interval_stand_where_the_scale_puts_them() {
        let row = IntervalRow {
            name: "a".to_owned(),
            value: Some(50.0),
            interval: Some((25.0, 75.0)),
            note: "50 %".to_owned(),
            ..IntervalRow::default()
        };
        let chart = Intervals {
            width_px: 228.0,
            label: "success, %".to_owned(),
            ends: Some((0.0, 100.0)),
            reference: None,
            rows: vec![row],
        };
        // 14 to 214 px are 0 to 100 %.
        assert!(chart.draw(&Ink::PAGE).contains("M64 24L164 24"), "{}", chart.draw(&Ink::PAGE));
    }
}
