//! The first check of a scenario's text, before its types: size, nesting, YAML syntax, keys written
//! twice, tags, numbers that are not finite.

use super::error::ScenarioError;
use super::explain;
use super::faults::FAULTS_MAX;
use super::key_path::KeyPath;
use serde::de::{DeserializeSeed, Deserializer, EnumAccess, Error, MapAccess, SeqAccess, Visitor};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::fmt;

/// Largest scenario file, bytes. Maps and recordings are files of their own and not counted.
pub(super) const SIZE_MAX_BYTES: usize = 1 << 20;

/// Deepest nesting of lists and keys. Real scenarios stay below 10.
const DEPTH_MAX: usize = 32;

/// Most opening brackets in one file. The time of the YAML scanner grows with the square of the number of
/// open brackets (a second for 10⁵); this bounds it without parsing quotes and comments.
const BRACKETS_MAX: usize = 20_000;

/// The message for `.nan` and `.inf`.
pub(super) const NOT_FINITE: &str = "not a finite number";

/// The end of the message for a key that was there before.
const TWICE: &str = "is written twice";

/// The end of the message for a number beyond those that scenarios have.
const TOO_LARGE: &str = "is too large";

/// Refuses a text that is too large or not well-formed. The numbers that are not finite are left to the caller: the rest of the text can
/// be read all the same.
pub(super) fn check(file: &str, text: &str) -> Result<Vec<(KeyPath, ScenarioError)>, ScenarioError> {
    if text.len() > SIZE_MAX_BYTES {
        return Err(too_large().in_file(file));
    }
    if let Some((open, _)) = text.match_indices(['[', '{']).nth(BRACKETS_MAX) {
        return Err(ScenarioError::new(format!("more than {BRACKETS_MAX} opening brackets"))
            .label("one too many")
            .help("move long lists into files of their own")
            .at(Some(file.to_owned()), text, open..open + 1));
    }
    if text.lines().all(|line| matches!(line.trim_start().chars().next(), None | Some('#'))) {
        return Err(ScenarioError::new("the scenario is empty").help(SMALLEST).in_file(file));
    }
    let (mut faults, mut is_readable) = (Vec::new(), true);
    while faults.len() < FAULTS_MAX {
        // One more walk for each fault, because the reader tells a position at its end only.
        let passed = Cell::new(faults.len());
        let walk = Walk { depth_left: DEPTH_MAX, passed: &passed };
        let Err(error) = walk.deserialize(serde_yaml::Deserializer::from_str(text)) else { break };
        let message = error.to_string();
        is_readable &= message.contains(NOT_FINITE);
        faults.push(explain::shape(&error, file, text));
        if ![NOT_FINITE, TWICE, TOO_LARGE].iter().any(|goes_on| message.contains(goes_on)) {
            break;
        }
    }
    if is_readable {
        return Ok(faults);
    }
    ScenarioError::all(faults.into_iter().map(|(_, error)| error), file).map(|()| Vec::new())
}

/// The error for a file of more than [`SIZE_MAX_BYTES`].
pub(super) fn too_large() -> ScenarioError {
    ScenarioError::new(format!("the scenario is larger than {} KiB", SIZE_MAX_BYTES / 1024))
        .help("is this the right file? Maps and recordings stay in files of their own, which the scenario names")
}

/// The smallest scenario, as advice in messages.
pub(super) const SMALLEST: &str = "the smallest scenario names a map and the planners to drive with:\n\
    map: {movingai: {file: my_map.map}}\nstacks: {global: [a_star], local: [dwa]}";

/// Walks over everything and keeps nothing.
#[derive(Clone, Copy)]
struct Walk<'a> {
    depth_left: usize,
    /// Faults that are to be passed over, because they are known.
    passed: &'a Cell<usize>,
}

impl Walk<'_> {
    /// A fault behind which the walk can go on.
    fn fault<E: Error>(self, message: impl FnOnce() -> String) -> Result<(), E> {
        pass_or_fail(self.passed, message)
    }

    fn deeper<E: Error>(self) -> Result<Self, E> {
        let depth_left = self.depth_left.checked_sub(1);
        depth_left
            .map(|depth_left| Self { depth_left, ..self })
            .ok_or_else(|| E::custom(format!("lists and keys are nested more than {DEPTH_MAX} deep")))
    }
}

impl<'de> DeserializeSeed<'de> for Walk<'_> {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Walk<'_> {
    type Value = ();
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("plain YAML")
    }
    fn visit_bool<E: Error>(self, _: bool) -> Result<(), E> {
        Ok(())
    }
    fn visit_u64<E: Error>(self, _: u64) -> Result<(), E> {
        Ok(())
    }
    fn visit_i64<E: Error>(self, _: i64) -> Result<(), E> {
        Ok(())
    }
    fn visit_u128<E: Error>(self, value: u128) -> Result<(), E> {
        self.fault(|| format!("the number {value} {TOO_LARGE}"))
    }
    fn visit_i128<E: Error>(self, value: i128) -> Result<(), E> {
        self.fault(|| format!("the number {value} {TOO_LARGE}"))
    }
    fn visit_f64<E: Error>(self, value: f64) -> Result<(), E> {
        if value.is_finite() { Ok(()) } else { self.fault(|| NOT_FINITE.to_owned()) }
    }
    fn visit_str<E: Error>(self, _: &str) -> Result<(), E> {
        Ok(())
    }
    fn visit_unit<E: Error>(self) -> Result<(), E> {
        Ok(())
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        let deeper = self.deeper()?;
        while seq.next_element_seed(deeper)?.is_some() {}
        Ok(())
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let deeper = self.deeper()?;
        let mut seen = BTreeSet::new();
        while map.next_key_seed(Key { seen: &mut seen, passed: self.passed })?.is_some() {
            map.next_value_seed(deeper)?;
        }
        Ok(())
    }
    fn visit_enum<A: EnumAccess<'de>>(self, data: A) -> Result<(), A::Error> {
        let (tag, _) = data.variant::<String>()?;
        Err(A::Error::custom(format!("scenarios use no YAML tags, found `!{tag}`")))
    }
}

/// Reads a key and refuses one seen before, at its own position.
struct Key<'a> {
    seen: &'a mut BTreeSet<String>,
    passed: &'a Cell<usize>,
}

/// Passes over a fault that is known, else fails with it.
fn pass_or_fail<E: Error>(passed: &Cell<usize>, message: impl FnOnce() -> String) -> Result<(), E> {
    match passed.get().checked_sub(1) {
        Some(left) => {
            passed.set(left);
            Ok(())
        }
        None => Err(E::custom(message())),
    }
}

impl<'de> DeserializeSeed<'de> for Key<'_> {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl Visitor<'_> for Key<'_> {
    type Value = ();
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a key")
    }
    fn visit_str<E: Error>(self, key: &str) -> Result<(), E> {
        if self.seen.insert(key.to_owned()) {
            Ok(())
        } else {
            pass_or_fail(self.passed, || format!("the key `{key}` {TWICE}"))
        }
    }
}
