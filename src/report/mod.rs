//! Pictures and pages made from scenes and traces.

pub mod chart;
pub mod drawing;
pub mod palette;
pub mod picture;
