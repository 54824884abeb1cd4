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
use crate::scenario::Scenario;
use crate::trace::{self, Trace};
use crate::world::spec::SceneSpec;
use crate::world::{Infeasible, Scene, SceneError, StaticMap};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scenario ready to run: checked, its fixed map loaded once for all episodes.
#[derive(Debug)]
pub struct Experiment {
    scenario: Scenario,
    stacks: Vec<StackSpec>,
    scene_spec: SceneSpec,
    robot: Robot,
    base_dir: PathBuf,
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

impl Experiment {
    /// Prepares a checked scenario; files are looked up relative to `base_dir`.
    ///
    /// # Errors
    /// If a fixed map or a recording cannot be loaded.
    pub fn new(scenario: Scenario, base_dir: &Path) -> Result<Self, PrepareError> {
        let fixed_map = if scenario.map.is_fixed() {
            let seed = EpisodeSeed { seed: scenario.seed, episode: 0 };
            Some(Arc::new(StaticMap::new(scenario.map.load(base_dir, seed)?)))
        } else {
            None
        };
        let scene_spec = scenario.scene_spec(base_dir)?;
        Ok(Self {
            stacks: scenario.stacks(),
            scene_spec,
            robot: Robot::new(&scenario.robot, &scenario.limits),
            base_dir: base_dir.to_owned(),
            fixed_map,
            scenario,
        })
    }

    /// The scenario that runs.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// The robot that is driven.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The stacks in the order of their rows.
    pub fn stacks(&self) -> &[StackSpec] {
        &self.stacks
    }

