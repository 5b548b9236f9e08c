//! The light a scene stands in: a sun, and a sky of constant radiance above the horizon.
//!
//! The reflection of the sky is approximated. The diffuse part is exact up to the sampling: kd times the cosine-weighted
//! share of the sky that the triangle sees. The specular part is the lobe's directional albedo (the Fresnel-weighted
//! share that a surface under a full sky reflects towards the viewer) times the same share, as if the blocked directions
//! were spread evenly. Light from surface to surface
//! is left out, or taken to be the same all over.

use glam::Vec3;

use crate::base::Array;
use crate::base::ids::TriangleId;
use crate::scene::Material;
use crate::scene::brdf::{self, sky_specular};
use crate::scene::light::Sun;
use crate::scene::reflectance::LobeFrame;

/// A sun and a sky.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lighting {
    /// The sun, which casts shadows.
    pub sun: Sun,
    /// The sky's radiance, linear RGB; a white Lambertian under an open sky has the same.
    pub sky: Vec3,
    /// The radiance of the scene's own surfaces, linear RGB: what a triangle sees where it sees no sky; 0 to leave that out.
    pub bounce: Vec3,
    /// The unit vector to the zenith, the middle of the sky's hemisphere.
    pub up: Vec3,
    /// The radiance seen by rays that leave the mesh, linear RGB.
    pub background: Vec3,
    /// The share of the sky that each triangle sees, in [0, 1], from `visibility`; empty where every triangle sees the
    /// whole sky.
    pub visibility: Array<f32>,
}

impl Lighting {
    /// Light of a sun and of a sky about +z that every triangle sees whole.
    pub(crate) fn new(sun: Sun, sky: Vec3) -> Lighting {
        Lighting { sun, sky, bounce: Vec3::ZERO, up: Vec3::Z, background: sky, visibility: Vec::new().into() }
    }

    /// The radiance that a triangle reflects of the sky alone; `cos`, in [0, 1], is the cosine between viewer and normal.
    #[inline]
    pub(crate) fn ambient(&self, triangle: TriangleId, m: &Material, cos: f32) -> Vec3 {
        let share = self.visibility.get(triangle.index()).copied().unwrap_or(1.0);
        (self.sky * share + self.bounce * (1.0 - share))
            * (Vec3::from(m.kd) + Vec3::from(m.ks) * sky_specular(m.r, cos))
    }
}

/// The radiance that a triangle reflects of the unshadowed sun towards `wo`. Directions are the world's, `frame` is the
/// triangle's.
#[inline]
pub(crate) fn sunlit(sun: &Sun, m: &Material, frame: &LobeFrame, wo: Vec3) -> Vec3 {
    sun.color * brdf::radiance(m, frame.to_local(sun.direction), frame.to_local(wo))
}
