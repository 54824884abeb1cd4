//! Perception and actuation of the robot against the distributions that the scenario states, and the script.

use simrun::episode::{Outcome, Runner, Setting, TerminationSpec};
use simrun::geometry::{Pose, Twist, Vec2, wrap_angle};
use simrun::map::{Cell, OccupancyGrid};
use simrun::math;
use simrun::observation::{Belief, SensedObstacle};
use simrun::plan::{global::GlobalChoice, local::LocalChoice, stack::Stack};
use simrun::rng::EpisodeSeed;
use simrun::robot::Robot;
use simrun::scenario::ScenarioFile;
use simrun::settings::quantity::{Fraction, NonNegative, Positive};
use simrun::world::{
    ActuationSpec, Change, Conditions, DT_S, Event, LidarSpec, LocalisationSpec, Mover, Scene, SensingSpec, Shape,
    StaticMap, UnknownStatic, World,
};
use std::sync::Arc;

const STAND: Twist = Twist { v: 0.0, omega: 0.0 };

fn hall(cols: i32, rows: i32) -> Scene {
    let map = Arc::new(StaticMap::new(OccupancyGrid::empty(cols, rows, 1.0)));
    Scene::new(&map, Pose::new(5.0, 5.0, 0.3), Vec2::new(18.0, 5.0))
}

/// A robot whose drive reaches any command at once.
fn nimble() -> Robot {
    Robot {
        reverse_speed_max_mps: 5.0,
        speed_max_mps: 5.0,
        acceleration_max_mps2: 1e3,
        deceleration_max_mps2: 1e3,
        yaw_rate_max_radps: 20.0,
        yaw_acceleration_max_radps2: 1e4,
        ..Robot::default()
    }
}

fn sense(world: &mut World<'_>, scene: &Scene) -> (Vec<SensedObstacle>, Belief) {
    let (mut sensed, mut belief) = (Vec::new(), Belief::new(&scene.map.grid, &scene.map.field));
    world.sense(&mut belief, &mut sensed);
    (sensed, belief)
}

/// Mean and standard deviation lie within five standard errors of what is stated: one test in a million fails by chance.
fn assert_normal(what: &str, draws: &[f64], mean: f64, deviation: f64) {
    let n = draws.len() as f64;
    let found = draws.iter().sum::<f64>() / n;
    let spread = (draws.iter().map(|x| (x - found) * (x - found)).sum::<f64>() / (n - 1.0)).sqrt();
    assert!((found - mean).abs() <= 5.0 * deviation / n.sqrt(), "{what}: mean {found}, stated {mean}");
    let standard_error = deviation / (2.0 * n).sqrt();
    assert!((spread - deviation).abs() <= 5.0 * standard_error, "{what}: deviation {spread}, stated {deviation}");
}

#[test]
fn what_is_sensed_has_the_stated_noise_and_misses() {
    let mut scene = hall(20, 10);
    scene.movers.push(Mover::new(Vec2::new(8.0, 6.0), Vec2::zeros(), 0.4));
    let sensing = SensingSpec {
        range_noise_m: NonNegative::new(0.05),
        bearing_noise_rad: NonNegative::new(0.02),
        velocity_noise_mps: NonNegative::new(0.1),
        miss_probability: Fraction::new(0.2),
        ..SensingSpec::default()
    };
    let conditions = Conditions { seed: EpisodeSeed { seed: 5, episode: 2 }, sensing, ..Conditions::default() };
    let robot = Robot::default();
    let mut world = World::new(&scene, &robot, &conditions);
    let ticks = 6000;
    // What is measured is the point of the surface that is nearest.
    let nearest = Vec2::new(3.0, 1.0) * (1.0 - 0.4 / 10f64.sqrt());
    let (mut ranges, mut bearings, mut velocities, mut missed) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for _ in 0..ticks {
        let (sensed, _) = sense(&mut world, &scene);
        match sensed.first() {
            Some(mover) => {
                let measured = nearest + (mover.position - scene.movers[0].position);
                ranges.push(measured.norm() - nearest.norm());
                bearings.push(wrap_angle(math::atan2(measured.y, measured.x) - math::atan2(nearest.y, nearest.x)));
                velocities.extend([mover.velocity.x, mover.velocity.y]);
            }
            None => missed += 1,
        }
        world.step(STAND);
    }
    assert_normal("range", &ranges, 0.0, 0.05);
    assert_normal("bearing", &bearings, 0.0, 0.02);
    assert_normal("velocity", &velocities, 0.0, 0.1);
    let share = f64::from(missed) / f64::from(ticks);
    assert!((share - 0.2).abs() < 5.0 * (0.2 * 0.8 / f64::from(ticks)).sqrt(), "{share}");
}

