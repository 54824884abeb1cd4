//! Our code allocates nothing in a tick: counted by the allocator itself, rapier's own step apart.
//!
//! A binary of its own, with one test: the count is of the whole process.

#![expect(unsafe_code, reason = "an allocator that counts has to be one")]
#![expect(clippy::print_stderr, reason = "says what rapier allocates")]

use rapier2d::prelude::{
    ActiveCollisionTypes, BroadPhaseBvh, BvhOptimizationStrategy, ColliderBuilder, PhysicsWorld, Pose,
    RigidBodyBuilder, Vector,
};
use simrun::episode::{DT_S, Outcome, Runner, TerminationSpec};
use simrun::map::OccupancyGrid;
use simrun::observation::Observation;
use simrun::plan::global::GlobalChoice;
use simrun::plan::local::{Decision, Guidance, LocalChoice, LocalPlanner};
use simrun::plan::stack::{PlanningSpec, Stack};
use simrun::rng::EpisodeSeed;
use simrun::robot::Robot;
use simrun::world::{Conditions, Scene, SceneSpec, StaticMap};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
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
    fn decide(&mut self, observation: &Observation<'_>, guidance: &Guidance<'_>) -> Decision {
        let decision = self.inner.decide(observation, guidance);
        self.counts.lock().expect("one thread").push(allocations());
        decision
    }

    fn reset(&mut self) {
        self.inner.reset();
        self.counts.lock().expect("one thread").clear();
    }
}

/// What rapier allocates, by itself, to move so many bodies and step, step by step: its list of what was
/// moved among it. The first steps build what the later ones use again.
fn rapier_allocates(bodies: usize) -> Vec<u64> {
    let broad_phase = BroadPhaseBvh::with_optimization_strategy(BvhOptimizationStrategy::None);
    let mut physics = PhysicsWorld { gravity: Vector::ZERO, broad_phase, ..PhysicsWorld::default() };
    physics.integration_parameters.dt = DT_S as f32;
    let inert = |radius_m: f32| {
        ColliderBuilder::ball(radius_m).density(0.0).active_collision_types(ActiveCollisionTypes::empty())
    };
    physics.insert_collider(inert(1.0), None);
    let bodies: Vec<_> = (0..bodies)
        .map(|k| {
            let pose = Pose::from_translation(Vector::new(3.0 * k as f32, 5.0));
            let body = RigidBodyBuilder::kinematic_position_based().pose(pose).can_sleep(false);
            physics.insert(body, inert(0.3)).0
        })
        .collect();
    let mut moved = |step: usize| {
        let before = allocations();
        for (k, &handle) in bodies.iter().enumerate() {
            let pose = Pose::from_translation(Vector::new(3.0 * k as f32 + 0.05 * step as f32, 5.0));
            physics.bodies[handle].set_next_kinematic_position(pose);
        }
        physics.step();
        allocations() - before
    };
    (0..100).map(&mut moved).collect()
}

#[test]
fn a_tick_allocates_nothing_but_what_rapier_does() {
    const MOVERS: usize = 8;
    let rapier = rapier_allocates(1 + MOVERS);
    let usual = rapier[rapier.len() - 1];
    eprintln!(
        "rapier allocates {} times in its first steps and {usual} times in each later one",
        rapier[..2].iter().sum::<u64>()
    );
    let row = |row: usize| {
        if row % 13 == 6 {
            "....##......####......######....##......"
        } else {
            "........................................"
        }
    };
    let rows: Vec<&str> = (0..40).map(row).collect();
    let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(&rows, 0.5)));
    let yaml = format!(
        "{{unknown_static: [random: {{count: 4, placement: on_route}}], moving: [random: {{count: {MOVERS}, speed_mps: [0.3, 0.6]}}]}}"
    );
    let spec = SceneSpec { obstacles: serde_yaml::from_str(&yaml).expect("valid"), ..SceneSpec::default() };
    let robot = Robot::default();
    let (mut ticks, mut seen, mut planned) = (0, 0, 0);
    for local in ["dwa", "imp_dwa", "pure_pursuit"] {
        let counts = Arc::new(Mutex::new(Vec::with_capacity(20_000)));
        let inner = LocalChoice::by_name(local).expect("defaults").build();
        let watched = Watched { inner, counts: Arc::clone(&counts) };
        let global = GlobalChoice::by_name("a_star").expect("defaults").build();
        let planning: PlanningSpec = serde_yaml::from_str("replan: when_blocked").expect("valid");
        let mut stack = Stack::new(Some(global), Vec::new(), Box::new(watched)).with_planning(&planning);
        let mut runner = Runner::default();
        for episode in 0..6 {
            let seed = EpisodeSeed { seed: 5, episode };
            let scene = Scene::generate(&spec, &map, &robot, 0.3, seed).expect("feasible");
            // The first time makes room for what the second needs.
            for _ in 0..2 {
                let outcome =
                    runner.run(&scene, &robot, &Conditions::default(), &TerminationSpec::default(), &mut stack);
                assert!(!matches!(outcome, Outcome::PlannerError { .. }), "{outcome:?}");
            }
            let trace = &runner.record.trace;
            let counts = counts.lock().expect("one thread");
            // The first two steps of rapier build what the later ones use again.
            for (tick, pair) in counts.windows(2).enumerate().skip(2) {
                let allocated = pair[1] - pair[0];
                // What is counted from decision `tick` on ends with the decision of the next tick.
                let decided = tick as u32 + 1;
                if trace.paths.iter().any(|path| path.tick == decided) {
                    planned += 1; // a new path is kept in the trace
                    continue;
                }
                assert!(
                    allocated <= usual,
                    "tick {decided} of episode {episode} with {local}: {allocated} allocations, rapier {usual}"
                );
                ticks += 1;
            }
            seen += trace.ticks.last().map_or(0, |tick| tick.seen_statics);
        }
    }
    eprintln!("{ticks} ticks, {planned} ticks with a new path, {seen} unknown statics seen");
    assert!(ticks > 4000 && seen > 10, "{ticks} {seen}");
}
