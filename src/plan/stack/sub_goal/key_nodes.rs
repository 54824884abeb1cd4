//! The key nodes of the path one after the other, as the papers do.
//!
//! The sub-goal moves on when the robot is within the switching radius of it or has passed its normal plane, that is the
//! plane through the node across the direction in which the path arrives there; without the second rule robots circle nodes
//! that they missed. The last node, the goal, never switches.
//!
//! Source: L. Gao et al., 2025, section 2.4 (sub-goals, switching within 0.5 to 1.0 m); the normal plane is simrun's resolution.

use super::SubGoalRule;
use crate::geometry::Vec2;
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::stack::route::Route;
use crate::settings::Entry;
use crate::settings::quantity::Positive;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When the next one's turn comes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Distance at which the sub-goal moves on to the next key node, m; default 0.8 (gao2025: 0.5 to 1.0).
    pub switching_radius_m: Positive,
}

impl Default for Params {
    fn default() -> Self {
        Self { switching_radius_m: Positive::new(0.8) }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "The key nodes of the path one after the other, as the papers do." };

impl SubGoalRule for Params {
    fn advance(&self, route: &mut Route, position: Vec2, _: Option<&PlanningGrid>) {
        let last = route.nodes.len() - 1;
        while route.next < last {
            let node = route.nodes[route.next].position;
            let arriving = node - route.nodes[route.next - 1].position;
            let near = (position - node).norm() <= self.switching_radius_m.get();
            let passed = arriving.norm_squared() == 0.0 || (position - node).dot(&arriving) > 0.0;
            if !(near || passed) {
                break;
            }
            route.next += 1;
        }
        // From a little behind the current piece up to the sub-goal: a path that passes the same place twice must not let
        // the progress jump.
        let from_m = math::max(route.progress_m, route.nodes[route.next.saturating_sub(2)].along_m);
        route.project(position, from_m, route.nodes[route.next].along_m);
        route.previous_node = route.nodes[route.next.saturating_sub(1)].position;
        route.sub_goal = route.nodes[route.next].position;
        route.is_last = route.next == last;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Path;

    fn route() -> Route {
        let mut route = Route::default();
        let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)].map(|(x, y)| Vec2::new(x, y));
        route.set(Path::polyline(&corners));
        route
    }

    #[test]
    fn a_node_is_left_when_it_is_near_or_its_normal_plane_is_passed() {
        let (rule, mut route) = (Params::default(), route());
        rule.advance(&mut route, Vec2::new(3.1, 0.0), None);
        assert_eq!((route.sub_goal, route.progress_m), (Vec2::new(4.0, 0.0), 3.1));
        rule.advance(&mut route, Vec2::new(3.3, 0.0), None); // 0.7 m to the node
        assert_eq!((route.sub_goal, route.previous_node), (Vec2::new(4.0, 4.0), Vec2::new(4.0, 0.0)));
        // 2 m aside of the second node, but beyond the plane y = 4.
        rule.advance(&mut route, Vec2::new(6.0, 4.1), None);
        assert_eq!((route.sub_goal, route.is_last), (Vec2::new(0.0, 4.0), true));
    }

    #[test]
    fn the_goal_never_switches() {
        let (rule, mut route) = (Params::default(), route());
        for position in [Vec2::new(4.0, 0.0), Vec2::new(4.0, 4.0), Vec2::new(-3.0, 4.0), Vec2::new(0.0, 4.0)] {
            rule.advance(&mut route, position, None);
        }
        assert_eq!((route.sub_goal, route.next), (Vec2::new(0.0, 4.0), 3));
    }

    #[test]
    fn named_nodes_are_steered_for_and_not_the_ends_of_the_pieces() {
        let mut route = route();
        let path = route.path.clone().with_key_nodes(&[Vec2::new(0.0, 0.0), Vec2::new(5.0, 2.0), Vec2::new(0.0, 4.0)]);
        route.set(path);
        Params::default().advance(&mut route, Vec2::new(1.0, 0.0), None);
        assert_eq!((route.sub_goal, route.nodes[1].along_m), (Vec2::new(5.0, 2.0), 6.0));
    }
}
