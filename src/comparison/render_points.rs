//! The ranking of a sweep's settings as text, Markdown and CSV.

use super::latex::comment;
use super::pair::SUCCESS;
use super::render::{copies_left_out, csv_text, ends, fitting_table, heading, note, p_value, success, with_interval};
use super::{Format, PointRanking};
use crate::results::{Field, json_object};
use crate::settings::quantity::counted;
use serde_json::{Value as Json, json};

/// The settings of a sweep, best first, with the tests against the best. Lines of text have at most `width` characters where that can be
/// done.
pub fn render_points(ranking: &PointRanking, format: Format, width: usize) -> String {
    if format == Format::Csv {
        return csv_text(&head(ranking), &lines(ranking));
    }
    let mut text = heading(&ranking.title, 1, format, width) + &heading("Settings, best first", 2, format, width);
    let keys: Vec<String> = ranking.keys.iter().map(|key| short_key(key, &ranking.keys)).collect();
    let is_one_stack = ranking.ranked.windows(2).all(|pair| pair[0].summary.stack == pair[1].summary.stack);
    let mut head: Vec<String> = ["rank", "point"].map(str::to_owned).to_vec();
    if !is_one_stack {
        head.push("stack".to_owned());
    }
    head.extend(keys);
    head.extend(["n", "success % [95 %]", "group", "time_s"].map(str::to_owned));
    for metric in &ranking.metrics {
        head.extend([format!("{metric} − best"), "Holm".to_owned()]);
    }
    let mut rows = vec![head];
    for (index, point) in ranking.ranked.iter().enumerate() {
        let mut row = vec![(index + 1).to_string(), point.point.to_string()];
        if !is_one_stack {
            row.push(point.summary.stack.clone());
        }
        row.extend(point.values.iter().map(|value| if value.is_empty() { "-".to_owned() } else { value.clone() }));
        let time = point.summary.metric("time_s").mean.map_or_else(|| "-".to_owned(), |mean| format!("{mean:.2}"));
        row.extend([point.summary.rated.to_string(), success(&point.summary), point.letters.clone(), time]);
        for metric in &ranking.metrics {
            row.extend(match point.tests.iter().find(|test| test.metric == *metric) {
                None => ["", ""].map(str::to_owned),
                Some(test) if test.metric == SUCCESS => {
                    [with_interval(metric, test.difference, None), p_value(test.p_holm)]
                }
                Some(test) => [with_interval(metric, test.shift, test.shift_interval), p_value(test.p_holm)],
            });
        }
        rows.push(row);
    }
    text += &fitting_table(&rows, 0, format, width);
    text += "\n";
    let mut words = format!(
        "Settings that share a letter are not told apart by success (exact tests of all pairs, Holm, 5 %). {} − best: success in percentage points, the\n\
         rest the Hodges–Lehmann estimate with its 95 % interval, where both arrived; Holm: p-value corrected over all {} of this table.\n",
        ranking.metrics.join(", "),
        counted(ranking.ranked.iter().map(|point| point.tests.len() as u64).sum(), "test"),
    );
    if ranking.copies > 0 {
        words += &copies_left_out(ranking.copies, ranking.distinct);
    }
    let others: Vec<String> =
        ranking.ranked.iter().filter(|point| !point.is_paired).map(|point| point.point.to_string()).collect();
    if !others.is_empty() {
        words += &format!(
            "In other worlds than the best, hence compared as independent samples (Fisher's exact test, rank sums): points {}.\n",
            others.join(", ")
        );
    }
    let needed = ranking.worlds_needed();
    if !needed.is_empty() {
        words += &format!("{needed}\n");
    }
    text += &note(&words, format, width);
    let arguments = ranking.best_arguments();
    let command = format!("simrun SCENARIO {arguments} --seed NEW --out best");
    text += &note(
        "The best was chosen by these worlds, so its figures are too good on average; drive it in others:\n",
        format,
        width,
    );
    text += &match format {
        Format::Markdown => format!("\n```sh\n{command}\n```\n\n"),
        Format::Text | Format::Csv => format!("    {command}\n\n"),
        Format::Latex => comment(&format!("    {command}")) + "\n",
    };
    text
}

/// The last part of a key where no other key ends alike, else the whole.
fn short_key(key: &str, keys: &[String]) -> String {
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_owned();
    let alike = keys.iter().filter(|other| last(other) == last(key)).count();
    if alike == 1 { last(key) } else { key.to_owned() }
}

/// The columns of the ranking.
fn head(ranking: &PointRanking) -> Vec<String> {
    let mut head: Vec<String> = ["rank", "point", "stack"].map(str::to_owned).to_vec();
    head.extend(ranking.keys.iter().cloned());
    head.extend(
        ["n", "success_rate", "success_rate_low", "success_rate_high", "group", "time_s_mean"].map(str::to_owned),
    );
    for metric in &ranking.metrics {
        let columns = ["test", "n", "difference", "low", "high", "shift", "shift_low", "shift_high", "p", "p_holm"];
        head.extend(columns.map(|column| format!("{metric}_{column}")));
    }
    head
}

/// The values of those columns, best first.
fn lines(ranking: &PointRanking) -> Vec<Vec<Field>> {
    let ranked = ranking.ranked.iter().enumerate().map(|(index, point)| {
        let mut line: Vec<Field> = vec![(index as u64 + 1).into(), point.point.into(), (&point.summary.stack).into()];
        line.extend(point.values.iter().cloned().map(Field::Setting));
        line.push(point.summary.rated.into());
        let rate = point.summary.success;
        line.extend([rate.map(|r| r.rate), rate.map(|r| r.low), rate.map(|r| r.high)].map(Field::from));
        line.extend([Field::from(&point.letters), point.summary.metric("time_s").mean.into()]);
        for metric in &ranking.metrics {
            match point.tests.iter().find(|test| test.metric == *metric) {
                None => line.extend(vec![Field::Empty; 10]),
                Some(test) => {
                    line.extend([test.test.into(), test.n.into(), test.difference.into()]);
                    line.extend(ends(test.interval));
                    line.push(test.shift.into());
                    line.extend(ends(test.shift_interval));
                    line.extend([test.p.into(), test.p_holm.into()]);
                }
            }
        }
        line
    });
    ranked.collect()
}

/// The ranking as an object of JSON, each setting with the columns of the CSV as keys.
pub fn points_json(ranking: &PointRanking) -> Json {
    let head = head(ranking);
    let ranked =
        lines(ranking).iter().map(|line| json_object(head.iter().map(String::as_str), line)).collect::<Vec<_>>();
    json!({
        "section": ranking.title,
        "keys": ranking.keys,
        "distinct": ranking.distinct,
        "copies": ranking.copies,
        "points": ranked,
        "worlds_needed": ranking.worlds_needed(),
        "best_arguments": ranking.best_arguments(),
    })
}
