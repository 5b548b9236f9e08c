//! The one reflection model: a Lambertian plus a dielectric microfacet lobe.
//!
//! Torrance and Sparrow (1967) with the distribution of Trowbridge and Reitz (1975), Smith's height-correlated
//! masking (Heitz 2014, eq. 99), and exact unpolarised Fresnel reflectance for an index of 1.5:
//!
//! ```text
//! f(wi, wo) = kd / pi + ks D(h) G(wi, wo) F(wi.h) / (4 cos_i cos_o)
//! D = a^2 / (pi ((n.h)^2 (a^2 - 1) + 1)^2)        G = 1 / (1 + L(wi) + L(wo))
//! L(w) = (sqrt(1 + a^2 tan^2 w) - 1) / 2          a = max(r^2, 1e-3)
//! ```
//!
//! Directions are unit vectors in the surface's frame, +z its normal, pointing away from the surface.

mod microfacet;
mod sky;
#[cfg(test)]
mod tests;

pub(crate) use microfacet::{distribution, fresnel, lambda, radiance};
pub(crate) use sky::{radical_inverse, sky_specular};
