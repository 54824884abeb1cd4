//! Tests of the window as a whole: rollouts, clearances, braking rule, normalisation, choice, recovery.

use super::*;
use crate::map::{Cell, OccupancyGrid};
use crate::observation::{Belief, SensedObstacle};
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::robot::Robot;

fn settings() -> Settings {
    Settings {
        normalise: Normalise::Sum,
        horizon_s: Some(3.0),
        movers_horizon_s: None,
        room_m: 0.0,
        prediction: Prediction::Euler,
        speed: Spacing::Count(5),
        yaw_rate: Spacing::Count(7),
        predict_dynamic: false,
        clearance_cap_m: 1.0,
        distance_mode: DistanceMode::PathMin,
        measure: Measure::Exact,
        braking_distance: BrakingDistance::Arc,
        braking_clip_m: None,
        braking_turn: BrakingTurn::Off,
    }
}

fn belief(grid: &OccupancyGrid) -> Belief {
    Belief::from(grid)
}

fn open_space() -> Belief {
    belief(&OccupancyGrid::empty(40, 40, 1.0))
}

fn observe<'a>(
    belief: &'a Belief,
    robot: &'a Robot,
    pose: Pose,
    twist: Twist,
    obstacles: &'a [SensedObstacle],
) -> Situation<'a> {
    Situation { twist, obstacles, ..Situation::new(robot, belief, pose, Vec2::zeros()) }
}

/// Poses after each step by the printed recurrence, in plain `f64`.
fn euler(mut pose: Pose, twist: Twist, steps: usize) -> Vec<Pose> {
    (0..steps)
        .map(|_| {
            let position = pose.position + direction(pose.theta) * twist.v * 0.1;
            pose = Pose { position, theta: pose.theta + twist.omega * 0.1 };
            pose
        })
        .collect()
}

#[test]
fn rollouts_end_where_the_closed_forms_say() {
    let (belief, robot) = (open_space(), Robot { yaw_rate_max_radps: 2.0, ..Robot::default() });
    let pose = Pose::new(20.3, 18.7, 0.9);
    for omega in [-1.7, 0.0, 0.6] {
        let situation = observe(&belief, &robot, pose, Twist { v: 0.8, omega }, &[]);
        let mut window = DynamicWindow::new(settings());
        let rollouts = window.roll(&situation, &Aim::ON);
        assert!(rollouts.len() >= 35);
        for i in 0..rollouts.len() {
            let expected = *euler(pose, rollouts.twist(i), 30).last().unwrap();
            assert!((rollouts.end(i).position - expected.position).norm() < 2e-5, "{:?}", rollouts.twist(i));
            assert!((rollouts.end(i).theta - crate::geometry::wrap_angle(expected.theta)).abs() < 1e-9);
        }
        let mut window = DynamicWindow::new(Settings { prediction: Prediction::Arc, ..settings() });
        let rollouts = window.roll(&situation, &Aim::ON);
        for i in 0..rollouts.len() {
            let expected = pose.advance(rollouts.twist(i), 3.0);
            assert!((rollouts.end(i).position - expected.position).norm() < 2e-5, "{:?}", rollouts.twist(i));
        }
    }
}

#[test]
fn far_from_everything_every_clearance_is_exactly_the_cap() {
    let (belief, robot) = (open_space(), Robot::default());
    let mut window = DynamicWindow::new(settings());
    let rollouts =
        window.roll(&observe(&belief, &robot, Pose::new(20.0, 20.0, 0.3), Twist { v: 0.7, omega: 0.1 }, &[]), &Aim::ON);
    assert_eq!(rollouts.admissible().count(), rollouts.len());
    for i in 0..rollouts.len() {
        assert_eq!(
            (rollouts.static_clearance(i), rollouts.mover_clearance(i)),
            (Clearance::both(1.0), Clearance::both(1.0))
        );
        assert!((rollouts.free_arc_m(i) - 3.0 * rollouts.twist(i).v).abs() < 1e-12);
    }
}

/// A world at random: coarse or fine cells, movers about the robot.
fn random_world(stream: &mut Stream) -> (Belief, Vec<SensedObstacle>, Pose, Twist) {
    let (side, resolution_m, density) = if stream.uniform() < 0.5 { (16, 1.0, 0.12) } else { (80, 0.2, 0.004) };
    let mut grid = OccupancyGrid::empty(side, side, resolution_m);
    for row in 0..side {
        for col in 0..side {
            if stream.uniform() < density {
                grid.set_occupied(Cell { col, row });
            }
        }
    }
    let mut point = |low: f64, high: f64| Vec2::new(stream.range(low, high), stream.range(low, high));
    let pose = Pose { position: point(2.0, 14.0), theta: 0.0 };
    let movers = (0..3).map(|_| SensedObstacle::disc(0, point(0.0, 16.0), point(-1.0, 1.0), 0.3)).collect();
    let pose = Pose { theta: stream.range(-3.1, 3.1), ..pose };
    (belief(&grid), movers, pose, Twist { v: stream.range(0.0, 1.0), omega: stream.range(-1.0, 1.0) })
}

