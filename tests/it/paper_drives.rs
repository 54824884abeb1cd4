//! Drives through the papers' scenarios whose local planner is a witness, for tests of recorded decisions.

use super::support::root;
use simrun::digest::{Digest, Fnv1a};
use simrun::episode::{Runner, Setting};
use simrun::experiment::Experiment;
use simrun::plan::contract::LocalPlanner;
use simrun::plan::stack::{Stack, StackSpec};
use simrun::rng::EpisodeSeed;
use simrun::scenario::{Edit, ScenarioFile};
use simrun::world::Conditions;
use std::fs;
use std::path::PathBuf;

/// A file of the tests' data.
pub fn data(name: &str) -> PathBuf {
    root().join("tests/data").join(name)
}

/// A paper's scenario with changes.
pub fn experiment(scenario: &str, changes: &[&str]) -> Experiment {
    let file = ScenarioFile::open(root().join(format!("scenarios/papers/{scenario}.yaml"))).unwrap();
    let edits: Vec<Edit> = changes.iter().map(|change| Edit::parse(change).unwrap()).collect();
    Experiment::load(&file, &edits).unwrap()
}

/// Drives an episode through a stack with `local` in the place of its local planner; `false` where there is no world.
pub fn drive(experiment: &Experiment, episode: u64, spec: &StackSpec, local: Box<dyn LocalPlanner>) -> bool {
    let Ok(scene) = experiment.scene(0, episode) else { return false };
    let scenario = experiment.scenario();
    let conditions = Conditions {
        seed: EpisodeSeed { seed: scenario.seed, episode },
        sensing: scenario.sensing.clone(),
        localisation: scenario.localisation.clone(),
        actuation: scenario.actuation.clone(),
        control_period_s: scenario.control_period_s,
    };
    let (robot, termination) = (experiment.robot(0), &scenario.termination);
    let setting = Setting { scene: &scene, robot, conditions: &conditions, termination, way_m: None };
    let global = spec.global.as_ref().map(|global| global.build());
    let stages = spec.path.iter().map(|stage| stage.build()).collect();
    let mut stack = Stack::new(global, stages, local).with_planning(&scenario.planning);
    Runner::default().run(setting, &mut stack);
    true
}

/// The rows of a second implementation's answers to the file `first`; its first line must bear the digest of that file.
pub fn answers_to(first: &str, second: &str, oracle: &str) -> String {
    let mut hash = Fnv1a::default();
    hash.bytes(&fs::read(data(first)).unwrap());
    let digest = Digest(hash.value()).to_string();
    let text = fs::read_to_string(data(second)).unwrap();
    let (origin, rows) = text.split_once('\n').unwrap();
    assert!(origin.ends_with(&digest), "{origin}, but it is {digest}: run python3 tests/oracles/{oracle}");
    rows.to_owned()
}