#[test]
fn an_obstacle_out_of_view_or_behind_another_is_not_sensed() {
    let sees = |sensing: &SensingSpec, movers: &[Vec2], walls: &[&str]| -> Vec<Vec2> {
        let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(walls, 1.0)));
        let mut scene = Scene::new(&map, Pose::new(0.5, 2.5, 0.0), Vec2::new(8.5, 2.5));
        scene.movers.extend(movers.iter().map(|&at| Mover::new(at, Vec2::zeros(), 0.2)));
        let conditions = Conditions { sensing: sensing.clone(), ..Conditions::default() };
        let robot = Robot::default();
        let mut world = World::new(&scene, &robot, &conditions);
        sense(&mut world, &scene).0.iter().map(|mover| mover.position).collect()
    };
    const OPEN: [&str; 5] = ["..........", "..........", "..........", "..........", ".........."];
    let wall = ["..........", "...#......", "...#......", "...#......", ".........."];
    let (ahead, behind_it, aside) = (Vec2::new(2.0, 2.5), Vec2::new(4.5, 2.5), Vec2::new(1.0, 4.5));
    let plain = SensingSpec::default();
    assert_eq!(sees(&plain, &[ahead, behind_it, aside], &wall).len(), 3);
    // A sector of a right angle: `aside` lies at atan(2 / 0.5), beyond π/4.
    let sector = SensingSpec { field_of_view_rad: Some(Positive::new(math::FRAC_PI_2)), ..SensingSpec::default() };
    assert_eq!(sees(&sector, &[ahead, behind_it, aside], &OPEN), [ahead, behind_it]);
    let sight = SensingSpec { occlusion: true, ..SensingSpec::default() };
    assert_eq!(sees(&sight, &[ahead, behind_it, aside], &OPEN), [ahead, aside], "one mover hides another");
    assert_eq!(sees(&sight, &[behind_it, aside], &OPEN), [behind_it, aside]);
    assert_eq!(sees(&sight, &[behind_it, aside], &wall), [aside], "a wall hides");
}

#[test]
fn the_believed_pose_drifts_and_shakes_as_stated() {
    let spec = LocalisationSpec {
        position_noise_m: NonNegative::new(0.03),
        heading_noise_rad: NonNegative::new(0.01),
        position_drift_m: NonNegative::new(0.02),
        heading_drift_rad: NonNegative::new(0.005),
    };
    let (scene, robot) = (hall(20, 10), Robot::default());
    let (mut early, mut late, mut heading) = (Vec::new(), Vec::new(), Vec::new());
    for episode in 0..1500 {
        let seed = EpisodeSeed { seed: 8, episode };
        let conditions = Conditions { seed, localisation: spec.clone(), ..Conditions::default() };
        let mut world = World::new(&scene, &robot, &conditions);
        let error = |world: &World<'_>| world.believed_pose().position - world.pose().position;
        early.extend(error(&world).iter());
        for _ in 0..90 {
            world.step(STAND);
        }
        sense(&mut world, &scene);
        late.extend(error(&world).iter());
        heading.push(wrap_angle(world.believed_pose().theta - world.pose().theta));
    }
    assert_normal("at first", &early, 0.0, 0.03);
    // Variances add: 9 s of drift.
    assert_normal("after 9 s", &late, 0.0, (0.03f64 * 0.03 + 9.0 * 0.02 * 0.02).sqrt());
    assert_normal("heading", &heading, 0.0, (0.01f64 * 0.01 + 9.0 * 0.005 * 0.005).sqrt());
}

