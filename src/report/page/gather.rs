//! The rows of one folder of results, read once and line by line: what a page needs of them, in bounded memory.
//!
//! Counts and the values of the compared metrics are those of all rows. Whole rows are kept for two purposes: a bounded number of them for
//! the tests of pairs (the first worlds of every point), and a few for the gallery ([`Candidates`]).

use super::choose::Candidates;
use crate::analysis::{Z_95, wilson};
use crate::comparison::{COMPARED, Section, StackRows, TableError};
use crate::episode::Outcome;
use crate::results::{
    Column, EPISODES_CSV, Identity, Launch, Manifest, Rate, Reader, ResultsError, Row, Statistics, metric_column,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::rc::Rc;

/// Whole rows that are kept for the tests, of all points together.
const ROWS_KEPT_MAX: u64 = 60_000;

/// What the rows of a folder say.
#[derive(Debug)]
pub(super) struct Gathered {
    /// Name of the scenario.
    pub scenario: String,
    /// Swept keys.
    pub keys: Vec<String>,
    /// The points, in order of their first rows.
    pub points: Vec<Point>,
    /// Columns that are younger than the table.
    pub missing: Vec<&'static str>,
    /// Number of rows.
    pub rows: u64,
    /// Worlds whose rows are kept whole begin below this episode; `None` if all are.
    pub kept_below: Option<u64>,
    /// Whether the table is not as its finished run left it.
    pub is_altered: bool,
    /// The manifest beside the table.
    pub manifest: Option<Manifest>,
    /// Episodes that a gallery may show.
    pub candidates: Candidates,
}

/// One point of a sweep; a run without one has a single point.
#[derive(Debug)]
pub(super) struct Point {
    /// Its stacks, in the order of their first rows.
    pub stacks: Vec<Stack>,
    /// The rows that are kept.
    pub section: Section,
}

/// All rows of one stack at one point.
#[derive(Debug)]
pub(super) struct Stack {
    /// Its name.
    pub name: String,
    /// Number of episodes.
    pub n: u64,
    /// Number of episodes that rates count.
    pub rated: u64,
    /// Number of episodes per outcome, in the order of [`Outcome::NAMES`].
    pub outcomes: [u64; Outcome::NAMES.len()],
    /// Values of [`COMPARED`] over the successes, in the order of the rows.
    pub values: [Vec<f64>; COMPARED.len()],
    /// Failures by outcome and what it was with: "collision with dynamic".
    pub endings: BTreeMap<String, u64>,
}

impl Stack {
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            n: 0,
            rated: 0,
            outcomes: [0; Outcome::NAMES.len()],
            values: Default::default(),
            endings: BTreeMap::new(),
        }
    }

    fn add(&mut self, row: &Row, columns: [&'static Column; COMPARED.len()]) {
        self.n += 1;
        self.rated += u64::from(row.outcome.is_rated());
        self.outcomes[row.outcome.index()] += 1;
        if row.outcome.is_success() {
            for (values, column) in self.values.iter_mut().zip(columns) {
                values.extend(column.number(&row.metrics));
            }
        } else {
            *self.endings.entry(row.outcome.words()).or_default() += 1;
        }
    }

    /// Success rate with its Wilson 95 % interval.
    pub fn success(&self) -> Option<Rate> {
        let successes = self.outcomes[0];
        let (low, high) = wilson(successes, self.rated, Z_95)?;
        Some(Rate { rate: successes as f64 / self.rated as f64, low, high })
    }

    /// Statistics of the metric of that place in [`COMPARED`].
    pub fn statistics(&self, metric: usize) -> Statistics {
        Statistics::of(&mut self.values[metric].clone())
    }
}

impl Gathered {
    /// Reads the `episodes.csv` at `path`, or that of the folder.
    ///
    /// # Errors
    /// If it cannot be read as one.
    pub fn read(path: &Path, shown: usize) -> Result<Self, TableError> {
        let file = if path.is_dir() { path.join(EPISODES_CSV) } else { path.to_owned() };
        let place = |source| ResultsError::Read { path: file.clone(), source };
        let mut reader = Reader::open(&file)?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let table = file.file_name().unwrap_or_default().to_string_lossy();
        let manifest = Manifest::read(folder).ok();
        let mut found = Self {
            scenario: String::new(),
            keys: reader.swept().to_vec(),
            points: Vec::new(),
            missing: reader.missing(),
            rows: 0,
            kept_below: None,
            is_altered: manifest.as_ref().is_some_and(|manifest| manifest.is_altered(folder, &table)),
            manifest,
            candidates: Candidates::new(shown),
        };
        let columns = COMPARED.map(|name| metric_column(name).expect("a column of the table, as a test asserts"));
        let (mut block, mut kept, mut at): (Vec<Row>, u64, BTreeMap<u32, usize>) = (Vec::new(), 0, BTreeMap::new());
        while let Some(row) = reader.next() {
            let row = row.map_err(place)?;
            if found.rows == 0 {
                found.scenario.clone_from(&row.scenario);
            } else if found.scenario != row.scenario {
                let message = format!("a row of `{}` in a file of `{}`", row.scenario, found.scenario);
                return Err(TableError::Contradiction { path: file, line: reader.line(), message });
            }
            found.rows += 1;
            if block
                .last()
                .is_some_and(|last| (last.point, last.seed, last.episode) != (row.point, row.seed, row.episode))
            {
                found.take(std::mem::take(&mut block), columns, &mut kept, &mut at);
            }
            block.push(row);
        }
        found.take(block, columns, &mut kept, &mut at);
        Ok(found)
    }

