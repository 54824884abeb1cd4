//! An experiment: episodes × stacks as ordered work, in parallel.
//!
//! One block is one world, driven by every stack. Workers take blocks from the results folder in the
//! order of the rows and hand them back as they finish; the folder writes them in order. Nothing in a block depends on another.

use crate::clock::Stopwatch;
use crate::episode::{DT_S, Outcome, Runner, Timings};
use crate::map::MapError;
use crate::metrics::{self, Metrics};
use crate::plan::stack::{Stack, StackSpec};
use crate::results::{Digest, Folder, Identity, Order, Point, ResultsError, Row, Timing};
use crate::rng::EpisodeSeed;
use crate::robot::Robot;
use crate::scenario::{Scenario, SweepPoint};
use crate::trace::{self, Trace};
use crate::world::{Conditions, Infeasible, Scene, SceneError, SceneSpec, StaticMap};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scenario ready to run: checked, its fixed map loaded once for all episodes of all points of its sweep.
#[derive(Debug)]
pub struct Experiment {
    scenario: Scenario,
    swept: Vec<String>,
    points: Vec<Setup>,
    base_dir: PathBuf,
}

/// What runs at one point of the sweep; a scenario without one is one point.
#[derive(Debug)]
struct Setup {
    /// The values of the swept keys.
    values: Vec<String>,
    scenario: Scenario,
    /// The stacks that run here: those that no earlier point has run in the same way.
    stacks: Vec<StackSpec>,
    scene_spec: SceneSpec,
    robot: Robot,
    fixed_map: Option<Arc<StaticMap>>,
}

/// Why an experiment cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum PrepareError {
    /// The fixed map cannot be had.
    #[error(transparent)]
    Map(#[from] MapError),
    /// Something that the scene needs cannot be had.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Every stack of a point of the sweep has run at an earlier one in the same way.
    #[error("the sweep's point {point} changes nothing: every stack has run like that before")]
    SamePoint {
        /// Its keys and values.
        point: String,
    },
}

