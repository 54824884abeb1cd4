//! Tables of a page: stacks, pairs that differ, endings.

use super::gather::Gathered;
use super::html::{capitalised, count, escape, number, or_dash, p_value, signed, table};
use crate::comparison::{ALPHA, COMPARED, Comparison, Report};
use crate::report::chart;
use crate::results::{Rate, Statistics};
use std::collections::BTreeMap;

/// What a table says of one stack.
struct Line {
    name: String,
    n: u64,
    success: Option<Rate>,
    letters: String,
    metrics: [Statistics; COMPARED.len()],
}

/// The table of stacks of a run at one point.
pub(super) fn stacks(gathered: &Gathered, reports: &[Report], note: Option<&str>) -> String {
    let (Some(point), Some(report)) = (gathered.points.first(), reports.first()) else { return String::new() };
    if report.copies > 0 || gathered.kept_below.is_none() {
        return of_report(report) + &said(note);
    }
    let letters = |name: &str| {
        let at = report.stacks.iter().position(|stack| stack.stack == name);
        at.and_then(|at| report.letters.get(at)).cloned().unwrap_or_default()
    };
    let lines = point.stacks.iter().map(|stack| Line {
        name: stack.name.clone(),
        n: stack.rated,
        success: stack.success(),
        letters: letters(&stack.name),
        metrics: [0, 1, 2].map(|metric| stack.statistics(metric)),
    });
    render(&lines.collect::<Vec<_>>()) + &said(note)
}

fn said(note: Option<&str>) -> String {
    note.map_or_else(String::new, |note| format!("<p class=\"note\">{}</p>\n", escape(note)))
}

/// The table of stacks of an analysis.
pub(super) fn of_report(report: &Report) -> String {
    let lines = report.stacks.iter().zip(&report.letters).map(|(stack, letters)| Line {
        name: stack.stack.clone(),
        n: stack.rated,
        success: stack.success,
        letters: letters.clone(),
        metrics: COMPARED.map(|metric| *stack.metric(metric)),
    });
    let mut text = render(&lines.collect::<Vec<_>>());
    if report.copies > 0 {
        text += &format!(
            "<p class=\"note\">{} of {} episodes are left out: nothing in them is random, so they are copies. {}</p>\n",
            report.copies,
            report.copies + report.distinct,
            if report.distinct == 1 { "One world is no sample, and nothing is tested." } else { "" }
        );
    }
    text
}

fn render(lines: &[Line]) -> String {
    let mut head = vec!["stack".to_owned(), "worlds".to_owned(), "success, % [95 %]".to_owned(), "group".to_owned()];
    head.extend(COMPARED.iter().map(|metric| chart::label(metric)));
    let rows: Vec<Vec<String>> = lines
        .iter()
        .map(|line| {
            let success = line.success.map_or_else(
                || "–".to_owned(),
                |Rate { rate, low, high }| {
                    format!(
                        "<b>{}</b> <span class=\"i\">[{}, {}]</span>",
                        number(100.0 * rate, 1),
                        number(100.0 * low, 1),
                        number(100.0 * high, 1)
                    )
                },
            );
            let mut row = vec![escape(&line.name), count(line.n), success, escape(&line.letters)];
            row.extend(line.metrics.iter().map(|metric| {
                let Statistics { n, mean, sd, median, .. } = *metric;
                if n == 0 {
                    return "–".to_owned();
                }
                format!("{} <span class=\"i\">± {}, {}</span>", or_dash(mean, 2), or_dash(sd, 2), or_dash(median, 2))
            }));
            row
        })
        .collect();
    table(&head, &rows, 1, "stacks")
        + "<p class=\"small\">Success of all feasible worlds with Wilson’s interval; the rest over the successes: mean <span class=\"i\">± standard deviation, median</span>. \
           Stacks that share a letter are not told apart by success (exact McNemar tests of all pairs, Holm, 5 %).</p>\n"
}

/// What is compared, in words.
fn metric_name(metric: &str) -> String {
    if metric == "success" { "success, points".to_owned() } else { chart::label(metric) }
}

/// Decimals that suit a difference of a metric.
fn decimals(test: &Comparison) -> usize {
    let largest = test.interval.into_iter().flat_map(|(low, high)| [low, high]).chain(test.difference);
    let largest = largest.fold(0.0, |most, value| crate::math::max(most, value.abs()));
    match largest {
        x if x >= 10.0 => 1,
        x if x >= 1.0 => 2,
        _ => 3,
    }
}

