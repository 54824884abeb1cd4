use super::*;
use crate::geometry::Twist;
use crate::map::connectivity::reachable;
use crate::map::{Cell, DistanceField, Frame, OccupancyGrid};
use crate::rng::Purpose;
use crate::world::obstacles::ObstaclesSpec;
use crate::world::{Conditions, World};

pub(in crate::world) fn spec(start: &str, goal: &str, obstacles: &str) -> SceneSpec {
    SceneSpec {
        start: serde_yaml::from_str(start).unwrap(),
        goal: serde_yaml::from_str(goal).unwrap(),
        obstacles: serde_yaml::from_str::<ObstaclesSpec>(obstacles).unwrap(),
        script: Vec::new(),
    }
}

pub(in crate::world) fn seed(episode: u64) -> EpisodeSeed {
    EpisodeSeed { seed: 42, episode }
}

/// 30 by 30 cells of 1 m, a fifth of them occupied.
pub(in crate::world) fn random_map(episode: u64) -> Arc<StaticMap> {
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

pub(in crate::world) fn paper_scene(episode: u64) -> Result<Scene, Infeasible> {
    Scene::generate(&spec("random", "random", PAPER), &random_map(episode), &Robot::default(), seed(episode))
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
fn what_a_map_keeps_of_other_scenes_changes_none() {
    // Six clearances, more than are kept, in turn; beside each a map that nobody has used.
    let (used, plain) = (random_map(7), spec("random", "random", "{}"));
    let mut drawn = 0;
    for episode in 0..24 {
        let robot = Robot { radius_m: 0.05 + 0.2 * (episode % 6) as f64, ..Robot::default() };
        for spec in [&plain, &spec("random", "random", PAPER)] {
            let scene =
                |map: &Arc<StaticMap>| Scene::generate(spec, map, &robot, seed(episode)).map(|scene| scene.digest());
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
            let draw = |obstacles| Scene::generate(&spec("random", "random", obstacles), &map, &robot, seed(episode));
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
    let small = Scene::generate(&spec, &map, &Robot::default(), seed(1)).unwrap();
    let robot = Robot { radius_m: 0.4, ..Robot::default() };
    let large = Scene::generate(&spec, &map, &robot, seed(1)).unwrap();
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
    let scene = Scene::generate(&spec, &map, &Robot::default(), seed(0)).unwrap();
    let near = |a: Vec2, x: f64, y: f64| (a - Vec2::new(x, y)).norm() < 1e-12;
    assert!(near(scene.start.position, 1.0, 2.0) && scene.start.theta.abs() < 1e-12);
    assert!(near(scene.goal, 8.5, 3.5));
    assert!(near(scene.unknown_static[0].pose().position, 5.0, 2.5));
    assert!(near(scene.movers[0].position, 8.0, 4.0) && near(scene.movers[0].velocity, -1.0, 0.0));
    assert!(near(scene.movers[1].velocity, 0.0, -2.0));
    // A start without heading looks at the goal.
    let facing = SceneSpec { start: serde_yaml::from_str("[8, 1]").unwrap(), ..spec };
    let scene = Scene::generate(&facing, &map, &Robot::default(), seed(0)).unwrap();
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
        Scene::generate(spec, &map, &robot, seed(0)).unwrap_err().message
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
fn a_given_start_inside_the_margin_is_judged_by_the_footprint() {
    let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(&["#####", ".....", "#####"], 1.0)));
    let spec = spec("[0.5, 1.5]", "[4.5, 1.5]", "{}");
    // The lane leaves 0.5 m to both sides: enough for the robot, too little for its margin of 0.05 m.
    let robot = Robot { radius_m: 0.48, ..Robot::default() };
    assert!(Scene::generate(&spec, &map, &robot, seed(0)).is_ok());
    let drawn = SceneSpec { start: StartSpec::default(), goal: GoalSpec::default(), ..spec };
    assert!(Scene::generate(&drawn, &map, &robot, seed(0)).is_err(), "what is drawn keeps the margin");
}

/// The mover's states over `ticks` ticks of a world in which the robot stands.
pub(in crate::world) fn states(scene: &Scene, ticks: usize) -> Vec<Vec<Mover>> {
    let robot = Robot::default();
    let mut world = World::new(scene, &robot, &Conditions::default());
    let mut all = vec![world.movers().to_vec()];
    for _ in 0..ticks {
        assert_eq!(world.step(Twist::ZERO).contact, None);
        all.push(world.movers().to_vec());
    }
    all
}

pub(in crate::world) fn scene_of(obstacles: &str, episode: u64) -> Scene {
    let map = Arc::new(StaticMap::new(OccupancyGrid::empty(40, 30, 1.0)));
    Scene::generate(&spec("[1, 1]", "[38, 28]", obstacles), &map, &Robot::default(), seed(episode)).unwrap()
}
