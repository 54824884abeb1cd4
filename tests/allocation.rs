//! Our code allocates nothing in a tick, and a run takes about the memory that was estimated: counted by the allocator itself, rapier's
//! own step apart.
//!
//! A binary of its own, with one test, and no module of `it`: the allocator is that of the whole process, and so is the count.

#![expect(unsafe_code, reason = "an allocator that counts has to be one")]
#![expect(clippy::print_stderr, reason = "says what rapier allocates")]

use rapier2d::prelude::{
    ActiveCollisionTypes, BroadPhaseBvh, BvhOptimizationStrategy, ColliderBuilder, PhysicsWorld, Pose,
    RigidBodyBuilder, SharedShape, Vector,
};
use simrun::episode::{Outcome, Runner, Setting, TerminationSpec};
use simrun::experiment::{Experiment, Session};
use simrun::geometry::Vec2;
use simrun::map::OccupancyGrid;
use simrun::plan::contract::{Decision, Entry, Failure, Guidance, LocalPlanner, Situation};
use simrun::plan::global::GlobalChoice;
use simrun::plan::local::LocalChoice;
use simrun::plan::stack::{PlanningSpec, Stack};
use simrun::results::Existing;
use simrun::rng::EpisodeSeed;
use simrun::robot::Robot;
use simrun::scenario::{Scenario, ScenarioFile};
use simrun::trace::Trace;
use simrun::world::{Conditions, Scene, SceneSpec, Shape, StaticMap};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);
/// Bytes in use, and the most that ever were since it was last set.
static IN_USE: AtomicU64 = AtomicU64::new(0);
static PEAK: AtomicU64 = AtomicU64::new(0);

fn take(bytes: usize) {
    ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
    let before = IN_USE.fetch_add(bytes as u64, Ordering::Relaxed);
    PEAK.fetch_max(before + bytes as u64, Ordering::Relaxed);
}

