//! What no single value shows: numbers that contradict each other, and what the map says.

use super::error::ScenarioError;
use super::file::similar_files;
use super::key_path::KeyPath;
use super::{Scenario, Stacks};
use crate::geometry::Vec2;
use crate::map::connectivity::Components;
use crate::map::{Cell, DistanceField, MapError, OccupancyGrid};
use crate::math;
use crate::plan::PlanningGrid;
use crate::quantity::NonNegative;
use crate::rng::EpisodeSeed;
use crate::world::spec::{CellPlace, GoalSpec, StartSpec};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

impl Scenario {
    /// Checks what can be checked without the map: that no two values contradict each other.
    ///
    /// # Errors
    /// The first contradiction, with the keys at fault.
    pub fn consistent(&self) -> Result<(), ScenarioError> {
        self.consistent_limits()?;
        self.consistent_termination()?;
        self.consistent_stacks()
    }

    fn consistent_limits(&self) -> Result<(), ScenarioError> {
        let (reverse, forward) = (self.limits.reverse_speed_max_mps.get(), self.limits.speed_max_mps.get());
        if reverse > forward {
            return Err(contradiction(
                format!("the robot would be faster in reverse ({reverse} m/s) than forward ({forward} m/s)"),
                ("limits.reverse_speed_max_mps", reverse),
                ("limits.speed_max_mps", forward),
            ));
        }
        let (near, encounter) = (self.metrics.near_miss_m.get(), self.metrics.encounter_m.get());
        if near > encounter {
            return Err(contradiction(
                format!("a near miss ({near} m) would be farther away than an encounter ({encounter} m)"),
                ("metrics.near_miss_m", near),
                ("metrics.encounter_m", encounter),
            ));
        }
        Ok(())
    }

    fn consistent_termination(&self) -> Result<(), ScenarioError> {
        let termination = &self.termination;
        if termination.goal_tolerance_m.get() == 0.0 {
            return Err(ScenarioError::new("no robot arrives at a goal of tolerance 0")
                .key(KeyPath::parse("termination.goal_tolerance_m"))
                .label("expected a distance above 0")
                .help("the robot moves in steps of a tenth of a second: 0.25 m is usual"));
        }
        if let Some(timeout) = termination.timeout_s
            && termination.stuck_after_s > timeout
        {
            let (stuck, timeout) = (termination.stuck_after_s.get(), timeout.get());
            return Err(contradiction(
                format!("the time-out ({timeout} s) would come before the robot can be stuck ({stuck} s)"),
                ("termination.stuck_after_s", stuck),
                ("termination.timeout_s", timeout),
            ));
        }
        Ok(())
    }

    fn consistent_stacks(&self) -> Result<(), ScenarioError> {
        let specs = self.stacks();
        if specs.is_empty() {
            let (key, what) = match &self.stacks {
                Stacks::List(_) => ("stacks", "stack"),
                Stacks::Product(product) if product.global.is_empty() => ("stacks.global", "global planner"),
                Stacks::Product(product) if product.path.is_empty() => ("stacks.path", "path treatment"),
                Stacks::Product(_) => ("stacks.local", "local planner"),
            };
            let help = match what {
                "path treatment" => "`path: [[]]` drives along paths as they were planned",
                _ => "name at least one; `simrun planners` lists them",
            };
            return Err(ScenarioError::new(format!("`{key}` names no {what}"))
                .key(KeyPath::parse(key))
                .label("empty")
                .help(help));
        }
        let mut first_of: BTreeMap<&str, usize> = BTreeMap::new();
        for (i, spec) in specs.iter().enumerate() {
            let Some(first) = first_of.insert(&spec.name, i) else { continue };
            let refused = ScenarioError::new(format!("two stacks are called `{}`", spec.name));
            return Err(match &self.stacks {
                Stacks::List(_) => refused
                    .key(KeyPath::parse("stacks").item(i))
                    .label(format!("the same name as `stacks[{first}]`"))
                    .help("give one of them a `name` of its own"),
                Stacks::Product(product) => refused
                    .key(KeyPath::parse("stacks").key(repeated(product)))
                    .label("gives equal names")
                    .help("write the stacks as a list and name them: `- {name: …, global: …, local: …}`"),
            });
        }
        Ok(())
    }

