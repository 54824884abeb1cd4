//! Pictures and pages made from scenes and traces.

pub mod chart;
mod svg;

pub use svg::{Caption, draw};
