//! Global planners against the published optima of the MovingAI benchmarks.
//!
//! Two small maps are shipped in `tests/data/movingai`; the others lie beside the repository (`../shared/benchmarks`), and
//! without them the output says which tests were skipped. The larger maps are asked every tenth query unless SIMRUN_FULL=1.

use super::support::{benchmarks, is_full, root};
use simrun::map::formats::movingai;
use simrun::map::{Cell, DistanceField, OccupancyGrid};
use simrun::plan::PlanningGrid;
use simrun::plan::contract::{GlobalPlanner, Problem};
use simrun::plan::global::GlobalChoice;
use std::fs;
use std::path::{Path, PathBuf};

fn shipped() -> PathBuf {
    root().join("tests/data/movingai")
}

fn read(file: &Path) -> String {
    fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()))
}

/// A query with its optimum and how far a correct answer may be from it, in cells.
struct Question {
    start: Cell,
    goal: Cell,
    optimum: f64,
    tolerance: f64,
}

/// The map and the questions of a scenario file; the map lies in the folder `maps`.
fn load(scen: &Path, maps: &Path) -> (OccupancyGrid, Vec<Question>) {
    let text = read(scen);
    let map_name = text.lines().nth(1).and_then(|line| line.split('\t').nth(1)).expect("a map column");
    let map = movingai::parse(&read(&maps.join(map_name.rsplit('/').next().expect("a name")))).expect("a valid map");
    let printed: Vec<&str> = text.lines().skip(1).filter_map(|line| line.split('\t').next_back()).collect();
    let queries = movingai::parse_queries(&text).expect("valid queries");
    assert_eq!(printed.len(), queries.len());
    let questions = queries.iter().zip(printed).map(|(query, printed)| Question {
        start: movingai::flip(&map, query.start),
        goal: movingai::flip(&map, query.goal),
        optimum: query.optimal_length,
        tolerance: tolerance(printed, query.optimal_length),
    });
    let questions = questions.collect();
    (map, questions)
}

/// Largest distance of a correct answer from the printed value.
///
/// The newer files have eight decimals of sums with √2 = 1.414213562, which is 3.8e-10 short per
/// diagonal step; the older ones have six significant digits of sums in single precision.
fn tolerance(printed: &str, length: f64) -> f64 {
    let decimals = printed.trim().split('.').nth(1).map_or(0, str::len);
    if decimals >= 8 {
        return 0.51e-8 + 3.8e-10 * length / std::f64::consts::SQRT_2;
    }
    let digits_before_the_point = format!("{}", length.trunc()).len() as i32;
    let unit = format!("1e{}", digits_before_the_point - 6).parse::<f64>().expect("a power of ten");
    0.6 * unit
}

/// Length of a path in cells: a straight step 1, a diagonal one √2, others their Euclidean length.
/// Whole steps are counted before they are added up.
fn length(path: &[Cell]) -> f64 {
    let (mut straight, mut diagonal, mut rest) = (0, 0, 0.0);
    for pair in path.windows(2) {
        match ((pair[1].col - pair[0].col).abs(), (pair[1].row - pair[0].row).abs()) {
            (0, n) | (n, 0) => straight += n,
            (m, n) if m == n => diagonal += n,
            (m, n) => rest += f64::from(m * m + n * n).sqrt(),
        }
    }
    f64::from(straight) + f64::from(diagonal) * std::f64::consts::SQRT_2 + rest
}

struct Planners {
    grid: PlanningGrid,
    path: Vec<Cell>,
}

impl Planners {
    fn on(map: &OccupancyGrid) -> Self {
        Self { grid: PlanningGrid::new(map, &DistanceField::new(map), 0.0), path: Vec::new() }
    }

    fn solve(&mut self, planner: &mut dyn GlobalPlanner, question: &Question) -> f64 {
        let problem = Problem { grid: &self.grid, start: question.start, goal: question.goal };
        assert_eq!(planner.as_grid().expect("cells").search(&problem, &mut self.path).result, Ok(()));
        length(&self.path)
    }
}

/// Asks `names` every `stride`-th question of a file; both sides of the optimum are wrong.
fn check_optima(folder: &Path, scen: &str, names: &[&str], stride: usize) {
    let (map, questions) = load(&folder.join(scen), folder);
    let mut planners = Planners::on(&map);
    let stride = if is_full() { 1 } else { stride };
    for name in names {
        let mut planner = GlobalChoice::by_name(name).expect("defaults").build();
        for question in questions.iter().step_by(stride) {
            let found = planners.solve(&mut *planner, question);
            let error = (found - question.optimum).abs();
            assert!(error <= question.tolerance, "{scen} {name}: {found}, published {}", question.optimum);
        }
    }
}

