//! A scenario's file: its text, and the edits made to it on the way in.

use super::error::ScenarioError;
use super::explain;
use super::faults::{self, Written};
use super::key_path::{self, KeyPath, Step};
use super::memory::{Memory, Room};
use super::{Edit, Name, Scenario, shape};
use crate::files::{self, FileError};
use std::path::{Path, PathBuf};

/// The top-level keys that the checks against the map read.
const MAP_CHECK_READS: [&str; 10] =
    ["map", "seed", "start", "goal", "obstacles", "script", "robot", "limits", "planning", "control_period_s"];

/// Reads a scenario file with edits and checks everything that can be checked before the first tick.
///
/// # Errors
/// Every fault, placed in the file or at the edit that caused it.
pub fn load(path: impl Into<PathBuf>, edits: &[Edit]) -> Result<Scenario, ScenarioError> {
    let file = ScenarioFile::open(path)?;
    let scenario = file.read(edits)?;
    file.check(&scenario, edits)?;
    Ok(scenario)
}

/// Why a document beside scenarios cannot be read, with the line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct DocumentError(String);

/// Reads another YAML document of simrun's, such as the manifest of a paper.
///
/// # Errors
/// If it is no YAML, or not what `T` expects.
pub fn read_document<T: serde::de::DeserializeOwned>(text: &str) -> Result<T, DocumentError> {
    serde_yaml::from_str(text).map_err(|error| DocumentError(error.to_string()))
}

/// A scenario's tree after its edits.
struct Edited {
    tree: serde_yaml::Value,
    /// Where each edit landed; nowhere if it was refused.
    landed: Vec<Vec<KeyPath>>,
    /// The errors of the edits that could not be made.
    refused: Vec<ScenarioError>,
}

/// The text of a scenario file, kept so that errors can show the line.
#[derive(Clone, Debug)]
pub struct ScenarioFile {
    path: PathBuf,
    text: String,
    /// The folder in which relative paths start, if it is not that of the file.
    folder: Option<PathBuf>,
    room: Option<Room>,
}

impl ScenarioFile {
    /// Reads the file, at most as much of it as a scenario may have.
    ///
    /// # Errors
    /// If it cannot be read, is too large, or is not UTF-8.
    pub fn open(path: impl Into<PathBuf>) -> Result<Self, ScenarioError> {
        let path = path.into();
        let shown = path.display().to_string();
        let refused = match files::text(&path, shape::SIZE_MAX_BYTES as u64) {
            Ok(text) => return Ok(Self { path, text, folder: None, room: None }),
            Err(FileError::TooLarge { .. }) => shape::too_large(),
            Err(FileError::NotUtf8 { line, .. }) => {
                ScenarioError::new(format!("line {line} holds bytes that are not UTF-8 text"))
                    .help("is this the right file? Save it as UTF-8")
            }
            Err(error) if error.is_missing() => {
                let refused = ScenarioError::new("there is no such scenario file");
                match similar_files(&path) {
                    Some(files) => refused.help(files),
                    None => refused,
                }
            }
            Err(error) => ScenarioError::new(format!("cannot read the scenario: {error}")),
        };
        Err(refused.in_file(&shown))
    }

    /// A scenario from a text; `path` is what messages show, and where relative paths start.
    pub fn from_text(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        let text = text.into();
        // Editors of other systems put a byte order mark in front.
        let text = text.strip_prefix('\u{feff}').map_or_else(|| text.clone(), str::to_owned);
        Self { path: path.into(), text, folder: None, room: None }
    }

    /// The same file; scenarios of it that would take more memory are refused when they are checked.
    #[must_use]
    pub fn within(mut self, room: Room) -> Self {
        self.room = Some(room);
        self
    }

    /// The memory that a run may take.
    pub(super) fn memory(&self) -> Memory {
        Memory::new(self.room)
    }

    /// The file's name in messages.
    pub(super) fn shown(&self) -> String {
        self.path.display().to_string()
    }

    /// The same scenario, whose relative paths start in another folder than the file's own.
    #[must_use]
    pub fn in_folder(self, folder: PathBuf) -> Self {
        Self { folder: Some(folder), ..self }
    }

    /// The file, as it was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The folder in which relative paths of the scenario start.
    pub fn folder(&self) -> &Path {
        self.folder.as_deref().or(self.path.parent()).unwrap_or(Path::new(""))
    }

