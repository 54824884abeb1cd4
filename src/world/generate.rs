//! Draws a scene from its specification.
//!
//! Order: fixed unknown statics, start and goal, reference route, random unknown statics, movers (which
//! reflect on the statics). Every obstacle draws from a stream of its own, (purpose, entry of the list, number within
//! the entry): appending one, or raising a count, leaves the bits of the others as they were. (An unknown static
//! that is added *before* others in the list may push those that it now overlaps to another of their own draws.)
//!
//! A scene is feasible if the footprint fits at start and goal and a disc of the clearance below can go
//! from one to the other over the cell centres of the true map, in which every cell that an unknown static touches
//! is occupied. The clearance is the larger of footprint radius and inflation, so that what is feasible is
//! so on the planning grid as well; where a given start or goal lies inside the inflated zone, the footprint alone.
//! Every draw is bounded; what cannot be placed within [`TRIES`] draws makes the scene infeasible, which is a result.

use super::DT_S;
use super::floor::Floor;
use super::motion::{Irregular, Motion, Patrol, Replay, Sample};
use super::mover::free_run;
use super::obstacle::{Body, Mover, Outline, SLACK_M, Shape, UnknownStatic};
use super::recording::Recording;
use super::route::reference_route;
use super::scene::Scene;
use super::script::{Change, Event};
use super::spec::moving::{Heading, MotionChoice};
use super::spec::{
    CellPlace, EventChoice, GoalSpec, MovingChoice, PlacementChoice, RandomPlace, SceneSpec, ScriptEntry, StartSpec,
    UnknownStaticChoice, moving, unknown_static,
};
use super::statics::{StaticMap, Statics};
use crate::geometry::{Path, Pose, Vec2, direction};
use crate::map::{Cell, OccupancyGrid};
use crate::math;
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::robot::{OutlineCorners, Robot};
use crate::settings::quantity::{CountOrZero, Finite, Fraction, NonNegative, Positive};
use std::sync::Arc;

/// Draws for one start and goal, one unknown static or one mover.
const TRIES: u32 = 1000;

/// No feasible scene was found: an outcome of the episode, not an error.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Infeasible {
    /// What could not be placed.
    pub message: String,
}

impl Infeasible {
    fn new(message: impl Into<String>) -> Self {
        Self { message: message.into() }
    }
}

/// A part of a specification that no draw can mend: what is given cannot stand where it is given.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {message}")]
pub struct SceneError {
    /// The key relative to the scenario's root, such as `start` or `obstacles.moving[2].fixed.position`.
    pub key: String,
    /// What is wrong: cell, position, what is in the way.
    pub message: String,
}

impl SceneError {
    fn new(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { key: key.into(), message: message.into() }
    }
}

impl SceneSpec {
    /// Checks everything that does not depend on a draw: given places against the map and each other, ranges, velocities.
    ///
    /// # Errors
    /// The first place in file order (start, goal, unknown statics, movers) that cannot be.
    pub fn check(&self, map: &StaticMap, robot: &Robot) -> Result<(), SceneError> {
        let unknown = self.obstacles.fixed_statics(&map.grid);
        let statics = Statics { map, unknown: &unknown };
        let start = self.start.given(&map.grid);
        if let Some((position, theta)) = start {
            check_fits("start", position, theta, robot, &statics)?;
        }
        if let Some(goal) = self.goal.given(&map.grid) {
            check_fits("goal", goal, None, robot, &statics)?;
        }
        for (entry, choice) in self.obstacles.unknown_static.iter().enumerate() {
            let key = format!("obstacles.unknown_static[{entry}].{}", choice.name());
            match choice {
                UnknownStaticChoice::fixed(params) => {
                    let p = params.pose(&map.grid).position;
                    if map.edge_distance_m(p) < 0.0 {
                        return Err(SceneError::new(format!("{key}.pose"), outside(p, map)));
                    }
                }
                UnknownStaticChoice::random(params) => {
                    if let PlacementChoice::on_route(placement) = &params.placement {
                        let share = placement.share.map(Fraction::get);
                        check_range(&format!("{key}.placement.on_route.share"), share)?;
                    }
                }
            }
        }
        let mut recordings = self.recordings.iter();
        for (entry, choice) in self.obstacles.moving.iter().enumerate() {
            let key = format!("obstacles.moving[{entry}].{}", choice.name());
            match choice {
                MovingChoice::fixed(params) => {
                    params.velocity(&map.grid).map_err(|message| SceneError::new(&*key, message))?;
                    check_motion(&key, &params.motion)?;
                    let key = format!("{key}.position");
                    let position = point(params.position, &map.grid);
                    let outline = params.outline(&map.grid);
                    if params.on_static != moving::OnStatic::Pass {
                        if map.edge_distance_m(position) < 0.0 {
                            return Err(SceneError::new(key, outside(position, map)));
                        }
                        let gap = statics.gap_m(&outline, position);
                        if gap < -SLACK_M {
                            let overlap = format!("overlaps a static obstacle or the map's edge by {:.3} m", -gap);
                            return Err(SceneError::new(key, format!("the mover {}", at(position, map, &overlap))));
                        }
                    }
                    if let Some((start, _)) = start
                        && (start - position).norm() < outline.circumradius_m() + robot.radius_m
                    {
                        return Err(SceneError::new(key, "the mover overlaps the robot at its start"));
                    }
                }
                MovingChoice::random(params) => {
                    check_range(&format!("{key}.speed_mps"), params.speed_mps.map(NonNegative::get))?;
                    check_motion(&key, &params.motion)?;
                }
                MovingChoice::crossing(params) => {
                    check_range(&format!("{key}.speed_mps"), params.speed_mps.map(NonNegative::get))?;
                    check_range(&format!("{key}.share"), params.share.map(Fraction::get))?;
                }
                MovingChoice::patrol(params) => {
                    check_patrol(&key, params, start.map(|(position, _)| position), robot, &statics)?
                }
                MovingChoice::replay(params) => {
                    let recording = recordings.next();
                    let missing = params.ids.iter().flatten().find(|id| {
                        recording.is_some_and(|recording| recording.tracks().all(|(known, _)| known != **id))
                    });
                    if let Some(id) = missing {
                        return Err(SceneError::new(format!("{key}.ids"), format!("the recording has no id {id}")));
                    }
                }
            }
        }
        self.check_script(robot, &statics)
    }

    fn check_script(&self, robot: &Robot, statics: &Statics<'_>) -> Result<(), SceneError> {
        let kinds = self.kinds_of_movers();
        for (entry, ScriptEntry { at_s, event }) in self.script.iter().enumerate() {
            let key = format!("script[{entry}].event.{}", event.name());
            let mover = match event {
                EventChoice::obstacle(params) => {
                    let [x, y, _] = params.pose;
                    let p = point([x, y], &statics.map.grid);
                    if statics.map.edge_distance_m(p) < 0.0 {
                        return Err(SceneError::new(format!("{key}.pose"), outside(p, statics.map)));
                    }
                    if let Some(until_s) = params.until_s.filter(|until_s| until_s <= at_s) {
                        let message =
                            format!("it would vanish ({} s) before it appears ({} s)", until_s.get(), at_s.get());
                        return Err(SceneError::new(format!("{key}.until_s"), message));
                    }
                    continue;
                }
                EventChoice::goal(params) => {
                    let known = Statics { map: statics.map, unknown: &[] };
                    check_fits(&format!("{key}.to"), point(params.to, &statics.map.grid), None, robot, &known)?;
                    continue;
                }
                EventChoice::wheel_slip(params) => {
                    check_range(&format!("{key}.left"), params.left.map(Fraction::get))?;
                    check_range(&format!("{key}.right"), params.right.map(Fraction::get))?;
                    continue;
                }
                EventChoice::sensor_range(_) => continue,
                EventChoice::mover_appears(params) => params.mover,
                EventChoice::mover_vanishes(params) => params.mover,
                EventChoice::mover_stops(params) => params.mover,
                EventChoice::mover_starts(params) => params.mover,
                EventChoice::mover_velocity(params) => params.mover,
            };
            let (mover, count) = (mover.get(), kinds.len());
            let message = match kinds.get(mover as usize) {
                None => format!("there is no mover {mover}: `obstacles.moving` gives {count}, numbered from 0"),
                Some(&"replay") => format!("mover {mover} replays a recording and does nothing else"),
                Some(&"patrol") if matches!(event, EventChoice::mover_velocity(_)) => {
                    format!("mover {mover} is on patrol and has no velocity of its own")
                }
                Some(_) => continue,
            };
            return Err(SceneError::new(format!("{key}.mover"), message));
        }
        Ok(())
    }

