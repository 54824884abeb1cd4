//! Errors of scenarios, shown at their place in the file.

use super::key_path::KeyPath;
use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use serde::Serialize;
use std::fmt;
use std::ops::Range;

/// Reason why a scenario was refused: what was found and where, what was expected, and what to do.
///
/// [`Display`](fmt::Display) shows it like a compiler does, in plain text; [`render`](Self::render)
/// also in colour.
#[derive(Clone, Debug)]
pub struct ScenarioError(Box<Diagnosis>);

#[derive(Clone, Debug)]
struct Diagnosis {
    title: String,
    keys: Vec<(KeyPath, Option<String>)>,
    label: String,
    notes: Vec<String>,
    help: Vec<String>,
    place: Place,
    /// Faults beside this one.
    others: Vec<ScenarioError>,
}

/// Place of the fault.
#[derive(Clone, Debug)]
enum Place {
    /// Not looked up yet.
    Unknown,
    /// In a file, without a line (the whole of it, or something that is not there).
    File(String),
    /// In a text: the bytes `span` of it. `file` is absent for what was typed on the command line.
    Text { file: Option<String>, text: String, span: Range<usize> },
}

/// The parts of an error, for programs. What is not known is `None`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ErrorParts {
    /// What is wrong, in one sentence.
    pub message: String,
    /// The file at fault.
    pub file: Option<String>,
    /// The argument of the command line at fault, such as `--set a.b=x`; it is in no file.
    pub argument: Option<String>,
    /// Line in the file, from 1.
    pub line: Option<usize>,
    /// Column in the line, in characters from 1.
    pub column: Option<usize>,
    /// Path of the key at fault, such as `robot.radius_m`.
    pub key: Option<String>,
    /// What stands at that place: the first line of it.
    pub found: Option<String>,
    /// What is expected there.
    pub expected: Option<String>,
    /// Facts that help to understand.
    pub notes: Vec<String>,
    /// What to do.
    pub help: Vec<String>,
}

impl ScenarioError {
    /// An error with its first line: one sentence without full stop.
    pub(super) fn new(title: impl Into<String>) -> Self {
        Self(Box::new(Diagnosis {
            title: title.into(),
            keys: Vec::new(),
            label: String::new(),
            notes: Vec::new(),
            help: Vec::new(),
            place: Place::Unknown,
            others: Vec::new(),
        }))
    }

    /// All of these errors as one: those of files as a whole, then by the place in `file`, then those of other files and of the command line.
    /// Nothing is wrong if there is none.
    pub(super) fn all(errors: impl IntoIterator<Item = Self>, file: &str) -> Result<(), Self> {
        let mut errors: Vec<Self> = errors.into_iter().flat_map(Self::apart).collect();
        errors.sort_by_key(|error| match &error.0.place {
            Place::Unknown | Place::File(_) => (0, 0),
            Place::Text { file: Some(name), span, .. } if name == file => (1, span.start),
            Place::Text { file: Some(_), .. } => (2, 0),
            Place::Text { file: None, .. } => (3, 0),
        });
        let mut errors = errors.into_iter();
        let Some(mut first) = errors.next() else { return Ok(()) };
        first.0.others = errors.collect();
        Err(first)
    }

    /// The errors that were made one, each by itself.
    pub(super) fn apart(mut self) -> impl Iterator<Item = Self> {
        let others = std::mem::take(&mut self.0.others);
        std::iter::once(self).chain(others)
    }

    /// Names a key at fault. Of several, the one that was edited is shown, else the first in the file.
    pub(super) fn key(mut self, key: KeyPath) -> Self {
        self.0.keys.push((key, None));
        self
    }

    /// Names a key at fault, and what to write beside the caret if it is the one that is shown.
    pub(super) fn key_labelled(mut self, key: KeyPath, label: impl Into<String>) -> Self {
        self.0.keys.push((key, Some(label.into())));
        self
    }

    /// Takes the label of the key number `i`, which is the one that will be shown.
    pub(super) fn showing(mut self, i: usize) -> Self {
        if let Some((_, Some(label))) = self.0.keys.get(i) {
            self.0.label = label.clone();
        }
        self
    }

    /// Sets the text beside the caret.
    pub(super) fn label(mut self, label: impl Into<String>) -> Self {
        self.0.label = label.into();
        self
    }

