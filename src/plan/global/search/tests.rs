//! The planners that share the core, against a slow shortest-path computation of their own.

mod repairs;

use super::*;
use crate::plan::global::{
    GlobalChoice, GlobalPlanner, a_star, d_star, d_star_lite, dijkstra, improved_dijkstra, lpa_star,
};
use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};
use crate::plan::{ESCAPE_FACTOR, Passability};
use crate::rng::Stream;

const CORNER_RULES: [CornerRule; 3] = [CornerRule::Forbid, CornerRule::OneFree, CornerRule::Allow];
const CONSISTENT: [Heuristic; 3] = [Heuristic::Octile, Heuristic::Euclidean, Heuristic::Chebyshev];

/// A problem on a random map, some with an escape zone around the start.
fn random_problem(stream: &mut Stream) -> (PlanningGrid, Cell, Cell) {
    let share = stream.range(0.0, 0.5);
    let map = random_map(stream, 14, share);
    let mut grid = uninflated(&map);
    let (start, goal) = (random_cell(stream, &map), random_cell(stream, &map));
    if stream.uniform() < 0.3 {
        // Some obstacles are there by inflation only.
        let mut occupied = map.clone();
        for index in 0..map.occupied().len() {
            if stream.uniform() < 0.7 {
                occupied.set_free(map.cell(index));
            }
        }
        grid.open_around(&occupied, start);
        grid.open_around(&occupied, goal);
    }
    (grid, start, goal)
}

fn neighbours(cell: Cell) -> impl Iterator<Item = Cell> {
    let offsets = (-1..=1).flat_map(|row| (-1..=1).map(move |col| (col, row))).filter(|&offset| offset != (0, 0));
    offsets.map(move |(col, row)| Cell { col: cell.col + col, row: cell.row + row })
}

/// Cost of a step between neighbours, if it is allowed: the rules written down once more.
fn step_cost(grid: &PlanningGrid, a: Cell, b: Cell, rule: CornerRule) -> Option<Steps> {
    let free = |col, row| grid.is_passable(Cell { col, row });
    let beside = usize::from(free(a.col, b.row)) + usize::from(free(b.col, a.row));
    let diagonal = a.col != b.col && a.row != b.row;
    let needed = match rule {
        CornerRule::Forbid => 2,
        CornerRule::OneFree => 1,
        CornerRule::Allow => 0,
    };
    let allowed = free(a.col, a.row) && free(b.col, b.row) && (!diagonal || beside >= needed);
    let escapes = [a, b].iter().any(|&cell| grid.passability(cell) == Passability::Escape);
    let factor = if escapes { ESCAPE_FACTOR } else { 1 };
    let steps =
        if diagonal { Steps { straight: 0, diagonal: factor } } else { Steps { straight: factor, diagonal: 0 } };
    allowed.then_some(steps)
}

/// Shortest distances from a cell to all others, by relaxing every step until nothing changes.
fn bellman_ford(grid: &PlanningGrid, start: Cell, rule: CornerRule) -> Vec<f64> {
    let cells: Vec<Cell> =
        (0..grid.rows()).flat_map(|row| (0..grid.cols()).map(move |col| Cell { col, row })).collect();
    let at = |cell: Cell| (cell.row * grid.cols() + cell.col) as usize;
    let mut distances = vec![f64::INFINITY; cells.len()];
    distances[at(start)] = 0.0;
    loop {
        let before = distances.clone();
        for &a in &cells {
            for b in neighbours(a) {
                if let Some(steps) = step_cost(grid, a, b, rule) {
                    distances[at(b)] = crate::math::min(distances[at(b)], distances[at(a)] + steps.value());
                }
            }
        }
        if distances == before {
            return distances;
        }
    }
}

/// The cost of a path, checked to be one: ends, neighbours, corner rule.
fn checked_cost(grid: &PlanningGrid, path: &[Cell], start: Cell, goal: Cell, rule: CornerRule) -> Steps {
    assert_eq!((path.first(), path.last()), (Some(&start), Some(&goal)));
    path.windows(2).fold(Steps::default(), |cost, step| {
        assert!((step[1].col - step[0].col).abs() <= 1 && (step[1].row - step[0].row).abs() <= 1 && step[0] != step[1]);
        cost.plus(step_cost(grid, step[0], step[1], rule).expect("an allowed step"))
    })
}

