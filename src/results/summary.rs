//! `summary.csv`: rates and statistics over the rows of each stack at each sweep point.

use super::ReadError;
use super::columns::metric_columns;
use super::csv_rows::Reader;
use super::field::{Field, json_object};
use super::row::Row;
use crate::analysis::{Z_95, quantile, wilson};
use crate::episode::Outcome;
use serde_json::{Map, Value as Json};
use std::io::{self, BufRead};

/// A rate with its Wilson 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rate {
    /// Successes divided by trials.
    pub rate: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// Statistics of one metric. `None` if undefined.
///
/// Sums run in the order of the rows. Quantiles interpolate linearly (type 7, [`quantile`]).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Number of successes in which the metric is defined.
    pub n: u64,
    /// Arithmetic mean.
    pub mean: Option<f64>,
    /// Standard deviation of the sample (divisor n − 1); `None` for fewer than two values.
    pub sd: Option<f64>,
    /// Median.
    pub median: Option<f64>,
    /// First quartile.
    pub q1: Option<f64>,
    /// Third quartile.
    pub q3: Option<f64>,
}

impl Statistics {
    /// The statistics of values in the order of their rows; they are sorted on return.
    pub(crate) fn of(values: &mut [f64]) -> Self {
        let n = values.len() as f64;
        let Some(mean) = (n > 0.0).then(|| values.iter().sum::<f64>() / n) else {
            return Self::default();
        };
        let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
        let sd = (n > 1.0).then(|| (squares / (n - 1.0)).sqrt());
        values.sort_unstable_by(f64::total_cmp);
        let [q1, median, q3] = [0.25, 0.5, 0.75].map(|p| quantile(values, p));
        Self { n: values.len() as u64, mean: Some(mean), sd, median, q1, q3 }
    }

    fn fields(&self) -> [Option<f64>; 5] {
        [self.mean, self.sd, self.median, self.q1, self.q3]
    }
}

/// One row of `summary.csv`: a stack at a sweep point.
#[derive(Clone, Debug, PartialEq)]
pub struct SummaryRow {
    /// Name of the scenario.
    pub scenario: String,
    /// Number of the sweep point.
    pub point: u32,
    /// Name of the stack.
    pub stack: String,
    /// Number of episodes, infeasible worlds included.
    pub n: u64,
    /// Number of episodes that rates count ([`Outcome::is_rated`]).
    pub rated: u64,
    /// Number of episodes per outcome, in the order of [`Outcome::NAMES`].
    pub outcomes: [u64; Outcome::NAMES.len()],
    /// Number of collisions in which the robot stood still.
    pub collision_at_rest: u64,
    /// Success rate over the feasible worlds; `None` without a feasible world.
    pub success: Option<Rate>,
    /// Mean of the column `spl` over the feasible worlds, failures counting 0 (Anderson et al. 2018);
    /// `None` if it is undefined in one of them.
    pub spl: Option<f64>,
    /// One entry per metric column ([`metric_columns`]), over the successes.
    pub metrics: Vec<Statistics>,
    /// Swept keys and their values at this point.
    pub swept: Vec<(String, String)>,
}

impl SummaryRow {
    /// Statistics of a metric.
    ///
    /// # Panics
    /// If no metric column has that name.
    pub fn metric(&self, name: &str) -> &Statistics {
        let index = metric_columns().position(|column| column.name == name);
        &self.metrics[index.unwrap_or_else(|| panic!("no metric is called `{name}`"))]
    }

    /// Number of episodes with an outcome of that name.
    ///
    /// # Panics
    /// If no outcome has that name.
    pub fn count(&self, outcome: &str) -> u64 {
        let index = Outcome::NAMES.iter().position(|&name| name == outcome);
        self.outcomes[index.unwrap_or_else(|| panic!("no outcome is called `{outcome}`"))]
    }
}

/// The rows of one stack at one sweep point so far.
#[derive(Debug)]
struct Group {
    row: SummaryRow,
    spl_sum: f64,
    is_spl_defined: bool,
    /// Values of each metric over the successes, in the order of the rows: exact quantiles need them all.
    values: Vec<Vec<f64>>,
}

