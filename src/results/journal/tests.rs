//! The journal, on rows that are pure functions of their places.

use super::*;
use crate::digest::Digest;
use crate::episode::Outcome;
use crate::metrics::{Metrics, StateTime};
use crate::results::row::Row;
use crate::results::timings::Timing;
use crate::rng::{EpisodeSeed, Purpose};

const SEED: u64 = 7;

fn identity(scenario: &str) -> Identity {
    Identity {
        version: "1".to_owned(),
        build: "b".to_owned(),
        seed: SEED,
        stacks: vec!["a".to_owned(), "b".to_owned()],
        scenario_hash: String::new(),
        scenario: scenario.to_owned(),
        files: BTreeMap::new(),
    }
}

/// `points` points; the first has two stacks, the others one.
fn order(points: usize, episodes: u64) -> Order {
    let point = |index: usize| {
        let names: &[&str] = if index == 0 { &["a", "b,c"] } else { &["a"] };
        names.iter().map(|name| StackAt { name: (*name).to_owned(), values: vec![format!("0.{index}")] }).collect()
    };
    Order::new(vec!["robot.radius_m".to_owned()], (0..points).map(point).collect(), episodes).unwrap()
}

/// The rows of a block, a pure function of its place.
fn rows(block: &Block<'_>) -> Vec<Answer> {
    let (point, episode) = (block.point(), block.episode());
    let row = |StackAt { name: stack, values }: &StackAt| {
        let mut stream = EpisodeSeed { seed: u64::from(point), episode }.stream(Purpose::Planner, stack.len() as u64);
        Row {
            scenario: "s".to_owned(),
            point,
            stack: stack.clone(),
            global: "a_star".to_owned(),
            path: String::new(),
            local: "dwa".to_owned(),
            episode,
            seed: SEED,
            outcome: match stream.index(3) {
                0 => Outcome::PlannerError { message: "it said \"no\",\nthen fell".to_owned() },
                _ => Outcome::Success,
            },
            metrics: Metrics { time_s: Some(stream.uniform()), ..Metrics::default() },
            world_digest: Some(Digest(stream.bits())),
            trace_digest: None,
            swept: values.clone(),
        }
    };
    let answer = |stack: &StackAt| {
        let row = row(stack);
        let time_s = row.metrics.time_s.unwrap();
        let state = |name: &str, seconds: f64| StateTime { state: name.to_owned(), seconds, entries: 1 };
        let states = vec![state("track", 0.25 * time_s), state("recover", 0.75 * time_s)];
        Answer { row, states, timing: Timing::default() }
    };
    block.stacks().iter().map(answer).collect()
}

fn open(path: &Path, points: usize, episodes: u64) -> Result<Journal, ResultsError> {
    Journal::open(path, identity("k: 1"), order(points, episodes), Existing::Continue)
}

/// Runs at most `blocks` blocks.
fn run(folder: &Journal, blocks: u64) -> u64 {
    let mut ran = 0;
    while ran < blocks
        && let Some(block) = folder.take()
    {
        let rows = rows(&block);
        folder.submit(block, &rows).unwrap();
        ran += 1;
    }
    ran
}

fn content(path: &Path) -> [Vec<u8>; 3] {
    [EPISODES_CSV, STATES_CSV, SUMMARY_CSV].map(|name| std::fs::read(path.join(name)).unwrap())
}

/// What an undisturbed run writes.
fn undisturbed(points: usize, episodes: u64) -> [Vec<u8>; 3] {
    let directory = tempfile::tempdir().unwrap();
    let folder = open(directory.path(), points, episodes).unwrap();
    assert_eq!(folder.opened(), Opened::Fresh);
    run(&folder, u64::MAX);
    folder.finish().unwrap().unwrap();
    content(directory.path())
}

