//! Searches on grids: `a_star` against the crate `pathfinding`, the other planners against `a_star`, and growth.

use crate::measure::{self, Spread};
use crate::scenes::{self, GridScene};
use crate::{Line, Row, Settings, Target};
use pathfinding::directed::astar::astar;
use simrun::map::connectivity::{self, Components};
use simrun::map::{Cell, DistanceField, OccupancyGrid};
use simrun::plan::PlanningGrid;
use simrun::plan::contract::{GlobalPlanner, Problem};
use simrun::plan::global::GlobalChoice;
use std::f64::consts::SQRT_2;
use std::fs;
use std::process::Command;

/// The rows of this module.
pub const ROWS: &[Row] = &[
    Row {
        name: "a_star",
        what: "A* without cutting corners, per query, against pathfinding's astar with the same exact costs",
        target: Some(Target::AtMost(0.25)),
        measure: a_star,
    },
    Row {
        name: "jps",
        what: "jump point search, per query, against a_star (random maps are not part of the target)",
        target: Some(Target::AtMost(0.5)),
        measure: |settings| against_a_star(settings, "jps", true),
    },
    Row {
        name: "theta_star",
        what: "any-angle search, per query, against a_star",
        target: Some(Target::AtMost(5.0)),
        measure: |settings| against_a_star(settings, "theta_star", false),
    },
    Row {
        name: "imp_a_star",
        what: "the paper's A*, per query, against a_star",
        target: Some(Target::AtMost(1.5)),
        measure: |settings| against_a_star(settings, "imp_a_star", false),
    },
    Row {
        name: "lpa_star_repair",
        what: "repair after a change on the path near the robot, against a search from scratch: its own, then a_star's",
        target: Some(Target::AtMost(0.2)),
        measure: repair,
    },
    Row {
        name: "grid_growth",
        what: "a_star on random maps of 128^2 to 4096^2 cells: ns per expansion; memory of map, field and search",
        target: None,
        measure: growth,
    },
    Row {
        name: "distance_field",
        what: "exact distance field of the same maps, ns a cell",
        target: None,
        measure: distance_field,
    },
];

/// Queries per map: spread over the whole set, so that a row takes seconds.
const QUERIES: usize = 60;

/// Answers all queries once, as the timed part of most rows does; for counting instructions.
pub fn once(planner: &str) -> Result<String, String> {
    let choice = GlobalChoice::by_name(planner).map_err(|error| error.to_string())?;
    let mut lines = Vec::new();
    for scene in scenes::random_grids()? {
        let problems = scene.problems(QUERIES);
        let (_, expanded, generated) = answers(&mut *choice.build(), &problems);
        lines.push(format!("{}: {} queries, {expanded} expanded, {generated} generated", scene.name, problems.len()));
    }
    Ok(lines.join("\n"))
}

fn planner(name: &str) -> Box<dyn GlobalPlanner> {
    GlobalChoice::by_name(name).expect("a planner of the registry").build()
}

/// Straight and diagonal steps of a path; `None` without a path.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Length {
    straight: u32,
    diagonal: u32,
}

impl Length {
    fn of(path: &[Cell]) -> Option<Self> {
        let mut length = Self { straight: 0, diagonal: 0 };
        for step in path.windows(2) {
            if step[0].col != step[1].col && step[0].row != step[1].row {
                length.diagonal += 1;
            } else {
                length.straight += 1;
            }
        }
        (!path.is_empty()).then_some(length)
    }
}

