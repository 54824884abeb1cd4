//! Data flows one way: a room (a file or folder of `src/`) names only those above it in the list, and some crates
//! are known to few rooms alone.
//!
//! The sources are read as tokens, so that comments and texts do not count, `use` lists are followed into their
//! braces, and `super` is resolved from the module in which it stands.

use super::support::{files, root};
use std::collections::BTreeSet;
use std::fs;

/// The order of the house, ground first; a folder's own modules may name each other.
const ORDER: [&str; 25] = [
    "math",
    "settings",
    "geometry",
    "rng",
    "clock",
    "digest",
    "guard",
    "command",
    "files",
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

/// A crate that only some rooms may name.
struct Confined {
    name: &'static str,
    rooms: &'static [&'static str],
    /// Unit tests of any room may name it.
    free_in_tests: bool,
}

/// The crates that `Cargo.toml` or the architecture keeps to some rooms.
const CONFINED: [Confined; 14] = [
    Confined { name: "rapier2d", rooms: &["world"], free_in_tests: false },
    Confined { name: "parry2d", rooms: &["world"], free_in_tests: false },
    Confined { name: "serde_yaml", rooms: &["scenario"], free_in_tests: true },
    Confined { name: "clap", rooms: &["cli"], free_in_tests: false },
    Confined { name: "console", rooms: &["cli"], free_in_tests: false },
    Confined { name: "indicatif", rooms: &["cli"], free_in_tests: false },
    Confined { name: "signal_hook", rooms: &["cli"], free_in_tests: false },
    Confined { name: "libm", rooms: &["math"], free_in_tests: false },
    Confined { name: "tiny_skia", rooms: &["report"], free_in_tests: false },
    Confined { name: "ttf_parser", rooms: &["report"], free_in_tests: false },
    Confined { name: "pdf_writer", rooms: &["report"], free_in_tests: false },
    Confined { name: "miniz_oxide", rooms: &["report"], free_in_tests: false },
    Confined { name: "base64", rooms: &["report"], free_in_tests: false },
    Confined { name: "gif", rooms: &["report"], free_in_tests: false },
];

/// Room, crate and the reason for which the room may name it all the same; one that is no longer needed must go.
const EXCEPTIONS: [(&str, &str, &str); 1] =
    [("map", "serde_yaml", "the header of a ROS map is YAML, and maps stand above scenarios")];

#[derive(Debug, Clone, PartialEq, Eq)]
enum Token {
    Word(String),
    /// `::`
    Colons,
    Sign(char),
}

use Token::{Colons, Sign, Word};

fn word(token: Option<&Token>) -> Option<&str> {
    match token {
        Some(Word(word)) => Some(word),
        _ => None,
    }
}

/// The tokens of a source without comments, texts, characters and lifetimes.
fn tokens(source: &str) -> Vec<Token> {
    let chars: Vec<char> = source.chars().collect();
    let (mut tokens, mut at) = (Vec::new(), 0);
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    while at < chars.len() {
        let rest = &chars[at..];
        match rest {
            ['/', '/', ..] => at += rest.iter().position(|c| *c == '\n').unwrap_or(rest.len()),
            ['/', '*', ..] => {
                let (mut depth, mut inside) = (0, 0);
                loop {
                    match &rest[inside..] {
                        ['/', '*', ..] => (depth, inside) = (depth + 1, inside + 2),
                        ['*', '/', ..] => (depth, inside) = (depth - 1, inside + 2),
                        _ => inside += 1,
                    }
                    if depth == 0 || inside >= rest.len() {
                        break;
                    }
                }
                at += inside;
            }
            ['"', ..] => at += quoted(rest, '"'),
            // A character, or a lifetime, which is a word behind a quote.
            ['\'', '\\', ..] => at += quoted(rest, '\''),
            ['\'', _, '\'', ..] => at += 3,
            [':', ':', ..] => {
                tokens.push(Colons);
                at += 2;
            }
            [c, ..] if is_part(*c) => {
                let end = rest.iter().position(|c| !is_part(*c)).unwrap_or(rest.len());
                let word: String = rest[..end].iter().collect();
                let hashes = rest[end..].iter().take_while(|c| **c == '#').count();
                let opens_text = rest.get(end + hashes) == Some(&'"');
                if matches!(&word[..], "r" | "br" | "cr") && opens_text {
                    let close: String = format!("\"{}", "#".repeat(hashes));
                    let text: String = rest[end + hashes + 1..].iter().collect();
                    let length = text.find(&close).map_or(text.len(), |byte| text[..byte].chars().count());
                    at += end + hashes + 1 + length + close.len();
                } else {
                    // `r#name` is a name.
                    if !(word == "r" && hashes == 1) {
                        tokens.push(Word(word));
                    }
                    at += end;
                }
            }
            [c, ..] => {
                if !c.is_whitespace() {
                    tokens.push(Sign(*c));
                }
                at += 1;
            }
            [] => break,
        }
    }
    tokens
}

