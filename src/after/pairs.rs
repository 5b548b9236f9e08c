//! Pictures held against those that they should be: two files, or two folders file by file.
//!
//! A picture in a folder is known as a frame is, by its name relative to the folder, ending included, with `/` between
//! folders. What is not named as a picture, and folders that are links, are passed over. One pair is held at a time.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::base::units::Bytes;
use crate::base::{Error, Result};
use crate::codec::images::{self, Curve, Transfer, to_srgb};
use crate::render::pictures::PictureErrors;
use crate::scene::frame::LinearImage;

/// Bytes that a pair may take.
const MEMORY: u64 = 4 * Bytes::GIB;

/// What is compared, clipped to [0, 1].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ColorSpace {
    /// Linear radiance; samples of 8 and 16 bits are taken to be sRGB.
    Linear,
    /// The sRGB values of that, as a picture on a screen has them.
    Srgb,
}

/// What was compared, and what was not.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Compared {
    /// The pairs that were compared, sorted by name.
    pub pairs: Vec<Pair>,
    /// The pictures that were skipped, sorted by name.
    pub skipped: Vec<Unpaired>,
    /// The errors over all pixels and all windows of all pairs.
    pub all: PictureErrors,
}

/// A picture, and how far it is from the one that it should be.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pair {
    /// The pictures' name.
    pub name: PathBuf,
    /// The errors.
    pub errors: PictureErrors,
}

/// A picture that was not compared.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Unpaired {
    /// The picture's name.
    pub name: PathBuf,
    /// Why it was not compared.
    pub why: String,
}

/// Compares what was found with the truth. Where they are folders, a picture that is in one only is skipped, and so is
/// a pair that cannot be compared: a damaged file, two sizes.
///
/// # Errors
/// A file and a folder; two files that cannot be compared; two folders without a pair that can.
pub(crate) fn compare(truth: &Path, found: &Path, space: ColorSpace) -> Result<Compared> {
    let is_folder = |path: &Path| fs::metadata(path).map(|file| file.is_dir()).map_err(Error::io("open", path));
    let curve = Curve::new(Transfer::Srgb);
    match (is_folder(truth)?, is_folder(found)?) {
        (false, false) => {
            let name = truth.file_name().map_or_else(|| truth.to_owned(), PathBuf::from);
            let errors = pair(truth, found, &curve, space)?;
            Ok(Compared { pairs: vec![Pair { name, errors }], skipped: Vec::new(), all: errors })
        }
        (true, true) => folders(truth, found, |truth, found| pair(truth, found, &curve, space)),
        (folder, _) => {
            let (folder, file) = if folder { (truth, found) } else { (found, truth) };
            let [folder, file] = [folder, file].map(Path::display);
            Err(Error::invalid(format!("{folder} is a folder and {file} is a file: give two folders, or two files")))
        }
    }
}

fn folders(truth: &Path, found: &Path, pair: impl Fn(&Path, &Path) -> Result<PictureErrors>) -> Result<Compared> {
    let (wanted, there) = (names(truth)?, names(found)?);
    let mut compared = Compared::default();
    for name in wanted.union(&there) {
        let lacks = if wanted.contains(name) { found } else { truth };
        if !(wanted.contains(name) && there.contains(name)) {
            compared.skipped.push(Unpaired { name: name.clone(), why: format!("not in {}", lacks.display()) });
            continue;
        }
        match pair(&truth.join(name), &found.join(name)) {
            Ok(errors) => {
                compared.all.merge(&errors);
                compared.pairs.push(Pair { name: name.clone(), errors });
            }
            Err(why) => compared.skipped.push(Unpaired { name: name.clone(), why: why.to_string() }),
        }
    }
    if compared.pairs.is_empty() {
        let (pairs, [truth, found]) = (wanted.intersection(&there).count(), [truth, found].map(Path::display));
        let why = compared.skipped.iter().find(|left| wanted.contains(&left.name) && there.contains(&left.name));
        return Err(Error::invalid(match why {
            None => format!("no picture in {truth} has one of the same name in {found}"),
            Some(Unpaired { why, .. }) => {
                format!("none of {pairs} pictures of {truth} can be compared with its like in {found}: {why}")
            }
        }));
    }
    Ok(compared)
}

/// Names of the pictures in a folder and its folders.
fn names(root: &Path) -> Result<BTreeSet<PathBuf>> {
    let (mut folders, mut names) = (vec![root.to_owned()], BTreeSet::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).map_err(Error::io("read the folder", &folder))? {
            let entry = entry.map_err(Error::io("read the folder", &folder))?;
            let path = entry.path();
            // Not of a link, which may lead back.
            if entry.file_type().map_err(Error::io("look at", &path))?.is_dir() {
                folders.push(path);
            } else if images::is_picture(&path) && path.is_file() {
                names.extend(path.strip_prefix(root).map(Path::to_owned));
            }
        }
    }
    Ok(names)
}

fn pair(truth: &Path, found: &Path, curve: &Curve, space: ColorSpace) -> Result<PictureErrors> {
    let (size, other) = (images::size(truth)?, images::size(found)?);
    if size != other {
        let truth = truth.display();
        let words = format!("{other} pixels, where {truth} has {size}");
        return Err(Error::malformed(found, words));
    }
    let wanted = images::read_image(truth, size, curve, MEMORY)?;
    let found = images::read_image(found, size, curve, MEMORY.saturating_sub(wanted.bytes()))?;
    let [width, height] = [size.width, size.height].map(|side| side as usize);
    let values = |image: &LinearImage, at| {
        let rgb = image.pixel(at).map_or([f32::NAN; 3], |pixel| pixel.rgb);
        if space == ColorSpace::Srgb { rgb.map(to_srgb) } else { rgb }
    };
    Ok(PictureErrors::of(width, height, |y, wanted_row, found_row| {
        let row = y * width..(y + 1) * width;
        wanted_row.extend(row.clone().map(|at| values(&wanted, at)));
        found_row.extend(row.map(|at| values(&found, at)));
    }))
}
