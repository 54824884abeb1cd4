//! The tests by which a claim holds: one file each.
//!
//! A metric is a measured column of `episodes.csv`, or `success` (in percent).

use super::Paper;
use super::evidence::Evidence;
use super::manifest::{Table, larger_form};
use super::published::{Published, Quantity, SUCCESS};
use crate::analysis::{normal_upper_tail, student_upper_tail};
use crate::comparison::{ALPHA, Section, StackRows};
use crate::results::metric_column;
use crate::settings::quantity::counted;
use crate::settings::registry;
use serde::Deserialize;

#[cfg(test)]
mod tests;

registry! {
    /// What would make a claim hold.
    pub enum Test: "test", Entry, dyn Kind {
        compare, best, reduction, equivalent, differ, reach, range, rank_correlation, rank_sum, fisher, multiples, all, untestable,
    }
}

/// What the registry knows of a test.
#[derive(Debug)]
pub struct Entry {
    /// The test in one line.
    pub summary: &'static str,
}

/// What a test does.
pub trait Kind {
    /// Checks the names in it, before anything runs.
    ///
    /// # Errors
    /// What does not fit the paper's tables and the known metrics.
    fn check(&self, paper: &Paper) -> Result<(), String>;

    /// The measured rows that it looks at.
    fn uses(&self) -> Vec<Use<'_>>;

    /// Puts the claim to the test.
    fn judge(&self, data: &Data<'_>) -> Verdict;
}

/// Measured rows that a test looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Use<'a> {
    /// Id of the table.
    pub table: &'a str,
    /// The stack; `None` for every stack of the table.
    pub stack: Option<&'a str>,
}

/// A stack in a table.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Id of the table.
    pub table: String,
    /// Name of the stack.
    pub stack: String,
}

impl Place {
    /// Its measured rows.
    fn used(&self) -> Use<'_> {
        Use { table: &self.table, stack: Some(&self.stack) }
    }
}

/// How two numbers should stand to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Relation {
    /// The first is smaller.
    Less,
    /// The first is larger.
    More,
    /// They are equal within the tolerance.
    Equal,
}

/// Whether a test is about the paper's numbers or ours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The rows of our runs.
    #[default]
    Measured,
    /// The numbers that the paper prints.
    Published,
}

/// The worlds that a comparison looks at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// Those that both stacks solved.
    #[default]
    BothSolved,
    /// All in which the metric is defined for both: for what is known before the drive, such as planned lengths.
    All,
}

/// Ruling on a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ruling {
    /// The claim holds.
    Holds,
    /// The claim does not hold.
    Fails,
    /// Whether the claim holds depends on a choice that the paper leaves open.
    Depends,
    /// The data do not decide the claim.
    Undecided,
    /// No run could decide the claim.
    Untestable,
    /// The tables that would decide the claim were not run.
    NotRun,
}

impl Ruling {
    /// Every ruling, in the order of reports.
    pub const ALL: [Self; 6] =
        [Self::Holds, Self::Fails, Self::Depends, Self::Undecided, Self::Untestable, Self::NotRun];

    /// The ruling in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "does not hold",
            Self::Depends => "depends",
            Self::Undecided => "undecided",
            Self::Untestable => "cannot be tested",
            Self::NotRun => "not run",
        }
    }

    /// Whether the data decide the claim.
    pub fn is_decided(self) -> bool {
        matches!(self, Self::Holds | Self::Fails)
    }
}

/// A ruling with its reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The ruling.
    pub ruling: Ruling,
    /// The numbers behind the ruling.
    pub why: String,
    /// Two-sided p-value of the statistical test behind it; `None` where nothing is estimated, as for printed numbers.
    pub p: Option<f64>,
}

fn verdict(ruling: Ruling, why: impl Into<String>) -> Verdict {
    Verdict { ruling, why: why.into(), p: None }
}

impl Verdict {
    fn with_p(self, p: f64) -> Self {
        Self { p: Some(p), ..self }
    }
}

/// Ruling by a lower and an upper end of an interval: whether it lies within bounds.
fn within(interval: (f64, f64), at_least: f64, at_most: f64) -> Ruling {
    let (low, high) = interval;
    if low >= at_least && high <= at_most {
        Ruling::Holds
    } else if high < at_least || low > at_most {
        Ruling::Fails
    } else {
        Ruling::Undecided
    }
}

/// Two-sided p-value of a standard normal statistic.
fn p_of_z(z: f64) -> f64 {
    crate::math::min(1.0, 2.0 * normal_upper_tail(z.abs()))
}

/// Two-sided p-value of the score test, of which Wilson's interval is the inversion, that a rate of `n` trials is `bound`; both in
/// per cent.
fn p_of_rate(rate: f64, bound: f64, n: u64) -> f64 {
    let error = (bound * (100.0 - bound) / n as f64).sqrt();
    if error > 0.0 { p_of_z((rate - bound) / error) } else { f64::from(u8::from(rate == bound)) }
}

