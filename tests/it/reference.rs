//! Results compared byte for byte with those of `results/reference/`, and with themselves: other
//! thread counts, another order of work, a kill in the middle.
//!
//! `SIMRUN_BLESS=1 cargo test --release --test it reference::` writes the references anew; say in the changelog what moved and why.

use super::support::{is_blessing, root};
use simrun::experiment::{Experiment, Session};
use simrun::results::{EPISODES_CSV, Existing, STATES_CSV, SUMMARY_CSV, compare};
use simrun::scenario::{Edit, ScenarioFile};
use std::fs;
use std::path::{Path, PathBuf};

fn experiment(name: &str, episodes: u32) -> Experiment {
    let file = ScenarioFile::open(root().join(format!("scenarios/{name}.yaml"))).unwrap();
    let edits = [Edit::parse(&format!("episodes={episodes}")).unwrap()];
    let scenario = file.read(&edits).unwrap();
    let points = file.points(&scenario, &edits).unwrap();
    Experiment::new(scenario, points, file.folder()).unwrap()
}

/// Runs the experiment to its end, but stops after `stop_after` blocks where given.
fn run(experiment: &Experiment, path: &Path, threads: usize, stop_after: Option<u64>) {
    let session = Session::open(experiment, path, Existing::Continue).unwrap();
    let stop = || {
        if stop_after.is_some_and(|blocks| session.blocks_done() >= blocks) {
            session.stop();
        }
    };
    session.run(threads, None, stop).unwrap();
    session.finish().unwrap();
}

fn assert_same(left: &Path, right: &Path, hint: &str) {
    for file in [EPISODES_CSV, STATES_CSV, SUMMARY_CSV] {
        if let Some(difference) = compare(&left.join(file), &right.join(file)).unwrap() {
            panic!("{file}: {difference}\n{hint}");
        }
    }
}

/// The shipped scenarios that are kept as references, with how many of their episodes.
const REFERENCES: [(&str, u32); 5] =
    [("warehouse", 4), ("02_wall", 1), ("04_unknown_pallet", 1), ("05_crossing", 6), ("07_movingai", 4)];

#[test]
fn reference_results_have_not_moved() {
    let scratch = tempfile::tempdir().unwrap();
    for (name, episodes) in REFERENCES {
        let fresh = scratch.path().join(name);
        run(&experiment(name, episodes), &fresh, 2, None);
        let reference: PathBuf = root().join("results/reference").join(name);
        if is_blessing() {
            fs::create_dir_all(&reference).unwrap();
            for file in [EPISODES_CSV, STATES_CSV, SUMMARY_CSV] {
                fs::copy(fresh.join(file), reference.join(file)).unwrap();
            }
        }
        assert_same(&reference, &fresh, "left is results/reference: if this was meant to move, see CONTRIBUTING.md");
    }
}

#[test]
fn threads_and_interruptions_do_not_change_a_byte() {
    let scratch = tempfile::tempdir().unwrap();
    let experiment = experiment("05_crossing", 12);
    let one = scratch.path().join("one");
    run(&experiment, &one, 1, None);
    for threads in [2, 8] {
        let many = scratch.path().join(format!("{threads}"));
        run(&experiment, &many, threads, None);
        assert_same(&one, &many, "left ran on one thread");
    }
    let interrupted = scratch.path().join("interrupted");
    run(&experiment, &interrupted, 2, Some(4));
    // What a kill in the middle of a write leaves behind.
    let path = interrupted.join(EPISODES_CSV);
    let mut torn = fs::read(&path).unwrap();
    assert!(torn.len() < fs::read(one.join(EPISODES_CSV)).unwrap().len(), "it was interrupted");
    torn.truncate(torn.len() - 7);
    fs::write(&path, torn).unwrap();
    run(&experiment, &interrupted, 2, None);
    assert_same(&one, &interrupted, "right was interrupted and resumed");
}

#[test]
fn a_row_alone_is_the_row_of_the_whole_run() {
    let experiment = experiment("05_crossing", 6);
    let whole = fs::read_to_string(root().join("results/reference/05_crossing/episodes.csv")).unwrap();
    let drive = experiment.drive_one(0, 5, 2).unwrap();
    let mut line = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    simrun::results::write_row(&mut line, &drive.row).unwrap();
    let line = String::from_utf8(line.into_inner().unwrap()).unwrap();
    assert_eq!(whole.lines().last(), Some(line.trim_end()), "episode 5 of the third stack, run alone");
}
