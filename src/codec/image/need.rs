//! What reading an image takes, known from its header before a sample is decoded.

use image::ColorType;

use super::{exr, jpeg};

/// Bytes of memory that reading an image takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Need {
    /// At its largest, while it is read.
    pub peak: u64,
    /// Once it is there.
    pub held: u64,
}

impl Need {
    /// Of this image, and then of the mask beside it.
    #[must_use]
    pub fn then(self, mask: Need) -> Need {
        Need { peak: self.peak.max(self.held + mask.peak), held: self.held + mask.held }
    }

    /// What a baseline JPEG of this many pixels takes, at its usual size: for files that are not there yet.
    pub fn usual(pixels: u64) -> Need {
        Need { peak: 3 * pixels + pixels / 2 + SLACK, held: 3 * pixels }
    }

    /// Of a JPEG of this many bytes.
    pub(super) fn of_jpeg(header: &jpeg::Header, length: u64, becomes: Becomes) -> Need {
        let pixels = pixels(header.size);
        let color = if header.channels == 1 { ColorType::L8 } else { ColorType::Rgb8 };
        Need::of(length + pixels * header.channels + header.workspace, pixels, color, becomes)
    }

    /// Of an EXR.
    pub(super) fn of_exr(header: &exr::Header, becomes: Becomes) -> Need {
        let pixels = pixels(header.size);
        let masked = becomes == Becomes::Masked && header.alpha;
        let color = if masked { ColorType::Rgba32F } else { ColorType::Rgb32F };
        Need::of(pixels * u64::from(color.bytes_per_pixel()) + header.workspace, pixels, color, becomes)
    }

    /// Of a PNG, whose rows are decoded in place.
    pub(super) fn of_png(size: (u32, u32), color: ColorType, becomes: Becomes) -> Need {
        let rows = 4 * u64::from(size.0) * u64::from(color.bytes_per_pixel());
        let decoded = pixels(size) * u64::from(color.bytes_per_pixel());
        Need::of(decoded + rows + PNG_METADATA, pixels(size), color, becomes)
    }

    /// Of a TIFF of this many bytes, which is decoded into a buffer and copied.
    pub(super) fn of_tiff(size: (u32, u32), color: ColorType, length: u64, becomes: Becomes) -> Need {
        let decoded = pixels(size) * u64::from(color.bytes_per_pixel());
        // A strip or tile of a compressed one may be all of the image, and be held once more.
        let strip = if length < decoded { decoded } else { 0 };
        // CMYK has a fourth channel in the buffer that RGB has not.
        let buffer = if color.has_color() { decoded / 3 * 4 } else { decoded };
        Need::of(buffer + decoded + strip + tiff_values(length, decoded), pixels(size), color, becomes)
    }

    /// Of a Radiance HDR, whose rows are decoded in place.
    pub(super) fn of_hdr(size: (u32, u32), becomes: Becomes) -> Need {
        Need::of(12 * pixels(size) + 16 * u64::from(size.0), pixels(size), ColorType::Rgb32F, becomes)
    }

    /// Of an image that takes this much to decode and has these samples then.
    fn of(decoding: u64, pixels: u64, color: ColorType, becomes: Becomes) -> Need {
        let decoded = pixels * u64::from(color.bytes_per_pixel());
        let (kept, held) = match (becomes, color) {
            (Becomes::Grey, ColorType::L8) => (true, decoded),
            (Becomes::Grey, _) => (false, pixels),
            (_, ColorType::Rgb8 | ColorType::Rgb16 | ColorType::Rgb32F) => (true, decoded),
            (becomes, color) => {
                let mask = u64::from(becomes == Becomes::Masked && color.has_alpha());
                (false, pixels * (3 * u64::from(color.bytes_per_pixel() / color.channel_count()) + mask))
            }
        };
        let converting = if kept { decoded } else { decoded + held };
        Need { peak: decoding.max(converting) + SLACK, held }
    }
}

/// What the samples become.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Becomes {
    /// Red, green and blue, as wide as they are.
    Rgb,
    /// The same, and a mask of a byte if there is alpha.
    Masked,
    /// One byte.
    Grey,
}

fn pixels(size: (u32, u32)) -> u64 {
    u64::from(size.0) * u64::from(size.1)
}

/// Bytes of buffers that do not grow with the image.
const SLACK: u64 = 256 << 10;

/// The most bytes that a PNG may hold of colour profiles, text and the like.
pub(super) const PNG_METADATA: u64 = 4 << 20;

/// The most bytes that a TIFF of this many bytes, decoded and not, may hold of values in its directory, and of a strip
/// before it is decompressed.
pub(super) fn tiff_values(length: u64, decoded: u64) -> u64 {
    if length < decoded { length.min(64 << 20) + (1 << 20) } else { 4 << 20 }
}
