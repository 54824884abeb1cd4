//! The stacks of a scenario: a product of planners, or a list of stacks one by one.

use super::{KeyPath, Name, Step};
use crate::plan::global::GlobalChoice;
use crate::plan::local::LocalChoice;
use crate::plan::path::PathChoice;
use crate::plan::stack::{Caps, Movers, Replan, StackSpec, SubGoals};
use crate::settings::quantity::{NonNegative, Positive};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;

/// Which planners drive (scenario key `stacks`).
#[derive(Clone, Debug, PartialEq)]
pub enum Stacks {
    /// Every global planner with every path treatment and every local planner.
    Product(Product),
    /// Stacks one by one.
    List(Vec<Listed>),
}

/// Every combination, in the order global, path, local (the last one changes fastest).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Product {
    /// Global planners; `none` drives the local planner alone, with the goal as its only sub-goal.
    pub global: Vec<Global>,
    /// Path treatments, each a list of stages in order; by default one without stages.
    #[serde(default = "untreated")]
    pub path: Vec<Vec<PathChoice>>,
    /// Local planners.
    pub local: Vec<LocalChoice>,
    /// When to plan again; by default what `planning.replan` says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub replan: Option<Replan>,
    /// Which point of the path to steer for; by default what `planning.sub_goals` says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sub_goals: Option<SubGoals>,
    /// What sensed movers are to the global planner; by default what `planning.movers` says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub movers: Option<Movers>,
    /// Highest forward speed that the planners may use, m/s; by default, and at most, that of `limits`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_max_mps: Option<Positive>,
    /// Highest reverse speed that the planners may use, m/s; by default, and at most, that of `limits`. 0 forbids reversing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reverse_speed_max_mps: Option<NonNegative>,
}

fn untreated() -> Vec<Vec<PathChoice>> {
    vec![Vec::new()]
}

/// One stack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Listed {
    /// Name in results; by default `global[+path…]+local`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<Name>,
    /// The global planner; `none` drives the local planner alone, with the goal as its only sub-goal.
    pub global: Global,
    /// Path stages in order; by default none.
    #[serde(default)]
    pub path: Vec<PathChoice>,
    /// The local planner.
    pub local: LocalChoice,
    /// When to plan again; by default what `planning.replan` says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub replan: Option<Replan>,
    /// Which point of the path to steer for; by default what `planning.sub_goals` says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sub_goals: Option<SubGoals>,
    /// What sensed movers are to the global planner; by default what `planning.movers` says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub movers: Option<Movers>,
    /// Highest forward speed that the planners may use, m/s; by default, and at most, that of `limits`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_max_mps: Option<Positive>,
    /// Highest reverse speed that the planners may use, m/s; by default, and at most, that of `limits`. 0 forbids reversing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reverse_speed_max_mps: Option<NonNegative>,
}

impl Stacks {
    /// Every stack, in the order of rows in results.
    pub fn specs(&self) -> Vec<StackSpec> {
        match self {
            Self::Product(product) => {
                let Product { global, path, local, .. } = product;
                let rules = Rules::of_product(product);
                let mut specs = Vec::new();
                for global in global {
                    for path in path {
                        for local in local {
                            specs.push(spec(None, global, path, local, &rules));
                        }
                    }
                }
                specs
            }
            Self::List(stacks) => stacks
                .iter()
                .map(|s| spec(s.name.as_ref(), &s.global, &s.path, &s.local, &Rules::of_listed(s)))
                .collect(),
        }
    }
}

