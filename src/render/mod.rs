//! Pictures of a mesh with materials, and the errors of pictures and of materials.
//!
//! All pictures are linear radiance in the units of `scene`: a white Lambertian that faces the sun has radiance 1. Light
//! arrives from the sun (with cast shadows) and from a sky of constant radiance; light from surface to surface is left
//! out.

pub(crate) mod environment;
pub(crate) mod metrics;
pub(crate) mod pictures;
pub(crate) mod relight;
pub(crate) mod similarity;
#[cfg(test)]
mod tests;

pub(crate) use environment::Lighting;
pub(crate) use relight::relight;
