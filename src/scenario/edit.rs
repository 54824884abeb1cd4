//! Edits of a scenario's tree before its types see it: `--set path.to.key=value`, and sweeps.
//!
//! Which keys may be edited is asked of the schema, not of the file: a key that the file leaves at
//! its default may be set as well. A list's item is named by its index, by the planner it holds, or
//! by its own `name`; a planner written without parameters takes them (`dwa` becomes
//! `dwa: {horizon_s: 2}`).

use super::error::ScenarioError;
use super::explain;
use super::key_path::KeyPath;
use super::schema::Place;
use crate::choice::nearest;
use serde_yaml::{Mapping, Value};

/// A value to put at a place of the scenario's tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    origin: String,
    path: String,
    value: Value,
}

impl Edit {
    /// The edit that the command line writes as `--set path.to.key=value`; the value is YAML.
    ///
    /// # Errors
    /// Where there is no `=` or no path before it, or the value is not YAML.
    pub fn parse(argument: &str) -> Result<Self, ScenarioError> {
        let origin = format!("--set {argument}");
        let refuse = |title: &str| {
            ScenarioError::new(title)
                .at(None, &origin, 6..origin.len())
                .help("for example `--set limits.speed_max_mps=0.8`")
        };
        let (path, value) = match argument.split_once('=') {
            Some((path, value)) if !path.is_empty() && path.split('.').all(|part| !part.is_empty()) => (path, value),
            Some(_) => return Err(refuse("`--set` needs a path of keys joined by dots before the `=`")),
            None => return Err(refuse("`--set` needs `path.to.key=value`")),
        };
        super::shape::check("", &format!("value: {value}"))
            .ok()
            .and_then(|()| serde_yaml::from_str(value).ok())
            .map(|value| Self::new(&origin, path, value))
            .ok_or_else(|| refuse("the value after `=` is not YAML that a scenario may hold"))
    }

    /// An edit that came from elsewhere; `origin` is what messages show, and holds `path`.
    pub fn new(origin: &str, path: &str, value: Value) -> Self {
        Self { origin: origin.to_owned(), path: path.to_owned(), value }
    }

    /// Makes the edit, and says where in the tree it landed.
    ///
    /// # Errors
    /// Where the path leads to no key of the schema, or to no item of the tree's list.
    pub(super) fn apply(&self, tree: &mut Value, schema: &serde_json::Value) -> Result<KeyPath, ScenarioError> {
        let parts: Vec<&str> = self.path.split('.').collect();
        let mut cursor = Cursor { edit: self, schema, done: KeyPath::default(), parts: &parts, used: 0 };
        cursor.descend(tree, Place::top(schema))?;
        Ok(cursor.done)
    }

    /// Shows an error at this edit; `part` is the number of the path's part at fault, none for the value.
    pub(super) fn blame(&self, error: ScenarioError, part: Option<usize>) -> ScenarioError {
        let path_start = self.origin.find(&self.path).unwrap_or(0);
        let value_start = self.origin[path_start..].find('=').map_or(path_start, |equals| path_start + equals + 1);
        let span = match part {
            Some(part) => {
                let before: usize = self.path.split('.').take(part).map(|part| part.len() + 1).sum();
                let length = self.path.split('.').nth(part).map_or(0, str::len);
                path_start + before..path_start + before + length
            }
            None => value_start..self.origin.len(),
        };
        error.at(None, &self.origin, span)
    }
}

/// Where an edit stands in its descent.
struct Cursor<'a> {
    edit: &'a Edit,
    schema: &'a serde_json::Value,
    /// The way so far, as the tree has it.
    done: KeyPath,
    /// The way to go, as it was written.
    parts: &'a [&'a str],
    /// Parts gone so far.
    used: usize,
}

