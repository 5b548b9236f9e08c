//! Pictures of a mesh with materials, and how far two pictures, or two lists of materials, are apart.
//!
//! Everything is linear radiance in the units of `scene`: a white Lambertian that faces the sun has radiance 1. Light
//! arrives from the sun (with cast shadows) and from a sky of constant radiance; light that bounces from surface to
//! surface is left out.

pub mod environment;
pub mod metrics;
pub mod pictures;
pub mod relight;
pub mod similarity;
#[cfg(test)]
mod tests;
pub mod visibility;

pub use environment::Lighting;
pub use relight::relight;
pub use visibility::{Shares, sky_visibility};
