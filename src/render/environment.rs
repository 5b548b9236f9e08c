//! The light a scene stands in: a sun, and a sky of constant radiance above the horizon.
//!
//! What a surface sends back of the sky is approximated. Its diffuse part is exact up to the sampling: kd times the
//! cosine-weighted share of the sky that the triangle sees. Its specular part is the lobe's directional albedo (the
//! Fresnel-weighted share that a surface under a full sky reflects towards the viewer) times the same share, as if the
//! blocked directions were spread evenly. Light from surface to surface is left out.

use glam::Vec3;

use crate::base::Array;
use crate::base::ids::TriangleId;
use crate::scene::Material;
use crate::scene::brdf::{self, sky_specular};
use crate::scene::light::Sun;
use crate::scene::reflectance::LobeFrame;

/// A sun and a sky.
#[derive(Debug, Clone, PartialEq)]
pub struct Lighting {
    /// The sun; its shadows are cast.
    pub sun: Sun,
    /// The sky's radiance, linear RGB; what a white Lambertian under all of it has, too.
    pub sky: Vec3,
    /// Towards the zenith, unit: the sky is the hemisphere about it.
    pub up: Vec3,
    /// What rays that leave the mesh see, linear RGB.
    pub background: Vec3,
    /// The share of the sky that each triangle sees, in [0, 1], from `visibility`; empty where all see all of it.
    pub visibility: Array<f32>,
}

impl Lighting {
    /// A sun and a sky over z, all of it seen from everywhere.
    pub fn new(sun: Sun, sky: Vec3) -> Lighting {
        Lighting { sun, sky, up: Vec3::Z, background: sky, visibility: Vec::new().into() }
    }

    /// Radiance that a triangle sends back of the sky alone; `cos` is that of the viewer to the normal, in [0, 1].
    #[inline]
    pub fn ambient(&self, triangle: TriangleId, m: &Material, cos: f32) -> Vec3 {
        let share = self.visibility.get(triangle as usize).copied().unwrap_or(1.0);
        self.sky * share * (Vec3::from(m.kd) + Vec3::from(m.ks) * sky_specular(m.r, cos))
    }
}

/// The sun's radiance reflected towards `wo`, unshadowed; directions in the world, `frame` the triangle's.
#[inline]
pub fn sunlit(sun: &Sun, m: &Material, frame: &LobeFrame, wo: Vec3) -> Vec3 {
    sun.color * brdf::radiance(m, frame.to_local(sun.direction), frame.to_local(wo))
}
