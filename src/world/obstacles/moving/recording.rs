//! Recordings of movers: CSV files with one row per mover and moment.

use crate::files;
use crate::geometry::Vec2;
use crate::settings::{COORDINATE_M_MAX, shown};
use crate::world::motion::Sample;
use std::collections::BTreeMap;
use std::path::Path;

/// The tracks of a recording, by id. Times in seconds since it began, positions in the world frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    tracks: BTreeMap<u64, Vec<Sample>>,
}

/// Largest number of bytes of a recording: days of a busy square.
const BYTES_MAX: u64 = 1 << 28;

/// Latest moment, s: clocks that count from 1970 are below it.
const TIME_S_MAX: f64 = 1e10;
/// Fastest that anything in a recording may move, m/s: identities that jump across a square within a frame are below it.
const SPEED_MPS_MAX: f64 = 1e5;

/// The columns that a recording needs, with all the names by which each may go.
const TIME: &[&str] = &["time_s", "time", "t", "frame"];
const ID: &[&str] = &["id", "ped_id", "track_id"];
const X: &[&str] = &["x_m", "x"];
const Y: &[&str] = &["y_m", "y"];

impl Recording {
    /// Reads a recording; `frame_rate_hz` makes times of a column called `frame`.
    ///
    /// # Errors
    /// The first thing wrong with the file: line, column, what was found, what was expected.
    pub fn read(file: &Path, frame_rate_hz: f64) -> Result<Self, String> {
        let text =
            files::text(file, BYTES_MAX).map_err(|error| format!("cannot read `{}`: {error}", file.display()))?;
        Self::parse(text.as_bytes(), frame_rate_hz).map_err(|message| format!("{}: {message}", file.display()))
    }

    /// Reads a recording from the bytes of its file.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(bytes: &[u8], frame_rate_hz: f64) -> Result<Self, String> {
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
        let header = reader.headers().map_err(|error| error.to_string())?.clone();
        let column = |names: &[&str]| {
            let found = header.iter().position(|name| names.contains(&name));
            found.ok_or_else(|| {
                let (names, header) = (names.join("`, `"), header.iter().collect::<Vec<_>>().join("`, `"));
                format!("line 1: expected a column `{names}`, found `{header}`")
            })
        };
        let (time, id, x, y) = (column(TIME)?, column(ID)?, column(X)?, column(Y)?);
        let scale = if &header[time] == "frame" { 1.0 / frame_rate_hz } else { 1.0 };
        let mut tracks: BTreeMap<u64, Vec<Sample>> = BTreeMap::new();
        for record in reader.records() {
            let record = record.map_err(|error| error.to_string())?;
            let line = record.position().map_or(0, csv::Position::line);
            let field = |column: usize| record.get(column).unwrap_or_default();
            let number = |column: usize| {
                let found = field(column);
                let value = found.parse::<f64>().ok().filter(|value| value.is_finite());
                let place = || format!("line {line}, column `{}`", &header[column]);
                let value = value.ok_or_else(|| format!("{}: expected a number, found `{found}`", place()))?;
                let (most, unit) = if column == time { (TIME_S_MAX, "s") } else { (COORDINATE_M_MAX, "m") };
                if value.abs() > most {
                    return Err(format!("{}: expected at most {most} {unit}, found `{found}`", place()));
                }
                Ok(value)
            };
            let who = field(id).parse::<u64>().map_err(|_| {
                format!("line {line}, column `{}`: expected a whole number, found `{}`", &header[id], field(id))
            })?;
            let sample = Sample { time_s: number(time)? * scale, position: Vec2::new(number(x)?, number(y)?) };
            tracks.entry(who).or_default().push(sample);
        }
        if tracks.is_empty() {
            return Err("the recording is empty".to_owned());
        }
        for (who, track) in &mut tracks {
            track.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
            if let Some(twice) = track.windows(2).find(|pair| pair[0].time_s == pair[1].time_s) {
                return Err(format!("id {who} is in two places at {} s", twice[0].time_s));
            }
            let speed_mps =
                |pair: &[Sample]| (pair[1].position - pair[0].position).norm() / (pair[1].time_s - pair[0].time_s);
            if let Some(leap) = track.windows(2).find(|pair| speed_mps(pair) > SPEED_MPS_MAX) {
                return Err(format!(
                    "id {who} moves at {} m/s at {} s, expected at most {SPEED_MPS_MAX} m/s",
                    shown(speed_mps(leap)),
                    leap[0].time_s
                ));
            }
        }
        Ok(Self { tracks })
    }

    /// The track of each id, ascending.
    pub fn tracks(&self) -> impl Iterator<Item = (u64, &[Sample])> {
        self.tracks.iter().map(|(&id, samples)| (id, samples.as_slice()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_become_seconds_and_tracks_are_in_order() {
        let csv = b"frame,ped_id,x_m,y_m\n20,7,2,0\n10,7,1,0.5\n10,3,-4,4\n";
        let recording = Recording::parse(csv, 25.0).unwrap();
        let at = |time_s: f64, x: f64, y: f64| Sample { time_s, position: Vec2::new(x, y) };
        let tracks: Vec<_> = recording.tracks().map(|(id, track)| (id, track.to_vec())).collect();
        assert_eq!(tracks, [(3, vec![at(0.4, -4.0, 4.0)]), (7, vec![at(0.4, 1.0, 0.5), at(0.8, 2.0, 0.0)])]);
        let seconds = Recording::parse(b"x, y, time, id\n1, 2, 0.4, 3\n", 25.0).unwrap();
        assert_eq!(seconds.tracks().next(), Some((3, &[at(0.4, 1.0, 2.0)][..])));
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place() {
        for (csv, expected) in [
            ("time,x,y\n", "line 1: expected a column `id`, `ped_id`, `track_id`, found `time`, `x`, `y`"),
            ("time,id,x,y\n0,1,2,3\n0.1,1,two,3\n", "line 3, column `x`: expected a number, found `two`"),
            ("time,id,x,y\n0,a,2,3\n", "line 2, column `id`: expected a whole number, found `a`"),
            ("time,id,x,y\n0,1,2,inf\n", "line 2, column `y`: expected a number, found `inf`"),
            ("time,id,x,y\n0,1,2,3\n0,1,4,3\n", "id 1 is in two places at 0 s"),
            ("time,id,x,y\n", "the recording is empty"),
            ("time,id,x,y\n0,1,1e300,3\n", "line 2, column `x`: expected at most 100000000 m, found `1e300`"),
            ("time,id,x,y\n1e30,1,1,3\n", "line 2, column `time`: expected at most 10000000000 s, found `1e30`"),
            (
                "time,id,x,y\n0,1,0,3\n0.04,1,9e7,3\n",
                "id 1 moves at 2250000000 m/s at 0 s, expected at most 100000 m/s",
            ),
        ] {
            assert_eq!(Recording::parse(csv.as_bytes(), 25.0).unwrap_err(), expected);
        }
        let short = Recording::parse(b"time,id,x,y\n0,1,2\n", 25.0).unwrap_err();
        assert!(short.contains("line: 2"), "{short}");
    }
}
