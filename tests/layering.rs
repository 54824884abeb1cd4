//! Data flows one way: a module imports only from those above it in the list.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::fs;
use std::path::{Path, PathBuf};

/// The order of the house, ground first; a folder's own modules may name each other.
const ORDER: [&str; 22] = [
    "math",
    "settings",
    "geometry",
    "digest",
    "rng",
    "clock",
    "map",
    "robot",
    "observation",
    "plan",
    "world",
    "trace",
    "episode",
    "metrics",
    "scenario",
    "analysis",
    "results",
    "experiment",
    "comparison",
    "paper",
    "report",
    "cli",
];

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// The first-level modules that a source names behind `crate::`, comments left out.
fn named_modules(source: &str) -> Vec<String> {
    let code: String =
        source.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
    let mut named = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        let rest = &code[at + "crate::".len()..];
        if let Some(list) = rest.strip_prefix('{') {
            let list = &list[..list.find(';').unwrap_or(list.len())];
            named.extend(
                list.split(',')
                    .map(|item| item.trim_matches(|c: char| !c.is_alphanumeric() && c != '_'))
                    .map(|item| item.split("::").next().unwrap_or_default().to_owned()),
            );
        } else {
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            named.push(rest[..end].to_owned());
        }
    }
    named
}

#[test]
fn a_module_imports_only_from_those_above_it() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    let mut seen = Vec::new();
    let mut broken = Vec::new();
    for file in files {
        let relative = file.strip_prefix(&src).unwrap();
        let room =
            relative.components().next().unwrap().as_os_str().to_str().unwrap().trim_end_matches(".rs").to_owned();
        if room == "lib" || room == "main" {
            continue;
        }
        let floor = ORDER.iter().position(|name| *name == room);
        let floor = floor.unwrap_or_else(|| panic!("{room} has no place in the order: add it"));
        seen.push(floor);
        for named in named_modules(&fs::read_to_string(&file).unwrap()) {
            if let Some(other) = ORDER.iter().position(|name| *name == named)
                && other > floor
            {
                broken.push(format!("{} names {named}, which stands below it", relative.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
    for (floor, room) in ORDER.iter().enumerate() {
        assert!(seen.contains(&floor), "{room} is in the order but not in src");
    }
}

#[test]
fn planners_never_see_the_world() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/plan");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    for file in files {
        let named = named_modules(&fs::read_to_string(&file).unwrap());
        assert!(!named.iter().any(|name| name == "world"), "{} names the world", file.display());
    }
}

#[test]
fn rapier_is_used_by_the_world_alone() {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&src, &mut files);
    for file in files {
        let names_rapier = fs::read_to_string(&file).unwrap().contains("rapier2d::");
        assert!(!names_rapier || file.starts_with(src.join("world")), "{} names rapier2d", file.display());
    }
}
