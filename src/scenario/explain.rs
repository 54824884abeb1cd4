//! The YAML reader's errors in the words of scenario files.
//!
//! serde and serde_yaml hand over a sentence and a position. The sentence begins with the key path
//! and follows one of the few forms below; any other is passed on as it is.

use super::error::ScenarioError;
use super::key_path::{self, KeyPath, Step};
use super::schema::Place;
use crate::settings::choice::nearest;
use serde_json::Value as Json;
use std::ops::Range;

/// An error of the first look at the text: syntax, nesting, keys written twice, tags, numbers.
/// With the place in the tree.
pub(super) fn shape(error: &serde_yaml::Error, file: &str, text: &str) -> (KeyPath, ScenarioError) {
    let Fault { path, message, mut span, .. } = Fault::new(error, text);
    let at = span.as_ref().map_or(0, |span| span.start);
    let line_start = text[..at].rfind('\n').map_or(0, |end| end + 1);
    let indentation = text[line_start..].find(|c| c != ' ').unwrap_or(0);
    let refused = if text[line_start + indentation..].starts_with('\t') {
        span = Some(line_start + indentation..line_start + indentation + 1);
        ScenarioError::new("a tab in the indentation")
            .label("this is a tab")
            .help("YAML is indented with spaces: replace each tab by two of them")
    } else if let Some(repeated) = message.strip_suffix(" is written twice") {
        ScenarioError::new(format!("{repeated} is written twice{}", inside(&path)))
            .label("the second time")
            .help("keep one of the two")
    } else if message.starts_with("scenarios use no YAML tags") {
        ScenarioError::new(message)
            .label("starts with `!`")
            .help("write a choice with parameters as `name: {parameters}`")
    } else if message.starts_with("lists and keys are nested") || message == "recursion limit exceeded" {
        ScenarioError::new(message)
            .label("too deep")
            .help("no scenario needs that: is a bracket or a quote left open before it?")
    } else if message == "repetition limit exceeded" {
        ScenarioError::new("aliases (`*name`) blow the scenario up to an unreasonable size")
            .help("write the values out, or leave out aliases of aliases")
    } else if message.contains("more than one document") {
        ScenarioError::new("the file holds more than one YAML document")
            .help("keep one scenario per file: remove the `---` between them")
    } else if message == super::shape::NOT_FINITE {
        ScenarioError::new(format!("{} is not a finite number", home(&path)))
            .label("expected a finite number")
            .help("write the number that you mean, such as 1.5")
    } else if message.starts_with("the number") {
        ScenarioError::new(format!("{}: {message}", home(&path)))
            .label("too large")
            .help("no whole number in a scenario is larger than 18446744073709551615")
    } else {
        syntax(&message, &text[..at])
    };
    let refused = match span {
        Some(span) => refused.at(Some(file.to_owned()), text, span),
        None => refused.in_file(file),
    };
    (path, refused)
}

/// An error of the YAML grammar, in a text that is right up to `before`'s end.
fn syntax(message: &str, before: &str) -> ScenarioError {
    let (problem, context) = message.split_once(", while ").unwrap_or((message, ""));
    let glued = |line: &&str| {
        let line = line.trim();
        line.split_once(':').is_some_and(|(key, value)| {
            key.chars().all(|c| c.is_alphanumeric() || c == '_') && value.starts_with(|c: char| !c.is_whitespace())
        })
    };
    let unspaced = before.lines().rev().take(2).find(glued);
    let help = match problem {
        _ if let Some(line) = unspaced => format!("a space is missing after the colon in `{}`", line.trim()),
        p if p.contains("mapping values are not allowed") => {
            "is this line indented too far? A text that holds `: ` needs quotes".to_owned()
        }
        p if p.contains("did not find expected ',' or") => "is a bracket or a comma missing before it?".to_owned(),
        p if p.contains("unexpected end of stream") || p.contains("did not find expected node") => {
            "is a bracket or a quote left open?".to_owned()
        }
        p if p.contains("unknown anchor") => "an alias `*name` needs an anchor `&name` above it".to_owned(),
        _ => "is this line indented like its neighbours, with spaces only and `key: value`?".to_owned(),
    };
    let error = ScenarioError::new(format!("this is not YAML: {problem}")).label("here").help(help);
    if context.is_empty() { error } else { error.note(format!("while {context}")) }
}

