//! The files and folders below a project's folder.

use std::collections::{BTreeSet, VecDeque};
use std::fs;
use std::path::{Path, PathBuf};

use crate::base::{Error, Result};
use crate::disk::mark::MARK;

/// The most files and folders that are listed.
const MOST: usize = 1 << 18;

/// The most folders above one another.
const DEEPEST: usize = 8;

/// The files and folders below a folder, by their paths relative to it, with `/` between folders. What is nearer comes first.
#[derive(Debug, Default)]
pub(super) struct Listing {
    /// The folders; the first is the folder itself, "".
    pub folders: Vec<String>,
    /// The files.
    pub files: Vec<String>,
    /// Whether there is more than was listed.
    pub cut: bool,
}

impl Listing {
    /// Lists a folder. Links are followed, each folder is listed once. Hidden folders, folders of runs and names that are not
    /// UTF-8 are left out.
    ///
    /// # Errors
    /// The folder itself cannot be listed.
    pub(super) fn of(root: &Path) -> Result<Listing> {
        fs::read_dir(root).map_err(Error::io("list", root))?;
        let mut listing = Listing::default();
        let (mut seen, mut waiting) = (BTreeSet::new(), VecDeque::from([(String::new(), 0)]));
        while let Some((folder, depth)) = waiting.pop_front() {
            let path = root.join(&folder);
            if path.join(MARK).is_file() || !seen.insert(path.canonicalize().unwrap_or(path.clone())) {
                continue;
            }
            for name in names(&path) {
                let (name, entry) = (below(&folder, &name), path.join(&name));
                if !entry.is_dir() {
                    listing.files.push(name);
                } else if depth < DEEPEST {
                    waiting.push_back((name, depth + 1));
                } else {
                    listing.cut = true;
                }
            }
            listing.folders.push(folder);
            if listing.files.len() + waiting.len() >= MOST {
                listing.cut = true;
                break;
            }
        }
        Ok(listing)
    }

    /// The files right in a folder.
    pub(super) fn within<'a>(&'a self, folder: &'a str) -> impl Iterator<Item = &'a str> {
        self.files.iter().map(String::as_str).filter(move |file| above(file) == folder)
    }
}

/// The names in a folder that are not hidden, sorted.
fn names(folder: &PathBuf) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().take(MOST);
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.retain(|name| !name.starts_with('.') && !name.contains(char::is_control));
    names.sort();
    names
}

/// Whether a file or folder is named as masks are, or lies in a folder that is.
pub(super) fn is_of_masks(path: &str) -> bool {
    path.to_lowercase().contains("mask")
}

/// The path of something in a folder.
pub(super) fn below(folder: &str, name: &str) -> String {
    if folder.is_empty() { name.to_owned() } else { format!("{folder}/{name}") }
}

/// The folder that holds something.
pub(super) fn above(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// A path as it is told and written: the folder itself is ".".
pub(super) fn named(path: &str) -> &str {
    if path.is_empty() { "." } else { path }
}
