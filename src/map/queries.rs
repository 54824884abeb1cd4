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
    /// Whether the file gives the length 0 between different cells, which published sets do where there is no way; `optimum` is `None`.
    pub says_no_way: bool,
    /// Its line in the file, from 1; 0 if it is from no file.
    pub line: usize,
}

impl Query {
    /// A query of which no more is known.
    pub fn new(start: Cell, goal: Cell) -> Self {
        Self { start, goal, optimum: None, tolerance: 0.0, says_no_way: false, line: 0 }
    }

    /// The same with a published length, which is correct within `tolerance`.
    fn published(self, length: f64, tolerance: f64) -> Self {
        let says_no_way = length == 0.0 && self.start != self.goal;
        Self { optimum: (!says_no_way).then_some(length), tolerance, says_no_way, ..self }
    }
}

/// The map for which a `.scen` says that its queries are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedMap {
    /// Its name in the file.
    pub name: String,
    /// Its columns and rows.
    pub size: [i32; 2],
    /// The first line that says so, from 1.
    pub line: usize,
}

/// Queries of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Queries {
    /// The queries in the order of the file.
    pub list: Vec<Query>,
    /// The different maps for which they are, in the order of the file; none if the file does not say.
    pub maps: Vec<NamedMap>,
}

/// Largest number of bytes of a file of queries: some millions of them.
const BYTES_MAX: u64 = 1 << 28;

/// Reads a file of queries, whatever it is called: a `.scen` of the MovingAI benchmarks if it opens as one, else a table
/// ([`parse_table`]).
///
/// # Errors
/// The file and its first fault, with the line; also if it holds no queries.
pub fn read(file: &Path) -> Result<Queries, String> {
    let is_scen = |text: &str| text.lines().next().is_some_and(movingai::is_version);
    read_as(file, |text| if is_scen(text) { parse_scen(text) } else { parse_table(text) })
}

/// Reads a `.scen` of the MovingAI benchmarks, whatever it is called.
///
/// # Errors
/// As [`read`].
pub fn read_scen(file: &Path) -> Result<Queries, String> {
    read_as(file, parse_scen)
}

fn read_as(file: &Path, parse: impl Fn(&str) -> Result<Queries, String>) -> Result<Queries, String> {
    let text = files::text(file, BYTES_MAX).map_err(|error| format!("cannot read `{}`: {error}", file.display()))?;
    let queries = parse(&text).map_err(|message| format!("{}: {message}", file.display()))?;
    if queries.list.is_empty() {
        return Err(format!("{}: found no queries, expected one a line behind the first line", file.display()));
    }
    Ok(queries)
}

/// Reads a `.scen`.
///
/// # Errors
/// The first fault, with its line.
pub fn parse_scen(text: &str) -> Result<Queries, String> {
    let found = movingai::parse_queries(text).map_err(|error| error.to_string())?;
    let mut maps: Vec<NamedMap> = Vec::new();
    for query in &found {
        if !maps.iter().rev().any(|map| map.name == query.map && map.size == query.size) {
            maps.push(NamedMap { name: query.map.clone(), size: query.size, line: query.line });
        }
    }
    let digits = Digits::of(found.iter().map(|query| &query.printed[..]), true);
    let list = found.iter().map(|query| {
        let tolerance = digits.tolerance(&query.printed, query.optimal_length);
        Query { line: query.line, ..Query::new(query.start, query.goal) }.published(query.optimal_length, tolerance)
    });
    Ok(Queries { list: list.collect(), maps })
}