/// Lengths of all paths, nodes expanded and generated.
fn answers(planner: &mut dyn GlobalPlanner, problems: &[Problem<'_>]) -> (Vec<Option<Length>>, u64, u64) {
    let mut path = Vec::new();
    let (mut expanded, mut generated) = (0, 0);
    let lengths = problems.iter().map(|problem| {
        let search = planner.as_grid().expect("cells").search(problem, &mut path);
        expanded += search.expanded;
        generated += search.generated;
        Length::of(&path)
    });
    (lengths.collect(), expanded, generated)
}

/// The timed part: all queries, one after the other.
fn run(planner: &mut dyn GlobalPlanner, problems: &[Problem<'_>], path: &mut Vec<Cell>) {
    for problem in problems {
        planner.as_grid().expect("cells").search(problem, path);
    }
}

/// All maps: those that come with the benches and, where they are there, those of the MovingAI benchmarks.
fn all_grids(settings: &Settings) -> Result<Vec<GridScene>, String> {
    let mut grids = scenes::random_grids()?;
    match scenes::movingai_grids(settings) {
        Ok(more) => grids.extend(more),
        Err(reason) => eprintln!("without the MovingAI benchmarks: {reason}"),
    }
    Ok(grids)
}

/// A grid as the peer is given it: row-major with a blocked border, so that it need not test for the edge either.
struct PeerGrid {
    stride: u32,
    free: Vec<bool>,
}

/// Costs that order like counts of straight and diagonal steps: 2^40 to the cell.
const STRAIGHT: u64 = 1 << 40;
const DIAGONAL: u64 = (SQRT_2 * STRAIGHT as f64 + 0.5) as u64;

impl PeerGrid {
    fn of(grid: &PlanningGrid) -> Self {
        let is_free = |row, col| grid.is_passable(Cell { col, row });
        let free = (-1..=grid.rows()).flat_map(|row| (-1..=grid.cols()).map(move |col| is_free(row, col)));
        Self { stride: grid.cols() as u32 + 2, free: free.collect() }
    }

    fn index(&self, cell: Cell) -> u32 {
        (cell.row + 1) as u32 * self.stride + (cell.col + 1) as u32
    }

    fn cell(&self, index: u32) -> Cell {
        Cell { col: (index % self.stride) as i32 - 1, row: (index / self.stride) as i32 - 1 }
    }

    fn successors(&self, from: u32) -> impl Iterator<Item = (u32, u64)> + use<> {
        let free = |index: u32| self.free[index as usize];
        let (south, north) = (from - self.stride, from + self.stride);
        let (e, n, w, s) = (free(from + 1), free(north), free(from - 1), free(south));
        let straight = |is_free: bool, to: u32| is_free.then_some((to, STRAIGHT));
        let diagonal = |sides_are_free: bool, to: u32| (sides_are_free && free(to)).then_some((to, DIAGONAL));
        [
            straight(e, from + 1),
            straight(n, north),
            straight(w, from - 1),
            straight(s, south),
            diagonal(n && e, north + 1),
            diagonal(n && w, north - 1),
            diagonal(s && w, south - 1),
            diagonal(s && e, south + 1),
        ]
        .into_iter()
        .flatten()
    }

    /// The peer's answer to a query: its path and how many nodes it asked for successors.
    fn search(&self, problem: &Problem<'_>) -> (Option<Vec<u32>>, u64) {
        let (start, goal) = (self.index(problem.start), self.index(problem.goal));
        let mut expanded = 0;
        let octile = |&index: &u32| {
            let cell = self.cell(index);
            let (dx, dy) = (cell.col.abs_diff(problem.goal.col), cell.row.abs_diff(problem.goal.row));
            STRAIGHT * u64::from(dx.abs_diff(dy)) + DIAGONAL * u64::from(dx.min(dy))
        };
        let successors = |&index: &u32| {
            expanded += 1;
            self.successors(index)
        };
        let found = astar(&start, successors, octile, |&index| index == goal);
        (found.map(|(path, _)| path), expanded)
    }
}

fn a_star(settings: &Settings) -> Result<Vec<Line>, String> {
    let mut lines = Vec::new();
    for scene in all_grids(settings)? {
        let problems = scene.problems(QUERIES);
        let peer = PeerGrid::of(&scene.grid);
        let mut ours = planner("a_star");
        let (lengths, expanded, generated) = answers(&mut *ours, &problems);
        let mut peer_expanded = 0;
        for (problem, length) in problems.iter().zip(lengths) {
            let (found, count) = peer.search(problem);
            peer_expanded += count;
            let path = found.map_or(Vec::new(), |path| path.into_iter().map(|index| peer.cell(index)).collect());
            check(&scene, problem, length, Length::of(&path))?;
        }
        let mut path = Vec::new();
        let pair = measure::pair(
            settings.pairs,
            || run(&mut *ours, &problems, &mut path),
            || problems.iter().map(|problem| peer.search(problem).1).sum::<u64>(),
        );
        let per_expansion = |s: Spread, expanded: u64| s.median / expanded as f64 * 1e9;
        let counts = format!(
            "{} queries, {expanded} expanded ({generated} generated) {:.1} ns each; peer {peer_expanded} {:.1} ns each",
            problems.len(),
            per_expansion(pair.first, expanded),
            per_expansion(pair.second, peer_expanded),
        );
        lines.push(Line::of(&scene.name, pair, problems.len() as f64, counts));
    }
    Ok(lines)
}

fn check(scene: &GridScene, problem: &Problem<'_>, ours: Option<Length>, other: Option<Length>) -> Result<(), String> {
    if ours == other {
        return Ok(());
    }
    let (start, goal) = (problem.start, problem.goal);
    Err(format!("{}: {start:?} to {goal:?}: ours {ours:?}, the other {other:?}", scene.name))
}

/// A planner against `a_star` on the same queries; `is_exact` where its paths must be as short.
fn against_a_star(settings: &Settings, name: &str, is_exact: bool) -> Result<Vec<Line>, String> {
    let mut lines = Vec::new();
    for scene in all_grids(settings)? {
        let problems = scene.problems(QUERIES);
        let (mut ours, mut a_star) = (planner(name), planner("a_star"));
        let (lengths, expanded, _) = answers(&mut *ours, &problems);
        let (a_star_lengths, a_star_expanded, _) = answers(&mut *a_star, &problems);
        for ((problem, length), a_star_length) in problems.iter().zip(lengths).zip(a_star_lengths) {
            if is_exact {
                check(&scene, problem, length, a_star_length)?;
            } else if length.is_some() != a_star_length.is_some() {
                return Err(format!("{}: {:?} to {:?}: one finds no path", scene.name, problem.start, problem.goal));
            }
        }
        let (mut path, mut a_star_path) = (Vec::new(), Vec::new());
        let pair = measure::pair(
            settings.pairs,
            || run(&mut *ours, &problems, &mut path),
            || run(&mut *a_star, &problems, &mut a_star_path),
        );
        let counts = format!("{} queries, {expanded} expanded, a_star {a_star_expanded}", problems.len());
        lines.push(Line::of(&scene.name, pair, problems.len() as f64, counts));
    }
    Ok(lines)
}

/// Distance ahead of the robot at which its path is blocked, cells: about its range of sight.
const AHEAD: usize = 12;
/// Queries per map whose paths are long enough; each has planners of its own.
const REPAIRS: usize = 10;

/// The robot stands at the start of a path, and a block of 3 × 3 cells appears on it and disappears again. Timed is
/// what the planner does about both, against twice a search from scratch.
fn repair(settings: &Settings) -> Result<Vec<Line>, String> {
    let mut lines = Vec::new();
    for scene in all_grids(settings)? {
        let (mut path, mut cases) = (Vec::new(), Vec::new());
        let mut a_star = planner("a_star");
        for problem in scene.problems(4 * REPAIRS) {
            a_star.as_grid().expect("cells").search(&problem, &mut path);
            let block = path.get(AHEAD).map(|centre| blocked_around(&scene, *centre));
            let Some(block) = block.filter(|_| path.len() > 2 * AHEAD) else { continue };
            let after = Problem { grid: &PlanningGrid::new(&block, &DistanceField::new(&block), 0.0), ..problem };
            a_star.as_grid().expect("cells").search(&after, &mut path);
            if !path.is_empty() && cases.len() < REPAIRS {
                cases.push((problem.start, problem.goal, after.grid.clone()));
            }
        }
        if cases.is_empty() {
            continue;
        }
        let problems = |case: &'_ (Cell, Cell, PlanningGrid)| (case.0, case.1);
        let grids = |case: usize| [&cases[case].2, &scene.grid];
        let each = |planners: &mut [Box<dyn GlobalPlanner>], path: &mut Vec<Cell>, fresh: bool| {
            let mut expanded = 0;
            for (case, planner) in planners.iter_mut().enumerate() {
                let (start, goal) = problems(&cases[case]);
                for grid in grids(case) {
                    if fresh {
                        planner.reset();
                    }
                    expanded += planner.as_grid().expect("cells").search(&Problem { grid, start, goal }, path).expanded;
                }
            }
            expanded
        };
        let planners = |name| -> Vec<Box<dyn GlobalPlanner>> { cases.iter().map(|_| planner(name)).collect() };
        let units = 2.0 * cases.len() as f64;
        for other in ["lpa_star", "a_star"] {
            let (mut ours, mut others) = (planners("lpa_star"), planners(other));
            each(&mut ours, &mut path, false);
            let (expanded, other_expanded) = (each(&mut ours, &mut path, false), each(&mut others, &mut path, true));
            // Both sides answer alike: the last grid of each case is the one without the block.
            for (case, ours) in ours.iter_mut().enumerate() {
                let (start, goal) = problems(&cases[case]);
                for grid in grids(case) {
                    let problem = Problem { grid, start, goal };
                    ours.as_grid().expect("cells").search(&problem, &mut path);
                    let length = Length::of(&path);
                    a_star.as_grid().expect("cells").search(&problem, &mut path);
                    check(&scene, &problem, length, Length::of(&path))?;
                }
            }
            let (mut our_path, mut other_path) = (Vec::new(), Vec::new());
            let pair = measure::pair(
                settings.pairs,
                || each(&mut ours, &mut our_path, false),
                || each(&mut others, &mut other_path, true),
            );
            let counts = format!("{} changes, {expanded} expanded, from scratch {other_expanded}", 2 * cases.len());
            lines.push(Line::of(format!("{} / {other}", scene.name), pair, units, counts));
        }
    }
    Ok(lines)
}

/// The map with a block of 3 × 3 cells more.
fn blocked_around(scene: &GridScene, centre: Cell) -> OccupancyGrid {
    let mut map = scene.map.clone();
    for row in centre.row - 1..=centre.row + 1 {
        for col in centre.col - 1..=centre.col + 1 {
            if map.contains(Cell { col, row }) {
                map.set_occupied(Cell { col, row });
            }
        }
    }
    map
}

const SIDES: [i32; 6] = [128, 256, 512, 1024, 2048, 4096];

/// 20 % of the cells occupied, by a linear congruential generator.
fn random_map(side: i32) -> OccupancyGrid {
    let mut map = OccupancyGrid::empty(side, side, 0.05);
    let mut state = 1u64;
    for index in 0..map.occupied().len() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        if state >> 32 < (1 << 32) / 5 {
            map.set_occupied(map.cell(index));
        }
    }
    map
}

fn growth(settings: &Settings) -> Result<Vec<Line>, String> {
    let line = |side: i32| {
        let map = random_map(side);
        let field = DistanceField::new(&map);
        let grid = PlanningGrid::new(&map, &field, 0.0);
        let problems = across(&grid, &map, &field)?;
        let mut a_star = planner("a_star");
        let (lengths, expanded, _) = answers(&mut *a_star, &problems);
        if lengths.iter().any(Option::is_none) {
            return Err(format!("{side}: no path"));
        }
        let mut path = Vec::new();
        let spread = measure::alone(settings.pairs, || run(&mut *a_star, &problems, &mut path));
        // In a process of its own, whose memory nothing else has used before.
        let this = std::env::current_exe().map_err(|error| error.to_string())?;
        let memory = Command::new(this).args(["--memory", &side.to_string()]).output();
        let memory = memory.map_err(|error| error.to_string())?.stdout;
        let counts = format!(
            "{expanded} expanded, {:.1} ns each ({:.1} .. {:.1}); {}",
            spread.median / expanded as f64 * 1e9,
            spread.min / expanded as f64 * 1e9,
            spread.max / expanded as f64 * 1e9,
            String::from_utf8_lossy(&memory).trim(),
        );
        Ok(Line { input: format!("{side} x {side}"), ours: spread, other: None, ratio: None, counts })
    };
    SIDES.map(line).into_iter().collect()
}

/// Across the whole map, four ways; from each end inwards to a cell of the largest connected part.
fn across<'a>(grid: &'a PlanningGrid, map: &OccupancyGrid, field: &DistanceField) -> Result<Vec<Problem<'a>>, String> {
    let side = map.cols();
    let parts = Components::new(map, &connectivity::passable(field, 0.0));
    let is_open = |cell: Cell| Some(parts.labels()[map.index(cell)]) == parts.largest();
    let at = |(col, row): (i32, i32)| {
        let inwards = |from: i32, step: i32| if from < side / 2 { from + step } else { from - step };
        let mut cells = (0..side / 2).map(|step| Cell { col: inwards(col, step), row });
        cells.find(|&cell| is_open(cell)).ok_or("no free cell")
    };
    let end = side - 2;
    let ends = [
        ((1, 1), (end, end)),
        ((1, end), (end, 1)),
        ((1, side / 2), (end, side / 3)),
        ((side / 2, 1), (side / 3, end)),
    ];
    ends.iter().map(|&(start, goal)| Ok(Problem { grid, start: at(start)?, goal: at(goal)? })).collect()
}

