//! A sun: a directional light with irradiance pi on a surface that faces it, so that a white Lambertian surface there has
//! radiance 1. And the light of sun and sky that reaches one triangle.

use glam::Vec3;

/// A directional light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    /// Unit vector towards the light.
    pub direction: Vec3,
    /// Colour; white is `[1, 1, 1]`. The irradiance at normal incidence is pi times the colour.
    pub color: Vec3,
}

/// The light that reaches one triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalLight {
    /// Unit vector towards the sun, in the frame of the triangle's map.
    pub direction: Vec3,
    /// The sun's colour times the share of the triangle that the sun reaches, linear RGB.
    pub sun: Vec3,
    /// The sky's radiance times the share of the sky that the triangle sees, linear RGB.
    pub sky: Vec3,
}
