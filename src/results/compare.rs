//! First difference of two result files.

use super::ResultsError;
use super::csv_rows::split;
use crate::files;
use std::fmt;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// The first difference between two CSV files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Number of the line, from 1; the header is line 1.
    pub line: u64,
    /// Name of the column; empty if the lines differ as a whole (one is missing, cut short or not CSV).
    pub column: String,
    /// The left value.
    pub left: String,
    /// The right value.
    pub right: String,
    /// Identification of the row: point, stack and episode, as far as the file has them.
    pub row: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line, column, left, right, row } = self;
        write!(f, "line {line}")?;
        if !row.is_empty() {
            write!(f, " ({row})")?;
        }
        if !column.is_empty() {
            write!(f, ", column `{column}`")?;
        }
        write!(f, ": `{left}` on the left, `{right}` on the right")
    }
}

/// Text in place of a line that is missing.
const END: &str = "end of file";

/// Compares two CSV files byte by byte; `None` if they are equal, else the first differing line and its first
/// differing column.
///
/// # Errors
/// If a file cannot be read.
pub fn compare(left: &Path, right: &Path) -> Result<Option<Difference>, ResultsError> {
    let open = |path| files::open(path, u64::MAX).map(BufReader::new).map_err(ResultsError::io("read", path));
    let (mut left_file, mut right_file) = (open(left)?, open(right)?);
    let (mut left_line, mut right_line, mut header) = (Vec::new(), Vec::new(), Vec::new());
    for line in 1.. {
        left_line.clear();
        right_line.clear();
        left_file.read_until(b'\n', &mut left_line).map_err(ResultsError::io("read", left))?;
        right_file.read_until(b'\n', &mut right_line).map_err(ResultsError::io("read", right))?;
        if left_line != right_line {
            return Ok(Some(difference(line, &header, &left_line, &right_line)));
        }
        if left_line.is_empty() {
            return Ok(None);
        }
        if line == 1 {
            header.clone_from(&left_line);
        }
    }
    unreachable!("files end")
}

fn difference(line: u64, header: &[u8], left: &[u8], right: &[u8]) -> Difference {
    let whole = |line: &[u8]| if line.is_empty() { END.to_owned() } else { String::from_utf8_lossy(line).into_owned() };
    let mut found =
        Difference { line, column: String::new(), left: whole(left), right: whole(right), row: String::new() };
    let fields = |line: &[u8]| line.strip_suffix(b"\n").and_then(|line| split(line).ok());
    let (Some(left), Some(right)) = (fields(left), fields(right)) else {
        return found;
    };
    let names = fields(header).unwrap_or_else(|| left.clone());
    let differs = |index: &usize| left.get(*index) != right.get(*index);
    if let Some(index) = (0..left.len().max(right.len())).find(differs) {
        let value = |record: &csv::StringRecord| record.get(index).unwrap_or("end of line").to_owned();
        found.column = names.get(index).unwrap_or_default().to_owned();
        (found.left, found.right) = (value(&left), value(&right));
    }
    let known = ["point", "stack", "episode"].iter().filter_map(|&key| {
        let index = names.iter().position(|name| name == key)?;
        (line > 1).then(|| format!("{key} {}", left.get(index).unwrap_or_default()))
    });
    found.row = known.collect::<Vec<_>>().join(", ");
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compared(left: &str, right: &str) -> Option<String> {
        let directory = tempfile::tempdir().unwrap();
        let paths = ["left", "right"].map(|name| directory.path().join(name));
        std::fs::write(&paths[0], left).unwrap();
        std::fs::write(&paths[1], right).unwrap();
        compare(&paths[0], &paths[1]).unwrap().map(|difference| difference.to_string())
    }

    #[test]
    fn the_first_differing_row_and_column_is_named_with_both_values() {
        let base = "point,stack,episode,time_s\n0,a,0,1.5\n0,b,0,2.5\n";
        assert_eq!(compared(base, base), None);
        let found = |right: &str| compared(base, right).unwrap();
        assert_eq!(
            found("point,stack,episode,time_s\n0,a,0,1.5\n0,b,0,2.25\n"),
            "line 3 (point 0, stack b, episode 0), column `time_s`: `2.5` on the left, `2.25` on the right"
        );
        assert_eq!(
            found("point,stack,episode,time\n0,a,0,1\n"),
            "line 1, column `time_s`: `time_s` on the left, `time` on the right"
        );
        assert_eq!(
            found("point,stack,episode,time_s\n0,a,0,1.5\n"),
            "line 3: `0,b,0,2.5\n` on the left, `end of file` on the right"
        );
        assert_eq!(
            found("point,stack,episode,time_s\n0,a,0,1.5\n0,b,0,2.5"),
            "line 3: `0,b,0,2.5\n` on the left, `0,b,0,2.5` on the right"
        );
        // Other bytes of the same fields are a difference, too.
        assert!(
            found("point,stack,episode,time_s\n0,a,0,1.5\n0,\"b\",0,2.5\n").contains("`0,\"b\",0,2.5\n` on the right")
        );
        assert_eq!(
            found("point,stack,episode,time_s\n0,a,0\n"),
            "line 2 (point 0, stack a, episode 0), column `time_s`: `1.5` on the left, `end of line` on the right"
        );
    }
}