#[test]
fn a_lost_robot_places_what_it_sees_as_seen_from_where_it_believes_to_be() {
    let mut scene = hall(20, 10);
    scene.movers.push(Mover::new(Vec2::new(8.0, 6.0), Vec2::new(0.0, 0.5), 0.4));
    scene.unknown_static.push(UnknownStatic::new(Pose::new(7.5, 3.5, 0.0), Shape::Disc { radius_m: 0.4 }));
    let localisation = LocalisationSpec {
        position_noise_m: NonNegative::new(0.5),
        heading_noise_rad: NonNegative::new(0.3),
        ..LocalisationSpec::default()
    };
    let conditions = Conditions { seed: EpisodeSeed { seed: 9, episode: 0 }, localisation, ..Conditions::default() };
    let robot = Robot::default();
    let mut world = World::new(&scene, &robot, &conditions);
    let (sensed, belief) = sense(&mut world, &scene);
    let (eye, believed) = (world.pose(), world.believed_pose());
    assert!((believed.position - eye.position).norm() > 0.1);
    // Distance and bearing are what they are; only the frame is wrong.
    let (there, placed) = (scene.movers[0].position, sensed[0].position);
    assert!(((there - eye.position).norm() - (placed - believed.position).norm()).abs() < 1e-12);
    assert!((eye.bearing_to(there) - believed.bearing_to(placed)).abs() < 1e-12);
    assert!((sensed[0].velocity.norm() - 0.5).abs() < 1e-12);
    let disc = scene.unknown_static[0].pose().position;
    let bearing = eye.bearing_to(disc) + believed.theta;
    let (sin, cos) = math::sin_cos(bearing);
    let expected = believed.position + (disc - eye.position).norm() * Vec2::new(cos, sin);
    assert!(belief.added().contains(&belief.grid().cell_at(expected)), "{expected:?} {:?}", belief.added());
}

#[test]
fn commands_arrive_after_the_latency() {
    let (scene, robot) = (hall(20, 10), nimble());
    let actuation: ActuationSpec = serde_yaml::from_str("latency_ticks: 3").unwrap();
    let conditions = Conditions { actuation, ..Conditions::default() };
    let mut world = World::new(&scene, &robot, &conditions);
    let mut driven = Vec::new();
    for tick in 0..8 {
        world.step(Twist { v: 0.1 * f64::from(tick + 1), omega: 0.0 });
        driven.push((world.twist().v * 10.0).round() as i32);
    }
    assert_eq!(driven, [0, 0, 0, 1, 2, 3, 4, 5]);
}

#[test]
fn noise_and_slip_part_the_ground_from_the_wheels_as_stated() {
    let (scene, robot) = (hall(2000, 2000), nimble());
    let start = Scene { start: Pose::new(1000.0, 1000.0, 0.0), ..scene };
    let actuation: ActuationSpec =
        serde_yaml::from_str("{speed_noise_share: 0.1, yaw_rate_noise_share: 0.2, slip_left: [0.1, 0.3]}").unwrap();
    let conditions = Conditions { seed: EpisodeSeed { seed: 3, episode: 1 }, actuation, ..Conditions::default() };
    let mut world = World::new(&start, &robot, &conditions);
    let (mut speed, mut yaw_rate) = (Vec::new(), Vec::new());
    for _ in 0..5000 {
        world.step(Twist { v: 1.0, omega: 0.5 });
        assert_eq!(world.odometry(), Twist { v: 1.0, omega: 0.5 });
        // The right wheel has grip: v + ω b/2 is its speed. With a straight command the left one would lose 0.2 on average.
        let Twist { v, omega } = world.twist();
        let right = v + 0.5 * robot.track_width_m * omega;
        let left = v - 0.5 * robot.track_width_m * omega;
        speed.push(right);
        yaw_rate.push(left);
    }
    // right = v' + b ω'/2 with v' ~ N(1, 0.1), ω' ~ N(0.5, 0.1), b/2 = 0.2.
    let deviation = (0.1f64 * 0.1 + (0.2f64 * 0.1) * (0.2 * 0.1)).sqrt();
    assert_normal("right wheel", &speed, 1.1, deviation);
    // left = (v' − b ω'/2) · k with k uniform in [0.7, 0.9]: mean 0.9 · 0.8, E[k²] = 0.8² + 0.2²/12.
    let second = (0.9f64 * 0.9 + deviation * deviation) * (0.64 + 0.04 / 12.0);
    let mean = yaw_rate.iter().sum::<f64>() / 5000.0;
    assert!((mean - 0.72).abs() < 5.0 * ((second - 0.72 * 0.72) / 5000.0).sqrt(), "{mean}");
}

