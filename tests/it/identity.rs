//! Nothing mixes: rows, traces and folders belong to one run, and whoever goes on with another one is told what differs.

use super::reproduce::write_tiny_paper;
use super::support::{Simrun, root, simrun};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

#[path = "../../build/build_id.rs"]
pub(super) mod build_id;

use build_id::{Tools, build_id, engine_sources, features_asked, linked};

/// Writes files below a folder, by name.
fn write(folder: &Path, files: &[(&str, &str)]) {
    for (name, text) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
}

fn tools() -> Tools {
    Tools { compiler: "rustc 1.95.0".to_owned(), architecture: "x86_64".to_owned(), features: BTreeSet::new() }
}

const MANIFEST: &str = r#"
[package]
name = "simrun"
version = "0.2.0"
# [dependencies] in a comment is none.

[dependencies]
# The physics world.
rapier2d = { version = "=0.36.1", features = ["enhanced-determinism"] } # pinned
csv = "1.4"
image = { version = "0.25", default-features = false, features = [
    "png",
    "bmp",
] }

[dev-dependencies]
boon = "0.6"

[target.'cfg(unix)'.dependencies]
libc = "0.2"
"#;

/// The same as cargo writes it into a package.
const PACKAGED: &str = r#"
[package]
name = "simrun"
version = "0.2.0"

[dependencies.csv]
version = "1.4"

[dependencies.image]
version = "0.25"
features = [
    "bmp",
    "png",
]
default-features = false

[dependencies.rapier2d]
version = "=0.36.1"
features = ["enhanced-determinism"]

[dev-dependencies.boon]
version = "0.6"

[target."cfg(unix)".dependencies.libc]
version = "0.2"
"#;

const LOCK: &str = r#"
version = 4

[[package]]
name = "simrun"
version = "0.2.0"
dependencies = [
 "boon",
 "csv",
 "libc",
 "rapier2d 0.36.1",
]

[[package]]
name = "benches"
version = "0.1.0"
dependencies = [
 "pathfinding",
 "simrun",
]

[[package]]
name = "boon"
version = "0.6.0"
checksum = "b0"
dependencies = [
 "regex",
]

[[package]]
name = "regex"
version = "1.0.0"

[[package]]
name = "csv"
version = "1.4.0"
checksum = "c0"

[[package]]
name = "libc"
version = "0.2.1"

[[package]]
name = "pathfinding"
version = "4.0.0"

[[package]]
name = "parry2d"
version = "0.31.0"
checksum = "a1"

[[package]]
name = "rapier2d"
version = "0.9.0"

[[package]]
name = "rapier2d"
version = "0.36.1"
checksum = "d0"
dependencies = [
 "parry2d",
]
"#;

