//! What the light is found from, prepared, and the answers to what is asked of it.

use std::collections::BTreeMap;

use glam::Vec3;

use super::comparison::Comparison;
use super::decision::rises;
use super::directions::elevation;
use super::found::{Decision, Found, Spread};
use super::gains::Gains;
use super::observed::Sighting;
use super::pairs::{Pair, pairs};
use super::patches::{POINTS, Patch, Patches, Scene};
use super::ratio::{Ratio, best};
use super::scale;
use super::search::{Candidate, search};
use super::spread::{UNKNOWN, spread};
use crate::base::convert::to_f32;
use crate::base::ids::TriangleId;

/// What is given about the light.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// The radiance of a white surface that faces the sun, where it is known.
    pub white: Option<f64>,
}

/// Pairs below which no light is told.
const FEWEST_PAIRS: usize = 200;

/// The least share of the sky of patches that tell the ratio.
const OPEN: f32 = 0.3;

/// The least share of the light of a white surface that faces it, by which albedos are told.
const BRIGHT: f32 = 0.3;

/// Rounds in which white and the ratio are found in turn.
const ROUNDS: usize = 3;

/// What the light is found from, prepared.
#[derive(Debug)]
pub struct Clues<'a> {
    patches: Patches<'a>,
    pairs: Vec<Pair>,
}

/// Finds the light.
pub fn find(
    scene: &Scene<'_>,
    sample: &[TriangleId],
    sightings: &[Sighting],
    gains: &Gains,
    settings: &Settings,
) -> Found {
    Clues::new(scene, sample, sightings, gains).find(settings)
}

impl<'a> Clues<'a> {
    /// Prepares what was seen of a sample.
    pub fn new(scene: &Scene<'a>, sample: &[TriangleId], sightings: &[Sighting], gains: &Gains) -> Self {
        let patches = Patches::new(scene, sample, sightings, gains);
        let pairs = pairs(&patches);
        Clues { patches, pairs }
    }

    /// Finds the light.
    pub fn find(&self, settings: &Settings) -> Found {
        if self.pairs.len() < FEWEST_PAIRS {
            return self.nothing(settings);
        }
        let mut comparison = self.comparison(settings);
        let (mut found, mut dome) = search(&mut comparison, &self.pairs);
        if let Some(bounced) = self.bounced(&comparison, &found, settings) {
            comparison = bounced;
            (found, dome) = search(&mut comparison, &self.pairs);
        }
        let rises = rises(&comparison, &self.pairs, &found);
        let decided = rises.decide(elevation(found.sun, self.patches.up));
        found.ratio = self.ratio(&mut comparison, &found, settings);
        let spread = spread(&comparison, &self.pairs, &mut found);
        let told = Found { turned: to_f32(rises.turned.by), dome, spread, decided, ..self.nothing(settings) };
        let told = Found { turned_sure: to_f32(rises.turned.sure), soft_sure: to_f32(rises.soft.sure), ..told };
        if decided == Decision::NoSun {
            let white = settings.white.map_or_else(|| scale::overcast(&self.comparison(settings)), to_f32);
            return Found { white, sky: [white; 3], ..told };
        }
        self.lit(&found, &comparison, told)
    }

    /// The light where the sun's direction is known: its ratio to the sky, and the scale. The sun is believed; what was seen
    /// may speak against it all the same, and then it is doubtful.
    pub fn under(&self, sun: Vec3, settings: &Settings) -> Found {
        if self.pairs.len() < FEWEST_PAIRS {
            return self.nothing(settings);
        }
        let mut comparison = self.comparison(settings);
        let lit = self.patches.sun(sun, POINTS);
        let mut found = self.candidate(&mut comparison, sun, &lit);
        if let Some(bounced) = self.bounced(&comparison, &found, settings) {
            comparison = bounced;
            found = self.candidate(&mut comparison, sun, &lit);
        }
        let rises = rises(&comparison, &self.pairs, &found);
        found.ratio = self.ratio(&mut comparison, &found, settings);
        let spread = spread(&comparison, &self.pairs, &mut Candidate { ..found });
        let decided = match rises.decide(0.0) {
            Decision::Sun => Decision::Sun,
            _ => Decision::Doubtful,
        };
        let told = Found { turned: to_f32(rises.turned.by), spread, decided, ..self.nothing(settings) };
        let told = Found { turned_sure: to_f32(rises.turned.sure), soft_sure: to_f32(rises.soft.sure), ..told };
        self.lit(&found, &comparison, told)
    }

    /// The cost of each of some suns, by scales that they share; the lowest is the likeliest.
    pub fn costs(&self, suns: &[Vec3], settings: &Settings) -> Vec<f64> {
        let mut comparison = self.comparison(settings);
        let lit: Vec<Vec<f32>> = suns.iter().map(|sun| self.patches.sun(*sun, POINTS)).collect();
        if let Some(first) = lit.first() {
            let (_, ratio) = best(&comparison, first, &self.pairs);
            comparison.fit_scales(first, ratio, &self.pairs);
        }
        lit.iter().map(|lit| best(&comparison, lit, &self.pairs).0).collect()
    }

