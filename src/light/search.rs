//! The search for the sun: a grid over the sky, then the best of its modes refined. The grid and the modes are judged by some of
//! the patches, the last steps by all.

use glam::Vec3;
use rayon::prelude::*;

use super::comparison::Comparison;
use super::directions::{angle, dome, rings};
use super::pairs::{Pair, pairs};
use super::patches::POINTS;
use super::ratio::{GREYS, Ratio, best, best_grey, refined};
use crate::base::convert::to_f32;

/// Directions of the grid, and the lowest.
const GRID: usize = 500;
const LOWEST_DEGREES: f64 = 8.0;

/// Patches that the grid and the modes are judged by.
const SOME: usize = 4000;

/// Modes that are refined, and how far they lie apart at least.
const MODES: usize = 4;
const APART_DEGREES: f32 = 15.0;

/// Steps of the hexagons, degrees: for each mode, and for the best one.
const COARSE: [f32; 3] = [4.0, 2.0, 1.0];
const FINE: [f32; 3] = [2.0, 1.0, 0.5];

/// A sun and its cost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// Unit vector towards the sun.
    pub sun: Vec3,
    /// The ratio that costs least under it.
    pub ratio: Ratio,
    /// The cost over all pairs.
    pub cost: f64,
}

/// Searches the whole sky. The comparison's scales become those of the sun that is found. Returns the sun, and the directions
/// of the grid with their costs.
pub(super) fn search(comparison: &mut Comparison<'_>, pairs_of_all: &[Pair]) -> (Candidate, Vec<(Vec3, f32)>) {
    let thinned = comparison.patches.thinned(SOME);
    let some_pairs = pairs(&thinned);
    let mut some = Comparison::of(&thinned, comparison);
    let grid = grid(&mut some, &some_pairs);
    let modes: Vec<Candidate> = starts(&grid)
        .into_iter()
        .map(|start| {
            let from = best(&some, &some.patches.sun(start, 1), &some_pairs);
            refine(&some, &some_pairs, Candidate { sun: start, ratio: from.1, cost: from.0 }, &COARSE, 1)
        })
        .collect();
    comparison.scales = some.scales;
    let judged = modes.into_iter().map(|mode| {
        let cost = comparison.cost(&comparison.patches.sun(mode.sun, POINTS), mode.ratio, pairs_of_all);
        Candidate { cost, ..mode }
    });
    let none = Candidate { sun: comparison.patches.up, ratio: [1.0; 3], cost: f64::INFINITY };
    let likeliest = judged.fold(none, |best, mode| if mode.cost < best.cost { mode } else { best });
    let lit = comparison.patches.sun(likeliest.sun, POINTS);
    let cost = comparison.fit_scales(&lit, likeliest.ratio, pairs_of_all);
    let found = refine(comparison, pairs_of_all, Candidate { cost, ..likeliest }, &FINE, POINTS);
    comparison.fit_scales(&comparison.patches.sun(found.sun, POINTS), found.ratio, pairs_of_all);
    (found, grid)
}

/// The directions of the grid and their costs, each with its best grey ratio; the scales become those of the best.
fn grid(comparison: &mut Comparison<'_>, pairs: &[Pair]) -> Vec<(Vec3, f32)> {
    let suns = dome(comparison.patches.up, GRID, LOWEST_DEGREES);
    let lit: Vec<Vec<f32>> = suns.par_iter().map(|sun| comparison.patches.sun(*sun, 1)).collect();
    let judged = |comparison: &Comparison<'_>| -> Vec<(f64, Ratio)> {
        lit.par_iter().map(|lit| best_grey(comparison, lit, pairs, GREYS.into_iter().step_by(2))).collect()
    };
    let first = judged(comparison);
    let best = (0..first.len()).fold(0, |best, i| if first[i].0 < first[best].0 { i } else { best });
    comparison.fit_scales(&lit[best], first[best].1, pairs);
    suns.into_iter().zip(judged(comparison)).map(|(sun, (cost, _))| (sun, to_f32(cost))).collect()
}

/// The best directions of a grid that lie apart.
fn starts(grid: &[(Vec3, f32)]) -> Vec<Vec3> {
    let mut order = grid.to_vec();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut starts: Vec<Vec3> = Vec::new();
    for (sun, _) in order {
        if starts.len() < MODES && starts.iter().all(|other| angle(*other, sun) > APART_DEGREES) {
            starts.push(sun);
        }
    }
    starts
}

/// The best sun near a first one: hexagons of falling size, each moved until its middle is the best.
fn refine(comparison: &Comparison<'_>, pairs: &[Pair], first: Candidate, steps: &[f32], points: usize) -> Candidate {
    let Candidate { mut sun, mut ratio, mut cost } = first;
    for &step in steps {
        for _ in 0..4 {
            let tries = rings(sun, step, 1);
            let cost = |sun: &Vec3| comparison.cost(&comparison.patches.sun(*sun, points), ratio, pairs);
            let costs: Vec<f64> = tries.par_iter().map(cost).collect();
            let best = (1..tries.len()).fold(0, |best, i| if costs[i] < costs[best] { i } else { best });
            if best == 0 {
                break;
            }
            sun = tries[best];
        }
        let lit = comparison.patches.sun(sun, points);
        let from = (comparison.cost(&lit, ratio, pairs), ratio);
        (cost, ratio) = refined(comparison, &lit, pairs, from, &[1.2, 1.08, 1.03]);
    }
    Candidate { sun, ratio, cost }
}
