//! The memory that a run will take, estimated before any of it is taken.
//!
//! The figures per cell, mover, … were measured as peaks of whole runs; `tests/allocation.rs` holds them within a factor of two. What
//! a run takes besides, the program itself among it, stays below [`Scenario::BASE_BYTES`].

use super::error::ScenarioError;
use super::key_path::KeyPath;
use super::{Scenario, Stacks};
use crate::files;
use crate::plan::local::LocalChoice;
use crate::plan::local::window::Spacing;
use crate::robot::Robot;
use crate::world::obstacles::moving::MovingChoice;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// Memory that a run may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    /// All of it, bytes.
    pub bytes: u64,
    /// Threads that share it.
    pub threads: u64,
    /// Processes, each with maps and recordings of its own.
    pub processes: u64,
}

/// The map and the tables derived from it, bytes a cell.
const MAP_BYTES: u64 = 12;
/// Belief and ways of a thread, bytes a cell.
const BELIEF_BYTES: u64 = 5;
/// Grid and nodes of a global planner, bytes a cell.
const SEARCH_BYTES: u64 = 18;
/// A mover, bytes, and its part of a tick of the trace.
const MOVER_BYTES: [u64; 2] = [1400, 60];
/// A tick of the trace, bytes, and the part of a ray in it.
const TICK_BYTES: u64 = 340;
const RAY_BYTES: u64 = 12;
/// A candidate of a dynamic window, bytes.
const CANDIDATE_BYTES: u64 = 150;
/// A byte of a recording's text, bytes once it is read, and again for each world that plays it.
const RECORDING_BYTES: [u64; 2] = [3, 2];
/// A point of a sweep, and a stack at it, bytes.
const POINT_BYTES: [u64; 2] = [5000, 5000];

/// A part of the estimate: what it is for, by the key that makes it larger.
#[derive(Clone, Debug, PartialEq)]
struct Part {
    key: KeyPath,
    /// Bytes that all threads share.
    shared: u64,
    /// Bytes of each thread.
    each: u64,
}

impl Part {
    fn bytes(&self, room: Room) -> u64 {
        self.shared.saturating_mul(room.processes).saturating_add(self.each.saturating_mul(room.threads))
    }
}

/// The room of a run, and what the points of its sweep that were looked at hold of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    room: Option<Room>,
    held: u64,
    maps: BTreeSet<String>,
}

impl Memory {
    pub(super) fn new(room: Option<Room>) -> Self {
        Self { room, ..Self::default() }
    }

    /// Checks that there is room for a scenario whose map has so many cells; it is held from then on.
    pub(super) fn check(&mut self, scenario: &Scenario, cells: u64, folder: &Path) -> Result<(), ScenarioError> {
        let Some(room) = self.room else { return Ok(()) };
        let Room { bytes, threads, processes } = room;
        let parts = parts(scenario, cells, folder);
        let total = parts
            .iter()
            .map(|part| part.bytes(room))
            .fold(Scenario::BASE_BYTES.saturating_mul(processes), u64::saturating_add);
        let total = total.saturating_add(self.held.saturating_mul(processes));
        if total > bytes {
            let largest = parts.iter().max_by_key(|part| part.bytes(room)).expect("a map at least");
            let threads_said = if threads == 1 { String::new() } else { format!(", run fewer --threads ({threads})") };
            return Err(ScenarioError::new(format!(
                "a run would take about {} of memory, of {} that it may",
                files::size(total),
                files::size(bytes)
            ))
            .key(largest.key.clone())
            .label(format!("about {} for this", files::size(largest.bytes(room))))
            .help(format!("lower it{threads_said}, or allow more with --memory-limit")));
        }
        let [point, stack] = POINT_BYTES;
        self.held = self.held.saturating_add(point + stack * scenario.stacks().len() as u64);
        if scenario.map.is_fixed() && self.maps.insert(serde_json::to_string(&scenario.map).unwrap_or_default()) {
            self.held = self.held.saturating_add(MAP_BYTES.saturating_mul(cells));
        }
        Ok(())
    }
}

impl Scenario {
    /// What every run takes besides, bytes: the program itself, above all.
    pub const BASE_BYTES: u64 = 16 << 20;

    /// Bytes that a run of this scenario, at one point, takes on so many threads, about, if its map has so many cells. Files are
    /// looked up relative to `folder`.
    pub fn memory_bytes(&self, cells: u64, folder: &Path, threads: u64) -> u64 {
        let room = Room { bytes: u64::MAX, threads, processes: 1 };
        parts(self, cells, folder).iter().map(|part| part.bytes(room)).fold(Self::BASE_BYTES, u64::saturating_add)
    }
}

