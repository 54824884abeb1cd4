//! The stack: global planner × path stages × fusion × local planner, with replanning.
//!
//! The local planner steers for one point of the global path at a time, the *sub-goal*. Two rules choose it:
//!
//! - [`lookahead`]: the point a given distance ahead of the robot's progress along the path;
//! - [`mod@key_nodes`]: the ends of the path's pieces one after the other. The sub-goal moves on when the
//!   robot is within the switching radius of it or has passed its normal plane, that is the plane
//!   through the node across the direction in which the path arrives there; without the second rule
//!   robots circle nodes that they missed. The last node, the goal, never switches.
//!
//! Source of the key nodes: L. Gao et al., 2025, section 2.4 (sub-goals, switching within 0.5 to 1.0 m); the normal
//! plane is simrun's resolution.

use super::PlanningGrid;
use super::global::{GlobalChoice, GlobalPlanner, PlanFailure, Problem, Search};
use super::local::{Decision, Guidance, LocalChoice, LocalPlanner};
use super::path::{PathChoice, PathStage};
use crate::clock::Stopwatch;
use crate::geometry::{Path, Piece, Vec2};
use crate::map::Cell;
use crate::math;
use crate::observation::{Belief, Observation};
use crate::settings::choice::choice;
use crate::settings::quantity::{NonNegative, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where the centre of the robot may be planned, and how key nodes are handed on (scenario key `planning`).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PlanningSpec {
    /// Distance that cell centres of the planned path keep from obstacle squares, m; the robot's
    /// radius and 0.05 m where absent: a path at exactly the radius touches, and no local planner can
    /// follow it. The papers plan with 0 and clearance rules of their own.
    pub inflation_m: Option<NonNegative>,
    /// Which point of the path the local planner steers for; default `lookahead`.
    pub sub_goals: SubGoals,
    /// When stacks plan again that do not say so themselves; default `never`.
    pub replan: Replan,
    /// Simulated time that planning takes; by default none.
    pub compute: ComputeSpec,
}

/// Simulated time that planning takes, a model and never a clock: the same on every machine.
///
/// A request made at tick k that costs c seconds is answered at tick k + ⌈c / dt⌉, from what was observed at tick k. Until
/// then the last path and the last command stay in force (at first there is none: the robot stands), and the layer that is
/// busy is asked nothing new. What costs nothing is answered at once. Path stages are not charged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ComputeSpec {
    /// Charged for each node that the global planner expands, s; default 0.
    pub per_expansion_s: NonNegative,
    /// Charged for each pose of each trajectory that the local planner simulates, s; default 0.
    pub per_rollout_point_s: NonNegative,
}

impl Default for ComputeSpec {
    fn default() -> Self {
        Self { per_expansion_s: NonNegative::new(0.0), per_rollout_point_s: NonNegative::new(0.0) }
    }
}

/// Whole ticks that `cost_s` seconds of planning take, rounded up.
fn ticks_of(cost_s: f64, dt_s: f64) -> u32 {
    // A cost that is a whole number of ticks but for rounding is that number.
    (cost_s / dt_s - 1e-9).ceil().clamp(0.0, f64::from(u32::MAX)) as u32
}

/// An answer on its way.
#[derive(Clone, Debug)]
struct Pending<T> {
    ready_tick: u32,
    answer: T,
}

impl<T> Pending<T> {
    /// The answer, if its time has come.
    fn take(slot: &mut Option<Self>, tick: u32) -> Option<T> {
        slot.take_if(|pending| pending.ready_tick <= tick).map(|pending| pending.answer)
    }
}

/// What planned paths keep from obstacles beyond the robot's radius where a scenario does not say, m.
const PLANNING_MARGIN_M: f64 = 0.05;

impl PlanningSpec {
    /// The inflation of the planning grid for a robot of radius `radius_m`, m.
    pub fn inflation_m(&self, radius_m: f64) -> f64 {
        self.inflation_m.map_or(radius_m + PLANNING_MARGIN_M, NonNegative::get)
    }
}