/// The length of a text or character with its quotes.
fn quoted(chars: &[char], quote: char) -> usize {
    let mut at = 1;
    while at < chars.len() && chars[at] != quote {
        at += if chars[at] == '\\' { 2 } else { 1 };
    }
    at + 1
}

/// The names used in one file.
#[derive(Debug, Default)]
struct Named {
    /// Rooms of this crate; `*` stands for all of them, by a glob or another name of the root.
    rooms: BTreeSet<String>,
    /// First names of paths in production code and in tests, crates among them.
    firsts: BTreeSet<String>,
    firsts_of_tests: BTreeSet<String>,
}

/// Reads one file, whose place under `src/` says in which module it stands.
struct Reader<'t> {
    tokens: &'t [Token],
    /// Modules from the root to where the reader is.
    module: Vec<String>,
    /// Depth of braces at which each inline module began.
    opened: Vec<usize>,
    depth: usize,
    /// Until which token everything is under `#[cfg(test)]`.
    test_until: usize,
    named: Named,
}

/// The modules of a file under `src/`: `plan/stack.rs` is `plan::stack`, `plan/mod.rs` is `plan`.
fn module_of(relative: &str) -> Vec<String> {
    let mut module: Vec<String> = relative.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    module.pop_if(|last| last == "mod");
    module
}

fn read(relative: &str, source: &str) -> Named {
    let tokens = tokens(source);
    let named = Named::default();
    let module = module_of(relative);
    let is_test = module.last().is_some_and(|last| last == "tests");
    let test_until = if is_test { tokens.len() } else { 0 };
    let mut reader = Reader { tokens: &tokens, module, opened: Vec::new(), depth: 0, test_until, named };
    reader.all();
    reader.named
}

