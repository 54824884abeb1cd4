//! Pictures and pages made from scenes and traces.

mod svg;

pub use svg::{Caption, draw};
