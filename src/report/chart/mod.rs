//! Charts as SVG: scales with round ticks, axes, marks, and the few kinds of chart that results need.
//!
//! A chart is data in, text out: [`Strip`] (points of worlds with mean and quartiles), [`Intervals`] (a value with its interval
//! a row), [`Shares`] (outcomes of a stack as one bar), [`Lines`] (a value over a key, with a band), [`Heat`] (a value over two
//! keys) and [`Beside`] (published and measured). All are drawn on a [`Drawing`], whose user unit is one pixel of a page, in the
//! colours of an [`Ink`]: [`Ink::PAGE`] takes them from variables of the page's style sheet, so that a chart follows light and dark
//! mode. Labels come from the table of columns ([`label`]).
//!
//! The same data make the same bytes: no clock, no random numbers, coordinates to a tenth of a pixel.

mod axis;
mod beside;
mod drawing;
mod heat;
mod intervals;
mod lines;
mod scale;
mod shares;
mod strip;

pub use axis::{axis_x, axis_y};
pub use beside::{Beside, BesideRow};
pub use drawing::{Anchor, Drawing, escape, text_width_px};
pub use heat::{Heat, HeatCell};
pub use intervals::{IntervalRow, Intervals};
pub use lines::{LinePoint, Lines, Series};
pub use scale::{Scale, Tick, nice_step, number};
pub use shares::{ShareRow, Shares};
pub use strip::{Strip, StripRow};

use crate::results::metric_column;

/// The colours of a chart, as SVG takes them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ink {
    /// Text and the marks that matter most.
    pub text: &'static str,
    /// Labels of axes and secondary text.
    pub muted: &'static str,
    /// Lines of the grid.
    pub grid: &'static str,
    /// What lies behind the chart.
    pub paper: &'static str,
    /// One colour a stack, told apart by the colour-blind; there are more stacks than colours at times, so that no chart relies on
    /// colour alone.
    pub series: [&'static str; 8],
    /// Steps of a map of values, from low to high.
    pub ramp: [&'static str; 7],
    /// Text on each step of the ramp.
    pub on_ramp: [&'static str; 7],
    /// The colour of each outcome, in the order of [`Outcome::NAMES`](crate::episode::Outcome::NAMES); the last one for those behind.
    pub outcomes: [&'static str; 9],
}

impl Ink {
    /// Variables of a style sheet that `report` writes.
    pub const PAGE: Self = Self {
        text: "var(--ink)",
        muted: "var(--muted)",
        grid: "var(--rule)",
        paper: "var(--paper)",
        series: [
            "var(--s0)",
            "var(--s1)",
            "var(--s2)",
            "var(--s3)",
            "var(--s4)",
            "var(--s5)",
            "var(--s6)",
            "var(--s7)",
        ],
        ramp: ["#f1f3f8", "#d3dcec", "#aac0dc", "#7b9fc9", "#4f7cb0", "#2f5990", "#173867"],
        on_ramp: ["#1b1f24", "#1b1f24", "#1b1f24", "#1b1f24", "#ffffff", "#ffffff", "#ffffff"],
        outcomes: [
            "var(--o0)",
            "var(--o1)",
            "var(--o2)",
            "var(--o3)",
            "var(--o4)",
            "var(--o5)",
            "var(--o6)",
            "var(--o7)",
            "var(--o8)",
        ],
    };

    /// The colour of a series.
    pub fn series(&self, index: usize) -> &'static str {
        self.series[index % self.series.len()]
    }

    /// The colour of the outcome of that number.
    pub fn outcome(&self, index: usize) -> &'static str {
        self.outcomes[index.min(self.outcomes.len() - 1)]
    }
}

/// What a metric is called on an axis, with its unit: "time, s".
pub fn label(metric: &str) -> String {
    let unit = if metric == "success" { "%" } else { metric_column(metric).map_or("", |column| column.unit) };
    let words = words(metric);
    if unit.is_empty() { words } else { format!("{words}, {unit}") }
}

/// The name of a metric in words, without its unit: `clearance_min_m` is "smallest clearance".
pub fn words(metric: &str) -> String {
    let bare = match metric_column(metric) {
        Ok(column) if !column.unit.is_empty() => metric.rsplit_once('_').map_or(metric, |(bare, _)| bare),
        _ => metric,
    };
    match bare {
        "clearance_min" => "smallest clearance".to_owned(),
        "clearance_mean" => "mean clearance".to_owned(),
        "spl" => "SPL".to_owned(),
        _ => bare.replace('_', " "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_come_from_the_table_of_columns() {
        let labels = ["time_s", "clearance_min_m", "spl", "success", "jerk_rms_mps3", "own key"].map(label);
        assert_eq!(labels, ["time, s", "smallest clearance, m", "SPL", "success, %", "jerk rms, m/s³", "own key"]);
    }
}
