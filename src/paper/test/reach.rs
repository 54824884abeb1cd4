//! Our success rate reaches the published one: the lower end of our Wilson 95 % interval is at least that of the published count.
//!
//! Fails if the upper end of ours is below the published lower end, undecided otherwise. The published count is that of the table whose
//! id is this one's up to its first `_`: `table3_replan` is asked for what is printed of `table3`. Where a table with more worlds was
//! run, that one decides.

use super::{Data, Entry, Kind, Place, Use, Verdict, missing, p_of_rate, verdict, within};
use crate::analysis::{Z_95, wilson};
use crate::comparison::StackRows;
use crate::paper::Paper;
use crate::paper::published::{SUCCESS, mean_of};
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "our success rate reaches the published one" };

/// Where.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The stack; its published success rate must be in the CSV, with its trials.
    pub of: Place,
    /// Id of a table with more worlds and the same stack, which counts instead wherever it was run; default none.
    #[serde(default)]
    pub larger: Option<String>,
}

impl Params {
    /// The stack in the larger table, if there is one.
    fn in_larger(&self) -> Option<Place> {
        Some(Place { table: self.larger.clone()?, stack: self.of.stack.clone() })
    }

    /// The rows that decide.
    pub(in crate::paper) fn rows<'a>(&self, data: &Data<'a>) -> Result<&'a StackRows, Verdict> {
        match self.in_larger().map(|place| data.stack(&place)) {
            Some(Ok(rows)) => Ok(rows),
            _ => data.stack(&self.of),
        }
    }
}

impl Kind for Params {
    fn check(&self, paper: &Paper) -> Result<(), String> {
        self.larger.iter().chain([&self.of.table]).try_for_each(|table| paper.known(table))
    }

    fn uses(&self) -> Vec<Use<'_>> {
        let larger = self.larger.as_deref().map(|table| Use { table, stack: Some(&self.of.stack) });
        larger.into_iter().chain([self.of.used()]).collect()
    }

    fn judge(&self, data: &Data<'_>) -> Verdict {
        self.judged(data).unwrap_or_else(|verdict| verdict)
    }
}

impl Params {
    fn judged(&self, data: &Data<'_>) -> Result<Verdict, Verdict> {
        let base = self.of.table.split('_').next().unwrap_or(&self.of.table);
        let place = Place { table: base.to_owned(), stack: self.of.stack.clone() };
        let theirs = data.printed(&place, SUCCESS).and_then(|number| Some((&number.value, number.counts()?)));
        let (printed, (k, trials)) = theirs.ok_or_else(|| missing("no published count"))?;
        let ours = mean_of(self.rows(data)?, SUCCESS).ok_or_else(|| missing("no rows"))?;
        let (low, high) = ours.interval.unwrap_or((ours.value, ours.value));
        let (limit, _) = wilson(k, trials, Z_95).unwrap_or_default();
        let limit = 100.0 * limit;
        let why = format!(
            "ours {:.1} % [{low:.1}, {high:.1}] of {}; published {printed} %, about {k} of {trials}, lower limit {limit:.1} %",
            ours.value, ours.n,
        );
        let p = p_of_rate(ours.value, limit, ours.n);
        Ok(verdict(within((low, high), limit, f64::INFINITY), why).with_p(p))
    }
}
