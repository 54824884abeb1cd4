use super::*;
use crate::geometry::outline::Shape;
use crate::geometry::{Twist, direction};
use crate::map::connectivity::reachable;
use crate::map::{Cell, DistanceField, Frame, OccupancyGrid};
use crate::rng::Purpose;
use crate::world::obstacles::ObstaclesSpec;
use crate::world::obstacles::moving::{MovingChoice, recording::Recording};
use crate::world::{Conditions, World};

fn spec(start: &str, goal: &str, obstacles: &str) -> SceneSpec {
    SceneSpec {
        start: serde_yaml::from_str(start).unwrap(),
        goal: serde_yaml::from_str(goal).unwrap(),
        obstacles: serde_yaml::from_str::<ObstaclesSpec>(obstacles).unwrap(),
        script: Vec::new(),
    }
}

/// What the one mover of a specification plays.
fn set_recording(spec: &mut SceneSpec, recording: Arc<Recording>) {
    let [MovingChoice::replay(params)] = spec.obstacles.moving.as_mut_slice() else { panic!("{spec:?}") };
    params.recording = Some(recording);
}

fn seed(episode: u64) -> EpisodeSeed {
    EpisodeSeed { seed: 42, episode }
}

/// 30 by 30 cells of 1 m, a fifth of them occupied.
fn random_map(episode: u64) -> Arc<StaticMap> {
    let mut stream = seed(episode).stream(Purpose::Map, 0);
    let mut grid = OccupancyGrid::empty(30, 30, 1.0);
    for index in 0..900 {
        if stream.uniform() < 0.2 {
            grid.set_occupied(grid.cell(index));
        }
    }
    Arc::new(StaticMap::new(grid))
}

const PAPER: &str = "
unknown_static:
  - random: {count: 1, placement: on_route, snap_to_cells: true, apart_from_obstacles: true, keep_from_ends_m: 0.5}
  - random: {count: 2, placement: {near_route: {distance_max_m: 3}}, shape: {rectangle: {size_m: [0.4, 0.7]}}}
  - random: {count: 2, shape: {disc: {radius_m: 0.3}}}
moving:
  - random: {count: 4, speed_mps: [0.8, 1.0]}
";

fn paper_scene(episode: u64) -> Result<Scene, Infeasible> {
    Scene::generate(&spec("random", "random", PAPER), &random_map(episode), &Robot::default(), 0.3, seed(episode))
}

#[test]
fn every_scene_is_feasible_and_as_specified() {
    let robot = Robot::default();
    let mut scenes = 0;
    for episode in 0..300 {
        let Ok(scene) = paper_scene(episode) else { continue };
        scenes += 1;
        let grid = &scene.map.grid;
        assert!((scene.start.position - scene.goal).norm() >= 0.5 * grid.extent_m().norm() - 1e-9);
        let towards = scene.start.bearing_to(scene.goal);
        assert!(towards.abs() < 1e-12, "the start heading points at the goal, not {towards} aside");
        assert_eq!((scene.unknown_static.len(), scene.movers.len()), (5, 4));

        // The true map, put together anew: start and goal connected for the disc of the clearance.
        let mut truth = OccupancyGrid::clone(grid);
        for obstacle in &scene.unknown_static {
            for index in 0..grid.occupied().len() {
                let cell = grid.cell(index);
                if obstacle.touches(grid.square(cell)) {
                    assert!(truth.is_free(cell), "unknown statics lie on free cells, apart from each other");
                    truth.set_occupied(cell);
                }
            }
            for end in [scene.start.position, scene.goal] {
                assert!(obstacle.distance_m(end) >= robot.radius_m);
            }
        }
        let reached = reachable(&truth, &DistanceField::new(&truth), grid.cell_at(scene.start.position), 0.3);
        assert!(reached[grid.index(grid.cell_at(scene.goal))], "episode {episode}");

        let route = scene.reference_route.as_ref().expect("wanted");
        let on_route = &scene.unknown_static[0];
        let cell = grid.cell_at(on_route.pose().position);
        assert_eq!(on_route.pose(), Pose { position: grid.centre(cell), theta: 0.0 });
        // Snapping moves a point of the route by up to half a diagonal.
        assert!(route.project(on_route.pose().position).1 <= 0.71);
        for row in cell.row - 1..=cell.row + 1 {
            for col in cell.col - 1..=cell.col + 1 {
                assert!(grid.is_free(Cell { col, row }), "apart from obstacles");
            }
        }
        for near in &scene.unknown_static[1..3] {
            assert!(route.project(near.pose().position).1 <= 3.0);
        }
        for mover in &scene.movers {
            assert!(scene.statics().distance_m(mover.position) >= mover.radius_m());
            assert!((mover.position - scene.start.position).norm() >= 3.0 + 0.25 + 0.3);
            assert!((0.8..1.0 + 1e-12).contains(&mover.velocity.norm()));
        }
    }
    assert!(scenes > 250, "{scenes}");
}