    /// The kind of each mover, in the scene's order.
    fn kinds_of_movers(&self) -> Vec<&'static str> {
        let mut recordings = self.recordings.iter();
        let kinds = self.obstacles.moving.iter().flat_map(|choice| {
            let count = match choice {
                MovingChoice::fixed(_) | MovingChoice::patrol(_) => 1,
                MovingChoice::random(params) => params.count.get() as usize,
                MovingChoice::crossing(params) => params.count.get() as usize,
                MovingChoice::replay(params) => recordings.next().map_or(0, |recording| {
                    let plays = |id: &u64| params.ids.as_ref().is_none_or(|ids| ids.contains(id));
                    recording.tracks().filter(|(id, _)| plays(id)).count()
                }),
            };
            core::iter::repeat_n(choice.name(), count)
        });
        kinds.collect()
    }
}

fn check_range(key: &str, [low, high]: [f64; 2]) -> Result<(), SceneError> {
    if low <= high {
        return Ok(());
    }
    Err(SceneError::new(key, format!("expected [lowest, highest], found [{low}, {high}]")))
}

fn check_motion(key: &str, motion: &MotionChoice) -> Result<(), SceneError> {
    let MotionChoice::irregular(params) = motion else { return Ok(()) };
    let key = format!("{key}.motion.irregular");
    check_range(&format!("{key}.interval_s"), params.interval_s.map(Positive::get))?;
    params.speed_mps.map_or(Ok(()), |speed| check_range(&format!("{key}.speed_mps"), speed.map(NonNegative::get)))
}

/// Whether a patrol has a way to go and the mover fits on it.
fn check_patrol(
    key: &str,
    params: &moving::patrol::Params,
    start: Option<Vec2>,
    robot: &Robot,
    statics: &Statics<'_>,
) -> Result<(), SceneError> {
    let map = statics.map;
    let key_of = |index: usize| format!("{key}.waypoints[{index}]");
    let places: Vec<Vec2> = params.waypoints.iter().map(|&place| point(place, &map.grid)).collect();
    let count = places.len();
    if count < 2 {
        let message = format!("a patrol needs at least two waypoints, found {count}");
        return Err(SceneError::new(format!("{key}.waypoints"), message));
    }
    let outline = params.outline(&map.grid);
    if start.is_some_and(|start| (start - places[0]).norm() < outline.circumradius_m() + robot.radius_m) {
        return Err(SceneError::new(key_of(0), "the mover overlaps the robot at its start"));
    }
    let legs = if params.closed && count > 2 { count } else { count - 1 };
    for (from, to) in (0..legs).map(|leg| (leg, (leg + 1) % count)) {
        let (a, b) = (places[from], places[to]);
        if a == b {
            return Err(SceneError::new(key_of(to), "the same place as the waypoint before it"));
        }
        if params.on_static == moving::OnStatic::Pass {
            continue;
        }
        if map.edge_distance_m(a) < 0.0 {
            return Err(SceneError::new(key_of(from), outside(a, map)));
        }
        let fits = statics.gap_m(&outline, a) >= -SLACK_M;
        if !fits || statics.sweep(&outline.with_slack(), a, b - a, 1.0).is_some() {
            let message = if fits {
                format!("a static obstacle or the map's edge is in the way to waypoint {to}")
            } else {
                format!("the mover {}", at(a, map, "overlaps a static obstacle or the map's edge"))
            };
            return Err(SceneError::new(key_of(from), format!("{message}; `on_static: pass` goes through")));
        }
    }
    Ok(())
}

/// Whether the footprint fits at `p` with the heading `theta`; where that is open, whether it fits with any.
fn check_fits(key: &str, p: Vec2, theta: Option<f64>, robot: &Robot, statics: &Statics<'_>) -> Result<(), SceneError> {
    let map = statics.map;
    if map.edge_distance_m(p) < 0.0 {
        return Err(SceneError::new(key, outside(p, map)));
    }
    let body = match theta {
        Some(theta) => robot.body(Pose { position: p, theta }),
        None => Body { position: p, radius_m: robot.inscribed_radius_m(), corners: None },
    };
    let unknown = statics.unknown.iter().enumerate();
    let unknown = unknown.map(|(index, obstacle)| {
        (format!("unknown static number {index} given in the scenario"), obstacle.gap_m(&body), obstacle.distance_m(p))
    });
    let known = ("a known obstacle".to_owned(), map.obstacle_gap_m(&body), map.obstacle_distance_m(p, f64::INFINITY));
    let edge = ("the map's edge".to_owned(), map.edge_gap_m(&body), map.edge_distance_m(p));
    match [known, edge].into_iter().chain(unknown).find(|&(_, gap_m, _)| gap_m < -SLACK_M) {
        None => Ok(()),
        Some((what, _, distance_m)) if distance_m <= 0.0 => {
            Err(SceneError::new(key, at(p, map, &format!("lies inside {what}"))))
        }
        Some((what, gap_m, distance_m)) => {
            let room = match body.corners {
                None => format!("(radius {} m): {distance_m:.3} m to {what}", body.radius_m),
                Some(_) => format!("with that heading: its footprint overlaps {what} by {:.3} m", -gap_m),
            };
            Err(SceneError::new(key, at(p, map, &format!("leaves no room for the robot {room}"))))
        }
    }
}

fn at(p: Vec2, map: &StaticMap, what: &str) -> String {
    let cell = map.grid.cell_at(p);
    let world = map.grid.frame().point_to_world(p);
    format!("at [{:.3}, {:.3}], in cell [{}, {}], {what}", world.x, world.y, cell.col, cell.row)
}

fn outside(p: Vec2, map: &StaticMap) -> String {
    let (cols, rows) = (map.grid.cols(), map.grid.rows());
    at(p, map, &format!("lies outside the map of {cols} by {rows} cells"))
}

fn point(position: [Finite; 2], grid: &OccupancyGrid) -> Vec2 {
    grid.frame().point_to_grid(Vec2::new(position[0].get(), position[1].get()))
}

fn centre(cell: CellPlace, grid: &OccupancyGrid) -> Vec2 {
    let [col, row] = cell.0.map(|n| n.get() as i32);
    grid.centre(Cell { col, row })
}

impl StartSpec {
    /// The given position (grid frame) and heading; `None` where the start is random.
    pub fn given(&self, grid: &OccupancyGrid) -> Option<(Vec2, Option<f64>)> {
        match *self {
            Self::Random(_) => None,
            Self::Position(position) => Some((point(position, grid), None)),
            Self::Pose([x, y, theta]) => {
                let pose = grid.frame().to_grid(Pose::new(x.get(), y.get(), theta.get()));
                Some((pose.position, Some(pose.theta)))
            }
            Self::Cell(cell) => Some((centre(cell, grid), None)),
        }
    }
}

impl GoalSpec {
    /// The given position (grid frame); `None` where the goal is random.
    pub fn given(&self, grid: &OccupancyGrid) -> Option<Vec2> {
        match *self {
            Self::Random(_) => None,
            Self::Position(position) => Some(point(position, grid)),
            Self::Cell(cell) => Some(centre(cell, grid)),
        }
    }
}

impl unknown_static::fixed::Params {
    fn pose(&self, grid: &OccupancyGrid) -> Pose {
        let [x, y, theta] = self.pose.map(Finite::get);
        grid.frame().to_grid(Pose::new(x, y, theta))
    }
}

