//! Tables of LaTeX. They need the package booktabs and no other: decimals stand below each other because every number is filled up to
//! the most decimals of its column, by digits that are not seen.

use crate::results::metric_column;
use std::fmt::Write as _;

/// The longest text that stands on one line of its column, characters.
const LINE_CHARS_MAX: usize = 60;

/// Rows of cells as a `tabular`; the first row is the head, the first `left` columns are texts. A row of one cell is a title across the table.
///
/// Cells such as `96.7 [92.0, 99.1]`, `12.3 ± 0.4, 12.1` and `40 (3)` are taken apart so that each of their numbers is aligned.
pub(super) fn latex(rows: &[Vec<String>], left: usize) -> String {
    let Some((head, body)) = rows.split_first() else { return String::new() };
    let columns: Vec<Column> = (0..head.len())
        .map(|at| Column::of(body.iter().filter_map(|row| row.get(at)).filter(|_| head.len() > 1), at < left))
        .collect();
    let count: usize = columns.iter().map(Column::width).sum();
    let last = columns.len().saturating_sub(1);
    let specs: String = columns.iter().enumerate().map(|(at, column)| column.spec(at == last)).collect();
    let heads = head.iter().zip(&columns).map(|(text, column)| column.head(&heading(text)));
    let mut text = format!("\\begin{{tabular}}{{{specs}}}\n\\toprule\n{} \\\\\n\\midrule\n", joined(heads));
    for (at, row) in body.iter().enumerate() {
        let _ = match &row[..] {
            [title] if columns.len() > 1 => {
                let rule = if at > 0 { "\\addlinespace\n" } else { "" };
                writeln!(text, "{rule}\\multicolumn{{{count}}}{{l}}{{\\emph{{{}}}}} \\\\", escaped(title))
            }
            cells => {
                writeln!(text, "{} \\\\", joined(cells.iter().zip(&columns).map(|(cell, column)| column.cell(cell))))
            }
        };
    }
    text + "\\bottomrule\n\\end{tabular}\n"
}

fn joined(cells: impl Iterator<Item = String>) -> String {
    cells.collect::<Vec<_>>().join(" & ")
}

/// A text as a comment.
pub(super) fn comment(text: &str) -> String {
    text.trim_end().lines().map(|line| format!("% {line}").trim_end().to_owned() + "\n").collect()
}

/// The name of a metric in words with its unit, `length_m` as "length, m"; any other text as it is.
fn heading(text: &str) -> String {
    let Ok(column) = metric_column(text) else { return escaped(text) };
    let bare = if column.unit.is_empty() { text } else { text.rsplit_once('_').map_or(text, |(bare, _)| bare) };
    let words = bare.replace('_', " ");
    escaped(&if column.unit.is_empty() { words } else { format!("{words}, {}", column.unit) })
}

/// How the cells of a column are set.
enum Column {
    /// Texts, in lines of their own length or in a paragraph.
    Text { is_long: bool },
    /// Numbers with the marks between, before and behind them; `decimals` are the most of each number.
    Numbers { marks: Vec<String>, decimals: Vec<usize> },
}

