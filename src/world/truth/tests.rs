use super::super::DT_S;
use super::*;
use crate::geometry::convex::Polygon;
use crate::geometry::outline::{Outline, Shape};
use crate::geometry::{direction, point_segment_distance};
use crate::map::{Cell, DistanceField, OccupancyGrid};
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::world::obstacles::moving::{OnRobot, OnStatic};
use crate::world::statics::StaticMap;
use rapier2d::parry::query::details::distance_composite_shape_shape;
use rapier2d::prelude::{Ball, QueryFilter, Vector};
use std::sync::Arc;

/// The smallest of some distances.
fn smallest(distances_m: &[f64]) -> f64 {
    distances_m.iter().fold(f64::INFINITY, |best, &distance| math::min(best, distance))
}

const SAMPLES: u32 = 200;

/// A robot whose drive reaches any command within one tick.
fn nimble(radius_m: f64) -> Robot {
    Robot {
        radius_m,
        reverse_speed_max_mps: 5.0,
        speed_max_mps: 5.0,
        acceleration_max_mps2: 1e3,
        deceleration_max_mps2: 1e3,
        yaw_rate_max_radps: 20.0,
        yaw_acceleration_max_radps2: 1e4,
        ..Robot::default()
    }
}

fn empty_scene(cols: i32, rows: i32, start: Pose) -> Scene {
    let map = Arc::new(StaticMap::new(OccupancyGrid::empty(cols, rows, 1.0)));
    Scene::new(&map, start, start.position)
}

fn straight_mover(position: Vec2, velocity: Vec2, radius_m: f64, on_static: OnStatic) -> Mover {
    Mover { on_static, ..Mover::new(position, velocity, radius_m) }
}

/// A small world: random cells, two rectangles and a disc nobody knows, three movers that go straight through.
fn random_scene(stream: &mut Stream) -> Option<Scene> {
    let mut grid = OccupancyGrid::empty(12, 9, stream.range(0.3, 1.2));
    for index in 0..grid.occupied().len() {
        if stream.uniform() < 0.12 {
            grid.set_occupied(grid.cell(index));
        }
    }
    let extent = grid.extent_m();
    let somewhere = |stream: &mut Stream| Vec2::new(stream.range(0.0, extent.x), stream.range(0.0, extent.y));
    let start = Pose { position: somewhere(stream), theta: stream.range(-3.0, 3.0) };
    let mut scene = Scene::new(&Arc::new(StaticMap::new(grid)), start, start.position);
    for k in 0..3 {
        let p = somewhere(stream);
        let shape = if k == 0 {
            Shape::Disc { radius_m: stream.range(0.1, 0.6) }
        } else {
            Shape::Rectangle { half_m: Vec2::new(stream.range(0.02, 0.6), stream.range(0.02, 0.6)) }
        };
        scene.unknown_static.push(UnknownStatic::new(Pose::new(p.x, p.y, stream.range(-4.0, 4.0)), shape));
        let velocity = stream.range(0.0, 3.0) * direction(stream.range(-4.0, 4.0));
        scene.movers.push(straight_mover(somewhere(stream), velocity, stream.range(0.1, 0.5), OnStatic::Pass));
    }
    Some(scene)
}

/// Position of the robot `t` after `pose`, by the textbook formula of the circle (another one than the product's).
fn on_arc(pose: Pose, twist: Twist, t: f64) -> Vec2 {
    let Twist { v, omega } = twist;
    if omega.abs() < 1e-6 {
        return pose.position + v * t * direction(pose.theta);
    }
    let end = pose.theta + omega * t;
    pose.position
        + v / omega * Vec2::new(math::sin(end) - math::sin(pose.theta), math::cos(pose.theta) - math::cos(end))
}

/// Distance to each kind of obstacle from plain geometry: every square, every side of every rectangle.
struct Oracle<'a> {
    scene: &'a Scene,
    radius_m: f64,
}

