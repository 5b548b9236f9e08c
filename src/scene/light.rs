//! A sun: directional, with irradiance pi on a surface that faces it, so that a white Lambertian there has radiance 1.

use glam::Vec3;

/// A directional light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Unit vector towards the light.
    pub direction: Vec3,
    /// Colour; white is `[1, 1, 1]`, and irradiance at normal incidence is pi times it.
    pub color: Vec3,
}
