//! A recorded episode as a page carries it: small, exact to a millimetre, and readable by a script without a library.
//!
//! # The contract with the player
//!
//! The page has `<script type="application/json" id="episodes">`, an array of [`Entry`]: `{id, point, episode, stack, world,
//! outcome, cause, sentence, command, stats, data}`. `id` is unique and the fragment of its permalink (`#p0-e3-a_star+dwa`); entries
//! with one `world` (`"p0-e3"`) took place in the same world and can be shown side by side; `cause` may be empty; `stats` maps
//! columns of `episodes.csv` to numbers. `data` is base64 (standard alphabet, padded) of raw deflate of UTF-8 JSON, the object below.
//! `<script type="application/json" id="maps">` is an object from map ids to the same packing of a map. In both scripts every `<` is
//! written `\u003c`.
//!
//! Units: **positions in mm, angles in mrad, speeds in mm/s and mrad/s, all integers**; frame: the map's grid, origin at its lower left
//! corner, x right, y up, heading counter-clockwise from +x. A *delta array* holds the first value, then differences. "row" is a
//! row of the trace: row 0 is before the first tick, row k the end of tick k − 1, at `k · dt_s`; the last row of an
//! episode that ended in a contact shows the moment of the contact, at `end.time_s`.
//!
//! ```json
//! {"dt_s": 0.1,
//!  "map_id": "m0",                      // {"cols","rows","resolution_m","cells":[state,count,…]}: 0 free, 1 occupied, 2 unknown; row 0 at the bottom
//!  "footprint": {"radius_m": 0.25},     // or [[x,y],…] in metres, in the robot's frame
//!  "start": {"x": 1500, "y": 9500, "heading": 0},
//!  "goals": [{"row": 0, "x": 28500, "y": 9500}],     // the goal in force from that row on
//!  "goal_tolerance_m": 0.25,
//!  "unknown": [{"disc": {"x","y","r"}}, {"polygon": [[x,y],…]}],     // not on the robot's map; mm; "from_row"/"to_row" where it came or went
//!  "robot": {"x": […], "y": […], "heading": […], "v": […], "w": […]},      // delta arrays, one value a row
//!  "clearance": […],                    // delta array, mm, one value a row
//!  "belief": null,                      // or {"x","y","heading"}: the pose that the robot believed; null where it is the true one
//!  "movers": [{"shape": {"disc": {"r": 300}}, "heading": 0, "x": […], "y": […],     // or {"polygon": [[x,y],…]} about its centre, turned already
//!              "present": [[0, 120]]}],     // rows [from, to) in which it is there; absent where it always is
//!  "seen": [[0, [0, 2]]],               // from that row on the robot senses these movers, by number
//!  "sensed": [[0, [[x,y],…]]],          // where it senses them, each 5 rows; only where sensing is noisy, else []
//!  "grown": [[12, [cell,…], [cell,…]]], // cells that entered and left the robot's map at that row; delta arrays of row-major indices
//!  "lidar": {"first": −3124.139, "step": 69.813, "count": 90, "every": 5, "unit_mm": 10, "ranges": […]},    // or null; scan k is of row k · every; per ray the
//!                                       // first range, then its difference to the last scan: all rays of scan 0, all of scan 1, …; 0 is no echo
//!  "paths": [{"row": 0, "x": […], "y": […], "nodes": [[x,y],…]}],       // delta arrays of a polyline; the path in force from that row on
//!  "sub_goal": [[row, x, y], …],        // where it changes
//!  "states": {"names": ["track"], "changes": [[0, 0]]},     // [row, index into names]
//!  "notes": {"phase": {"values": […], "scale": 1000}},     // numbers of the local planner times scale, delta arrays, one value a row
//!  "v_max": 1000,
//!  "contact": null,                     // or {"row","x","y","with"}: the touched point
//!  "end": {"row": 214, "time_s": 21.4, "outcome": "success"}}
//! ```

use crate::episode::{Outcome, Recording};
use crate::geometry::outline::Outline;
use crate::geometry::{Path, Piece, Pose, Vec2};
use crate::map::{Cell, OccupancyGrid};
use crate::math;
use crate::observation::SensedObstacle;
use crate::report::drawing::stays;
use crate::world::ObstacleKind;
use base64::Engine as _;
use serde::Serialize;
use std::collections::BTreeMap;

