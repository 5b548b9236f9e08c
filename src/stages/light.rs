//! Section `[light]`: where the light that the photographs were taken in is known from.

use glam::DVec3;

use super::scene_light::SunAndSky;
use crate::config::{Choice, Effect, Key, Keys, Problem, Section, Settings, Value};
use crate::light::ephemeris::{elevation, in_mesh, sun_over};
use crate::scene::light::Sun;
use crate::scene::moment::Moment;

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
    /// Latitude, north positive, and longitude, east positive, degrees; `None` where the photographs are to tell.
    pub place: Option<[f64; 2]>,
    /// When the photographs were taken; `None` where they are to tell.
    pub time: Option<Moment>,
    /// The direction of north in the mesh's coordinates, of any length but 0.
    pub north: Option<[f64; 3]>,
}

/// Where the light is known from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Sun and sky are found in the photographs.
    Estimate,
    /// The sun is that of a place and a time; its ratio to the sky is found in the photographs.
    Ephemeris,
    /// Nowhere: the light is unknown: the estimator sees reflectance maps alone.
    Unknown,
    /// Sun and sky are given.
    Known,
}

impl Choice for Mode {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("estimate", Mode::Estimate),
        ("ephemeris", Mode::Ephemeris),
        ("known", Mode::Known),
        ("unknown", Mode::Unknown),
    ];
}

impl Section for Config {
    const NAME: &'static str = "light";
    const ABOUT: &'static str = "The light that the photographs were taken in.";
    const KEYS: &'static [Key] = &[
        Key {
            name: "mode",
            doc: "\"estimate\": sun and sky are found in the photographs, if they can be. \"ephemeris\": the sun is that of place \
                  and time, and the photographs tell the sky. \"known\": the photographs were taken in the sun and sky below. \
                  \"unknown\": materials come from the reflectance maps alone. Where there is a light, \
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
                  and \"ephemeris\" only. Photographs alone cannot tell a brighter sun from whiter walls; without this, a usual albedo does.",
            value: Value::Optional("1.0"),
        },
        Key {
            name: "place",
            doc: "Where the photographs were taken, [latitude, longitude] in degrees, north and east positive, with mode = \
                  \"ephemeris\" only. Without it, the median of what their EXIF says.",
            value: Value::Optional("[52.775, 16.637]"),
        },
        Key {
            name: "time",
            doc: "When the photographs were taken, with mode = \"ephemeris\" only; where it has no zone, the photographs decide \
                  for one. Without it, the median of what their EXIF says.",
            value: Value::Optional("\"2014-05-26T12:45:30+02:00\""),
        },
        Key {
            name: "north",
            doc: "The direction of north in the mesh's coordinates, with mode = \"ephemeris\" only. Without it, [scene] \
                  crs tells it, or it is y, as maps have it (UTM, ENU), where up is z.",
            value: Value::Optional("[0.0, 1.0, 0.0]"),
        },
    ];

    fn read(keys: &Keys<'_>) -> Self {
        let mode: Mode = keys.choice("mode");
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
            let idle = Problem::new("has no meaning unless mode = \"estimate\" or \"ephemeris\"");
            let hint = "take it out, or set mode = \"estimate\"";
            keys.check("white", mode.is_looked_for() || !keys.is_good("mode"), idle.hint(hint));
            keys.check("white", (1e-3..=1e3).contains(&white), "must be 0.001 to 1000");
        }
        let (place, time) = (keys.optional("place"), keys.optional("time"));
        let config = Config { mode, sun, color, sky, white, place, time, north: keys.optional("north") };
        config.check_ephemeris(keys);
        config
    }

    fn settings(&self) -> Settings {
        let Config { mode, sun, color, sky, white, place, time, north } = self;
        Settings::of(Self::NAME)
            .with("mode", mode.name(), Effect::Light)
            .with("mode", mode.name(), Effect::Look)
            .optional("white", *white, Effect::Look)
            .optional("place", *place, Effect::Look)
            .optional("time", time.map(|time| time.to_string()), Effect::Look)
            .optional("north", *north, Effect::Look)
            .with("sun", sun, Effect::Light)
            .with("color", color, Effect::Light)
            .with("sky", sky, Effect::Light)
    }
}

impl Mode {
    /// Whether the photographs are looked at for the light.
    pub fn is_looked_for(self) -> bool {
        matches!(self, Mode::Estimate | Mode::Ephemeris)
    }
}

/// How far up may lean from z in a mesh whose north is taken to be y, degrees: cameras tell up to a few.
const LEANS_DEGREES: f64 = 15.0;

