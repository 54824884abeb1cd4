//! `simrun analyze` as a user meets it, on tables made by hand and against SciPy's numbers.

use super::support::{Answer, root, simrun};
use simrun::episode::Outcome;
use simrun::metrics::Metrics;
use simrun::results::{Digest, Row, header_line, write_row};
use std::fs;
use std::path::{Path, PathBuf};

/// A row that succeeded with that length, or ran out of time.
fn row(stack: &str, episode: u64, length_m: Option<f64>) -> Row {
    Row {
        scenario: "made_up".to_owned(),
        point: 0,
        stack: stack.to_owned(),
        global: String::new(),
        path: String::new(),
        local: "dwa".to_owned(),
        episode,
        seed: 7,
        outcome: if length_m.is_some() { Outcome::Success } else { Outcome::Timeout },
        metrics: Metrics { length_m, time_s: length_m, ..Metrics::default() },
        world_digest: Some(Digest(episode)),
        trace_digest: Some(Digest(length_m.unwrap_or_default().to_bits())),
        swept: Vec::new(),
    }
}

fn write(file: &Path, swept: &[String], rows: &[Row]) {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(header_line(swept));
    for row in rows {
        write_row(&mut writer, row).unwrap();
    }
    fs::write(file, writer.into_inner().unwrap()).unwrap();
}

/// Two stacks with these lengths in the same worlds.
fn two(folder: &Path, name: &str, first: &[Option<f64>], second: &[Option<f64>]) -> PathBuf {
    let rows = first.iter().zip(second).enumerate();
    let rows = rows.flat_map(|(i, (&a, &b))| [row("first", i as u64, a), row("second", i as u64, b)]);
    let file = folder.join(name);
    write(&file, &[], &rows.collect::<Vec<Row>>());
    file
}

fn analyze(arguments: &[&str], files: &[&Path]) -> (String, String, i32) {
    let Answer { code, stdout, stderr } = simrun(root()).arg("analyze").args(files).args(arguments).answer();
    (stdout, stderr, code)
}

/// A field of the line of a test in the CSV.
fn field(csv: &str, metric: &str, name: &str) -> String {
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let header = reader.headers().unwrap().clone();
    let column = |wanted: &str| header.iter().position(|found| found == wanted).unwrap();
    let lines = reader.records().map(Result::unwrap).collect::<Vec<_>>();
    let line = lines.iter().find(|line| &line[column("metric")] == metric).unwrap();
    line[column(name)].to_owned()
}

#[test]
fn the_signed_rank_test_of_lengths_is_scipys() {
    let scratch = tempfile::tempdir().unwrap();
    let mut reader = csv::Reader::from_path(root().join("tests/data/statistics_oracle.csv")).unwrap();
    let numbers = |text: &str| text.split_whitespace().map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
    let mut cases = 0;
    for case in reader.records().map(Result::unwrap).filter(|case| &case[0] == "signed_rank") {
        let (differences, expected) = (numbers(&case[1]), numbers(&case[3]));
        let [zeros, positive, negative, p] = expected[..] else { panic!("{expected:?}") };
        let first: Vec<Option<f64>> = differences.iter().map(|_| Some(64.0)).collect();
        let second: Vec<Option<f64>> = differences.iter().map(|difference| Some(64.0 + difference)).collect();
        let file = two(scratch.path(), "oracle.csv", &first, &second);
        let (csv, error, code) = analyze(&["--format", "csv"], &[&file]);
        assert_eq!((code, error.as_str()), (0, ""));
        let found: f64 = field(&csv, "length_m", "p").parse().unwrap();
        assert!((found - p).abs() <= 1e-9 * p, "{found} for {p}");
        let telling: f64 = field(&csv, "length_m", "informative").parse().unwrap();
        assert_eq!(telling + zeros, differences.len() as f64);
        if positive + negative > 0.0 {
            let effect: f64 = field(&csv, "length_m", "effect").parse().unwrap();
            assert!((effect - (positive - negative) / (positive + negative)).abs() < 1e-12);
        }
        cases += 1;
    }
    assert!(cases >= 3, "{cases} cases");
}