fn static_distance_m(grid: &OccupancyGrid, p: Vec2) -> f64 {
    let extent = grid.extent_m();
    let mut best = math::min(math::min(p.x, extent.x - p.x), math::min(p.y, extent.y - p.y));
    for (index, _) in grid.occupied().iter().enumerate().filter(|&(_, &occupied)| occupied) {
        best = math::min(best, grid.square(grid.cell(index)).signed_distance(p));
    }
    best
}

#[test]
fn bounds_of_static_clearances_agree_with_brute_force() {
    let robot = Robot::default();
    let mut stream = EpisodeSeed { seed: 11, episode: 0 }.stream(Purpose::Planner, 0);
    let (mut touched, mut free) = (0, 0);
    for _ in 0..120 {
        let (belief, _, pose, twist) = random_world(&mut stream);
        if static_distance_m(belief.grid(), pose.position) < robot.radius_m + 0.03 {
            continue; // a start in contact has rules of its own
        }
        let mut window = DynamicWindow::new(Settings {
            normalise: Normalise::Fixed,
            speed: Spacing::Count(2),
            yaw_rate: Spacing::Count(3),
            ..settings()
        });
        let rollouts = window.roll(&observe(&belief, &robot, pose, twist, &[]), &Aim::ON);
        for i in 0..rollouts.len() {
            // Dense sampling of the line through the poses: what really is met on the way.
            let mut poses = vec![pose];
            poses.extend(euler(pose, rollouts.twist(i), 30));
            let (mut truth, mut first) = (f64::INFINITY, f64::INFINITY);
            for step in 0..30 {
                for part in 1..=8 {
                    let share = f64::from(part) / 8.0;
                    let p = poses[step].position + (poses[step + 1].position - poses[step].position) * share;
                    let gap = static_distance_m(belief.grid(), p) - robot.radius_m;
                    if step > 0 {
                        // A rollout counts from its first predicted pose on, not from where the robot is.
                        truth = math::min(truth, gap);
                    }
                    if gap <= 0.0 && first == f64::INFINITY {
                        first = (step as f64 + share) * 0.1 * rollouts.twist(i).v;
                    }
                }
            }
            let arc = rollouts.free_arc_m(i);
            assert!(
                arc <= first + 1e-6,
                "{arc} m free, but contact after {first} m {truth} {:?} {pose:?}",
                rollouts.twist(i)
            );
            if rollouts.touches(i) {
                touched += 1;
                // Not told of a contact unless there nearly is one.
                assert!(truth < 0.06, "no contact: {truth}");
            } else {
                free += 1;
                let (found, truth) = (rollouts.static_clearance(i), math::min(truth, 1.0));
                assert!(found.path_min_m <= truth + 1e-4, "{found:?} instead of {truth}");
                assert!(found.path_min_m >= truth - 0.075, "{found:?} instead of {truth}");
                assert!(found.path_min_m <= found.end_m);
            }
        }
    }
    assert!(touched > 100 && free > 100, "{touched} and {free}");
}

