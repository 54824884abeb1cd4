//! Maps of ROS `map_server`: a YAML header beside a grey image.
//!
//! ```yaml
//! image: depot.pgm             # PGM, PNG or BMP; beside the YAML file, or an absolute path
//! resolution: 0.05             # metres per pixel
//! origin: [-10.0, -10.0, 0.0]  # pose [x, y, yaw] of the lower left corner in the frame `map`
//! negate: 0                    # 1: dark is free
//! occupied_thresh: 0.65
//! free_thresh: 0.25
//! mode: trinary                # or scale, or raw; this one key may be left out
//! ```
//!
//! A pixel's darkness p is 1 − mean of its colour channels (the mean itself with `negate`), both from
//! 0 to 1; row 0 of the image is the top. The cell's occupancy, as in `nav_msgs/OccupancyGrid`:
//!
//! | mode | 100 | 0 | between | −1 (unknown) |
//! |---|---|---|---|---|
//! | `trinary` | p > `occupied_thresh` | p < `free_thresh` | never | all others |
//! | `scale` | p > `occupied_thresh` | p < `free_thresh` | 100 (p − free) / (occupied − free), rounded | never |
//! | `raw` | value 100 | value 0 | the pixel's value (of 255), whatever `negate` says | values above 100 |
//!
//! The comparisons are strict and colours count by their mean, as in ROS 1 and in Nav2 up to Jazzy. In the first
//! two modes a pixel that is not fully opaque is unknown. The world frame is the map's own: planners work in
//! cells, and poses go through [`Frame`] with the yaw of `origin`.
//!
//! A cell is an obstacle at occupancy 100 and free below, like Nav2's static layer by default
//! (`lethal_cost_threshold` 100, `trinary_costmap`); the key `unknown` decides on unknown cells.
//!
//! Keys that Nav2 does not know are passed over, as there, with a note.
//!
//! Source: ros-navigation/navigation2, `nav2_map_server/src/map_io.cpp`, from Humble to Jazzy. Departures: ROS 1 took the opacity
//! into the mean of `trinary`; versions of 2026 compare by ≥ and ≤ and weigh colours by their brightness. No pixel of 8
//! bits meets a usual threshold exactly (0.65 · 255 = 165.75, 0.25 · 255 = 63.75, 0.196 · 255 = 49.98); thresholds of 1
//! and 0 are met by black and white, and then a note says so.

mod header;
mod pixels;
mod pnm;
mod writer;

pub use writer::write;

use crate::files;
use crate::map::file::{Draft, FileFormat, Loaded, Unknown};
use crate::map::{Cell, Entry, Frame, MapError, MapKind, OccupancyGrid};
use crate::rng::EpisodeSeed;
use crate::settings::choice::or_text;
use crate::settings::quantity::Positive;
use header::Header;
use pixels::decode;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Registry entry.
pub const ENTRY: Entry = Entry {
    summary: "A map of ROS map_server: a YAML header beside a grey image.",
    files: &[
        FileFormat {
            extensions: &["yaml", "yml"],
            name: Some("ROS"),
            has_frame: true,
            in_scenarios: None,
            read: |file, _, unknown| Ok(RosMap::load(file)?.loaded(unknown)),
            write: Some(write_with_header),
        },
        FileFormat {
            extensions: &["png"],
            name: None,
            has_frame: false,
            in_scenarios: BARE,
            read: read_image,
            write: Some(|grid, file| vec![Draft { file: file.into(), bytes: writer::png(grid) }]),
        },
        FileFormat {
            extensions: &["pgm"],
            name: None,
            has_frame: false,
            in_scenarios: BARE,
            read: read_image,
            write: Some(|grid, file| vec![Draft { file: file.into(), bytes: writer::pgm(grid) }]),
        },
        picture(&["bmp"]),
        picture(&["ppm"]),
        picture(&["pbm"]),
        picture(&["pam"]),
    ],
};

/// An image that is read by its content, and not written.
const fn picture(extensions: &'static [&'static str]) -> FileFormat {
    FileFormat { extensions, name: None, has_frame: false, in_scenarios: BARE, read: read_image, write: None }
}

/// What to do with an image as the map of a scenario.
const BARE: Option<&str> = Some(
    "an image has no resolution and no origin: `simrun map convert IMAGE site.yaml --resolution-m 0.05` writes the header that has them",
);

