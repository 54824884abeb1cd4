//! The pairing promise: no key but those of the world changes the world.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use simrun::experiment::Experiment;
use simrun::scenario::{Edit, Scenario, ScenarioFile};
use std::collections::BTreeSet;
use std::path::Path;

/// The keys that a world is made from.
const OF_THE_WORLD: [&str; 8] = ["map", "robot", "obstacles", "start", "goal", "script", "episodes", "seed"];

/// Keys that name things and drive none.
const WORDS: [&str; 3] = ["name", "description", "sweep"];

/// Random everything: ends in a narrow map, unknown statics by the route, movers of every random kind, a script.
const TEXT: &str = "
map: {random: {cols: 20, rows: 20, obstacles: 60}}
obstacles:
  unknown_static: [random: {count: 2, placement: on_route, shape: {disc: {radius_m: 0.2}}}, random]
  moving: [random: {count: 2, motion: irregular}, crossing: {count: 1, speed_mps: [0.3, 0.5]}]
script: [{at_s: 2.5, event: {sensor_range: {range_m: 3}}}]
stacks: {global: [a_star], local: [dwa]}
episodes: 12
seed: 3
";

/// Other values for keys of every block that shapes no world.
const EDITS: &[&str] = &[
    "sensing.range_m=2",
    "sensing.field_of_view_rad=2",
    "sensing.occlusion=true",
    "sensing.range_noise_m=0.1",
    "sensing.miss_probability=0.3",
    "sensing.lidar={rays: 8}",
    "localisation.position_noise_m=0.2",
    "localisation.heading_drift_rad=0.1",
    "actuation.latency_ticks=3",
    "actuation.slip_left=[0.1, 0.2]",
    "limits.speed_max_mps=0.4",
    "limits.yaw_rate_max_radps=0.5",
    "planning.inflation_m=0",
    "planning.inflation_m=0.45",
    "planning.inflation_m=0.6",
    "planning.sub_goals=key_nodes",
    "planning.replan=when_blocked",
    "planning.compute.per_expansion_s=0.001",
    "termination.goal_tolerance_m=0.5",
    "termination.timeout_s=100",
    "metrics.near_miss_m=0.1",
    "stacks={global: [dijkstra, none], local: [pure_pursuit]}",
];

/// The fingerprints of the worlds of all episodes; what is infeasible counts by its message.
fn worlds(edits: &[&str]) -> Vec<String> {
    let edits: Vec<Edit> = edits.iter().map(|edit| Edit::parse(edit).unwrap()).collect();
    let file = ScenarioFile::from_text("pairing.yaml", TEXT);
    let scenario = file.read(&edits).unwrap();
    let points = file.points(&scenario, &edits).unwrap();
    let episodes = u64::from(scenario.episodes.get());
    let experiment = Experiment::new(scenario, points, Path::new(".")).unwrap();
    let world = |episode| match experiment.scene(0, episode) {
        Ok(scene) => scene.digest().to_string(),
        Err(infeasible) => infeasible.message,
    };
    (0..episodes).map(world).collect()
}

#[test]
fn no_key_that_is_not_of_the_world_changes_a_world() {
    let plain = worlds(&[]);
    assert_eq!(plain.iter().collect::<BTreeSet<_>>().len(), 12, "every episode has its own: {plain:?}");
    for edit in EDITS {
        assert_eq!(worlds(&[edit]), plain, "{edit}");
    }
}

#[test]
fn keys_of_the_world_do_change_it() {
    let plain = worlds(&[]);
    for edit in [
        "map.random.obstacles=61",
        "robot.radius_m=0.3",
        "obstacles.moving=[]",
        "start=[0.5, 0.5]",
        "goal=[19.5, 19.5]",
        "script=[]",
        "seed=4",
    ] {
        assert_ne!(worlds(&[edit]), plain, "{edit}");
    }
}

#[test]
fn every_block_of_a_scenario_is_one_or_the_other() {
    let schema = Scenario::schema();
    let keys = schema["properties"].as_object().unwrap().keys();
    let tried: BTreeSet<&str> = EDITS.iter().map(|edit| edit.split(['.', '=']).next().unwrap()).collect();
    for key in keys {
        let known = OF_THE_WORLD.contains(&key.as_str()) || WORDS.contains(&key.as_str());
        assert!(known != tried.contains(key.as_str()), "`{key}`: does it shape the world or does it not?");
    }
}
