//! A picture as a PDF of one page, which is as large as the picture. Texts stay texts, in the font that is built in: they can be searched,
//! and journals find every font embedded. Nothing of the clock or the machine is in the file.

use super::font;
use super::{Mark, Paint, Picture, Shape, Text};
use crate::geometry::Vec2;
use crate::report::palette::{Colour, PAPER};
use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{
    CidFontType, FontFlags, LineCapStyle, LineJoinStyle, SystemInfo, TextRenderingMode, UnicodeCmap,
};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str};

/// Points to a pixel: 96 pixels and 72 points are an inch.
const POINTS: f64 = 0.75;

/// Distance of the handles of a quarter of a circle from its ends, in radii: 4/3 (√2 − 1).
const QUARTER: f64 = 0.552_284_749_830_793_4;

/// The picture as a file of PDF.
pub fn pdf(picture: &Picture) -> Vec<u8> {
    let [catalog, pages, page, content] = [1, 2, 3, 4].map(Ref::new);
    let mut writer =
        Writer { content: Content::new(), height: picture.height, alphas: Vec::new(), letters: Default::default() };
    writer.content.transform([POINTS as f32, 0.0, 0.0, POINTS as f32, 0.0, 0.0]);
    for mark in &picture.marks {
        writer.mark(mark);
    }
    let Writer { content: operations, alphas, mut letters, .. } = writer;

    let mut pdf = Pdf::new();
    pdf.catalog(catalog).pages(pages);
    pdf.pages(pages).kids([page]).count(1);
    let mut sheet = pdf.page(page);
    sheet.media_box(Rect::new(0.0, 0.0, (picture.width * POINTS) as f32, (picture.height * POINTS) as f32));
    sheet.parent(pages).contents(content);
    // A colour space for what lets through what lies beneath it.
    sheet.group().transparency().isolated(true).color_space().device_rgb();
    let mut resources = sheet.resources();
    let mut fonts = resources.fonts();
    for bold in [false, true] {
        if !letters[usize::from(bold)].is_empty() {
            fonts.pair(Name(font_name(bold)), font_ref(bold, 0));
        }
    }
    fonts.finish();
    let mut states = resources.ext_g_states();
    for (index, alpha) in alphas.iter().enumerate() {
        let mut state =
            states.insert(Name(alpha_name(index).as_bytes())).start::<pdf_writer::writers::ExtGraphicsState<'_>>();
        state.stroking_alpha(*alpha as f32).non_stroking_alpha(*alpha as f32);
    }
    states.finish();
    resources.finish();
    sheet.finish();
    let operations = compress_to_vec_zlib(&operations.finish(), 9);
    pdf.stream(content, &operations).filter(Filter::FlateDecode);
    for bold in [false, true] {
        let letters = &mut letters[usize::from(bold)];
        if !letters.is_empty() {
            letters.sort_unstable();
            letters.dedup();
            embed(&mut pdf, bold, letters);
        }
    }
    pdf.finish()
}

fn font_name(bold: bool) -> &'static [u8] {
    if bold { b"Bold" } else { b"Regular" }
}

/// The objects of a font: itself, its glyphs, their description, its file, what its glyphs mean.
fn font_ref(bold: bool, part: i32) -> Ref {
    Ref::new(10 + 10 * i32::from(bold) + part)
}

fn alpha_name(index: usize) -> String {
    format!("A{index}")
}

