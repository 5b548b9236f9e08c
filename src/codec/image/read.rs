//! Reads photographs and masks. What a file takes is worked out from its header, the same way before it is read and
//! while it is read: a file that asks for more than it was given is refused before a sample is decoded.

use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use image::error::{ImageError, LimitErrorKind};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::need::{Becomes, Need, PNG_METADATA, tiff_values};
use super::{Curve, exr, jpeg};
use crate::base::units::Bytes;
use crate::base::{Error, Result};
use crate::scene::frame::{LinearImage, Samples};

/// The size of an image, (columns, rows).
type Size = (u32, u32);

/// The longest side of a picture whose size nobody foretold; a JPEG has none longer.
const MOST: u32 = 65_535;

/// What reading a photograph of `size` pixels will take.
///
/// # Errors
/// No such file, an unknown format, a damaged header, another size.
pub fn need(path: &Path, size: Size) -> Result<Need> {
    Ok(Opened::new(path, Some(size), Becomes::Rgb)?.need)
}

/// Whether a file is named as pictures of the formats that are read are: .jpg, .jpeg, .png, .tif, .tiff, .exr or .hdr.
pub fn is_picture(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    ["jpg", "jpeg", "png", "tif", "tiff", "exr", "hdr"].iter().any(|known| ending == *known)
}

/// Columns and rows of a picture, at most 65,535 each, as its header says.
///
/// # Errors
/// No such file, an unknown format, a damaged header, a larger one.
pub fn size(path: &Path) -> Result<Size> {
    Ok(Opened::new(path, None, Becomes::Rgb)?.size)
}

/// Reads a photograph of `size` pixels, unmasked, within `memory` bytes.
///
/// # Errors
/// No such file, an unknown format, a damaged file, another size, one that takes more memory.
pub fn read_image(path: &Path, size: Size, curve: &Curve, memory: u64) -> Result<LinearImage> {
    Ok(linear(Opened::new(path, Some(size), Becomes::Rgb)?.decode(memory)?, size, curve))
}

/// Reads a picture of `size` pixels within `memory` bytes, masked where its alpha is 0 or, in an EXR with alpha, where
/// there are no pixels.
///
/// # Errors
/// Those of [`read_image`].
pub fn read_picture(path: &Path, size: Size, curve: &Curve, memory: u64) -> Result<LinearImage> {
    let decoded = Opened::new(path, Some(size), Becomes::Masked)?.decode(memory)?;
    let mask = match &decoded {
        DynamicImage::ImageLumaA8(picture) => Some(opaque::<_, 2>(picture)),
        DynamicImage::ImageLumaA16(picture) => Some(opaque::<_, 2>(picture)),
        DynamicImage::ImageRgba8(picture) => Some(opaque::<_, 4>(picture)),
        DynamicImage::ImageRgba16(picture) => Some(opaque::<_, 4>(picture)),
        DynamicImage::ImageRgba32F(picture) => Some(opaque::<_, 4>(picture)),
        _ => None,
    };
    Ok(LinearImage { mask, ..linear(decoded, size, curve) })
}

/// A mask of pixels of so many channels, the last of them alpha.
fn opaque<T: Default + PartialEq, const CHANNELS: usize>(samples: &[T]) -> Vec<u8> {
    samples.as_chunks::<CHANNELS>().0.iter().map(|pixel| u8::from(pixel[CHANNELS - 1] != T::default())).collect()
}

fn linear(decoded: DynamicImage, size: Size, curve: &Curve) -> LinearImage {
    let (samples, table): (_, Arc<[f32]>) = match decoded.color() {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            (Samples::U8(decoded.into_rgb8().into_raw()), curve.eight.clone())
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            (Samples::U16(decoded.into_rgb16().into_raw()), curve.sixteen.clone())
        }
        _ => (Samples::F32(decoded.into_rgb32f().into_raw()), Arc::from([])),
    };
    LinearImage { width: size.0, height: size.1, samples, table, mask: None }
}

/// The mask of an image in a folder of masks: `NAME.png`, as COLMAP has it, or with `.png` in place of the image's own
/// ending; `None` if there is neither, and then every pixel counts.
pub fn mask_path(masks: &Path, name: &str) -> Option<PathBuf> {
    let appended = masks.join(format!("{name}.png"));
    let replaced = masks.join(name).with_extension("png");
    [appended, replaced].into_iter().find(|path| path.is_file())
}

/// What reading the mask of an image will take; nothing if there is none.
///
/// # Errors
/// A damaged header, another size.
pub fn mask_need(masks: &Path, name: &str, size: Size) -> Result<Need> {
    mask_path(masks, name).map_or(Ok(Need::default()), |path| Ok(Opened::new(&path, Some(size), Becomes::Grey)?.need))
}

/// Reads the mask of an image of `size` pixels within `memory` bytes: 0 where a pixel is to be ignored, anything else
/// where it counts.
///
/// # Errors
/// A damaged file, another size, one that takes more memory.
pub fn read_mask(masks: &Path, name: &str, size: Size, memory: u64) -> Result<Option<Vec<u8>>> {
    let Some(path) = mask_path(masks, name) else { return Ok(None) };
    Ok(Some(Opened::new(&path, Some(size), Becomes::Grey)?.decode(memory)?.into_luma8().into_raw()))
}

/// An image file whose header has been read.
struct Opened<'a> {
    path: &'a Path,
    size: Size,
    length: u64,
    content: Content,
    becomes: Becomes,
    need: Need,
}

enum Content {
    Jpeg(BufReader<File>, jpeg::Header),
    Exr(BufReader<File>, exr::Header),
    Other(Box<dyn ImageDecoder>, ImageFormat),
}

