//! The kinds of figures: rows become means with intervals, and points.

use super::curves::{Curve, Curves, Mean};
use super::data::{FigureError, Rows, Values, swept_keys};
use super::{Figure, Panel, Style, axis_label, rows};
use crate::analysis::{Better, Location, Z_95, bootstrap_interval, student_quantile, wilson};
use crate::report::chart::{Tick, number};
use crate::results::metric_column;
use crate::settings::choice::NameError;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What a figure is to show beside its kind.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    /// Columns, one panel each; the usual ones if there are none.
    pub metrics: Vec<String>,
    /// The point of the sweep, where one is shown.
    pub point: Option<u32>,
    /// Only these stacks; all if there are none.
    pub stacks: Vec<String>,
    /// The stack that others are compared with; the first one by default.
    pub reference: Option<String>,
    /// Whether drives that failed count for what depends on the drive.
    pub failures: bool,
}

impl Asked {
    fn metrics<'a>(&'a self, usual: &[&'a str]) -> Vec<&'a str> {
        if self.metrics.is_empty() { usual.to_vec() } else { self.metrics.iter().map(String::as_str).collect() }
    }

    fn keeps(&self, stack: &str) -> bool {
        self.stacks.is_empty() || self.stacks.iter().any(|name| name == stack)
    }

    /// Refuses stacks that the table does not have.
    fn check(&self, rows: &Rows) -> Result<(), FigureError> {
        let known = |name: &&String| rows.stacks.contains(name);
        match self.stacks.iter().chain(&self.reference).find(|name| !known(name)) {
            Some(name) => Err(NameError::unknown("stack", name, &rows.stacks).into()),
            None if rows.is_empty() => Err(FigureError::Nothing("the table has no rows yet".to_owned())),
            None => Ok(()),
        }
    }
}

/// Points of worlds that a series shows in a panel at most; of more, every second, third and so on is shown.
const POINTS_MAX: usize = 300;

/// Values of a continuous x that still count as places of their own.
const PLACES_MAX: usize = 12;

/// Means of a continuous x, each over as many rows.
const BINS: usize = 8;

const SUCCESS: &str = "success";

/// A mean with its 95 % interval: of `success` the rate in per cent with Wilson's, of anything else with Student's t.
fn mean(values: &[f64], is_success: bool) -> Option<(f64, Option<(f64, f64)>)> {
    let n = values.len();
    if n == 0 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n as f64;
    if is_success {
        let successes = values.iter().filter(|value| **value > 0.5).count() as u64;
        let interval = wilson(successes, n as u64, Z_95).map(|(low, high)| (100.0 * low, 100.0 * high));
        return Some((100.0 * mean, interval));
    }
    let squares: f64 = values.iter().map(|x| (x - mean) * (x - mean)).sum();
    let half = (n > 1).then(|| {
        let error = (squares / (n - 1) as f64 / n as f64).sqrt();
        student_quantile(0.975, n as u64 - 1) * error
    });
    Some((mean, half.map(|half| (mean - half, mean + half))))
}

/// At most [`POINTS_MAX`] of the points, evenly spread over their order.
fn thinned<T: Copy>(points: &[T]) -> Vec<T> {
    points.iter().step_by(points.len().div_ceil(POINTS_MAX).max(1)).copied().collect()
}

fn ends(metric: &str) -> Option<(f64, f64)> {
    (metric == SUCCESS).then_some((0.0, 100.0))
}

/// Refuses words where numbers are needed.
fn numbers(column: &Values) -> Result<(), FigureError> {
    match column.words.first() {
        None => Ok(()),
        Some(word) => Err(FigureError::Nothing(format!(
            "the column `{}` is no number (`{word}`): it can be --x or --by",
            column.name
        ))),
    }
}

/// Words for the caption: what the means are over.
fn counted_rows(asked: &Asked, metrics: &[&str]) -> String {
    let of_drive = |name: &&&str| metric_column(name).is_ok_and(|column| column.known == crate::results::Known::After);
    let over =
        if asked.failures || metrics.iter().find(of_drive).is_none() { "" } else { " of the drives that arrived" };
    format!("Means{over} with 95 % intervals; success of all feasible worlds; dots are worlds.")
}

/// A value over a swept key, a curve for each stack and each value of the other swept keys. `x` is the key; the first one by default.
///
/// # Errors
/// If the table cannot be read, was no sweep, or has no such key or column.
pub fn sweep(path: &Path, x: Option<&str>, asked: &Asked, style: &Style) -> Result<Figure, FigureError> {
    let keys = swept_keys(path)?;
    let x = match x {
        Some(x) if !keys.iter().any(|key| key == x) => return Err(NameError::unknown("swept key", x, &keys).into()),
        Some(x) => x,
        None => keys.first().ok_or_else(|| {
            let message = format!("{}: no key was swept; `simrun plot stacks` compares its stacks", path.display());
            FigureError::Nothing(message)
        })?,
    };
    let others: Vec<&str> = keys.iter().map(String::as_str).filter(|key| *key != x).collect();
    let by: Vec<&str> = std::iter::once("stack").chain(others).collect();
    curves(path, x, &asked.metrics(&[SUCCESS, "time_s"]), &by, asked, style)
}

/// Any column over any other, a curve for each value of `by`.
///
/// # Errors
/// If the table cannot be read or has no such column, or a y is no number.
pub fn columns(path: &Path, x: &str, by: Option<&str>, asked: &Asked, style: &Style) -> Result<Figure, FigureError> {
    curves(path, x, &asked.metrics(&[SUCCESS]), &[by.unwrap_or("stack")], asked, style)
}

/// The name of each series: the parts in which series differ.
fn series_names(rows: &Rows, first: usize, keys: &BTreeSet<Vec<Option<u64>>>) -> Vec<String> {
    let count = keys.iter().next().map_or(0, Vec::len);
    let differs = |part: usize| keys.iter().map(|key| key[part]).collect::<BTreeSet<_>>().len() > 1;
    let parts: Vec<usize> = (0..count).filter(|&part| differs(part)).collect();
    let name = |key: &Vec<Option<u64>>| {
        let words = parts.iter().filter_map(|&part| {
            let (column, bits) = (&rows.columns[first + part], key[part]?);
            let value = f64::from_bits(bits);
            if let Some(word) = column.words.get(value as usize) {
                return Some(word.clone());
            }
            let last = column.name.rsplit('.').next().unwrap_or_default();
            Some(format!("{} {}", axis_label(last).to_lowercase(), short(value)))
        });
        words.collect::<Vec<String>>().join(", ")
    };
    keys.iter().map(name).collect()
}

/// A number with as many decimals as it needs, up to four.
fn short(value: f64) -> String {
    let decimals = (0..4).find(|&decimals| {
        let text = format!("{value:.decimals$}");
        text.parse::<f64>().is_ok_and(|read| (read - value).abs() <= 1e-9 * value.abs())
    });
    number(value, decimals.unwrap_or(4))
}

fn curves(
    path: &Path,
    x: &str,
    metrics: &[&str],
    by: &[&str],
    asked: &Asked,
    style: &Style,
) -> Result<Figure, FigureError> {
    let names: Vec<&str> = std::iter::once(x).chain(metrics.iter().copied()).chain(by.iter().copied()).collect();
    let rows = Rows::read(path, &names)?;
    asked.check(&rows)?;
    let (first_by, of_x) = (1 + metrics.len(), &rows.columns[0]);
    rows.columns[1..first_by].iter().try_for_each(numbers)?;
    let kept: Vec<usize> = (0..rows.len())
        .filter(|&row| asked.keeps(&rows.stacks[rows.stack[row]]))
        .filter(|&row| asked.point.is_none_or(|point| rows.world[row].0 == point))
        .collect();

    // Series, in the order of the values that tell them apart; words in the order of the table.
    let key = |row: usize| -> Vec<Option<u64>> {
        rows.columns[first_by..]
            .iter()
            .map(|by| Some(by.values[row]).filter(|x| x.is_finite()).map(f64::to_bits))
            .collect()
    };
    let mut of_series: BTreeMap<Vec<Option<u64>>, Vec<usize>> = BTreeMap::new();
    kept.iter().for_each(|&row| of_series.entry(key(row)).or_default().push(row));
    let keys: BTreeSet<Vec<Option<u64>>> = of_series.keys().cloned().collect();
    let series_names = series_names(&rows, first_by, &keys);

    let distinct: BTreeSet<u64> =
        kept.iter().map(|&row| of_x.values[row]).filter(|x| x.is_finite()).map(order_bits).collect();
    let mut places: Vec<f64> = Vec::new();
    if distinct.len() <= PLACES_MAX || !of_x.words.is_empty() {
        places = kept.iter().map(|&row| of_x.values[row]).filter(|x| x.is_finite()).collect();
        places.sort_unstable_by(f64::total_cmp);
        places.dedup();
    }
    if distinct.is_empty() {
        return Err(FigureError::Nothing(format!("no row has a value of `{x}`")));
    }
    let label = |place: &f64| Tick {
        value: *place,
        label: of_x.words.get(*place as usize).cloned().unwrap_or_else(|| short(*place)),
    };
    let panels = metrics.iter().enumerate().map(|(metric, name)| {
        let curves = of_series.values().enumerate().map(|(series, of_series)| {
            let is_success = *name == SUCCESS;
            let value = |row: usize| rows.value(1 + metric, row, asked.failures);
            // A key that does not touch a stack is empty in its rows: they hold at every place.
            let at = |row: usize| {
                let x = of_x.values[row];
                if x.is_finite() { vec![x] } else { places.clone() }
            };
            let points: Vec<(f64, f64)> = of_series
                .iter()
                .filter_map(|&row| Some((row, value(row)?)))
                .flat_map(|(row, y)| at(row).into_iter().map(move |x| (x, y)))
                .collect();
            let cloud = if is_success { Vec::new() } else { thinned(&points) };
            let means =
                if places.is_empty() { binned(points, is_success) } else { at_places(&points, &places, is_success) };
            Curve { series, means, cloud }
        });
        Panel::Curves(Curves {
            x_label: axis_label(x),
            y_label: axis_label(name),
            x_places: places.iter().map(label).collect(),
            y_ends: ends(name),
            is_log: [style.is_log[0], style.is_log[1] && *name != SUCCESS],
            is_joined: of_x.words.is_empty(),
            curves: curves.collect(),
        })
    });
    let panels: Vec<Panel> = panels.collect();
    let legend = series_names.into_iter().enumerate().filter(|_| keys.len() > 1).map(|(at, name)| (name, at)).collect();
    let caption = format!("{}: {} over {x}. {}", rows.scenario, metrics.join(", "), counted_rows(asked, metrics));
    Ok(Figure { panels, legend, caption })
}

/// The bits of a number, for sets of numbers.
fn order_bits(value: f64) -> u64 {
    value.to_bits()
}

fn at_places(points: &[(f64, f64)], places: &[f64], is_success: bool) -> Vec<Mean> {
    let mut of_place: Vec<Vec<f64>> = vec![Vec::new(); places.len()];
    for (x, y) in points {
        if let Ok(place) = places.binary_search_by(|place| place.total_cmp(x)) {
            of_place[place].push(*y);
        }
    }
    let means = places.iter().zip(&of_place).filter_map(|(&x, values)| {
        let (y, interval) = mean(values, is_success)?;
        Some(Mean { x, y, interval })
    });
    means.collect()
}

/// Means of a continuous x: the points in order of x, in [`BINS`] parts of the same number of points.
fn binned(mut points: Vec<(f64, f64)>, is_success: bool) -> Vec<Mean> {
    points.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let size = points.len().div_ceil(BINS).max(5);
    let means = points.chunks(size).filter_map(|part| {
        let values: Vec<f64> = part.iter().map(|point| point.1).collect();
        let (y, interval) = mean(&values, is_success)?;
        let x = part.iter().map(|point| point.0).sum::<f64>() / part.len() as f64;
        Some(Mean { x, y, interval })
    });
    means.collect()
}

/// The rows of one point, and its stacks.
fn of_point(path: &Path, metrics: &[&str], asked: &Asked) -> Result<(Rows, Vec<usize>, Vec<usize>), FigureError> {
    let rows = Rows::read(path, metrics)?;
    asked.check(&rows)?;
    rows.columns.iter().try_for_each(numbers)?;
    let points: BTreeSet<u32> = rows.world.iter().map(|world| world.0).collect();
    let point = match asked.point {
        Some(point) if !points.contains(&point) => {
            return Err(FigureError::Nothing(format!("there is no point {point}: the table has {}", points.len())));
        }
        Some(point) => point,
        None if points.len() > 1 => {
            return Err(FigureError::Nothing(format!(
                "the table has {} points of a sweep, which are never pooled: name one with --point, or use `simrun plot sweep`",
                points.len()
            )));
        }
        None => points.first().copied().unwrap_or_default(),
    };
    let kept: Vec<usize> = (0..rows.len())
        .filter(|&row| rows.world[row].0 == point && asked.keeps(&rows.stacks[rows.stack[row]]))
        .collect();
    let here: BTreeSet<usize> = kept.iter().map(|&row| rows.stack[row]).collect();
    Ok((rows, kept, here.into_iter().collect()))
}

const USUAL: [&str; 4] = [SUCCESS, "time_s", "length_m", "clearance_min_m"];

/// Stacks side by side: a panel for each metric, a row for each stack.
///
/// # Errors
/// If the table cannot be read, has several points and none was named, or has no such column or stack.
pub fn stacks(path: &Path, asked: &Asked, style: &Style) -> Result<Figure, FigureError> {
    let metrics = asked.metrics(&USUAL);
    let (rows, kept, stacks) = of_point(path, &metrics, asked)?;
    let panels = metrics.iter().enumerate().map(|(metric, name)| {
        let is_success = *name == SUCCESS;
        let of_stack = stacks.iter().enumerate().map(|(series, &stack)| {
            let of_stack = kept.iter().filter(|&&row| rows.stack[row] == stack);
            let values: Vec<f64> = of_stack.filter_map(|&row| rows.value(metric, row, asked.failures)).collect();
            let mean = mean(&values, is_success);
            rows::Row {
                name: rows.stacks[stack].clone(),
                series,
                mean: mean.map(|mean| mean.0),
                interval: mean.and_then(|mean| mean.1),
                cloud: if is_success { Vec::new() } else { thinned(&values) },
            }
        });
        Panel::Rows(rows::Rows {
            label: axis_label(name),
            ends: ends(name),
            reference: None,
            is_log: style.is_log[0] && !is_success,
            rows: of_stack.collect(),
        })
    });
    let panels = panels.collect();
    let caption = format!("{}: {}. {}", rows.scenario, metrics.join(", "), counted_rows(asked, &metrics));
    Ok(Figure { panels, legend: Vec::new(), caption })
}

/// Differences to a reference on the same worlds: a panel for each metric, a row for each other stack. Metrics that depend on the drive are compared where
/// both arrived.
///
/// # Errors
/// As [`stacks`], and if there is nothing to compare.
pub fn pairs(path: &Path, asked: &Asked) -> Result<Figure, FigureError> {
    let metrics = asked.metrics(&USUAL);
    let (rows, kept, stacks) = of_point(path, &metrics, asked)?;
    let reference = match &asked.reference {
        Some(name) => rows.stacks.iter().position(|stack| stack == name).unwrap_or_default(),
        None => stacks.first().copied().unwrap_or_default(),
    };
    let others: Vec<usize> = stacks.iter().copied().filter(|&stack| stack != reference).collect();
    if others.is_empty() {
        return Err(FigureError::Nothing("one stack alone: there is nothing to compare it with".to_owned()));
    }
    let of_world: BTreeMap<(u32, u64, u64), usize> =
        kept.iter().filter(|&&row| rows.stack[row] == reference).map(|&row| (rows.world[row], row)).collect();
    let panels = metrics.iter().enumerate().map(|(metric, name)| {
        let is_success = *name == SUCCESS;
        let value = |row: usize| rows.value(metric, row, asked.failures);
        let of_stack = others.iter().map(|&stack| {
            let of_stack = kept.iter().filter(|&&row| rows.stack[row] == stack);
            let factor = if is_success { 100.0 } else { 1.0 };
            let differences: Vec<f64> = of_stack
                .filter_map(|&row| Some(factor * (value(row)? - value(*of_world.get(&rows.world[row])?)?)))
                .collect();
            let n = differences.len() as f64;
            rows::Row {
                name: rows.stacks[stack].clone(),
                series: stacks.iter().position(|&other| other == stack).unwrap_or_default(),
                mean: (n > 0.0).then(|| differences.iter().sum::<f64>() / n),
                interval: bootstrap_interval(&differences, Location::Mean, 0.95),
                cloud: if is_success { Vec::new() } else { thinned(&differences) },
            }
        });
        let better = match metric_column(name).map_or(Some(Better::Higher), |column| column.better) {
            Some(Better::Higher) => ", more is better",
            Some(Better::Lower) => ", less is better",
            None => "",
        };
        let label = if is_success { "Success (points)".to_owned() } else { axis_label(name) };
        Panel::Rows(rows::Rows {
            label: format!("Δ {label}{better}"),
            ends: None,
            reference: Some(0.0),
            is_log: false,
            rows: of_stack.collect(),
        })
    });
    let panels = panels.collect();
    let caption = format!(
        "{}: difference to {} on the same worlds (what depends on the drive: where both arrived), means with 95 % bootstrap intervals; dots are worlds.",
        rows.scenario, rows.stacks[reference]
    );
    Ok(Figure { panels, legend: Vec::new(), caption })
}