/// Rows from one sensed set of points, or scan, to the next.
const EVERY_ROWS: usize = 5;
/// Rays of a scan that reach the page; of more, evenly chosen ones.
const RAYS_MAX: usize = 90;
/// Ranges of an episode that reach the page; of more, fewer scans.
const RANGES_MAX: usize = 24_000;
/// Unit of a range, mm.
const RANGE_UNIT_MM: f64 = 10.0;
/// Numbers of the local planner that reach the page.
const NOTES_MAX: usize = 6;
/// What a number of the local planner is multiplied by.
const NOTE_SCALE: f64 = 1000.0;

/// An episode of the gallery.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Entry {
    /// Unique name, and fragment of the permalink.
    pub id: String,
    /// Point of the sweep.
    pub point: u32,
    /// Number of the episode.
    pub episode: u64,
    /// The stack that drove.
    pub stack: String,
    /// Name of the world; equal for episodes that can stand side by side.
    pub world: String,
    /// How it ended.
    pub outcome: String,
    /// What led to a failure, in words; empty for a success.
    pub cause: String,
    /// What happened, in words.
    pub sentence: String,
    /// The command that drives it again.
    pub command: String,
    /// Metrics by column.
    pub stats: BTreeMap<&'static str, f64>,
    /// The packed [`Episode`].
    pub data: String,
}

/// JSON packed for a page: raw deflate, then base64.
pub fn pack(value: &impl Serialize) -> String {
    let json = serde_json::to_vec(value).expect("numbers, texts and lists can be written as JSON");
    base64::engine::general_purpose::STANDARD.encode(miniz_oxide::deflate::compress_to_vec(&json, 9))
}

/// JSON that may stand inside a `script` element.
pub fn json_in_script(value: &impl Serialize) -> String {
    let json = serde_json::to_string(value).expect("numbers, texts and lists can be written as JSON");
    json.replace('<', "\\u003c")
}

/// A map, as [the contract](self) has it.
#[derive(Debug, Serialize)]
pub struct Map {
    cols: i32,
    rows: i32,
    resolution_m: f64,
    cells: Vec<u32>,
}

impl Map {
    /// The map of a grid.
    pub fn new(grid: &OccupancyGrid) -> Self {
        let runs = grid.occupied().chunk_by(|a, b| a == b);
        let cells = runs.flat_map(|run| [u32::from(run[0]), run.len() as u32]).collect();
        Self { cols: grid.cols(), rows: grid.rows(), resolution_m: grid.resolution_m(), cells }
    }
}

/// An episode, as [the contract](self) has it.
#[derive(Debug, Serialize)]
pub struct Episode {
    dt_s: f64,
    map_id: String,
    footprint: Footprint,
    start: At,
    goals: Vec<Goal>,
    goal_tolerance_m: f64,
    unknown: Vec<Unknown>,
    robot: Track,
    clearance: Vec<i64>,
    belief: Option<Believed>,
    movers: Vec<Mover>,
    seen: Vec<(usize, Vec<u32>)>,
    sensed: Vec<(usize, Vec<[i64; 2]>)>,
    grown: Vec<(u32, Vec<i64>, Vec<i64>)>,
    lidar: Option<Lidar>,
    paths: Vec<Planned>,
    sub_goal: Vec<(usize, i64, i64)>,
    states: States,
    notes: BTreeMap<&'static str, Note>,
    v_max: i64,
    contact: Option<Contact>,
    end: End,
}

#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Footprint {
    Disc { radius_m: f64 },
    Polygon(Vec<[f64; 2]>),
}

#[derive(Debug, Serialize)]
struct At {
    x: i64,
    y: i64,
    heading: i64,
}

#[derive(Debug, Serialize)]
struct Goal {
    row: u32,
    x: i64,
    y: i64,
}

#[derive(Debug, Serialize)]
struct Unknown {
    #[serde(flatten)]
    shape: UnknownShape,
    #[serde(skip_serializing_if = "Option::is_none")]
    from_row: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    to_row: Option<u32>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "lowercase")]
enum UnknownShape {
    Disc { x: i64, y: i64, r: i64 },
    Polygon(Vec<[i64; 2]>),
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "lowercase")]
enum MoverShape {
    Disc { r: i64 },
    Polygon(Vec<[i64; 2]>),
}

#[derive(Debug, Serialize)]
struct Track {
    x: Vec<i64>,
    y: Vec<i64>,
    heading: Vec<i64>,
    v: Vec<i64>,
    w: Vec<i64>,
}