fn plan(choice: &GlobalChoice, grid: &PlanningGrid, start: Cell, goal: Cell) -> (Search, Vec<Cell>) {
    let mut path = vec![start; 3];
    (choice.build().as_grid().expect("cells").search(&Problem { grid, start, goal }, &mut path), path)
}

fn a_star(heuristic: Heuristic, corner_rule: CornerRule) -> GlobalChoice {
    GlobalChoice::a_star(a_star::Params { heuristic, corner_rule })
}

fn dijkstra(corner_rule: CornerRule) -> GlobalChoice {
    GlobalChoice::dijkstra(dijkstra::Params { corner_rule })
}

/// The planners that repair the search of the call before.
fn repairing(corner_rule: CornerRule) -> [GlobalChoice; 3] {
    [
        GlobalChoice::lpa_star(lpa_star::Params { corner_rule }),
        GlobalChoice::d_star(d_star::Params { corner_rule }),
        GlobalChoice::d_star_lite(d_star_lite::Params { corner_rule }),
    ]
}

#[test]
fn paths_are_valid_and_as_short_as_bellman_ford_says() {
    let mut stream = stream(21);
    let (mut found, mut escaped) = (0, 0);
    for _ in 0..1500 {
        let (grid, start, goal) = random_problem(&mut stream);
        for rule in CORNER_RULES {
            let distances = bellman_ford(&grid, start, rule);
            let shortest = distances[(goal.row * grid.cols() + goal.col) as usize];
            let (reference, path) = plan(&dijkstra(rule), &grid, start, goal);
            let expected = if !grid.is_passable(start) {
                Err(Failure::StartOccupied)
            } else if !grid.is_passable(goal) {
                Err(Failure::GoalOccupied)
            } else if shortest == f64::INFINITY {
                Err(Failure::NoPath)
            } else {
                Ok(())
            };
            assert_eq!(reference.result, expected);
            let cost = expected.as_ref().ok().map(|_| checked_cost(&grid, &path, start, goal, rule));
            if let Some(cost) = cost {
                assert!((cost.value() - shortest).abs() < 1e-9, "{cost:?} {shortest}");
                found += 1;
                escaped += usize::from(path.iter().any(|&cell| grid.passability(cell) == Passability::Escape));
            } else {
                assert!(path.is_empty(), "the old path is gone");
            }
            for heuristic in CONSISTENT {
                let (search, path) = plan(&a_star(heuristic, rule), &grid, start, goal);
                assert_eq!(search.result, expected);
                assert_eq!(
                    expected.as_ref().ok().map(|_| checked_cost(&grid, &path, start, goal, rule)),
                    cost,
                    "exactly"
                );
                // f(n) ≤ optimum and h(n) > 0 make g(n) < optimum: Dijkstra has expanded n as well.
                assert!(search.expanded <= reference.expanded, "{heuristic:?} {search:?} {reference:?}");
                assert!(search.generated >= search.expanded);
            }
            let without_symmetry = GlobalChoice::improved_dijkstra(improved_dijkstra::Params { corner_rule: rule });
            let (search, path) = plan(&without_symmetry, &grid, start, goal);
            assert_eq!(search.result, expected);
            assert_eq!(expected.as_ref().ok().map(|_| checked_cost(&grid, &path, start, goal, rule)), cost, "exactly");
            assert_eq!(search.expanded, reference.expanded, "the nodes nearer than the goal, and no other");
            for repairing in repairing(rule) {
                let (search, path) = plan(&repairing, &grid, start, goal);
                assert_eq!(search.result, expected);
                let of_path = expected.as_ref().ok().map(|_| checked_cost(&grid, &path, start, goal, rule));
                assert_eq!(of_path, cost, "exactly");
            }
            if rule == CornerRule::Forbid {
                let jumping = GlobalChoice::by_name("jps").expect("defaults");
                let (search, path) = plan(&jumping, &grid, start, goal);
                assert_eq!(search.result, expected);
                assert_eq!(
                    expected.as_ref().ok().map(|_| checked_cost(&grid, &path, start, goal, rule)),
                    cost,
                    "exactly"
                );
            }
            let (search, path) = plan(&a_star(Heuristic::Manhattan, rule), &grid, start, goal);
            assert_eq!(search.result, expected);
            if let Some(cost) = cost {
                assert!(checked_cost(&grid, &path, start, goal, rule).value() >= cost.value());
            }
        }
    }
    assert!(found > 1000 && escaped > 100, "{found} {escaped}");
}

