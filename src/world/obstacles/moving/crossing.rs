//! Movers that cross the reference route at about the time at which the robot comes by, each from its own random stream.
//!
//! A point of the route is drawn, and a heading; the mover is there when a robot that drives the route at
//! `robot_speed_mps` would be, give or take `jitter_s`. Where it begins follows by driving backwards from there, with bounces off
//! statics. A mover that is met by accident says little of avoidance; this one is met.

use super::{Given, Mover, MovingKind, OnRobot, OnStatic, manners, radius_default, yield_distance_default};
use crate::geometry::{Vec2, direction};
use crate::math;
use crate::rng::{Purpose, Stream};
use crate::robot::OutlineCorners;
use crate::settings::Entry;
use crate::settings::quantity::{CountOrZero, Fraction, NonNegative, Positive};
use crate::world::motion::free_run;
use crate::world::obstacles::Drawing;
use crate::world::scene::{Infeasible, SceneError, TRIES, check_range};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "movers that cross the reference route when the robot may be there" };

/// Parameters of movers that cross the route.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// How many. Default: 1.
    pub count: CountOrZero,
    /// Radius of the disc, m. Default: 0.3.
    pub radius_m: Positive,
    /// A convex outline in place of the disc: corners [x, y], m, x along its way at first; it keeps that heading. Default: none.
    pub footprint: Option<OutlineCorners>,
    /// Range [lowest, highest] from which the speed is drawn, m/s. Default: [0.5, 1].
    pub speed_mps: [NonNegative; 2],
    /// Part of the route's length from which the crossing is drawn: 0 is the start, 1 the goal. Default: [0.3, 0.8].
    pub share: [Fraction; 2],
    /// Speed at which the robot is taken to drive the route, m/s. Default: 0.5.
    pub robot_speed_mps: Positive,
    /// The mover is at most this much too early or too late, uniformly, s. Default: 2.
    pub jitter_s: NonNegative,
    /// It goes straight for this long before and after the crossing, s. Default: 3.
    pub straight_s: NonNegative,
    /// At a wall, an unknown static or the map's edge. Default: reflect.
    pub on_static: OnStatic,
    /// Towards the robot. Default: ignore.
    pub on_robot: OnRobot,
    /// Surface distance within which a yielding mover stops for a robot ahead of it, m. Default: 1.
    pub yield_distance_m: NonNegative,
    /// Least surface distance to the robot at the start, m. Default: 3.
    pub keep_from_start_m: NonNegative,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            count: CountOrZero::new(1),
            radius_m: radius_default(),
            footprint: None,
            speed_mps: [NonNegative::new(0.5), NonNegative::new(1.0)],
            share: [Fraction::new(0.3), Fraction::new(0.8)],
            robot_speed_mps: Positive::new(0.5),
            jitter_s: NonNegative::new(2.0),
            straight_s: NonNegative::new(3.0),
            on_static: OnStatic::default(),
            on_robot: OnRobot::default(),
            yield_distance_m: yield_distance_default(),
            keep_from_start_m: NonNegative::new(3.0),
        }
    }
}

manners!();

impl MovingKind for Params {
    fn check(&self, key: &str, _: &Given<'_>) -> Result<(), SceneError> {
        check_range(&format!("{key}.speed_mps"), self.speed_mps.map(NonNegative::get))?;
        check_range(&format!("{key}.share"), self.share.map(Fraction::get))
    }

    fn count(&self) -> usize {
        self.count.get() as usize
    }

    fn needs_route(&self) -> bool {
        true
    }

    fn draw(&self, drawing: &Drawing<'_>) -> Result<Vec<Mover>, Infeasible> {
        let one = |number| {
            self.draw_one(drawing, drawing.stream(Purpose::Dynamic, number))
                .ok_or_else(|| drawing.no_place("obstacles.moving", number))
        };
        (0..self.count.get()).map(one).collect()
    }
}

impl Params {
    /// One mover; `None` after too many draws.
    fn draw_one(&self, drawing: &Drawing<'_>, mut stream: Stream) -> Option<Mover> {
        let scene = drawing.scene;
        let (statics, route) = (scene.statics(), scene.route());
        let [slowest, fastest] = self.speed_mps.map(NonNegative::get);
        let [low, high] = self.share.map(Fraction::get);
        let keep = self.keep_from_start_m.get() + drawing.robot.radius_m + self.manners().circumradius_m();
        let (jitter_s, straight_s) = (self.jitter_s.get(), self.straight_s.get());
        (0..TRIES).find_map(|_| {
            let velocity = stream.range(slowest, fastest) * direction(stream.range(-math::PI, math::PI));
            let along_m = route.length() * stream.range(low, high);
            let time_s = math::max(0.0, along_m / self.robot_speed_mps.get() + stream.range(-jitter_s, jitter_s));
            let place = route.point_at(along_m);
            let outline = self.manners().outline(velocity);
            let free = |way: Vec2, for_s: f64| statics.sweep(&outline, place, way, for_s).is_none();
            if statics.gap_m(&outline, place) < 0.0 || !free(velocity, straight_s) {
                return None;
            }
            if !free(-velocity, math::min(straight_s, time_s)) {
                return None;
            }
            // What bounces like light comes back the way it went.
            let back = Mover { on_static: self.on_static, ..Mover::with_outline(place, -velocity, outline.clone()) };
            let (position, reversed) = free_run(&back, &statics, time_s)?;
            let clear = (position - scene.start.position).norm() >= keep;
            clear.then(|| self.manners().mover(position, -reversed, outline))
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::Twist;
    use crate::robot::Robot;
    use crate::world::scene::Scene;
    use crate::world::scene::tests::{random_map, seed, spec};
    use crate::world::{Conditions, World};

    #[test]
    fn a_crossing_mover_is_on_the_route_when_the_robot_may_be() {
        let text = "moving: [crossing: {robot_speed_mps: 0.5, jitter_s: 2, straight_s: 0}]";
        for episode in 0..30 {
            let map = random_map(episode);
            let spec = spec("random", "random", text);
            let Ok(scene) = Scene::generate(&spec, &map, &Robot::default(), seed(episode)) else { continue };
            let route = scene.reference_route.as_ref().expect("wanted");
            let length = route.length();
            let (first, last) = (0.3 * length / 0.5 - 2.0, 0.8 * length / 0.5 + 2.0);
            let mover = &scene.movers[0];
            assert!((mover.position - scene.start.position).norm() >= 3.0 + 0.3 + 0.25 - 1e-9);
            let robot = Robot::default();
            let mut world = World::new(&scene, &robot, &Conditions::default());
            let meets = (0..(last / 0.1).ceil() as u32 + 1).any(|tick| {
                let at = world.movers()[0].position;
                world.step(Twist::ZERO);
                // Within a tick's way of the route, at a time at which it may be met.
                f64::from(tick) * 0.1 >= first - 0.1 && route.project(at).1 <= 0.1
            });
            assert!(meets, "episode {episode}");
        }
    }
}
