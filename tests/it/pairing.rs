//! The pairing promise: one seed and one episode give the same world to every stack and every setting, unless the setting is
//! of the world itself.
//!
//! The settings, and other values for them, are taken from the JSON Schema: a key that is added tomorrow is tried as well.

use serde_json::{Map, Value, json};
use simrun::experiment::Experiment;
use simrun::results::Digest;
use simrun::scenario::{Scenario, ScenarioFile};
use std::collections::BTreeSet;

/// The keys that make the world: all others promise to leave it alone.
const OF_THE_WORLD: [&str; 8] = ["map", "robot", "obstacles", "start", "goal", "script", "episodes", "seed"];

/// Keys that give values to other keys.
const OF_OTHER_KEYS: [&str; 1] = ["sweep"];

/// Settings that are refused unless another one has a value that is not its default.
const NEED_ANOTHER: [&str; 1] = ["stacks.local.barr_dwa.barr_mode"];

/// Expected to move the world until start and goal are drawn on a floor that no planner's setting shapes; must be empty then.
const EXPECTED_TO_MOVE: [&str; 0] = [];

const EPISODES: u64 = 3;

/// Everything random that a world can have, and drives of a few ticks.
fn base() -> Value {
    json!({
        "map": {"random": {"cols": 20, "rows": 20, "obstacles": 60}},
        "obstacles": {
            "unknown_static": [{"random": {"count": 2, "placement": "on_route"}}],
            "moving": [{"random": {"count": 2}}, {"crossing": {}}],
        },
        "termination": {"timeout_s": 0.8, "stuck_after_s": 0.3},
        "stacks": {"global": ["a_star"], "local": ["dwa"]},
        "episodes": EPISODES,
        "seed": 5,
    })
}

/// A key and the values that may be tried for it; the first that a scenario accepts counts.
struct Variant {
    key: String,
    values: Vec<Value>,
    /// Whether this is one setting. Else it is a kind of thing, or a list, with defaults for all that is in it.
    is_setting: bool,
}

/// The subschema behind a `$ref`.
fn resolved(node: &Value) -> &Value {
    match node.get("$ref").and_then(Value::as_str) {
        Some(name) => resolved(Scenario::schema().pointer(&name[1..]).expect("a definition")),
        None => node,
    }
}

/// The subschemas of which a value has to fit one.
fn alternatives(node: &Value) -> Vec<&Value> {
    let node = resolved(node);
    match node.get("anyOf").or_else(|| node.get("oneOf")) {
        Some(Value::Array(nodes)) => nodes.iter().flat_map(alternatives).collect(),
        _ => vec![node],
    }
}

fn properties(node: &Value) -> impl Iterator<Item = (&String, &Value)> {
    node.get("properties").and_then(Value::as_object).into_iter().flatten()
}

fn required(node: &Value) -> BTreeSet<&str> {
    node.get("required").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str).collect()
}

fn is_of_type(node: &Value, name: &str) -> bool {
    match node.get("type") {
        Some(Value::Array(names)) => names.iter().any(|found| found == name),
        found => found.is_some_and(|found| found == name),
    }
}

/// Numbers that fit a node and are not the present one, those that are near it first.
fn numbers(node: &Value, now: &Value) -> Vec<Value> {
    let bound = |name: &str| node.get(name).and_then(Value::as_f64);
    let near = now.as_f64().map(|now| [2.0 * now, 0.5 * now, now + 1.0, now - 1.0]);
    let ends = [bound("minimum"), bound("maximum")].into_iter().flatten();
    let tried = near.into_iter().flatten().chain([1.0, 0.5, 2.0, 0.1, 0.0, 10.0, -1.0]).chain(ends);
    let is_whole = !is_of_type(node, "number");
    let fits = |x: &f64| {
        bound("minimum").is_none_or(|least| *x >= least)
            && bound("maximum").is_none_or(|most| *x <= most)
            && bound("exclusiveMinimum").is_none_or(|below| *x > below)
            && bound("exclusiveMaximum").is_none_or(|above| *x < above)
            && now.as_f64() != Some(*x)
            && (!is_whole || x.fract() == 0.0)
    };
    tried.filter(fits).map(|x| if is_whole { json!(x as i64) } else { json!(x) }).collect()
}

/// A value that fits a node, with as little in it as it allows.
fn least(node: &Value) -> Value {
    let node = alternatives(node)[0];
    if let Some(value) = node.get("const") {
        return value.clone();
    }
    if let Some(values) = node.get("enum") {
        return values[0].clone();
    }
    if is_of_type(node, "object") {
        let required = required(node);
        let entries = properties(node).filter(|(name, _)| required.contains(&name[..]));
        return Value::Object(entries.map(|(name, node)| (name.clone(), least(node))).collect());
    }
    if is_of_type(node, "array") {
        let count = node.get("minItems").and_then(Value::as_u64).unwrap_or(0);
        return (0..count).map(|_| least(&node["items"])).collect();
    }
    if is_of_type(node, "number") || is_of_type(node, "integer") {
        return numbers(node, &Value::Null)[0].clone();
    }
    if is_of_type(node, "boolean") { json!(false) } else { json!("other") }
}

