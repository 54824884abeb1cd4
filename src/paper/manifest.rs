//! A paper as data: tables to run, and claims to test on them.
//!
//! `scenarios/papers/NAME.paper.yaml` is read as a [`Manifest`]; its published numbers stand in a CSV beside it.

use crate::scenario::Name;
use crate::settings::choice::choice;
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
    /// The claims to test on the results.
    pub claims: Vec<Claim>,
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

/// A stack in a table.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Id of the table.
    pub table: String,
    /// Name of the stack.
    pub stack: String,
}

choice! {
    /// What would make a claim hold. A metric is a measured column of `episodes.csv`, or `success` (in percent).
    pub enum Test: "test" {
        compare, differ, reach, range, fisher, multiples, all, untestable,
    }
}

/// How two numbers should stand to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Relation {
    /// The first is smaller.
    Less,
    /// The first is larger.
    More,
    /// They are equal within the tolerance.
    Equal,
}

/// Whether a test is about the paper's numbers or ours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The rows of our runs.
    #[default]
    Measured,
    /// The numbers that the paper prints.
    Published,
}

/// The worlds that a comparison looks at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// Those that both stacks solved.
    #[default]
    BothSolved,
    /// All in which the metric is defined for both: for what is known before the drive, such as planned lengths.
    All,
}

/// One stack against another.
///
/// Measured: on the same worlds. `less` and `more` of a metric hold if the 95 % interval of the mean difference `of − factor · than`
/// lies wholly on that side of 0 and the signed-rank test agrees (p ≤ 0.05); of `success`, if McNemar's exact test tells the two
/// apart. They fail if the same shows on the other side, a metric also where no world differs at all, and are undecided otherwise.
/// `equal` holds if no world differs by more than the tolerance. Published: the printed numbers as they are.
pub mod compare {
    use super::{Deserialize, Over, Place, Relation, Source};

    /// Which stacks, by which metric.
    #[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// The metric.
        pub metric: String,
        /// The first stack.
        pub of: Place,
        /// How it should stand to the second.
        pub is: Relation,
        /// The second stack; of another table, the worlds must be the same.
        pub than: Place,
        /// The second number is multiplied by this; default 1.
        #[serde(default = "one")]
        pub factor: f64,
        /// Difference up to which two numbers are equal; default 0.
        #[serde(default)]
        pub tolerance: f64,
        /// The worlds it looks at; default `both_solved`.
        #[serde(default)]
        pub over: Over,
        /// Whose numbers; default `measured`.
        #[serde(default)]
        pub source: Source,
    }

    fn one() -> f64 {
        1.0
    }
}

/// Stacks differ on one world: holds if in some world the largest and the smallest value are further apart than the tolerance.
pub mod differ {
    use super::Deserialize;

    /// Which stacks, by which metric.
    #[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// The metric, looked at wherever it is defined for all of the stacks.
        pub metric: String,
        /// Ids of the tables.
        pub tables: Vec<String>,
        /// Names of the stacks, the same in each table.
        pub stacks: Vec<String>,
        /// Difference up to which two numbers are equal; default 0.
        #[serde(default)]
        pub tolerance: f64,
    }
}

/// Our success rate reaches the published one: the lower end of our Wilson 95 % interval is at least that of the published count.
///
/// Fails if the upper end of ours is below the published lower end, undecided otherwise. The published count is that of the table whose
/// id is this one's up to its first `_`: `table3_replan` is asked for what is printed of `table3`.
pub mod reach {
    use super::{Deserialize, Place};

    /// Where.
    #[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// The stack; its published success rate must be in the CSV, with its trials.
        pub of: Place,
    }
}

/// A metric lies within bounds.
///
/// `every`: in every row (of the paper: in every printed number). `mean`: the 95 % interval of the mean over the successes
/// (of `success`: the Wilson interval of the rate) lies within the bounds; fails if it lies wholly outside, undecided otherwise.
pub mod range {
    use super::{Deserialize, Source};

    /// Which metric, which bounds.
    #[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// The metric.
        pub metric: String,
        /// Id of the table.
        pub table: String,
        /// The stack; default every stack of the table.
        #[serde(default)]
        pub stack: Option<String>,
        /// Lower bound, itself within; default none.
        #[serde(default)]
        pub at_least: Option<f64>,
        /// Upper bound, itself within; default none.
        #[serde(default)]
        pub at_most: Option<f64>,
        /// Of what; default `mean`.
        #[serde(default)]
        pub of: Statistic,
        /// Whose numbers; default `measured`.
        #[serde(default)]
        pub source: Source,
    }

    /// What must lie within the bounds.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, serde::Serialize, schemars::JsonSchema)]
    #[serde(rename_all = "snake_case")]
    pub enum Statistic {
        /// The mean over the successes, or the rate.
        #[default]
        Mean,
        /// Every single value.
        Every,
    }
}

/// The paper's own counts show one of its stacks to be better than another: two-sided exact test of Fisher, p ≤ 0.05.
pub mod fisher {
    use super::{Deserialize, Place};

    /// Which two.
    #[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// The stack that should be better.
        pub of: Place,
        /// The stack that should be worse.
        pub than: Place,
    }
}

/// Every published success rate of a table is, to the printed digit, a whole number of its trials.
pub mod multiples {
    use super::Deserialize;

    /// Which table.
    #[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// Id of the table.
        pub table: String,
        /// Digits after the point of a printed percentage; default 1.
        #[serde(default = "one")]
        pub decimals: u32,
    }

    fn one() -> u32 {
        1
    }
}

/// All of several tests: holds if all do, fails if one does, undecided otherwise.
pub mod all {
    use super::{Deserialize, Test};

    /// Which ones.
    #[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// The tests.
        pub tests: Vec<Test>,
    }
}

/// Nothing that simrun can run would decide it.
pub mod untestable {
    use super::Deserialize;

    /// Why not.
    #[derive(Clone, Debug, PartialEq, Deserialize, serde::Serialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// The reason.
        pub because: String,
    }
}
