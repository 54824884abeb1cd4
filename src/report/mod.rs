//! Pictures and pages made from scenes and traces.

pub mod chart;
pub mod figure;
mod svg;

pub use svg::{Caption, draw};
