//! The command as a user meets it: what it prints, what it writes, how it exits.

use super::support::{Simrun, files, root, simrun};
use std::fs;
use std::path::PathBuf;

fn scenario(name: &str) -> PathBuf {
    root().join(format!("scenarios/{name}.yaml"))
}

fn stderr(command: &mut Simrun) -> String {
    command.answer().stderr
}

fn stdout(command: &mut Simrun) -> String {
    command.answer().stdout
}

#[test]
fn a_scenario_alone_runs_and_prints_its_table() {
    let scratch = tempfile::tempdir().unwrap();
    let text = stdout(simrun(scratch.path()).arg(scenario("01_empty")));
    assert!(text.contains("a_star+dwa") && text.contains("results/01_empty/episodes.csv"), "{text}");
    for file in ["episodes.csv", "summary.csv", "timings.csv", "manifest.json"] {
        assert!(scratch.path().join("results/01_empty").join(file).exists(), "{file}");
    }
    let message = simrun(scratch.path()).arg(scenario("01_empty")).ends_with(0).stderr;
    assert!(message.contains("complete, nothing to run"), "{message}");
}

#[test]
fn a_bad_scenario_exits_with_2_and_writes_nothing() {
    let scratch = tempfile::tempdir().unwrap();
    let mut count = 0;
    for path in files(&root().join("tests/bad_scenarios"), "yaml") {
        let text = fs::read_to_string(&path).unwrap_or_default();
        // Fixtures that need options or other bytes are tested with the reader itself.
        if text.starts_with("# --set") || text.is_empty() {
            continue;
        }
        simrun(scratch.path()).arg(&path).ends_with(2);
        count += 1;
    }
    assert!(count >= 12, "{count} fixtures");
    assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 0, "nothing was written");
}

#[test]
fn a_key_that_does_not_exist_is_refused_with_the_nearest_one() {
    let scratch = tempfile::tempdir().unwrap();
    let mut command = simrun(scratch.path());
    command.arg(scenario("01_empty")).args(["--set", "limits.sped_max_mps=2"]);
    command.ends_with(2);
    let message = stderr(&mut command);
    assert!(message.contains("--set limits.sped_max_mps=2") && message.contains("speed_max_mps"), "{message}");
}

#[test]
fn an_unknown_stack_is_refused_with_the_nearest_one() {
    let scratch = tempfile::tempdir().unwrap();
    let mut command = simrun(scratch.path());
    command.arg(scenario("01_empty")).args(["--stack", "a_star+dwaa"]);
    command.ends_with(2);
    assert!(stderr(&mut command).contains("did you mean `a_star+dwa`"), "{}", stderr(&mut command));
}

#[test]
fn a_missed_requirement_exits_with_3() {
    let scratch = tempfile::tempdir().unwrap();
    simrun(scratch.path()).arg(scenario("06_u_trap")).args(["--require-success", "1"]).ends_with(3);
    // One success of one is no proof of ninety per cent: the interval begins at 2.5 % (Clopper-Pearson).
    let one = ["--require-success", "0.9", "--episodes", "1", "--quiet"];
    simrun(scratch.path()).arg(scenario("01_empty")).args(one).ends_with(0);
    let said = simrun(scratch.path()).arg(scenario("01_empty")).args(one).arg("--require-interval").ends_with(3).stderr;
    assert!(said.contains("succeeds in 100.0 %, surely in"), "{said}");
}

#[test]
fn another_run_in_the_same_folder_is_refused() {
    let scratch = tempfile::tempdir().unwrap();
    simrun(scratch.path()).arg(scenario("01_empty")).ends_with(0);
    let mut other = simrun(scratch.path());
    other.arg(scenario("01_empty")).args(["--set", "limits.speed_max_mps=0.5"]);
    other.ends_with(1);
    assert!(stderr(&mut other).contains("limits.speed_max_mps"), "{}", stderr(&mut other));
    other.arg("--force").ends_with(0);
}

