//! Map files of every known format, told apart by their extension.
//!
//! | extension | format | resolution | origin | unknown cells |
//! |---|---|---|---|---|
//! | `.map` | MovingAI ([`movingai`](super::formats::movingai)) | no | no | no |
//! | `.yaml`, `.yml` | ROS map_server with its image ([`ros`](super::formats::ros)) | yes | yes | read |
//! | `.png`, `.pgm` | a grey image, read as ROS does; the grey 205 of map savers is unknown | no | no | read |
//! | `.bmp`, `.ppm`, `.pbm`, `.pam` | the same, read and not written | no | no | read |
//! | `.txt` | a drawing as in scenarios ([`ascii`](super::formats::ascii)) | no | no | no |

use super::{Cell, Frame, MapError, MapSpec, OccupancyGrid, SIDE_MAX, check_resolution};
use crate::files;
use crate::settings::quantity::Positive;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// A format of map files; the entries of the registry of maps hold them.
#[derive(Clone, Copy, Debug)]
pub struct FileFormat {
    /// The extensions in small letters without the dot; the usual one first.
    pub extensions: &'static [&'static str],
    /// Name of the format, if its extension does not say it.
    pub name: Option<&'static str>,
    /// Whether resolution and origin have a place in the format.
    pub has_frame: bool,
    /// What to do where a scenario names such a file as its map and cannot; `None` if it can.
    pub in_scenarios: Option<&'static str>,
    /// Reads a file; the resolution is used if the file gives none.
    pub read: fn(&Path, Positive, Unknown) -> Result<Loaded, MapError>,
    /// The file of a map and its companions, such as an image, to be written in reverse order: the last names no other.
    /// `None` for a format that is only read.
    pub write: Option<fn(&OccupancyGrid, &Path) -> Vec<Draft>>,
}

impl FileFormat {
    /// Every format, in the order of the registry of maps.
    pub fn all() -> impl Iterator<Item = &'static Self> {
        MapSpec::ENTRIES.iter().flat_map(|entry| entry.files)
    }

    /// The format of a file by its extension, in capitals or not.
    ///
    /// # Errors
    /// [`MapError::UnknownExtension`] if no format has that extension.
    pub fn of(file: &Path) -> Result<&'static Self, MapError> {
        let extension = file.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
        let has = |format: &&Self| extension.as_deref().is_some_and(|found| format.extensions.contains(&found));
        Self::all().find(has).ok_or_else(|| MapError::UnknownExtension { known: Self::known() }.of(file))
    }

    /// The drafts of a map in the format of the file's extension, and that format.
    ///
    /// # Errors
    /// [`MapError::UnknownExtension`] if no format that is written has that extension.
    pub fn drafts(grid: &OccupancyGrid, file: &Path) -> Result<(Vec<Draft>, &'static Self), MapError> {
        let format = Self::to_write(file)?;
        Ok((format.write.map_or_else(Vec::new, |write| write(grid, file)), format))
    }

    /// The format that a file is to be written in.
    ///
    /// # Errors
    /// [`MapError::UnknownExtension`] if no format that is written has its extension.
    pub fn to_write(file: &Path) -> Result<&'static Self, MapError> {
        let unknown = || MapError::UnknownExtension { known: Self::written() }.of(file);
        Self::of(file).ok().filter(|format| format.write.is_some()).ok_or_else(unknown)
    }

    /// The formats in words: `.map (MovingAI), …`.
    pub fn known() -> String {
        Self::in_words(Self::all())
    }

    /// The formats that are written, in words.
    pub fn written() -> String {
        Self::in_words(Self::all().filter(|format| format.write.is_some()))
    }

    fn in_words(formats: impl Iterator<Item = &'static Self>) -> String {
        let shown = |format: &Self| {
            let name = format.name.map_or(String::new(), |name| format!(" ({name})"));
            format!(".{}{name}", format.extensions[0])
        };
        let mut shown: Vec<String> = formats.map(shown).collect();
        let last = shown.pop().unwrap_or_default();
        format!("{} or {last}", shown.join(", "))
    }
}

/// What unknown cells count as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Unknown {
    /// Nothing drives where nobody has looked.
    #[default]
    Occupied,
    /// What nobody has seen is not there.
    Free,
}

/// A map read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Loaded {
    /// The grid, with unknown cells treated as requested.
    pub grid: OccupancyGrid,
    /// Number of unknown cells.
    pub unknown: usize,
    /// Whether each cell is unknown, in the order of the grid; empty if none is.
    pub unknown_cells: Vec<bool>,
    /// What the file says that was not used, or should be looked at, in words.
    pub notes: Vec<String>,
}

impl Loaded {
    /// A map all of whose cells are known, of which there is nothing to say.
    pub fn known(grid: OccupancyGrid) -> Self {
        Self { grid, unknown: 0, unknown_cells: Vec::new(), notes: Vec::new() }
    }