impl Column {
    fn of<'a>(cells: impl Iterator<Item = &'a String>, is_text: bool) -> Self {
        let cells: Vec<&String> = cells.filter(|cell| !is_blank(cell)).collect();
        let is_long = cells.iter().any(|cell| cell.chars().count() > LINE_CHARS_MAX);
        let Some(parts) = cells.iter().map(|cell| Parts::of(cell)).collect::<Option<Vec<_>>>() else {
            return Self::Text { is_long };
        };
        let Some(full) = parts.iter().max_by_key(|parts| parts.numbers.len()).filter(|_| !is_text) else {
            return Self::Text { is_long };
        };
        // A number by itself, such as a mean without a deviation, stands in the middle.
        if parts.iter().any(|parts| parts.marks != full.marks && parts.numbers.len() > 1) {
            return Self::Text { is_long };
        }
        let most = |number: usize| {
            let complete = parts.iter().filter(|parts| parts.marks == full.marks);
            complete.map(|parts| decimals(parts.numbers[number])).fold(0, usize::max)
        };
        Self::Numbers {
            marks: full.marks.iter().map(|mark| (*mark).to_owned()).collect(),
            decimals: (0..full.numbers.len()).map(most).collect(),
        }
    }

    /// Number of columns of LaTeX.
    fn width(&self) -> usize {
        match self {
            Self::Text { .. } => 1,
            Self::Numbers { decimals, .. } => decimals.len(),
        }
    }

    fn spec(&self, is_last: bool) -> String {
        match self {
            Self::Text { is_long: false } => "l".to_owned(),
            Self::Text { is_long: true } => "p{0.55\\linewidth}".to_owned(),
            Self::Numbers { marks, .. } => {
                let space = if is_last { "" } else { "\\hspace{2\\tabcolsep}" };
                let behind = marks.iter().skip(1).enumerate().map(|(at, mark)| match mark.as_str() {
                    "" => "r".to_owned(),
                    mark if at + 2 == marks.len() => format!("r@{{{}{space}}}", escaped(mark)),
                    mark => format!("r@{{{}}}", escaped(mark)),
                });
                behind.collect()
            }
        }
    }

    fn head(&self, text: &str) -> String {
        match (self, self.width()) {
            (Self::Text { .. }, _) => text.to_owned(),
            (Self::Numbers { .. }, 1) => format!("\\multicolumn{{1}}{{r}}{{{text}}}"),
            (Self::Numbers { .. }, width) => format!("\\multicolumn{{{width}}}{{c}}{{{text}}}"),
        }
    }

    fn cell(&self, cell: &str) -> String {
        let Self::Numbers { decimals: most, .. } = self else { return heading(cell) };
        match Parts::of(cell) {
            Some(parts) if parts.numbers.len() == most.len() => {
                joined(parts.numbers.iter().zip(most).map(|(number, &most)| set_number(number, most)))
            }
            _ => {
                let shown = if cell == "-" { "--".to_owned() } else { escaped(cell) };
                match most.len() {
                    1 => shown.clone(),
                    width => format!("\\multicolumn{{{width}}}{{c}}{{{shown}}}"),
                }
            }
        }
    }
}

fn is_blank(cell: &str) -> bool {
    cell.is_empty() || cell == "-"
}

/// A cell taken apart: numbers, and what stands before, between and behind them.
struct Parts<'a> {
    numbers: Vec<&'a str>,
    /// One more than numbers.
    marks: Vec<&'a str>,
}

impl<'a> Parts<'a> {
    /// `None` if the cell holds anything but numbers and the usual marks, or begins with a mark other than `±`.
    fn of(cell: &'a str) -> Option<Self> {
        let (mut numbers, mut marks, mut rest) = (Vec::new(), Vec::new(), cell);
        loop {
            let start = rest.find(|c: char| c.is_ascii_digit() || "+-".contains(c)).unwrap_or(rest.len());
            let (mark, from_number) = rest.split_at(start);
            marks.push(mark);
            if from_number.is_empty() {
                break;
            }
            let number = number_at(from_number)?;
            numbers.push(number);
            rest = &from_number[number.len()..];
        }
        let known = ["", " [", ", ", "]", " (", ")", " ± ", " %"];
        let is_known = marks.iter().all(|mark| known.contains(mark)) && marks[0].is_empty();
        (is_known && !numbers.is_empty()).then_some(Self { numbers, marks })
    }
}

/// The number with which a text begins.
fn number_at(text: &str) -> Option<&str> {
    let is_digit = |c: char| c.is_ascii_digit();
    let digits = |from: usize| text[from..].find(|c| !is_digit(c)).map_or(text.len(), |length| from + length);
    let start = usize::from(text.starts_with(['+', '-']));
    let mut end = digits(start);
    if end == start {
        return None;
    }
    if text[end..].starts_with('.') && text[end + 1..].starts_with(is_digit) {
        end = digits(end + 1);
    }
    if let Some(exponent) = text[end..].strip_prefix('e') {
        let from = end + 1 + usize::from(exponent.starts_with(['+', '-']));
        if text[from..].starts_with(is_digit) {
            end = digits(from);
        }
    }
    Some(&text[..end])
}

/// Decimals of a number; one with an exponent has none that could be aligned.
fn decimals(number: &str) -> usize {
    if number.contains('e') { 0 } else { number.split_once('.').map_or(0, |(_, decimals)| decimals.len()) }
}

/// A number with digits that are not seen, up to `most` decimals.
fn set_number(number: &str, most: usize) -> String {
    if let Some((digits, exponent)) = number.split_once('e') {
        return format!("${digits}\\times10^{{{exponent}}}$");
    }
    let signed = match number.strip_prefix(['+', '-']) {
        Some(digits) => format!("${}${digits}", &number[..1]),
        None => number.to_owned(),
    };
    let missing = "0".repeat(most - decimals(number));
    match (missing.is_empty(), number.contains('.')) {
        (true, _) => signed,
        (false, true) => format!("{signed}\\phantom{{{missing}}}"),
        (false, false) => format!("{signed}\\phantom{{.{missing}}}"),
    }
}