impl Reader<'_> {
    fn all(&mut self) {
        let mut at = 0;
        while at < self.tokens.len() {
            at = self.next(at);
        }
    }

    fn get(&self, at: usize) -> Option<&Token> {
        self.tokens.get(at)
    }

    /// Reads what begins at a token and returns where the next begins.
    fn next(&mut self, at: usize) -> usize {
        match &self.tokens[at] {
            Sign('{') => self.depth += 1,
            Sign('}') => {
                self.depth = self.depth.saturating_sub(1);
                if self.opened.last() == Some(&self.depth) {
                    self.opened.pop();
                    self.module.pop();
                }
            }
            Sign('#') if self.is_cfg_test(at) => {
                self.test_until = if self.test_until > at { self.test_until } else { self.end_of_item(at + 7) };
            }
            Word(keyword) if keyword == "mod" => {
                if let (Some(name), Some(Sign('{'))) = (word(self.get(at + 1)), self.get(at + 2)) {
                    let name = name.to_owned();
                    self.opened.push(self.depth);
                    self.module.push(name);
                }
            }
            Word(keyword) if keyword == "use" && self.get(at + 1) != Some(&Sign('<')) => {
                // `use ::name` is a crate.
                let at = at + 1 + usize::from(self.get(at + 1) == Some(&Colons));
                return self.tree(at, &[], at);
            }
            Word(_) if self.get(at + 1) == Some(&Colons) && (at == 0 || !self.continues_a_path(at)) => {
                return self.path(at);
            }
            _ => {}
        }
        at + 1
    }

    /// Whether the word at a token is part of a longer path, a field or a method.
    fn continues_a_path(&self, at: usize) -> bool {
        match &self.tokens[at - 1] {
            Colons => at >= 2 && matches!(self.tokens[at - 2], Word(_) | Sign('>')),
            sign => *sign == Sign('.') && self.get(at.wrapping_sub(2)) != Some(&Sign('.')),
        }
    }

    /// A path of an expression or a type: the words that colons join.
    fn path(&mut self, at: usize) -> usize {
        let (mut words, mut end) = (Vec::new(), at);
        while let Some(next) = word(self.get(end)) {
            words.push(next.to_owned());
            end += 1;
            if self.get(end) != Some(&Colons) {
                break;
            }
            end += 1;
        }
        self.name(&words, at);
        end
    }

    /// A tree of a `use`, behind a prefix; returns the token behind it.
    fn tree(&mut self, mut at: usize, prefix: &[String], start: usize) -> usize {
        let mut words = prefix.to_vec();
        loop {
            match self.get(at) {
                Some(Word(next)) if next == "as" => {
                    // Another name for what was named.
                    at += 2;
                }
                Some(Word(next)) => {
                    words.push(next.clone());
                    at += 1;
                }
                Some(Colons) => at += 1,
                Some(Sign('*')) => {
                    words.push("*".to_owned());
                    at += 1;
                }
                Some(Sign('{')) => {
                    at += 1;
                    while at < self.tokens.len() && self.get(at) != Some(&Sign('}')) {
                        at = self.tree(at, &words, start);
                        at += usize::from(self.get(at) == Some(&Sign(',')));
                    }
                    return at + 1;
                }
                _ => {
                    self.name(&words, start);
                    // A `;` is behind the whole, a `,` or `}` belongs to the list around it.
                    let is_odd = !matches!(self.get(at), Some(Sign(',' | '}' | ';')));
                    return at + usize::from(is_odd);
                }
            }
        }
    }

    /// Notes what a path names. One into this crate counts by its room, any other by its first word.
    fn name(&mut self, words: &[String], at: usize) {
        let mut full = match words.first().map(String::as_str) {
            Some("crate" | "simrun") => Vec::new(),
            Some("self" | "super") => self.module.clone(),
            Some(first) => {
                let is_test = at < self.test_until;
                let firsts = if is_test { &mut self.named.firsts_of_tests } else { &mut self.named.firsts };
                firsts.insert(first.to_owned());
                return;
            }
            None => return,
        };
        for word in words {
            match &word[..] {
                "crate" | "simrun" | "self" => {}
                "super" => {
                    full.pop();
                }
                _ => full.push(word.clone()),
            }
        }
        // The root itself, by whatever name, is a door to every room.
        self.named.rooms.insert(full.first().map_or("*", String::as_str).to_owned());
    }

    fn is_cfg_test(&self, at: usize) -> bool {
        let expected = [Sign('#'), Sign('['), Word("cfg".into()), Sign('('), Word("test".into()), Sign(')'), Sign(']')];
        self.tokens[at..].starts_with(&expected)
    }

    /// The end of the item that begins at a token: a `;` outside all brackets, or the brace that closes its first one.
    fn end_of_item(&self, from: usize) -> usize {
        let mut depth = 0;
        for (at, token) in self.tokens.iter().enumerate().skip(from) {
            match token {
                Sign('(' | '[' | '{') => depth += 1,
                Sign(')' | ']') => depth -= 1,
                Sign('}') => {
                    depth -= 1;
                    if depth == 0 {
                        return at + 1;
                    }
                }
                Sign(';') if depth == 0 => return at + 1,
                _ => {}
            }
        }
        self.tokens.len()
    }
}