#[test]
fn a_scan_measures_walls_and_movers_with_the_stated_noise() {
    let mut scene = hall(20, 10);
    scene.start = Pose::new(5.0, 5.0, 0.0);
    scene.movers.push(Mover::new(Vec2::new(8.0, 5.0), Vec2::zeros(), 0.5));
    let lidar: LidarSpec = serde_yaml::from_str("{rays: 4, range_m: 12}").unwrap();
    let run = |lidar: LidarSpec, ticks: usize| -> Vec<Vec<f64>> {
        let sensing = SensingSpec { lidar: Some(lidar), ..SensingSpec::default() };
        let conditions = Conditions { seed: EpisodeSeed { seed: 4, episode: 0 }, sensing, ..Conditions::default() };
        let robot = Robot::default();
        let mut world = World::new(&scene, &robot, &conditions);
        let scans = (0..ticks).map(|_| {
            sense(&mut world, &scene);
            let scan = world.scan().unwrap();
            assert!((scan.bearing_first_rad + 3.0 * math::PI / 4.0).abs() < 1e-12);
            assert!((scan.bearing_step_rad - math::FRAC_PI_2).abs() < 1e-12);
            let ranges = scan.ranges_m.to_vec();
            world.step(STAND);
            ranges
        });
        scans.collect()
    };
    // Rays at ±45° and ±135°: 5 m to the walls, times √2.
    let scan = &run(lidar.clone(), 1)[0];
    assert!(scan.iter().all(|range| (range - 5.0 * math::SQRT_2).abs() < 1e-9), "{scan:?}");
    let ahead =
        &run(LidarSpec { field_of_view_rad: Some(Positive::new(4.0 * math::FRAC_PI_2)), ..lidar.clone() }, 1)[0];
    assert_eq!(ahead, scan, "a field of view of the whole circle is the default");
    let short = LidarSpec { range_m: Positive::new(3.0), ..lidar.clone() };
    assert!(run(short, 1)[0].iter().all(|range| range.is_infinite()));
    let noisy =
        LidarSpec { range_noise_m: NonNegative::new(0.04), miss_probability: Fraction::new(0.1), ..lidar.clone() };
    let ranges: Vec<f64> = run(noisy, 2500).concat();
    let measured: Vec<f64> = ranges.iter().copied().filter(|range| range.is_finite()).collect();
    assert_normal("range", &measured, 5.0 * math::SQRT_2, 0.04);
    let share = 1.0 - measured.len() as f64 / ranges.len() as f64;
    assert!((share - 0.1).abs() < 5.0 * (0.09 / ranges.len() as f64).sqrt(), "{share}");
}

#[test]
fn one_kind_of_noise_does_not_move_another() {
    let mut scene = hall(20, 10);
    scene.movers.push(Mover::new(Vec2::new(8.0, 6.0), Vec2::zeros(), 0.4));
    let robot = Robot::default();
    let first = |sensing: SensingSpec, localisation: LocalisationSpec| {
        let seed = EpisodeSeed { seed: 5, episode: 2 };
        let conditions = Conditions { seed, sensing, localisation, ..Conditions::default() };
        let mut world = World::new(&scene, &robot, &conditions);
        sense(&mut world, &scene).0[0].velocity - Vec2::zeros()
    };
    let velocity = SensingSpec { velocity_noise_mps: NonNegative::new(0.1), ..SensingSpec::default() };
    let more = SensingSpec { range_noise_m: NonNegative::new(0.1), ..velocity.clone() };
    let lost = LocalisationSpec { position_noise_m: NonNegative::new(0.1), ..LocalisationSpec::default() };
    let alone = first(velocity.clone(), LocalisationSpec::default());
    assert_eq!(alone, first(more, LocalisationSpec::default()));
    assert!((alone - first(velocity, lost)).norm() < 1e-12);
}