    /// Checks the scenario against its map, which is read or (for episode 0) generated for that;
    /// paths in the scenario are relative to `folder`. What unknown obstacles do to the way is not
    /// checked, and where start or goal is random, the way is not either.
    ///
    /// # Errors
    /// If the map cannot be had, the robot does not fit at the start, the goal is out of reach, or
    /// the known map has no way between the two.
    pub fn check(&self, folder: &Path) -> Result<(), ScenarioError> {
        let grid = match self.map.load(folder, EpisodeSeed { seed: self.seed, episode: 0 }) {
            Ok(grid) => grid,
            // What one episode draws says nothing of the others: it is a result and not a fault.
            Err(MapError::Infeasible { .. }) => return Ok(()),
            Err(error) => return Err(self.map_error(error)),
        };
        let start = match &self.start {
            StartSpec::Random(_) => None,
            StartSpec::Position([x, y]) | StartSpec::Pose([x, y, _]) => Some(in_grid(&grid, [x.get(), y.get()])),
            StartSpec::Cell(cell) => Some(centre_of(&grid, cell)),
        };
        let goal = match &self.goal {
            GoalSpec::Random(_) => None,
            GoalSpec::Position([x, y]) => Some(in_grid(&grid, [x.get(), y.get()])),
            GoalSpec::Cell(cell) => Some(centre_of(&grid, cell)),
        };
        let radius = self.robot.radius_m.get();
        let tolerance = self.termination.goal_tolerance_m.get();
        if let Some(start) = start {
            fits(&grid, "start", start, radius, 0.0)?;
        }
        if let Some(goal) = goal {
            fits(&grid, "goal", goal, radius, tolerance)?;
        }
        let (Some(start), Some(goal)) = (start, goal) else { return Ok(()) };
        let distance = (goal - start).norm();
        if distance <= tolerance {
            return Err(ScenarioError::new("the robot starts at its goal")
                .key_labelled(KeyPath::parse("goal"), format!("{distance} m from `start`"))
                .key_labelled(KeyPath::parse("start"), format!("{distance} m from `goal`"))
                .note(format!("`termination.goal_tolerance_m` is {tolerance}: nearer than that has arrived"))
                .help("move them apart"));
        }
        self.way(&grid, start, goal)
    }

    /// Checks that the planning grid has a way from the start to the goal.
    fn way(&self, grid: &OccupancyGrid, start: Vec2, goal: Vec2) -> Result<(), ScenarioError> {
        let field = DistanceField::new(grid);
        let (start, goal) = (grid.cell_at(start), grid.cell_at(goal));
        let is_way = |inflation_m: f64| {
            let mut planning = PlanningGrid::new(grid, &field, inflation_m);
            planning.open_around(grid, start);
            planning.open_around(grid, goal);
            let passable: Vec<bool> =
                (0..grid.occupied().len()).map(|index| planning.is_passable(grid.cell(index))).collect();
            Components::new(grid, &passable).connected(grid.index(start), grid.index(goal))
        };
        let inflation_m = self.planning.inflation_m.map_or(self.robot.radius_m.get(), NonNegative::get);
        if is_way(inflation_m) {
            return Ok(());
        }
        let refused = ScenarioError::new("no path leads from the start to the goal")
            .key_labelled(KeyPath::parse("goal"), "cannot be reached from `start`")
            .key_labelled(KeyPath::parse("start"), "`goal` cannot be reached from here");
        Err(if inflation_m > 0.0 && is_way(0.0) {
            refused
                .note(format!("planned paths keep {inflation_m} m from obstacles, and every way between the two is narrower"))
                .help("widen the passage, or lower `planning.inflation_m` (by default the robot's radius) or `robot.radius_m`")
        } else {
            refused
                .note("obstacles of the known map part the two")
                .help("move one of them, or open the map between them")
        })
    }

    /// The error for a map that cannot be had; one inside a map file is shown there.
    fn map_error(&self, error: MapError) -> ScenarioError {
        let map = KeyPath::parse("map").key(self.map.name());
        match error {
            MapError::File { file, source } => match *source {
                MapError::Format { line, column, found, expected, advice } => {
                    let text = std::fs::read(&file).unwrap_or_default();
                    let text = String::from_utf8_lossy(&text);
                    ScenarioError::new(format!("the map file is broken: found {found}, expected {expected}"))
                        .key(map.key("file"))
                        .label(format!("expected {expected}"))
                        .help(advice)
                        .at(Some(file.display().to_string()), &text, span_at(&text, line, column))
                }
                MapError::Read { source } => {
                    let mut refused = ScenarioError::new(format!("cannot read the map {}: {source}", file.display()))
                        .key(map.key("file"))
                        .label("this file")
                        .note("the path is relative to the folder of the scenario file");
                    if let Some(files) = similar_files(&file) {
                        refused = refused.help(files);
                    }
                    refused
                }
                other => ScenarioError::new(format!("{}: {other}", file.display())).key(map.key("file")),
            },
            MapError::Contradiction { found, expected, advice, .. } => ScenarioError::new(format!(
                "the sizes of `{map}` do not fit together: found {found}, expected {expected}"
            ))
            .key(map)
            .help(advice),
            other => ScenarioError::new(other.to_string()).key(map),
        }
    }
}

/// A point of the world frame in the grid frame.
fn in_grid(grid: &OccupancyGrid, [x, y]: [f64; 2]) -> Vec2 {
    grid.frame().point_to_grid(Vec2::new(x, y))
}

/// The centre of a cell that may lie outside.
fn centre_of(grid: &OccupancyGrid, cell: &CellPlace) -> Vec2 {
    let [col, row] = cell.0.map(|number| number.get() as i32);
    grid.centre(Cell { col, row })
}

