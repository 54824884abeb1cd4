//! Claims against evidence.

use super::evidence::Evidence;
use super::manifest::{Over, Place, Relation, Source, Test, all, compare, differ, fisher, multiples, range, reach};
use super::published::{Published, is_of_plan, mean_of, value};
use crate::analysis::{
    Location, PairedOutcomes, Z_95, bootstrap_interval, fisher_exact, mcnemar_exact, paired_differences, signed_rank,
    wilson,
};
use crate::comparison::{ALPHA, StackRows};
use crate::episode::Outcome;
use crate::math;

/// What came of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ruling {
    /// It holds.
    Holds,
    /// It does not hold.
    Fails,
    /// The data do not tell.
    Undecided,
    /// Nothing that could be run would tell.
    Untestable,
}

impl Ruling {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "does not hold",
            Self::Undecided => "undecided",
            Self::Untestable => "cannot be tested",
        }
    }
}

/// A ruling with its reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// What came of it.
    pub ruling: Ruling,
    /// The numbers that say so.
    pub why: String,
}

fn verdict(ruling: Ruling, why: impl Into<String>) -> Verdict {
    Verdict { ruling, why: why.into() }
}

fn missing(what: &str) -> Verdict {
    verdict(Ruling::Undecided, format!("no data: {what}"))
}

/// Puts a claim to its test.
pub fn judge(test: &Test, evidence: &Evidence, published: &[Published]) -> Verdict {
    match test {
        Test::compare(params) => match params.source {
            Source::Measured => compare_measured(params, evidence),
            Source::Published => compare_published(params, published),
        },
        Test::differ(params) => differs(params, evidence),
        Test::reach(params) => reaches(params, evidence, published),
        Test::range(params) => in_range(params, evidence, published),
        Test::fisher(params) => told_apart(params, published),
        Test::multiples(params) => whole_counts(params, published),
        Test::all(params) => every_one(params, evidence, published),
        Test::untestable(params) => verdict(Ruling::Untestable, params.because.clone()),
    }
}

fn compare_measured(params: &compare::Params, evidence: &Evidence) -> Verdict {
    let find = |place: &Place| evidence.stack(&place.table, &place.stack);
    let (Some(of), Some(than)) = (find(&params.of), find(&params.than)) else {
        return missing(&format!("{} in {}", params.of.stack, params.of.table));
    };
    let counts =
        |outcome: &Outcome| params.over == Over::All || is_of_plan(&params.metric) || *outcome == Outcome::Success;
    let pairs: Vec<(f64, f64)> = of
        .shared(than)
        .filter(|(a, b)| counts(&a.outcome) && counts(&b.outcome))
        .filter_map(|(a, b)| Some((value(a, &params.metric)?, params.factor * value(b, &params.metric)?)))
        .collect();
    if pairs.is_empty() {
        return missing("no world counts for both");
    }
    let n = pairs.len();
    let mean = |pick: fn(&(f64, f64)) -> f64| pairs.iter().map(pick).sum::<f64>() / n as f64;
    let differences: Vec<f64> = pairs.iter().map(|(a, b)| a - b).collect();
    let (a, b) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let factor = if params.factor == 1.0 { String::new() } else { format!(" ({} times)", params.factor) };
    if params.is == Relation::Equal {
        let largest = differences.iter().map(|d| d.abs()).fold(0.0, math::max);
        let ruling = if largest <= params.tolerance { Ruling::Holds } else { Ruling::Fails };
        return verdict(ruling, format!("largest difference {largest:.3} in {n} worlds"));
    }
    let (low, high) = bootstrap_interval(&differences, Location::Mean, 0.95).unwrap_or((a - b, a - b));
    // In few worlds the exact tests know more than a bootstrap: of one world its interval is a point.
    let is_success = params.metric == "success" && params.factor == 1.0;
    let p = if is_success {
        let (first, second): (Vec<bool>, Vec<bool>) = pairs.iter().map(|(a, b)| (*a > 0.0, *b > 0.0)).unzip();
        mcnemar_exact(PairedOutcomes::count(&first, &second))
    } else {
        let (first, second): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
        signed_rank(&paired_differences(&first, &second)).p
    };
    let is_clear = p <= ALPHA && (is_success || high < 0.0 || low > 0.0);
    let (is_less, is_more) = (is_clear && a < b, is_clear && a > b);
    let ruling = match params.is {
        Relation::Less if is_less => Ruling::Holds,
        Relation::Less if is_more => Ruling::Fails,
        Relation::More if is_more => Ruling::Holds,
        Relation::More if is_less => Ruling::Fails,
        // The numbers are the same in every world.
        _ if !is_success && low == 0.0 && high == 0.0 => Ruling::Fails,
        _ => Ruling::Undecided,
    };
    let p = if p < 0.0005 { ", p < 0.001".to_owned() } else { format!(", p = {p:.3}") };
    verdict(
        ruling,
        format!("{a:.2} against {b:.2}{factor}, difference {:+.2} [{low:+.2}, {high:+.2}] in {n} worlds{p}", a - b),
    )
}