#[test]
fn the_build_id_is_of_what_decides_bytes_and_of_nothing_else() {
    let package = tempfile::tempdir().unwrap();
    let sources = [
        ("Cargo.toml", MANIFEST),
        ("Cargo.lock", LOCK),
        ("src/lib.rs", "pub mod plan;"),
        ("src/math.rs", "fn f() {}\n"),
        ("src/plan/grid.rs", "fn g() {}\n"),
        ("src/cli/run.rs", "fn h() {}\n"),
    ];
    write(package.path(), &sources);
    let id = || build_id(package.path(), &tools()).unwrap();
    let first = id();
    assert_eq!(first, id());

    let with = |name: &str, text: &str| {
        write(package.path(), &[(name, text)]);
        let found = id();
        match sources.iter().find(|(known, _)| *known == name) {
            Some((_, before)) => write(package.path(), &[(name, before)]),
            None => fs::remove_file(package.path().join(name)).unwrap(),
        }
        assert_eq!(id(), first, "{name} is as it was");
        found
    };
    for (name, text) in [
        ("src/plan/grid.rs", "fn g() { }\n"),
        ("src/plan/new.rs", ""),
        ("src/cli.rs", ""),
        ("src/plan/cli/run.rs", ""),
        ("Cargo.lock", &LOCK.replace("0.31.0", "0.31.1")),
        ("Cargo.lock", &LOCK.replace("a1", "a2")),
        ("Cargo.lock", ""),
        ("Cargo.toml", &MANIFEST.replace("\"enhanced-determinism\"", "")),
        ("Cargo.toml", &MANIFEST.replace("default-features = false, ", "")),
    ] {
        assert_ne!(with(name, text), first, "{name}: {text}");
    }
    for (name, text) in [
        ("src/math.rs", "fn f() {}\r\n"),
        ("src/cli/run.rs", "fn other() {}\n"),
        ("src/report/picture.rs", "fn draw() {}\n"),
        ("src/lib.rs", "pub mod plan; pub mod report;"),
        ("src/.grid.rs.swp", "an editor's"),
        ("README.md", "new"),
        ("tests/it/main.rs", "new"),
        ("Cargo.lock", &LOCK.replace("0.6.0", "0.7.0")),
        ("Cargo.lock", &LOCK.replace("4.0.0", "5.0.0")),
        ("Cargo.toml", &MANIFEST.replace("0.6", "0.7")),
        ("Cargo.toml", &format!("{MANIFEST}[profile.release]\nopt-level = 1\ndebug = true\n")),
        ("Cargo.toml", PACKAGED),
    ] {
        assert_eq!(with(name, text), first, "{name}: {text}");
    }
    for tools in [
        Tools { compiler: "rustc 1.96.0".to_owned(), ..tools() },
        Tools { architecture: "x86".to_owned(), ..tools() },
        Tools { features: BTreeSet::from(["FAST".to_owned()]), ..tools() },
    ] {
        assert_ne!(build_id(package.path(), &tools).unwrap(), first, "{tools:?}");
    }
}

#[test]
fn a_manifest_says_the_same_as_people_and_as_cargo_write_it() {
    let expected = [
        ("csv", "default"),
        ("image", "\"bmp\",\"png\""),
        ("libc", "default"),
        ("rapier2d", "\"enhanced-determinism\",default"),
    ];
    let expected = expected.map(|(name, features)| (name.to_owned(), features.to_owned())).into();
    assert_eq!(features_asked(MANIFEST), expected);
    assert_eq!(features_asked(PACKAGED), expected);
}

#[test]
fn only_linked_packages_are_locked_ones() {
    let expected = ["csv 1.4.0 c0", "libc 0.2.1 ", "parry2d 0.31.0 a1", "rapier2d 0.36.1 d0"].map(str::to_owned);
    assert_eq!(linked(MANIFEST, LOCK), expected.into());
    // Of this very package.
    let text = |name: &str| fs::read_to_string(root().join(name)).unwrap();
    let found = linked(&text("Cargo.toml"), &text("Cargo.lock"));
    let is_there = |name: &str| found.iter().any(|package| package.starts_with(&format!("{name} ")));
    assert!(["rapier2d", "parry2d", "libm", "rand_chacha", "csv"].into_iter().all(is_there), "{found:?}");
    assert!(!["simrun", "boon", "pathfinding", "tempfile"].into_iter().any(is_there), "{found:?}");
    let sources = engine_sources(&root().join("src")).unwrap();
    assert!(sources.contains_key("plan/global/a_star.rs") && sources.contains_key("experiment/drive.rs"));
    assert!(!sources.keys().any(|name| build_id::SHELL.contains(&name.split('/').next().unwrap())));
}

