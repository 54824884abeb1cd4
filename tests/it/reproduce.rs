//! `simrun reproduce` on a made-up paper whose verdicts are known, and on those that are shipped.

use super::support::{Answer, root, simrun};
use simrun::experiment::Experiment;
use simrun::paper::Paper;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

const SCENARIO: &str = "
map: {random: {cols: 12, rows: 8, obstacles: 12}}
stacks: {global: [a_star, dijkstra], local: [pure_pursuit]}
episodes: 8
";

const NUMBERS: &str = "\
where,table,stack,against,metric,quantity,unit,value,trials,note
Table 1,open,a_star+pure_pursuit,,success,mean,%,96.7,120,116 of 120
Table 1,open,dijkstra+pure_pursuit,,success,mean,%,86.7,120,104 of 120
Table 1,open,a_star+pure_pursuit,,time_s,mean,s,20.5,,
Table 1,open,dijkstra+pure_pursuit,,time_s,mean,s,30.5,,
Table 2,slow,a_star+pure_pursuit,,success,mean,%,96.5,120,no count of 120
text,open,a_star+pure_pursuit,dijkstra+pure_pursuit,expanded,reduction_percent,%,40,,
text,open,a_star+pure_pursuit,,clearance_min_m,mean,m,>=0.5,,no number
";

const PAPER: &str = "
title: Made up
citation: Nobody (2026)
about: One planner is said to be better than another.
method: Both drive a few small worlds.
published: tiny_claims.csv
tables:
  - {id: open, title: as it is, scenario: tiny.yaml}
  - {id: slow, title: at half the speed, scenario: tiny.yaml, set: [limits.speed_max_mps=0.5], under_choices: 6}
  - {id: more, title: more of it, scenario: tiny.yaml, set: [seed=9], full: true}
  - {id: open_hurried, title: with no time, scenario: tiny.yaml, set: [termination.timeout_s=0.5, termination.stuck_after_s=0.4], stacks: [a_star+pure_pursuit]}
questions:
  - id: equal
    says: both find shortest paths
    test: {compare: {metric: planned_length_m, of: &a {table: open, stack: a_star+pure_pursuit}, is: equal, than: &d {table: open, stack: dijkstra+pure_pursuit}, tolerance: 1e-9, over: all}}
  - id: fewer nodes
    says: A* expands fewer nodes
    test: {compare: {metric: expanded, of: *a, is: less, than: *d, over: all}}
  - id: more nodes
    says: A* expands more nodes
    test: {compare: {metric: expanded, of: *a, is: more, than: *d, over: all}}
  - id: slower
    says: at half the speed it takes longer, by a third at least
    test: {compare: {metric: time_s, of: &s {table: slow, stack: a_star+pure_pursuit}, is: more, than: *a, factor: 1.33}}
  - id: three times
    says: and three times as long
    test: {compare: {metric: time_s, of: *s, is: more, than: *a, factor: 3}}
  - id: lengths differ
    says: the planned lengths differ
    test: {differ: {metric: planned_length_m, tables: [open, slow], stacks: [a_star+pure_pursuit, dijkstra+pure_pursuit], tolerance: 1e-9}}
  - id: nodes differ
    says: the expanded nodes differ
    test: {differ: {metric: expanded, tables: [open], stacks: [a_star+pure_pursuit, dijkstra+pure_pursuit]}}
  - id: reached in no time
    says: the rate is reached in half a second
    test: {reach: {of: {table: open_hurried, stack: a_star+pure_pursuit}}}
  - id: top speed
    says: nobody is faster than allowed
    test: {range: {metric: speed_mean_mps, table: slow, at_most: 0.5, of: every}}
  - id: standing
    says: everybody stands
    test: {range: {metric: speed_mean_mps, table: slow, at_most: 0.01, of: every}}
  - id: mean speed
    says: the mean lies between nothing and the limit
    test: {range: {metric: speed_mean_mps, table: slow, at_least: 0, at_most: 0.5}}
  - id: printed times
    says: A* is printed as faster
    test: {compare: {source: published, metric: time_s, of: *a, is: less, than: *d}}
  - id: printed wrongly
    says: A* is printed as slower
    test: {compare: {source: published, metric: time_s, of: *a, is: more, than: *d}}
  - id: counts
    says: 116 of 120 are more than 104 of 120
    test: {fisher: {of: *a, than: *d}}
  - id: whole
    says: the rates of Table 1 are whole counts
    test: {multiples: {table: open}}
  - id: not whole
    says: those of Table 2 as well
    test: {multiples: {table: slow}}
  - id: both
    says: one thing that holds and one that does not
    test: {all: {tests: [{multiples: {table: open}}, {multiples: {table: slow}}]}}
  - id: elsewhere
    says: it is fast on another computer
    test: {untestable: {because: that is not here}}
