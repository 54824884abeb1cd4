//! Ranges: every number of a scenario lies where physics allows, by the unit of its key.

use super::error::ScenarioError;
use super::key_path::KeyPath;
use crate::settings::{check_count, check_range, shown};
use serde_json::Value;

/// Keys that are checked elsewhere: a sweep's values at each of its points.
const LEFT_OUT: [&str; 2] = ["sweep", "seed"];

/// The numbers of a scenario, given as the tree of its keys, that lie outside of their ranges: each with its key and what was expected.
pub(super) fn faults(tree: &Value) -> Vec<ScenarioError> {
    let mut faults = Vec::new();
    let keys = tree.as_object().into_iter().flatten().filter(|(key, _)| !LEFT_OUT.contains(&key.as_str()));
    keys.for_each(|(key, value)| walk(&KeyPath::parse(key), key, value, false, &mut faults));
    faults
}

/// Checks the numbers below a key called `name`.
fn walk(path: &KeyPath, name: &str, value: &Value, is_listed: bool, faults: &mut Vec<ScenarioError>) {
    match value {
        Value::Object(keys) => {
            keys.iter().for_each(|(key, value)| walk(&path.clone().key(key), key, value, false, faults));
        }
        Value::Array(items) => {
            let items = items.iter().enumerate();
            items.for_each(|(index, value)| walk(&path.clone().item(index), name, value, true, faults));
        }
        Value::Number(number) => {
            let checked = match (number.as_u64(), number.as_f64()) {
                (Some(count), _) => check_count(name, count),
                (None, Some(value)) => check_range(name, value, is_listed),
                (None, None) => Ok(()),
            };
            faults.extend(checked.err().map(|expected| {
                let real = || shown(number.as_f64().unwrap_or_default());
                let found = number.as_u64().map_or_else(real, |count| count.to_string());
                ScenarioError::new(format!("`{path}` is {found}, expected {expected}"))
                    .key(path.clone())
                    .label(format!("expected {expected}"))
            }));
        }
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

#[cfg(test)]
mod tests {
    use crate::scenario::{Edit, ScenarioFile};

    const BASE: &str = "map: {empty: {cols: 9, rows: 9}}\nstacks: {global: [a_star], local: [dwa]}\n";

    /// The title of the error of one more line, and the place that it shows.
    fn refused(line: &str) -> String {
        let file = ScenarioFile::from_text("far.yaml", format!("{BASE}{line}\n"));
        let error = file.read(&[]).expect_err(line);
        assert!(error.to_string().contains("far.yaml:3"), "{error}");
        error.title().to_owned()
    }

    #[test]
    fn every_number_ends_where_physics_does() {
        for (line, title) in [
            ("limits: {speed_max_mps: 1e300}", "`limits.speed_max_mps` is 1e300, expected at most 1000 m/s"),
            ("actuation: {speed_noise_share: 1e30}", "`actuation.speed_noise_share` is 1e30, expected at most 100"),
            ("goal: [1e300, 4]", "`goal[0]` is 1e300, expected at most 100000000 m"),
            (
                "obstacles: {moving: [random: {count: 1000000000}]}",
                "`obstacles.moving[0].random.count` is 1000000000, expected at most 100000",
            ),
            ("robot: {radius_m: 1e-300}", "`robot.radius_m` is 1e-300, expected 0 or at least 0.000001 m"),
        ] {
            assert_eq!(refused(line), title);
        }
        let of_a_stack = "stacks: {global: [a_star], local: [{dwa: {horizon_s: 1e30}}]}";
        let file = ScenarioFile::from_text("far.yaml", format!("map: {{empty: {{cols: 9, rows: 9}}}}\n{of_a_stack}\n"));
        let error = file.read(&[]).expect_err("refused").to_string();
        assert!(error.contains("`stacks.local[0].dwa.horizon_s` is 1e30, expected at most 10000000 s"), "{error}");
    }

    #[test]
    fn an_edit_and_a_point_of_a_sweep_are_blamed_for_their_own_numbers() {
        let file = ScenarioFile::from_text("far.yaml", BASE);
        let edits = [Edit::parse("limits.speed_max_mps=1e9").expect("an edit")];
        let error = file.read(&edits).expect_err("refused").to_string();
        assert!(error.contains("--set limits.speed_max_mps=1e9") && error.contains("at most 1000 m/s"), "{error}");
        let file = ScenarioFile::from_text("far.yaml", format!("{BASE}sweep: {{limits.speed_max_mps: [1, 1e9]}}\n"));
        let scenario = file.read(&[]).expect("the sweep by itself");
        let error = file.points(&scenario, &[]).expect_err("refused").to_string();
        assert!(error.contains("sweep['limits.speed_max_mps'][1]") && error.contains("at most 1000 m/s"), "{error}");
    }
}