#[test]
fn random_movers_never_enter_statics_while_driving() {
    for episode in 0..60 {
        let Ok(scene) = paper_scene(episode) else { continue };
        let robot = Robot::default();
        let mut world = World::new(&scene, &robot, &Conditions::default());
        for _ in 0..100 {
            world.step(Twist::ZERO);
            for (mover, begin) in world.movers().iter().zip(&scene.movers) {
                assert!(scene.statics().distance_m(mover.position) > mover.radius_m() - 1e-8);
                assert!((mover.velocity.norm() - begin.velocity.norm()).abs() < 1e-9 || mover.velocity.norm() == 0.0);
            }
        }
    }
}

#[test]
fn what_a_map_keeps_of_other_scenes_changes_none() {
    // Six clearances, more than are kept, in turn; beside each a map that nobody has used.
    let (used, plain) = (random_map(7), spec("random", "random", "{}"));
    let mut drawn = 0;
    for episode in 0..24 {
        let inflation_m = 0.2 * (episode % 6) as f64;
        for spec in [&plain, &spec("random", "random", PAPER)] {
            let scene = |map: &Arc<StaticMap>| {
                Scene::generate(spec, map, &Robot::default(), inflation_m, seed(episode)).map(|scene| scene.digest())
            };
            let (ours, fresh) = (scene(&used), scene(&random_map(7)));
            assert_eq!(ours, fresh, "episode {episode}");
            drawn += u32::from(ours.is_ok());
        }
    }
    assert!(drawn > 20, "{drawn}");
}

#[test]
fn one_seed_is_one_scene_and_another_seed_another() {
    for episode in 0..20 {
        let (Ok(a), Ok(b)) = (paper_scene(episode), paper_scene(episode)) else { continue };
        assert_eq!(a.digest(), b.digest());
        assert_eq!((a.start, a.goal, &a.unknown_static, &a.movers), (b.start, b.goal, &b.unknown_static, &b.movers));
        assert_eq!(a.reference_route, b.reference_route);
        if let Ok(other) = paper_scene(episode + 1000) {
            assert_ne!(a.digest(), other.digest());
        }
    }
}

#[test]
fn adding_obstacles_leaves_the_others_bits_unchanged() {
    let robot = Robot::default();
    let base = "{unknown_static: [random: {count: 2}], moving: [random: {count: 2}, random]}";
    for (more, statics, movers) in [
        ("{unknown_static: [random: {count: 3}], moving: [random: {count: 2}, random]}", vec![0, 1], vec![]),
        ("{unknown_static: [random: {count: 2}], moving: [random: {count: 3}, random]}", vec![0, 1], vec![0, 1, 3]),
        (
            "{unknown_static: [random: {count: 2}], moving: [random: {count: 2}, random, random]}",
            vec![0, 1],
            vec![0, 1, 2],
        ),
    ] {
        for episode in 0..30 {
            let map = random_map(episode);
            let draw =
                |obstacles| Scene::generate(&spec("random", "random", obstacles), &map, &robot, 0.25, seed(episode));
            let (Ok(before), Ok(after)) = (draw(base), draw(more)) else { continue };
            assert_eq!((before.start, before.goal), (after.start, after.goal));
            let kept: Vec<_> = statics.iter().map(|&k: &usize| after.unknown_static[k].clone()).collect();
            assert_eq!(kept, before.unknown_static);
            let kept: Vec<_> = movers.iter().map(|&k: &usize| after.movers[k].clone()).collect();
            assert_eq!(kept, before.movers[..kept.len()]);
            assert_ne!(before.digest(), after.digest());
        }
    }
}

#[test]
fn the_order_of_obstacles_in_a_scene_does_not_depend_on_the_robot() {
    // Another robot, another scenario: but streams are addressed by purpose, so the movers' velocities are the same.
    let map = random_map(1);
    let spec = spec("random", "random", "{moving: [random: {count: 5}]}");
    let small = Scene::generate(&spec, &map, &Robot::default(), 0.25, seed(1)).unwrap();
    let robot = Robot { radius_m: 0.4, ..Robot::default() };
    let large = Scene::generate(&spec, &map, &robot, 0.4, seed(1)).unwrap();
    for (a, b) in small.movers.iter().zip(&large.movers) {
        assert_eq!(a.velocity, b.velocity);
    }
}

