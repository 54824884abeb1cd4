//! A run against an older one: rows that changed, and regressions.

use super::pair::correct;
use super::{ALPHA, Comparison, Gate, Section, StackRows, compare_pairs};
use crate::analysis::Better;
use crate::results::metric_column;
use crate::settings::quantity::counted;

/// Comparison of a newer run with an older one.
#[derive(Clone, Debug)]
pub struct Baseline {
    /// Number of rows that both runs have.
    pub rows: u64,
    /// Rows whose trace changed: (point, stack, episode).
    pub moved: Vec<(u32, String, u64)>,
    /// Number of rows of the older run that the newer one lacks.
    pub missing: u64,
    /// Number of rows that only the newer run has.
    pub added: u64,
    /// Number of rows of both runs whose worlds differ; they are not compared.
    pub other_worlds: u64,
    /// Tests of new against old for each stack that changed; `reference` is the old run.
    pub comparisons: Vec<Comparison>,
    /// Regressions in words; empty if nothing got worse.
    pub regressions: Vec<String>,
}

/// Two runs that are not of one scenario: the title of each with its scenario.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{}` is a run of `{}`, `{}` of `{}`", old.0, old.1, new.0, new.1)]
pub struct OtherScenario {
    /// The older run.
    pub old: (String, String),
    /// The newer run.
    pub new: (String, String),
}

