//! All that a planner gets and gives, on one page.
//!
//! ```text
//! global planner   Task (Situation, grid, start, goal)      ──►  Plan: a path in metres, with times where the method has them
//! path stage       Task, every node of the path             ──►  Path
//! local planner    Situation, Guidance (path, key nodes)    ──►  Decision: command, state, effort, notes, request
//! each of them may answer with a Failure instead
//! ```
//!
//! Positions are in the grid frame, metres and radians. An answer may depend on what is passed in and on what the planner kept
//! since its last `reset`, and on nothing else: no clock, no other source of randomness than [`Situation::random`].

use super::PlanningGrid;
use crate::geometry::{KeyNode, Path, Pose, Twist, Vec2, wrap_angle};
use crate::map::{Cell, OccupancyGrid};
use crate::observation::{Belief, Scan, SensedObstacle};
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::robot::Robot;
use serde::{Deserialize, Serialize};

/// Registry entry of a planner or a path stage: its source and its capabilities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// One sentence: what it does and when to use it.
    pub summary: &'static str,
    /// Where it comes from: authors, title, venue, year.
    pub source: &'static str,
    /// Whether its paths are the shortest ones of the grid's graph at its default parameters.
    pub exact: bool,
    /// Whether its paths leave the grid's edges: consecutive vertices need not be neighbours.
    pub any_angle: bool,
    /// Whether it draws random numbers.
    pub random: bool,
    /// Whether it heeds movers, either as standing obstacles or with their predicted motion.
    pub reacts_to_movers: bool,
    /// The states that a local planner can be in; empty for the other layers.
    pub states: &'static [State],
    /// The names of the numbers that a local planner publishes ([`Decision::notes`]), in order.
    pub notes: &'static [&'static str],
}

impl Entry {
    /// An entry without any capability, for `..Entry::PLAIN`.
    pub const PLAIN: Self = Self {
        summary: "",
        source: "",
        exact: false,
        any_angle: false,
        random: false,
        reacts_to_movers: false,
        states: &[],
        notes: &[],
    };
}

/// Random numbers of one planner: a stream of its own, addressed by episode and tick, so that a planner that draws more moves
/// nothing else, and the same planner at the same tick draws the same numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Randomness {
    seed: EpisodeSeed,
    /// 0: global planner; 1: local planner; 2 and on: path stages.
    layer: u64,
    tick: u32,
}

impl Randomness {
    /// The random numbers of the global planner of an episode at one tick.
    pub fn new(seed: EpisodeSeed, tick: u32) -> Self {
        Self { seed, layer: 0, tick }
    }

    /// Random numbers of another layer at the same tick.
    pub(super) fn of_layer(self, layer: u64) -> Self {
        Self { layer, ..self }
    }

    /// The stream, at its beginning for this tick.
    pub fn stream(&self) -> Stream {
        let mut stream = self.seed.stream(Purpose::Planner, self.layer);
        stream.at_tick(self.tick);
        stream
    }
}

/// Limits on the work of one answer, in counts and never in time; without limits by default. An answer that took more counts as
/// [`Failure::OutOfBudget`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Budget {
    /// Nodes that a global planner may expand.
    pub expansions: u64,
    /// Poses that a local planner may simulate.
    pub rollout_points: u64,
}

impl Default for Budget {
    fn default() -> Self {
        Self { expansions: u64::MAX, rollout_points: u64::MAX }
    }
}

/// What counts as arrived at the goal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Arrival {
    /// Distance of the robot's centre from the goal that is near enough, m.
    pub tolerance_m: f64,
    /// Whether the robot has to stand there: below [`Self::SPEED_MPS`] and [`Self::YAW_RATE_RADPS`].
    pub must_stand: bool,
    /// Heading that it has to have where it must stand, grid frame, rad; any where there is none.
    pub heading_rad: Option<f64>,
    /// How far its heading may differ from that one, rad.
    pub heading_tolerance_rad: f64,
}

impl Default for Arrival {
    /// Within 0.25 m, at any speed.
    fn default() -> Self {
        Self { tolerance_m: 0.25, must_stand: false, heading_rad: None, heading_tolerance_rad: 0.1 }
    }
}

impl Arrival {
    /// Speed up to which a robot stands, m/s.
    pub const SPEED_MPS: f64 = 0.05;
    /// Yaw rate up to which a robot stands, rad/s.
    pub const YAW_RATE_RADPS: f64 = 0.1;

    /// Whether `position` is near enough to the goal.
    pub fn is_near(&self, goal: Vec2, position: Vec2) -> bool {
        (goal - position).norm() <= self.tolerance_m
    }

