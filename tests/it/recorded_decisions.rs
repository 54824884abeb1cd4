//! The decisions of `pdwa`, tick by tick, against a second implementation, `tests/oracles/qin2026_pdwa.py`.
//!
//! `pdwa_drives.jsonl` holds what the planner knew and decided at every tick of drives through the paper's scenarios, positions and twists rounded
//! to six decimals; `pdwa_second.csv` what the second implementation makes of it. Written anew with
//!
//!     SIMRUN_BLESS=1 cargo test --release --test it pdwa_decisions::the_planner
//!     python3 tests/oracles/qin2026_pdwa.py

use super::support::{is_blessing, root};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use simrun::digest::{Digest, Fnv1a};
use simrun::episode::{Runner, Setting};
use simrun::experiment::Experiment;
use simrun::geometry::{KeyNode, Path, Pose, Twist, Vec2};
use simrun::map::{Cell, OccupancyGrid};
use simrun::observation::{Belief, SensedObstacle};
use simrun::plan::contract::{Decision, Entry, Failure, Guidance, LocalPlanner, Situation};
use simrun::plan::local::LocalChoice;
use simrun::plan::stack::{Stack, StackSpec};
use simrun::rng::EpisodeSeed;
use simrun::robot::Robot;
use simrun::scenario::{Edit, ScenarioFile};
use simrun::world::Conditions;
use std::fs;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// Drives from which decisions are taken: scenario, stack, changes, episodes, ticks.
type From = (&'static str, &'static str, &'static [&'static str], core::ops::Range<u64>, usize);

const DRIVES: [From; 4] = [
    ("qin2026_table3", "ssa_star+pdwa", &["seed=8500000"], 0..4, 600),
    ("qin2026_table3", "ssa_star+pdwa", &["seed=8600000", "stacks.0.local.pdwa.split=length"], 0..3, 600),
    (
        "qin2026_table3",
        "ssa_star+pdwa",
        &["seed=8700000", "stacks.0.local.pdwa.avoid.predict_dynamic=false"],
        0..2,
        600,
    ),
    ("qin2026_deadlock", "printed", &["seed=8800000"], 0..1, 3000),
];

/// A tick: what the planner knew, and its answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Tick {
    tick: u32,
    pose: [f64; 3],
    twist: [f64; 2],
    progress_m: f64,
    /// The cells that the known map lacks, where they have changed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    added: Option<Vec<[i32; 2]>>,
    /// x, y, vx, vy, radius.
    movers: Vec<[f64; 5]>,
    state: String,
    region: u32,
    conflict: bool,
    failures: u32,
    command: [f64; 2],
}

/// A drive: its head, as the second implementation reads it, and its ticks.
struct Drive {
    head: Value,
    ticks: Vec<Tick>,
}

fn data(name: &str) -> PathBuf {
    root().join("tests/data").join(name)
}

fn experiment(scenario: &str, changes: &[&str]) -> Experiment {
    let file = ScenarioFile::open(root().join(format!("scenarios/papers/{scenario}.yaml"))).unwrap();
    let edits: Vec<Edit> = changes.iter().map(|change| Edit::parse(change).unwrap()).collect();
    Experiment::load(&file, &edits).unwrap()
}

fn rounded(number: f64) -> f64 {
    (number * 1e6).round() / 1e6
}

/// What a drive showed: its head once, and its ticks without their answers.
type Seen = Arc<Mutex<(Value, Vec<Tick>)>>;

/// A local planner that writes down what it is asked.
struct Witness {
    planner: Box<dyn LocalPlanner>,
    seen: Seen,
    revision: Option<u64>,
}