/// The tests of pairs: those that differ, then the rest folded away.
pub(super) fn pairs(reports: &[Report]) -> String {
    let tests = || reports.iter().flat_map(|report| report.comparisons.iter().map(move |test| (report, test)));
    let all = tests().count();
    if all == 0 {
        return String::new();
    }
    let has_points = reports.len() > 1;
    let row = |(report, test): (&Report, &Comparison)| {
        let places = decimals(test);
        let difference = test.difference.map_or_else(|| "–".to_owned(), |value| signed(value, places));
        let interval = test.interval.map_or_else(String::new, |(low, high)| {
            format!(" <span class=\"i\">[{}, {}]</span>", signed(low, places), signed(high, places))
        });
        let mut cells = vec![
            escape(&test.stack),
            escape(&test.reference),
            escape(&metric_name(test.metric)),
            format!("<b>{difference}</b>{interval}"),
            format!("{} ({})", test.n, test.informative),
            p_value(test.p_holm),
            test.effect.map_or_else(
                || "–".to_owned(),
                |effect| if effect.is_finite() { number(effect, 2) } else { "∞".to_owned() },
            ),
        ];
        if has_points {
            cells.insert(0, escape(&report_point(report)));
        }
        cells
    };
    let differs = |test: &Comparison| !test.too_few && test.p_holm <= ALPHA;
    let mut head = ["stack", "against", "metric", "difference [95 %]", "worlds (that tell)", "p, Holm", "effect"]
        .map(str::to_owned)
        .to_vec();
    if has_points {
        head.insert(0, "point".to_owned());
    }
    let left = if has_points { 4 } else { 3 };
    let found: Vec<Vec<String>> = tests().filter(|(_, test)| differs(test)).map(row).collect();
    let rest: Vec<Vec<String>> = tests().filter(|(_, test)| !differs(test)).map(row).collect();
    let mut text = if found.is_empty() {
        "<p>No pair is told apart by these worlds. That is not the same as equal: see what difference they could show.</p>\n".to_owned()
    } else {
        table(&head, &found, left, "pairs")
    };
    if !rest.is_empty() {
        let few = tests().filter(|(_, test)| test.too_few).count();
        let few = if few > 0 { format!(", {few} of them with too few worlds for any result") } else { String::new() };
        text += &format!(
            "<details><summary>{} of {all} tests that tell nothing apart{few}</summary>\n{}</details>\n",
            rest.len(),
            table(&head, &rest, left, "pairs")
        );
    }
    text + "<p class=\"small\">On the same worlds; lengths, times and clearances where both arrived. Difference: mean of stack − the one it is held against, with its bootstrap interval; p of the exact \
            McNemar test (success) or the signed-rank test, corrected by Holm over all tests of a point; effect: odds of winning alone, or rank-biserial correlation.</p>\n"
}

fn report_point(report: &Report) -> String {
    report.stacks.first().map_or_else(String::new, |stack| stack.point.to_string())
}

/// Failures by outcome and what it was with, one column a stack.
pub(super) fn endings(gathered: &Gathered) -> String {
    let names = gathered.stack_names();
    let mut counts: BTreeMap<&str, BTreeMap<&str, u64>> = BTreeMap::new();
    for stack in gathered.points.iter().flat_map(|point| &point.stacks) {
        for (ending, count) in &stack.endings {
            *counts.entry(ending).or_default().entry(&stack.name).or_default() += count;
        }
    }
    if counts.is_empty() {
        return "<p>Every episode succeeded.</p>\n".to_owned();
    }
    let head: Vec<String> =
        std::iter::once("ending".to_owned()).chain(names.iter().map(|name| (*name).to_owned())).collect();
    let rows: Vec<Vec<String>> = counts
        .iter()
        .map(|(ending, by_stack)| {
            let cells = names.iter().map(|name| by_stack.get(name).copied().unwrap_or(0));
            let cells =
                cells.map(|count| if count == 0 { "<span class=\"i\">0</span>".to_owned() } else { count.to_string() });
            std::iter::once(capitalised(ending)).chain(cells).collect()
        })
        .collect();
    table(&head, &rows, 1, "endings")
}
