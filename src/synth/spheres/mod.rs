//! Dense reflectance maps of known materials under one light, in the layout of the published training set (section 3.1 of
//! the publication) or in that of scenes.
//!
//! | layout | a bin is                    | fixed            | filled bins                 |
//! |--------|-----------------------------|------------------|-----------------------------|
//! | lobe   | a direction of reflection   | normal +z, light | the front half, rows 0..30  |
//! | sphere | a normal of the unit sphere | camera, light    | those that the camera sees  |
//!
//! Values are linear radiance at the bin's middle, not clipped; bins that are not filled are 0. A folder of maps holds
//!
//! ```text
//! maps.npy [N,3,60,120]   materials.npy [N,7]   lights.npy [N,3]   views.npy [N,3] (sphere only)
//! ```
//!
//! Directions are unit vectors in the map's frame. A view is the direction from the sphere's centre to the camera; [`Camera`]
//! gives the camera's distance.

mod published;
mod write;

pub(crate) use published::Published;
pub(crate) use write::Samples;

use std::f32::consts::{PI, TAU};
use std::sync::LazyLock;

use clap::ValueEnum;
use glam::Vec3;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::scene::reflectance::{BINS, FRONT_BINS, direction_of};
use crate::scene::{Material, brdf};

/// Floats of a map: three planes of bins.
pub const MAP: usize = 3 * BINS;

/// Distance of the perspective camera from the centre of the unit sphere: the sphere lies within 14.5 degrees of the
/// camera's axis. The publication names no distance.
const DISTANCE: f32 = 4.0;

/// The direction at the middle of every bin.
static DIRECTIONS: LazyLock<Vec<Vec3>> = LazyLock::new(|| (0..).take(BINS).map(direction_of).collect());

/// Draws a `lobe` map over the contents of `out`.
pub(crate) fn lobe(m: &Material, light: Vec3, out: &mut [f32; MAP]) {
    out.fill(0.0);
    for (bin, &towards) in DIRECTIONS[..FRONT_BINS].iter().enumerate() {
        put(out, bin, brdf::radiance(m, light, towards));
    }
}

/// The camera that looks at a sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Camera {
    /// A camera infinitely far away, which sees half of the sphere
    #[default]
    Orthographic,
    /// A camera four radii from the centre, which sees the sphere within 75.5 degrees of the camera's axis
    Perspective,
}

impl Camera {
    /// The unit vector from the sphere's point with this normal to a camera in direction `view`.
    fn towards(self, view: Vec3, normal: Vec3) -> Vec3 {
        match self {
            Camera::Orthographic => view,
            Camera::Perspective => (DISTANCE * view - normal).normalize(),
        }
    }
}

/// Draws a `sphere` map over the contents of `out`.
pub(crate) fn sphere(m: &Material, light: Vec3, view: Vec3, camera: Camera, out: &mut [f32; MAP]) {
    out.fill(0.0);
    let (alpha, kd, ks) = (m.alpha(), Vec3::from(m.kd), Vec3::from(m.ks));
    let facet = |wo: Vec3| {
        let h = (light + wo).normalize_or_zero();
        (h, brdf::fresnel(light.dot(h).clamp(0.0, 1.0)))
    };
    // From afar the half vector, and with it Fresnel's term, is the same all over the sphere.
    let same = (camera == Camera::Orthographic).then(|| facet(view));
    for (bin, &normal) in DIRECTIONS.iter().enumerate() {
        let wo = camera.towards(view, normal);
        let (cos_i, cos_o) = (normal.dot(light), normal.dot(wo));
        if cos_i <= 0.0 || cos_o <= 0.0 {
            continue;
        }
        let (h, fresnel) = same.unwrap_or_else(|| facet(wo));
        let d = brdf::distribution(alpha, normal.dot(h).powi(2), normal.cross(h).length_squared());
        let g = 1.0 / (1.0 + brdf::lambda(alpha, cos_i) + brdf::lambda(alpha, cos_o));
        put(out, bin, kd * cos_i + ks * (PI * d * g * fresnel / (4.0 * cos_o)));
    }
}

/// Sets a bin.
fn put(out: &mut [f32; MAP], bin: usize, rgb: Vec3) {
    (out[bin], out[BINS + bin], out[2 * BINS + bin]) = rgb.into();
}

/// The material, light and view that a map is drawn from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// The material.
    pub material: Material,
    /// The unit vector to the light.
    pub light: Vec3,
    /// The unit vector to the camera; only spheres have a camera.
    pub view: Vec3,
}

