//! The model's factors, and their product.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::Vec3;

use crate::scene::Material;

/// Index of refraction of the dielectric interface; F at normal incidence is 0.04.
pub(crate) const ETA: f32 = 1.5;

/// Unpolarised Fresnel reflectance of the interface, entering from air; `cos` in [0, 1].
#[inline]
pub(crate) fn fresnel(cos: f32) -> f32 {
    let transmitted = (1.0 - (1.0 - cos * cos) / (ETA * ETA)).sqrt();
    let parallel = (ETA * cos - transmitted) / (ETA * cos + transmitted);
    let perpendicular = (cos - ETA * transmitted) / (cos + ETA * transmitted);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// Trowbridge-Reitz density of facet normals. `cos2` and `sin2` are of the angle between `h` and the normal: both are
/// asked for because `1 - cos2` has no digits left where a smooth surface's lobe lives.
#[inline]
pub(crate) fn distribution(alpha: f32, cos2: f32, sin2: f32) -> f32 {
    let a2 = alpha * alpha;
    let d = sin2 + cos2 * a2;
    a2 * FRAC_1_PI / (d * d)
}

/// Smith's Lambda of a direction with cosine `cos` to the normal, in (0, 1].
#[inline]
pub(crate) fn lambda(alpha: f32, cos: f32) -> f32 {
    let c2 = cos * cos;
    0.5 * ((1.0 + alpha * alpha * (1.0 - c2).max(0.0) / c2).sqrt() - 1.0)
}

/// The specular lobe for `ks = 1`, per steradian; 0 where either direction is not above the surface.
#[inline]
pub(crate) fn specular(alpha: f32, wi: Vec3, wo: Vec3) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return 0.0;
    }
    let h = (wi + wo).normalize();
    let d = distribution(alpha, h.z * h.z, h.x * h.x + h.y * h.y);
    let g = 1.0 / (1.0 + lambda(alpha, wi.z) + lambda(alpha, wo.z));
    d * g * fresnel(wi.dot(h).min(1.0)) / (4.0 * wi.z * wo.z)
}

/// The BRDF, per steradian, linear RGB; 0 where either direction is not above the surface.
pub(crate) fn evaluate(m: &Material, wi: Vec3, wo: Vec3) -> Vec3 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return Vec3::ZERO;
    }
    Vec3::from(m.kd) * FRAC_1_PI + Vec3::from(m.ks) * specular(m.alpha(), wi, wo)
}

/// Radiance that leaves towards `wo` under a white directional light from `wi` with irradiance pi.
pub(crate) fn radiance(m: &Material, wi: Vec3, wo: Vec3) -> Vec3 {
    PI * evaluate(m, wi, wo) * wi.z.max(0.0)
}
