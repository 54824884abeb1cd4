//! `simrun report`: the page on folders of results.

use super::support::{root, simrun};
use base64::Engine as _;
use simrun::episode::Outcome;
use simrun::experiment::Experiment;
use simrun::metrics::Metrics;
use simrun::report::{self, Settings};
use simrun::results::{Digest, Row, header_line, write_row};
use simrun::scenario::ScenarioFile;
use simrun::world::ObstacleKind;
use std::fs;
use std::path::Path;

const CROSSING: &str = "name: crossing
description: \"</style><script>alert('d')</script> & more\"
seed: 5
episodes: 3
map: {empty: {cols: 12, rows: 8}}
obstacles: {moving: [{random: {count: 3}}]}
stacks: {global: [a_star], local: [dwa, pure_pursuit]}
";

/// A run of a scenario in FOLDER/run.
fn run(folder: &Path, scenario: &str) {
    fs::write(folder.join("crossing.yaml"), scenario).unwrap();
    simrun(folder).args(["run", "crossing.yaml", "--out", "run", "--quiet"]).ends_with(0);
}

fn page(folder: &Path, arguments: &[&str]) -> String {
    simrun(folder).arg("report").args(arguments).args(["-o", "-"]).ends_with(0).stdout
}

/// The JSON in the element of a page that has this id.
fn json(page: &str, id: &str) -> serde_json::Value {
    let (_, rest) = page.split_once(&format!("id=\"{id}\">")).expect("the page has the element");
    let (text, _) = rest.split_once("</script>").unwrap();
    serde_json::from_str(text).expect("JSON")
}

/// What is packed in a text: base64 of raw deflate of JSON.
fn unpacked(packed: &serde_json::Value) -> serde_json::Value {
    let bytes = base64::engine::general_purpose::STANDARD.decode(packed.as_str().unwrap()).unwrap();
    serde_json::from_slice(&miniz_oxide::inflate::decompress_to_vec(&bytes).unwrap()).unwrap()
}

fn sums(deltas: &serde_json::Value) -> Vec<f64> {
    let whole = deltas.as_array().unwrap().iter().map(|value| value.as_i64().unwrap());
    whole
        .scan(0, |sum, delta| {
            *sum += delta;
            Some(*sum as f64 / 1000.0)
        })
        .collect()
}

#[test]
fn the_page_is_the_same_twice_names_no_place_and_asks_nobody() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), CROSSING);
    let first = page(folder.path(), &["run", "--threads", "1"]);
    assert_eq!(first, page(folder.path(), &["run", "--threads", "3"]));
    assert!(!first.contains(folder.path().to_str().unwrap()), "an absolute path");
    let outside = first.replace("http://www.w3.org/2000/svg", "");
    for link in ["http:", "https:", "src=", "@import", "url("] {
        assert!(!outside.contains(link), "{link}");
    }
    // What comes from files is text.
    assert!(!first.contains("<script>alert") && first.contains("&lt;script&gt;alert(&#39;d&#39;)"));
    // Every table and chart is there, and a way back to each episode.
    for part in
        ["id=\"stacks\"", "id=\"plots\"", "id=\"outcomes\"", "id=\"replay\"", "simrun run crossing.yaml --episodes 3"]
    {
        assert!(first.contains(part), "{part}");
    }
    assert!(first.contains("simrun draw crossing.yaml --episode 0 --stack a_star+dwa"));
}

