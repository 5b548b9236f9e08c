//! The light of a white sky that the specular lobe reflects.

use std::sync::LazyLock;

use glam::Vec3;

use super::microfacet::{fresnel, lambda};
use crate::base::convert::{Cut, to_f32};
use crate::scene::Material;

/// The bits of `k` mirrored at the binary point: van der Corput's sequence, in [0, 1).
pub(crate) fn radical_inverse(k: u32) -> f32 {
    // The upper 24 bits, so that the result stays below 1.
    (k.reverse_bits() >> 8) as f32 / (1 << 24) as f32
}

/// Nodes of the table along roughness and along the square root of the cosine, which is finer where Fresnel rises.
const NODES: usize = 32;

/// The directional albedo of the specular lobe with `ks = 1`: the share of a white sky that is reflected towards a
/// viewer at this cosine to the normal. Interpolated; within 0.01 of the integral.
pub(crate) fn sky_specular(r: f32, cos: f32) -> f32 {
    static TABLE: LazyLock<Vec<f32>> = LazyLock::new(|| {
        let node = |i: usize| i as f32 / (NODES - 1) as f32;
        (0..NODES * NODES).map(|i| directional_albedo(node(i / NODES), node(i % NODES).powi(2).max(1e-3))).collect()
    });
    let scaled = |v: f32| v.clamp(0.0, 1.0) * (NODES - 1) as f32;
    let (row, column) = (scaled(r), scaled(cos.clamp(0.0, 1.0).sqrt()));
    let (i, j) = (usize::cut(row).min(NODES - 2), usize::cut(column).min(NODES - 2));
    let (v, u) = (row - i as f32, column - j as f32);
    let at = |i: usize, j: usize| TABLE[i * NODES + j];
    let along = |i: usize| at(i, j) * (1.0 - u) + at(i, j + 1) * u;
    along(i) * (1.0 - v) + along(i + 1) * v
}

/// The integral of the lobe times the cosine over all incoming directions, by sampling facets as dense as D(h) cos h.
fn directional_albedo(r: f32, cos: f32) -> f32 {
    const SAMPLES: u32 = 512;
    let m = Material { kd: [0.0; 3], ks: [1.0; 3], r };
    let alpha = m.alpha();
    let wo = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let sample = |k: u32| {
        let (u, turn) = ((k as f32 + 0.5) / SAMPLES as f32, std::f32::consts::TAU * radical_inverse(k));
        let tan = alpha * (u / (1.0 - u)).sqrt();
        let z = 1.0 / (1.0 + tan * tan).sqrt();
        let h = Vec3::new(tan * z * turn.cos(), tan * z * turn.sin(), z);
        let wo_h = wo.dot(h);
        let wi = h * (2.0 * wo_h) - wo;
        if wo_h <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let g = 1.0 / (1.0 + lambda(alpha, wi.z) + lambda(alpha, cos));
        f64::from(g * fresnel(wo_h.min(1.0)) * wo_h / (cos * z))
    };
    to_f32((0..SAMPLES).map(sample).sum::<f64>() / f64::from(SAMPLES))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_surface_reflects_the_sky_as_fresnel_says() {
        for cos in [1.0, 0.8, 0.5, 0.25] {
            let (found, truth) = (sky_specular(0.0, cos), fresnel(cos));
            assert!((found - truth).abs() < 0.01, "cos {cos}: {found} against {truth}");
        }
    }

    #[test]
    fn a_rough_surface_reflects_what_quadrature_finds() {
        for (r, cos) in [(0.5, 0.9), (0.8, 0.5), (1.0, 0.3)] {
            let m = Material { kd: [0.0; 3], ks: [1.0; 3], r };
            let wo = Vec3::new((1.0_f32 - cos * cos).sqrt(), 0.0, cos);
            // Midpoints over the solid angle, 2 pi of it.
            let (rows, columns) = (400, 200);
            let mut sum = 0.0_f64;
            for i in 0..rows {
                let z = (i as f32 + 0.5) / rows as f32;
                for j in 0..columns {
                    let (s, c) = (std::f32::consts::TAU * (j as f32 + 0.5) / columns as f32).sin_cos();
                    let wi = Vec3::new((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z);
                    sum += f64::from(crate::scene::brdf::microfacet::evaluate(&m, wi, wo).x * z);
                }
            }
            let truth = sum * std::f64::consts::TAU / f64::from(rows * columns);
            let found = f64::from(sky_specular(r, cos));
            assert!((found - truth).abs() < 0.01, "r {r} cos {cos}: {found} against {truth}");
        }
    }
}