/// Reads a table of queries, columns separated by tabs or commas. The first line names the columns `start_col`, `start_row`,
/// `goal_col`, `goal_row` and, if the optimum is known, `length_cells`.
///
/// # Errors
/// The first fault, with its line.
pub fn parse_table(text: &str) -> Result<Queries, String> {
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
    let mut found = Vec::new();
    for (index, line) in lines {
        let fields: Vec<&str> = line.split(separator).map(str::trim).collect();
        let field = |column: usize| fields.get(column).copied().unwrap_or_default();
        let wrong = |column: usize, expected: &str| {
            format!("line {}, `{}`: expected {expected}, found `{}`", index + 1, names[column], field(column))
        };
        let whole = |column: usize| field(column).parse::<i32>().map_err(|_| wrong(column, "a whole number"));
        let [start_col, start_row, goal_col, goal_row] = cells.map(whole);
        let (start, goal) = (Cell { col: start_col?, row: start_row? }, Cell { col: goal_col?, row: goal_row? });
        let published = match length.filter(|&column| !field(column).is_empty()) {
            None => None,
            Some(column) => {
                let number = field(column).parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
                Some((field(column), number.ok_or_else(|| wrong(column, "a number of at least 0"))?))
            }
        };
        found.push((Query { line: index + 1, ..Query::new(start, goal) }, published));
    }
    let digits = Digits::of(found.iter().filter_map(|(_, published)| Some(published.as_ref()?.0)), false);
    let list = found.into_iter().map(|(query, published)| match published {
        Some((printed, length)) => query.published(length, digits.tolerance(printed, length)),
        None => query,
    });
    Ok(Queries { list: list.collect(), maps: Vec::new() })
}

/// How a file prints its lengths.
///
/// A length is right to half of its last printed digit. Printers that drop zeros at the end (`%g`) print 7.00000 as 7, as the older
/// sets do: there numbers have as many digits as the longest one. A file drops zeros if it has numbers without a point beside
/// numbers with one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Digits {
    /// Significant digits of the longest number of a file that drops zeros; `None` if the file prints them.
    longest: Option<usize>,
    /// Whether one printer wrote all: then numbers with a point lost their zeros as well. People mix.
    is_of_one_printer: bool,
}

