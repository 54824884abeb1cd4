//! Every fault of a scenario's types and not the first one alone: what is at fault is taken out of the tree, and what is left is read again.

use super::explain::Fault;
use super::key_path::{self, KeyPath, Step};
use super::{Edit, Scenario, ScenarioError};
use crate::settings::choice::nearest;
use serde_json::Value as Json;
use serde_yaml::Value;

/// Most errors that are looked for: more are not read by anybody at once.
pub(super) const FAULTS_MAX: usize = 20;

/// Most readings of one scenario.
const READINGS_MAX: usize = 64;

/// What a scenario must have, for the rest of it to be read where this is at fault.
const STAND_INS: [(&str, &str); 2] =
    [("map", "{empty: {cols: 9, rows: 9}}"), ("stacks", "{global: [a_star], local: [dwa]}")];

/// A scenario as it was written: where its faults are shown.
pub(super) struct Written<'a> {
    pub file: &'a str,
    pub text: &'a str,
    pub edits: &'a [Edit],
    /// The places of each edit.
    pub landed: &'a [Vec<KeyPath>],
}

/// What came of a reading.
#[derive(Debug)]
pub(super) struct Reading {
    /// The scenario, without what is at fault; `None` if nothing can be read.
    pub scenario: Option<Scenario>,
    /// The faults, placed.
    pub errors: Vec<ScenarioError>,
    /// What was taken out, as paths of the scenario as it was written.
    pub taken_out: Vec<KeyPath>,
}

/// Reads the types of a tree. What is in `taken_out` is known to be at fault and left out.
pub(super) fn read(mut tree: Value, taken_out: Vec<KeyPath>, written: &Written<'_>, schema: &Json) -> Reading {
    let mut reading = Reading { scenario: None, errors: Vec::new(), taken_out: Vec::new() };
    let mut gaps = Gaps::default();
    for path in taken_out {
        let here = gaps.here(&path);
        reading.taken_out.extend(take_out(&mut tree, &here, &mut gaps));
    }
    for _ in 0..READINGS_MAX {
        // Through a text and not straight from the tree, whose reader tells no key paths.
        let text = serde_yaml::to_string(&tree).expect("a tree read from YAML can be written as YAML");
        let error = match serde_yaml::from_str::<Scenario>(&text) {
            Ok(scenario) => {
                reading.scenario = Some(scenario);
                return reading;
            }
            Err(error) => error,
        };
        let fault = Fault::new(&error, &text);
        let (refused, _) = fault.clone().explain(schema);
        let here = refused.keys().next().cloned().unwrap_or_default();
        let path = gaps.written(&here);
        // What is above or below something at fault is at fault for that reason, and so is a key that is missing because it is misspelt.
        let is_misspelt = |taken: &KeyPath| {
            let names = fault.missing_key_name().zip(taken.steps().last().map(Step::name));
            taken.parent() == path.parent()
                && names.is_some_and(|(missing, taken)| nearest(taken, &[missing]).is_some())
        };
        if !reading.taken_out.iter().any(|taken| taken.touches(&path) || is_misspelt(taken)) {
            reading.errors.push(written.place(fault.clone(), &gaps, schema));
            if reading.errors.len() == FAULTS_MAX {
                return reading;
            }
        }
        match take_out(&mut tree, &here, &mut gaps) {
            Some(taken) => reading.taken_out.push(taken),
            None => return reading,
        }
    }
    reading
}

impl Written<'_> {
    /// A fault of a tree with gaps, shown where it was written.
    fn place(&self, fault: Fault<'_>, gaps: &Gaps, schema: &Json) -> ScenarioError {
        let path = gaps.written(&fault.path);
        let first = || {
            let error = serde_yaml::from_str::<Scenario>(self.text).err()?;
            let direct = Fault::new(&error, self.text);
            direct.is_like(&fault, &path).then_some(direct)
        };
        let direct = first().filter(|_| self.edits.is_empty());
        let (refused, span) = match direct {
            Some(direct) => direct.explain(schema),
            None => fault.moved(self.text, path).explain(schema),
        };
        let edit = self.edits.iter().zip(self.landed).rev().find(|(_, landed)| {
            refused.keys().any(|key| !key.is_top() && landed.iter().any(|place| key.touches(place)))
        });
        match (edit, span) {
            (Some((edit, _)), _) => edit.blame(refused, None),
            (None, Some(span)) => refused.at(Some(self.file.to_owned()), self.text, span),
            // The fault is in none of the edited values: the last edit made it one.
            (None, None) if !self.edits.is_empty() && serde_yaml::from_str::<Scenario>(self.text).is_ok() => {
                self.edits[self.edits.len() - 1].blame(refused, None)
            }
            (None, None) => refused.in_file(self.file),
        }
    }
}