impl LocalPlanner for Witness {
    fn decide(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Result<Decision, Failure> {
        let mut seen = self.seen.lock().unwrap();
        let belief = situation.belief;
        let cells = |cells: &mut dyn Iterator<Item = Cell>| cells.map(|cell| [cell.col, cell.row]).collect::<Vec<_>>();
        if seen.1.is_empty() {
            let grid = belief.grid();
            let occupied = (0..grid.occupied().len()).filter(|&index| grid.occupied()[index]);
            let mut known = occupied.map(|index| grid.cell(index)).filter(|cell| !belief.added().contains(cell));
            let vertices: Vec<[f64; 2]> = guidance.path.vertices().map(|point| [point.x, point.y]).collect();
            let nodes: Vec<f64> = guidance.key_nodes.iter().map(|node| node.along_m).collect();
            seen.0 = json!({
                "cols": grid.cols(), "rows": grid.rows(), "resolution_m": grid.resolution_m(),
                "known": cells(&mut known), "dt_s": situation.dt_s, "path": vertices, "key_nodes_m": nodes,
            });
        }
        let is_new =
            self.revision != Some(belief.revision()) && !(self.revision.is_none() && belief.added().is_empty());
        self.revision = Some(belief.revision());
        let mover = |mover: &SensedObstacle| {
            let (p, v) = (mover.position, mover.velocity);
            [p.x, p.y, v.x, v.y, mover.radius_m()].map(rounded)
        };
        let (pose, twist) = (situation.pose, situation.twist);
        seen.1.push(Tick {
            tick: situation.tick,
            pose: [pose.position.x, pose.position.y, pose.theta].map(rounded),
            twist: [twist.v, twist.omega].map(rounded),
            progress_m: rounded(guidance.progress_m),
            added: is_new.then(|| cells(&mut belief.added().iter().copied())),
            movers: situation.obstacles.iter().map(mover).collect(),
            state: String::new(),
            region: 0,
            conflict: false,
            failures: 0,
            command: [0.0, 0.0],
        });
        self.planner.decide(situation, guidance)
    }

    fn entry(&self) -> &'static Entry {
        self.planner.entry()
    }
}

/// The robot of a drive's head.
fn robot(head: &Value) -> Robot {
    let number = |key: &str| head["robot"][key].as_f64().unwrap();
    Robot {
        radius_m: number("radius_m"),
        speed_max_mps: number("speed_max_mps"),
        reverse_speed_max_mps: number("reverse_speed_max_mps"),
        acceleration_max_mps2: number("acceleration_max_mps2"),
        deceleration_max_mps2: number("deceleration_max_mps2"),
        yaw_rate_max_radps: number("yaw_rate_max_radps"),
        yaw_acceleration_max_radps2: number("yaw_acceleration_max_radps2"),
        ..Robot::default()
    }
}

/// The answers of a fresh planner to the ticks of a drive, in order.
fn answers(choice: &LocalChoice, drive: &Drive) -> Vec<Tick> {
    let head = &drive.head;
    let (robot, mut planner) = (robot(head), choice.build());
    let whole = |key: &str| i32::try_from(head[key].as_i64().unwrap()).unwrap();
    let mut grid = OccupancyGrid::empty(whole("cols"), whole("rows"), head["resolution_m"].as_f64().unwrap());
    for [col, row] in serde_json::from_value::<Vec<[i32; 2]>>(head["known"].clone()).unwrap() {
        grid.set_occupied(Cell { col, row });
    }
    let points: Vec<[f64; 2]> = serde_json::from_value(head["path"].clone()).unwrap();
    let path = Path::polyline(&points.iter().map(|point| Vec2::new(point[0], point[1])).collect::<Vec<_>>());
    let mut nodes: Vec<KeyNode> = Vec::new();
    path.key_nodes(&mut nodes);
    let mut belief = Belief::from(&grid);
    let answer = |tick: &Tick| {
        for &[col, row] in tick.added.iter().flatten() {
            let square = grid.square(Cell { col, row });
            belief.add(square, |other| other == square);
        }
        let mover = |(id, mover): (usize, &[f64; 5])| {
            let [x, y, vx, vy, radius_m] = *mover;
            SensedObstacle::disc(id as u32, Vec2::new(x, y), Vec2::new(vx, vy), radius_m)
        };
        let movers: Vec<SensedObstacle> = tick.movers.iter().enumerate().map(mover).collect();
        let [x, y, theta] = tick.pose;
        let situation = Situation {
            tick: tick.tick,
            dt_s: head["dt_s"].as_f64().unwrap(),
            twist: Twist { v: tick.twist[0], omega: tick.twist[1] },
            obstacles: &movers,
            ..Situation::new(&robot, &belief, Pose::new(x, y, theta), path.end())
        };
        let guidance = Guidance { key_nodes: &nodes, path_revision: 1, ..Guidance::to_end(&path, tick.progress_m) };
        let decision = planner.decide(&situation, &guidance).unwrap();
        let notes = decision.notes.values();
        Tick {
            state: decision.state.name.to_owned(),
            region: notes[0] as u32,
            conflict: notes[1] == 1.0,
            failures: notes[2] as u32,
            command: [decision.command.v, decision.command.omega],
            ..tick.clone()
        }
    };
    drive.ticks.iter().map(answer).collect()
}

