//! The recipes of frame groups. A recipe is made of contents: bytes of files, settings that change a unit's bytes, the version
//! of its format; never of a time or a path. So a file with a new date alone changes no recipe, and a file with new contents
//! changes the recipes of what was made of it.

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

use glam::Vec3;
use rayon::prelude::*;

use super::frozen::{Frozen, Names};
use super::ingredients::{TOO_LARGE, contents, image_in, ingredient, with_contents, with_pose};
use super::readable::Readable;
use crate::base::ids::FrameId;
use crate::base::patience::Patience;
use crate::base::{PhaseName, Result};
use crate::config::Effect;
use crate::disk::{self, Damage, Ledger, Recipe, Store, UnitName};
use crate::phases::cause::{FORMAT, FrameInput};
use crate::phases::light::{FrozenLight, suns_of};
use crate::phases::scene::LoadedScene;
use crate::phases::units::Unit;
use crate::pipeline::Pipeline;
use crate::scene::frame::Frame;
use crate::scene::vignetting::Vignetting;
use crate::shard::Segment;
use crate::shard::format::VERSION;
use crate::stages::cast::Conditions;
use crate::stages::decode::{Content, Contents};
use crate::stages::gather::{GroupFrames, SEGMENT};
use crate::stages::look;

/// Frames whose observations become one unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Group {
    /// All that the unit's bytes depend on. Before the group is done, its files may have other contents, or not be looked at.
    pub recipe: Recipe,
    /// The group's frames, ascending.
    pub frames: Vec<FrameId>,
}

/// The frame groups of a scene: the list of their frames, and the recipes of each.
pub(crate) struct FrameGroups {
    list: Frozen,
    /// The frames of every group as planned: the list, with what it still lacks.
    planned: Vec<Names>,
    frames: Ingredients,
    /// As units of casting.
    groups: Vec<Group>,
    /// As units of looking.
    looks: Vec<Group>,
    /// How each frame was taken, as far as it is known for the image that is there.
    taken: Vec<TakenIn>,
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
        light: &FrozenLight,
    ) -> Result<Self> {
        FrameGroups::with(pipeline, ledger, scene, Frozen::open(store, ledger)?, Some(readable), light)
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
        light: &FrozenLight,
    ) -> Result<Self> {
        FrameGroups::with(pipeline, ledger, scene, Frozen::read(store, ledger)?, readable, light)
    }

    fn with(
        pipeline: &Pipeline,
        ledger: &Ledger,
        scene: &LoadedScene,
        list: Frozen,
        readable: Option<&Readable>,
        light: &FrozenLight,
    ) -> Result<Self> {
        let planned = list.groups(&scene.frames, pipeline.gather.group);
        let frames = Ingredients::of(&scene.frames, readable);
        let (groups, looks, taken) = Default::default();
        let mut all = FrameGroups { list, planned, frames, groups, looks, taken };
        all.look(pipeline, ledger, scene, light)?;
        all.cast(pipeline, ledger, scene, light)?;
        Ok(all)
    }

    /// The groups that have any frame, as units of casting, each with the recipe that it has now.
    pub(crate) fn all(&self) -> &[Group] {
        &self.groups
    }

    /// The same groups as units of looking; none where nothing is to be found by that.
    pub(crate) fn looks(&self) -> &[Group] {
        &self.looks
    }

    /// How each frame was taken.
    pub(crate) fn conditions(&self) -> Vec<Conditions> {
        let of = |TakenIn { gain, vignetting, light }: &TakenIn| Conditions {
            gain: gain.map_or(1.0, f32::exp),
            vignetting: *vignetting,
            light: *light,
        };
        self.taken.iter().map(of).collect()
    }

    /// Gives the units of looking the recipes that they have now.
    fn look(&mut self, pipeline: &Pipeline, ledger: &Ledger, scene: &LoadedScene, light: &FrozenLight) -> Result<()> {
        if !pipeline.is_looked_at() {
            self.looks.clear();
            return Ok(());
        }
        let recipe = Recipe::new(PhaseName::Look, "")
            .with("scene.mesh", scene.mesh_key)
            .with(FORMAT, look::VERSION)
            .with(PhaseName::Look.as_str(), light.sample_key())
            .with_all(pipeline.ingredients(Effect::Cast));
        let common = Common { recipe, taken: &|_| TakenIn::default() };
        self.looks = self.frames.groups(pipeline, ledger, scene, &self.planned, &common)?;
        Ok(())
    }

    /// Gives the units of casting the recipes that they have now, with the gains and the suns that are known now.
    ///
    /// # Errors
    /// A unit record that cannot be read.
    pub(super) fn cast(
        &mut self,
        pipeline: &Pipeline,
        ledger: &Ledger,
        scene: &LoadedScene,
        light: &FrozenLight,
    ) -> Result<()> {
        let sun = if pipeline.estimates_light() { PhaseName::Light.as_str() } else { "light.sun" };
        let suns = in_recipe(&suns_of(pipeline, light));
        let recipe = Recipe::new(PhaseName::Cast, "")
            .with("scene.mesh", scene.mesh_key)
            .with(FORMAT, VERSION)
            .with_or_without(sun, suns)
            .with_all(pipeline.ingredients(Effect::Cast));
        self.taken = vec![TakenIn::default(); scene.frames.len()];
        for group in &self.looks {
            for id in &group.frames {
                let name = &scene.frames[id.index()].name;
                let gain = light.state().gains.get(name).filter(|gain| gain.image == image_in(&group.recipe, name));
                let (gain, state) = (gain.map(|gain| gain.log), light.state());
                let (vignetting, light) = (state.vignetting_of(&scene.frames[id.index()]), state.light_of(name));
                self.taken[id.index()] = TakenIn { gain, vignetting, light };
            }
        }
        let taken = &self.taken;
        let common = Common { recipe, taken: &|id| taken[id.index()] };
        self.groups = self.frames.groups(pipeline, ledger, scene, &self.planned, &common)?;
        Ok(())
    }

    /// What was wrong with the list, if anything was.
    pub(crate) fn damage(&self) -> Option<&Damage> {
        self.list.damage()
    }

    /// Gives groups that were done the recipes of what was read, in place of what they had before.
    pub(crate) fn settle(&mut self, read: &BTreeMap<UnitName, Recipe>) {
        for group in self.groups.iter_mut().chain(&mut self.looks) {
            if let Some(recipe) = read.get(&group.recipe.unit()) {
                group.recipe.clone_from(recipe);
            }
        }
    }

    /// Freezes the groups as planned. Where another process froze others first, those are the groups.
    ///
    /// # Errors
    /// A list that cannot be written, a unit record that cannot be read.
    pub(crate) fn freeze(
        &mut self,
        pipeline: &Pipeline,
        ledger: &Ledger,
        scene: &LoadedScene,
        light: &FrozenLight,
    ) -> Result<()> {
        self.planned = self.list.freeze(&scene.frames, pipeline.gather.group)?;
        self.look(pipeline, ledger, scene, light)
    }
}