#[derive(Debug, Serialize)]
struct Believed {
    x: Vec<i64>,
    y: Vec<i64>,
    heading: Vec<i64>,
}

#[derive(Debug, Serialize)]
struct Mover {
    shape: MoverShape,
    heading: i64,
    x: Vec<i64>,
    y: Vec<i64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    present: Option<Vec<[usize; 2]>>,
}

#[derive(Debug, Serialize)]
struct Lidar {
    first: f64,
    step: f64,
    count: usize,
    every: usize,
    unit_mm: f64,
    ranges: Vec<i64>,
}

#[derive(Debug, Serialize)]
struct Planned {
    row: u32,
    x: Vec<i64>,
    y: Vec<i64>,
    nodes: Vec<[i64; 2]>,
}

#[derive(Debug, Serialize)]
struct States {
    names: Vec<&'static str>,
    changes: Vec<(usize, usize)>,
}

#[derive(Debug, Serialize)]
struct Note {
    values: Vec<i64>,
    scale: f64,
}

#[derive(Debug, Serialize)]
struct Contact {
    row: usize,
    x: i64,
    y: i64,
    with: &'static str,
}

#[derive(Debug, Serialize)]
struct End {
    row: usize,
    time_s: f64,
    outcome: &'static str,
}

impl Episode {
    /// The episode of a recording, in the map called `map_id`; lidar scans are left out unless `with_scans`.
    pub fn new(recording: &Recording, map_id: &str, with_scans: bool) -> Self {
        let Recording { scene, robot, dt_s, outcome, trace, .. } = recording;
        let ticks = &trace.ticks;
        let column =
            |value: &dyn Fn(&crate::trace::Tick) -> f64| deltas(ticks.iter().map(|tick| thousandths(value(tick))));
        let headings = || unwrapped(ticks.iter().map(|tick| tick.pose.theta));
        // Events happen at the beginning of the first tick from their time on.
        let row_at = |time_s: f64| (time_s / dt_s - 1e-9).ceil() as u32;
        let later = scene.script.iter().filter_map(|event| {
            let goal = event.change.goal_moved_to()?;
            Some(Goal { row: row_at(event.at_s), x: thousandths(goal.x), y: thousandths(goal.y) })
        });
        let first = Goal { row: 0, x: thousandths(scene.goal.x), y: thousandths(scene.goal.y) };
        let last = ticks.len().saturating_sub(1);
        Self {
            dt_s: *dt_s,
            map_id: map_id.to_owned(),
            footprint: match &robot.footprint {
                None => Footprint::Disc { radius_m: robot.radius_m },
                Some(polygon) => {
                    Footprint::Polygon(polygon.corners().iter().map(|corner| [corner.x, corner.y]).collect())
                }
            },
            start: At {
                x: thousandths(scene.start.position.x),
                y: thousandths(scene.start.position.y),
                heading: thousandths(scene.start.theta),
            },
            goals: std::iter::once(first).chain(later).collect(),
            goal_tolerance_m: recording.goal_tolerance_m,
            unknown: scene
                .unknown_static
                .iter()
                .zip(stays(scene))
                .filter(|(_, stay)| stay.from_s.is_finite())
                .map(|(obstacle, stay)| Unknown {
                    shape: unknown(obstacle.outline(), obstacle.pose().position),
                    from_row: (stay.from_s > 0.0).then(|| row_at(stay.from_s)),
                    to_row: stay.until_s.is_finite().then(|| row_at(stay.until_s)),
                })
                .collect(),
            robot: Track {
                x: column(&|tick| tick.pose.position.x),
                y: column(&|tick| tick.pose.position.y),
                heading: headings(),
                v: column(&|tick| tick.twist.v),
                w: column(&|tick| tick.twist.omega),
            },
            clearance: column(&|tick| if tick.clearance_m.is_finite() { tick.clearance_m } else { 1e3 }),
            belief: believed(recording),
            movers: (0..trace.mover_count).map(|mover| moving(recording, mover)).collect(),
            seen: seen(recording),
            sensed: sensed(recording),
            grown: recording
                .detail
                .belief
                .iter()
                .map(|change| {
                    let cells = |cells: &[Cell]| deltas(cells.iter().map(|&cell| scene.map.grid.index(cell) as i64));
                    (change.tick, cells(&change.entered), cells(&change.left))
                })
                .collect(),
            lidar: with_scans.then(|| lidar(recording)).flatten(),
            paths: trace.paths.iter().map(|planned| path(&planned.path, planned.tick)).collect(),
            sub_goal: changes(ticks.iter().map(|tick| (thousandths(tick.sub_goal.x), thousandths(tick.sub_goal.y))))
                .map(|(row, (x, y))| (row, x, y))
                .collect(),
            states: states(recording),
            notes: notes(recording),
            v_max: thousandths(robot.speed_max_mps),
            contact: contact(recording),
            end: End {
                row: last,
                time_s: if ticks.is_empty() { 0.0 } else { trace.row_time_s(last, *dt_s) },
                outcome: outcome.name(),
            },
        }
    }
}

