//! The material and the light of a sample, drawn before the sample's views.

use std::f32::consts::{FRAC_PI_2, TAU};

use clap::ValueEnum;
use glam::Vec3;
use rand::{Rng, RngExt};

use super::flight::bell;
use crate::scene::light::LocalLight;
use crate::scene::reflectance::LobeFrame;
use crate::scene::{Material, brdf};
use crate::synth::direction;

/// The distribution of materials and lights.
///
/// | prior   | materials                                    | sun                                      | in shadow              |
/// |---------|----------------------------------------------|------------------------------------------|------------------------|
/// | uniform | uniform in [0, 1]^7                          | uniform over the hemisphere above the    | 1 in 9                 |
/// |         |                                              | surface, cos from 0.05 up                |                        |
/// | outdoor | dark more often than bright, little colour,  | 15 to 80 degrees above the horizon, and  | what faces away, and a |
/// |         | matt and rough more often than glossy        | where it then stands to the surface      | fifth of the others    |
/// | mixed   | half of them uniform, half outdoor           | as outdoor                               | as outdoor             |
///
/// In all priors a sky of one colour, at most 0.3, is seen in part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum Prior {
    /// Any material, any light
    #[default]
    Uniform,
    /// Materials of outdoor scenes, the sun above the horizon
    Outdoor,
    /// The light of outdoor scenes, half of the materials any
    Mixed,
}

/// A surface's material and light, the same in all frames of one flight.
pub(super) struct Lit {
    pub material: Material,
    pub light: LocalLight,
}

impl Lit {
    /// Draws material and light for a surface with this frame.
    pub(super) fn draw(prior: Prior, frame: &LobeFrame, rng: &mut impl Rng) -> Lit {
        let anything = match prior {
            Prior::Uniform => return Lit { material: any(rng), light: anywhere(rng) },
            Prior::Outdoor => false,
            Prior::Mixed => rng.random(),
        };
        let material = if anything { any(rng) } else { outdoor(rng) };
        Lit { material, light: above(frame, rng) }
    }

    /// Radiance towards `wo`. The reflection of the sky is taken as the sky's radiance times Fresnel's factor at `wo`.
    pub(super) fn radiance(&self, wo: Vec3) -> Vec3 {
        let (m, LocalLight { direction, sun, sky }) = (&self.material, self.light);
        let direct = if sun == Vec3::ZERO { sun } else { sun * brdf::radiance(m, direction, wo) };
        direct + sky * (Vec3::from(m.kd) + Vec3::from(m.ks) * brdf::fresnel(wo.z.clamp(0.0, 1.0)))
    }
}

/// Any material.
fn any(rng: &mut impl Rng) -> Material {
    Material::from(std::array::from_fn::<f32, 7, _>(|_| rng.random()))
}

/// A material of outdoor scenes: albedo about 0.2 and log-normal, a slight tint, a specular part that is mostly grey and
/// weak, and rougher the weaker it is.
fn outdoor(rng: &mut impl Rng) -> Material {
    let albedo = 0.2 * (0.7 * bell(rng)).exp();
    let tint = rng.random_range(0.0..0.35f32);
    let kd = [0; 3].map(|_| (albedo * (1.0 + tint * bell(rng))).clamp(0.0, 1.0));
    let gloss = rng.random::<f32>().powf(1.7);
    let tint = if rng.random_bool(0.1) { 0.2 } else { 0.0 };
    let ks = [0; 3].map(|_| (gloss * (1.0 + tint * bell(rng))).clamp(0.0, 1.0));
    Material { kd, ks, r: (0.8 - 0.5 * gloss + 0.2 * bell(rng)).clamp(0.0, 1.0) }
}

/// A sun anywhere above the surface, and a sky.
fn anywhere(rng: &mut impl Rng) -> LocalLight {
    let cos = rng.random_range(0.05..1.0f32);
    let (sin_phi, cos_phi) = rng.random_range(0.0..TAU).sin_cos();
    let sin = (1.0 - cos * cos).sqrt();
    let sky = sky(rng);
    let sunlit = sky == 0.0 || rng.random_bool(0.85);
    LocalLight {
        direction: Vec3::new(sin * cos_phi, sin * sin_phi, cos),
        sun: Vec3::splat(f32::from(u8::from(sunlit))),
        sky: tinted(sky, rng),
    }
}

/// A sun above the horizon, in the surface's frame, and a sky.
fn above(frame: &LobeFrame, rng: &mut impl Rng) -> LocalLight {
    let from_up = FRAC_PI_2 - rng.random_range(15f32..80.0).to_radians();
    let direction = frame.to_local(direction(from_up, rng.random_range(0.0..TAU)));
    let sunlit = direction.z > 0.0 && rng.random_bool(0.8);
    let sky = sky(rng);
    LocalLight { direction, sun: Vec3::splat(f32::from(u8::from(sunlit))), sky: tinted(sky, rng) }
}

/// Radiance of the sky that reaches a surface; 0 for a quarter of the surfaces.
fn sky(rng: &mut impl Rng) -> f32 {
    match rng.random_bool(0.25) {
        true => 0.0,
        false => rng.random_range(0.0..0.3f32) * rng.random_range(0.3..1.0),
    }
}

/// The colour of a sky of this radiance.
fn tinted(sky: f32, rng: &mut impl Rng) -> Vec3 {
    sky * Vec3::new(rng.random_range(0.75..1.0), rng.random_range(0.85..1.0), 1.0)
}
