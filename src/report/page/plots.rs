//! Charts of one run: success with intervals, the worlds of each metric, shares of outcomes.

use super::gather::{Gathered, Point, sample};
use super::html::{charts, count, number};
use crate::comparison::COMPARED;
use crate::episode::Outcome;
use crate::report::chart::{self, Ink, IntervalRow, Intervals, ShareRow, Shares, Strip, StripRow};
use crate::results::{Rate, Statistics};

/// Width of a chart, px: a telephone's, so that nothing is scaled down there.
pub(super) const WIDTH_PX: f64 = 372.0;
/// Points of all strips of a chart together.
const POINTS_MAX: usize = 2400;

/// Success and the compared metrics of the stacks at the one point of a run.
pub(super) fn worlds(gathered: &Gathered) -> String {
    let Some(point) = gathered.points.first() else { return String::new() };
    let mut figures = vec![("Success".to_owned(), success(point))];
    for (index, metric) in COMPARED.iter().enumerate() {
        if point.stacks.iter().any(|stack| !stack.values[index].is_empty()) {
            figures
                .push((format!("{}, of successes", sentence_case(&chart::words(metric))), strip(point, index, metric)));
        }
    }
    charts(&figures)
        + "<p class=\"small\">Each point is a world. The bar goes from the first to the third quartile, its mark is the median, the diamond the mean.</p>\n"
}

fn sentence_case(words: &str) -> String {
    let mut chars = words.chars();
    chars.next().map_or_else(String::new, |first| first.to_uppercase().collect::<String>() + chars.as_str())
}

fn success(point: &Point) -> String {
    let rows = point.stacks.iter().enumerate().map(|(series, stack)| {
        let rate = stack.success();
        IntervalRow {
            name: stack.name.clone(),
            series,
            value: rate.map(|rate| 100.0 * rate.rate),
            interval: rate.map(|rate| (100.0 * rate.low, 100.0 * rate.high)),
            note: rate.map_or_else(
                || "no feasible world".to_owned(),
                |Rate { rate, .. }| format!("{} % of {}", number(100.0 * rate, 1), count(stack.rated)),
            ),
        }
    });
    let chart = Intervals {
        width_px: WIDTH_PX,
        label: "success, % (95 % interval)".to_owned(),
        ends: Some((0.0, 100.0)),
        reference: None,
        rows: rows.collect(),
    };
    chart.draw(&Ink::PAGE)
}

fn strip(point: &Point, index: usize, metric: &str) -> String {
    let most = (POINTS_MAX / point.stacks.len().max(1)).clamp(20, 600);
    let rows = point.stacks.iter().enumerate().map(|(series, stack)| {
        let Statistics { n, mean, median, q1, q3, .. } = stack.statistics(index);
        let quartiles = q1.zip(median).zip(q3).map(|((q1, median), q3)| [q1, median, q3]);
        let note = mean.map_or_else(String::new, |mean| format!("mean {} (n = {})", number(mean, 2), count(n)));
        StripRow { name: stack.name.clone(), series, points: sample(&stack.values[index], most), mean, quartiles, note }
    });
    Strip { width_px: WIDTH_PX, label: chart::label(metric), rows: rows.collect() }.draw(&Ink::PAGE)
}

/// Shares of outcomes of every stack, all points together.
pub(super) fn outcomes(gathered: &Gathered) -> String {
    let ink = Ink::PAGE;
    let parts = Outcome::NAMES.iter().enumerate().map(|(index, name)| (name.replace('_', " "), ink.outcome(index)));
    let rows = gathered.stack_names().into_iter().map(|name| {
        let stacks = || gathered.points.iter().flat_map(|point| &point.stacks).filter(|stack| stack.name == name);
        let ended = |index: usize| stacks().map(|stack| stack.outcomes[index]).sum();
        let n: u64 = stacks().map(|stack| stack.n).sum();
        ShareRow {
            name: name.to_owned(),
            note: format!("n = {}", count(n)),
            counts: (0..Outcome::NAMES.len()).map(ended).collect(),
        }
    });
    let chart = Shares { width_px: 2.0 * WIDTH_PX, parts: parts.collect(), rows: rows.collect() };
    format!("<div class=\"wide-chart\">{}</div>\n", chart.draw(&ink))
}