impl Group {
    /// A group without rows, for the stack and point of `row`.
    fn new(row: &Row, keys: &[String], episodes: usize) -> Self {
        let metrics = metric_columns().count();
        Self {
            row: SummaryRow {
                scenario: row.scenario.clone(),
                point: row.point,
                stack: row.stack.clone(),
                n: 0,
                rated: 0,
                outcomes: [0; Outcome::NAMES.len()],
                collision_at_rest: 0,
                success: None,
                spl: None,
                metrics: Vec::new(),
                swept: keys.iter().cloned().zip(row.swept.iter().cloned()).collect(),
            },
            spl_sum: 0.0,
            is_spl_defined: true,
            // Lists that grow leave holes behind; room that is never filled takes no memory.
            values: (0..metrics).map(|_| Vec::with_capacity(episodes)).collect(),
        }
    }

    fn add(&mut self, row: &Row) {
        self.row.n += 1;
        self.row.outcomes[row.outcome.index()] += 1;
        self.row.collision_at_rest += u64::from(row.outcome.parts().at_rest == Some(&true));
        if row.outcome.is_rated() {
            self.row.rated += 1;
            match row.metrics.spl {
                Some(spl) => self.spl_sum += spl,
                // What has failed counts 0 whether it was written or not.
                None => self.is_spl_defined &= !row.outcome.is_success(),
            }
        }
        if row.outcome.is_success() {
            for (values, column) in self.values.iter_mut().zip(metric_columns()) {
                values.extend(column.number(&row.metrics));
            }
        }
    }

    fn finish(mut self) -> SummaryRow {
        let (rated, successes) = (self.row.rated, self.row.count("success"));
        self.row.success =
            wilson(successes, rated, Z_95).map(|(low, high)| Rate { rate: successes as f64 / rated as f64, low, high });
        self.row.spl = (rated > 0 && self.is_spl_defined).then(|| self.spl_sum / rated as f64);
        self.row.metrics = self.values.iter_mut().map(|values| Statistics::of(values)).collect();
        self.row
    }
}

/// Summarises an `episodes.csv`: one row per (sweep point, stack) in the order of their first rows.
///
/// A pure function of the bytes. It holds the values of one sweep point at a time, and makes room for `episodes` rows of each
/// stack at once; more are taken as well.
///
/// # Errors
/// If a line is not what a run writes, or the sweep points are out of order.
pub fn summarise(input: impl BufRead, episodes: usize) -> Result<Vec<SummaryRow>, ReadError> {
    let mut reader = Reader::new(input)?;
    let keys = reader.swept().to_vec();
    let mut summary = Vec::new();
    let mut groups: Vec<Group> = Vec::new();
    let mut point = 0;
    while let Some(row) = reader.next() {
        let row = row?;
        if row.point < point {
            return Err(reader.error(format!("sweep point {} after {point}", row.point)));
        }
        if row.point > point {
            point = row.point;
            summary.extend(groups.drain(..).map(Group::finish));
        }
        let index = groups.iter().position(|group| group.row.stack == row.stack);
        let index = index.unwrap_or_else(|| {
            groups.push(Group::new(&row, &keys, episodes));
            groups.len() - 1
        });
        groups[index].add(&row);
    }
    summary.extend(groups.into_iter().map(Group::finish));
    Ok(summary)
}

/// Summarises rows of one stack at one sweep point; `None` without a row.
pub fn summarise_rows<'a>(rows: impl ExactSizeIterator<Item = &'a Row>) -> Option<SummaryRow> {
    let (count, mut rows) = (rows.len(), rows.peekable());
    let mut group = Group::new(rows.peek()?, &[], count);
    rows.for_each(|row| group.add(row));
    Some(group.finish())
}

/// The names of the columns of `summary.csv` for a sweep over `keys`.
fn summary_header(keys: &[String]) -> Vec<String> {
    let mut header: Vec<String> =
        ["scenario", "point", "stack", "n"].iter().chain(&Outcome::NAMES).map(|&s| s.to_owned()).collect();
    header.extend(["collision_at_rest", "success_rate", "success_low", "success_high", "spl"].map(str::to_owned));
    for column in metric_columns() {
        header
            .extend(["n", "mean", "sd", "median", "q1", "q3"].map(|statistic| format!("{statistic}_{}", column.name)));
    }
    header.extend_from_slice(keys);
    header
}

