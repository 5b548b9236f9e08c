//! The light of a scene, where it is known, and what of it reaches each triangle.

use glam::Vec3;
use serde::Serialize;

use super::{Choice, Fault};
use crate::base::ids::TriangleId;
use crate::render::Shares;
use crate::scene::Mesh;
use crate::scene::light::{LocalLight, Sun};
use crate::trace::Bvh;

/// Section `[light]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// Whether the light is known.
    pub mode: Mode,
    /// Towards the sun, in the mesh's coordinates; any length but 0, which stands for none given.
    pub sun: [f64; 3],
    /// Radiance of a white Lambertian that faces the sun, sky aside, linear RGB.
    pub color: [f64; 3],
    /// Radiance of the sky, taken to be the same all over, linear RGB; what a white Lambertian under all of it has, too.
    pub sky: [f64; 3],
}

/// Whether the light is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// It is not: the estimator sees reflectance maps alone.
    Unknown,
    /// Sun and sky are given.
    Known,
}

impl Choice for Mode {
    const NAMES: &'static [(&'static str, Self)] = &[("unknown", Mode::Unknown), ("known", Mode::Known)];
}

impl Default for Config {
    fn default() -> Self {
        Config { mode: Mode::Unknown, sun: [0.0; 3], color: [1.0; 3], sky: [0.0; 3] }
    }
}

impl Config {
    /// What is wrong with it.
    pub fn check(&self) -> Vec<Fault> {
        let mut faults = Vec::new();
        let length = self.sun.iter().map(|v| v * v).sum::<f64>();
        if self.mode == Mode::Known && !(length.is_finite() && length > 0.0) {
            let rule =
                "must point towards the sun where mode = \"known\", in the mesh's coordinates, as [0.3, -0.5, 0.8]";
            faults.push(Fault::new("sun", rule, format!("{:?}", self.sun)));
        }
        for (key, values) in [("color", self.color), ("sky", self.sky)] {
            if !values.iter().all(|v| (0.0..=1e3).contains(v)) {
                faults.push(Fault::new(key, "must be three numbers, 0 to 1000", format!("{values:?}")));
            }
        }
        faults
    }
}

impl Config {
    /// The sun, and the sky's radiance.
    pub fn sun_and_sky(&self) -> (Sun, Vec3) {
        let vector = |v: [f64; 3]| Vec3::from_array(v.map(|v| v as f32));
        (Sun { direction: vector(self.sun).normalize_or_zero(), color: vector(self.color) }, vector(self.sky))
    }
}

/// Rays that find a triangle's share of the sky.
const SKY_RAYS: u32 = 32;

/// A known light over a scene.
pub struct SceneLight<'a> {
    mesh: &'a Mesh,
    bvh: &'a Bvh,
    sun: Sun,
    sky: Vec3,
    up: Vec3,
    shares: Shares,
}

impl<'a> SceneLight<'a> {
    /// The light of the configuration over a mesh; the sky is the half about `up`.
    pub fn new(config: &Config, mesh: &'a Mesh, bvh: &'a Bvh, up: [f64; 3]) -> Self {
        let (sun, sky) = config.sun_and_sky();
        let up = Vec3::from_array(up.map(|v| v as f32)).normalize_or_zero();
        let rays = if sky == Vec3::ZERO { 0 } else { SKY_RAYS };
        SceneLight { mesh, bvh, sun, sky, up, shares: Shares::new(mesh, rays) }
    }

    /// What of it reaches a triangle; nothing one without area.
    pub fn local(&self, t: TriangleId) -> LocalLight {
        let Some(frame) = self.mesh.lobe_frame(t) else {
            return LocalLight { direction: Vec3::Z, sun: Vec3::ZERO, sky: Vec3::ZERO };
        };
        LocalLight {
            direction: frame.to_local(self.sun.direction),
            sun: self.sun.color * self.shares.sun(self.mesh, self.bvh, self.sun.direction, t),
            sky: self.sky * self.shares.sky(self.mesh, self.bvh, self.up, t),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_known_sun_has_a_direction() {
        assert_eq!(Config::default().check(), []);
        let known = Config { mode: Mode::Known, ..Config::default() };
        assert_eq!(known.check().iter().map(|f| f.key).collect::<Vec<_>>(), ["sun"]);
        assert_eq!(Config { sun: [0.0, 0.0, -2.0], ..known.clone() }.check(), []);
        let dark = Config { color: [-1.0, 0.0, 0.0], sky: [f64::NAN; 3], sun: [1.0; 3], ..known };
        assert_eq!(dark.check().iter().map(|f| f.key).collect::<Vec<_>>(), ["color", "sky"]);
    }

    #[test]
    fn a_roof_shades_what_lies_under_it() {
        // A floor, a roof over it that the sun overhead does not pass, and a floor beside them.
        let corner = |z: f64, half: f64| [[-half, -half, z], [half, -half, z], [-half, half, z]].map(DVec3::from);
        let (floor, roof) = (corner(0.0, 1.0), corner(1.0, 1.5));
        let beside = floor.map(|p| p + DVec3::X * 9.0);
        let mesh = Mesh::new(&[floor, roof, beside].concat(), vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]]).unwrap();
        let bvh = Bvh::build(&mesh);
        let config = Config { mode: Mode::Known, sun: [0.0, 0.0, 3.0], color: [1.0; 3], sky: [0.5; 3] };
        let light = SceneLight::new(&config, &mesh, &bvh, [0.0, 0.0, 1.0]);
        let [under, roof, open] = [0, 1, 2].map(|t| light.local(t));
        assert_eq!((under.sun, roof.sun, open.sun), (Vec3::ZERO, Vec3::ONE, Vec3::ONE));
        assert!(under.sky.x < 0.4 && roof.sky.x == 0.5 && open.sky.x > 0.45, "{under:?} {open:?}");
        assert!((open.direction - Vec3::Z).length() < 1e-6);
    }
}