#[test]
fn consistent_heuristics_expand_no_node_twice_and_manhattan_does() {
    let mut stream = stream(22);
    let (mut twice, mut longer) = (0, 0);
    for _ in 0..1500 {
        let map = random_map(&mut stream, 40, 0.3);
        let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
        let grid = uninflated(&map);
        let problem = Problem { grid: &grid, start, goal };
        let mut lengths = Vec::new();
        for heuristic in [Heuristic::Octile, Heuristic::Euclidean, Heuristic::Chebyshev, Heuristic::Manhattan] {
            // Closed nodes may be re-opened here even where the planner says that they need not be.
            struct Reopening<'a>(a_star::CostPlusEstimate<'a>);
            impl Rule for Reopening<'_> {
                type Cost = Steps;
                type Priority = f64;
                fn reopens(&self) -> bool {
                    true
                }
                fn moves(&self, from: &Visit<Steps>) -> Moves {
                    self.0.moves(from)
                }
                fn priority(&self, arrival: Arrival<Steps>) -> f64 {
                    self.0.priority(arrival)
                }
            }
            let params = a_star::Params { heuristic, corner_rule: CornerRule::Forbid };
            let rule = Reopening(a_star::CostPlusEstimate { problem: &problem, params: &params });
            let (mut workspace, mut path) = (Workspace::<_, Buckets<_>>::default(), Vec::new());
            let search = workspace.search(&rule, &problem, &mut path);
            let Nodes { of_cells, search: met } = &workspace.nodes;
            let closed = of_cells.iter().filter(|node| node.state >= met.closed()).count() as u64;
            if heuristic.is_consistent() {
                assert_eq!(search.expanded, closed, "{heuristic:?}");
            } else {
                twice += u32::from(search.expanded > closed);
            }
            lengths.push(
                search.result.map_or(0.0, |()| checked_cost(&grid, &path, start, goal, CornerRule::Forbid).value()),
            );
        }
        longer += u32::from(lengths[3] > lengths[0]);
    }
    assert!(twice > 20 && longer > 20, "{twice} {longer}");
}

#[test]
fn whole_steps_as_one_integer_change_nothing_but_the_time() {
    let mut stream = stream(27);
    let (mut whole, mut real) = (Workspace::<_, Buckets<_>>::default(), Workspace::<_, Buckets<_>>::default());
    let mut expanded = 0;
    for case in 0..3000 {
        let (grid, start, goal) = if case % 10 == 0 {
            let map = random_map(&mut stream, 300, 0.25);
            (uninflated(&map), random_cell(&mut stream, &map), random_cell(&mut stream, &map))
        } else {
            random_problem(&mut stream)
        };
        let problem = Problem { grid: &grid, start, goal };
        for corner_rule in CORNER_RULES {
            let params = a_star::Params { heuristic: Heuristic::Octile, corner_rule };
            let (mut path, mut expected_path) = (Vec::new(), Vec::new());
            let search = whole.search(&a_star::CostPlusOctile::new(&problem, corner_rule), &problem, &mut path);
            let rule = a_star::CostPlusEstimate { problem: &problem, params: &params };
            let expected = real.search(&rule, &problem, &mut expected_path);
            expanded += search.expanded;
            assert_eq!((search, path), (expected, expected_path), "{corner_rule:?}");
        }
    }
    assert!(expanded > 300_000, "{expanded}");
}

