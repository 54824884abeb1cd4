//! Plan again when the rest of the path has become blocked on the belief map, or the robot has come to a stand.

use super::{Begin, ReplanRule, Watch};
use crate::settings::Entry;
use crate::settings::quantity::NonNegative;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When a stand counts as blocked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Also plan again when the robot has stood within 0.1 m for this long, s: a new path may lead elsewhere, and one that
    /// came into force at full speed may have been missed. 0 never does; default 5.
    pub after_standing_s: NonNegative,
    /// Where the new path begins when the old one has become blocked. Default `robot`.
    pub from: From,
}

/// Where a new path begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum From {
    /// At the robot.
    #[default]
    Robot,
    /// At the next key node, and the old path is kept up to it, where that is free and the node is not the goal; else at the robot.
    KeyNode,
}

impl Default for Params {
    fn default() -> Self {
        Self { after_standing_s: NonNegative::new(5.0), from: From::Robot }
    }
}

/// Registry entry.
pub const ENTRY: Entry =
    Entry { summary: "Plan again when the rest of the path has become blocked, or the robot has stood for a while." };

impl ReplanRule for Params {
    fn wants_path(&self, watch: &mut Watch<'_>) -> Option<Begin> {
        let after_s = self.after_standing_s.get();
        if after_s > 0.0 && watch.has_stood(after_s) {
            return Some(Begin::Robot);
        }
        watch.path_has_become_blocked().then(|| match self.from {
            From::Robot => Begin::Robot,
            From::KeyNode => watch.nearest_key_node(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Path, Pose, Vec2};
    use crate::map::{Cell, OccupancyGrid};
    use crate::observation::Belief;
    use crate::plan::PlanningGrid;
    use crate::plan::contract::Situation;
    use crate::plan::stack::planning::PlanningSpec;
    use crate::plan::stack::replan::Checked;
    use crate::plan::stack::route::Route;
    use crate::plan::stack::standing::Standing;
    use crate::robot::Robot;

    /// What the rule wants of a path with key nodes at x = 1.5, 6.5, 12.5 and 18.5, all at y = 5.5, once a cell is blocked.
    fn wanted(from: From, next: usize, blocked: (i32, i32), inflation_m: f64) -> Option<Begin> {
        let map = OccupancyGrid::empty(20, 11, 1.0);
        let (robot, mut belief) = (Robot::default(), Belief::from(&map));
        let mut route = Route::default();
        let nodes = [1.5, 6.5, 12.5, 18.5].map(|x| Vec2::new(x, 5.5));
        let planning = PlanningSpec { inflation_m: Some(NonNegative::new(inflation_m)), ..PlanningSpec::default() };
        let mut grid = PlanningGrid::new(&map, belief.field(), inflation_m);
        route.set_on(Path::polyline(&nodes), &grid);
        route.next = next;
        let mut checked = Checked { revision: belief.revision(), ..Checked::default() };
        let square = map.square(Cell { col: blocked.0, row: blocked.1 });
        belief.add(square, |other| other == square);
        let situation = Situation::new(&robot, &belief, Pose::new(2.5, 5.5, 0.0), route.path.end());
        let mut watch = Watch {
            situation: &situation,
            route: &route,
            planning: &planning,
            grid: &mut grid,
            checked: &mut checked,
            standing: &mut Standing::default(),
            standing_since_tick: 0,
            planned_tick: 0,
        };
        Params { from, ..Params::default() }.wants_path(&mut watch)
    }

    #[test]
    fn a_blocked_path_is_planned_anew_from_the_robot_or_from_the_next_key_node_if_the_way_to_it_is_free() {
        for inflation_m in [0.0, 0.3] {
            let wanted = |from, next, col| wanted(from, next, (col, 5), inflation_m);
            let on_path = |from_m| Some(Begin::OnPath { from_m });
            assert_eq!(wanted(From::Robot, 1, 9), Some(Begin::Robot));
            assert_eq!(wanted(From::KeyNode, 1, 9), on_path(5.0));
            assert_eq!(wanted(From::KeyNode, 1, 15), on_path(5.0));
            assert_eq!(wanted(From::KeyNode, 2, 15), on_path(11.0));
            // Before the node; on the way to the goal, which is no node to go on from; behind the robot.
            assert_eq!(wanted(From::KeyNode, 1, 4), Some(Begin::Robot));
            assert_eq!(wanted(From::KeyNode, 3, 15), Some(Begin::Robot));
            assert_eq!(wanted(From::KeyNode, 3, 9), None);
        }
        assert_eq!(wanted(From::KeyNode, 1, (9, 8), 0.0), None);
    }
}
