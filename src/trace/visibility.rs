//! The share of the sky, and of the sun, that each triangle sees.

use std::ops::Range;

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use super::{Bvh, Ray, parallel};
use crate::base::convert::to_u32;
use crate::base::ids::TriangleId;
use crate::scene::Mesh;
use crate::scene::brdf::radical_inverse;

/// Rays a triangle that find its share of the sky, unless a finer share is asked for.
pub(crate) const SKY_RAYS: u32 = 32;

/// The distance at which rays start from the surface they leave: farther than rounding moves a hit on this mesh.
pub(crate) fn offset(mesh: &Mesh) -> f32 {
    mesh.positions.iter().fold(0.0_f32, |far, p| far.max(p.abs().max_element())) * 1e-5
}

/// Finds by rays the share of the light that reaches a triangle.
#[derive(Debug)]
pub(crate) struct Shares {
    /// Directions in a triangle's own frame, as dense as their cosine, and where on the triangle each ray starts.
    sky: Vec<(Vec3, DVec2)>,
    offset: f32,
}

impl Shares {
    /// Prepares `rays` rays a triangle from points spread over it. In a triangle's own frame the rays are the same for every
    /// triangle.
    pub(crate) fn new(mesh: &Mesh, rays: u32) -> Shares {
        Shares { sky: (0..rays).map(|k| (cosine_direction(k, rays), spread(k))).collect(), offset: offset(mesh) }
    }

    /// The cosine-weighted share of the sky about `up` that a triangle sees; 0 for a triangle without area. Rays below the
    /// horizon see no sky, even where they leave the mesh.
    pub(crate) fn sky(&self, mesh: &Mesh, bvh: &Bvh, up: Vec3, t: TriangleId) -> f32 {
        let Some(frame) = mesh.lobe_frame(t) else { return 0.0 };
        let free = self.sky.iter().filter(|(local, at)| {
            let direction = frame.to_world(*local);
            if direction.dot(up) <= 0.0 {
                return false;
            }
            let origin = point(mesh.corners(t), *at) + frame.z * self.offset;
            !bvh.occluded(&Ray { origin, direction }, f32::INFINITY)
        });
        free.count() as f32 / self.sky.len().max(1) as f32
    }

    /// The share of a triangle's front that the sun reaches; 0 where the triangle faces away.
    pub(crate) fn sun(&self, mesh: &Mesh, bvh: &Bvh, sun: Vec3, t: TriangleId) -> f32 {
        let Some(normal) = mesh.normal(t).filter(|normal| normal.dot(sun) > 0.0) else { return 0.0 };
        let corners = mesh.corners(t);
        let origins: [Vec3; 16] = std::array::from_fn(|k| point(corners, spread(to_u32(k))) + normal * self.offset);
        let mut dark = [false; 16];
        parallel::occluded(bvh, sun, &origins, &mut dark);
        dark.iter().filter(|dark| !**dark).count() as f32 / 16.0
    }
}

/// The share of the sky that each of these triangles sees, in order, found by `rays` rays a triangle.
pub(crate) fn sky_visibility(mesh: &Mesh, bvh: &Bvh, up: Vec3, rays: u32, triangles: Range<usize>) -> Vec<f32> {
    let shares = Shares::new(mesh, rays);
    triangles.into_par_iter().map(|t| shares.sky(mesh, bvh, up, TriangleId::at(t))).collect()
}

/// The point at these shares of the triangle's edges from its first corner.
fn point([a, b, c]: [Vec3; 3], at: DVec2) -> Vec3 {
    let at = at.as_vec2();
    a + (b - a) * at.x + (c - a) * at.y
}

/// The `k`-th of `n` directions about +z, as dense as their cosine: a Hammersley set on the disk, lifted (Malley).
fn cosine_direction(k: u32, n: u32) -> Vec3 {
    let (radius, turn) = (((k as f32 + 0.5) / n as f32).sqrt(), std::f32::consts::TAU * radical_inverse(k));
    Vec3::new(radius * turn.cos(), radius * turn.sin(), (1.0 - radius * radius).max(0.0).sqrt())
}

/// The `k`-th of a sequence of points spread over the triangle (0,0) (1,0) (0,1), slightly inside its edges: the R2
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
