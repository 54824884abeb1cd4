//! The arguments that name a scenario and change it, shared by the subcommands.

use super::Failure;
use super::isolated::Isolate;
use super::memory::MemoryLimit;
use crate::experiment::{Experiment, PrepareError};
use crate::results::Manifest;
use crate::scenario::{Edit, ScenarioFile};
use std::path::{Path, PathBuf};

/// Changes to a scenario.
#[derive(Clone, Debug, Default, PartialEq, clap::Args)]
pub(super) struct Changes {
    /// Set a key of the scenario, for example --set limits.speed_max_mps=1.5 (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Number of episodes.
    #[arg(long, value_name = "N")]
    episodes: Option<u32>,
    /// Seed of all randomness.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Only this stack, by its name in the results (repeatable).
    #[arg(long = "stack", value_name = "NAME")]
    stacks: Vec<String>,
    #[command(flatten)]
    memory: MemoryLimit,
}

impl Changes {
    /// The edits `set`, and one stack alone.
    pub(super) fn of_one_stack(set: Vec<String>, stack: String) -> Self {
        Self { set, stacks: vec![stack], ..Self::default() }
    }

    /// The same with only these stacks.
    pub(super) fn with_stacks(self, names: &[String]) -> Self {
        Self { stacks: names.to_vec(), ..self }
    }

    /// Loads and checks the scenario in `source` with these changes, ready to run: a scenario file, or a folder of results, whose manifest
    /// holds the scenario.
    pub(super) fn load(&self, source: &Path) -> Result<Experiment, Failure> {
        self.load_for(source, None, &Isolate::default())
    }

    /// The changes as arguments.
    pub(super) fn arguments(&self) -> Vec<String> {
        let set = self.set.iter().map(|edit| format!("--set={edit}"));
        let episodes = self.episodes.iter().map(|episodes| format!("--episodes={episodes}"));
        let seed = self.seed.iter().map(|seed| format!("--seed={seed}"));
        let stacks = self.stacks.iter().map(|stack| format!("--stack={stack}"));
        set.chain(episodes).chain(seed).chain(stacks).chain(self.memory.arguments()).collect()
    }

    /// The same for a run on so many threads; on every processor unless `threads` is given.
    pub(super) fn load_for(
        &self,
        source: &Path,
        threads: Option<usize>,
        isolate: &Isolate,
    ) -> Result<Experiment, Failure> {
        let (file, recorded) = if source.is_dir() {
            let (file, manifest) = recorded(source)?;
            (file, Some(manifest))
        } else {
            (ScenarioFile::open(source).map_err(Failure::Scenario)?, None)
        };
        // A folder that was extended holds more episodes than its scenario says.
        let episodes = self.episodes.map(u64::from).or(recorded.as_ref().map(|manifest| manifest.episodes));
        let numbers = [("episodes", episodes), ("seed", self.seed)];
        let numbers = numbers.iter().filter_map(|(key, number)| number.map(|number| format!("{key}={number}")));
        let edits = self.set.iter().cloned().chain(numbers).map(|text| Edit::parse(&text));
        let edits = edits.collect::<Result<Vec<Edit>, _>>().map_err(Failure::Scenario)?;
        let ran = recorded.map(|manifest| manifest.identity.stacks).unwrap_or_default();
        let file = self.memory.set(file, threads, isolate);
        prepare(&file, &edits, if self.stacks.is_empty() { &ran } else { &self.stacks })
    }
}

/// Loads and checks several scenarios, each as `load` does; what is wrong with each of them is told at once.
pub(super) fn load_all(
    sources: &[PathBuf],
    load: impl Fn(&Path) -> Result<Experiment, Failure>,
) -> Result<Vec<Experiment>, Failure> {
    let (mut experiments, mut refused) = (Vec::new(), Vec::new());
    for source in sources {
        match load(source) {
            Ok(experiment) => experiments.push(experiment),
            Err(failure @ (Failure::Usage(_) | Failure::Scenario(_))) => refused.push(failure),
            Err(other) => return Err(other),
        }
    }
    Failure::all(refused).map(|()| experiments)
}

/// The scenario that a folder of results was made of, and its manifest.
fn recorded(folder: &Path) -> Result<(ScenarioFile, Manifest), Failure> {
    let refused =
        |reason| Failure::Usage(format!("error: {}: found a folder without results: {reason}", folder.display()));
    let manifest = Manifest::read(folder).map_err(refused)?;
    let file = ScenarioFile::from_text(folder, manifest.identity.scenario.clone());
    // The resolved scenario always has its name.
    let name = file.read(&[]).map_err(Failure::Scenario)?.name;
    let paths = manifest.scenario_folder(name.as_str()).unwrap_or_default();
    Ok((file.in_folder(paths), manifest))
}

/// The experiment of a scenario's file with edits; with only the stacks named in `stacks`, unless it is empty.
pub(super) fn prepare(file: &ScenarioFile, edits: &[Edit], stacks: &[String]) -> Result<Experiment, Failure> {
    let mut experiment = Experiment::load(file, edits).map_err(|error| match error {
        PrepareError::Scenario(refused) => Failure::Scenario(refused),
        other => Failure::usage(other),
    })?;
    if !stacks.is_empty() {
        experiment.keep_stacks(stacks).map_err(Failure::usage)?;
    }
    Ok(experiment)
}

/// Which point of the sweep is meant.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct AtPoint {
    /// Which point of the scenario's sweep, counted from 0 (`simrun check` lists them).
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(super) point: u32,
}

impl AtPoint {
    /// The point, if the experiment has it.
    pub(super) fn of(&self, experiment: &Experiment) -> Result<u32, Failure> {
        let (point, count) = (self.point, experiment.points());
        if point < count {
            return Ok(point);
        }
        Err(Failure::usage(format!("there is no point {point}: the sweep has {count}, counted from 0")))
    }

    /// The point, if a stack runs there.
    pub(super) fn driven(&self, experiment: &Experiment) -> Result<u32, Failure> {
        let point = self.of(experiment)?;
        if experiment.stacks(point).len() > 0 {
            return Ok(point);
        }
        let stacks = experiment.stack_names().join(", ");
        Err(Failure::usage(format!(
            "nothing runs at point {point}: {stacks} ran in the same way at an earlier point (`simrun check` lists them)"
        )))
    }
}