/// Two-sided p-value of Student's test that the mean of `values` is `bound`; 1 where it cannot be tested.
fn p_of_mean(values: &[f64], bound: f64) -> f64 {
    let n = values.len();
    if n < 2 || !bound.is_finite() {
        return 1.0;
    }
    let mean = values.iter().sum::<f64>() / n as f64;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    let error = (squares / (n - 1) as f64 / n as f64).sqrt();
    if error > 0.0 {
        crate::math::min(1.0, 2.0 * student_upper_tail((mean - bound).abs() / error, n as u64 - 1))
    } else {
        f64::from(u8::from(mean == bound))
    }
}

/// A ruling by an interval that the test of the same question must confirm: in few worlds it knows more than a bootstrap.
fn confirmed(ruling: Ruling, p: f64) -> Ruling {
    if ruling.is_decided() && p > ALPHA { Ruling::Undecided } else { ruling }
}

/// A p-value as reports show it.
fn p_text(p: f64) -> String {
    if p < 0.0005 { "p < 0.001".to_owned() } else { format!("p = {p:.3}") }
}

fn worlds(count: usize) -> String {
    counted(count as u64, "world")
}

/// The verdict where there is nothing to look at.
fn missing(what: &str) -> Verdict {
    verdict(Ruling::Undecided, format!("no data: {what}"))
}

/// What tests look at: the rows of our runs, under one reading of the paper, and the printed numbers.
#[derive(Clone, Copy, Debug)]
pub struct Data<'a> {
    /// The rows of our runs.
    pub evidence: &'a Evidence,
    /// The printed numbers.
    pub published: &'a [Published],
    /// The tables of the paper, for their larger forms.
    pub tables: &'a [Table],
    /// Id of the choice under which the claims are judged; `None` for the tables as they are.
    pub choice: Option<&'a str>,
}

impl<'a> Data<'a> {
    /// The rows of a table without a sweep.
    fn section(&self, table: &str) -> Result<&'a Section, Verdict> {
        let not_run = || verdict(Ruling::NotRun, format!("`{table}` was not run; `--full` runs every table"));
        let first = |table: &str| self.evidence.sections(self.choice, table).and_then(<[Section]>::first);
        larger_form(self.tables, table).and_then(first).or_else(|| first(table)).ok_or_else(not_run)
    }

    /// The rows of a stack in a table without a sweep.
    fn stack(&self, place: &Place) -> Result<&'a StackRows, Verdict> {
        let section = self.section(&place.table)?;
        let found = section.stacks.iter().find(|rows| rows.name == place.stack);
        found.ok_or_else(|| missing(&format!("`{}` in `{}`", place.stack, place.table)))
    }

    /// The printed mean of a metric of a stack.
    fn printed(&self, place: &Place, metric: &str) -> Option<&'a Published> {
        self.published.iter().find(|number| {
            (number.table.as_str(), number.stack.as_str(), number.metric.as_str())
                == (&place.table, &place.stack, metric)
                && number.quantity == Quantity::Mean
                && number.number().is_some()
        })
    }
}

/// Checks the name of a metric.
pub(super) fn check_metric(name: &str) -> Result<(), String> {
    if name == SUCCESS { Ok(()) } else { metric_column(name).map(|_| ()).map_err(|error| error.to_string()) }
}

/// The joint verdict of parts: holds if all hold, fails if one fails, else undecided.
///
/// The p-value of "all hold" is the largest one (an intersection-union test, Berger 1982); that of "one fails" the smallest of the
/// failing ones, times the number of parts.
fn together(verdicts: Vec<Verdict>) -> Verdict {
    let count = |ruling: Ruling| verdicts.iter().filter(|verdict| verdict.ruling == ruling).count();
    let ruling = if verdicts.is_empty() {
        return missing("no rows");
    } else if count(Ruling::Fails) > 0 {
        Ruling::Fails
    } else if count(Ruling::NotRun) > 0 {
        Ruling::NotRun
    } else if count(Ruling::Holds) == verdicts.len() {
        Ruling::Holds
    } else {
        Ruling::Undecided
    };
    let of = |wanted: &dyn Fn(Ruling) -> bool| {
        verdicts.iter().filter(move |part| wanted(part.ruling)).map(|part| part.p).collect::<Option<Vec<f64>>>()
    };
    let p = if ruling == Ruling::Fails {
        let smallest = of(&|part| part == Ruling::Fails).and_then(|p| p.into_iter().reduce(crate::math::min));
        smallest.map(|p| crate::math::min(1.0, p * verdicts.len() as f64))
    } else {
        of(&|_| true).and_then(|p| p.into_iter().reduce(crate::math::max))
    };
    let why = |part: &Verdict| {
        if verdicts.len() == 1 { part.why.clone() } else { format!("{} ({})", part.why, part.ruling.words()) }
    };
    Verdict { ruling, why: verdicts.iter().map(why).collect::<Vec<_>>().join("; "), p }
}