    /// Keeps only the stacks of these names, in the scenario's order.
    ///
    /// # Errors
    /// The name that no stack has.
    pub fn keep_stacks<'n>(&mut self, names: &'n [String]) -> Result<(), &'n str> {
        if let Some(unknown) = names.iter().find(|name| self.stacks.iter().all(|stack| stack.name != **name)) {
            return Err(unknown);
        }
        self.stacks.retain(|stack| names.contains(&stack.name));
        Ok(())
    }

    /// The order of the rows: every stack of every episode.
    ///
    /// # Panics
    /// If every stack was left out.
    pub fn order(&self) -> Order {
        let stacks = self.stacks.iter().map(|stack| stack.name.clone()).collect();
        Order::new(Vec::new(), vec![Point { values: Vec::new(), stacks }], u64::from(self.scenario.episodes.get()))
            .expect("no key is swept")
    }

    /// What makes a run of this experiment the same run as another.
    ///
    /// # Errors
    /// If the program cannot read its own file.
    pub fn identity(&self) -> Result<Identity, ResultsError> {
        let stacks = self.stacks.iter().map(|stack| stack.name.clone()).collect();
        Identity::new(&self.scenario.to_yaml(), self.scenario.seed, stacks)
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
                let rows = self.run_block(&mut worker, block.episode(), traces)?;
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

    /// Drives every stack through the world of one episode; each with its trace as a file in `traces` where given.
    ///
    /// # Errors
    /// If a trace cannot be written.
    pub fn run_block(
        &self,
        worker: &mut Worker,
        episode: u64,
        traces: Option<&Path>,
    ) -> Result<Vec<(Row, Timing)>, RunError> {
        let clock = Stopwatch::start();
        let scene = self.scene(episode);
        let shortest_m = scene.as_ref().ok().and_then(|scene| self.shortest_m(scene));
        let world_s = clock.elapsed_s();
        worker.stacks.resize_with(self.stacks.len(), || None);
        let mut rows = Vec::with_capacity(self.stacks.len());
        for (index, spec) in self.stacks.iter().enumerate() {
            let Worker { runner, stacks } = &mut *worker;
            rows.push(match &scene {
                Ok(scene) => {
                    let row = self.drive(scene, shortest_m, spec, &mut stacks[index], runner, episode);
                    if let Some(folder) = traces {
                        write_trace(folder, &row, scene, &runner.record.trace)?;
                    }
                    let timing = timing(world_s, &mut runner.record.timings);
                    (row, timing)
                }
                Err(infeasible) => {
                    let outcome = Outcome::InfeasibleWorld { message: infeasible.message.clone() };
                    (self.row(spec, episode, outcome), Timing { world_s, ..Timing::default() })
                }
            });
        }
        Ok(rows)
    }

    /// Drives one stack through one episode and keeps the scene and the trace.
    ///
    /// # Errors
    /// If the episode has no feasible world.
    pub fn drive_one(&self, episode: u64, stack_index: usize) -> Result<Drive, Infeasible> {
        let scene = self.scene(episode)?;
        let mut runner = Runner::default();
        let spec = &self.stacks[stack_index];
        let row = self.drive(&scene, self.shortest_m(&scene), spec, &mut None, &mut runner, episode);
        Ok(Drive { scene, row, trace: runner.record.trace })
    }

    /// The world of one episode.
    ///
    /// # Errors
    /// If none was found within the generator's bound.
    pub fn scene(&self, episode: u64) -> Result<Scene, Infeasible> {
        let seed = EpisodeSeed { seed: self.scenario.seed, episode };
        let map = match &self.fixed_map {
            Some(map) => Arc::clone(map),
            None => {
                let grid = self.scenario.map.load(&self.base_dir, seed);
                Arc::new(StaticMap::new(grid.map_err(|error| Infeasible { message: error.to_string() })?))
            }
        };
        let inflation_m = self.scenario.planning.inflation_m(self.robot.radius_m);
        Scene::generate(&self.scene_spec, &map, &self.robot, inflation_m, seed)
    }

    fn shortest_m(&self, scene: &Scene) -> Option<f64> {
        metrics::shortest_m(scene, self.robot.radius_m, self.scenario.termination.goal_tolerance_m.get())
    }

    fn drive(
        &self,
        scene: &Scene,
        shortest_m: Option<f64>,
        spec: &StackSpec,
        slot: &mut Option<Stack>,
        runner: &mut Runner,
        episode: u64,
    ) -> Row {
        let scenario = &self.scenario;
        let stack = slot.get_or_insert_with(|| spec.build(&scenario.planning));
        let outcome = runner.run(scene, &self.robot, &scenario.sensing, &scenario.termination, stack);
        if matches!(outcome, Outcome::PlannerError { .. }) {
            *slot = None;
        }
        let measured = metrics::Episode {
            scene,
            robot: &self.robot,
            trace: &runner.record.trace,
            success: outcome == Outcome::Success,
            goal_tolerance_m: scenario.termination.goal_tolerance_m.get(),
            dt_s: DT_S,
            shortest_m,
        };
        Row {
            metrics: metrics::measure(measured, &scenario.metrics),
            world_digest: Some(Digest(scene.digest())),
            trace_digest: Some(Digest(trace::digest(&runner.record.trace))),
            ..self.row(spec, episode, outcome)
        }
    }

    /// The row of an episode in which nothing was measured.
    fn row(&self, spec: &StackSpec, episode: u64, outcome: Outcome) -> Row {
        Row {
            scenario: self.scenario.name.to_string(),
            point: 0,
            stack: spec.name.clone(),
            global: spec.global.as_ref().map_or_else(String::new, |global| global.name().to_owned()),
            path: spec.path_name(),
            local: spec.local.name().to_owned(),
            episode,
            seed: self.scenario.seed,
            outcome,
            metrics: Metrics::default(),
            world_digest: None,
            trace_digest: None,
            swept: Vec::new(),
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

/// Writes `e000017_a_star+dwa.csv`.
fn write_trace(folder: &Path, row: &Row, scene: &Scene, trace: &Trace) -> Result<(), RunError> {
    let path = folder.join(format!("e{:06}_{}.csv", row.episode, row.stack));
    let write = || -> io::Result<()> {
        let mut file = io::BufWriter::new(std::fs::File::create(&path)?);
        trace::write_csv(trace, scene.map.grid.frame(), DT_S, &mut file)?;
        io::Write::flush(&mut file)
    };
    write().map_err(|source| RunError::Trace { path: path.clone(), source })
}