#[test]
fn an_obstacle_of_the_script_appears_is_believed_vanishes_and_is_forgotten_when_seen_to_be_gone() {
    let mut scene = hall(20, 10);
    let crate_at = UnknownStatic::new(Pose::new(8.5, 5.5, 0.0), Shape::Rectangle { half_m: Vec2::new(0.5, 0.5) });
    scene.unknown_static.push(crate_at.with_presence(false));
    let event = |tick: u32, present| Event { at_s: f64::from(tick) * DT_S, change: Change::obstacle(0, present) };
    scene.script = vec![event(3, true), event(6, false)];
    let robot = Robot::default();
    let mut world = World::new(&scene, &robot, &Conditions::default());
    let mut belief = Belief::new(&scene.map.grid, &scene.map.field);
    let mut sensed = Vec::new();
    let (mut known, mut gaps) = (Vec::new(), Vec::new());
    for _ in 0..8 {
        world.sense(&mut belief, &mut sensed);
        known.push(!belief.grid().is_free(Cell { col: 8, row: 5 }));
        gaps.push(world.step(STAND).clearance_m < 4.0);
    }
    assert_eq!(known, [false, false, false, true, true, true, false, false]);
    assert_eq!(gaps, known, "the truth goes with it");
    assert_eq!((belief.revision(), belief.added().len(), world.seen_statics()), (2, 0, 0));
    assert_eq!(belief.field(), &*scene.map.field);
}

#[test]
fn an_obstacle_that_vanishes_out_of_range_stays_believed() {
    let mut scene = hall(20, 10);
    scene.start = Pose::new(5.0, 5.0, 0.0);
    let crate_at = UnknownStatic::new(Pose::new(8.5, 5.5, 0.0), Shape::Rectangle { half_m: Vec2::new(0.5, 0.5) });
    scene.unknown_static.push(crate_at);
    scene.script = vec![
        Event { at_s: 0.1, change: Change::sensor_range(1.0) },
        Event { at_s: 0.2, change: Change::obstacle(0, false) },
    ];
    let robot = nimble();
    let mut world = World::new(&scene, &robot, &Conditions::default());
    let mut belief = Belief::new(&scene.map.grid, &scene.map.field);
    let mut sensed = Vec::new();
    let mut freed_at = None;
    for _ in 0..40 {
        world.sense(&mut belief, &mut sensed);
        if freed_at.is_none() && belief.added().is_empty() {
            freed_at = Some(world.pose().position.x);
        }
        world.step(Twist { v: 1.0, omega: 0.0 });
    }
    // Its face was at x = 8 and the sensor reaches 1 m.
    assert!((freed_at.unwrap() - 7.0).abs() < 0.11, "{freed_at:?}");
}

#[test]
fn a_goal_that_moves_is_planned_for_whatever_the_rule() {
    let mut scene = hall(20, 10);
    let there = Vec2::new(3.0, 8.0);
    scene.script = vec![Event { at_s: 2.0, change: Change::goal(there) }];
    for global in ["a_star", "none"] {
        let global = (global != "none").then(|| GlobalChoice::by_name(global).unwrap().build());
        let mut stack = Stack::new(global, Vec::new(), LocalChoice::by_name("dwa").unwrap().build());
        let mut runner = Runner::default();
        let robot = Robot::default();
        let (conditions, termination) = (Conditions::default(), TerminationSpec::default());
        let setting =
            Setting { scene: &scene, robot: &robot, conditions: &conditions, termination: &termination, way_m: None };
        let outcome = runner.run(setting, &mut stack);
        assert_eq!(outcome, Outcome::Success);
        let trace = &runner.record.trace;
        assert!((trace.ticks.last().unwrap().pose.position - there).norm() <= 0.25);
        assert_eq!((trace.replans, trace.paths[1].tick), (1, 20));
    }
    assert!(!scene.has_a_fixed_task());
    assert_eq!((scene.goal_at(1.9), scene.goal_at(2.0)), (scene.goal, there));
}

#[test]
fn movers_do_what_the_script_says() {
    let mut scene = hall(20, 10);
    scene.movers.push(Mover::new(Vec2::new(12.0, 2.0), Vec2::new(0.5, 0.0), 0.3));
    let event = |tick: u32, change| Event { at_s: f64::from(tick) * DT_S, change };
    scene.script = vec![
        event(2, Change::halt(0, true)),
        event(4, Change::halt(0, false)),
        event(6, Change::velocity(0, Vec2::new(0.0, 1.0))),
        event(8, Change::mover(0, false)),
        event(10, Change::mover(0, true)),
    ];
    let robot = Robot::default();
    let mut world = World::new(&scene, &robot, &Conditions::default());
    let mut seen = Vec::new();
    for _ in 0..12 {
        world.step(STAND);
        let mover = &world.movers()[0];
        seen.push((
            mover.present,
            (mover.position.x * 100.0).round() as i32,
            (mover.position.y * 100.0).round() as i32,
        ));
    }
    let expected = [
        (true, 1205, 200),
        (true, 1210, 200),
        (true, 1210, 200),
        (true, 1210, 200),
        (true, 1215, 200),
        (true, 1220, 200),
        (true, 1220, 210),
        (true, 1220, 220),
        (false, 1220, 220),
        (false, 1220, 220),
        (true, 1220, 230),
        (true, 1220, 240),
    ];
    assert_eq!(seen, expected);
}

