//! Planning: global planners, path stages, local planners, and the stack that joins them.
//!
//! Nothing here sees the world; planners get an [`Observation`](crate::observation::Observation).

pub mod global;
mod grid;
pub mod local;
pub mod path;
pub mod stack;

pub use grid::{ESCAPE_FACTOR, Passability, PlanningGrid};

/// What the registry says about a planner beside its parameters.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// One sentence: what it does and when to use it.
    pub summary: &'static str,
    /// Where it comes from: authors, title, venue, year.
    pub source: &'static str,
    /// Whether its paths are the shortest ones of the grid's graph at its default parameters.
    pub exact: bool,
    /// Whether its paths leave the grid's edges: consecutive vertices need not be neighbours.
    pub any_angle: bool,
}

impl Entry {
    /// A planner that promises nothing beyond its contract.
    pub const PLAIN: Self = Self { summary: "", source: "", exact: false, any_angle: false };
}
