//! How the episodes of each stack ended: one bar of shares a row.

use super::axis::LABEL_PX;
use super::strip::name_line;
use super::{Anchor, Drawing, Ink, text_width_px};

/// A chart of shares.
#[derive(Clone, Debug)]
pub struct Shares {
    /// Width, px.
    pub width_px: f64,
    /// What the parts are, with the colour of each.
    pub parts: Vec<(String, &'static str)>,
    /// The rows, from the top.
    pub rows: Vec<ShareRow>,
}

/// One bar.
#[derive(Clone, Debug)]
pub struct ShareRow {
    /// Its name.
    pub name: String,
    /// What stands at the right end of its name.
    pub note: String,
    /// The count of each part.
    pub counts: Vec<u64>,
}

/// Height of a row with its name, px.
const ROW_PX: f64 = 42.0;
const BAR_PX: f64 = 16.0;
const LEGEND_PX: f64 = 18.0;

impl Shares {
    /// The chart; parts that no row has are left out of the legend.
    pub fn draw(&self, ink: &Ink) -> String {
        let has = |part: usize| self.rows.iter().any(|row| row.counts.get(part).is_some_and(|&count| count > 0));
        let legend: Vec<usize> = (0..self.parts.len()).filter(|&part| has(part)).collect();
        let (mut lines, mut x) = (vec![Vec::new()], 4.0);
        for part in legend {
            let width = 16.0 + text_width_px(&self.parts[part].0, LABEL_PX) + 12.0;
            if x + width > self.width_px && x > 4.0 {
                lines.push(Vec::new());
                x = 4.0;
            }
            if let Some(line) = lines.last_mut() {
                line.push((part, x));
            }
            x += width;
        }
        let legend_px = lines.len() as f64 * LEGEND_PX + 4.0;
        let mut drawing = Drawing::new(self.width_px, legend_px + self.rows.len() as f64 * ROW_PX);
        for (line, entries) in lines.iter().enumerate() {
            let y = line as f64 * LEGEND_PX + 3.0;
            for &(part, x) in entries {
                let (name, colour) = &self.parts[part];
                drawing.rect((x, y), (11.0, 11.0), &format!("rx=\"2\" fill=\"{colour}\""));
                drawing.text((x + 16.0, y + 9.5), Anchor::Start, LABEL_PX, ink.muted, name);
            }
        }
        for (at, row) in self.rows.iter().enumerate() {
            let top = legend_px + at as f64 * ROW_PX;
            name_line(&mut drawing, ink, top + 13.0, &row.name, &row.note);
            self.bar(&mut drawing, ink, row, top + 19.0);
        }
        let says = self.rows.iter().map(|row| {
            let counts = row.counts.iter().zip(&self.parts).filter(|(count, _)| **count > 0);
            let counts: Vec<String> = counts.map(|(count, (name, _))| format!("{count} {name}")).collect();
            format!("{}: {}", row.name, counts.join(", "))
        });
        drawing.finish(&says.collect::<Vec<_>>().join("; "))
    }

    fn bar(&self, drawing: &mut Drawing, ink: &Ink, row: &ShareRow, y: f64) {
        let (left, width) = (4.0, self.width_px - 8.0);
        let total = row.counts.iter().sum::<u64>();
        if total == 0 {
            drawing.text((left, y + 12.0), Anchor::Start, LABEL_PX, ink.muted, "no episode");
            return;
        }
        let mut done = 0;
        for (count, (_, colour)) in row.counts.iter().zip(&self.parts).filter(|(count, _)| **count > 0) {
            let x = left + width * done as f64 / total as f64;
            done += count;
            let end = left + width * done as f64 / total as f64;
            // A hair of paper tells neighbours apart without colour.
            let gap = if done < total && end - x > 2.0 { 1.0 } else { 0.0 };
            drawing.rect((x, y), (crate::math::max(end - x - gap, 0.7), BAR_PX), &format!("fill=\"{colour}\""));
            let label = count.to_string();
            if text_width_px(&label, 10.5) + 8.0 < end - x {
                drawing.text((x + 5.0, y + 12.0), Anchor::Start, 10.5, ink.paper, &label);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_as_long_as_their_shares_and_what_never_happened_is_not_named() {
        let parts = ["success", "collision", "stuck"].into_iter().zip(Ink::PAGE.outcomes);
        let chart = Shares {
            width_px: 208.0,
            parts: parts.map(|(name, colour)| (name.to_owned(), colour)).collect(),
            rows: vec![
                ShareRow { name: "a".to_owned(), note: String::new(), counts: vec![3, 1, 0] },
                ShareRow { name: "b".to_owned(), note: String::new(), counts: vec![0, 0, 0] },
            ],
        };
        let svg = chart.draw(&Ink::PAGE);
        assert!(
            svg.contains("x=\"4\" y=\"41\" width=\"149\"") && svg.contains("x=\"154\" y=\"41\" width=\"50\""),
            "{svg}"
        );
        assert!(!svg.contains(">stuck<") && svg.contains(">no episode<"));
    }
}
