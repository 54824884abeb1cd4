//! Checks beyond single values: numbers that contradict each other, and the scenario against its map.

use super::error::ScenarioError;
use super::file::similar_files;
use super::key_path::KeyPath;
use super::memory::{Memory, cells_given};
use super::{GoalSpec, Scenario, Stacks, ranges};
use crate::episode::Arrive;
use crate::files;
use crate::geometry::Vec2;
use crate::map::connectivity::Components;
use crate::map::{DRAWING_BYTES_MAX, MapError};
use crate::math;
use crate::plan::PlanningGrid;
use crate::plan::contract::Fit;
use crate::rng::EpisodeSeed;
use crate::robot::Robot;
use crate::world::script::EventChoice;
use crate::world::{INSIDE_KNOWN, SceneError, StaticMap, UnknownStatic};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

impl Scenario {
    /// Checks that every number lies in the range of its unit and that no two contradict each other, as far as this can be checked
    /// without the map.
    ///
    /// # Errors
    /// Every contradiction, with the keys at fault.
    pub fn consistent(&self) -> Result<(), ScenarioError> {
        ScenarioError::all(self.contradictions(), "")
    }

    pub(super) fn contradictions(&self) -> Vec<ScenarioError> {
        let checks = [
            self.consistent_speeds(),
            self.consistent_metrics(),
            self.consistent_termination(),
            self.consistent_actuation(),
            self.consistent_stacks(),
            self.sweep.consistent(),
        ];
        self.out_of_range().into_iter().chain(checks.into_iter().filter_map(Result::err)).collect()
    }

    /// The numbers outside of the ranges of their units.
    pub(super) fn out_of_range(&self) -> Vec<ScenarioError> {
        ranges::faults(&serde_json::to_value(self).expect("a scenario is names and finite numbers"))
    }

    fn consistent_speeds(&self) -> Result<(), ScenarioError> {
        let (reverse, forward) = (self.limits.reverse_speed_max_mps.get(), self.limits.speed_max_mps.get());
        if reverse <= forward {
            return Ok(());
        }
        Err(contradiction(
            format!("the robot would be faster in reverse ({reverse} m/s) than forward ({forward} m/s)"),
            ("limits.reverse_speed_max_mps", reverse),
            ("limits.speed_max_mps", forward),
        ))
    }

