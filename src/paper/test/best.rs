//! One stack against each other stack of a table, on the same worlds: the shortest, the fastest, the safest of all.
//!
//! Each comparison is that of `compare`. Holds if it holds against each of the others, fails if one of them is better, the p-values
//! corrected by Holm over the others; undecided otherwise.

use super::compare::{Difference, pairs};
use super::{Data, Entry, Kind, Over, Place, Relation, Ruling, Use, Verdict, check_metric, missing, verdict};
use crate::analysis::holm;
use crate::comparison::ALPHA;
use crate::math;
use crate::paper::Paper;
use crate::paper::published::SUCCESS;
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "one stack against each other stack of a table" };

/// Which stack, by which metric.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The metric.
    pub metric: String,
    /// The stack that should be the best.
    pub of: Place,
    /// Whether the best has less or more.
    pub is: Relation,
    /// Stacks of the table that do not count; default none.
    #[serde(default)]
    pub except: Vec<String>,
    /// The worlds of each comparison; default `both_solved`.
    #[serde(default)]
    pub over: Over,
}

impl Kind for Params {
    fn check(&self, paper: &Paper) -> Result<(), String> {
        check_metric(&self.metric)?;
        paper.known(&self.of.table)?;
        if self.is == Relation::Equal {
            return Err("the best has `less` or `more`".to_owned());
        }
        Ok(())
    }

    fn uses(&self) -> Vec<Use<'_>> {
        vec![self.of.used(), Use { table: &self.of.table, stack: None }]
    }

    fn judge(&self, data: &Data<'_>) -> Verdict {
        self.judged(data).unwrap_or_else(|verdict| verdict)
    }
}

impl Params {
    fn judged(&self, data: &Data<'_>) -> Result<Verdict, Verdict> {
        let of = data.stack(&self.of)?;
        let section = data.section(&self.of.table)?;
        let counts = |name: &String| *name != self.of.stack && !self.except.contains(name);
        let others: Vec<_> = section.stacks.iter().filter(|stack| counts(&stack.name)).collect();
        if others.is_empty() {
            return Err(missing("no other stack"));
        }
        let differences = others
            .iter()
            .map(|other| Difference::of(&pairs(of, other, &self.metric, self.over), self.metric == SUCCESS));
        let differences = differences.collect::<Result<Vec<Difference>, Verdict>>()?;
        let adjusted = holm(&differences.iter().map(|found| found.p).collect::<Vec<f64>>());
        let rulings: Vec<Ruling> = differences.iter().map(|found| found.ruling(self.is)).collect();
        let fails = || rulings.iter().zip(&adjusted).filter(|(ruling, p)| **ruling == Ruling::Fails && **p <= ALPHA);
        let won = rulings.iter().filter(|ruling| **ruling == Ruling::Holds).count();
        let (ruling, p) = if let Some(p) = fails().map(|(_, p)| *p).reduce(math::min) {
            (Ruling::Fails, p)
        } else {
            let largest = differences.iter().map(|found| found.p).fold(0.0, math::max);
            (if won == others.len() { Ruling::Holds } else { Ruling::Undecided }, largest)
        };
        let rest = others.iter().zip(&differences).zip(&rulings).filter(|(_, ruling)| **ruling != Ruling::Holds);
        let rest = rest.map(|((other, found), _)| format!("; against {} {}", other.name, found.text()));
        let word = if self.is == Relation::Less { "less" } else { "more" };
        let why = format!("{word} than {won} of {}{}", others.len(), rest.collect::<String>());
        Ok(verdict(ruling, why).with_p(p))
    }
}
