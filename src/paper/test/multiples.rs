//! Every published success rate of a table is, to the printed digit, a whole number of its trials.

use super::{Data, Entry, Kind, Ruling, Use, Verdict, missing, verdict};
use crate::paper::Paper;
use crate::paper::published::{Published, Quantity, SUCCESS};
use serde::Deserialize;

pub(super) const ENTRY: Entry = Entry { summary: "every printed rate is a whole number of trials" };

/// Which table.
#[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Id of the table.
    pub table: String,
    /// Digits after the point of a printed percentage; default 1.
    #[serde(default = "one")]
    pub decimals: u32,
}

fn one() -> u32 {
    1
}

impl Kind for Params {
    fn check(&self, paper: &Paper) -> Result<(), String> {
        paper.known(&self.table)
    }

    fn uses(&self) -> Vec<Use<'_>> {
        Vec::new()
    }

    fn judge(&self, data: &Data<'_>) -> Verdict {
        let step = (0..self.decimals).fold(1.0, |step, _| step / 10.0);
        let rates: Vec<(f64, u64)> = data
            .published
            .iter()
            .filter(|number| {
                number.table == self.table && number.metric == SUCCESS && number.quantity == Quantity::Mean
            })
            .filter_map(|number: &Published| Some((number.number()?, number.trials?)))
            .collect();
        let is_whole = |rate: f64, trials: u64| {
            let nearest = (rate * trials as f64 / 100.0).round();
            // A printed number is half a step away from the true one at most.
            (100.0 * nearest / trials as f64 - rate).abs() <= 0.5 * step + 1e-9
        };
        let odd: Vec<String> = rates
            .iter()
            .filter(|(rate, trials)| !is_whole(*rate, *trials))
            .map(|(rate, _)| format!("{rate}"))
            .collect();
        match (rates.len(), odd.as_slice()) {
            (0, _) => missing("no published rates"),
            (n, []) => verdict(Ruling::Holds, format!("all {n} are")),
            (n, _) => verdict(Ruling::Fails, format!("{} of {n} are not: {}", odd.len(), odd.join(", "))),
        }
    }
}