#[test]
fn a_file_torn_at_any_byte_is_resumed_to_the_same_bytes() {
    let whole = undisturbed(2, 2);
    for (table, name) in [EPISODES_CSV, STATES_CSV].into_iter().enumerate() {
        let directory = tempfile::tempdir().unwrap();
        run(&open(directory.path(), 2, 2).unwrap(), u64::MAX);
        let paths = [EPISODES_CSV, STATES_CSV].map(|name| directory.path().join(name));
        let manifest = std::fs::read(directory.path().join(MANIFEST_JSON)).unwrap();
        let text = &whole[table];
        let header = text.iter().position(|&byte| byte == b'\n').unwrap() + 1;
        let mut fewest_run = u64::MAX;
        // Everything behind the header, and a few places inside it; the other table is whole.
        for torn in (0..header).step_by(97).chain(header - 1..=text.len()) {
            std::fs::write(&paths[table], &text[..torn]).unwrap();
            std::fs::write(directory.path().join(MANIFEST_JSON), &manifest).unwrap();
            let folder = open(directory.path(), 2, 2).unwrap();
            let ran = run(&folder, u64::MAX);
            // Without `finish`, which waits for the disk: the summary is a function of these bytes.
            for (path, expected) in paths.iter().zip(&whole) {
                assert_eq!(std::fs::read(path).unwrap(), *expected, "{name} torn at byte {torn}");
            }
            // The more there was, the less is to do.
            assert!(ran <= fewest_run, "{name} torn at byte {torn}: {ran} blocks");
            fewest_run = ran;
        }
        assert_eq!(fewest_run, 0);
    }
}

#[test]
fn a_run_killed_between_blocks_goes_on_where_it_was() {
    let expected = undisturbed(3, 4);
    for killed in 0..=12 {
        let directory = tempfile::tempdir().unwrap();
        // Dropping without `finish` is what a kill leaves.
        assert_eq!(run(&open(directory.path(), 3, 4).unwrap(), killed), killed);
        let folder = open(directory.path(), 3, 4).unwrap();
        let opened = match killed {
            0 => Opened::Fresh,
            12 => Opened::Complete,
            _ => Opened::Resume { blocks_done: killed },
        };
        assert_eq!((folder.opened(), folder.blocks_done()), (opened, killed));
        assert_eq!(run(&folder, u64::MAX), 12 - killed);
        folder.finish().unwrap().unwrap();
        assert_eq!(content(directory.path()), expected);
    }
}

#[test]
fn a_complete_folder_is_left_as_it_is() {
    let directory = tempfile::tempdir().unwrap();
    let folder = open(directory.path(), 1, 3).unwrap();
    run(&folder, u64::MAX);
    let summary = folder.finish().unwrap();
    let files = || {
        [EPISODES_CSV, SUMMARY_CSV, MANIFEST_JSON, TIMINGS_CSV]
            .map(|name| std::fs::read(directory.path().join(name)).unwrap())
    };
    let before = files();
    let folder = open(directory.path(), 1, 3).unwrap();
    assert_eq!(folder.opened(), Opened::Complete);
    assert!(folder.take().is_none());
    assert_eq!(folder.finish().unwrap(), summary);
    assert_eq!(files(), before);
}

#[test]
fn the_manifest_has_the_hashes_of_finished_tables_and_of_no_others() {
    let directory = tempfile::tempdir().unwrap();
    let manifest = || Manifest::read(directory.path()).unwrap();
    let folder = open(directory.path(), 2, 3).unwrap();
    run(&folder, 4);
    folder.stop();
    assert_eq!(folder.finish().unwrap(), None);
    assert_eq!(manifest().tables, BTreeMap::new());
    let folder = open(directory.path(), 2, 3).unwrap();
    run(&folder, u64::MAX);
    folder.finish().unwrap().unwrap();
    let names = [EPISODES_CSV, STATES_CSV, SUMMARY_CSV];
    let hashes: BTreeMap<String, String> = names
        .map(str::to_owned)
        .into_iter()
        .zip(content(directory.path()).map(|bytes| Digest::of(&bytes).to_string()))
        .collect();
    assert_eq!(manifest().tables, hashes);
    // Killed between the summary and the hashes: the next start writes them.
    write_manifest(directory.path(), &Manifest { tables: BTreeMap::new(), ..manifest() }).unwrap();
    let folder = open(directory.path(), 2, 3).unwrap();
    assert_eq!(folder.opened(), Opened::Complete);
    folder.finish().unwrap().unwrap();
    assert_eq!(manifest().tables, hashes);
    // An extension is not finished until it is.
    let folder = open(directory.path(), 2, 5).unwrap();
    assert_eq!(manifest().tables, BTreeMap::new());
    run(&folder, u64::MAX);
    folder.finish().unwrap().unwrap();
    assert_eq!(content(directory.path()), undisturbed(2, 5));
    assert!(names.iter().all(|name| manifest().tables[*name] != hashes[*name]));
    // What lies behind complete tables is cut where no hash forbids it.
    write_manifest(directory.path(), &Manifest { tables: BTreeMap::new(), ..manifest() }).unwrap();
    let table = directory.path().join(EPISODES_CSV);
    let whole = std::fs::read(&table).unwrap();
    std::fs::write(&table, [&whole[..], b"torn"].concat()).unwrap();
    open(directory.path(), 2, 5).unwrap().finish().unwrap().unwrap();
    assert_eq!(std::fs::read(&table).unwrap(), whole);
    std::fs::write(&table, [&whole[..], b"torn"].concat()).unwrap();
    assert!(matches!(open(directory.path(), 2, 5).unwrap_err(), ResultsError::Altered { .. }));
}

