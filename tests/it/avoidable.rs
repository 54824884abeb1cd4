//! Could the robot have avoided it? Every hit by a mover in the warehouse and in lesson 5, judged by an oracle of its own.
//!
//! From the true state at some time before the contact the oracle tries full braking and 15 × 31 constant twists within the limits, each
//! reached as fast as the limits allow, kept for a while and followed by braking. A hit was avoidable at that time if one of them stays clear
//! for 5 s of all movers, each at its velocity of that moment, and of everything that stands. It knows nothing of the planner.
//!
//! A mover that turns later cannot be foreseen from its velocity; such hits are counted apart. The table of many worlds is
//! printed with `SIMRUN_FULL=1 cargo test --release --test it avoidable:: -- --nocapture`.

use super::support::{is_full, root};
use simrun::episode::{Outcome, Recording};
use simrun::experiment::Experiment;
use simrun::geometry::{Pose, Twist, Vec2};
use simrun::math;
use simrun::scenario::{Edit, ScenarioFile};
use simrun::world::ObstacleKind;

const STEP_S: f64 = 0.05;
const CLEAR_S: f64 = 5.0;
/// Gap that a way out must leave to count as one, m: what the bounds of a planner's distances take off.
const ROOM_M: f64 = 0.01;
const HOLDS_S: [f64; 5] = [0.5, 1.0, 2.0, 3.0, 5.0];

/// Moments before the contact, s; none is the first sight of the mover.
const MOMENTS_S: [Option<f64>; 4] = [None, Some(2.0), Some(1.5), Some(1.0)];

/// A hit, with whether it was avoidable at each of the moments.
struct Hit {
    episode: u64,
    avoidable: [Option<bool>; MOMENTS_S.len()],
    /// The same with gaps down to nothing.
    squeezes: [Option<bool>; MOMENTS_S.len()],
    /// Whether the mover had another velocity at the moment than at the contact.
    turned: [bool; MOMENTS_S.len()],
}

/// Whether a manoeuvre from row `row` of the recording keeps more than `room_m` from everything.
fn escapes(recording: &Recording, row: usize, room_m: f64) -> bool {
    let robot = &recording.robot;
    let (low, high) = (-robot.reverse_speed_max_mps, robot.speed_max_mps);
    let twists = (0..15).flat_map(|v| (0..31).map(move |omega| (f64::from(v) / 14.0, f64::from(omega) / 15.0 - 1.0)));
    let twists = twists.map(|(v, omega)| Twist { v: low + (high - low) * v, omega: robot.yaw_rate_max_radps * omega });
    let now = recording.trace.ticks[row].twist;
    let mut manoeuvres = twists.flat_map(|twist| HOLDS_S.map(|hold_s| (twist, hold_s)));
    let is_clear = |twist: Twist, hold_s: f64| least_gap_m(recording, row, twist, hold_s) > room_m;
    is_clear(now, 0.0) || manoeuvres.any(|(twist, hold_s)| is_clear(twist, hold_s))
}

/// Least gap of a manoeuvre, m; not looked at beyond the first contact.
fn least_gap_m(recording: &Recording, row: usize, wanted: Twist, hold_s: f64) -> f64 {
    let (robot, tick) = (&recording.robot, &recording.trace.ticks[row]);
    let (mut pose, mut twist, mut least_m) = (tick.pose, tick.twist, f64::INFINITY);
    for step in 1..=(CLEAR_S / STEP_S) as u32 {
        let time_s = f64::from(step) * STEP_S;
        let braking = Twist { v: 0.0, omega: slower(twist, robot.deceleration_max_mps2 * STEP_S) };
        let command = if time_s <= hold_s + 1e-9 { wanted } else { braking };
        twist = robot.actuate(twist, command, STEP_S);
        pose = pose.advance(twist, STEP_S);
        least_m = math::min(least_m, gap_m(recording, row, pose, time_s));
        if least_m <= 0.0 {
            break;
        }
    }
    least_m
}

/// The yaw rate that keeps the curvature while the speed falls.
fn slower(twist: Twist, lost: f64) -> f64 {
    if twist.v.abs() > lost { twist.omega * (1.0 - lost / twist.v.abs()) } else { 0.0 }
}

/// Least distance from the robot's edge at `pose` to anything, `time_s` after row `row`, m.
fn gap_m(recording: &Recording, row: usize, pose: Pose, time_s: f64) -> f64 {
    let (p, radius_m) = (pose.position, recording.robot.radius_m);
    let grid = &recording.scene.map.grid;
    let extent = grid.extent_m();
    let mut gap = math::min(math::min(p.x, p.y), math::min(extent.x - p.x, extent.y - p.y)) - radius_m;
    let reach = Vec2::new(radius_m, radius_m);
    let (first, last) = (grid.cell_at(p - reach), grid.cell_at(p + reach));
    for row in first.row..=last.row {
        for col in first.col..=last.col {
            let cell = simrun::map::Cell { col, row };
            if grid.contains(cell) && !grid.is_free(cell) {
                gap = math::min(gap, grid.square(cell).signed_distance(p) - radius_m);
            }
        }
    }
    for obstacle in &recording.scene.unknown_static {
        gap = math::min(gap, obstacle.distance_m(p) - radius_m);
    }
    for (mover, state) in recording.scene.movers.iter().zip(recording.trace.movers_at(row)) {
        if state.present {
            let there = state.position + state.velocity * time_s;
            gap = math::min(gap, mover.outline.distance_m(there, p) - radius_m);
        }
    }
    gap
}

