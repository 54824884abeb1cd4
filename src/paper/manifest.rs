//! A paper as data: tables to run, claims to test on them, and the choices that the paper leaves open.
//!
//! `scenarios/papers/NAME.paper.yaml` is read as a [`Manifest`]; its published numbers stand in a CSV beside it.

use super::test::Test;
use crate::scenario::Name;
use crate::settings::quantity::Count;
use serde::Deserialize;

/// A paper: its description, the tables to run, the claims to test on the results.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Title of the paper.
    pub title: String,
    /// Authors, venue and year.
    pub citation: String,
    /// What the paper proposes and claims, for somebody who has not read it.
    pub about: String,
    /// What our runs share with the paper's and what is our own choice, for the same reader.
    pub method: String,
    /// CSV of the published numbers, in the manifest's folder.
    pub published: String,
    /// The tables to run.
    pub tables: Vec<Table>,
    /// The choices that the paper leaves open, each taken another way; default none. Every statement is judged again under each.
    #[serde(default)]
    pub ablate: Vec<Choice>,
    /// The claims of the paper. Their tests are one family: p-values are corrected for their number (Holm).
    #[serde(default)]
    pub claims: Vec<Claim>,
    /// Questions that the paper does not ask, on the same results. They count apart and are not corrected.
    #[serde(default)]
    pub questions: Vec<Claim>,
}

impl Manifest {
    /// The claims, then the questions.
    pub fn statements(&self) -> impl Iterator<Item = &Claim> {
        self.claims.iter().chain(&self.questions)
    }
}

/// A choice that the paper leaves open, taken another way than in its tables.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// Its name in reports, and in names of folders.
    pub id: Name,
    /// What it takes another way, in words.
    pub says: String,
    /// Whether it is a choice about the planner or about the world.
    pub of: Subject,
    /// Changes to the scenarios, each `path.to.key=value` as `--set` takes them.
    pub set: Vec<String>,
    /// Ids of the tables that it changes.
    pub tables: Vec<String>,
    /// Whether it is the reading of the text that is kindest to the paper's claims; at most one is. Default no.
    #[serde(default)]
    pub kindest: bool,
}

/// What a choice is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Subject {
    /// The planner: how a formula is read, what a parameter is.
    Planner,
    /// The world: how movers behave, how large they are.
    World,
    /// Both.
    Both,
}

/// One scenario that is run, as it stands or with changes.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Its name in claims and published numbers, and the name of its folder of results.
    pub id: Name,
    /// Description in one line.
    pub title: String,
    /// The scenario's file, in the manifest's folder.
    pub scenario: String,
    /// Changes to the scenario, each `path.to.key=value` as `--set` takes them; default none.
    #[serde(default)]
    pub set: Vec<String>,
    /// Only these stacks of the scenario, by name; default all.
    #[serde(default)]
    pub stacks: Vec<String>,
    /// Whether only the full form runs it (`simrun reproduce --full`); default no.
    #[serde(default)]
    pub full: bool,
    /// Id of a table with more worlds and the same stacks: where that one was run, claims about this table are judged by it. Default none.
    #[serde(default)]
    pub larger: Option<String>,
    /// Number of episodes under each choice of `ablate`; default as many as otherwise.
    #[serde(default)]
    pub under_choices: Option<Count>,
}

/// Id of the larger form of the table `id`, if it has one.
pub(super) fn larger_form<'a>(tables: &'a [Table], id: &str) -> Option<&'a str> {
    tables.iter().find(|table| table.id.as_str() == id)?.larger.as_deref()
}

/// A statement that is put to the test.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// A short name that is not used twice.
    pub id: String,
    /// The claim in words.
    pub says: String,
    /// Reason for testing it; default nothing.
    #[serde(default)]
    pub doubt: String,
    /// The test by which it holds.
    pub test: Test,
    /// Meaning of the verdict, whichever it is; default nothing.
    #[serde(default)]
    pub remark: String,
}
