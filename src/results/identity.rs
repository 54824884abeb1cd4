//! Identity of a run, and the manifest that records it.

use super::journal::{MANIFEST_BYTES_MAX, MANIFEST_JSON};
use crate::digest::Digest;
use crate::trace::Header;
use crate::{clock, files, scenario};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Largest number of differences named in one message; further ones are only counted.
const DIFFERENCES_MAX: usize = 5;

/// Build id of this simrun, 16 hexadecimal digits: see `build/build_id.rs`.
pub const BUILD: &str = env!("SIMRUN_BUILD");

/// Hash of a scenario's text without the number of its episodes, 16 hexadecimal digits: more of them drive no episode otherwise.
pub fn settings_hash(scenario: &str) -> String {
    let lines = scenario.lines().filter(|line| !line.starts_with("episodes:"));
    Digest::of(lines.flat_map(|line| [line, "\n"]).collect::<String>().as_bytes()).to_string()
}

/// Identity of a run: the rows of two runs with equal identities are the same bytes.
///
/// The number of episodes is no part of it, since more may be added: the key `episodes` at the top
/// of the resolved scenario is passed over.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// Version of simrun.
    pub version: String,
    /// Build id, 16 hexadecimal digits: a hash of what decides bytes, which are the engine's sources, the crates it is linked with, the
    /// compiler, the architecture and features of simrun, and neither optimisation nor the model of the processor.
    pub build: String,
    /// Seed of the scenario.
    pub seed: u64,
    /// Names of the stacks, in order.
    pub stacks: Vec<String>,
    /// FNV-1a hash of `scenario`, 16 hexadecimal digits.
    pub scenario_hash: String,
    /// The scenario with every default, as YAML text.
    pub scenario: String,
    /// FNV-1a hash of every file that the scenario names, by the name it has there: maps with their images, recordings. Manifests of 0.1
    /// have none.
    #[serde(default)]
    pub files: BTreeMap<String, String>,
}

impl Identity {
    /// The identity of a run of this very build; `files` has the hash of every file that the scenario names.
    pub fn new(scenario: &str, seed: u64, stacks: Vec<String>, files: BTreeMap<String, String>) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            build: BUILD.to_owned(),
            seed,
            stacks,
            scenario_hash: Digest::of(scenario.as_bytes()).to_string(),
            scenario: scenario.to_owned(),
            files,
        }
    }

    /// Whether a trace with this header is of this run.
    pub(super) fn has_trace(&self, header: &Header) -> bool {
        header.build == self.build && header.settings_hash == settings_hash(&self.scenario)
    }

    /// Differences of `other`, in words; empty if it is the same run.
    pub fn differences(&self, other: &Self) -> Vec<String> {
        let mut found = Vec::new();
        if self.scenario != other.scenario {
            match scenario::differences(&self.scenario, &other.scenario, &["episodes"]) {
                Some(differences) => found.extend(differences),
                None => found.push("the scenario".to_owned()),
            }
        }
        for (name, hash) in &self.files {
            // A file that only one of them names is a difference of the scenario, or of a file that names it.
            if other.files.get(name).is_some_and(|now| now != hash) {
                found.push(format!("the file `{name}` has been changed"));
            }
        }
        let is_seed_said = found.iter().any(|difference| difference.starts_with("`seed`"));
        let mut field = |what: &str, there: String, here: String| {
            if there != here {
                found.push(format!("{what}: {there} there, {here} here"));
            }
        };
        if !is_seed_said {
            field("the seed", self.seed.to_string(), other.seed.to_string());
        }
        field("the stacks", self.stacks.join(", "), other.stacks.join(", "));
        field("the version of simrun", self.version.clone(), other.version.clone());
        field("the build of simrun", self.build.clone(), other.build.clone());
        if found.len() > DIFFERENCES_MAX {
            let more = found.len() - DIFFERENCES_MAX;
            found.truncate(DIFFERENCES_MAX);
            found.push(format!("and {more} more"));
        }
        found
    }
}

/// One start of the program; outside the byte contract.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Launch {
    /// The command line.
    pub command: Vec<String>,
    /// Name of the machine; empty if unknown.
    pub host: String,
    /// Seconds since 1970-01-01 UTC.
    pub started_unix_s: u64,
    /// Folder in which it was started, where the command's paths begin; empty if unknown.
    #[serde(default)]
    pub folder: PathBuf,
}

impl Launch {
    /// This start of the program.
    pub fn current() -> Self {
        Self {
            command: std::env::args_os().map(|argument| argument.to_string_lossy().into_owned()).collect(),
            host: host(),
            started_unix_s: clock::unix_time_s(),
            folder: std::env::current_dir().unwrap_or_default(),
        }
    }
}

/// Name of this machine; empty if unknown.
pub(super) fn host() -> String {
    let host = files::text(Path::new("/proc/sys/kernel/hostname"), 1 << 10);
    host.or_else(|_| std::env::var("HOSTNAME")).unwrap_or_default().trim().to_owned()
}

