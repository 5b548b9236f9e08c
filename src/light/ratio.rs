//! The ratio of sky to sun, per channel, that costs least under a sun's direction.

use rayon::prelude::*;

use super::comparison::Comparison;
use super::pairs::Pair;

/// Sky over sun, per channel: the radiance of a white surface under the whole sky by that of one that faces the sun.
pub(super) type Ratio = [f32; 3];

/// Grey ratios to begin with: each the same factor apart.
pub(super) const GREYS: [f32; 9] = [0.03, 0.051, 0.086, 0.145, 0.245, 0.414, 0.7, 1.18, 2.0];

/// The bounds of a ratio.
const LEAST: f32 = 0.005;
const MOST: f32 = 20.0;

/// The best of some grey ratios, and its cost.
pub(super) fn best_grey(
    comparison: &Comparison<'_>,
    lit: &[f32],
    pairs: &[Pair],
    greys: impl Iterator<Item = f32>,
) -> (f64, Ratio) {
    let costs = greys.map(|grey| (comparison.cost(lit, [grey; 3], pairs), [grey; 3]));
    costs.fold((f64::INFINITY, [1.0; 3]), |best, next| if next.0 < best.0 { next } else { best })
}

/// The best ratio, and its cost: the best grey one, then steps of all channels and of each.
pub(super) fn best(comparison: &Comparison<'_>, lit: &[f32], pairs: &[Pair]) -> (f64, Ratio) {
    let costs: Vec<f64> = GREYS.par_iter().map(|grey| comparison.cost(lit, [*grey; 3], pairs)).collect();
    let grey = (1..GREYS.len()).fold(0, |best, i| if costs[i] < costs[best] { i } else { best });
    refined(comparison, lit, pairs, (costs[grey], [GREYS[grey]; 3]), &[1.5, 1.2, 1.08, 1.03, 1.01])
}

/// The best ratio near one of known cost.
pub(super) fn refined(
    comparison: &Comparison<'_>,
    lit: &[f32],
    pairs: &[Pair],
    from: (f64, Ratio),
    steps: &[f32],
) -> (f64, Ratio) {
    let (mut cost, mut ratio) = from;
    for &step in steps {
        loop {
            let moved = |way: usize| -> Ratio {
                let by = if way.is_multiple_of(2) { step } else { 1.0 / step };
                std::array::from_fn(|c| {
                    if way / 2 == 3 || way / 2 == c { (ratio[c] * by).clamp(LEAST, MOST) } else { ratio[c] }
                })
            };
            let costs: Vec<f64> =
                (0..8usize).into_par_iter().map(|way| comparison.cost(lit, moved(way), pairs)).collect();
            let best = (1..8).fold(0, |best, i| if costs[i] < costs[best] { i } else { best });
            if costs[best] >= cost - 1e-7 {
                break;
            }
            (cost, ratio) = (costs[best], moved(best));
        }
    }
    (cost, ratio)
}