impl Stacks {
    /// For each stack, whether a change of the value at `path` (from the top of the scenario) can concern it, in the order of
    /// [`Self::specs`]: a value outside `stacks` concerns all of them, a planner those that it is part of.
    pub(super) fn touched_by(&self, path: &KeyPath) -> Vec<bool> {
        let below = match path.steps() {
            [Step::Key(top), below @ ..] if top == "stacks" => below,
            _ => &[],
        };
        match (self, below) {
            (Self::List(stacks), [Step::Item(item), ..]) => (0..stacks.len()).map(|stack| stack == *item).collect(),
            (Self::Product(product), [Step::Key(list), Step::Item(item), ..]) => {
                let (paths, locals) = (product.path.len(), product.local.len());
                let holds = |stack: usize| match list.as_str() {
                    "global" => stack / (paths * locals) == *item,
                    "path" => stack / locals % paths == *item,
                    "local" => stack % locals == *item,
                    _ => true,
                };
                (0..product.global.len() * paths * locals).map(holds).collect()
            }
            _ => vec![true; self.specs().len()],
        }
    }
}

/// Settings of a stack beside its planners.
struct Rules {
    replan: Option<Replan>,
    sub_goals: Option<SubGoals>,
    movers: Option<Movers>,
    caps: Caps,
}

impl Rules {
    fn of_product(product: &Product) -> Self {
        let Product { replan, sub_goals, movers, speed_max_mps, reverse_speed_max_mps, .. } = product.clone();
        Self { replan, sub_goals, movers, caps: Caps { speed_max_mps, reverse_speed_max_mps } }
    }

    fn of_listed(listed: &Listed) -> Self {
        let Listed { replan, sub_goals, movers, speed_max_mps, reverse_speed_max_mps, .. } = listed.clone();
        Self { replan, sub_goals, movers, caps: Caps { speed_max_mps, reverse_speed_max_mps } }
    }
}

fn spec(name: Option<&Name>, global: &Global, path: &[PathChoice], local: &LocalChoice, rules: &Rules) -> StackSpec {
    let mut spec = StackSpec {
        name: String::new(),
        global: global.0.clone(),
        path: path.to_vec(),
        local: local.clone(),
        replan: rules.replan.clone(),
        sub_goals: rules.sub_goals.clone(),
        movers: rules.movers.clone(),
        caps: rules.caps,
    };
    spec.name = name.map_or_else(|| spec.default_name(), |name| name.as_str().to_owned());
    spec
}

impl<'de> Deserialize<'de> for Stacks {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Stacks;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("`{global: […], local: […]}` or a list of stacks")
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Stacks, A::Error> {
                Product::deserialize(MapAccessDeserializer::new(map)).map(Stacks::Product)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Stacks, A::Error> {
                Vec::deserialize(SeqAccessDeserializer::new(seq)).map(Stacks::List)
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

impl Serialize for Stacks {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Product(product) => product.serialize(serializer),
            Self::List(stacks) => stacks.serialize(serializer),
        }
    }
}

impl JsonSchema for Stacks {
    fn schema_name() -> Cow<'static, str> {
        "Stacks".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({"anyOf": [generator.subschema_for::<Product>(), generator.subschema_for::<Vec<Listed>>()]})
    }
}

/// A global planner, or `none`.
#[derive(Clone, Debug, PartialEq)]
pub struct Global(pub Option<GlobalChoice>);

impl Global {
    const NONE: &str = "none";
}

