//! A whole tick: observe, decide, move, judge, rapier; and the beginning of an episode.
//!
//! `tick/world30/…` is the world of `benches/scenes/world30.world`: 30 m × 30 m, 200 static discs that the robot knows
//! (occupied cells of a map of 0.1 m), ten movers that shuttle on lanes, 900 ticks of 0.1 s, `a_star` + `dwa`. The time is that of
//! the whole episode, the beginning of the world and the first path among it, over the ticks that were driven.

use crate::measure::{Spread, alone};
use crate::{Line, Row, Settings, scenes};
use simrun::episode::{Outcome, Runner, Setting, TerminationSpec};
use simrun::geometry::{Pose, Vec2};
use simrun::map::formats::movingai;
use simrun::map::{Cell, OccupancyGrid};
use simrun::observation::Belief;
use simrun::plan::global::{GlobalChoice, a_star};
use simrun::plan::local::{LocalChoice, dwa};
use simrun::plan::stack::{Caps, PlanningSpec, StackSpec};
use simrun::rng::EpisodeSeed;
use simrun::robot::Robot;
use simrun::scenario::ScenarioFile;
use simrun::settings::quantity::{NonNegative, Positive, Samples};
use simrun::world::{Conditions, Mover, Patrol, Scene, StaticMap, World};
use std::path::Path as FilePath;
use std::sync::Arc;

/// Side of the cells of the known map, m.
const RESOLUTION_M: f64 = 0.1;

/// Its rows.
pub const ROWS: &[Row] = &[
    Row {
        name: "tick/world30/35",
        what: "one tick of the world that the Python peers drive; 35 candidates, as many as the papers' window has",
        target: None,
        measure: |settings| world30(settings, 5, 7),
    },
    Row {
        name: "tick/world30/400",
        what: "the same with 400 candidates",
        target: None,
        measure: |settings| world30(settings, 20, 20),
    },
    Row {
        name: "tick/warehouse",
        what: "one tick of scenarios/warehouse.yaml, stack a_star+dwa, 20 episodes",
        target: None,
        measure: warehouse,
    },
    Row {
        name: "growth/samples",
        what: "one tick of that world by the number of candidates",
        target: None,
        measure: by_samples,
    },
    Row {
        name: "growth/obstacles",
        what: "one tick by the number of static discs, none to 800, ten movers, 35 candidates",
        target: None,
        measure: by_obstacles,
    },
    Row {
        name: "growth/movers",
        what: "one tick by the number of movers, none to 200, 35 candidates; without static discs and a global planner",
        target: None,
        measure: by_movers,
    },
    Row {
        name: "start/512",
        what: "an episode's world on a map that is loaded, 512 x 512",
        target: None,
        measure: start,
    },
];

/// The world of the peers, as its file says it.
struct Peers {
    size: Vec2,
    discs: Vec<(Vec2, f64)>,
    movers: Vec<Mover>,
    start: Vec2,
    goal: Vec2,
    robot: Robot,
    termination: TerminationSpec,
}

impl Peers {
    fn read() -> Result<Self, String> {
        let file = scenes::folder().join("world30.world");
        let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        let (mut robot, mut movers, mut discs) = (Vec::new(), Vec::new(), Vec::new());
        let (mut size, mut duration_s) = (Vec::new(), 0.0);
        for line in text.lines().filter(|line| !line.starts_with('#') && !line.starts_with("type")) {
            let mut words = line.split_whitespace();
            let Some(key) = words.next() else { continue };
            let values: Result<Vec<f64>, _> = words.map(str::parse).collect();
            let values = values.map_err(|error| format!("{}: `{line}`: {error}", file.display()))?;
            match key {
                "size" => size = values,
                "steps" => duration_s = 0.1 * values[0],
                "robot" => robot = values,
                "moving" => movers.push(shuttle(&values)),
                "static" => discs.push((Vec2::new(values[0], values[1]), values[2])),
                _ => {}
            }
        }
        let timeout_s = Some(Positive::new(duration_s));
        Ok(Self {
            size: Vec2::new(size[0], size[1]),
            discs,
            movers,
            start: Vec2::new(robot[0], robot[1]),
            goal: Vec2::new(robot[2], robot[3]),
            robot: Robot { radius_m: robot[4], speed_max_mps: robot[5], ..Robot::default() },
            termination: TerminationSpec { timeout_s, ..TerminationSpec::default() },
        })
    }

    fn scene(&self) -> Scene {
        let cells = |side: f64| (side / RESOLUTION_M).round() as i32;
        let mut map = OccupancyGrid::empty(cells(self.size.x), cells(self.size.y), RESOLUTION_M);
        for row in 0..map.rows() {
            for col in 0..map.cols() {
                let square = map.square(Cell { col, row });
                if self.discs.iter().any(|&(centre, radius)| square.signed_distance(centre) < radius) {
                    map.set_occupied(Cell { col, row });
                }
            }
        }
        let way = self.goal - self.start;
        let start = Pose { position: self.start, theta: way.y.atan2(way.x) };
        let mut scene = Scene::new(&Arc::new(StaticMap::new(map)), start, self.goal);
        scene.movers.clone_from(&self.movers);
        scene
    }

