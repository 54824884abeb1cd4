//! Checks that the parts of a paper fit together, before anything runs.

use super::Paper;
use super::manifest::{Choice, larger_form};
use super::published::Quantity;
use super::test::{Use, check_metric};
use crate::settings::choice::{NameError, unknown_name};
use std::collections::BTreeSet;

impl Paper {
    /// Checks ids, tables, metrics and published numbers against each other.
    pub(super) fn consistent(&self) -> Result<(), String> {
        let tables = &self.manifest.tables;
        if tables.is_empty() {
            return Err("`tables` is empty".to_owned());
        }
        once("tables", tables.iter().map(|table| table.id.as_str()))?;
        once("claims", self.manifest.statements().map(|claim| claim.id.as_str()))?;
        let choices = &self.manifest.ablate;
        once("choices", choices.iter().map(|choice| choice.id.as_str()))?;
        for choice in choices {
            let refuse = |message: String| Err(format!("choice `{}`: {message}", choice.id));
            if choice.set.is_empty() || choice.tables.is_empty() {
                return refuse("`set` and `tables` name what it changes".to_owned());
            }
            if let Err(message) = choice.tables.iter().try_for_each(|table| self.known(table)) {
                return refuse(message);
            }
        }
        if choices.iter().filter(|choice| choice.kindest).count() > 1 {
            return Err("at most one choice is the `kindest`".to_owned());
        }
        for table in tables {
            let Some(larger) = &table.larger else { continue };
            self.known(larger).map_err(|message| format!("table `{}`: `larger`: {message}", table.id))?;
            let has_one_alone = |choice: &&Choice| {
                choice.tables.contains(larger) != choice.tables.iter().any(|id| id == table.id.as_str())
            };
            if let Some(choice) = choices.iter().find(has_one_alone) {
                return Err(format!(
                    "choice `{}` changes one of `{}` and `{larger}`, its larger form: name both",
                    choice.id, table.id
                ));
            }
        }
        for claim in self.manifest.statements() {
            claim.test.kind().check(self).map_err(|message| format!("claim `{}`: {message}", claim.id))?;
        }
        for number in &self.published {
            let place = || format!("{}: `{}` of {}", self.manifest.published, number.value, number.place);
            let check = || {
                self.known(&number.table)?;
                let needs_another = number.quantity.needs_another_stack();
                if needs_another == number.against.is_empty() {
                    let needs = if needs_another { "a" } else { "no" };
                    return Err(format!("a `{}` needs {needs} stack in `against`", number.quantity.name()));
                }
                if number.trials == Some(0) {
                    return Err("`trials` is 0".to_owned());
                }
                if number.quantity == Quantity::Rank && number.metric.is_empty() {
                    Ok(())
                } else {
                    check_metric(&number.metric)
                }
            };
            check().map_err(|message| format!("{}: {message}", place()))?;
        }
        Ok(())
    }

    /// Refuses a table that the paper does not have.
    pub(super) fn known(&self, id: &str) -> Result<(), String> {
        let ids: Vec<&str> = self.manifest.tables.iter().map(|table| table.id.as_str()).collect();
        if ids.contains(&id) { Ok(()) } else { Err(unknown_name("table", id, &ids)) }
    }

    /// Checks that every stack that claims and published numbers name in a table is among `stacks`, which the table runs.
    ///
    /// # Errors
    /// The first name that is not among them.
    pub fn check_stacks(&self, table: &str, stacks: &[String]) -> Result<(), NameError> {
        let used = self.uses().filter(|used| used.table == table).filter_map(|used| used.stack);
        let printed = self.published.iter().filter(|number| number.table == table);
        let printed = printed.flat_map(|number| [number.stack.as_str(), number.against.as_str()]);
        let mut named = used.chain(printed.filter(|name| !name.is_empty()));
        match named.find(|name| !stacks.iter().any(|stack| stack == name)) {
            Some(stack) => Err(NameError::unknown("stack", stack, stacks)),
            None => Ok(()),
        }
    }

    /// The stacks of a table that claims and questions look at, for runs under other choices: `None` for all, empty for none.
    pub fn stacks_used(&self, table: &str) -> Option<Vec<String>> {
        let used: BTreeSet<Option<&str>> =
            self.uses().filter(|used| used.table == table).map(|used| used.stack).collect();
        used.into_iter().map(|stack| stack.map(str::to_owned)).collect()
    }

    fn uses(&self) -> impl Iterator<Item = Use<'_>> {
        self.manifest.statements().flat_map(|claim| claim.test.kind().uses()).flat_map(|used| {
            let larger = larger_form(&self.manifest.tables, used.table);
            [Some(used), larger.map(|table| Use { table, ..used })].into_iter().flatten()
        })
    }
}

/// Refuses names that stand twice.
fn once<'a>(what: &str, names: impl Iterator<Item = &'a str>) -> Result<(), String> {
    let mut known = BTreeSet::new();
    match names.into_iter().find(|name| !known.insert(*name)) {
        Some(name) => Err(format!("two {what} are called `{name}`")),
        None => Ok(()),
    }
}