#[test]
fn given_places_are_in_the_world_frame_and_kept() {
    // The map turned by a quarter and moved: grid x runs along world y.
    let frame = Frame { origin: Pose::new(10.0, 0.0, math::FRAC_PI_2) };
    let map = Arc::new(StaticMap::new(OccupancyGrid::empty(10, 6, 1.0).with_frame(frame)));
    let obstacles = "
unknown_static: [fixed: {pose: [7.5, 5.0, 0], shape: {disc: {radius_m: 0.2}}}]
moving:
  - fixed: {position: [6, 8], velocity_mps: [0, -1]}
  - fixed: {position: [6, 8], speed_mps: 2, heading_rad: 0, radius_m: 0.2, on_static: stop}
";
    let spec = spec("[8, 1, 1.5707963267948966]", "cell: [8, 3]", obstacles);
    let scene = Scene::generate(&spec, &map, &Robot::default(), 0.25, seed(0)).unwrap();
    let near = |a: Vec2, x: f64, y: f64| (a - Vec2::new(x, y)).norm() < 1e-12;
    assert!(near(scene.start.position, 1.0, 2.0) && scene.start.theta.abs() < 1e-12);
    assert!(near(scene.goal, 8.5, 3.5));
    assert!(near(scene.unknown_static[0].pose().position, 5.0, 2.5));
    assert!(near(scene.movers[0].position, 8.0, 4.0) && near(scene.movers[0].velocity, -1.0, 0.0));
    assert!(near(scene.movers[1].velocity, 0.0, -2.0));
    // A start without heading looks at the goal.
    let facing = SceneSpec { start: serde_yaml::from_str("[8, 1]").unwrap(), ..spec };
    let scene = Scene::generate(&facing, &map, &Robot::default(), 0.25, seed(0)).unwrap();
    assert!((scene.start.theta - math::atan2(1.5, 7.5)).abs() < 1e-12);
}

#[test]
fn what_cannot_be_is_refused_with_key_cell_and_cause() {
    let map = StaticMap::new(OccupancyGrid::from_ascii(&[".....", "..#..", "....."], 1.0));
    let robot = Robot::default();
    for (start, goal, obstacles, key, parts) in [
        ("[2.5, 1.5]", "random", "{}", "start", vec!["cell [2, 1]", "lies inside a known obstacle"]),
        ("[2.5, 0.8]", "random", "{}", "start", vec!["[2.500, 0.800]", "radius 0.25 m", "0.200 m to a known"]),
        ("[0.1, 0.5]", "random", "{}", "start", vec!["0.100 m to the map's edge"]),
        ("random", "[7, 1]", "{}", "goal", vec!["cell [7, 1]", "outside the map of 5 by 3 cells"]),
        ("random", "cell: [5, 0]", "{}", "goal", vec!["outside the map"]),
        (
            "[0.5, 0.5]",
            "random",
            "{unknown_static: [random, fixed: {pose: [1, 0.5, 0], shape: {disc: {radius_m: 0.3}}}]}",
            "start",
            vec!["unknown static number 0"],
        ),
        (
            "random",
            "random",
            "{unknown_static: [random, fixed: {pose: [9, 9, 0]}]}",
            "obstacles.unknown_static[1].fixed.pose",
            vec!["outside the map"],
        ),
        (
            "random",
            "random",
            "{moving: [fixed: {position: [2.5, 1.5], velocity_mps: [1, 0]}]}",
            "obstacles.moving[0].fixed.position",
            vec!["cell [2, 1]", "overlaps a static obstacle or the map's edge by 0.800 m"],
        ),
        (
            "[0.5, 0.5]",
            "random",
            "{moving: [fixed: {position: [0.9, 0.5], velocity_mps: [1, 0]}]}",
            "obstacles.moving[0].fixed.position",
            vec!["overlaps the robot"],
        ),
        (
            "random",
            "random",
            "{moving: [fixed: {position: [0.5, 0.5], velocity_mps: [1, 0], speed_mps: 1}]}",
            "obstacles.moving[0].fixed",
            vec!["either `velocity_mps`, or `speed_mps` with `heading_rad`"],
        ),
        (
            "random",
            "random",
            "{moving: [random: {speed_mps: [1, 0.5]}]}",
            "obstacles.moving[0].random.speed_mps",
            vec!["found [1, 0.5]"],
        ),
    ] {
        let error = spec(start, goal, obstacles).check(&map, &robot).unwrap_err();
        assert_eq!(error.key, key, "{error}");
        for part in parts {
            assert!(error.message.contains(part), "{part}: {error}");
        }
    }
    assert_eq!(spec("[0.5, 0.5]", "[4.5, 2.5]", "{}").check(&map, &robot), Ok(()));
}

