//! Driving: the stacks of a point through the world of one episode.

use super::fault::{Fault, Phase, guarded};
use super::{Experiment, RunError, Setup, StackHere, Surroundings};
use crate::clock::Stopwatch;
use crate::episode::{Outcome, Record, Recording, Runner, Setting, Timings, watch};
use crate::geometry::Vec2;
use crate::guard::guard;
use crate::metrics::failure::Cause;
use crate::metrics::{self, Metrics, StateTime};
use crate::plan::PlanningGrid;
use crate::plan::contract::Problem;
use crate::plan::global::GlobalChoice;
use crate::plan::stack::{Stack, StackSpec};
use crate::results::{self, Answer, Digest, Row, Timing};
use crate::rng::EpisodeSeed;
use crate::trace::{self, Detail, Header, Trace};
use crate::world::{Conditions, Infeasible, Scene, StaticMap};
use std::io;
use std::path::Path;
use std::sync::Arc;

/// Buffers that one thread reuses from block to block. No result depends on them.
#[derive(Debug, Default)]
pub struct Worker {
    runner: Runner,
    point: u32,
    stacks: Vec<Option<Stack>>,
}

/// One episode with everything that a picture or a trace file needs.
#[derive(Debug)]
pub struct Drive {
    /// The row of `episodes.csv`.
    pub row: Row,
    /// World, robot and drive.
    pub recording: Recording,
}

impl Drive {
    /// What led to its failure; `None` for a success.
    pub fn cause(&self) -> Option<Cause> {
        let Recording { scene, robot, outcome, trace, dt_s, .. } = &self.recording;
        metrics::failure::cause(scene, robot.radius_m, outcome, trace, *dt_s)
    }
}

impl Worker {
    /// The worker at a point, whose stacks it builds anew when the point is another.
    fn at(&mut self, point: u32, setup: &Setup) -> &mut Self {
        if self.point != point {
            self.point = point;
            self.drop_stacks();
        }
        self.stacks.resize_with(setup.stacks.len(), || None);
        self
    }

    /// Throws away whatever a panic may have left half done.
    fn renew(&mut self) {
        self.runner = Runner::default();
        self.drop_stacks();
    }

    /// A planner's panic as it is dropped costs no row: all of them are made.
    fn drop_stacks(&mut self) {
        for stack in self.stacks.drain(..) {
            let _ = guard(|| drop(stack));
        }
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.drop_stacks();
    }
}

impl Experiment {
    /// Drives every stack of a point through the world of one episode; writes the trace of each to the folder `traces` if given.
    ///
    /// A panic anywhere in it is a row: `planner_error` where a planner ran, else `internal_error`.
    ///
    /// # Errors
    /// If a trace cannot be written.
    pub fn run_block(
        &self,
        worker: &mut Worker,
        point: u32,
        episode: u64,
        traces: Option<&Path>,
    ) -> Result<Vec<Answer>, RunError> {
        let mut answers = Vec::with_capacity(self.stacks(point).len());
        self.drive_block(worker, (point, episode, 0), traces, |answer| {
            answers.extend(answer);
            true
        })?;
        Ok(answers)
    }

    /// Drives the stacks of a block, (point, episode), from the stack `from` on. Hands each answer to `each`, and `None` as soon as the
    /// world is there; ends when that says no.
    pub(super) fn drive_block(
        &self,
        worker: &mut Worker,
        (point, episode, from): (u32, u64, usize),
        traces: Option<&Path>,
        mut each: impl FnMut(Option<Answer>) -> bool,
    ) -> Result<(), RunError> {
        let clock = Stopwatch::start();
        let setup = &self.points[point as usize];
        let world = guarded(Phase::WorldGeneration, || self.world(point, episode));
        let world_s = clock.elapsed_s();
        if !each(None) {
            return Ok(());
        }
        for index in from..setup.stacks.len() {
            let at = (point, episode, index);
            let mut answer = match &world {
                Ok(Ok(world)) => {
                    let driven =
                        self.answer(worker.at(point, setup), index, world, episode).and_then(|(row, states)| {
                            let timing = timing(&mut worker.runner.record.timings);
                            let answer = Answer { row, states, timing };
                            let written =
                                guarded(Phase::Encoding, || self.write(&answer, traces, &world.scene, worker))?;
                            Ok(written.map(|()| answer))
                        });
                    match driven {
                        Ok(answer) => answer?,
                        Err(fault) => {
                            worker.renew();
                            self.faulty(&fault, at, Some(world.digest))
                        }
                    }
                }
                Ok(Err(infeasible)) => {
                    self.undriven(Outcome::InfeasibleWorld { message: infeasible.message.clone() }, at, None)
                }
                Err(fault) => self.faulty(fault, at, None),
            };
            answer.timing.world_s += world_s;
            if !each(Some(answer)) {
                return Ok(());
            }
        }
        Ok(())
    }

