//! `pf_aco`: an ant colony whose ants are drawn by a potential field.
//!
//! Source: the baseline "PFAC" of Hu, Wang, Zhang, Research on Dynamic Obstacle Avoidance Method of Mobile Robot based on Improved A*
//! Algorithm and Dynamic Window Method, Engineering Letters 32(3), 2024, which takes it from its reference 21. That text is not
//! available to us: this is a **stand-in** after the family of such methods (`systems.md` §7.9). The ants and their pheromone are those of
//! M. Dorigo, V. Maniezzo, A. Colorni, Ant system, IEEE Transactions on Systems, Man, and Cybernetics B 26(1), 1996, and of
//! T. Stützle, H. H. Hoos, MAX-MIN Ant System, Future Generation Computer Systems 16(8), 2000.
//!
//! ```text
//! repeat T times, t = 0 … T − 1
//!     every ant goes from the start to the goal; from i it steps to a free neighbour j that it has not been to, with the probability
//!         P(i → j) = τ(i → j)^a η(i → j)^b / the sum of that over all such neighbours
//!         η(i → j) = exp(ξ(t) cos θ) / (|j − goal| + 0.1)          ξ(t) = ξ0 (1 − t / T)
//!         θ: between the step and the force at i,  F = k_a (goal − i) + Σ k_r (1/ρ − 1/ρ0) / ρ² · (i − obstacle) / ρ   over ρ ≤ ρ0
//!     τ ← (1 − ρ_e) τ + deposits
//! answer with the shortest path of all ants; of equal ones with the earliest
//! ```
//!
//! Lengths are in cells, between the centres of cells. The force sums over the cells of the map that are blocked on the planning grid, those
//! of its inflation included, whose centres are within ρ0 of that of i; what is outside the map repels nothing. Where F is 0, so is cos θ.
//! At first τ is 2 on steps to cells within 0.2 |start goal| of the straight line from start to goal, and 1 elsewhere.
//!
//! **Pheromone** lies on steps: there and back are two. By `update: ant_system` every ant lays Qc / L on each step of its path of length L.
//! Then more iterations give worse paths: the ants of the first ones, which follow the force alone, lay so much on their common way,
//! and evaporation takes so much from all others, that no other way is ever tried again, and the slower ξ falls the longer
//! they do so. Hence the default `max_min`, which lays 1 / L on the shortest path so far alone, and keeps τ within
//!
//! ```text
//! τ_max = 1 / (ρ_e L)          τ_min = τ_max (1 − p) / (3 p),  at most τ_max          p = 0.05^(1 / steps of that path)
//! ```
//!
//! so that ants that choose among four ways find that path again with a probability of 5 % where pheromone alone decides. Before the first
//! update all pheromone is scaled so that 2 becomes τ_max, which changes no probability. Another Qc would scale all of this and change nothing.
//!
//! **An ant without a way on** goes back by one step; its path is what is left. So every ant arrives where there is a way, no path has a cell
//! twice, and the first ant that is back at the start without a way on shows that there is none: it has been to every cell within reach.
//!
//! **Effort.** Expanded are the nodes from which an ant steps on or back, once for each time; generated are the candidates weighed there.
//! The search ends as out of budget, whatever it has found, with the first step that the budget does not allow.
//!
//! **Randomness.** An answer draws more numbers than a tick has, so the tick's stream gives the seed of a stream for the answer.
//!
//! Departures: the length of a path counts steps from and to cells of escape zones ten times, as all planners' costs do.
//!
//! Parameters: [`Params`].

use super::GlobalKind;
use super::search::{CellCost, CornerRule, Cost, Marks, Move, Moves, euclidean, stepped};
use crate::geometry::Vec2;
use crate::map::Cell;
use crate::math;
use crate::plan::contract::{Entry, Failure, GlobalPlanner, Plan, Problem, SearchEffort, Task};
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::settings::quantity::{Count, NonNegative, Positive, PositiveFraction};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How pheromone is laid and kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Update {
    /// Only the shortest path so far gets pheromone, and all pheromone stays within bounds (Stützle and Hoos).
    #[default]
    MaxMin,
    /// Every ant's path gets pheromone, without bounds (Dorigo, Maniezzo and Colorni): more iterations may find longer paths.
    AntSystem,
}

/// Parameters of `pf_aco`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Ants per iteration. Default 50.
    pub ants: Count,
    /// T, the iterations. Default 100.
    pub iterations: Count,
    /// a, the exponent of the pheromone. Default 1.
    pub pheromone_exponent: NonNegative,
    /// b, the exponent of η, nearness to the goal and direction of the force. Default 7.
    pub heuristic_exponent: NonNegative,
    /// ρ_e, the share of the pheromone that evaporates per iteration. Default 0.3.
    pub evaporation: PositiveFraction,
    /// Qc, the pheromone that a path of one cell's length gets; without effect under `update: max_min`. Default 1.
    pub deposit: Positive,
    /// How pheromone is laid and kept. Default `max_min`.
    pub update: Update,
    /// k_a, the attraction of the goal per cell of distance. Default 1.
    pub attraction_gain: NonNegative,
    /// k_r, the repulsion of obstacles. Default 1.
    pub repulsion_gain: NonNegative,
    /// ρ0, the distance from which obstacles repel, cells. Default 2.
    pub repulsion_range_cells: Positive,
    /// ξ0, the weight of the force's direction in the first iteration; it falls to 0 in proportion. Default 2.
    pub force_weight: NonNegative,
    /// When a diagonal step may pass obstacles beside it; default `forbid`.
    pub corner_rule: CornerRule,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            ants: Count::new(50),
            iterations: Count::new(100),
            pheromone_exponent: NonNegative::new(1.0),
            heuristic_exponent: NonNegative::new(7.0),
            evaporation: PositiveFraction::new(0.3),
            deposit: Positive::new(1.0),
            update: Update::MaxMin,
            attraction_gain: NonNegative::new(1.0),
            repulsion_gain: NonNegative::new(1.0),
            repulsion_range_cells: Positive::new(2.0),
            force_weight: NonNegative::new(2.0),
            corner_rule: CornerRule::Forbid,
        }
    }
}

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "Ant colony drawn by a potential field: random, much work, paths a little longer than the shortest; a stand-in for PFAC.",
    source: "Stand-in for reference 21 of Hu, Wang, Zhang, Engineering Letters 32(3), 2024, after Stützle, Hoos, MAX-MIN Ant System, Future Generation Computer Systems 16(8), 2000",
    random: true,
    ..Entry::PLAIN
};

