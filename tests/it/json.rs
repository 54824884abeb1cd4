//! `--format json` as a program meets it: one document on stdout, the columns of the tables as keys, errors with their place.

use super::support::{Answer, files, root, simrun};
use serde_json::{Value as Json, json};
use std::fs;
use std::path::Path;

/// The document of a call, which ends with that code.
#[track_caller]
fn document(folder: &Path, arguments: &[&str], code: i32) -> Json {
    let Answer { stdout, stderr, .. } = simrun(folder).args(arguments).args(["--format", "json"]).ends_with(code);
    let document: Json = serde_json::from_str(&stdout).unwrap_or_else(|error| panic!("{error}: {stdout}"));
    assert_eq!(document["exit_code"], code);
    assert_eq!(document["errors"].as_array().unwrap().is_empty(), code == 0, "{document}");
    assert_eq!(stderr.contains("error"), code != 0, "people are told as well: {stderr}");
    assert_eq!(document["simrun"], env!("CARGO_PKG_VERSION"));
    document
}

fn scenario(name: &str) -> String {
    root().join(format!("scenarios/{name}.yaml")).display().to_string()
}

/// The names and fields of a table of one line.
fn line_of(csv: &str) -> Vec<(String, String)> {
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let names = reader.headers().unwrap().clone();
    let line = reader.records().next().unwrap().unwrap();
    names.iter().map(str::to_owned).zip(line.iter().map(str::to_owned)).collect()
}

/// Whether an object has the columns of a line as keys, in order, with the same values.
#[track_caller]
fn assert_same(object: &Json, line: &[(String, String)]) {
    let object = object.as_object().unwrap();
    let names: Vec<&String> = line.iter().map(|(name, _)| name).collect();
    assert_eq!(object.keys().collect::<Vec<_>>(), names);
    for (name, text) in line {
        match &object[name] {
            Json::Null => assert_eq!(text, "", "{name}"),
            Json::Number(number) => {
                // serde_json's reader, unlike its writer, may miss the last bit.
                let (found, expected) = (number.as_f64().unwrap(), text.parse::<f64>().unwrap());
                assert!((found - expected).abs() <= 1e-15 * expected.abs(), "{name}: {found} for {expected}");
            }
            Json::Bool(flag) => assert_eq!(&flag.to_string(), text, "{name}"),
            other => assert_eq!(other.as_str(), Some(text.as_str()), "{name}"),
        }
    }
}

#[test]
fn run_prints_the_summary_or_the_rows_of_an_episode() {
    let scratch = tempfile::tempdir().unwrap();
    let whole = document(scratch.path(), &["run", &scenario("01_empty"), "--episodes", "1"], 0);
    assert_eq!((&whole["command"], &whole["runs"][0]["folder"]), (&json!("run"), &json!("results/01_empty")));
    let summary = fs::read_to_string(scratch.path().join("results/01_empty/summary.csv")).unwrap();
    assert_same(&whole["runs"][0]["summary"][0], &line_of(&summary));

    let one = document(scratch.path(), &[&scenario("01_empty"), "--episode", "0"], 0);
    let csv = simrun(scratch.path()).arg(scenario("01_empty")).args(["--episode", "0"]).ends_with(0).stdout;
    assert_same(&one["runs"][0]["rows"][0], &line_of(&csv));
    assert_eq!(one["runs"][0]["rows"][0]["success"], 1);
}

#[test]
fn what_was_found_is_printed_beside_the_requirement_that_was_missed() {
    let scratch = tempfile::tempdir().unwrap();
    let arguments = [&scenario("06_u_trap"), "--require-success", "1", "--episodes", "1"];
    let missed = document(scratch.path(), &arguments.map(|argument| argument as &str), 3);
    assert!(missed["errors"][0]["message"].as_str().unwrap().contains("100.0 % is required"), "{missed}");
    assert!(!missed["runs"][0]["summary"].as_array().unwrap().is_empty());
}

#[test]
fn errors_of_scenarios_have_the_place_that_people_are_shown() {
    let mut placed = 0;
    for path in files(&root().join("tests/bad_scenarios"), "yaml") {
        let text = fs::read_to_string(&path).unwrap_or_default();
        // Fixtures that need options or other bytes are tested with the reader itself.
        if text.starts_with("# --set") || text.is_empty() {
            continue;
        }
        let path = path.display().to_string();
        let Answer { stdout, stderr, .. } = simrun(root()).args(["check", &path, "--format", "json"]).ends_with(2);
        let document: Json = serde_json::from_str(&stdout).unwrap();
        let error = &document["errors"][0];
        assert!(stderr.contains(error["message"].as_str().unwrap()), "{error}");
        // The first place in the message for people, `--> FILE:LINE:COLUMN`.
        let shown = stderr.lines().find_map(|line| line.trim_start().strip_prefix("--> ")).unwrap_or_default();
        let mut parts = shown.rsplitn(3, ':');
        let (column, line) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
        if let (Ok(line), Ok(column)) = (line.parse::<u64>(), column.parse::<u64>()) {
            assert_eq!((&error["line"], &error["column"]), (&json!(line), &json!(column)), "{path}: {stderr}");
            placed += 1;
        }
    }
    assert!(placed >= 12, "{placed}");
}

