//! Pictures and pages made from scenes and traces.

pub mod chart;
pub mod drawing;
pub mod figure;
mod page;
pub mod palette;
pub mod picture;

pub use page::{ReportError, Settings, episode, report};