/// A point that moves along the path ahead of the robot.
///
/// A local planner that is given far key nodes cuts across what the path avoids and overshoots the
/// turns; this hands it the path itself. Where the point is out of the robot's sight on the planning
/// grid it is drawn back along the path until it is in sight: a sub-goal behind a corner would pull
/// the robot into the corner.
pub mod lookahead {
    use super::{Deserialize, JsonSchema, Positive, Serialize};

    /// How far ahead.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Params {
        /// Arc length from the robot's place on the path to the sub-goal, m; about top speed × horizon
        /// lets a dynamic window drive at full speed. Default 3.
        pub distance_m: Positive,
        /// The sub-goal is not drawn back nearer than this, m; default 1.5.
        pub distance_min_m: Positive,
    }

    impl Default for Params {
        fn default() -> Self {
            Self { distance_m: Positive::new(3.0), distance_min_m: Positive::new(1.5) }
        }
    }
}

/// The key nodes of the path one after the other, as the papers do.
pub mod key_nodes {
    use super::{Deserialize, JsonSchema, Positive, Serialize};

    /// When the next one's turn comes.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Params {
        /// Distance at which the sub-goal moves on to the next key node, m; default 0.8 (gao2025: 0.5 to 1.0).
        pub switching_radius_m: Positive,
    }

    impl Default for Params {
        fn default() -> Self {
            Self { switching_radius_m: Positive::new(0.8) }
        }
    }
}

choice! {
    /// Which point of the path is the sub-goal.
    pub enum SubGoals: "rule for sub-goals" { lookahead, key_nodes }
}

impl Default for SubGoals {
    fn default() -> Self {
        Self::lookahead(lookahead::Params::default())
    }
}

/// Never plan again after the first path (as the papers do).
pub mod never {
    use super::{Deserialize, JsonSchema, Serialize};

    /// No parameters.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Params {}
}

/// Plan again when the rest of the path has become blocked on the belief map, or the robot has come to a stand.
pub mod when_blocked {
    use super::{Deserialize, JsonSchema, NonNegative, Serialize};

    /// When a stand counts as blocked.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Params {
        /// Also plan again when the robot has stood within 0.1 m for this long, s: a new path may lead elsewhere, and one that
        /// came into force at full speed may have been missed. 0 never does; default 5.
        pub after_standing_s: NonNegative,
    }

    impl Default for Params {
        fn default() -> Self {
            Self { after_standing_s: NonNegative::new(5.0) }
        }
    }
}

/// Plan again when the robot has stood for a while.
pub mod when_stuck {
    use super::{Deserialize, JsonSchema, Positive, Serialize};

    /// When the robot counts as standing.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct Params {
        /// How long it must have stood, s; default 5.
        pub after_s: Positive,
        /// Within which distance it counts as standing, m; default 0.1.
        pub radius_m: Positive,
    }

    impl Default for Params {
        fn default() -> Self {
            Self { after_s: Positive::new(5.0), radius_m: Positive::new(0.1) }
        }
    }
}

/// Plan again at a fixed period.
pub mod every {
    use super::{Deserialize, JsonSchema, Positive, Serialize};

    /// The period.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// Time between two plans, s.
        pub period_s: Positive,
    }
}

/// Distance within which a robot counts as standing, m.
const STANDING_RADIUS_M: f64 = 0.1;

choice! {
    /// When the global planner is asked again, on the map as believed by then.
    pub enum Replan: "replanning rule" { never, when_blocked, when_stuck, every }
}

impl Default for Replan {
    fn default() -> Self {
        Self::never(never::Params {})
    }
}

/// A stack as a scenario describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct StackSpec {
    /// Unique name in results.
    pub name: String,
    /// The global planner; none for a local planner that gets the goal as its only sub-goal.
    pub global: Option<GlobalChoice>,
    /// Path stages in order.
    pub path: Vec<PathChoice>,
    /// The local planner.
    pub local: LocalChoice,
    /// When to plan again; what `planning.replan` says where absent.
    pub replan: Option<Replan>,
}

