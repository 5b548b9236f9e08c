//! Gains and light of what all frames saw, beside what is known of them.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use super::ephemeris::under;
use super::found::{Decided, FoundLight, Gain, Looked, camera_of};
use super::frozen::State;
use super::occasion::{Occasion, agreement, seconds};
use super::sittings::{Sitting, alike, together};
use crate::base::ids::TriangleId;
use crate::base::key::Key;
use crate::codec::images::Taken;
use crate::light::{self, Clues, Gains, Settings, Sighting, sittings};
use crate::phases::scene::LoadedScene;
use crate::pipeline::Pipeline;
use crate::scene::frame::Frame;
use crate::scene::vignetting::Vignetting;
use crate::stages::light::Mode;
use crate::trace::Bvh;

/// What gains and light are found of.
#[derive(Clone, Copy)]
pub(super) struct Evidence<'a> {
    /// The pipeline.
    pub pipeline: &'a Pipeline,
    /// The scene.
    pub scene: &'a LoadedScene,
    /// The hierarchy over its mesh.
    pub bvh: &'a Bvh,
    /// The triangles that were looked at.
    pub sample: &'a [TriangleId],
    /// What the frames saw of them.
    pub sightings: &'a [Sighting],
    /// What every frame's photograph tells of place and time.
    pub told: &'a [Taken],
    /// The content of every frame's image, as recipes have it; empty where it was not read.
    pub images: &'a [String],
}

/// What was found of the sittings, the first of them that whose light is best known.
struct Found {
    gains: Gains,
    light: Option<FoundLight>,
    /// The sitting of each frame.
    of_frame: Vec<usize>,
}

impl<'a> Evidence<'a> {
    /// What is found beside what is known. It depends on the evidence alone, not on the number of threads.
    pub(super) fn looked(&self, known: &State) -> Looked {
        let frames = &self.scene.frames;
        let lenses = self.vignetting(known);
        let lens = |frame: &Frame| lenses.get(&camera_of(frame)).copied().unwrap_or(Vignetting::NONE);
        let lens_of: Vec<Vignetting> = frames.iter().map(lens).collect();
        let even = |sighting: &Sighting| {
            let by = lens_of.get(sighting.frame as usize).map_or(1.0, |lens| lens.at(sighting.radius2));
            Sighting { mean: sighting.mean.map(|v| v / by), ..*sighting }
        };
        let even: Vec<Sighting> = self.sightings.iter().map(even).collect();
        let Found { gains, light, of_frame } = Evidence { sightings: &even, ..*self }.found(known);
        let named = || frames.iter().zip(self.images).zip(&gains.log);
        let is_known = |frame: &Frame, image: &String| known.gains.get(&frame.name).is_some_and(|g| g.image == *image);
        let new: BTreeMap<String, Gain> = named()
            .filter(|((frame, image), _)| self.pipeline.solves_exposure() && !is_known(frame, image))
            .filter_map(|((frame, image), log)| Some((frame.name.clone(), Gain { log: (*log)?, image: image.clone() })))
            .collect();
        let untied = named().filter(|((_, image), log)| log.is_none() && !image.is_empty());
        let moved = known.light.as_ref().zip(light.as_ref()).and_then(|(before, now)| before.against(now));
        let several = of_frame.iter().any(|sitting| *sitting > 0);
        let taken_in = frames.iter().zip(&of_frame).filter(|(frame, _)| !known.taken_in.contains_key(&frame.name));
        let taken_in = taken_in.filter(|_| several).map(|(frame, sitting)| (frame.name.clone(), *sitting)).collect();
        Looked {
            untied: untied.map(|((frame, _), _)| frame.name.clone()).collect(),
            residual: if gains.residual.is_finite() { gains.residual } else { 0.0 },
            gains: new,
            exif: if several { None } else { agreement(self.told, &gains) },
            vignetting: lenses.into_iter().filter(|(camera, _)| !known.vignetting.contains_key(camera)).collect(),
            taken_in,
            light: light.filter(|_| known.light.is_none()),
            moved,
            // Whoever keeps it knows these.
            gains_under: Key([0; 32]),
            light_under: Key([0; 32]),
            sightings: Key([0; 32]),
        }
    }

    /// The vignetting of every camera: what is known stays.
    fn vignetting(&self, known: &State) -> BTreeMap<String, Vignetting> {
        let mut lenses = known.vignetting.clone();
        if !self.pipeline.solves_exposure() {
            return lenses;
        }
        let names: Vec<String> = self.scene.frames.iter().map(camera_of).collect();
        let mut cameras: Vec<&String> = names.iter().collect();
        cameras.sort_unstable();
        cameras.dedup();
        if cameras.iter().any(|camera| !lenses.contains_key(*camera)) {
            let of_frame: Vec<usize> =
                names.iter().map(|name| cameras.partition_point(|camera| *camera < name)).collect();
            let found = light::vignetting(self.sightings, &of_frame, cameras.len());
            for (camera, found) in cameras.into_iter().zip(found) {
                lenses.entry(camera.clone()).or_insert(found);
            }
        }
        lenses
    }

