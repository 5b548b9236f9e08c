//! The photographs of a scene, as they lie in their folder.

use std::collections::BTreeSet;
use std::path::Path;

use crate::codec::poses::{self, Photographs};
use crate::scene::frame::Frame;

/// Gives frames whose photographs are not there the names of files that are theirs in all likelihood; tells what was assumed.
pub(super) fn find_photographs(frames: &mut [Frame], images: &Path, photographs: &dyn Photographs) -> Option<String> {
    let missing: Vec<usize> = (0..frames.len()).filter(|&at| !images.join(&frames[at].name).exists()).collect();
    if missing.is_empty() {
        return None;
    }
    let named: BTreeSet<String> = frames.iter().map(|frame| frame.name.clone()).collect();
    // A folder that cannot be read has no photographs: each of them is told of when it is skipped.
    let there = photographs.names().unwrap_or_default();
    let files: Vec<String> = there.iter().filter(|file| !named.contains(*file)).cloned().collect();
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
