//! Folders of results as input: their failures, and drawing and driving their episodes again.

use super::support::simrun;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A hall whose wall stops the local planner alone, with a sweep; the map is a file beside the scenario.
const SCENARIO: &str = "map: hall.map\nepisodes: 3\nstart: {x: 2.5, y: 3.5, heading_rad: 0}\ngoal: [17.5, 3.5]\n\
    stacks:\n  - {global: a_star, local: pure_pursuit}\n  - {name: alone, global: none, local: dwa}\n\
    sweep: {limits.speed_max_mps: [0.5, 1]}\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("sub dir")).unwrap();
    let map =
        format!("type octile\nheight 7\nwidth 20\nmap\n{}\n{}", ".".repeat(20), "..........@@........\n".repeat(6));
    fs::write(folder.path().join("sub dir/hall.map"), map).unwrap();
    fs::write(folder.path().join("sub dir/hall.yaml"), SCENARIO).unwrap();
    simrun(folder.path()).args(["sub dir/hall.yaml", "--out", "out", "--quiet"]).ends_with(0);
    folder
}

/// Runs a line that simrun printed, with the simrun under test.
#[track_caller]
fn shell(folder: &Path, line: &str) -> String {
    let line = line.replacen("simrun", env!("CARGO_BIN_EXE_simrun"), 1);
    let output = Command::new("sh").current_dir(folder).args(["-c", &line]).output().unwrap();
    assert!(output.status.success(), "{line}\n{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn failures_are_listed_by_cause_with_commands_that_drive_them_again() {
    let folder = folder();
    let text = simrun(folder.path()).args(["failures", "out"]).ends_with(0).stdout;
    assert!(text.contains(" of 12 episodes failed"), "{text}");
    // It sees the wall between itself and the goal and has no path around it.
    assert!(text.contains("stuck: the robot got stuck among known obstacles (6)"), "{text}");
    assert!(text.contains("  alone, episode 2, point 1, after "), "{text}");
    let episodes = fs::read_to_string(folder.path().join("out/episodes.csv")).unwrap();
    let expected =
        episodes.lines().find(|line| line.starts_with("hall,1,alone,") && line.contains(",2,1,stuck,")).unwrap();

    let line = text.lines().find(|line| line.contains("simrun run out --episode 2 --point 1 --stack alone")).unwrap();
    assert!(shell(folder.path(), line.trim()).contains(expected), "the same row again");
    assert!(folder.path().join("out/traces/p0001_e000002_alone.csv").exists());
    let line = text.lines().find(|line| line.contains("simrun draw out --episode 2 --point 1 --stack alone")).unwrap();
    shell(folder.path(), line.trim());
    assert!(fs::read_to_string(folder.path().join("p1_e2_alone.svg")).unwrap().contains("alone, episode 2"));

    let table =
        simrun(folder.path()).args(["failures", "out", "--format", "csv", "--stack", "alone"]).ends_with(0).stdout;
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 7, "{table}");
    assert_eq!(lines[0], "point,stack,episode,seed,outcome,collision_with,at_rest,cause,time_s,message,draw,run");
    let few = simrun(folder.path()).args(["failures", "out", "--stack", "alone", "--each", "2"]).ends_with(0).stdout;
    assert!(few.contains("… and 4 more"), "{few}");
    let quick = simrun(folder.path()).args(["failures", "out", "--outcomes", "--stack", "alone"]).ends_with(0).stdout;
    assert!(quick.contains("\nstuck (6)\n"), "{quick}");
}

#[test]
fn a_folder_of_results_is_a_scenario_also_from_elsewhere() {
    let folder = folder();
    let elsewhere = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let before = fs::read(out.join("episodes.csv")).unwrap();
    let said = simrun(elsewhere.path()).arg("run").arg(&out).ends_with(0).stderr;
    assert!(said.contains("complete, nothing to run"), "{said}");
    simrun(elsewhere.path()).arg("run").arg(&out).args(["--episodes", "4", "--quiet"]).ends_with(0);
    let after = fs::read(out.join("episodes.csv")).unwrap();
    assert!(after.len() > before.len());
    let episode =
        simrun(elsewhere.path()).arg("run").arg(&out).args(["--episode", "3", "--stack", "alone"]).ends_with(0);
    let row = episode.stdout.lines().nth(1).unwrap();
    assert!(String::from_utf8(after).unwrap().contains(row), "{row}");
    for (words, part) in [(["draw", "."], "found a folder without results"), (["failures", "."], "episodes.csv")] {
        let said = simrun(elsewhere.path()).args(words).ends_with(2).stderr;
        assert!(said.contains(part), "{said}");
    }
}

#[test]
fn the_resolved_scenario_is_the_same_run() {
    let folder = folder();
    let resolved = simrun(folder.path()).args(["check", "--resolved", "sub dir/hall.yaml"]).ends_with(0).stdout;
    assert!(resolved.contains("  # used: "), "{resolved}");
    fs::write(folder.path().join("sub dir/resolved.yaml"), &resolved).unwrap();
    let said = simrun(folder.path()).args(["sub dir/resolved.yaml", "--out", "out"]).ends_with(0).stderr;
    assert!(said.contains("complete, nothing to run"), "{said}");
    // The shorthands of the first file are other words for the same run.
    let short = SCENARIO
        .replace("hall.map", "{movingai: hall.map}")
        .replace("{x: 2.5, y: 3.5, heading_rad: 0}", "[2.5, 3.5, 0]");
    fs::write(folder.path().join("sub dir/short.yaml"), format!("name: hall\n{short}")).unwrap();
    let said = simrun(folder.path()).args(["sub dir/short.yaml", "--out", "out"]).ends_with(0).stderr;
    assert!(said.contains("complete, nothing to run"), "{said}");
}

#[test]
fn a_requirement_is_judged_for_one_episode_too() {
    let folder = folder();
    for (stack, code) in [("alone", 3), ("a_star+pure_pursuit", 0)] {
        let words = ["run", "out", "--episode", "0", "--stack", stack, "--require-success", "1"];
        simrun(folder.path()).args(words).ends_with(code);
    }
}

#[test]
fn a_picture_is_not_written_under_a_name_that_promises_another_format() {
    let folder = folder();
    let said = simrun(folder.path()).args(["draw", "out", "--stack", "alone", "-o", "x.jpg"]).ends_with(2).stderr;
    assert!(said.contains("x.jpg") && said.contains(".svg"), "{said}");
    assert!(!folder.path().join("x.jpg").exists());
}

#[test]
fn what_is_wrong_with_several_scenarios_is_told_at_once() {
    let folder = folder();
    for (name, text) in
        [("one.yaml", "map: warehouse\nstacks: {global: [astar], local: [dwa]}\nseed: -1\n"), ("two.yaml", "map: 5\n")]
    {
        fs::write(folder.path().join(name), text).unwrap();
    }
    for command in ["check", "run"] {
        let said = simrun(folder.path()).args([command, "one.yaml", "sub dir/hall.yaml", "two.yaml"]).ends_with(2);
        assert_eq!(said.stderr.matches("error: ").count(), 4, "{}", said.stderr);
        assert!(!folder.path().join("results").exists());
        assert_eq!(said.stdout.contains("hall.yaml: valid"), command == "check");
    }
}
