//! From the pixels of an image to the occupancy of cells.

use super::header::{Header, Mode};
use super::{FREE, OCCUPIED, RosMap, UNKNOWN, pnm};
use crate::files::{self, FileError};
use crate::geometry::Pose;
use crate::map::file::IMAGE_BYTES_MAX;
use crate::map::{Frame, MapError, SIDE_MAX};
use crate::settings::quantity::counted;
use image::error::LimitErrorKind;
use image::{DynamicImage, ImageBuffer, ImageError, ImageFormat, ImageReader, Limits, Pixel};
use std::io::BufReader;
use std::path::Path;

impl Header {
    /// The map of an image.
    pub(super) fn map(&self, image: &DynamicImage) -> RosMap {
        let mut seen = Seen::default();
        let occupancy = match image {
            DynamicImage::ImageLuma8(pixels) => self.occupancy(pixels, u8::MAX.into(), &mut seen),
            DynamicImage::ImageLumaA8(pixels) => self.occupancy(pixels, u8::MAX.into(), &mut seen),
            DynamicImage::ImageRgb8(pixels) => self.occupancy(pixels, u8::MAX.into(), &mut seen),
            DynamicImage::ImageRgba8(pixels) => self.occupancy(pixels, u8::MAX.into(), &mut seen),
            DynamicImage::ImageLuma16(pixels) => self.occupancy(pixels, u16::MAX.into(), &mut seen),
            DynamicImage::ImageLumaA16(pixels) => self.occupancy(pixels, u16::MAX.into(), &mut seen),
            DynamicImage::ImageRgb16(pixels) => self.occupancy(pixels, u16::MAX.into(), &mut seen),
            // Four channels of 16 bits hold every other kind.
            other => self.occupancy(&other.to_rgba16(), u16::MAX.into(), &mut seen),
        };
        let [x, y, yaw] = self.origin.map(|number| number.get());
        RosMap {
            cols: image.width() as usize,
            resolution_m: self.resolution.get(),
            frame: Frame { origin: Pose::new(x, y, yaw) },
            occupancy,
            notes: seen.notes(),
        }
    }

    /// The occupancy of each pixel, the bottom row first; `full` is the largest value of a channel.
    fn occupancy<P>(&self, image: &ImageBuffer<P, Vec<P::Subpixel>>, full: u32, seen: &mut Seen) -> Vec<i8>
    where
        P: Pixel<Subpixel: Into<u32>>,
    {
        let has_alpha = matches!(P::COLOR_MODEL, "YA" | "LA" | "RGBA");
        let colours = usize::from(P::CHANNEL_COUNT) - usize::from(has_alpha);
        let white = f64::from(full) * colours as f64;
        let mut occupancy = Vec::with_capacity(image.len() / usize::from(P::CHANNEL_COUNT));
        for row in image.rows().rev() {
            occupancy.extend(row.map(|pixel| {
                let channels = pixel.channels();
                // Whole numbers, so that the one division is the only rounding.
                let sum: u32 = channels[..colours].iter().map(|&channel| channel.into()).sum();
                let opaque = channels[colours..].iter().all(|&alpha| alpha.into() == full);
                let cell = self.cell(f64::from(sum), white, opaque);
                seen.look(self, f64::from(sum), white, cell);
                cell
            }));
        }
        occupancy
    }

    fn darkness(&self, sum: f64, white: f64) -> f64 {
        if self.negate.0 { sum / white } else { (white - sum) / white }
    }

    /// The occupancy of a pixel whose channels add up to `sum`; those of white add up to `white`.
    fn cell(&self, sum: f64, white: f64, opaque: bool) -> i8 {
        if self.mode == Mode::Raw {
            let value = (sum * 255.0 / white).round();
            return if value <= f64::from(OCCUPIED) { value as i8 } else { UNKNOWN };
        }
        let darkness = self.darkness(sum, white);
        let (free, occupied) = (self.free_thresh.get(), self.occupied_thresh.get());
        if !opaque {
            UNKNOWN
        } else if darkness > occupied {
            OCCUPIED
        } else if darkness < free {
            FREE
        } else if self.mode == Mode::Scale {
            ((darkness - free) / (occupied - free) * f64::from(OCCUPIED)).round() as i8
        } else {
            UNKNOWN
        }
    }
}

/// The grey that the map savers of ROS write for unknown cells, of 255.
const SAVED_UNKNOWN: f64 = 205.0;

