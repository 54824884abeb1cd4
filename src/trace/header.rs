//! The lines in front of a trace's table, each begun with `#`: which drive it is, and how to drive it again.

use crate::command;
use crate::files;
use std::fmt;
use std::io::{self, BufRead};
use std::path::Path;

/// Which drive a trace is of.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// The scenario's file, as the command named it; the scenario's name where it has no file.
    pub scenario: String,
    /// The edits made to it, as `--set` takes them.
    pub edits: Vec<String>,
    /// Seed of the scenario.
    pub seed: u64,
    /// Number of the sweep point.
    pub point: u32,
    /// Number of the episode.
    pub episode: u64,
    /// Name of the stack.
    pub stack: String,
    /// Build id of the simrun that drove, 16 hexadecimal digits.
    pub build: String,
    /// Hash of the scenario with every default but the number of episodes, 16 hexadecimal digits.
    pub settings_hash: String,
    /// Digest of everything that happened, as in `episodes.csv`, 16 hexadecimal digits.
    pub trace_digest: String,
}

/// Longest header that is read, lines; the table begins long before.
const LINES_MAX: usize = 32;

impl Header {
    /// Reads the header of a trace file; `None` if it has none, as those of 0.1.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn read(file: &Path) -> io::Result<Option<Self>> {
        let lines = files::lines(file, u64::MAX)?.lines().take(LINES_MAX);
        let lines = lines.take_while(|line| line.as_ref().is_ok_and(|line| line.starts_with('#')));
        let lines = lines.collect::<io::Result<Vec<String>>>()?;
        let value = |key: &str| lines.iter().find_map(|line| line.strip_prefix(&format!("# {key}: ")));
        let parse = || {
            Some(Self {
                scenario: value("scenario")?.to_owned(),
                edits: serde_json::from_str(value("edits")?).ok()?,
                seed: value("seed")?.parse().ok()?,
                point: value("point")?.parse().ok()?,
                episode: value("episode")?.parse().ok()?,
                stack: value("stack")?.to_owned(),
                build: value("build")?.to_owned(),
                settings_hash: value("settings_hash")?.to_owned(),
                trace_digest: value("trace_digest")?.to_owned(),
            })
        };
        Ok(parse())
    }

    /// Whether it is the same drive of the same build, whatever its scenario's file was called.
    pub fn is_same_drive(&self, other: &Self) -> bool {
        let named = |header: &Self| Self { scenario: String::new(), edits: Vec::new(), ..header.clone() };
        named(self) == named(other)
    }

    /// The command that drives it again.
    pub fn command(&self) -> String {
        let mut words = vec!["simrun".to_owned(), "run".to_owned(), self.scenario.clone()];
        words.extend(["--episode".to_owned(), self.episode.to_string()]);
        if self.point > 0 {
            words.extend(["--point".to_owned(), self.point.to_string()]);
        }
        words.extend(["--stack".to_owned(), self.stack.clone()]);
        words.extend(self.edits.iter().flat_map(|edit| ["--set".to_owned(), edit.clone()]));
        command::line(words)
    }
}

/// One line for each fact, each begun with `#`.
impl fmt::Display for Header {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let edits = serde_json::to_string(&self.edits).map_err(|_| fmt::Error)?;
        // A name that would begin a new line leaves the header.
        let mut line = |key: &str, value: &dyn fmt::Display| {
            writeln!(f, "# {key}: {}", value.to_string().replace(char::is_control, " "))
        };
        line("command", &self.command())?;
        line("scenario", &self.scenario)?;
        line("edits", &edits)?;
        line("seed", &self.seed)?;
        line("point", &self.point)?;
        line("episode", &self.episode)?;
        line("stack", &self.stack)?;
        line("build", &self.build)?;
        line("settings_hash", &self.settings_hash)?;
        line("trace_digest", &self.trace_digest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> Header {
        Header {
            scenario: "my scenarios/5.yaml".to_owned(),
            edits: vec!["limits.speed_max_mps=0.5".to_owned(), "goal=[1,\n2]".to_owned(), "name=it's".to_owned()],
            seed: 7,
            point: 3,
            episode: 12,
            stack: "a_star+dwa".to_owned(),
            build: "0123456789abcdef".to_owned(),
            settings_hash: "0".repeat(16),
            trace_digest: "1".repeat(16),
        }
    }

    #[test]
    fn a_header_reads_back_as_it_was_written_and_tells_the_command() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("e000012_a_star+dwa.csv");
        std::fs::write(&file, format!("{}tick,time_s\n0,0\n# episode: 13\n", header())).unwrap();
        assert_eq!(Header::read(&file).unwrap(), Some(header()));
        assert_eq!(
            header().command(),
            "simrun run 'my scenarios/5.yaml' --episode 12 --point 3 --stack a_star+dwa --set limits.speed_max_mps=0.5 \
             --set $'goal=[1,\\0122]' --set 'name=it'\\''s'"
        );
        assert_eq!(header().to_string().lines().filter(|line| line.starts_with("# ")).count(), 10);
        std::fs::write(&file, "tick,time_s\n0,0\n").unwrap();
        assert_eq!(Header::read(&file).unwrap(), None);
    }

    #[test]
    fn a_drive_is_the_same_whatever_its_file_was_called_and_another_by_anything_else() {
        let other_file = Header { scenario: "5.yaml".to_owned(), edits: vec![], ..header() };
        assert!(header().is_same_drive(&other_file));
        for other in [
            Header { episode: 13, ..header() },
            Header { build: String::new(), ..header() },
            Header { trace_digest: String::new(), ..header() },
        ] {
            assert!(!header().is_same_drive(&other), "{other:?}");
        }
    }
}
