//! From a task to the path that is driven: global planner, path stages, checks. `simrun plan` and episodes share it.

use crate::geometry::{Path, Piece, Vec2, cross};
use crate::math;
use crate::plan::contract::{Failure, GlobalPlanner, PathStage, Plan, Situation, Task};
use crate::plan::{Passability, PlanningGrid};

/// Plans with `global` and treats the path with `stages`, in their order, into `plan`.
///
/// # Errors
/// The failure of the planner or a stage, and [`Failure::Fault`] for an invalid answer.
pub fn find_path<'s>(
    global: &mut dyn GlobalPlanner,
    stages: &mut [Box<dyn PathStage + 's>],
    task: &Task<'_>,
    plan: &mut Plan,
) -> Result<(), Failure> {
    let situation = Situation { random: task.situation.random.of_layer(0), ..*task.situation };
    global.plan(&Task { situation: &situation, ..*task }, plan)?;
    if plan.effort.expanded > task.situation.budget.expansions {
        return Err(Failure::OutOfBudget);
    }
    let mut keeps_off = true;
    check(&plan.path, task, keeps_off).map_err(|what| Failure::Fault(format!("the planned path {what}")))?;
    // Stages that follow may build the path anew.
    let mut fallbacks = plan.path.fallbacks();
    for (number, stage) in stages.iter_mut().enumerate() {
        let situation = Situation { random: task.situation.random.of_layer(2 + number as u64), ..*task.situation };
        plan.path = stage.apply(&Task { situation: &situation, ..*task }, &plan.path)?;
        keeps_off &= stage.keeps_off_obstacles();
        let faulty = |what| Failure::Fault(format!("the path of stage {number} {what}"));
        check(&plan.path, task, keeps_off).map_err(faulty)?;
        fallbacks = fallbacks.max(plan.path.fallbacks());
    }
    join(&mut plan.path, task.grid);
    plan.path = core::mem::take(&mut plan.path).with_fallbacks(fallbacks);
    Ok(())
}

impl Plan {
    /// Makes the path of [`Self::cells`]: from the task's start through the centres of the cells between to its goal. The centres
    /// of the start's and the goal's own cells are no nodes: a robot that plans anew would turn back to the first.
    ///
    /// Where the straight way from the start to the first node is not clear ([`PlanningGrid::is_clear`]), the path joins the
    /// stretch from the start cell's centre to that node at the farthest point to which it is; the same at the goal.
    pub fn follow_cells(&mut self, task: &Task<'_>) {
        let between = self.cells.get(1..self.cells.len().saturating_sub(1)).unwrap_or_default();
        let mut nodes: Vec<Vec2> = Vec::with_capacity(between.len() + 4);
        nodes.extend(between.iter().map(|&cell| task.grid.centre(cell)));
        let grid = task.grid;
        let centre = |p: Vec2| grid.centre(grid.cell_at(p));
        if grid.inflation_m() > 0.0 {
            let first = nodes.first().copied();
            let goes_straight = |to: Vec2| grid.is_clear(task.start, to);
            if !goes_straight(first.unwrap_or(task.goal)) {
                let way =
                    way_to_stretch(grid, task.start, centre(task.start), first.unwrap_or_else(|| centre(task.goal)));
                nodes.splice(0..0, way);
            }
            let last = nodes.last().copied();
            if last.is_some_and(|last| !grid.is_clear(last, task.goal)) {
                let way = way_to_stretch(grid, task.goal, centre(task.goal), last.unwrap_or(task.start));
                nodes.extend(way.into_iter().rev());
            }
        }
        let pieces = nodes.into_iter().chain([task.goal]).map(|to| Piece::Line { to }).collect();
        self.path = Path::new(task.start, pieces);
    }
}

/// Points tried along a stretch, and halvings between the last two of them.
const STRETCH_POINTS: u32 = 16;
const STRETCH_HALVINGS: u32 = 5;