#[test]
fn an_example_worked_by_hand_in_three_formats() {
    let scratch = tempfile::tempdir().unwrap();
    // Ten worlds: both solve six, the second alone three, the first alone none. McNemar: p = 2 · (1/2)³ = 0.25.
    let first = [10.0, 10.0, 10.0, 10.0, 10.0, 10.0].map(Some).into_iter().chain([None; 4]).collect::<Vec<_>>();
    // Differences −1 … −6 on the six: p = 2 / 2⁶ = 0.03125.
    let second = [9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 1.0, 1.0, 1.0].map(Some).into_iter().chain([None]).collect::<Vec<_>>();
    let file = two(scratch.path(), "example.csv", &first, &second);
    let (csv, ..) = analyze(&["--format", "csv"], &[&file]);
    assert_eq!((field(&csv, "success", "p"), field(&csv, "success", "n")), ("0.25".into(), "10".into()));
    assert_eq!((field(&csv, "length_m", "p"), field(&csv, "length_m", "n")), ("0.03125".into(), "6".into()));
    assert_eq!(field(&csv, "length_m", "difference"), "-3.5");
    // The averages of pairs of −1 … −6 are symmetric around −3.5; the interval of six numbers is all of them. 39 m of 60 m.
    let of_length = |name| field(&csv, "length_m", name);
    assert_eq!(["shift", "shift_low", "shift_high", "ratio"].map(of_length), ["-3.5", "-6", "-1", "0.65"]);
    // (2.497705 + 0.841621) √3.5 / √(6 − 2.497705² / 2), at a quarter of five per cent.
    let detectable: f64 = of_length("detectable").parse().unwrap();
    assert!((detectable - 3.339_326 * 3.5f64.sqrt() / (6.0f64 - 3.119_265).sqrt()).abs() < 1e-5, "{detectable}");
    // The family has four tests; clearances are not there, so that their p is 1. Holm: 4 · 0.03125 for both length and time.
    assert_eq!(field(&csv, "length_m", "p_holm"), "0.125");

    let (text, ..) = analyze(&[], &[&file]);
    for part in ["conditional", "60.0 [31.3, 83.2]", "90.0 [59.6, 98.2]", "too few", "Holm"] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    let (markdown, ..) = analyze(&["--format", "markdown"], &[&file]);
    assert!(markdown.contains("| stack |") && markdown.contains("|---|"), "{markdown}");
    let (unpaired, ..) = analyze(&["--unpaired", "--format", "csv"], &[&file]);
    // Fisher, 9 of 10 against 6 of 10: 2 · (C(10,9) C(10,6) + C(10,10) C(10,5)) / C(20,15).
    let p: f64 = field(&unpaired, "success", "p").parse().unwrap();
    assert!((p - 2.0 * (10.0 * 210.0 + 252.0) / 15504.0).abs() < 1e-12, "{p}");
}

#[test]
fn files_and_points_are_never_pooled() {
    let scratch = tempfile::tempdir().unwrap();
    let a = two(scratch.path(), "a.csv", &[Some(1.0); 3], &[None; 3]);
    let b = two(scratch.path(), "b.csv", &[None; 3], &[Some(1.0); 3]);
    let (text, ..) = analyze(&[], &[&a, &b]);
    assert_eq!(text.matches("100.0 [43.9, 100.0]").count(), 2, "{text}");
    assert_eq!(text.matches("0.0 [0.0, 56.1]").count(), 2, "{text}");

    let swept = scratch.path().join("swept.csv");
    let rows = [("0.1", 0), ("0.2", 1)].into_iter().flat_map(|(value, point)| {
        (0..3).map(move |i| Row {
            point,
            swept: vec![value.to_owned()],
            ..row("first", i, (point == 0).then_some(1.0))
        })
    });
    write(&swept, &["robot.radius_m".to_owned()], &rows.collect::<Vec<Row>>());
    let (text, ..) = analyze(&[], &[&swept]);
    assert!(text.contains("robot.radius_m = 0.1") && text.contains("robot.radius_m = 0.2"), "{text}");
    assert!(text.contains("100.0 [43.9, 100.0]") && text.contains("0.0 [0.0, 56.1]"), "{text}");
}

