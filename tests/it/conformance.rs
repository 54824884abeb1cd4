//! Promises of planners, tested on every planner of a registry: there is no second list of names.

use simrun::geometry::Pose;
use simrun::map::{Cell, DistanceField, OccupancyGrid};
use simrun::metrics::any_angle_m;
use simrun::observation::Belief;
use simrun::plan::PlanningGrid;
use simrun::plan::contract::{Failure, GlobalPlanner, Plan, Problem, Search, Situation, Task};
use simrun::plan::global::GlobalChoice;
use simrun::rng::{EpisodeSeed, Purpose};
use simrun::robot::Robot;

/// Start `S`, goal `G`, obstacles `#`; several start and goal are allowed to be absent.
fn problem(lines: &[&str]) -> (PlanningGrid, Cell, Cell) {
    let plain: Vec<String> = lines.iter().map(|line| line.replace(['S', 'G'], ".")).collect();
    let plain: Vec<&str> = plain.iter().map(String::as_str).collect();
    let map = OccupancyGrid::from_ascii(&plain, 0.5);
    let find = |letter| {
        let row = lines.iter().position(|line| line.contains(letter)).expect("drawn");
        let col = lines[row].find(letter).expect("drawn");
        Cell { col: col as i32, row: (lines.len() - 1 - row) as i32 }
    };
    (PlanningGrid::new(&map, &DistanceField::new(&map), 0.0), find('S'), find('G'))
}

const FREE: &[&str] = &[
    "..........", //
    ".S.....##.", //
    "...###....", //
    "....#...G.", //
    "..........", //
];

const BLOCKED: &[&str] = &[
    ".....#....", //
    ".S....#...", //
    ".....#....", //
    "....#...G.", //
    "....#.....", //
];

fn planners() -> impl Iterator<Item = (&'static str, Box<dyn GlobalPlanner>)> {
    GlobalChoice::NAMES.iter().map(|&name| {
        let choice = GlobalChoice::by_name(name).expect("every parameter has a default");
        assert_eq!(choice.name(), name);
        (name, choice.build())
    })
}

/// Asks a planner for cells; one that is more than a search of the grid is asked for a path between their centres.
fn plan(planner: &mut dyn GlobalPlanner, (grid, start, goal): &(PlanningGrid, Cell, Cell)) -> (Search, Vec<Cell>) {
    let mut path = vec![Cell { col: 1, row: 1 }; 3];
    if let Some(planner) = planner.as_grid() {
        let search = planner.search(&Problem { grid, start: *start, goal: *goal }, &mut path);
        return (search, path);
    }
    let (robot, belief) = (Robot::default(), Belief::from(&OccupancyGrid::empty(grid.cols(), grid.rows(), 0.5)));
    let (start, goal) = (grid.centre(*start), grid.centre(*goal));
    let situation = Situation::new(&robot, &belief, Pose { position: start, theta: 0.0 }, goal);
    let mut plan = Plan { cells: path, ..Plan::default() };
    let result = planner.plan(&Task { situation: &situation, grid, start, goal }, &mut plan);
    (Search { result, expanded: plan.effort.expanded, generated: plan.effort.generated }, plan.cells)
}

#[test]
fn every_global_planner_finds_a_free_path_from_start_to_goal() {
    let problem = problem(FREE);
    for (name, mut planner) in planners() {
        let (search, path) = plan(&mut *planner, &problem);
        assert_eq!(search.result, Ok(()), "{name}");
        assert_eq!((path[0], path[path.len() - 1]), (problem.1, problem.2), "{name}");
        assert!(search.expanded > 0 && search.generated > 0, "{name}: {search:?}");
        for pair in path.windows(2) {
            let step = ((pair[1].col - pair[0].col).abs(), (pair[1].row - pair[0].row).abs());
            let neighbours = step.0 <= 1 && step.1 <= 1;
            assert!(neighbours || problem.0.line_of_sight_cells(pair[0], pair[1]), "{name}: {pair:?}");
            assert!(step != (0, 0) && problem.0.is_passable(pair[1]), "{name}: {pair:?}");
        }
    }
}

#[test]
fn every_global_planner_says_that_no_path_exists() {
    let problem = problem(BLOCKED);
    for (name, mut planner) in planners() {
        let (search, path) = plan(&mut *planner, &problem);
        assert_eq!((search.result, path), (Err(Failure::NoPath), vec![]), "{name}");
    }
}

#[test]
fn every_global_planner_stays_where_start_and_goal_are_one_cell() {
    let (grid, start, _) = problem(FREE);
    for (name, mut planner) in planners() {
        let (search, path) = plan(&mut *planner, &(grid.clone(), start, start));
        assert_eq!((search.result, path), (Ok(()), vec![start]), "{name}");
    }
}

