//! Panes and water: they mirror what stands before them, sharply, and show what lies behind.

use glam::Vec3;

use super::noise::{cell, noise, unit};
use crate::scene::brdf::fresnel;

/// The depth of a room, metres.
const ROOM: f32 = 3.0;

/// How a clear surface answers a ray.
pub(super) struct Clear {
    /// The normal as waves and warping turn it.
    pub normal: Vec3,
    /// The share of what is mirrored.
    pub mirrored: f32,
    /// What lies behind, as the albedo of a matt surface in its place.
    pub behind: Vec3,
}

/// A window at a point of the world, metres, seen along a direction, its face towards the eye.
pub(super) fn window(point: Vec3, direction: Vec3, normal: Vec3) -> Clear {
    let warp = Vec3::new(noise(point / 0.5, 30), noise(point / 0.5, 31), noise(point / 0.5, 32)) * 0.008;
    let cos = (-direction.dot(normal)).clamp(0.05, 1.0);
    // Four faces of two panes, one behind the other.
    let one = fresnel(cos);
    let mirrored = 4.0 * one / (1.0 + 3.0 * one);
    let pane = cell(point / 1.4);
    let room = point + direction * (ROOM / cos);
    let behind = if unit(pane, 33) < 0.3 {
        Vec3::new(0.33, 0.31, 0.27) * (0.6 + 0.4 * unit(pane, 34))
    } else {
        Vec3::new(0.05, 0.045, 0.04) * (0.3 + 2.0 * unit(cell(room / 1.2), 35))
    };
    Clear { normal: (normal + warp).normalize(), mirrored, behind }
}

/// Water at a point of the world, metres, seen along a direction.
pub(super) fn water(point: Vec3, direction: Vec3, normal: Vec3) -> Clear {
    let wave = |purpose| 0.02 * noise(point / 0.7, purpose) + 0.02 * noise(point / 0.2, purpose + 1);
    let normal = (normal + Vec3::new(wave(36), wave(38), 0.0)).normalize();
    // Schlick's formula for an index of 1.33.
    let mirrored = 0.02 + 0.98 * (1.0 - (-direction.dot(normal)).clamp(0.0, 1.0)).powi(5);
    Clear { normal, mirrored, behind: Vec3::new(0.02, 0.035, 0.03) }
}
