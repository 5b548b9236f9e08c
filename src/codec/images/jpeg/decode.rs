//! From a whole JPEG to samples.

use std::io::Cursor;
use std::iter::once;

use image::{DynamicImage, GrayImage, RgbImage};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::{ZByteReaderTrait, ZCursor};
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::header::Header;
use super::parts::Parts;
use super::whole::{Spare, check};
use crate::base::convert::to_usize;
use crate::codec::images::size::Size;

/// The marker that ends an image.
const END: &[u8] = &[0xff, 0xd9];

/// Decodes the samples, grey or RGB, of a file with this header.
///
/// # Errors
/// In words: what is missing of the image or damaged; what the decoder says.
pub(in crate::codec::images) fn decode(file: &[u8], header: &Header) -> Result<DynamicImage, String> {
    let Spare { junk, end } = check(file, header.size)?;
    if junk.is_empty() && file[end..].starts_with(END) {
        return samples(ZCursor::new(&file[..end + END.len()]), header);
    }
    let starts = once(0).chain(junk.iter().map(|bytes| bytes.end));
    let ends = junk.iter().map(|bytes| bytes.start).chain(once(end));
    let kept = starts.zip(ends).map(|(start, end)| &file[start..end]);
    samples(Parts::new(kept.chain(once(END))), header)
}

/// Checks that a JPEG within another file is whole.
///
/// # Errors
/// In words: what is missing of the image or damaged.
pub(in crate::codec::images) fn check_whole(file: &[u8]) -> Result<(), String> {
    let header = Header::read(&mut Cursor::new(file)).map_err(|why| why.to_string())?;
    check(file, header.size).map(drop)
}

fn samples(file: impl ZByteReaderTrait, header: &Header) -> Result<DynamicImage, String> {
    let Size { width, height } = header.size;
    let space = if header.channels == 1 { ColorSpace::Luma } else { ColorSpace::RGB };
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(width as usize)
        .set_max_height(height as usize)
        .jpeg_set_out_colorspace(space);
    let mut decoder = JpegDecoder::new_with_options(file, options);
    decoder.decode_headers().map_err(|why| why.to_string())?;
    let needed = header.size.pixels() * header.channels;
    if decoder.output_buffer_size().map(|size| size as u64) != Some(needed) {
        return Err("the decoder finds another size than the markers have".to_owned());
    }
    let mut samples = vec![0; to_usize(needed)];
    decoder.decode_into(&mut samples).map_err(|why| why.to_string())?;
    let picture = match space {
        ColorSpace::Luma => GrayImage::from_raw(width, height, samples).map(DynamicImage::from),
        _ => RgbImage::from_raw(width, height, samples).map(DynamicImage::from),
    };
    picture.ok_or_else(|| "it has no pixels".to_owned())
}
