//! A picture as pixels and as PNG. The painter is portable: no instruction that only some processors have, no system font, so that a
//! picture has the same bytes everywhere.

use super::font::{self, Outlines, Pen};
use super::{Mark, Paint, Picture, Shape, Stroke, Text};
use crate::geometry::{Rect, Vec2};
use crate::report::palette::{Colour, PAPER};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use tiny_skia::{FillRule, LineCap, LineJoin, Mask, PathBuilder, Pixmap, StrokeDash, Transform};

/// Pixels, row by row from the top, three bytes each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Red, green and blue of each.
    pub rgb: Vec<u8>,
}

/// Sides of the largest image that is made, pixels.
const SIDE_MAX: f64 = 16_384.0;

/// Paints a picture with `scale` pixels for each of its own, at least 1 along each side and at most 16384.
pub fn raster(picture: &Picture, scale: f64) -> Pixels {
    let side = |length: f64| crate::math::clamp((length * scale).round(), 1.0, SIDE_MAX) as u32;
    let (width, height) = (side(picture.width), side(picture.height));
    let pixmap = Pixmap::new(width, height).expect("a bounded size");
    let mut brush = Brush { pixmap, scale: Transform::from_scale(scale as f32, scale as f32), mask: None };
    brush.pixmap.fill(paint_of(PAPER, 1.0));
    for mark in &picture.marks {
        match mark {
            Mark::Shape(shape, paint) => brush.shape(shape, paint),
            Mark::Text(text) => brush.text(text),
            Mark::Clip(rect) => brush.mask = brush.mask_of(*rect),
            Mark::Unclip => brush.mask = None,
        }
    }
    // Every pixel is opaque.
    let rgb = brush.pixmap.pixels().iter().flat_map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
    Pixels { width, height, rgb }
}

/// The pixels as a PNG.
pub fn png(pixels: &Pixels) -> Vec<u8> {
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    encoder.write_image(&pixels.rgb, pixels.width, pixels.height, ExtendedColorType::Rgb8).expect("an image");
    bytes
}

fn paint_of(colour: Colour, alpha: f64) -> tiny_skia::Color {
    let alpha = (crate::math::clamp(alpha, 0.0, 1.0) * 255.0).round() as u8;
    tiny_skia::Color::from_rgba8(colour.r, colour.g, colour.b, alpha)
}

struct Brush {
    pixmap: Pixmap,
    scale: Transform,
    mask: Option<Mask>,
}

impl Brush {
    fn mask_of(&self, rect: Rect) -> Option<Mask> {
        let Rect { min, max } = rect;
        let rect = tiny_skia::Rect::from_ltrb(min.x as f32, min.y as f32, max.x as f32, max.y as f32)?;
        let mut mask = Mask::new(self.pixmap.width(), self.pixmap.height())?;
        mask.fill_path(&PathBuilder::from_rect(rect), FillRule::Winding, false, self.scale);
        Some(mask)
    }

    fn shape(&mut self, shape: &Shape, paint: &Paint) {
        let mut path = PathBuilder::new();
        match shape {
            Shape::Circle { centre, radius } => path.push_circle(centre.x as f32, centre.y as f32, *radius as f32),
            Shape::Lines { lines, closed } => {
                for line in lines {
                    for (index, p) in line.iter().enumerate() {
                        if index == 0 { Outlines::move_to(&mut path, *p) } else { Outlines::line_to(&mut path, *p) }
                    }
                    if *closed && !line.is_empty() {
                        path.close();
                    }
                }
            }
        }
        let Some(path) = path.finish() else { return };
        if let Some((colour, alpha)) = paint.fill {
            self.fill(&path, colour, alpha);
        }
        if let Some(stroke) = &paint.stroke {
            self.stroke(&path, stroke);
        }
    }

    fn fill(&mut self, path: &tiny_skia::Path, colour: Colour, alpha: f64) {
        let mut paint = tiny_skia::Paint::default();
        paint.set_color(paint_of(colour, alpha));
        self.pixmap.fill_path(path, &paint, FillRule::Winding, self.scale, self.mask.as_ref());
    }

    fn stroke(&mut self, path: &tiny_skia::Path, stroke: &Stroke) {
        let mut paint = tiny_skia::Paint::default();
        paint.set_color(paint_of(stroke.colour, stroke.alpha));
        let pen = tiny_skia::Stroke {
            width: stroke.width as f32,
            line_cap: if stroke.dash.is_some() { LineCap::Butt } else { LineCap::Round },
            line_join: LineJoin::Round,
            dash: stroke.dash.and_then(|[dash, gap]| StrokeDash::new(vec![dash as f32, gap as f32], 0.0)),
            ..tiny_skia::Stroke::default()
        };
        self.pixmap.stroke_path(path, &paint, &pen, self.scale, self.mask.as_ref());
    }

