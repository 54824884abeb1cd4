//! Reports as text, Markdown and CSV.

use super::latex::{comment, latex};
use super::pair::SUCCESS;
use super::{ALPHA, COMPARED, Comparison, EquivalenceTest, Report};
use crate::analysis::Ratio;
use crate::episode::Outcome;
use crate::math;
use crate::results::layout::{WIDE, aligned, paragraph};
use crate::results::{Field, Rate, Statistics, SummaryRow, json_object, summary_json};
use crate::settings::quantity::counted;
use serde_json::{Map, Value as Json, json};
use std::fmt::Write as _;

/// Format of a report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Aligned columns for a terminal.
    #[default]
    Text,
    /// Tables of Markdown.
    Markdown,
    /// Tables of LaTeX with booktabs, everything else as comments.
    Latex,
    /// The tests, one per line, every section in one table.
    Csv,
}

/// The reports of all sections in one text.
///
/// Lines of text have at most `width` characters where that can be done.
pub fn render(reports: &[Report], format: Format, width: usize) -> String {
    match format {
        Format::Csv => csv(reports),
        Format::Text | Format::Markdown | Format::Latex => {
            reports.iter().map(|report| section(report, format, width)).collect()
        }
    }
}

/// Rows of cells as a table; the first row is the head. Text is aligned, the first `left` columns to the left. In Markdown and LaTeX a row of
/// one cell is a title across the table.
pub fn table(rows: &[Vec<String>], left: usize, format: Format) -> String {
    fitting_table(rows, left, format, WIDE)
}

/// The same, text in parts of at most `width` characters.
pub(super) fn fitting_table(rows: &[Vec<String>], left: usize, format: Format, width: usize) -> String {
    match format {
        Format::Text | Format::Csv => return aligned(rows, left, width),
        Format::Latex => return latex(rows, left),
        Format::Markdown => {}
    }
    let mut text = String::new();
    for (index, row) in rows.iter().enumerate() {
        let _ = match &row[..] {
            [title] if rows[0].len() > 1 => writeln!(text, "| *{title}* {}", "| ".repeat(rows[0].len()).trim_end()),
            cells => writeln!(text, "| {} |", cells.join(" | ")),
        };
        if index == 0 {
            let marks = (0..row.len()).map(|column| if column < left { "---" } else { "---:" });
            let _ = writeln!(text, "|{}|", marks.collect::<Vec<_>>().join("|"));
        }
    }
    text
}

/// Success in per cent with its 95 % interval.
pub(super) fn success(row: &SummaryRow) -> String {
    row.success.map_or_else(
        || "-".to_owned(),
        |Rate { rate, low, high }| format!("{:.1} [{:.1}, {:.1}]", 100.0 * rate, 100.0 * low, 100.0 * high),
    )
}

/// The line about episodes that do not count.
pub(super) fn copies_left_out(copies: u64, distinct: u64) -> String {
    format!(
        "{} left out: nothing in them is random, so they are copies of the {distinct} that {}.\n",
        counted(copies, "episode"),
        if distinct == 1 { "counts; one world is no sample, and nothing is tested" } else { "count" }
    )
}

/// A sentence beside tables: in LaTeX a comment.
pub(super) fn note(text: &str, format: Format, width: usize) -> String {
    match format {
        Format::Latex => comment(text),
        Format::Markdown => text.to_owned(),
        Format::Text | Format::Csv => paragraph(text, width),
    }
}

/// A title of some level, 1 or 2.
pub(super) fn heading(text: &str, level: usize, format: Format, width: usize) -> String {
    match format {
        Format::Markdown => format!("{} {text}\n\n", "#".repeat(level + 1)),
        Format::Text | Format::Csv if level == 1 => format!("{text}\n\n"),
        Format::Text | Format::Csv | Format::Latex => note(&format!("{text}\n"), format, width),
    }
}

