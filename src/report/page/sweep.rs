//! A sweep: success, length and time over each key, a map over two, the best setting.

use super::gather::{Gathered, Stack};
use super::html::{charts, escape, number, or_dash, p_value, table};
use super::plots::WIDTH_PX;
use crate::analysis::{Z_95, wilson};
use crate::comparison::{Section, Table, rank_points};
use crate::report::chart::{self, Heat, HeatCell, Ink, LinePoint, Lines, Series};
use crate::results::Rate;

/// Settings of the ranking that are shown unfolded.
const RANKED_SHOWN: usize = 10;
/// Stacks that get a line of their own; more would be a tangle.
const LINES_MAX: usize = 8;
/// Maps of pairs of keys.
const MAPS_MAX: usize = 3;
/// Values of a key that a map can show.
const VALUES_MAX: usize = 24;

/// The section of a sweep; `words` are those with which a command names its scenario.
pub(super) fn section(gathered: &Gathered, words: &str) -> String {
    ranking(gathered, words) + &over_keys(gathered) + &maps(gathered)
}

/// Settings by success, then time.
fn ranking(gathered: &Gathered, words: &str) -> String {
    let sections: Vec<Section> = gathered.sections().cloned().collect();
    let shown = gathered.scenario.clone();
    let whole = Table { path: shown.into(), sections, missing: Vec::new(), identity: None, is_altered: false };
    let Ok(found) = rank_points(&whole, &[]) else { return String::new() };
    let mut head: Vec<String> = vec!["setting".to_owned(), "stack".to_owned()];
    head.extend(["success, % [95 %]", "group", "time, s", "length, m", "p, Holm: success", "time"].map(str::to_owned));
    let rows: Vec<Vec<String>> = found
        .ranked
        .iter()
        .map(|point| {
            let values = found.keys.iter().zip(&point.values).filter(|(_, value)| !value.is_empty());
            let values: Vec<String> = values.map(|(key, value)| format!("{} = {}", short(key), value)).collect();
            let success = point.summary.success.map_or_else(
                || "–".to_owned(),
                |Rate { rate, low, high }| {
                    let [rate, low, high] = [rate, low, high].map(|share| number(100.0 * share, 1));
                    format!("<b>{rate}</b> <span class=\"i\">[{low}, {high}]</span>")
                },
            );
            let p = |metric: &str| {
                let test = point.tests.iter().find(|test| test.metric == metric);
                test.map_or_else(|| "–".to_owned(), |test| p_value(test.p_holm))
            };
            vec![
                escape(&format!("{}: {}", point.point, values.join(", "))),
                escape(&point.summary.stack),
                success,
                escape(&point.letters),
                or_dash(point.summary.metric("time_s").mean, 2),
                or_dash(point.summary.metric("length_m").mean, 2),
                p("success"),
                p("time_s"),
            ]
        })
        .collect();
    let best = found.ranked.first().map_or_else(String::new, |best| {
        let rate = best.summary.success.map_or_else(String::new, |rate| {
            let [value, low, high] = [rate.rate, rate.low, rate.high].map(|share| number(100.0 * share, 1));
            format!(" with {value} % [{low}, {high}]")
        });
        format!(
            "<p>The best setting by success, then time, is <b>{}</b> at point {}{rate}. Chosen by the worlds that it is judged on, it looks too good on average: \
             another seed says what it is worth.</p>\n<pre><code>simrun run {} {}</code></pre>\n",
            escape(&best.summary.stack),
            best.point,
            escape(words),
            escape(&found.best_arguments())
        )
    });
    let (first, rest) = rows.split_at(rows.len().min(RANKED_SHOWN));
    let mut text = best + &table(&head, first, 2, "ranking");
    if !rest.is_empty() {
        text += &format!(
            "<details><summary>{} more settings</summary>\n{}</details>\n",
            rest.len(),
            table(&head, rest, 2, "ranking")
        );
    }
    let needed = found.worlds_needed();
    if !needed.is_empty() {
        text += &format!("<p>{}</p>\n", escape(&needed));
    }
    text + "<p class=\"small\">Settings that share a letter are not told apart by success; p of each against the best, corrected by Holm over the table.</p>\n"
}

