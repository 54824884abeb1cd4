//! Drives that users of other tools reported or would: one scenario each in `tests/data/drives`, one test each here.

use super::support::{Answer, is_full, root, simrun};
use simrun::geometry::{Twist, Vec2};
use simrun::map::OccupancyGrid;
use simrun::math;
use simrun::results::{EPISODES_CSV, STATES_CSV, SUMMARY_CSV};
use simrun::rng::EpisodeSeed;
use simrun::robot::Robot;
use simrun::scenario::load;
use simrun::world::{Conditions, Scene, StaticMap, World};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

fn folder() -> PathBuf {
    root().join("tests/data/drives")
}

type Row = BTreeMap<String, String>;

/// A command on one of the scenarios.
fn answer(command: &str, case: &str, more: &[&str], code: i32) -> Answer {
    simrun(&folder()).args([command, &format!("{case}.yaml")]).args(more).ends_with(code)
}

/// The rows of episode 0, by column.
fn drive(case: &str, more: &[&str]) -> Vec<Row> {
    let table = answer("run", case, &[&["--episode", "0"], more].concat(), 0).stdout;
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    rows.deserialize().map(|row| row.expect("a row")).collect()
}

/// The rows of a whole run, by column, and the traces of each, by stack, if there is one episode.
fn run(case: &str, more: &[&str]) -> (Vec<Row>, BTreeMap<String, Vec<Row>>) {
    let scratch = tempfile::tempdir().expect("a folder");
    let out = scratch.path().join("out");
    answer("run", case, &[&["--quiet", "--trace", "--out", out.to_str().expect("a name")], more].concat(), 0);
    let read = |path: PathBuf| {
        csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .from_path(path)
            .expect("a table")
            .deserialize()
            .map(Result::unwrap)
            .collect()
    };
    let rows: Vec<Row> = read(out.join("episodes.csv"));
    let trace = |row: &Row| {
        let name = format!("traces/e{:0>6}_{}.csv", row["episode"], row["stack"]);
        (row["stack"].clone(), read(out.join(name)))
    };
    let traces = if rows[0].contains_key("termination.goal_tolerance_m") {
        BTreeMap::new()
    } else {
        rows.iter().map(trace).collect()
    };
    (rows, traces)
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} is `{}` in {row:?}", row[column]))
}

#[track_caller]
fn all_arrive(rows: &[Row]) {
    assert!(!rows.is_empty() && rows.iter().all(|row| row["outcome"] == "success"), "{rows:?}");
}

#[test]
fn a_long_way_between_ends_that_are_near_has_the_time_that_it_takes() {
    let rows = drive("serpentine", &[]);
    all_arrive(&rows);
    // 62 m at 1 m/s; the straight line is 4 m.
    assert!(rows.iter().all(|row| number(row, "time_s") > 60.0), "{rows:?}");
}

#[test]
fn a_robot_that_turns_as_fast_as_it_can_is_not_stuck() {
    all_arrive(&drive("slow_turn", &[]));
    let plain =
        drive("slow_turn", &["--set", "termination.stuck_while_turning=true", "--stack", "a_star+pure_pursuit"]);
    assert_eq!((plain[0]["outcome"].as_str(), number(&plain[0], "time_s")), ("stuck", 30.0));
}

#[test]
fn a_robot_that_waits_for_somebody_is_not_stuck() {
    // Somebody stands in the door for 45 s; then he walks to and fro in it.
    let rows = drive("waits_for_person", &["--set", "stacks.replan=never"]);
    assert!(rows[0]["outcome"] != "stuck" && number(&rows[0], "time_s") > 45.0, "{rows:?}");
    let never = ["--set", "script=[]", "--set", "stacks.replan=never"];
    let stays = drive("waits_for_person", &never);
    assert_eq!(stays[0]["outcome"], "timeout", "it waited to the end: {stays:?}");
    let counts = drive("waits_for_person", &[&never[..], &["--set", "termination.stuck_behind_movers=true"]].concat());
    assert_eq!(counts[0]["outcome"], "stuck");
    // There is a way round, and who stands is on the map.
    let round = drive("waits_for_person", &["--set", "script=[]"]);
    all_arrive(&round);
    assert!(number(&round[0], "replans") >= 1.0 && number(&round[0], "time_s") < 45.0, "{round:?}");
}

