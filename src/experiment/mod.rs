//! An experiment: episodes × stacks as ordered work, in parallel.
//!
//! One block is one world, driven by every stack. A [`Session`] takes blocks from its journal in the order of the rows, drives
//! them on several threads and hands them back as they finish; the journal writes them in order. Nothing in a block depends on
//! another, so that any of them can be driven alone ([`Experiment::run_block`]).

mod differences;
mod drive;
mod fault;
mod isolate;
mod pool;
mod session;

pub use drive::{Drive, Worker};
pub use fault::Phase;
pub use isolate::{Isolation, serve};
pub use pool::{in_order, on_threads, threads_available};
pub use session::{Session, Untraced};

use crate::command;
use crate::digest::Digest;
use crate::files;
use crate::guard::guard;
use crate::map::{MapError, OccupancyGrid};
use crate::plan::stack::StackSpec;
use crate::results::{self, Identity, Order, ResultsError, StackAt};
use crate::rng::EpisodeSeed;
use crate::robot::Robot;
use crate::scenario::{Edit, Scenario, ScenarioError, ScenarioFile, SweepPoint};
use crate::settings::choice::NameError;
use crate::world::{SceneError, SceneSpec, StaticMap};
use fault::Origin;
use std::collections::{BTreeMap, BTreeSet};
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
    /// FNV-1a hash of every file that the scenario names at any point.
    files: BTreeMap<String, String>,
    origin: Origin,
    /// Hash of the scenario with every default but the number of episodes, for traces.
    settings_hash: String,
    probe: Option<Probe>,
}

/// Called at the beginning of each part of a work item, with the number of the episode.
pub type Probe = fn(Phase, u64);

/// The stacks that run at one point of the sweep; a scenario without a sweep is one point.
#[derive(Debug)]
struct Setup {
    /// The values of the swept keys.
    values: Vec<String>,
    scenario: Scenario,
    /// The stacks that run here: those that no earlier point has run in the same way, unless they were left out.
    stacks: Vec<StackHere>,
    surroundings: Arc<Surroundings>,
}

/// A stack at a point.
#[derive(Debug)]
struct StackHere {
    spec: StackSpec,
    /// The values of the swept keys in its rows.
    values: Vec<String>,
}

/// Data shared by all points whose scenarios differ in their stacks alone.
#[derive(Debug)]
struct Surroundings {
    scene_spec: SceneSpec,
    robot: Robot,
    fixed_map: Option<Arc<StaticMap>>,
}

/// Reason why an experiment cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum PrepareError {
    /// The scenario is refused.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The fixed map cannot be loaded.
    #[error(transparent)]
    Map(#[from] MapError),
    /// A file that the scene needs cannot be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A file was written while it was being read.
    #[error("the file `{0}` was changed while it was being read: run again once it is whole")]
    Changed(String),
}

/// Reason why a run ended before its work was done.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The results could not be written.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// A child process cannot go on, or cannot begin.
    #[error("{message}")]
    Child {
        /// What happened.
        message: String,
    },
    /// A trace could not be written.
    #[error("cannot write the trace `{}`: {source}", path.display())]
    Trace {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// An episode that was driven again for its trace went otherwise than its row tells.
    #[error("point {point}, episode {episode}, {stack}: driven again, it has the trace digest {now}, its row {before}")]
    OtherDrive {
        /// Number of the point.
        point: u32,
        /// Number of the episode.
        episode: u64,
        /// Name of the stack.
        stack: String,
        /// Digest in the row.
        before: Digest,
        /// Digest of the drive.
        now: Digest,
    },
}

impl Surroundings {
    /// `maps` are the fixed maps that are loaded already, by the text of their specification.
    fn new(
        scenario: &Scenario,
        base_dir: &Path,
        maps: &mut BTreeMap<String, Arc<StaticMap>>,
    ) -> Result<Self, PrepareError> {
        let fixed_map = if scenario.map.is_fixed() {
            let text = serde_json::to_string(&scenario.map).expect("a map is specified by texts and finite numbers");
            Some(match maps.get(&text) {
                Some(map) => Arc::clone(map),
                None => {
                    let seed = EpisodeSeed { seed: scenario.seed, episode: 0 };
                    let map = Arc::new(StaticMap::new(scenario.map.load(base_dir, seed)?));
                    maps.insert(text, Arc::clone(&map));
                    map
                }
            })
        } else {
            None
        };
        let robot = Robot::new(&scenario.robot, &scenario.limits);
        Ok(Self { scene_spec: scenario.scene_spec(base_dir)?, robot, fixed_map })
    }
}

