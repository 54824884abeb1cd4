//! The decisions of local planners with states, tick by tick, against second implementations written from the papers alone (`tests/oracles/`).
//!
//! `PLANNER_drives.jsonl` holds what the planner knew and decided at every tick of drives through its paper's scenarios, positions
//! rounded to six decimals and twists to twelve; `PLANNER_second.csv` what the second implementation makes of it. Written anew with
//!
//!     SIMRUN_BLESS=1 cargo test --release --test it recorded_decisions::the_planners
//!     python3 tests/oracles/qin2026_pdwa.py
//!     python3 tests/oracles/zhao2025_barr_dwa.py
//!     python3 tests/oracles/hu2024_follow_dwa.py

use super::paper_drives::{answers_to, data, drive, experiment};
use super::support::is_blessing;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use simrun::experiment::Experiment;
use simrun::geometry::{KeyNode, Path, Pose, Twist, Vec2};
use simrun::map::{Cell, OccupancyGrid};
use simrun::observation::{Belief, SensedObstacle};
use simrun::plan::contract::{Decision, Entry, Failure, Guidance, LocalPlanner, Situation};
use simrun::plan::local::LocalChoice;
use simrun::plan::stack::StackSpec;
use simrun::robot::Robot;
use std::fs;
use std::sync::{Arc, Mutex};

/// Drives from which decisions are taken: scenario, stack, changes, episodes, ticks.
type From = (&'static str, &'static str, &'static [&'static str], core::ops::Range<u64>, usize);

/// A planner whose decisions are recorded.
struct Recording {
    planner: &'static str,
    oracle: &'static str,
    drives: &'static [From],
    /// Least number of ticks in each state, so that an empty recording does not pass.
    least: &'static [(&'static str, u32)],
}

const RECORDINGS: [Recording; 3] = [
    Recording {
        planner: "pdwa",
        oracle: "qin2026_pdwa.py",
        drives: PDWA,
        least: &[("follow", 1000), ("avoid", 1000), ("retreat", 50), ("withdraw", 50), ("wait", 10)],
    },
    Recording {
        planner: "barr_dwa",
        oracle: "zhao2025_barr_dwa.py",
        drives: BARR,
        least: &[("track", 2000), ("recover", 5)],
    },
    Recording {
        planner: "follow_dwa",
        oracle: "hu2024_follow_dwa.py",
        drives: FOLLOW,
        least: &[("track", 2000), ("brake", 100), ("follow", 300), ("recover", 100)],
    },
];

const RELATIVE: &str = "stacks.*.local.barr_dwa.barr=relative";
const TARGET: &str = "stacks.*.local.barr_dwa.barr=target";
const FACTOR: &str = "stacks.*.local.barr_dwa.barr_mode=multiplicative";
const ALWAYS: &str = "stacks.*.local.barr_dwa.barr_when=always";
const TWO_CROSS: &str = "obstacles.moving.0.crossing.count=2";
const NO_NEW_PATH: &str = "stacks.*.replan=never";

const BARR: &[From] = &[
    ("zhao2025_robot", "improved", &["seed=8500000"], 0..6, 200),
    ("zhao2025_robot", "improved_window", &["seed=8500000", RELATIVE], 0..2, 200),
    ("zhao2025_unknown", "improved_once", &["seed=8600000", TWO_CROSS], 0..2, 300),
    ("zhao2025_unknown", "improved", &["seed=8600000", TWO_CROSS, NO_NEW_PATH, TARGET], 2..4, 300),
    ("zhao2025_unknown", "improved", &["seed=8700000", TWO_CROSS, NO_NEW_PATH, FACTOR], 0..2, 300),
    ("zhao2025_unknown", "improved", &["seed=8700000", TWO_CROSS, NO_NEW_PATH, ALWAYS], 2..4, 300),
];

const LEAD: &str = "stacks.*.local.follow_dwa.brake_lead_s=1";
const HEAD_ON: &str = "stacks.*.local.follow_dwa.brake_angle_max_deg=180";
const SHORT_WAIT: &str = "stacks.*.local.follow_dwa.wait_max_s=2";
const ARC: &str = "stacks.*.local.follow_dwa.va_distance=arc";

const FOLLOW: &[From] = &[
    ("hu2024_states", "improved", &["seed=8500000"], 0..8, 400),
    ("hu2024_trap", "improved", &["seed=8500000", SHORT_WAIT], 0..5, 400),
    ("hu2024_table3", "improved_dwa", &["seed=8600000", LEAD], 0..2, 400),
    ("hu2024_table3", "fusion", &["seed=8600000"], 2..4, 400),
    ("hu2024_table3", "fusion", &["seed=8700000", HEAD_ON, ARC], 0..2, 400),
    ("hu2024_table2", "fusion", &["seed=8800000"], 0..1, 400),
];

const PDWA: &[From] = &[
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
    sub_goal: [f64; 2],
    /// The cells that the known map lacks, where they have changed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    added: Option<Vec<[i32; 2]>>,
    /// x, y, vx, vy, radius, number.
    movers: Vec<[f64; 6]>,
    state: String,
    notes: Vec<f64>,
    command: [f64; 2],
}