    /// Finds gains and light sitting by sitting. Sittings of one light become one, and are looked at anew.
    fn found(&self, known: &State) -> Found {
        let mut of_frame = self.sittings(known);
        if !self.pipeline.estimates_light() {
            return Found { gains: self.gains(known, self.sightings, |_| true), light: None, of_frame };
        }
        loop {
            let count = of_frame.iter().max().map_or(1, |last| last + 1);
            let mut sittings: Vec<Sitting<'a>> = (0..count).map(|one| self.sitting(known, &of_frame, one)).collect();
            if known.light.is_none() {
                let lights: Vec<&FoundLight> = sittings.iter().map(|sitting| &sitting.light).collect();
                if let Some((kept, given)) = alike(&lights) {
                    let joined = |sitting: usize| match sitting {
                        s if s == given => kept,
                        s => s - usize::from(s > given),
                    };
                    of_frame.iter_mut().for_each(|sitting| *sitting = joined(*sitting));
                    continue;
                }
                let frames = |sitting: usize| of_frame.iter().filter(|of| **of == sitting).count();
                let mut ranked: Vec<(usize, Sitting<'a>)> = sittings.into_iter().enumerate().collect();
                ranked.sort_by_key(|(at, sitting)| (sitting.light.decided != Decided::Sun, Reverse(frames(*at))));
                let rank = |of: usize| ranked.iter().position(|(at, _)| *at == of).unwrap_or(0);
                of_frame = of_frame.iter().map(|of| rank(*of)).collect();
                sittings = ranked.into_iter().map(|(_, sitting)| sitting).collect();
            }
            let gains = all_gains(&sittings, &of_frame);
            let counts: Vec<usize> = (0..count).map(|one| of_frame.iter().filter(|of| **of == one).count()).collect();
            return Found { gains, light: together(sittings, &counts), of_frame };
        }
    }

    /// The sitting of each frame. A light that is known stays the only one if it was.
    fn sittings(&self, known: &State) -> Vec<usize> {
        let frames = &self.scene.frames;
        let one_moment = self.pipeline.light.mode == Mode::Ephemeris && self.pipeline.light.time.is_some();
        let one_light = known.light.as_ref().is_some_and(|light| light.others.is_empty());
        if !self.pipeline.estimates_light() || one_moment || one_light {
            return vec![0; frames.len()];
        }
        let of_known: Vec<Option<usize>> =
            frames.iter().map(|frame| known.taken_in.get(&frame.name).copied()).collect();
        sittings(self.sightings, &seconds(self.told), &of_known)
    }

    /// One sitting.
    fn sitting(&self, known: &State, of_frame: &[usize], one: usize) -> Sitting<'a> {
        let is_own = |frame: usize| of_frame.get(frame) == Some(&one);
        let alone = of_frame.iter().all(|sitting| *sitting == one);
        let own: Vec<Sighting>;
        let seen = if alone {
            self.sightings
        } else {
            own = self.sightings.iter().filter(|sighting| is_own(sighting.frame as usize)).copied().collect();
            &own
        };
        let gains = self.gains(known, seen, is_own);
        let scene = light::Scene { mesh: &self.scene.mesh, bvh: self.bvh, up: self.pipeline.scene.zenith() };
        let settings = Settings { white: self.pipeline.light.white };
        let clues = Clues::new(&scene, self.sample, seen, &gains);
        let told = || self.told.iter().enumerate().filter(|(frame, _)| is_own(*frame)).map(|(_, told)| *told).collect();
        // That the photographs tell an occasion was made sure of; those of one sitting may not.
        let occasion = |told: Vec<Taken>| Occasion::told(self.pipeline, &told).ok();
        let occasion = (self.pipeline.light.mode == Mode::Ephemeris).then(|| occasion(told())).flatten();
        let light = occasion.and_then(|occasion| under(&clues, &occasion, &settings));
        let light = light.unwrap_or_else(|| FoundLight::of(&clues.find(&settings)));
        Sitting { clues, gains, light }
    }

    /// The gains of some frames, from what they saw.
    fn gains(&self, known: &State, seen: &[Sighting], of: impl Fn(usize) -> bool) -> Gains {
        let count = self.scene.frames.len();
        if !self.pipeline.solves_exposure() {
            return Gains::none(count);
        }
        let frozen = |(at, (frame, image)): (usize, (&Frame, &String))| {
            known.gains.get(&frame.name).filter(|gain| of(at) && gain.image == *image).map(|gain| gain.log)
        };
        let frozen: Vec<Option<f32>> = self.scene.frames.iter().zip(self.images).enumerate().map(frozen).collect();
        light::gains(seen, count, &frozen)
    }
}

/// The gains of all frames, each in its sitting. What they leave is that of the worst.
fn all_gains(sittings: &[Sitting<'_>], of_frame: &[usize]) -> Gains {
    let log = of_frame.iter().enumerate().map(|(frame, sitting)| sittings[*sitting].gains.log[frame]).collect();
    Gains { log, residual: sittings.iter().map(|sitting| sitting.gains.residual).fold(0.0, f32::max) }
}