impl Oracle<'_> {
    fn gaps_m(&self, robot: Vec2, time_s: f64) -> [f64; 4] {
        let grid = &self.scene.map.grid;
        let (extent, half) = (grid.extent_m(), 0.5 * grid.resolution_m());
        let cells = (0..grid.occupied().len()).filter(|&index| grid.occupied()[index]).map(|index| {
            let d = robot - grid.centre(grid.cell(index));
            math::hypot(math::max(d.x.abs() - half, 0.0), math::max(d.y.abs() - half, 0.0))
        });
        let unknown = self.scene.unknown_static.iter().map(|obstacle| match obstacle.shape() {
            Shape::Disc { radius_m } => (robot - obstacle.pose().position).norm() - radius_m,
            Shape::Polygon(_) => unreachable!("the scenes of this oracle have none"),
            Shape::Rectangle { half_m } => {
                let (along, across) =
                    (direction(obstacle.pose().theta), direction(obstacle.pose().theta + 0.5 * math::PI));
                let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
                    .map(|(a, b)| obstacle.pose().position + a * half_m.x * along + b * half_m.y * across);
                let d = robot - obstacle.pose().position;
                if d.dot(&along).abs() < half_m.x && d.dot(&across).abs() < half_m.y {
                    -self.radius_m
                } else {
                    smallest(&[0, 1, 2, 3].map(|k| point_segment_distance(robot, corners[k], corners[(k + 1) % 4])))
                }
            }
        });
        let movers = self
            .scene
            .movers
            .iter()
            .map(|mover| (mover.position + time_s * mover.velocity - robot).norm() - mover.radius_m());
        let least = |distances: &mut dyn Iterator<Item = f64>| distances.fold(f64::INFINITY, math::min) - self.radius_m;
        [
            least(&mut cells.into_iter()),
            least(&mut unknown.into_iter()),
            least(&mut movers.into_iter()),
            least(&mut [robot.x, robot.y, extent.x - robot.x, extent.y - robot.y].into_iter()),
        ]
    }
}

/// Corners of a body whose shape and place is given, by plain trigonometry.
fn corners_at(corners: &[Vec2], position: Vec2, theta: f64) -> Vec<Vec2> {
    let across = direction(theta + 0.5 * math::PI);
    corners.iter().map(|c| position + c.x * direction(theta) + c.y * across).collect()
}

/// Distance between two outlines from the distances of their sides, 0 where they cross or one holds the other.
fn plain_distance(a: &[Vec2], b: &[Vec2]) -> f64 {
    let sides = |corners: &[Vec2]| -> Vec<(Vec2, Vec2)> {
        (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()])).collect()
    };
    let side_of = |p: Vec2, (q, r): (Vec2, Vec2)| (r - q).x * (p - q).y - (r - q).y * (p - q).x;
    let holds = |corners: &[Vec2], p: Vec2| sides(corners).iter().all(|&side| side_of(p, side) > 0.0);
    if holds(a, b[0]) || holds(b, a[0]) {
        return 0.0;
    }
    let mut least = f64::INFINITY;
    for s in sides(a) {
        for t in sides(b) {
            if side_of(s.0, t) * side_of(s.1, t) < 0.0 && side_of(t.0, s) * side_of(t.1, s) < 0.0 {
                return 0.0;
            }
            let ends = [
                point_segment_distance(s.0, t.0, t.1),
                point_segment_distance(s.1, t.0, t.1),
                point_segment_distance(t.0, s.0, s.1),
                point_segment_distance(t.1, s.0, s.1),
            ];
            least = math::min(least, smallest(&ends));
        }
    }
    least
}

/// Distance from a polygon to everything in the scene; 0 where it touches. Discs are polygons of 240 corners.
fn plain_gap_m(scene: &Scene, corners: &[Vec2], time_s: f64) -> f64 {
    let grid = &scene.map.grid;
    let extent = grid.extent_m();
    let edge = corners.iter().map(|p| smallest(&[p.x, p.y, extent.x - p.x, extent.y - p.y]));
    let mut least = math::max(edge.fold(f64::INFINITY, math::min), 0.0);
    for index in (0..grid.occupied().len()).filter(|&index| grid.occupied()[index]) {
        let square = grid.square(grid.cell(index));
        let (min, max) = (square.min, square.max);
        let square = [min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)];
        least = math::min(least, plain_distance(corners, &square));
    }
    let mut against = |shape: &Shape, position: Vec2, theta: f64| {
        let shape: Vec<Vec2> = match shape {
            Shape::Disc { radius_m } => {
                (0..240).map(|k| *radius_m * direction(math::TAU * f64::from(k) / 240.0)).collect()
            }
            Shape::Rectangle { half_m } => [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
                .map(|(a, b)| Vec2::new(a * half_m.x, b * half_m.y))
                .to_vec(),
            Shape::Polygon(polygon) => polygon.corners().to_vec(),
        };
        least = math::min(least, plain_distance(corners, &corners_at(&shape, position, theta)));
    };
    for obstacle in &scene.unknown_static {
        against(obstacle.shape(), obstacle.pose().position, obstacle.pose().theta);
    }
    for mover in &scene.movers {
        let axis = mover.outline.axis();
        let theta = math::atan2(axis.y, axis.x);
        against(mover.outline.shape(), mover.position + time_s * mover.velocity, theta);
    }
    least
}