    /// Whether a cell of the grid is unknown.
    pub fn is_unknown(&self, cell: Cell) -> bool {
        self.unknown_cells.get(self.grid.index(cell)).is_some_and(|&unknown| unknown)
    }
}

/// A file to be written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Draft {
    /// Its name.
    pub file: PathBuf,
    /// What it will hold.
    pub bytes: Vec<u8>,
}

impl Draft {
    /// Writes the file. What is there already is replaced only if `replace` says so.
    fn save(&self, replace: bool) -> Result<(), MapError> {
        let mut options = File::options();
        options.write(true).truncate(replace).create(replace).create_new(!replace);
        let write = || options.open(&self.file)?.write_all(&self.bytes);
        write().map_err(|source| MapError::Write { source }.of(&self.file))
    }
}

/// Reads a map file. `resolution_m` is used if the file gives no resolution.
///
/// # Errors
/// [`MapError::File`] if the extension is unknown, or the file cannot be read or does not follow its format.
pub fn read(file: &Path, resolution_m: Positive, unknown: Unknown) -> Result<Loaded, MapError> {
    let loaded = (FileFormat::of(file)?.read)(file, resolution_m, unknown)?;
    check_resolution(&loaded.grid).map_err(|error| error.of(file))?;
    Ok(loaded)
}

/// Drafts of a map file and of its companions: a `.yaml` comes with a `.pgm` of the same name.
///
/// # Errors
/// [`MapError::File`] if the extension is unknown.
pub fn drafts(grid: &OccupancyGrid, file: &Path) -> Result<Vec<Draft>, MapError> {
    Ok(FileFormat::drafts(grid, file)?.0)
}

/// Writes drafts, all or, if one of the files is there already and `replace` is not set, none.
///
/// # Errors
/// [`MapError::Exist`] with the files that are there; [`MapError::File`] if a file cannot be written.
pub fn save_all(drafts: &[Draft], replace: bool) -> Result<(), MapError> {
    let there = || drafts.iter().map(|draft| draft.file.clone()).filter(|file| file.symlink_metadata().is_ok());
    let files: Vec<PathBuf> = if replace { Vec::new() } else { there().collect() };
    if !files.is_empty() {
        return Err(MapError::Exist { files });
    }
    // A header comes last: it never names an image that is not there.
    drafts.iter().rev().try_for_each(|draft| draft.save(replace))
}

/// Writes a map file and its companions, over files that are there; returns the files written.
///
/// # Errors
/// [`MapError::File`] if the extension is unknown or a file cannot be written.
pub fn write(grid: &OccupancyGrid, file: &Path) -> Result<Vec<PathBuf>, MapError> {
    let drafts = drafts(grid, file)?;
    save_all(&drafts, true)?;
    Ok(drafts.into_iter().map(|draft| draft.file).collect())
}

/// Largest number of bytes of an image: one of the largest size, four channels of 16 bits.
pub(super) const IMAGE_BYTES_MAX: u64 = (SIDE_MAX * SIDE_MAX * 8) as u64;

/// A colour picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Colours row by row from the top; transparent pixels are blended with white.
    pub pixels: Vec<[u8; 3]>,
    /// Pixels in a row.
    pub width: usize,
}

/// Reads a colour picture, a PNG.
///
/// # Errors
/// [`MapError::File`] if the file cannot be read or is no PNG of at most 16384 pixels a side.
pub fn read_picture(file: &Path) -> Result<Picture, MapError> {
    let refuse = |message: String| MapError::Header { line: 1, column: 1, message }.of(file);
    let opened = files::open(file, IMAGE_BYTES_MAX).map_err(|source| MapError::Read { source }.of(file))?;
    let mut reader = image::ImageReader::with_format(std::io::BufReader::new(opened), image::ImageFormat::Png);
    let mut limits = image::Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(16_384), Some(16_384));
    reader.limits(limits);
    let picture = reader.decode().map_err(|error| refuse(format!("not a PNG that can be read: {error}")))?.into_rgba8();
    let over_white = |[r, g, b, a]: [u8; 4]| {
        let alpha = u32::from(a);
        [r, g, b].map(|c| ((u32::from(c) * alpha + 255 * (255 - alpha) + 127) / 255) as u8)
    };
    let pixels = picture.pixels().map(|pixel| over_white(pixel.0)).collect();
    Ok(Picture { pixels, width: picture.width() as usize })
}

