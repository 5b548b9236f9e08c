//! How sure is the light? Blocks of the plan are drawn anew: what other such scenes would have given.

use glam::Vec3;
use rayon::prelude::*;

use crate::base::convert::{Cut, to_f32};

use super::blocks::{BLOCKS, Sums, blocks};
use super::comparison::Comparison;
use super::directions::{angle, rings};
use super::draw::unit;
use super::found::Spread;
use super::pairs::Pair;
use super::patches::POINTS;
use super::scale;
use super::search::Candidate;

/// Suns about the one that was found: degrees between rings, and rings.
const STEP_DEGREES: f32 = 1.5;
const FINE_DEGREES: f32 = 0.4;
const RINGS: usize = 5;

/// Scenes that are drawn.
const DRAWS: u64 = 300;

/// A lattice point stands for its cell, whose points lie so far from it (in steps, root mean square).
const WITHIN_CELL: f32 = 0.4;

/// The step of log ratio by which slopes are found.
const SLOPE: f32 = 0.05;

/// The spread of a logarithm of which nothing is known: a factor of twenty.
pub(super) const UNKNOWN: f32 = 3.0;

/// The spread of a light. The sun becomes the mean over the scenes that are drawn, which is steadier than the best of one.
pub(super) fn spread(comparison: &Comparison<'_>, pairs: &[Pair], found: &mut Candidate) -> Spread {
    let blocks = blocks(comparison.patches, pairs);
    let costs = |sun: Vec3, ratio| comparison.block_costs(&comparison.patches.sun(sun, POINTS), ratio, pairs, &blocks);
    let around = |middle: Vec3, step: f32| {
        let suns = rings(middle, step, RINGS);
        let of_suns: Vec<Sums> = suns.par_iter().map(|sun| costs(*sun, found.ratio)).collect();
        let drawn = |seed: u64| {
            let mut times = [0f64; BLOCKS];
            (0..BLOCKS as u64).for_each(|k| times[usize::cut(unit(seed, k) * BLOCKS as f64)] += 1.0);
            let cost = |costs: &Sums| costs.iter().zip(&times).map(|(cost, times)| cost * times).sum::<f64>();
            let all: Vec<f64> = of_suns.iter().map(cost).collect();
            suns[(1..all.len()).fold(0, |best, i| if all[i] < all[best] { i } else { best })]
        };
        let best: Vec<Vec3> = (0..DRAWS).into_par_iter().map(drawn).collect();
        let mean = best.iter().sum::<Vec3>().normalize_or_zero();
        let off = best.iter().map(|sun| angle(*sun, mean).powi(2)).sum::<f32>() / DRAWS as f32;
        (mean, (off + (WITHIN_CELL * step).powi(2)).sqrt())
    };
    let (mut mean, mut off) = around(found.sun, STEP_DEGREES);
    if off < STEP_DEGREES {
        (mean, off) = around(mean, FINE_DEGREES);
    }
    let ratio = std::array::from_fn(|c| {
        let at = |way: f32| {
            let mut ratio = found.ratio;
            ratio[c] *= (way * SLOPE).exp();
            costs(found.sun, ratio)
        };
        let [less, here, more] = [at(-1.0), at(0.0), at(1.0)];
        // The blocks' slopes at the least cost against its curvature.
        let slopes = less.iter().zip(&more).map(|(less, more)| ((more - less) / 2.0).powi(2)).sum::<f64>();
        let curvature = (0..BLOCKS).map(|b| more[b] + less[b] - 2.0 * here[b]).sum::<f64>();
        if curvature > 0.0 { (to_f32(slopes.sqrt() / curvature) * SLOPE).min(UNKNOWN) } else { UNKNOWN }
    });
    found.sun = mean;
    Spread { sun_degrees: off, ratio, scale: scale::SPREAD }
}