    /// The answer for a stack, (point, episode, its number), that has not been driven to an end.
    pub(super) fn undriven(
        &self,
        outcome: Outcome,
        (point, episode, stack): (u32, u64, usize),
        world: Option<Digest>,
    ) -> Answer {
        let measured = Measured { outcome, metrics: Metrics::default(), world, trace: None };
        let row = self.row(point, &self.points[point as usize].stacks[stack], episode, measured);
        Answer { row, states: Vec::new(), timing: Timing::default() }
    }

    /// The answer for a stack, (point, episode, its number), that a fault of simrun has cost.
    pub(super) fn faulty(&self, fault: &Fault, at: (u32, u64, usize), world: Option<Digest>) -> Answer {
        let (point, episode, stack) = at;
        let name = &self.points[point as usize].stacks[stack].spec.name;
        let message = format!("{fault}; replay: {}", self.replay_in_folder(point, episode, name));
        self.undriven(Outcome::InternalError { message }, at, world)
    }

    /// Drives one stack of a point through one episode and records it in full.
    ///
    /// # Errors
    /// If the episode has no feasible world.
    ///
    /// # Panics
    /// If the world or the row of a drive cannot be made because of a fault of simrun itself.
    pub fn drive_one(&self, point: u32, episode: u64, stack_index: usize) -> Result<Drive, Infeasible> {
        let world = self.world(point, episode)?;
        let mut worker = Worker::default();
        worker.runner = Runner::in_full();
        let setup = &self.points[point as usize];
        let answered = self.answer(worker.at(point, setup), stack_index, &world, episode);
        let (row, _) = answered.unwrap_or_else(|fault| panic!("{fault}"));
        let Record { trace, detail, .. } = core::mem::take(&mut worker.runner.record);
        let (outcome, detail) = (row.outcome.clone(), detail.unwrap_or_default());
        let recording = Recording { outcome, trace, detail, ..setup.unrecorded(world.scene) };
        Ok(Drive { row, recording })
    }

    /// The world of one episode at a point without a drive: for `lasts_s` seconds its movers go their ways as if no robot were
    /// there. For pictures of worlds.
    ///
    /// # Errors
    /// If the episode has no feasible world.
    pub fn watch_one(&self, point: u32, episode: u64, lasts_s: f64) -> Result<Recording, Infeasible> {
        let scene = self.scene(point, episode)?;
        let setup = &self.points[point as usize];
        let recording = setup.unrecorded(scene);
        let ticks = (lasts_s / setup.dt_s()).round() as u32;
        let trace = watch(&recording.scene, &recording.robot, &setup.conditions(setup.seed(episode)), ticks);
        Ok(Recording { trace, ..recording })
    }

    /// Drives a stack through a world and measures what came of it.
    fn answer(
        &self,
        worker: &mut Worker,
        index: usize,
        world: &Drawn,
        episode: u64,
    ) -> Result<(Row, Vec<StateTime>), Fault> {
        let point = worker.point;
        let setup = &self.points[point as usize];
        let here = &setup.stacks[index];
        let Worker { runner, stacks, .. } = worker;
        let outcome = guarded(Phase::Drive, || {
            self.enter(Phase::Drive, episode);
            setup.drive(setup.seed(episode), world, &here.spec, &mut stacks[index], runner)
        })?;
        if let Outcome::InternalError { message } = outcome {
            return Err(Fault { phase: Phase::Drive, message });
        }
        guarded(Phase::Metrics, || {
            self.enter(Phase::Metrics, episode);
            let trace = &runner.record.trace;
            let measured = setup.measure(world, trace, outcome);
            (self.row(point, here, episode, measured), metrics::states(trace, setup.dt_s()))
        })
    }

    /// Tries whether an answer can be written, and writes its trace if it is asked for.
    fn write(&self, answer: &Answer, traces: Option<&Path>, scene: &Scene, worker: &Worker) -> Result<(), RunError> {
        self.enter(Phase::Encoding, answer.row.episode);
        answer.assert_writable();
        match traces {
            Some(folder) => self.write_trace(folder, &answer.row, scene, &worker.runner.record.trace),
            None => Ok(()),
        }
    }

    fn enter(&self, phase: Phase, episode: u64) {
        if let Some(probe) = self.probe {
            probe(phase, episode);
        }
    }

    /// The world of one episode at a point, with what all its stacks share.
    fn world(&self, point: u32, episode: u64) -> Result<Drawn, Infeasible> {
        self.enter(Phase::WorldGeneration, episode);
        let scene = self.scene(point, episode)?;
        let ways = self.points[point as usize].ways(&scene);
        Ok(Drawn { ways, digest: Digest(scene.digest()), scene })
    }

