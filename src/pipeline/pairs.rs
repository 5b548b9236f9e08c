//! Pictures held against those that they should be: two files, or two folders file by file.
//!
//! A picture in a folder is known as a frame is, by its name relative to the folder, ending included, with `/` between
//! folders. What is not named as a picture, and folders that are links, are passed over. One pair is held at a time.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::base::units::Bytes;
use crate::base::{Error, Result};
use crate::codec::image::{self, Curve, Transfer, to_srgb};
use crate::render::pictures::PictureErrors;
use crate::scene::frame::LinearImage;

/// Bytes that a pair may take.
const MEMORY: u64 = 4 * Bytes::GIB;

/// What is compared, clipped to [0, 1].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Space {
    /// Linear radiance; samples of 8 and 16 bits are taken to be sRGB.
    Linear,
    /// The sRGB values of that, as a picture on a screen has them.
    Srgb,
}

/// What was compared, and what was not.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Compared {
    /// Names and errors, sorted by name.
    pub pictures: Vec<(PathBuf, PictureErrors)>,
    /// Names of pictures that were skipped, and why; sorted.
    pub skipped: Vec<(PathBuf, String)>,
    /// The errors over all pixels and all windows of all pictures.
    pub all: PictureErrors,
}

/// Compares what was found with the truth. Where they are folders, a picture that is in one only is skipped, and so is
/// a pair that cannot be compared: a damaged file, two sizes.
///
/// # Errors
/// A file and a folder; two files that cannot be compared; two folders without a pair that can.
pub fn compare(truth: &Path, found: &Path, space: Space) -> Result<Compared> {
    let is_folder = |path: &Path| fs::metadata(path).map(|file| file.is_dir()).map_err(Error::io("open", path));
    let curve = Curve::new(Transfer::Srgb);
    match (is_folder(truth)?, is_folder(found)?) {
        (false, false) => {
            let name = truth.file_name().map_or_else(|| truth.to_owned(), PathBuf::from);
            let errors = pair(truth, found, &curve, space)?;
            Ok(Compared { pictures: vec![(name, errors)], skipped: Vec::new(), all: errors })
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
            compared.skipped.push((name.clone(), format!("not in {}", lacks.display())));
            continue;
        }
        match pair(&truth.join(name), &found.join(name)) {
            Ok(errors) => {
                compared.all.merge(&errors);
                compared.pictures.push((name.clone(), errors));
            }
            Err(why) => compared.skipped.push((name.clone(), why.to_string())),
        }
    }
    if compared.pictures.is_empty() {
        let (pairs, [truth, found]) = (wanted.intersection(&there).count(), [truth, found].map(Path::display));
        let why = compared.skipped.iter().find(|(name, _)| wanted.contains(name) && there.contains(name));
        return Err(Error::invalid(match why {
            None => format!("no picture in {truth} has one of the same name in {found}"),
            Some((_, why)) => {
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
            } else if image::is_picture(&path) && path.is_file() {
                names.extend(path.strip_prefix(root).map(Path::to_owned));
            }
        }
    }
    Ok(names)
}

fn pair(truth: &Path, found: &Path, curve: &Curve, space: Space) -> Result<PictureErrors> {
    let (size, other) = (image::size(truth)?, image::size(found)?);
    if size != other {
        let truth = truth.display();
        let words = format!("{} x {} pixels, where {truth} has {} x {}", other.0, other.1, size.0, size.1);
        return Err(Error::malformed(found, words));
    }
    let wanted = image::read_picture(truth, size, curve, MEMORY)?;
    let found = image::read_picture(found, size, curve, MEMORY.saturating_sub(wanted.bytes()))?;
    let [width, height] = [size.0, size.1].map(|side| side as usize);
    let values = |image: &LinearImage, at| {
        let rgb = image.pixel(at).map_or([f32::NAN; 3], |pixel| pixel.rgb);
        if space == Space::Srgb { rgb.map(to_srgb) } else { rgb }
    };
    Ok(PictureErrors::of(width, height, |y, wanted_row, found_row| {
        let row = y * width..(y + 1) * width;
        wanted_row.extend(row.clone().map(|at| values(&wanted, at)));
        found_row.extend(row.map(|at| values(&found, at)));
    }))
}