#[test]
fn stopping_leaves_a_folder_without_summary_that_goes_on() {
    let directory = tempfile::tempdir().unwrap();
    let folder = open(directory.path(), 1, 5).unwrap();
    run(&folder, 2);
    let taken = folder.take().unwrap();
    folder.stop();
    assert!(folder.take().is_none());
    let rows = rows(&taken);
    folder.submit(taken, &rows).unwrap();
    assert_eq!(folder.finish().unwrap(), None);
    assert!(!directory.path().join(SUMMARY_CSV).exists());
    assert_eq!(open(directory.path(), 1, 5).unwrap().opened(), Opened::Resume { blocks_done: 3 });
}

#[test]
fn answers_in_any_order_from_any_thread_make_the_same_bytes() {
    let expected = undisturbed(2, 150);
    for (threads, window) in [(1, 1), (2, 1), (3, 2), (8, 7), (8, WINDOW_BLOCKS)] {
        let directory = tempfile::tempdir().unwrap();
        let folder =
            Journal::open_with_window(directory.path(), identity("k: 1"), order(2, 150), Existing::Continue, window)
                .unwrap();
        std::thread::scope(|scope| {
            for thread in 0..threads {
                let folder = &folder;
                scope.spawn(move || {
                    let mut stream = EpisodeSeed { seed: 3, episode: thread }.stream(Purpose::Planner, 0);
                    while let Some(block) = folder.take() {
                        let rows = rows(&block);
                        // Some blocks take long.
                        (0..stream.index(20)).for_each(|_| std::thread::yield_now());
                        let index = block.index();
                        folder.submit(block, &rows).unwrap();
                        let state = folder.state();
                        assert!(state.waiting.len() as u64 <= window && index < state.written + window);
                    }
                });
            }
        });
        folder.finish().unwrap().unwrap();
        assert_eq!(content(directory.path()), expected);
    }
}

#[test]
fn later_blocks_wait_for_the_first_one() {
    let directory = tempfile::tempdir().unwrap();
    let folder =
        Journal::open_with_window(directory.path(), identity("k: 1"), order(1, 4), Existing::Continue, 3).unwrap();
    let header = header_line(folder.order().swept());
    let blocks: Vec<Block<'_>> = (0..3).map(|_| folder.take().unwrap()).collect();
    for block in blocks.into_iter().rev() {
        assert_eq!(std::fs::read(directory.path().join(EPISODES_CSV)).unwrap(), header);
        let rows = rows(&block);
        folder.submit(block, &rows).unwrap();
    }
    run(&folder, u64::MAX);
    folder.finish().unwrap().unwrap();
    assert_eq!(content(directory.path()), undisturbed(1, 4));
}

#[test]
fn a_folder_in_use_is_refused_until_its_owner_ends() {
    let directory = tempfile::tempdir().unwrap();
    let owner = open(directory.path(), 1, 2).unwrap();
    for _ in 0..2 {
        let error = open(directory.path(), 1, 2).unwrap_err();
        assert!(matches!(error, ResultsError::Locked { .. }));
        assert!(error.to_string().contains(&*directory.path().to_string_lossy()), "{error}");
    }
    drop(owner);
    open(directory.path(), 1, 2).unwrap();
}

