//! The meshes in a project's folder.

use std::cmp::Reverse;
use std::fs;
use std::path::Path;

use super::listing::Listing;
use crate::codec::meshes;

/// The most meshes that are looked at.
const MOST: usize = 64;

/// Words in the names of meshes that were made for looks or for speed, and hold less than the one that they were made from.
const LESSER: [&str; 4] = ["simplified", "decimated", "lowpoly", "25d"];

/// The meshes that were found.
#[derive(Debug, Default)]
pub(super) struct Surfaces {
    /// The meshes with their bytes, the best first.
    pub meshes: Vec<(String, u64)>,
    /// The files that are named as meshes are and are none, with the reason.
    pub others: Vec<(String, String)>,
}

/// All meshes: those of which less was taken away first, then the largest.
pub(super) fn find(root: &Path, listing: &Listing) -> Surfaces {
    let mut found = Surfaces::default();
    for file in listing.files.iter().filter(|file| meshes::is_named(Path::new(file))).take(MOST) {
        let path = root.join(file);
        match meshes::look(&path) {
            Ok(()) => found.meshes.push((file.clone(), fs::metadata(&path).map_or(0, |found| found.len()))),
            Err(why) => found.others.push((file.clone(), why.to_string())),
        }
    }
    let lesser = |file: &str| LESSER.iter().any(|word| file.to_lowercase().contains(word));
    found.meshes.sort_by_key(|(file, bytes)| (lesser(file), Reverse(*bytes)));
    found
}