/// The words that say in which block something is; none at the top.
fn inside(path: &KeyPath) -> String {
    if path.is_top() { String::new() } else { format!(" in `{path}`") }
}

/// An error of the YAML reader, taken apart.
#[derive(Clone)]
pub(super) struct Fault<'a> {
    /// The text in which it is shown.
    pub text: &'a str,
    /// The value (or for a key that does not belong: the block) that was being read.
    pub path: KeyPath,
    /// The sentence without path and position.
    pub message: String,
    /// What to underline, where a position is known.
    pub span: Option<Range<usize>>,
}

impl<'a> Fault<'a> {
    /// Takes apart an error raised while reading `text`.
    pub fn new(error: &serde_yaml::Error, text: &'a str) -> Self {
        let mut message = error.to_string();
        let mut span = None;
        if let Some(location) = error.location() {
            let position = format!(" at line {} column {}", location.line(), location.column());
            message = message.replacen(&position, "", 1);
            let index = location.index().min(text.len());
            span = text.is_char_boundary(index).then(|| key_path::token(text, index));
        }
        let path = match message.split_once(": ") {
            Some((prefix, rest)) if !prefix.contains([' ', '`']) && key_path::exists(text, &KeyPath::parse(prefix)) => {
                let path = KeyPath::parse(prefix);
                message = rest.to_owned();
                path
            }
            _ => KeyPath::default(),
        };
        Self { text, path, message, span }
    }

    /// The key that does not belong, if that is the fault.
    pub fn unknown_key(&self) -> Option<&str> {
        quoted_after(&self.message, "unknown field ").map(|(key, _)| key)
    }

    /// The key that is missing, if that is the fault.
    pub fn missing_key_name(&self) -> Option<&str> {
        quoted_after(&self.message, "missing field ").map(|(key, _)| key)
    }

    /// Whether another reading tells the same, of `path`.
    pub fn is_like(&self, other: &Fault<'_>, path: &KeyPath) -> bool {
        self.path == *path && self.message == other.message
    }

    /// The same in our words, and what to underline.
    pub fn explain(mut self, schema: &Json) -> (ScenarioError, Option<Range<usize>>) {
        let error = self.in_our_words(schema);
        (error, self.span)
    }

    fn in_our_words(&mut self, schema: &Json) -> ScenarioError {
        let message = std::mem::take(&mut self.message);
        if let Some((key, _)) = quoted_after(&message, "unknown field ") {
            self.narrow_to(key);
            return unknown_key(key, &self.path, schema);
        }
        if let Some((key, _)) = quoted_after(&message, "missing field ") {
            return self.missing_key(key, schema);
        }
        if let Some((name, rest)) = quoted_after(&message, "unknown variant ") {
            let known: Vec<&str> = rest.split('`').skip(1).step_by(2).collect();
            return self.unknown_name(&format!("value of {}:", home(&self.path)), name, &known, schema);
        }
        if let Some((what, rest)) = message.strip_prefix("unknown ").and_then(|rest| rest.split_once(" `"))
            && let Some((name, rest)) = rest.split_once('`')
            && let Some((_, known)) = rest.split_once("(known: ")
        {
            let known: Vec<&str> = known.trim_end_matches(')').split(", ").collect();
            return self.unknown_name(what, name, &known, schema);
        }
        if let Some((two, _)) = message.split_once(" (is the indentation right?)") {
            return self.two_names(two, schema);
        }
        if let Some(error) = self.bad_drawing(&message) {
            return error;
        }
        for kind in ["invalid type: ", "invalid value: ", "invalid length "] {
            if let Some((found, expected)) = message.strip_prefix(kind).and_then(|rest| rest.split_once(", expected "))
            {
                let found = if kind == "invalid length " { format!("a list of {found}") } else { plain_found(found) };
                return self.wrong_value(&plain_expected(expected), &found, schema);
            }
        }
        if let Some((expected, found)) = message.strip_prefix("expected ").and_then(|rest| rest.split_once(", found "))
        {
            return self.wrong_value(expected, &format!("`{}`", found.trim_matches(['`', '"'])), schema);
        }
        self.with_meaning(ScenarioError::new(format!("{}: {message}", home(&self.path))), schema)
    }