    /// The scenario with `edits` made to it in order, checked by itself (not yet against its map).
    ///
    /// # Errors
    /// Every fault, placed in the file or at the edit that caused it; what follows from another fault is left out. Where what is at fault
    /// has nothing to do with the map, the faults against the map are among them.
    pub fn read(&self, edits: &[Edit]) -> Result<Scenario, ScenarioError> {
        let file = self.shown();
        let schema = Scenario::schema();
        let (paths, mut errors): (Vec<KeyPath>, Vec<ScenarioError>) =
            shape::check(&file, &self.text)?.into_iter().unzip();
        let Edited { tree, landed, refused } = self.edited_in_part(edits, schema)?;
        errors.extend(refused);
        let written = Written { file: &file, text: &self.text, edits, landed: &landed };
        let reading = faults::read(tree, paths, &written, schema);
        errors.extend(reading.errors);
        let Some(mut scenario) = reading.scenario else {
            ScenarioError::all(errors, &file)?;
            return Err(ScenarioError::new("the scenario cannot be read").in_file(file));
        };
        if scenario.name == Name::default() {
            match self.stem() {
                Ok(name) => scenario.name = name,
                Err(error) => errors.push(error.in_file(&file)),
            }
        }
        let at_fault =
            |key: &KeyPath| reading.taken_out.iter().any(|taken| taken.steps().first() == key.steps().first());
        let is_new = |error: &ScenarioError| !error.keys().any(at_fault);
        errors.extend(scenario.contradictions().into_iter().filter(is_new).map(|error| self.place(error, edits)));
        if errors.is_empty() {
            return Ok(scenario);
        }
        // Nothing is done with a number beyond physics, not even looked at on the map.
        let is_physical = scenario.out_of_range().is_empty();
        if is_physical
            && !reading
                .taken_out
                .iter()
                .any(|key| MAP_CHECK_READS.contains(&key.steps().first().map_or("", Step::name)))
        {
            let on_map = scenario.check_within(self.folder(), &mut self.memory()).map_err(ScenarioError::apart).err();
            errors.extend(on_map.into_iter().flatten().filter(is_new).map(|error| self.place(error, edits)));
        }
        ScenarioError::all(errors, &file).map(|()| scenario)
    }

    /// Checks a scenario of this file against its map; see [`Scenario::check`].
    ///
    /// # Errors
    /// Every fault, placed in the file or at the edit that caused it.
    pub fn check(&self, scenario: &Scenario, edits: &[Edit]) -> Result<(), ScenarioError> {
        scenario.check_within(self.folder(), &mut self.memory()).map_err(|error| self.place(error, edits))
    }

    /// The tree after all edits, and where each of them landed.
    pub(super) fn edited(
        &self,
        edits: &[Edit],
        schema: &serde_json::Value,
    ) -> Result<(serde_yaml::Value, Vec<Vec<KeyPath>>), ScenarioError> {
        let Edited { tree, landed, refused } = self.edited_in_part(edits, schema)?;
        ScenarioError::all(refused, &self.shown()).map(|()| (tree, landed))
    }

    /// Makes the edits that can be made.
    fn edited_in_part(&self, edits: &[Edit], schema: &serde_json::Value) -> Result<Edited, ScenarioError> {
        let file = self.shown();
        let mut tree: serde_yaml::Value =
            serde_yaml::from_str(&self.text).map_err(|error| explain::shape(&error, &file, &self.text).1)?;
        let (mut landed, mut refused) = (Vec::new(), Vec::new());
        for edit in edits {
            // An edit that fails has changed nothing.
            let mut edited = tree.clone();
            match edit.apply(&mut edited, schema) {
                Ok(places) => {
                    tree = edited;
                    landed.push(places);
                }
                Err(error) => {
                    refused.push(error);
                    landed.push(Vec::new());
                }
            }
        }
        Ok(Edited { tree, landed, refused })
    }

    /// Shows errors where their keys stand: at the last edit of one of them, else in the file.
    pub(super) fn place(&self, error: ScenarioError, edits: &[Edit]) -> ScenarioError {
        let file = self.shown();
        let landed = self.edited_in_part(edits, Scenario::schema()).map(|edited| edited.landed).unwrap_or_default();
        let placed: Vec<ScenarioError> = error.apart().map(|error| self.place_one(error, edits, &landed)).collect();
        match ScenarioError::all(placed, &file) {
            Err(error) => error,
            Ok(()) => unreachable!("an error is at least one"),
        }
    }

    fn place_one(&self, error: ScenarioError, edits: &[Edit], landed: &[Vec<KeyPath>]) -> ScenarioError {
        if let Some((edit, key)) = edit_of(&error, landed) {
            return edits[edit].blame(error.showing(key), None);
        }
        let file = self.shown();
        let written = error.keys().position(|key| key_path::exists(&self.text, key)).unwrap_or(0);
        let span = error.keys().nth(written).and_then(|key| key_path::locate(&self.text, key));
        match span {
            Some(span) => error.showing(written).at(Some(file), &self.text, span),
            None => error.in_file(file),
        }
    }