/// Refuses a place (grid frame) outside the map, in an occupied cell, or nearer to one (or to the
/// map's edge) than the robot's radius less `slack_m`.
fn fits(grid: &OccupancyGrid, what: &str, p: Vec2, radius_m: f64, slack_m: f64) -> Result<(), ScenarioError> {
    let cell = grid.cell_at(p);
    let clearance = clearance_m(grid, p, radius_m);
    let error = if !grid.contains(cell) {
        ScenarioError::new(format!("the {what} lies outside the map")).label("outside")
    } else if !grid.is_free(cell) {
        ScenarioError::new(format!("the {what} lies in a wall"))
            .label(format!("cell [{}, {}] is occupied", cell.col, cell.row))
    } else if clearance + slack_m < radius_m - 1e-9 {
        ScenarioError::new(format!("the robot does not fit at the {what}"))
            .label(format!("{clearance:.3} m from the nearest wall"))
            .note(format!("`robot.radius_m` is {radius_m}"))
    } else {
        return Ok(());
    };
    let error = error.key(KeyPath::parse(what)).note(extent(grid));
    Err(match nearest_fitting(grid, p, radius_m) {
        Some(fit) => {
            let at = grid.frame().point_to_world(fit);
            error.help(format!("the nearest cell where it fits is at [{}, {}]", rounded(at.x), rounded(at.y)))
        }
        None => {
            error.help("the robot fits nowhere on this map: is `robot.radius_m` or the map's `resolution_m` right?")
        }
    })
}

/// Distance from `p` inside the map to the nearest occupied square or to the edge, m, if below `cap_m`.
fn clearance_m(grid: &OccupancyGrid, p: Vec2, cap_m: f64) -> f64 {
    let extent = grid.extent_m();
    let edge = [p.x, p.y, extent.x - p.x, extent.y - p.y].into_iter().fold(cap_m, math::min);
    let reach = Vec2::new(cap_m, cap_m);
    let (low, high) = (grid.cell_at(p - reach), grid.cell_at(p + reach));
    let mut nearest = edge;
    for row in low.row.max(0)..=high.row.min(grid.rows() - 1) {
        for col in low.col.max(0)..=high.col.min(grid.cols() - 1) {
            let cell = Cell { col, row };
            if !grid.is_free(cell) {
                nearest = math::min(nearest, grid.square(cell).signed_distance(p));
            }
        }
    }
    nearest
}

/// The cell centre nearest to `p` where a disc fits; the first in row-major order of equals.
fn nearest_fitting(grid: &OccupancyGrid, p: Vec2, radius_m: f64) -> Option<Vec2> {
    let field = DistanceField::new(grid);
    let fitting = (0..grid.occupied().len()).map(|i| grid.cell(i)).filter(|&cell| field.distance_m(cell) >= radius_m);
    let centres = fitting.map(|cell| grid.centre(cell));
    centres.min_by(|a, b| (a - p).norm_squared().total_cmp(&(b - p).norm_squared()))
}

/// Where the map lies, in words.
fn extent(grid: &OccupancyGrid) -> String {
    let corner = grid.frame().origin;
    let heading = if corner.theta == 0.0 { String::new() } else { format!(", turned by {} rad", corner.theta) };
    format!(
        "the map has {} × {} cells of {} m, its lower left corner at [{}, {}]{heading}",
        grid.cols(),
        grid.rows(),
        grid.resolution_m(),
        corner.position.x,
        corner.position.y
    )
}

/// A length for people, to the millimetre.
fn rounded(metres: f64) -> f64 {
    math::canonical((metres * 1000.0).round() / 1000.0)
}

/// The bytes of the character in a line of a text, both counted from 1; past the end, the last place there is.
fn span_at(text: &str, line: usize, column: usize) -> Range<usize> {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let content = text[start..].lines().next().unwrap_or("");
    let (offset, length) =
        content.char_indices().nth(column.saturating_sub(1)).map_or((content.len(), 0), |(i, c)| (i, c.len_utf8()));
    start + offset..start + offset + length
}

/// An error about two numbers of which the first must not be the larger.
fn contradiction(title: String, (small, small_is): (&str, f64), (large, large_is): (&str, f64)) -> ScenarioError {
    ScenarioError::new(title)
        .key_labelled(KeyPath::parse(small), format!("expected at most `{large}`, {large_is}"))
        .key_labelled(KeyPath::parse(large), format!("expected at least `{small}`, {small_is}"))
        .help(format!("lower `{small}` or raise `{large}`"))
}

/// The list of a product in which something stands twice.
fn repeated(product: &super::Product) -> &'static str {
    let twice = |names: Vec<String>| (1..names.len()).any(|i| names[..i].contains(&names[i]));
    if twice(product.local.iter().map(|local| local.name().to_owned()).collect()) {
        "local"
    } else if twice(product.global.iter().map(|global| format!("{:?}", global.0.as_ref().map(|g| g.name()))).collect())
    {
        "global"
    } else {
        "path"
    }
}