/// A drive: its head, as the second implementation reads it, and its ticks.
struct Drive {
    head: Value,
    ticks: Vec<Tick>,
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
                "goal": [situation.goal.x, situation.goal.y],
            });
        }
        let is_new =
            self.revision != Some(belief.revision()) && !(self.revision.is_none() && belief.added().is_empty());
        self.revision = Some(belief.revision());
        let mover = |mover: &SensedObstacle| {
            let (p, v) = (mover.position, mover.velocity);
            [p.x, p.y, v.x, v.y, mover.radius_m(), f64::from(mover.id)].map(rounded)
        };
        let (pose, twist) = (situation.pose, situation.twist);
        seen.1.push(Tick {
            tick: situation.tick,
            pose: [pose.position.x, pose.position.y, pose.theta].map(rounded),
            twist: [twist.v, twist.omega].map(|number| (number * 1e12).round() / 1e12),
            progress_m: rounded(guidance.progress_m),
            sub_goal: [guidance.sub_goal.x, guidance.sub_goal.y].map(rounded),
            added: is_new.then(|| cells(&mut belief.added().iter().copied())),
            movers: situation.obstacles.iter().map(mover).collect(),
            state: String::new(),
            notes: Vec::new(),
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
        let mover = |&[x, y, vx, vy, radius_m, id]: &[f64; 6]| {
            SensedObstacle::disc(id as u32, Vec2::new(x, y), Vec2::new(vx, vy), radius_m)
        };
        let movers: Vec<SensedObstacle> = tick.movers.iter().map(mover).collect();
        let [x, y, theta] = tick.pose;
        let situation = Situation {
            tick: tick.tick,
            dt_s: head["dt_s"].as_f64().unwrap(),
            twist: Twist { v: tick.twist[0], omega: tick.twist[1] },
            obstacles: &movers,
            ..Situation::new(&robot, &belief, Pose::new(x, y, theta), path.end())
        };
        let sub_goal = Vec2::new(tick.sub_goal[0], tick.sub_goal[1]);
        let guidance =
            Guidance { key_nodes: &nodes, path_revision: 1, sub_goal, ..Guidance::to_end(&path, tick.progress_m) };
        let decision = planner.decide(&situation, &guidance).unwrap();
        Tick {
            state: decision.state.name.to_owned(),
            notes: decision.notes.values().to_vec(),
            command: [decision.command.v, decision.command.omega],
            ..tick.clone()
        }
    };
    drive.ticks.iter().map(answer).collect()
}

/// The planner of the drives' stack, and its head.
fn of_stack(experiment: &Experiment, name: &str, planner: &str) -> (StackSpec, Value) {
    let spec = experiment.stacks(0).find(|spec| spec.name == name).unwrap().clone();
    let robot = experiment.robot(0);
    let head = json!({
        "planner": planner,
        "robot": {
            "radius_m": robot.radius_m,
            "speed_max_mps": robot.speed_max_mps,
            "reverse_speed_max_mps": robot.reverse_speed_max_mps,
            "acceleration_max_mps2": robot.acceleration_max_mps2,
            "deceleration_max_mps2": robot.deceleration_max_mps2,
            "yaw_rate_max_radps": robot.yaw_rate_max_radps,
            "yaw_acceleration_max_radps2": robot.yaw_acceleration_max_radps2,
        },
        "params": serde_json::to_value(&spec.local).unwrap()[planner],
    });
    (spec, head)
}