/// Parameters of a ROS map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, remote = "Self")]
#[schemars(extend("x-alone" = "file"))]
pub struct Params {
    /// The YAML file, relative to the folder of the scenario file; it names its image.
    #[schemars(example = "maps/depot.yaml")]
    pub file: PathBuf,
    /// What cells count as that the map does not know: `occupied` or `free`. Default `occupied`.
    #[serde(default)]
    pub unknown: Unknown,
}

or_text!(Params, "file");

impl MapKind for Params {
    fn load(&self, folder: &Path, _seed: EpisodeSeed) -> Result<OccupancyGrid, MapError> {
        Ok(RosMap::load(&folder.join(&self.file))?.grid(self.unknown))
    }

    fn is_fixed(&self) -> bool {
        true
    }

    fn files(&self, folder: &Path) -> Vec<PathBuf> {
        let header = files::text(&folder.join(&self.file), HEADER_BYTES_MAX).ok();
        let image = header.and_then(|text| Some(Header::parse(&text).ok()?.0.image));
        let beside = self.file.parent().unwrap_or(Path::new(""));
        [Some(self.file.clone()), image.map(|image| beside.join(image))].into_iter().flatten().collect()
    }

    fn is_unknown(&self, folder: &Path, cell: Cell) -> bool {
        let map = RosMap::load(&folder.join(&self.file));
        map.is_ok_and(|map| map.grid(self.unknown).contains(cell) && map.occupancy_at(cell) == UNKNOWN)
    }

    fn notes(&self, folder: &Path) -> Vec<String> {
        let file = folder.join(&self.file);
        let notes = RosMap::load(&file).map_or_else(|_| Vec::new(), |map| map.notes);
        notes.into_iter().map(|note| format!("{}: {note}", file.display())).collect()
    }
}

/// Reads a grey image that has no header.
fn read_image(file: &Path, resolution_m: Positive, unknown: Unknown) -> Result<Loaded, MapError> {
    let map = RosMap::from_image(file, resolution_m).map_err(|error| error.of(file))?;
    Ok(map.loaded(unknown))
}

/// Drafts a header, and its image beside it under the same name with the extension `.pgm`.
fn write_with_header(grid: &OccupancyGrid, file: &Path) -> Vec<Draft> {
    let image = file.with_extension("pgm");
    let name = image.file_name().unwrap_or_default().to_string_lossy();
    let (header, pgm) = write(grid, &name);
    vec![Draft { file: file.into(), bytes: header.into_bytes() }, Draft { file: image, bytes: pgm }]
}

/// Occupancy of a cell that holds an obstacle; also the largest occupancy.
const OCCUPIED: i8 = 100;
/// Occupancy of a cell that is certainly free.
const FREE: i8 = 0;
/// Occupancy of a cell that nobody has seen.
const UNKNOWN: i8 = -1;

/// A map of ROS: the occupancy of each cell, which may be unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct RosMap {
    cols: usize,
    resolution_m: f64,
    frame: Frame,
    occupancy: Vec<i8>,
    notes: Vec<String>,
}

impl RosMap {
    /// Reads a YAML file and the image that it names.
    ///
    /// # Errors
    /// [`MapError::File`] if the header or the image cannot be read or do not follow their formats.
    pub fn load(file: &Path) -> Result<Self, MapError> {
        let text = files::text(file, HEADER_BYTES_MAX).map_err(|source| MapError::Read { source }.of(file))?;
        let folder = file.parent().unwrap_or(Path::new(""));
        let load = || {
            let (header, mut notes) = Header::parse(&text)?;
            // An absolute path replaces the folder.
            let image = decode(&folder.join(&header.image), Some(folder))?;
            let mut map = header.map(&image);
            notes.append(&mut map.notes);
            Ok(Self { notes, ..map })
        };
        load().map_err(|error: MapError| error.of(file))
    }

    /// Reads an image that has no header: trinary, white is free, origin [0, 0, 0], and thresholds by which the grey 205 that map savers
    /// write for unknown stays unknown.
    ///
    /// # Errors
    /// [`MapError::Image`] if it cannot be read.
    pub fn from_image(file: &Path, resolution_m: Positive) -> Result<Self, MapError> {
        Ok(Header::of_image(resolution_m).map(&decode(file, None)?))
    }

    /// Occupancy from 0 to 100 or −1 for unknown, row-major, row 0 at the bottom.
    pub fn occupancy(&self) -> &[i8] {
        &self.occupancy
    }

