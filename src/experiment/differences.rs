//! Settings in which the stacks of a comparison differ beside their planners.
//!
//! Two planners that are compared with different knowledge or a different right to plan again are not compared as planners.
//! That can be what is asked, so it is a note and no error.

use crate::plan::stack::{PlanningSpec, StackSpec};
use serde_json::Value;
use std::collections::BTreeMap;

/// Parameters of local planners that say what the planner may know or how it predicts, and not what it is.
const SHARED: [&str; 6] = ["predict_dynamic", "prediction", "normalise", "horizon_s", "movers_horizon_s", "room_m"];

/// One sentence for each setting that differs, in the order of the keys; stacks that do not have a setting do not count.
pub fn differences<'a>(stacks: impl Iterator<Item = &'a StackSpec>, planning: &PlanningSpec) -> Vec<String> {
    let mut settings: BTreeMap<&str, Vec<(String, &str)>> = BTreeMap::new();
    for stack in stacks {
        let mut add = |key: &'static str, value: String| {
            settings.entry(key).or_default().push((value, stack.name.as_str()));
        };
        if stack.global.is_some() {
            add("replan", words(stack.replan.as_ref().unwrap_or(&planning.replan)));
            add("sub_goals", words(stack.sub_goals.as_ref().unwrap_or(&planning.sub_goals)));
            add("movers", words(stack.movers.as_ref().unwrap_or(&planning.movers)));
        }
        add("speed_max_mps", words(&stack.caps.speed_max_mps));
        add("reverse_speed_max_mps", words(&stack.caps.reverse_speed_max_mps));
        let local = serde_json::to_value(&stack.local).unwrap_or_default();
        let params = local.as_object().and_then(|choice| choice.values().next());
        for key in SHARED {
            if let Some(value) = params.and_then(|params| params.get(key)) {
                add(key, words(value));
            }
        }
    }
    settings.iter().filter_map(|(key, values)| sentence(key, values)).collect()
}

/// `None` where all stacks have the same value.
fn sentence(key: &str, values: &[(String, &str)]) -> Option<String> {
    let mut by_value: Vec<(&str, Vec<&str>)> = Vec::new();
    for (value, stack) in values {
        match by_value.iter_mut().find(|(known, _)| known == value) {
            Some((_, stacks)) => stacks.push(stack),
            None => by_value.push((value, vec![stack])),
        }
    }
    let said: Vec<String> = by_value.iter().map(|(value, stacks)| format!("{value} ({})", stacks.join(", "))).collect();
    (by_value.len() > 1).then(|| format!("the stacks differ in `{key}`: {}", said.join("; ")))
}

/// A setting as it would stand in a scenario; `default` where it is absent.
fn words(value: &impl serde::Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(Value::Null) | Err(_) => "default".to_owned(),
        Ok(Value::String(text)) => text,
        Ok(Value::Object(choice))
            if choice.len() == 1 && choice.values().all(|params| params == &Value::Object(serde_json::Map::new())) =>
        {
            choice.keys().next().cloned().unwrap_or_default()
        }
        Ok(other) => other.to_string().replace('"', "").replace(':', ": ").replace(',', ", "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    fn said(stacks: &str) -> Vec<String> {
        let text = format!("map: {{empty: {{cols: 9, rows: 9}}}}\nstacks: {stacks}\n");
        let scenario: Scenario = serde_yaml::from_str(&text).unwrap();
        differences(scenario.stacks().iter(), &scenario.planning)
    }

    #[test]
    fn a_comparison_without_settings_is_even() {
        assert_eq!(said("{global: [a_star, theta_star], local: [dwa, imp_dwa, pure_pursuit]}"), [""; 0]);
    }

    #[test]
    fn what_differs_is_said_with_its_values_and_stacks() {
        assert_eq!(
            said("{global: [a_star], local: [{dwa: {predict_dynamic: false}}, imp_dwa, pure_pursuit]}"),
            ["the stacks differ in `predict_dynamic`: false (a_star+dwa); true (a_star+imp_dwa)"]
        );
        let differ =
            said("[{global: a_star, local: dwa, replan: never}, {global: theta_star, local: dwa, speed_max_mps: 0.5}]");
        assert_eq!(differ.len(), 2, "{differ:?}");
        assert!(
            differ[0].starts_with("the stacks differ in `replan`: never (a_star+dwa); {when_blocked: "),
            "{differ:?}"
        );
        assert_eq!(differ[1], "the stacks differ in `speed_max_mps`: default (a_star+dwa); 0.5 (theta_star+dwa)");
    }
}
