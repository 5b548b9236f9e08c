//! Is there a sun at all? Under a sky alone, a sun that is turned about up explains the photographs as well; under a bright
//! patch of cloud, a sun that is spread over the patch explains them better.

use rayon::prelude::*;

use super::blocks::{BLOCKS, Sums, blocks};
use super::comparison::Comparison;
use super::directions::{rings, turned};
use super::found::Decision;
use super::pairs::Pair;
use super::patches::POINTS;
use super::ratio::best;
use super::search::Candidate;

/// A rise of the cost, in nats a pair, and how many standard errors it lies above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rise {
    /// The mean.
    pub by: f64,
    /// The mean over its standard error.
    pub sure: f64,
}

/// More standard errors than this say no more.
const SUREST: f64 = 99.0;

/// Degrees between the rings of the spread sun.
const SOFT_DEGREES: f32 = 10.0;

/// The rise of the cost for other suns than the one that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rises {
    /// For a sun that is turned about up by a quarter, a half or three quarters, whichever rises least.
    pub turned: Rise,
    /// For a sun that is spread over a cap of 20 degrees.
    pub soft: Rise,
}

/// The rise below which a sun that is there may as well stand elsewhere.
const LEAST_RISE: f64 = 0.1;

/// Standard errors of the rise below which there is no sun, and below which the sun is doubtful.
const TURNED: [f64; 2] = [3.0, 5.0];
const SOFT: [f64; 2] = [-3.0, 1.0];

/// The highest sun that is not doubtful: under an overcast sky the best sun stands near the zenith.
const HIGHEST_DEGREES: f32 = 78.0;

impl Rises {
    /// Whether a sun at this elevation is believed.
    pub(super) fn decide(&self, elevation_degrees: f32) -> Decision {
        let Rises { turned, soft } = self;
        // Comparisons with what is no number are false, and then there is no sun.
        let more = |limit: usize| turned.sure >= TURNED[limit] && soft.sure >= SOFT[limit] && turned.by >= LEAST_RISE;
        match (more(0), more(1) && elevation_degrees <= HIGHEST_DEGREES) {
            (true, true) => Decision::Sun,
            (true, false) => Decision::Doubtful,
            _ => Decision::NoSun,
        }
    }
}

/// Finds how much worse other suns explain what was seen. The ratio is found anew for each; the scales are those of the sun
/// that was found.
pub(super) fn rises(comparison: &Comparison<'_>, pairs: &[Pair], found: &Candidate) -> Rises {
    let mut comparison = comparison.clone();
    let blocks = blocks(comparison.patches, pairs);
    let mut counts: Sums = [0.0; BLOCKS];
    blocks.iter().for_each(|block| counts[*block] += 1.0);
    let lit = comparison.patches.sun(found.sun, POINTS);
    let (_, ratio) = best(&comparison, &lit, pairs);
    comparison.fit_scales(&lit, ratio, pairs);
    let here = comparison.block_costs(&lit, ratio, pairs, &blocks);
    let rise = |lit: &[f32]| {
        let (_, ratio) = best(&comparison, lit, pairs);
        let there = comparison.block_costs(lit, ratio, pairs, &blocks);
        let all = pairs.len() as f64;
        let by = there.iter().zip(&here).map(|(there, here)| there - here).sum::<f64>() / all;
        let off = (0..BLOCKS).map(|b| (there[b] - here[b] - by * counts[b]).powi(2)).sum::<f64>();
        // Where all blocks agree, the error is 0.
        Rise { by, sure: (by * all / off.sqrt().max(f64::MIN_POSITIVE)).clamp(-SUREST, SUREST) }
    };
    let turns = [90.0, 180.0, 270.0].map(|degrees| turned(found.sun, comparison.patches.up, degrees));
    let turns = turns.map(|sun| rise(&comparison.patches.sun(sun, POINTS)));
    let cap = rings(found.sun, SOFT_DEGREES, 2);
    let cap: Vec<Vec<f32>> = cap.par_iter().map(|sun| comparison.patches.sun(*sun, 1)).collect();
    let soft: Vec<f32> = (0..lit.len()).map(|i| cap.iter().map(|lit| lit[i]).sum::<f32>() / cap.len() as f32).collect();
    let least = turns.into_iter().fold(turns[0], |least, rise| if rise.by < least.by { rise } else { least });
    Rises { turned: least, soft: rise(&soft) }
}
