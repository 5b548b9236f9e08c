//! JPEG (ITU-T T.81): what its markers say of its size and of what decoding it takes, whether it is all there, and its
//! samples.

use std::io::{self, ErrorKind, Read, Seek};

use image::{DynamicImage, GrayImage, RgbImage};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// What the markers before the first scan say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// Columns and rows.
    pub size: (u32, u32),
    /// Samples of a decoded pixel: 1 if grey, else 3.
    pub channels: u64,
    /// Bytes that the decoder holds beside file and pixels.
    pub workspace: u64,
}

impl Header {
    /// Reads the markers up to the first scan.
    ///
    /// # Errors
    /// `UnexpectedEof` where the file ends before a scan, `InvalidData` where a scan comes without a frame before it.
    pub fn read(file: &mut (impl Read + Seek)) -> io::Result<Header> {
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

/// A frame header.
struct Frame {
    size: (u32, u32),
    progressive: bool,
    /// Horizontal and vertical sampling factors.
    components: Vec<(u64, u64)>,
}

impl Frame {
    /// Reads it from after its first sample's bits.
    fn read(marker: u8, file: &mut impl Read) -> io::Result<Frame> {
        let [h0, h1, w0, w1, count] = bytes(file)?;
        let size = (u32::from(u16::from_be_bytes([w0, w1])), u32::from(u16::from_be_bytes([h0, h1])));
        let component = |_| bytes(file).map(|[_, factors, _]| (u64::from(factors >> 4), u64::from(factors & 15)));
        let components = (0..count).map(component).collect::<io::Result<_>>()?;
        Ok(Frame { size, progressive: matches!(marker, 0xc2 | 0xc6 | 0xca | 0xce), components })
    }

    /// What decoding takes where the first scan has this many components and comes after this many bytes.
    ///
    /// The decoder holds all coefficients, 2 bytes each, where scans come one after another; else those of a row of
    /// blocks, which it also scales up to the pixels' grid.
    fn header(self, scanned: usize, metadata: u64) -> Header {
        let Frame { size: (width, height), progressive, components } = self;
        let most = |factor: fn(&(u64, u64)) -> u64| components.iter().map(factor).max().unwrap_or(1).max(1);
        let (across, down) = (most(|c| c.0), most(|c| c.1));
        let (columns, rows) = (u64::from(width).div_ceil(8 * across), u64::from(height).div_ceil(8 * down));
        let blocks: u64 = components.iter().map(|&(h, v)| columns * h * rows * v).sum();
        let held = progressive || scanned < components.len();
        let coefficients = if held { blocks * 64 * 2 } else { 0 };
        let row = columns * across * 8 * down * 8 * 2;
        let rows = components.len() as u64 * row * (2 + across * down);
        let channels = if components.len() == 1 { 1 } else { 3 };
        // Profiles and previews in the file's head are copied.
        Header { size: (width, height), channels, workspace: coefficients + rows + 2 * metadata }
    }
}

fn bytes<const N: usize>(file: &mut impl Read) -> io::Result<[u8; N]> {
    let mut found = [0; N];
    file.read_exact(&mut found)?;
    Ok(found)
}

/// The next marker: 0xff, and any byte but 0 (a stuffed 0xff of coded data) and 0xff (a fill byte).
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

/// Decodes the samples, grey or RGB, of a file whose header said this.
///
/// # Errors
/// What the decoder says, in words.
pub fn decode(bytes: &[u8], header: &Header) -> Result<DynamicImage, String> {
    let (width, height) = header.size;
    let space = if header.channels == 1 { ColorSpace::Luma } else { ColorSpace::RGB };
    let options = DecoderOptions::default()
        .set_strict_mode(false)
        .set_max_width(width as usize)
        .set_max_height(height as usize)
        .jpeg_set_out_colorspace(space);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|why| why.to_string())?;
    let needed = u64::from(width) * u64::from(height) * header.channels;
    if decoder.output_buffer_size().map(|size| size as u64) != Some(needed) {
        return Err("the decoder finds another size than the markers say".to_owned());
    }
    let mut samples = vec![0; needed as usize];
    decoder.decode_into(&mut samples).map_err(|why| why.to_string())?;
    let picture = match space {
        ColorSpace::Luma => GrayImage::from_raw(width, height, samples).map(DynamicImage::from),
        _ => RgbImage::from_raw(width, height, samples).map(DynamicImage::from),
    };
    picture.ok_or_else(|| "it has no pixels".to_owned())
}

/// Whether the markers (annex B) lead from the start of the image to its end. What follows the end is not looked at:
/// cameras append previews. Decoders fill what is cut off with grey, which must not count as radiance.
pub fn is_whole(bytes: &[u8]) -> bool {
    let mut rest = bytes;
    loop {
        // As in `next_marker`.
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