impl moving::fixed::Params {
    /// The velocity in the grid frame, or what is wrong with how it is given.
    fn velocity(&self, grid: &OccupancyGrid) -> Result<Vec2, &'static str> {
        match (self.velocity_mps, self.speed_mps, self.heading_rad) {
            (Some([x, y]), None, None) => Ok(turn_to_grid(Vec2::new(x.get(), y.get()), grid)),
            (None, Some(speed), Some(heading)) => Ok(turn_to_grid(speed.get() * direction(heading.get()), grid)),
            _ => Err("a mover needs either `velocity_mps`, or `speed_mps` with `heading_rad`"),
        }
    }

    /// The outline, its x axis along the heading or the velocity.
    fn outline(&self, grid: &OccupancyGrid) -> Outline {
        let forward = match self.heading_rad {
            Some(heading) => turn_to_grid(direction(heading.get()), grid),
            None => self.velocity(grid).unwrap_or_default(),
        };
        outline(self.radius_m, self.footprint.as_ref(), forward)
    }
}

impl moving::patrol::Params {
    /// The outline, its x axis along the first leg.
    fn outline(&self, grid: &OccupancyGrid) -> Outline {
        let [first, second] = [0, 1].map(|index| point(self.waypoints[index], grid));
        outline(self.radius_m, self.footprint.as_ref(), second - first)
    }
}

/// A vector of the world frame in the grid frame.
fn turn_to_grid(v: Vec2, grid: &OccupancyGrid) -> Vec2 {
    grid.frame().point_to_grid(v + grid.frame().origin.position)
}

impl super::spec::ObstaclesSpec {
    fn fixed_statics(&self, grid: &OccupancyGrid) -> Vec<UnknownStatic> {
        self.unknown_static
            .iter()
            .filter_map(|choice| match choice {
                UnknownStaticChoice::fixed(params) => {
                    Some(UnknownStatic::new(params.pose(grid), Shape::from(&params.shape)))
                }
                UnknownStaticChoice::random(_) => None,
            })
            .collect()
    }

    /// Whether something is drawn by the reference route.
    fn go_by_route(&self) -> bool {
        let statics = self.unknown_static.iter().any(|choice| match choice {
            UnknownStaticChoice::random(params) => !matches!(params.placement, PlacementChoice::anywhere(_)),
            UnknownStaticChoice::fixed(_) => false,
        });
        statics || self.moving.iter().any(|choice| matches!(choice, MovingChoice::crossing(_)))
    }
}

impl Scene {
    /// Draws the scene of `seed`.
    ///
    /// `inflation_m` is that of the planning grid (`planning.inflation_m`). Everything in the scene depends on the
    /// arguments alone.
    ///
    /// # Errors
    /// [`Infeasible`] where something given or drawn cannot be placed.
    pub fn generate(
        spec: &SceneSpec,
        map: &Arc<StaticMap>,
        robot: &Robot,
        inflation_m: f64,
        seed: EpisodeSeed,
    ) -> Result<Self, Infeasible> {
        spec.check(map, robot).map_err(|error| Infeasible::new(error.to_string()))?;
        let grid = &map.grid;
        let fixed = spec.obstacles.fixed_statics(grid);
        let ends = (spec.start.given(grid), spec.goal.given(grid));

        let with_fixed = |clearance_m: f64| {
            let mut floor = Floor::new(map, clearance_m);
            for obstacle in &fixed {
                let touched = floor.touched(obstacle);
                floor.add(&touched);
            }
            floor
        };
        let given = [ends.0.map(|(position, _)| position), ends.1];
        // Where both ends are given nobody needs to fit there with any heading but the given one.
        let room_m = if given.iter().all(Option::is_some) { robot.inscribed_radius_m() } else { robot.radius_m };
        let mut floor = with_fixed(math::max(room_m, inflation_m));
        if given.iter().flatten().any(|&p| !floor.passable()[grid.index(grid.cell_at(p))]) {
            floor = with_fixed(room_m);
        }
        for p in given.into_iter().flatten() {
            // The cell of a given end counts even where only the given point, not its centre, is clear.
            floor.admit(grid.cell_at(p));
        }

        let (start, goal) = draw_ends(spec, &floor, seed)?;
        let theta = match ends.0 {
            Some((_, Some(theta))) => theta,
            _ => math::atan2(goal.y - start.y, goal.x - start.x),
        };
        // A search of the whole map: only where it is wanted.
        let reference_route = spec.obstacles.go_by_route().then(|| {
            reference_route(grid, floor.known(), start, goal, seed)
                .ok_or_else(|| Infeasible::new("start and goal are not connected on the known map"))
        });
        let reference_route = reference_route.transpose()?;
        let mut scene = Self {
            map: Arc::clone(map),
            start: Pose { position: start, theta },
            goal,
            reference_route,
            unknown_static: Vec::new(),
            movers: Vec::new(),
            script: Vec::new(),
        };
        let body = robot.body(scene.start);
        if body.corners.is_some() && math::min(map.gap_m(&body), statics_gap_m(&fixed, &body)) < -SLACK_M {
            return Err(Infeasible::new("the footprint does not fit at the start with its heading"));
        }
        let cells = (grid.index(grid.cell_at(start)), grid.index(grid.cell_at(goal)));
        for (entry, choice) in spec.obstacles.unknown_static.iter().enumerate() {
            match choice {
                UnknownStaticChoice::fixed(params) => {
                    scene.unknown_static.push(UnknownStatic::new(params.pose(grid), Shape::from(&params.shape)));
                }
                UnknownStaticChoice::random(params) => {
                    for number in 0..params.count.get() {
                        let stream = seed.stream(Purpose::UnknownStatic, entity(entry, number));
                        let drawn = draw_static(params, &scene, &mut floor, robot, cells, stream);
                        scene.unknown_static.push(drawn.ok_or_else(|| {
                            Infeasible::new(format!(
                                "no place for number {number} of obstacles.unknown_static[{entry}] in {TRIES} draws"
                            ))
                        })?);
                    }
                }
            }
        }
        let mut recordings = spec.recordings.iter();
        for (entry, choice) in spec.obstacles.moving.iter().enumerate() {
            match choice {
                MovingChoice::fixed(params) => {
                    let velocity = params.velocity(grid).map_err(Infeasible::new)?;
                    let speed = velocity.norm();
                    let mover = Mover {
                        on_static: params.on_static,
                        on_robot: params.on_robot,
                        yield_distance_m: params.yield_distance_m.get(),
                        motion: motion(&params.motion, [speed, speed], seed, entity(entry, 0)),
                        ..Mover::with_outline(point(params.position, grid), velocity, params.outline(grid))
                    };
                    let blocked = mover.on_static != moving::OnStatic::Pass
                        && scene.statics().gap_m(&mover.outline, mover.position) < -SLACK_M;
                    if blocked || (mover.position - start).norm() < mover.radius_m() + robot.radius_m {
                        return Err(Infeasible::new(format!(
                            "obstacles.moving[{entry}] begins in the robot or in a random unknown static"
                        )));
                    }
                    scene.movers.push(mover);
                }
                MovingChoice::random(params) => {
                    for number in 0..params.count.get() {
                        let stream = seed.stream(Purpose::Dynamic, entity(entry, number));
                        let drawn = draw_mover(params, &scene, robot, stream).map(|mover| Mover {
                            motion: motion(
                                &params.motion,
                                params.speed_mps.map(NonNegative::get),
                                seed,
                                entity(entry, number),
                            ),
                            ..mover
                        });
                        scene.movers.push(drawn.ok_or_else(|| no_place(entry, number))?);
                    }
                }
                MovingChoice::crossing(params) => {
                    for number in 0..params.count.get() {
                        let stream = seed.stream(Purpose::Dynamic, entity(entry, number));
                        let drawn = draw_crossing(params, &scene, robot, stream);
                        scene.movers.push(drawn.ok_or_else(|| no_place(entry, number))?);
                    }
                }
                MovingChoice::patrol(params) => scene.movers.push(patrol(params, grid)),
                MovingChoice::replay(params) => {
                    let recording = recordings.next().expect("one recording for each replay");
                    scene.movers.extend(replay(params, recording, grid));
                }
            }
        }
        scene.write_script(&spec.script);
        Ok(scene)
    }