    /// Occupancy of a cell of the map.
    fn occupancy_at(&self, cell: Cell) -> i8 {
        self.occupancy[cell.row as usize * self.cols + cell.col as usize]
    }

    /// What its header says that was not used, and cells that may not be what was meant, in words.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Number of unknown cells.
    pub fn unknown_count(&self) -> usize {
        self.occupancy.iter().filter(|&&occupancy| occupancy == UNKNOWN).count()
    }

    /// The grid that planners see, and the number of unknown cells.
    fn loaded(&self, unknown: Unknown) -> Loaded {
        let count = self.unknown_count();
        let is_unknown = |&occupancy: &i8| occupancy == UNKNOWN;
        Loaded {
            grid: self.grid(unknown),
            unknown: count,
            unknown_cells: if count == 0 { Vec::new() } else { self.occupancy.iter().map(is_unknown).collect() },
            notes: self.notes.clone(),
        }
    }

    /// The grid that planners see.
    pub fn grid(&self, unknown: Unknown) -> OccupancyGrid {
        let rows = self.occupancy.len() / self.cols;
        let mut grid = OccupancyGrid::empty(self.cols as i32, rows as i32, self.resolution_m).with_frame(self.frame);
        for (index, &occupancy) in self.occupancy.iter().enumerate() {
            if occupancy == OCCUPIED || (occupancy == UNKNOWN && unknown == Unknown::Occupied) {
                grid.set_occupied(grid.cell(index));
            }
        }
        grid.with_unknown(self.occupancy.iter().map(|&occupancy| occupancy == UNKNOWN).collect())
    }
}

