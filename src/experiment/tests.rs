//! Experiments in small worlds, without the command line.

use super::*;
use crate::metrics::Metrics;
use crate::results::{EPISODES_CSV, Existing, Opened, Row, STATES_CSV, SUMMARY_CSV};
use std::collections::BTreeSet;

const BASE: &str = "
name: small
map: {random: {cols: 12, rows: 12, obstacles: 12}}
obstacles: {moving: [random: {count: 1}]}
stacks: {global: [a_star, dijkstra], local: [dwa, pure_pursuit]}
termination: {timeout_s: 40}
seed: 5
";

fn experiment(more: &str) -> Experiment {
    let episodes = if more.contains("episodes:") { "" } else { "episodes: 2\n" };
    let file = ScenarioFile::from_text("small.yaml", format!("{BASE}{episodes}{more}"));
    Experiment::load(&file, &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn rows(experiment: &Experiment, point: u32, episode: u64) -> Vec<Row> {
    let block = experiment.run_block(&mut Worker::default(), point, episode, None).unwrap();
    block.into_iter().map(|answer| answer.row).collect()
}

fn names(experiment: &Experiment, point: u32) -> Vec<&str> {
    experiment.stacks(point).map(|stack| stack.name.as_str()).collect()
}

#[test]
fn a_block_has_a_row_per_stack_all_of_one_world() {
    let experiment = experiment("");
    assert_eq!((experiment.points(), experiment.order().unwrap().rows()), (1, 8));
    let rows = rows(&experiment, 0, 1);
    let stacks = ["a_star+dwa", "a_star+pure_pursuit", "dijkstra+dwa", "dijkstra+pure_pursuit"];
    assert_eq!(rows.iter().map(|row| row.stack.as_str()).collect::<Vec<_>>(), stacks);
    let worlds: BTreeSet<String> = rows.iter().map(|row| format!("{:?}", row.world_digest)).collect();
    assert!(worlds.len() == 1 && rows[0].world_digest.is_some());
    assert!(rows.iter().all(|row| (row.scenario.as_str(), row.episode, row.seed) == ("small", 1, 5)));
}

#[test]
fn a_worker_that_has_driven_other_blocks_gives_the_same_rows() {
    let experiment = experiment("sweep: {stacks.local.dwa.horizon_s: [1, 2]}");
    let mut worker = Worker::default();
    for (point, episode) in [(0, 0), (1, 1), (0, 1), (1, 0), (0, 0)] {
        let used = experiment.run_block(&mut worker, point, episode, None).unwrap();
        let used: Vec<Row> = used.into_iter().map(|answer| answer.row).collect();
        assert_eq!(used, rows(&experiment, point, episode), "point {point}, episode {episode}");
    }
}

#[test]
fn a_drive_alone_is_the_row_of_its_block() {
    let experiment = experiment("");
    for (index, row) in rows(&experiment, 0, 0).into_iter().enumerate() {
        assert_eq!(experiment.drive_one(0, 0, index).unwrap().row, row);
    }
}

#[test]
fn only_the_stacks_that_are_kept_run_and_an_unknown_one_is_refused() {
    let mut experiment = experiment("");
    let error = experiment.keep_stacks(&["a_star+dwaa".to_owned()]).unwrap_err().to_string();
    assert!(error.contains("did you mean `a_star+dwa`?"), "{error}");
    assert_eq!(experiment.stacks(0).len(), 4, "nothing changed");
    let all = rows(&experiment, 0, 0);
    experiment.keep_stacks(&["dijkstra+dwa".to_owned(), "a_star+dwa".to_owned()]).unwrap();
    assert_eq!(names(&experiment, 0), ["a_star+dwa", "dijkstra+dwa"], "in the scenario's order");
    assert_eq!(rows(&experiment, 0, 0), [all[0].clone(), all[2].clone()]);
}

#[test]
fn a_world_that_cannot_be_is_a_row_for_every_stack() {
    let text =
        "map: {random: {cols: 8, rows: 8, obstacles: 48}}\nstacks: {global: [a_star], local: [dwa, pure_pursuit]}\n";
    let experiment = Experiment::load(&ScenarioFile::from_text("full.yaml", text), &[]).unwrap();
    let rows = rows(&experiment, 0, 0);
    assert_eq!(rows.iter().map(|row| row.outcome.name()).collect::<Vec<_>>(), ["infeasible_world"; 2]);
    assert!(rows.iter().all(|row| row.world_digest.is_none() && !row.outcome.message().is_empty()));
}

#[test]
fn a_session_that_stops_is_finished_by_the_next_one_to_the_same_bytes() {
    let experiment = experiment("sweep: {limits.speed_max_mps: [0.5, 1]}");
    let scratch = tempfile::tempdir().unwrap();
    let read = |folder: &str| {
        [EPISODES_CSV, STATES_CSV, SUMMARY_CSV]
            .map(|file| std::fs::read(scratch.path().join(folder).join(file)).unwrap())
    };
    let open = |folder: &str| Session::open(&experiment, &scratch.path().join(folder), Existing::Continue).unwrap();
    let whole = open("whole");
    whole.run(1, None, || {}).unwrap();
    assert_eq!(whole.finish().unwrap().unwrap().len(), 8, "a summary of every stack at every point");

    let session = open("parts");
    session.run(1, None, || session.stop()).unwrap();
    assert_eq!((session.blocks_done(), session.finish().unwrap()), (1, None));
    let session = open("parts");
    assert_eq!(session.opened(), Opened::Resume { blocks_done: 1 });
    session.run(3, None, || {}).unwrap();
    session.finish().unwrap().unwrap();
    assert_eq!(read("parts"), read("whole"));
    assert_eq!(open("parts").opened(), Opened::Complete);
}

/// (point, stack, swept values) of every row, without driving.
fn driven(experiment: &Experiment) -> Vec<(u32, String, String)> {
    let order = experiment.order().unwrap();
    let points = (0..).zip(order.points());
    points.flat_map(|(point, stacks)| stacks.iter().map(move |s| (point, s.name.clone(), s.values.join("|")))).collect()
}

const TWO: &str = "sweep: {stacks.local.dwa.horizon_s: [1, 2], stacks.local.pure_pursuit.lookahead_m: [0.5, 1]}";

#[test]
fn a_product_over_two_planners_drives_each_at_its_own_settings_once() {
    let mut experiment = experiment(TWO);
    experiment.keep_stacks(&["a_star+dwa".to_owned(), "a_star+pure_pursuit".to_owned()]).unwrap();
    let row = |point: u32, stack: &str, values: &str| (point, format!("a_star+{stack}"), values.to_owned());
    assert_eq!(
        driven(&experiment),
        [row(0, "dwa", "1|"), row(0, "pure_pursuit", "|0.5"), row(1, "pure_pursuit", "|1"), row(2, "dwa", "2|")]
    );
    // The fourth point has nothing new, and keeps its number.
    assert_eq!((experiment.points(), experiment.stacks(3).len()), (4, 0));
    assert_eq!(experiment.values(3), ["2", "1"]);
}

#[test]
fn a_zip_over_two_planners_may_repeat_a_value() {
    let zip =
        TWO.replace("{stacks", "{zip: {stacks").replace("[1, 2]", "[1, 2, 2]").replace("[0.5, 1]}", "[0.5, 0.5, 1]}}");
    let mut experiment = experiment(&zip);
    experiment.keep_stacks(&["a_star+dwa".to_owned(), "a_star+pure_pursuit".to_owned()]).unwrap();
    let found: Vec<String> =
        driven(&experiment).into_iter().map(|(point, stack, values)| format!("{point} {stack} {values}")).collect();
    assert_eq!(found, ["0 a_star+dwa 1|", "0 a_star+pure_pursuit |0.5", "1 a_star+dwa 2|", "2 a_star+pure_pursuit |1"]);
}

#[test]
fn every_row_of_a_three_axis_sweep_replays_alone_with_its_own_number() {
    let sweep = "sweep: {limits.speed_max_mps: [0.6, 1], stacks.global.a_star.corner_rule: [forbid, allow], stacks.local.dwa.horizon_s: [1, 2]}";
    let experiment = experiment(sweep);
    let wholes: Vec<Vec<Row>> = (0..experiment.points()).map(|point| rows(&experiment, point, 1)).collect();
    let mut rows = 0;
    for name in experiment.stack_names() {
        let mut alone = self::experiment(sweep);
        alone.keep_stacks(std::slice::from_ref(&name)).unwrap();
        assert_eq!(alone.points(), 8, "points keep their numbers");
        for (point, whole) in (0..).zip(&wholes) {
            let whole: Vec<&Row> = whole.iter().filter(|row| row.stack == name).collect();
            let found = if whole.is_empty() { Vec::new() } else { self::rows(&alone, point, 1) };
            assert_eq!(found.iter().collect::<Vec<_>>(), whole);
            assert_eq!(names(&alone, point).len(), whole.len());
            rows += whole.len();
        }
    }
    // At each speed: dwa with a_star at all four settings, dwa with dijkstra at two horizons, pure_pursuit with a_star at
    // two rules and with dijkstra at one.
    assert_eq!(rows, 2 * (4 + 2 + 2 + 1));
}

#[test]
fn the_times_of_the_states_add_up_to_the_time_of_the_episode() {
    for answer in experiment("").run_block(&mut Worker::default(), 0, 1, None).unwrap() {
        let sum_s: f64 = answer.states.iter().map(|state| state.seconds).sum();
        assert!((sum_s - answer.row.metrics.time_s.unwrap()).abs() < 1e-9, "{answer:?}");
        assert!(answer.states.iter().all(|state| state.entries > 0));
    }
}

/// An experiment whose parts `probe` enters first.
fn faulty(more: &str, probe: Probe) -> Experiment {
    let mut experiment = experiment(more);
    experiment.set_probe(probe);
    experiment
}

fn run_to_the_end(experiment: &Experiment, folder: &Path) -> Vec<Row> {
    let session = Session::open(experiment, folder, Existing::Replace).unwrap();
    session.run(2, None, || {}).unwrap();
    session.finish().unwrap().unwrap();
    let table = std::fs::read(folder.join(EPISODES_CSV)).unwrap();
    results::Reader::new(table.as_slice()).unwrap().map(Result::unwrap).collect()
}

#[test]
fn a_panic_in_any_part_of_a_work_item_is_a_row_that_names_it_and_the_run_goes_on() {
    let probes: [(Phase, Probe); 4] = [
        (Phase::WorldGeneration, |phase, episode| {
            assert!((phase, episode) != (Phase::WorldGeneration, 1), "no ground")
        }),
        (Phase::Drive, |phase, episode| assert!((phase, episode) != (Phase::Drive, 1), "no wheels")),
        (Phase::Metrics, |phase, episode| assert!((phase, episode) != (Phase::Metrics, 1), "no ruler")),
        (Phase::Encoding, |phase, episode| assert!((phase, episode) != (Phase::Encoding, 1), "no pen")),
    ];
    let scratch = tempfile::tempdir().unwrap();
    let healthy = run_to_the_end(&experiment("episodes: 3"), &scratch.path().join("healthy"));
    for (phase, probe) in probes {
        let experiment = faulty("episodes: 3", probe);
        let rows = run_to_the_end(&experiment, &scratch.path().join(phase.name()));
        assert_eq!(rows.len(), healthy.len());
        for (row, healthy) in rows.iter().zip(&healthy) {
            if row.episode != 1 {
                assert_eq!(row, healthy, "{phase:?}");
                continue;
            }
            let said = row.outcome.message();
            assert_eq!(row.outcome.name(), "internal_error", "{phase:?}");
            assert!(said.starts_with(&format!("{}: no ", phase.name())), "{said}");
            assert!(said.contains(" (src/experiment/tests.rs:"), "{said}");
            let command = format!("; replay: simrun run small.yaml --episode 1 --stack {} --seed 5", row.stack);
            assert!(said.ends_with(&command), "{said}");
            // The world is still the world, unless it is what failed.
            assert_eq!(row.world_digest, healthy.world_digest.filter(|_| phase != Phase::WorldGeneration), "{phase:?}");
            assert!(row.trace_digest.is_none() && row.metrics == Metrics::default());
        }
        let summary = results::summarise(
            std::fs::read(scratch.path().join(phase.name()).join(EPISODES_CSV)).unwrap().as_slice(),
            3,
        );
        assert!(summary.unwrap().iter().all(|row| (row.n, row.rated, row.count("internal_error")) == (3, 2, 1)));
    }
}

#[test]
fn the_command_of_a_row_names_point_and_edits_so_that_a_shell_hands_them_on() {
    let file =
        ScenarioFile::from_text("some where/it.yaml", format!("{BASE}sweep: {{limits.speed_max_mps: [0.5, 1]}}"));
    let edits =
        ["episodes=9", "seed=8", "stacks.local=[dwa]", "robot.radius_m=0.2"].map(|text| Edit::parse(text).unwrap());
    let experiment = Experiment::load(&file, &edits).unwrap();
    assert_eq!(
        experiment.replay_command(1, 7, "a_star+dwa"),
        "simrun run 'some where/it.yaml' --point 1 --episode 7 --stack a_star+dwa --seed 8 \
         --set 'stacks.local=[dwa]' --set robot.radius_m=0.2"
    );
}

#[test]
fn a_worker_that_has_met_a_fault_drives_on_as_a_new_one() {
    let experiment = faulty("", |phase, episode| assert!((phase, episode) != (Phase::Metrics, 1), "no ruler"));
    let mut worker = Worker::default();
    for episode in [0, 1, 0] {
        let used = experiment.run_block(&mut worker, 0, episode, None).unwrap();
        let used: Vec<Row> = used.into_iter().map(|answer| answer.row).collect();
        assert_eq!(used, rows(&experiment, 0, episode));
    }
}

#[test]
fn many_more_threads_than_blocks_are_as_good_as_few() {
    let scratch = tempfile::tempdir().unwrap();
    let experiment = experiment("");
    let session = Session::open(&experiment, scratch.path(), Existing::Replace).unwrap();
    session.run(100_000, None, || {}).unwrap();
    assert_eq!(session.finish().unwrap().unwrap().len(), 4);
}
