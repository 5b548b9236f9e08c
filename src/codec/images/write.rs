//! Writes pictures: 8-bit sRGB, rows from the top. A picture is whole under its name, or not there.

use std::path::Path;

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageResult};

use crate::base::{Error, Result};
use crate::disk::{WriteSeek, write_atomic};

/// Writes a JPEG of `width * height` pixels; `quality` from 1 to 100.
pub fn write_jpeg(path: &Path, pixels: &[[u8; 3]], width: u32, height: u32, quality: u8) -> Result<()> {
    write(path, |out| {
        JpegEncoder::new_with_quality(out, quality).encode(
            pixels.as_flattened(),
            width,
            height,
            ExtendedColorType::Rgb8,
        )
    })
}

/// Writes a PNG of `width * height` pixels.
pub fn write_png(path: &Path, pixels: &[[u8; 3]], width: u32, height: u32) -> Result<()> {
    write(path, |out| PngEncoder::new(out).write_image(pixels.as_flattened(), width, height, ExtendedColorType::Rgb8))
}

fn write(path: &Path, encode: impl FnOnce(&mut (dyn WriteSeek + '_)) -> ImageResult<()>) -> Result<()> {
    write_atomic(path, |out| encode(out).map_err(|why| Error::io("write", path)(std::io::Error::other(why))))
}
