//! Reads photographs and masks.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::error::{ImageError, LimitErrorKind};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::{Curve, jpeg};
use crate::base::{Error, Result};
use crate::scene::frame::{LinearImage, Samples};

/// The size of an image, (columns, rows).
type Size = (u32, u32);

/// Bytes that decoders may take beside the decoded image.
const WORKSPACE: u64 = 64 << 20;

/// Reads a photograph of `size` pixels, unmasked.
///
/// # Errors
/// No such file, an unknown format, a damaged file, another size.
pub fn read_image(path: &Path, size: Size, curve: &Curve) -> Result<LinearImage> {
    let decoded = decode(path, size)?;
    let no_table = || std::sync::Arc::from([]);
    let (samples, table) = match decoded.color() {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            (Samples::U8(decoded.into_rgb8().into_raw()), curve.eight.clone())
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            (Samples::U16(decoded.into_rgb16().into_raw()), curve.sixteen.clone())
        }
        _ => (Samples::F32(decoded.into_rgb32f().into_raw()), no_table()),
    };
    Ok(LinearImage { width: size.0, height: size.1, samples, table, mask: None })
}

/// The mask of an image in a folder of masks: `NAME.png`, as COLMAP has it, or with `.png` in place of the image's own
/// ending; `None` if there is neither, and then every pixel counts.
pub fn mask_path(masks: &Path, name: &str) -> Option<PathBuf> {
    let appended = masks.join(format!("{name}.png"));
    let replaced = masks.join(name).with_extension("png");
    [appended, replaced].into_iter().find(|path| path.is_file())
}

/// Reads the mask of an image of `size` pixels: 0 where a pixel is to be ignored, anything else where it counts.
///
/// # Errors
/// A damaged file, another size.
pub fn read_mask(masks: &Path, name: &str, size: Size) -> Result<Option<Vec<u8>>> {
    let Some(path) = mask_path(masks, name) else { return Ok(None) };
    Ok(Some(decode(&path, size)?.into_luma8().into_raw()))
}

fn decode(path: &Path, size: Size) -> Result<DynamicImage> {
    let malformed = |why: ImageError| match why {
        ImageError::IoError(why) if why.kind() != std::io::ErrorKind::UnexpectedEof => Error::io("read", path)(why),
        ImageError::Limits(limit) if matches!(limit.kind(), LimitErrorKind::DimensionError) => Error::malformed(
            path,
            format!("it is larger than {} x {} pixels, the size that is expected", size.0, size.1),
        ),
        why => Error::malformed(path, why.to_string()),
    };
    // The widest sample is an f32, the most channels are four.
    let most = 2 * u64::from(size.0) * u64::from(size.1) * 16 + WORKSPACE;
    let length = fs::metadata(path).map_err(Error::io("open", path))?.len();
    if length > most {
        return Err(Error::malformed(path, format!("{length} bytes are too many for {} x {} pixels", size.0, size.1)));
    }
    let bytes = fs::read(path).map_err(Error::io("read", path))?;
    let mut reader = ImageReader::new(Cursor::new(&bytes)).with_guessed_format().map_err(Error::io("read", path))?;
    match reader.format() {
        None => return Err(Error::malformed(path, "no image that gonio reads: JPEG, PNG, TIFF, EXR or HDR")),
        Some(ImageFormat::Jpeg) if !jpeg::is_whole(&bytes) => {
            return Err(Error::malformed(path, "the JPEG is cut short: its end is missing"));
        }
        Some(_) => {}
    }
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(size.0), Some(size.1));
    limits.max_alloc = Some(most);
    reader.limits(limits.clone());
    let mut decoder = reader.into_decoder().map_err(malformed)?;
    decoder.set_limits(limits).map_err(malformed)?;
    let found = decoder.dimensions();
    if found != size {
        return Err(Error::malformed(
            path,
            format!("{} x {} pixels, where {} x {} are expected", found.0, found.1, size.0, size.1),
        ));
    }
    DynamicImage::from_decoder(decoder).map_err(malformed)
}
