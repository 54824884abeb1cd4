//! The JSON Schema against an independent validator: shipped scenarios pass, slips of the pen do not.

use super::support::{files, is_blessing, root};
use boon::{Compiler, SchemaIndex, Schemas};
use simrun::scenario::Scenario;
use std::fs;
use std::path::PathBuf;

const FILE: &str = "docs/scenario.schema.json";

/// The reference of keys, for people.
const REFERENCE: &str = "docs/book/src/scenario.md";

/// The shipped scenarios: neither headers of maps nor papers.
fn scenarios() -> Vec<PathBuf> {
    let folder = root().join("scenarios");
    let mut found = files(&folder, "yaml");
    found.retain(|file| !file.starts_with(folder.join("maps")) && !file.to_string_lossy().ends_with(".paper.yaml"));
    found
}

/// The schema as a program that has not read our code understands it.
struct Validator {
    schemas: Schemas,
    root: SchemaIndex,
}

impl Validator {
    fn new() -> Self {
        let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
        compiler.add_resource(FILE, Scenario::schema().clone()).unwrap();
        let root = compiler.compile(FILE, &mut schemas).unwrap_or_else(|error| panic!("{error}"));
        Self { schemas, root }
    }

    fn check(&self, value: &serde_json::Value) -> Result<(), String> {
        self.schemas.validate(value, self.root).map_err(|error| error.to_string())
    }
}

/// The file as the validator's own kind of tree.
fn tree(text: &str) -> Option<serde_json::Value> {
    serde_yaml::from_str(text).ok()
}

#[test]
fn the_shipped_schema_is_the_one_that_the_command_prints() {
    let path = root().join(FILE);
    if is_blessing() {
        fs::write(&path, Scenario::schema_text()).unwrap();
    }
    assert_eq!(fs::read_to_string(path).unwrap(), Scenario::schema_text(), "SIMRUN_BLESS=1 writes it anew");
}

#[test]
fn the_reference_of_keys_is_the_one_that_the_code_writes() {
    let (path, page) = (root().join(REFERENCE), simrun::scenario::reference::page());
    if is_blessing() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, &page).unwrap();
    }
    assert_eq!(fs::read_to_string(path).unwrap(), page, "SIMRUN_BLESS=1 writes it anew");
}

/// Every object in a tree, with the pointer to it.
fn objects<'a>(tree: &'a serde_json::Value, at: &str, found: &mut Vec<(String, &'a serde_json::Value)>) {
    match tree {
        serde_json::Value::Object(keys) => {
            found.push((at.to_owned(), tree));
            keys.iter().for_each(|(key, inner)| objects(inner, &format!("{at}/{key}"), found));
        }
        serde_json::Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, inner)| objects(inner, &format!("{at}/{i}"), found));
        }
        _ => {}
    }
}

#[test]
fn types_of_the_schema_have_names_of_their_own_and_every_key_and_kind_is_described() {
    let schema = Scenario::schema();
    let types = schema["$defs"].as_object().unwrap();
    for name in ["map.random", "map.warehouse", "obstacles.moving.random", "stacks.local.dwa", "stacks.global.a_star"] {
        assert!(types.contains_key(name), "{name} is not in {:?}", types.keys());
    }
    assert!(!types.keys().any(|name| name.contains("Params")), "{:?}", types.keys());
    let mut all = Vec::new();
    objects(schema, "", &mut all);
    let mut references = 0;
    for (at, object) in &all {
        // The file alone is enough for an editor: every reference leads to a type in it.
        if let Some(reference) = object["$ref"].as_str() {
            assert!(schema.pointer(&reference[1..]).is_some(), "{at} refers to {reference}");
            references += 1;
        }
        if at.ends_with("/properties") {
            for (key, value) in object.as_object().unwrap() {
                let described =
                    |form: &serde_json::Value| form["description"].as_str().is_some_and(|text| !text.is_empty());
                let wrapped = value["anyOf"].as_array().into_iter().flatten().chain([value]);
                let target = wrapped.filter_map(|form| form["$ref"].as_str()).find_map(|to| schema.pointer(&to[1..]));
                assert!(described(value) || target.is_some_and(described), "{at}/{key} has no description");
            }
        }
    }
    assert!(references > 100, "{references}");
}

#[test]
fn every_shipped_scenario_is_valid_and_tells_editors_where_the_schema_is() {
    let validator = Validator::new();
    let files = scenarios();
    assert!(files.len() >= 15, "{files:?}");
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        let value = tree(&text).unwrap();
        validator.check(&value).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let depth = file.strip_prefix(root()).unwrap().components().count() - 1;
        let line = format!("# yaml-language-server: $schema={}{FILE}", "../".repeat(depth));
        assert!(text.lines().any(|found| found == line), "{} lacks `{line}`", file.display());
    }
}

#[test]
fn what_a_schema_can_say_is_refused_by_it() {
    let validator = Validator::new();
    let base = "map: {empty: {cols: 20, rows: 10}}\nstacks: {global: [a_star], local: [dwa]}\n";
    assert!(validator.check(&tree(base).unwrap()).is_ok());
    for slip in [
        "limits: {speed_max_mp: 1}",
        "limits: {speed_max_mps: -1}",
        "limits: {speed_max_mps: fast}",
        "seed: -1",
        "episodes: 0",
        "obstacles: {moving: [randm]}",
        "obstacles: {moving: [random: {count: 1.5}]}",
        "sensing: 5",
        "sweep: {robot.radius_m: 0.2}",
        "sweep: {robot.radius_m: {from: 0.2, to: 0.3}}",
    ] {
        let text = format!("{base}{slip}\n");
        assert!(validator.check(&tree(&text).unwrap()).is_err(), "the schema lets `{slip}` pass");
    }
    for wrong in ["map: {empty: {cols: 20, rows: 10}}", "stacks: {global: [a_star], local: [dwa]}", "- 1"] {
        assert!(validator.check(&tree(wrong).unwrap()).is_err(), "the schema lets `{wrong}` pass");
    }
}