#[test]
fn leaving_out_detours_changes_nothing_but_the_time() {
    /// A* that tries all allowed moves.
    struct Thorough<'a>(a_star::CostPlusEstimate<'a>);
    impl Rule for Thorough<'_> {
        type Cost = Steps;
        type Priority = f64;
        fn reopens(&self) -> bool {
            self.0.reopens()
        }
        fn moves(&self, from: &Visit<Steps>) -> Moves {
            Moves::allowed(self.0.problem.grid, from.index, self.0.params.corner_rule)
        }
        fn priority(&self, arrival: Arrival<Steps>) -> f64 {
            self.0.priority(arrival)
        }
    }
    let mut stream = stream(26);
    let mut fewer = 0;
    for _ in 0..3000 {
        let (grid, start, goal) = random_problem(&mut stream);
        for corner_rule in CORNER_RULES {
            for heuristic in [Heuristic::Octile, Heuristic::Euclidean, Heuristic::Chebyshev, Heuristic::Manhattan] {
                let (problem, params) =
                    (Problem { grid: &grid, start, goal }, a_star::Params { heuristic, corner_rule });
                let rule = || a_star::CostPlusEstimate { problem: &problem, params: &params };
                let (mut path, mut thorough_path) = (Vec::new(), Vec::new());
                let search = Workspace::<_, Buckets<_>>::default().search(&rule(), &problem, &mut path);
                let thorough =
                    Workspace::<_, Buckets<_>>::default().search(&Thorough(rule()), &problem, &mut thorough_path);
                assert_eq!((&search, &path), (&thorough, &thorough_path), "{heuristic:?} {corner_rule:?}");
                if search.result.is_ok() && path.len() > 2 {
                    let at = grid.index(path[1]);
                    let all = Moves::allowed(&grid, at, corner_rule).count();
                    let arrived_by =
                        Moves::allowed(&grid, grid.index(start), corner_rule).find(|step| step.from(start) == path[1]);
                    fewer += u32::from(Moves::worthwhile(&grid, at, corner_rule, arrived_by).count() < all);
                }
            }
        }
    }
    assert!(fewer > 1000, "moves are left out: {fewer}");
}

#[test]
fn mirrored_and_reversed_problems_cost_the_same() {
    let mut stream = stream(23);
    for _ in 0..1500 {
        let share = stream.range(0.0, 0.4);
        let map = random_map(&mut stream, 20, share);
        let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
        let flip = |cell: Cell| Cell { col: map.cols() - 1 - cell.col, row: cell.row };
        let turn = |cell: Cell| Cell { col: cell.row, row: cell.col };
        let mut flipped = crate::map::OccupancyGrid::empty(map.cols(), map.rows(), 1.0);
        let mut turned = crate::map::OccupancyGrid::empty(map.rows(), map.cols(), 1.0);
        for index in (0..map.occupied().len()).filter(|&index| map.occupied()[index]) {
            flipped.set_occupied(flip(map.cell(index)));
            turned.set_occupied(turn(map.cell(index)));
        }
        let cost = |map: &crate::map::OccupancyGrid, rule, start, goal| {
            let grid = uninflated(map);
            let (search, path) = plan(&a_star(Heuristic::Octile, rule), &grid, start, goal);
            search.result.ok().map(|_| checked_cost(&grid, &path, start, goal, rule))
        };
        for rule in CORNER_RULES {
            let expected = cost(&map, rule, start, goal);
            assert_eq!(cost(&flipped, rule, flip(start), flip(goal)), expected);
            assert_eq!(cost(&turned, rule, turn(start), turn(goal)), expected);
            assert_eq!(cost(&map, rule, goal, start), expected);
        }
    }
}

#[test]
fn a_workspace_carries_nothing_from_one_map_to_the_next() {
    let mut stream = stream(24);
    let mut used: Vec<(GlobalChoice, Box<dyn GlobalPlanner>)> = GlobalChoice::NAMES
        .iter()
        .map(|name| GlobalChoice::by_name(name).expect("defaults"))
        .map(|choice| (choice.clone(), choice.build()))
        // The others have such a test of their own.
        .filter_map(|(choice, mut planner)| planner.as_grid().is_some().then_some((choice, planner)))
        .collect();
    assert!(used.len() > 10);
    for _ in 0..500 {
        let side = [3, 12, 40][stream.index(3)];
        let map = random_map(&mut stream, side, 0.25);
        let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
        let grid = uninflated(&map);
        for (choice, planner) in &mut used {
            let (expected, expected_path) = plan(choice, &grid, start, goal);
            let mut path = vec![goal];
            for _ in 0..2 {
                planner.reset();
                assert_eq!(
                    planner.as_grid().expect("cells").search(&Problem { grid: &grid, start, goal }, &mut path),
                    expected
                );
                assert_eq!(path, expected_path);
            }
        }
    }
}

