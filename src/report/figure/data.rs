//! The columns of an `episodes.csv` that a figure shows, read row by row: nothing else of a row is kept.

use crate::episode::Outcome;
use crate::results::{COLUMNS, Column, EPISODES_CSV, Field, Known, Reader, ResultsError};
use crate::settings::choice::NameError;
use std::collections::BTreeMap;
use std::path::Path;

/// Why a table cannot be plotted.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// It cannot be read as an `episodes.csv`.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// No column has that name.
    #[error(transparent)]
    Name(#[from] NameError),
    /// What was asked for cannot be shown.
    #[error("{0}")]
    Nothing(String),
}

/// The rows of a table, column by column.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// Name of the scenario.
    pub scenario: String,
    /// Names of the stacks, in the order of their first rows.
    pub stacks: Vec<String>,
    /// Number of the stack of each row.
    pub stack: Vec<usize>,
    /// Sweep point, seed and episode of each row.
    pub world: Vec<(u32, u64, u64)>,
    /// Whether each row succeeded; `None` where the world was infeasible, which no rate counts.
    pub success: Vec<Option<bool>>,
    /// The columns that were asked for, in that order.
    pub columns: Vec<Values>,
}

/// The values of one column.
#[derive(Clone, Debug, Default)]
pub struct Values {
    /// Name of the column.
    pub name: String,
    /// One value a row: a number, or which of `words`; not a number where it is undefined.
    pub values: Vec<f64>,
    /// The words of a column that is no number, in the order of their first rows; empty for numbers.
    pub words: Vec<String>,
    /// Whether the value depends on how the drive went, so that failed drives are another matter.
    pub of_drive: bool,
}

/// Where a column is in a row.
#[derive(Clone, Copy, Debug)]
enum Place {
    Known(&'static Column),
    Swept(usize),
}

/// The swept keys of a table, in order; of a folder, of the `episodes.csv` in it.
///
/// # Errors
/// If it cannot be read.
pub fn swept_keys(path: &Path) -> Result<Vec<String>, FigureError> {
    Ok(open(path)?.swept().to_vec())
}

fn open(path: &Path) -> Result<Reader<impl std::io::BufRead + use<>>, ResultsError> {
    Reader::open(&if path.is_dir() { path.join(EPISODES_CSV) } else { path.to_owned() })
}

impl Rows {
    /// Reads the named columns of a table; of a folder, of the `episodes.csv` in it.
    ///
    /// # Errors
    /// If it cannot be read, or has no column of such a name; the message names the nearest one.
    pub fn read(path: &Path, columns: &[&str]) -> Result<Self, FigureError> {
        let reader = open(path)?;
        let places = columns.iter().map(|name| place(name, reader.swept())).collect::<Result<Vec<Place>, _>>()?;
        let mut rows = Self::default();
        let mut readings: Vec<Reading> = places.iter().map(|_| Reading::default()).collect();
        for row in reader {
            let row = row.map_err(|source| ResultsError::Read { path: path.to_owned(), source })?;
            if rows.scenario.is_empty() {
                rows.scenario.clone_from(&row.scenario);
            }
            let stack = rows.stacks.iter().position(|name| *name == row.stack).unwrap_or_else(|| {
                rows.stacks.push(row.stack.clone());
                rows.stacks.len() - 1
            });
            rows.stack.push(stack);
            rows.world.push((row.point, row.seed, row.episode));
            rows.success.push(row.outcome.is_rated().then_some(row.outcome == Outcome::Success));
            for (reading, place) in readings.iter_mut().zip(&places) {
                reading.push(match place {
                    Place::Known(column) => column.field(&row),
                    Place::Swept(index) => Field::Setting(row.swept[*index].clone()),
                });
            }
        }
        let named = readings.into_iter().zip(columns.iter().zip(&places));
        rows.columns = named.map(|(reading, (name, place))| reading.finish(name, place)).collect();
        Ok(rows)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.stack.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.stack.is_empty()
    }