#[test]
fn a_broken_file_is_named_with_its_line() {
    let scratch = tempfile::tempdir().unwrap();
    let good = two(scratch.path(), "good.csv", &[Some(1.0); 2], &[Some(2.0); 2]);
    let text = fs::read_to_string(&good).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let refused = |text: String, message: &str| {
        let file = scratch.path().join("bad.csv");
        fs::write(&file, text).unwrap();
        let (stdout, stderr, code) = analyze(&[], &[&file]);
        assert!(code == 2 && stdout.is_empty() && stderr.contains("bad.csv") && stderr.contains(message), "{stderr}");
    };
    refused(text.replacen(",success,,1", ",success,,0", 1), "line 2: `success`: expected `1`, found `0`");
    refused(text.trim_end().to_owned(), "line 5: the line is cut short");
    refused(format!("{text}{}\n", lines[1]), "line 6: a second row of `first` in episode 0");
    refused(text.replacen("\nmade_up,0,second,", "\nelsewhere,0,second,", 1), "line 3: a row of `elsewhere`");
    let other_world = lines[2].replacen("0000000000000000,", "0000000000000009,", 1);
    refused(text.replacen(lines[2], &other_world, 1), "line 3: `first` and `second` met different worlds in episode 0");
    refused(String::new(), "empty");
    let (_, stderr, code) = analyze(&["--reference", "frist"], &[&good]);
    assert!(code == 2 && stderr.contains("did you mean `first`?"), "{stderr}");
}

#[test]
fn a_baseline_finds_what_moved_and_what_got_worse() {
    let scratch = tempfile::tempdir().unwrap();
    let lengths: Vec<Option<f64>> = (0..20).map(|i| Some(10.0 + f64::from(i))).collect();
    let longer: Vec<Option<f64>> = lengths.iter().map(|length| length.map(|x| x + 1.0)).collect();
    let old = two(scratch.path(), "old.csv", &lengths, &lengths);
    let new = two(scratch.path(), "new.csv", &lengths, &longer);
    let against = |file: &Path, old: &Path| analyze(&["--baseline", old.to_str().unwrap()], &[file]);

    let (text, error, code) = against(&old, &old);
    assert!(code == 0 && error.is_empty() && text.contains("40 rows in both, 0 moved"), "{text}{error}");
    let (text, error, code) = against(&new, &old);
    assert!(code == 3 && error.contains("second: length_m by +1.000"), "{error}");
    assert!(text.contains("20 moved") && !error.contains("first"), "{text}{error}");
    let (text, error, code) = against(&old, &new);
    assert!(code == 0 && text.contains("20 moved"), "shorter is no regression: {text}{error}");
    // One row of forty is no evidence, but it is named.
    let mut one = lengths.clone();
    one[7] = None;
    let one = two(scratch.path(), "one.csv", &one, &lengths);
    let (text, error, code) = against(&one, &old);
    assert!(code == 0 && text.contains("1 moved") && text.contains("first, episode 7"), "{text}{error}");
}

#[test]
fn a_table_of_an_older_header_is_analysed_and_its_missing_columns_are_said_once() {
    let old = Path::new("tests/data/episodes_header_1.csv");
    let (text, error, code) = analyze(&[], &[old]);
    assert!(code == 0 && text.contains("dwa_predicting"), "{text}");
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(
        error.contains("episodes_header_1.csv: an older version wrote this table") && error.contains("contacts"),
        "{error}"
    );
    // The run of today is compared with that of the older version as ever.
    let (text, _, code) =
        analyze(&["--baseline", "tests/data/episodes_header_1.csv"], &[Path::new("results/reference/05_crossing")]);
    assert!(code == 0 && text.contains(" 0 missing, 0 new"), "{text}");
}

