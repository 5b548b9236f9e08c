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

/// What reading a photograph of `size` pixels will take.
///
/// # Errors
/// No such file, an unknown format, a damaged header, another size.
pub fn need(path: &Path, size: Size) -> Result<Need> {
    Ok(Opened::new(path, size, Becomes::Rgb)?.need)
}

/// Reads a photograph of `size` pixels, unmasked, within `memory` bytes.
///
/// # Errors
/// No such file, an unknown format, a damaged file, another size, one that takes more memory.
pub fn read_image(path: &Path, size: Size, curve: &Curve, memory: u64) -> Result<LinearImage> {
    let decoded = Opened::new(path, size, Becomes::Rgb)?.decode(memory)?;
    let (samples, table): (_, Arc<[f32]>) = match decoded.color() {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            (Samples::U8(decoded.into_rgb8().into_raw()), curve.eight.clone())
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            (Samples::U16(decoded.into_rgb16().into_raw()), curve.sixteen.clone())
        }
        _ => (Samples::F32(decoded.into_rgb32f().into_raw()), Arc::from([])),
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

/// What reading the mask of an image will take; nothing if there is none.
///
/// # Errors
/// A damaged header, another size.
pub fn mask_need(masks: &Path, name: &str, size: Size) -> Result<Need> {
    mask_path(masks, name).map_or(Ok(Need::default()), |path| Ok(Opened::new(&path, size, Becomes::Grey)?.need))
}

/// Reads the mask of an image of `size` pixels within `memory` bytes: 0 where a pixel is to be ignored, anything else
/// where it counts.
///
/// # Errors
/// A damaged file, another size, one that takes more memory.
pub fn read_mask(masks: &Path, name: &str, size: Size, memory: u64) -> Result<Option<Vec<u8>>> {
    let Some(path) = mask_path(masks, name) else { return Ok(None) };
    Ok(Some(Opened::new(&path, size, Becomes::Grey)?.decode(memory)?.into_luma8().into_raw()))
}

/// An image file whose header has been read.
struct Opened<'a> {
    path: &'a Path,
    size: Size,
    length: u64,
    content: Content,
    need: Need,
}

enum Content {
    Jpeg(BufReader<File>, jpeg::Header),
    Exr(BufReader<File>, exr::Header),
    Other(Box<dyn ImageDecoder>, ImageFormat),
}

impl<'a> Opened<'a> {
    fn new(path: &'a Path, size: Size, becomes: Becomes) -> Result<Self> {
        let file = File::open(path).map_err(Error::io("open", path))?;
        let length = file.metadata().map_err(Error::io("open", path))?.len();
        let mut file = BufReader::new(file);
        let start = file.fill_buf().map_err(Error::io("read", path))?;
        let format = image::guess_format(start)
            .map_err(|_| Error::malformed(path, "no image that gonio reads: JPEG, PNG, TIFF, EXR or HDR"))?;
        let (content, found, need) = match format {
            ImageFormat::Jpeg => {
                let header = jpeg::Header::read(&mut file).map_err(|why| match why.kind() {
                    ErrorKind::UnexpectedEof => Error::malformed(path, "the JPEG is cut short within its header"),
                    ErrorKind::InvalidData => Error::malformed(path, why.to_string()),
                    _ => Error::io("read", path)(why),
                })?;
                (Content::Jpeg(file, header), header.size, Need::of_jpeg(&header, length, becomes))
            }
            ImageFormat::OpenExr => {
                let header = exr::Header::read(&mut file).map_err(|why| Error::malformed(path, why))?;
                (Content::Exr(file, header), header.size, Need::of_exr(&header, becomes))
            }
            format => {
                let mut reader = ImageReader::with_format(file, format);
                reader.limits(limits(size, PNG_METADATA));
                let decoder = reader.into_decoder().map_err(|why| refused(path, size, why))?;
                let (found, color) = (decoder.dimensions(), decoder.color_type());
                let need = match format {
                    ImageFormat::Png => Need::of_png(found, color, becomes),
                    ImageFormat::Hdr => Need::of_hdr(found, becomes),
                    _ => Need::of_tiff(found, color, length, becomes),
                };
                (Content::Other(Box::new(decoder), format), found, need)
            }
        };
        if found != size {
            return Err(Error::malformed(
                path,
                format!("{} x {} pixels, where {} x {} are expected", found.0, found.1, size.0, size.1),
            ));
        }
        Ok(Opened { path, size, length, content, need })
    }

    fn decode(self, memory: u64) -> Result<DynamicImage> {
        let Opened { path, size, length, content, need } = self;
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
                let samples = exr::decode(file, &header).map_err(|why| Error::malformed(path, why))?;
                let picture = image::Rgb32FImage::from_raw(size.0, size.1, samples).map(DynamicImage::from);
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

fn refused(path: &Path, size: Size, why: ImageError) -> Error {
    match why {
        ImageError::IoError(why) if why.kind() != ErrorKind::UnexpectedEof => Error::io("read", path)(why),
        ImageError::Limits(limit) if matches!(limit.kind(), LimitErrorKind::DimensionError) => Error::malformed(
            path,
            format!("it is larger than {} x {} pixels, the size that is expected", size.0, size.1),
        ),
        why => Error::malformed(path, why.to_string()),
    }
}
