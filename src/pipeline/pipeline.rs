//! A pipeline file, checked.

use std::path::{Path, PathBuf};

use super::run::Run;
use super::scene::Scene;
use super::synth::{MESH, Synth};
use crate::base::{Error, Result};
use crate::config::{Effect, Section, Setting, real};
use crate::stages::{cast, decode, export, gather, infer, light, merge};
use crate::synth::city;

/// A pipeline file, checked: values are in range, paths are resolved, inputs were there.
#[derive(Debug, Clone, PartialEq)]
pub struct Pipeline {
    /// The pipeline file's path.
    pub file: PathBuf,
    /// What makes the inputs on the first run, if anything does.
    pub synth: Option<Synth>,
    /// The inputs.
    pub scene: Scene,
    /// How images become radiance.
    pub decode: decode::Config,
    /// How radiance becomes observations.
    pub cast: cast::Config,
    /// How observations become segments.
    pub gather: gather::Config,
    /// How maps become materials.
    pub infer: infer::Config,
    /// How materials become tables.
    pub merge: merge::Config,
    /// What is known of the light.
    pub light: light::Config,
    /// The files for other programs.
    pub export: export::Config,
    /// Where and with how much a run runs.
    pub run: Run,
}

impl Pipeline {
    /// Whether the scene is there. It is not while `[synth]` has yet to make it, or to finish it.
    pub fn is_made(&self) -> bool {
        let is_here = |synth: &Synth| self.scene.mesh == synth.into.join(MESH).into();
        self.synth.as_ref().filter(|synth| is_here(synth)).is_none_or(|s| city::is_finished(&s.into, &s.city))
    }

    /// Refuses a place for something that a command writes, if one of the pipeline's inputs lies there.
    ///
    /// # Errors
    /// The place is an input, or in a folder of inputs.
    pub(crate) fn may_write(&self, out: &Path) -> Result<()> {
        let Scene { mesh, images, poses, masks, .. } = &self.scene;
        let model = if let infer::Model::File(model) = &self.infer.model { Some(model) } else { None };
        // A mesh may have several files.
        let parts = mesh.files().unwrap_or_default();
        let inputs = [&self.file, images, &poses.path].into_iter().chain(masks).chain(model).chain(&parts);
        let place = real(out);
        match inputs.into_iter().find(|input| place.starts_with(real(input))) {
            None => Ok(()),
            Some(input) => Err(Error::invalid(format!(
                "{} lies where an input of the pipeline is ({}), which is never written to: name another file",
                out.display(),
                input.display()
            ))),
        }
    }

    /// Whether the exposure of each frame is found.
    pub fn solves_exposure(&self) -> bool {
        self.decode.exposure == decode::Exposure::Solve
    }

    /// Whether the light is found in the photographs, all of it or all but the sun's direction.
    pub fn estimates_light(&self) -> bool {
        self.light.mode.is_looked_for()
    }

    /// Whether frames are looked at before they are cast, to find exposures or the light.
    pub fn is_looked_at(&self) -> bool {
        self.solves_exposure() || self.estimates_light()
    }

    /// Every setting of every section.
    pub fn all_settings(&self) -> Vec<Setting> {
        let Pipeline { file: _, synth, scene, decode, cast, gather, infer, merge, light, export, run } = self;
        let mut all: Vec<Setting> = synth.iter().flat_map(Section::settings).collect();
        all.extend(scene.settings());
        all.extend(decode.settings());
        all.extend(cast.settings());
        all.extend(gather.settings());
        all.extend(infer.settings());
        all.extend(merge.settings());
        all.extend(light.settings());
        all.extend(export.settings());
        all.extend(run.settings());
        all
    }

    /// The settings of one effect, as ingredients of a recipe.
    pub fn ingredients(&self, effect: Effect) -> impl Iterator<Item = (String, String)> {
        let ingredient = move |Setting { key, value, effect: of }| (of == effect).then_some((key, value));
        self.all_settings().into_iter().filter_map(ingredient)
    }
}