    /// The file's name without its ending, as the scenario's name.
    fn stem(&self) -> Result<Name, ScenarioError> {
        let stem = self.path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        Name::try_from(stem.as_str()).map_err(|_| {
            ScenarioError::new(format!("the file's name {stem:?} cannot name a folder of results"))
                .key(KeyPath::parse("name"))
                .help("add `name: …` to the scenario, of letters, digits, `_`, `-` and `+`, or rename the file")
        })
    }
}

/// The last edit that landed on one of the error's keys (or above or below it), and which key that is.
fn edit_of(error: &ScenarioError, landed: &[Vec<KeyPath>]) -> Option<(usize, usize)> {
    let key_of =
        |edit: &[KeyPath]| error.keys().position(|key| !key.is_top() && edit.iter().any(|place| key.touches(place)));
    landed.iter().enumerate().rev().find_map(|(i, edit)| Some((i, key_of(edit)?)))
}

/// A sentence that lists the files beside `path` that are called much like it.
pub(super) fn similar_files(path: &Path) -> Option<String> {
    let wanted = path.file_name()?.to_string_lossy().into_owned();
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Some(format!("there is no folder {}", folder.display()));
    };
    let mut names: Vec<(u64, String)> = entries
        .filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned()))
        .map(|name| ((strsim::jaro_winkler(&wanted, &name) * 1e6) as u64, name))
        .filter(|(score, _)| *score > 700_000)
        .collect();
    names.sort_by(|a, b| b.0.cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
    let names: Vec<String> = names.into_iter().take(3).map(|(_, name)| format!("`{name}`")).collect();
    (!names.is_empty()).then(|| format!("did you mean {}?", names.join(" or ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = "map: {empty: {cols: 20, rows: 10}}\nstacks: {global: [a_star], local: [dwa]}\n";

    fn refusal(bytes: &[u8]) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("warehouse.yaml");
        std::fs::write(&path, bytes).unwrap();
        load(path, &[]).unwrap_err().to_string()
    }

    #[test]
    fn a_file_that_is_not_there_is_named_with_those_like_it() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("warehouse.yaml"), GOOD).unwrap();
        let error = load(folder.path().join("warehose.yaml"), &[]).unwrap_err().to_string();
        assert!(error.contains("warehose.yaml") && error.contains("did you mean `warehouse.yaml`?"), "{error}");
    }

    #[test]
    fn the_name_is_the_files_unless_given() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("narrow-door_2.yaml");
        std::fs::write(&path, GOOD).unwrap();
        assert_eq!(load(&path, &[]).unwrap().name.as_str(), "narrow-door_2");
        std::fs::write(&path, format!("name: other\n{GOOD}")).unwrap();
        assert_eq!(load(&path, &[]).unwrap().name.as_str(), "other");
    }

    #[test]
    fn other_line_ends_and_a_byte_order_mark_change_nothing() {
        let plain = ScenarioFile::from_text("a.yaml", GOOD).read(&[]).unwrap();
        for text in [GOOD.replace('\n', "\r\n"), format!("\u{feff}{GOOD}"), format!("---\n{GOOD}...\n")] {
            assert_eq!(ScenarioFile::from_text("a.yaml", text).read(&[]).unwrap(), plain);
        }
        let error = ScenarioFile::from_text("a.yaml", "map: {empty: {cols: 2}}\r\nstacks: {globl: []}\r\n");
        assert!(error.read(&[]).unwrap_err().to_string().contains("a.yaml:1:"), "positions survive");
    }

    #[test]
    fn what_is_no_text_or_too_large_is_refused() {
        assert!(refusal(b"map: \xff\xfe").contains("line 1 holds bytes that are not UTF-8"));
        assert!(refusal(&vec![b'#'; shape::SIZE_MAX_BYTES + 1]).contains("larger than 1024 KiB"));
        assert!(refusal(b"map: \0").contains("not YAML"));
    }

    #[test]
    fn hostile_texts_are_refused_and_do_not_stall_the_reader() {
        let size = shape::SIZE_MAX_BYTES;
        let anchors = "x: &x [a, a, a, a, a, a, a, a, a, a]\n";
        for text in [
            "[".repeat(size),
            "{".repeat(size),
            "[\"]\", ".repeat(size / 6),
            "- ".repeat(size / 2),
            "? ".repeat(size / 2),
            "a: {".repeat(size / 4),
            "&a ".repeat(size / 3),
            "!".repeat(size),
            "'".repeat(size),
            format!("{anchors}y: [{}]", "*x, ".repeat(size / 5)),
            "a:\n ".repeat(size / 4),
            (0..600).map(|depth| format!("{}a:\n", " ".repeat(depth))).collect(),
        ] {
            let refused = ScenarioFile::from_text("hostile.yaml", text).read(&[]);
            assert!(refused.is_err());
        }
    }
}
