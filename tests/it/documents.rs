//! Checks that the files and names that the documents mention exist.

use super::support::{files, is_blessing, root, simrun};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The blocks of a page that open with this line, without their fences.
fn blocks<'a>(page: &'a str, opening: &str) -> Vec<&'a str> {
    let opening = format!("```{opening}\n");
    page.split(opening.as_str()).skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

#[test]
fn scenarios_that_the_guide_shows_are_valid() {
    let mut count = 0;
    for page in files(&guide(), "md") {
        let text = fs::read_to_string(&page).unwrap();
        // A block `yaml file=NAME` is a whole scenario, which the commands of the page run.
        for (at, opening) in text.match_indices("```yaml file=") {
            let (name, rest) = text[at + opening.len()..].split_once('\n').unwrap();
            // Files of the map that it names are beside it when the page's commands run.
            let yaml = rest.split("```").next().unwrap();
            if !yaml.contains("stacks:") || yaml.contains("file:") {
                continue;
            }
            let file = simrun::scenario::ScenarioFile::from_text(name, yaml);
            let scenario = file.read(&[]).unwrap_or_else(|error| panic!("{}: {error}", page.display()));
            file.check(&scenario, &[]).unwrap_or_else(|error| panic!("{}: {error}", page.display()));
            count += 1;
        }
    }
    assert!(count >= 3, "only {count} scenarios: does the test still look in the right places?");
}

/// `scripts/book commands` compares the page's table with what the program prints.
#[test]
fn the_table_of_the_readme_is_that_of_the_guide() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let page = fs::read_to_string(guide().join("first-table.md")).unwrap();
    assert!(page.contains(blocks(&readme, "text")[0]));
}

#[test]
fn the_readme_is_short() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    assert!(readme.lines().count() < 150);
}

#[test]
fn the_pictures_of_the_pages_are_those_of_the_commands_on_them() {
    let scratch = tempfile::tempdir().unwrap();
    for (page, picture) in [
        ("README.md", "docs/warehouse.gif"),
        ("docs/book/src/maps.md", "docs/book/src/maps/barn_120.svg"),
        ("docs/book/src/papers/qin2026.md", "docs/book/src/papers/qin2026.svg"),
        ("docs/book/src/papers/zhu2025.md", "docs/book/src/papers/zhu2025.svg"),
        ("docs/book/src/papers/zhao2025.md", "docs/book/src/papers/zhao2025.svg"),
        ("docs/book/src/papers/hu2024.md", "docs/book/src/papers/hu2024.svg"),
    ] {
        let text = fs::read_to_string(root().join(page)).unwrap();
        let command = text.split("`simrun draw scenarios").nth(1).unwrap().split('`').next().unwrap();
        let command = format!("scenarios{command}");
        let arguments = command.split_whitespace().take_while(|word| *word != "-o");
        let picture = root().join(picture);
        let drawn = scratch.path().join(picture.file_name().unwrap());
        simrun(root()).arg("draw").args(arguments).arg("-o").arg(&drawn).ends_with(0);
        if is_blessing() {
            fs::copy(&drawn, &picture).unwrap();
        }
        assert!(
            fs::read(&picture).unwrap() == fs::read(&drawn).unwrap(),
            "{}: bless if that is meant",
            picture.display()
        );
    }
    // The states in which the planner does not just follow its path.
    for (paper, marked, plain) in
        [("qin2026", ["avoid", "retreat"], "follow"), ("hu2024", ["brake", "follow"], "track")]
    {
        let picture = fs::read_to_string(root().join(format!("docs/book/src/papers/{paper}.svg"))).unwrap();
        let is_marked = |state: &str| picture.contains(&format!(">{state}</text>"));
        assert!(marked.into_iter().all(is_marked) && !is_marked(plain), "{paper}");
    }
}

/// The folder of the guide's pages.
fn guide() -> PathBuf {
    root().join("docs/book/src")
}

/// The documents of the repository, results of runs left out.
fn documents() -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(root()).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        let is_hidden = name.starts_with('.');
        if path.is_dir() && !is_hidden && !["target", "results", "node_modules"].contains(&name) {
            found.extend(files(&path, "md"));
        } else if path.extension().is_some_and(|ending| ending == "md") {
            found.push(path);
        }
    }
    found.push(root().join("llms.txt"));
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
            let path = rest[..end].trim_end_matches('.');
            // The end of a block in braces that opened before the path.
            let path = if path.contains('{') { path } else { path.trim_end_matches('}') };
            paths.push(path.to_owned());
        }
    }
    paths
}

/// The lines of a document outside of its blocks of code.
fn prose(text: &str) -> String {
    let mut inside = false;
    let lines = text.lines().filter(|line| {
        let is_fence = line.trim_start().starts_with("```");
        inside ^= is_fence;
        !inside && !is_fence
    });
    lines.fold(String::new(), |text, line| text + line + "\n")
}

/// The targets of links within the repository: a path relative to the document, and behind `#` a heading.
fn links(text: &str) -> Vec<(String, Option<String>)> {
    let text = prose(text);
    let targets = text.match_indices("](").map(|(at, found)| &text[at + found.len()..]);
    let targets = targets.filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
    let targets = targets.filter(|target| !target.contains("://") && !target.contains(char::is_whitespace));
    let parts = targets.map(|target| target.split_once('#').map_or((target, None), |(path, at)| (path, Some(at))));
    parts.map(|(path, at)| (path.to_owned(), at.map(str::to_owned))).collect()
}