/// A text in which nothing is a command of LaTeX.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' => out.push_str("\\textbackslash{}"),
            '~' => out.push_str("\\textasciitilde{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => out.extend(['\\', c]),
            '<' => out.push_str("\\textless{}"),
            '>' => out.push_str("\\textgreater{}"),
            '|' => out.push_str("\\textbar{}"),
            '"' => out.push_str("\\textquotedbl{}"),
            '±' => out.push_str("$\\pm$"),
            '−' => out.push_str("$-$"),
            '·' => out.push_str("$\\cdot$"),
            '²' => out.push_str("$^2$"),
            '³' => out.push_str("$^3$"),
            '≥' => out.push_str("$\\ge$"),
            '≤' => out.push_str("$\\le$"),
            '→' => out.push_str("$\\to$"),
            '×' => out.push_str("$\\times$"),
            '…' => out.push_str("\\dots{}"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(rows: &[&[&str]], left: usize) -> String {
        let rows: Vec<Vec<String>> = rows.iter().map(|row| row.iter().map(|&cell| cell.to_owned()).collect()).collect();
        latex(&rows, left)
    }

    #[test]
    fn nothing_in_a_text_is_a_command() {
        assert_eq!(
            escaped("a_star+dwa 50 % #1 {x} ~^\\"),
            "a\\_star+dwa 50 \\% \\#1 \\{x\\} \\textasciitilde{}\\textasciicircum{}\\textbackslash{}"
        );
        assert_eq!(comment("a\n\nb_c 5 %\n"), "% a\n%\n% b_c 5 %\n");
    }

    #[test]
    fn numbers_are_filled_up_to_the_decimals_of_their_column() {
        let text = table(
            &[
                &["stack", "success % [95 %]", "length_m", "p"],
                &["a_star+dwa", "96.7 [92.0, 99.1]", "+1.25", "0.0123"],
                &["bfs", "100.0 [97, 100]", "-3", "1.2e-10"],
                &["none", "-", "-", ""],
            ],
            1,
        );
        let expected = r"\begin{tabular}{lr@{ [}r@{, }r@{]\hspace{2\tabcolsep}}rr}
\toprule
stack & \multicolumn{3}{c}{success \% [95 \%]} & \multicolumn{1}{r}{length, m} & \multicolumn{1}{r}{p} \\
\midrule
a\_star+dwa & 96.7 & 92.0 & 99.1 & $+$1.25 & 0.0123 \\
bfs & 100.0 & 97\phantom{.0} & 100\phantom{.0} & $-$3\phantom{.00} & $1.2\times10^{-10}$ \\
none & \multicolumn{3}{c}{--} & -- &  \\
\bottomrule
\end{tabular}
";
        assert_eq!(text, expected);
    }

    #[test]
    fn every_row_has_as_many_columns_as_the_table() {
        let text = table(
            &[
                &["stack", "metric", "n (informative)", "mean", ""],
                &["robot.radius_m = 0.2"],
                &["a & b", "time_s", "40 (3)", "12.3 ± 0.4, 12.1", "too few"],
                &["c", "success", "7 (0)", "5", ""],
            ],
            2,
        );
        let spec = text.lines().next().unwrap().trim_start_matches("\\begin{tabular}");
        // Without what stands between columns.
        let mut depth = 0;
        let columns = spec[1..spec.len() - 1].chars().filter(|c| {
            depth += i32::from(*c == '{') - i32::from(*c == '}');
            depth == 0 && "lrc".contains(*c)
        });
        assert_eq!(columns.count(), 8, "{spec}");
        for line in text.lines().filter(|line| line.ends_with("\\\\")) {
            let spans = line.split("\\multicolumn{").skip(1).map(|rest| rest[..1].parse::<usize>().unwrap() - 1);
            let cells = line.replace("\\&", "").matches('&').count() + 1 + spans.sum::<usize>();
            assert_eq!(cells, 8, "{line}");
        }
        assert!(text.contains("a \\& b & time, s & 40 & 3 & 12.3 & 0.4 & 12.1 & too few"), "{text}");
        assert!(text.contains("c & success & 7 & 0 & \\multicolumn{3}{c}{5} & "), "{text}");
        assert!(text.contains("\\multicolumn{8}{l}{\\emph{robot.radius\\_m = 0.2}}"), "{text}");
    }

    #[test]
    fn long_texts_become_paragraphs() {
        let long = "a claim ".repeat(12);
        assert!(table(&[&["claim", "n"], &[&long, "1"]], 1).starts_with("\\begin{tabular}{p{0.55\\linewidth}r}"));
    }
}
