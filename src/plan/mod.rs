//! Planning: global planners, path stages, local planners, and the stack that joins them.
//!
//! Nothing here sees the world; planners get a [`Situation`](contract::Situation). Their interface is [`contract`].

pub mod clearance;
pub mod contract;
pub mod global;
mod grid;
pub mod local;
pub mod path;
pub mod snapshot;
pub mod stack;

pub use contract::Entry;
pub use grid::{ESCAPE_FACTOR, Passability, PlanningGrid};