/// Embeds one of the two fonts; `letters` are those in use with their glyphs, in order of the glyphs.
fn embed(pdf: &mut Pdf, bold: bool, letters: &[(u16, char)]) {
    let part = |part| font_ref(bold, part);
    let face = font::face(bold);
    let thousandths = |units: i16| f32::from(units) * 1000.0 / f32::from(face.units_per_em());
    let name = Name(if bold { b"SIMRUN+Arimo-Bold" } else { b"SIMRUN+Arimo-Regular" });
    let system = SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };
    pdf.type0_font(part(0))
        .base_font(name)
        .encoding_predefined(Name(b"Identity-H"))
        .descendant_font(part(1))
        .to_unicode(part(4));
    let mut glyphs = pdf.cid_font(part(1));
    glyphs.subtype(CidFontType::Type2).base_font(name).system_info(system).font_descriptor(part(2));
    glyphs.cid_to_gid_map_predefined(Name(b"Identity"));
    let advance = |glyph| {
        let units = face.glyph_hor_advance(ttf_parser::GlyphId(glyph)).unwrap_or(0);
        f32::from(units) * 1000.0 / f32::from(face.units_per_em())
    };
    glyphs.widths().consecutive(0, (0..face.number_of_glyphs()).map(advance));
    glyphs.finish();
    let bounds = face.global_bounding_box();
    pdf.font_descriptor(part(2))
        .name(name)
        .flags(FontFlags::NON_SYMBOLIC)
        .bbox(Rect::new(
            thousandths(bounds.x_min),
            thousandths(bounds.y_min),
            thousandths(bounds.x_max),
            thousandths(bounds.y_max),
        ))
        .italic_angle(0.0)
        .ascent(thousandths(face.ascender()))
        .descent(thousandths(face.descender()))
        .cap_height(thousandths(face.capital_height().unwrap_or(face.ascender())))
        .stem_v(if bold { 140.0 } else { 80.0 })
        .font_file2(part(3));
    let file = font::file(bold);
    let packed = compress_to_vec_zlib(file, 9);
    let mut stream = pdf.stream(part(3), &packed);
    stream.filter(Filter::FlateDecode);
    stream.pair(Name(b"Length1"), file.len() as i32);
    stream.finish();
    let mut meanings = UnicodeCmap::new(Name(b"Arimo"), system);
    for &(glyph, letter) in letters {
        meanings.pair(glyph, letter);
    }
    pdf.cmap(part(4), &meanings.finish());
}

struct Writer {
    content: Content,
    height: f64,
    /// Shares of opacity in use; each is a state with a name.
    alphas: Vec<f64>,
    /// Letters in use of the regular and the bold font, with their glyphs.
    letters: [Vec<(u16, char)>; 2],
}

impl Writer {
    /// In PDF y points up.
    fn at(&self, p: Vec2) -> (f32, f32) {
        (p.x as f32, (self.height - p.y) as f32)
    }

    fn mark(&mut self, mark: &Mark) {
        match mark {
            Mark::Shape(shape, paint) => self.shape(shape, paint),
            Mark::Text(text) => self.text(text),
            Mark::Clip(rect) => {
                self.content.save_state();
                let (x, y) = self.at(Vec2::new(rect.min.x, rect.max.y));
                self.content.rect(x, y, (rect.max.x - rect.min.x) as f32, (rect.max.y - rect.min.y) as f32);
                self.content.clip_nonzero().end_path();
            }
            Mark::Unclip => {
                self.content.restore_state();
            }
        }
    }

    fn alpha(&mut self, alpha: f64) {
        let known = self.alphas.iter().position(|known| *known == alpha);
        let index = known.unwrap_or_else(|| {
            self.alphas.push(alpha);
            self.alphas.len() - 1
        });
        self.content.set_parameters(Name(alpha_name(index).as_bytes()));
    }

    fn shape(&mut self, shape: &Shape, paint: &Paint) {
        if let Some((colour, alpha)) = paint.fill {
            self.alpha(alpha);
            let [r, g, b] = shares(colour);
            self.content.set_fill_rgb(r, g, b);
            self.outline(shape);
            self.content.fill_nonzero();
        }
        if let Some(stroke) = &paint.stroke {
            self.alpha(stroke.alpha);
            let [r, g, b] = shares(stroke.colour);
            self.content.set_stroke_rgb(r, g, b).set_line_width(stroke.width as f32);
            self.content.set_line_join(LineJoinStyle::RoundJoin);
            match stroke.dash {
                Some([dash, gap]) => {
                    self.content.set_line_cap(LineCapStyle::ButtCap);
                    self.content.set_dash_pattern([dash as f32, gap as f32], 0.0);
                }
                None => {
                    self.content.set_line_cap(LineCapStyle::RoundCap).set_dash_pattern([], 0.0);
                }
            }
            self.outline(shape);
            self.content.stroke();
        }
    }

