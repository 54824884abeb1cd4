//! A point that moves along the path ahead of the robot.
//!
//! A local planner that is given far key nodes cuts across what the path avoids and overshoots the
//! turns; this hands it the path itself. Where the point is out of the robot's sight on the planning
//! grid it is drawn back along the path until it is in sight: a sub-goal behind a corner would pull
//! the robot into the corner. In sight means that the robot can go straight there
//! ([`PlanningGrid::is_clear`]).

use super::SubGoalRule;
use crate::geometry::Vec2;
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::stack::route::Route;
use crate::settings::Entry;
use crate::settings::quantity::Positive;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How far ahead.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Arc length from the robot's place on the path to the sub-goal, m; about top speed × horizon
    /// lets a dynamic window drive at full speed. Default 3.
    pub distance_m: Positive,
    /// The sub-goal is not drawn back nearer than this, m; default 0.3: round a corner it has to be near.
    pub distance_min_m: Positive,
}

impl Default for Params {
    fn default() -> Self {
        Self { distance_m: Positive::new(3.0), distance_min_m: Positive::new(0.3) }
    }
}

/// Registry entry.
pub const ENTRY: Entry =
    Entry { summary: "The point of the path a given distance ahead of the robot, if it is in sight." };

/// Least step in which the sub-goal is drawn back on an inflated grid, m.
const STEP_MIN_M: f64 = 0.1;

impl SubGoalRule for Params {
    fn advance(&self, route: &mut Route, position: Vec2, grid: Option<&PlanningGrid>) {
        let (distance_m, distance_min_m) = (self.distance_m.get(), self.distance_min_m.get());
        // Only as far as the sub-goal: a path that passes the same place twice must not let the progress jump.
        route.project(position, route.progress_m, route.progress_m + distance_m);
        while route.next + 1 < route.nodes.len() && route.nodes[route.next].along_m < route.progress_m {
            route.next += 1;
        }
        let mut ahead_m = distance_m;
        let point = |ahead_m: f64| route.path.point_at(route.progress_m + ahead_m);
        if let Some(grid) = grid {
            // Without inflation as fine as the cells, else not finer than a decimetre either.
            let least_m = if grid.inflation_m() > 0.0 { STEP_MIN_M } else { 0.0 };
            let step_m = math::max(0.5 * grid.resolution_m(), least_m);
            while ahead_m > distance_min_m && !grid.is_clear(position, point(ahead_m)) {
                ahead_m = math::max(ahead_m - step_m, distance_min_m);
            }
        }
        let (sub_goal, foot) = (point(ahead_m), point(0.0));
        route.previous_node = foot;
        route.is_last = route.progress_m + ahead_m >= route.length_m();
        route.sub_goal = if route.is_last { route.path.end() } else { sub_goal };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Path;
    use crate::plan::grid::tests::drawn;

    #[test]
    fn the_sub_goal_runs_ahead_and_ends_at_the_goal() {
        let v = Vec2::new;
        let mut route = Route::default();
        route.set(Path::polyline(&[v(0.0, 0.0), v(4.0, 0.0), v(4.0, 4.0)]));
        let rule = Params::default();
        rule.advance(&mut route, v(2.0, 0.5), None);
        // 2 m along, 3 m ahead: 1 m up the second leg.
        assert_eq!((route.progress_m, route.sub_goal, route.previous_node), (2.0, v(4.0, 1.0), v(2.0, 0.0)));
        assert!(!route.is_last && route.next == 1);
        rule.advance(&mut route, v(4.0, 2.0), None);
        assert_eq!((route.progress_m, route.sub_goal, route.is_last, route.next), (5.0, v(4.0, 4.0), true, 2)); // never beyond the sub-goal before
        // The robot has gone back; the progress has not.
        rule.advance(&mut route, v(4.0, 0.0), None);
        assert_eq!(route.progress_m, 5.0);
    }

    #[test]
    fn it_is_drawn_back_into_sight_but_not_below_the_least_distance() {
        let (_, grid) = drawn(&[
            ".....", //
            ".....", //
            "...#.", //
            "...#.", //
        ]);
        let v = Vec2::new;
        let mut route = Route::default();
        route.set(Path::polyline(&[v(2.5, 0.5), v(2.5, 3.5), v(4.5, 3.5), v(4.5, 0.5)]));
        let rule = Params { distance_m: Positive::new(6.0), distance_min_m: Positive::new(1.0) };
        rule.advance(&mut route, v(2.5, 0.5), Some(&grid));
        assert!(grid.line_of_sight(v(2.5, 0.5), route.sub_goal), "{:?}", route.sub_goal);
        let far = Params { distance_m: Positive::new(6.0), distance_min_m: Positive::new(5.5) };
        far.advance(&mut route, v(2.5, 0.5), Some(&grid));
        assert_eq!(route.sub_goal, route.path.point_at(5.5));
    }
}