/// The paths of those links.
fn linked_paths(text: &str) -> Vec<String> {
    links(text).into_iter().map(|(path, _)| path).filter(|path| !path.is_empty()).collect()
}

/// The anchors of a document's headings, as GitHub and mdBook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for line in prose(text).lines().filter(|line| line.starts_with('#')) {
        let heading = line.trim_start_matches('#').trim().to_lowercase();
        let name: String = heading
            .chars()
            .filter(|c| c.is_alphanumeric() || " _-".contains(*c))
            .map(|c| if c == ' ' { '-' } else { c })
            .collect();
        // The second of equal headings is called NAME-1.
        let numbered = (1..).map(|n| format!("{name}-{n}"));
        let free = std::iter::once(name.clone()).chain(numbered).find(|name| !found.contains(name));
        found.extend(free);
    }
    found
}

/// Pictures that `scripts/book` draws when it builds the guide, by the command on the line below each.
fn drawn_pictures(text: &str) -> Vec<(String, String)> {
    let lines: Vec<&str> = text.lines().filter(|line| !line.is_empty()).collect();
    let mut found = Vec::new();
    for pair in lines.windows(2) {
        let Some(target) = linked_paths(pair[0]).into_iter().find(|target| is_drawn(target)) else { continue };
        let command =
            pair[1].strip_prefix("`simrun ").and_then(|rest| rest.split_once('`')).map(|(command, _)| command);
        found.push((target, command.unwrap_or_default().to_owned()));
    }
    found
}

fn is_drawn(target: &str) -> bool {
    target.trim_start_matches("../").starts_with("pictures/")
}

/// The paths that a document names and that are not in the repository.
fn missing(document: &Path, text: &str) -> Vec<String> {
    // Written by the reader's own runs and files; patterns and alternatives stand for several files.
    let is_ours = |path: &String| {
        !(path.contains("my_planner")
            || path.ends_with("local/turn_and_drive.rs")
            || path.contains('*')
            || path.contains('{')
            || path.ends_with("episodes.csv"))
    };
    let named = named_paths(text).into_iter().filter(is_ours).map(|path| (root().join(&path), path));
    let folder = document.parent().unwrap();
    let is_of_guide = document.starts_with(guide());
    let linked = linked_paths(text).into_iter().filter(|path| !(is_of_guide && is_drawn(path)));
    let linked = linked.map(|path| (folder.join(&path), path));
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
fn every_heading_that_a_link_names_exists() {
    let (mut count, mut broken) = (0, Vec::new());
    for document in documents() {
        let text = fs::read_to_string(&document).unwrap();
        for (path, heading) in links(&text) {
            let Some(heading) = heading else { continue };
            let target = if path.is_empty() { document.clone() } else { document.parent().unwrap().join(&path) };
            let known = fs::read_to_string(&target).map(|text| anchors(&text)).unwrap_or_default();
            if !known.contains(&heading) {
                broken.push(format!("{} links to {path}#{heading}", document.strip_prefix(root()).unwrap().display()));
            }
            count += 1;
        }
    }
    assert!(broken.is_empty(), "which do not exist:\n{}", broken.join("\n"));
    assert!(count > 50, "the test found only {count} links to headings");
}

#[test]
fn headings_have_the_anchors_of_github() {
    let text = "# A `path.to_key`, and more\n```sh\n# a comment\n```\n## Same\n## Same\n";
    let expected: BTreeSet<String> = ["a-pathto_key-and-more", "same", "same-1"].map(str::to_owned).into();
    assert_eq!(anchors(text), expected);
}

/// A link out of the folder of the guide's pages is dead in the built book.
#[test]
fn pages_of_the_guide_link_to_pages_of_the_guide() {
    for page in files(&guide(), "md") {
        let text = fs::read_to_string(&page).unwrap();
        let depth = page.parent().unwrap().strip_prefix(guide()).unwrap().components().count();
        for path in linked_paths(&text) {
            let up = path.matches("../").count();
            assert!(up <= depth, "{} links to {path}, which is no part of the guide", page.display());
        }
    }
}

#[test]
fn every_picture_that_is_drawn_for_the_guide_stands_above_its_command() {
    let mut count = 0;
    for page in files(&guide(), "md") {
        let text = fs::read_to_string(&page).unwrap();
        let drawn = drawn_pictures(&text);
        assert_eq!(drawn.len(), linked_paths(&text).iter().filter(|path| is_drawn(path)).count(), "{}", page.display());
        for (picture, command) in drawn {
            let file = command.split(' ').find(|word| word.ends_with(".yaml"));
            let exists =
                file.is_some_and(|file| root().join(file).exists() || text.contains(&format!("```yaml file={file}\n")));
            assert!(exists, "{}: `{command}` below {picture} draws no scenario that is here", page.display());
            count += 1;
        }
    }
    assert!(count > 40, "only {count} pictures: does the test still look in the right places?");
}

#[test]
fn a_path_that_does_not_exist_is_found() {
    let document = root().join("docs/book/src/planning.md");
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
    let page = fs::read_to_string(root().join("docs/book/src/changes-0.2.md")).unwrap();
    let block = blocks(&page, "text")[0];
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