fn wedge(stream: &mut Stream, size_m: f64) -> Polygon {
    let mut length = |sign: f64| sign * size_m * stream.range(0.3, 1.0);
    let (ahead, left, behind, right) = (length(1.0), length(1.0), length(-1.0), length(-1.0));
    let corners = [(ahead, 0.0), (0.0, left), (behind, 0.5 * left), (behind, 0.5 * right), (0.0, right)];
    Polygon::new(&corners.map(|(x, y)| Vec2::new(x, y))).expect("convex")
}

#[test]
fn the_verdict_on_polygons_equals_dense_sampling_of_plain_geometry() {
    let (mut ticks, mut contacts) = (0, [0; 4]);
    for episode in 0..540 {
        let mut stream = EpisodeSeed { seed: 17, episode }.stream(Purpose::Planner, 0);
        let Some(mut scene) = random_scene(&mut stream) else { continue };
        if episode % 3 != 0 {
            let (cols, rows, side_m) = (scene.map.grid.cols(), scene.map.grid.rows(), scene.map.grid.resolution_m());
            scene.map = Arc::new(StaticMap::new(OccupancyGrid::empty(cols, rows, side_m)));
        }
        let pose = scene.unknown_static[1].pose();
        scene.unknown_static[1] = UnknownStatic::new(pose, Shape::Polygon(wedge(&mut stream, 0.5)));
        let outline = Outline::new(Shape::Polygon(wedge(&mut stream, 0.4)), stream.range(-3.0, 3.0));
        scene.movers[1].outline = outline;
        let footprint = wedge(&mut stream, 0.35);
        // What touches with this one is at least a millimetre deep.
        let shrunk = footprint.scaled(1.0 - 1.001e-3 / footprint.inradius_m());
        let robot = Robot { radius_m: footprint.circumradius_m(), footprint: Some(footprint), ..nimble(0.1) };
        let corners = |robot: &Polygon, pose: Pose| corners_at(robot.corners(), pose.position, pose.theta);
        let polygon = robot.footprint.as_ref().expect("given");
        if plain_gap_m(&scene, &corners(polygon, scene.start), 0.0) < 0.01 {
            continue;
        }
        let mut world = World::new(&scene, &robot, &Conditions::default());
        for tick in 0..6 {
            let v = if stream.uniform() < 0.4 { 0.0 } else { stream.range(-3.0, 3.0) };
            let command = Twist { v, omega: stream.range(-8.0, 8.0) };
            let (before, began_s) = (world.pose(), f64::from(tick) * DT_S);
            let step = world.step(command);
            ticks += 1;
            let end_s = step.contact.map_or(DT_S, |contact| contact.time_s);
            let at = |t: f64| Pose { position: on_arc(before, command, t), theta: before.theta + command.omega * t };
            for k in 0..=20 {
                let t = end_s * f64::from(k) / 20.0;
                assert!(
                    plain_gap_m(&scene, &corners(&shrunk, at(t)), began_s + t) > 0.0,
                    "a contact of a millimetre was missed in episode {episode}"
                );
                let gap = plain_gap_m(&scene, &corners(polygon, at(t)), began_s + t);
                // A disc of 240 corners reaches 0.05 mm less far.
                assert!(step.clearance_low_m <= gap + 6e-5, "{step:?} claims more than {gap}");
            }
            let gap = plain_gap_m(&scene, &corners(polygon, at(end_s)), began_s + end_s);
            if let Some(contact) = step.contact {
                contacts[KINDS.iter().position(|&kind| kind == contact.with).unwrap()] += 1;
                assert!(gap < 6e-5 && step.clearance_m < 0.0 && step.clearance_m > -1e-6, "{gap} {step:?}");
                break;
            }
            assert!((gap - math::max(step.clearance_m, 0.0)).abs() < 6e-5, "{gap} {step:?}");
        }
    }
    assert!(ticks > 1000 && contacts.iter().all(|&count| count > 2), "{ticks} ticks, {contacts:?}");
}

#[test]
fn a_corner_that_turns_into_a_wall_touches_it_at_its_closed_form() {
    // Half sides 0.4 and 0.2, the wall 0.43 m to the left: the front corner, at the angle atan(1/2) and 0.4472 m out, reaches
    // it where sin(atan(1/2) + φ) = 0.43 / 0.4472.
    let half = Vec2::new(0.4, 0.2);
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(a, b)| Vec2::new(a * half.x, b * half.y));
    let footprint = Polygon::new(&corners).unwrap();
    let robot = Robot { radius_m: half.norm(), footprint: Some(footprint), ..nimble(0.1) };
    let scene = empty_scene(4, 3, Pose::new(2.0, 3.0 - 0.43, 0.0));
    let mut world = World::new(&scene, &robot, &Conditions::default());
    assert!((world.clearance_m() - 0.23).abs() < 1e-12);
    let omega = 0.5;
    let contact = (0..50).find_map(|tick| Some((tick, world.step(Twist { v: 0.0, omega }).contact?)));
    let (tick, contact) = contact.expect("the corner meets the wall");
    let turned = math::FRAC_PI_2 - math::acos(0.43 / half.norm()) - math::atan2(half.y, half.x);
    assert!((f64::from(tick) * DT_S + contact.time_s - turned / omega).abs() < 1e-6);
    assert_eq!((contact.with, contact.at_rest), (ObstacleKind::Boundary, false));
}

