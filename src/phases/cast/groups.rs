//! The recipes of frame groups. A recipe is made of contents: bytes of files, settings that change a unit's bytes, the version
//! of its format; never of a time or a path. So a file with a new date alone changes no recipe, and a file with new contents
//! changes the recipes of what was made of it.

use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::frozen::{Frozen, Names};
use super::ingredients::{INPUTS, TOO_LARGE, UNREADABLE, ingredient};
use super::readable::Readable;
use crate::base::ids::FrameId;
use crate::base::key::Key;
use crate::base::{PhaseName, Result};
use crate::codec::images;
use crate::config::Effect;
use crate::disk::Recipe;
use crate::disk::{Content, Damage, Ledger, Store};
use crate::phases::cause::{FORMAT, FrameInput};
use crate::phases::scene::LoadedScene;
use crate::pipeline::Pipeline;
use crate::scene::frame::Frame;
use crate::shard::Segment;
use crate::shard::format::VERSION;
use crate::stages::gather::SEGMENT;

/// Frames whose observations become one unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Group {
    /// All that the unit's bytes depend on.
    pub recipe: Recipe,
    /// The group's frames, ascending.
    pub frames: Vec<FrameId>,
}

/// The frame groups of a scene: the list of their frames, and the recipe of each.
pub(crate) struct FrameGroups {
    list: Frozen,
    /// The frames of every group as planned: the list, with what it still lacks.
    planned: Vec<Names>,
    frames: Ingredients,
    groups: Vec<Group>,
}

impl FrameGroups {
    /// The groups for a run, which sets a damaged list aside.
    ///
    /// # Errors
    /// A list or a unit record that cannot be read.
    pub(crate) fn of_run(
        pipeline: &Pipeline,
        store: &Arc<dyn Store>,
        ledger: &Ledger,
        scene: &LoadedScene,
        readable: &Readable,
    ) -> Result<Self> {
        FrameGroups::with(pipeline, ledger, scene, Frozen::open(store, ledger)?, Some(readable))
    }

    /// The groups as a run would have them; nothing is changed. Without `readable`, frames that were left out stay so.
    ///
    /// # Errors
    /// A list or a unit record that cannot be read.
    pub(crate) fn read(
        pipeline: &Pipeline,
        store: &Arc<dyn Store>,
        ledger: &Ledger,
        scene: &LoadedScene,
        readable: Option<&Readable>,
    ) -> Result<Self> {
        FrameGroups::with(pipeline, ledger, scene, Frozen::read(store, ledger)?, readable)
    }

    fn with(
        pipeline: &Pipeline,
        ledger: &Ledger,
        scene: &LoadedScene,
        list: Frozen,
        readable: Option<&Readable>,
    ) -> Result<Self> {
        let planned = list.groups(&scene.frames, pipeline.gather.group);
        let frames = Ingredients::of(pipeline, &scene.frames, readable);
        let groups = frames.groups(pipeline, ledger, scene, &planned)?;
        Ok(FrameGroups { list, planned, frames, groups })
    }

    /// The groups that have any frame, each with the recipe that it has now.
    pub(crate) fn all(&self) -> &[Group] {
        &self.groups
    }

    /// What was wrong with the list, if anything was.
    pub(crate) fn damage(&self) -> Option<&Damage> {
        self.list.damage()
    }

    /// Freezes the groups as planned. Where another process froze others first, those are the groups.
    ///
    /// # Errors
    /// A list that cannot be written, a unit record that cannot be read.
    pub(super) fn freeze(&mut self, pipeline: &Pipeline, ledger: &Ledger, scene: &LoadedScene) -> Result<()> {
        let frozen = self.list.freeze(&scene.frames, pipeline.gather.group)?;
        if frozen != self.planned {
            self.groups = self.frames.groups(pipeline, ledger, scene, &frozen)?;
            self.planned = frozen;
        }
        Ok(())
    }
}

/// The ingredients of every frame.
struct Ingredients {
    /// Contents of image, mask and pose, where there are any.
    contents: Vec<[Option<String>; INPUTS.len()]>,
    /// Whether each frame is too large under this limit; `None` where nobody asks, and frames that were left out stay so.
    too_large: Option<Vec<bool>>,
}

impl Ingredients {
    fn of(pipeline: &Pipeline, frames: &[Frame], readable: Option<&Readable>) -> Self {
        let too_large =
            readable.map(|readable| FrameId::all(frames.len()).map(|id| readable.is_too_large(id)).collect());
        Ingredients { contents: frames.par_iter().map(|frame| contents(pipeline, frame)).collect(), too_large }
    }