impl Digits {
    fn of<'t>(printed: impl Iterator<Item = &'t str>, is_of_one_printer: bool) -> Self {
        let (mut drops_zeros, mut longest) = (false, None);
        for text in printed {
            let has_point = text.contains('.');
            drops_zeros |= !has_point && text != "0";
            if has_point && !text.contains(['e', 'E']) {
                let significant = text.trim_start_matches(['+', '0', '.']).bytes().filter(u8::is_ascii_digit).count();
                longest = longest.max(Some(significant));
            }
        }
        Self { longest: longest.filter(|_| drops_zeros), is_of_one_printer }
    }

    /// Largest distance of a correct length from a printed one, in cells.
    ///
    /// Eight decimals and more are sums with √2 = 1.414213562, which is 3.8e-10 short per diagonal step, rounded once; fewer come from
    /// sums in single precision, whose error is below a tenth of the last digit.
    fn tolerance(self, printed: &str, length: f64) -> f64 {
        let (mantissa, exponent) = printed.split_once(['e', 'E']).unwrap_or((printed, "0"));
        let fraction = mantissa.split_once('.').map(|(_, fraction)| fraction);
        let shown = fraction.map_or(0, str::len) as i32 - exponent.parse::<i32>().unwrap_or(0);
        let decimals = match self.longest {
            Some(longest) if fraction.is_none() || self.is_of_one_printer => {
                let before_point = length.trunc().to_string().len();
                shown.max(longest as i32 - before_point as i32)
            }
            _ => shown,
        };
        // Read as decimals are, so that it is the nearest number.
        let unit: f64 = format!("1e{}", -decimals).parse().unwrap_or(0.0);
        if decimals >= 8 { 0.51 * unit + 3.8e-10 * length / core::f64::consts::SQRT_2 } else { 0.6 * unit }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_by_their_columns() {
        let text = "start_col\tstart_row\tgoal_col\tgoal_row\tlength_cells\n468\t114\t341\t136\t136.11269837\n\n1\t2\t3\t4\t2.82842712\n";
        let queries = parse_table(text).unwrap();
        assert!(queries.maps.is_empty());
        let queries = queries.list;
        assert_eq!((queries.len(), queries[1].line), (2, 4));
        assert_eq!((queries[0].start, queries[0].goal), (Cell { col: 468, row: 114 }, Cell { col: 341, row: 136 }));
        assert_eq!(queries[0].optimum, Some(136.112_698_37));
        assert!((queries[0].tolerance - (0.51e-8 + 3.8e-10 * 96.246_2)).abs() < 1e-12);
        let commas = parse_table("goal_row,goal_col,start_row,start_col\n4,3,2,1\n").unwrap().list;
        assert_eq!(commas[0], Query { optimum: None, tolerance: 0.0, line: 2, ..queries[1] });
    }

    /// The tolerances of a file with these lengths.
    fn tolerances<const N: usize>(printed: [&str; N], is_of_one_printer: bool) -> [f64; N] {
        let digits = Digits::of(printed.into_iter(), is_of_one_printer);
        printed.map(|text| digits.tolerance(text, text.parse().unwrap()))
    }

    #[test]
    fn few_digits_are_compared_as_few_digits() {
        let near = |found: &[f64], expected: &[f64]| {
            assert!(found.iter().zip(expected).all(|(a, b)| (a / b - 1.0).abs() < 1e-9), "{found:?} {expected:?}");
        };
        for is_of_one_printer in [false, true] {
            near(&tolerances(["1.41", "20.00", "307.99"], is_of_one_printer), &[0.6e-2; 3]);
            near(&tolerances(["7", "8"], is_of_one_printer), &[0.6; 2]);
            near(&tolerances(["2.0", "11.4", "11.414"], is_of_one_printer), &[0.6e-1, 0.6e-1, 0.6e-3]);
            near(&tolerances(["1.5e3", "1e308"], is_of_one_printer), &[0.6e2, 0.6e308]);
            // Six significant digits without zeros at the end; a 0 may stand for no way in any file.
            let of_whole = tolerances(["7", "29.3848", "1207.43", "1.41421", "123456"], is_of_one_printer);
            near(&of_whole, &[0.6e-5, 0.6e-4, 0.6e-2, 0.6e-5, 0.6]);
            near(&tolerances(["0", "1.41", "3.00"], is_of_one_printer)[1..], &[0.6e-2; 2]);
        }
        // 21.2 is 21.2000 to a printer that drops zeros, and to a person what it says.
        near(&tolerances(["7", "21.2", "1.41421"], true), &[0.6e-5, 0.6e-4, 0.6e-5]);
        near(&tolerances(["7", "21.2", "1.41421"], false), &[0.6e-5, 0.6e-1, 0.6e-5]);
    }

    #[test]
    fn the_length_0_between_different_cells_is_no_optimum() {
        let table = "start_col,start_row,goal_col,goal_row,length_cells\n0,0,1,0,0\n2,2,2,2,0.0\n0,0,1,0,1\n";
        let found: Vec<_> = parse_table(table).unwrap().list.iter().map(|q| (q.optimum, q.says_no_way)).collect();
        assert_eq!(found, [(None, true), (Some(0.0), false), (Some(1.0), false)]);
    }

    #[test]
    fn a_scen_says_for_which_maps_it_is() {
        let text = "version 1\n0 a.map 8 6 0 0 1 1 1.41\n0 a.map 8 6 0 0 1 0 1.00\n0 b.map 8 6 0 0 1 0 1.00\n";
        let queries = parse_scen(text).unwrap();
        let named = |name: &str, line| NamedMap { name: name.to_owned(), size: [8, 6], line };
        assert_eq!(queries.maps, [named("a.map", 2), named("b.map", 4)]);
        assert_eq!(queries.list.iter().map(|query| query.line).collect::<Vec<_>>(), [2, 3, 4]);
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
                "line 2, `length_cells`: expected a number of at least 0, found `far`",
            ),
            (
                "start_col,start_row,goal_col,goal_row,length_cells\n1,2,3,4,-3\n",
                "line 2, `length_cells`: expected a number of at least 0, found `-3`",
            ),
        ] {
            let error = parse_table(text).unwrap_err();
            assert!(error.starts_with(expected), "{error}");
        }
    }
}