#[test]
fn a_packed_episode_is_the_drive_to_half_a_millimetre() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), CROSSING);
    let page = page(folder.path(), &["run"]);
    let (episodes, maps) = (json(&page, "episodes"), json(&page, "maps"));
    let episodes = episodes.as_array().unwrap();
    assert_eq!(episodes.len(), 6, "three worlds, two stacks");
    let file = ScenarioFile::open(folder.path().join("crossing.yaml")).unwrap();
    let experiment = Experiment::load(&file, &[]).unwrap();
    for entry in episodes {
        let stack = experiment.stacks(0).position(|stack| stack.name == entry["stack"].as_str().unwrap()).unwrap();
        let drive = experiment.drive_one(0, entry["episode"].as_u64().unwrap(), stack).unwrap();
        let (recording, packed) = (&drive.recording, unpacked(&entry["data"]));
        let [x, y, heading] = ["x", "y", "heading"].map(|column| sums(&packed["robot"][column]));
        assert_eq!(x.len(), recording.trace.ticks.len());
        for (row, tick) in recording.trace.ticks.iter().enumerate() {
            let position = tick.pose.position;
            assert!((x[row] - position.x).abs() <= 5.001e-4 && (y[row] - position.y).abs() <= 5.001e-4, "row {row}");
            assert!(
                ((heading[row] - tick.pose.theta).rem_euclid(std::f64::consts::TAU) + 1e-3) % std::f64::consts::TAU
                    < 2e-3
            );
        }
        for (number, mover) in packed["movers"].as_array().unwrap().iter().enumerate() {
            let last = recording.trace.movers_at(x.len() - 1)[number].position;
            assert!((sums(&mover["x"])[x.len() - 1] - last.x).abs() <= 5.001e-4);
        }
        assert_eq!(packed["end"]["outcome"], entry["outcome"]);
        assert_eq!(entry["world"], format!("p0-e{}", entry["episode"]));
        assert_eq!(entry["id"], format!("p0-e{}-{}", entry["episode"], entry["stack"].as_str().unwrap()));
        assert_eq!(entry["stats"]["time_s"].as_f64(), drive.row.metrics.time_s);
        let map = unpacked(&maps[packed["map_id"].as_str().unwrap()]);
        assert_eq!((map["cols"].as_i64(), map["cells"].to_string()), (Some(12), "[0,96]".to_owned()));
    }
    let ids: std::collections::BTreeSet<String> = episodes.iter().map(|entry| entry["id"].to_string()).collect();
    assert_eq!(ids.len(), episodes.len());
    // Each can be reached without a script.
    assert!(ids.iter().all(|id| page.contains(&format!("<a class=\"episode\" href=\"#{}\">", id.trim_matches('"')))));
}

#[test]
fn an_obstacle_of_the_script_is_there_when_the_script_says() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = root().join("scenarios/13_blocked_aisle.yaml");
    simrun(folder.path()).args(["run", "--episodes", "1", "--out", "run", "--quiet"]).arg(scenario).ends_with(0);
    let episodes = json(&page(folder.path(), &["run"]), "episodes");
    let packed = unpacked(&episodes[0]["data"]);
    // It appears at 4 s and goes at 30 s, the goal moves at 12 s, and a tick is 0.1 s.
    let obstacle = &packed["unknown"][0];
    assert_eq!((obstacle["from_row"].as_u64(), obstacle["to_row"].as_u64()), (Some(40), Some(300)), "{obstacle}");
    assert!(obstacle["polygon"].is_array(), "{obstacle}");
    assert_eq!(packed["goals"][1]["row"], 120);
}