const KINDS: [ObstacleKind; 4] =
    [ObstacleKind::KnownStatic, ObstacleKind::UnknownStatic, ObstacleKind::Dynamic, ObstacleKind::Boundary];

#[test]
fn the_verdict_equals_dense_sampling_of_plain_geometry() {
    let (mut ticks, mut contacts, mut grazes) = (0, [0; 4], 0);
    for episode in 0..3000 {
        let mut stream = EpisodeSeed { seed: 11, episode }.stream(Purpose::Planner, 0);
        let robot = nimble(stream.range(0.05, 0.4));
        let Some(scene) = random_scene(&mut stream) else { continue };
        let oracle = Oracle { scene: &scene, radius_m: robot.radius_m };
        if smallest(&oracle.gaps_m(scene.start.position, 0.0)) < 0.01 {
            continue;
        }
        let mut world = World::new(&scene, &robot, &Conditions::default());
        let (mut episode_low, mut episode_truth) = (world.clearance_m(), world.clearance_m());
        let mut nearest = oracle.gaps_m(scene.start.position, 0.0);
        for tick in 0..8 {
            // One in four stands or only turns.
            let v = if stream.uniform() < 0.25 { 0.0 } else { stream.range(-5.0, 5.0) };
            let command = Twist { v, omega: stream.range(-6.0, 6.0) };
            let (before, began_s) = (world.pose(), f64::from(tick) * DT_S);
            let step = world.step(command);
            ticks += 1;
            assert_eq!(world.twist(), command, "the drive reaches every command");

            let end_s = step.contact.map_or(DT_S, |contact| contact.time_s);
            let mut truth = f64::INFINITY;
            let mut deepest = 0.0;
            for k in 0..=SAMPLES {
                let t = DT_S * f64::from(k) / f64::from(SAMPLES);
                let gaps = oracle.gaps_m(on_arc(before, command, t), began_s + t);
                let gap = smallest(&gaps);
                if t <= end_s {
                    nearest.iter_mut().zip(&gaps).for_each(|(nearest, &gap)| *nearest = math::min(*nearest, gap));
                    assert!(gap > -1e-3, "a contact {} deep was missed in episode {episode}", -gap);
                    truth = math::min(truth, gap);
                    deepest = math::min(deepest, gap);
                }
            }
            grazes += i32::from(step.contact.is_none() && deepest < 0.0);
            let gaps = oracle.gaps_m(on_arc(before, command, end_s), began_s + end_s);
            nearest.iter_mut().zip(&gaps).for_each(|(nearest, &gap)| *nearest = math::min(*nearest, gap));
            assert!((smallest(&gaps) - step.clearance_m).abs() < 1e-9, "{gaps:?} {step:?}");
            truth = math::min(truth, step.clearance_m);
            assert!(step.clearance_low_m <= truth + 1e-9, "{step:?} claims more than {truth}");
            episode_low = math::min(episode_low, step.clearance_low_m);
            episode_truth = math::min(episode_truth, truth);

            if let Some(contact) = step.contact {
                let kind = KINDS.iter().position(|&kind| kind == contact.with).unwrap();
                contacts[kind] += 1;
                // A true overlap, and no deeper than the first moment of one.
                assert!(gaps[kind] < 0.0 && gaps[kind] > -1e-6, "{gaps:?} {contact:?} in episode {episode}");
                assert!((contact.pose.position - on_arc(before, command, end_s)).norm() < 1e-9);
                assert_eq!(contact.at_rest, command.v.abs() < 0.02);
                break;
            }
        }
        // Samples are up to 8 m/s · 0.25 ms = 2 mm of relative motion from the true minimum.
        assert!(episode_truth - episode_low < 1e-3 + 2e-3, "{episode_truth} against {episode_low}");
        let Closest { movers_m, unknown_m } = world.closest();
        for (low_m, truth_m) in [(unknown_m, nearest[1]), (movers_m, nearest[2])] {
            assert!(
                low_m == truth_m || (low_m <= truth_m + 1e-9 && truth_m - low_m < 1e-3 + 2e-3),
                "{low_m} {truth_m}"
            );
        }
    }
    assert!(ticks > 4000 && contacts.iter().all(|&count| count > 50), "{ticks} ticks, {contacts:?}, {grazes} grazes");
}

