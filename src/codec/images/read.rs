//! Reads photographs and masks. The need of a file follows from its header, by the same rules before it is read and while
//! it is read: a file that needs more memory than it was given is refused before a sample is decoded. A file is read once,
//! as a whole ([`Encoded`]), and decoded from these bytes, whose key is that of the result.

use std::io::{self, BufRead, BufReader, Cursor, ErrorKind, Read, Seek};
use std::path::Path;
use std::sync::Arc;

use image::error::{ImageError, LimitErrorKind};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use super::need::{Becomes, Need, tiff_values};
use super::size::Size;
use super::transfer::Curve;
use super::{exr, hdr, jpeg, mask, other, png, tiff};
use crate::base::guard::guarded;
use crate::base::input::Input;
use crate::base::key::Key;
use crate::base::shown::{brief, short};
use crate::base::units::Bytes;
use crate::base::{Error, Result};
use crate::scene::frame::{LinearImage, Samples};

/// The bytes that a decoder may hold before it knows the size of a picture.
const HEADER: u64 = 4 << 20;

/// The bytes of a file's start that formats are recognised by.
const START: u64 = 64;

/// The memory that reading a photograph of this size takes.
///
/// # Errors
/// No such file, an unknown format, a damaged header, another size.
pub fn need(path: &Path, size: Size) -> Result<Need> {
    Ok(Opened::at(path, Some(size), Becomes::Color)?.need)
}

/// Whether a file has the ending of a format that is read: .jpg, .jpeg, .png, .tif, .tiff, .exr or .hdr.
pub(crate) fn is_picture(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    ["jpg", "jpeg", "png", "tif", "tiff", "exr", "hdr"].iter().any(|known| ending == *known)
}

/// The size of a picture by its header, at most 65,535 pixels a side.
///
/// # Errors
/// No such file, an unknown format, a damaged header, a larger one.
pub fn size(path: &Path) -> Result<Size> {
    Ok(Opened::at(path, None, Becomes::Color)?.size)
}

/// Reads a picture of this size within `memory` bytes. Pixels are masked where alpha is 0, and in an EXR where the file has no
/// pixels.
///
/// # Errors
/// No such file, an unknown format, a damaged file, another size, a file that takes more memory.
pub fn read_image(path: &Path, size: Size, curve: &Curve, memory: u64) -> Result<LinearImage> {
    Encoded::read(path, memory)?.image(size, curve, memory)
}

fn linear(decoded: DynamicImage, size: Size, curve: &Curve) -> LinearImage {
    let mask = mask::of_alpha(&decoded);
    let (samples, table): (_, Arc<[f32]>) = match decoded.color() {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => {
            (Samples::U8(decoded.into_rgb8().into_raw()), curve.eight.clone())
        }
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            (Samples::U16(decoded.into_rgb16().into_raw()), curve.sixteen.clone())
        }
        _ => (Samples::F32(decoded.into_rgb32f().into_raw()), Arc::from([])),
    };
    LinearImage { width: size.width, height: size.height, samples, table, mask }
}

/// The memory that reading a mask of this size takes.
///
/// # Errors
/// A damaged header, another size.
pub(crate) fn mask_need(path: &Path, size: Size) -> Result<Need> {
    Ok(Opened::at(path, Some(size), Becomes::Mask)?.need)
}

/// The bytes of an image file.
pub struct Encoded<'a> {
    path: &'a Path,
    bytes: Vec<u8>,
    /// The key of the bytes.
    pub key: Key,
}

impl<'a> Encoded<'a> {
    /// Reads a file of at most `memory` bytes.
    ///
    /// # Errors
    /// No such file, one that is changed while it is read, a longer one.
    pub fn read(path: &'a Path, memory: u64) -> Result<Self> {
        let file = Input::open(path).map_err(Error::io("open", path))?;
        if file.length() > memory {
            return Err(too_little(path, file.length(), memory));
        }
        let bytes = file.read_all().map_err(Error::io("read", path))?;
        Ok(Encoded { path, key: Key::of_bytes(&bytes), bytes })
    }

    /// Decodes a picture of this size, masked where alpha is 0 and where there are no pixels, within `memory` bytes, the
    /// file's own among them.
    ///
    /// # Errors
    /// An unknown format, a damaged file, another size, a file that takes more memory.
    pub fn image(&self, size: Size, curve: &Curve, memory: u64) -> Result<LinearImage> {
        Ok(linear(self.decode(size, Becomes::Color, memory)?, size, curve))
    }

