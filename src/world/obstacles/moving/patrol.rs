//! One mover that goes from waypoint to waypoint, again and again.

use super::{
    Given, Mover, MovingKind, OnRobot, OnStatic, Order, SLACK_M, manners, radius_default, yield_distance_default,
};
use crate::geometry::Vec2;
use crate::geometry::outline::Outline;
use crate::map::OccupancyGrid;
use crate::math;
use crate::rng::Purpose;
use crate::robot::OutlineCorners;
use crate::settings::Entry;
use crate::settings::quantity::{Finite, NonNegative, Positive};
use crate::world::motion::Patrol;
use crate::world::obstacles::Drawing;
use crate::world::scene::{Infeasible, SceneError, at, check_inside, point_to_grid};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "one mover that goes from waypoint to waypoint, again and again" };

/// Parameters of a patrol.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Waypoints [x, y] in the world frame, m; it begins at the first. At least two, no two neighbours at one place.
    pub waypoints: Vec<[Finite; 2]>,
    /// Speed, m/s. Default: 0.5.
    #[serde(default = "speed_default")]
    pub speed_mps: Positive,
    /// How much faster or slower it may be, m/s: uniform, drawn once, the speed at least a tenth of `speed_mps`. Default: 0.
    #[serde(default = "spread_default")]
    pub speed_spread_mps: NonNegative,
    /// Whether the last waypoint leads back to the first; else it goes back the way it came. Default: true.
    #[serde(default = "closed_default")]
    pub closed: bool,
    /// Stop at every waypoint, s. Default: 0.
    #[serde(default = "pause_default")]
    pub pause_s: NonNegative,
    /// Radius of the disc, m. Default: 0.3.
    #[serde(default = "radius_default")]
    pub radius_m: Positive,
    /// A convex outline in place of the disc: corners [x, y], m, x along the first leg; it keeps that heading. Default: none.
    #[serde(default)]
    pub footprint: Option<OutlineCorners>,
    /// Where a static obstacle is in its way: `stop` waits there, `turn_back` goes back to the waypoint before, `pass` goes through.
    /// Default: stop.
    #[serde(default = "on_static_default")]
    pub on_static: OnStatic,
    /// Towards the robot. Default: ignore.
    #[serde(default)]
    pub on_robot: OnRobot,
    /// Surface distance within which a yielding mover stops for a robot ahead of it, m. Default: 1.
    #[serde(default = "yield_distance_default")]
    pub yield_distance_m: NonNegative,
}

fn speed_default() -> Positive {
    Positive::new(0.5)
}

fn spread_default() -> NonNegative {
    NonNegative::new(0.0)
}

fn closed_default() -> bool {
    true
}

fn pause_default() -> NonNegative {
    NonNegative::new(0.0)
}

fn on_static_default() -> OnStatic {
    OnStatic::Stop
}

manners!();

impl Params {
    /// The outline, its x axis along the first leg.
    fn outline(&self, grid: &OccupancyGrid) -> Outline {
        let [first, second] = [0, 1].map(|index| point_to_grid(self.waypoints[index], grid));
        self.manners().outline(second - first)
    }
}

impl MovingKind for Params {
    /// Checks that the patrol has a way to go and that the mover fits on it.
    fn check(&self, key: &str, given: &Given<'_>) -> Result<(), SceneError> {
        let (statics, map) = (given.statics, given.statics.map);
        let key_of = |index: usize| format!("{key}.waypoints[{index}]");
        let places: Vec<Vec2> = self.waypoints.iter().map(|&place| point_to_grid(place, &map.grid)).collect();
        let count = places.len();
        if count < 2 {
            let message = format!("a patrol needs at least two waypoints, found {count}");
            return Err(SceneError::new(format!("{key}.waypoints"), message));
        }
        let outline = self.outline(&map.grid);
        if given.meets_robot(&outline, places[0]) {
            return Err(SceneError::new(key_of(0), "the mover overlaps the robot at its start"));
        }
        let legs = if self.closed && count > 2 { count } else { count - 1 };
        for (from, to) in (0..legs).map(|leg| (leg, (leg + 1) % count)) {
            let (a, b) = (places[from], places[to]);
            if a == b {
                return Err(SceneError::new(key_of(to), "the same place as the waypoint before it"));
            }
            if self.on_static == OnStatic::Pass {
                continue;
            }
            check_inside(&key_of(from), a, map)?;
            let fits = statics.gap_m(&outline, a) >= -SLACK_M;
            if !fits || statics.sweep(&outline.with_slack(), a, b - a, 1.0).is_some() {
                let message = if fits {
                    format!("a static obstacle or the map's edge is in the way to waypoint {to}")
                } else {
                    format!("the mover {}", at(a, map, "overlaps a static obstacle or the map's edge"))
                };
                return Err(SceneError::new(key_of(from), format!("{message}; `on_static: pass` goes through")));
            }
        }
        Ok(())
    }

    fn count(&self) -> usize {
        1
    }

