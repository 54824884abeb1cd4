//! What charts are drawn on: a text of SVG with a size.

use std::fmt::Write as _;

/// Which part of a text stands at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

impl Anchor {
    fn attribute(self) -> &'static str {
        match self {
            Self::Start => "",
            Self::Middle => " text-anchor=\"middle\"",
            Self::End => " text-anchor=\"end\"",
        }
    }
}

/// A picture that is being drawn; places are pixels from the top left corner, y down.
#[derive(Clone, Debug)]
pub struct Drawing {
    body: String,
    width_px: f64,
    height_px: f64,
}

impl Drawing {
    /// An empty picture.
    pub fn new(width_px: f64, height_px: f64) -> Self {
        Self { body: String::new(), width_px, height_px }
    }

    /// Its width, px.
    pub fn width_px(&self) -> f64 {
        self.width_px
    }

    /// Its height, px.
    pub fn height_px(&self) -> f64 {
        self.height_px
    }

    /// Appends any other SVG.
    pub fn raw(&mut self, svg: &str) {
        self.body.push_str(svg);
    }

    /// A straight line.
    pub fn line(&mut self, (x1, y1): (f64, f64), (x2, y2): (f64, f64), colour: &str, width_px: f64) {
        let data = format!("M{} {}L{} {}", Px(x1), Px(y1), Px(x2), Px(y2));
        self.path(&data, &format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\"", Px(width_px)));
    }

    /// A line through points.
    pub fn polyline(&mut self, points: &[(f64, f64)], style: &str) {
        let mut data = String::with_capacity(points.len() * 12);
        for (at, &(x, y)) in points.iter().enumerate() {
            let _ = write!(data, "{}{} {}", if at == 0 { 'M' } else { 'L' }, Px(x), Px(y));
        }
        self.path(&data, style);
    }

    /// A path of SVG's own language.
    pub fn path(&mut self, data: &str, style: &str) {
        let _ = writeln!(self.body, "<path d=\"{data}\" {style}/>");
    }

    /// A filled rectangle.
    pub fn rect(&mut self, (x, y): (f64, f64), (width, height): (f64, f64), style: &str) {
        let (x, y, width, height) = (Px(x), Px(y), Px(width), Px(height));
        let _ = writeln!(self.body, "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" {style}/>");
    }

    /// Round dots of one look, as one element: many points stay small.
    pub fn dots(&mut self, points: impl IntoIterator<Item = (f64, f64)>, radius_px: f64, colour: &str, opacity: f64) {
        let mut data = String::new();
        for (x, y) in points {
            let _ = write!(data, "M{} {}h0", Px(x), Px(y));
        }
        if !data.is_empty() {
            let width = Px(2.0 * radius_px);
            self.path(
                &data,
                &format!(
                    "fill=\"none\" stroke=\"{colour}\" stroke-opacity=\"{opacity}\" stroke-width=\"{width}\" stroke-linecap=\"round\""
                ),
            );
        }
    }

    /// A text of `size_px`; it is escaped here.
    pub fn text(&mut self, (x, y): (f64, f64), anchor: Anchor, size_px: f64, colour: &str, text: &str) {
        let (x, y, size, anchor) = (Px(x), Px(y), Px(size_px), anchor.attribute());
        let text = escape(text);
        let _ = writeln!(
            self.body,
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" fill=\"{colour}\"{anchor}>{text}</text>"
        );
    }

    /// The picture as an element of a page, or a file of its own. `says` is what it shows, in words, for those who cannot see it.
    pub fn finish(self, says: &str) -> String {
        let (width, height, says) = (Px(self.width_px), Px(self.height_px), escape(says));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{says}\" \
             font-family=\"system-ui, -apple-system, 'Segoe UI', Roboto, Helvetica, Arial, sans-serif\">\n{}</svg>\n",
            self.body
        )
    }
}

/// A length in a file: to a tenth of a pixel, without needless digits.
pub(super) struct Px(pub(super) f64);

impl std::fmt::Display for Px {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let tenths = (self.0 * 10.0).round() as i64;
        let (sign, tenths) = if tenths < 0 { ("-", -tenths) } else { ("", tenths) };
        if tenths % 10 == 0 {
            write!(f, "{sign}{}", tenths / 10)
        } else {
            write!(f, "{sign}{}.{}", tenths / 10, tenths % 10)
        }
    }
}

/// A text inside a document: nothing in it is markup, and no character of it is one that XML forbids.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            '\n' | '\t' => out.push(c),
            c if c.is_control() || c == '\u{fffe}' || c == '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// About how wide a text is, px: enough to keep labels apart, in any of the usual faces.
pub fn text_width_px(text: &str, size_px: f64) -> f64 {
    let em = |c: char| match c {
        'i' | 'j' | 'l' | 't' | 'f' | 'r' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' | '(' | ')' | '[' | ']' => 0.33,
        ' ' => 0.3,
        '\u{2009}' => 0.17,
        'm' | 'w' | 'M' | 'W' | '%' | '@' => 0.88,
        'A'..='Z' => 0.67,
        c if c.is_ascii() => 0.56,
        _ => 0.8,
    };
    text.chars().map(em).sum::<f64>() * size_px
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_no_markup() {
        assert_eq!(escape("a<b & \"c\"\u{1}'"), "a&lt;b &amp; &quot;c&quot;\u{fffd}&#39;");
        let mut drawing = Drawing::new(10.0, 10.0);
        drawing.text((1.0, 2.0), Anchor::End, 10.0, "#000", "</svg><script>");
        let svg = drawing.finish("a \"b\"");
        assert!(!svg.contains("<script>") && svg.contains("aria-label=\"a &quot;b&quot;\""), "{svg}");
    }

    #[test]
    fn lengths_are_short() {
        let shown = [1.0, 0.05, -0.04, -2.36, 12.349].map(|x| Px(x).to_string());
        assert_eq!(shown, ["1", "0.1", "0", "-2.4", "12.3"]);
    }
}
