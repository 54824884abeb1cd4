//! The points of a sweep against each other: a ranking of settings, and tests of each against the best.

use super::pair::{SUCCESS, compare_unpaired, correct, outcomes};
use super::{ALPHA, Comparison, Section, StackRows, Table, compare_pairs, compared_name};
use crate::analysis::{Better, Ranking, fisher_exact, holm, mcnemar_exact, pairs};
use crate::command::quoted;
use crate::results::{SummaryRow, summarise_rows};
use crate::settings::choice::NameError;

/// The metrics that settings are tested by if none are named: those that rank them.
const RANKING: [&str; 2] = [SUCCESS, "time_s"];

/// The settings of a sweep from best to worst.
#[derive(Clone, Debug)]
pub struct PointRanking {
    /// The file.
    pub title: String,
    /// The swept keys.
    pub keys: Vec<String>,
    /// What the settings are tested by: `success` or columns of metrics.
    pub metrics: Vec<&'static str>,
    /// The settings, best first.
    pub ranked: Vec<RankedPoint>,
    /// Number of episodes that differ in anything.
    pub distinct: u64,
    /// Number of episodes that are copies of others to the last bit and do not count.
    pub copies: u64,
}

/// One setting: a stack at the first point that has its values.
#[derive(Clone, Debug)]
pub struct RankedPoint {
    /// Number of the point.
    pub point: u32,
    /// Values of the swept keys; empty if a key does not concern the stack.
    pub values: Vec<String>,
    /// Statistics of its rows, with the name of its stack.
    pub summary: SummaryRow,
    /// Letters of the groups of settings that the data cannot tell apart by success.
    pub letters: String,
    /// Tests against the best, one for each metric of the ranking; empty for the best itself.
    pub tests: Vec<Comparison>,
    /// Whether it met the worlds of the best. If not, its tests are of independent samples.
    pub is_paired: bool,
}

/// Reason why the points of a table cannot be ranked.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PointsError {
    /// A metric that is not compared.
    #[error(transparent)]
    Metric(#[from] NameError),
    /// Nothing to compare.
    #[error("`{0}` has one setting alone, no sweep: there is nothing to compare it with")]
    Alone(String),
}

/// Ranks the settings of a sweep by success, equal ones by their mean time, then in the order of the table.
///
/// A setting is a stack with its values of the swept keys; each has run once. All are tested against the best by `metrics` (by
/// success and time if there are none), Holm's correction over all tests together. Settings in the same worlds are compared in
/// pairs; one whose worlds differ from those of the best (a swept key changed them) as independent samples. The letters are a family of their own: all pairs by
/// success. The best is chosen by the same worlds that it is tested on, so its figures are too good on average: a run with
/// another seed says what it is worth.
///
/// # Errors
/// If a metric is not one that is compared, or the table holds a single setting.
pub fn rank_points(table: &Table, metrics: &[String]) -> Result<PointRanking, PointsError> {
    let metrics: Vec<&'static str> = if metrics.is_empty() {
        RANKING.to_vec()
    } else {
        metrics.iter().map(|name| compared_name(name)).collect::<Result<_, _>>()?
    };
    let title = table.path.display().to_string();
    let points: Vec<u32> =
        table.sections.iter().flat_map(|section| vec![section.point; section.stacks.len()]).collect();
    let stacks = table.sections.iter().flat_map(|section| &section.stacks).cloned().collect();
    let whole = Section { title: title.clone(), scenario: String::new(), point: 0, swept: Vec::new(), stacks };
    let (Section { stacks, .. }, copies) = whole.without_copies();
    if stacks.len() < 2 {
        return Err(PointsError::Alone(title));
    }
    let mut settings: Vec<(u32, StackRows, SummaryRow)> = points
        .into_iter()
        .zip(stacks)
        .filter_map(|(point, stack)| Some((point, summarise_rows(stack.rows.values())?, stack)))
        .map(|(point, summary, stack)| (point, stack, summary))
        .collect();
    let time = |summary: &SummaryRow| summary.metric("time_s").mean.unwrap_or(f64::INFINITY);
    settings.sort_by(|(_, a, summary_a), (_, b, summary_b)| {
        b.success_rate().total_cmp(&a.success_rate()).then(time(summary_a).total_cmp(&time(summary_b)))
    });

    let rates: Vec<f64> = settings.iter().map(|(_, stack, _)| stack.success_rate()).collect();
    let p: Vec<f64> = pairs(settings.len()).map(|(a, b)| p_of_success(&settings[a].1, &settings[b].1)).collect();
    let letters = Ranking::new(&rates, Better::Higher, &holm(&p), ALPHA).letters();

    let distinct = settings.iter().map(|(_, stack, _)| stack.rows.len() as u64).max().unwrap_or(0);
    let best = settings[0].1.clone();
    let tests_of = |stack: &StackRows| {
        if stack.is_of_same_worlds(&best) { compare_pairs(&best, stack) } else { compare_unpaired(&best, stack) }
    };
    let is_sample = copies == 0 || distinct > 1;
    let mut tests: Vec<Comparison> = settings[1..]
        .iter()
        .filter(|_| is_sample)
        .flat_map(|(_, stack, _)| tests_of(stack))
        .filter(|test| metrics.contains(&test.metric))
        .collect();
    correct(&mut tests);
    let mut tests = tests.into_iter();
    let ranked = settings.into_iter().zip(letters).enumerate().map(|(rank, ((point, stack, summary), letters))| {
        let count = if rank > 0 { metrics.len() } else { 0 };
        RankedPoint {
            point,
            is_paired: stack.is_of_same_worlds(&best),
            values: stack.values,
            summary,
            letters,
            tests: tests.by_ref().take(count).collect(),
        }
    });
    Ok(PointRanking {
        title,
        keys: table
            .sections
            .first()
            .map_or_else(Vec::new, |section| section.swept.iter().map(|(key, _)| key.clone()).collect()),
        ranked: ranked.collect(),
        metrics,
        distinct,
        copies,
    })
}

