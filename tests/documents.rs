//! What the documents name exists.

use std::fs;
use std::path::Path;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The tables of the README that come from the code, between their marks.
fn generated_tables() -> [(&'static str, String); 2] {
    use simrun::plan::{global::GlobalChoice, local::LocalChoice, path::PathChoice};
    let registries = [
        ("global", GlobalChoice::NAMES, GlobalChoice::ENTRIES),
        ("path", PathChoice::NAMES, PathChoice::ENTRIES),
        ("local", LocalChoice::NAMES, LocalChoice::ENTRIES),
    ];
    let mut planners = String::from("| | planner | what | source |\n|---|---|---|---|\n");
    for (kind, names, entries) in registries {
        for (name, entry) in names.iter().zip(entries) {
            planners += &format!("| {kind} | `{name}` | {} | {} |\n", entry.summary, entry.source);
        }
    }
    [("columns", simrun::results::columns()), ("planners", planners)]
}

#[test]
fn the_tables_of_the_readme_are_those_of_the_code() {
    let path = root().join("README.md");
    let mut text = fs::read_to_string(&path).unwrap();
    for (name, table) in generated_tables() {
        let (open, close) = (format!("<!-- {name} -->\n"), format!("<!-- /{name} -->"));
        let from = text.find(&open).unwrap() + open.len();
        let to = text.find(&close).unwrap();
        if std::env::var_os("SIMRUN_BLESS").is_some() {
            text.replace_range(from..to, &table);
        } else {
            assert_eq!(&text[from..to], table, "SIMRUN_BLESS=1 cargo test --test documents writes it anew");
        }
    }
    if std::env::var_os("SIMRUN_BLESS").is_some() {
        fs::write(&path, text).unwrap();
    }
}

#[test]
fn the_scenario_that_the_readme_shows_is_valid() {
    let text = fs::read_to_string(root().join("README.md")).unwrap();
    let yaml = text.split("```yaml\n").nth(1).unwrap().split("```").next().unwrap();
    let file = simrun::scenario::ScenarioFile::from_text("readme.yaml", yaml);
    let scenario = file.read(&[]).unwrap_or_else(|error| panic!("{error}"));
    file.check(&scenario, &[]).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scenario.stacks().len(), 8);
}

/// Every text between back quotes, or behind `](`, that looks like a path of this repository.
fn named_paths(text: &str) -> Vec<String> {
    let starts = ["src/", "tests/", "scenarios/", "scripts/", "docs/", "benches/", "examples/", "results/reference"];
    let mut paths = Vec::new();
    for (at, _) in text.match_indices(['`', '(', ' ']) {
        let rest = &text[at + 1..];
        if starts.iter().any(|start| rest.starts_with(start)) {
            let end = rest.find(|c: char| !(c.is_alphanumeric() || "/_.-".contains(c))).unwrap_or(rest.len());
            paths.push(rest[..end].trim_end_matches('.').to_owned());
        }
    }
    paths
}

#[test]
fn every_path_that_a_document_names_exists() {
    let mut count = 0;
    for document in ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"] {
        let text = fs::read_to_string(root().join(document)).unwrap();
        for path in named_paths(&text) {
            // `my_planner` is the reader's own.
            if path.contains("my_planner") || path.ends_with("episodes.csv") {
                continue;
            }
            assert!(root().join(&path).exists(), "{document} names {path}, which does not exist");
            count += 1;
        }
    }
    assert!(count > 5, "the test found only {count} paths: does it still look in the right places?");
}