/// The faults of one file; the exceptions that it needs are added to `needed`.
fn faults(relative: &str, source: &str, needed: &mut BTreeSet<(&'static str, &'static str)>) -> Vec<String> {
    let module = module_of(relative);
    let room = &module[0];
    let Some(floor) = ORDER.iter().position(|name| name == room) else {
        return vec![format!("{room} has no place in the order: add it")];
    };
    let named = read(relative, source);
    let mut faults = Vec::new();
    for other in &named.rooms {
        match ORDER.iter().position(|name| name == other) {
            Some(other_floor) if other_floor > floor => {
                faults.push(format!("{relative} names {other}, which stands below it"));
            }
            None if other == "*" => {
                faults.push(format!("{relative} imports the root of the crate, and so every room: name them"));
            }
            _ => {}
        }
    }
    for confined in &CONFINED {
        let in_tests = !confined.free_in_tests && named.firsts_of_tests.contains(confined.name);
        if !(in_tests || named.firsts.contains(confined.name)) || confined.rooms.contains(&&room[..]) {
            continue;
        }
        match EXCEPTIONS.iter().find(|(excepted, name, _)| excepted == room && *name == confined.name) {
            Some(&(excepted, name, _)) => {
                needed.insert((excepted, name));
            }
            None => faults.push(format!("{relative} names {}, which is for {:?} alone", confined.name, confined.rooms)),
        }
    }
    faults
}

#[test]
fn a_room_names_only_those_above_it_and_no_crate_that_is_kept_from_it() {
    let src = root().join("src");
    let (mut seen, mut broken, mut needed) = (BTreeSet::new(), Vec::new(), BTreeSet::new());
    for file in files(&src, "rs") {
        let relative = file.strip_prefix(&src).unwrap().to_str().unwrap().replace('\\', "/");
        if relative == "lib.rs" || relative == "main.rs" {
            continue;
        }
        seen.insert(module_of(&relative)[0].clone());
        broken.extend(faults(&relative, &fs::read_to_string(&file).unwrap(), &mut needed));
    }
    assert!(broken.is_empty(), "{broken:#?}");
    for room in ORDER {
        assert!(seen.contains(room), "{room} is in the order but not in src");
    }
    for (room, name, reason) in EXCEPTIONS {
        assert!(needed.contains(&(room, name)), "{room} no longer names {name} ({reason}): delete the exception");
    }
}

/// Ways to open a file for reading, as type or module and function; `files` alone may take them.
const OPENINGS: [(&str, &str); 9] = [
    ("fs", "read"),
    ("fs", "read_to_string"),
    ("File", "open"),
    ("File", "open_buffered"),
    ("ImageReader", "open"),
    ("image", "open"),
    ("image", "load"),
    ("Reader", "from_path"),
    ("ReaderBuilder", "from_path"),
];

/// The ways to open a file that production code takes; its tests stand behind it.
fn openings(source: &str) -> Vec<(&'static str, &'static str)> {
    let tokens = tokens(source);
    let tests = [Sign('#'), Sign('['), Word("cfg".into()), Sign('('), Word("test".into()), Sign(')'), Sign(']')];
    let of_tests = tokens.windows(8).position(|part| part[..7] == tests && part[7] == Word("mod".into()));
    let production = &tokens[..of_tests.unwrap_or(tokens.len())];
    let takes = |&(owner, name): &(&str, &str)| {
        production.iter().enumerate().any(|(at, token)| {
            let rest = &production[at..];
            let is_path = word(Some(token)) == Some(owner) && rest.get(1) == Some(&Colons);
            // `use std::fs::{…}` and `.from_path(…)` of a builder.
            let listed = rest.iter().skip(3).take_while(|token| **token != Sign('}'));
            let in_list =
                rest.get(2) == Some(&Sign('{')) && listed.into_iter().any(|token| word(Some(token)) == Some(name));
            let is_method = name == "from_path" && *token == Sign('.') && word(rest.get(1)) == Some(name);
            is_path && (word(rest.get(2)) == Some(name) || in_list) || is_method
        })
    };
    OPENINGS.into_iter().filter(takes).collect()
}