/// Content of `manifest.json`: the run to which the folder belongs, and the starts of the program that wrote it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// The run.
    pub identity: Identity,
    /// Episodes per point that were requested last.
    pub episodes: u64,
    /// Every start that wrote here, oldest first.
    pub launches: Vec<Launch>,
    /// FNV-1a hash of each table, by its name, as the finished run left it; empty until then. It tells damage and edits, and is no
    /// defence against somebody who means to deceive.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tables: BTreeMap<String, String>,
}

impl Manifest {
    /// Reads the manifest of a folder of results.
    ///
    /// # Errors
    /// If it cannot be read, or is not of this version, in words.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let text = files::text(&folder.join(MANIFEST_JSON), MANIFEST_BYTES_MAX)
            .map_err(|error| format!("{MANIFEST_JSON} cannot be read: {error}"))?;
        serde_json::from_str(&text).map_err(|error| format!("{MANIFEST_JSON} is not of this version: {error}"))
    }

    /// Whether a table in `folder` is not as the finished run left it: altered, damaged or gone. Turned line ends are no alteration. False where
    /// the manifest has no hash of it.
    pub fn is_altered(&self, folder: &Path, table: &str) -> bool {
        let now = || files::digest_of_lines(&folder.join(table)).ok().map(|digest| digest.to_string());
        self.tables.get(table).is_some_and(|then| now().as_ref() != Some(then))
    }

    /// The folder of the scenario's file, in which the paths begin that it names, if one of the commands tells it: that of a YAML file which
    /// is still there, best of one that is called like the scenario.
    pub fn scenario_folder(&self, name: &str) -> Option<PathBuf> {
        let words = self.launches.iter().flat_map(|launch| launch.command.iter().map(|word| launch.folder.join(word)));
        let is_yaml = |file: &PathBuf| file.extension().is_some_and(|ending| ending == "yaml" || ending == "yml");
        let files: Vec<PathBuf> = words.filter(is_yaml).filter(|file| file.is_file()).collect();
        let named = files.iter().find(|file| file.file_stem().is_some_and(|stem| stem == name));
        named.or(files.first())?.parent().map(Path::to_owned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity(scenario: &str) -> Identity {
        Identity::new(scenario, 7, vec!["a_star+dwa".to_owned()], BTreeMap::new())
    }

    #[test]
    fn the_differing_key_is_named_with_both_values() {
        let there = identity("robot: {radius_m: 0.25, mass_kg: 3}\nmap: {size: [30, 20]}\nepisodes: 10\n");
        let here = identity("robot: {radius_m: 0.3}\nmap: {size: [30, 25]}\ngoal: [1, 2]\nepisodes: 20\n");
        assert_eq!(
            there.differences(&here),
            [
                "`robot.radius_m`: 0.25 there, 0.3 here",
                "`robot.mass_kg`: 3 there, absent here",
                "`map.size[1]`: 20 there, 25 here",
                "`goal`: absent there, - 1 - 2 here",
            ]
        );
    }

    #[test]
    fn the_number_of_episodes_is_no_difference_but_a_nested_key_of_that_name_is() {
        assert!(identity("episodes: 10").differences(&identity("episodes: 20")).is_empty());
        assert_eq!(
            identity("a: {episodes: 1}").differences(&identity("a: {episodes: 2}")),
            ["`a.episodes`: 1 there, 2 here"]
        );
    }

    #[test]
    fn a_file_with_other_content_is_named_and_a_seed_is_named_once() {
        let files =
            |hall: &str| [("hall.map", hall), ("walk.csv", "1")].map(|(a, b)| (a.to_owned(), b.to_owned())).into();
        let there = Identity { files: files("1"), ..identity("seed: 1") };
        let here = Identity { files: files("2"), seed: 8, ..identity("seed: 8") };
        assert_eq!(there.differences(&here), ["`seed`: 1 there, 8 here", "the file `hall.map` has been changed"]);
    }

    #[test]
    fn the_hash_of_the_settings_is_of_all_keys_but_the_number_of_episodes() {
        let hash = settings_hash("seed: 1\nepisodes: 10\na:\n  episodes: 3\n");
        assert_eq!(hash, settings_hash("seed: 1\nepisodes: 20\na:\n  episodes: 3\n"));
        assert_ne!(hash, settings_hash("seed: 1\nepisodes: 10\na:\n  episodes: 4\n"));
        assert_ne!(hash, settings_hash("seed: 2\nepisodes: 10\na:\n  episodes: 3\n"));
    }

    #[test]
    fn seed_stacks_version_and_build_are_named() {
        let there = identity("a: 1");
        let here = Identity {
            seed: 8,
            stacks: vec!["a_star+dwa".to_owned(), "dijkstra+dwa".to_owned()],
            version: "0.0.0".to_owned(),
            build: "0".to_owned(),
            ..there.clone()
        };
        let found = there.differences(&here);
        let version = env!("CARGO_PKG_VERSION");
        assert_eq!(found[0], "the seed: 7 there, 8 here");
        assert_eq!(found[1], "the stacks: a_star+dwa there, a_star+dwa, dijkstra+dwa here");
        assert_eq!(found[2], format!("the version of simrun: {version} there, 0.0.0 here"));
        assert_eq!(found[3], format!("the build of simrun: {} there, 0 here", there.build));
    }
}
