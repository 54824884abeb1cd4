//! What scenario files are made of: checked numbers, and named choices from registries.
//!
//! One kind of thing is one file and one line. A kind's file holds its documentation, its `Params`, its [`Entry`] and its
//! behaviour; the line is its name in a `registry!`, from which come the reader, "did you mean", the JSON Schema,
//! `simrun planners`, `simrun explain` and the conformance tests.

pub mod choice;
pub mod quantity;
mod registry;
mod unit;

pub(crate) use registry::registry;
pub use unit::unit_of;

/// What a registry says of one kind of thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// One line: what it is.
    pub summary: &'static str,
}
