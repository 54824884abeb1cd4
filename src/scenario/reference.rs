//! The reference of scenario keys: meaning, unit, type, default, allowed values, range and an example of every key.
//!
//! All of it is read from the JSON Schema of [`Scenario`], which comes from the types that read scenarios.

use super::Scenario;
use super::key_path::{KeyPath, Step};
use super::schema::{Place, TYPES};
use crate::settings::choice::nearest;
use crate::settings::unit_of;
use serde_json::{Map, Value as Json, json};
use std::fmt::Write as _;

/// The output of `simrun explain KEY`; the empty text explains the top-level keys.
///
/// Items of lists may be left out of the path: `stacks.local.dwa` explains the planner in a list of planners.
///
/// # Errors
/// If the key is unknown; the message names the nearest one.
pub fn explain(path: &str) -> Result<String, String> {
    Ok(Key::find(path)?.as_text())
}

/// Meanings of the keys below `path`, one after the other, as text: the parameters of a planner, for example.
///
/// # Errors
/// If the key is unknown; the message names the nearest one.
pub fn parameters(path: &str) -> Result<String, String> {
    let key = Key::find(path)?;
    let mut text = String::new();
    for inner in key.inner() {
        let default = inner.default_text();
        let _ = writeln!(text, "  {}: {default}", inner.name());
        let facts = [inner.unit().map(str::to_owned), Some(inner.type_text()), inner.range()];
        let facts: Vec<String> = facts.into_iter().flatten().collect();
        let _ = writeln!(text, "      {} ({})", inner.meaning(), facts.join(", "));
        for (name, meaning) in inner.allowed() {
            let _ = writeln!(text, "        {}", [format!("`{name}`"), meaning].join("  ").trim_end());
        }
    }
    Ok(text)
}

/// The keys below `path` as a table in Markdown, and an example in YAML: the parameters on the page of a planner.
///
/// # Errors
/// If the key is unknown; the message names the nearest one.
pub fn section(path: &str) -> Result<String, String> {
    let key = Key::find(path)?;
    let mut text = String::new();
    if key.inner().is_empty() {
        text.push_str("None.\n\n");
    } else {
        key.write_table(&mut text, Page::Planner);
    }
    key.write_example(&mut text);
    Ok(text)
}

/// The keys below `path` as JSON, each with `name`, `meaning`, `unit`, `type`, `required`, `default`, `range` (in words) and `allowed` (name and
/// meaning of each value that is allowed, if they are few). What does not apply is `null`.
///
/// # Errors
/// If the key is unknown; the message names the nearest one.
pub fn parameters_json(path: &str) -> Result<Vec<Json>, String> {
    let as_json = |key: &Key| {
        let allowed = key.allowed();
        let allowed = allowed.into_iter().map(|(name, meaning)| json!({ "name": name, "meaning": meaning }));
        json!({
            "name": key.name(),
            "meaning": key.meaning(),
            "unit": key.unit(),
            "type": key.type_text(),
            "required": key.required,
            "default": key.place.find("default").map(without_nulls),
            "range": key.range(),
            "allowed": allowed.collect::<Vec<Json>>(),
        })
    };
    Ok(Key::find(path)?.inner().iter().map(as_json).collect())
}

/// The whole reference as a page of Markdown: `docs/book/src/scenario.md`.
pub fn page() -> String {
    let top = Key { path: KeyPath::default(), place: Place::top(Scenario::schema()), required: false, is_kind: false };
    let mut text = String::from(HEAD);
    top.write_table(&mut text, Page::Scenario);
    for key in top.inner() {
        key.write_section(&mut text, 2);
    }
    text
}

const HEAD: &str = "# Scenario files: every key

<!-- Written by the test that compares this page with the code: SIMRUN_BLESS=1 writes it anew. -->

A scenario file is YAML. This page lists every key: its unit (also the last word of its name), type, default, the values that it
takes and what it means. `simrun explain KEY.PATH` prints the same for one key, `simrun check --resolved FILE` prints a scenario
with every default filled in, and `docs/scenario.schema.json` tells it to editors. Angles are in radians, positions in the frame
of the map. A choice is written `name` or `name: {parameters}`. A default of *none* means that the key may be left out; its
meaning says what then holds. `map` and `stacks` are the only keys that a scenario must have.

";