/// Whatever it was optimised for: the id is of the sources alone.
#[test]
fn the_command_has_the_build_id_of_these_sources() {
    let scratch = tempfile::tempdir().unwrap();
    simrun(scratch.path())
        .arg(root().join("scenarios/01_empty.yaml"))
        .args(["--episodes", "1", "--quiet"])
        .ends_with(0);
    let manifest = fs::read_to_string(scratch.path().join("results/01_empty/manifest.json")).unwrap();
    let said = format!("\"build\": \"{}\"", env!("SIMRUN_BUILD"));
    assert!(manifest.contains(&said), "{manifest}");
    let Ok(version) = Command::new("rustc").arg("--version").output() else { return };
    let compiler = String::from_utf8(version.stdout).unwrap();
    let id = build_id(root(), &Tools { compiler, architecture: std::env::consts::ARCH.to_owned(), ..tools() }).unwrap();
    assert_eq!(format!("{id:016x}"), env!("SIMRUN_BUILD"));
}

const STACKS: &str = "stacks: {global: [a_star], local: [pure_pursuit]}\n";
const HALL: &str = "type octile\nheight 10\nwidth 20\nmap\n";

fn hall(wall: char) -> String {
    let rows = (0..10).map(|row| {
        if row == 4 { format!("{}{wall}{}\n", ".".repeat(9), ".".repeat(10)) } else { ".".repeat(20) + "\n" }
    });
    HALL.to_owned() + &rows.collect::<String>()
}

#[test]
fn a_changed_file_is_another_run_and_is_named() {
    let header =
        "image: hall.pgm\nresolution: 0.5\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.25\n";
    let image = |wall: u8| format!("P2 20 10 255\n{}", format!("{}{wall}\n", "254 ".repeat(19)).repeat(10));
    let walk = |x: f64| format!("time_s,id,x_m,y_m\n0,1,{x},2\n9,1,{x},8\n");
    let open = "map: {empty: {cols: 20, rows: 10}}\n";
    for (scenario, files, changed) in [
        ("map: {movingai: {file: maps/hall.map}}\n", vec![("maps/hall.map", hall('.'))], ("maps/hall.map", hall('@'))),
        (
            "map: {ros: {file: maps/hall.yaml}}\n",
            vec![("maps/hall.yaml", header.to_owned()), ("maps/hall.pgm", image(254))],
            ("maps/hall.pgm", image(0)),
        ),
        (
            "map: {ros: {file: maps/hall.yaml}}\n",
            vec![("maps/hall.yaml", header.to_owned()), ("maps/hall.pgm", image(254))],
            ("maps/hall.yaml", header.replace("0.5", "0.6")),
        ),
        (
            &format!("{open}obstacles: {{moving: [replay: {{file: walk.csv, gap_max_s: 9}}]}}\n"),
            vec![("walk.csv", walk(12.0))],
            ("walk.csv", walk(13.0)),
        ),
        (
            &format!("{open}sweep: {{obstacles.moving: [[], [replay: {{file: walk.csv}}]]}}\n"),
            vec![("walk.csv", walk(12.0))],
            ("walk.csv", walk(13.0)),
        ),
    ] {
        let scratch = tempfile::tempdir().unwrap();
        write(scratch.path(), &[("s.yaml", &format!("{scenario}{STACKS}"))]);
        for (name, text) in &files {
            write(scratch.path(), &[(name, text)]);
        }
        let run = |episodes: &str| {
            let mut command = simrun(scratch.path());
            command.args(["run", "s.yaml", "--quiet", "--out", "out", "--episodes", episodes]);
            command
        };
        let table = || fs::read(scratch.path().join("out/episodes.csv")).unwrap();
        run("2").ends_with(0);
        // Written anew with what it held already, it is the same file.
        let (name, before) = files.iter().find(|(name, _)| *name == changed.0).unwrap();
        write(scratch.path(), &[(name, before)]);
        run("3").ends_with(0);
        let whole = table();
        write(scratch.path(), &[(name, &changed.1)]);
        for episodes in ["3", "5"] {
            let said = run(episodes).ends_with(1).stderr;
            assert!(
                said.contains(&format!("another run: the file `{name}` has been changed. Write elsewhere")),
                "{said}"
            );
        }
        assert_eq!(table(), whole, "{name}");
        write(scratch.path(), &[(name, before)]);
        run("5").ends_with(0);
        assert!(table().starts_with(&whole) || scenario.contains("sweep"), "{name}");
    }
}