impl Group {
    /// The group as a unit.
    pub(crate) fn unit(&self) -> Unit {
        Unit::new(self.recipe.clone()).weighing(self.frames.len() as u64)
    }

    /// The groups that these units are, as stages take them.
    pub(crate) fn of_units(groups: &[Group], units: &[Unit]) -> Vec<GroupFrames> {
        let find = |unit: &Unit| groups.iter().find(|group| group.recipe == unit.recipe);
        let taken = |group: &Group| GroupFrames { recipe: group.recipe.clone(), frames: group.frames.clone() };
        units.iter().filter_map(find).map(taken).collect()
    }

    /// The recipe of the group once these contents of its frames' files were read.
    pub(super) fn read(recipe: &Recipe, all: &[Frame], contents: &[(FrameId, Contents)]) -> Recipe {
        contents.iter().fold(recipe.clone(), |recipe, (id, contents)| with_contents(recipe, &all[id.index()], contents))
    }
}

/// How a frame was taken, as far as it is known.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct TakenIn {
    /// The logarithm of its gain.
    gain: Option<f32>,
    /// How much darker it is towards its corners.
    vignetting: Vignetting,
    /// The position of its light.
    light: usize,
}

/// What stands for the suns in a recipe: nothing where none shines.
fn in_recipe(suns: &[Option<Vec3>]) -> Option<String> {
    let sun = |sun: &Option<Vec3>| sun.map_or_else(|| "none".to_owned(), |sun| sun.to_string());
    suns.iter().any(Option::is_some).then(|| suns.iter().map(sun).collect::<Vec<_>>().join("; "))
}

/// What the recipes of all groups of a phase have in common.
struct Common<'a> {
    /// The recipe of a group without frames and number.
    recipe: Recipe,
    /// How a frame was taken, where the group's unit depends on it.
    taken: &'a dyn Fn(FrameId) -> TakenIn,
}

impl Common<'_> {
    fn phase(&self) -> PhaseName {
        self.recipe.phase()
    }

    /// The recipe of a group of these frames, but for their files.
    fn of(&self, number: &str, all: &[Frame], frames: &[FrameId]) -> Recipe {
        let ingredients = self.recipe.ingredients().map(|(name, value)| (name.to_owned(), value.to_owned()));
        let start = Recipe::new(self.phase(), number).with_all(ingredients);
        frames.iter().fold(start, |recipe, &id| {
            let frame = &all[id.index()];
            let TakenIn { gain, vignetting: Vignetting { second, fourth }, light } = (self.taken)(id);
            let gain = match (gain, second != 0.0 || fourth != 0.0) {
                (gain, false) => gain.map(|gain| gain.to_string()),
                (gain, true) => Some(format!("{} {second} {fourth}", gain.unwrap_or(0.0))),
            };
            with_pose(recipe, frame)
                .with_or_without(ingredient(FrameInput::Gain, &frame.name), gain)
                .with_or_without(ingredient(FrameInput::Light, &frame.name), (light > 0).then_some(light))
        })
    }
}

/// What the recipe of a group begins with.
struct Start<'a> {
    /// The recipe without the contents of files.
    recipe: Recipe,
    /// The units of the group that are done, whatever they are made of. Before there are any, files are not looked at.
    done: &'a [UnitName],
}