    /// The value of a column in a row that counts: of what depends on the drive, successes alone count unless `failures` do as well; of all else,
    /// feasible worlds.
    pub fn value(&self, column: usize, row: usize, failures: bool) -> Option<f64> {
        let success = self.success[row]?;
        let column = &self.columns[column];
        let value = column.values[row];
        (value.is_finite() && (success || failures || !column.of_drive)).then_some(value)
    }
}

fn place(name: &str, swept: &[String]) -> Result<Place, NameError> {
    let known = COLUMNS.iter().find(|column| column.name == name).map(Place::Known);
    let place = known.or_else(|| swept.iter().position(|key| key == name).map(Place::Swept));
    place.ok_or_else(|| {
        let names: Vec<&str> =
            COLUMNS.iter().map(|column| column.name).chain(swept.iter().map(String::as_str)).collect();
        NameError::unknown("column", name, &names)
    })
}

/// A column that is being read: its numbers, or its words as long as not all of them are numbers.
#[derive(Default)]
struct Reading {
    values: Vec<f64>,
    words: Vec<String>,
    /// Number of each word.
    known: BTreeMap<String, usize>,
}

impl Reading {
    fn push(&mut self, field: Field) {
        let value = match field {
            Field::Whole(number) => number as f64,
            Field::Real(number) => number,
            Field::Flag(flag) => f64::from(u8::from(flag)),
            Field::Empty => f64::NAN,
            Field::Text(text) | Field::Setting(text) if text.is_empty() => f64::NAN,
            Field::Text(text) | Field::Setting(text) => {
                let next = self.words.len();
                let number = *self.known.entry(text.clone()).or_insert(next);
                if number == next {
                    self.words.push(text);
                }
                number as f64
            }
        };
        self.values.push(value);
    }

    fn finish(self, name: &str, place: &Place) -> Values {
        let (mut values, mut words) = (self.values, self.words);
        let numbers = words.iter().map(|word| word.parse().ok().filter(|number: &f64| number.is_finite()));
        if let Some(numbers) = numbers.collect::<Option<Vec<f64>>>()
            && !words.is_empty()
        {
            values.iter_mut().filter(|value| value.is_finite()).for_each(|value| *value = numbers[*value as usize]);
            words.clear();
        }
        // `success` is its own rate: a failure is a 0 and not left out.
        let of_drive = matches!(place, Place::Known(column) if column.is_metric() && column.known == Known::After && column.name != "spl");
        Values { name: name.to_owned(), values, words, of_drive }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::Metrics;
    use crate::results::{Row, header_line, write_row};
    use std::path::PathBuf;

    /// A table of stacks `a` and `b` at two points of a sweep: `(stack, point, episode, time, value of the key)`, no time for a time-out.
    pub(crate) fn table(folder: &Path, rows: &[(&str, u32, u64, Option<f64>, &str)]) -> PathBuf {
        let header = header_line(&["robot.radius_m".to_owned()]);
        let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(header);
        for &(stack, point, episode, time_s, value) in rows {
            let row = Row {
                scenario: "made_up".to_owned(),
                stack: stack.to_owned(),
                point,
                episode,
                outcome: if time_s.is_some() { Outcome::Success } else { Outcome::Timeout },
                metrics: Metrics { time_s: time_s.or(Some(99.0)), ..Metrics::default() },
                swept: vec![value.to_owned()],
                ..Row::blank()
            };
            write_row(&mut writer, &row).unwrap();
        }
        let file = folder.join("episodes.csv");
        std::fs::write(&file, writer.into_inner().unwrap()).unwrap();
        file
    }

    #[test]
    fn columns_are_numbers_or_words() {
        let folder = tempfile::tempdir().unwrap();
        table(folder.path(), &[("a", 0, 0, Some(4.0), "0.2"), ("b", 0, 0, None, ""), ("a", 1, 0, Some(6.0), "0.3")]);
        let rows = Rows::read(folder.path(), &["time_s", "robot.radius_m", "outcome", "success"]).unwrap();
        assert_eq!((rows.len(), rows.stacks.join(" ")), (3, "a b".to_owned()));
        assert_eq!(rows.columns[0].values, [4.0, 99.0, 6.0]);
        assert_eq!((rows.columns[1].values[2], rows.columns[1].words.len()), (0.3, 0));
        assert!(rows.columns[1].values[1].is_nan(), "the key does not touch that stack");
        assert_eq!(rows.columns[2].words, ["success", "timeout"]);
        assert_eq!(rows.columns[3].values, [1.0, 0.0, 1.0]);
        // The time of a time-out says nothing about drives that arrive.
        assert_eq!(
            [rows.value(0, 1, false), rows.value(0, 1, true), rows.value(3, 1, false)],
            [None, Some(99.0), Some(0.0)]
        );
    }

    #[test]
    fn an_unknown_column_is_refused_with_the_nearest_one() {
        let folder = tempfile::tempdir().unwrap();
        let file = table(folder.path(), &[("a", 0, 0, Some(4.0), "0.2")]);
        let said = |name: &str| Rows::read(&file, &[name]).unwrap_err().to_string();
        assert!(said("tim_s").contains("did you mean `time_s`?"), "{}", said("tim_s"));
        assert!(said("robot.radius").contains("did you mean `robot.radius_m`?"));
        assert_eq!(swept_keys(&file).unwrap(), ["robot.radius_m"]);
    }
}
