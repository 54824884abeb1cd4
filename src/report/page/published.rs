//! A folder of `simrun reproduce`: verdicts on the claims, and published numbers beside measured ones.

use super::html::{charts, escape, number, p_value, table};
use super::plots::WIDTH_PX;
use super::{ReportError, read_text};
use crate::report::chart::{self, Beside, BesideRow, Ink};
use std::path::Path;

/// What a folder of `simrun reproduce` holds beside its tables.
#[derive(Debug)]
pub(super) struct Published {
    /// Title of the paper, from its report.
    pub title: String,
    citation: String,
    verdicts: Vec<Vec<String>>,
    numbers: Vec<Number>,
}

/// A published number with the measured one.
#[derive(Debug)]
struct Number {
    place: String,
    table: String,
    stack: String,
    against: String,
    metric: String,
    quantity: String,
    unit: String,
    published: String,
    measured: Option<f64>,
    interval: Option<(f64, f64)>,
}

/// Rows of a CSV by the names of their columns.
fn records(path: &Path, wanted: &[&str]) -> Result<Vec<Vec<String>>, ReportError> {
    let refuse = |message: String| ReportError::File { path: path.to_owned(), message };
    let text = read_text(path)?;
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let head = reader.headers().map_err(|error| refuse(error.to_string()))?.clone();
    let places = wanted.iter().map(|name| {
        head.iter().position(|found| found == *name).ok_or_else(|| refuse(format!("expected the column `{name}`")))
    });
    let places = places.collect::<Result<Vec<usize>, _>>()?;
    let row =
        |record: csv::StringRecord| places.iter().map(|&at| record.get(at).unwrap_or_default().to_owned()).collect();
    reader.records().map(|record| record.map(row).map_err(|error| refuse(error.to_string()))).collect()
}

impl Published {
    /// What `folder` holds; `None` if it is no folder of `simrun reproduce`.
    pub fn read(folder: &Path) -> Result<Option<Self>, ReportError> {
        let (verdicts, numbers) = (folder.join("verdicts.csv"), folder.join("numbers.csv"));
        if !verdicts.is_file() || !numbers.is_file() {
            return Ok(None);
        }
        let verdicts =
            records(&verdicts, &["id", "asked_by", "claim", "verdict", "because", "p_holm", "kindest", "depends_on"])?;
        let wanted = [
            "where",
            "table",
            "stack",
            "against",
            "metric",
            "quantity",
            "unit",
            "published",
            "measured",
            "low",
            "high",
        ];
        let numbers = records(&numbers, &wanted)?.into_iter().filter_map(|row| {
            let [place, table, stack, against, metric, quantity, unit, published, measured, low, high] =
                row.try_into().ok()?;
            let interval = low.parse().ok().zip(high.parse().ok());
            Some(Number {
                place,
                table,
                stack,
                against,
                metric,
                quantity,
                unit,
                published,
                measured: measured.parse().ok(),
                interval,
            })
        });
        // The report opens with the title and the citation.
        let report = read_text(&folder.join("report.md")).unwrap_or_default();
        let mut lines = report.lines().filter(|line| !line.trim().is_empty());
        let title = lines.next().and_then(|line| line.strip_prefix("# ")).map(str::to_owned);
        let citation = lines.next().filter(|line| !line.starts_with('#')).unwrap_or_default().to_owned();
        let named = folder.file_name().map_or_else(|| "paper".to_owned(), |name| name.to_string_lossy().into_owned());
        Ok(Some(Self { title: title.unwrap_or(named), citation, verdicts, numbers: numbers.collect() }))
    }

    /// The section of the page.
    pub fn section(&self) -> String {
        let mut text = "<section id=\"published\"><h2>Published and measured</h2>\n".to_owned();
        if !self.citation.is_empty() {
            text += &format!("<p class=\"lead\">{}</p>\n", escape(&self.citation));
        }
        text += &self.claims("paper", "Claims of the paper");
        text += &self.claims("simrun", "Questions of ours");
        text += &self.figures();
        text += &self.every_number();
        text + "</section>\n"
    }

