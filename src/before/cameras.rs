//! The poses in a project's folder.

use std::path::Path;

use super::listing::{Listing, below, named};
use crate::base::patience::Patience;
use crate::codec::images::is_picture;
use crate::codec::meshes::is_named;
use crate::codec::poses::{self, FORMATS, PhotographFolder, PoseFormat, Target};
use crate::scene::frame::Frame;

/// The most poses that are read.
const MOST: usize = 16;

/// The most files in one folder whose first bytes are looked at.
const OPENED: usize = 64;

/// Poses that were found and read.
#[derive(Debug)]
pub(super) struct Cameras {
    /// The format.
    pub format: &'static PoseFormat,
    /// The path that leads to them, relative to the project's folder.
    pub path: String,
    /// The frames, sorted by name.
    pub frames: Vec<Frame>,
}

/// All poses, what is nearer first, and what is to be said of those that cannot be read.
pub(super) fn find(root: &Path, listing: &Listing) -> (Vec<Cameras>, Vec<String>) {
    let (mut found, mut broken) = (Vec::new(), Vec::new());
    let photographs = PhotographFolder::new(root);
    let patience = Patience::default();
    for (format, path) in places(root, listing) {
        match patience.with(|| poses::read(format, &root.join(&path), &photographs)) {
            Ok(frames) => found.push(Cameras { format, path, frames }),
            Err(why) => broken.push(format!("poses {} cannot be read: {why}", named(&path))),
        }
    }
    (found, broken)
}

/// Where the poses lie.
fn places(root: &Path, listing: &Listing) -> Vec<(&'static PoseFormat, String)> {
    let mut places = Vec::new();
    for folder in &listing.folders {
        for format in FORMATS {
            if (format.is_at)(&root.join(folder)) {
                places.push((*format, folder.clone()));
            } else if format.target != Target::Folder {
                let file = files(listing, folder).into_iter().find(|file| (format.is_at)(&root.join(file)));
                places.extend(file.map(|file| (*format, file)));
            }
            if places.len() >= MOST {
                return places;
            }
        }
    }
    places
}

/// The files in a folder that may hold poses.
fn files(listing: &Listing, folder: &str) -> Vec<String> {
    let other = |file: &&str| !is_picture(Path::new(file)) && !is_named(Path::new(file));
    listing.within(folder).filter(other).take(OPENED).map(str::to_owned).collect()
}

/// The files and folders that a COLMAP project has before its cameras are posed.
pub(super) fn database(listing: &Listing) -> Option<String> {
    listing.folders.iter().map(|folder| below(folder, "database.db")).find(|file| listing.files.contains(file))
}
