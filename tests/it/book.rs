//! The pages of the guide (`docs/book/src`) that are made from the code, and the order of its pages.
//!
//! `SIMRUN_BLESS=1 cargo test --release --test it -- book::` writes them anew.

use super::support::{files, is_blessing, root};
use simrun::plan::{Entry, global::GlobalChoice, local::LocalChoice, path::PathChoice};
use simrun::scenario::reference;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

const MADE: &str =
    "<!-- Made from the code: SIMRUN_BLESS=1 cargo test --release --test it -- book:: writes it anew. -->";

fn source() -> PathBuf {
    root().join("docs/book/src")
}

/// Compares a text with that of a file, or writes it there.
fn compare(path: &PathBuf, text: &str) {
    if is_blessing() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    let found = fs::read_to_string(path).unwrap_or_default();
    let place = path.strip_prefix(root()).unwrap().display();
    assert!(
        found == text,
        "{place} is not what the code says: SIMRUN_BLESS=1 cargo test --release --test it -- book::"
    );
}

/// The text of a file with what is between its marks `<!-- name -->` and `<!-- /name -->` replaced.
fn with_part(path: &PathBuf, name: &str, part: &str) -> String {
    let mut text = fs::read_to_string(path).unwrap();
    let (open, close) = (format!("<!-- {name} -->\n"), format!("<!-- /{name} -->"));
    let from = text.find(&open).unwrap_or_else(|| panic!("{} has no {open}", path.display())) + open.len();
    let to = text.find(&close).unwrap();
    text.replace_range(from..to, part);
    text
}

/// One kind of planners: its word, the folder and key of its planners, their names and entries.
struct Kind {
    word: &'static str,
    folder: &'static str,
    names: &'static [&'static str],
    entries: &'static [Entry],
}

const KINDS: [Kind; 3] = [
    Kind { word: "Global planner", folder: "global", names: GlobalChoice::NAMES, entries: GlobalChoice::ENTRIES },
    Kind { word: "Path stage", folder: "path", names: PathChoice::NAMES, entries: PathChoice::ENTRIES },
    Kind { word: "Local planner", folder: "local", names: LocalChoice::NAMES, entries: LocalChoice::ENTRIES },
];

fn planners() -> impl Iterator<Item = (&'static Kind, &'static str, &'static Entry)> {
    KINDS.iter().flat_map(|kind| kind.names.iter().zip(kind.entries).map(move |(name, entry)| (kind, *name, entry)))
}

/// The documentation at the top of a planner's file.
fn module_documentation(kind: &Kind, name: &str) -> String {
    let folder = root().join("src/plan").join(kind.folder);
    let file =
        [folder.join(format!("{name}.rs")), folder.join(name).join("mod.rs")].into_iter().find(|file| file.exists());
    let text = fs::read_to_string(file.unwrap()).unwrap();
    let lines = text.lines().map_while(|line| line.strip_prefix("//!"));
    lines.map(|line| line.strip_prefix(' ').unwrap_or(line)).fold(String::new(), |text, line| text + line + "\n")
}

/// The documentation with the links of rustdoc turned into those of the guide.
fn for_the_guide(documentation: &str) -> String {
    let mut text = String::new();
    let mut rest = documentation;
    while let Some(at) = rest.find("[`") {
        text.push_str(&rest[..at]);
        let Some((name, after)) = rest[at + 2..].split_once("`]") else { break };
        let target = after.strip_prefix('(').and_then(|after| after.split_once(')'));
        rest = target.map_or(after, |(_, after)| after);
        let is_planner = target.is_some() && planners().any(|(_, known, _)| known == name);
        text += &if is_planner { format!("[`{name}`]({name}.md)") } else { format!("`{name}`") };
    }
    text.push_str(rest);
    let papers = "[systems.md](../papers/systems.md)";
    let text = text.replace("`docs/book/src/papers/systems.md`", papers).replace("`systems.md`", papers);
    text.replace("Parameters: `Params`.\n", "").trim_end().to_owned()
}

