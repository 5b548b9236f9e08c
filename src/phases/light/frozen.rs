//! What was found of exposures and light, frozen: a list that is only ever added to. What is known stays as it is when frames come,
//! go or change, so that nothing has to be done over but what was made of them. "Anew" in the list ends what was known before it.
//!
//! The list is `light/*.json`. What it lost is found again, from the sightings.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::found::{FoundLight, Gain, Looked, Moved, camera_of};
use crate::base::ids::TriangleId;
use crate::base::key::{Key, KeyBuilder};
use crate::base::{Error, Result};
use crate::config::Effect;
use crate::disk::Store;
use crate::disk::frozen::{self, Damage};
use crate::phases::report::LightReport;
use crate::pipeline::Pipeline;
use crate::scene::cells::LIGHTS;
use crate::scene::frame::Frame;
use crate::scene::vignetting::Vignetting;

/// The folder of the list in a run's store.
const FOLDER: &str = "light";

/// The version of how gains and light are found. Another version finds them anew.
pub(super) const VERSION: u32 = 2;

/// An entry of the list.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Entry {
    /// What was found before is to be found anew.
    Anew,
    /// The triangles that are looked at.
    Sample {
        /// The key of their mesh's file.
        mesh: Key,
        /// The triangles, ascending.
        triangles: Vec<u32>,
    },
    /// What was found of the sightings.
    Looked(Box<Looked>),
}

/// What is known of exposures and light, under the configuration as it is.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct State {
    sample: Option<Arc<[TriangleId]>>,
    /// The gains by the names of their frames.
    pub gains: BTreeMap<String, Gain>,
    /// Frames that nothing ties to the others.
    pub untied: Vec<String>,
    /// The spread of what the gains leave.
    pub residual: f32,
    /// How much darker cameras are towards their corners, by the size of their images.
    pub vignetting: BTreeMap<String, Vignetting>,
    /// The correlation of the gains with the exposures that the photographs tell, where they do.
    pub exif: Option<f32>,
    /// The positions of the lights that frames were taken in, by their names; none where all were taken in one.
    pub taken_in: BTreeMap<String, usize>,
    /// The light.
    pub light: Option<FoundLight>,
    /// That it would be found elsewhere now.
    pub moved: Option<Moved>,
    /// The sightings that this is of.
    pub sightings: Option<Key>,
}

/// The list, and what it says.
pub(crate) struct FrozenLight {
    list: frozen::Frozen<Entry>,
    damage: Option<Damage>,
    mesh: Key,
    gains_under: Key,
    light_under: Key,
    state: State,
}

/// Ends what is known of exposures and light in a store: the next run finds it anew.
///
/// # Errors
/// A list that cannot be written.
pub(crate) fn end_light(store: &Arc<dyn Store>) -> Result<()> {
    let (mut list, _) = frozen::Frozen::open(Arc::clone(store), FOLDER)?;
    while !matches!(list.items().last(), None | Some(Entry::Anew)) {
        list.add(vec![Entry::Anew])?;
    }
    Ok(())
}

impl State {
    /// How much darker a frame is towards its corners.
    pub(crate) fn vignetting_of(&self, frame: &Frame) -> Vignetting {
        self.vignetting.get(&camera_of(frame)).copied().unwrap_or(Vignetting::NONE)
    }

    /// The position of the light that a frame was taken in.
    pub(crate) fn light_of(&self, frame: &str) -> usize {
        self.taken_in.get(frame).map_or(0, |light| (*light).min(LIGHTS - 1))
    }

