//! `simrun planners`: what the registry holds.

use super::{Failure, Out};
use crate::plan::Entry;
use crate::plan::global::GlobalChoice;
use crate::plan::local::LocalChoice;
use crate::plan::path::PathChoice;
use crate::results::layout::{hanging, lines};
use crate::scenario::reference;
use crate::settings::choice::unknown_name;
use std::fmt::Write as _;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Describe this planner alone, with its parameters.
    name: Option<String>,
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
    let Some(name) = &args.name else { return args.out.write(&list(args.out.width())) };
    match describe(name, args.out.width()) {
        Some(text) => args.out.write(&text),
        None => {
            let known: Vec<&str> = REGISTRIES.iter().flat_map(|registry| registry.2).copied().collect();
            Err(Failure::Usage(format!("error: {}", unknown_name("planner", name, &known))))
        }
    }
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

fn describe(name: &str, width: usize) -> Option<String> {
    let (key, entry) = REGISTRIES.iter().find_map(|(_, key, names, entries)| {
        let index = names.iter().position(|known| *known == name)?;
        Some((format!("{key}.{name}"), &entries[index]))
    })?;
    let parameters = lines(&reference::parameters(&key).ok()?, width);
    let parameters =
        if parameters.is_empty() { "No parameters.\n".to_owned() } else { format!("Parameters\n{parameters}") };
    let summary = hanging("  ", 2, entry.summary, width);
    let source = hanging("  Source: ", 10, entry.source, width);
    Some(format!("{name}\n{summary}{source}\n{parameters}"))
}
