//! Building blocks of scenario files: checked numbers, and named choices from registries.
//!
//! One kind of thing is one file and one line. A kind's file holds its documentation, its `Params`, its [`Entry`] and its
//! behaviour; the line is its name in a `registry!`, from which come the reader, "did you mean", the JSON Schema,
//! `simrun planners`, `simrun explain` and the conformance tests.

pub mod choice;
pub mod quantity;
mod registry;
mod unit;

pub(crate) use registry::registry;
pub use unit::{COORDINATE_M_MAX, OutOfRange, RESOLUTION_M, check_count, check_range, shown, unit_of};

/// Registry entry of one kind of thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// One line that describes it.
    pub summary: &'static str,
}