#[test]
fn clearances_of_the_papers_form_are_those_of_the_poses() {
    let robot = Robot::default();
    let mut stream = EpisodeSeed { seed: 14, episode: 0 }.stream(Purpose::Planner, 0);
    let (mut touched, mut free) = (0, 0);
    for case in 0..240 {
        let (belief, movers, pose, twist) = random_world(&mut stream);
        let (predict_dynamic, prediction) =
            (case % 2 == 0, if case % 3 == 0 { Prediction::Arc } else { Prediction::Euler });
        let distance_mode = if case % 5 < 2 { DistanceMode::Endpoint } else { DistanceMode::PathMin };
        let near = |m: &SensedObstacle| (m.position - pose.position).norm() < m.radius_m() + robot.radius_m + 0.1;
        if static_distance_m(belief.grid(), pose.position) < robot.radius_m + 0.03 || movers.iter().any(near) {
            continue; // a start in contact has rules of its own
        }
        let mut window = DynamicWindow::new(Settings {
            predict_dynamic,
            prediction,
            distance_mode,
            speed: Spacing::Count(3),
            yaw_rate: Spacing::Count(5),
            ..settings()
        });
        let rollouts = window.roll(&observe(&belief, &robot, pose, twist, &movers), &Aim::ON);
        for i in 0..rollouts.len() {
            let twist = rollouts.twist(i);
            let poses = match prediction {
                Prediction::Euler => euler(pose, twist, 30),
                Prediction::Arc => (1..=30).map(|k| pose.advance(twist, 0.1 * f64::from(k))).collect(),
            };
            let gaps = poses.iter().enumerate().map(|(k, at)| {
                let t = if predict_dynamic { 0.1 * (k + 1) as f64 } else { 0.0 };
                let of = |m: &SensedObstacle| (at.position - m.position - m.velocity * t).norm() - m.radius_m();
                let mover = movers.iter().map(of).fold(f64::INFINITY, math::min);
                (static_distance_m(belief.grid(), at.position) - robot.radius_m, mover - robot.radius_m)
            });
            let gaps: Vec<(f64, f64)> = gaps.collect();
            let lowest = |of: fn(&(f64, f64)) -> f64| gaps.iter().map(of).fold(f64::INFINITY, math::min);
            let (statics, mover) = (lowest(|gap| gap.0), lowest(|gap| gap.1));
            if math::min(statics, mover).abs() < 1e-4 {
                continue; // rounding decides
            }
            let first = gaps.iter().position(|gap| math::min(gap.0, gap.1) < 0.0);
            assert_eq!(rollouts.touches(i), first.is_some(), "{statics} {mover}");
            if let Some(first) = first {
                touched += 1;
                assert!((rollouts.free_arc_m(i) - first as f64 * 0.1 * twist.v.abs()).abs() < 1e-9);
                continue;
            }
            free += 1;
            let cut = |gap: f64| math::min(gap, 1.0);
            let (found, last) = (rollouts.static_clearance(i), cut(gaps[29].0));
            assert!((found.path_min_m - cut(statics)).abs() < 1e-5, "{found:?} instead of {statics}");
            assert!((rollouts.mover_clearance(i).path_min_m - cut(mover)).abs() < 1e-4, "{mover}");
            assert!(found.end_m <= last + 1e-5 && found.end_m >= found.path_min_m - 1e-6, "{found:?} {last}");
            assert!(distance_mode == DistanceMode::PathMin || (found.end_m - last).abs() < 1e-5, "{found:?} {last}");
        }
    }
    assert!(touched > 300 && free > 300, "{touched} and {free}");
}

/// Gaps of a footprint at a pose, each side by itself: to the statics, and to discs.
fn footprint_gaps_m(grid: &OccupancyGrid, movers: &[SensedObstacle], footprint: &Polygon, pose: Pose) -> (f64, f64) {
    let corners = footprint.placed(pose.position, direction(pose.theta));
    let sides = |k: usize| (corners[k], corners[(k + 1) % corners.len()]);
    let holds =
        |p: Vec2| (0..corners.len()).all(|k| crate::geometry::cross(sides(k).1 - sides(k).0, p - sides(k).0) > 0.0);
    let to_point = |p: Vec2| {
        let sides = (0..corners.len()).map(|k| crate::geometry::point_segment_distance(p, sides(k).0, sides(k).1));
        if holds(p) { -1.0 } else { sides.fold(f64::INFINITY, math::min) }
    };
    // Corners of the footprint to everything, and corners of the squares to the footprint.
    let mut statics = corners.iter().map(|&corner| static_distance_m(grid, corner)).fold(f64::INFINITY, math::min);
    for (index, _) in grid.occupied().iter().enumerate().filter(|&(_, &occupied)| occupied) {
        let square = grid.square(grid.cell(index));
        for corner in convex::rectangle(square) {
            statics = math::min(statics, to_point(corner));
        }
    }
    let movers = movers.iter().map(|m| to_point(m.position) - m.radius_m());
    (statics, movers.fold(f64::INFINITY, math::min))
}