    /// Decodes a mask of this size: 0 where a pixel is ignored, since all its colours are 0 or its alpha is, anything else where
    /// it counts.
    ///
    /// # Errors
    /// Those of [`Encoded::image`].
    pub fn mask(&self, size: Size, memory: u64) -> Result<Vec<u8>> {
        Ok(mask::of_picture(self.decode(size, Becomes::Mask, memory)?))
    }

    fn decode(&self, size: Size, becomes: Becomes, memory: u64) -> Result<DynamicImage> {
        let Encoded { path, bytes, .. } = self;
        let file = Cursor::new(&bytes[..]);
        Opened::new(file, bytes.len() as u64, path, Some(size), becomes)?.decode(bytes, memory)
    }
}

/// An image whose header is read.
struct Opened<'a, R: BufRead + Seek> {
    path: &'a Path,
    size: Size,
    length: u64,
    content: Content<'a, R>,
    need: Need,
}

enum Content<'a, R: BufRead + Seek> {
    Jpeg(R, jpeg::Header),
    Exr(R, exr::Header),
    Png(Box<png::Header<R>>),
    Other { decoder: Box<dyn ImageDecoder + 'a>, format: ImageFormat },
}

impl<'a> Opened<'a, BufReader<Input>> {
    /// Reads the header of a file.
    fn at(path: &'a Path, expected: Option<Size>, becomes: Becomes) -> Result<Self> {
        let file = Input::open(path).map_err(Error::io("open", path))?;
        let length = file.length();
        Opened::new(BufReader::new(file), length, path, expected, becomes)
    }
}

impl<'a, R: BufRead + Seek + 'a> Opened<'a, R> {
    fn new(file: R, length: u64, path: &'a Path, expected: Option<Size>, becomes: Becomes) -> Result<Self> {
        guarded(|| Opened::header(file, length, path, expected, becomes)).unwrap_or_else(|why| Err(gave_up(path, &why)))
    }

    fn header(mut file: R, length: u64, path: &'a Path, expected: Option<Size>, becomes: Becomes) -> Result<Self> {
        let mut start = Vec::new();
        let read = file.by_ref().take(START).read_to_end(&mut start).and_then(|_| file.rewind());
        read.map_err(Error::io("read", path))?;
        let format = if tiff::is_big(&start) { Ok(ImageFormat::Tiff) } else { image::guess_format(&start) };
        let format = format.map_err(|_| Error::malformed(path, other::told(&start)))?;
        let (content, size) = match format {
            ImageFormat::Jpeg => {
                let header = jpeg::Header::read(&mut file).map_err(|why| unheaded(path, "JPEG", why))?;
                (Content::Jpeg(file, header), header.size)
            }
            ImageFormat::Png => {
                let header = png::Header::read(file).map_err(|why| unheaded(path, "PNG", why))?;
                let size = header.size;
                (Content::Png(Box::new(header)), size)
            }
            ImageFormat::OpenExr => {
                let header = exr::Header::read(&mut file).map_err(|why| unheaded(path, "EXR", why))?;
                let size = header.size;
                (Content::Exr(file, header), size)
            }
            format => {
                match format {
                    ImageFormat::Tiff => tiff::check(&mut file).map_err(|why| unheaded(path, "TIFF", why))?,
                    ImageFormat::Hdr => hdr::check(&mut file).map_err(|why| unheaded(path, "HDR", why))?,
                    _ => return Err(Error::malformed(path, other::told(&start))),
                }
                let mut reader = ImageReader::with_format(file, format);
                // No pixel is decoded yet.
                reader.limits(limits(Size::MOST, HEADER));
                let decoder = reader.into_decoder().map_err(|why| refused(path, Size::MOST, why))?;
                let (width, height) = decoder.dimensions();
                let size = Size { width, height };
                (Content::Other { decoder: Box::new(decoder), format }, size)
            }
        };
        if let Some(expected) = expected.filter(|&expected| expected != size) {
            let compared = || match becomes {
                Becomes::Color => size.compared(expected),
                Becomes::Mask => Some("a mask must have the size of its photograph".to_owned()),
            };
            let hint = compared().map(|hint| format!(": {hint}")).unwrap_or_default();
            return Err(Error::malformed(path, format!("{size} pixels, where {expected} are expected{hint}")));
        }
        if let Some(why) = size.too_large() {
            return Err(Error::malformed(path, why));
        }
        // The size must be checked first: the bytes of an unchecked one could overflow.
        let need = match &content {
            Content::Jpeg(_, header) => Need::of_jpeg(header, becomes),
            Content::Exr(_, header) => Need::of_exr(header, becomes),
            Content::Png(header) => Need::of_png(size, header.color, header.metadata, becomes),
            Content::Other { format: ImageFormat::Hdr, .. } => Need::of_hdr(size, becomes),
            Content::Other { decoder, .. } => Need::of_tiff(size, decoder.color_type(), length, becomes),
        };
        // The file's own bytes are held to the end.
        Ok(Opened { path, size, length, content, need: Need { peak: length + need.peak, ..need } })
    }
}