impl Cursor<'_> {
    fn descend(&mut self, node: &mut Value, place: Place<'_>) -> Result<(), ScenarioError> {
        let Some(&part) = self.parts.get(self.used) else {
            *node = self.edit.value.clone();
            return Ok(());
        };
        if let Value::Sequence(items) = node {
            return self.item(items, place, part);
        }
        let Some(inner) = place.key(part) else { return Err(self.refuse_key(node, &place, part)) };
        if node.as_str() == Some(part) || node.is_null() {
            *node = Value::Mapping(Mapping::new());
        }
        let Value::Mapping(map) = node else { return Err(self.refuse_key(node, &place, part)) };
        if place.is_choice(part)
            && let Some(chosen) =
                map.keys().find_map(|key| key.as_str().filter(|key| *key != part && place.is_choice(key)))
        {
            let title = format!("`{}` is `{chosen}` in this scenario, not `{part}`", self.done);
            let help = format!("replace it as a whole: `--set '{}={{{part}: {{…}}}}'`", self.done.dotted());
            return Err(self.refuse(ScenarioError::new(title).label(format!("here it is `{chosen}`")).help(help)));
        }
        self.done = std::mem::take(&mut self.done).key(part);
        self.used += 1;
        self.descend(map.entry(Value::from(part)).or_insert(Value::Null), inner)
    }

    fn item(&mut self, items: &mut [Value], place: Place<'_>, part: &str) -> Result<(), ScenarioError> {
        let Some(inner) = place.items() else {
            return Err(self.refuse(explain::unknown_key(part, &self.done, self.schema)));
        };
        let count = items.len();
        let holds = |item: &Value| match item {
            Value::String(name) => name == part,
            Value::Mapping(map) => map.contains_key(part) || map.get("name").and_then(Value::as_str) == Some(part),
            _ => false,
        };
        let mut matching = (0..count).filter(|&i| holds(&items[i]));
        let (index, by_name) = match (part.parse::<usize>(), matching.next(), matching.next()) {
            (Ok(index), ..) if index < count => (index, false),
            (Err(_), Some(index), None) => (index, true),
            (Err(_), Some(first), Some(second)) => {
                let title = format!("`{part}` stands more than once in `{}`", self.done);
                let list = self.done.dotted();
                let help = format!("name it by its index: `{list}.{first}.{part}` or `{list}.{second}.{part}`");
                return Err(self.refuse(ScenarioError::new(title).label("which one?").help(help)));
            }
            (parsed, ..) => {
                let names: Vec<&str> = items.iter().filter_map(name_of).collect();
                let mut error = ScenarioError::new(match parsed {
                    Ok(_) => format!("`{}` has {count} items, counted from 0", self.done),
                    Err(_) => format!("no item of `{}` is `{part}`", self.done),
                });
                if let Some(near) = nearest(part, &names) {
                    error = error.label(format!("did you mean `{near}`?"));
                }
                if !names.is_empty() {
                    error = error.note(format!("items of `{}`: {}", self.done, names.join(", ")));
                }
                return Err(self.refuse(
                    error.help(format!("to add one, set the whole list: `--set '{}=[…]'`", self.done.dotted())),
                ));
            }
        };
        self.done = std::mem::take(&mut self.done).item(index);
        // A planner's name stands for the item and for the key in it; an own `name` and an index for the item alone.
        let is_key = by_name && inner.key(part).is_some();
        if !is_key {
            self.used += 1;
        }
        self.descend(&mut items[index], inner)
    }

    /// The error for a key that cannot be edited here.
    fn refuse_key(&self, node: &Value, place: &Place<'_>, part: &str) -> ScenarioError {
        if place.key(part).is_none() && place.items().is_some() {
            let title = format!("this scenario has no list `{}` to take `{part}` from", self.done);
            return self.refuse(
                ScenarioError::new(title).help(format!("set the whole list: `--set '{}=[…]'`", self.done.dotted())),
            );
        }
        if place.keys().is_empty() || (place.key(part).is_some() && !node.is_mapping()) {
            let found = node.as_str().map_or("a plain value".to_owned(), |name| format!("`{name}`"));
            return self.refuse(ScenarioError::new(format!("`{}` is {found} and has no key `{part}`", self.done)));
        }
        self.refuse(explain::unknown_key(part, &self.done, self.schema))
    }

    fn refuse(&self, error: ScenarioError) -> ScenarioError {
        self.edit.blame(error, Some(self.used))
    }
}

/// The name by which an item of a list can be edited.
fn name_of(item: &Value) -> Option<&str> {
    match item {
        Value::String(name) => Some(name),
        Value::Mapping(map) => match map.get("name") {
            Some(name) => name.as_str(),
            None if map.len() == 1 => map.keys().next()?.as_str(),
            None => None,
        },
        _ => None,
    }
}