#[test]
fn another_run_is_refused_with_the_difference_named_until_it_is_to_be_replaced() {
    let directory = tempfile::tempdir().unwrap();
    run(&open(directory.path(), 1, 2).unwrap(), 1);
    let before = std::fs::read(directory.path().join(EPISODES_CSV)).unwrap();
    let open = |existing| Journal::open(directory.path(), identity("k: 2"), order(1, 2), existing);
    let error = open(Existing::Continue).unwrap_err().to_string();
    assert!(error.contains("`k`: 1 there, 2 here") && error.contains("--force"), "{error}");
    assert_eq!(std::fs::read(directory.path().join(EPISODES_CSV)).unwrap(), before);
    let folder = open(Existing::Replace).unwrap();
    assert_eq!(folder.opened(), Opened::Fresh);
    run(&folder, u64::MAX);
    folder.finish().unwrap().unwrap();
    assert_eq!(open(Existing::Continue).unwrap().opened(), Opened::Complete);
    assert_eq!(content(directory.path()), undisturbed(1, 2));
}

#[test]
fn more_episodes_make_the_bytes_of_a_longer_run() {
    for (points, old, new, blocks) in
        [(1, 2, 5, 2), (1, 4, 5, 3), (3, 2, 5, 6), (3, 2, 5, 5), (3, 2, 3, 3), (3, 4, 5, 2)]
    {
        let directory = tempfile::tempdir().unwrap();
        run(&open(directory.path(), points, old).unwrap(), blocks);
        let folder = open(directory.path(), points, new).unwrap();
        assert_eq!(folder.opened(), Opened::Resume { blocks_done: blocks });
        assert_eq!(run(&folder, u64::MAX), points as u64 * new - blocks, "nothing runs twice");
        folder.finish().unwrap().unwrap();
        assert_eq!(content(directory.path()), undisturbed(points, new));
        assert!([EXTENDED_CSV, EXTENDED_STATES_CSV].iter().all(|name| !directory.path().join(name).exists()));
    }
}

#[test]
fn an_extension_killed_anywhere_is_finished_to_the_same_bytes() {
    let expected = undisturbed(3, 4);
    for killed in 0..6 {
        let directory = tempfile::tempdir().unwrap();
        run(&open(directory.path(), 3, 2).unwrap(), 6);
        run(&open(directory.path(), 3, 4).unwrap(), killed);
        let folder = open(directory.path(), 3, 4).unwrap();
        assert_eq!(folder.opened(), Opened::Resume { blocks_done: 6 + killed });
        assert_eq!(run(&folder, u64::MAX), 6 - killed);
        folder.finish().unwrap().unwrap();
        assert_eq!(content(directory.path()), expected);
    }
    // Killed after the old tables were set aside and before the new ones were there, or between the two.
    for is_half in [false, true] {
        let directory = tempfile::tempdir().unwrap();
        run(&open(directory.path(), 3, 2).unwrap(), 6);
        resume::set_aside(directory.path()).unwrap();
        if is_half {
            std::fs::rename(directory.path().join(EXTENDED_CSV), directory.path().join(EPISODES_CSV)).unwrap();
            assert_eq!(open(directory.path(), 3, 2).unwrap().opened(), Opened::Complete, "nothing is lost");
        }
        let folder = open(directory.path(), 3, 4).unwrap();
        assert_eq!(run(&folder, u64::MAX), 6);
        folder.finish().unwrap().unwrap();
        assert_eq!(content(directory.path()), expected);
    }
}

#[test]
fn another_extension_waits_for_the_first_and_the_old_number_is_always_there() {
    let directory = tempfile::tempdir().unwrap();
    run(&open(directory.path(), 3, 2).unwrap(), 6);
    // Two new episodes of the first point, then the copies up to the next gap: the second point is begun.
    run(&open(directory.path(), 3, 4).unwrap(), 2);
    for asked in [2, 3, 5] {
        let error = open(directory.path(), 3, asked).unwrap_err();
        assert!(matches!(error, ResultsError::UnfinishedExtension { episodes: 4, .. }), "{error}");
    }
    open(directory.path(), 3, 4).unwrap();
}

#[test]
fn fewer_episodes_than_present_are_refused() {
    for (points, blocks) in [(1, 3), (2, 3), (2, 4), (2, 6)] {
        let directory = tempfile::tempdir().unwrap();
        run(&open(directory.path(), points, 3).unwrap(), blocks);
        let error = open(directory.path(), points, 2).unwrap_err();
        assert!(matches!(error, ResultsError::TooManyEpisodes { present: 3, asked: 2, .. }), "{error}");
    }
    // A run that has not come that far may end earlier.
    let directory = tempfile::tempdir().unwrap();
    run(&open(directory.path(), 1, 5).unwrap(), 2);
    assert_eq!(open(directory.path(), 1, 2).unwrap().opened(), Opened::Complete);
}

