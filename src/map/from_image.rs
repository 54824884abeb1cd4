//! A grid from a colour picture: what stands out by its colour is an obstacle.
//!
//! Source: qin2026, section 3.1, equations 1 to 3 (`systems.md` §3): threshold in hue, saturation and value, opening and
//! closing, nearest-neighbour resampling to the grid.
//!
//! ```text
//! M(x, y) = 1 where S > T_s and V < T_v                  the paper's mask; hue may be restricted as well
//! M' = closing(opening(M))                               square window: specks go, gaps close
//! grid(col, row) = M'(⌊(col + ½) W / cols⌋, ⌊(row + ½) H / rows⌋)
//! ```
//!
//! Departures: the paper names neither thresholds nor window (all are parameters here), and resamples to a size; an
//! occupied cell is one whose centre is, so an obstacle thinner than a cell can be lost.

use super::OccupancyGrid;

/// Parameters by which a picture becomes a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Params {
    /// An obstacle's hue lies between these, degrees; [300, 60] goes through red. [0, 360] takes every hue.
    pub hue_deg: [f64; 2],
    /// An obstacle's saturation is above this, 0 to 1 (the paper's T_s: grey ground is left out).
    pub saturation_min: f64,
    /// An obstacle's value is below this, 0 to 1 (the paper's T_v: glare is left out); above 1 takes every value.
    pub value_max: f64,
    /// Opening: obstacles narrower than 2 `opening_px` + 1 px vanish.
    pub opening_px: u32,
    /// Closing: gaps narrower than 2 `closing_px` + 1 px are filled.
    pub closing_px: u32,
    /// Columns and rows of the grid; `None` for those of the picture.
    pub size: Option<[u32; 2]>,
    /// Side of a cell, m.
    pub resolution_m: f64,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            hue_deg: [0.0, 360.0],
            saturation_min: 0.25,
            value_max: 0.95,
            opening_px: 1,
            closing_px: 1,
            size: None,
            resolution_m: 1.0,
        }
    }
}

/// Hue in degrees from 0 up to 360 (0 for greys), saturation and value from 0 to 1, of a colour in 8 bits a channel.
pub fn hsv([r, g, b]: [u8; 3]) -> [f64; 3] {
    let (high, low) = (r.max(g).max(b), r.min(g).min(b));
    let chroma = f64::from(high - low);
    let [r, g, b] = [r, g, b].map(f64::from);
    let sector = if high == low {
        0.0
    } else if f64::from(high) == r {
        ((g - b) / chroma).rem_euclid(6.0)
    } else if f64::from(high) == g {
        (b - r) / chroma + 2.0
    } else {
        (r - g) / chroma + 4.0
    };
    let saturation = if high == 0 { 0.0 } else { chroma / f64::from(high) };
    [60.0 * sector, saturation, f64::from(high) / 255.0]
}

impl Params {
    fn is_obstacle(&self, colour: [u8; 3]) -> bool {
        let [hue, saturation, value] = hsv(colour);
        let [from, to] = self.hue_deg;
        let in_hue = if from <= to { (from..=to).contains(&hue) } else { hue >= from || hue <= to };
        in_hue && saturation > self.saturation_min && value < self.value_max
    }

    /// The grid of a picture of `width` columns, its rows from the top.
    ///
    /// # Panics
    /// If the picture is empty or its last row is not complete.
    pub fn grid(&self, pixels: &[[u8; 3]], width: usize) -> OccupancyGrid {
        assert!(!pixels.is_empty() && pixels.len().is_multiple_of(width), "a picture of whole rows");
        let height = pixels.len() / width;
        // With ground all around, so that closing may grow beyond the picture before it shrinks again.
        let margin = self.opening_px.max(self.closing_px) as usize;
        let padded = width + 2 * margin;
        let mut mask = vec![false; padded * (height + 2 * margin)];
        for (index, &colour) in pixels.iter().enumerate() {
            mask[(index / width + margin) * padded + index % width + margin] = self.is_obstacle(colour);
        }
        for (window_px, first) in [(self.opening_px, false), (self.closing_px, true)] {
            for value in [first, !first] {
                spread(&mut mask, padded, window_px as usize, value);
            }
        }
        let [cols, rows] = self.size.map_or([width, height], |size| size.map(|side| side as usize));
        let mut grid = OccupancyGrid::empty(cols as i32, rows as i32, self.resolution_m);
        // ⌊(i + ½) from / to⌋ in whole numbers.
        let nearest = |index: usize, from: usize, to: usize| (2 * index + 1) * from / (2 * to);
        for index in 0..cols * rows {
            let cell = grid.cell(index);
            let row_from_top = rows - 1 - cell.row as usize;
            let (across, down) = (nearest(cell.col as usize, width, cols), nearest(row_from_top, height, rows));
            if mask[(down + margin) * padded + across + margin] {
                grid.set_occupied(cell);
            }
        }
        grid
    }
}

/// Gives `value` to every pixel that has a pixel of that value within a square window of `reach` to all sides: dilation for
/// `true`, erosion for `false`. Pixels outside the picture count for neither. Rows, then columns; linear in the pixels.
fn spread(mask: &mut [bool], width: usize, reach: usize, value: bool) {
    let height = mask.len() / width;
    spread_lines(mask, (0..height).map(|row| (row * width, 1, width)), reach, value);
    spread_lines(mask, (0..width).map(|col| (col, width, height)), reach, value);
}