/// Choices whose kinds are pages of their own in the guide, `planners/NAME.md`.
const WITH_PAGES: [&str; 3] = ["stacks.global", "stacks.path", "stacks.local"];

/// A key of the scenario, or the top.
struct Key {
    path: KeyPath,
    place: Place<'static>,
    required: bool,
    /// Whether it is a kind of a choice, which has no default of its own.
    is_kind: bool,
}

impl Key {
    fn find(text: &str) -> Result<Self, String> {
        let schema = Scenario::schema();
        let mut key = Self { path: KeyPath::default(), place: Place::top(schema), required: false, is_kind: false };
        for step in KeyPath::parse(text).steps() {
            // An item of a list means the same as every other.
            let name = match step {
                Step::Item(_) => continue,
                Step::Key(name) if name.parse::<usize>().is_ok() => continue,
                Step::Key(name) => name,
            };
            key = key.child(name).ok_or_else(|| key.unknown(name))?;
        }
        Ok(key)
    }

    /// The error for a key that is not in here.
    fn unknown(&self, name: &str) -> String {
        let known: Vec<&str> = self.keys();
        let place = if self.path.is_top() { "a scenario".to_owned() } else { format!("`{}`", self.path) };
        let mut message = format!("{place} has no key `{name}`");
        if let Some(near) = nearest(name, &known) {
            let _ = write!(message, ", did you mean `{}`?", self.path.clone().key(near));
        }
        let homes = Place::top(Scenario::schema()).paths_to(name);
        if !homes.is_empty() {
            let homes: Vec<String> = homes.iter().take(3).map(|path| format!("`{path}`")).collect();
            let _ = write!(message, "\nhelp: there is {}", homes.join(", "));
        }
        match known.is_empty() {
            true => message + "\nnote: it takes a plain value and has no keys",
            false => format!("{message}\nnote: keys here: {}", known.join(", ")),
        }
    }