/// The nodes from `end`, a start or goal that has no clear way to the end of a stretch that begins at its own cell's centre, to the
/// farthest point of the stretch to which it has one, that point included.
///
/// Where there is none, the way leads by the centre: straight, or first along one axis and then along the other, whichever has
/// most room. A move along an axis inside a cell comes no nearer to any square than one of its ends.
fn way_to_stretch(grid: &PlanningGrid, end: Vec2, centre: Vec2, to: Vec2) -> Vec<Vec2> {
    let at = |share: f64| centre + (to - centre) * share;
    let is_clear = |share: f64| grid.is_clear(end, at(share));
    let share_of = |k: u32| f64::from(k) / f64::from(STRETCH_POINTS);
    if let Some(k) = (0..STRETCH_POINTS).rev().find(|&k| is_clear(share_of(k))) {
        let (mut near, mut far) = (share_of(k), share_of(k + 1));
        for _ in 0..STRETCH_HALVINGS {
            let middle = 0.5 * (near + far);
            *(if is_clear(middle) { &mut near } else { &mut far }) = middle;
        }
        return vec![at(near)];
    }
    let ways = [vec![centre], vec![Vec2::new(end.x, centre.y), centre], vec![Vec2::new(centre.x, end.y), centre]];
    let room_m = |way: &[Vec2]| {
        let legs = core::iter::once(end).chain(way.iter().copied()).zip(way);
        legs.map(|(from, &to)| grid.clearance(from, to)).fold(f64::INFINITY, math::min)
    };
    let [mut best, others @ ..] = ways;
    for way in others {
        if room_m(&way) > room_m(&best) + 1e-9 {
            best = way;
        }
    }
    best
}

/// Largest depth to which a path may reach into a blocked square, cells. A step past a corner that the planner may cut, from
/// a start beside the centre of its cell, stays below it; a path through a wall does not.
const INTRUSION_CELLS: f64 = 0.4;

/// Checks that a path runs from the task's start to its goal, and through passable cells if it should keep off obstacles; the error says
/// what is wrong.
///
/// Nearer than two cells to either end anything goes: there the robot itself may stand in the inflated zone.
fn check(path: &Path, task: &Task<'_>, keeps_off: bool) -> Result<(), String> {
    const SLACK_M: f64 = 1e-6;
    let is_finite = |p: Vec2| p.x.is_finite() && p.y.is_finite();
    if !path.vertices().all(is_finite) {
        return Err("has a vertex that is not finite".to_owned());
    }
    if (path.start() - task.start).norm() > SLACK_M {
        return Err(format!("begins at {:?} and not at {:?}", path.start().as_slice(), task.start.as_slice()));
    }
    if (path.end() - task.goal).norm() > SLACK_M {
        return Err(format!("ends at {:?} and not at {:?}", path.end().as_slice(), task.goal.as_slice()));
    }
    if !keeps_off {
        return Ok(());
    }
    let side_m = task.grid.resolution_m();
    // Blocked by inflation alone, a cell is passable where the path keeps what its ends and the cells of escape zones leave.
    let inflation_m = task.grid.inflation_m();
    let obstacles = task.grid.obstacles();
    let floor_m = obstacles.map_or(0.0, |obstacles| {
        let in_zone = |p: &Vec2| task.grid.passability(task.grid.cell_at(*p)) == Passability::Escape;
        let least = |floor_m: f64, p: Vec2| obstacles.clearance(p, floor_m);
        path.vertices().filter(in_zone).chain([task.start, task.goal]).fold(inflation_m, least)
    });
    let has_room = |p: Vec2| {
        obstacles.is_some_and(|obstacles| obstacles.clearance(p, floor_m) >= math::max(floor_m - SLACK_M, SLACK_M))
            && task.grid.passes_movers_between(p, p, task.start, task.goal)
    };
    let is_near_end = |p: Vec2| (p - task.start).norm() < 2.0 * side_m || (p - task.goal).norm() < 2.0 * side_m;
    let intrudes = |p: Vec2| {
        let cell = task.grid.cell_at(p);
        let offset = (p - task.grid.centre(cell)) / side_m;
        let depth = 0.5 - math::max(offset.x.abs(), offset.y.abs());
        depth > INTRUSION_CELLS && !task.grid.is_passable(cell) && !is_near_end(p) && !has_room(p)
    };
    for (from, piece) in path.segments() {
        let steps = (piece.length(from) / (0.2 * side_m)).ceil().clamp(1.0, 1e6) as u32;
        if let Some(p) = (0..=steps).map(|k| piece.chord_point(from, k, steps)).find(|&p| intrudes(p)) {
            return Err(format!("passes through a blocked cell at {:?}", p.as_slice()));
        }
    }
    Ok(())
}