    /// What a report says of it.
    pub(super) fn report(&self) -> LightReport {
        let gains = || self.gains.values().map(|gain| gain.log.exp());
        let told = LightReport {
            moved: self.moved.as_ref().map(|moved| moved.words.clone()),
            gains: self.gains.len() as u64,
            gain_range: [gains().reduce(f32::min).unwrap_or(1.0), gains().reduce(f32::max).unwrap_or(1.0)],
            untied: self.untied.clone(),
            exif: self.exif,
            corners: self
                .vignetting
                .values()
                .map(|lens| 1.0 - lens.at(1.0))
                .reduce(f32::max)
                .filter(|lost| *lost > 0.0),
            ..LightReport::default()
        };
        let Some(light) = &self.light else { return told };
        let FoundLight { sun_degrees, color, sky, white, turned, .. } = *light;
        let sun = light.told_sun();
        LightReport { sun, sun_degrees, color, sky, white, turned, words: light.words.clone(), ..told }
    }
}

impl FrozenLight {
    /// Reads the list and changes nothing.
    ///
    /// # Errors
    /// A store that fails.
    pub(crate) fn read(store: &Arc<dyn Store>, pipeline: &Pipeline, mesh: Key) -> Result<Self> {
        let (list, damage) = frozen::Frozen::read(Arc::clone(store), FOLDER)?;
        Ok(FrozenLight::with(list, damage, pipeline, mesh))
    }

    /// Reads the list for a run, which sets a damaged page aside.
    ///
    /// # Errors
    /// A store that fails.
    pub(crate) fn open(store: &Arc<dyn Store>, pipeline: &Pipeline, mesh: Key) -> Result<Self> {
        let (list, damage) = frozen::Frozen::open(Arc::clone(store), FOLDER)?;
        Ok(FrozenLight::with(list, damage, pipeline, mesh))
    }

    /// What is wrong with the list of a store, which had at least so many entries, if anything is.
    ///
    /// # Errors
    /// A store that fails.
    pub(super) fn rotten(store: &Arc<dyn Store>, entries: usize) -> Result<Option<Damage>> {
        let (list, damage) = frozen::Frozen::<Entry>::read(Arc::clone(store), FOLDER)?;
        let lost = || {
            let why = "it is not there, but what was made of it is".to_owned();
            (list.items().len() < entries).then(|| Damage { page: list.next_page(), why, kept: Vec::new() })
        };
        Ok(damage.or_else(lost))
    }

    /// The number of entries.
    pub(super) fn entries(&self) -> usize {
        self.list.items().len()
    }

    fn with(list: frozen::Frozen<Entry>, damage: Option<Damage>, pipeline: &Pipeline, mesh: Key) -> Self {
        let key = |domain: &str, effects: &[Effect]| {
            let settings = effects.iter().flat_map(|effect| pipeline.ingredients(*effect));
            let start = KeyBuilder::new(domain).field(&VERSION.to_le_bytes()).field(mesh.to_string().as_bytes());
            settings.fold(start, |key, (name, value)| key.field(name.as_bytes()).field(value.as_bytes())).finish()
        };
        let exposure = pipeline.ingredients(Effect::Look).filter(|(name, _)| name == "decode.exposure");
        let gains_under = exposure.fold(key("gonio gains 1", &[Effect::Cast]), |under, (_, value)| {
            KeyBuilder::new("gonio gains 1").field(under.to_string().as_bytes()).field(value.as_bytes()).finish()
        });
        let light_under = key("gonio light 1", &[Effect::Cast, Effect::Look]);
        let mut frozen = FrozenLight { list, damage, mesh, gains_under, light_under, state: State::default() };
        frozen.state = frozen.sum_up();
        frozen
    }

    /// What the list says under the configuration as it is.
    fn sum_up(&self) -> State {
        let mut state = State::default();
        for entry in self.list.items() {
            match entry {
                Entry::Anew => state = State::default(),
                Entry::Sample { mesh, triangles } if *mesh == self.mesh => {
                    state = State::default();
                    state.sample = Some(triangles.iter().map(|&t| TriangleId(t)).collect());
                }
                Entry::Looked(looked) if looked.gains_under == self.gains_under => {
                    state.gains.extend(looked.gains.iter().map(|(name, gain)| (name.clone(), gain.clone())));
                    state.vignetting.extend(looked.vignetting.iter().map(|(camera, found)| (camera.clone(), *found)));
                    (state.untied, state.residual, state.exif) = (looked.untied.clone(), looked.residual, looked.exif);
                    state.sightings = None;
                    if looked.light_under == self.light_under {
                        state.light = looked.light.clone().or(state.light);
                        state.taken_in.extend(looked.taken_in.iter().map(|(name, light)| (name.clone(), *light)));
                        (state.moved, state.sightings) = (looked.moved.clone(), Some(looked.sightings));
                    }
                }
                Entry::Sample { .. } | Entry::Looked(_) => {}
            }
        }
        state
    }