#[test]
fn a_cart_that_parks_in_the_aisle_is_gone_round() {
    let dwa = ["--stack", "a_star+dwa"];
    let rows = drive("parked_cart", &dwa);
    all_arrive(&rows);
    assert!(number(&rows[0], "replans") >= 1.0 && number(&rows[0], "length_m") > 50.0, "{rows:?}");
    let never = drive("parked_cart", &[&dwa[..], &["--set", "planning.standing_mps=0"]].concat());
    assert_ne!(never[0]["outcome"], "success", "{never:?}");
}

#[test]
fn nothing_stays_on_the_map_where_a_cart_has_left() {
    all_arrive(&drive("ghost", &[]));
    all_arrive(&drive("ghost", &["--set", "stacks.replan=never"]));
}

#[test]
fn a_contact_within_a_tick_ends_length_and_time() {
    // The board's face is at x = 50.9995 m, the robot starts at 49 m and has a radius of 0.25 m; 40 m/s.
    let rows = drive("tunnel", &[]);
    assert_eq!((rows[0]["outcome"].as_str(), rows[0]["collided_with"].as_str()), ("collision", "unknown_static"));
    assert!((number(&rows[0], "length_m") - 1.7495).abs() < 1e-6, "{rows:?}");
    let time_s = number(&rows[0], "time_s");
    assert!((10.0 * time_s).fract() > 0.01 && number(&rows[0], "ticks") == (10.0 * time_s).ceil(), "{rows:?}");
    assert!((number(&rows[0], "speed_mean_mps") * time_s - 1.7495).abs() < 1e-6, "{rows:?}");
}

#[test]
fn help_for_a_start_in_an_unknown_static_names_a_place_that_is_accepted() {
    let unknown = "obstacles.unknown_static=[{fixed: {pose: [1.25,1.25,0], shape: {rectangle: {size_m: [0.6,0.6]}}}}]";
    let said = answer("check", "start_in_unknown", &["--set", unknown], 2).stderr;
    let place = said.split("where the robot fits is at ").nth(1).and_then(|rest| rest.lines().next()).unwrap_or(&said);
    assert_ne!(place, "[1.25, 1.25]", "{said}");
    answer("check", "start_in_unknown", &["--set", unknown, "--set", &format!("start={place}")], 0);
}

#[test]
fn what_the_script_puts_upon_the_robot_hits_it_at_once_as_later() {
    for at_s in ["0", "0.1"] {
        let rows = drive("script_on_robot", &["--set", &format!("script.0.at_s={at_s}")]);
        let found = ["outcome", "collided_with", "at_rest", "time_s"].map(|column| rows[0][column].as_str());
        assert_eq!(found, ["collision", "unknown_static", "1", at_s]);
    }
}

#[test]
fn a_number_is_read_alike_in_the_file_and_by_set() {
    let text = std::fs::read_to_string(folder().join("scalars.yaml")).unwrap();
    let scratch = tempfile::tempdir().unwrap();
    for (spelling, value) in [("010", None), ("0x10", Some("16.0")), ("0o12", Some("10.0")), ("1e1", Some("10.0"))] {
        std::fs::write(scratch.path().join("s.yaml"), text.replace("range_m: 010", &format!("range_m: {spelling}")))
            .unwrap();
        std::fs::write(scratch.path().join("plain.yaml"), text.replace("range_m: 010", "range_m: 5")).unwrap();
        let check = |file: &str, more: &[&str]| {
            let answer = simrun(scratch.path()).args(["check", file, "--resolved"]).args(more).answer();
            let line = |text: &str, word: &str| text.lines().find(|line| line.contains(word)).map(str::to_owned);
            (
                answer.code,
                line(&answer.stderr, "error:"),
                line(&answer.stderr, "help:").map(|line| line.trim().to_owned()),
                line(&answer.stdout, "range_m"),
            )
        };
        let (in_file, by_set) =
            (check("s.yaml", &[]), check("plain.yaml", &["--set", &format!("sensing.range_m={spelling}")]));
        assert_eq!(in_file, by_set, "{spelling}");
        match value {
            Some(value) => assert_eq!(in_file.3, Some(format!("  range_m: {value}"))),
            None => assert!(in_file.0 == 2 && in_file.2.unwrap_or_default().contains("write `10`")),
        }
    }
}

#[test]
fn steps_of_a_sweep_are_the_numbers_that_people_write() {
    let said = answer("check", "sweep_rounding", &[], 0);
    let both = said.stdout + &said.stderr;
    assert!(!both.contains("0.30000000000000004"), "{both}");
}

#[test]
fn with_every_noise_on_the_bytes_are_the_same_for_any_number_of_threads() {
    answer("verify", "everything_random", &["--episodes", "4"], 0);
}

