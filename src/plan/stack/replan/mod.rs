//! Replanning rules: when the global planner is asked again, on the map as believed by then. One file per rule.

use super::planning::PlanningSpec;
use super::route::Route;
use super::standing::Standing;
use crate::plan::PlanningGrid;
use crate::plan::contract::Situation;
use crate::settings::{Entry, registry};

/// Behaviour of a replanning rule.
pub trait ReplanRule {
    /// Where to plan a new path from at this tick; `None` to keep the path in force.
    fn wants_path(&self, watch: &mut Watch<'_>) -> Option<Begin>;

    /// Distance within which a robot counts as standing, m.
    fn standing_radius_m(&self) -> f64 {
        0.1
    }
}

registry! {
    /// When the global planner is asked again, on the map as believed by then.
    pub enum Replan: "replanning rule", Entry, dyn ReplanRule { never, when_blocked, when_stuck, when_threatened, every }
}

impl Default for Replan {
    fn default() -> Self {
        Self::when_blocked(when_blocked::Params::default())
    }
}

/// Where a new path begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Begin {
    /// At the robot.
    Robot,
    /// At this arc length on the path in force, m, which is kept up to it.
    OnPath {
        /// Arc length from the beginning of the path, m.
        from_m: f64,
    },
}

impl Begin {
    /// The arc length; `None` for the robot.
    pub(super) fn along_m(self) -> Option<f64> {
        match self {
            Self::Robot => None,
            Self::OnPath { from_m } => Some(from_m),
        }
    }
}

/// The questions that a replanning rule may ask.
#[derive(Debug)]
pub struct Watch<'a> {
    /// The situation at this tick.
    pub situation: &'a Situation<'a>,
    /// The path in force and the robot's progress on it.
    pub route: &'a Route,
    pub(super) planning: &'a PlanningSpec,
    pub(super) grid: &'a mut PlanningGrid,
    pub(super) checked: &'a mut Checked,
    pub(super) standing: &'a mut Standing,
    pub(super) standing_since_tick: u32,
    pub(super) planned_tick: u32,
}

/// The map for which the path in force was last tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Checked {
    /// Revision of the belief.
    pub(super) revision: u64,
    /// Revision of the marks of movers that stand.
    pub(super) standing_revision: u64,
    /// The tick, where movers block cells: they are elsewhere at every tick.
    pub(super) movers_tick: u32,
}

impl Checked {
    /// The map on which a test of the path at this tick would be made.
    pub(super) fn now(situation: &Situation<'_>, planning: &PlanningSpec, standing_revision: u64) -> Self {
        let movers_tick = if planning.movers.kind().block() { situation.tick } else { 0 };
        Self { revision: situation.belief.revision(), standing_revision, movers_tick }
    }
}

impl Watch<'_> {
    /// Whether the robot has stood for at least `time_s`.
    pub fn has_stood(&self, time_s: f64) -> bool {
        self.situation.time_since_s(self.standing_since_tick) >= time_s - 1e-9
    }

    /// Whether the last plan was made at least `time_s` ago.
    pub fn planned_before(&self, time_s: f64) -> bool {
        self.situation.time_since_s(self.planned_tick) >= time_s - 1e-9
    }

    /// Whether the rest of the path has become less clear than it was planned since this was last asked.
    pub fn path_has_become_blocked(&mut self) -> bool {
        let now = Checked::now(self.situation, self.planning, self.standing.revision);
        if now == *self.checked {
            return false;
        }
        *self.checked = now;
        let belief = self.standing.belief(self.situation);
        super::rebuild_grid(self.grid, self.planning, &Situation { belief, ..*self.situation });
        !self.route.is_free_up_to(f64::INFINITY, self.grid, self.situation.pose.position)
    }

    /// The first key node that the robot has not passed, where it is not the end of the path and the path up to it is as clear as it
    /// was planned; else the robot. To be asked after [`Self::path_has_become_blocked`], whose map it uses.
    pub fn nearest_key_node(&self) -> Begin {
        let route = self.route;
        let Some([node, _, ..]) = route.nodes.get(route.next..) else { return Begin::Robot };
        let from_m = node.along_m;
        let is_free = route.is_free_up_to(from_m, self.grid, self.situation.pose.position);
        if is_free { Begin::OnPath { from_m } } else { Begin::Robot }
    }
}
