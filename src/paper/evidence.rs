//! Results of running a paper's tables: rows, checked bounds, causes of failures.

use crate::comparison::{Section, StackRows};
use crate::experiment::{Experiment, in_order, threads_available};
use crate::metrics::failure::Cause;
use crate::plan::global::{GlobalChoice, a_star};
use crate::plan::stack::{Movers, StackSpec};
use crate::results::{Digest, Row};
use std::collections::{BTreeMap, BTreeSet};

/// Number of failures per stack and table that are driven again to find their causes.
const SAMPLE: usize = 20;
/// Slack for rounding in comparisons of lengths, m.
const SLACK_M: f64 = 1e-9;

/// Results of a paper's tables.
#[derive(Debug, Default)]
pub struct Evidence {
    /// Results by id of the table.
    pub tables: BTreeMap<String, TableEvidence>,
    /// Rows of tables under other choices, by the id of the choice and that of the table.
    pub under: BTreeMap<(String, String), Vec<Section>>,
}

/// Results of one table.
#[derive(Debug)]
pub struct TableEvidence {
    /// Its rows, one section per point of a sweep.
    pub sections: Vec<Section>,
    /// The bounds that every row must keep.
    pub bounds: Bounds,
    /// Causes of the stacks' failures, by (point, stack).
    pub failures: BTreeMap<(u32, String), Failures>,
}

/// Bounds that no row may break, whatever the planners do.
#[derive(Clone, Debug, Default)]
pub struct Bounds {
    /// Number of rows checked.
    pub rows: u64,
    /// Number of checks made.
    pub checks: u64,
    /// Violations in words. Any violation is a defect of the program.
    pub broken: Vec<String>,
}

/// The causes of a stack's failures.
#[derive(Clone, Debug, Default)]
pub struct Failures {
    /// Number of failures.
    pub total: u64,
    /// Number of failures that were driven again, the first ones.
    pub sampled: u64,
    /// Number of these with each cause.
    pub causes: BTreeMap<Cause, u64>,
    /// An episode of each cause.
    pub examples: BTreeMap<Cause, u64>,
}

impl Failures {
    /// Takes in the failures of the same stack elsewhere.
    pub(super) fn join(&mut self, other: &Self) {
        self.total += other.total;
        self.sampled += other.sampled;
        for (cause, count) in &other.causes {
            *self.causes.entry(*cause).or_default() += count;
        }
        for (cause, episode) in &other.examples {
            self.examples.entry(*cause).or_insert(*episode);
        }
    }
}

impl Evidence {
    /// The rows of a table: under a choice if it changes the table, else as the table is.
    pub fn sections(&self, choice: Option<&str>, table: &str) -> Option<&[Section]> {
        let under = choice.and_then(|choice| self.under.get(&(choice.to_owned(), table.to_owned())));
        Some(under.map_or_else(|| self.tables.get(table).map(|found| &found.sections), Some)?)
    }

    /// The rows of a table without a sweep.
    pub fn section(&self, table: &str) -> Option<&Section> {
        self.tables.get(table)?.sections.first()
    }

    /// The rows of a stack in a table without a sweep.
    pub fn stack(&self, table: &str, stack: &str) -> Option<&StackRows> {
        self.section(table)?.stacks.iter().find(|rows| rows.name == stack)
    }

    /// Adds the rows of a table that `experiment` wrote: checks their bounds and drives a sample of the failures again.
    pub fn add(&mut self, table: &str, experiment: &Experiment, sections: Vec<Section>) {
        let bounds = check(experiment, &sections);
        let stacks: Vec<(u32, &StackRows)> =
            sections.iter().flat_map(|section| section.stacks.iter().map(|stack| (section.point, stack))).collect();
        let found = in_order(stacks.len(), threads_available(), |index| {
            let (point, stack) = stacks[index];
            let number = experiment.stacks(point).position(|spec| spec.name == stack.name);
            number.map_or_else(Failures::default, |number| sample(experiment, point, number, stack))
        });
        let keys = stacks.iter().map(|(point, stack)| (*point, stack.name.clone()));
        let failures = keys.zip(found).collect();
        self.tables.insert(table.to_owned(), TableEvidence { sections, bounds, failures });
    }
}

/// Drives the first failures of a stack again and counts their causes.
fn sample(experiment: &Experiment, point: u32, stack_index: usize, stack: &StackRows) -> Failures {
    let failed = || stack.rows.values().filter(|row| !row.outcome.is_success());
    let mut found = Failures { total: failed().count() as u64, ..Failures::default() };
    for row in failed().take(SAMPLE) {
        let Ok(drive) = experiment.drive_one(point, row.episode, stack_index) else { continue };
        if let Some(cause) = drive.cause() {
            found.sampled += 1;
            *found.causes.entry(cause).or_default() += 1;
            found.examples.entry(cause).or_insert(row.episode);
        }
    }
    found
}

/// Checks, on every row (systems.md §1.3):
///
/// 0. its world is the one that its seed and episode give again;
/// 1. no planned path is shorter than the straight line from start to goal, and no successful drive by more than the goal tolerance;
/// 2. the planned paths of exact planners on one world, without path stages, are equally long;
/// 3. A* expands no more nodes than Dijkstra in one search (it may expand as many with f equal to the optimum, never more);
/// 4. Dijkstra expands no more nodes in one search than there are free cells.
fn check(experiment: &Experiment, sections: &[Section]) -> Bounds {
    let mut all = Bounds::default();
    for section in sections {
        let worlds: BTreeSet<(u64, u64)> = section.stacks.iter().flat_map(|stack| stack.rows.keys().copied()).collect();
        let worlds: Vec<(u64, u64)> = worlds.into_iter().collect();
        let movers = &experiment.scenario_at(section.point).planning.movers;
        let stacks = experiment.stacks(section.point);
        let exact: Vec<&str> = stacks.filter(|spec| is_exact(spec, movers)).map(|spec| spec.name.as_str()).collect();
        for found in
            in_order(worlds.len(), threads_available(), |index| check_world(experiment, section, worlds[index], &exact))
        {
            all.rows += found.rows;
            all.checks += found.checks;
            all.broken.extend(found.broken);
        }
    }
    all
}