    fn consistent_metrics(&self) -> Result<(), ScenarioError> {
        let (near, encounter) = (self.metrics.near_miss_m.get(), self.metrics.encounter_m.get());
        if near <= encounter {
            return Ok(());
        }
        Err(contradiction(
            format!("a near miss ({near} m) would be farther away than an encounter ({encounter} m)"),
            ("metrics.near_miss_m", near),
            ("metrics.encounter_m", encounter),
        ))
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

    /// Checks that a heading of a goal counts for something.
    fn check_heading(&self) -> Result<(), ScenarioError> {
        if self.termination.arrive == Arrive::Stand {
            return Ok(());
        }
        let of_script = self.script.iter().position(|entry| match &entry.event {
            EventChoice::goal(goal) => goal.heading_rad.is_some(),
            _ => false,
        });
        let key = match (&self.goal, of_script) {
            (GoalSpec::Pose(_), _) => KeyPath::parse("goal"),
            (_, Some(entry)) => KeyPath::parse(&format!("script[{entry}].event.goal.heading_rad")),
            _ => return Ok(()),
        };
        Err(ScenarioError::new("a heading at the goal, and a robot that need not stop there")
            .key_labelled(key, "this heading would count for nothing")
            .help("set `termination: {arrive: stand}`, or leave out the heading"))
    }

    fn consistent_actuation(&self) -> Result<(), ScenarioError> {
        const LATENCY_TICKS_MAX: u32 = 1000;
        let latency = self.actuation.latency_ticks.get();
        if latency > LATENCY_TICKS_MAX {
            return Err(ScenarioError::new(format!("commands would take {latency} ticks to arrive"))
                .key(KeyPath::parse("actuation.latency_ticks"))
                .label(format!("expected at most {LATENCY_TICKS_MAX} ticks of the control period")));
        }
        for (key, [low, high]) in [("slip_left", self.actuation.slip_left), ("slip_right", self.actuation.slip_right)] {
            if low > high {
                return Err(ScenarioError::new(format!(
                    "expected [lowest, highest], found [{}, {}]",
                    low.get(),
                    high.get()
                ))
                .key(KeyPath::parse("actuation").key(key))
                .label("the first number is the larger"));
            }
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
    /// paths in the scenario are relative to `folder`. The effect of unknown obstacles on the way is not
    /// checked; if start or goal is random, the way is not checked at all.
    ///
    /// # Errors
    /// If the map cannot be loaded, the robot does not fit at the start, the goal is out of reach, or
    /// the known map has no way between the two; every fault that does not follow from another.
    pub fn check(&self, folder: &Path) -> Result<(), ScenarioError> {
        self.check_within(folder, &mut Memory::default())
    }

    /// As [`Self::check`]; nothing is loaded for which there is no memory.
    pub(super) fn check_within(&self, folder: &Path, memory: &mut Memory) -> Result<(), ScenarioError> {
        match self.load_map(folder, memory)? {
            Some(map) => self.check_on(&map, folder),
            None => Ok(()),
        }
    }

    /// The map of episode 0, for [`Self::check_on`]; `None` if no acceptable map was drawn for it.
    pub(super) fn load_map(&self, folder: &Path, memory: &mut Memory) -> Result<Option<StaticMap>, ScenarioError> {
        let given = cells_given(self);
        given.map_or(Ok(()), |cells| memory.check(self, cells, folder))?;
        match self.map.load(folder, EpisodeSeed { seed: self.seed, episode: 0 }) {
            Ok(grid) => {
                // Of files and mazes the grid alone is there by now, the smallest part.
                let cells = grid.occupied().len() as u64;
                given.map_or_else(|| memory.check(self, cells, folder), |_| Ok(()))?;
                Ok(Some(StaticMap::new(grid)))
            }
            // What one episode draws says nothing of the others: it is a result and not a fault.
            Err(MapError::Infeasible { .. }) => Ok(None),
            Err(error) => Err(self.map_error(error)),
        }
    }

    /// Checks the scenario against `map`, which is its own.
    pub(super) fn check_on(&self, map: &StaticMap, folder: &Path) -> Result<(), ScenarioError> {
        let robot = Robot::new(&self.robot, &self.limits);
        let mut errors: Vec<ScenarioError> = self.check_heading().err().into_iter().collect();
        let in_scene = match self.scene_spec(folder) {
            Ok(scene) => scene.faults(map, &robot),
            Err(error) => vec![error],
        };
        let is_placed = !in_scene.iter().any(|error| ["start", "goal"].contains(&error.key.as_str()));
        errors.extend(in_scene.into_iter().map(|error| self.scene_error(error, map, &robot, folder)));
        errors.extend(self.planner_faults(map, &robot));
        if is_placed && let (Some(start), Some(goal)) = self.ends(map) {
            errors.extend(self.check_ends(map, start, goal).err());
        }
        ScenarioError::all(errors, "")
    }

    /// Start and goal, where they are given.
    fn ends(&self, map: &StaticMap) -> (Option<Vec2>, Option<Vec2>) {
        (self.start.given(&map.grid).map(|(position, _)| position), self.goal.given(&map.grid))
    }

    /// The error for an impossible part of the scene.
    fn scene_error(&self, mut error: SceneError, map: &StaticMap, robot: &Robot, folder: &Path) -> ScenarioError {
        let (start, goal) = self.ends(map);
        let end = if error.key == "start" { start } else { goal.filter(|_| error.key == "goal") };
        if end.is_some_and(|end| self.map.kind().is_unknown(folder, map.grid.cell_at(end))) {
            let unknown = "lies on an unknown cell of the map, which counts as occupied";
            error.message = error.message.replace(INSIDE_KNOWN, unknown);
        }
        let refused = ScenarioError::new(format!("`{}`: {}", error.key, error.message)).key(KeyPath::parse(&error.key));
        match (error.key.as_str(), start, goal) {
            ("start", ..) if robot.footprint.is_some() => {
                refused.help("give it another heading, or a place with more room")
            }
            ("start", Some(place), _) | ("goal", _, Some(place)) => {
                let unknown = self.obstacles.given_statics(&map.grid);
                nearest_fit(refused, map, &unknown, place, robot.inscribed_radius_m())
            }
            (key, ..) if key.ends_with(".position") || key.ends_with(".pose") => refused.help("move it to free floor"),
            _ => refused,
        }
    }

    /// Checks that start and goal are apart, and that a way leads from one to the other.
    fn check_ends(&self, map: &StaticMap, start: Vec2, goal: Vec2) -> Result<(), ScenarioError> {
        let tolerance = self.termination.goal_tolerance_m.get();
        let distance = rounded((goal - start).norm());
        if distance <= tolerance && self.goal.heading_rad(&map.grid).is_none() {
            return Err(ScenarioError::new("the robot starts at its goal")
                .key_labelled(KeyPath::parse("goal"), format!("{distance} m from `start`"))
                .key_labelled(KeyPath::parse("start"), format!("{distance} m from `goal`"))
                .note(format!("`termination.goal_tolerance_m` is {tolerance}: nearer than that has arrived"))
                .help("move them apart"));
        }
        self.check_way(map, start, goal)
    }

    /// Checks the parameters of every planner against `map`, which is the scenario's own, and the robot.
    pub(super) fn check_planners(&self, map: &StaticMap) -> Result<(), ScenarioError> {
        ScenarioError::all(self.planner_faults(map, &Robot::new(&self.robot, &self.limits)), "")
    }

    /// The planners whose parameters do not fit the map and the robot.
    fn planner_faults(&self, map: &StaticMap, robot: &Robot) -> Vec<ScenarioError> {
        let fit = Fit { map: &map.grid, robot, dt_s: self.control_period_s.get() };
        let mut faults = Vec::new();
        let mut ask = |key: KeyPath, name: &str, answer: Result<(), String>| {
            faults.extend(answer.err().map(|message| {
                ScenarioError::new(format!("`{name}`: {message}")).key(key).label("does not fit this map and robot")
            }));
        };
        let in_product = |list: &str, item: usize| KeyPath::parse("stacks").key(list).item(item);
        match &self.stacks {
            Stacks::Product(product) => {
                for (item, choice) in product.global.iter().enumerate() {
                    if let Some(choice) = &choice.0 {
                        ask(in_product("global", item), choice.name(), choice.kind().check(&fit));
                    }
                }
                for (item, stages) in product.path.iter().enumerate() {
                    for (stage, choice) in stages.iter().enumerate() {
                        ask(in_product("path", item).item(stage), choice.name(), choice.kind().check(&fit));
                    }
                }
                for (item, choice) in product.local.iter().enumerate() {
                    ask(in_product("local", item), choice.name(), choice.kind().check(&fit));
                }
            }
            Stacks::List(stacks) => {
                for (item, stack) in stacks.iter().enumerate() {
                    let key = |part: &str| KeyPath::parse("stacks").item(item).key(part);
                    if let Some(choice) = &stack.global.0 {
                        ask(key("global"), choice.name(), choice.kind().check(&fit));
                    }
                    for (stage, choice) in stack.path.iter().enumerate() {
                        ask(key("path").item(stage), choice.name(), choice.kind().check(&fit));
                    }
                    ask(key("local"), stack.local.name(), stack.local.kind().check(&fit));
                }
            }
        }
        faults
    }

    /// Checks that the planning grid has a way from the start to the goal.
    fn check_way(&self, map: &StaticMap, start: Vec2, goal: Vec2) -> Result<(), ScenarioError> {
        let grid = &map.grid;
        let (start, goal) = (grid.cell_at(start), grid.cell_at(goal));
        let is_way = |inflation_m: f64| {
            let mut planning = PlanningGrid::new(grid, &map.field, inflation_m);
            planning.open_around(grid, start);
            planning.open_around(grid, goal);
            let passable: Vec<bool> =
                (0..grid.occupied().len()).map(|index| planning.is_passable(grid.cell(index))).collect();
            Components::new(grid, &passable).connected(grid.index(start), grid.index(goal))
        };
        let inflation_m = self.planning.inflation_m(Robot::new(&self.robot, &self.limits).radius_m);
        if is_way(inflation_m) {
            return Ok(());
        }
        let refused = ScenarioError::new("no path leads from the start to the goal")
            .key_labelled(KeyPath::parse("goal"), "cannot be reached from `start`")
            .key_labelled(KeyPath::parse("start"), "`goal` cannot be reached from here");
        Err(if inflation_m > 0.0 && is_way(0.0) {
            refused
                .note(format!("planned paths keep {inflation_m} m from obstacles, and every way between the two is narrower"))
                .help("widen the passage, or lower `planning.inflation_m` (by default the robot's radius and 0.05 m) or `robot.radius_m`")
        } else {
            refused
                .note("obstacles of the known map part the two")
                .help("move one of them, or open the map between them")
        })
    }

    /// The error for a map that cannot be loaded; a fault inside a map file is shown there.
    fn map_error(&self, error: MapError) -> ScenarioError {
        let map = KeyPath::parse("map").key(self.map.name());
        match error {
            MapError::File { file, source } => match *source {
                MapError::Format { line, column, found, expected, advice } => {
                    let text = files::text(&file, DRAWING_BYTES_MAX).unwrap_or_default();
                    ScenarioError::new(format!("the map file is broken: found {found}, expected {expected}"))
                        .key(map.key("file"))
                        .label(format!("expected {expected}"))
                        .help(advice)
                        .at(Some(file.display().to_string()), &text, span_at(&text, line, column))
                }
                MapError::Header { line, column, message } => {
                    let text = files::text(&file, DRAWING_BYTES_MAX).unwrap_or_default();
                    ScenarioError::new(format!("the header of the map is broken: {message}"))
                        .key(map.key("file"))
                        .label("here")
                        .at(Some(file.display().to_string()), &text, span_at(&text, line, column))
                }
                MapError::Read { source } => {
                    let refused = |title: String| ScenarioError::new(title).key(map.key("file")).label("this file");
                    if !source.is_missing() {
                        return refused(format!("cannot read the map file {}: {source}", file.display()));
                    }
                    let missing = refused(format!("there is no map file {}", file.display()))
                        .note("the path is relative to the folder of the scenario file");
                    match similar_files(&file) {
                        Some(files) => missing.help(files),
                        None => missing,
                    }
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

/// Adds the extent of the map, and the cell centre nearest to `p` on which a disc fits beside the given unknown statics as well (ties:
/// the first row by row).
fn nearest_fit(
    error: ScenarioError,
    map: &StaticMap,
    unknown: &[UnknownStatic],
    p: Vec2,
    radius_m: f64,
) -> ScenarioError {
    let grid = &map.grid;
    let origin = grid.frame().origin;
    let turned = if origin.theta == 0.0 { String::new() } else { format!(", turned by {} rad", origin.theta) };
    let error = error.note(format!(
        "the map has {} × {} cells of {} m, its lower left corner at [{}, {}]{turned}",
        grid.cols(),
        grid.rows(),
        grid.resolution_m(),
        origin.position.x,
        origin.position.y
    ));
    let cells = (0..grid.occupied().len()).map(|index| grid.cell(index));
    let fitting = cells.filter(|&cell| map.field.distance_m(cell) >= radius_m).map(|cell| grid.centre(cell));
    let fitting = fitting.filter(|&centre| unknown.iter().all(|obstacle| obstacle.distance_m(centre) >= radius_m));
    match fitting.min_by(|a, b| (a - p).norm_squared().total_cmp(&(b - p).norm_squared())) {
        Some(fit) => {
            let at = grid.frame().point_to_world(fit);
            error.help(format!("the nearest cell where the robot fits is at [{}, {}]", rounded(at.x), rounded(at.y)))
        }
        None => {
            error.help("the robot fits nowhere on this map: are `robot.radius_m` and the map's `resolution_m` right?")
        }
    }
}

/// A length for people, to the millimetre.
fn rounded(metres: f64) -> f64 {
    math::canonical((metres * 1000.0).round() / 1000.0)
}

/// The bytes of the character in a line of a text, both counted from 1; past the end, the last place of the text.
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

/// The list of a product that holds an entry twice.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::ScenarioFile;

    /// A room of 10 m by 5 m with a wall in the middle: whole at `gap` 0, else with a door of `gap` cells of 0.25 m.
    fn scenario(gap: usize, more: &str) -> ScenarioFile {
        let row = |row: usize| {
            let is_wall = !(10..10 + gap).contains(&row);
            format!("\"{}{}{}\"", ".".repeat(20), if is_wall { "#" } else { "." }, ".".repeat(19))
        };
        let rows: Vec<String> = (0..20).map(row).collect();
        let text = format!(
            "map: {{ascii: {{rows: [{}], resolution_m: 0.25}}}}\nstacks: {{global: [a_star], local: [dwa]}}\n{more}",
            rows.join(", ")
        );
        ScenarioFile::from_text("room.yaml", text)
    }

    fn checked(file: &ScenarioFile) -> Result<(), String> {
        file.read(&[]).and_then(|scenario| file.check(&scenario, &[])).map_err(|error| error.to_string())
    }

    const ENDS: &str = "start: [1, 2]\ngoal: [9, 2]\n";

    #[test]
    fn a_way_through_the_door_is_valid_and_a_wall_is_not() {
        checked(&scenario(6, ENDS)).unwrap();
        let error = checked(&scenario(0, ENDS)).unwrap_err();
        assert!(error.contains("no path leads from the start to the goal"), "{error}");
        assert!(error.contains("obstacles of the known map part the two"), "{error}");
    }

    #[test]
    fn a_door_narrower_than_the_inflation_is_named_as_that() {
        // A door of 0.5 m: the middle of it is 0.25 m from the wall, the default inflation 0.3 m.
        let error = checked(&scenario(2, ENDS)).unwrap_err();
        assert!(error.contains("planned paths keep 0.3 m from obstacles"), "{error}");
        checked(&scenario(2, &format!("{ENDS}planning: {{inflation_m: 0}}"))).unwrap();
    }

    #[test]
    fn a_start_in_the_wall_is_told_where_the_robot_fits() {
        // The wall is the column from 5 to 5.25 m; a disc of 0.25 m fits at the centres beside it.
        let error = checked(&scenario(0, "start: [5.05, 1.1]\ngoal: [9, 2]\n")).unwrap_err();
        assert!(error.contains("`start`") && error.contains("room.yaml:3"), "{error}");
        assert!(error.contains("the nearest cell where the robot fits is at [4.625, 1.125]"), "{error}");
    }

    #[test]
    fn a_start_at_the_goal_is_refused_with_the_distance() {
        let error = checked(&scenario(0, "start: [1, 2]\ngoal: [1.2, 2]\n")).unwrap_err();
        assert!(error.contains("starts at its goal") && error.contains("0.2 m"), "{error}");
        checked(&scenario(0, "start: [1, 2]\ngoal: [1.3, 2]\n")).unwrap();
    }

    #[test]
    fn numbers_that_contradict_each_other_name_both_keys() {
        for (more, keys) in [
            ("limits: {reverse_speed_max_mps: 2}", ["limits.reverse_speed_max_mps", "limits.speed_max_mps"]),
            ("metrics: {near_miss_m: 3}", ["metrics.near_miss_m", "metrics.encounter_m"]),
            ("termination: {timeout_s: 20}", ["termination.stuck_after_s", "termination.timeout_s"]),
        ] {
            let error = scenario(0, more).read(&[]).unwrap_err();
            let named: Vec<String> = error.keys().map(KeyPath::to_string).collect();
            assert_eq!(named, keys, "{error}");
        }
        // Equal bounds contradict nothing.
        scenario(0, "limits: {reverse_speed_max_mps: 1}\ntermination: {timeout_s: 30}").read(&[]).unwrap();
    }

    #[test]
    fn an_empty_list_of_planners_is_named_by_its_key() {
        for (stacks, key) in [
            ("{global: [], local: [dwa]}", "stacks.global"),
            ("{global: [a_star], local: []}", "stacks.local"),
            ("{global: [a_star], path: [], local: [dwa]}", "stacks.path"),
            ("[]", "stacks"),
        ] {
            let text = format!("map: {{empty: {{cols: 9, rows: 9}}}}\nstacks: {stacks}\n");
            let error = ScenarioFile::from_text("empty.yaml", text).read(&[]).unwrap_err();
            assert_eq!(error.keys().map(KeyPath::to_string).collect::<Vec<_>>(), [key], "{error}");
        }
    }

    #[test]
    fn a_character_of_a_text_is_found_by_line_and_column() {
        let text = "ab\né#x\n";
        assert_eq!(&text[span_at(text, 2, 2)], "#");
        assert_eq!(&text[span_at(text, 2, 1)], "é");
        assert_eq!(span_at(text, 2, 9), 7..7, "behind the line's end");
    }
}
