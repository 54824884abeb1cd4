//! `simrun reproduce` and `simrun analyze` from the outside, on papers and rows made up for the test.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use assert_cmd::Command;
use std::fs;
use std::path::Path;

fn simrun(folder: &Path) -> Command {
    let mut command = Command::cargo_bin("simrun").unwrap();
    command.current_dir(folder).env("NO_COLOR", "1");
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

const SCENARIO: &str = "
map: {random: {cols: 20, rows: 20, obstacles: 60}}
start: {cell: [0, 19]}
goal: {cell: [19, 0]}
obstacles: {moving: [random: {count: 2, speed_mps: [0.8, 1.0]}]}
stacks:
  - {name: short, global: a_star, local: dwa}
  - {name: blind, global: a_star, local: pure_pursuit}
  - {name: greedy, global: imp_a_star, local: pure_pursuit}
episodes: 12
seed: 3
";

const PAPER: &str = "
title: A made-up paper
citation: nobody
about: Nothing.
method: Nothing.
published: numbers.csv
tables:
  - {id: t1, title: As it is, scenario: world.yaml}
  - {id: t1_still, title: Without movers, scenario: world.yaml, set: ['obstacles.moving=[]'], stacks: [short, blind]}
claims:
  - {id: fewer, says: The greedy search expands less, test: {compare: {metric: expanded, of: {table: t1, stack: greedy}, is: less, than: {table: t1, stack: short}, over: all}}}
  - {id: same, says: One planner plans one length, test: {differ: {metric: planned_length_m, tables: [t1], stacks: [short, blind], tolerance: 1.0e-9}}}
  - {id: tiny, says: Drives are below 1 m, test: {range: {metric: length_m, table: t1, at_most: 1}}}
  - {id: reach, says: The tracker reaches 10 of 100 where nothing moves, test: {reach: {of: {table: t1_still, stack: blind}}}}
  - {id: fisher, says: The counts tell them apart, test: {fisher: {of: {table: t1, stack: short}, than: {table: t1, stack: blind}}}}
  - {id: whole, says: Rates are counts, test: {multiples: {table: t1}}}
  - {id: never, says: It is pretty, test: {untestable: {because: beauty}}}
";

const NUMBERS: &str = "where,table,stack,against,metric,quantity,unit,value,trials,note
Table 1,t1,short,,success,mean,%,90.0,100,
Table 1,t1,blind,,success,mean,%,10.0,100,
Table 1,t1,greedy,,success,mean,%,33.34,100,not a count
text,t1,greedy,short,planned_length_m,reduction_percent,%,5,,
";

fn paper(folder: &Path) {
    fs::create_dir_all(folder.join("papers")).unwrap();
    fs::write(folder.join("papers/world.yaml"), SCENARIO).unwrap();
    fs::write(folder.join("papers/made_up.paper.yaml"), PAPER).unwrap();
    fs::write(folder.join("papers/numbers.csv"), NUMBERS).unwrap();
}

#[test]
fn a_paper_is_run_judged_and_reported_and_goes_on_after_a_break() {
    let scratch = tempfile::tempdir().unwrap();
    paper(scratch.path());
    let run = || simrun(scratch.path()).args(["reproduce", "made_up", "--papers", "papers"]).assert().success();
    run();
    let out = scratch.path().join("results/reproduce/made_up");
    let read = |name: &str| fs::read_to_string(out.join(name)).unwrap();
    let verdicts = read("verdicts.csv");
    for (id, expected) in [
        ("fewer", "holds"),
        ("same", "does not hold"),
        ("tiny", "does not hold"),
        ("reach", "holds"),
        ("fisher", "holds"),
        ("whole", "does not hold"),
        ("never", "cannot be tested"),
    ] {
        let line = verdicts.lines().find(|line| line.starts_with(&format!("{id},"))).unwrap();
        assert!(line.contains(&format!(",{expected},")), "{line}");
    }
    let report = read("report.md");
    for part in ["# A made-up paper", "## The claims", "## Why drives failed", "checks on 60 rows, 0 broken", "(90.0)"]
    {
        assert!(report.contains(part), "the report lacks `{part}`:\n{report}");
    }
    let rows = read("t1/episodes.csv");
    // A row is lost, as if the run had been cut short: it comes back, and nothing else moves.
    let cut: String = rows.lines().take(20).map(|line| format!("{line}\n")).collect();
    fs::write(out.join("t1/episodes.csv"), cut).unwrap();
    run();
    assert_eq!(read("t1/episodes.csv"), rows);
    assert_eq!(read("report.md"), report);
}

#[test]
fn a_paper_that_is_not_there_or_contradicts_itself_is_refused() {
    let scratch = tempfile::tempdir().unwrap();
    paper(scratch.path());
    let refused = |name: &str, expected: &str| {
        let assert = simrun(scratch.path()).args(["reproduce", name, "--papers", "papers"]).assert().code(2);
        let message = text(&assert.get_output().stderr);
        assert!(message.contains(expected), "{message}");
    };
    refused("made_upp", "did you mean `made_up`?");
    let broken = PAPER.replace("table: t1_still, stack: blind", "table: t2, stack: blind");
    fs::write(scratch.path().join("papers/broken.paper.yaml"), broken).unwrap();
    refused("broken", "claim `reach` asks about `t2`, which is no table");
    let unknown = PAPER.replace("set: ['obstacles.moving=[]']", "set: ['obstacles.movin=[]']");
    fs::write(scratch.path().join("papers/unknown.paper.yaml"), unknown).unwrap();
    refused("unknown", "did you mean `moving`?");
    assert!(!scratch.path().join("results").exists(), "nothing was written");
}

#[test]
fn rows_are_compared_in_pairs_and_with_an_older_run() {
    let scratch = tempfile::tempdir().unwrap();
    fs::write(scratch.path().join("world.yaml"), SCENARIO).unwrap();
    let run = |out: &str, set: &[&str]| {
        let mut command = simrun(scratch.path());
        command.args(["world.yaml", "--quiet", "--episodes", "30", "--out", out]).args(set).assert().success();
    };
    run("old", &[]);
    run("slow", &["--set", "limits.speed_max_mps=0.5"]);
    let analyze = |args: &[&str]| simrun(scratch.path()).arg("analyze").args(args).output().unwrap();

    let plain = text(&analyze(&["old/episodes.csv"]).stdout);
    assert!(plain.contains("blind   short      success") && plain.contains("Holm"), "{plain}");
    let csv = text(&analyze(&["old/episodes.csv", "--all-pairs", "--format", "csv"]).stdout);
    assert_eq!(csv.lines().count(), 1 + 3 * 4, "three pairs, four metrics each:\n{csv}");
    let markdown = text(&analyze(&["old/episodes.csv", "--format", "markdown", "--unpaired"]).stdout);
    assert!(markdown.contains("| stack |") && markdown.contains("independent samples"), "{markdown}");
    let wrong = analyze(&["old/episodes.csv", "--reference", "blin"]);
    assert!(wrong.status.code() == Some(2) && text(&wrong.stderr).contains("did you mean `blind`?"));
    let missing = analyze(&["none.csv"]);
    assert!(missing.status.code() == Some(2) && text(&missing.stderr).contains("cannot read `none.csv`"));

    let same = analyze(&["old/episodes.csv", "--baseline", "old/episodes.csv"]);
    assert!(same.status.success() && text(&same.stdout).contains("90 rows in both, 0 moved"));
    let worse = analyze(&["slow/episodes.csv", "--baseline", "old/episodes.csv"]);
    assert_eq!(worse.status.code(), Some(3), "{}", text(&worse.stdout));
    assert!(text(&worse.stderr).contains("time_s by +"), "{}", text(&worse.stderr));
}