/// The layout of maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// The `lobe` layout.
    Lobe,
    /// The `sphere` layout, as this camera sees the sphere.
    Sphere(Camera),
}

impl Sample {
    /// The random sample at an index of a seed.
    pub fn draw(seed: u64, index: u64) -> Sample {
        let mut rng = Pcg64Mcg::seed_from_u64(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(index));
        let material = Material::from(std::array::from_fn(|_| rng.random_range(0.0..=1.0)));
        Sample { material, light: hemisphere(&mut rng), view: hemisphere(&mut rng) }
    }

    /// Draws the sample's map over the contents of `out`.
    pub fn render(&self, layout: Layout, out: &mut [f32; MAP]) {
        match layout {
            Layout::Lobe => lobe(&self.material, self.light, out),
            Layout::Sphere(camera) => sphere(&self.material, self.light, self.view, camera, out),
        }
    }
}

/// A unit vector, uniform over the half about +z.
fn hemisphere(rng: &mut impl Rng) -> Vec3 {
    let (z, phi) = (rng.random_range(0.0..=1.0f32), rng.random_range(0.0..TAU));
    let s = (1.0 - z * z).sqrt();
    Vec3::new(s * phi.cos(), s * phi.sin(), z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blank() -> Box<[f32; MAP]> {
        vec![f32::NAN; MAP].into_boxed_slice().try_into().unwrap()
    }

    #[test]
    fn a_matt_lobe_is_even_and_a_matt_sphere_falls_off_with_the_cosine() {
        let m = Material { kd: [0.2, 0.4, 0.8], ks: [0.0; 3], r: 0.5 };
        let (light, view) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, -0.6, 0.8));
        let mut map = blank();
        lobe(&m, light, &mut map);
        for c in 0..3 {
            let plane = &map[c * BINS..][..BINS];
            assert!(plane[..FRONT_BINS].iter().all(|v| (v - 0.8 * m.kd[c]).abs() < 1e-6));
            assert!(plane[FRONT_BINS..].iter().all(|v| *v == 0.0));
        }
        sphere(&m, light, view, Camera::Orthographic, &mut map);
        for (bin, n) in DIRECTIONS.iter().enumerate() {
            let lit = n.dot(light) > 0.0 && n.dot(view) > 0.0;
            let expected = if lit { 0.4 * n.dot(light) } else { 0.0 };
            assert!((map[BINS + bin] - expected).abs() < 1e-6, "bin {bin}");
        }
    }

    #[test]
    fn both_layouts_are_the_same_reflection() {
        // A sphere's point, turned so that its normal is +z, reflects as a lobe does.
        let m = Material { kd: [0.3; 3], ks: [0.9, 0.5, 0.1], r: 0.4 };
        let (light, view) = (Vec3::new(0.48, 0.6, 0.64), Vec3::new(-0.6, 0.0, 0.8));
        let mut map = blank();
        for camera in [Camera::Orthographic, Camera::Perspective] {
            sphere(&m, light, view, camera, &mut map);
            let mut compared = 0;
            for (bin, &normal) in DIRECTIONS.iter().enumerate() {
                let wo = camera.towards(view, normal);
                if normal.dot(light) <= 0.0 || normal.dot(wo) <= 0.05 {
                    continue;
                }
                let turn = glam::Quat::from_rotation_arc(normal, Vec3::Z);
                let expected = brdf::radiance(&m, turn * light, turn * wo);
                let found = Vec3::new(map[bin], map[BINS + bin], map[2 * BINS + bin]);
                assert!((found - expected).abs().max_element() < 2e-4 * (1.0 + expected.max_element()), "bin {bin}");
                compared += 1;
            }
            assert!(compared > 800);
        }
    }

    #[test]
    fn a_near_camera_sees_less_and_a_matt_sphere_the_same() {
        let m = Material { kd: [0.5; 3], ks: [0.0; 3], r: 1.0 };
        let (mut far, mut near) = (blank(), blank());
        sphere(&m, Vec3::Z, Vec3::Z, Camera::Orthographic, &mut far);
        sphere(&m, Vec3::Z, Vec3::Z, Camera::Perspective, &mut near);
        for (bin, n) in DIRECTIONS.iter().enumerate() {
            let expected = if n.z > 1.0 / DISTANCE { far[bin] } else { 0.0 };
            assert!((near[bin] - expected).abs() < 1e-6, "bin {bin}");
        }
        assert!(near.iter().filter(|v| **v > 0.0).count() < far.iter().filter(|v| **v > 0.0).count());
    }
}
