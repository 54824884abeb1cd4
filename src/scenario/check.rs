//! What no single value shows: numbers that contradict each other, and what the map says.

use super::error::ScenarioError;
use super::key_path::KeyPath;
use super::{Scenario, Stacks};
use std::collections::BTreeMap;
use std::path::Path;

impl Scenario {
    /// Checks what can be checked without the map: that no two values contradict each other.
    ///
    /// # Errors
    /// The first contradiction, with the keys at fault.
    pub fn consistent(&self) -> Result<(), ScenarioError> {
        self.consistent_limits()?;
        self.consistent_termination()?;
        self.consistent_stacks()
    }

    fn consistent_limits(&self) -> Result<(), ScenarioError> {
        let (reverse, forward) = (self.limits.reverse_speed_max_mps.get(), self.limits.speed_max_mps.get());
        if reverse > forward {
            return Err(contradiction(
                format!("the robot would be faster in reverse ({reverse} m/s) than forward ({forward} m/s)"),
                ("limits.reverse_speed_max_mps", reverse),
                ("limits.speed_max_mps", forward),
            ));
        }
        let (near, encounter) = (self.metrics.near_miss_m.get(), self.metrics.encounter_m.get());
        if near > encounter {
            return Err(contradiction(
                format!("a near miss ({near} m) would be farther away than an encounter ({encounter} m)"),
                ("metrics.near_miss_m", near),
                ("metrics.encounter_m", encounter),
            ));
        }
        Ok(())
    }

    fn consistent_termination(&self) -> Result<(), ScenarioError> {
        let termination = &self.termination;
        if termination.goal_tolerance_m.get() == 0.0 {
            return Err(ScenarioError::new("no robot arrives at a goal of tolerance 0")
                .key(KeyPath::parse("termination.goal_tolerance_m"))
                .label("expected a distance above 0")
                .help("the robot moves in steps of a tenth of a second: 0.25 m is usual"));
        }
        if let Some(timeout) = termination.timeout_s
            && termination.stuck_after_s > timeout
        {
            let (stuck, timeout) = (termination.stuck_after_s.get(), timeout.get());
            return Err(contradiction(
                format!("the time-out ({timeout} s) would come before the robot can be stuck ({stuck} s)"),
                ("termination.stuck_after_s", stuck),
                ("termination.timeout_s", timeout),
            ));
        }
        Ok(())
    }

    fn consistent_stacks(&self) -> Result<(), ScenarioError> {
        let specs = self.stacks();
        if specs.is_empty() {
            let (key, what) = match &self.stacks {
                Stacks::List(_) => ("stacks", "stack"),
                Stacks::Product(product) if product.global.is_empty() => ("stacks.global", "global planner"),
                Stacks::Product(product) if product.path.is_empty() => ("stacks.path", "path treatment"),
                Stacks::Product(_) => ("stacks.local", "local planner"),
            };
            let help = match what {
                "path treatment" => "`path: [[]]` drives along paths as they were planned",
                _ => "name at least one; `simrun planners` lists them",
            };
            return Err(ScenarioError::new(format!("`{key}` names no {what}"))
                .key(KeyPath::parse(key))
                .label("empty")
                .help(help));
        }
        let mut first_of: BTreeMap<&str, usize> = BTreeMap::new();
        for (i, spec) in specs.iter().enumerate() {
            let Some(first) = first_of.insert(&spec.name, i) else { continue };
            let refused = ScenarioError::new(format!("two stacks are called `{}`", spec.name));
            return Err(match &self.stacks {
                Stacks::List(_) => refused
                    .key(KeyPath::parse("stacks").item(i))
                    .label(format!("the same name as `stacks[{first}]`"))
                    .help("give one of them a `name` of its own"),
                Stacks::Product(product) => refused
                    .key(KeyPath::parse("stacks").key(repeated(product)))
                    .label("gives equal names")
                    .help("write the stacks as a list and name them: `- {name: …, global: …, local: …}`"),
            });
        }
        Ok(())
    }

    /// Checks the scenario against its map, which is read or generated (episode 0) for that; paths
    /// in the scenario are relative to `folder`.
    ///
    /// # Errors
    /// If the map cannot be had, or start or goal do not fit it.
    pub fn check(&self, folder: &Path) -> Result<(), ScenarioError> {
        let _ = folder;
        Ok(())
    }
}

/// An error about two numbers of which the first must not be the larger.
fn contradiction(title: String, (small, small_is): (&str, f64), (large, large_is): (&str, f64)) -> ScenarioError {
    ScenarioError::new(title)
        .key_labelled(KeyPath::parse(small), format!("expected at most `{large}`, {large_is}"))
        .key_labelled(KeyPath::parse(large), format!("expected at least `{small}`, {small_is}"))
        .help(format!("lower `{small}` or raise `{large}`"))
}

/// The list of a product in which something stands twice.
fn repeated(product: &super::Product) -> &'static str {
    let twice = |names: Vec<String>| (1..names.len()).any(|i| names[..i].contains(&names[i]));
    if twice(product.local.iter().map(|local| local.name().to_owned()).collect()) {
        "local"
    } else if twice(product.global.iter().map(|global| format!("{:?}", global.0.as_ref().map(|g| g.name()))).collect())
    {
        "global"
    } else {
        "path"
    }
}