    /// Turns the entries of a script into events by tick; what happens at the same tick happens in the order of the file.
    fn write_script(&mut self, entries: &[ScriptEntry]) {
        let grid = &self.map.grid;
        let tick_of = |time_s: NonNegative| (time_s.get() / DT_S).round() as u32;
        for ScriptEntry { at_s, event } in entries {
            let number = |mover: CountOrZero| mover.get() as usize;
            let change = match event {
                EventChoice::obstacle(params) => {
                    let [x, y, theta] = params.pose.map(Finite::get);
                    let pose = grid.frame().to_grid(Pose::new(x, y, theta));
                    let number = self.unknown_static.len();
                    self.unknown_static.push(UnknownStatic::new(pose, Shape::from(&params.shape)).with_presence(false));
                    if let Some(until_s) = params.until_s {
                        let gone = Change::Obstacle { number, present: false };
                        self.script.push(Event { tick: tick_of(until_s), change: gone });
                    }
                    Change::Obstacle { number, present: true }
                }
                EventChoice::mover_appears(params) => Change::Mover { number: number(params.mover), present: true },
                EventChoice::mover_vanishes(params) => Change::Mover { number: number(params.mover), present: false },
                EventChoice::mover_stops(params) => Change::Halt { number: number(params.mover), halted: true },
                EventChoice::mover_starts(params) => Change::Halt { number: number(params.mover), halted: false },
                EventChoice::mover_velocity(params) => {
                    let [still, moving] = [[Finite::new(0.0); 2], params.velocity_mps].map(|v| point(v, grid));
                    Change::Velocity { number: number(params.mover), velocity: moving - still }
                }
                EventChoice::goal(params) => Change::Goal(point(params.to, grid)),
                EventChoice::sensor_range(params) => Change::SensorRange(params.range_m.get()),
                EventChoice::wheel_slip(params) => Change::WheelSlip { left: params.left, right: params.right },
            };
            self.script.push(Event { tick: tick_of(*at_s), change });
        }
        self.script.sort_by_key(|event| event.tick);
    }
}

fn no_place(entry: usize, number: u32) -> Infeasible {
    Infeasible::new(format!("no place for number {number} of obstacles.moving[{entry}] in {TRIES} draws"))
}

/// How a mover goes on; an irregular one draws its speeds from `speed_mps` unless its parameters say otherwise.
fn motion(choice: &MotionChoice, speed_mps: [f64; 2], seed: EpisodeSeed, entity: u64) -> Motion {
    match choice {
        MotionChoice::uniform(_) => Motion::Uniform,
        MotionChoice::irregular(params) => Motion::Irregular(Box::new(Irregular {
            interval_s: params.interval_s.map(Positive::get),
            speed_mps: params.speed_mps.map_or(speed_mps, |speed| speed.map(NonNegative::get)),
            stream: seed.stream(Purpose::Motion, entity),
        })),
    }
}

/// The mover of a patrol, at its first waypoint.
fn patrol(params: &moving::patrol::Params, grid: &OccupancyGrid) -> Mover {
    let waypoints: Arc<[Vec2]> = params.waypoints.iter().map(|&place| point(place, grid)).collect();
    let first = waypoints[0];
    let velocity = (waypoints[1] - first).normalize() * params.speed_mps.get();
    Mover {
        on_static: params.on_static,
        on_robot: params.on_robot,
        yield_distance_m: params.yield_distance_m.get(),
        motion: Motion::Patrol(Patrol {
            waypoints,
            speed_mps: params.speed_mps.get(),
            closed: params.closed,
            pause_s: params.pause_s.get(),
        }),
        ..Mover::with_outline(first, velocity, params.outline(grid))
    }
}

/// The movers of a recording, by id; those whose data ends before the episode begins are left out.
fn replay<'a>(
    params: &'a moving::replay::Params,
    recording: &'a Recording,
    grid: &'a OccupancyGrid,
) -> impl Iterator<Item = Mover> + 'a {
    let wanted = |id: u64| params.ids.as_ref().is_none_or(|ids| ids.contains(&id));
    recording.tracks().filter(move |&(id, _)| wanted(id)).filter_map(|(_, track)| {
        let from_s = params.from_s.get();
        let samples: Arc<[Sample]> = track
            .iter()
            .map(|sample| Sample {
                time_s: sample.time_s - from_s,
                position: grid.frame().point_to_grid(sample.position),
            })
            .collect();
        let is_over = samples[samples.len() - 1].time_s <= 0.0 && !params.stays;
        let first = samples[0].position;
        (!is_over).then(|| Mover {
            on_static: moving::OnStatic::Pass,
            motion: Motion::Replay(Replay { samples, stays: params.stays }),
            present: false,
            ..Mover::new(first, Vec2::zeros(), params.radius_m.get())
        })
    })
}

/// A mover that crosses the reference route when the robot may be there; `None` after too many draws.
fn draw_crossing(params: &moving::crossing::Params, scene: &Scene, robot: &Robot, mut stream: Stream) -> Option<Mover> {
    let statics = scene.statics();
    let route = route_of(scene);
    let [slowest, fastest] = params.speed_mps.map(NonNegative::get);
    let [low, high] = params.share.map(Fraction::get);
    let radius_m = outline(params.radius_m, params.footprint.as_ref(), Vec2::zeros()).circumradius_m();
    let keep = params.keep_from_start_m.get() + robot.radius_m + radius_m;
    let (jitter_s, straight_s) = (params.jitter_s.get(), params.straight_s.get());
    (0..TRIES).find_map(|_| {
        let velocity = stream.range(slowest, fastest) * direction(stream.range(-math::PI, math::PI));
        let along_m = route.length() * stream.range(low, high);
        let time_s = math::max(0.0, along_m / params.robot_speed_mps.get() + stream.range(-jitter_s, jitter_s));
        let place = route.point_at(along_m);
        let outline = outline(params.radius_m, params.footprint.as_ref(), velocity);
        let free = |way: Vec2, for_s: f64| statics.sweep(&outline, place, way, for_s).is_none();
        if statics.gap_m(&outline, place) < 0.0 || !free(velocity, straight_s) {
            return None;
        }
        if !free(-velocity, math::min(straight_s, time_s)) {
            return None;
        }
        // What bounces like light comes back the way it went.
        let back = Mover { on_static: params.on_static, ..Mover::with_outline(place, -velocity, outline.clone()) };
        let (position, reversed) = free_run(&back, &statics, time_s)?;
        let clear = (position - scene.start.position).norm() >= keep;
        clear.then(|| Mover {
            on_static: params.on_static,
            on_robot: params.on_robot,
            yield_distance_m: params.yield_distance_m.get(),
            ..Mover::with_outline(position, -reversed, outline)
        })
    })
}

/// The stream number of one obstacle: entry of the list in the high 16 bits, number within it in the low 32.
fn entity(entry: usize, number: u32) -> u64 {
    assert!(entry < 1 << 16, "a list of obstacles has at most 65536 entries");
    (entry as u64) << 32 | u64::from(number)
}

/// Start and goal: given as they are, random ones uniform over the passable cell centres that are far enough from the
/// other end and connected with it.
fn draw_ends(spec: &SceneSpec, floor: &Floor<'_>, seed: EpisodeSeed) -> Result<(Vec2, Vec2), Infeasible> {
    let grid = floor.grid();
    let (start, goal) = (spec.start.given(grid).map(|(position, _)| position), spec.goal.given(grid));
    let parts = floor.components();
    let part = |p: Vec2| parts.labels()[grid.index(grid.cell_at(p))];
    let diagonal = grid.extent_m().norm();
    let distance_min =
        |place: &RandomPlace, share: f64| place.distance_min_m.map_or(share * diagonal, NonNegative::get);
    // Labels are 0 where nothing fits.
    let candidates = || parts.labels().iter().enumerate().filter(|&(_, &label)| label != 0).map(|(index, _)| index);
    // Each end has a stream of its own, so that giving one leaves the draws of the other.
    let mut start_stream = seed.stream(Purpose::StartGoal, 0);
    let mut goal_stream = seed.stream(Purpose::StartGoal, 1);
    let far_from = |other: Vec2, distance: f64, stream: &mut Stream| {
        let connected = part(other);
        let far = || {
            candidates().filter(|&index| {
                parts.labels()[index] == connected
                    && (grid.centre(grid.cell(index)) - other).norm() >= distance - SLACK_M
            })
        };
        drawn(far, stream).map(|index| grid.centre(grid.cell(index)))
    };
    match (start, goal, &spec.start, &spec.goal) {
        (Some(start), Some(goal), ..) => {
            if part(start) == 0 || part(start) != part(goal) {
                return Err(Infeasible::new("start and goal are not connected for the robot"));
            }
            Ok((start, goal))
        }
        (Some(start), None, _, GoalSpec::Random(place)) => far_from(start, distance_min(place, 0.25), &mut goal_stream)
            .map(|goal| (start, goal))
            .ok_or_else(|| Infeasible::new("no free cell is connected with the start and far enough from it")),
        (None, Some(goal), StartSpec::Random(place), _) => far_from(goal, distance_min(place, 0.25), &mut start_stream)
            .map(|start| (start, goal))
            .ok_or_else(|| Infeasible::new("no free cell is connected with the goal and far enough from it")),
        (None, None, StartSpec::Random(from), GoalSpec::Random(to)) if !parts.sizes().is_empty() => {
            let distance = math::max(distance_min(from, 0.5), distance_min(to, 0.5));
            for _ in 0..TRIES {
                let start = drawn(candidates, &mut start_stream).expect("there is one");
                let start = grid.centre(grid.cell(start));
                if let Some(goal) = far_from(start, distance, &mut goal_stream) {
                    return Ok((start, goal));
                }
            }
            Err(Infeasible::new(format!("no connected start and goal at least {distance:.3} m apart in {TRIES} draws")))
        }
        _ => Err(Infeasible::new("no free cell for start and goal")),
    }
}