    /// What was wrong with the list, if anything was.
    pub(crate) fn damage(&self) -> Option<&Damage> {
        self.damage.as_ref()
    }

    /// What is known.
    pub(crate) fn state(&self) -> &State {
        &self.state
    }

    /// The triangles that are looked at; none where they have not been chosen.
    pub(crate) fn sample(&self) -> Arc<[TriangleId]> {
        self.state.sample.clone().unwrap_or_default()
    }

    /// What stands in recipes for the triangles that are looked at.
    pub(crate) fn sample_key(&self) -> String {
        let Some(sample) = &self.state.sample else { return "not chosen".to_owned() };
        sample
            .iter()
            .fold(KeyBuilder::new("gonio sample 1"), |key, t| key.field(&t.0.to_le_bytes()))
            .finish()
            .to_string()
    }

    /// What stands in a recipe for all that is known of these sightings.
    pub(super) fn key(&self, sightings: Key) -> Option<Key> {
        let State { sample: _, gains, untied, residual, vignetting, exif, taken_in, light, moved, sightings: of } =
            &self.state;
        let all = serde_json::to_vec(&(gains, untied, residual, vignetting, exif, taken_in, light, moved))
            .unwrap_or_default();
        (*of == Some(sightings)).then(|| Key::of_bytes(&all))
    }

    /// The key of the light, in the recipes of what it lights.
    pub(crate) fn light_key(&self) -> Option<Key> {
        let of = |FoundLight { sun, color, sky, bounce, sun_degrees, ratio, .. }: &FoundLight| {
            format!("{sun:?} {color:?} {sky:?} {bounce:?} {sun_degrees:?} {ratio:?}")
        };
        let all: Vec<String> = self.state.light.as_ref()?.all().map(of).collect();
        Some(Key::of_bytes(all.join("; ").as_bytes()))
    }

    /// Freezes the triangles that are looked at, unless they are.
    ///
    /// # Errors
    /// A list that cannot be written.
    pub(crate) fn freeze_sample(&mut self, choose: impl Fn() -> Vec<TriangleId>) -> Result<()> {
        while self.state.sample.is_none() {
            let triangles = choose().into_iter().map(|t| t.0).collect();
            self.add(Entry::Sample { mesh: self.mesh, triangles })?;
        }
        Ok(())
    }

    /// Freezes what was found of sightings, which `find` answers given what is known. Another process may have been first.
    ///
    /// # Errors
    /// What `find` says; a list that cannot be written.
    pub(super) fn freeze(&mut self, sightings: Key, find: impl Fn(&State) -> Result<Looked>) -> Result<()> {
        while self.state.sightings != Some(sightings) {
            let looked = find(&self.state)?;
            let (gains_under, light_under) = (self.gains_under, self.light_under);
            self.add(Entry::Looked(Looked { gains_under, light_under, sightings, ..looked }.into()))?;
        }
        Ok(())
    }

    /// Adds an entry as it will be read again, to the last digit.
    fn add(&mut self, entry: Entry) -> Result<()> {
        let failed =
            |why: serde_json::Error| Error::invalid(format!("what was found of the light cannot be kept: {why}"));
        let written = serde_json::to_vec(&entry).map_err(failed)?;
        self.list.add(vec![serde_json::from_slice(&written).map_err(failed)?])?;
        self.state = self.sum_up();
        Ok(())
    }
}