/// The published mean of a metric of a stack.
fn printed<'p>(published: &'p [Published], place: &Place, metric: &str) -> Option<&'p Published> {
    published.iter().find(|number| {
        (number.table.as_str(), number.stack.as_str(), number.metric.as_str()) == (&place.table, &place.stack, metric)
            && number.quantity == "mean"
            && number.number().is_some()
    })
}

fn compare_published(params: &compare::Params, published: &[Published]) -> Verdict {
    let number = |place: &Place| printed(published, place, &params.metric).and_then(Published::number);
    let (Some(a), Some(b)) = (number(&params.of), number(&params.than)) else {
        return missing("not printed");
    };
    let b = b * params.factor;
    let holds = match params.is {
        Relation::Less => a < b,
        Relation::More => a > b,
        Relation::Equal => (a - b).abs() <= params.tolerance,
    };
    verdict(if holds { Ruling::Holds } else { Ruling::Fails }, format!("printed: {a} against {b}"))
}

fn differs(params: &differ::Params, evidence: &Evidence) -> Verdict {
    let (mut worlds, mut widest) = (0u64, 0.0);
    for table in &params.tables {
        let Some(section) = evidence.section(table) else { return missing(table) };
        let stacks: Vec<&StackRows> =
            params.stacks.iter().filter_map(|name| section.stacks.iter().find(|stack| stack.name == *name)).collect();
        let Some(first) = stacks.first().filter(|_| stacks.len() == params.stacks.len()) else {
            return missing(&format!("not all of these stacks ran in {table}"));
        };
        for world in first.rows.keys() {
            let values: Vec<f64> =
                stacks.iter().filter_map(|stack| value(stack.rows.get(world)?, &params.metric)).collect();
            if values.len() == stacks.len() {
                worlds += 1;
                let low = values.iter().copied().fold(f64::INFINITY, math::min);
                let high = values.iter().copied().fold(f64::NEG_INFINITY, math::max);
                widest = math::max(widest, high - low);
            }
        }
    }
    let ruling = if worlds == 0 {
        Ruling::Undecided
    } else if widest > params.tolerance {
        Ruling::Holds
    } else {
        Ruling::Fails
    };
    verdict(ruling, format!("largest difference {widest:.3} in {worlds} worlds"))
}

fn reaches(params: &reach::Params, evidence: &Evidence, published: &[Published]) -> Verdict {
    let printed = params.of.table.split('_').next().unwrap_or(&params.of.table);
    let place = Place { table: printed.to_owned(), stack: params.of.stack.clone() };
    let theirs = self::printed(published, &place, "success").and_then(Published::counts);
    let (Some((k, trials)), Some(stack)) = (theirs, evidence.stack(&params.of.table, &params.of.stack)) else {
        return missing("no published count, or no rows");
    };
    let Some(ours) = mean_of(stack, "success") else { return missing("no rows") };
    let (low, high) = ours.interval.unwrap_or((ours.value, ours.value));
    let (their_low, _) = wilson(k, trials, Z_95).unwrap_or_default();
    let their_low = 100.0 * their_low;
    let ruling = if low >= their_low {
        Ruling::Holds
    } else if high < their_low {
        Ruling::Fails
    } else {
        Ruling::Undecided
    };
    let rate = 100.0 * k as f64 / trials as f64;
    verdict(
        ruling,
        format!(
            "ours {:.1} % [{low:.1}, {high:.1}] of {}; published {rate:.1} % of {trials}, lower limit {their_low:.1} %",
            ours.value, ours.n
        ),
    )
}

