//! Comparisons of stacks with each other, and of runs with older runs, from rows of `episodes.csv` paired by
//! world.
//!
//! The statistics themselves are in [`analysis`](crate::analysis); here rows become pairs, pairs become tests, and tests
//! become tables. Nothing is pooled: every file and every point of a sweep is a section of its own.

mod baseline;
mod equivalence;
mod gate;
mod latex;
mod margin;
mod pair;
mod points;
mod read;
mod render;
mod render_points;

pub use baseline::{Baseline, OtherScenario, compare_baseline};
pub use equivalence::EquivalenceTest;
pub use gate::Gate;
pub use margin::{Margin, MarginError, Margins};
pub use pair::{Comparison, compare_pairs};
pub use points::{PointRanking, PointsError, RankedPoint, rank_points};
pub use read::{Section, StackRows, Table, TableError, read_table};
pub use render::{Format, comparison_table, render, report_json, table, tests_json};
pub use render_points::{points_json, render_points};

use crate::analysis::{Better, Ranking, holm, mcnemar_exact, pairs};
use crate::results::{Column, SummaryRow, metric_column, summarise_rows};
use crate::settings::choice::NameError;
use pair::{SUCCESS, compare_unpaired, correct, outcomes};

/// The error rate of the whole family of tests of a section.
pub const ALPHA: f64 = 0.05;

/// The columns by which stacks are compared, on the worlds that both solved.
pub const COMPARED: [&str; 3] = ["length_m", "time_s", "clearance_min_m"];

/// Those columns, from the table of columns.
fn compared() -> [&'static Column; COMPARED.len()] {
    COMPARED.map(|name| metric_column(name).expect("a column of the table, as a test asserts"))
}

/// Analysis of one section.
#[derive(Clone, Debug)]
pub struct Report {
    /// Source of the rows, and the point of the sweep to which they belong.
    pub title: String,
    /// Summary of each stack.
    pub stacks: Vec<SummaryRow>,
    /// The tests.
    pub comparisons: Vec<Comparison>,
    /// The tests of equivalence that were asked for.
    pub equivalences: Vec<EquivalenceTest>,
    /// Groups of stacks that the data cannot tell apart by success: the letters of each stack.
    pub letters: Vec<String>,
    /// Whether pairs of the same worlds were compared.
    pub paired: bool,
    /// Episodes that differ in anything.
    pub distinct: u64,
    /// Episodes that are copies of others to the last bit and do not count.
    pub copies: u64,
}

/// Choice of the comparisons that are made.
#[derive(Clone, Debug, Default)]
pub struct Pairing {
    /// The stack with which the others are compared; `None` for the first one.
    pub reference: Option<String>,
    /// Whether every stack is compared with every other.
    pub all_pairs: bool,
    /// Whether Fisher's exact test and rank sums of independent samples are used, as in some papers, instead of pairs.
    pub unpaired: bool,
    /// Margins up to which stacks count as equivalent; tests of equivalence are of pairs.
    pub equivalent: Margins,
}

/// Name of what is compared: `success` or one of [`COMPARED`].
///
/// # Errors
/// If nothing of that name is compared.
pub fn compared_name(name: &str) -> Result<&'static str, NameError> {
    let names: Vec<&'static str> = [SUCCESS].into_iter().chain(COMPARED).collect();
    let known = names.iter().copied().find(|known| *known == name);
    known.ok_or_else(|| NameError::unknown("metric", name, &names))
}

