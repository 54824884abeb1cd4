//! Plan again when a sensed mover will soon be near the path ahead, or as `when_blocked` does.
//!
//! A mover threatens the path if, at its present velocity, it comes within `distance_m` (surface to the robot's surface) of the
//! point of the path where a robot at its highest speed would be at the same moment, within the next `predict_s`. Without
//! `planning.movers: block` the new path is planned on the same map and may be the old one.

use super::{Begin, ReplanRule, Watch, when_blocked};
use crate::settings::Entry;
use crate::settings::quantity::{NonNegative, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What counts as a threat.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Distance between the surfaces of robot and mover below which the path is threatened, m; default 0.3.
    pub distance_m: NonNegative,
    /// How far ahead movers are predicted, s; default 3.
    pub predict_s: Positive,
    /// Least time from one plan to the next for this reason, s; default 1.
    pub period_min_s: Positive,
}

impl Default for Params {
    fn default() -> Self {
        Self { distance_m: NonNegative::new(0.3), predict_s: Positive::new(3.0), period_min_s: Positive::new(1.0) }
    }
}

/// Registry entry.
pub const ENTRY: Entry =
    Entry { summary: "Plan again when a mover threatens the path ahead, or as `when_blocked` does." };

/// Number of moments examined within the predicted time.
const LOOKS: u32 = 30;

impl ReplanRule for Params {
    fn wants_path(&self, watch: &mut Watch<'_>) -> Option<Begin> {
        if watch.planned_before(self.period_min_s.get()) && self.is_threatened(watch) {
            return Some(Begin::Robot);
        }
        when_blocked::Params::default().wants_path(watch)
    }
}

impl Params {
    fn is_threatened(&self, watch: &Watch<'_>) -> bool {
        let (situation, route) = (watch.situation, watch.route);
        (0..=LOOKS).any(|look| {
            let time_s = self.predict_s.get() * f64::from(look) / f64::from(LOOKS);
            let robot = route.path.point_at(route.progress_m + time_s * situation.robot.speed_max_mps);
            situation.obstacles.iter().any(|mover| {
                let gap_m = (mover.position + mover.velocity * time_s - robot).norm();
                gap_m < mover.radius_m() + situation.robot.radius_m + self.distance_m.get()
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Path, Pose, Vec2};
    use crate::map::OccupancyGrid;
    use crate::observation::{Belief, SensedObstacle};
    use crate::plan::PlanningGrid;
    use crate::plan::contract::Situation;
    use crate::plan::stack::planning::PlanningSpec;
    use crate::plan::stack::replan::Checked;
    use crate::plan::stack::route::Route;
    use crate::plan::stack::standing::Standing;
    use crate::robot::Robot;

    #[test]
    fn a_mover_that_will_cross_is_a_threat_and_one_that_leaves_is_none() {
        let (robot, belief) = (Robot::default(), Belief::from(&OccupancyGrid::empty(20, 20, 1.0)));
        let mut route = Route::default();
        route.set(Path::polyline(&[Vec2::new(1.0, 5.0), Vec2::new(18.0, 5.0)]));
        let threatened = |position: (f64, f64), velocity: (f64, f64)| {
            let (position, velocity) = (Vec2::new(position.0, position.1), Vec2::new(velocity.0, velocity.1));
            let movers = [SensedObstacle::disc(0, position, velocity, 0.3)];
            let start = Pose::new(1.0, 5.0, 0.0);
            let situation =
                Situation { tick: 50, obstacles: &movers, ..Situation::new(&robot, &belief, start, route.path.end()) };
            let mut watch = Watch {
                situation: &situation,
                route: &route,
                planning: &PlanningSpec::default(),
                grid: &mut PlanningGrid::default(),
                checked: &mut Checked::default(),
                standing: &mut Standing::default(),
                standing_since_tick: 50,
                planned_tick: 0,
            };
            Params::default().wants_path(&mut watch).is_some()
        };
        // The robot is at x = 3 after 2 s; so is the first mover, at y = 5. The second goes the other way.
        assert!(threatened((3.0, 7.0), (0.0, -1.0)));
        assert!(!threatened((3.0, 7.0), (0.0, 1.0)));
        // 0.86 m beside the path: 0.25 + 0.3 + 0.3 = 0.85 m would be a threat.
        assert!(!threatened((3.0, 5.86), (0.0, 0.0)) && threatened((3.0, 5.84), (0.0, 0.0)));
    }
}
