//! Rows to and from the lines of `episodes.csv`.

use super::columns::{Access, COLUMNS, Column, header};
use super::field::{Field, json_object};
use super::row::Row;
use super::value::one_line;
use super::{ReadError, ResultsError};
use crate::episode::{Outcome, Parts};
use crate::files::{self, LineFeeds};
use crate::world::ObstacleKind;
use serde_json::{Map, Value as Json};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// Longest line that is read, bytes; those that a run writes stay below 64 KiB.
const LINE_BYTES_MAX: u64 = 1 << 20;

/// Characters of a message that reach the file: some hundred of what was said, and the command that drives the episode again.
const MESSAGE_CHARS_MAX: usize = 2000;

/// Appends one row to a CSV writer.
///
/// The row is one line: in texts every control character becomes a space, and messages are cut
/// after 2000 characters. Undefined values are empty, floats have the fewest digits that read back
/// as the same number, −0 is 0.
///
/// # Errors
/// If the writer fails.
///
/// # Panics
/// If a float is not finite.
pub fn write_row<W: io::Write>(writer: &mut csv::Writer<W>, row: &Row) -> io::Result<()> {
    let mut text = String::new();
    for column in &COLUMNS {
        text.clear();
        match column.access {
            Access::Field { get, .. } => get(row).write(&mut text),
            Access::Ending(part) => text.push_str(&part(&row.outcome)),
            Access::Metric { get, .. } => get(&row.metrics).write(&mut text),
        }
        writer.write_field(&text)?;
    }
    for value in &row.swept {
        writer.write_field(one_line(value).as_bytes())?;
    }
    Ok(writer.write_record(None::<&[u8]>)?)
}

/// A row as an object of JSON: the columns of `episodes.csv` as keys, then the `swept` keys. Numbers are numbers (`success` and `at_rest`
/// 0 or 1, as in the table), what is undefined is `null`, digests are texts.
pub fn row_json(row: &Row, swept: &[String]) -> Map<String, Json> {
    let columns = COLUMNS.iter().map(|column| column.field(row));
    let fields: Vec<Field> = columns.chain(row.swept.iter().cloned().map(Field::Setting)).collect();
    json_object(header(swept), &fields)
}

/// Places of the columns in a table of this version, or of an older one that lacks some.
#[derive(Debug)]
struct Layout {
    /// Place of each column; `None` if the table is older than the column.
    places: [Option<usize>; COLUMNS.len()],
    /// Place of the first swept key.
    swept_from: usize,
    swept: Vec<String>,
}

impl Layout {
    /// The layout of a header; the error says what is wrong with it.
    fn new(header: &csv::StringRecord) -> Result<Self, String> {
        let mut places = [None; COLUMNS.len()];
        let mut at = 0;
        for (place, column) in places.iter_mut().zip(&COLUMNS) {
            let found = header.get(at).unwrap_or_default();
            if found == column.name {
                *place = Some(at);
                at += 1;
            } else if column.since == 1 {
                return Err(format!("expected the column `{}`, found `{found}`", column.name));
            }
        }
        Ok(Self { places, swept_from: at, swept: header.iter().skip(at).map(str::to_owned).collect() })
    }

    /// The columns with their texts; columns that the table lacks are skipped.
    fn fields<'r>(&self, record: &'r csv::StringRecord) -> impl Iterator<Item = (&'static Column, &'r str)> {
        let placed = COLUMNS.iter().zip(&self.places);
        placed.filter_map(|(column, place)| Some((column, record.get((*place)?)?)))
    }

    /// The row of a record; the message of an error names the column.
    fn read(&self, record: &csv::StringRecord) -> Result<Row, String> {
        let expected = self.swept_from + self.swept.len();
        if record.len() != expected {
            return Err(format!("expected {expected} fields, found {}", record.len()));
        }
        let mut row = Row::blank();
        let mut parts = EndingParts::default();
        for (column, text) in self.fields(record) {
            match column.access {
                Access::Field { get_mut, .. } => get_mut(&mut row).read(text),
                Access::Ending(_) => {
                    parts.take(column.name, text);
                    Ok(())
                }
                Access::Metric { get_mut, .. } => get_mut(&mut row.metrics).read(text),
            }
            .map_err(|expected| format!("`{}`: expected {expected}, found `{text}`", column.name))?;
        }
        row.outcome = parts.outcome()?;
        // The parts must agree with one another: each is what the outcome they make would write.
        for (column, text) in self.fields(record) {
            if let Access::Ending(part) = column.access {
                let expected = part(&row.outcome);
                if expected != text {
                    return Err(format!("`{}`: expected `{expected}`, found `{text}`", column.name));
                }
            }
        }
        row.swept = record.iter().skip(self.swept_from).map(str::to_owned).collect();
        Ok(row)
    }
}

