//! Keys that a scenario may have, taken from its JSON Schema, so that there is no second list of them.

use super::key_path::{KeyPath, Step};
use serde_json::{Map, Value as Json};
use std::collections::{BTreeMap, VecDeque};

/// A place in the schema: the alternatives that a value there may follow.
#[derive(Clone, Debug)]
pub(super) struct Place<'a> {
    root: &'a Json,
    forms: Vec<&'a Json>,
}

impl<'a> Place<'a> {
    /// The top of the schema `root`.
    pub fn top(root: &'a Json) -> Self {
        Self::new(root, [root])
    }

    /// The place of `path`; `None` if no alternative has it.
    pub fn at(root: &'a Json, path: &KeyPath) -> Option<Self> {
        path.steps().iter().try_fold(Self::top(root), |place, step| match step {
            Step::Key(key) => place.key(key),
            Step::Item(_) => place.items(),
        })
    }

    fn new(root: &'a Json, schemas: impl IntoIterator<Item = &'a Json>) -> Self {
        let mut forms = Vec::new();
        let mut open: Vec<&Json> = schemas.into_iter().collect();
        while let Some(schema) = open.pop() {
            let reference = schema["$ref"].as_str().and_then(|to| root.pointer(to.strip_prefix('#')?));
            open.extend(reference);
            for alternatives in ["anyOf", "oneOf", "allOf"] {
                open.extend(schema[alternatives].as_array().into_iter().flatten().rev());
            }
            forms.push(schema);
        }
        Self { root, forms }
    }

    /// The names of the keys allowed here, in the order of the schema.
    pub fn keys(&self) -> Vec<&'a str> {
        let mut keys: Vec<&str> = Vec::new();
        for key in self.forms.iter().filter_map(|form| form["properties"].as_object()).flat_map(|keys| keys.keys()) {
            if !keys.contains(&key.as_str()) {
                keys.push(key);
            }
        }
        keys
    }

    /// The place of the key `name` in here.
    pub fn key(&self, name: &str) -> Option<Self> {
        self.inner(|form| form["properties"].get(name))
    }

    /// The place of the items of a list.
    pub fn items(&self) -> Option<Self> {
        self.inner(|form| form.get("items"))
    }

    /// The place one step further, by the alternatives that have it.
    pub fn inner(&self, step: impl Fn(&'a Json) -> Option<&'a Json>) -> Option<Self> {
        let found: Vec<&Json> = self.forms.iter().filter_map(|form| step(form)).collect();
        (!found.is_empty()).then(|| Self::new(self.root, found))
    }

    /// Whether `key` is one of several of which exactly one may stand here (a choice by name).
    pub fn is_choice(&self, key: &str) -> bool {
        let has_key = |form: &&&Json| form["properties"].get(key).is_some();
        self.keys().len() > 1
            && self
                .forms
                .iter()
                .filter(has_key)
                .all(|form| form["properties"].as_object().is_some_and(|p| p.len() == 1))
    }

    /// Meaning of this place: the first paragraph of its documentation.
    pub fn meaning(&self) -> Option<String> {
        self.find("description").and_then(Json::as_str).map(first_paragraph)
    }

    /// The first of the alternatives' values of the schema's keyword `keyword`.
    pub fn find(&self, keyword: &str) -> Option<&'a Json> {
        self.forms.iter().find_map(|form| form.get(keyword))
    }

    /// The alternatives, wrappers before what they wrap.
    pub fn forms(&self) -> &[&'a Json] {
        &self.forms
    }

    /// The place of the key `name` in here, or in the items of the list here.
    pub fn key_or_item_key(&self, name: &str) -> Option<Self> {
        self.key(name).or_else(|| self.items()?.key_or_item_key(name))
    }

    /// The only texts allowed here, each with its meaning; they include a choice's kinds that need no parameters.
    pub fn names(&self) -> Vec<(&'a str, Option<String>)> {
        let listed = |form: &&'a Json| form["enum"].as_array().into_iter().flatten().chain(form.get("const")).collect();
        let mut names: Vec<(&str, Option<String>)> = Vec::new();
        for form in &self.forms {
            let values: Vec<&'a Json> = listed(form);
            for name in values.into_iter().filter_map(Json::as_str) {
                if !names.iter().any(|(known, _)| *known == name) {
                    let meaning = form.get("const").and(form["description"].as_str());
                    names.push((name, meaning.map(first_paragraph)));
                }
            }
        }
        names
    }

    /// The kinds of a choice, each with its meaning, in the order of the registry; empty if this is no choice.
    pub fn kinds(&self) -> Vec<(&'a str, Option<String>)> {
        if !self.keys().iter().any(|key| self.is_choice(key)) {
            return Vec::new();
        }
        let mut kinds: Vec<(&str, Option<String>)> = Vec::new();
        let named = self.names();
        let forms = self.forms.iter().flat_map(|form| {
            let keys = form["properties"].as_object().into_iter().flat_map(|keys| keys.keys().map(String::as_str));
            form.get("const").and_then(Json::as_str).into_iter().chain(keys)
        });
        for name in forms.filter(|name| self.is_choice(name) || named.iter().any(|(known, _)| known == name)) {
            if !kinds.iter().any(|(known, _)| *known == name) {
                let alone = named.iter().find(|(known, _)| *known == name).and_then(|(_, meaning)| meaning.clone());
                kinds.push((name, alone.or_else(|| self.key(name)?.meaning())));
            }
        }
        kinds
    }

    /// Every path of keys to a key called `name`; list items are left out of the paths.
    pub fn paths_to(&self, name: &str) -> Vec<KeyPath> {
        let mut found = Vec::new();
        self.search(name, &KeyPath::default(), 0, &mut found);
        found
    }

    fn search(&self, name: &str, path: &KeyPath, depth: usize, found: &mut Vec<KeyPath>) {
        const DEPTH_MAX: usize = 8;
        if depth > DEPTH_MAX {
            return;
        }
        if let Some(items) = self.items() {
            items.search(name, path, depth + 1, found);
        }
        for key in self.keys() {
            let inner = path.clone().key(key);
            if key == name && !found.contains(&inner) {
                found.push(inner.clone());
            }
            if let Some(place) = self.key(key) {
                place.search(name, &inner, depth + 1, found);
            }
        }
    }
}

