//! Writes pictures: 8-bit sRGB, rows from the top. A picture is whole under its name, or not there.

use std::io::{self, Cursor, Write};
use std::path::Path;

use exif::experimental::Writer;
use exif::{Field, In, Tag};
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError, ImageResult};

use crate::base::{Error, Result};
use crate::disk::{WriteSeek, write_atomic};
use crate::scene::moment::{Moment, zone_name};

/// Writes a JPEG of `width * height` pixels; `quality` from 1 to 100.
pub fn write_jpeg(path: &Path, pixels: &[[u8; 3]], width: u32, height: u32, quality: u8) -> Result<()> {
    write_jpeg_taken(path, pixels, [width, height], quality, None)
}

/// Writes a JPEG as [`write_jpeg`] does; where a time is given, its EXIF tells that it was taken then.
pub(crate) fn write_jpeg_taken(
    path: &Path,
    pixels: &[[u8; 3]],
    [width, height]: [u32; 2],
    quality: u8,
    time: Option<Moment>,
) -> Result<()> {
    let exif = time.map(|time| taken_at(time).map_err(Error::io("write", path))).transpose()?;
    write(path, |out| {
        let mut encoder = JpegEncoder::new_with_quality(out, quality);
        if let Some(exif) = exif {
            encoder.set_exif_metadata(exif).map_err(ImageError::Unsupported)?;
        }
        encoder.encode(pixels.as_flattened(), width, height, ExtendedColorType::Rgb8)
    })
}

/// EXIF that tells when a photograph was taken, in the form that cameras have: 2014:05:26 12:45:30.
fn taken_at(time: Moment) -> io::Result<Vec<u8>> {
    let clock: String = time.to_string().chars().take(19).collect();
    let clock = clock.replace('-', ":").replace('T', " ");
    let said = |tag: Tag, text: String| Field {
        tag,
        ifd_num: In::PRIMARY,
        value: exif::Value::Ascii(vec![text.into_bytes()]),
    };
    let fields = [
        Some(said(Tag::DateTimeOriginal, clock)),
        time.zone.map(|zone| said(Tag::OffsetTimeOriginal, zone_name(zone))),
    ];
    let (mut writer, mut exif) = (Writer::new(), Cursor::new(Vec::new()));
    fields.iter().flatten().for_each(|field| writer.push_field(field));
    writer.write(&mut exif, false).map_err(io::Error::other)?;
    Ok(exif.into_inner())
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
