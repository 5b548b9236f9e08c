//! Meshes that are parts of one, as programs leave tiles: files whose names differ by numbers alone, and that lie beside each
//! other rather than over each other.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::base::pattern;
use crate::codec::meshes;

/// The most parts that are gone through, to find whether they lie beside each other.
const TRIED: usize = 64;

/// Parts of one mesh.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Tiles {
    /// The path of all of them, in which `*` stands for what differs.
    pub path: String,
    /// The files.
    pub files: Vec<String>,
}

/// The tiles among some meshes below a folder.
pub(super) fn find(root: &Path, meshes: &[&str]) -> Vec<Tiles> {
    let mut alike: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for &file in meshes {
        let skeleton: String = pieces(file).into_iter().map(|(text, number)| if number { "*" } else { text }).collect();
        alike.entry(skeleton).or_default().push(file);
    }
    let several = alike.into_values().filter(|files| files.len() > 1);
    let tiles = several.filter_map(|files| {
        let path = common(&files);
        let mut all: Vec<PathBuf> = files.iter().map(|file| root.join(file)).collect();
        all.sort();
        let exactly = pattern::files(&root.join(&path)).is_ok_and(|found| found == all);
        let tiles = || Tiles { path: path.clone(), files: files.iter().map(|file| (*file).to_owned()).collect() };
        (exactly && lie_beside(&all)).then(tiles)
    });
    tiles.collect()
}

/// A path in pieces: numbers, signs and all, and what stands between.
fn pieces(path: &str) -> Vec<(&str, bool)> {
    let numeric = |c: char| c.is_ascii_digit() || c == '+' || c == '-';
    let mut pieces: Vec<(&str, bool)> = Vec::new();
    let mut rest = path;
    while let Some(first) = rest.chars().next() {
        let number = numeric(first);
        let end = rest.find(|c: char| numeric(c) != number).unwrap_or(rest.len());
        pieces.push((&rest[..end], number));
        rest = &rest[end..];
    }
    pieces
}

/// The path of files that differ by numbers alone: `*` stands where they do.
fn common(files: &[&str]) -> String {
    let all: Vec<Vec<(&str, bool)>> = files.iter().map(|file| pieces(file)).collect();
    let Some(first) = all.first() else { return String::new() };
    let same = |at: usize| all.iter().all(|pieces| pieces.get(at) == first.get(at));
    first.iter().enumerate().map(|(at, (text, _))| if same(at) { *text } else { "*" }).collect()
}

/// Whether no two of these meshes lie over each other.
fn lie_beside(files: &[PathBuf]) -> bool {
    let boxes: Vec<[DVec3; 2]> = files.iter().take(TRIED).filter_map(|file| bounds(file)).collect();
    boxes.len() > 1 && boxes.iter().enumerate().all(|(at, a)| boxes[..at].iter().all(|b| is_beside(a, b)))
}

/// The box about some vertices of a mesh.
fn bounds(file: &Path) -> Option<[DVec3; 2]> {
    let points = meshes::sample(&file.into()).ok().filter(|points| !points.is_empty())?;
    let within = |by: fn(DVec3, DVec3) -> DVec3| points.iter().copied().reduce(by);
    Some([within(DVec3::min)?, within(DVec3::max)?])
}

/// Whether two boxes share less than half of the smaller one along some axis: tiles overlap by their margins.
fn is_beside([low, high]: &[DVec3; 2], [other_low, other_high]: &[DVec3; 2]) -> bool {
    let shared = high.min(*other_high) - low.max(*other_low);
    let smaller = (*high - *low).min(*other_high - *other_low);
    (0..3).any(|axis| shared[axis] < 0.5 * smaller[axis])
}