claims:
  - id: slow is slow
    says: at half the speed the mean is below it
    test: {range: {metric: speed_mean_mps, table: slow, at_most: 0.55}}
  - id: full only
    says: a table of the full form
    test: {range: {metric: speed_mean_mps, table: more, at_most: 5}}
ablate:
  - {id: hurried, says: half speed is no half speed, of: world, set: [limits.speed_max_mps=4, limits.acceleration_max_mps2=9], tables: [slow], kindest: true}
";

/// The made-up paper, called `tiny`.
pub fn write_tiny_paper(folder: &Path) {
    write_paper(folder, PAPER, NUMBERS);
}

fn write_paper(folder: &Path, paper: &str, numbers: &str) {
    fs::write(folder.join("tiny.paper.yaml"), paper).unwrap();
    fs::write(folder.join("tiny_claims.csv"), numbers).unwrap();
    fs::write(folder.join("tiny.yaml"), SCENARIO).unwrap();
}

fn reproduce(folder: &Path, paper: &str, arguments: &[&str]) -> (String, i32) {
    let Answer { code, stderr, .. } =
        simrun(folder).args(["reproduce", paper, "--out", "out"]).args(arguments).answer();
    (stderr, code)
}

/// Two columns of a CSV, the first as keys.
fn columns(file: &Path, key: usize, value: usize) -> BTreeMap<String, String> {
    let mut reader = csv::Reader::from_path(file).unwrap();
    reader.records().map(|record| record.unwrap()).map(|r| (r[key].to_owned(), r[value].to_owned())).collect()
}

#[test]
fn a_made_up_paper_gets_the_verdicts_that_it_deserves() {
    let scratch = tempfile::tempdir().unwrap();
    write_paper(scratch.path(), PAPER, NUMBERS);
    let (error, code) = reproduce(scratch.path(), "tiny", &["--papers", ".", "--quiet"]);
    assert_eq!((code, error.as_str()), (0, ""));
    let out = scratch.path().join("out");
    let found = columns(&out.join("verdicts.csv"), 0, 3);
    for (id, verdict) in [
        ("equal", "holds"),
        ("fewer nodes", "holds"),
        ("more nodes", "does not hold"),
        ("slower", "holds"),
        ("three times", "does not hold"),
        ("lengths differ", "does not hold"),
        ("nodes differ", "holds"),
        ("reached in no time", "does not hold"),
        ("top speed", "holds"),
        ("standing", "does not hold"),
        ("mean speed", "holds"),
        ("printed times", "holds"),
        ("printed wrongly", "does not hold"),
        ("counts", "holds"),
        ("whole", "holds"),
        ("not whole", "does not hold"),
        ("both", "does not hold"),
        ("elsewhere", "cannot be tested"),
        ("slow is slow", "holds"),
        ("full only", "not run"),
    ] {
        assert_eq!(found[id], verdict, "{id}");
    }
    assert_eq!(found.len(), 20);

    // A number of the report, by hand from the rows.
    let mut rows = csv::Reader::from_path(out.join("open/episodes.csv")).unwrap();
    let header = rows.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|found| found == name).unwrap();
    let (stack, outcome, time) = (column("stack"), column("outcome"), column("time_s"));
    let rows: Vec<csv::StringRecord> = rows.records().map(Result::unwrap).collect();
    let solved = rows.iter().filter(|row| &row[stack] == "a_star+pure_pursuit" && &row[outcome] == "success");
    let times: Vec<f64> = solved.map(|row| row[time].parse().unwrap()).collect();
    let mut numbers = csv::Reader::from_path(out.join("numbers.csv")).unwrap();
    let numbers: Vec<csv::StringRecord> = numbers.records().map(Result::unwrap).collect();
    assert_eq!(numbers.len(), NUMBERS.lines().count() - 1, "every published number has its line");
    let number = numbers.iter().find(|n| &n[2] == "a_star+pure_pursuit" && &n[4] == "time_s").unwrap();
    let [measured, low, high, n] = [8, 9, 10, 11].map(|field| number[field].parse::<f64>().unwrap());
    assert!((measured - times.iter().sum::<f64>() / times.len() as f64).abs() < 1e-9 && n == times.len() as f64);
    assert!(low <= measured && measured <= high);

    // The report opens with what the paper says, and a second call runs nothing again.
    let report = fs::read_to_string(out.join("report.md")).unwrap();
    let order = ["Made up", "One planner is said", "Both drive a few", "does not hold", "no number"];
    let places: Vec<Option<usize>> = order.iter().map(|part| report.find(part)).collect();
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{places:?}");
    let clocked = || fs::read_to_string(out.join("open/timings.csv")).unwrap();
    let before = clocked();
    assert_eq!(reproduce(scratch.path(), "tiny", &["--papers", ".", "--quiet"]).1, 0);
    assert_eq!(clocked(), before, "wall-clock times of the first run");
    assert_eq!(fs::read_to_string(out.join("report.md")).unwrap(), report);

    // The full form runs the rest, and each choice with the episodes that it has; the claim that a choice turns says so.
    assert_eq!(reproduce(scratch.path(), "tiny", &["--papers", ".", "--quiet", "--full"]).1, 0);
    assert_eq!(clocked(), before, "what is there is not run again");
    let verdicts = columns(&out.join("verdicts.csv"), 0, 3);
    assert_eq!((verdicts["slow is slow"].as_str(), verdicts["full only"].as_str()), ("depends", "holds"));
    assert_eq!(columns(&out.join("verdicts.csv"), 0, 9)["slow is slow"], "hurried");
    let rows = fs::read_to_string(out.join("slow+hurried/episodes.csv")).unwrap();
    assert_eq!(rows.lines().count(), 1 + 2 * 6, "six episodes of the two stacks that statements name");
    assert!(fs::read_to_string(out.join("report.md")).unwrap().contains("(the kindest reading)"));
}