impl Config {
    fn check_ephemeris(&self, keys: &Keys<'_>) {
        let Config { mode, place, time, north, .. } = self;
        for (key, is_given) in [("place", place.is_some()), ("time", time.is_some()), ("north", north.is_some())] {
            let idle = Problem::new("has no meaning unless mode = \"ephemeris\"");
            let hint = "take it out, or set mode = \"ephemeris\"";
            let is_meant = *mode == Mode::Ephemeris || !is_given || !keys.is_good("mode");
            keys.check(key, is_meant, idle.hint(hint));
        }
        if let Some([latitude, longitude]) = place {
            let is_place = (-90.0..=90.0).contains(latitude) && (-180.0..=180.0).contains(longitude);
            let rule = "must be [latitude, longitude] in degrees, -90 to 90 and -180 to 180";
            keys.check("place", is_place, rule);
        }
        if let Some(north) = north {
            let length = DVec3::from(*north).length_squared();
            let rule = "must be a finite vector that is not zero, as [0, 1, 0]";
            keys.check("north", length.is_finite() && length > 0.0, rule);
        }
        if let (Some(place), Some(utc)) = (place, time.and_then(Moment::utc))
            && ["place", "time", "mode"].iter().all(|key| keys.is_good(key))
        {
            let elevation = elevation(sun_over(*place, utc));
            let words =
                format!("must be by day: the sun stood {:.0} degrees below the horizon there and then", -elevation);
            let hint = "check the zone, and that place is [latitude, longitude]";
            keys.check("time", elevation > 0.0, Problem::new(words).hint(hint));
        }
    }

    /// The direction of north in a mesh with this way up, where it is given or taken to be y.
    ///
    /// # Errors
    /// North cannot be told.
    pub fn north(&self, up: [f64; 3]) -> Result<DVec3, Problem> {
        let up = DVec3::from(up);
        let Some(north) = self.north.map(DVec3::from) else {
            let usual = up.angle_between(DVec3::Z).to_degrees() <= LEANS_DEGREES;
            let unusual = || {
                let [x, y, z] = up.normalize_or_zero().to_array();
                Problem::new(format!("is needed, since up is [{x:.2}, {y:.2}, {z:.2}] and not z"))
                    .hint("give the direction of north in the mesh's coordinates, or set mode = \"estimate\"")
            };
            return usual.then_some(DVec3::Y).ok_or_else(unusual);
        };
        let level = in_mesh(DVec3::Y, north, up).is_some();
        level.then_some(north).ok_or_else(|| Problem::new("must not point up or down").got(format!("{:?}", self.north)))
    }

    /// The light, where the configuration gives it.
    pub fn known(&self) -> Option<SunAndSky> {
        let vector = |v: [f64; 3]| DVec3::from(v).as_vec3();
        let sun = Sun { direction: vector(self.sun).normalize_or_zero(), color: vector(self.color) };
        (self.mode == Mode::Known).then(|| SunAndSky::new(sun, vector(self.sky)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{defaults, read_text};

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
    fn a_place_and_a_time_are_checked() {
        let day = "mode = 'ephemeris'\nplace = [52.775, 16.637]\n";
        for (text, fields) in [
            ("mode = 'ephemeris'", &[][..]),
            (&format!("{day}time = 2012-08-19T12:45:30+02:00\nwhite = 2\nnorth = [0, 1, 0]"), &[]),
            (&format!("{day}time = '2012-08-19T12:45:30'"), &[]),
            (&format!("{day}time = '2012-08-19T00:45:30+02:00'"), &["light.time"]),
            (&format!("{day}time = 12"), &["light.time"]),
            (&format!("{day}time = 2012-08-19"), &["light.time"]),
            (
                "mode = 'ephemeris'\nplace = [91, 0]\nnorth = [0, 0, 0]\ntime = 'noon'",
                &["light.north", "light.place", "light.time"],
            ),
            ("mode = 'ephemeris'\nplace = [nan, 0]", &["light.place"]),
            (
                "place = [52, 16]\nnorth = [0, 1, 0]\ntime = '2012-08-19T12:45:30'",
                &["light.north", "light.place", "light.time"],
            ),
        ] {
            let (_, problems) = read_text::<Config>(text);
            let mut found: Vec<_> = problems.iter().map(|p| p.field.as_str()).collect();
            found.sort_unstable();
            assert_eq!(found, fields, "{text}: {problems:?}");
        }
        let (_, problems) = read_text::<Config>(&format!("{day}time = '2012-08-19T00:45:30+02:00'"));
        assert!(problems[0].rule.contains("the sun stood 24 degrees below the horizon"), "{problems:?}");
    }

    #[test]
    fn north_is_y_where_up_is_z_and_must_be_given_elsewhere() {
        let north = |north, up| Config { north, ..defaults() }.north(up).map_err(|problem| problem.rule);
        assert_eq!(north(None, [0.0, 0.0, 2.0]), Ok(DVec3::Y));
        assert_eq!(north(None, [0.1, -0.1, 1.0]), Ok(DVec3::Y));
        assert!(north(None, [0.0, -1.0, 0.0]).is_err_and(|rule| rule.contains("[0.00, -1.00, 0.00]")));
        assert_eq!(north(Some([1.0, 0.0, 0.0]), [0.0, -1.0, 0.0]), Ok(DVec3::X));
        assert!(north(Some([0.0, 3.0, 0.0]), [0.0, -1.0, 0.0]).is_err_and(|rule| rule.contains("up or down")));
    }
}
