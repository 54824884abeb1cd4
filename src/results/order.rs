//! The order of rows: (sweep point, episode, stack), and the blocks that work is cut into.

use super::ResultsError;
use super::columns::COLUMNS;
use super::row::Row;
use super::value::one_line;
use std::collections::BTreeSet;

/// One point of a sweep: the values of the swept keys and the stacks that run there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Point {
    /// The value of each swept key, as it is to stand in the file.
    pub values: Vec<String>,
    /// Names of the stacks, in the order of their rows.
    pub stacks: Vec<String>,
}

/// Which rows an experiment writes, in which order.
///
/// A **block** is the rows of one world: one (point, episode) with one row per stack of the point.
/// Blocks are numbered by point, then episode.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Order {
    swept: Vec<String>,
    points: Vec<Point>,
    episodes: u64,
}

impl Order {
    /// An order of `points` × `episodes`.
    ///
    /// # Errors
    /// If a swept key is named like a column or like another one.
    ///
    /// # Panics
    /// If there is no point or no episode, if a point has not one value per swept key, has no stack,
    /// or has two stacks of one name, or if a text holds a control character.
    pub fn new(swept: Vec<String>, points: Vec<Point>, episodes: u64) -> Result<Self, ResultsError> {
        assert!(!points.is_empty() && episodes > 0, "nothing to run");
        for (index, key) in swept.iter().enumerate() {
            if COLUMNS.iter().any(|column| column.name == key) || swept[..index].contains(key) {
                return Err(ResultsError::SweptKey(key.clone()));
            }
        }
        for point in &points {
            assert_eq!(point.values.len(), swept.len(), "one value per swept key");
            let names: BTreeSet<&String> = point.stacks.iter().collect();
            assert!(!names.is_empty() && names.len() == point.stacks.len(), "stacks are named apart");
            let mut texts = swept.iter().chain(&point.values).chain(&point.stacks);
            assert!(texts.all(|text| one_line(text) == text.as_str()), "texts of a row are on one line");
        }
        Ok(Self { swept, points, episodes })
    }

    /// The swept keys.
    pub fn swept(&self) -> &[String] {
        &self.swept
    }

    /// The points, in order.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Episodes per point.
    pub fn episodes(&self) -> u64 {
        self.episodes
    }

    /// Number of blocks.
    pub fn blocks(&self) -> u64 {
        self.points.len() as u64 * self.episodes
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.points.iter().map(|point| point.stacks.len() as u64 * self.episodes).sum()
    }

    /// Point and episode of a block.
    pub(super) fn position(&self, block: u64) -> (u32, u64) {
        assert!(block < self.blocks(), "block {block} of {}", self.blocks());
        let point = u32::try_from(block / self.episodes).expect("points are numbered with 32 bits");
        (point, block % self.episodes)
    }

    /// The stacks of a point.
    pub(super) fn stacks(&self, point: u32) -> &[String] {
        &self.points[point as usize].stacks
    }

    /// Whether `row` is the row of stack `stack` in the block (point, episode), or what it should say.
    pub(super) fn check(&self, row: &Row, point: u32, episode: u64, stack: usize, seed: u64) -> Result<(), String> {
        let Point { values, stacks } = &self.points[point as usize];
        let expected = &stacks[stack];
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
