//! How much of the sky each triangle sees.

use std::ops::Range;

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use super::environment::radical_inverse;
use crate::base::ids::TriangleId;
use crate::scene::Mesh;
use crate::trace::{Bvh, Ray};

/// How far rays start from the surface they leave, relative to the mesh's extent: beyond what rounding moves a hit.
pub fn offset(mesh: &Mesh) -> f32 {
    mesh.positions.iter().fold(0.0_f32, |far, p| far.max(p.abs().max_element())) * 1e-5
}

/// The cosine-weighted share of the sky that each of these triangles sees: `rays` rays from points spread over it, the same in
/// the triangle's own frame for every triangle. Rays below the horizon see none, even where they leave the mesh.
pub fn sky_visibility(mesh: &Mesh, bvh: &Bvh, up: Vec3, rays: u32, triangles: Range<TriangleId>) -> Vec<f32> {
    let offset = offset(mesh);
    let samples: Vec<(Vec3, DVec2)> = (0..rays).map(|k| (cosine_direction(k, rays), spread(k))).collect();
    let share = |t: TriangleId| {
        let Some(frame) = mesh.lobe_frame(t) else { return 0.0 };
        let [a, b, c] = mesh.corners(t);
        let free = samples.iter().filter(|(local, at)| {
            let direction = frame.to_world(*local);
            if direction.dot(up) <= 0.0 {
                return false;
            }
            let origin = a + (b - a) * at.x as f32 + (c - a) * at.y as f32 + frame.z * offset;
            !bvh.occluded(&Ray { origin, direction }, f32::INFINITY)
        });
        free.count() as f32 / rays.max(1) as f32
    };
    triangles.into_par_iter().map(share).collect()
}

/// The `k`-th of `n` directions about +z, as dense as their cosine: a Hammersley set on the disk, lifted (Malley).
fn cosine_direction(k: u32, n: u32) -> Vec3 {
    let (radius, turn) = (((k as f32 + 0.5) / n as f32).sqrt(), std::f32::consts::TAU * radical_inverse(k));
    Vec3::new(radius * turn.cos(), radius * turn.sin(), (1.0 - radius * radius).max(0.0).sqrt())
}

/// The `k`-th of a sequence of points spread over the triangle (0,0) (1,0) (0,1), a bit inside its edges: the R2
/// sequence (Roberts 2018), folded.
fn spread(k: u32) -> DVec2 {
    let p = (DVec2::new(0.754_877_666_246_692_7, 0.569_840_290_998_053_2) * f64::from(k + 1)).fract();
    let p = if p.x + p.y > 1.0 { 1.0 - p } else { p };
    p * 0.94 + 0.02
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cosine_directions_average_to_two_thirds_up() {
        let mean = (0..256).map(|k| cosine_direction(k, 256)).sum::<Vec3>() / 256.0;
        assert!(mean.truncate().length() < 0.01 && (mean.z - 2.0 / 3.0).abs() < 0.003, "{mean}");
        assert!((0..256).map(spread).all(|p| p.x > 0.0 && p.y > 0.0 && p.x + p.y < 1.0));
    }
}
