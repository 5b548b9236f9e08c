//! Trees as they are, of many clumps of leaves, and as a reconstruction leaves them: one smooth blob without a trunk.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rand::RngExt;

use crate::synth::city::palette;
use crate::synth::city::surface::{Block, Part, Spot};

/// Clumps of a crown.
const CLUMPS: u32 = 8;

/// A broad-leaved tree of a height, metres.
pub(in crate::synth::city) fn tree(block: &mut Block, spot: Spot, height: f64) {
    let leaves = palette::leaves(&mut block.rng);
    let wide = height * block.rng.random_range(0.27..0.38);
    let tall = height * block.rng.random_range(0.3..0.36);
    let (middle, radii) = (DVec3::new(0.0, 0.0, height - tall), DVec3::new(wide, wide, tall));
    block.part = Part::Town;
    let bark = palette::bark(&mut block.rng);
    let radius = 0.025 * height;
    block.lathe(spot, &[DVec2::new(radius * 1.3, -0.05), DVec2::new(radius, height - 1.6 * tall)], 6, 0.1, &bark);
    block.blob(spot, middle, radii * 0.72, 0.25, &leaves.shaded(0.85));
    for _ in 0..CLUMPS {
        let (turn, up) = (block.rng.random_range(0.0..TAU), block.rng.random_range(-0.6..0.95_f64));
        let out = (1.0 - up * up).sqrt();
        let at = middle + DVec3::new(turn.cos() * out, turn.sin() * out, up) * radii * 0.72;
        let size = wide * block.rng.random_range(0.3..0.5);
        let shade = block.rng.random_range(0.85..1.15);
        block.blob(spot, at, DVec3::splat(size), 0.35, &leaves.shaded(shade));
    }
    block.part = Part::Mesh;
    block.blob(spot, middle - DVec3::Z * 0.1 * tall, radii * 1.02, 0.12, &leaves);
    block.part = Part::Both;
}