/// A text that begins with a capital.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().into_iter().flat_map(char::to_uppercase).chain(letters).collect()
}

fn page(kind: &Kind, name: &str, entry: &Entry) -> String {
    let documentation = for_the_guide(&module_documentation(kind, name));
    // The first line opens with the planner's name, which is the title of the page.
    let documentation = documentation.strip_prefix(&format!("`{name}`: ")).unwrap_or(&documentation);
    let documentation = capital(documentation);
    let parameters = reference::section(&format!("stacks.{}.{name}", kind.folder)).unwrap();
    let folder = kind.folder;
    format!(
        "# `{name}`\n\n{MADE}\n\n*{}.* {}\n\n\
         ![What {name} does](../pictures/{name}.svg)\n\n\
         `simrun draw docs/book/pictures/{folder}.yaml --stack {name}`\n\n\
         ## How it works\n\n{documentation}\n\n\
         ## Parameters\n\n{}\n",
        kind.word,
        entry.summary,
        parameters.trim_end(),
    )
}

#[test]
fn every_planner_has_its_page() {
    let folder = source().join("planners");
    for (kind, name, entry) in planners() {
        compare(&folder.join(format!("{name}.md")), &page(kind, name, entry));
    }
    let index = folder.join("index.md");
    let mut table = String::from("| | planner | what | source |\n|---|---|---|---|\n");
    for (kind, name, entry) in planners() {
        let _ = writeln!(table, "| {} | [`{name}`]({name}.md) | {} | {} |", kind.folder, entry.summary, entry.source);
    }
    compare(&index, &with_part(&index, "planners", &table));
    let known: BTreeSet<String> = planners().map(|(_, name, _)| format!("{name}.md")).collect();
    for file in files(&folder, "md") {
        let name = file.file_name().unwrap().to_str().unwrap();
        assert!(name == "index.md" || known.contains(name), "planners/{name} describes no planner of the registry");
    }
}

#[test]
fn every_planner_has_its_picture() {
    for kind in &KINDS {
        let file = format!("docs/book/pictures/{}.yaml", kind.folder);
        let text = fs::read_to_string(root().join(&file)).unwrap();
        let scenario = simrun::scenario::ScenarioFile::from_text(&file, &text);
        let scenario = scenario.read(&[]).unwrap_or_else(|error| panic!("{error}"));
        let stacks: Vec<String> = scenario.stacks().into_iter().map(|stack| stack.name).collect();
        for name in kind.names {
            assert!(stacks.iter().any(|stack| stack == name), "{file} has no stack {name}");
        }
    }
}

#[test]
fn links_of_rustdoc_become_those_of_the_guide() {
    let text = "As [`dwa`](super::dwa) with [`Params`] (`systems.md` §3), see [`window`](super::window).\n\nParameters: [`Params`].\n";
    let expected = "As [`dwa`](dwa.md) with `Params` ([systems.md](../papers/systems.md) §3), see `window`.";
    assert_eq!(for_the_guide(text), expected);
}

#[test]
fn the_page_of_results_has_every_column() {
    let path = source().join("results.md");
    compare(&path, &with_part(&path, "columns", &simrun::results::columns()));
}

/// The numbered lessons and the main scenario, by file name.
fn lessons() -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(root().join("scenarios"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter_map(|name| name.strip_suffix(".yaml").map(str::to_owned))
        .collect();
    names.sort();
    names
}

/// What the comment at the top of a scenario says, by its words: the title, `Shows`, `Should happen` and, if need be, `Picture`.
fn header(name: &str) -> BTreeMap<&'static str, String> {
    let text = fs::read_to_string(root().join("scenarios").join(format!("{name}.yaml"))).unwrap();
    let lines = text.lines().map_while(|line| line.strip_prefix('#')).skip(1).map(str::trim);
    let words = [
        ("Shows: ", "Shows"),
        ("What it shows: ", "Shows"),
        ("Should happen: ", "Should happen"),
        ("What should happen: ", "Should happen"),
        ("Picture: ", "Picture"),
    ];
    let mut parts = BTreeMap::from([("title", String::new())]);
    let mut part = "title";
    for line in lines {
        let named = words.iter().find_map(|(word, name)| Some((*name, line.strip_prefix(word)?)));
        let (name, line) = named.unwrap_or((part, line));
        part = name;
        let text: &mut String = parts.entry(part).or_default();
        if !text.is_empty() && !line.is_empty() {
            text.push(' ');
        }
        text.push_str(line);
    }
    parts
}