impl<'a> Opened<'a> {
    fn new(path: &'a Path, expected: Option<Size>, becomes: Becomes) -> Result<Self> {
        let most = expected.unwrap_or((MOST, MOST));
        let file = File::open(path).map_err(Error::io("open", path))?;
        let length = file.metadata().map_err(Error::io("open", path))?.len();
        let mut file = BufReader::new(file);
        let start = file.fill_buf().map_err(Error::io("read", path))?;
        let format = image::guess_format(start)
            .map_err(|_| Error::malformed(path, "no image that gonio reads: JPEG, PNG, TIFF, EXR or HDR"))?;
        let (content, size) = match format {
            ImageFormat::Jpeg => {
                let header = jpeg::Header::read(&mut file).map_err(|why| match why.kind() {
                    ErrorKind::UnexpectedEof => Error::malformed(path, "the JPEG is cut short within its header"),
                    ErrorKind::InvalidData => Error::malformed(path, why.to_string()),
                    _ => Error::io("read", path)(why),
                })?;
                (Content::Jpeg(file, header), header.size)
            }
            ImageFormat::OpenExr => {
                let header = exr::Header::read(&mut file).map_err(|why| Error::malformed(path, why))?;
                (Content::Exr(file, header), header.size)
            }
            format => {
                let mut reader = ImageReader::with_format(file, format);
                reader.limits(limits(most, PNG_METADATA));
                let decoder = reader.into_decoder().map_err(|why| refused(path, most, why))?;
                let size = decoder.dimensions();
                (Content::Other(Box::new(decoder), format), size)
            }
        };
        if expected.is_some_and(|expected| size != expected) {
            return Err(Error::malformed(
                path,
                format!("{} x {} pixels, where {} x {} are expected", size.0, size.1, most.0, most.1),
            ));
        }
        if size.0 > most.0 || size.1 > most.1 {
            return Err(too_large(path, most));
        }
        // Not before the size is known to be one whose bytes can be counted.
        let need = match &content {
            Content::Jpeg(_, header) => Need::of_jpeg(header, length, becomes),
            Content::Exr(_, header) => Need::of_exr(header, becomes),
            Content::Other(decoder, ImageFormat::Png) => Need::of_png(size, decoder.color_type(), becomes),
            Content::Other(_, ImageFormat::Hdr) => Need::of_hdr(size, becomes),
            Content::Other(decoder, _) => Need::of_tiff(size, decoder.color_type(), length, becomes),
        };
        Ok(Opened { path, size, length, content, becomes, need })
    }

    fn decode(self, memory: u64) -> Result<DynamicImage> {
        let Opened { path, size, length, content, becomes, need } = self;
        if need.peak > memory {
            let [needs, has] = [need.peak, memory].map(Bytes);
            return Err(Error::malformed(path, format!("reading it takes {needs} of memory, and it was given {has}")));
        }
        match content {
            Content::Jpeg(file, header) => {
                let bytes = read_all(path, file, length)?;
                if !jpeg::is_whole(&bytes) {
                    return Err(Error::malformed(path, "the JPEG is cut short: its end is missing"));
                }
                jpeg::decode(&bytes, &header).map_err(|why| Error::malformed(path, why))
            }
            Content::Exr(mut file, header) => {
                file.rewind().map_err(Error::io("read", path))?;
                let picture = if becomes == Becomes::Masked && header.alpha {
                    let samples = exr::decode::<4>(file, &header).map_err(|why| Error::malformed(path, why))?;
                    image::Rgba32FImage::from_raw(size.0, size.1, samples).map(DynamicImage::from)
                } else {
                    let samples = exr::decode::<3>(file, &header).map_err(|why| Error::malformed(path, why))?;
                    image::Rgb32FImage::from_raw(size.0, size.1, samples).map(DynamicImage::from)
                };
                picture.ok_or_else(|| Error::malformed(path, "it has not all of its pixels"))
            }
            Content::Other(mut decoder, format) => {
                if format == ImageFormat::Tiff {
                    // Of what is allowed, the decoder takes off what the pixels are, and lets its values have the rest.
                    let decoded = decoder.total_bytes();
                    let most = decoded / 3 * 4 + tiff_values(length, decoded);
                    decoder.set_limits(limits(size, most)).map_err(|why| refused(path, size, why))?;
                }
                DynamicImage::from_decoder(decoder).map_err(|why| refused(path, size, why))
            }
        }
    }
}

/// All bytes of a file of which the header has been read, and which must still have this length.
fn read_all(path: &Path, mut file: BufReader<File>, length: u64) -> Result<Vec<u8>> {
    file.rewind().map_err(Error::io("read", path))?;
    // Room for one more, so that the end is found without the vector growing.
    let mut bytes = Vec::with_capacity(length as usize + 1);
    file.take(length + 1).read_to_end(&mut bytes).map_err(Error::io("read", path))?;
    if bytes.len() as u64 != length {
        return Err(Error::malformed(path, "its length has changed while it was read"));
    }
    Ok(bytes)
}

fn limits(size: Size, bytes: u64) -> Limits {
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(size.0), Some(size.1));
    limits.max_alloc = Some(bytes);
    limits
}

fn too_large(path: &Path, most: Size) -> Error {
    Error::malformed(path, format!("it is larger than {} x {} pixels, the most that is expected", most.0, most.1))
}

fn refused(path: &Path, most: Size, why: ImageError) -> Error {
    match why {
        ImageError::IoError(why) if why.kind() != ErrorKind::UnexpectedEof => Error::io("read", path)(why),
        ImageError::Limits(limit) if matches!(limit.kind(), LimitErrorKind::DimensionError) => too_large(path, most),
        why => Error::malformed(path, why.to_string()),
    }
}