/// Pixels that may not mean what whoever saved the map meant.
#[derive(Default)]
struct Seen {
    /// Pixels of the savers' grey for unknown that are free.
    unknown_as_free: usize,
    /// Pixels whose darkness is a threshold.
    on_threshold: usize,
}

impl Seen {
    fn look(&mut self, header: &Header, sum: f64, white: f64, cell: i8) {
        if header.mode == Mode::Raw {
            return;
        }
        self.unknown_as_free += usize::from(cell == FREE && sum * 255.0 == SAVED_UNKNOWN * white);
        let darkness = header.darkness(sum, white);
        let is_exact = darkness == header.occupied_thresh.get() || darkness == header.free_thresh.get();
        self.on_threshold += usize::from(is_exact && cell == UNKNOWN);
    }

    fn notes(&self) -> Vec<String> {
        let grey = ("grey 205, which map savers write for unknown, is free by `free_thresh`", self.unknown_as_free);
        let exact = (
            "darkness that is exactly a threshold is unknown, as in ROS 1 and Nav2 up to Jazzy, and occupied or free in newer ones",
            self.on_threshold,
        );
        let noted = [grey, exact].into_iter().filter(|(_, cells)| *cells > 0);
        noted.map(|(what, cells)| format!("{what}: {}", counted(cells as u64, "cell"))).collect()
    }
}

/// Decodes a PGM (or another of the PNM family), PNG or BMP image; its first bytes say which it is. `beside` is the folder of the header
/// that names the image.
pub(super) fn decode(file: &Path, beside: Option<&Path>) -> Result<DynamicImage, MapError> {
    let refuse_for = |found: String, expected: String, advice: String| MapError::Image {
        image: file.into(),
        found,
        expected,
        advice,
    };
    let refuse = |found: String, advice: &str| {
        let expected = format!("a PGM, PNG or BMP image of at most {SIDE_MAX} x {SIDE_MAX} pixels");
        refuse_for(found, expected, advice.to_owned())
    };
    let open = || files::open(file, IMAGE_BYTES_MAX).map(BufReader::new);
    let opened = open().map_err(|error| match (error, beside) {
        (FileError::Kind { found }, _) => refuse(found.to_owned(), "name the image itself"),
        (error, Some(folder)) if error.is_missing() => {
            let other = file.file_name().map(|name| folder.join(name)).filter(|other| other != file && other.is_file());
            match other {
                Some(other) => {
                    let name = other.file_name().unwrap_or_default().display();
                    refuse(error.to_string(), &format!("`{name}` lies beside the YAML file: write `image: {name}`"))
                }
                None => refuse(error.to_string(), "`image` is relative to the folder of the YAML file"),
            }
        }
        (error, _) if error.is_missing() => refuse(error.to_string(), "is the name right?"),
        (error, _) => refuse(error.to_string(), "is it the right file?"),
    })?;
    let guessed = ImageReader::new(opened).with_guessed_format();
    let mut reader = guessed.map_err(|error| refuse(error.to_string(), "is the file whole?"))?;
    let format = reader.format();
    if !matches!(format, Some(ImageFormat::Png | ImageFormat::Pnm | ImageFormat::Bmp)) {
        let found = format.map_or("an unknown format".to_owned(), |format| format!("the format {format:?}"));
        return Err(refuse(found, "convert it, for example with `magick IN OUT.png`"));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(SIDE_MAX as u32);
    limits.max_image_height = Some(SIDE_MAX as u32);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| match &error {
        ImageError::Limits(limit) if matches!(limit.kind(), LimitErrorKind::DimensionError) => {
            refuse("more pixels".to_owned(), "cut or scale it")
        }
        ImageError::Limits(_) => {
            refuse("an image that takes too much memory".to_owned(), "save it in 8 bits of grey, or scale it down")
        }
        _ => refuse(error.to_string(), "is the file whole?"),
    })?;
    if image.width() == 0 || image.height() == 0 {
        return Err(refuse("an image without pixels".to_owned(), "is the file whole?"));
    }
    if format == Some(ImageFormat::Pnm) {
        let surplus = open().map_err(std::io::Error::from).and_then(pnm::surplus);
        if let Some((found, expected)) = surplus.map_err(|error| refuse(error.to_string(), "is the file whole?"))? {
            let advice = "were line ends turned when it was saved, which moves every pixel? Save it anew";
            return Err(refuse_for(found, expected, advice.to_owned()));
        }
    }
    Ok(image)
}
