//! Papers put to the test: their published numbers and claims as data, run and judged.
//!
//! A paper is a [`Manifest`] (`NAME.paper.yaml`): scenarios to run, the published numbers, claims with the test that decides each.
//! The engine knows no paper; another one is another manifest with its scenarios.

mod check;
mod evidence;
mod findings;
pub mod manifest;
mod published;
mod report;
pub mod test;

pub use evidence::{Bounds, Evidence, Failures, TableEvidence};
pub use findings::{Finding, Findings};
pub use manifest::Manifest;
pub use published::{Measured, Published, Quantity, measured};
pub use report::{published_csv, report, verdicts_csv};
pub use test::{Ruling, Verdict};

use crate::files::{self, FileError};
use crate::scenario::{Edit, ScenarioError, ScenarioFile, read_document};
use crate::settings::choice::NameError;
use crate::settings::quantity::Count;
use std::path::{Path, PathBuf};

/// Reason why a paper cannot be put to the test.
#[derive(Debug, thiserror::Error)]
pub enum PaperError {
    /// There is no paper, table, stack or metric of that name.
    #[error(transparent)]
    Name(#[from] NameError),
    /// The folder has no papers at all.
    #[error("`{}` holds no papers; run it where the scenarios are, or name their folder with --papers", folder.display())]
    NoPapers {
        /// The folder.
        folder: PathBuf,
    },
    /// A file cannot be read.
    #[error("cannot read `{}`: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: FileError,
    },
    /// A file of the paper is wrong in itself, or does not fit the others.
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Description of the fault.
        message: String,
    },
}

/// Largest number of bytes of a manifest, and of a file of published numbers.
const BYTES_MAX: u64 = 1 << 22;

/// A paper, read.
#[derive(Clone, Debug)]
pub struct Paper {
    /// Its short name: that of the manifest's file.
    pub name: String,
    /// Its tables and claims.
    pub manifest: Manifest,
    /// Its published numbers.
    pub published: Vec<Published>,
    folder: PathBuf,
}

impl Paper {
    /// The names of the papers in `folder`, in alphabetical order.
    ///
    /// # Errors
    /// If there is none.
    pub fn names(folder: &Path) -> Result<Vec<String>, PaperError> {
        let names = known_papers(folder);
        if names.is_empty() { Err(PaperError::NoPapers { folder: folder.to_owned() }) } else { Ok(names) }
    }

    /// Reads the paper called `name` from `folder`.
    ///
    /// # Errors
    /// If no paper has that name (the error lists the known ones), or its files contradict each other.
    pub fn read(folder: &Path, name: &str) -> Result<Self, PaperError> {
        let path = folder.join(format!("{name}.paper.yaml"));
        let text =
            files::text(&path, BYTES_MAX).map_err(|source| match (source.is_missing(), known_papers(folder)) {
                (true, known) if known.is_empty() => PaperError::NoPapers { folder: folder.to_owned() },
                (true, known) => NameError::unknown("paper", name, &known).into(),
                _ => PaperError::Read { path: path.clone(), source },
            })?;
        let refuse = |message: String| PaperError::File { path: path.clone(), message };
        let manifest: Manifest = read_document(&text).map_err(|error| refuse(error.to_string()))?;
        let published = Published::read(&folder.join(&manifest.published))?;
        let paper = Self { name: name.to_owned(), manifest, published, folder: folder.to_owned() };
        paper.consistent().map_err(refuse)?;
        Ok(paper)
    }

    /// The scenario of a table with the edits of the table, and those of a choice that changes it; `episodes` is the largest number
    /// of episodes that it may have.
    ///
    /// # Errors
    /// If the scenario or an edit is refused.
    pub fn scenario(
        &self,
        table: &manifest::Table,
        choice: Option<&manifest::Choice>,
        episodes: Option<u32>,
    ) -> Result<(ScenarioFile, Vec<Edit>), ScenarioError> {
        let file = ScenarioFile::open(self.folder.join(&table.scenario))?;
        let name = format!("name={}", folder_of(table, choice));
        let set = table.set.iter().chain(choice.iter().flat_map(|choice| &choice.set)).chain([&name]);
        let mut edits = set.map(|text| Edit::parse(text)).collect::<Result<Vec<Edit>, _>>()?;
        let most_under_choice = choice.and(table.under_choices).map(Count::get);
        if let Some(most) = episodes.into_iter().chain(most_under_choice).min() {
            let planned = file.read(&edits)?.episodes.get();
            edits.push(Edit::parse(&format!("episodes={}", planned.min(most)))?);
        }
        Ok((file, edits))
    }
}

/// The name of the folder of a table's results: the table's, and the choice's where it is not as it is.
pub fn folder_of(table: &manifest::Table, choice: Option<&manifest::Choice>) -> String {
    choice.map_or_else(|| table.id.to_string(), |choice| format!("{}+{}", table.id, choice.id))
}

fn known_papers(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter_map(|name| Some(name.strip_suffix(".paper.yaml")?.to_owned())).collect();
    names.sort();
    names
}
