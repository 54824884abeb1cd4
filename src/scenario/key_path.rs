//! Key paths such as `stacks.local[0].dwa.horizon_s`, and where they stand in a YAML text.

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;
use std::ops::Range;

/// One step of a [`KeyPath`].
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Step {
    /// A key of a block of keys.
    Key(String),
    /// An item of a list, counted from 0.
    Item(usize),
}

impl Step {
    /// The key; empty for an item of a list.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Key(key) => key,
            Self::Item(_) => "",
        }
    }
}

/// The path from the top of a scenario to one of its values.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct KeyPath(Vec<Step>);

impl KeyPath {
    /// The path written as `a.b[0].c`, as the YAML reader does.
    pub fn parse(text: &str) -> Self {
        let mut steps = Vec::new();
        for part in text.split('.').filter(|part| !part.is_empty()) {
            let (key, items) = part.split_at(part.find('[').unwrap_or(part.len()));
            if !key.is_empty() {
                steps.push(Step::Key(key.to_owned()));
            }
            steps.extend(items.split(['[', ']']).filter_map(|index| index.parse().ok()).map(Step::Item));
        }
        Self(steps)
    }

    /// The steps from the top.
    pub fn steps(&self) -> &[Step] {
        &self.0
    }

    /// Whether it is the top itself.
    pub fn is_top(&self) -> bool {
        self.0.is_empty()
    }

    /// The path one step shorter; the top stays the top.
    pub fn parent(&self) -> Self {
        Self(self.0[..self.0.len().saturating_sub(1)].to_vec())
    }

    /// The path one step further, to a key.
    pub fn key(mut self, key: impl Into<String>) -> Self {
        self.0.push(Step::Key(key.into()));
        self
    }

    /// The path one step further, to an item of a list.
    pub fn item(mut self, index: usize) -> Self {
        self.0.push(Step::Item(index));
        self
    }

    /// The path as `--set` writes it: `stacks.local.0.dwa`.
    pub fn dotted(&self) -> String {
        self.to_string().replace('[', ".").replace(']', "")
    }

    /// Whether one of the two leads to the other, or both are the same.
    pub fn touches(&self, other: &Self) -> bool {
        self.0.iter().zip(&other.0).all(|(a, b)| a == b)
    }
}

impl fmt::Display for KeyPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if i == 0 => f.write_str(key)?,
                Step::Key(key) => write!(f, ".{key}")?,
                Step::Item(index) => write!(f, "[{index}]")?,
            }
        }
        Ok(())
    }
}

/// The bytes to underline for `path` in `text`: those of the longest beginning of it that is in the text.
/// `None` if not even the first key is, or the text is not YAML.
pub(super) fn locate(text: &str, path: &KeyPath) -> Option<Range<usize>> {
    (1..=path.0.len()).rev().find_map(|count| locate_exactly(text, &path.0[..count]))
}

/// The bytes of the key at the end of `path`; those of [`locate`] if it is not in the text.
pub(super) fn locate_key(text: &str, path: &KeyPath) -> Option<Range<usize>> {
    offset(text, &path.0, Part::Key).map(|start| token(text, start)).or_else(|| locate(text, path))
}

/// Whether the whole of `path` is in `text`.
pub(super) fn exists(text: &str, path: &KeyPath) -> bool {
    offset(text, &path.0, Part::Value).is_some()
}

/// The value where it begins on the line of its key, else the key.
fn locate_exactly(text: &str, steps: &[Step]) -> Option<Range<usize>> {
    let value = offset(text, steps, Part::Value)?;
    let key = match steps.last() {
        Some(Step::Key(_)) => offset(text, steps, Part::Key),
        _ => None,
    };
    match key {
        // An alias has its value where the anchor is.
        Some(key) if value < key => Some(token(text, key)),
        Some(key) if text[key..value].contains('\n') || text[value..].starts_with(['\n', '\r']) => {
            Some(token(text, key))
        }
        Some(key) if value == text.len() => Some(token(text, key)),
        _ => Some(token(text, value)),
    }
}

/// The bytes of the token that begins at `start`: a quoted text, a bracket with what it holds, or a
/// plain word up to the next separator; never past the end of its line, and never empty unless the line ends.
pub(super) fn token(text: &str, start: usize) -> Range<usize> {
    let rest = &text[start..];
    let line = &rest[..rest.find(['\n', '\r']).unwrap_or(rest.len())];
    let length = match line.chars().next() {
        Some(quote @ ('"' | '\'')) => line[1..].find(quote).map(|end| end + 2),
        Some(open @ ('[' | '{')) => {
            let close = if open == '[' { ']' } else { '}' };
            let mut depth = 0;
            line.char_indices().find_map(|(i, c)| {
                depth += i32::from(c == open) - i32::from(c == close);
                (depth == 0).then_some(i + 1)
            })
        }
        _ => [" #", ": ", ", ", "]", "}"].iter().filter_map(|end| line.find(end)).filter(|&end| end > 0).min(),
    };
    let word = line[..length.unwrap_or(line.len())].trim_end();
    let word = if word.starts_with(['"', '\'', '[', '{']) { word } else { word.trim_end_matches([':', ',']) };
    start..start + word.len()
}