    /// The names of the keys in here, or in the items of the list here.
    fn keys(&self) -> Vec<&'static str> {
        let mut place = self.place.clone();
        loop {
            let keys = place.keys();
            match place.items() {
                Some(items) if keys.is_empty() => place = items,
                _ => return keys,
            }
        }
    }

    fn child(&self, name: &str) -> Option<Self> {
        let place = self.place.key_or_item_key(name)?;
        let holds = |list: &Json| list.as_array().is_some_and(|keys| keys.iter().any(|key| key == name));
        let is_kind = self.is_choice();
        let required = !is_kind && self.holder(name).is_some_and(|form| holds(&form["required"]));
        Some(Self { path: self.path.clone().key(name), place, required, is_kind })
    }

    /// The first of the alternatives that has the key `name`, here or in the items of the list here.
    fn holder(&self, name: &str) -> Option<&'static Json> {
        self.elements().forms().iter().copied().find(|form| form["properties"].get(name).is_some())
    }

    /// The innermost items of the list here; the place itself if it is no list.
    fn elements(&self) -> Place<'static> {
        let mut place = self.place.clone();
        while place.keys().is_empty()
            && let Some(items) = place.items()
        {
            place = items;
        }
        place
    }

    fn inner(&self) -> Vec<Self> {
        self.keys().iter().filter_map(|name| self.child(name)).collect()
    }

    fn name(&self) -> &str {
        match self.path.steps().last() {
            Some(Step::Key(name)) => name,
            _ => "",
        }
    }

    fn meaning(&self) -> String {
        self.place.meaning().unwrap_or_default()
    }

    fn is_choice(&self) -> bool {
        !self.elements().kinds().is_empty()
    }

    fn is_number(&self) -> bool {
        let is_number =
            |form: &Json| form["type"] == "number" || form["type"] == "integer" || first_type(form) == "number";
        self.elements().forms().iter().any(|form| is_number(form))
    }

    fn unit(&self) -> Option<&'static str> {
        self.is_number().then(|| unit_of(self.name())).flatten()
    }

    fn type_text(&self) -> String {
        type_text(&self.place)
    }

    /// The default as YAML on one line; `none` if the key may be left out and has no default.
    fn default_text(&self) -> String {
        if self.required {
            return "required".to_owned();
        }
        match self.place.find("default").map(without_nulls) {
            None | Some(Json::Null) => "none".to_owned(),
            Some(value) => in_line(&value),
        }
    }

    fn range(&self) -> Option<String> {
        let elements = self.elements();
        let is_list = self.place.items().is_some();
        let bound = |keyword: &str| elements.find(keyword).and_then(Json::as_f64);
        let range = match (bound("exclusiveMinimum"), bound("minimum"), bound("maximum")) {
            (Some(low), _, None) => format!("above {low}"),
            (Some(low), _, Some(high)) => format!("above {low}, at most {high}"),
            (None, Some(low), Some(high)) => format!("from {low} to {high}"),
            (None, Some(low), None) => format!("at least {low}"),
            (None, None, Some(high)) => format!("at most {high}"),
            (None, None, None) if self.is_choice() => return None,
            (None, None, None) => {
                return elements.find("pattern").map(|p| format!("pattern {}", p.as_str().unwrap_or("")));
            }
        };
        Some(if is_list { format!("each {range}") } else { range })
    }

    /// The texts allowed here, each with its meaning; empty for a choice, whose kinds are keys.
    fn allowed(&self) -> Vec<(String, String)> {
        let elements = self.elements();
        let kinds = elements.kinds();
        let names = if kinds.is_empty() { elements.names() } else { kinds };
        names.into_iter().map(|(name, meaning)| (name.to_owned(), meaning.unwrap_or_default())).collect()
    }

    fn as_text(&self) -> String {
        let mut text = String::new();
        if self.path.is_top() {
            text.push_str("The keys of a scenario; `simrun explain KEY` explains one of them.\n\n");
        } else {
            let _ = writeln!(text, "{}\n  {}\n", self.path, self.meaning());
            let facts = [
                ("unit", self.unit().map(str::to_owned)),
                ("type", Some(self.type_text())),
                ("default", (!self.is_kind).then(|| self.default_text())),
                ("range", self.range()),
            ];
            for (what, fact) in facts {
                if let Some(fact) = fact {
                    let _ = writeln!(text, "  {what:<8} {fact}");
                }
            }
        }
        let (allowed, inner) = (self.allowed(), self.inner());
        let rows: Vec<(String, String)> = match (allowed.is_empty(), self.path.is_top()) {
            (false, _) => allowed,
            (true, _) => inner.iter().map(|key| (key.name().to_owned(), key.meaning())).collect(),
        };
        if !rows.is_empty() {
            let head = match (self.is_choice(), inner.is_empty()) {
                (true, _) => "\nOne of\n",
                (false, true) => "\nAllowed values\n",
                (false, false) if self.path.is_top() => "",
                (false, false) => "\nKeys\n",
            };
            text.push_str(head);
            let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
            for (name, meaning) in rows {
                let _ = writeln!(text, "{}", format!("  {name:<width$}  {meaning}").trim_end());
            }
        }
        if !self.path.is_top() {
            let _ = write!(text, "\nExample\n{}", indented(&yaml(&self.example_tree(true))));
        }
        text
    }

    /// A part of a scenario that has this key; with `full`, every key of a block that has a default of its own is written out.
    fn example_tree(&self, full: bool) -> Json {
        let names: Vec<&str> = self
            .path
            .steps()
            .iter()
            .filter_map(|step| if let Step::Key(key) = step { Some(key.as_str()) } else { None })
            .collect();
        let top = Place::top(Scenario::schema());
        let Some((first, rest)) = names.split_first() else { return Json::Null };
        let value = top.key(first).map_or(Json::Null, |place| with_key(&place, rest, full));
        json!({ *first: value })
    }

    fn write_table(&self, text: &mut String, page: Page) {
        text.push_str("| key | unit | type | default | values | meaning |\n|---|---|---|---|---|---|\n");
        for key in self.inner() {
            let name = match key.home() {
                _ if key.keys().is_empty() => format!("`{}`", key.name()),
                home => format!("[`{}`]({})", key.name(), page.link(&home)),
            };
            let names: Vec<String> = match key.keys().is_empty() {
                true => key.allowed().iter().map(|(name, _)| format!("`{name}`")).collect(),
                false => Vec::new(),
            };
            let values = [key.range(), (!names.is_empty()).then(|| names.join(", "))];
            let values: Vec<String> = values.into_iter().flatten().collect();
            let default = match key.default_text().as_str() {
                // Each key in there says its own.
                value if value.starts_with('{') && !key.is_choice() => "`{}`".to_owned(),
                plain @ ("required" | "none") => plain.to_owned(),
                value => format!("`{value}`"),
            };
            let cells = [
                name,
                key.unit().unwrap_or_default().to_owned(),
                key.type_text(),
                default,
                values.join("; "),
                key.meaning_with_values(),
            ];
            let _ = writeln!(text, "| {} |", cells.map(|cell| cell.replace('|', "\\|")).join(" | "));
        }
        text.push('\n');
    }

    /// The meaning, and that of every value that is a name.
    fn meaning_with_values(&self) -> String {
        let mut meaning = self.meaning();
        if self.keys().is_empty() {
            for (name, what) in self.allowed().iter().filter(|(_, what)| !what.is_empty()) {
                let _ = write!(meaning, " `{name}`: {what}");
            }
        }
        meaning
    }

    /// Place at which the keys in here are described: this one, or the first one of the same type.
    fn home(&self) -> KeyPath {
        let types = self
            .place
            .forms()
            .iter()
            .chain(self.elements().forms())
            .filter_map(|form| form["$ref"].as_str())
            .collect::<Vec<_>>();
        let home = types.first().and_then(|name| name.strip_prefix(TYPES)).unwrap_or_default();
        // `stacks.Product` stands where `stacks` does.
        let home =
            home.split('.').take_while(|part| !part.starts_with(char::is_uppercase)).collect::<Vec<_>>().join(".");
        if home.is_empty() { self.path.clone() } else { KeyPath::parse(&home) }
    }

    fn write_section(&self, text: &mut String, level: usize) {
        if self.keys().is_empty() || self.home() != self.path {
            return;
        }
        let _ = writeln!(text, "{} `{}`\n\n{}\n", "#".repeat(level.min(4)), self.path, self.meaning());
        let has_pages = WITH_PAGES.contains(&self.path.to_string().as_str());
        let page = Page::Scenario;
        if self.is_choice() {
            let _ = writeln!(text, "One of ({}):\n\n| choice | what it is |\n|---|---|", self.type_text());
            for (name, meaning) in self.allowed() {
                let inner = self.child(&name).filter(|key| !key.keys().is_empty());
                let name = match inner {
                    // No global planner is no planner.
                    _ if has_pages && name != "none" => {
                        format!("[`{name}`]({})", page.link(&self.path.clone().key(&name)))
                    }
                    Some(key) => format!("[`{name}`]({})", page.link(&key.home())),
                    None => format!("`{name}`"),
                };
                let _ = writeln!(text, "| {name} | {} |", meaning.replace('|', "\\|"));
            }
            text.push('\n');
        } else {
            self.write_table(text, Page::Scenario);
            if let Some(place) = any_key(&self.place).filter(|place| !place.keys().is_empty()) {
                text.push_str("The values of a key may be a list, or a block:\n\n");
                Self { path: self.path.clone(), place, required: false, is_kind: false }
                    .write_table(text, Page::Scenario);
            }
        }
        self.write_example(text);
        for key in self.inner().iter().filter(|_| !has_pages) {
            key.write_section(text, level + 1);
        }
    }

    fn write_example(&self, text: &mut String) {
        let _ = writeln!(text, "```yaml\n{}```\n", yaml(&self.example_tree(true)));
    }
}

