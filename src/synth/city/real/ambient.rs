//! What a triangle is lit by besides the sun: the sky where it is seen, and where another surface is, the light that this one has
//! from sun and sky and passes on. Once: what it has from third surfaces is left out.

use glam::Vec3;
use rayon::prelude::*;

use super::sky::{Sky, cosine_direction};
use crate::base::ids::TriangleId;
use crate::base::{Error, Result};
use crate::scene::Mesh;
use crate::scene::light::Sun;
use crate::trace::{Bvh, Ray};

/// Rays a triangle.
const RAYS: u32 = 48;

/// Triangles between two questions whether to stop.
const BATCH: usize = 1 << 15;

/// The radiance of the land beyond the mesh.
pub(super) const LAND: Vec3 = Vec3::new(0.16, 0.17, 0.14);

/// The radiance of a white Lambertian in each triangle's place, without the sun's own light. `kd` gives a triangle's albedo.
///
/// # Errors
/// `Error::Interrupted` where `stop` says so.
pub(super) fn ambient(
    mesh: &Mesh,
    bvh: &Bvh,
    kd: impl Fn(usize) -> Vec3 + Sync,
    (sun, sky): (&Sun, &Sky),
    offset: f32,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Vec3>> {
    let open = |found: Option<TriangleId>, direction: Vec3| match found {
        Some(_) => Vec3::ZERO,
        None if direction.z > 0.0 => sky.radiance(direction),
        None => LAND,
    };
    let gather = |of: &(dyn Fn(&Ray) -> Vec3 + Sync), t: usize| {
        let t = TriangleId::at(t);
        let Some(frame) = mesh.lobe_frame(t) else { return Vec3::ZERO };
        let [a, b, c] = mesh.corners(t);
        let origin = (a + b + c) / 3.0 + frame.z * offset;
        let ray = |k| Ray { origin, direction: frame.to_world(cosine_direction(k, RAYS)) };
        (0..RAYS).map(|k| of(&ray(k))).sum::<Vec3>() / RAYS as f32
    };
    let each = |of: &(dyn Fn(&Ray) -> Vec3 + Sync)| -> Result<Vec<Vec3>> {
        let mut all = Vec::with_capacity(mesh.len());
        for first in (0..mesh.len()).step_by(BATCH) {
            if stop() {
                return Err(Error::Interrupted);
            }
            let batch = first..mesh.len().min(first + BATCH);
            all.par_extend(batch.into_par_iter().map(|t| gather(of, t)));
        }
        Ok(all)
    };
    let direct = each(&|ray| open(bvh.nearest(ray, f32::INFINITY).map(|hit| hit.triangle), ray.direction))?;
    let passed_on = each(&|ray| {
        let Some(hit) = bvh.nearest(ray, f32::INFINITY) else { return Vec3::ZERO };
        let Some(normal) = mesh.normal(hit.triangle) else { return Vec3::ZERO };
        let normal = if normal.dot(ray.direction) > 0.0 { -normal } else { normal };
        let cos = normal.dot(sun.direction);
        let towards = Ray { origin: ray.at(hit.t) + normal * offset, direction: sun.direction };
        let lit = if cos > 0.0 && !bvh.occluded(&towards, f32::INFINITY) { cos } else { 0.0 };
        kd(hit.triangle.index()) * (direct[hit.triangle.index()] + sun.color * lit)
    })?;
    Ok(direct.into_iter().zip(passed_on).map(|(direct, passed_on)| direct + passed_on).collect())
}