/// The rows of an `episodes.csv`, read one by one.
///
/// Every row is one line that ends in a newline; a file that was cut short is an error at its last line. Tables of every
/// released header can be read: columns that are younger than the table are undefined in every row ([`Reader::missing`]).
#[derive(Debug)]
pub struct Reader<R> {
    lines: Lines<R>,
    layout: Layout,
}

/// The records of a table with their places in the file.
#[derive(Debug)]
struct Lines<R> {
    input: R,
    buffer: Vec<u8>,
    /// Lines read, the header included.
    line: u64,
    /// Bytes of the lines read.
    offset: u64,
}

impl Reader<LineFeeds<BufReader<File>>> {
    /// Opens a table; line ends that another system has turned, and a mark that an editor has put in front, change no row.
    ///
    /// # Errors
    /// If the file cannot be read, or has no header of an `episodes.csv`.
    pub fn open(table: &Path) -> Result<Self, ResultsError> {
        let lines = files::lines(table, u64::MAX).map_err(ResultsError::io("read", table))?;
        Self::new(lines).map_err(|source| ResultsError::Read { path: table.to_owned(), source })
    }
}

impl<R: BufRead> Reader<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// If the header is not that of an `episodes.csv` of this version or an older one.
    pub fn new(input: R) -> Result<Self, ReadError> {
        let mut lines = Lines { input, buffer: Vec::new(), line: 0, offset: 0 };
        let header = lines.record()?.ok_or(ReadError::Empty)?;
        let layout = Layout::new(&header).map_err(|message| lines.error(message))?;
        Ok(Self { lines, layout })
    }

    /// The swept keys, in order.
    pub fn swept(&self) -> &[String] {
        &self.layout.swept
    }

    /// The columns that the table lacks because it is older than they are.
    pub fn missing(&self) -> Vec<&'static str> {
        let placed = COLUMNS.iter().zip(&self.layout.places);
        placed.filter(|(_, place)| place.is_none()).map(|(column, _)| column.name).collect()
    }

    /// Number of the line that was read last, from 1; the header is line 1.
    pub fn line(&self) -> u64 {
        self.lines.line
    }

    /// Bytes of the file up to the end of the line that was read last.
    pub fn offset(&self) -> u64 {
        self.lines.offset
    }

    /// An error at the line that was read last.
    pub(super) fn error(&self, message: String) -> ReadError {
        self.lines.error(message)
    }
}

impl<R: BufRead> Lines<R> {
    fn error(&self, message: String) -> ReadError {
        ReadError::Line { line: self.line, message }
    }

    /// The fields of the next line; `None` at the end.
    fn record(&mut self) -> Result<Option<csv::StringRecord>, ReadError> {
        self.buffer.clear();
        let mut input = Read::by_ref(&mut self.input).take(LINE_BYTES_MAX);
        let bytes = input.read_until(b'\n', &mut self.buffer).map_err(ReadError::Io)?;
        if bytes == 0 {
            return Ok(None);
        }
        self.line += 1;
        self.offset += bytes as u64;
        let Some(line) = self.buffer.strip_suffix(b"\n") else {
            let is_cut = (bytes as u64) < LINE_BYTES_MAX;
            let message =
                if is_cut { "the line is cut short" } else { "the line is longer than 1 MiB: is it a table?" };
            return Err(self.error(message.to_owned()));
        };
        split(line).map(Some).map_err(|message| self.error(message))
    }
}

