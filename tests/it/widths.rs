//! Text fits the width that `COLUMNS` names, and is as wide as it needs to be where it names none.

use super::support::{Simrun, root, simrun};
use std::fs;

const STACKS: &str = "stacks:\n  global: [a_star, improved_dijkstra]\n  path: [[], [line_of_sight, b_spline]]\n  local: [dwa, pure_pursuit]\n";

/// What simrun prints to stdout at a width, after a look at its lines.
#[track_caller]
fn at(width: usize, command: &mut Simrun) -> String {
    let text = command.env("COLUMNS", &width.to_string()).ends_with(0).stdout;
    // A command to copy stays whole.
    for line in text.lines().filter(|line| !line.trim_start().starts_with("simrun ")) {
        assert!(line.chars().count() <= width, "{width} columns, {}: {line}", line.chars().count());
    }
    text
}

#[test]
fn every_table_fits_80_columns_and_loses_no_stack() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        "map: {{empty: {{cols: 12, rows: 10}}}}\nepisodes: 3\n{STACKS}sweep: {{limits.speed_max_mps: [0.8, 1]}}\n"
    );
    fs::write(folder.path().join("small.yaml"), text).unwrap();
    let stacks = ["a_star+dwa", "improved_dijkstra+line_of_sight+b_spline+pure_pursuit"];
    let said = at(80, simrun(folder.path()).args(["run", "small.yaml", "--out", "out"]));
    assert!(stacks.iter().all(|stack| said.contains(stack)), "{said}");
    assert!(said.contains("limits.speed_max_mps = 0.8:"), "{said}");

    for arguments in
        [&["analyze", "out"][..], &["analyze", "out", "--all-pairs"], &["analyze", "out", "--compare-points"]]
    {
        let narrow = at(80, simrun(folder.path()).args(arguments));
        let wide = simrun(folder.path()).args(arguments).ends_with(0).stdout;
        assert!(wide.lines().any(|line| line.chars().count() > 100), "{wide}");
        // Broken elsewhere, and the same words: tables go on below with their names, so the narrow form has more of those.
        for word in wide.split_whitespace().filter(|word| !word.contains(['+', '.'])) {
            assert!(narrow.contains(word), "{word} is lost\n{narrow}");
        }
    }
    at(80, simrun(folder.path()).args(["check", "small.yaml"]));
    at(60, simrun(folder.path()).args(["planners"]));
    at(60, simrun(folder.path()).args(["planners", "dwa"]));
}

#[test]
fn what_goes_to_a_file_is_as_wide_as_ever() {
    let folder = tempfile::tempdir().unwrap();
    let table = root().join("results/reference/05_crossing/episodes.csv");
    let wide = simrun(folder.path()).arg("analyze").arg(&table).ends_with(0).stdout;
    simrun(folder.path()).env("COLUMNS", "60").arg("analyze").arg(&table).args(["--out", "report.txt"]).ends_with(0);
    assert_eq!(fs::read_to_string(folder.path().join("report.txt")).unwrap(), wide);
}