/// A number of thousandths: millimetres of metres.
fn thousandths(value: f64) -> i64 {
    (value * 1e3).round() as i64
}

/// The first value, then differences.
fn deltas(values: impl Iterator<Item = i64>) -> Vec<i64> {
    let mut last = 0;
    values.map(|value| value - std::mem::replace(&mut last, value)).collect()
}

/// Angles in mrad as a delta array, without jumps by a full turn.
fn unwrapped(angles: impl Iterator<Item = f64>) -> Vec<i64> {
    let (mut last, mut turns) = (None::<f64>, 0.0);
    deltas(angles.map(|angle| {
        if let Some(before) = last {
            turns -= ((angle - before) / math::TAU).round();
        }
        last = Some(angle);
        thousandths(angle + turns * math::TAU)
    }))
}

/// The rows at which a value differs from the one before, the first included.
fn changes<T: PartialEq + Clone>(values: impl Iterator<Item = T>) -> impl Iterator<Item = (usize, T)> {
    let mut last = None::<T>;
    values.enumerate().filter(move |(_, value)| {
        let is_new = last.as_ref() != Some(value);
        if is_new {
            last = Some(value.clone());
        }
        is_new
    })
}

fn in_mm(p: Vec2) -> [i64; 2] {
    [thousandths(p.x), thousandths(p.y)]
}

fn unknown(outline: &Outline, centre: Vec2) -> UnknownShape {
    match outline.corners(centre) {
        Some(corners) => UnknownShape::Polygon(corners.iter().map(|&corner| in_mm(corner)).collect()),
        None => {
            let [x, y] = in_mm(centre);
            UnknownShape::Disc { x, y, r: thousandths(outline.circumradius_m()) }
        }
    }
}

fn moving(recording: &Recording, index: usize) -> Mover {
    let (trace, outline) = (&recording.trace, &recording.scene.movers[index].outline);
    let shape = match outline.corners(Vec2::zeros()) {
        Some(corners) => MoverShape::Polygon(corners.iter().map(|&corner| in_mm(corner)).collect()),
        None => MoverShape::Disc { r: thousandths(outline.circumradius_m()) },
    };
    let rows = trace.ticks.len();
    let state = |row: usize| trace.movers_at(row)[index];
    // Where it is absent it keeps its place: what the trace says there means nothing.
    let first = (0..rows).find(|&row| state(row).present).map_or(Vec2::zeros(), |row| state(row).position);
    let mut at = first;
    let places: Vec<Vec2> = (0..rows)
        .map(|row| {
            if state(row).present {
                at = state(row).position;
            }
            at
        })
        .collect();
    let mut present: Vec<[usize; 2]> = Vec::new();
    for row in (0..rows).filter(|&row| state(row).present) {
        match present.last_mut() {
            Some([_, to]) if *to == row => *to += 1,
            _ => present.push([row, row + 1]),
        }
    }
    Mover {
        shape,
        heading: thousandths(math::atan2(outline.axis().y, outline.axis().x)),
        x: deltas(places.iter().map(|place| thousandths(place.x))),
        y: deltas(places.iter().map(|place| thousandths(place.y))),
        present: (present != [[0, rows]]).then_some(present),
    }
}

/// The poses that the robot believed, if one of them is off by more than half a millimetre or milliradian.
fn believed(recording: &Recording) -> Option<Believed> {
    let ticks = &recording.trace.ticks;
    // A row's believed pose is that at the beginning of its tick, where the row before ended.
    let truth = |row: usize| ticks[row.saturating_sub(1)].pose;
    let is_off = |believed: Pose, truth: Pose| {
        (believed.position - truth.position).norm() > 5e-4 || (believed.theta - truth.theta).abs() > 5e-4
    };
    (0..ticks.len()).any(|row| is_off(ticks[row].believed, truth(row))).then(|| Believed {
        x: deltas(ticks.iter().map(|tick| thousandths(tick.believed.position.x))),
        y: deltas(ticks.iter().map(|tick| thousandths(tick.believed.position.y))),
        heading: unwrapped(ticks.iter().map(|tick| tick.believed.theta)),
    })
}