#[test]
fn files_are_opened_for_reading_in_one_room() {
    let src = root().join("src");
    for file in files(&src, "rs") {
        let relative = file.strip_prefix(&src).unwrap().to_str().unwrap().replace('\\', "/");
        let is_test = ["tests.rs", "support.rs"].iter().any(|name| relative.ends_with(name));
        let found = openings(&fs::read_to_string(&file).unwrap());
        if relative == "files.rs" {
            assert_eq!(found, [("File", "open")]);
        } else {
            assert!(is_test || found.is_empty(), "{relative} opens files by {found:?}: `files` is the place for it");
        }
    }
    for (source, expected) in [
        ("fn f() { std::fs::read(path); }", ("fs", "read")),
        ("use std::fs::{self, read_to_string};", ("fs", "read_to_string")),
        ("fn f() { csv::ReaderBuilder::new().from_path(path); }", ("Reader", "from_path")),
        ("fn f() -> io::Result<File> { File::open(path) }", ("File", "open")),
    ] {
        assert!(openings(source).contains(&expected), "{source}");
    }
    for source in ["fs::read_dir(folder)", "files::open(path, 1)", "#[cfg(test)]\nmod tests { fs::read(path) }"] {
        assert!(openings(source).is_empty(), "{source}");
    }
}

/// With the rooms re-exported at the root, `crate::World` would be no room's name.
#[test]
fn the_root_of_the_crate_holds_rooms_and_no_other_names() {
    let tokens = tokens(&fs::read_to_string(root().join("src/lib.rs")).unwrap());
    assert!(!tokens.contains(&Word("use".to_owned())), "src/lib.rs imports or re-exports something");
    let rooms: BTreeSet<&str> = tokens
        .windows(2)
        .filter(|pair| pair[0] == Word("mod".to_owned()))
        .filter_map(|pair| word(pair.get(1)))
        .collect();
    assert_eq!(rooms, BTreeSet::from(ORDER), "the rooms of src/lib.rs and those of the order");
}

#[test]
fn planners_never_see_the_world() {
    let src = root().join("src");
    for file in files(&src.join("plan"), "rs") {
        let relative = file.strip_prefix(&src).unwrap().to_str().unwrap();
        let named = read(relative, &fs::read_to_string(&file).unwrap());
        assert!(!named.rooms.contains("world"), "{relative} names the world");
    }
}

#[test]
fn what_breaks_the_order_is_refused_in_every_spelling() {
    let refused = |relative: &str, source: &str, expected: &str| {
        let faults = faults(relative, source, &mut BTreeSet::new());
        assert!(faults.len() == 1 && faults[0].contains(expected), "{relative}: {source}\n{faults:?}");
    };
    for source in [
        "use crate::world::World;",
        "use crate::world;",
        "use crate::{math, world::World};",
        "use crate::{math::{self, max}, world::{World, Scene}};",
        "pub(crate) use crate::{\n    geometry::Vec2,\n    world::World,\n};",
        "fn f(world: &crate::world::World) {}",
        "fn f() -> Vec<crate::world::World> { Vec::new() }",
        "use simrun::world::World;",
        "macro_rules! m { () => { $crate::world::World::new() }; }",
        "#[cfg(test)]\nmod tests {\n    use crate::world::World;\n}",
        "/* a comment */ use /* inside */ crate::world::World;",
        "const A: &str = \"a \\\" quote\"; const B: char = '\"'; use crate::world::World; const C: char = '\"';",
        "const A: &str = r#\"a \" quote\"#; use crate::world::World;",
        "fn f<'a>(a: &'a str) -> &'a str { crate::world::name(a) }",
    ] {
        refused("plan/stack.rs", source, "names world");
        refused("geometry.rs", source, "names world");
    }
    // In a file of the root `super` is the root.
    refused("geometry.rs", "use super::world::World;", "names world");
    refused("geometry.rs", "use super::{math, world::World};", "names world");
    refused("geometry.rs", "fn f(world: super::world::World) {}", "names world");
    refused("plan/mod.rs", "use super::world::World;", "names world");
    refused("plan/stack.rs", "use super::super::world::World;", "names world");
    refused("plan/stack.rs", "use super::{grid, super::world::{World}};", "names world");
    refused("plan/stack.rs", "use self::super::super::world::World;", "names world");
    refused("plan/local/dwa.rs", "fn f(world: &super::super::super::world::World) {}", "names world");
    refused("plan/stack.rs", "mod tests { use super::super::super::world::World; }", "names world");
    refused(
        "plan/stack.rs",
        "mod a { mod b {} fn f() { if true { super::super::super::world::f() } } }",
        "names world",
    );
    // Doors to every room.
    for source in
        ["use super::*;", "use super as root;", "use crate::*;", "use crate as root;", "use crate::{self as root};"]
    {
        refused("geometry.rs", source, "root of the crate");
    }
    refused("plan/stack.rs", "use super::super::*;", "root of the crate");
    refused("plan/stack.rs", "mod tests { use super::super::super::*; }", "root of the crate");
    refused("attic.rs", "", "no place in the order");
}

