//! A picture as SVG.

use super::font::FAMILY;
use super::{Anchor, Mark, Paint, Picture, Shape, Text};
use crate::geometry::Vec2;
use crate::report::palette::{INK, PAPER};
use std::fmt::{self, Write as _};

/// The picture as a file of SVG, ended by a line break. It has a view box and no size: it fills the width that it is given.
pub fn svg(picture: &Picture) -> String {
    let (width, height) = (Number(picture.width), Number(picture.height));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"{FAMILY}\" fill=\"{INK}\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"{PAPER}\"/>\n"
    );
    let mut clips = 0;
    for mark in &picture.marks {
        // Writing to a text does not fail.
        let _ = match mark {
            Mark::Shape(Shape::Circle { centre, radius }, paint) => {
                let (x, y, r) = (Number(centre.x), Number(centre.y), Number(*radius));
                writeln!(svg, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"{}/>", Style(paint))
            }
            Mark::Shape(Shape::Lines { lines, closed }, paint) => {
                writeln!(svg, "<path d=\"{}\"{}/>", Data { lines, closed: *closed }, Style(paint))
            }
            Mark::Text(text) => writeln!(svg, "{}", Words(text)),
            Mark::Clip(rect) => {
                clips += 1;
                let (x, y) = (Number(rect.min.x), Number(rect.min.y));
                let (w, h) = (Number(rect.max.x - rect.min.x), Number(rect.max.y - rect.min.y));
                writeln!(
                    svg,
                    "<clipPath id=\"clip{clips}\"><rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/></clipPath>\n\
                     <g clip-path=\"url(#clip{clips})\">"
                )
            }
            Mark::Unclip => writeln!(svg, "</g>"),
        };
    }
    svg.push_str("</svg>\n");
    svg
}

/// A number to the hundredth, without zeros at its end.
struct Number(f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", crate::math::canonical((self.0 * 100.0).round() / 100.0))
    }
}

struct Data<'a> {
    lines: &'a [Vec<Vec2>],
    closed: bool,
}

impl fmt::Display for Data<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for line in self.lines {
            let mut last = None;
            for p in line {
                let (x, y) = (Number(p.x), Number(p.y));
                match last {
                    None => write!(f, "M{x} {y}"),
                    Some(Vec2 { .. }) if last == Some(*p) => Ok(()),
                    Some(before) if before.y == p.y => write!(f, "H{x}"),
                    Some(before) if before.x == p.x => write!(f, "V{y}"),
                    Some(_) => write!(f, "L{x} {y}"),
                }?;
                last = Some(*p);
            }
            if self.closed {
                f.write_str("z")?;
            }
        }
        Ok(())
    }
}

/// The attributes of a paint.
struct Style<'a>(&'a Paint);

impl fmt::Display for Style<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let faded = |alpha: f64| alpha < 1.0;
        match self.0.fill {
            None => f.write_str(" fill=\"none\"")?,
            Some((colour, alpha)) => {
                write!(f, " fill=\"{colour}\"")?;
                if faded(alpha) {
                    write!(f, " fill-opacity=\"{}\"", Number(alpha))?;
                }
            }
        }
        let Some(stroke) = self.0.stroke else { return Ok(()) };
        write!(f, " stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"", stroke.colour, Number(stroke.width))?;
        match stroke.dash {
            Some([dash, gap]) => write!(f, " stroke-dasharray=\"{} {}\"", Number(dash), Number(gap))?,
            None => f.write_str(" stroke-linecap=\"round\"")?,
        }
        if faded(stroke.alpha) {
            write!(f, " stroke-opacity=\"{}\"", Number(stroke.alpha))?;
        }
        Ok(())
    }
}

struct Words<'a>(&'a Text);

impl fmt::Display for Words<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.0;
        let (x, y) = (Number(text.at.x), Number(text.at.y));
        write!(f, "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\"", Number(text.size))?;
        match text.anchor {
            Anchor::Start => {}
            Anchor::Middle => f.write_str(" text-anchor=\"middle\"")?,
            Anchor::End => f.write_str(" text-anchor=\"end\"")?,
        }
        if text.colour != INK {
            write!(f, " fill=\"{}\"", text.colour)?;
        }
        if text.bold {
            f.write_str(" font-weight=\"700\"")?;
        }
        if text.upward {
            write!(f, " transform=\"rotate(-90 {x} {y})\"")?;
        }
        if text.rimmed {
            let rim = Number(2.0 * text.rim());
            write!(f, " paint-order=\"stroke\" stroke=\"{PAPER}\" stroke-width=\"{rim}\" stroke-linejoin=\"round\"")?;
        }
        write!(f, ">{}</text>", escape(&text.words))
    }
}

/// Text of XML: signs that would be read as marks are escaped, those that XML does not know are a box.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '\u{fffe}' | '\u{ffff}' => escaped.push('\u{25a1}'),
            _ if letter.is_control() => escaped.push('\u{25a1}'),
            _ => escaped.push(letter),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_escaped() {
        assert_eq!(escape("a<b & c>\u{7}"), "a&lt;b &amp; c&gt;\u{25a1}");
    }

    #[test]
    fn numbers_have_two_decimals_at_most() {
        assert_eq!([1.0, 0.125, -0.001, 12.5].map(|x| Number(x).to_string()), ["1", "0.13", "0", "12.5"]);
    }

    #[test]
    fn a_page_is_one_element_with_what_is_on_it() {
        let svg = svg(&super::super::tests::page());
        assert_eq!(
            svg.lines().skip(2).collect::<Vec<_>>(),
            [
                "<path d=\"M10 5H20V15H10z\" fill=\"#e69f00\"/>",
                "<clipPath id=\"clip1\"><rect x=\"0\" y=\"0\" width=\"30\" height=\"30\"/></clipPath>",
                "<g clip-path=\"url(#clip1)\">",
                "<circle cx=\"30\" cy=\"20\" r=\"6\" fill=\"#0072b2\"/>",
                "</g>",
                "</svg>",
            ]
        );
    }
}