    /// Angle by which a robot that heads for `theta` still has to turn, rad; 0 where any heading will do.
    pub fn turn_left_rad(&self, theta: f64) -> f64 {
        self.heading_rad.map_or(0.0, |heading_rad| wrap_angle(heading_rad - theta))
    }

    /// Whether a robot at `pose` that moves with `twist` has arrived at `goal`.
    pub fn is_met(&self, goal: Vec2, pose: Pose, twist: Twist) -> bool {
        let stands = || twist.v.abs() <= Self::SPEED_MPS && twist.omega.abs() <= Self::YAW_RATE_RADPS;
        self.is_near(goal, pose.position)
            && (!self.must_stand || stands() && self.turn_left_rad(pose.theta).abs() <= self.heading_tolerance_rad)
    }
}

/// All that a planner may know at a tick. Nothing else exists for it.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// The tick, counted from 0; time is `tick * dt_s`.
    pub tick: u32,
    /// Control period, s.
    pub dt_s: f64,
    /// Own pose as believed.
    pub pose: Pose,
    /// Own twist as believed.
    pub twist: Twist,
    /// The robot itself: footprint and limits, lowered by the caps of the stack.
    pub robot: &'a Robot,
    /// The map as believed.
    pub belief: &'a Belief,
    /// Moving obstacles in sensor range, in the order of the scenario.
    pub obstacles: &'a [SensedObstacle],
    /// Moving obstacles that were sensed before and are not now, where they were sensed last; each until the robot sees that it is no
    /// longer there.
    pub remembered: &'a [SensedObstacle],
    /// Ranges of the scanner, if the robot has one.
    pub scan: Option<Scan<'a>>,
    /// Goal of the episode, grid frame, m.
    pub goal: Vec2,
    /// What counts as arrived there.
    pub arrival: Arrival,
    /// The planner's own random numbers.
    pub random: Randomness,
    /// Limits on the work of the answer.
    pub budget: Budget,
}

impl<'a> Situation<'a> {
    /// Standing at `pose` at tick 0 with a control period of 0.1 s; nothing moves, nothing is random, nothing is limited.
    pub fn new(robot: &'a Robot, belief: &'a Belief, pose: Pose, goal: Vec2) -> Self {
        Self {
            tick: 0,
            dt_s: 0.1,
            pose,
            twist: Twist::ZERO,
            robot,
            belief,
            obstacles: &[],
            remembered: &[],
            scan: None,
            goal,
            arrival: Arrival::default(),
            random: Randomness::default(),
            budget: Budget::default(),
        }
    }

    /// Simulated time since `tick`, s.
    pub fn time_since_s(&self, tick: u32) -> f64 {
        f64::from(self.tick - tick) * self.dt_s
    }
}

/// The question put to a global planner or a path stage.
#[derive(Clone, Copy, Debug)]
pub struct Task<'a> {
    /// Everything that the planner may know. Its `goal` is the goal of the episode; the goal of the task may differ.
    pub situation: &'a Situation<'a>,
    /// Cells in which the robot's centre may be.
    pub grid: &'a PlanningGrid,
    /// First point of the path, grid frame, m.
    pub start: Vec2,
    /// Last point of the path, grid frame, m.
    pub goal: Vec2,
}

impl<'a> Task<'a> {
    /// The task with start and goal as cells.
    pub fn problem(&self) -> Problem<'a> {
        Problem { grid: self.grid, start: self.grid.cell_at(self.start), goal: self.grid.cell_at(self.goal) }
    }
}

/// A task in cells, for planners that search the grid.
#[derive(Clone, Copy, Debug)]
pub struct Problem<'a> {
    /// Cells in which the robot's centre may be.
    pub grid: &'a PlanningGrid,
    /// Start cell.
    pub start: Cell,
    /// Goal cell.
    pub goal: Cell,
}

impl Problem<'_> {
    /// Whether start and goal are passable.
    ///
    /// # Errors
    /// [`Failure::StartOccupied`] before [`Failure::GoalOccupied`].
    pub fn check_ends(&self) -> Result<(), Failure> {
        if !self.grid.is_passable(self.start) {
            Err(Failure::StartOccupied)
        } else if !self.grid.is_passable(self.goal) {
            Err(Failure::GoalOccupied)
        } else {
            Ok(())
        }
    }
}

/// Reason why a planner or a path stage has no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
pub enum Failure {
    /// The start is blocked or outside.
    #[error("the start is occupied")]
    StartOccupied,
    /// The goal is blocked or outside.
    #[error("the goal is occupied")]
    GoalOccupied,
    /// Start and goal are not connected.
    #[error("no path exists")]
    NoPath,
    /// The answer took more than the [`Budget`].
    #[error("the planner ran out of its budget")]
    OutOfBudget,
    /// Something is wrong in the planner: the episode ends as `planner_error`.
    #[error("{0}")]
    Fault(String),
}

