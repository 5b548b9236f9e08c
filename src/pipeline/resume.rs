//! What a run has to do again, and what it can keep: the keys of its units of work, compared with the manifest.
//!
//! A key is a content hash of what a unit is made of: bytes of files, the configuration that changes its bytes, the
//! version of its format. Never a time or a path. So touching a file redoes nothing, and changing one redoes what was
//! made of it.

use std::path::Path;

use rayon::prelude::*;

use super::Pipeline;
use crate::base::Result;
use crate::base::ids::FrameId;
use crate::base::key::{Key, KeyBuilder};
use crate::codec::image;
use crate::disk::Manifest;
use crate::scene::frame::Frame;
use crate::shard::format::VERSION;
use crate::stages::gather::Group;

/// The groups of a run's frames, each with its key.
pub fn groups(pipeline: &Pipeline, mesh: Key, frames: &[Frame]) -> Vec<Group> {
    let ids: Vec<FrameId> = (0..frames.len() as FrameId).collect();
    let keys: Vec<Key> = frames.par_iter().map(|frame| frame_key(pipeline, frame)).collect();
    ids.chunks(pipeline.gather.group as usize)
        .map(|ids| {
            let start = KeyBuilder::new("gonio map unit 1").field(&VERSION.to_le_bytes()).key(mesh);
            let key = ids.iter().fold(start, |key, &id| key.key(keys[id as usize])).finish();
            Group { key, frames: ids.to_vec() }
        })
        .collect()
}

/// The key of all that a frame's observations are made of, the mesh aside.
fn frame_key(pipeline: &Pipeline, frame: &Frame) -> Key {
    let content = |path: &Path| match Key::of_file(path) {
        Ok(key) => key.to_string(),
        // What cannot be read is skipped when its turn comes; once it can be read, its key is another.
        Err(_) => "unreadable".to_owned(),
    };
    let scene = &pipeline.scene;
    let mask = scene.masks.as_deref().and_then(|masks| image::mask_path(masks, &frame.name));
    // Debug output of floats has all their digits.
    KeyBuilder::new("gonio frame 1")
        .field(frame.name.as_bytes())
        .field(format!("{:?} {:?}", frame.camera, frame.pose).as_bytes())
        .field(content(&scene.images.join(&frame.name)).as_bytes())
        .field(mask.as_deref().map(content).unwrap_or_default().as_bytes())
        .field(format!("{:?}", pipeline.decode).as_bytes())
        .finish()
}

/// The groups that the manifest does not have.
pub fn to_do(manifest: &Manifest, groups: &[Group]) -> Vec<Group> {
    groups.iter().filter(|g| manifest.files(&g.unit()).is_none()).cloned().collect()
}

/// Forgets the units of a kind, which is how their names begin, that this run is not made of, and removes their files.
pub fn forget_others(manifest: &mut Manifest, kind: &str, wanted: impl Fn(&str) -> bool) -> Result<()> {
    let stale = manifest.units().keys().filter(|unit| unit.starts_with(kind) && !wanted(unit));
    let stale: Vec<String> = stale.cloned().collect();
    if stale.is_empty() { Ok(()) } else { manifest.forget(stale.iter().map(String::as_str)) }
}