/// Every way to change the value of a key by one setting within it.
fn variants(key: &str, node: &Value, now: &Value) -> Vec<Variant> {
    let mut found = Vec::new();
    let mut push = |values: Vec<Value>, is_setting: bool| {
        let values: Vec<Value> = values.into_iter().filter(|value| value != now).collect();
        if !values.is_empty() {
            found.push(Variant { key: key.to_owned(), values, is_setting });
        }
    };
    for node in alternatives(node) {
        // Lists whose items depend on each other show what fits.
        if let Some(examples) = node.get("examples").and_then(Value::as_array) {
            push(examples.clone(), true);
        }
        if let Some(value) = node.get("const") {
            push(vec![value.clone()], true);
        } else if let Some(values) = node.get("enum").and_then(Value::as_array) {
            values.iter().for_each(|value| push(vec![value.clone()], true));
        } else if is_of_type(node, "boolean") {
            push(vec![json!(true), json!(false)], true);
        } else if is_of_type(node, "number") || is_of_type(node, "integer") {
            push(numbers(node, now), true);
        } else if is_of_type(node, "string") {
            push(vec![json!("other"), json!("another")], true);
        } else if is_of_type(node, "array") || is_of_type(node, "object") {
            push(vec![least(node)], false);
        }
    }
    for node in alternatives(node) {
        if is_of_type(node, "array") {
            let count = node.get("minItems").and_then(Value::as_u64).unwrap_or(1) as usize;
            let item = now.get(0).unwrap_or(&Value::Null);
            found.extend(wrapped(variants(key, &node["items"], item), |value| vec![value; count.max(1)].into()));
        } else if is_of_type(node, "object") {
            let fits = |now: &Map<String, Value>| now.keys().all(|key| properties(node).any(|(name, _)| name == key));
            let around = match now.as_object().filter(|now| fits(now)) {
                Some(now) => now.clone(),
                None => least(node).as_object().expect("an object").clone(),
            };
            for (name, node) in properties(node) {
                let now = around.get(name).or_else(|| node.get("default")).unwrap_or(&Value::Null);
                let key = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                found.extend(wrapped(variants(&key, node, now), |value| {
                    let mut around = around.clone();
                    around.insert(name.clone(), value);
                    around.into()
                }));
            }
        }
    }
    found
}

fn wrapped(variants: Vec<Variant>, wrap: impl Fn(Value) -> Value) -> Vec<Variant> {
    let wrap = |variant: Variant| Variant { values: variant.values.into_iter().map(&wrap).collect(), ..variant };
    variants.into_iter().map(wrap).collect()
}

/// The experiment of a scenario, or why it is refused.
fn experiment(scenario: &Value) -> Result<Experiment, String> {
    let file = ScenarioFile::from_text("pairing.yaml", scenario.to_string());
    let scenario = file.read(&[]).map_err(|error| error.to_string())?;
    file.check(&scenario, &[]).map_err(|error| error.to_string())?;
    let points = file.points(&scenario, &[]).map_err(|error| error.to_string())?;
    Experiment::new(scenario, points, file.folder()).map_err(|error| error.to_string())
}

/// `world_digest` of each episode; `None` without a feasible world.
fn worlds(experiment: &Experiment) -> Vec<Option<Digest>> {
    (0..EPISODES)
        .map(|episode| experiment.drive_one(0, episode, 0).ok().and_then(|drive| drive.row.world_digest))
        .collect()
}

#[test]
fn no_setting_moves_the_world_but_those_of_the_world() {
    let base = base();
    let plain = experiment(&base).unwrap_or_else(|error| panic!("{error}"));
    let expected = worlds(&plain);
    assert!(expected.iter().all(Option::is_some), "{expected:?}");
    let (mut moved, mut set, mut never_set) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    for (name, node) in properties(Scenario::schema()) {
        if OF_THE_WORLD.contains(&&name[..]) || OF_OTHER_KEYS.contains(&&name[..]) {
            continue;
        }
        let now = base.get(name).or_else(|| node.get("default")).unwrap_or(&Value::Null);
        for variant in variants(name, node, now) {
            let scenarios = variant.values.iter().map(|value| {
                let mut scenario = base.clone();
                scenario[name] = value.clone();
                scenario
            });
            let differs = |experiment: &Experiment| experiment.scenario() != plain.scenario();
            match scenarios.filter_map(|scenario| experiment(&scenario).ok()).find(differs) {
                Some(experiment) => {
                    if worlds(&experiment) != expected {
                        moved.insert(variant.key.clone());
                    }
                    set.insert(variant.key);
                }
                None if variant.is_setting => {
                    never_set.insert(variant.key);
                }
                None => {}
            }
        }
    }
    let is_free = |key: &&String| !NEED_ANOTHER.contains(&key.as_str());
    let never_set: Vec<&String> = never_set.difference(&set).filter(is_free).collect();
    assert!(never_set.is_empty(), "no valid other value was found for {never_set:#?}");
    assert_eq!(
        moved,
        EXPECTED_TO_MOVE.map(str::to_owned).into(),
        "the keys that moved a world (left) are not those expected"
    );
    for key in [
        "limits.speed_max_mps",
        "sensing.lidar.rays",
        "stacks.local.dwa.horizon_s",
        "stacks.path.arc_fillet.clearance_m",
    ] {
        assert!(set.contains(key), "{key} was not tried: {set:#?}");
    }
}

/// The test sees what it looks for: settings of the world move the world.
#[test]
fn settings_of_the_world_move_it() {
    let expected = worlds(&experiment(&base()).unwrap_or_else(|error| panic!("{error}")));
    for (name, value) in [
        ("robot", json!({"radius_m": 0.7})),
        ("map", json!({"random": {"cols": 20, "rows": 20, "obstacles": 61}})),
        ("obstacles", json!({"moving": ["crossing"]})),
        ("goal", json!([10, 10])),
        ("seed", json!(6)),
    ] {
        let mut scenario = base();
        scenario[name] = value;
        let found = worlds(&experiment(&scenario).unwrap_or_else(|error| panic!("{error}")));
        assert_ne!(found, expected, "{name}");
    }
}
