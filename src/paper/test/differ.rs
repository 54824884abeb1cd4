//! Stacks differ on one world: holds if in some world the largest and the smallest value are further apart than the tolerance.

use super::{Data, Entry, Kind, Ruling, Use, Verdict, check_metric, missing, verdict, worlds};
use crate::comparison::StackRows;
use crate::math;
use crate::paper::Paper;
use crate::paper::published::value;
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "stacks differ on one world" };

/// Which stacks, by which metric.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The metric, looked at wherever it is defined for all of the stacks.
    pub metric: String,
    /// Ids of the tables.
    pub tables: Vec<String>,
    /// Names of the stacks, the same in each table.
    pub stacks: Vec<String>,
    /// Difference up to which two numbers are equal; default 0.
    #[serde(default)]
    pub tolerance: f64,
}

impl Kind for Params {
    fn check(&self, paper: &Paper) -> Result<(), String> {
        check_metric(&self.metric)?;
        self.tables.iter().try_for_each(|table| paper.known(table))
    }

    fn uses(&self) -> Vec<Use<'_>> {
        let of = |table| self.stacks.iter().map(move |stack| Use { table, stack: Some(stack) });
        self.tables.iter().flat_map(|table| of(table)).collect()
    }

    fn judge(&self, data: &Data<'_>) -> Verdict {
        self.judged(data).unwrap_or_else(|verdict| verdict)
    }
}

impl Params {
    fn judged(&self, data: &Data<'_>) -> Result<Verdict, Verdict> {
        let (mut count, mut widest) = (0, 0.0);
        for table in &self.tables {
            let section = data.section(table)?;
            let stacks: Vec<&StackRows> =
                self.stacks.iter().filter_map(|name| section.stacks.iter().find(|stack| stack.name == *name)).collect();
            let Some(first) = stacks.first().filter(|_| stacks.len() == self.stacks.len()) else {
                return Err(missing(&format!("not all of these stacks ran in {table}")));
            };
            for world in first.rows.keys() {
                let values: Vec<f64> =
                    stacks.iter().filter_map(|stack| value(stack.rows.get(world)?, &self.metric)).collect();
                if values.len() == stacks.len() {
                    count += 1;
                    let low = values.iter().copied().fold(f64::INFINITY, math::min);
                    let high = values.iter().copied().fold(f64::NEG_INFINITY, math::max);
                    widest = math::max(widest, high - low);
                }
            }
        }
        let ruling = if count == 0 {
            Ruling::Undecided
        } else if widest > self.tolerance {
            Ruling::Holds
        } else {
            Ruling::Fails
        };
        Ok(verdict(ruling, format!("largest difference {widest:.3} in {}", worlds(count))))
    }
}