#[test]
fn clearances_of_a_footprint_agree_with_brute_force() {
    let corners = [(0.45, 0.0), (0.3, 0.25), (-0.35, 0.25), (-0.35, -0.25), (0.3, -0.25)];
    let footprint = Polygon::new(&corners.map(|(x, y)| Vec2::new(x, y))).unwrap();
    let overhang_m = 0.08;
    for disc in footprint.cover() {
        let beyond = disc.radius_m + convex::point_distance(footprint.corners(), disc.centre);
        assert!(beyond <= overhang_m, "{beyond}");
    }
    let robot = Robot { radius_m: footprint.circumradius_m(), footprint: Some(footprint.clone()), ..Robot::default() };
    let mut stream = EpisodeSeed { seed: 12, episode: 0 }.stream(Purpose::Planner, 0);
    let (mut touched, mut free) = (0, 0);
    for case in 0..150 {
        let (belief, movers, pose, twist) = random_world(&mut stream);
        let (at_static, at_mover) = footprint_gaps_m(belief.grid(), &movers, &footprint, pose);
        if at_static < overhang_m + 0.1 || at_mover < overhang_m + 0.1 {
            continue; // a start in contact has rules of its own
        }
        let prediction = if case % 2 == 0 { Prediction::Euler } else { Prediction::Arc };
        let mut window = DynamicWindow::new(Settings {
            prediction,
            speed: Spacing::Count(2),
            yaw_rate: Spacing::Count(3),
            ..settings()
        });
        let rollouts = window.roll(&observe(&belief, &robot, pose, twist, &movers), &Aim::ON);
        for i in 0..rollouts.len() {
            let poses: Vec<Pose> = match prediction {
                Prediction::Euler => euler(pose, rollouts.twist(i), 30),
                Prediction::Arc => (1..=30).map(|k| pose.advance(rollouts.twist(i), 0.1 * f64::from(k))).collect(),
            };
            let gaps = poses.iter().map(|&pose| footprint_gaps_m(belief.grid(), &movers, &footprint, pose));
            let (statics, mover) = gaps.reduce(|a, b| (math::min(a.0, b.0), math::min(a.1, b.1))).expect("30 poses");
            if rollouts.touches(i) {
                touched += 1;
                let nearest = math::min(statics, mover);
                assert!(nearest < overhang_m + 0.085, "no contact: {statics}, {mover}, {:?}", rollouts.twist(i));
            } else {
                free += 1;
                for (found, truth, slack) in [
                    (rollouts.static_clearance(i), statics, overhang_m + 0.085),
                    (rollouts.mover_clearance(i), mover, overhang_m + 0.03),
                ] {
                    let truth = math::min(truth, 1.0);
                    assert!(found.path_min_m <= truth + 1e-4, "{found:?} instead of {truth}");
                    assert!(found.path_min_m >= truth - slack, "{found:?} instead of {truth}");
                    assert!(found.path_min_m <= found.end_m);
                }
            }
        }
    }
    assert!(touched > 80 && free > 80, "{touched} and {free}");
}

#[test]
#[expect(clippy::print_stderr, reason = "a test that is skipped says so")]
fn every_width_of_lanes_gives_the_same_bits() {
    if !Width::widest().is_wide() {
        eprintln!("skipped: this processor has no AVX2");
        return;
    }
    let corners = [(0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2)];
    let footprint = Polygon::new(&corners.map(|(x, y)| Vec2::new(x, y))).unwrap();
    let disc = Robot::default();
    let polygon = Robot { radius_m: footprint.circumradius_m(), footprint: Some(footprint), ..Robot::default() };
    let mut stream = EpisodeSeed { seed: 13, episode: 0 }.stream(Purpose::Planner, 0);
    for case in 0..400 {
        let (belief, movers, pose, twist) = random_world(&mut stream);
        let robot = if case % 2 == 0 { &disc } else { &polygon };
        let settings = Settings {
            prediction: if case % 3 == 0 { Prediction::Arc } else { Prediction::Euler },
            predict_dynamic: case % 4 < 2,
            normalise: if case % 5 < 3 { Normalise::Fixed } else { Normalise::Sum },
            ..settings()
        };
        let mut wide = DynamicWindow::new(settings.clone());
        let mut plain = DynamicWindow { width: Width::PLAIN, ..DynamicWindow::new(settings) };
        let situation = observe(&belief, robot, pose, twist, &movers);
        let arrival_m = if case % 7 < 3 { 1.3 } else { f64::INFINITY };
        let aim = Aim { arrival_m, stop: pose.position + Vec2::new(0.9, -0.9), ..Aim::ON };
        wide.roll(&situation, &aim);
        plain.roll(&situation, &aim);
        let (wide, plain) = (wide.admit_stopping(&situation), plain.admit_stopping(&situation));
        assert_eq!((&wide.admissible, &wide.going_on_s), (&plain.admissible, &plain.going_on_s));
        let bits = |rollouts: &Rollouts| {
            let clearances = rollouts.statics.iter().chain(&rollouts.movers).flat_map(|c| [c.path_min_m, c.end_m]);
            let ends = rollouts.end.iter().flat_map(|end| [end.x, end.y]);
            clearances.chain(ends).chain(rollouts.free_s.iter().copied()).map(f64::to_bits).collect::<Vec<_>>()
        };
        assert_eq!(bits(wide), bits(plain));
    }
}