impl GlobalKind for Params {
    fn build(&self) -> Box<dyn GlobalPlanner> {
        Box::new(Planner::new(self))
    }
}

/// Added to the distance from the goal, so that η is finite there, cells.
const DISTANCE_OFFSET_CELLS: f64 = 0.1;
/// Pheromone at first, beside the line from start to goal and near it.
const FIRST_PHEROMONE: [f64; 2] = [1.0, 2.0];
/// Half of the width of the band about that line is this part of its length.
const BAND_PART: i64 = 5;
/// Probability with which ants led by pheromone alone find the best path again (Stützle and Hoos).
const BEST_PATH_PROBABILITY: f64 = 0.05;
/// Half of the eight neighbours, as Stützle and Hoos count choices.
const CHOICES: f64 = 4.0;
/// Pheromone is kept from here to its inverse, whatever the parameters: sums and products of weights stay finite and above 0.
const PHEROMONE_LEAST: f64 = 1e-100;

/// e^x, from e^-300 to e^300.
fn limited_exp(x: f64) -> f64 {
    math::exp(math::clamp(x, -300.0, 300.0))
}

/// What the colony knows of a cell from which an ant has looked around. Arrays are by direction, and hold numbers for allowed moves alone.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// In the padded grid.
    index: u32,
    moves: Moves,
    /// cos θ.
    along_force: [f64; 8],
    /// −ln of the distance of the neighbour from the goal, with its offset.
    nearness: [f64; 8],
    /// τ.
    pheromone: [f64; 8],
    /// Pheromone laid in this iteration.
    laid: [f64; 8],
    /// τ^a η^b in the iteration [`Self::weighed_in`].
    weights: [f64; 8],
    weighed_in: Option<u32>,
}

/// A step of an ant.
#[derive(Clone, Copy, Debug)]
struct Taken {
    /// Number of the node from which it leads.
    node: u32,
    by: Move,
}

/// The planner.
#[derive(Debug)]
pub struct Planner {
    params: Params,
    /// The nodes of the current answer, in the order in which ants came to them.
    nodes: Vec<Node>,
    /// Number of the node of each padded cell, if it has one: any number else.
    numbers: Vec<u32>,
    /// Where the current ant has been.
    visited: Marks,
    trail: Vec<Taken>,
    best: Vec<Taken>,
}

impl Planner {
    /// A fresh planner.
    pub fn new(params: &Params) -> Self {
        Self {
            params: params.clone(),
            nodes: Vec::new(),
            numbers: Vec::new(),
            visited: Marks::default(),
            trail: Vec::new(),
            best: Vec::new(),
        }
    }

    /// A colony that is about to set out; start and goal are passable and not the same.
    fn colony<'a>(&'a mut self, problem: &'a Problem<'a>, stream: Stream, expansions_max: u64) -> Colony<'a> {
        self.nodes.clear();
        if self.numbers.len() < problem.grid.cells().len() {
            self.numbers.resize(problem.grid.cells().len(), 0);
        }
        Colony {
            problem,
            goal: problem.grid.index(problem.goal),
            expansions_max,
            stream,
            effort: SearchEffort::default(),
            untouched: FIRST_PHEROMONE,
            best_cost: None,
            ants: self,
        }
    }

    /// The cells of the shortest path into `path`, which is left empty on failure, and the effort.
    fn search(
        &mut self,
        problem: &Problem<'_>,
        stream: Stream,
        expansions_max: u64,
        path: &mut Vec<Cell>,
    ) -> (Result<(), Failure>, SearchEffort) {
        path.clear();
        if let Err(failure) = problem.check_ends() {
            return (Err(failure), SearchEffort::default());
        }
        if problem.start == problem.goal {
            path.push(problem.start);
            return (Ok(()), SearchEffort::default());
        }
        let iterations = self.params.iterations.get();
        let mut colony = self.colony(problem, stream, expansions_max);
        let result = (0..iterations).try_for_each(|iteration| colony.iterate(iteration));
        let effort = colony.effort;
        if result.is_ok() {
            let (nodes, grid) = (&self.nodes, problem.grid);
            path.extend(self.best.iter().map(|step| grid.cell(nodes[step.node as usize].index)));
            path.push(problem.goal);
        }
        (result, effort)
    }
}

impl GlobalPlanner for Planner {
    fn plan(&mut self, task: &Task<'_>, plan: &mut Plan) -> Result<(), Failure> {
        let mut seeds = task.situation.random.stream();
        let seed = EpisodeSeed { seed: seeds.bits(), episode: seeds.bits() };
        let (stream, expansions_max) = (seed.stream(Purpose::Planner, 0), task.situation.budget.expansions);
        let (result, effort) = self.search(&task.problem(), stream, expansions_max, &mut plan.cells);
        plan.effort = effort;
        result?;
        plan.follow_cells(task);
        Ok(())
    }
}