/// Whether the planned paths of a stack are shortest ones on the same grid: an exact search with its defaults (another corner rule is
/// another graph) or with another consistent heuristic, its path as it is, and no cell blocked by the movers that it senses; `movers` is what
/// they are to stacks that do not say.
fn is_exact(spec: &StackSpec, movers: &Movers) -> bool {
    let Some(global) = &spec.global else { return false };
    let is_same_grid = !spec.movers.as_ref().unwrap_or(movers).kind().block();
    let has_defaults = match global {
        GlobalChoice::a_star(params) => {
            let plain = a_star::Params { heuristic: params.heuristic, ..a_star::Params::default() };
            params.heuristic.is_consistent() && *params == plain
        }
        other => GlobalChoice::by_name(other.name()).as_ref() == Ok(other),
    };
    spec.path.is_empty() && global.entry().exact && has_defaults && is_same_grid
}

/// The checks of one world; `exact` are the stacks whose planned paths must be equally long.
fn check_world(experiment: &Experiment, section: &Section, world: (u64, u64), exact: &[&str]) -> Bounds {
    let mut bounds = Bounds::default();
    let episode = world.1;
    let Ok(scene) = experiment.scene(section.point, episode) else { return bounds };
    let tolerance_m = experiment.scenario_at(section.point).termination.goal_tolerance_m.get();
    let straight_m = (scene.goal - scene.start.position).norm();
    let free = scene.map.grid.occupied().iter().filter(|occupied| !**occupied).count() as u64;
    let rows: Vec<&Row> = section.stacks.iter().filter_map(|stack| stack.rows.get(&world)).collect();
    let mut test = |holds: bool, what: &dyn Fn() -> String| {
        bounds.checks += 1;
        if !holds {
            bounds.broken.push(format!("{}, episode {episode}: {}", section.title, what()));
        }
    };
    let digest = Some(Digest(scene.digest()));
    for row in &rows {
        test(row.world_digest == digest, &|| format!("{} drove in another world", row.stack));
        if let Some(planned_m) = row.metrics.planned_length_m {
            test(planned_m >= straight_m - SLACK_M, &|| format!("{} planned {planned_m} of {straight_m} m", row.stack));
        }
        if let (true, Some(length_m)) = (row.outcome.is_success(), row.metrics.length_m) {
            let is_possible = length_m + tolerance_m >= straight_m - 1e-6;
            test(is_possible, &|| format!("{} drove {length_m} of {straight_m} m", row.stack));
        }
    }
    let lengths = rows.iter().filter(|row| exact.contains(&row.stack.as_str()));
    let lengths: Vec<(&str, f64)> =
        lengths.filter_map(|row| Some((row.stack.as_str(), row.metrics.planned_length_m?))).collect();
    for (stack, planned_m) in lengths.iter().skip(1) {
        let (first, length_m) = lengths[0];
        let is_equal = (planned_m - length_m).abs() <= SLACK_M;
        test(is_equal, &|| format!("{stack} planned {planned_m} m, {first} {length_m} m"));
    }
    let expanded = |global: &str| {
        let once = rows
            .iter()
            .find(|row| row.global == global && row.metrics.replans == Some(0) && exact.contains(&row.stack.as_str()));
        once.and_then(|row| row.metrics.expanded)
    };
    if let Some(by_dijkstra) = expanded("dijkstra") {
        test(by_dijkstra <= free, &|| format!("dijkstra expanded {by_dijkstra} of {free} free cells"));
        if let Some(by_a_star) = expanded("a_star") {
            test(by_a_star <= by_dijkstra, &|| format!("a_star expanded {by_a_star}, dijkstra {by_dijkstra}"));
        }
    }
    bounds.rows = rows.len() as u64;
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::ScenarioFile;

    #[test]
    fn only_plain_exact_searches_of_the_same_grid_must_agree() {
        let names = |planning: &str| {
            let text = format!(
                "
name: exact
map: {{empty: {{cols: 9, rows: 9}}}}
planning: {planning}
stacks:
  - {{name: dijkstra, global: dijkstra, local: dwa}}
  - {{name: euclid, global: {{a_star: {{heuristic: euclidean}}}}, local: dwa}}
  - {{name: manhattan, global: {{a_star: {{heuristic: manhattan}}}}, local: dwa}}
  - {{name: corners, global: {{dijkstra: {{corner_rule: allow}}}}, local: dwa}}
  - {{name: pruned, global: dijkstra, path: [line_of_sight], local: dwa}}
  - {{name: greedy, global: atan_a_star, local: dwa}}
  - {{name: alone, global: none, local: dwa}}
  - {{name: round_movers, global: d_star, local: dwa, movers: block}}
  - {{name: repairs, global: d_star, local: dwa, movers: ignore}}
"
            );
            let experiment = Experiment::load(&ScenarioFile::from_text("exact.yaml", text), &[]).unwrap();
            let movers = &experiment.scenario().planning.movers;
            let exact = experiment.stacks(0).filter(|spec| is_exact(spec, movers)).map(|spec| spec.name.clone());
            exact.collect::<Vec<_>>()
        };
        assert_eq!(names("{}"), ["dijkstra", "euclid", "repairs"]);
        assert_eq!(names("{movers: block}"), ["repairs"]);
    }
}