    fn refuses(&self, order: Order) -> Option<&'static str> {
        (order == Order::Velocity).then_some("is on patrol and has no velocity of its own")
    }

    /// The mover, at its first waypoint.
    fn draw(&self, drawing: &Drawing<'_>) -> Result<Vec<Mover>, Infeasible> {
        let grid = &drawing.scene.map.grid;
        let (mean_mps, spread_mps) = (self.speed_mps.get(), self.speed_spread_mps.get());
        let speed_mps = if spread_mps > 0.0 {
            let drawn_mps = drawing.stream(Purpose::Dynamic, 0).range(mean_mps - spread_mps, mean_mps + spread_mps);
            math::max(drawn_mps, 0.1 * mean_mps)
        } else {
            mean_mps
        };
        let patrol = Patrol {
            waypoints: self.waypoints.iter().map(|&place| point_to_grid(place, grid)).collect(),
            speed_mps,
            closed: self.closed,
            pause_s: self.pause_s.get(),
        };
        let first = patrol.waypoints[0];
        let velocity = (patrol.waypoints[1] - first).normalize() * patrol.speed_mps;
        let mover = self.manners().mover(first, velocity, self.outline(grid));
        Ok(vec![Mover { motion: patrol.into(), ..mover }])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::geometry::outline::Shape;
    use crate::world::obstacles::unknown_static::UnknownStatic;
    use crate::world::scene::tests::{scene_of, states};

    #[test]
    fn a_patrol_is_where_arithmetic_says() {
        let text =
            "moving: [patrol: {waypoints: [[10, 10], [14, 10], [14, 13]], speed_mps: 0.5, pause_s: 1, closed: true}]";
        let states = states(&scene_of(text, 0), 400);
        // 4 m, stop, 3 m, stop, 5 m, stop: 8 + 1 + 6 + 1 + 10 + 1 = 27 s a round.
        for (tick, state) in states.iter().enumerate() {
            let t = (tick as f64 * 0.1) % 27.0;
            let along = |from: (f64, f64), to: (f64, f64), share: f64| {
                Vec2::new(from.0 + (to.0 - from.0) * share, from.1 + (to.1 - from.1) * share)
            };
            let expected = if t < 9.0 {
                along((10.0, 10.0), (14.0, 10.0), math::min(t / 8.0, 1.0))
            } else if t < 16.0 {
                along((14.0, 10.0), (14.0, 13.0), math::min((t - 9.0) / 6.0, 1.0))
            } else {
                along((14.0, 13.0), (10.0, 10.0), math::min((t - 16.0) / 10.0, 1.0))
            };
            assert!((state[0].position - expected).norm() < 1e-6, "tick {tick}: {:?} {expected:?}", state[0].position);
        }
        let there_and_back =
            "moving: [patrol: {waypoints: [[10, 10], [14, 10], [14, 13]], speed_mps: 0.5, closed: false}]";
        let states = self::states(&scene_of(there_and_back, 0), 281);
        assert!((states[140][0].position - Vec2::new(14.0, 13.0)).norm() < 1e-6, "7 m after 14 s");
        assert!((states[200][0].position - Vec2::new(14.0, 10.0)).norm() < 1e-6);
        assert!((states[280][0].position - Vec2::new(10.0, 10.0)).norm() < 1e-6);
    }

    #[test]
    fn guards_of_different_worlds_differ_in_speed_if_a_spread_is_given() {
        let speed = |spread: &str, episode: u64| {
            let text =
                format!("moving: [patrol: {{waypoints: [[10, 10], [14, 10]], speed_mps: 0.5, {spread}closed: false}}]");
            scene_of(&text, episode).movers[0].velocity.x
        };
        assert!((0..20).all(|episode| speed("", episode) == 0.5));
        let drawn: Vec<f64> = (0..20).map(|episode| speed("speed_spread_mps: 0.2, ", episode)).collect();
        assert!(drawn.iter().all(|speed| (0.3..=0.7).contains(speed)), "{drawn:?}");
        assert!(drawn.iter().any(|&speed| speed < 0.4) && drawn.iter().any(|&speed| speed > 0.6), "{drawn:?}");
        // None stands or goes backwards, however wide the spread.
        assert!((0..20).all(|episode| speed("speed_spread_mps: 9, ", episode) >= 0.05));
    }

    #[test]
    fn a_patrol_waits_at_what_is_in_its_way_unless_it_passes() {
        for (on_static, expected) in [("stop", 11.2), ("pass", 14.0)] {
            let text = format!(
                "moving: [patrol: {{waypoints: [[10, 10], [14, 10]], speed_mps: 1, pause_s: 9, on_static: {on_static}}}]"
            );
            let mut scene = scene_of(&text, 0);
            scene.unknown_static.push(UnknownStatic::new(Pose::new(12.0, 10.0, 0.0), Shape::Disc { radius_m: 0.5 }));
            let states = states(&scene, 60);
            assert!((states[60][0].position.x - expected).abs() < 1e-6, "{:?}", states[60][0].position);
        }
    }
}