    /// The albedo of the triangles that much light reaches, by their positions in the sample, under a sun, if any, and a sky and
    /// surfaces of these radiances. `white` is the radiance of a white surface that faces the sun, or the sky where there is none.
    pub fn albedos(&self, sun: Option<Vec3>, white: f32, sky: [f32; 3], bounce: [f32; 3]) -> BTreeMap<u32, [f32; 3]> {
        let plain = self.comparison(&Settings { white: Some(f64::from(white)) });
        let comparison = if bounce == [0.0; 3] { plain } else { plain.with_bounce(bounce) };
        let none = || vec![0.0; self.patches.all.len()];
        let lit = sun.map_or_else(none, |sun| self.patches.sun(sun, POINTS));
        let ratio = sky.map(|sky| sky / white);
        let bright = |patch: &Patch, lit: f32| if sun.is_some() { lit > BRIGHT } else { patch.sky > BRIGHT };
        let all = self.patches.all.iter().zip(&lit).enumerate();
        all.filter(|(_, (patch, lit))| bright(patch, **lit))
            .map(|(at, (patch, lit))| (patch.sample, comparison.albedo(at, *lit, ratio)))
            .collect()
    }

    fn comparison(&self, settings: &Settings) -> Comparison<'_> {
        let mut comparison = Comparison::new(&self.patches);
        comparison.white = settings.white.map_or(1.0, to_f32);
        comparison
    }

    /// A sun with its best ratio; the scales become the likeliest under it.
    fn candidate(&self, comparison: &mut Comparison<'_>, sun: Vec3, lit: &[f32]) -> Candidate {
        let (cost, ratio) = best(comparison, lit, &self.pairs);
        comparison.fit_scales(lit, ratio, &self.pairs);
        Candidate { sun, ratio, cost }
    }

    /// The comparison with the light that surfaces send each other, where that explains better what was seen. They are as
    /// bright as the photographs show them. Photographs of the world have that light, and most rendered ones have not.
    fn bounced<'s>(&'s self, plain: &Comparison<'s>, found: &Candidate, settings: &Settings) -> Option<Comparison<'s>> {
        let all = &self.patches.all;
        let area: f32 = all.iter().map(|patch| patch.area).sum();
        let mean = |c: usize| all.iter().map(|patch| patch.area * patch.radiance[c]).sum::<f32>() / area;
        let lit = self.patches.sun(found.sun, POINTS);
        let cost = |mut comparison: Comparison<'s>| {
            let ratio = self.ratio(&mut comparison, found, settings);
            comparison.fit_scales(&lit, ratio, &self.pairs)
        };
        let bounced = plain.with_bounce([mean(0), mean(1), mean(2)]);
        (cost(bounced.clone()) < cost(plain.clone())).then_some(bounced)
    }

    /// The light of a sun.
    fn lit(&self, found: &Candidate, Comparison { white, bounce, .. }: &Comparison<'_>, told: Found) -> Found {
        let sun = Some(found.sun.as_dvec3().normalize().to_array());
        let sky = found.ratio.map(|ratio| ratio * white);
        Found { sun, color: [*white; 3], sky, bounce: *bounce, white: *white, ..told }
    }

    /// The ratio from patches that are wholly lit or wholly shaded and see the sky, and with it the scale.
    fn ratio(&self, comparison: &mut Comparison<'_>, found: &Candidate, settings: &Settings) -> Ratio {
        let lit = self.patches.sun(found.sun, POINTS);
        let whole = |i: u32| {
            let (patch, lit) = (&self.patches.all[i as usize], lit[i as usize]);
            let cos = Vec3::from(patch.normal).dot(found.sun).max(0.0);
            patch.sky > OPEN && (lit <= 0.01 * cos || lit >= 0.99 * cos)
        };
        let clear: Vec<Pair> = self.pairs.iter().copied().filter(|[i, j]| whole(*i) && whole(*j)).collect();
        let pairs = if clear.len() < FEWEST_PAIRS { &self.pairs } else { &clear };
        let mut ratio = found.ratio;
        for _ in 0..ROUNDS {
            ratio = best(comparison, &lit, pairs).1;
            if settings.white.is_some() {
                break;
            }
            comparison.white = scale::white(comparison, &lit, ratio);
        }
        ratio
    }

    /// What is told where too little was seen.
    fn nothing(&self, settings: &Settings) -> Found {
        let white = to_f32(settings.white.unwrap_or(1.0));
        Found {
            sun: None,
            color: [0.0; 3],
            sky: [white; 3],
            bounce: [0.0; 3],
            spread: Spread { sun_degrees: 180.0, ratio: [UNKNOWN; 3], scale: scale::SPREAD },
            turned: 0.0,
            turned_sure: 0.0,
            soft_sure: 0.0,
            white,
            decided: Decision::TooLittle,
            dome: Vec::new(),
            triangles: self.patches.all.len(),
            pairs: self.pairs.len(),
        }
    }
}
