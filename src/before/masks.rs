//! The folder that holds the masks of photographs.

use std::path::Path;

use super::listing::{Listing, is_of_masks};
use super::photographs::Photographs;
use crate::codec::images::mask_path;

/// A folder of masks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Masks {
    /// The folder, relative to the project's.
    pub folder: String,
    /// How many photographs have a mask there.
    pub count: usize,
}

/// The folder that holds the most masks of photographs: one that is named so, or that of the photographs.
pub(super) fn find(root: &Path, listing: &Listing, photographs: &Photographs) -> Option<Masks> {
    let beside = listing.within(&photographs.folder).any(|file| is_of_masks(file.rsplit('/').next().unwrap_or(file)));
    let named = listing.folders.iter().filter(|folder| is_of_masks(folder));
    let folders = named.chain(beside.then_some(&photographs.folder));
    let images = root.join(&photographs.folder);
    let count = |folder: &String| {
        let masked = |file: &&String| matches!(mask_path(&root.join(folder), &images, file), Ok(Some(_)));
        let count = photographs.files.iter().flatten().filter(masked).count();
        (count > 0).then(|| Masks { folder: folder.clone(), count })
    };
    // The first of equals.
    folders.filter_map(count).reduce(|best, next| if next.count > best.count { next } else { best })
}
