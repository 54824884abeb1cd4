//! Every fault a scenario can have, one file each, with the message that a user gets.
//!
//! `SIMRUN_BLESS=1 cargo test --release --test it bad_scenarios::` writes the messages anew. Read each of them: would
//! someone who has never seen simrun know what to do? Comment lines `# --set a.b=x` at the top of a
//! file are given as options.

use super::support::{files, is_blessing, root};
use simrun::scenario::{Edit, load};
use std::path::Path;

/// Their names are relative, as messages name the file as it was given; cargo runs tests in the folder of the package.
const FOLDER: &str = "tests/bad_scenarios";

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
    let mut differing = Vec::new();
    for file in files(Path::new(FOLDER), "yaml") {
        let message = message(&file);
        let expected_file = file.with_extension("stderr");
        if is_blessing() && message != "accepted\n" {
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
fn scenarios_and_expected_messages_come_in_pairs() {
    let stems = |ending| files(&root().join(FOLDER), ending).iter().map(|file| file.with_extension("")).collect();
    let [scenarios, messages]: [Vec<_>; 2] = ["yaml", "stderr"].map(stems);
    assert_eq!(scenarios, messages);
    assert!(scenarios.len() >= 77, "{} fixtures: where did the others go?", scenarios.len());
}
