//! What a run has to do again, and what it can keep: the recipes of its units of work, compared with the manifest.
//!
//! A recipe is made of contents: bytes of files, the configuration that changes a unit's bytes, the version of its format.
//! Never a time or a path. So touching a file redoes nothing, and changing one redoes what was made of it.

use std::collections::BTreeSet;
use std::path::Path;

use rayon::prelude::*;
use serde::Serialize;
use serde_json::Value;

use super::Pipeline;
use super::readable::Readable;
use crate::base::Result;
use crate::base::ids::FrameId;
use crate::base::key::Key;
use crate::codec::image;
use crate::disk::{Manifest, Recipe};
use crate::scene::frame::Frame;
use crate::shard::format::VERSION;
use crate::stages::gather::{FRAMES, Group};

/// How the names of a frame's parts begin.
pub const IMAGE: &str = "image ";
/// The same for its mask.
pub const MASK: &str = "mask ";
/// The same for its camera and pose.
pub const POSE: &str = "pose ";

/// What stands for the content of a file that cannot be read: it is skipped when its turn comes, and once it can be read
/// its key is another.
pub const UNREADABLE: &str = "unreadable";

/// What stands for the content of an image that does not fit under the limit: its frame is skipped, and once there is
/// memory for it its key is another.
pub const TOO_LARGE: &str = "too large";

/// The recipe parts of each frame: image, mask, pose.
struct Parts<'a> {
    frames: &'a [Frame],
    values: Vec<[Option<String>; 3]>,
}

impl Parts<'_> {
    fn of<'a>(pipeline: &Pipeline, frames: &'a [Frame]) -> Parts<'a> {
        Parts { frames, values: frames.par_iter().map(|frame| parts_of(pipeline, frame)).collect() }
    }

    /// The group of these frames, which lack nothing but `common`, the parts that all groups share. `left_out` says which
    /// of them are too large.
    fn group(&self, common: &Recipe, frames: Vec<FrameId>, left_out: impl Fn(FrameId) -> bool) -> Group {
        let add = |recipe: Recipe, &id: &FrameId| {
            let (name, values) = (&self.frames[id as usize].name, &self.values[id as usize]);
            let named = [IMAGE, MASK, POSE].iter().zip(values);
            named.fold(recipe, |recipe, (&part, value)| match value {
                Some(_) if part == IMAGE && left_out(id) => recipe.with(format!("{part}{name}"), TOO_LARGE),
                Some(value) => recipe.with(format!("{part}{name}"), value),
                None => recipe,
            })
        };
        Group { recipe: frames.iter().fold(common.clone(), add), frames }
    }

    /// The frame of this name.
    fn find(&self, name: &str) -> Option<FrameId> {
        self.frames.binary_search_by(|frame| frame.name.as_str().cmp(name)).ok().map(|id| id as FrameId)
    }
}

/// The frames that a unit of the map side was made of, by name.
pub fn frames_of(recipe: &Recipe) -> impl Iterator<Item = &str> {
    recipe.parts().filter_map(|(part, _)| part.strip_prefix(POSE))
}

/// The groups of a run's frames. Groups that are done stay as they are if none of their frames has changed; the frames
/// that are left are put into groups in the order of their names. So a frame that changes takes its group along and no
/// other, and a frame that is new takes none.
///
/// A frame that is too large under this limit (`fit`) is left out of a group that is still to be done, and its group is
/// done again under a limit that it fits. A group that has it already keeps it, whatever the limit is now. Without `fit`,
/// nothing is asked of frames that were left out.
pub fn groups(
    pipeline: &Pipeline,
    manifest: &Manifest,
    mesh: Key,
    frames: &[Frame],
    fit: Option<&Readable>,
) -> Vec<Group> {
    let parts = Parts::of(pipeline, frames);
    let common = settings(
        Recipe::new(FRAMES).with("scene.mesh", mesh).with("format", VERSION),
        [("decode", value_of(&pipeline.decode)), ("gather.shadow", value_of(&pipeline.gather.shadow))],
    );
    let mut free: BTreeSet<FrameId> = (0..frames.len() as FrameId).collect();
    let mut groups = Vec::new();
    for (unit, done) in manifest.of_kind(FRAMES) {
        let Some(ids) = frames_of(&done.recipe).map(|name| parts.find(name)).collect::<Option<Vec<_>>>() else {
            continue;
        };
        if !ids.is_empty() && ids.iter().all(|id| free.contains(id)) {
            let was = |id| done.recipe.part(&format!("{IMAGE}{}", frames[id as usize].name)) == Some(TOO_LARGE);
            let group = parts.group(&common, ids, |id| was(id) && fit.is_none_or(|fit| fit.is_too_large(id)));
            if group.recipe.unit() == unit {
                group.frames.iter().for_each(|id| {
                    free.remove(id);
                });
                groups.push(group);
            }
        }
    }
    let left: Vec<FrameId> = free.into_iter().collect();
    let too_large = |id| fit.is_some_and(|fit| fit.is_too_large(id));
    let new = |ids: &[FrameId]| parts.group(&common, ids.to_vec(), too_large);
    groups.extend(left.chunks(pipeline.gather.group as usize).map(new));
    groups.sort_unstable_by_key(|group| group.frames[0]);
    groups
}

fn parts_of(pipeline: &Pipeline, frame: &Frame) -> [Option<String>; 3] {
    let content = |path: &Path| match Key::of_file(path) {
        Ok(key) => key.to_string(),
        Err(_) => UNREADABLE.to_owned(),
    };
    let scene = &pipeline.scene;
    let mask = scene.masks.as_deref().and_then(|masks| image::mask_path(masks, &frame.name));
    // Debug output of floats has all their digits.
    let pose = Key::of_bytes(format!("{:?} {:?}", frame.camera, frame.pose).as_bytes());
    [Some(content(&scene.images.join(&frame.name))), mask.as_deref().map(content), Some(pose.to_string())]
}

/// Adds settings as parts, a section's keys one by one.
pub fn settings<'a>(recipe: Recipe, settings: impl IntoIterator<Item = (&'a str, Value)>) -> Recipe {
    settings.into_iter().fold(recipe, |recipe, (name, value)| match value {
        Value::Object(keys) => keys.into_iter().fold(recipe, |r, (key, value)| r.with(format!("{name}.{key}"), value)),
        value => recipe.with(name, value),
    })
}

/// A configuration as the text that stands in recipes.
pub fn value_of(config: &impl Serialize) -> Value {
    // What has no such text would be the same whatever it holds: configurations are plain values, which have one.
    serde_json::to_value(config).unwrap_or_default()
}

/// The groups that the manifest does not have.
pub fn to_do(manifest: &Manifest, groups: &[Group]) -> Vec<Group> {
    groups.iter().filter(|g| manifest.files(&g.recipe.unit()).is_none()).cloned().collect()
}

/// Forgets the units of a kind that this run is not made of, and removes their files.
pub fn forget_others<'a>(
    manifest: &mut Manifest,
    kind: &str,
    wanted: impl IntoIterator<Item = &'a Recipe>,
) -> Result<()> {
    let wanted: BTreeSet<String> = wanted.into_iter().map(Recipe::unit).collect();
    let stale = manifest.of_kind(kind).map(|(name, _)| name).filter(|name| !wanted.contains(*name));
    let stale: Vec<String> = stale.map(str::to_owned).collect();
    if stale.is_empty() { Ok(()) } else { manifest.forget(stale.iter().map(String::as_str)) }
}