/// The ingredients of every frame, found when they are asked for.
struct Ingredients {
    contents: Vec<OnceLock<Contents>>,
    patience: Patience,
    /// Whether each frame is too large under this limit; `None` where nobody asks, and frames that were left out stay so.
    too_large: Option<Vec<bool>>,
}

impl Ingredients {
    fn of(frames: &[Frame], readable: Option<&Readable>) -> Self {
        let too_large =
            readable.map(|readable| FrameId::all(frames.len()).map(|id| readable.is_too_large(id)).collect());
        let contents = frames.iter().map(|_| OnceLock::new()).collect();
        Ingredients { contents, patience: Patience::default(), too_large }
    }

    fn is_too_large(&self, frame: FrameId) -> bool {
        self.too_large.as_ref().is_some_and(|too_large| too_large[frame.index()])
    }

    /// Finds the contents of these frames, many at once.
    fn find(&self, pipeline: &Pipeline, all: &[Frame], some: &[FrameId]) {
        some.par_iter().for_each(|id| {
            self.contents[id.index()].get_or_init(|| contents(pipeline, &all[id.index()], &self.patience));
        });
    }

    /// A recipe with the files of these frames, as far as the unit is begun. `left_out` says which of them are too large.
    fn recipe(&self, start: &Start<'_>, all: &[Frame], some: &[FrameId], left_out: impl Fn(FrameId) -> bool) -> Recipe {
        some.iter().fold(start.recipe.clone(), |recipe, &id| {
            let too_large = Contents::without(Content::TooLarge);
            let found = || self.contents[id.index()].get().filter(|_| !start.done.is_empty());
            let contents = if left_out(id) { Some(&too_large) } else { found() };
            contents.map_or(recipe.clone(), |contents| with_contents(recipe, &all[id.index()], contents))
        })
    }

    /// The groups of these frames, each with the recipe that it has now; groups without any posed frame are left out.
    ///
    /// The files of a group of which nothing is done are not looked at: what they hold is known once they are read. A frame
    /// that is too large under this limit is left out of a group that is still to be done, and its group is done over under a
    /// limit that it fits. A group that has it already keeps it, whatever the limit is now.
    fn groups(
        &self,
        pipeline: &Pipeline,
        ledger: &Ledger,
        scene: &LoadedScene,
        list: &[Names],
        common: &Common<'_>,
    ) -> Result<Vec<Group>> {
        let all = &scene.frames;
        let groups = list.iter().enumerate().map(|(number, names)| (number.to_string(), posed(all, names)));
        let groups: Vec<(String, Vec<FrameId>)> = groups.filter(|(_, frames)| !frames.is_empty()).collect();
        let begun = groups.iter().filter(|(number, _)| !ledger.find(common.phase(), number).is_empty());
        let begun: Vec<FrameId> = begun.flat_map(|(_, frames)| frames).copied().collect();
        self.find(pipeline, all, &begun);
        groups.into_iter().map(|(number, frames)| self.group(ledger, all, common, &number, frames)).collect()
    }

    fn group(
        &self,
        ledger: &Ledger,
        all: &[Frame],
        common: &Common<'_>,
        number: &str,
        frames: Vec<FrameId>,
    ) -> Result<Group> {
        let done = ledger.find(common.phase(), number);
        let start = Start { recipe: common.of(number, all, &frames), done: &done };
        let mut recipe = self.recipe(&start, all, &frames, |id| self.is_too_large(id));
        if !ledger.is_done(&recipe.unit()) {
            for done in &done {
                let done = ledger.recipe(done)?;
                let still_left_out = |id: FrameId| {
                    let name = ingredient(FrameInput::Image, &all[id.index()].name);
                    done.ingredient(&name) == Some(TOO_LARGE) && (self.too_large.is_none() || self.is_too_large(id))
                };
                let kept = self.recipe(&start, all, &frames, still_left_out);
                if kept == done {
                    recipe = kept;
                }
            }
        }
        Ok(Group { recipe, frames })
    }
}

/// The frames of these names that are posed now, ascending.
fn posed(all: &[Frame], names: &Names) -> Vec<FrameId> {
    let find = |name: &str| all.binary_search_by(|frame| frame.name.as_str().cmp(name)).ok();
    let mut ids: Vec<FrameId> = names.frames().filter_map(find).map(FrameId::at).collect();
    ids.sort_unstable();
    ids
}

/// Opens the segments of these groups, as far as they are done.
///
/// # Errors
/// A segment that cannot be read.
pub(crate) fn opened_segments(
    store: &dyn Store,
    ledger: &Ledger,
    groups: &[Group],
) -> Result<Vec<Segment<disk::Content>>> {
    let mut segments = Vec::new();
    for files in groups.iter().filter_map(|group| ledger.files(&group.recipe.unit())) {
        for file in files.iter().filter(|file| file.name.ends_with(SEGMENT)) {
            segments.push(Segment::open(store.open(&file.name)?, &store.path(&file.name))?);
        }
    }
    Ok(segments)
}