/// Compares a run with an older one of the same scenario, stack by stack on the same worlds.
///
/// A regression is a test that is significant after Holm's correction over all stacks and metrics of the gate, points the wrong way
/// (less success, longer, slower, less clearance) and is larger than the gate's margin, a planner that crashes where it did not, a missing row, or that no world is the baseline's, so that nothing was compared. Points of a sweep are
/// matched by the values of their keys, of those that touch a stack. Rows of equal number whose worlds differ are counted and left out of the tests.
///
/// # Errors
/// If the runs are of different scenarios.
pub fn compare_baseline(old: &[Section], new: &[Section], gate: &Gate) -> Result<Baseline, OtherScenario> {
    if let (Some(old), Some(new)) = (old.first(), new.first())
        && old.scenario != new.scenario
    {
        let name = |section: &Section| (section.title.clone(), section.scenario.clone());
        return Err(OtherScenario { old: name(old), new: name(new) });
    }
    let mut result = Baseline {
        rows: 0,
        moved: Vec::new(),
        missing: 0,
        added: 0,
        other_worlds: 0,
        comparisons: Vec::new(),
        regressions: Vec::new(),
    };
    let keys = |section: &Section| section.swept.iter().map(|(key, _)| key.clone()).collect::<Vec<String>>();
    let find = |sections: &[Section], point: &Section, stack: &StackRows| -> Option<StackRows> {
        let sections = sections.iter().filter(|section| keys(section) == keys(point));
        sections.flat_map(|section| &section.stacks).find(|other| other.is_same_setting(stack)).cloned()
    };
    for section in old {
        // Copies of an episode are no evidence; their rows are compared all the same.
        let (distinct, _) = section.without_copies();
        for (before, once) in section.stacks.iter().zip(&distinct.stacks) {
            let Some(after) = find(new, section, before) else {
                result.missing += before.rows.len() as u64;
                continue;
            };
            let mut crashes = 0;
            let moved_before = result.moved.len();
            for (world, row) in &before.rows {
                let Some(now) = after.rows.get(world) else {
                    result.missing += 1;
                    continue;
                };
                result.rows += 1;
                if now.world_digest != row.world_digest {
                    result.other_worlds += 1;
                }
                if now.trace_digest != row.trace_digest || now.outcome != row.outcome {
                    result.moved.push((section.point, before.name.clone(), row.episode));
                }
                crashes += u64::from(now.outcome.is_crash() && !row.outcome.is_crash());
            }
            if crashes > 0 {
                result.regressions.push(format!(
                    "{} crashes in {} in which it did not",
                    before.name,
                    counted(crashes, "episode")
                ));
            }
            if result.moved.len() > moved_before {
                result.comparisons.extend(compare_pairs(once, &after));
            }
        }
    }
    for section in new {
        for after in &section.stacks {
            let before = find(old, section, after);
            let is_new = |world: &&(u64, u64)| before.as_ref().is_none_or(|before| !before.rows.contains_key(*world));
            result.added += after.rows.keys().filter(is_new).count() as u64;
        }
    }
    result.comparisons.retain(|comparison| gate.counts(comparison.metric));
    correct(&mut result.comparisons);
    if result.missing > 0 {
        result.regressions.push(format!("{} of the baseline missing", counted(result.missing, "row")));
    }
    if result.rows > 0 && result.other_worlds == result.rows {
        result.regressions.push("every world differs from the baseline's, so nothing was compared".to_owned());
    }
    for comparison in &result.comparisons {
        // Success is no metric; more of it is better.
        let better = metric_column(comparison.metric).map_or(Some(Better::Higher), |column| column.better);
        let worse = comparison.difference.is_some_and(|difference| match better {
            Some(Better::Higher) => difference < 0.0,
            Some(Better::Lower) => difference > 0.0,
            None => false,
        });
        let (stack, metric) = (&comparison.stack, comparison.metric);
        let difference = comparison.difference.unwrap_or_default();
        if worse && comparison.p_holm <= ALPHA && difference.abs() > gate.margin(metric, comparison.reference_mean) {
            result.regressions.push(format!("{stack}: {metric} by {difference:+.3} (p = {:.2e})", comparison.p_holm));
        }
    }
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::super::tests::section;
    use super::*;

    #[test]
    fn equal_runs_have_not_moved_and_nothing_is_tested() {
        let old = section(&[("a", "ssssf", &[1.0, 2.0, 3.0, 4.0])]);
        let found = compare_baseline(std::slice::from_ref(&old), std::slice::from_ref(&old), &Gate::default()).unwrap();
        assert_eq!((found.rows, found.moved.len(), found.missing, found.added), (5, 0, 0, 0));
        assert!(found.comparisons.is_empty() && found.regressions.is_empty());
    }

    #[test]
    fn what_is_smaller_than_the_margin_or_not_of_the_gate_is_no_regression() {
        let times: Vec<f64> = (0..30).map(|k| 20.0 + f64::from(k)).collect();
        let longer: Vec<f64> = times.iter().map(|time| 1.02 * time).collect();
        let old = section(&[("a", &"s".repeat(30), &times)]);
        let mut new = section(&[("a", &"s".repeat(30), &longer)]);
        new.stacks[0]
            .rows
            .values_mut()
            .for_each(|row| row.trace_digest = Some(crate::results::Digest(100 + row.episode)));
        let regressions = |metrics: &[&str], margins: &[&str]| {
            let own = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
            let gate = Gate::new(&own(metrics), &own(margins)).unwrap();
            compare_baseline(std::slice::from_ref(&old), std::slice::from_ref(&new), &gate).unwrap().regressions.len()
        };
        // Two per cent of a mean of 34.5 m are 0.69 m.
        let length = ["length_m"];
        assert_eq!((regressions(&length, &[]), regressions(&length, &["length_m=3%"])), (1, 0));
        assert_eq!((regressions(&length, &["length_m=1%"]), regressions(&length, &["length_m=0.6"])), (1, 1));
        assert_eq!((regressions(&["success"], &[]), regressions(&length, &["time_s=90%"])), (0, 1));
    }

    #[test]
    fn fewer_successes_are_a_regression_and_more_are_not() {
        let (good, bad) = ("s".repeat(30), "f".repeat(15) + &"s".repeat(15));
        let (good, bad) = (section(&[("a", &good, &[])]), section(&[("a", &bad, &[])]));
        let worse =
            compare_baseline(std::slice::from_ref(&good), std::slice::from_ref(&bad), &Gate::default()).unwrap();
        assert_eq!(worse.moved.len(), 15);
        assert!(worse.regressions.len() == 1 && worse.regressions[0].contains("a: success by -50"), "{worse:?}");
        let better =
            compare_baseline(std::slice::from_ref(&bad), std::slice::from_ref(&good), &Gate::default()).unwrap();
        assert!(better.regressions.is_empty() && better.moved.len() == 15);
    }

    #[test]
    fn missing_rows_are_a_regression_and_new_ones_are_counted() {
        let (old, new) = (section(&[("a", "ssss", &[])]), section(&[("a", "sss", &[]), ("b", "ss", &[])]));
        let found = compare_baseline(&[old], &[new], &Gate::default()).unwrap();
        assert_eq!((found.missing, found.added), (1, 2));
        assert_eq!(found.regressions, ["1 row of the baseline missing"]);
    }

    #[test]
    fn points_are_matched_by_their_values_and_worlds_by_their_digests() {
        let point = |value: &str, number: u32, ends: &str| {
            let mut point = section(&[("a", ends, &[])]);
            point.swept = vec![("robot.radius_m".to_owned(), value.to_owned())];
            point.stacks[0].values = vec![value.to_owned()];
            point.point = number;
            point
        };
        let old = [point("0.2", 0, "ssss"), point("0.3", 1, "ffff")];
        let new = [point("0.3", 0, "ffff"), point("0.2", 1, "ssss")];
        let found = compare_baseline(&old, &new, &Gate::default()).unwrap();
        assert_eq!((found.rows, found.moved.len(), found.missing, found.added), (8, 0, 0, 0));

        let mut other = section(&[("a", "fsss", &[])]);
        other.stacks[0].rows.values_mut().for_each(|row| row.world_digest = Some(crate::results::Digest(1)));
        let found = compare_baseline(&[section(&[("a", "ssss", &[])])], &[other], &Gate::default()).unwrap();
        assert_eq!((found.rows, found.other_worlds), (4, 4));
        assert!(found.comparisons.iter().all(|comparison| comparison.n == 0), "other worlds are no pairs");
        assert_eq!(found.regressions, ["every world differs from the baseline's, so nothing was compared"]);

        let mut another = section(&[("a", "ssss", &[])]);
        another.scenario = "elsewhere".to_owned();
        assert!(compare_baseline(&old, &[another], &Gate::default()).unwrap_err().to_string().contains("`elsewhere`"));
    }
}