fn give_back(bytes: usize) {
    IN_USE.fetch_sub(bytes as u64, Ordering::Relaxed);
}

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        take(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        give_back(layout.size());
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Both are in use while it is copied, unless the system can do better.
        take(size);
        give_back(layout.size());
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations() -> u64 {
    ALLOCATIONS.load(Ordering::Relaxed)
}

/// Notes the number of allocations so far at every tick of an episode.
struct Watched {
    inner: Box<dyn LocalPlanner>,
    counts: Arc<Mutex<Vec<u64>>>,
}

impl LocalPlanner for Watched {
    fn decide(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Result<Decision, Failure> {
        let decision = self.inner.decide(situation, guidance);
        self.counts.lock().expect("one thread").push(allocations());
        decision
    }

    fn entry(&self) -> &'static Entry {
        self.inner.entry()
    }

    fn reset(&mut self) {
        self.inner.reset();
        self.counts.lock().expect("one thread").clear();
    }
}

/// Allocations of rapier by itself in each tick of an episode: the same bodies in a bare world follow the same motion.
fn rapier_allocates(scene: &Scene, robot: &Robot, trace: &Trace) -> Vec<u64> {
    let broad_phase = BroadPhaseBvh::with_optimization_strategy(BvhOptimizationStrategy::None);
    let mut physics = PhysicsWorld { gravity: Vector::ZERO, broad_phase, ..PhysicsWorld::default() };
    let at = |p: Vec2| Pose::from_translation(Vector::new(p.x as f32, p.y as f32));
    let inert = |shape: SharedShape| {
        ColliderBuilder::new(shape).density(0.0).active_collision_types(ActiveCollisionTypes::empty())
    };
    // The map is one collider; its size is all that the tree knows of it.
    let half = 0.5 * scene.map.grid.extent_m() + Vec2::new(1.0, 1.0);
    let map = inert(SharedShape::cuboid(half.x as f32, half.y as f32));
    physics.insert_collider(map.position(at(0.5 * scene.map.grid.extent_m())), None);
    for obstacle in &scene.unknown_static {
        let shape = match obstacle.shape() {
            Shape::Disc { radius_m } => SharedShape::ball(*radius_m as f32),
            Shape::Rectangle { half_m } => SharedShape::cuboid(half_m.x as f32, half_m.y as f32),
            Shape::Polygon(_) => unreachable!("there is none in these scenes"),
        };
        let pose = obstacle.pose();
        let position = Pose::new(at(pose.position).translation, pose.theta as f32);
        physics.insert_collider(inert(shape).position(position), None);
    }
    let mut kinematic = |p: Vec2, radius_m: f64| {
        let body = RigidBodyBuilder::kinematic_position_based().pose(at(p)).can_sleep(false);
        physics.insert(body, inert(SharedShape::ball(radius_m as f32))).0
    };
    let robot = kinematic(scene.start.position, robot.radius_m);
    let movers: Vec<_> = scene.movers.iter().map(|mover| kinematic(mover.position, mover.radius_m())).collect();
    let step = |row: usize| {
        let before = allocations();
        let pose = trace.ticks[row].pose;
        physics.bodies[robot].set_position(Pose::new(at(pose.position).translation, pose.theta as f32), false);
        for (&mover, state) in movers.iter().zip(trace.movers_at(row)) {
            physics.bodies[mover].set_position(at(state.position), false);
        }
        physics.detect_collisions(&(), &());
        allocations() - before
    };
    (1..trace.ticks.len()).map(step).collect()
}

#[test]
fn memory_is_taken_as_it_is_promised() {
    a_tick_allocates_nothing_but_what_rapier_does();
    a_run_takes_the_memory_that_was_estimated();
}

/// Peaks of whole runs: at most twice the estimate and, on one thread, at least half of it.
fn a_run_takes_the_memory_that_was_estimated() {
    const SHORT: &str = "episodes: 2\ntermination: {timeout_s: 10, stuck_after_s: 9}\n";
    const HALL: &str = "map: {empty: {cols: 1000, rows: 1000, resolution_m: 0.05}}\n";
    const ROOM: &str = "map: {empty: {cols: 40, rows: 40}}\n";
    let folder = tempfile::tempdir().expect("a folder");
    let mut recording = String::from("time_s,id,x_m,y_m\n");
    for row in 0..200_000 {
        recording += &format!("{:.2},{},{:.3},4.5\n", f64::from(row / 20) * 0.1, row % 20, f64::from(row % 37));
    }
    std::fs::write(folder.path().join("recording.csv"), recording).expect("room");
    let cases = [
        format!("{HALL}stacks: {{global: [a_star], local: [pure_pursuit]}}\n"),
        format!("{HALL}stacks: {{global: [a_star, dijkstra, theta_star, d_star], local: [pure_pursuit]}}\n"),
        "map: {random: {cols: 1000, rows: 1000, resolution_m: 0.05, obstacles: 1000}}\nrobot: {radius_m: 0.05}\n\
         stacks: {global: [a_star], local: [dwa]}\n"
            .to_owned(),
        "map: {empty: {cols: 300, rows: 300}}\nobstacles: {moving: [random: {count: 3000, radius_m: 0.1}]}\n\
         robot: {radius_m: 0.1}\nstacks: {global: [a_star], local: [pure_pursuit]}\n"
            .to_owned(),
        format!("{ROOM}stacks: {{global: [a_star], local: [dwa: {{speed_samples: 400, yaw_rate_samples: 400}}]}}\n"),
        format!(
            "{ROOM}obstacles: {{moving: [replay: {{file: recording.csv}}]}}\nstacks: {{global: [a_star], local: [pure_pursuit]}}\n"
        ),
        format!("{ROOM}sensing: {{lidar: {{rays: 10000}}}}\nstacks: {{global: [a_star], local: [pure_pursuit]}}\n"),
    ];
    for (index, case) in cases.iter().enumerate() {
        let path = folder.path().join(format!("case{index}.yaml"));
        std::fs::write(&path, format!("{case}{SHORT}")).expect("room");
        for threads in [1, 2] {
            let before = IN_USE.load(Ordering::Relaxed);
            PEAK.store(before, Ordering::Relaxed);
            let file = ScenarioFile::open(&path).unwrap_or_else(|error| panic!("{error}"));
            let experiment = Experiment::load(&file, &[]).unwrap_or_else(|error| panic!("{error}"));
            let out = folder.path().join("out");
            let session = Session::open(&experiment, &out, Existing::Replace).expect("a folder");
            session.run(threads, None, || {}).expect("it runs");
            session.finish().expect("it ends").expect("it is whole");
            let peak = PEAK.load(Ordering::Relaxed) - before;
            let scenario = experiment.scenario();
            let cells =
                scenario.map.load(folder.path(), EpisodeSeed::default()).expect("a map").occupied().len() as u64;
            // What every program takes is no allocation.
            let base = Scenario::BASE_BYTES;
            let estimate = scenario.memory_bytes(cells, folder.path(), threads as u64) - base;
            eprintln!("case {index}, {threads} threads: {peak} bytes at most, {estimate} estimated");
            let slack = base / 4;
            // On a busy machine one of two threads may drive both worlds: then there was less at once than there may be.
            let is_least = threads == 1;
            assert!(
                peak <= 2 * estimate + slack && (!is_least || estimate <= 2 * peak + slack),
                "{case}{threads} threads: {peak} bytes at most, {estimate} estimated"
            );
        }
    }
}

fn a_tick_allocates_nothing_but_what_rapier_does() {
    let row = |row: usize| {
        if row % 13 == 6 {
            "....##......####......######....##......"
        } else {
            "........................................"
        }
    };
    let rows: Vec<&str> = (0..40).map(row).collect();
    let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(&rows, 0.5)));
    let yaml = "{unknown_static: [random: {count: 4, placement: on_route}], moving: [random: {count: 8, speed_mps: [0.3, 0.6]}]}";
    let spec = SceneSpec { obstacles: serde_yaml::from_str(yaml).expect("valid"), ..SceneSpec::default() };
    let robot = Robot::default();
    let (mut ticks, mut seen, mut planned, mut rapier_in_all) = (0, 0, 0, 0);
    for &local in LocalChoice::NAMES {
        let counts = Arc::new(Mutex::new(Vec::with_capacity(20_000)));
        let inner = LocalChoice::by_name(local).expect("defaults").build();
        let watched = Watched { inner, counts: Arc::clone(&counts) };
        let global = GlobalChoice::by_name("a_star").expect("defaults").build();
        let planning: PlanningSpec = serde_yaml::from_str("replan: when_blocked").expect("valid");
        let mut stack = Stack::new(Some(global), Vec::new(), Box::new(watched)).with_planning(&planning);
        let mut runner = Runner::default();
        for episode in 0..6 {
            let seed = EpisodeSeed { seed: 5, episode };
            let scene = Scene::generate(&spec, &map, &robot, seed).expect("feasible");
            let (conditions, termination) = (Conditions::default(), TerminationSpec::default());
            let setting = Setting {
                scene: &scene,
                robot: &robot,
                conditions: &conditions,
                termination: &termination,
                way_m: None,
            };
            // The first time makes room for what the second needs.
            for _ in 0..2 {
                let outcome = runner.run(setting, &mut stack);
                assert!(!matches!(outcome, Outcome::PlannerError { .. }), "{outcome:?}");
            }
            let trace = &runner.record.trace;
            let rapier = rapier_allocates(&scene, &robot, trace);
            let counts = counts.lock().expect("one thread");
            for (tick, pair) in counts.windows(2).enumerate() {
                let allocated = pair[1] - pair[0];
                // What is counted from decision `tick` on ends with the decision of the next tick.
                let decided = tick as u32 + 1;
                // A new path is made before its tick's decision, and kept in the trace after it.
                if trace.paths.iter().any(|path| path.tick == decided || path.tick + 1 == decided) {
                    planned += 1;
                    continue;
                }
                assert!(
                    allocated <= rapier[tick],
                    "tick {decided} of episode {episode} with {local}: {allocated} allocations, rapier {}",
                    rapier[tick]
                );
                ticks += 1;
                rapier_in_all += allocated;
            }
            seen += trace.ticks.last().map_or(0, |tick| tick.seen_statics);
        }
    }
    eprintln!(
        "{ticks} ticks: we allocate nothing, rapier {:.2} times a tick; beside them {planned} ticks about a new path; {seen} unknown statics seen",
        rapier_in_all as f64 / f64::from(ticks)
    );
    assert!(ticks > 3000 && seen > 10, "{ticks} {seen}");
}
