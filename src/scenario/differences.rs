//! Differences between two resolved scenarios.

use serde_yaml::Value;

/// Differences of the YAML text `here` from `there`: each differing key with both values, in words. Top-level keys in
/// `ignored` are skipped. `None` if one of the two is no YAML.
pub fn differences(there: &str, here: &str, ignored: &[&str]) -> Option<Vec<String>> {
    let (there, here) = (serde_yaml::from_str(there).ok()?, serde_yaml::from_str(here).ok()?);
    let mut found = Vec::new();
    compare(&mut String::new(), &there, &here, ignored, &mut found);
    Some(found)
}

/// Appends the differing keys below `path`.
fn compare(path: &mut String, there: &Value, here: &Value, ignored: &[&str], found: &mut Vec<String>) {
    if there == here {
        return;
    }
    let length = path.len();
    match (there, here) {
        (Value::Mapping(a), Value::Mapping(b)) => {
            let added = b.iter().filter(|(key, _)| !a.contains_key(*key));
            for (key, _) in a.iter().chain(added) {
                let name = short(key);
                if length == 0 && ignored.contains(&name.as_str()) {
                    continue;
                }
                if length > 0 {
                    path.push('.');
                }
                path.push_str(&name);
                match (a.get(key), b.get(key)) {
                    (Some(there), Some(here)) => compare(path, there, here, ignored, found),
                    (Some(there), None) => found.push(format!("`{path}`: {} there, absent here", short(there))),
                    (None, here) => {
                        found.push(format!("`{path}`: absent there, {} here", here.map_or_else(String::new, short)))
                    }
                }
                path.truncate(length);
            }
        }
        (Value::Sequence(a), Value::Sequence(b)) if a.len() == b.len() => {
            for (index, (there, here)) in a.iter().zip(b).enumerate() {
                path.push_str(&format!("[{index}]"));
                compare(path, there, here, ignored, found);
                path.truncate(length);
            }
        }
        _ => found.push(format!("`{path}`: {} there, {} here", short(there), short(here))),
    }
}

/// A value as one short line.
fn short(value: &Value) -> String {
    let text = serde_yaml::to_string(value).unwrap_or_default();
    let line = text.trim_end().replace('\n', " ");
    if line.chars().count() > 60 { line.chars().take(59).chain(['…']).collect() } else { line }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differing_keys_are_named_with_both_values_and_ignored_ones_are_not() {
        let found = differences("a: {b: [1, 2], c: 3}\nn: 1\n", "a: {b: [1, 4], d: 3}\nn: 2\n", &["n"]).unwrap();
        assert_eq!(found, ["`a.b[1]`: 2 there, 4 here", "`a.c`: 3 there, absent here", "`a.d`: absent there, 3 here"]);
        assert_eq!(differences("a: {n: 1}", "a: {n: 2}", &["n"]).unwrap(), ["`a.n`: 1 there, 2 here"]);
        assert_eq!(differences("a: [", "a: 1", &[]), None);
    }
}