#[test]
fn the_lowest_clearance_is_within_a_millimetre_of_a_closed_form() {
    // The robot passes a disc on a straight line: the truth is the distance of that line.
    let mut stream = EpisodeSeed { seed: 12, episode: 0 }.stream(Purpose::Planner, 0);
    for _ in 0..500 {
        let robot = nimble(stream.range(0.05, 0.4));
        let mut scene = empty_scene(20, 20, Pose::new(5.0, 10.0, 0.0));
        let beside = robot.radius_m + 0.5 + stream.range(0.0, 0.5);
        let pose = Pose::new(10.0 + stream.range(-0.5, 0.5), 10.0 + beside, 0.0);
        scene.unknown_static.push(UnknownStatic::new(pose, Shape::Disc { radius_m: 0.5 }));
        let mut world = World::new(&scene, &robot, &Conditions::default());
        let (v, mut low) = (stream.range(1.0, 5.0), f64::INFINITY);
        while world.pose().position.x < 15.0 {
            low = math::min(low, world.step(Twist { v, omega: 0.0 }).clearance_low_m);
        }
        let truth = beside - 0.5 - robot.radius_m;
        assert!(low <= truth + 1e-12 && low > truth - 1.001e-3, "{low} {truth}");
        let closest = world.closest();
        assert!(
            closest.unknown_m <= truth + 1e-12
                && closest.unknown_m > truth - 1.001e-3
                && closest.movers_m.is_infinite()
        );
    }
}

#[test]
fn grazes_on_an_arc_count_from_a_millimetre_of_depth_and_misses_never() {
    // Driving a circle about the origin of the turn, the robot comes within | |c| − R | of a disc's centre.
    let mut stream = EpisodeSeed { seed: 16, episode: 0 }.stream(Purpose::Planner, 0);
    for _ in 0..1000 {
        let robot = nimble(stream.range(0.05, 0.4));
        let (turn_radius, disc) = (stream.range(1.0, 4.0), stream.range(0.05, 0.5));
        let depth = stream.range(-3e-3, 4e-3);
        let centre = Vec2::new(10.0, 10.0);
        let mut scene = empty_scene(20, 20, Pose::new(10.0 + turn_radius, 10.0, math::FRAC_PI_2));
        let reach = turn_radius + robot.radius_m + disc - depth;
        let position = centre + reach * direction(stream.range(1.0, 5.0));
        let shape = Shape::Disc { radius_m: disc };
        scene.unknown_static.push(UnknownStatic::new(Pose { position, theta: 0.0 }, shape));
        let mut world = World::new(&scene, &robot, &Conditions::default());
        let v = stream.range(0.5, 5.0);
        let twist = Twist { v, omega: v / turn_radius };
        let (mut found, mut low) = (false, f64::INFINITY);
        for _ in 0..(math::TAU / (twist.omega * DT_S)).ceil() as u32 {
            let step = world.step(twist);
            low = math::min(low, step.clearance_low_m);
            found = step.contact.is_some();
            if found {
                break;
            }
        }
        assert!(found || depth <= 1e-3, "a graze {depth} deep at {v} m/s was missed");
        assert!(!found || depth > 0.0, "a miss by {} at {v} m/s was taken for a contact", -depth);
        if !found {
            assert!(low <= -depth + 1e-9 && low > -depth - 1.001e-3, "{low} for {}", -depth);
        }
    }
}

#[test]
fn a_straight_drive_a_circle_and_braking_follow_their_closed_forms() {
    let robot = nimble(0.25);
    let scene = empty_scene(20, 20, Pose::new(3.0, 10.0, 0.0));
    let mut world = World::new(&scene, &robot, &Conditions::default());
    for _ in 0..100 {
        world.step(Twist { v: 1.2, omega: 0.0 });
    }
    assert!((world.pose().position - Vec2::new(15.0, 10.0)).norm() < 1e-9);

    // One full turn of a circle of radius v / ω = 2 m, to the left of the start.
    world.reset();
    let (ticks, omega) = (50, math::TAU / 5.0);
    for tick in 1..=ticks {
        world.step(Twist { v: 2.0 * omega, omega });
        let turned = omega * DT_S * f64::from(tick);
        let expected = Vec2::new(3.0, 12.0) + 2.0 * direction(turned - 0.5 * math::PI);
        assert!((world.pose().position - expected).norm() < 1e-9, "{:?}", world.pose());
    }
    assert!((world.pose().position - scene.start.position).norm() < 1e-9);

    // From 1 m/s at 0.5 m/s², each tick at its end speed: 0.95 m (robot.rs works it out).
    let robot = Robot::default();
    let mut world = World::new(&scene, &robot, &Conditions::default());
    while world.twist().v < 1.0 {
        world.step(Twist { v: 1.0, omega: 0.0 });
    }
    let begin = world.pose().position.x;
    while world.twist().v > 0.0 {
        world.step(Twist::ZERO);
    }
    assert!((world.pose().position.x - begin - 0.95).abs() < 1e-9);
}

