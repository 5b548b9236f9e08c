//! What the light is found from, prepared, and the answers to what is asked of it.

use glam::Vec3;

use super::comparison::Comparison;
use super::decision::rise;
use super::directions::elevation;
use super::found::{Decision, Found, Spread};
use super::gains::Gains;
use super::observed::Sighting;
use super::pairs::{Pair, pairs};
use super::patches::{POINTS, Patches, Scene};
use super::ratio::{Ratio, best};
use super::search::{Candidate, search};
use super::{scale, spread};
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

/// The rise of the cost below which there is no sun, and below which the sun is doubtful; the highest sun that is believed.
const NO_SUN: f64 = 0.17;
const DOUBTFUL: f64 = 0.3;
const HIGHEST_DEGREES: f32 = 78.0;

/// The least share of the sky of patches that tell the ratio.
const OPEN: f32 = 0.3;

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

        let mut comparison = Comparison::new(&self.patches);
        if let Some(white) = settings.white {
            comparison.white = to_f32(white);
        }
        let (mut found, dome) = search(&mut comparison, &self.pairs);

        let turned = rise(&comparison, &self.pairs, &found);
        found.ratio = self.ratio(&mut comparison, &found, settings);

        let (spread, mean) = spread::spread(&comparison, &self.pairs, &found);
        found.sun = mean;

        let high = elevation(found.sun, self.patches.up) > HIGHEST_DEGREES;
        let decided = match turned {
            _ if high => Decision::NoSun,
            turned if turned < NO_SUN => Decision::NoSun,
            turned if turned < DOUBTFUL => Decision::Doubtful,
            _ => Decision::Sun,
        };
        let white = comparison.white;
        Found {
            sun: (decided != Decision::NoSun).then(|| found.sun.as_dvec3().normalize().to_array()),
            color: [white; 3],
            sky: found.ratio.map(|ratio| ratio * white),
            spread,
            turned: to_f32(turned),
            white,
            decided,
            dome,
            triangles: self.patches.all.len(),
            pairs: self.pairs.len(),
        }
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
            spread: Spread { sun_degrees: 180.0, ratio: [f32::INFINITY; 3], scale: scale::SPREAD },
            turned: 0.0,
            white,
            decided: Decision::TooLittle,
            dome: Vec::new(),
            triangles: self.patches.all.len(),
            pairs: self.pairs.len(),
        }
    }
}