#[test]
fn the_gallery_shows_every_lesson() {
    let mut page = format!(
        "# Lessons\n\n{MADE}\n\nEach scenario of the folder `scenarios/` shows one thing. The comment at its top says what it shows and what should happen; \
         this page repeats it, with a picture of one drive. Run a lesson, then change it.\n\n"
    );
    for name in lessons() {
        let parts = header(&name);
        let part = |word: &str| parts.get(word).unwrap_or_else(|| panic!("{name}.yaml does not say `{word}: `"));
        let title = part("title").trim_end_matches('.');
        let title =
            title.strip_prefix("Lesson ").and_then(|rest| rest.split_once(": ")).map_or(title, |(_, title)| title);
        let number = name.split('_').next().and_then(|number| number.parse::<u32>().ok());
        let title = capital(title);
        let heading = number.map_or(title.clone(), |number| format!("{number}. {title}"));
        let options = parts.get("Picture").map_or(String::new(), |options| format!(" {options}"));
        let _ = write!(
            page,
            "## {heading}\n\n{}\n\n**What should happen:** {}\n\n![{title}](pictures/{name}.svg)\n\n\
             `simrun draw scenarios/{name}.yaml{options}`\n\n",
            capital(part("Shows")),
            part("Should happen"),
        );
    }
    compare(&source().join("lessons.md"), &(page.trim_end().to_owned() + "\n"));
}

/// The targets of the links of `SUMMARY.md`, in order.
fn chapters(summary: &str) -> Vec<&str> {
    let targets = summary.split("](").skip(1).map(|rest| rest.split(')').next().unwrap());
    targets.collect()
}

#[test]
fn every_page_is_a_chapter_of_the_guide() {
    let path = source().join("SUMMARY.md");
    let summary = fs::read_to_string(&path).unwrap();
    // The lines of the planners stand together; they are written from the registry.
    let is_planner = |line: &&str| line.contains("](planners/") && !line.contains("index.md");
    let first = summary.lines().position(|line| is_planner(&line)).unwrap_or(usize::MAX);
    let mut lines: Vec<String> = summary.lines().filter(|line| !is_planner(line)).map(str::to_owned).collect();
    let at = first.min(1 + lines.iter().position(|line| line.contains("](planners/index.md")).unwrap());
    let of_planners = planners().map(|(_, name, _)| format!("  - [`{name}`](planners/{name}.md)"));
    lines.splice(at..at, of_planners.collect::<Vec<_>>());
    compare(&path, &(lines.join("\n") + "\n"));

    let summary = fs::read_to_string(&path).unwrap();
    let listed = chapters(&summary);
    let distinct: BTreeSet<&str> = listed.iter().copied().collect();
    assert_eq!(listed.len(), distinct.len(), "a page stands in SUMMARY.md twice");
    let pages = files(&source(), "md")
        .into_iter()
        .map(|file| file.strip_prefix(source()).unwrap().to_str().unwrap().replace('\\', "/"));
    let pages: BTreeSet<String> = pages.filter(|page| page != "SUMMARY.md").collect();
    assert_eq!(
        pages.iter().map(String::as_str).collect::<BTreeSet<_>>(),
        distinct,
        "pages (left) and chapters of SUMMARY.md (right)"
    );
}