fn sensed_at(recording: &Recording, row: usize) -> &[SensedObstacle] {
    recording.detail.sensed_at(row)
}

fn seen(recording: &Recording) -> Vec<(usize, Vec<u32>)> {
    let rows = recording.detail.ticks();
    changes((0..rows).map(|row| sensed_at(recording, row).iter().map(|obstacle| obstacle.id).collect())).collect()
}

/// Where movers are sensed, if not where they are.
fn sensed(recording: &Recording) -> Vec<(usize, Vec<[i64; 2]>)> {
    let trace = &recording.trace;
    let rows = recording.detail.ticks().min(trace.ticks.len());
    let is_off = |row: usize, obstacle: &SensedObstacle| {
        let mover = trace.movers_at(row).get(obstacle.id as usize);
        mover.is_none_or(|mover| (mover.position - obstacle.position).norm() > 5e-4)
    };
    let is_noisy = (0..rows).any(|row| sensed_at(recording, row).iter().any(|obstacle| is_off(row, obstacle)));
    let of = |row: usize| (row, sensed_at(recording, row).iter().map(|obstacle| in_mm(obstacle.position)).collect());
    if is_noisy { (0..rows).step_by(EVERY_ROWS).map(of).collect() } else { Vec::new() }
}

fn lidar(recording: &Recording) -> Option<Lidar> {
    let field_of_view = recording.sensing.lidar.as_ref()?.field_of_view_rad;
    let field_of_view_rad = field_of_view.map_or(math::TAU, |angle| math::min(angle.get(), math::TAU));
    let trace = &recording.trace;
    let rays = trace.ray_count;
    if rays == 0 {
        return None;
    }
    let scans = trace.ranges_m.len() / rays;
    let skip = rays.div_ceil(RAYS_MAX);
    let count = rays.div_ceil(skip);
    let every = EVERY_ROWS.max((scans * count).div_ceil(RANGES_MAX));
    let mut last = vec![0; count];
    let mut ranges = Vec::with_capacity(scans.div_ceil(every) * count);
    for scan in (0..scans).step_by(every) {
        for (ray, before) in last.iter_mut().enumerate() {
            let range_m = trace.ranges_m[scan * rays + ray * skip];
            // A surface at the robot's own centre is shown a centimetre away: 0 is no echo.
            let range = if range_m.is_finite() { ((range_m * 1e3 / RANGE_UNIT_MM).round() as i64).max(1) } else { 0 };
            ranges.push(range - std::mem::replace(before, range));
        }
    }
    let step_rad = field_of_view_rad / rays as f64;
    // Ninety steps add up: they are given to the thousandth of a milliradian.
    let mrad = |angle_rad: f64| math::canonical((angle_rad * 1e6).round() / 1e3);
    Some(Lidar {
        first: mrad(0.5 * step_rad - 0.5 * field_of_view_rad),
        step: mrad(step_rad * skip as f64),
        count,
        every,
        unit_mm: RANGE_UNIT_MM,
        ranges,
    })
}

/// The points of a path: ends of lines, and of chords that leave no arc or curve by more than a centimetre.
pub(super) fn points_of(path: &Path) -> Vec<Vec2> {
    let mut points = vec![path.start()];
    for (from, piece) in path.segments() {
        match piece {
            Piece::Line { to } => points.push(*to),
            Piece::Arc { .. } | Piece::Curve(_) => {
                let chords = piece.chord_count(from, 0.01, 200.0);
                points.extend((1..=chords).map(|k| piece.chord_point(from, k, chords)));
            }
        }
    }
    points
}

fn path(path: &Path, tick: u32) -> Planned {
    let points = points_of(path);
    let mut nodes = Vec::new();
    path.key_nodes(&mut nodes);
    Planned {
        row: tick,
        x: deltas(points.iter().map(|p| thousandths(p.x))),
        y: deltas(points.iter().map(|p| thousandths(p.y))),
        nodes: nodes.iter().map(|node| in_mm(node.position)).collect(),
    }
}