/// The planners that promise shortest paths.
fn exact() -> Vec<&'static str> {
    let planners = GlobalChoice::NAMES.iter().zip(GlobalChoice::ENTRIES);
    planners.filter(|(_, entry)| entry.exact).map(|(name, _)| *name).collect()
}

#[test]
fn the_planners_that_promise_shortest_paths_are_these() {
    // Written down a second time on purpose: a promise that is taken back must be taken back here.
    assert_eq!(
        exact(),
        ["dijkstra", "a_star", "jps", "improved_dijkstra", "lpa_star", "d_star", "d_star_lite", "ssa_star"]
    );
}

#[test]
fn the_shipped_maps_have_the_published_optima() {
    for scen in ["random-32-32-20-random-1.scen", "random-32-32-20-even-1.scen", "maze-32-32-4-random-1.scen"] {
        check_optima(&shipped(), scen, &exact(), 1);
    }
}

#[test]
fn small_maps_have_the_published_optima() {
    let Some(folder) = benchmarks("movingai") else { return };
    for scen in ["room-64-64-8-random-1.scen", "warehouse-10-20-10-2-1-random-1.scen", "arena.map.scen"] {
        check_optima(&folder, scen, &exact(), 1);
    }
}

#[test]
fn the_game_map_has_the_published_optima() {
    let Some(folder) = benchmarks("movingai") else { return };
    check_optima(&folder, "lak303d.map.scen", &exact(), 10);
}

#[test]
fn the_city_map_has_the_published_optima() {
    let Some(folder) = benchmarks("movingai") else { return };
    check_optima(&folder, "Berlin_0_256.map.scen", &exact(), 10);
}

#[test]
fn the_random_map_has_the_published_optima() {
    let Some(folder) = benchmarks("movingai") else { return };
    check_optima(&folder, "random512-20-0.map.scen", &exact(), 10);
}

#[test]
fn the_rooms_have_the_published_optima() {
    let Some(folder) = benchmarks("movingai") else { return };
    check_optima(&folder, "16room_000.map.scen", &exact(), 10);
}

#[test]
fn the_maze_has_the_published_optima() {
    let Some(folder) = benchmarks("movingai") else { return };
    check_optima(&folder, "maze512-8-0.map.scen", &exact(), 10);
}

/// Asks theta_star every question of a file of any-angle optima, which may touch obstacles; our sight may not: in narrow
/// places the paths differ by more than the planner.
#[expect(clippy::print_stdout, reason = "how near the paths come is a figure to report, not to assert")]
fn check_any_angle(folder: &Path, maps: &Path, name: &str) {
    let (map, questions) = load(&folder.join(format!("{name}.anyangle-centre.scen")), maps);
    let mut planners = Planners::on(&map);
    let mut planner = GlobalChoice::by_name("theta_star").expect("defaults").build();
    let (mut sum, mut worst, mut count) = (0.0, 1.0, 0.0);
    for question in &questions {
        let found = planners.solve(&mut *planner, question);
        assert!(found >= question.optimum - 1e-8, "{name}: {found}, optimum {}", question.optimum);
        let in_sight = |pair: &[Cell]| planners.grid.line_of_sight_cells(pair[0], pair[1]);
        assert!(planners.path.windows(2).all(in_sight), "{name}");
        if question.optimum > 0.0 {
            let ratio = found / question.optimum;
            sum += ratio;
            count += 1.0;
            worst = if ratio > worst { ratio } else { worst };
        }
    }
    println!("theta_star on {name}: length / any-angle optimum mean {:.5}, max {worst:.5}", sum / count);
}

#[test]
fn theta_star_paths_on_the_shipped_map_are_in_sight_and_never_shorter_than_the_any_angle_optimum() {
    check_any_angle(&shipped(), &shipped(), "random-32-32-20");
}

#[test]
fn theta_star_paths_are_in_sight_and_never_shorter_than_the_any_angle_optimum() {
    let Some(folder) = benchmarks("anyangle") else { return };
    let maps = folder.with_file_name("movingai");
    for name in ["arena", "room-64-64-8", "Berlin_0_256"] {
        check_any_angle(&folder, &maps, name);
    }
}