/// The first paragraph of a documentation, on one line.
fn first_paragraph(text: &str) -> String {
    text.split("\n\n").next().unwrap_or_default().replace('\n', " ").trim().to_owned()
}

/// A schema whose types are called after the key path at which each stands first, such as `obstacles.moving.random`: of
/// several, the shortest path, and of equals the first in the schema. A type that shares its place with the one that wraps it
/// keeps its own name behind the path (`stacks.Product`).
pub(super) fn named_by_path(mut schema: Json) -> Json {
    let Some(Json::Object(types)) = schema.as_object_mut().and_then(|top| top.remove("$defs")) else { return schema };
    let mut names: BTreeMap<String, String> = BTreeMap::new();
    let mut order: Vec<String> = Vec::new();
    let mut open = VecDeque::from([(KeyPath::default(), &schema)]);
    while let Some((path, form)) = open.pop_front() {
        if let Some(name) = referenced(form)
            && let Some(target) = types.get(name)
            && !names.contains_key(name)
        {
            let taken = path.is_top() || names.values().any(|other| *other == path.to_string());
            names.insert(name.to_owned(), if taken { format!("{path}.{name}") } else { path.to_string() });
            order.push(name.to_owned());
            open.push_front((path.clone(), target));
        }
        // What stands at the same place before what stands deeper.
        let alternatives =
            ["anyOf", "oneOf", "allOf", "prefixItems"].iter().flat_map(|k| form[*k].as_array()).flatten();
        let inner = alternatives.chain(["items", "additionalProperties"].iter().filter_map(|k| form.get(*k)));
        for same_place in inner.collect::<Vec<_>>().into_iter().rev() {
            open.push_front((path.clone(), same_place));
        }
        open.extend(form["properties"].as_object().into_iter().flatten().map(|(k, form)| (path.clone().key(k), form)));
    }
    let renamed: Map<String, Json> =
        order.iter().map(|name| (names[name].clone(), with_references(types[name].clone(), &names))).collect();
    let mut schema = with_references(schema, &names);
    schema["$defs"] = Json::Object(renamed);
    schema
}

/// The name of the type that a schema refers to.
fn referenced(form: &Json) -> Option<&str> {
    form["$ref"].as_str()?.strip_prefix(TYPES)
}

/// Place of the types in a schema.
pub(super) const TYPES: &str = "#/$defs/";

/// The schema with every reference to a type by its new name.
fn with_references(mut form: Json, names: &BTreeMap<String, String>) -> Json {
    if let Some(name) = referenced(&form).and_then(|name| names.get(name)) {
        form["$ref"] = Json::String(format!("{TYPES}{name}"));
    }
    match form {
        Json::Object(keys) => keys.into_iter().map(|(key, form)| (key, with_references(form, names))).collect(),
        Json::Array(items) => items.into_iter().map(|form| with_references(form, names)).collect(),
        plain => plain,
    }
}
