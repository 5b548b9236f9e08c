//! Is there a sun at all? Under a sky alone, a sun that is turned about up explains the photographs as well.

use rayon::prelude::*;

use super::comparison::Comparison;
use super::directions::turned;
use super::pairs::Pair;
use super::patches::POINTS;
use super::ratio::best;
use super::search::Candidate;

/// By how much the cost rises at least when the sun is turned about up by a quarter, a half and three quarters, the ratio
/// found anew for each. The scales are those of the sun that was found.
pub(super) fn rise(comparison: &Comparison<'_>, pairs: &[Pair], found: &Candidate) -> f64 {
    let mut comparison = comparison.clone();
    let lit = comparison.patches.sun(found.sun, POINTS);
    let (_, ratio) = best(&comparison, &lit, pairs);
    let cost = comparison.fit_scales(&lit, ratio, pairs);
    let other = |quarter: u32| {
        let sun = turned(found.sun, comparison.patches.up, 90.0 * quarter as f32);
        best(&comparison, &comparison.patches.sun(sun, POINTS), pairs).0 - cost
    };
    (1..4u32).into_par_iter().map(other).collect::<Vec<_>>().into_iter().fold(f64::INFINITY, f64::min)
}