/// One of the items, each as likely as the others; none where there is none.
fn drawn<I: Iterator<Item = usize>>(items: impl Fn() -> I, stream: &mut Stream) -> Option<usize> {
    let count = items().count();
    if count > 0 { items().nth(stream.index(count)) } else { None }
}

/// A random unknown static: on free cells, clear of both ends, start and goal still connected; `None` after too many draws.
fn draw_static(
    params: &unknown_static::random::Params,
    scene: &Scene,
    floor: &mut Floor<'_>,
    robot: &Robot,
    (start, goal): (usize, usize),
    mut stream: Stream,
) -> Option<UnknownStatic> {
    let grid = &scene.map.grid;
    let shape = Shape::from(&params.shape);
    let keep = math::max(params.keep_from_ends_m.get(), robot.radius_m);
    for _ in 0..TRIES {
        let theta = stream.range(-math::PI, math::PI);
        let Some(mut position) = draw_position(&params.placement, scene, &mut stream) else {
            continue;
        };
        let mut pose = Pose { position, theta };
        if params.snap_to_cells {
            position = grid.centre(grid.cell_at(position));
            pose = Pose { position, theta: 0.0 };
        }
        let obstacle = UnknownStatic::new(pose, shape.clone());
        if obstacle.distance_m(scene.start.position) < keep || obstacle.distance_m(scene.goal) < keep {
            continue;
        }
        let touched = floor.touched(&obstacle);
        if touched.is_empty() || floor.overlaps(&touched) || (params.apart_from_obstacles && floor.adjoins(&touched)) {
            continue;
        }
        let blocked = floor.add(&touched);
        if floor.components().connected(start, goal) {
            return Some(obstacle);
        }
        floor.remove(&touched, &blocked);
    }
    None
}

/// The reference route of a scene in which something is placed by it.
fn route_of(scene: &Scene) -> &Path {
    scene.reference_route.as_ref().expect("one is drawn where something goes by it")
}

/// A position of the placement's distribution; `None` where this draw fell outside of it.
fn draw_position(placement: &PlacementChoice, scene: &Scene, stream: &mut Stream) -> Option<Vec2> {
    let extent = scene.map.grid.extent_m();
    match placement {
        PlacementChoice::anywhere(_) => Some(Vec2::new(stream.range(0.0, extent.x), stream.range(0.0, extent.y))),
        PlacementChoice::on_route(params) => {
            let route = route_of(scene);
            let [low, high] = params.share.map(|share| share.get() * route.length());
            Some(route.point_at(stream.range(low, high)))
        }
        PlacementChoice::near_route(params) => {
            let (route, reach) = (route_of(scene), params.distance_max_m.get());
            let (mut min, mut max) = (route.start(), route.start());
            for p in route.vertices() {
                min = Vec2::new(math::min(min.x, p.x), math::min(min.y, p.y));
                max = Vec2::new(math::max(max.x, p.x), math::max(max.y, p.y));
            }
            let low = Vec2::new(math::max(min.x - reach, 0.0), math::max(min.y - reach, 0.0));
            let high = Vec2::new(math::min(max.x + reach, extent.x), math::min(max.y + reach, extent.y));
            let p = Vec2::new(stream.range(low.x, high.x), stream.range(low.y, high.y));
            (route.project(p).1 <= reach).then_some(p)
        }
    }
}

/// A random mover: clear of every static obstacle and of the robot's start; `None` after too many draws.
fn draw_mover(params: &moving::random::Params, scene: &Scene, robot: &Robot, mut stream: Stream) -> Option<Mover> {
    let extent = scene.map.grid.extent_m();
    let [slowest, fastest] = params.speed_mps.map(NonNegative::get);
    let speed = stream.range(slowest, fastest);
    let heading = stream.range(-math::PI, math::PI);
    let shape = outline(params.radius_m, params.footprint.as_ref(), Vec2::zeros());
    let keep = params.keep_from_start_m.get() + robot.radius_m + shape.circumradius_m();
    (0..TRIES).find_map(|_| {
        let position = Vec2::new(stream.range(0.0, extent.x), stream.range(0.0, extent.y));
        let way = match params.heading {
            Heading::Any => direction(heading),
            Heading::AlongAisle => math::sign(heading) * aisle(&scene.map, position, shape.shape().inradius_m()),
        };
        let velocity = speed * way;
        let outline = outline(params.radius_m, params.footprint.as_ref(), way);
        let clear =
            (position - scene.start.position).norm() >= keep && scene.statics().gap_m(&outline, position) >= 0.0;
        clear.then(|| Mover {
            on_static: params.on_static,
            on_robot: params.on_robot,
            yield_distance_m: params.yield_distance_m.get(),
            ..Mover::with_outline(position, velocity, outline)
        })
    })
}

/// The outline of a mover: its footprint with x pointing `forward` (along x where that is no direction), or a disc.
fn outline(radius_m: Positive, footprint: Option<&OutlineCorners>, forward: Vec2) -> Outline {
    let length = forward.norm();
    let axis = if length > 0.0 { forward / length } else { Vec2::new(1.0, 0.0) };
    match footprint {
        None => Outline::disc(radius_m.get()),
        Some(corners) => Outline::new(Shape::Polygon(corners.polygon().clone()), 0.0).with_axis(axis),
    }
}

/// Signed distance from a body to the nearest of some obstacles, m.
fn statics_gap_m(obstacles: &[UnknownStatic], body: &Body) -> f64 {
    obstacles.iter().fold(f64::INFINITY, |best, obstacle| math::min(best, obstacle.gap_m(body)))
}

