//! Inputs and processes that once broke a promise: each is refused with a message, or is a row, and nothing else happens.

use super::support::{Simrun, root, simrun};
use std::fs;
use std::path::{Path, PathBuf};

fn cases() -> PathBuf {
    root().join("tests/cases/faults")
}

/// A call in the folder of the cases.
fn call(arguments: &str) -> Simrun {
    let mut call = simrun(&cases());
    call.args(arguments.split_whitespace());
    call
}

/// Calls, the code with which each ends, and what each must say.
const CALLS: [(&str, i32, &[&str]); 22] = [
    // Where physics ends.
    (
        "check sweep_with_one_huge_cell.yaml",
        2,
        &["`map.empty.resolution_m` is 1e300", "expected 0.0001 to 10000 m", "[1]"],
    ),
    ("check sweep_with_one_huge_horizon.yaml", 2, &["horizon_s", "at most 10000000 s", "[2]"]),
    ("check actuation_noise_1e30.yaml", 2, &["`actuation.speed_noise_share` is 1e30, expected at most 100", ":3:"]),
    ("check speed_1e9.yaml", 2, &["`limits.speed_max_mps` is 1000000000, expected at most 1000 m/s", ":3:"]),
    ("check movers_1e9.yaml", 2, &["`obstacles.moving[0].random.count` is 1000000000, expected at most 100000"]),
    ("check far_recording.yaml", 2, &["far_recording.csv: line 2, column `x`: expected at most 100000000 m"]),
    ("check hypercube_range_reversed.yaml", 2, &["goes from 1 to 0.1", "expected [lowest, highest]"]),
    // Sizes that do not fit.
    ("check cells_16384.yaml --memory-limit 2GiB", 2, &["GiB of memory, of 2 GiB that it may", "--memory-limit"]),
    ("run cells_16384.yaml --memory-limit 2GiB", 2, &["GiB of memory, of 2 GiB that it may"]),
    ("check speed_1e9.yaml --memory-limit lots", 2, &["expected a size such as 4GiB or 500MB"]),
    // Files that are none, or hostile.
    ("check map_file_dev_zero.yaml", 2, &["found a device, expected a regular file"]),
    ("check recording_dev_zero.yaml", 2, &["found a device, expected a regular file"]),
    ("plan hall.map --scen /dev/zero --global a_star", 2, &["a device"]),
    ("check brackets_19000.yaml", 2, &["nested more than 32 deep"]),
    ("check ros_header_60000_brackets.yaml", 2, &["ros_header_60000_brackets.map.yaml:1:", "open brackets"]),
    // Messages that are true.
    ("check alias_in_a_contradiction.yaml", 2, &["the robot starts at its goal", ":4:"]),
    ("check real_where_a_count_belongs.yaml", 2, &["is `1000.0`, expected a whole number", ":3:"]),
    ("check hexadecimal_where_a_real_belongs.yaml", 0, &[]),
    // Queries of another map, and far outside.
    ("plan hall.map --queries queries_row_i32_min.csv --global a_star", 2, &["line 2", "outside the map"]),
    ("plan hall.map --scen of_another_map.scen --global a_star", 2, &["line 2", "512 x 512", "48 x 30"]),
    // Ten thousand points are checked, not compared with one another.
    ("check sweep_of_10000_points.yaml", 0, &[]),
    ("check point_of_a_stack_run_alone.yaml", 0, &[]),
];

#[test]
fn every_case_ends_as_it_should() {
    for (arguments, code, said) in CALLS {
        let answer = call(arguments).ends_with(code);
        for words in said {
            assert!(answer.stderr.contains(words), "{arguments}: no `{words}` in\n{}", answer.stderr);
        }
        assert!(!answer.stderr.contains("panicked") && !answer.stderr.contains("simrun itself"), "{}", answer.stderr);
    }
}