/// The force at a cell, whose length is of no effect.
fn force(problem: &Problem<'_>, params: &Params, at: Cell) -> Vec2 {
    let between = |from: Cell, to: Cell| Vec2::new(f64::from(to.col - from.col), f64::from(to.row - from.row));
    let range = params.repulsion_range_cells.get();
    // A map has far fewer columns and rows.
    let reach = math::min(range.floor(), 1e6) as i32;
    let (grid, mut force) = (problem.grid, params.attraction_gain.get() * between(at, problem.goal));
    for row in (at.row - reach).max(0)..=(at.row + reach).min(grid.rows() - 1) {
        for col in (at.col - reach).max(0)..=(at.col + reach).min(grid.cols() - 1) {
            let cell = Cell { col, row };
            if grid.is_passable(cell) {
                continue;
            }
            let away = between(cell, at);
            let rho = away.norm();
            if rho <= range {
                force += params.repulsion_gain.get() * (1.0 / rho - 1.0 / range) / (rho * rho) / rho * away;
            }
        }
    }
    force
}

/// Whether a cell is in the band about the straight line from start to goal, its edge included; in integers.
fn is_near_line(start: Cell, goal: Cell, cell: Cell) -> bool {
    let between =
        |from: Cell, to: Cell| (i64::from(to.col) - i64::from(from.col), i64::from(to.row) - i64::from(from.row));
    let square = |(x, y): (i64, i64)| x * x + y * y;
    let (line, to) = (between(start, goal), between(start, cell));
    let (length_square, along) = (square(line), to.0 * line.0 + to.1 * line.1);
    if along <= 0 {
        BAND_PART * BAND_PART * square(to) <= length_square
    } else if along >= length_square {
        BAND_PART * BAND_PART * square(between(goal, cell)) <= length_square
    } else {
        BAND_PART * (to.0 * line.1 - to.1 * line.0).abs() <= length_square
    }
}

/// One answer in the making.
struct Colony<'a> {
    problem: &'a Problem<'a>,
    /// Its place in the padded grid.
    goal: u32,
    expansions_max: u64,
    stream: Stream,
    effort: SearchEffort,
    /// Pheromone of steps on which none was ever laid, beside the line from start to goal and near it.
    untouched: [f64; 2],
    /// Length of the shortest path so far.
    best_cost: Option<CellCost>,
    ants: &'a mut Planner,
}

impl Colony<'_> {
    /// Sends every ant once, and lays their pheromone.
    ///
    /// # Errors
    /// [`Failure::NoPath`], [`Failure::OutOfBudget`].
    fn iterate(&mut self, iteration: u32) -> Result<(), Failure> {
        for _ in 0..self.ants.params.ants.get() {
            let cost = self.walk(iteration)?;
            if self.ants.params.update == Update::AntSystem {
                lay(&mut self.ants.nodes, &self.ants.trail, self.ants.params.deposit.get() / cost.value());
            }
            if self.best_cost.is_none_or(|best| cost < best) {
                self.best_cost = Some(cost);
                self.ants.best.clone_from(&self.ants.trail);
            }
        }
        self.update(iteration);
        Ok(())
    }

    /// Sends one ant; its path is the trail then.
    fn walk(&mut self, iteration: u32) -> Result<CellCost, Failure> {
        let grid = self.problem.grid;
        let start = grid.index(self.problem.start);
        self.ants.visited.begin(grid);
        self.ants.visited.mark(start);
        self.ants.trail.clear();
        let mut at = start;
        while at != self.goal {
            if self.effort.expanded >= self.expansions_max {
                return Err(Failure::OutOfBudget);
            }
            self.effort.expanded += 1;
            let number = self.node_at(at);
            self.weigh(number, iteration);
            if let Some(by) = self.choose(number) {
                self.ants.trail.push(Taken { node: number as u32, by });
                at = by.index_from(grid, at);
                self.ants.visited.mark(at);
            } else {
                let back = self.ants.trail.pop().ok_or(Failure::NoPath)?;
                at = self.ants.nodes[back.node as usize].index;
            }
        }
        let nodes = &self.ants.nodes;
        let cost = self.ants.trail.iter().fold(CellCost::ZERO, |cost, step| {
            let from = nodes[step.node as usize].index;
            stepped(grid, cost, from, step.by.index_from(grid, from), step.by)
        });
        Ok(cost)
    }

    /// Draws the step of the current ant from a node; `None` where there is no way on.
    fn choose(&mut self, number: usize) -> Option<Move> {
        let node = &self.ants.nodes[number];
        // The candidates, each with the weights up to its own.
        let (mut candidates, mut count, mut total) = ([(Move::E, 0.0); 8], 0, 0.0);
        for step in node.moves {
            if !self.ants.visited.contains(step.index_from(self.problem.grid, node.index)) {
                total += node.weights[step.direction()];
                candidates[count] = (step, total);
                count += 1;
            }
        }
        self.effort.generated += count as u64;
        let (last, before) = candidates[..count].split_last()?;
        let drawn = self.stream.uniform() * total;
        Some(before.iter().find(|(_, up_to)| drawn < *up_to).unwrap_or(last).0)
    }

    /// Number of the node of a padded cell, which is made if there is none.
    fn node_at(&mut self, index: u32) -> usize {
        let number = self.ants.numbers[index as usize] as usize;
        if self.ants.nodes.get(number).is_some_and(|node| node.index == index) {
            return number;
        }
        let node = self.new_node(index);
        let number = self.ants.nodes.len();
        self.ants.numbers[index as usize] = number as u32;
        self.ants.nodes.push(node);
        number
    }

    fn new_node(&self, index: u32) -> Node {
        let Problem { grid, start, goal } = *self.problem;
        let params = &self.ants.params;
        let cell = grid.cell(index);
        let (moves, force) = (Moves::allowed(grid, index, params.corner_rule), force(self.problem, params, cell));
        let strength = force.norm();
        let mut node = Node {
            index,
            moves,
            along_force: [0.0; 8],
            nearness: [0.0; 8],
            pheromone: [0.0; 8],
            laid: [0.0; 8],
            weights: [0.0; 8],
            weighed_in: None,
        };
        let centre = |cell: Cell| Vec2::new(f64::from(cell.col), f64::from(cell.row));
        for step in moves {
            let (k, to) = (step.direction(), step.from(cell));
            // Gains may be so large that a force is not finite: it has no direction then.
            if strength > 0.0 && strength.is_finite() {
                let way = centre(to) - centre(cell);
                node.along_force[k] = force.dot(&way) / (strength * way.norm());
            }
            node.nearness[k] = -math::ln(euclidean(to, goal) + DISTANCE_OFFSET_CELLS);
            node.pheromone[k] = self.untouched[usize::from(is_near_line(start, goal, to))];
        }
        node
    }

    /// Computes a node's weights, which stay during an iteration.
    fn weigh(&mut self, number: usize, iteration: u32) {
        let (node, params) = (&mut self.ants.nodes[number], &self.ants.params);
        if node.weighed_in == Some(iteration) {
            return;
        }
        node.weighed_in = Some(iteration);
        let left = 1.0 - f64::from(iteration) / f64::from(params.iterations.get());
        let xi = params.force_weight.get() * left;
        let (a, b) = (params.pheromone_exponent.get(), params.heuristic_exponent.get());
        for step in node.moves {
            let k = step.direction();
            let tau = node.pheromone[k];
            let of_pheromone = if a == 1.0 { tau } else { limited_exp(a * math::ln(tau)) };
            node.weights[k] = of_pheromone * limited_exp(b * (xi * node.along_force[k] + node.nearness[k]));
        }
    }

    /// Evaporates, and adds what has been laid.
    fn update(&mut self, iteration: u32) {
        let Some(best_cost) = self.best_cost else { return };
        let evaporation = self.ants.params.evaporation.get();
        let (mut low, mut high, mut scale) = (0.0, f64::INFINITY, 1.0);
        if self.ants.params.update == Update::MaxMin {
            lay(&mut self.ants.nodes, &self.ants.best, 1.0 / best_cost.value());
            (low, high) = bounds(evaporation, best_cost.value(), self.ants.best.len());
            if iteration == 0 {
                scale = high / FIRST_PHEROMONE[1];
            }
        }
        let next = |tau: f64, laid: f64| {
            let bounded = math::clamp((1.0 - evaporation) * (scale * tau) + laid, low, high);
            math::clamp(bounded, PHEROMONE_LEAST, 1.0 / PHEROMONE_LEAST)
        };
        for node in &mut self.ants.nodes {
            for (tau, laid) in node.pheromone.iter_mut().zip(&mut node.laid) {
                *tau = next(*tau, *laid);
                *laid = 0.0;
            }
        }
        for tau in &mut self.untouched {
            *tau = next(*tau, 0.0);
        }
    }
}

