//! The search for the sun: a grid over the sky, then the best of its modes refined.

use glam::Vec3;
use rayon::prelude::*;

use super::comparison::Comparison;
use super::directions::{angle, dome, rings};
use super::pairs::{Pair, some};
use super::patches::POINTS;
use super::ratio::{GREYS, Ratio, best, best_grey, refined};

/// Directions of the grid, and the lowest.
const GRID: usize = 500;
pub(super) const LOWEST_DEGREES: f64 = 8.0;

/// Pairs that the grid is judged by.
const GRID_PAIRS: usize = 15_000;

/// Modes that are refined, and how far they lie apart at least.
const MODES: usize = 4;
const APART_DEGREES: f32 = 15.0;

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

/// What a search found.
#[derive(Debug, Clone)]
pub(super) struct Searched {
    /// The best of each mode, the likeliest first.
    pub modes: Vec<Candidate>,
    /// The directions of the grid and their costs.
    pub dome: Vec<(Vec3, f32)>,
}

/// Searches the whole sky. The comparison's scales become those of the best sun. There must be pairs.
pub(super) fn search(comparison: &mut Comparison<'_>, pairs: &[Pair]) -> Searched {
    let directions = dome(comparison.patches.up, GRID, LOWEST_DEGREES);
    let few = some(pairs, GRID_PAIRS);
    let lit: Vec<Vec<f32>> = directions.par_iter().map(|sun| comparison.patches.sun(*sun, 1)).collect();

    let mut costs = Vec::new();
    for round in 0..2 {
        let cost = |lit: &Vec<f32>| best_grey(comparison, lit, &few, GREYS.into_iter().step_by(2));
        costs = lit.par_iter().map(cost).collect::<Vec<_>>();
        if round == 0 {
            let first = (1..costs.len()).fold(0, |best, i| if costs[i].0 < costs[best].0 { i } else { best });
            comparison.fit_scales(&lit[first], costs[first].1, &few);
        }
    }

    drop(lit);
    let mut order: Vec<usize> = (0..directions.len()).collect();
    order.sort_by(|a, b| costs[*a].0.total_cmp(&costs[*b].0));
    let mut starts: Vec<Vec3> = Vec::new();
    for i in order {
        if starts.len() < MODES && starts.iter().all(|other| angle(*other, directions[i]) > APART_DEGREES) {
            starts.push(directions[i]);
        }
    }
    let mut modes: Vec<Candidate> = Vec::new();
    for start in starts {
        let found = refine(comparison, pairs, start);
        if modes.is_empty() {
            comparison.fit_scales(&comparison.patches.sun(found.sun, POINTS), found.ratio, pairs);
        }
        modes.push(found);
    }
    for mode in &mut modes {
        mode.cost = comparison.cost(&comparison.patches.sun(mode.sun, POINTS), mode.ratio, pairs);
    }
    modes.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let dome = directions.into_iter().zip(&costs).map(|(sun, cost)| (sun, cost.0 as f32)).collect();
    Searched { modes, dome }
}

/// The best sun near a start: hexagons of halving size, each moved until its middle is the best.
fn refine(comparison: &Comparison<'_>, pairs: &[Pair], start: Vec3) -> Candidate {
    let mut sun = start;
    let (mut cost, mut ratio) = best(comparison, &comparison.patches.sun(sun, 1), pairs);
    for step in [4.0, 2.0, 1.0, 0.5] {
        let points = if step < 4.0 { POINTS } else { 1 };
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
        let lit = comparison.patches.sun(sun, POINTS);
        let from = (comparison.cost(&lit, ratio, pairs), ratio);
        (cost, ratio) = refined(comparison, &lit, pairs, from, &[1.2, 1.08, 1.03]);
    }
    Candidate { sun, ratio, cost }
}
