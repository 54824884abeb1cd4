//! A stack as a scenario describes it.

use super::{Movers, PlanningSpec, Replan, Stack, SubGoals};
use crate::math;
use crate::plan::global::GlobalChoice;
use crate::plan::local::LocalChoice;
use crate::plan::path::PathChoice;
use crate::robot::Robot;
use crate::settings::quantity::{NonNegative, Positive};

/// A stack as a scenario describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct StackSpec {
    /// Unique name in results.
    pub name: String,
    /// The global planner; `None` for a local planner alone, whose only sub-goal is the goal.
    pub global: Option<GlobalChoice>,
    /// Path stages in order.
    pub path: Vec<PathChoice>,
    /// The local planner.
    pub local: LocalChoice,
    /// When to plan again; `None` for the rule of `planning.replan`.
    pub replan: Option<Replan>,
    /// Which point of the path to steer for; `None` for the rule of `planning.sub_goals`.
    pub sub_goals: Option<SubGoals>,
    /// What sensed movers are to the global planner; `None` for what `planning.movers` says.
    pub movers: Option<Movers>,
    /// Limits of this stack below those of the robot.
    pub caps: Caps,
}

/// Speed limits of a stack below those of the robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Caps {
    /// Highest forward speed, m/s.
    pub speed_max_mps: Option<Positive>,
    /// Highest reverse speed, m/s; 0 forbids reversing.
    pub reverse_speed_max_mps: Option<NonNegative>,
}

impl Caps {
    /// The robot with the limits lowered to the caps; `None` if no limit is lowered.
    pub(super) fn robot(&self, robot: &Robot) -> Option<Robot> {
        let Self { speed_max_mps, reverse_speed_max_mps } = *self;
        let is_capped = speed_max_mps.is_some() || reverse_speed_max_mps.is_some();
        is_capped.then(|| {
            let mut capped = robot.clone();
            if let Some(speed) = speed_max_mps {
                capped.speed_max_mps = math::min(robot.speed_max_mps, speed.get());
            }
            if let Some(speed) = reverse_speed_max_mps {
                capped.reverse_speed_max_mps = math::min(robot.reverse_speed_max_mps, speed.get());
            }
            capped
        })
    }
}

impl StackSpec {
    /// The name of the global planner, or `none`, as it stands in the name of a stack.
    pub fn global_name(&self) -> &'static str {
        self.global.as_ref().map_or("none", GlobalChoice::name)
    }

    /// The name in results of the path part: the stages joined by `+`; empty without stages.
    pub fn path_name(&self) -> String {
        self.path.iter().map(PathChoice::name).collect::<Vec<_>>().join("+")
    }

    /// `global[+path…]+local`, the name of a stack whose scenario gives none.
    pub fn default_name(&self) -> String {
        let mut parts = vec![self.global_name()];
        parts.extend(self.path.iter().map(PathChoice::name));
        parts.push(self.local.name());
        parts.join("+")
    }

    /// A fresh stack.
    pub fn build(&self, planning: &PlanningSpec) -> Stack {
        let mut stack = Stack::new(
            self.global.as_ref().map(GlobalChoice::build),
            self.path.iter().map(PathChoice::build).collect(),
            self.local.build(),
        )
        .with_planning(planning);
        if let Some(replan) = &self.replan {
            stack = stack.with_replan(replan.clone());
        }
        if let Some(sub_goals) = &self.sub_goals {
            stack.planning.sub_goals = sub_goals.clone();
        }
        if let Some(movers) = &self.movers {
            stack.planning.movers = movers.clone();
        }
        stack.caps = self.caps;
        stack
    }
}
