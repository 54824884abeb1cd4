//! Maps as Nav2's map saver writes them: a YAML header beside a grey image.

use crate::map::OccupancyGrid;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

/// The threshold that Nav2's map saver writes for occupied cells.
pub(super) const OCCUPIED_THRESH: f64 = 0.65;
/// The threshold that Nav2's map saver writes for free cells.
pub(super) const FREE_THRESH: f64 = 0.25;
/// The grey that Nav2's map saver writes for free cells; occupied ones are 0.
const FREE_GREY: u8 = 254;

/// Grey values as Nav2's map saver writes them (0 occupied, 254 free), the top row first.
fn greys(grid: &OccupancyGrid) -> Vec<u8> {
    let rows = grid.occupied().chunks_exact(grid.cols() as usize).rev();
    rows.flatten().map(|&occupied| if occupied { 0 } else { FREE_GREY }).collect()
}

/// The YAML header of a map and its image, a binary PGM; the header calls the image `image`.
pub fn write(grid: &OccupancyGrid, image: &str) -> (String, Vec<u8>) {
    let origin = grid.frame().origin;
    // As YAML writes a text: quoted where it must be.
    let image = serde_yaml::to_string(image).expect("a text is YAML");
    let header = format!(
        "image: {}\nmode: trinary\nresolution: {:?}\norigin: [{:?}, {:?}, {:?}]\nnegate: 0\n\
         occupied_thresh: {OCCUPIED_THRESH:?}\nfree_thresh: {FREE_THRESH:?}\n",
        image.trim_end(),
        grid.resolution_m(),
        origin.position.x,
        origin.position.y,
        origin.theta,
    );
    (header, pgm(grid))
}

/// A binary PGM of 8 bits of grey, free cells 254 and occupied ones 0.
pub(super) fn pgm(grid: &OccupancyGrid) -> Vec<u8> {
    let mut pgm = format!("P5\n{} {}\n255\n", grid.cols(), grid.rows()).into_bytes();
    pgm.extend(greys(grid));
    pgm
}

/// A PNG of 8 bits of grey, free cells 254 and occupied ones 0.
pub(super) fn png(grid: &OccupancyGrid) -> Vec<u8> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(&greys(grid), grid.cols() as u32, grid.rows() as u32, ExtendedColorType::L8)
        .expect("memory takes an image whose bytes match its size");
    bytes
}
