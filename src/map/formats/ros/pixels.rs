//! From the pixels of an image to the occupancy of cells.

use super::header::{Header, Mode};
use super::{FREE, OCCUPIED, RosMap, UNKNOWN};
use crate::files;
use crate::geometry::Pose;
use crate::map::file::IMAGE_BYTES_MAX;
use crate::map::{Frame, MapError, SIDE_MAX};
use image::{DynamicImage, ImageBuffer, ImageFormat, ImageReader, Limits, Pixel};
use std::io::BufReader;
use std::path::Path;

impl Header {
    /// The map of an image.
    pub(super) fn map(&self, image: &DynamicImage) -> RosMap {
        let occupancy = match image {
            DynamicImage::ImageLuma8(pixels) => self.occupancy(pixels, u8::MAX.into()),
            DynamicImage::ImageLumaA8(pixels) => self.occupancy(pixels, u8::MAX.into()),
            DynamicImage::ImageRgb8(pixels) => self.occupancy(pixels, u8::MAX.into()),
            DynamicImage::ImageRgba8(pixels) => self.occupancy(pixels, u8::MAX.into()),
            DynamicImage::ImageLuma16(pixels) => self.occupancy(pixels, u16::MAX.into()),
            DynamicImage::ImageLumaA16(pixels) => self.occupancy(pixels, u16::MAX.into()),
            DynamicImage::ImageRgb16(pixels) => self.occupancy(pixels, u16::MAX.into()),
            // Four channels of 16 bits hold every other kind.
            other => self.occupancy(&other.to_rgba16(), u16::MAX.into()),
        };
        let [x, y, yaw] = self.origin.map(|number| number.get());
        RosMap {
            cols: image.width() as usize,
            resolution_m: self.resolution.get(),
            frame: Frame { origin: Pose::new(x, y, yaw) },
            occupancy,
        }
    }

    /// The occupancy of each pixel, the bottom row first; `full` is the largest value of a channel.
    fn occupancy<P>(&self, image: &ImageBuffer<P, Vec<P::Subpixel>>, full: u32) -> Vec<i8>
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
                self.cell(f64::from(sum), white, opaque)
            }));
        }
        occupancy
    }

    /// The occupancy of a pixel whose channels add up to `sum`; those of white add up to `white`.
    fn cell(&self, sum: f64, white: f64, opaque: bool) -> i8 {
        if self.mode == Mode::Raw {
            let value = (sum * 255.0 / white).round();
            return if value <= f64::from(OCCUPIED) { value as i8 } else { UNKNOWN };
        }
        let darkness = if self.negate.0 { sum / white } else { (white - sum) / white };
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

/// Decodes a PGM (or another of the PNM family) or PNG image; its first bytes say which it is.
pub(super) fn decode(file: &Path) -> Result<DynamicImage, MapError> {
    let refuse = |found: String, advice| MapError::Image {
        image: file.into(),
        found,
        expected: format!("a PGM or PNG image of at most {SIDE_MAX} x {SIDE_MAX} pixels"),
        advice,
    };
    let open = || ImageReader::new(BufReader::new(files::open(file, IMAGE_BYTES_MAX)?)).with_guessed_format();
    let mut reader =
        open().map_err(|error| refuse(error.to_string(), "`image` is relative to the folder of the YAML file"))?;
    let format = reader.format();
    if !matches!(format, Some(ImageFormat::Png | ImageFormat::Pnm)) {
        let found = format.map_or("an unknown format".to_owned(), |format| format!("the format {format:?}"));
        return Err(refuse(found, "convert it, for example with `magick IN OUT.png`"));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(SIDE_MAX as u32);
    limits.max_image_height = Some(SIDE_MAX as u32);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| refuse(error.to_string(), "is the file whole?"))?;
    if image.width() == 0 || image.height() == 0 {
        return Err(refuse("an image without pixels".to_owned(), "is the file whole?"));
    }
    Ok(image)
}