    /// One line: a tick of an episode, `label` telling what it grows with.
    fn drive(&self, settings: &Settings, label: String, samples: (u32, u32), global: Option<GlobalChoice>) -> Line {
        let scene = self.scene();
        let conditions = Conditions { seed: EpisodeSeed { seed: 1, episode: 0 }, ..Conditions::default() };
        let local = LocalChoice::dwa(dwa::Params {
            speed_samples: Samples::new(samples.0),
            yaw_rate_samples: Samples::new(samples.1),
            predict_dynamic: true,
            ..dwa::Params::default()
        });
        let mut stack = StackSpec {
            name: "bench".to_owned(),
            global,
            path: Vec::new(),
            local,
            replan: None,
            sub_goals: None,
            movers: None,
            caps: Caps::default(),
        }
        .build(&PlanningSpec { inflation_m: Some(NonNegative::new(0.35)), ..PlanningSpec::default() });
        let mut runner = Runner::default();
        let (robot, termination) = (&self.robot, &self.termination);
        let setting = Setting { scene: &scene, robot, conditions: &conditions, termination, way_m: None };
        let mut drive = || runner.run(setting, &mut stack);
        let outcome = drive();
        let time = alone(settings.pairs, &mut drive);
        let trace = &runner.record.trace;
        let ticks = trace.ticks.len() - 1;
        let counts = format!(
            "{ticks} ticks, {:.1} rollouts per tick, {} recoveries, {}",
            trace.rollouts as f64 / ticks as f64,
            trace.recoveries,
            outcome.name()
        );
        Line::alone(label, time, ticks as f64, counts)
    }
}

/// A mover that drives to and fro between two points.
fn shuttle(values: &[f64]) -> Mover {
    let (from, to) = (Vec2::new(values[0], values[1]), Vec2::new(values[2], values[3]));
    let speed_mps = values[5];
    let velocity = (to - from) * (speed_mps / (to - from).norm());
    let patrol = Patrol { waypoints: Arc::new([from, to]), speed_mps, closed: false, pause_s: 0.0 };
    Mover { motion: patrol.into(), ..Mover::new(from, velocity, values[4]) }
}

fn world30(settings: &Settings, speeds: u32, yaw_rates: u32) -> Result<Vec<Line>, String> {
    let label = format!("{speeds} x {yaw_rates} samples");
    Ok(vec![Peers::read()?.drive(settings, label, (speeds, yaw_rates), a_star())])
}

fn a_star() -> Option<GlobalChoice> {
    Some(GlobalChoice::a_star(a_star::Params::default()))
}

fn by_samples(settings: &Settings) -> Result<Vec<Line>, String> {
    let peers = Peers::read()?;
    let line = |side: u32| peers.drive(settings, (side * side).to_string(), (side, side), a_star());
    Ok([5, 10, 15, 20, 30, 40].map(line).into())
}

fn by_obstacles(settings: &Settings) -> Result<Vec<Line>, String> {
    let line = |count: usize| {
        let peers = Peers::read()?;
        let mut places = Places::default();
        let discs = std::iter::from_fn(|| Some((places.next_in(peers.size), 0.15)));
        let clear =
            |&(centre, _): &(Vec2, f64)| [peers.start, peers.goal].iter().all(|end| (centre - end).norm() > 1.5);
        let discs = discs.filter(clear).take(count).collect();
        Ok(Peers { discs, ..peers }.drive(settings, count.to_string(), (5, 7), a_star()))
    };
    [0, 50, 100, 200, 400, 800].map(line).into_iter().collect()
}

fn by_movers(settings: &Settings) -> Result<Vec<Line>, String> {
    let line = |count: usize| {
        let peers = Peers::read()?;
        let mut places = Places::default();
        let lanes = std::iter::from_fn(|| Some((places.next_in(peers.size), places.next_in(peers.size))));
        let clear = |&(from, to): &(Vec2, Vec2)| {
            (from - to).norm() > 1.0 && [from, to].iter().all(|end| (end - peers.start).norm() > 3.0)
        };
        let movers = lanes.filter(clear).take(count);
        let movers = movers.map(|(from, to)| shuttle(&[from.x, from.y, to.x, to.y, 0.05, 0.5])).collect();
        let robot = Robot { radius_m: 0.05, ..peers.robot.clone() };
        let peers = Peers { discs: Vec::new(), movers, robot, ..peers };
        Ok(peers.drive(settings, count.to_string(), (5, 7), None))
    };
    [0, 10, 20, 50, 100, 200].map(line).into_iter().collect()
}

/// Places all over an area, by a linear congruential generator.
#[derive(Default)]
struct Places(u64);

