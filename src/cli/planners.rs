//! `simrun planners`: what the registry holds.

use super::json::{self, TextOrJson};
use super::{Failure, Out};
use crate::plan::Entry;
use crate::plan::global::GlobalChoice;
use crate::plan::local::LocalChoice;
use crate::plan::path::PathChoice;
use crate::results::layout::{hanging, lines};
use crate::scenario::reference;
use crate::settings::choice::unknown_name;
use serde_json::{Value as Json, json};
use std::fmt::Write as _;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Describe this planner alone, with its parameters.
    name: Option<String>,
    /// How to print it; json describes every planner with its parameters, or the one that is named.
    #[arg(long, value_enum, default_value_t)]
    format: TextOrJson,
    #[command(flatten)]
    out: Out,
}

/// One registry: its title, the key under which scenarios name its planners, their names and entries.
type Registry = (&'static str, &'static str, &'static [&'static str], &'static [Entry]);

const REGISTRIES: [Registry; 3] = [
    ("Global planners", "stacks.global", GlobalChoice::NAMES, GlobalChoice::ENTRIES),
    ("Path stages", "stacks.path", PathChoice::NAMES, PathChoice::ENTRIES),
    ("Local planners", "stacks.local", LocalChoice::NAMES, LocalChoice::ENTRIES),
];

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    if args.format == TextOrJson::Json {
        return json::answer("planners", &args.out, |document| {
            let described =
                args.name.as_deref().map_or_else(|| Ok(all_as_json()), |name| Ok(vec![as_json(find(name)?)]));
            document.insert("planners".to_owned(), described?.into());
            Ok(())
        });
    }
    match &args.name {
        None => args.out.write(&list(args.out.width())),
        Some(name) => args.out.write(&describe(find(name)?, args.out.width())),
    }
}

/// A planner of the registry: its role, the key under which scenarios name it, its name and entry.
type Planner = (&'static str, String, &'static str, &'static Entry);

fn all() -> impl Iterator<Item = Planner> {
    REGISTRIES.iter().flat_map(|(_, key, names, entries)| {
        let role = key.rsplit('.').next().unwrap_or_default();
        names.iter().zip(*entries).map(move |(name, entry)| (role, format!("{key}.{name}"), *name, entry))
    })
}

fn find(name: &str) -> Result<Planner, Failure> {
    all().find(|planner| planner.2 == name).ok_or_else(|| {
        let known: Vec<&str> = all().map(|planner| planner.2).collect();
        Failure::Usage(format!("error: {}", unknown_name("planner", name, &known)))
    })
}

fn all_as_json() -> Vec<Json> {
    all().map(as_json).collect()
}

fn as_json((role, key, name, entry): Planner) -> Json {
    json!({
        "name": name,
        "role": role,
        "key": key,
        "summary": entry.summary,
        "source": entry.source,
        "parameters": reference::parameters_json(&key).unwrap_or_default(),
    })
}

fn list(width: usize) -> String {
    let mut text = String::new();
    for (title, _, names, entries) in REGISTRIES {
        let _ = writeln!(text, "{title}");
        for (name, entry) in names.iter().zip(entries) {
            text += &hanging(&format!("  {name:<18} "), 21, entry.summary, width);
        }
        text.push('\n');
    }
    text.push_str("`simrun planners NAME` describes one with its parameters.\n");
    text
}

fn describe((_, key, name, entry): Planner, width: usize) -> String {
    let parameters = lines(&reference::parameters(&key).unwrap_or_default(), width);
    let parameters =
        if parameters.is_empty() { "No parameters.\n".to_owned() } else { format!("Parameters\n{parameters}") };
    let summary = hanging("  ", 2, entry.summary, width);
    let source = hanging("  Source: ", 10, entry.source, width);
    format!("{name}\n{summary}{source}\n{parameters}")
}