#[test]
fn rows_that_this_run_would_not_write_are_refused_by_line() {
    let directory = tempfile::tempdir().unwrap();
    let folder = open(directory.path(), 2, 2).unwrap();
    run(&folder, u64::MAX);
    folder.finish().unwrap();
    let path = directory.path().join(EPISODES_CSV);
    let text = std::fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let without = |gone: usize| {
        let kept: Vec<&str> = lines.iter().enumerate().filter(|(i, _)| *i != gone).map(|(_, line)| *line).collect();
        kept.join("\n") + "\n"
    };
    for (edited, message) in [
        (without(3), "line 4: expected point 0, episode 1, stack `a`, found point 0, episode 1, stack `b,c`"),
        (text.clone() + lines[6] + "\n", "line 8: a row beyond the last sweep point"),
        (text.replace(",7,", ",8,"), "line 2: expected the seed 7, found 8"),
        (text.replace("s,1,a,", "s,1,a,,"), "line 6: expected 60 fields, found 61"),
        (text.replacen("robot.radius_m", "robot.mass_kg", 1), "line 1: expected the swept keys"),
    ] {
        std::fs::write(&path, edited).unwrap();
        let error = open(directory.path(), 2, 2).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn rows_without_a_manifest_are_not_touched() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join(EPISODES_CSV);
    std::fs::write(&path, "my,own,table\n").unwrap();
    let error = open(directory.path(), 1, 1).unwrap_err();
    assert!(matches!(error, ResultsError::Foreign { .. }), "{error}");
    assert_eq!(std::fs::read(&path).unwrap(), b"my,own,table\n");
}

#[test]
#[expect(clippy::print_stdout, reason = "a skipped test says so")]
fn a_bad_path_fails_at_once_and_is_named() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("file");
    std::fs::write(&file, "").unwrap();
    let error = open(&file.join("run"), 1, 1).unwrap_err().to_string();
    assert!(error.contains("cannot create") && error.contains("run`"), "{error}");

    let read_only = directory.path().join("read_only");
    std::fs::create_dir(&read_only).unwrap();
    let mut permissions = std::fs::metadata(&read_only).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&read_only, permissions).unwrap();
    if File::create(read_only.join("probe")).is_ok() {
        println!("skipped: this user may write to read-only folders");
        return;
    }
    let error = open(&read_only, 1, 1).unwrap_err().to_string();
    assert!(error.contains("cannot write") && error.contains("read_only"), "{error}");
}