/// Joins lines that go straight on, after the last stage and never before: stages get every node. Paths with named key nodes or
/// times stay as they are. The first and the last leg are judged by the centres of the start's and the goal's cells, between
/// which a planner on the grid has gone straight; they take part where the robot can go straight as well.
fn join(path: &mut Path, grid: &PlanningGrid) {
    if path.has_named_nodes() || !path.times_s().is_empty() || path.pieces().len() < 2 {
        return;
    }
    let last = path.pieces().len() - 1;
    let centre = |p: Vec2| grid.centre(grid.cell_at(p));
    let mut pieces: Vec<Piece> = Vec::with_capacity(path.pieces().len());
    // Where the piece before begins, and where it does in truth.
    let (mut before, mut begin) = (centre(path.start()), path.start());
    for (index, (from, piece)) in path.segments().enumerate() {
        let goes_on = match (pieces.last(), piece) {
            (Some(Piece::Line { .. }), &Piece::Line { to }) => {
                let (arriving, leaving) = (from - before, if index == last { centre(to) } else { to } - from);
                let slack = STRAIGHT_RAD * arriving.norm() * leaving.norm();
                // Between cells' centres all is as it was; a leg to a point beside its centre is another line.
                let is_leg = pieces.len() == 1 || index == last;
                cross(arriving, leaving).abs() <= slack
                    && arriving.dot(&leaving) >= 0.0
                    && (!is_leg || grid.inflation_m() <= 0.0 || grid.is_clear(begin, to))
            }
            _ => false,
        };
        if goes_on {
            pieces.pop();
        } else {
            begin = from;
        }
        pieces.push(piece.clone());
        before = if index == 0 { before } else { from };
    }
    *path = Path::new(path.start(), pieces);
}

