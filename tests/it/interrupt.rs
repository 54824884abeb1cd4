//! Ctrl-C and SIGTERM: what was finished is kept, and the command that simrun prints goes on to the same bytes.

use crate::support::simrun;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Worlds that take some hundredths of a second each.
const SCENARIO: &str = "map: {empty: {cols: 40, rows: 30, resolution_m: 0.5}}\nepisodes: 60\n\
    obstacles: {moving: [{random: {count: 3}}]}\nstacks: {global: [a_star], local: [dwa, pure_pursuit]}\n";

const TABLES: [&str; 3] = ["episodes.csv", "states.csv", "summary.csv"];

/// Starts a run whose stderr is read line by line.
fn start(folder: &Path, words: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_simrun"));
    command.current_dir(folder).env("NO_COLOR", "1").args(words);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Waits until the table holds so many bytes.
fn wait_for(table: &Path, bytes: u64, child: &mut Child) {
    while fs::metadata(table).map_or(0, |table| table.len()) < bytes && child.try_wait().unwrap().is_none() {
        std::thread::yield_now();
    }
}

#[test]
fn a_run_that_is_interrupted_again_and_again_ends_in_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("my worlds.yaml"), SCENARIO).unwrap();
    let words =
        ["my worlds.yaml", "--set", "limits.speed_max_mps=0.9", "--set", "name=worlds", "--threads", "2", "--out"];
    simrun(folder.path()).args(words).arg("whole").ends_with(0);
    let whole = |name: &str| fs::read(folder.path().join("whole").join(name)).unwrap();
    let all = whole("episodes.csv").len() as u64;

    let words = [&words[..], &["it's here"]].concat();
    let table = folder.path().join("it's here/episodes.csv");
    let mut interrupted = 0;
    for (tenths, name, code) in [(1, "INT", 130), (3, "TERM", 143), (4, "INT", 130), (8, "INT", 130)] {
        let mut child = start(folder.path(), &words);
        wait_for(&table, all * tenths / 10, &mut child);
        signal(&child, name);
        let output = child.wait_with_output().unwrap();
        let (stdout, stderr) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        if output.status.code() == Some(0) {
            // It was over before.
            continue;
        }
        interrupted += 1;
        assert_eq!(output.status.code(), Some(code), "{stderr}");
        assert!(stderr.contains("finishing the worlds in hand"), "{stderr}");
        assert!(stdout.contains("a_star+pure_pursuit") && !table.with_file_name("summary.csv").exists(), "{stdout}");
        let (_, said) = stderr.split_once("interrupted: ").unwrap();
        let kept: usize = said.split_once(" of 60 worlds are kept in it's here").unwrap().0.parse().unwrap();
        let rows = fs::read_to_string(&table).unwrap().lines().count() - 1;
        assert_eq!(rows, 2 * kept, "whole worlds, all of them written");
        let expected = r"simrun 'my worlds.yaml' --set limits.speed_max_mps=0.9 --set name=worlds --threads 2 --out 'it'\''s here'";
        assert!(said.trim_end().ends_with(expected), "{said}");
    }
    assert!(interrupted > 0);
    simrun(folder.path()).args(&words).ends_with(0);
    for name in TABLES {
        assert!(fs::read(table.with_file_name(name)).unwrap() == whole(name), "{name} differs");
    }
}

#[test]
fn the_command_that_is_printed_goes_on_and_forces_nothing() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("worlds.yaml"), SCENARIO).unwrap();
    let mut child = start(folder.path(), &["worlds.yaml", "--force", "--quiet", "--set", "goal=[15, 12]"]);
    wait_for(&folder.path().join("results/worlds/episodes.csv"), 2000, &mut child);
    signal(&child, "INT");
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), output.stdout.len()), (Some(130), 0), "{stderr}");
    let command = stderr.lines().last().unwrap().trim();
    assert!(command.ends_with("simrun worlds.yaml --quiet --set 'goal=[15, 12]'"), "{command}");
    let went_on = Command::new("sh").current_dir(folder.path()).args(["-c", command]).output().unwrap();
    assert_eq!(went_on.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&went_on.stderr).contains("going on after"));
}

#[test]
fn the_second_signal_ends_it_at_once() {
    let folder = tempfile::tempdir().unwrap();
    // A world that takes minutes.
    let long = SCENARIO.replace("dwa,", "{dwa: {speed_samples: 500, yaw_rate_samples: 500}},");
    fs::write(folder.path().join("long.yaml"), long).unwrap();
    let mut child = start(folder.path(), &["long.yaml"]);
    wait_for(&folder.path().join("results/long/timings.csv"), 1, &mut child);
    let mut stderr = BufReader::new(child.stderr.take().unwrap()).lines();
    signal(&child, "INT");
    let said = stderr.next().unwrap().unwrap();
    assert!(said.contains("the same signal once more ends at once"), "{said}");
    signal(&child, "INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(stderr.next().is_none(), "no word of what was kept: nobody waited for it");
}
