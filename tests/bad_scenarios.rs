//! Every fault a scenario can have, one file each, with the message that a user gets.
//!
//! `SIMRUN_BLESS=1 cargo test --test bad_scenarios` writes the messages anew. Read each of them: would
//! someone who has never seen simrun know what to do? Comment lines `# --set a.b=x` at the top of a
//! file are given as options.

use simrun::scenario::{Edit, load};
use std::path::{Path, PathBuf};

fn fixtures() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir("tests/bad_scenarios")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "yaml"))
        .collect();
    files.sort();
    files
}

/// The message for a scenario file, which must be refused.
fn message(file: &Path) -> String {
    let text = String::from_utf8_lossy(&std::fs::read(file).unwrap()).into_owned();
    let sets = text.lines().filter_map(|line| line.strip_prefix("# --set "));
    let refused = sets.map(Edit::parse).collect::<Result<Vec<_>, _>>().and_then(|edits| load(file, &edits));
    match refused {
        Ok(_) => "accepted\n".to_owned(),
        Err(error) => format!("{error}\n"),
    }
}

#[test]
fn every_bad_scenario_gets_the_message_written_beside_it() {
    let bless = std::env::var_os("SIMRUN_BLESS").is_some();
    let mut differing = Vec::new();
    let files = fixtures();
    assert!(files.len() > 30);
    for file in files {
        let message = message(&file);
        let expected_file = file.with_extension("stderr");
        if bless && message != "accepted\n" {
            std::fs::write(&expected_file, &message).unwrap();
        } else if std::fs::read_to_string(&expected_file).ok().as_ref() != Some(&message) {
            differing.push(format!("{}:\n{message}", file.display()));
        }
    }
    assert!(
        differing.is_empty(),
        "{} messages differ; read them, then bless with SIMRUN_BLESS=1\n{}",
        differing.len(),
        differing.join("\n")
    );
}

#[test]
fn no_expected_message_is_left_without_its_scenario() {
    for entry in std::fs::read_dir("tests/bad_scenarios").unwrap() {
        let path = entry.unwrap().path();
        assert!(path.extension().is_none_or(|e| e != "stderr") || path.with_extension("yaml").exists(), "{path:?}");
    }
}
