//! The photographs of a scene, as they lie in their folder.

use std::collections::BTreeSet;
use std::path::Path;

use crate::codec::poses::{self, PhotographFolder, Photographs};
use crate::scene::frame::Frame;

/// The photographs in a folder and below, by their names relative to it, sorted. A folder that cannot be read has none.
pub(super) fn pictures(folder: &Path) -> Vec<String> {
    PhotographFolder::new(folder).names().map(<[String]>::to_vec).unwrap_or_default()
}

/// Gives frames whose photographs are not there the names of files that are theirs in all likelihood; tells what was assumed.
pub(super) fn find_photographs(frames: &mut [Frame], images: &Path) -> Option<String> {
    let missing: Vec<usize> = (0..frames.len()).filter(|&at| !images.join(&frames[at].name).exists()).collect();
    if missing.is_empty() {
        return None;
    }
    let named: BTreeSet<String> = frames.iter().map(|frame| frame.name.clone()).collect();
    let files: Vec<String> = pictures(images).into_iter().filter(|file| !named.contains(file)).collect();
    let names: Vec<&str> = missing.iter().map(|&at| frames[at].name.as_str()).collect();
    let (alike, found) = poses::resolve(&names, &files)?;
    let pairs: Vec<(usize, String)> =
        missing.into_iter().zip(found).filter_map(|(at, file)| Some((at, file?.to_owned()))).collect();
    let (first, file) = pairs.first()?;
    let words = format!(
        "{} of {} photographs are found {alike}: {} is taken for {}",
        pairs.len(),
        frames.len(),
        images.join(file).display(),
        frames[*first].name
    );
    pairs.into_iter().for_each(|(at, file)| frames[at].name = file);
    frames.sort_by(|a, b| a.name.cmp(&b.name));
    Some(words)
}