impl Experiment {
    /// Prepares a checked scenario, with the points of its sweep ([`ScenarioFile::points`](crate::scenario::ScenarioFile::points));
    /// files are looked up relative to `base_dir`.
    ///
    /// Every stack runs once at each of its own settings: at the first point that has them.
    ///
    /// # Errors
    /// If a fixed map or a recording cannot be loaded.
    ///
    /// # Panics
    /// If there is no point.
    pub fn new(scenario: Scenario, points: Vec<SweepPoint>, base_dir: &Path) -> Result<Self, PrepareError> {
        let files = digests(points.iter().map(|point| &point.scenario), base_dir);
        let mut maps = BTreeMap::new();
        let mut known: BTreeMap<usize, Arc<Surroundings>> = BTreeMap::new();
        let mut driven: BTreeSet<(usize, String)> = BTreeSet::new();
        let mut setups: Vec<Setup> = Vec::new();
        for point in points {
            let surroundings = match known.get(&point.surroundings) {
                Some(surroundings) => Arc::clone(surroundings),
                None => {
                    let surroundings = Arc::new(Surroundings::new(&point.scenario, base_dir, &mut maps)?);
                    known.insert(point.surroundings, Arc::clone(&surroundings));
                    surroundings
                }
            };
            let specs = point.scenario.stacks().into_iter().enumerate();
            // The text of a specification names every parameter of every planner, to the last bit.
            let new = specs.filter(|(_, spec)| driven.insert((point.surroundings, format!("{spec:?}"))));
            let stacks = new.map(|(index, spec)| StackHere { spec, values: point.values_of(index) }).collect();
            setups.push(Setup { stacks, surroundings, values: point.values, scenario: point.scenario });
        }
        assert!(!setups.is_empty(), "an experiment has at least one point");
        let origin = Origin { file: PathBuf::from(scenario.name.as_str()), edits: Vec::new() };
        let settings_hash = results::settings_hash(&scenario.to_yaml());
        // What was read is what the identity says, although others may write meanwhile.
        let now = digests(setups.iter().map(|setup| &setup.scenario), base_dir);
        if let Some((name, _)) = now.iter().find(|(name, digest)| files.get(*name) != Some(digest)) {
            return Err(PrepareError::Changed(name.clone()));
        }
        Ok(Self {
            swept: scenario.sweep.keys(),
            scenario,
            points: setups,
            base_dir: base_dir.to_owned(),
            files,
            origin,
            settings_hash,
            probe: None,
        })
    }

    /// Reads, checks and prepares the scenario of a file with `edits` made to it.
    ///
    /// # Errors
    /// If the scenario is refused, or [`Self::new`] fails.
    pub fn load(file: &ScenarioFile, edits: &[Edit]) -> Result<Self, PrepareError> {
        let scenario = file.read(edits)?;
        let points = file.points(&scenario, edits)?;
        let mut experiment = Self::new(scenario, points, file.folder())?;
        experiment.origin = Origin::new(file.path().to_owned(), edits);
        Ok(experiment)
    }

    /// Has `probe` called at the beginning of each part of every work item. For tests: it may panic, as any of them may.
    #[doc(hidden)]
    pub fn set_probe(&mut self, probe: Probe) {
        self.probe = Some(probe);
    }

    /// The command that drives one stack through one episode as this run does, with the file named as it was when this was loaded.
    pub fn replay_command(&self, point: u32, episode: u64, stack: &str) -> String {
        self.replay(&self.origin.file.display().to_string(), point, episode, stack)
    }

    /// The same from the scenario's own folder, which is the same text for everybody who runs it.
    fn replay_in_folder(&self, point: u32, episode: u64, stack: &str) -> String {
        let name = self.origin.file.file_name().unwrap_or_default();
        self.replay(&name.to_string_lossy(), point, episode, stack)
    }

    fn replay(&self, file: &str, point: u32, episode: u64, stack: &str) -> String {
        let mut words = format!("simrun run {}", command::quoted(file));
        if !self.swept.is_empty() {
            words += &format!(" --point {point}");
        }
        words += &format!(" --episode {episode} --stack {} --seed {}", command::quoted(stack), self.scenario.seed);
        // The seed has an option of its own.
        let is_told = |edit: &&String| !edit.starts_with("seed=");
        for edit in self.origin.edits.iter().filter(is_told) {
            words += &format!(" --set {}", command::quoted(edit));
        }
        words
    }