#[test]
fn the_contact_is_at_its_closed_form_and_names_what_was_hit() {
    // At 2 m/s from x = 2.5 with radius 0.25 against the face at x = 4: 1.25 m, 0.625 s: 25 ms into tick 7.
    let mut grid = OccupancyGrid::empty(8, 3, 1.0);
    grid.set_occupied(Cell { col: 4, row: 1 });
    let map = Arc::new(StaticMap::new(grid));
    let robot = nimble(0.25);
    let drive = |scene: &Scene, v: f64| {
        let mut world = World::new(scene, &robot, &Conditions::default());
        (1..100).find_map(|tick| world.step(Twist { v, omega: 0.0 }).contact.map(|contact| (tick, contact)))
    };
    let scene = Scene::new(&map, Pose::new(2.5, 1.5, 0.0), Vec2::new(2.5, 1.5));
    let (tick, contact) = drive(&scene, 2.0).unwrap();
    assert_eq!((tick, contact.with, contact.at_rest), (7, ObstacleKind::KnownStatic, false));
    assert!((contact.time_s - 0.025).abs() < 1e-8 && (contact.pose.position.x - 3.75).abs() < 1e-8);
    // Backwards, the map's edge: 2.25 m at 2 m/s = 1.125 s.
    let (tick, contact) = drive(&scene, -2.0).unwrap();
    assert_eq!((tick, contact.with), (12, ObstacleKind::Boundary));
    assert!((contact.time_s - 0.025).abs() < 1e-8);
    // A mover drives into the standing robot: 1.5 − 0.25 − 0.3 = 0.95 m at 1 m/s, at the end of tick 10 less 50 ms.
    let mut scene = scene;
    scene.movers.push(straight_mover(Vec2::new(1.0, 1.5), Vec2::new(1.0, 0.0), 0.3, OnStatic::Reflect));
    let (tick, contact) = drive(&scene, 0.0).unwrap();
    assert_eq!((tick, contact.with, contact.at_rest), (10, ObstacleKind::Dynamic, true));
    assert!((contact.time_s - 0.05).abs() < 1e-8);
}

#[test]
fn a_robot_as_wide_as_its_lane_does_not_touch_the_walls() {
    let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(&["########", "........", "########"], 0.1)));
    let robot = nimble(0.05);
    let scene = Scene::new(&map, Pose::new(0.15, 0.15, 0.0), Vec2::new(0.6, 0.15));
    let mut world = World::new(&scene, &robot, &Conditions::default());
    for _ in 0..10 {
        assert_eq!(world.step(Twist { v: 0.5, omega: 0.0 }).contact, None);
    }
}

#[test]
fn a_fast_robot_cannot_jump_over_a_thin_obstacle() {
    // 0.5 m a tick through a sheet of 2 mm.
    let mut scene = empty_scene(12, 4, Pose::new(1.0, 2.0, 0.0));
    let half_m = Vec2::new(0.001, 1.0);
    scene.unknown_static.push(UnknownStatic::new(Pose::new(6.3, 2.0, 0.0), Shape::Rectangle { half_m }));
    let robot = nimble(0.05);
    let mut world = World::new(&scene, &robot, &Conditions::default());
    let contact = (0..20).find_map(|_| world.step(Twist { v: 5.0, omega: 0.0 }).contact).unwrap();
    assert_eq!(contact.with, ObstacleKind::UnknownStatic);
    assert!((contact.pose.position.x - (6.299 - 0.05)).abs() < 1e-8);
}

#[test]
fn a_yielding_mover_waits_and_goes_on() {
    let mut scene = empty_scene(12, 4, Pose::new(6.0, 2.0, math::FRAC_PI_2));
    let mut mover = straight_mover(Vec2::new(2.0, 2.0), Vec2::new(1.0, 0.0), 0.3, OnStatic::Reflect);
    mover.on_robot = OnRobot::Yield;
    scene.movers.push(mover);
    let robot = nimble(0.25);
    let mut world = World::new(&scene, &robot, &Conditions::default());
    for _ in 0..100 {
        assert_eq!(world.step(Twist::ZERO).contact, None);
    }
    // Stops on the first tick that begins within 1 m of surface: the centres are then at most 1.55 m apart.
    let waiting = world.movers()[0].clone();
    assert_eq!(waiting.velocity, Vec2::zeros());
    assert!((4.45..4.55).contains(&waiting.position.x), "{waiting:?}");
    // The robot backs out of its way, from y = 2 to 0.5: 2.1 m between the centres.
    for _ in 0..3 {
        world.step(Twist { v: -5.0, omega: 0.0 });
    }
    world.step(Twist::ZERO);
    assert_eq!(world.movers()[0].velocity, Vec2::new(1.0, 0.0));
}

