//! Planners that repair their search, against Dijkstra from scratch, over episodes of blocked and freed cells and a robot that moves.

use super::*;
use crate::map::OccupancyGrid;

/// What a sequence of calls came to, summed.
#[derive(Debug, Default)]
struct Tally {
    found: u32,
    lost: u32,
    /// Calls that found a way where the call before, from the same start to the same goal, had found none.
    recovered: u32,
    expanded: u64,
    from_scratch: u64,
}

/// Plans 20 times on one map that changes in between, beside Dijkstra.
fn episode(choice: &GlobalChoice, corner_rule: CornerRule, stream: &mut Stream, tally: &mut Tally) {
    let share = stream.range(0.0, 0.4);
    // What is occupied, and what is blocked by inflation as well.
    let mut blocked = random_map(stream, 24, share);
    let mut occupied = blocked.clone();
    let (mut planner, mut fresh) = (choice.build(), dijkstra(corner_rule).build());
    let (mut start, mut goal) = (random_cell(stream, &blocked), random_cell(stream, &blocked));
    let (mut path, mut expected_path) = (Vec::new(), Vec::new());
    let mut lost = None;
    for _ in 0..20 {
        let before = (blocked.clone(), occupied.clone());
        for _ in 0..stream.index(6) {
            let cell = random_cell(stream, &blocked);
            let toggle = |map: &mut OccupancyGrid, free: bool| {
                if free { map.set_free(cell) } else { map.set_occupied(cell) }
            };
            let was_free = blocked.is_free(cell);
            toggle(&mut blocked, !was_free);
            toggle(&mut occupied, !was_free || stream.uniform() < 0.5);
        }
        let mut grid = uninflated(&blocked);
        if stream.uniform() < 0.5 {
            grid.open_around(&occupied, start);
            grid.open_around(&occupied, goal);
        }
        let problem = Problem { grid: &grid, start, goal };
        let search = planner.as_grid().expect("cells").search(&problem, &mut path);
        let expected = fresh.as_grid().expect("cells").search(&problem, &mut expected_path);
        assert_eq!(search.result, expected.result, "{}", choice.name());
        if search.result.is_ok() {
            assert_eq!(
                checked_cost(&grid, &path, start, goal, corner_rule),
                checked_cost(&grid, &expected_path, start, goal, corner_rule),
                "{}",
                choice.name()
            );
            tally.found += 1;
            tally.recovered += u32::from(lost == Some((start, goal)));
            tally.expanded += search.expanded;
            tally.from_scratch += expected.expanded;
            start = path[stream.index(path.len().min(4))];
        } else {
            assert!(path.is_empty());
            tally.lost += 1;
            lost = (search.result == Err(Failure::NoPath)).then_some((start, goal));
            if stream.uniform() < 0.5 {
                start = random_cell(stream, &blocked);
            } else {
                // What has just been blocked is freed again.
                (blocked, occupied) = before;
            }
        }
        if stream.uniform() < 0.05 {
            goal = random_cell(stream, &blocked);
        }
    }
}

#[test]
fn repairs_cost_what_a_search_from_scratch_does() {
    for planner in 0..repairing(CornerRule::Forbid).len() {
        let (mut stream, mut tally) = (stream(61), Tally::default());
        for case in 0..600 {
            let corner_rule = CORNER_RULES[case % 3];
            let choice = &repairing(corner_rule)[planner];
            episode(choice, corner_rule, &mut stream, &mut tally);
        }
        let Tally { found, lost, recovered, expanded, from_scratch } = tally;
        assert!(found > 3000 && lost > 700 && recovered > 20, "{tally:?}");
        assert!(expanded < from_scratch / 2, "{expanded} expanded in repairs, {from_scratch} from scratch");
    }
}

#[test]
fn after_a_reset_nothing_is_left_of_the_episode_before() {
    let mut stream = stream(65);
    for _ in 0..50 {
        let (grid, start, goal) = random_problem(&mut stream);
        let problem = Problem { grid: &grid, start, goal };
        let mut other = grid.clone();
        other.block_capsule(grid.centre(start), grid.centre(goal), 0.6 * grid.resolution_m());
        for choice in repairing(CornerRule::Forbid) {
            let (mut planner, mut path) = (choice.build(), Vec::new());
            let _ = planner.as_grid().expect("cells").search(&Problem { grid: &other, ..problem }, &mut path);
            planner.reset();
            let again = planner.as_grid().expect("cells").search(&problem, &mut path);
            assert_eq!((again, path), plan(&choice, &grid, start, goal), "{}", choice.name());
        }
    }
}