fn in_range(params: &range::Params, evidence: &Evidence, published: &[Published]) -> Verdict {
    let (low, high) = (params.at_least.unwrap_or(f64::NEG_INFINITY), params.at_most.unwrap_or(f64::INFINITY));
    let wanted = |stack: &str| params.stack.as_ref().is_none_or(|name| name == stack);
    if params.source == Source::Published {
        let numbers: Vec<f64> = published
            .iter()
            .filter(|number| number.table == params.table && wanted(&number.stack) && number.metric == params.metric)
            .filter(|number| number.quantity == "mean")
            .filter_map(Published::number)
            .collect();
        let outside: Vec<String> =
            numbers.iter().filter(|number| **number < low || **number > high).map(f64::to_string).collect();
        return match (numbers.len(), outside.as_slice()) {
            (0, _) => missing("not printed"),
            (_, []) => verdict(Ruling::Holds, "every printed number lies within"),
            (n, _) => verdict(
                Ruling::Fails,
                format!("{} of {n} printed numbers do not: {}", outside.len(), outside.join(", ")),
            ),
        };
    }
    let Some(section) = evidence.section(&params.table) else { return missing(&params.table) };
    let stacks = section.stacks.iter().filter(|stack| wanted(&stack.name));
    if params.of == range::Statistic::Every {
        let values: Vec<f64> =
            stacks.flat_map(|stack| stack.rows.values()).filter_map(|row| value(row, &params.metric)).collect();
        let outside = values.iter().filter(|value| **value < low || **value > high).count();
        let ruling = if values.is_empty() {
            Ruling::Undecided
        } else if outside == 0 {
            Ruling::Holds
        } else {
            Ruling::Fails
        };
        return verdict(ruling, format!("{outside} of {} values lie outside", values.len()));
    }
    let rulings = stacks.filter_map(|stack| {
        let mean = mean_of(stack, &params.metric)?;
        let (a, b) = mean.interval.unwrap_or((mean.value, mean.value));
        let ruling = if a >= low && b <= high {
            Ruling::Holds
        } else if b < low || a > high {
            Ruling::Fails
        } else {
            Ruling::Undecided
        };
        Some(verdict(ruling, format!("{}: {:.3} [{a:.3}, {b:.3}]", stack.name, mean.value)))
    });
    together(rulings.collect())
}

fn told_apart(params: &fisher::Params, published: &[Published]) -> Verdict {
    let counts = |place: &Place| printed(published, place, "success").and_then(Published::counts);
    let (Some((a, n)), Some((b, m))) = (counts(&params.of), counts(&params.than)) else {
        return missing("no published counts");
    };
    let p = fisher_exact([[a, n - a], [b, m - b]]);
    let ruling = if p <= ALPHA && a * m > b * n { Ruling::Holds } else { Ruling::Fails };
    verdict(ruling, format!("{a}/{n} against {b}/{m} ({}): p = {p:.3}", params.than.stack))
}

fn whole_counts(params: &multiples::Params, published: &[Published]) -> Verdict {
    let step = (0..params.decimals).fold(1.0, |step, _| step / 10.0);
    let rates: Vec<(&Published, f64, u64)> = published
        .iter()
        .filter(|number| number.table == params.table && number.metric == "success" && number.quantity == "mean")
        .filter_map(|number| Some((number, number.number()?, number.trials?)))
        .collect();
    let is_whole = |rate: f64, trials: u64| {
        let nearest = (rate * trials as f64 / 100.0).round();
        // A printed number is half a step away from the true one at most.
        (100.0 * nearest / trials as f64 - rate).abs() <= 0.5 * step + 1e-9
    };
    let odd: Vec<String> = rates
        .iter()
        .filter(|(_, rate, trials)| !is_whole(*rate, *trials))
        .map(|(_, rate, _)| format!("{rate}"))
        .collect();
    match (rates.len(), odd.as_slice()) {
        (0, _) => missing("no published rates"),
        (n, []) => verdict(Ruling::Holds, format!("all {n} are")),
        (n, _) => verdict(Ruling::Fails, format!("{} of {n} are not: {}", odd.len(), odd.join(", "))),
    }
}

fn every_one(params: &all::Params, evidence: &Evidence, published: &[Published]) -> Verdict {
    together(params.tests.iter().map(|test| judge(test, evidence, published)).collect())
}

/// Holds if all do, fails if one does, else undecided.
fn together(verdicts: Vec<Verdict>) -> Verdict {
    let any = |ruling: Ruling| verdicts.iter().any(|verdict| verdict.ruling == ruling);
    let ruling = if verdicts.is_empty() {
        return missing("no rows");
    } else if any(Ruling::Fails) {
        Ruling::Fails
    } else if any(Ruling::Undecided) || any(Ruling::Untestable) {
        Ruling::Undecided
    } else {
        Ruling::Holds
    };
    let why = |verdict: &Verdict| {
        if verdicts.len() == 1 { verdict.why.clone() } else { format!("{} ({})", verdict.why, verdict.ruling.words()) }
    };
    verdict(ruling, verdicts.iter().map(why).collect::<Vec<_>>().join("; "))
}