/// [`spread`] along lines given by first pixel, step and length.
fn spread_lines(mask: &mut [bool], lines: impl Iterator<Item = (usize, usize, usize)>, reach: usize, value: bool) {
    for (first, step, length) in lines {
        let had: Vec<bool> = (0..length).map(|k| mask[first + k * step] == value).collect();
        // Number of pixels with the value in the window around k.
        let mut count = had.iter().take(reach).filter(|&&has| has).count();
        for k in 0..length {
            count += usize::from(had.get(k + reach).is_some_and(|&has| has));
            if k > reach {
                count -= usize::from(had[k - reach - 1]);
            }
            if count > 0 {
                mask[first + k * step] = value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{EpisodeSeed, Purpose};

    const RED: [u8; 3] = [200, 20, 20];
    const GREY: [u8; 3] = [120, 120, 120];

    fn picture(rows: &[&str]) -> (Vec<[u8; 3]>, usize) {
        let pixels = rows.concat().bytes().map(|c| if c == b'#' { RED } else { GREY }).collect();
        (pixels, rows[0].len())
    }

    fn grid(rows: &[&str], params: &Params) -> OccupancyGrid {
        let (pixels, width) = picture(rows);
        params.grid(&pixels, width)
    }

    const RAW: Params = Params {
        hue_deg: [0.0, 360.0],
        saturation_min: 0.25,
        value_max: 0.95,
        opening_px: 0,
        closing_px: 0,
        size: None,
        resolution_m: 1.0,
    };

    #[test]
    fn known_colours_have_known_hues() {
        for (colour, expected) in [
            ([255, 0, 0], [0.0, 1.0, 1.0]),
            ([255, 255, 0], [60.0, 1.0, 1.0]),
            ([0, 255, 0], [120.0, 1.0, 1.0]),
            ([0, 255, 255], [180.0, 1.0, 1.0]),
            ([0, 0, 255], [240.0, 1.0, 1.0]),
            ([255, 0, 255], [300.0, 1.0, 1.0]),
            ([0, 0, 0], [0.0, 0.0, 0.0]),
            ([255, 255, 255], [0.0, 0.0, 1.0]),
            ([51, 102, 102], [180.0, 0.5, 0.4]),
        ] {
            let found = hsv(colour);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{colour:?}: {found:?}");
        }
    }

    #[test]
    fn thresholds_choose_by_hue_saturation_and_value() {
        let blue = [20, 20, 200];
        let glare = [255, 180, 180];
        let row = [RED, blue, glare, GREY];
        let occupied = |params: Params| params.grid(&row, 4).occupied().to_vec();
        assert_eq!(occupied(RAW), [true, true, false, false]);
        assert_eq!(occupied(Params { value_max: 1.1, ..RAW }), [true, true, true, false]);
        assert_eq!(occupied(Params { hue_deg: [300.0, 60.0], ..RAW }), [true, false, false, false]);
        assert_eq!(occupied(Params { hue_deg: [200.0, 280.0], ..RAW }), [false, true, false, false]);
        assert_eq!(occupied(Params { saturation_min: 0.95, ..RAW }), [false; 4]);
    }

    #[test]
    fn opening_drops_specks_and_keeps_blocks_and_closing_fills_gaps() {
        let speckled = [".....#..", ".###....", ".###..#.", ".###....", "........", "........"];
        let opened = grid(&speckled, &Params { opening_px: 1, ..RAW });
        assert_eq!(opened, grid(&["........", ".###....", ".###....", ".###....", "........", "........"], &RAW));
        let holed = ["........", ".#####..", ".##.##..", ".#####..", "........"];
        let closed = grid(&holed, &Params { closing_px: 1, ..RAW });
        assert_eq!(closed, grid(&["........", ".#####..", ".#####..", ".#####..", "........"], &RAW));
    }

    /// The window written down once more: every pixel asks all others.
    fn slow(mask: &[bool], width: usize, reach: usize, value: bool) -> Vec<bool> {
        let near =
            |a: usize, b: usize| (a / width).abs_diff(b / width) <= reach && (a % width).abs_diff(b % width) <= reach;
        let any = |p: usize| (0..mask.len()).any(|q| mask[q] == value && near(p, q));
        (0..mask.len()).map(|p| if any(p) { value } else { mask[p] }).collect()
    }

    #[test]
    fn the_moving_window_agrees_with_asking_every_pixel() {
        let mut draws = EpisodeSeed { seed: 2, episode: 0 }.stream(Purpose::Map, 0);
        for _ in 0..60 {
            let (width, height, reach) = (1 + draws.index(12), 1 + draws.index(12), draws.index(5));
            let mask: Vec<bool> = (0..width * height).map(|_| draws.uniform() < 0.3).collect();
            for value in [false, true] {
                let mut fast = mask.clone();
                spread(&mut fast, width, reach, value);
                assert_eq!(fast, slow(&mask, width, reach, value), "{width} {reach} {value}");
            }
        }
    }

    #[test]
    fn resampling_takes_the_nearest_pixel() {
        let checks = ["##..", "##..", "..##", "..##"];
        let half = grid(&checks, &Params { size: Some([2, 2]), resolution_m: 0.5, ..RAW });
        assert_eq!(half, OccupancyGrid::from_ascii(&["#.", ".#"], 0.5));
        let double = grid(&["#.", ".#"], &Params { size: Some([4, 4]), ..RAW });
        assert_eq!(double, grid(&checks, &RAW));
    }
}