#[test]
fn what_is_not_the_same_run_is_shown_without_replays_and_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("hall.map"), "type octile\nheight 4\nwidth 8\nmap\n........\n........\n........\n........\n")
        .unwrap();
    let scenario = CROSSING.replace("{empty: {cols: 12, rows: 8}}", "{movingai: {file: hall.map}}");
    run(path, &scenario);
    let shown = page(path, &["run"]);
    assert!(shown.contains("id=\"episodes\"") && !shown.contains("No replays"));

    let manifest = fs::read_to_string(path.join("run/manifest.json")).unwrap();
    let (before, rest) = manifest.split_once("\"build\": \"").unwrap();
    fs::write(path.join("run/manifest.json"), format!("{before}\"build\": \"{}{}", "0".repeat(16), &rest[16..]))
        .unwrap();
    let other_build = page(path, &["run"]);
    assert!(other_build.contains("No replays: another build of simrun wrote these results"), "another build");
    assert!(other_build.contains("id=\"stacks\"") && !other_build.contains("id=\"episodes\""));

    fs::write(path.join("run/manifest.json"), &manifest).unwrap();
    let map = fs::read_to_string(path.join("hall.map")).unwrap();
    fs::write(path.join("hall.map"), map.replacen("........", ".......@", 1)).unwrap();
    assert!(page(path, &["run"]).contains("the file `hall.map` is not the one that was driven with"), "another map");
    fs::write(path.join("hall.map"), map).unwrap();

    let table = fs::read_to_string(path.join("run/episodes.csv")).unwrap();
    let (first, rest) = table.split_once('\n').unwrap();
    let mut row: Vec<&str> = rest.lines().next().unwrap().split(',').collect();
    let at = row.len() - 1;
    assert_eq!(row[at].len(), 16, "the trace digest is last");
    row[at] = "0000000000000000";
    let others: Vec<&str> = rest.lines().skip(1).collect();
    fs::write(path.join("run/episodes.csv"), format!("{first}\n{}\n{}\n", row.join(","), others.join("\n"))).unwrap();
    let other_drive = page(path, &["run"]);
    assert!(other_drive.contains("1 episode of the gallery went another way"), "another trace");
    assert_eq!(json(&other_drive, "episodes").as_array().unwrap().len(), 5);

    fs::remove_file(path.join("run/manifest.json")).unwrap();
    assert!(page(path, &["run"]).contains("No replays: there is no readable manifest.json"), "no manifest");
}

fn row(stack: &str, episode: u64, outcome: Outcome, time_s: Option<f64>) -> Row {
    Row {
        scenario: "made_up".to_owned(),
        point: 0,
        stack: stack.to_owned(),
        global: "a_star".to_owned(),
        path: String::new(),
        local: "dwa".to_owned(),
        episode,
        seed: 1,
        outcome,
        metrics: Metrics { time_s, length_m: time_s, ..Metrics::default() },
        world_digest: Some(Digest(episode)),
        trace_digest: Some(Digest(episode + 1000)),
        swept: Vec::new(),
    }
}

/// A page on rows that nobody drove.
fn made_up(rows: &[Row]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let mut table = csv::WriterBuilder::new().has_headers(false).from_writer(header_line(&[]));
    rows.iter().for_each(|row| write_row(&mut table, row).unwrap());
    fs::write(folder.path().join("episodes.csv"), table.into_inner().unwrap()).unwrap();
    report::report(&[folder.path().to_owned()], &Settings::default()).unwrap()
}

#[test]
fn every_outcome_has_its_place() {
    let message = || "<b>said so</b>".to_owned();
    let endings = [
        Outcome::Success,
        Outcome::Collision { with: ObstacleKind::Dynamic, at_rest: true },
        Outcome::Collision { with: ObstacleKind::UnknownStatic, at_rest: false },
        Outcome::Timeout,
        Outcome::Stuck,
        Outcome::NoPath { message: message() },
        Outcome::PlannerError { message: message() },
        Outcome::InternalError { message: message() },
        Outcome::GaveUp { message: message() },
        Outcome::InfeasibleWorld { message: message() },
    ];
    let rows: Vec<Row> =
        (0..).zip(endings).map(|(episode, outcome)| row("a<i>", episode, outcome, Some(3.0))).collect();
    let page = made_up(&rows);
    for words in [
        "Collision with dynamic, standing still",
        "Collision with unknown static",
        "Timeout",
        "Stuck",
        "No path",
        "Planner error",
        "Internal error",
        "Gave up",
        "Infeasible world",
    ] {
        assert!(page.contains(&format!("<th scope=\"row\">{words}</th>")), "{words}");
    }
    // One success of seven feasible worlds.
    assert!(page.contains("<b>14.3</b>") && page.contains("a&lt;i&gt;") && !page.contains("a<i>"));
}

