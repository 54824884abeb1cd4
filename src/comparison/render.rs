//! Reports as text, Markdown and CSV.

use super::{COMPARED, Comparison, Report};
use crate::episode::Outcome;
use crate::results::{Rate, Statistics};
use crate::settings::quantity::counted;
use std::fmt::Write as _;

/// Format of a report.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Aligned columns for a terminal.
    #[default]
    Text,
    /// Tables of Markdown.
    Markdown,
    /// The tests, one per line, every section in one table.
    Csv,
}

/// The reports of all sections in one text.
pub fn render(reports: &[Report], format: Format) -> String {
    match format {
        Format::Csv => csv(reports),
        Format::Text | Format::Markdown => reports.iter().map(|report| section(report, format)).collect(),
    }
}

/// Rows of cells as a table; the first row is the head. Text is aligned, the first `left` columns to the left.
pub fn table(rows: &[Vec<String>], left: usize, format: Format) -> String {
    let mut text = String::new();
    if format == Format::Markdown {
        for (index, row) in rows.iter().enumerate() {
            let _ = writeln!(text, "| {} |", row.join(" | "));
            if index == 0 {
                let marks = (0..row.len()).map(|column| if column < left { "---" } else { "---:" });
                let _ = writeln!(text, "|{}|", marks.collect::<Vec<_>>().join("|"));
            }
        }
        return text;
    }
    let columns = rows.first().map_or(0, Vec::len);
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or_default();
    let widths: Vec<usize> = (0..columns).map(width).collect();
    for row in rows {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| {
            if column < left { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
        });
        let _ = writeln!(text, "{}", cells.collect::<Vec<_>>().join("  ").trim_end());
    }
    text
}

fn section(report: &Report, format: Format) -> String {
    let heading = |text: &str| match format {
        Format::Markdown => format!("### {text}\n\n"),
        Format::Text | Format::Csv => format!("{text}\n"),
    };
    let mut text = match format {
        Format::Markdown => format!("## {}\n\n", report.title),
        Format::Text | Format::Csv => format!("{}\n\n", report.title),
    };
    text += &heading(
        "Each stack by itself (success of all episodes; the rest of the successful ones: mean ± sd, median [quartiles])",
    );
    let mut rows = vec![vec!["stack".to_owned(), "n".to_owned(), "success % [95 %]".to_owned(), "group".to_owned()]];
    let endings: Vec<usize> =
        (1..Outcome::NAMES.len()).filter(|&k| report.stacks.iter().any(|stack| stack.outcomes[k] > 0)).collect();
    rows[0].extend(endings.iter().map(|&k| Outcome::NAMES[k].to_owned()));
    rows[0].extend(COMPARED.map(str::to_owned));
    for (stack, letters) in report.stacks.iter().zip(&report.letters) {
        let success = stack.success.map_or_else(
            || "-".to_owned(),
            |Rate { rate, low, high }| format!("{:.1} [{:.1}, {:.1}]", 100.0 * rate, 100.0 * low, 100.0 * high),
        );
        let mut row = vec![stack.stack.clone(), stack.rated.to_string(), success, letters.clone()];
        row.extend(endings.iter().map(|&k| stack.outcomes[k].to_string()));
        row.extend(COMPARED.iter().map(|metric| {
            let Statistics { n, mean, sd, median, q1, q3 } = *stack.metric(metric);
            let shown = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.2}"));
            let [mean, sd, median, q1, q3] = [mean, sd, median, q1, q3].map(shown);
            if n == 0 { mean } else { format!("{mean} ± {sd}, {median} [{q1}, {q3}]") }
        }));
        rows.push(row);
    }
    text += &table(&rows, 1, format);
    text +=
        "\nStacks that share a letter are not told apart by success (exact McNemar tests of all pairs, Holm, 5 %).\n\n";
    if report.copies > 0 {
        text += &format!(
            "{} left out: nothing in them is random, so they are copies of the {} that {}.\n\n",
            counted(report.copies, "episode"),
            report.distinct,
            if report.distinct == 1 { "counts; one world is no sample, and nothing is tested" } else { "count" }
        );
    }
    if report.comparisons.is_empty() {
        return text;
    }
    text += &heading(if report.paired {
        "Compared on the same worlds (lengths, times and clearances only where both stacks arrived: conditional on that)"
    } else {
        "Compared as independent samples (the same worlds would allow pairs, which tell more)"
    });
    text += &table(&comparison_rows(&report.comparisons), 3, format);
    text += if report.paired {
        "\ndifference: stack − reference, success in percentage points, with its 95 % bootstrap interval; p: two-sided; Holm: corrected over \
         all tests of this table;\neffect: odds of winning alone for success, rank-biserial correlation for the rest.\n"
    } else {
        "\ndifference: stack − reference, success in percentage points; p: two-sided; Holm: corrected over all tests of this table; effect: \
         odds ratio for success,\nrank-biserial correlation for the rest.\n"
    };
    if report.comparisons.iter().any(|comparison| comparison.too_few) {
        text += "too few: even if all worlds that tell pointed one way, the test could not be significant: run more episodes.\n";
    }
    text + "\n"
}

/// The tests as cells, with their head.
fn comparison_rows(comparisons: &[Comparison]) -> Vec<Vec<String>> {
    let head =
        ["stack", "reference", "metric", "n", "informative", "difference", "95 % interval", "p", "Holm", "effect", ""];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    let real = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.3}"));
    for c in comparisons {
        let verdict = match (c.too_few, c.p_holm <= super::ALPHA) {
            (true, _) => "too few",
            (false, true) => "differs",
            (false, false) => "",
        };
        rows.push(vec![
            c.stack.clone(),
            c.reference.clone(),
            c.metric.to_owned(),
            c.n.to_string(),
            c.informative.to_string(),
            c.difference.map_or_else(|| "-".to_owned(), |value| format!("{value:+.3}")),
            c.interval.map_or_else(|| "-".to_owned(), |(low, high)| format!("[{low:+.3}, {high:+.3}]")),
            p_value(c.p),
            p_value(c.p_holm),
            real(c.effect),
            verdict.to_owned(),
        ]);
    }
    rows
}

/// The tests as aligned text.
pub fn comparison_table(comparisons: &[Comparison]) -> String {
    table(&comparison_rows(comparisons), 3, Format::Text)
}

fn p_value(p: f64) -> String {
    if p < 1e-4 { format!("{p:.1e}") } else { format!("{p:.4}") }
}

fn csv(reports: &[Report]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let head = [
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
    ];
    let mut lines = vec![head.map(str::to_owned)];
    let real = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value}"));
    for report in reports {
        for c in &report.comparisons {
            lines.push([
                report.title.clone(),
                c.stack.clone(),
                c.reference.clone(),
                c.metric.to_owned(),
                c.test.to_owned(),
                c.n.to_string(),
                c.informative.to_string(),
                real(c.difference),
                real(c.interval.map(|(low, _)| low)),
                real(c.interval.map(|(_, high)| high)),
                c.p.to_string(),
                c.p_holm.to_string(),
                real(c.effect),
                c.too_few.to_string(),
            ]);
        }
    }
    for line in lines {
        // Writing to memory does not fail.
        let _ = writer.write_record(&line);
    }
    String::from_utf8_lossy(&writer.into_inner().unwrap_or_default()).into_owned()
}