#[test]
fn what_does_not_fit_together_is_refused_before_anything_runs() {
    let scratch = tempfile::tempdir().unwrap();
    let refused = |paper: &str, numbers: &str, message: &str| {
        write_paper(scratch.path(), paper, numbers);
        let (error, code) = reproduce(scratch.path(), "tiny", &["--papers", "."]);
        assert!(code == 2 && error.contains(message), "{message}: {error}");
        assert!(!scratch.path().join("out").exists());
    };
    refused(&PAPER.replace("tables: [open, slow]", "tables: [open, slwo]"), NUMBERS, "slwo");
    refused(&PAPER.replace("{id: slow,", "{id: open,"), NUMBERS, "two tables are called `open`");
    refused(&PAPER.replace("id: counts", "id: equal"), NUMBERS, "two claims are called `equal`");
    refused(
        &PAPER.replace("multiples: {table: slow}}\n", "multiple: {table: slow}}\n"),
        NUMBERS,
        "unknown test `multiple`",
    );
    refused(
        &PAPER.replace("tables: [slow], kindest", "tables: [slwo], kindest"),
        NUMBERS,
        "choice `hurried`: unknown table `slwo`",
    );
    refused(&PAPER.replace("metric: expanded, of", "metric: expandde, of"), NUMBERS, "`expandde`");
    refused(
        &PAPER.replace("stack: dijkstra+pure_pursuit}, tol", "stack: dijkstar+pure_pursuit}, tol"),
        NUMBERS,
        "dijkstar",
    );
    refused(&PAPER.replace("speed_max_mps=0.5", "speed_mx_mps=0.5"), NUMBERS, "did you mean `speed_max_mps`?");
    refused(
        &PAPER
            .replace("stacks: [a_star+pure_pursuit],", "stacks: [a_star],")
            .replace("stacks: [a_star+pure_pursuit]}", "stacks: [a_star]}"),
        NUMBERS,
        "`a_star`",
    );
    refused(PAPER, &NUMBERS.replace("Table 2,slow", "Table 2,slwo"), "slwo");
    refused(PAPER, &NUMBERS.replace(",expanded,", ",expandde,"), "expandde");
    refused(PAPER, &NUMBERS.replace("reduction_percent", "redcution_percent"), "redcution_percent");
    let (error, code) = reproduce(scratch.path(), "tinny", &["--papers", "."]);
    assert!(code == 2 && error.contains("did you mean `tiny`?"), "{error}");
    let (error, code) = reproduce(scratch.path(), "tiny", &[]);
    assert!(code == 2 && error.contains("--papers"), "{error}");
}