    /// What the file of the scenario's map says that was not used, or should be looked at, in words.
    pub fn map_notes(&self) -> Vec<String> {
        self.scenario.map.notes(&self.base_dir)
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
        &self.points[point as usize].surroundings.robot
    }

    /// The map of every episode at a point, if they all have the same.
    pub fn fixed_map(&self, point: u32) -> Option<&OccupancyGrid> {
        self.points[point as usize].surroundings.fixed_map.as_ref().map(|map| &*map.grid)
    }

    /// The keys that are swept.
    pub fn swept(&self) -> &[String] {
        &self.swept
    }

    /// The value of each swept key at a point.
    pub fn values(&self, point: u32) -> &[String] {
        &self.points[point as usize].values
    }

    /// Whether the episodes of a point are copies of one another because nothing in it is random: the worlds of the first two are the same,
    /// and so is all that the first stack does in them.
    pub fn repeats(&self, point: u32) -> bool {
        // What panics is found out by the run, and no copy of anything.
        let digest = |episode: u64| guard(|| self.scene(point, episode).ok().map(|scene| scene.digest())).ok();
        if self.scenario_at(point).episodes.get() < 2 || self.stacks(point).len() == 0 || digest(0) != digest(1) {
            return false;
        }
        let trace = |episode: u64| {
            guard(|| self.drive_one(point, episode, 0)).ok()?.ok().and_then(|drive| drive.row.trace_digest)
        };
        trace(0).is_some() && trace(0) == trace(1)
    }

    /// Settings in which the stacks of a point differ beside their planners, one sentence each.
    pub fn differences(&self, point: u32) -> Vec<String> {
        differences::differences(self.stacks(point), &self.scenario_at(point).planning)
    }

    /// The stacks that run at a point, in the order of their rows; empty if each has run in the same way at an earlier point.
    pub fn stacks(&self, point: u32) -> impl ExactSizeIterator<Item = &StackSpec> {
        self.points[point as usize].stacks.iter().map(|stack| &stack.spec)
    }

    /// The names of all stacks, in the order in which they first appear.
    pub fn stack_names(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        let mut known = BTreeSet::new();
        for StackHere { spec, .. } in self.points.iter().flat_map(|point| &point.stacks) {
            if known.insert(&spec.name) {
                names.push(spec.name.clone());
            }
        }
        names
    }

    /// Keeps only the stacks of these names, in the scenario's order. Points keep their numbers, also those at which none of
    /// them runs.
    ///
    /// # Errors
    /// If no stack has one of the names.
    pub fn keep_stacks(&mut self, names: &[String]) -> Result<(), NameError> {
        let known = self.stack_names();
        if let Some(unknown) = names.iter().find(|name| !known.contains(name)) {
            return Err(NameError::unknown("stack", unknown, &known));
        }
        for point in &mut self.points {
            point.stacks.retain(|stack| names.contains(&stack.spec.name));
        }
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
        let stack = |stack: &StackHere| StackAt { name: stack.spec.name.clone(), values: stack.values.clone() };
        let points = self.points.iter().map(|point| point.stacks.iter().map(stack).collect());
        Order::new(self.swept.clone(), points.collect(), u64::from(self.scenario.episodes.get()))
    }

    /// Identity of a run of this experiment: runs with the same identity have the same rows.
    pub fn identity(&self) -> Identity {
        Identity::new(&self.scenario.to_yaml(), self.scenario.seed, self.stack_names(), self.files.clone())
    }
}

/// The FNV-1a hash of every file that the scenarios name, by its name there. One that cannot be read is left out: loading it says why.
fn digests<'a>(scenarios: impl Iterator<Item = &'a Scenario>, folder: &Path) -> BTreeMap<String, String> {
    let names: BTreeSet<PathBuf> = scenarios.flat_map(|scenario| scenario.files(folder)).collect();
    let digest = |name: &PathBuf| files::digest(&folder.join(name)).ok();
    names.iter().filter_map(|name| Some((name.display().to_string(), digest(name)?.to_string()))).collect()
}

#[cfg(test)]
mod tests;