/// A scratch folder with a scenario of 4 episodes that are quick to drive.
fn quick() -> tempfile::TempDir {
    let scratch = tempfile::tempdir().unwrap();
    let map = "map: {empty: {cols: 20, rows: 10, resolution_m: 0.5}}\n";
    write(scratch.path(), &[("s.yaml", &format!("{map}episodes: 4\n{STACKS}"))]);
    scratch
}

/// `simrun run s.yaml --quiet --out out`, with more arguments.
fn run(scratch: &Path, more: &[&str]) -> Simrun {
    let mut command = simrun(scratch);
    command.args(["run", "s.yaml", "--quiet", "--out", "out"]).args(more);
    command
}

fn text(path: impl AsRef<Path>) -> String {
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.as_ref().display()))
}

/// Every file of a folder and of those in it with its content, but the lock.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(contents(&path));
        } else if !path.ends_with(".lock") {
            found.insert(path.clone(), fs::read(path).unwrap());
        }
    }
    found
}

/// A table with another value in a column of its first row.
fn altered(table: &str, column: &str) -> String {
    let mut lines: Vec<Vec<&str>> = table.split('\n').map(|line| line.split(',').collect()).collect();
    let index = lines[0].iter().position(|name| *name == column).unwrap();
    lines[1][index] = "3";
    lines.iter().map(|line| line.join(",")).collect::<Vec<_>>().join("\n")
}

#[test]
fn an_altered_table_is_told_by_analyze_and_verify_and_refused_by_run() {
    for (table, column) in [("episodes.csv", "length_m"), ("states.csv", "entries")] {
        let scratch = quick();
        run(scratch.path(), &[]).ends_with(0);
        let out = scratch.path().join("out");
        let said = simrun(scratch.path()).args(["verify", "out"]).ends_with(0).stdout;
        assert_eq!(said, "out: episodes.csv, states.csv, summary.csv are as the finished run left them\n");
        assert_eq!(simrun(scratch.path()).args(["analyze", "out"]).ends_with(0).stderr, "");
        // Git and editors turn line ends; that is no alteration.
        let whole = text(out.join(table));
        fs::write(out.join(table), whole.replace('\n', "\r\n")).unwrap();
        simrun(scratch.path()).args(["verify", "out"]).ends_with(0);
        fs::write(out.join(table), &whole).unwrap();

        fs::write(out.join(table), altered(&whole, column)).unwrap();
        let before = contents(&out);
        let said = simrun(scratch.path()).args(["verify", "out"]).ends_with(3).stderr;
        assert!(said.contains(&format!("altered since the run was finished: {table}")), "{said}");
        let said = simrun(scratch.path()).args(["analyze", "out"]).ends_with(0).stderr;
        assert_eq!(said.contains("warning: `out/episodes.csv` has been altered"), table == "episodes.csv", "{said}");
        for more in [&[][..], &["--episodes", "6"], &["--trace"]] {
            let said = run(scratch.path(), more).ends_with(1).stderr;
            assert!(said.contains(&format!("`out/{table}` has been altered since its run was finished")), "{said}");
        }
        assert_eq!(contents(&out), before);
        run(scratch.path(), &["--force"]).ends_with(0);
        assert_eq!(text(out.join(table)), whole);
    }
}

