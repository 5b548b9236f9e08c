//! A light over a scene, and how much of it reaches each triangle.

use glam::{DVec3, Vec3};

use crate::base::ids::TriangleId;
use crate::config::{Choice, Effect, Key, Keys, Problem, Section, Settings, Value};
use crate::scene::Mesh;
use crate::scene::light::{LocalLight, Sun};
use crate::trace::visibility::SKY_RAYS;
use crate::trace::{Bvh, Shares};

/// Section `[light]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// Where the light is known from.
    pub mode: Mode,
    /// The direction to the sun in the mesh's coordinates, of any length but 0; zeros if none is given.
    pub sun: [f64; 3],
    /// Radiance of a white Lambertian that faces the sun, without the sky's part, linear RGB.
    pub color: [f64; 3],
    /// Radiance of the sky, the same all over, linear RGB. A white Lambertian under all of it has this radiance too.
    pub sky: [f64; 3],
    /// Radiance of a white Lambertian that faces the sun, in the photographs, where the light is estimated; `None` where that is
    /// estimated too.
    pub white: Option<f64>,
}

/// Where the light is known from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Sun and sky are found in the photographs.
    Estimate,
    /// Nowhere: the light is unknown: the estimator sees reflectance maps alone.
    Unknown,
    /// Sun and sky are given.
    Known,
}

impl Choice for Mode {
    const NAMES: &'static [(&'static str, Self)] =
        &[("estimate", Mode::Estimate), ("known", Mode::Known), ("unknown", Mode::Unknown)];
}

impl Section for Config {
    const NAME: &'static str = "light";
    const ABOUT: &'static str = "The light that the photographs were taken in.";
    const KEYS: &'static [Key] = &[
        Key {
            name: "mode",
            doc: "\"estimate\": sun and sky are found in the photographs, if they can be. \"known\": the photographs were taken in \
                  the sun and sky below. \"unknown\": materials come from the reflectance maps alone. Where there is a light, \
                  [infer] estimator uses it, and the shadows that it casts.",
            value: Value::Default("\"estimate\""),
        },
        Key {
            name: "sun",
            doc: "The direction to the sun in the mesh's coordinates. Any solar calculator gives azimuth and elevation for a \
                  place and a time.",
            value: Value::Optional("[0.3, -0.5, 0.8]"),
        },
        Key {
            name: "color",
            doc: "Radiance of a white matt surface that faces the sun, without the sky's part, in the units of the photographs.",
            value: Value::Default("[1.0, 1.0, 1.0]"),
        },
        Key {
            name: "sky",
            doc: "Radiance of the sky. A white matt surface in the shade, under all of the sky, has this radiance too.",
            value: Value::Default("[0.0, 0.0, 0.0]"),
        },
        Key {
            name: "white",
            doc: "Radiance of a white matt surface that faces the sun, in the units of the photographs, with mode = \"estimate\" \
                  only. Photographs alone cannot tell a brighter sun from whiter walls; without this, a usual albedo does.",
            value: Value::Optional("1.0"),
        },
    ];

    fn read(keys: &Keys<'_>) -> Self {
        let mode = keys.choice("mode");
        let sun: [f64; 3] = keys.optional("sun").unwrap_or_default();
        let length = DVec3::from(sun).length_squared();
        let rule = "must point towards the sun where mode = \"known\", in the mesh's coordinates, as [0.3, -0.5, 0.8]";
        keys.check("sun", mode != Mode::Known || (length.is_finite() && length > 0.0), rule);
        let [color, sky] = ["color", "sky"].map(|key| {
            let radiance: [f64; 3] = keys.value(key);
            keys.check(key, radiance.iter().all(|v| (0.0..=1e3).contains(v)), "must be three numbers, 0 to 1000");
            radiance
        });
        let white: Option<f64> = keys.optional("white");
        if let Some(white) = white {
            let idle = Problem::new("has no meaning unless mode = \"estimate\"");
            let hint = "take it out, or set mode = \"estimate\"";
            keys.check("white", mode == Mode::Estimate || !keys.is_good("mode"), idle.hint(hint));
            keys.check("white", (1e-3..=1e3).contains(&white), "must be 0.001 to 1000");
        }
        Config { mode, sun, color, sky, white }
    }

    fn settings(&self) -> Settings {
        let Config { mode, sun, color, sky, white } = self;
        Settings::of(Self::NAME)
            .with("mode", mode.name(), Effect::Light)
            .with("mode", mode.name(), Effect::Look)
            .optional("white", *white, Effect::Look)
            .with("sun", sun, Effect::Light)
            .with("color", color, Effect::Light)
            .with("sky", sky, Effect::Light)
    }
}

