//! PNG (ISO/IEC 15948): decoded without texts and profiles, which may be longer than the pixels and are not needed.
//!
//! Layout (clause 5): a signature of 8 bytes, then chunks: length u32, name of 4 bytes, so many bytes, crc u32; big endian.
//! The pixels are in chunks IDAT, one after the other. The last chunk, IEND, may be missing (`ended`).

use std::io::{self, BufRead, ErrorKind, Read, Seek};

use image::{ColorType, DynamicImage, ImageBuffer};
use png::{BitDepth, DecodingError, Limits, Reader, Transformations};

use super::ended::Ended;
use super::need::PNG_METADATA;
use super::size::Size;
use crate::base::convert::to_usize;
use crate::base::shown::brief;

/// The most chunks before the pixels; programs write ten.
const MOST: u32 = 4096;

/// Chunks that the decoder passes over.
const PASSED_OVER: [&[u8; 4]; 4] = [b"tEXt", b"zTXt", b"iTXt", b"iCCP"];

/// A file whose header is read.
pub(super) struct Header<R: BufRead + Seek> {
    reader: Reader<Ended<R>>,
    /// The size of the picture.
    pub size: Size,
    /// The samples that it is decoded to.
    pub color: ColorType,
    /// The bytes that come before the pixels and are held.
    pub metadata: u64,
}

impl<R: BufRead + Seek> Header<R> {
    /// Reads the chunks before the pixels.
    ///
    /// # Errors
    /// The system's; `UnexpectedEof` where the file ends before its pixels; `InvalidData`, in words, for what is damaged, too
    /// many or too long.
    pub(super) fn read(file: R) -> io::Result<Self> {
        let mut file = Ended::of(file);
        let metadata = metadata(&mut file)?;
        let mut decoder = png::Decoder::new_with_limits(file, Limits { bytes: to_usize(PNG_METADATA) });
        decoder.set_ignore_text_chunk(true);
        decoder.set_ignore_iccp_chunk(true);
        decoder.set_transformations(Transformations::EXPAND);
        let (width, height) = decoder.read_header_info().map_err(words)?.size();
        let size = Size { width, height };
        if let Some(why) = size.too_large() {
            return Err(invalid(why));
        }
        let reader = decoder.read_info().map_err(words)?;
        let (color, depth) = reader.output_color_type();
        let color = match (color, depth) {
            (png::ColorType::Grayscale, BitDepth::Eight) => ColorType::L8,
            (png::ColorType::Grayscale, BitDepth::Sixteen) => ColorType::L16,
            (png::ColorType::GrayscaleAlpha, BitDepth::Eight) => ColorType::La8,
            (png::ColorType::GrayscaleAlpha, BitDepth::Sixteen) => ColorType::La16,
            (png::ColorType::Rgb, BitDepth::Eight) => ColorType::Rgb8,
            (png::ColorType::Rgb, BitDepth::Sixteen) => ColorType::Rgb16,
            (png::ColorType::Rgba, BitDepth::Eight) => ColorType::Rgba8,
            (png::ColorType::Rgba, BitDepth::Sixteen) => ColorType::Rgba16,
            other => return Err(invalid(format!("samples of {other:?} are not read"))),
        };
        Ok(Header { reader, size, color, metadata })
    }

    /// Decodes the pixels.
    ///
    /// # Errors
    /// Those of [`Header::read`].
    pub(super) fn decode(mut self) -> io::Result<DynamicImage> {
        let Size { width, height } = self.size;
        let mut bytes = vec![0; to_usize(self.size.pixels() * u64::from(self.color.bytes_per_pixel()))];
        self.reader.next_frame(&mut bytes).map_err(words)?;
        let picture = match self.color {
            ColorType::L8 => ImageBuffer::from_raw(width, height, bytes).map(DynamicImage::ImageLuma8),
            ColorType::La8 => ImageBuffer::from_raw(width, height, bytes).map(DynamicImage::ImageLumaA8),
            ColorType::Rgb8 => ImageBuffer::from_raw(width, height, bytes).map(DynamicImage::ImageRgb8),
            ColorType::Rgba8 => ImageBuffer::from_raw(width, height, bytes).map(DynamicImage::ImageRgba8),
            color => {
                let wide = bytes.as_chunks().0.iter().map(|&sample| u16::from_be_bytes(sample)).collect();
                match color {
                    ColorType::L16 => ImageBuffer::from_raw(width, height, wide).map(DynamicImage::ImageLuma16),
                    ColorType::La16 => ImageBuffer::from_raw(width, height, wide).map(DynamicImage::ImageLumaA16),
                    ColorType::Rgb16 => ImageBuffer::from_raw(width, height, wide).map(DynamicImage::ImageRgb16),
                    _ => ImageBuffer::from_raw(width, height, wide).map(DynamicImage::ImageRgba16),
                }
            }
        };
        picture.ok_or_else(|| invalid("some of its pixels are missing".to_owned()))
    }
}

/// The bytes of the chunks before the pixels that the decoder holds; goes back to the start.
fn metadata(file: &mut (impl Read + Seek)) -> io::Result<u64> {
    file.rewind()?;
    io::copy(&mut file.by_ref().take(8), &mut io::sink())?;
    let mut all = 0;
    for _ in 0..MOST {
        let mut head = [0; 8];
        file.read_exact(&mut head)?;
        let [l0, l1, l2, l3, name @ ..] = head;
        if name == *b"IDAT" {
            file.rewind()?;
            return Ok(all);
        }
        let length = u32::from_be_bytes([l0, l1, l2, l3]);
        if !PASSED_OVER.contains(&&name) {
            all += u64::from(length);
        }
        if all > PNG_METADATA {
            return Err(invalid(format!("more than {PNG_METADATA} bytes come before its pixels")));
        }
        file.seek_relative(i64::from(length) + 4)?;
    }
    Err(invalid(format!("more than {MOST} chunks come before its pixels")))
}

fn words(why: DecodingError) -> io::Error {
    match why {
        DecodingError::IoError(why) => why,
        why => invalid(brief(&why)),
    }
}

fn invalid(words: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, words)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn found(chunks: &[(&[u8; 4], usize)]) -> Result<u64, ErrorKind> {
        let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
        for (name, length) in chunks {
            file.extend((*length as u32).to_be_bytes());
            file.extend(*name);
            file.extend(vec![0; length + 4]);
        }
        let mut file = Cursor::new(file);
        let found = metadata(&mut file).map_err(|why| why.kind());
        assert!(found.is_err() || file.position() == 0);
        found
    }

    #[test]
    fn what_comes_before_the_pixels_is_counted_before_it_is_held() {
        assert_eq!(found(&[(b"IHDR", 13), (b"eXIf", 3000), (b"IDAT", 10), (b"tEXt", 99)]), Ok(3013));
        assert_eq!(found(&[(b"IHDR", 13), (b"tEXt", 9 << 20), (b"iCCP", 9 << 20), (b"IDAT", 10)]), Ok(13));
        assert_eq!(found(&[(b"IHDR", 13), (b"eXIf", 4 << 20), (b"IDAT", 10)]), Err(ErrorKind::InvalidData));
        assert_eq!(found(&[(b"tEXt", 1); 5000]), Err(ErrorKind::InvalidData));
        assert_eq!(found(&[(b"IHDR", 13), (b"tEXt", 3)]), Err(ErrorKind::UnexpectedEof));
        assert_eq!(found(&[]), Err(ErrorKind::UnexpectedEof));
    }
}