#[test]
fn an_error_tells_the_key_what_was_found_and_what_was_expected() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("bad.yaml");
    let text =
        "map: {empty: {cols: 20, rows: 10}}\nrobot:\n  radius_m: wide\nstacks: {global: [a_star], local: [dwa]}\n";
    fs::write(&file, text).unwrap();
    let error = document(scratch.path(), &["check", "bad.yaml"], 2)["errors"][0].clone();
    let told = ["file", "line", "column", "key", "found"].map(|key| error[key].clone());
    assert_eq!(told, [json!("bad.yaml"), json!(3), json!(13), json!("robot.radius_m"), json!("wide")], "{error}");
    assert!(error["expected"].as_str().unwrap().contains("number"), "{error}");

    let unknown = document(scratch.path(), &[&scenario("01_empty"), "--set", "limits.sped_max_mps=2"], 2);
    let error = &unknown["errors"][0];
    assert_eq!((&error["file"], &error["argument"]), (&Json::Null, &json!("--set limits.sped_max_mps=2")), "{error}");
    assert!(error["help"].to_string().contains("speed_max_mps"), "{error}");
}

#[test]
fn a_command_line_that_cannot_be_read_is_refused_in_json_too() {
    let scratch = tempfile::tempdir().unwrap();
    for arguments in [&["run", "x.yaml", "--episods", "3"][..], &["chek"], &["planners", "dwaa"]] {
        let refused = document(scratch.path(), arguments, 2);
        assert!(!refused["errors"][0]["message"].as_str().unwrap().is_empty(), "{refused}");
    }
}

#[test]
fn every_fault_of_every_file_is_an_error() {
    let scratch = tempfile::tempdir().unwrap();
    let text = "map: {empty: {cols: 20, rows: 10}}\nrobot: {radius_m: wide}\nepisode: 3\nstacks: {global: [a_star], local: [dwa]}\n";
    fs::write(scratch.path().join("two.yaml"), text).unwrap();
    fs::write(scratch.path().join("good.yaml"), text.replace("robot: {radius_m: wide}\nepisode: 3\n", "")).unwrap();
    let found = document(scratch.path(), &["check", "two.yaml", "good.yaml", "missing.yaml"], 2);
    let errors = found["errors"].as_array().unwrap();
    let places: Vec<(&Json, &Json)> = errors.iter().map(|error| (&error["file"], &error["line"])).collect();
    let (two, missing) = (json!("two.yaml"), json!("missing.yaml"));
    assert_eq!(places, [(&two, &json!(2)), (&two, &json!(3)), (&missing, &Json::Null)], "{found}");
    assert_eq!(found["scenarios"][0]["file"], "good.yaml");
}

#[test]
fn failures_have_the_columns_of_their_table() {
    let scratch = tempfile::tempdir().unwrap();
    simrun(scratch.path()).arg(scenario("06_u_trap")).args(["--episodes", "1", "--quiet", "--out", "out"]).ends_with(0);
    let found = document(scratch.path(), &["failures", "out"], 0);
    let csv = simrun(scratch.path()).args(["failures", "out", "--format", "csv"]).ends_with(0).stdout;
    assert_same(&found["failures"][0], &line_of(&csv));
    assert_eq!(found["failed"].as_u64().unwrap() as usize, found["failures"].as_array().unwrap().len());
}

#[test]
fn check_names_points_stacks_and_notes_and_resolves() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("swept.yaml");
    let text = "map: {empty: {cols: 20, rows: 10}}\nstacks: {global: [a_star], local: [dwa]}\nepisodes: 3\nstart: [2, 2, 0]\ngoal: [15, 8]\n\
                sweep: {robot.radius_m: [0.2, 0.3]}\n";
    fs::write(&file, text).unwrap();
    let checked = document(scratch.path(), &["check", "swept.yaml", "--resolved"], 0);
    let found = &checked["scenarios"][0];
    assert_eq!((&found["scenario"], &found["episodes"]), (&json!("swept"), &json!(3)));
    assert_eq!(
        found["points"][1],
        json!({ "point": 1, "values": { "robot.radius_m": 0.3 }, "stacks": ["a_star+dwa"] })
    );
    assert!(found["notes"][0].as_str().unwrap().contains("nothing in this scenario is random"), "{found}");
    assert!(found["resolved"]["limits"]["speed_max_mps"].is_number(), "{found}");
}