/// The page of the guide that a table is written for.
#[derive(Clone, Copy)]
enum Page {
    /// `scenario.md`.
    Scenario,
    /// `planners/NAME.md`.
    Planner,
}

impl Page {
    /// The link to the place that describes the keys below `path`.
    fn link(self, path: &KeyPath) -> String {
        let path = path.to_string();
        let planner = path.rsplit_once('.').filter(|(choice, _)| WITH_PAGES.contains(choice)).map(|(_, name)| name);
        // The anchor that Markdown makes of a heading that holds a key path.
        let anchor = path.replace('.', "");
        match (self, planner) {
            (Self::Scenario, Some(name)) => format!("planners/{name}.md"),
            (Self::Scenario, None) => format!("#{anchor}"),
            (Self::Planner, Some(name)) => format!("{name}.md"),
            (Self::Planner, None) => format!("../scenario.md#{anchor}"),
        }
    }
}

/// The first of a form's types.
fn first_type(form: &Json) -> &str {
    form["type"].as_str().or_else(|| form["type"].as_array()?.first()?.as_str()).unwrap_or_default()
}

/// The values allowed at a place, in words.
fn type_text(place: &Place<'_>) -> String {
    let mut kinds: Vec<String> = Vec::new();
    let mut add = |kind: String| {
        if !kinds.contains(&kind) {
            kinds.push(kind);
        }
    };
    let is_choice = !place.kinds().is_empty();
    for form in place.forms() {
        match first_type(form) {
            _ if form.get("const").is_some() || form.get("enum").is_some() => add("name".to_owned()),
            "number" => add("number".to_owned()),
            "integer" => add("whole number".to_owned()),
            "string" => add("text".to_owned()),
            "boolean" => add("`true` or `false`".to_owned()),
            "object" if is_choice => add("`name: {parameters}`".to_owned()),
            "object" => match any_key(place).map(|values| type_text(&values)) {
                Some(values) => add(format!("keys by path, each with a {values}")),
                None => add("block of keys".to_owned()),
            },
            "array" => {
                let of = place.items().map_or(String::new(), |items| format!(" of {}", plural(&type_text(&items))));
                add(match (form["minItems"].as_u64(), form["maxItems"].as_u64()) {
                    (Some(low), Some(high)) if low == high => format!("list of {low}{}", of.replacen(" of", "", 1)),
                    (Some(low), Some(high)) => format!("list of {low} to {high}{}", of.replacen(" of", "", 1)),
                    (Some(low), None) if !of.is_empty() => {
                        format!("list of at least {low}{}", of.replacen(" of", "", 1))
                    }
                    _ => format!("list{of}"),
                });
            }
            _ => {}
        }
    }
    // The short form first.
    kinds.sort_by_key(|kind| kind != "name");
    kinds.join(" or ")
}

