//! Rows of result files, sorted into sections; rows are compared only within a section.

use crate::results::{EPISODES_CSV, Identity, Manifest, ReadError, Reader, ResultsError, Row, title};
use crate::scenario;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// A table of episodes, sorted into sections.
#[derive(Clone, Debug)]
pub struct Table {
    /// The file.
    pub path: PathBuf,
    /// One section per point of its sweep, in order.
    pub sections: Vec<Section>,
    /// Columns that are younger than the table, hence undefined in every row.
    pub missing: Vec<&'static str>,
    /// Whether the table is not as its finished run left it, by the hash in the manifest beside it.
    pub is_altered: bool,
    /// Identity of the run, by the manifest beside it; `None` without a readable one.
    pub identity: Option<Identity>,
}

impl Table {
    /// Settings in which this run differs from an older one, each key with both values, in words; the number of episodes does not count.
    /// Empty without the manifests of both.
    pub fn settings_that_differ(&self, older: &Self) -> Vec<String> {
        let (Some(old), Some(new)) = (&older.identity, &self.identity) else { return Vec::new() };
        scenario::differences(&old.scenario, &new.scenario, &["episodes", "description"]).unwrap_or_default()
    }
}

/// The rows of one file at one point of its sweep.
#[derive(Clone, Debug)]
pub struct Section {
    /// File, and the point's keys and values.
    pub title: String,
    /// Name of the scenario.
    pub scenario: String,
    /// Number of the point.
    pub point: u32,
    /// Swept keys and their values; the value is empty if the key concerns none of the stacks.
    pub swept: Vec<(String, String)>,
    /// The stacks, in the order of their first rows.
    pub stacks: Vec<StackRows>,
}

impl Section {
    /// The section without copies, and the number of episodes left out. An episode is a copy of an earlier one if the world and what
    /// every stack did in it are the same to the last bit: nothing in the scenario is random, and it is no evidence of its own. Rows without
    /// digests are no copies.
    pub fn without_copies(&self) -> (Self, u64) {
        let mut section = self.clone();
        let worlds: BTreeSet<(u64, u64)> = self.stacks.iter().flat_map(|stack| stack.rows.keys().copied()).collect();
        let mut known = BTreeSet::new();
        let mut copies = 0;
        for world in worlds {
            let digests = |stack: &StackRows| {
                let row = stack.rows.get(&world)?;
                Some((row.world_digest?.0, row.trace_digest?.0))
            };
            let drives: Vec<Option<(u64, u64)>> = self.stacks.iter().map(digests).collect();
            let is_told_apart = drives.iter().any(Option::is_none);
            if !is_told_apart && !known.insert(drives) {
                copies += 1;
                for stack in &mut section.stacks {
                    stack.rows.remove(&world);
                }
            }
        }
        (section, copies)
    }
}

/// The rows of one stack.
#[derive(Clone, Debug)]
pub struct StackRows {
    /// Its name.
    pub name: String,
    /// Values of the swept keys; empty if a key does not concern the stack.
    pub values: Vec<String>,
    /// One row per world: (seed, episode).
    pub rows: BTreeMap<(u64, u64), Row>,
}

impl StackRows {
    /// Whether it is the other run's stack at the same values. Older tables give a value to keys that do not concern a stack.
    pub(super) fn is_same_setting(&self, other: &Self) -> bool {
        let agree = |(a, b): (&String, &String)| a == b || a.is_empty() || b.is_empty();
        self.name == other.name && self.values.iter().zip(&other.values).all(agree)
    }

    /// The rows of the worlds that both stacks drove, feasible ones only, in the order of the worlds. Worlds of one seed and episode
    /// are the same only if their digests are: those of another build or scenario may differ.
    pub fn shared<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = (&'a Row, &'a Row)> {
        self.rows
            .iter()
            .filter_map(|(world, row)| Some((row, other.rows.get(world)?)))
            .filter(|(a, b)| a.outcome.is_rated() && b.outcome.is_rated() && a.world_digest == b.world_digest)
    }

