//! Claims against evidence.

use super::evidence::Evidence;
use super::manifest::{Over, Place, Relation, Source, Test, all, compare, differ, fisher, multiples, range, reach};
use super::published::{Published, Quantity, SUCCESS, counts_failures, mean_of, value};
use crate::analysis::{
    Location, PairedOutcomes, Z_95, bootstrap_interval, fisher_exact, mcnemar_exact, paired_differences, signed_rank,
    wilson,
};
use crate::comparison::{ALPHA, StackRows};
use crate::episode::Outcome;
use crate::math;
use crate::settings::quantity::counted;

/// Ruling on a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ruling {
    /// The claim holds.
    Holds,
    /// The claim does not hold.
    Fails,
    /// The data do not decide the claim.
    Undecided,
    /// No run could decide the claim.
    Untestable,
}

impl Ruling {
    /// The ruling in words.
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
    /// The ruling.
    pub ruling: Ruling,
    /// The numbers behind the ruling.
    pub why: String,
}

fn verdict(ruling: Ruling, why: impl Into<String>) -> Verdict {
    Verdict { ruling, why: why.into() }
}

fn worlds(count: u64) -> String {
    counted(count, "world")
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
        |outcome: &Outcome| params.over == Over::All || counts_failures(&params.metric) || outcome.is_success();
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
        return verdict(ruling, format!("largest difference {largest:.3} in {}", worlds(n as u64)));
    }
    let (low, high) = bootstrap_interval(&differences, Location::Mean, 0.95).unwrap_or((a - b, a - b));
    // In few worlds the exact tests know more than a bootstrap: of one world its interval is a point.
    let is_success = params.metric == SUCCESS && params.factor == 1.0;
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
        format!(
            "{a:.2} against {b:.2}{factor}, difference {:+.2} [{low:+.2}, {high:+.2}] in {}{p}",
            a - b,
            worlds(n as u64)
        ),
    )
}

