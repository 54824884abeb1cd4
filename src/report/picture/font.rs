//! The font of all pictures: Arimo, whose letters are as wide as those of Arial, Helvetica and Liberation Sans, so that a picture whose
//! reader has one of those looks the same. Two subsets are built in (Latin 1, signs, some Greek); `LICENSES/README.md` says how they were made.

use crate::geometry::Vec2;
use std::sync::OnceLock;
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// The font and those that stand in for it, as CSS and SVG name them.
pub const FAMILY: &str = "Arimo, Arial, 'Liberation Sans', Helvetica, sans-serif";

/// The file of the regular or the bold letters.
pub(super) fn file(bold: bool) -> &'static [u8] {
    if bold { include_bytes!("font/Arimo-Bold.ttf") } else { include_bytes!("font/Arimo-Regular.ttf") }
}

pub(super) fn face(bold: bool) -> &'static Face<'static> {
    static FACES: [OnceLock<Face<'static>>; 2] = [OnceLock::new(), OnceLock::new()];
    FACES[usize::from(bold)].get_or_init(|| Face::parse(file(bold), 0).expect("a font"))
}

/// The glyphs of a text, each with where it begins, in units of the em from the beginning of the text. A letter that the font does not have
/// is its box.
pub(super) fn glyphs(words: &str, bold: bool) -> impl Iterator<Item = (char, GlyphId, f64)> {
    let face = face(bold);
    let em = f64::from(face.units_per_em());
    words.chars().scan(0.0, move |pen, letter| {
        let glyph = face.glyph_index(letter).unwrap_or(GlyphId(0));
        let at = *pen;
        *pen += f64::from(face.glyph_hor_advance(glyph).unwrap_or(0)) / em;
        Some((letter, glyph, at))
    })
}

/// Width of a text, in the unit of `size`.
pub fn width(words: &str, size: f64, bold: bool) -> f64 {
    let face = face(bold);
    let advance = |letter| face.glyph_hor_advance(face.glyph_index(letter).unwrap_or(GlyphId(0))).unwrap_or(0);
    let units: u64 = words.chars().map(|letter| u64::from(advance(letter))).sum();
    units as f64 * size / f64::from(face.units_per_em())
}

/// The words in lines of at most this width, cut at spaces; a word that is wider has a line of its own.
pub fn wrapped(words: &str, size: f64, bold: bool, width_max: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width(line, size, bold) + width(" ", size, bold) + width(word, size, bold) <= width_max => {
                *line += " ";
                *line += word;
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Takes the outline of a glyph, its origin at `origin`, y down.
pub(super) struct Pen<'a, T> {
    pub origin: Vec2,
    pub scale: f64,
    pub to: &'a mut T,
}

/// What a glyph is drawn with.
pub(super) trait Outlines {
    fn move_to(&mut self, p: Vec2);
    fn line_to(&mut self, p: Vec2);
    fn quad_to(&mut self, by: Vec2, p: Vec2);
    fn close(&mut self);
}

impl<T> Pen<'_, T> {
    fn at(&self, x: f32, y: f32) -> Vec2 {
        self.origin + Vec2::new(f64::from(x), -f64::from(y)) * self.scale
    }
}

impl<T: Outlines> OutlineBuilder for Pen<'_, T> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.to.move_to(self.at(x, y));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.to.line_to(self.at(x, y));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.to.quad_to(self.at(x1, y1), self.at(x, y));
    }

    // TrueType has none: the chord.
    fn curve_to(&mut self, _: f32, _: f32, _: f32, _: f32, x: f32, y: f32) {
        self.to.line_to(self.at(x, y));
    }

    fn close(&mut self) {
        self.to.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Widths of Helvetica in its Adobe metrics, thousandths of an em: 0 556, m 833, i 222, . 278, W 944; bold m 889.
    #[test]
    fn letters_are_as_wide_as_those_of_helvetica() {
        for (letter, bold, expected) in [
            ("0", false, 556.0),
            ("m", false, 833.0),
            ("i", false, 222.0),
            (".", false, 278.0),
            ("W", false, 944.0),
            ("m", true, 889.0),
        ] {
            let found = width(letter, 1000.0, bold);
            assert!((found - expected).abs() < 1.0, "{letter}: {found}");
        }
    }

    #[test]
    fn what_the_font_lacks_is_a_box() {
        assert!(width("\u{4ed6}", 10.0, false) > 0.0);
        assert!(face(false).glyph_index('\u{2212}').is_some());
    }

    #[test]
    fn words_are_wrapped_at_spaces() {
        let lines = wrapped("one two three incomprehensibilities", 10.0, false, 45.0);
        assert_eq!(lines, ["one two", "three", "incomprehensibilities"]);
    }
}
