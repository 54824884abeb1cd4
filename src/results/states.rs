//! `states.csv`: the time of each stack in each state of its local planner, under the same byte contract as `episodes.csv`.

use super::csv_rows::{Reader, header_line, split, write_row};
use super::row::Row;
use super::timings::Timing;
use super::value::{Value, one_line};
use crate::metrics::StateTime;
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead};

/// Results of one stack in one world.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Its row of `episodes.csv`.
    pub row: Row,
    /// Its rows of `states.csv`; their times add up to the row's `time_s`.
    pub states: Vec<StateTime>,
    /// Its row of `timings.csv`.
    pub timing: Timing,
}

/// An answer on its way to another process.
#[derive(Serialize, Deserialize)]
struct Sent {
    row: Vec<u8>,
    states: Vec<StateTime>,
    timing: Timing,
}

impl Answer {
    /// Writes it to nowhere, so that a fault shows before its turn in the tables comes.
    ///
    /// # Panics
    /// If a number in it is not finite.
    pub fn assert_writable(&self) {
        let [mut episodes, mut states] = [(); 2].map(|()| csv::Writer::from_writer(io::sink()));
        write_row(&mut episodes, &self.row).expect("nowhere takes everything");
        write_states(&mut states, self).expect("nowhere takes everything");
    }

    /// It as bytes, for another process. The row goes as the line that a table has of it: reading that back loses nothing.
    ///
    /// # Panics
    /// If a number in it is not finite.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let mut line = csv::Writer::from_writer(Vec::new());
        write_row(&mut line, &self.row).expect("memory takes everything");
        let row = line.into_inner().expect("memory takes everything");
        let sent = Sent { row, states: self.states.clone(), timing: self.timing };
        postcard::to_stdvec(&sent).expect("plain data is written")
    }

    /// The answer of [`Self::to_bytes`] of a run that sweeps these keys; `None` if the bytes are none.
    pub(crate) fn from_bytes(bytes: &[u8], swept: &[String]) -> Option<Self> {
        let Sent { row, states, timing } = postcard::from_bytes(bytes).ok()?;
        let table = [header_line(swept), row].concat();
        let row = Reader::new(table.as_slice()).ok()?.next()?.ok()?;
        Some(Self { row, states, timing })
    }
}

/// The names of the columns.
pub(super) const HEADER: &str = "point,episode,stack,state,seconds,entries\n";

/// Rounding error allowed between the sum of the times of the states and the time of the episode, s.
const SLACK_S: f64 = 1e-6;

/// Appends the rows of one stack.
pub(super) fn write_states<W: io::Write>(writer: &mut csv::Writer<W>, answer: &Answer) -> io::Result<()> {
    let Answer { row, states, .. } = answer;
    for StateTime { state, seconds, entries } in states {
        let mut time = String::new();
        seconds.write(&mut time);
        let names = [&row.stack, state].map(|name| one_line(name).into_owned());
        let [stack, state] = names;
        writer.write_record([
            row.point.to_string(),
            row.episode.to_string(),
            stack,
            state,
            time,
            entries.to_string(),
        ])?;
    }
    Ok(())
}

/// The lines of a `states.csv`, block by block.
#[derive(Debug)]
pub(super) struct StateLines<R> {
    input: R,
    /// The next line; empty if it has not been read yet.
    next: Vec<u8>,
    /// Bytes of the lines taken.
    offset: u64,
}

impl<R: BufRead> StateLines<R> {
    /// Reads the header; `None` if it differs or is incomplete.
    pub(super) fn new(input: R) -> io::Result<Option<Self>> {
        let mut lines = Self { input, next: Vec::new(), offset: 0 };
        let is_header = lines.peek()?.is_some_and(|line| line == HEADER.as_bytes());
        Ok(is_header.then(|| {
            lines.take();
            lines
        }))
    }

    /// Bytes of the file up to the end of the line that was taken last.
    pub(super) fn offset(&self) -> u64 {
        self.offset
    }

    /// The next line with its newline; `None` at the end, or if the line is incomplete.
    fn peek(&mut self) -> io::Result<Option<&[u8]>> {
        if self.next.is_empty() {
            self.input.read_until(b'\n', &mut self.next)?;
        }
        Ok(Some(self.next.as_slice()).filter(|line| line.ends_with(b"\n")))
    }

    fn take(&mut self) -> Vec<u8> {
        self.offset += self.next.len() as u64;
        std::mem::take(&mut self.next)
    }