impl StackSpec {
    /// The name of the global part in the name of the stack: the planner's, or `none` (whose column `global` is empty).
    pub fn global_name(&self) -> &'static str {
        self.global.as_ref().map_or("none", GlobalChoice::name)
    }

    /// The name in results of the path part: the stages joined by `+`; empty where there are none.
    pub fn path_name(&self) -> String {
        self.path.iter().map(PathChoice::name).collect::<Vec<_>>().join("+")
    }

    /// `global[+path…]+local`, the name of a stack that was given none.
    pub fn default_name(&self) -> String {
        let mut parts = vec![self.global_name()];
        parts.extend(self.path.iter().map(PathChoice::name));
        parts.push(self.local.name());
        parts.join("+")
    }

    /// A fresh stack.
    pub fn build(&self, planning: &PlanningSpec) -> Stack {
        Stack::new(
            self.global.as_ref().map(GlobalChoice::build),
            self.path.iter().map(PathChoice::build).collect(),
            self.local.build(),
        )
        .with_planning(planning)
        .with_replan(self.replan.as_ref().unwrap_or(&planning.replan).clone())
    }
}

/// What the stack has done so far in an episode.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Nodes expanded by the global planner.
    pub expanded: u64,
    /// Nodes generated by the global planner.
    pub generated: u64,
    /// Searches after the first.
    pub replans: u32,
}

/// A global planner, path stages and a local planner, driven together.
pub struct Stack {
    global: Option<Box<dyn GlobalPlanner>>,
    stages: Vec<Box<dyn PathStage>>,
    local: Box<dyn LocalPlanner>,
    planning: PlanningSpec,
    replan: Replan,
    grid: PlanningGrid,
    cells: Vec<Cell>,
    route: Route,
    /// The path that is being planned.
    coming_path: Option<Pending<Path>>,
    /// The decision that is being made.
    coming_decision: Option<Pending<Decision>>,
    /// The last decision that came into force.
    decision: Decision,
    effort: Effort,
    anchor: Anchor,
    checked_revision: u64,
    planned_tick: u32,
    planned_goal: Vec2,
    global_s: f64,
}

impl core::fmt::Debug for Stack {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Stack").field("replan", &self.replan).field("route", &self.route).finish_non_exhaustive()
    }
}

impl Stack {
    /// A stack from its parts; `None` leaves the local planner alone with the goal.
    pub fn new(
        global: Option<Box<dyn GlobalPlanner>>,
        stages: Vec<Box<dyn PathStage>>,
        local: Box<dyn LocalPlanner>,
    ) -> Self {
        Self {
            global,
            stages,
            local,
            planning: PlanningSpec::default(),
            replan: Replan::default(),
            grid: PlanningGrid::default(),
            cells: Vec::new(),
            route: Route::default(),
            coming_path: None,
            coming_decision: None,
            decision: Decision::STAND,
            effort: Effort::default(),
            anchor: Anchor::default(),
            checked_revision: 0,
            planned_tick: 0,
            planned_goal: Vec2::zeros(),
            global_s: 0.0,
        }
    }

    /// The same stack with other planning settings, its replanning rule among them.
    #[must_use]
    pub fn with_planning(mut self, spec: &PlanningSpec) -> Self {
        self.planning = spec.clone();
        self.replan = spec.replan.clone();
        self
    }

    /// The same stack with another replanning rule.
    #[must_use]
    pub fn with_replan(mut self, replan: Replan) -> Self {
        self.replan = replan;
        self
    }

    /// Begins an episode: forgets the last one and plans the first path.
    ///
    /// # Errors
    /// What the global planner says; the episode then ends as `no_path`.
    pub fn begin(&mut self, observation: &Observation<'_>) -> Result<(), PlanFailure> {
        if let Some(global) = &mut self.global {
            global.reset();
        }
        self.local.reset();
        self.effort = Effort::default();
        self.global_s = 0.0;
        self.route = Route::default();
        (self.coming_path, self.coming_decision, self.decision) = (None, None, Decision::STAND);
        self.anchor = Anchor { position: observation.pose.position, tick: observation.tick };
        self.plan(observation)
    }