#[test]
fn a_wall_ahead_limits_the_free_arc() {
    // The wall's face is at x = 10; from x = 8 the disc of 0.25 m touches after 1.75 m.
    let mut grid = OccupancyGrid::empty(20, 20, 1.0);
    for row in 0..20 {
        grid.set_occupied(Cell { col: 10, row });
    }
    let (belief, robot) = (belief(&grid), Robot::default());
    let situation = observe(&belief, &robot, Pose::new(8.0, 9.5, 0.0), Twist { v: 0.8, omega: 0.0 }, &[]);
    let mut window = DynamicWindow::new(settings());
    let rollouts = window.roll(&situation, &Aim::ON);
    let straight: Vec<usize> = (0..rollouts.len()).filter(|&i| rollouts.twist(i).omega == 0.0).collect();
    for i in straight {
        let step = rollouts.twist(i).v * 0.1;
        assert!(rollouts.touches(i));
        // Within two steps before the contact: one is the step itself, the other what is taken off per step.
        let arc = rollouts.free_arc_m(i);
        assert!(arc <= 1.75 && arc > 1.75 - 2.0 * step, "{arc}");
    }
    assert!(rollouts.admissible().all(|i| !rollouts.touches(i)));
}

#[test]
fn the_braking_rule_by_clearance_is_the_printed_one() {
    // A lane of 1 m, the robot in its middle: clearance 0.25 m, so v ≤ √(2·0.25·0.5) = 0.5 m/s.
    let mut grid = OccupancyGrid::empty(30, 3, 1.0);
    for col in 0..30 {
        grid.set_occupied(Cell { col, row: 0 });
        grid.set_occupied(Cell { col, row: 2 });
    }
    let (belief, robot) = (belief(&grid), Robot::default());
    let fastest = |braking_distance, clip, turn| {
        let mut window = DynamicWindow::new(Settings {
            braking_distance,
            braking_clip_m: clip,
            braking_turn: turn,
            speed: Spacing::Step(0.01),
            ..settings()
        });
        let situation = observe(&belief, &robot, Pose::new(10.0, 1.5, 0.0), Twist { v: 0.51, omega: 0.0 }, &[]);
        let rollouts = window.roll(&situation, &Aim::ON);
        rollouts.admissible().map(|i| rollouts.twist(i).v).fold(0.0, math::max)
    };
    let off = BrakingTurn::Off;
    assert!((fastest(BrakingDistance::Clearance, None, off) - 0.5).abs() < 0.011);
    assert!((fastest(BrakingDistance::Arc, None, off) - 0.56).abs() < 1e-9);
    // Cut at 0.27 m: √(2·0.27·0.5) = 0.5196.
    assert!((fastest(BrakingDistance::Arc, Some(0.27), off) - 0.51).abs() < 0.011);
}

#[test]
fn terms_are_normalised_over_the_admissible_rollouts_and_ties_are_specified() {
    let twist = |v, omega| Twist { v, omega };
    let mut rollouts = Rollouts::new();
    rollouts.twists = vec![twist(0.1, 0.0), twist(0.2, -0.3), twist(0.2, 0.3), twist(0.2, 0.1), twist(0.9, 0.0)];
    rollouts.admissible = vec![0, 1, 2, 3];
    let mut score = Score::default();

    // Speeds 0.1, 0.2, 0.2, 0.2 sum to 0.7; the inadmissible 0.9 counts for nothing.
    let mut scoring = score.over(&rollouts);
    scoring.add(2.0, |i| rollouts.twist(i).v);
    for (i, expected) in [2.0 / 7.0, 4.0 / 7.0, 4.0 / 7.0, 4.0 / 7.0, 0.0].into_iter().enumerate() {
        assert!((scoring.score(i) - expected).abs() < 1e-12, "{i}");
    }
    // A term that is 0 everywhere adds 0; one that differs multiplies: (1, 3, 3, 3)/10.
    scoring.add(5.0, |_| 0.0);
    scoring.multiply(|i| if i == 0 { 1.0 } else { 3.0 });
    assert!((scoring.score(0) - 0.2 / 7.0).abs() < 1e-12 && (scoring.score(1) - 1.2 / 7.0).abs() < 1e-12);
    // 1, 2 and 3 tie in score and speed: the smallest |ω| wins.
    assert_eq!(scoring.best(), Some(3));

    // Equal |ω|: the lower index. All scores equal: the larger speed first.
    rollouts.admissible = vec![0, 1, 2];
    assert_eq!(score.over(&rollouts).best(), Some(1));
    // A weight for each rollout.
    let mut scoring = score.over(&rollouts);
    scoring.add_weighted(|i| if i == 0 { 9.0 } else { 1.0 }, |_| 1.0);
    assert_eq!(scoring.best(), Some(0));
    rollouts.admissible.clear();
    assert_eq!(score.over(&rollouts).best(), None);
}

#[test]
#[should_panic(expected = "a term of the objective is NaN")]
fn a_term_that_is_not_a_number_is_refused() {
    let mut rollouts = Rollouts::new();
    rollouts.twists = vec![Twist::ZERO];
    rollouts.admissible = vec![0];
    Score::default().over(&rollouts).add(1.0, |_| f64::NAN);
}