/// Work of one search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SearchEffort {
    /// Nodes popped and expanded, re-expansions included; the goal that ends the search is not expanded.
    pub expanded: u64,
    /// Nodes pushed, the start and every cheaper connection included.
    pub generated: u64,
}

/// The answer of a global planner; its memory is used again.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// From start to goal, every node included.
    pub path: Path,
    /// Work of the search, counted on failure as well.
    pub effort: SearchEffort,
    /// Cells of a path on the grid, start and goal included; empty if the planner does not work on cells.
    pub cells: Vec<Cell>,
}

/// Turns a task into a path.
///
/// A planner may keep workspaces and, between [`reset`](Self::reset)s, what it learnt in earlier
/// calls of the same episode; its answer may depend on nothing else. It never reads a clock.
pub trait GlobalPlanner: Send {
    /// Finds a path from the start to the goal of `task` into `plan`, which holds the answer before; `plan.effort` is filled in
    /// on failure too.
    ///
    /// # Errors
    /// The reason why no path was found.
    fn plan(&mut self, task: &Task<'_>, plan: &mut Plan) -> Result<(), Failure>;

    /// Forgets everything learnt. Called before each episode.
    fn reset(&mut self) {}

    /// The planner's own search in cells; `None` unless it searches the grid.
    fn as_grid(&mut self) -> Option<&mut dyn GridPlanner> {
        None
    }
}

/// Outcome and effort of a search on the grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Search {
    /// Whether a path was found.
    pub result: Result<(), Failure>,
    /// Nodes popped and expanded, re-expansions included; the goal that ends the search is not expanded.
    pub expanded: u64,
    /// Nodes pushed, the start and every cheaper connection included.
    pub generated: u64,
}

/// A global planner that answers with cells. Each one is a [`GlobalPlanner`] as well.
pub trait GridPlanner: Send {
    /// Finds a path. On success `path` holds its cells from start to goal, both included (once if they are equal);
    /// consecutive ones are neighbours, or for an any-angle planner in sight of each other. On failure `path` is empty.
    fn search(&mut self, problem: &Problem<'_>, path: &mut Vec<Cell>) -> Search;

    /// Forgets everything learnt. Called before each episode.
    fn reset(&mut self) {}
}

impl<T: GridPlanner> GlobalPlanner for T {
    fn plan(&mut self, task: &Task<'_>, plan: &mut Plan) -> Result<(), Failure> {
        let Search { result, expanded, generated } = self.search(&task.problem(), &mut plan.cells);
        plan.effort = SearchEffort { expanded, generated };
        result?;
        plan.follow_cells(task);
        Ok(())
    }

    fn reset(&mut self) {
        GridPlanner::reset(self);
    }

    fn as_grid(&mut self) -> Option<&mut dyn GridPlanner> {
        Some(self)
    }
}

/// Turns a path into a better one.
pub trait PathStage: Send {
    /// The new path: same start, same end. It may have times and name its key nodes.
    ///
    /// # Errors
    /// If no path satisfies the stage.
    fn apply(&mut self, task: &Task<'_>, path: &Path) -> Result<Path, Failure>;

    /// Whether its paths keep off blocked cells. A path that does not is a fault of a stage that says so and a property of one that does
    /// not: a formula that is printed without a check.
    fn keeps_off_obstacles(&self) -> bool {
        true
    }
}

/// Input of the local layer from the global one.
#[derive(Clone, Copy, Debug)]
pub struct Guidance<'a> {
    /// The path in force, grid frame; a stand-alone local planner gets the straight line to the goal.
    pub path: &'a Path,
    /// Progress of the robot: arc length along `path`, m. On one path it decreases on [`Request::GoBack`] only.
    pub progress_m: f64,
    /// Start of the leg to the sub-goal: with the rule `key_nodes` the key node before the sub-goal, with `lookahead` the point
    /// of the path at `progress_m`.
    pub previous_node: Vec2,
    /// The point to steer for.
    pub sub_goal: Vec2,
    /// Whether `sub_goal` is the end of the path.
    pub is_last: bool,
    /// Increases by one whenever a new path comes into force.
    pub path_revision: u32,
    /// All key nodes of the path, start and goal included.
    pub key_nodes: &'a [KeyNode],
    /// Number of the first key node that the robot has not passed yet.
    pub next_key_node: usize,
}

impl<'a> Guidance<'a> {
    /// Steering for the end of `path`, without key nodes on the way.
    pub fn to_end(path: &'a Path, progress_m: f64) -> Self {
        Self {
            path,
            progress_m,
            previous_node: path.start(),
            sub_goal: path.end(),
            is_last: true,
            path_revision: 0,
            key_nodes: &[],
            next_key_node: 0,
        }
    }