/// McNemar's exact test on the same worlds, Fisher's exact test otherwise.
fn p_of_success(a: &StackRows, b: &StackRows) -> f64 {
    if a.is_of_same_worlds(b) {
        return mcnemar_exact(outcomes(a, b));
    }
    let row = |stack: &StackRows| {
        let rated = stack.rows.values().filter(|row| row.outcome.is_rated()).count() as u64;
        [stack.successes(), rated - stack.successes()]
    };
    fisher_exact([row(a), row(b)])
}

impl PointRanking {
    /// The arguments of `simrun` that make the best setting out of the swept scenario.
    pub fn best_arguments(&self) -> String {
        let Some(best) = self.ranked.first() else { return String::new() };
        let mut arguments = "--set 'sweep={}'".to_owned();
        for (key, value) in self.keys.iter().zip(&best.values).filter(|(_, value)| !value.is_empty()) {
            arguments += &format!(" --set {}", quoted(format!("{key}={value}")));
        }
        arguments + &format!(" --stack {}", quoted(&best.summary.stack))
    }

    /// How many worlds would tell the first two apart, in words: by success, or by time where they succeed equally often.
    pub fn worlds_needed(&self) -> String {
        let Some(second) = self.ranked.get(1).filter(|second| !second.tests.is_empty()) else { return String::new() };
        let names = format!("The best and the second (points {} and {})", self.ranked[0].point, second.point);
        if !second.is_paired {
            return format!("{names} are in different worlds; how many would tell them apart is not computed.");
        }
        let differs = |test: &&Comparison| test.difference.is_some_and(|difference| difference != 0.0);
        let Some(test) = second.tests.iter().find(differs) else {
            return format!("{names} are equal in all that is compared: no number of worlds tells them apart.");
        };
        let unit = if test.metric == SUCCESS { " points" } else { "" };
        let difference = format!("{} by {:+.3}{unit}", test.metric, test.difference.unwrap_or_default());
        if test.p_holm <= ALPHA {
            return format!("{names} are told apart by these worlds: {difference}.");
        }
        match test.pairs_needed() {
            Some(needed) => format!(
                "{names} differ in {difference}: if that is the truth, about {needed} worlds show it with a power of 80 % (one test at 5 %)."
            ),
            None => format!("{names} differ in {difference}: too little for any number of worlds to show."),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::section;
    use super::*;
    use crate::results::Digest;
    use std::path::PathBuf;

    /// One stack at points with the values of one key: outcomes and lengths; the time is twice the length.
    fn sweep(points: &[(&str, &str, &[f64])]) -> Table {
        let sections = points.iter().enumerate().map(|(number, &(value, ends, lengths))| {
            let mut section = section(&[("a_star+dwa", ends, lengths)]);
            section.point = number as u32;
            section.swept = vec![("robot.radius_m".to_owned(), value.to_owned())];
            section.stacks[0].values = vec![value.to_owned()];
            section
        });
        Table {
            path: PathBuf::from("made_up"),
            sections: sections.collect(),
            missing: Vec::new(),
            is_altered: false,
            identity: None,
        }
    }

    #[test]
    fn settings_are_ranked_by_success_then_time_and_tested_against_the_best() {
        let ends = "s".repeat(30);
        let slow: Vec<f64> = (0..30).map(|k| 20.0 + f64::from(k)).collect();
        let fast: Vec<f64> = slow.iter().map(|x| x - 1.0).collect();
        let bad = "f".repeat(15) + &"s".repeat(15);
        let table =
            sweep(&[("0.3", &bad, &fast), ("0.2", &ends, &slow), ("[1, 2]", &ends, &fast), ("0.1", &ends, &slow)]);
        let found = rank_points(&table, &[]).unwrap();
        let order: Vec<u32> = found.ranked.iter().map(|point| point.point).collect();
        assert_eq!(order, [2, 1, 3, 0], "equal ones in the order of the table");
        let letters: Vec<&str> = found.ranked.iter().map(|point| point.letters.as_str()).collect();
        assert_eq!(letters, ["a", "a", "a", "b"]);
        assert!(found.ranked[0].tests.is_empty());
        let tests: Vec<&Comparison> = found.ranked.iter().flat_map(|point| &point.tests).collect();
        assert_eq!(tests.len(), 6, "success and time of three");
        // Thirty differences of one sign: p = 2 · 2⁻³⁰, the smallest two of six tests and ties.
        let time = &found.ranked[1].tests[1];
        assert!(
            (time.difference, time.metric) == (Some(2.0), "time_s")
                && (time.p_holm / (12.0 / (1u64 << 30) as f64) - 1.0).abs() < 1e-9
        );
        assert_eq!(found.best_arguments(), "--set 'sweep={}' --set 'robot.radius_m=[1, 2]' --stack a_star+dwa");
        assert!(
            found.worlds_needed().contains("are told apart by these worlds: time_s by +2.000"),
            "{}",
            found.worlds_needed()
        );
        let only = rank_points(&table, &["success".to_owned()]).unwrap();
        assert!(only.worlds_needed().contains("equal in all that is compared"), "{}", only.worlds_needed());
        assert!(rank_points(&table, &["succes".to_owned()]).unwrap_err().to_string().contains("`success`"));
    }

    #[test]
    fn the_worlds_needed_are_those_of_connors_formula() {
        // 30 against 27 of 30: δ = ψ = 0.1, so that (1.959964 √0.1 + 0.841621 √0.09)² / 0.01 = 76.1.
        let table = sweep(&[("1", &("fff".to_owned() + &"s".repeat(27)), &[]), ("2", &"s".repeat(30), &[])]);
        let said = rank_points(&table, &[]).unwrap().worlds_needed();
        assert!(said.contains("success by -10.000 points") && said.contains("about 77 worlds"), "{said}");
    }

    #[test]
    fn points_in_other_worlds_are_independent_samples() {
        let mut table = sweep(&[("1", &"s".repeat(20), &[]), ("2", &("f".repeat(10) + &"s".repeat(10)), &[])]);
        table.sections[1].stacks[0].rows.values_mut().for_each(|row| row.world_digest = Some(Digest(row.episode)));
        let found = rank_points(&table, &[]).unwrap();
        let second = &found.ranked[1];
        assert!(!second.is_paired && second.tests[0].test == "Fisher, exact" && second.tests[0].n == 40);
        assert!((second.tests[0].p - fisher_exact([[20, 0], [10, 10]])).abs() < 1e-12);
        assert!(found.worlds_needed().contains("different worlds"));
    }

    #[test]
    fn one_setting_is_no_sweep() {
        let table = sweep(&[("1", "ssf", &[])]);
        assert_eq!(rank_points(&table, &[]).unwrap_err(), PointsError::Alone("made_up".to_owned()));
    }
}