/// Largest number of bytes of a header; real ones stay below 1 KiB.
const HEADER_BYTES_MAX: u64 = 1 << 16;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pose, Vec2};
    use crate::map::connectivity::Components;
    use crate::math::FRAC_PI_2;
    use image::{DynamicImage, GrayImage, ImageBuffer, ImageFormat, Luma, LumaA, Rgb, Rgba};
    use std::io::Write;

    const HEADER: &str = "image: map.pgm\nresolution: 0.5\norigin: [1, 2, 0]\nnegate: 0\n\
                          occupied_thresh: 0.65\nfree_thresh: 0.25\n";

    /// A folder with `map.yaml` and an image of the bytes given.
    fn folder(header: &str, image: &[u8]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("map.yaml"), header).expect("a file");
        std::fs::write(folder.path().join("map.pgm"), image).expect("a file");
        folder
    }

    fn load(header: &str, image: &[u8]) -> Result<RosMap, MapError> {
        RosMap::load(&folder(header, image).path().join("map.yaml"))
    }

    /// The occupancies of one row of grey pixels.
    fn row(header: &str, greys: &[u8]) -> Vec<i8> {
        let mut pgm = format!("P5\n{} 1\n255\n", greys.len()).into_bytes();
        pgm.extend(greys);
        load(header, &pgm).expect("a map").occupancy
    }

    #[test]
    fn row_0_of_the_image_is_the_top_and_origin_the_lower_left_corner() {
        // 3 x 2 pixels; the comment and the line breaks are as map_saver and GIMP write them.
        let ascii = b"P2\n# CREATOR: map_saver 0.5 m/pix\n3 2\n255\n0 254 254\n254\n254 180\n";
        let binary = b"P5\n# CREATOR: map_saver 0.5 m/pix\n3 2\n255\n\x00\xfe\xfe\xfe\xfe\xb4";
        let map = load(HEADER, ascii).expect("a map");
        assert_eq!(map, load(HEADER, binary).expect("a map"));
        assert_eq!(map.occupancy(), [0, 0, -1, 100, 0, 0]);
        assert_eq!(map.unknown_count(), 1);
        let grid = map.grid(Unknown::Occupied);
        assert_eq!(grid.to_string(), "#..\n..#\n");
        assert_eq!(map.grid(Unknown::Free).to_string(), "#..\n...\n");
        assert_eq!(grid.resolution_m(), 0.5);
        assert_eq!(grid.frame().point_to_world(Vec2::new(0.5, 0.0)), Vec2::new(1.5, 2.0));
    }

    #[test]
    fn a_turned_origin_turns_the_map_about_its_lower_left_corner() {
        let header = HEADER.replace("[1, 2, 0]", "[1, 2, 1.5707963267948966]");
        let grid = load(&header, b"P2 3 1 255 254 254 0").expect("a map").grid(Unknown::Occupied);
        assert_eq!(grid.frame().origin, Pose::new(1.0, 2.0, FRAC_PI_2));
        // The occupied cell is the third: its centre lies 1.25 m along the map's x axis, which points to
        // the world's +y, and 0.25 m along its y axis, which points to -x.
        let centre = grid.frame().point_to_world(grid.centre(Cell { col: 2, row: 0 }));
        assert!((centre - Vec2::new(1.0 - 0.25, 2.0 + 1.25)).norm() < 1e-12, "{centre}");
        let cell = grid.cell_at(grid.frame().point_to_grid(Vec2::new(0.8, 3.2)));
        assert!(cell == Cell { col: 2, row: 0 } && !grid.is_free(cell));
    }

    #[test]
    fn thresholds_are_met_from_both_sides() {
        // p of 89 is 0.651, of 90 0.647, of 191 0.2510, of 192 0.2471.
        assert_eq!(row(HEADER, &[0, 89, 90, 191, 192, 255]), [100, 100, -1, -1, 0, 0]);
        // Thresholds that a pixel meets exactly: 51 and 204 of 255 are p = 0.8 and 0.2. Neither is included.
        let exact = HEADER.replace("0.65", "0.8").replace("0.25", "0.2");
        assert_eq!(row(&exact, &[50, 51, 52, 203, 204, 205]), [100, -1, -1, -1, -1, 0]);
    }

    #[test]
    fn negate_swaps_dark_and_light() {
        for negate in ["1", "true", "True", "yes", "'1'", "on"] {
            let header = HEADER.replace("negate: 0", &format!("negate: {negate}"));
            // p is v / 255: 63 is 0.247, 64 0.251, 165 0.647, 166 0.651.
            assert_eq!(row(&header, &[0, 63, 64, 165, 166, 255]), [0, 0, -1, -1, 100, 100], "{negate}");
        }
        for negate in ["false", "no", "'0'", "off"] {
            assert_eq!(row(&HEADER.replace("negate: 0", &format!("negate: {negate}")), &[0]), [100]);
        }
    }

    #[test]
    fn scale_grades_what_lies_between_the_thresholds() {
        let header = format!("{HEADER}mode: Scale\n");
        // 127: p = 128/255 = 0.50196, (p - 0.25) / 0.4 = 0.6299; 190: 65/255 = 0.2549 → 0.0123; 90: 0.647 → 0.9926.
        assert_eq!(row(&header, &[0, 90, 127, 190, 254]), [100, 99, 63, 1, 0]);
        let map = load(&header, b"P2 2 1 255 127 0").expect("a map");
        assert_eq!(map.grid(Unknown::Occupied).to_string(), ".#\n");
    }

    #[test]
    fn raw_takes_the_values_as_they_are() {
        for negate in ["0", "1"] {
            let header = format!("{}mode: raw\n", HEADER.replace("negate: 0", &format!("negate: {negate}")));
            assert_eq!(row(&header, &[0, 1, 99, 100, 101, 205, 255]), [0, 1, 99, 100, -1, -1, -1]);
        }
    }

    /// An image under the name that the header gives: the content says what it is.
    fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.into().write_to(&mut bytes, format).expect("an image");
        bytes.into_inner()
    }

    fn png(image: impl Into<DynamicImage>) -> Vec<u8> {
        encoded(image, ImageFormat::Png)
    }

    #[test]
    fn a_bmp_has_the_cells_of_the_same_png() {
        let grey = GrayImage::from_fn(5, 3, |x, y| Luma([(x * 60 + y * 7) as u8]));
        let rgb = ImageBuffer::from_fn(5, 3, |x, y| Rgb([(x * 60) as u8, (y * 120) as u8, 200]));
        let images: [DynamicImage; 2] = [grey.into(), rgb.into()];
        for image in images {
            let bmp = load(HEADER, &encoded(image.clone(), ImageFormat::Bmp)).expect("a map");
            assert_eq!(bmp, load(HEADER, &png(image)).expect("a map"));
        }
    }

    #[test]
    fn an_image_without_a_header_keeps_the_grey_of_unknown_cells_unknown() {
        let folder = folder(HEADER, b"P2 4 1 255 0 205 206 254");
        let bare = RosMap::from_image(&folder.path().join("map.pgm"), Positive::new(1.0)).expect("a map");
        assert_eq!((bare.occupancy(), bare.notes()), (&[100, -1, 0, 0][..], &[][..]));
        // By the header's 0.25 it is free, which is noted.
        let by_header = RosMap::load(&folder.path().join("map.yaml")).expect("a map");
        assert_eq!(by_header.occupancy(), [100, 0, 0, 0]);
        let expected = "grey 205, which map savers write for unknown, is free by `free_thresh`: 1 cell";
        assert_eq!(by_header.notes(), [expected]);
    }

    #[test]
    fn keys_of_others_are_passed_over_and_noted() {
        let image = b"P2 1 1 255 0";
        let plain = load(HEADER, image).expect("a map");
        for (more, expected) in [
            ("map_type: occupancy\n", "line 7: the key `map_type` is no key of map headers and passed over"),
            (
                "'mod': [scale, {a: b}]\n",
                "line 7: the key `mod` is no key of map headers and passed over; did you mean `mode`?",
            ),
        ] {
            let map = load(&format!("{HEADER}{more}"), image).expect("a map");
            assert_eq!(map.notes(), [expected]);
            assert_eq!(map.occupancy(), plain.occupancy());
        }
        // The first of several documents, as yaml-cpp has it; keys that are no texts.
        assert_eq!(load(&format!("---\n{HEADER}---\nresolution: 7\n"), image).expect("a map"), plain);
        assert_eq!(load(&format!("{HEADER}3: 4\n"), image).expect("a map"), plain);
    }

    #[test]
    fn colours_are_averaged_and_depths_agree() {
        // Means 170 (p = 0.333: unknown), 255 (free) and 85 (p = 0.667: occupied).
        let rgb = |x, _| Rgb([[255_u8, 255, 0], [255, 255, 255], [0, 0, 255]][x as usize]);
        let rgb8 = ImageBuffer::from_fn(3, 1, rgb);
        assert_eq!(load(HEADER, &png(rgb8)).expect("a map").occupancy, [-1, 0, 100]);
        for grey in 0..=u8::MAX {
            let narrow = load(HEADER, &png(GrayImage::from_pixel(1, 1, Luma([grey])))).expect("a map");
            let wide = ImageBuffer::from_pixel(1, 1, Luma([u16::from(grey) * 257]));
            assert_eq!(narrow, load(HEADER, &png(DynamicImage::ImageLuma16(wide))).expect("a map"));
        }
    }

    #[test]
    fn what_is_not_opaque_is_unknown_except_in_raw() {
        let pixels = [[0_u8, 0, 0, 255], [0, 0, 0, 0], [255, 255, 255, 255], [255, 255, 255, 0], [0, 0, 0, 128]];
        let rgba = png(ImageBuffer::from_fn(5, 1, |x, _| Rgba(pixels[x as usize])));
        let greys = png(DynamicImage::ImageLumaA8(ImageBuffer::from_fn(5, 1, |x, _| {
            LumaA([pixels[x as usize][0], pixels[x as usize][3]])
        })));
        for image in [rgba, greys] {
            assert_eq!(load(HEADER, &image).expect("a map").occupancy, [100, -1, 0, -1, -1]);
            let scale = load(&format!("{HEADER}mode: scale\n"), &image).expect("a map");
            assert_eq!(scale.occupancy, [100, -1, 0, -1, -1]);
            assert_eq!(load(&format!("{HEADER}mode: raw\n"), &image).expect("a map").occupancy, [0, 0, -1, -1, 0]);
        }
    }

    #[test]
    fn a_palette_is_looked_up_with_its_transparency() {
        // By hand, for the encoder writes no palettes: 4 pixels of 2 bits, indices 0 1 2 3; the
        // colours black, white, grey 205 and white, the last one transparent (tRNS).
        let chunk = |kind: &[u8], data: &[u8]| {
            let mut chunk = (data.len() as u32).to_be_bytes().to_vec();
            chunk.extend(kind.iter().chain(data));
            let crc = kind.iter().chain(data).fold(u32::MAX, |crc, &byte| {
                (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 * (crc & 1)))
            });
            chunk.extend((!crc).to_be_bytes());
            chunk
        };
        // zlib, one stored block of a filter byte and a byte of pixels: 00, 00 01 10 11; Adler-32 by hand:
        // a = 1 + 0 + 27 = 28, b = 1 + 28 = 29.
        let pixels = [0x78, 0x01, 0x01, 2, 0, 0xfd, 0xff, 0x00, 0b0001_1011, 0, 29, 0, 28];
        let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
        bytes.extend(chunk(b"IHDR", &[0, 0, 0, 4, 0, 0, 0, 1, 2, 3, 0, 0, 0]));
        bytes.extend(chunk(b"PLTE", &[0, 0, 0, 255, 255, 255, 205, 205, 205, 255, 255, 255]));
        bytes.extend(chunk(b"tRNS", &[255, 255, 255, 0]));
        bytes.extend(chunk(b"IDAT", &pixels));
        bytes.extend(chunk(b"IEND", &[]));
        // 205: p = 50/255 = 0.196 is free at 0.25 and unknown at 0.196.
        assert_eq!(load(HEADER, &bytes).expect("a map").occupancy, [100, 0, 0, -1]);
        assert_eq!(load(&HEADER.replace("0.25", "0.196"), &bytes).expect("a map").occupancy, [100, 0, -1, -1]);
    }

    #[test]
    fn other_depths_of_pgm_are_scaled() {
        // Of 100: 30 is p = 0.7, 40 is 0.6, 80 is 0.2.
        assert_eq!(load(HEADER, b"P2 3 1 100 30 40 80").expect("a map").occupancy, [100, -1, 0]);
        assert_eq!(load(HEADER, b"P5 2 1 65535\n\x00\x00\xff\xff").expect("a map").occupancy, [100, 0]);
    }

    #[test]
    fn headers_may_be_quoted_and_listed_and_in_any_order() {
        let header = "free_thresh: \"0.25\"\noccupied_thresh: .65\nnegate: 0\nmode: 'trinary'\n# a comment\n\
                      origin:\n- 1\n- \"2.0\"\n- 0e0\nresolution: '0.50000'\nimage: \"map.pgm\"\n";
        let image = b"P2 1 1 255 0";
        assert_eq!(load(header, image).expect("a map"), load(HEADER, image).expect("a map"));
        let flow = "{image: map.pgm, resolution: 0.5, origin: [1, 2, 0], negate: 0, occupied_thresh: 0.65, \
                    free_thresh: 0.25}";
        assert_eq!(load(flow, image).expect("a map"), load(HEADER, image).expect("a map"));
    }

    #[test]
    fn faults_of_a_header_are_named_with_their_place() {
        for (old, new, expected) in [
            (
                "resolution",
                "resolutoin",
                "line 2, column 1: missing key `resolution`; unknown key `resolutoin`, did you mean `resolution`?",
            ),
            ("negate: 0\n", "", "missing key `negate`"),
            ("negate: 0", "negate: 2", "invalid value: integer `2`, expected 0 or 1"),
            ("negate: 0", "negate: 0\nnegate: 0", "line 5, column 1: twice the key `negate`"),
            ("0.5", "0", "line 2, column 13: resolution: expected a number above 0, found 0"),
            ("0.5", "wide", "line 2, column 13: resolution: invalid value: string \"wide\", expected a number"),
            ("0.5", ".nan", "expected a number above 0, found NaN"),
            ("[1, 2, 0]", "[1, 2]", "invalid length 2, expected an array of length 3"),
            ("[1, 2, 0]", "[1, 2, .inf]", "expected a finite number, found inf"),
            ("0.65", "65", "expected a number from 0 to 1, found 65"),
            ("0.65", "0.25", "found `free_thresh` 0.25 and `occupied_thresh` 0.25, expected a free threshold below"),
            ("negate: 0", "negate: 0\nmode: trinry", "line 5, column 1: unknown mode `trinry`, did you mean"),
            ("map.pgm", "''", "`image` is empty"),
            ("map.pgm", "[", ": line "),
        ] {
            let header = HEADER.replacen(old, new, 1);
            assert_ne!(header, HEADER);
            let message = load(&header, b"P2 1 1 255 0").expect_err("refused").to_string();
            assert!(message.contains("map.yaml: ") && message.contains(expected), "{message}");
        }
        assert!(load("", b"P2 1 1 255 0").is_err());
    }

    #[test]
    fn faults_of_an_image_are_named_with_the_image() {
        for (image, expected) in [
            (&b""[..], "expected a PGM, PNG or BMP image"),
            (b"no image at all", "expected a PGM, PNG or BMP image"),
            (b"\xff\xd8\xff\xe0\0\x10JFIF", "found the format Jpeg, expected a PGM, PNG or BMP image"),
            (b"P5 3 3 255\n123", "is the file whole?"),
            (b"P2 3 1 255 1 2", "is the file whole?"),
            (b"P2 1 1 255 256", "is the file whole?"),
            (b"P5\r\n1 1\r\n255\r\n\0", "found 2 bytes of pixels, expected 1, as 1 x 1 pixels have"),
            (b"P2 1 1 255 0 0", "found 2 numbers of pixels, expected 1, as 1 x 1 pixels have"),
            (b"BM", "is the file whole?"),
            (b"P5 0 3 255\n", "expected a PGM, PNG or BMP image"),
            (b"P5 99999 99999 255\n", "of at most 16384 x 16384 pixels"),
            (b"\x89PNG\r\n\x1a\n", "is the file whole?"),
        ] {
            let message = load(HEADER, image).expect_err("refused").to_string();
            assert!(message.contains("map.yaml: ") && message.contains("map.pgm: found"), "{message}");
            assert!(message.contains(expected), "{message}");
        }
        let message = load(&HEADER.replace("map.pgm", "other.png"), b"").expect_err("refused").to_string();
        assert!(message.contains("other.png: found ") && message.contains("folder of the YAML file"), "{message}");
        let message = RosMap::load(Path::new("no/such.yaml")).expect_err("refused").to_string();
        assert!(message.contains("such.yaml: cannot read the map"), "{message}");
    }

    #[test]
    fn what_is_written_is_read_again() {
        let origin = Pose::new(-12.5, 1e-7, 0.3);
        let grid = OccupancyGrid::from_ascii(&["..#", "#.."], 0.05).with_frame(Frame { origin });
        let (header, pgm) = write(&grid, "map.pgm");
        assert_eq!(load(&header, &pgm).expect("a map").grid(Unknown::Free), grid);
        assert_eq!(load(&header, &pgm).expect("a map").unknown_count(), 0);
        let (header, _) = write(&grid, "a: strange #name.pgm");
        assert_eq!(Header::parse(&header).expect("a header").0.image, "a: strange #name.pgm");
    }

    /// The folder of the benchmark; `None` if it is absent.
    fn benchmark() -> Option<PathBuf> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/benchmarks/ros_maps");
        if !folder.exists() {
            writeln!(std::io::stderr(), "skipped: ../shared/benchmarks not found").expect("stderr");
            return None;
        }
        Some(folder)
    }

    #[test]
    fn benchmark_maps_have_the_cells_that_others_counted() {
        let Some(folder) = benchmark() else { return };
        let facts = std::fs::read_to_string(folder.join("facts.tsv")).expect("text");
        let mut maps = 0;
        for line in facts.lines().skip(1) {
            let fields: Vec<&str> = line.split('\t').collect();
            let map = RosMap::load(&folder.join(fields[0])).expect("a map");
            let grid = map.grid(Unknown::Occupied);
            let free: Vec<bool> = grid.occupied().iter().map(|&occupied| !occupied).collect();
            let count = |occupancy| map.occupancy.iter().filter(|&&cell| cell == occupancy).count().to_string();
            let largest = Components::new(&grid, &free).sizes().iter().copied().max().expect("free cells").to_string();
            let found = [
                grid.cols().to_string(),
                grid.rows().to_string(),
                count(FREE),
                count(OCCUPIED),
                count(UNKNOWN),
                largest,
            ];
            let expected = [fields[3], fields[4], fields[6], fields[7], fields[8], fields[9]];
            assert_eq!(found, expected, "{line}");
            assert_eq!(grid.resolution_m(), fields[5].parse::<f64>().expect("a number"));

            // Queries count rows from the top.
            let queries = folder.join(fields[0].replace(".yaml", ".queries.tsv"));
            for query in std::fs::read_to_string(queries).expect("text").lines().skip(1) {
                let numbers: Vec<i32> =
                    query.split('\t').take(4).map(|field| field.parse().expect("a number")).collect();
                for end in numbers.chunks_exact(2) {
                    assert!(grid.is_free(Cell { col: end[0], row: grid.rows() - 1 - end[1] }), "{query}");
                }
            }
            maps += 1;
        }
        assert_eq!(maps, 2);
    }
}
