//! Pictures one after the other as a GIF that plays for ever.
//!
//! The colours are chosen once for the whole film, by counting: the most frequent first, none too like another. Each frame holds the
//! rectangle that has changed, and in it what has not changed is transparent, which packs well.

use super::{Picture, raster};
use gif::{DisposalMethod, Encoder, Frame, Repeat};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Colours of a film at most; one more index stands for what has not changed.
const COLOURS_MAX: usize = 127;
/// Frames that are looked at for the choice of colours.
const LOOKED_AT: usize = 12;
/// Colours of which every part differs by less than this are one.
const ALIKE: i32 = 10;

type Rgb = [u8; 3];

/// A film of `count` pictures of one size, at least one and at most 65535 pixels along each side. `picture` paints each, `shown_cs` says for how long it is shown, hundredths of a
/// second. A picture that looks like the one before makes that one stay longer.
pub fn gif(count: usize, picture: &dyn Fn(usize) -> Picture, shown_cs: &dyn Fn(usize) -> u16, scale: f64) -> Vec<u8> {
    let looked_at = (0..LOOKED_AT).map(|k| k * count.saturating_sub(1) / (LOOKED_AT - 1));
    let colours = Colours::of(looked_at.map(|index| raster(&picture(index), scale).rgb));
    let transparent = colours.palette.len() as u8;
    let mut nearest = BTreeMap::new();
    let mut frames: Vec<Frame<'static>> = Vec::new();
    let mut before: Vec<u8> = Vec::new();
    let mut size = (1, 1);
    for index in 0..count {
        let pixels = raster(&picture(index), scale);
        size = (pixels.width as u16, pixels.height as u16);
        let now: Vec<u8> = pixels
            .rgb
            .as_chunks()
            .0
            .iter()
            .map(|rgb| *nearest.entry(*rgb).or_insert_with(|| colours.nearest(*rgb)))
            .collect();
        let shown = shown_cs(index);
        match changed(&before, &now, usize::from(size.0)) {
            None => {
                if let Some(last) = frames.last_mut() {
                    last.delay = last.delay.saturating_add(shown);
                }
            }
            Some(part) => frames.push(Frame {
                delay: shown,
                dispose: DisposalMethod::Keep,
                transparent: (!before.is_empty()).then_some(transparent),
                left: part.left as u16,
                top: part.top as u16,
                width: part.width as u16,
                height: part.height as u16,
                buffer: Cow::Owned(part.cut(&before, &now, usize::from(size.0), transparent)),
                ..Frame::default()
            }),
        }
        before = now;
    }
    let palette: Vec<u8> = colours.palette.iter().flatten().copied().chain([0; 3]).collect();
    let mut encoder = Encoder::new(Vec::new(), size.0, size.1, &palette).expect("a palette of at most 128");
    encoder.set_repeat(Repeat::Infinite).expect("a block in memory");
    for frame in &frames {
        encoder.write_frame(frame).expect("a frame within its size");
    }
    encoder.into_inner().expect("an end in memory")
}

/// The colours of a film.
struct Colours {
    palette: Vec<Rgb>,
}

impl Colours {
    /// Chosen from all pixels of some frames.
    fn of(frames: impl Iterator<Item = Vec<u8>>) -> Self {
        let mut counts: BTreeMap<Rgb, u64> = BTreeMap::new();
        for frame in frames {
            for rgb in frame.as_chunks().0 {
                *counts.entry(*rgb).or_default() += 1;
            }
        }
        let mut by_count: Vec<(Rgb, u64)> = counts.into_iter().collect();
        // Ties stay in the order of the colours.
        by_count.sort_by_key(|&(_, count)| core::cmp::Reverse(count));
        let mut palette: Vec<Rgb> = Vec::new();
        for (rgb, _) in by_count {
            if palette.len() < COLOURS_MAX && palette.iter().all(|known| !alike(*known, rgb)) {
                palette.push(rgb);
            }
        }
        Self { palette }
    }