#[test]
fn the_shipped_papers_run() {
    let scratch = tempfile::tempdir().unwrap();
    let papers = root().join("scenarios/papers").display().to_string();
    let (error, code) =
        reproduce(scratch.path(), "all", &["--papers", &papers, "--episodes", "1", "--short", "--quiet"]);
    assert_eq!((code, error.as_str()), (0, ""));
    // What depends on the paper's numbers alone is the same for any number of episodes.
    for (paper, id, verdict) in [
        ("gao2025", "T2", "does not hold"),
        ("gao2025", "T3", "does not hold"),
        ("gao2025", "T7-3", "holds"),
        ("gao2025", "T7-5", "does not hold"),
        ("gao2025", "T9", "does not hold"),
        ("gao2025", "hardware", "cannot be tested"),
        ("hu2024", "T26-20", "does not hold"),
        ("hu2024", "T26-30", "does not hold"),
        ("zhao2025", "T21", "does not hold"),
        ("zhao2025", "T22", "does not hold"),
        ("zhu2025", "T19", "does not hold"),
    ] {
        let verdicts = columns(&scratch.path().join(format!("out/{paper}/verdicts.csv")), 0, 3);
        assert_eq!(verdicts[id], verdict, "{paper} {id}");
    }
    // One line for the claims and one for the questions of each, where it has any.
    let table = fs::read_to_string(scratch.path().join("out/verdicts.md")).unwrap();
    assert_eq!(table.matches("| claims |").count(), 5, "{table}");
    assert_eq!(table.lines().next(), Some(TABLE_HEAD));
}

const TABLE_HEAD: &str = "| paper | | all | holds | does not hold | depends | undecided | cannot be tested | not run |";

#[test]
fn all_papers_run_one_after_the_other_and_are_counted() {
    let scratch = tempfile::tempdir().unwrap();
    write_paper(scratch.path(), PAPER, NUMBERS);
    fs::write(scratch.path().join("another.paper.yaml"), PAPER).unwrap();
    let both = ["--papers", ".", "--quiet", "--short", "--episodes", "3"];
    assert_eq!(reproduce(scratch.path(), "all", &both), (String::new(), 0));
    let table = fs::read_to_string(scratch.path().join("out/verdicts.md")).unwrap();
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines[0], TABLE_HEAD);
    for (first, paper) in [(2, "another"), (4, "tiny")] {
        let verdicts = columns(&scratch.path().join("out").join(paper).join("verdicts.csv"), 0, 3);
        let numbers = |line: &str, what: &str| -> Vec<usize> {
            let cells = line.strip_prefix(&format!("| {paper} | {what} | ")).unwrap().trim_end_matches(" |");
            cells.split(" | ").map(|cell| cell.parse().unwrap()).collect()
        };
        let (claims, questions) = (numbers(lines[first], "claims"), numbers(lines[first + 1], "questions"));
        let count = |word: &str| verdicts.values().filter(|verdict| *verdict == word).count();
        let counts = ["holds", "does not hold", "depends", "undecided", "cannot be tested", "not run"].map(count);
        let sums: Vec<usize> = claims.iter().zip(&questions).map(|(a, b)| a + b).collect();
        assert_eq!(sums, [&[verdicts.len()], &counts[..]].concat());
    }
    // A fault in the last of them is found before the first one runs.
    fs::remove_dir_all(scratch.path().join("out")).unwrap();
    fs::write(scratch.path().join("tiny.paper.yaml"), PAPER.replace("table: slow,", "table: slowly,")).unwrap();
    let (error, code) = reproduce(scratch.path(), "all", &both);
    assert!(code == 2 && error.contains("slowly") && !scratch.path().join("out").exists(), "{error}");
    let (error, code) = reproduce(scratch.path(), "tiny", &["--short", "--full"]);
    assert!(code == 2 && error.contains("cannot be used with"), "{error}");
}

#[test]
fn every_table_of_the_shipped_papers_fits_each_of_its_choices() {
    let folder = root().join("scenarios/papers");
    let mut checked = 0;
    for name in Paper::names(&folder).unwrap() {
        let paper = Paper::read(&folder, &name).unwrap();
        for choice in &paper.manifest.ablate {
            for table in
                paper.manifest.tables.iter().filter(|table| choice.tables.iter().any(|id| *id == table.id.as_str()))
            {
                let (file, edits) = paper.scenario(table, Some(choice), Some(1)).unwrap();
                Experiment::load(&file, &edits).unwrap_or_else(|error| panic!("{name} {}: {error:?}", choice.id));
                checked += 1;
            }
        }
    }
    assert!(checked > 300, "{checked}");
}