/// The planner of the drives' stack, and its head.
fn of_stack(experiment: &Experiment, name: &str) -> (StackSpec, Value) {
    let spec = experiment.stacks(0).find(|spec| spec.name == name).unwrap().clone();
    let robot = experiment.robot(0);
    let local = serde_json::to_value(&spec.local).unwrap()["pdwa"].clone();
    let window = &local["avoid"];
    let keys = [
        "heading_weight",
        "distance_weight",
        "velocity_weight",
        "speed_step_mps",
        "yaw_rate_step_radps",
        "horizon_s",
        "d_cap_m",
        "prediction",
        "va_distance",
        "predict_dynamic",
    ];
    let window: Value =
        keys.iter().map(|&key| (key.to_owned(), window[key].clone())).collect::<serde_json::Map<_, _>>().into();
    let head = json!({
        "robot": {
            "radius_m": robot.radius_m,
            "speed_max_mps": robot.speed_max_mps,
            "reverse_speed_max_mps": robot.reverse_speed_max_mps,
            "acceleration_max_mps2": robot.acceleration_max_mps2,
            "deceleration_max_mps2": robot.deceleration_max_mps2,
            "yaw_rate_max_radps": robot.yaw_rate_max_radps,
            "yaw_acceleration_max_radps2": robot.yaw_acceleration_max_radps2,
        },
        "params": {"split": local["split"], "trigger": local["trigger"]},
        "window": window,
    });
    (spec, head)
}

/// Drives and writes `pdwa_drives.jsonl`.
fn bless() {
    let mut out = String::new();
    for (scenario, name, changes, episodes, ticks) in DRIVES {
        let experiment = experiment(scenario, changes);
        let (spec, common) = of_stack(&experiment, name);
        let settings = experiment.scenario();
        for episode in episodes {
            let Ok(scene) = experiment.scene(0, episode) else { continue };
            let conditions = Conditions {
                seed: EpisodeSeed { seed: settings.seed, episode },
                sensing: settings.sensing.clone(),
                localisation: settings.localisation.clone(),
                actuation: settings.actuation.clone(),
                control_period_s: settings.control_period_s,
            };
            let (robot, termination) = (experiment.robot(0), &settings.termination);
            let setting = Setting { scene: &scene, robot, conditions: &conditions, termination, way_m: None };
            let seen = Seen::default();
            let witness = Witness { planner: spec.local.build(), seen: Arc::clone(&seen), revision: None };
            let global = spec.global.as_ref().map(|global| global.build());
            let stages = spec.path.iter().map(|stage| stage.build()).collect();
            let mut stack = Stack::new(global, stages, Box::new(witness)).with_planning(&settings.planning);
            Runner::default().run(setting, &mut stack);
            let (mut head, mut seen) = core::mem::take(&mut *seen.lock().unwrap());
            seen.truncate(ticks);
            for (key, value) in common.as_object().unwrap() {
                head[key] = value.clone();
            }
            (head["scenario"], head["stack"], head["episode"]) = (scenario.into(), name.into(), episode.into());
            head["changes"] = changes.into();
            // As they will be read.
            let text = serde_json::to_string(&(head, seen)).unwrap();
            let (head, ticks): (Value, Vec<Tick>) = serde_json::from_str(&text).unwrap();
            let mut drive = Drive { head, ticks };
            drive.ticks = answers(&spec.local, &drive);
            out.push_str(&format!("{}\n", json!({"drive": drive.head})));
            for tick in &drive.ticks {
                out.push_str(&format!("{}\n", serde_json::to_string(tick).unwrap()));
            }
        }
    }
    fs::write(data("pdwa_drives.jsonl"), out).unwrap();
}