#[test]
fn what_keeps_the_order_is_allowed() {
    for (relative, source) in [
        ("plan/stack.rs", "use crate::{geometry::Vec2, map::Cell};\nuse super::grid::{PlanningGrid, world::World};"),
        ("plan/stack.rs", "use super::super::map::Cell;"),
        (
            "plan/stack.rs",
            "// use crate::world::World;\n/// See [`crate::world::World`].\n/* crate::world */ fn f() {}",
        ),
        ("plan/stack.rs", "const A: &str = \"crate::world::World\"; const B: &str = r#\"use crate::world::X;\"#;"),
        ("plan/stack.rs", "mod tests { use super::*; fn world() { let world = 1; super::world(world); } }"),
        ("plan/stack.rs", "mod world { pub struct World; } use self::world::World; use world::World as Other;"),
        (
            "geometry.rs",
            "pub(super) fn f() {} pub(crate) fn g(self: &Self) {} #[cfg(test)] mod tests { use super::*; }",
        ),
        ("world/mod.rs", "use rapier2d::prelude::*; use super::plan::stack::Stack;"),
        ("scenario/mod.rs", "use serde_yaml::Value; use crate::world::World;"),
        ("plan/local/dwa.rs", "#[cfg(test)] mod tests { fn f() { serde_yaml::from_str(\"1\") } }"),
        ("plan/local/tests.rs", "use serde_yaml::Value;"),
        ("plan/local/dwa.rs", "struct S { clap: u8 } fn f(s: S) { let libm = s.clap; other::clap::parse(libm) }"),
    ] {
        let faults = faults(relative, source, &mut BTreeSet::new());
        assert!(faults.is_empty(), "{relative}: {source}\n{faults:?}");
    }
}

#[test]
fn crates_are_refused_where_they_do_not_belong() {
    for (relative, source, name) in [
        ("trace.rs", "use serde_yaml::Value;", "serde_yaml"),
        ("trace.rs", "use serde_yaml;", "serde_yaml"),
        ("trace.rs", "use ::serde_yaml as yaml;", "serde_yaml"),
        ("trace.rs", "fn f(v: &serde_yaml::Value) {}", "serde_yaml"),
        ("trace.rs", "fn f(v: &::serde_yaml::Value) {}", "serde_yaml"),
        ("trace.rs", "#[cfg(test)] use serde_yaml::Value; use serde_yaml::Mapping;", "serde_yaml"),
        ("trace.rs", "#[cfg(test)] mod tests { fn f() {} } fn g(v: serde_yaml::Value) {}", "serde_yaml"),
        ("plan/stack.rs", "#[cfg(test)] mod tests { use rapier2d::parry::query; }", "rapier2d"),
        ("plan/grid.rs", "fn f() { parry2d::query::contact() }", "parry2d"),
        ("scenario/mod.rs", "#[derive(clap::Args)] struct Options;", "clap"),
        ("experiment/mod.rs", "use indicatif::{ProgressBar, ProgressStyle};", "indicatif"),
        ("geometry.rs", "fn f(x: f64) -> f64 { libm::sin(x) }", "libm"),
    ] {
        let faults = faults(relative, source, &mut BTreeSet::new());
        assert!(faults.len() == 1 && faults[0].contains(name), "{relative}: {source}\n{faults:?}");
    }
}

/// What is left out of the build id decides no bytes: only rooms behind the experiment, which nothing in it may name.
#[test]
fn the_rooms_that_are_no_engine_stand_behind_it() {
    let engine = ORDER.iter().position(|room| *room == "experiment").unwrap();
    for name in super::identity::build_id::SHELL {
        let room = ORDER.iter().position(|room| *room == name);
        assert!(["lib.rs", "main.rs"].contains(&name) || room.is_some_and(|room| room > engine), "{name}");
    }
}