    /// Whether every episode that both drove is in the same world, and there is one: then they are pairs.
    pub fn is_of_same_worlds(&self, other: &Self) -> bool {
        let mut both = self.rows.iter().filter_map(|(world, row)| Some((row, other.rows.get(world)?))).peekable();
        both.peek().is_some() && both.all(|(a, b)| a.world_digest == b.world_digest)
    }

    /// Number of successes.
    pub fn successes(&self) -> u64 {
        self.rows.values().filter(|row| row.outcome.is_success()).count() as u64
    }

    /// Successes divided by episodes in feasible worlds; 0 without any.
    pub fn success_rate(&self) -> f64 {
        let feasible = self.rows.values().filter(|row| row.outcome.is_rated()).count();
        if feasible == 0 { 0.0 } else { self.successes() as f64 / feasible as f64 }
    }
}

/// Reason why the rows of a table cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// It cannot be read as an `episodes.csv`.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// Rows of it contradict each other.
    #[error("{}: line {line}: {message}", path.display())]
    Contradiction {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: u64,
        /// Description of the fault.
        message: String,
    },
}

/// Reads an `episodes.csv` of this version or an older one into one section per point; of a folder, the `episodes.csv` in it.
///
/// # Errors
/// The fault of the file, with its line; also two rows of one stack in one world, stacks that met different worlds in one
/// episode, and rows of a second scenario.
pub fn read_table(path: &Path) -> Result<Table, TableError> {
    let path = if path.is_dir() { path.join(EPISODES_CSV) } else { path.to_owned() };
    let shown = path.display();
    let place = |source: ReadError| ResultsError::Read { path: path.clone(), source };
    let mut reader = Reader::open(&path)?;
    let (keys, missing) = (reader.swept().to_vec(), reader.missing());
    let mut sections: Vec<Section> = Vec::new();
    while let Some(row) = reader.next() {
        let row = row.map_err(place)?;
        let known = sections.iter().position(|section| section.point == row.point);
        let index = known.unwrap_or_else(|| {
            let swept = keys.iter().map(|key| (key.clone(), String::new())).collect();
            sections.push(Section {
                title: String::new(),
                scenario: row.scenario.clone(),
                point: row.point,
                swept,
                stacks: Vec::new(),
            });
            sections.len() - 1
        });
        let line = reader.line();
        let refuse = |message| TableError::Contradiction { path: path.clone(), line, message };
        if sections[0].scenario != row.scenario {
            let first = &sections[0].scenario;
            return Err(refuse(format!("a row of `{}` in a file of `{first}`", row.scenario)));
        }
        let Section { stacks, swept, .. } = &mut sections[index];
        let stack = stacks.iter().position(|stack| stack.name == row.stack).unwrap_or_else(|| {
            for ((_, known), value) in swept.iter_mut().zip(&row.swept).filter(|((_, known), _)| known.is_empty()) {
                known.clone_from(value);
            }
            stacks.push(StackRows { name: row.stack.clone(), values: row.swept.clone(), rows: BTreeMap::new() });
            stacks.len() - 1
        });
        let world = (row.seed, row.episode);
        let name = row.stack.clone();
        if let Some(other) = stacks.iter().find_map(|stack| stack.rows.get(&world))
            && other.world_digest != row.world_digest
        {
            let other = &other.stack;
            return Err(refuse(format!("`{other}` and `{name}` met different worlds in episode {}", world.1)));
        }
        if stacks[stack].rows.insert(world, row).is_some() {
            return Err(refuse(format!("a second row of `{name}` in episode {}", world.1)));
        }
    }
    for section in &mut sections {
        let values = title(std::iter::once(section.swept.as_slice()));
        section.title = if values.is_empty() { shown.to_string() } else { format!("{shown}: {values}") };
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let manifest = Manifest::read(folder).ok();
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let is_altered = manifest.as_ref().is_some_and(|manifest| manifest.is_altered(folder, &name));
    Ok(Table { sections, missing, is_altered, identity: manifest.map(|manifest| manifest.identity), path })
}