    /// Reference position `time_s` after the beginning of the path; `None` if the path has no times.
    pub fn reference(&self, time_s: f64) -> Option<Vec2> {
        self.path.point_at_time(time_s)
    }
}

/// Kind of a local planner's state, for code that treats all planners alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum StateKind {
    /// Following or optimising as usual.
    Tracking,
    /// No admissible command existed.
    Recovering,
    /// Standing on purpose until something has passed: not stuck.
    Waiting,
    /// Going back along the path on purpose.
    Retreating,
    /// At the goal.
    Arrived,
}

/// A state of a local planner, by its own name; a column of the trace and rows of `states.csv`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct State {
    /// The planner's own name of the state, in snake case.
    pub name: &'static str,
    /// Kind of the state.
    pub kind: StateKind,
}

impl State {
    /// Following or optimising as usual.
    pub const TRACK: Self = Self { name: "track", kind: StateKind::Tracking };
    /// No admissible command existed: braking or turning in place.
    pub const RECOVER: Self = Self { name: "recover", kind: StateKind::Recovering };
    /// At the goal, where the stack brakes and turns by itself: a state of the stack, in which no local planner is.
    pub const ARRIVE: Self = Self { name: "arrive", kind: StateKind::Arrived };
}

/// Numbers that a local planner publishes beside a decision, such as the terms of the winner or a phase: at most
/// [`Notes::COUNT_MAX`], finite, in the order of [`Entry::notes`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Notes {
    values: [f64; Self::COUNT_MAX],
    count: u8,
}

impl Notes {
    /// Largest number of values.
    pub const COUNT_MAX: usize = 12;
    /// No values.
    pub const NONE: Self = Self { values: [0.0; Self::COUNT_MAX], count: 0 };

    /// Notes of the given values.
    ///
    /// # Panics
    /// If there are more than [`Self::COUNT_MAX`].
    pub fn new(given: &[f64]) -> Self {
        let mut values = [0.0; Self::COUNT_MAX];
        values[..given.len()].copy_from_slice(given);
        Self { values, count: given.len() as u8 }
    }

    /// The values.
    pub fn values(&self) -> &[f64] {
        &self.values[..usize::from(self.count)]
    }
}

/// A request of the local planner to the stack. It takes effect at the next tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// A new path, from the robot or from a point of the old path that the robot is to reach first; the old path up to that point
    /// is kept.
    NewPath {
        /// Arc length on the path in force from which to plan, m; `None` for the robot's own position.
        from_m: Option<f64>,
    },
    /// Sets the progress, and with it the sub-goal, back to an earlier point of the path in force.
    GoBack {
        /// Arc length to go back to, m.
        to_m: f64,
    },
    /// The planner steers for this point at this tick and not for the stack's sub-goal; the trace says so.
    SubGoal(Vec2),
}

/// The answer of a local planner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Commanded twist.
    pub command: Twist,
    /// State of the planner.
    pub state: State,
    /// Candidate trajectories simulated for this decision.
    pub rollouts: u64,
    /// Poses simulated in all of them; a scenario may charge simulated time for each.
    pub rollout_points: u64,
    /// The planner's own numbers.
    pub notes: Notes,
    /// Request to the stack, if any.
    pub request: Option<Request>,
}

impl Decision {
    /// Standing still; nothing was simulated.
    pub const STAND: Self = Self::track(Twist::ZERO);

    /// `command`, chosen without simulating anything.
    pub const fn track(command: Twist) -> Self {
        Self { command, state: State::TRACK, rollouts: 0, rollout_points: 0, notes: Notes::NONE, request: None }
    }
}

/// Turns a situation and the guidance of a path into a command, once per tick.
///
/// A planner may keep workspaces and, between [`reset`](Self::reset)s, its own state of the episode;
/// its answer may depend on nothing else. It never reads a clock.
pub trait LocalPlanner: Send {
    /// The command for this tick.
    ///
    /// # Errors
    /// If the planner has no command: the episode ends as `planner_error`.
    fn decide(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Result<Decision, Failure>;

    /// Registry entry of the planner: the states and notes that its decisions may have.
    fn entry(&self) -> &'static Entry {
        const OUTSIDE: Entry = Entry { states: &[State::TRACK, State::RECOVER], ..Entry::PLAIN };
        &OUTSIDE
    }

    /// Forgets everything. Called before each episode.
    fn reset(&mut self) {}
}

/// Map, robot and control period against which parameters are checked before the first tick.
#[derive(Clone, Copy, Debug)]
pub struct Fit<'a> {
    /// The known map.
    pub map: &'a OccupancyGrid,
    /// The robot.
    pub robot: &'a Robot,
    /// Control period, s.
    pub dt_s: f64,
}