impl<R: BufRead> Iterator for Reader<R> {
    type Item = Result<Row, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        let record = match self.lines.record() {
            Ok(record) => record?,
            Err(error) => return Some(Err(error)),
        };
        Some(self.layout.read(&record).map_err(|message| self.error(message)))
    }
}

/// The fields of one line without its newline, quoted as in RFC 4180.
///
/// A reader of the csv crate per line would cost 80 µs each, one for the whole file passes over empty lines.
pub(super) fn split(line: &[u8]) -> Result<csv::StringRecord, String> {
    let mut rest = std::str::from_utf8(line).map_err(|error| error.to_string())?;
    let mut record = csv::StringRecord::new();
    let mut unquoted = String::new();
    loop {
        let after = if let Some(mut quoted) = rest.strip_prefix('"') {
            unquoted.clear();
            let after = loop {
                let (text, after) = quoted.split_once('"').ok_or("a quote is not closed")?;
                unquoted.push_str(text);
                // Two quotes stand for one.
                let Some(more) = after.strip_prefix('"') else { break after };
                unquoted.push('"');
                quoted = more;
            };
            record.push_field(&unquoted);
            after
        } else {
            let (field, after) = rest.split_at(rest.find(',').unwrap_or(rest.len()));
            record.push_field(field);
            after
        };
        match after.strip_prefix(',') {
            Some(more) => rest = more,
            None if after.is_empty() => return Ok(record),
            None => return Err("text follows a closing quote".to_owned()),
        }
    }
}

/// The header line of a sweep over `swept`, newline included.
pub fn header_line(swept: &[String]) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(header(swept)).expect("writing to memory cannot fail");
    writer.into_inner().expect("writing to memory cannot fail")
}

/// Texts of the columns of an outcome, one function per column.
pub(super) mod ending {
    use super::{MESSAGE_CHARS_MAX, Outcome, one_line};

    pub(crate) fn outcome(outcome: &Outcome) -> String {
        outcome.name().to_owned()
    }

    pub(crate) fn message(outcome: &Outcome) -> String {
        one_line(outcome.message()).chars().take(MESSAGE_CHARS_MAX).collect()
    }

    pub(crate) fn success(outcome: &Outcome) -> String {
        u8::from(outcome.is_success()).to_string()
    }

    pub(crate) fn collided_with(outcome: &Outcome) -> String {
        outcome.parts().with.map_or_else(String::new, |with| with.name().to_owned())
    }

    pub(crate) fn at_rest(outcome: &Outcome) -> String {
        outcome.parts().at_rest.map_or_else(String::new, |at_rest| u8::from(*at_rest).to_string())
    }
}

/// The texts from which an outcome is put together again.
#[derive(Default)]
struct EndingParts {
    name: String,
    message: String,
    collided_with: String,
    at_rest: bool,
}

impl EndingParts {
    fn take(&mut self, column: &str, text: &str) {
        match column {
            "outcome" => self.name = text.to_owned(),
            "message" => self.message = text.to_owned(),
            "collided_with" => self.collided_with = text.to_owned(),
            "at_rest" => self.at_rest = text == "1",
            // It follows from the outcome and is compared with it afterwards.
            "success" => {}
            other => panic!("the column `{other}` is no part of an outcome"),
        }
    }

    fn outcome(self) -> Result<Outcome, String> {
        let Self { name, message, collided_with, at_rest } = self;
        if !Outcome::NAMES.contains(&name.as_str()) {
            return Err(format!("`outcome`: expected one of {}, found `{name}`", Outcome::NAMES.join(", ")));
        }
        let with = (!collided_with.is_empty()).then(|| obstacle(&collided_with)).transpose()?;
        let parts = Parts { with: with.as_ref(), at_rest: Some(&at_rest), message: Some(&message) };
        Outcome::from_parts(&name, parts).ok_or_else(|| "`collided_with`: expected an obstacle, found ``".to_owned())
    }
}

