//! A picture: shapes and texts in pixels, y down, painted one over the other. It knows nothing of robots. The files beside this one write
//! it as SVG, as pixels, as PDF and as GIF; all take their letters from the font that is built in, so that each looks the same everywhere.

pub mod font;
mod gif;
mod pdf;
mod raster;
mod svg;

use super::palette::{Colour, INK, PAPER};
use crate::geometry::{Rect, Vec2};

pub use gif::gif;
pub use pdf::pdf;
pub use raster::{Pixels, png, raster};
pub use svg::svg;

/// Shapes and texts on a white page. Lengths are in pixels at scale 1, y points down.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Width of the page.
    pub width: f64,
    /// Height of the page.
    pub height: f64,
    marks: Vec<Mark>,
}

/// One thing that is painted.
#[derive(Clone, Debug)]
enum Mark {
    Shape(Shape, Paint),
    Text(Text),
    /// From here on nothing is painted outside this rectangle.
    Clip(Rect),
    /// The last `Clip` ends.
    Unclip,
}

/// An outline.
#[derive(Clone, Debug)]
enum Shape {
    Circle {
        centre: Vec2,
        radius: f64,
    },
    /// Lines through points; a filled or closed one returns to its first.
    Lines {
        lines: Vec<Vec<Vec2>>,
        closed: bool,
    },
}

/// How an outline is painted: filled, drawn along, or both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Paint {
    fill: Option<(Colour, f64)>,
    stroke: Option<Stroke>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Stroke {
    colour: Colour,
    width: f64,
    alpha: f64,
    /// Length of dashes and of the gaps between them.
    dash: Option<[f64; 2]>,
}

impl Paint {
    /// Filled.
    pub const fn fill(colour: Colour) -> Self {
        Self { fill: Some((colour, 1.0)), stroke: None }
    }

    /// Drawn along with a pen of this width.
    pub const fn line(colour: Colour, width: f64) -> Self {
        Self { fill: None, stroke: Some(Stroke { colour, width, alpha: 1.0, dash: None }) }
    }

    /// Also drawn along with a pen of this width.
    #[must_use]
    pub const fn edged(self, colour: Colour, width: f64) -> Self {
        Self { stroke: Self::line(colour, width).stroke, ..self }
    }

    /// The line in dashes.
    #[must_use]
    pub fn dashed(mut self, dash: f64, gap: f64) -> Self {
        if let Some(stroke) = &mut self.stroke {
            stroke.dash = Some([dash, gap]);
        }
        self
    }

    /// Lets through what lies beneath: fill and line so far by this share, from 0 (nothing is left of them) to 1.
    #[must_use]
    pub fn faded(mut self, alpha: f64) -> Self {
        if let Some((_, of_fill)) = &mut self.fill {
            *of_fill *= alpha;
        }
        if let Some(stroke) = &mut self.stroke {
            stroke.alpha *= alpha;
        }
        self
    }
}

/// Where a text lies about its point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Anchor {
    /// It begins there.
    #[default]
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// One line of text.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    /// Where its base line begins, is half or ends.
    pub at: Vec2,
    /// The words.
    pub words: String,
    /// Height of the letters: the font's em.
    pub size: f64,
    /// Where it lies about its point.
    pub anchor: Anchor,
    /// Colour of the letters.
    pub colour: Colour,
    /// Whether the letters are bold.
    pub bold: bool,
    /// Whether it is read from below upwards.
    pub upward: bool,
    /// Whether the letters have a rim of the page's colour, so that they can be read over lines.
    pub rimmed: bool,
}

impl Text {
    /// A plain text that begins at a point.
    pub fn new(at: Vec2, size: f64, words: impl Into<String>) -> Self {
        Self {
            at,
            words: words.into(),
            size,
            anchor: Anchor::Start,
            colour: INK,
            bold: false,
            upward: false,
            rimmed: false,
        }
    }