    /// Drives the episode of a row again, and records it in full; `None` if there is no such stack at such a point, or no world.
    pub fn drive_again(&self, row: &Row) -> Option<Drive> {
        if row.point >= self.points() {
            return None;
        }
        let stack_index = self.stacks(row.point).position(|stack| stack.name == row.stack)?;
        self.drive_one(row.point, row.episode, stack_index).ok()
    }

    /// The world of one episode at a point.
    ///
    /// # Errors
    /// If no feasible world was found within the generator's bound.
    pub fn scene(&self, point: u32, episode: u64) -> Result<Scene, Infeasible> {
        let setup = &self.points[point as usize];
        let (scenario, seed) = (&setup.scenario, setup.seed(episode));
        let Surroundings { scene_spec, robot, fixed_map } = &*setup.surroundings;
        let map = match fixed_map {
            Some(map) => Arc::clone(map),
            None => {
                let grid = scenario.map.load(&self.base_dir, seed);
                Arc::new(StaticMap::new(grid.map_err(|error| Infeasible { message: error.to_string() })?))
            }
        };
        Scene::generate(scene_spec, &map, robot, seed)
    }

    fn row(&self, point: u32, here: &StackHere, episode: u64, measured: Measured) -> Row {
        let StackHere { spec, values } = here;
        let Measured { outcome, metrics, world, trace } = measured;
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
            world_digest: world,
            trace_digest: trace,
            swept: values.clone(),
        }
    }

    /// Name of the trace of a row without its ending, as in `e000017_a_star+dwa`; in a sweep it begins with the point, as in `p0003_`.
    fn trace_stem(&self, row: &Row) -> String {
        let point = if self.swept.is_empty() { String::new() } else { format!("p{:04}_", row.point) };
        format!("{point}e{:06}_{}", row.episode, row.stack)
    }

    /// The header of the trace of a row.
    pub fn trace_header(&self, row: &Row) -> Header {
        Header {
            scenario: self.origin.file.display().to_string(),
            edits: self.origin.edits.clone(),
            seed: row.seed,
            point: row.point,
            episode: row.episode,
            stack: row.stack.clone(),
            build: results::BUILD.to_owned(),
            settings_hash: self.settings_hash.clone(),
            trace_digest: row.trace_digest.map_or_else(String::new, |digest| digest.to_string()),
        }
    }

    /// Whether a folder holds the trace of a row. Traces are put in place as a whole, and the table behind its scans.
    pub(super) fn has_trace(&self, folder: &Path, row: &Row) -> bool {
        let there = Header::read(&folder.join(self.trace_stem(row) + ".csv"));
        there.is_ok_and(|there| there.is_some_and(|there| there.is_same_drive(&self.trace_header(row))))
    }

    /// Takes the trace of a row out of a folder again.
    pub(super) fn remove_trace(&self, folder: &Path, row: &Row) {
        let stem = self.trace_stem(row);
        for ending in [".csv", ".lidar.csv"] {
            let _ = std::fs::remove_file(folder.join(format!("{stem}{ending}")));
        }
    }

    /// Writes `e000017_a_star+dwa.csv`, and before it the scans to `e000017_a_star+dwa.lidar.csv`.
    fn write_trace(&self, folder: &Path, row: &Row, scene: &Scene, trace: &Trace) -> Result<(), RunError> {
        let stem = self.trace_stem(row);
        let header = self.trace_header(row);
        let dt_s = self.points[row.point as usize].dt_s();
        let write = |ending: &str, content: &dyn Fn(&mut Vec<u8>) -> io::Result<()>| {
            let mut bytes = header.to_string().into_bytes();
            let path = folder.join(format!("{stem}{ending}"));
            let written = content(&mut bytes).and_then(|()| results::put(&path, &bytes));
            written.map_err(|source| RunError::Trace { path, source })
        };
        if trace.ray_count > 0 {
            write(".lidar.csv", &|bytes| trace::write_scans(trace, dt_s, bytes))?;
        }
        write(".csv", &|bytes| trace::write_csv(trace, scene.map.grid.frame(), dt_s, bytes))
    }
}

/// Shortest ways of one world.
#[derive(Clone, Copy, Debug, Default)]
struct Ways {
    /// The column `shortest_m`.
    shortest_m: Option<f64>,
    /// The way by which the time-out goes; `None` where that is given.
    way_m: Option<f64>,
}