/// Several of a type.
fn plural(kind: &str) -> String {
    match kind {
        "number" | "whole number" | "text" | "name" => format!("{kind}s"),
        "block of keys" => "blocks of keys".to_owned(),
        list if list.starts_with("list") && !list.contains(" or ") => format!("lists{}", &list[4..]),
        "" => "values".to_owned(),
        other => format!("({other})"),
    }
}

/// The place of the values whose keys have no fixed name.
fn any_key<'a>(place: &Place<'a>) -> Option<Place<'a>> {
    place.inner(|form| form.get("additionalProperties").filter(|values| values.is_object()))
}

/// A value without its keys that are null: those are as if left out.
fn without_nulls(value: &Json) -> Json {
    match value {
        Json::Object(keys) => {
            let kept = keys.iter().filter(|(_, value)| !value.is_null());
            kept.map(|(key, value)| (key.clone(), without_nulls(value))).collect()
        }
        Json::Array(items) => items.iter().map(without_nulls).collect(),
        plain => plain.clone(),
    }
}

/// A value as YAML on one line.
fn in_line(value: &Json) -> String {
    match value {
        Json::Object(keys) => {
            let keys: Vec<String> = keys
                .iter()
                .map(|(key, value)| match value {
                    Json::Object(inner) if inner.is_empty() && keys.len() == 1 => key.clone(),
                    value => format!("{key}: {}", in_line(value)),
                })
                .collect();
            match &keys[..] {
                [name] if !name.contains(':') => name.clone(),
                _ => format!("{{{}}}", keys.join(", ")),
            }
        }
        Json::Array(items) => format!("[{}]", items.iter().map(in_line).collect::<Vec<_>>().join(", ")),
        Json::Number(number) => {
            number.as_f64().filter(|_| number.is_f64()).map_or(number.to_string(), |x| x.to_string())
        }
        Json::String(text) if text.is_empty() => "''".to_owned(),
        Json::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// A tree as YAML.
fn yaml(tree: &Json) -> String {
    let mut text = String::new();
    write_block(&mut text, tree, 0);
    text
}

/// Writes a tree as YAML: blocks of keys and lists of them line by line, all else on one line.
fn write_block(text: &mut String, value: &Json, indent: usize) {
    let Json::Object(keys) = value else {
        let _ = writeln!(text, "{:indent$}{}", "", in_line(value));
        return;
    };
    for (key, value) in keys {
        let _ = write!(text, "{:indent$}{key}:", "");
        match value {
            Json::Object(inner) if !inner.is_empty() => {
                text.push('\n');
                write_block(text, value, indent + 2);
            }
            Json::Array(items) if items.iter().any(Json::is_object) => {
                text.push('\n');
                for item in items {
                    let start = text.len();
                    write_block(text, item, indent + 4);
                    text.replace_range(start + indent + 2..start + indent + 3, "-");
                }
            }
            plain => {
                let _ = writeln!(text, " {}", in_line(plain));
            }
        }
    }
}

fn indented(text: &str) -> String {
    text.lines().map(|line| format!("  {line}\n")).collect()
}

/// An example of the value at a place, including the key path `rest` below it.
fn with_key(place: &Place<'_>, rest: &[&str], full: bool) -> Json {
    let Some((name, deeper)) = rest.split_first() else { return if full { full_sample(place) } else { sample(place) } };
    let Some(inner) = place.key(name) else {
        return place.items().map_or(Json::Null, |items| json!([with_key(&items, rest, full)]));
    };
    let form = place.forms().iter().find(|form| form["properties"].get(name).is_some());
    let mut keys = form.map_or_else(Map::new, |form| required(place, form, Some(name)));
    keys.insert((*name).to_owned(), with_key(&inner, deeper, full));
    Json::Object(keys)
}

/// Examples of the keys that a block must have, but for one of them.
fn required(place: &Place<'_>, form: &Json, except: Option<&str>) -> Map<String, Json> {
    let names = form["required"].as_array().into_iter().flatten().filter_map(Json::as_str);
    let others = names.filter(|name| Some(*name) != except);
    others.filter_map(|name| Some((name.to_owned(), sample(&place.key(name)?)))).collect()
}

/// A block with every key that is required or has an informative default; for other values, that of [`sample`].
fn full_sample(place: &Place<'_>) -> Json {
    let says_something = |value: &Json| !matches!(without_nulls(value), Json::Null | Json::Array(_) | Json::Object(_));
    let block = place.forms().iter().find(|form| form["properties"].is_object());
    match (block, place.items()) {
        (Some(form), _) if place.kinds().is_empty() && place.find("examples").is_none() => {
            let required = required(place, form, None);
            let keys = place.keys().into_iter().filter_map(|name| {
                let inner = place.key(name)?;
                let shown = required.contains_key(name) || inner.find("default").is_some_and(says_something);
                shown.then(|| (name.to_owned(), sample(&inner)))
            });
            Json::Object(keys.collect())
        }
        (None, Some(items)) if !items.keys().is_empty() && items.kinds().is_empty() => json!([full_sample(&items)]),
        _ => sample(place),
    }
}

/// An example of the value at a place: its default if that is informative, else a fitting value.
fn sample(place: &Place<'_>) -> Json {
    if let Some(example) = place.find("examples").and_then(|examples| examples.get(0)) {
        return example.clone();
    }
    match place.find("default").map(without_nulls) {
        Some(Json::Null) | None => {}
        Some(Json::Array(items)) if items.is_empty() => {}
        Some(Json::Object(keys)) if keys.is_empty() => {}
        Some(Json::String(text)) if text.is_empty() => {}
        Some(Json::Object(keys)) if keys.len() == 1 && keys.values().all(|value| *value == json!({})) => {
            return keys.keys().next().map_or(Json::Null, |name| json!(name));
        }
        Some(default) => return default,
    }
    if let Some((name, _)) = place.names().first() {
        return json!(name);
    }
    for form in place.forms() {
        match first_type(form) {
            "integer" => return json!(form["minimum"].as_u64().unwrap_or(0).max(1)),
            "number" => return json!(if form["maximum"].as_f64() == Some(1.0) { 0.5 } else { 1.0 }),
            "boolean" => return json!(true),
            "string" => return json!("text"),
            "array" => {
                let count = form["minItems"].as_u64().unwrap_or(1).max(1);
                let item = place.items().map_or(json!(1), |items| sample(&items));
                return Json::Array(vec![item; count as usize]);
            }
            "object" => return Json::Object(required(place, form, None)),
            _ => {}
        }
    }
    Json::Null
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::ScenarioFile;

    fn every_key(key: &Key, found: &mut Vec<Key>) {
        for inner in key.inner() {
            every_key(&inner, found);
            found.push(inner);
        }
    }

    fn all() -> Vec<Key> {
        let mut keys = Vec::new();
        every_key(&Key::find("").unwrap(), &mut keys);
        keys
    }

    #[test]
    fn the_example_of_every_key_is_part_of_a_scenario() {
        let keys = all();
        assert!(keys.len() > 300, "{}", keys.len());
        let mut wrong = Vec::new();
        for (key, full) in keys.iter().flat_map(|key| [(key, false), (key, true)]) {
            let mut text = yaml(&key.example_tree(full));
            for (needed, line) in [
                ("map:", "map: {empty: {cols: 20, rows: 10}}\n"),
                ("stacks:", "stacks: {global: [a_star], local: [dwa]}\n"),
            ] {
                if !text.starts_with(needed) {
                    text += line;
                }
            }
            if let Err(error) = ScenarioFile::from_text("example.yaml", text.clone()).read(&[]) {
                wrong.push(format!("{}:\n{text}{error}", key.path));
            }
        }
        assert!(wrong.is_empty(), "{} of them:\n{}", wrong.len(), wrong.join("\n\n"));
    }

    #[test]
    fn a_key_is_explained_with_unit_default_range_and_example() {
        let text = explain("planning.inflation_m").unwrap();
        for part in
            ["planning.inflation_m\n", "unit     m\n", "type     number\n", "default  none\n", "range    at least 0\n"]
        {
            assert!(text.contains(part), "{text}");
        }
        assert!(text.ends_with("Example\n  planning:\n    inflation_m: 1\n"), "{text}");
        let text = explain("obstacles.moving.random.speed_mps").unwrap();
        assert!(
            text.contains("m/s") && text.contains("  obstacles:\n    moving:\n      - random:\n          speed_mps"),
            "{text}"
        );
        assert_eq!(explain("obstacles.moving[3].random.speed_mps"), explain("obstacles.moving.random.speed_mps"));
        assert_eq!(explain("obstacles.moving.0.random.speed_mps"), explain("obstacles.moving.random.speed_mps"));
    }

    #[test]
    fn choices_are_listed_with_a_line_each() {
        let text = explain("map").unwrap();
        for (name, entry) in crate::map::MapSpec::NAMES.iter().zip(crate::map::MapSpec::ENTRIES) {
            let line = text.lines().find(|line| line.trim_start().starts_with(&format!("{name} "))).unwrap();
            assert!(line.ends_with(entry.summary), "{line}");
        }
        let text = explain("map.random.shape").unwrap();
        assert!(text.contains("Allowed values") && text.contains("blocks  Rectangles of 1 to 4"), "{text}");
        // In the order of the source, as the file that declares them has them.
        let keys: Vec<&str> = Key::find("map.random").unwrap().keys();
        assert_eq!(keys[..4], ["cols", "rows", "resolution_m", "obstacles"]);
    }

    #[test]
    fn the_top_lists_every_key_of_a_scenario() {
        let text = explain("").unwrap();
        for key in Scenario::schema()["properties"].as_object().unwrap().keys() {
            assert!(text.lines().any(|line| line.trim_start().starts_with(key.as_str())), "{key}: {text}");
        }
    }

    #[test]
    fn a_wrong_key_is_answered_with_the_nearest_and_with_its_home() {
        for (wrong, expected) in [
            ("planing", "did you mean `planning`?"),
            ("limits.speed_max_mp", "did you mean `limits.speed_max_mps`?"),
            ("stacks.local.dwaa", "did you mean `stacks.local.dwa`?"),
            ("robot.horizon_s", "there is `stacks.local.dwa.horizon_s`"),
            ("seed.x", "it takes a plain value and has no keys"),
        ] {
            let message = explain(wrong).unwrap_err();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn every_section_that_the_page_links_to_is_there() {
        let page = page();
        let headings: Vec<String> = page
            .lines()
            .filter(|line| line.starts_with("##"))
            .map(|line| line.trim_start_matches('#').replace(['`', '.', ' '], ""))
            .collect();
        let links: Vec<&str> = page.split("](#").skip(1).filter_map(|rest| rest.split(')').next()).collect();
        assert!(
            links.len() > 50 && links.iter().all(|link| headings.iter().any(|h| h == link)),
            "{links:?} {headings:?}"
        );
        // The parameters of planners are on pages of their own.
        let planners = all().into_iter().map(|key| key.path.to_string());
        let planners = planners.filter(|path| path.starts_with("stacks.") && path.matches('.').count() == 2);
        let pages = planners.fold(page, |pages, path| pages + &section(&path).expect("a planner has a section"));
        for key in all() {
            assert!(pages.contains(&format!("`{}`", key.name())), "{}", key.path);
        }
    }
}
