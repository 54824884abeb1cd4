//! Children that hang, abort, overflow their stack or are killed. This test binary is its own child: a probe in the experiment does
//! what no shipped code does.

use simrun::experiment::{Experiment, Isolation, Phase, Session, serve};
use simrun::results::{EPISODES_CSV, Existing, Opened, Reader, ResultsError, Row};
use simrun::scenario::ScenarioFile;
use std::path::Path;
use std::process::Command;

const SCENARIO: &str = "
map: {empty: {cols: 12, rows: 12}}
stacks: {global: [a_star, dijkstra], local: [pure_pursuit]}
episodes: 4
";

/// Names what the child does in the second episode; without it `child` is a test that has nothing to do.
const MISBEHAVES: &str = "SIMRUN_TEST_CHILD";

fn experiment() -> Experiment {
    Experiment::load(&ScenarioFile::from_text("small.yaml", SCENARIO), &[]).unwrap()
}

fn hang() -> ! {
    loop {
        std::hint::black_box(0);
    }
}

fn overflow(depth: u64) -> u64 {
    let frame = [depth; 128];
    std::hint::black_box(&frame);
    if depth == u64::MAX { 0 } else { overflow(depth + 1) + frame[3] }
}

/// The child: not a test of its own.
#[test]
#[expect(clippy::exit, reason = "one of the ways in which a child may end")]
fn child() {
    let Some(what) = std::env::var_os(MISBEHAVES) else { return };
    let mut experiment = experiment();
    let probe: fn(Phase, u64) = match what.to_str().unwrap() {
        "hang" => |phase, episode| {
            if (phase, episode) == (Phase::Drive, 1) {
                hang()
            }
        },
        "hang_in_the_world" => |phase, episode| {
            if (phase, episode) == (Phase::WorldGeneration, 1) {
                hang()
            }
        },
        "abort" => |phase, episode| {
            if (phase, episode) == (Phase::Metrics, 1) {
                std::process::abort()
            }
        },
        "overflow" => |phase, episode| {
            if (phase, episode) == (Phase::Drive, 1) {
                std::hint::black_box(overflow(0));
            }
        },
        "leave" => |phase, episode| {
            if (phase, episode) == (Phase::Encoding, 1) {
                std::process::exit(3)
            }
        },
        _ => |_, _| {},
    };
    experiment.set_probe(probe);
    serve(&experiment, None, std::io::stdin(), &mut std::io::stdout()).unwrap();
}

/// Runs in children that misbehave.
fn run(folder: &Path, what: &str, give_up_after_s: Option<f64>) -> (Opened, Vec<Row>) {
    let command = || {
        let mut command = Command::new(std::env::current_exe().unwrap());
        command.args(["--exact", "isolation::child", "--nocapture"]).env(MISBEHAVES, what);
        command
    };
    let experiment = experiment();
    // A child that another test starts at this moment holds the last run's lock until it has become another program.
    let opened = std::iter::repeat_with(|| Session::open(&experiment, folder, Existing::Continue));
    let session =
        opened.filter(|opened| !matches!(opened, Err(ResultsError::Locked { .. }))).map(Result::unwrap).next();
    let session = session.unwrap();
    let opened = session.opened();
    session.run_isolated(2, &Isolation { command: &command, give_up_after_s }, || {}).unwrap();
    session.finish().unwrap().unwrap();
    let table = std::fs::read(folder.join(EPISODES_CSV)).unwrap();
    (opened, Reader::new(table.as_slice()).unwrap().map(Result::unwrap).collect())
}

/// The rows of a healthy run.
fn healthy() -> Vec<Row> {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), "nothing", None).1
}

#[test]
fn a_child_that_dies_is_a_row_with_its_signal_and_the_run_goes_on() {
    let healthy = healthy();
    for (what, said) in [("abort", "SIGABRT"), ("overflow", "SIGABRT"), ("leave", "exit code 3")] {
        let folder = tempfile::tempdir().unwrap();
        let (_, rows) = run(folder.path(), what, None);
        assert_eq!(rows.len(), healthy.len());
        for (row, healthy) in rows.iter().zip(&healthy) {
            if row.episode == 1 {
                let message = row.outcome.message();
                assert_eq!(row.outcome.name(), "internal_error", "{what}");
                assert!(message.starts_with("drive: its process ") && message.contains(said), "{what}: {message}");
                let command = format!("; replay: simrun run small.yaml --episode 1 --stack {} --seed 1", row.stack);
                assert!(message.ends_with(&command), "{message}");
            } else {
                assert_eq!(row, healthy, "{what}");
            }
        }
    }
}

#[test]
fn a_child_that_hangs_is_given_up_and_its_drive_is_driven_again_when_the_run_goes_on() {
    let healthy = healthy();
    for what in ["hang", "hang_in_the_world"] {
        let folder = tempfile::tempdir().unwrap();
        let (opened, rows) = run(folder.path(), what, Some(1.0));
        assert_eq!((opened, rows.len()), (Opened::Fresh, healthy.len()));
        for (row, healthy) in rows.iter().zip(&healthy) {
            let has_hung = row.outcome.name() == "gave_up";
            assert_eq!(has_hung, row.episode == 1, "{what}: {row:?}");
            assert!(has_hung || row == healthy, "{what}");
        }
        // The same command again, now that the machine is quick enough.
        let (opened, rows) = run(folder.path(), "nothing", Some(60.0));
        assert_eq!((opened, &rows), (Opened::Resume { blocks_done: 3 }, &healthy), "{what}");
        assert_eq!(run(folder.path(), "nothing", None).0, Opened::Complete);
    }
}