/// Number of cells that the parameters of a map give away; `None` if it must be loaded to know.
pub(super) fn cells_given(scenario: &Scenario) -> Option<u64> {
    let map = serde_json::to_value(&scenario.map).ok()?;
    let params = map.as_object()?.values().next()?;
    let side = |key: &str| params.get(key).and_then(Value::as_u64);
    side("cols")?.checked_mul(side("rows")?)
}

fn parts(scenario: &Scenario, cells: u64, folder: &Path) -> Vec<Part> {
    let part = |key: KeyPath, shared: u64, each: u64| Part { key, shared, each };
    let stacks = scenario.stacks();
    let searches = stacks.iter().filter(|stack| stack.global.is_some()).count() as u64;
    let of_map = MAP_BYTES.saturating_mul(cells);
    let (shared, each) = if scenario.map.is_fixed() { (of_map, 0) } else { (of_map, of_map) };
    let of_thread = cells.saturating_mul(BELIEF_BYTES + SEARCH_BYTES * searches);
    let mut parts = vec![part(KeyPath::parse("map").key(scenario.map.name()), shared, each.saturating_add(of_thread))];

    let ticks = ticks_max(scenario, cells);
    let rays = scenario.sensing.lidar.as_ref().map_or(0, |lidar| u64::from(lidar.rays.get()));
    let of_tick = TICK_BYTES + RAY_BYTES * rays;
    let key = if rays > 0 { "sensing.lidar.rays" } else { "termination" };
    parts.push(part(KeyPath::parse(key), 0, ticks.saturating_mul(of_tick)));

    for (index, moving) in scenario.obstacles.moving.iter().enumerate() {
        let key = KeyPath::parse("obstacles.moving").item(index).key(moving.name());
        let [mover, of_tick] = MOVER_BYTES;
        let of_trace = of_tick.saturating_mul(ticks);
        let each = (moving.kind().count() as u64).saturating_mul(mover.saturating_add(of_trace));
        let (key, shared, each) = match moving {
            MovingChoice::replay(params) => {
                let bytes = files::length(&folder.join(&params.file));
                let [read, played] = RECORDING_BYTES;
                (key.key("file"), bytes.saturating_mul(read), bytes.saturating_mul(played).saturating_add(each))
            }
            _ => (key, 0, each),
        };
        parts.push(part(key, shared, each));
    }

    for (index, stack) in stacks.iter().enumerate() {
        let each = candidates(scenario, &stack.local).saturating_mul(CANDIDATE_BYTES);
        let key = match &scenario.stacks {
            Stacks::Product(product) => {
                let item = product.local.iter().position(|local| *local == stack.local);
                KeyPath::parse("stacks.local").item(item.unwrap_or_default())
            }
            Stacks::List(_) => KeyPath::parse("stacks").item(index).key("local"),
        };
        parts.push(part(key.key(stack.local.name()), 0, each));
    }
    parts
}

/// Candidates of one decision of a dynamic window; 0 for other local planners.
fn candidates(scenario: &Scenario, local: &LocalChoice) -> u64 {
    let tree = serde_json::to_value(local).unwrap_or_default();
    // The window of one planner may be a part of another's parameters.
    let Some(params) = tree.as_object().and_then(|choice| choice.values().next()) else { return 0 };
    let nested = params.as_object().into_iter().flat_map(|keys| keys.values());
    let spacing = |params: &Value, step: &str, count: &str| {
        let step = params.get(step).and_then(Value::as_f64).map(Spacing::Step);
        step.or_else(|| Some(Spacing::Count(params.get(count)?.as_u64()?.try_into().ok()?)))
    };
    let robot = Robot::new(&scenario.robot, &scenario.limits);
    let of = |params: &Value| {
        let speed = spacing(params, "speed_step_mps", "speed_samples")?;
        let yaw_rate = spacing(params, "yaw_rate_step_radps", "yaw_rate_samples")?;
        let [speeds, yaw_rates] = Spacing::most(speed, yaw_rate, &robot, scenario.control_period_s.get());
        Some((speeds * yaw_rates) as u64)
    };
    core::iter::once(params).chain(nested).filter_map(of).sum()
}

/// The ticks of an episode that runs into its time-out, on a map of so many cells that is as long as it is wide.
fn ticks_max(scenario: &Scenario, cells: u64) -> u64 {
    let resolution_m = serde_json::to_value(&scenario.map)
        .ok()
        .and_then(|map| map.as_object()?.values().next()?.get("resolution_m")?.as_f64())
        .unwrap_or(1.0);
    let way_m = (cells as f64).sqrt() * resolution_m;
    let robot = Robot::new(&scenario.robot, &scenario.limits);
    u64::from(scenario.termination.tick_max(way_m, &robot, scenario.control_period_s.get()))
}