#[test]
fn one_episode_prints_its_rows_and_writes_only_the_trace() {
    let scratch = tempfile::tempdir().unwrap();
    let mut command = simrun(scratch.path());
    command.arg(scenario("05_crossing")).args(["--episode", "3", "--stack", "dwa"]);
    let text = stdout(&mut command);
    assert_eq!(text.lines().count(), 2, "{text}");
    assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 0);
    command.arg("--trace").ends_with(0);
    let trace = fs::read_to_string(scratch.path().join("results/05_crossing/traces/e000003_dwa.csv")).unwrap();
    let header = trace.lines().find(|line| !line.starts_with('#')).unwrap();
    assert!(header.starts_with("tick,time_s,x_m,y_m,theta_rad,"), "{header}");
}

#[test]
fn verify_says_that_the_bytes_are_the_same() {
    let scratch = tempfile::tempdir().unwrap();
    let text = stdout(simrun(scratch.path()).arg("verify").arg(scenario("02_wall")));
    assert!(text.contains("identical"), "{text}");
    assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 0);
}

#[test]
fn a_resolved_scenario_is_a_scenario() {
    let scratch = tempfile::tempdir().unwrap();
    let resolved = stdout(simrun(scratch.path()).args(["check", "--resolved"]).arg(scenario("warehouse")));
    let path = scratch.path().join("resolved.yaml");
    fs::write(&path, &resolved).unwrap();
    let again = stdout(simrun(scratch.path()).args(["check", "--resolved"]).arg(&path));
    assert_eq!(resolved, again);
}

#[test]
fn planners_lists_every_planner_and_describes_one() {
    let scratch = tempfile::tempdir().unwrap();
    let list = stdout(simrun(scratch.path()).arg("planners"));
    let names = simrun::plan::global::GlobalChoice::NAMES.iter().chain(simrun::plan::local::LocalChoice::NAMES);
    for name in names {
        assert!(list.contains(name), "{name} is not in {list}");
    }
    let one = stdout(simrun(scratch.path()).args(["planners", "dwa"]));
    assert!(one.contains("horizon_s") && one.contains("Fox"), "{one}");
    simrun(scratch.path()).args(["planners", "dwaa"]).ends_with(2);
}

#[test]
fn planners_keeps_the_order_of_the_source_and_lists_allowed_values() {
    let scratch = tempfile::tempdir().unwrap();
    let text = stdout(simrun(scratch.path()).args(["planners", "imp_a_star"]));
    let source = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/src/plan/global/imp_a_star.rs")).unwrap();
    let params = source.split("pub struct Params {").nth(1).unwrap().split("\n}").next().unwrap();
    let fields: Vec<&str> =
        params.lines().filter_map(|line| line.trim().strip_prefix("pub ")?.split(':').next()).collect();
    assert!(fields.len() > 3, "{fields:?}");
    let places: Vec<usize> = fields.iter().map(|field| text.find(&format!("\n  {field}: ")).expect(field)).collect();
    assert!(places.is_sorted(), "{fields:?} {text}");
    assert!(text.contains("`dynamic`") && text.contains("`one`"), "{text}");
    let dwa = stdout(simrun(scratch.path()).args(["planners", "dwa"]));
    assert!(dwa.contains("  d_cap_m: 0.3\n") && dwa.contains("(s, number, above 0)"), "{dwa}");
}

#[test]
fn explain_describes_a_key_and_answers_a_wrong_one_with_the_nearest() {
    let scratch = tempfile::tempdir().unwrap();
    let text = stdout(simrun(scratch.path()).args(["explain", "planning.inflation_m"]));
    assert!(text.contains("unit     m\n") && text.contains("range    at least 0\n"), "{text}");
    assert!(stdout(simrun(scratch.path()).arg("explain")).contains("stacks"));
    let wrong = simrun(scratch.path()).args(["explain", "planning.inflation"]).ends_with(2).stderr;
    assert!(wrong.contains("did you mean `planning.inflation_m`?"), "{wrong}");
}