    /// Takes the lines of the block (point, episode) and returns whether they are whole: whether the times of every stack's
    /// states add up to the time of its episode. `stacks` are the names and times in the order of the rows.
    pub(super) fn is_whole(&mut self, point: u32, episode: u64, stacks: &[(String, f64)]) -> io::Result<bool> {
        for (stack, time_s) in stacks {
            let mut sum_s = 0.0;
            while let Some(found) = self.peek()?.and_then(StateKey::read)
                && (found.point, found.episode, &found.stack) == (point, episode, stack)
            {
                sum_s += found.seconds;
                self.take();
            }
            if (sum_s - time_s).abs() > SLACK_S {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Takes the lines of the block (point, episode) as they are.
    pub(super) fn block(&mut self, point: u32, episode: u64) -> io::Result<Vec<u8>> {
        let mut lines = Vec::new();
        while self.peek()?.and_then(StateKey::read).is_some_and(|key| (key.point, key.episode) == (point, episode)) {
            lines.extend(self.take());
        }
        Ok(lines)
    }
}

/// The row to which a line belongs, and its time.
struct StateKey {
    point: u32,
    episode: u64,
    stack: String,
    seconds: f64,
}

impl StateKey {
    /// Reads a line; `None` if no run writes such a line.
    fn read(line: &[u8]) -> Option<Self> {
        let fields = split(line.strip_suffix(b"\n")?).ok()?;
        let [point, episode, stack, _, seconds, _] = fields.iter().collect::<Vec<&str>>().try_into().ok()?;
        Some(Self {
            point: point.parse().ok()?,
            episode: episode.parse().ok()?,
            stack: stack.to_owned(),
            seconds: seconds.parse().ok()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answer(episode: u64, stack: &str, states: &[(&str, f64, u32)]) -> Answer {
        let states = states.iter();
        Answer {
            row: Row { stack: stack.to_owned(), episode, ..Row::blank() },
            states: states
                .map(|&(state, seconds, entries)| StateTime { state: state.to_owned(), seconds, entries })
                .collect(),
            timing: Timing::default(),
        }
    }

    fn text(answers: &[Answer]) -> String {
        let mut writer = csv::Writer::from_writer(HEADER.as_bytes().to_vec());
        answers.iter().for_each(|answer| write_states(&mut writer, answer).unwrap());
        String::from_utf8(writer.into_inner().unwrap()).unwrap()
    }

    #[test]
    fn an_answer_reaches_another_process_as_it_is() {
        let seed = crate::rng::EpisodeSeed { seed: 7, episode: 0 };
        let mut stream = seed.stream(crate::rng::Purpose::Planner, 0);
        for _ in 0..300 {
            let mut sent = answer(3, "a,b", &[("track", 0.1 + 0.2, 2)]);
            sent.row = super::super::csv_rows::tests::random_row(&mut stream, 2);
            sent.timing.global_s = 1.0 / 3.0;
            let keys = ["one".to_owned(), "two".to_owned()];
            assert_eq!(Answer::from_bytes(&sent.to_bytes(), &keys).as_ref(), Some(&sent));
        }
        assert_eq!(Answer::from_bytes(b"nonsense", &[]), None);
    }

    #[test]
    fn a_row_is_written_for_each_state() {
        let text = text(&[answer(7, "a,b", &[("track", 1.5, 2), ("recover", 0.1 + 0.2, 1)]), answer(8, "c", &[])]);
        assert_eq!(text, format!("{HEADER}0,7,\"a,b\",track,1.5,2\n0,7,\"a,b\",recover,0.30000000000000004,1\n"));
    }

    #[test]
    fn a_block_is_whole_if_its_times_add_up_wherever_it_is_torn() {
        let answers = [
            answer(0, "a", &[("track", 1.5, 2), ("recover", 0.5, 1)]),
            answer(0, "b", &[]),
            answer(1, "a", &[("track", 2.0, 1)]),
        ];
        let text = text(&answers);
        let second = text.find("0,1,a").unwrap();
        for torn in 0..=text.len() {
            let Some(mut lines) = StateLines::new(&text.as_bytes()[..torn]).unwrap() else {
                assert!(torn < HEADER.len());
                continue;
            };
            let first = [("a".to_owned(), 2.0), ("b".to_owned(), 0.0)];
            let is_whole = lines.is_whole(0, 0, &first).unwrap();
            assert_eq!(is_whole, torn >= second, "{torn}");
            if is_whole {
                assert_eq!(lines.offset(), second as u64);
                assert_eq!(lines.is_whole(0, 1, &[("a".to_owned(), 2.0)]).unwrap(), torn == text.len());
            }
        }
        let mut lines = StateLines::new(text.as_bytes()).unwrap().unwrap();
        assert_eq!(lines.block(0, 0).unwrap(), text.as_bytes()[HEADER.len()..second]);
        assert_eq!(lines.block(0, 1).unwrap(), text.as_bytes()[second..]);
        assert_eq!(lines.block(0, 2).unwrap(), b"");
    }
}