    fn missing_key(&mut self, key: &str, schema: &Json) -> ScenarioError {
        let place = Place::at(schema, &self.path);
        let word = self.span.clone().map_or("", |span| &self.text[span]);
        let is_parameter = place.as_ref().is_some_and(|place| place.key(key).is_none());
        if is_parameter && place.and_then(|place| place.key(word)?.key(key)).is_some() {
            // A choice written by its name alone: the reader knows the place of the name only.
            self.path = std::mem::take(&mut self.path).key(word);
        }
        let mut error = ScenarioError::new(format!("`{key}` is missing{}", inside(&self.path)));
        if self.path.is_top() {
            self.span = None;
            error = error.help(match key {
                "map" => "say what to drive on, for example `map: {movingai: {file: my_map.map}}`",
                "stacks" => "say what to drive with, for example `stacks: {global: [a_star], local: [dwa]}`",
                _ => "add it",
            });
        } else if is_parameter {
            error = error.label(format!("expected `{word}: {{{key}: …}}`"));
        } else {
            error = error.label(format!("expected `{key}: …` in here"));
        }
        self.path = std::mem::take(&mut self.path).key(key);
        self.with_meaning(error, schema)
    }

    fn unknown_name(&mut self, what: &str, name: &str, known: &[&str], schema: &Json) -> ScenarioError {
        self.narrow_to(name);
        let mut error = ScenarioError::new(format!("unknown {what} `{name}`"))
            .key(self.path.clone())
            .label(nearest(name, known).map_or("not known here".to_owned(), |near| format!("did you mean `{near}`?")))
            .note(format!("known here: {}", known.join(", ")));
        let paths = Place::top(schema).paths_to(name);
        let homes: Vec<String> = paths.iter().take(3).map(|path| format!("`{}`", path.parent())).collect();
        if !homes.is_empty() {
            error = error.help(format!("`{name}` belongs under {}", homes.join(" or ")));
        }
        error
    }

    fn two_names(&mut self, message: &str, schema: &Json) -> ScenarioError {
        let names: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
        let what =
            message.strip_prefix("expected one ").and_then(|rest| rest.split_once(',')).map_or("name", |(w, _)| w);
        let (first, second) = (names.first().copied().unwrap_or(""), names.get(1).copied().unwrap_or(""));
        self.narrow_to(second);
        let path = &self.path;
        let is_name = Place::at(schema, path).is_some_and(|place| place.key(second).is_some());
        let help = match path.steps().last() {
            _ if !is_name => format!("if `{second}` is a parameter of `{first}`, indent it further than `{first}`"),
            Some(Step::Item(_)) => format!("make `{second}` a list item of its own, with a `-` before it"),
            _ => "keep one of the two".to_owned(),
        };
        ScenarioError::new(format!("{} takes one {what}, found `{first}` and `{second}`", home(path)))
            .key(path.clone())
            .label("the second one")
            .help(help)
    }

    /// A map drawn in the scenario, whose error names a line of the drawing.
    fn bad_drawing(&mut self, message: &str) -> Option<ScenarioError> {
        let (place, rest) = message.strip_prefix("line ")?.split_once(": found ")?;
        let (row, column) = place.split_once(", column ")?;
        let row: usize = row.parse().ok()?;
        let (found, rest) = rest.split_once(", expected ")?;
        let (expected, advice) = rest.split_once("; ")?;
        let item = self.path.clone().item(row.saturating_sub(1));
        if key_path::exists(self.text, &item) {
            self.span = key_path::locate(self.text, &item);
        } else if let Some(span) = &self.span {
            let mut start = span.start;
            for _ in 0..row {
                start += self.text[start..].find('\n').map_or(0, |end| end + 1);
            }
            start += self.text[start..].len() - self.text[start..].trim_start_matches(' ').len();
            self.span = Some(key_path::token(self.text, start));
        }
        let title = format!("{}: found {found} in row {row} at column {column}, expected {expected}", home(&self.path));
        Some(ScenarioError::new(title).key(self.path.clone()).label(format!("expected {expected}")).help(advice))
    }

    fn wrong_value(&mut self, expected: &str, found: &str, schema: &Json) -> ScenarioError {
        let mut error = ScenarioError::new(format!("{} is {found}, expected {expected}", home(&self.path)))
            .label(format!("expected {expected}"));
        if expected == "a list"
            && let Some(word) = found.split('`').nth(1)
        {
            error = error.help(format!("a list of one is written `[{word}]`"));
        }
        let word = found.trim_start_matches("the text `").trim_matches(['`', '-', '+', '.']).to_ascii_lowercase();
        if ["nan", "inf", "infinity"].contains(&word.as_str()) {
            error = error.help("every number of a scenario is finite: write the one that you mean, such as 1.5");
        }
        if let Some(digits) = found.strip_prefix("the text `").and_then(|found| found.strip_suffix('`'))
            && digits.len() > 1
            && digits.bytes().all(|byte| byte.is_ascii_digit())
        {
            let plain = digits.trim_start_matches('0');
            error = error.help(format!(
                "digits that begin with 0 or stand in quotes are a text in YAML: write `{}`",
                if plain.is_empty() { "0" } else { plain }
            ));
        }
        self.with_meaning(error, schema)
    }