    /// Takes in the rows of one world.
    fn take(
        &mut self,
        block: Vec<Row>,
        columns: [&'static Column; COMPARED.len()],
        kept: &mut u64,
        at: &mut BTreeMap<u32, usize>,
    ) {
        let Some(first) = block.first() else { return };
        let (number, episode, seed) = (first.point, first.episode, first.seed);
        let keys = &self.keys;
        let index = *at.entry(number).or_insert_with(|| {
            let swept = keys.iter().map(|key| (key.clone(), String::new())).collect();
            let (title, scenario, stacks) = (String::new(), first.scenario.clone(), Vec::new());
            self.points
                .push(Point { stacks: Vec::new(), section: Section { title, scenario, point: number, swept, stacks } });
            self.points.len() - 1
        });
        let Point { stacks, section } = &mut self.points[index];
        for row in &block {
            let stack = stacks.iter().position(|stack| stack.name == row.stack).unwrap_or_else(|| {
                for ((_, known), value) in
                    section.swept.iter_mut().zip(&row.swept).filter(|((_, known), _)| known.is_empty())
                {
                    known.clone_from(value);
                }
                stacks.push(Stack::new(&row.stack));
                let (name, values, rows) = (row.stack.clone(), row.swept.clone(), BTreeMap::new());
                section.stacks.push(StackRows { name, values, rows });
                stacks.len() - 1
            });
            stacks[stack].add(row, columns);
        }
        let block = Rc::new(block);
        self.candidates.offer(&block);
        if self.kept_below.is_some_and(|below| episode >= below) {
            return;
        }
        *kept += block.len() as u64;
        for row in block.iter() {
            let found = self.points[index].section.stacks.iter_mut().find(|stack| stack.name == row.stack);
            if let Some(stack) = found {
                stack.rows.insert((seed, episode), row.clone());
            }
        }
        if *kept > ROWS_KEPT_MAX {
            let most = self.sections().flat_map(|section| &section.stacks).flat_map(|stack| stack.rows.keys());
            let most = most.map(|&(_, episode)| episode).max().unwrap_or_default();
            self.keep_below((most / 2).max(1));
            *kept = self.sections().flat_map(|section| &section.stacks).map(|stack| stack.rows.len() as u64).sum();
        }
    }

    /// Keeps whole rows of the worlds below an episode alone.
    pub fn keep_below(&mut self, below: u64) {
        self.kept_below = Some(self.kept_below.map_or(below, |known| known.min(below)));
        for stack in self.points.iter_mut().flat_map(|point| &mut point.section.stacks) {
            stack.rows.retain(|&(_, episode), _| episode < below);
        }
    }

    /// The kept rows, one section a point.
    pub fn sections(&self) -> impl Iterator<Item = &Section> {
        self.points.iter().map(|point| &point.section)
    }

    /// The names of all stacks, in the order of their first rows.
    pub fn stack_names(&self) -> Vec<&str> {
        let mut known = BTreeSet::new();
        let names = self.points.iter().flat_map(|point| &point.stacks).map(|stack| stack.name.as_str());
        names.filter(|name| known.insert(*name)).collect()
    }

    /// Number of worlds, those of one point counted once each.
    pub fn worlds(&self) -> u64 {
        self.points.iter().map(|point| point.stacks.iter().map(|stack| stack.n).max().unwrap_or(0)).sum()
    }

    /// Whether the run is a sweep.
    pub fn is_sweep(&self) -> bool {
        self.points.len() > 1
    }

    /// The run to which the rows belong.
    pub fn identity(&self) -> Option<&Identity> {
        self.manifest.as_ref().map(|manifest| &manifest.identity)
    }

    /// The last start of the program that wrote here.
    pub fn launch(&self) -> Option<&Launch> {
        self.manifest.as_ref()?.launches.last()
    }
}

/// At most `most` of the values, evenly chosen from the first to the last.
pub(super) fn sample(values: &[f64], most: usize) -> Vec<f64> {
    if values.len() <= most {
        return values.to_vec();
    }
    (0..most).map(|k| values[k * values.len() / most]).collect()
}