/// The values of those columns.
fn summary_fields(row: &SummaryRow) -> Vec<Field> {
    let mut fields = vec![Field::from(&row.scenario), row.point.into(), (&row.stack).into(), row.n.into()];
    fields.extend(row.outcomes.map(Field::from));
    fields.push(row.collision_at_rest.into());
    let rate = row.success;
    fields.extend([rate.map(|r| r.rate), rate.map(|r| r.low), rate.map(|r| r.high), row.spl].map(Field::from));
    for statistics in &row.metrics {
        fields.push(statistics.n.into());
        fields.extend(statistics.fields().map(Field::from));
    }
    fields.extend(row.swept.iter().map(|(_, value)| Field::Setting(value.clone())));
    fields
}

/// Writes `summary.csv`.
///
/// Columns: scenario, point, stack, n, the count of each outcome, `collision_at_rest`, `success_rate` with
/// `success_low` and `success_high` (Wilson 95 %), `spl`; then for each metric column of `episodes.csv`
/// `n_`, `mean_`, `sd_`, `median_`, `q1_` and `q3_` followed by its name, over the successes; then the swept keys.
///
/// # Errors
/// If the writer fails.
pub fn write_summary<W: io::Write>(output: W, keys: &[String], summary: &[SummaryRow]) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(output);
    writer.write_record(summary_header(keys))?;
    for row in summary {
        writer.write_record(summary_fields(row).iter().map(Field::csv))?;
    }
    writer.flush()
}

