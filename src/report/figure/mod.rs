//! Figures for papers, from the rows of an `episodes.csv`: a value over a swept key ([`sweep`]), stacks side by side ([`stacks`]), differences on
//! the same worlds ([`pairs`]), any column over any other ([`columns`]).
//!
//! Means come with their 95 % intervals (success: Wilson; differences: bootstrap; the rest: Student's t), and the worlds stand behind them as dots. Labels and
//! units come from the table of columns, colours are those of Okabe and Ito with a mark of its own for each. The same table makes the same bytes.

mod axis;
mod curves;
mod data;
mod kinds;
mod rows;
mod sheet;

pub use data::{FigureError, swept_keys};
pub use kinds::{Asked, columns, pairs, stacks, sweep};

use super::palette::{INK, series as series_colour};
use super::picture::{Anchor, Picture, svg};
use crate::math;
use crate::settings::unit_of;
use curves::Curves;
use rows::Rows;
use sheet::{MM_PX, Sheet};

/// Size and looks of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Style {
    /// Width, mm: 88 is a column of many journals, 180 the page.
    pub width_mm: f64,
    /// Size of all texts, pt.
    pub font_size_pt: f64,
    /// Title above the figure.
    pub title: Option<String>,
    /// Whether x and y are logarithmic.
    pub is_log: [bool; 2],
}

impl Default for Style {
    fn default() -> Self {
        Self { width_mm: 88.0, font_size_pt: 8.0, title: None, is_log: [false, false] }
    }
}

/// A figure that is ready to be drawn.
#[derive(Clone, Debug)]
pub struct Figure {
    panels: Vec<Panel>,
    /// Names of the series, with their colours and marks; empty where the panels name them.
    legend: Vec<(String, usize)>,
    /// What it shows: the text for a caption.
    pub caption: String,
}

#[derive(Clone, Debug)]
enum Panel {
    Curves(Curves),
    Rows(Rows),
}

impl Panel {
    fn height_px(&self, font_px: f64) -> f64 {
        match self {
            Self::Curves(panel) => panel.height_px(font_px),
            Self::Rows(panel) => panel.height_px(font_px),
        }
    }
}

/// Narrowest panel, in heights of letters.
const PANEL_MIN: f64 = 26.0;

impl Figure {
    /// The figure as a file of SVG that says how large it is on paper.
    pub fn svg(&self, style: &Style) -> String {
        let picture = self.picture(style);
        let [width, height] = [picture.width, picture.height].map(|px| (px / MM_PX * 100.0).round() / 100.0);
        svg(&picture).replacen("<svg ", &format!("<svg width=\"{width}mm\" height=\"{height}mm\" "), 1)
    }

    /// The figure as a picture, 96 pixels an inch.
    pub fn picture(&self, style: &Style) -> Picture {
        let (width, font) = (style.width_mm * MM_PX, style.font_size_pt * 96.0 / 72.0);
        let margin = 0.6 * font;
        let columns = (((width - margin) / (PANEL_MIN * font)) as usize).clamp(1, self.panels.len().max(1));
        let panel_width = (width - 2.0 * margin - (columns as f64 - 1.0) * 1.5 * font) / columns as f64;
        let title_px = if style.title.is_some() { 1.8 * font } else { 0.0 };
        // Places of the legend are found on a sheet that is thrown away.
        let places = self.legend_places(&Sheet::new(width, 1.0, font), width - 2.0 * margin);
        let legend_px = places.last().map_or(0.0, |(_, line)| (*line as f64 + 1.0) * 1.4 * font + 0.4 * font);
        let lines: Vec<f64> = self
            .panels
            .chunks(columns)
            .map(|line| line.iter().map(|panel| panel.height_px(font)).fold(0.0, math::max) + 0.9 * font)
            .collect();
        let mut sheet =
            Sheet::new(width, 2.0 * margin + title_px + legend_px + lines.iter().sum::<f64>() - 0.9 * font, font);
        if let Some(title) = &style.title {
            sheet.text((margin, margin + 0.9 * font), Anchor::Start, INK, title);
        }
        for ((name, series), (x, line)) in self.legend.iter().zip(places) {
            let (x, y) = (margin + x, margin + title_px + (line as f64 + 0.6) * 1.4 * font);
            sheet.line((x, y), (x + 1.8 * font, y), series_colour(*series), 1.2);
            sheet.mark(*series, (x + 0.9 * font, y));
            sheet.text((x + 2.3 * font, y + 0.35 * font), Anchor::Start, INK, name);
        }
        let mut top = margin + title_px + legend_px;
        for (panels, height) in self.panels.chunks(columns).zip(lines) {
            for (at, panel) in panels.iter().enumerate() {
                let left = margin + at as f64 * (panel_width + 1.5 * font);
                match panel {
                    Panel::Curves(panel) => panel.draw(&mut sheet, (left, top), panel_width),
                    Panel::Rows(panel) => panel.draw(&mut sheet, (left, top), panel_width),
                }
            }
            top += height;
        }
        sheet.picture
    }

    /// Where each entry of the legend begins, and on which line.
    fn legend_places(&self, sheet: &Sheet, width_px: f64) -> Vec<(f64, usize)> {
        let (mut x, mut line, mut places) = (0.0, 0, Vec::new());
        for (name, _) in &self.legend {
            let wide = sheet.width_of(name) + 3.8 * sheet.font_px;
            if x > 0.0 && x + wide - 1.5 * sheet.font_px > width_px {
                (x, line) = (0.0, line + 1);
            }
            places.push((x, line));
            x += wide;
        }
        places
    }
}

/// The label of an axis: "Time (s)", "Success (%)", "Horizon (s)" of a swept key.
fn axis_label(name: &str) -> String {
    let last = name.rsplit('.').next().unwrap_or(name);
    let (words, unit) = match super::chart::label(name) {
        label if name.contains('.') && label == super::chart::words(name) => {
            let unit = unit_of(last);
            let bare = if unit.is_some() { last.rsplit_once('_').map_or(last, |(bare, _)| bare) } else { last };
            (bare.replace('_', " "), unit.map(str::to_owned))
        }
        label => match label.rsplit_once(", ") {
            Some((words, unit)) => (words.to_owned(), Some(unit.to_owned())),
            None => (label, None),
        },
    };
    let mut letters = words.chars();
    let words: String = letters.next().into_iter().flat_map(char::to_uppercase).chain(letters).collect();
    unit.map_or_else(|| words.clone(), |unit| format!("{words} ({unit})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_have_words_and_units() {
        let labels = [
            "time_s",
            "success",
            "spl",
            "stacks.local.dwa.horizon_s",
            "obstacles.moving.0.random.count",
            "jerk_rms_mps3",
        ];
        let expected = ["Time (s)", "Success (%)", "SPL", "Horizon (s)", "Count", "Jerk rms (m/s³)"];
        assert_eq!(labels.map(axis_label), expected);
    }
}