    fn is_too_large(&self, frame: FrameId) -> bool {
        self.too_large.as_ref().is_some_and(|too_large| too_large[frame.index()])
    }

    /// The recipe of these frames beside what all groups have in `common`. `left_out` says which of them are too large.
    fn recipe(&self, common: Recipe, all: &[Frame], some: &[FrameId], left_out: impl Fn(FrameId) -> bool) -> Recipe {
        let add = |recipe: Recipe, &id: &FrameId| {
            let (name, contents) = (&all[id.index()].name, &self.contents[id.index()]);
            INPUTS.iter().zip(contents).fold(recipe, |recipe, (&(input, _), content)| match content {
                Some(_) if input == FrameInput::Image && left_out(id) => {
                    recipe.with(ingredient(input, name), TOO_LARGE)
                }
                Some(content) => recipe.with(ingredient(input, name), content),
                None => recipe,
            })
        };
        some.iter().fold(common, add)
    }

    /// The groups of these frames, each with the recipe that it has now; groups without any posed frame are left out.
    ///
    /// A frame that is too large under this limit is left out of a group that is still to be done, and its group is done over
    /// under a limit that it fits. A group that has it already keeps it, whatever the limit is now.
    fn groups(&self, pipeline: &Pipeline, ledger: &Ledger, scene: &LoadedScene, list: &[Names]) -> Result<Vec<Group>> {
        let all = &scene.frames;
        let mut groups = Vec::new();
        for (number, names) in list.iter().enumerate() {
            let frames = posed(all, names);
            if frames.is_empty() {
                continue;
            }
            let common = || {
                Recipe::new(PhaseName::Cast, number.to_string())
                    .with("scene.mesh", scene.mesh_key)
                    .with(FORMAT, VERSION)
                    .with_all(pipeline.ingredients(Effect::Cast))
            };
            let mut recipe = self.recipe(common(), all, &frames, |id| self.is_too_large(id));
            if !ledger.is_done(&recipe.unit()) {
                for done in ledger.find(PhaseName::Cast, &number.to_string()) {
                    let done = ledger.recipe(&done)?;
                    let still_left_out = |id: FrameId| {
                        let name = ingredient(FrameInput::Image, &all[id.index()].name);
                        done.ingredient(&name) == Some(TOO_LARGE) && (self.too_large.is_none() || self.is_too_large(id))
                    };
                    let kept = self.recipe(common(), all, &frames, still_left_out);
                    if kept == done {
                        recipe = kept;
                    }
                }
            }
            groups.push(Group { recipe, frames });
        }
        Ok(groups)
    }
}

/// The frames of these names that are posed now, ascending.
fn posed(all: &[Frame], names: &Names) -> Vec<FrameId> {
    let find = |name: &str| all.binary_search_by(|frame| frame.name.as_str().cmp(name)).ok();
    let mut ids: Vec<FrameId> = names.frames().filter_map(find).map(FrameId::at).collect();
    ids.sort_unstable();
    ids
}

fn contents(pipeline: &Pipeline, frame: &Frame) -> [Option<String>; INPUTS.len()] {
    let content = |path: &Path| match Key::of_file(path) {
        Ok(key) => key.to_string(),
        Err(_) => UNREADABLE.to_owned(),
    };
    let scene = &pipeline.scene;
    let mask = scene.masks.as_deref().and_then(|masks| images::mask_path(masks, &frame.name));
    // Debug output of floats has all their digits.
    let pose = Key::of_bytes(format!("{:?} {:?}", frame.camera, frame.pose).as_bytes());
    [Some(content(&scene.images.join(&frame.name))), mask.as_deref().map(content), Some(pose.to_string())]
}

/// Opens the segments of these groups, as far as they are done.
///
/// # Errors
/// A segment that cannot be read.
pub(crate) fn opened_segments(store: &dyn Store, ledger: &Ledger, groups: &[Group]) -> Result<Vec<Segment<Content>>> {
    let mut segments = Vec::new();
    for files in groups.iter().filter_map(|group| ledger.files(&group.recipe.unit())) {
        for file in files.iter().filter(|file| file.name.ends_with(SEGMENT)) {
            segments.push(Segment::open(store.open(&file.name)?, &store.path(&file.name))?);
        }
    }
    Ok(segments)
}