#[test]
fn a_table_that_lost_its_end_is_completed_if_the_rest_is_as_it_was() {
    let scratch = quick();
    run(scratch.path(), &[]).ends_with(0);
    let table = scratch.path().join("out/episodes.csv");
    let whole = text(&table);
    fs::write(&table, &whole[..whole.len() - 40]).unwrap();
    run(scratch.path(), &[]).ends_with(0);
    assert_eq!(text(&table), whole);
    // The end is gone and the beginning altered: the rows are made, and the hash tells.
    fs::write(&table, altered(&whole[..whole.len() - 40], "length_m")).unwrap();
    let said = run(scratch.path(), &[]).ends_with(1).stderr;
    assert!(said.contains("has been altered since its run was finished"), "{said}");
    run(scratch.path(), &[]).ends_with(1);
    simrun(scratch.path()).args(["verify", "out"]).ends_with(3);
    let said = simrun(scratch.path()).args(["verify", "s.yaml"]).ends_with(0).stdout;
    assert!(said.contains("identical"), "{said}");
}

#[test]
fn traces_belong_to_the_run_of_their_folder() {
    let scratch = quick();
    let traces = scratch.path().join("out/traces");
    let names = || {
        let mut names: Vec<String> =
            fs::read_dir(&traces).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    let expected = |count: usize| (0..count).map(|n| format!("e{n:06}_a_star+pure_pursuit.csv")).collect::<Vec<_>>();
    // Asked for at once, or of a finished folder, or of one that is extended: the same traces.
    run(scratch.path(), &["--trace"]).ends_with(0);
    assert_eq!(names(), expected(4));
    let first = contents(&traces);
    run(scratch.path(), &["--force"]).ends_with(0);
    assert_eq!(names(), [""; 0]);
    run(scratch.path(), &["--trace", "--episodes", "4"]).ends_with(0);
    assert_eq!(contents(&traces), first);
    fs::remove_dir_all(&traces).unwrap();
    run(scratch.path(), &["--trace"]).ends_with(0);
    assert_eq!(contents(&traces), first);
    fs::remove_file(traces.join(&expected(4)[2])).unwrap();
    run(scratch.path(), &["--trace", "--episodes", "6"]).ends_with(0);
    assert_eq!(names(), expected(6));
    assert!(first.iter().all(|(trace, bytes)| fs::read(trace).unwrap() == *bytes));

    // What is there is not driven again; what belongs to another drive is.
    let third = traces.join(&expected(4)[2]);
    let marked = text(&third) + "mine\n";
    fs::write(&third, &marked).unwrap();
    run(scratch.path(), &["--trace", "--episodes", "6"]).ends_with(0);
    assert_eq!(text(&third), marked);
    fs::write(&third, marked.replace("# episode: 2", "# episode: 3")).unwrap();
    run(scratch.path(), &["--trace", "--episodes", "6"]).ends_with(0);
    assert!(!text(&third).contains("mine"));

    // Another run leaves none of the old behind, and nothing of others is touched.
    write(&traces, &[("notes.csv", "mine")]);
    let other = ["--force", "--trace", "--episodes", "2", "--set", "stacks.local=[dwa]"];
    run(scratch.path(), &other).ends_with(0);
    assert_eq!(names(), ["e000000_a_star+dwa.csv", "e000001_a_star+dwa.csv", "notes.csv"]);
    // Nor does a single episode of another run get in.
    let said = run(scratch.path(), &["--trace", "--episode", "0"]).ends_with(1).stderr;
    assert!(said.contains("holds results of another run") && said.contains("stacks.local"), "{said}");
    // Rows taken away: traces of another run go when a new one begins.
    fs::remove_file(scratch.path().join("out/episodes.csv")).unwrap();
    run(scratch.path(), &[]).ends_with(0);
    assert_eq!(names(), ["notes.csv"]);
}

#[test]
fn a_drive_that_is_not_that_of_its_row_gets_no_trace() {
    let scratch = quick();
    run(scratch.path(), &[]).ends_with(0);
    // As an older version left it: without hashes.
    let out = scratch.path().join("out");
    let manifest = text(out.join("manifest.json"));
    let before_hashes = manifest.split(",\n  \"tables\"").next().unwrap().to_owned() + "\n}\n";
    fs::write(out.join("manifest.json"), before_hashes).unwrap();
    let table = altered(&text(out.join("episodes.csv")), "trace_digest").replacen(",3\n", &format!(",{:016x}\n", 3), 1);
    fs::write(out.join("episodes.csv"), table).unwrap();
    let said = run(scratch.path(), &["--trace", "--threads", "1"]).ends_with(1).stderr;
    assert!(said.contains("point 0, episode 0, a_star+pure_pursuit: driven again, it has the trace digest"), "{said}");
    assert!(said.contains("its row 0000000000000003"), "{said}");
    assert_eq!(fs::read_dir(out.join("traces")).unwrap().count(), 0);
}

#[test]
fn a_trace_can_be_driven_again_from_itself() {
    let scratch = quick();
    let more = ["--trace", "--set", "limits.speed_max_mps=0.8", "--seed", "9"];
    run(scratch.path(), &more).ends_with(0);
    let trace = scratch.path().join("out/traces/e000002_a_star+pure_pursuit.csv");
    let header: Vec<String> =
        text(&trace).lines().map_while(|line| line.strip_prefix("# ").map(str::to_owned)).collect();
    let rows = text(scratch.path().join("out/episodes.csv"));
    let digest = |line: &str| {
        let column = rows.lines().next().unwrap().split(',').position(|name| name == "trace_digest").unwrap();
        line.split(',').nth(column).unwrap().to_owned()
    };
    let command =
        "simrun run s.yaml --episode 2 --stack a_star+pure_pursuit --set limits.speed_max_mps=0.8 --set seed=9";
    assert_eq!(
        header[..8],
        [
            &format!("command: {command}"),
            "scenario: s.yaml",
            "edits: [\"limits.speed_max_mps=0.8\",\"seed=9\"]",
            "seed: 9",
            "point: 0",
            "episode: 2",
            "stack: a_star+pure_pursuit",
            &format!("build: {}", env!("SIMRUN_BUILD")),
        ]
    );
    assert_eq!(header[9], format!("trace_digest: {}", digest(rows.lines().nth(3).unwrap())));
    // Its command prints its row.
    let printed = simrun(scratch.path()).args(command.split(' ').skip(1)).ends_with(0).stdout;
    assert_eq!(printed.lines().nth(1), rows.lines().nth(3));

    // It is drawn as it was driven, from its own folder as well.
    let picture = |folder: &Path, arguments: &[&str]| {
        simrun(folder).arg("draw").args(arguments).args(["-o", "-"]).ends_with(0).stdout
    };
    let of_scenario =
        picture(scratch.path(), &["s.yaml", "--episode", "2", "--set", "limits.speed_max_mps=0.8", "--seed", "9"]);
    assert_eq!(picture(scratch.path(), &["out/traces/e000002_a_star+pure_pursuit.csv"]), of_scenario);
    assert_eq!(picture(trace.parent().unwrap(), &["e000002_a_star+pure_pursuit.csv"]), of_scenario);
    let draw = |file: &str| {
        let mut command = simrun(scratch.path());
        command.args(["draw", file]);
        command
    };
    let said = draw("out/episodes.csv").ends_with(2).stderr;
    assert!(said.contains("does not begin with the lines `# scenario: …`"), "{said}");
    let said = draw("out/traces/e000002_a_star+pure_pursuit.csv").args(["--seed", "8"]).ends_with(2).stderr;
    assert!(said.contains("nothing of it can be changed"), "{said}");
    let scenario = text(scratch.path().join("s.yaml")).replace("cols: 20", "cols: 21");
    fs::write(scratch.path().join("s.yaml"), scenario).unwrap();
    let said = draw("out/traces/e000002_a_star+pure_pursuit.csv").ends_with(1).stderr;
    assert!(said.contains("comes out otherwise: the scenario `s.yaml` has been changed"), "{said}");
    assert!(!scratch.path().join("episode.svg").exists());
}

/// A run that lasts for hours, in a process of its own, which ends with the test.
struct LongRun(Child);

impl LongRun {
    fn start(scratch: &Path) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_simrun"));
        command.current_dir(scratch).args(["run", "s.yaml", "--quiet", "--out", "out", "--threads", "1"]);
        Self(command.args(["--episodes", "1000000"]).stderr(Stdio::piped()).spawn().unwrap())
    }

    /// Exit code and messages, once it has ended by itself.
    fn end(&mut self) -> (Option<i32>, String) {
        let mut said = String::new();
        self.0.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        (self.0.wait().unwrap().code(), said)
    }
}

