//! Data with a known truth: a city with its photographs, dense maps of spheres, sparse maps as flights fill them.

pub(crate) mod city;
pub(crate) mod sparse;
pub(crate) mod spheres;

use glam::Vec3;

/// The unit vector at an angle from +z and an azimuth from +x towards +y.
fn direction(from_up: f32, azimuth: f32) -> Vec3 {
    let ((sin, cos), (y, x)) = (from_up.sin_cos(), azimuth.sin_cos());
    Vec3::new(sin * x, sin * y, cos)
}