#[test]
fn copies_of_one_world_are_no_evidence() {
    let scratch = tempfile::tempdir().unwrap();
    // Own map, own start and goal, nothing random: twenty episodes are one.
    let (free, wall) = ("....................", "..........#.........");
    let rows = [free, free, free, wall, wall, free, free, free].map(|row| format!("'{row}'")).join(", ");
    let text = format!(
        "map: {{ascii: {{resolution_m: 0.5, rows: [{rows}]}}}}
start: [1, 2, 0]
goal: [9, 2]
stacks: [{{global: a_star, local: dwa}}, {{global: none, local: pure_pursuit}}]
episodes: 20\n"
    );
    fs::write(scratch.path().join("fixed.yaml"), text).unwrap();
    let said = simrun(scratch.path()).args(["check", "fixed.yaml"]).ends_with(0).stdout;
    assert!(said.contains("nothing in this scenario is random: its 20 episodes are the same"), "{said}");
    simrun(scratch.path()).args(["fixed.yaml", "--quiet", "--out", "out"]).ends_with(0);
    let said = simrun(scratch.path()).args(["analyze", "out"]).ends_with(0).stdout;
    assert!(said.contains("19 episodes left out") && said.contains("one world is no sample"), "{said}");
    assert!(!said.contains("differs") && !said.contains("McNemar, exact"), "{said}");
    // Noise makes them differ, though the world is one.
    let noisy = ["--set", "localisation.position_noise_m=0.02"];
    let said = simrun(scratch.path()).args(["check", "fixed.yaml"]).args(noisy).ends_with(0).stdout;
    assert!(!said.contains("nothing in this scenario is random"), "{said}");
    simrun(scratch.path()).args(["fixed.yaml", "--quiet", "--out", "noisy"]).args(noisy).ends_with(0);
    let said = simrun(scratch.path()).args(["analyze", "noisy"]).ends_with(0).stdout;
    assert!(!said.contains("left out") && said.contains("differs"), "{said}");
}

#[test]
fn equivalence_is_shown_where_the_interval_is_inside_of_the_margin() {
    let scratch = tempfile::tempdir().unwrap();
    let first: Vec<Option<f64>> = (0..40).map(|k| Some(20.0 + f64::from(k))).collect();
    let second: Vec<Option<f64>> = (0..40).map(|k| Some(20.0 + f64::from(k) + 0.25 * f64::from(k % 3 - 1))).collect();
    let file = two(scratch.path(), "alike.csv", &first, &second);
    let (text, _, code) = analyze(&["--equivalent", "length_m=1%", "--equivalent", "time_s=0.05"], &[&file]);
    assert!(code == 0 && text.contains("equivalent within ±0.395"), "{text}");
    assert_eq!(text.matches("not shown").count(), 1, "{text}");
    let (csv, ..) = analyze(&["--equivalent", "length_m=1%", "--format", "csv"], &[&file]);
    assert_eq!(field(&csv, "length_m", "margin"), "0.395");
    assert_eq!(field(&csv, "time_s", "margin"), "");
    let p: f64 = field(&csv, "length_m", "equivalence_p").parse().unwrap();
    assert!(p > 0.0 && p < 1e-6, "{p}");
    for (margin, said) in
        [("length_m=0", "above 0"), ("lenght_m=1", "did you mean `length_m`?"), ("length_m", "METRIC=VALUE")]
    {
        let (_, error, code) = analyze(&["--equivalent", margin], &[&file]);
        assert!(code == 2 && error.contains(said), "{error}");
    }
}

/// Rows of one stack at points with these values of one key and lengths; the world of an episode has the same digest at every point.
fn sweep(file: &Path, points: &[(&str, Vec<Option<f64>>)]) {
    let rows = points.iter().enumerate().flat_map(|(point, (value, lengths))| {
        lengths.iter().enumerate().map(move |(i, &length)| Row {
            point: point as u32,
            swept: vec![(*value).to_owned()],
            ..row("first", i as u64, length)
        })
    });
    write(file, &["stacks.local.dwa.horizon_s".to_owned()], &rows.collect::<Vec<Row>>());
}

