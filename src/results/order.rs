//! The order of rows: (sweep point, episode, stack), and the blocks that work is cut into.

use super::ResultsError;
use super::columns::COLUMNS;
use super::row::Row;
use super::value::one_line;
use std::collections::BTreeSet;

/// A stack that runs at a point of a sweep.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StackAt {
    /// Its name.
    pub name: String,
    /// The value of each swept key for its rows; empty if the key does not concern the stack.
    pub values: Vec<String>,
}

/// The rows of an experiment and their order.
///
/// A **block** is the rows of one world: one (point, episode) with one row per stack of the point.
/// Blocks are numbered by point, then episode. A point at which no stack runs has no block, and keeps its number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Order {
    swept: Vec<String>,
    points: Vec<Vec<StackAt>>,
    /// The numbers of the points at which a stack runs.
    driven: Vec<u32>,
    episodes: u64,
}

impl Order {
    /// An order of `points`, each with its stacks in the order of their rows, × `episodes`.
    ///
    /// # Errors
    /// If a swept key is named like a column or like another one.
    ///
    /// # Panics
    /// If no stack runs at any point or there is no episode, if a stack has not one value per swept key, if two stacks of a
    /// point have one name, or if a text holds a control character.
    pub fn new(swept: Vec<String>, points: Vec<Vec<StackAt>>, episodes: u64) -> Result<Self, ResultsError> {
        for (index, key) in swept.iter().enumerate() {
            if COLUMNS.iter().any(|column| column.name == key) || swept[..index].contains(key) {
                return Err(ResultsError::SweptKey(key.clone()));
            }
        }
        let is_line = |text: &String| one_line(text) == text.as_str();
        assert!(swept.iter().all(is_line), "texts of a row are on one line");
        for stacks in &points {
            let names: BTreeSet<&String> = stacks.iter().map(|stack| &stack.name).collect();
            assert!(names.len() == stacks.len(), "stacks are named apart");
            for StackAt { name, values } in stacks {
                assert_eq!(values.len(), swept.len(), "one value per swept key");
                assert!(is_line(name) && values.iter().all(is_line), "texts of a row are on one line");
            }
        }
        let driven = (0..).zip(&points).filter(|(_, stacks)| !stacks.is_empty()).map(|(point, _)| point);
        let driven: Vec<u32> = driven.collect();
        assert!(!driven.is_empty() && episodes > 0, "nothing to run");
        Ok(Self { swept, points, driven, episodes })
    }

    /// The swept keys.
    pub fn swept(&self) -> &[String] {
        &self.swept
    }

    /// The stacks of each point, by its number.
    pub fn points(&self) -> &[Vec<StackAt>] {
        &self.points
    }

    /// Episodes per point.
    pub fn episodes(&self) -> u64 {
        self.episodes
    }

    /// Number of blocks.
    pub fn blocks(&self) -> u64 {
        self.driven.len() as u64 * self.episodes
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.points.iter().map(|stacks| stacks.len() as u64 * self.episodes).sum()
    }

    /// Point and episode of a block.
    pub(super) fn position(&self, block: u64) -> (u32, u64) {
        assert!(block < self.blocks(), "block {block} of {}", self.blocks());
        (self.driven[(block / self.episodes) as usize], block % self.episodes)
    }

    /// Number of the point at `place` among those with rows, counted from 0; `None` past the last.
    pub(super) fn driven(&self, place: u64) -> Option<u32> {
        self.driven.get(usize::try_from(place).ok()?).copied()
    }

    /// The place of a point among those with rows.
    pub(super) fn place(&self, point: u32) -> u64 {
        self.driven.binary_search(&point).expect("a point with rows") as u64
    }

    /// The stacks of a point.
    pub(super) fn stacks(&self, point: u32) -> &[StackAt] {
        &self.points[point as usize]
    }

    /// Checks that `row` is the row of stack `stack` in the block (point, episode); the error says what it should be.
    pub(super) fn check(&self, row: &Row, point: u32, episode: u64, stack: usize, seed: u64) -> Result<(), String> {
        let StackAt { name: expected, values } = &self.stacks(point)[stack];
        if (row.point, row.episode, &row.stack) != (point, episode, expected) {
            return Err(format!(
                "expected point {point}, episode {episode}, stack `{expected}`, found point {}, episode {}, stack `{}`",
                row.point, row.episode, row.stack
            ));
        }
        if row.seed != seed {
            return Err(format!("expected the seed {seed}, found {}", row.seed));
        }
        if row.swept != *values {
            return Err(format!("expected the swept values {values:?}, found {:?}", row.swept));
        }
        Ok(())
    }
}
