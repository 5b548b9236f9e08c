//! The folder that holds the photographs that poses name.

use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::fs::{self, DirEntry};
use std::path::Path;

use super::listing::{Listing, above, below, is_of_masks};
use crate::codec::images::{self, Size, is_picture};
use crate::codec::poses::{Alike, resolve};
use crate::scene::frame::Frame;

/// The most folders that are tried.
const TRIED: usize = 128;

/// How many headers are read.
const HEADERS: usize = 16;

/// The largest downscale.
const SMALLEST: u32 = 64;

/// A folder of photographs.
#[derive(Debug, Clone)]
pub(super) struct Photographs {
    /// The folder, relative to the project's.
    pub folder: String,
    /// The photograph of each frame, relative to the folder.
    pub files: Vec<Option<String>>,
    /// How the names that differ were matched.
    pub alike: Option<Alike>,
    /// Whether the photographs' sizes are those of the cameras.
    pub fit: Fit,
}

/// How the sizes of photographs go with those of their cameras. The better comes first.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Fit {
    /// Photographs are so many times smaller.
    Smaller(u32),
    /// The sizes do not fit; the words say how.
    Not(String),
}

impl Photographs {
    /// How many frames have a photograph.
    pub(super) fn count(&self) -> usize {
        self.files.iter().flatten().count()
    }

    /// What is better comes first: more photographs, then sizes that fit.
    pub(super) fn rank(&self) -> (Reverse<usize>, Option<Alike>, &Fit) {
        (Reverse(self.count()), self.alike, &self.fit)
    }

    /// The folder below this one that all photographs lie in; "" if it is this one.
    pub(super) fn shared(&self) -> &str {
        let mut files = self.files.iter().flatten();
        let mut shared = files.next().map_or("", |file| above(file));
        for file in files {
            while !(shared.is_empty() || file.strip_prefix(shared).is_some_and(|rest| rest.starts_with('/'))) {
                shared = above(shared);
            }
        }
        shared
    }
}

/// The photographs of these frames in a folder, by their very names.
pub(super) fn within(root: &Path, listing: &Listing, folder: &str, frames: &[Frame]) -> Option<Photographs> {
    let files: Vec<Option<String>> = exact(&pictures(listing), folder, frames);
    let fit = fit(&root.join(folder), frames, &files);
    files.iter().any(Option::is_some).then(|| Photographs { folder: folder.to_owned(), files, alike: None, fit })
}

fn exact(pictures: &BTreeSet<&str>, folder: &str, frames: &[Frame]) -> Vec<Option<String>> {
    let file = |frame: &Frame| pictures.contains(&*below(folder, &frame.name)).then(|| frame.name.clone());
    frames.iter().map(file).collect()
}

fn pictures(listing: &Listing) -> BTreeSet<&str> {
    listing.files.iter().map(String::as_str).filter(|file| is_picture(Path::new(file))).collect()
}

/// The folder that holds the most photographs of these frames; among equals the one whose sizes fit, then the nearest.
pub(super) fn find(root: &Path, listing: &Listing, frames: &[Frame]) -> Option<Photographs> {
    let pictures = pictures(listing);
    let folders = folders(listing, &pictures);
    let exact = |folder: &&str| ((*folder).to_owned(), None, exact(&pictures, folder, frames));
    let alike = |folder: &&str| {
        let prefix = below(folder, "");
        let under = |file: &&&str| file.strip_prefix(&*prefix).map(str::to_owned);
        let files: Vec<String> = pictures.iter().filter_map(|file| under(&file)).collect();
        let names: Vec<&str> = frames.iter().map(|frame| frame.name.as_str()).collect();
        let (alike, found) = resolve(&names, &files)?;
        Some(((*folder).to_owned(), Some(alike), found.into_iter().map(|file| file.map(str::to_owned)).collect()))
    };
    let best = most(folders.iter().map(exact).collect());
    let best = if best.is_empty() { most(folders.iter().filter_map(alike).collect()) } else { best };
    let fitting = best.into_iter().map(|(folder, alike, files)| {
        let fit = fit(&root.join(&folder), frames, &files);
        Photographs { folder, files, alike, fit }
    });
    // The first of equals: folders come from what is nearest.
    fitting.min_by(|a, b| (a.alike, &a.fit).cmp(&(b.alike, &b.fit)))
}

type Candidate = (String, Option<Alike>, Vec<Option<String>>);

/// The candidates with the most photographs; none where none has any.
fn most(candidates: Vec<Candidate>) -> Vec<Candidate> {
    let count = |(.., files): &Candidate| files.iter().flatten().count();
    let most = candidates.iter().map(count).max().unwrap_or(0);
    candidates.into_iter().filter(|candidate| most > 0 && count(candidate) == most).collect()
}

/// A folder beside the project's in which most of these frames have a photograph of their name, and how many have one.
pub(super) fn beside(root: &Path, frames: &[Frame]) -> Option<(String, usize)> {
    let root = root.canonicalize().ok()?;
    let name = |entry: DirEntry| entry.file_name().into_string().ok().filter(|name| !name.starts_with('.'));
    let mut siblings: Vec<String> = fs::read_dir(root.parent()?).ok()?.flatten().filter_map(name).collect();
    siblings.sort();
    let own = root.file_name().unwrap_or_default();
    let others = siblings.into_iter().filter(|name| own != name.as_str()).take(TRIED);
    let folders = others.flat_map(|name| [format!("../{name}"), format!("../{name}/images")]);
    let count = |folder: String| {
        let there = |frame: &&Frame| root.join(&folder).join(&frame.name).is_file();
        (frames.iter().filter(there).count(), Reverse(folder.clone()), folder)
    };
    let (count, _, folder) = folders.map(count).max()?;
    (2 * count > frames.len()).then_some((folder, count))
}

/// The folders that have pictures, themselves or below, what is nearer first.
fn folders<'a>(listing: &'a Listing, pictures: &BTreeSet<&str>) -> Vec<&'a str> {
    let mut with: BTreeSet<&str> = BTreeSet::from([""]);
    for picture in pictures {
        let mut folder = above(picture);
        while with.insert(folder) {
            folder = above(folder);
        }
    }
    let all = listing.folders.iter().map(String::as_str);
    all.filter(|folder| with.contains(folder) && !is_of_masks(folder)).take(TRIED).collect()
}

/// How the sizes of some photographs go with those of their cameras.
fn fit(folder: &Path, frames: &[Frame], files: &[Option<String>]) -> Fit {
    let there: Vec<(&Frame, &String)> =
        frames.iter().zip(files).filter_map(|(frame, file)| Some((frame, file.as_ref()?))).collect();
    let step = there.len().div_ceil(HEADERS).max(1);
    let mut smaller = None;
    for (frame, file) in there.into_iter().step_by(step) {
        let camera = Size { width: frame.camera.width, height: frame.camera.height };
        let Ok(size) = images::size(&folder.join(file)) else { continue };
        let by = (1..=SMALLEST).find(|&by| size.is_smaller(camera, by));
        match (by, smaller) {
            (Some(by), None) => smaller = Some(by),
            (Some(by), Some(before)) if by == before => {}
            (Some(by), Some(before)) => {
                return Fit::Not(format!("some are {before} times smaller than their cameras, some {by} times"));
            }
            (None, _) => {
                let larger = size.width >= camera.width;
                let hint = if larger { "; these may be the originals, and the poses of smaller images" } else { "" };
                return Fit::Not(format!("{file} has {size} pixels, and its camera {camera}{hint}"));
            }
        }
    }
    smaller.map_or_else(|| Fit::Not("no header can be read".to_owned()), Fit::Smaller)
}
