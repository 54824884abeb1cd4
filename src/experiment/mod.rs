//! An experiment: episodes × stacks as ordered work, in parallel.
//!
//! One block is one world, driven by every stack. A [`Session`] takes blocks from its journal in the order of the rows, drives
//! them on several threads and hands them back as they finish; the journal writes them in order. Nothing in a block depends on
//! another, so that any of them can be driven alone ([`Experiment::run_block`]).

mod drive;
mod pool;
mod session;

pub use drive::{Drive, Worker};
pub use pool::{in_order, on_threads, threads_available};
pub use session::Session;

use crate::map::MapError;
use crate::plan::stack::StackSpec;
use crate::results::{Identity, Order, Point, ResultsError};
use crate::rng::EpisodeSeed;
use crate::robot::Robot;
use crate::scenario::{Edit, Scenario, ScenarioError, ScenarioFile, SweepPoint};
use crate::settings::choice::NameError;
use crate::world::{SceneError, SceneSpec, StaticMap};
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
    /// The scenario is refused.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
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

    /// Reads, checks and prepares the scenario of a file with `edits` made to it.
    ///
    /// # Errors
    /// If the scenario is refused, or [`Self::new`] fails.
    pub fn load(file: &ScenarioFile, edits: &[Edit]) -> Result<Self, PrepareError> {
        let scenario = file.read(edits)?;
        let points = file.points(&scenario, edits)?;
        Self::new(scenario, points, file.folder())
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
    /// If no stack has one of the names.
    pub fn keep_stacks(&mut self, names: &[String]) -> Result<(), NameError> {
        let known = self.stack_names();
        if let Some(unknown) = names.iter().find(|name| !known.contains(name)) {
            return Err(NameError::unknown("stack", unknown, &known));
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
}

#[cfg(test)]
mod tests;
