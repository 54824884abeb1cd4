//! Checks that the parts of a paper fit together, before anything runs.

use super::Paper;
use super::manifest::{Place, Source, Test, range};
use super::published::{Quantity, SUCCESS};
use crate::results::metric_column;
use crate::settings::choice::{NameError, unknown_name};

fn metric(name: &str) -> Result<(), String> {
    if name == SUCCESS { Ok(()) } else { metric_column(name).map(|_| ()).map_err(|error| error.to_string()) }
}

impl Paper {
    /// Checks ids, tables, metrics and published numbers against each other.
    pub(super) fn consistent(&self) -> Result<(), String> {
        let tables = &self.manifest.tables;
        if tables.is_empty() {
            return Err("`tables` is empty".to_owned());
        }
        for (index, table) in tables.iter().enumerate() {
            if tables[..index].iter().any(|other| other.id == table.id) {
                return Err(format!("two tables are called `{}`", table.id));
            }
        }
        let claims = &self.manifest.claims;
        for (index, claim) in claims.iter().enumerate() {
            if claims[..index].iter().any(|other| other.id == claim.id) {
                return Err(format!("two claims are called `{}`", claim.id));
            }
            self.check_test(&claim.test).map_err(|message| format!("claim `{}`: {message}", claim.id))?;
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
                    metric(&number.metric)
                }
            };
            check().map_err(|message| format!("{}: {message}", place()))?;
        }
        Ok(())
    }

    fn known(&self, id: &str) -> Result<(), String> {
        let ids: Vec<&str> = self.manifest.tables.iter().map(|table| table.id.as_str()).collect();
        if ids.contains(&id) { Ok(()) } else { Err(unknown_name("table", id, &ids)) }
    }

    fn check_test(&self, test: &Test) -> Result<(), String> {
        match test {
            Test::compare(test) => {
                metric(&test.metric)?;
                self.known(&test.of.table)?;
                self.known(&test.than.table)?;
                if !(test.factor.is_finite() && test.tolerance >= 0.0 && test.tolerance.is_finite()) {
                    return Err("`factor` and `tolerance` are finite, `tolerance` at least 0".to_owned());
                }
                Ok(())
            }
            Test::differ(test) => {
                metric(&test.metric)?;
                test.tables.iter().try_for_each(|table| self.known(table))
            }
            Test::reach(test) => self.known(&test.of.table),
            Test::range(test) => {
                metric(&test.metric)?;
                self.known(&test.table)?;
                if test.at_least.is_none() && test.at_most.is_none() {
                    return Err("a range needs `at_least`, `at_most` or both".to_owned());
                }
                if test.metric == SUCCESS && test.of == range::Statistic::Every && test.source == Source::Measured {
                    return Err("a row's `success` is 0 or 100: ask for the mean".to_owned());
                }
                Ok(())
            }
            Test::fisher(test) => self.known(&test.of.table).and_then(|()| self.known(&test.than.table)),
            Test::multiples(test) => self.known(&test.table),
            Test::all(test) if test.tests.is_empty() => Err("`all` of no tests".to_owned()),
            Test::all(test) => test.tests.iter().try_for_each(|test| self.check_test(test)),
            Test::untestable(_) => Ok(()),
        }
    }

    /// Checks that every stack that claims and published numbers name in a table is among `stacks`, which the table runs.
    ///
    /// # Errors
    /// The first name that is not among them.
    pub fn check_stacks(&self, table: &str, stacks: &[String]) -> Result<(), NameError> {
        let mut named = Vec::new();
        self.manifest.claims.iter().for_each(|claim| places(&claim.test, &mut named));
        for number in &self.published {
            named.push((&number.table, &number.stack));
            if !number.against.is_empty() {
                named.push((&number.table, &number.against));
            }
        }
        match named.iter().find(|(at, stack)| *at == table && !stacks.contains(stack)) {
            Some((_, stack)) => Err(NameError::unknown("stack", stack, stacks)),
            None => Ok(()),
        }
    }
}

/// Collects the (table, stack) pairs whose measured rows a test uses.
fn places<'a>(test: &'a Test, found: &mut Vec<(&'a String, &'a String)>) {
    let at = |place: &'a Place| (&place.table, &place.stack);
    match test {
        Test::compare(test) if test.source == Source::Measured => found.extend([at(&test.of), at(&test.than)]),
        Test::differ(test) => {
            found.extend(test.tables.iter().flat_map(|table| test.stacks.iter().map(move |stack| (table, stack))));
        }
        Test::reach(test) => found.push(at(&test.of)),
        Test::range(test) if test.source == Source::Measured => {
            found.extend(test.stack.as_ref().map(|stack| (&test.table, stack)));
        }
        Test::all(test) => test.tests.iter().for_each(|test| places(test, found)),
        _ => {}
    }
}