#[test]
#[expect(clippy::print_stdout, reason = "a skipped test says so")]
fn a_full_disk_fails_the_run_and_leaves_whole_blocks() {
    // Linux has a file that is always full.
    let full = Path::new("/dev/full");
    if !full.exists() {
        println!("skipped: no /dev/full here");
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let folder = open(directory.path(), 1, 4).unwrap();
    run(&folder, 2);
    let [third, fourth] = [folder.take().unwrap(), folder.take().unwrap()];
    let whole = std::fs::read(directory.path().join(EPISODES_CSV)).unwrap();
    {
        let mut state = folder.state();
        let tables = state.tables.as_mut().unwrap();
        (tables.timings, tables.episodes) = (full_disk(full), full_disk(full));
    }
    let answer = rows(&third);
    let error = folder.submit(third, &answer).unwrap_err();
    assert!(matches!(error, ResultsError::Io { action: "write", .. }), "{error}");
    let answer = rows(&fourth);
    assert!(matches!(folder.submit(fourth, &answer), Err(ResultsError::Failed(_))));
    assert!(folder.take().is_none());
    assert!(matches!(folder.finish(), Err(ResultsError::Failed(_))));
    assert_eq!(std::fs::read(directory.path().join(EPISODES_CSV)).unwrap(), whole);
    let folder = open(directory.path(), 1, 4).unwrap();
    assert_eq!(run(&folder, u64::MAX), 2);
    folder.finish().unwrap().unwrap();
    assert_eq!(content(directory.path()), undisturbed(1, 4));
}

fn full_disk(path: &Path) -> Appender<File> {
    Appender::unchecked(File::options().append(true).open(path).unwrap())
}

#[test]
fn a_block_that_is_given_up_ends_the_run_for_the_workers_that_wait() {
    let directory = tempfile::tempdir().unwrap();
    let folder =
        Journal::open_with_window(directory.path(), identity("k: 1"), order(1, 4), Existing::Continue, 1).unwrap();
    std::thread::scope(|scope| {
        let first = folder.take().unwrap();
        let waiting = scope.spawn(|| folder.take().is_none());
        drop(first);
        assert!(waiting.join().unwrap());
    });
    let error = folder.finish().unwrap_err().to_string();
    assert!(error.contains("point 0, episode 0 was given up"), "{error}");
}

#[test]
#[should_panic(expected = "a row of another block")]
fn rows_in_another_order_are_a_bug() {
    let directory = tempfile::tempdir().unwrap();
    let folder = open(directory.path(), 1, 1).unwrap();
    let block = folder.take().unwrap();
    let mut rows = rows(&block);
    rows.reverse();
    let _ = folder.submit(block, &rows);
}

#[test]
fn a_swept_key_named_like_a_column_is_refused() {
    for keys in [vec!["seed"], vec!["robot.radius_m", "robot.radius_m"]] {
        let keys: Vec<String> = keys.into_iter().map(str::to_owned).collect();
        let point = vec![StackAt { name: "a".to_owned(), values: keys.clone() }];
        assert!(matches!(Order::new(keys, vec![point], 1), Err(ResultsError::SweptKey(_))));
    }
}

#[test]
fn the_manifest_remembers_every_start_and_timings_have_a_row_per_row() {
    let directory = tempfile::tempdir().unwrap();
    run(&open(directory.path(), 2, 3).unwrap(), 1);
    let timings = directory.path().join(TIMINGS_CSV);
    let mut torn = std::fs::read(&timings).unwrap();
    torn.extend(b"0,a,1,0.0");
    std::fs::write(&timings, torn).unwrap();
    let folder = open(directory.path(), 2, 3).unwrap();
    run(&folder, u64::MAX);
    folder.finish().unwrap();
    let manifest: Manifest =
        serde_json::from_slice(&std::fs::read(directory.path().join(MANIFEST_JSON)).unwrap()).unwrap();
    assert_eq!((manifest.identity, manifest.episodes, manifest.launches.len()), (identity("k: 1"), 3, 2));
    // 2 · 3 rows of the first point, 3 of the second.
    let keys: Vec<String> = csv::Reader::from_path(&timings)
        .unwrap()
        .records()
        .map(|record| record.unwrap().iter().take(3).collect::<Vec<_>>().join(" "))
        .collect();
    assert_eq!(keys, ["0 a 0", "0 b,c 0", "0 a 1", "0 b,c 1", "0 a 2", "0 b,c 2", "1 a 0", "1 a 1", "1 a 2"]);
}

#[test]
fn a_drive_that_was_given_up_is_driven_again_wherever_it_stands_and_whenever_a_kill_comes() {
    for points in [1, 3] {
        let whole = undisturbed(points, 3);
        for killed in 0..=5 {
            let directory = tempfile::tempdir().unwrap();
            let folder = open(directory.path(), points, 3).unwrap();
            let mut ran = 0;
            while let Some(block) = folder.take() {
                let mut rows = rows(&block);
                if block.index() % 3 == 1 {
                    let row = &mut rows[0].row;
                    (row.outcome, row.metrics) = (Outcome::GaveUp { message: "1 s".to_owned() }, Metrics::default());
                    rows[0].states.clear();
                }
                folder.submit(block, &rows).unwrap();
                ran += 1;
            }
            folder.finish().unwrap().unwrap();
            let given_up = points as u64;
            assert_eq!(ran, 3 * given_up);
            let folder = open(directory.path(), points, 3).unwrap();
            assert_eq!(folder.opened(), Opened::Resume { blocks_done: ran - given_up });
            let first = run(&folder, killed);
            drop(folder);
            let folder = open(directory.path(), points, 3).unwrap();
            assert_eq!(first + run(&folder, u64::MAX), given_up, "nothing else runs twice");
            folder.finish().unwrap().unwrap();
            assert_eq!(content(directory.path()), whole, "{points} points, killed after {killed}");
        }
    }
}