    /// The same about another point of the text.
    #[must_use]
    pub fn anchored(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// The same in another colour.
    #[must_use]
    pub fn coloured(self, colour: Colour) -> Self {
        Self { colour, ..self }
    }

    /// Width of the rim on each side of a line of a letter.
    fn rim(&self) -> f64 {
        if self.rimmed { 0.14 * self.size } else { 0.0 }
    }

    /// How far left of its point the text begins.
    fn lead(&self) -> f64 {
        let width = font::width(&self.words, self.size, self.bold);
        match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5 * width,
            Anchor::End => width,
        }
    }
}

impl Picture {
    /// An empty page.
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, marks: Vec::new() }
    }

    /// A circle.
    pub fn circle(&mut self, centre: Vec2, radius: f64, paint: Paint) {
        self.marks.push(Mark::Shape(Shape::Circle { centre, radius }, paint));
    }

    /// A line through points that ends at the last.
    pub fn line(&mut self, points: Vec<Vec2>, paint: Paint) {
        self.lines(vec![points], paint);
    }

    /// Lines through points, as one thing: where they cross, a faded colour is not laid on twice.
    pub fn lines(&mut self, lines: Vec<Vec<Vec2>>, paint: Paint) {
        self.marks.push(Mark::Shape(Shape::Lines { lines, closed: false }, paint));
    }

    /// An area with one or several borders; a border that runs the other way round than the one about it is a hole.
    pub fn area(&mut self, borders: Vec<Vec<Vec2>>, paint: Paint) {
        self.marks.push(Mark::Shape(Shape::Lines { lines: borders, closed: true }, paint));
    }

    /// A rectangle.
    pub fn rect(&mut self, rect: Rect, paint: Paint) {
        let Rect { min, max } = rect;
        let corners = vec![min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)];
        self.area(vec![corners], paint);
    }

    /// A text.
    pub fn text(&mut self, text: Text) {
        if !text.words.is_empty() {
            self.marks.push(Mark::Text(text));
        }
    }

    /// What `paint` paints, and nothing of it outside `rect`.
    pub fn clipped(&mut self, rect: Rect, paint: impl FnOnce(&mut Self)) {
        self.marks.push(Mark::Clip(rect));
        paint(self);
        self.marks.push(Mark::Unclip);
    }

    /// The colours in use, each once, the page's first.
    pub fn colours(&self) -> Vec<Colour> {
        let mut colours = vec![PAPER];
        let mut add = |colour: Colour| {
            if !colours.contains(&colour) {
                colours.push(colour);
            }
        };
        for mark in &self.marks {
            match mark {
                Mark::Shape(_, paint) => {
                    paint.fill.iter().for_each(|(colour, _)| add(*colour));
                    paint.stroke.iter().for_each(|stroke| add(stroke.colour));
                }
                Mark::Text(text) => add(text.colour),
                Mark::Clip(_) | Mark::Unclip => {}
            }
        }
        colours
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::report::palette::{BLUE, ORANGE};

    /// A page of 40 x 30 with an orange square from (10, 5) to (20, 15) and a blue disc that is cut off at x = 30.
    pub fn page() -> Picture {
        let mut page = Picture::new(40.0, 30.0);
        page.rect(Rect { min: Vec2::new(10.0, 5.0), max: Vec2::new(20.0, 15.0) }, Paint::fill(ORANGE));
        page.clipped(Rect { min: Vec2::new(0.0, 0.0), max: Vec2::new(30.0, 30.0) }, |page| {
            page.circle(Vec2::new(30.0, 20.0), 6.0, Paint::fill(BLUE));
        });
        page
    }

    #[test]
    fn colours_are_listed_once() {
        let mut page = page();
        page.line(vec![Vec2::zeros(), Vec2::new(9.0, 9.0)], Paint::line(BLUE, 1.0));
        assert_eq!(page.colours(), [PAPER, ORANGE, BLUE]);
    }

    #[test]
    fn paint_fades_by_the_product() {
        let paint = Paint::fill(BLUE).faded(0.5).edged(ORANGE, 2.0).faded(0.5);
        assert_eq!(paint.fill, Some((BLUE, 0.25)));
        assert_eq!(paint.stroke.map(|stroke| stroke.alpha), Some(0.5));
    }
}
