//! A named choice with parameters, as scenario files write it: `name` or `name: {params}`.
//!
//! The macro `choice!` turns a list of modules, each with a `Params` type, into one enum whose variants
//! are called like the modules, and derives everything that must agree with that list: reading
//! (with "did you mean"), writing, the JSON Schema and the list of names. The parameters are read
//! straight from the file's own reader, so that an error keeps its line, column and key path.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{DeserializeOwned, Error, MapAccess, value::MapDeserializer};
use serde_json::json;

/// Reason why a name is refused: it is unknown, or it needs parameters as well.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NameError(String);

impl NameError {
    /// The error for `found`, which is not in `known`; the message names the nearest known name if one is near.
    pub fn unknown(what: &str, found: &str, known: &[impl AsRef<str>]) -> Self {
        let known: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
        Self(unknown_name(what, found, &known))
    }
}

impl Error for NameError {
    fn custom<T: std::fmt::Display>(message: T) -> Self {
        Self(message.to_string())
    }
}

/// The message for a name that is not in `known`, with the nearest known name if one is near.
pub fn unknown_name(what: &str, found: &str, known: &[&str]) -> String {
    let hint = nearest(found, known).map_or(String::new(), |name| format!(", did you mean `{name}`?"));
    format!("unknown {what} `{found}`{hint} (known: {})", known.join(", "))
}

/// The known name most similar to `found`, if it is similar enough for a typing error; ties go to the first.
pub fn nearest<'a>(found: &str, known: &[&'a str]) -> Option<&'a str> {
    let (mut best, mut best_score) = (None, 0.72);
    for &name in known {
        let score = strsim::jaro_winkler(&found.to_lowercase(), name);
        if score > best_score {
            (best, best_score) = (Some(name), score);
        }
    }
    best
}

/// Parameters with every default, for a choice that was written by its name alone.
///
/// # Errors
/// If a parameter without default is missing.
pub fn defaults<P: DeserializeOwned, E: Error>() -> Result<P, E> {
    P::deserialize(MapDeserializer::<_, E>::new(core::iter::empty::<(&str, &str)>()))
}

/// The parameters of a choice written as `name: {params}`; `name:` alone means every default.
///
/// # Errors
/// The error of the parameters' own reader.
pub fn value<'de, P: DeserializeOwned, A: MapAccess<'de>>(map: &mut A) -> Result<P, A::Error> {
    match map.next_value::<Option<P>>()? {
        Some(params) => Ok(params),
        None => defaults(),
    }
}

/// The JSON Schema of one kind of a choice: by its name alone if every parameter has a default, and with its parameters.
///
/// Without a `summary`, the documentation of the parameters describes the kind.
pub fn kind_schemas<P: JsonSchema>(generator: &mut SchemaGenerator, name: &str, summary: Option<&str>) -> Vec<Schema> {
    let params = P::json_schema(generator);
    let described = || params.get("description")?.as_str()?.split("\n\n").next().map(|text| text.replace('\n', " "));
    let description = summary.map(str::to_owned).or_else(described).unwrap_or_default();
    let reference = generator.subschema_for::<P>();
    let alone = params
        .get(ALONE)
        .and_then(|key| key.as_str())
        .map(|key| json!({"type": "string", "description": format!("`{key}` alone.")}));
    if params.get("required").is_some() {
        let with_params = match alone {
            None => json!({"description": description, "allOf": [reference]}),
            Some(alone) => json!({"description": description, "anyOf": [reference, alone]}),
        };
        return vec![with_key(name, &with_params)];
    }
    let with_params = json!({"description": description, "anyOf": [reference, {"type": "null"}]});
    vec![json_schema!({"const": name, "description": description}), with_key(name, &with_params)]
}

/// Keyword of schemas of parameters: the parameter that may stand alone, as a text, in place of the block (`or_text!`).
pub const ALONE: &str = "x-alone";

