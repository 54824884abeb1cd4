//! What keys a scenario may have, asked of its JSON Schema, so that there is no second list of them.

use super::key_path::{KeyPath, Step};
use serde_json::Value as Json;

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

    /// The place of `path`; `None` where no alternative has it.
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

    /// The names of the keys that may stand here, in the order of the schema.
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

    fn inner(&self, step: impl Fn(&'a Json) -> Option<&'a Json>) -> Option<Self> {
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

    /// What the documentation says of this place: its first sentence.
    pub fn meaning(&self) -> Option<String> {
        let text = self.forms.iter().find_map(|form| form["description"].as_str())?;
        let paragraph = text.split("\n\n").next()?.replace('\n', " ");
        Some(paragraph.trim().to_owned())
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