    /// The command for this tick; may plan a new path first. Where planning takes simulated time
    /// ([`ComputeSpec`]) it is the last command that was ready, and counts as one decision only once.
    pub fn decide(&mut self, observation: &Observation<'_>) -> Decision {
        let tick = observation.tick;
        self.anchor.follow(observation, &self.replan);
        if let Some(path) = Pending::take(&mut self.coming_path, tick) {
            self.route.set(path);
            self.anchor = Anchor { position: observation.pose.position, tick };
        }
        // A goal that has moved is a new task, whatever the rule.
        let goal_has_moved = observation.goal != self.planned_goal;
        if self.coming_path.is_none() && (goal_has_moved || self.global.is_some() && self.wants_new_path(observation)) {
            self.effort.replans += 1;
            // Where no path exists on the belief map the old one stays in force.
            let _ = self.plan(observation);
            self.anchor = Anchor { position: observation.pose.position, tick: observation.tick };
        }
        if self.route.revision == 0 {
            return Decision::STAND;
        }
        let grid = self.global.is_some().then_some(&self.grid);
        self.route.advance(observation.pose.position, &self.planning.sub_goals, grid);

        // What an answer counts it counts where it was asked for: the ticks that wait for it or repeat it count nothing.
        let uncounted = |decision: Decision| Decision { rollouts: 0, rollout_points: 0, ..decision };
        if let Some(ready) = Pending::take(&mut self.coming_decision, tick) {
            self.decision = ready;
        }
        if self.coming_decision.is_some() {
            return uncounted(self.decision);
        }
        let answer = self.local.decide(observation, &self.route.guidance());
        let cost_s = answer.rollout_points as f64 * self.planning.compute.per_rollout_point_s.get();
        let delay = ticks_of(cost_s, observation.dt_s);
        if delay == 0 {
            self.decision = uncounted(answer);
            return answer;
        }
        self.coming_decision = Some(Pending { ready_tick: tick + delay, answer: uncounted(answer) });
        Decision { rollouts: answer.rollouts, rollout_points: answer.rollout_points, ..self.decision }
    }

    /// Whether a path is being planned and not in force yet ([`ComputeSpec`]).
    pub fn is_planning(&self) -> bool {
        self.coming_path.is_some()
    }

    /// The path in force.
    pub fn path(&self) -> &Path {
        &self.route.path
    }

    /// Counts the paths that came into force; 0 before the first.
    pub fn path_revision(&self) -> u32 {
        self.route.revision
    }

    /// The key node steered for.
    pub fn sub_goal(&self) -> Vec2 {
        self.route.guidance().sub_goal
    }

    /// What has been done in this episode so far.
    pub fn effort(&self) -> Effort {
        self.effort
    }

    /// Wall time spent in the global layer in this episode, s; for `timings.csv` alone.
    pub fn global_s(&self) -> f64 {
        self.global_s
    }

    fn wants_new_path(&mut self, observation: &Observation<'_>) -> bool {
        match &self.replan {
            Replan::never(_) => false,
            Replan::when_blocked(params) => {
                let after_s = params.after_standing_s.get();
                (after_s > 0.0 && self.has_stood(observation, after_s)) || self.has_become_blocked(observation)
            }
            Replan::when_stuck(params) => self.has_stood(observation, params.after_s.get()),
            Replan::every(params) => observation.time_since_s(self.planned_tick) >= params.period_s.get() - 1e-9,
        }
    }

    fn has_stood(&self, observation: &Observation<'_>, time_s: f64) -> bool {
        observation.time_since_s(self.anchor.tick) >= time_s - 1e-9
    }

    fn has_become_blocked(&mut self, observation: &Observation<'_>) -> bool {
        let revision = observation.belief.revision();
        if revision == self.checked_revision {
            return false;
        }
        self.checked_revision = revision;
        self.rebuild_grid(observation);
        !self.route.rest_is_free(&self.grid)
    }

