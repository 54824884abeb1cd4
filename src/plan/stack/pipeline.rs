//! From a task to the path that is driven: global planner, path stages, checks. `simrun plan` and episodes share it.

use crate::geometry::{Path, Piece, Vec2, cross};
use crate::map::Cell;
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::contract::{Failure, GlobalPlanner, PathStage, Plan, Situation, Task};

/// Plans with `global` and treats the path with `stages`, in their order, into `plan`.
///
/// # Errors
/// What the planner or a stage says, and [`Failure::Fault`] for an answer that cannot be.
pub fn find_path(
    global: &mut dyn GlobalPlanner,
    stages: &mut [Box<dyn PathStage>],
    task: &Task<'_>,
    plan: &mut Plan,
) -> Result<(), Failure> {
    let situation = Situation { random: task.situation.random.of_layer(0), ..*task.situation };
    global.plan(&Task { situation: &situation, ..*task }, plan)?;
    if plan.effort.expanded > task.situation.budget.expansions {
        return Err(Failure::OutOfBudget);
    }
    check(&plan.path, task).map_err(|what| Failure::Fault(format!("the planned path {what}")))?;
    for (number, stage) in stages.iter_mut().enumerate() {
        let situation = Situation { random: task.situation.random.of_layer(2 + number as u64), ..*task.situation };
        plan.path = stage.apply(&Task { situation: &situation, ..*task }, &plan.path)?;
        check(&plan.path, task).map_err(|what| Failure::Fault(format!("the path of stage {number} {what}")))?;
    }
    Ok(())
}

impl Plan {
    /// Makes the path of [`Self::cells`]: from the task's start by the centres of the cells to its goal. The centre of the
    /// start's own cell is no node, or a robot that plans anew would turn back to it; nor is that of the goal's.
    pub fn follow_cells(&mut self, task: &Task<'_>) {
        self.path = Path::polyline(&bends(task.grid, &self.cells, task.start, task.goal));
    }
}

/// The nodes of a path of cells at which it turns, with the task's own start and goal.
fn bends(grid: &PlanningGrid, cells: &[Cell], from: Vec2, goal: Vec2) -> Vec<Vec2> {
    let mut nodes = vec![from];
    for at in 1..cells.len().saturating_sub(1) {
        let (before, here, after) = (cells[at - 1], cells[at], cells[at + 1]);
        let arriving = ((here.col - before.col), (here.row - before.row));
        let leaving = ((after.col - here.col), (after.row - here.row));
        let turns = i64::from(arriving.0) * i64::from(leaving.1) != i64::from(arriving.1) * i64::from(leaving.0);
        let reverses = arriving.0 * leaving.0 + arriving.1 * leaving.1 < 0;
        if turns || reverses {
            nodes.push(grid.centre(here));
        }
    }
    nodes.push(goal);
    nodes
}

/// How far a path may reach into a blocked square, cells. A step past a corner that the planner may cut, from a start beside
/// the centre of its cell, stays below it; a path through a wall does not.
const INTRUSION_CELLS: f64 = 0.4;

/// Whether a path runs from the task's start to its goal through passable cells; else what is wrong.
///
/// Nearer than two cells to either end anything goes: there the robot itself may stand in the inflated zone.
fn check(path: &Path, task: &Task<'_>) -> Result<(), String> {
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
    let side_m = task.grid.resolution_m();
    let is_near_end = |p: Vec2| (p - task.start).norm() < 2.0 * side_m || (p - task.goal).norm() < 2.0 * side_m;
    let intrudes = |p: Vec2| {
        let cell = task.grid.cell_at(p);
        let offset = (p - task.grid.centre(cell)) / side_m;
        let depth = 0.5 - math::max(offset.x.abs(), offset.y.abs());
        depth > INTRUSION_CELLS && !task.grid.is_passable(cell) && !is_near_end(p)
    };
    for (from, piece) in path.segments() {
        let steps = (piece.length(from) / (0.2 * side_m)).ceil().clamp(1.0, 1e6) as u32;
        if let Some(p) = (0..=steps).map(|k| piece.chord_point(from, k, steps)).find(|&p| intrudes(p)) {
            return Err(format!("passes through a blocked cell at {:?}", p.as_slice()));
        }
    }
    Ok(())
}

/// `path` with lines that go straight on joined: key nodes and times stay. The first and the last leg are judged by the centres
/// of the start's and the goal's cells, between which a planner on the grid has gone straight.
#[expect(dead_code, reason = "in force with the next commit")]
fn joined(path: Path, grid: &PlanningGrid) -> Path {
    if path.has_named_nodes() || !path.times_s().is_empty() || path.pieces().len() < 2 {
        return path;
    }
    let ends = [path.start(), path.end()].map(|p| grid.centre(grid.cell_at(p)));
    let last = path.pieces().len() - 1;
    let mut pieces: Vec<Piece> = Vec::with_capacity(path.pieces().len());
    for (index, (from, piece)) in path.segments().enumerate() {
        let goes_on = match (pieces.last(), piece) {
            (Some(Piece::Line { .. }), Piece::Line { to }) => {
                let before = if index == 1 { ends[0] } else { path.vertices().nth(index - 1).unwrap_or(from) };
                let after = if index == last { ends[1] } else { *to };
                let (arriving, leaving) = (from - before, after - from);
                let slack = 1e-9 * arriving.norm() * leaving.norm();
                cross(arriving, leaving).abs() <= slack && arriving.dot(&leaving) >= 0.0
            }
            _ => false,
        };
        if goes_on {
            pieces.pop();
        }
        pieces.push(piece.clone());
    }
    Path::new(path.start(), pieces)
}