/// Turn below which a line goes straight on, rad: rounding makes less.
const STRAIGHT_RAD: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::geometry::Rect;
    use crate::map::{Cell, OccupancyGrid};
    use crate::observation::Belief;
    use crate::plan::contract::SearchEffort;
    use crate::plan::global::GlobalChoice;
    use crate::plan::grid::tests::{random_cell, random_map, stream, uninflated};
    use crate::plan::path::PathChoice;
    use crate::robot::Robot;

    fn v(x: f64, y: f64) -> Vec2 {
        Vec2::new(x, y)
    }

    /// Asks `ask` a task on a map.
    fn with_task<T>(map: &OccupancyGrid, start: Vec2, goal: Vec2, ask: impl FnOnce(&Task<'_>) -> T) -> T {
        let (robot, belief, grid) = (Robot::default(), Belief::from(map), uninflated(map));
        let pose = Pose { position: start, theta: 0.0 };
        let situation = Situation::new(&robot, &belief, pose, goal);
        ask(&Task { situation: &situation, grid: &grid, start, goal })
    }

    /// A planner that gives this path.
    struct Answers(Path);

    impl GlobalPlanner for Answers {
        fn plan(&mut self, _: &Task<'_>, plan: &mut Plan) -> Result<(), Failure> {
            plan.path = self.0.clone();
            plan.effort = SearchEffort { expanded: 10, generated: 10 };
            Ok(())
        }
    }

    /// A stage that notes the nodes that it gets.
    struct Counts<'a>(&'a std::sync::Mutex<usize>);

    impl PathStage for Counts<'_> {
        fn apply(&mut self, _: &Task<'_>, path: &Path) -> Result<Path, Failure> {
            *self.0.lock().unwrap() = path.vertices().count();
            Ok(path.clone())
        }
    }

    /// The bends of a path of cells, in whole numbers.
    fn bends(grid: &PlanningGrid, cells: &[Cell], from: Vec2, goal: Vec2) -> Vec<Vec2> {
        let mut nodes = vec![from];
        for three in cells.windows(3) {
            let arriving = (three[1].col - three[0].col, three[1].row - three[0].row);
            let leaving = (three[2].col - three[1].col, three[2].row - three[1].row);
            if arriving.0 * leaving.1 != arriving.1 * leaving.0 || arriving.0 * leaving.0 + arriving.1 * leaving.1 < 0 {
                nodes.push(grid.centre(three[1]));
            }
        }
        nodes.push(goal);
        nodes
    }

    #[test]
    fn stages_get_every_cell_and_the_driven_path_has_the_bends_alone() {
        let mut stream = stream(61);
        let mut found = 0;
        for name in ["a_star", "theta_star", "bfs"] {
            let mut planner = GlobalChoice::by_name(name).unwrap().build();
            for _ in 0..300 {
                let map = random_map(&mut stream, 20, 0.2);
                let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
                // Beside the centre of its cell, as a robot stands.
                let off = map.resolution_m() * v(stream.range(-0.4, 0.4), stream.range(-0.4, 0.4));
                let (start, goal) = (map.centre(start) + off, map.centre(goal));
                let nodes = std::sync::Mutex::new(0);
                let counts = &nodes;
                with_task(&map, start, goal, |task| {
                    let mut plan = Plan::default();
                    planner.reset();
                    // The stage lives for this call alone.
                    let stage: Box<dyn PathStage + '_> = Box::new(Counts(counts));
                    let answer = find_path(&mut *planner, &mut [stage], task, &mut plan);
                    if answer.is_ok() {
                        found += 1;
                        assert_eq!(*counts.lock().unwrap(), plan.cells.len().max(2), "{name}");
                        let expected = bends(task.grid, &plan.cells, start, goal);
                        assert_eq!(plan.path.vertices().collect::<Vec<_>>(), expected, "{name}");
                    }
                });
            }
        }
        assert!(found > 300, "{found}");
    }

    #[test]
    fn every_planner_and_stage_keeps_the_inflation_as_far_as_start_and_goal_do() {
        let mut stream = stream(62);
        let mut found = 0;
        let stages: [&[&str]; 10] = [
            &[],
            &["line_of_sight"],
            &["clearance_prune"],
            &["arc_fillet"],
            &["clearance_prune", "arc_fillet"],
            &["b_spline"],
            &["clearance_prune", "b_spline"],
            &["farthest_visible"],
            &["minimum_snap"],
            &["farthest_visible", "minimum_snap"],
        ];
        for _ in 0..40 {
            let map = random_map(&mut stream, 20, 0.12);
            let side_m = map.resolution_m();
            let inflation_m = side_m * [0.3, 0.45, 0.7, 1.2, 2.4][stream.index(5)];
            let mut random_point = || {
                let cell = random_cell(&mut stream, &map);
                map.centre(cell) + side_m * v(stream.range(-0.45, 0.45), stream.range(-0.45, 0.45))
            };
            let (start, goal) = (random_point(), random_point());
            let squares: Vec<Rect> = (-1..=map.rows())
                .flat_map(|row| (-1..=map.cols()).map(move |col| Cell { col, row }))
                .filter(|&cell| !map.is_free(cell))
                .map(|cell| map.square(cell))
                .collect();
            // By brute force, from the squares alone.
            let room_m = |p: Vec2| squares.iter().map(|square| square.signed_distance(p)).fold(inflation_m, math::min);
            if room_m(start) <= 0.0 || room_m(goal) <= 0.0 {
                continue;
            }
            let (robot, belief) = (Robot::default(), Belief::from(&map));
            let mut grid = PlanningGrid::new(&map, belief.field(), inflation_m);
            grid.open_around(&map, map.cell_at(start));
            grid.open_around(&map, map.cell_at(goal));
            let situation = Situation::new(&robot, &belief, Pose { position: start, theta: 0.0 }, goal);
            let task = Task { situation: &situation, grid: &grid, start, goal };
            for &name in GlobalChoice::NAMES {
                for stages in stages {
                    let mut stages: Vec<Box<dyn PathStage>> =
                        stages.iter().map(|name| PathChoice::by_name(name).unwrap().build()).collect();
                    let mut planner = GlobalChoice::by_name(name).unwrap().build();
                    let mut plan = Plan::default();
                    match find_path(&mut *planner, &mut stages, &task, &mut plan) {
                        Ok(()) => found += 1,
                        Err(Failure::Fault(what)) => panic!("{name}: {what}"),
                        Err(_) => continue,
                    }
                    // What start, goal and the planner's own cells leave; a diagonal step of the grid may dip.
                    let ends = [start, goal].into_iter().map(room_m);
                    let cells = plan.cells.iter().map(|&cell| room_m(map.centre(cell)));
                    let steps = plan.cells.windows(2).filter(|pair| {
                        (pair[0].col - pair[1].col).abs() == 1 && (pair[0].row - pair[1].row).abs() == 1
                    });
                    let dips = steps.map(|pair| grid.clearance(map.centre(pair[0]), map.centre(pair[1])));
                    let floor_m = ends.chain(cells).chain(dips).fold(inflation_m, math::min);
                    for (from, piece) in plan.path.segments() {
                        for k in 0..=40 {
                            let p = piece.chord_point(from, k, 40);
                            let kept_m = room_m(p);
                            assert!(
                                kept_m >= floor_m - 1e-6,
                                "{name} {:?}: {kept_m} of {floor_m} at {p:?}, inflation {inflation_m}\n{:?}\n{:?}",
                                stages.len(),
                                plan.path,
                                plan.cells
                            );
                        }
                    }
                }
            }
        }
        assert!(found > 300, "{found}");
    }

    #[test]
    fn a_start_beside_its_cells_centre_joins_the_path_where_it_has_a_clear_way() {
        // A gap of 1 m between blocks; the start stands half a cell off its cell's centre, to the left of the gap.
        let map = OccupancyGrid::from_ascii(
            &[
                "............",
                "....##......",
                "....##......",
                "............",
                "....##......",
                "....##......",
                "............",
            ],
            1.0,
        );
        let (robot, belief) = (Robot::default(), Belief::from(&map));
        let grid = PlanningGrid::new(&map, belief.field(), 0.3);
        let (start, goal) = (v(3.54, 3.97), v(10.5, 3.5));
        let situation = Situation::new(&robot, &belief, Pose { position: start, theta: 0.0 }, goal);
        let task = Task { situation: &situation, grid: &grid, start, goal };
        let mut plan = Plan::default();
        let mut planner = GlobalChoice::by_name("a_star").unwrap().build();
        find_path(&mut *planner, &mut [], &task, &mut plan).unwrap();
        let nodes: Vec<Vec2> = plan.path.vertices().collect();
        // From (3.54, 3.97) to (4.166, 3.5) the line passes the corner (4, 4) at 0.235 / 0.783 = 0.300 m.
        assert!(nodes.len() == 3 && nodes[1].y == 3.5 && (nodes[1].x - 4.166).abs() < 1e-3, "{nodes:?}");
        assert!(plan.path.segments().all(|(from, piece)| grid.clearance(from, piece.end()) >= 0.3 - 1e-9));
    }

    #[test]
    fn answers_that_cannot_be_are_the_planners_fault() {
        let map = OccupancyGrid::from_ascii(&["......", "..##..", "..##..", "......"], 1.0);
        let (start, goal) = (v(0.5, 0.5), v(5.5, 3.5));
        let fault = |path: Path| {
            with_task(&map, start, goal, |task| find_path(&mut Answers(path), &mut [], task, &mut Plan::default()))
        };
        assert_eq!(fault(Path::polyline(&[start, v(0.5, 3.5), goal])), Ok(()));
        for (path, words) in [
            (Path::polyline(&[v(1.5, 0.5), goal]), "begins at"),
            (Path::polyline(&[start, v(5.5, 0.5)]), "ends at"),
            (Path::polyline(&[start, v(f64::NAN, 1.0), goal]), "not finite"),
            (Path::polyline(&[start, v(2.5, 0.5), v(2.5, 3.5), goal]), "passes through a blocked cell"),
        ] {
            let answer = fault(path);
            assert!(matches!(&answer, Err(Failure::Fault(what)) if what.contains(words)), "{answer:?}");
        }
    }

    /// A stage that goes straight to the goal.
    struct Straight {
        keeps_off: bool,
    }

    impl PathStage for Straight {
        fn apply(&mut self, task: &Task<'_>, _: &Path) -> Result<Path, Failure> {
            Ok(Path::polyline(&[task.start, task.goal]))
        }

        fn keeps_off_obstacles(&self) -> bool {
            self.keeps_off
        }
    }

    #[test]
    fn a_stage_without_a_check_may_lead_through_obstacles_and_one_with_a_check_may_not() {
        let map = OccupancyGrid::from_ascii(&["......", "..##..", "..##..", "......"], 1.0);
        let (start, goal) = (v(0.5, 1.5), v(5.5, 1.5));
        let round = Path::polyline(&[start, v(0.5, 0.5), v(5.5, 0.5), goal]);
        let ask = |keeps_off: bool| {
            let mut stages: [Box<dyn PathStage>; 1] = [Box::new(Straight { keeps_off })];
            let mut plan = Plan::default();
            let answer = with_task(&map, start, goal, |task| {
                find_path(&mut Answers(round.clone()), &mut stages, task, &mut plan)
            });
            (answer, plan.path.length())
        };
        assert_eq!(ask(false), (Ok(()), 5.0));
        assert!(
            matches!(ask(true).0, Err(Failure::Fault(what)) if what.contains("the path of stage 0 passes through"))
        );
    }

    #[test]
    fn more_than_the_budget_is_out_of_budget() {
        let map = OccupancyGrid::empty(6, 4, 1.0);
        let (start, goal) = (v(0.5, 0.5), v(5.5, 3.5));
        let ask = |expansions: u64| {
            with_task(&map, start, goal, |task| {
                let mut situation = *task.situation;
                situation.budget.expansions = expansions;
                let task = Task { situation: &situation, ..*task };
                find_path(&mut Answers(Path::polyline(&[start, goal])), &mut [], &task, &mut Plan::default())
            })
        };
        assert_eq!((ask(10), ask(9)), (Ok(()), Err(Failure::OutOfBudget)));
    }

    #[test]
    fn named_nodes_and_times_are_not_joined_away() {
        let map = OccupancyGrid::empty(6, 4, 1.0);
        let straight = Path::polyline(&[v(0.5, 0.5), v(2.5, 0.5), v(4.5, 0.5)]);
        let grid = uninflated(&map);
        for (path, pieces) in [
            (straight.clone(), 1),
            (straight.clone().with_times(vec![1.0, 2.0]), 2),
            (straight.clone().with_key_nodes(&[v(0.5, 0.5), v(2.5, 0.5), v(4.5, 0.5)]), 2),
            (Path::polyline(&[v(0.5, 0.5), v(2.5, 0.5), v(1.5, 0.5)]), 2), // it turns back
        ] {
            let mut joined = path;
            join(&mut joined, &grid);
            assert_eq!(joined.pieces().len(), pieces);
        }
    }
}