/// Reads and writes parameters of which one, a text, may stand alone: `ros: site.yaml` is `ros: {file: site.yaml}`.
///
/// The type derives both traits with `#[serde(remote = "Self")]`, and its schema says `#[schemars(extend("x-alone" = "file"))]`.
macro_rules! or_text {
    ($Params:ident, $key:literal) => {
        impl<'de> serde::Deserialize<'de> for $Params {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Reader;
                impl<'de> serde::de::Visitor<'de> for Reader {
                    type Value = $Params;
                    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                        f.write_str(concat!("a block of keys, or `", $key, "` alone"))
                    }
                    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<$Params, E> {
                        let keys = [($key, text)].into_iter();
                        $Params::deserialize(serde::de::value::MapDeserializer::<_, E>::new(keys))
                    }
                    fn visit_map<A: serde::de::MapAccess<'de>>(self, map: A) -> Result<$Params, A::Error> {
                        $Params::deserialize(serde::de::value::MapAccessDeserializer::new(map))
                    }
                }
                deserializer.deserialize_any(Reader)
            }
        }

        impl serde::Serialize for $Params {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                $Params::serialize(self, serializer)
            }
        }
    };
}
pub(crate) use or_text;

/// The schema of `name: {parameters}`.
fn with_key(name: &str, value: &serde_json::Value) -> Schema {
    json_schema!({"type": "object", "properties": {name: value}, "required": [name], "additionalProperties": false})
}

/// Makes the enum of a choice; see the module's documentation.
///
/// `choice! { /// docs  pub enum Name: "what it is called in errors" { module = "one line: what it is", … } }`; the line may be left out.
macro_rules! choice {
    ($(#[$doc:meta])* $vis:vis enum $Name:ident: $what:literal { $($module:ident $(= $summary:expr)?),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        #[expect(non_camel_case_types, reason = "a variant is called like its module and like its name in YAML")]
        $vis enum $Name {
            $(#[doc = concat!("`", stringify!($module), "`: see [`mod@", stringify!($module), "`].")]
            $module($module::Params)),+
        }

        impl $Name {
            /// The names in the order of the registry.
            pub const NAMES: &'static [&'static str] = &[$(stringify!($module)),+];

            /// The name as scenario files write it.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$module(_) => stringify!($module)),+ }
            }

            /// The choice of that name with every parameter at its default.
            ///
            /// # Errors
            /// If the name is unknown or a parameter has no default.
            pub fn by_name(name: &str) -> Result<Self, $crate::settings::choice::NameError> {
                <Self as serde::Deserialize>::deserialize(serde::de::value::StrDeserializer::new(name))
            }
        }

        impl<'de> serde::Deserialize<'de> for $Name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct Reader;
                impl<'de> serde::de::Visitor<'de> for Reader {
                    type Value = $Name;
                    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                        write!(f, "a {}: `name` or `name: {{parameters}}`", $what)
                    }
                    fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<$Name, E> {
                        match name {
                            $(stringify!($module) => Ok($Name::$module($crate::settings::choice::defaults()?)),)+
                            _ => Err(E::custom($crate::settings::choice::unknown_name($what, name, $Name::NAMES))),
                        }
                    }
                    fn visit_map<A: serde::de::MapAccess<'de>>(self, mut map: A) -> Result<$Name, A::Error> {
                        use serde::de::Error as _;
                        let Some(name) = map.next_key::<String>()? else {
                            return Err(A::Error::custom(concat!("expected the name of a ", $what)));
                        };
                        let choice = match name.as_str() {
                            $(stringify!($module) => $Name::$module($crate::settings::choice::value(&mut map)?),)+
                            _ => return Err(A::Error::custom($crate::settings::choice::unknown_name($what, &name, $Name::NAMES))),
                        };
                        match map.next_key::<String>()? {
                            None => Ok(choice),
                            Some(second) => Err(A::Error::custom(format!(
                                concat!("expected one ", $what, ", found `{}` and `{}` (is the indentation right?)"), name, second
                            ))),
                        }
                    }
                }
                deserializer.deserialize_any(Reader)
            }
        }

        impl serde::Serialize for $Name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                use serde::ser::SerializeMap;
                let mut map = serializer.serialize_map(Some(1))?;
                match self { $(Self::$module(params) => map.serialize_entry(stringify!($module), params)?),+ }
                map.end()
            }
        }

        impl schemars::JsonSchema for $Name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($Name).into()
            }
            fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                let mut forms = Vec::new();
                $(forms.extend($crate::settings::choice::kind_schemas::<$module::Params>(
                    generator,
                    stringify!($module),
                    None$(.or(Some($summary)))?,
                ));)+
                schemars::json_schema!({"anyOf": forms})
            }
        }
    };
}
pub(crate) use choice;
