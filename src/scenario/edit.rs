//! Edits of a scenario's tree before its types see it: `--set path.to.key=value`, and sweeps.
//!
//! The schema decides which keys may be edited, not the file: a key that the file leaves at
//! its default may be set as well. A list's item is named by its index, by the planner it holds, or
//! by its own `name`; a planner written without parameters takes them (`dwa` becomes
//! `dwa: {horizon_s: 2}`). `*` stands for every item of a list, or whichever planner is there, that has the rest of the
//! path: `stacks.*.local.dwa.horizon_s` is the horizon of every listed stack that drives with `dwa`,
//! `stacks.*.local.*.horizon_s` that of every one whose local planner has a horizon.

use super::error::ScenarioError;
use super::key_path::KeyPath;
use super::schema::Place;
use super::{explain, shape};
use crate::settings::choice::nearest;
use crate::settings::quantity::counted;
use serde_yaml::{Mapping, Value};

/// A value to put at a place of the scenario's tree.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// Text of the edit that messages show.
    origin: String,
    /// Byte of `origin` at which the path begins.
    path_start: usize,
    path: String,
    value: Value,
}

impl Edit {
    /// The edit that the command line writes as `--set path.to.key=value`; the value is YAML.
    ///
    /// # Errors
    /// If there is no `=`, no path before it, or the value is not YAML.
    pub fn parse(argument: &str) -> Result<Self, ScenarioError> {
        let before = "--set ";
        let origin = format!("{before}{argument}");
        let refuse = |title: &str| {
            ScenarioError::new(title)
                .at(None, &origin, before.len()..origin.len())
                .help("for example `--set limits.speed_max_mps=0.8`")
        };
        let (path, value) = match argument.split_once('=') {
            Some((path, value)) if path.split('.').all(|part| !part.is_empty()) => (path, value),
            Some(_) => return Err(refuse("`--set` needs a path of keys joined by dots before the `=`")),
            None => return Err(refuse("`--set` needs `path.to.key=value`")),
        };
        shape::check("", &format!("value: {value}"))
            .map_err(|error| error.title().replace("`value`", "the value"))
            .and_then(|not_finite| match not_finite.first() {
                Some((_, error)) => Err(error.title().replace("`value`", "the value")),
                None => serde_yaml::from_str(value).map_err(|error| error.to_string()),
            })
            .map(|tree| Self::new(before, path, &format!("={value}"), tree))
            .map_err(|message| refuse(&message))
    }

    /// An edit that came from elsewhere; messages show `before`, `path` and `after` side by side.
    pub fn new(before: &str, path: &str, after: &str, value: Value) -> Self {
        Self { origin: format!("{before}{path}{after}"), path_start: before.len(), path: path.to_owned(), value }
    }

    /// The edit as `--set` takes it.
    pub fn argument(&self) -> &str {
        &self.origin[self.path_start..]
    }

    /// Makes the edit and returns its places in the tree: one, or with a `*` at least one.
    ///
    /// # Errors
    /// If the path leads to no key of the schema, or to no item of the tree's list.
    pub(super) fn apply(&self, tree: &mut Value, schema: &serde_json::Value) -> Result<Vec<KeyPath>, ScenarioError> {
        let parts: Vec<&str> = self.path.split('.').collect();
        let cursor = Cursor { edit: self, schema, done: KeyPath::default(), parts: &parts, used: 0 };
        cursor.descend(tree, Place::top(schema))
    }

    /// Shows an error at this edit; `part` is the number of the path's part at fault, `None` for the value.
    pub(super) fn blame(&self, error: ScenarioError, part: Option<usize>) -> ScenarioError {
        let span = match part {
            Some(part) => {
                let before: usize = self.path.split('.').take(part).map(|part| part.len() + 1).sum();
                let start = self.path_start + before;
                start..start + self.path.split('.').nth(part).map_or(0, str::len)
            }
            None => {
                let path_end = self.path_start + self.path.len();
                path_end + usize::from(self.origin[path_end..].starts_with('='))..self.origin.len()
            }
        };
        error.at(None, &self.origin, span)
    }
}

/// Position of an edit during its descent into the tree.
#[derive(Clone)]
struct Cursor<'a> {
    edit: &'a Edit,
    schema: &'a serde_json::Value,
    /// The path so far, with the keys and indices of the tree.
    done: KeyPath,
    /// The parts of the path as written.
    parts: &'a [&'a str],
    /// Number of parts used so far.
    used: usize,
}