fn section(report: &Report, format: Format, width: usize) -> String {
    let note = |text: &str| note(text, format, width);
    let title = heading(&report.title, 1, format, width);
    let heading = |text: &str| heading(text, 2, format, width);
    let mut text = title;
    text += &heading(
        "Each stack by itself (success of all episodes; the rest of the successful ones: mean ± sd, median; quartiles are in summary.csv)",
    );
    let mut rows = vec![vec!["stack".to_owned(), "n".to_owned(), "success % [95 %]".to_owned(), "group".to_owned()]];
    let endings: Vec<usize> =
        (1..Outcome::NAMES.len()).filter(|&k| report.stacks.iter().any(|stack| stack.outcomes[k] > 0)).collect();
    rows[0].extend(endings.iter().map(|&k| Outcome::NAMES[k].to_owned()));
    rows[0].extend(COMPARED.map(str::to_owned));
    for (stack, letters) in report.stacks.iter().zip(&report.letters) {
        let mut row = vec![stack.stack.clone(), stack.rated.to_string(), success(stack), letters.clone()];
        row.extend(endings.iter().map(|&k| stack.outcomes[k].to_string()));
        row.extend(COMPARED.iter().map(|metric| {
            let Statistics { n, mean, sd, median, .. } = *stack.metric(metric);
            let shown = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"));
            let [mean, sd, median] = [mean, sd, median].map(shown);
            if n == 0 { mean } else { format!("{mean} ± {sd}, {median}") }
        }));
        rows.push(row);
    }
    text += &fitting_table(&rows, 1, format, width);
    text += "\n";
    text += &note(
        "Stacks that share a letter are not told apart by success (exact McNemar tests of all pairs, Holm, 5 %).\n",
    );
    text += "\n";
    if report.copies > 0 {
        text += &note(&copies_left_out(report.copies, report.distinct));
        text += "\n";
    }
    if report.comparisons.is_empty() {
        return text;
    }
    text += &heading(if report.paired {
        "Compared on the same worlds (lengths, times and clearances only where both stacks arrived: conditional on that)"
    } else {
        "Compared as independent samples (the same worlds would allow pairs, which tell more)"
    });
    text += &comparison_table(&report.comparisons, format, width);
    text += "\n";
    text += &note(if report.paired {
        "difference: mean of stack − reference with its 95 % bootstrap interval, success in percentage points; Hodges–Lehmann: the typical difference, which\n\
         belongs to the rank test, with its 95 % interval; ratio: mean of the stack / mean of the reference; p: two-sided; Holm: corrected over all tests\n\
         of this table; effect: odds of winning alone for success, rank-biserial correlation for the rest.\n"
    } else {
        "difference: stack − reference, success in percentage points; Hodges–Lehmann: the shift that belongs to the rank test, with its 95 % interval;\n\
         p: two-sided; Holm: corrected over all tests of this table; effect: odds ratio for success, rank-biserial correlation for the rest.\n"
    });
    if report.paired {
        text += &note(&detectable(&report.comparisons));
    }
    if report.comparisons.iter().any(|comparison| comparison.too_few) {
        text += &note(
            "too few: even if all worlds that tell pointed one way, the test could not be significant: run more episodes.\n",
        );
    }
    if !report.equivalences.is_empty() {
        text += "\n";
        text += &heading("Equivalent up to a margin? (two one-sided tests at 5 %; difference with its 90 % interval)");
        text += &fitting_table(&equivalence_rows(&report.equivalences), 3, format, width);
    }
    text + "\n"
}

/// What differences the worlds of a table can show.
fn detectable(comparisons: &[Comparison]) -> String {
    let alpha = ALPHA / comparisons.len() as f64;
    let (mut shown, mut never) = (Vec::new(), Vec::new());
    for metric in [SUCCESS].into_iter().chain(COMPARED) {
        let tests = comparisons.iter().filter(|test| test.metric == metric && test.spread.is_some());
        let found: Vec<Option<f64>> = tests.map(|test| test.detectable(alpha)).collect();
        let known: Vec<f64> = found.iter().flatten().copied().collect();
        let (low, high) =
            (known.iter().copied().fold(f64::INFINITY, math::min), known.iter().copied().fold(0.0, math::max));
        let unit = if metric == SUCCESS { " points" } else { "" };
        let (least, most) = (digits(metric, low), digits(metric, high));
        if found.contains(&None) {
            never.push(metric);
        } else if !known.is_empty() {
            shown.push(if least == most {
                format!("{metric} {most}{unit}")
            } else {
                format!("{metric} {least} to {most}{unit}")
            });
        }
    }
    if !never.is_empty() {
        shown.push(format!("not any of {}", never.join(", ")));
    }
    if shown.is_empty() {
        return String::new();
    }
    format!("Smallest difference that so many worlds show (power 80 %, after Holm): {}.\n", shown.join("; "))
}

/// Three digits or so of a number that is not negative.
fn digits(metric: &str, value: f64) -> String {
    format!("{value:.*}", decimals(metric, value))
}