impl Places {
    fn next_in(&mut self, size: Vec2) -> Vec2 {
        let mut share = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 33) as f64 / f64::from(1u32 << 31)
        };
        Vec2::new(size.x * share(), size.y * share())
    }
}

fn warehouse(settings: &Settings) -> Result<Vec<Line>, String> {
    let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/warehouse.yaml");
    let file = ScenarioFile::open(&file).map_err(|error| error.to_string())?;
    let scenario = file.read(&[]).map_err(|error| error.to_string())?;
    let points = file.points(&scenario, &[]).map_err(|error| error.to_string())?;
    let experiment =
        simrun::experiment::Experiment::new(scenario, points, file.folder()).map_err(|error| error.to_string())?;
    let spec = experiment.stacks(0).find(|spec| spec.name == "a_star+dwa").ok_or("no stack a_star+dwa")?;
    let scenario = experiment.scenario_at(0);
    let scenes: Result<Vec<Scene>, _> = (0..20).map(|episode| experiment.scene(0, episode)).collect();
    let scenes = scenes.map_err(|error| error.to_string())?;
    let mut stack = spec.build(&scenario.planning);
    let mut runner = Runner::default();
    let mut drive = || {
        let mut ticks = 0;
        for (episode, scene) in scenes.iter().enumerate() {
            let seed = EpisodeSeed { seed: scenario.seed, episode: episode as u64 };
            let conditions = Conditions { seed, sensing: scenario.sensing.clone(), ..Conditions::default() };
            let (robot, termination) = (experiment.robot(0), &scenario.termination);
            let setting = Setting { scene, robot, conditions: &conditions, termination, way_m: None };
            let outcome = runner.run(setting, &mut stack);
            assert!(!matches!(outcome, Outcome::PlannerError { .. }));
            ticks += runner.record.trace.ticks.len() - 1;
        }
        ticks
    };
    let ticks = drive();
    let time = alone(settings.pairs, &mut drive);
    Ok(vec![Line::alone("20 episodes", time, ticks as f64, format!("{ticks} ticks"))])
}

/// Work between a loaded map and the first tick.
fn start(settings: &Settings) -> Result<Vec<Line>, String> {
    let file = scenes::folder().join("random512-20.map");
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let map = Arc::new(StaticMap::new(movingai::parse(&text).map_err(|error| error.to_string())?));
    let robot = Robot::default();
    let generator = |ends: &str, statics: &str| {
        let yaml = format!(
            "name: start\nmap: {{movingai: {{file: {}}}}}\n{ends}\nstacks: {{global: [none], local: [dwa]}}\n\
             obstacles: {{{statics}moving: [{{random: {{count: 10, radius_m: 0.2, speed_mps: [0.2, 0.5]}}}}]}}\n",
            file.display()
        );
        let scenario = ScenarioFile::from_text("start.yaml", yaml).read(&[]).map_err(|error| error.to_string())?;
        let spec = scenario.scene_spec(FilePath::new(".")).map_err(|error| error.to_string())?;
        let (map, robot) = (&map, &robot);
        Ok::<_, String>(move |episode| {
            Scene::generate(&spec, map, robot, EpisodeSeed { seed: 1, episode }).map_err(|error| error.to_string())
        })
    };
    let statics = "unknown_static: [{random: {count: 2, shape: {disc: {radius_m: 0.3}}}}], ";
    let random = generator("start: random\ngoal: random", statics)?;
    let scene = random(0)?;
    let at = |p: Vec2| format!("[{}, {}]", p.x, p.y);
    let given = format!("start: {}\ngoal: {}", at(scene.start.position), at(scene.goal));
    let episodes = |generate: &dyn Fn(u64) -> Result<Scene, String>| {
        let mut episode = 0;
        alone(settings.pairs, || {
            episode = (episode + 1) % 64;
            generate(episode).is_ok()
        })
    };
    let given_time = episodes(&generator(&given, "")?);
    let ends_time = episodes(&generator("start: random\ngoal: random", "")?);
    let random_time = episodes(&random);
    let conditions = Conditions { seed: EpisodeSeed { seed: 1, episode: 0 }, ..Conditions::default() };
    let world_time = alone(settings.pairs, || World::new(&scene, &robot, &conditions).clearance_m());
    let belief_time = alone(settings.pairs, || Belief::new(&scene.map.grid, &scene.map.field));
    let bare = Scene { movers: Vec::new(), ..Scene::new(&map, scene.start, scene.goal) };
    let bare_time = alone(settings.pairs, || World::new(&bare, &robot, &conditions).clearance_m());
    let line = |name: &str, time: Spread| Line::alone(name, time, 1.0, "");
    Ok(vec![
        line("scene, 10 movers drawn", given_time),
        line("scene, ends drawn as well", ends_time),
        line("scene, ends, 2 statics drawn", random_time),
        line("world, 10 movers, 2 statics", world_time),
        line("world without obstacles", bare_time),
        line("belief", belief_time),
    ])
}
