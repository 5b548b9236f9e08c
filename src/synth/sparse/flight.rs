//! The views of one surface of a scene on a flight: directions from the surface to the cameras that see it, z up.

use std::f32::consts::{PI, TAU};

use glam::Vec3;
use rand::{Rng, RngExt};

use crate::base::convert::Cut;
use crate::synth::direction;

/// Nearly normal, mean 0, deviation 1: the sum of four uniforms.
pub(super) fn bell(rng: &mut impl Rng) -> f32 {
    (0..4).map(|_| rng.random_range(-0.5..0.5f32)).sum::<f32>() * 1.732
}

/// The normal of a surface of a scene: ground or flat roof, pitched roof, wall, or another surface that may face any way
/// but steeply down.
pub(super) fn surface(rng: &mut impl Rng) -> Vec3 {
    let tilt = match rng.random_range(0..20) {
        0..8 => bell(rng).abs() * 0.17,
        8..11 => rng.random_range(0.3..0.9),
        11..16 => PI / 2.0 + bell(rng) * 0.07,
        _ => rng.random_range(-0.3..1.0f32).acos(),
    };
    direction(tilt, rng.random_range(0.0..TAU))
}

/// Unit directions to the cameras that see the surface's point, whatever way the surface faces.
pub(super) fn views(rng: &mut impl Rng) -> Vec<Vec3> {
    let mut cameras = Vec::new();
    let pattern = rng.random_range(0..4);
    if pattern != 0 {
        orbit(rng, &mut cameras);
    }
    if pattern <= 1 {
        block(rng, &mut cameras);
    }
    // Something higher stands beside the surface and hides low views from that side.
    let behind = rng
        .random_bool(0.5)
        .then(|| (rng.random_range(0.0..TAU), rng.random_range(0.3..2.0f32), rng.random_range(0.2..1.3f32).tan()));
    let kept = rng.random_range(0.15..0.9);
    cameras.retain(|c| {
        let hidden = behind.is_some_and(|(azimuth, half_width, slope)| {
            let off = (c.y.atan2(c.x) - azimuth).rem_euclid(TAU);
            off.min(TAU - off) < half_width && c.z < slope * c.x.hypot(c.y)
        });
        !hidden && rng.random_bool(kept)
    });
    cameras.iter().map(|c| c.normalize()).collect()
}

/// Adds one to three rings around a centre that need not be the surface.
fn orbit(rng: &mut impl Rng, cameras: &mut Vec<Vec3>) {
    let off = direction(PI / 2.0, rng.random_range(0.0..TAU)) * rng.random_range(0.0..0.6f32);
    for _ in 0..rng.random_range(1..=3) {
        let from_up = rng.random_range(0.2..1.2f32);
        let start = rng.random_range(0.0..TAU);
        let frames = rng.random_range(6..26);
        let wander = rng.random_range(0.0..0.06f32);
        for i in 0..frames {
            let azimuth = start + TAU * i as f32 / frames as f32;
            let at = direction(from_up, azimuth) + Vec3::new(bell(rng), bell(rng), bell(rng)) * wander;
            cameras.push(at - off);
        }
    }
}

/// Adds the frames with the surface in them of parallel tracks at one height, the camera straight down or a little oblique.
fn block(rng: &mut impl Rng, cameras: &mut Vec<Vec3>) {
    let half = (rng.random_range(0.45..0.75f32), rng.random_range(0.35..0.55f32));
    // Distances between frames along and across the tracks, from overlaps of 65 to 85 and 50 to 80 percent.
    let along = 2.0 * half.1 * rng.random_range(0.15..0.35);
    let across = 2.0 * half.0 * rng.random_range(0.2..0.5);
    let (sin, cos) = rng.random_range(0.0..TAU).sin_cos();
    let phase = (rng.random_range(0.0..along), rng.random_range(0.0..across));
    let lean = if rng.random_bool(0.3) { rng.random_range(-0.5..0.5f32) } else { 0.0 };
    let steps = |half: f32, step: f32| i32::cut((half / step).ceil()) + 1;
    for i in -steps(half.1, along)..=steps(half.1, along) {
        for j in -steps(half.0, across)..=steps(half.0, across) {
            let (y, x) = (i as f32 * along + phase.0, j as f32 * across + phase.1);
            if y.abs() <= half.1 && x.abs() <= half.0 {
                let (y, height) = (y + lean, 1.0 + bell(rng) * 0.02);
                cameras.push(Vec3::new(x * cos - y * sin, x * sin + y * cos, height));
            }
        }
    }
}
