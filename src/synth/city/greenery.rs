//! Plants: broad-leaved trees, conifers, hedges.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rand::RngExt;

use super::palette;
use super::real::clumps;
use super::surface::{Block, Rect, Spot};
use super::world::World;
use crate::base::convert::Cut;

/// A tree of the given height, metres: a trunk and one or two crowns, or a conifer.
pub(super) fn tree(block: &mut Block, at: DVec2, height: f64) {
    let spot = Spot::new(at, block.rng.random_range(0.0..TAU));
    if block.world == World::Real {
        return clumps::tree(block, spot, height);
    }
    if block.rng.random_bool(0.18) {
        let needles = palette::needles(&mut block.rng);
        let wide = height * block.rng.random_range(0.2..0.27);
        let profile = [(0.4, 0.1), (1.0, 0.16), (0.72, 0.42), (0.45, 0.66), (0.22, 0.86), (0.0, 1.0)];
        trunk(block, spot, 0.03 * height, 0.2 * height);
        block.lathe(spot, &profile.map(|(r, z)| DVec2::new(r * wide, z * height)), 8, 0.16, &needles);
        return;
    }
    let leaves = palette::leaves(&mut block.rng);
    let wide = height * block.rng.random_range(0.27..0.38);
    let tall = height * block.rng.random_range(0.3..0.36);
    trunk(block, spot, 0.025 * height, height - 1.6 * tall);
    block.blob(spot, DVec3::new(0.0, 0.0, height - tall), DVec3::new(wide, wide, tall), 0.22, &leaves);
    // A second, lower crown makes larger trees irregular.
    if height > 5.5 && block.rng.random_bool(0.6) {
        let aside = wide * 0.6;
        let leaves = leaves.shaded(0.95);
        block.blob(spot, DVec3::new(aside, 0.0, height - 1.35 * tall), DVec3::splat(0.62 * wide), 0.2, &leaves);
    }
}

fn trunk(block: &mut Block, spot: Spot, radius: f64, height: f64) {
    let bark = palette::bark(&mut block.rng);
    block.lathe(spot, &[DVec2::new(radius * 1.3, -0.05), DVec2::new(radius, height)], 6, 0.1, &bark);
}

/// A clipped hedge over a rectangle, about 1.2 m high.
pub(super) fn hedge(block: &mut Block, rect: Rect) {
    let needles = palette::needles(&mut block.rng).shaded(1.5);
    let half = rect.size() * 0.5;
    let height = block.rng.random_range(0.9..1.4);
    let spot = Spot::new(rect.centre(), 0.0);
    block.solid(spot, (-half).extend(-0.1), half.extend(height), &needles, &needles);
}

/// Trees at random over a rectangle and away from its edge, one for each `square_metres`.
pub(super) fn grove(block: &mut Block, rect: Rect, square_metres: f64, heights: std::ops::Range<f64>) {
    let size = rect.size() - 2.0;
    if size.min_element() <= 0.0 {
        return;
    }
    let expected = size.x * size.y / square_metres;
    let count = usize::cut(expected) + usize::from(block.rng.random_bool(expected.fract()));
    for _ in 0..count {
        let at = DVec2::new(block.rng.random_range(0.0..size.x), block.rng.random_range(0.0..size.y));
        let height = block.rng.random_range(heights.clone());
        tree(block, rect.low + 1.0 + at, height);
    }
}