/// Why a run ended before its work was done.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The results could not be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// A trace could not be written.
    #[error("cannot write the trace `{}`: {source}", path.display())]
    Trace {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// What one thread keeps from block to block: memory, never knowledge.
#[derive(Debug, Default)]
pub struct Worker {
    runner: Runner,
    point: u32,
    stacks: Vec<Option<Stack>>,
}

/// One episode with all that a picture or a trace file needs.
#[derive(Debug)]
pub struct Drive {
    /// The world before the first tick.
    pub scene: Scene,
    /// The row of `episodes.csv`.
    pub row: Row,
    /// What happened.
    pub trace: Trace,
}

impl Setup {
    /// `before` are the points before this one, whose map is used where it is the same.
    fn new(point: SweepPoint, base_dir: &Path, before: &[Self]) -> Result<Self, PrepareError> {
        let SweepPoint { values, scenario } = point;
        let shared = before.iter().find(|other| other.scenario.map == scenario.map);
        let fixed_map = match shared {
            Some(other) => other.fixed_map.clone(),
            None if scenario.map.is_fixed() => {
                let seed = EpisodeSeed { seed: scenario.seed, episode: 0 };
                Some(Arc::new(StaticMap::new(scenario.map.load(base_dir, seed)?)))
            }
            None => None,
        };
        // A stack that a swept key does not touch runs once.
        let is_new = |stack: &StackSpec| {
            before
                .iter()
                .all(|other| !other.stacks.contains(stack) || !differ_in_stacks_alone(&other.scenario, &scenario))
        };
        Ok(Self {
            stacks: scenario.stacks().into_iter().filter(is_new).collect(),
            scene_spec: scenario.scene_spec(base_dir)?,
            robot: Robot::new(&scenario.robot, &scenario.limits),
            values,
            fixed_map,
            scenario,
        })
    }
}

/// Whether the two scenarios give a stack that both have the same episodes.
fn differ_in_stacks_alone(a: &Scenario, b: &Scenario) -> bool {
    Scenario { stacks: b.stacks.clone(), ..a.clone() } == *b
}

impl Experiment {
    /// Prepares a checked scenario, with the points of its sweep ([`ScenarioFile::points`](crate::scenario::ScenarioFile::points));
    /// files are looked up relative to `base_dir`.
    ///
    /// # Errors
    /// If a fixed map or a recording cannot be loaded, or nothing changes at a point of the sweep.
    pub fn new(scenario: Scenario, points: Vec<SweepPoint>, base_dir: &Path) -> Result<Self, PrepareError> {
        let swept = scenario.sweep.keys();
        let mut setups: Vec<Setup> = Vec::new();
        for point in points {
            let setup = Setup::new(point, base_dir, &setups)?;
            if setup.stacks.is_empty() {
                let point = swept.iter().zip(&setup.values).map(|(key, value)| format!("{key} = {value}"));
                return Err(PrepareError::SamePoint { point: point.collect::<Vec<_>>().join(", ") });
            }
            setups.push(setup);
        }
        assert!(!setups.is_empty(), "an experiment has at least one point");
        Ok(Self { scenario, swept, points: setups, base_dir: base_dir.to_owned() })
    }

    /// The scenario that runs, its sweep included.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Number of points of the sweep: 1 without one.
    pub fn points(&self) -> u32 {
        self.points.len() as u32
    }

    /// The scenario at a point of the sweep.
    pub fn scenario_at(&self, point: u32) -> &Scenario {
        &self.points[point as usize].scenario
    }

    /// The robot that is driven at a point.
    pub fn robot(&self, point: u32) -> &Robot {
        &self.points[point as usize].robot
    }

    /// The stacks that run at a point, in the order of their rows.
    pub fn stacks(&self, point: u32) -> &[StackSpec] {
        &self.points[point as usize].stacks
    }

    /// The names of all stacks, in the order in which they first appear.
    pub fn stack_names(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for stack in self.points.iter().flat_map(|point| &point.stacks) {
            if !names.contains(&stack.name) {
                names.push(stack.name.clone());
            }
        }
        names
    }

    /// Keeps only the stacks of these names, in the scenario's order, and the points at which one of them runs.
    ///
    /// # Errors
    /// The name that no stack has.
    pub fn keep_stacks<'n>(&mut self, names: &'n [String]) -> Result<(), &'n str> {
        let known = self.stack_names();
        if let Some(unknown) = names.iter().find(|name| !known.contains(name)) {
            return Err(unknown);
        }
        for point in &mut self.points {
            point.stacks.retain(|stack| names.contains(&stack.name));
        }
        self.points.retain(|point| !point.stacks.is_empty());
        Ok(())
    }

    /// The order of the rows: every point, every episode, every stack.
    ///
    /// # Errors
    /// If a swept key is called like a column.
    ///
    /// # Panics
    /// If every stack was left out.
    pub fn order(&self) -> Result<Order, ResultsError> {
        let points = self.points.iter().map(|setup| Point {
            values: setup.values.clone(),
            stacks: setup.stacks.iter().map(|stack| stack.name.clone()).collect(),
        });
        Order::new(self.swept.clone(), points.collect(), u64::from(self.scenario.episodes.get()))
    }

    /// What makes a run of this experiment the same run as another.
    ///
    /// # Errors
    /// If the program cannot read its own file.
    pub fn identity(&self) -> Result<Identity, ResultsError> {
        Identity::new(&self.scenario.to_yaml(), self.scenario.seed, self.stack_names())
    }

    /// Runs what `folder` still wants on `threads` threads; `after` is told of every finished block, from any thread.
    ///
    /// # Errors
    /// If a row or a trace cannot be written. What was written before stays, and the same command goes on from there.
    pub fn run(
        &self,
        folder: &Folder,
        threads: usize,
        traces: Option<&Path>,
        after: impl Fn() + Sync,
    ) -> Result<(), RunError> {
        let work = || -> Result<(), RunError> {
            let mut worker = Worker::default();
            while let Some(block) = folder.take() {
                let rows = self.run_block(&mut worker, block.point(), block.episode(), traces)?;
                folder.submit(block, &rows)?;
                after();
            }
            Ok(())
        };
        std::thread::scope(|scope| {
            let others: Vec<_> = (1..threads).map(|_| scope.spawn(work)).collect();
            let mut result = work();
            for other in others {
                let theirs = other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
                result = result.and(theirs);
            }
            result
        })
    }

    /// Drives every stack of a point through the world of one episode; each with its trace as a file in `traces` where given.
    ///
    /// # Errors
    /// If a trace cannot be written.
    pub fn run_block(
        &self,
        worker: &mut Worker,
        point: u32,
        episode: u64,
        traces: Option<&Path>,
    ) -> Result<Vec<(Row, Timing)>, RunError> {
        let clock = Stopwatch::start();
        let setup = &self.points[point as usize];
        let scene = self.scene(point, episode);
        let shortest_m = scene.as_ref().ok().and_then(|scene| setup.shortest_m(scene));
        let world_s = clock.elapsed_s();
        if worker.point != point {
            (worker.point, worker.stacks) = (point, Vec::new());
        }
        worker.stacks.resize_with(setup.stacks.len(), || None);
        let mut rows = Vec::with_capacity(setup.stacks.len());
        for (index, spec) in setup.stacks.iter().enumerate() {
            let Worker { runner, stacks, .. } = &mut *worker;
            rows.push(match &scene {
                Ok(scene) => {
                    let measured =
                        setup.drive(setup.seed(episode), scene, shortest_m, spec, &mut stacks[index], runner);
                    let row = self.row(point, spec, episode, measured);
                    if let Some(folder) = traces {
                        self.write_trace(folder, &row, scene, &runner.record.trace)?;
                    }
                    let timing = timing(world_s, &mut runner.record.timings);
                    (row, timing)
                }
                Err(infeasible) => {
                    let outcome = Outcome::InfeasibleWorld { message: infeasible.message.clone() };
                    let row = self.row(
                        point,
                        spec,
                        episode,
                        Measured { outcome, metrics: Metrics::default(), digests: None },
                    );
                    (row, Timing { world_s, ..Timing::default() })
                }
            });
        }
        Ok(rows)
    }

    /// Drives one stack of a point through one episode and keeps the scene and the trace.
    ///
    /// # Errors
    /// If the episode has no feasible world.
    pub fn drive_one(&self, point: u32, episode: u64, stack_index: usize) -> Result<Drive, Infeasible> {
        let scene = self.scene(point, episode)?;
        let mut runner = Runner::default();
        let setup = &self.points[point as usize];
        let spec = &setup.stacks[stack_index];
        let measured = setup.drive(setup.seed(episode), &scene, setup.shortest_m(&scene), spec, &mut None, &mut runner);
        let row = self.row(point, spec, episode, measured);
        Ok(Drive { scene, row, trace: runner.record.trace })
    }

    /// The world of one episode at a point.
    ///
    /// # Errors
    /// If none was found within the generator's bound.
    pub fn scene(&self, point: u32, episode: u64) -> Result<Scene, Infeasible> {
        let Setup { scenario, scene_spec, robot, fixed_map, .. } = &self.points[point as usize];
        let seed = self.points[point as usize].seed(episode);
        let map = match fixed_map {
            Some(map) => Arc::clone(map),
            None => {
                let grid = scenario.map.load(&self.base_dir, seed);
                Arc::new(StaticMap::new(grid.map_err(|error| Infeasible { message: error.to_string() })?))
            }
        };
        Scene::generate(scene_spec, &map, robot, seed)
    }

    fn row(&self, point: u32, spec: &StackSpec, episode: u64, measured: Measured) -> Row {
        let Measured { outcome, metrics, digests } = measured;
        Row {
            scenario: self.scenario.name.to_string(),
            point,
            stack: spec.name.clone(),
            global: spec.global.as_ref().map_or_else(String::new, |global| global.name().to_owned()),
            path: spec.path_name(),
            local: spec.local.name().to_owned(),
            episode,
            seed: self.scenario.seed,
            outcome,
            metrics,
            world_digest: digests.map(|(world, _)| world),
            trace_digest: digests.map(|(_, trace)| trace),
            swept: self.points[point as usize].values.clone(),
        }
    }

    /// Writes `e000017_a_star+dwa.csv`, with the point in front where there are several, and what a scanner measured
    /// to `e000017_a_star+dwa.lidar.csv`.
    fn write_trace(&self, folder: &Path, row: &Row, scene: &Scene, trace: &Trace) -> Result<(), RunError> {
        let point = if self.swept.is_empty() { String::new() } else { format!("p{:04}_", row.point) };
        let stem = format!("{point}e{:06}_{}", row.episode, row.stack);
        let write = |ending: &str, content: &dyn Fn(&mut io::BufWriter<std::fs::File>) -> io::Result<()>| {
            let path = folder.join(format!("{stem}{ending}"));
            let file = std::fs::File::create(&path);
            let written = file.and_then(|file| content(&mut io::BufWriter::new(file)));
            written.map_err(|source| RunError::Trace { path, source })
        };
        write(".csv", &|file| trace::write_csv(trace, scene.map.grid.frame(), DT_S, file))?;
        if trace.ray_count > 0 {
            write(".lidar.csv", &|file| trace::write_scans(trace, DT_S, file))?;
        }
        Ok(())
    }
}

