//! Queries of a map: starts and goals in the cells of the map's own file, with their optima where these are known.
//!
//! Cells count columns from the left and rows from the *top*, as map files do ([`movingai::flip`] turns them
//! into grid cells); lengths are in cells.

use super::Cell;
use super::formats::movingai;
use crate::files;
use std::path::Path;

/// A start, a goal and the length of the shortest way, if known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// Start, in cells of the file.
    pub start: Cell,
    /// Goal, in cells of the file.
    pub goal: Cell,
    /// Length of the shortest way for 8 neighbours that cuts no corner, in cells.
    pub optimum: Option<f64>,
    /// Largest distance of a correct length from `optimum`, which is printed with few digits, in cells.
    pub tolerance: f64,
    /// Its line in the file, from 1; 0 if it is from no file.
    pub line: usize,
}

/// Largest number of bytes of a file of queries: some millions of them.
const BYTES_MAX: u64 = 1 << 28;

/// Reads a file of queries: a `.scen` of the MovingAI benchmarks, or any other as a table ([`parse_table`]).
///
/// # Errors
/// The first fault, with its line.
pub fn read(file: &Path) -> Result<Vec<Query>, String> {
    let text = files::text(file, BYTES_MAX).map_err(|error| format!("cannot read `{}`: {error}", file.display()))?;
    let is_scen = file.extension().is_some_and(|extension| extension == "scen");
    let queries = if is_scen { parse_scen(&text) } else { parse_table(&text) };
    queries.map_err(|message| format!("{}: {message}", file.display()))
}

/// Reads a `.scen`.
///
/// # Errors
/// The first fault, with its line.
pub fn parse_scen(text: &str) -> Result<Vec<Query>, String> {
    let queries = movingai::parse_queries(text).map_err(|error| error.to_string())?;
    let lines = text.lines().enumerate().skip(1).filter(|(_, line)| !line.trim().is_empty());
    let read = queries.iter().zip(lines).map(|(query, (index, line))| {
        let printed = line.split('\t').next_back().unwrap_or_default();
        Query {
            start: query.start,
            goal: query.goal,
            optimum: Some(query.optimal_length),
            tolerance: tolerance(printed, query.optimal_length),
            line: index + 1,
        }
    });
    Ok(read.collect())
}

/// Reads a table of queries, columns separated by tabs or commas. The first line names the columns `start_col`, `start_row`,
/// `goal_col`, `goal_row` and, if the optimum is known, `length_cells`.
///
/// # Errors
/// The first fault, with its line.
pub fn parse_table(text: &str) -> Result<Vec<Query>, String> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let (_, header) = lines.next().ok_or("the file is empty")?;
    let separator = if header.contains('\t') { '\t' } else { ',' };
    let names: Vec<&str> = header.split(separator).map(str::trim).collect();
    let find = |name: &str| names.iter().position(|found| *found == name);
    let column = |name: &str| {
        find(name).ok_or_else(|| format!("line 1: expected a column `{name}`, found `{}`", names.join("`, `")))
    };
    let cells = [column("start_col")?, column("start_row")?, column("goal_col")?, column("goal_row")?];
    let length = find("length_cells");
    lines
        .map(|(index, line)| {
            let fields: Vec<&str> = line.split(separator).map(str::trim).collect();
            let field = |column: usize| fields.get(column).copied().unwrap_or_default();
            let whole = |column: usize| {
                field(column).parse::<i32>().map_err(|_| {
                    format!(
                        "line {}, `{}`: expected a whole number, found `{}`",
                        index + 1,
                        names[column],
                        field(column)
                    )
                })
            };
            let [start_col, start_row, goal_col, goal_row] = cells.map(whole);
            let printed = length.map(field).filter(|text| !text.is_empty());
            let optimum = printed.map(|text| {
                let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
                number.ok_or_else(|| format!("line {}, `length_cells`: expected a number, found `{text}`", index + 1))
            });
            let optimum = optimum.transpose()?;
            Ok(Query {
                start: Cell { col: start_col?, row: start_row? },
                goal: Cell { col: goal_col?, row: goal_row? },
                optimum,
                tolerance: optimum.zip(printed).map_or(0.0, |(length, printed)| tolerance(printed, length)),
                line: index + 1,
            })
        })
        .collect()
}

/// Largest distance of a correct length from a printed one, in cells.
///
/// Eight decimals are sums with √2 = 1.414213562, which is 3.8e-10 short per diagonal step, rounded once; fewer come from six significant
/// digits of sums in single precision.
fn tolerance(printed: &str, length: f64) -> f64 {
    let decimals = printed.trim().split('.').nth(1).map_or(0, str::len);
    if decimals >= 8 {
        return 0.51e-8 + 3.8e-10 * length / core::f64::consts::SQRT_2;
    }
    let digits = length.trunc().to_string().len();
    (digits..6).fold(0.6, |unit, _| unit / 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_by_their_columns() {
        let text = "start_col\tstart_row\tgoal_col\tgoal_row\tlength_cells\n468\t114\t341\t136\t136.11269837\n\n1\t2\t3\t4\t2.82842712\n";
        let queries = parse_table(text).unwrap();
        assert_eq!((queries.len(), queries[1].line), (2, 4));
        assert_eq!((queries[0].start, queries[0].goal), (Cell { col: 468, row: 114 }, Cell { col: 341, row: 136 }));
        assert_eq!(queries[0].optimum, Some(136.112_698_37));
        assert!((queries[0].tolerance - (0.51e-8 + 3.8e-10 * 96.246_2)).abs() < 1e-12);
        let commas = parse_table("goal_row,goal_col,start_row,start_col\n4,3,2,1\n").unwrap();
        assert_eq!(commas[0], Query { optimum: None, tolerance: 0.0, line: 2, ..queries[1] });
    }

    #[test]
    fn few_digits_are_compared_as_few_digits() {
        assert!((tolerance("29.3848", 29.3848) - 0.6e-4).abs() < 1e-12);
        assert!((tolerance("1207.43", 1207.43) - 0.6e-2).abs() < 1e-12);
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        for (text, expected) in [
            ("", "the file is empty"),
            ("start_col,start_row,goal_col\n", "line 1: expected a column `goal_row`"),
            (
                "start_col,start_row,goal_col,goal_row\n1,2,3,x\n",
                "line 2, `goal_row`: expected a whole number, found `x`",
            ),
            (
                "start_col,start_row,goal_col,goal_row,length_cells\n1,2,3,4,far\n",
                "line 2, `length_cells`: expected a number",
            ),
        ] {
            let error = parse_table(text).unwrap_err();
            assert!(error.starts_with(expected), "{error}");
        }
    }
}
