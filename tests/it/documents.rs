//! Checks that the files and names that the documents mention exist.

use super::support::{files, is_blessing, root, simrun};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

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
        if is_blessing() {
            text.replace_range(from..to, &table);
        } else {
            assert_eq!(
                &text[from..to],
                table,
                "SIMRUN_BLESS=1 cargo test --release --test it documents:: writes it anew"
            );
        }
    }
    if is_blessing() {
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

#[test]
fn the_pictures_of_the_papers_are_those_of_the_commands_on_their_pages() {
    for paper in ["qin2026", "zhu2025", "zhao2025", "hu2024"] {
        let folder = root().join("docs/papers");
        let page = fs::read_to_string(folder.join(format!("{paper}.md"))).unwrap();
        let command = page.split("`simrun draw ").nth(1).unwrap().split('`').next().unwrap();
        let arguments = command.split_whitespace().chain(["-o", "-"]);
        let answer = simrun(root()).arg("draw").args(arguments).answer();
        assert_eq!(answer.code, 0, "{answer:?}");
        let picture = folder.join(format!("{paper}.svg"));
        if is_blessing() {
            fs::write(&picture, &answer.stdout).unwrap();
        }
        assert!(fs::read_to_string(&picture).unwrap() == answer.stdout, "{paper}: bless if that is meant");
    }
    // The states in which the planner does not just follow its path.
    for (paper, marked, plain) in
        [("qin2026", ["avoid", "retreat"], "follow"), ("hu2024", ["brake", "follow"], "track")]
    {
        let picture = fs::read_to_string(root().join(format!("docs/papers/{paper}.svg"))).unwrap();
        let is_marked = |state: &str| picture.contains(&format!(">{state}</text>"));
        assert!(marked.into_iter().all(is_marked) && !is_marked(plain), "{paper}");
    }
}

/// The documents of the repository, results of runs left out.
fn documents() -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(root()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        let is_hidden = name.starts_with('.');
        if path.is_dir() && !is_hidden && !["target", "results"].contains(&name) {
            found.extend(files(&path, "md"));
        } else if path.extension().is_some_and(|ending| ending == "md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Every text behind a back quote, a bracket or a space that looks like a path from the root of this repository.
fn named_paths(text: &str) -> Vec<String> {
    let starts = ["src/", "tests/", "scenarios/", "scripts/", "docs/", "benches/", "examples/", "results/reference"];
    let mut paths = Vec::new();
    for (at, _) in text.match_indices(['`', '(', ' ']) {
        let rest = &text[at + 1..];
        if starts.iter().any(|start| rest.starts_with(start)) {
            let end = rest.find(|c: char| !(c.is_alphanumeric() || "/_.-*{}".contains(c))).unwrap_or(rest.len());
            paths.push(rest[..end].trim_end_matches('.').to_owned());
        }
    }
    paths
}

/// The targets of links to files, which are relative to the document.
fn linked_paths(text: &str) -> Vec<String> {
    let targets = text.match_indices("](").map(|(at, found)| &text[at + found.len()..]);
    let targets = targets.filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
    let targets = targets.filter_map(|target| target.split('#').next());
    targets.filter(|target| !target.is_empty() && !target.contains("://")).map(str::to_owned).collect()
}

/// The paths that a document names and that are not in the repository.
fn missing(document: &Path, text: &str) -> Vec<String> {
    // Written by the reader's own runs and files; patterns and alternatives stand for several files.
    let is_ours = |path: &String| {
        !(path.contains("my_planner") || path.contains('*') || path.contains('{') || path.ends_with("episodes.csv"))
    };
    let named = named_paths(text).into_iter().filter(is_ours).map(|path| (root().join(&path), path));
    let folder = document.parent().unwrap();
    let linked = linked_paths(text).into_iter().map(|path| (folder.join(&path), path));
    named.chain(linked).filter(|(file, _)| !file.exists()).map(|(_, path)| path).collect()
}

#[test]
fn every_path_that_a_document_names_exists() {
    let (mut count, mut broken) = (0, Vec::new());
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        count += named_paths(&text).len() + linked_paths(&text).len();
        for path in missing(&document, &text) {
            broken.push(format!("{} names {path}", document.strip_prefix(root()).unwrap().display()));
        }
    }
    assert!(broken.is_empty(), "which do not exist:\n{}", broken.join("\n"));
    assert!(count > 50, "the test found only {count} paths: does it still look in the right places?");
}

#[test]
fn a_path_that_does_not_exist_is_found() {
    let document = root().join("docs/planning.md");
    let text = "`src/lib.rs`, [a page](performance.md#speed), (docs/nowhere.md), `tests/nowhere.rs`: see [b](nowhere.csv) \
                and [c](https://example.com/docs/x.md).";
    assert_eq!(missing(&document, text), ["docs/nowhere.md", "tests/nowhere.rs", "nowhere.csv"]);
}

/// `cargo test --test NAME` in documents, scripts and comments names a target that exists.
#[test]
fn every_test_target_that_a_document_names_exists() {
    let mut texts = documents();
    texts.extend(["src", "tests"].iter().flat_map(|folder| files(&root().join(folder), "rs")));
    let mut count = 0;
    for file in texts {
        let text = fs::read_to_string(&file).unwrap();
        // This file speaks of the option itself.
        if file.ends_with("documents.rs") {
            continue;
        }
        for (at, option) in text.match_indices("--test ") {
            let mut words = text[at + option.len()..].split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
            let (target, module) = (words.next().unwrap(), words.next().unwrap_or_default());
            let place = file.display();
            let has = |path: String| root().join("tests").join(path).exists();
            assert!(has(format!("{target}.rs")) || has(format!("{target}/main.rs")), "{place} names --test {target}");
            if let Some(module) = module.strip_suffix("::") {
                assert!(has(format!("{target}/{module}.rs")), "{place} names the tests {module}");
            }
            count += 1;
        }
    }
    assert!(count >= 5, "only {count} mentions: does the test still look in the right places?");
}

#[test]
fn the_keys_on_the_page_of_changes_bring_back_the_drives_of_version_0_1() {
    let page = fs::read_to_string(root().join("docs/changes-0.2.md")).unwrap();
    let block = page.split("```text\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let scratch = tempfile::tempdir().unwrap();
    fs::write(scratch.path().join("as_0_1.yaml"), block).unwrap();
    let out = simrun(scratch.path()).args(["as_0_1.yaml", "--quiet", "--out", "out"]).ends_with(0);
    assert!(out.stderr.is_empty(), "{out:?}");
    let rows: Vec<BTreeMap<String, String>> = csv::Reader::from_path(scratch.path().join("out/episodes.csv"))
        .unwrap()
        .deserialize()
        .map(Result::unwrap)
        .collect();
    // The page's table holds what version 0.1.0 printed.
    let printed: Vec<Vec<&str>> = page
        .lines()
        .filter(|line| line.starts_with("| `a_star+"))
        .map(|line| line.split('|').map(|cell| cell.trim().trim_matches('`')).collect())
        .collect();
    assert_eq!((rows.len(), printed.len()), (12, 12));
    for row in &rows {
        let found = printed.iter().find(|cells| cells[1] == row["stack"] && cells[2] == row["episode"]).unwrap();
        assert_eq!(found[3..6], [row["outcome"].as_str(), row["time_s"].as_str(), row["length_m"].as_str()]);
    }
}