#[test]
fn stamps_start_again_before_they_run_out() {
    let (_, grid) = drawn(&["....", ".##.", "...."]);
    let (start, goal) = (Cell { col: 0, row: 1 }, Cell { col: 3, row: 1 });
    let problem = Problem { grid: &grid, start, goal };
    let params = a_star::Params::default();
    let rule = a_star::CostPlusEstimate { problem: &problem, params: &params };
    let (mut workspace, mut path) = (Workspace::<_, Buckets<_>>::default(), Vec::new());
    workspace.nodes.search = State(u32::MAX / State::ONE_SEARCH * State::ONE_SEARCH - 3 * State::ONE_SEARCH);
    let expected = Workspace::<_, Buckets<_>>::default().search(&rule, &problem, &mut path);
    for _ in 0..6 {
        assert_eq!(workspace.search(&rule, &problem, &mut path), expected);
    }
    assert!(workspace.nodes.search.0 < 6 * State::ONE_SEARCH, "{:?}", workspace.nodes.search);
}

#[test]
fn the_three_corner_rules_differ_as_drawn() {
    let (_, grid) = drawn(&[
        "...", //
        "#..", //
        ".#.", //
    ]);
    let (start, goal) = (Cell { col: 0, row: 0 }, Cell { col: 2, row: 2 });
    let cost = |rule| {
        let (search, path) = plan(&dijkstra(rule), &grid, start, goal);
        search.result.map(|_| checked_cost(&grid, &path, start, goal, rule))
    };
    assert_eq!(cost(CornerRule::Forbid), Err(Failure::NoPath));
    assert_eq!(cost(CornerRule::OneFree), Err(Failure::NoPath)); // both cells beside are blocked
    assert_eq!(cost(CornerRule::Allow), Ok(Steps { straight: 0, diagonal: 2 }));
    let (_, grid) = drawn(&["..", ".#"]);
    let (start, goal) = (Cell { col: 0, row: 0 }, Cell { col: 1, row: 1 });
    assert_eq!(plan(&dijkstra(CornerRule::Forbid), &grid, start, goal).1.len(), 3);
    assert_eq!(plan(&dijkstra(CornerRule::OneFree), &grid, start, goal).1.len(), 2);
}

#[test]
fn expansions_and_generations_are_counted_by_hand_in_a_corridor() {
    // Five cells in a row: four are expanded, the goal is not; all five are pushed once.
    let (_, grid) = drawn(&["....."]);
    let (start, goal) = (Cell { col: 0, row: 0 }, Cell { col: 4, row: 0 });
    for choice in [dijkstra(CornerRule::Forbid), a_star(Heuristic::Octile, CornerRule::Forbid)] {
        let (search, path) = plan(&choice, &grid, start, goal);
        assert_eq!((search.expanded, search.generated, path.len()), (4, 5, 5));
        // From the middle Dijkstra goes both ways: 2, then 1 and 3 and 0 at equal steps before 4.
        let (search, _) = plan(&choice, &grid, Cell { col: 2, row: 0 }, goal);
        let expected = if matches!(choice, GlobalChoice::dijkstra(_)) { (4, 5) } else { (2, 4) };
        assert_eq!((search.expanded, search.generated), expected);
        let (search, path) = plan(&choice, &grid, start, start);
        assert_eq!((search.expanded, search.generated, path), (0, 1, vec![start]));
    }
}

#[test]
fn leaving_an_escape_zone_costs_ten_times_as_much_and_is_done_at_once() {
    let (map, mut grid) = drawn(&[
        ".......", //
        ".iiiii.", //
        ".......", //
    ]);
    let (start, goal) = (Cell { col: 1, row: 1 }, Cell { col: 6, row: 1 });
    assert_eq!(plan(&dijkstra(CornerRule::Forbid), &grid, start, goal).0.result, Err(Failure::StartOccupied));
    grid.open_around(&map, start);
    // One step out costs 10; then 3 straight and 1 diagonal at least. West: 1 + 10, longer.
    let (_, path) = plan(&dijkstra(CornerRule::Forbid), &grid, start, goal);
    let cost = checked_cost(&grid, &path, start, goal, CornerRule::Forbid);
    assert_eq!(cost, Steps { straight: 10 + 6, diagonal: 0 });
}