fn drives() -> Vec<Drive> {
    let mut drives: Vec<Drive> = Vec::new();
    for line in fs::read_to_string(data("pdwa_drives.jsonl")).unwrap().lines() {
        match serde_json::from_str::<Value>(line).unwrap() {
            Value::Object(mut object) if object.contains_key("drive") => {
                drives.push(Drive { head: object.remove("drive").unwrap(), ticks: Vec::new() });
            }
            tick => drives.last_mut().unwrap().ticks.push(serde_json::from_value(tick).unwrap()),
        }
    }
    drives
}

#[test]
fn the_planner_decides_as_recorded() {
    if is_blessing() {
        bless();
    }
    for drive in drives() {
        let changes: Vec<String> = serde_json::from_value(drive.head["changes"].clone()).unwrap();
        let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
        let experiment = experiment(drive.head["scenario"].as_str().unwrap(), &changes);
        let (spec, _) = of_stack(&experiment, drive.head["stack"].as_str().unwrap());
        for (now, then) in answers(&spec.local, &drive).iter().zip(&drive.ticks) {
            let is_same = now.command.iter().zip(&then.command).all(|(a, b)| (a - b).abs() < 1e-12);
            assert!(is_same, "bless if that is meant: {now:?}\n{then:?}");
            assert_eq!(*now, Tick { command: now.command, ..then.clone() }, "bless if that is meant");
        }
    }
}

/// A row of `pdwa_second.csv`.
#[derive(Debug, Deserialize)]
struct Second {
    drive: usize,
    tick: u32,
    state: String,
    region: u32,
    conflict: bool,
    failures: u32,
    v: Option<f64>,
    omega: Option<f64>,
}

#[test]
fn the_second_implementation_decides_the_same() {
    let first = fs::read_to_string(data("pdwa_drives.jsonl")).unwrap();
    let second = fs::read_to_string(data("pdwa_second.csv")).unwrap();
    let (origin, second) = second.split_once('\n').unwrap();
    let mut hash = Fnv1a::default();
    hash.bytes(first.as_bytes());
    let digest = Digest(hash.value()).to_string();
    assert!(origin.ends_with(&digest), "{origin}, but it is {digest}: run python3 tests/oracles/qin2026_pdwa.py");

    let mut rows = csv::Reader::from_reader(second.as_bytes()).into_deserialize::<Second>().map(|row| row.unwrap());
    let mut mirrored = 0;
    let mut in_state = std::collections::BTreeMap::<String, u32>::new();
    for (number, drive) in drives().iter().enumerate() {
        for tick in &drive.ticks {
            let row = rows.next().unwrap();
            assert_eq!((row.drive, row.tick), (number, tick.tick));
            let (ours, theirs) = (
                (&tick.state, tick.region, tick.conflict, tick.failures),
                (&row.state, row.region, row.conflict, row.failures),
            );
            assert_eq!(ours, theirs, "drive {number}, {tick:?}");
            // The command on the way is the path tracker's, which the paper does not name.
            if let (Some(v), Some(omega)) = (row.v, row.omega) {
                let is_near = |a: f64, b: f64| (a - b).abs() <= 1e-9;
                let is_same = is_near(v, tick.command[0]) && is_near(omega, tick.command[1]);
                // A robot in the middle of a lane has two best ways that mirror each other: rounding decides.
                let is_mirrored = is_near(v, tick.command[0]) && is_near(omega, -tick.command[1]);
                assert!(is_same || is_mirrored, "drive {number}, {tick:?}\n{row:?}");
                mirrored += u32::from(!is_same);
            } else {
                assert_eq!(tick.state, "follow");
            }
            *in_state.entry(tick.state.clone()).or_default() += 1;
        }
    }
    assert!(rows.next().is_none());
    assert!(mirrored <= 2, "{mirrored}");
    for (state, least) in [("follow", 1000), ("avoid", 1000), ("retreat", 50), ("withdraw", 50), ("wait", 10)] {
        assert!(in_state.get(state).is_some_and(|&ticks| ticks >= least), "{in_state:?}");
    }
}