    /// Adds the key and what its documentation says.
    fn with_meaning(&self, error: ScenarioError, schema: &Json) -> ScenarioError {
        let place = Place::at(schema, &self.path).filter(|_| !self.path.is_top());
        let error = match place.and_then(|place| place.meaning()) {
            Some(meaning) => error.note(format!("`{}`: {meaning}", self.path)),
            None => error,
        };
        error.key(self.path.clone())
    }

    /// Underlines `word`, where it stands on its own at or after the position.
    fn narrow_to(&mut self, word: &str) {
        let Some(start) = self.span.as_ref().map(|span| span.start) else { return };
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let stands_alone = |&(i, _): &(usize, &str)| {
            !self.text[..start + i].ends_with(is_word) && !self.text[start + i + word.len()..].starts_with(is_word)
        };
        if let Some((i, _)) = self.text[start..].match_indices(word).find(stands_alone).filter(|_| !word.is_empty()) {
            self.span = Some(start + i..start + i + word.len());
        }
    }
}

/// The error for a key that does not exist in the block `path`: with the block where it does, or
/// else with the nearest key here.
pub(super) fn unknown_key(key: &str, path: &KeyPath, schema: &Json) -> ScenarioError {
    let mut known = Place::at(schema, path).map_or(Vec::new(), |place| place.keys());
    // By the alphabet, for readers who look for one of them.
    known.sort_unstable();
    let home = if path.is_top() { "the top level".to_owned() } else { format!("`{path}`") };
    let error = ScenarioError::new(format!("unknown key `{key}`{}", inside(path))).key(path.clone().key(key)).note(
        if known.is_empty() { format!("{home} has no keys") } else { format!("keys of {home}: {}", known.join(", ")) },
    );
    let elsewhere: Vec<String> =
        Place::top(schema).paths_to(key).iter().take(3).map(|path| format!("`{path}`")).collect();
    match nearest(key, &known) {
        _ if !elsewhere.is_empty() => {
            error.label("not a key here").help(format!("there is {}: is it indented right?", elsewhere.join(", ")))
        }
        Some(near) => error.label(format!("did you mean `{near}`?")),
        None => error.label("not a key here"),
    }
}

/// The value of a path, as a subject.
fn home(path: &KeyPath) -> String {
    if path.is_top() { "the scenario".to_owned() } else { format!("`{path}`") }
}

/// The text in backquotes right after `start`, and what follows it.
fn quoted_after<'m>(message: &'m str, start: &str) -> Option<(&'m str, &'m str)> {
    message.strip_prefix(start)?.strip_prefix('`')?.split_once('`')
}

/// What serde says it found, in our words.
fn plain_found(found: &str) -> String {
    if let Some(text) = found.strip_prefix("string ") {
        let text = text.trim_matches('"');
        let short: String = text.chars().take(40).collect();
        return format!("the text `{short}{}`", if short.len() < text.len() { "…" } else { "" });
    }
    match found {
        "sequence" => "a list".to_owned(),
        "map" => "a block of keys".to_owned(),
        "unit value" | "unit" => "empty".to_owned(),
        _ => found.find('`').map_or(found.to_owned(), |start| found[start..].to_owned()),
    }
}

/// What serde says it expected, in our words.
fn plain_expected(expected: &str) -> String {
    match expected {
        "u64" | "u32" | "usize" | "u16" | "u8" => "a whole number of at least 0".to_owned(),
        "i64" | "i32" => "a whole number".to_owned(),
        "f64" | "f32" => "a number".to_owned(),
        "a string" | "string" => "a text".to_owned(),
        "a boolean" => "`true` or `false`".to_owned(),
        "a sequence" => "a list".to_owned(),
        e if e.starts_with("struct ") || e == "a map" || e == "map" => "a block of keys".to_owned(),
        e => e.to_owned(),
    }
}
