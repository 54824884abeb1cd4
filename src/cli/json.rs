//! `--format json`: one document on stdout, whether the command succeeds or not.
//!
//! Every document has `simrun` (the version), `command`, `exit_code` and `errors`, a list that is empty if nothing went wrong; what was
//! found before a fault is there as well. The same messages go to stderr, for people. `docs/book/src/json.md` describes the keys.

use super::{Failure, Out, print};
use crate::scenario::ErrorParts;
use serde_json::{Map, Value as Json, json};
use std::ffi::OsString;

/// Format of what commands print that have no tables for papers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum TextOrJson {
    /// For people.
    #[default]
    Text,
    /// One JSON document.
    Json,
}

/// An object of JSON.
pub(super) type Object = Map<String, Json>;

/// Does a command's work, which fills the document, and writes it.
pub(super) fn answer(
    command: &str,
    out: &Out,
    work: impl FnOnce(&mut Object) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let mut document = opened(command);
    let result = work(&mut document);
    document.extend(end(&result));
    out.write(&text(&document))?;
    result
}

/// The keys with which every document begins.
pub(super) fn opened(command: &str) -> Object {
    Object::from_iter([("simrun".to_owned(), env!("CARGO_PKG_VERSION").into()), ("command".to_owned(), command.into())])
}

/// The keys with which every document ends.
pub(super) fn end(result: &Result<(), Failure>) -> Object {
    let (code, errors) = match result {
        Ok(()) => (0, Vec::new()),
        Err(failure) => (failure.exit_code(), errors(failure)),
    };
    Object::from_iter([("exit_code".to_owned(), code.into()), ("errors".to_owned(), json!(errors))])
}

/// A document as text, for people to read as well.
fn text(document: &Object) -> String {
    let text = serde_json::to_string_pretty(document).expect("objects of texts and numbers can be written");
    text + "\n"
}

/// Prints the document of a command line that was refused before any command began, if it asks for JSON.
pub(super) fn refuse(arguments: &[OsString], failure: &Failure) -> Result<(), Failure> {
    let asks = |pair: &[OsString]| pair[0] == "--format" && pair[1] == "json";
    if !arguments.windows(2).any(asks) && !arguments.iter().any(|argument| argument == "--format=json") {
        return Ok(());
    }
    let mut document = opened("");
    document.extend(end(&Err(failure.clone())));
    print(&text(&document))
}

fn errors(failure: &Failure) -> Vec<ErrorParts> {
    match failure {
        Failure::Scenario(refused) => refused.parts(),
        Failure::Several(failures) => failures.iter().flat_map(errors).collect(),
        Failure::Usage(message)
        | Failure::Run(message)
        | Failure::Requirement(message)
        | Failure::Busy(message)
        | Failure::Interrupted(message, _) => vec![of_message(message)],
    }
}

/// The parts of a message: its lines that begin with `note:` and `help:` stand apart.
fn of_message(message: &str) -> ErrorParts {
    let (mut rest, mut parts) = (Vec::new(), ErrorParts::default());
    for line in message.trim_end().lines() {
        let line = line.strip_prefix("error: ").unwrap_or(line);
        if let Some(note) = line.trim_start().strip_prefix("note: ") {
            parts.notes.push(note.to_owned());
        } else if let Some(advice) = line.trim_start().strip_prefix("help: ") {
            parts.help.push(advice.to_owned());
        } else {
            rest.push(line);
        }
    }
    parts.message = rest.join("\n").trim().to_owned();
    parts
}
