//! Writes pictures: 8-bit sRGB, rows from the top.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageResult};

use crate::base::{Error, Result};

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

fn write(path: &Path, encode: impl FnOnce(&mut BufWriter<File>) -> ImageResult<()>) -> Result<()> {
    let mut out = BufWriter::new(File::create(path).map_err(Error::io("create", path))?);
    encode(&mut out).map_err(|why| Error::io("write", path)(std::io::Error::other(why)))?;
    out.flush().map_err(Error::io("write", path))
}