#[test]
fn recovery_brakes_as_hard_as_it_can_and_then_turns_on_the_spot() {
    let (belief, robot) = (open_space(), Robot::default());
    let target = Vec2::new(20.0, 30.0); // to the left
    let mut window = DynamicWindow::new(settings());
    let rolling = observe(&belief, &robot, Pose::new(20.0, 20.0, 0.0), Twist { v: 0.6, omega: 0.0 }, &[]);
    let recovery = window.recover(&rolling, target);
    assert!((recovery.command.v - 0.55).abs() < 1e-12); // 0.6 − 0.5·0.1
    assert!((recovery.command.omega - 0.2).abs() < 1e-12); // 2·0.1: as much towards the target as one tick allows
    assert!(recovery.rollouts >= 7);

    let standing = observe(&belief, &robot, Pose::new(20.0, 20.0, 0.0), Twist { v: 0.04, omega: 0.0 }, &[]);
    let recovery = window.recover(&standing, target);
    assert_eq!(recovery.command, Twist { v: 0.0, omega: 1.0 }); // √(2·2·π/2) = 2.5, the limit is 1
}

/// A robot that rolls at 0.9 m/s along a wall on its left, whose face is at y = 2, and recovers towards a target beyond it: how
/// near its edge comes to the wall, and where it ends.
fn recover_beside_a_wall(y_m: f64) -> (f64, Twist, Pose) {
    let mut grid = OccupancyGrid::empty(20, 6, 1.0);
    for col in 0..20 {
        grid.set_occupied(Cell { col, row: 2 });
    }
    let (belief, robot) = (belief(&grid), Robot::default());
    let (mut pose, mut twist) = (Pose::new(3.0, y_m, 0.0), Twist { v: 0.9, omega: 0.0 });
    let mut window = DynamicWindow::new(settings());
    let mut closest = f64::INFINITY;
    for _ in 0..60 {
        let recovery = window.recover(&observe(&belief, &robot, pose, twist, &[]), BEYOND_THE_WALL);
        twist = robot.actuate(twist, recovery.command, 0.1);
        for _ in 0..10 {
            pose = pose.advance(twist, 0.01);
            closest = math::min(closest, static_distance_m(belief.grid(), pose.position) - robot.radius_m);
        }
    }
    (closest, twist, pose)
}

const BEYOND_THE_WALL: Vec2 = Vec2::new(10.0, 5.0);

#[test]
fn recovery_does_not_turn_into_a_wall_while_it_rolls() {
    // Its edge is 3 cm from the wall.
    let (closest, twist, pose) = recover_beside_a_wall(1.72);
    assert!(closest > 0.0, "{closest}");
    assert!(twist.v == 0.0 && pose.bearing_to(BEYOND_THE_WALL).abs() < 0.05, "{twist:?} {pose:?}");
}

#[test]
fn recovery_keeps_room_where_there_is_room() {
    // 30 cm: the turn to the target must not end on the wall's face. What the prediction may be wrong by comes off the 5 cm.
    let (closest, ..) = recover_beside_a_wall(1.45);
    assert!((0.035..0.3).contains(&closest), "{closest}");
}

#[test]
fn a_robot_believed_in_contact_may_leave_but_not_go_deeper() {
    // The face of the wall is at x = 10; at x = 9.76 the edge is believed 1 cm inside it.
    let mut grid = OccupancyGrid::empty(20, 20, 1.0);
    for row in 0..20 {
        grid.set_occupied(Cell { col: 10, row });
    }
    let (belief, robot) = (belief(&grid), Robot::default());
    let admissible = |theta: f64| {
        let mut window = DynamicWindow::new(settings());
        let rollouts = window.roll(&observe(&belief, &robot, Pose::new(9.76, 9.5, theta), Twist::ZERO, &[]), &Aim::ON);
        let straight_on = |i: &usize| rollouts.twist(*i).v > 0.03 && rollouts.twist(*i).omega == 0.0;
        (rollouts.admissible().count(), rollouts.admissible().filter(straight_on).count())
    };
    assert_eq!(admissible(0.0).1, 0, "not into the wall");
    assert!(admissible(0.0).0 > 0, "standing and turning");
    assert!(admissible(math::PI).1 > 0, "away from it");
}

#[test]
fn a_believed_twist_outside_the_limits_is_no_panic() {
    let (belief, robot) = (open_space(), Robot::default());
    let mut window = DynamicWindow::new(settings());
    for v in [0.4, 1.6, -0.5, 1.02] {
        let situation = observe(&belief, &robot, Pose::new(20.0, 20.0, 0.0), Twist { v, omega: 1.7 }, &[]);
        assert!(!window.roll(&situation, &Aim::ON).is_empty());
    }
}

