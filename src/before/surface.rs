//! The meshes in a project's folder.

use std::cmp::Reverse;
use std::fs;
use std::path::Path;

use glam::DVec3;

use super::cameras::Cameras;
use super::listing::Listing;
use super::tiles::{self, Tiles};
use crate::codec::meshes;
use crate::codec::poses::OPENDRONEMAP;
use crate::scene::frame::Frame;
use crate::scene::seen::share_seen;

/// The most meshes that are looked at.
const MOST: usize = 64;

/// The most meshes that are gone through, to find how much of them the cameras see.
const TRIED: usize = 6;

/// Words in the names of meshes that were made for looks or for speed, and hold less than the one that they were made from.
const LESSER: [&str; 4] = ["simplified", "decimated", "lowpoly", "25d"];

/// A mesh.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Surface {
    /// The file, or the path of several in which `*` stands for what differs.
    pub file: String,
    /// The bytes of all files.
    pub bytes: u64,
    /// How many files there are.
    pub parts: usize,
    /// Some of the vertices; none where it was not gone through.
    pub points: Vec<DVec3>,
    /// What share of the vertices the cameras see, where there are cameras.
    pub seen: Option<f64>,
}

/// The meshes that were found.
#[derive(Debug, Default)]
pub(super) struct Surfaces {
    /// The meshes, the best first.
    pub meshes: Vec<Surface>,
    /// The files that are named as meshes are and are none, with the reason.
    pub others: Vec<(String, String)>,
}

/// All meshes: those that the cameras see first, then those of which less was taken away, then the largest.
pub(super) fn find(root: &Path, listing: &Listing, cameras: Option<&Cameras>) -> Surfaces {
    let mut found = Surfaces::default();
    let named = listing.files.iter().map(String::as_str).filter(|file| meshes::is_named(Path::new(file)));
    let mut files: Vec<&str> = named.collect();
    let bytes = |file: &str| fs::metadata(root.join(file)).map_or(0, |found| found.len());
    for Tiles { path, files: parts } in tiles::find(root, &files) {
        files.retain(|file| !parts.iter().any(|part| part == file));
        found.add(path, parts.iter().map(|part| bytes(part)).sum(), parts.len());
    }
    for file in files.into_iter().take(MOST) {
        match meshes::look(&root.join(file)) {
            Ok(()) => found.add(file.to_owned(), bytes(file), 1),
            Err(why) => found.others.push((file.to_owned(), why.to_string())),
        }
    }
    // OpenDroneMap writes two meshes, and poses about the georeferenced one.
    let apart = |file: &str| cameras.is_some_and(|with| *with.format == OPENDRONEMAP) && !file.contains("_geo.");
    let lesser = |file: &str| LESSER.iter().any(|word| file.to_lowercase().contains(word));
    found.meshes.sort_by_key(|mesh| (lesser(&mesh.file), apart(&mesh.file), Reverse(mesh.bytes)));
    if let Some(cameras) = cameras {
        found.go_through(root, &cameras.frames);
    }
    found
}

impl Surfaces {
    fn add(&mut self, file: String, bytes: u64, parts: usize) {
        self.meshes.push(Surface { file, bytes, parts, points: Vec::new(), seen: None });
    }

    /// Finds how much of the first meshes the cameras see, and puts those of which they see little behind the others.
    fn go_through(&mut self, root: &Path, frames: &[Frame]) {
        let rest = self.meshes.split_off(self.meshes.len().min(TRIED));
        for mut mesh in std::mem::take(&mut self.meshes) {
            match meshes::sample(&root.join(&mesh.file).into()) {
                Ok(points) => {
                    mesh.seen = Some(share_seen(frames, &points));
                    mesh.points = points;
                    self.meshes.push(mesh);
                }
                Err(why) => self.others.push((mesh.file, why.to_string())),
            }
        }
        let most = self.meshes.iter().filter_map(|mesh| mesh.seen).fold(0.0, f64::max);
        self.meshes.sort_by_key(|mesh| mesh.seen.is_some_and(|seen| seen < 0.25 * most));
        self.meshes.extend(rest);
    }
}
