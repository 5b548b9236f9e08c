//! The radiance of what a ray meets.

use glam::Vec3;

use super::ambient::LAND;
use super::pane::{Clear, water, window};
use super::sky::Sky;
use super::texture;
use crate::base::convert::Cut;
use crate::base::ids::TriangleId;
use crate::scene::brdf::{self, sky_specular};
use crate::scene::light::Sun;
use crate::scene::reflectance::LobeFrame;
use crate::scene::{Material, Mesh};
use crate::synth::city::finish::Substance;
use crate::trace::{Bvh, Hit, Ray};

/// Columns of a row of the town: its material, and the number of its substance.
pub(in crate::synth::city) const COLUMNS: usize = Material::LEN + 1;

/// Roughnesses below which a surface mirrors what stands before it, and above which it does not.
const MIRRORS: [f32; 2] = [0.25, 0.45];

/// The town in its light.
pub(super) struct Lit<'a> {
    pub mesh: &'a Mesh,
    pub bvh: &'a Bvh,
    /// A row for each triangle.
    pub rows: &'a [[f32; COLUMNS]],
    pub sun: Sun,
    pub sky: Sky,
    /// The radiance of a white Lambertian in each triangle's place, without the sun's own light.
    pub ambient: Vec<Vec3>,
    /// How far from a surface rays start.
    pub offset: f32,
}

/// A point that a ray met.
pub(super) struct Point {
    pub triangle: TriangleId,
    /// The point, in the mesh's coordinates relative to its origin.
    pub at: Vec3,
    /// The normal on the side that the ray came from.
    pub normal: Vec3,
    /// The ray's direction.
    pub direction: Vec3,
}

/// The row's material and substance.
pub(super) fn split(row: &[f32; COLUMNS]) -> (Material, Substance) {
    let [m @ .., number] = *row;
    (Material::from(m), Substance::numbered(usize::cut(number)))
}

impl Lit<'_> {
    /// The point where a ray from `eye` met a triangle; `None` where it met none.
    pub(super) fn point(&self, eye: Vec3, direction: Vec3, hit: &Hit) -> Option<Point> {
        let normal = hit.is_some().then(|| self.mesh.normal(hit.triangle)).flatten()?;
        let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
        Some(Point { triangle: hit.triangle, at: eye + direction * hit.t, normal, direction })
    }

    /// Where rays start that leave a point.
    pub(super) fn start(&self, point: &Point) -> Vec3 {
        point.at + point.normal * self.offset
    }

    /// The radiance of a point towards the ray's origin; `is_lit` says whether the sun reaches it.
    pub(super) fn radiance(&self, point: &Point, is_lit: bool) -> Vec3 {
        let (base, substance) = split(&self.rows[point.triangle.index()]);
        let world = self.mesh.origin.as_vec3() + point.at;
        match substance {
            Substance::Glass => self.clear(point, &window(world, point.direction, point.normal), is_lit),
            Substance::Water => self.clear(point, &water(world, point.direction, point.normal), is_lit),
            _ => self.solid(point, &texture::at(substance, &base, world), is_lit),
        }
    }

    /// The radiance of a surface of one lobe.
    fn solid(&self, point: &Point, m: &Material, is_lit: bool) -> Vec3 {
        let (ambient, wo) = (self.ambient[point.triangle.index()], -point.direction);
        let mut radiance = Vec3::from(m.kd) * ambient;
        if is_lit {
            let frame = LobeFrame::new(point.normal);
            let lobe = brdf::radiance(m, frame.to_local(self.sun.direction), frame.to_local(wo));
            radiance += self.sun.color * lobe;
        }
        let [low, high] = MIRRORS;
        let sharp = ((high - m.r) / (high - low)).clamp(0.0, 1.0);
        let around = if sharp > 0.0 {
            ambient.lerp(self.seen(self.start(point), mirror(point.direction, point.normal)), sharp)
        } else {
            ambient
        };
        radiance + Vec3::from(m.ks) * sky_specular(m.r, point.normal.dot(wo)) * around
    }

    /// The radiance of a pane or of water.
    fn clear(&self, point: &Point, clear: &Clear, is_lit: bool) -> Vec3 {
        let away = mirror(point.direction, clear.normal);
        let mut mirrored = self.seen(self.start(point), away);
        if is_lit {
            // The sun itself, as wide as its disc and the warping: brighter than any photograph shows.
            mirrored += 60.0 * self.sun.color * ((away.dot(self.sun.direction) - 0.9996) / 0.0003).clamp(0.0, 1.0);
        }
        let behind = clear.behind
            * (self.ambient[point.triangle.index()] + if is_lit { self.sun.color * 0.3 } else { Vec3::ZERO });
        mirrored * clear.mirrored + behind * (1.0 - clear.mirrored)
    }

    /// The radiance that comes along a ray, with matt surfaces.
    fn seen(&self, origin: Vec3, direction: Vec3) -> Vec3 {
        let Some(hit) = self.bvh.nearest(&Ray { origin, direction }, f32::INFINITY) else {
            return self.beyond(direction);
        };
        let Some(point) = self.point(origin, direction, &hit) else { return self.beyond(direction) };
        let (base, _) = split(&self.rows[hit.triangle.index()]);
        let cos = point.normal.dot(self.sun.direction);
        let towards = Ray { origin: self.start(&point), direction: self.sun.direction };
        let lit = if cos > 0.0 && !self.bvh.occluded(&towards, f32::INFINITY) { cos } else { 0.0 };
        Vec3::from(base.kd) * (self.ambient[hit.triangle.index()] + self.sun.color * lit)
    }

    /// The radiance of what lies beyond the mesh.
    pub(super) fn beyond(&self, direction: Vec3) -> Vec3 {
        if direction.z > 0.0 { self.sky.radiance(direction) } else { LAND }
    }
}

/// The direction mirrored at a surface.
fn mirror(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - normal * (2.0 * direction.dot(normal))
}