    fn outline(&mut self, shape: &Shape) {
        match shape {
            Shape::Circle { centre, radius } => {
                let corner = |x: f64, y: f64| self.at(centre + Vec2::new(x, y) * *radius);
                let k = QUARTER;
                let quarters = [
                    [corner(1.0, k), corner(k, 1.0), corner(0.0, 1.0)],
                    [corner(-k, 1.0), corner(-1.0, k), corner(-1.0, 0.0)],
                    [corner(-1.0, -k), corner(-k, -1.0), corner(0.0, -1.0)],
                    [corner(k, -1.0), corner(1.0, -k), corner(1.0, 0.0)],
                ];
                let (x, y) = corner(1.0, 0.0);
                self.content.move_to(x, y);
                for [(x1, y1), (x2, y2), (x3, y3)] in quarters {
                    self.content.cubic_to(x1, y1, x2, y2, x3, y3);
                }
                self.content.close_path();
            }
            Shape::Lines { lines, closed } => {
                for line in lines {
                    for (index, p) in line.iter().enumerate() {
                        let (x, y) = self.at(*p);
                        if index == 0 {
                            self.content.move_to(x, y)
                        } else {
                            self.content.line_to(x, y)
                        };
                    }
                    if *closed && !line.is_empty() {
                        self.content.close_path();
                    }
                }
            }
        }
    }

    fn text(&mut self, text: &Text) {
        let glyphs: Vec<(u16, char)> =
            font::glyphs(&text.words, text.bold).map(|(letter, glyph, _)| (glyph.0, letter)).collect();
        let bytes: Vec<u8> = glyphs.iter().flat_map(|(glyph, _)| glyph.to_be_bytes()).collect();
        self.letters[usize::from(text.bold)].extend(&glyphs);
        self.alpha(1.0);
        let [r, g, b] = shares(text.colour);
        let (x, y) = self.at(text.at);
        let lead = text.lead() as f32;
        let place = if text.upward { [0.0, 1.0, -1.0, 0.0, x, y - lead] } else { [1.0, 0.0, 0.0, 1.0, x - lead, y] };
        let rim = text.rimmed.then(|| (2.0 * text.rim()) as f32);
        for rim in rim.map(Some).into_iter().chain([None]) {
            self.content.begin_text();
            self.content.set_font(Name(font_name(text.bold)), text.size as f32).set_text_matrix(place);
            match rim {
                Some(width) => {
                    let [r, g, b] = shares(PAPER);
                    self.content.set_text_rendering_mode(TextRenderingMode::Stroke);
                    self.content.set_stroke_rgb(r, g, b).set_line_width(width);
                    self.content.set_line_join(LineJoinStyle::RoundJoin).set_dash_pattern([], 0.0);
                }
                None => {
                    self.content.set_text_rendering_mode(TextRenderingMode::Fill).set_fill_rgb(r, g, b);
                }
            }
            self.content.show(Str(&bytes)).end_text();
        }
    }
}

fn shares(colour: Colour) -> [f32; 3] {
    [colour.r, colour.g, colour.b].map(|part| f32::from(part) / 255.0)
}

#[cfg(test)]
mod tests {
    use super::super::tests::page;
    use super::*;

    fn text_of(bytes: &[u8]) -> String {
        bytes.iter().map(|&byte| char::from(byte)).collect()
    }

    #[test]
    fn the_page_is_as_large_as_the_picture_and_has_the_fonts_of_its_texts() {
        let mut page = page();
        let plain = text_of(&pdf(&page));
        assert!(plain.starts_with("%PDF-") && plain.trim_end().ends_with("%%EOF"));
        assert!(plain.contains("/MediaBox [0 0 30 22.5]") && !plain.contains("Arimo"));
        page.text(Text::new(Vec2::new(1.0, 9.0), 8.0, "8 m"));
        let worded = text_of(&pdf(&page));
        assert!(worded.contains("Arimo-Regular") && !worded.contains("Arimo-Bold"));
        // What the glyphs mean, by which a reader finds the text: U+0038, the eight.
        assert!(worded.contains("<0038>"));
    }

    #[test]
    fn a_file_has_the_same_bytes_twice() {
        assert_eq!(pdf(&page()), pdf(&page()));
    }
}