/// The items that were taken out of lists: those behind them have moved up.
#[derive(Debug, Default)]
struct Gaps(Vec<KeyPath>);

impl Gaps {
    /// The path, as the scenario was written, of what is at `here` in the tree.
    fn written(&self, here: &KeyPath) -> KeyPath {
        let mut path = KeyPath::default();
        for step in here.steps() {
            path = match step {
                Step::Key(key) => path.key(key),
                Step::Item(index) => {
                    let mut missing = self.in_list(&path);
                    missing.sort_unstable();
                    let index =
                        missing.into_iter().fold(*index, |index, gap| if gap <= index { index + 1 } else { index });
                    path.item(index)
                }
            };
        }
        path
    }

    /// The path in the tree of what was written at `path`, which is still there.
    fn here(&self, path: &KeyPath) -> KeyPath {
        let mut written = KeyPath::default();
        let mut here = KeyPath::default();
        for step in path.steps() {
            match step {
                Step::Key(key) => {
                    written = written.key(key);
                    here = here.key(key);
                }
                Step::Item(index) => {
                    let before = self.in_list(&written).into_iter().filter(|gap| gap < index).count();
                    written = written.item(*index);
                    here = here.item(index - before);
                }
            }
        }
        here
    }

    /// The numbers of the items that are missing in the list at `list`.
    fn in_list(&self, list: &KeyPath) -> Vec<usize> {
        let missing = self.0.iter().filter(|gap| gap.parent() == *list);
        missing
            .filter_map(|gap| if let Some(Step::Item(index)) = gap.steps().last() { Some(*index) } else { None })
            .collect()
    }
}

/// Takes the value at `path` out of the tree, or the deepest one above it that is there, and tells what that was as it was written.
/// What a scenario must have gets a stand-in. `None` if there is nothing to take.
fn take_out(tree: &mut Value, path: &KeyPath, gaps: &mut Gaps) -> Option<KeyPath> {
    let mut depth = path.steps().len();
    while depth > 0 && value_at(tree, &path.steps()[..depth]).is_none() {
        depth -= 1;
    }
    if depth == 0 {
        let Some(Step::Key(key)) = path.steps().first() else { return None };
        return stand_in(tree, key).then(|| KeyPath::default().key(key));
    }
    let taken = (depth..path.steps().len()).fold(path.clone(), |path, _| path.parent());
    let (last, above) = taken.steps().split_last()?;
    let written = gaps.written(&taken);
    match (value_at(tree, above)?, last) {
        (Value::Mapping(keys), Step::Key(key)) => {
            keys.remove(key.as_str());
            if above.is_empty() {
                stand_in(tree, key);
            }
        }
        (Value::Sequence(items), Step::Item(index)) => {
            items.remove(*index);
            gaps.0.push(written.clone());
        }
        _ => return None,
    }
    Some(written)
}

/// Puts something valid at a key that a scenario must have.
fn stand_in(tree: &mut Value, key: &str) -> bool {
    let text = STAND_INS.iter().find(|(name, _)| *name == key);
    let (Some((_, text)), Value::Mapping(keys)) = (text, tree) else { return false };
    let value: Value = serde_yaml::from_str(text).expect("a stand-in is YAML");
    keys.insert(Value::from(key), value);
    true
}

fn value_at<'t>(tree: &'t mut Value, steps: &[Step]) -> Option<&'t mut Value> {
    steps.iter().try_fold(tree, |value, step| match step {
        Step::Key(key) => value.get_mut(key.as_str()),
        Step::Item(index) => value.get_mut(*index),
    })
}