#[test]
fn a_mover_out_of_sight_is_remembered_until_its_place_is_seen_to_be_free() {
    // Its surface is 2.7 m away; it vanishes while the sensor reaches 1 m.
    let mut scene = hall(20, 10);
    scene.movers.push(Mover::new(Vec2::new(8.0, 5.0), Vec2::zeros(), 0.3));
    let event = |tick: u32, change| Event { at_s: f64::from(tick) * DT_S, change };
    scene.script = vec![
        event(2, Change::sensor_range(1.0)),
        event(4, Change::mover(0, false)),
        event(6, Change::sensor_range(2.6)),
        event(8, Change::sensor_range(2.8)),
        event(10, Change::mover(0, true)),
        event(12, Change::velocity(0, Vec2::new(5.0, 0.0))),
    ];
    let robot = Robot::default();
    let mut world = World::new(&scene, &robot, &Conditions::default());
    let mut seen = Vec::new();
    for _ in 0..14 {
        let sensed = sense(&mut world, &scene).0;
        assert!(world.remembered().iter().all(|mover| mover.id == 0 && mover.position == scene.movers[0].position));
        seen.push((sensed.len(), world.remembered().len()));
        world.step(STAND);
    }
    // At the end it leaves the sensor's range, which still reaches the place that it has left.
    let expected = [
        (1, 0),
        (1, 0),
        (0, 1),
        (0, 1),
        (0, 1),
        (0, 1),
        (0, 1),
        (0, 1),
        (0, 0),
        (0, 0),
        (1, 0),
        (1, 0),
        (1, 0),
        (0, 0),
    ];
    assert_eq!(seen, expected);
}

#[test]
fn wheels_slip_from_the_moment_that_the_script_says() {
    let mut scene = hall(20, 10);
    let lossy = [Fraction::new(0.5); 2];
    scene.script = vec![Event { at_s: 0.2, change: Change::wheel_slip(lossy, lossy) }];
    let robot = nimble();
    let mut world = World::new(&scene, &robot, &Conditions::default());
    let speeds: Vec<f64> = (0..4)
        .map(|_| {
            world.step(Twist { v: 1.0, omega: 0.0 });
            world.twist().v
        })
        .collect();
    assert_eq!(speeds, [1.0, 1.0, 0.5, 0.5]);
    assert!((world.pose().position - scene.start.position).norm() < 0.31);
    assert_ne!(scene.digest(), hall(20, 10).digest());
    assert_eq!(DT_S, 0.1);
}

#[test]
fn a_script_is_read_in_the_world_frame_and_its_faults_are_told() {
    let text = "map: {empty: {cols: 20, rows: 10, resolution_m: 1}}\nstart: [2, 5]\ngoal: [18, 5]\n\
                stacks: {global: [a_star], local: [dwa]}\n\
                obstacles: {moving: [{fixed: {position: [9, 2], velocity_mps: [0.5, 0]}}]}\n";
    let check = |script: &str| {
        let file = ScenarioFile::from_text("t.yaml", format!("{text}script:\n{script}"));
        let scenario = file.read(&[])?;
        scenario.check(std::path::Path::new("."))
    };
    let error = |script: &str| check(script).unwrap_err().to_string();
    assert!(error("  - {at_s: 1, event: {mover_stops: {mover: 1}}}").contains("there is no mover 1"));
    assert!(error("  - {at_s: 1, event: {mover_stop: {mover: 0}}}").contains("did you mean `mover_stops`"));
    assert!(error("  - {at_s: 1, event: {goal: {to: [30, 3]}}}").contains("outside the map"));
    let early = "  - {at_s: 5, event: {obstacle: {pose: [9, 5, 0], until_s: 4}}}";
    assert!(error(early).contains("it would vanish (4 s) before it appears (5 s)"));
}