    fn nearest(&self, rgb: Rgb) -> u8 {
        let distance =
            |known: &Rgb| -> i32 { (0..3).map(|part| (i32::from(known[part]) - i32::from(rgb[part])).pow(2)).sum() };
        let nearest = self.palette.iter().enumerate().min_by_key(|(_, known)| distance(known));
        nearest.map_or(0, |(index, _)| index as u8)
    }
}

fn alike(a: Rgb, b: Rgb) -> bool {
    (0..3).all(|part| (i32::from(a[part]) - i32::from(b[part])).abs() < ALIKE)
}

/// A rectangle of pixels.
#[derive(Debug, PartialEq, Eq)]
struct Part {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

/// The smallest rectangle that holds all that differs; all of `now` if nothing was before.
fn changed(before: &[u8], now: &[u8], width: usize) -> Option<Part> {
    if before.is_empty() {
        return Some(Part { left: 0, top: 0, width, height: now.len() / width });
    }
    let differing = || (0..now.len()).filter(|&at| before[at] != now[at]);
    let (top, bottom) = (differing().next()? / width, differing().next_back()? / width);
    let (left, right) = differing().fold((width, 0), |(left, right), at| (left.min(at % width), right.max(at % width)));
    Some(Part { left, top, width: right - left + 1, height: bottom - top + 1 })
}

impl Part {
    /// The part of `now`, transparent where it is as before.
    fn cut(&self, before: &[u8], now: &[u8], width: usize, transparent: u8) -> Vec<u8> {
        let rows = self.top..self.top + self.height;
        let places = rows.flat_map(|row| (self.left..self.left + self.width).map(move |col| row * width + col));
        places.map(|at| if before.get(at) == Some(&now[at]) { transparent } else { now[at] }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Paint, Picture};
    use super::*;
    use crate::geometry::Vec2;
    use crate::report::palette::{BLUE, PAPER};

    /// A disc that stands on two frames and then steps to the right.
    fn steps(index: usize) -> Picture {
        let mut page = Picture::new(40.0, 20.0);
        page.circle(Vec2::new(10.0 + 10.0 * index.saturating_sub(1) as f64, 10.0), 4.0, Paint::fill(BLUE));
        page
    }

    #[test]
    fn a_reader_sees_the_pictures_one_after_the_other() {
        let bytes = gif(4, &steps, &|index| if index == 3 { 100 } else { 8 }, 1.0);
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut reader = options.read_info(&bytes[..]).unwrap();
        assert_eq!((reader.width(), reader.height()), (40, 20));
        let mut screen = vec![[0; 4]; 800];
        let mut delays = Vec::new();
        while let Some(frame) = reader.read_next_frame().unwrap() {
            delays.push(frame.delay);
            for (at, rgba) in frame.buffer.as_chunks::<4>().0.iter().enumerate() {
                let (col, row) = (at % usize::from(frame.width), at / usize::from(frame.width));
                if rgba[3] > 0 {
                    screen[(row + usize::from(frame.top)) * 40 + col + usize::from(frame.left)] = *rgba;
                }
            }
        }
        // Two that look alike are one that stays twice as long.
        assert_eq!(delays, [16, 8, 100]);
        let colour = |x: usize| [screen[400 + x][0], screen[400 + x][1], screen[400 + x][2]];
        let [paper, blue] = [PAPER, BLUE].map(|colour| [colour.r, colour.g, colour.b]);
        assert_eq!([10, 20, 30].map(colour), [paper, paper, blue]);
    }

    #[test]
    fn the_part_that_changed_holds_all_that_differs() {
        let (before, mut now) = (vec![0; 12], vec![0; 12]);
        assert_eq!(changed(&before, &now, 4), None);
        (now[5], now[10]) = (1, 1);
        let part = changed(&before, &now, 4).unwrap();
        assert_eq!(part, Part { left: 1, top: 1, width: 2, height: 2 });
        assert_eq!(part.cut(&before, &now, 4, 9), [1, 9, 9, 1]);
    }
}