impl<'a> Fault<'a> {
    /// The same fault in another text, where it is at `path`.
    fn moved<'t>(self, text: &'t str, path: KeyPath) -> Fault<'t> {
        let span = match self.unknown_key() {
            Some(key) => key_path::locate_key(text, &path.clone().key(key)),
            None => key_path::locate(text, &path),
        };
        Fault { text, path, message: self.message, span }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::ScenarioFile;

    /// First lines of the messages for a scenario, in their order.
    fn titles(text: &str, sets: &[&str]) -> Vec<String> {
        let edits: Vec<Edit> = sets.iter().map(|set| Edit::parse(set).unwrap()).collect();
        let error = ScenarioFile::from_text("room.yaml", text).read(&edits).unwrap_err();
        error.to_string().lines().filter_map(|line| line.strip_prefix("error: ")).map(str::to_owned).collect()
    }

    const GOOD: &str = "map: {empty: {cols: 20, rows: 10}}\nstacks: {global: [a_star], local: [dwa]}\n";

    #[test]
    fn independent_faults_are_told_at_once_in_the_order_of_the_file() {
        let text = "episode: 5\nmap: {empty: {cols: 20, rows: ten}}\nrobot: {radius: 0.3}\n\
            stacks: {global: [astar, a_star, dikstra], path: [[line_of_sigt]], local: [dwa, {dwa: {horizon: 2}}]}\n\
            limits: {speed_max_mps: -1, reverse_speed_max_mps: 5}\n";
        assert_eq!(
            titles(text, &[]),
            [
                "unknown key `episode`",
                "`map.empty.rows` is the text `ten`, expected a whole number from 1 to 16384",
                "unknown key `radius` in `robot`",
                "unknown global planner `astar`",
                "unknown global planner `dikstra`",
                "unknown path stage `line_of_sigt`",
                "unknown key `horizon` in `stacks.local[1].dwa`",
                "`limits.speed_max_mps` is `-1`, expected a number above 0",
            ]
        );
    }

    #[test]
    fn each_fault_is_shown_at_its_own_line() {
        let text = "map: {empty: {cols: 20, rows: 10}}\nstacks:\n  global:\n    - astar\n    - a_star\n    - dikstra: {}\n  local: [dwa]\n";
        let error = ScenarioFile::from_text("room.yaml", text).read(&[]).unwrap_err().to_string();
        let places: Vec<&str> = error.lines().filter_map(|line| line.trim().strip_prefix("--> ")).collect();
        assert_eq!(places, ["room.yaml:4:7", "room.yaml:6:7"], "{error}");
        assert!(error.contains("did you mean `a_star`?") && error.contains("did you mean `dijkstra`?"), "{error}");
    }

    #[test]
    fn what_follows_from_a_fault_is_not_told() {
        // Without its rows the map is none, without its file it cannot be read; a list is empty once its only item has gone.
        for (text, expected) in [
            ("map: {ascii: {rows: 5}}\nstacks: {global: [astar], local: []}\n", 2),
            ("map: {movingai: {fiel: a.map}}\nstacks: {global: [a_star], local: [dwa]}\n", 1),
            ("map: 7\nstacks: 8\n", 2),
            ("seed: -1\n", 3),
            ("- a list\n", 1),
            ("map: {empty: {cols: .nan, rows: 10}}\nstacks: {global: [a_star], local: [dwaa]}\n", 2),
        ] {
            let titles = titles(text, &[]);
            assert_eq!(titles.len(), expected, "{text}{titles:?}");
        }
    }

    #[test]
    fn faults_of_edits_and_of_the_file_are_told_together() {
        let text = GOOD.replace("[dwa]", "[dwaa]");
        let found = titles(&text, &["seed=-3", "robot.radius_m=wide"]);
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(
            found[0].contains("`dwaa`") && found[1].contains("`seed`") && found[2].contains("`robot.radius_m`"),
            "{found:?}"
        );
        let found = titles(GOOD, &["sed=3", "robot.radius=1"]);
        assert_eq!(found, ["unknown key `sed`", "unknown key `radius` in `robot`"]);
        assert_eq!(titles(GOOD, &["sed=3", "seed=first"]).len(), 2);
    }

    #[test]
    fn numbers_that_contradict_each_other_are_told_beside_what_does_not_touch_them() {
        let text =
            format!("{GOOD}limits: {{reverse_speed_max_mps: 2}}\nmetrics: {{near_miss_m: 3}}\nsensing: {{range: 3}}\n");
        let found = titles(&text, &[]);
        assert_eq!(found.len(), 3, "{found:?}");
        // A speed that cannot be read contradicts nothing.
        let text = format!("{GOOD}limits: {{reverse_speed_max_mps: 2, speed_max_mps: fast}}\n");
        assert_eq!(titles(&text, &[]).len(), 1);
    }

    #[test]
    fn gaps_of_lists_are_counted() {
        let mut gaps = Gaps::default();
        let mut tree: Value = serde_yaml::from_str("a: [0, 1, {b: [x, y]}, 3]").unwrap();
        for here in ["a[1]", "a[0]", "a[0].b[0]"] {
            take_out(&mut tree, &KeyPath::parse(here), &mut gaps).unwrap();
        }
        assert_eq!(gaps.0, ["a[1]", "a[0]", "a[2].b[0]"].map(KeyPath::parse));
        assert_eq!(gaps.written(&KeyPath::parse("a[1]")), KeyPath::parse("a[3]"));
        assert_eq!(gaps.written(&KeyPath::parse("a[0].b[0]")), KeyPath::parse("a[2].b[1]"));
        assert_eq!(gaps.here(&KeyPath::parse("a[2].b[1]")), KeyPath::parse("a[0].b[0]"));
    }
}