/// Decimals that leave about three digits; success has one.
fn decimals(metric: &str, largest: f64) -> usize {
    if metric == SUCCESS || largest >= 10.0 {
        1
    } else if largest >= 1.0 {
        2
    } else {
        3
    }
}

/// A number with its sign and so many decimals; what rounds to 0 is +0.
fn signed(x: f64, places: usize) -> String {
    let text = format!("{x:+.places$}");
    if text.contains(|c: char| ('1'..='9').contains(&c)) { text } else { format!("{:+.places$}", 0.0) }
}

/// A difference with its interval, as many decimals in all three.
pub(super) fn with_interval(metric: &str, value: Option<f64>, interval: Option<(f64, f64)>) -> String {
    let Some(value) = value else { return "-".to_owned() };
    let (low, high) = interval.unwrap_or((value, value));
    let places = decimals(metric, [value, low, high].into_iter().fold(0.0, |most, x| math::max(most, x.abs())));
    let shown = |x: f64| signed(x, places);
    match interval {
        Some(_) => format!("{} [{}, {}]", shown(value), shown(low), shown(high)),
        None => shown(value),
    }
}

/// The tests as cells, with their head. The reference has a column only where there are several, and is not
/// the stack of an older run.
fn comparison_rows(comparisons: &[Comparison]) -> Vec<Vec<String>> {
    let is_one = comparisons.windows(2).all(|pair| pair[0].reference == pair[1].reference)
        || comparisons.iter().all(|test| test.reference == test.stack);
    let is_unpaired = comparisons.iter().all(|comparison| comparison.ratio.is_none() && comparison.interval.is_none());
    let head = [
        "stack",
        "reference",
        "metric",
        "n (informative)",
        if is_unpaired { "difference" } else { "difference [95 %]" },
        "Hodges–Lehmann [95 %]",
        "ratio [95 %]",
        "p",
        "Holm",
        "effect",
        "",
    ];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for c in comparisons {
        rows.push(vec![
            c.stack.clone(),
            c.reference.clone(),
            c.metric.to_owned(),
            format!("{} ({})", c.n, c.informative),
            with_interval(c.metric, c.difference, c.interval),
            with_interval(c.metric, c.shift, c.shift_interval),
            c.ratio.map_or_else(
                || "-".to_owned(),
                |Ratio { ratio, interval: (low, high) }| format!("{ratio:.3} [{low:.3}, {high:.3}]"),
            ),
            p_value(c.p),
            p_value(c.p_holm),
            c.effect.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}")),
            verdict(c).to_owned(),
        ]);
    }
    let dropped = [(1, is_one), (6, is_unpaired)].into_iter().filter(|(_, is_dropped)| *is_dropped);
    for (column, _) in dropped.collect::<Vec<_>>().into_iter().rev() {
        rows.iter_mut().for_each(|row| drop(row.remove(column)));
    }
    rows
}

fn verdict(test: &Comparison) -> &'static str {
    match (test.too_few, test.p_holm <= ALPHA) {
        (true, _) => "too few",
        (false, true) => "differs",
        (false, false) => "",
    }
}

/// The tests as a table. A reference that all share is named above it.
pub fn comparison_table(comparisons: &[Comparison], format: Format, width: usize) -> String {
    let rows = comparison_rows(comparisons);
    let reference = comparisons.first().map_or("", |first| &first.reference);
    let is_one = comparisons.iter().all(|test| test.reference == reference && test.stack != reference);
    let end = if format == Format::Markdown { "\n\n" } else { "\n" };
    let title = if is_one { note(&format!("reference: {reference}{end}"), format, WIDE) } else { String::new() };
    title + &fitting_table(&rows, if rows[0][1] == "reference" { 3 } else { 2 }, format, width)
}

