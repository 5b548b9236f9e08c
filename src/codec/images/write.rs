//! Writes pictures: 8-bit sRGB, rows from the top. A picture is whole under its name, or not there.

use std::io::{self, Write};
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
    write_atomic(path, |out| encode_png(out, pixels, width, height).map_err(Error::io("write", path)))
}

/// Writes a PNG of `width * height` pixels to an open file.
pub(crate) fn encode_png(out: impl Write, pixels: &[[u8; 3]], width: u32, height: u32) -> io::Result<()> {
    let encoder = PngEncoder::new(out);
    encoder.write_image(pixels.as_flattened(), width, height, ExtendedColorType::Rgb8).map_err(io::Error::other)
}

fn write(path: &Path, encode: impl FnOnce(&mut (dyn WriteSeek + '_)) -> ImageResult<()>) -> Result<()> {
    write_atomic(path, |out| encode(out).map_err(|why| Error::io("write", path)(io::Error::other(why))))
}