impl Drop for LongRun {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Waits until something holds, which must come soon.
fn until(what: &str, holds: impl Fn() -> bool) {
    for _ in 0..6000 {
        if holds() {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("still waiting: {what}");
}

fn has_rows(table: &Path) -> bool {
    fs::read(table).is_ok_and(|bytes| bytes.iter().filter(|&&byte| byte == b'\n').count() > 2)
}

#[cfg(unix)]
#[test]
fn a_folder_that_goes_under_way_ends_the_run_at_once() {
    for what in ["removed", "moved", "table", "replaced"] {
        let scratch = quick();
        let out = scratch.path().join("out");
        let mut run = LongRun::start(scratch.path());
        until("rows", || has_rows(&out.join("episodes.csv")));
        match what {
            // A block may be put there while the folder is being emptied.
            "removed" => until("removal", || fs::remove_dir_all(&out).is_ok() || !out.exists()),
            "moved" => fs::rename(&out, scratch.path().join("elsewhere")).unwrap(),
            "table" => fs::remove_file(out.join("episodes.csv")).unwrap(),
            _ => {
                fs::copy(out.join("episodes.csv"), out.join("copy")).unwrap();
                fs::rename(out.join("copy"), out.join("episodes.csv")).unwrap();
            }
        }
        let before = scratch.path().join("out").exists().then(|| contents(&out).len());
        let (code, said) = run.end();
        assert_eq!(code, Some(1), "{what}: {said}");
        assert!(said.contains("removed, moved or replaced while the run was writing it"), "{what}: {said}");
        assert_eq!(scratch.path().join("out").exists().then(|| contents(&out).len()), before, "{what}");
    }
}

/// The command as somebody who may not write everywhere, as the superuser may.
#[cfg(unix)]
fn as_a_user(scratch: &Path, arguments: &[&str]) -> (i32, String, String) {
    use std::os::unix::fs::MetadataExt as _;
    use std::os::unix::process::CommandExt as _;
    let mut command = Command::new(env!("CARGO_BIN_EXE_simrun"));
    command.current_dir(scratch).args(arguments).env("NO_COLOR", "1");
    if fs::metadata("/proc/self").is_ok_and(|process| process.uid() == 0) {
        command.uid(65534).gid(65534);
    }
    let output = command.output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// Takes away the right to write in a folder and everything in it, or gives it back.
#[cfg(unix)]
fn set_read_only(folder: &Path, is_read_only: bool) {
    use std::os::unix::fs::PermissionsExt as _;
    let set = |path: &Path, mode: u32| fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            set_read_only(&path, is_read_only);
        } else {
            set(&path, if is_read_only { 0o444 } else { 0o644 });
        }
    }
    set(folder, if is_read_only { 0o555 } else { 0o755 });
}

#[cfg(unix)]
#[test]
fn a_finished_folder_that_may_only_be_read_is_shown() {
    let scratch = quick();
    let out = scratch.path().join("out");
    let table = simrun(scratch.path()).args(["run", "s.yaml", "--out", "out"]).ends_with(0).stdout;
    write_tiny_paper(scratch.path());
    let reproduce = ["reproduce", "tiny", "--papers", ".", "--episodes", "2", "--out", "paper"];
    let judged = simrun(scratch.path()).args(reproduce).ends_with(0).stdout;
    for has_lock in [true, false] {
        set_read_only(scratch.path(), true);
        let before = contents(scratch.path());
        assert_eq!(as_a_user(scratch.path(), &["run", "s.yaml", "--out", "out"]).1, table);
        let (code, shown, said) = as_a_user(scratch.path(), &["run", "s.yaml", "--out", "out"]);
        assert_eq!((code, shown.as_str()), (0, table.as_str()), "{said}");
        assert!(said.contains("complete, nothing to run") && !said.contains("rror"), "{said}");
        assert_eq!(as_a_user(scratch.path(), &["analyze", "out"]).0, 0);
        assert_eq!(as_a_user(scratch.path(), &["verify", "out"]).0, 0);
        let (code, shown, said) = as_a_user(scratch.path(), &reproduce);
        assert_eq!((code, shown.as_str()), (0, judged.as_str()), "{said}");
        // More of it cannot be written.
        let (code, _, said) = as_a_user(scratch.path(), &["run", "s.yaml", "--out", "out", "--episodes", "5"]);
        assert!(code == 1 && said.contains("cannot write `out/.lock`"), "{said}");
        assert_eq!(contents(scratch.path()), before);
        set_read_only(scratch.path(), false);
        if has_lock {
            fs::remove_file(out.join(".lock")).unwrap();
        }
    }
}

#[test]
fn a_folder_in_use_is_told_with_its_holder_and_waited_for() {
    let scratch = quick();
    let out = scratch.path().join("out");
    // A lock file that nobody holds is no lock, whatever it says.
    write(&out, &[(".lock", "process 1 on elsewhere\n")]);
    run(scratch.path(), &[]).ends_with(0);
    let mut long = LongRun::start(scratch.path());
    let id = long.0.id();
    until("lock", || text(out.join(".lock")).starts_with(&format!("process {id} on ")));
    let said = run(scratch.path(), &["--episodes", "1000000"]).ends_with(75).stderr;
    assert!(said.contains(&format!("`out` is in use by process {} on ", id)), "{said}");
    assert!(said.contains("--wait-lock"), "{said}");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&out, scratch.path().join("link")).unwrap();
        let mut linked = simrun(scratch.path());
        linked.args(["run", "s.yaml", "--quiet", "--episodes", "1000000", "--out", "link"]).ends_with(75);
    }
    let said = run(scratch.path(), &["--episodes", "1000000", "--wait-lock", "1"]).ends_with(75).stderr;
    assert!(said.contains("waiting for it"), "{said}");
    // When it ends, however it ends, the next one has the folder.
    let waiting = std::thread::scope(|scope| {
        let waiting = scope.spawn(|| run(scratch.path(), &["--force", "--wait-lock", "60"]).ends_with(0).stderr);
        std::thread::sleep(Duration::from_millis(300));
        long.0.kill().unwrap();
        long.0.wait().unwrap();
        waiting.join().unwrap()
    });
    assert!(waiting.contains(&format!("in use by process {}", id)), "{waiting}");
}

#[test]
fn names_that_are_one_folder_where_capitals_do_not_count_are_refused() {
    let scratch = quick();
    let scenario = text(scratch.path().join("s.yaml"));
    write(
        scratch.path(),
        &[("a.yaml", &format!("name: Hall\n{scenario}")), ("b.yaml", &format!("name: hall\n{scenario}"))],
    );
    let said = simrun(scratch.path()).args(["run", "a.yaml", "b.yaml"]).ends_with(2).stderr;
    assert!(said.contains("`Hall` and `hall` are the same folder where capitals do not count"), "{said}");
    let said = simrun(scratch.path()).args(["run", "a.yaml", "a.yaml"]).ends_with(2).stderr;
    assert!(said.contains("two scenarios are called `Hall`"), "{said}");
    assert!(!scratch.path().join("results").exists());
}