#[test]
fn pages_of_little_are_whole() {
    let nothing = [row("a", 0, Outcome::Timeout, None), row("b", 0, Outcome::Stuck, None)];
    let page = made_up(&nothing);
    assert!(page.contains("<b>0.0</b>") && page.contains("No pair is told apart"), "zero successes, no metrics");
    let one = made_up(&[row("a", 0, Outcome::Success, Some(2.5))]);
    assert!(one.contains("Every episode succeeded") && !one.contains("id=\"pairs\""), "one stack, one episode");
    let infeasible = made_up(&[row("a", 0, Outcome::InfeasibleWorld { message: String::new() }, None)]);
    assert!(infeasible.contains("no feasible world"));
    let folder = tempfile::tempdir().unwrap();
    let refused = simrun(folder.path()).args(["report", "."]).ends_with(2);
    assert!(refused.stderr.contains("holds no results"), "{}", refused.stderr);
    fs::write(folder.path().join("episodes.csv"), header_line(&[])).unwrap();
    let refused = simrun(folder.path()).args(["report", "."]).ends_with(2);
    assert!(refused.stderr.contains("has no rows yet") && !folder.path().join("report.html").exists());
}

#[test]
fn runs_in_the_same_worlds_stand_side_by_side() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), CROSSING);
    let slower = ["run", "crossing.yaml", "--out", "slow", "--quiet", "--set", "limits.speed_max_mps=0.5"];
    simrun(folder.path()).args(slower).ends_with(0);
    let page = page(folder.path(), &["run", "slow"]);
    assert!(
        page.contains("Runs side by side") && page.contains("slow: a_star+dwa") && page.contains("run: a_star+dwa")
    );
    assert!(page.contains("simrun draw crossing.yaml --set limits.speed_max_mps=0.5 --episode 0 --stack a_star+dwa"));
    // One world, whichever run drove it: the player can put them beside each other.
    let episodes = json(&page, "episodes");
    let world = |id: &str| {
        episodes.as_array().unwrap().iter().find(|entry| entry["id"] == id).map(|entry| entry["world"].clone())
    };
    let (first, second) = (world("r0-p0-e0-a_star+dwa"), world("r1-p0-e0-a_star+dwa"));
    assert!(first.is_some() && first == second, "{first:?} {second:?}");
}

#[test]
fn a_sweep_shows_its_keys_its_map_and_its_best_setting() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = "sweep: {limits.speed_max_mps: [0.5, 1.0], robot.radius_m: [0.2, 0.3]}\n";
    run(folder.path(), &(CROSSING.to_owned() + sweep));
    let page = page(folder.path(), &["run", "--episodes-shown", "5"]);
    for part in [
        "success over speed_max_mps",
        "time over radius_m",
        "success over two keys",
        "The best setting by success",
        "--set robot.radius_m=",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(page.contains(" --point ") && json(&page, "episodes").as_array().unwrap().len() <= 5);
}

#[test]
fn a_folder_of_reproduce_shows_published_beside_measured() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), CROSSING);
    let path = folder.path().join("run");
    let paper = folder.path().join("paper");
    fs::create_dir_all(paper.join("T1")).unwrap();
    for file in ["episodes.csv", "manifest.json"] {
        fs::copy(path.join(file), paper.join("T1").join(file)).unwrap();
    }
    fs::write(paper.join("report.md"), "# A paper & its <title>\n\nSomebody, 2025\n").unwrap();
    fs::write(
        paper.join("verdicts.csv"),
        "id,asked_by,claim,verdict,ours,because,p,p_holm,kindest,depends_on\nC1,paper,It is <faster>,holds,holds,it was,0.01,0.02,holds,\n\
         Q1,simrun,Is it?,undecided,undecided,who knows,,,,\n",
    )
    .unwrap();
    fs::write(
        paper.join("numbers.csv"),
        "where,table,stack,against,metric,quantity,unit,published,measured,low,high,n\nTable 1,T1,a_star+dwa,,time_s,mean,s,20.5,21.25,20.1,22.3,3\n",
    )
    .unwrap();
    let page = page(folder.path(), &["paper"]);
    for part in [
        "A paper &amp; its &lt;title&gt;",
        "It is &lt;faster&gt;",
        "0.0200",
        "Questions of ours",
        "T1: time",
        ">20.5<",
        "21.25",
        "id=\"episodes\"",
    ] {
        assert!(page.contains(part), "{part}");
    }
}