#[test]
fn wheel_limits_apply_to_what_is_predicted() {
    let (belief, robot) = (open_space(), Robot { wheel_speed_max_mps: 0.7, ..Robot::default() });
    let mut window = DynamicWindow::new(settings());
    let pose = Pose::new(20.0, 20.0, 0.0);
    let rollouts = window.roll(&observe(&belief, &robot, pose, Twist { v: 0.6, omega: 0.5 }, &[]), &Aim::ON);
    for i in 0..rollouts.len() {
        let (left, right) = robot.wheel_speeds(rollouts.twist(i));
        assert!(left <= 0.7 + 1e-12 && right <= 0.7 + 1e-12);
        let expected = *euler(pose, rollouts.twist(i), 30).last().unwrap();
        assert!((rollouts.end(i).position - expected.position).norm() < 2e-5, "{:?}", rollouts.twist(i));
    }
}

/// Tracks of a constant twist that brakes along its arc after `brake_s`, by small steps in `f64`.
fn glide(robot: &Robot, pose: Pose, twist: Twist, brake_s: f64, horizon_s: f64, mut at: impl FnMut(f64, Pose)) {
    const STEP_S: f64 = 0.005;
    let mut here = pose;
    for k in 1..=(horizon_s / STEP_S).round() as u32 {
        let time_s = f64::from(k) * STEP_S;
        let lost = robot.deceleration_max_mps2 * math::max(time_s - 0.5 * STEP_S - brake_s, 0.0);
        let share = if lost > 0.0 { math::max(1.0 - lost / twist.v, 0.0) } else { 1.0 };
        here = here.advance(Twist { v: twist.v * share, omega: twist.omega * share }, STEP_S);
        at(time_s, here);
    }
}

#[test]
fn the_two_ways_past_the_movers_agree_with_small_steps() {
    let robot = Robot::default();
    let mut stream = EpisodeSeed { seed: 17, episode: 0 }.stream(Purpose::Planner, 0);
    let belief = open_space();
    let (mut hit, mut passed, mut stopped, mut run_over) = (0, 0, 0, 0);
    for _ in 0..300 {
        let pose = Pose::new(20.0, 20.0, stream.range(-3.0, 3.0));
        let twist = Twist { v: stream.range(0.2, 1.0), omega: stream.range(-1.0, 1.0) };
        let away = direction(stream.range(-3.0, 3.0)) * stream.range(1.5, 4.0);
        let velocity = Vec2::new(stream.range(-1.0, 1.0), stream.range(-1.0, 1.0));
        let mover = SensedObstacle::disc(0, pose.position + away, velocity, 0.3);
        let settings = Settings {
            normalise: Normalise::Fixed,
            prediction: Prediction::Arc,
            predict_dynamic: true,
            speed: Spacing::Count(2),
            yaw_rate: Spacing::Count(3),
            horizon_s: None,
            ..settings()
        };
        let mut window = DynamicWindow::new(settings);
        let movers = [mover];
        let situation = observe(&belief, &robot, pose, twist, &movers);
        let passes: Vec<usize> = window.roll(&situation, &Aim::ON).admissible().collect();
        let rollouts = window.admit_stopping(&situation);
        for i in 0..rollouts.len() {
            let gap = |brake_s: f64| {
                let mut least = f64::INFINITY;
                glide(&robot, pose, rollouts.twist(i), brake_s, 3.0, |time_s, here| {
                    let gap = (here.position - movers[0].position - velocity * time_s).norm() - 0.3 - robot.radius_m;
                    least = math::min(least, gap);
                });
                least
            };
            // The room of 5 cm, and what the bound between two poses takes off: at most ¼ (0.2 m)² over the distance, 2 cm.
            let (going_on, stopping) = (gap(f64::INFINITY), gap(0.1));
            assert_eq!(passes.contains(&i), rollouts.going_on_s(i).is_infinite());
            if passes.contains(&i) {
                assert!(going_on > 0.049, "{going_on}");
                passed += 1;
            } else {
                assert!(going_on < 0.075, "{going_on}");
                hit += 1;
                if rollouts.admissible().any(|admitted| admitted == i) {
                    assert!(stopping > 0.049, "{stopping}");
                    stopped += 1;
                } else {
                    assert!(stopping < 0.075, "{stopping}");
                    run_over += 1;
                }
            }
        }
    }
    assert!(hit > 100 && passed > 500 && stopped > 50 && run_over > 50, "{hit} {passed} {stopped} {run_over}");
}