#[test]
fn a_planner_that_draws_draws_the_same_on_any_number_of_threads() {
    let scratch = tempfile::tempdir().unwrap();
    let file = folder().join("pf_aco.yaml");
    for threads in ["1", "4"] {
        let options = ["--quiet", "--threads", threads, "--out", threads];
        simrun(scratch.path()).arg("run").arg(&file).args(options).ends_with(0);
    }
    for table in [EPISODES_CSV, STATES_CSV, SUMMARY_CSV] {
        let [one, four] = ["1", "4"].map(|folder| std::fs::read(scratch.path().join(folder).join(table)).unwrap());
        assert!(one == four, "{table}");
    }
    let table = std::fs::read(scratch.path().join("1").join(EPISODES_CSV)).unwrap();
    let rows: Vec<Row> = csv::Reader::from_reader(&*table).deserialize().map(|row| row.unwrap()).collect();
    let distinct = |column: &str| rows.iter().map(|row| &row[column]).collect::<std::collections::BTreeSet<_>>().len();
    // One world, twelve episodes.
    assert_eq!((rows.len(), distinct("world_digest")), (12, 1));
    assert!(distinct("planned_length_m") > 3 && distinct("expanded") > 6);
}

#[test]
fn a_robot_that_has_to_stand_has_the_heading_of_the_goal_in_force() {
    let rows = drive("stand_at_goal", &[]);
    assert_eq!(rows.len(), 6);
    all_arrive(&rows);
    let scratch = tempfile::tempdir().unwrap();
    let file = folder().join("stand_at_goal.yaml");
    simrun(scratch.path()).arg("run").arg(&file).args(["--trace", "--quiet"]).ends_with(0);
    let traces = super::support::files(scratch.path(), "csv");
    let mut seen = 0;
    for trace in traces.iter().filter(|path| path.to_string_lossy().contains("traces")) {
        let table = std::fs::read_to_string(trace).unwrap();
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(table.as_bytes());
        let rows: Vec<Row> = reader.deserialize().map(|row| row.unwrap()).collect();
        let last = rows.last().unwrap();
        assert!(number(last, "v_mps").abs() <= 0.05 && number(last, "omega_radps").abs() <= 0.1, "{last:?}");
        assert!((number(last, "theta_rad") + 1.5).abs() <= 0.1, "{last:?}");
        assert!((Vec2::new(number(last, "x_m"), number(last, "y_m")) - Vec2::new(12.0, 7.0)).norm() <= 0.25);
        assert_eq!(last["mode"], "arrive");
        seen += 1;
    }
    assert_eq!(seen, 6, "{traces:?}");
    let said = answer("check", "stand_at_goal", &["--set", "termination.arrive=pass"], 2).stderr;
    assert!(said.contains("this heading would count for nothing"), "{said}");
}

#[test]
fn no_cart_of_the_warehouse_leaves_its_aisle() {
    let worlds = if is_full() { 1000 } else { 100 };
    for name in ["warehouse", "20_carts"] {
        let folder = root().join("scenarios");
        let scenario = load(folder.join(format!("{name}.yaml")), &[]).unwrap_or_else(|error| panic!("{error}"));
        let spec = scenario.scene_spec(&folder).unwrap();
        let robot = Robot::new(&scenario.robot, &scenario.limits);
        let mut turns = 0;
        for episode in 0..worlds {
            let seed = EpisodeSeed { seed: scenario.seed, episode };
            let grid: OccupancyGrid = scenario.map.load(&folder, seed).unwrap();
            let Ok(scene) = Scene::generate(&spec, &Arc::new(StaticMap::new(grid)), &robot, seed) else { continue };
            let mut world = World::new(&scene, &robot, &Conditions { seed, ..Conditions::default() });
            for tick in 0..600 {
                world.step(Twist::ZERO);
                for (mover, first) in world.movers().iter().zip(&scene.movers) {
                    let across = Vec2::new(-first.velocity.y, first.velocity.x).normalize();
                    let offset_m = (mover.position - first.position).dot(&across);
                    assert!(offset_m.abs() < 1e-9, "{name}, episode {episode}, tick {tick}: {offset_m} m off its line");
                    turns += u32::from(tick == 599 && mover.velocity.dot(&first.velocity) < 0.0);
                }
            }
        }
        assert!(turns > worlds as u32, "{turns} carts of {name} are on their way back");
    }
}

#[test]
fn planned_paths_keep_the_inflation_off_the_first_corner() {
    let rows = drive("first_leg", &[]);
    assert_eq!(rows.len(), 16);
    all_arrive(&rows);
    assert!(rows.iter().all(|row| number(row, "clearance_min_m") > 0.01), "{rows:?}");
}

