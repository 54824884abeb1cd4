//! Metrics of meetings with movers and unknown statics: encounters, time to collision.

use super::drive::without_bound_below_zero;
use crate::geometry::{Pose, Twist, Vec2, direction};
use crate::math;
use crate::robot::Robot;
use crate::trace::{MoverState, Trace};
use crate::world::{Mover, Scene};

/// Horizon of `ttc_min_s`, s.
pub const TTC_HORIZON_S: f64 = 10.0;

/// Surface distance at which two discs count as touching, m.
const TOUCH_M: f64 = 1e-6;

/// Longest step of the advancement, s: the bound on the relative acceleration holds over one step.
const STEP_MAX_S: f64 = 1.0;

/// Steps after which two discs count as touching: only a gap of nothing keeps the steps that short.
const STEPS_MAX: u32 = 1000;

/// How many obstacles a robot met, by kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Encounters {
    /// Movers.
    pub movers: u32,
    /// Unknown statics.
    pub unknown: u32,
}

impl Encounters {
    /// `encounters`: both kinds together.
    pub fn total(self) -> u32 {
        self.movers + self.unknown
    }
}

/// `encounters`, `encounters_movers`: movers and unknown statics whose surface came within `encounter_m` of the footprint's edge
/// at the end of some tick or at the beginning, each counted once. Neither direction is better: it measures
/// how much there was to avoid. On failure, up to the end.
pub fn encounters(scene: &Scene, robot: &Robot, trace: &Trace, encounter_m: f64) -> Encounters {
    let reach_m = robot.radius_m + encounter_m;
    let poses = || trace.ticks.iter().map(|tick| tick.pose);
    // The circles around both are the cheap test that most ticks fail.
    let is_near = |p: Vec2, q: Vec2, outer_m: f64| (p - q).norm() - outer_m <= reach_m;
    let movers = scene.movers.iter().enumerate().filter(|&(index, mover)| {
        let met = |(row, pose): (usize, Pose)| {
            let state = trace.movers_at(row)[index];
            state.present
                && is_near(pose.position, state.position, mover.radius_m())
                && mover.gap_m(state.position, &robot.body(pose)) <= encounter_m
        };
        poses().enumerate().any(met)
    });
    let statics = scene.unknown_static.iter().filter(|obstacle| {
        let outer_m = obstacle.shape().circumradius_m();
        poses().any(|pose| {
            is_near(pose.position, obstacle.pose().position, outer_m)
                && obstacle.gap_m(&robot.body(pose)) <= encounter_m
        })
    });
    Encounters { movers: movers.count() as u32, unknown: statics.count() as u32 }
}

/// `clearance_movers_min_m`: the smallest distance at any moment from the footprint's edge to a mover, m; more is better.
/// Up to a millimetre below the truth, as [`clearance_min_m`](super::drive::clearance_min_m); undefined where no mover was there.
pub fn clearance_movers_min_m(trace: &Trace) -> Option<f64> {
    defined(trace.closest.movers_m, trace)
}

/// `clearance_unknown_min_m`: the same to an unknown static; undefined where there was none.
pub fn clearance_unknown_min_m(trace: &Trace) -> Option<f64> {
    defined(trace.closest.unknown_m, trace)
}

fn defined(low_m: f64, trace: &Trace) -> Option<f64> {
    low_m.is_finite().then(|| without_bound_below_zero(low_m, trace))
}

/// `ttc_min_s`: the smallest time to collision with a mover over all ticks, s; more is better.
///
/// At the end of each tick the robot is carried on along the exact arc of its true twist and each mover in a
/// straight line at its velocity; the time to collision is the first at which their outlines touch
/// (J. C. Hayward, Near miss determination through use of a scale of danger, 1972; here in the plane). 0 where they
/// touch already. Undefined if nothing would touch within [`TTC_HORIZON_S`]. On failure, up to the end.
pub fn ttc_min_s(scene: &Scene, robot: &Robot, trace: &Trace) -> Option<f64> {
    // Each finding shortens the horizon of all later looks, which rules most movers out by distance alone.
    let mut least = None;
    let mut horizon_s = TTC_HORIZON_S;
    for (row, tick) in trace.ticks.iter().enumerate() {
        for (state, mover) in trace.movers_at(row).iter().zip(&scene.movers) {
            if state.present
                && let Some(time_s) = time_to_collision_s(robot, tick.pose, tick.twist, mover, state, horizon_s)
            {
                (least, horizon_s) = (Some(time_s), time_s);
            }
        }
    }
    least
}

