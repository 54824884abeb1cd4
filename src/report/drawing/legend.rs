//! The legend beneath a map: what each mark means, in lines as wide as the page.

use crate::geometry::Vec2;
use crate::math;
use crate::report::picture::{Picture, Text, font};

const SIZE: f64 = 11.0;
const LINE: f64 = 18.0;
const GAP: f64 = 16.0;
/// Width of a mark, if it has no other.
const MARK: f64 = 22.0;

type Draw = Box<dyn Fn(&mut Picture, Vec2)>;

struct Entry {
    width: f64,
    draw: Draw,
    words: String,
}

impl Entry {
    fn width(&self) -> f64 {
        self.width + 5.0 + font::width(&self.words, SIZE, false)
    }
}

/// What the marks of a picture mean.
#[derive(Default)]
pub(super) struct Legend {
    entries: Vec<Entry>,
}

impl Legend {
    /// Adds a mark, painted about the point that it is given, and what it means.
    pub fn add(&mut self, words: impl Into<String>, draw: impl Fn(&mut Picture, Vec2) + 'static) {
        self.add_wide(MARK, words, draw);
    }

    /// The same for a mark of another width.
    pub fn add_wide(&mut self, width: f64, words: impl Into<String>, draw: impl Fn(&mut Picture, Vec2) + 'static) {
        self.entries.push(Entry { width, draw: Box::new(draw), words: words.into() });
    }

    /// Width of the widest entry.
    pub fn width(&self) -> f64 {
        self.entries.iter().map(Entry::width).fold(0.0, math::max)
    }

    /// Paints it with its upper left corner at `corner` and at most `width` wide, one entry to a line if none else has room; returns its height.
    pub fn paint(&self, page: &mut Picture, corner: Vec2, width: f64) -> f64 {
        let (mut x, mut y) = (0.0, 0.0);
        for entry in &self.entries {
            let takes = entry.width();
            if x > 0.0 && x + takes > width {
                (x, y) = (0.0, y + LINE);
            }
            let middle = corner + Vec2::new(x + 0.5 * entry.width, y + 0.5 * LINE);
            (entry.draw)(page, middle);
            let words = Vec2::new(corner.x + x + entry.width + 5.0, middle.y + 0.36 * SIZE);
            page.text(Text::new(words, SIZE, entry.words.as_str()));
            x += takes + GAP;
        }
        if self.entries.is_empty() { 0.0 } else { y + LINE }
    }
}
