//! The stacks of a scenario: a product of planners, or a list of stacks one by one.

use super::Name;
use crate::plan::global::GlobalChoice;
use crate::plan::local::LocalChoice;
use crate::plan::path::PathChoice;
use crate::plan::stack::{Replan, StackSpec};
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
    /// When to plan again; by default never.
    #[serde(default)]
    pub replan: Replan,
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
    /// When to plan again; by default never.
    #[serde(default)]
    pub replan: Replan,
}

impl Stacks {
    /// Every stack, in the order of rows in results.
    pub fn specs(&self) -> Vec<StackSpec> {
        match self {
            Self::Product(Product { global, path, local, replan }) => {
                let mut specs = Vec::new();
                for global in global {
                    for path in path {
                        for local in local {
                            specs.push(spec(None, global, path, local, replan));
                        }
                    }
                }
                specs
            }
            Self::List(stacks) => {
                stacks.iter().map(|s| spec(s.name.as_ref(), &s.global, &s.path, &s.local, &s.replan)).collect()
            }
        }
    }
}

fn spec(name: Option<&Name>, global: &Global, path: &[PathChoice], local: &LocalChoice, replan: &Replan) -> StackSpec {
    let mut spec = StackSpec {
        name: String::new(),
        global: global.0.clone(),
        path: path.to_vec(),
        local: local.clone(),
        replan: replan.clone(),
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
        json_schema!({"anyOf": [generator.subschema_for::<GlobalChoice>(), {"const": Self::NONE}]})
    }
}