/// The mover in contact at the end of the recording.
fn hit_by(recording: &Recording) -> usize {
    let last = recording.trace.ticks.len() - 1;
    let (p, states) = (recording.trace.ticks[last].pose.position, recording.trace.movers_at(last));
    let gap_m = |k: usize| recording.scene.movers[k].outline.distance_m(states[k].position, p);
    (0..states.len()).filter(|&k| states[k].present).min_by(|&a, &b| gap_m(a).total_cmp(&gap_m(b))).unwrap()
}

/// Judges the hit at the end of the recording.
fn judge(recording: &Recording, episode: u64, range_m: f64) -> Hit {
    let trace = &recording.trace;
    let (last, mover) = (trace.ticks.len() - 1, hit_by(recording));
    let state = |row: usize| trace.movers_at(row)[mover];
    let is_seen = |row: &usize| {
        let gap_m =
            recording.scene.movers[mover].outline.distance_m(state(*row).position, trace.ticks[*row].pose.position);
        state(*row).present && gap_m <= range_m
    };
    let first_sight = (0..=last).rev().take_while(is_seen).last().unwrap_or(last);
    let rows = MOMENTS_S.map(|moment_s| match moment_s {
        None => Some(first_sight),
        Some(moment_s) => {
            last.checked_sub((moment_s / recording.dt_s).round() as usize).filter(|row| *row >= first_sight)
        }
    });
    // The velocity before the tick of the contact: in that tick the mover may have been stopped.
    let met = state(last - 1).velocity;
    let turned = rows.map(|row| row.is_some_and(|row| (state(row).velocity - met).norm() > 0.05));
    let judged = |room_m: f64| rows.map(|row| row.map(|row| escapes(recording, row, room_m)));
    Hit { episode, avoidable: judged(ROOM_M), squeezes: judged(0.0), turned }
}

/// Drives a stack of a scenario and judges every hit by a mover.
fn hits(file: &str, stack: &str, episodes: u64, seed: u64) -> (u64, Vec<Hit>) {
    let file = ScenarioFile::open(root().join(file)).unwrap();
    let edits = [Edit::parse(&format!("seed={seed}")).unwrap(), Edit::parse(&format!("episodes={episodes}")).unwrap()];
    let mut experiment = Experiment::load(&file, &edits).unwrap();
    experiment.keep_stacks(&[stack.to_owned()]).unwrap();
    let range_m = experiment.scenario().sensing.range_m.get();
    let (mut successes, mut hits) = (0, Vec::new());
    for episode in 0..episodes {
        let Ok(drive) = experiment.drive_one(0, episode, 0) else { continue };
        match drive.recording.outcome {
            Outcome::Success => successes += 1,
            Outcome::Collision { with: ObstacleKind::Dynamic, .. } => {
                hits.push(judge(&drive.recording, episode, range_m))
            }
            _ => {}
        }
    }
    (successes, hits)
}

#[expect(clippy::print_stdout, reason = "the table is what is asked for")]
fn print(name: &str, episodes: u64, successes: u64, hits: &[Hit]) {
    println!("{name}: {successes} of {episodes} arrive, {} are hit by a mover", hits.len());
    println!(
        "| moment | hits that were avoidable with 1 cm to spare | of them by a mover that had not turned yet | avoidable at all |"
    );
    println!("|---|---|---|---|");
    for (k, moment_s) in MOMENTS_S.iter().enumerate() {
        let moment = moment_s.map_or_else(|| "first sight".to_owned(), |s| format!("{s:.1} s before"));
        let avoidable = hits.iter().filter(|hit| hit.avoidable[k] == Some(true));
        let known = avoidable.clone().filter(|hit| !hit.turned[k]);
        let numbers: Vec<u64> = known.clone().map(|hit| hit.episode).collect();
        let at_all = hits.iter().filter(|hit| hit.squeezes[k] == Some(true)).count();
        println!("| {moment} | {} | {} {numbers:?} | {at_all} |", avoidable.count(), known.count());
    }
}

#[test]
fn no_hit_of_the_warehouse_or_of_crossing_traffic_could_have_been_avoided_a_second_before() {
    let episodes = if is_full() { 1000 } else { 60 };
    for (file, stack) in [("scenarios/warehouse.yaml", "a_star+dwa"), ("scenarios/05_crossing.yaml", "dwa_predicting")]
    {
        let (successes, hits) = hits(file, stack, episodes, 7_000_000);
        print(file, episodes, successes, &hits);
        let late = hits.iter().filter(|hit| hit.avoidable[3] == Some(true) && !hit.turned[3]).count();
        assert_eq!(late, 0, "{file}");
        assert!(successes * 100 >= episodes * 96, "{file}: {successes} of {episodes}");
    }
}
