//! Data with a known truth: spheres, sparse maps, a city.

pub mod city;
pub mod sparse;
pub mod spheres;

use glam::Vec3;

/// The unit vector at an angle from +z and an azimuth from +x towards +y.
fn direction(from_up: f32, azimuth: f32) -> Vec3 {
    let ((sin, cos), (y, x)) = (from_up.sin_cos(), azimuth.sin_cos());
    Vec3::new(sin * x, sin * y, cos)
}