impl Opened<'_, Cursor<&[u8]>> {
    fn decode(self, bytes: &[u8], memory: u64) -> Result<DynamicImage> {
        let path = self.path;
        guarded(|| self.samples(bytes, memory)).unwrap_or_else(|why| Err(gave_up(path, &why)))
    }

    fn samples(self, bytes: &[u8], memory: u64) -> Result<DynamicImage> {
        let Opened { path, size, length, content, need } = self;
        if need.peak > memory {
            return Err(too_little(path, need.peak, memory));
        }
        match content {
            Content::Jpeg(_, header) => jpeg::decode(bytes, &header).map_err(|why| Error::malformed(path, brief(&why))),
            Content::Png(header) => header.decode().map_err(|why| torn(path, why)),
            Content::Exr(mut file, header) => {
                file.set_position(0);
                let picture = if header.masked {
                    let samples = exr::decode::<4>(file, &header).map_err(|why| Error::malformed(path, brief(&why)))?;
                    image::Rgba32FImage::from_raw(size.width, size.height, samples).map(DynamicImage::from)
                } else {
                    let samples = exr::decode::<3>(file, &header).map_err(|why| Error::malformed(path, brief(&why)))?;
                    image::Rgb32FImage::from_raw(size.width, size.height, samples).map(DynamicImage::from)
                };
                picture.ok_or_else(|| Error::malformed(path, "some of its pixels are missing"))
            }
            Content::Other { mut decoder, format, .. } => {
                if format == ImageFormat::Tiff {
                    tiff::check_parts(bytes).map_err(|why| Error::malformed(path, why))?;
                    // The decoder subtracts the pixels from the limit; the values of the directory may have the rest.
                    let decoded = decoder.total_bytes();
                    let most = decoded / 3 * 4 + tiff_values(length, decoded);
                    decoder.set_limits(limits(size, most)).map_err(|why| refused(path, size, why))?;
                }
                DynamicImage::from_decoder(decoder).map_err(|why| refused(path, size, why))
            }
        }
    }
}

/// The error for a file that takes more memory than was set aside by its header.
fn too_little(path: &Path, needs: u64, has: u64) -> Error {
    let [needs, has] = [needs, has].map(Bytes);
    Error::invalid(format!("{}: reading it takes {needs} of memory, and it was given {has}", path.display()))
}

fn limits(size: Size, bytes: u64) -> Limits {
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(size.width), Some(size.height));
    limits.max_alloc = Some(bytes);
    limits
}

/// The error of a decoder that panicked: the file is skipped like any other that cannot be read.
fn gave_up(path: &Path, words: &str) -> Error {
    Error::malformed(path, format!("the decoder gave up: {}", short(words)))
}

/// The error of a header that was looked at before the decoder sees it.
fn unheaded(path: &Path, format: &str, why: io::Error) -> Error {
    match why.kind() {
        ErrorKind::UnexpectedEof => Error::malformed(path, format!("the {format} is cut short within its header")),
        _ => torn(path, why),
    }
}

/// The error where a header or samples end early: the system's, if it is one, or else a fault of the file.
fn torn(path: &Path, why: io::Error) -> Error {
    if why.raw_os_error().is_some() {
        return Error::io("read", path)(why);
    }
    let cut = why.kind() == ErrorKind::UnexpectedEof;
    Error::malformed(path, if cut { "it is cut short".to_owned() } else { brief(&why) })
}

fn refused(path: &Path, most: Size, why: ImageError) -> Error {
    match why {
        ImageError::IoError(why) => torn(path, why),
        ImageError::Limits(limit) if matches!(limit.kind(), LimitErrorKind::DimensionError) => {
            Error::malformed(path, format!("it is larger than {most} pixels, the most that is expected"))
        }
        why => Error::malformed(path, brief(&why)),
    }
}