#[test]
fn a_world_that_cannot_be_is_infeasible_and_says_what() {
    let robot = Robot::default();
    let generate = |lines: &[&str], spec: &SceneSpec| {
        let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(lines, 1.0)));
        Scene::generate(spec, &map, &robot, 0.25, seed(0)).unwrap_err().message
    };
    let walled = ["..#..", "..#..", "..#.."];
    assert!(generate(&walled, &spec("[0.5, 0.5]", "[4.5, 0.5]", "{}")).contains("not connected"));
    assert!(generate(&walled, &spec("random", "random", "{}")).contains("at least 2.915 m apart"));
    assert!(generate(&["###"], &spec("random", "random", "{}")).contains("no free cell"));
    // The only way is one cell wide: an obstacle on it would close it.
    let lane = ["#######", ".......", "#######"];
    let plug = spec("[0.5, 1.5]", "[6.5, 1.5]", "{unknown_static: [random: {snap_to_cells: true}]}");
    assert!(generate(&lane, &plug).contains("number 0 of obstacles.unknown_static[0]"));
    let crowd = spec("[0.5, 1.5]", "[6.5, 1.5]", "{moving: [random: {radius_m: 0.6}]}");
    assert!(generate(&lane, &crowd).contains("number 0 of obstacles.moving[0]"));
}

#[test]
fn a_given_start_inside_the_inflated_zone_is_judged_by_the_footprint() {
    let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(&["#####", ".....", "#####"], 1.0)));
    let spec = spec("[0.5, 1.5]", "[4.5, 1.5]", "{}");
    // The lane leaves 0.5 m to both sides: too little for 0.8 m of inflation, enough for the robot.
    assert!(Scene::generate(&spec, &map, &Robot::default(), 0.8, seed(0)).is_ok());
}

#[test]
fn movers_of_an_aisle_set_out_along_it() {
    // An aisle along x below, one along y on the right: each two cells wide and longer than wide.
    let rows = ["########..", "########..", "########..", "########..", "..........", ".........."];
    let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(&rows, 1.0)));
    let spec =
        spec("[0.5, 0.5]", "[1.5, 0.5]", "{moving: [random: {count: 4, heading: along_aisle, keep_from_start_m: 0}]}");
    let (mut along_x, mut along_y) = (0, 0);
    for episode in 0..200 {
        for mover in Scene::generate(&spec, &map, &Robot::default(), 0.25, seed(episode)).unwrap().movers {
            let (x, v) = (mover.position.x, mover.velocity);
            assert!(v.x == 0.0 || v.y == 0.0, "{v:?}");
            if x < 8.0 {
                assert!(v.x != 0.0, "{mover:?}");
                along_x += i32::from(v.x > 0.0);
            } else if mover.position.y > 2.0 {
                assert!(v.y != 0.0, "{mover:?}");
                along_y += i32::from(v.y > 0.0);
            }
        }
    }
    assert!(along_x > 50 && along_y > 50, "either way: {along_x} {along_y}");
}

/// The mover's states over `ticks` ticks of a world in which the robot stands.
fn states(scene: &Scene, ticks: usize) -> Vec<Vec<Mover>> {
    let robot = Robot::default();
    let mut world = World::new(scene, &robot, &Conditions::default());
    let mut all = vec![world.movers().to_vec()];
    for _ in 0..ticks {
        assert_eq!(world.step(Twist::ZERO).contact, None);
        all.push(world.movers().to_vec());
    }
    all
}

fn scene_of(obstacles: &str, episode: u64) -> Scene {
    let map = Arc::new(StaticMap::new(OccupancyGrid::empty(40, 30, 1.0)));
    Scene::generate(&spec("[1, 1]", "[38, 28]", obstacles), &map, &Robot::default(), 0.3, seed(episode)).unwrap()
}