#[test]
fn the_points_of_a_sweep_are_ranked_and_tested_against_the_best() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("sweep.csv");
    let lengths = |add: f64| (0..30).map(|k| Some(20.0 + f64::from(k) + add)).collect::<Vec<_>>();
    let mut failing = lengths(-1.0);
    failing[..12].fill(None);
    sweep(&file, &[("1", failing), ("2.5", lengths(0.0)), ("4", lengths(2.0))]);
    let (csv, error, code) = analyze(&["--compare-points", "--format", "csv"], &[&file]);
    assert_eq!((code, error.as_str()), (0, ""));
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let header = reader.headers().unwrap().clone();
    let lines: Vec<_> = reader.records().map(Result::unwrap).collect();
    let of = |rank: usize, name: &str| lines[rank][header.iter().position(|found| found == name).unwrap()].to_owned();
    assert_eq!([0, 1, 2].map(|rank| of(rank, "stacks.local.dwa.horizon_s")), ["2.5", "4", "1"]);
    assert_eq!([0, 1, 2].map(|rank| of(rank, "group")), ["a", "a", "b"]);
    assert_eq!((of(1, "time_s_shift"), of(0, "time_s_shift")), ("2".to_owned(), String::new()));
    // McNemar: twelve worlds that one alone solves. Of four tests two p-values are smaller: 2 · 2 · 2⁻¹² or more by Holm.
    let p: f64 = of(2, "success_p").parse().unwrap();
    assert!((p - 2.0 / 4096.0).abs() < 1e-12);
    assert_eq!(of(2, "success_p_holm").parse::<f64>().unwrap(), 2.0 * p);

    let (text, ..) = analyze(&["--compare-points"], &[&file]);
    assert!(text.contains("--set 'sweep={}' --set stacks.local.dwa.horizon_s=2.5 --stack first"), "{text}");
    assert!(text.contains("are told apart by these worlds: time_s by +2.000"), "{text}");
    let (markdown, ..) = analyze(&["--compare-points", "--format", "markdown", "--metrics", "length_m"], &[&file]);
    assert!(markdown.contains("length_m − best") && !markdown.contains("time_s − best"), "{markdown}");
    // Without it, points are sections; a CSV of tests has none, and that is said.
    let (_, error, _) = analyze(&["--format", "csv"], &[&file]);
    assert!(error.contains("--compare-points"), "{error}");

    sweep(&file, &[("1", lengths(0.0))]);
    let (_, error, code) = analyze(&["--compare-points"], &[&file]);
    assert!(code == 2 && error.contains("one setting alone"), "{error}");
    let (_, _, code) = analyze(&["--metrics", "time_s"], &[&file]);
    assert_eq!(code, 2, "metrics belong to a mode");
}

#[test]
fn a_baseline_of_another_scenario_is_named_with_its_keys() {
    let scratch = tempfile::tempdir().unwrap();
    let text = "name: gated\nmap: {empty: {cols: 12, rows: 10, resolution_m: 0.5}}\nstacks: [{global: none, local: pure_pursuit}]\nepisodes: 8\n";
    fs::write(scratch.path().join("gated.yaml"), text).unwrap();
    let run = |out: &str, set: &[&str]| {
        simrun(scratch.path()).args(["gated.yaml", "--quiet", "--out", out]).args(set).ends_with(0)
    };
    run("old", &[]);
    run("new", &["--set", "limits.speed_max_mps=0.75", "--episodes", "9"]);
    let said =
        simrun(scratch.path()).args(["analyze", "new", "--baseline", "old", "--margin", "time_s=90%"]).answer().stdout;
    let (_, after) = said.split_once("The scenario is not that of the baseline").expect(&said);
    assert!(
        after
            .lines()
            .nth(1)
            .is_some_and(|line| line.starts_with("  `limits.speed_max_mps`: ") && line.ends_with("0.75 here")),
        "{said}"
    );
    let said = simrun(scratch.path()).args(["analyze", "old", "--baseline", "old"]).answer().stdout;
    assert!(!said.contains("scenario"), "{said}");
    // Another map has other worlds: a gate that could compare nothing does not pass.
    run("elsewhere", &["--set", "map.empty.cols=13"]);
    let Answer { code, stdout, .. } =
        simrun(scratch.path()).args(["analyze", "elsewhere", "--baseline", "old"]).answer();
    assert!(code == 3 && stdout.contains("nothing was compared"), "{stdout}");
}

#[test]
fn a_table_of_a_header_alone_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = two(folder.path(), "episodes.csv", &[], &[]);
    let (stdout, stderr, code) = analyze(&[], &[&file]);
    assert_eq!((stdout.as_str(), code), ("", 2));
    assert!(stderr.contains("has no rows"), "{stderr}");
}