/// What came of an episode; the digests are those of world and trace.
struct Measured {
    outcome: Outcome,
    metrics: Metrics,
    digests: Option<(Digest, Digest)>,
}

impl Setup {
    fn seed(&self, episode: u64) -> EpisodeSeed {
        EpisodeSeed { seed: self.scenario.seed, episode }
    }

    fn shortest_m(&self, scene: &Scene) -> Option<f64> {
        if !scene.has_a_fixed_task() {
            return None;
        }
        metrics::shortest_m(scene, self.robot.inscribed_radius_m(), self.scenario.termination.goal_tolerance_m.get())
    }

    fn drive(
        &self,
        seed: EpisodeSeed,
        scene: &Scene,
        shortest_m: Option<f64>,
        spec: &StackSpec,
        slot: &mut Option<Stack>,
        runner: &mut Runner,
    ) -> Measured {
        let scenario = &self.scenario;
        let conditions = Conditions {
            seed,
            sensing: scenario.sensing.clone(),
            localisation: scenario.localisation.clone(),
            actuation: scenario.actuation.clone(),
            ..Conditions::default()
        };
        let stack = slot.get_or_insert_with(|| spec.build(&scenario.planning));
        let outcome = runner.run(scene, &self.robot, &conditions, &scenario.termination, stack);
        if matches!(outcome, Outcome::PlannerError { .. }) {
            *slot = None;
        }
        let trace = &runner.record.trace;
        let measured = metrics::Episode {
            scene,
            robot: &self.robot,
            trace,
            success: outcome == Outcome::Success,
            goal_tolerance_m: scenario.termination.goal_tolerance_m.get(),
            dt_s: DT_S,
            shortest_m,
        };
        Measured {
            metrics: metrics::measure(measured, &scenario.metrics),
            digests: Some((Digest(scene.digest()), Digest(trace::digest(trace)))),
            outcome,
        }
    }
}

/// The times of one row.
fn timing(world_s: f64, timings: &mut Timings) -> Timing {
    let local_s = &mut timings.local_s;
    local_s.sort_unstable_by(f64::total_cmp);
    let quantile = |q: f64| {
        let last = local_s.len().saturating_sub(1);
        local_s.get((q * last as f64).round() as usize).copied().unwrap_or_default()
    };
    Timing {
        world_s: world_s + timings.world_s,
        global_s: timings.global_s,
        local_p50_s: quantile(0.5),
        local_p99_s: quantile(0.99),
        local_max_s: quantile(1.0),
        physics_s: timings.physics_s,
    }
}