#[test]
fn misspelt_subcommands_and_options_are_answered_with_the_nearest() {
    let scratch = tempfile::tempdir().unwrap();
    for (words, expected) in [
        (&["anlyze", "results/a"][..], "did you mean `simrun analyze`?"),
        (&["anlyze", "--all-pairs", "results/a"], "a similar subcommand exists: 'analyze'"),
        (&["run", "a.yaml", "--epsiodes", "3"], "a similar argument exists: '--episodes'"),
        (&["a.yaml", "--epsiodes", "3"], "a similar argument exists: '--episodes'"),
        (&["map", "inof", "a.map"], "a similar subcommand exists: 'info'"),
        // The name of a file is no typing error.
        (&["analyse.yaml"], "there is no such scenario file"),
    ] {
        let message = simrun(scratch.path()).args(words).ends_with(2).stderr;
        assert!(message.contains(expected), "{words:?}: {message}");
    }
    // A file that is called like a misspelt subcommand is a scenario.
    fs::write(scratch.path().join("anlyze"), "map: [").unwrap();
    let message = simrun(scratch.path()).arg("anlyze").ends_with(2).stderr;
    assert!(!message.contains("subcommand"), "{message}");
}

#[test]
fn commands_that_print_write_a_file_with_out() {
    let scratch = tempfile::tempdir().unwrap();
    let map = scratch.path().join("a.txt");
    fs::write(&map, "..#\n...\n").unwrap();
    let (map, plan) = (map.display().to_string(), ["--from", "0,0", "--to", "2,1"]);
    let shipped = scenario("04_unknown_pallet").display().to_string();
    let commands: [&[&str]; 7] = [
        &["planners"],
        &["explain", "map"],
        &["schema"],
        &["map", "info", &map],
        &["plan", &map, plan[0], plan[1], plan[2], plan[3]],
        &["check", &shipped],
        &["check", &shipped, "--resolved"],
    ];
    for words in commands {
        let printed = stdout(simrun(scratch.path()).args(words));
        let quiet = stdout(simrun(scratch.path()).args(words).args(["-o", "written"]));
        let written = fs::read_to_string(scratch.path().join("written")).unwrap();
        assert_eq!((quiet.as_str(), &written), ("", &printed), "{words:?}");
    }
    simrun(scratch.path()).args(["map", "convert", &map, "--out", "b.map"]).ends_with(0);
    assert!(scratch.path().join("b.map").exists());
    simrun(scratch.path()).args(["map", "convert", &map]).ends_with(2);
}

#[test]
fn a_picture_becomes_a_map_with_a_preview() {
    let folder = tempfile::tempdir().expect("a folder");
    let (png, map) = (folder.path().join("yard.png"), folder.path().join("yard.map"));
    // Grey ground, a red block of 10 by 6 pixels from (4, 5) on, a blue speck.
    let picture = image::RgbImage::from_fn(32, 20, |x, y| {
        image::Rgb(match (x, y) {
            (4..14, 5..11) => [190, 40, 30],
            (25, 3) => [20, 30, 200],
            _ => [130, 130, 125],
        })
    });
    picture.save(&png).expect("a picture");
    let [png, map] = [&png, &map].map(|path| path.display().to_string());
    simrun(folder.path()).args(["map", "from-image", &png, &map]).ends_with(0);
    let rows: Vec<String> = fs::read_to_string(&map).expect("a map").lines().skip(4).map(str::to_owned).collect();
    assert_eq!(rows.iter().map(|row| row.matches('@').count()).sum::<usize>(), 60, "{rows:#?}");
    assert!((5..11).all(|row| &rows[row][4..14] == "@@@@@@@@@@"));
    let preview = image::open(folder.path().join("yard.preview.png")).expect("a preview").into_rgb8();
    assert_eq!(preview.dimensions(), (32, 20));
    assert_eq!((preview.get_pixel(4, 5).0, preview.get_pixel(3, 5).0), ([200, 0, 160], [193, 193, 190]));

    let sized =
        ["map", "from-image", &png, &map, "--cols", "16", "--rows", "10", "--opening-px", "0", "--hue-deg", "200,280"];
    simrun(folder.path()).args(sized).ends_with(2);
    simrun(folder.path()).args(sized).arg("--force").ends_with(0);
    for (bad, message) in [
        (vec!["--hue-deg", "10"], "expected two hues"),
        (vec!["--cols", "0", "--rows", "3"], "0 is not in 1..=16384"),
        (vec!["--cols", "3"], "--rows"),
    ] {
        let said = simrun(folder.path()).args(["map", "from-image", &png, &map]).args(bad).ends_with(2).stderr;
        assert!(said.contains(message), "{said}");
    }
    let said = simrun(folder.path()).args(["map", "from-image", &map, &map]).ends_with(2).stderr;
    assert!(said.contains("not a PNG that can be read"), "{said}");
}
