//! Papers put to the test: what they published and claim as data, run and judged.
//!
//! A paper is a [`Manifest`] (`NAME.paper.yaml`): scenarios to run, the published numbers, claims with the test that decides each.
//! The engine knows no paper; another one is another manifest with its scenarios.

mod check;
mod evidence;
mod judge;
pub mod manifest;
mod published;
mod report;

pub use evidence::{Bounds, Evidence, Failures};
pub use judge::{Ruling, Verdict, judge};
pub use manifest::Manifest;
pub use published::{Measured, Published, measured};
pub use report::{published_csv, report, verdicts_csv};

use crate::scenario::{Edit, ScenarioError, ScenarioFile};
use std::path::{Path, PathBuf};

/// A paper, read.
#[derive(Clone, Debug)]
pub struct Paper {
    /// Its short name: that of the manifest's file.
    pub name: String,
    /// What is run and asked.
    pub manifest: Manifest,
    /// What it printed.
    pub published: Vec<Published>,
    folder: PathBuf,
}

impl Paper {
    /// Reads the paper called `name` from `folder`.
    ///
    /// # Errors
    /// If there is no such paper (with those there are), or its files contradict each other.
    pub fn read(folder: &Path, name: &str) -> Result<Self, String> {
        let path = folder.join(format!("{name}.paper.yaml"));
        let text = std::fs::read_to_string(&path).map_err(|error| {
            let known = known_papers(folder);
            let known = known.iter().map(String::as_str).collect::<Vec<_>>();
            let which = match known.as_slice() {
                [] => format!(
                    "`{}` holds no papers; run it where the scenarios are, or name their folder with --papers",
                    folder.display()
                ),
                known => crate::settings::choice::unknown_name("paper", name, known),
            };
            if error.kind() == std::io::ErrorKind::NotFound {
                which
            } else {
                format!("cannot read `{}`: {error}", path.display())
            }
        })?;
        let manifest: Manifest = serde_yaml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        let published = Published::read(&folder.join(&manifest.published))?;
        let paper = Self { name: name.to_owned(), manifest, published, folder: folder.to_owned() };
        paper.consistent().map_err(|message| format!("{}: {message}", path.display()))?;
        Ok(paper)
    }

    /// The scenario of a table and the edits that make it what the table runs; `episodes` is the most that each may have.
    ///
    /// # Errors
    /// If the scenario or an edit is refused.
    pub fn scenario(
        &self,
        table: &manifest::Table,
        episodes: Option<u32>,
    ) -> Result<(ScenarioFile, Vec<Edit>), ScenarioError> {
        let file = ScenarioFile::open(self.folder.join(&table.scenario))?;
        let name = format!("name={}", table.id);
        let set = table.set.iter().chain([&name]).map(|text| Edit::parse(text));
        let mut edits = set.collect::<Result<Vec<Edit>, _>>()?;
        if let Some(most) = episodes {
            let planned = file.read(&edits)?.episodes.get();
            edits.push(Edit::parse(&format!("episodes={}", planned.min(most)))?);
        }
        Ok((file, edits))
    }
}

fn known_papers(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter_map(|name| Some(name.strip_suffix(".paper.yaml")?.to_owned())).collect();
    names.sort();
    names
}