/// Which end of an entry to find.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    Key,
    Value,
}

/// Byte offset of the key or value at the end of `steps`. The walk ends in an error raised on
/// purpose, because that is where the YAML reader tells a position.
fn offset(text: &str, steps: &[Step], part: Part) -> Option<usize> {
    let error = Walk { steps, part }.deserialize(serde_yaml::Deserializer::from_str(text)).err()?;
    (error.to_string().contains(HERE)).then(|| error.location())?.map(|location| location.index())
}

const HERE: &str = "\u{1}here";

#[derive(Clone, Copy)]
struct Walk<'a> {
    steps: &'a [Step],
    part: Part,
}

impl<'de> DeserializeSeed<'de> for Walk<'_> {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        if self.steps.is_empty() { deserializer.deserialize_any(Stop) } else { deserializer.deserialize_any(self) }
    }
}

impl<'de> Visitor<'de> for Walk<'_> {
    type Value = ();
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list or keys")
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        let Step::Key(wanted) = &self.steps[0] else { return Err(A::Error::custom("not a list")) };
        let stop = self.part == Part::Key && self.steps.len() == 1;
        while let Some(found) = map.next_key_seed(Key { wanted, stop })? {
            if found {
                return map.next_value_seed(Walk { steps: &self.steps[1..], ..self });
            }
            map.next_value::<IgnoredAny>()?;
        }
        Ok(())
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<(), A::Error> {
        let Step::Item(wanted) = self.steps[0] else { return Err(A::Error::custom("not keys")) };
        for _ in 0..wanted {
            if seq.next_element::<IgnoredAny>()?.is_none() {
                return Ok(());
            }
        }
        seq.next_element_seed(Walk { steps: &self.steps[1..], ..self }).map(|_| ())
    }
}

/// Reads a key; at the wanted one it may stop.
struct Key<'a> {
    wanted: &'a str,
    stop: bool,
}

impl<'de> DeserializeSeed<'de> for Key<'_> {
    type Value = bool;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<bool, D::Error> {
        deserializer.deserialize_str(self)
    }
}

impl Visitor<'_> for Key<'_> {
    type Value = bool;
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a key")
    }
    fn visit_str<E: Error>(self, key: &str) -> Result<bool, E> {
        if key == self.wanted && self.stop { Err(E::custom(HERE)) } else { Ok(key == self.wanted) }
    }
}

/// Refuses everything: whatever the type, its visitor's default is an error with `expecting` in it.
struct Stop;

impl Visitor<'_> for Stop {
    type Value = ();
    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(HERE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown<'a>(text: &'a str, path: &str) -> &'a str {
        &text[locate(text, &KeyPath::parse(path)).unwrap()]
    }

    #[test]
    fn paths_read_back_as_they_were_written() {
        for text in ["a", "a.b", "stacks.local[0].dwa.horizon_s", "a[1][2].b"] {
            assert_eq!(KeyPath::parse(text).to_string(), text);
        }
        assert!(KeyPath::parse("").is_top());
    }

    #[test]
    fn a_key_path_is_found_in_the_text() {
        let text = "é: ü # first\nlimits:\n  speed: 1.5  # fast\n  \"yaw rate\": 2\nstacks:\n  local:\n  - dwa\n  - dwa: {horizon_s: 3, n: 4}\n  path: [[a, b], []]\nnothing:\nlast:";
        assert_eq!(shown(text, "é"), "ü");
        assert_eq!(shown(text, "limits.speed"), "1.5");
        assert_eq!(shown(text, "limits"), "limits");
        assert_eq!(shown(text, "limits.yaw rate"), "2");
        assert_eq!(shown(text, "stacks.local[0]"), "dwa");
        assert_eq!(shown(text, "stacks.local[1]"), "dwa");
        assert_eq!(shown(text, "stacks.local[1].dwa"), "{horizon_s: 3, n: 4}");
        assert_eq!(shown(text, "stacks.local[1].dwa.horizon_s"), "3");
        assert_eq!(shown(text, "stacks.path[0][1]"), "b");
        assert_eq!(shown(text, "stacks.path[1]"), "[]");
        assert_eq!(shown(text, "nothing"), "nothing");
        assert_eq!(shown(text, "last"), "last");
        // The nearest place above, where the key itself is not in the text.
        assert_eq!(shown(text, "limits.reverse.x"), "limits");
        assert_eq!(shown(text, "stacks.local[7]"), "local");
        assert_eq!(locate(text, &KeyPath::parse("goal")), None);
        assert_eq!(locate("a", &KeyPath::parse("a")), None);
    }
}