/// The published mean of a metric of a stack.
fn printed<'p>(published: &'p [Published], place: &Place, metric: &str) -> Option<&'p Published> {
    published.iter().find(|number| {
        (number.table.as_str(), number.stack.as_str(), number.metric.as_str()) == (&place.table, &place.stack, metric)
            && number.quantity == Quantity::Mean
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
    verdict(ruling, format!("largest difference {widest:.3} in {}", self::worlds(worlds)))
}

fn reaches(params: &reach::Params, evidence: &Evidence, published: &[Published]) -> Verdict {
    let printed = params.of.table.split('_').next().unwrap_or(&params.of.table);
    let place = Place { table: printed.to_owned(), stack: params.of.stack.clone() };
    let theirs = self::printed(published, &place, SUCCESS).and_then(Published::counts);
    let (Some((k, trials)), Some(stack)) = (theirs, evidence.stack(&params.of.table, &params.of.stack)) else {
        return missing("no published count, or no rows");
    };
    let Some(ours) = mean_of(stack, SUCCESS) else { return missing("no rows") };
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
            .filter(|number| number.quantity == Quantity::Mean)
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
    let counts = |place: &Place| printed(published, place, SUCCESS).and_then(Published::counts);
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
        .filter(|number| number.table == params.table && number.metric == SUCCESS && number.quantity == Quantity::Mean)
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

/// The joint verdict: holds if all hold, fails if one fails, else undecided.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::comparison::Section;
    use crate::episode::Outcome;
    use crate::metrics::Metrics;
    use crate::paper::evidence::TableEvidence;
    use crate::results::Row;
    use crate::scenario::read_document;

    /// Rows of stacks: the length of each success, `None` where the drive failed.
    fn evidence(stacks: &[(&str, &[Option<f64>])]) -> Evidence {
        let rows = |name: &str, lengths: &[Option<f64>]| {
            let row = |(episode, length_m): (usize, &Option<f64>)| {
                let outcome = if length_m.is_some() { Outcome::Success } else { Outcome::Timeout };
                let metrics = Metrics { length_m: *length_m, planned_length_m: Some(5.0), ..Metrics::default() };
                let episode = episode as u64;
                ((1, episode), Row { stack: name.to_owned(), episode, outcome, metrics, ..Row::blank() })
            };
            StackRows { name: name.to_owned(), values: Vec::new(), rows: lengths.iter().enumerate().map(row).collect() }
        };
        let section = Section {
            title: "t".to_owned(),
            scenario: "t".to_owned(),
            point: 0,
            swept: Vec::new(),
            stacks: stacks.iter().map(|(name, lengths)| rows(name, lengths)).collect(),
        };
        let table = TableEvidence { sections: vec![section], bounds: Default::default(), failures: Default::default() };
        Evidence { tables: [("t".to_owned(), table)].into() }
    }

    fn printed(stack: &str, metric: &str, value: &str, trials: Option<u64>) -> Published {
        Published {
            place: "Table 1".to_owned(),
            table: "t".to_owned(),
            stack: stack.to_owned(),
            against: String::new(),
            metric: metric.to_owned(),
            quantity: Quantity::Mean,
            unit: String::new(),
            value: value.to_owned(),
            trials,
            note: String::new(),
        }
    }

    fn ruling(test: &str, evidence: &Evidence, published: &[Published]) -> Ruling {
        let test: Test = read_document(test).unwrap_or_else(|error| panic!("{test}: {error}"));
        judge(&test, evidence, published).ruling
    }

    fn compare(metric: &str, is: &str, more: &str) -> String {
        format!(
            "compare: {{metric: {metric}, of: {{table: t, stack: a}}, is: {is}, than: {{table: t, stack: b}}{more}}}"
        )
    }

    const TEN: [Option<f64>; 10] = [Some(10.0); 10];

    #[test]
    fn shorter_on_every_world_is_less_and_not_more() {
        // Ten worlds, each 1 to 10 cm shorter: the signed-rank test of ten of one sign is 2/2¹⁰.
        let shorter: Vec<Option<f64>> = (1..=10).map(|k| Some(10.0 - 0.01 * f64::from(k))).collect();
        let found = evidence(&[("a", &shorter), ("b", &TEN)]);
        assert_eq!(ruling(&compare("length_m", "less", ""), &found, &[]), Ruling::Holds);
        assert_eq!(ruling(&compare("length_m", "more", ""), &found, &[]), Ruling::Fails);
        assert_eq!(ruling(&compare("length_m", "equal", ", tolerance: 0.11"), &found, &[]), Ruling::Holds);
        assert_eq!(ruling(&compare("length_m", "equal", ", tolerance: 0.09"), &found, &[]), Ruling::Fails);
        // Twice as long as b is far more than a.
        assert_eq!(ruling(&compare("length_m", "less", ", factor: 2"), &found, &[]), Ruling::Holds);
    }

    #[test]
    fn few_or_equal_worlds_do_not_decide_and_none_is_no_data() {
        let two = [Some(9.0), Some(9.5)];
        assert_eq!(
            ruling(&compare("length_m", "less", ""), &evidence(&[("a", &two), ("b", &TEN)]), &[]),
            Ruling::Undecided,
            "two of one sign: p = 0.5"
        );
        let equal = evidence(&[("a", &TEN), ("b", &TEN)]);
        assert_eq!(ruling(&compare("length_m", "less", ""), &equal, &[]), Ruling::Fails, "the same in every world");
        let failed = evidence(&[("a", &[None; 10]), ("b", &TEN)]);
        assert_eq!(
            ruling(&compare("length_m", "less", ""), &failed, &[]),
            Ruling::Undecided,
            "no world solved by both"
        );
        // What is known before the drive counts for failures, too.
        assert_eq!(ruling(&compare("planned_length_m", "equal", ""), &failed, &[]), Ruling::Holds);
        assert_eq!(ruling(&compare("length_m", "less", ""), &evidence(&[("b", &TEN)]), &[]), Ruling::Undecided);
    }

    #[test]
    fn success_is_told_apart_by_mcnemars_test() {
        // Six worlds that b alone solves: p = 2/2⁶ = 0.03; five: 0.06.
        let losing = |count: usize| -> Vec<Option<f64>> { (0..10).map(|k| (k >= count).then_some(10.0)).collect() };
        let found = |count| evidence(&[("a", &losing(count)), ("b", &TEN)]);
        assert_eq!(ruling(&compare("success", "less", ""), &found(6), &[]), Ruling::Holds);
        assert_eq!(ruling(&compare("success", "more", ""), &found(6), &[]), Ruling::Fails);
        assert_eq!(ruling(&compare("success", "less", ""), &found(5), &[]), Ruling::Undecided);
    }

    #[test]
    fn printed_numbers_are_compared_as_they_stand() {
        let paper = [printed("a", "length_m", "9.5", None), printed("b", "length_m", "10", None)];
        let nothing = Evidence::default();
        let published = ", source: published";
        assert_eq!(ruling(&compare("length_m", "less", published), &nothing, &paper), Ruling::Holds);
        assert_eq!(ruling(&compare("length_m", "more", published), &nothing, &paper), Ruling::Fails);
        assert_eq!(ruling(&compare("time_s", "less", published), &nothing, &paper), Ruling::Undecided, "not printed");
        let within = |low: f64| format!("range: {{metric: length_m, table: t, at_least: {low}, source: published}}");
        assert_eq!(ruling(&within(9.5), &nothing, &paper), Ruling::Holds, "a bound is within");
        assert_eq!(ruling(&within(9.6), &nothing, &paper), Ruling::Fails);
    }

    #[test]
    fn a_rate_is_reached_by_its_interval() {
        // Published 60 of 120: Wilson's interval is 50 % ± z/2 / √(120 + z²) = [41.2, 58.8].
        let paper = [printed("a", "success", "50", Some(120))];
        let rate = |solved: usize| -> Vec<Option<f64>> { (0..100).map(|k| (k < solved).then_some(1.0)).collect() };
        let reach = "reach: {of: {table: t, stack: a}}";
        // Of 100: 55 have [45.2, 64.4], 45 have [35.6, 54.8], 25 have [17.5, 34.3].
        for (solved, expected) in [(55, Ruling::Holds), (45, Ruling::Undecided), (25, Ruling::Fails)] {
            assert_eq!(ruling(reach, &evidence(&[("a", &rate(solved))]), &paper), expected, "{solved}");
        }
        assert_eq!(ruling(reach, &evidence(&[("a", &TEN)]), &[]), Ruling::Undecided, "nothing published");
    }

    #[test]
    fn ranges_look_at_means_or_at_every_row() {
        let found = evidence(&[("a", &[Some(1.0), Some(2.0), Some(3.0), None])]);
        let range = |bounds: &str| format!("range: {{metric: length_m, table: t, stack: a, {bounds}}}");
        assert_eq!(ruling(&range("at_most: 2.5, of: every"), &found, &[]), Ruling::Fails);
        assert_eq!(ruling(&range("at_most: 3, of: every"), &found, &[]), Ruling::Holds);
        assert_eq!(ruling(&range("at_least: 0.5, at_most: 3.5"), &found, &[]), Ruling::Holds);
        assert_eq!(ruling(&range("at_least: 3.5"), &found, &[]), Ruling::Fails);
        assert_eq!(ruling(&range("at_least: 2"), &found, &[]), Ruling::Undecided, "the interval of the mean holds 2");
        assert_eq!(ruling("range: {metric: length_m, table: other, at_least: 2}", &found, &[]), Ruling::Undecided);
    }

    #[test]
    fn stacks_differ_if_one_world_shows_it() {
        let found = evidence(&[("a", &[Some(1.0), Some(2.0)]), ("b", &[Some(1.0), Some(2.5)])]);
        let differ = |tolerance: f64| {
            format!("differ: {{metric: length_m, tables: [t], stacks: [a, b], tolerance: {tolerance}}}")
        };
        assert_eq!(ruling(&differ(0.4), &found, &[]), Ruling::Holds);
        assert_eq!(ruling(&differ(0.5), &found, &[]), Ruling::Fails);
        let without = "differ: {metric: length_m, tables: [t], stacks: [a, c]}";
        assert_eq!(ruling(without, &found, &[]), Ruling::Undecided);
    }

    #[test]
    fn the_papers_counts_are_tested_as_counts() {
        // 116 and 104 of 120: Fisher's two-sided p = 0.009; 97 % of 120 is 116.4 drives.
        let paper = [printed("a", "success", "96.7", Some(120)), printed("b", "success", "86.7", Some(120))];
        let fisher = "fisher: {of: {table: t, stack: a}, than: {table: t, stack: b}}";
        let nothing = Evidence::default();
        assert_eq!(ruling(fisher, &nothing, &paper), Ruling::Holds);
        let reversed = "fisher: {of: {table: t, stack: b}, than: {table: t, stack: a}}";
        assert_eq!(ruling(reversed, &nothing, &paper), Ruling::Fails, "told apart, but the other way");
        assert_eq!(ruling("multiples: {table: t}", &nothing, &paper), Ruling::Holds);
        let odd = [printed("a", "success", "97.0", Some(120))];
        assert_eq!(ruling("multiples: {table: t}", &nothing, &odd), Ruling::Fails);
        assert_eq!(ruling("multiples: {table: t, decimals: 0}", &nothing, &odd), Ruling::Holds, "to the percent it is");
    }

    #[test]
    fn all_of_several_holds_if_each_does() {
        let found = evidence(&[("a", &TEN)]);
        let range = |low: f64| format!("{{range: {{metric: length_m, table: t, at_least: {low}}}}}");
        let (holds, fails, open) = (range(9.0), range(11.0), "{untestable: {because: nobody knows}}".to_owned());
        for (tests, expected) in [
            (vec![&holds, &holds], Ruling::Holds),
            (vec![&holds, &fails, &open], Ruling::Fails),
            (vec![&holds, &open], Ruling::Undecided),
        ] {
            let tests = tests.into_iter().map(String::as_str).collect::<Vec<_>>().join(", ");
            assert_eq!(ruling(&format!("all: {{tests: [{tests}]}}"), &found, &[]), expected, "{tests}");
        }
        assert_eq!(ruling(&open, &found, &[]), Ruling::Untestable);
    }
}
