//! `simrun planners`: what the registry holds.

use super::{Failure, print};
use crate::plan::Entry;
use crate::plan::global::GlobalChoice;
use crate::plan::local::LocalChoice;
use crate::plan::path::PathChoice;
use crate::settings::choice::unknown_name;
use schemars::Schema;
use std::fmt::Write as _;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Describe this planner alone, with its parameters.
    name: Option<String>,
}

/// One registry: its title, names, entries and parameter schemas.
type Registry = (&'static str, &'static [&'static str], &'static [Entry], fn(&str) -> Option<Schema>);

const REGISTRIES: [Registry; 3] = [
    ("Global planners", GlobalChoice::NAMES, GlobalChoice::ENTRIES, GlobalChoice::params_schema),
    ("Path stages", PathChoice::NAMES, PathChoice::ENTRIES, PathChoice::params_schema),
    ("Local planners", LocalChoice::NAMES, LocalChoice::ENTRIES, LocalChoice::params_schema),
];

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    match &args.name {
        None => print(&list()),
        Some(name) => match describe(name) {
            Some(text) => print(&text),
            None => {
                let known: Vec<&str> = REGISTRIES.iter().flat_map(|registry| registry.1).copied().collect();
                Err(Failure::Usage(format!("error: {}", unknown_name("planner", name, &known))))
            }
        },
    }
}

fn list() -> String {
    let mut text = String::new();
    for (title, names, entries, _) in REGISTRIES {
        let _ = writeln!(text, "{title}");
        for (name, entry) in names.iter().zip(entries) {
            let _ = writeln!(text, "  {name:<18} {}", entry.summary);
        }
        text.push('\n');
    }
    text.push_str("`simrun planners NAME` describes one with its parameters.\n");
    text
}

fn describe(name: &str) -> Option<String> {
    let (entry, schema) = REGISTRIES.iter().find_map(|(_, names, entries, schema)| {
        let index = names.iter().position(|known| *known == name)?;
        Some((&entries[index], schema(name)?))
    })?;
    let mut text = format!("{name}\n  {}\n  Source: {}\n", entry.summary, entry.source);
    let parameters = schema.get("properties").and_then(|value| value.as_object());
    match parameters {
        Some(parameters) if !parameters.is_empty() => {
            text.push_str("\nParameters\n");
            for (key, value) in parameters {
                let default = value.get("default").map_or_else(|| "required".to_owned(), ToString::to_string);
                let meaning = value.get("description").and_then(|text| text.as_str()).unwrap_or_default();
                let _ = writeln!(text, "  {key}: {default}\n      {}", meaning.replace('\n', "\n      "));
            }
        }
        _ => text.push_str("\nNo parameters.\n"),
    }
    Some(text)
}