#[test]
fn a_rollout_that_ends_at_a_rack_stands_there_in_the_way_of_the_mover() {
    // A rack across the lane 2 m ahead; a mover comes along its face. Going on means to brake before the rack.
    let mut grid = OccupancyGrid::empty(40, 40, 0.5);
    for row in 0..40 {
        grid.set_occupied(Cell { col: 24, row });
    }
    let (belief, robot) = (belief(&grid), Robot::default());
    let movers = [SensedObstacle::disc(0, Vec2::new(11.6, 12.9), Vec2::new(0.0, -1.0), 0.3)];
    let situation = observe(&belief, &robot, Pose::new(10.0, 10.0, 0.0), Twist { v: 0.6, omega: 0.0 }, &movers);
    let settings =
        Settings { normalise: Normalise::Fixed, predict_dynamic: true, prediction: Prediction::Arc, ..settings() };
    let mut window = DynamicWindow::new(Settings { horizon_s: None, ..settings });
    let rollouts = window.roll(&situation, &Aim::ON);
    let straight = (0..rollouts.len()).find(|&i| rollouts.twist(i) == Twist { v: 0.6, omega: 0.0 }).unwrap();
    assert!(rollouts.admissible().all(|i| i != straight), "it would stand at x = 11.7, in the mover's way");
    assert!(window.admit_stopping(&situation).admissible().any(|i| i == straight), "and may stop short of it");
}

#[test]
fn a_mover_before_a_static_is_expected_to_turn() {
    let mut grid = OccupancyGrid::empty(40, 40, 0.5);
    grid.set_occupied(Cell { col: 20, row: 20 });
    let belief = belief(&grid);
    // The square is [10, 10.5]²; the disc of 0.3 m touches it at x = 9.7, after 1.7 m at 1 m/s.
    let velocity = Vec2::new(1.0, 0.0);
    let mover = SensedObstacle::disc(0, Vec2::new(8.0, 10.25), velocity, 0.3);
    let bounce = Bounce::of(&mover, velocity, &belief, 0.1, 30).expect("it meets the square");
    assert_eq!(bounce.step, 18, "the first step that is inside, for at 1.7 m it touches exactly");
    assert!((bounce.mirrored(velocity) + velocity).norm() < 1e-12);
    // Past it, away from it, beside it while it touches: straight on.
    for (position, velocity) in [((8.0, 9.6), (1.0, 0.0)), ((9.0, 10.25), (-1.0, 0.0)), ((9.75, 10.25), (0.0, 0.1))] {
        let (position, velocity) = (Vec2::new(position.0, position.1), Vec2::new(velocity.0, velocity.1));
        let mover = SensedObstacle::disc(0, position, velocity, 0.3);
        assert_eq!(Bounce::of(&mover, velocity, &belief, 0.1, 30), None, "{position:?}");
    }
    // The edge of the map mirrors as well.
    let velocity = Vec2::new(0.6, 0.8);
    let mover = SensedObstacle::disc(0, Vec2::new(5.0, 18.9), velocity, 0.3);
    let bounce = Bounce::of(&mover, velocity, &belief, 0.1, 30).expect("it meets the edge");
    assert!((bounce.mirrored(velocity) - Vec2::new(0.6, -0.8)).norm() < 1e-12);
}

#[test]
fn a_robot_at_rest_leaves_the_lane_of_a_mover() {
    // A mover at 1 m/s, 3.5 m away, straight at the robot: within the window of one tick nothing escapes it.
    let (belief, robot) = (open_space(), Robot::default());
    let settings = Settings { normalise: Normalise::Fixed, predict_dynamic: true, ..settings() };
    let mut window = DynamicWindow::new(Settings { horizon_s: None, ..settings });
    let (mut pose, mut twist) = (Pose::new(20.0, 20.0, math::FRAC_PI_2), Twist::ZERO);
    let mut mover = SensedObstacle::disc(0, Vec2::new(16.5, 20.0), Vec2::new(1.0, 0.0), 0.3);
    let mut gap = f64::INFINITY;
    for _ in 0..60 {
        let movers = [mover.clone()];
        let situation = observe(&belief, &robot, pose, twist, &movers);
        window.roll(&situation, &Aim::ON);
        let rollouts = window.admit_stopping(&situation);
        let standing = rollouts.admissible().find(|&i| rollouts.twist(i) == Twist::ZERO);
        let command = match standing {
            Some(_) => Twist::ZERO,
            None => window.decide(None, &situation, Vec2::new(20.0, 30.0)).command,
        };
        twist = robot.actuate(twist, command, 0.1);
        pose = pose.advance(twist, 0.1);
        mover.position += mover.velocity * 0.1;
        gap = math::min(gap, (pose.position - mover.position).norm() - 0.3 - robot.radius_m);
    }
    assert!(gap > 0.02, "{gap}");
}