/// Time until a robot at constant twist and a mover at constant velocity first touch, s; `None` if not before `horizon_s`.
///
/// The discs around both come first: they cannot touch later than the outlines. From there on, where one is a polygon, the
/// outlines, by conservative advancement on their exact distance: to a millimetre.
fn time_to_collision_s(
    robot: &Robot,
    pose: Pose,
    twist: Twist,
    mover: &Mover,
    state: &MoverState,
    horizon_s: f64,
) -> Option<f64> {
    const NEAR_M: f64 = 1e-3;
    let mut t = time_to_touch_s(pose, twist, state, robot.radius_m + mover.radius_m(), horizon_s)?;
    if robot.footprint.is_none() && mover.outline.corners(Vec2::zeros()).is_none() {
        return Some(t);
    }
    let rate = twist.v.abs() + twist.omega.abs() * robot.radius_m + state.velocity.norm();
    for _ in 0..STEPS_MAX {
        let gap_m = mover.gap_m(state.position + state.velocity * t, &robot.body(pose.advance(twist, t)));
        if gap_m <= NEAR_M {
            return Some(t);
        }
        t += gap_m / rate;
        if t >= horizon_s {
            return None;
        }
    }
    Some(t)
}

/// Time until the centres of a robot at constant twist and a mover at constant velocity first come within `reach_m` of each
/// other, s; `None` if not before `horizon_s`.
///
/// Conservative advancement on g(t) = |D(t)|², D from robot to mover. With V = D′ and the robot's
/// acceleration |v ω| the only one, g″ = 2|V|² + 2 D·D″ ≥ −K, K = 2 |D| |v ω|; so up to a time h later
/// g ≥ g₀ + g₀′ h − K h²/2, and nothing touches before that parabola falls to `reach_m`². Steps go to that
/// root. They never pass a touch, however brief, and near one they converge quadratically, like Newton's.
fn time_to_touch_s(robot: Pose, twist: Twist, mover: &MoverState, reach_m: f64, horizon_s: f64) -> Option<f64> {
    let speed_max = twist.v.abs() + mover.velocity.norm();
    let acceleration = (twist.v * twist.omega).abs();
    let mut t = 0.0;
    for _ in 0..STEPS_MAX {
        let pose = robot.advance(twist, t);
        let apart = mover.position + mover.velocity * t - pose.position;
        let distance = apart.norm();
        let gap = distance - reach_m;
        if gap <= TOUCH_M {
            return Some(t);
        }
        let left = horizon_s - t;
        if gap > speed_max * left {
            return None;
        }
        let longest = math::min(left, STEP_MAX_S);
        let fall = 2.0 * acceleration * (distance + speed_max * longest);
        let rate = 2.0 * apart.dot(&(mover.velocity - direction(pose.theta) * twist.v));
        let above = gap * (distance + reach_m);
        let root = (rate * rate + 2.0 * fall * above).sqrt();
        // The positive root of above + rate·h − fall·h²/2, in the form that does not cancel.
        let step = if rate < 0.0 {
            2.0 * above / (root - rate)
        } else if fall > 0.0 {
            (rate + root) / fall
        } else {
            longest
        };
        if step >= left {
            return None;
        }
        t += math::min(step, longest);
    }
    Some(t)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{drive, mover, scene_with};
    use super::*;
    use crate::geometry::convex::Polygon;
    use crate::rng::{EpisodeSeed, Purpose};
    use crate::world::{Outline, Shape, UnknownStatic};

    const STILL: Pose = Pose { position: Vec2::new(0.0, 0.0), theta: 0.0 };

    fn ttc(twist: Twist, position: (f64, f64), velocity: (f64, f64), reach_m: f64) -> Option<f64> {
        let mover = MoverState {
            position: Vec2::new(position.0, position.1),
            velocity: Vec2::new(velocity.0, velocity.1),
            present: true,
        };
        time_to_touch_s(STILL, twist, &mover, reach_m, TTC_HORIZON_S)
    }

    fn near(found: Option<f64>, expected: f64) -> bool {
        found.is_some_and(|time| (time - expected).abs() < 1e-5)
    }

    #[test]
    fn head_on_and_overtaking() {
        let v1 = Twist { v: 1.0, omega: 0.0 };
        // 5 m apart, radii 0.5 together, closing at 1.5 m/s: 4.5 / 1.5 = 3 s.
        assert!(near(ttc(v1, (5.0, 0.0), (-0.5, 0.0), 0.5), 3.0));
        // Following at 0.5 m/s more: 9 s; at 0.4 m/s more 11.25 s, beyond the horizon; away from it never.
        assert!(near(ttc(v1, (5.0, 0.0), (0.5, 0.0), 0.5), 9.0));
        assert_eq!(ttc(v1, (5.0, 0.0), (0.6, 0.0), 0.5), None);
        assert_eq!(ttc(v1, (-5.0, 0.0), (0.5, 0.0), 0.5), None);
        assert_eq!(ttc(Twist::ZERO, (5.0, 0.0), (0.0, 0.0), 0.5), None);
    }

    #[test]
    fn a_crossing_mover_has_the_root_of_the_quadratic() {
        // Robot along x at 1 m/s; mover from (4, −4) along y at 1 m/s. D(t) = (4 − t)(1, −1), |D| = √2 (4 − t) = 0.6
        // at t = 4 − 0.6/√2 = 3.57574 s.
        let v1 = Twist { v: 1.0, omega: 0.0 };
        assert!(near(ttc(v1, (4.0, -4.0), (0.0, 1.0), 0.6), 4.0 - 0.6 / 2f64.sqrt()));
        // A second later at the crossing: D = (4 − t, t − 5), closest at t = 4.5 with √0.5 = 0.707 m: passes 0.6, not 0.8.
        assert_eq!(ttc(v1, (4.0, -5.0), (0.0, 1.0), 0.6), None);
        // (4−t)² + (5−t)² = 0.64: t = 4.5 − √(0.32 − 0.25) = 4.23542 s.
        assert!(near(ttc(v1, (4.0, -5.0), (0.0, 1.0), 0.8), 4.5 - 0.07f64.sqrt()));
    }

    #[test]
    fn an_arc_meets_what_stands_on_its_circle() {
        // v 1, ω 0.5: circle of radius 2 about (0, 2). A post of reach 0.5 at its far side (0, 4), half a turn = 2π s away:
        // touched where the chord 2·2·sin(φ/2) = 0.5, φ = 2 asin(0.125) = 0.250656 rad, that is φ / 0.5 s earlier.
        let arc = Twist { v: 1.0, omega: 0.5 };
        assert!(near(ttc(arc, (0.0, 4.0), (0.0, 0.0), 0.5), math::TAU - 0.250_655_662_336_131_2 / 0.5));
        assert_eq!(ttc(arc, (0.0, 4.6), (0.0, 0.0), 0.5), None);
        // Turning on the spot: only the mover moves. 3 m, 0.5 m/s, reach 0.5: 5 s.
        assert!(near(ttc(Twist { v: 0.0, omega: 1.0 }, (0.0, 3.0), (0.0, -0.5), 0.5), 5.0));
    }

    #[test]
    fn touching_is_now() {
        assert_eq!(ttc(Twist::ZERO, (0.5, 0.0), (0.0, 0.0), 0.5), Some(0.0));
        assert_eq!(ttc(Twist::ZERO, (0.2, 0.0), (1.0, 0.0), 0.5), Some(0.0));
    }

    #[test]
    fn footprints_count_with_their_corners() {
        let half = |x: f64, y: f64| {
            Polygon::new(&[(x, y), (-x, y), (-x, -y), (x, -y)].map(|(x, y)| Vec2::new(x, y))).expect("convex")
        };
        let footprint = half(0.4, 0.2);
        let robot = Robot { radius_m: footprint.circumradius_m(), footprint: Some(footprint), ..Robot::default() };
        let outline = Outline::new(Shape::Polygon(half(0.3, 0.1)), 0.0);
        let cart = |x: f64, y: f64| Mover::with_outline(Vec2::new(x, y), Vec2::zeros(), outline.clone());
        let ttc = |mover: &Mover| {
            let state = MoverState { position: mover.position, velocity: mover.velocity, present: true };
            time_to_collision_s(&robot, STILL, Twist { v: 1.0, omega: 0.0 }, mover, &state, TTC_HORIZON_S)
        };
        // Face to face: 5 − 0.4 − 0.3 = 4.3 m at 1 m/s. Beside each other: 0.35 − 0.2 − 0.1 = 5 cm, where the discs would touch.
        assert!(ttc(&cart(5.0, 0.0)).is_some_and(|time| (4.299..=4.3).contains(&time)));
        assert_eq!(ttc(&cart(5.0, 0.35)), None);
        // A robot that stands, 5 m from the cart's centre: 4.3 m between the surfaces.
        let scene = scene_with(vec![cart(5.0, 0.0)], Vec::new());
        let state = MoverState { position: Vec2::new(5.0, 0.0), velocity: Vec2::zeros(), present: true };
        let trace = Trace { ticks: drive(STILL, &[]), movers: vec![state], mover_count: 1, ..Trace::default() };
        assert_eq!(encounters(&scene, &robot, &trace, 4.29).total(), 0);
        assert_eq!(encounters(&scene, &robot, &trace, 4.31).total(), 1);
    }

    #[test]
    fn advancement_agrees_with_fine_steps() {
        // Fine steps of 1 ms: no touch may come before the time found, and one must come with it.
        let mut draws = EpisodeSeed { seed: 3, episode: 0 }.stream(Purpose::Dynamic, 0);
        let (mut touches, mut misses) = (0, 0);
        for _ in 0..2000 {
            let mut within = |half: f64| draws.range(-half, half);
            let twist = Twist { v: within(1.5), omega: within(1.5) };
            let mover = MoverState {
                position: Vec2::new(within(4.0), within(4.0)),
                velocity: Vec2::new(within(1.0), within(1.0)),
                present: true,
            };
            let gap = |t: f64| (mover.position + mover.velocity * t - STILL.advance(twist, t).position).norm() - 0.6;
            let sampled = (0..=10_000).map(|k| f64::from(k) / 1000.0).find(|&t| gap(t) <= 0.0);
            match (time_to_touch_s(STILL, twist, &mover, 0.6, TTC_HORIZON_S), sampled) {
                (Some(found), Some(sampled)) => {
                    assert!(gap(found) <= 2e-6 && found <= sampled, "{twist:?} {mover:?}: {found}, sampled {sampled}");
                    touches += 1;
                }
                // A touch shorter than a sample.
                (Some(found), None) => assert!(gap(found) <= 2e-6),
                (None, Some(sampled)) => panic!("{twist:?} {mover:?}: touch at {sampled} s was missed"),
                (None, None) => misses += 1,
            }
        }
        assert!(touches > 200 && misses > 200, "{touches} touches, {misses} misses");
    }

    #[test]
    fn the_least_time_over_ticks_and_movers_counts() {
        // 10 ticks at 1 m/s from the origin. A follows 2 m behind at 0.1 m/s and never comes; B stands at (8, 0). At the end
        // the robot is at x = 1 and B's surface (radius 0.3) 7 − 0.25 − 0.3 = 6.45 m away: 6.45 s, the least.
        let movers = [((-2.0, 0.0), (0.1, 0.0)), ((8.0, 0.0), (0.0, 0.0))]
            .map(|(p, v)| mover(Vec2::new(p.0, p.1), Vec2::new(v.0, v.1), 0.3));
        let mut scene = scene_with(movers.to_vec(), Vec::new());
        let ticks = drive(STILL, &[Twist { v: 1.0, omega: 0.0 }; 10]);
        let state = |m: &Mover, row: usize| MoverState {
            position: m.position + m.velocity * (row as f64 * 0.1),
            velocity: m.velocity,
            present: true,
        };
        let states = (0..=10).flat_map(|row| movers.iter().map(move |m| state(m, row)).collect::<Vec<_>>()).collect();
        let trace = Trace { ticks, movers: states, mover_count: 2, ..Trace::default() };
        assert!(near(ttc_min_s(&scene, &Robot::default(), &trace), 6.45));
        // Surfaces: A 2 − 0.55 = 1.45 m off at first; B 6.45 m at best.
        assert_eq!(encounters(&scene, &Robot::default(), &trace, 1.44).total(), 0);
        assert_eq!(encounters(&scene, &Robot::default(), &trace, 1.46).total(), 1);
        assert_eq!(encounters(&scene, &Robot::default(), &trace, 6.46).total(), 2);
        // A pallet turned by 90°: 0.4 m half-side now towards the path's end (1, 0); its edge is at y = 2 − 0.4 = 1.6,
        // 1.35 m from the footprint. Unturned it would be 2 − 0.1 − 0.25 = 1.65 m.
        let shape = Shape::Rectangle { half_m: Vec2::new(0.4, 0.1) };
        scene.unknown_static = vec![UnknownStatic::new(Pose::new(1.0, 2.0, math::FRAC_PI_2), shape)];
        assert_eq!(encounters(&scene, &Robot::default(), &trace, 1.34).total(), 0);
        let met = encounters(&scene, &Robot::default(), &trace, 1.36);
        assert_eq!((met.total(), met.movers, met.unknown), (1, 0, 1));
    }
}