/// The last part of a key: what tells it from others in a label.
fn short(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

/// Counts and sums of some stacks.
#[derive(Clone, Copy, Default)]
struct Pool {
    successes: u64,
    rated: u64,
    sums: [f64; 2],
    squares: [f64; 2],
    counts: [u64; 2],
}

/// The metrics over a key beside success, by their place in `COMPARED`.
const OVER: [(usize, &str); 2] = [(0, "length_m"), (1, "time_s")];

impl Pool {
    fn add(&mut self, stack: &Stack) {
        self.successes += stack.outcomes[0];
        self.rated += stack.rated;
        for (at, (metric, _)) in OVER.iter().enumerate() {
            for value in &stack.values[*metric] {
                self.sums[at] += value;
                self.squares[at] += value * value;
                self.counts[at] += 1;
            }
        }
    }

    fn success(&self) -> Option<(f64, Option<(f64, f64)>)> {
        let (low, high) = wilson(self.successes, self.rated, Z_95)?;
        Some((100.0 * self.successes as f64 / self.rated as f64, Some((100.0 * low, 100.0 * high))))
    }

    /// Mean with its 95 % interval by the normal law.
    fn mean(&self, at: usize) -> Option<(f64, Option<(f64, f64)>)> {
        let n = self.counts[at] as f64;
        let mean = (n > 0.0).then(|| self.sums[at] / n)?;
        let variance = crate::math::max(self.squares[at] / n - mean * mean, 0.0);
        let half = (n > 1.0).then(|| Z_95 * (variance / (n - 1.0)).sqrt());
        Some((mean, half.map(|half| (mean - half, mean + half))))
    }

    fn of(&self, metric: Option<usize>) -> Option<(f64, Option<(f64, f64)>)> {
        metric.map_or_else(|| self.success(), |at| self.mean(at))
    }
}

/// The values of a key in the order of the table; by number if they all are.
fn values_of(gathered: &Gathered, key: usize) -> (Vec<String>, Option<Vec<f64>>) {
    let mut values: Vec<String> = Vec::new();
    for point in &gathered.points {
        for stack in &point.section.stacks {
            let Some(value) = stack.values.get(key).filter(|value| !value.is_empty()) else { continue };
            if !values.contains(value) {
                values.push(value.clone());
            }
        }
    }
    let numbers: Option<Vec<f64>> =
        values.iter().map(|value| value.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match numbers {
        Some(mut numbers) => {
            values.sort_by(|a, b| a.parse::<f64>().unwrap_or(0.0).total_cmp(&b.parse().unwrap_or(0.0)));
            numbers.sort_by(f64::total_cmp);
            (values, Some(numbers))
        }
        None => (values, None),
    }
}

/// All rows of the stacks that `wanted` names by their values.
fn pooled(gathered: &Gathered, name: Option<&str>, wanted: &[(usize, &str)]) -> Pool {
    let mut pool = Pool::default();
    for point in &gathered.points {
        for (stack, rows) in point.stacks.iter().zip(&point.section.stacks) {
            let is_named = name.is_none_or(|name| stack.name == name);
            if is_named && wanted.iter().all(|(key, value)| rows.values.get(*key).is_some_and(|own| own == value)) {
                pool.add(stack);
            }
        }
    }
    pool
}

/// Success, length and time over each key.
fn over_keys(gathered: &Gathered) -> String {
    let names = gathered.stack_names();
    let mut text = String::new();
    for (key, name) in gathered.keys.iter().enumerate() {
        let (values, numbers) = values_of(gathered, key);
        if values.len() < 2 {
            continue;
        }
        let metrics =
            [(None, "success")].into_iter().chain(OVER.iter().enumerate().map(|(at, (_, name))| (Some(at), *name)));
        let figures: Vec<(String, String)> = metrics
            .map(|(metric, called)| {
                let series = names.iter().take(LINES_MAX).enumerate().map(|(series, stack)| {
                    let points = values.iter().enumerate().filter_map(|(at, value)| {
                        let (y, interval) = pooled(gathered, Some(stack), &[(key, value)]).of(metric)?;
                        let x = numbers.as_ref().map_or(at as f64, |numbers| numbers[at]);
                        Some(LinePoint { x, y, interval })
                    });
                    Series { name: (*stack).to_owned(), series, points: points.collect() }
                });
                let lines = Lines {
                    width_px: WIDTH_PX,
                    height_px: 170.0,
                    x_label: name.clone(),
                    y_label: chart::label(called),
                    y_ends: metric.is_none().then_some((0.0, 100.0)),
                    x_words: if numbers.is_some() { Vec::new() } else { values.clone() },
                    series: series.filter(|series| !series.points.is_empty()).collect(),
                };
                (format!("{} over {}", chart::words(called), short(name)), lines.draw(&Ink::PAGE))
            })
            .collect();
        text += &charts(&figures);
    }
    if text.is_empty() {
        return text;
    }
    let others = if gathered.keys.len() > 1 { " All values of the other keys are taken together." } else { "" };
    let left = if names.len() > LINES_MAX {
        format!(" The first {LINES_MAX} of {} stacks have lines.", names.len())
    } else {
        String::new()
    };
    format!(
        "{text}<p class=\"small\">Bands are 95 % intervals; lengths and times are means of the successes.{others}{left}</p>\n"
    )
}

/// Success over pairs of keys, all stacks together.
fn maps(gathered: &Gathered) -> String {
    let many: Vec<(usize, Vec<String>)> = (0..gathered.keys.len())
        .map(|key| (key, values_of(gathered, key).0))
        .filter(|(_, values)| (2..=VALUES_MAX).contains(&values.len()))
        .collect();
    let mut figures = Vec::new();
    for (at, (x_key, xs)) in many.iter().enumerate() {
        for (y_key, ys) in &many[at + 1..] {
            if figures.len() < MAPS_MAX {
                figures.extend(map(gathered, (*x_key, xs), (*y_key, ys)));
            }
        }
    }
    charts(&figures)
}

fn map(gathered: &Gathered, (x_key, xs): (usize, &[String]), (y_key, ys): (usize, &[String])) -> [(String, String); 2] {
    let ys: Vec<&String> = ys.iter().rev().collect();
    let of = |metric: Option<usize>| -> Vec<Option<f64>> {
        let places = ys.iter().flat_map(|y| xs.iter().map(move |x| (x, *y)));
        places.map(|(x, y)| Some(pooled(gathered, None, &[(x_key, x), (y_key, y)]).of(metric)?.0)).collect()
    };
    let draw = |metric: Option<usize>, called: &str| {
        let values = of(metric);
        let known = || values.iter().flatten().copied();
        let best = match metric {
            None => known().fold(f64::NEG_INFINITY, crate::math::max),
            Some(_) => known().fold(f64::INFINITY, crate::math::min),
        };
        // Where several are best none is framed.
        let is_alone = known().filter(|value| value.total_cmp(&best).is_eq()).count() == 1;
        let cell = |value: f64| HeatCell { value, is_best: is_alone && value.total_cmp(&best).is_eq() };
        let cells = values.iter().map(|value| value.map(cell)).collect();
        let heat = Heat {
            width_px: WIDTH_PX,
            label: chart::label(called),
            x: (gathered.keys[x_key].clone(), xs.to_vec()),
            y: (gathered.keys[y_key].clone(), ys.iter().map(|&y| y.clone()).collect()),
            cells,
            decimals: usize::from(metric.is_some() || xs.len() <= 6),
            ends: metric.is_none().then_some((0.0, 100.0)),
        };
        (format!("{} over two keys", chart::words(called)), heat.draw(&Ink::PAGE))
    };
    [draw(None, "success"), draw(Some(1), "time_s")]
}