    fn rebuild_grid(&mut self, observation: &Observation<'_>) {
        let belief = observation.belief;
        let inflation_m = self.planning.inflation_m(observation.robot.radius_m);
        self.grid.rebuild(belief.grid(), belief.field(), inflation_m);
        for point in [observation.pose.position, observation.goal] {
            self.grid.open_around(belief.grid(), belief.grid().cell_at(point));
        }
    }

    fn plan(&mut self, observation: &Observation<'_>) -> Result<(), PlanFailure> {
        let clock = Stopwatch::start();
        let result = self.plan_untimed(observation);
        self.global_s += clock.elapsed_s();
        result
    }

    fn plan_untimed(&mut self, observation: &Observation<'_>) -> Result<(), PlanFailure> {
        self.planned_tick = observation.tick;
        self.checked_revision = observation.belief.revision();
        let (from, goal) = (observation.pose.position, observation.goal);
        self.planned_goal = goal;
        if self.global.is_none() {
            self.route.set(Path::polyline(&[from, goal]));
            return Ok(());
        }
        self.rebuild_grid(observation);
        let occupancy: &Belief = observation.belief;
        let problem =
            Problem { grid: &self.grid, start: occupancy.grid().cell_at(from), goal: occupancy.grid().cell_at(goal) };
        let Some(global) = &mut self.global else { return Ok(()) };
        let Search { result, expanded, generated } = global.plan(&problem, &mut self.cells);
        self.effort.expanded += expanded;
        self.effort.generated += generated;
        result?;
        let mut path = Path::polyline(&vertices(&self.grid, &self.cells, from, goal));
        for stage in &mut self.stages {
            path = stage.apply(&self.grid, &path);
        }
        let cost_s = expanded as f64 * self.planning.compute.per_expansion_s.get();
        match ticks_of(cost_s, observation.dt_s) {
            0 => self.route.set(path),
            delay => self.coming_path = Some(Pending { ready_tick: observation.tick + delay, answer: path }),
        }
        Ok(())
    }
}