/// Length of the grid's shortest way on the known map from the start to the goal, and on to each goal of the script, m; a straight
/// line where there is no way.
fn grid_way_m(scene: &Scene) -> f64 {
    let (map, grid) = (&scene.map.grid, PlanningGrid::new(&scene.map.grid, &scene.map.field, 0.0));
    let mut planner = GlobalChoice::by_name("a_star").expect("it is in the registry").build();
    let mut cells = Vec::new();
    let mut leg_m = |from: Vec2, to: Vec2| {
        let problem = Problem { grid: &grid, start: grid.cell_at(from), goal: grid.cell_at(to) };
        let is_found = planner.as_grid().is_some_and(|planner| planner.search(&problem, &mut cells).result.is_ok());
        if !is_found {
            return (to - from).norm();
        }
        cells.windows(2).map(|pair| (map.centre(pair[1]) - map.centre(pair[0])).norm()).sum()
    };
    let later = scene.script.iter().filter_map(|event| event.change.goal_moved_to());
    let (mut at, mut way_m) = (scene.start.position, 0.0);
    for goal in core::iter::once(scene.goal).chain(later) {
        way_m += leg_m(at, goal);
        at = goal;
    }
    way_m
}

/// The world of a block, with what its stacks share.
struct Drawn {
    scene: Scene,
    ways: Ways,
    digest: Digest,
}

/// Result of an episode, with the digests of world and trace.
struct Measured {
    outcome: Outcome,
    metrics: Metrics,
    world: Option<Digest>,
    trace: Option<Digest>,
}

impl Setup {
    /// Control period, s.
    fn dt_s(&self) -> f64 {
        self.scenario.control_period_s.get()
    }

    fn seed(&self, episode: u64) -> EpisodeSeed {
        EpisodeSeed { seed: self.scenario.seed, episode }
    }

    fn shortest_m(&self, scene: &Scene) -> Option<f64> {
        if !scene.has_a_fixed_task() {
            return None;
        }
        metrics::shortest_m(
            scene,
            self.surroundings.robot.inscribed_radius_m(),
            self.scenario.termination.goal_tolerance_m.get(),
        )
    }

    /// The shortest ways of a world, which are the same for all stacks.
    fn ways(&self, scene: &Scene) -> Ways {
        let shortest_m = self.shortest_m(scene);
        let is_timed = self.scenario.termination.timeout_s.is_none();
        let way_m = if is_timed { shortest_m.or_else(|| Some(grid_way_m(scene))) } else { None };
        Ways { shortest_m, way_m }
    }

    fn conditions(&self, seed: EpisodeSeed) -> Conditions {
        let scenario = &self.scenario;
        Conditions {
            seed,
            sensing: scenario.sensing.clone(),
            localisation: scenario.localisation.clone(),
            actuation: scenario.actuation.clone(),
            control_period_s: scenario.control_period_s,
        }
    }

    /// A recording of the scene before anything has happened.
    fn unrecorded(&self, scene: Scene) -> Recording {
        Recording {
            scene,
            robot: self.surroundings.robot.clone(),
            dt_s: self.dt_s(),
            goal_tolerance_m: self.scenario.termination.goal_tolerance_m.get(),
            sensing: self.scenario.sensing.clone(),
            outcome: Outcome::Timeout,
            trace: Trace::default(),
            detail: Detail::default(),
        }
    }

    fn drive(
        &self,
        seed: EpisodeSeed,
        world: &Drawn,
        spec: &StackSpec,
        slot: &mut Option<Stack>,
        runner: &mut Runner,
    ) -> Outcome {
        let scenario = &self.scenario;
        let conditions = self.conditions(seed);
        let stack = slot.get_or_insert_with(|| spec.build(&scenario.planning));
        let (robot, termination, way_m) = (&self.surroundings.robot, &scenario.termination, world.ways.way_m);
        let setting = Setting { scene: &world.scene, robot, conditions: &conditions, termination, way_m };
        let outcome = runner.run(setting, stack);
        if outcome.is_crash() {
            let broken = slot.take();
            let _ = guard(|| drop(broken));
        }
        outcome
    }

    fn measure(&self, world: &Drawn, trace: &Trace, outcome: Outcome) -> Measured {
        let measured = metrics::Episode {
            scene: &world.scene,
            robot: &self.surroundings.robot,
            trace,
            success: outcome == Outcome::Success,
            goal_tolerance_m: self.scenario.termination.goal_tolerance_m.get(),
            dt_s: self.dt_s(),
            shortest_m: world.ways.shortest_m,
        };
        Measured {
            metrics: metrics::measure(measured, &self.scenario.metrics),
            world: Some(world.digest),
            trace: Some(Digest(trace::digest(trace))),
            outcome,
        }
    }
}

/// The times of one row.
fn timing(timings: &mut Timings) -> Timing {
    let local_s = &mut timings.local_s;
    local_s.sort_unstable_by(f64::total_cmp);
    let quantile = |q: f64| {
        let last = local_s.len().saturating_sub(1);
        local_s.get((q * last as f64).round() as usize).copied().unwrap_or_default()
    };
    Timing {
        world_s: timings.world_s,
        global_s: timings.global_s,
        local_p50_s: quantile(0.5),
        local_p99_s: quantile(0.99),
        local_max_s: quantile(1.0),
        physics_s: timings.physics_s,
    }
}