/// Memory of this process taken by a map, its field and a search, bytes per cell.
pub fn memory(side: i32) -> Result<String, String> {
    let mut marks = vec![resident_bytes()?];
    let map = random_map(side);
    marks.push(resident_bytes()?);
    let field = DistanceField::new(&map);
    marks.push(resident_bytes()?);
    let grid = PlanningGrid::new(&map, &field, 0.0);
    marks.push(resident_bytes()?);
    let problems = across(&grid, &map, &field)?;
    let before_search = resident_bytes()?;
    answers(&mut *planner("a_star"), &problems);
    let search = resident_bytes()? - before_search;
    let per_cell = |bytes: f64| bytes / (f64::from(side) * f64::from(side));
    let [map, field, grid] = std::array::from_fn(|k| per_cell(marks[k + 1] - marks[k]));
    let search = per_cell(search);
    Ok(format!(
        "bytes a cell: map {map:.1}, field {field:.1}, grid {grid:.1}, search {search:.1}, together {:.1}",
        map + field + grid + search
    ))
}

/// Memory of this process that is in use, bytes.
fn resident_bytes() -> Result<f64, String> {
    let text = fs::read_to_string("/proc/self/statm").map_err(|error| format!("/proc/self/statm: {error}"))?;
    let pages = text.split_whitespace().nth(1).and_then(|pages| pages.parse::<f64>().ok());
    Ok(pages.ok_or("/proc/self/statm has another form")? * 4096.0)
}

fn distance_field(settings: &Settings) -> Result<Vec<Line>, String> {
    let line = |side: i32| {
        let map = random_map(side);
        let spread = measure::alone(settings.pairs, || DistanceField::new(&map));
        let per_cell = |s: f64| s * 1e9 / (f64::from(side) * f64::from(side));
        let counts = format!(
            "{:.1} ns a cell ({:.1} .. {:.1})",
            per_cell(spread.median),
            per_cell(spread.min),
            per_cell(spread.max)
        );
        Line { input: format!("{side} x {side}"), ours: spread, other: None, ratio: None, counts }
    };
    Ok(SIDES.into_iter().map(line).collect())
}
