//! `simrun plan` and `simrun map` as a user meets them; with the benchmarks beside the repository also against published optima.

use super::support::{Answer, benchmarks, root, simrun};
use std::fs;
use std::path::Path;

/// Exit code, stdout, stderr.
fn run(folder: &Path, args: &[&str]) -> (i32, String, String) {
    let Answer { code, stdout, stderr } = simrun(folder).args(args).answer();
    (code, stdout, stderr)
}

/// 8 columns, 4 rows; a wall with a gap on top.
const HALL: &str = "type octile\nheight 4\nwidth 8\nmap\n........\n...@....\n...@....\n...@....\n";

fn hall() -> tempfile::TempDir {
    let scratch = tempfile::tempdir().unwrap();
    fs::write(scratch.path().join("hall.map"), HALL).unwrap();
    scratch
}

#[test]
fn one_query_is_one_row_per_planner_in_the_cells_of_the_file() {
    let scratch = hall();
    let args =
        ["plan", "hall.map", "--from", "1,3", "--to", "5,3", "--global", "a_star,dijkstra", "--resolution-m", "0.5"];
    let (code, out, err) = run(scratch.path(), &args);
    assert_eq!(code, 0, "{err}");
    let rows: Vec<Vec<&str>> = out.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 3);
    assert_eq!(
        rows[0].join(","),
        "map,query,start_col,start_row,goal_col,goal_row,global,found,optimal,length,length_m,ratio,expanded,generated,turns,fallbacks,note"
    );
    // Up two rows on the diagonal's side, over the wall in row 0 without cutting its corners: (1,3) to (2,0) to (4,0) to (5,3).
    let expected = 2.0 + 2.0 * (2.0 + std::f64::consts::SQRT_2);
    for (row, planner) in rows[1..].iter().zip(["a_star", "dijkstra"]) {
        assert_eq!(row[..8].join(","), format!("hall.map,0,1,3,5,3,{planner},1"));
        let length: f64 = row[9].parse().unwrap();
        assert!((length - expected).abs() < 1e-12 && (row[10].parse::<f64>().unwrap() - 0.5 * length).abs() < 1e-12);
        assert_eq!((row[8], row[11], row[16]), ("", "", ""), "no optimum is known, nothing to note");
    }
    assert!(err.contains("a_star: 1 queries, 1 found; no optimum is known"), "{err}");
}

#[test]
fn a_table_of_queries_is_compared_with_its_optima() {
    let scratch = hall();
    let table = "start_col\tstart_row\tgoal_col\tgoal_row\tlength_cells\n1\t3\t5\t3\t8.82842712\n0\t0\t7\t0\t7.00000000\n0\t0\t2\t2\t2.90000000\n";
    fs::write(scratch.path().join("queries.tsv"), table).unwrap();
    let (code, out, err) = run(scratch.path(), &["plan", "hall.map", "--queries", "queries.tsv"]);
    assert_eq!((code, out.lines().count()), (0, 4), "{err}");
    // The third length is made up: the way is shorter than it says, and that is said.
    assert!(err.contains("3 queries, 3 found; 2 of 3 equal the optimum, 1 are shorter"), "{err}");
    let pruned = ["plan", "hall.map", "--queries", "queries.tsv", "--global", "dfs", "--path", "line_of_sight"];
    assert_eq!(run(scratch.path(), &pruned).0, 0);
}

#[test]
fn inflation_may_close_the_way_which_is_a_result() {
    let scratch = hall();
    let (code, out, _) = run(scratch.path(), &["plan", "hall.map", "--from", "1,2", "--to", "6,2", "--inflate", "0.6"]);
    let row: Vec<&str> = out.lines().nth(1).unwrap().split(',').collect();
    assert_eq!((code, row[7], row[9]), (0, "0", ""), "{out}");
}

#[test]
fn what_cannot_be_planned_is_refused() {
    let scratch = hall();
    fs::write(scratch.path().join("off.tsv"), "start_col,start_row,goal_col,goal_row\n\n1,1,9,0\n").unwrap();
    for (args, expected) in [
        (
            &["plan", "hall.map", "--from", "1,3", "--to", "3,3"][..],
            "the goal 3,3 is occupied (rows count from the top)",
        ),
        (
            &["plan", "hall.map", "--queries", "off.tsv"],
            "line 3: the goal 9,0 lies outside the map of 8 columns and 4 rows",
        ),
        (&["plan", "hall.map", "--from", "1,3", "--to", "5,3", "--global", "a_stra"], "did you mean `a_star`?"),
        (&["plan", "hall.map", "--from", "1,3"], "--to"),
        (&["plan", "hall.map"], "--scen"),
        (&["plan", "none.map", "--from", "1,3", "--to", "5,3"], "none.map"),
    ] {
        let (code, out, err) = run(scratch.path(), args);
        assert!(code == 2 && out.is_empty() && err.contains(expected), "{args:?}: {code} {err}");
    }
}

#[test]
fn maps_are_described_and_survive_a_change_of_format() {
    let scratch = hall();
    let (code, info, _) = run(scratch.path(), &["map", "info", "hall.map"]);
    assert!(code == 0 && info.contains('8') && info.contains("29"), "29 free cells of 32:\n{info}");
    for name in ["hall.yaml", "hall.png", "hall.txt", "again.map"] {
        assert_eq!(run(scratch.path(), &["map", "convert", "hall.map", name]).0, 0, "{name}");
    }
    for name in ["hall.yaml", "hall.png", "hall.txt"] {
        assert_eq!(run(scratch.path(), &["map", "convert", name, "back.map", "--force"]).0, 0, "{name}");
        assert_eq!(fs::read_to_string(scratch.path().join("back.map")).unwrap(), HALL, "{name}");
    }
    assert_eq!(run(scratch.path(), &["map", "convert", "hall.map", "hall.bmp"]).0, 2);
}

/// Plans every query of a file with two planners; each answer must be as long as the file says.
fn check_optima(folder: &Path, queries: &[(&str, &str, &str, usize)]) {
    for &(map, option, queries, count) in queries {
        let path = |name: &str| folder.join(name).to_string_lossy().into_owned();
        let args = ["plan", &path(map), option, &path(queries), "--global", "a_star,dijkstra"];
        let (code, out, err) = run(folder, &args);
        assert_eq!(code, 0, "{err}");
        for planner in ["a_star", "dijkstra"] {
            let expected = format!(
                "{planner}: {count} queries, {count} found; {count} of {count} equal the optimum, 0 are shorter"
            );
            assert!(err.contains(&expected), "{map}: {err}");
        }
        assert_eq!(out.lines().count(), 1 + 2 * count);
    }
}

#[test]
fn the_shipped_maps_have_their_published_optima() {
    check_optima(
        &root().join("tests/data/movingai"),
        &[
            ("random-32-32-20.map", "--scen", "random-32-32-20-random-1.scen", 409),
            ("maze-32-32-4.map", "--scen", "maze-32-32-4-random-1.scen", 395),
        ],
    );
}

#[test]
fn real_maps_have_their_known_optima() {
    let Some(folder) = benchmarks("ros_maps") else { return };
    check_optima(
        &folder,
        &[
            ("depot.yaml", "--queries", "depot.queries.tsv", 50),
            ("tb3_sandbox.yaml", "--queries", "tb3_sandbox.queries.tsv", 50),
        ],
    );
}

#[test]
fn a_game_map_has_its_published_optima() {
    let Some(folder) = benchmarks("movingai") else { return };
    check_optima(&folder, &[("arena.map", "--scen", "arena.map.scen", 160)]);
}