fn obstacle(name: &str) -> Result<ObstacleKind, String> {
    use ObstacleKind::{Boundary, Dynamic, KnownStatic, UnknownStatic};
    [KnownStatic, UnknownStatic, Dynamic, Boundary]
        .into_iter()
        .find(|kind| kind.name() == name)
        .ok_or_else(|| format!("`collided_with`: expected an obstacle, found `{name}`"))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::digest::Digest;
    use crate::metrics::Metrics;
    use crate::rng::{EpisodeSeed, Purpose, Stream};

    /// A row whose every field is drawn at random, with texts that need quoting.
    pub(crate) fn random_row(stream: &mut Stream, swept: usize) -> Row {
        let texts = ["a_star", "", "with, comma", "with \"quotes\"", "né, \"日本\"", " spaces ", "-", "'"];
        let text = |stream: &mut Stream| texts[stream.index(texts.len())].to_owned();
        let outcome = match stream.index(9) {
            0 => Outcome::Success,
            1 => Outcome::Timeout,
            2 => Outcome::Stuck,
            3 => Outcome::NoPath { message: text(stream) },
            4 => Outcome::PlannerError { message: text(stream) },
            5 => Outcome::InfeasibleWorld { message: text(stream) },
            6 => Outcome::InternalError { message: text(stream) },
            7 => Outcome::GaveUp { message: text(stream) },
            _ => {
                let kinds = [
                    ObstacleKind::KnownStatic,
                    ObstacleKind::UnknownStatic,
                    ObstacleKind::Dynamic,
                    ObstacleKind::Boundary,
                ];
                Outcome::Collision { with: kinds[stream.index(4)], at_rest: stream.index(2) == 1 }
            }
        };
        let mut row = Row {
            scenario: text(stream),
            point: stream.bits() as u32,
            stack: text(stream),
            global: text(stream),
            path: text(stream),
            local: text(stream),
            episode: stream.bits(),
            seed: stream.bits(),
            outcome,
            metrics: Metrics::default(),
            world_digest: (stream.index(2) == 1).then(|| Digest(stream.bits())),
            trace_digest: (stream.index(2) == 1).then(|| Digest(stream.bits() >> stream.index(64))),
            swept: (0..swept).map(|_| text(stream)).collect(),
        };
        // Any finite bits, then the values that go wrong first.
        let real = |stream: &mut Stream| match stream.index(8) {
            0 => None,
            1 => Some(0.1 + 0.2),
            2 => Some(f64::MIN_POSITIVE / 8.0),
            3 => Some(f64::MAX),
            4 => Some(-1.0 / 3.0),
            5 => Some(12.0),
            _ => Some(f64::from_bits(stream.bits())).filter(|x| x.is_finite() && *x != 0.0),
        };
        let metrics = &mut row.metrics;
        for field in [
            &mut metrics.time_s,
            &mut metrics.length_m,
            &mut metrics.spl,
            &mut metrics.clearance_min_m,
            &mut metrics.jerk_rms_mps3,
            &mut metrics.path_deviation_mean_m,
        ] {
            *field = real(stream);
        }
        metrics.planned_turns = (stream.index(2) == 1).then(|| stream.bits() as u32);
        metrics.ticks = (stream.index(2) == 1).then(|| stream.bits() as u32);
        metrics.expanded = (stream.index(2) == 1).then(|| stream.bits());
        row
    }

    fn bytes(rows: &[Row], swept: &[String]) -> Vec<u8> {
        let mut bytes = header_line(swept);
        let mut writer = csv::Writer::from_writer(&mut bytes);
        rows.iter().for_each(|row| write_row(&mut writer, row).unwrap());
        drop(writer);
        bytes
    }

    fn read(bytes: &[u8]) -> Result<Vec<Row>, ReadError> {
        Reader::new(bytes)?.collect()
    }

    #[test]
    fn rows_survive_writing_and_reading() {
        let mut stream = EpisodeSeed { seed: 1, episode: 0 }.stream(Purpose::Planner, 0);
        for swept in [0, 2] {
            let keys: Vec<String> =
                ["robot.radius_m", "world.dynamic[0].count"][..swept].iter().map(|&k| k.into()).collect();
            let rows: Vec<Row> = (0..3000).map(|_| random_row(&mut stream, swept)).collect();
            let bytes = bytes(&rows, &keys);
            assert_eq!(bytes.iter().filter(|&&byte| byte == b'\n').count(), rows.len() + 1);
            assert_eq!(read(&bytes).unwrap(), rows);
        }
    }

    #[test]
    fn lines_are_split_as_the_csv_crate_splits_them() {
        let mut stream = EpisodeSeed { seed: 2, episode: 0 }.stream(Purpose::Planner, 0);
        let pieces = ["", "a", ",", "\"", "\"\"", " ", "é"];
        for _ in 0..3000 {
            let field = |stream: &mut Stream| (0..stream.index(6)).map(|_| pieces[stream.index(7)]).collect::<String>();
            let fields: Vec<String> = (0..2 + stream.index(4)).map(|_| field(&mut stream)).collect();
            let mut writer = csv::Writer::from_writer(Vec::new());
            writer.write_record(&fields).unwrap();
            let line = writer.into_inner().unwrap();
            assert_eq!(split(line.strip_suffix(b"\n").unwrap()).unwrap(), fields, "{line:?}");
        }
    }

    #[test]
    fn a_row_is_written_as_the_contract_says() {
        let row = Row {
            scenario: "warehouse".to_owned(),
            point: 3,
            stack: "a_star+dwa".to_owned(),
            global: "a_star".to_owned(),
            path: String::new(),
            local: "dwa".to_owned(),
            episode: 12,
            seed: 7,
            outcome: Outcome::Collision { with: ObstacleKind::Dynamic, at_rest: true },
            metrics: Metrics {
                time_s: Some(12.0),
                length_m: Some(0.1 + 0.2),
                spl: Some(0.0),
                clearance_min_m: Some(-0.0),
                expanded: Some(421),
                ..Metrics::default()
            },
            world_digest: Some(Digest(0xab)),
            trace_digest: None,
            swept: vec!["[1, 2]".to_owned()],
        };
        let bytes = bytes(&[row], &["goal".to_owned()]);
        let line = std::str::from_utf8(&bytes).unwrap().lines().nth(1).unwrap();
        assert_eq!(
            line,
            "warehouse,3,a_star+dwa,a_star,,dwa,12,7,collision,,0,dynamic,1,12,0.30000000000000004,,0,,,,,,0,,,,,,,,,,421,\
             ,,,,,,,,,,,,,,,,,,,,,,,,00000000000000ab,,\"[1, 2]\""
        );
    }

    #[test]
    fn a_row_in_json_holds_what_its_line_holds() {
        let mut stream = EpisodeSeed { seed: 3, episode: 0 }.stream(Purpose::Planner, 0);
        let swept = ["robot.radius_m".to_owned(), "planner".to_owned()];
        for _ in 0..500 {
            let mut row = random_row(&mut stream, 2);
            row.swept[0] = "0.25".to_owned();
            let bytes = bytes(std::slice::from_ref(&row), &swept);
            let mut table = csv::Reader::from_reader(bytes.as_slice());
            let names = table.headers().unwrap().clone();
            let line = table.records().next().unwrap().unwrap();
            let object = row_json(&row, &swept);
            assert!(object.keys().map(String::as_str).eq(names.iter()));
            for (name, text) in names.iter().zip(&line) {
                let is_number = COLUMNS.iter().any(|column| column.name == name && column.is_metric())
                    || ["point", "episode", "seed", "success", "at_rest", "robot.radius_m"].contains(&name);
                match &object[name] {
                    Json::Null => assert_eq!(text, "", "{name}"),
                    Json::Number(number) => {
                        assert!(is_number, "{name}");
                        // To the last bit, as a reader of either takes it.
                        assert_eq!(number.as_f64(), text.parse().ok(), "{name}");
                    }
                    Json::String(found) => assert!(!is_number && one_line(found) == text, "{name}: {found:?}"),
                    other => panic!("{name}: {other}"),
                }
            }
        }
    }

    #[test]
    fn a_table_of_the_first_header_is_read_with_its_missing_columns_empty() {
        // Written by the version before the columns were added.
        let old = include_bytes!("../../tests/data/episodes_header_1.csv");
        let mut reader = Reader::new(&old[..]).unwrap();
        assert_eq!((reader.missing().len(), reader.missing()[0]), (16, "clearance_movers_min_m"));
        let rows: Vec<Row> = reader.by_ref().map(Result::unwrap).collect();
        let lines: Vec<&str> = std::str::from_utf8(old).unwrap().lines().collect();
        assert_eq!(rows.len(), lines.len() - 1);
        let names: Vec<&str> = lines[0].split(',').collect();
        for (row, line) in rows.iter().zip(&lines[1..]) {
            assert!(row.metrics.contacts.is_none() && row.metrics.ticks.is_some());
            // Written again, each of its columns says the same.
            let again = String::from_utf8(bytes(std::slice::from_ref(row), &[])).unwrap();
            let (header, again) = again.trim_end().split_once('\n').unwrap();
            let again: Vec<(&str, &str)> = header.split(',').zip(again.split(',')).collect();
            let kept: Vec<&str> =
                again.iter().filter(|(name, _)| names.contains(name)).map(|(_, value)| *value).collect();
            assert_eq!(kept.join(","), **line);
        }
        // A column of the first header is not missed.
        let text = String::from_utf8(old.to_vec()).unwrap().replacen(",ticks,", ",", 1);
        let error = Reader::new(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(error, "line 1: expected the column `ticks`, found `world_digest`");
    }

    #[test]
    fn a_message_becomes_one_line_of_bounded_length() {
        let mut row = Row::blank();
        row.outcome = Outcome::PlannerError { message: format!("line one\nline two\r\n\t{}", "x".repeat(3000)) };
        let bytes = bytes(&[row], &[]);
        let back = read(&bytes).unwrap().remove(0);
        assert!(back.outcome.message().starts_with("line one line two   xxx"), "{}", back.outcome.message());
        assert_eq!(back.outcome.message().chars().count(), MESSAGE_CHARS_MAX);
    }

    #[test]
    #[should_panic(expected = "not finite")]
    fn a_not_a_number_is_never_written() {
        let mut row = Row::blank();
        row.metrics.time_s = Some(f64::NAN);
        bytes(&[row], &[]);
    }

    #[test]
    fn what_no_run_writes_is_refused_with_line_and_column() {
        let good = String::from_utf8(bytes(&[Row::blank()], &[])).unwrap();
        for (found, instead, message) in [
            ("timeout,,0", "timeout,,1", "line 2: `success`: expected `0`, found `1`"),
            ("timeout,,0", "success,,0", "line 2: `success`: expected `1`, found `0`"),
            ("timeout,,0", "late,,0", "line 2: `outcome`: expected one of"),
            ("timeout,,0,", "collision,,0,wall", "line 2: `collided_with`: expected an obstacle, found `wall`"),
            ("timeout,,0,", "timeout,,0,dynamic", "line 2: `collided_with`: expected ``, found `dynamic`"),
            ("timeout,,0,,,", "timeout,,0,,,NaN", "line 2: `time_s`: expected a finite number, found `NaN`"),
            ("\n,0,", "\n,-1,", "line 2: `point`: expected a whole number, found `-1`"),
            ("\n,0,", "\n\n,0,", "line 2: expected 59 fields, found 1"),
            ("timeout,,0", "timeout,\"a,0", "line 2: a quote is not closed"),
            ("timeout,,0", "timeout,\"a\"b,0", "line 2: text follows a closing quote"),
            ("time_s", "time", "line 1: expected the column `time_s`, found `time`"),
        ] {
            let bad = good.replacen(found, instead, 1);
            assert_ne!(bad, good);
            let error = read(bad.as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with(message), "{error}");
        }
        let error = read(&good.as_bytes()[..good.len() - 1]).unwrap_err().to_string();
        assert_eq!(error, "line 2: the line is cut short");
    }
}
