//! A clear sky: bluer and darker above, white at the horizon, with a glow about the sun.

use glam::{Vec2, Vec3};

use crate::scene::brdf::radical_inverse;

/// A clear sky under a sun.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sky {
    sun: Vec3,
    scale: Vec3,
}

/// Directions that the sky's mean is taken over.
const SAMPLES: u32 = 4096;

impl Sky {
    /// The sky about +z under which a white Lambertian that sees all of it has the radiance `mean`.
    pub(super) fn new(sun: Vec3, mean: Vec3) -> Sky {
        let even = Sky { sun, scale: Vec3::ONE };
        let sum: Vec3 = (0..SAMPLES).map(|k| even.radiance(cosine_direction(k, SAMPLES))).sum();
        Sky { sun, scale: mean * SAMPLES as f32 / sum }
    }

    /// The radiance from a direction, a unit vector.
    pub(super) fn radiance(&self, from: Vec3) -> Vec3 {
        let high = from.z.max(0.0).powf(0.45);
        let gradient = Vec3::new(0.7, 0.95, 1.3) * high + Vec3::new(1.9, 1.8, 1.6) * (1.0 - high);
        let apart = from.dot(self.sun).clamp(-1.0, 1.0).acos().to_degrees();
        let glow = Vec3::new(1.0, 0.95, 0.85) * (6.0 * (-apart / 6.0).exp() + 1.2 * (-apart / 20.0).exp());
        (gradient + glow) * self.scale
    }
}

/// The `k`-th of `n` directions about +z, as dense as their cosine.
pub(super) fn cosine_direction(k: u32, n: u32) -> Vec3 {
    let (square, turn) = ((k as f32 + 0.5) / n as f32, std::f32::consts::TAU * radical_inverse(k));
    (Vec2::from_angle(turn) * square.sqrt()).extend((1.0 - square).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_white_surface_under_it_has_the_mean() {
        let (sun, mean) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.16, 0.19, 0.24));
        let sky = Sky::new(sun, mean);
        let found = (0..1024).map(|k| sky.radiance(cosine_direction(k, 1024))).sum::<Vec3>() / 1024.0;
        assert!((found / mean - 1.0).abs().max_element() < 0.02, "{found}");
        let (at_sun, above, level) = (sky.radiance(sun), sky.radiance(Vec3::Z), sky.radiance(-Vec3::X));
        assert!(at_sun.x > 3.0 * above.x && level.x > above.x && level.z / level.x < above.z / above.x);
    }
}