#[test]
fn every_global_planner_refuses_occupied_ends_and_ends_outside() {
    let (grid, start, goal) = problem(FREE);
    for blocked in [Cell { col: 4, row: 2 }, Cell { col: -1, row: 0 }, Cell { col: 0, row: -1 }].into_iter().chain([
        Cell { col: 10, row: 0 },
        Cell { col: 0, row: 5 },
        Cell { col: i32::MAX, row: i32::MIN },
    ]) {
        for (name, mut planner) in planners() {
            let (search, path) = plan(&mut *planner, &(grid.clone(), blocked, goal));
            assert_eq!((search.result, path), (Err(Failure::StartOccupied), vec![]), "{name} {blocked:?}");
            let (search, path) = plan(&mut *planner, &(grid.clone(), start, blocked));
            assert_eq!((search.result, path), (Err(Failure::GoalOccupied), vec![]), "{name} {blocked:?}");
            let (search, _) = plan(&mut *planner, &(grid.clone(), blocked, blocked));
            assert_eq!(search.result, Err(Failure::StartOccupied), "{name} {blocked:?}");
        }
    }
}

#[test]
fn every_global_planner_answers_the_same_twice_and_after_other_problems() {
    let (a, b) = (problem(FREE), problem(BLOCKED));
    let larger: Vec<String> = FREE.iter().map(|line| format!("{line}{}", ".".repeat(30))).collect();
    let larger: Vec<&str> = larger.iter().map(String::as_str).collect();
    let c = problem(&larger);
    for (name, mut planner) in planners() {
        let alone = |problem| {
            let fresh = GlobalChoice::by_name(name).expect("defaults").build();
            plan(&mut *{ fresh }, problem)
        };
        for problem in [&a, &a, &c, &b, &a, &c] {
            planner.reset();
            assert_eq!(plan(&mut *planner, problem), alone(problem), "{name}");
        }
    }
}

/// Straight and diagonal steps of a path of neighbours.
fn steps(path: &[Cell]) -> (usize, usize) {
    let straight = path.windows(2).filter(|pair| pair[0].col == pair[1].col || pair[0].row == pair[1].row).count();
    (straight, path.len() - 1 - straight)
}

#[test]
fn every_global_planner_finds_a_way_where_there_is_one_and_none_is_shorter_than_can_be() {
    let mut stream = EpisodeSeed { seed: 1, episode: 0 }.stream(Purpose::Map, 0);
    let mut planners: Vec<_> = planners().collect();
    let mut found = 0;
    for _ in 0..1000 {
        let (cols, rows) = (1 + stream.index(20) as i32, 1 + stream.index(20) as i32);
        let mut map = OccupancyGrid::empty(cols, rows, 0.5);
        let share = stream.range(0.0, 0.45);
        for index in 0..map.occupied().len() {
            if stream.uniform() < share {
                map.set_occupied(map.cell(index));
            }
        }
        let mut cell = || map.cell(stream.index(map.occupied().len()));
        let problem = (PlanningGrid::new(&map, &DistanceField::new(&map), 0.0), cell(), cell());
        let (grid, start, goal) = &problem;
        let optimum_m = any_angle_m(&map, map.centre(*start), map.centre(*goal));
        let mut reference = None;
        for (name, planner) in &mut planners {
            planner.reset();
            let (search, path) = plan(&mut **planner, &problem);
            let (result, shortest) = reference.get_or_insert((search.result.clone(), path.clone()));
            assert_eq!(search.result, *result, "{name}");
            if result.is_err() {
                continue;
            }
            found += 1;
            assert_eq!((path[0], path[path.len() - 1]), (*start, *goal), "{name}");
            assert!(path.windows(2).all(|pair| pair[0] != pair[1]), "{name}");
            assert!(path.windows(2).all(|pair| grid.line_of_sight_cells(pair[0], pair[1])), "{name}: {path:?}");
            let length_m: f64 = path.windows(2).map(|pair| (grid.centre(pair[0]) - grid.centre(pair[1])).norm()).sum();
            assert!(length_m >= optimum_m.expect("a way exists") - 1e-9, "{name}: {length_m}, {optimum_m:?}");
            if GlobalChoice::by_name(name).expect("defaults").entry().exact {
                assert_eq!(steps(&path), steps(shortest), "{name}: as long as dijkstra's, to the step");
            }
        }
    }
    assert!(found > 2000, "{found}");
}

#[test]
fn every_global_planner_has_a_name_of_its_own_a_summary_and_a_source() {
    assert_eq!(GlobalChoice::ENTRIES.len(), GlobalChoice::NAMES.len());
    for (at, (name, entry)) in GlobalChoice::NAMES.iter().zip(GlobalChoice::ENTRIES).enumerate() {
        assert!(!GlobalChoice::NAMES[..at].contains(name), "{name} twice");
        assert!(entry.summary.ends_with('.') && !entry.source.is_empty(), "{name}");
    }
}
