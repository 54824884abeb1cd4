//! One test for each bug that was found in use or by review and that no other test would have shown.

use super::support::simrun;
use std::fs;
use std::path::Path;

const BASE: &str = "
map: {random: {cols: 20, rows: 20, obstacles: 60}}
episodes: 1
seed: 5
";

fn write(folder: &Path, name: &str, text: &str) {
    fs::write(folder.join(name), format!("{BASE}{text}\n")).unwrap();
}

#[test]
fn a_row_of_a_sweep_is_run_alone_by_its_own_point_and_stack() {
    let scratch = tempfile::tempdir().unwrap();
    write(
        scratch.path(),
        "swept.yaml",
        "stacks: {global: [a_star, dijkstra], local: [dwa]}
sweep: {stacks.local.dwa.horizon_s: [1, 2], stacks.global.a_star.corner_rule: [forbid, allow]}",
    );
    simrun(scratch.path()).args(["swept.yaml", "--quiet"]).ends_with(0);
    let rows = fs::read_to_string(scratch.path().join("results/swept/episodes.csv")).unwrap();
    let mut checked = 0;
    for row in rows.lines().skip(1) {
        let fields: Vec<&str> = row.split(',').collect();
        let (point, stack) = (fields[1], fields[2]);
        let alone = ["swept.yaml", "--point", point, "--episode", "0", "--stack", stack];
        let alone = simrun(scratch.path()).args(alone).ends_with(0).stdout;
        assert_eq!(alone.lines().nth(1), Some(row), "point {point}, {stack}");
        checked += 1;
    }
    assert!(checked >= 6, "{rows}");
}

#[test]
fn a_product_over_keys_of_two_planners_runs() {
    let scratch = tempfile::tempdir().unwrap();
    write(
        scratch.path(),
        "swept.yaml",
        "stacks: {global: [a_star], local: [dwa, pure_pursuit]}
sweep: {stacks.local.dwa.horizon_s: [1, 2], stacks.local.pure_pursuit.lookahead_m: [0.5, 1.0]}",
    );
    simrun(scratch.path()).args(["swept.yaml", "--quiet"]).ends_with(0);
    // Each stack once at each of its own settings.
    let rows = fs::read_to_string(scratch.path().join("results/swept/episodes.csv")).unwrap();
    assert_eq!(rows.lines().count(), 1 + 2 + 2, "{rows}");
}

#[test]
fn one_column_of_a_zip_may_repeat_a_value() {
    let scratch = tempfile::tempdir().unwrap();
    write(
        scratch.path(),
        "swept.yaml",
        "stacks: {global: [a_star], local: [dwa]}
sweep: {zip: {limits.speed_max_mps: [0.5, 0.5, 1.0], stacks.local.dwa.horizon_s: [1, 2, 2]}}",
    );
    simrun(scratch.path()).args(["swept.yaml", "--quiet"]).ends_with(0);
}

#[test]
fn what_a_planner_cannot_do_on_this_map_is_refused_before_the_run() {
    let scratch = tempfile::tempdir().unwrap();
    let text = "map: {empty: {cols: 30, rows: 30, resolution_m: 0.05}}
limits: {speed_max_mps: 20}
stacks: {global: [a_star], local: [{dwa: {horizon_s: 500}}]}\n";
    fs::write(scratch.path().join("long.yaml"), text).unwrap();
    let said = simrun(scratch.path()).args(["check", "long.yaml"]).ends_with(2).stderr;
    assert!(said.contains("horizon_s"), "{said}");
}

#[test]
fn a_map_that_is_not_there_is_missed_without_a_word_about_scenarios() {
    let scratch = tempfile::tempdir().unwrap();
    let said = simrun(scratch.path()).args(["map", "info", "nowhere.map"]).ends_with(2).stderr;
    assert!(said.contains("nowhere.map") && !said.contains("scenario"), "{said}");
}

#[test]
fn every_error_says_that_it_is_one() {
    let scratch = tempfile::tempdir().unwrap();
    write(scratch.path(), "one.yaml", "stacks: {global: [a_star], local: [dwa]}");
    simrun(scratch.path()).args(["one.yaml", "--quiet"]).ends_with(0);
    let said = simrun(scratch.path()).args(["one.yaml", "--set", "limits.speed_max_mps=0.5"]).ends_with(1).stderr;
    assert!(said.lines().any(|line| line.starts_with("error:")), "{said}");
}

#[test]
fn an_episode_plans_the_path_that_simrun_plan_shows() {
    // Episodes handed the stages the bends of a path alone, `simrun plan` every cell: 7.4142 m and 7.2361 m here.
    let scratch = tempfile::tempdir().unwrap();
    let rows = "......\n......\n@.....\n@.....\n..@...\n..@...\n";
    fs::write(scratch.path().join("mini.map"), format!("type octile\nheight 6\nwidth 6\nmap\n{rows}")).unwrap();
    let scenario = "map: {movingai: {file: mini.map}}\nstart: {cell: [0, 0]}\ngoal: {cell: [5, 5]}\nrobot: {radius_m: 0.2}\n\
                    planning: {inflation_m: 0}\nstacks: {global: [a_star, dijkstra], path: [[clearance_prune], \
                    [line_of_sight], [clearance_prune, arc_fillet], []], local: [pure_pursuit]}\n";
    fs::write(scratch.path().join("mini.yaml"), scenario).unwrap();
    let column = |table: &str, name: &str| -> Vec<f64> {
        let mut lines = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let at = lines.next().unwrap().iter().position(|&column| column == name).unwrap();
        lines.map(|fields| fields[at].parse().unwrap()).collect()
    };
    let episodes = simrun(scratch.path()).args(["mini.yaml", "--episode", "0"]).ends_with(0).stdout;
    let mut shown = Vec::new();
    for global in ["a_star", "dijkstra"] {
        for stages in ["clearance_prune", "line_of_sight", "clearance_prune,arc_fillet", ""] {
            let mut plan = simrun(scratch.path());
            plan.args(["plan", "mini.map", "--from", "0,5", "--to", "5,0", "--global", global]);
            let table = if stages.is_empty() { &mut plan } else { plan.args(["--path", stages]) }.ends_with(0).stdout;
            shown.extend(column(&table, "length_m"));
        }
    }
    let planned = column(&episodes, "planned_length_m");
    assert!(planned.len() == 8 && (planned[0] - 7.2361).abs() < 1e-4, "{planned:?}");
    assert!(planned.iter().zip(&shown).all(|(a, b)| (a - b).abs() < 1e-9), "{planned:?} {shown:?}");
}
