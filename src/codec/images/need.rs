//! The memory that reading an image takes, known from its header before a sample is decoded.

use image::ColorType;

use super::size::Size;
use super::{exr, jpeg};

/// The bytes of memory that reading an image takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Need {
    /// The most that is held while the image is read.
    pub peak: u64,
    /// The memory that the image holds once it is read.
    pub held: u64,
}

impl Need {
    /// The need of an image and then of its mask.
    #[must_use]
    pub fn then(self, mask: Need) -> Need {
        Need { peak: self.peak.max(self.held + mask.peak), held: self.held + mask.held }
    }

    /// The need of a baseline JPEG of this many pixels and of the usual length: for files that are not there yet.
    pub fn usual(pixels: u64) -> Need {
        Need { peak: 3 * pixels + pixels / 2 + SLACK, held: 3 * pixels }
    }

    /// The need of a JPEG, without its bytes.
    pub(super) fn of_jpeg(header: &jpeg::Header, becomes: Becomes) -> Need {
        let pixels = header.size.pixels();
        let color = if header.channels == 1 { ColorType::L8 } else { ColorType::Rgb8 };
        Need::of(pixels * header.channels + header.workspace, pixels, color, becomes)
    }

    /// The need of an EXR, without its bytes.
    pub(super) fn of_exr(header: &exr::Header, becomes: Becomes) -> Need {
        let pixels = header.size.pixels();
        let color = if header.masked { ColorType::Rgba32F } else { ColorType::Rgb32F };
        let decoded = pixels * u64::from(color.bytes_per_pixel());
        Need::of(decoded.saturating_add(header.workspace), pixels, color, becomes)
    }

    /// The need of a PNG, without its bytes; its rows are decoded in place. `metadata` bytes come before its pixels: the
    /// decoder gathers a chunk in a vector that grows, and then keeps what it holds.
    pub(super) fn of_png(size: Size, color: ColorType, metadata: u64, becomes: Becomes) -> Need {
        let rows = 4 * u64::from(size.width) * u64::from(color.bytes_per_pixel());
        let decoded = size.pixels() * u64::from(color.bytes_per_pixel());
        // 16 bits are put into the order of this machine in a second buffer.
        let wide = if color.bytes_per_pixel() / color.channel_count() == 2 { decoded } else { 0 };
        Need::of(decoded + rows.max(wide) + 3 * metadata, size.pixels(), color, becomes)
    }

    /// The need of a TIFF of this many bytes, without these; it is decoded into a buffer and copied.
    pub(super) fn of_tiff(size: Size, color: ColorType, length: u64, becomes: Becomes) -> Need {
        let decoded = size.pixels() * u64::from(color.bytes_per_pixel());
        // A strip or tile of a compressed TIFF may be the whole image, and is held once more.
        let strip = if length < decoded { decoded } else { 0 };
        // In the buffer, CMYK has one channel more than RGB.
        let buffer = if color.has_color() { decoded / 3 * 4 } else { decoded };
        Need::of(buffer + decoded + strip + tiff_values(length, decoded), size.pixels(), color, becomes)
    }

    /// The need of a Radiance HDR, without its bytes; its rows are decoded in place.
    pub(super) fn of_hdr(size: Size, becomes: Becomes) -> Need {
        Need::of(12 * size.pixels() + 16 * u64::from(size.width), size.pixels(), ColorType::Rgb32F, becomes)
    }

    /// The need of an image that takes `decoding` bytes to decode and then has samples of `color`.
    fn of(decoding: u64, pixels: u64, color: ColorType, becomes: Becomes) -> Need {
        let decoded = pixels * u64::from(color.bytes_per_pixel());
        let (kept, held) = match (becomes, color) {
            (Becomes::Mask, ColorType::L8) => (true, decoded),
            (Becomes::Mask, _) => (false, pixels),
            (Becomes::Color, ColorType::Rgb8 | ColorType::Rgb16 | ColorType::Rgb32F) => (true, decoded),
            (Becomes::Color, color) => {
                let mask = u64::from(color.has_alpha());
                (false, pixels * (3 * u64::from(color.bytes_per_pixel() / color.channel_count()) + mask))
            }
        };
        let converting = if kept { decoded } else { decoded + held };
        Need { peak: decoding.max(converting).saturating_add(SLACK), held }
    }
}

/// The samples that an image is read as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Becomes {
    /// Red, green and blue, as wide as they are, and a mask of one byte a pixel if there is alpha.
    Color,
    /// A mask of one byte a pixel.
    Mask,
}

/// The bytes of buffers that do not grow with the image.
const SLACK: u64 = 1 << 20;

/// The most bytes that a PNG may hold before its pixels, without texts and profiles.
pub(super) const PNG_METADATA: u64 = 4 << 20;

/// The most bytes that the values of a TIFF's directory, and a strip before it is decompressed, may take. The TIFF has
/// `length` bytes, and `decoded` bytes once it is decoded.
pub(super) fn tiff_values(length: u64, decoded: u64) -> u64 {
    if length < decoded { length.min(64 << 20) + (1 << 20) } else { 4 << 20 }
}