#[test]
fn theta_star_bends_only_where_it_must() {
    let (_, grid) = drawn(&[
        "........", //
        "...#....", //
        "...#....", //
    ]);
    let theta_star = GlobalChoice::by_name("theta_star").expect("defaults");
    let cell = |col, row| Cell { col, row };
    let (_, path) = plan(&theta_star, &grid, cell(0, 0), cell(7, 0));
    // One bend above the wall, whose top is at y = 2: the way up passes x = 3 at
    // y = 0.5 + 2.5 · 2/3 = 2.17, the way down x = 4 at y = 2.5 − 0.5 · 2/4 = 2.25.
    assert_eq!(path, [cell(0, 0), cell(3, 2), cell(7, 0)]);
    let (search, path) = plan(&theta_star, &grid, cell(4, 0), cell(7, 2));
    assert_eq!((search.result, path), (Ok(()), vec![cell(4, 0), cell(7, 2)]));
}

#[test]
fn theta_star_paths_are_in_sight_and_no_shorter_than_straight() {
    let mut stream = stream(25);
    let theta_star = GlobalChoice::by_name("theta_star").expect("defaults");
    let mut shorter = 0;
    for _ in 0..1500 {
        let share = stream.range(0.0, 0.4);
        let map = random_map(&mut stream, 30, share);
        let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
        let grid = uninflated(&map);
        let (search, path) = plan(&theta_star, &grid, start, goal);
        let (reference, grid_path) = plan(&dijkstra(CornerRule::Forbid), &grid, start, goal);
        assert_eq!(search.result, reference.result, "neighbours are connected, so what is reachable is the same");
        if search.result.is_ok() {
            assert_eq!((path[0], path[path.len() - 1]), (start, goal));
            assert!(path.windows(2).all(|pair| grid.line_of_sight_cells(pair[0], pair[1])));
            let length = |path: &[Cell]| -> f64 {
                path.windows(2).map(|p| (grid.centre(p[0]) - grid.centre(p[1])).norm()).sum()
            };
            assert!(length(&path) >= (grid.centre(start) - grid.centre(goal)).norm() - 1e-9);
            shorter += u32::from(length(&path) < length(&grid_path) - 1e-9);
        }
    }
    assert!(shorter > 300, "usually shorter than the grid path, and often it can be: {shorter}");
}

#[test]
fn theta_star_leaves_an_escape_zone_cell_by_cell() {
    let (map, mut grid) = drawn(&[
        "iiiiii", //
        "iiiiii", //
        "......", //
    ]);
    let (start, goal) = (Cell { col: 0, row: 2 }, Cell { col: 5, row: 0 });
    grid.open_around(&map, start);
    let (_, path) = plan(&GlobalChoice::by_name("theta_star").expect("defaults"), &grid, start, goal);
    assert_eq!(path[..3], [start, Cell { col: 0, row: 1 }, Cell { col: 0, row: 0 }]);
}

#[test]
fn values_of_equal_counts_are_equal_and_of_different_counts_in_the_right_order() {
    // Neighbouring convergents of √2 are the counts whose values are nearest: p − q√2 = ±(√2 − 1)ᵏ.
    let (mut p, mut q) = (1u32, 1u32);
    while p < 1 << 22 {
        let (whole, diagonals) = (Steps { straight: p, diagonal: 0 }, Steps { straight: 0, diagonal: q });
        let exact = (u64::from(p) * u64::from(p)).cmp(&(2 * u64::from(q) * u64::from(q)));
        assert_eq!(whole.value().total_cmp(&diagonals.value()), exact, "{p}² against 2 · {q}²");
        (p, q) = (p + 2 * q, p + q);
    }
}

#[test]
fn ticks_order_counts_that_differ_by_less_than_a_map_of_path_as_exactly() {
    let mut stream = stream(28);
    let ticks = |straight: u64, diagonal: u64| {
        let one = |is_diagonal| Cost::stepped(CellCost::ZERO, is_diagonal, 1).0;
        straight * one(false) + diagonal * one(true)
    };
    let (mut p, mut q) = (1u64, 1u64);
    while q < 1 << 17 {
        let exact = (p * p).cmp(&(2 * q * q));
        for _ in 0..20 {
            // The same difference from anywhere.
            let (s, d) = (stream.index(1 << 20) as u64, stream.index(1 << 20) as u64);
            assert_eq!(ticks(s + p, d).cmp(&ticks(s, d + q)), exact, "{p}² against 2 · {q}²");
        }
        (p, q) = (p + 2 * q, p + q);
    }
    assert!(q > 1 << 17);
}