fn states(recording: &Recording) -> States {
    let mut names: Vec<&'static str> = Vec::new();
    let mut index = |name: &'static str| {
        names.iter().position(|known| *known == name).unwrap_or_else(|| {
            names.push(name);
            names.len() - 1
        })
    };
    let found = changes(recording.trace.ticks.iter().map(|tick| tick.state.name));
    let changes = found.map(|(row, name)| (row, index(name))).collect();
    States { names, changes }
}

fn notes(recording: &Recording) -> BTreeMap<&'static str, Note> {
    let trace = &recording.trace;
    let values = |index: usize| {
        let of_row = trace.notes.iter().map(|notes| notes.values().get(index).copied().unwrap_or_default());
        deltas(of_row.map(|value| (math::clamp(value, -1e9, 1e9) * NOTE_SCALE).round() as i64))
    };
    let named = trace.note_names.iter().take(NOTES_MAX).enumerate();
    named.map(|(index, name)| (*name, Note { values: values(index), scale: NOTE_SCALE })).collect()
}

/// The point that the robot touched at the end.
fn contact(recording: &Recording) -> Option<Contact> {
    let Recording { scene, outcome, trace, .. } = recording;
    let Outcome::Collision { with, .. } = outcome else { return None };
    let row = trace.ticks.len().checked_sub(1)?;
    let robot = trace.ticks[row].pose.position;
    let grid = &scene.map.grid;
    let nearest = |points: &mut dyn Iterator<Item = Vec2>| {
        points.min_by(|a, b| (a - robot).norm().total_cmp(&(b - robot).norm())).unwrap_or(robot)
    };
    let point = match with {
        ObstacleKind::Dynamic => {
            let present = scene.movers.iter().zip(trace.movers_at(row)).filter(|(_, state)| state.present);
            nearest(&mut present.map(|(mover, state)| mover.outline.nearest_point(state.position, robot)))
        }
        ObstacleKind::UnknownStatic => {
            let there = scene.unknown_static.iter().filter(|obstacle| obstacle.is_present());
            nearest(&mut there.map(|obstacle| obstacle.outline().nearest_point(obstacle.pose().position, robot)))
        }
        ObstacleKind::KnownStatic => {
            nearest(&mut grid.occupied().iter().enumerate().filter(|(_, is)| **is).map(|(index, _)| {
                let square = grid.square(grid.cell(index));
                Vec2::new(
                    math::clamp(robot.x, square.min.x, square.max.x),
                    math::clamp(robot.y, square.min.y, square.max.y),
                )
            }))
        }
        ObstacleKind::Boundary => {
            let extent = grid.extent_m();
            let edges = [
                Vec2::new(0.0, robot.y),
                Vec2::new(extent.x, robot.y),
                Vec2::new(robot.x, 0.0),
                Vec2::new(robot.x, extent.y),
            ];
            nearest(&mut edges.into_iter())
        }
    };
    let [x, y] = in_mm(point);
    Some(Contact { row, x, y, with: with.name() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_packed_comes_out_again() {
        let packed = pack(&vec![1, -2, 3]);
        let bytes = base64::engine::general_purpose::STANDARD.decode(packed).unwrap();
        assert_eq!(miniz_oxide::inflate::decompress_to_vec(&bytes).unwrap(), b"[1,-2,3]");
    }

    #[test]
    fn a_script_cannot_be_ended_by_what_it_holds() {
        assert_eq!(json_in_script(&"</script><!--"), "\"\\u003c/script>\\u003c!--\"");
    }

    #[test]
    fn headings_go_on_over_a_half_turn() {
        let angles = [3.1, -3.1, -3.0, 3.1];
        let found = unwrapped(angles.into_iter());
        let sums: Vec<i64> = found
            .iter()
            .scan(0, |sum, x| {
                *sum += x;
                Some(*sum)
            })
            .collect();
        // −3.1 is 3.183 one turn on.
        assert_eq!(sums, [3100, 3183, 3283, 3100]);
    }

    #[test]
    fn a_map_is_its_runs() {
        let grid = OccupancyGrid::from_ascii(&["..#", "##."], 0.5);
        let map = Map::new(&grid);
        assert_eq!((map.cols, map.rows, map.cells), (3, 2, vec![1, 2, 0, 3, 1, 1]), "from the lower left corner");
    }

    #[test]
    fn changes_are_the_rows_that_differ() {
        let found: Vec<(usize, char)> = changes("aabba".chars()).collect();
        assert_eq!(found, [(0, 'a'), (2, 'b'), (4, 'a')]);
    }
}