impl<'de> Deserialize<'de> for Global {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Global;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a global planner: `name`, `name: {parameters}` or `none`")
            }
            fn visit_str<E: Error>(self, name: &str) -> Result<Global, E> {
                match name {
                    Global::NONE => Ok(Global(None)),
                    _ => {
                        GlobalChoice::deserialize(serde::de::value::StrDeserializer::new(name)).map(|g| Global(Some(g)))
                    }
                }
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Global, A::Error> {
                GlobalChoice::deserialize(MapAccessDeserializer::new(map)).map(|choice| Global(Some(choice)))
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

impl Serialize for Global {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0 {
            Some(choice) => choice.serialize(serializer),
            None => serializer.serialize_str(Self::NONE),
        }
    }
}

impl JsonSchema for Global {
    fn schema_name() -> Cow<'static, str> {
        "Global".into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({"anyOf": [generator.subschema_for::<GlobalChoice>(), {"const": Self::NONE, "description": "No global planner: the local one drives alone, with the goal as its only sub-goal."}]})
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<String> {
        serde_yaml::from_str::<Stacks>(text).unwrap().specs().into_iter().map(|spec| spec.name).collect()
    }

    #[test]
    fn a_product_is_every_combination_the_last_changing_fastest() {
        let text = "{global: [a_star, none], path: [[], [line_of_sight]], local: [dwa, pure_pursuit]}";
        let expected = [
            "a_star+dwa",
            "a_star+pure_pursuit",
            "a_star+line_of_sight+dwa",
            "a_star+line_of_sight+pure_pursuit",
            "none+dwa",
            "none+pure_pursuit",
            "none+line_of_sight+dwa",
            "none+line_of_sight+pure_pursuit",
        ];
        assert_eq!(names(text), expected);
    }

    #[test]
    fn every_spelling_of_a_choice_is_the_same_choice() {
        let plain: Stacks = serde_yaml::from_str("{global: [a_star], local: [dwa], replan: never}").unwrap();
        for text in [
            "{global: [a_star: {}], local: [dwa: {}], path: [[]], replan: never}",
            "{global: [{a_star: {}}], local: [{dwa: {}}], replan: {never: {}}}",
            "global:\n- a_star:\nlocal:\n- dwa:\nreplan:\n  never:\n",
            "{global: ['a_star'], local: [\"dwa\"], replan: 'never'}",
            "global:\n  - a_star: ~\nlocal:\n  - dwa: {}\nreplan:\n  never: ~\n",
        ] {
            assert_eq!(serde_yaml::from_str::<Stacks>(text).unwrap(), plain, "{text}");
        }
    }

    #[test]
    fn listed_stacks_keep_their_order_and_their_own_names() {
        let text = "
- {global: dijkstra, local: dwa}
- name: alone
  global: none
  local: {pure_pursuit: {lookahead_m: 1.5}}
  replan: {every: {period_s: 2}}
- {global: a_star, path: [line_of_sight], local: dwa, replan: when_stuck}
";
        assert_eq!(names(text), ["dijkstra+dwa", "alone", "a_star+line_of_sight+dwa"]);
        let specs = serde_yaml::from_str::<Stacks>(text).unwrap().specs();
        assert_eq!(specs[1].global, None);
        let replan = |k: usize| specs[k].replan.as_ref().map(Replan::name);
        assert_eq!((replan(0), replan(1), replan(2)), (None, Some("every"), Some("when_stuck")));
    }

    #[test]
    fn a_key_touches_the_stacks_that_its_planner_is_part_of() {
        let text = "{global: [a_star, none], path: [[], [line_of_sight]], local: [dwa, pure_pursuit]}";
        let product: Stacks = serde_yaml::from_str(text).unwrap();
        let touched = |stacks: &Stacks, path: &str| -> Vec<String> {
            let touched = stacks.touched_by(&KeyPath::parse(path));
            assert_eq!(touched.len(), stacks.specs().len());
            let names = stacks.specs().into_iter().map(|spec| spec.name).zip(touched);
            names.filter(|(_, touched)| *touched).map(|(name, _)| name).collect()
        };
        for (path, part, count) in [
            ("stacks.global[0].a_star.corner_rule", "a_star", 4),
            ("stacks.global[1]", "none", 4),
            ("stacks.path[1][0].line_of_sight", "line_of_sight", 4),
            ("stacks.local[1].pure_pursuit.lookahead_m", "pure_pursuit", 4),
        ] {
            let names = touched(&product, path);
            assert!(
                names.len() == count && names.iter().all(|name| name.split('+').any(|p| p == part)),
                "{path}: {names:?}"
            );
        }
        for path in ["limits.speed_max_mps", "stacks.replan", "stacks.local", "stacks", "planning.inflation_m"] {
            assert_eq!(touched(&product, path).len(), 8, "{path}");
        }
        let list: Stacks = serde_yaml::from_str("[{global: a_star, local: dwa}, {global: none, local: dwa}]").unwrap();
        assert_eq!(touched(&list, "stacks[1].local.dwa.horizon_s"), ["none+dwa"]);
        assert_eq!(touched(&list, "robot.radius_m").len(), 2);
    }
}