    fn text(&mut self, text: &Text) {
        let face = font::face(text.bold);
        let mut path = PathBuilder::new();
        let scale = text.size / f64::from(face.units_per_em());
        for (_, glyph, at) in font::glyphs(&text.words, text.bold) {
            let origin = Vec2::new(at * text.size - text.lead(), 0.0);
            face.outline_glyph(glyph, &mut Pen { origin, scale, to: &mut path });
        }
        let Some(path) = path.finish() else { return };
        let (x, y) = (text.at.x as f32, text.at.y as f32);
        let place =
            if text.upward { Transform::from_row(0.0, -1.0, 1.0, 0.0, x, y) } else { Transform::from_translate(x, y) };
        let Some(path) = path.transform(place) else { return };
        if text.rimmed {
            self.stroke(&path, &Stroke { colour: PAPER, width: 2.0 * text.rim(), alpha: 1.0, dash: None });
        }
        self.fill(&path, text.colour, 1.0);
    }
}

impl Outlines for PathBuilder {
    fn move_to(&mut self, p: Vec2) {
        Self::move_to(self, p.x as f32, p.y as f32);
    }

    fn line_to(&mut self, p: Vec2) {
        Self::line_to(self, p.x as f32, p.y as f32);
    }

    fn quad_to(&mut self, by: Vec2, p: Vec2) {
        Self::quad_to(self, by.x as f32, by.y as f32, p.x as f32, p.y as f32);
    }

    fn close(&mut self) {
        Self::close(self);
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::page;
    use super::*;
    use crate::report::palette::{BLUE, ORANGE};

    fn colour(pixels: &Pixels, x: u32, y: u32) -> Colour {
        let at = 3 * (y * pixels.width + x) as usize;
        Colour { r: pixels.rgb[at], g: pixels.rgb[at + 1], b: pixels.rgb[at + 2] }
    }

    #[test]
    fn shapes_are_where_they_are_put_at_any_scale_and_clips_end_them() {
        for scale in [1_u32, 3] {
            let pixels = raster(&page(), f64::from(scale));
            assert_eq!((pixels.width, pixels.height), (40 * scale, 30 * scale));
            for (x, y, expected) in
                [(10, 5, ORANGE), (19, 14, ORANGE), (9, 5, PAPER), (20, 15, PAPER), (29, 20, BLUE), (31, 20, PAPER)]
            {
                assert_eq!(colour(&pixels, x * scale, y * scale), expected, "{x}, {y} at {scale}");
            }
        }
    }

    /// An `l` of Arimo is a bar from the base line to the ascender; upward it lies.
    #[test]
    fn letters_stand_on_their_base_line() {
        let mut upright = Picture::new(40.0, 40.0);
        upright.text(Text::new(Vec2::new(10.0, 30.0), 20.0, "l"));
        let mut lying = Picture::new(40.0, 40.0);
        lying.text(Text { upward: true, ..Text::new(Vec2::new(30.0, 20.0), 20.0, "l") });
        let dark = |picture: &Picture| {
            let pixels = raster(picture, 1.0);
            let spots: Vec<(u32, u32)> =
                (0..1600).map(|at| (at % 40, at / 40)).filter(|&(x, y)| colour(&pixels, x, y).r < 120).collect();
            let span = |of: &dyn Fn(&(u32, u32)) -> u32| {
                let values = || spots.iter().map(of);
                (values().min().unwrap(), values().max().unwrap())
            };
            (span(&|spot| spot.0), span(&|spot| spot.1))
        };
        let ((left, right), (top, bottom)) = dark(&upright);
        assert!(left >= 10 && right <= 14 && (14..=17).contains(&top) && bottom == 29, "{left} {right} {top} {bottom}");
        let ((left, right), (top, bottom)) = dark(&lying);
        assert!((14..=17).contains(&left) && right == 29 && top >= 15 && bottom <= 19, "{left} {right} {top} {bottom}");
    }

    #[test]
    fn a_png_holds_the_pixels() {
        let pixels = raster(&page(), 1.0);
        let read = image::load_from_memory(&png(&pixels)).unwrap().into_rgb8();
        assert_eq!((read.width(), read.height()), (40, 30));
        assert!(read.into_raw() == pixels.rgb);
    }
}