/// One more line for a small scenario, and what must be said of it.
const LINES: [(&str, &str); 18] = [
    ("robot: {radius_m: 1e30}", "expected at most 100000 m"),
    ("robot: {radius_m: 1e-300}", "expected 0 or at least 0.000001 m"),
    ("limits: {acceleration_max_mps2: 1e300}", "expected at most 1000000 m/s²"),
    ("limits: {yaw_rate_max_radps: 1e30}", "expected at most 10000 rad/s"),
    ("termination: {timeout_s: 1e300}", "expected at most 10000000 s"),
    ("termination: {stuck_radius_m: 1e38}", "expected at most 100000 m"),
    ("metrics: {encounter_m: 1e30}", "expected at most 100000 m"),
    ("sensing: {range_noise_m: 1e30}", "expected at most 100000 m"),
    ("localisation: {heading_drift_rad: 1e30}", "expected at most 10000 rad"),
    ("planning: {compute: {per_expansion_s: 1e300}}", "expected at most 10000000 s"),
    ("goal: [1e300, 5]", "expected at most 100000000 m"),
    ("obstacles: {moving: [fixed: {position: [5, 5], velocity_mps: [1e30, 0]}]}", "expected at most 1000 m/s"),
    ("obstacles: {moving: [random: {count: 2, speed_mps: [1, 1e30]}]}", "expected at most 1000 m/s"),
    ("obstacles: {moving: [patrol: {waypoints: [[1, 1], [1e300, 1]], speed_mps: 1}]}", "expected at most 100000000 m"),
    ("script: [{at_s: 1e300, event: {goal: {to: [3, 3]}}}]", "expected at most 10000000 s"),
    ("sweep: {stacks.local.dwa.d_cap_m: [1, 1e30]}", "sweep['stacks.local.dwa.d_cap_m'][1]"),
    ("sweep: {stacks.local.dwa.horizon_s: [1, 1e6]}", "are too much for one decision"),
    ("sweep: {limits.speed_max_mps: {from: 1, to: 1e30, steps: 3}}", "expected at most 1000 m/s"),
];

#[test]
fn a_number_beyond_physics_is_refused_with_its_line_wherever_it_stands() {
    let scratch = tempfile::tempdir().unwrap();
    for (line, said) in LINES {
        let text =
            format!("map: {{empty: {{cols: 20, rows: 10}}}}\nstacks: {{global: [a_star], local: [dwa]}}\n{line}\n");
        fs::write(scratch.path().join("far.yaml"), text).unwrap();
        let answer = simrun(scratch.path()).args(["check", "far.yaml"]).ends_with(2);
        assert!(answer.stderr.contains(said), "{line}: no `{said}` in\n{}", answer.stderr);
    }
}

#[test]
fn dwa_arrives_whatever_the_drive_accelerates_at() {
    let scratch = tempfile::tempdir().unwrap();
    for acceleration in ["0.5", "2", "5", "10"] {
        let mut run = call("run dwa_stops_short_of_the_goal.yaml --quiet --require-success 1");
        run.arg(format!("--set=limits.acceleration_max_mps2={acceleration}"));
        run.arg("--out").arg(scratch.path().join(acceleration)).ends_with(0);
    }
}

#[test]
fn as_many_threads_as_anybody_asks_for_are_no_fault() {
    let scratch = tempfile::tempdir().unwrap();
    let mut run = simrun(root());
    run.args([
        "run",
        "scenarios/01_empty.yaml",
        "--episodes",
        "3",
        "--threads",
        "100000",
        "--quiet",
        "--memory-limit",
        "1PiB",
    ]);
    run.arg("--out").arg(scratch.path()).ends_with(0);
}

const SMALL: &str = "map: {random: {cols: 20, rows: 20, obstacles: 40}}
obstacles: {moving: [random: {count: 3}]}
stacks: {global: [a_star, dijkstra], local: [dwa, pure_pursuit]}
sweep: {limits.speed_max_mps: [0.5, 1]}
episodes: 2
";

/// The tables of a run.
fn tables(folder: &Path) -> [String; 3] {
    ["episodes.csv", "states.csv", "summary.csv"].map(|file| fs::read_to_string(folder.join(file)).unwrap())
}

#[test]
fn tables_of_child_processes_are_those_of_threads() {
    let scratch = tempfile::tempdir().unwrap();
    fs::write(scratch.path().join("small.yaml"), SMALL).unwrap();
    let run = |more: &[&str]| {
        let out = more.join("_").replace('-', "");
        let mut run = simrun(scratch.path());
        run.args(["run", "small.yaml", "--quiet", "--seed", "3", "--set", "robot.radius_m=0.2", "--out", &out]);
        run.args(more).ends_with(0);
        tables(&scratch.path().join(out))
    };
    let expected = run(&["--threads", "2"]);
    assert!(expected[0].lines().count() == 1 + 2 * 2 * 4, "{}", expected[0]);
    assert_eq!(run(&["--threads", "1", "--isolate"]), expected);
    assert_eq!(run(&["--threads", "3", "--isolate", "--give-up-after", "600"]), expected);
}

#[test]
fn giving_up_needs_children() {
    for arguments in ["run speed_1e9.yaml --give-up-after 3", "run speed_1e9.yaml --isolate --give-up-after 0"] {
        call(arguments).ends_with(2);
    }
}