/// Analyses one section.
///
/// # Errors
/// If no stack has the name of the reference; the error lists the stacks.
pub fn analyse(section: &Section, pairing: &Pairing) -> Result<Report, NameError> {
    let (section, copies) = section.without_copies();
    let stacks = &section.stacks;
    let reference = match &pairing.reference {
        None => 0,
        Some(name) => stacks.iter().position(|stack| stack.name == *name).ok_or_else(|| {
            let known: Vec<&str> = stacks.iter().map(|stack| stack.name.as_str()).collect();
            NameError::unknown("stack", name, &known)
        })?,
    };
    let distinct = stacks.iter().map(|stack| stack.rows.len() as u64).max().unwrap_or(0);
    let chosen: Vec<(usize, usize)> = if copies > 0 && distinct < 2 {
        Vec::new()
    } else if pairing.all_pairs {
        pairs(stacks.len()).collect()
    } else {
        (0..stacks.len()).filter(|&other| other != reference).map(|other| (reference, other)).collect()
    };
    let compare = if pairing.unpaired { compare_unpaired } else { compare_pairs };
    let mut comparisons: Vec<Comparison> = chosen.iter().flat_map(|&(a, b)| compare(&stacks[a], &stacks[b])).collect();
    correct(&mut comparisons);
    let of_pairs = chosen.iter().map(|&(a, b)| (&stacks[a], &stacks[b]));
    let equivalences = equivalence::test_equivalence(of_pairs, &pairing.equivalent);

    // The ranking is a family of its own: every pair of stacks by success.
    let p: Vec<f64> = pairs(stacks.len()).map(|(a, b)| mcnemar_exact(outcomes(&stacks[a], &stacks[b]))).collect();
    let rates: Vec<f64> = stacks.iter().map(StackRows::success_rate).collect();
    let letters = Ranking::new(&rates, Better::Higher, &holm(&p), ALPHA).letters();
    Ok(Report {
        title: section.title.clone(),
        stacks: stacks.iter().filter_map(|stack| summarise_rows(stack.rows.values())).collect(),
        comparisons,
        equivalences,
        letters,
        paired: !pairing.unpaired,
        distinct,
        copies,
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::episode::Outcome;
    use crate::metrics::Metrics;
    use crate::results::{Rate, Row, Statistics};

    /// Rows of stacks, one character an episode: `s` success, `c` collision at time-out's length, `i` infeasible.
    pub(crate) fn section(stacks: &[(&str, &str, &[f64])]) -> Section {
        let stacks = stacks.iter().map(|&(name, ends, lengths)| {
            let rows = ends.chars().enumerate().map(|(episode, end)| {
                let outcome = match end {
                    's' => Outcome::Success,
                    'i' => Outcome::InfeasibleWorld { message: String::new() },
                    _ => Outcome::Timeout,
                };
                let length_m = lengths.get(episode).copied();
                let metrics = Metrics { length_m, time_s: length_m.map(|x| 2.0 * x), ..Metrics::default() };
                let row = Row { stack: name.to_owned(), episode: episode as u64, outcome, metrics, ..Row::blank() };
                ((0, episode as u64), row)
            });
            StackRows { name: name.to_owned(), values: Vec::new(), rows: rows.collect() }
        });
        Section {
            title: "made up".to_owned(),
            scenario: String::new(),
            point: 0,
            swept: Vec::new(),
            stacks: stacks.collect(),
        }
    }

    #[test]
    fn a_stack_is_summed_up_without_its_infeasible_worlds() {
        let section = section(&[("a", "sssfi", &[1.0, 2.0, 4.0, 9.0])]);
        let report = analyse(&section, &Pairing::default()).unwrap();
        let a = &report.stacks[0];
        assert_eq!((a.n, a.rated, a.outcomes), (5, 4, [3, 0, 1, 0, 0, 0, 0, 0, 1]));
        // Wilson's interval of 3 of 4, by the formula: (0.75 + z²/8 ± z √(0.75·0.25/4 + z²/64)) / (1 + z²/4).
        let Rate { rate, low, high } = a.success.unwrap();
        assert!(rate == 0.75 && (low - 0.300_642).abs() < 1e-5 && (high - 0.954_413).abs() < 1e-5, "{low} {high}");
        let Statistics { n, mean, sd, median, q1, q3 } = *a.metric(COMPARED[0]);
        assert!((mean.unwrap() - 7.0 / 3.0).abs() < 1e-12 && (sd.unwrap() - (7.0f64 / 3.0).sqrt()).abs() < 1e-12);
        assert_eq!((n, median, q1, q3), (3, Some(2.0), Some(1.5), Some(3.0)));
    }

    #[test]
    fn pairs_are_tested_as_by_hand() {
        // Eight worlds; a alone solves two, b alone none, both five, of which lengths differ by +1, +2, −3, 0, +4 (b − a).
        let a = [10.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0];
        let b = [11.0, 12.0, 7.0, 10.0, 14.0, 9.0, 9.0, 9.0];
        let section = section(&[("a", "sssssssf", &a), ("b", "sssssfff", &b)]);
        let report = analyse(&section, &Pairing::default()).unwrap();
        let [success, length, ..] = report.comparisons.as_slice() else { panic!("{report:?}") };
        assert_eq!((success.n, success.informative, success.difference), (8, 2, Some(-25.0)));
        assert_eq!((success.p, success.effect), (0.5, Some(0.0)), "2 · (1/2)²");
        assert_eq!((length.n, length.informative, length.difference), (5, 4, Some(0.8)));
        // Ranks 1, 2, 3, 4 with W⁻ = 3: subsets with a sum up to 3 are ∅, 1, 2, 3, 1+2: p = 2 · 5 / 16.
        assert_eq!((length.p, length.effect), (0.625, Some(0.4)));
        assert!(length.too_few && success.too_few);
        assert_eq!(report.letters, ["a", "a"]);
    }

    #[test]
    fn a_clear_difference_is_found_and_ranked() {
        let wins = "s".repeat(40);
        let losses = "f".repeat(20) + &"s".repeat(20);
        let section = section(&[("good", &wins, &[]), ("bad", &losses, &[]), ("fine", &wins, &[])]);
        let report = analyse(&section, &Pairing { all_pairs: true, ..Pairing::default() }).unwrap();
        let success: Vec<&Comparison> = report.comparisons.iter().filter(|c| c.metric == "success").collect();
        assert_eq!(success.len(), 3);
        assert!(success[0].p_holm < 1e-4 && success[0].difference == Some(-50.0) && !success[0].too_few);
        assert_eq!(success[0].effect, Some(0.0));
        assert_eq!(success[2].effect, Some(f64::INFINITY), "fine against bad");
        assert_eq!(report.letters, ["a", "b", "a"]);
        let wrong = Pairing { reference: Some("goood".to_owned()), ..Pairing::default() };
        assert!(analyse(&section, &wrong).unwrap_err().to_string().contains("did you mean `good`?"));
    }

    #[test]
    fn unpaired_tests_are_those_of_the_papers() {
        // 116 of 120 against 104 of 120: the two-sided Fisher test of the notes on gao2025 (T8), p = 0.009.
        let (a, b) = ("s".repeat(116) + "ffff", "s".repeat(104) + &"f".repeat(16));
        let section = section(&[("a", &a, &[]), ("b", &b, &[])]);
        let report = analyse(&section, &Pairing { unpaired: true, ..Pairing::default() }).unwrap();
        assert_eq!(report.comparisons[0].test, "Fisher, exact");
        assert!((report.comparisons[0].p - 0.009).abs() < 5e-4, "{}", report.comparisons[0].p);
    }
}
