//! The poses in a project's folder, each with the photographs that are theirs.

use std::path::Path;

use super::listing::{Listing, below, is_of_masks, named};
use super::photographs::{self, Photographs};
use crate::base::Result;
use crate::base::patience::Patience;
use crate::codec::images::is_picture;
use crate::codec::meshes::is_named;
use crate::codec::poses::{self, FORMATS, PhotographFolder, PoseFormat, Posed, Target};
use crate::scene::frame::Frame;
use crate::scene::georeference::Georeference;

/// The most poses that are read.
const MOST: usize = 16;

/// The most files in one folder whose first bytes are looked at.
const OPENED: usize = 64;

/// The most folders of photographs that poses are read with, where names fit several.
const TRIED: usize = 8;

/// Poses that were found and read.
#[derive(Debug)]
pub(super) struct Cameras {
    /// The format.
    pub format: &'static PoseFormat,
    /// The path that leads to them, relative to the project's folder.
    pub path: String,
    /// The frames, sorted by name.
    pub frames: Vec<Frame>,
    /// Where on the earth they stand, if the files say it.
    pub place: Option<Georeference>,
    /// What else the format says, as of its coordinates.
    pub notes: Vec<String>,
}

/// Poses, and their photographs if they are there.
pub(super) type Taken = (Cameras, Option<Photographs>);

/// All poses, what is nearer first, and what is to be said of those that cannot be read.
pub(super) fn find(root: &Path, listing: &Listing) -> (Vec<Taken>, Vec<String>) {
    let (mut found, mut broken) = (Vec::new(), Vec::new());
    for (format, path) in places(root, listing) {
        match (Reading { root, listing, format, path: &path }).posed() {
            Ok((Posed { frames, georeference: place, notes, .. }, photographs)) => {
                found.push((Cameras { format, path, frames, place, notes }, photographs))
            }
            Err(why) => broken.push(format!("poses {} cannot be read: {why}", named(&path))),
        }
    }
    (found, broken)
}

/// Poses that are being read.
struct Reading<'a> {
    root: &'a Path,
    listing: &'a Listing,
    format: &'static PoseFormat,
    path: &'a str,
}

impl Reading<'_> {
    /// The frames, named as the photographs are below their folder.
    ///
    /// # Errors
    /// Those of the format.
    fn posed(&self) -> Result<(Posed, Option<Photographs>)> {
        match self.looked("") {
            Ok(posed) => {
                let found = photographs::find(self.root, self.listing, &posed.frames);
                let narrow = found.as_ref().and_then(|found| self.narrow(found));
                Ok(narrow.map_or((posed, found), |(posed, found)| (posed, Some(found))))
            }
            // A program may leave the same photographs twice, as they were taken and undistorted.
            Err(why) => self.apart().map(|(posed, found)| (posed, Some(found))).ok_or(why),
        }
    }

    /// The frames, as they are named with the photographs of a folder.
    fn looked(&self, folder: &str) -> Result<Posed> {
        let photographs = PhotographFolder::new(&self.root.join(folder));
        Patience::default().with(|| poses::look(self.format, &self.root.join(self.path), &photographs))
    }

    /// The same photographs in the folder that all of them lie in, where a name is settled by what is there.
    fn narrow(&self, found: &Photographs) -> Option<(Posed, Photographs)> {
        let shared = found.shared();
        let narrow = (!shared.is_empty()).then(|| self.within(&below(&found.folder, shared)))?;
        narrow.filter(|(_, narrow)| narrow.count() == found.count())
    }

    fn within(&self, folder: &str) -> Option<(Posed, Photographs)> {
        let posed = self.looked(folder).ok()?;
        let found = photographs::within(self.root, self.listing, folder, &posed.frames)?;
        Some((posed, found))
    }

    /// The folder with the most photographs, of those that have photographs right in them.
    fn apart(&self) -> Option<(Posed, Photographs)> {
        let has = |folder: &&String| {
            !is_of_masks(folder) && self.listing.within(folder).any(|file| is_picture(Path::new(file)))
        };
        let folders = self.listing.folders.iter().filter(has).take(TRIED);
        folders.filter_map(|folder| self.within(folder)).min_by(|(_, a), (_, b)| a.rank().cmp(&b.rank()))
    }
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