/// Vertices of a path of cells: the robot's own position, the centres where it turns, the goal's
/// own position. The centre of the robot's own cell is no vertex, or a robot that plans anew
/// would turn back to it.
fn vertices(grid: &PlanningGrid, cells: &[Cell], from: Vec2, goal: Vec2) -> Vec<Vec2> {
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

/// A path in force and how far the robot has come on it.
#[derive(Clone, Debug, Default)]
struct Route {
    path: Path,
    nodes: Vec<Vec2>,
    ends_m: Vec<f64>,
    /// Number of the key node that the robot has not passed yet.
    next: usize,
    progress_m: f64,
    previous_node: Vec2,
    sub_goal: Vec2,
    is_last: bool,
    revision: u32,
}

impl Route {
    fn set(&mut self, path: Path) {
        self.nodes.clear();
        self.nodes.extend(path.vertices());
        self.ends_m.clear();
        self.ends_m.push(0.0);
        let mut end = 0.0;
        for (from, piece) in path.segments() {
            end += piece.length(from);
            self.ends_m.push(end);
        }
        self.path = path;
        self.next = 1.min(self.nodes.len() - 1);
        self.progress_m = 0.0;
        (self.previous_node, self.sub_goal) = (self.nodes[0], self.nodes[self.next]);
        self.is_last = self.next == self.nodes.len() - 1;
        self.revision += 1;
    }

    /// Moves progress and sub-goal on as far as they go.
    fn advance(&mut self, position: Vec2, rule: &SubGoals, grid: Option<&PlanningGrid>) {
        match rule {
            SubGoals::lookahead(params) => self.look_ahead(position, params, grid),
            SubGoals::key_nodes(params) => self.switch_nodes(position, params.switching_radius_m.get()),
        }
    }

    fn look_ahead(&mut self, position: Vec2, params: &lookahead::Params, grid: Option<&PlanningGrid>) {
        let (distance_m, distance_min_m) = (params.distance_m.get(), params.distance_min_m.get());
        // Only as far as the sub-goal: a path that passes the same place twice must not let the progress jump.
        self.project(position, self.progress_m, self.progress_m + distance_m);
        while self.next + 1 < self.nodes.len() && self.ends_m[self.next] < self.progress_m {
            self.next += 1;
        }
        let end_m = self.ends_m[self.ends_m.len() - 1];
        let mut ahead_m = distance_m;
        let point = |ahead_m: f64| self.path.point_at(self.progress_m + ahead_m);
        if let Some(grid) = grid {
            let step_m = 0.5 * grid.resolution_m();
            while ahead_m > distance_min_m && !grid.line_of_sight(position, point(ahead_m)) {
                ahead_m = math::max(ahead_m - step_m, distance_min_m);
            }
        }
        let sub_goal = point(ahead_m);
        self.previous_node = point(0.0);
        self.is_last = self.progress_m + ahead_m >= end_m;
        self.sub_goal = if self.is_last { self.path.end() } else { sub_goal };
    }

    fn switch_nodes(&mut self, position: Vec2, switching_radius_m: f64) {
        let last = self.nodes.len() - 1;
        while self.next < last {
            let node = self.nodes[self.next];
            let arriving = node - self.nodes[self.next - 1];
            let near = (position - node).norm() <= switching_radius_m;
            let passed = arriving.norm_squared() == 0.0 || (position - node).dot(&arriving) > 0.0;
            if !(near || passed) {
                break;
            }
            self.next += 1;
        }
        // From a little behind the current piece up to the sub-goal, for the same reason.
        let from_m = math::max(self.progress_m, self.ends_m[self.next.saturating_sub(2)]);
        self.project(position, from_m, self.ends_m[self.next]);
        self.previous_node = self.nodes[self.next.saturating_sub(1)];
        self.sub_goal = self.nodes[self.next];
        self.is_last = self.next == last;
    }

    /// Moves the progress to the point nearest to `position` within a stretch of the path, never back.
    fn project(&mut self, position: Vec2, from_m: f64, to_m: f64) {
        let nearest_m = self.path.project_within(position, from_m, to_m).0;
        self.progress_m = math::max(math::max(from_m, self.progress_m), math::min(nearest_m, to_m));
    }

    fn guidance(&self) -> Guidance<'_> {
        Guidance {
            path: &self.path,
            progress_m: self.progress_m,
            previous_node: self.previous_node,
            sub_goal: self.sub_goal,
            is_last: self.is_last,
            path_revision: self.revision,
        }
    }

    /// Whether every piece from the current one on is free on the grid; arcs are tested by chords
    /// of at most a tenth of a cell's sagitta.
    fn rest_is_free(&self, grid: &PlanningGrid) -> bool {
        let first = self.next.saturating_sub(1);
        self.path.segments().skip(first).all(|(from, piece)| match piece {
            Piece::Line { to } => grid.line_of_sight(from, *to),
            Piece::Arc { .. } => {
                let length = piece.length(from);
                let steps = (length / (0.25 * grid.resolution_m())).ceil().clamp(1.0, 1e4) as usize;
                let at = |k: usize| piece.point_at(from, length * k as f64 / steps as f64);
                (0..steps).all(|k| grid.line_of_sight(at(k), at(k + 1)))
            }
        })
    }
}

/// Where the robot was when it last counted as moving.
#[derive(Clone, Copy, Debug, Default)]
struct Anchor {
    position: Vec2,
    tick: u32,
}

impl Anchor {
    fn follow(&mut self, observation: &Observation<'_>, replan: &Replan) {
        let radius_m = match replan {
            Replan::when_stuck(params) => params.radius_m.get(),
            _ => STANDING_RADIUS_M,
        };
        if (observation.pose.position - self.position).norm() > radius_m {
            *self = Self { position: observation.pose.position, tick: observation.tick };
        }
    }
}
