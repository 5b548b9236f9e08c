//! JPEG (ITU-T T.81): its size and the memory that decoding takes, from its markers; whether it is whole; its samples.

use std::io::{self, ErrorKind, Read, Seek};

use image::{DynamicImage, GrayImage, RgbImage};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::size::Size;
use crate::base::convert::to_usize;

/// The contents of the markers before the first scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Header {
    /// The size of the image.
    pub size: Size,
    /// The samples of a decoded pixel: 1 if grey, else 3.
    pub channels: u64,
    /// The bytes that the decoder holds beside the file and the pixels.
    pub workspace: u64,
}

impl Header {
    /// Reads the markers up to the first scan.
    ///
    /// # Errors
    /// `UnexpectedEof` where the file ends before a scan, `InvalidData` where a scan comes without a frame before it.
    pub(super) fn read(file: &mut (impl Read + Seek)) -> io::Result<Header> {
        let mut frame: Option<Frame> = None;
        loop {
            let marker = next_marker(file)?;
            // Restarts, start and end of image, and 1 stand alone.
            if matches!(marker, 0x01 | 0xd0..=0xd9) {
                continue;
            }
            let [high, low, first] = bytes(file)?;
            let length = i64::from(u16::from_be_bytes([high, low]));
            match marker {
                // Not Huffman tables, nor the reserved, nor arithmetic conditioning.
                0xc0..=0xcf if !matches!(marker, 0xc4 | 0xc8 | 0xcc) => frame = Some(Frame::read(marker, file)?),
                0xda => {
                    let metadata = file.stream_position()?;
                    let none = || io::Error::new(ErrorKind::InvalidData, "a scan without a frame header");
                    return Ok(frame.ok_or_else(none)?.header(usize::from(first), metadata));
                }
                _ => file.seek_relative((length - 3).max(0))?,
            }
        }
    }
}

/// The sampling factors of a component.
struct Sampling {
    across: u64,
    down: u64,
}

/// A frame header.
struct Frame {
    size: Size,
    progressive: bool,
    components: Vec<Sampling>,
}

impl Frame {
    /// Reads the header from behind its first byte, the bits of a sample.
    fn read(marker: u8, file: &mut impl Read) -> io::Result<Frame> {
        let [h0, h1, w0, w1, count] = bytes(file)?;
        let side = |bytes| u32::from(u16::from_be_bytes(bytes));
        let size = Size { width: side([w0, w1]), height: side([h0, h1]) };
        let component = |_| {
            let [_, factors, _] = bytes(file)?;
            Ok(Sampling { across: u64::from(factors >> 4), down: u64::from(factors & 15) })
        };
        let components = (0..count).map(component).collect::<io::Result<_>>()?;
        Ok(Frame { size, progressive: matches!(marker, 0xc2 | 0xc6 | 0xca | 0xce), components })
    }

    /// The header of a file whose first scan has `scanned` components and comes after `metadata` bytes.
    ///
    /// The decoder holds all coefficients, 2 bytes each, where there are several scans; else those of a row of blocks, which
    /// it also scales up to the grid of the pixels.
    fn header(self, scanned: usize, metadata: u64) -> Header {
        let Frame { size, progressive, components } = self;
        let most = |factor: fn(&Sampling) -> u64| components.iter().map(factor).max().unwrap_or(1).max(1);
        let (across, down) = (most(|c| c.across), most(|c| c.down));
        let (columns, rows) = (u64::from(size.width).div_ceil(8 * across), u64::from(size.height).div_ceil(8 * down));
        let blocks: u64 = components.iter().map(|c| columns * c.across * rows * c.down).sum();
        let held = progressive || scanned < components.len();
        let coefficients = if held { blocks * 64 * 2 } else { 0 };
        let row = columns * across * 8 * down * 8 * 2;
        let rows = components.len() as u64 * row * (2 + across * down);
        let channels = if components.len() == 1 { 1 } else { 3 };
        // The decoder copies profiles and previews from the file's head.
        Header { size, channels, workspace: coefficients + rows + 2 * metadata }
    }
}

fn bytes<const N: usize>(file: &mut impl Read) -> io::Result<[u8; N]> {
    let mut found = [0; N];
    file.read_exact(&mut found)?;
    Ok(found)
}

/// The next marker: 0xff, and then any byte but 0 (0xff was coded data) and 0xff (a fill byte).
fn next_marker(file: &mut impl Read) -> io::Result<u8> {
    let mut last = 0;
    loop {
        let [byte] = bytes(file)?;
        if last == 0xff && !matches!(byte, 0 | 0xff) {
            return Ok(byte);
        }
        last = byte;
    }
}

/// Decodes the samples, grey or RGB, of a file with this header.
///
/// # Errors
/// In words: those of the decoder.
pub(super) fn decode(bytes: &[u8], header: &Header) -> Result<DynamicImage, String> {
    let Size { width, height } = header.size;
    let space = if header.channels == 1 { ColorSpace::Luma } else { ColorSpace::RGB };
    let options = DecoderOptions::default()
        .set_strict_mode(false)
        .set_max_width(width as usize)
        .set_max_height(height as usize)
        .jpeg_set_out_colorspace(space);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
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

/// Whether the markers (annex B) lead from the start of the image to its end. Bytes after the end are not looked at:
/// cameras append previews. Decoders fill a part that is cut off with grey, which must not count as radiance.
pub(super) fn is_whole(bytes: &[u8]) -> bool {
    let mut rest = bytes;
    loop {
        // A marker as in `next_marker`.
        let Some(at) = rest.windows(2).position(|w| w[0] == 0xff && !matches!(w[1], 0 | 0xff)) else { return false };
        let marker = rest[at + 1];
        rest = &rest[at + 2..];
        match marker {
            0xd9 => return true,
            // Restarts, start of image, and 1 stand alone.
            0x01 | 0xd0..=0xd8 => {}
            _ => {
                let Some(&[high, low]) = rest.first_chunk::<2>() else { return false };
                // IMPORTANT: segments are skipped by their length, since a thumbnail in one of them has an end too.
                let Some(after) = rest.get(usize::from(u16::from_be_bytes([high, low]))..) else { return false };
                rest = after;
            }
        }
    }
}