    /// Adds a fact, to each error if it is several.
    pub(super) fn note(mut self, note: impl Into<String>) -> Self {
        let note = note.into();
        self.0.others.iter_mut().for_each(|other| other.0.notes.push(note.clone()));
        self.0.notes.push(note);
        self
    }

    /// Adds advice.
    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.0.help.push(help.into());
        self
    }

    /// Places the error in a text, unless it has a place.
    pub(super) fn at(mut self, file: Option<String>, text: &str, span: Range<usize>) -> Self {
        if matches!(self.0.place, Place::Unknown) {
            self.0.place = Place::Text { file, text: text.to_owned(), span };
        }
        self
    }

    /// Places the error in a file as a whole, unless it has a place.
    pub(super) fn in_file(mut self, file: impl Into<String>) -> Self {
        if matches!(self.0.place, Place::Unknown) {
            self.0.place = Place::File(file.into());
        }
        self
    }

    /// The keys at fault, the most important first; empty if the file as a whole is at fault. Of several faults, those of the first.
    pub fn keys(&self) -> impl ExactSizeIterator<Item = &KeyPath> {
        self.0.keys.iter().map(|(key, _)| key)
    }

    /// Whether the two say the same of the same place.
    pub(super) fn repeats(&self, other: &Self) -> bool {
        let place = |error: &Self| match &error.0.place {
            Place::Text { file, span, .. } => Some((file.clone(), span.clone())),
            Place::Unknown | Place::File(_) => None,
        };
        self.0.title == other.0.title && place(self) == place(other)
    }

    /// The first line of the message: what is wrong, in one sentence.
    pub fn title(&self) -> &str {
        &self.0.title
    }

    /// The parts of each fault.
    pub fn parts(&self) -> Vec<ErrorParts> {
        std::iter::once(self).chain(&self.0.others).map(Self::parts_alone).collect()
    }

    fn parts_alone(&self) -> ErrorParts {
        let Diagnosis { title, keys, label, notes, help, place, .. } = &*self.0;
        let mut parts = ErrorParts {
            message: title.clone(),
            key: keys.first().map(|(key, _)| key.to_string()).filter(|key| !key.is_empty()),
            notes: notes.clone(),
            help: help.clone(),
            ..ErrorParts::default()
        };
        match (label.strip_prefix("expected "), label.is_empty()) {
            (Some(expected), _) => parts.expected = Some(expected.to_owned()),
            // "did you mean …?" is advice; anything else is a fact.
            (None, false) if label.starts_with("did you mean") => parts.help.insert(0, label.clone()),
            (None, false) => parts.notes.insert(0, label.clone()),
            (None, true) => {}
        }
        match place {
            Place::Unknown => {}
            Place::File(file) => parts.file = Some(file.clone()),
            Place::Text { file, text, span } => {
                let (before, rest) = text.split_at(span.start);
                let marked = &rest[..span.len()];
                parts.found = marked.lines().next().filter(|found| !found.is_empty()).map(str::to_owned);
                if file.is_some() {
                    let line = before.rsplit('\n').next().unwrap_or_default();
                    parts.line = Some(before.matches('\n').count() + 1);
                    parts.column = Some(line.chars().count() + 1);
                    parts.file.clone_from(file);
                } else {
                    parts.argument = Some(text.clone());
                }
            }
        }
        parts
    }

    /// The whole message over several lines, without a line break at the end; several faults are parted by an empty line.
    pub fn render(&self, colour: bool) -> String {
        let parts = std::iter::once(self).chain(&self.0.others);
        parts.map(|part| part.render_alone(colour)).collect::<Vec<String>>().join("\n\n")
    }

    fn render_alone(&self, colour: bool) -> String {
        let Diagnosis { title, label, notes, help, place, .. } = &*self.0;
        let mut group = Group::with_title(Level::ERROR.primary_title(title));
        match place {
            Place::Unknown => {}
            Place::File(file) => group = group.element(Origin::path(file)),
            Place::Text { file, text, span } => {
                let mark = AnnotationKind::Primary.span(span.clone()).label(label);
                let snippet = Snippet::source(text).line_numbering(file.is_some()).path(file.as_ref());
                group = group.element(snippet.annotation(mark));
            }
        }
        group = group.elements(notes.iter().map(|note| Level::NOTE.message(note)));
        group = group.elements(help.iter().map(|help| Level::HELP.message(help)));
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        renderer.render(&[group])
    }
}

impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for ScenarioError {}