/// Drives and writes the recording.
fn bless(recording: &Recording) {
    let mut out = String::new();
    for &(scenario, name, changes, ref episodes, ticks) in recording.drives {
        let experiment = experiment(scenario, changes);
        let (spec, common) = of_stack(&experiment, name, recording.planner);
        for episode in episodes.clone() {
            let seen = Seen::default();
            let witness = Witness { planner: spec.local.build(), seen: Arc::clone(&seen), revision: None };
            if !drive(&experiment, episode, &spec, Box::new(witness)) {
                continue;
            }
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
    fs::write(data(&format!("{}_drives.jsonl", recording.planner)), out).unwrap();
}

/// The drives in `PLANNER_drives.jsonl` or `PLANNER_situations.jsonl`.
fn drives(planner: &str, what: &str) -> Vec<Drive> {
    let mut drives: Vec<Drive> = Vec::new();
    for line in fs::read_to_string(data(&format!("{planner}_{what}.jsonl"))).unwrap().lines() {
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
fn the_planners_decide_as_recorded() {
    for recording in &RECORDINGS {
        let planner = recording.planner;
        if is_blessing() {
            bless(recording);
        }
        for drive in drives(planner, "drives") {
            for (now, then) in answers(&planner_of(&drive, planner), &drive).iter().zip(&drive.ticks) {
                let is_same = is_close(&now.command, &then.command) && is_close(&now.notes, &then.notes);
                assert!(is_same && now.state == then.state, "bless if that is meant: {now:?}\n{then:?}");
            }
        }
    }
}

/// The planner that drove a drive, by its head.
fn planner_of(drive: &Drive, planner: &str) -> LocalChoice {
    let changes: Vec<String> = serde_json::from_value(drive.head["changes"].clone()).unwrap();
    let changes: Vec<&str> = changes.iter().map(String::as_str).collect();
    let experiment = experiment(drive.head["scenario"].as_str().unwrap(), &changes);
    of_stack(&experiment, drive.head["stack"].as_str().unwrap(), planner).0.local
}

fn is_close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
}

/// A row of `PLANNER_second.csv`; a column that the planner has not is empty.
#[derive(Debug, Deserialize)]
struct Second {
    drive: usize,
    tick: u32,
    state: String,
    region: Option<u32>,
    conflict: Option<bool>,
    failures: Option<u32>,
    cap_mps: Option<f64>,
    v: Option<f64>,
    omega: Option<f64>,
    /// By how much the best score exceeds the second best, as a share.
    margin: Option<f64>,
}

impl Second {
    /// The notes that the planner must have published; `speed_max_mps` is the cap where there is none.
    fn notes(&self, planner: &str, speed_max_mps: f64) -> Vec<f64> {
        match planner {
            "pdwa" => {
                let conflict = f64::from(u8::from(self.conflict.unwrap()));
                vec![f64::from(self.region.unwrap()), conflict, f64::from(self.failures.unwrap())]
            }
            "follow_dwa" => vec![self.cap_mps.unwrap_or(speed_max_mps)],
            _ => Vec::new(),
        }
    }
}

fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9
}

fn are_near(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(&a, &b)| is_near(a, b))
}

#[test]
fn the_second_implementations_decide_the_same() {
    for Recording { planner, oracle, least, .. } in RECORDINGS {
        let second = answers_to(&format!("{planner}_drives.jsonl"), &format!("{planner}_second.csv"), oracle);
        let mut rows = csv::Reader::from_reader(second.as_bytes()).into_deserialize::<Second>().map(|row| row.unwrap());
        let mut otherwise = 0;
        let mut in_state = std::collections::BTreeMap::<String, u32>::new();
        for (number, drive) in drives(planner, "drives").iter().enumerate() {
            let speed_max_mps = robot(&drive.head).speed_max_mps;
            for tick in &drive.ticks {
                let row = rows.next().unwrap();
                assert_eq!((row.drive, row.tick), (number, tick.tick));
                assert_eq!(tick.state, row.state, "{planner}, drive {number}, {tick:?}\n{row:?}");
                let is_noted = are_near(&row.notes(planner, speed_max_mps), &tick.notes);
                assert!(is_noted, "{planner}, drive {number}, {tick:?}\n{row:?}");
                if let (Some(v), Some(omega)) = (row.v, row.omega) {
                    let is_same = is_near(v, tick.command[0]) && is_near(omega, tick.command[1]);
                    // A robot in the middle of a lane has two best ways that mirror each other: rounding decides.
                    let is_mirrored = is_near(v, tick.command[0]) && is_near(omega, -tick.command[1]);
                    // The poses of rollouts are rounded by about 10 µm, which moves a score by up to about 4e-6.
                    let is_tie = row.margin.is_some_and(|margin| margin < 1e-6);
                    assert!(is_same || is_mirrored || is_tie, "{planner}, drive {number}, {tick:?}\n{row:?}");
                    otherwise += u32::from(!is_same);
                } else {
                    // The command on the way is the path tracker's, which the paper does not name.
                    assert_eq!((planner, &*tick.state), ("pdwa", "follow"));
                }
                *in_state.entry(tick.state.clone()).or_default() += 1;
            }
        }
        assert!(rows.next().is_none());
        assert!(otherwise <= 2, "{planner}: {otherwise}");
        for &(state, least) in least {
            assert!(in_state.get(state).is_some_and(|&ticks| ticks >= least), "{planner}: {in_state:?}");
        }
    }
}

/// Made-up ticks on bent paths among movers of several sizes, answered by the second implementations: rules that the drives hardly try.
#[test]
fn made_up_situations_are_decided_as_the_second_implementations_do() {
    for (planner, states) in
        [("barr_dwa", &["track", "recover"][..]), ("follow_dwa", &["track", "brake", "follow", "recover"])]
    {
        let mut in_state = std::collections::BTreeMap::<String, u32>::new();
        for (number, drive) in drives(planner, "situations").iter().enumerate() {
            for (ours, theirs) in answers(&planner_of(drive, planner), drive).iter().zip(&drive.ticks) {
                let is_same = are_near(&ours.notes, &theirs.notes) && are_near(&ours.command, &theirs.command);
                assert!(ours.state == theirs.state && is_same, "{planner}, drive {number}, {ours:?}\n{theirs:?}");
                *in_state.entry(ours.state.clone()).or_default() += 1;
            }
        }
        assert!(
            states.iter().all(|state| in_state.get(*state).is_some_and(|&ticks| ticks >= 100)),
            "{planner}: {in_state:?}"
        );
    }
}