fn equivalence_rows(tests: &[EquivalenceTest]) -> Vec<Vec<String>> {
    let head = ["stack", "reference", "metric", "n", "margin", "90 % interval", "p", "Holm", "verdict"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for test in tests {
        let margin = format!("±{}", digits(test.metric, test.margin));
        let interval = test.interval.map_or_else(
            || "-".to_owned(),
            |(low, high)| {
                let places = decimals(test.metric, math::max(low.abs(), high.abs()));
                format!("[{}, {}]", signed(low, places), signed(high, places))
            },
        );
        rows.push(vec![
            test.stack.clone(),
            test.reference.clone(),
            test.metric.to_owned(),
            test.n.to_string(),
            margin.clone(),
            interval,
            p_value(test.p),
            p_value(test.p_holm),
            if test.is_shown() { format!("equivalent within {margin}") } else { "not shown".to_owned() },
        ]);
    }
    rows
}

pub(super) fn p_value(p: f64) -> String {
    if p < 1e-4 { format!("{p:.1e}") } else { format!("{p:.4}") }
}

/// The ends of an interval.
pub(super) fn ends(interval: Option<(f64, f64)>) -> [Field; 2] {
    [interval.map(|(low, _)| low).into(), interval.map(|(_, high)| high).into()]
}

/// A table as CSV: its head, then its lines.
pub(super) fn csv_text(head: &[String], lines: &[Vec<Field>]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory does not fail.
    let _ = writer.write_record(head);
    for line in lines {
        let _ = writer.write_record(line.iter().map(Field::csv));
    }
    String::from_utf8_lossy(&writer.into_inner().unwrap_or_default()).into_owned()
}

/// The columns of the table of tests.
const TESTS: [&str; 26] = [
    "section",
    "stack",
    "reference",
    "metric",
    "test",
    "n",
    "informative",
    "difference",
    "low",
    "high",
    "p",
    "p_holm",
    "effect",
    "too_few",
    "shift",
    "shift_low",
    "shift_high",
    "ratio",
    "ratio_low",
    "ratio_high",
    "detectable",
    "margin",
    "equivalence_low",
    "equivalence_high",
    "equivalence_p",
    "equivalence_p_holm",
];

/// The values of those columns, one line per test.
fn tests(title: &str, comparisons: &[Comparison], equivalences: &[EquivalenceTest]) -> Vec<Vec<Field>> {
    let alpha = ALPHA / math::max(comparisons.len() as f64, 1.0);
    let line = |c: &Comparison| {
        let of_same =
            |test: &&EquivalenceTest| (&test.stack, &test.reference, test.metric) == (&c.stack, &c.reference, c.metric);
        let equivalence = equivalences.iter().find(of_same);
        let mut line: Vec<Field> = vec![
            title.into(),
            (&c.stack).into(),
            (&c.reference).into(),
            c.metric.into(),
            c.test.into(),
            c.n.into(),
            c.informative.into(),
            c.difference.into(),
        ];
        line.extend(ends(c.interval));
        line.extend([c.p.into(), c.p_holm.into(), c.effect.into(), c.too_few.into(), c.shift.into()]);
        line.extend(ends(c.shift_interval));
        line.push(c.ratio.map(|ratio| ratio.ratio).into());
        line.extend(ends(c.ratio.map(|ratio| ratio.interval)));
        line.extend([c.detectable(alpha).into(), equivalence.map(|test| test.margin).into()]);
        line.extend(ends(equivalence.and_then(|test| test.interval)));
        line.extend([equivalence.map(|test| test.p).into(), equivalence.map(|test| test.p_holm).into()]);
        line
    };
    comparisons.iter().map(line).collect()
}

fn csv(reports: &[Report]) -> String {
    let lines: Vec<Vec<Field>> =
        reports.iter().flat_map(|report| tests(&report.title, &report.comparisons, &report.equivalences)).collect();
    csv_text(&TESTS.map(str::to_owned), &lines)
}

/// Tests as objects of JSON, with the columns of the CSV as keys.
pub fn tests_json(comparisons: &[Comparison], equivalences: &[EquivalenceTest]) -> Vec<Json> {
    let lines = tests("", comparisons, equivalences);
    // The section stands around them.
    lines.iter().map(|line| json_object(TESTS, line).into_iter().skip(1).collect::<Map<_, _>>().into()).collect()
}

/// A section as an object of JSON: its stacks with the columns of `summary.csv` and their `group`, its tests with those of the CSV.
pub fn report_json(report: &Report) -> Json {
    let stacks = report.stacks.iter().zip(&report.letters).map(|(stack, letters)| {
        let mut stack = summary_json(stack);
        stack.insert("group".to_owned(), letters.as_str().into());
        stack
    });
    json!({
        "section": report.title,
        "paired": report.paired,
        "distinct": report.distinct,
        "copies": report.copies,
        "stacks": stacks.collect::<Vec<_>>(),
        "tests": tests_json(&report.comparisons, &report.equivalences),
    })
}