#[test]
fn an_irregular_mover_changes_course_as_often_and_as_much_as_it_says() {
    let text = "moving: [random: {speed_mps: [0.8, 1.0], motion: {irregular: {interval_s: [1, 3]}}, on_static: pass}]";
    let (mut changes_s, mut headings, mut speeds) = (Vec::new(), Vec::new(), Vec::new());
    for episode in 0..40 {
        let states = states(&scene_of(text, episode), 600);
        let mut last = 0;
        for tick in 1..states.len() {
            let (before, after) = (states[tick - 1][0].velocity, states[tick][0].velocity);
            if before != after {
                changes_s.push((tick - last) as f64 * 0.1);
                last = tick;
                headings.push(math::atan2(after.y, after.x));
                speeds.push(after.norm());
            }
            let moved = states[tick][0].position - states[tick - 1][0].position;
            assert!((moved - after * 0.1).norm() < 1e-9, "straight within a tick");
        }
    }
    let n = changes_s.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    assert!(n > 1000.0, "{n}");
    // Uniform on [1, 3]: mean 2, sd 0.577; four standard errors. The first interval of an episode counts from tick 1.
    assert!((mean(&changes_s) - 2.0).abs() < 4.0 * 0.577 / n.sqrt(), "{}", mean(&changes_s));
    assert!(changes_s.iter().all(|s| (0.95..=3.15).contains(s)));
    assert!((mean(&speeds) - 0.9).abs() < 4.0 * 0.058 / n.sqrt() && speeds.iter().all(|s| (0.8..=1.0).contains(s)));
    let turn: Vec2 = headings.iter().map(|&heading| direction(heading)).sum::<Vec2>() / n;
    // The mean direction of n uniform headings is about 1/√n long.
    assert!(turn.norm() < 3.0 / n.sqrt(), "{turn:?}");
}

#[test]
fn a_crossing_mover_is_on_the_route_when_the_robot_may_be() {
    let text = "moving: [crossing: {robot_speed_mps: 0.5, jitter_s: 2, straight_s: 0}]";
    for episode in 0..30 {
        let map = random_map(episode);
        let spec = spec("random", "random", text);
        let Ok(scene) = Scene::generate(&spec, &map, &Robot::default(), 0.3, seed(episode)) else { continue };
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
    let there_and_back = "moving: [patrol: {waypoints: [[10, 10], [14, 10], [14, 13]], speed_mps: 0.5, closed: false}]";
    let states = self::states(&scene_of(there_and_back, 0), 281);
    assert!((states[140][0].position - Vec2::new(14.0, 13.0)).norm() < 1e-6, "7 m after 14 s");
    assert!((states[200][0].position - Vec2::new(14.0, 10.0)).norm() < 1e-6);
    assert!((states[280][0].position - Vec2::new(10.0, 10.0)).norm() < 1e-6);
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

#[test]
fn a_recorded_mover_is_at_the_recorded_place_and_gone_outside_of_its_time() {
    let csv = b"time_s,id,x_m,y_m\n1.0,4,10,10\n1.4,4,10.4,10\n1.85,4,10.4,10.9\n3.0,4,10.4,13.2\n";
    let recording = Arc::new(Recording::parse(csv, 25.0).unwrap());
    let obstacles = "moving: [replay: {file: unused.csv, from_s: 0.5}]";
    let mut spec = spec("[1, 1]", "[38, 28]", obstacles);
    set_recording(&mut spec, recording);
    let map = Arc::new(StaticMap::new(OccupancyGrid::empty(40, 30, 1.0)));
    let scene = Scene::generate(&spec, &map, &Robot::default(), 0.3, seed(0)).unwrap();
    let states = states(&scene, 40);
    for (tick, state) in states.iter().enumerate() {
        let t = tick as f64 * 0.1 + 0.5;
        // The row of a tick shows the end of the tick: the first one driven begins at 1.0 s, the last one ends at 3.0 s.
        assert_eq!(state[0].present, t > 1.05 && t < 3.05, "at {t}");
        if state[0].present {
            let expected =
                if t < 1.4 { Vec2::new(10.0 + (t - 1.0), 10.0) } else { Vec2::new(10.4, 10.0 + 2.0 * (t - 1.4)) };
            assert!((state[0].position - expected).norm() < 1e-6, "at {t}: {:?} {expected:?}", state[0].position);
        }
    }
}

#[test]
fn a_mover_that_appears_upon_the_robot_is_a_collision_at_that_moment() {
    let csv = b"time_s,id,x_m,y_m\n1.0,4,1.2,1\n9.0,4,1.2,1\n";
    let mut spec = spec("[1, 1]", "[38, 28]", "moving: [replay: {file: unused.csv}]");
    set_recording(&mut spec, Arc::new(Recording::parse(csv, 25.0).unwrap()));
    let map = Arc::new(StaticMap::new(OccupancyGrid::empty(40, 30, 1.0)));
    let scene = Scene::generate(&spec, &map, &Robot::default(), 0.3, seed(0)).unwrap();
    let robot = Robot::default();
    let mut world = World::new(&scene, &robot, &Conditions::default());
    let hit = (0..20).find_map(|tick| world.step(Twist::ZERO).contact.map(|contact| (tick, contact.time_s)));
    assert_eq!(hit, Some((10, 0.0)));
}
