//! Nothing mixes: rows, traces and folders belong to one run, and whoever goes on with another one is told what differs.

use super::support::{root, simrun};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

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