#[test]
fn obstacles_are_sensed_by_their_surface_and_statics_only_once() {
    let mut scene = empty_scene(20, 5, Pose::new(1.0, 2.5, 0.0));
    // Range 5 m. The mover's surface is at x = 5.95, sensed at once; the square's at x = 6.5, sensed from x = 1.5.
    scene.movers.push(straight_mover(Vec2::new(6.25, 2.5), Vec2::zeros(), 0.3, OnStatic::Reflect));
    let half_m = Vec2::new(0.5, 0.5);
    scene.unknown_static.push(UnknownStatic::new(Pose::new(7.0, 2.5, 0.0), Shape::Rectangle { half_m }));
    let robot = nimble(0.25);
    let mut world = World::new(&scene, &robot, &Conditions::default());
    let mut belief = Belief::new(&scene.map.grid, &scene.map.field);
    let mut sensed = Vec::new();
    world.sense(&mut belief, &mut sensed);
    assert_eq!((sensed.len(), world.seen_statics(), belief.revision()), (1, 0, 0));
    assert_eq!(sensed[0].position, Vec2::new(6.25, 2.5));
    for _ in 0..5 {
        world.step(Twist { v: 1.0, omega: 0.0 });
    }
    for _ in 0..2 {
        world.step(Twist { v: 0.01, omega: 0.0 });
        world.sense(&mut belief, &mut sensed);
        assert_eq!((world.seen_statics(), belief.revision()), (1, 1));
    }
    // From x = 6.5 to 7.5: two cells of one row.
    assert_eq!(belief.added(), [Cell { col: 6, row: 2 }, Cell { col: 7, row: 2 }]);
}

#[test]
fn worlds_of_one_scene_stay_bit_equal_also_after_a_reset() {
    let mut stream = EpisodeSeed { seed: 14, episode: 3 }.stream(Purpose::Planner, 0);
    let scene = random_scene(&mut stream).unwrap();
    let robot = nimble(0.2);
    let mut first = World::new(&scene, &robot, &Conditions::default());
    let mut second = World::new(&scene, &robot, &Conditions::default());
    let mut log = Vec::new();
    for tick in 0..200 {
        let command = Twist { v: math::sin(f64::from(tick)), omega: 0.3 };
        let step = first.step(command);
        assert_eq!(step, second.step(command));
        assert_eq!(first.movers(), second.movers());
        log.push((step, first.pose()));
    }
    first.reset();
    for (tick, logged) in log.iter().enumerate() {
        let step = first.step(Twist { v: math::sin(tick as f64), omega: 0.3 });
        assert_eq!((step, first.pose()), *logged);
    }
}

#[test]
fn rapier_holds_the_same_poses_and_the_same_clearance() {
    let mut compared = 0;
    for episode in 0..200 {
        let mut stream = EpisodeSeed { seed: 15, episode }.stream(Purpose::Planner, 0);
        let Some(scene) = random_scene(&mut stream) else { continue };
        let robot = nimble(stream.range(0.05, 0.3));
        let mut world = World::new(&scene, &robot, &Conditions::default());
        if world.clearance_m() < 0.0 {
            continue;
        }
        for _ in 0..10 {
            let command = Twist { v: stream.range(-2.0, 2.0), omega: stream.range(-2.0, 2.0) };
            let step = world.step(command);
            let physics = &world.physics.world;
            let body = &physics.bodies[world.physics.robot];
            let p = world.pose().position;
            assert_eq!(body.translation(), Vector::new(p.x as f32, p.y as f32));
            assert!((f64::from(body.rotation().angle()) - world.pose().theta).abs() < 1e-6);
            for (handle, mover) in world.physics.movers.iter().zip(world.movers()) {
                let expected = Vector::new(mover.position.x as f32, mover.position.y as f32);
                assert_eq!(physics.bodies[*handle].translation(), expected);
            }
            if step.contact.is_some() {
                break;
            }
            // Everything but the robot itself, through rapier's own acceleration structure.
            let filter = QueryFilter::new().exclude_rigid_body(world.physics.robot);
            let query = physics.query_pipeline_with_filter(filter);
            let ball = Ball::new(robot.radius_m as f32);
            let theirs = distance_composite_shape_shape(query.dispatcher, body.position(), &query, &ball).distance;
            assert!((f64::from(theirs) - step.clearance_m).abs() < 1e-4, "{theirs} {step:?}");
            compared += 1;
        }
    }
    assert!(compared > 200, "{compared}");
}