/// A row of `summary.csv` as an object of JSON: its columns as keys, numbers as numbers, what is undefined as `null`.
pub fn summary_json(row: &SummaryRow) -> Map<String, Json> {
    let keys: Vec<String> = row.swept.iter().map(|(key, _)| key.clone()).collect();
    json_object(summary_header(&keys).iter().map(String::as_str), &summary_fields(row))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Metrics;
    use crate::results::csv_rows::{header_line, write_row};
    use crate::world::ObstacleKind;

    fn row(point: u32, stack: &str, outcome: Outcome, time_s: Option<f64>, spl: Option<f64>) -> Row {
        Row {
            scenario: "s".to_owned(),
            point,
            stack: stack.to_owned(),
            global: String::new(),
            path: String::new(),
            local: "dwa".to_owned(),
            episode: 0,
            seed: 0,
            outcome,
            metrics: Metrics { time_s, spl, ..Metrics::default() },
            world_digest: None,
            trace_digest: None,
            swept: vec![point.to_string()],
        }
    }

    fn summary(rows: &[Row]) -> Vec<SummaryRow> {
        let mut bytes = header_line(&["key".to_owned()]);
        let mut writer = csv::Writer::from_writer(&mut bytes);
        rows.iter().for_each(|row| write_row(&mut writer, row).unwrap());
        drop(writer);
        summarise(bytes.as_slice(), 2).unwrap()
    }

    #[test]
    fn a_summary_worked_by_hand() {
        let hit = |at_rest| Outcome::Collision { with: ObstacleKind::Dynamic, at_rest };
        let infeasible = Outcome::InfeasibleWorld { message: "no room".to_owned() };
        let rows = [
            row(0, "b", Outcome::Success, Some(4.0), Some(0.5)),
            row(0, "a", Outcome::Timeout, Some(99.0), Some(0.0)),
            row(0, "b", Outcome::Success, Some(8.0), Some(1.0)),
            row(0, "b", hit(true), Some(50.0), Some(0.0)),
            row(0, "b", hit(false), Some(50.0), Some(0.0)),
            row(0, "b", Outcome::Success, Some(1.0), Some(0.75)),
            row(0, "b", Outcome::Success, Some(2.0), Some(0.25)),
            row(0, "b", infeasible.clone(), None, None),
            row(1, "b", infeasible, None, None),
        ];
        let summary = summary(&rows);
        // Order of first rows: b before a.
        assert_eq!(
            summary.iter().map(|r| (r.point, r.stack.as_str())).collect::<Vec<_>>(),
            [(0, "b"), (0, "a"), (1, "b")]
        );
        let b = &summary[0];
        assert_eq!((b.n, b.outcomes, b.collision_at_rest), (7, [4, 2, 0, 0, 0, 0, 0, 0, 1], 1));
        assert_eq!(b.swept, [("key".to_owned(), "0".to_owned())]);
        // 4 of the 6 feasible worlds: z² = 3.841459, centre 5.920729, half 1.959964 √(8/6 + 0.960365) = 2.968358.
        let rate = b.success.unwrap();
        assert_eq!(rate.rate, 4.0 / 6.0);
        assert!((rate.low - (5.920_729 - 2.968_358) / 9.841_459).abs() < 1e-6, "{}", rate.low);
        assert!((rate.high - (5.920_729 + 2.968_358) / 9.841_459).abs() < 1e-6, "{}", rate.high);
        // (0.5 + 1 + 0.75 + 0.25) / 6 feasible.
        assert_eq!(b.spl, Some(2.5 / 6.0));
        // Times 1, 2, 4, 8: mean 15/4; squares 7.5625 + 3.0625 + 0.0625 + 18.0625 = 28.75, by 3.
        let expected = Statistics {
            n: 4,
            mean: Some(3.75),
            sd: Some((28.75f64 / 3.0).sqrt()),
            median: Some(3.0),
            q1: Some(1.75),
            q3: Some(5.0),
        };
        assert_eq!(*b.metric("time_s"), expected);
        assert_eq!(*b.metric("length_m"), Statistics::default());
        // No success: a rate of 0 and nothing else to say.
        assert_eq!((summary[1].success.unwrap().rate, summary[1].metric("time_s").n), (0.0, 0));
        // No feasible world: no rate at all.
        assert_eq!((summary[2].success, summary[2].spl), (None, None));
    }

    #[test]
    fn spl_over_all_is_undefined_where_one_success_has_none() {
        let rows = [row(0, "a", Outcome::Success, None, None), row(0, "a", Outcome::Success, None, Some(1.0))];
        assert_eq!(summary(&rows)[0].spl, None);
    }

    #[test]
    fn sweep_points_out_of_order_are_refused() {
        let mut bytes = header_line(&["key".to_owned()]);
        let mut writer = csv::Writer::from_writer(&mut bytes);
        [1, 0].iter().for_each(|&p| write_row(&mut writer, &row(p, "a", Outcome::Stuck, None, None)).unwrap());
        drop(writer);
        assert_eq!(summarise(bytes.as_slice(), 2).unwrap_err().to_string(), "line 3: sweep point 0 after 1");
    }

    #[test]
    fn every_line_of_the_file_has_a_field_for_every_name() {
        let rows = [row(0, "a,b", Outcome::Success, Some(1.5), None), row(1, "a,b", Outcome::Stuck, None, None)];
        let mut bytes = Vec::new();
        write_summary(&mut bytes, &["key".to_owned()], &summary(&rows)).unwrap();
        let mut reader = csv::Reader::from_reader(bytes.as_slice());
        let names = reader.headers().unwrap().clone();
        let records: Vec<_> = reader.records().map(Result::unwrap).collect();
        let field = |record: usize, name: &str| &records[record][names.iter().position(|n| n == name).unwrap()];
        assert_eq!(records.len(), 2);
        assert_eq!(names.iter().next_back(), Some("key"));
        assert_eq!((field(0, "stack"), field(0, "success"), field(0, "success_rate")), ("a,b", "1", "1"));
        assert_eq!((field(0, "mean_time_s"), field(0, "sd_time_s"), field(0, "n_time_s")), ("1.5", "", "1"));
        assert_eq!((field(1, "stuck"), field(1, "success_low"), field(1, "median_ticks")), ("1", "0", ""));
        let object = summary_json(&summary(&rows)[0]);
        assert!(object.keys().map(String::as_str).eq(names.iter()));
        assert_eq!(
            (&object["mean_time_s"], &object["sd_time_s"], &object["n_time_s"]),
            (&1.5.into(), &Json::Null, &1.into())
        );
    }
}