    fn claims(&self, asked_by: &str, title: &str) -> String {
        let asked = || self.verdicts.iter().filter(|verdict| verdict[1] == asked_by);
        if asked().next().is_none() {
            return String::new();
        }
        let mut counts: Vec<(&str, usize)> = Vec::new();
        for verdict in asked() {
            match counts.iter_mut().find(|(words, _)| *words == verdict[3]) {
                Some((_, count)) => *count += 1,
                None => counts.push((&verdict[3], 1)),
            }
        }
        let counts: Vec<String> = counts.iter().map(|(words, count)| format!("{count} {}", escape(words))).collect();
        let rows: Vec<Vec<String>> = asked()
            .map(|verdict| {
                let p = verdict[5].parse().map_or_else(|_| "–".to_owned(), p_value);
                let rests = match (verdict[6].as_str(), verdict[7].as_str()) {
                    ("", "") => String::new(),
                    (kindest, "") => format!("kindest reading: {kindest}"),
                    ("", turned) => format!("turned by {turned}"),
                    (kindest, turned) => format!("kindest reading: {kindest}; turned by {turned}"),
                };
                vec![
                    escape(&verdict[0]),
                    escape(&verdict[2]),
                    format!("<span class=\"verdict\" data-verdict=\"{0}\">{0}</span>", escape(&verdict[3])),
                    escape(&verdict[4]),
                    escape(&rests),
                    p,
                ]
            })
            .collect();
        let head = ["", "claim", "verdict", "because", "rests on", "p, Holm"].map(str::to_owned);
        format!("<h3>{title}</h3>\n<p>{}.</p>\n{}", counts.join(", "), table(&head, &rows, 5, "claims"))
    }

    /// One figure a table: the metric with most published means in it.
    fn figures(&self) -> String {
        let is_mean = |number: &&Number| {
            number.quantity == "mean"
                && number.against.is_empty()
                && number.published.parse::<f64>().is_ok()
                && number.measured.is_some()
        };
        let mut tables: Vec<&str> = Vec::new();
        for number in self.numbers.iter().filter(is_mean) {
            if !tables.contains(&number.table.as_str()) {
                tables.push(&number.table);
            }
        }
        let mut figures = Vec::new();
        for table in tables {
            let of_table = || self.numbers.iter().filter(is_mean).filter(|number| number.table == table);
            let count = |metric: &str| of_table().filter(|number| number.metric == metric).count();
            let mut metrics: Vec<&str> = of_table().map(|number| number.metric.as_str()).collect();
            metrics.sort_by_key(|metric| std::cmp::Reverse(count(metric)));
            let Some(metric) = metrics.first().copied() else { continue };
            let rows = of_table().filter(|number| number.metric == metric).map(|number| BesideRow {
                name: number.stack.clone(),
                published: number.published.parse().ok(),
                measured: number.measured,
                interval: number.interval,
            });
            let chart = Beside { width_px: WIDTH_PX, label: chart::label(metric), rows: rows.collect() };
            figures.push((format!("{table}: {}", chart::words(metric)), chart.draw(&Ink::PAGE)));
        }
        if figures.is_empty() {
            String::new()
        } else {
            format!("<h3>The principal figure of each table</h3>\n{}", charts(&figures))
        }
    }

    fn every_number(&self) -> String {
        if self.numbers.is_empty() {
            return String::new();
        }
        let rows: Vec<Vec<String>> = self
            .numbers
            .iter()
            .map(|ours| {
                let against =
                    if ours.against.is_empty() { String::new() } else { format!(" against {}", ours.against) };
                let measured = ours.measured.map_or_else(|| "–".to_owned(), |value| number(value, 2));
                let interval = ours.interval.map_or_else(String::new, |(low, high)| {
                    format!(" <span class=\"i\">[{}, {}]</span>", number(low, 2), number(high, 2))
                });
                vec![
                    escape(&ours.place),
                    escape(&ours.table),
                    escape(&ours.stack),
                    escape(&format!("{} {}{against}, {}", ours.metric, ours.quantity, ours.unit)),
                    escape(&ours.published),
                    format!("{measured}{interval}"),
                ]
            })
            .collect();
        let head = ["where", "table", "stack", "what", "published", "measured [95 %]"].map(str::to_owned);
        format!(
            "<details><summary>Every published number beside ours ({})</summary>\n{}</details>\n",
            rows.len(),
            table(&head, &rows, 4, "numbers")
        )
    }
}
