//! Which pixels count: the mask files of frames, and alpha.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use image::DynamicImage;

use crate::base::{Error, Result};

/// What programs put between an image's name and the ending of its mask: COLMAP and others nothing, Metashape `_mask`,
/// RealityScan and OpenMVS `.mask`.
const MARKS: [&str; 3] = ["", "_mask", ".mask"];

const ENDINGS: [&str; 6] = ["png", "PNG", "jpg", "JPG", "tif", "tiff"];

/// The mask of an image in a folder of masks: the image's name, with or without its ending, then a mark of [`MARKS`] and one of
/// [`ENDINGS`]; `None` if there is no such file: every pixel counts. The photograph itself is no mask.
///
/// # Errors
/// The system does not say whether there is one.
pub(crate) fn mask_path(masks: &Path, images: &Path, name: &str) -> Result<Option<PathBuf>> {
    let (photograph, stem) = (images.join(name), Path::new(name).with_extension(""));
    let stems = [name, &stem.to_string_lossy()].map(ToOwned::to_owned);
    let marked = MARKS.iter().flat_map(|mark| stems.iter().map(move |stem| format!("{stem}{mark}")));
    for path in marked.flat_map(|name| ENDINGS.iter().map(move |ending| masks.join(format!("{name}.{ending}")))) {
        match fs::metadata(&path) {
            Ok(found) if found.is_dir() || path == photograph => {}
            Ok(_) => return Ok(Some(path)),
            Err(why) if matches!(why.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {}
            Err(why) => return Err(Error::io("look at", path)(why)),
        }
    }
    Ok(None)
}

/// The mask that a picture's alpha is; `None` without alpha.
pub(super) fn of_alpha(picture: &DynamicImage) -> Option<Vec<u8>> {
    match picture {
        DynamicImage::ImageLumaA8(picture) => Some(opaque::<_, 2>(picture)),
        DynamicImage::ImageLumaA16(picture) => Some(opaque::<_, 2>(picture)),
        DynamicImage::ImageRgba8(picture) => Some(opaque::<_, 4>(picture)),
        DynamicImage::ImageRgba16(picture) => Some(opaque::<_, 4>(picture)),
        DynamicImage::ImageRgba32F(picture) => Some(opaque::<_, 4>(picture)),
        _ => None,
    }
}

fn opaque<T: Default + PartialEq, const CHANNELS: usize>(samples: &[T]) -> Vec<u8> {
    samples.as_chunks::<CHANNELS>().0.iter().map(|pixel| u8::from(pixel[CHANNELS - 1] != T::default())).collect()
}

/// A mask file as a mask: 0 where all colours are 0 or alpha is.
pub(super) fn of_picture(picture: DynamicImage) -> Vec<u8> {
    match picture {
        DynamicImage::ImageLuma8(picture) => picture.into_raw(),
        DynamicImage::ImageLumaA8(picture) => seen::<_, 2>(&picture),
        DynamicImage::ImageRgb8(picture) => seen::<_, 3>(&picture),
        DynamicImage::ImageRgba8(picture) => seen::<_, 4>(&picture),
        DynamicImage::ImageLuma16(picture) => seen::<_, 1>(&picture),
        DynamicImage::ImageLumaA16(picture) => seen::<_, 2>(&picture),
        DynamicImage::ImageRgb16(picture) => seen::<_, 3>(&picture),
        DynamicImage::ImageRgba16(picture) => seen::<_, 4>(&picture),
        DynamicImage::ImageRgb32F(picture) => seen::<_, 3>(&picture),
        other => seen::<_, 4>(&other.into_rgba32f()),
    }
}

/// Where a colour is not 0, nor alpha, which is the last of two or four channels.
fn seen<T: Default + PartialEq, const CHANNELS: usize>(samples: &[T]) -> Vec<u8> {
    let (none, alpha) = (T::default(), CHANNELS.is_multiple_of(2));
    let colors = CHANNELS - usize::from(alpha);
    let counts = |pixel: &[T; CHANNELS]| {
        pixel[..colors].iter().any(|value| *value != none) && !(alpha && pixel[CHANNELS - 1] == none)
    };
    samples.as_chunks::<CHANNELS>().0.iter().map(|pixel| u8::from(counts(pixel))).collect()
}