#[test]
fn belief_takes_in_exactly_the_touched_cells() {
    let mut scene = empty_scene(10, 10, Pose::new(2.5, 2.5, 0.0));
    // A disc of 0.6 about a corner point touches the four cells around it.
    scene.unknown_static.push(UnknownStatic::new(Pose::new(5.0, 5.0, 0.0), Shape::Disc { radius_m: 0.6 }));
    let robot = Robot::default();
    let mut world = World::new(&scene, &robot, &Conditions::default());
    let mut belief = Belief::new(&scene.map.grid, &scene.map.field);
    world.sense(&mut belief, &mut Vec::new());
    let mut expected = OccupancyGrid::clone(&scene.map.grid);
    for (col, row) in [(4, 4), (5, 4), (4, 5), (5, 5)] {
        expected.set_occupied(Cell { col, row });
    }
    assert_eq!(belief.grid(), &expected);
    assert_eq!(belief.field(), &DistanceField::new(&expected));
}

#[test]
#[should_panic(expected = "not finite")]
fn a_command_that_is_not_a_number_is_a_bug_of_the_caller() {
    let scene = empty_scene(3, 3, Pose::new(1.5, 1.5, 0.0));
    World::new(&scene, &Robot::default(), &Conditions::default()).step(Twist { v: f64::NAN, omega: 0.0 });
}

#[test]
fn movers_and_the_script_go_by_time_at_any_control_period() {
    use crate::settings::quantity::Period;
    use crate::world::{Change, Event, Irregular, Patrol};

    let mut scene = empty_scene(14, 10, Pose::new(1.0, 1.0, 0.0));
    let half_m = Vec2::new(0.5, 0.5);
    scene.unknown_static.push(UnknownStatic::new(Pose::new(7.0, 5.0, 0.3), Shape::Rectangle { half_m }));
    let waypoints = Arc::new([Vec2::new(3.0, 8.0), Vec2::new(9.0, 8.0), Vec2::new(9.0, 3.0)]);
    let patrol = Patrol { waypoints, speed_mps: 0.7, closed: false, pause_s: 0.33 };
    let stream = EpisodeSeed { seed: 19, episode: 0 }.stream(Purpose::Motion, 0);
    let irregular = Irregular { interval_s: [0.5, 2.0], speed_mps: [0.3, 0.9], stream };
    scene.movers = vec![
        straight_mover(Vec2::new(12.0, 4.0), Vec2::new(-0.9, 0.5), 0.3, OnStatic::Reflect),
        Mover { motion: patrol.into(), ..Mover::new(Vec2::new(3.0, 8.0), Vec2::zeros(), 0.2) },
        Mover { motion: irregular.into(), ..Mover::new(Vec2::new(4.0, 6.0), Vec2::new(0.4, 0.0), 0.3) },
    ];
    scene.script = vec![
        Event { at_s: 3.0, change: Change::velocity(0, Vec2::new(0.2, -0.6)) },
        Event { at_s: 5.0, change: Change::halt(1, true) },
        Event { at_s: 7.0, change: Change::halt(1, false) },
    ];
    let robot = nimble(0.25);
    // Where the movers are after every second of half a minute.
    let places = |ticks_per_s: u32| -> Vec<Vec<Vec2>> {
        let control_period_s = Period::new(1.0 / f64::from(ticks_per_s));
        let mut world = World::new(&scene, &robot, &Conditions { control_period_s, ..Conditions::default() });
        let mut second = |_| {
            for _ in 0..ticks_per_s {
                world.step(Twist::ZERO);
            }
            world.movers().iter().map(|mover| mover.position).collect()
        };
        (0..30).map(&mut second).collect()
    };
    let papers = places(10);
    for ticks_per_s in [1, 4, 7, 20, 50] {
        for (second, (ours, expected)) in places(ticks_per_s).iter().zip(&papers).enumerate() {
            for (number, (place, expected)) in ours.iter().zip(expected).enumerate() {
                let away_m = (place - expected).norm();
                assert!(away_m < 1e-6, "mover {number} after {} s at {ticks_per_s} Hz: {away_m}", second + 1);
            }
        }
    }
}

#[test]
fn a_drive_covers_its_way_at_any_control_period() {
    use crate::settings::quantity::Period;

    let (robot, scene) = (nimble(0.25), empty_scene(20, 20, Pose::new(3.0, 10.0, 0.0)));
    for period_s in [0.01, 0.1, 0.5] {
        let control_period_s = Period::new(period_s);
        let mut world = World::new(&scene, &robot, &Conditions { control_period_s, ..Conditions::default() });
        for _ in 0..(5.0 / period_s).round() as u32 {
            assert_eq!(world.step(Twist { v: 1.2, omega: 0.0 }).contact, None);
        }
        assert!((world.pose().position - Vec2::new(9.0, 10.0)).norm() < 1e-9, "{period_s}");
    }
}
