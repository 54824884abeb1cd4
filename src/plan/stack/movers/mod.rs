//! How the global planner treats sensed movers. One file per choice.

use crate::plan::PlanningGrid;
use crate::plan::contract::Situation;
use crate::settings::{Entry, registry};

/// Behaviour of a treatment of movers.
pub trait MoversOnGrid {
    /// Marks the cells that sensed movers block on the planning grid, for a robot whose centre keeps `inflation_m` from obstacles.
    fn mark(&self, grid: &mut PlanningGrid, situation: &Situation<'_>, inflation_m: f64);

    /// Whether movers can block cells.
    fn block(&self) -> bool;
}

registry! {
    /// What sensed movers are to the global planner.
    pub enum Movers: "treatment of movers", Entry, dyn MoversOnGrid { ignore, block }
}

impl Default for Movers {
    fn default() -> Self {
        Self::ignore(ignore::Params {})
    }
}