/// Lays an amount of pheromone on every step of a path.
fn lay(nodes: &mut [Node], path: &[Taken], amount: f64) {
    for step in path {
        nodes[step.node as usize].laid[step.by.direction()] += amount;
    }
}

/// τ_min and τ_max of Stützle and Hoos for a shortest path of `length` cells and `steps` steps.
fn bounds(evaporation: f64, length: f64, steps: usize) -> (f64, f64) {
    let high = 1.0 / (evaporation * length);
    let per_step = math::exp(math::ln(BEST_PATH_PROBABILITY) / steps as f64);
    let low = high * (1.0 - per_step) / ((CHOICES - 1.0) * per_step);
    (math::min(low, high), high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::{DistanceField, OccupancyGrid};
    use crate::observation::Belief;
    use crate::plan::Passability;
    use crate::plan::contract::{Budget, GridPlanner, Randomness, Situation};
    use crate::plan::global::a_star;
    use crate::plan::grid::tests::{drawn, random_cell, random_map, stream, uninflated};
    use crate::plan::grid::{ESCAPE_FACTOR, PlanningGrid};
    use crate::robot::Robot;

    fn cell(col: i32, row: i32) -> Cell {
        Cell { col, row }
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }

    /// A stream for one answer.
    fn ants_stream(episode: u64) -> Stream {
        EpisodeSeed { seed: 8_500_001, episode }.stream(Purpose::Planner, 0)
    }

    fn small(ants: u32, iterations: u32) -> Params {
        Params { ants: Count::new(ants), iterations: Count::new(iterations), ..Params::default() }
    }

    fn length(path: &[Cell]) -> f64 {
        path.windows(2).map(|pair| euclidean(pair[0], pair[1])).sum()
    }

    type Answer = (Result<(), Failure>, SearchEffort, Vec<Cell>);

    /// The answer of a fresh planner without limits.
    fn ask(params: &Params, problem: &Problem<'_>, stream: Stream) -> Answer {
        let mut path = vec![cell(7, 7)];
        let (result, effort) = Planner::new(params).search(problem, stream, u64::MAX, &mut path);
        (result, effort, path)
    }

    /// A shortest path.
    fn optimum(problem: &Problem<'_>) -> Option<f64> {
        let mut path = Vec::new();
        let search = a_star::Planner::new(&a_star::Params::default()).search(problem, &mut path);
        search.result.is_ok().then(|| length(&path))
    }

    #[test]
    fn forces_and_probabilities_are_those_of_the_formulas_by_hand() {
        let (_, grid) = drawn(&[
            "....", //
            ".#..", //
            "....", //
        ]);
        let problem = Problem { grid: &grid, start: cell(0, 0), goal: cell(3, 0) };
        // Repulsion at a distance of 1: 1/2; of √2: (1/√2 − 1/2) / 2 = 0.1035533906, of which 0.0732233047 along each axis; of 2: none.
        // Nothing comes from the border.
        for (at, x, y) in [
            (cell(0, 0), 3.0 - 0.073_223_304_7, -0.073_223_304_7),
            (cell(1, 0), 2.0, -0.5),
            (cell(2, 0), 1.0 + 0.073_223_304_7, -0.073_223_304_7),
            (cell(0, 1), 3.0 - 0.5, -1.0),
            (cell(2, 2), 1.0 + 0.073_223_304_7, -2.0 + 0.073_223_304_7),
            (cell(3, 1), 0.0, -1.0),
        ] {
            let force = force(&problem, &Params::default(), at);
            close(force.x, x);
            close(force.y, y);
        }
        // From the start: E, 2 cells from the goal and in the band of half width 0.6; N, √10 from it and 1 beside the line.
        // cos θ = 0.9996871864 and −0.0250105857. With ξ = 2 and ξ = 1:
        let by_hand = [
            (1.0, 0, 7.032_794_999_85, 0.291_578_272_88),
            (1.0, 1, 2.588_030_138_90, 0.298_962_776_72),
            (7.0, 0, 13_295.838_582_247_3, 0.000_179_178_589_7),
            (7.0, 1, 12.150_812_890_01, 0.000_213_461_634_1),
        ];
        for (b, iteration, east, north) in by_hand {
            let params = Params { heuristic_exponent: NonNegative::new(b), ..small(1, 2) };
            let mut planner = Planner::new(&params);
            let mut colony = planner.colony(&problem, ants_stream(0), u64::MAX);
            let number = colony.node_at(grid.index(problem.start));
            colony.weigh(number, iteration);
            let node = &colony.ants.nodes[number];
            assert_eq!(node.moves.collect::<Vec<_>>(), [Move::E, Move::N]);
            assert!((node.weights[Move::E.direction()] / east - 1.0).abs() < 1e-9);
            assert!((node.weights[Move::N.direction()] / north - 1.0).abs() < 1e-8);
        }
        // Ants go that way that often: N with 0.2915782729 / (0.2915782729 + 7.0327949999) = 0.0398093136.
        let params = Params { heuristic_exponent: NonNegative::new(1.0), ..small(1, 2) };
        let mut planner = Planner::new(&params);
        let mut colony = planner.colony(&problem, ants_stream(1), u64::MAX);
        let count = 40_000;
        let north = (0..count)
            .filter(|_| {
                colony.walk(0).unwrap();
                // (0, 1) leads to the goal as well, so the first step stays.
                colony.ants.trail[0].by == Move::N
            })
            .count();
        // Four standard deviations: 4 √(0.0398 · 0.9602 / 40000) = 0.0039.
        assert!((north as f64 / f64::from(count) - 0.039_809_313_6).abs() < 0.0039, "{north}");
    }

    #[test]
    fn pheromone_is_that_of_the_formulas_by_hand() {
        let (_, grid) = drawn(&["...."]);
        let problem = Problem { grid: &grid, start: cell(0, 0), goal: cell(3, 0) };
        // All steps are on the line, 2 each. Two ants go E three times: L = 3. (1, 0) has a way back too.
        let there_and_back = |update| {
            let params = Params { update, deposit: Positive::new(6.0), ..small(2, 3) };
            let mut planner = Planner::new(&params);
            let mut colony = planner.colony(&problem, ants_stream(2), u64::MAX);
            let mut seen = Vec::new();
            for iteration in 0..3 {
                let number = colony.node_at(grid.index(cell(1, 0)));
                let tau = colony.ants.nodes[number].pheromone;
                seen.push([tau[Move::E.direction()], tau[Move::W.direction()]]);
                colony.iterate(iteration).unwrap();
            }
            seen
        };
        let check = |update, expected: [[f64; 2]; 3]| {
            for (seen, expected) in there_and_back(update).into_iter().flatten().zip(expected.into_iter().flatten()) {
                close(seen, expected);
            }
        };
        // 0.7 τ, and 2 · 6 / 3 where the ants went.
        check(Update::AntSystem, [[2.0, 2.0], [5.4, 1.4], [7.78, 0.98]]);
        // τ_max = 1 / 0.9; p = 0.05^(1/3) = 0.3684031499, τ_min = 0.6349694876. What was 2 is τ_max; where the ants went
        // 0.7 τ_max + 1/3 = τ_max, else 0.7 τ_max and then, for 0.49 τ_max is less, τ_min.
        let high = 1.0 / 0.9;
        check(Update::MaxMin, [[2.0, 2.0], [high, 0.7 * high], [high, 0.634_969_487_63]]);
    }

    /// The method once more, as the formulas stand: every step of the map has its pheromone, and nothing is kept or put off.
    /// The best length after each iteration, the last path and the work; `None` where an ant finds no way.
    fn by_the_book(
        params: &Params,
        problem: &Problem<'_>,
        mut stream: Stream,
    ) -> Option<(Vec<f64>, Vec<Cell>, [u64; 2])> {
        const AROUND: [(i32, i32); 8] = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];
        let Problem { grid, start, goal } = *problem;
        let power = |x: f64, y: f64| math::exp(y * math::ln(x));
        let at = |c: Cell| (c.row * grid.cols() + c.col) as usize;
        let may_step = |from: Cell, (dx, dy): (i32, i32)| {
            let beside = [cell(from.col + dx, from.row), cell(from.col, from.row + dy)];
            let free_beside = beside.into_iter().filter(|&c| grid.is_passable(c)).count();
            let needed = match params.corner_rule {
                CornerRule::Forbid => 2,
                CornerRule::OneFree => 1,
                CornerRule::Allow => 0,
            };
            grid.is_passable(cell(from.col + dx, from.row + dy)) && (dx == 0 || dy == 0 || free_beside >= needed)
        };
        let cost = |path: &[Cell]| -> f64 {
            let is_dear = |c: &Cell| grid.passability(*c) == Passability::Escape;
            let step = |pair: &[Cell]| {
                let factor = if pair.iter().any(is_dear) { f64::from(ESCAPE_FACTOR) } else { 1.0 };
                factor * euclidean(pair[0], pair[1])
            };
            path.windows(2).map(step).sum()
        };
        let all: Vec<Cell> =
            (0..grid.rows()).flat_map(|row| (0..grid.cols()).map(move |col| Cell { col, row })).collect();
        let d = euclidean(start, goal);
        let mut tau = vec![[0.0; 8]; all.len()];
        for &from in &all {
            for (k, (dx, dy)) in AROUND.into_iter().enumerate() {
                // Distance from the segment, by its share of the way.
                let (x, y) = (f64::from(from.col + dx - start.col), f64::from(from.row + dy - start.row));
                let (gx, gy) = (f64::from(goal.col - start.col), f64::from(goal.row - start.row));
                let share = math::clamp((x * gx + y * gy) / (d * d), 0.0, 1.0);
                let beside = math::hypot(x - share * gx, y - share * gy);
                tau[at(from)][k] = if beside <= 0.2 * d + 1e-12 { 2.0 } else { 1.0 };
            }
        }
        let (mut best, mut history, mut work) = (Vec::new(), Vec::new(), [0, 0]);
        for t in 0..params.iterations.get() {
            let xi = params.force_weight.get() * (1.0 - f64::from(t) / f64::from(params.iterations.get()));
            let eta = |from: Cell, (dx, dy): (i32, i32)| {
                let (mut fx, mut fy) = (f64::from(goal.col - from.col), f64::from(goal.row - from.row));
                for obstacle in all.iter().filter(|&&c| !grid.is_passable(c)) {
                    let rho = euclidean(*obstacle, from);
                    if rho <= 2.0 {
                        let push = (1.0 / rho - 0.5) / (rho * rho);
                        fx += push * f64::from(from.col - obstacle.col) / rho;
                        fy += push * f64::from(from.row - obstacle.row) / rho;
                    }
                }
                let (dot, lengths) = (
                    fx * f64::from(dx) + fy * f64::from(dy),
                    math::hypot(fx, fy) * math::hypot(f64::from(dx), f64::from(dy)),
                );
                let cos = if lengths > 0.0 { dot / lengths } else { 0.0 };
                math::exp(xi * cos) / (euclidean(cell(from.col + dx, from.row + dy), goal) + 0.1)
            };
            let mut paths = Vec::new();
            for _ in 0..params.ants.get() {
                let (mut path, mut been) = (vec![start], vec![false; all.len()]);
                been[at(start)] = true;
                while let Some(&from) = path.last() {
                    if from == goal {
                        break;
                    }
                    work[0] += 1;
                    let ways: Vec<(usize, Cell, f64)> = (0..8)
                        .filter(|&k| may_step(from, AROUND[k]))
                        .map(|k| (k, cell(from.col + AROUND[k].0, from.row + AROUND[k].1)))
                        .filter(|(_, to)| !been[at(*to)])
                        .map(|(k, to)| {
                            let (a, b) = (params.pheromone_exponent.get(), params.heuristic_exponent.get());
                            (k, to, power(tau[at(from)][k], a) * power(eta(from, AROUND[k]), b))
                        })
                        .collect();
                    work[1] += ways.len() as u64;
                    if ways.is_empty() {
                        path.pop();
                        continue;
                    }
                    let mut drawn = stream.uniform() * ways.iter().map(|way| way.2).sum::<f64>();
                    let mut to = ways[ways.len() - 1].1;
                    for way in &ways {
                        if drawn < way.2 {
                            to = way.1;
                            break;
                        }
                        drawn -= way.2;
                    }
                    been[at(to)] = true;
                    path.push(to);
                }
                if path.is_empty() {
                    return None;
                }
                if best.is_empty() || cost(&path) < cost(&best) - 1e-9 {
                    best.clone_from(&path);
                }
                paths.push(path);
            }
            history.push(cost(&best));
            let (rho, top) = (params.evaporation.get(), 1.0 / (params.evaporation.get() * cost(&best)));
            let is_max_min = params.update == Update::MaxMin;
            for tau in tau.iter_mut().flatten() {
                *tau *= (1.0 - rho) * if is_max_min && t == 0 { top / 2.0 } else { 1.0 };
            }
            if is_max_min {
                paths = vec![best.clone()];
            }
            for path in &paths {
                for pair in path.windows(2) {
                    let step = (pair[1].col - pair[0].col, pair[1].row - pair[0].row);
                    tau[at(pair[0])][AROUND.iter().position(|&around| around == step).unwrap()] += 1.0 / cost(path);
                }
            }
            if is_max_min {
                let p = power(0.05, 1.0 / (best.len() - 1) as f64);
                let bottom = math::min(top * (1.0 - p) / (3.0 * p), top);
                tau.iter_mut().flatten().for_each(|tau| *tau = math::clamp(*tau, bottom, top));
            }
        }
        Some((history, best, work))
    }

    #[test]
    fn answers_are_those_of_the_method_by_the_book() {
        let mut stream = stream(101);
        let (mut found, mut escaped) = (0, 0);
        for case in 0..240 {
            let share = stream.range(0.0, 0.35);
            let map = random_map(&mut stream, 12, share);
            let inflation_m = [0.0, 0.8][case as usize % 2] * map.resolution_m();
            let (start, goal) = (random_cell(&mut stream, &map), random_cell(&mut stream, &map));
            let mut grid = PlanningGrid::new(&map, &DistanceField::new(&map), inflation_m);
            grid.open_around(&map, start);
            grid.open_around(&map, goal);
            let problem = Problem { grid: &grid, start, goal };
            if problem.check_ends().is_err() || start == goal {
                continue;
            }
            let params = Params {
                corner_rule: [CornerRule::Forbid, CornerRule::OneFree, CornerRule::Allow][case as usize % 3],
                update: if case % 4 < 2 { Update::MaxMin } else { Update::AntSystem },
                heuristic_exponent: NonNegative::new([7.0, 2.0][case as usize / 4 % 2]),
                pheromone_exponent: NonNegative::new([1.0, 1.5][case as usize / 8 % 2]),
                ..small(6, 8)
            };
            let (result, effort, path) = ask(&params, &problem, ants_stream(case));
            let Some((history, expected, [expanded, generated])) = by_the_book(&params, &problem, ants_stream(case))
            else {
                assert_eq!((result, path), (Err(Failure::NoPath), vec![]));
                continue;
            };
            assert_eq!((result, path), (Ok(()), expected));
            assert_eq!(effort, SearchEffort { expanded, generated });
            let mut planner = Planner::new(&params);
            let mut colony = planner.colony(&problem, ants_stream(case), u64::MAX);
            for (iteration, length) in history.into_iter().enumerate() {
                colony.iterate(iteration as u32).unwrap();
                assert!((colony.best_cost.unwrap().value() / length - 1.0).abs() < 1e-9);
            }
            found += 1;
            escaped += u32::from(grid.has_escape_zone());
        }
        assert!(found > 80 && escaped > 20, "{found} {escaped}");
    }

    #[test]
    fn paths_are_valid_and_a_used_planner_answers_like_a_fresh_one() {
        let mut stream = stream(102);
        let rules = [CornerRule::Forbid, CornerRule::OneFree, CornerRule::Allow];
        let mut used = rules.map(|corner_rule| Planner::new(&Params { corner_rule, ..small(5, 4) }));
        let (mut found, mut longer) = (0, 0);
        for case in 0..600 {
            let share = stream.range(0.0, 0.45);
            let side = [3, 12, 30][stream.index(3)];
            let map = random_map(&mut stream, side, share);
            let grid = uninflated(&map);
            let problem =
                Problem { grid: &grid, start: random_cell(&mut stream, &map), goal: random_cell(&mut stream, &map) };
            for (corner_rule, planner) in rules.into_iter().zip(&mut used) {
                let mut path = vec![problem.goal];
                let (result, effort) = planner.search(&problem, ants_stream(case), u64::MAX, &mut path);
                let fresh = ask(&planner.params, &problem, ants_stream(case));
                assert_eq!((&result, effort, &path), (&fresh.0, fresh.1, &fresh.2));
                let mut shortest = Vec::new();
                let reference = a_star::Params { corner_rule, ..a_star::Params::default() };
                let expected = a_star::Planner::new(&reference).search(&problem, &mut shortest).result;
                assert_eq!(result, expected);
                if result.is_err() {
                    assert!(path.is_empty());
                    continue;
                }
                found += 1;
                longer += u32::from(length(&path) > length(&shortest) + 1e-9);
                assert_eq!((path[0], path[path.len() - 1]), (problem.start, problem.goal));
                let mut sorted = path.clone();
                sorted.sort_by_key(|cell| (cell.row, cell.col));
                assert!(sorted.windows(2).all(|pair| pair[0] != pair[1]), "a cell twice: {path:?}");
                for pair in path.windows(2) {
                    let (from, to) = (pair[0], pair[1]);
                    let (dx, dy) = (to.col - from.col, to.row - from.row);
                    assert!(dx.abs() <= 1 && dy.abs() <= 1 && grid.is_passable(to));
                    let beside = [cell(to.col, from.row), cell(from.col, to.row)];
                    let free = beside.into_iter().filter(|&c| grid.is_passable(c)).count();
                    let needed = [2, 1, 0][corner_rule as usize];
                    assert!(dx == 0 || dy == 0 || free >= needed, "{corner_rule:?}: {pair:?}");
                }
            }
        }
        assert!(found > 400 && longer > 20, "{found} {longer}");
    }

    #[test]
    fn where_there_is_no_way_one_ant_shows_it() {
        let (_, grid) = drawn(&[
            "...#.", //
            ".#.#.", //
            "...#.", //
        ]);
        let params = Params::default();
        let problem = Problem { grid: &grid, start: cell(0, 0), goal: cell(4, 1) };
        let (result, effort, path) = ask(&params, &problem, ants_stream(0));
        assert_eq!((result, path), (Err(Failure::NoPath), vec![]));
        // Eight cells within reach: seven steps on, and one back from each, that from the start being the end.
        assert_eq!(effort.expanded, 15);
        let fails = |start, goal, failure| {
            let answer = ask(&params, &Problem { grid: &grid, start, goal }, ants_stream(0));
            assert_eq!(answer, (Err(failure), SearchEffort::default(), vec![]));
        };
        fails(cell(1, 1), cell(3, 1), Failure::StartOccupied);
        fails(cell(-1, 1), cell(0, 0), Failure::StartOccupied);
        fails(cell(0, 0), cell(3, 1), Failure::GoalOccupied);
        fails(cell(0, 0), cell(5, 0), Failure::GoalOccupied);
        let stays = ask(&params, &Problem { grid: &grid, start: cell(2, 1), goal: cell(2, 1) }, ants_stream(0));
        assert_eq!(stays, (Ok(()), SearchEffort::default(), vec![cell(2, 1)]));
    }

    #[test]
    fn the_budget_is_the_steps_of_the_ants() {
        let map = random_map(&mut stream(103), 20, 0.15);
        let grid = uninflated(&map);
        let free = || (0..map.occupied().len()).map(|index| map.cell(index)).filter(|&c| grid.is_passable(c));
        let problem = Problem { grid: &grid, start: free().next().unwrap(), goal: free().next_back().unwrap() };
        let params = small(4, 3);
        let (result, effort, best) = ask(&params, &problem, ants_stream(0));
        assert_eq!(result, Ok(()));
        let mut path = Vec::new();
        let mut planner = Planner::new(&params);
        let enough = planner.search(&problem, ants_stream(0), effort.expanded, &mut path);
        assert_eq!((enough, &path), ((Ok(()), effort), &best));
        for short in [effort.expanded - 1, 10, 0] {
            let (result, effort) = planner.search(&problem, ants_stream(0), short, &mut path);
            assert_eq!((result, effort.expanded, path.len()), (Err(Failure::OutOfBudget), short, 0));
        }
    }

    /// Maps of 20 × 20 cells, 15 to 20 % of them blocked, with a way between opposite corners; and its length.
    fn corner_to_corner(count: usize) -> Vec<(PlanningGrid, f64)> {
        let mut maps = Vec::new();
        for seed in 8_500_100.. {
            let mut stream = EpisodeSeed { seed, episode: 0 }.stream(Purpose::Map, 0);
            let share = stream.range(0.15, 0.2);
            let mut map = OccupancyGrid::empty(20, 20, 1.0);
            for index in 1..399 {
                if stream.uniform() < share {
                    map.set_occupied(map.cell(index));
                }
            }
            let grid = uninflated(&map);
            let shortest = optimum(&Problem { grid: &grid, start: cell(0, 0), goal: cell(19, 19) });
            maps.extend(shortest.map(|shortest| (grid, shortest)));
            if maps.len() == count {
                break;
            }
        }
        maps
    }

    #[test]
    fn paths_get_shorter_with_the_iterations_of_a_run_and_from_run_to_run() {
        let maps = corner_to_corner(30);
        // Mean length over the shortest one, of runs with so many iterations.
        let mean = |update, iterations| {
            let params = Params { update, ..small(50, iterations) };
            let mut planner = Planner::new(&params);
            let mut sum = 0.0;
            for (number, (grid, shortest)) in maps.iter().enumerate() {
                let problem = Problem { grid, start: cell(0, 0), goal: cell(19, 19) };
                let mut colony = planner.colony(&problem, ants_stream(number as u64), u64::MAX);
                let mut best = f64::INFINITY;
                for iteration in 0..iterations {
                    colony.iterate(iteration).unwrap();
                    let now = colony.best_cost.unwrap().value();
                    assert!(now <= best && now >= shortest - 1e-9);
                    best = now;
                }
                sum += best / shortest;
            }
            sum / maps.len() as f64
        };
        let means = |update| [1, 10, 100].map(|iterations| mean(update, iterations));
        let (max_min, ant_system) = (means(Update::MaxMin), means(Update::AntSystem));
        let [one, ten, hundred] = max_min;
        assert!(hundred <= ten && ten <= one && hundred < 1.05, "{max_min:?}");
        // Why `max_min` is the default.
        assert!(ant_system[2] > ant_system[1] && hundred < ant_system[2], "{ant_system:?}");
    }

    #[test]
    fn seeds_and_ticks_decide_and_nothing_else() {
        let map = OccupancyGrid::empty(20, 20, 1.0);
        let (robot, belief, grid) = (Robot::default(), Belief::from(&map), uninflated(&map));
        let (start, goal) = (grid.centre(cell(2, 3)), grid.centre(cell(17, 9)));
        let params = small(2, 2);
        let plan_at = |seed, tick| {
            let random = Randomness::new(EpisodeSeed { seed, episode: 0 }, tick);
            let situation =
                Situation { random, ..Situation::new(&robot, &belief, Pose { position: start, theta: 0.0 }, goal) };
            let mut plan = Plan::default();
            let task = Task { situation: &situation, grid: &grid, start, goal };
            Planner::new(&params).plan(&task, &mut plan).unwrap();
            plan
        };
        let first = plan_at(8_600_000, 0);
        assert_eq!(first, plan_at(8_600_000, 0));
        assert_eq!((first.path.start(), first.path.end()), (start, goal));
        let others = (1..=20).flat_map(|k| [plan_at(8_600_000 + k, 0), plan_at(8_600_000, k as u32)]);
        let different = others.filter(|plan| plan.cells != first.cells).count();
        assert!(different >= 30, "{different} of 40");
        let situation = Situation {
            budget: Budget { expansions: 5, ..Budget::default() },
            ..Situation::new(&robot, &belief, Pose { position: start, theta: 0.0 }, goal)
        };
        let mut plan = first;
        let answer = Planner::new(&params).plan(&Task { situation: &situation, grid: &grid, start, goal }, &mut plan);
        assert_eq!((answer, plan.effort.expanded, plan.cells.len()), (Err(Failure::OutOfBudget), 5, 0));
    }

    #[test]
    fn no_parameters_stop_the_ants() {
        let map = random_map(&mut stream(104), 20, 0.1);
        let grid = uninflated(&map);
        let free = || (0..map.occupied().len()).map(|index| map.cell(index)).filter(|&c| grid.is_passable(c));
        let problem = Problem { grid: &grid, start: free().next().unwrap(), goal: free().next_back().unwrap() };
        assert!(optimum(&problem).is_some());
        for number in [0.0, f64::MIN_POSITIVE, 1.0, 1e3, f64::MAX] {
            let any = NonNegative::new(number);
            let positive = Positive::new(if number == 0.0 { 1e-300 } else { number });
            for changed in [
                Params { pheromone_exponent: any, ..small(5, 30) },
                Params { heuristic_exponent: any, ..small(5, 30) },
                Params { attraction_gain: any, ..small(5, 30) },
                Params { repulsion_gain: any, ..small(5, 30) },
                Params { force_weight: any, ..small(5, 30) },
                Params { attraction_gain: any, repulsion_gain: any, force_weight: any, ..small(5, 30) },
                Params { deposit: positive, repulsion_range_cells: positive, ..small(5, 30) },
                Params {
                    evaporation: PositiveFraction::new(math::max(math::min(number, 1.0), 1e-300)),
                    ..small(5, 30)
                },
            ] {
                for update in [Update::MaxMin, Update::AntSystem] {
                    let mut planner = Planner::new(&Params { update, ..changed.clone() });
                    let mut path = Vec::new();
                    let (result, _) = planner.search(&problem, ants_stream(0), u64::MAX, &mut path);
                    assert_eq!((result, path.last()), (Ok(()), Some(&problem.goal)), "{changed:?}");
                    let finite = |node: &Node| {
                        node.moves.into_iter().all(|step| {
                            let (tau, weight) = (node.pheromone[step.direction()], node.weights[step.direction()]);
                            tau.is_finite() && tau > 0.0 && weight.is_finite() && (weight > 0.0)
                        })
                    };
                    assert!(planner.nodes.iter().all(finite), "{changed:?}");
                }
            }
        }
    }
}