impl Config {
    /// The light, where the configuration gives it.
    pub fn known(&self) -> Option<SunAndSky> {
        let vector = |v: [f64; 3]| DVec3::from(v).as_vec3();
        let sun = Sun { direction: vector(self.sun).normalize_or_zero(), color: vector(self.color) };
        (self.mode == Mode::Known).then(|| SunAndSky { sun, sky: vector(self.sky) })
    }
}

/// A sun, and a sky that is the same all over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunAndSky {
    /// The sun.
    pub sun: Sun,
    /// The sky's radiance.
    pub sky: Vec3,
}

/// A light over a scene.
pub(crate) struct SceneLight<'a> {
    mesh: &'a Mesh,
    bvh: &'a Bvh,
    light: SunAndSky,
    up: Vec3,
    shares: Shares,
}

impl<'a> SceneLight<'a> {
    /// A light over a mesh. The sky is the hemisphere about `up`.
    pub(crate) fn new(light: SunAndSky, mesh: &'a Mesh, bvh: &'a Bvh, up: [f64; 3]) -> Self {
        let up = DVec3::from(up).as_vec3().normalize_or_zero();
        let rays = if light.sky == Vec3::ZERO { 0 } else { SKY_RAYS };
        SceneLight { mesh, bvh, light, up, shares: Shares::new(mesh, rays) }
    }

    /// The light that reaches a triangle; zero for a triangle without area.
    pub(crate) fn local(&self, t: TriangleId) -> LocalLight {
        let Some(frame) = self.mesh.lobe_frame(t) else {
            return LocalLight { direction: Vec3::Z, sun: Vec3::ZERO, sky: Vec3::ZERO };
        };
        let SunAndSky { sun, sky } = self.light;
        LocalLight {
            direction: frame.to_local(sun.direction),
            sun: sun.color * self.shares.sun(self.mesh, self.bvh, sun.direction, t),
            sky: sky * self.shares.sky(self.mesh, self.bvh, self.up, t),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::read_text;

    #[test]
    fn a_known_sun_has_a_direction() {
        for (text, fields) in [
            ("", &[][..]),
            ("mode = 'known'", &["light.sun"]),
            ("mode = 'known'\nsun = [0, 0, 0]", &["light.sun"]),
            ("mode = 'known'\nsun = [inf, 0, 0]", &["light.sun"]),
            ("mode = 'known'\nsun = [0, 0, -2]", &[]),
            ("white = 2.5", &[]),
            ("white = 0", &["light.white"]),
            ("white = nan", &["light.white"]),
            ("mode = 'unknown'\nwhite = 1", &["light.white"]),
            ("mode = 'known'\nsun = [1, 1, 1]\ncolor = [-1, 0, 0]\nsky = [nan, 0, 0]", &["light.color", "light.sky"]),
        ] {
            let (_, problems) = read_text::<Config>(text);
            assert_eq!(problems.iter().map(|p| p.field.as_str()).collect::<Vec<_>>(), fields, "{text}");
        }
    }

    #[test]
    fn a_roof_shades_what_lies_under_it() {
        // A floor, a roof over it that the sun overhead does not pass, and a floor beside them.
        let corner = |z: f64, half: f64| [[-half, -half, z], [half, -half, z], [-half, half, z]].map(DVec3::from);
        let (floor, roof) = (corner(0.0, 1.0), corner(1.0, 1.5));
        let beside = floor.map(|p| p + DVec3::X * 9.0);
        let mesh = Mesh::new(&[floor, roof, beside].concat(), vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]]).unwrap();
        let bvh = Bvh::build(&mesh);
        let config = Config { mode: Mode::Known, sun: [0.0, 0.0, 3.0], color: [1.0; 3], sky: [0.5; 3], white: None };
        let light = SceneLight::new(config.known().unwrap(), &mesh, &bvh, [0.0, 0.0, 1.0]);
        let [under, roof, open] = [0, 1, 2].map(|t| light.local(TriangleId(t)));
        assert_eq!((under.sun, roof.sun, open.sun), (Vec3::ZERO, Vec3::ONE, Vec3::ONE));
        assert!(under.sky.x < 0.4 && roof.sky.x == 0.5 && open.sky.x > 0.45, "{under:?} {open:?}");
        assert!((open.direction - Vec3::Z).length() < 1e-6);
    }
}
