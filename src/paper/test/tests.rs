use super::*;
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
    Evidence { tables: [("t".to_owned(), table)].into(), ..Evidence::default() }
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
    test.kind().judge(&Data { evidence, published, tables: &[], choice: None }).ruling
}

fn compare(metric: &str, is: &str, more: &str) -> String {
    format!("compare: {{metric: {metric}, of: {{table: t, stack: a}}, is: {is}, than: {{table: t, stack: b}}{more}}}")
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
    assert_eq!(ruling(&compare("length_m", "less", ""), &failed, &[]), Ruling::Undecided, "no world solved by both");
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
    assert_eq!(ruling(&range("at_least: -1, at_most: 5"), &found, &[]), Ruling::Holds);
    assert_eq!(ruling(&range("at_least: 5"), &found, &[]), Ruling::Fails);
    assert_eq!(ruling(&range("at_least: 2"), &found, &[]), Ruling::Undecided, "the interval of the mean holds 2");
    assert_eq!(ruling("range: {metric: length_m, table: other, at_least: 2}", &found, &[]), Ruling::NotRun);
}

#[test]
fn stacks_differ_if_one_world_shows_it() {
    let found = evidence(&[("a", &[Some(1.0), Some(2.0)]), ("b", &[Some(1.0), Some(2.5)])]);
    let differ =
        |tolerance: f64| format!("differ: {{metric: length_m, tables: [t], stacks: [a, b], tolerance: {tolerance}}}");
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

/// Ten lengths, the k-th shorter than 10 m by k cm times `factor`.
fn shorter(factor: f64) -> Vec<Option<f64>> {
    (1..=10).map(|k| Some(10.0 - 0.01 * factor * f64::from(k))).collect()
}

#[test]
fn the_best_is_better_than_each_of_the_others() {
    let best = |of: &str, is: &str| format!("best: {{metric: length_m, of: {{table: t, stack: {of}}}, is: {is}}}");
    let found = evidence(&[("a", &shorter(2.0)), ("b", &shorter(1.0)), ("c", &TEN)]);
    assert_eq!(ruling(&best("a", "less"), &found, &[]), Ruling::Holds);
    assert_eq!(ruling(&best("b", "less"), &found, &[]), Ruling::Fails, "a is shorter: p = 2/2¹⁰, twice that for two");
    assert_eq!(ruling(&best("c", "more"), &found, &[]), Ruling::Holds);
    // Two that no world tells apart, but not equal: b's last world is 1 cm longer.
    let mut twin = shorter(2.0);
    twin[9] = Some(9.81);
    let found = evidence(&[("a", &shorter(2.0)), ("b", &twin), ("c", &TEN)]);
    assert_eq!(ruling(&best("a", "less"), &found, &[]), Ruling::Undecided);
    let except = "best: {metric: length_m, of: {table: t, stack: a}, is: less, except: [b]}";
    assert_eq!(ruling(except, &found, &[]), Ruling::Holds);
}

#[test]
fn a_reduction_is_tested_against_its_bounds() {
    // 10, 10, … against 10 − 0.02 k: the means are 9.89 and 10, 1.1 per cent less.
    let found = evidence(&[("a", &shorter(2.0)), ("b", &TEN)]);
    let reduction = |bounds: &str| {
        let places = "of: {table: t, stack: a}, than: {table: t, stack: b}";
        ruling(&format!("reduction: {{metric: length_m, {places}, {bounds}}}"), &found, &[])
    };
    assert_eq!(reduction("at_least: 0.5"), Ruling::Holds);
    assert_eq!(reduction("at_least: 2.5"), Ruling::Fails);
    assert_eq!(reduction("at_least: 1.1"), Ruling::Undecided);
    assert_eq!(reduction("at_least: 0.5, at_most: 2.5"), Ruling::Holds);
    // Two worlds cannot decide, whatever their bootstrap interval says.
    let two = evidence(&[("a", &[Some(9.0), Some(9.1)]), ("b", &[Some(10.0), Some(10.0)])]);
    let places = "of: {table: t, stack: a}, than: {table: t, stack: b}";
    let test = format!("reduction: {{metric: length_m, {places}, at_least: 2}}");
    assert_eq!(ruling(&test, &two, &[]), Ruling::Undecided);
    assert_eq!(ruling("range: {metric: length_m, table: t, stack: a, at_most: 9.2}", &two, &[]), Ruling::Undecided);
}

#[test]
fn equivalence_needs_a_margin_that_the_interval_keeps() {
    let found = evidence(&[("a", &shorter(1.0)), ("b", &TEN)]);
    let equivalent = |metric: &str, margin: f64| {
        let places = "of: {table: t, stack: a}, than: {table: t, stack: b}";
        ruling(&format!("equivalent: {{metric: {metric}, {places}, margin: {margin}}}"), &found, &[])
    };
    // The mean difference is 0.055 m, its 90 % interval ± t₉ · 0.0303 / √10 = ± 0.0176.
    assert_eq!(equivalent("length_m", 0.08), Ruling::Holds);
    assert_eq!(equivalent("length_m", 0.06), Ruling::Undecided);
    assert_eq!(equivalent("length_m", 0.03), Ruling::Fails);
    assert_eq!(equivalent("success", 5.0), Ruling::Undecided, "ten pairs say nothing to 5 points");
}

#[test]
fn rankings_are_compared_by_their_correlation() {
    let names = ["a", "b", "c", "d", "e", "f"];
    let length = |k: usize| vec![Some(10.0 + k as f64); 3];
    let lengths: Vec<Vec<Option<f64>>> = (0..6).map(length).collect();
    let rows: Vec<(&str, &[Option<f64>])> =
        names.iter().zip(&lengths).map(|(name, lengths)| (*name, lengths.as_slice())).collect();
    let found = evidence(&rows);
    let ranked = |values: [&str; 6]| {
        let paper: Vec<Published> =
            names.iter().zip(values).map(|(name, value)| printed(name, "length_m", value, None)).collect();
        ruling("rank_correlation: {metric: length_m, table: t}", &found, &paper)
    };
    // Of six, only the same order (p = 2/720) and one exchange of neighbours are significant enough.
    assert_eq!(ranked(["1", "2", "3", "4", "5", "6"]), Ruling::Holds);
    assert_eq!(ranked(["6", "5", "4", "3", "2", "1"]), Ruling::Fails);
    assert_eq!(ranked(["3", "1", "2", "6", "4", "5"]), Ruling::Undecided);
}

#[test]
fn where_a_larger_form_was_run_it_decides() {
    let tables: Vec<Table> = read_document(
        "- {id: t, title: t, scenario: t.yaml, larger: t_more}\n- {id: t_more, title: t, scenario: t.yaml, full: true}",
    )
    .unwrap();
    let test: Test = read_document(&compare("length_m", "less", "")).unwrap();
    let judged = |evidence: &Evidence| {
        test.kind().judge(&Data { evidence, published: &[], tables: &tables, choice: None }).ruling
    };
    let mut found = evidence(&[("a", &shorter(1.0)[..2]), ("b", &TEN[..2])]);
    assert_eq!(judged(&found), Ruling::Undecided, "two worlds");
    let more = evidence(&[("a", &shorter(1.0)), ("b", &TEN)]).tables.remove("t").unwrap();
    found.tables.insert("t_more".to_owned(), more);
    assert_eq!(judged(&found), Ruling::Holds, "ten worlds");
}

#[test]
fn independent_samples_are_tested_by_their_rank_sum() {
    let found = evidence(&[("a", &shorter(1.0)), ("b", &TEN)]);
    let sum = |is: &str| {
        format!("rank_sum: {{metric: length_m, of: {{table: t, stack: a}}, is: {is}, than: {{table: t, stack: b}}}}")
    };
    assert_eq!(ruling(&sum("less"), &found, &[]), Ruling::Holds);
    assert_eq!(ruling(&sum("more"), &found, &[]), Ruling::Fails);
    let few = evidence(&[("a", &shorter(1.0)[..2]), ("b", &TEN[..2])]);
    assert_eq!(ruling(&sum("less"), &few, &[]), Ruling::Undecided);
    // A hundredth of the second is less than the first.
    let scaled = sum("less").replace("b}}", "b}, factor: 0.01}");
    assert_eq!(ruling(&scaled, &found, &[]), Ruling::Fails);
}

#[test]
fn a_table_that_was_not_run_decides_nothing_and_a_larger_one_decides_where_it_was() {
    let paper = [printed("a", "success", "50", Some(120))];
    let reach = |larger: &str| format!("reach: {{of: {{table: t, stack: a}}, larger: {larger}}}");
    let rate = |solved: usize| -> Vec<Option<f64>> { (0..100).map(|k| (k < solved).then_some(1.0)).collect() };
    let mut found = evidence(&[("a", &rate(45))]);
    assert_eq!(ruling(&reach("t_more"), &found, &paper), Ruling::Undecided, "t decides");
    let more = evidence(&[("a", &rate(90))]).tables.remove("t").unwrap();
    found.tables.insert("t_more".to_owned(), more);
    assert_eq!(ruling(&reach("t_more"), &found, &paper), Ruling::Holds);
    assert_eq!(ruling("range: {metric: length_m, table: none, at_least: 1}", &found, &[]), Ruling::NotRun);
}