impl Cursor<'_> {
    fn descend(mut self, node: &mut Value, place: Place<'_>) -> Result<Vec<KeyPath>, ScenarioError> {
        let Some(&part) = self.parts.get(self.used) else {
            *node = self.edit.value.clone();
            return Ok(vec![self.done]);
        };
        if let Value::Sequence(items) = node {
            return self.item(items, place, part);
        }
        let written = match node {
            Value::String(name) => Some(name.clone()),
            Value::Mapping(map) if map.len() == 1 => map.keys().next().and_then(Value::as_str).map(str::to_owned),
            _ => None,
        };
        let part = written.as_deref().filter(|name| part == "*" && place.is_choice(name)).unwrap_or(part);
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

    fn item(mut self, items: &mut [Value], place: Place<'_>, part: &str) -> Result<Vec<KeyPath>, ScenarioError> {
        let Some(inner) = place.items() else {
            return Err(self.refuse(explain::unknown_key(part, &self.done, self.schema)));
        };
        if part == "*" {
            return self.every_item(items, &inner);
        }
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
                    Ok(_) => format!("`{}` has {}, counted from 0", self.done, counted(count as u64, "item")),
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

    /// The edit in every item that has the rest of the path; the others stay as they are.
    fn every_item(self, items: &mut [Value], inner: &Place<'_>) -> Result<Vec<KeyPath>, ScenarioError> {
        let (mut landed, mut first_error) = (Vec::new(), None);
        for (index, item) in items.iter_mut().enumerate() {
            let done = self.done.clone().item(index);
            let mut edited = item.clone();
            match (Self { done, used: self.used + 1, ..self.clone() }).descend(&mut edited, inner.clone()) {
                Ok(places) => {
                    *item = edited;
                    landed.extend(places);
                }
                Err(error) => first_error = first_error.or(Some(error)),
            }
        }
        if landed.is_empty() {
            let is_empty = || self.refuse(ScenarioError::new(format!("`{}` is an empty list", self.done)));
            return Err(first_error.unwrap_or_else(is_empty));
        }
        Ok(landed)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Scenario, ScenarioFile};

    const BASE: &str = "
map: {random: {cols: 30, rows: 30, obstacles: 100}}
obstacles:
  moving: [random: {count: 3}, fixed: {position: [1, 2]}]
stacks:
  global: [a_star, theta_star: {}]
  local: [dwa, pure_pursuit]
";

    fn read(text: &str, sets: &[&str]) -> Scenario {
        let edits: Vec<Edit> = sets.iter().map(|set| Edit::parse(set).unwrap()).collect();
        ScenarioFile::from_text("base.yaml", text).read(&edits).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Two texts must give the same scenario: `BASE` with edits, and `BASE` with the text replaced.
    fn same(sets: &[&str], from: &str, to: &str) {
        assert!(BASE.contains(from), "{from}");
        assert_eq!(read(BASE, sets), read(&BASE.replacen(from, to, 1), &[]), "{sets:?}");
    }

    #[test]
    fn an_edit_gives_what_the_file_would_with_the_value_written_in() {
        same(&["map.random.cols=40"], "cols: 30", "cols: 40");
        same(&["seed=7"], "\nmap", "\nseed: 7\nmap");
        same(&["limits.speed_max_mps=0.5"], "\nmap", "\nlimits: {speed_max_mps: 0.5}\nmap");
        same(&["start=[1, 2]"], "\nmap", "\nstart: [1, 2]\nmap");
        same(&["map.random.map_seed=3"], "obstacles: 100", "obstacles: 100, map_seed: 3");
        same(
            &["map={empty: {cols: 5, rows: 5}}"],
            "{random: {cols: 30, rows: 30, obstacles: 100}}",
            "{empty: {cols: 5, rows: 5}}",
        );
        same(&["stacks.global=[dijkstra]"], "[a_star, theta_star: {}]", "[dijkstra]");
        same(
            &["stacks.path=[[], [line_of_sight]]"],
            "[dwa, pure_pursuit]",
            "[dwa, pure_pursuit]\n  path: [[], [line_of_sight]]",
        );
        same(&["stacks.replan=when_blocked"], "[dwa, pure_pursuit]", "[dwa, pure_pursuit]\n  replan: when_blocked");
        same(
            &["stacks.replan.every.period_s=2"],
            "[dwa, pure_pursuit]",
            "[dwa, pure_pursuit]\n  replan: {every: {period_s: 2}}",
        );
        same(&["description='a: b'"], "\nmap", "\ndescription: 'a: b'\nmap");
    }

    #[test]
    fn a_planner_written_without_parameters_takes_them() {
        let to = "dwa, pure_pursuit: {lookahead_m: 0.7}]";
        same(&["stacks.local.pure_pursuit.lookahead_m=0.7"], "dwa, pure_pursuit]", to);
        same(&["stacks.local.1.pure_pursuit.lookahead_m=0.7"], "dwa, pure_pursuit]", to);
        same(&["stacks.local.pure_pursuit={lookahead_m: 0.7}"], "dwa, pure_pursuit]", to);
        same(&["stacks.local.1={pure_pursuit: {lookahead_m: 0.7}}"], "dwa, pure_pursuit]", to);
    }

    #[test]
    fn items_are_found_by_index_and_by_name() {
        same(&["obstacles.moving.random.count=9"], "count: 3", "count: 9");
        same(&["obstacles.moving.0.random.count=9"], "count: 3", "count: 9");
        same(&["obstacles.moving.fixed.position.1=5"], "[1, 2]", "[1, 5]");
        let listed = "map: {empty: {cols: 5, rows: 5}}\nstacks:\n- {name: slow, global: a_star, local: pure_pursuit}";
        let by_name = read(listed, &["stacks.slow.local.pure_pursuit.lookahead_m=0.7"]);
        assert_eq!(by_name, read(listed, &["stacks.0.local.pure_pursuit.lookahead_m=0.7"]));
        assert_eq!(by_name, read(&listed.replace("pure_pursuit}", "{pure_pursuit: {lookahead_m: 0.7}}}"), &[]));
    }

    #[test]
    fn a_star_is_every_item_that_has_the_rest_of_the_path() {
        let listed = |horizons: [&str; 2]| {
            let [first, third] = horizons;
            format!(
                "map: {{empty: {{cols: 5, rows: 5}}}}\nstacks:\n- {{global: a_star, local: {first}}}\n\
                 - {{global: a_star, local: pure_pursuit}}\n- {{global: dijkstra, local: {third}}}\n"
            )
        };
        let plain = listed(["dwa", "{dwa: {d_cap_m: 1}}"]);
        let both = listed(["{dwa: {horizon_s: 2}}", "{dwa: {d_cap_m: 1, horizon_s: 2}}"]);
        assert_eq!(read(&plain, &["stacks.*.local.dwa.horizon_s=2"]), read(&both, &[]));
        let every = listed(["{dwa: {horizon_s: 2}}", "{dwa: {d_cap_m: 1, horizon_s: 2}}"]);
        assert_eq!(read(&plain, &["stacks.*.local.*.horizon_s=2"]), read(&every, &[]));
        let refused = |set: &str| {
            let edit = Edit::parse(set).unwrap();
            ScenarioFile::from_text("b.yaml", plain.clone()).read(&[edit]).unwrap_err().to_string()
        };
        assert!(refused("stacks.*.local.imp_dwa.horizon_s=2").contains("has no key `imp_dwa`"));
        assert!(refused("stacks.*.local.dwa.horzon_s=2").contains("did you mean `horizon_s`"));
        assert!(refused("obstacles.moving.*.random.count=2").contains("no list `obstacles.moving`"));
    }

    #[test]
    fn later_edits_see_the_earlier_ones() {
        same(
            &["stacks.local=[pure_pursuit]", "stacks.local.pure_pursuit.lookahead_m=0.7"],
            "dwa, pure_pursuit",
            "pure_pursuit: {lookahead_m: 0.7}",
        );
        same(&["seed=7", "seed=8"], "\nmap", "\nseed: 8\nmap");
    }

    #[test]
    fn an_edit_may_mend_a_file_and_a_fault_elsewhere_is_shown_in_the_file() {
        let broken = BASE.replace("cols: 30", "cols: 0");
        assert_eq!(read(&broken, &["map.random.cols=30"]), read(BASE, &[]));
        let edits = [Edit::parse("seed=7").unwrap()];
        let error = ScenarioFile::from_text("base.yaml", broken).read(&edits).unwrap_err().to_string();
        assert!(error.contains("base.yaml:2:22") && error.contains("`map.random.cols`"), "{error}");
    }

    #[test]
    fn what_cannot_be_edited_is_refused_at_its_part_of_the_path() {
        for (set, underlined, message) in [
            ("stacks.local.dwa.no_such=1", "no_such", "unknown key `no_such` in `stacks.local[0].dwa`"),
            ("seed.low=1", "low", "has no key `low`"),
            ("stacks.local.5=dwa", "5", "`stacks.local` has 2 items"),
            ("stacks.local.dwa.dwa=1", "dwa", "unknown key `dwa`"),
            ("e=1", "e", "unknown key `e`"),
            ("seed=.nan", "seed=.nan", "not a finite number"),
            ("seed=[1", "seed=[1", "not YAML"),
            ("=1", "=1", "needs a path"),
            ("a..b=1", "a..b=1", "needs a path"),
        ] {
            let edit = Edit::parse(set);
            let error =
                edit.and_then(|edit| ScenarioFile::from_text("b.yaml", BASE).read(&[edit])).unwrap_err().to_string();
            let carets = error.lines().rfind(|line| line.contains('^')).unwrap().matches('^').count();
            assert!(error.contains(message) && carets == underlined.len(), "{set}:\n{error}");
        }
    }
}
