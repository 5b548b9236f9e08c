//! Gains and light of what all frames saw, beside what is known of them.

use std::collections::BTreeMap;

use super::ephemeris::under;
use super::found::{FoundLight, Gain, Looked};
use super::frozen::State;
use super::occasion::Occasion;
use crate::base::ids::TriangleId;
use crate::base::key::Key;
use crate::light::{self, Clues, Gains, Settings, Sighting};
use crate::phases::scene::LoadedScene;
use crate::pipeline::Pipeline;
use crate::scene::frame::Frame;

/// What gains and light are found of.
pub(super) struct Evidence<'a> {
    /// The pipeline.
    pub pipeline: &'a Pipeline,
    /// The scene.
    pub scene: &'a LoadedScene,
    /// The triangles that were looked at.
    pub sample: &'a [TriangleId],
    /// What the frames saw of them.
    pub sightings: &'a [Sighting],
    /// When and where the photographs were taken, where that tells the sun.
    pub occasion: Option<Occasion>,
    /// The content of every frame's image, as recipes have it; empty where it was not read.
    pub images: &'a [String],
}

impl Evidence<'_> {
    /// What is found beside what is known. It depends on the evidence alone, not on the number of threads.
    pub(super) fn looked(&self, known: &State) -> Looked {
        let frames = &self.scene.frames;
        let gains = self.gains(known);
        let named = || frames.iter().zip(self.images).zip(&gains.log);
        let is_known = |frame: &Frame, image: &String| known.gains.get(&frame.name).is_some_and(|g| g.image == *image);
        let new: BTreeMap<String, Gain> = named()
            .filter(|((frame, image), _)| self.pipeline.solves_exposure() && !is_known(frame, image))
            .filter_map(|((frame, image), log)| Some((frame.name.clone(), Gain { log: (*log)?, image: image.clone() })))
            .collect();
        let untied = named().filter(|((_, image), log)| log.is_none() && !image.is_empty());
        let light = self.pipeline.estimates_light().then(|| self.light(&gains));
        let moved = known.light.as_ref().zip(light.as_ref()).and_then(|(before, now)| before.against(now));
        Looked {
            untied: untied.map(|((frame, _), _)| frame.name.clone()).collect(),
            residual: if gains.residual.is_finite() { gains.residual } else { 0.0 },
            gains: new,
            light: light.filter(|_| known.light.is_none()),
            moved,
            // Whoever keeps it knows these.
            gains_under: Key([0; 32]),
            light_under: Key([0; 32]),
            sightings: Key([0; 32]),
        }
    }

    fn gains(&self, known: &State) -> Gains {
        let count = self.scene.frames.len();
        if !self.pipeline.solves_exposure() {
            return Gains::none(count);
        }
        let of = |(frame, image): (&Frame, &String)| {
            known.gains.get(&frame.name).filter(|gain| gain.image == *image).map(|gain| gain.log)
        };
        let frozen: Vec<Option<f32>> = self.scene.frames.iter().zip(self.images).map(of).collect();
        light::gains(self.sightings, count, &frozen)
    }

    fn light(&self, gains: &Gains) -> FoundLight {
        let (mesh, bvh) = (&self.scene.mesh, self.scene.bvh());
        let up = self.pipeline.scene.zenith();
        let scene = light::Scene { mesh, bvh: &bvh, up };
        let settings = Settings { white: self.pipeline.light.white };
        let clues = Clues::new(&scene, self.sample, self.sightings, gains);
        let known = self.occasion.as_ref().and_then(|occasion| under(&clues, occasion, &settings));
        known.unwrap_or_else(|| FoundLight::of(&clues.find(&settings)))
    }
}
