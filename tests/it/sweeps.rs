//! Sweeps from the outside: points, worlds, columns, resume.

use super::support::simrun;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const BASE: &str = "
map: {random: {cols: 20, rows: 20, obstacles: 60}}
obstacles: {moving: [random: {count: 2}]}
stacks: {global: [a_star], local: [dwa, pure_pursuit]}
episodes: 3
seed: 5
";

/// Writes a scenario, runs it and returns its rows, each as (column, value) by the header.
fn rows(folder: &Path, name: &str, text: &str) -> Vec<Vec<(String, String)>> {
    fs::write(folder.join(format!("{name}.yaml")), text).unwrap();
    simrun(folder).args([&format!("{name}.yaml"), "--quiet"]).ends_with(0);
    let mut reader = csv::Reader::from_path(folder.join(format!("results/{name}/episodes.csv"))).unwrap();
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    reader.records().map(|row| header.iter().cloned().zip(row.unwrap().iter().map(str::to_owned)).collect()).collect()
}

fn get<'a>(row: &'a [(String, String)], column: &str) -> &'a str {
    &row.iter().find(|(name, _)| name == column).unwrap().1
}

#[test]
fn a_sweep_adds_a_column_and_a_stack_that_it_does_not_touch_runs_once() {
    let scratch = tempfile::tempdir().unwrap();
    let text = format!("{BASE}sweep: {{stacks.local.dwa.horizon_s: [1, 2, 3]}}");
    let swept = rows(scratch.path(), "swept", &text);
    let count = |point: &str, stack: &str| {
        swept.iter().filter(|row| get(row, "point") == point && get(row, "stack") == stack).count()
    };
    for point in ["0", "1", "2"] {
        assert_eq!(count(point, "a_star+dwa"), 3);
        assert_eq!(count(point, "a_star+pure_pursuit"), if point == "0" { 3 } else { 0 });
    }
    assert!(swept.iter().all(|row| row.last().unwrap().0 == "stacks.local.dwa.horizon_s"));
    // Each episode is one world, whatever the point.
    for episode in ["0", "1", "2"] {
        let worlds: BTreeSet<&str> =
            swept.iter().filter(|row| get(row, "episode") == episode).map(|row| get(row, "world_digest")).collect();
        assert_eq!(worlds.len(), 1);
    }
    // The horizon does matter.
    let traces: BTreeSet<&str> = swept
        .iter()
        .filter(|row| get(row, "episode") == "0" && get(row, "local") == "dwa")
        .map(|row| get(row, "trace_digest"))
        .collect();
    assert_eq!(traces.len(), 3);
}

#[test]
fn every_point_is_the_plain_run_with_those_values() {
    let scratch = tempfile::tempdir().unwrap();
    let keys = "limits.speed_max_mps: [0.6, 0.9], obstacles.moving.0.random.count: [1, 4]";
    let swept = rows(scratch.path(), "swept", &format!("{BASE}sweep: {{{keys}}}"));
    for (point, (speed, count)) in [(0.6, 1), (0.6, 4), (0.9, 1), (0.9, 4)].into_iter().enumerate() {
        let text =
            BASE.replace("count: 2", &format!("count: {count}")) + &format!("limits: {{speed_max_mps: {speed}}}");
        let plain = rows(scratch.path(), &format!("plain{point}"), &text);
        let here: Vec<_> = swept.iter().filter(|row| get(row, "point") == point.to_string()).collect();
        assert_eq!(here.len(), plain.len());
        for (swept, plain) in here.iter().zip(&plain) {
            for (column, value) in plain.iter().filter(|(column, _)| column != "scenario" && column != "point") {
                assert_eq!(get(swept, column), value, "{column} at point {point}");
            }
        }
    }
}

#[test]
fn one_world_of_one_point_can_be_run_alone_and_all_of_it_again_with_other_threads() {
    let scratch = tempfile::tempdir().unwrap();
    let text = format!("{BASE}sweep: {{stacks.local.dwa.horizon_s: [1, 2]}}");
    rows(scratch.path(), "swept", &text);
    let all = fs::read_to_string(scratch.path().join("results/swept/episodes.csv")).unwrap();
    let one = simrun(scratch.path()).args(["swept.yaml", "--point", "1", "--episode", "2"]).ends_with(0).stdout;
    let (header, row) = one.split_once('\n').unwrap();
    assert!(all.starts_with(header) && all.contains(row) && row.contains("a_star+dwa"), "{one}");
    simrun(scratch.path()).args(["verify", "swept.yaml"]).ends_with(0);
    for (args, expected) in [
        (&["swept.yaml", "--point", "2", "--episode", "0"][..], "there is no point 2: the sweep has 2"),
        (&["swept.yaml", "--point", "1"], "name its --episode"),
    ] {
        let message = simrun(scratch.path()).args(args).ends_with(2).stderr;
        assert!(message.contains(expected), "{message}");
    }
    let listed = simrun(scratch.path()).args(["check", "swept.yaml"]).ends_with(0).stdout;
    assert!(listed.contains("1: stacks.local.dwa.horizon_s = 2: a_star+dwa"), "{listed}");
}

#[test]
fn a_point_that_changes_nothing_is_refused() {
    let scratch = tempfile::tempdir().unwrap();
    fs::write(scratch.path().join("same.yaml"), format!("{BASE}sweep: {{limits.speed_max_mps: [1, 1.0]}}")).unwrap();
    let message = simrun(scratch.path()).arg("same.yaml").ends_with(2).stderr;
    assert!(message.contains("changes nothing") || message.contains("there twice"), "{message}");
}