/// The unit vector along x or y in which a disc has the longer free run through `position` on the known map, by
/// whole cells; equal runs: along x.
fn aisle(map: &StaticMap, position: Vec2, radius_m: f64) -> Vec2 {
    let here = map.grid.cell_at(position);
    let run = |(cols, rows): (i32, i32)| {
        let ahead = (1..).map(|k| Cell { col: here.col + k * cols, row: here.row + k * rows });
        ahead.take_while(|&cell| map.grid.contains(cell) && map.field.distance_m(cell) >= radius_m).count()
    };
    if run((1, 0)) + run((-1, 0)) >= run((0, 1)) + run((0, -1)) { Vec2::new(1.0, 0.0) } else { Vec2::new(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::super::spec::{Conditions, ObstaclesSpec};
    use super::super::truth::World;
    use super::*;
    use crate::geometry::Twist;
    use crate::map::connectivity::reachable;
    use crate::map::{DistanceField, Frame};

    fn spec(start: &str, goal: &str, obstacles: &str) -> SceneSpec {
        SceneSpec {
            start: serde_yaml::from_str(start).unwrap(),
            goal: serde_yaml::from_str(goal).unwrap(),
            obstacles: serde_yaml::from_str::<ObstaclesSpec>(obstacles).unwrap(),
            recordings: Vec::new(),
            script: Vec::new(),
        }
    }

    fn seed(episode: u64) -> EpisodeSeed {
        EpisodeSeed { seed: 42, episode }
    }

    /// 30 by 30 cells of 1 m, a fifth of them occupied.
    fn random_map(episode: u64) -> Arc<StaticMap> {
        let mut stream = seed(episode).stream(Purpose::Map, 0);
        let mut grid = OccupancyGrid::empty(30, 30, 1.0);
        for index in 0..900 {
            if stream.uniform() < 0.2 {
                grid.set_occupied(grid.cell(index));
            }
        }
        Arc::new(StaticMap::new(grid))
    }

    const PAPER: &str = "
unknown_static:
  - random: {count: 1, placement: on_route, snap_to_cells: true, apart_from_obstacles: true, keep_from_ends_m: 0.5}
  - random: {count: 2, placement: {near_route: {distance_max_m: 3}}, shape: {rectangle: {size_m: [0.4, 0.7]}}}
  - random: {count: 2, shape: {disc: {radius_m: 0.3}}}
moving:
  - random: {count: 4, speed_mps: [0.8, 1.0]}
";

    fn paper_scene(episode: u64) -> Result<Scene, Infeasible> {
        Scene::generate(&spec("random", "random", PAPER), &random_map(episode), &Robot::default(), 0.3, seed(episode))
    }

    #[test]
    fn every_scene_is_feasible_and_as_specified() {
        let robot = Robot::default();
        let mut scenes = 0;
        for episode in 0..300 {
            let Ok(scene) = paper_scene(episode) else { continue };
            scenes += 1;
            let grid = &scene.map.grid;
            assert!((scene.start.position - scene.goal).norm() >= 0.5 * grid.extent_m().norm() - 1e-9);
            let towards = scene.start.bearing_to(scene.goal);
            assert!(towards.abs() < 1e-12, "the start heading points at the goal, not {towards} aside");
            assert_eq!((scene.unknown_static.len(), scene.movers.len()), (5, 4));

            // The true map, put together anew: start and goal connected for the disc of the clearance.
            let mut truth = OccupancyGrid::clone(grid);
            for obstacle in &scene.unknown_static {
                for index in 0..grid.occupied().len() {
                    let cell = grid.cell(index);
                    if obstacle.touches(grid.square(cell)) {
                        assert!(truth.is_free(cell), "unknown statics lie on free cells, apart from each other");
                        truth.set_occupied(cell);
                    }
                }
                for end in [scene.start.position, scene.goal] {
                    assert!(obstacle.distance_m(end) >= robot.radius_m);
                }
            }
            let reached = reachable(&truth, &DistanceField::new(&truth), grid.cell_at(scene.start.position), 0.3);
            assert!(reached[grid.index(grid.cell_at(scene.goal))], "episode {episode}");

            let route = scene.reference_route.as_ref().expect("wanted");
            let on_route = &scene.unknown_static[0];
            let cell = grid.cell_at(on_route.pose().position);
            assert_eq!(on_route.pose(), Pose { position: grid.centre(cell), theta: 0.0 });
            // Snapping moves a point of the route by up to half a diagonal.
            assert!(route.project(on_route.pose().position).1 <= 0.71);
            for row in cell.row - 1..=cell.row + 1 {
                for col in cell.col - 1..=cell.col + 1 {
                    assert!(grid.is_free(Cell { col, row }), "apart from obstacles");
                }
            }
            for near in &scene.unknown_static[1..3] {
                assert!(route.project(near.pose().position).1 <= 3.0);
            }
            for mover in &scene.movers {
                assert!(scene.statics().distance_m(mover.position) >= mover.radius_m());
                assert!((mover.position - scene.start.position).norm() >= 3.0 + 0.25 + 0.3);
                assert!((0.8..1.0 + 1e-12).contains(&mover.velocity.norm()));
            }
        }
        assert!(scenes > 250, "{scenes}");
    }

    #[test]
    fn random_movers_never_enter_statics_while_driving() {
        for episode in 0..60 {
            let Ok(scene) = paper_scene(episode) else { continue };
            let robot = Robot::default();
            let mut world = World::new(&scene, &robot, &Conditions::default());
            for _ in 0..100 {
                world.step(Twist::ZERO);
                for (mover, begin) in world.movers().iter().zip(&scene.movers) {
                    assert!(scene.statics().distance_m(mover.position) > mover.radius_m() - 1e-8);
                    assert!(
                        (mover.velocity.norm() - begin.velocity.norm()).abs() < 1e-9 || mover.velocity.norm() == 0.0
                    );
                }
            }
        }
    }

    #[test]
    fn what_a_map_keeps_of_other_scenes_changes_none() {
        // Six clearances, more than are kept, in turn; beside each a map that nobody has used.
        let (used, plain) = (random_map(7), spec("random", "random", "{}"));
        let mut drawn = 0;
        for episode in 0..24 {
            let inflation_m = 0.2 * (episode % 6) as f64;
            for spec in [&plain, &spec("random", "random", PAPER)] {
                let scene = |map: &Arc<StaticMap>| {
                    Scene::generate(spec, map, &Robot::default(), inflation_m, seed(episode))
                        .map(|scene| scene.digest())
                };
                let (ours, fresh) = (scene(&used), scene(&random_map(7)));
                assert_eq!(ours, fresh, "episode {episode}");
                drawn += u32::from(ours.is_ok());
            }
        }
        assert!(drawn > 20, "{drawn}");
    }

    #[test]
    fn one_seed_is_one_scene_and_another_seed_another() {
        for episode in 0..20 {
            let (Ok(a), Ok(b)) = (paper_scene(episode), paper_scene(episode)) else { continue };
            assert_eq!(a.digest(), b.digest());
            assert_eq!(
                (a.start, a.goal, &a.unknown_static, &a.movers),
                (b.start, b.goal, &b.unknown_static, &b.movers)
            );
            assert_eq!(a.reference_route, b.reference_route);
            if let Ok(other) = paper_scene(episode + 1000) {
                assert_ne!(a.digest(), other.digest());
            }
        }
    }

    #[test]
    fn adding_obstacles_leaves_the_others_bits_unchanged() {
        let robot = Robot::default();
        let base = "{unknown_static: [random: {count: 2}], moving: [random: {count: 2}, random]}";
        for (more, statics, movers) in [
            ("{unknown_static: [random: {count: 3}], moving: [random: {count: 2}, random]}", vec![0, 1], vec![]),
            ("{unknown_static: [random: {count: 2}], moving: [random: {count: 3}, random]}", vec![0, 1], vec![0, 1, 3]),
            (
                "{unknown_static: [random: {count: 2}], moving: [random: {count: 2}, random, random]}",
                vec![0, 1],
                vec![0, 1, 2],
            ),
        ] {
            for episode in 0..30 {
                let map = random_map(episode);
                let draw = |obstacles| {
                    Scene::generate(&spec("random", "random", obstacles), &map, &robot, 0.25, seed(episode))
                };
                let (Ok(before), Ok(after)) = (draw(base), draw(more)) else { continue };
                assert_eq!((before.start, before.goal), (after.start, after.goal));
                let kept: Vec<_> = statics.iter().map(|&k: &usize| after.unknown_static[k].clone()).collect();
                assert_eq!(kept, before.unknown_static);
                let kept: Vec<_> = movers.iter().map(|&k: &usize| after.movers[k].clone()).collect();
                assert_eq!(kept, before.movers[..kept.len()]);
                assert_ne!(before.digest(), after.digest());
            }
        }
    }

    #[test]
    fn the_order_of_obstacles_in_a_scene_does_not_depend_on_the_robot() {
        // Another robot, another scenario: but streams are addressed by purpose, so the movers' velocities are the same.
        let map = random_map(1);
        let spec = spec("random", "random", "{moving: [random: {count: 5}]}");
        let small = Scene::generate(&spec, &map, &Robot::default(), 0.25, seed(1)).unwrap();
        let robot = Robot { radius_m: 0.4, ..Robot::default() };
        let large = Scene::generate(&spec, &map, &robot, 0.4, seed(1)).unwrap();
        for (a, b) in small.movers.iter().zip(&large.movers) {
            assert_eq!(a.velocity, b.velocity);
        }
    }

    #[test]
    fn given_places_are_in_the_world_frame_and_kept() {
        // The map turned by a quarter and moved: grid x runs along world y.
        let frame = Frame { origin: Pose::new(10.0, 0.0, math::FRAC_PI_2) };
        let map = Arc::new(StaticMap::new(OccupancyGrid::empty(10, 6, 1.0).with_frame(frame)));
        let obstacles = "
unknown_static: [fixed: {pose: [7.5, 5.0, 0], shape: {disc: {radius_m: 0.2}}}]
moving:
  - fixed: {position: [6, 8], velocity_mps: [0, -1]}
  - fixed: {position: [6, 8], speed_mps: 2, heading_rad: 0, radius_m: 0.2, on_static: stop}
";
        let spec = spec("[8, 1, 1.5707963267948966]", "cell: [8, 3]", obstacles);
        let scene = Scene::generate(&spec, &map, &Robot::default(), 0.25, seed(0)).unwrap();
        let near = |a: Vec2, x: f64, y: f64| (a - Vec2::new(x, y)).norm() < 1e-12;
        assert!(near(scene.start.position, 1.0, 2.0) && scene.start.theta.abs() < 1e-12);
        assert!(near(scene.goal, 8.5, 3.5));
        assert!(near(scene.unknown_static[0].pose().position, 5.0, 2.5));
        assert!(near(scene.movers[0].position, 8.0, 4.0) && near(scene.movers[0].velocity, -1.0, 0.0));
        assert!(near(scene.movers[1].velocity, 0.0, -2.0));
        // A start without heading looks at the goal.
        let facing = SceneSpec { start: serde_yaml::from_str("[8, 1]").unwrap(), ..spec };
        let scene = Scene::generate(&facing, &map, &Robot::default(), 0.25, seed(0)).unwrap();
        assert!((scene.start.theta - math::atan2(1.5, 7.5)).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_is_refused_with_key_cell_and_cause() {
        let map = StaticMap::new(OccupancyGrid::from_ascii(&[".....", "..#..", "....."], 1.0));
        let robot = Robot::default();
        for (start, goal, obstacles, key, parts) in [
            ("[2.5, 1.5]", "random", "{}", "start", vec!["cell [2, 1]", "lies inside a known obstacle"]),
            ("[2.5, 0.8]", "random", "{}", "start", vec!["[2.500, 0.800]", "radius 0.25 m", "0.200 m to a known"]),
            ("[0.1, 0.5]", "random", "{}", "start", vec!["0.100 m to the map's edge"]),
            ("random", "[7, 1]", "{}", "goal", vec!["cell [7, 1]", "outside the map of 5 by 3 cells"]),
            ("random", "cell: [5, 0]", "{}", "goal", vec!["outside the map"]),
            (
                "[0.5, 0.5]",
                "random",
                "{unknown_static: [random, fixed: {pose: [1, 0.5, 0], shape: {disc: {radius_m: 0.3}}}]}",
                "start",
                vec!["unknown static number 0"],
            ),
            (
                "random",
                "random",
                "{unknown_static: [random, fixed: {pose: [9, 9, 0]}]}",
                "obstacles.unknown_static[1].fixed.pose",
                vec!["outside the map"],
            ),
            (
                "random",
                "random",
                "{moving: [fixed: {position: [2.5, 1.5], velocity_mps: [1, 0]}]}",
                "obstacles.moving[0].fixed.position",
                vec!["cell [2, 1]", "overlaps a static obstacle or the map's edge by 0.800 m"],
            ),
            (
                "[0.5, 0.5]",
                "random",
                "{moving: [fixed: {position: [0.9, 0.5], velocity_mps: [1, 0]}]}",
                "obstacles.moving[0].fixed.position",
                vec!["overlaps the robot"],
            ),
            (
                "random",
                "random",
                "{moving: [fixed: {position: [0.5, 0.5], velocity_mps: [1, 0], speed_mps: 1}]}",
                "obstacles.moving[0].fixed",
                vec!["either `velocity_mps`, or `speed_mps` with `heading_rad`"],
            ),
            (
                "random",
                "random",
                "{moving: [random: {speed_mps: [1, 0.5]}]}",
                "obstacles.moving[0].random.speed_mps",
                vec!["found [1, 0.5]"],
            ),
        ] {
            let error = spec(start, goal, obstacles).check(&map, &robot).unwrap_err();
            assert_eq!(error.key, key, "{error}");
            for part in parts {
                assert!(error.message.contains(part), "{part}: {error}");
            }
        }
        assert_eq!(spec("[0.5, 0.5]", "[4.5, 2.5]", "{}").check(&map, &robot), Ok(()));
    }

    #[test]
    fn a_world_that_cannot_be_is_infeasible_and_says_what() {
        let robot = Robot::default();
        let generate = |lines: &[&str], spec: &SceneSpec| {
            let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(lines, 1.0)));
            Scene::generate(spec, &map, &robot, 0.25, seed(0)).unwrap_err().message
        };
        let walled = ["..#..", "..#..", "..#.."];
        assert!(generate(&walled, &spec("[0.5, 0.5]", "[4.5, 0.5]", "{}")).contains("not connected"));
        assert!(generate(&walled, &spec("random", "random", "{}")).contains("at least 2.915 m apart"));
        assert!(generate(&["###"], &spec("random", "random", "{}")).contains("no free cell"));
        // The only way is one cell wide: an obstacle on it would close it.
        let lane = ["#######", ".......", "#######"];
        let plug = spec("[0.5, 1.5]", "[6.5, 1.5]", "{unknown_static: [random: {snap_to_cells: true}]}");
        assert!(generate(&lane, &plug).contains("number 0 of obstacles.unknown_static[0]"));
        let crowd = spec("[0.5, 1.5]", "[6.5, 1.5]", "{moving: [random: {radius_m: 0.6}]}");
        assert!(generate(&lane, &crowd).contains("number 0 of obstacles.moving[0]"));
    }

    #[test]
    fn a_given_start_inside_the_inflated_zone_is_judged_by_the_footprint() {
        let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(&["#####", ".....", "#####"], 1.0)));
        let spec = spec("[0.5, 1.5]", "[4.5, 1.5]", "{}");
        // The lane leaves 0.5 m to both sides: too little for 0.8 m of inflation, enough for the robot.
        assert!(Scene::generate(&spec, &map, &Robot::default(), 0.8, seed(0)).is_ok());
    }

    #[test]
    fn movers_of_an_aisle_set_out_along_it() {
        // An aisle along x below, one along y on the right: each two cells wide and longer than wide.
        let rows = ["########..", "########..", "########..", "########..", "..........", ".........."];
        let map = Arc::new(StaticMap::new(OccupancyGrid::from_ascii(&rows, 1.0)));
        let spec = spec(
            "[0.5, 0.5]",
            "[1.5, 0.5]",
            "{moving: [random: {count: 4, heading: along_aisle, keep_from_start_m: 0}]}",
        );
        let (mut along_x, mut along_y) = (0, 0);
        for episode in 0..200 {
            for mover in Scene::generate(&spec, &map, &Robot::default(), 0.25, seed(episode)).unwrap().movers {
                let (x, v) = (mover.position.x, mover.velocity);
                assert!(v.x == 0.0 || v.y == 0.0, "{v:?}");
                if x < 8.0 {
                    assert!(v.x != 0.0, "{mover:?}");
                    along_x += i32::from(v.x > 0.0);
                } else if mover.position.y > 2.0 {
                    assert!(v.y != 0.0, "{mover:?}");
                    along_y += i32::from(v.y > 0.0);
                }
            }
        }
        assert!(along_x > 50 && along_y > 50, "either way: {along_x} {along_y}");
    }

    /// The mover's states over `ticks` ticks of a world in which the robot stands.
    fn states(scene: &Scene, ticks: usize) -> Vec<Vec<Mover>> {
        let robot = Robot::default();
        let mut world = World::new(scene, &robot, &Conditions::default());
        let mut all = vec![world.movers().to_vec()];
        for _ in 0..ticks {
            assert_eq!(world.step(Twist::ZERO).contact, None);
            all.push(world.movers().to_vec());
        }
        all
    }

    fn scene_of(obstacles: &str, episode: u64) -> Scene {
        let map = Arc::new(StaticMap::new(OccupancyGrid::empty(40, 30, 1.0)));
        Scene::generate(&spec("[1, 1]", "[38, 28]", obstacles), &map, &Robot::default(), 0.3, seed(episode)).unwrap()
    }

    #[test]
    fn an_irregular_mover_changes_course_as_often_and_as_much_as_it_says() {
        let text =
            "moving: [random: {speed_mps: [0.8, 1.0], motion: {irregular: {interval_s: [1, 3]}}, on_static: pass}]";
        let (mut changes_s, mut headings, mut speeds) = (Vec::new(), Vec::new(), Vec::new());
        for episode in 0..40 {
            let states = states(&scene_of(text, episode), 600);
            let mut last = 0;
            for tick in 1..states.len() {
                let (before, after) = (states[tick - 1][0].velocity, states[tick][0].velocity);
                if before != after {
                    changes_s.push((tick - last) as f64 * 0.1);
                    last = tick;
                    headings.push(math::atan2(after.y, after.x));
                    speeds.push(after.norm());
                }
                let moved = states[tick][0].position - states[tick - 1][0].position;
                assert!((moved - after * 0.1).norm() < 1e-9, "straight within a tick");
            }
        }
        let n = changes_s.len() as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        assert!(n > 1000.0, "{n}");
        // Uniform on [1, 3]: mean 2, sd 0.577; four standard errors. The first interval of an episode counts from tick 1.
        assert!((mean(&changes_s) - 2.0).abs() < 4.0 * 0.577 / n.sqrt(), "{}", mean(&changes_s));
        assert!(changes_s.iter().all(|s| (0.95..=3.15).contains(s)));
        assert!((mean(&speeds) - 0.9).abs() < 4.0 * 0.058 / n.sqrt() && speeds.iter().all(|s| (0.8..=1.0).contains(s)));
        let turn: Vec2 = headings.iter().map(|&heading| direction(heading)).sum::<Vec2>() / n;
        // The mean direction of n uniform headings is about 1/√n long.
        assert!(turn.norm() < 3.0 / n.sqrt(), "{turn:?}");
    }

    #[test]
    fn a_crossing_mover_is_on_the_route_when_the_robot_may_be() {
        let text = "moving: [crossing: {robot_speed_mps: 0.5, jitter_s: 2, straight_s: 0}]";
        for episode in 0..30 {
            let map = random_map(episode);
            let spec = spec("random", "random", text);
            let Ok(scene) = Scene::generate(&spec, &map, &Robot::default(), 0.3, seed(episode)) else { continue };
            let route = scene.reference_route.as_ref().expect("wanted");
            let length = route.length();
            let (first, last) = (0.3 * length / 0.5 - 2.0, 0.8 * length / 0.5 + 2.0);
            let mover = &scene.movers[0];
            assert!((mover.position - scene.start.position).norm() >= 3.0 + 0.3 + 0.25 - 1e-9);
            let robot = Robot::default();
            let mut world = World::new(&scene, &robot, &Conditions::default());
            let meets = (0..(last / 0.1).ceil() as u32 + 1).any(|tick| {
                let at = world.movers()[0].position;
                world.step(Twist::ZERO);
                // Within a tick's way of the route, at a time at which it may be met.
                f64::from(tick) * 0.1 >= first - 0.1 && route.project(at).1 <= 0.1
            });
            assert!(meets, "episode {episode}");
        }
    }

    #[test]
    fn a_patrol_is_where_arithmetic_says() {
        let text =
            "moving: [patrol: {waypoints: [[10, 10], [14, 10], [14, 13]], speed_mps: 0.5, pause_s: 1, closed: true}]";
        let states = states(&scene_of(text, 0), 400);
        // 4 m, stop, 3 m, stop, 5 m, stop: 8 + 1 + 6 + 1 + 10 + 1 = 27 s a round.
        for (tick, state) in states.iter().enumerate() {
            let t = (tick as f64 * 0.1) % 27.0;
            let along = |from: (f64, f64), to: (f64, f64), share: f64| {
                Vec2::new(from.0 + (to.0 - from.0) * share, from.1 + (to.1 - from.1) * share)
            };
            let expected = if t < 9.0 {
                along((10.0, 10.0), (14.0, 10.0), math::min(t / 8.0, 1.0))
            } else if t < 16.0 {
                along((14.0, 10.0), (14.0, 13.0), math::min((t - 9.0) / 6.0, 1.0))
            } else {
                along((14.0, 13.0), (10.0, 10.0), math::min((t - 16.0) / 10.0, 1.0))
            };
            assert!((state[0].position - expected).norm() < 1e-6, "tick {tick}: {:?} {expected:?}", state[0].position);
        }
        let there_and_back =
            "moving: [patrol: {waypoints: [[10, 10], [14, 10], [14, 13]], speed_mps: 0.5, closed: false}]";
        let states = self::states(&scene_of(there_and_back, 0), 281);
        assert!((states[140][0].position - Vec2::new(14.0, 13.0)).norm() < 1e-6, "7 m after 14 s");
        assert!((states[200][0].position - Vec2::new(14.0, 10.0)).norm() < 1e-6);
        assert!((states[280][0].position - Vec2::new(10.0, 10.0)).norm() < 1e-6);
    }

    #[test]
    fn a_patrol_waits_at_what_is_in_its_way_unless_it_passes() {
        for (on_static, expected) in [("stop", 11.2), ("pass", 14.0)] {
            let text = format!(
                "moving: [patrol: {{waypoints: [[10, 10], [14, 10]], speed_mps: 1, pause_s: 9, on_static: {on_static}}}]"
            );
            let mut scene = scene_of(&text, 0);
            scene.unknown_static.push(UnknownStatic::new(Pose::new(12.0, 10.0, 0.0), Shape::Disc { radius_m: 0.5 }));
            let states = states(&scene, 60);
            assert!((states[60][0].position.x - expected).abs() < 1e-6, "{:?}", states[60][0].position);
        }
    }

    #[test]
    fn a_recorded_mover_is_at_the_recorded_place_and_gone_outside_of_its_time() {
        let csv = b"time_s,id,x_m,y_m\n1.0,4,10,10\n1.4,4,10.4,10\n1.85,4,10.4,10.9\n3.0,4,10.4,13.2\n";
        let recording = Arc::new(Recording::parse(csv, 25.0).unwrap());
        let obstacles = "moving: [replay: {file: unused.csv, from_s: 0.5}]";
        let mut spec = spec("[1, 1]", "[38, 28]", obstacles);
        spec.recordings = vec![recording];
        let map = Arc::new(StaticMap::new(OccupancyGrid::empty(40, 30, 1.0)));
        let scene = Scene::generate(&spec, &map, &Robot::default(), 0.3, seed(0)).unwrap();
        let states = states(&scene, 40);
        for (tick, state) in states.iter().enumerate() {
            let t = tick as f64 * 0.1 + 0.5;
            // The row of a tick shows the end of the tick: the first one driven begins at 1.0 s, the last one ends at 3.0 s.
            assert_eq!(state[0].present, t > 1.05 && t < 3.05, "at {t}");
            if state[0].present {
                let expected =
                    if t < 1.4 { Vec2::new(10.0 + (t - 1.0), 10.0) } else { Vec2::new(10.4, 10.0 + 2.0 * (t - 1.4)) };
                assert!((state[0].position - expected).norm() < 1e-6, "at {t}: {:?} {expected:?}", state[0].position);
            }
        }
    }

    #[test]
    fn a_mover_that_appears_upon_the_robot_is_a_collision_at_that_moment() {
        let csv = b"time_s,id,x_m,y_m\n1.0,4,1.2,1\n9.0,4,1.2,1\n";
        let mut spec = spec("[1, 1]", "[38, 28]", "moving: [replay: {file: unused.csv}]");
        spec.recordings = vec![Arc::new(Recording::parse(csv, 25.0).unwrap())];
        let map = Arc::new(StaticMap::new(OccupancyGrid::empty(40, 30, 1.0)));
        let scene = Scene::generate(&spec, &map, &Robot::default(), 0.3, seed(0)).unwrap();
        let robot = Robot::default();
        let mut world = World::new(&scene, &robot, &Conditions::default());
        let hit = (0..20).find_map(|tick| world.step(Twist::ZERO).contact.map(|contact| (tick, contact.time_s)));
        assert_eq!(hit, Some((10, 0.0)));
    }
}