#[test]
fn planners_are_described_with_their_parameters() {
    let scratch = tempfile::tempdir().unwrap();
    let all = document(scratch.path(), &["planners"], 0);
    let all = all["planners"].as_array().unwrap();
    for (role, name) in [("global", "a_star"), ("path", "line_of_sight"), ("local", "dwa")] {
        let planner = all.iter().find(|planner| planner["name"] == name).unwrap();
        assert_eq!((&planner["role"], &planner["key"]), (&json!(role), &json!(format!("stacks.{role}.{name}"))));
    }
    let one = document(scratch.path(), &["planners", "dwa"], 0);
    assert_eq!(one["planners"].as_array().unwrap().len(), 1);
    let parameters = one["planners"][0]["parameters"].as_array().unwrap();
    let named = |name: &str| parameters.iter().find(|parameter| parameter["name"] == name).unwrap();
    assert_eq!((&named("horizon_s")["unit"], &named("horizon_s")["required"]), (&json!("s"), &json!(false)));
    let prediction = named("prediction");
    assert_eq!(prediction["default"], "arc");
    let allowed: Vec<&Json> = prediction["allowed"].as_array().unwrap().iter().map(|value| &value["name"]).collect();
    assert_eq!(allowed, ["euler", "arc"], "{prediction}");
    assert!(parameters.iter().all(|parameter| !parameter["meaning"].as_str().unwrap().is_empty()));
}

#[test]
fn plan_answers_with_the_columns_of_its_table() {
    let scratch = tempfile::tempdir().unwrap();
    fs::write(scratch.path().join("hall.txt"), ".....\n..#..\n.....\n").unwrap();
    let arguments = ["plan", "hall.txt", "--from", "0,1", "--to", "4,1", "--global", "a_star"];
    let planned = document(scratch.path(), &arguments, 0);
    let csv = simrun(scratch.path()).args(arguments).ends_with(0).stdout;
    assert_same(&planned["rows"][0], &line_of(&csv));
    let sums = &planned["planners"][0];
    assert_eq!((&sums["global"], &sums["found"], &sums["ratio_mean"]), (&json!("a_star"), &json!(1), &Json::Null));
}

#[test]
fn analyze_holds_stacks_tests_rankings_and_the_verdict_on_a_baseline() {
    let scratch = tempfile::tempdir().unwrap();
    let text = "map: {empty: {cols: 20, rows: 10}}\nstacks: {global: [a_star], local: [dwa, pure_pursuit]}\nepisodes: 4\n\
                sweep: {limits.speed_max_mps: [0.5, 1]}\n";
    fs::write(scratch.path().join("two.yaml"), text).unwrap();
    simrun(scratch.path()).args(["two.yaml", "--quiet", "--out", "out"]).ends_with(0);
    let found = document(scratch.path(), &["analyze", "out"], 0);
    let sections = found["sections"].as_array().unwrap();
    assert_eq!(sections.len(), 2);
    assert_eq!(
        (&sections[0]["stacks"][0]["success_rate"], &sections[0]["stacks"][0]["group"]),
        (&json!(1.0), &json!("a"))
    );
    // The tests are those of the CSV, the section around them.
    let csv = simrun(scratch.path()).args(["analyze", "out", "--format", "csv"]).ends_with(0).stdout;
    assert_same(&sections[0]["tests"][0], &line_of(&csv)[1..]);

    let ranked = document(scratch.path(), &["analyze", "out", "--compare-points"], 0);
    let csv =
        simrun(scratch.path()).args(["analyze", "out", "--compare-points", "--format", "csv"]).ends_with(0).stdout;
    assert_same(&ranked["rankings"][0]["points"][0], &line_of(&csv));

    let same = document(scratch.path(), &["analyze", "out", "--baseline", "out"], 0);
    assert_eq!((&same["rows"], &same["moved"], &same["regressions"]), (&json!(16), &json!([]), &json!([])));
    let fewer = scratch.path().join("fewer.csv");
    let all = fs::read_to_string(scratch.path().join("out/episodes.csv")).unwrap();
    let kept: String = all.lines().take(16).map(|line| format!("{line}\n")).collect();
    fs::write(&fewer, kept).unwrap();
    let worse = document(scratch.path(), &["analyze", "fewer.csv", "--baseline", "out"], 3);
    assert_eq!((&worse["missing"], &worse["regressions"]), (&json!(1), &json!(["1 row of the baseline missing"])));
}