#[test]
fn the_window_touches_no_known_wall_and_stands_before_none() {
    for (case, stack) in [("workshop_static", "a_star+dwa"), ("imp_maze", "a_star+imp_dwa")] {
        let (rows, _) = run(case, &["--stack", stack]);
        assert!(rows.len() >= 40);
        all_arrive(&rows);
    }
}

#[test]
fn a_post_on_the_line_is_gone_round() {
    let rows = drive("post_on_line", &[]);
    let outcome = |name: &str| rows.iter().find(|row| row["stack"] == name).expect("the stack")["outcome"].clone();
    assert_eq!(outcome("guided"), "success");
    // Alone a window holds no way round; it must not touch the post.
    assert!(outcome("alone_dwa") == "stuck" && outcome("alone_imp") == "stuck", "{rows:?}");
}

#[test]
fn a_cart_beside_a_wall_turns_without_touching_it() {
    for row in drive("cart_beside_wall", &[]) {
        let stack = &row["stack"];
        assert!(row["outcome"] == "success" || stack.ends_with("pure_pursuit"), "{stack}: {}", row["outcome"]);
    }
}

/// Time to drive `way` from rest to rest at `top` speed and `rate` of acceleration.
fn trapezoid_s(way: f64, top: f64, rate: f64) -> f64 {
    if way >= top * top / rate { way / top + top / rate } else { 2.0 * (way / rate).sqrt() }
}

#[test]
fn a_hall_is_crossed_in_little_more_than_the_time_of_the_trapezoid() {
    let wall = format!("map={{ascii: {{resolution_m: 0.1, rows: [{}]}}}}", {
        let row = format!("\"{}{}\"", ".".repeat(183), "#".repeat(17));
        vec![row; 100].join(", ")
    });
    let quarter = core::f64::consts::FRAC_PI_2;
    for (name, sets, turn_rad) in [
        ("ahead", vec![], 0.0),
        ("aside", vec!["start=[10, 2, 0]", "goal=[10, 18]"], quarter),
        ("behind", vec!["start=[18, 5, 0]", "goal=[2, 5]"], 2.0 * quarter),
        ("wall", vec![wall.as_str()], 0.0),
    ] {
        let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
        let (rows, _) = run("hall", &sets);
        assert_eq!(rows.len(), 75);
        for row in &rows {
            let (tolerance_m, rate) =
                (number(row, "termination.goal_tolerance_m"), number(row, "limits.acceleration_max_mps2"));
            let best_s = trapezoid_s(16.0 - tolerance_m, 1.0, rate);
            let limit_s =
                if turn_rad == 0.0 { 1.05 * best_s } else { 1.3 * (trapezoid_s(turn_rad, 1.0, 2.0) + best_s) };
            let time_s = number(row, "time_s");
            assert!(row["outcome"] == "success" && time_s <= limit_s, "{name}: {time_s} s of {limit_s} s in {row:?}");
        }
    }
}

#[test]
fn the_commanded_speed_does_not_flip_from_tick_to_tick() {
    let doorway = root().join("scenarios/08_doorway.yaml");
    for case in ["lane_2m", "goal_creep", doorway.with_extension("").to_str().expect("a name")] {
        let (rows, traces) = run(case, &["--episodes", "1"]);
        all_arrive(&rows);
        for (stack, trace) in &traces {
            let speeds: Vec<f64> = trace
                .iter()
                .filter(|row| !row["command_v_mps"].is_empty())
                .map(|row| number(row, "command_v_mps"))
                .collect();
            let changes: Vec<f64> = speeds.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let flips = changes
                .windows(2)
                .filter(|pair| pair[0] * pair[1] < 0.0 && math::min(pair[0].abs(), pair[1].abs()) >= 0.02 - 1e-9)
                .count();
            assert!(flips * 20 <= speeds.len(), "{case}, {stack}: {flips} of {} ticks", speeds.len());
        }
        if case == "lane_2m" {
            assert!(
                rows.iter().all(|row| number(row, "jerk_rms_mps3") < 1.0 && number(row, "time_s") <= 17.0),
                "{rows:?}"
            );
        }
    }
    for tolerance_m in ["0.25", "0.1", "0.05", "0.02", "0.01"] {
        let rows = drive("goal_creep", &["--set", &format!("termination.goal_tolerance_m={tolerance_m}")]);
        all_arrive(&rows);
        assert!(rows.iter().all(|row| number(row, "time_s") <= 19.0), "{tolerance_m}: {rows:?}");
    }
}