/// A picture with the map made from it: occupied cells in magenta over the fading picture, a PNG of the picture's size.
pub fn preview(picture: &Picture, grid: &OccupancyGrid, file: &Path) -> Draft {
    let (width, height) = (picture.width, picture.pixels.len() / picture.width);
    let (cols, rows) = (grid.cols() as usize, grid.rows() as usize);
    let colour = |index: usize| {
        let (col, row) = (index % width * cols / width, rows - 1 - index / width * rows / height);
        let faded = picture.pixels[index].map(|c| 128 + c / 2);
        if grid.occupied()[row * cols + col] { [200, 0, 160] } else { faded }
    };
    let bytes: Vec<u8> = (0..width * height).flat_map(colour).collect();
    let mut png = Vec::new();
    PngEncoder::new(&mut png)
        .write_image(&bytes, width as u32, height as u32, ExtendedColorType::Rgb8)
        .expect("memory takes an image whose bytes match its size");
    Draft { file: file.into(), bytes: png }
}

/// The parts of a grid that a format cannot hold, in words; `None` if it holds all.
pub fn loss(grid: &OccupancyGrid, format: &FileFormat) -> Option<String> {
    let lost = !format.has_frame && (grid.resolution_m() != 1.0 || *grid.frame() != Frame::IDENTITY);
    let origin = grid.frame().origin;
    lost.then(|| {
        format!(
            "the format holds neither resolution ({} m) nor origin ([{}, {}, {}])",
            grid.resolution_m(),
            origin.position.x,
            origin.position.y,
            origin.theta
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::rng::{EpisodeSeed, Purpose};

    fn of(file: &str) -> &'static FileFormat {
        FileFormat::of(Path::new(file)).expect("a format")
    }

    fn read_plain(file: &Path) -> Result<Loaded, MapError> {
        read(file, Positive::new(1.0), Unknown::Occupied)
    }

    #[test]
    fn every_format_brings_back_what_it_was_given() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut draws = EpisodeSeed { seed: 1, episode: 0 }.stream(Purpose::Map, 0);
        for _ in 0..20 {
            let (cols, rows) = (1 + draws.index(40), 1 + draws.index(40));
            let mut grid = OccupancyGrid::empty(cols as i32, rows as i32, 1.0);
            for index in 0..cols * rows {
                if draws.uniform() < 0.3 {
                    grid.set_occupied(grid.cell(index));
                }
            }
            for name in ["a.map", "b.yaml", "c.png", "d.pgm", "e.txt", "f.YML"] {
                let file = folder.path().join(name);
                let written = write(&grid, &file).expect("written");
                assert!(written[0] == file && written.iter().all(|file| file.exists()));
                assert_eq!(read_plain(&file).expect("read"), Loaded::known(grid.clone()), "{name}");
            }
        }
    }

    #[test]
    fn a_ros_map_keeps_its_frame_and_other_formats_say_what_they_lose() {
        let folder = tempfile::tempdir().expect("a folder");
        let frame = Frame { origin: Pose::new(-3.0, 4.5, 0.25) };
        let grid = OccupancyGrid::from_ascii(&["..#", "#.."], 0.05).with_frame(frame);
        let file = folder.path().join("hall.v2.yaml");
        let written = write(&grid, &file).expect("written");
        assert_eq!(written[1], folder.path().join("hall.v2.pgm"));
        assert_eq!(read_plain(&file).expect("read").grid, grid);
        assert_eq!(loss(&grid, of("a.yaml")), None);
        let lost = loss(&grid, of("a.map")).expect("a loss");
        assert!(lost.contains("resolution (0.05 m)") && lost.contains("origin ([-3, 4.5, 0.25])"), "{lost}");
        assert_eq!(loss(&OccupancyGrid::empty(2, 2, 1.0), of("a.png")), None);
    }

    #[test]
    fn what_cannot_be_read_or_written_is_named() {
        let empty = OccupancyGrid::empty(1, 1, 1.0);
        let nowhere = read_plain(Path::new("nowhere.map")).expect_err("refused").to_string();
        assert!(
            nowhere.starts_with("nowhere.map: cannot read the map: ") && !nowhere.contains("scenario"),
            "{nowhere}"
        );
        for (message, expected) in [
            (
                read_plain(Path::new("a.jpg")).map(|_| ()),
                "a.jpg: the extension names no format of maps, expected .txt, .map (MovingAI), .yaml (ROS), .png, .pgm, .bmp, .ppm, .pbm or .pam",
            ),
            (read_plain(Path::new("no/such.txt")).map(|_| ()), "such.txt: cannot read the map"),
            (read_plain(Path::new("no/such.png")).map(|_| ()), "such.png: image "),
            (
                write(&empty, Path::new("map.bmp")).map(|_| ()),
                "map.bmp: the extension names no format of maps, expected .txt, .map (MovingAI), .yaml (ROS), .png or .pgm",
            ),
            (write(&empty, Path::new("map")).map(|_| ()), "map: the extension names no format of maps"),
            (write(&empty, Path::new("no/such/folder/a.map")).map(|_| ()), "a.map: cannot write the map"),
        ] {
            let message = message.expect_err("refused").to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
